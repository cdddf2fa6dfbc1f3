"""docs/deck_tasks.md, docs/units.md and docs/gallery.md: what stands there is taken by the program, and does what is said.

- Every example of the page by task, put into a small deck in place of what that has of the same keys, passes `slipdisk check`.
- Every key of the left column of its table stands in it, and exists.
- The two decks of the page on units give the same physics, in their units.
- The runs of the gallery are runs of decks that ship, with keys that they have.
"""
import os
import pathlib
import re
import shlex
import subprocess
import sys
import tempfile
import unittest

ROOT = pathlib.Path(os.environ.get("SLIPDISK_SOURCE_DIR", pathlib.Path(__file__).resolve().parents[2]))
PROGRAM = os.environ.get("SLIPDISK_PROGRAM", str(ROOT / "build/release/slipdisk"))
sys.path.insert(0, str(ROOT / "tools/python"))

import slipdisk  # noqa: E402

# A box with a lid, some grains and a disk of a name, for examples that refer to them.
BASE = {
    "dt": "dt = 1e-5;",
    "gravity": "gravity = { g = 9.81; };",
    "materials": 'materials = ( { name = "grain"; k_n = 1e4; k_t = 5e3; gamma_n = 2; mu = 0.5; } );',
    "disks": 'disks = ( { name = "ball"; x = 0; y = 0.021; radius = 0.02; density = 3.57; } );',
    "disk_rows": 'disk_rows = ( { columns = ("x", "y", "radius"); density = 1; group = "grains";'
                 ' rows = ( (0.041, 0.021, 0.02), (0.2, 0.1, 0.02) ); } );',
    "container": 'container = { type = "box"; width = 1; height = 2; open = false; };',
    "phases": 'phases = ( { name = "run"; time = 0.2; } );',
}
ROW = re.compile(r"^\| (.+?) \| \[(.+?)\]\(.*?\).*? \| (.+) \|$", re.M)
FILES = {
    "grains.csv": "x,y,radius\n0.3,1,0.02\n0.4,1,0.03\n",
    "measured.csv": "PosX,PosY,Diameter\n0.3,1,0.04\n0.4,1,0.06\n",
    "motion.csv": "time,value\n0,0\n0.1,0\n0.2,1\n0.3,0\n0.4,0\n",
    "packing.data": "grains\n\n1 atoms\n1 atom types\n-1 1 xlo xhi\n-1 3 ylo yhi\n-0.5 0.5 zlo zhi\n\n"
                    "Atoms # sphere\n\n1 1 0.04 1000 0.3 1.2 0\n",
}


def program(*words, folder=None):
    return subprocess.run([PROGRAM, *map(str, words)], cwd=folder, capture_output=True, text=True, check=False)


def deck_of(example):
    """The small deck, with what the example sets in place of its own. None: not for a deck."""
    parts = [part for part in re.findall(r"`([^`]+)`", example) if part.endswith(";")]
    if not parts:
        return None
    keys = dict(BASE)
    for part in parts:
        key = re.match(r"\w+", part)[0]
        keys[key] = part
    if "time" in keys or "steps" in keys:
        keys.pop("phases")
    if "container" in keys and any('name = "floor"' in part for part in parts):
        keys["container"] = ""
    if 'type = "hopper"' in keys["container"]:
        keys["disks"], keys["disk_rows"] = (
            re.sub(r"0\.021|0\.1(?=, 0.02)", "0.9", keys[key]) for key in ("disks", "disk_rows"))
    if "material_pairs" in keys:
        for key, material in (("disks", "grain"), ("disk_rows", "grain"), ("container", "steel")):
            keys[key] = keys[key].replace("{ ", f'{{ material = "{material}"; ', 1)
    if "box = { x" in keys.get("box", ""):
        keys["container"] = ""
        keys["walls"] = 'walls = ( { name = "floor"; type = "line"; points = ( (-1, 0), (1, 0) ); } );'
    return "\n".join(keys.values()) + "\n"


class Tasks(unittest.TestCase):
    def setUp(self):
        self.rows = ROW.findall((ROOT / "docs/deck_tasks.md").read_text())
        self.assertGreater(len(self.rows), 50)

    def test_examples_are_taken(self):
        with tempfile.TemporaryDirectory() as folder:
            folder = pathlib.Path(folder)
            for name, text in FILES.items():
                (folder / name).write_text(text)
            (folder / "base.cfg").write_text("\n".join(BASE.values()))
            done = program("run", "base.cfg", "-o", "packing.h5", "-D", "phases[0].time=1e-4",
                           "-D", "disks[0].name=first", "-D", "disks[0].y=1.5", "-D", "disk_rows[0].group=old", "--quiet", folder=folder)
            self.assertEqual(done.returncode, 0, done.stderr)
            for task, _, example in self.rows:
                text = deck_of(example)
                if text is None:
                    self.assertIn("-D", example, task)
                    continue
                with self.subTest(task):
                    if "packing.h5" in text:
                        text = text.replace(BASE["disks"], "").replace(BASE["disk_rows"], "")
                    (folder / "deck.cfg").write_text(text)
                    done = program("check", "deck.cfg", folder=folder)
                    self.assertEqual(done.returncode, 0, f"{done.stderr}\n{text}")
                    self.assertNotIn("warning", done.stderr)

    def test_keys_stand_in_their_examples(self):
        keys = program("check", "--keys").stdout
        for task, named, example in self.rows:
            for key in re.findall(r"`([^`]+)`", named):
                last = key.split(".")[-1]
                with self.subTest(task):
                    self.assertTrue(last in example or "time" in example, key)
                    if key != "-D":
                        self.assertIn(last, keys)


class Units(unittest.TestCase):
    def test_both_decks_are_one_system(self):
        page = (ROOT / "docs/units.md").read_text()
        si, reduced = re.findall(r"^```\n(# .*?)^```", page, re.M | re.S)
        mass, length, g = 4.5e-3, 0.02, 9.81
        time = (length / g) ** 0.5
        with tempfile.TemporaryDirectory() as folder:
            results = []
            for name, text in (("si", si), ("reduced", reduced)):
                path = pathlib.Path(folder, name + ".cfg")
                path.write_text(text)
                done = program("run", path, "-o", path.with_suffix(".h5"), "--quiet")
                self.assertEqual((done.returncode, done.stderr), (0, ""))
                results.append(slipdisk.Result(path.with_suffix(".h5")))
            self.compare(*results, mass, length, g, time)

    def compare(self, a, b, mass, length, g, time):
        self.assertAlmostEqual(a.time / time, b.time, delta=1e-9 * b.time)
        self.assertEqual(a.step, b.step)
        scales = {"x": length, "y": length, "vx": length / time, "vy": length / time, "angle": 1, "omega": 1 / time,
                  "mass": mass, "radius": length, "inertia": mass * length**2}
        for name, scale in scales.items():
            for one, other in zip(a.disks[name] / scale, b.disks[name]):
                self.assertAlmostEqual(one, other, delta=1e-6 * max(1, abs(other)), msg=name)
        energy = mass * g * length
        for name in ("viscous", "friction"):
            self.assertGreater(b.energy[name], 0.01)
            self.assertAlmostEqual(a.energy[name] / energy, b.energy[name], delta=1e-6 * b.energy[name], msg=name)


class Gallery(unittest.TestCase):
    def test_runs(self):
        runs = re.findall(r"^slipdisk (?:run|sweep) (inputs/\S+) -o \S+(.*)$", (ROOT / "docs/gallery.md").read_text(), re.M)
        self.assertGreater(len(runs), 10)
        for deck, rest in runs:
            with self.subTest(deck):
                words = shlex.split(rest)
                overrides = [word for k, word in enumerate(words) if "-D" in (word, words[k - 1] if k else "")]
                done = program("check", ROOT / deck, *overrides)
                self.assertEqual(done.returncode, 0, done.stderr)


if __name__ == "__main__":
    unittest.main()
