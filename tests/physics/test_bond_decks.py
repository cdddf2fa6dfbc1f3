"""The decks of inputs/bonds, shortened: their budgets close, and what is said in them comes out."""
import os
import pathlib
import tempfile
import unittest

import h5py

from results_common import ROOT, run

DECKS = sorted((ROOT / "inputs/bonds").glob("*.cfg"))
BRIEF = "SLIPDISK_BRIEF" in os.environ
MOST = 1e-4  # residual over the scale of the budget, with the residual of the compression
SMALL = {"compression": ("container.width=8", "container.height=17", "packings[0].count=128", "phases.free.time=5", "phases.load.time=30",
                         "motions.down.velocity=-1e-3", "motions.up.velocity=1e-3"),
         "brazilian": ("packings[0].count=100", "motions[0].speed=0.3", "motions[1].speed=0.3", "phases.load.time=40",
                       "motions.up.velocity=1e-3", "motions.down.velocity=-1e-3"),
         "heap": ("packings[0].count=100", "phases.settle.time=10", "phases.stand.time=10", "constants.strength=3"),
         "agglomerate": ("packings[0].count=60", "constants.speed=0.3")}


class Bonds(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix="slipdisk-bonds-")
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def result(self, name, *settings):
        path = self.folder / f"{name}{len(list(self.folder.iterdir()))}.h5"
        words = [word for setting in settings for word in ("-D", setting)]
        status, _, err = run("run", ROOT / f"inputs/bonds/{name}.cfg", *words, "-o", path, "--quiet", "--threads", 1)
        self.assertEqual(status, 0, err)
        file = h5py.File(path)
        self.addCleanup(file.close)
        return file

    def test_every_deck_is_checked_without_a_warning(self):
        self.assertEqual({deck.stem for deck in DECKS}, set(SMALL))
        for deck in DECKS:
            with self.subTest(deck.name):
                status, _, err = run("check", deck)
                self.assertEqual((status, err), (0, ""))

    def test_budgets_close(self):
        for name, settings in SMALL.items():
            with self.subTest(name):
                file = self.result(name, *settings)
                energy, broken = dict(file["summary/energy"].attrs), file["breaks/energy"][:]
                self.assertLess(abs(energy["residual"]), MOST * energy["scale"])
                self.assertGreater(len(broken), 3)
                lost = sum(energy[f"broken_{mode}"] for mode in ("tension", "shear", "bending"))
                self.assertAlmostEqual(lost, broken.sum(), delta=1e-12 * abs(lost))

    @unittest.skipIf(BRIEF, "steps are slow")
    def test_a_strong_column_stands(self):
        count = {}
        for strength in (40, 8):
            file = self.result("heap", f"constants.strength={strength}", "phases.stand.time=20")
            count[strength] = file["observables/fragments/value"][-1]
        self.assertEqual(count[40], 1)
        self.assertGreater(count[8], 100)

    @unittest.skipIf(BRIEF, "steps are slow")
    def test_peaks_are_those_of_the_page(self):
        file = self.result("compression")
        lid = file["observables/walls"][()].decode().split("\n").index("lid")
        force, width = file["observables/wall_normal/value"][:, lid], file["observables/width/value"][:]
        bonded = file["observables/bonds/value"][:] > 0
        peak = force[bonded].max() / width[~bonded].min()
        self.assertGreater(peak, 0.85)  # over the strength of the cement
        self.assertLess(peak, 1.0)


if __name__ == "__main__":
    unittest.main()
