"""Isometries of the plane and changes of frame, applied to decks and to states."""
import copy
import dataclasses
import math

NEGATED = {"velocity": "velocity", "harmonic": "amplitude", "parabolic": "amplitude", "triangle": "amplitude", "square": "amplitude",
           "table": "factor", "load": "force", "servo": "force"}


@dataclasses.dataclass
class Map:
    """r -> matrix r + shift; turn: 1, or -1 where it mirrors; angle: by which directions turn, of mirrors after x -> -x."""
    matrix: tuple = ((1.0, 0.0), (0.0, 1.0))
    shift: tuple = (0.0, 0.0)
    turn: float = 1.0
    angle: float = 0.0

    def vector(self, v):
        (a, b), (c, d) = self.matrix
        return [a * v[0] + b * v[1], c * v[0] + d * v[1]]

    def point(self, p):
        x, y = self.vector(p)
        return [x + self.shift[0], y + self.shift[1]]

    def direction(self, angle):
        return self.angle + (angle if self.turn > 0 else math.pi - angle)

    def axis(self, name):
        """(name of the axis onto which this one goes, sign)"""
        (a, _), (c, _) = self.matrix
        first = ("x", a) if a else ("y", c)
        (_, b), (_, d) = self.matrix
        second = ("x", b) if b else ("y", d)
        return first if name == "x" else second


MIRROR = Map(((-1.0, 0.0), (0.0, 1.0)), turn=-1.0)
UPSIDE_DOWN = Map(((1.0, 0.0), (0.0, -1.0)), turn=-1.0, angle=-math.pi)
QUARTER = Map(((0.0, -1.0), (1.0, 0.0)), angle=math.pi / 2)


def shifted(x, y):
    return Map(shift=(x, y))


def map_disk(m, disk):
    disk["x"], disk["y"] = m.point((disk["x"], disk["y"]))
    velocity = {}
    for name in "xy":
        if f"v{name}" in disk:
            to, sign = m.axis(name)
            velocity[f"v{to}"] = sign * disk.pop(f"v{name}")
    disk.update(velocity)
    for name in "theta", "omega", "torque":
        if name in disk:
            disk[name] *= m.turn
    if "force" in disk:
        disk["force"] = m.vector(disk["force"])
    if "locked" in disk:
        disk["locked"] = [coordinate_of(m, name)[0] for name in disk["locked"]]


def map_wall(m, wall):
    for name in "pivot", "center":
        if name in wall:
            wall[name] = m.point(wall[name])
    if "points" in wall:
        wall["points"] = [m.point(p) for p in wall["points"]]
    if "from" in wall:
        ends = m.direction(wall["from"]), m.direction(wall["to"])
        wall["from"], wall["to"] = ends if m.turn > 0 else ends[::-1]


def coordinate_of(m, name):
    return m.axis(name) if name in "xy" else (name, m.turn)


def map_motion(m, motion):
    motion["coordinate"], sign = coordinate_of(m, motion["coordinate"])
    if sign < 0 and motion["type"] != "fixed":
        key = NEGATED[motion["type"]]  # random ones have no sign
        motion[key] = -motion[key]


def map_held(m, item):
    """Vectors, numbers about the third axis, names of coordinates: of clumps, forces and locks."""
    for name in "velocity", "force":
        if name in item:
            item[name] = m.vector(item[name])
    for name in "omega", "torque":
        if name in item:
            item[name] *= m.turn
    for name in "locked", "coordinates":
        if name in item:
            item[name] = [coordinate_of(m, c)[0] for c in ([item[name]] if isinstance(item[name], str) else item[name])]


def map_field(m, field):
    if "centre" in field:
        field["centre"] = m.point(field["centre"])
    if "flow" in field:
        field["flow"] = m.vector(field["flow"])
    for name in "swirl", "omega", "shear_rate":
        if name in field:
            field[name] *= m.turn
    if field["type"] == "gravity":
        map_gravity(m, field)


def map_phase(m, phase):
    """Deforming boxes are mirrored and shifted, not turned."""
    for name in "rate_xy", "stress_xy":
        if name in phase.get("cell", {}):
            phase["cell"][name] *= m.turn


def map_container(m, container):
    """These too."""
    container["origin"] = m.point(container["origin"])


def map_box(m, box):
    edges = {}
    for name in "xy":
        if name in box:
            to, sign = m.axis(name)
            ends = [sign * e + m.shift["xy".index(to)] for e in box.pop(name)]
            edges[to] = sorted(ends)
    box.update(edges)
    if "periodic" in box:
        box["periodic"] = "".join(sorted(edges))


def map_gravity(m, gravity):
    """The acceleration is -g (sin tilt, cos tilt)."""
    x, y = m.vector((math.sin(gravity.get("tilt", 0.0)), math.cos(gravity.get("tilt", 0.0))))
    gravity["tilt"] = math.atan2(x, y)


LISTS = {"disks": map_disk, "walls": map_wall, "motions": map_motion, "clumps": map_held, "fields": map_field, "forces": map_held,
         "locks": map_held, "phases": map_phase}
GROUPS = {"box": map_box, "bounds": map_box, "gravity": map_gravity, "container": map_container}


def mapped(m, deck):
    deck = copy.deepcopy(deck)
    for name, change in LISTS.items():
        for item in deck.get(name, ()):
            change(m, item)
    for name, change in GROUPS.items():
        if name in deck:
            change(m, deck[name])
    return deck


def into_box(deck):
    """Disks that start beyond a periodic edge start at their image."""
    box = deck.get("box", {})
    for name in box.get("periodic", ""):
        low, high = box[name]
        for disk in deck["disks"]:
            disk[name] = low + (disk[name] - low) % (high - low)
    return deck
