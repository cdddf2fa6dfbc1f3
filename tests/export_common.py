"""What the tests of slipdisk export share: a run with all that frames can hold."""
import atexit
import functools
import pathlib
import shutil
import tempfile
import unittest

import h5py

from results_common import run

# Periodic in x, fixed and driven disks, two materials and groups, rain, disks that are taken out, all kinds of walls.
RICH = """
title = "all, that frames can hold";
integrator = "verlet";
dt = 1e-4;
seed = 3;
gravity = { g = 10; };
box = { periodic = "x"; x = (-1, 1); };
materials = (
  { name = "grain"; k_n = 1e4; k_t = 5e3; gamma_n = 2; mu = 0.3; },
  { name = "soft, \\"wet\\""; k_n = 5e3; k_t = 1e3; gamma_n = 2; mu = 0.1; }
);
material_pairs = ( { materials = ("grain", "soft, \\"wet\\""); k_n = 5e3; k_t = 1e3; gamma_n = 2; mu = 0.1; } );
disks = (
  { name = "pusher"; x = 0; y = 0.2; radius = 0.1; mass = 1; fixed = true; material = "grain"; },
  { name = "runner"; x = 0.9; y = 0.5; vx = 8; omega = 3; radius = 0.05; mass = 0.1; material = "grain"; },
  { x = 0; y = -0.3; radius = 0.05; mass = 0.1; material = "grain"; },
  { x = -0.5; y = 0.1; radius = 0.1; mass = 1; fixed = true; material = "grain"; group = "feet"; },
  { x = 0.5; y = 0.1; radius = 0.1; mass = 1; fixed = true; material = "grain"; group = "feet"; }
);
packings = (
  { type = "rain"; count = 50; rows = 2; group = "grains"; density = 3; material = "soft, \\"wet\\"";
    sizes = "list"; radii = (0.04, 0.05); x = (-0.9, 0.9); y = (0.8, 1.6); }
);
walls = (
  { name = "floor"; type = "line"; points = ((-1, 0), (1, 0)); material = "grain"; },
  { name = "bar"; type = "segment"; points = ((-0.3, 0.5), (-0.1, 0.6)); pivot = (-0.2, 0.55); material = "grain"; },
  { type = "polyline"; points = ((0.6, 0.3), (0.7, 0.4), (0.8, 0.3)); material = "grain"; },
  { name = "post"; type = "circle"; center = (0.3, 0.4); side = "outside"; radius = 0.07; material = "grain"; }
);
motions = (
  { name = "push"; disk = "pusher"; coordinate = "y"; type = "harmonic"; amplitude = 0.02; frequency = 5; },
  { name = "turn"; wall = "bar"; coordinate = "theta"; type = "velocity"; velocity = 1; }
);
bounds = { x = (-2, 2); y = (-1, 2.5); outside = "remove"; };
phases = ( { name = "all"; time = 0.8; frames = 800; contacts = 1600; } );
output = { series = 100; };
measure = { rotation = [ "runner" ]; walls = true; groups = true; };
"""

SHRINKING = """
integrator = "verlet";
dt = 0.1;
materials = ( { name = "disk"; k_n = 1; gamma_n = 0.1; } );
container = { type = "periodic"; width = 10; height = 12; };
packings = ( { type = "random"; count = 40; density = 1; sizes = "list"; radii = (0.5, 0.7); group = "disks"; } );
phases = ( { name = "compress"; time = 200; frames = 400; relax = true; compress = { fraction = 0.8; rate = 2e-3; }; } );
"""

OPEN = """
dt = 1e-4;
materials = ( { name = "disk"; k_n = 1e4; k_t = 1e4; gamma_n = 1; mu = 0.2; } );
disks = ( { x = 0; y = 0; vx = 1; omega = 2; radius = 0.5; mass = 1; }, { x = 3; y = 1; radius = 0.25; mass = 0.5; } );
phases = ( { name = "fly"; time = 0.2; frames = 500; } );
"""

DECKS = {"rich": RICH, "shrinking": SHRINKING, "open": OPEN}


@functools.cache
def make_results():
    """The folder of the decks and their results; they are run once."""
    folder = pathlib.Path(tempfile.mkdtemp(prefix="slipdisk-export-"))
    atexit.register(shutil.rmtree, folder)
    for name, deck in DECKS.items():
        (folder / f"{name}.cfg").write_text(deck)
        status, _, err = run("run", folder / f"{name}.cfg", "--quiet", "-o", folder / f"{name}.h5")
        assert status == 0, err
    return folder


class Exports(unittest.TestCase):
    """Each test has a folder of its own."""

    def setUp(self):
        self.made = make_results()
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="slipdisk-test-"))

    def tearDown(self):
        shutil.rmtree(self.folder)

    def export(self, deck, form, *more, out="out"):
        """The path of the export."""
        path = self.folder / out
        status, _, err = run("export", self.made / f"{deck}.h5", "--to", form, "-o", path, *more)
        self.assertEqual(status, 0, err)
        return path

    def open(self, deck):
        file = h5py.File(self.made / f"{deck}.h5")
        self.addCleanup(file.close)
        return file


def in_play(file, frame):
    """Numbers of the disks that are there in a frame."""
    disks = file["particles/disks"]
    if "activity" not in disks:
        return list(range(len(disks["radius"])))
    return [k for k, a in enumerate(disks["activity/value"][frame]) if a in (0, 3) or disks["driven"][k]]
