"""Disks from files: data files and dumps of LAMMPS, HDF5 of others, and results of other runs with their contacts; the box from a file."""
import pathlib
import shutil
import signal
import tempfile
import unittest

import h5py
import numpy

from results_common import ROOT, Folder, assert_same, changed, run, start, wait_for

MATERIALS = """dt = 2e-5; gravity = { g = 9.81; tilt = 0.1; };
materials = ( { name = "grain"; k_n = 1e4; k_t = 5e3; gamma_n = 3; mu = 0.5; }, { name = "steel"; k_n = 1e4; } );
material_pairs = ( { materials = ["grain", "steel"]; k_n = 1e4; k_t = 5e3; gamma_n = 3; mu = 0.5; } );
"""
# every kind of wall, one without a name; one has been moved, one has been turned
WALLS = """walls = (
  { name = "bottom"; type = "line"; points = ( (-0.2, 0), (0.2, 0) ); material = "steel"; },
  { name = "left"; type = "segment"; points = ( (-0.09, 1), (-0.09, -1) ); material = "steel"; },
  { name = "right"; type = "polyline"; points = ( (0.09, -1), (0.09, 0.05), (0.1, 1) ); material = "steel"; },
  { type = "circle"; center = (0, -0.02); radius = 0.03; side = "outside"; material = "steel"; } );
"""
# two fixed disks stand among the free ones, so that slots are not numbers; angles are many turns
HEAP = MATERIALS + WALLS + """
disk_rows = (
  { columns = ("x", "y", "radius", "theta", "fixed", "group"); density = 3.57; material = "grain";
    rows = ( (-0.05, 0.03, 0.02, 0, 0, "low"), (0, 0.034, 0.022, 1e5, 0, "low"), (-0.02, -0.01, 0.012, 0, 1, "keel"),
      (0.05, 0.03, 0.018, 1, 0, "low"), (-0.03, 0.08, 0.02, 2, 0, "low"), (0.025, 0.08, 0.02, 3.9, 0, "low"),
      (0.02, -0.01, 0.012, 0, 1, "keel"), (0.07, 0.09, 0.015, -3.9, 0, "low"), (-0.06, 0.12, 0.019, -7, 0, "low"),
      (-0.01, 0.12, 0.021, 12, 0, "high"), (0.04, 0.125, 0.02, 0, 0, "high"), (0, 0.17, 0.02, 0, 0, "high"),
      (0.045, 0.18, 0.02, 0, 0, "high"), (-0.045, 0.175, 0.02, 0, 0, "high") ); } );
motions = (
  { name = "push"; wall = "left"; coordinate = "x"; type = "table"; times = (0, 0.1, 0.5, 0.6);
    values = (0, 0, 0.004, 0.004); },
  { name = "swing"; wall = 3; coordinate = "theta"; type = "table"; times = (0, 0.1, 0.5, 0.6);
    values = (0, 0, 0.7, 0.7); },
  { name = "lean"; wall = "right"; coordinate = "theta"; type = "table"; times = (0, 0.1, 0.5, 0.6);
    values = (0, 0, 0.01, 0.01); } );
phases = ( { time = 3; } ); output = { contacts = 1000; };
"""
GO = MATERIALS + WALLS + """disk_files = ( { file = "heap.h5"; contacts = true; } );
phases = ( { steps = 2000; series = 20; } ); output = { contacts = 100; };
"""
OPEN = "dt = 1e-4; materials = ( { name = \"m\"; k_n = 1e3; } ); steps = 1; output = { frames = 1; };\n"


def contacts(path, moment):
    """The table of contacts of that moment, in the order of the numbers."""
    with h5py.File(path) as file:
        c = file["contacts"]
        first, count = c["first"][moment], c["count"][moment]
        rows = {name: c[name][first:first + count]
                for name in ("a", "b", "part", "force", "tau", "zeta", "overlap", "sliding")}
    order = numpy.lexsort((rows["part"], rows["b"], rows["a"]))
    return {name: column[order] for name, column in rows.items()}


def kinetic(path):
    with h5py.File(path) as file:
        return sum(file[f"observables/kinetic_{k}/value"][()] for k in ("translation", "rotation"))


class Files(Folder):
    def write(self, name, text):
        path = self.folder / name
        path.write_text(text)
        return path

    def run_deck(self, text, *words, name="r"):
        """The result of a deck with this text; warnings are kept."""
        result = self.folder / f"{name}.h5"
        _, err = self.run_ok("run", self.write(f"{name}.cfg", text), "--force", "-o", result, *words)
        self.warnings = [line for line in err.split("\n") if "warning:" in line]
        return result

    def start_of(self, text):
        """Columns of the disks at step 0."""
        with h5py.File(self.run_deck(text)) as file:
            disks = file["particles/disks"]
            found = {name: disks[name][()] for name in ("radius", "mass", "inertia", "species", "group", "driven")}
            found["x"], found["y"] = disks["position/value"][0].T
            found["vx"], found["vy"] = disks["velocity/value"][0].T
            found["theta"], found["omega"] = disks["angle/value"][0], disks["angular_velocity/value"][0]
        return found

    def refuse(self, text, *expected):
        status, _, err = run("check", self.write("bad.cfg", text))
        self.assertEqual(status, 2, err)
        for words in expected:
            self.assertIn(words, err)


class Lammps(Files):
    """decks/sphere.data was written by LAMMPS (29 Sep 2021), write_data, atom_style sphere, fix nve/sphere disc."""

    def setUp(self):
        super().setUp()
        self.text = (ROOT / "tests/decks/sphere.data").read_text()

    def deck(self, keys, data=None, box=""):
        self.write("a.data", self.text if data is None else data)
        return OPEN + box + f'disk_files = ( {{ file = "a.data"; {keys} }} );'

    def lines(self, section, n=12):
        rows = self.text.split(section)[1].split("\n")[2:2 + n]
        return numpy.array(sorted([float(w) for w in row.split()] for row in rows))

    def test_file_of_lammps(self):
        atoms, velocities = self.lines("Atoms # sphere"), self.lines("Velocities")
        self.assertNotEqual(self.text.split("# sphere\n\n")[1].split()[0], "1", "the file's order is to be another")
        disks = self.start_of(self.deck("density = 3;"))
        for name, expected in (("x", atoms[:, 4]), ("y", atoms[:, 5]), ("radius", atoms[:, 2] / 2),
                               ("vx", velocities[:, 1]), ("vy", velocities[:, 2]), ("omega", velocities[:, 6])):
            self.assertTrue((disks[name] == expected).all(), name)
        self.assertTrue(numpy.allclose(disks["mass"], 3 * numpy.pi * disks["radius"]**2, rtol=1e-15))

    def test_columns(self):
        atoms = self.lines("Atoms # sphere")
        disks = self.start_of(self.deck('columns = ("x", "y", "radius", "mass", "group = type", "name = id");') +
                              'locks = ( { group = "2"; coordinates = "theta"; }, { disk = "3"; coordinates = "x"; } );')
        self.assertTrue(numpy.allclose(disks["mass"], atoms[:, 3] * 4 / 3 * numpy.pi * (atoms[:, 2] / 2)**3,
                                       rtol=1e-15))
        self.assertTrue((disks["vx"] == 0).all())
        self.assertEqual(list(disks["group"]), [{1: 0, 2: 1}[t] for t in atoms[:, 1]])

    def test_common_values_go_before(self):
        disks = self.start_of(self.deck("density = 3; radius = 0.1; vx = 0; vy = 0; omega = 0;"))
        self.assertTrue((disks["radius"] == 0.1).all() and (disks["vx"] == 0).all())

    def test_box(self):
        box = 'box = { periodic = "xy"; file = "a.data"; };'
        with h5py.File(self.run_deck(self.deck("density = 3;", box=box))) as file:
            self.assertEqual(list(file["particles/disks/box/edges"][()]), [2, 1.5])
            self.assertEqual(list(file["particles/disks/box"].attrs["lower"]), [-1, -0.75])

    def test_hybrid(self):
        rows = self.text.split("# sphere\n\n")[1].split("\n\n")[0].split("\n")
        words = [row.split() for row in rows]
        hybrid = "\n".join(" ".join(w[:2] + w[4:7] + w[2:4] + ["0"] + w[7:]) for w in words)
        plain = self.start_of(self.deck("density = 3;"))
        other = self.start_of(self.deck("density = 3;", self.text.replace("\n".join(rows), hybrid).replace(
            "# sphere", "# hybrid sphere molecular")))
        for name in plain:
            self.assertTrue((plain[name] == other[name]).all(), name)

    def test_mistakes(self):
        def bad(old, new, *expected):
            self.assertIn(old, self.text)
            self.refuse(self.deck("density = 3;", self.text.replace(old, new, 1)), *expected)

        bad("# sphere", "# full", "a.data:10: Atoms # full: expected # sphere")
        bad("# sphere", "", "the atom style is not given in a comment")
        bad("# sphere", "# hybrid", "which styles it is made of is not said")
        bad("12 atoms", "13 atoms", "12 atoms in section Atoms; the header says 13")
        bad("zlo zhi\n", "zlo zhi\n0.1 0 0 xy xz yz\n", "tilted")
        bad("\n2 2 0.5", "\n1 2 0.5", "id = 1: two atoms have it")
        bad("\n2 2 0.5", "\n2 2 half", "diameter = half: expected a number")
        bad("\n2 2 0.5", "\n2 2 -0.5", "radius", "expected a number > 0")
        bad("\n2 2 0.5", "\n2 2", "9 values; expected 7 of an atom of style sphere, or 3 more")
        bad("Velocities\n\n", "Velocities\n\n77 0 0 0 0 0 0\n", "id = 77: no atom has it")
        self.refuse(self.deck("density = 3;", "x, y, radius\n1, 2, 3\n"), "this is no LAMMPS data file")
        self.refuse(self.deck("density = 3;", self.text.split("Atoms")[0] + "Masses\n\n1 1\n"), "no section Atoms")
        self.refuse(self.deck('columns = ("x", "y", "radius", "density");'), "mass over the volume of a sphere")
        self.refuse(self.deck('density = 1; columns = ("x", "y", "z");'), 'no column of disks is called "z"')
        self.refuse(self.deck('density = 1; columns = ("x", "y", "radius = type");'), '"type" is a word')
        self.refuse(self.deck("density = 3; contacts = true;"), "belongs to results of a run")
        self.refuse(self.deck("density = 3;", box='box = { periodic = "x"; file = "no.data"; };'), "no.data")



class Dumps(Files):
    """Text dumps of LAMMPS: positions in every form, the frame, the box, and the way back from slipdisk export."""
    ROWS = ((3, 2, 0.9, -0.3, 0.2, 3.0, 1, 2, 3), (1, 1, -0.5, 0.5, 0.1, 1.0, -1, 0, 0), (2, 1, 0.3, 0.2, 0.15, 2.0, 0, 0.5, -7))
    BOX = ((-1, 1), (-0.75, 0.75))

    def dump(self, frames, names="id type x y radius mass vx vy omegaz", name="a.dump"):
        text = ""
        for step, rows in frames:
            bounds = "\n".join(f"{low} {high}" for low, high in (*self.BOX, (-0.5, 0.5)))
            text += (f"ITEM: TIMESTEP\n{step}\nITEM: NUMBER OF ATOMS\n{len(rows)}\nITEM: BOX BOUNDS pp pp pp\n{bounds}\n"
                     f"ITEM: ATOMS {names}\n" + "".join(" ".join(map(repr, row)) + "\n" for row in rows))
        self.write(name, text)
        return text

    def deck(self, keys="", box=""):
        return OPEN + box + f'disk_files = ( {{ file = "a.dump"; {keys} }} );'

    def expect(self, disks, rows):
        rows = numpy.array(sorted(rows))
        for k, name in enumerate(("x", "y", "radius", "mass", "vx", "vy", "omega")):
            self.assertTrue(numpy.allclose(disks[name], rows[:, k + 2], rtol=0, atol=1e-15), name)

    def test_frames(self):
        later = [(*row[:2], row[2] / 2, *row[3:]) for row in self.ROWS]
        self.dump([(0, self.ROWS[:1]), (500, self.ROWS), (1000, later)])
        self.expect(self.start_of(self.deck()), later)
        self.expect(self.start_of(self.deck("timestep = 500;")), self.ROWS)
        self.refuse(self.deck("timestep = 700;"), "the dump has no timestep 700; expected one from 0 to 1000")
        box = 'box = { periodic = "xy"; file = "a.dump"; };'
        self.refuse(self.deck("timestep = 500;", box), "its disks are read at timestep 500, its box at timestep 1000; expected one moment")
        with h5py.File(self.run_deck(self.deck("timestep = 500;", box.replace("file", "timestep = 500; file")))) as file:
            self.assertEqual(list(file["particles/disks/box/edges"][()]), [2, 1.5])
            self.assertEqual(list(file["particles/disks/box"].attrs["lower"]), [-1, -0.75])

    def test_positions(self):
        """Scaled, unwrapped and scaled unwrapped positions are those in the box."""
        size = [high - low for low, high in self.BOX]
        for names, lower, scale, images in (("xs ys", [low for low, _ in self.BOX], size, 0), ("xu yu", [0, 0], [1, 1], 3),
                                            ("xsu ysu", [low for low, _ in self.BOX], size, -2)):
            rows = [(*row[:2], *((row[2 + c] + images * size[c] - lower[c]) / scale[c] for c in range(2)), *row[4:]) for row in self.ROWS]
            self.dump([(0, rows)], f"id type {names} radius mass vx vy omegaz")
            self.expect(self.start_of(self.deck()), self.ROWS)

    def test_columns(self):
        self.dump([(0, self.ROWS)])
        disks = self.start_of(self.deck('columns = ("x", "y", "radius", "mass", "group = type", "name = id");') +
                              'locks = ( { group = "2"; coordinates = "theta"; }, { disk = "3"; coordinates = "x"; } );')
        self.assertEqual((list(disks["mass"]), list(disks["vx"])), ([1, 2, 3], [0, 0, 0]))
        disks = self.start_of(self.deck("density = 2; vx = 1;"))
        self.assertTrue(numpy.allclose(disks["mass"], 2 * numpy.pi * disks["radius"]**2) and (disks["vx"] == 1).all())
        self.dump([(0, [row[2:5] for row in self.ROWS])], "x y radius")
        disks = self.start_of(self.deck("mass = 1;"))
        self.assertEqual(list(disks["x"]), [row[2] for row in self.ROWS])
        self.refuse(self.deck('mass = 1; columns = ("x", "y", "radius", "vx");'), 'column "vx": line 9 of the dump has none')
        self.refuse(self.deck('mass = 1; columns = ("x", "y", "radius", "name = id");'), 'column "id": line 9 of the dump has none')
        self.refuse(self.deck(), "density: missing for all its disks: expected density (or mass) here, or in a column")
        self.write("b.csv", "x,y,radius\n0,0,1\n")
        self.refuse(OPEN + 'disk_files = ( { file = "b.csv"; mass = 1; timestep = 3; } );', "timestep = 3: belongs to dumps of LAMMPS only")
        self.refuse(OPEN + f'disk_files = ( {{ file = "{ROOT}/tests/decks/sphere.data"; density = 1; timestep = 3; }} );',
                    "a data file has no timesteps")

    def test_there_and_back(self):
        """The last frame of an export begins a deck as it ended."""
        made = self.run_deck(HEAP.replace("time = 3", "steps = 2000; frames = 1000"), name="heap")
        self.run_ok("export", made, "--to", "lammps-dump", "-o", self.folder / "a.dump")
        found = self.start_of(self.deck())
        with h5py.File(made) as file:
            disks = file["particles/disks"]
            for name, values in (("x", disks["position/value"][-1, :, 0]), ("y", disks["position/value"][-1, :, 1]),
                                 ("vx", disks["velocity/value"][-1, :, 0]), ("theta", disks["angle/value"][-1]),
                                 ("omega", disks["angular_velocity/value"][-1]), ("radius", disks["radius"][:]), ("mass", disks["mass"][:])):
                self.assertTrue(numpy.allclose(found[name], values, rtol=1e-14, atol=1e-300), name)  # 15 digits


class Hdf5(Files):
    X, Y, R = numpy.array([0, 1, 2.5]), numpy.array([3, 4, 5.5]), numpy.array([0.5, 0.25, 0.125])

    def check_disks(self, keys, **more):
        disks = self.start_of(OPEN + f'disk_files = ( {{ file = "p.h5"; {keys} density = 2; }} );')
        for name, expected in {"x": self.X, "y": self.Y, "radius": self.R, **more}.items():
            self.assertTrue((disks[name] == expected).all(), name)

    def test_compound(self):
        rows = numpy.zeros(3, [("radius", "f4"), ("x", "f8"), ("y", "f8"), ("spin", "i4")])
        rows["x"], rows["y"], rows["radius"], rows["spin"] = self.X, self.Y, self.R, (1, 2, 3)
        with h5py.File(self.folder / "p.h5", "w") as file:
            file["a/table"] = rows
        self.check_disks('dataset = "/a/table";')
        self.check_disks('dataset = "/a/table"; columns = ("x", "y", "radius", "omega = spin");', omega=[1, 2, 3])

    def test_matrix(self):
        with h5py.File(self.folder / "p.h5", "w") as file:
            file["plain"] = numpy.c_[self.X, self.Y, self.R]
            file["short"] = numpy.c_[self.X, self.Y, self.R]
            file["short"].attrs["columns"] = "x y"
            file["named"] = numpy.c_[self.R, self.Y, self.X, self.Y]
            file["named"].attrs["columns"] = ["radius", "y", "x", "vx"]
        deck = OPEN + 'disk_files = ( { file = "p.h5"; dataset = "%s"; mass = 1; } );'
        self.refuse(deck % "plain", 'without names of its columns; expected an attribute "columns"')
        self.refuse(deck % "short", '3 columns, and its attribute "columns" 2 names')
        self.check_disks('dataset = "named"; columns = ("x", "y", "radius", "vx");', vx=self.Y)

    def test_group(self):
        with h5py.File(self.folder / "p.h5", "w") as file:
            file["g/x"], file["g/y"], file["g/diameter"] = self.X, self.Y, 2 * self.R
            file["g/radius"] = self.R
        self.check_disks('dataset = "/g";')
        self.refuse(OPEN + 'disk_files = ( { file = "p.h5"; dataset = "g"; columns = ("x", "z = y"); mass = 1; } );',
                    'no column of disks is called "z"')
        self.refuse(OPEN + 'disk_files = ( { file = "p.h5"; dataset = "g"; mass = 1; '
                    'columns = ("x", "y", "radius = width"); } );', 'column "width": there is no such dataset')

    def test_h5md_of_others(self):
        """The last frame; elements that do not change may be fixed."""
        with h5py.File(self.folder / "p.h5", "w") as file:
            place = numpy.zeros((3, 3, 2))
            place[-1] = numpy.c_[self.X, self.Y]
            file["particles/disks/position/value"] = place
            file["particles/disks/velocity/value"] = place + 1
            file["particles/disks/angle/value"] = place[..., 0] + 2
            file["particles/disks/angular_velocity"] = self.R + 3
            file["particles/disks/radius"] = self.R
        self.check_disks('dataset = "/particles/disks";', vx=0 * self.X)
        self.check_disks('dataset = "/particles/disks"; '
                         'columns = ("x", "y", "radius", "vx", "vy", "theta", "omega");',
                         vx=self.X + 1, vy=self.Y + 1, theta=self.X + 2, omega=self.R + 3)

    def test_mistakes(self):
        with h5py.File(self.folder / "p.h5", "w") as file:
            file["g/x"], file["g/y"], file["g/radius"] = self.X, self.Y, self.R
        bad = OPEN + 'disk_files = ( { file = "p.h5"; mass = 1; '
        self.refuse(bad + "} );", "dataset: missing")
        self.refuse(bad + 'dataset = "g"; contacts = true; } );', "is no result or checkpoint of a run")
        self.refuse(bad + 'dataset = "h"; } );', "there is no dataset or group h")
        self.refuse(bad.replace("p.h5", "q.h5") + 'dataset = "h"; } );', "q.h5")
        self.refuse(bad + 'dataset = "g"; columns = ("x", "y", "radius", "group = x"); } );', "is a text")


class Columns(Files):
    """Names and values of other programs: hints that can be obeyed, and arithmetic with a column."""
    X, Y, D = numpy.array([0, 1.5, -2.7]), numpy.array([3, 4.1, 5.5]), numpy.array([0.9, 0.3, 0.7])
    # line of names, the hint, and columns that are no hint of anything
    NAMES = (("PosX,PosY,Diameter", '"x = PosX", "y = PosY", "radius = 0.5 * Diameter"'),
             ("X,Y,DIAM", '"x = X", "y = Y", "radius = 0.5 * DIAM"'),
             ('"Points:0","Points:1",diameter', '"x = Points:0", "y = Points:1", "radius = 0.5 * diameter"'),
             ("Position X,Position Y,dia-meter", '"x = Position X", "y = Position Y", "radius = 0.5 * dia-meter"'),
             ("X,Y,index", '"x = X", "y = Y", "radius = ..."'), ("X,Y,Rho", '"x = X", "y = Y", "radius = ..."'),
             ("exp,year,error", '"x = ...", "y = ...", "radius = ..."'), ("x (m),y (m),R (mm)", '"x = ...", "y = ...", "radius = ..."'))

    def table(self, names):
        self.write("a.csv", names + "\n" + "".join(f"{x!r},{y!r},{d!r}\n" for x, y, d in zip(*map(list, (self.X, self.Y, self.D)))))

    def deck(self, keys, file="a.csv"):
        return OPEN + f'constants = {{ half = 0.5; }}; disk_files = ( {{ file = "{file}"; density = 1; {keys} }} );'

    def holds(self, keys, **more):
        disks = self.start_of(self.deck(**keys) if isinstance(keys, dict) else self.deck(keys))
        for name, expected in {"x": self.X, "y": self.Y, "radius": 0.5 * self.D, **more}.items():
            self.assertEqual(list(disks[name]), list(expected), (keys, name))

    def test_what_a_hint_says_is_read_with_the_right_values(self):
        for names, hint in self.NAMES:
            with self.subTest(names):
                self.table(names)
                self.refuse(self.deck(""), f"columns = ({hint})")
                if "..." in hint:
                    self.refuse(self.deck(f"columns = ({hint});"), 'no column "..."')
                    continue
                self.holds(f"columns = ({hint});")
                self.refuse(self.deck('columns = ("x", "y", "radius");'), *(f"did you mean {one}?" for one in hint.split(", ")))
        self.table("x,y,mask")
        self.refuse(self.deck('mass = 1; columns = ("x", "y", "mass");'), 'no column "mass" in the line of names; found "x", "y", "mask"')
        for name, told in (("vz", "expected x, y, theta"), ("fx", "expected x, y, theta"), ("index", "expected x, y, theta"),
                           ("diameter", 'did you mean "radius = 0.5 * diameter"?'), ("omegaz", 'did you mean "omega = omegaz"?')):
            self.refuse(self.deck(f'columns = ("x", "y", "{name}");'), f'no column of disks is called "{name}"; {told}')

    def test_every_format_takes_arithmetic(self):
        self.table("x,y,d (m)")
        for text in ("0.5 * d (m)", "d (m)/2", "half*d (m)", "d (m) - half * d (m)", "d (m) / sqrt(4)"):
            self.holds(f'columns = ("x = 2 * x / 2", "y", "radius = {text}");')
        rows = numpy.zeros(3, [("x", "f8"), ("y", "f8"), ("d:0", "f8"), ("rate", "f8")])
        rows["x"], rows["y"], rows["d:0"], rows["rate"] = self.X, self.Y, self.D, self.X
        with h5py.File(self.folder / "p.h5", "w") as file:
            file["compound"] = rows
            file["matrix"] = numpy.c_[self.X, self.Y, self.D, self.X]
            file["matrix"].attrs["columns"] = ["x", "y", "d:0", "rate"]
            for name in rows.dtype.names:
                file[f"group/{name}"] = rows[name]
                file[f"particles/all/{name}"] = rows[name]
            place = numpy.zeros((1, 3, 2))
            place[0] = numpy.c_[self.X, self.Y]
            file["particles/all/position/value"] = place
        for dataset in ("compound", "matrix", "group", "particles/all"):
            self.holds({"keys": f'dataset = "{dataset}"; columns = ("x", "y", "radius = half * d:0", "vx = 2 * rate");', "file": "p.h5"},
                       vx=2 * self.X)
        atoms = "".join(f"{k + 1} 1 {self.D[k]!r} 1 {self.X[k]!r} {self.Y[k]!r} 0\n" for k in range(3))
        self.write("l.data", "LAMMPS\n\n3 atoms\n-9 9 xlo xhi\n-9 9 ylo yhi\n\nAtoms # sphere\n\n" + atoms)
        self.write("l.dump", "ITEM: TIMESTEP\n0\nITEM: NUMBER OF ATOMS\n3\nITEM: BOX BOUNDS ff ff ff\n-9 9\n-9 9\n-1 1\n"
                   "ITEM: ATOMS id type diameter mass x y z\n" + atoms)
        for file in ("l.data", "l.dump"):
            self.holds({"keys": "", "file": file})
            self.holds({"keys": 'columns = ("x", "y", "radius");', "file": file})
            self.holds({"keys": 'columns = ("x", "y", "radius = 0.5 * diameter", "vx = -y");', "file": file}, vx=-self.Y)

    def test_mistakes(self):
        self.table("X,Y,Diameter")
        for text, told in (("radius = 0.5 * Diametr", 'no column "Diametr" in the line of names; did you mean "Diameter"?'),
                           ("radius = 0.5 * X * Diameter", 'expected one column of the file; "X" and "Diameter" are two'),
                           ("radius = 0.5 * (Diameter", "a ) is missing"), ("radius = half * 2", "it names no column of the file"),
                           ("radius = haf * Diameter", 'a.csv:2: radius = haf * Diameter with Diameter = 0.9: no constant is called "haf"'),
                           ("radius = 1 / (Diameter - 0.3)", "a.csv:3: radius = 1 / (Diameter - 0.3) with Diameter = 0.3: division by zero"),
                           ("radius = -Diameter", "radius = -0.9")):
            with self.subTest(text):
                self.refuse(self.deck(f'columns = ("x = X", "y = Y", "{text}");'), told)
        self.refuse(OPEN + 'disk_rows = ( { columns = ("x", "y", "radius = 2 * r"); density = 1; rows = ( (0, 0, 1) ); } );',
                    "expected a name alone: the values are those of the rows")


class Tables(Files):
    """A mistake that all rows of a table have is told once."""

    FILES = {"c.csv": "x, y, radius\n0, 0, 0.5\n2, 0, 0.5\n4, 0, 0.5\n", "place.csv": "x, y\n0, 0\n2, 0\n4, 0\n",
             "zero.csv": "x, y, radius, density\n0, 0, 0.5, 0\n2, 0, 0.5, 0\n4, 0, 0.5, 0\n",
             "both.csv": "x, y, radius, mass, density\n0, 0, 0.5, 1, 1\n2, 0, 0.5, 1, 1\n4, 0, 0.5, 1, 1\n",
             "kinds.csv": "x, y, radius, mass, material\n0, 0, 0.5, 1, a\n2, 0, 0.5, 1, b\n4, 0, 0.5, 1, a\n",
             "l.data": "LAMMPS\n\n3 atoms\n-9 9 xlo xhi\n-9 9 ylo yhi\n\nAtoms # sphere\n\n"
                       "1 1 1 0 0 0 0\n2 1 1 0 2 0 0\n3 1 1 0 4 0 0\n",
             "point.data": "LAMMPS\n\n3 atoms\n-9 9 xlo xhi\n-9 9 ylo yhi\n\nAtoms # sphere\n\n"
                           "1 1 0 1 0 0 0\n2 1 0 1 2 0 0\n3 1 0 1 4 0 0\n"}
    ROWS = "rows = ( (0, 0), (2, 0), (4, 0) );"
    FIXED = "expected density (or mass) here, or in a column (key columns)"

    def test_one_message(self):
        for name, text in self.FILES.items():
            self.write(name, text)
        with h5py.File(self.folder / "p.h5", "w") as file:
            for k, column in enumerate(("x", "y", "radius")):
                file[f"g/{column}"] = numpy.array([0, 2, 4]) * (k == 0) + 0.5 * (k == 2)
        file = "disk_files[0]."
        none = "density: missing for all its disks: " + self.FIXED
        for keys, expected in (
                ('file = "c.csv";', [file + none]),
                ('file = "l.data";', [file + none]),
                ('file = "p.h5"; dataset = "g";', [file + none]),
                ('file = "p.h5"; dataset = "g"; columns = ("x", "y");', [file + "radius: missing", file + none]),
                ('file = "place.csv"; mass = 1;', [file + "radius: missing for all its disks: expected radius here"]),
                ('file = "c.csv"; columns = ("x", "radius"); mass = 1;', [file + "y: missing"]),
                ('file = "c.csv"; columns = ("y", "radius"); mass = 1;', [file + "x: missing"]),
                ('file = "zero.csv";', ["zero.csv:2: density = 0: expected a number > 0; none of the 3 rows has one, so leave out "
                                        "this column and give mass or density in the deck"]),
                ('file = "l.data"; columns = ("x", "y", "radius", "mass");', ["l.data:9: mass = 0: expected a number > 0"]),
                ('file = "point.data"; density = 1;', ["point.data:9: radius = 0: expected a number > 0"]),
                ('file = "both.csv";', [file + "density: given together with mass"]),
                ('file = "c.csv"; mass = 1; fixed = true; vx = 1;', [file + "fixed = true: a fixed disk cannot have a velocity"]),
                ('file = "kinds.csv";', ['kinds.csv:2: material: no material is called "a"',
                                         'kinds.csv:3: material: no material is called "b"']),
                ('columns = ("x", "y"); ' + self.ROWS, ["disk_rows[0].radius: missing", "disk_rows[0]." + none]),
                ('columns = ("x", "mass"); y = 0; radius = 0.5; ' + self.ROWS, ["bad.cfg:2: mass = 0: expected a number > 0"])):
            kind = "disk_rows" if "rows" in keys else "disk_files"
            with self.subTest(keys):
                status, _, err = run("check", self.write("bad.cfg", OPEN + f"{kind} = ( {{ {keys} }} );"))
                told = [line for line in err.splitlines() if "bad.cfg" in line or ".csv:" in line or ".data:" in line]
                self.assertEqual(status, 2, err)
                self.assertEqual(len(told), len(expected), err)
                for words in expected:
                    self.assertIn(words, err)

    def test_some_rows(self):
        """Mistakes of single rows stay with their lines."""
        self.write("some.csv", "x, y, radius\n0, 0, 0\n2, 0, 0.5\n4, 0, -1\n")
        self.refuse(OPEN + 'disk_files = ( { file = "some.csv"; mass = 1; } );', "some.csv:2: radius: 0: expected",
                    "some.csv:4: radius: -1: expected")


class Box(Files):
    DISKS = 'disks = ( { x = 0.5; y = 0.5; radius = 0.05; mass = 1; } );'

    def edges(self, box):
        with h5py.File(self.run_deck(OPEN + self.DISKS + f"box = {{ {box} }};")) as file:
            box = file["particles/disks/box"]
            edges = box["edges/value"][-1] if "value" in box["edges"] else box["edges"][()]
            return list(box.attrs["lower"]) + list(edges)

    def test_forms(self):
        with h5py.File(self.folder / "fixed.h5", "w") as file:
            file["particles/disks/box/edges"] = numpy.array([2.0, 3])
        with h5py.File(self.folder / "frames.h5", "w") as file:
            file["particles/disks/box/edges/value"] = numpy.array([[9.0, 9], [2, 3]])
            file["particles/disks/box"].attrs["lower"] = numpy.array([0.25, -1])
        self.assertEqual(self.edges('periodic = "xy"; file = "fixed.h5";'), [0, 0, 2, 3])
        self.assertEqual(self.edges('periodic = "xy"; file = "frames.h5";'), [0.25, -1, 2, 3])
        self.assertEqual(self.edges('periodic = "y"; file = "frames.h5";'), [0, -1, 0, 3])
        self.assertEqual(self.edges('periodic = "xy"; x = (0, 1); file = "frames.h5";'), [0, -1, 1, 3])

    def test_of_a_result(self):
        deck = OPEN + self.DISKS + 'box = { periodic = "x"; x = (0.1, 0.8); };'
        self.run_deck(deck, name="a")
        self.assertEqual(self.edges('periodic = "x"; file = "a.h5";'), [0.1, 0, 0.8 - 0.1, 0])
        self.refuse(OPEN + self.DISKS + 'box = { periodic = "xy"; file = "a.h5"; };', "not periodic in y")

    def test_mistakes(self):
        with h5py.File(self.folder / "none.h5", "w") as file:
            file["x"] = 1
        self.refuse(OPEN + self.DISKS + 'box = { periodic = "x"; file = "none.h5"; };', "has no edges")
        self.refuse(OPEN + self.DISKS + 'box = { periodic = "x"; file = "gone.h5"; };', "gone.h5")
        self.refuse(OPEN + self.DISKS + 'box = { periodic = "x"; };', "missing: expected (lower, upper)")


class Contacts(Files):
    """A heap that has come to rest is the beginning of other runs."""

    made = None

    @classmethod
    def setUpClass(cls):
        cls.made = pathlib.Path(tempfile.mkdtemp(prefix="slipdisk-heap-"))
        (cls.made / "heap.cfg").write_text(HEAP)
        _, _, cls.trouble = run("run", cls.made / "heap.cfg", "--quiet", "-o", cls.made / "heap.h5")

    @classmethod
    def tearDownClass(cls):
        shutil.rmtree(cls.made)

    def setUp(self):
        super().setUp()
        self.heap = self.folder / "heap.h5"
        self.assertTrue((self.made / "heap.h5").exists(), self.trouble)
        shutil.copy(self.made / "heap.h5", self.heap)
        self.old = contacts(self.heap, -1)
        self.assertLess(kinetic(self.heap)[-1], 1e-20, "the heap is not at rest")
        self.assertGreater(len(self.old["a"]), 15)
        # there are contacts with each kind of wall, and some stretched skin
        self.assertEqual(set(range(14, 18)) - set(self.old["b"]), set())
        self.assertGreater(abs(self.old["tau"]).max(), 0.01)

    def assert_same_contacts(self, new, tolerance=1e-9):
        for name in "a", "b", "part", "sliding":
            self.assertEqual(list(self.old[name]), list(new[name]), name)
        # a disk has turned by 1e5 rad, which the file keeps to 7e-12: R 7e-12 in lambda
        rounding = {"zeta": 0.022 * 7.3e-12, "tau": 5e3 * 0.022 * 7.3e-12}
        for name in "force", "tau", "zeta", "overlap":
            bound = max(tolerance * abs(self.old[name]).max(), rounding.get(name, 0))
            self.assertLess(abs(self.old[name] - new[name]).max(), bound, name)

    def test_equilibrium_goes_on(self):
        go = self.run_deck(GO)
        self.assertEqual(self.warnings, [])
        self.assert_same_contacts(contacts(go, 0))
        self.assert_same_contacts(contacts(go, -1))
        self.assertLess(kinetic(go).max(), 1e-16)
        with h5py.File(self.heap) as old, h5py.File(go) as new:
            for name in "position", "angle":
                self.assertTrue((old[f"particles/disks/{name}/value"][-1] ==
                                 new[f"particles/disks/{name}/value"][0]).all(), name)
            for name in "mass", "inertia", "species", "driven":
                self.assertTrue((old[f"particles/disks/{name}"][()] == new[f"particles/disks/{name}"][()]).all(), name)
            self.assertEqual(new["summary/energy"].attrs["opening"], 0)
            self.assertIn("contacts = true", new["parameters/deck_full"][()].decode())

    def test_without_contacts_it_relaxes(self):
        go = self.run_deck(GO.replace("contacts = true", "contacts = false").replace(
            WALLS, WALLS.replace("-0.09, ", "-0.086, ")))
        self.assertGreater(kinetic(go).max(), 1e-9)
        self.assertEqual(abs(contacts(go, 0)["tau"]).max(), 0)

    def test_other_slots(self):
        """Disks that were free are prescribed now, and others stand before those of the file."""
        go = GO.replace("contacts = true;", "contacts = true; vx = 0; vy = 0; omega = 0;")
        more = ('disks = ( { x = 3; y = 3; radius = 0.1; mass = 1; fixed = true; material = "grain"; } );'
                'motions = ( { group = "high"; coordinate = ("x", "y", "theta"); type = "fixed"; } );')
        new = contacts(self.run_deck(go + more), 0)
        old = {frozenset((a, b if b < 14 else b + 1000)): f
               for a, b, f in zip(self.old["a"], self.old["b"], self.old["tau"])}
        high = set(range(9, 14))
        kept = 0
        for a, b, f in zip(new["a"].astype(int), new["b"].astype(int), new["tau"]):
            pair = frozenset((a - 1, b - 1 if b < 15 else b - 1 + 1000))
            self.assertAlmostEqual(old[pair], f, delta=1e-9)
            kept += 1
        lost = sum(len(pair - high) == 0 or pair <= high | set(range(1014, 1018)) for pair in old)
        self.assertEqual(kept, len(old) - lost)
        self.assertIn(f"{lost} of {len(old)} contacts of the packing do not touch", "".join(self.warnings))

    def test_contacts_that_are_apart(self):
        """What is dropped is no loss."""
        with changed(self.heap) as file:
            slot = list(file["state/id"][()]).index(13)
            file["state/x"][slot] += 3e-5
        go = self.run_deck(GO + "measure = { disks = true; };")
        self.assertIn("do not touch at the start", "".join(self.warnings))
        self.assertLess(len(contacts(go, 0)["a"]), len(self.old["a"]))
        with h5py.File(go) as file:
            self.assertEqual(file["observables/opening/value"][0], 0)
            self.assertTrue((file["state/loss_opening"][()] >= 0).all())
            lost = file["observables/viscous/value"][-1] + file["observables/friction/value"][-1]
            self.assertGreater(lost, 1e-7)
            self.assertLess(abs(file["observables/residual/value"][()]).max(), 1e-3 * lost)

    def test_wall_that_is_gone(self):
        go = self.run_deck(GO.replace(WALLS, WALLS.replace("-0.09, ", "-0.19, ")))
        n = int((self.old["b"] == 15).sum())
        self.assertIn(f"{n} of {len(self.old['a'])} contacts are with walls that this deck does not have", "".join(self.warnings))
        self.assertIn('wall 1 "left" of the file', "".join(self.warnings))
        self.assertNotIn(15, contacts(go, 0)["b"])
        self.assertEqual(len(contacts(go, 0)["a"]), len(self.old["a"]) - n)

    def test_walls_in_another_order(self):
        lines = WALLS.split("\n")
        walls = "\n".join([lines[0], lines[3], lines[2], lines[1], lines[4], ""])
        new = contacts(self.run_deck(GO.replace(WALLS, walls)), 0)
        other = {14: 16, 15: 15, 16: 14}
        old = {(a, other.get(b, b)): f for a, b, f in zip(self.old["a"], self.old["b"], self.old["tau"])}
        self.assertEqual(len(new["a"]), len(old))
        for a, b, f in zip(new["a"], new["b"], new["tau"]):
            self.assertAlmostEqual(old[a, b], f, delta=1e-9)

    def test_goes_on_from_what_went_on(self):
        """The walls are where they were, also in the third run, whose deck is that of the first."""
        self.run_deck(GO, name="second")
        third = self.run_deck(GO.replace("heap.h5", "second.h5"))
        self.assertEqual(self.warnings, [])
        self.assert_same_contacts(contacts(third, 0))

    def test_values_of_the_deck(self):
        keys = 'contacts = true; density = 7.14; vx = 0; vy = 0; omega = 0; group = "all";'
        go = self.run_deck(GO.replace("contacts = true;", keys))
        with h5py.File(self.heap) as old, h5py.File(go) as new:
            self.assertTrue(numpy.allclose(2 * old["particles/disks/mass"][()], new["particles/disks/mass"][()]))
            self.assertTrue((new["particles/disks/group"][()] == 0).all())
        for key in 'x = 1;', 'theta = 1;', 'radius = 1;', 'columns = ("x", "y", "radius");':
            self.refuse(GO.replace("contacts = true;", "contacts = true; density = 1; " + key), key.split()[0])

    def test_checkpoint(self):
        """Of a run that is not finished; it has no frames."""
        process = start("run", self.write("long.cfg", HEAP), "--quiet", "-o", self.result, "-D", "checkpoint=0.02",
                        "-D", "phases[0].time=2000")
        wait_for(lambda: self.checkpoints() and self.checkpoints()[0] > 200000 or process.poll() is not None)
        process.send_signal(signal.SIGTERM)
        process.communicate()
        self.assertEqual(process.returncode, 75)
        newest = f"r.h5.parts/checkpoint-{self.checkpoints()[0]}.h5"
        go = self.run_deck(GO.replace("heap.h5", newest), name="go")
        self.assertEqual(self.warnings, [])
        self.assert_same_contacts(contacts(go, 0), 1e-6)
        self.assertLess(kinetic(go).max(), 1e-16)

    def test_interrupted(self):
        deck = self.write("long.cfg", GO + 'motions = ( { name = "shake"; wall = "bottom"; coordinate = "y"; '
                          'type = "harmonic"; amplitude = 1e-4; frequency = 50; } );')
        words = [deck, "--quiet", "-D", "phases[0].steps=25000"]
        self.run_ok("run", *words, "-o", self.folder / "whole.h5")
        self.kill_until_done([*words, "-D", "checkpoint=0.01"], 0.1, 4)
        assert_same(self, self.folder / "whole.h5", self.result)

    def test_another_file(self):
        """A run is not continued with a packing that differs in its contacts only."""
        deck = self.write("long.cfg", GO)
        words = ["run", deck, "--quiet", "-o", self.result, "-D", "phases[0].steps=100000000"]
        process = start(*words, "-D", "checkpoint=0.05")
        wait_for(lambda: self.checkpoints() or process.poll() is not None)
        process.send_signal(signal.SIGTERM)
        process.communicate()
        with changed(self.heap) as file:
            file["state/contact_lambda_ref"][3] += 1e-9
        status, _, err = run(*words)
        self.assertEqual(status, 2)
        self.assertIn("a file that the deck names", err)

    def test_damaged(self):
        for name, value in ("contact_b", 99), ("id", 5):
            copy = self.folder / "broken.h5"
            copy.write_bytes(self.heap.read_bytes())
            with changed(copy) as file:
                file[f"state/{name}"][0] = value
                file[f"state/{name}"][1] = value
            self.refuse(GO.replace("heap.h5", "broken.h5"), "the state in this file is damaged")
        copy.write_bytes(self.heap.read_bytes())
        with changed(copy) as file:
            del file["state/theta"]
        self.refuse(GO.replace("heap.h5", "broken.h5"), "there is no dataset or group /state/theta")
        with changed(copy) as file:
            file["state"].attrs["format"] = 1
        self.refuse(GO.replace("heap.h5", "broken.h5"), "its state has format 1")

    def test_before_slots(self):
        """Contacts of a packing may stand in any order, as they do in results of before."""
        old = self.folder / "old.h5"
        old.write_bytes(self.heap.read_bytes())
        with changed(old) as file:
            file["state"].attrs["format"] = 2
            for name in file["state"]:
                if name.startswith("contact_"):
                    file[f"state/{name}"][:] = file[f"state/{name}"][:][::-1]
            for name, before in (("lambda_ref", "lambda"), ("zeta", "stretch"), ("nonconservative_work", "gain")):
                file.move(f"state/contact_{name}", f"state/contact_{before}")
        new = self.run_deck(GO, name="new")
        again = self.run_deck(GO.replace("heap.h5", "old.h5"), name="again")
        with h5py.File(new) as one, h5py.File(again) as two:
            self.assertEqual(one["state"].attrs["hash"], two["state"].attrs["hash"])

    def test_echo(self):
        """The full deck refers to the file, and is the same run."""
        go = self.run_deck(GO)
        with h5py.File(go) as file:
            text = file["parameters/deck_full"][()].decode()
        again = self.run_deck(text, name="again")
        with h5py.File(go) as one, h5py.File(again) as two:
            self.assertEqual(one["state"].attrs["hash"], two["state"].attrs["hash"])
        plain = self.run_deck(GO.replace("contacts = true", "density = 3.57"), name="plain")
        with h5py.File(plain) as file:
            self.assertIn("disk_rows", file["parameters/deck_full"][()].decode())


class Periodic(Files):
    """A compressed box of disks: edges and contacts come from the file."""
    DECK = """dt = 1e-4; materials = ( { name = "m"; k_n = 100; k_t = 80; gamma_n = 0.4; mu = 0.3; } );
"""

    def test_compressed(self):
        chance = numpy.random.default_rng(3)
        rows = ", ".join("(%.4f, %.4f, %.4f)" % (0.13 + 0.25 * (k % 4) + chance.uniform(-0.01, 0.01),
                                                 -0.37 + 0.25 * (k // 4) + chance.uniform(-0.01, 0.01),
                                                 (0.1, 0.115)[k % 3 == 0]) for k in range(16))
        self.run_deck(self.DECK + 'box = { periodic = "xy"; x = (0, 1); y = (-0.5, 0.5); }; gravity = { g = 0; };' +
                      'disk_rows = ( { columns = ("x", "y", "radius"); density = 1; rows = (' + rows + '); } );'
                      'phases = ( { time = 12; compress = { fraction = 0.9; rate = 0.02; }; }, { time = 20; } );'
                      'output = { contacts = 1000; };', name="jam")
        self.old = contacts(self.folder / "jam.h5", -1)
        self.assertGreater(len(self.old["a"]), 20)
        with h5py.File(self.folder / "jam.h5") as file:
            scale = file["state/box_scale"][()]
        self.assertLess(scale, 0.95)
        go = self.run_deck(self.DECK + 'box = { periodic = "xy"; file = "jam.h5"; };'
                           'disk_files = ( { file = "jam.h5"; contacts = true; } );'
                           'steps = 2000; output = { contacts = 100; };')
        self.assertEqual(self.warnings, [])
        with h5py.File(go) as file:
            self.assertTrue(numpy.allclose(file["particles/disks/box/edges"][()], scale, rtol=1e-15))
            self.assertIn("x = (0.0, ", file["parameters/deck_full"][()].decode())
        Contacts.assert_same_contacts(self, contacts(go, 0))
        Contacts.assert_same_contacts(self, contacts(go, -1), 1e-3)


class Servo(Files):
    """Walls that a servo has moved far from where the deck has them."""

    def test_goes_on_at_the_same_pressure(self):
        walls = """integrator = "verlet"; dt = 2e-3; materials = ( { name = "m"; k_n = 500; gamma_n = 10; } );
container = { type = "box"; width = 14; height = 14; open = false; };
motions = (
  { name = "sides"; wall = ("left", "right"); coordinate = "x"; type = "servo"; pressure = 1; speed = 0.2; },
  { name = "ends"; wall = ("floor", "lid"); coordinate = "y"; type = "servo"; pressure = 1; speed = 0.2; },
  { name = "raise"; wall = "lid"; coordinate = "y"; type = "velocity"; velocity = 0.3; } );
measure = { box = true; stress = true; walls = true; };
"""
        press = """packings = ( { type = "random"; count = 100; radius = 0.5; density = 1; } );
phases = ( { time = 400; motions = ("sides", "ends"); settle = { kinetic = 1e-8; unbalanced = 1e-4; }; } );"""
        self.run_deck(walls + press, name="pressed")
        on = walls + 'disk_files = ( { file = "pressed.h5"; contacts = true; } ); phases = ( %s );'
        with h5py.File(self.run_deck(on % '{ time = 20; motions = ("sides", "ends"); }')) as file:
            values = {name: file[f"observables/{name}/value"][:] for name in ("stress_xx", "stress_yy", "width")}
        self.assertLess(values["width"].max(), 10.5)
        for name in ("stress_xx", "stress_yy"):
            self.assertLess(abs(values[name] - 1).max(), 0.01, name)
        # the region goes with a wall that leaves the container of the deck, too
        with h5py.File(self.run_deck(on % '{ time = 20; motions = ("raise"); }')) as file:
            height, lid = file["observables/height/value"][:], file["observables/wall_force_y/value"][:, 3]
        self.assertLess(abs(height[-1] - height[0] - 6), 1e-6)
        self.assertEqual(lid[-1], 0)


class Gone(Files):
    """Disks that have been taken out are not in the packing, and numbers close up."""

    def test_removed(self):
        deck = (MATERIALS + 'walls = ( { name = "floor"; type = "segment"; points = ( (-0.5, 0), (0.5, 0) ); '
                'material = "steel"; } );'
                'disk_rows = ( { columns = ("x", "y", "radius", "name"); density = 1; material = "grain"; '
                'rows = ( (0, 0.1, 0.1, "a"), (0.9, 0.1, 0.1, "lost"), (0.3, 0.1, 0.1, "b") ); } );'
                'bounds = { y = (-1, 2); outside = "remove"; }; time = 1; output = { contacts = 1000; };')
        old = contacts(self.run_deck(deck, name="a"), -1)
        go = self.run_deck(MATERIALS + 'walls = ( { name = "floor"; type = "segment"; '
                           'points = ( (-0.5, 0), (0.5, 0) ); material = "steel"; } );'
                           'disk_files = ( { file = "a.h5"; contacts = true; } ); steps = 100; '
                           'output = { contacts = 10; }; measure = { rotation = ("a", "b"); };', name="b")
        self.assertEqual(self.warnings, [])
        new = contacts(go, 0)
        self.assertEqual((list(old["a"]), list(new["a"]), list(new["b"])), ([0, 2], [0, 1], [2, 2]))
        self.assertTrue(numpy.allclose(old["force"], new["force"], rtol=1e-12))


if __name__ == "__main__":
    unittest.main(verbosity=2)
