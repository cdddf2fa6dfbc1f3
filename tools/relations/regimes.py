"""The same of what is not plain dynamics: deforming boxes, compression, relaxation, rain, sweeps; stress against forces on walls."""
import copy
import h5py
import numpy as np

from . import decks, files, maps, symmetries, watch

EVERY = symmetries.EVERY
NEAR = symmetries.NEAR
without = symmetries.without
PLAIN = {"box": ("xy",), "walls": ("none",), "bodies": ("free", "inertia"), "gravity": ("none",), "motion": ("none",), "field": ("none",)}


# --- decks ------------------------------------------------------------------------------------------------------------


def cell(b, made):
    """A box that deforms, at rates or stresses."""
    kinds = ({"rate_xy": b.uniform(-3, 3)}, {"rate_xx": b.uniform(-1, 1), "rate_yy": b.uniform(-1, 1)},
             {"rate_xy": b.uniform(-3, 3), "stress_yy": b.uniform(0.5, 3), "max_rate": 2.0},
             {"stress_xx": 2.0, "stress_yy": b.uniform(0.5, 3), "max_rate": 2.0},
             {"stress_xy": b.uniform(-1, 1), "stress_yy": 2.0, "max_rate": 2.0})
    made.deck["phases"] = [{"steps": 300, "cell": b.choice(kinds)}]


def compress(b, made):
    target = {"pressure": b.uniform(0.5, 5)} if b.random() < 0.5 else {"fraction": b.uniform(0.8, 0.95)}
    made.deck["phases"] = [{"steps": 300, "compress": {**target, "rate": b.uniform(1, 10)}}]


def relax(b, made):
    made.deck["integrator"] = "verlet"
    made.deck["phases"] = [{"steps": 300, "relax": True}]


REGIMES = {
    "cell": (cell, PLAIN),
    "compress": (compress, {**PLAIN, "bodies": ("free", "inertia", "clumps", "locked")}),
    "compress a box": (compress, {"walls": ("box",), "box": ("open",), **without("bodies", "held"), "motion": ("none",),
                                  "field": ("none",)}),
    "relax": (relax, {"field": ("none", "central"), "motion": ("none", "push", "spin", "table"), "integrator": ("verlet",)}),
}


def make(name, seed):
    change, only = REGIMES[name]
    made = decks.make(seed, only)
    change(decks.random.Random(f"{name}-{seed}"), made)
    return in_container(made.deck)[0] if name == "compress a box" else made.deck


def in_container(deck):
    """(the deck with a container in place of its walls, corners)"""
    deck = copy.deepcopy(deck)
    points = np.array([p for wall in deck["walls"] for p in wall["points"]])
    (x0, y0), (x1, y1) = points.min(0), points.max(0)
    material = {"material": deck["walls"][0]["material"]} if "material" in deck["walls"][0] else {}
    del deck["walls"]
    deck["container"] = {"type": "box", "width": x1 - x0, "height": y1 - y0, "origin": [(x0 + x1) / 2, y0], "open": False, **material}
    return deck, (x0, y0, x1, y1)


def mirrored(deck):
    other = maps.mapped(maps.MIRROR, deck)
    if "container" in other:
        other["container"]["origin"] = maps.MIRROR.point(other["container"]["origin"])
    for phase in other["phases"]:
        for name in "rate_xy", "stress_xy":
            if name in phase.get("cell", {}):
                phase["cell"][name] *= -1
    return other


KINDS = ("angle", "spin", "force", "torque", "energy")  # boxes change about their lower left corner, and so do frames


def in_any_frame(looks, n):
    """Without what depends on the frame, or on where a wall's pivot is."""
    for look in looks:
        look["torque"] = look["torque"][:n]
        look["energy"] = look["energy"][symmetries.INNER]
    return looks


def regime_mirror(seed):
    """Deforming boxes, compression, relaxation: mirrored."""
    deck = make(list(REGIMES)[seed % len(REGIMES)], seed)
    n = len(deck["disks"])
    one = [watch.mapped_look(maps.MIRROR, look) for look in watch.follow(deck, 300, EVERY)]
    found = watch.follow(mirrored(deck), 300, EVERY)
    if "container" in deck:  # left and right have changed places
        for look in found:
            look["force"][[n + 1, n + 2]] = look["force"][[n + 2, n + 1]]
            look["angle"], look["spin"] = look["angle"][:n], look["spin"][:n]
        for look in one:
            look["angle"], look["spin"] = look["angle"][:n], look["spin"][:n]
    watch.same(in_any_frame(one, n), in_any_frame(found, n), NEAR, KINDS, EVERY)


def regime_order(seed):
    """Deforming boxes, compression, relaxation: disks in another order."""
    deck = make(list(REGIMES)[seed % len(REGIMES)], seed)
    other = copy.deepcopy(deck)
    other["disks"].reverse()
    n = len(deck["disks"])
    found = watch.follow(other, 300, EVERY)
    for look in found:
        for kind, values in look.items():
            if kind != "energy":
                look[kind] = np.concatenate([values[:n][::-1], values[n:]])
    watch.same(watch.follow(deck, 300, EVERY), found, NEAR, every=EVERY)


def regime_images(seed):
    """Deforming boxes: what stands elsewhere does the same, with shear in a frame that moves."""
    deck = make(("cell", "compress")[seed % 2], seed)
    edges = watch.edges_of(deck)
    m = maps.shifted(0.53 * edges[0], 0.41 * edges[1])
    other = maps.mapped(m, deck)
    other["box"] = copy.deepcopy(deck["box"])
    seen, found = watch.follow(deck, 300, EVERY), watch.follow(maps.into_box(other), 300, EVERY)
    watch.same(seen, found, NEAR, ("angle", "spin", "force", "torque"), EVERY)


def regime_phases(seed):
    """Deforming boxes, compression, relaxation: a phase in three parts, the same bits."""
    deck = make(list(REGIMES)[seed % len(REGIMES)], seed)
    other = copy.deepcopy(deck)
    other["phases"] = [{**deck["phases"][0], "steps": steps} for steps in (100, 77, 123)]
    watch.same(watch.follow(deck, 300, EVERY), watch.follow(other, 300, EVERY), 0.0, every=EVERY)


def regime_bits(seed):
    """Deforming boxes, compression, relaxation: saved in the middle."""
    deck = make(list(REGIMES)[seed % len(REGIMES)], seed)
    sim = watch.simulation(deck)
    watch.advance(sim, 100 + seed % 50)
    other = watch.slipdisk.Simulation.from_bytes(sim.to_bytes())
    for which in sim, other:
        watch.advance(which, 120)
    if sim.hash() != other.hash():
        raise watch.Wrong("the state differs")


# --- rain -------------------------------------------------------------------------------------------------------------


def rain_deck(seed, origin):
    b = decks.random.Random(f"rain-{seed}")
    made = decks.make(seed, {"walls": ("none",), "box": ("open",), "motion": ("none",), "field": ("none",), "gravity": ("down",),
                             "materials": ("one",), "bodies": ("free",)})
    deck = made.deck
    deck["disks"] = []
    deck["container"] = {"type": b.choice(("box", "channel")), "width": 0.6, "height": 0.5, "origin": origin}
    deck["packings"] = [{"type": "rain", "count": 14, "rows": 1, "interval": 2.5e-3, "speed": 1.0, "density": 1.0, "sizes": "uniform",
                         "lower": 0.04, "upper": 0.055,
                         "y": [origin[1] + 0.003, origin[1] + 0.5]}]  # clear of the floor by more than rounding
    deck["phases"] = [{"steps": 800}]
    return deck


def rain(seed):
    """Rain elsewhere falls in the same way, and a copy of it."""
    deck = rain_deck(seed, [0.0, 0.0])
    n = 14
    one, other = watch.follow(deck, 800, 100), watch.follow(rain_deck(seed, [1.0, 2.0]), 800, 100)
    watch.same(in_any_frame(one, n), in_any_frame(other, n), 10 * NEAR, KINDS, 100)
    sim = watch.simulation(deck)
    watch.advance(sim, 330)
    copied = sim.clone()
    for which in sim, copied:
        watch.advance(which, 400)
    if sim.hash() != copied.hash():
        raise watch.Wrong("the state of a copy differs")


# --- stress -----------------------------------------------------------------------------------------------------------


def stress(seed):
    """A sigma = sum X F over the bodies + sum of the walls' places times the forces on them, at any moment."""
    made = decks.make(seed, {"walls": ("box",), "box": ("open",), "friction": ("smooth",), "rolling": ("none",), "motion": ("none",),
                             "integrator": ("verlet",), **without("bodies", "held")})
    deck, (x0, y0, x1, y1) = in_container(made.deck)
    deck["phases"] = [{"steps": 40}]
    deck["output"] = {"series": 1}
    deck["measure"] = {"walls": True, "stress": True}
    sim = watch.simulation(deck)
    with files.folder() as work:
        with h5py.File(files.run(work, deck)) as file:
            o = file["observables"]
            columns = {key: o[key]["value"][:] for key in ("stress_xx", "stress_yy", "wall_force_x", "wall_force_y")}
            names = o["walls"][()].decode().split()
    area = (x1 - x0) * (y1 - y0)
    at = {"floor": (0, y0), "lid": (0, y1), "left": (x0, 0), "right": (x1, 0)}
    for step in range(41):
        for c, name in enumerate("xy"):
            walls = sum(at[wall][c] * columns[f"wall_force_{name}"][step][k] for k, wall in enumerate(names))
            got = area * columns[f"stress_{name * 2}"][step]
            files.near(f"stress_{name * 2}", step, got, walls + moments(sim, deck, name), 1e-9)
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
