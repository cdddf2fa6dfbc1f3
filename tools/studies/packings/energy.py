"""What rotation costs, disk by disk and packing by packing, and how far disks wander."""
import numpy as np

from ratchet.page import Figure, Numbers, Section
from ratchet.style import COLOURS, GREY, figure, legend_below
from ratchet.verdict import MOTIONS, SURE, beside, decide, missing, number

from . import disks
from .drive import bars, curves_of
from .statistics import mean_error, spearman, weighted_power

SETS = (("low", 0.3), ("moderate", 2.0))
SLOW = 0.5  # rms displacement ~ time^a: a disk that diffuses has a = 1/2, one in a cage 0


def sections(campaign):
    return [powers(campaign), displacements(campaign)]


def within(found, name, chosen=lambda box: box.held):
    """Rank correlation of |Omega| and a power within each packing: mean over packings, with its error."""
    values = []
    for box in found:
        part = chosen(box)
        if part.sum() >= 5:
            values.append(spearman(np.abs(box["omega"][part]), box[name][part]))
    return mean_error(values)


def floor_disks(box):
    """Disks that the floor does work on."""
    return box.held & (box["injected"] != 0)


def powers(campaign):
    sweeps = disks.of_motions(campaign)
    sets = sets_of(campaign, sweeps)
    out = Section("powers", "What rotation costs",
                  "The floor works on the disks that touch it; of every disk it is known what it takes from the floor, "
                  "and what its contacts lose by friction and in dashpots (a contact of two disks gives half to each). "
                  f"Powers are means over the measured time. {disks.RULE} They are left out.",
                  missing=campaign.missing("low", "moderate", *disks.SWEEPS))
    out.claims += beside(*([*(friction(name, found) for name, found in sets[motion].items() if found),
                            *([total(table)] if len(table) >= 3 else [])] for motion, table in sweeps.items()))
    if not out.claims:
        out.claims.append(missing("Disks that turn faster lose more by friction.", slug="friction-rotation"))
        return out
    out.tables.append(power_table(sweeps))
    out.figures.append(power_figure(sets, sweeps))
    return out


def sets_of(campaign, sweeps):
    """{motion: {name: boxes}} at the drives of SETS: long runs under harmonic drive, those of the sweep under random
    drive."""
    return {MOTIONS[0]: {name: disks.boxes(campaign, name, drive) for name, drive in SETS},
            MOTIONS[1]: {name: sweeps[MOTIONS[1]].get(drive, []) for name, drive in SETS}}


def friction(name, found):
    value, error = within(found, "friction")
    turning = within(found, "friction", lambda box: box.held & box.turns)
    floor = within(found, "injected", floor_disks)
    verdict = None if not error >= 0 else True if value > SURE * error else False if value < SURE * error else None
    return decide(f"At {found[0].drive:g} <i>g</i> disks that turn faster lose more by friction.", verdict,
                  f"rank correlation of |&Omega;| and friction within a packing {number(value, error)}, of those that "
                  f"turn {number(*turning)}; of |&Omega;| and the injected power, of disks that the floor works on, "
                  f"{number(*floor)}", slug=f"{name}-friction-rotation")


def injected(box):
    """Power that the floor gives to the whole packing, over its number of disks."""
    return float(np.sum(box["injected"])) / len(box["omega"])


def total(table):
    """Injected power of a packing against its rms rotation, across the drives."""
    pairs = {}
    for found in table.values():
        for box in found:
            pairs.setdefault(box.replica, []).append((box.rms, injected(box)))
    ranks = mean_error([spearman(*np.transpose(p)) for p in pairs.values() if len(p) >= 3])
    rms, power = (weighted_power(curves_of(table, value), list(table)) for value in (lambda box: box.rms, injected))
    exponent = power.exponent / rms.exponent if rms.exponent else np.nan
    error = abs(exponent) * np.hypot(power.error / power.exponent, rms.error / rms.exponent)
    verdict = None if not ranks[1] >= 0 else bool(ranks[0] > SURE * ranks[1] and ranks[0] > 0.9)
    return decide("Across drives the packing turns faster the more power is put in: a rank correlation above "
                  "0.9.", verdict,
                  f"rank correlation of rms &Omega; and injected power {number(*ranks)}; over all drives the injected "
                  f"power goes as drive<sup><i>a</i></sup>, <i>a</i> = {power}, the rms with <i>a</i> = {rms}, so that "
                  f"power ~ rms<sup><i>b</i></sup> with <i>b</i> near {number(exponent, error)}",
                  slug="power-rotation")


def power_table(sweeps):
    rows = []
    for motion, table in sweeps.items():
        for drive, found in table.items():
            parts = [mean_error([float(np.sum(box[name])) / len(box["omega"]) for box in found])
                     for name in ("injected", "friction", "viscous")]
            rotation = within(found, "friction"), within(found, "injected", floor_disks)
            rows.append([motion, float(drive), len(found), *(number(*part) for part in (*parts, *rotation))])
    return Numbers("Powers per disk (W) at each drive, and rank correlations with |&Omega;| within packings",
                   ["motion", "drive/<i>g</i>", "packings", "injected", "lost by friction", "lost in dashpots",
                    "|&Omega;| and friction", "|&Omega;| and injected, at the floor"], rows)


def power_figure(sets, sweeps):
    picture, axes = figure(columns=2, rows=2, width=7.2, height=6.6, sharex="col", sharey="col")
    for (motion, some), table, row in zip(sets.items(), sweeps.values(), axes):
        for k, found in enumerate(some.values()):
            for box in found:
                part = box.held & (box["friction"] > 0) & (box["omega"] != 0)
                for chosen, fill in ((part & box.turns, COLOURS[k]), (part & ~box.turns, "none")):
                    row[0].plot(np.abs(box["omega"][chosen]), box["friction"][chosen], "os"[k], ms=2.6, mew=0.5, mfc=fill,
                                color=COLOURS[k])
            if found:
                row[0].plot([], [], "os"[k], ms=3, color=COLOURS[k], label=f"{found[0].drive:g} $g$")
        row[0].plot([], [], "o", ms=3, mfc="none", color=GREY, label="within 3 errors")
        for k, (drive, found) in enumerate(table.items()):
            row[1].plot([box.rms for box in found], [injected(box) for box in found], "os"[k // 8], ms=4, mfc="white",
                        color=COLOURS[k % len(COLOURS)], label=f"{drive:g} $g$")
        row[0].set_ylabel(f"{motion} drive: lost by friction (W)", fontsize=10)
        row[1].set_ylabel("injected power per disk (W)", fontsize=10)
    every = [box["friction"][box.held] for some in sets.values() for found in some.values() for box in found]
    axes[0, 0].set_ylim(bottom=max(np.median(np.concatenate(every or [np.ones(1)])), 1e-300) * 1e-4)
    axes[1, 0].set_xlabel(r"$|\Omega_i|$ (rad/s)")
    axes[1, 1].set_xlabel(r"rms $\Omega$ of the packing (rad/s)")
    for panel in axes.flat:
        panel.set_xscale("log")
        panel.set_yscale("log")
        if panel.get_legend_handles_labels()[0]:
            left = panel in axes[:, 0]
            panel.legend(loc="lower left" if left else "upper left", fontsize=8.5, ncol=1 if left else 2, columnspacing=0.6,
                         handletextpad=0.1)
    return Figure("powers", picture, "Left: power that a disk loses by friction against its mean angular velocity; "
                  "full: disks that turn; those that lose hardly anything are below the axis. Right: power that the "
                  "floor puts in against the rms angular velocity, a point a packing. Above: harmonic drive, below: random "
                  "drive.", "Scatter plots of friction power and injected power against angular velocity")


# --- displacements ----------------------------------------------------------------------------------------------------
def displacements(campaign):
    sets = {motion: curves(campaign, entries) for motion, entries in zip(
        MOTIONS, ((*SETS, (disks.SWEEPS[0], None)), ((disks.SWEEPS[1], None),)))}
    out = Section("wander", "Is it a solid? Displacements against time",
                  "Root mean square of how far a disk has moved after a time, over all starts within the measured time, at "
                  "moments three periods of 80 Hz or a multiple apart: the same phase of the harmonic motion. In a cage it comes to a "
                  f"level; a disk that diffuses goes with the root of time. {disks.RULE} They are drawn apart. Errors: scatter "
                  "of packings.")
    if not any(sets.values()):
        out.claims.append(missing("Disks stay in their cages: displacements come to a level.", slug="wander-level"))
        return out
    out.claims += beside(*([level(f"{drive:g} <i>g</i>", points) for drive, points in some.items()] for some in sets.values()))
    out.figures.append(wander_figure(sets))
    return out


def curves(campaign, entries):
    """{drive: points} at the drives of SETS, those of the first entry that has them, and at the strongest drive of the
    sweep."""
    found = {}
    for name, drive in entries:
        boxes = disks.boxes(campaign, name, np.nan if drive is None else drive)
        table = disks.wandering(campaign, name, boxes) if boxes else []
        drives = {box.drive for box in boxes} if len(table) else set()
        for at in sorted(drives & {max(drives, default=0), *(drive for _, drive in SETS)}):
            found.setdefault(at, curve(table, boxes, at))
    return found


def curve(table, found, drive):
    """{lag: (held, loose)} with lists over packings, of those at this drive."""
    numbers = {float(k) for k, box in enumerate(found) if box.drive == drive}
    points = {}
    for row in table.rows:
        if row["packing"] in numbers:
            pair = points.setdefault(round(row["lag"], 4), ([], []))
            for values, name in zip(pair, ("held", "loose")):
                if isinstance(row[name], float):
                    values.append(row[name])
    return dict(sorted(points.items()))


def level(label, points):
    """The exponent of the rms displacement in time, over its last three octaves."""
    lags = list(points)[-4:]
    count = max((len(points[lag][0]) for lag in lags), default=0)
    curves = [{lag: points[lag][0][k] for lag in lags if k < len(points[lag][0]) and points[lag][0][k] > 0}
              for k in range(count)]
    fit = weighted_power(curves, lags)
    spread = np.nanmax([fit.error, fit.weights, 0.0])
    verdict = None if not np.isfinite(fit.exponent) or count < 2 else True if fit.exponent + SURE * spread < SLOW else \
        False if fit.exponent - SURE * spread > SLOW else None
    last = points[lags[-1]] if lags else ([], [])
    return decide(f"At {label} disks stay in their cages: they move more slowly than by diffusion, less than with the "
                  f"root "
                  "of time.", verdict,
                  f"rms displacement after {lags[-1] if lags else np.nan:.3g} s "
                  f"{number(*mean_error(last[0]), digits=2)} "
                  f"diameters, of rattlers {number(*mean_error(last[1]), digits=2)}; over the last three octaves ~ "
                  f"time<sup><i>a</i></sup>, <i>a</i> = {number(fit.exponent, spread)}",
                  slug=f"wander-{label.split()[0]}")


def wander_figure(sets):
    picture, axes = figure(columns=2, width=7.4, height=3.8, legend=True, sharey=True)
    every = [lag for some in sets.values() for points in some.values() for lag in points]
    for panel, (motion, some) in zip(axes, sets.items()):
        for k, (drive, points) in enumerate(some.items()):
            for j, (style, what) in enumerate((("o-", ""), ("x:", ", rattlers"))):
                lags = [lag for lag, pair in points.items() if pair[j]]
                values = np.array([mean_error(points[lag][j]) for lag in lags]).reshape(-1, 2)
                if len(lags):
                    panel.errorbar(lags, values[:, 0], yerr=bars(values[:, 0], values[:, 1]), fmt=style, lw=0.8, ms=4,
                                   mfc="white", color=COLOURS[k], label=f"{drive:g} $g$" + what)
        if every:
            x = np.array([min(every), max(every)])
            panel.plot(x, 2e-4 * np.sqrt(x / x[0]), color=GREY, lw=0.9, ls="--", label="root of time", gid="guide")
        panel.set_xscale("log")
        panel.set_yscale("log")
        panel.set_xlabel("time between (s)")
        panel.set_title(f"{motion} drive", fontsize=10)
    axes[0].set_ylabel("rms displacement / diameter")
    legend_below(picture, axes, 4, fontsize=9)
    return Figure("wander", picture, "Root mean square displacement against time; rattlers apart (crosses). Dashed: "
                  "the slope of diffusion.", "Root mean square displacement against time on logarithmic axes")
