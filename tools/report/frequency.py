"""Frequency of the turning supports, which the paper leaves open, and of the random vibration."""
import math

import numpy as np

from .page import Figure, Numbers, Section
from .style import BLACK, figure, in_pi, legend_above, points, zero_line
from .turning import matched, sweep_points
from .verdict import SURE, Claim, decide, missing, NO, OPEN, YES

PI = math.pi
BASE_AMPLITUDE, BASE_EPS, BASE_OMEGA = 0.04, 1e-4, 20 * PI
FIXED, SCALED = "fixed amplitude", "fixed amplitude times frequency squared"


def split(table, amplitude, frequency, base):
    """{FIXED: points at the base amplitude, SCALED: points with amplitude * frequency^2 as at the base}"""
    constant = base * BASE_OMEGA ** 2
    return {FIXED: table.where(**{amplitude: base}).sorted(frequency),
            SCALED: table.such(lambda row: abs(row[amplitude]
                                               * row[frequency] ** 2 / constant - 1) < 1e-3).sorted(frequency)}


def sections(results):
    out = Section("frequency", "Frequency of the drive", "Tilt 0.04&pi;. Left, middle: supports that turn (parabola), "
                  "decks <code>inputs/paper/frequency.cfg</code>; by theory "
                  "&Omega;/&Theta;<sub>b</sub>&omega;<sub>b</sub> depends on the drive through "
                  "&Theta;<sub>b</sub>&omega;<sub>b</sub>&sup2; only. Right: random vibration, "
                  "<code>frequency_random.cfg</code>. Each at fixed amplitude (&Theta;<sub>b</sub> = 0.04, "
                  "&epsilon;<sub>b</sub> = 10<sup>&minus;4</sup>) and at fixed amplitude times frequency squared.",
                  new=True)
    turning = matched(results, "frequency", "frequency.cfg", sweep_points(results, "frequency"))
    random = results.sweep("frequency_random").joined()
    out.missing = turning.missing + random.missing
    picture, axes = figure(3, 1, height=4.0, width=7.6)
    rows = []
    for k, (phase, title) in enumerate(((0.0, "in phase"), (PI, "opposite phases"))):
        for n, (name, line) in enumerate(split(turning.where(phase=phase), "theta_b", "omega_b",
                                               BASE_AMPLITUDE).items()):
            if not line:
                continue
            w, unit = line.column("omega_b"), line.column("theta_b") * line.column("omega_b")
            points(axes[k], w / PI, line.disk("omega") / unit, line.disk("omega_error") / unit, "fixed $\\Theta_b$"
                   if n == 0 else "fixed $\\Theta_b\\omega_b^2$", n, "os"[n], line="none")
            exact = line.column("theory.mean") / unit
            if np.isfinite(exact).any():
                axes[k].plot(w / PI, exact, color=BLACK, ls="-" if n == 0 else "--", lw=0.9,
                             label="exact, fixed $\\Theta_b$" if n == 0 else "exact, $\\Theta_b\\omega_b^2$")
            rows += [[f"{title}, {name}", row["theta_b"], row["omega_b"] / PI, row["upper.omega"] / u,
                      row["upper.omega_error"] / u, x, row["upper.left.openings"] + row["upper.right.openings"]]
                     for row, u, x in zip(line.rows, unit, exact)]
        axes[k].set_title(title, pad=66)
        axes[k].set_xlabel(r"frequency $\omega_b$")
        axes[k].set_ylabel(r"$\Omega/\Theta_b\omega_b$")
    for n, (name, line) in enumerate(split(random, "eps_b", "omega_b", BASE_EPS).items()):
        if line:
            points(axes[2], line.column("omega_b") / PI, 1e4 * line.disk("scaled"), 1e4 * line.disk("scaled_error"),
                   "fixed $\\epsilon_b$" if n == 0 else "fixed $\\epsilon_b\\omega^2$", n, "os"[n])
        rows += [[f"random, {name}", row["eps_b"], row["omega_b"] / PI, row["upper.scaled"], row["upper.scaled_error"],
                  math.nan, row["upper.left.openings"] + row["upper.right.openings"]] for row in line.rows]
    axes[2].set_title("random vibration", pad=66)
    axes[2].set_xlabel(r"frequency $\omega$")
    axes[2].set_ylabel(r"$t_g\,\Omega\times10^{4}$")
    for axis in axes:
        axis.set_xscale("log")
        axis.set_xticks([5, 10, 20, 40, 80])
        axis.set_xticks([], minor=True)
        in_pi(axis.xaxis)
        axis.set_xlim(4, 100)
        zero_line(axis)
        if axis.get_legend_handles_labels()[0]:
            legend_above(axis, 1, fontsize=9, handlelength=1.5, labelspacing=0.2)
    out.figures.append(Figure("frequency", picture, "Rotation against the frequency of the drive. Lines on the left "
                              "and in the middle: exact solution of permanent sliding at the same amplitude and "
                              "frequency; on the right they join points.",
                              "Rotation against the frequency of the drive"))
    out.claims = claims(turning, random)
    out.tables.append(Numbers("All points", ["", "amplitude", "frequency/&pi;",
                                             "&Omega;/&Theta;<sub>b</sub>&omega;<sub>b</sub>, or "
                                             "<i>t<sub>g</sub></i>&Omega;",
                                             "error", "exact", "openings"], rows))
    return [out]


def claims(turning, random):
    out = []
    for phase, title, sign in ((0.0, "in phase", 1), (PI, "in opposite phases", -1)):
        line = turning.where(phase=phase)
        text = f"The sense of rotation {title} does not depend on the frequency."
        if line:
            right = sign * line.disk("omega") > SURE * line.disk("omega_error")
            out.append(decide(text, bool(right.all()) if right.all()
                              or (sign * line.disk("omega") < -SURE * line.disk("omega_error")).any() else None,
                              f"{int(right.sum())} of " f"{len(line)} points have the sign of 20 &pi; by more than "
                              f"{SURE:g} errors"))
        else:
            out.append(missing(text))
        fixed = split(line, "theta_b", "omega_b", BASE_AMPLITUDE)[SCALED] if line else line
        text = (f"{title[0].upper() + title[1:]}, theory is met better at lower frequency (fixed "
                "&Theta;<sub>b</sub>&omega;<sub>b</sub>&sup2;).")
        off = np.abs(fixed.disk("omega") / fixed.column("theory.mean") - 1) if fixed else np.array([])
        if len(off) > 2 and np.isfinite(off).all():
            told = ", ".join(f"{100 * o:.{1 if o < 0.1 else 0}f} % at {w / PI:g} &pi;" for o,
                             w in zip(off, fixed.column("omega_b")))
            out.append(decide(text, bool(off[0] < off[-1]), "deviation from the exact solution " + told))
        else:
            out.append(missing(text))
    text = "Under random vibration the rotation is clockwise at all frequencies."
    if random:
        z = random.disk("omega") / random.disk("omega_error")
        verdict = NO if (z > SURE).any() else YES if (z < -SURE).sum() > len(z) / 2 else OPEN
        out.append(Claim(text, verdict, f"of {len(z)} points {int((z < -SURE).sum())} are negative and "
                         f"{int((z > SURE).sum())} positive by more than {SURE:g} errors; openings at "
                         + str(int(((random.column('upper.left.openings')
                                     + random.column('upper.right.openings')) > 0).sum())) + " of them"))
    else:
        out.append(missing(text))
    return out
