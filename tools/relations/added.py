"""Features that are added to a deck when its bodies, laws and motions are there: of phases, boxes, packings, measuring."""
from .decks import DT, FEATURES, Unsuitable, added

PLAIN_BODIES = {"bodies": ("free", "inertia", "forces"), "motion": ("none",), "field": ("none",)}
WALLS = {"walls": tuple(name for name in FEATURES["walls"] if name != "none")}


for _dimension in "phases", "bond", "bounds", "bodies later", "source", "also", "calls", "outputs":
    added(_dimension, "none")(lambda r, deck: None)


@added("measure", "none")
def no_measure(r, deck):
    """Nothing of single disks, so that ranks take it."""
    if "measure" not in deck:
        deck["measure"] = {"rotation": []}

PERIODIC = {**PLAIN_BODIES, "bodies": ("free", "inertia"), "box": ("xy",), "walls": ("none",), "gravity": ("none",)}


@added("phases", "box at rates", **PERIODIC)
def box_at_rates(r, deck):
    kinds = {"rate_xy": r.uniform(-3, 3)}, {"rate_xx": r.uniform(-1, 1), "rate_yy": r.uniform(-1, 1), "boundary": True}
    deck["phases"] = [{"steps": 300, "cell": r.choice(kinds)}]


@added("phases", "box at stresses", **PERIODIC)
def box_at_stresses(r, deck):
    kinds = ({"rate_xy": r.uniform(-3, 3), "stress_yy": r.uniform(0.5, 3), "max_rate": 2.0, "response": 0.02},
             {"stress_xx": 2.0, "stress_yy": r.uniform(0.5, 3), "max_rate": 2.0}, {"stress_xy": r.uniform(-1, 1), "max_rate": 2.0})
    deck["phases"] = [{"steps": 100}, {"steps": 200, "cell": r.choice(kinds)}]


@added("phases", "compress", **{**PERIODIC, "bodies": ("free", "inertia", "clumps", "locked")})
def compress(r, deck):
    target = {"pressure": r.uniform(0.5, 5)} if r.random() < 0.5 else {"fraction": r.uniform(0.8, 0.95)}
    deck["phases"] = [{"steps": 200, "compress": {**target, "rate": r.uniform(1, 10), "tolerance": 1e-4}}, {"steps": 100}]


def in_container(deck):
    """A container in place of the walls of a box. Returns its corners."""
    points = [p for wall in deck["walls"] for p in wall["points"]]
    (x0, y0), (x1, y1) = (min(p[0] for p in points), min(p[1] for p in points)), (max(p[0] for p in points), max(p[1] for p in points))
    material = {"material": deck["walls"][0]["material"]} if "material" in deck["walls"][0] else {}
    del deck["walls"]
    deck["container"] = {"type": "box", "width": x1 - x0, "height": y1 - y0, "origin": [(x0 + x1) / 2, y0], "open": False, **material}
    return x0, y0, x1, y1


@added("phases", "compress a box", walls=("box",), box=("open",), motion=("none",), field=("none",),
       bodies=tuple(name for name in FEATURES["bodies"] if name != "held"))
def compress_a_box(r, deck):
    in_container(deck)
    compress(r, deck)


@added("phases", "relax", integrator=("verlet",), field=("none", "central"), motion=("none", "push", "spin", "table"))
def relax(r, deck):
    deck["phases"] = [{"steps": 120, "relax": True, "settle": {"unbalanced": 1e-3, "every": 40}}, {"steps": 100, "relax": True},
                      {"steps": 80}]


@added("phases", "settle", motion=("none",))
def settle(r, deck):
    deck["phases"] = [{"steps": 150, "settle": {"kinetic": r.choice((1e-9, 10.0)), "every": 30}}, {"steps": 150}]


@added("phases", "switched fields", field=tuple(name for name in FEATURES["field"] if name != "none"), motion=("none", "push"))
def switched_fields(r, deck):
    deck["phases"] = [{"steps": 120, "fields": []}, {"steps": 180, "fields": [deck["fields"][0]["name"]]}]


@added("phases", "until", motion=("none", "push", "random", "wave"), bodies=("free", "inertia"))
def until(r, deck):
    deck["phases"] = [{"steps": 100}, {"steps": 150, "measure": True}]
    deck["measure"] = {"rotation": [deck["disks"][0]["name"]]}
    deck["until"] = {"relative": 0.5, "max_time": 300 * DT}


@added("bodies later", "rain", walls=("none",), box=("open",), gravity=("down",), **PLAIN_BODIES)
def rain(r, deck):
    height = max(d["y"] + d["radius"] for d in deck["disks"])
    low = min(d["y"] - d["radius"] for d in deck["disks"])
    wide = max(abs(d["x"]) + d["radius"] for d in deck["disks"])
    deck["container"] = {"type": "box", "width": 2 * wide + 0.2, "height": height - low + 0.5, "origin": [0.0, low - 0.001]}
    deck["packings"] = [{"type": "rain", "count": 8, "rows": 1, "interval": 2.5e-3, "speed": 1.0, "density": 1.0, "sizes": "uniform",
                         "lower": 0.04, "upper": 0.055}]
    if "material_pairs" in deck:
        deck["container"]["material"] = deck["packings"][0]["material"] = "grain"


@added("bodies later", "hold and release", motion=("none", "push", "wave"), bodies=("free", "held", "inertia"))
def hold_and_release(r, deck):
    named = {m.get("disk") for m in deck.get("motions", ())}
    free = [d["name"] for d in deck["disks"] if not d.get("fixed") and d["name"] not in named]
    fixed = [d["name"] for d in deck["disks"] if d.get("fixed")]
    first, second = r.sample(free, 2)
    deck["phases"] = [{"steps": 100, "hold": [first]}, {"steps": 100, "hold": [second], "release": [first, *fixed]}, {"steps": 100}]


def cement(r, deck, keys, **phase):
    """Bonds of all laws, made when the first phase begins."""
    for law in deck["materials"] + deck.get("material_pairs", []):
        law.update(keys() | {"bond_gap": 1e-2})
    deck["phases"][0]["bond"] = phase


UNBRIDGED = {"cohesion": ("none", "constant")}


@added("bond", "springs", **UNBRIDGED)
def bond_springs(r, deck):
    cement(r, deck, lambda: {"bond_k_n": r.uniform(300, 900), "bond_k_t": r.uniform(200, 500), "bond_k_r": r.choice((0.0, 300.0)),
                             "bond_extension": 5e-3})


@added("bond", "beams that damp", **UNBRIDGED)
def bond_beams(r, deck):
    cement(r, deck, lambda: {"bond_E": r.uniform(500, 1500), "bond_width": r.uniform(0.02, 0.06), "bond_poisson": r.uniform(0, 0.4),
                             "bond_gamma_n": 0.2, "bond_gamma_t": 0.1, "bond_gamma_r": 0.1, "bond_tension": r.uniform(20, 100),
                             "bond_cohesion": r.uniform(5, 60), "bond_friction": r.uniform(0, 0.6)})


@added("bond", "brittle", **UNBRIDGED)
def brittle_bonds(r, deck):
    cement(r, deck, lambda: {"bond_k_n": r.uniform(300, 900), "bond_k_t": r.uniform(200, 500), "bond_k_r": r.uniform(100, 300),
                             "bond_max_tension": r.uniform(0.02, 0.5), "bond_max_shear": r.uniform(0.02, 0.5),
                             "bond_max_bending": r.uniform(1e-3, 1e-2), "bond_weibull": r.uniform(1.5, 6), "bond_alone": r.random() < 0.5})


@added("bond", "sinter", **UNBRIDGED)
def sintering(r, deck):
    cement(r, deck, lambda: {"bond_k_n": r.uniform(300, 900), "bond_k_t": r.uniform(200, 500), "bond_extension": r.uniform(2e-4, 2e-3)},
           sinter=True, begin=False)
    for phase in deck["phases"][1:]:
        phase["bond"] = {"sinter": True}


@added("bounds", "report", gravity=("none",), bodies=("free", "forces", "inertia"))
def report(r, deck):
    deck["bounds"] = {"x": [-5, 5], "y": [-5, 5], "outside": "report"}


@added("bounds", "remove", gravity=("down", "oblique"), bodies=("free", "forces", "inertia"), box=("open",), motion=("none", "push", "wave"))
def remove(r, deck):
    low = min(d["y"] for d in deck["disks"])
    deck["bounds"] = {"x": [-5, 5], "y": [low - 1e-3, 5], "outside": "remove"}


ALONE = {**PLAIN_BODIES, "bodies": ("free",), "walls": ("none",), "box": ("open",), "motion": ("none",), "materials": ("one",)}


@added("source", "rows", **ALONE)
def rows(r, deck):
    columns = ("x", "y", "radius", "theta", "vx", "vy", "omega")
    deck["disk_rows"] = [{"columns": list(columns), "density": 1.0, "rows": [[d[c] for c in columns] for d in deck["disks"]]}]
    deck["disks"] = []


def packed(name, container, **keys):
    """Disks of a generator in a container."""
    @added("source", name, **ALONE)
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
packed("random in a polygon", {"type": "polygon", "radius": 0.5, "sides": 5, "angle": 0.2}, type="random", count=20)
packed("random in a hopper", {"type": "hopper", "width": 0.8, "height": 0.9, "outlet": 0.2, "angle": 0.9}, type="random", count=20)
packed("random in a periodic box", {"type": "periodic", "width": 0.7, "height": 0.7}, type="random", fraction=0.5)
packed("clumps in a box", {"type": "box", "width": 0.7, "height": 0.9, "open": False}, type="random", count=8,
       clump={"at": [[-0.5, 0.0], [0.5, 0.0]], "radii": [0.6, 0.6]})


def need_disks(deck):
    """One by one, in the deck."""
    if not deck["disks"]:
        raise Unsuitable


@added("also", "turning gravity", gravity=("none",), field=("none",))
def turning_gravity(r, deck):
    deck["fields"] = [{"name": "turn", "type": "gravity", "g": 10.0, "omega": r.uniform(-20, 20), "tilt": r.uniform(-1, 1)}]


@added("also", "fields of a group", field=("none",), bodies=("free", "inertia", "forces"))
def fields_of_a_group(r, deck):
    need_disks(deck)
    deck["fields"] = [{"name": "air", "type": "drag", "gamma": 0.05, "per": r.choice(("radius", "mass")), "shear_rate": r.uniform(-3, 3),
                       "centre": [0.02, 0.01], "group": "group0"},
                      {"name": "damp", "type": "damping", "alpha": 0.2, "alpha_rotation": 0.4},
                      {"name": "pull", "type": "central", "strength": 0.3, "per": "mass", "centre": [0.02, 0.01], "disk": [deck["disks"][0]["name"]]}]


@added("also", "locks and forces", motion=("none",), bodies=("free", "inertia"))
def locks_and_forces(r, deck):
    need_disks(deck)
    first, second = deck["disks"][0], deck["disks"][2]
    deck["forces"] = [{"group": "group1", "force": [r.uniform(-0.3, 0.3), 0.1], "torque": 1e-3}, {"disk": [first["name"]], "force": [0.1, 0.0]}]
    for disk in deck["disks"][::2]:
        if disk is not second:
            del disk["omega"]
    del deck["disks"][1]["vx"]
    if any("cell" in phase for phase in deck["phases"]):
        raise Unsuitable
    deck["locks"] = [{"group": "group0", "except": [second["name"]], "coordinates": "theta"},
                     {"disk": [deck["disks"][1]["name"]], "coordinates": "x"}]


@added("also", "clumps with forces", bodies=("clumps",), motion=("none",))
def clumps_with_forces(r, deck):
    deck["clumps"][0].update(mass=0.02, inertia=3e-5, force=[r.uniform(-0.3, 0.3), 0.1], torque=1e-3, group="pair")
    for disk in deck["disks"]:
        if disk["name"] in deck["clumps"][0]["disk"]:
            disk["group"] = "pair"
    del deck["clumps"][0]["disk"]
    deck["clumps"][1].update(locked=["theta"])
    del deck["clumps"][1]["omega"]


@added("also", "moduli", materials=("one",), normal=("hertz",), cohesion=("none",), friction=("mindlin",))
def moduli(r, deck):
    keys = deck["materials"][0]
    for key in "k_n", "k_t":
        del keys[key]
    keys.update(E_star=3e4, poisson=0.3)


@added("also", "a displacement limit")
def a_displacement_limit(r, deck):
    deck["limits"]["displacement"] = r.choice((1e-4, 5e-4, 7e-4))


@added("also", "a noisy group", motion=("none",), bodies=("free",))
def a_noisy_group(r, deck):
    need_disks(deck)
    for disk in deck["disks"][::2]:
        for key in "vx", "vy":
            disk.pop(key)
    deck["motions"] = [{"name": f"noise {axis}", "group": "group0", "coordinate": axis, "type": "random", "acceleration": 1.0, "damping": 0.3,
                        "frequency": 60.0, "interval": 3, "independent": True} for axis in "xy"]
    deck["gravity"] = {"g": 10.0}


@added("also", "waves of walls", motion=("none",), **WALLS)
def waves_of_walls(r, deck):
    if "walls" not in deck:  # a container is there
        raise Unsuitable
    wall = deck["walls"][0]["name"]
    deck["motions"] = [{"name": "square", "wall": wall, "coordinate": "y", "type": "square", "amplitude": 1e-4, "frequency": 50.0, "rise": 0.6,
                        "phase": 0.3},
                       {"name": "wave", "wall": wall, "coordinate": "y", "type": "parabolic", "amplitude": 1e-4, "omega": 300.0, "ramp": 1e-3},
                       {"name": "rest", "wall": wall, "coordinate": "x", "type": "fixed"}]


def container_around(deck):
    need_disks(deck)
    low = min(d["y"] - d["radius"] for d in deck["disks"])
    high = max(d["y"] + d["radius"] for d in deck["disks"])
    wide = max(abs(d["x"]) + d["radius"] for d in deck["disks"]) + 0.001
    deck["container"] = {"type": "box", "width": 2 * wide, "height": high - low + 0.002, "origin": [0.0, low - 0.001], "open": False}
    if "material_pairs" in deck:
        deck["container"]["material"] = "grain"


LIDDED = {"motion": ("none",), "gravity": ("down", "none"), "walls": ("none",), "box": ("open",), "bodies": ("free", "inertia")}


@added("also", "a pressing lid", **LIDDED)
def a_pressing_lid(r, deck):
    if "container" in deck:
        raise Unsuitable
    container_around(deck)
    deck["motions"] = [{"name": "press", "wall": "lid", "coordinate": "y", "type": "servo", "pressure": 1.0, "speed": 0.2}]


@added("phases", "loads in phases", **LIDDED)
def loads_in_phases(r, deck):
    container_around(deck)
    deck["motions"] = [{"name": "sides", "wall": ["left", "right"], "coordinate": "x", "type": "servo", "pressure": 2.0, "speed": 0.3},
                       {"name": "servo", "wall": "lid", "coordinate": "y", "type": "servo", "force": -0.5, "speed": 0.3},
                       {"name": "load", "wall": "lid", "coordinate": "y", "type": "load", "mass": 0.03, "force": -0.3},
                       {"name": "shear", "wall": "lid", "coordinate": "x", "type": "servo", "force": 0.3, "speed": 0.5}]
    deck["phases"] = [{"steps": 90, "motions": ["sides", "servo"]}, {"steps": 80, "motions": ["sides", "load", "shear"]},
                      {"steps": 1, "motions": []}, {"steps": 130, "motions": ["load", "sides"]}]


@added("measure", "every disk")
def every_disk(r, deck):
    if any("cell" in phase for phase in deck["phases"]):
        raise Unsuitable
    deck["measure"] = {**deck.get("measure", {}), "disks": True, "every": r.choice((1, 3, 29)), "rotation": deck.get("measure", {}).get("rotation", [])}
    deck["phases"][-1]["measure"] = True


@added("measure", "single disks")
def single_disks(r, deck):
    deck["measure"] = {**deck.get("measure", {}), "rotation": [deck["disks"][1]["name"]]}
    deck["phases"][-1]["measure"] = True


@added("measure", "watched contacts")
def watched_contacts(r, deck):
    names = [d["name"] for d in deck["disks"]]
    deck["measure"] = {**deck.get("measure", {}), "configurations": True, "sliding": [{"disk": names[1], "partners": [names[0], names[2]]}]}


@added("measure", "columns of the series")
def columns_of_the_series(r, deck):
    deck["measure"] = {**deck.get("measure", {}), "groups": True, "contacts": [deck["disks"][0]["name"]],
                       "rotation": deck.get("measure", {}).get("rotation", []), "averages": {"mean_kinetic": "kinetic_translation", "rate_of_loss": "rate(viscous)"}}
    deck["phases"][-1]["series"] = 1


def measure_sums(deck):
    grouped = any("group" in one for one in deck["disks"] + deck.get("packings", []))
    deck["measure"] = {**deck.get("measure", {}), "groups": grouped, "box": True, "stress": True, "rattlers": True, "fragments": True, "walls": bool(deck.get("walls"))}


@added("outputs", "rows")
def rows_of_results(r, deck):
    deck["output"] = {"series": r.choice((1, 7, 10)), "frames": r.choice((25, 50)), "contacts": r.choice((30, 60))}
    measure_sums(deck)


@added("outputs", "rows of phases")
def rows_of_phases(r, deck):
    for phase in deck["phases"]:
        phase.update(series=r.choice((5, 13)), frames=r.choice((0, 40)), contacts=r.choice((0, 70)), measure=r.random() < 0.7)
    deck["checkpoint"] = 1e-3


def call(deck, r, *calls):
    """Some of these, in any order, at two moments."""
    some = r.sample(calls, min(len(calls), 6))
    deck["calls"] = [f"{step}: {one}" for step, one in zip([110] * (len(some) // 2) + [190] * len(some), some)]


def free_disks(deck):
    """Numbers of those that no motion leads and nothing holds."""
    need_disks(deck)
    led = {motion.get("disk") for motion in deck.get("motions", ())}
    return [k for k, d in enumerate(deck["disks"]) if not {"fixed", "locked"} & set(d) and d["name"] not in led]


SINGLE = {"bodies": ("free", "held", "locked", "inertia", "forces")}
MOTION_KEYS = ("velocity", "amplitude", "force", "pressure")


@added("calls", "laws")
def set_laws(r, deck):
    pairs = ((0, "grain"),) if len(deck["materials"]) == 1 else ((0, "grain"), (3, "steel"))
    laws = {law["name"]: law for law in deck["materials"]}
    call(deck, r, *(f"set law.{key} {index} {laws[name][key] * r.uniform(0.9, 1.1):.4g}"
                    for index, name in pairs for key in laws[name] if type(laws[name][key]) in (int, float)))


@added("calls", "laws of bonds", bond=("springs", "beams that damp", "brittle", "sinter"), **UNBRIDGED)
def set_laws_of_bonds(r, deck):
    law = deck["materials"][0]
    call(deck, r, *(f"set law.{key} 0 {value * r.uniform(0.9, 1.1):.4g}" for key, value in law.items()
                    if key.startswith("bond_") and type(value) is float))


@added("calls", "gravity")
def set_gravity(r, deck):
    call(deck, r, *(f"set gravity {axis} {r.uniform(-10, 10):.4g}" for axis in (0, 0, 1, 1)))


@added("calls", "motions")
def set_motions(r, deck):
    some = [f"set motion.{key} {k} {motion[key] * r.uniform(0.8, 1.2):.4g}"
            for k, motion in enumerate(deck.get("motions", ())) for key in MOTION_KEYS if key in motion]
    if not some:
        raise Unsuitable
    call(deck, r, *some)


@added("calls", "kicks", **SINGLE)
def kick(r, deck):
    some = [r.choice(free_disks(deck)) for _ in range(8)]
    x, y, both = (deck["disks"][k] for k in some[:3])
    call(deck, r, *(f"set {name} {k} {r.uniform(-0.5, 0.5):.4g}" for name, k in zip(("vx", "vy", "omega", "angle"), some[3:])),
         f"set velocity {some[7]} {r.uniform(-0.5, 0.5):.4g} {r.uniform(-0.5, 0.5):.4g}", f"set x {some[0]} {x['x']:.6g}",
         f"set y {some[1]} {y['y']:.6g}", f"set position {some[2]} {both['x']:.6g} {both['y']:.6g}")


@added("calls", "sizes", **SINGLE)
def set_sizes(r, deck):
    some = [(k, deck["disks"][k]["radius"]) for k in r.sample(free_disks(deck), 2)]
    call(deck, r, *(f"set radius {k} {radius * r.uniform(0.98, 1.002):.6g}" for k, radius in some),
         *(f"set mass {k} {3.14 * radius**2 * r.uniform(0.9, 1.5):.4g}" for k, radius in some),
         *(f"set inertia {k} {1.57 * radius**4 * r.uniform(0.9, 1.5):.4g}" for k, radius in some))


@added("calls", "hold and release", **SINGLE)
def call_hold_and_release(r, deck):
    first, second = r.sample(free_disks(deck), 2)
    deck["calls"] = [f"60: set held {first} 1", f"120: set held {second} 1", f"160: set held {first} 0", f"240: set held {second} 0"]


@added("calls", "disks added and removed", box=("open",), **SINGLE)
def add_and_remove(r, deck):
    last, high = len(deck["disks"]), max(d["y"] + d["radius"] for d in deck["disks"])
    gone = r.choice(free_disks(deck))
    deck["calls"] = [f"70: add {r.uniform(-0.02, 0.02):.4g} {high + 0.06:.6g} 0.045", f"140: remove {gone}", f"210: remove {last}"]


@added("calls", "bonds", bond=("none",), **UNBRIDGED, **SINGLE)
def call_bonds(r, deck):
    cement(r, deck, lambda: {"bond_k_n": r.uniform(300, 900), "bond_k_t": r.uniform(200, 500), "bond_extension": r.uniform(2e-4, 2e-3)})
    del deck["phases"][0]["bond"]
    deck["calls"] = [f"{step}: bond {r.choice(free_disks(deck))} {r.randrange(len(deck['disks']))}" for step in (1, 1, 60, 60, 120, 180)]
