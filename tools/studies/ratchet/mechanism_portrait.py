"""Phase portraits: the upper disk's velocity against its angle, and the way of its centre with the equilibria."""
import math

import numpy as np

from . import mechanism_film
from .mechanism import BASE
from .mechanism_theory import SIGNS, System, forces
from .page import Figure, Section
from .runs import slipdisk
from .style import BLACK, COLOURS, CONFIGURATIONS, GREY, LIGHT, figure, legend_below

RUNS = (("portrait_random", "random vibration"), ("sync_strong", "in phase"), ("async_strong", "opposite phases"))
FILM = "async_weak"  # all four configurations last long enough to be seen
ROWS = 400
SPAN = 0.1  # time shown: a period of the turning supports
DIGITS_OF = {"angle_upper": 9, "angle_left": 8, "angle_right": 8, "x": 6, "y": 6, **dict.fromkeys(
    ("time", "spin_upper", "spin_left", "spin_right", "x_left", "y_left", "x_right", "y_right", "n1", "n2", "tau1",
     "tau2"), 5)}  # significant digits that are kept
ORDER = [*SIGNS, "stick", "open"]


def trace(path):
    """Columns of one period: angles and velocities, centre, forces, and the configuration of the two contacts."""
    result = slipdisk.Result(path)
    frames, contacts = result.frames, result.contacts
    time = frames.time
    last = time[-1]
    ks = np.nonzero((time > last - SPAN * 1.0001) & (time > 0))[0]
    ks = ks[np.unique(np.linspace(0, len(ks) - 1, min(ROWS, len(ks))).round().astype(int))]
    place, angle, spin = frames["position"][ks], frames["angle"][ks], frames["angular_velocity"][ks]
    at = {round(t, 9): k for k, t in enumerate(contacts.time)}
    out = {"time": time[ks] - time[ks[0]], "x": place[:, 0, 0], "y": place[:, 0, 1]}
    for i, name in enumerate(("upper", "left", "right")):
        out[f"angle_{name}"], out[f"spin_{name}"] = angle[:, i], spin[:, i]
    out["x_left"], out["y_left"], out["x_right"], out["y_right"] = (place[:, i, j] for i in (1, 2) for j in (0, 1))
    pairs = [touching(contacts[at[round(float(t), 9)]]) for t in time[ks]]
    for k, name in enumerate(("n1", "n2", "tau1", "tau2", "configuration")):
        out[name] = np.array([pair[k] for pair in pairs])
    return out


def touching(table):
    """(n1, n2, tau1, tau2, configuration) of the two contacts of disk 0; tau > 0: a positive torque on it."""
    n, tau, slides = [0.0, 0.0], [0.0, 0.0], [0, 0]
    for row in table:
        k = int(row["b"]) - 1
        n[k], tau[k], slides[k] = float(row["force"]), float(row["tau"]), int(row["sliding"])
    if min(n) <= 0:
        name = "open"
    elif 0 in slides:
        name = "stick"
    else:
        name = next(key for key, signs in SIGNS.items() if signs == tuple(int(math.copysign(1, t)) for t in tau))
    return (*n, *tau, name)


def numbers(results, name):
    def make():
        path = results.run(name)
        return trace(path) if path else None
    return results.numbers(f"mechanism-portrait-{name.replace('_', '-')}", make, digits=DIGITS_OF,
                           title=f"One period of the run {name}: upper disk, supports, contacts",
                           units="lengths in R, forces in m g, tau > 0: positive torque on the upper disk")


def drive_of(results, name):
    """Amplitude of the drive of a run."""
    info = results.numbers(f"mechanism-drive-{name.replace('_', '-')}", lambda: {
        "amplitude": slipdisk.Result(results.run(name)).deck.motions[0].amplitude} if results.run(name) else None)
    return info.rows[0]["amplitude"] if info else math.nan


def equilibria(system):
    """Centre of the upper disk at the translational equilibrium of each configuration, from where the disks just "
      "touch."""
    s, c = math.sin(system.theta_h), math.cos(system.theta_h)
    towards = np.array([[-s, -c], [s, -c]])
    return {key: np.linalg.solve(towards, np.array(forces(system, signs)) / system.k_n) for key, signs in SIGNS.items()}


def sections(results):
    out = Section("mechanism-portrait", "Phase portraits", "One period 2&pi;/&omega;, tilt 0.04&pi;: random "
                                                           "vibration at "
                  "&epsilon;<sub>b</sub> = 10<sup>&minus;4</sup> (<code>inputs/three_disk/random.cfg</code>), "
                  "supports that "
                  "turn in phase and in opposite phases at &Theta;<sub>b</sub> = 0.04 (<code>sync.cfg</code>, "
                  "<code>async.cfg</code>).", new=True)
    tables = {name: numbers(results, name) for name, _ in RUNS}
    out.missing = [f"{name}: not run yet" for name, table in tables.items() if not table]
    amplitudes = {name: drive_of(results, name) for name, _ in RUNS}
    film = numbers(results, FILM)
    told = ""
    if film:
        mechanism_film.write(film, results.folder)
        told = (" A film of one period in opposite phases (&Theta;<sub>b</sub> = 0.002), angles and displacements "
                "magnified: <code>figures/cycle.gif</code>.")
    out.figures.append(draw(tables, amplitudes, told))
    return [out]


def draw(tables, amplitudes, told):
    picture, axes = figure(3, 2, width=7.6, height=5.4, legend=True)
    points = equilibria(System(tilt=BASE["tilt"]))
    for k, (name, title) in enumerate(RUNS):
        table = tables[name]
        above, below = axes[0, k], axes[1, k]
        above.set_title(title)
        if not table:
            continue
        unit = amplitudes[name]
        speed = unit * BASE["omega_b"]
        part = np.array([row["configuration"] for row in table.rows])
        angle = table.column("angle_upper") + table.column("angle_left")
        angle = (angle - angle.mean()) / unit
        velocity = (table.column("spin_upper") + table.column("spin_left")) / speed
        x, y = 1e4 * table.column("x"), 1e4 * table.column("y")
        for axis, a, b in ((above, angle, velocity), (below, x, y)):
            axis.plot(a, b, color=LIGHT, lw=0.8, zorder=1, gid="guide")
            for key, colour in zip(ORDER, (*COLOURS[:4], GREY, BLACK)):
                mask = part == key
                if mask.any() or k == 0:
                    axis.plot(a[mask], b[mask], ".", ms=3.5, color=colour, label=CONFIGURATIONS[key][0],
                              zorder=2 + (key in SIGNS))
        for n, (key, place) in enumerate(points.items()):
            below.plot(*(1e4 * place), marker="*", ms=11, mfc=COLOURS[n], mec=BLACK, mew=0.7, ls="none", zorder=5)
        above.set_xlabel(r"$(\theta+\theta_1)\,/\,$amplitude")
        below.set_xlabel(r"$x\times10^4$")
    axes[0, 0].set_ylabel(r"$(\Omega+\dot\theta_1)\,/\,$velocity")
    axes[1, 0].set_ylabel(r"$y\times10^4$")
    legend_below(picture, axes[0, 0], 6, markerscale=2, columnspacing=1, handletextpad=0.2)
    return Figure("mechanism-portrait", picture, "Above: velocity of the upper disk relative to the left support's "
                                                 "surface "
                  "against their relative angle. Below: way of the upper disk's centre from where the disks just "
                  "touch; "
                  "stars: translational equilibrium points of the four configurations, in their colours. Grey dots: a "
                  "contact sticks." + told, "Phase portraits of the upper disk and the way of its centre")
