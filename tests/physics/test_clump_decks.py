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

    def run_text(self, name, text):
        deck, path = self.folder / f"{name}.cfg", self.folder / f"{name}.h5"
        deck.write_text(text)
        status, _, err = run("run", deck, "-o", path, "--quiet")
        self.assertEqual(status, 0, err)
        return path

    def measured(self, path, *words):
        status, out, err = run("measure", path, "--json", *words)
        self.assertEqual(status, 0, err)
        return json.loads(out)["frames"]

    @unittest.skipIf(BRIEF, "steps are slow")
    def test_a_file_says_what_the_walls_feel(self):
        path = self.run_text("pressed", PRESSED)
        with h5py.File(path) as file:
            last = {name: o["value"][-1] for name, o in file["observables"].items() if isinstance(o, h5py.Group) and "value" in o}
            unbalanced = file["summary/phase/unbalanced"][-1]
        (state,) = self.measured(path)
        stress, region = state["stress"]["contact"], state["region"]
        for c, (force, length) in enumerate((("wall_force_x", "height"), ("wall_force_y", "width"))):
            self.assertAlmostEqual(max(last[force]) / last[length], stress[c][c], 8)
            self.assertAlmostEqual(last["stress_" + "xy"[c] * 2], stress[c][c], 11)
        self.assertAlmostEqual(last["pressure"], state["stress"]["pressure"], 11)
        self.assertAlmostEqual(stress[0][1], stress[1][0], 8)
        self.assertAlmostEqual(state["contacts"]["unbalanced"], unbalanced, 12)
        self.assertEqual((state["disks"]["free"], state["disks"]["clumps"]), (46, 23))
        # contacts that are not stored are found again, without those of a clump's own disks
        *_, before, frame = self.measured(path, "--all")
        self.assertTrue(before["contacts"]["recomputed"])
        self.assertEqual(before["contacts"]["closed"], state["contacts"]["closed"])
        self.assertAlmostEqual(before["stress"]["pressure"], state["stress"]["pressure"], 3)
        # pressures on disks are those of their clumps
        tables = self.folder / "tables"
        status, _, err = run("measure", path, "--csv", tables)
        self.assertEqual(status, 0, err)
        rows = numpy.genfromtxt(tables / "disks.csv", delimiter=",", names=True)
        numpy.testing.assert_array_equal(rows["pressure"][0::2], rows["pressure"][1::2])
        if rows["closed"].all():
            self.assertAlmostEqual((rows["pressure"] * rows["cell"]).sum() / region["area"], state["stress"]["pressure"], 9)

    def test_a_file_knows_inertia_and_force_of_a_clump(self):
        path = self.run_text("given", GIVEN)
        (state,) = self.measured(path)
        self.assertAlmostEqual(state["stress"]["energy_rotation"], 7, 6)  # I w^2/2
        self.assertAlmostEqual(state["stress"]["energy_translation"], 3, 6)  # M v^2/2
        with h5py.File(path) as file:
            self.assertEqual(file["particles/clumps/constant_force"][:].tolist(), [[0, 0.5]])


PRESSED = """
integrator = "verlet"; contact_variant = "conservative"; dt = 1e-3;
materials = ( { name = "g"; k_n = 1e4; restitution = 0.3; }, { name = "smooth"; k_n = 1e4; } );
material_pairs = ( { materials = ("g", "smooth"); k_n = 1e4; restitution = 0.3; } );
container = { type = "box"; width = 12; height = 12; open = false; material = "smooth"; };
packings = ( { type = "random"; fraction = 0.4; radius = 0.5; density = 1; material = "g"; clump = { at = ([-0.8, 0], [0.8, 0]); }; } );
phases = ( { time = 100; compress = { pressure = 10; rate = 0.05; }; settle = { unbalanced = 0.01; }; },
           { time = 40; relax = true; settle = { unbalanced = 1e-9; every = 500; }; frames = 250; } );
output = { series = 100; };
measure = { stress = true; box = true; walls = true; rotation = (); };
"""
GIVEN = """
dt = 1e-3; time = 1e-3; gravity = { g = 0; };
materials = ( { name = "m"; k_n = 1; k_t = 0; mu = 0; gamma_n = 0; } );
disk_rows = ( { columns = ("x", "y"); radius = 1; mass = 0.7; rows = ((-0.8, 0), (0.8, 0)); } );
clumps = ( { disk = (0, 1); velocity = (1, 0); omega = 2; mass = 6; inertia = 3.5; force = (0, 0.5); } );
"""

if __name__ == "__main__":
    unittest.main()
