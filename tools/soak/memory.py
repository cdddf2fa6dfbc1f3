"""Allocations that fail, the n-th or all from the n-th on (tests/inject/memory.c): what comes out is the right result, or
a message with status 4 (2, 3 where they are true, too) and what was saved continues to the right result.

Libraries that do not look at what malloc returns (libconfig, parts of GSL and HDF5) crash: that is no failure here as long as no
false result is left and the run continues to the right one. How often it happens stands in the note."""
import concurrent.futures
import dataclasses
import os
import pathlib
import re
import shutil
import signal
import subprocess
import time

import h5py
import numpy

from .trial import ROOT, Row

THREE = ROOT / "inputs" / "three_disk"
STEPS = ["-D", "phases.settle.steps=200", "-D", "phases.measure.steps=20000", "-D", "phases.measure.series=500"]
MEANS = """
integrator = "verlet"; dt = 0.001; seed = 3; gravity = { g = 1; };
materials = ( { name = "a"; k_n = 1e3; k_t = 500; gamma_n = 2; mu = 0.5; } );
container = { type = "box"; width = 8; height = 10; };
packings = ( { type = "random"; count = 12; density = 1; sizes = "mono"; radius = 0.5; } );
phases = ( { name = "fall"; steps = 300; }, { name = "rest"; steps = 2000; measure = true; } );
measure = { disks = true; rotation = (); };
output = { series = 500; frames = 1000; contacts = 1000; };
"""
# Speeds, times and places differ from run to run.
VOLATILE = re.compile(rb"speed |run time|steps per second|wall|ns per step|step_nanosec|started|ended|directory|MB\)")


@dataclasses.dataclass
class Case:
    name: str
    words: list            # DIR stands for the folder of the trial
    made: str = ""         # the file that is compared; "": what is printed
    begun: str = ""        # a folder that is copied first
    again: list = None     # continues what has failed


@dataclasses.dataclass
class End:
    status: int
    out: bytes
    err: bytes


def content(path):
    """name -> bytes, of all that says nothing about how the run went"""
    found = {}
    with h5py.File(path) as file:
        def visit(name, item):
            if name.startswith("parameters") and not name.startswith("parameters/model"):
                return
            if isinstance(item, h5py.Dataset):
                found[name] = numpy.asarray(item[()]).tobytes()
            for key, value in item.attrs.items():
                if key not in ("step_nanoseconds", "ns_per_step"):
                    found[f"{name}@{key}"] = numpy.asarray(value).tobytes()

        file.visititems(visit)
    return found


def printed(text):
    return b"\n".join(line for line in text.split(b"\n") if not VOLATILE.search(line))


class Trials:
    def __init__(self, setup):
        self.setup = setup
        self.shim = setup.build / "tests" / "libinject_memory.so"
        if not self.shim.exists():
            raise SystemExit(f"{self.shim} is missing: build all of the preset")

    def call(self, words, folder, **fail):
        log = folder / "log"
        names = {"at": "SLIPDISK_FAIL_ALLOCATION", "on": "SLIPDISK_FAIL_ALLOCATIONS_ON", "own": "SLIPDISK_FAIL_OWN"}
        env = dict(os.environ)
        if fail:
            env |= {"LD_PRELOAD": str(self.shim), "SLIPDISK_ALLOCATION_LOG": str(log)}
            env |= {names[key]: str(int(value)) for key, value in fail.items() if value}
        words = [str(word).replace("DIR", str(folder)) for word in words]
        try:
            ran = subprocess.run([self.setup.program, *words], env=env, cwd=folder, capture_output=True, timeout=120)
        except subprocess.TimeoutExpired:
            return End(124, b"", b"")
        return End(ran.returncode, ran.stdout, ran.stderr)

    def folder(self, case, name):
        folder = self.setup.work / name
        folder.mkdir()
        (folder / "means.cfg").write_text(MEANS)
        if case.begun:
            shutil.copytree(case.begun, folder, dirs_exist_ok=True)
        return folder

    def outcome(self, case, folder, end):
        """What was found: bytes, or None when there is nothing."""
        if case.made:
            path = folder / case.made
            return content(path) if path.exists() else None
        return printed(end.out)

    def reference(self, case, own):
        folder = self.folder(case, f"{case.name}-reference-{own}".replace(" ", "-"))
        end = self.call(case.words, folder, at=0, own=own)
        if end.status != 0:
            raise RuntimeError(f"{case.name}: {end.err.decode()}")
        count = int((folder / "log").read_text())
        right = self.outcome(case, folder, end)
        shutil.rmtree(folder)
        return count, right

    def judge(self, case, folder, end, right):
        """"" or what is wrong."""
        if end.status == 0:
            return "" if self.outcome(case, folder, end) == right else "status 0 with another result"
        if end.status > 0 and not end.err.strip():
            return f"status {end.status} in silence"
        if end.status > 4:
            return f"status {end.status}"
        if not case.made:
            return ""
        if (folder / case.made).exists() and self.outcome(case, folder, end) != right:
            return f"status {end.status} and a false result"
        later = self.call(case.again, folder)
        if later.status != 0 and b"finished already" not in later.err:
            return f"does not continue: {later.err.decode()[:200]}"
        return "" if self.outcome(case, folder, end) == right else "continues to another result"

    def one(self, case, right, at, on, own):
        folder = self.folder(case, f"{case.name}-{at}-{on}-{own}".replace(" ", "-"))
        end = self.call(case.words, folder, at=at, on=on, own=own)
        try:
            wrong = self.judge(case, folder, end, right)
            if own and end.status < 0 and not wrong:
                wrong = f"crashes with signal {-end.status}"
        except OSError as reason:
            wrong = f"cannot be read: {reason}"
        shutil.rmtree(folder, ignore_errors=True)
        return wrong and f"n = {at}{' and on' * on}{', own' * own}: {wrong}", end.status < 0

    def row(self, case, own, most):
        count, right = self.reference(case, own)
        every = sorted(self.setup.random(case.name, own).sample(range(1, count + 1), min(count, most)))
        tasks = [(case, right, at, on, own) for at in every for on in (False, True)]
        with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
            found = list(pool.map(lambda task: self.one(*task), tasks))
        wrong = [what for what, _ in found if what]
        crashes = sum(crash for _, crash in found)
        whose = "of the program" if own else "of all libraries"
        note = f"of {count} allocations" if own else f"of {count} allocations; {crashes} crashes in libraries"
        note = wrong[0] if wrong else note
        return Row(f"{case.name}: allocations {whose}", len(found), len(wrong), note)


def begin(trials, folder):
    """An unfinished run with two checkpoints."""
    deck = THREE / "random.cfg"
    words = ["run", deck, *STEPS, "-D", "checkpoint=0.02", "--threads", "1", "-o", folder / "r.h5", "--quiet"]
    for steps in (300000, 1000000, 3000000, 10000000):
        words[words.index("phases.measure.steps=20000") if steps == 300000 else 5] = f"phases.measure.steps={steps}"
        folder.mkdir()
        process = subprocess.Popen([trials.setup.program, *map(str, words)], stderr=subprocess.PIPE)
        while process.poll() is None and len(list(folder.glob("r.h5.parts/checkpoint-*.h5"))) < 2:
            time.sleep(0.001)
        process.send_signal(signal.SIGTERM)
        process.communicate()
        if process.returncode == 75:
            return
        shutil.rmtree(folder)
    raise RuntimeError("no run is long enough to be stopped")


def cases(trials):
    made = trials.setup.work / "made"
    begin(trials, trials.setup.work / "begun")
    made.mkdir()
    (made / "means.cfg").write_text(MEANS)
    for words in (["run", THREE / "random.cfg", *STEPS, "-o", "DIR/three.h5", "--quiet"],
                  ["run", "DIR/means.cfg", "-o", "DIR/means.h5", "--quiet"]):
        end = trials.call(words, made)
        if end.status != 0:
            raise RuntimeError(end.err.decode())
    run = ["run", THREE / "random.cfg", *STEPS, "--threads", "1", "-o", "DIR/r.h5", "--quiet"]
    means = ["run", "DIR/means.cfg", "--threads", "1", "-o", "DIR/r.h5", "--quiet"]
    point = ["sweep", ROOT / "inputs" / "paper" / "random.cfg", "-D", "phases.settle.steps=200",
             "-D", "phases.measure.steps=5000", "--point", "3", "-o", "DIR/s", "--quiet"]
    resume = ["resume", "DIR/r.h5", "--threads", "1", "--quiet"]
    return [Case("run", run, "r.h5", again=run), Case("run with means", means, "r.h5", again=means),
            Case("resume", resume, "r.h5", trials.setup.work / "begun", resume),
            Case("sweep", point, point_file(trials, point), again=point),
            Case("info", ["info", made / "means.h5"]), Case("info json", ["info", made / "three.h5", "--json"]),
            Case("measure", ["measure", made / "means.h5", "--all", "--json"]),
            Case("check", ["check", THREE / "random.cfg"]), Case("theory", ["theory", THREE / "steady.cfg"])]


def point_file(trials, words):
    """Where the point's result stands."""
    folder = trials.setup.work / "point"
    folder.mkdir()
    end = trials.call(words, folder)
    found = [path for path in folder.rglob("*.h5")]
    if end.status != 0 or len(found) != 1:
        raise RuntimeError(f"sweep: {end.err.decode()} {found}")
    return str(found[0].relative_to(folder))


def run(setup, own=None, most=None):
    trials = Trials(setup)
    rows = []
    for case in cases(trials):
        rows.append(trials.row(case, True, own or setup.pick(15, 10**9)))
        rows.append(trials.row(case, False, most or setup.pick(10, 10**9)))
    return rows
