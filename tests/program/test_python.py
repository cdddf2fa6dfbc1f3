"""The Python package: simulations from decks, dicts and arrays; columns, observers, forces, saving; errors."""
import ctypes
import gc
import os
import pathlib
import pickle
import re
import sys
import tempfile
import threading
import time
import unittest
import unittest.mock
import warnings

import numpy as np

from package import ROOT

import slipdisk
from slipdisk import library as lib

RATCHET = ROOT / "inputs/three_disk/random.cfg"
SHORT = {"phases.settle.steps": 1000, "phases.measure.steps": 100_000, "measure.configurations": True}
DISK = {"k_n": 1e3, "k_t": 1e6, "gamma_n": 10, "mu": 0.1}
DEEP = -np.sqrt(3)
DICT = {
    "dt": 1e-6, "gravity": {"g": 10, "tilt": "0.04 pi"}, "materials": {"disk": DISK},
    "disks": {"upper": {"x": 0, "y": 0, "radius": 1, "mass": 0.1},
              "left": {"x": -1, "y": DEEP, "radius": 1, "mass": 0.1, "fixed": True},
              "right": {"x": 1, "y": DEEP, "radius": 1, "mass": 0.1, "fixed": True}},
    "motions": {"shake": {"disk": ["left", "right"], "coordinate": ["x", "y", "theta"], "type": "random", "amplitude": 1e-4,
                          "omega": "20 pi", "damping": 0.5, "ramp": 0.2}},
    "phases": [{"name": "settle", "steps": 1000}, {"name": "measure", "steps": 100_000}],
    "measure": {"rotation": ["upper"], "sliding": [{"disk": "upper", "partners": ["left", "right"]}],
                "configurations": True},
}
GRAINS = {"dt": 2e-5, "time": 1, "gravity": {"g": 9.81}, "materials": {"grain": {"k_n": 1e4, "gamma_n": 0.5}},
          "walls": {"floor": {"type": "line", "points": [[-1, 0], [1, 0]]}}}
FREE = {"dt": 1e-3, "time": 10, "materials": {"grain": {"k_n": 1e4}}}


def ratchet(**more):
    return slipdisk.Simulation(RATCHET, SHORT, threads=1, **more)


def lattice(n, pitch=1.0):
    side = int(np.ceil(np.sqrt(n)))
    return {"x": np.arange(n) % side * pitch, "y": (np.arange(n) // side + 0.5) * pitch}


class Building(unittest.TestCase):
    def test_structs(self):
        """A disk that went through the library is the same: layouts agree."""
        library, model = lib.library(), lib.library().sd_model_new()
        rows = np.zeros(3, lib.DISK)
        for k, name in enumerate(("position", "velocity", "radius", "mass", "inertia", "force", "material", "group", "locked",
                                  "driven", "waiting")):
            rows[name] = np.arange(rows[name].size).reshape(rows[name].shape) % (2 if rows[name].dtype == bool else 100) + (
                0 if rows[name].dtype == bool else k + 1)
        self.assertEqual(library.sd_model_add_disks(model, len(rows), rows.ctypes.data), 0)
        self.assertEqual(library.sd_model_disks(model), 3)
        for k in range(3):
            found = np.frombuffer(ctypes.string_at(library.sd_model_disk(model, k), lib.DISK.itemsize), lib.DISK)[0]
            for name in set(lib.DISK.names) - {"group"}:  # which the library sets
                np.testing.assert_array_equal(found[name], rows[k][name], name)
        library.sd_model_free(model)

    def test_a_library_with_other_structs_is_refused(self):
        class Other(ctypes.Structure):
            _fields_ = [("kinetic", ctypes.c_double)]

        with unittest.mock.patch.dict(lib.SHARED, sd_energy=Other), self.assertRaisesRegex(slipdisk.FileError, "other structs .*: sd_energy$"):
            lib.load()

    def test_names(self):
        """What dir() lists is there, and is no name that the package only uses."""
        self.assertFalse({"Any", "TYPE_CHECKING", "annotations", "ctypes"} & set(dir(slipdisk)))
        for name in slipdisk.__all__:
            getattr(slipdisk, name)

    def test_dict_is_deck(self):
        """A dict, a deck with overrides, and the deck that a simulation prints: the same bits."""
        by_dict, by_deck = slipdisk.Simulation(DICT), ratchet()
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder, "full.cfg")
            path.write_text(by_deck.deck_full)
            again = slipdisk.Simulation(path)
        for simulation in (by_dict, by_deck, again):
            simulation.advance(3000)
        self.assertEqual(by_dict.hash(), by_deck.hash())
        self.assertEqual(again.hash(), by_deck.hash())
        self.assertEqual((by_dict.n_disks, by_dict.n_walls, by_dict.dt, by_dict.steps), (3, 0, 1e-6, 101_000))

    def test_values(self):
        """Every float keeps its bits; numpy's numbers, texts with quotes, bools, tuples."""
        x = float(np.nextafter(0.1, 1))
        text = slipdisk.deck_text({"dt": np.float64(x), "title": 'a "b" \\ c', "steps": np.int64(3), "a": {"on": np.bool_(True)},
                                   "b": (1, 2.5, np.array([1.0, 2.0])), "none": None})
        self.assertEqual(text, f'dt = {x!r};\ntitle = "a \\"b\\" \\\\ c";\nsteps = 3;\na = {{ on = true; }};\nb = (1, 2.5, (1.0, 2.0));\n')

    def test_arrays(self):
        """Disks from arrays have the bits of the arrays; one value holds for all; names and materials are words."""
        rng, n = np.random.default_rng(1), 1500
        place = lattice(n)
        radius = rng.uniform(0.3, 0.49, n)
        vx = np.where(np.arange(n) % 3, rng.normal(size=n) * 1e-30, 0)
        deck = {**FREE, "materials": {"a": {"k_n": 1e4}, "b": {"k_n": 2e4}},
                "material_pairs": [{"materials": ["a", "b"], "k_n": 1e4}], "disks": {"first": {
                    "x": -5, "y": 0, "radius": 1, "mass": 1, "material": "a"}}}
        s = slipdisk.Simulation(deck, disks={**place, "radius": radius, "vx": vx, "density": 2.0, "fixed": np.arange(n) % 3 == 0,
                                             "material": np.where(np.arange(n) % 2, "b", "a"),
                                             "name": [f"d{k}" for k in range(n)]})
        self.assertEqual(s.n_disks, n + 1)
        self.assertEqual(s.find("d7"), 8)
        self.assertEqual(s.name(8), "d7")
        np.testing.assert_array_equal(s.disks["x"][1:], place["x"])
        np.testing.assert_array_equal(s.disks["radius"][1:], radius)
        np.testing.assert_array_equal(s.disks["vx"][1:], vx)
        np.testing.assert_array_equal(s.disks["material"][1:], np.arange(n) % 2)
        np.testing.assert_allclose(s.disks["mass"][1:], 2 * np.pi * radius**2, rtol=1e-15)
        self.assertFalse(np.array_equal(s.columns["id"][:n], np.arange(n)), "slots go by place from 1000 free disks on")

    def test_arrays_with_deck_file(self):
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder, "d.cfg")
            path.write_text(slipdisk.deck_text(GRAINS))
            s = slipdisk.Simulation(path, disks={"x": [0.0, 0.1], "y": [0.02, 0.02], "radius": 0.02, "density": 1})
        self.assertEqual((s.n_disks, s.n_walls, s.find("floor")), (2, 1, 2))
        np.testing.assert_array_equal(s.walls["y"], [0])

    def test_one_value(self):
        """One value holds for all, also of x and y; a disk needs no array."""
        s = slipdisk.Simulation(FREE, disks={"x": [0.0, 3.0], "y": 1.0, "radius": 1, "mass": 2, "force": [1.0, 0.0]})
        self.assertEqual((s.disks["y"].tolist(), s.disks["mass"].tolist()), ([1, 1], [2, 2]))
        self.assertEqual(slipdisk.Simulation(FREE, disks={"x": 0, "y": 1, "radius": 1, "mass": 2}).n_disks, 1)

    def test_many(self):
        """1e5 disks are there in well under a second of processor time."""
        place = lattice(100_000)
        begin = time.process_time()
        s = slipdisk.Simulation(FREE, disks={**place, "radius": 0.4, "density": 1.0}, threads=1)
        took = time.process_time() - begin
        self.assertEqual(s.n_disks, 100_000)
        self.assertLess(took, 5, "about 0.6 s where nothing else runs")


class Stepping(unittest.TestCase):
    def test_pieces(self):
        """However steps are divided: the same bits."""
        a, b, c = ratchet(), ratchet(), ratchet()
        a.advance(20_000)
        for n in (1, 999, 7, 12_993, np.int32(6000)):
            b.advance(n)
        c.advance(time=0.02)
        self.assertEqual((a.step, b.step, c.step), (20_000,) * 3)
        self.assertEqual(a.hash(), b.hash())
        self.assertEqual(a.hash(), c.hash())
        a.advance()
        self.assertTrue(a.finished)
        self.assertEqual((a.step, a.stage.phase), (101_000, 2))
        with self.assertWarns(slipdisk.Warning):
            a.advance(10)
        self.assertEqual(a.step, 101_000)

    def test_extents_are_those_of_the_header(self):
        header = (ROOT / "include/slipdisk/state.h").read_text()
        header = re.sub(r"/\*.*?\*/", "", header, flags=re.S)
        names = re.findall(r"\bSD_(PER_\w+)\b", header[header.index("typedef enum sd_extent"):header.index("SD_EXTENTS")])
        self.assertEqual([getattr(lib, name) for name in names], list(range(len(names))))

    def test_fields(self):
        deck = {**FREE, "integrator": "verlet", "fields": {"air": {"type": "drag", "gamma": 1.0},
                                                           "pull": {"type": "central", "strength": 0.1}}}
        s = slipdisk.Simulation(deck, disks={"x": [0.0, 3.0], "y": [0.0, 0.0], "radius": 1, "mass": 1, "vx": [1.0, 2.0]})
        s.advance(500)
        x, v = s.disks["x"], s.disks["vx"]
        np.testing.assert_allclose(s.columns["field_x"], -v - 0.1 * x, rtol=1e-12)
        self.assertAlmostEqual(s.energy["drag"], s.disks["loss_drag"].sum(), delta=1e-12)
        self.assertEqual(len(slipdisk.Simulation(FREE, disks={"x": [0.0], "y": [0.0], "radius": 1, "mass": 1}).columns["field_x"]), 0)

    def test_often(self):
        """The short way of calls that repeat each other: same bits, errors, warnings; nothing breaks when only it is left."""
        a, b = ratchet(), ratchet()
        for k in range(600):
            a.advance(10)
        b.advance(6000)
        self.assertEqual(a.hash(), b.hash())
        a.observe(10, lambda s: 1 / 0)
        with self.assertRaises(ZeroDivisionError):
            a.advance(10)
        for k in range(2):
            b.advance(10)
        advance = b.advance
        del b
        gc.collect()
        with self.assertRaises(ReferenceError):
            for k in range(600):
                advance(10)
        s = slipdisk.Simulation({**FREE, "bounds": {"x": [-1, 1], "y": [-1, 1]}},
                                disks={"x": [0.0], "y": [0.0], "radius": 0.1, "mass": 1, "vx": [0.5]})
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            for k in range(1000):
                s.advance(10)
        self.assertEqual(["left the bounds" in str(w.message) for w in caught], [True])

    def test_program(self):
        """The program's numbers, bit by bit."""
        s = ratchet()
        s.advance()
        with tempfile.TemporaryDirectory() as folder:
            r = slipdisk.run(RATCHET, os.path.join(folder, "r.h5"), SHORT)
            for name in ("x", "y", "theta", "omega", "contact_zeta", "loss_friction"):
                np.testing.assert_array_equal(r.state[name], s.columns[name])
            for name in ("omega", "error", "scaled", "turned"):
                self.assertEqual(r.rotation[name][0], s.rotation[name][0], name)
            self.assertEqual(r.slide["pm"][0], s.slide["pm"][0])
            self.assertEqual(r.configurations["name"].tolist(), [f"upper.{c}" for c in ("pp", "pm", "mp", "mm", "stick", "open")])
            self.assertEqual(s.configurations["steps"].sum(), 100_000)
            for name in s.configurations.dtype.names:
                np.testing.assert_array_equal(r.configurations[name], s.configurations[name], name)
            self.assertEqual(r.energy, s.energy)
            np.testing.assert_array_equal(r.last_contacts["force"], s.contacts["force"])

    def test_means(self):
        s = slipdisk.Simulation({**GRAINS, "measure": {"disks": True}, "time": 0.2},
                                disks={"x": [-0.3, 0, 0.3], "y": 0.1, "radius": 0.05, "density": 1, "omega": [1.0, 2.0, 3.0]})
        s.advance()
        self.assertEqual(s.means["disk"].tolist(), [0, 1, 2])
        np.testing.assert_allclose(s.means["omega"], [1, 2, 3], rtol=1e-9)

    def test_interrupt(self):
        """Ctrl-C ends a long call after a step, and the simulation goes on."""
        s = slipdisk.Simulation(RATCHET, {"phases.settle.steps": 2_000_000_000})
        threading.Timer(0.3, lambda: os.kill(os.getpid(), 2)).start()
        with self.assertRaises(KeyboardInterrupt):
            s.advance()
        self.assertGreater(s.step, 0)
        before = s.step
        s.advance(1)
        self.assertEqual(s.step, before + 1)


class Reading(unittest.TestCase):
    def test_views(self):
        """Views follow the system, cannot be written, and keep it alive."""
        s = ratchet()
        x = s.columns["x"]
        before, pointer = x.copy(), x.ctypes.data
        s.advance(5000)  # across the end of a phase
        self.assertFalse(np.array_equal(before, x))
        np.testing.assert_array_equal(x, s.columns["x"])
        self.assertEqual(s.columns["x"].ctypes.data, pointer)
        with self.assertRaises(ValueError):
            x[0] = 1
        kept = x.copy()
        del s
        gc.collect()
        np.testing.assert_array_equal(x, kept)

    def test_views_of_many(self):
        """Where slots are put in order anew (end of a phase, 1000 disks) and contacts come and go."""
        deck = {**GRAINS, "integrator": "verlet", "phases": [{"name": "a", "steps": 300}, {"name": "b", "steps": 300}], "time": None,
                "walls": {"floor": {"type": "line", "points": [[-1, 0], [1, 0]]}}}
        rng = np.random.default_rng(2)
        place = lattice(1600, 0.041)
        s = slipdisk.Simulation(deck, disks={"x": place["x"] + rng.uniform(-5e-4, 5e-4, 1600), "y": place["y"], "radius": 0.02, "density": 3.0,
                                             "vx": rng.normal(size=1600)})
        view, contacts = s.columns["y"], s.contacts
        s.advance()
        np.testing.assert_array_equal(view, s.columns["y"])
        self.assertEqual(len(contacts), 0)
        self.assertGreater(len(s.contacts), 100)
        c = s.contacts[0]
        y, r = s.disks["y"], s.disks["radius"]
        if c["b"] < s.n_disks:
            apart = np.hypot(s.disks["x"][c["a"]] - s.disks["x"][c["b"]], y[c["a"]] - y[c["b"]])
            self.assertAlmostEqual(apart, r[c["a"]] + r[c["b"]] - c["overlap"], 9)

    def test_names_and_units(self):
        s = ratchet()
        self.assertEqual((s.columns.unit("vx"), s.find("left"), s.name(1)), ("length/time", 1, "left"))
        self.assertIn("x", list(s.disks))
        self.assertEqual(s.disks["angle"].shape, (3,))
        s.advance(100)
        np.testing.assert_array_equal(s.disks["angle"], s.disks["turn"] + s.disks["theta"])
        self.assertTrue(np.isnan(s.disks["x2"][1]), "a column of free disks")
        for wrong in (lambda: s.columns["nix"], lambda: s.find("uper"), lambda: s.disks["contact_a"]):
            with self.assertRaises(KeyError):
                wrong()
        with self.assertRaisesRegex(slipdisk.UnknownName, 'no .uper. in the names of bodies; did you mean .upper.'):
            s.find("uper")

    def test_energy(self):
        s = ratchet()
        s.advance(5000)
        e = s.energy
        closed = (e.kinetic_translation + e.kinetic_rotation + e.elastic_normal + e.elastic_tangential + e.elastic_rolling
                  + e.cohesion + e.external - e.start - e.work - e.nonconservative_work + e.viscous + e.friction + e.rolling
                  + e.bridge + e.opening + e.drag + e.damping + e.relaxed)
        self.assertAlmostEqual(closed, e.residual, 12)
        self.assertEqual(e["work"], e.work)
        self.assertLess(abs(e.residual), 1e-6 * e.scale)

    def test_mean(self):
        rng = np.random.default_rng(4)
        m = slipdisk.mean(rng.normal(3, 2, 40_000))
        self.assertLess(abs(m.mean - 3), 5 * m.error)
        self.assertAlmostEqual(m.error, 0.01, 2)
        y = rng.normal(5, 1, 40_000)
        m = slipdisk.mean(2 * y + rng.normal(0, 3, 40_000), over=y)  # the noise that both have does not count
        self.assertLess(abs(m.mean - 2), 5 * m.error)
        self.assertAlmostEqual(m.error, 3 / 200 / 5, delta=3e-4)
        self.assertEqual(slipdisk.mean(4 * y, over=y).error, 0)
        self.assertAlmostEqual(slipdisk.mean(y, over=np.ones(40_000)).error, slipdisk.mean(y).error, 12)
        for x, over in ((y, y[1:]), ([[1.0]], None), (y, [[1.0]])):
            with self.assertRaisesRegex(slipdisk.UserError, r"mean: (x|over): expected \(\w+,\), got"):
                slipdisk.mean(x, over=over)
        self.assertTrue(np.isnan(slipdisk.mean([], over=[]).mean))


class Extending(unittest.TestCase):
    def test_observers(self):
        """They are called at multiples, change no bit, can stop, and what they raise is raised."""
        s, plain = ratchet(), ratchet()
        seen = []

        @s.observe(500)
        def look(simulation):
            seen.append((simulation.step, simulation.energy.work))

        s.advance(2250)
        plain.advance(2250)
        self.assertEqual([step for step, _ in seen], [500, 1000, 1500, 2000])
        self.assertEqual(s.hash(), plain.hash())
        s.observe(100, lambda simulation: simulation.step >= 2700)
        s.advance(10_000)
        self.assertEqual(s.step, 2700)

        @s.observe(7)
        def fail(simulation):
            raise ZeroDivisionError("of an observer")

        with self.assertRaisesRegex(ZeroDivisionError, "of an observer"):
            s.advance(1000)
        self.assertEqual(s.step, 2702)

    def test_force(self):
        """A harmonic trap: the period is that of the spring, the work is in the budget, the budget closes."""
        k, mass = 4.0, 1.0
        s = slipdisk.Simulation(FREE, disks={"x": [1.0, -3.0, 7.0], "y": [0.0, 10.0, 20.0], "radius": 0.5, "mass": mass})
        steps = []

        @s.add_force
        def trap(c):
            steps.append(c.step)
            c.force_x -= k * c.x[:c.n_free]
            c.torque += 0.1

        s.advance(1000)
        self.assertEqual(steps[-1], 1000)
        self.assertEqual(len(steps), len(set(steps)))
        w = np.sqrt(k / mass)
        np.testing.assert_allclose(s.disks["x"], np.array([1, -3, 7]) * np.cos(w), atol=1e-5)
        np.testing.assert_allclose(s.disks["omega"], 0.1 / (mass * 0.25 / 2), rtol=1e-6)
        e = s.energy
        self.assertAlmostEqual(e.work / (k / 2 * 59 * (1 - np.cos(w) ** 2) + 3 * 0.1 * 0.4), 1, 5)
        self.assertLess(abs(e.residual), 1e-5 * e.scale)

    def test_force_fails(self):
        """What a force raises ends the step; nothing is called after it, and it is raised once."""
        s = ratchet()
        calls = []

        @s.add_force
        def fail(c):
            calls.append(c.step)
            if c.step == 1500:
                raise RuntimeError("of a force")

        with self.assertRaisesRegex(RuntimeError, "of a force"):
            s.advance(5000)
        self.assertEqual((s.step, calls[-1]), (1500, 1500))
        s.advance(10)
        self.assertEqual(s.step, 1510)
        s, plain = ratchet(), ratchet()
        with self.assertRaises(AttributeError):
            s.add_force(lambda c: c.fx)
        s.advance(100)
        plain.advance(100)
        self.assertEqual(s.disks["x"].tolist(), plain.disks["x"].tolist())

    def test_disks_come_and_go(self):
        s = slipdisk.Simulation(GRAINS, disks={"x": [0.0], "y": [0.02], "radius": 0.02, "density": 1})
        s.advance(100)
        view = s.columns["x"]
        with self.assertRaises(BufferError):
            s.add_disks(x=0.2, y=0.5, radius=0.02, density=1)
        del view
        self.assertEqual(s.add_disks(x=[0.2, 0.4], y=0.5, radius=[0.02, 0.03], density=1.0, vy=-1).tolist(), [1, 2])
        self.assertEqual((s.n_disks, s.find("floor")), (3, 3))
        np.testing.assert_allclose(s.disks["mass"][1:], np.pi * np.array([0.02, 0.03]) ** 2)
        s.advance(500)
        s.remove_disks([1])
        self.assertEqual(s.disks["activity"].tolist(), [0, 2, 0])
        s.advance(100)
        self.assertLess(abs(s.energy.residual), 1e-2 * s.energy.scale)
        for wrong in (lambda: s.add_disks(x=0, y=1, radius=-1, mass=1), lambda: s.add_disks(x=0, y=1, radius=1),
                      lambda: s.add_disks(x=0, y=1, radius=1, mass=1, colour=3), lambda: s.remove_disks([1])):
            with self.assertRaises(slipdisk.UserError):
                wrong()

    def test_saving(self):
        """A file, bytes, pickle and a clone go on with the same bits; so does a checkpoint of the program."""
        s = ratchet()
        s.advance(3000)
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "s.h5")
            s.save(path)
            others = [slipdisk.Simulation.load(path), slipdisk.Simulation.from_bytes(s.to_bytes()), pickle.loads(pickle.dumps(s)), s.clone()]
            self.assertEqual(slipdisk.Result(path).step, 3000)
            with self.assertRaises(slipdisk.FileError):
                s.save(os.path.join(folder, "not", "there.h5"))
            with self.assertRaises(slipdisk.Error):
                slipdisk.Simulation.load(os.path.join(folder, "nix.h5"))
        for other in (s, *others):
            other.advance(5000)
            self.assertEqual(other.step, 8000)
        self.assertEqual({other.hash() for other in others}, {s.hash()})


class Errors(unittest.TestCase):
    def check(self, kind, pattern, function):
        with self.assertRaisesRegex(kind, pattern) as caught:
            function()
        return caught.exception

    def test_deck(self):
        """All mistakes at once, with their places; of dicts by their keys, of arrays by the disk."""
        e = self.check(slipdisk.UserError, "did you mean", lambda: slipdisk.Simulation(
            {"dt": "fast", "time": 1, "materials": {"a": {"k_n": 1, "mo": 2}}}))
        self.assertGreater(len(e.messages), 2)
        self.assertEqual(e.status, 2)
        self.assertIsInstance(e, ValueError)
        self.assertTrue(all(not line.startswith("deck:") for line in e.messages), e.messages)
        self.assertEqual(pickle.loads(pickle.dumps(e)).messages, e.messages)
        self.check(slipdisk.UserError, r"disks\[1\]: radius", lambda: slipdisk.Simulation(
            FREE, disks={"x": [0, 3, 6], "y": [0, 0, 0], "radius": [1, -1, 1], "density": 1}))
        self.check(slipdisk.UserError, "differ in length: x 2, y 3", lambda: slipdisk.Simulation(
            FREE, disks={"x": [0, 3], "y": [0, 0, 0], "radius": 1, "density": 1}))
        e = self.check(slipdisk.UserError, "did you mean 'omega'", lambda: slipdisk.Simulation(
            FREE, disks={"x": [0, 3], "y": np.zeros((2, 2)), "radius": 1, "omga": [0, 1]}))
        self.assertEqual([line.split(":")[0] for line in e.messages], ["disks.y", "no 'omga' in the keys of disks; did you mean 'omega'?", "disks"])
        self.check(slipdisk.UserError, "argument disks", lambda: slipdisk.Simulation({**FREE, "disks": {"x": [0, 1], "y": [0, 1]}}))
        self.check(slipdisk.UserError, "text of one", lambda: slipdisk.Simulation(slipdisk.deck_text(FREE)))
        self.check(slipdisk.UserError, r"-D gravity\.tlt", lambda: slipdisk.Simulation(RATCHET, {"gravity.tlt": 0.1}))
        self.check(slipdisk.UserError, "nix.cfg", lambda: slipdisk.Simulation("nix.cfg"))
        self.check(slipdisk.UserError, "finite", lambda: slipdisk.Simulation({"dt": np.nan}))
        self.check(slipdisk.UserError, r"phases\[0\]\.x: expected a number", lambda: slipdisk.Simulation({"phases": [{"x": object()}]}))

    def test_numeric(self):
        """Two disks that are shot into one another: which, and at which step."""
        s = slipdisk.Simulation(FREE, disks={"x": [0.0, 3.0], "y": [0.0, 0.0], "radius": 1, "mass": 1, "vx": [100.0, -100.0]})
        e = self.check(slipdisk.NumericError, "step", lambda: s.advance(1000))
        self.assertEqual(e.status, 3)

    def test_arguments(self):
        s = ratchet()
        self.check(slipdisk.UserError, "expected 0 or more", lambda: s.advance(-1))
        self.check(slipdisk.UserError, "not both", lambda: s.advance(1, time=1))
        for steps in (1.5, 5.0, 1e6, np.float64(5)):
            self.check(slipdisk.UserError, r"whole number of steps.*or advance\(time=", lambda: s.advance(steps))
        s.advance(np.int64(10))
        self.assertEqual(s.step, 10)
        self.check(slipdisk.UserError, "expected 1 or more", lambda: s.observe(0, print))
        self.check(slipdisk.UserError, "body 7", lambda: s.name(7))

    def test_end(self):
        """Beyond the end of the run a warning says what was not made; a deck without a length has no end."""
        s = slipdisk.Simulation(FREE, disks={"x": [0.0], "y": [0.0], "radius": 1, "mass": 1})
        end = s.steps * s.dt
        with self.assertWarnsRegex(slipdisk.Warning, f"the run ended at step {s.steps}, time .*, 100 of {s.steps + 100} steps before"):
            s.advance(time=end + 100 * s.dt)
        self.assertTrue(s.finished)
        for call in (lambda: s.advance(time=1), lambda: s.advance(7)):
            with self.assertWarnsRegex(slipdisk.Warning, "the run was over before, at step .*: no step was made"):
                call()
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            s.advance()
            s.advance(0)
            endless = slipdisk.Simulation({k: v for k, v in FREE.items() if k not in ("steps", "time", "phases")},
                                          disks={"x": [0.0], "y": [0.0], "radius": 1, "mass": 1})
            endless.advance(1000)
        self.assertFalse(endless.finished)
        self.check(slipdisk.UserError, "this run has no end", endless.advance)

    def test_steering(self):
        """Changes between steps: closed forms, the budget, the same bits of a clone and a loaded one, names."""
        deck = {"dt": 1e-3, "gravity": {"g": 10.0}, "materials": [{"name": "grain", "k_n": 1e4}, {"name": "steel", "k_n": 1e4}],
                "material_pairs": [{"materials": ["grain", "steel"], "k_n": 1e4}],
                "disks": {"ball": {"x": 0, "y": 0, "radius": 1, "mass": 2, "material": "grain"},
                          "plate": {"x": 9, "y": 0, "radius": 1, "mass": 1, "material": "steel", "fixed": True}},
                "motions": {"push": {"disk": "plate", "coordinate": "x", "type": "velocity", "velocity": 1.0}}}
        s = slipdisk.Simulation(deck)
        s.disks["vx"] = [2.0, 1.0]  # of the fixed disk: as it is
        s.set("vy", 1.0, "ball")
        s.advance(time=1)
        np.testing.assert_allclose(s.get("position", 0), (2, 1 - 5), atol=1e-12)
        np.testing.assert_allclose(s.gravity, (0, -10))
        s.gravity = 1, 0
        s.set("motion.velocity", -2, "push")
        s.set("law.k_n", [2e4, 3e4], ["grain", ("grain", "steel")])
        self.assertEqual([s.get("law.k_n", p) for p in ("grain", "steel", ("steel", "grain"))], [2e4, 1e4, 3e4])
        copies = s, s.clone(), slipdisk.Simulation.from_bytes(s.to_bytes(), threads=2)
        for other in copies:
            other.advance(time=1)
            other.release(["plate"])
            other.advance(time=1)
            np.testing.assert_allclose(other.disks["x"], (2 + 4 + 2, 9 + 1 - 2 - 2 + 0.5), atol=1e-11)
            self.assertLess(abs(other.energy.residual), 1e-11 * other.energy.scale)
        self.assertEqual(len({other.hash() for other in copies}), 1)
        s.hold("plate")
        self.assertEqual(s.get("held").tolist(), [0, 1])
        s.disks["x"] += 1.0  # of both: the held one too
        np.testing.assert_allclose(s.get("x"), (9, 7.5), atol=1e-11)

    def test_steering_refused(self):
        s = ratchet()
        x = s.disks["x"]
        hash = s.hash()
        for name in ("x", "vx", "angle"):
            self.check(slipdisk.UserError, "is a copy: to change the simulation", lambda: s.disks[name].__setitem__(0, 1.0))
        with self.assertRaises(ValueError):
            np.add(x, 1, out=x)
        with self.assertRaises(ValueError):
            x[1:][0] = 1
        y = x.copy()
        y[0] = 1
        z = x + 1
        z[0] = 5
        x -= 1
        x[0] = 1
        self.assertEqual((y[0], z[0], x[0]), (1, 5, 1))
        for pattern, call in (
                ("did you mean", lambda: s.set("velocty", 1, 0)), ("fixed or driven", lambda: s.set("vx", 1, 1)),
                ("did you mean 'upper'", lambda: s.set("vx", 1, "uper")), ("no material is called 'x'", lambda: s.set("law.mu", 1, "x")),
                ("no motion is called 'x'", lambda: s.set("motion.amplitude", 1, "x")), ("last argument", lambda: s.set("law.mu", 1)),
                (r"expected one number or \(3,\), got \(2,\)", lambda: s.set("vx", [1, 2])), ("expected numbers", lambda: s.set("vx", "a", 0)),
                ("fixed or driven", lambda: s.disks.__setitem__("vx", 3.0)), ("what can be set", lambda: s.disks.__setitem__("force_x", 3.0)),
                ("walls cannot be set", lambda: s.walls.__setitem__("x", 3.0)), ("whole number", lambda: s.set("vx", 1, 0.5)),
                ("expected a number of at most 1e100", lambda: s.set("vx", np.nan, 0)), ("max_overlap", lambda: s.set("radius", 3, 0))):
            self.check(slipdisk.UserError, pattern, call)
        self.assertEqual(s.hash(), hash)

        @s.observe(1)
        def steers(sim):
            sim.set("vx", 1, 0)
        self.check(slipdisk.UserError, "observer", lambda: s.advance(1))

    def test_warnings(self):
        """What leaves the bounds is warned of, at the caller's line."""
        deck = {**FREE, "bounds": {"x": [-1, 1], "y": [-1, 1]}}
        s = slipdisk.Simulation(deck, disks={"x": [0.0], "y": [0.0], "radius": 0.1, "mass": 1, "vx": [50.0]})
        for piece in (1000, 100_000):
            s = slipdisk.Simulation(deck, disks={"x": [0.0], "y": [0.0], "radius": 0.1, "mass": 1, "vx": [50.0]})
            with warnings.catch_warnings(record=True) as caught:
                warnings.simplefilter("always")
                s.advance(piece)
            self.assertEqual([w.category for w in caught], [slipdisk.Warning])
            self.assertIn("left the bounds", str(caught[0].message))
            self.assertEqual(caught[0].filename, __file__)
        with self.assertWarnsRegex(slipdisk.Warning, "dt = 5e-05 is more than"):  # as check advises
            slipdisk.Simulation(RATCHET, {"dt": 5e-5})

    def test_no_library(self):
        """Results are read without the library; what is missing is told when it is needed."""
        code = ("import slipdisk\n"
                "try:\n    slipdisk.version()\nexcept slipdisk.FileError as error:\n    print(error)")
        import subprocess
        done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True,
                              env={**os.environ, "SLIPDISK_LIBRARY": "/not/there.so", "PYTHONPATH": str(ROOT / "tools/python")})
        self.assertIn("libslipdisk.so not found (/not/there.so); build it", done.stdout, done.stderr)


if __name__ == "__main__":
    unittest.main(verbosity=1)
