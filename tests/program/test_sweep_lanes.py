"""Points of a sweep that run side by side in lanes: the results of each by itself, however they are put together, stopped,
killed and continued."""
import os
import random
import re
import shutil
import signal
import subprocess
import unittest

import h5py

from results_common import DECK, LONG, SELDOM, assert_same, run, start, steps_for, wait_for
from sweep_common import (ReferenceTest, SweepTest, children, column, is_alive, results, rows, sessions,
                          temporary_folder, three_disks)

SECONDS = 0.3  # of a point alone: side by side as long as all of them
TILTS = '{ parameters = ( { path = "gravity.tilt"; values = (0, "0.01 pi", "0.02 pi", "0.03 pi"); } ); replicas = %d; }'
LANES = "side by side"


def has_lanes():
    folder = temporary_folder()
    (folder / "deck.cfg").write_text(three_disks(TILTS % 1, 10))
    _, out, _ = run("check", folder / "deck.cfg", "--brief", "--no-probe")
    shutil.rmtree(folder)
    return LANES in out


@unittest.skipUnless(has_lanes(), "this machine has no lanes")
class Lanes(ReferenceTest):
    """Eight points; the reference are the same, one by one."""

    POINTS = 8

    @classmethod
    def setUpClass(cls):
        cls.make(three_disks(TILTS % 2, steps_for(SECONDS), checkpoint=0.03), "--no-lanes")
        _, out, _ = run("check", cls.path, "--brief", "--no-probe")
        cls.width = int(re.search(r"8 of them can go in lanes, up to (\d+) side by side", out)[1])
        cls.together = min(8, cls.width)

    def setUp(self):
        super().setUp()
        self.assertNotIn(LANES, self.err)

    def test_who_goes_together(self):
        """Groups are as large as they can be, but leave no worker idle."""
        for words, said in ((), "8 side by side in lanes"), (["-j", 3], "8 in lanes: 3 groups of up to 4"), \
                (["-j", 5], "6 in lanes: 3 groups of up to 2 side by side, 2 one by one"), \
                (["-j", 8], "0 done\n"), (["--threads", 2], "0 done\n"):
            with self.subTest(words=words):
                found = self.sweep(self.path, *words, "-D", "phases.measure.steps=20")
                if self.width == 8:
                    self.assertIn(said, found)
                self.assert_all_done(found)
                shutil.rmtree(self.out)

    def test_same_results(self):
        for words in (), ("-j", 3):
            with self.subTest(words=words):
                self.finish(*words)
                self.assertEqual(set(sessions(self.out).values()), {1})
                if not words:
                    self.assert_cost_is_shared()
                shutil.rmtree(self.out)

    def assert_cost_is_shared(self):
        """The wall time of a group is shared among its points."""
        for name, path in results(self.out).items():
            with h5py.File(path) as file:
                p = file["parameters"].attrs
                self.assertGreater(p["step_seconds"], 0)
                self.assertLess(p["step_seconds"], p["wall_seconds"] / self.together * 1.05, name)

    def test_killed_again_and_again(self):
        """kill -9, and continued by other groups, or one by one."""
        chance = random.Random(3)
        kinds = (("-j", 1), ("-j", 2), ("--no-lanes", "-j", 2), (), ("--no-lanes",), ("-j", 3))
        kills = 0
        for k in range(40):
            process = start("sweep", self.path, *kinds[k % len(kinds)], "-o", self.out, "--quiet")
            try:
                _, err = process.communicate(timeout=chance.uniform(0.05, 0.4))
                self.assertEqual(process.returncode, 0, err)
                break
            except subprocess.TimeoutExpired:
                workers = children(process.pid)
                for pid in (process.pid, *workers):
                    os.kill(pid, signal.SIGKILL)
                process.communicate()
                wait_for(lambda gone=workers: not any(is_alive(pid) for pid in gone))
                kills += 1
        self.assertGreater(kills, 2)
        self.finish()
        self.assertGreater(max(sessions(self.out).values()), 1)

    def test_signals(self):
        """All points of a group stop at checkpoints; one of them goes on alone, the rest in other groups."""
        for words in ("-j", 1), ():
            process = self.begin(1, self.path, *words)
            self.assertIn(f"{self.together} running", self.sweep(self.path, "--status"))
            said = self.stop(process, signal.SIGTERM, 75)
            self.assertIn("stopped, everything is saved: give the command again", said)
            self.assertEqual(len(list((self.out / "points").glob("*.parts"))), self.together)
            self.assertEqual(column(self.out, "status"), ["stopped"] * self.together + ["waiting"] * (8 - self.together))
        self.assertEqual(run("resume", self.out / "points/tilt=0,r=1.h5", "--quiet")[0], 0)
        process = self.begin(1, self.path, "--no-lanes", "-j", 1)
        self.stop(process, signal.SIGINT, 75)
        self.finish("-j", 2)
        self.assertEqual(max(sessions(self.out).values()), 4)

    def test_crash(self):
        """Of a group that crashes each point is run again by itself."""
        process = self.begin(1, self.path, "-j", 1)
        os.kill(children(process.pid)[0], signal.SIGSEGV)
        self.gate.open()
        _, err = process.communicate(timeout=LONG)
        self.assertEqual(process.returncode, 0, err)
        self.assertRegex(err, r"warning: the process that ran \d+ points side by side .*; they are run again one by one")
        self.assert_all_done(err)
        self.assert_same_results(self.out, self.reference)

    def test_crash_again(self):
        """Only the point that crashes by itself, too, has failed."""
        n = self.together
        process = self.begin(1, self.path, "-j", 1, "--point", f"0-{n - 1}")
        first, = children(process.pid)
        os.kill(first, signal.SIGKILL)
        wait_for(lambda: (children(process.pid) or [first]) != [first])
        os.kill(children(process.pid)[0], signal.SIGKILL)
        self.gate.open()
        _, err = process.communicate(timeout=LONG)
        self.assertEqual(process.returncode, 3, err)
        self.assertIn(f"{n - 1} of {n} points done, 1 failed", err)
        failed, = (self.out / "points").glob("*.failed")
        self.assertIn("was ended by signal 9", failed.read_text())
        self.finish("-j", 1)

    def test_at_once(self):
        """Whatever groups the two find."""
        self.sweep_twice_at_once("-j", 1)
        self.finish()

    def test_one_is_run_by_another_process(self):
        """It is left out, the others of its group go on."""
        one = self.begin(1, self.path, "--point", 2, "-D", "phases.measure.steps=1e12")
        said = self.sweep(self.path, "-j", 1, "--no-wait", status=6)
        self.assertIn("7 of 8 points done, 1 run by another process", said)
        self.stop(one, signal.SIGTERM, 75)
        self.assertIn("tilt=0.01pi.h5.parts", [p.name for p in (self.out / "points").iterdir()])
        # and what it was run with was another deck
        said = self.sweep(self.path, "-j", 1, status=2)
        self.assertRegex(said, r"1 point in \S+ is of another deck: nothing is run\.")
        self.assertRegex(said, r"error: phases\.measure\.steps: \w+ there, \w+ here \(1 point\)\n")

    def test_part(self):
        """Some points only, as for a task of an array of jobs."""
        said = self.sweep(self.path, "--point", "1-4", *SELDOM)
        self.assertIn("4 points, 0 done", said)
        self.assertIn("4 of 4 points done", said)
        self.assertEqual(len(results(self.out)), 4)
        self.assertFalse((self.out / "table.csv").exists())
        self.sweep(self.path, "--point", "4-400", "-j", 2, *SELDOM)
        self.assertEqual(len(results(self.out)), 7)
        self.assertIn("3 of 3 points done", self.sweep(self.path, "--point", "5-7", *SELDOM))
        self.finish()
        for words in "8-9", "3-2", "3-", "a-b", "-3-4":
            self.assertIn("--point", self.sweep(self.path, "--point", words, status=2))

    def test_full_disk(self):
        """Of one point: it leaves, the others go on."""
        name = "tilt=0.02pi"
        small = self.small_disk("64k", self.out / f"points/{name}.h5.parts")
        (small / "part-999999.h5").write_bytes(bytes(20 * 1024))  # as a kill would leave it
        said = self.sweep(self.path, "-j", 1, status=4)
        self.assertIn("No space left on device", said)
        self.assertIn("7 of 8 points done, 1 failed", said)
        self.assertEqual(sorted(results(self.out)), sorted(set(results(self.reference)) - {name}))
        subprocess.run(["umount", small], check=True)
        self.finish("-j", 1)


@unittest.skipUnless(has_lanes(), "this machine has no lanes")
class Different(SweepTest):
    """Points that do not do the same."""

    def compare(self, text, status=0, n=None):
        """In groups and one by one; what the groups said."""
        deck = self.deck(text)
        alone = self.folder / "alone"
        self.sweep(deck, "--no-lanes", "-j", 2, out=alone, status=status)
        said = self.sweep(deck, status=status)
        self.assertIn(LANES, said)
        one, two = results(self.out), results(alone)
        self.assertEqual(sorted(one), sorted(two))
        for name in one:
            assert_same(self, one[name], two[name])
        self.assertEqual(len(one), n)
        return said

    def test_numeric(self):
        """One fails on the way; its state is kept, and the others do not notice."""
        said = self.compare(three_disks('{ parameters = ( { path = "motions.shake.amplitude"; '
                                        'values = (1e-4, 2e-4, 5, 3e-4); } ); }', 150000), status=3, n=3)
        self.assertIn("point 2, amplitude=5: failed: ", said)
        self.assertIn("3 of 4 points done, 1 failed", said)
        message = rows(self.out)[2]["message"]
        self.assertEqual(message.replace(str(self.folder / "alone"), str(self.out)),
                         rows(self.folder / "alone")[2]["message"].replace(str(self.folder / "alone"), str(self.out)))
        kept = [[p.name for p in (where / "points/amplitude=5.h5.parts").glob("emergency-*.h5")]
                for where in (self.out, self.folder / "alone")]
        self.assertEqual(len(kept[0]), 1)
        self.assertEqual(*kept)
        step = int(kept[0][0].split("-")[1][:-3])
        self.assertGreater(step, 100)
        self.assertLess(step, 140000)

    def test_rest(self):
        """The disk falls onto the others, and phases end when it is at rest, or do not."""
        text = three_disks("""{ parameters = (
            { path = "phases.fall.settle.kinetic"; name = "rest"; values = (3e-4, 3e-5, 1e-5, 1e-12); } ); }""", 20000)
        fall = '{ name = "fall"; steps = 30000; measure = false; settle = { kinetic = 1e-3; every = 700; }; },'
        text = text.replace("phases = (", f"phases = ( {fall}").replace("x = 0;  y = 0; ", "x = 0;  y = 0; vy = -0.1;")
        self.compare(text, n=4)
        self.assertEqual(len(set(column(self.out, "steps"))), 4, column(self.out, "steps"))

    def test_error_bar(self):
        """Runs end when it is small enough, or are given up."""
        self.compare(f"""@include "{DECK}"
            until = {{ error = 1; max_time = 6; }};
            sweep = {{ parameters = ( {{ path = "phases.measure.steps"; name = "least"; values = (100000); }},
              {{ path = "phases.settle.steps"; name = "settle"; values = (1000, 30000); }},
              {{ path = "motions[*].amplitude"; name = "drive"; values = (6e-4); }},
              {{ path = "until.error"; name = "wanted"; values = (0.1, 0.02, 1e-30); }} ); }};""", n=6)
        self.assertGreater(len(set(column(self.out, "steps"))), 3, column(self.out, "steps"))
        self.assertEqual(column(self.out, "goal").count("0"), 2)

    def test_lengths_and_cadences(self):
        """Rows fall on different steps, steps are of different lengths, and so are phases."""
        self.compare(three_disks('''( { parameters = (
            { path = "phases[0].steps"; name = "n"; values = (3000, 7777, 20000); zip = "length"; },
            { path = "output.series"; values = (7, 500, 1300); zip = "length"; },
            { path = "output.frames"; values = (0, 1111, 100); zip = "length"; },
            { path = "dt"; values = (1e-6, 2e-6, 5e-7); zip = "length"; } ); replicas = 2; } )'''), n=6)
        self.assertEqual(column(self.out, "steps"), ["3000"] * 2 + ["7777"] * 2 + ["20000"] * 2)

    def test_kinds(self):
        """Integrators and motions do not go together, and what has too many bodies for lanes goes by itself."""
        said = self.compare(three_disks('''{ parameters = (
            { path = "integrator"; values = ("gear5", "verlet"); },
            { path = "materials[0].mu"; values = (0.1, 0.2, 0); },
            { path = "motions.shake.disk"; name = "who"; values = ("left", "right"); } ); }''', 3000), n=12)
        self.assertIn("12 of 12 points done", said)


if __name__ == "__main__":
    unittest.main()
