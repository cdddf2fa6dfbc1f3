"""Conveyors and arcs in whole runs: a packing that goes on with its contacts, what files and pictures know of arcs."""
import shutil
import unittest

import h5py
import numpy

from results_common import run
from sweep_common import temporary_folder

MATERIAL = """dt = 2e-5; gravity = { g = 9.81; };
materials = ( { name = "a"; k_n = 1e4; k_t = 5e3; gamma_n = 2; mu = 0.4; } );
walls = ( { name = "belt"; type = "segment"; points = ((-0.3, 0), (0.03, 0)); },
  { name = "bowl"; type = "arc"; center = (0.15, 0.19); radius = 0.2; from = -2.5; to = -0.9; },
  { name = "roller"; type = "circle"; center = (-0.4, -0.05); radius = 0.05; side = "outside"; } );
"""
FIRST = MATERIAL + """disk_rows = ( { columns = ("x", "y", "radius"); density = 3.57; rows = ((-0.15, 0.02, 0.02),
  (-0.1, 0.021, 0.02), (-0.05, 0.02, 0.02), (0.1, 0.04, 0.02), (0.15, 0.02, 0.02), (0.2, 0.02, 0.02), (-0.4, 0.0199, 0.02)); } );
locks = ( { disk = 6; coordinates = ("x", "theta"); } );
motions = ( { wall = ("belt", "bowl", "roller"); coordinate = "surface"; type = "velocity"; velocity = 3e-3; },
  { wall = "bowl"; coordinate = "theta"; type = "harmonic"; amplitude = 0.05; frequency = 1; } );
steps = 12345; output = { frames = 5000; series = 1000; contacts = 5000; };
"""
SECOND = MATERIAL + """disk_files = ( { file = "first.h5"; contacts = true; } );
steps = 1; output = { frames = 1; contacts = 1; };
"""


class WallRuns(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = temporary_folder()
        cls.addClassCleanup(shutil.rmtree, cls.folder)

    def slipdisk(self, *words, **more):
        status, out, err = run(*words, **more)
        self.assertEqual(status, 0, err)
        return out

    def both_runs(self, law=""):
        for name, text in ("first", FIRST), ("second", SECOND):
            if law:  # the surface of a round wall with rolling resistance is refused
                text = text.replace("mu = 0.4;", "mu = 0.4;" + law).replace('"bowl", "roller")', '"bowl")')
            (self.folder / f"{name}.cfg").write_text(text)
            self.slipdisk("run", self.folder / f"{name}.cfg", "-q", "--force", "-o", self.folder / f"{name}.h5")

    def test_rolling_goes_on(self):
        """So does the rolling displacement, with the R_eff of each wall."""
        self.both_runs(" k_r = 2e3; mu_r = 0.3;")
        with h5py.File(self.folder / "first.h5") as one, h5py.File(self.folder / "second.h5") as two:
            before, after = (file["state/contact_rho"][()] for file in (one, two))
            self.assertLessEqual({7, 8, 9}, set(one["state/contact_b"][()]))
            numpy.testing.assert_allclose(after, before, atol=5e-7)
            self.assertGreater(abs(before).max(), 2e-6)

    def test_a_packing_goes_on(self):
        """Arcs stand as they were turned, and surfaces begin anew: no stretch of a contact changes by more than a step can."""
        self.both_runs()
        with h5py.File(self.folder / "first.h5") as one, h5py.File(self.folder / "second.h5") as two:
            self.assertGreater(abs(one["state/surface"][()]).min(), 5e-4)
            self.assertGreater(abs(one["state/theta"][-2]), 0.04)
            pairs = [list(zip(file["state/contact_a"][()], file["state/contact_b"][()])) for file in (one, two)]
            self.assertEqual(pairs[0], pairs[1])
            self.assertLessEqual({7, 8, 9}, {b for _, b in pairs[0]})
            before, after = (file["state/contact_zeta"][()] for file in (one, two))
            numpy.testing.assert_allclose(after, before, atol=5e-7)
            self.assertGreater(abs(before).max(), 2e-6)
            shape = one["particles/walls/shape"]
            self.assertEqual(list(shape["kind"][()]), [1, 4, 3])
            points = shape["points"][()]
            arc = points[2:2 + shape["count"][1]]
            numpy.testing.assert_allclose(numpy.hypot(*(arc - [0.15, 0.19]).T), 0.2, atol=1e-15)
        for form in "csv", "vtk", "lammps-data":
            self.slipdisk("export", self.folder / "first.h5", "--to", form, "-o", self.folder / f"out-{form}")
        self.assertIn("wall 1 bowl: arc", (self.folder / "out-lammps-data").read_text())


if __name__ == "__main__":
    unittest.main()
