"""The packing that is compared: disks of 0.8 to 1.2 mean radii, settled under gravity on a flat floor, periodic along
x, then shaken for a while; much like that of tests/bench/cases.h.

slipdisk makes a packing of at most BASE disks; larger ones are copies of it side by side. Positions and velocities go
to all programs; memories of contacts do not, since the others cannot read them: all begin with relaxed tangential springs."""
import dataclasses
import os

import h5py
import numpy as np
from slipdisk import sealed

from . import inputs, programs

MEAN = 0.02                     # mean radius
BASE, HIGH = 1000, 25           # disks of the packing that is made, and rows of it before it settles
SETTLE, SHAKE = 30000, 20       # steps at rest; periods of shaking


@dataclasses.dataclass
class Packing:
    x: np.ndarray
    y: np.ndarray
    vx: np.ndarray
    vy: np.ndarray
    omega: np.ndarray
    radius: np.ndarray
    width: float                # of the periodic box, from 0

    @property
    def count(self):
        return len(self.x)

    @property
    def mass(self):
        return inputs.DENSITY * np.pi * self.radius**2

    @property
    def height(self):
        return float((self.y + self.radius).max())

    def repeated(self, copies):
        columns = {name: np.tile(getattr(self, name), copies) for name in ("y", "vx", "vy", "omega", "radius")}
        x = np.concatenate([self.x + k * self.width for k in range(copies)])
        return Packing(x=x, width=copies * self.width, **columns)

    def write_hdf5(self, path):
        """For disk_files of a deck: the dataset /disks."""
        names = ("x", "y", "vx", "vy", "omega", "radius")
        table = np.zeros(self.count, dtype=[(name, float) for name in names])
        for name in names:
            table[name] = getattr(self, name)
        with h5py.File(path, "w") as file:
            file["disks"] = table

    def write_data(self, path, spheres):
        """For read_data of LAMMPS and LIGGGHTS. In two dimensions, too, a density is for LAMMPS that of a sphere; for
        LIGGGHTS it is mass over area there."""
        density = self.mass / (4 / 3 * np.pi * self.radius**3 if spheres else np.pi * self.radius**2)
        number, zero = np.arange(1, self.count + 1), np.zeros(self.count)
        top = self.height + 10 * MEAN
        with open(path, "w") as file:
            file.write(f"packing of {self.count} disks\n\n{self.count} atoms\n1 atom types\n\n"
                       f"0 {self.width!r} xlo xhi\n{-2 * MEAN!r} {top!r} ylo yhi\n{-MEAN!r} {MEAN!r} zlo zhi\n\n"
                       "Atoms\n\n")
            # Columns: id, type, diameter, density, position; then id, velocity, angular velocity.
            np.savetxt(file, np.column_stack([number, zero + 1, 2 * self.radius, density, self.x, self.y, zero]),
                       "%d %d %.17g %.17g %.17g %.17g %g")
            file.write("\nVelocities\n\n")
            np.savetxt(file, np.column_stack([number, self.vx, self.vy, zero, zero, zero, self.omega]),
                       "%d %.17g %.17g %g %g %g %.17g")


def read(path):
    with open(path) as file:
        return file.read()


def from_result(path, frame=-1):
    """The packing as a result of slipdisk has it in a frame."""
    with sealed.read(path) as file:
        disks = file["particles/disks"]
        x, y = disks["position/value"][frame].T
        vx, vy = disks["velocity/value"][frame].T
        return Packing(x=x, y=y, vx=vx, vy=vy, omega=disks["angular_velocity/value"][frame], radius=disks["radius"][:],
                       width=float(disks["box/edges"][0]))


def loose(count):
    """Disks in rows that do not touch: what falls on the floor."""
    high = HIGH if count >= BASE else 10
    wide, spacing = count // high, 2.45 * MEAN
    row, column = np.divmod(np.arange(count), wide)
    zero = np.zeros(count)
    return Packing(x=spacing * (column + 0.5 * (row % 2)), y=spacing * (0.5 + 0.87 * row), vx=zero, vy=zero, omega=zero,
                   radius=MEAN * np.random.default_rng(1).uniform(0.8, 1.2, count), width=wide * spacing)


def make(program, folder, count, cores):
    """A packing of so many disks (multiples of 10 below BASE, of BASE above): settled, shaken, at the beginning of a
    period of the floor. What was made before is taken again."""
    if count > BASE and count % BASE or count < BASE and count % 10 or count < 50:
        raise ValueError(f"{count} disks: multiples of {BASE} above that, of 10 from 50 on")
    base = min(count, BASE)
    start, deck, result = (os.path.join(folder, name) for name in (f"loose-{base}.h5", f"packing-{base}.cfg",
                                                                   f"packing-{base}.h5"))
    text = inputs.packing_deck(os.path.basename(start), loose(base).width,
                               [("settle", SETTLE, False), ("shake", SHAKE * inputs.PERIOD, True)])
    if not (os.path.exists(result) and read(deck) == text):
        loose(base).write_hdf5(start)
        with open(deck, "w") as file:
            file.write(text)
        programs.slipdisk(program, deck, result, cores[:1])
    return from_result(result).repeated(count // base)
