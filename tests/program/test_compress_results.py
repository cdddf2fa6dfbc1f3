"""Results of a compressed box: edges of every frame, pressure and packing fraction, and the packing used again."""
import json
import pathlib
import tempfile
import unittest

import h5py
import numpy

from results_common import run

MATERIAL = 'materials = ( { name = "disk"; k_n = 1; k_t = 0.5; gamma_n = 0.3; mu = 0.2; } );\n'
MADE = 'dt = 0.1; integrator = "verlet"; contact_variant = "conservative";\n' + MATERIAL + """
container = { type = "periodic"; width = 18; height = 15; origin = (-2, 3); };
packings = ( { type = "random"; count = 100; density = 1; sizes = "list"; radii = (0.5, 0.7); } );
phases = ( { steps = 4000; compress = { fraction = 0.86; rate = 1e-3; }; frames = 500; series = 500; },
           { steps = 20000; relax = true; compress = { pressure = 5e-3; rate = 1e-3; };
             settle = { unbalanced = 1e-8; every = 500; }; series = 500; } );
"""
USED = 'dt = 0.1; integrator = "verlet"; contact_variant = "conservative";\n' + MATERIAL + """
box = { file = "made.h5"; periodic = "xy"; };
disk_files = ( { file = "made.h5"; dataset = "/particles/disks"; contacts = true; } );
steps = 10;
"""


class CompressedBox(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory(prefix="slipdisk-compress-")
        cls.where = pathlib.Path(cls.folder.name)
        for name, deck in ("made", MADE), ("used", USED):
            (cls.where / f"{name}.cfg").write_text(deck)
        cls.status, _, cls.err = run("run", cls.where / "made.cfg", "-o", cls.where / "made.h5", "--quiet")

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()

    def setUp(self):
        self.assertEqual(self.status, 0, self.err)
        self.file = h5py.File(self.where / "made.h5")

    def tearDown(self):
        self.file.close()

    def test_edges_of_every_frame(self):
        disks = self.file["particles/disks"]
        edges, position = disks["box/edges/value"], disks["position/value"]
        self.assertEqual(disks["box/edges/step"], disks["position/step"])
        self.assertEqual(edges.shape, (position.shape[0], 2))
        self.assertGreater(edges.shape[0], 8)
        self.assertEqual(edges.attrs["unit"], b"length")
        numpy.testing.assert_array_equal(edges[0], [18, 15])
        numpy.testing.assert_allclose(edges[:, 0] / edges[:, 1], 18 / 15, rtol=1e-14)
        self.assertLess(edges[-1, 0], 14)
        numpy.testing.assert_array_equal(disks["box"].attrs["lower"], [-2, 3])
        self.assertEqual([b.decode() for b in disks["box"].attrs["boundary"]], ["periodic", "periodic"])
        for frame in range(edges.shape[0]):
            offset = position[frame] - [-2, 3]
            self.assertTrue((offset >= 0).all() and (offset <= edges[frame] * (1 + 1e-12)).all(), frame)

    def test_series(self):
        o, disks = self.file["observables"], self.file["particles/disks"]
        edges = disks["box/edges/value"][-1]
        area = edges[0] * edges[1]
        fraction = numpy.pi * (disks["radius"][()] ** 2).sum() / area
        self.assertAlmostEqual(o["packing_fraction/value"][-1], fraction, delta=1e-12)
        self.assertEqual(o["pressure/step"], o["work/step"])

        c = self.file["contacts"]
        rows = slice(c["first"][-1], c["first"][-1] + c["count"][-1])
        x, radius = disks["position/value"][-1], disks["radius"][()]
        a, b, force = c["a"][rows], c["b"][rows], c["force"][rows]
        way = x[b] - x[a]
        way -= edges * numpy.round(way / edges)
        pressure = (force * numpy.hypot(*way.T)).sum() / (2 * area)
        self.assertAlmostEqual(o["pressure/value"][-1] / pressure, 1, delta=1e-12)
        self.assertAlmostEqual(pressure / 5e-3, 1, delta=1e-3)
        numpy.testing.assert_allclose(radius[a] + radius[b] - numpy.hypot(*way.T), c["overlap"][rows], atol=1e-12)

        e = {k: o[f"{k}/value"][-1] for k in ("work", "relaxed", "residual")}
        self.assertGreater(e["relaxed"], 0)
        self.assertLess(abs(e["residual"]), 1e-3 * e["work"])

    def test_info(self):
        status, out, err = run("info", self.where / "made.h5", "--json")
        self.assertEqual(status, 0, err)
        self.assertIn("relaxed", json.loads(out)["energy"])

    def test_used_again(self):
        status, _, err = run("run", self.where / "used.cfg", "-o", self.where / "used.h5", "--quiet")
        self.assertEqual(status, 0, err)
        with h5py.File(self.where / "used.h5") as used:
            numpy.testing.assert_allclose(used["particles/disks/box/edges"][()],
                                          self.file["particles/disks/box/edges/value"][-1], rtol=1e-15)
            self.assertEqual(used["state/contact_a"].shape, self.file["state/contact_a"].shape)
            force = self.file["state/contact_force"][()]
            # at rest it goes on at rest, with the same forces
            numpy.testing.assert_allclose(used["state/contact_force"][()], force, atol=1e-6 * force.mean())
            self.assertLess(used["observables/kinetic_translation/value"][-1], 1e-12)


if __name__ == "__main__":
    unittest.main()
