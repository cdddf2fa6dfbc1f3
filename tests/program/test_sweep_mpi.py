"""A sweep over the ranks of an MPI job: the results of one process, also when it is stopped or killed on the way.

mpirun passes USR1 on, and the job ends with status 75. On TERM (and INT) it passes TERM on, kills what is left after
a second, and ends with a status of its own: no more is asked of it here than that nothing is lost.
"""
import csv
import fcntl
import os
import pathlib
import random
import shutil
import signal
import subprocess
import tempfile
import time
import unittest

import h5py

from results_common import DECK, Gate, LONG, PROGRAM, assert_same, results, run, steps_for, wait_for

MPIEXEC = os.environ["SLIPDISK_MPIEXEC"].split()
POINTS, TIMING = 6, {"ns_per_step"}


def listed(table):
    """The files that belong to a table, without the checksums of those with times in them."""
    with h5py.File(table) as file:
        return [line.split()[0] for line in file["parameters/files"][()].decode().splitlines()]


def children(pid):
    """Processes whose parent this is."""
    found = []
    for stat in pathlib.Path("/proc").glob("[0-9]*/stat"):
        try:
            words = stat.read_text().rpartition(")")[2].split()
        except OSError:  # gone meanwhile
            continue
        if int(words[1]) == pid:
            found.append(int(stat.parent.name))
    return sorted(found)


def is_alive(pid):
    try:
        return pathlib.Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except OSError:
        return False


class Sweep(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.top = pathlib.Path(tempfile.mkdtemp(prefix="slipdisk-sweep-mpi-"))
        cls.deck = cls.top / "tilts.cfg"
        cls.deck.write_text(f"""@include "{DECK}"
            sweep = {{ parameters = ( {{ path = "gravity.tilt"; values = (0, "0.02 pi", "0.04 pi"); }} );
                       replicas = {POINTS // 3}; }};""")
        cls.steps = steps_for(1)
        _, out, _ = run("check", cls.deck, "--brief", "--no-probe")
        cls.has_lanes = "side by side" in out

    @classmethod
    def tearDownClass(cls):
        shutil.rmtree(cls.top)

    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(dir=self.top)) / "sweep"

    def prepare(self, part):
        """Points that take about `part` seconds each, and what one process makes of them."""
        self.words = ["sweep", str(self.deck), "-D", "phases.settle.steps=20000", "-D",
                      f"phases.measure.steps={round(self.steps * part / 1000) * 1000}", "-D", "checkpoint=0.05"]
        self.reference = self.folder.parent / "reference"
        status, _, err = run(*self.words, "-j", 1, "-o", self.reference)
        self.assertEqual(status, 0, err)

    def start(self, ranks, *more, env=None):
        self.log = open(self.folder.parent / "log", "a+")
        self.addCleanup(self.log.close)
        return subprocess.Popen([*MPIEXEC, "-n", str(ranks), PROGRAM, *self.words, "-o", str(self.folder), *more],
                                stdout=self.log, stderr=self.log, env=env)

    def said(self):
        return (self.folder.parent / "log").read_text()

    def finish(self, ranks, status=0, *more):
        self.assertEqual(self.start(ranks, *more).wait(timeout=LONG), status, self.said())

    def ranks_at_work(self, process):
        """Their process ids, once one waits at the gate; the other may ask that one for a point, and wait, too."""
        self.gate.wait(process)
        return children(process.pid)

    def results(self, folder=None):
        return sorted(path.name for path in (folder or self.folder).glob("points/*"))

    def assert_complete(self):
        """All results, and the tables but for what was measured with a clock, are those of one process."""
        self.assertEqual(self.results(), self.results(self.reference))
        self.assertEqual(len(self.results()), POINTS)
        for name in self.results():
            assert_same(self, self.folder / "points" / name, self.reference / "points" / name)
        for name in ("table.csv", "means.csv"):
            with open(self.folder / name, newline="") as one, open(self.reference / name, newline="") as two:
                a, b = list(csv.DictReader(one)), list(csv.DictReader(two))
            self.assertEqual(len(a), POINTS if name == "table.csv" else 3)
            for row in (*a, *b):
                for column in TIMING & row.keys():
                    row[column] = "time"
            self.assertEqual(a, b)
        a, b = (results.content(folder / "table.h5") for folder in (self.folder, self.reference))
        others = [name for name in results.differences(a, b) if "@" not in name]
        self.assertEqual([name for name in others if pathlib.PurePath(name).name not in TIMING | {"files"}], [])
        self.assertEqual(*(listed(folder / "table.h5") for folder in (self.folder, self.reference)))
        self.assertEqual(sorted(p.name for p in self.folder.iterdir()), sorted(
            p.name for p in self.reference.iterdir()))

    def test_same_results_on_any_number_of_ranks(self):
        self.prepare(0.2)
        for ranks in (2, 4):
            with self.subTest(ranks=ranks):
                self.finish(ranks)
                self.assert_complete()
                if self.has_lanes and ranks == 2:
                    self.assertIn("6 in lanes: ", self.said())
                if ranks == 2:  # finished already: nothing happens
                    self.finish(ranks)
                    self.assert_complete()
                shutil.rmtree(self.folder)

    def interrupt(self, how, status=None):
        """how(launcher, ranks) ends a job of two ranks that are at work, with all points in lanes and one by one in turn;
        status None: any but 0."""
        self.lanes = not getattr(self, "lanes", False) and self.has_lanes
        for path in self.folder.glob("points/*.h5"):  # always enough to do, however fast the machine
            if path.is_file():
                path.unlink()
        self.gate = Gate(self, self.folder, when=2)
        process = self.start(2, *(() if self.lanes else ("--no-lanes",)), env=self.gate.environment)
        ranks = self.ranks_at_work(process)
        how(process.pid, ranks)
        self.gate.open()
        found = process.wait(timeout=LONG)
        if status is None:
            self.assertNotEqual(found, 0, self.said())
        else:
            self.assertEqual(found, status, self.said())
        wait_for(lambda: not any(is_alive(pid) for pid in ranks))
        self.assertLess(len(list(self.folder.glob("points/*.h5"))), POINTS)

    def test_interrupted_in_every_way(self):
        self.prepare(1)
        self.interrupt(lambda launcher, ranks: os.kill(launcher, signal.SIGUSR1), 75)
        # one rank hears of it, all stop
        self.interrupt(lambda launcher, ranks: os.kill(ranks[0], signal.SIGTERM), 75)
        self.interrupt(lambda launcher, ranks: os.kill(ranks[1], signal.SIGUSR1), 75)
        self.interrupt(lambda launcher, ranks: os.kill(launcher, signal.SIGTERM))
        self.interrupt(lambda launcher, ranks: os.kill(ranks[1], signal.SIGKILL))
        chance = random.Random(1)

        def kill_all(launcher, ranks):
            time.sleep(chance.uniform(0, 0.1))
            for pid in (launcher, *ranks):
                os.kill(pid, signal.SIGKILL)

        for _ in range(2):
            self.interrupt(kill_all)
        self.finish(2)
        self.assert_complete()

    def test_points_of_other_processes_are_waited_for(self):
        """Also of those that rank 1 would have run; a signal to one rank ends the waiting of all."""
        self.prepare(0.02)
        parts = self.folder / "points" / f"{self.results(self.reference)[1]}.parts"
        parts.mkdir(parents=True)
        with open(parts / "lock", "w") as lock:
            fcntl.flock(lock, fcntl.LOCK_EX)
            self.finish(2, 6, "--no-wait")
            self.assertIn("left to other processes: 1 point", self.said())
            for number, status in (signal.SIGUSR1, 75), (None, 0):
                with open(self.log.name, "w"):
                    pass
                process = self.start(2)
                wait_for(lambda: "waiting for 1 point that other processes run" in self.said())
                if number:
                    os.kill(children(process.pid)[1], number)
                else:
                    lock.close()
                self.assertEqual(process.wait(timeout=LONG), status, self.said())
        self.assert_complete()

    def test_a_point_fails(self):
        """Its limit to overlaps is too low: the others are done, and the status is 3."""
        self.words = ["sweep", str(self.deck), "-D", "phases.settle.steps=20000", "-D", "phases.measure.steps=50000"]
        limits = "sweep.parameters=({ path = \"max_overlap\"; values = (0.5, 0.25, 1e-12, 0.125); })"
        self.finish(5, 3, "-D", limits, "-D", "sweep.replicas=1")
        self.assertEqual(len(list(self.folder.glob("points/*.h5"))), 3, self.said())
        self.assertEqual(len(list(self.folder.glob("points/*.failed"))), 1, self.said())


if __name__ == "__main__":
    unittest.main()
