"""One system said in several ways: disks that come later, forces of a program, clumps of one disk."""
import copy

import numpy as np

from . import decks, symmetries, watch

EVERY = symmetries.EVERY
NEAR = symmetries.NEAR
without = symmetries.without


def later(seed):
    """A disk that is added before the first step, clear of others; another that stands far away and is taken out."""
    made = decks.make(seed, {"bodies": ("free", "held"), "box": ("open",), "gravity": ("none",), "field": ("none", "damping"),
                             **without("walls", "drum", "box")})
    deck = copy.deepcopy(made.deck)
    last = len(deck["disks"]) - 1
    named = {m.get("disk") for m in deck.get("motions", ())}
    disk = deck["disks"][last]
    if disk.get("fixed") or disk["name"] in named:
        raise watch.Refused("the last disk is held")
    disk["radius"] *= 0.8  # a disk that comes has no acceleration yet
    seen = watch.follow(deck, 300, EVERY)
    other = copy.deepcopy(deck)
    del other["disks"][last]
    sim = watch.simulation(other)
    keys = {key: value for key, value in disk.items() if key not in ("name", "group")}
    if "material" in keys:
        keys["material"] = ("grain", "steel").index(keys["material"])
    sim.add_disks(**keys)
    more = {key: keys[key] for key in ("radius", "density", "material") if key in keys}
    far = sim.add_disks(x=7.0, y=7.0, **more)
    found = []
    for k in range(300 // EVERY + 1):
        if k:
            watch.advance(sim, EVERY)
        if k == 4:
            sim.remove_disks(far)
        found.append(watch.look(sim, deck))
    n, walls = len(deck["disks"]), len(deck.get("walls", ()))
    rows = np.r_[np.arange(n), np.arange(n + 1, n + 1 + walls)].astype(int)
    found = [{kind: v if kind == "energy" else v[rows] for kind, v in look.items()} for look in found]
    kinds = ("place", "angle", "velocity", "spin", "force", "torque")
    watch.same(seen[1:], found[1:], NEAR, kinds, EVERY)


def forced(seed):
    """Gravity and constant forces of the deck, and the same from a function of the program."""
    deck = decks.make(seed, {"gravity": ("down", "oblique"), "bodies": ("forces", "inertia"), "field": ("none", "drag", "central"),
                             "bond": symmetries.BONDS, **without("motion", "load")}).deck
    other = copy.deepcopy(deck)
    gravity = other.pop("gravity")
    g, tilt = gravity["g"], gravity.get("tilt", 0.0)
    forces = [other["disks"][k].pop("force", (0.0, 0.0)) + [other["disks"][k].pop("torque", 0.0)]
              if "force" in other["disks"][k] else [0.0, 0.0, 0.0] for k in range(len(other["disks"]))]
    forces = np.array(forces)
    sim = watch.simulation(other)

    @sim.add_force
    def push(c):
        n, own = c.n_free, c.id[:c.n_free]
        c.force_x += forces[own, 0] - c.mass[:n] * g * np.sin(tilt)
        c.force_y += forces[own, 1] - c.mass[:n] * g * np.cos(tilt)
        c.torque += forces[own, 2]

    found = [watch.look(sim, other)]
    for _ in range(300 // EVERY):
        watch.advance(sim, EVERY)
        found.append(watch.look(sim, other))
    watch.same(watch.follow(deck, 300, EVERY), found, NEAR, ("place", "angle", "velocity", "spin", "force", "torque"), EVERY)


def lone(seed):
    """Clumps of one disk each are disks."""
    deck = decks.make(seed, {"bodies": ("free", "held"), "bond": symmetries.BONDS, **without("motion", "lead a clump")}).deck
    other = copy.deepcopy(deck)
    named = {m.get("disk") for m in other.get("motions", ())}
    other["clumps"] = []
    for disk in other["disks"]:
        if disk.get("fixed") or disk["name"] in named or len(other["clumps"]) == 3:
            continue
        other["clumps"].append({"name": f"clump of {disk['name']}", "disk": [disk["name"]],
                                "velocity": [disk.pop("vx"), disk.pop("vy")], "omega": disk.pop("omega")})
    watch.same(watch.follow(deck, 300, EVERY), watch.follow(other, 300, EVERY), NEAR, every=EVERY)


def budget(seed):
    """Energies close, up to what the time step leaves."""
    deck = decks.make(seed, {"bond": symmetries.BONDS, **without("field", "damping")}).deck
    sim = watch.simulation(deck)
    watch.advance(sim, 300)
    energy = sim.energy
    if not abs(energy["residual"]) <= 5e-3 * energy["scale"]:
        raise watch.Wrong(f"the residual is {energy['residual'] / energy['scale']:.2g} of the scale")
    lost = [name for name in ("viscous", "friction", "rolling", "bridge", "drag") if energy[name] < -1e-3 * energy["scale"]]
    if lost and deck["integrator"] == "verlet":
        raise watch.Wrong(f"losses below 0: {lost}")


def loaded(seed):
    """A wall under a load obeys its own equation of motion."""
    made = decks.make(seed, {"motion": ("load",), "bond": symmetries.BONDS, **without("walls", "none", "pillar", "hump")})
    deck = made.deck
    motion = deck["motions"][0]
    wall = next(k for k, w in enumerate(deck["walls"]) if w["name"] == motion["wall"])
    c, mass = motion["coordinate"], motion["mass"]
    gravity = deck.get("gravity", {"g": 0.0})
    pull = -gravity["g"] * (np.sin if c == "x" else np.cos)(gravity.get("tilt", 0.0))
    sim = watch.simulation(deck)
    last = None
    for step in range(1, 120):
        watch.advance(sim, 1)
        speed = float(sim.walls[f"v{c}"][wall])
        push = (float(sim.walls[f"force_{c}"][wall]) + motion["force"]) / mass + pull
        if last is not None and step > 2:
            got, expected = (speed - last[0]) / decks.DT, (push + last[1]) / 2
            if not abs(got - expected) <= 1e-7 * max(1.0, abs(push), abs(last[1])):
                raise watch.Wrong(f"at step {step} the wall accelerates by {got:.9g}, its forces give {expected:.9g}")
        last = speed, push
