"""sim.measure() and result.measure(): every value of `slipdisk measure --json`, digit for digit, of a simulation in memory, of the
last state and of stored frames; boxes of frames."""
import json
import pickle
import signal

import h5py
import numpy as np

from results_common import LONG, ROOT, Folder, start, wait_for
from test_cell_readers import DECK as PERIODIC
from test_cell_readers import PRESS
from test_measure_command import BOX

import package  # noqa: F401

import slipdisk

INPUTS = ROOT / "inputs"
CASES = {  # deck: its text, or a file and what shortens it
    "walls": BOX,
    "sheared": PERIODIC + PRESS + "output = { frames = 250; };\n",
    "clumps": (INPUTS / "clumps/dimers.cfg", {
        "dt": 2e-5, "packings[0].count": 40, "container.width": 0.2, "phases.fall.steps": 20000, "output.frames": 10000}),
    "hertz": (INPUTS / "laws/hertz_mindlin.cfg", {
        "packings[0].count": 60, "container.width": 8, "container.height": 12, "phases.pour.time": 3, "phases.pour.frames": 50000}),
    "drum": (INPUTS / "packing/drum.cfg", {
        "packings[0].count": 60, "container.radius": 6, "phases.fill.time": 10, "phases.start.time": 1, "phases.flow.time": 1,
        "phases.flow.frames": 500}),
    "few": (INPUTS / "three_disk/random.cfg", {
        "phases.settle.steps": 20000, "phases.measure.steps": 20000, "output.frames": 20000}),
    "flight": (INPUTS / "collisions/two_disks.cfg", {"output.frames": 100}),  # no contact at the end
}


class Measure(Folder):
    def made(self, case):
        deck = CASES[case]
        path, overrides = deck if isinstance(deck, tuple) else (self.folder / f"{case}.cfg", {})
        if isinstance(deck, str):
            path.write_text(deck)
        result = slipdisk.run(path, self.folder / f"{case}.h5", overrides)
        sim = slipdisk.Simulation(path, overrides)
        sim.advance()
        return result, sim

    def json(self, result, *words):
        out, _ = self.run_ok("measure", result.path, "--json", *words)
        return json.loads(out)["frames"]

    def equal(self, m, frame):
        """All values of a frame of the JSON are in the measurement, and the other way round."""
        left = {(group, key) if isinstance(values, dict) else (group,): value for group, values in frame.items()
                for key, value in (values if isinstance(values, dict) else {None: values}).items()}
        left.pop(("frame",))
        sides = [side for side, is_open in zip(("left", "right", "bottom", "top"), m.region_open) if is_open]
        self.assertEqual(left.pop(("region", "open")), sides)
        for name, path in m.json.items():
            place, found = tuple(path.split(".")), m[name]
            if not path:
                continue
            expected = left.pop(place, left.get(place[:1]))  # a group is null if nothing in it is known
            if isinstance(expected, dict) or expected is None:  # nor is a single value
                self.assertTrue(np.isnan(found).all() or (name == "pairs_disks" and found < 2), (name, found, expected))
                continue
            if isinstance(found, np.ndarray):
                known = np.array([x if x is not None else np.nan for x in np.ravel(expected)]).reshape(np.shape(expected))
                np.testing.assert_array_equal(found, known, err_msg=name)
            else:
                self.assertIs(type(found), type(expected), (name, found, expected))
                self.assertEqual(found, expected, name)
            self.assertTrue(m.unit(name) and m.meaning(name), name)
        self.assertEqual([place for place, value in left.items() if value is not None], [])

    def test_all_values(self):
        for case in CASES:
            with self.subTest(case):
                result, sim = self.made(case)
                (state,), stored = self.json(result), [self.json(result, "--frame", k)[0] for k in range(len(result.frames))]
                self.assertGreater(len(stored), 1)
                last = result.measure()
                self.equal(last, state)
                now = sim.measure()
                self.assertEqual(list(now), list(last))
                for name in now:
                    np.testing.assert_array_equal(now[name], last[name], err_msg=name)
                for m, frame in zip(result.measure(slice(None)), stored):
                    self.equal(m, frame)
                self.assertEqual([m.step for m in result.measure([1, -1])], [stored[1]["step"], stored[-1]["step"]])
                self.equal(result.measure(0), stored[0])
                if case == "sheared":
                    continue
                x, y = last.region_x, last.region_y
                part = [*(x[0] + np.diff(x)[0] * np.array([0.1, 0.8])), *(y[0] + np.diff(y)[0] * np.array([0.05, 0.7]))]
                words = "--region=" + ",".join(map(repr, map(float, part))), "--bins=7"
                self.equal(result.measure(-1, region=part, bins=7), self.json(result, "--frame", len(stored) - 1, *words)[0])
                np.testing.assert_equal(dict(sim.measure(part, 7)), dict(result.measure(None, part, 7)))

    def test_what_they_mean(self):
        """The numbers of a sheared box, from positions and radii; names as attributes; units; a box for each frame."""
        result, sim = self.made("sheared")
        area = (np.pi * result.disks["radius"] ** 2).sum()
        with h5py.File(result.path) as file:
            edges = file["particles/disks/box/edges/value"][:]
        self.assertGreater(abs(edges[-1] - edges[0]).max(), 0.3)
        for k, frame in enumerate(result.frames):
            np.testing.assert_array_equal(frame.box, edges[k].diagonal())
            self.assertEqual(frame.box_offset, edges[k][1, 0])
            self.assertAlmostEqual(result.measure(k).fraction, area / np.prod(frame.box), 9)
        m = sim.measure()
        np.testing.assert_allclose([m.width, m.height], result.box, rtol=1e-12)
        self.assertAlmostEqual(m["fraction"], area / np.prod(result.box), 9)
        self.assertAlmostEqual(m.pressure, m.stress.trace() / 2, 12)
        self.assertEqual((m.stress.shape, m.g.shape, m.g_edges.shape), ((2, 2), (100,), (101,)))
        self.assertEqual((m.units["pressure"], m.unit("mean_force")), ("force/length", "force"))
        self.assertIn("pressure", dir(m))
        self.assertRegex(repr(m), r"(?m)^pressure +\S+ +force/length +half the trace")
        again = pickle.loads(pickle.dumps(result))
        self.assertEqual(again.measure(0).fraction, result.measure(0).fraction)
        self.assertEqual(pickle.loads(pickle.dumps(m)).z, m.z)

    def test_in_an_observer(self):
        """As it runs: the same numbers as of frames, and the same bits of the run."""
        result, _ = self.made("walls")
        sim, found = slipdisk.Simulation(self.folder / "walls.cfg"), []
        sim.observe(2000, lambda sim: found.append(sim.measure(bins=10)))
        sim.advance()
        self.assertEqual([m.step for m in found], list(result.frames.step[1:]))
        for m, k in zip(found, range(1, len(found) + 1)):
            stored = result.measure(k)
            self.assertEqual((m.closed, m.fraction, m.z), (stored.closed, stored.fraction, stored.z))
        plain = slipdisk.Simulation(self.folder / "walls.cfg")
        plain.advance()
        self.assertEqual(plain.hash(), sim.hash())

    def test_unfinished(self):
        """An unfinished run of several parts: its last state is that of the checkpoint, its frames have boxes."""
        for name, cell in ("bent", "cell = { rate_xx = 1e-5; rate_xy = 0.7; };"), ("still", ""):
            deck = self.folder / f"{name}.cfg"
            deck.write_text(PERIODIC + f"phases = ( {{ time = 1e5; frames = 250; {cell} }} ); checkpoint = 0.2;\n")
            path = self.folder / f"{name}.h5"
            process = start("run", deck, "-o", path, "--quiet")
            folder = self.folder / f"{name}.h5.parts"
            wait_for(lambda: len(list(folder.glob("part-*.h5"))) > 2 or process.poll() is not None)
            process.send_signal(signal.SIGTERM)
            _, err = process.communicate(timeout=LONG)
            self.assertEqual(process.returncode, 75, err)
            result = slipdisk.Result(path)
            self.assertFalse(result.finished)
            self.assertEqual(result.measure().step, result.step)
            boxes = result.frames.box
            self.assertEqual(boxes.shape, (len(result.frames), 2))
            for k in (0, 1, -1):
                np.testing.assert_array_equal(result.frames[k].box, boxes[k])
                np.testing.assert_allclose([result.measure(k).width, result.measure(k).height], boxes[k], rtol=1e-12)

    def test_refused(self):
        result, sim = self.made("sheared")
        for call, text in ((lambda: sim.measure(bins=0), "measure: bins = 0: expected 1 ..."),
                           (lambda: sim.measure(bins=10**6), "bins = 1000000: expected 1 ... 100000"),
                           (lambda: sim.measure(region=[0, 1, 2]), "measure: region = [0, 1, 2]: expected x0, x1, y0, y1"),
                           (lambda: sim.measure(region=[0, 1, 2, 3, 4]), "measure: region = [0, 1, 2, 3, 4]: expected x0, x1, y0, y1"),
                           (lambda: sim.measure(region="walls"), "measure: region = 'walls': expected x0, x1, y0, y1"),
                           (lambda: sim.measure(region=(1, 0, 0, 1)), "region = 1, 0, 0, 1: expected x0, x1, y0, y1 with x0 < x1"),
                           (lambda: sim.measure(region=(0, np.inf, 0, 1)), "region = (0, inf, 0, 1): expected x0, x1"),
                           (lambda: sim.measure(region=(0, 1, 0, 1)), "a region of a sheared box is not measured"),
                           (lambda: result.measure(99), "measure: frame = 99: expected -"),
                           (lambda: result.measure(1.5), "measure: frame = 1.5: expected a whole number"),
                           (lambda: sim.measure()["zz"], "no 'zz' in a measurement")):
            with self.assertRaises(slipdisk.UserError) as caught:
                call()
            self.assertIn(text, str(caught.exception))
        with self.assertRaises(AttributeError):
            sim.measure().zz
        forced = slipdisk.Simulation(self.folder / "sheared.cfg")
        with self.assertRaisesRegex(slipdisk.UserError, "sd_simulation_measure"):
            forced.add_force(lambda columns: forced.measure())


if __name__ == "__main__":
    import unittest
    unittest.main()
