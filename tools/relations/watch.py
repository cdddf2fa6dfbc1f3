"""What came of a deck: numbers of all bodies, forces and energies at chosen steps, made in this process."""
import os
import pathlib
import sys
import warnings

import numpy as np

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
BUILD = pathlib.Path(os.environ.get("SLIPDISK_BUILD_DIR", ROOT / "build/release"))
os.environ.setdefault("SLIPDISK_LIBRARY", str(BUILD / "libslipdisk.so"))
os.environ.setdefault("SLIPDISK_PROGRAM", str(BUILD / "slipdisk"))
sys.path.insert(0, str(ROOT / "tools" / "python"))

import slipdisk  # noqa: E402

ENERGIES = ("kinetic_translation", "kinetic_rotation", "elastic_normal", "elastic_tangential", "elastic_rolling", "elastic_bond", "cohesion",
            "work", "nonconservative_work", "viscous", "friction", "rolling", "bridge", "opening", "broken_tension", "broken_shear",
            "broken_bending", "drag", "damping")
SCALES = {"place": 0.05, "angle": 1.0, "velocity": 1.0, "spin": 20.0, "force": 1.0, "torque": 0.05, "energy": 0.01}


FREE = tuple(kind for kind in SCALES if kind != "place")


class Refused(Exception):
    """The program refuses the deck, with a message."""


class Wrong(Exception):
    """The relation does not hold."""


def simulation(deck, threads=1, **more):
    try:
        with warnings.catch_warnings():  # of overlaps at the start, which are meant
            warnings.simplefilter("ignore", slipdisk.Warning)
            return slipdisk.Simulation(deck, threads=threads, **more)
    except slipdisk.Error as error:
        raise Refused(str(error)) from None


def advance(sim, steps):
    try:
        sim.advance(steps)
    except slipdisk.NumericError as error:
        raise Refused(str(error)) from None


def edges_of(deck):
    box = deck.get("box", {})
    return np.array([box[name][1] - box[name][0] if name in box.get("periodic", "") else 0.0 for name in "xy"])


def look(sim, deck):
    """{kind: array} of disks then walls, by number; places are absolute."""
    kept = {}
    edges = edges_of(deck)
    bodies = sim.disks, sim.walls

    def join(name):
        return np.concatenate([np.asarray(b[name], float) for b in bodies])
    kept["place"] = np.stack([join("x") + join("image_x") * edges[0], join("y") + join("image_y") * edges[1]], 1)
    kept["velocity"] = np.stack([join("vx"), join("vy")], 1)
    kept["angle"], kept["spin"] = join("angle"), join("omega")
    kept["force"] = np.stack([join("force_x"), join("force_y")], 1)
    kept["torque"] = join("torque")
    energy = sim.energy
    kept["energy"] = np.array([energy[name] for name in ENERGIES])
    return kept


def follow(deck, steps, every):
    """Looks at each multiple of `every`, beginning with step 0."""
    sim = simulation(deck)
    seen = [look(sim, deck)]
    for _ in range(steps // every):
        advance(sim, every)
        seen.append(look(sim, deck))
    return seen


def apart(one, other, kinds=tuple(SCALES)):
    """(how far apart two looks are, in units of what is usual, kind)"""
    worst = 0.0, ""
    for kind in kinds:
        far = float(np.abs(one[kind] - other[kind]).max(initial=0.0)) / SCALES[kind]
        if not far <= worst[0]:
            worst = far, kind
    return worst


def same(one, other, most, kinds=tuple(SCALES), every=1):
    """Two records of looks agree."""
    for k, (a, b) in enumerate(zip(one, other, strict=True)):
        far, kind = apart(a, b, kinds)
        if not far <= most:
            raise Wrong(f"{kind} is off by {far:.2g} at step {k * every}")


def mapped_look(m, seen):
    """What the look is after the map, but for angles at the start."""
    matrix = np.array(m.matrix)
    found = dict(seen)
    found["place"] = seen["place"] @ matrix.T + np.array(m.shift)
    for kind in "velocity", "force":
        found[kind] = seen[kind] @ matrix.T
    for kind in "spin", "torque", "angle":
        found[kind] = m.turn * seen[kind]
    return found
