"""What the tests of results share: running the program, and comparing two results."""
import os
import pathlib
import shutil
import subprocess
import tempfile
import time

import h5py
import numpy

ROOT = pathlib.Path(os.environ.get("SLIPDISK_SOURCE_DIR", pathlib.Path(__file__).resolve().parent.parent))
PROGRAM = os.environ.get("SLIPDISK_PROGRAM", str(ROOT / "build/release/slipdisk"))
DECK = ROOT / "inputs/three_disk/random.cfg"
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
    out, err = process.communicate(timeout=500)
    return process.returncode, out, err


def steps_for(seconds):
    """Steps that take about this long with this build (sanitizers are slow), a multiple of 100000."""
    steps, took, folder = 50000, 0, tempfile.mkdtemp(prefix="slipdisk-speed-")
    while took < 0.3:  # shorter ones are mostly the start and the end
        steps *= 4
        begin = time.monotonic()
        status, _, err = run("run", *deck_arguments(measure=steps), "--quiet", "--force", "-o",
                             os.path.join(folder, "speed.h5"))
        took = time.monotonic() - begin
        assert status == 0, err
    shutil.rmtree(folder)
    return max(2, round(steps / took * seconds / 100000)) * 100000


def wait_for(condition, seconds=60):
    end = time.monotonic() + seconds
    while not condition():
        if time.monotonic() > end:
            raise AssertionError("waited in vain")
        time.sleep(0.002)


def datasets(file):
    """path -> array, of everything that must not depend on how often a run was interrupted"""
    found = {}

    def visit(path, item):
        if isinstance(item, h5py.Dataset):
            found[path] = item[()]

    file.visititems(visit)
    return found


def assert_same(test, a, b):
    """Two finished results are the same in every bit, but for the description of the run."""
    with h5py.File(a) as one, h5py.File(b) as two:
        test.assertEqual(one["state"].attrs["hash"], two["state"].attrs["hash"])
        x, y = datasets(one), datasets(two)
        test.assertEqual(sorted(x), sorted(y))
        for path in x:
            if path == "parameters/deck_overrides" or path == "parameters/deck_full":
                continue
            test.assertEqual(numpy.asarray(x[path]).tobytes(), numpy.asarray(y[path]).tobytes(), path)
