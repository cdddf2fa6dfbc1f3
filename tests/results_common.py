"""What the tests of results share: running the program, killing it, and comparing two results."""
import contextlib
import functools
import os
import pathlib
import random
import resource
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import unittest

import h5py

ROOT = pathlib.Path(os.environ.get("SLIPDISK_SOURCE_DIR", pathlib.Path(__file__).resolve().parent.parent))
sys.path.insert(0, str(ROOT / "tools"))

from soak import results  # noqa: E402  what the trials of tools/soak.sh compare by
from soak.inject import Fault  # noqa: E402
PROGRAM = os.environ.get("SLIPDISK_PROGRAM", str(ROOT / "build/release/slipdisk"))
DECK = ROOT / "inputs/three_disk/random.cfg"
CALLS = pathlib.Path(os.environ.get("SLIPDISK_BUILD_DIR", ROOT / "build/release")) / "tests/calls.so"
BRIEF = os.environ.get("SLIPDISK_BRIEF") == "1"  # steps are slow, as under sanitizers: see brief.h
LONG = 600  # seconds after which what a test waits for will not come, however busy the machine
# Checkpoints cost more than the steps between them; who is not to be interrupted writes none.
SELDOM = "-D", "checkpoint=60"
SETTLE, MEASURE = 20000, 300000
SERIES, FRAMES, CONTACTS = 1000, 700, 30000


def deck_arguments(settle=SETTLE, measure=MEASURE, checkpoint=60, frames=FRAMES, series=SERIES):
    overrides = {"phases.settle.steps": settle, "phases.measure.steps": measure, "checkpoint": float(checkpoint),
                 "phases.settle.series": 1000, "phases.measure.series": series, "phases.measure.frames": frames,
                 "phases.measure.contacts": CONTACTS}
    words = [str(DECK)]
    for key, value in overrides.items():
        words += ["-D", f"{key}={value}"]
    return words


def start(*words, **more):
    return subprocess.Popen([PROGRAM, *map(str, words)], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
                            **more)


def run(*words, **more):
    """(exit status, standard output, standard error)"""
    process = start(*words, **more)
    out, err = process.communicate(timeout=LONG)
    return process.returncode, out, err


def brief(full, less):
    """What is repeated to try many moments, as BRIEF does in C."""
    return less if BRIEF else full


def cost_of(folder, steps):
    """Seconds of processor time of a run."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    status, _, err = run("run", *deck_arguments(measure=steps), "--quiet", "--force", "-o", os.path.join(folder, "speed.h5"))
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    assert status == 0, err
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


@functools.cache
def speed():
    """Steps a second of processor time: beside other work, steps counted by the clock would be over too soon. Start and end of
    the process, a good part under sanitizers, do not count."""
    steps, took = 50000, 0
    with tempfile.TemporaryDirectory(prefix="slipdisk-speed-") as folder:
        ends = min(cost_of(folder, 1000) for _ in range(3))
        while took < 0.3:
            steps *= 4
            took = cost_of(folder, steps) - ends
    return steps / took


def steps_for(seconds):
    """Steps that take about this long with this build (sanitizers are slow), a multiple of 100000."""
    return max(2, round(speed() * seconds / 100000)) * 100000


class Gate:
    """Runs below a folder wait where a test wants them, so that no other work on the machine lets them end before.

    With this environment each process waits once, when a point of its has written a checkpoint of its own beyond its first
    step: before the part of the series that follows. It goes on when the gate is opened, or after a signal that it
    handles."""

    def __init__(self, test, below, when=0):
        """when: not there, but before the when-th part that the process writes of whatever point."""
        self.file = tempfile.NamedTemporaryFile(prefix="slipdisk-gate-")
        test.addCleanup(self.file.close)
        last = {}
        for path in pathlib.Path(below).rglob("part-*.h5"):
            last[path.parent.name] = max(last.get(path.parent.name, 0), int(path.stem.split("-")[1]))
        part = "|".join([f"{folder}/part-{n + 2:06d}.h5" for folder, n in last.items()] + ["part-000003.h5"])
        fault = Fault(call="rename", name="*/part-*.h5" if when else f"*/@({part})", when=when or 1, do="wait",
                      gate=self.file.name)
        self.environment = fault.environment(CALLS, below)

    def wait(self, process, count=1):
        """Until so many processes wait, none of which can have ended."""
        wait_for(lambda: process.poll() is not None or pathlib.Path(self.file.name).stat().st_size >= count)
        assert process.poll() is None, "it was over before it could be interrupted"

    def open(self):
        self.file.close()


@contextlib.contextmanager
def changed(path):
    """An h5py file to be changed on purpose; its checksum is made anew."""
    with h5py.File(path, "r+") as file:
        yield file
    status, _, err = run("verify", "--seal", "--quiet", path)
    assert status == 0, err


def wait_for(condition, seconds=LONG):
    end = time.monotonic() + seconds
    while not condition():
        if time.monotonic() > end:
            raise AssertionError("waited in vain")
        time.sleep(0.002)


def assert_same(test, a, b):
    """Two finished results are the same in every bit, but for the description of the run."""
    described = "parameters@", "parameters/deck_overrides", "parameters/deck_full"
    test.assertEqual(results.differences(results.content(a), results.content(b), described), [])


class Folder(unittest.TestCase):
    """A folder for one test, with a result r.h5 to be made in it."""

    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="slipdisk-test-"))
        self.result = self.folder / "r.h5"
        self.parts = self.folder / "r.h5.parts"

    def tearDown(self):
        shutil.rmtree(self.folder, ignore_errors=True)

    def run_ok(self, *words):
        status, out, err = run(*words)
        self.assertEqual(status, 0, err)
        return out, err

    def started(self, *words, command="run"):
        """A run that has written a checkpoint of its own beyond step 0, and waits for a signal or for self.gate.open()."""
        self.gate = Gate(self, self.folder)
        process = start(command, *words, "-o", self.result, env=self.gate.environment)
        self.gate.wait(process)
        return process

    def checkpoints(self):
        """Their steps, the newest first."""
        found = [int(p.stem.split("-")[1]) for p in self.parts.glob("checkpoint-*.h5")]
        return sorted(found, reverse=True)

    def kill_until_done(self, words, longest, seed):
        """Runs the command and kills it, again and again; how often."""
        chance = random.Random(seed)
        kills = 0
        while True:
            process = start("run", *words, "-o", self.result)
            try:
                # the delay grows, so that there is an end
                _, err = process.communicate(timeout=chance.uniform(0.01, longest) * (1 + kills / 20))
                self.assertEqual(process.returncode, 0, err)
                return kills
            except subprocess.TimeoutExpired:
                process.send_signal(signal.SIGKILL)
                process.communicate()
                kills += 1
                # the kill came after the end
                if self.result.exists() and not self.parts.exists():
                    return kills

    def kill_while_merging(self, words, times):
        """Lets the command run to its merge and kills it there; how many merges were cut short."""
        def merging():
            return any(self.parts.glob("result.h5.*.tmp"))

        chance = random.Random(1)
        cut = 0
        for _ in range(times):
            process = start("run", *words, "-o", self.result)
            wait_for(lambda p=process: merging() or p.poll() is not None)
            time.sleep(chance.uniform(0, 0.1))
            process.send_signal(signal.SIGKILL)
            process.communicate()
            cut += merging()
            if self.result.exists():
                break
        return cut
