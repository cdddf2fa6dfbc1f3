"""The Python package where it is called at the wrong moment, or with arguments that cannot be: signals, callbacks, threads, forks."""
import gc
import os
import signal
import sys
import tempfile
import threading
import time
import unittest

import numpy as np

import package  # noqa: F401

import slipdisk

DECK = {"dt": 1e-3, "steps": 100_000_000, "integrator": "verlet", "materials": {"grain": {"k_n": 1e4}}}


def made(n=9, threads=1):
    k = np.arange(n)
    return slipdisk.Simulation(DECK, disks={"x": k % 40 * 1.0, "y": k // 40 * 1.0, "radius": 0.4, "mass": 1.0,
                                            "vx": np.sin(k), "name": [f"d{j}" for j in k]}, threads=threads)


def none(_):
    pass


def signal_within(s, number, later, ready=lambda: True):
    """A thread that sends a signal once `advance` is under way, as numbers are then refused to other threads, and `ready`."""
    def send():
        try:
            while s.step >= 0:
                time.sleep(0.001)
        except slipdisk.UserError:
            time.sleep(later)
        while not ready():
            time.sleep(0.001)
        os.kill(os.getpid(), number)

    thread = threading.Thread(target=send)
    thread.start()
    return thread


class Signals(unittest.TestCase):
    def test_ctrl_c_arrives(self):
        """KeyboardInterrupt comes out of `advance`, whatever is called in each step; the system is good, and goes on."""
        def slowly(_):
            sum(range(30))

        def observed(s):
            s.observe(1, slowly)

        def forced(s):
            s.add_force(slowly)

        def both(s):
            observed(s)
            forced(s)

        for kind in (none, observed, forced, both):
            for k in range(10):
                s = made()
                kind(s)
                sender = signal_within(s, signal.SIGINT, 0.001 * k)
                with self.assertRaises(KeyboardInterrupt):
                    s.advance()
                sender.join()
                step = s.step
                s.advance(10)
                self.assertEqual(s.step, step + 10)
                plain = made()
                if kind in (forced, both):
                    plain.add_force(none)
                plain.advance(s.step)
                self.assertEqual(plain.hash(), s.hash())

    def test_any_signal_arrives(self):
        """So does what the handler of another signal raises; other exceptions that cannot be raised go where they went."""
        def late(*_):
            raise TimeoutError("late")

        seen = []
        before, sys.unraisablehook = sys.unraisablehook, lambda what: seen.append(what.exc_type)
        old = signal.signal(signal.SIGALRM, late)
        try:
            class Broken:
                def __del__(self):
                    raise ValueError

            for k in range(10):
                s = made()
                s.observe(1, lambda s: Broken() and None if s.step == 3 else None)
                sender = signal_within(s, signal.SIGALRM, 0.001 * k, lambda: len(seen) > k)
                with self.assertRaises(TimeoutError):
                    s.advance()
                sender.join()
            self.assertEqual(seen, [ValueError] * 10)
            self.assertEqual(sys.unraisablehook.__name__, "<lambda>")
        finally:
            signal.signal(signal.SIGALRM, old)
            sys.unraisablehook = before


def entries(s, folder):
    """All that a simulation can do, and where else than between two steps: o in observers, f in forces."""
    return {
        "advance": (lambda: s.advance(1), ""), "advance(0)": (lambda: s.advance(0), ""),
        "advance(time)": (lambda: s.advance(time=0.1), ""), "observe": (lambda: s.observe(9**9, none), ""),
        "add_force": (lambda: s.add_force(none), ""), "add_disks": (lambda: s.add_disks(x=9, y=900, radius=0.1, mass=1), ""),
        "remove_disks": (lambda: s.remove_disks([3]), ""), "__init__": (lambda: s.__init__(DECK), "never"),
        "save": (lambda: s.save(os.path.join(folder, "s.h5")), "o"), "to_bytes": (s.to_bytes, "o"), "clone": (s.clone, "o"),
        "hash": (s.hash, "o"), "columns": (lambda: s.columns["x"].sum(), "o"), "disks": (lambda: s.disks["angle"], "o"),
        "walls": (lambda: s.walls["x"], "o"), "contacts": (lambda: s.contacts, "o"), "energy": (lambda: s.energy, "o"),
        "rotation": (lambda: s.rotation, "o"), "slide": (lambda: s.slide, "o"), "means": (lambda: s.means, "o"),
        "configurations": (lambda: s.configurations, "o"), "step": (lambda: s.step, "of"), "time": (lambda: s.time, "of"),
        "dt": (lambda: s.dt, "of"), "steps": (lambda: s.steps, "of"), "finished": (lambda: s.finished, "of"),
        "stage": (lambda: s.stage, "of"), "n_disks": (lambda: s.n_disks, "of"), "n_walls": (lambda: s.n_walls, "of"),
        "find": (lambda: s.find("d1"), "of"), "name": (lambda: s.name(1), "of"), "deck": (lambda: s.deck, "of"),
        "threads": (lambda: s.threads, "of"), "repr": (lambda: repr(s), "of")}


class Moments(unittest.TestCase):
    def walk(self, s, where, folder):
        for name, (call, good) in entries(s, folder).items():
            try:
                call()
                self.found.append((name, where, where in good))
            except slipdisk.UserError as error:
                self.found.append((name, where, not (where in good) and ("not " in str(error) or "made" in str(error) or "another" in str(error))))

    def test_everywhere(self):
        """All of it in observers, forces and another thread: served or refused, and the same bits after."""
        for n, threads in ((9, 1), (2100, 2)):
            self.found, s, plain = [], made(n, threads), made(n, 1)
            folder = tempfile.TemporaryDirectory()
            plain.add_force(none)

            def force(c):
                if c.step == 3:
                    self.walk(s, "f", folder.name)

            s.add_force(force)
            s.observe(5, lambda s: self.walk(s, "o", folder.name))

            def beside(s):
                thread = threading.Thread(target=self.walk, args=(s, "t", folder.name))
                thread.start()
                thread.join()

            s.observe(7, beside)
            s.advance(9)
            plain.advance(9)
            self.assertEqual(len(self.found), 3 * len(entries(s, folder.name)))
            self.assertEqual([f for f in self.found if not f[2]], [])
            self.assertEqual(s.hash(), plain.hash())
            folder.cleanup()

    def test_two_threads(self):
        """Each call is served or refused; the steps that were served are made."""
        s, made_steps = made(400), []

        def work():
            for _ in range(300):
                try:
                    s.advance(2)
                    made_steps.append(2)
                except slipdisk.UserError:
                    pass

        threads = [threading.Thread(target=work) for _ in range(2)]
        [t.start() for t in threads]
        [t.join() for t in threads]
        self.assertEqual(s.step, sum(made_steps))
        plain = made(400)
        plain.advance(s.step)
        self.assertEqual(s.hash(), plain.hash())

    def test_fork(self):
        """A child steps on with the same bits, or only lets go."""
        s = made(2100, 2)
        s.advance(5)
        plain = s.clone()
        plain.advance(5)
        want = plain.hash()
        for steps in (5, 0):
            child = os.fork()
            if child == 0:
                s.advance(steps)
                good = steps == 0 or s.hash() == want
                del s
                gc.collect()
                os._exit(0 if good else 1)
            self.assertEqual(os.waitpid(child, 0)[1], 0)
        s.advance(5)
        self.assertEqual(s.hash(), want)

    def test_arrays_of_a_force(self):
        """What a force keeps of its columns holds add_disks up; afterwards disks come."""
        for keep in (lambda c: c.force_x, lambda c: c.x[2:], lambda c: c, lambda c: c.torque.reshape(3, 3)):
            s, kept = made(), []
            s.add_force(lambda c: kept.append(keep(c)) if not kept else None)
            s.advance(3)
            with self.assertRaises(BufferError):
                s.add_disks(x=9, y=900, radius=0.1, mass=1)
            kept[0] = True
            s.add_disks(x=9, y=900, radius=0.1, mass=1)
            s.advance(3)


class Arguments(unittest.TestCase):
    def test_all(self):
        s, folder = made(), tempfile.gettempdir()
        data, before = s.to_bytes(), s.hash()
        disk = dict(x=9.0, y=900.0, radius=0.1, mass=1.0)
        nan, inf = float("nan"), float("inf")
        wrong = {
            **{f"remove_disks {d!r:.30}": (lambda d=d: s.remove_disks(d), "nix" if d == "nix" else "disk") for d in (
                2**32 + 7, 9.9, 7.0, -1, 9, nan, "nix", None, True, [[1]], [2**70], 1j)},
            **{f"advance {n!r}": (lambda n=n: s.advance(n), "advance") for n in (-1, 1.5, nan, inf, 2**70, "3", [1], True)},
            **{f"time {t!r}": (lambda t=t: s.advance(time=t), "time") for t in (-1, nan, inf, 1e300)},
            **{f"every {n!r}": (lambda n=n: s.observe(n, none), "every") for n in (0, -1, 1.5, 2**64 + 1, None, "3")},
            **{f"name {n!r}": (lambda n=n: s.name(n), "body") for n in (-1, 9, 2**32, 0.5, "d1")},
            **{f"find {n!r}": (lambda n=n: s.find(n), "") for n in ("a\0b", 3, None, "")},
            **{f"path {p!r}": (lambda p=p: s.save(p), "path") for p in (folder + "/a\0b", 3.5, None)},
            **{f"load {p!r}": (lambda p=p: slipdisk.Simulation.load(p), "path") for p in ("a\0b", 3.5, None)},
            **{f"threads {n!r}": (lambda n=n: slipdisk.Simulation(DECK, disks=disk, threads=n), "threads") for n in (
                -1, 2**32 + 1, 1.5, None, "2")},
            **{f"bytes {type(b)}": (lambda b=b: slipdisk.Simulation.from_bytes(b), "") for b in (b"", data[:-5], "text", 3, None)},
            **{f"function {f!r}": (lambda f=f: s.observe(1, f), "function") for f in (3, "f")},
            **{f"force {f!r}": (lambda f=f: s.add_force(f), "function") for f in (3, None)},
            **{f"add_disks {key} = {v!r:.30}": (lambda key=key, v=v: s.add_disks(**{**disk, key: v}), key.replace("_", ".")) for key, values in {
                "x": (nan, inf, 1e308, "1", None, 1j, [[1.0]], [1, 2, 3, [4]]), "y": ([1.0, 900.0, nan],),
                "radius": (1e300, nan, 0, -1, [1, 2]), "mass": (nan, -1, 0, 1e300), "vx": (1e200, nan), "omega": (inf,),
                "material": (0.7, 1, -1, 2**32, nan, "grain"), "inertia": (-1, nan), "torque": (nan,), "force_x": (inf,),
                "colour": (1,)}.items() for v in values if not (key == "radius" and isinstance(v, list))},
            "lengths": (lambda: s.add_disks(x=[1, 2], y=[900, 901, 902], radius=0.1, mass=1), "differ in length"),
            "mass and density": (lambda: s.add_disks(**disk, density=1), "mass or density"),
            "on another": (lambda: s.add_disks(**{**disk, "x": 3.0, "y": 0.0}), "same centre"),
            "deep in another": (lambda: s.add_disks(**{**disk, "x": 3.0, "y": 0.1}), "overlap by"),
            "two at once": (lambda: s.add_disks(**{**disk, "x": [3.5, 3.5], "y": 50}), "same centre"),
            "deck": (lambda: slipdisk.Simulation({**DECK, "title": "a\0b"}, disks=disk), ""),
            "override": (lambda: slipdisk.Simulation(DECK, {"title": "a\0b"}, disks=disk), "null byte"),
            "made again": (lambda: s.__init__(DECK), "made")}
        for name, (call, says) in wrong.items():
            with self.subTest(name):
                with self.assertRaisesRegex(slipdisk.Error, says):
                    call()
        self.assertEqual(s.hash(), before)
        s.remove_disks(np.array([3], np.int8))
        self.assertEqual(s.add_disks(x=np.float32([9, 11])[::-1], y=np.array(900), radius=0.1, density=1).tolist(), [9, 10])
        self.assertEqual(s.disks["x"][9:].tolist(), [11, 9])
        s.advance(3)


if __name__ == "__main__":
    unittest.main()
