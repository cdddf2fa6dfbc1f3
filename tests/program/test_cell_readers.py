"""A box that deforms: whatever reads a frame, or the end, has the box of that moment, and not the deck's."""
import json
import os
import sys

import h5py
import numpy

from results_common import PROGRAM, ROOT, Folder, run

sys.path[:0] = [str(ROOT / "tools" / "python")]
os.environ.setdefault("SLIPDISK_PROGRAM", str(PROGRAM))
import slipdisk  # noqa: E402

DECK = """dt = 1e-3; seed = 1; materials = ( { name = "disk"; k_n = 1e3; gamma_n = 3; } );
container = { type = "periodic"; width = 8; height = 6; };
packings = ( { type = "random"; fraction = 0.3; density = 1; sizes = "uniform"; lower = 0.3; upper = 0.5; } );
measure = { stress = true; box = true; };
"""
PRESS = 'phases = ( { name = "press"; time = 1.5; cell = { rate_xx = -0.1; rate_yy = -0.2; rate_xy = 0.7; }; } );\n'
SHRINK = 'phases = ( { name = "shrink"; time = 0.5; compress = { fraction = 0.6; rate = 0.2; }; } );\n'
OUTPUT = "output = { frames = 250; series = 250; };\n"


class Boxes(Folder):
    def made(self, phases, output=OUTPUT, name="d"):
        (self.folder / f"{name}.cfg").write_text(DECK + phases + output)
        self.ok("run", f"{name}.cfg", "-o", f"{name}.h5", "--quiet")
        return slipdisk.Result(self.folder / f"{name}.h5")

    def ok(self, *words):
        status, out, err = run(*words, cwd=self.folder)
        self.assertIn(status, (0, 5), err)
        return out

    def edges(self, name="d"):
        """[frame][2][2], by h5py."""
        with h5py.File(self.folder / f"{name}.h5") as file:
            edges = file["particles/disks/box/edges/value"][:]
        return edges if edges.ndim == 3 else edges[:, :, None] * numpy.eye(2)

    def same(self, found, expected, what):
        numpy.testing.assert_allclose(found, expected, rtol=1e-6, atol=1e-9, err_msg=what)

    def check(self, r, name="d"):
        edges = self.edges(name)
        area = (numpy.pi * r.disks["radius"] ** 2).sum()
        self.assertGreater(abs(edges[-1] - edges[0]).max(), 0.3)
        self.same(r.box, edges[-1].diagonal(), "Result.box")
        self.same(r.box_offset, edges[-1][1, 0], "Result.box_offset")
        self.same(r.frames.box, edges.diagonal(axis1=1, axis2=2), "frames.box")
        self.same(r.frames.box_offset, edges[:, 1, 0], "frames.box_offset")
        self.same(r.series["packing_fraction"], area / numpy.linalg.det(edges), "series")
        found = [json.loads(self.ok("measure", f"{name}.h5", "--json", *words)) for words in ([], ["--frame", "2"])]
        text = json.dumps(found)
        for box in edges[-1], edges[2]:
            self.assertIn(f"{area / numpy.linalg.det(box):.6g}"[:6], text)
        self.ok("export", f"{name}.h5", "--to", "h5md3d", "-o", f"{name}.h5md")
        with h5py.File(self.folder / f"{name}.h5md") as file:
            self.same(file["particles/trajectory/box/edges/value"][:, :2, :2], edges, "h5md3d")
        self.ok("export", f"{name}.h5", "--to", "lammps-data", "-o", f"{name}.data")
        bounds = {line.split()[-1]: line.split() for line in (self.folder / f"{name}.data").read_text().splitlines()[:20] if line}
        for key, length in zip(("xhi", "yhi"), edges[-1].diagonal()):
            self.same(float(bounds[key][1]) - float(bounds[key][0]), length, key)
        self.same(float(bounds["yz"][0]) if "yz" in bounds else 0, edges[-1][1, 0], "xy")
        from slipdisk.plot_source import Source
        source = Source(r)
        self.same([source.box_at(k)[1] for k in range(len(edges))], edges.diagonal(axis1=1, axis2=2), "plot")
        self.same([source.offset_at(k) for k in range(len(edges))], edges[:, 1, 0], "plot")

    def test_deformed(self):
        self.check(self.made(PRESS))

    def test_shrunk(self):
        self.check(self.made(SHRINK))

    def test_upright(self):
        """A box that stays as it is, and open space."""
        r = self.made('phases = ( { steps = 500; } );\n')
        self.same(r.box, [8, 6], "box")
        self.same(r.frames.box, [[8, 6]] * len(r.frames), "frames.box")
        self.assertEqual((r.box_offset, abs(r.frames.box_offset).max()), (0, 0))


if __name__ == "__main__":
    import unittest
    unittest.main()
