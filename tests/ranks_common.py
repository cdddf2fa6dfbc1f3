"""What the tests of runs over several MPI ranks share: decks, and running them on so many ranks and threads."""
import os
import pathlib
import subprocess

from results_common import LONG, PROGRAM, assert_same, results  # noqa: F401

MPIEXEC = os.environ["SLIPDISK_MPIEXEC"].split()
SHIM = pathlib.Path(os.environ["SLIPDISK_BUILD_DIR"]) / "tests/calls.so"

GRAIN = """materials = ( { name = "grain"; k_n = 1e4; k_t = 5e3; gamma_n = 2; mu = 0.4; } );"""
LATTICE = """packings = ( { type = "square"; jitter = 0.5; count = %d; x = [ %s ]; y = [ %s ]; group = "grains"; density = 1.27;
                sizes = "uniform"; lower = 0.4; upper = 0.5; } );"""

# A column falls apart on a shaken floor: contacts slide while their disks change ranks, and shares of work change.
COLLAPSE = f"""
title = "collapse"; integrator = "verlet"; dt = 1e-3; gravity = {{ g = 1; }};
{GRAIN}
container = {{ type = "box"; width = 40; height = 30; }};
{LATTICE % (240, "-20, -10", "0.5, 30")}
motions = ( {{ name = "shake"; wall = "floor"; coordinate = "y"; type = "harmonic"; acceleration = 1; frequency = 2; ramp = 1; }} );
phases = ( {{ name = "fall"; steps = 2000; series = 200; frames = 500; }},
           {{ name = "spread"; steps = 2000; series = 200; frames = 1000; contacts = 500; measure = true; }} );
measure = {{ disks = true; walls = true; }};
"""

# Gear, a periodic channel with a rough floor that moves at random: all disks wrap, also across ranks.
CHANNEL = f"""
title = "channel"; integrator = "gear5"; dt = 5e-4; gravity = {{ g = 1; tilt = "0.15 pi"; }}; seed = 5;
{GRAIN}
box = {{ x = [ 0, 20 ]; periodic = "x"; }};
disk_rows = ( {{ columns = ("x", "y", "radius"); density = 1.27; fixed = true; group = "floor"; rows = (
    (1, 0, 1), (3, 0, 1), (5, 0, 1), (7, 0, 1), (9, 0, 1), (11, 0, 1), (13, 0, 1), (15, 0, 1), (17, 0, 1), (19, 0, 1)); }} );
{LATTICE % (180, "0, 20", "1.2, 40")}
motions = ( {{ name = "noise"; group = "floor"; coordinate = ("x", "theta"); type = "random"; amplitude = 0.02; frequency = 3; ramp = 0.1; }} );
phases = ( {{ steps = 3000; series = 300; frames = 1000; contacts = 1000; measure = true; }} );
measure = {{ disks = true; }};
"""

# So few disks in the channel that ranks have none, and get some.
FEW = CHANNEL.replace("count = 180;", "count = 7;").replace("steps = 3000;", "steps = 8000;").replace("disks = true;", "disks = true; rotation = (); sliding = ();")

# Every law that contacts have, in a turning drum.
LAWS = f"""
title = "laws"; integrator = "verlet"; dt = 5e-4; gravity = {{ g = 1; }};
materials = ( {{ name = "grain"; law = "hertz"; k_n = 2e4; restitution = 0.5; limit_damping = false; tangential = "mindlin";
                k_t = 2e4; gamma_t = 1; mu = 0.5; mu_kinetic = 0.4; k_r = 1e3; mu_r = 0.1; gamma_r = 0.5;
                cohesion = "bridge"; pull_off = 1; range = 0.02; rupture = 0.1; }} );
walls = ( {{ name = "drum"; type = "circle"; center = (0, 0); radius = 9; side = "inside"; material = "grain"; }} );
{LATTICE % (120, "-5, 5", "-6, 6")}
motions = ( {{ name = "turn"; wall = "drum"; coordinate = "theta"; type = "velocity"; velocity = 0.5; ramp = 0.5; }} );
phases = ( {{ steps = 3000; series = 300; frames = 1000; contacts = 1000; }} );
"""

# A lid that a load presses on, sides that servos move, until the packing has settled.
PRESSED = f"""
title = "pressed"; integrator = "verlet"; dt = 1e-3;
{GRAIN}
container = {{ type = "box"; width = 16; height = 16; open = false; }};
{LATTICE % (150, "-7.4, 7.4", "0.6, 15.4")}
motions = ( {{ name = "press"; wall = "lid"; coordinate = "y"; type = "load"; mass = 5; force = -40; }},
            {{ name = "sides"; wall = ("left", "right"); coordinate = "x"; type = "servo"; pressure = 3; speed = 0.5; }} );
phases = ( {{ name = "press"; steps = 12000; motions = ("press", "sides"); series = 500;
              settle = {{ kinetic = 1e-2; unbalanced = 5e-2; }}; }},
           {{ name = "hold"; steps = 2000; motions = ("press", "sides"); frames = 1000; }} );
"""

# A lid that falls faster than short lists bear.
SLAM = PRESSED.replace("dt = 1e-3;", "dt = 1e-3; skin = 0.02; limits = { displacement = 0; };").replace("mass = 5; force = -40;", "mass = 1; force = -200;")

# A disk apart from a heap goes beyond all numbers in one step.
LOST = COLLAPSE.replace("phases = (", """disks = ( { name = "lost"; x = 15; y = 25; radius = 0.5; density = 1.27; } );
fields = ( { name = "hole"; type = "central"; disk = "lost"; centre = (15, 20); strength = 1e100; power = 8; } );
phases = ( { name = "calm"; steps = 300; fields = (); },""")

# Two rains at once on a shaken floor, so many disks that a phase puts them in order.
SHOWERS = f"""
title = "showers"; integrator = "verlet"; dt = 2e-4; gravity = {{ g = 1; }}; seed = 3;
{GRAIN}
container = {{ type = "box"; width = 40; height = 60; }};
packings = ( {{ type = "rain"; count = 900; rows = 3; interval = 0.02; speed = 3; sizes = "uniform"; lower = 0.1; upper = 0.2; density = 1; }},
             {{ type = "rain"; count = 300; rows = 2; interval = 0.03; x = (-10, 10); speed = 1; radius = 0.12; density = 1; }} );
motions = ( {{ name = "shake"; wall = "floor"; coordinate = "y"; type = "harmonic"; amplitude = 0.1; frequency = 1; }} );
phases = ( {{ name = "still"; steps = 450; series = 50; frames = 150; contacts = 150; motions = (); }},
           {{ name = "shake"; steps = 600; series = 50; frames = 300; }} );
"""

# A batch falls in the last step of a phase: before one that relaxes, and where a disk is beyond the bounds just then.
LAST_DROP = f"""
title = "last drop"; integrator = "verlet"; dt = 1e-3; gravity = {{ g = 1; }};
{GRAIN}
container = {{ type = "box"; width = 10; height = 30; }};
packings = ( {{ type = "rain"; count = 80; rows = 1; interval = 0.1; speed = 5; gap = 1; density = 1.27; sizes = "uniform"; lower = 0.4; upper = 0.6; }} );
phases = ( {{ steps = 300; frames = 100; series = 50; }}, {{ name = "relax"; steps = 500; relax = true; series = 50; }} );
"""
LOST_DROP = f"""
title = "lost drop"; integrator = "verlet"; dt = 1e-3; gravity = {{ g = 1; }};
{GRAIN}
packings = ( {{ type = "rain"; count = 80; rows = 1; interval = 0.1; speed = 5; gap = 1; x = (-4, 4); y = (0.5, 10); density = 1.27;
                sizes = "uniform"; lower = 0.4; upper = 0.6; }} );
bounds = {{ y = (0.9, 1000); outside = "remove"; }};
phases = ( {{ steps = 200; frames = 100; series = 50; }}, {{ steps = 300; frames = 100; series = 50; }} );
"""

# All that a series can sum up, in many rows: two materials, groups that are mixed, a lid within the region.
MIXTURE = """
materials = ( { name = "hard"; k_n = 1e4; k_t = 5e3; gamma_n = 0.5; mu = 0.4; }, { name = "soft"; k_n = 6e3; k_t = 2e3; gamma_n = 0.5; mu = 0.2; } );
material_pairs = ( { materials = ("hard", "soft"); k_n = 8e3; k_t = 3e3; gamma_n = 0.5; mu = 0.3; } );
packings = ( { type = "square"; jitter = 0.5; count = 90; x = [ %s ]; y = [ %s ]; group = "red"; density = 1.27; material = "hard";
                sizes = "uniform"; lower = 0.4; upper = 0.5; },
             { type = "square"; jitter = 0.5; count = 70; x = [ %s ]; y = [ %s ]; group = "blue"; density = 2; material = "soft";
                sizes = "uniform"; lower = 0.3; upper = 0.5; } );
"""
# Packings in tiles, of which ranks make their own: a front around a disk at the edge of a periodic box; a lattice across a tall box, whose
# disks have sizes of two levels.
TILES = f"""
title = "tiles"; integrator = "gear5"; dt = 2e-4; gravity = {{ g = 1; tilt = 0.1; }}; seed = 7; checkpoint = 1e6;
{GRAIN}
box = {{ x = (-30, 30); periodic = "x"; }};
walls = ( {{ name = "floor"; type = "segment"; points = ((-30, 0), (30, 0)); }} );
disks = ( {{ name = "big"; x = 29; y = 12; radius = 2; density = 1.27; fixed = true; }}, {{ x = 0; y = 60; radius = 1; density = 1.27; }} );
packings = ( {{ type = "front"; count = 8003; tiles = 7; y = (0.1, 50); sizes = "list"; radii = (0.2, 0.28); density = 1.27; group = "grains"; }} );
motions = ( {{ wall = "floor"; coordinate = "y"; type = "harmonic"; amplitude = 0.05; frequency = 5; }} );
phases = ( {{ name = "fall"; steps = 300; series = 50; frames = 100; contacts = 150; }},
           {{ name = "more"; measure = true; steps = 300; series = 50; frames = 300; }} );
measure = {{ disks = true; groups = true; walls = true; }};
"""
LEVELS = f"""
title = "levels"; integrator = "verlet"; dt = 2e-4; gravity = {{ g = 1; }}; checkpoint = 1e6;
{GRAIN}
container = {{ type = "box"; width = 40; height = 400; }};
packings = ( {{ type = "triangular"; count = 6000; tiles = 5; spacing = 1.02; jitter = 1; sizes = "powerlaw"; exponent = 2; lower = 0.05;
                upper = 0.5; density = 1.27; }} );
phases = ( {{ steps = 400; series = 100; frames = 200; contacts = 200; }} );
"""

# Rain whose disks ranks make; some fall at the end of the first phase, and in a front around it others do, for which there are tiles, too.
DROPS = SHOWERS.replace('type = "rain"; count = 300;', 'type = "rain"; count = 4100; tiles = 3; group = "drops"; sizes = "list"; radii = (0.1, 0.13);').replace(
    "radius = 0.12; ", "") + "measure = { groups = true; };\n"
LOST_DROPS = LOST_DROP.replace("count = 80;", "count = 3100; tiles = 3;").replace("rows = 1;", "rows = 2;")
FRONT_IN_RAIN = TILES.replace("packings = (", 'packings = ( { type = "rain"; count = 400; rows = 2; y = (55, 80); interval = 0.01; speed = 2; radius = 0.3; density = 1.27; },')

# A bed of disks that stick slides over the bounds, now and again several at once, some of which touch.
SLIDE = """
title = "slide"; integrator = "gear5"; dt = 2e-4; gravity = { g = 5; tilt = 0.9; };
materials = ( { name = "grain"; k_n = 1e4; k_t = 5e3; gamma_n = 2; mu = 0.3; gamma_t = 1; k_r = 100; mu_r = 0.05; cohesion = "bridge"; pull_off = 2; range = 0.02;
                rupture = 0.05; } );
walls = ( { name = "floor"; type = "line"; points = ((0, 0), (1, 0)); } );
packings = ( { type = "front"; count = 3000; x = (-20, 20); y = (0.05, 60); sizes = "uniform"; lower = 0.2; upper = 0.28; density = 1.27; group = "all"; } );
bounds = { x = (-20.1, 1000); outside = "remove"; };
measure = { walls = true; groups = true; stress = true; };
phases = ( { name = "slide"; steps = 2400; series = 64; frames = 1024; contacts = 1024; }, { name = "more"; steps = 800; series = 50; frames = 400; contacts = 512; } );
"""
LEAVE = SLIDE.replace("remove", "report")

# The last disks of a file that is large enough to be read in parts: a result with groups and materials that are mixed, and its columns.
PREPARED = f"""
title = "prepared"; integrator = "verlet"; dt = 5e-4; gravity = {{ g = 1; }};
{MIXTURE.replace("count = 90", "count = 12000").replace("count = 70", "count = 9000") % ("0, 200", "0.6, 110", "0, 200", "110, 200")}
box = {{ x = (0, 200); periodic = "x"; }};
walls = ( {{ name = "floor"; type = "line"; points = ((0, 0), (1, 0)); material = "soft"; }} );
phases = ( {{ steps = 50; }} );
"""
FILE = PREPARED.replace("packings", "other").split("other")[0] + """
box = { x = (0, 200); periodic = "x"; };
walls = ( { name = "floor"; type = "line"; points = ((0, 0), (1, 0)); material = "soft"; } );
disks = ( { name = "ball"; x = 100; y = 210; vy = -5; radius = 4; density = 2; material = "hard"; group = "balls"; } );
disk_files = ( { file = "prepared.h5"; } );
motions = ( { wall = "floor"; coordinate = "y"; type = "harmonic"; amplitude = 0.1; frequency = 5; } );
phases = ( { name = "shake"; steps = 200; series = 50; frames = 100; contacts = 100; }, { steps = 100; series = 50; } );
measure = { groups = true; walls = true; };
"""
COLUMNS = FILE.replace("box = { x = (0, 200); peri", 'box = { file = "prepared.h5"; peri').replace(
    'file = "prepared.h5"; }', 'file = "prepared.h5"; columns = ("x", "y", "vx", "radius"); dataset = "/particles/disks"; '
    'density = 2; omega = 1; material = "soft"; group = "all"; }')

# A bed that a fluid spins, on walls that move, turn and run; and a run that goes on with it and its contacts. Some are with a wall that is gone,
# some are bridges that are longer than those of the new liquid.
WET = 'law = "hertz"; restitution = 0.5; limit_damping = false; tangential = "mindlin"; k_t = 1e4; gamma_t = 1; mu = 0.5; mu_kinetic = 0.4; k_r = 1e3; ' \
    'mu_r = 0.1; gamma_r = 0.5; cohesion = "bridge"; pull_off = 1; range = 0.02; rupture = 0.1;'
BED = f"""
title = "bed"; integrator = "verlet"; dt = 5e-4; gravity = {{ g = 20; }};
materials = ( {{ name = "hard"; k_n = 2e4; {WET} }}, {{ name = "soft"; k_n = 1e4; {WET} }} );
material_pairs = ( {{ materials = ("hard", "soft"); k_n = 15e3; {WET} }} );
box = {{ x = (0, 200); periodic = "x"; }};
walls = ( {{ name = "post"; type = "segment"; points = ((150, 0), (150, 20)); material = "hard"; }},
          {{ name = "floor"; type = "line"; points = ((0, 0), (1, 0)); material = "soft"; }},
          {{ name = "wheel"; type = "circle"; center = (100, 40); radius = 12; side = "outside"; material = "hard"; }},
          {{ name = "beam"; type = "polyline"; points = ((20, 20), (40, 25), (60, 20)); material = "soft"; }} );
packings = ( {{ type = "front"; count = 12000; y = (0, 95); material = "hard"; group = "red"; sizes = "uniform"; lower = 0.4; upper = 0.5; density = 1.27; }},
             {{ type = "front"; count = 9000; y = (95, 200); material = "soft"; group = "blue"; sizes = "uniform"; lower = 0.3; upper = 0.5; density = 2; }} );
motions = ( {{ wall = "wheel"; coordinate = "theta"; type = "velocity"; velocity = 30; }},
            {{ wall = "beam"; coordinate = "surface"; type = "velocity"; velocity = 3; }},
            {{ wall = "floor"; coordinate = "y"; type = "harmonic"; amplitude = 0.1; frequency = 5; }} );
fields = ( {{ type = "drag"; gamma = 1e-9; gamma_rotation = 2; shear_rate = 160; centre = (0, 0); }} );
phases = ( {{ steps = 200; }} );
"""
KNOWN = "\n".join(line for line in BED.replace("rupture = 0.1", "rupture = 0.05").splitlines() if "post" not in line and "surface" not in line).replace("          { name = \"floor\"", "walls = ( { name = \"floor\"")
KNOWN = KNOWN.split("packings")[0] + """
disks = ( { name = "ball"; x = 100; y = 210; vy = -5; radius = 4; density = 2; material = "hard"; group = "balls"; } );
disk_files = ( { file = "bed.h5"; contacts = true; } );
motions""" + KNOWN.split("motions")[1].split("fields")[0] + """
phases = ( { name = "shake"; steps = 100; series = 50; frames = 50; contacts = 50; }, { steps = 100; series = 50; } );
measure = { groups = true; walls = true; };
"""
# With the laws of the bed its last forces hold at step 0.
CARRIED = KNOWN.replace("rupture = 0.05", "rupture = 0.1")
# In a longer box those at its ends lose their partners.
WIDER = KNOWN.replace("x = (0, 200)", "x = (0, 201)")

DECKS = {"bed": BED, "known": KNOWN, "carried": CARRIED, "wider": WIDER, "slide": SLIDE, "leave": LEAVE, "drops": DROPS, "lost drops": LOST_DROPS, "front in rain": FRONT_IN_RAIN, "prepared": PREPARED, "file": FILE, "columns": COLUMNS, "collapse": COLLAPSE, "channel": CHANNEL, "few": FEW, "laws": LAWS, "pressed": PRESSED, "slam": SLAM, "lost": LOST, 
         "tiles": TILES, "showers": SHOWERS, "last drop": LAST_DROP, "lost drop": LOST_DROP, "levels": LEVELS}


def some(all_numbers, few):
    """Of ranks or seeds: all of them with SLIPDISK_FULL=1, else so few that each number comes up in some deck."""
    return all_numbers if os.environ.get("SLIPDISK_FULL") else few


def ranks_of(launcher):
    """rank -> process id, of those that are there."""
    found = {}
    for process in pathlib.Path("/proc").glob("[0-9]*"):
        try:
            words = (process / "stat").read_text().rpartition(")")[2].split()
            if int(words[1]) != launcher or words[0] == "Z":
                continue
            for item in (process / "environ").read_bytes().split(b"\0"):
                if item.startswith(b"OMPI_COMM_WORLD_RANK="):
                    found[int(item.partition(b"=")[2])] = int(process.name)
        except OSError:  # gone meanwhile
            continue
    return found


def start(ranks, *words, threads=1, environment=(), **more):
    """`slipdisk WORDS` over so many ranks, with more variables (NAME=VALUE) in their environment; ranks 0: without mpirun."""
    launch = [*MPIEXEC, "-n", str(ranks)] if ranks else []
    return subprocess.Popen([*launch, "env", f"OMP_NUM_THREADS={threads}", *environment, PROGRAM, *map(str, words)],
                            stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, **more)


def run(ranks, *words, threads=1, **more):
    """(exit status, standard output, standard error)"""
    process = start(ranks, *words, threads=threads, **more)
    out, err = process.communicate(timeout=LONG)
    return process.returncode, out, err
