"""Series that a deck asks for: forces on walls, groups and chosen disks, size and stress of the region; against closed
forms, contact tables, frames, and `slipdisk measure`."""
import json
import sys
import unittest

import h5py
import numpy as np

import results_common
from results_common import run

MATERIAL = 'materials = ( { name = "m"; k_n = 1e5; k_t = 5e4; gamma_n = 20.0; mu = 0.4; } );\n'
HEAD = 'integrator = "%s"; contact_variant = "%s"; dt = 2e-4;\n' + MATERIAL
BOX = """
gravity = { g = 10.0; };
container = { type = "box"; width = 1.0; height = 1.5; };
disks = ( { name = "grain"; x = 0.1; y = 0.06; radius = 0.05; density = 100.0; group = "red"; } );
packings = ( { type = "rain"; count = 40; rows = 1; sizes = "uniform"; lower = 0.05; upper = 0.08; density = 100.0;
  y = (0.2, 1.5); group = "blue"; } );
phases = ( { steps = %d; }, { steps = 500; } );
output = { series = 500; frames = 500; contacts = 500; };
measure = { walls = true; groups = true; contacts = ("grain", 5); box = true; stress = true; rattlers = true; };
"""
# Disks go beyond the periodic edges; one moves through the fixed one's neighbourhood.
PERIODIC = """
box = { x = (0, 1); y = (0, 1); periodic = "xy"; };
packings = ( { type = "random"; count = 40; sizes = "uniform"; lower = 0.03; upper = 0.05; density = 100.0; group = "red"; },
             { type = "random"; count = 20; sizes = "uniform"; lower = 0.03; upper = 0.05; density = 50.0; group = "blue"; } );
disks = ( { x = 0.5; y = 0.5; radius = 0.1; fixed = true; density = 1; },
          { x = 0.1; y = 0.1; radius = 0.05; vx = 3; omega = 40; density = 100; } );
phases = ( { steps = 3000; series = 300; frames = 300; contacts = 300; compress = { fraction = 0.9; rate = 1; }; },
           { steps = 3000; series = 300; frames = 300; contacts = 300; } );
measure = { groups = true; box = true; stress = true; rattlers = true; };
"""


def near(got, expected, tolerance):
    """Within `tolerance` of the largest."""
    got, expected = np.asarray(got, float), np.asarray(expected, float)
    assert got.shape == expected.shape, (got.shape, expected.shape)
    return np.abs(got - expected).max() <= tolerance * max(np.abs(expected).max(), 1e-300)


class Series(results_common.Folder):
    def make(self, deck, *words):
        self.deck = self.folder / "deck.cfg"
        self.deck.write_text(deck)
        self.run_ok("run", self.deck, "-o", self.result, "--quiet", "--force", *words)

    def columns(self, file):
        group = file["observables"]
        return {name: group[name]["value"][:] for name in group if isinstance(group[name], h5py.Group)}

    def tables(self, file):
        """Of every row of the series its contact table; they were taken together."""
        c = file["contacts"]
        self.assertEqual(list(c["step"]), list(file["observables/contacts/step"]))
        for first, count in zip(c["first"][:], c["count"][:]):
            yield {name: c[name][first:first + count] for name in ("a", "b", "force", "tau", "sliding")}

    def names(self, file, what):
        return file[f"observables/{what}"][()].decode().split()

    def test_one_disk_on_an_incline(self):
        """A disk at rest between a tilted floor and a step: N and T are those of statics."""
        tilt = 0.3
        self.make(HEAD % ("verlet", "paper") + """
gravity = { g = 10.0; tilt = %g; };
disks = ( { x = 0.0; y = 1.0; radius = 1.0; mass = 2.0; } );
walls = ( { type = "line"; points = ((-1, 0), (1, 0)); }, { name = "step"; type = "line"; points = ((-1, 0), (-1, 1)); } );
phases = ( { time = 40; relax = true; settle = { unbalanced = 1e-12; every = 100; }; } );
measure = { walls = true; contacts = 0; };
""" % tilt)
        with h5py.File(self.result) as file:
            c = {name: values[-1] for name, values in self.columns(file).items()}
            self.assertEqual(file["observables/walls"][()].decode(), "wall 0\nstep\n")
            self.assertEqual(list(file["observables/contact_disks"]), [0])
            self.assertEqual(file["observables/wall_torque/value"].attrs["unit"], b"force length")
        self.assertTrue(near([*c["wall_force_x"], *c["wall_force_y"]],
                             [-c["wall_tangential"][0], -c["wall_normal"][1], -c["wall_normal"][0], c["wall_tangential"][1]], 1e-12))
        # no torque on the disk: the two tangential forces are equal and opposite
        self.assertAlmostEqual(c["wall_tangential"].sum(), 0, 9)
        self.assertAlmostEqual(c["wall_force_x"].sum(), -20 * np.sin(tilt), 8)
        self.assertAlmostEqual(c["wall_force_y"].sum(), -20 * np.cos(tilt), 8)
        self.assertTrue(near(c["wall_contacts"], [1, 1], 0))
        self.assertAlmostEqual(c["disk_normal"][0], c["wall_normal"].sum(), 12)
        self.assertAlmostEqual(c["disk_force_y"][0], 20 * np.cos(tilt), 8)

    def test_weight_on_the_floor(self):
        """At rest floor and sides carry the weight; the stress of a box is that of its walls."""
        self.make(HEAD % ("gear5", "paper") + BOX % 20000 + """
motions = ( { name = "lid"; wall = "lid"; coordinate = "y"; type = "servo"; force = -50; speed = 0.2; } );
""", "-D", "container.open=false", "-D", "phases[0].motions=()", "-D", "phases[1].motions=lid",
                  "-D", "phases[1].steps=400000", "-D", "phases[1].settle.unbalanced=1e-8")
        with h5py.File(self.result) as file:
            c = {name: values[-1] for name, values in self.columns(file).items()}
            weight = 10 * file["particles/disks/mass"][:].sum()
            floor, left, right, lid = (self.names(file, "walls").index(n) for n in ("floor", "left", "right", "lid"))
            self.assertEqual(self.names(file, "groups"), ["red", "blue"])
        x, y, height = c["wall_force_x"], c["wall_force_y"], c["height"]
        self.assertAlmostEqual(y[lid], 50, 4)
        self.assertAlmostEqual(y.sum() / -weight, 1, 6)
        self.assertAlmostEqual(c["group_force_y"].sum() / weight, 1, 6)
        self.assertGreater(abs(y[left]) + abs(y[right]), 1e-3 * weight)
        self.assertTrue(near(c["wall_normal"], [-y[floor], -x[left], x[right], y[lid]], 1e-9))
        self.assertTrue(near(c["wall_tangential"], [-x[floor], y[left], -y[right], x[lid]], 1e-9))
        self.assertLess(height, 1.2)
        self.assertEqual(c["width"], 1.0)

    def test_walls_of_a_compressed_box(self):
        """Without gravity and friction sigma_xx of a box at rest is the force on its sides over its height."""
        self.make(HEAD % ("verlet", "paper") + """
container = { type = "box"; width = 1.0; height = 1.5; open = false; };
packings = ( { type = "random"; count = 60; sizes = "uniform"; lower = 0.05; upper = 0.08; density = 100.0; } );
phases = ( { steps = 200000; relax = true; series = 500; settle = { unbalanced = 1e-9; };
  compress = { pressure = 5.0; rate = 1.0; }; } );
measure = { walls = true; box = true; stress = true; };
""", "-D", "materials[0].mu=0", "-D", "materials[0].k_t=0")
        with h5py.File(self.result) as file:
            series = self.columns(file)
            scale = file["particles/disks/box/scale/value"][-1]
        c = {name: values[-1] for name, values in series.items()}
        floor, left, right, lid = range(4)
        self.assertLess(scale, 0.99)
        self.assertTrue(near([c["width"], c["height"]], [scale, 1.5 * scale], 1e-12))
        self.assertTrue(near(series["height"] / series["width"], np.full(len(series["width"]), 1.5), 1e-12))
        for a, b, stress, length in ((left, right, "stress_xx", c["height"]), (floor, lid, "stress_yy", c["width"])):
            self.assertAlmostEqual(c["wall_normal"][a] / c["wall_normal"][b], 1, 7)
            self.assertAlmostEqual(c[stress] / (c["wall_normal"][a] / length), 1, 7)
        self.assertAlmostEqual((c["stress_xx"] + c["stress_yy"]) / 2 / c["pressure"], 1, 7)
        self.assertAlmostEqual(c["pressure"] / 5, 1, 2)
        self.assertFalse(c["wall_tangential"].any())

    def test_sums_of_contact_tables(self):
        # directions are those of the positions; with Gear the engine's forces belong to the predicted ones
        for integrator, variant, bound in (("gear5", "paper", 1e-5), ("verlet", "conservative", 1e-10)):
            self.make(HEAD % (integrator, variant) + BOX % 8000)
            with h5py.File(self.result) as file:
                c = self.columns(file)
                disks = file["particles/disks/group"][:]
                groups = np.concatenate([disks, [-1, -1, -1]])
                for row, table in enumerate(self.tables(file)):
                    a, b = table["a"].astype(int), table["b"].astype(int)
                    of = {"wall": [b == 41 + k for k in range(3)], "disk": [(a == k) | (b == k) for k in (0, 5)],
                          "group": [(groups[a] == k) != (groups[b] == k) for k in range(2)]}
                    for what, members in of.items():
                        for k, mine in enumerate(members):
                            self.assertEqual(c[what + "_contacts"][row, k], mine.sum())
                            self.assertEqual(c[what + "_sliding"][row, k], (table["sliding"][mine] != 0).sum())
                            self.assertAlmostEqual(c[what + "_normal"][row, k], table["force"][mine].sum(), 9)
                            self.assertAlmostEqual(c[what + "_tangential"][row, k], table["tau"][mine].sum(), 9)
                self.assertGreater(c["wall_sliding"].max() + c["group_sliding"].max(), 0)
                # a group of one disk
                for name in ("force_x", "force_y", "torque", "normal", "tangential", "contacts"):
                    self.assertTrue(near(c["group_" + name][:, 0], c["disk_" + name][:, 0], bound), name)
                for name in "force_x", "force_y":  # actio = reactio
                    self.assertTrue(near(c["group_" + name].sum(1), -c["wall_" + name].sum(1), bound), name)
                # nothing is in play but one disk; the rest waits
                self.assertEqual(c["wall_contacts"][0].sum(), 0)

    def test_groups_in_a_periodic_box(self):
        """Against forces from tables and positions; those on all groups and on the disks of none add up to zero."""
        self.make(HEAD % ("verlet", "paper") + PERIODIC)
        with h5py.File(self.result) as file:
            c, p = self.columns(file), file["particles/disks"]
            self.assertEqual(list(p["position/step"]), list(file["contacts/step"]))
            radius, mass, group = p["radius"][:], p["mass"][:], p["group"][:]
            self.assertTrue(p["image/value"][-1].any())
            for row, table in enumerate(self.tables(file)):
                a, b = table["a"].astype(int), table["b"].astype(int)
                edges, at = p["box/edges/value"][row], p["position/value"][row]
                self.assertTrue(near([c["width"][row], c["height"][row]], edges, 1e-14))
                d = at[b] - at[a]
                d -= edges * np.round(d / edges)
                n = d / np.hypot(*d.T)[:, None]
                force = table["force"][:, None] * n + table["tau"][:, None] * np.stack([n[:, 1], -n[:, 0]], 1)
                absolute = at + p["image/value"][row] * edges
                for k in range(2):
                    mine = group == k
                    centre = mass[mine] @ absolute[mine] / mass[mine].sum()
                    total, torque = np.zeros(2), 0.0
                    for sign, one, other in ((-1, a, b), (1, b, a)):
                        outside = mine[one] & ~mine[other]
                        total += sign * force[outside].sum(0)
                        arm = absolute[one] - centre
                        torque += (sign * (arm[:, 0] * force[:, 1] - arm[:, 1] * force[:, 0]) +
                                   radius[one] * table["tau"])[outside].sum()
                    scale = max(c["group_normal"][row, k], 1e-9)
                    self.assertTrue(near([c["group_force_x"][row, k], c["group_force_y"][row, k]], total, 1e-9) or
                                    np.abs(total).max() < 1e-9 * scale)
                    self.assertLess(abs(c["group_torque"][row, k] - torque), 1e-9 * scale)
            self.assertGreater(c["group_normal"].min(1).max(), 0.1)

    def test_stress_and_size_are_those_of_measure(self):
        for deck in BOX % 8000, PERIODIC:
            self.make(HEAD % ("gear5", "paper") + deck)
            with h5py.File(self.result) as file:
                c = self.columns(file)
                steps = list(file["observables/contacts/step"])
                self.assertEqual(steps, list(file["particles/disks/position/step"]))
            frames = json.loads(self.run_ok("measure", self.result, "--all", "--json")[0])["frames"]
            self.assertEqual(steps, [f["step"] for f in frames])
            for part in "contact", "kinetic":
                name = "stress" if part == "contact" else "kinetic"
                tensor = np.array([f["stress"][part] for f in frames])
                for ending, i, j in (("xx", 0, 0), ("xy", 0, 1), ("yx", 1, 0), ("yy", 1, 1))[:3 if part == "kinetic" else 4]:
                    if part == "kinetic" and ending == "yx":
                        ending, i, j = "yy", 1, 1
                    self.assertTrue(near(c[f"{name}_{ending}"], tensor[:, i, j], 1e-12), ending)
            for name, side in (("width", "x"), ("height", "y")):
                self.assertTrue(near(c[name], [np.diff(f["region"][side])[0] for f in frames], 1e-14))
            self.assertGreater(c["stress_yy"].max(), 0)
            self.assertEqual(list(c["rattlers"]), [f["disks"]["rattlers"] for f in frames])
            z = np.array([f["contacts"]["z_backbone"] for f in frames], float)
            np.testing.assert_array_equal(c["z_backbone"], z)
            self.assertGreater(np.nanmax(z), 2)
            self.assertLess(0, max(c["rattlers"]))

    def test_nothing_in_play(self):
        """While all disks wait there is no force, and where no disk is and no region, no size."""
        self.make(HEAD % ("gear5", "paper") + BOX % 1000, "-D", "phases[1].series=1", "-D", "disks=()", "-D",
                  "measure.contacts=5")
        with h5py.File(self.result) as file:
            c = self.columns(file)
            self.assertEqual(c["stress_xx"][0], 0)
            self.assertEqual((c["width"][0], c["height"][0]), (1, 1.5))

    def test_only_when_asked(self):
        deck = HEAD % ("gear5", "paper") + BOX % 1000
        self.make(deck, "-D", "measure={}")
        with h5py.File(self.result) as file:
            names = set(file["observables"])
        self.make(deck)
        with h5py.File(self.result) as file:
            more = set(file["observables"]) - names
        self.assertEqual({name.split("_")[0] for name in more},
                         {"wall", "walls", "group", "groups", "disk", "contact", "width", "height", "stress", "kinetic",
                          "rattlers", "z"})
        self.assertEqual(len(more), 3 * 7 + 2 + 7 + 3 + 2)

    def test_mistakes(self):
        deck = self.folder / "deck.cfg"
        deck.write_text(HEAD % ("gear5", "paper") + 'steps = 10; disks = ( { name = "one"; x = 0; y = 0; radius = 1; mass = 1; } );')
        for key, message in (("walls=true", "measure.walls = true: there are no walls"), ("groups=true", "no disk has a group"),
                             ("contacts=two", 'measure.contacts = "two": no disk is called that'),
                             ("contacts=(0, 0)", "named twice"), ("contacts=7", "expected"), ("box=3", "expected")):
            status, _, err = run("check", deck, "-D", f"measure.{key}")
            self.assertEqual(status, 2, key)
            self.assertIn(message, err)


if __name__ == "__main__":
    sys.exit(unittest.main(verbosity=1))
