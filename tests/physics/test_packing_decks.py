"""The decks that make large packings, with fewer disks: deposition ends at rest and stays so, compression ends at jamming."""
import pathlib
import tempfile
import unittest

import h5py
import numpy

from results_common import ROOT, run

DECKS = ROOT / "inputs/packing"
GRAINS, WIDTH = 260, 0.8  # as many rows of disks as one batch of rain has are 20 of them wide
JAMMED = 160

# What shake_1e4.cfg does with a deposited packing, without shaking it.
USED = """
integrator = "verlet"; dt = 3e-5; gravity = {{ g = 9.81; }};
materials = ( {{ name = "grain"; k_n = 1e4; k_t = 5e3; gamma_n = 0.5; mu = 0.1; }} );
container = {{ type = "box"; width = {width}; height = 4; }};
disk_files = ( {{ file = "{file}"; dataset = "/particles/disks"; contacts = true; density = 3.57; group = "grains"; }} );
steps = 2000; output = {{ series = 100; }}; measure = {{ rotation = (); }};
"""


def without_rattlers(a, b, n):
    """(contacts per disk, disks) when those with fewer than three contacts are taken away until none is left."""
    alive = numpy.ones(n, bool)
    while True:
        held = alive[a] & alive[b]
        loose = alive & (numpy.bincount(numpy.concatenate([a[held], b[held]]), minlength=n) < 3)
        if not loose.any():
            return 2 * held.sum() / alive.sum(), int(alive.sum())
        alive &= ~loose


class Decks(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix="slipdisk-decks-")
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def run_ok(self, deck, result, *settings):
        words = [word for setting in settings for word in ("-D", setting)]
        status, _, err = run("run", deck, *words, "-o", result, "--quiet", "--threads", 1)
        self.assertEqual((status, err), (0, ""))
        return h5py.File(result)

    def all_reached(self, file):
        phases = file["summary/phase"]
        self.assertTrue(phases["reached"][:].all(), list(phases["steps"]))
        return phases

    def last_contacts(self, file):
        c = file["contacts"]
        rows = slice(c["first"][-1], c["first"][-1] + c["count"][-1])
        return c["a"][rows], c["b"][rows]

    def test_deposition(self):
        for name in "deposit_1e4", "deposit_1e5":
            with self.subTest(name):
                self.deposition(name)

    def deposition(self, name):
        made = self.folder / f"{name}.h5"
        with self.run_ok(DECKS / f"{name}.cfg", made, f"packings[0].count={GRAINS}", f"container.width={WIDTH}") as file:
            phases = self.all_reached(file)
            self.assertLessEqual(phases["unbalanced"][-1], 1e-3)
            self.assertLessEqual(phases["kinetic"][-1], 1e-9)
            self.assertLess(phases["steps"][:].sum(), 30000)
            summary, energy = file["summary"].attrs, file["summary/energy"].attrs
            self.assertEqual((summary["waiting"], summary["outside"]), (0, 0))
            self.assertLess(abs(energy["residual"]), 5e-3 * energy["scale"])
            disks = file["particles/disks"]
            x, radius = disks["position/value"][-1], disks["radius"][:]
            self.assertGreater(numpy.pi * (radius ** 2).sum() / (WIDTH * (x[:, 1] + radius).max()), 0.72)
            a, b = self.last_contacts(file)
            self.assertGreater(numpy.bincount(a[b < GRAINS], minlength=GRAINS).sum() * 2 / GRAINS, 3)
            self.assertTrue((numpy.bincount(numpy.concatenate([a, b]))[:GRAINS] >= 2).mean() > 0.95)
        # the dynamics of another deck has nothing to settle
        deck = self.folder / "used.cfg"
        deck.write_text(USED.format(width=WIDTH, file=made))
        with self.run_ok(deck, self.folder / f"{name}_used.h5") as file:
            kinetic = sum(file[f"observables/kinetic_{part}/value"][:] for part in ("translation", "rotation"))
            self.assertLess(kinetic.max(), 2e-7 * GRAINS)  # single disks creep on

    def test_jamming(self):
        edge = 152.4 * (JAMMED / 10000) ** 0.5
        settings = f"packings[0].count={JAMMED}", f"container.width={edge}", f"container.height={edge}"
        with self.run_ok(DECKS / "jam_1e4.cfg", self.folder / "jam.h5", *settings, "output.series=100") as file:
            phases = self.all_reached(file)
            ends = numpy.cumsum(phases["steps"][:])
            step = file["observables/pressure/step"]
            rows = numpy.searchsorted(step[:] if hasattr(step, "__len__") else step, ends)
            pressure = file["observables/pressure/value"][:][rows]
            fraction = file["observables/packing_fraction/value"][:][rows]
            numpy.testing.assert_allclose(pressure[3:], [1e-3, 3e-4, 1e-4], rtol=2e-3)
            self.assertTrue((numpy.diff(fraction[2:]) < 0).all(), fraction)
            # a straight line to no pressure; few disks scatter
            jammed = fraction[5] - pressure[5] * (fraction[4] - fraction[5]) / (pressure[4] - pressure[5])
            self.assertAlmostEqual(jammed, 0.84, delta=0.02)
            z, n = without_rattlers(*self.last_contacts(file), JAMMED)
            self.assertGreater(n, 0.8 * JAMMED)
            self.assertTrue(4 - 2 / n <= z < 4.3, z)


if __name__ == "__main__":
    unittest.main()
