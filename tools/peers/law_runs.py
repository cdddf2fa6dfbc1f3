"""The laws of laws.py in both programs: collisions, rolling to rest, a packing that falls; what is measured of them.

Collisions: all pairs of a law stand in one run, far apart. They begin to touch at the same time. Head-on ones of two
small disks have speeds over two decades, oblique ones of a small and a large disk different angles.
Rolling: disks on a plane. Packing: disks of both sizes fall into a box and come to rest, from several random starts."""
import dataclasses
import math
import os

import numpy as np

from . import frames, inputs, laws, programs

SPEEDS = (0.01, 0.03, 0.1, 0.3, 1.0)
ANGLES, SPEED = (5, 15, 30, 45, 60, 75), 0.3    # degrees between approach and line of centres; relative speed
APART, BEFORE, LASTS = 0.2, 20, 4e-3             # of pairs; steps before touch, time after it
DT, STEPS = 1e-6, (4e-6, 2e-6, 1e-6, 5e-7)      # of collisions; and of their dependence on the step
ROLL_SPEEDS, ROLL_DT, ROLL_TIME = (0.05, 0.1, 0.2), 1e-5, 2.5
COUNT, WIDTH, SEEDS, FALL_DT, FALL_STEPS = 120, 0.2, 4, 1e-5, 120000
G = inputs.G


@dataclasses.dataclass
class Disks:
    kind: list                  # "a" or "b" of each disk
    x: np.ndarray
    y: np.ndarray
    vx: np.ndarray
    vy: np.ndarray
    omega: np.ndarray

    @property
    def radius(self):
        return np.array([laws.RADII[kind] for kind in self.kind])

    @property
    def mass(self):
        return np.array([laws.MASSES[kind] for kind in self.kind])

    def rows(self):
        columns = 'columns = ("x", "y", "vx", "vy", "omega", "radius", "material")'
        numbers = zip(*(map(float, it) for it in (self.x, self.y, self.vx, self.vy, self.omega, self.radius)))
        table = ",\n".join(f"    ({', '.join(map(repr, row))}, \"{kind}\")" for row, kind in zip(numbers, self.kind))
        return f'disk_rows = ( {{ {columns}; density = {laws.DENSITY}; rows = (\n{table} ); }} );\n'

    def write_data(self, path):
        """For LAMMPS: a density there is that of a sphere."""
        radius, zero, number = self.radius, np.zeros(len(self.kind)), np.arange(1, len(self.kind) + 1)
        types = [1 + "ab".index(kind) for kind in self.kind]
        low, high = (f(np.concatenate([self.x, self.y])) for f in (np.min, np.max))
        edges = "".join(f"{low - 2!r} {high + 2!r} {axis}lo {axis}hi\n" for axis in "xy")
        with open(path, "w") as file:
            file.write(f"disks\n\n{len(radius)} atoms\n2 atom types\n\n{edges}-0.01 0.01 zlo zhi\n\nAtoms\n\n")
            np.savetxt(file, np.column_stack([number, types, 2 * radius, self.mass / (4 / 3 * np.pi * radius**3),
                                              self.x, self.y, zero]), "%d %d %.17g %.17g %.17g %.17g %g")
            file.write("\nVelocities\n\n")
            np.savetxt(file, np.column_stack([number, self.vx, self.vy, zero, zero, zero, self.omega]),
                       "%d %.17g %.17g %g %g %g %.17g")


# --- starts -----------------------------------------------------------------------------------------------------
def pairs(dt=DT):
    """Head-on and oblique pairs, one above the other; the first of each moves to the right."""
    rows = [("aa", speed, 0.0) for speed in SPEEDS] + [("ab", SPEED, math.radians(angle)) for angle in ANGLES]
    kind, columns = [], []
    for k, (both, speed, angle) in enumerate(rows):
        u, v = speed * math.cos(angle) / 2, speed * math.sin(angle) / 2
        reach, before = sum(laws.RADII[it] for it in both), (BEFORE + 0.5) * dt
        # Where they are at touch: side by side along x.
        for sign, one in zip((-1, 1), both):
            kind.append(one)
            columns.append((sign * (reach / 2 + u * before), APART * k + sign * v * before, -sign * u, -sign * v, 0.0))
    return Disks(kind, *np.array(columns).T)


def collisions(start, end):
    """(e of the head-on pairs, [(angle of rebound of the surfaces, R omega / speed)] of the oblique ones)"""
    n = len(SPEEDS)
    vx, vy, omega = (np.asarray(it).reshape(-1, 2) for it in (end.vx, end.vy, end.omega))
    radius = start.radius.reshape(-1, 2)
    normal, tangential = vx[:, 0] - vx[:, 1], vy[:, 0] - vy[:, 1] + (radius * omega).sum(axis=1)
    e = [float(-normal[k] / speed) for k, speed in enumerate(SPEEDS)]
    oblique = [(math.degrees(math.atan2(tangential[k], -normal[k])), float(radius[k, 0] * omega[k, 0] / SPEED))
               for k in range(n, n + len(ANGLES))]
    return e, oblique


def rolling(law):
    """Disks of the small size on a plane that begin to roll, at their depth of rest."""
    speed = np.array(ROLL_SPEEDS)
    keys = law.keys(*laws.effective("a", "w"))
    depth = laws.MASSES["a"] * G / keys["k_n"]
    return Disks(["a"] * len(speed), np.arange(len(speed)) * 1.0, np.full(len(speed), laws.RADII["a"] - depth), speed,
                 np.zeros(len(speed)), -speed / laws.RADII["a"])


def expected_rolling(speed):
    """Distance to rest of a disk that rolls without sliding: couple mu_r R m g, deceleration 2/3 mu_r g."""
    return speed**2 / (4 / 3 * laws.MU_R * G)


def loose(seed):
    """Rows of disks that do not touch, sizes in random order."""
    rng, reach = np.random.default_rng(seed), laws.RADII["b"]
    wide = int(WIDTH / (2.3 * reach))
    row, column = np.divmod(np.arange(COUNT), wide)
    spacing = WIDTH / wide
    shift = rng.uniform(-0.1, 0.1, (2, COUNT)) * reach
    kind = ["ab"[k] for k in rng.permutation(np.arange(COUNT) % 2)]
    zero = np.zeros(COUNT)
    return Disks(kind, (column + 0.5) * spacing + shift[0] - WIDTH / 2, (row + 0.5) * 2.3 * reach + shift[1], zero,
                 zero, zero)


# --- decks and scripts --------------------------------------------------------------------------------------------
def deck(law, disks, dt, steps, gravity=False, walls="", frame=None):
    return (f'dt = {dt!r};\nintegrator = "verlet";\n' + (f"gravity = {{ g = {G!r}; }};\n" if gravity else "")
            + laws.materials(law) + walls + disks.rows() + f"steps = {steps};\nmeasure = {{ rotation = (); }};\n"
            f"output = {{ series = 0; frames = {frame or steps}; }};\n")


def script(law, data, dt, steps, dump, gravity=False, walls=(), frame=None):
    text = inputs.lammps_style("f").replace("boundary f f p", "boundary f f p") + f"read_data {data}\n"
    text += inputs.lists(0.2 * laws.RADII["a"], dt) + f"pair_style granular\npair_coeff * * {law.lammps}\n"
    text += f"fix gravity all gravity {G!r} vector 0 -1 0\n" if gravity else ""
    text += "".join(f"fix wall{k} all wall/gran granular {law.lammps} {where}\n" for k, where in enumerate(walls))
    text += "fix move all nve/sphere disc\nfix flat all enforce2d\n"
    return text + inputs.runs([steps], (frame or steps, dump))


PLANE = 'walls = ( { name = "plane"; type = "line"; points = ((-1, 0), (1, 0)); material = "w"; } );\n'
BOX = (f'container = {{ type = "box"; width = {WIDTH!r}; height = 1.0; material = "w"; }};\n')


def run_both(setup, law, disks, name, dt, steps, gravity=False, own_walls="", walls=(), frame=None):
    """{program: frames of slipdisk and, where it is, LAMMPS}"""
    path = os.path.join(setup.folder, "laws", name)
    os.makedirs(os.path.dirname(path), exist_ok=True)
    with open(path + ".cfg", "w") as file:
        file.write(deck(law, disks, dt, steps, gravity, own_walls, frame))
    core = programs.cores_here(1)
    programs.slipdisk(setup.program, path + ".cfg", path + ".h5", core)
    found = {"slipdisk": frames.of_slipdisk(path + ".h5")}
    if setup.lammps:
        disks.write_data(path + ".data")
        with open(path + ".in", "w") as file:
            base = os.path.basename(path)
            file.write(script(law, base + ".data", dt, steps, base + ".dump", gravity, walls, frame))
        setup.note("LAMMPS", programs.run_script(setup.lammps, path + ".in", core))
        found["LAMMPS"] = frames.of_dump(path + ".dump")
    return found


# --- a packing ----------------------------------------------------------------------------------------------------
def packed(law, disks, frame):
    """Mean height, contacts per disk (those of disks twice), elastic energy and kinetic energy per disk."""
    x, y, radius = frame.x, frame.y, disks.radius
    contacts, elastic = 0, 0.0

    def energy(keys, delta):
        power = 2.5 if keys.get("law") == "hertz" else 2
        return keys["k_n"] * delta**power / power

    for one in range(len(x)):
        gap = radius[one] + radius[one + 1:] - np.hypot(x[one + 1:] - x[one], y[one + 1:] - y[one])
        for other in np.flatnonzero(gap > 0):
            keys = law.keys(*laws.effective(disks.kind[one], disks.kind[one + 1 + other]))
            contacts, elastic = contacts + 2, elastic + energy(keys, gap[other])
        for depth in (radius[one] - y[one], radius[one] - (WIDTH / 2 - abs(x[one]))):
            if depth > 0:
                keys = law.keys(*laws.effective(disks.kind[one], "w"))
                contacts, elastic = contacts + 1, elastic + energy(keys, depth)
    kinetic = frames.kinetic_energy(frame, disks.mass, radius)
    return [float(y.mean()), contacts / len(x), elastic / len(x), kinetic]


def mean(rows):
    """(means, standard errors) of the columns"""
    rows = np.array(rows)
    error = rows.std(axis=0, ddof=1) / math.sqrt(len(rows)) if len(rows) > 1 else np.full(rows.shape[1], math.nan)
    return rows.mean(axis=0).tolist(), error.tolist()


def collide(setup, law, name, dt=DT):
    """{program: what `collisions` gives}"""
    start = pairs(dt)
    both = run_both(setup, law, start, name, dt, BEFORE + round(LASTS / dt))
    return {who: collisions(start, it[-1]) for who, it in both.items()}


def smaller_steps(setup, name="hooke"):
    """[(dt, {program: (e at 0.1 m/s, angles of rebound)})], and the exact e of the linear law."""
    rows = [(dt, {who: (e[2], [row[0] for row in oblique]) for who, (e, oblique) in
                  collide(setup, laws.LAWS[name], "steps", dt).items()}) for dt in STEPS]
    _, mass = laws.effective("a", "a")
    exact = laws.restitution(lambda delta: laws.K * delta, lambda _delta: laws.GAMMA, mass, 0.1, True)
    return {"rows": rows, "e": exact}


def compare_law(setup, name, seeds):
    """All that is told of a law, as plain data."""
    law, path = laws.LAWS[name], name.replace(" ", "").replace(",", "-").replace("/", "-")
    found = {"collisions": collide(setup, law, path + "-pairs")}
    if law.rolls:
        start = rolling(law)
        both = run_both(setup, law, start, path + "-rolling", ROLL_DT, round(ROLL_TIME / ROLL_DT), True, PLANE,
                        ("yplane 0.0 NULL",))
        found["rolling"] = {who: (it[-1].x - start.x).tolist() for who, it in both.items()}
    rows = {}
    for seed in range(seeds):
        start = loose(seed)
        both = run_both(setup, law, start, f"{path}-packing", FALL_DT, FALL_STEPS, True, BOX,
                        (f"xplane {-WIDTH / 2!r} {WIDTH / 2!r}", "yplane 0.0 NULL"))
        for who, it in both.items():
            rows.setdefault(who, []).append(packed(law, start, it[-1]))
    return {**found, "packing": {who: mean(it) for who, it in rows.items()}}


def compare(setup, names=None, seeds=SEEDS):
    """What is found, anew after each law."""
    found, steps = {}, smaller_steps(setup)
    for name in names or laws.LAWS:
        setup.say(f"law: {name}")
        found[name] = compare_law(setup, name, seeds)
        yield {"seeds": seeds, "laws": dict(found), "steps": steps}
