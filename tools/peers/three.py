"""One disk on two supports that shake to and fro along x: inputs/three_disk/sync.cfg with another motion, since LAMMPS
and LIGGGHTS cannot let a support turn to and fro, only shake.

slipdisk runs it alone and as points of a sweep, which go side by side in the lanes of vectors."""
import glob
import math
import os

import numpy as np
from slipdisk import sealed

from . import frames, inputs, programs, timing

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
DECK = os.path.join(ROOT, "inputs", "three_disk", "sync.cfg")
# As in the deck; a test of agreement fails if the deck changes and these do not.
LAW = inputs.Law(k_n=1e3, k_t=1e6, gamma_n=10, mu=0.1)
G, TILT, MASS, DT = 10, 0.04 * math.pi, 0.1, 1e-6
AMPLITUDE, SHAKES = 1e-3, 0.1   # of the supports, and their period
PLACES = ((0, 0), (-1, -1.7320508075688772), (1, -1.7320508075688772))
STEPS, WARM, CHECK, POINTS = 2_000_000, 1000, 100_000, 16
FRAMES = 200


def keys(warm, steps, every=0):
    # a support swings away at first: in a short run its contact is open all the time
    return {"integrator": "verlet", "limits.open": 0, "motions.turn.type": "harmonic", "motions.turn.coordinate": "x",
            "motions.turn.amplitude": AMPLITUDE, "phases.rest.steps": warm, "phases.rest.motions": '("turn")',
            "phases.measure.steps": steps, "phases.measure.series": 0, "phases.measure.frames": every}


def write_data(path, spheres):
    density = MASS / (4 / 3 * math.pi if spheres else math.pi)
    with open(path, "w") as file:
        file.write("three disks\n\n3 atoms\n1 atom types\n\n-4 4 xlo xhi\n-4 4 ylo yhi\n-1 1 zlo zhi\n\nAtoms\n\n"
                   + "".join(f"{k + 1} 1 2.0 {density!r} {x!r} {y!r} 0\n" for k, (x, y) in enumerate(PLACES)))


def script(style, data, steps, dumps=None):
    """style: granular or hooke of LAMMPS, or liggghts."""
    if style == "liggghts":
        pair, move, head = inputs.liggghts_law(LAW)[0], "nve/sphere", inputs.liggghts_style("f")
    else:
        # Supports are disks of the same mass to LAMMPS: its effective mass is that of two such disks.
        pair, move, head = inputs.lammps_law(style, LAW, MASS)[0], "nve/sphere disc", inputs.lammps_style("f")
    return (head + f"read_data {data}\n" + inputs.lists(0.2, DT) + "group upper id 1\ngroup supports id 2 3\n"
            "neigh_modify exclude group supports supports\n" + pair
            + f"fix gravity upper gravity {G!r} vector {-math.sin(TILT)!r} {-math.cos(TILT)!r} 0\n"
            f"fix shake supports move wiggle {AMPLITUDE!r} 0.0 0.0 {SHAKES!r}\n"
            f"fix move upper {move}\nfix flat all enforce2d\n" + inputs.runs(steps, dumps, old=style == "liggghts"))


class Three:
    def __init__(self, setup, steps=STEPS, check=CHECK):
        self.setup, self.steps, self.check_steps = setup, steps, check
        self.folder = os.path.join(setup.folder, "three")
        os.makedirs(self.folder, exist_ok=True)
        write_data(self._path("lammps.data"), True)
        write_data(self._path("liggghts.data"), False)

    def _path(self, name):
        return os.path.join(self.folder, name)

    def others(self):
        """{name: (style, program)}"""
        found = {}
        if self.setup.lammps:
            found = {f"LAMMPS {style}": (style, self.setup.lammps) for style in ("granular", "hooke")}
        if self.setup.liggghts:
            found["LIGGGHTS"] = ("liggghts", self.setup.liggghts)
        return found

    # --- one run: seconds per step of one system -----------------------------------------------------------------
    def slipdisk(self, cores):
        return programs.slipdisk(self.setup.program, DECK, self._path("three.h5"), cores, keys(WARM, self.steps)) / (
            WARM + self.steps)

    def lanes(self, cores):
        folder = self._path("lanes")
        words = [self.setup.program, "sweep", DECK, "-o", folder, "--force", "--quiet", "-j", "1"]
        for key, value in {**keys(WARM, self.steps), "sweep.replicas": POINTS}.items():
            words += ["-D", f"{key}={value}"]
        programs.call(programs.bound(words, cores), self.folder)
        points = glob.glob(os.path.join(folder, "points", "*.h5"))
        if len(points) != POINTS:
            raise programs.Failed(f"{folder}: {len(points)} points, not {POINTS}")
        return sum(map(programs.step_seconds, points)) / (POINTS * (WARM + self.steps))

    def other(self, name, cores):
        style, _ = self.others()[name]
        output = self._run(name, script(style, self._data(style), [WARM, self.steps]), cores)
        loop = programs.loop_time(output)
        if not loop or loop[2:] != (self.steps, 3):
            raise programs.Failed(f"{name}: a loop over {self.steps} steps of 3 disks was wanted, not {loop}")
        return loop[0] / self.steps

    def _data(self, style):
        return "liggghts.data" if style == "liggghts" else "lammps.data"

    def _run(self, name, text, cores):
        style, program = self.others()[name]
        with open(self._path(style + ".in"), "w") as file:
            file.write(text)
        output = programs.run_script(program, self._path(style + ".in"), cores)
        self.setup.note(name.split()[0], output)
        return output

    # --- physics ---------------------------------------------------------------------------------------------------
    def paths(self, cores):
        """{name: [steps][x, y, omega]} of the upper disk, from step 0 on."""
        every, result = self.check_steps // FRAMES, self._path("check.h5")
        # The phase of rest cannot be empty: all of it is one phase of the check, the other a single step.
        programs.slipdisk(self.setup.program, DECK, result, cores,
                          {**keys(self.check_steps, 1), "phases.rest.frames": every})
        with sealed.read(result) as file:
            disks = file["particles/disks"]
            keep = disks["position/step"][:] % every == 0
            path = np.column_stack([disks["position/value"][:, 0], disks["angular_velocity/value"][:, 0]])
            found = {"slipdisk": path[keep]}
        for name, (style, _) in self.others().items():
            self._run(name, script(style, self._data(style), [self.check_steps], (every, style + ".dump")), cores)
            dumped = frames.of_dump(self._path(style + ".dump"))
            found[name] = np.array([[frame.x[0], frame.y[0], frame.omega[0]] for frame in dumped])
        return found


def path_difference(path, own):
    """Largest distance between two paths, over the larger extent of the second one."""
    if path.shape != own.shape:
        raise ValueError(f"{len(path)} frames, not {len(own)}")
    return float(np.hypot(*(path - own)[:, :2].T).max() / np.ptp(own[:, :2], axis=0).max())


def compare(setup):
    it, core = Three(setup), programs.cores_here(1)
    setup.say(f"three disks: physics over {it.check_steps} steps")
    paths = it.paths(core)
    physics = {name: dict(zip(("x", "y", "omega"), path[-1]), off=path_difference(path, paths["slipdisk"]))
               for name, path in paths.items()}
    setup.say(f"three disks: time over {it.steps} steps")
    runs = {"slipdisk": lambda: 1e9 * it.slipdisk(core),
            f"slipdisk, a sweep of {POINTS} points": lambda: 1e9 * it.lanes(core)}
    for name in it.others():
        runs[name] = lambda name=name: 1e9 * it.other(name, core)
    times = {name: found.values for name, found in timing.alternate(runs, setup.repeats, setup.say).items()}
    return {"steps": it.steps, "dt": DT, "check_steps": it.check_steps, "physics": physics, "times": times}
