"""Runs whose phases end at rest, with rain and bounds: what they write and say."""
import unittest

import h5py
import numpy

from results_common import Folder, run, start

DECK = """
dt = 2e-5; gravity = {{ g = 9.81; }}; checkpoint = {checkpoint};
materials = ( {{ name = "a"; k_n = 1e4; k_t = 5e3; gamma_n = 2; mu = 0.4; }} );
container = {{ type = "box"; width = 0.4; height = 1; }};
packings = ( {{ type = "rain"; count = {count}; rows = 1; sizes = "uniform"; lower = 0.012; upper = 0.02; density = 3.57; }} );
phases = (
  {{ name = "fall"; steps = {most}; settle = {{ kinetic = 1e-8; unbalanced = 1e-2; every = 700; }}; series = 900; frames = 5000; }},
  {{ name = "after"; steps = 2000; series = 500; contacts = 1000; }}
);
measure = {{ rotation = (); }};
"""

LEAK = """
dt = 2e-5; gravity = { g = 9.81; };
materials = ( { name = "a"; k_n = 1e4; gamma_n = 2; } );
walls = ( { type = "segment"; points = ((-1, 0), (1, 0)); } );
disks = ( { name = "stays"; x = 0; y = 0.02; radius = 0.02; density = 3.57; },
          { name = "falls"; x = 2; y = 0.5; radius = 0.02; density = 3.57; } );
bounds = { y = (-0.1, 2); outside = "report"; };
steps = 30000; output = { series = 1000; };
"""


class Runs(Folder):
    def deck(self, text=None, count=40, most=200000, checkpoint=60.0):
        path = self.folder / "d.cfg"
        path.write_text(text or DECK.format(count=count, most=most, checkpoint=checkpoint))
        return path


class Ends(Runs):
    def test_at_rest(self):
        out, err = self.run_ok("run", self.deck(), "-o", self.result)
        self.assertNotIn("warning", err)
        with h5py.File(self.result) as file:
            phases = file["summary/phase"]
            taken, most = phases["steps"][:], phases["most"][:]
            self.assertEqual(list(most), [200000, 2000])
            self.assertEqual(list(phases["reached"]), [1, 1])
            self.assertEqual(list(phases["asked"]), [1, 0])
            self.assertEqual(phases["name"][()].split(), [b"fall", b"after"])
            self.assertLess(taken[0], 200000)
            self.assertEqual(taken[0] % 700, 0)
            self.assertEqual(taken[1], 2000)
            self.assertLessEqual(phases["kinetic"][0], 1e-8)
            self.assertLessEqual(phases["unbalanced"][0], 1e-2)
            summary = file["summary"].attrs
            self.assertEqual((summary["step"], summary["steps"]), (taken.sum(), 202000))
            self.assertEqual((summary["waiting"], summary["outside"], summary["left"]), (0, 0, 0))
            # cadences count from where each phase began
            rows = [*range(0, taken[0], 900), *range(taken[0], taken.sum() + 1, 500)]
            self.assertEqual(list(file["observables/work/step"]), rows)
            self.assertEqual(list(file["contacts/step"]), [0, *range(taken[0], taken.sum() + 1, 1000)])
            self.assertTrue((file["observables/outside/value"][:] == 0).all())
            energy = file["summary/energy"].attrs
            self.assertLess(abs(energy["residual"]), 1e-3 * energy["scale"])
            # what waits brings nothing: the energy at the start grows with each batch
            start_energy = file["observables/start/value"][:]
            self.assertGreater(len(set(start_energy)), 2)
            self.assertTrue((numpy.diff(start_energy) >= 0).all())
        self.assertIn("of at most 202000 steps", out)
        self.assertRegex(out, rf"fall +{taken[0]} +200000")
        self.assertIn("of at most", self.run_ok("info", self.result)[0])

    def test_not_at_rest(self):
        out, err = self.run_ok("run", self.deck(most=3000), "-o", self.result)
        self.assertIn('warning: phase "fall" has ended after all its 3000 steps and is not at rest; kinetic energy per disk', err)
        self.assertIn("asked for is 1e-08", err)
        self.assertIn("; a longer phase is needed, or one more with relax = true\n", err)
        self.assertIn("NOT reached", out)
        with h5py.File(self.result) as file:
            self.assertEqual(list(file["summary/phase/reached"]), [0, 1])
            self.assertEqual(list(file["summary/phase/steps"]), [3000, 2000])
            waiting = int(file["summary"].attrs["waiting"])
        self.assertGreater(waiting, 0)
        self.assertIn(f"{waiting} disks still wait for their rain", err)
        self.assertIn(f"{waiting} disks wait to be released", out)

    def test_progress(self):
        log = self.folder / "log"
        self.run_ok("run", self.deck(), "-o", self.result, "--log", log)
        lines = [line for line in log.read_text().splitlines() if "ETA" in line]
        # no percentage of a length that will not be reached, no end while disks wait for their rain
        self.assertRegex(lines[0], r"fall: step 0 of at most 202000 .* ETA \?  \d+ disks wait")
        after = [line for line in lines if line.startswith("after: step")]
        self.assertRegex(after[0], r"step \d+/\d+ .* \d+\.\d % ")
        self.assertIn("100.0 %", lines[-1])

    def test_progress_towards_rest(self):
        log = self.folder / "log"
        deck = self.deck(LEAK.replace("steps = 30000;", "phases = ( { steps = 30000; settle = { kinetic = 1e-9; }; } );"))
        run("run", deck, "-o", self.result, "--log", log)
        lines = [line for line in log.read_text().splitlines() if "ETA" in line]
        self.assertRegex(lines[0], r"step 0 of at most 30000 .*  kinetic \S+ of 1e-09")


class Lost(Runs):
    def test_told_of(self):
        out, err = self.run_ok("run", self.deck(LEAK), "-o", self.result)
        self.assertRegex(err, r'warning: step \d+: disk "falls" left the bounds, it is at \(2, -0\.1')
        self.assertRegex(out, r'1 disk left the bounds: disk "falls" at \(2, -')
        with h5py.File(self.result) as file:
            outside = file["observables/outside/value"][:]
            self.assertEqual((outside[0], outside[-1], file["summary"].attrs["outside"]), (0, 1, 1))
        self.assertIn("left the bounds", self.run_ok("info", self.result)[0])

    def test_reason_to_stop(self):
        status, _, err = run("run", self.deck(LEAK.replace("report", "stop")), "-o", self.result)
        self.assertEqual(status, 3)
        self.assertRegex(err, r'error: step \d+: disk "falls" left the bounds')
        self.assertEqual(len(list(self.parts.glob("emergency-*.h5"))), 1)

    def test_taken_out(self):
        out, err = self.run_ok("run", self.deck(LEAK.replace("report", "remove")), "-o", self.result)
        self.assertIn("and is taken out", err)
        self.assertRegex(out, r'1 disk left the bounds: disk "falls" at \(2, -0\.1')

    def test_nobody_gave_bounds(self):
        deck = LEAK.replace('bounds = { y = (-0.1, 2); outside = "report"; };', "").replace("30000", "150000")
        out, err = self.run_ok("run", self.deck(deck), "-o", self.result)
        self.assertIn('disk "falls" left the bounds', err)
        self.assertIn('outside = "report"', self.run_ok("check", self.deck(deck), "--no-probe")[0])


if __name__ == "__main__":
    unittest.main()
