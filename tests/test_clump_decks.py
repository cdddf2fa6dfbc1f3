"""The decks of inputs/clumps, shortened: their budgets close, and results tell of clumps what their disks tell."""
import json
import os
import pathlib
import tempfile
import unittest

import h5py
import numpy

from results_common import ROOT, run

BRIEF = "SLIPDISK_BRIEF" in os.environ
MOST = 1e-6  # residual over the scale of the budget


class Clumps(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix="slipdisk-clumps-")
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def result(self, name, *settings):
        path = self.folder / f"{name}.h5"
        words = [word for setting in settings for word in ("-D", setting)]
        status, _, err = run("run", ROOT / f"inputs/clumps/{name}.cfg", *words, "-o", path, "--quiet", "--threads", 1)
        self.assertIn(status, (0, 5), err)
        file = h5py.File(path)
        self.addCleanup(file.close)
        return path, file

    def check_poses(self, file):
        """Centres of mass of the disks, beyond the edges of the box, are those of the clumps, at every frame."""
        disks, clumps = file["particles/disks"], file["particles/clumps"]
        member, mass = disks["clump"][:], disks["mass"][:]
        edges = disks["box/edges"][:] if "edges" in disks["box"] else numpy.zeros(2)
        total = numpy.bincount(member, mass)[1:]
        numpy.testing.assert_allclose(total, clumps["mass"][:], rtol=1e-12)
        for frame in range(len(disks["position/value"])):
            at = disks["position/value"][frame] + disks["image/value"][frame] * edges
            centre = clumps["position/value"][frame] + clumps["image/value"][frame] * edges
            for k in range(2):
                found = numpy.bincount(member, mass * at[:, k])[1:] / total
                numpy.testing.assert_allclose(found, centre[:, k], atol=1e-12)

    def check_budget(self, file):
        energy = dict(file["summary/energy"].attrs)
        self.assertLess(abs(energy["residual"]), MOST * energy["scale"])
        return energy

    def test_decks_are_checked_without_a_warning(self):
        for deck in sorted((ROOT / "inputs/clumps").glob("*.cfg")):
            with self.subTest(deck.name):
                status, _, err = run("check", deck)
                self.assertEqual((status, err), (0, ""))

    @unittest.skipIf(BRIEF, "steps are slow")
    def test_dimers_fall_and_touch(self):
        _, file = self.result("dimers", "packings[0].count=60", "container.width=0.2", "phases[0].time=0.5",
                              "output.frames=10000")
        self.check_poses(file)
        self.assertGreater(self.check_budget(file)["friction"], 0)

    def test_a_result_with_clumps_begins_no_other_deck(self):
        path, _ = self.result("dimers", "packings[0].count=20", "container.width=0.2", "phases[0].time=1e-4")
        start = self.folder / "start.cfg"
        deck = """integrator = "verlet"; dt = 2e-5; time = 1e-3;
materials = ( { name = "grain"; k_n = 1e4; } );
disk_files = (
  { file = "dimers.h5"; MORE } );
"""
        refused = f'{start}:4: disk_files[0].file = "dimers.h5": it has 20 clumps, which are not read'
        for more, expected in (("", refused), ("contacts = true;", refused),
                               ('columns = ("x", "y", "radius", "mass"); dataset = "/particles/disks";', None)):
            start.write_text(deck.replace("MORE", more))
            status, _, err = run("check", start, "--brief", "--no-probe")
            self.assertEqual(status, 2 if expected else 0, err)
            self.assertIn(expected or "", err)
        status, out, _ = run("info", path)
        self.assertIn("40 disks, 20 clumps, ", out)
        status, out, _ = run("info", path, "--json")
        self.assertEqual(json.loads(out)["clumps"], 20)
        status, out, _ = run("check", ROOT / "inputs/clumps/plate.cfg", "--no-probe")
        self.assertRegex(out, r"# clumps      1, of 15 disks")

    @unittest.skipIf(BRIEF, "steps are slow")
    def test_a_plate_is_drawn_and_bears_its_load(self):
        path, file = self.result("plate", "phases[1].time=0.4")
        self.check_poses(file)
        self.check_budget(file)
        clumps = file["particles/clumps"]
        x = clumps["position/value"][-1, 0, 0] + 0.6 * clumps["image/value"][-1, 0, 0]
        started = clumps["position/value"][0, 0, 0]
        self.assertAlmostEqual(clumps["velocity/value"][-1, 0, 0], 0.2, 12)
        self.assertAlmostEqual(x - started, 0.2 * 0.4, 12)
        self.assertEqual(clumps["angle/value"][-1, 0], 0)
        self.assertLess(clumps["force/value"][-1, 0, 0], 0)  # the grains hold it back
        out = self.folder / "plate.dump"
        status, _, err = run("export", path, "-o", out, "--to", "lammps-dump")
        self.assertEqual(status, 0, err)
        frame = out.read_text().split("ITEM: ATOMS")[-1].splitlines()[1:]
        self.assertEqual(sum(line.split()[2] == "1" for line in frame), 15)


if __name__ == "__main__":
    unittest.main()
