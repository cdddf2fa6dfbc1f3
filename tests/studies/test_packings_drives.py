"""Harmonic against random drive, and disks whose neighbours do not turn: each verdict can be met and can fail."""
import os
import pathlib
import re
import subprocess
import tempfile
import unittest

import numpy as np

from studies_common import PROGRAM, ROOT
from packings import alone, front, gentle
from packings.disks import Box
from ratchet.data import Table
from ratchet.page import by_motion
from ratchet.verdict import NO, OPEN, YES, beside, decide

RNG = np.random.default_rng(5)


def lattice(rows=6, columns=10):
    """Places and radii of disks that touch on a triangular lattice."""
    k, row = np.meshgrid(np.arange(columns), np.arange(rows))
    return (k + 0.5 * (row % 2)).ravel() * 1.0, (row * 3 ** 0.5 / 2).ravel(), np.full(rows * columns, 0.5)


@unittest.skipUnless(os.path.exists(PROGRAM), "the program is not built")
class Floors(unittest.TestCase):
    DECK = """
constants = { drive = 0.5; }; dt = 1e-4; integrator = "verlet"; gravity = { g = 9.81; };
materials = ( { name = "grain"; k_n = 1e3; gamma_n = 0.5; } );
container = { type = "box"; width = 0.2; height = 0.4; };
disks = ( { x = 0; y = 0.3; radius = 0.02; density = 3.57; fixed = true; } );
%s
phases = ( { name = "wait"; time = 1; motions = "MOTION"; },
           { name = "measure"; time = 100; motions = "MOTION"; frames = 17; } );
"""

    def test_rms_displacement(self):
        """The floors of cage_gentle.cfg and cage_alone.cfg have the same rms displacement, a/(sqrt 2 omega^2)."""
        for name in ("cage_gentle.cfg", "cage_alone.cfg"):
            motions = re.search(r"motions = \(.*?\n\);", (ROOT / "inputs/packing" / name).read_text(), re.S)[0]
            for motion in ("shake", "noise"):
                with tempfile.TemporaryDirectory() as folder:
                    deck, path = os.path.join(folder, "a.cfg"), os.path.join(folder, "a.h5")
                    pathlib.Path(deck).write_text(self.DECK.replace("MOTION", motion) % motions)
                    done = subprocess.run([PROGRAM, "run", deck, "-o", path, "--quiet"], capture_output=True, text=True,
                                          check=False)
                    self.assertIn(done.returncode, (0, 5), done.stderr)
                    result = alone.slipdisk.Result(path)
                    height = result.wall_frames["position"][:, :, 1]
                    height = height[result.wall_frames.time > 1]
                rms = height.std(axis=0).max()
                wanted = 0.5 * 9.81 / (2 * np.pi * 80) ** 2 / 2 ** 0.5
                self.assertAlmostEqual(rms / wanted, 1, delta=0.04, msg=f"{name} {motion}")


class Sets(unittest.TestCase):
    def test_sets(self):
        """Each disk is in one set; none of a set touches another of it or the same disk; sets are few."""
        x, y, radius = lattice()
        found = alone.sets(x, y, radius)
        self.assertEqual(sorted(sum(found, [])), list(range(60)))
        for one in found:
            apart = np.hypot(x[one][:, None] - x[one], y[one][:, None] - y[one])[np.triu_indices(len(one), 1)]
            self.assertGreater(apart.min(initial=9), 2 * 3 ** 0.5 / 2 + 0.1)  # beyond second neighbours
        self.assertLess(len(found), 14)


class Gears(unittest.TestCase):
    def test_row(self):
        """A driven disk between walls turns its neighbours against it; without walls a train of gears turns as one."""
        a, b, force = np.array([0.0, 1]), np.array([1.0, 2]), np.array([1.0, 1])
        radius, load = np.array([1.0, 2, 1]), np.array([2.0, 3, 2])  # one force of each disk is a wall's
        matrix = alone.gears(radius, load, a, b, force)
        self.assertTrue(np.allclose(matrix, [[0, -1, 0], [-1 / 6, 0, -1 / 6], [0, -1, 0]]))
        omega = np.linalg.solve(np.eye(3) - matrix, [1.0, 0, 0])
        self.assertTrue(omega[0] > 0 > omega[1] and omega[2] > 0, omega)
        free = alone.gears(radius, np.array([1.0, 2, 1]), a, b, force)
        self.assertTrue(np.allclose(free @ [2.0, -1, 2], [2, -1, 2]))  # surfaces roll on each other: nothing slides


def packing(cage=1.0, gearing=1.0, left=0.0, number=0):
    """60 disks of a lattice: Omega is made of this much cage, this much gearing, and what is left."""
    x, y, radius = lattice()
    a, b = np.nonzero(np.triu(np.hypot(x[:, None] - x, y[:, None] - y) < 1.01, 1))
    force = RNG.uniform(0.5, 2, len(a))
    load = np.bincount(a, force, 60) + np.bincount(b, force, 60) + 0.5
    own, other, rest = RNG.normal(size=(3, 60))
    gears = gearing * alone.gears(radius, load, a, b, force)
    omega = np.linalg.solve(np.eye(60) - gears, cage * own + (1 - cage) * other) + left * rest
    columns = {"disk": np.arange(60.0), "radius": radius, "omega": omega, "error": 0.01, "first": omega, "second": omega,
               "alone": own, "alone_error": 0.01, "contacts": 4.0, "load": load, "friction": 1.0}
    rows = [{name: float(np.broadcast_to(values, 60)[k]) for name, values in columns.items()} for k in range(60)]
    return alone.Packing(Table(rows), Table([{"a": float(i), "b": float(j), "force": f} for i, j, f in zip(a, b, force)]))


KEY = (0.7, 1.0)


class Alone(unittest.TestCase):
    def verdicts(self, **how):
        packings = [packing(number=k, **how) for k in range(8)]
        return [f(KEY, packings).verdict for f in (alone.set_by_cage, alone.with_gears, alone.balanced)]

    def test_cage_and_gears(self):
        self.assertEqual(self.verdicts(left=0.1)[1:], [YES, YES])
        self.assertEqual(self.verdicts(gearing=0.0, left=0.1)[0], YES)

    def test_neither(self):
        self.assertEqual(self.verdicts(cage=0.0), [NO, NO, NO])
        self.assertEqual(self.verdicts(gearing=-0.5)[2], NO)  # neighbours turn alike

    def test_shares(self):
        """They add up to one, and what is left is what was put in."""
        part = alone.shares([packing(left=1.0) for _ in range(8)])
        self.assertAlmostEqual(sum(part[name][0] for name in ("cage", "gearing", "neighbours", "neither")), 1, 9)
        exact = alone.shares([packing() for _ in range(8)])
        self.assertLess(exact["neither"][0], 0.01)
        self.assertGreater(exact["gearing"][0], 0.05)
        self.assertGreater(part["neither"][0], 0.2)

    def test_turning_alone(self):
        turning = [packing() for _ in range(4)]
        self.assertEqual(alone.cage_turns(KEY, turning).verdict, YES)
        for one in turning:
            one.alone = 1e-3 * RNG.normal(size=60)
        self.assertEqual(alone.cage_turns(KEY, turning).verdict, NO)


def box(still, sign=1.0, drive=0.1, sure=None):
    """60 disks of which a fraction stands still; sign: their sense against that of others."""
    turns = np.arange(60) >= 60 * still
    omega = np.where(turns, sign * np.where(np.arange(60) % 2, 1.0, -1.0), 0.0)
    columns = {"radius": np.full(60, 0.02), "omega": omega, "error": np.full(60, 0.01), "omega_first": omega,
               "omega_second": omega, "persistent": np.full(60, 4.0), "openings": np.where(turns, 1.0, 0.0),
               "friction": np.where(turns, 1.0, 0.0)}
    for k in range(len(gentle.TIMES)):
        columns[f"sure_{k + 1}"] = np.where(turns if sure is None else turns & (k >= sure), 9.0, 0.0)
    return Box({"drive": drive, "replica": 0.0, "measured": 300.0}, columns)


class Gentle(unittest.TestCase):
    def part(self, harmonic, random, sign=1.0, sure=None):
        return {0: [box(harmonic)] * 2, 1: [box(random, sure=sure)] * 2, 2: [box(random, sign, sure=sure)] * 2}

    def test_equal(self):
        self.assertEqual(gentle.equal(0.1, self.part(0.7, 0.1)).verdict, NO)
        self.assertIn(gentle.equal(0.1, self.part(0.0, 0.0)).verdict, (YES, OPEN))
        many = {motion: found * 10 for motion, found in self.part(0.3, 0.3).items()}
        self.assertEqual(gentle.equal(0.1, many).verdict, YES)

    def test_senses(self):
        self.assertEqual(gentle.repeats(0.1, self.part(0.5, 0.0)).verdict, YES)
        self.assertEqual(gentle.repeats(0.1, self.part(0.5, 0.0, -1.0)).verdict, NO)
        self.assertEqual(gentle.repeats(0.1, self.part(0.5, 1.0)).verdict, OPEN)  # none turns
        against = {**self.part(0.0, 0.0), 0: [box(0.0, -1.0)] * 2}
        self.assertEqual(gentle.carried(0.1, against).verdict, NO)

    def test_level(self):
        self.assertEqual(gentle.levelled(0.1, self.part(0.5, 0.3)).verdict, YES)
        self.assertEqual(gentle.levelled(0.1, self.part(0.5, 0.3, sure=3)).verdict, NO)  # all in the second half

    def test_dissipation(self):
        """rms Omega in proportion to the power of friction, and as its root."""
        for exponent, verdict in ((1.0, YES), (0.5, NO)):
            found = {}
            for drive in (0.03, 0.1, 0.3):
                found[drive] = []
                for k in range(6):
                    one = box(0.2, drive=drive)
                    one.whole["replica"] = float(k)
                    one.columns["friction"] = np.full(60, 3.0 * drive ** 2 * (1 + 0.01 * k))
                    one.columns["omega"] = one.columns["omega"] * (drive ** 2) ** exponent * (1 + 0.02 * RNG.normal())
                    found[drive].append(one)
            self.assertEqual(gentle.dissipation(found, "harmonic").verdict, verdict)

    def test_one_statement_for_two_motions(self):
        """The text is that of the first motion, and the slug of the second tells it; the head of the page gathers them."""
        harmonic = [decide("At 2 <i>g</i> it holds.", True, "1", slug="gears-contact-2g"),
                    decide("It holds for long.", None, "2", slug="long")]
        random = [decide("At 2 <i>g</i> it holds here, too.", False, "3", slug="gears-contact-2g")]
        found = beside(harmonic, random)
        self.assertEqual([(c.motion, c.slug, c.text) for c in found], [
            ("harmonic", "gears-contact-2g", "At 2 <i>g</i> it holds."), ("harmonic", "long", "It holds for long."),
            ("random", "gears-contact-2g-random", "At 2 <i>g</i> it holds.")])
        single, pairs = by_motion([*found, decide("Alone.", True, "4")])
        self.assertEqual(([c.text for c in single], {text: list(pair) for text, pair in pairs.items()}),
                         (["Alone."], {"At 2 <i>g</i> it holds.": ["harmonic", "random"], "It holds for long.": ["harmonic"]}))
        rows = front.by_drive({claim.slug: claim for claim in found})
        self.assertEqual(rows, [["disks in contact turn against each other", "yes at 2 <i>g</i>", "no at 2 <i>g</i>"]])

    def test_words(self):
        self.assertEqual(set(front.WORDS), {YES, NO, OPEN})


if __name__ == "__main__":
    unittest.main(verbosity=1)
