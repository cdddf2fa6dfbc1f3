"""What changes nothing: mirrors, turns, shifts, other orders, divisions of the run, features of size zero, another frame."""
import copy

import numpy as np

from . import decks, maps, watch

EVERY = 30
NEAR = 1e-8   # after 300 steps; two runs differ by rounding, which collisions make larger
CONTACT = ("normal", "damping", "friction", "rolling", "cohesion")


def without(dimension, *names):
    return {dimension: [name for name in decks.FEATURES[dimension] if name not in names]}


# Rows of added.py that maps carry; half of the decks have none.
BONDS = ("none", *decks.FEATURES["bond"])
ADDED = {"bond": BONDS[2:],
         "phases": tuple(row for row in decks.FEATURES["phases"] if row != "loads in phases"),
         "bodies later": ("hold and release",), "bounds": ("report",),
         "also": tuple(name for name in decks.FEATURES["also"] if name not in ("none", "a noisy group"))}
DEFORMING = "box at rates", "box at stresses", "compress", "compress a box"
KINDS = ("angle", "spin", "force", "torque", "energy")  # boxes change about their lower left corner, and so do frames
INNER = [watch.ENERGIES.index(name) for name in watch.ENERGIES if not name.startswith(("kinetic", "work"))]


def draw(seed, only=None, **less):
    """The deck of a number, with rows of added.py but for some: {dimension: rows that are left out}."""
    rows = {name: [row for row in names if row not in less.get(name, ())] for name, names in ADDED.items()}
    return decks.make(seed, {**{name: ("none", *names, *["none"] * len(names)) for name, names in rows.items()}, **(only or {})})


def in_any_frame(looks, n):
    """Without what depends on the frame, or on where a wall's pivot is."""
    for look in looks:
        look["torque"] = look["torque"][:n]
        look["energy"] = look["energy"][INNER]
    return looks


def of_equal_strength(deck):
    """The deck with bonds whose strength does not depend on the numbers of two bodies."""
    for law in deck["materials"] + deck.get("material_pairs", []):
        law.pop("bond_weibull", None)
    return deck


def relate(made, m, steps=300):
    """The map of the deck does the map of what the deck does."""
    deck, kinds, n = made.deck, tuple(watch.SCALES), len(made.deck["disks"])
    if m.turn < 0 and "container" in deck:
        of_equal_strength(deck)
    one = [watch.mapped_look(m, seen) for seen in watch.follow(deck, steps, EVERY)]
    other = watch.follow(maps.mapped(m, deck), steps, EVERY)
    if m.turn < 0 and "container" in deck:  # left and right have changed places
        for look in other:
            for kind, values in look.items():
                if kind != "energy":
                    values[[n + 1, n + 2]] = values[[n + 2, n + 1]]
    if made.has["phases"] in DEFORMING:
        one, other, kinds = in_any_frame(one, n), in_any_frame(other, n), KINDS
    if "container" in deck:  # walls of containers point in directions of their own
        for look in one + other:
            look["angle"], look["torque"] = look["angle"][:n], look["torque"][:n]
    watch.same(one, other, NEAR, kinds, EVERY)


def mirror(seed):
    """x -> -x, or y -> -y where x is driven by random numbers, which have no sign."""
    made = draw(seed)
    driven = [m["coordinate"] for m in made.deck.get("motions", ()) if m["type"] == "random"]
    if {"x", "y"} <= set(driven):
        raise watch.Refused("random numbers drive both")
    upside_down = "x" in driven or (seed % 2 and "y" not in driven and "container" not in made.deck)
    relate(made, maps.UPSIDE_DOWN if upside_down else maps.MIRROR)


def quarter(seed):
    """A quarter turn. Random streams, a square's corner and shear belong to a coordinate."""
    relate(draw(seed, without("motion", "random"), phases=DEFORMING, also=("a pressing lid", "fields of a group")),
           maps.QUARTER)


def shift(seed):
    """Everything elsewhere, the box too. What relaxes depends on the sign of a power, which rounding may change."""
    relate(draw(seed, phases=("relax",)), maps.shifted(0.375, -1.25))


def images(seed):
    """Everything elsewhere but the box: what is beyond its edges is taken back. Shear does the same in a frame that moves."""
    made = draw(seed, {"box": ("x", "y", "xy"), **without("field", "drag", "central", "rotation"),
                       **without("walls", "drum", "ring", "bowl", "pillar", "hump")},
                phases=("compress a box", "relax"), bounds=("report",), also=("fields of a group", "a pressing lid"))
    if any(phase.get("cell", {}).get("boundary") for phase in made.deck["phases"]):
        raise watch.Refused("only disks that cross an edge take part in its motion")
    deck, n, looks = made.deck, len(made.deck["disks"]), []
    edges = watch.edges_of(deck)
    other = maps.mapped(maps.shifted(0.53 * edges[0], 0.41 * edges[1]), deck)
    other["box"] = copy.deepcopy(deck["box"])
    for which in deck, maps.into_box(other):
        looks.append(watch.follow(which, 300, EVERY))
        for look in looks[-1]:
            look["torque"] = look["torque"][:n]  # that on a wall is about its pivot, wherever the image
    watch.same(*looks, NEAR, KINDS[:-1] if made.has["phases"] in DEFORMING else watch.FREE, EVERY)


def order(seed):
    """Disks in another order, and walls: sums are rounded otherwise."""
    deck = of_equal_strength(draw(seed, without("motion", "random")).deck)
    n, walls = len(deck["disks"]), len(deck.get("walls", ()))
    other = copy.deepcopy(deck)
    other["disks"].reverse()
    if walls:
        other["walls"].reverse()
    found = watch.follow(other, 300, EVERY)
    for look in found:
        for kind, values in look.items():
            if kind != "energy":
                look[kind] = np.concatenate([values[:n][::-1], values[n:n + walls][::-1], values[n + walls:]])
    watch.same(watch.follow(deck, 300, EVERY), found, NEAR, every=EVERY)


def phases(seed):
    """Phases in parts, but for those that end at a goal: the same bits."""
    deck = draw(seed, without("motion", "switched"), phases=("until",)).deck
    other = copy.deepcopy(deck)
    other["phases"] = []
    for phase in deck["phases"]:
        goal = {"settle", "compress"} & set(phase)
        parts = [{**phase, "steps": steps} for steps in ([phase["steps"]] if goal else (33, 29, phase["steps"] - 62))]
        for part in parts[1:]:  # forces are evaluated anew where disks are held and released
            part.pop("hold", None), part.pop("release", None)
            if "bond" in part:
                part["bond"] = {"sinter": part["bond"].get("sinter", False), "begin": False}
        other["phases"] += parts
    watch.same(watch.follow(deck, 300, EVERY), watch.follow(other, 300, EVERY), 0.0, every=EVERY)


def rain(seed):
    """Rain elsewhere falls in the same way."""
    deck = decks.make(seed, {"bodies later": ("rain",), "materials": ("one",)}).deck
    n, steps = len(deck["disks"]) + deck["packings"][0]["count"], 800
    deck["phases"] = [{"steps": steps}]
    deck["packings"][0]["y"] = [deck["container"]["origin"][1] + y for y in (0.003, deck["container"]["height"])]  # clear of the floor
    other = maps.mapped(maps.shifted(1.0, 2.0), deck)
    other["packings"][0]["y"] = [y + 2.0 for y in deck["packings"][0]["y"]]
    looks = [in_any_frame(watch.follow(which, steps, 100), n) for which in (deck, other)]
    watch.same(*looks, 10 * NEAR, KINDS, 100)


TINY = 1e-60
ZEROS = {
    "friction of 0": ({"friction": ("smooth",)}, {"k_t": 1e3, "mu": 0.0}),
    "no tangential spring": ({"friction": ("smooth",)}, {"mu": 0.5}),
    "no rolling friction": ({"rolling": ("none",)}, {"k_r": 500.0, "mu_r": 0.0}),
    "tiny rolling": ({"rolling": ("none",)}, {"k_r": TINY, "gamma_r": TINY, "mu_r": 0.5}),
    "tiny tangential dashpot": ({"friction": ("spring", "stuck", "mindlin", "kinetic", "critical")}, {"gamma_t": TINY}),
    "tiny viscosity": ({"damping": ("elastic", "restitution", "pulls")}, {"gamma_n": TINY}),
    "restitution of 1": ({"damping": ("elastic", "viscous")}, {"restitution": 1.0}),
    "kinetic friction as static": ({"friction": ("spring", "stuck", "dashpot", "mindlin", "critical")}, {"mu_kinetic": "mu"}),
    "tiny critical load": ({"friction": ("spring", "stuck", "dashpot", "mindlin", "kinetic")}, {"critical_load": TINY}),
    "critical load beyond all forces": ({"friction": ("smooth",)}, {"k_t": 1e3, "mu": 0.5, "critical_load": 1e9}),
}
ATTRACTIONS = {
    "tiny cohesion": ({"cohesion": ("none",)}, {"cohesion": "constant", "pull_off": TINY, "range": 3e-3}),
    "tiny bridge": ({"cohesion": ("none",)}, {"cohesion": "bridge", "pull_off": TINY, "range": 3e-3, "rupture": 6e-3}),
}


def zero(seed, cases=None, kinds=tuple(watch.SCALES), **unsuited):
    """Parts of a law that are zero, or all but zero, and no such parts. Servos take means over the shortest period of all springs."""
    only, keys = list((cases or ZEROS).values())[seed % len(cases or ZEROS)]
    deck = draw(seed, {**only, **without("motion", "servo")}, also=("moduli", "a pressing lid"), **unsuited).deck
    other = copy.deepcopy(deck)
    for law in other["materials"] + other.get("material_pairs", []):
        law.update({key: law[value] if isinstance(value, str) and value in law else value for key, value in keys.items()})
    watch.same(watch.follow(deck, 300, EVERY), watch.follow(other, 300, EVERY), NEAR, kinds, every=EVERY)


def attraction(seed):
    """All but no attraction, and none: touch of pairs that are closed before is touch. Their losses differ by an order of dt, since the
    way of the step of touch is known where there was a contact before; bonds that sinter do so where the contact begins."""
    zero(seed, ATTRACTIONS, [kind for kind in watch.SCALES if kind != "energy"], phases=("relax", "settle", *DEFORMING), bond=("sinter",))


def idle(seed):
    """Things without effect beside a deck without them: fields, gravity, motions, forces of 0, what stands far away."""
    deck = decks.make(seed, {"field": ("none",), "gravity": ("none",), "box": ("open",), "bond": BONDS,
                             "motion": ("none", "push", "spin", "wave", "belt", "lead", "load", "servo", "table")}).deck
    other = copy.deepcopy(deck)
    still = [d["name"] for d in other["disks"] if d.get("fixed")]
    material = {} if len(other["materials"]) == 1 else {"material": "steel"}
    additions = {
        "drag": lambda: other.update(fields=[{"type": "drag", "gamma": 0.0}]),
        "damping": lambda: other.update(fields=[{"type": "damping", "alpha": 0.0}]),
        "central": lambda: other.update(fields=[{"type": "central", "strength": 0.0}]),
        "rotation": lambda: other.update(fields=[{"type": "rotation", "omega": 0.0}]),
        "gravity": lambda: other.update(gravity={"g": 0.0, "tilt": 0.3}),
        "forces": lambda: other.update(forces=[{"disk": "disk0", "force": [0.0, 0.0], "torque": 0.0}]),
        "wall": lambda: other.setdefault("walls", []).append({"type": "segment", "points": [[5.0, 5.0], [6.0, 5.0]], **material}),
        "box": lambda: other.update(box={"x": [-3.0, 3.0], "y": [-4.0, 4.0], "periodic": "xy"}),
        "still": lambda: [other.setdefault("motions", []).append({"disk": name, "coordinate": c, "type": "velocity", "velocity": 0.0})
                          for name in still for c in ("x", "theta")],
    }
    names = list(additions)
    additions[names[seed % len(names)]]()
    n = len(deck["disks"]) + len(deck.get("walls", ()))
    found = [{kind: v if kind == "energy" else v[:n] for kind, v in look.items()} for look in watch.follow(other, 300, EVERY)]
    watch.same(watch.follow(deck, 300, EVERY), found, NEAR, every=EVERY)


BOOST = np.array([0.71, -0.43])


def boosted(deck):
    other = copy.deepcopy(deck)
    held = [("wall", w["name"]) for w in other.get("walls", ())] + [("disk", d["name"]) for d in other["disks"] if d.get("fixed")]
    for disk in other["disks"]:
        for name, value in zip(("vx", "vy"), BOOST):
            if name in disk:
                disk[name] += float(value)
    members = {name for clump in other.get("clumps", ()) for name in clump["disk"]}
    led = {(kind, m[kind], m["coordinate"]) for m in other.get("motions", ()) for kind in ("disk", "clump", "wall") if kind in m}
    for clump in other.get("clumps", ()):
        clump["velocity"] = [float(v if ("clump", clump["name"], c) in led else v + u)
                             for c, v, u in zip("xy", clump["velocity"], BOOST)]
    motions = other.setdefault("motions", [])
    wanted = {(kind, name, c) for kind, name in held for c in "xy"} | {key for key in led if key[2] in "xy"}
    for k, (kind, name, c) in enumerate(sorted(wanted)):
        motions.append({"name": f"boost{k}", kind: name, "coordinate": c, "type": "velocity", "velocity": float(BOOST["xy".index(c)])})
    assert not members & {d["name"] for d in other["disks"] if d.get("fixed")}
    for phase in other["phases"]:
        if "motions" in phase:
            phase["motions"] = phase["motions"] + [f"boost{k}" for k in range(len(wanted))]
    return other


def boost(seed):
    """All that happens in a frame that moves steadily."""
    walls = without("walls", "side")["walls"] if seed % 2 else ("none",)
    deck = decks.make(seed, {"field": ("none",), "walls": walls, "box": ("open",) if seed % 2 else ("open", "x", "y", "xy"),
                             "bodies": ("free", "held", "inertia", "forces", "clumps"), "bond": BONDS,
                             **without("motion", "load", "servo")}).deck
    if "motions" in deck or "walls" in deck or any("fixed" in d for d in deck["disks"]):
        for disk in deck["disks"]:  # prescribed bodies have no velocity at step 0 yet: nothing touches them then
            disk["radius"] *= 0.92
    seen, found = watch.follow(deck, 300, EVERY), watch.follow(boosted(deck), 300, EVERY)
    for k, look in enumerate(found):
        look["place"] = look["place"] - BOOST * (k * EVERY * decks.DT)
        look["velocity"] = look["velocity"] - BOOST
    for look in seen + found:
        look["energy"] = look["energy"][INNER]
    watch.same(seen[1:], found[1:], NEAR, every=EVERY)  # motions begin after step 0


def reverse(seed):
    """Without losses and with velocity Verlet the way back is the way there."""
    made = decks.make(seed, {"damping": ("elastic",), "friction": ("smooth",), "rolling": ("none",), "cohesion": ("none", "constant"),
                             "motion": ("none",), "field": ("none", "central"), "integrator": ("verlet",)})
    deck = made.deck
    sim = watch.simulation(deck)
    start = watch.look(sim, deck)
    watch.advance(sim, 300)
    back = copy.deepcopy(deck)
    state, columns = sim.disks, sim.columns
    members = {name for clump in deck.get("clumps", ()) for name in clump["disk"]}
    for k, disk in enumerate(back["disks"]):
        disk.update({name: float(state[name][k]) for name in "xy"}, theta=float(state["angle"][k]))
        for name in ("vx", "vy", "omega") if disk["name"] not in members else ():
            if name in disk:
                disk[name] = -float(state[name][k])
    for k, clump in enumerate(back.get("clumps", ())):
        clump.update(velocity=[-float(columns["clump_vx"][k]), -float(columns["clump_vy"][k])], omega=-float(columns["clump_omega"][k]))
    sim = watch.simulation(back)
    watch.advance(sim, 300)
    end = watch.look(sim, back)
    for name in "velocity", "spin":
        end[name] = -end[name]
    edges = watch.edges_of(deck)
    way = end["place"] - start["place"]
    end["place"] = start["place"] + way - np.where(edges > 0, edges * np.round(way / np.where(edges > 0, edges, 1.0)), 0.0)
    watch.same([start], [end], 10 * NEAR, ("place", "velocity", "angle", "spin", "force"))
