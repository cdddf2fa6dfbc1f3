"""Statistics of the study of packings about cages, from made-up numbers: each verdict can be met and can fail."""
import unittest

import numpy as np

import studies_common  # noqa: F401
from packings import cages, contacts, jumps, memory, space
from ratchet.data import Table
from ratchet.verdict import NO, YES


def rng():
    return np.random.default_rng(3)


def table(**columns):
    columns = {key: np.broadcast_to(values, max(map(np.size, columns.values()))) for key, values in columns.items()}
    return Table([{key: value if isinstance(value, str) else float(value) for key, value in zip(columns, row)}
                  for row in zip(*columns.values())])


class Memory(unittest.TestCase):
    def judged(self, history, noise=0.02):
        """Verdict on 120 disks whose two runs share what is left beside `history`."""
        r, n = rng(), 120
        shared = r.normal(size=n)
        columns = {"drive": 2.0, "packing": np.repeat([0, 1], 60), "disk": np.tile(np.arange(60), 2), "radius": 0.02}
        for variant in ("reference", "forgotten"):
            own = np.sqrt(1 - history) * shared + np.sqrt(history) * r.normal(size=n)
            halves = own + noise * np.sqrt(2) * r.normal(size=(2, n))
            columns |= {variant: halves.mean(axis=0), variant + "_error": noise, variant + "_first": halves[0],
                        variant + "_second": halves[1], variant + "_x": np.arange(n), variant + "_y": 0.0}
        pair = memory.Disks(table(**columns), 2.0, ("reference", "forgotten"))
        return memory.judge("memory", "anew", True, 2.0, [pair])[0], memory.together(memory.not_repeated, [pair])

    def test_same(self):
        claim, (share, error) = self.judged(0)
        self.assertEqual((claim.verdict, claim.kind, claim.slug), (YES, "paper", "quenched-memory-2g"))
        self.assertLess(share, 0.01)

    def test_history_counts(self):
        claim, (share, error) = self.judged(0.4)
        self.assertEqual(claim.verdict, NO)
        self.assertLess(abs(share - 0.4), 4 * error)

    def test_names_of_points(self):
        self.assertEqual(memory.packing_of({"start": "work_x_points_r_3.h5"}), 3)
        self.assertEqual(memory.packing_of({"start": "work_x_points_base.h5"}), 0)
        found = [memory.variant_of(p) for p in ({}, {"phase": "pi"}, {"spin": 5.0}, {"spin": -5.0},
                                                {"contacts": "false"},
                                                {"motion": "noise", "noise": 1.0}, {"motion": "noise", "noise": 2.0})]
        self.assertEqual(tuple(found), memory.VARIANTS)


class Balance(unittest.TestCase):
    def test_two_supports(self):
        """The torques are (15)-(18) and their mean is (19) to first order in the tilt, however the springs are."""
        half, tilt, mu = np.pi / 6, 0.1, 0.1
        angle = np.array([-np.pi / 2 - (half - tilt), -np.pi / 2 + half + tilt])
        force = np.sin([half + tilt, half - tilt]) / np.sin(2 * half)
        self.assertTrue(np.allclose(contacts.geometry(angle), (tilt, half)))
        phi = np.arctan(mu)
        for signs, torque in (((1, 1), np.sin(phi) * np.cos(tilt - phi) / np.cos(half)),
                              ((-1, -1), -np.sin(phi) * np.cos(tilt + phi) / np.cos(half)),
                              ((1, -1), np.sin(phi) * np.sin(tilt) / np.sin(half + phi)),
                              ((-1, 1), -np.sin(phi) * np.sin(tilt) / np.sin(half - phi))):
            found = contacts.rectified_torque(angle, force, [1, 3], mu, [signs])
            self.assertAlmostEqual(mu * found, torque, 12)
        mu2, c, t = mu * mu, np.cos(half), np.tan(half)
        mean = mu2 * (mu2 + (1 + mu2) * np.cos(2 * half)) * np.sin(tilt) / (c ** 3 * 2 * (1 + mu2) * (mu2 - t * t))
        self.assertAlmostEqual(mu * contacts.rectified_torque(angle, force, [1, 1], mu), mean, 12)

    def test_symmetric_cage(self):
        """Nothing turns in a cage that is its own mirror image, and a mirror changes the sense."""
        angle = np.radians([-150, -30, 30, 150])
        self.assertAlmostEqual(contacts.rectified_torque(angle, [2, 2, 1, 1], np.ones(4)), 0, 12)
        found = [contacts.rectified_torque(np.radians(a), [2, 1, 0.5], np.ones(3))
                 for a in ([-150, -20, 80], [-30, 200, 100])]
        self.assertAlmostEqual(found[0], -found[1], 12)
        self.assertGreater(abs(found[0]), 1e-3)

    def test_gears(self):
        """A disk that is driven turns its neighbours the other way; the last of a row of three turns with the first."""
        cage = contacts.Cage.__new__(contacts.Cage)
        cage.n, cage.radius = 3, np.ones(3)
        cage.disk, cage.other = np.array([0, 1, 1, 2, 0, 1, 2]), np.array([1, 0, 2, 1, 9, 9, 9])
        cage.force = np.ones(7)
        omega = contacts.response(cage, np.array([1.0, 0, 0]))
        self.assertTrue(omega[0] > 0 > omega[1] and omega[2] > 0, omega)
        self.assertTrue(np.allclose(contacts.response(cage, np.array([1.0, 0, 0]), own=True), [0.5, 0, 0]))


class Cages(unittest.TestCase):
    def part(self, weight):
        """60 disks in each of 6 packings whose Omega is this much a function of the cage."""
        r, n = rng(), 360
        columns = {name: r.normal(size=n) for name in (*cages.ODD, *cages.EVEN, *cages.PREDICTIONS)}
        signal = columns["tilt"] * (1 + 0.3 * columns["contacts"]) - columns["force_1"]
        omega = weight * signal / signal.std() + np.sqrt(1 - weight ** 2) * r.normal(size=n)
        for name in ("meshed",):
            columns[name] = omega + 0.3 * r.normal(size=n) if weight else columns[name]
        columns["gears"] = 0.8 * omega + 0.4 * r.normal(size=n) if weight else r.normal(size=n)
        return cages.Part(table(random=0.0, drive=2.0, packing=np.repeat(np.arange(6), 60), disk=np.tile(np.arange(60),
                                                                                                         6),
                                omega=omega, error=0.01, **columns))

    def verdicts(self, part):
        return [f(2.0, part).verdict for f in (cages.predicts, cages.mechanism, cages.gear)]

    def test_cage_counts(self):
        self.assertEqual(self.verdicts(self.part(0.95)), [YES] * 3)

    def test_cage_does_not_count(self):
        part = self.part(0)
        self.assertEqual(self.verdicts(part), [NO] * 3)
        self.assertGreater(part.chance("all"), 0.01)

    def test_chance(self):
        r = rng()
        x, group = r.normal(size=90), np.repeat([0, 1, 2], 30)
        self.assertLess(cages.chance(lambda v: float(np.dot(v, x)), x + 0.1 * r.normal(size=90), group, 200), 0.01)
        found = cages.shuffled(x, group, r)
        self.assertFalse((found == x).all())
        for one in range(3):
            self.assertEqual(sorted(found[group == one]), sorted(x[group == one]))


class Space(unittest.TestCase):
    def verdicts(self, sign):
        """A row of 10 packings of 60 disks whose neighbours turn with this sign."""
        rows, r = [], rng()
        for block in range(10):
            omega = sign ** np.arange(60) * (1 + 0.5 * r.normal(size=60)) + 0.5 * r.normal(size=60)
            run = type("Run", (), {"x": np.arange(60.0), "y": np.zeros(60), "radius": np.full(60, 0.5), "omega": omega,
                                   "error": np.full(60, 0.01)})
            cage = contacts.Cage.__new__(contacts.Cage)
            cage.n = 60
            cage.disk = np.concatenate([np.arange(59), np.arange(1, 60)])
            cage.other = np.concatenate([np.arange(1, 60), np.arange(59)])
            rows += space.of_run(0, block, run, cage)
        rows = [{key: value if key == "kind" else float(value) for key, value in row.items()} for row in rows]
        curve = {kind: space.curve(Table([row for row in rows if row["kind"] == kind])) for kind in
                 ("contacts", "distance")}
        self.assertEqual(list(curve["contacts"][5][:3]), [590, 580, 570])  # pairs
        return [space.gears("", "", curve["contacts"]).verdict, space.second("", "", curve["contacts"]).verdict]

    def test_gears(self):
        self.assertEqual(self.verdicts(-1.0), [YES, YES])
        self.assertEqual(self.verdicts(1.0), [NO, YES])

    def test_ways(self):
        i, j, steps = space.along([[1], [0, 2], [1, 3], [2]], 2)
        self.assertEqual(sorted(zip(i, j, steps))[:2], [(0, 1, 1), (0, 2, 2)])
        i, j, apart = space.near(np.array([0, 3.0, 1]), np.array([0, 0, 1.0]), 2.5)
        self.assertEqual(sorted(zip(i, j)), [(0, 2), (1, 2), (2, 0), (2, 1)])


class Jumps(unittest.TestCase):
    def test_changes(self):
        """Steps are found where they are, and hardly any in noise."""
        r = rng()
        level = np.repeat([0, 1, -0.5], [40, 30, 50])
        found = jumps.changes(level + 0.1 * r.normal(size=120), 0.05)
        self.assertEqual(len(found), 2)
        self.assertLessEqual(max(abs(np.subtract(found, [40, 70]))), 1)
        self.assertLess(sum(len(jumps.changes(r.normal(size=120), 0)) for _ in range(200)), 6)
        self.assertEqual(jumps.changes(level + 0.1 * r.normal(size=120), 3), [])

    def test_switches(self):
        self.assertEqual(jumps.switches(np.repeat([1.0, 0, 1], [20, 20, 20])), [20, 40])
        self.assertEqual(jumps.switches(np.full(60, 0.7)), [])

    def judged(self, together):
        """Verdict on 200 jumps in 10 runs, so many of them at rearrangements, which cover a fifth of the time."""
        r = rng()
        found = table(drive=2.0, packing=np.repeat(np.arange(10), 20), variant=0.0, together=r.random(200) < together,
                      covered=0.2)
        disks = table(drive=2.0, packing=np.arange(10.0), variant=0.0, time=60.0, shuffled=0.0, events=30.0,
                      turned=20.0)
        return jumps.judge(2.0, disks, found)[0].verdict

    def test_verdict(self):
        self.assertEqual(self.judged(0.8), YES)
        self.assertEqual(self.judged(0.2), NO)


if __name__ == "__main__":
    unittest.main(verbosity=1)
