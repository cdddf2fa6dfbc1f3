"""Which noise is rectified: single coordinates, one support only, the same signals on both."""
import math

import numpy as np

from .mechanism import PI, points
from .mechanism_theory import Drive, System, predicted
from .page import Figure, Numbers, Section
from .style import figure, in_pi, power, zero_line
from .style import points as draw_points
from .verdict import CHECK, NO, OPEN, SURE, YES, Claim, decide, missing, number, zero

OMEGA = 20 * PI
# (key, label, coordinates, supports, by signals of their own)
CASES = (
    ("own-xyt", r"$x,y,\theta$", ("x", "y", "theta"), "both", True),
    ("own-x", "$x$", ("x",), "both", True),
    ("own-y", "$y$", ("y",), "both", True),
    ("own-xy", "$x,y$", ("x", "y"), "both", True),
    ("own-t", r"$\theta$", ("theta",), "both", True),
    ("one-xyt", r"$x,y,\theta$", ("x", "y", "theta"), "both", False),
    ("one-x", "$x$", ("x",), "both", False),
    ("one-y", "$y$", ("y",), "both", False),
    ("one-xy", "$x,y$", ("x", "y"), "both", False),
    ("one-t", r"$\theta$", ("theta",), "both", False),
    ("left", "left only", ("x", "y", "theta"), "left", True),
    ("right", "right only", ("x", "y", "theta"), "right", True),
)
PANELS = (("own", "own signals"), ("one", "the same signals"), ("", "one support"))
WORDS = {"own-xyt": "<i>x</i>, <i>y</i>, &theta;", "own-x": "<i>x</i>", "own-y": "<i>y</i>",
         "own-xy": "<i>x</i>, <i>y</i>", "own-t": "&theta;"}


def word(case):
    if case in ("left", "right"):
        return f"{case} support only"
    kind, coordinates = case.split("-")
    return WORDS[f"own-{coordinates}"] + (", own signals" if kind == "own" else ", the same signals")


def case_of(row):
    """Key of the case that a row of the sweep belongs to."""
    if row.get("support") in ("left", "right"):
        return row["support"]
    used = "".join(name[0] for name in ("x", "y", "theta") if name in row["coordinates"])
    return ("own-" if row["own"] == "true" else "one-") + used


def theory(case, eps, tilt):
    """Strong drive, Omega over the rms velocity of a coordinate."""
    _, _, coordinates, supports, own = next(c for c in CASES if c[0] == case)
    used = {"both": (0, 1), "left": (0,), "right": (1,)}[supports]
    return predicted(System(tilt=tilt), Drive(1.0 / OMEGA, OMEGA, coordinates=coordinates, supports=used, own=own))


def sections(results):
    out = Section("mechanism-noise", "Which noise is rectified", "Deck <code>inputs/paper/mechanism_noise.cfg</code>: "
                  "random vibration (52) of single coordinates, of one support only, and of both supports by the same "
                  "signals. Errors join the error bars of two replicas. Theory: permanent sliding with the torques "
                  "(15)-(18) at strong drive, the supports' velocities and the linear response of the upper centre "
                  "being Gaussian (no free parameter).", new=True)
    table = points(results.sweep("mechanism_noise"), lambda row: row["eps_b"] * OMEGA)
    out.missing = list(table.missing)
    for row in table.rows:
        row["case"] = case_of(row)
    lines = {(case[0], eps): table.where(case=case[0], eps_b=eps).sorted("tilt") for case in CASES
             for eps in table.values("eps_b")}
    out.figures.append(draw(lines, table.values("eps_b")))
    out.claims = claims(lines, table)
    rows = []
    for (case, eps), line in lines.items():
        rows += [[word(case), eps, row["tilt"] / PI, row["omega"], row["error"], theory(case, eps, row["tilt"]),
                  *(row[f"upper.{part}"] for part in ("pp", "pm", "mp", "mm", "stick", "open"))] for row in line.rows]
    out.tables.append(Numbers("All points", ["noise", "&epsilon;<sub>b</sub>", "&theta;<sub>T</sub>/&pi;",
                                             "&Omega;/&epsilon;<sub>b</sub>&omega;", "error", "strong drive",
                                             "S<sup>++</sup>", "S<sup>+&minus;</sup>", "S<sup>&minus;+</sup>",
                                             "S<sup>&minus;&minus;</sup>", "a contact sticks",
                                             "a contact is open"], rows))
    return [out]


def draw(lines, amplitudes):
    rows = max(len(amplitudes), 1)
    picture, axes = figure(3, rows, width=7.6, height=2.6 * rows + 0.2, legend=True, squeeze=False)
    for i, eps in enumerate(amplitudes):
        for axis, (group, title) in zip(axes[i], PANELS):
            cases = [c for c in CASES if c[0].startswith(group + "-" if group else ("left", "right"))]
            for k, (case, label, *_) in enumerate(cases):
                line = lines.get((case, eps))
                if line:
                    draw_points(axis, line.column("tilt") / PI, line.column("omega"), line.column("error"), label,
                                k if group else k + 5, "os^vDP<"[k if group else k + 5], line="-", ms=4)
            zero_line(axis)
            in_pi(axis.xaxis, 0.04)
            axis.set_title(f"{title}, $\\epsilon_b={power(eps)}$", fontsize=10)
        axes[i, 0].set_ylabel(r"$\Omega/\epsilon_b\omega$")
    for axis in axes[-1]:
        axis.set_xlabel(r"tilt $\theta_T$")
    shown = [axes[0, k].get_legend_handles_labels() for k in (0, 2)]
    picture.legend_place.legend(*(sum((part[n] for part in shown), []) for n in (0, 1)), loc="center", ncol=7,
                                columnspacing=1, handletextpad=0.3)
    return Figure("mechanism-noise", picture, "Mean angular velocity against tilt for single coordinates of the "
                  "vibration, in units of the rms velocity of one coordinate. Left: each coordinate of each support by "
                  "its own signal; middle: both supports by the same signals (mind the scale); right: one support "
                  "vibrates, the other rests. Lines join points.",
                  "Angular velocity against tilt for single coordinates, one support, and equal signals")


def claims(lines, table):
    if not table:
        return [missing("Which noise is rectified.", kind=CHECK, slug="noise-rectified")]
    out = []
    strongest = table.values("eps_b")[-1]
    told = []
    for case, *_ in CASES:
        line = lines[case, strongest]
        at = line.where(tilt=0.04 * PI)
        if at:
            row = at.rows[0]
            told.append((row["omega"] / row["error"] if row["error"] > 0 else 0.0, case, row))
    turning = [(z, case, row) for z, case, row in told if abs(z) > SURE]
    senses = {1: "counter-clockwise", -1: "clockwise"}
    parts = []
    for sign, name in senses.items():
        those = [f"{word(c)} ({number(r['omega'], r['error'])})" for z, c, r in turning if np.sign(z) == sign]
        parts.append(f"{name}: {', '.join(those) or 'none'}")
    rest = [f"{word(c)} ({number(r['omega'], r['error'])})" for z, c, r in told if abs(z) <= SURE]
    own = [z for z, case, _ in told if case in ("own-x", "own-y", "own-t")]
    out.append(decide("Each coordinate by itself (<i>x</i>, <i>y</i>, &theta;; own signals) is rectified at a tilt of "
                      "0.04&pi;.", (lambda factor: all(abs(z) > factor * SURE for z in own)) if len(own) == 3 else None,
                      f"&Omega;/&epsilon;<sub>b</sub>&omega; at &epsilon;<sub>b</sub> = {strongest:g}, tilt 0.04&pi;: "
                      + "; ".join(parts) + f"; within {SURE:g} errors of zero: {', '.join(rest) or 'none'}",
                      kind=CHECK, slug="noise-coordinates"))
    flat = [row for case, *_ in CASES if case not in ("left", "right") for eps in table.values("eps_b")
            for row in lines[case, eps].where(tilt=0.0).rows]
    out.append(zero("Without tilt no noise that treats both supports alike is rectified.",
                    [r["omega"] for r in flat], [r["error"] for r in flat], kind=CHECK, slug="noise-symmetric"))
    out.append(one_support(lines, table))
    out.append(mirror(lines, table))
    return out


def one_support(lines, table):
    """One support at rest breaks the reflection symmetry, but not that of the signs of the torques."""
    text = "A single vibrating support turns the disk without any tilt."
    rows = [(eps, side, row) for eps in table.values("eps_b") for side in ("left", "right")
            for row in lines[side, eps].where(tilt=0.0).rows]
    if not rows:
        return missing(text, kind=CHECK, slug="noise-one-support")
    z = [row["omega"] / row["error"] for _, _, row in rows]
    told = "; ".join(f"{side} at &epsilon;<sub>b</sub> = {eps:g}: {number(row['omega'], row['error'])}"
                     for eps, side, row in rows)

    def judge(factor):
        sure = [abs(v) > factor * SURE for v in z]
        return YES if all(sure) else NO if not any(sure) else OPEN

    told += (" (&Omega;/&epsilon;<sub>b</sub>&omega;). Theory has none: without tilt the torques of S<sup>++</sup> and "
             "S<sup>&minus;&minus;</sup> are opposite, those of S<sup>+&minus;</sup>, S<sup>&minus;+</sup> zero, "
             "whatever the supports do")
    return Claim(text, judge, told, kind=CHECK, slug="noise-one-support")


def mirror(lines, table):
    """Reflection takes (left, tilt) to (right, -tilt): at zero tilt the two are opposite."""
    text = "Without tilt left and right support turn the disk in opposite senses, equally fast."
    gaps, errors = [], []
    for eps in table.values("eps_b"):
        both = [lines[side, eps].where(tilt=0.0).rows for side in ("left", "right")]
        if all(both):
            gaps.append(both[0][0]["omega"] + both[1][0]["omega"])
            errors.append(math.hypot(both[0][0]["error"], both[1][0]["error"]))
    return zero(text, gaps, errors, kind=CHECK, slug="noise-mirror", what="sum of both &Omega;")
