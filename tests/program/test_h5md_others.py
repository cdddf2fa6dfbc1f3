"""H5MD files of other programs as disks and as box: one moment of all elements, or a message; nothing is read that was not written."""
import unittest

import h5py
import numpy

from results_common import run
from test_disk_files import OPEN, Files

X, Y, R = numpy.array([0.3, 1, 2.5]), numpy.array([3, 4, 5.5]), numpy.array([0.5, 0.25, 0.125])
PLACE = numpy.c_[X, Y]


def element(group, name, frames, steps=None, **more):
    """A time-dependent element; steps: a list, or (distance, offset), stored as a scalar."""
    item = group.create_group(name)
    item.create_dataset("value", data=numpy.array(frames), **more)
    if isinstance(steps, tuple):
        item["step"] = steps[0]
        if steps[1] is not None:
            item["step"].attrs["offset"] = steps[1]
    elif steps is not None:
        item["step"] = numpy.array(steps)
    return item


def solid(group, radius=R):
    group["radius"] = radius


class Others(Files):
    def made(self, fill, name="all", path="p.h5", **head):
        with h5py.File(self.folder / path, "w", **head) as file:
            fill(file.create_group(f"particles/{name}"))

    def read(self, columns='columns = ("x", "y", "radius", "vx", "vy"); ', file="p.h5", more=""):
        text = OPEN + more + f'disk_files = ( {{ file = "{file}"; {columns} density = 2; }} );'
        result = self.folder / "read.h5"
        status, _, err = run("run", self.write("read.cfg", text), "--force", "-o", result)
        if status:
            return status, err
        with h5py.File(result) as made:
            disks = made["particles/disks"]
            return {"x": disks["position/value"][0, :, 0], "y": disks["position/value"][0, :, 1],
                    "vx": disks["velocity/value"][0, :, 0], "radius": disks["radius"][:]}, err

    def is_read(self, expected, words="", **keys):
        """Disks are those of this table of x, y and, if there, vx; `words` are in the warnings."""
        found, err = self.read(**keys)
        self.assertIsInstance(found, dict, err)
        for k, name in enumerate(("x", "y", "vx")[:expected.shape[1]]):
            self.assertTrue((found[name] == expected[:, k]).all(), (name, found[name], expected[:, k]))
        self.assertEqual(bool(words), "warning" in err, err)
        self.assertIn(words, err)

    def is_refused(self, words, **keys):
        status, err = self.read(**keys)
        self.assertEqual(status, 2, err)
        self.assertIn(words, err)

    # --- steps ---

    def test_cadences(self):
        """The last step that all have; a warning where an element goes on; a refusal where there is none."""
        frames = [PLACE + k for k in range(4)]
        speed = [PLACE * 10 + k for k in range(4)]
        at = lambda k, v: numpy.c_[frames[k], speed[v][:, 0]]  # noqa: E731
        cases = [  # steps of position, of velocity, the frames to be read, what is said
            ([0, 10, 20, 30], [0, 10, 20, 30], (3, 3), ""),
            ([0, 10, 20, 30], (10, 0), (3, 3), ""),
            ((10, None), [0, 10, 20, 30], (3, 3), ""),
            ((10, 100), (10, 100), (3, 3), ""),
            ((10, 100), (30, 70), (3, 2), "step 130 is read"),
            ([0, 10, 20, 30], [0, 20, 40, 60], (2, 1), "step 20 is read"),
            ([0, 1, 2, 3], [0, 10, 20, 30], (0, 0), "step 0 is read"),
            ([0, 10, 20, 30], (7, 1), None, "no step in common"),
            ([0, 1, 2, 3], [4, 5, 6, 7], None, "no step in common"),
            ([0, 10, 20, 0], [0, 10, 20, 0], None, "do not ascend"),
            ([0, 10, 10, 20], [0, 10, 20, 30], None, "do not ascend"),
            ([0, 10, 20], [0, 10, 20, 30], None, "another number of steps than of frames"),
            ((0, 5), [0, 10, 20, 30], None, "no positive number"),
            (None, None, (3, 3), ""),
            (None, [0, 10, 20, 30], None, "whether their values belong together")]
        for steps, others, read, words in cases:
            def fill(g, steps=steps, others=others):
                element(g, "position", frames, steps)
                element(g, "velocity", speed, others)
                solid(g)
            self.made(fill)
            with self.subTest(position=steps, velocity=others):
                if read:
                    self.is_read(at(*read), words)
                else:
                    self.is_refused(words)
                if "step 20" in words:
                    self.is_read(frames[3], columns="")  # what is not asked for does not matter

    def test_frames_without_steps(self):
        def fill(g):
            element(g, "position", [PLACE, PLACE + 1])
            element(g, "velocity", [PLACE])
            solid(g)
        self.made(fill)
        self.is_refused("whether their values belong together")

    def test_fixed_elements(self):
        """Those that do not change belong to every step; a scalar of one frame, too."""
        def fill(g):
            g["position"] = PLACE
            element(g, "velocity", [PLACE * 2, PLACE * 3], (5, 5))
            element(g, "radius", [R, R], [5, 10])
        self.made(fill)
        self.is_read(numpy.c_[PLACE, 3 * X])

    def test_links(self):
        """Hard links are as good as what they lead to; others are refused."""
        def fill(g):
            element(g, "position", [PLACE, PLACE + 1], [0, 5])
            g["velocity/value"] = numpy.array([PLACE, PLACE + 2])
            g["velocity/step"] = g["position/step"]
            solid(g)
        self.made(fill)
        self.is_read(numpy.c_[PLACE + 1, X + 2])
        with h5py.File(self.folder / "p.h5", "r+") as file:
            del file["particles/all/velocity/step"]
            file["particles/all/velocity/step"] = h5py.SoftLink("/particles/all/position/step")
        self.is_refused("steps behind a link, which is not followed")
        with h5py.File(self.folder / "p.h5", "r+") as file:
            del file["particles/all/velocity"]
            file["particles/all/velocity"] = h5py.ExternalLink("q.h5", "/v")
        self.is_refused("is a link, which is not followed")

    # --- space ---

    def test_three_dimensions(self):
        """Particles in a plane are disks; others would be flattened."""
        flat, deep = numpy.c_[PLACE, [0.7, 0.7, 0.7]], numpy.c_[PLACE, [0, 0, 0.1]]
        still, away = numpy.c_[PLACE, [0, 0, 0]], numpy.c_[PLACE, [1, 1, 1]]
        for place, speed, words in ((flat, still, ""), (deep, still, "position has three dimensions"),
                                    (flat, away, "velocity has three dimensions"), (flat.astype("f4"), still, "")):
            def fill(g, place=place, speed=speed):
                element(g, "position", [place], [0])
                g["velocity"] = speed
                solid(g)
            self.made(fill)
            with self.subTest(words):
                if words:
                    self.is_refused(words)
                else:
                    self.is_read(numpy.c_[place[:, :2], X])
        self.made(lambda g: (g.create_dataset("position", data=PLACE[:, :1]), solid(g)))
        self.is_refused("has not the shape of one value per particle", columns="")

    # --- rows without a particle ---

    def test_rows_of_fill_values(self):
        """Rows without a particle are left out where ids tell of them, and else refused."""
        place, nothing = numpy.r_[PLACE, [[0, 0], [9, 9]]], numpy.r_[PLACE, [[-1e30, -1e30]]]
        radius = numpy.r_[R, [0, 1]]

        def with_ids(ids, **more):
            def fill(g):
                element(g, "position", [place + 1, place], [0, 4])
                element(g, "id", [[0, 1, 2, 3, 4], ids], [0, 4], **more)
                solid(g, radius)
            return fill
        self.made(with_ids([5, 1, 7, -1, -1]))
        self.is_read(PLACE, columns="")
        self.made(with_ids([5, 1, 7, 99, 99], fillvalue=99, chunks=(1, 5)))
        self.is_read(PLACE, columns="")
        self.made(with_ids([99, 1, 7, 99, 8], fillvalue=99, chunks=(1, 5)))
        self.is_read(place[[1, 2, 4]], columns="")
        self.made(with_ids([5, 1, 7, 0, 0]))
        self.is_refused("is 0 in several rows", columns="")
        self.made(lambda g: (g.create_dataset("position", data=nothing, chunks=(2, 2), fillvalue=-1e30),
                             solid(g, numpy.r_[R, 1])))
        self.is_refused("row 3 of position holds the fill value", columns="")
        self.made(lambda g: (g.create_dataset("position", data=numpy.r_[PLACE, [[numpy.nan] * 2]]), solid(g, numpy.r_[R, 1])))
        self.is_refused("x = nan", columns="")

    def test_never_written(self):
        def fill(g):
            element(g, "position", [PLACE], [0], maxshape=(None, 3, 2), chunks=(1, 3, 2))
            g["position/value"].resize(2, axis=0)
            del g["position/step"]
            g["position/step"] = [0, 5]
            solid(g)
        self.made(fill)
        self.is_refused("has values that were never written", columns="")
        self.made(lambda g: (g.create_dataset("position", shape=(3, 2), dtype="f8"), solid(g)))
        self.is_refused("never written", columns="")
        with h5py.File(self.folder / "p.h5", "w") as file:
            file.create_dataset("m", (3, 3), "f8").attrs["columns"] = "x,y,radius"
        self.is_refused("never written", columns='dataset = "m";')

    # --- names, user blocks ---

    def test_groups(self):
        """One group of particles need not be named; several must be. A user block before the data changes nothing."""
        def fill(g):
            element(g, "position", [PLACE], [0])
            solid(g)
        for block, name in (0, "p.h5md"), (512, "p.mat"), (1024, "p.h5"), (2048, "p.he5"), (4096, "p.hdf5"):
            self.made(fill, name="trajectory", path=name, userblock_size=block)
            if block:
                with open(self.folder / name, "r+b") as file:
                    file.write(b"MATLAB 7.3 MAT-file, Platform: GLNXA64".ljust(block, b" "))
            self.is_read(PLACE, columns="", file=name)
            (self.folder / name).unlink()
        with h5py.File(self.folder / "p.h5", "w") as file:
            for name in "a", "b":
                fill(file.create_group(f"particles/{name}"))
        self.is_refused("dataset: missing", columns="")
        self.is_read(PLACE, columns='dataset = "/particles/b";')

    def test_user_block_elsewhere(self):
        """info, view, verify, measure and export take the file for what it is; a deck in its place is named."""
        with h5py.File(self.folder / "m.mat", "w", userblock_size=512) as file:
            file["x"] = 1
        with open(self.folder / "m.mat", "r+b") as file:
            file.write(b"MATLAB 7.3 MAT-file".ljust(512, b" "))
        for words in (["info"], ["view"], ["measure"], ["export", "--to", "csv"], ["verify"], ["plot"]):
            status, _, err = run(*words, self.folder / "m.mat", cwd=self.folder)
            self.assertIn(status, (2, 4), words)
            self.assertNotRegex(err, "text|zero byte|not an HDF5", words)
        status, _, err = run("check", self.folder / "m.mat")
        self.assertEqual(status, 2)
        self.assertIn("it is an HDF5 file, not a text", err)

    # --- the box ---

    DISK = 'disks = ( { x = 0.5; y = 0.5; radius = 0.05; mass = 1; } );'

    def box(self, file="p.h5", periodic="xy", disks=DISK):
        text = OPEN + disks + f'box = {{ periodic = "{periodic}"; file = "{file}"; }};'
        status, _, err = run("run", self.write("box.cfg", text), "--force", "-o", self.folder / "box.h5")
        if status:
            return status, err
        with h5py.File(self.folder / "box.h5") as made:
            box = made["particles/disks/box"]
            edges = box["edges/value"][-1] if "value" in box["edges"] else box["edges"][()]
            return [*box.attrs["lower"], *edges], err

    def test_boxes(self):
        two, three = [2.0, 3.0], [2.0, 3.0, 1.0]
        square, cube = numpy.diag(two), numpy.diag(three)
        sheared, whole, tipped, turned = square + [[0, 0], [0.5, 0]], square + [[0, 0], [-4, 0]], cube.copy(), square[::-1]
        tipped[2, 0] = 0.3
        good = [0, 0, 2, 3]
        cases = [(two, good), (three, good), (square, good), (cube, good), (whole, good), (sheared, "sheared"),
                 (tipped, "rectangular"), (turned, "rectangular"), ([2.0], "no box"), ([numpy.nan, 3], "no lengths"),
                 ([-2.0, 3], "no lengths")]
        for edges, expected in cases:
            for steps in (None, "alone", [0, 10], (10, 0)) if edges is cube else (None, [0, 10]):
                def fill(g, edges=edges, steps=steps):
                    box = g.create_group("box")
                    if steps is None:
                        box["edges"] = numpy.array(edges)
                    else:
                        element(box, "edges", [edges, edges], None if steps == "alone" else steps)
                self.made(fill)
                found, err = self.box()
                with self.subTest(edges=edges, steps=steps):
                    if isinstance(expected, str):
                        self.assertEqual(found, 2, err)
                        self.assertIn(expected, err)
                    else:
                        self.assertEqual(found, expected, err)

    def test_box_and_boundary(self):
        def fill(g):
            g["box/edges"] = [2.0, 3, 4]
            g["box"].attrs["boundary"] = [b"periodic", b"none", b"none"]
            g["box"].attrs["lower"] = [0.25, -1.0, 0]
        self.made(fill)
        self.assertEqual(self.box(periodic="x")[0], [0.25, 0, 2, 0])
        self.assertIn("not periodic in y", self.box()[1])

    def test_box_of_the_moment(self):
        """It is read at the step of the positions, and disks of another step are refused."""
        def fill(g, steps=(0, 10, 20), speeds=(0, 10)):
            element(g, "position", [PLACE, PLACE + 0.1, PLACE + 0.2], [0, 10, 20])
            element(g, "velocity", [PLACE] * len(speeds), list(speeds))
            element(g.create_group("box"), "edges", [[7.0, 8], [8, 9], [9, 10]], list(steps))
            solid(g)
        box = 'box = { periodic = "xy"; file = "p.h5"; };'
        self.made(fill)
        self.assertEqual(self.box()[0], [0, 0, 9, 10])
        self.is_read(PLACE + 0.2, columns="", more=box)
        self.is_refused("its disks are read at step 10, its box at step 20", more=box)
        self.made(lambda g: fill(g, steps=(0, 10, 30)))
        found, err = self.box()
        self.assertEqual(found, [0, 0, 8, 9])
        self.assertIn("step 10 is read", err)
        self.made(lambda g: fill(g, steps=(1, 11, 31)))
        self.assertIn("no step in common", self.box()[1])

    def test_several_boxes(self):
        for other, words in ([2.0, 3], ""), ([2.0, 4], "have different boxes"):
            with h5py.File(self.folder / "p.h5", "w") as file:
                file["particles/a/box/edges"], file["particles/b/box/edges"] = [2.0, 3], other
            found, err = self.box()
            self.assertEqual(found, 2 if words else [0, 0, 2, 3], err)
            self.assertIn(words, err)

    def test_our_own_export(self):
        """What `export --to h5md3d` makes is read as box and as disks, without those that were taken out."""
        deck = OPEN.replace("frames = 1;", "frames = 50;").replace("steps = 1;", "steps = 200;") + (
            'box = { periodic = "x"; x = (0.1, 0.9); }; bounds = { y = (-1, 9); outside = "remove"; }; disk_rows = ( { density = 1; '
            'columns = ("x", "y", "radius", "vx", "vy"); rows = ( (0.3, 0.5, 0.05, 1, 0), (0.5, -0.9, 0.05, 0, -10), '
            '(0.7, 0.5, 0.04, 0, 2) ); } );')
        self.run_deck(deck, name="own")
        status, _, err = run("export", self.folder / "own.h5", "--to", "h5md3d", "-o", self.folder / "own.h5md")
        self.assertEqual(status, 0, err)
        self.assertEqual(self.box("own.h5md", "x")[0], [0.1, 0, 0.9 - 0.1, 0])
        with h5py.File(self.folder / "own.h5") as file:
            disks = file["particles/disks"]
            there = disks["activity/value"][-1] != 2 if "activity" in disks else numpy.ones(3, bool)
            expected = numpy.c_[disks["position/value"][-1], disks["velocity/value"][-1, :, 0]][there]
        self.assertEqual(len(expected), 2)
        self.is_read(expected, file="own.h5md")
        self.is_read(expected, file="own.h5", columns='dataset = "/particles/disks"; columns = ("x", "y", "radius", "vx");')


if __name__ == "__main__":
    unittest.main()
