"""Torque, normal forces and durations of each sliding configuration against the translational equilibrium points."""
import math

import numpy as np

from .mechanism import PI, all_coordinates, key, mean, name_of
from .mechanism_theory import SIGNS, System, forces, torques
from .page import Figure, Numbers, Section
from .catalogue import paper
from .style import COLOURS, CONFIGURATIONS, GREY, configuration, figure, in_pi, legend_below, zero_line
from .style import points as draw_points
from .verdict import CHECK, NO, OPEN, PAPER, SURE, TOLERANCES, YES, Claim, decide, in_fields, missing, number

LEAST = 1e-3   # fraction of time below which a configuration does not count
CLOSE = 0.1    # torques and forces within 10 % count as those of the equilibrium
UNDONE = 0.2   # of the torque just after tilting may be left over
DAMPING = 0.5  # of the random vibration: t_c = 1/(c w)
SUMS = (("pp", "mm"), ("pm", "mp"))
PLACE = "section 4"


class Point:
    """One set of the sweep: each configuration's fraction, torque, forces and durations with errors."""

    def __init__(self, members):
        row = members.rows[0]
        self.tilt, self.omega_b = key(row, "tilt"), key(row, "omega_b")
        self.random = "phase" not in row
        self.amplitude = key(row, "eps_b" if self.random else "theta_b")
        self.drive = ("random" if all_coordinates(row) else "random rotation") if self.random else (
            "in phase" if abs(row["phase"]) < 1e-9 else "opposite phases")
        self.system = System(tilt=self.tilt)
        self.tep = torques(self.system)
        self.omega = mean(members, "upper.omega")
        self.time, self.replicas = row["upper.measured"], len(members)
        self.part = {c: {name: mean(members, f"upper.{c}" + (f".{name}" if name else ""))
                         for name in ("", "torque", "torque_sd", "left.force", "right.force", "dwell", "dwell_sd")}
                     for c in (*SIGNS, "stick", "open")}

    def share(self, c):
        value = self.part[c][""][0]
        return value if math.isfinite(value) else 0.0

    def seen(self):
        return [c for c in SIGNS if self.share(c) > LEAST]

    def measured(self):
        """Mean torque from what is measured of all six."""
        return sum(self.share(c) * self.part[c]["torque"][0] for c in self.part if self.share(c) > 0)

    def balance(self, durations=None):
        """Mean torque with those of the equilibria and the durations of this point, or of another."""
        return sum((durations or self).share(c) * self.tep[c] for c in SIGNS)

    def error(self):
        return math.sqrt(sum((self.part[c][""][1] * self.tep[c]) ** 2 for c in SIGNS
                             if math.isfinite(self.part[c][""][1])))

    def sum_of(self, a, b):
        """(sum of the torques of two configurations, its error)"""
        (x, dx), (y, dy) = self.part[a]["torque"], self.part[b]["torque"]
        return x + y, math.hypot(dx, dy)

    def deviations(self, name):
        """[(relative deviation from the equilibrium, its error, configuration)]; name: "torque" or "force"."""
        out = []
        for c in self.seen():
            if name == "torque":
                pairs = [(self.part[c]["torque"], self.tep[c])]
            else:
                pairs = [(self.part[c][f"{side}.force"], aim)
                         for side, aim in zip(("left", "right"), forces(self.system, SIGNS[c]))]
            out += [(value / aim - 1, error / abs(aim) if math.isfinite(error) else 0.0, c)
                    for (value, error), aim in pairs if aim and math.isfinite(value)]
        return out


def points(results):
    tables = [results.sweep("mechanism"), results.sweep("mechanism_turning")]
    found = {}  # equal points of two grids are one
    for table in tables:
        for p in map(Point, table.sets()):
            found.setdefault((p.drive, round(p.amplitude, 9), round(p.omega_b, 6), round(p.tilt, 9)), p)
    return list(found.values()), [line for table in tables for line in table.missing]


def chosen(found, drive, **conditions):
    return [p for p in found if p.drive == drive and all(abs(getattr(p, k) / v - 1) < 1e-6 if v else getattr(p, k) == 0
                                                         for k, v in conditions.items())]


STRONG = (("random", "random vibration", {"amplitude": 1e-4, "omega_b": 20 * PI}),
          ("in phase", "in phase", {"amplitude": 0.04, "omega_b": 20 * PI}),
          ("opposite phases", "opposite phases", {"amplitude": 0.04, "omega_b": 20 * PI}))
VELOCITY = {"random": 1e-4 * 20 * PI, "random rotation": 1e-2 * 20 * PI, "in phase": 0.04 * 20 * PI,
            "opposite phases": 0.04 * 20 * PI}


def values(points_there, configuration, name):
    """(means, errors) to be drawn; without replicas there are no errors."""
    pairs = [p.part[configuration][name] for p in points_there]
    return [value for value, _ in pairs], np.nan_to_num([error for _, error in pairs])


def of_velocity(found, drive):
    """The points at the fixed velocity and tilt, by frequency."""
    line = [p for p in found if p.drive == drive and abs(p.tilt / (0.04 * PI) - 1) < 1e-6
            and abs(p.amplitude * p.omega_b / VELOCITY[drive] - 1) < 1e-3]
    return sorted({p.omega_b: p for p in line}.values(), key=lambda p: p.omega_b)


def sections(results):
    out = Section("mechanism-tep", "Torque and forces of each configuration", "Means over the time that the contacts "
                                                                              "spend "
                  "in each sliding configuration, against the translational equilibrium points (TEPs): the torques "
                  "(15)-(18) and the normal forces that belong to them. Decks "
                  "<code>inputs/paper/mechanism.cfg</code> (errors "
                  "from the scatter of replicas) and <code>mechanism_turning.cfg</code>, key "
                  "<code>measure.configurations</code>.", new=True)
    found, out.missing = points(results)
    out.figures += [against_tilt(found), against_frequency(found)]
    out.claims = claims(found)
    rows = []
    for p in found:
        for c in SIGNS:
            if p.share(c) <= 0:
                continue
            part, aim = p.part[c], forces(p.system, SIGNS[c])
            rows.append([p.drive, p.amplitude, p.omega_b / PI, p.tilt / PI, name_of(c),
                         *part[""], *part["torque"], p.tep[c], part["torque_sd"][0], *part["left.force"], aim[0],
                         *part["right.force"], aim[1], part["dwell"][0], part["dwell_sd"][0]])
    out.tables.append(Numbers("Torque, normal forces and durations of each configuration", [
        "drive", "amplitude", "&omega;/&pi;", "&theta;<sub>T</sub>/&pi;", "", "fraction of time", "error", "torque",
        "error", "(15)-(18)", "standard deviation", "<i>n</i><sub>1</sub>", "error", "TEP", "<i>n</i><sub>2</sub>",
        "error", "TEP",
        "mean visit", "standard deviation"], rows))
    out.tables.append(durations(found))
    return [out]


def durations(found):
    """Visits against the correlation time and the periods of the normal oscillation."""
    rows = []
    for p in found:
        if abs(p.tilt - 0.04 * PI) > 1e-6 or p.drive == "random rotation":
            continue
        t_c = 1 / (DAMPING * p.omega_b) if p.random else math.nan
        x, y = (math.sqrt(2 * p.system.k_n / p.system.mass) * f(p.system.theta_h) for f in (math.sin, math.cos))
        rows.append([p.drive, p.amplitude, p.omega_b / PI, *(1e3 * p.part[c]["dwell"][0] for c in (*SIGNS, "stick")),
                     1e3 * t_c, 1e3 / x, 1e3 / y])
    return Numbers("Mean duration of a visit at tilt 0.04&pi;, in 10<sup>&minus;3</sup> time units", [
        "drive", "amplitude", "&omega;/&pi;", *map(name_of, SIGNS),
        "a contact sticks", "<i>t<sub>c</sub></i>", "1/&omega;<sub>x</sub>", "1/&omega;<sub>y</sub>"], rows)


def against_tilt(found):
    picture, axes = figure(3, 2, width=7.6, height=5.6, legend=True, sharex=True)
    tilts = np.linspace(0, 0.085 * PI, 60)
    curves = {c: np.array([[torques(System(tilt=t))[c], *forces(System(tilt=t), SIGNS[c])] for t in tilts])
              for c in SIGNS}
    for col, (drive, title, where) in enumerate(STRONG):
        line = sorted({p.tilt: p for p in chosen(found, drive, **where)}.values(), key=lambda p: p.tilt)
        above, below = axes[0, col], axes[1, col]
        for k, c in enumerate(SIGNS):
            there = [p for p in line if p.share(c) > LEAST]
            x = np.array([p.tilt / PI for p in there])
            shown = bool(there)
            for axis, names, index in ((above, ("torque",), (0,)), (below, ("left.force", "right.force"), (1, 2))):
                for n, (name, i) in enumerate(zip(names, index)):
                    if shown:
                        axis.plot(tilts / PI, curves[c][:, i], color=COLOURS[k], lw=1, ls="-" if n == 0 else "--",
                                  gid="guide")
                        draw_points(axis, x, *values(there, c, name),
                                    **{**configuration(c), **({} if axis is above else {"label": None})}, line="none", ms=4.5,
                                    **({"mfc": COLOURS[k]} if n == 0 and axis is below else {}))
        above.set_title(title)
        zero_line(above)
        in_pi(below.xaxis, 0.04)
        below.set_xlabel(r"tilt $\theta_T$")
    axes[0, 0].set_ylabel("torque")
    axes[1, 0].set_ylabel("$n_1$ (filled), $n_2$ (open)")
    legend_below(picture, axes.flat, 4)
    return Figure("mechanism-tep", picture, "Mean torque (above) and normal forces (below) while the contacts are in "
                                            "each "
                  "configuration, against tilt. Lines: translational equilibrium points (below: solid "
                  "<i>n</i><sub>1</sub>, dashed <i>n</i><sub>2</sub>). Random: &epsilon;<sub>b</sub> = "
                  "10<sup>&minus;4</sup>; "
                  "turning supports: &Theta;<sub>b</sub> = 0.04; &omega; = 20&pi;. Configurations that last less "
                  "than 0.1 % of the "
                  "time are left out.", "Torque and normal forces of each sliding configuration against tilt")


def against_frequency(found):
    drives = (("random", "random vibration"), ("random rotation", "random rotation, strong"), ("in phase", "in phase"),
              ("opposite phases", "opposite phases"))
    picture, axes = figure(4, 2, width=7.8, height=4.6, legend=True, sharey="row", sharex=True)
    tep = torques(System(tilt=0.04 * PI))
    for (above, below), (drive, title) in zip(axes.T, drives):
        line = of_velocity(found, drive)
        for k, c in enumerate(SIGNS):
            there = [p for p in line if p.share(c) > LEAST]
            if there:
                draw_points(above, [p.omega_b / PI for p in there], *values(there, c, "torque"), **configuration(c),
                            line="none", ms=4)
                above.axhline(tep[c], color=COLOURS[k], lw=1, gid="guide")
        for k, (a, b) in enumerate(SUMS):
            there = [p for p in line if p.share(a) > LEAST and p.share(b) > LEAST]
            pairs = np.array([p.sum_of(a, b) for p in there]).reshape(-1, 2) / (tep[a] + tep[b])
            if there:
                draw_points(below, [p.omega_b / PI for p in there], pairs[:, 0], np.nan_to_num(np.abs(pairs[:, 1])),
                            f"{CONFIGURATIONS[a][0]} + {CONFIGURATIONS[b][0]} (below)", 4 + 2 * k, "DP"[k], line="-",
                            ms=4.5)
        below.axhline(1, color=GREY, lw=0.8, gid="guide")
        below.set_xscale("log")
        below.set_xlim(1.8, 450)
        in_pi(below.xaxis)
        for axis in (above, below):
            axis.axvline(100 / math.sqrt(2) / PI, color=GREY, lw=0.8, ls=":", gid="guide")
            zero_line(axis)
        below.set_xlabel(r"frequency $\omega$")
        above.set_title(title, fontsize=10)
    axes[0, 0].set_ylabel("torque")
    axes[1, 0].set_ylabel("sum / that of the TEPs")
    shown = [axis.get_legend_handles_labels() for axis in (axes[0, 0], axes[1, 0])]
    picture.legend_place.legend(*(sum((part[n] for part in shown), []) for n in (0, 1)), loc="center", ncol=6,
                                columnspacing=1, handletextpad=0.3)
    return Figure("mechanism-short", picture, "Above: mean torque of each configuration against the frequency of the "
                  "drive at a fixed velocity of the supports, tilt 0.04&pi;; lines: TEP. Below: sums of the torques of "
                  "opposite configurations, which are what is rectified, over those of the TEPs. Dotted: frequency "
                  "&omega;<sub>x</sub> of the upper centre's horizontal oscillation. Faster than that the centre "
                  "cannot follow: the torques become &plusmn;&mu;(<i>n</i><sub>1</sub> &plusmn; <i>n</i><sub>2</sub>) "
                  "of the same forces in all configurations, and the sums vanish.",
                  "Torque of each configuration against the frequency of the drive")


def judged(text, sets, name, place, slug, kind, limit=CLOSE):
    """All deviations of these points within a limit: one error inside, three outside."""
    every = [(d, e, c, p) for p in sets for d, e, c in p.deviations(name)]
    if not every:
        return missing(text, place, slug=slug, kind=kind)
    told = []
    for c in SIGNS:
        those = [x[0] for x in every if x[2] == c]
        if those:
            told.append(f"{name_of(c)} {100 * min(those):+.0f} to "
                        f"{100 * max(those):+.0f} %".replace("-", "&minus;"))
    off = [(abs(x[0]), x[1]) for x in every]
    near = sum(d + e <= limit for d, e in off)
    return Claim(text, lambda factor: all_within(off, factor * limit),
                 f"{near} of {len(every)} values at {len(sets)} points are within {100 * limit:g} %, "
                 f"{sum(d - SURE * e > limit for d, e in off)} farther by more than {SURE:g} errors: " + ", ".join(told), place,
                 kind, slug)


def all_within(off, limit):
    """off: pairs of a size and its error. All within the limit by an error, or one beyond it by three?"""
    return (NO if any(d - SURE * e > limit for d, e in off) else YES if all(d + e <= limit for d, e in off) else OPEN)


def claims(found):
    tilted = {drive: [p for p in found if p.drive == drive and p.tilt > 0] for drive in VELOCITY}
    base = {drive: [p for p in those if abs(p.omega_b / (20 * PI) - 1) < 1e-6] for drive, those in tilted.items()}
    strong = {drive: [p for p in base[drive] if abs(p.amplitude * p.omega_b / VELOCITY[drive] - 1) < 1e-3]
              for drive in VELOCITY}
    estimate = paper("tep-torque")
    out = [judged(estimate["text"], base["random"], "torque", estimate["place"], "tep-torque", PAPER,
                  TOLERANCES["estimate"]),
           judged("Under random vibration the TEP gives the mean normal forces.", base["random"], "force", PLACE,
                  "tep-forces", PAPER)]
    for drive in ("in phase", "opposite phases"):
        word = drive.replace(" ", "-")
        out += [judged(f"Turning {drive}, strongly, the mean torque of each configuration is that of its TEP.",
                       strong[drive], "torque", "sections 4.1, 4.2", f"tep-torque-{word}", PAPER),
                judged(f"Turning {drive}, strongly, the TEP gives the mean normal forces.", strong[drive], "force", "",
                       f"tep-forces-{word}", CHECK)]
    out.append(asymmetry(strong))
    return [*out, elastic(found), nearer(found), *longer(found), *balances(found, {**strong, "random": base["random"]})]


def asymmetry(strong):
    """The sums over opposite configurations are all that can turn the disk; are they those of the equilibria?"""
    text = ("What is rectified, the sums of the torques of S<sup>++</sup> and S<sup>&minus;&minus;</sup> and of "
            "S<sup>+&minus;</sup> and S<sup>&minus;+</sup>, is that of the TEPs under random vibration.")
    told, off = [], []
    for p in strong["random"]:
        for a, b in SUMS:
            (found, error), aim = p.sum_of(a, b), p.tep[a] + p.tep[b]
            off.append((abs(found / aim - 1), error / abs(aim)))
            if abs(p.tilt - 0.04 * PI) < 1e-6:
                told.append(f"{name_of(a)}, {name_of(b)}: {number(found, error)}, TEPs {number(aim)}")
    if not off:
        return missing(text, kind=CHECK, slug="tep-asymmetry")
    return Claim(text, lambda factor: all_within(off, factor * CLOSE),
                 f"at &epsilon;<sub>b</sub> = 10<sup>&minus;4</sup>, tilt 0.04&pi;: {'; '.join(told)}; "
                 f"{sum(d + e <= CLOSE for d, e in off)} of {len(off)} sums at {len(off) // 2} tilts within {100 * CLOSE:g} %",
                 kind=CHECK, slug="tep-asymmetry")


def elastic(found):
    """Judges the time in which a contact sticks, at drives whose upper disk is slow beside the supports."""
    fast = [p for drive in ("random rotation", "in phase", "opposite phases") for p in found
            if p.drive == drive and p.tilt > 0 and abs(p.amplitude * p.omega_b / VELOCITY[drive] - 1) < 1e-3]
    if not fast:
        return missing(**paper("elastic-short"))
    limit, worst = TOLERANCES["rare"], max(fast, key=lambda p: p.share("stick"))
    slow = [p.share("stick") for p in found if p.drive == "random" and p.tilt > 0]
    told = (f"a contact sticks for at most {100 * worst.share('stick'):.1f} % of the time at {len(fast)} points of supports that "
            f"turn strongly ({worst.drive}, &omega; = {worst.omega_b / PI:g} &pi;; counted as short below {100 * limit:g} %)")
    if slow:
        told += (f"; under the figures' random vibration, where the upper disk is no slower than its supports, for "
                 f"{100 * min(slow):.0f} to {100 * max(slow):.0f} %")
    return decide(condition=lambda factor: worst.share("stick") < factor * limit, numbers=told, **paper("elastic-short"))


def nearer(found):
    """The rms deviation of the four torques from those of the TEPs never rises with the correlation time and falls to half."""
    judges, told = [], []
    for drive, title in (("random", "all coordinates"), ("random rotation", "supports that turn strongly")):
        line = [(p.omega_b, p.deviations("torque")) for p in of_velocity(found, drive)]
        line = [row for row in line if len(row[1]) == len(SIGNS)][::-1]  # the longest correlation time last
        if len(line) < 4:
            continue
        size = np.array([math.sqrt(np.mean([d * d for d, _, _ in off])) for _, off in line])
        error = np.array([math.sqrt(sum((d * e) ** 2 for d, e, _ in off)) / len(off) for _, off in line]) / size
        change, spread = np.diff(size), np.hypot(error[1:], error[:-1])

        def judge(factor, size=size, change=change, spread=spread):
            return NO if (change > SURE * spread).any() else YES if size[-1] < factor * 0.5 * size[0] else OPEN

        judges.append(judge)
        told.append(f"{title}: " + ", ".join(f"{100 * d:.1f} % at &omega; = {w / PI:g} &pi;" for (w, _), d in zip(line, size)))
    if not judges:
        return missing(**paper("tep-correlation-time"))
    return Claim(verdict=lambda factor: in_fields([judge(factor) for judge in judges]), rule="fields",
                 numbers="rms relative deviation of the four torques, tilt 0.04 &pi;; " + "; ".join(told)
                 + " (counted as nearer when it never rises and falls to half)", **paper("tep-correlation-time"))


def longer(found):
    """Distance of the rectified sums from those of the equilibria at the lowest and the highest frequency."""
    out = []
    for drives, text, slug in (
            (("random",), "Under random vibration what is rectified, the sums of the torques of opposite configurations, comes "
             "the closer to that of the TEPs the longer the correlation time.", "tep-correlation-sums"),
            (("random rotation", "in phase", "opposite phases"), "The same at strong drive: supports that turn at "
             "random, in phase and in opposite phases.", "tep-correlation-strong")):
        told, parts = [], []
        for drive in drives:
            line = of_velocity(found, drive)
            for a, b in SUMS:
                there = [p for p in line if p.share(a) > LEAST and p.share(b) > LEAST]
                if len(there) < 4:
                    continue
                far = [abs(p.sum_of(a, b)[0] / (p.tep[a] + p.tep[b]) - 1) for p in there]
                parts.append(far[0] / far[-1])
                told.append(f"{drive}, {name_of(a)} and {name_of(b)}: {far[-1]:.2f} at &omega; = "
                            f"{there[-1].omega_b / PI:g} &pi;, {far[0]:.2f} at {there[0].omega_b / PI:g} &pi;")
        out.append(missing(text, slug=slug, kind=CHECK) if not told else
                   decide(text, lambda factor, parts=parts: max(parts) < factor * 0.5, "distance of the rectified sums from those of the TEPs, over these: "
                          + "; ".join(told) + " (counted as closer when halved from the highest to the lowest "
                          "frequency)", slug=slug, kind=CHECK))
    return out


def balances(found, those):
    """Torque times duration, with what is measured and with the TEPs."""
    text = "The measured torques times their durations add up to zero."
    # Left over is I (Omega(end) - Omega(begin))/time; the two follow the supports, whose surfaces move at 2 v (rms)
    # when all coordinates vibrate: about 3 v apart.
    rows = [(abs(p.measured()) * p.time * math.sqrt(p.replicas) / (3 * p.system.inertia * p.amplitude * p.omega_b), p)
            for p in found if p.seen()]
    out = []
    if rows:
        worst, p = max(rows, key=lambda row: row[0])
        out.append(decide(text, lambda factor: worst < factor * SURE, "left over, in units of <i>I</i>&Delta;&Omega;/time with the "
                          "&Delta;&Omega; of supports that vibrate like these: at most "
                          f"{number(worst, digits=2)} at {len(rows)} points ({p.drive}, amplitude {p.amplitude:g}; "
                          f"counted as zero below {SURE:g})", kind=CHECK, slug="torque-balance-measured"))
    else:
        out.append(missing(text, kind=CHECK, slug="torque-balance-measured"))
    for drive in ("random", "in phase", "opposite phases"):
        out.append(balance(drive, those[drive], found))
    return out


def balance(drive, those, found):
    """Have the durations adjusted until the TEP torques balance (41)? What is left over, in units of what they give "
      "with the
    durations at zero tilt."""
    text = f"With the TEP torques the durations satisfy (41), {drive}{'' if drive == 'random' else ', strong drive'}."
    place, slug = f"{PLACE}, eq. (41)", "torque-balance" + ("" if drive == "random" else "-" + drive.replace(" ", "-"))
    rows = []
    for p in those:
        level = chosen(found, drive, amplitude=p.amplitude, omega_b=p.omega_b, tilt=0.0)
        if level and p.balance(level[0]):
            start = p.balance(level[0])
            rows.append((p.balance() / start, p.error() / abs(start), p, start))
    if not rows:
        return missing(text, place, slug=slug)
    near = [r for r in rows if abs(r[0]) + r[1] <= UNDONE]
    low, high = min(rows, key=lambda r: r[0]), max(rows, key=lambda r: r[0])
    return Claim(text, lambda factor: all_within([(abs(r[0]), r[1]) for r in rows], factor * UNDONE),
                 "left over, in units of the torque just after tilting (durations as at zero tilt): from "
                 + " to ".join(f"{number(r[0], r[1] or None)} (amplitude {r[2].amplitude:g}, tilt {r[2].tilt / PI:g} "
                               f"&pi;)" for r in (low, high))
                 + f"; {len(near)} of {len(rows)} points below {UNDONE:g}", place, PAPER, slug)
