"""Rotation and openings of contacts against the drive, harmonic and random."""
import numpy as np
from matplotlib.ticker import NullFormatter

from ratchet.page import Figure, Numbers, Section
from ratchet.style import COLOURS, GREY, LIGHT, figure, legend_above, legend_below
from ratchet.verdict import MOTIONS, SURE, beside, decide, missing, number

from . import disks, each
from .disks import MANY, OPEN
from .statistics import crossing, jackknife, mean_error, share, trend, weighted_power

FEW = 0.01           # openings per contact and period; how sharp the onset is: from here to MANY
SHARP = 5.0
FRACTIONS = ("significant", "spearman", "sliding")  # columns that are drawn from 0 to 1
SOLID = 0.25         # rms displacement about the mean place over the mean diameter, below which it is a solid


def by_drive(runs):
    """{drive: runs}, in order."""
    found = {}
    for run in runs:
        if run.has_means and isinstance(run.parameters.get("drive"), float):
            found.setdefault(run.parameters["drive"], []).append(run)
    return dict(sorted(found.items()))


def row(drive, found):
    """Means over packings with errors, as a dictionary of (value, error), of the disks that are no rattlers."""
    ranks, scaled = each.consistency(found)
    return {"drive": drive, "runs": len(found), "rms": mean_error([box.rms for box in found]),
            "median": mean_error([box.median for box in found]),
            "significant": share([(int(box.turns[box.held].sum()), int(box.held.sum())) for box in found]),
            "pearson": scaled, "spearman": ranks, "openings": mean_error([box.openings for box in found]),
            "sliding": mean_error([box.whole["sliding"] for box in found]),
            "contacts": mean_error([box.whole["coordination"] for box in found]),
            "wander": mean_error([box.spread("rms") for box in found]),
            "drift": mean_error([box.spread("displacement") for box in found]),
            "loose": mean_error([box.spread("rms", True) for box in found]),
            "rattlers": mean_error([float(np.sum(~box.held)) for box in found]),
            "farthest": max(box.whole["farthest"] for box in found),
            "noise": mean_error([box.noise for box in found])}


def lasts(correlation):
    """Correlation of halves above 0.5 and significant; False when it is below by its errors, None when it cannot be
    told."""
    value, error = correlation
    if value > 0.5:
        return True if value > SURE * error else None
    return None if value + SURE * np.nan_to_num(error) > 0.5 else False


def columns(rows, name):
    return np.array([r[name][0] for r in rows]), np.array([r[name][1] for r in rows])


def sections(campaign):
    return [against_drive(campaign)]


def curves_of(table, value):
    """{drive: value(box)} of each packing, known by its number; where that is a number above zero."""
    curves = {}
    for drive, found in table.items():
        for box in found:
            if value(box) > 0:
                curves.setdefault(box.replica, {})[drive] = value(box)
    return list(curves.values())


def onset(groups, level):
    """Drive at which openings reach a level, for jackknife over packings: groups are packings' {drive: openings}."""
    drives = sorted(set.intersection(*(set(g) for g in groups))) if groups else []
    return crossing(drives, [np.mean([g[d] for g in groups]) for d in drives], level)


def against_drive(campaign):
    sweeps = {motion: table for motion, table in disks.of_motions(campaign).items() if len(table) >= 3}
    found = [box for table in sweeps.values() for boxes in table.values() for box in boxes]
    out = Section("drive", "Rotation against drive",
                  f"<code>inputs/packing/shake_drive.cfg</code> and, with the same rms displacements, "
                  f"<code>shake_random.cfg</code>: {max(map(len, sweeps.values()), default=0)} drives with "
                  f"{len({box.replica for box in found})} packings each, {found[0].whole['measured'] if found else 0:.0f} s "
                  "measured. An opening is a contact that ends; it is counted per contact and period of the floor (1/80 s). "
                  f"{disks.RULE} They are left out but for openings and contacts. Error bars: scatter of packings, or leaving "
                  "out one at a time. Exponents are fits to the means of logarithms over packings, each with the weight of "
                  "its error.", missing=campaign.missing(*disks.SWEEPS))
    if MOTIONS[0] not in sweeps:
        out.claims.append(missing("Typical |&Omega;| grows with the drive in both regimes.", slug="drive-rms"))
        return out
    made = {motion: judged(table) for motion, table in sweeps.items()}
    out.claims += beside(*(claims for _, claims, _ in made.values()))
    rows = {motion: rows for motion, (rows, _, _) in made.items()}
    out.figures.append(drive_figure(rows, {motion: start for motion, (_, _, start) in made.items()}))
    out.tables.append(numbers_table(rows))
    return out


def judged(table):
    """(rows, claims, drive at which contacts begin to open) of one motion."""
    rows = [row(drive, found) for drive, found in table.items()]
    drives = np.array([r["drive"] for r in rows])
    regimes, start = separates(table, rows, drives)
    return rows, [regimes, *growth(table, drives, start), solid(rows), *lasting(rows)], start


def numbers_table(sets):
    names = ("rattlers", "rms", "median", "noise", "significant", "pearson", "spearman", "openings", "sliding",
             "contacts", "wander", "drift", "loose")
    return Numbers("Means over packings at each drive (angular velocities in rad/s; no rattlers but in the last "
                   "column)",
                   ["motion", "drive/<i>g</i>", "packings", "rattlers", "rms &Omega;", "median |&Omega;|", "median error bar",
                    "beyond 3 errors", "Pearson (scaled)", "Spearman", "openings", "sliding", "contacts per disk",
                    "wander/d", "drift/d", "wander/d of rattlers"],
                   [[motion, float(r["drive"]), r["runs"], *(number(*r[name]) for name in names)]
                    for motion, rows in sets.items() for r in rows])


def separates(table, rows, drives):
    openings = columns(rows, "openings")[0]
    curves = [curve for curve in curves_of(table, lambda box: max(box.openings, 1e-12)) if len(curve) == len(table)]
    (start, error), low, high = (jackknife(lambda part, level=level: onset(part, level), curves) if curves
                                 else (crossing(drives, openings, level), np.nan) for level in (OPEN, FEW, MANY))
    text = (f"{OPEN:g} openings per contact and period are reached at {number(start, error)} <i>g</i>; {FEW:g} at "
            f"{number(*low)} <i>g</i> and {MANY:g} at {number(*high)} <i>g</i>. At {drives[0]:g} <i>g</i> there are "
            f"{number(*rows[0]['openings'])}, at {drives[-1]:g} <i>g</i> {number(*rows[-1]['openings'])}")
    if not np.isfinite(low[0]):  # the weakest drive has more: a bound is all there is
        sharp = None
        text += f"; nowhere there are fewer than {FEW:g}, so it cannot be said how sharp the change is"
    else:
        ratio = high[0] / low[0]
        spread = SURE * ratio * np.hypot(*(e / v for v, e in (low, high)))
        sharp = True if ratio + spread < SHARP else False if ratio - spread > SHARP else None
        text += f": a factor of {number(ratio, spread / SURE)}"
    return decide("The opening of contacts separates two regimes: from few to many openings it takes less "
                  f"than a factor of {SHARP:g} in the drive.", sharp, text, slug="drive-regimes"), start


def seen(box):
    """The median of |Omega| where it is above the error bar of 95 %, else 0: then more than half may stand still."""
    return box.median if box.median > disks.LIMIT * box.noise else 0.0


def growth(table, drives, start):
    """Claims on the exponents below and above the onset of openings, of the rms and of the median."""
    made = []
    low = drives <= (start if np.isfinite(start) else 0)
    for name, what, value in (("rms", "The rms", lambda box: box.rms), ("median", "The median", seen)):
        curves = curves_of(table, value)
        told, grows = [], []
        for word, part in (("below", low), ("above", ~low)):
            some = [d for d in drives[part] if sum(d in curve for curve in curves) * 2 > len(table[d])]
            fit = weighted_power([{d: c[d] for d in some if d in c} for c in curves], some)
            spread = np.nanmax([fit.error, fit.weights]) if np.isfinite([fit.error, fit.weights]).any() else np.nan
            told.append(f"{word} the onset |&Omega;| ~ drive<sup><i>a</i></sup>, <i>a</i> = {fit}" if fit.points > 1
                        else f"{word} the onset {fit.points} drives, no fit")
            grows.append(None if not np.isfinite(spread) else True if fit.exponent > SURE * spread
                         else False if fit.exponent < -SURE * spread else None)
            lost = [f"{d:g}" for d in drives[part] if d not in some]
            if lost:
                told[-1] += (f"; at {', '.join(lost)} <i>g</i> it is within its error bar of zero in half of the "
                             f"packings or "
                             "more, and left out")
        made.append(decide(f"{what} of |&Omega;| grows with the drive in both regimes.", _all(grows),
                           "; ".join(told) + f". Rank correlation with the drive {number(*trend(curves))}",
                           slug=f"drive-{name}"))
    return made


def solid(rows):
    value, error = columns(rows, "wander")
    loose = [r["drive"] for r in rows if r["wander"][0] > SOLID]
    far = [r["drive"] for r in rows if r["farthest"] > 1]
    return decide(f"It remains a solid: disks wander by less than {SOLID:g} mean diameters "
                             f"(rms).", not loose,
                             f"rms displacement about the mean place {number(value[0], error[0])} d at "
                             f"{rows[0]['drive']:g} "
                             f"<i>g</i>, {number(value[-1], error[-1])} d at {rows[-1]['drive']:g} <i>g</i>"
                             + (f"; above {SOLID:g} at {', '.join(f'{d:g}' for d in loose)} <i>g</i>" if loose else "")
                             + (f"; single disks, rattlers among them, wander by more than a diameter (rms) at "
                                f"{', '.join(f'{d:g}' for d in far)} <i>g</i>"
                                if far else "; no single disk, not even a rattler, wanders by a diameter"),
                             slug="drive-solid")


def _all(verdicts):
    """True, False or None of several such."""
    verdicts = list(verdicts)
    return False if False in verdicts else None if None in verdicts else True


def lasting(rows):
    made = []
    at = "; ".join(f"{r['drive']:g} <i>g</i>: {{}}" for r in rows)
    for name, what, how in (("pearson", "linear correlation, each packing scaled by its rms", "Rotation lasts at "
                                                                                              "every drive"),
                            ("spearman", "rank correlation, means over packings",
                             "It lasts at every drive in ranks, too, where slow disks count as much as fast ones")):
        made.append(decide(f"{how}: the correlation of halves is above 0.5.", _all(lasts(r[name]) for r in rows),
                                 f"{what}; " + at.format(*(number(*r[name]) for r in rows)),
                                 slug="drive-lasts" if name == "pearson" else "drive-ranks"))
    return made


def bars(value, error):
    """Error bars for a logarithmic axis: they end before they reach zero."""
    error = np.nan_to_num(error)
    return np.array([np.minimum(error, 0.7 * value), error])


def drive_figure(sets, starts):
    picture, axes = figure(columns=2, rows=2, width=7.4, height=6.4, sharex=True, legend=True)
    panels = ((axes[0, 0], (("rms", "rms"), ("median", "median")), r"$|\Omega|$ (rad/s)"),
              (axes[0, 1], (("openings", "openings"),), "openings per contact\nand period"),
              (axes[1, 0], (("significant", "beyond 3 errors"), ("spearman", "rank correlation of halves"),
                            ("sliding", "sliding contacts")), "fraction"),
              (axes[1, 1], (("wander", "disks"), ("loose", "rattlers")), "rms displacement / diameter"))
    for motion, rows in sets.items():
        drives = np.array([r["drive"] for r in rows])
        random = motion != MOTIONS[0]
        for panel, curves, label in panels:
            for k, (name, text) in enumerate(curves):
                value, error = columns(rows, name)
                shown = np.isfinite(value) if name in FRACTIONS else value > 0
                size = np.nan_to_num(error) if name in FRACTIONS else bars(value, error)
                panel.errorbar(drives[shown], value[shown], yerr=size[..., shown], fmt="os^"[k] + ("--" if random else "-"),
                               color=COLOURS[k], lw=0.7, ms=4, mfc=COLOURS[k] if random else "white",
                               label=None if random or len(curves) == 1 else text)
            panel.set_ylabel(label)
        if np.isfinite(starts[motion]):
            for panel in axes.flat:
                panel.axvline(starts[motion], color=GREY, lw=0.8, ls="--" if random else ":", gid="guide")
    axes[0, 1].axhline(OPEN, color=LIGHT, lw=0.8, gid="guide")
    axes[1, 1].axhline(SOLID, color=LIGHT, lw=0.8, gid="guide")
    axes[1, 0].set_ylim(-0.3, 1.1)
    for panel in (axes[0, 0], axes[1, 0], axes[1, 1]):
        legend_above(panel, 2, fontsize=8)
    for panel in (axes[0, 0], axes[0, 1], axes[1, 1]):
        panel.set_yscale("log")
    every = [r["drive"] for rows in sets.values() for r in rows]
    for panel in axes.flat:
        panel.set_xscale("log")
        shown = [d for d in (0.1, 0.3, 1, 3, 9) if min(every) <= d <= max(every)]
        panel.set_xticks(shown, [f"{d:g}" for d in shown])
        panel.xaxis.set_minor_formatter(NullFormatter())
    for panel in axes[1]:
        panel.set_xlabel("drive: peak acceleration of the\nharmonic motion / $g$")
    axes[0, 1].plot([], [], "o-", color=GREY, mfc="white", lw=0.7, label="harmonic drive")
    axes[0, 1].plot([], [], "o--", color=GREY, lw=0.7, label="random drive, the same rms displacement")
    legend_below(picture, axes[0, 1], 2)
    return Figure("drive", picture, f"Against the drive; disks that are no rattlers unless said otherwise. Vertical lines: "
                  f"where {OPEN:g} openings per contact and period are reached, dotted under harmonic drive, dashed under "
                  "random drive. Displacements are those about the mean place; the level: a quarter of a diameter.",
                  "Typical angular velocity, openings of contacts, persistence and displacements against drive")
