"""Calls that fail once or for ever, disks that are full, folders that go away: the right result with status 0; or status
4 with a message that names a file, nothing false at the result's name, and the right result when the command is given
again. No third."""
import dataclasses
import errno
import os
import shutil
import subprocess

from . import folders, inject, kill, runs
from .inject import Fault
from .trial import Row

# Errors with which each kind of call can fail. EINTR and a short count are no failures: a program goes on.
ERRORS = {
    "open": "EIO EMFILE EACCES ESTALE ENOSPC EINTR", "read": "EIO ESTALE EINTR short",
    "pread": "EIO ESTALE EINTR short", "write": "ENOSPC EIO EDQUOT EINTR short",
    "pwrite": "ENOSPC EIO EDQUOT EINTR short", "fsync": "EIO ENOSPC EINTR", "truncate": "EIO ENOSPC EINTR",
    "allocate": "ENOSPC EIO EOPNOTSUPP EINTR", "rename": "EIO ENOSPC EACCES ESTALE", "link": "EIO ENOSPC EACCES ESTALE",
    "unlink": "EIO EACCES ESTALE", "stat": "EIO EACCES ESTALE", "close": "EIO ENOSPC EINTR",
    "mkdir": "EIO ENOSPC EACCES", "rmdir": "EIO EACCES", "readdir": "EIO ESTALE", "lock": "EIO ENOLCK EINTR",
    "mmap": "ENOMEM"}
HARMLESS = ("EINTR", "short")


def judge(run, place, end, what="", lost=False):
    """Nothing, or how the end of a run breaks the rule; `what`: name of the errno, or short; lost: see repair."""
    if end.status < 0:
        return f"ends by signal {-end.status}"
    if end.status == 0:
        said = run.wrong(place, left_over=bool(end.err.strip()))
        return f"FALSE: status 0, and {said}" if said else run.repair(place)
    if what in HARMLESS:
        return f"{what} ends it with {end.status}: {runs.first_line(end.err)}"
    # 2 is a mistake of the user, unless the system's own words stand there
    number = getattr(errno, what, None)
    honest = number is not None and os.strerror(number) in end.err
    if end.status != 4 and not (end.status == 2 and honest):
        return f"ends with {end.status}: {runs.first_line(end.err)}"
    if not runs.FILE.search(end.err):
        return f"status {end.status} names no file: {runs.first_line(end.err)}"
    said = run.false(place)
    return f"FALSE: status {end.status}, and {said}" if said else run.repair(place, lost=lost)


def trial(run, shim, template, fault):
    place = run.folder(template)
    end = run.call(place, fault.environment(shim, place))
    # an interrupted call of the HDF5 library may be the end of a run, as long as it is an honest one
    what = "" if fault.origin == "library" else fault.do
    said = judge(run, place, end, what)
    shutil.rmtree(place)
    return said and f"{fault}: {said}"


def faults_of(kind, n, most):
    """Every errno at each of up to `most` calls, once and for ever."""
    found = []
    words = ERRORS[kind].split()
    for k, when in enumerate(runs.spread(n, most)):
        # with few trials the errors take turns
        for word in words if most >= n else [words[(k + j) % len(words)] for j in range(2)]:
            if word == "EINTR":
                found += [Fault(kind, when, word, origin=origin) for origin in ("program", "library")]
            else:
                found += [Fault(kind, when, word, times) for times in (1, 0)]
    return found


def _injected(setup, run, shim, cases):
    rows = []
    for name, template in cases:
        made = kill.logged(run, shim, ",".join(ERRORS), template)
        for kind in ERRORS:
            n = sum(k == kind for k, _ in made)
            if n == 0:
                continue
            most = setup.pick(5 if kind in ("pread", "readdir", "close") else 10, 10**6)
            rows.append(runs.together(setup, f"{run.name}, {name}: {kind}", faults_of(kind, n, most),
                                      lambda fault, t=template: trial(run, shim, t, fault), f"of {n} calls"))
    return rows


# --- a full disk --------------------------------------------------------------------------------------------

def _written(run, shim):
    """Bytes that a run writes, found by halving: so many do."""
    low, high = 0, 1 << 26
    while high - low > 4096:
        middle = (low + high) // 2
        place = run.folder()
        end = run.call(place, Fault(room=middle).environment(shim, place))
        low, high = (low, middle) if end.status == 0 else (middle, high)
        shutil.rmtree(place)
    return high


def _budgets(setup, run, shim, cases):
    need = _written(run, shim)
    sizes = [k * need // setup.pick(12, 400) for k in range(setup.pick(12, 400))]
    return [runs.together(setup, f"{run.name}, {name}: full after N bytes", sizes,
                          lambda room, t=template: trial(run, shim, t, Fault(room=room, do="ENOSPC")),
                          f"N up to {need}") for name, template in cases]


def _limits(setup, run):
    """ulimit -f: no file may become longer; the kernel sends SIGXFSZ and says EFBIG."""
    largest = max(len(b"".join(c.values())) for c in run.right.values()) * 2

    def one(size):
        place = run.folder()
        limited = dataclasses.replace(run, also=["prlimit", f"--fsize={size}"])
        said = judge(run, place, limited.call(place), "EFBIG")
        shutil.rmtree(place)
        return said and f"prlimit --fsize={size}: {said}"

    n = setup.pick(8, 100)
    return runs.together(setup, f"{run.name}: no file beyond N bytes", [k * largest // n for k in range(n)], one)


def _mounted(setup, run, home):
    """A small file system in memory; afterwards it is made large."""
    what = f"{run.name}: full file system of N bytes"
    probe = home / "probe"
    probe.mkdir()
    if os.geteuid() != 0 or subprocess.run(["mount", "-t", "tmpfs", "-o", "size=64k", "tmpfs", probe],
                                           capture_output=True).returncode:
        return Row(what, 0, 0, "left out: mounting is not allowed here")
    subprocess.run(["umount", probe], check=True)

    def one(size):
        mount = home / f"disk-{size}"
        mount.mkdir()
        subprocess.run(["mount", "-t", "tmpfs", "-o", f"size={size}", "tmpfs", mount], check=True)
        try:
            here = dataclasses.replace(run, home=mount)
            place = here.folder()
            end = here.call(place)
            subprocess.run(["mount", "-o", "remount,size=64m", mount], check=True)
            said = judge(here, place, end, "ENOSPC")
        finally:
            subprocess.run(["umount", mount], check=True)
        return said and f"tmpfs of {size} bytes: {said}"

    n = setup.pick(10, 200)
    # the deck needs two pages
    return runs.together(setup, what, [16384 + 4096 * (k * 256 // n) for k in range(n)], one)


def run(setup):
    home = runs.scratch(setup)
    try:
        shim = inject.library(home)
        short = runs.three(setup, home).prepare()
        rows = folders.rows(setup, home, short)
        if not shim:
            return rows + [Row("calls that fail", 0, 0, "left out: no compiler")]
        cases = kill.stages(short, shim)
        rows += _injected(setup, short, shim, cases)
        rows += _budgets(setup, short, shim, cases[:setup.pick(1, 3)])
        return rows + [_limits(setup, short), _mounted(setup, short, home)]
    finally:
        shutil.rmtree(home, ignore_errors=True)
