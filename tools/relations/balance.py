"""Momentum and angular momentum at every step: forces from contacts, accelerations from forces, sums over all bodies."""
import numpy as np

from . import decks, geometry, symmetries, watch

STEPS = 90
NEAR = 1e-9
GEAR = 251 / 360


def law_of(deck, a, b):
    if len(deck["materials"]) == 1:
        return deck["materials"][0]
    bodies = deck["disks"] + deck.get("walls", [])
    names = [bodies[k]["material"] for k in (a, b)]
    if names[0] != names[1]:
        return deck["material_pairs"][0]
    return next(law for law in deck["materials"] if law["name"] == names[0])


class Moment:
    """Columns after a step, by number of the body; clumps by theirs."""
    BODY = ("x", "y", "angle", "vx", "vy", "omega", "force_x", "force_y", "torque")
    FREE = ("x2", "y2", "theta2", "x3", "y3", "theta3", "x4", "y4", "theta4", "x5", "y5", "theta5", "field_x", "field_y",
            "field_torque")

    def __init__(self, sim):
        disks, walls, columns = sim.disks, sim.walls, sim.columns
        self.all = {name: np.concatenate([disks[name], walls[name]]).astype(float) for name in self.BODY}
        self.free = {name: np.asarray(disks[name], float) for name in self.FREE if name in columns}
        self.clump = {name[6:]: np.array(columns[name], float) for name in columns if name.startswith("clump_")}
        self.clump["angle"] = self.clump["theta"] + self.clump["turn"]
        self.contacts = sim.contacts
        self.poses = np.stack([self.all["x"], self.all["y"], self.all["angle"]], 1)


def predicted(moment, dt, clump=False):
    """Poses at which a Gear step evaluates contacts, of bodies that are not led."""
    values = moment.clump if clump else {**moment.all, **moment.free}
    rows = []
    for place, speed, name in (("x", "vx", "x"), ("y", "vy", "y"), ("angle", "omega", "theta")):
        n = len(values[f"{name}2"])
        rows.append(values[place][:n] + dt * values[speed][:n] + sum(np.nan_to_num(values[f"{name}{k}"]) for k in (2, 3, 4, 5)))
    return np.stack(rows, 1)


class Bodies:
    """What moves how: coordinates that forces move, of disks and clumps."""

    def __init__(self, deck):
        self.deck, self.members = deck, [[int(name[4:]) for name in c["disk"]] for c in deck.get("clumps", ())]
        self.names = [d["name"] for d in deck["disks"]]
        self.members = [[self.names.index(f"disk{k}") for k in m] for m in self.members]
        self.in_clump = {k for m in self.members for k in m}
        led = [(m.get("disk", m.get("clump")), m["coordinate"]) for m in deck.get("motions", ())]
        self.moves = {}
        for k, disk in enumerate(deck["disks"]):
            held = set("xy") | {"theta"} if disk.get("fixed") else set(disk.get("locked", ()))
            self.moves[k] = [c for c in ("x", "y", "theta") if c not in held and (disk["name"], c) not in led]
        self.clump_moves = [[c for c in ("x", "y", "theta") if (clump["name"], c) not in led] for clump in deck.get("clumps", ())]

    def poses(self, before, now, dt):
        """At which the forces of the step act."""
        poses = now.poses.copy()
        if self.deck["integrator"] != "gear5":
            return poses
        ahead = predicted(before, dt)
        for k, moves in self.moves.items():
            for c in moves if k not in self.in_clump else ():
                poses[k]["x y theta".split().index(c)] = ahead[k]["x y theta".split().index(c)]
        if self.members:
            self.place_clumps(poses, before, now, predicted(before, dt, True))
        return poses

    def place_clumps(self, poses, before, now, ahead):
        at = np.stack([now.clump["x"], now.clump["y"], now.clump["angle"]], 1)
        start = np.stack([before.clump["x"], before.clump["y"], before.clump["angle"]], 1)
        edges = watch.edges_of(self.deck)
        for number, members in enumerate(self.members):
            pose = at[number].copy()
            for c in self.clump_moves[number]:
                pose["x y theta".split().index(c)] = ahead[number]["x y theta".split().index(c)]
            turn = pose[2] - start[number][2]
            for k in members:
                o = before.poses[k][:2] - start[number][:2]
                o = o - np.where(edges > 0, edges * np.round(o / np.where(edges > 0, edges, 1.0)), 0.0)
                c, s = np.cos(turn), np.sin(turn)
                poses[k][:2] = pose[0] + c * o[0] - s * o[1], pose[1] + s * o[0] + c * o[1]
                poses[k][2] = before.poses[k][2] + turn


def forces_of(scene, deck, moment, poses):
    """[body][x, y, torque about the body's own point] from rows of contacts; torque on straight walls about the pivot."""
    sums = np.zeros((len(poses), 3))
    names = moment.contacts.dtype.names
    for row in moment.contacts:
        a, b = int(row["a"]), int(row["b"])
        n, lever, arm, other, way = scene.contact(row, poses)
        tau = row["tau"] if "tau" in names else -law_of(deck, a, b).get("k_t", 0.0) * row["zeta"]
        couple = row["roll"] * arm if "roll" in names else 0.0
        force = -row["force"] * n + tau * lever * np.array([-n[1], n[0]])
        radius = scene.radii[a]
        sums[a] += [*force, tau * radius + couple]
        on_b = tau * other - couple
        if other == 0.0:  # the arm from the pivot to the disk's centre
            on_b = -(way[0] * force[1] - way[1] * force[0]) - tau * radius - couple
        sums[b] += [-force[0], -force[1], on_b]
    return sums


def compare(step, what, got, expected, scale):
    far = np.abs(np.asarray(got) - np.asarray(expected)) / scale
    if far.size and not far.max() <= NEAR:
        where = np.unravel_index(np.nanargmax(far), far.shape)
        raise watch.Wrong(f"{what} of {where} at step {step}: {np.asarray(got)[where]:.10g}, expected {np.asarray(expected)[where]:.10g}")


def gravity_of(deck):
    gravity = deck.get("gravity", {})
    g, tilt = gravity.get("g", 0.0), gravity.get("tilt", 0.0)
    return np.array([-g * np.sin(tilt), -g * np.cos(tilt), 0.0])


def driving(deck, moment, masses):
    """[disk][x, y, theta] forces of all but contacts."""
    n = len(deck["disks"])
    found = gravity_of(deck) * masses
    for k, disk in enumerate(deck["disks"]):
        found[k] += [*disk.get("force", (0.0, 0.0)), disk.get("torque", 0.0)]
    if "field_x" in moment.free:
        for c, name in enumerate(("field_x", "field_y", "field_torque")):
            found[:, c] += np.nan_to_num(moment.free[name][:n])
    return found


def gain(before, now, names, dt, gear):
    """Velocity that the step has added, but for that of the old acceleration, and what the rule makes of a new acceleration:
    v1 = `rest` + `factor` a1."""
    x2, x3, x4, x5 = (np.nan_to_num(before[f"{names[0]}{k}"]) for k in (2, 3, 4, 5))
    n = len(x2)
    speed = before[names[1]][:n]
    if not gear:
        return speed + x2 / dt, dt / 2
    q2 = x2 + 3 * x3 + 6 * x4 + 10 * x5
    return speed + (2 * x2 + 3 * x3 + 4 * x4 + 5 * x5) / dt - GEAR / dt * q2, GEAR * dt / 2


def accelerations(deck, bodies, before, now, masses):
    """m a of every free coordinate of single disks, from the velocities before and after the step."""
    n, gear = len(deck["disks"]), deck["integrator"] == "gear5"
    found = np.full((n, 3), np.nan)
    old, new = {**before.all, **before.free}, now.all
    for c, names in enumerate((("x", "vx"), ("y", "vy"), ("theta", "omega"))):
        rest, factor = gain(old, new, names, decks.DT, gear)
        found[:, c] = masses[:, c] * (new[names[1]][:n] - rest) / factor
    for k in range(n):
        for c, name in enumerate(("x", "y", "theta")):
            if k in bodies.in_clump or name not in bodies.moves[k]:
                found[k, c] = np.nan
    return found


def clump_accelerations(deck, bodies, before, now):
    """The same of clumps, but for mass and inertia."""
    found = np.full((len(bodies.members), 3), np.nan)
    for c, names in enumerate((("x", "vx"), ("y", "vy"), ("theta", "omega"))):
        rest, factor = gain(before.clump, now.clump, names, decks.DT, deck["integrator"] == "gear5")
        value = (now.clump[names[1]] - rest) / factor
        for number, moves in enumerate(bodies.clump_moves):
            if names[0] in moves:
                found[number, c] = value[number]
    return found


def balance_of_clumps(step, deck, bodies, before, now, poses, total, masses):
    """Sums over the disks of a clump, with their levers."""
    if not bodies.members or any(f["type"] == "damping" for f in deck.get("fields", ())):
        return
    got = clump_accelerations(deck, bodies, before, now)
    edges = watch.edges_of(deck)
    for number, members in enumerate(bodies.members):
        mass = masses[members, 0]
        first = poses[members[0]][:2]
        way = poses[members][:, :2] - first
        way = way - np.where(edges > 0, edges * np.round(way / np.where(edges > 0, edges, 1.0)), 0.0)
        arm = way - mass @ way / mass.sum()
        inertia = (masses[members, 2] + mass * (arm ** 2).sum(1)).sum()
        force = total[members]
        torque = (force[:, 2] + arm[:, 0] * force[:, 1] - arm[:, 1] * force[:, 0]).sum()
        expected = np.array([force[:, 0].sum(), force[:, 1].sum(), torque])
        value = got[number] * [mass.sum(), mass.sum(), inertia]
        moving = ~np.isnan(value)
        compare(step, f"m a of clump {number}", value[moving], expected[moving], 10.0)


def total_of(deck, now):
    """Sum of contact forces over all bodies, and of torques about the origin."""
    force = np.stack([now.all["force_x"], now.all["force_y"]], 1)
    torque = now.all["torque"] + now.poses[:, 0] * force[:, 1] - now.poses[:, 1] * force[:, 0]
    return [*force.sum(0), torque.sum()]


def balance(seed):
    """Forces on bodies are the sums of those of their contacts; they add up to zero, as do torques; m a is force + fields + gravity."""
    deck = decks.make(seed, {"bond": symmetries.BONDS}).deck
    for disk in deck["disks"]:
        disk["mass"] = disk.pop("density") * np.pi * disk["radius"] ** 2
    sim = watch.simulation(deck)
    scene, bodies = geometry.Scene(deck, watch.edges_of(deck)), Bodies(deck)
    masses = np.array([[d["mass"], d["mass"], d.get("inertia", d["mass"] * d["radius"] ** 2 / 2)] for d in deck["disks"]])
    before = Moment(sim)
    for step in range(1, STEPS + 1):
        watch.advance(sim, 1)
        now = Moment(sim)
        poses = bodies.poses(before, now, decks.DT)
        sums = forces_of(scene, deck, now, poses)
        compare(step, "force", np.stack([now.all["force_x"], now.all["force_y"], now.all["torque"]], 1), sums, [10.0, 10.0, 1.0])
        n = len(deck["disks"])
        total = sums[:n] + driving(deck, now, masses)
        got = accelerations(deck, bodies, before, now, masses)
        moving = ~np.isnan(got)
        compare(step, "m a", np.where(moving, got, 0), np.where(moving, total, 0), [10.0, 10.0, 1.0])
        balance_of_clumps(step, deck, bodies, before, now, poses, total, masses)
        if "box" not in deck and not scene.paper and deck["integrator"] == "verlet":
            compare(step, "total", total_of(deck, now), np.zeros(3), 1.0)
        before = now
