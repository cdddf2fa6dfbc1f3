"""What the tests of sweeps share: decks with sweeps, and what is in their folders."""
import csv
import os
import pathlib
import shutil
import subprocess
import tempfile
import unittest

import h5py
import numpy

from results_common import Gate, LONG, SELDOM, assert_same, run, start

THREE = """
dt = 1e-6;
gravity = { g = 10; tilt = "0.04 pi"; };
materials = ( { name = "disk"; k_n = 1e3; k_t = 1e6; gamma_n = 10; mu = 0.1; } );
disks = (
  { name = "upper"; x = 0;  y = 0;                   radius = 1; mass = 0.1; },
  { name = "left";  x = -1; y = -1.7320508075688772; radius = 1; mass = 0.1; fixed = true; },
  { name = "right"; x = 1;  y = -1.7320508075688772; radius = 1; mass = 0.1; fixed = true; }
);
motions = (
  { name = "shake"; disk = ["left", "right"]; coordinate = ["x", "y", "theta"]; type = "random";
    amplitude = 1e-4; omega = "20 pi"; damping = 0.5; ramp = 0.2; }
);
measure = { rotation = ["upper"]; sliding = ( { disk = "upper"; partners = ["left", "right"]; } );
            configurations = true; };
"""
def three_disks(sweep, steps=20000, checkpoint=60.0, more=""):
    return (f"{THREE}checkpoint = {checkpoint};\noutput = {{ series = {max(steps // 20, 1)}; }};\n"
            f"phases = ( {{ name = \"measure\"; steps = {steps}; }} );\n{more}sweep = {sweep};\n")


def temporary_folder():
    """In memory when there is such a place: a sweep synchronises many small files."""
    shm = pathlib.Path("/dev/shm")
    there = shm.is_dir() and os.access(shm, os.W_OK) and shutil.disk_usage(shm).free > 2**29
    return pathlib.Path(tempfile.mkdtemp(prefix="slipdisk-sweep-", dir=shm if there else None))


def rows(folder, name="table.csv"):
    with open(folder / name, newline="") as file:
        return list(csv.DictReader(file))


def column(folder, name, table="table.csv"):
    return [r[name] for r in rows(folder, table)]


def results(folder):
    """name -> file, of all that is finished"""
    return {p.name[:-3]: p for p in (folder / "points").glob("*.h5") if p.is_file()}


def sessions(folder):
    """name -> how many processes have worked on it, of all that is finished"""
    found = {}
    for name, path in results(folder).items():
        with h5py.File(path) as file:
            found[name] = int(file["parameters"].attrs["sessions"])
    return found


def stamps(folder):
    """What changes when a result is written again."""
    return {name: (p.stat().st_ino, p.stat().st_mtime_ns) for name, p in results(folder).items()}


def children(pid):
    found = []
    for task in pathlib.Path(f"/proc/{pid}/task").glob("*/children"):
        try:
            found += [int(word) for word in task.read_text().split()]
        except OSError:
            pass
    return found


def is_alive(pid):
    """Zombies are dead: whoever has inherited them may never look."""
    try:
        return pathlib.Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()[0] not in "ZX"
    except OSError:
        return False


class SweepTest(unittest.TestCase):
    def setUp(self):
        self.folder = temporary_folder()
        self.out = self.folder / "out"

    def tearDown(self):
        shutil.rmtree(self.folder, ignore_errors=True)

    def small_disk(self, size, place=None):
        """A folder with room for so much."""
        if os.geteuid() != 0:
            self.skipTest("only root can mount a small disk")
        small = place or self.folder / "small"
        small.mkdir(parents=True)
        if subprocess.run(["mount", "-t", "tmpfs", "-o", f"size={size}", "tmpfs", small]).returncode:
            self.skipTest("mounting is not allowed here")
        # after tearDown, the last first
        self.addCleanup(shutil.rmtree, self.folder, ignore_errors=True)
        self.addCleanup(subprocess.run, ["umount", small], stderr=subprocess.DEVNULL)
        return small

    def deck(self, text, name="deck.cfg"):
        path = self.folder / name
        path.write_text(text)
        return path

    def sweep(self, deck, *words, status=0, out=None, **more):
        found, output, err = run("sweep", deck, "-o", out or self.out, *words, **more)
        self.assertEqual(found, status, output + err)
        return output + err

    def checkpoints(self):
        """name -> step of the last checkpoint, of points that are not finished"""
        found = {}
        for parts in (self.out / "points").glob("*.parts"):
            found[parts.name] = max((int(c.stem.split("-")[1]) for c in parts.glob("checkpoint-*.h5")), default=0)
        return found

    def begin(self, workers, *words, **more):
        """Starts a sweep; returns when so many workers wait, each with checkpoints of its own, for a signal or the gate."""
        self.gate = Gate(self, self.folder)
        process = start("sweep", *words, "-o", self.out, env=self.gate.environment, **more)
        self.gate.wait(process, workers)
        return process

    def assert_same_results(self, a, b):
        """The files are the same, and so are the tables but for the cost of a step."""
        one, two = results(a), results(b)
        self.assertEqual(sorted(one), sorted(two))
        for name in one:
            assert_same(self, one[name], two[name])
        for name in "table.csv", "means.csv":
            x, y = rows(a, name), rows(b, name)
            for r in x + y:
                r.pop("ns_per_step", None)
            self.assertEqual(x, y, name)
        with h5py.File(a / "table.h5") as f, h5py.File(b / "table.h5") as g:
            for group in "points", "means":
                self.assertEqual(list(f[group]), list(g[group]))
                for name in f[group]:
                    if name != "ns_per_step":
                        self.assertEqual(f[group][name][()].tobytes(), g[group][name][()].tobytes(), name)
        self.assertEqual(sorted(p.name for p in a.iterdir()), sorted(p.name for p in b.iterdir()))
        self.assertEqual(sorted(p.name for p in (a / "points").iterdir()), sorted(f"{name}.h5" for name in two))


class ReferenceTest(SweepTest):
    """A class sweeps its deck once, by make(); however its tests come to their results, they are to be the same."""

    POINTS = 0

    @classmethod
    def make(cls, text, *words):
        cls.where = temporary_folder()
        cls.addClassCleanup(shutil.rmtree, cls.where)
        cls.path = cls.where / "deck.cfg"
        cls.path.write_text(text)
        cls.reference = cls.where / "deck.sweep"  # where a sweep goes by itself
        cls.status, _, cls.err = run("sweep", cls.path, "-j", 2, *words, *SELDOM, cwd=cls.where)

    def setUp(self):
        super().setUp()
        self.assertEqual(self.status, 0, self.err)
        self.assert_all_done(self.err)

    def assert_all_done(self, said):
        self.assertIn(f"{self.POINTS} of {self.POINTS} points done", said)

    def stop(self, process, number, status):
        """Sends a signal to the sweep alone; returns what it has said."""
        process.send_signal(number)
        _, err = process.communicate(timeout=LONG)
        self.assertEqual(process.returncode, status, err)
        return err

    def finish(self, *words):
        """Sweeps what is not done yet."""
        self.assert_all_done(self.sweep(self.path, *words, *SELDOM))
        self.assert_same_results(self.out, self.reference)

    def sweep_twice_at_once(self, *words):
        """Two sweeps share the points: none is run twice."""
        both = [start("sweep", self.path, *words, *SELDOM, "-o", self.out) for _ in range(2)]
        said = [p.communicate(timeout=LONG)[1] for p in both]
        self.assertEqual([p.returncode for p in both], [0, 0], said)
        self.assertEqual(sum(text.count("Omega =") for text in said), self.POINTS, said)
        self.assertEqual(list(sessions(self.out).values()), [1] * self.POINTS)


def number(text):
    return numpy.nan if text == "" else float(text)
