"""The Python package: results of runs, finished or not, and sweeps; runs by the program."""
import csv
import os
import pathlib
import signal
import subprocess
import sys
import tempfile
import time
import types
import unittest
import unittest.mock
import warnings

import h5py
import numpy as np

ROOT = pathlib.Path(os.environ.get("SLIPDISK_SOURCE_DIR", pathlib.Path(__file__).resolve().parents[2]))
PROGRAM = os.environ.setdefault("SLIPDISK_PROGRAM", str(ROOT / "build/release/slipdisk"))
os.environ["SLIPDISK_LIBRARY"] = "/none"  # results are read without it
sys.path.insert(0, str(ROOT / "tools" / "python"))
sys.dont_write_bytecode = True

import slipdisk  # noqa: E402

DECK = ROOT / "inputs/three_disk/random.cfg"
SHORT = {"phases.settle.steps": 2000, "phases.measure.steps": 30_000, "phases.measure.series": 100, "phases.measure.frames": 500,
         "phases.measure.contacts": 1000}
GRAINS = {
    "dt": 1e-4, "integrator": "verlet", "gravity": {"g": 9.81}, "materials": {"grain": {"k_n": 1e3, "k_t": 5e2, "gamma_n": 0.5, "mu": 0.1}},
    "container": {"type": "box", "width": 0.2, "height": 0.4},
    "packings": [{"type": "random", "fraction": 0.3, "density": 3.57, "radius": 0.02, "y": [0, 0.2]}],
    "phases": {"fall": {"steps": 1500}, "measure": {"steps": 2000, "series": 100, "frames": 500}}, "measure": {"disks": True},
}


class Folder(unittest.TestCase):
    def setUp(self):
        self.temporary = tempfile.TemporaryDirectory(prefix="slipdisk-test-")
        self.folder = pathlib.Path(self.temporary.name)
        self.path = self.folder / "r.h5"

    def tearDown(self):
        self.temporary.cleanup()


class Results(Folder):
    def test_empty_table(self):
        """A table of contacts from before any disk touches has columns and no rows."""
        phases = [{"name": "fall", "steps": 1500, "contacts": 500}]
        r = slipdisk.run({**GRAINS, "phases": phases}, self.path)
        self.assertEqual([len(r.contacts[k]) == n for k, n in enumerate(r.contacts.count)], [True] * 4)
        self.assertEqual(len(r.contacts[0]["force"]), 0)

    def test_finished(self):
        """What h5py reads, by short names; rotation and slide beside what info says."""
        r = slipdisk.run(DECK, self.path, SHORT)
        self.assertTrue(r.finished)
        self.assertEqual((r.step, r.dt, r.names), (32_000, 1e-6, ["upper", "left", "right"]))
        with h5py.File(self.path) as file:
            np.testing.assert_array_equal(r.series["work"], file["observables/work/value"][:])
            np.testing.assert_array_equal(r.series["time"], file["observables/angle/time"][:])
            np.testing.assert_array_equal(r.frames["position"], file["particles/disks/position/value"][:])
            np.testing.assert_array_equal(r.frames[-2]["velocity"], file["particles/disks/velocity/value"][-2])
            first, count = file["contacts/first"][:], file["contacts/count"][:]
            self.assertEqual(len(r.contacts), len(count))
            for k in (0, 3, len(count) - 1):
                np.testing.assert_array_equal(r.contacts[k]["tau"], file["contacts/tau"][first[k]:first[k] + count[k]])
            np.testing.assert_array_equal(r.disks["radius"], file["particles/disks/radius"][:])
            np.testing.assert_allclose(np.c_[r.disks["x"], r.disks["y"]], r.frames[-1]["position"], rtol=0, atol=1e-12)
            self.assertIn("# full deck", r.deck_full)
            self.assertIn("eps_b" if "eps_b" in r.deck_text else "three disks", r.deck_text)
        info = slipdisk.info(self.path)
        self.assertEqual(r.rotation["omega"][0], info["rotation"][0]["omega"])
        self.assertEqual(r.slide["pm"][0], info["sliding"][0]["S+-"])
        self.assertEqual(r.slide["name"][0].tolist(), ["upper", "left", "right"])
        self.assertEqual(dict(r.energy), info["energy"])
        self.assertEqual(r.doubts, [])
        self.assertEqual(r.phases["name"].tolist(), ["settle", "measure"])
        self.assertIsNone(r.means)
        self.assertEqual(r.series.unit("work"), "energy")
        self.assertEqual(r.series.array("time", "angle").dtype["angle"].shape, (1,))

    def test_unfinished(self):
        """Parts one after the other are the beginning of the finished result; refresh() follows the run."""
        overrides = {**SHORT, "phases.measure.steps": 40_000_000, "phases.measure.series": 10_000, "phases.measure.frames": 30_000,
                     "phases.measure.contacts": 70_000, "checkpoint": 0.05}
        words = [PROGRAM, "run", str(DECK), "-o", str(self.path), "--quiet"]
        for key, value in overrides.items():
            words += ["-D", f"{key}={value}"]
        process = subprocess.Popen(words)
        end = time.monotonic() + 300

        def few():
            try:
                r = slipdisk.Result(self.path)
                return len(r._parts) < 4 or len(r.contacts) < 4
            except slipdisk.Error:
                return True  # there is no checkpoint yet

        while few() and process.poll() is None and time.monotonic() < end:
            time.sleep(0.01)
        during = slipdisk.Result(self.path)  # while it runs
        self.assertFalse(during.finished)
        self.assertEqual(during.series["step"][-1] <= during.step, True)
        process.send_signal(signal.SIGINT)
        self.assertEqual(process.wait(), 75)
        before = during.step
        self.assertGreaterEqual(during.refresh().step, before)
        halted = slipdisk.Result(str(self.path) + ".parts")
        self.assertFalse(halted.finished)
        self.assertGreater(len(halted._parts), 3)
        kept = {name: halted.series[name] for name in halted.series}
        frames, contacts, last = halted.frames["position"], halted.contacts["force"], halted.frames[-1]["position"]
        np.testing.assert_array_equal(frames[-1], last)
        np.testing.assert_array_equal(halted.contacts[3]["force"], contacts[6:8])
        self.assertEqual(halted.names, ["upper", "left", "right"])
        self.assertEqual(halted.disks["radius"].tolist(), [1, 1, 1])
        steps = halted.step + 10_000
        deck = self.folder / "again.cfg"
        deck.write_text(halted.deck_full)
        whole = slipdisk.run(deck, self.folder / "whole.h5", {"phases.measure.steps": steps - 2000, "checkpoint": 60})
        for name, column in kept.items():
            np.testing.assert_array_equal(whole.series[name][:len(column)], column, name)
        np.testing.assert_array_equal(whole.frames["position"][:len(frames)], frames)
        np.testing.assert_array_equal(whole.contacts["force"][:len(contacts)], contacts)

    def test_packing(self):
        """A dict is written beside the result; means of every disk, walls, totals."""
        r = slipdisk.run(GRAINS, self.path)
        self.assertTrue((self.folder / "r.cfg").exists())
        n = r.summary.disks
        self.assertEqual(r.means.shape, (n,))
        self.assertAlmostEqual(float(np.sqrt(np.mean(r.means["omega"] ** 2))), r.totals.omega_rms, 12)
        self.assertEqual(r.wall_frames["position"].shape, (len(r.frames), r.summary.walls, 2))
        self.assertEqual(r.box.tolist(), [0, 0])
        self.assertEqual(len(r.last_contacts), r.summary.contacts)
        with self.assertRaisesRegex(slipdisk.UserError, "finished"):
            slipdisk.run(GRAINS, self.path)
        slipdisk.run(GRAINS, self.path, force=True)

    def test_pandas(self):
        r = slipdisk.run(DECK, self.path, SHORT)
        with unittest.mock.patch.dict(sys.modules, pandas=types.SimpleNamespace(DataFrame=dict)):
            frame = r.series.pandas("time", "angle")
        self.assertEqual(list(frame), ["time", "angle[0]"])

    def test_mistakes(self):
        with self.assertRaisesRegex(slipdisk.FileError, "nix.h5: no such result, nor .*nix.h5.parts"):
            slipdisk.Result("nix.h5")
        text = self.folder / "text.h5"
        text.write_text("no HDF5")
        with self.assertRaisesRegex(slipdisk.FileError, "text.h5"):
            slipdisk.Result(text)
        with h5py.File(self.path, "w") as file:
            file["x"] = 1
        with self.assertRaisesRegex(slipdisk.FileError, "not a result of slipdisk"):
            slipdisk.Result(self.path)
        os.unlink(self.path)
        with self.assertRaisesRegex(slipdisk.UserError, r"gravity\.g = -1"):
            slipdisk.run(DECK, self.path, {"gravity.g": -1})
        r = slipdisk.run(DECK, self.path, SHORT)
        with self.assertRaisesRegex(slipdisk.UnknownName, "did you mean 'friction'"):
            r.series["fricton"]
        with self.assertRaisesRegex(slipdisk.UnknownName, "no 'place' in frames"):
            r.frames["place"]
        with self.assertRaises(IndexError):
            r.frames[1000]

    def test_doubt(self):
        """A run in doubt is warned of and read."""
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            r = slipdisk.run(DECK, self.path, {**SHORT, "limits.residual": 1e-90})
        self.assertEqual([d.name for d in r.doubts], ["residual"])
        self.assertIn("residual", str(caught[-1].message))
        self.assertTrue(r.doubts[0].value > r.doubts[0].limit)


class Sweeps(Folder):
    def test_sweep(self):
        """The table has the numbers of table.csv in its order; points are results."""
        deck = {"dt": 1e-6, **{"gravity": {"g": 10}}, "materials": {"disk": {"k_n": 1e3, "k_t": 1e6, "gamma_n": 10, "mu": 0.1}},
                "disks": {"upper": {"x": 0, "y": 0, "radius": 1, "mass": 0.1, "omega": 0.1}}, "walls": {"floor": {
                    "type": "line", "points": [[-1, -1], [1, -1]]}}, "steps": 2000, "measure": {"rotation": ["upper"]},
                "sweep": {"parameters": [{"path": "gravity.g", "name": "g", "values": [5, 10.0]}], "replicas": 2}}
        folder = self.folder / "s.sweep"
        with self.assertRaisesRegex(slipdisk.FileError, "not the folder of a sweep"):
            slipdisk.Sweep(self.folder)
        s = slipdisk.sweep(deck, folder, jobs=2)
        with open(folder / "table.csv", newline="") as file:
            rows = list(csv.DictReader(file))
        self.assertEqual(list(s.table.dtype.names), list(rows[0]))
        self.assertEqual(s["name"].tolist(), [row["name"] for row in rows])
        self.assertEqual(s["upper.omega"].tolist(), [float(row["upper.omega"]) for row in rows])
        self.assertEqual(s["g"].tolist(), [5, 5, 10, 10])
        self.assertEqual((len(s), len(s.done), len(s.means)), (4, 4, 2))
        self.assertEqual(s.means["g"].tolist(), [5, 10])
        self.assertEqual(s.unit("upper.omega"), "rad/time")
        self.assertEqual(s[2].rotation["omega"][0], s["upper.omega"][2])
        self.assertEqual(s["g=5"].path, s[0].path)
        self.assertEqual(len(list(s.results())), 4)
        with unittest.mock.patch.dict(sys.modules, pandas=types.SimpleNamespace(DataFrame=dict)):
            self.assertEqual(list(s.pandas())[:3], ["point", "name", "status"])
        with self.assertRaisesRegex(slipdisk.UnknownName, "did you mean 'upper.omega'"):
            s["upper.omga"]
        # a point that is not there, and no table
        os.unlink(s.path("g=10"))
        subprocess.run([PROGRAM, "sweep", str(self.folder / "s.cfg"), "-o", str(folder), "--table"], check=True, capture_output=True)
        self.assertEqual(s.refresh()["status"].tolist(), ["done", "done", "waiting", "done"])
        self.assertTrue(np.isnan(s["upper.omega"][2]))
        self.assertEqual((len(s.done), len(list(s.results()))), (3, 3))
        os.unlink(folder / "table.h5")
        bare = slipdisk.Sweep(folder)
        self.assertEqual(bare.names, ["g=10,r=1", "g=5", "g=5,r=1"])
        with self.assertRaisesRegex(slipdisk.FileError, "--table makes it"):
            bare.table


if __name__ == "__main__":
    unittest.main(verbosity=1)
