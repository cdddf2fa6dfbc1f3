"""`slipdisk sweep`: what it says of results that are in doubt, of another deck's, of another sweep's."""
import re
import shutil
import signal
import subprocess
import unittest

import h5py

from results_common import run
from sweep_common import SweepTest, column, results, rows, stamps, three_disks

UNCLOSED = "the energy budget does not close: a smaller dt is needed"


class Doubts(SweepTest):
    """Finished points whose numbers mean nothing are done, but not without a word."""

    def test_energy_budget(self):
        """The contacts are so stiff that dt is not stable: the disk is thrown off at once."""
        deck = self.deck(three_disks('{ parameters = ( { path = "materials[0].k_n"; values = (1e3, 1e13); } ); replicas = 2; }',
                                     more="limits = { unstable_step = true; };\n"))
        for words in ("-j", 2), (), ("-j", 2, "--no-lanes", "--force"):
            said = self.sweep(deck, *words, status=5)
            self.assertIn("4 of 4 points done", said)
            self.assertIn("2 points whose energy budget does not close: a smaller dt is needed\n", said)
            if words:
                self.assertEqual(said.count(f"; {UNCLOSED}"), 2, said)
        table = rows(self.out)
        self.assertEqual([r["status"] for r in table], ["done"] * 4)
        self.assertEqual([UNCLOSED in r["message"] for r in table], [False, False, True, True])
        self.assertEqual([r["message"] for r in table[:2]], ["", ""])
        said = self.sweep(deck, "--status")
        self.assertEqual(said.count(UNCLOSED), 2, said)
        self.assertIn("4 points: 4 done\n2 points whose energy budget", said)
        self.assertIn(UNCLOSED, self.sweep(deck, "--list").splitlines()[2])
        self.assertIn("1 point whose energy budget", self.sweep(deck, "--point", "1-2", status=5))
        # `info` has the same opinion
        for row in table:
            _, out, _ = run("info", results(self.out)[row["name"]])
            self.assertEqual(UNCLOSED in out, UNCLOSED in row["message"])

    def test_open_contacts(self):
        """One of two disks is thrown off."""
        deck = self.deck(three_disks('{ parameters = ( { path = "disks.upper.vy"; values = (0, 50); } ); }'))
        said = self.sweep(deck, "-j", 1, status=5)
        wanted = re.search(r"point 1, vy=50: upper: Omega = \S+ \+- \S+(?: \*)?; (the watched contacts of upper were open 100 % of the time "
                           r"\(with left: .*\))  \(", said)[1]
        self.assertIn("2 of 2 points done", said)
        self.assertIn("1 point whose watched contacts were open nearly all the time\n", said)
        self.assertEqual(column(self.out, "message"), ["", wanted])
        said = self.sweep(deck, "--status")
        self.assertIn(wanted, said)
        self.assertNotIn("vy=0 ", said)
        self.assertIn("1 point whose watched contacts", said)
        with h5py.File(self.out / "table.h5") as file:
            self.assertEqual(list(file["points/message"]), [b"", wanted.encode()])


FOUR = '{ parameters = ( { path = "gravity.tilt"; values = (0, "0.01 pi", "0.02 pi", "0.03 pi"); } ); }'


class OtherDeck(SweepTest):
    """What a forgotten -D would do."""

    def setUp(self):
        super().setUp()
        self.path = self.deck(three_disks(FOUR, 1000))
        self.longer = "-D", "phases.measure.steps=2000"

    def names(self):
        return sorted(p.name for p in (self.out / "points").iterdir())

    def test_finished(self):
        """Points that are not done are not run either, in no way."""
        self.sweep(self.path, *self.longer, "--point", "0-1", "--quiet")
        self.sweep(self.path, *self.longer, "--table")
        before = stamps(self.out), column(self.out, "status")
        for words in ("-j", 2), (), ("--point", 3), ("--point", "2-3"), ("--point", "1-3", "-j", 1), ("--table",):
            said = self.sweep(self.path, *words, status=2)
            self.assertRegex(said, r"error: (2 points in \S+ are|at least 1 point in \S+ is) of another deck: ")
            self.assertRegex(said, r"error: phases\.measure\.steps: 2000 there, 1000 here \((2 points|1 point)\)\n")
            self.assertEqual(said.count("phases.measure.steps"), 1, said)
            self.assertIn("no table is written" if "--table" in words else "nothing is run", said)
            self.assertEqual((stamps(self.out), column(self.out, "status")), before)
            self.assertEqual(len(self.names()), 2)
        said = self.sweep(self.path, "--status")
        self.assertEqual(said.splitlines(), [f"{self.out}: 4 points: 2 waiting, 2 other deck",
                                             "other deck: phases.measure.steps: 2000 there, 1000 here (2 points)"])
        said = self.sweep(self.path, "--mix", "-j", 2, status=2)
        self.assertIn("2 of 4 points done, 2 with a result that is not this deck's", said)
        self.assertEqual(column(self.out, "status"), ["other deck"] * 2 + ["done"] * 2)
        self.assertIn("table.csv", self.sweep(self.path, "--table", "--mix"))
        self.sweep(self.path, "--force", "-j", 2, "--quiet")
        self.assertEqual(column(self.out, "steps"), ["1000"] * 4)

    def test_begun(self):
        """A run that is not finished, too, is another deck's: it is told, and does not count as failed."""
        process = self.begin(1, self.path, "--point", 1, "-D", "phases.measure.steps=1e12", "-D", "checkpoint=0.03")
        process.send_signal(signal.SIGINT)
        self.assertEqual(process.wait(60), 75)
        process.communicate()
        said = self.sweep(self.path, "--status")
        self.assertIn("4 points: 3 waiting, 1 other deck\nother deck: phases.measure.steps: ", said)
        said = self.sweep(self.path, "-j", 2, status=2)
        self.assertIn("1 point in ", said)
        self.assertIn(" (1 point)", said)
        self.assertEqual(self.names(), ["tilt=0.01pi.h5.parts"])
        said = self.sweep(self.path, "-j", 2, "--mix", status=2)
        self.assertIn("3 of 4 points done, 1 with a result that is not this deck's", said)
        self.assertNotIn("failed", said)
        self.sweep(self.path, "-j", 2, "--force", "--quiet")
        self.assertEqual(column(self.out, "status"), ["done"] * 4)

    def test_differences(self):
        """By the keys, once for all points; a title is none, nor a default that is written out, nor the sweep."""
        self.sweep(self.path, "-j", 2, "--quiet")
        text = self.path.read_text()
        self.path.write_text('title = "new"; seed = 1; max_overlap = 0.5; checkpoint = 7.0;\n' + text.replace("checkpoint = 60.0;", "") +
                             "# and a comment\n")
        self.assertIn("4 of 4 points done", self.sweep(self.path, "-j", 2))
        for key, wanted in (("motions.shake.amplitude=2e-4",
                             r"motions\.shake\.amplitude: 0\.0001 there, 0\.0002 here \(4 points\)"),
                            ("seed=7", r"seed: \d+L there, \d+L here, and other values \(4 points\)"),
                            ("disks.upper.vx=0.5", r"disks\.upper\.vx: 0\.0 there, 0\.5 here \(4 points\)"),
                            ("measure.rotation=[0, 1]", r"measure\.rotation: .* there, .* here \(4 points\)"),
                            ("integrator=\"verlet\"", r'integrator: "gear5" there, "verlet" here \(4 points\)')):
            with self.subTest(key=key):
                said = self.sweep(self.path, "-D", key, status=2)
                self.assertRegex(said, rf"\nerror: {wanted}\n\Z")

    def test_growing_and_shrinking(self):
        """Points that this sweep does not have are told of; a folder that has nothing else is refused."""
        self.sweep(self.path, "-j", 2, "--quiet")
        (self.out / "points/tilt=9.failed").write_text("why\n")
        before = stamps(self.out)
        part = self.deck(three_disks(FOUR.replace('"0.01 pi", ', ""), 1000))
        wanted = "has 1 result, 1 note of a failure of points that this sweep does not have, such as tilt="
        for words in ("-j", 2), ("--status",), ("--table",), ("--list",):
            self.assertIn(wanted, self.sweep(part, *words))
        self.assertEqual(len(rows(self.out)), 3)
        self.assertEqual(self.sweep(part, "--quiet"), "")
        other = self.deck(three_disks('{ parameters = ( { path = "gravity.g"; values = (9, 10); } ); }', 1000))
        for words in ("-j", 2), (), ("--point", 1), ("--point", "0-1"), ("--table",):
            said = self.sweep(other, *words, status=2)
            self.assertIn("has 4 results, 1 note of a failure of points that this sweep does not have", said)
            self.assertIn("and nothing of its own: no", said)
        self.assertEqual(len(rows(self.out)), 3)
        self.assertEqual(stamps(self.out), before)
        self.assertIn("2 of 2 points done", self.sweep(other, "--mix", "-j", 2))
        self.assertIn("has 4 results", self.sweep(other, "-j", 2))


class Points(SweepTest):
    """Of single points."""

    def test_info(self):
        """The complete deck of a point makes the same numbers; what failed says so; a folder is no result."""
        deck = self.deck(three_disks('{ parameters = ( { path = "motions.shake.amplitude"; values = (1e-4, 5); } ); replicas = 2; }',
                                     150000))
        self.sweep(deck, "-j", 2, "-D", "gravity.tilt=0.1", "--quiet", status=3)
        path = self.out / "points/amplitude=0.0001,r=1.h5"
        status, out, err = run("info", "--deck", path)
        self.assertEqual(status, 0, err)
        again = self.folder / "again.h5"
        status, _, err = run("run", self.deck(out, "again.cfg"), "-o", again, "--quiet")
        self.assertEqual(status, 0, err)
        with h5py.File(path) as one, h5py.File(again) as two:
            self.assertEqual(one["state"].attrs["hash"], two["state"].attrs["hash"])
        failed = self.out / "points/amplitude=5.h5"
        status, out, _ = run("info", failed)
        self.assertEqual(status, 0)
        self.assertRegex(out, r"NOT finished.*\nFAILED when it was run last:\n  .*overlap")
        shutil.rmtree(f"{failed}.parts")
        status, out, _ = run("info", failed)
        self.assertEqual(status, 0)
        self.assertRegex(out, r"there is no result\nFAILED when it was run last:\n  .*overlap")
        status, _, err = run("info", self.out)
        self.assertEqual(status, 2)
        self.assertIn(f"slipdisk sweep DECK -o {self.out} --status", err)

    def test_blocks(self):
        """The last block of a list of tasks may be longer than the list."""
        deck = self.deck(three_disks(FOUR, 100))
        said = self.sweep(deck, "--point", "2-9")
        self.assertIn("--point 2-9: 3 is the last point of this sweep", said)
        self.assertIn("2 of 2 points done", said)
        self.assertIn("is done already", self.sweep(deck, "--point", "3-9"))
        self.assertIn("is done already", self.sweep(deck, "--point", "3-9", "-j", 2))

    def test_nothing_can_be_written(self):
        """Failures whose reasons could not be kept count, and a table that could not be written is not promised."""
        deck = self.deck(three_disks(FOUR, 1000))
        small = self.small_disk("8m", self.out)
        (small / "points").mkdir()
        subprocess.run(["mount", "-o", "remount,ro", small], check=True)
        for words in ("-j", 2), ():
            said = self.sweep(deck, *words, status=4)
            self.assertIn("0 of 4 points done, 4 failed; the table could not be written\n", said)
            self.assertNotIn("failed: error:", said)
            self.assertNotIn("everything is saved", said)


if __name__ == "__main__":
    unittest.main()
