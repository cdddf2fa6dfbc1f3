"""Comparison with another program: the same box, shaken at four accelerations."""
import math

import numpy as np
from matplotlib.ticker import NullFormatter

from ratchet.page import Figure, Numbers, Section
from ratchet.style import BLACK, COLOURS, GREY, figure
from ratchet.verdict import Claim, NO, OPEN, YES, missing, number

from .compare import newcomer, percent, student, student_limit
from .statistics import mean_error

# rms angular velocity (rad/s), mean of two packings, of an independent program with the parameters of outside.cfg
THEIRS = {0.3: 0.016, 0.7: 0.102, 2.0: 0.46, 5.0: 0.75}
PACKINGS = 2
LIKELY, UNLIKELY = 0.05, 0.01  # chances above and below which the programs agree and disagree
COARSE = 4.0   # a test that lets pass this factor and more tells nothing
CLOSE = 2.0    # likewise of all drives together
TEXT = "The typical angular velocity of another program lies in the scatter of packings of this one"


def sections(campaign):
    out = Section("outside", "Check from outside: another program",
                  "<code>inputs/packing/outside.cfg</code>: 60 disks, <i>k<sub>n</sub></i> = 10<sup>4</sup> N/m, "
                  "<i>k<sub>t</sub></i>/<i>k<sub>n</sub></i> = 0.773, &mu; = 0.1, &gamma;<sub>n</sub> = 0.1, floor at "
                  "80 Hz, 10 s at rest, 30 s to thermalise, 200 s measured. An independent program has had the mean "
                  f"rms &Omega; of the table, of {PACKINGS} packings of its own at each drive. Compared by Student's "
                  "test of ln(rms): the spread of packings is taken for the same in both programs.",
                  missing=campaign.missing("outside"))
    table = campaign.numbers("outside", lambda: rows(campaign.runs("outside")),
                             "each packing of the box that another program has shaken, too (rad/s)")
    found = {drive: table.column("rms")[table.column("drive") == drive] for drive in THEIRS}
    found = {drive: rms for drive, rms in found.items() if len(rms)}
    if not found:
        out.claims.append(missing(TEXT + ".", slug="outside-program"))
        return [out]
    out.claims.append(together(found))
    out.claims += [one(drive, rms) for drive, rms in found.items()]
    out.figures.append(picture_of(found))
    out.tables.append(Numbers("Two programs, rms &Omega; (rad/s)",
                              ["drive/<i>g</i>", "packings", "this program", "error", "standard deviation",
                               "other program", "ratio"],
                              [[drive, len(rms), *mean_error(rms), float(np.std(rms, ddof=1)) if len(rms) > 1 else "",
                                THEIRS[drive], THEIRS[drive] / float(np.mean(rms))]
                               for drive, rms in found.items()], shown=True))
    return [out]


def rows(runs):
    runs = [run for run in runs if run.has_means]
    if not runs:
        return None
    return {"drive": [run.parameters["drive"] for run in runs], "seed": [run.seed for run in runs],
            "rms": [run.rms for run in runs], "median": [run.median for run in runs],
            "significant": [run.significant for run in runs],
            "openings": [run.openings_per_period(80) for run in runs]}


def verdict_of(chance, factor, limit):
    """factor: largest deviation that would still have passed."""
    if not math.isfinite(chance):
        return OPEN
    return NO if chance < UNLIKELY else YES if chance > LIKELY and factor < limit else OPEN


def one(drive, rms):
    t, degrees, chance, reach = newcomer(np.log(rms), math.log(THEIRS[drive]), PACKINGS)
    numbers = f"{number(THEIRS[drive])} rad/s against {number(*mean_error(rms))} rad/s of {len(rms)} packings"
    if degrees >= 1:
        factor = math.exp(reach)
        numbers += (f": <i>t</i> = {number(t)} with {degrees} degrees of freedom, a chance of {percent(chance)}; "
                    f"a factor above {factor:.2g} would be noticed")
    verdict = verdict_of(chance, math.exp(reach), COARSE) if degrees >= 1 else OPEN
    return Claim(f"{TEXT}, at {drive:g} <i>g</i>.", verdict, numbers, slug=f"outside-program-{drive:g}g")


def together(found):
    """The mean of ln(theirs/ours) over drives; one spread of packings for all, since it hardly depends on the drive."""
    groups = {drive: np.log(rms) for drive, rms in found.items()}
    degrees = sum(len(g) - 1 for g in groups.values())
    if degrees < 2:
        return missing(f"{TEXT}, all drives together.", why="fewer than two packings", slug="outside-program")
    variance = sum(float(np.sum((g - g.mean()) ** 2)) for g in groups.values()) / degrees
    away = np.array([math.log(THEIRS[drive]) - g.mean() for drive, g in groups.items()])
    errors = np.sqrt(variance * np.array([1 / len(g) + 1 / PACKINGS for g in groups.values()]))
    weight = errors ** -2
    mean, error = float(np.sum(weight * away) / weight.sum()), float(weight.sum() ** -0.5)
    chance, factor = student(mean / error, degrees), math.exp(error * student_limit(LIKELY, degrees))
    ratio = math.exp(mean)
    return Claim(f"{TEXT}, all drives together.", verdict_of(chance, factor, CLOSE),
                 f"other program over this one: {number(ratio, ratio * error)} ({len(groups)} drives, {degrees} "
                 f"degrees of freedom, a chance of {percent(chance)}); packings scatter "
                 f"by {100 * math.sqrt(variance):.0f} %, "
                 f"a factor above {factor:.2g} would be noticed", slug="outside-program")


def picture_of(found):
    picture, axes = figure(height=3.7)
    for k, (drive, rms) in enumerate(found.items()):
        axes.plot(drive * np.geomspace(0.95, 1 / 0.95, len(rms)), rms, "o", ms=3.5, mew=0.7, mfc="none", color=GREY,
                  label="this program, packings" if k == 0 else None)
    drives = np.array(list(found))
    mean, error = np.array([mean_error(rms) for rms in found.values()]).T
    axes.errorbar(drives * 0.86, mean, yerr=np.nan_to_num(error), fmt="s", color=COLOURS[0], mfc="white", capsize=3,
                  label="mean and its error")
    # Two packings scatter like ours: their mean by 1/sqrt(2) of the standard deviation.
    spread = np.array([np.std(np.log(rms), ddof=1) if len(rms) > 1 else 0 for rms in found.values()]) / PACKINGS ** 0.5
    theirs = np.array([THEIRS[drive] for drive in found])
    axes.errorbar(drives / 0.86, theirs, yerr=[theirs * (1 - np.exp(-spread)), theirs * (np.exp(spread) - 1)], fmt="D",
                  color=COLOURS[1], capsize=3, label=f"other program, mean of {PACKINGS}")
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.set_xticks(drives, [f"{d:g}" for d in drives])
    axes.tick_params(axis="x", which="minor", bottom=False, top=False)
    axes.xaxis.set_minor_formatter(NullFormatter())
    axes.set_ylim(bottom=0.01)
    axes.set_xlim(drives.min() * 0.7, drives.max() * 1.45)
    axes.set_xlabel("peak acceleration of the floor / $g$")
    axes.set_ylabel(r"rms $\Omega$ (rad/s)")
    axes.grid(axis="y", color=BLACK, alpha=0.12, lw=0.6)
    axes.legend(loc="upper left")
    return Figure("outside", picture, "The same box in two programs: rms of the mean angular velocities of 60 disks. "
                                      "Bars of the other program: what "
                                      "the scatter of our packings makes of the mean of two.",
                  "Typical angular velocity against drive in two programs")
