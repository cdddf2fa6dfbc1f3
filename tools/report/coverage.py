"""Do error bars cover what they should? The scatter of many seeds against the error bars of each."""
import math

import numpy as np

from .page import Figure, Numbers, Section
from .style import COLOURS, figure, legend_below, power
from .verdict import CHECK, NO, OPEN, SURE, YES, Claim, beyond, judged, missing, number, survival

WITHIN = (1, 2, 3)  # error bars
NORMAL = [math.erf(k / math.sqrt(2)) for k in WITHIN]
MARKERS = "ovs^D*"
FEWEST = 10  # seeds of a set that counts


def sections(results):
    out = Section("coverage", "Coverage of error bars", "Random vibration (tilt 0.02&pi;), deck "
                  "<code>inputs/paper/coverage.cfg</code>: up to 200 seeds for each length of the measured time and each "
                  "amplitude. <i>z</i> is the distance of a run's &Omega; from the mean of its set in its own error bars, "
                  "times &radic;(<i>n</i>/(<i>n</i> &minus; 1)). Were the error bars known exactly, <i>z</i> would be "
                  "normal. They are known to about 15 %, so that tails are a little longer.", new=True)
    table = results.sweep("coverage")
    out.missing = list(table.missing)
    cases = [case for case in map(measured, table.sets()) if case]
    out.claims = [ratio_claim(cases), within_claim(cases)]
    if cases:
        out.figures.append(draw(cases))
        out.tables.append(numbers(cases))
    return [out]


def measured(members):
    """What the runs of one set say; None: too few."""
    omega, error = members.disk("omega"), members.disk("omega_error")
    good = np.isfinite(omega) & (error > 0)
    omega, error, n = omega[good], error[good], int(good.sum())
    if n < FEWEST:
        return None
    scatter = float(omega.std(ddof=1))
    z = (omega - omega.mean()) / error * math.sqrt(n / (n - 1))
    ratio = float(error.mean()) / scatter
    return {"length": members.rows[0]["length"], "eps_b": members.rows[0]["eps_b"], "n": n, "scatter": scatter,
            "bar": float(error.mean()), "spread": float(error.std(ddof=1)), "ratio": ratio,
            "ratio_error": ratio * math.hypot(1 / math.sqrt(2 * (n - 1)), error.std(ddof=1) / error.mean() / math.sqrt(n)),
            "z": np.sort(z),
            "within": [float((np.abs(z) < k).mean()) for k in WITHIN],
            "reliable": float(np.mean(members.disk("converged")[good]))}


def name_of(case):
    return f"{case['length']:g} time units at {number(case['eps_b'])}"


def ratio_claim(cases):
    """Too large and too small bars count alike: chi^2 of the ratios from 1."""
    text, kind = "The mean error bar is the scatter of seeds, at each length and amplitude.", {"slug": "coverage-ratio"}
    if not cases:
        return missing(text, kind=CHECK, **kind)
    off = [(case["ratio"] - 1) / case["ratio_error"] for case in cases]
    chi2 = float(np.sum(np.square(off)))
    worst = max(range(len(cases)), key=lambda k: abs(off[k]))
    return Claim(text, judged(chi2, len(cases)), "ratios " + ", ".join(number(c["ratio"], c["ratio_error"]) for c in cases)
                 + f"; &chi;&sup2; from 1 = {chi2:.1f} for {len(cases)} (a chance of {100 * survival(chi2, len(cases)):.2g} % for "
                 f"more); farthest off: {name_of(cases[worst])}", kind=CHECK, rule="scatter", **kind)


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
    return Claim(text, NO if worst > limit else OPEN if worst > SURE else YES, f"of {runs} runs "
                 + ", ".join(f"{value:.1f} % within {k}" for k, value in zip(WITHIN, pooled)) + " (normal: "
                 + ", ".join(f"{100 * p:.1f} %" for p in NORMAL) + f"); {len(off)} fractions, the farthest off is {worst:.1f} "
                 f"of its standard deviations ({limit:.1f} refute)", kind=CHECK, rule="threshold", **kind)


def draw(cases):
    """Distribution function of z against the normal one: a curve that is steeper has bars that are too large."""
    picture, (left, right) = figure(2, legend=True)
    grid = np.linspace(-4, 4, 400)
    phi = np.array([0.5 * math.erfc(-x / math.sqrt(2)) for x in grid])
    left.plot(grid, phi, color="#111111", lw=1.2, gid="guide", label="normal")
    lengths = sorted({case["length"] for case in cases})
    for k, eps in enumerate(sorted({case["eps_b"] for case in cases})):
        for case in (c for c in cases if c["eps_b"] == eps):
            style = ("-", "--", ":")[lengths.index(case["length"]) % 3]
            share = (np.arange(case["n"]) + 0.5) / case["n"]
            left.plot(case["z"], share, drawstyle="steps-mid", color=COLOURS[k], ls=style, lw=0.9,
                      label=rf"${power(eps)}$, {case['length']:g}")
        line = sorted((c for c in cases if c["eps_b"] == eps), key=lambda c: c["length"])
        right.errorbar([c["length"] * (0.97 + 0.06 * k) for c in line], [c["ratio"] for c in line],
                       [c["ratio_error"] for c in line], fmt=MARKERS[k] + "-", color=COLOURS[k], mfc="white", lw=0.7)
    left.set_xlabel(r"$z$: distance from the mean in error bars")
    left.set_ylabel("fraction of runs below")
    left.set_xlim(-4, 4)
    right.axhline(1, color="#111111", lw=1.2, gid="guide")
    right.set_xscale("log")
    right.set_xlabel("measured time")
    right.set_ylabel("mean error bar / scatter")
    right.set_ylim(0, None)
    legend_below(picture, [left], 4)
    return Figure("coverage", picture, "Left: fraction of runs below <i>z</i> for each amplitude &epsilon;<sub>b</sub> "
                  "(colour) and length (line), and the normal law. Steeper than it: error bars too large. Right: mean error "
                  "bar over the scatter of seeds.", "Distribution of the distance from the mean in error bars, and mean "
                  "error bar over scatter against the measured time")


def numbers(cases):
    columns = ["length", "&epsilon;<sub>b</sub>", "seeds", "scatter of &Omega;", "mean error bar", "bars' own scatter",
               "bar/scatter", "error", *(f"within {k}" for k in WITHIN), *(f"normal {k}" for k in WITHIN),
               "binomial error of the first", "reliable"]
    return Numbers("Coverage", columns, [
        [c["length"], c["eps_b"], c["n"], c["scatter"], c["bar"], c["spread"], c["ratio"], c["ratio_error"], *c["within"],
         *NORMAL, math.sqrt(NORMAL[0] * (1 - NORMAL[0]) / c["n"]), c["reliable"]] for c in cases])
