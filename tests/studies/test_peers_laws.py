"""The laws beside LAMMPS (tools/compare_peers.sh --laws): what is computed and read, from made-up data and closed
forms; and, where LAMMPS is installed, whether collisions with the same law are the same."""
import math
import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

import h5py
import numpy

ROOT = pathlib.Path(os.environ.get("SLIPDISK_SOURCE_DIR", pathlib.Path(__file__).resolve().parents[2]))
PROGRAM = os.environ.get("SLIPDISK_PROGRAM", str(ROOT / "build/release/slipdisk"))
sys.path.insert(0, str(ROOT / "tools"))
sys.dont_write_bytecode = True

from peers import bench, frames, law_page, law_runs, laws, page, programs  # noqa: E402


def setup(folder, lammps=None):
    return bench.Setup(PROGRAM, folder, lammps=lammps, say=lambda text: None)


def linear_e(k, gamma, mass, limited):
    """docs/physics.md: with the force cut off at 0, and without."""
    b = gamma / (2 * mass)
    w = math.sqrt(k / mass - b * b)
    turn = math.pi - math.atan2(2 * b * w, w * w - b * b) if limited else math.pi
    return math.exp(-b * turn / w)


class Numbers(unittest.TestCase):
    def test_restitution(self):
        """The integrated collision has the closed form of the linear law."""
        for limited in (True, False):
            found = laws.restitution(lambda d: 1e4 * d, lambda d: 0.5, 3.6e-4, 0.3, limited)
            self.assertAlmostEqual(found, linear_e(1e4, 0.5, 3.6e-4, limited), 6)

    def test_tsuji(self):
        """The polynomial is right for a damping with the mass of a sphere, twice m_eff: LAMMPS' e is larger."""
        mass, radius = 3.6e-4, 0.004
        k = laws.K_HERTZ * math.sqrt(radius)
        for e in (0.3, 0.6, 0.9):
            for speed in (0.01, 1.0):
                found = [laws.restitution(lambda d: k * d**1.5,
                                          lambda d, c=laws.tsuji(e) * math.sqrt(m * k): c * d**0.25, mass, speed, False)
                         for m in (2 * mass, mass)]
                self.assertAlmostEqual(found[0], e, delta=0.01)
                self.assertAlmostEqual(found[1], laws.tsuji_e(e), delta=1e-5)
        self.assertLess(abs(laws.tsuji(1)), 1e-3)

    def test_numbers_of_pairs(self):
        """LAMMPS multiplies by m_eff and R_eff; each pair of materials has the product."""
        text = laws.materials(laws.LAWS["hooke, mass_velocity"])
        for pair in (("a", "a"), ("a", "b"), ("b", "w")):
            self.assertIn(f"gamma_n = {laws.MASS_RATE * laws.effective(*pair)[1]!r};", text)
        self.assertEqual(laws.effective("b", "w"), (laws.RADII["b"], laws.MASSES["b"]))
        radius, mass = laws.effective("a", "b")
        self.assertAlmostEqual(radius, 0.0048)
        self.assertAlmostEqual(1 / mass, 1 / laws.MASSES["a"] + 1 / laws.MASSES["b"])
        self.assertIn(f"k_n = {laws.K_HERTZ * math.sqrt(0.008)!r};", laws.materials(laws.LAWS["mindlin"]))

    def test_viscoelastic(self):
        """Its restitution falls with the speed; the number that stands for it is right at one speed."""
        radius, mass = laws.effective("a", "a")
        slow, own, fast = (laws.viscoelastic_e(radius, mass, speed) for speed in (0.01, laws.MATCHED, 1.0))
        self.assertTrue(0.2 < fast < own < slow < 1)
        self.assertEqual(laws.LAWS["hertz, viscoelastic"].keys(radius, mass)["restitution"], own)


class Starts(unittest.TestCase):
    def test_pairs_touch_at_the_same_time(self):
        it = law_runs.pairs()
        time = (law_runs.BEFORE + 0.5) * law_runs.DT
        x, y = ((numpy.array(place) + time * speed).reshape(-1, 2) for place, speed in ((it.x, it.vx), (it.y, it.vy)))
        numpy.testing.assert_allclose(x[:, 1] - x[:, 0], it.radius.reshape(-1, 2).sum(axis=1), rtol=1e-14)
        numpy.testing.assert_allclose(y[:, 1] - y[:, 0], 0, atol=1e-15)
        speed = numpy.hypot(*((numpy.array(v).reshape(-1, 2) @ (1, -1)) for v in (it.vx, it.vy)))
        numpy.testing.assert_allclose(speed, (*law_runs.SPEEDS, *[law_runs.SPEED] * len(law_runs.ANGLES)))

    def test_collisions(self):
        """Surfaces that move on as they came, and half the speed along the normal."""
        it = law_runs.pairs()
        end = frames.Frame(1, it.x, it.y, -it.vx / 2, it.vy, it.omega, 0.0)
        e, oblique = law_runs.collisions(it, end)
        numpy.testing.assert_allclose(e, 0.5)
        expected = [math.degrees(math.atan(2 * math.tan(math.radians(angle)))) for angle in law_runs.ANGLES]
        numpy.testing.assert_allclose([row[0] for row in oblique], expected)
        # A spin that brings the surfaces of both to rest.
        relative = (it.vy.reshape(-1, 2) @ (1, -1)).repeat(2)
        end = frames.Frame(1, it.x, it.y, -it.vx, it.vy, -relative / 2 / it.radius, 0.0)
        numpy.testing.assert_allclose([row[0] for row in law_runs.collisions(it, end)[1]], 0, atol=1e-12)

    def test_packing(self):
        """Three disks: two on the floor, one on both."""
        a, depth = laws.RADII["a"], 1e-5
        x = numpy.array([0.0, 2 * a - depth, a - depth / 2])
        y = numpy.array([a - depth, a, a + math.sqrt(3) * a + 1e-6])
        zero = numpy.zeros(3)
        it = law_runs.Disks(["a", "a", "a"], x, y, zero, zero, zero)
        height, contacts, elastic, kinetic = law_runs.packed(laws.LAWS["hooke"], it,
                                                             frames.Frame(1, x, y, zero, zero, zero, 0.0))
        reach = [math.hypot(x[2] - x[k], y[2] - y[k]) for k in (0, 1)]
        closed = [2 * a - r for r in reach if r < 2 * a] + [2 * a - math.hypot(x[1] - x[0], y[1] - y[0])]
        self.assertAlmostEqual(height, y.mean())
        self.assertAlmostEqual(contacts, (2 * len(closed) + 1) / 3)
        self.assertAlmostEqual(elastic, laws.K / 2 * (sum(d * d for d in closed) + depth**2) / 3)
        self.assertEqual(kinetic, 0)
        loose = law_runs.loose(1)
        self.assertEqual(law_runs.packed(laws.LAWS["hooke"], loose, loose_frame(loose))[1], 0)

    def test_means(self):
        self.assertEqual(law_runs.mean([[1, 5], [3, 5]]), ([2, 5], [1, 0]))


def loose_frame(it):
    return frames.Frame(0, it.x, it.y, it.vx, it.vy, it.omega, 0.0)


class Page(unittest.TestCase):
    @staticmethod
    def found(lammps):
        def one(shift):
            return [[0.5 + shift] * len(law_runs.SPEEDS), [[10.0 - 20 * shift, 0.1]] * len(law_runs.ANGLES)]

        own = {"slipdisk": one(0), **({"LAMMPS": one(0.001)} if lammps else {})}
        it = {"collisions": own, "rolling": {who: [0.1, 0.2, 0.3] for who in own},
              "packing": {who: ([0.1, 3.0, 1e-6, 0], [0.003, 0.1, 1e-7, 0]) for who in own}}
        steps = {"e": 0.5, "rows": [(1e-6, {who: (0.501, [1.0] * 6) for who in own})]}
        return {"seeds": 4, "laws": {"rolling sds": it}, "steps": steps}

    def test_tables(self):
        text = "\n".join(law_page.render(self.found(True)))
        self.assertIn("| rolling sds | +1.0e-03 | -2.0e-02 | +0.0e+00 |", text)
        self.assertIn("| rolling sds | 0.5000 / 0.5010 |", text)
        self.assertIn("| rolling sds | 100.000 / 100.000 | +0.0 |", text)
        self.assertIn("| 1e-06 | +1.0e-03 | +1.0e-03 |", text)
        self.assertIn("| 0.1 m/s | 0.038226 | 0.200000 | 0.200000 |", text)

    def test_without_lammps(self):
        text = "\n".join(law_page.render(self.found(False)))
        self.assertIn("| rolling sds | 0.5000 |", text)
        self.assertNotIn("Largest difference", text)

    def test_page_that_ships(self):
        """Laws of the pages are laws of the table; each has a row in all tables, and no cell is cut by a stroke."""
        for path, cells in (("tools/peers/laws.md", [5, 6, 7, 7]), ("docs/performance.md", [5])):
            text = (ROOT / path).read_text().split("<!-- laws -->\n")[1].split("<!-- end of laws -->")[0]
            rows = [line.split(" | ") for line in text.splitlines() if line.startswith("| ")]
            shown = {row[0][2:] for row in rows} & set(laws.LAWS)
            self.assertIn("hooke", shown)
            for name in shown:
                self.assertEqual([len(row) for row in rows if row[0] == "| " + name], cells, name)
        self.assertIn("laws", page.PARTS)

    def test_both_pages_say_the_same(self):
        """The page has the first table and that of the time steps; numbers are those of all tables."""
        whole, brief = ((ROOT / path).read_text().split("<!-- laws -->\n")[1].split("<!-- end of laws -->")[0]
                        for path in ("tools/peers/laws.md", "docs/performance.md"))
        self.assertGreater(brief.count("\n| "), 10)
        for line in brief.splitlines():
            self.assertIn(line + "\n", whole)
        text = "\n".join(law_page.brief(self.found(True)))
        self.assertIn("| rolling sds | +1.0e-03 |", text)
        self.assertIn("| 1e-06 | +1.0e-03 | +1.0e-03 |", text)
        self.assertNotIn("100.000", text)


class Own(unittest.TestCase):
    def test_every_law(self):
        """Decks of all laws run; restitution is that of the integrated collision."""
        radius, mass = laws.effective("a", "a")
        with tempfile.TemporaryDirectory() as folder:
            found = {name: law_runs.collide(setup(folder), law, name.replace("/", "-"))["slipdisk"]
                     for name, law in laws.LAWS.items()}
        for name, (e, _) in found.items():
            keys = laws.LAWS[name].keys(radius, mass)
            if "restitution" in keys:
                numpy.testing.assert_allclose(e, keys["restitution"], rtol=2e-4, err_msg=name)
                continue
            hertz = keys.get("law") == "hertz"

            def force(d, k=keys, power=1.5 if hertz else 1):
                return k["k_n"] * d**power - k.get("pull_off", 0)

            for got, speed in zip(e, law_runs.SPEEDS):
                # dmt: the pull-off acts on the way in and on the way out, while the disks touch.
                expected = laws.restitution(force, lambda _d, k=keys: k["gamma_n"], mass, speed,
                                            keys.get("limit_damping", True))
                if expected:
                    # A force that pulls ends with a jump: its error is of first order in dt.
                    self.assertAlmostEqual(got, expected, delta=2e-4 if keys.get("limit_damping", True) else 1e-3,
                                           msg=name)
                else:                           # held by the pull-off
                    self.assertLess(abs(got), 0.1, name)

    def test_rolling(self):
        with tempfile.TemporaryDirectory() as folder:
            law = laws.LAWS["rolling sds"]
            start = law_runs.rolling(law)
            end = law_runs.run_both(setup(folder), law, start, "rolling", law_runs.ROLL_DT, 250000, True,
                                    law_runs.PLANE)["slipdisk"][-1]
        for k, speed in enumerate(law_runs.ROLL_SPEEDS):
            self.assertAlmostEqual((end.x[k] - start.x[k]) / law_runs.expected_rolling(speed), 1, delta=2e-3)
            self.assertLess(abs(end.omega[k]), 1e-6)


class Alike(unittest.TestCase):
    def test_collisions(self):
        """Laws that are the same but for the arm of the tangential force."""
        with tempfile.TemporaryDirectory() as folder:
            for name in ("hooke", "hooke, mass_velocity", "hertz, velocity", "rolling sds"):
                found = law_runs.collide(setup(folder, programs.find("lammps")), laws.LAWS[name], "alike")
                e, angle, spin = law_page.differences({"collisions": found})
                self.assertLess(abs(e), 2e-3, name)
                self.assertLess(abs(angle), 0.3, name)
                self.assertLess(abs(spin), 3e-3, name)

    # Two spheres, or one on a wall, overlap by DEPTH and are sheared by 1e-6: force and torque of hertz/material.
    MODULUS, NU, MU, DEPTH = 1e7, 0.3, 1.0, 2e-6
    LAMMPS = """units si
dimension 2
atom_style sphere
boundary f f p
newton off
comm_modify vel yes
region box block -1 1 -1 1 -0.1 0.1
create_box 1 box
create_atoms 1 single {x} 0 0
{second}
set atom 1 diameter {diameter}
set group all density 1000
group one id 1
velocity one set 0 0.01 0
pair_style granular
pair_coeff * * {law}
{wall}
timestep 1e-6
fix 1 all nve/noforce
dump 1 one custom 100 {out} fx fy tqz
dump_modify 1 format float %.12g
run 100
"""
    DECK = """dt = 1e-6; steps = 100; integrator = "verlet"; contact_variant = "conservative";
materials = ( {{ name = "m"; law = "hertz"; E_star = {modulus}; mu = {mu}; tangential = "mindlin"; poisson = {nu}; }} );
disks = ( {{ x = {x}; y = 0; radius = {radius}; mass = 1; inertia = 1e9; locked = ("x", "y"); }}{second} );
{wall}
motions = ( {{ {mover}; coordinate = "y"; type = "velocity"; velocity = -0.01; }} );
"""

    def test_modulus(self):
        """E_star and poisson: the force of hertz/material and mindlin, for unequal spheres and on a wall."""
        law = f"hertz/material {self.MODULUS} 0.0 {self.NU} tangential mindlin NULL 0.0 {self.MU} damping velocity"
        for one, other in ((0.008, 0.012), (0.01, 0.01), (0.02, 0.002), (0.008, None)):
            with self.subTest(one=one, other=other), tempfile.TemporaryDirectory() as name:
                folder = pathlib.Path(name)
                x = self.DEPTH - one
                (folder / "in").write_text(self.LAMMPS.format(
                    x=x, diameter=2 * one, law=law, out=folder / "out",
                    second=f"create_atoms 1 single {other} 0 0\nset atom 2 diameter {2 * other}" if other else "",
                    wall="" if other else f"fix w all wall/gran granular {law} xplane NULL 0"))
                subprocess.run([programs.find("lammps"), "-in", folder / "in", "-log", "none"], check=True,
                               capture_output=True, cwd=folder)
                theirs = [float(word) for word in (folder / "out").read_text().splitlines()[-1].split()]
                # At walls this LAMMPS divides by 1 - nu, and has a tangential stiffness of its own.
                (folder / "d.cfg").write_text(self.DECK.format(
                    modulus=self.MODULUS / 2 / (1 - self.NU**(2 if other else 1)), nu=self.NU, mu=self.MU, x=x, radius=one,
                    second=f', {{ x = {other}; y = 0; radius = {other}; mass = 1; fixed = true; }}' if other else "",
                    wall="" if other else 'walls = ( { name = "w"; type = "line"; points = ((0, -1), (0, 1)); } );',
                    mover="disk = 1" if other else 'wall = "w"'))
                subprocess.run([PROGRAM, "run", "d.cfg", "-o", "d.h5"], check=True, capture_output=True, cwd=folder)
                with h5py.File(folder / "d.h5") as f:
                    last = f["contacts/step"][-1] == 100
                    force, tau = (f[f"contacts/{key}"][-1] for key in ("force", "tau"))
                self.assertTrue(last)
                self.assertLess(abs(tau), 0.9 * self.MU * force)
                if other:
                    self.assertAlmostEqual(math.hypot(force, tau) / math.hypot(*theirs[:2]), 1, delta=1e-4)
                    self.assertAlmostEqual(tau * one / theirs[2], 1, delta=1e-3)
                else:
                    self.assertAlmostEqual(-force / theirs[0], 1, delta=1e-9)


if __name__ == "__main__":
    sys.exit(unittest.main(verbosity=1))
