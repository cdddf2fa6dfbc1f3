"""What the tests of pictures and films share: small real runs of every sort."""
import os
import pathlib
import subprocess
import sys

ROOT = pathlib.Path(os.environ.get("SLIPDISK_SOURCE_DIR", pathlib.Path(__file__).resolve().parent.parent))
sys.path.insert(0, str(ROOT / "tools" / "python"))
sys.dont_write_bytecode = True
os.environ.setdefault("SLIPDISK_PROGRAM", str(ROOT / "build/release/slipdisk"))

THREE = ["phases.settle.steps=2e4", "phases.measure.steps=2e5", "phases.measure.frames=2e4", "phases.measure.series=500", "dt=1e-5"]
RUNS = {
    "three": ("three_disk/random.cfg", THREE),
    "two": ("collisions/two_disks.cfg", []),
    "shaken": ("packing/shake_low.cfg", ["phases.rest.time=2", "phases.thermalise.time=0.2", "phases.measure.time=1",
                                         "phases.measure.frames=3000", "phases.measure.contacts=3000"]),
    "pressed": ("packing/jam.cfg", ["packings[0].count=100", "container.width=15.2", "container.height=15.2", "phases[2].time=200",
                                    "phases[3].time=500", "phases[4].time=500", "phases[5].time=500", "phases[6].time=500",
                                    "phases[7].time=500", "output.series=100"]),
    "squeezed": ("packing/servo.cfg", ["container.width=12", "container.height=12", "phases[0].time=20", "phases[1].time=5",
                                       "measure={stress=true; box=true; walls=true;}"]),
    "sheared": ("shear/simple.cfg", ["container.width=9.4", "container.height=9.4", "packings[0].count=64", "phases[0].time=5",
                                     "phases[1].time=10", "measure={stress=true; rotation=();}"]),
    "biaxial": ("shear/biaxial.cfg", ["container.width=10", "container.height=10", "packings[0].count=64", "phases[0].time=20",
                                      "phases[1].time=10"]),
    "cemented": ("bonds/compression.cfg", ["container.width=6", "container.height=12", "packings[0].count=64", "phases.press.time=150",
                                           "phases.free.time=4", "phases.load.time=15", "motions.down.velocity=-2e-3",
                                           "motions.up.velocity=2e-3", "phases.load.frames=500", "phases.load.contacts=500"]),
    "hopper": ("packing/hopper.cfg", ["container.width=12", "container.height=30", "phases[0].time=60", "phases[1].time=20"]),
}
SWEEP = """sweep = { parameters = (
  { path = "motions[*].amplitude"; name = "amplitude"; values = (0.01, 0.04); },
  { path = "gravity.tilt"; name = "tilt"; values = (0, "0.02 pi", "0.04 pi"); } ); replicas = 2; };
"""


# Few disks, all of them watched: their rotation is not what a sweep of a sheared box is about.
SHEAR_SWEEP = ["packings[0].count=16", "container.width=5.3", "container.height=5.3", "phases[0].time=2", "phases[1].time=10",
               "measure={stress=true;}",
               'sweep={parameters=({path="phases[1].cell.rate_xy"; name="rate"; values=(0.2, 0.4);}); replicas=2;}']


def program():
    return os.environ["SLIPDISK_PROGRAM"]


def run(*words):
    done = subprocess.run([program(), *map(str, words)], capture_output=True, text=True, timeout=600)
    if done.returncode not in (0, 5):
        raise RuntimeError(f"{words}: {done.stderr}")


def make(folder, names=tuple(RUNS), sweep=True):
    """Results NAME.h5 of these names, tilted.sweep with tilted.cfg, and sheared.sweep."""
    for name in names:
        deck, overrides = RUNS[name]
        run("run", ROOT / "inputs" / deck, "-o", folder / f"{name}.h5", "--quiet", *(word for one in overrides for word in ("-D", one)))
    if sweep:
        text = (ROOT / "inputs/three_disk/async.cfg").read_text().replace("dt = 1e-6", "dt = 1e-5")
        (folder / "tilted.cfg").write_text(text + SWEEP)
        run("sweep", folder / "tilted.cfg", "-o", folder / "tilted.sweep", "--quiet", "-D", "phases[0].steps=2e4", "-D", "phases[1].steps=2e5")
        run("sweep", ROOT / "inputs/shear/simple.cfg", "-o", folder / "sheared.sweep", "--quiet",
            *(word for one in SHEAR_SWEEP for word in ("-D", one)))
