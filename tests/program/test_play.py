"""The engine in WebAssembly, in Node and in a headless Chromium: its states are those of the program, bit by bit, and its
module does what slipdisk.d.mts says.

    SLIPDISK_SPEED=N python3 tests/program/test_play.py    prints the table of docs/play.md, the best of N runs of each kind
"""
import base64
import gzip
import json
import os
import pathlib
import re
import shutil
import subprocess
import tempfile
import time
import unittest

import h5py
import numpy
from chromium import browser

ROOT = pathlib.Path(os.environ.get("SLIPDISK_SOURCE_DIR", pathlib.Path(__file__).resolve().parents[2]))
PROGRAM = os.environ.get("SLIPDISK_PROGRAM", str(ROOT / "build/release/slipdisk"))
PLAY = ROOT / "build/play"
RUNS = ROOT / "tests/play_runs.mjs"
SPEED = int(os.environ.get("SLIPDISK_SPEED", 0))
ALL = 10**9  # steps, more than any run has

# A million steps of the paper's three disks, and packings with disks that come to rest, roll, and are rigid bodies.
SHAKE = {"motions.shake.acceleration": 2, "motions.shake.ramp": 0.05, "phases.rest.time": 0.6, "phases.thermalise.time": 0.15,
         "phases.measure.time": 0.3}
CASES = {
    "random": ("paper/random.cfg", {"phases.settle.steps": 200000, "phases.measure.steps": 800000}),
    "sync": ("paper/sync.cfg", {"phases.rest.steps": 200000, "phases.measure.steps": 800000}),
    "async": ("paper/async.cfg", {"phases.rest.steps": 200000, "phases.measure.steps": 800000}),
    "shaken box": ("packing/shake_low.cfg", SHAKE),
    "shaken box, Gear": ("packing/shake_low.cfg", {**SHAKE, "integrator": "gear5"}),
    "clumps": ("clumps/dimers.cfg", {"packings[0].count": 20, "container.width": 0.25, "phases.fall.time": 0.2}),
}
SPEEDS = {
    "three disks, paper/random.cfg": ("paper/random.cfg", {"phases.settle.steps": 200000, "phases.measure.steps": 3800000}),
    "three disks, paper/sync.cfg": ("paper/sync.cfg", {"phases.rest.steps": 200000, "phases.measure.steps": 3800000}),
    "box of 60 disks, packing/shake_low.cfg": ("packing/shake_low.cfg", {**SHAKE, "phases.measure.time": 4}),
    "drum of 100 disks, packing/drum.cfg": ("packing/drum.cfg", {
        "container.radius": 8, "packings[0].count": 100, "motions.turn.velocity": -0.1, "motions.turn.ramp": 1,
        "phases.fill.time": 8, "phases.start.time": 4, "phases.flow.time": 40}),
    "sheared box of 500 disks, shear/simple.cfg": ("shear/simple.cfg", {
        "packings[0].count": 500, "container.width": 26.2, "container.height": 26.2, "phases.slow.time": 5, "phases.fast.time": 5}),
}
TWO = """dt = 1e-4; gravity = { g = 10; };
materials = ( { name = "glass"; k_n = 1e4; k_t = 8e3; gamma_n = 2; mu = 0.5; } );
disks = ( { name = "low"; x = 0; y = 0.0999; radius = 0.1; mass = 0.1; }, { name = "top"; x = 0; y = 0.2997; radius = 0.1; mass = 0.1; } );
walls = ( { name = "floor"; type = "line"; points = ( (-1, 0), (1, 0) ); } );
"""


def job(file, keys):
    path = ROOT / "inputs" / file
    return {"deck": path.read_text(), "files": {f.name: f.read_text() for f in path.parent.glob("*.inc")}, "set": keys, "steps": ALL}


def node(jobs):
    done = subprocess.run(["node", RUNS, PLAY / "slipdisk.mjs"], input=json.dumps(jobs), capture_output=True, text=True, check=False)
    if done.returncode:
        raise RuntimeError(done.stderr)
    return json.loads(done.stdout)


def native(file, keys, folder):
    """Hash and steps of the program's run, and its wall time in seconds."""
    result = pathlib.Path(folder) / "native.h5"
    result.unlink(missing_ok=True)
    words = [word for key, value in keys.items() for word in ("-D", f"{key}={value}")]
    began = time.perf_counter()
    subprocess.run([PROGRAM, "run", ROOT / "inputs" / file, *words, "-o", result, "--threads", "1", "--quiet"], check=True,
                   stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, env={**os.environ, "SLIPDISK_PATH": "baseline"})
    took = time.perf_counter() - began
    with h5py.File(result) as stored:
        found = stored["state"].attrs["hash"]
        return found.decode() if isinstance(found, bytes) else found, int(stored["state/step"][()]), took


class SameBits(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.mkdtemp()
        cls.addClassCleanup(shutil.rmtree, cls.folder)
        cls.jobs = [job(*case) for case in CASES.values()]
        cls.expected = [native(*case, cls.folder)[:2] for case in CASES.values()]

    def compare(self, found):
        for name, ours, theirs in zip(CASES, found, self.expected):
            with self.subTest(case=name):
                self.assertNotIn("error", ours)
                self.assertEqual((ours["hash"], ours["step"]), theirs)

    def test_in_node(self):
        self.compare(node(self.jobs))

    def test_in_chromium(self):
        """A page opened from a folder, in which module and engine lie, packed."""
        page = pathlib.Path(self.folder) / "page.html"
        text = "\n".join(f.read_text() for f in (PLAY / "slipdisk.mjs", RUNS)).replace("export ", "")
        engine = base64.b64encode(gzip.compress((PLAY / "slipdisk.wasm").read_bytes())).decode()
        page.write_text(f'<!doctype html><meta charset="utf-8"><script type="text/plain" id="slipdisk-wasm">{engine}</script>'
                        f'<script type="module">{text}\nwindow.run = async (jobs) => outcomes(await load(), jobs);</script>')
        driver = browser()
        self.addCleanup(driver.quit)
        driver.set_script_timeout(120)
        driver.get(page.as_uri())
        self.compare(driver.execute_async_script(
            "const done = arguments[1]; window.run(arguments[0]).then(done, (error) => done([{ error: String(error) }]))", self.jobs))
        self.assertEqual([entry["message"] for entry in driver.get_log("browser")], [])

    def test_steps_in_parts(self):
        """However the steps are divided, also where that is within a phase."""
        whole, = node([{**self.jobs[3], "steps": 12345}])
        parts, = node([{**self.jobs[3], "steps": 5, "then": [["advance", 12000], ["hash"], ["contacts"], ["advance", 340]]}])
        self.assertEqual(whole["hash"], parts["hash"])


class Module(unittest.TestCase):
    def one(self, **words):
        found, = node([{"deck": TWO, **words}])
        return found

    def asked(self, *calls, **words):
        found = self.one(ask=calls, **words)
        self.assertNotIn("error", found)
        return found["asked"]

    def test_mistakes(self):
        found = self.one(deck=TWO.replace("mass", "mas", 1) + "gravty = { g = 1; };\n")
        self.assertEqual((found["name"], found["status"]), ("SlipdiskError", 2))
        self.assertIn('deck:3: disks[0].mas = 0.1: unknown key of disks; did you mean "mass"?', found["messages"])
        self.assertIn('deck:5: gravty: unknown key; did you mean "gravity"?', found["messages"])
        self.assertEqual(found["error"], "\n".join(found["messages"]))
        self.assertIn('@include "none.inc"', self.one(deck='@include "none.inc"\n' + TWO)["error"].replace("include file ", "@include "))
        self.assertIn("the page has not given this file", self.one(deck=TWO + 'disk_files = ( { file = "a.h5"; } );')["error"])

    def test_mistakes_in_calls(self):
        for call, told in ((["advance", 2.5], "advance(2.5): expected a whole number"),
                           (["advance", -3], "expected 0 or more"),
                           (["grab", 99, 0, 0, 10], "99 is no free disk"),
                           (["grab", 1, "far", 0, 10], "to be finite"),
                           (["setLaw", "muh", 0.3], 'did you mean "law.mu"?')):
            with self.subTest(call=call):
                self.assertIn(told, self.one(ask=[call])["error"])
        self.assertIn("did you mean", self.one(then=[["set", "law.mue", 1]])["error"])
        self.assertIn("there is no such column", self.one(ask=[["column", "z"]])["error"])
        self.assertIn("freed", self.one(then=[["free"]])["error"])
        failed = self.one(set={"max_overlap": 0.01}, steps=100, then=[["set", "vy", -50, "top"], ["advance", 1000]])
        self.assertEqual(failed["status"], 3)
        self.assertIn("overlap", failed["error"])

    def test_warnings(self):
        self.assertTrue(any("k_t" in line for line in self.one(deck=TWO.replace("k_t = 8e3", "k_t = 0"))["warnings"]))

    def test_decks_as_objects(self):
        """The text of an object is a deck; settings and files replace and add."""
        deck = {"dt": 1e-4, "gravity": {"g": 10}, "materials": [{"name": "glass", "k_n": 1e4, "k_t": 8e3, "gamma_n": 2, "mu": 0.5}],
                "disks": [{"name": "low", "x": 0, "y": 0.0999, "radius": 0.1, "mass": 0.1},
                          {"name": "top", "x": 0, "y": 0.2997, "radius": 0.1, "mass": 0.1}],
                "walls": [{"name": "floor", "type": "line", "points": [[-1, 0], [1, 0]]}]}
        text, made, included, listed = node([
            {"deck": TWO, "steps": 1000}, {"deck": deck, "steps": 1000},
            {"deck": '@include "two.inc"', "files": {"two.inc": TWO}, "steps": 1000},
            {"deck": TWO, "set": ["materials.glass.mu=0.1"], "ask": [["get", "law.mu"], ["deck"]]}])
        self.assertEqual({text["hash"]}, {made["hash"], included["hash"]})
        self.assertEqual(listed["asked"][0], 0.1)
        self.assertIn('name = "glass"', listed["asked"][1])

    def test_reading(self):
        x, ids, disks, free, bodies, floor, name, none, step, t, dt, finished = self.asked(
            ["column", "x"], ["column", "id"], ["disks"], ["freeDisks"], ["bodies"], ["find", "floor"], ["name", 2], ["find", "z"],
            ["step"], ["time"], ["dt"], ["finished"])
        self.assertEqual((x[:2], ids, disks, free, bodies, floor), ([0, 0], [0, 1, 2], 2, 2, 3, 2))
        self.assertEqual((name, none, step, t, dt, finished), ('wall "floor"', -1, 0, 0, 1e-4, False))

    def test_contacts_and_walls(self):
        """At rest the floor carries both disks; the points lie on the floor and between the disks."""
        c, walls, forces, energy = self.asked(["contacts"], ["walls"], ["column", "contact_force"], ["energy"], steps=20000)
        self.assertEqual((c["n"], c["a"], sorted(c["b"]), c["normal"]), (2, [0, 0], [1, 2], forces))
        on_floor = c["b"].index(2)
        numpy.testing.assert_allclose([c["y"][on_floor], c["nx"][on_floor], c["ny"][on_floor]], [0, 0, -1], atol=1e-3)
        upward = [f * ny + t * nx for f, t, nx, ny in zip(c["normal"], c["tangential"], c["nx"], c["ny"])]
        self.assertAlmostEqual(upward[on_floor], -2, delta=0.1)  # force on the floor: two weights of 1
        self.assertEqual(walls, [{"body": 2, "name": 'wall "floor"', "kind": "line", "points": [-1, 0, 1, 0], "closed": False,
                                  "center": [0, 0], "radius": 0, "inside": False}])
        self.assertLess(abs(energy["residual"]), 1e-6)  # of the fall, 1e-4

    def test_steering(self):
        mu, gravity, y, released, first, removed = self.asked(
            ["get", "law.mu"], ["get", "gravity", 1], ["column", "y"], ["get", "vx", "low"], ["addDisks", [
                {"x": 0.5, "y": 0.5, "radius": 0.1, "mass": 0.1, "vy": 1}]], ["removeDisks", [0]], steps=10, then=[
                    ["setLaw", "mu", 0.25], ["set", "gravity", [0, -3]], ["set", "position", [0.3, 0.4], 1],
                    ["set", "vx", [0.125], ["low"]]])
        self.assertEqual((mu, gravity, y[1], released, first, removed), (0.25, -3, 0.4, 0.125, 2, None))

    def test_grip(self):
        """The spring lifts the upper disk until it carries its weight; its work closes the budget."""
        (y, energy), (fallen,) = self.asked(["column", "y"], ["energy"], then=[["grab", 1, 0, 0.8, 50, 5], ["advance", 40000]]), self.asked(
            ["column", "y"], then=[["grab", 1, 0, 0.8, 50, 5], ["advance", 40000], ["release"], ["advance", 2000]])
        self.assertAlmostEqual(y[1], 0.8 - 0.1 * 10 / 50, delta=1e-3)
        self.assertGreater(energy["work"], 0.1 * 10 * 0.4)
        self.assertLess(abs(energy["residual"]), 1e-5)
        self.assertLess(fallen[1], 0.6)

    def test_rotation(self):
        turn, none = node([{**job("paper/sync.cfg", {"phases.rest.steps": 1000, "phases.measure.steps": 400000}),
                            "ask": [["rotation"], ["rotation", 1]]}])[0]["asked"]
        self.assertEqual((turn["disk"], none), (0, None))
        self.assertGreater(turn["error"], 0)

    def test_example(self):
        done = subprocess.run(["node", ROOT / "tools/play/example.mjs"], capture_output=True, text=True, check=True)
        self.assertRegex(done.stdout, r"mean angular velocity 0\.04\d+ \+- 0\.00\d+\n")
        self.assertEqual(len(re.findall(r"slides|sticks", done.stdout)), 2)

    def test_interface(self):
        """Each member of the typed interface is in the module, and each public member of the module in the interface."""
        types, text = ((ROOT / "tools/play" / name).read_text() for name in ("slipdisk.d.mts", "slipdisk.mjs"))
        declared = re.search(r"export interface Simulation \{(.*?)\n\}", types, re.DOTALL)[1]
        declared = set(re.findall(r"^  (?:readonly )?(\w+)[(:]", declared, re.MULTILINE))
        simulation = text[text.index("class Simulation"):]
        defined = set(re.findall(r"^  (?:get )?(\w+)\(", simulation, re.MULTILINE)) - {"constructor"} | {"warnings"}
        self.assertEqual(declared, defined)


def table(repeats):
    print("| run | native, ns | Node, ns | ratio |\n| --- | ---: | ---: | ---: |")
    with tempfile.TemporaryDirectory() as folder:
        for name, case in SPEEDS.items():
            ours, theirs = [], []
            for _ in range(repeats):
                _, steps, took = native(*case, folder)
                found, = node([job(*case)])
                theirs.append(took * 1e9 / steps / found["free"])
                ours.append(found["seconds"] * 1e9 / steps / found["free"])
            print(f"| {name} | {min(theirs):.0f} | {min(ours):.0f} | {min(ours) / min(theirs):.2f} |", flush=True)


if __name__ == "__main__":
    if SPEED:
        table(SPEED)
    else:
        unittest.main()
