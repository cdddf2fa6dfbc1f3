"""Rotation and openings of contacts against the drive, harmonic and random."""
import numpy as np
from matplotlib.ticker import NullFormatter

from report.page import Figure, Numbers, Section
from report.style import COLOURS, GREY, LIGHT, figure
from report.verdict import SURE, decide, missing, number

from .statistics import crossing, jackknife, mean_error, pearson, pooled, power_law, spearman

FREQUENCY = 80.0
OPEN = 0.1           # openings per contact and period that separate the regimes
FEW, MANY = 0.01, 1.0  # how sharp it is: the drives at which this many are reached
SHARP = 5.0
SOLID = 0.25         # rms displacement about the mean place over the mean diameter, below which it is a solid


def by_drive(runs):
    """{drive: runs}, in order."""
    found = {}
    for run in runs:
        if run.has_means and isinstance(run.parameters.get("drive"), float):
            found.setdefault(run.parameters["drive"], []).append(run)
    return dict(sorted(found.items()))


def row(drive, runs):
    """Means over packings with errors, as a dictionary of (value, error)."""
    halves = [run.halves() for run in runs]
    return {"drive": drive, "runs": len(runs), "rms": mean_error([run.rms for run in runs]),
            "median": mean_error([run.median for run in runs]),
            "significant": mean_error([run.significant for run in runs]),
            "pearson": jackknife(pooled(pearson), halves), "spearman": jackknife(pooled(spearman), halves),
            "openings": mean_error([run.openings_per_period(FREQUENCY) for run in runs]),
            "sliding": mean_error([run.sliding_fraction for run in runs]),
            "contacts": mean_error([run.coordination for run in runs]),
            "wander": mean_error([run.wander for run in runs]), "drift": mean_error([run.drift for run in runs]),
            "farthest": max(run.farthest for run in runs), "noise": mean_error([run.noise for run in runs])}


def lasts(correlation):
    """Correlation of halves above 0.5 and significant; None when it is above but cannot be told from 0."""
    value, error = correlation
    if not value > 0.5:
        return False
    return True if value > SURE * error else None


def columns(rows, name):
    return np.array([r[name][0] for r in rows]), np.array([r[name][1] for r in rows])


def sections(campaign):
    return [against_drive(campaign), random_floor(campaign)]


def onset(groups):
    """Drive at which openings set in, for jackknife over packings: groups are seeds' {drive: openings}."""
    drives = sorted(set.intersection(*(set(g) for g in groups))) if groups else []
    return crossing(drives, [np.mean([g[d] for g in groups]) for d in drives], OPEN)


def against_drive(campaign):
    table = by_drive(campaign.runs("drive"))
    rows = [row(drive, runs) for drive, runs in table.items()]
    every = [run for runs in table.values() for run in runs]
    out = Section("drive", "Rotation against drive",
                  f"<code>inputs/packing/shake_drive.cfg</code>: {len(table)} peak accelerations with up to "
                  f"{max((r['runs'] for r in rows), default=0)} packings each, "
                  f"{every[0].measured if every else 0:.0f} s measured. An opening is a contact that ends; it is "
                  f"counted per "
                  "contact and period of the floor (1/80 s). Error bars: scatter of packings.",
                  missing=campaign.missing("drive"))
    if len(rows) < 3:
        out.claims.append(missing("Typical |&Omega;| grows with the drive in both regimes."))
        return out
    drives = np.array([r["drive"] for r in rows])
    start, spread = separates(out, table, rows, drives)
    out.figures.append(drive_figure(rows, drives, start))
    growth(out, rows, drives, start)
    solid(out, rows)
    lasting(out, rows)
    names = ("rms", "median", "noise", "significant", "pearson", "spearman", "openings", "sliding", "contacts",
             "wander", "drift")
    out.tables.append(Numbers("Means over packings at each drive (angular velocities in rad/s)",
                              ["drive/<i>g</i>", "packings", "rms &Omega;", "median |&Omega;|", "rms error bar",
                               "beyond 3 errors", "Pearson", "Spearman", "openings", "sliding", "contacts per disk",
                               "wander/d", "drift/d"],
                              [[float(r["drive"]), r["runs"], *(number(*r[name]) for name in names)] for r in rows]))
    return out


def separates(out, table, rows, drives):
    openings = columns(rows, "openings")[0]
    # Runs at one drive are ordered by replica: each replica in turn is left out of the curve.
    replicas = sorted({run.parameters.get("r", 0.0) for runs in table.values() for run in runs})
    curves = [{drive: run.openings_per_period(FREQUENCY) for drive, runs in table.items() for run in runs
               if run.parameters.get("r", 0.0) == k} for k in replicas]
    curves = [curve for curve in curves if len(curve) == len(table)]
    start, error = jackknife(onset, curves) if curves else (crossing(drives, openings, OPEN), np.nan)
    low, high = crossing(drives, openings, FEW), crossing(drives, openings, MANY)
    weakest, strongest = openings[0], openings[-1]
    text = (f"{OPEN:g} openings per contact and period are reached at {number(start, error)} <i>g</i>; {FEW:g} at "
            f"{number(low)} <i>g</i> and {MANY:g} at {number(high)} <i>g</i>. At {drives[0]:g} <i>g</i> there are "
            f"{number(weakest)}, at {drives[-1]:g} <i>g</i> {number(strongest)}")
    if not np.isfinite(low):
        text += f"; nowhere there are fewer than {FEW:g}, so it cannot be said how sharp the change is"
    sharp = None if not (np.isfinite(low) and np.isfinite(high)) else bool(high < SHARP * low)
    out.claims.append(decide("The opening of contacts separates two regimes: from few to many openings it takes less "
                             f"than a factor of {SHARP:g} in the drive.", sharp, text))
    return start, error


def growth(out, rows, drives, start):
    low = drives <= (start if np.isfinite(start) else 0)
    for name, what in (("rms", "The rms"), ("median", "The median")):
        value, error = columns(rows, name)
        told, steps = [], []
        for word, part in (("below", low), ("above", ~low)):
            if part.sum() >= 2:
                exponent, spread, _ = power_law(drives[part], value[part])
                told.append(f"{word} the onset |&Omega;| ~ drive<sup>{number(exponent, spread)}</sup> ({part.sum()} "
                            f"drives)")
            steps += list(np.diff(value[part]) / np.hypot(error[part][1:], error[part][:-1]))
        up, down = int(np.sum(np.array(steps) > 0)), int(np.sum(np.array(steps) < -SURE))
        ends = [value[part][-1] > value[part][0] + SURE * np.hypot(error[part][-1], error[part][0])
                for part in (low, ~low) if part.sum() >= 2]
        out.claims.append(decide(f"{what} of |&Omega;| grows with the drive in both regimes.",
                                 False if down else True if len(ends) == 2 and all(ends) else None,
                                 "; ".join(told) + f"; {up} of {len(steps)} steps are up, {down} significantly down; "
                                                   f"from "
                                 f"{number(value[0], error[0])} to {number(value[-1], error[-1])} rad/s"))


def solid(out, rows):
    value = columns(rows, "wander")[0]
    loose = [r["drive"] for r in rows if r["wander"][0] > SOLID]
    far = [r["drive"] for r in rows if r["farthest"] > 1]
    out.claims.append(decide(f"It remains a solid: disks wander by less than {SOLID:g} mean diameters "
                             f"(rms).", not loose,
                             f"rms displacement about the mean place {number(value[0])} d at {rows[0]['drive']:g} "
                             f"<i>g</i>, "
                             f"{number(value[-1])} d at {rows[-1]['drive']:g} <i>g</i>"
                             + (f"; above {SOLID:g} at {', '.join(f'{d:g}' for d in loose)} <i>g</i>" if loose else "")
                             + (f"; single disks wander by more than a diameter (rms) at "
                                f"{', '.join(f'{d:g}' for d in far)} <i>g</i>"
                                if far else "; no single disk wanders by a diameter")))


def _all(verdicts):
    """True, False or None of several such."""
    verdicts = list(verdicts)
    return False if False in verdicts else None if None in verdicts else True


def lasting(out, rows):
    value = columns(rows, "pearson")[0]
    share = columns(rows, "significant")[0]
    marks = [" (not significant)" if lasts(r["pearson"]) is None else "" for r in rows]
    out.claims.append(decide("Rotation lasts at every drive (correlation of halves above "
                             "0.5).", _all(lasts(r["pearson"]) for r in rows),
                             "correlation " + ", ".join(f"{v:.3f}{mark}" for v, mark in zip(value, marks)) + " and significant disks "
                             + ", ".join(f"{100 * v:.0f} %" for v in share) + " at "
                             + ", ".join(f"{r['drive']:g}" for r in rows) + " <i>g</i>"))


def bars(value, error):
    """Error bars for a logarithmic axis: they end before they reach zero."""
    error = np.nan_to_num(error)
    return np.array([np.minimum(error, 0.7 * value), error])


def drive_figure(rows, drives, start):
    picture, axes = figure(columns=2, rows=2, width=7.2, height=5.8, sharex=True)
    look = {"lw": 0.7, "mfc": "white"}
    for k, (name, label, sign) in enumerate((("rms", "rms", "o"), ("median", "median", "s"), ("noise", "rms error "
        "bar", "x"))):
        value, error = columns(rows, name)
        axes[0, 0].errorbar(drives, value, yerr=bars(value, error), fmt=sign + "-", color=COLOURS[k], label=label,
                            **look)
    axes[0, 0].set_yscale("log")
    axes[0, 0].set_ylabel(r"$|\Omega|$ (rad/s)")
    axes[0, 0].legend(loc="lower right")
    value, error = columns(rows, "openings")
    shown = value > 0
    axes[0, 1].errorbar(drives[shown], value[shown], yerr=bars(value, error)[:, shown], fmt="o-", lw=0.7,
                        mfc="white", color=COLOURS[3])
    axes[0, 1].axhline(OPEN, color=LIGHT, lw=0.8, gid="guide")
    axes[0, 1].set_yscale("log")
    axes[0, 1].set_ylabel("openings per contact and period")
    for k, (name, label, sign) in enumerate((("pearson", "correlation of halves", "o"),
                                             ("significant", "beyond 3 errors", "s"), ("sliding", "sliding "
                                                 "contacts", "^"))):
        value, error = columns(rows, name)
        axes[1, 0].errorbar(drives, value, yerr=error, fmt=sign + "-", color=COLOURS[k], label=label,
                            **look)
    axes[1, 0].set_ylim(0, 1.25)
    axes[1, 0].set_ylabel("fraction")
    axes[1, 0].legend(loc="upper left", ncol=2, fontsize=8.5, columnspacing=0.8)
    for k, (name, label, sign) in enumerate((("wander", "about the mean place", "o"), ("drift", "of the mean "
        "place", "s"))):
        value, error = columns(rows, name)
        axes[1, 1].errorbar(drives, value, yerr=bars(value, error), fmt=sign + "-", color=COLOURS[k], label=label,
                            **look)
    axes[1, 1].axhline(SOLID, color=LIGHT, lw=0.8, gid="guide")
    axes[1, 1].set_yscale("log")
    axes[1, 1].set_ylabel("rms displacement / diameter")
    axes[1, 1].legend(loc="upper left")
    for panel in axes.flat:
        panel.set_xscale("log")
        shown = [d for d in (0.1, 0.3, 1, 3, 9) if drives[0] <= d <= drives[-1]]
        panel.set_xticks(shown, [f"{d:g}" for d in shown])
        panel.xaxis.set_minor_formatter(NullFormatter())
        if np.isfinite(start):
            panel.axvline(start, color=GREY, lw=0.8, ls=":", gid="guide")
    for panel in axes[1]:
        panel.set_xlabel("peak acceleration of the floor / $g$")
    return Figure("drive", picture, f"Against the drive. Dotted: where {OPEN:g} openings per contact and period are "
                                    f"reached. "
                  "Displacement of the mean place: from where the disk was when measuring began.",
                  "Typical angular velocity, openings of contacts, persistence and displacements against drive")


def random_floor(campaign):
    table = by_drive(campaign.runs("random"))
    harmonic = by_drive(campaign.runs("drive"))
    rows = [row(drive, runs) for drive, runs in table.items()]
    out = Section("random", "Random vibration of the floor",
                  "<code>inputs/packing/shake_random.cfg</code>: the height of the floor is the randomly forced "
                  "oscillator of "
                  "physics.md, section 7, with &omega; = 2&pi; 80 Hz, <i>c</i> = 0.5; its rms displacement is that of "
                  "a harmonic "
                  "motion, <i>a</i>/&omega;&sup2;, with the acceleration <i>a</i> that is "
                  "given.", missing=campaign.missing("random"))
    if not rows:
        out.claims.append(missing("Disks rotate under random vibration, too."))
        return out
    for r in rows:
        linear = r["pearson"]
        out.claims.append(decide(f"At {r['drive']:g} <i>g</i> the rotation persists.", lasts(linear),
                                 f"{r['runs']} packings: Pearson {number(*linear)}, Spearman {number(*r['spearman'])}, "
                                 f"{number(100 * r['significant'][0], 100 * r['significant'][1])} % beyond 3 errors; "
                                 f"rms &Omega; "
                                 f"{number(*r['rms'])}, median {number(*r['median'])} rad/s; "
                                 f"{number(*r['openings'])} openings per contact and period"
                                 + (f"; harmonic: rms "
                                    f"{number(*mean_error([run.rms for run in harmonic[r['drive']]]))} rad/s"
                                    if r["drive"] in harmonic else "")))
    picture, axes = figure(columns=len(rows), height=3.6)
    for panel, r in zip(np.atleast_1d(axes), rows):
        groups = [run.halves() for run in table[r["drive"]]]
        for k, (a, b) in enumerate(groups):
            panel.plot(a, b, "o", ms=3, mew=0.6, mfc="none", color=COLOURS[k % len(COLOURS)])
        top = 1.08 * max(np.abs(np.concatenate([np.concatenate(g) for g in groups])).max(), 1e-12)
        panel.plot([-top, top], [-top, top], color=GREY, lw=0.8, gid="guide")
        panel.set_xlim(-top, top)
        panel.set_ylim(-top, top)
        panel.set_aspect("equal")
        panel.set_xlabel(r"$\Omega_i$, first half (rad/s)")
        panel.set_title(f"{r['drive']:g} $g$")
    np.atleast_1d(axes)[0].set_ylabel(r"$\Omega_i$, second half (rad/s)")
    out.figures.append(Figure("random", picture, "Mean angular velocities in two halves of the runs under random "
                                                 "vibration.",
                              "Scatter plots of mean angular velocities in two halves, random vibration"))
    return out
