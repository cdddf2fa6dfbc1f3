"""slipdisk measure: frames of finished, unfinished and moved results, against h5py; tables, options, messages."""
import csv
import json
import math
import shutil
import signal
import sys
import unittest

import h5py
import numpy as np

import results_common
from results_common import LONG, changed, run, start, wait_for

MATERIAL = '{ name = "m"; k_n = 1e4; k_t = 5e3; gamma_n = 5.0; mu = 0.4; }'
BOX = f"""
dt = 2e-4;
gravity = {{ g = 10.0; }};
materials = ( {MATERIAL} );
container = {{ type = "box"; width = 1.0; height = 1.5; }};
packings = ( {{ type = "rain"; count = 30; rows = 1; sizes = "uniform"; lower = 0.05; upper = 0.08; density = 100.0; }} );
phases = ( {{ steps = 8000; frames = 2000; contacts = 4000; }} );
"""
PERIODIC = f"""
dt = 2e-4;
materials = ( {MATERIAL} );
container = {{ type = "periodic"; width = 1.0; height = 2.0; }};
packings = ( {{ type = "random"; count = 60; sizes = "uniform"; lower = 0.03; upper = 0.06; density = 100.0; }} );
phases = ( {{ steps = 4000; frames = 1000; contacts = 1000; compress = {{ fraction = 0.7; rate = 0.2; }}; }} );
"""


def rows(path):
    with open(path) as file:
        return [{k: float(v) if v else math.nan for k, v in row.items()} for row in csv.DictReader(file)]


def rows_of_text(path):
    with open(path) as file:
        return list(csv.DictReader(file))


class Measure(results_common.Folder):
    def make(self, deck):
        self.deck = self.folder / "deck.cfg"
        self.deck.write_text(deck)
        self.run_ok("run", self.deck, "-o", self.result, "--quiet")

    def json(self, *words):
        out, _ = self.run_ok("measure", self.result, "--json", *words)
        return json.loads(out)["frames"]

    def refused(self, status, *words):
        got, out, err = run("measure", *words)
        self.assertEqual((got, out), (status, ""), err)
        return err

    def test_every_frame(self):
        self.make(BOX)
        self.deck.unlink()  # the result is enough
        frames = self.json("--all")
        with h5py.File(self.result) as file:
            disks = file["particles/disks"]
            self.assertEqual([f["step"] for f in frames], list(disks["position/step"]))
            tables = set(file["contacts/step"][:])
            radius, mass = disks["radius"][:], disks["mass"][:]
            for k, frame in enumerate(frames):
                self.assertEqual(frame["frame"], k)
                free = disks["activity/value"][k] != 1
                self.assertEqual(frame["disks"]["free"], np.count_nonzero(free))
                self.assertEqual(frame["disks"]["waiting"], np.count_nonzero(~free))
                self.assertEqual(frame["contacts"]["recomputed"], frame["step"] not in tables)
                # pairs that overlap, counted the slow way
                at = disks["position/value"][k][free]
                gap = np.hypot(*(at[:, None] - at[None]).transpose(2, 0, 1)) - radius[free][:, None] - radius[free]
                pairs = np.count_nonzero(np.triu(gap < 0, 1))
                contacts = frame["contacts"]
                self.assertEqual(contacts["closed"] - contacts["fixed"], pairs)
                self.assertAlmostEqual(contacts["z"], (2 * pairs + contacts["fixed"]) / np.count_nonzero(free), 12)
                v, spin = disks["velocity/value"][k][free], disks["angular_velocity/value"][k][free]
                energy = 0.5 * mass[free] @ (v ** 2).sum(axis=1) / np.count_nonzero(free)
                self.assertAlmostEqual(frame["stress"]["energy_translation"], energy, delta=1e-12 * energy)
            self.assertTrue(frames[0]["disks"]["waiting"] > 0 and frames[-1]["contacts"]["closed"] > 30)
            self.assertLess(frames[-1]["contacts"]["unbalanced"], 0.5)

    def test_last_state(self):
        self.make(BOX)
        (state,) = self.json()
        (frame,) = self.json("--frame", 4)
        self.assertIsNone(state.pop("frame"))
        self.assertEqual(frame.pop("frame"), 4)
        self.assertEqual(state, frame)
        (near,) = self.json("--time", 0.9)
        self.assertEqual(near["frame"], 2)
        with changed(self.result) as file:  # an older result: laws and walls come from the deck
            del file["parameters/model"]
        (old,) = self.json()
        old.pop("frame")
        self.assertEqual(old, state)
        with changed(self.result) as file:
            del file["parameters/deck_full"]
        self.assertIn("is not a result", self.refused(2, self.result))

    def test_tables(self):
        self.make(BOX)
        folder = self.folder / "tables"
        out, _ = self.run_ok("measure", self.result, "--csv", folder, "--bins", 20)
        self.assertIn("per disk", out)
        (frame,) = self.json("--bins", 20)
        self.assertEqual(sorted(p.name for p in folder.iterdir()),
                         ["contacts.csv", "disks.csv", "forces.csv", "frames.csv", "gr.csv"])
        disks, contacts = rows(folder / "disks.csv"), rows(folder / "contacts.csv")
        (total,) = rows(folder / "frames.csv")
        self.assertEqual(total["z"], frame["contacts"]["z"])
        self.assertEqual(len(contacts), frame["contacts"]["closed"])
        self.assertEqual(sum(d["contacts"] for d in disks), frame["contacts"]["z"] * len(disks))
        self.assertAlmostEqual(sum(d["cell"] for d in disks), frame["cells"]["total"], 12)
        self.assertAlmostEqual(sum(d["cell"] for d in disks), 1.5, 6)  # the box, but for overlaps with walls
        with h5py.File(self.result) as file:
            c = file["contacts"]
            last = slice(c["first"][-1], c["first"][-1] + c["count"][-1])
            for name in ("a", "b", "overlap", "force", "tau", "sliding"):
                self.assertTrue(np.allclose([row[name] for row in contacts], c[name][last], rtol=1e-13, atol=0), name)
        self.assertEqual(len(rows(folder / "gr.csv")), 20)
        forces = rows(folder / "forces.csv")
        self.assertEqual(len(forces), 20)
        inside = 1 - frame["normal_force"]["beyond"] / frame["normal_force"]["count"]
        self.assertAlmostEqual(sum(f["normal"] * (f["high"] - f["low"]) for f in forces), inside, 12)
        self.assertAlmostEqual(sum(f["mobilised"] / 20 for f in forces), 1, 12)
        written = self.folder / "found.json"
        out, _ = self.run_ok("measure", self.result, "-o", written, "--bins", 20)
        self.assertEqual(out, "")
        self.assertEqual(json.loads(written.read_text())["frames"], [frame])

    def test_friction_above_a_critical_load(self):
        """Two disks slide on a floor: one presses it with 1.5 times the critical load, the other with half of it."""
        disks = ", ".join(f'{{ x = {x}; y = {0.1 - 10 * mass / 1e4}; radius = 0.1; mass = {mass}; vx = 0.5; locked = ("theta"); }}'
                          for x, mass in ((0, 0.15), (1, 0.05)))
        self.make('dt = 2e-5; gravity = { g = 10.0; }; materials = ( { name = "m"; k_n = 1e4; k_t = 5e3; mu = 0.4; critical_load = 1; } );'
                  f' walls = ( {{ type = "line"; points = ( (-1, 0), (2, 0) ); }} ); disks = ( {disks} ); steps = 100;')
        self.run_ok("measure", self.result, "--csv", self.folder / "tables")
        pressed, light = rows(self.folder / "tables/contacts.csv")
        self.assertAlmostEqual(pressed["tau"], -0.4 * (1.5 - 1.0), 9)
        self.assertAlmostEqual(pressed["mobilised"], 1, 9)
        self.assertEqual((light["tau"], math.isnan(light["mobilised"])), (0, True))
        self.assertEqual([c["sliding"] for c in (pressed, light)], [-1, -1])
        (frame,) = self.json()
        self.assertEqual([frame[name]["count"] for name in ("normal_force", "tangential_force", "mobilised_friction")], [2, 1, 1])
        self.assertAlmostEqual(frame["mobilised_friction"]["mean"], 1, 9)

    def test_tables_of_some_bodies(self):
        """Rows of disks and contacts over all frames."""
        named = BOX.replace("packings", 'disks = ( { name = "grain, red"; x = 0.0; y = 0.06; radius = 0.05; '
                                        'density = 100.0; } );\npackings').replace("contacts = 4000", "contacts = 2000")
        self.make(named.replace('type = "rain";', 'type = "rain"; y = (0.2, 1.5);').replace("k_n = 1e4", "k_n = 5e4"))
        all_of, some = self.folder / "all", self.folder / "some"
        self.run_ok("measure", self.result, "--all", "--csv", all_of)
        self.run_ok("measure", self.result, "--all", "--csv", some, "--body", "grain, red", "--body", "right", "--body", 7)
        contacts, mine = rows_of_text(all_of / "contacts.csv"), rows_of_text(some / "contacts.csv")
        self.assertEqual(mine, [row for row in contacts if {row["a"], row["b"]} & {"0", "7", "33"}])
        self.assertGreater(len({row["step"] for row in mine}), 2)
        self.assertEqual([d["disk"] for d in rows(some / "disks.csv")], [0] + 4 * [0, 7])  # disk 7 waits at first
        with h5py.File(self.result) as file:
            zeta = file["contacts/zeta"][:]
        got = np.array([float(row["zeta"]) for row in contacts])
        self.assertTrue(np.allclose(got, zeta, rtol=1e-13, atol=0))
        self.assertIn("did you mean right?", self.refused(2, self.result, "--csv", some, "--body", "rigth"))
        self.assertIn("numbers are 0 to 33", self.refused(2, self.result, "--csv", some, "--body", 34))
        self.assertIn("expected --csv", self.refused(2, self.result, "--body", 1))

    def test_means_of_the_run(self):
        """rotation.csv and means.csv are what /summary has."""
        self.make(BOX + "measure = { rotation = (3, 5); disks = true; };")
        folder = self.folder / "tables"
        self.run_ok("measure", self.result, "--csv", folder)
        with h5py.File(self.result) as file:
            for name, group, n in ("rotation.csv", "summary/rotation", 2), ("means.csv", "summary/disks", 30):
                table = rows_of_text(folder / name)
                self.assertEqual(len(table), n)
                self.assertEqual(set(table[0]) - {"name"}, set(file[group]) - {"name", "names"})
                for column in set(table[0]) - {"name"}:
                    got = [float(row[column] or math.nan) for row in table]
                    self.assertTrue(np.allclose(got, file[group][column][:], rtol=1e-13, atol=0, equal_nan=True), column)
        self.run_ok("measure", self.result, "--csv", folder, "--body", 5)
        self.assertEqual([row["id"] for row in rows_of_text(folder / "means.csv")], ["5"])

    def test_open_region(self):
        """Where nothing ends the region the closed cells come first; a lid ends it."""
        self.make(BOX)
        for words, open_at in ((), ["top"]), (("--region", "-0.5,0.5,0,0.3"), []):
            (frame,) = self.json(*words)
            self.assertEqual(frame["region"]["open"], open_at)
            out, _ = self.run_ok("measure", self.result, *words)
            lines = [line.split() for line in out.split("\npacking\n")[1].splitlines()[:3]]
            cells, region = f"{frame['cells']['inside']:.6g}", f"{frame['fraction']:.6g}"
            self.assertEqual(lines[0][:3], ["packing", "fraction", cells if open_at else region])
            self.assertIn(["of", "the", "region", region] if open_at else ["inside", cells], [line[:4] if open_at else line[:2]
                                                                                            for line in lines])
            self.assertEqual("open at the top: " in out, bool(open_at))
        out, _ = self.run_ok("measure", self.result, "--all")
        head, *lines = out.splitlines()
        fraction, width, height = (head.replace("z back", "z_back").split().index(n) for n in ("fraction", "width", "height"))
        self.assertEqual({tuple(line.split()[k] for k in (fraction, width, height)) for line in lines[:5]},
                         {("-", "1", "1.5")})
        self.result.unlink()
        self.make(BOX.replace("height = 1.5;", "height = 1.5; open = false;"))
        self.assertEqual(self.json()[0]["region"]["open"], [])
        self.result.unlink()
        self.make('dt = 1e-3; materials = ( %s ); disks = ( { x = 0; y = 0; radius = 1; mass = 1; } ); steps = 5;' % MATERIAL)
        self.assertEqual(self.json()[0]["region"]["open"], ["left", "right", "bottom", "top"])
        self.assertIn("the deck gives no region", self.run_ok("measure", self.result)[0])

    def test_changing_box(self):
        self.make(PERIODIC)
        frames = self.json("--all")
        with h5py.File(self.result) as file:
            edges = file["particles/disks/box/edges/value"][:]
            covered = np.pi * (file["particles/disks/radius"][:] ** 2).sum()
        self.assertGreater(edges[0, 0], 1.05 * edges[-1, 0])
        for frame, edge in zip(frames, edges):
            self.assertAlmostEqual(frame["region"]["area"], edge[0] * edge[1], 12)
            self.assertAlmostEqual(frame["region"]["width"] / edge[0], 1, 12)
            self.assertAlmostEqual(frame["region"]["height"] / edge[1], 1, 12)
            self.assertAlmostEqual(frame["fraction"], covered / (edge[0] * edge[1]), 11)
            self.assertEqual(frame["region"]["periodic"], [True, True])
            self.assertEqual(frame["cells"]["open"], 0)
            self.assertAlmostEqual(frame["cells"]["total"] / frame["region"]["area"], 1, 12)
        (part,) = self.json("--region", "-0.2,0.1,0.3,0.5")
        self.assertAlmostEqual(part["region"]["area"], 0.06, 12)
        self.assertLess(part["disks"]["free"], 12)

    def test_lid(self):
        """The region ends at a lid that has come down, in the run itself and in one that begins with its result."""
        lid = ('dt = 2e-4; gravity = { g = 10.0; }; materials = ( %s );\n'
               'container = { type = "box"; width = 1.0; height = 1.5; open = false; };\n' % MATERIAL)
        press = 'motions = ( { wall = "lid"; coordinate = "y"; type = "load"; mass = 1.0; force = -5; } );\n'
        self.make(lid + press + 'packings = ( { type = "random"; count = 30; radius = 0.07; density = 10.0; } );\n'
                  'phases = ( { steps = 8000; } );')
        first, = self.json()
        with h5py.File(self.result) as file:
            height = file["state/y"][-1]
        self.assertLess(height, 1.0)
        self.assertAlmostEqual(first["region"]["y"][1], height, 12)
        self.assertGreater(first["fraction"], 0.45)
        shutil.copy(self.result, self.folder / "pressed.h5")
        self.result.unlink()
        self.make(lid + 'disk_files = ( { file = "pressed.h5"; contacts = true; } ); steps = 10;')
        second, = self.json()
        self.assertAlmostEqual(second["region"]["y"][1], height, 12)

    def test_unfinished(self):
        self.deck = self.folder / "deck.cfg"
        self.deck.write_text(BOX)
        words = ["run", self.deck, "-o", self.result, "-D", "phases[0].steps=200000000", "-D", "checkpoint=0.05"]
        process = start(*words)
        # several parts, and frames of 0, 2000, 4000 and 6000 steps in them
        wait_for(lambda: len(self.checkpoints()) > 1 and self.checkpoints()[0] > 6000)
        process.send_signal(signal.SIGTERM)
        process.communicate(timeout=LONG)
        self.assertEqual(process.returncode, 75)
        frames = self.json("--all")
        self.assertGreater(len(frames), 2)
        self.assertEqual([f["frame"] for f in frames[:-1]], list(range(len(frames) - 1)))
        part = self.parts / "part-000001.h5"
        out, _ = self.run_ok("measure", part, "--json", "--all")
        some = json.loads(out)["frames"]
        self.assertEqual(some, frames[:len(some)])
        checkpoint = self.parts / f"checkpoint-{self.checkpoints()[0]}.h5"
        out, _ = self.run_ok("measure", checkpoint, "--json")
        (state,) = json.loads(out)["frames"]
        self.assertEqual(state["step"], self.checkpoints()[0])
        self.assertIn("no frames are stored", self.refused(2, checkpoint, "--frame", 0))

    def test_state_with_rolling(self):
        self.make(BOX.replace("mu = 0.4;", "mu = 0.4; k_r = 20.0; mu_r = 0.2;"))
        with h5py.File(self.result) as file:
            roll = abs(file["state/contact_roll"][()])
        self.assertGreater(roll.max(), 0)
        (state,) = self.json()
        (frame,) = self.json("--frame", 4)
        self.assertEqual({**state, "frame": 4}, frame)

    def test_damaged_state(self):
        self.make(BOX)
        whole = self.folder / "whole.h5"
        shutil.copy(self.result, whole)
        for column, last, told in (("id", 10**6, "/state/id is damaged"), ("id", 31, "/state/id is damaged"),
                                   ("contact_a", 10**6, "the contacts of the state are damaged"),
                                   ("contact_b", 10**6, "the contacts of the state are damaged")):
            with self.subTest(column=column, last=last):
                shutil.copy(whole, self.result)
                with changed(self.result) as file:
                    values = file["state"][column]
                    values[0 if column == "id" else -1] = last
                self.assertIn(told, self.refused(4, self.result))

    def test_mistakes(self):
        self.make(BOX)
        self.assertIn("frame 5: there are 0 to 4", self.refused(2, self.result, "--frame", 5))
        self.assertIn("expected x0,x1,y0,y1", self.refused(2, self.result, "--region", "1,0,0,1"))
        self.assertIn("one of --frame, --time and --all", self.refused(2, self.result, "--all", "--time", 1))
        self.assertIn("did you mean --frame?", self.refused(2, self.result, "--frames", 1))
        self.assertIn("whole number", self.refused(2, self.result, "--bins", 0))
        self.assertIn("one result is expected", self.refused(2))
        self.assertIn("is a deck; slipdisk run", self.refused(2, self.deck))
        kept = self.result.read_bytes(), self.deck.read_bytes()
        self.assertIn("that is a result, which would be lost", self.refused(2, self.result, "-o", self.result))
        self.assertIn("that is a deck, which would be lost", self.refused(2, self.result, "-o", self.deck))
        self.assertEqual((self.result.read_bytes(), self.deck.read_bytes()), kept)
        self.assertIn("there is neither", self.refused(2, self.folder / "nothing.h5"))
        other = self.folder / "other.h5"
        with h5py.File(other, "w") as file:
            file["x"] = [1.0]
        self.assertIn("is not a result of slipdisk", self.refused(2, other))
        damaged = self.folder / "damaged.h5"
        shutil.copy(self.result, damaged)
        with changed(damaged) as file:
            file["state/contact_b"][0] = 4000000
        self.assertIn("damaged", self.refused(4, damaged))
        with changed(damaged) as file:
            file["contacts/count"][1] += 1000000
        self.assertIn("damaged", self.refused(4, damaged, "--frame", 2))


if __name__ == "__main__":
    sys.exit(unittest.main(verbosity=1))
