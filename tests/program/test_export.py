"""slipdisk export: ranges of frames, text formats and tables against the result they come from, round trips into decks,
mistakes, and failed writes."""
import csv
import os
import pathlib
import re
import resource
import signal
import sys
import unittest

import h5py
import numpy

from export_common import Exports, in_play
from results_common import BRIEF, run, start, wait_for


def table(path):
    with open(path, newline="") as file:
        return list(csv.DictReader(file))


def dump_frames(path):
    """(step, box lines, rows by column) of each frame of a text dump."""
    lines = iter(pathlib.Path(path).read_text().split("\n"))
    for line in lines:
        if not line:
            continue
        assert line == "ITEM: TIMESTEP", line
        step = int(next(lines))
        assert next(lines) == "ITEM: NUMBER OF ATOMS"
        n = int(next(lines))
        box = [next(lines) for _ in range(4)]
        names = next(lines).split()[2:]
        rows = numpy.array([next(lines).split() for _ in range(n)], float).reshape(n, len(names))
        yield step, box, dict(zip(names, rows.T))


class Ranges(Exports):
    def steps(self, frames, status=0):
        out = self.folder / "r.dump"
        got, _, err = run("export", self.made / "rich.h5", "--to", "lammps-dump", "-o", out, f"--frames={frames}")
        self.assertEqual(got, status, err)
        return [step for step, _, _ in dump_frames(out)] if status == 0 else err

    def test_slices_of_python(self):
        every = list(self.open("rich")["particles/disks/position/step"][:])
        for text in ":", "::", "2:", ":3", "-2:", ":-2", "::3", "1:8:2", "-5:-1:2", "0:1000", "-1000:2", "::1000", "+1:2":
            ends = [int(word) if word else None for word in text.split(":")]
            self.assertEqual(self.steps(text), every[slice(*ends)], text)
        for text in "0", "3", "-1", "-11", str(len(every) - 1):
            self.assertEqual(self.steps(text), [every[int(text)]], text)

    def test_mistakes(self):
        for text in "a", "1:b", "1:2:3:4", "::0", "::-1", "", "1.5", "1-2", "99999999999999999999":
            self.assertIn("expected a frame (5, -1 the last) or FIRST:END:STEP", self.steps(text, 2), text)
        for text in "11", "-12":
            self.assertIn("has frames 0 to 10", self.steps(text, 2))
        for text in "3:3", "5:2", "50:":
            self.assertIn("chooses none of the frames 0 to 10", self.steps(text, 2))


class Texts(Exports):
    def assert_same(self, got, expected, what):
        expected = numpy.asarray(expected)
        self.assertEqual(numpy.shape(got), expected.shape, what)
        self.assertTrue(numpy.array_equal(got, expected), what)

    def test_dump(self):
        file = self.open("rich")
        disks = file["particles/disks"]
        frames = list(dump_frames(self.export("rich", "lammps-dump")))
        self.assertEqual([f[0] for f in frames], list(disks["position/step"][:]))
        self.assertEqual(len({len(f[2]["id"]) for f in frames}), 3)  # some wait, some were removed
        for k, (_, box, rows) in enumerate(frames):
            there = in_play(file, k)
            self.assertEqual(box[0], "ITEM: BOX BOUNDS pp ff pp")
            self.assertEqual([float(x) for x in box[1].split()], [-1, 1])
            self.assertEqual(list(rows["id"]), [i + 1 for i in there])
            for c, axis in enumerate("xy"):
                self.assert_same(rows[axis], disks["position/value"][k][there, c], axis)
                self.assert_same(rows["v" + axis], disks["velocity/value"][k][there, c], "v" + axis)
                self.assert_same(rows["i" + axis], disks["image/value"][k][there, c], "i" + axis)
            self.assert_same(rows["omegaz"], disks["angular_velocity/value"][k][there], "spin")
            self.assert_same(rows["angle"], disks["angle/value"][k][there], "angle")
            for name in "radius", "mass":
                self.assert_same(rows[name], disks[name][:][there], name)
            self.assert_same(rows["mol"], disks["group"][:][there] + 1, "group")
            low, high = map(float, box[2].split())
            self.assertTrue(((rows["y"] - rows["radius"] > low - 1e-12) & (rows["y"] + rows["radius"] < high + 1e-12)).all())
        self.assertTrue((frames[-1][2]["ix"] != 0).any())
        kinds = {(m, g, d): t for t, m, g, d in zip(frames[-1][2]["type"], disks["species"][:][there],
                                                    disks["group"][:][there], disks["driven"][:][there])}
        self.assertEqual(len(kinds), len(set(kinds.values())))
        self.assertEqual(len(kinds), 4)

    def test_box_that_shrinks(self):
        file = self.open("shrinking")
        edges = file["particles/disks/box/edges/value"][:]
        self.assertGreater(len(edges), 3)
        for k, (_, box, _) in enumerate(dump_frames(self.export("shrinking", "lammps-dump"))):
            for c in range(2):
                low, high = map(float, box[1 + c].split())
                self.assert_same(high - low, edges[k, c], "edges")

    def test_csv(self):
        file = self.open("rich")
        disks, folder = file["particles/disks"], self.export("rich", "csv")
        rows = table(folder / "disks.csv")
        self.assertEqual(len(rows), sum(len(in_play(file, k)) for k in range(len(disks["position/step"]))))
        last = [row for row in rows if row["step"] == rows[-1]["step"]]
        there = in_play(file, -1)
        self.assertEqual([int(row["disk"]) for row in last], there)
        self.assertEqual([float(row["x"]) for row in last], list(disks["position/value"][-1][there, 0]))
        self.assertEqual([float(row["theta"]) for row in last], list(disks["angle/value"][-1][there]))
        self.assertEqual({row["material"] for row in last}, {"grain", 'soft, "wet"'})
        self.assertEqual({row["group"] for row in last}, {"", "feet", "grains"})
        contacts, stored = table(folder / "contacts.csv"), file["contacts"]
        for step, first, count in zip(*(stored[n][:] for n in ("step", "first", "count"))):
            at = [row for row in contacts if row["step"] == str(step)]
            self.assertEqual([int(row["b"]) for row in at], list(stored["b"][first:first + count]))
            self.assert_same([float(row["tau"]) for row in at], stored["tau"][first:first + count], "tau")
        self.assertTrue(any(row["tau"] == "" for row in contacts))  # of frames without a contact table
        series, stored = table(folder / "series.csv"), file["observables"]
        self.assert_same([float(r["kinetic_rotation"]) for r in series], stored["kinetic_rotation/value"][:], "energy")
        self.assert_same([float(r["angle[runner]"]) for r in series], stored["angle/value"][:, 0], "angle")
        self.assert_same([float(r["wall_force_y[floor]"]) for r in series], stored["wall_force_y/value"][:, 0], "wall")
        self.assert_same([float(r["group_torque[grains]"]) for r in series], stored["group_torque/value"][:, 1], "group")
        units = {(row["table"], row["column"]): row["unit"] for row in table(folder / "units.csv")}
        for name, some in ("disks", rows), ("contacts", contacts), ("series", series):
            self.assertEqual([c for t, c in units if t == name], list(some[0]), name)
        self.assertEqual(units["series", "angle[runner]"], "rad")

    def test_measure_has_the_same_contacts(self):
        status, _, err = run("measure", self.made / "rich.h5", "--csv", self.folder / "m")
        self.assertEqual(status, 0, err)
        folder = self.export("rich", "csv", "--frames=-1")
        self.assertEqual((folder / "contacts.csv").read_text(), (self.folder / "m/contacts.csv").read_text())


    def test_every_text_format_keeps_bits(self):
        old, there = self.open("rich")["particles/disks"], in_play(self.open("rich"), -1)
        for kind in "lammps-dump", "lammps-data", "extxyz", "csv":
            path = self.export("rich", kind, "--frames=-1", out="bits-" + kind)
            files = [f for f in path.rglob("*") if f.is_file()] if path.is_dir() else [path]
            texts = [f.read_bytes().decode("latin-1") for f in files]
            words = {float(w) for t in texts for w in re.findall(r"[-+]?\d+(?:\.\d*)?(?:e[-+]?\d+)?", t)}
            for name in "position/value", "velocity/value", "angular_velocity/value":
                self.assertEqual(set(numpy.ravel(old[name][-1][there]).tolist()) - words, set(), (kind, name))


class RoundTrips(Exports):
    """What is exported is the beginning of another deck."""

    def begin(self, text):
        (self.folder / "again.cfg").write_text(text + 'phases = ( { name = "a"; steps = 1; frames = 1; } );')
        status, _, err = run("run", self.folder / "again.cfg", "--quiet", "-o", self.folder / "again.h5")
        self.assertEqual(status, 0, err)
        file = h5py.File(self.folder / "again.h5")
        self.addCleanup(file.close)
        return file["particles/disks"]

    HEAD = ('dt = 1e-4; integrator = "verlet"; box = { periodic = "x"; file = "out"; };'
            'materials = ( { name = "grain"; k_n = 1e4; } );')

    def test_lammps_data(self):
        file = self.open("rich")
        old, there = file["particles/disks"], in_play(file, -1)
        path = self.export("rich", "lammps-data")
        text = path.read_text()
        self.assertLess(max(map(len, text.split("\n"))), 255)  # LAMMPS cuts longer lines
        types = {line.split(":")[0]: line for line in text.split("\n") if line.startswith("# type ")}
        self.assertEqual(len(types), 4)
        fixed = [k.split()[-1] for k, line in types.items() if line.endswith("fixed or driven")]
        self.assertIn("# group fixed type " + " ".join(fixed) + "\n", text)
        self.assertIn("# wall 0 floor: line\n#   -1 0\n#   1 0\n", text)
        feet = next(k.split()[-1] for k, line in types.items() if "group feet" in line)
        new = self.begin(self.HEAD + 'disk_files = ( { file = "out"; format = "lammps"; columns = ("x", "y", "vx", "vy", '
                         '"omega", "radius", "mass", "group = type"); } );'
                         f'motions = ( {{ name = "hold"; group = "{feet}"; coordinate = ("x", "y", "theta"); '
                         'type = "fixed"; } );')
        for name, mine in ("position", "position/value"), ("velocity", "velocity/value"), ("spin", "angular_velocity/value"):
            self.assertTrue((new[mine][0] == old[mine][-1][there]).all(), name)
        self.assertTrue((new["radius"][:] == old["radius"][:][there]).all())
        self.assertTrue(numpy.allclose(new["mass"][:], old["mass"][:][there], rtol=1e-15))
        self.assertEqual(list(new["driven"][:].nonzero()[0]), [there.index(k) for k in (3, 4)])

    def test_h5md(self):
        old = self.open("shrinking")["particles/disks"]
        self.export("shrinking", "h5md3d", out="s.h5")
        new = self.begin('dt = 0.1; integrator = "verlet"; materials = ( { name = "disk"; k_n = 1; } );'
                         'disk_files = ( { file = "s.h5"; dataset = "/particles/trajectory"; '
                         'columns = ("x", "y", "vx", "vy", "theta", "omega", "radius", "mass", "inertia"); } );')
        for name in "position/value", "velocity/value", "angle/value", "angular_velocity/value":
            self.assertTrue((new[name][0] == old[name][-1]).all(), name)

    def test_csv(self):
        file = self.open("rich")
        old, there = file["particles/disks"], in_play(file, -1)
        folder = self.export("rich", "csv", "--frames=-1")
        text = (self.made / "rich.cfg").read_text()
        new = self.begin(text[text.index("dt ="):text.index("disks = (")] +
                         'disk_files = ( { file = "out/disks.csv"; columns = ("x", "y", "theta", "vx", "vy", "omega", '
                         '"radius", "mass", "inertia", "material", "group"); } );')
        self.assertTrue(folder.is_dir())
        for name in "position/value", "velocity/value", "angle/value", "angular_velocity/value":
            self.assertTrue((new[name][0] == old[name][-1][there]).all(), name)
        for name in "radius", "mass", "inertia", "species":
            self.assertTrue((new[name][:] == old[name][:][there]).all(), name)


class Sources(Exports):
    def test_unfinished_run(self):
        """Parts and the last checkpoint; the checkpoint is a frame where it is newer than the last one."""
        out = self.folder / "r.h5"
        words = (self.made / "rich.cfg", "-D", "phases.all.time=1e9", "-D", "checkpoint=0.05", "--quiet", "-o", out)
        process = start("run", *words)
        parts = self.folder / "r.h5.parts"
        wait_for(lambda: any(int(p.stem.split("-")[1]) > 9000 for p in parts.glob("checkpoint-*.h5"))
                 or process.poll() is not None)
        process.send_signal(signal.SIGTERM)
        process.communicate()
        self.assertEqual(process.returncode, 75)
        status, _, err = run("export", out, "--to", "lammps-dump", "-o", self.folder / "u.dump", "--frames=:11")
        self.assertEqual(status, 0, err)
        wanted = {f[0]: f[2] for f in dump_frames(self.export("rich", "lammps-dump", "--frames=:10"))}
        found = {f[0]: f[2] for f in dump_frames(self.folder / "u.dump")}
        for step, rows in wanted.items():
            for name in "x", "y", "angle", "omegaz":
                self.assertTrue((rows[name] == found[step][name]).all(), (step, name))
        status, _, err = run("export", out, "--to", "csv", "-o", self.folder / "u", "--frames=-1")
        self.assertEqual(status, 0, err)
        rows = table(self.folder / "u/series.csv")
        self.assertEqual([int(r["step"]) for r in rows], sorted({int(r["step"]) for r in rows}))
        self.assertIn("wall_force_y[floor]", rows[0])
        state = max(int(p.stem.split("-")[1]) for p in parts.glob("checkpoint-*.h5"))
        self.assertEqual({int(r["step"]) for r in table(self.folder / "u/disks.csv")}, {state})
        status, told, err = run("export", f"{parts}/", "--to", "extxyz", "--frames=0", cwd=self.folder)
        self.assertTrue(told.startswith("r.extxyz: "), told + err)
        # of a checkpoint that is named itself the state, of a part its frames
        for form in "h5md3d", "lammps-dump", "lammps-data", "extxyz", "vtk", "csv":
            status, _, err = run("export", parts / f"checkpoint-{state}.h5", "--to", form, "-o", self.folder / form)
            self.assertEqual(status, 0, err)
        self.assertEqual([f[0] for f in dump_frames(self.folder / "lammps-dump")], [state])
        part = min(parts.glob("part-*.h5"))
        status, _, err = run("export", part, "--to", "lammps-dump", "-o", self.folder / "part.dump")
        self.assertEqual(status, 0, err)
        with h5py.File(part) as file:
            self.assertEqual([f[0] for f in dump_frames(self.folder / "part.dump")],
                             list(file["particles/disks/position/step"][:]))

    def test_default_names(self):
        for form, name in (("h5md3d", "open.h5md"), ("lammps-dump", "open.dump"), ("lammps-data", "open.data"),
                           ("extxyz", "open.extxyz"), ("vtk", "open.vtk"), ("csv", "open.tables")):
            status, out, err = run("export", self.made / "open.h5", "--to", form, cwd=self.folder)
            self.assertEqual(status, 0, err)
            self.assertTrue(out.startswith(f"{name}: "), out)
            self.assertTrue((self.folder / name).exists())


class Memory(Exports):
    def peak(self, result, form, frames):
        """Bytes; no less than what this process has, which is counted before the program begins."""
        out = self.folder / f"{form}{frames.replace(':', '-')}"
        process = start("export", result, "--to", form, f"--frames={frames}", "-o", out)
        with process.stdout, process.stderr:
            err = process.stdout.read() + process.stderr.read()
        _, status, used = os.wait4(process.pid, 0)
        process.returncode = status
        self.assertEqual(status, 0, err)
        return used.ru_maxrss * 1024

    @unittest.skipIf(BRIEF, "sanitizers keep what was freed")
    def test_one_frame_at_a_time(self):
        """Peak memory does not grow with the number of frames."""
        (self.folder / "many.cfg").write_text(
            'dt = 0.1; integrator = "verlet"; materials = ( { name = "disk"; k_n = 1; gamma_n = 0.1; } );'
            'container = { type = "periodic"; width = 70; height = 70; };'
            'packings = ( { type = "square"; count = 4000; density = 1; sizes = "mono"; radius = 0.5; } );'
            'phases = ( { name = "a"; steps = 200; frames = 1; } );')
        result = self.folder / "many.h5"
        status, _, err = run("run", self.folder / "many.cfg", "--quiet", "-o", result)
        self.assertEqual(status, 0, err)
        # what is read of a frame, and kept by mistake: 96 bytes a disk, 77 MB of 200 frames; more of vtk
        for form, frames in ("h5md3d", ":200"), ("lammps-dump", ":200"), ("vtk", ":50"):
            self.assertLess(self.peak(result, form, frames) - self.peak(result, form, ":2"), 12e6, form)


class Mistakes(Exports):
    def refuse(self, expected, *words, status=2):
        before = sorted(os.listdir(self.folder))
        got, _, err = run("export", *words, cwd=self.folder)
        self.assertEqual(got, status, err)
        self.assertIn(expected, err)
        self.assertEqual(sorted(os.listdir(self.folder)), before)

    def test_messages(self):
        result = self.made / "rich.h5"
        self.refuse("the format is not said; expected --to h5md3d|", result)
        self.refuse("--to xyz: expected h5md3d|lammps-dump|", result, "--to", "xyz")
        self.refuse("one result is expected", "--to", "csv")
        self.refuse("there is neither a result no.h5", "no.h5", "--to", "csv")
        self.refuse("is a deck; slipdisk run", self.made / "rich.cfg", "--to", "csv")
        self.refuse("chooses 6 frames; lammps-data takes one", result, "--to", "lammps-data", "--frames", "::2")
        self.refuse("that is a result, which would be lost", result, "--to", "h5md3d", "-o", result)
        self.refuse("there is no folder", result, "--to", "csv", "-o", "none/out")
        self.refuse("none", result, "--to", "extxyz", "-o", "none/out", status=4)
        (self.folder / "there").mkdir()
        (self.folder / "there/file").write_text("mine")
        self.refuse("is a folder; expected the name of a file", result, "--to", "extxyz", "-o", "there")
        self.refuse("there is there already: remove it", result, "--to", "vtk", "-o", "there")
        self.assertEqual((self.folder / "there/file").read_text(), "mine")
        self.export("open", "h5md3d", out="x.h5md")
        self.refuse("is not a result of slipdisk", "x.h5md", "--to", "csv")

    def test_full_disk(self):
        """A message, exit status 4, and nothing is left; an older file stays."""
        def small():
            signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
            resource.setrlimit(resource.RLIMIT_FSIZE, (6000, 6000))

        for form in "h5md3d", "lammps-dump", "lammps-data", "extxyz", "vtk", "csv":
            for old in None, "old":
                out = self.folder / f"{form}.out"
                if old and form not in ("vtk", "csv"):
                    out.write_text(old)
                before = sorted(os.listdir(self.folder))
                status, _, err = run("export", self.made / "rich.h5", "--to", form, "-o", out, preexec_fn=small)
                self.assertEqual(status, 4, f"{form}: {err}")
                self.assertIn("cannot write", err)
                self.assertEqual(sorted(os.listdir(self.folder)), before, form)
                if out.exists():
                    self.assertEqual(out.read_text(), old)


if __name__ == "__main__":
    sys.exit(unittest.main(verbosity=1))
