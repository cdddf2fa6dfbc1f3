"""The decks of inputs/fields, shortened: their budgets close, and what is said in them comes out."""
import os
import pathlib
import tempfile
import unittest

import h5py
import numpy

from results_common import ROOT, run

DECKS = sorted((ROOT / "inputs/fields").glob("*.cfg"))
BRIEF = "SLIPDISK_BRIEF" in os.environ
# Residual over the scale of the budget, of runs of this length.
TIME, MOST = 4, 1e-6


class Fields(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix="slipdisk-fields-")
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def result(self, name, *settings):
        path = self.folder / f"{name}.h5"
        words = [word for setting in settings for word in ("-D", setting)]
        status, _, err = run("run", ROOT / f"inputs/fields/{name}.cfg", *words, "-o", path, "--quiet", "--threads", 1)
        self.assertIn(status, (0, 5), err)  # 5: too short for the means of disks
        file = h5py.File(path)
        self.addCleanup(file.close)
        return file

    def test_every_deck_is_checked_without_a_warning(self):
        self.assertGreaterEqual(len(DECKS), 6)
        for deck in DECKS:
            with self.subTest(deck.name):
                status, out, err = run("check", deck)
                self.assertEqual((status, err), (0, ""))
                self.assertIn("# field ", out)

    @unittest.skipIf(BRIEF, "steps are slow")
    def test_budgets_close(self):
        for deck in DECKS:
            with self.subTest(deck.name):
                phases = deck.read_text().count("; time = ")
                settings = [f"phases[{k}].time={TIME if k == 0 else 0.1}" for k in range(phases)]
                energy = dict(self.result(deck.stem, *settings)["summary/energy"].attrs)
                self.assertLess(abs(energy["residual"]), MOST * energy["scale"])

    def test_sediment_sinks_at_its_speed(self):
        """Before they meet: m g/(gamma R), here R; the time to reach it is 1.27 pi R/4."""
        state = self.result("sediment", "packings[0].count=20", "phases[0].time=6")["state"]
        falls = state["y"][:20] > 5
        self.assertGreater(falls.sum(), 5)
        radius, speed = state["radius"][:20][falls], -state["vy"][:20][falls]
        expected = 1.27 * numpy.pi * radius / 4 * (1 - numpy.exp(-6 * 4 / (1.27 * numpy.pi * radius)))
        numpy.testing.assert_allclose(numpy.sort(speed)[[0, -1]], numpy.sort(expected)[[0, -1]], rtol=1e-5)

    def test_a_thin_suspension_turns_at_its_vorticity(self):
        state = self.result("shear_flow", "packings[0].fraction=0.01", "phases[1].time=1")["state"]
        alone = numpy.asarray(state["loss_friction"])[:len(state["vx"]) - 2] == 0
        self.assertGreater(alone.sum(), 5)
        n = len(alone)
        numpy.testing.assert_allclose(state["omega"][:n][alone], -0.05, rtol=1e-5)
        numpy.testing.assert_allclose(state["vx"][:n][alone], 0.1 * (state["y"][:n][alone] - 15), atol=1e-5)

    def test_the_planet_comes_back(self):
        state = self.result("orbit")["state"]
        self.assertAlmostEqual(state["x"][0], 0.4, delta=1e-4)
        self.assertAlmostEqual(state["y"][0], 0, delta=2e-3)  # after ten periods of 10000 steps


if __name__ == "__main__":
    unittest.main()
