"""What is written and read: series, contact tables, restarts from files, exports, sweeps."""
import contextlib
import copy
import csv
import pathlib
import shutil
import subprocess
import tempfile

import h5py
import numpy as np

from . import added, decks, symmetries, watch

WRITTEN = 1e-9    # of a force of 1: rounding of tables
GEAR = 1e-4       # directions of stored positions, forces of predicted ones
RESTART = 1e-8
without = symmetries.without
BONDS = symmetries.BONDS


@contextlib.contextmanager
def folder():
    made = pathlib.Path(tempfile.mkdtemp(prefix="slipdisk-relations-"))
    try:
        yield made
    finally:
        shutil.rmtree(made, ignore_errors=True)


def call(*words, statuses=(0, 5)):
    done = subprocess.run([watch.os.environ["SLIPDISK_PROGRAM"], *map(str, words)], capture_output=True, text=True)
    if done.returncode == 3:
        raise watch.Refused(done.stderr)
    if done.returncode not in statuses:
        raise watch.Wrong(f"{words[0]}: exit status {done.returncode}: {done.stderr[-400:]}")
    return done.stdout


def run(work, deck, name="r"):
    (work / f"{name}.cfg").write_text(watch.slipdisk.deck_text(deck))
    call("run", work / f"{name}.cfg", "-o", work / f"{name}.h5", "--quiet", "--threads", 1)
    return work / f"{name}.h5"


NAMES = "force_x", "force_y", "torque"
MEASURES = {"walls": True, "groups": True, "box": True, "stress": True, "rattlers": True}


def near(what, step, got, expected, most):
    far = np.abs(np.asarray(got) - np.asarray(expected)).max(initial=0.0)
    if not far <= most:
        raise watch.Wrong(f"{what} at step {step} is off by {far:.2g}")


def table_forces(work, result, n_bodies):
    """{step: forces on bodies, the sums of contacts.csv}"""
    call("measure", result, "--all", "--csv", work / "tables")
    sums = {}
    with open(work / "tables" / "contacts.csv", newline="", encoding="utf-8") as file:
        for row in csv.DictReader(file):
            force = np.array([float(row["force_x"]), float(row["force_y"])])
            total = sums.setdefault(int(row["step"]), np.zeros((n_bodies, 2)))
            total[int(row["b"])] += force
            total[int(row["a"])] -= force
    return sums


def written(seed):
    """Series of walls, groups and disks, and contacts.csv, have the forces that act in the engine."""
    made = decks.make(seed, {"bond": BONDS})
    deck = copy.deepcopy(made.deck)
    steps = 24
    deck["phases"] = [{**phase, "steps": steps // len(deck["phases"])} for phase in deck["phases"]]
    deck["output"] = {"series": 1, "frames": 1, "contacts": 1}
    names = [d["name"] for d in deck["disks"]]
    deck["measure"] = {**MEASURES, "contacts": names}
    if not deck.get("walls"):
        del deck["measure"]["walls"]
    seen = watch.follow(deck, steps, 1)
    members = [[k for k, d in enumerate(deck["disks"]) if d["group"] == group] for group in ("group0", "group1")]
    most = GEAR if deck["integrator"] == "gear5" else WRITTEN
    with folder() as work:
        result = run(work, deck)
        sums = table_forces(work, result, len(seen[0]["torque"]))
        with h5py.File(result) as file:
            o = file["observables"]
            columns = {key: o[key]["value"][:] for key in o if isinstance(o[key], h5py.Group)}
            order = o["groups"][()].decode().split()
    for step, look in enumerate(seen):
        force = np.column_stack([look["force"], look["torque"]])
        n = len(names)
        near("contacts.csv", step, sums.get(step, np.zeros((len(force), 2))), force[:, :2], most)
        for c, name in enumerate(NAMES):
            near(f"disk_{name}", step, columns[f"disk_{name}"][step], force[:n, c], most)
            if len(force) > n:
                near(f"wall_{name}", step, columns[f"wall_{name}"][step], force[n:, c], most)
            if name != "torque":
                near(f"group_{name}", step, columns[f"group_{name}"][step],
                     [force[members[int(g[-1])], c].sum() for g in order], most)


def stress(seed):
    """A sigma = sum X F over the bodies + sum of the walls' places times the forces on them, at any moment."""
    made = decks.make(seed, {"walls": ("box",), "box": ("open",), "bond": BONDS, "friction": ("smooth",), "rolling": ("none",), "motion": ("none",),
                             "integrator": ("verlet",), **without("bodies", "held")})
    deck, (x0, y0, x1, y1) = made.deck, added.in_container(made.deck)
    deck["phases"] = [{"steps": 40}]
    deck["output"] = {"series": 1}
    deck["measure"] = {"walls": True, "stress": True}
    sim = watch.simulation(deck)
    with folder() as work:
        with h5py.File(run(work, deck)) as file:
            o = file["observables"]
            columns = {key: o[key]["value"][:] for key in ("stress_xx", "stress_yy", "wall_force_x", "wall_force_y")}
            names = o["walls"][()].decode().split()
    area = (x1 - x0) * (y1 - y0)
    at = {"floor": (0, y0), "lid": (0, y1), "left": (x0, 0), "right": (x1, 0)}
    for step in range(41):
        for c, name in enumerate("xy"):
            walls = sum(at[wall][c] * columns[f"wall_force_{name}"][step][k] for k, wall in enumerate(names))
            got = area * columns[f"stress_{name * 2}"][step]
            near(f"stress_{name * 2}", step, got, walls + moments(sim, deck, name), 1e-9)
        watch.advance(sim, 1)


def moments(sim, deck, name):
    """Sum X F; bodies are clumps where there are. Held disks do not count: branches end at their surface."""
    state, columns = sim.disks, sim.columns
    members = {m for clump in deck.get("clumps", ()) for m in clump["disk"]}
    single = np.array([d["name"] not in members for d in deck["disks"]])
    total = float((state[name] * state[f"force_{name}"])[single].sum())
    if members:
        total += float((np.array(columns[f"clump_{name}"]) * columns[f"clump_force_{name}"]).sum())
    return total


def continued(deck, result):
    """The deck that goes on from the result of the first."""
    other = {key: value for key, value in deck.items() if key != "disks"}
    other["disk_files"] = [{"file": str(result), "contacts": True}]
    locks = [{"disk": d["name"], "coordinates": d["locked"]} for d in deck["disks"] if "locked" in d]
    forces = [{"disk": d["name"], "force": d["force"], "torque": d["torque"]} for d in deck["disks"] if "force" in d]
    other.update({key: value for key, value in (("locks", locks), ("forces", forces)) if value})
    other["phases"] = [{"steps": 100}]
    return other


def taken_over(seed):
    """A deck that begins with a result and its contacts goes on as the first would have.

    Without damping that depends on the sign of a velocity, which may be another before and after the corrector."""
    deck = decks.make(seed, {"motion": ("none", "push", "spin", "belt", "lead"), **without("bodies", "clumps"),
                             **without("field", "damping"), "materials": ("one", "two"),
                             "bond": [name for name in BONDS if name != "sinter"]}).deck
    steps = 60 + seed % 120
    deck = {**deck, "phases": [{"steps": steps}], "output": {"series": 0}}
    seen = watch.follow({**deck, "phases": [{"steps": steps + 20}]}, steps + 20, 1)[steps:]
    with folder() as work:
        other = continued(deck, run(work, deck))
        found = watch.follow(other, 20, 1)
    n = len(deck["disks"])
    edges = watch.edges_of(deck)
    for a, b in zip(seen, found):
        for look in a, b:
            if edges.any():
                look["place"] = look["place"] - np.where(edges > 0, edges * np.floor(look["place"] / np.where(edges > 0, edges, 1)), 0)
            look["torque"] = look["torque"][:n]
    forces, moves = ("force", "torque"), ("velocity", "spin") if edges.any() else ("place", "velocity", "spin")
    # the first forces with Gear are shown in the directions of the corrected places
    first, later = (GEAR, 10 * RESTART) if deck["integrator"] == "gear5" else (RESTART, RESTART)
    watch.same(seen[:1], found[:1], first, forces)
    watch.same(seen[1:], found[1:], later, forces)
    watch.same(seen, found, later, moves)


EXPORTS = {"csv": ("t", "t/disks.csv"), "lammps-data": ("t.data", "t.data"), "h5md3d": ("t.h5md", "t.h5md")}


def exported(seed):
    """Disks that are written for others and read again stand and move as they did."""
    deck = decks.make(seed, {"motion": ("none",), **without("bodies", "clumps", "locked")}).deck
    deck = {**deck, "phases": [{"steps": 40 + seed % 100}], "output": {"series": 0}}
    sim = watch.simulation(deck)
    watch.advance(sim, deck["phases"][0]["steps"])
    to = list(EXPORTS)[seed % 2]
    out, read = EXPORTS[to]
    with folder() as work:
        call("export", run(work, deck), "--to", to, "-o", work / out, "--frames", "-1")
        other = {key: value for key, value in deck.items() if key not in ("disks", "fields")}
        other["disk_files"] = [{"file": str(work / read), "density": 1.0, "material": "grain"}]
        if to == "csv":
            other["disk_files"][0]["columns"] = ["x", "y", "radius", "vx", "vy", "omega"]
        found = watch.simulation(other).disks
    state = sim.disks
    for name in "x", "y", "vx", "vy", "omega", "radius":
        near(name, 0, found[name], state[name], 1e-12)


def small(seed):
    """A deck of two free disks, which sweeps do side by side."""
    made = decks.make(seed, {"bodies": ("free", "held", "inertia", "forces"), "bond": BONDS, **without("motion", "load", "servo")})
    deck = copy.deepcopy(made.deck)
    led = {m.get("disk") for m in deck.get("motions", ())}
    kept = [d for d in deck["disks"] if d.get("fixed") or d["name"] in led]
    deck["disks"] = kept + [d for d in deck["disks"] if d not in kept][:2]
    deck["phases"] = [{**phase, "steps": max(40, phase["steps"] // 3)} for phase in deck["phases"]]
    return deck


def lanes(seed):
    """Points of a sweep, several of them side by side, have the bits of single runs."""
    deck = symmetries.of_equal_strength(small(seed))  # each point has a seed of its own
    deck["output"] = {"series": 0}
    speeds = [d["name"] for d in deck["disks"] if "omega" in d][:1]
    if not speeds:
        raise watch.Refused("no free disk")
    values = [-3.0, 0.5, 2.0, 7.0, 11.0]
    path = f"disks.{speeds[0]}.omega"
    hashes = []
    for value in values:
        sim = watch.simulation(deck, overrides={path: value})
        watch.advance(sim, sum(p["steps"] for p in deck["phases"]))
        hashes.append([np.asarray(sim.columns[name]).tobytes() for name in ("x", "y", "theta", "vx", "vy", "omega")])
    with folder() as work:
        (work / "d.cfg").write_text(watch.slipdisk.deck_text(
            {**deck, "sweep": {"parameters": [{"path": path, "name": "spin", "values": values}], "replicas": 1}}))
        call("sweep", work / "d.cfg", "-o", work / "d.sweep", "--quiet", "-j", 1)
        sweep = watch.slipdisk.Sweep(work / "d.sweep")
        for k, value in enumerate(values):
            state = sweep[k].state
            for name, wanted in zip(("x", "y", "theta", "vx", "vy", "omega"), hashes[k]):
                if np.asarray(state[name]).tobytes() != wanted and "random" not in str(deck.get("motions")):
                    raise watch.Wrong(f"{name} of the point {value} differs from the single run")
