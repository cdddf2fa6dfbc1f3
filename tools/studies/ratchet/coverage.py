"""Do error bars cover what they should? The scatter of many seeds against the error bars of each."""
import math

import numpy as np
from matplotlib.ticker import NullFormatter

from .page import Figure, Numbers, Section
from .style import BLACK, COLOURS, GREY, figure, points, power
from .verdict import CHECK, NO, OPEN, SURE, YES, Claim, beyond, scattering, missing, number, survival

WITHIN = (1, 2, 3)  # error bars
NORMAL = [math.erf(k / math.sqrt(2)) for k in WITHIN]
LINES = ("-", "--", ":")
FEWEST = 10  # seeds of a set that counts


def sections(results):
    out = Section("coverage", "Coverage of error bars",
                  "Random vibration (tilt 0.02&pi;), deck <code>inputs/paper/coverage.cfg</code>: many seeds for each "
                  "measured time and amplitude. <i>z</i> is the distance of a run's &Omega; from the mean of its set "
                  "in its own error bars, times &radic;(<i>n</i>/(<i>n</i> &minus; 1)). Were the error bars known "
                  "exactly, <i>z</i> would be normal. Runs that call their error bar unreliable do not "
                  "count.", new=True)
    table = results.sweep("coverage")
    out.missing = list(table.missing)
    cases = [case for case in map(measured, table.sets()) if case]
    out.claims = [ratio_claim(cases), within_claim(cases)]
    if cases:
        known = 100 * np.mean([case["spread"] / case["bar"] for case in cases])
        out.lead += f" They scatter by {known:.0f} % themselves, so that its tails are a little longer."
        out.figures.append(draw(cases))
        out.tables.append(numbers(cases))
    return [out]


def measured(members):
    """What the runs of one set say; None: too few."""
    omega, error = members.disk("omega"), members.disk("omega_error")
    reliable = members.disk("converged") > 0
    good = np.isfinite(omega) & (error > 0) & reliable
    omega, error, n = omega[good], error[good], int(good.sum())
    if n < FEWEST:
        return None
    scatter = float(omega.std(ddof=1))
    z = (omega - omega.mean()) / error * math.sqrt(n / (n - 1))
    ratio = float(error.mean()) / scatter
    return {"length": members.rows[0]["length"], "eps_b": members.rows[0]["eps_b"], "n": n, "scatter": scatter,
            "bar": float(error.mean()), "spread": float(error.std(ddof=1)), "ratio": ratio,
            "ratio_error": ratio * math.hypot(1 / math.sqrt(2 * (n - 1)),
                                              error.std(ddof=1) / error.mean() / math.sqrt(n)),
            "z": np.sort(z),
            "within": [float((np.abs(z) < k).mean()) for k in WITHIN],
            "reliable": float(np.mean(reliable))}


def name_of(case):
    return f"{case['length']:g} time units at {number(case['eps_b'])}"


def ratio_claim(cases):
    """Too large and too small bars count alike: chi^2 of the ratios from 1."""
    text, kind = "The mean error bar is the scatter of seeds, at each length and amplitude.", {"slug": "coverage-ratio"}
    if not cases:
        return missing(text, kind=CHECK, **kind)
    off = [(case["ratio"] - 1) / case["ratio_error"] for case in cases]
    chi2 = float(np.sum(np.square(off)))
    worst = cases[max(range(len(cases)), key=lambda k: abs(off[k]))]
    ratios = ", ".join(number(case["ratio"], case["ratio_error"]) for case in cases)
    numbers = (f"ratios {ratios}; &chi;&sup2; from 1 = {chi2:.1f} for {len(cases)} (a chance of "
               f"{100 * survival(chi2, len(cases)):.2g} % for more); farthest off: {name_of(worst)}")
    return Claim(text, scattering(chi2, len(cases)), numbers, kind=CHECK, rule="scatter", **kind)


def within_claim(cases):
    """As many within one and two error bars as a normal law has, in each set; both sides."""
    text, kind = "Within one and two error bars lie as many runs as a normal law has.", {"slug": "coverage-within"}
    if not cases:
        return missing(text, kind=CHECK, **kind)
    off = [(found - p) / math.sqrt(p * (1 - p) / case["n"])
           for case in cases for found, p in list(zip(case["within"], NORMAL))[:2]]
    worst, limit = max(map(abs, off)), beyond(len(off))
    runs = sum(case["n"] for case in cases)
    pooled = [100 * sum(case["within"][k] * case["n"] for case in cases) / runs for k in range(len(WITHIN))]
    numbers = (f"of {runs} runs " + ", ".join(f"{x:.1f} % within {k}" for k, x in zip(WITHIN, pooled)) + " (normal: "
               + ", ".join(f"{100 * p:.1f} %" for p in NORMAL) + f"); of {len(off)} fractions the farthest off is "
               f"{worst:.1f} of its standard deviations away ({limit:.1f} refute)")
    return Claim(text, lambda factor: NO if worst > beyond(len(off), factor) else OPEN if worst > factor * SURE else YES,
                 numbers, kind=CHECK, rule="threshold", **kind)


def draw(cases):
    """Distribution function of z against the normal one, and the mean error bar over the scatter."""
    picture, (left, right) = figure(2)
    grid = np.linspace(-4, 4, 400)
    normal = [0.5 * math.erfc(-x / math.sqrt(2)) for x in grid]
    left.plot(grid, normal, color=BLACK, lw=1.4, gid="guide", label="normal")
    lengths = sorted({case["length"] for case in cases})
    for k, eps in enumerate(sorted({case["eps_b"] for case in cases})):
        line = sorted((case for case in cases if case["eps_b"] == eps), key=lambda case: case["length"])
        for case in line:
            share = (np.arange(case["n"]) + 0.5) / case["n"]
            left.plot(case["z"], share, color=COLOURS[k], ls=LINES[lengths.index(case["length"]) % 3], lw=1)
        points(right, [case["length"] * (0.96 + 0.08 * k) for case in line], [case["ratio"] for case in line],
               [case["ratio_error"] for case in line], rf"$\epsilon_b={power(eps)}$", k, "os^"[k % 3])
    for k, length in enumerate(lengths):
        left.plot([], [], color=GREY, ls=LINES[k % 3], lw=1, label=f"{length:g}")
    left.set_xlabel(r"$z$: distance in error bars")
    left.set_ylabel(r"fraction of runs below $z$")
    left.set_xlim(-4, 4)
    left.legend(title="measured time", loc="upper left", fontsize=8, title_fontsize=8)
    right.axhline(1, color=BLACK, lw=1.4, zorder=0, gid="guide")
    right.set_xscale("log")
    right.set_xticks(lengths, [f"{length:g}" for length in lengths])
    right.xaxis.set_minor_formatter(NullFormatter())
    right.set_xlabel("measured time")
    right.set_ylabel("mean error bar / scatter")
    right.set_ylim(0, 1.5)
    right.legend(loc="lower right")
    caption = ("Left: fraction of runs below <i>z</i> for each amplitude &epsilon;<sub>b</sub> (colour) and measured "
               "time (line), and the normal law; a steeper curve means error bars that are too large. Right: mean "
               "error bar over the scatter of seeds.")
    return Figure("coverage", picture, caption, "Distribution of the distance from the mean in error bars, and mean "
                  "error bar over scatter against the measured time")


def numbers(cases):
    """Fractions stand with the standard deviation that the normal law gives them."""
    columns = ["measured time", "&epsilon;<sub>b</sub>", "seeds", "scatter of &Omega;", "mean error bar", "bar/scatter",
               "error", *(word for k in WITHIN for word in (f"within {k}", "error")), "reliable"]
    rows = [[c["length"], c["eps_b"], c["n"], c["scatter"], c["bar"], c["ratio"], c["ratio_error"],
             *(x for found, p in zip(c["within"], NORMAL) for x in (found, math.sqrt(p * (1 - p) / c["n"]))),
             c["reliable"]] for c in cases]
    law = ", ".join(f"{p:.4f}" for p in NORMAL)
    return Numbers(f"Coverage; a normal law has {law} within 1, 2, 3", columns, rows)
