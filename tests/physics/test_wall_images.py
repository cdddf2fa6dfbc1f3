"""Straight walls and arcs have images in periodic boxes: a system that lies across the edges of its box does what it does in the
middle, in motion, in what is written and in what is measured. What cannot have images is refused before it runs."""
import sys
import unittest

import h5py
import numpy as np

import results_common
from results_common import run

HEAD = """
box = { x = (0, 1); y = (0, 1); periodic = "xy"; };
integrator = "%s"; dt = 2e-4; seed = 3;
materials = ( { name = "m"; k_n = 2e4; k_t = 1.2e4; gamma_n = 4.0; mu = 0.4; gamma_t = 1.0; k_r = 40.0; mu_r = 0.02; gamma_r = 0.1; } );
output = { series = 100; frames = 200; contacts = 100; };
measure = { walls = true; stress = true; disks = true; };
"""
# Corners, ends and sides are met in the middle of the box, where brackets are coordinates.
WALLS = {
    "line": 'type = "line"; points = ([0.5, 0.2], [0.5, 0.7]);',
    "flat line": 'type = "line"; points = ([0.1, 0.43], [0.6, 0.43]);',
    "segment": 'type = "segment"; points = ([0.5, 0.35], [0.46, 0.62]);',
    "long segment": 'type = "segment"; points = ([0.0, -0.25], [0.85, 1.3]);',
    "slope": 'type = "segment"; points = ([0.1, 0.1], [0.95, 0.4]);',
    "polyline": 'type = "polyline"; points = ([0.5, 0.3], [0.45, 0.45], [0.5, 0.6], [0.6, 0.65]);',
    "polygon": 'type = "polyline"; closed = true; points = ([0.48, 0.42], [0.56, 0.52], [0.48, 0.62], [0.42, 0.52]);',
    "saw": 'type = "polyline"; points = ([0.0, 0.4], [0.4, 0.46], [0.6, 0.38], [1.0, 0.4]);',
    "arc": 'type = "arc"; center = [0.6, 0.5]; radius = 0.14; from = 1.7; to = 4.4;',
    "bowl": 'type = "arc"; center = [0.4, 0.5]; radius = 0.15; from = -1.4; to = 1.4;',
    "ring": 'type = "arc"; center = [0.45, 0.5]; radius = 0.09; from = 0.0; to = 6.283185307179586;',
}
MOTIONS = {
    "still": "",
    "moving": '{ wall = "w"; coordinate = "x"; type = "harmonic"; amplitude = 0.1; frequency = 1; },'
              '{ wall = "w"; coordinate = "y"; type = "velocity"; velocity = 0.05; }',
    "far": '{ wall = "w"; coordinate = ("x", "y"); type = "velocity"; velocity = 0.911; }',
    "turning": '{ wall = "w"; coordinate = "theta"; type = "harmonic"; amplitude = 0.6; frequency = 1; }',
    "belt": '{ wall = "w"; coordinate = "surface"; type = "velocity"; velocity = 0.6; }',
    "load": '{ wall = "w"; coordinate = "x"; type = "load"; mass = 3; force = 2.0; }',
}
# x, y, radius, vx, vy, omega
DISKS = [(0.623, 0.501, 0.05, -1.01, 0.1, 3.0), (0.752, 0.53, 0.04, -1.03, -0.2, -5.0), (0.303, 0.551, 0.045, 0.81, 0.1, 2.0),
         (0.561, 0.33, 0.03, -0.4, 0.52, 0.0), (0.412, 0.72, 0.035, 0.1, -0.93, 4.0)]
WAYS = [(0.5, 0.0), (0.0, 0.5), (0.5, 0.5), (-1.53, 0.47)]


def moved(text, way):
    """Coordinates in brackets go this way."""
    out, at = "", 0
    while (begin := text.find("[", at)) >= 0:
        end = text.index("]", begin)
        x, y = (float(v) for v in text[begin + 1:end].split(","))
        out += text[at:begin] + "(%.17g, %.17g)" % (x + way[0], y + way[1])
        at = end + 1
    return out + text[at:]


def deck(wall, motion, way=(0.0, 0.0), integrator="verlet", steps=1800, head=HEAD):
    rows = ", ".join("(%.17g, %.17g, %g, %g, %g, %g)" % ((x + way[0]) % 1.0, (y + way[1]) % 1.0, *rest)
                     for x, y, *rest in DISKS)
    return (head % integrator + f"""
walls = ( {{ name = "w"; {moved(WALLS.get(wall, wall), way)} }} );
disk_rows = ( {{ columns = ("x", "y", "radius", "vx", "vy", "omega"); density = 100; rows = ( {rows} ); }} );
motions = ( {MOTIONS.get(motion, motion)} );
phases = ( {{ steps = {steps}; }} );
""")


def near(test, got, expected, tolerance, what):
    """Within `tolerance` of the largest."""
    got, expected = np.asarray(got, float), np.asarray(expected, float)
    test.assertEqual(got.shape, expected.shape, what)
    worst = np.abs(got - expected).max(initial=0)
    test.assertLessEqual(worst, tolerance * max(np.abs(expected).max(initial=0), 1.0), what)


class Images(results_common.Folder):
    def make(self, text, name, *words):
        path = self.folder / "deck.cfg"
        path.write_text(text)
        self.run_ok("run", path, "-o", self.folder / name, "--quiet", "--force", *words)
        return self.folder / name

    def compare(self, one, other, way, what):
        """The same motion, forces, contacts and stress."""
        with h5py.File(one) as a, h5py.File(other) as b:
            d = b["particles/disks/position/value"][:] - a["particles/disks/position/value"][:] - np.array(way)
            near(self, d - np.round(d), 0 * d, 1e-8, what)
            near(self, b["particles/disks/velocity/value"], a["particles/disks/velocity/value"], 1e-7, what)
            series = [name for name in a["observables"] if name.startswith(("wall_", "stress_", "kinetic_", "friction"))]
            if "line, " in what:
                series.remove("wall_torque")  # a line has no images along itself, but a pivot, which may go round the box
            self.assertGreater(len(series), 10)
            for name in series:
                near(self, b["observables"][name]["value"], a["observables"][name]["value"], 1e-6, f"{what}: {name}")
            for name in a["contacts"]:
                near(self, b["contacts"][name], a["contacts"][name], 1e-6, f"{what}: contacts {name}")
            return np.abs(a["observables/wall_force_x/value"]).max() > 0

    def test_across_edges(self):
        tried = touched = 0
        for k, wall in enumerate(WALLS):
            for n, motion in enumerate(MOTIONS):
                turns_in_vain = motion == "turning" and wall in ("line", "flat line", "saw", "long segment")
                if (k + n) % results_common.brief(3, 9) or turns_in_vain:
                    continue
                way = WAYS[tried % len(WAYS)]
                integrator = ("verlet", "gear5")[tried // 2 % 2]
                one = self.make(deck(wall, motion, integrator=integrator), "one.h5")
                other = self.make(deck(wall, motion, way, integrator), "other.h5")
                touched += self.compare(one, other, way, f"{wall}, {motion}, {integrator}, moved by {way}")
                tried += 1
        self.assertGreater(touched, 0.7 * tried)

    def test_a_wall_at_the_edge(self):
        """A disk that flies to x = 0.97 comes back."""
        for wall in ("line", "segment"):
            for axis in "xy":
                other = "yx"[axis == "y"]
                ends = "(0.02, 0), (0.02, 0.6)" if axis == "x" else "(0, 0.02), (0.6, 0.02)"
                text = f"""box = {{ {axis} = (0, 1); periodic = "{axis}"; }}; dt = 1e-4; integrator = "verlet";
materials = ( {{ name = "m"; k_n = 1e4; }} );
walls = ( {{ name = "w"; type = "{wall}"; points = ({ends}); }} );
disks = ( {{ {axis} = 0.9; {other} = 0.3; v{axis} = 1; radius = 0.05; mass = 1; }} );
phases = ( {{ steps = 4000; frames = 100; series = 1; }} ); measure = {{ walls = true; }};"""
                with h5py.File(self.make(text, "a.h5")) as file:
                    at = file["particles/disks/position/value"][:, 0, "xy".index(axis)]
                    v = file["particles/disks/velocity/value"][-1, 0, "xy".index(axis)]
                    force = file[f"observables/wall_force_{axis}/value"][:, 0]
                    self.assertAlmostEqual(v, -1, delta=2e-4)
                    self.assertLess(at.max(), 0.981)
                    self.assertAlmostEqual(force.sum() * 1e-4, 2, delta=1e-2)  # what the disk gave it

    def test_tables_agree_with_series(self):
        """Forces of contacts, as they are measured, add up to those that the engine has."""
        found = 0
        for wall in ("segment", "slope", "polyline", "saw", "bowl", "ring"):
            result = self.make(deck(wall, "moving", (0.5, 0.5)), "a.h5")
            self.run_ok("export", result, "--to", "csv", "-o", self.folder / wall)
            with h5py.File(result) as file, open(self.folder / wall / "contacts.csv", encoding="utf-8") as table:
                names = table.readline().strip().split(",")
                rows = np.array([[float(v or 0) for v in line.rstrip("\n").split(",")] for line in table]).reshape(-1, len(names))
                steps = file["observables/wall_force_x/step"][:]
                column = {name: rows[:, k] for k, name in enumerate(names)}
                for step in np.unique(column["step"]):
                    mine = (column["step"] == step) & (column["b"] == len(DISKS))
                    row = list(steps).index(step)
                    for c in "xy":
                        series = file[f"observables/wall_force_{c}/value"][row, 0]
                        self.assertAlmostEqual(column[f"force_{c}"][mine].sum(), series, delta=1e-6 * max(1, abs(series)),
                                               msg=f"{wall}, step {step}")
                    found += mine.sum()
        self.assertGreater(found, 3)

    def test_a_floor_that_meets_its_image(self):
        """A segment as long as the box, a polyline that ends on the image of its start, segments that meet across the edge: a line."""
        text = """box = { x = (0, 1); periodic = "x"; }; dt = 1e-4; integrator = "verlet"; gravity = { g = 10; };
materials = ( { name = "m"; k_n = 1e5; gamma_n = 5; k_t = %s; mu = %s; } );
walls = ( { name = "w"; %s } );
disks = ( { x = 0.9; y = 0.0499; radius = 0.05; density = 100; vx = 1; omega = -20; }, { x = 0.5; y = 0.03; radius = 0.03; density = 100; vx = 2; omega = 30; },
          { x = 0; y = 0.04; radius = 0.04; density = 100; } );
phases = ( { steps = 8000; series = 10; frames = 8000; } ); measure = { walls = true; };"""
        shapes = ('type = "line"; points = ((0, 0), (1, 0));', 'type = "segment"; points = ((0, 0), (1, 0));',
                  'type = "segment"; points = ((1, 0), (0, 0));', 'type = "polyline"; points = ((0.2, 0), (0.7, 0), (1.2, 0));',
                  'type = "polyline"; points = ((-0.1, 0), (0.1, 0), (0.2, 0), (0.35, 0), (0.5, 0), (0.9, 0));',
                  'type = "segment"; points = ((0.6, 0), (1, 0)); }, { name = "v"; type = "segment"; points = ((0, 0), (0.3, 0)); },'
                  ' { name = "u"; type = "segment"; points = ((-0.4, 0), (-0.7, 0));')
        for law in (("0", "0"), ("8e4", "0.4")):
            made = [self.make(text % (*law, shape), f"{k}.h5") for k, shape in enumerate(shapes)]
            with h5py.File(made[0]) as line:
                for result in made[1:]:
                    with h5py.File(result) as file:
                        d = file["particles/disks/position/value"][-1] - line["particles/disks/position/value"][-1]
                        near(self, d - np.round(d), 0 * d, 1e-9, result)
                        for name in ("force_x", "force_y", "contacts"):
                            near(self, file[f"observables/wall_{name}/value"][:].sum(axis=1),
                                 line[f"observables/wall_{name}/value"][:].sum(axis=1), 1e-6, f"{result}, {name}")

    def test_what_is_refused(self):
        line, inclined = 'type = "line"; points = ((0, 0), (1, 0));', 'type = "line"; points = ((0, 0), (1, 0.2));'
        turn = '{ name = "rock"; wall = "w"; coordinate = "theta"; type = "harmonic"; amplitude = 0.1; frequency = 1; }'
        wall = 'type = "segment"; points = ((0, 0.2), (%s));'
        cases = (
            (inclined, "", "x", 'wall "w": a line along (1, 0.2) does not fit to its images in a box that is periodic in x;'),
            (inclined, "", "xy", "periodic in x and y; expected a line along x or y, or a segment or polyline"),
            (line, turn, "x", 'wall "w": motion "rock" turns a line, which does not fit to its images in a box that is periodic in x;'),
            (wall % "2, 0.2", "", "x", 'wall "w": longer than the periodic box, it lies on or too near to its own image,'),
            (wall % "1.5, 0.25", "", "x", 'wall "w": longer than the periodic box, it lies on or too near to its own image,'),
            (wall % "1, 0.2", turn, "x", 'wall "w": motion "rock" turns a wall of size 1, which may come to lie on its own image;'),
            ('type = "polyline"; points = ((-0.5, 0.2), (0.5, 0.2), (1.5, 0.2));', "", "x", "it lies on or too near to its own image,"),
            ('type = "arc"; center = (0.5, 0.2); radius = 0.46; from = 0.0; to = 3.14;', "", "x", 'wall "w": the arc, 0.92 wide, and its image in x can touch a disk at the same time; expected less than 0.9,'),
            ('type = "segment"; points = ((0.1, 0.2), (0.1, 0.4)); }, { name = "copy"; type = "segment"; points = ((1.1, 0.2), (1.1, 0.4));', "", "x",
             'wall "copy": it stands where an image of wall "w" is, which pushes as well; expected one of them'),
            ('type = "line"; points = ((0, 0.1), (1, 0.1)); }, { name = "copy"; type = "line"; points = ((0.3, 1.1), (0.6, 1.1));', "", "y",
             'wall "copy": it stands where an image of wall "w" is, which pushes as well; expected one of them'),
        )
        for shape, motion, periodic, expected in cases:
            head = HEAD.replace('periodic = "xy"', f'periodic = "{periodic}"').replace("x = (0, 1); y = (0, 1);", " ".join(f"{c} = (0, 1);" for c in periodic))
            path = self.folder / "deck.cfg"
            path.write_text(deck(shape, motion, head=head))
            for command in ("check", "run"):
                status, _, err = run(command, path)
                self.assertEqual(status, 2, expected + err)
                self.assertIn("deck.cfg:8: ", err)
                self.assertIn(expected, err)

    def test_a_pressure_has_no_side(self):
        """Along a periodic direction disks are on both sides of a wall."""
        path = self.folder / "deck.cfg"
        path.write_text(deck("line", '{ wall = "w"; coordinate = "x"; type = "servo"; pressure = 1; speed = 1; length = 1; }'))
        status, _, err = run("check", path)
        self.assertEqual(status, 2)
        self.assertIn("motions[0].pressure = 1: this wall does not press along x; expected force", err)

    def test_what_is_not(self):
        """The same in open space, a wall of the other direction, a wall that turns and is shorter."""
        turn = '{ wall = "w"; coordinate = "theta"; type = "harmonic"; amplitude = 0.1; frequency = 1; }'
        for shape, motion, box in (('type = "line"; points = ((0, 0), (1, 0.2));', turn, ""),
                                   ('type = "segment"; points = ((-9, 0.2), (9, 0.2));', turn, ""),
                                   ('type = "segment"; points = ((0.1, -9), (0.1, 9));', "", "x"),
                                   ('type = "segment"; points = ((0.1, 0.2), (0.9, 0.2));', turn, "x"),
                                   ('type = "line"; points = ((0, 0.1), (1, 0.1)); }, { type = "line"; points = ((0, 0.9), (1, 0.9));', "", "x")):
            head = HEAD.replace('box = { x = (0, 1); y = (0, 1); periodic = "xy"; };', f'box = {{ {box} = (0, 1); periodic = "{box}"; }};' if box else "")
            path = self.folder / "deck.cfg"
            path.write_text(deck(shape, motion, head=head))
            status, _, err = run("check", path)
            self.assertEqual(status, 0, err)

    def test_overlaps_at_the_start(self):
        """A disk that sits in an image of a wall is told of; packings keep clear of images."""
        for shape in ('type = "segment"; points = ((0.01, 0.2), (0.01, 0.8));', 'type = "circle"; center = (0.02, 0.5); radius = 0.04; side = "outside";',
                      'type = "arc"; center = (0.2, 0.5); radius = 0.19; from = 2.0; to = 4.2;', 'type = "line"; points = ((0.01, 0), (0.01, 1));'):
            head = """box = { x = (0, 1); periodic = "x"; }; dt = 1e-4;
materials = ( { name = "m"; k_n = 1e4; } );
walls = ( { name = "w"; %s } );
phases = ( { steps = 1; } );
""" % shape
            path = self.folder / "deck.cfg"
            path.write_text(head + "disks = ( { x = 0.99; y = 0.5; radius = 0.05; mass = 1; } );")
            status, _, err = run("check", path)
            self.assertEqual(status, 2, shape)
            self.assertIn('deep in wall "w"', err)
            path.write_text(head + 'packings = ( { type = "random"; fraction = 0.4; x = (0, 1); y = (0, 1); sizes = "uniform"; lower = 0.02; upper = 0.03; density = 1; } );')
            out, err = self.run_ok("check", path)
            self.assertIn("contacts    0 at the start", out + err)


if __name__ == "__main__":
    sys.exit(unittest.main())
