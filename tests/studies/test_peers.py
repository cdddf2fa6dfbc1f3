"""The comparison with LAMMPS and LIGGGHTS (tools/compare_peers.sh): what it reads and counts, from made-up data; and, where
LAMMPS is installed, whether a small packing, three disks and two disks in a loop behave alike."""
import io
import os
import pathlib
import shutil
import sys
import tempfile
import unittest
import unittest.mock

import numpy

ROOT = pathlib.Path(os.environ.get("SLIPDISK_SOURCE_DIR", pathlib.Path(__file__).resolve().parents[2]))
PROGRAM = os.environ.get("SLIPDISK_PROGRAM", str(ROOT / "build/release/slipdisk"))
sys.path.insert(0, str(ROOT / "tools"))
sys.dont_write_bytecode = True

from peers import __main__ as command  # noqa: E402
from peers import accuracy, bench, frames, inputs, packing, page, programs, three, timing  # noqa: E402

LAMMPS_OUTPUT = """LAMMPS (29 Sep 2021 - Update 2)
WARNING: a warning
WARNING: a warning
Loop time of 0.5 on 1 procs for 10 steps with 100 atoms
Neighbor list builds = 7
Dangerous builds = 0
Loop time of 3.25e-01 on 2 procs for 250 steps with 1000 atoms
Neighbor list builds = 3
Dangerous builds = 1
"""
LIGGGHTS_OUTPUT = """LIGGGHTS (Version LIGGGHTS-PUBLIC 3.8.0, compiled 2022-01-26-19:42:32 by buildd, git commit unknown)
Loop time of 0.0135779 on 1 procs for 250 steps with 100 atoms, finish time Sat Nov 21 15:16:22 2026
"""
DUMP = """ITEM: TIMESTEP
{step}
ITEM: NUMBER OF ATOMS
2
ITEM: BOX BOUNDS pp ff pp
0 1
0 1
-1 1
ITEM: ATOMS id x y vx vy omegaz
1 0.25 0.5 1 2 3
2 0.75 0.125 -1 -2 -3
"""


def random_packing(count=300, seed=3):
    """Disks anywhere, some of which overlap."""
    rng = numpy.random.default_rng(seed)
    speed = rng.normal(size=(3, count))
    return packing.Packing(x=rng.uniform(0, 1, count), y=rng.uniform(0.01, 0.6, count), vx=speed[0], vy=speed[1],
                           omega=speed[2], radius=rng.uniform(0.01, 0.02, count), width=1.0)


def frame_of(it, step=1, floor=0.0):
    return frames.Frame(step, it.x, it.y, it.vx, it.vy, it.omega, floor)


class Reading(unittest.TestCase):
    def test_output(self):
        """The last loop counts, and what stands behind it."""
        self.assertEqual(programs.loop_time(LAMMPS_OUTPUT), (0.325, 2, 250, 1000))
        self.assertEqual(programs.loop_time(LIGGGHTS_OUTPUT), (0.0135779, 1, 250, 100))
        self.assertIsNone(programs.loop_time("ERROR: nothing ran"))
        self.assertEqual(programs.neighbour_builds(LAMMPS_OUTPUT), {"Neighbor list": 3, "Dangerous": 1})
        self.assertEqual(programs.banner(LAMMPS_OUTPUT), "29 Sep 2021 - Update 2")
        self.assertEqual(programs.banner(LIGGGHTS_OUTPUT), "PUBLIC 3.8.0")
        self.assertIsNone(programs.banner("another program"))
        self.assertEqual(programs.warnings(LAMMPS_OUTPUT), ["WARNING: a warning"])

    def test_dump(self):
        step = inputs.PERIOD // 4
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder) / "dump"
            path.write_text(DUMP.format(step=0) + DUMP.format(step=step))
            first, second = frames.of_dump(path)
            moved = frames.of_dump(path, floor_rests=True)[1]
            path.write_text(DUMP.format(step=0).replace("\n1 0.25", "\n3 0.25"))
            with self.assertRaises(ValueError):
                frames.of_dump(path)
        self.assertEqual((first.step, second.step, first.floor), (0, step, 0))
        self.assertEqual(list(second.x), [0.25, 0.75])
        self.assertEqual(list(second.omega), [3, -3])
        # A quarter of a period later the floor is nearly at its middle height, and as fast as it gets.
        self.assertAlmostEqual(moved.y[0] - second.y[0], inputs.AMPLITUDE, delta=0.01 * inputs.AMPLITUDE)
        self.assertAlmostEqual(moved.vy[0] - second.vy[0], inputs.AMPLITUDE * inputs.W, delta=1e-5)

    def test_options(self):
        self.assertEqual(command.options(["--sizes", "1e3,2e4"]).sizes, [1000, 20000])
        self.assertEqual(command.options(["--three"]).what, "three")
        for words in (["--sizes", "10"], ["--sizes", "1e3,x"], ["--three", "--accuracy"]):
            with self.assertRaises(SystemExit), unittest.mock.patch("sys.stderr", io.StringIO()):
                command.options(words)


class Counting(unittest.TestCase):
    def test_overlaps(self):
        """Against every pair one by one, across the edge of the box as well."""
        it = random_packing()
        found = frames.overlaps(frame_of(it, floor=0.005), it.radius, it.width)
        dx = it.x[:, None] - it.x
        dx -= it.width * numpy.round(dx / it.width)
        between = it.radius[:, None] + it.radius - numpy.hypot(dx, it.y[:, None] - it.y)
        between = between[numpy.triu_indices(it.count, 1)]
        below = it.radius - (it.y - 0.005)
        expected = numpy.concatenate([between[between > 0], below[below > 0]])
        self.assertGreater((below > 0).sum(), 3)
        numpy.testing.assert_allclose(numpy.sort(found), numpy.sort(expected), rtol=1e-12)

    def test_copies_are_the_same_physics(self):
        it = random_packing()
        twice = it.repeated(3)
        self.assertEqual((twice.count, twice.width), (900, 3.0))
        one, three_of_it = (frames.physics([frame_of(p, 0), frame_of(p)], p) for p in (it, twice))
        for what in bench.TOLERANCES:
            self.assertAlmostEqual(getattr(one, what), getattr(three_of_it, what), 12)

    def test_compared(self):
        it = random_packing()
        own = frames.physics([frame_of(it)], it)
        other = frames.physics([frame_of(it)], it)
        other.kinetic *= 1.2
        found = bench.compared({"slipdisk": own, "LAMMPS hooke": other}, it.width)
        self.assertTrue(found["slipdisk"]["agrees"])
        self.assertFalse(found["LAMMPS hooke"]["agrees"])
        self.assertAlmostEqual(found["LAMMPS hooke"]["off"]["kinetic"], 0.2)

    def test_distance_across_the_edge(self):
        it = random_packing()
        shifted = frame_of(it)
        shifted.x = (it.x + 0.9) % 1.0
        self.assertAlmostEqual(frames.distance(frame_of(it), shifted, 1.0), 0.1, 12)

    def test_masses(self):
        """The density in a file of LAMMPS is that of a sphere, in one of LIGGGHTS that of a disk."""
        it = packing.loose(100)
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "data")
            for spheres, measure in ((True, lambda r: 4 / 3 * numpy.pi * r**3), (False, lambda r: numpy.pi * r**2)):
                it.write_data(path, spheres)
                rows = numpy.array([line.split() for line in pathlib.Path(path).read_text().split("Atoms")[1]
                                    .split("Velocities")[0].strip().splitlines()], dtype=float)
                numpy.testing.assert_allclose(rows[:, 3] * measure(rows[:, 2] / 2), it.mass, rtol=1e-14)
        with self.assertRaises(ValueError):
            packing.make(PROGRAM, "", 1500, [])

    def test_times(self):
        order, clock = [], iter(range(1, 100))
        runs = {name: lambda name=name: (order.append(name), float(next(clock)))[1] for name in "ab"}
        found = timing.alternate(runs, 3)
        self.assertEqual("".join(order), "abbaab")
        self.assertEqual(found["b"].values, [2, 3, 6])
        self.assertEqual(found["b"].median, 3)
        self.assertEqual(timing.ratio(found["b"], found["a"]), (1.2, 0.75, 2))

    def test_expected_of_loops(self):
        """Round a small circle the integral of r dbeta is its area over the distance."""
        area = numpy.pi * accuracy.CIRCLE**2
        self.assertAlmostEqual(accuracy.expected("circle", "LIGGGHTS") / (area / accuracy.APART), 1, delta=0.01)
        self.assertEqual(accuracy.expected("turn", "LIGGGHTS"), 0)
        self.assertEqual(accuracy.expected("circle", "slipdisk"), 0)


class Page(unittest.TestCase):
    MADE = {"machine": "a machine", "load": 0.0, "versions": {"slipdisk": "0", "LAMMPS": "1"}}

    def results(self):
        it = random_packing()
        physics = bench.compared({name: frames.physics([frame_of(it)], it) for name in ("LAMMPS hooke", "slipdisk")}, 1.0)
        times = {"slipdisk": [10.0, 11.0, 12.0], "LAMMPS hooke": [20.0, 22.0, 24.0]}
        data = {"1000": {"steps": 5, "check_steps": 25, "frames": 5, "physics": physics, "times": {"1": times}}}
        return {"packings": {"made": self.MADE, "data": data}}

    def test_tables(self):
        text = "\n".join(page.part("packings", self.results()))
        self.assertIn("| LAMMPS hooke | 22 (9 %) | 2.00 (2.00 to 2.00) |", text)
        self.assertIn("3 repeats of 5 steps (1e3)", text)
        self.assertLess(text.index("| slipdisk | 11"), text.index("| LAMMPS hooke | 22"))
        self.assertIn("| LAMMPS hooke | - | - | - | 0.0e+00 | yes |", text)
        self.assertNotIn("not quiet", text)
        self.assertNotIn("two cores", text)

    def test_fill(self):
        """Of the page that ships only the tables that there are results of change."""
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder) / "performance.md"
            shutil.copy(ROOT / "docs/performance.md", path)
            before = path.read_text()
            page.fill(str(path), self.results())
            after = path.read_text()
            page.fill(str(path), self.results())
            self.assertEqual(path.read_text(), after)
        self.assertIn("| LAMMPS hooke | 22", after)
        cut = "<!-- end of packings -->"
        self.assertEqual(before.split(cut)[1], after.split(cut)[1])
        self.assertEqual(before.split("<!-- packings -->")[0], after.split("<!-- packings -->")[0])


def quiet_setup(folder):
    return bench.Setup(PROGRAM, folder, repeats=1, work=25000, lammps=programs.find("lammps"),
                       liggghts=programs.find("liggghts"), say=lambda text: None)


class Decks(unittest.TestCase):
    """What needs slipdisk only."""

    def test_packing(self):
        """It is at rest but for the floor, bears load everywhere, and a timed run goes on from it."""
        with tempfile.TemporaryDirectory() as folder:
            setup = quiet_setup(folder)
            setup.lammps = setup.liggghts = None
            it = bench.Bench(setup, 100)
            own = it.check([])["slipdisk"]
            self.assertGreater(it.slipdisk([]), 0)
            going = frames.of_slipdisk(os.path.join(it.folder, "timed.h5"))
            rested = frames.physics(going[-1:], it.packing)
        self.assertTrue(1.4 < own.contacts < 2)
        self.assertAlmostEqual(rested.contacts / own.contacts, 1, delta=0.05)
        self.assertAlmostEqual(rested.overlap / own.overlap, 1, delta=0.25)  # the floor shakes
        self.assertLess(rested.kinetic, 10 * own.kinetic)

    def test_three(self):
        with tempfile.TemporaryDirectory() as folder:
            setup = quiet_setup(folder)
            it = three.Three(setup, steps=2000, check=2000)
            self.assertGreater(it.slipdisk([]), 0)
            self.assertGreater(it.lanes([]), 0)


class Alike(unittest.TestCase):
    def test_packing(self):
        """100 disks over 250 steps, all from the same state."""
        with tempfile.TemporaryDirectory() as folder:
            setup = quiet_setup(folder)
            setup.lammps_native = setup.lammps
            it = bench.Bench(setup, 100)
            found = bench.compared(it.check([]), it.packing.width)
            times = {name: run([]) for name, run in it.contestants().items()}
        self.assertEqual(it.check_steps, 250)
        for name, physics in found.items():
            self.assertTrue(physics["agrees"], (name, physics))
            self.assertLess(physics["distance"], 1e-3, name)
        # With the same viscosity disks stay together far better than with one that is right in the mean only.
        self.assertLess(found["LAMMPS granular"]["distance"], 1e-5)
        self.assertEqual(set(times) - {"slipdisk, baseline", "LAMMPS hooke, native"}, set(found))
        self.assertIn("LAMMPS hooke, native", times)
        self.assertTrue(all(seconds > 0 for seconds in times.values()), times)

    def test_three(self):
        """A fifth of a period; laws and places are those of the deck."""
        with tempfile.TemporaryDirectory() as folder:
            paths = three.Three(quiet_setup(folder), check=20000).paths([])
        self.assertIn("LAMMPS granular", paths)
        for name, path in paths.items():
            self.assertLess(three.path_difference(path, paths["slipdisk"]), 1e-3, name)

    def test_loops(self):
        """What is left of the stretch is what it should be, for each program."""
        with tempfile.TemporaryDirectory() as folder, unittest.mock.patch.object(accuracy, "CYCLES", (1, 2)):
            found = accuracy.loops(quiet_setup(folder), folder, [])
        self.assertEqual(len(found), 2 * (3 + bool(programs.find("liggghts"))))
        for row in found:
            tolerance = 0.02 * row["expected"] if row["expected"] else 1e-12
            self.assertAlmostEqual(row["left"][0], row["expected"], delta=tolerance, msg=row)
        self.assertTrue(all(max(row["left"]) < 1e-12 for row in found if row["program"] == "slipdisk"))


if __name__ == "__main__":
    sys.exit(unittest.main(verbosity=1))
