"""Power cuts: a run on an ext4 file system in a file, which loses all at once what has not been synchronised; then it is
mounted again and the same command is given. Data may come to the disk later than names do (data=writeback), so that what
is renamed without being synchronised is lost. Needs root and loop devices."""
import contextlib
import dataclasses
import fcntl
import os
import shutil
import signal
import subprocess

from . import inject, kill, runs
from .inject import Fault
from .trial import Row

# EXT4_IOC_SHUTDOWN with EXT4_GOING_FLAGS_NOLOGFLUSH: from now on nothing reaches the disk, not even the journal
SHUTDOWN, NO_LOG_FLUSH = 0x8004587D, 2
OPTIONS = "loop,data=writeback,noauto_da_alloc,commit=600"


class Disk:
    """A file system of its own, in a file."""

    def __init__(self, home, number, megabytes=24):
        self.image, self.place = home / f"disk-{number}.img", home / f"disk-{number}"
        self.place.mkdir()
        with open(self.image, "wb") as file:
            file.truncate(megabytes << 20)
        subprocess.run(["mkfs.ext4", "-q", "-F", "-E", "nodiscard", self.image], check=True, capture_output=True)

    def mount(self):
        subprocess.run(["mount", "-o", OPTIONS, self.image, self.place], check=True, capture_output=True)

    def cut(self):
        """The power goes."""
        fd = os.open(self.place, os.O_RDONLY)
        try:
            fcntl.ioctl(fd, SHUTDOWN, NO_LOG_FLUSH.to_bytes(4, "little"))
        finally:
            os.close(fd)

    def unmount(self):
        subprocess.run(["umount", self.place], check=True, capture_output=True)

    def drop(self):
        with contextlib.suppress(subprocess.CalledProcessError):
            self.unmount()
        self.image.unlink()


def _is_possible(home):
    if os.geteuid() != 0 or not shutil.which("mkfs.ext4"):
        return False
    try:
        disk = Disk(home, "probe")
        disk.mount()
        (disk.place / "lost").write_text("x")
        disk.cut()
        disk.unmount()
        disk.mount()
        lost = not (disk.place / "lost").exists()
        disk.drop()
        return lost
    except (OSError, subprocess.CalledProcessError):
        return False


def _begin(run, disk):
    """The run's folder on the disk; it has been there for long."""
    disk.mount()
    here = dataclasses.replace(run, home=disk.place)
    place = here.folder()
    os.sync()
    return here, place


def _after(here, disk, process):
    """Cuts the power, waits for what the run says of it, mounts the disk again."""
    disk.cut()
    try:
        process.communicate(timeout=runs.SECONDS)
    except subprocess.TimeoutExpired:
        process.kill()
        process.communicate()
        return "hangs after the cut"
    disk.unmount()
    disk.mount()
    return ""


def _at_random(setup, run, home, number):
    """Cuts until the run gets through; (cuts, what is wrong)."""
    chance = setup.random("power", run.name, number)
    disk, cuts = Disk(home, f"{run.name}-{number}".replace(" ", "-")), 0
    try:
        here, place = _begin(run, disk)
        while True:
            process = here.start(place)
            with contextlib.suppress(subprocess.TimeoutExpired):
                process.wait(timeout=chance.uniform(0.005, 1.2 * run.seconds) * (1 + cuts / 10))
            ended = process.poll()
            said = _after(here, disk, process)
            cuts += 1
            if ended == 0:
                # status 0 says that it is on the disk; the folder of parts may come back, and goes the next time
                said = said or here.wrong(place, left_over=True) or here.repair(place)
            elif ended is not None:
                said = f"ends with {ended} before the cut"
            said = said or here.false(place)
            if said or ended == 0:
                return cuts, said and f"seed {setup.seed}, trial {number}, cut {cuts}: {said}"
    finally:
        disk.drop()


def _random_cuts(setup, run, home, quota):
    cuts, number, said = 0, 0, []
    while cuts < quota:
        number += 1
        more, wrong = _at_random(setup, run, home, number)
        cuts += more
        if wrong:
            said.append(wrong)
            setup.say(f"  failed: {run.name}: {wrong}", flush=True)
    return Row(f"{run.name}, cut at random moments", cuts, len(said), said[0] if said else f"{number} runs")


def _at_call(run, home, shim, when):
    """The power goes together with the process, at that call."""
    disk = Disk(home, f"call-{when}")
    try:
        here, place = _begin(run, disk)
        fault = Fault("writing", when, "kill")
        end = here.call(place, fault.environment(shim, place))
        disk.cut()
        disk.unmount()
        disk.mount()
        if end.status == 0:
            said = here.wrong(place, left_over=True) or here.repair(place)
        elif end.status == -signal.SIGKILL:
            said = here.false(place) or here.repair(place)
        else:
            said = f"ends with {end.status}: {runs.first_line(end.err)}"
        return said and f"{fault}, then a cut: {said}"
    finally:
        disk.drop()


def run(setup):
    home = runs.scratch(setup)
    try:
        if not _is_possible(home):
            # nothing was tried, and that is said; it is no failure of slipdisk
            return [Row("power cuts", 0, 0, "left out: needs root, loop devices and ext4")]
        quota = setup.pick(8, 150)
        longer = runs.three(setup, home, steps=600000, checkpoint=0.02, series=10000).prepare()
        rows = [_random_cuts(setup, longer, home, quota),
                _random_cuts(setup, runs.deposit(setup, home).prepare(), home, quota)]
        shim = inject.library(home)
        if shim:
            short = runs.three(setup, home).prepare()
            n = len(kill.logged(short, shim))
            rows.append(runs.together(setup, f"{short.name}, cut at system calls", runs.spread(n, setup.pick(25, 500)),
                                      lambda when: _at_call(short, home, shim, when), f"of {n} calls"))
        return rows
    finally:
        shutil.rmtree(home, ignore_errors=True)
