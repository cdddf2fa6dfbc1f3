"""What the durations predict: sense and size of the rotation without a free parameter, and which ingredient fails."""
import math
import os

import numpy as np

from . import kept, mechanism_walk
from .data import Table
from .mechanism import PI, all_coordinates, key
from .mechanism import points as sweep_points
from .mechanism import told as shown
from .mechanism_tep import STRONG, chosen
from .mechanism_tep import points as tep_points
from .mechanism_theory import SIGNS, Drive, System, covariance, predicted, steady
from .page import Figure, Numbers, Section
from .style import BLACK, COLOURS, figure, in_pi, legend_above, power, zero_line
from .style import points as draw_points
from .verdict import CHECK, NO, OPEN, SURE, YES, Claim, decide, missing, number, together

OMEGA = 20 * PI
STIFFEST = 1e6  # k_n
EQUAL = 0.1    # sizes within 10 % count as equal
STEEP = 0.1 * PI  # tilt of the random rotation
XYT, TURN = ("x", "y", "theta"), ("theta",)
# At the drive's true strength: coordinates, amplitude, tilt/pi, whether friction moves the centre
WALKS = (*((XYT, eps, 0.04, 0) for eps in (2e-5, 5e-5, 1e-4, 3e-4, 1e-3)),
         *((XYT, eps, 0.04, 1) for eps in (1e-5, 2e-5, 4e-5, 7e-5, 1e-4)),
         *((XYT, 1e-4, tilt, moved) for moved in (0, 1) for tilt in (0.02, 0.08)),
         *((TURN, eps, 0.1, moved) for moved in (0, 1) for eps in (1e-4, 1e-3, 1e-2)))

WORDS = ("Predictions without a free "
         "parameter: (i) <i>strong drive</i>: torques (15)-(18), and the probabilities of the four configurations "
         "at a steady &Omega;, as the velocities with which the supports drag the upper disk are Gaussian (their "
         "covariance follows from (52) and from the linear response of the upper centre); &Omega; is where the "
         "mean torque vanishes. (ii) <i>true strength</i>: <i>I</i>d&Omega;/d<i>t</i> = "
         "<i>T</i><sup>&plusmn;&plusmn;</sup> with the same torques and velocities, so that the disk catches up "
         "with the supports and goes along with one of them for a while. (iii) <i>measured torques</i> in place of "
         "(15)-(18) in (i). (iv) <i>moving centre</i>: as (ii), with the normal forces of the moment in place of "
         "(15)-(18): friction moves the centre, which needs time for it; of the simulation only the tangential "
         "spring and openings are left out. Decks <code>inputs/paper/mechanism.cfg</code>, "
         "<code>mechanism_rotation.cfg</code>.")


def walks(results):
    """Omega over the rms velocity of permanent sliding at the true strength. It takes seconds for each row: what a call
    before this one has found with the same settings is taken over."""
    settings = "; ".join(map(str, (mechanism_walk.STEP, mechanism_walk.COPIES, mechanism_walk.WARM, mechanism_walk.TIME,
                                   len(WALKS))))

    def make():
        path = os.path.join(results.store.folder, "mechanism-walk.csv")
        if os.path.exists(path) and kept.head_of(path).get("settings") == settings:
            return Table.read(path, finished_only=False)
        if results.dry or results.level == "quick":
            return None
        rows = []
        for coordinates, eps, tilt, moved in WALKS:
            drive = Drive(eps, OMEGA, coordinates=coordinates)
            value, error, parts = mechanism_walk.mean(System(tilt=tilt * PI), drive, bool(moved))
            unit = eps * OMEGA
            rows.append([" ".join(coordinates), eps, tilt, moved, value / unit, error / unit, *parts])
        names = ("coordinates", "eps_b", "tilt", "moved", "omega", "error", *SIGNS, "stuck")
        return {name: [row[k] for row in rows] for k, name in enumerate(names)}
    return results.numbers("mechanism-walk", make, digits=6, settings=settings, units="tilt in pi, omega in eps_b w",
                           title="Permanent sliding under random vibration at the true strength of the drive: torques "
                           "(15)-(18), moved = 1: the normal forces of the moment")


def with_measured(p):
    """Omega at which the measured torques balance with Gaussian durations."""
    if not all(math.isfinite(p.part[c]["torque"][0]) for c in SIGNS):
        return math.nan
    drive = Drive(p.amplitude, p.omega_b)
    value = steady({c: p.part[c]["torque"][0] for c in SIGNS}, covariance(p.system, drive))
    return value / (p.amplitude * p.omega_b)


def sections(results):
    out = Section("mechanism-size", "Sense and size of the rotation from the durations", WORDS, new=True)
    found, gaps = tep_points(results)
    table = sweep_points(results.sweep("mechanism_rotation"), lambda r: r["eps_b"] * OMEGA)
    mechanism = sweep_points(results.sweep("mechanism"), lambda r: key(r, "eps_b") * key(r, "omega_b"))
    random = mechanism.such(lambda r: all_coordinates(r) and abs(key(r, "omega_b") - OMEGA) < 1e-6 and
                            isinstance(r.get("tilt"), float))
    walk = walks(results)
    out.missing = [*gaps, *table.missing]
    out.figures.append(draw(random, found, table, walk))
    out.claims = claims(found, random, table, walk)
    out.tables += tables(random, found, table, walk)
    return [out]


def curve(axis, x, values, colour, style, label):
    axis.plot(x, values, color=colour, lw=1.1, ls=style, label=label, gid="guide")


def draw(random, found, table, walk):
    picture, axes = figure(3, 1, width=7.8, height=4.4)
    for axis, column, where, scale in ((axes[0], "eps_b", {"tilt": 0.04 * PI}, 1.0),
                                       (axes[1], "tilt", {"eps_b": 1e-4}, 1 / PI)):
        line = random.where(**where).sorted(column)
        if line:
            draw_points(axis, scale * line.column(column), line.column("omega"), line.column("error"), "simulation", 0,
                        "o", line="none", ms=5)
        dense = np.geomspace(1e-5, 1e-3, 30) if column == "eps_b" else np.linspace(0, 0.085 * PI, 40)
        drives = [(System(tilt=0.04 * PI), Drive(v)) if column == "eps_b" else (System(tilt=v), Drive()) for v in dense]
        curve(axis, scale * dense, [predicted(s, d) / (d.eps * d.omega) for s, d in drives], BLACK, "-", "strong "
                                                                                                         "drive (i)")
        for n, label in enumerate(("true strength (ii)", "moving centre (iv)")):
            there = walk.where(coordinates="x y theta", moved=float(n), **(
                {"tilt": 0.04} if column == "eps_b" else {"eps_b": 1e-4})).sorted(column)
            if there:
                draw_points(axis, there.column(column), there.column("omega"), there.column("error"), label,
                            (1, 5)[n], "sx"[n], line=":", ms=4 + 2 * n)
        fixed = {"amplitude" if k == "eps_b" else k: v for k, v in where.items()}
        mine = [p for p in chosen(found, "random", omega_b=OMEGA, **fixed)]
        if mine:
            axis.plot([p.amplitude if column == "eps_b" else p.tilt / PI for p in mine],
                      [with_measured(p) for p in mine], "^", color=COLOURS[2], mfc="white", ms=4.5,
                      label="measured torques (iii)")
        zero_line(axis)
        axis.set_title("all coordinates, " + (r"$\theta_T=0.04\pi$" if column == "eps_b" else r"$\epsilon_b=10^{-4}$"),
                       pad=74, fontsize=10)
    legend_above(axes[0], 1, fontsize=8.5, labelspacing=0.15)
    axes[0].set_xscale("log")
    in_pi(axes[1].xaxis, 0.04)
    rotation(axes[2], table, walk.where(coordinates="theta", tilt=0.1))
    axes[0].set_xlabel(r"amplitude $\epsilon_b$")
    axes[1].set_xlabel(r"tilt $\theta_T$")
    axes[2].set_xlabel(r"amplitude $\epsilon_b$")
    axes[0].set_ylabel(r"$\Omega/\epsilon_b\omega$")
    return Figure("mechanism-size", picture, "Mean angular velocity in units of the rms velocity of one coordinate: "
                  "simulation and predictions without a free parameter. Left and middle: random vibration of all "
                  "coordinates. Right: the supports turn at random and do nothing else, each by its own signal or both "
                  "by one; lines: strong drive (i), squares: true strength (ii).",
                  "Angular velocity against amplitude and tilt with predictions without a free parameter")


def rotation(axis, table, walk):
    for k, (own, label) in enumerate((("true", "own signals"), ("false", "one signal"))):
        for k_n, sign, fill in ((1e3, "o", "white"), (1e5, "v", "white"), (STIFFEST, "D", COLOURS[k + 3])):
            line = rotation_line(table, own, k_n)
            if line:
                draw_points(axis, line.column("eps_b"), line.column("omega"), line.column("error"),
                            None if k else f"$k_n={power(k_n)}$", k + 3, sign, line="none", ms=5, mfc=fill)
        axis.text(0.03, 0.84 if k else 0.02, label, color=COLOURS[k + 3], transform=axis.transAxes, fontsize=9)
        aim = strong_rotation(own == "true")
        axis.axhline(aim, color=COLOURS[k + 3], lw=1.1, gid="guide")
    for n, label in enumerate(("(ii)", "(iv), $k_n=10^3$")):
        line = walk.where(moved=float(n)).sorted("eps_b")
        if line:
            draw_points(axis, line.column("eps_b"), line.column("omega"), line.column("error"), label, (1, 5)[n],
                        "sx"[n], line=":", ms=4 + 2 * n)
    zero_line(axis)
    axis.set_xscale("log")
    axis.set_title(r"random rotation, $\theta_T=0.1\pi$", pad=74, fontsize=10)
    if axis.get_legend_handles_labels()[0]:
        legend_above(axis, 1, fontsize=8.5, labelspacing=0.15)


def rotation_line(table, own, k_n):
    """Points of the random rotation at the steep tilt."""
    return table.such(lambda row: row["own"] == own and abs(key(row, "k_n") / k_n - 1) < 1e-6
                      and abs(turned(row) - STEEP) < 1e-6).sorted("eps_b")


def strong_rotation(own):
    return predicted(System(tilt=STEEP), Drive(1 / OMEGA, OMEGA, coordinates=("theta",), own=own))


def strength_at(walk, eps, tilt, moved=0):
    """(Omega, error) at the true strength of the drive, all coordinates; NaN where it has not been computed."""
    there = walk.such(lambda w: w["coordinates"] == "x y theta" and w["moved"] == moved
                      and abs(w["eps_b"] / eps - 1) < 1e-6 and abs(w["tilt"] * PI - tilt) < 1e-6)
    return (there.rows[0]["omega"], there.rows[0]["error"]) if there else (math.nan, math.nan)


def tables(random, found, table, walk):
    rows = []
    for row in sorted(random.rows, key=lambda r: (r["eps_b"], r["tilt"])):
        eps, tilt = row["eps_b"], row["tilt"]
        mine = chosen(found, "random", amplitude=eps, tilt=tilt, omega_b=OMEGA)
        rows.append([eps, tilt / PI, row["omega"], row["error"],
                     predicted(System(tilt=tilt), Drive(eps)) / (eps * OMEGA),
                     *strength_at(walk, eps, tilt), with_measured(mine[0]) if mine else math.nan,
                     *strength_at(walk, eps, tilt, 1)])
    unit = "&Omega;/&epsilon;<sub>b</sub>&omega;"
    size = Numbers("Size of the rotation, all coordinates", [
        "&epsilon;<sub>b</sub>", "&theta;<sub>T</sub>/&pi;", unit, "error", "strong drive (i)", "true strength (ii)",
        "error", "measured torques (iii)", "moving centre (iv)", "error"], rows)
    rows = [["own signals" if row["own"] == "true" else "one signal", key(row, "k_n"), row["eps_b"], turned(row) / PI,
             row["omega"], row["error"]] for row in table.rows]
    return [size, Numbers("Random rotation", ["", "<i>k<sub>n</sub></i>", "&epsilon;<sub>b</sub>",
                                              "&theta;<sub>T</sub>/&pi;", unit, "error"], rows)]


def turned(row):
    """Tilt of a row of the random rotation."""
    return row["tilt"] if isinstance(row.get("tilt"), float) else STEEP


def equal(text, value, error, aim, aim_error, slug):
    off, spread = value / aim - 1, math.hypot(error, aim_error * value / aim) / abs(aim)
    return Claim(text, lambda factor: within_errors(off, spread, factor * EQUAL), f"&Omega;/&epsilon;<sub>b</sub>&omega; = {number(value, error)}, predicted "
                 f"{number(aim, aim_error or None)}: a ratio of {number(value / aim, spread)} (counted as equal up to "
                 f"{100 * EQUAL:g} %)", kind=CHECK, slug=slug)


def within_errors(off, spread, limit):
    """One error inside the limit counts as equal, three outside as not."""
    return YES if abs(off) + spread <= limit else NO if abs(off) - SURE * spread > limit else OPEN


def claims(found, random, table, walk):
    out = [sense(found)]
    for own, word, slug in (("true", "each by its own signal", "size-own"),
                            ("false", "both by one signal", "size-one")):
        text = (f"Supports that turn at random, {word}: at strong drive and with stiff disks (<i>k<sub>n</sub></i> = "
                "10<sup>6</sup>) &Omega; is that of the torques (15)-(18) and of Gaussian durations (i).")
        line = rotation_line(table, own, STIFFEST)
        if not line:
            out.append(missing(text, kind=CHECK, slug=slug))
            continue
        weight = 1 / line.column("error") ** 2
        value = float(np.sum(weight * line.column("omega")) / np.sum(weight))
        out.append(equal(text, value, float(1 / math.sqrt(np.sum(weight))), strong_rotation(own == "true"), 0.0, slug))
    row = next(iter(random.where(eps_b=1e-4, tilt=0.04 * PI).rows), None)
    mine = chosen(found, "random", amplitude=1e-4, tilt=0.04 * PI, omega_b=OMEGA)
    for text, slug, aim in (
            ("All coordinates, &epsilon;<sub>b</sub> = 10<sup>&minus;4</sup>, tilt 0.04&pi;: strong drive (i) gives "
             "the size.",
             "size-strong", (predicted(System(tilt=0.04 * PI), Drive()) / (1e-4 * OMEGA), 0.0)),
            ("The same with measured torques (iii).", "size-measured", (with_measured(mine[0]), 0.0) if mine else None),
            ("The same at the true strength of the drive (ii).", "size-walk",
             strength_at(walk, 1e-4, 0.04 * PI)),
            ("The same with the normal forces of the moment, friction moving the centre (iv).", "size-moved",
             strength_at(walk, 1e-4, 0.04 * PI, 1))):
        if row is None or aim is None or not math.isfinite(aim[0]):
            out.append(missing(text, kind=CHECK, slug=slug))
        else:
            out.append(equal(text, row["omega"], row["error"], *aim, slug))
    return [*out, everywhere(random, walk)]


def everywhere(random, walk):
    """(iv) against the simulation at all amplitudes and tilts for which it has been computed."""
    text = "Permanent sliding with a moving centre (iv) gives &Omega; at all amplitudes and tilts."
    pairs = []
    for row in random.rows:
        aim, error = strength_at(walk, row["eps_b"], row["tilt"], 1)
        if math.isfinite(aim) and row["tilt"] > 0:
            ratio = row["omega"] / aim
            pairs.append((ratio, math.hypot(row["error"], error * ratio) / abs(aim), row))
    if not pairs:
        return missing(text, kind=CHECK, slug="size-everywhere")
    low, high = min(pairs, key=lambda p: p[0]), max(pairs, key=lambda p: p[0])
    return Claim(text, lambda factor: together([within_errors(p[0] - 1, p[1], factor * EQUAL) for p in pairs]),
                 f"simulation over prediction at {len(pairs)} points from " + " to ".join(
                     f"{number(p[0], p[1])} (&epsilon;<sub>b</sub> = {number(p[2]['eps_b'])}, tilt {p[2]['tilt'] / PI:g} &pi;)"
                     for p in (low, high)) + f" (counted as equal up to {100 * EQUAL:g} %)", kind=CHECK,
                 slug="size-everywhere", rule="equal")


def sense(found):
    """Sign of the TEP torques with the durations measured at zero tilt against that of Omega."""
    text = ("The durations measured without tilt, with the TEP torques just after tilting, predict the sense: "
            "random, in phase and opposite phases.")
    told, fine = [], []
    for drive, title, where in STRONG:
        line = chosen(found, drive, **where)
        level = [p for p in line if p.tilt == 0]
        tilted = sorted((p for p in line if p.tilt > 0), key=lambda p: p.tilt)
        if not level or not tilted:
            return missing(text, kind=CHECK, slug="weights-sense")
        torque = tilted[0].balance(level[0])
        sense_of = tilted[0].omega
        fine.append(bool(np.sign(torque) == np.sign(sense_of[0]) and abs(sense_of[0]) > SURE * (sense_of[1] or 0.0)))
        parts = ", ".join(f"{level[0].share(c):.3f}" for c in SIGNS)
        told.append(f"{title}: durations {parts}, torque {number(torque)}, &Omega; = {shown(*sense_of)} at tilt "
                    f"{tilted[0].tilt / PI:g} &pi;")
    return decide(text, all(fine), "; ".join(told) + " (durations of S<sup>++</sup>, S<sup>+&minus;</sup>, "
                                                     "S<sup>&minus;+</sup>, "
                  "S<sup>&minus;&minus;</sup>)", kind=CHECK, slug="weights-sense")
