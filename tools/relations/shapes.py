"""One wall in several shapes: one motion and one budget."""
import copy
import math

from . import decks, symmetries, watch

EVERY = 15
NEAR = 1e-8
without = symmetries.without
BONDS = symmetries.BONDS
of_equal_strength = symmetries.of_equal_strength


def straight(points, **keys):
    """Shapes of a straight wall from one point to another; each is a list of walls."""
    (x0, y0), (x1, y1) = points

    def at(s):
        return [x0 + s * (x1 - x0), y0 + s * (y1 - y0)]
    ends = [at(-1.5), at(2.5)]
    joints = [at(-1.5 + 4 * k / 37) for k in range(38)]
    cuts = [at(-1.5), at(0.31), at(0.52), at(2.5)]
    return {
        "line": [{"type": "line", "points": points, **keys}],
        "line through others": [{"type": "line", "points": [at(0.2), at(0.9)], **keys}],
        "segment": [{"type": "segment", "points": ends, **keys}],
        "polyline": [{"type": "polyline", "points": ends, **keys}],
        "joints": [{"type": "polyline", "points": joints, **keys}],
        "segments": [{"type": "segment", "points": cuts[k:k + 2], **keys} for k in range(3)],
    }


def round_shapes(wall, keys):
    """Of a circle: rings that begin anywhere, and, seen from outside, a disk."""
    same = {name: wall[name] for name in ("center", "radius")}
    found = {"circle": [{"type": "circle", "side": wall["side"], **same, **keys}]}
    for name, start in (("ring", -2.0), ("ring from elsewhere", 0.7)):
        found[name] = [{"type": "arc", **same, "from": start, "to": start + 2 * math.pi, **keys}]
    return found


def with_walls(deck, walls):
    """The deck with these in place of its wall; motions move all of them."""
    other = copy.deepcopy(deck)
    names = [f"wall0 part {k}" for k in range(len(walls))]
    other["walls"] = [{"name": name, **wall} for name, wall in zip(names, walls)]
    for motion in other.get("motions", ()):
        if "wall" in motion:
            motion["wall"] = names
    return other


def with_disk(deck, wall):
    """The deck with a held disk in place of its round wall, last of all disks."""
    other = copy.deepcopy(deck)
    del other["walls"]
    material = {"material": wall["material"]} if "material" in wall else {}
    other["disks"].append({"name": "pillar", "x": wall["center"][0], "y": wall["center"][1], "radius": wall["radius"],
                           "density": 1.0, "fixed": True, **material})
    for motion in other.get("motions", ()):
        if "wall" in motion:
            motion["disk"] = motion.pop("wall").replace("wall0", "pillar")
    return other


def looks(deck, n):
    """Of its first n disks."""
    return [{kind: v if kind == "energy" else v[:n] for kind, v in look.items()} for look in watch.follow(deck, 300, EVERY)]


def agree(shapes, n):
    """All shapes do what the first does."""
    names = list(shapes)
    first = looks(shapes[names[0]], n)
    for name in names[1:]:
        try:
            watch.same(first, looks(shapes[name], n), NEAR, every=EVERY)
        except watch.Wrong as wrong:
            raise watch.Wrong(f"{name} beside {names[0]}: {wrong}") from None


def flat(seed, names, bonds=("none",)):
    deck = of_equal_strength(decks.make(seed, {"walls": ("line",), "box": ("open",), "bond": bonds,
                                               **without("motion", "load", "servo", "random")}).deck)
    wall = deck["walls"][0]
    keys = {name: wall[name] for name in ("pivot", "material") if name in wall}
    shapes = straight(wall["points"], **keys)
    agree({name: with_walls(deck, shapes[name]) for name in names}, len(deck["disks"]))


def straight_walls(seed):
    """A line, a long segment, a polyline of one piece."""
    flat(seed, ("line", "line through others", "segment", "polyline"), BONDS)


def joined_walls(seed):
    """A line, a polyline with joints, segments that follow one another."""
    flat(seed, ("line", "joints", "segments"))


def round_walls(seed):
    """Circles, inside and outside, arcs of a whole turn, a held disk. A belt around an arc runs back on its outer side, that of a
    round wall does not."""
    walls = ("drum", "pillar")[seed % 2]
    deck = decks.make(seed, {"walls": (walls,), "variant": ("conservative",), "bond": BONDS, "box": ("open", "x") if walls == "pillar" else ("open",),
                             **without("motion", "load", "servo", "random", *(("belt",) if walls == "pillar" else ()))}).deck
    wall = of_equal_strength(deck)["walls"][0]
    keys = {"material": wall["material"]} if "material" in wall else {}
    shapes = {name: with_walls(deck, made) for name, made in round_shapes(wall, keys).items()}
    if walls == "pillar" and "bond_E" not in deck["materials"][0]:  # the length of a beam counts the radius of a disk, not that of a wall
        shapes["disk"] = with_disk(deck, wall)
    agree(shapes, len(deck["disks"]))
