"""messages.md beside this file: each mistake of its tables gets the message that stands there, and no other. After a
message was changed on purpose, `tests/docs/test_mistakes.py --write` writes the tables anew.
"""
import gzip
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import unittest

ROOT = pathlib.Path(os.environ.get("SLIPDISK_SOURCE_DIR", pathlib.Path(__file__).resolve().parents[2]))
PROGRAM = os.environ.get("SLIPDISK_PROGRAM", ROOT / "build/release/slipdisk")
KEPT = ROOT / "tests/docs/messages.md"

DECK = """dt = 1e-5;
time = 2;
gravity = { g = 9.81; tilt = 0; };
materials = (
  { name = "rubber"; k_n = 1e4; k_t = 5e3; gamma_n = 2; mu = 0.5; }
);
disks = (
  { name = "ball"; x = 0; y = 0.1; radius = 0.02; density = 3.57; }
);
walls = (
  { name = "floor"; type = "line"; points = ((-1, 0), (1, 0)); }
);
output = { series = 100; };
"""


def change(mistake, old, new):
    """This in place of that in the deck."""
    assert DECK.count(old) == 1, old
    return mistake, {"d.cfg": DECK.replace(old, new)}, []


def define(setting):
    return f"`-D '{setting}'`", {"d.cfg": DECK}, ["-D", setting]


def constant(setting):
    """A setting of a deck whose ball has a constant as its density."""
    deck = 'constants = { rho = 3.57; };\n' + DECK.replace("density = 3.57", 'density = "rho"')
    return f"`-D '{setting}'`, the deck has `constants.rho`", {"d.cfg": deck}, ["-D", setting]


def table(mistake, content, line='disk_files = ( { file = "d.csv"; density = 1; } );\n', name="d.csv"):
    return mistake, {"d.cfg": DECK + line, name: content if isinstance(content, bytes) else content.encode()}, []


def command(*words, beside=None):
    """A command in an empty folder, or beside a file of this name."""
    return f"`slipdisk {' '.join(words)}`" + (f" beside `{beside}`" if beside else ""), beside, list(words)


def value(key, old, *news):
    return [change(f"`{key} = {new};`", f"{key} = {old}", f"{key} = {new}") for new in news]


def changes(mistake, *pairs, more="", **others):
    """Several changes, more keys, and other files."""
    deck = DECK
    for old, new in pairs:
        assert deck.count(old) == 1, old
        deck = deck.replace(old, new)
    return mistake, {"d.cfg": deck + more, **{name.replace("_", "."): text for name, text in others.items()}}, []


def phase(mistake, keys, *pairs):
    return changes(mistake, ("time = 2;", f'phases = ( {{ name = "p"; time = 2; {keys} }} );'), *pairs)


def cell(mistake, keys, *pairs):
    """A phase of a periodic box with two disks."""
    deck = BOXED.replace("KEYS", keys)
    for old, new in pairs:
        assert deck.count(old) == 1, old
        deck = deck.replace(old, new)
    return mistake, {"d.cfg": deck}, []


BOXED = """integrator = "verlet";
dt = 1e-5;
gravity = { g = 0; };
materials = ( { name = "rubber"; k_n = 1e4; k_t = 5e3; gamma_n = 2; mu = 0.5; } );
box = { x = (0, 1); y = (0, 1); periodic = "xy"; };
disks = (
  { name = "a"; x = 0.1; y = 0.2; radius = 0.02; density = 3.57; },
  { name = "b"; x = 0.4; y = 0.2; radius = 0.02; density = 3.57; }
);
phases = (
  { name = "p"; time = 1; KEYS }
);
walls = ();
"""
SHEAR = "cell = { rate_xy = 0.1; };"
WALL = 'walls = ( { name = "floor"; type = "line"; points = ((-1, 0), (1, 0)); } )'
PULL = 'motions = ( { disk = "a"; coordinate = "x"; type = "velocity"; velocity = 1; } )'
SHAKE = 'motions = ( { name = "s"; wall = "floor"; coordinate = "y"; type = "harmonic"; amplitude = 1e-4; omega = 100; } );\n'
BOX = 'box = { x = (-1, 1); y = (0, 2); periodic = "x"; };\n'
CSV = "x,y,radius\n1,1,0.1\n"
DUMP = ("ITEM: TIMESTEP\n0\nITEM: NUMBER OF ATOMS\n1\nITEM: BOX BOUNDS pp pp pp\n0 4\n0 4\n-0.5 0.5\n"
        "ITEM: ATOMS id type x y radius\n1 1 1 1 0.1\n")
DATA = ("LAMMPS data file\n\n1 atoms\n1 atom types\n0 4 xlo xhi\n0 4 ylo yhi\n-0.5 0.5 zlo zhi\n\nAtoms # sphere\n\n"
        "1 1 0.2 1 1 1 0\n")
MERCURY = "2 0 0 0 4 4\n0.1 0.2 0 0 0.1 0 0 0\n0.5 0.5 0 0 0.1 0 0 0\n"
TABLES = {
    "Brackets, commas, quotes": [
        change("`)` of `materials` is missing", "mu = 0.5; }\n);", "mu = 0.5; }\n;"),
        change("`);` of `materials` is missing", "mu = 0.5; }\n);", "mu = 0.5; }"),
        change("`}` of a material is missing", "mu = 0.5; }", "mu = 0.5;"),
        change("`}` of `gravity` is missing", "tilt = 0; };", "tilt = 0;"),
        change("`}` at the end is missing", "series = 100; };", "series = 100;"),
        change("`}` in place of `)`", "(1, 0)); }\n)", "(1, 0)); }\n}"),
        change("`;` in a list", "(-1, 0), (1, 0)", "(-1, 0); (1, 0)"),
        change("`points = (-1, 0), (1, 0));`", "((-1, 0), (1, 0))", "(-1, 0), (1, 0))"),
        change("`points = ((-1, 0), (1, 0)));`", "((-1, 0), (1, 0))", "((-1, 0), (1, 0)))"),
        change("`points = ((-1 0), (1, 0));`", "(-1, 0)", "(-1 0)"),
        change("`points = [-1, 0, 1, 0];`", "((-1, 0), (1, 0))", "[-1, 0, 1, 0]"),
        change("`,` between disks is missing", "density = 3.57; }",
               "density = 3.57; }\n  { x = 1; y = 0.1; radius = 0.02; density = 1; }"),
        change("`,` behind the last wall", "(1, 0)); }", "(1, 0)); },"),
        change("`time = 2; };`", "time = 2;", "time = 2; };"),
        change("`time = 2;;`", "time = 2;", "time = 2;;"),
        change("`name = \"ball;`", '"ball"', '"ball'),
        change("`name = 'rubber';`", '"rubber"', "'rubber'"),
        change("`name = \u201crubber\u201d;`", '"rubber"', "\u201crubber\u201d"),
        change("`name = rubber;`", '"rubber"', "rubber"),
        change("`name = red rubber;`", '"rubber"', "red rubber"),
        change("`disks ( ...`", "disks = (", "disks ("),
        change("`gravity { ...`", "gravity = {", "gravity {"),
        change("`dt == 1e-5;`", "dt = 1e-5", "dt == 1e-5"),
        change("`\"dt\": 1e-5,`", "dt = 1e-5;", '"dt": 1e-5,'),
        change("`const dt = 1e-5;`", "dt = 1e-5", "const dt = 1e-5"),
        change("`x = ;`", "x = 0;", "x = ;"),
        change("`x = 0; x = 1;`", "x = 0;", "x = 0; x = 1;"),
        change("`/*` without `*/`", "output", "/* output"),
        change("the deck begins with a byte order mark", "dt", "\ufeffdt"),
        change("a no-break space", "dt = 1e-5", "dt =\u00a01e-5"),
        change("`disks = { ... };`", DECK[DECK.index("disks = (") + 8:DECK.index("walls")],
               '{ name = "ball"; x = 0; y = 0.1; radius = 0.02; density = 3.57; };\n'),
    ],
    "Numbers": [
        *value("radius", "0.02", '"1 mm"', "1 mm", "1mm"),
        *value("k_n", "1e4", '"1e4 N/m"', "1e4 N/m", '"1e4 Pa"', '"7 bar"', '"10 rpm"', '"1/s"'),
        *value("dt", "1e-5", '"10 us"', "1e-5f", "1d-5", "1_000", "0,00001", "10^-5"),
        *value("x", "0", "0,5", "\u22121", "-sqrt(3)"),
        *value("radius", "0.02", "2 * 0.01", '"2 * 0.01"', "R", '"2 * R"', '"2 * (0.01"', '"1/0"', '"two"'),
        *value("tilt", "0", "3 deg", "3deg", '"3 degrees"', '"3deg"', '"1/3 pi"'),
        *value("mu", "0.5", "50 %"),
        *value("time", "2", '"2 s"', "inf"),
        change("`steps = 2.5;`", "time = 2;", "steps = 2.5;"),
        change('`steps = "2 / 3e-5";`', "time = 2;", 'steps = "2 / 3e-5";'),
        change('`constants = { R = "R / 2"; };`', "dt", 'constants = { R = "R / 2"; };\ndt'),
        change('`constants = { R = 0.02; }; ... radius = "2 * r";`', "dt = 1e-5;\n" + DECK[11:],
               "constants = { R = 0.02; };\n" + DECK.replace("radius = 0.02", 'radius = "2 * r"')),
        *[define(setting) for setting in ("gravity.tilt=3deg", "gravity.g=0.7*9.81", "disks.ball.radius=1 mm", "dt=", "R=0.03",
                                          "measure.rotation=[ball]", "walls.floor.points=((0,0),(1,0)")],
    ],
    "Keys and names": [
        change("`time = 2; steps = 100;`", "time = 2;", "time = 2; steps = 100;"),
        change("neither `time` nor `steps`", "time = 2;", ""),
        change("`fixed = yes;`", "density", "fixed = yes; density"),
        change("`fixed = 1;`", "density", "fixed = 1; density"),
        change("`gama_n = 2;`", "gamma_n", "gama_n"),
        change("`gravity = 9.81;`", "{ g = 9.81; tilt = 0; }", "9.81"),
        change("`g = (0, -9.81);`", "g = 9.81", "g = (0, -9.81)"),
        change("`density` and `mass`", "density = 3.57", "density = 3.57; mass = 1"),
        change('`material = "ruber";`', "density", 'material = "ruber"; density'),
        change('`rotation = ("wheel");` in `measure`', "output", 'measure = { rotation = ("wheel"); };\noutput'),
        change('`type = "plane";`', '"line"', '"plane"'),
        changes("an arc that runs clockwise", ('type = "line"; points = ((-1, 0), (1, 0));',
                                               'type = "arc"; center = (0, 5); radius = 5; from = "-80 deg"; to = "-100 deg";')),
        changes("an arc in degrees", ('type = "line"; points = ((-1, 0), (1, 0));',
                                      'type = "arc"; center = (0, 5); radius = 5; from = 200; to = 340;')),
        *[change(f"`{keys}` in `materials`", "gamma_n = 2; mu = 0.5;", keys)
          for keys in ("friction = 0.5;", "e = 0.5;", "cor = 0.5;", "young = 1e9;", "damping = 2;", "mu = 0.3; mu_kinetic = 0.5;", "critical_load = 1;",
                       'cohesion = "constant";', 'cohesion = "bridge"; pull_off = 1;')],
        *[change(f"`{keys}` in `materials`", "k_n = 1e4; k_t = 5e3;", keys)
          for keys in ("k_t = 5e3;", "E_star = 1e6;", 'law = "hertz"; E_star = 1e6; k_n = 1e4;', 'law = "hertz"; E_star = 1e6; poisson = 0.3;',
                       'law = "hertz"; k_n = 1e6; tangential = "mindlin"; poisson = 0.3;',
                       'law = "hertz"; E_star = 1e6; k_t = 1e6; tangential = "mindlin"; poisson = 0.3;',
                       'law = "hertz"; E_star = 1e6; tangential = "mindlin"; poisson = 0.6;', 'law = "hertz"; E = 1e9; nu = 0.3;')],
        change("`diameter = 0.04;`", "radius = 0.02;", "diameter = 0.04;"),
        change("`timestep = 1e-5;`", "time = 2;", "time = 2; timestep = 1e-5;"),
        changes("a motion without `type`", ("output", 'motions = ( { wall = "floor"; coordinate = "y"; velocity = 1; } );\noutput')),
        changes("the surface of a disk", ("output", 'motions = ( { disk = "ball"; coordinate = "surface"; type = "velocity"; velocity = 1; } );\noutput')),
        change('`@include "x.inc"`, which is not there', "dt", '@include "x.inc"\ndt'),
        define("gravty.tilt=1"), define("disks.bal.radius=1"), define("gravity.tilt"),
        constant("constants.rh=3"), define("constants.radius=3"), constant("constants.rho=3"),
    ],
    "Names of something else": [
        changes(f"`{keys}`", ("density", 'group = "grains"; density'), more=keys + "\n" + 'clumps = ( { name = "pair"; disk = "ball"; } );\n' *
                ("clump" not in keys) + 'fields = ( { name = "air"; type = "drag"; gamma = 1e-9; } );\n' * ("fields" not in keys))
        for keys in ('motions = ( { disk = "floor"; coordinate = "y"; type = "velocity"; velocity = 1; } );',
                     'motions = ( { wall = "ball"; coordinate = "y"; type = "velocity"; velocity = 1; } );',
                     'motions = ( { clump = "grains"; coordinate = "y"; type = "velocity"; velocity = 1; } );',
                     'forces = ( { disk = "grains"; force = (1, 0); } );', 'forces = ( { group = "ball"; force = (1, 0); } );',
                     'clumps = ( { disk = ("ball", "rubber"); } );', 'measure = { rotation = ("air"); };',
                     'measure = { sliding = ( { disk = "ball"; partners = ("floor", "pair"); } ); };')
    ] + [
        changes('`material = "floor";` of a disk', ("density", 'material = "floor"; density')),
        phase('`motions = ("floor");` in `phases`', 'motions = ("floor");'),
    ],
    "Periodic boxes and clumps": [
        *[cell(mistake, keys, *pairs) for mistake, keys, pairs in (
            ("`cell` and a wall", SHEAR, [("walls = ()", WALL)]),
            ("`cell` and a channel", SHEAR, [("box = { x = (0, 1); y = (0, 1); periodic = \"xy\"; };",
                                             'container = { type = "channel"; width = 1; height = 1; origin = (0.5, 0); };')]),
            ("`cell` and gravity", SHEAR, [("g = 0", "g = 9.81")]),
            ("`cell` and clumps", SHEAR, [("walls = ()", 'clumps = ( { name = "pair"; disk = ("a", "b"); } )')]),
            ("`cell` and `forces`", SHEAR, [("walls = ()", 'forces = ( { disk = "a"; force = (1, 0); } )')]),
            ("`cell` and a motion", SHEAR, [("walls = ()", PULL)]),
            ("`cell` and `relax`", SHEAR + " relax = true;", []),
            ("`cell` and `measure.disks`", SHEAR, [("walls = ()", "measure = { disks = true; }")]),
            ("`rate_xy = 1e4;`", "cell = { rate_xy = 1e4; };", []),
            ("all stresses are 0", "cell = { stress_xx = 0; stress_yy = 0; };", []),
            ("the box becomes too small", "cell = { rate_yy = -3; };", []),
            ("`shear_rate = 1;` in `cell`", "cell = { shear_rate = 1; };", []),
            ("`cell = { };`", "cell = { };", []),
            ("`max_rate` without a stress", "cell = { rate_xy = 0.1; max_rate = 1; };", []),
            ("`stress_yy = -10;` without cohesion", "cell = { stress_yy = -10; };", []),
            ("a line at an angle", "", [("walls = ()", WALL.replace("(1, 0)", "(1, 0.1)"))]),
            ("a line that turns", "", [("walls = ()", WALL + "; " + SHAKE.replace('"y"', '"theta"').rstrip(";\n"))]),
            ("a segment longer than the box", "", [("walls = ()", WALL.replace('"line"', '"segment"'))]),
            ("a segment as long as the box, which turns", "", [("walls = ()", WALL.replace('"line"', '"segment"').replace("-1", "0") + "; " + SHAKE.replace('"y"', '"theta"').rstrip(";\n"))]),
            ("a wall and its image", "", [("walls = ()", 'walls = ( { type = "line"; points = ((0, 0), (0, 1)); }, { name = "end"; type = "line"; points = ((1, 0), (1, 1)); } )')]),
            ("an arc as wide as the box", "", [("walls = ()", 'walls = ( { type = "arc"; center = (0.5, 0.5); radius = 0.49; from = 0.0; to = 3.14; } )')]),
            ("drag in a box that shears", SHEAR, [("walls = ()", 'fields = ( { name = "air"; type = "drag"; gamma = 1; } )')]),
            ("damping in a box that shears", SHEAR, [("walls = ()", 'fields = ( { type = "damping"; alpha = 0.1; } )')]),
            ("attraction farther than half the box", "", [("mu = 0.5;", 'cohesion = "constant"; pull_off = 1; range = 0.5;')]),
            ("a motion of a disk of a clump", "", [("walls = ()", PULL + '; clumps = ( { disk = ("a", "b"); } )')]),
        )],
        changes("`container.width = 0.05;`", ('walls = (\n  { name = "floor"; type = "line"; points = ((-1, 0), (1, 0)); }\n);',
                                              'container = { type = "bed"; width = 0.05; height = 1; radius = 0.02; };')),
    ],
    "CSV files": [
        table("`1,1,0.1` in the first line", "1,1,0.1\n2,1,0.1\n"),
        table("`X,Y,R`", "X,Y,R\n1,1,0.1\n"),
        table("`id,pos_x,pos_y,diameter`", "id,pos_x,pos_y,diameter\n1,1,1,0.1\n"),
        table("`PosX,PosY,Rho,Index`", "PosX,PosY,Rho,Index\n1,1,1,1\n"),
        table("`Points:0,Points:1,D`", "Points:0,Points:1,D\n1,1,0.1\n"),
        table("`x,y,radius,id`", "x,y,radius,id\n1,1,0.1,1\n"),
        table("`x,y,radius,`", "x,y,radius,\n1,1,0.1,\n"),
        table('`"x","y","radius"` and `"1","1","0.1"`', '"x","y","radius"\n"1","1","0.1"\n'),
        table('`"x,y,radius`', '"x,y,radius\n1,1,0.1\n'),
        table("`x;y;radius` and `1;1;0.1`", CSV.replace(",", ";")),
        table("`x;y;radius` and `1,0;1,0;0,1`", "x;y;radius\n1,0;1,0;0,1\n"),
        table("tabs between values", CSV.replace(",", "\t")),
        table("`x y radius`", CSV.replace(",", " ")),
        table("a byte order mark", b"\xef\xbb\xbf" + CSV.encode()),
        table("UTF-16", b"\xff\xfe" + CSV.encode("utf-16-le")),
        table("lines end with CR", CSV.replace("\n", "\r")),
        table("compressed with gzip", gzip.compress(CSV.encode(), mtime=0)),
        table("a spreadsheet", b"PK\x03\x04\x14\x00\x06\x00rest"),
        table("an HDF5 file", b"\x89HDF\r\n\x1a\n\0\0\0\0"),
        table("a line of names and no rows", "x,y,radius\n"),
        table("empty", ""),
        table("`1,1,2*0.1`", "x,y,radius\n1,1,2*0.1\n"),
        table("`1,1,abc`", "x,y,radius\n1,1,abc\n"),
        table("`1,1`", "x,y,radius\n1,1\n"),
        *[table(f"{what} called {name}", text, f'disk_files = ( {{ file = "{name}"; density = 1; }} );\n', name)
          for what, text in (("a CSV file", CSV), ("a LAMMPS dump", DUMP), ("a LAMMPS data file", DATA), ("data of MercuryDPM", MERCURY))
          for name in ("d.csv", "d.txt", "d.data", "d.dump", "d.xyz")
          if not (what.startswith("a LAMMPS") and name in ("d.data", "d.dump")) and not (text == CSV and name in ("d.csv", "d.txt", "d.xyz"))],
        table('a CSV file called d.data, `format = "lammps"`', CSV, 'disk_files = ( { file = "d.data"; format = "lammps"; density = 1; } );\n', "d.data"),
        table("a CSV file called d.h5", CSV, 'disk_files = ( { file = "d.h5"; density = 1; } );\n', "d.h5"),
    ],
    "Set-ups that are seldom meant": [
        change("`mu` without `k_t`", " k_t = 5e3;", ""),
        change("`k_t` without `mu`", " mu = 0.5;", ""),
        change("`k_r` without `mu_r`", "mu = 0.5;", "mu = 0.5; k_r = 1e3;"),
        changes("`k_r` of a pair without `mu_r`", ("mu = 0.5; }\n);", "mu = 0.5; },\n  { name = \"steel\"; k_n = 1e4; }\n);\n"
                                                   'material_pairs = ( { materials = ("rubber", "steel"); k_n = 1e4; k_r = 1e3; } );'),
                ("density", 'material = "rubber"; density'), ('"floor";', '"floor"; material = "steel";')),
        change('`tangential = "mindlin"` without `k_t`', "k_t = 5e3; gamma_n = 2; mu = 0.5;", 'gamma_n = 2; tangential = "mindlin";'),
        change('`E_star = 1e6; tangential = "mindlin";` without `poisson`', "k_n = 1e4; k_t = 5e3; gamma_n = 2; mu = 0.5;",
               'law = "hertz"; E_star = 1e6; tangential = "mindlin"; mu = 0.5;'),
        change("`poisson` without `mu`", "k_n = 1e4; k_t = 5e3; gamma_n = 2; mu = 0.5;",
               'law = "hertz"; E_star = 1e6; tangential = "mindlin"; poisson = 0.3; gamma_n = 0.1;'),
        define("dt=1e-4"), define("dt=5e-4"),
        change("`gamma_n = 20;`, which bounds dt", "gamma_n = 2", "gamma_n = 20"),
        change("`gamma_n = 60;`, which bounds dt", "gamma_n = 2", "gamma_n = 60"),
        change("the ball sits in the floor", "y = 0.1;", "y = 0.0187;"),
        phase('`relax = true;` with `integrator = "gear5";`', "relax = true;"),
        phase("`settle` and nothing loses energy", "settle = { kinetic = 1e-9; };", ("gamma_n = 2; mu = 0.5;", ""), ("k_t = 5e3; ", "")),
        changes("`settle` and the floor is shaken", ("time = 2;", "phases = ( { time = 2; settle = { kinetic = 1e-9; }; } );"), more=SHAKE),
        phase("`settle = { unbalanced = 1e-16; };`", "settle = { unbalanced = 1e-16; };"),
        changes("`compress` without `settle`", ("time = 2;", 'phases = ( { name = "p"; time = 2; compress = { fraction = 1e-3; rate = 10; }; } );'),
                more=BOX),
        change("`measure.configurations` alone", "time = 2;", "time = 2; measure = { configurations = true; };"),
        changes("a watched wall far away", ('(1, 0)); }', '(1, 0)); },\n  { name = "lid"; type = "line"; points = ((-1, 1), (1, 1)); }'),
                ("y = 0.1;", "y = 0.02;"), more='measure = { sliding = ( { disk = "ball"; partners = ("floor", "lid"); } ); };\n'),
        changes("two segments end to end, one of which moves",
                ('(1, 0)); }', '(1, 0)); },\n  { name = "left"; type = "segment"; points = ((-1, 0.05), (0, 0.05)); },\n'
                 '  { name = "right"; type = "segment"; points = ((0, 0.05), (1, 0.05)); }'),
                more='motions = ( { wall = "left"; coordinate = "y"; type = "velocity"; velocity = 0.1; } );\n'),
        changes("a post under the floor", ('(1, 0)); }', '(1, 0)); },\n  { name = "post"; type = "segment"; points = ((0, 0), (0, -1)); }')),
        changes("a packing that is not there", more='disk_files = ( { file = "rain.h5"; } );\n', rain_cfg=DECK),
    ],
    "The command line": [
        command("rum", "d.cfg"), command("run"), command("run", "a.cfg", "b.cfg"), command("run", "nowhere.cfg"),
        command("run", "d.cfg", "--treads", "4"), command("run", "d.cfg", "-x"), command("run", "d.cfg", "-o"),
        command("run", "d.cfg", "--threads", "many"), command("run", "d.cfg", "--quiet=1"), command("--quiet", "run", "d.cfg"),
        command("run", "d.cfg", "-o", "-"), command("info", "-"), command("measure", "x.h5"),
        command("run", "d.cfg", "-np", "4"), command("run", "d.cgf", beside="d.cfg"), command("info", "d.g5", beside="d.h5"),
        command("verify", "d.g5", beside="d.h5"), command("view", "d.cfg", "-o", "d.png"), command("view", "d.cfg", "-o", "d.mp4"),
        command("export", "x.h5", "--to", "ovito"), command("export", "x.h5", "--to", "vkt"), command("plot", "x.h5", "--color", "omga"),
    ],
}

HEAD = """# Messages

Each row is a mistake in a deck, a file or a command, and the message that the program gives for it; test_mistakes.py compares
them, and writes this file with --write. Messages begin with `error:` (left out here) or `warning:`.

A value with a unit behind it (`"1 mm"`, `1e4 N/m`, `1e-5f`) gets this message, cut to "..." in the tables:

> d.cfg:8: disks[0].radius = "1 mm": "mm": UNITS
"""
UNITS = "units are not written, any consistent set will do; expected the bare number (a product needs &#42;)"


def said(program, files, arguments):
    """The errors of a command, or its warnings, or that there are none."""
    with tempfile.TemporaryDirectory() as folder:
        deck = isinstance(files, dict)
        for name, content in (files if deck else {files: DECK} if files else {}).items():
            (pathlib.Path(folder) / name).write_bytes(content.encode() if isinstance(content, str) else content)
        words = ["check", "d.cfg", "--brief", "--no-probe", *arguments] if deck else arguments
        ran = subprocess.run([str(program), *words], cwd=folder, stdin=subprocess.DEVNULL, capture_output=True, text=True,
                             errors="replace", check=False)
    if ran.returncode == 0:
        return ran.stderr.splitlines() or ["accepted"]
    assert ran.returncode == 2, (words, ran.returncode, ran.stderr)
    return [re.sub(r"^error: ", "", line) for line in ran.stderr.splitlines() if not line.startswith("warning: ")]


def shown_cell(lines):
    return "<br>".join(line.replace("&", "&amp;").replace("<", "&lt;").replace("|", "&#124;").replace("*", "&#42;")
                       for line in lines)


def shown(lines):
    return shown_cell(lines).replace(UNITS, "...")


def rows():
    """{mistake: message} of the tables."""
    found = {}
    for line in KEPT.read_text().splitlines():
        parts = line.split(" | ")
        if line.startswith("| ") and len(parts) == 2:
            found[parts[0][2:].replace("&#42;", "*")] = parts[1].removesuffix(" |")
    return found


def write():
    text = HEAD.replace("UNITS", UNITS)
    for title, mistakes in TABLES.items():
        text += f"\n## {title}\n\n| mistake | message |\n|---|---|\n"
        for mistake, files, arguments in mistakes:
            text += f"| {mistake} | {shown(said(PROGRAM, files, arguments))} |\n"
    KEPT.write_text(text)


class Mistakes(unittest.TestCase):
    def test_messages(self):
        there = rows()
        names = [mistake for mistakes in TABLES.values() for mistake, _, _ in mistakes]
        self.assertEqual(len(set(names)), len(names))
        self.assertGreater(len(names), 130)
        self.assertEqual(sorted(set(there) - {"mistake"}), sorted(names), "tests/docs/test_mistakes.py --write")
        for mistakes in TABLES.values():
            for mistake, files, arguments in mistakes:
                with self.subTest(mistake):
                    self.assertEqual(shown(said(PROGRAM, files, arguments)), there[mistake])

    def test_units(self):
        """The file has the message that its tables cut short."""
        deck = DECK.replace("radius = 0.02", 'radius = "1 mm"')
        self.assertIn(f"> {shown_cell(said(PROGRAM, {'d.cfg': deck}, []))}\n", KEPT.read_text())

    def test_deck(self):
        """Without a mistake it is right."""
        self.assertEqual(said(PROGRAM, {"d.cfg": DECK}, []), ["accepted"])


if __name__ == "__main__":
    if "--write" in sys.argv:
        write()
    else:
        unittest.main()
