"""The product of features and ways to run. Each deck has features of tools/relations/decks.py, and some of those below, which belong to
phases, boxes, measuring and packings; build/release/tests/ways runs it in every way and compares the bits.

    python3 -m relations.crossing --count 1000      (in tools; or tools/soak.sh crossing)

The same number gives the same deck. Deck number n has feature n modulo their count. The table counts, of every feature and way, the
decks that the way took and those that it left."""
import argparse
import collections
import copy
import pathlib
import random
import subprocess
import sys
import tempfile

from . import decks, watch

FEW, SOME, MANY = (2, 1), (3, 3), (4, 11)  # for lanes, for all, and enough for windows of steps with chunks of 8 disks
PLAIN_BODIES = {"bodies": ("free", "inertia", "forces"), "motion": ("none",), "field": ("none",)}
WALLS = {"walls": tuple(name for name in decks.FEATURES["walls"] if name != "none")}
MORE = {}  # dimension: {name: (function(random, deck), what the deck may have)}


def more(dimension, name, **only):
    def keep(function):
        MORE.setdefault(dimension, {})[name] = function, only
        return function
    return keep


for _dimension in "phases", "bounds", "bodies later", "source", "also":
    more(_dimension, "none")(lambda r, deck: None)


@more("measure", "none")
def no_measure(r, deck):
    """Nothing of single disks, so that ranks take it."""
    if "measure" not in deck:
        deck["measure"] = {"rotation": []}

PERIODIC = {**PLAIN_BODIES, "bodies": ("free", "inertia"), "box": ("xy",), "walls": ("none",), "gravity": ("none",)}


@more("phases", "box at rates", **PERIODIC)
def box_at_rates(r, deck):
    kinds = {"rate_xy": r.uniform(-3, 3)}, {"rate_xx": r.uniform(-1, 1), "rate_yy": r.uniform(-1, 1), "boundary": True}
    deck["phases"] = [{"steps": 300, "cell": r.choice(kinds)}]


@more("phases", "box at stresses", **PERIODIC)
def box_at_stresses(r, deck):
    kinds = ({"rate_xy": r.uniform(-3, 3), "stress_yy": r.uniform(0.5, 3), "max_rate": 2.0, "response": 0.02},
             {"stress_xx": 2.0, "stress_yy": r.uniform(0.5, 3), "max_rate": 2.0}, {"stress_xy": r.uniform(-1, 1), "max_rate": 2.0})
    deck["phases"] = [{"steps": 100}, {"steps": 200, "cell": r.choice(kinds)}]


@more("phases", "compress", **{**PERIODIC, "bodies": ("free", "inertia", "clumps", "locked")})
def compress(r, deck):
    target = {"pressure": r.uniform(0.5, 5)} if r.random() < 0.5 else {"fraction": r.uniform(0.8, 0.95)}
    deck["phases"] = [{"steps": 200, "compress": {**target, "rate": r.uniform(1, 10), "tolerance": 1e-4}}, {"steps": 100}]


@more("phases", "relax", integrator=("verlet",), field=("none", "central"), motion=("none", "push", "spin", "table"))
def relax(r, deck):
    deck["phases"] = [{"steps": 120, "relax": True, "settle": {"unbalanced": 1e-3, "every": 40}}, {"steps": 100, "relax": True},
                      {"steps": 80}]


@more("phases", "settle", motion=("none",))
def settle(r, deck):
    deck["phases"] = [{"steps": 150, "settle": {"kinetic": r.choice((1e-9, 10.0)), "every": 30}}, {"steps": 150}]


@more("phases", "switched fields", field=tuple(name for name in decks.FEATURES["field"] if name != "none"), motion=("none", "push"))
def switched_fields(r, deck):
    deck["phases"] = [{"steps": 120, "fields": []}, {"steps": 180, "fields": [deck["fields"][0]["name"]]}]


@more("phases", "until", motion=("none", "push", "random", "wave"), bodies=("free", "inertia"))
def until(r, deck):
    deck["phases"] = [{"steps": 100}, {"steps": 150, "measure": True}]
    deck["measure"] = {"rotation": [deck["disks"][0]["name"]]}
    deck["until"] = {"relative": 0.5, "max_time": 300 * decks.DT}


@more("bodies later", "rain", walls=("none",), box=("open",), gravity=("down",), **PLAIN_BODIES)
def rain(r, deck):
    height = max(d["y"] + d["radius"] for d in deck["disks"])
    low = min(d["y"] - d["radius"] for d in deck["disks"])
    wide = max(abs(d["x"]) + d["radius"] for d in deck["disks"])
    deck["container"] = {"type": "box", "width": 2 * wide + 0.2, "height": height - low + 0.5, "origin": [0.0, low - 0.001]}
    deck["packings"] = [{"type": "rain", "count": 8, "rows": 1, "interval": 2.5e-3, "speed": 1.0, "density": 1.0, "sizes": "uniform",
                         "lower": 0.04, "upper": 0.055}]
    if "material_pairs" in deck:
        deck["container"]["material"] = deck["packings"][0]["material"] = "grain"


@more("bodies later", "hold and release", motion=("none", "push", "wave"), bodies=("free", "held", "inertia"))
def hold_and_release(r, deck):
    named = {m.get("disk") for m in deck.get("motions", ())}
    free = [d["name"] for d in deck["disks"] if not d.get("fixed") and d["name"] not in named]
    fixed = [d["name"] for d in deck["disks"] if d.get("fixed")]
    first, second = r.sample(free, 2)
    deck["phases"] = [{"steps": 100, "hold": [first]}, {"steps": 100, "hold": [second], "release": [first, *fixed]}, {"steps": 100}]


@more("bounds", "report", gravity=("none",), bodies=("free", "forces", "inertia"))
def report(r, deck):
    deck["bounds"] = {"x": [-5, 5], "y": [-5, 5], "outside": "report"}


@more("bounds", "remove", gravity=("down", "oblique"), bodies=("free", "forces", "inertia"), box=("open",), motion=("none", "push", "wave"))
def remove(r, deck):
    low = min(d["y"] for d in deck["disks"])
    deck["bounds"] = {"x": [-5, 5], "y": [low - 1e-3, 5], "outside": "remove"}


# --- where disks come from --------------------------------------------------------------------------------------------

ALONE = {**PLAIN_BODIES, "bodies": ("free",), "walls": ("none",), "box": ("open",), "motion": ("none",), "materials": ("one",)}


@more("source", "rows", **ALONE)
def rows(r, deck):
    columns = ("x", "y", "radius", "theta", "vx", "vy", "omega")
    deck["disk_rows"] = [{"columns": list(columns), "density": 1.0, "rows": [[d[c] for c in columns] for d in deck["disks"]]}]
    deck["disks"] = []


def packed(name, container, **keys):
    """Disks of a generator in a container."""
    @more("source", name, **ALONE)
    def source(r, deck):
        deck["disks"] = []
        deck["container"] = container
        sizes = {"density": 1.0, "radius": 0.05} if "clump" in keys else {"density": 1.0, **SIZES[r.choice(list(SIZES))]}
        if keys["type"] in ("triangular", "square"):
            sizes = {"density": 1.0, "sizes": "mono", "radius": 0.045} if "clump" not in keys else sizes
        deck["packings"] = [{"group": "grains", **sizes, **keys}]


SIZES = {"uniform": {"sizes": "uniform", "lower": 0.04, "upper": 0.05}, "mono": {"sizes": "mono", "radius": 0.045},
         "gaussian": {"sizes": "gaussian", "radius": 0.045, "deviation": 0.002, "lower": 0.04, "upper": 0.05},
         "lognormal": {"sizes": "lognormal", "radius": 0.045, "deviation": 0.05, "lower": 0.04, "upper": 0.05},
         "powerlaw": {"sizes": "powerlaw", "exponent": 2.0, "lower": 0.04, "upper": 0.05},
         "list": {"sizes": "list", "radii": [0.04, 0.05], "weights": [1, 2]}}
packed("square in a channel", {"type": "channel", "width": 0.6, "height": 0.9}, type="square", count=40, jitter=0.3, x=[-0.3, 0.3], y=[0.0, 0.9])
packed("triangular on a bed", {"type": "bed", "width": 0.6, "height": 0.9, "radius": 0.05, "spacing": 0.12}, type="triangular", count=12)
packed("front in a drum", {"type": "drum", "radius": 0.4}, type="front", count=30)
packed("random in a hopper", {"type": "hopper", "width": 0.8, "height": 0.9, "outlet": 0.2, "angle": 0.9}, type="random", count=20)
packed("random in a periodic box", {"type": "periodic", "width": 0.7, "height": 0.7}, type="random", fraction=0.5)
packed("clumps in a box", {"type": "box", "width": 0.7, "height": 0.9, "open": False}, type="random", count=8,
       clump={"at": [[-0.5, 0.0], [0.5, 0.0]], "radii": [0.6, 0.6]})


# --- what else a deck may have ----------------------------------------------------------------------------------------


def need_disks(deck):
    """One by one, in the deck."""
    if not deck["disks"]:
        raise decks.Unsuitable


@more("also", "turning gravity", gravity=("none",), field=("none",))
def turning_gravity(r, deck):
    deck["fields"] = [{"name": "turn", "type": "gravity", "g": 10.0, "omega": r.uniform(-20, 20), "tilt": r.uniform(-1, 1)}]


@more("also", "fields of a group", field=("none",), bodies=("free", "inertia", "forces"))
def fields_of_a_group(r, deck):
    need_disks(deck)
    deck["fields"] = [{"name": "air", "type": "drag", "gamma": 0.05, "per": r.choice(("radius", "mass")), "shear_rate": r.uniform(-3, 3),
                       "group": "group0"},
                      {"name": "damp", "type": "damping", "alpha": 0.2, "alpha_rotation": 0.4},
                      {"name": "pull", "type": "central", "strength": 0.3, "per": "mass", "disk": [deck["disks"][0]["name"]]}]


@more("also", "locks and forces", motion=("none",), bodies=("free", "inertia"))
def locks_and_forces(r, deck):
    need_disks(deck)
    first, second = deck["disks"][0], deck["disks"][2]
    deck["forces"] = [{"group": "group1", "force": [r.uniform(-0.3, 0.3), 0.1], "torque": 1e-3}, {"disk": [first["name"]], "force": [0.1, 0.0]}]
    for disk in deck["disks"][::2]:
        if disk is not second:
            del disk["omega"]
    del deck["disks"][1]["vx"]
    if any("cell" in phase for phase in deck["phases"]):
        raise decks.Unsuitable
    deck["locks"] = [{"group": "group0", "except": [second["name"]], "coordinates": "theta"},
                     {"disk": [deck["disks"][1]["name"]], "coordinates": "x"}]


@more("also", "clumps with forces", bodies=("clumps",), motion=("none",))
def clumps_with_forces(r, deck):
    deck["clumps"][0].update(mass=0.02, inertia=3e-5, force=[r.uniform(-0.3, 0.3), 0.1], torque=1e-3, group="pair")
    for disk in deck["disks"]:
        if disk["name"] in deck["clumps"][0]["disk"]:
            disk["group"] = "pair"
    del deck["clumps"][0]["disk"]
    deck["clumps"][1].update(locked=["theta"])
    del deck["clumps"][1]["omega"]


@more("also", "moduli", materials=("one",), normal=("hertz",), cohesion=("none",), friction=("mindlin",))
def moduli(r, deck):
    keys = deck["materials"][0]
    for key in "k_n", "k_t":
        del keys[key]
    keys.update(E_star=3e4, poisson=0.3)


@more("also", "a noisy group", motion=("none",), bodies=("free",))
def a_noisy_group(r, deck):
    need_disks(deck)
    for disk in deck["disks"][::2]:
        for key in "vx", "vy":
            disk.pop(key)
    deck["motions"] = [{"name": f"noise {axis}", "group": "group0", "coordinate": axis, "type": "random", "acceleration": 1.0, "damping": 0.3,
                        "frequency": 60.0, "interval": 3, "independent": True} for axis in "xy"]
    deck["gravity"] = {"g": 10.0}


@more("also", "waves of walls", motion=("none",), **WALLS)
def waves_of_walls(r, deck):
    wall = deck["walls"][0]["name"]
    deck["motions"] = [{"name": "square", "wall": wall, "coordinate": "y", "type": "square", "amplitude": 1e-4, "frequency": 50.0, "rise": 0.6,
                        "phase": 0.3},
                       {"name": "wave", "wall": wall, "coordinate": "y", "type": "parabolic", "amplitude": 1e-4, "omega": 300.0, "ramp": 1e-3},
                       {"name": "rest", "wall": wall, "coordinate": "x", "type": "fixed"}]


@more("also", "a pressing lid", motion=("none",), gravity=("down", "none"), walls=("none",), box=("open",), **{"bodies": ("free", "inertia")})
def a_pressing_lid(r, deck):
    need_disks(deck)
    low = min(d["y"] - d["radius"] for d in deck["disks"])
    high = max(d["y"] + d["radius"] for d in deck["disks"])
    wide = max(abs(d["x"]) + d["radius"] for d in deck["disks"]) + 0.001
    deck["container"] = {"type": "box", "width": 2 * wide, "height": high - low + 0.002, "origin": [0.0, low - 0.001], "open": False}
    if "material_pairs" in deck:
        deck["container"]["material"] = "grain"
    deck["motions"] = [{"name": "press", "wall": "lid", "coordinate": "y", "type": "servo", "pressure": 1.0, "speed": 0.2}]


@more("measure", "every disk")
def every_disk(r, deck):
    if any("cell" in phase for phase in deck["phases"]):
        raise decks.Unsuitable
    deck["measure"] = {**deck.get("measure", {}), "disks": True, "every": r.choice((1, 3, 29)), "rotation": deck.get("measure", {}).get("rotation", [])}
    deck["phases"][-1]["measure"] = True


@more("measure", "single disks")
def single_disks(r, deck):
    deck["measure"] = {**deck.get("measure", {}), "rotation": [deck["disks"][1]["name"]]}
    deck["phases"][-1]["measure"] = True


@more("measure", "watched contacts")
def watched_contacts(r, deck):
    names = [d["name"] for d in deck["disks"]]
    deck["measure"] = {**deck.get("measure", {}), "configurations": True, "sliding": [{"disk": names[1], "partners": [names[0], names[2]]}]}


@more("measure", "columns of the series")
def columns_of_the_series(r, deck):
    deck["measure"] = {**deck.get("measure", {}), "groups": True, "contacts": [deck["disks"][0]["name"]],
                       "rotation": deck.get("measure", {}).get("rotation", []), "averages": {"mean_kinetic": "kinetic_translation", "rate_of_loss": "rate(viscous)"}}
    deck["phases"][-1]["series"] = 1


FEATURES = [(dimension, row) for rows in (decks.FEATURES, MORE) for dimension in rows for row in rows[dimension]]


def joined(one, two):
    """Rows that both allow, or None."""
    both = dict(one)
    for dimension, rows in two.items():
        both[dimension] = tuple(row for row in both.get(dimension, decks.FEATURES[dimension]) if row in rows)
        if not both[dimension]:
            return None
    return both


# Windows of steps take these, if motions are slow beside the margin of the lists
GENTLE = {"field": ("none",), "bodies": tuple(name for name in decks.FEATURES["bodies"] if name != "clumps"),
          "motion": tuple(name for name in decks.FEATURES["motion"] if name not in ("load", "servo", "lead", "lead a clump"))}


# Lanes of small systems take these
LANES = {"field": ("none",), "box": ("open",), "walls": ("none", "drum", "pillar"),
         "bodies": ("free", "held", "forces", "inertia"),
         "motion": tuple(name for name in decks.FEATURES["motion"] if name not in ("load", "servo", "lead", "lead a clump", "belt"))}


def slow_down(deck):
    for motion in deck.get("motions", ()):
        for key in "velocity", "amplitude", "factor":
            if key in motion:
                motion[key] *= 0.05


FEW_MORE = {"measure": ("none", "single disks"), "phases": ("none", "settle", "until"), "bounds": ("none", "report")}


def attempt(r, first):
    """The deck with this feature, or None: what was drawn beside it does not suit."""
    has, only = {}, {}
    dimensions = list(MORE)
    r.shuffle(dimensions)
    dimensions.sort(key=lambda name: name != first[0])
    if first[0] not in MORE:
        only = {first[0]: (first[1],)}
    shape = r.choice((FEW, SOME, MANY, MANY))
    for dimension in dimensions:
        rows = FEW_MORE.get(dimension, ("none",)) if shape == FEW else list(MORE[dimension])
        row = first[1] if dimension == first[0] else r.choice(rows) if r.random() < 0.4 else "none"
        both = joined(only, MORE[dimension][row][1])
        has[dimension], only = ("none", only) if both is None else (row, both)
        if dimension == first[0] and both is None:
            return None
    suited = joined(only, {FEW: LANES, MANY: GENTLE}.get(shape, {}))
    try:
        made = decks.make(r.randrange(10**9), suited or only, shape)
    except (ValueError, IndexError):
        return None
    deck = copy.deepcopy(made.deck)
    if suited and shape == MANY:
        slow_down(deck)
    for dimension in MORE:
        if has[dimension] != "none" or dimension == "measure":
            if dimension != "measure" and dimension != "phases" and len(deck["phases"]) > 1:
                has[dimension] = "none"
                continue
            try:
                MORE[dimension][has[dimension]][0](r, deck)
            except (decks.Unsuitable, ValueError, IndexError):
                has[dimension] = "none"
    has = {**made.has, **has}
    return decks.Deck(has, deck, made.steps) if has[first[0]] == first[1] else None


def make(seed):
    """The deck of a number: it has feature number seed modulo their count."""
    r = random.Random(f"crossing-{seed}")
    for _ in range(50):
        made = attempt(r, FEATURES[seed % len(FEATURES)])
        if made:
            return made
    raise ValueError(f"nothing suits {FEATURES[seed % len(FEATURES)]}")


# --- the product ------------------------------------------------------------------------------------------------------

ROUNDS = 2  # of one deck for each feature; only the first of them is run by several threads, too, which wait for each other on busy machines


def ways(folder, seeds):
    """Lines (seed, features, way, what came of it) of these decks."""
    program = watch.BUILD / "tests" / "ways"
    has = {}
    for seed in seeds:
        made = make(seed)
        has[seed] = made.has
        (folder / f"{seed}.cfg").write_text(watch.slipdisk.deck_text(made.deck))
    for alone in False, True:
        some = [folder / f"{seed}.cfg" for seed in seeds if (seed // len(FEATURES) % ROUNDS > 0) == alone]
        done = subprocess.run([program, *["--alone"][:alone], *some], stdout=subprocess.PIPE, text=True)
        for line in done.stdout.splitlines():
            path, way, outcome = line.split("\t")
            seed = int(pathlib.Path(path).stem)
            yield seed, has[seed], way, outcome
        if done.returncode not in (0, 1):
            raise RuntimeError(f"ways ended with {done.returncode}")


def product(seeds, block=50):
    """({(feature, way): Counter of same, left, wrong}, lines of what was wrong)"""
    cells, wrong = collections.defaultdict(collections.Counter), []
    seeds = list(seeds)
    for at in range(0, len(seeds), block):
        with tempfile.TemporaryDirectory(prefix="slipdisk-crossing-") as folder:
            for seed, has, way, outcome in ways(pathlib.Path(folder), seeds[at:at + block]):
                kind, _, said = outcome.partition(": ")
                if kind == "wrong":
                    wrong.append(f"deck {seed}, {way}: {said}\n  {has}\n  cd tools; python3 -m relations.crossing --first {seed} --deck")
                for feature in has.items():
                    cells[feature, way]["said nothing" if kind == "left" and not said else kind] += 1
    return cells, wrong


def table(cells):
    """Text: a row of each feature, a column of each way, taken/left."""
    names = list(dict.fromkeys(way for _, way in cells))
    lines = [" " * 34 + " ".join(f"{k:>7}" for k in range(len(names)))]
    for feature in FEATURES:
        counts = [cells.get((feature, way), collections.Counter()) for way in names]
        lines.append(f"{': '.join(feature):<34}" + " ".join(f"{c['same']:>3}/{c['left']:<3}" for c in counts))
    return "\n".join(lines + [f"{k}: {name}" for k, name in enumerate(names)])


def main():
    parser = argparse.ArgumentParser(prog="python3 -m relations.crossing", description=__doc__.split("\n")[0])
    parser.add_argument("--first", type=int, default=0, metavar="N", help="number of the first deck (0)")
    parser.add_argument("--count", type=int, default=2 * len(FEATURES), metavar="N", help="decks (two of each feature)")
    parser.add_argument("--deck", action="store_true", help="print the first deck, and stop")
    args = parser.parse_args()
    if args.deck:
        print(watch.slipdisk.deck_text(make(args.first).deck))
        return 0
    cells, wrong = product(range(args.first, args.first + args.count))
    print(table(cells))
    print(*wrong, sep="\n")
    print(f"{args.count} tried {len(wrong)} failed")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
