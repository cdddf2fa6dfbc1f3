"""Frequency of the turning supports, which the paper leaves open, and of the random vibration."""
import math

import numpy as np

from .data import Table
from .page import Figure, Numbers, Section
from .style import BLACK, figure, in_pi, legend_above, points, zero_line
from .turning import matched, sweep_points
from .verdict import approaches, number, signed

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
        line, slug = turning.where(phase=phase), title.split()[-1].replace("phases", "opposite")
        out.append(signed(f"The sense of rotation {title} does not depend on the frequency.", line.disk("omega"),
                          line.disk("omega_error"), sign,
                          names=[name_of(row, "theta_b", "&Theta;") for row in line.rows], slug=f"frequency-{slug}"))
        out.append(better(split(line, "theta_b", "omega_b", BASE_AMPLITUDE)[SCALED] if line else line, title, slug))
    told = [name_of(row, "eps_b", "&epsilon;") for row in random.rows]
    claim = signed("Under random vibration the rotation is clockwise at all frequencies.", random.disk("omega"),
                   random.disk("omega_error"), -1, names=told, slug="frequency-random")
    openings = random.column("upper.left.openings") + random.column("upper.right.openings")
    if (openings > 0).any():
        claim.numbers += "; contacts open at " + ", ".join(t for t, n in zip(told, openings) if n > 0)
    return [*out, claim]


def name_of(row, amplitude, symbol):
    return f"{row['omega_b'] / PI:g} &pi; with {symbol}<sub>b</sub> = {number(row[amplitude])}"


def better(line, title, slug):
    """The deviation from theory falls with the frequency as a deviation does that approaches zero."""
    text = (f"{title[0].upper() + title[1:]} &Omega; approaches theory as the frequency falls (fixed "
            "&Theta;<sub>b</sub>&omega;<sub>b</sub>&sup2;).")
    down = Table(line.sorted("omega_b").rows[::-1])
    known = down.column("theory.mean")
    return approaches(text, down.column("omega_b") / PI, down.disk("omega") / known - 1,
                      down.disk("omega_error") / np.abs(known), slug=f"frequency-theory-{slug}", unit=" &pi;")
