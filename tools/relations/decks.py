"""Decks at random over all pairs of features: rows of a table per dimension, of which each deck takes one. Rows of added.py change a deck
that is made, and say which rows it may have.

A deck is a dict with the structure of a deck. The same number gives the same deck, so that any trial can be repeated alone."""
import dataclasses
import math
import random

DT = 5e-5           # about 80 steps per contact
SPACING = 0.1       # of the lattice on which disks start
WALL = 0.002        # walls stand so far from the disks, or overlap them by half as much
FEATURES = {}       # dimension: {name: function that adds it}
ONLY = {}           # (dimension, name): {dimension: rows that a deck with this row may have}, of added rows
LAST = None         # the deck that was made last, for those who report


class Unsuitable(Exception):
    """This row cannot join what the deck has."""


def feature(dimension, name):
    def keep(function):
        FEATURES.setdefault(dimension, {})[name] = function
        return function
    return keep


def added(dimension, name, **only):
    """A row that changes a finished deck: function(random, deck)."""
    ONLY[dimension, name] = only
    return feature(dimension, name)


def plain(dimension, *names):
    """Rows that add nothing of their own."""
    for name in names:
        FEATURES.setdefault(dimension, {})[name] = lambda b: None


@dataclasses.dataclass
class Builder:
    """A deck that is being made. Disks, walls, motions and fields are lists of dicts."""
    random: random.Random
    has: dict = dataclasses.field(default_factory=dict)       # dimension: row
    allowed: dict = dataclasses.field(default_factory=dict)   # dimension: rows
    disks: list = dataclasses.field(default_factory=list)
    walls: list = dataclasses.field(default_factory=list)
    materials: list = dataclasses.field(default_factory=list)
    motions: list = dataclasses.field(default_factory=list)
    fields: list = dataclasses.field(default_factory=list)
    clumps: list = dataclasses.field(default_factory=list)
    phases: list = dataclasses.field(default_factory=list)
    top: dict = dataclasses.field(default_factory=dict)       # keys of the deck itself
    steps: int = 300
    shape: tuple = (3, 3)                                     # columns and rows of disks

    def near(self, size, share=0.5):
        """A length near `size`."""
        return size * self.random.uniform(1 - share, 1 + share)

    def sign(self):
        return self.random.choice((-1.0, 1.0))

    def edge(self, axis, side):
        """Where the disks end, and a wall can stand."""
        ends = [d["xy"[axis]] + side * d["radius"] for d in self.disks]
        return (max(ends) if side > 0 else min(ends)) + side * self.random.uniform(-WALL / 2, WALL)

    def wall(self, kind, **keys):
        self.walls.append({"name": f"wall{len(self.walls)}", "type": kind, **keys})

    def target(self):
        """Of a motion: a wall, or a disk where there is none."""
        if self.walls:
            return {"wall": self.random.choice(self.walls)["name"]}
        return {"disk": self.led()["name"]}

    def led(self):
        """A disk of its own, which motions may lead."""
        members = {name for clump in self.clumps for name in clump["disk"]}
        return self.random.choice([d for d in self.disks if d["name"] not in members and not {"locked", "fixed"} & set(d)])

    def move(self, coordinate, kind, target=None, **keys):
        target = target or self.target()
        self.motions.append({"name": f"motion{len(self.motions)}", **target, "coordinate": coordinate, "type": kind, **keys})
        for disk in self.disks:  # which has no velocity of its own there
            if disk["name"] == target.get("disk"):
                disk.pop({"theta": "omega"}.get(coordinate, f"v{coordinate}"), None)
        for clump in self.clumps:
            if clump["name"] == target.get("clump") and coordinate == "theta":
                del clump["omega"]
            elif clump["name"] == target.get("clump"):
                clump["velocity"]["xy".index(coordinate)] = 0.0


def lattice(b):
    columns, rows = b.shape
    for k in range(columns * rows):
        b.disks.append({
            "name": f"disk{k}", "group": f"group{k % 2}", "radius": b.near(0.0475, 0.07), "density": 1.0,
            "x": (k % columns - (columns - 1) / 2) * SPACING + b.random.uniform(-3e-3, 3e-3),
            "y": (k // columns - (rows - 1) / 2) * SPACING + b.random.uniform(-3e-3, 3e-3),
            "theta": b.random.uniform(-3, 3), "vx": b.random.uniform(-0.6, 0.6), "vy": b.random.uniform(-0.6, 0.6),
            "omega": b.random.uniform(-12, 12)})


plain("bodies", "free")


@feature("bodies", "held")
def held(b):
    disk = b.random.choice(b.disks)
    disk["fixed"] = True
    for name in "vx", "vy", "omega":
        del disk[name]


@feature("bodies", "locked")
def locked(b):
    for disk, names in zip(b.random.sample(b.disks, 2), (["theta"], [b.random.choice("xy")])):
        disk["locked"] = names
        for name in names:
            del disk[{"theta": "omega", "x": "vx", "y": "vy"}[name]]


@feature("bodies", "inertia")
def inertia(b):
    for disk in b.random.sample(b.disks, 4):
        disk["inertia"] = b.near(1.5e-5)


@feature("bodies", "forces")
def forces(b):
    for disk in b.random.sample(b.disks, 4):
        disk.update(force=[b.random.uniform(-0.3, 0.3), b.random.uniform(-0.3, 0.3)], torque=b.random.uniform(-5e-3, 5e-3))


@feature("bodies", "clumps")
def clumps(b):
    for number, members in enumerate(((0, 1), (5, 8, 7))):
        for k in members:
            for name in "vx", "vy", "omega":
                del b.disks[k][name]
        b.clumps.append({"name": f"clump{number}", "disk": [f"disk{k}" for k in members], "omega": b.random.uniform(-3, 3),
                         "velocity": [b.random.uniform(-0.6, 0.6), b.random.uniform(-0.6, 0.6)]})


LAWS = {
    "normal": {"linear": lambda b: {"k_n": b.near(2e3)}, "hertz": lambda b: {"law": "hertz", "k_n": b.near(4e4)}},
    "damping": {"elastic": lambda b: {}, "viscous": lambda b: {"gamma_n": b.near(0.6)},
                "restitution": lambda b: {"restitution": b.random.uniform(0.4, 0.9)},
                "pulls": lambda b: {"restitution": b.random.uniform(0.4, 0.9), "limit_damping": False}},
    "friction": {"smooth": lambda b: {}, "spring": lambda b: {"k_t": b.near(1.2e3), "mu": b.near(0.3)},
                 "stuck": lambda b: {"k_t": b.near(1.2e3), "mu": 50.0},
                 "dashpot": lambda b: {"k_t": b.near(1.2e3), "gamma_t": b.near(0.3), "mu": b.near(0.3)},
                 "mindlin": lambda b: {"tangential": "mindlin", "k_t": b.near(3e4), "mu": b.near(0.3)},
                 "kinetic": lambda b: {"k_t": b.near(1.2e3), "mu": 0.5, "mu_kinetic": b.near(0.3)},
                 "critical": lambda b: {"k_t": b.near(1.2e3), "mu": 0.5, "critical_load": b.near(0.4)}},
    "rolling": {"none": lambda b: {}, "spring": lambda b: {"k_r": b.near(500), "mu_r": b.near(0.1)},
                "dashpot": lambda b: {"k_r": b.near(500), "gamma_r": b.near(0.1), "mu_r": b.near(0.1)},
                "drag": lambda b: {"drag_r": b.near(0.1)}},
    "cohesion": {"none": lambda b: {},
                 "constant": lambda b: {"cohesion": "constant", "pull_off": b.near(0.2), "range": b.near(3e-3)},
                 "bridge": lambda b: {"cohesion": "bridge", "pull_off": b.near(0.2), "range": b.near(3e-3),
                                      "rupture": b.near(6e-3)}},
}
for dimension, rows in LAWS.items():
    plain(dimension, *rows)


def law(b, kinds=None):
    keys = {}
    for dimension, rows in LAWS.items():
        keys.update(rows[(kinds or b.has)[dimension]](b))
    return keys


plain("materials", "one", "two", "of other laws")


def materials(b):
    b.materials.append({"name": "grain", **law(b)})
    if b.has["materials"] == "one":
        return

    def more():
        if b.has["materials"] == "two":
            return law(b)
        kinds = {d: b.random.choice([name for name in rows if name in b.allowed[d]]) for d, rows in LAWS.items()}
        return law(b, kinds)
    b.materials.append({"name": "steel", **more()})
    b.top["material_pairs"] = [{"materials": ["grain", "steel"], **more()}]
    for body in b.disks + b.walls:
        body["material"] = b.random.choice(("grain", "steel"))


plain("walls", "none")


@feature("walls", "line")
def line(b):
    y = b.edge(1, -1)
    b.wall("line", points=[[-0.2, y], [0.2, y]], pivot=[0.03, y])


@feature("walls", "side")
def side(b):
    """In a box that is periodic in x its image is touched from the other side."""
    x = b.edge(0, b.random.choice((-1, 1)))
    b.wall("line", points=[[x, -0.25], [x, 0.25]])


@feature("walls", "tilted")
def tilted(b):
    angle = b.random.uniform(-0.6, 0.6)
    normal = math.sin(angle), -math.cos(angle)
    way = max(d["x"] * normal[0] + d["y"] * normal[1] + d["radius"] for d in b.disks) + b.random.uniform(-WALL / 2, WALL)
    b.wall("segment", points=[[way * normal[0] + s * normal[1], way * normal[1] - s * normal[0]] for s in (-0.25, 0.25)])


@feature("walls", "ends")
def ends(b):
    """Two pieces whose ends stand below the disks."""
    y = b.edge(1, -1)
    b.wall("segment", points=[[-0.25, y - 0.02], [b.random.uniform(-0.07, -0.03), y]])
    b.wall("segment", points=[[b.random.uniform(0.03, 0.07), y], [0.25, y - 0.02]])


@feature("walls", "terrain")
def terrain(b):
    y = b.edge(1, -1)
    heights = [b.random.uniform(0, 0.02) for _ in range(6)]
    b.wall("polyline", points=[[(k - 2.5) * 0.09, y - h] for k, h in enumerate(heights)])


@feature("walls", "box")
def box(b):
    (x0, x1), (y0, y1) = ((b.edge(axis, -1), b.edge(axis, 1)) for axis in (0, 1))
    corners = [[x0, y0], [x1, y0], [x1, y1], [x0, y1]]
    kind = b.random.choice(("line", "segment", "polyline"))
    if kind == "polyline":
        b.wall("polyline", points=corners, closed=True)
        return
    for k in range(4):
        b.wall(kind, points=[corners[k], corners[(k + 1) % 4]])


def around(b):
    return max(math.hypot(d["x"], d["y"]) + d["radius"] for d in b.disks) + b.random.uniform(-WALL / 2, WALL)


@feature("walls", "drum")
def drum(b):
    b.wall("circle", center=[0.0, 0.0], radius=around(b), side="inside")


@feature("walls", "ring")
def ring(b):
    start = b.random.uniform(-3, 3)
    b.wall("arc", center=[0.0, 0.0], radius=around(b), **{"from": start, "to": start + 2 * math.pi})


@feature("walls", "bowl")
def bowl(b):
    b.wall("arc", center=[0.0, 0.0], radius=around(b), **{"from": -2.4, "to": b.random.uniform(-1.2, -0.5)})


def obstacle(b, kind, **keys):
    """In place of the disk in the middle."""
    at = b.disks[len(b.disks) // 2]
    members = {name for clump in b.clumps for name in clump["disk"]}
    if at["name"] in members:
        raise Unsuitable
    b.disks.remove(at)
    b.wall(kind, center=[at["x"], at["y"]], radius=at["radius"] + b.random.uniform(-1e-3, 1e-3), **keys)


@feature("walls", "pillar")
def pillar(b):
    obstacle(b, "circle", side="outside")


@feature("walls", "hump")
def hump(b):
    obstacle(b, "arc", **{"from": b.random.uniform(-1, 0), "to": b.random.uniform(2, 4)})


plain("box", "open", "x", "y", "xy")


def points_of(wall):
    if "points" in wall:
        return [(x, x, y, y) for x, y in wall["points"]]
    (x, y), r = wall["center"], wall["radius"]
    return [(x - r, x + r, y - r, y + r)]


def periodic(b):
    """The box ends where disks and walls do, so that much touches across its edges."""
    if b.has["box"] == "open":
        return
    space = {"periodic": b.has["box"]}
    for axis in (0, 1):
        if "xy"[axis] not in b.has["box"]:
            continue
        ends = [(d["xy"[axis]] - d["radius"], d["xy"[axis]] + d["radius"]) for d in b.disks]
        if b.has["walls"] not in ("line", "side"):
            ends += [p[2 * axis:2 * axis + 2] for wall in b.walls for p in points_of(wall)]
        if b.has["walls"] == "side" and axis == 0:  # touched by the last disks on the other side
            x = b.walls[0]["points"][0][0]
            ends = [(x, x), *((low, high) for low, high in ends if min(abs(low - x), abs(high - x)) > 2 * WALL)]
        low, high = min(e[0] for e in ends), max(e[1] for e in ends)
        margin = {"drum": 0.03, "box": 0.03, "ring": 0.06, "bowl": 0.06}.get(b.has["walls"], 0.0)  # no disk touches two images
        low, high = low - margin, high + margin
        space["xy"[axis]] = [low, high + b.random.uniform(-WALL / 2, WALL)]
    b.top["box"] = space


plain("gravity", "none")


@feature("gravity", "down")
def down(b):
    b.top["gravity"] = {"g": b.near(10.0)}


@feature("gravity", "oblique")
def oblique(b):
    b.top["gravity"] = {"g": b.near(10.0), "tilt": b.random.uniform(-1.2, 1.2)}


plain("motion", "none")


def need_wall(b, *unsuited):
    """A wall that a load or servo may move, or whose surface may run."""
    if not b.walls or b.has["walls"] in unsuited:
        raise Unsuitable


@feature("motion", "push")
def push(b):
    target = b.target()
    for coordinate in "xy":
        b.move(coordinate, "velocity", target, velocity=b.random.uniform(-0.3, 0.3))


@feature("motion", "spin")
def spin(b):
    b.move("theta", "velocity", velocity=b.sign() * b.near(3.0))


@feature("motion", "wave")
def wave(b):
    kind = b.random.choice(("harmonic", "parabolic", "triangle", "square"))
    more = {"rise": 0.6} if kind == "square" else {}
    if b.random.random() < 0.5:
        more.update(ramp=b.near(5e-3), phase=b.random.uniform(0, 3))
    target, coordinate = b.target(), b.random.choice(("x", "y", "theta"))
    b.move(coordinate, kind, target, amplitude=b.sign() * b.near(2e-3), frequency=b.near(50.0), **more)
    if b.random.random() < 0.3:  # two move one coordinate
        b.move(coordinate, "harmonic", target, amplitude=b.sign() * b.near(1e-3), omega=b.near(400.0))


@feature("motion", "belt")
def belt(b):
    need_wall(b, *(("drum", "pillar") if b.has["rolling"] != "none" else ()))
    b.move("surface", "velocity", velocity=b.sign() * b.near(0.5))


@feature("motion", "table")
def table(b):
    values = [0.0, *(b.random.uniform(-1e-3, 1e-3) for _ in range(4))]
    values[1] = 0.0
    b.move(b.random.choice(("x", "y")), "table", times=[0.0, 1e-3, 5e-3, 1e-2, 2e-2], values=values, factor=1.0)


@feature("motion", "random")
def shaken(b):
    more = {"interval": b.random.choice((3, 10))} if b.random.random() < 0.5 else {}
    target = b.target()
    for coordinate in b.random.choice(("x", "y", "xy")):
        b.move(coordinate, "random", target, amplitude=b.near(3e-4), frequency=b.near(40.0), ramp=2e-3, **more)


@feature("motion", "switched")
def switched(b):
    target = b.target()
    b.move(b.random.choice("xy"), "velocity", target, velocity=b.sign() * b.near(0.3))
    b.move("theta", "harmonic", target, amplitude=b.near(4e-3), frequency=b.near(50.0))
    b.phases += [{"steps": 100, "motions": ["motion0"]}, {"steps": 100, "motions": ["motion1"]}, {"steps": 100, "motions": []}]


@feature("motion", "lead")
def lead(b):
    target = {"disk": b.led()["name"]}
    for coordinate in b.random.sample(("x", "y", "theta"), b.random.choice((1, 2, 3))):
        b.move(coordinate, "velocity", target, velocity=b.random.uniform(-0.3, 0.3))


@feature("motion", "lead a clump")
def lead_a_clump(b):
    if not b.clumps:
        raise Unsuitable
    b.move(b.random.choice(("x", "y", "theta")), "velocity", {"clump": "clump1"}, velocity=b.random.uniform(-0.3, 0.3))


@feature("motion", "load")
def load(b):
    need_wall(b, "pillar", "hump")
    b.move(b.random.choice("xy"), "load", mass=b.near(0.03), force=b.random.uniform(-0.3, 0.3))


@feature("motion", "servo")
def servo(b):
    need_wall(b, "pillar", "hump")
    b.move(b.random.choice("xy"), "servo", force=b.sign() * b.near(0.5), speed=b.near(0.3))


plain("field", "none")


@feature("field", "drag")
def drag(b):
    b.fields.append({"name": "air", "type": "drag", "gamma": b.near(0.05), "gamma_rotation": b.near(1e-4),
                     "flow": [b.random.uniform(-1, 1), b.random.uniform(-1, 1)], "swirl": b.random.uniform(-3, 3),
                     "centre": [0.05, -0.02]})


@feature("field", "damping")
def damping(b):
    b.fields.append({"name": "damp", "type": "damping", "alpha": b.random.uniform(0.1, 0.5)})


@feature("field", "central")
def central(b):
    b.fields.append({"name": "pull", "type": "central", "strength": b.near(0.3), "power": b.random.choice((1, -1, 2)),
                     "softening": 0.05, "centre": [0.02, 0.03]})


@feature("field", "rotation")
def rotation(b):
    b.fields.append({"name": "frame", "type": "rotation", "omega": b.sign() * b.near(5.0), "centre": [0.02, 0.03]})


plain("integrator", "verlet", "gear5")
plain("variant", "paper", "conservative")
ORDER = ("normal", "damping", "friction", "rolling", "cohesion", "materials", "bodies", "walls", "box", "gravity", "motion",
         "field", "integrator", "variant")


@dataclasses.dataclass
class Deck:
    has: dict     # dimension: row
    deck: dict
    steps: int
    calls: list   # of the library, as tests/crossing/ways.c reads them

    def text(self, deck_text):
        return "".join(f"# at {call}\n" for call in self.calls) + deck_text(self.deck)

    def pairs(self):
        """All pairs of its features."""
        rows = list(self.has.items())
        return {(rows[i], rows[j]) for i in range(len(rows)) for j in range(i)}


def choose(b, dimension, allowed):
    """A row at random of those that suit."""
    names = [name for name in FEATURES[dimension] if name in allowed]
    b.allowed[dimension] = allowed
    b.random.shuffle(names)
    for name in names:
        b.has[dimension] = name
        try:
            FEATURES[dimension][name](b)
            return
        except Unsuitable:
            continue
    raise Unsuitable


def joined(one, two):
    """{dimension: rows} that both allow, or None."""
    both = dict(one)
    for dimension, rows in two.items():
        both[dimension] = tuple(row for row in both.get(dimension, FEATURES[dimension]) if row in rows)
        if not both[dimension]:
            return None
    return both


def choose_added(r, only):
    """({dimension: row} of the added dimensions that are named, {dimension: rows} that these allow)"""
    has = {}
    dimensions = [name for name in only if name not in ORDER]
    r.shuffle(dimensions)
    for dimension in sorted(dimensions, key=lambda name: len(only[name]) > 1 or "none" in only[name]):  # what must be there comes first
        rows = list(only[dimension])
        r.shuffle(rows)
        both = None
        while both is None and rows:
            has[dimension] = rows.pop()
            both = joined(only, ONLY[dimension, has[dimension]])
        if both is None:
            raise Unsuitable
        only = both
    return has, only


def plain_deck(b, seed, only):
    lattice(b)
    for dimension in ORDER:
        choose(b, dimension, only.get(dimension, FEATURES[dimension]))
    materials(b)
    periodic(b)
    deck = {"dt": DT, "integrator": b.has["integrator"], "contact_variant": b.has["variant"], "seed": 1 + hash_of(seed),
            **b.top, "materials": b.materials, "disks": b.disks}
    for name in "walls", "clumps", "motions", "fields":
        if getattr(b, name):
            deck[name] = getattr(b, name)
    deck["phases"] = b.phases or [{"steps": b.steps}]
    deck["limits"] = {"residual": 0.0, "displacement": 0.0}
    return deck


def attempt(seed, number, only, shape):
    b = Builder(random.Random(f"deck-{seed}-{number}" if number else f"deck-{seed}"), shape=shape)
    has, allowed = choose_added(b.random, only)
    deck = plain_deck(b, seed, allowed)
    names = [disk["name"] for disk in deck["disks"]]
    for dimension in FEATURES:
        if dimension not in has:
            continue
        if dimension not in ("phases", "measure") and len(deck["phases"]) > 1 and "none" in only[dimension]:
            has[dimension] = "none"
        FEATURES[dimension][has[dimension]](b.random, deck)
    if not deck["disks"] and any(f"'{name}'" in repr(deck) for name in names):  # others have come in their place
        raise Unsuitable
    calls = deck.pop("calls", [])
    return Deck({**b.has, **has}, deck, b.steps, calls)


def make(seed, only=None, shape=(3, 3)):
    """The deck of a number. only: {dimension: rows} that are allowed. Where it is silent, all are allowed of bodies, laws, walls, motions, and
    no row is added. shape: columns and rows of disks."""
    global LAST
    for number in range(50):
        try:
            LAST = attempt(seed, number, only or {}, shape)
            return LAST
        except (Unsuitable, ValueError, IndexError):
            continue
    raise ValueError(f"no deck suits {only}")


def hash_of(seed):
    """The same in every process, unlike hash()."""
    return random.Random(f"seed-{seed}").randrange(10**6)


def count_pairs():
    """Of all features, pairs of two dimensions."""
    sizes = [len(FEATURES[d]) for d in ORDER]
    return sum(sizes[i] * sizes[j] for i in range(len(sizes)) for j in range(i))
