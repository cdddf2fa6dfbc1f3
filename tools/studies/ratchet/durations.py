"""How long a visit to each sliding configuration lasts against the correlation time of the random vibration."""
import math

import numpy as np

from .catalogue import paper
from .page import Figure, Numbers, Section
from .style import figure, legend_right, points
from .verdict import NO, OPEN, TOLERANCES, YES, Claim, close, missing, number, sliding

PI = math.pi
DAMPING = 0.5  # t_c = 1/(c w)
SIGNS = {"pp": "++", "pm": "+-", "mp": "-+", "mm": "--"}


def visits(table):
    """{configuration: (correlation times, mean duration, its error)} at fixed rms velocity, shortest first."""
    chosen = table.such(lambda row: not row.get("coordinates") and isinstance(row.get("omega_b"), float)
                        and math.isfinite(row["omega_b"]))
    sets = sorted(chosen.sets(), key=lambda part: -part.rows[0]["omega_b"])
    times = np.array([1 / (DAMPING * part.rows[0]["omega_b"]) for part in sets])
    out = {}
    for name in SIGNS:
        lasting = [part.disk(f"{name}.dwell") for part in sets]
        mean = np.array([v.mean() for v in lasting])
        error = np.array([v.std(ddof=1) / math.sqrt(len(v)) if len(v) > 1 else math.nan for v in lasting])
        good = np.isfinite(mean) & (mean > 0)
        out[name] = times[good], mean[good], error[good]
    return out


def proportional(found):
    """The ratio of duration and correlation time is the same at all correlation times."""
    told, verdicts, limit = [], [], TOLERANCES["proportional"]
    for name, (times, mean, error) in found.items():
        if len(times) < 3:
            continue
        ratio, spread = mean / times, np.nan_to_num(error / times)
        low, high = int(np.argmin(ratio)), int(np.argmax(ratio))
        middle = (ratio[low] + ratio[high]) / 2
        error = math.hypot(spread[low], spread[high]) / 2
        verdicts.append(close((ratio[high] - middle) / middle, error / middle, limit))
        told.append(f"{sliding(SIGNS[name])} {number(ratio[low], spread[low])} (<i>t<sub>c</sub></i> = "
                    f"{number(times[low])}) to {number(ratio[high], spread[high])} ({number(times[high])})")
    if not told:
        return missing(**paper("durations-correlation"))
    verdict = next((word for word in (NO, OPEN) if word in verdicts), YES)
    return Claim(verdict=verdict, numbers="duration over correlation time from " + "; ".join(told)
                 + f" (counted as the same within &plusmn;{100 * limit:g} %)",
                 rule="equal", **paper("durations-correlation"))


def sections(results):
    out = Section("durations", "Duration of the configurations against the correlation time",
                  "Mean duration of a visit to each sliding configuration under random vibration at tilt 0.04&pi;; the "
                  "frequency is varied at a fixed rms velocity of the supports (deck "
                  "<code>inputs/paper/mechanism.cfg</code>). <i>t<sub>c</sub></i> = 1/<i>c</i>&omega;. The supports' "
                  "velocity under (52) is as rough as a random walk: where two velocities meet they cross many times, "
                  "and most visits are cut short.", new=True)
    table = results.sweep("mechanism")
    found = visits(table) if table.has("upper.pp.dwell") else {}
    out.claims = [proportional(found)]
    picture, axes = figure(height=3.4)
    for k, (name, (times, mean, error)) in enumerate(found.items()):
        points(axes, times, mean / times, np.nan_to_num(error / times),
               f"$S^{{{SIGNS[name]}}}$", k,
               "os^D"[k], ms=9 if k == 0 else 5)
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.set_xlabel(r"correlation time $t_c$")
    axes.set_ylabel(r"mean duration$/t_c$")
    if found:
        legend_right(axes, "visit to")
    out.figures.append(Figure("durations", picture, "Mean duration of a visit over the correlation time. Proportional: "
                                                    "a level line.",
                              "Mean duration of the sliding configurations over the correlation time"))
    out.tables.append(Numbers("Mean duration of a visit", ["", "<i>t<sub>c</sub></i>", "mean", "error"],
                              [[sliding(SIGNS[name]), *row] for name, columns in found.items()
                               for row in zip(*map(list, columns))]))
    return [out]
