"""What rotation costs, disk by disk and packing by packing, and how far disks wander."""
import numpy as np

from ratchet.page import Figure, Numbers, Section
from ratchet.style import COLOURS, GREY, figure
from ratchet.verdict import SURE, decide, missing, number

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
    sets = {name: disks.boxes(campaign, name, drive) for name, drive in SETS}
    table = disks.by_drive(disks.boxes(campaign, "drive"))
    out = Section("powers", "What rotation costs",
                  "The floor works on the disks that touch it; of every disk it is known what it takes from the floor, "
                  "and what its contacts lose by friction and in dashpots (a contact of two disks gives half to each). "
                  f"Powers are means over the measured time. {disks.RULE} They are left out.",
                  missing=campaign.missing("low", "moderate", "drive"))
    for name, found in sets.items():
        if found:
            out.claims.append(friction(name, found))
    if len(table) >= 3:
        out.claims.append(total(table))
        out.tables.append(power_table(table))
    if not out.claims:
        out.claims.append(missing("Disks that turn faster lose more by friction.", slug="friction-rotation"))
        return out
    out.figures.append(power_figure(sets, table))
    return out


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


def power_table(table):
    rows = []
    for drive, found in table.items():
        parts = [mean_error([float(np.sum(box[name])) / len(box["omega"]) for box in found])
                 for name in ("injected", "friction", "viscous")]
        rotation = within(found, "friction"), within(found, "injected", floor_disks)
        rows.append([float(drive), len(found), *(number(*part) for part in (*parts, *rotation))])
    return Numbers("Powers per disk (W) at each drive, and rank correlations with |&Omega;| within packings",
                   ["drive/<i>g</i>", "packings", "injected", "lost by friction", "lost in dashpots",
                    "|&Omega;| and friction", "|&Omega;| and injected, at the floor"], rows)


def power_figure(sets, table):
    picture, axes = figure(columns=2, width=7.2, height=3.6)
    for k, (name, found) in enumerate(sets.items()):
        for box in found:
            part = box.held & (box["friction"] > 0) & (box["omega"] != 0)
            for chosen, fill in ((part & box.turns, COLOURS[k]), (part & ~box.turns, "none")):
                axes[0].plot(np.abs(box["omega"][chosen]), box["friction"][chosen], "os"[k], ms=2.6, mew=0.5, mfc=fill,
                             color=COLOURS[k])
        if found:
            axes[0].plot([], [], "os"[k], ms=3, color=COLOURS[k], label=f"{found[0].drive:g} $g$")
    axes[0].plot([], [], "o", ms=3, mfc="none", color=GREY, label="within 3 errors")
    every = np.concatenate([box["friction"][box.held] for found in sets.values() for box in found] or [np.ones(1)])
    axes[0].set_ylim(bottom=max(np.median(every), 1e-300) * 1e-4)
    axes[0].set_xlabel(r"$|\Omega_i|$ (rad/s)")
    axes[0].set_ylabel("lost by friction (W)")
    for k, (drive, found) in enumerate(table.items()):
        axes[1].plot([box.rms for box in found], [injected(box) for box in found], "os"[k // 8], ms=4, mfc="white",
                     color=COLOURS[k % len(COLOURS)], label=f"{drive:g} $g$")
    axes[1].set_xlabel(r"rms $\Omega$ of the packing (rad/s)")
    axes[1].set_ylabel("injected power per disk (W)")
    for panel in axes:
        panel.set_xscale("log")
        panel.set_yscale("log")
        if panel.get_legend_handles_labels()[0]:
            panel.legend(loc="lower left" if panel is axes[0] else "upper left", fontsize=8.5,
                         ncol=1 if panel is axes[0] else 2, columnspacing=0.6, handletextpad=0.1)
    return Figure("powers", picture, "Left: power that a disk loses by friction against its mean angular velocity; "
                  "full: disks that turn; those that lose hardly anything are below the axis. Right: power that the "
                  "floor puts in against the rms angular velocity, a point a packing.",
                  "Scatter plots of friction power and injected power against angular velocity")


# --- displacements ----------------------------------------------------------------------------------------------------
def displacements(campaign):
    sets = {}
    for name, drive in (*SETS, ("drive", np.nan)):
        found = disks.boxes(campaign, name, drive)
        table = disks.wandering(campaign, name, found) if found else []
        for at in {box.drive for box in found} if len(table) else ():
            if name != "drive" or at == max(box.drive for box in found):
                sets[f"{at:g} <i>g</i>"] = curve(table, found, at)
    out = Section("wander", "Is it a solid? Displacements against time",
                  "Root mean square of how far a disk has moved after a time, over all starts within the measured "
                  "time, at "
                  "the same phase of the floor. In a cage it comes to a level; a disk that diffuses goes with the "
                  "root of "
                  f"time. {disks.RULE} They are drawn apart. Errors: scatter of packings.")
    if not sets:
        out.claims.append(missing("Disks stay in their cages: displacements come to a level.", slug="wander-level"))
        return out
    out.claims += [level(label, c) for label, c in sets.items()]
    out.figures.append(wander_figure(sets))
    return out


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
    picture, axes = figure(height=3.8)
    for k, (label, points) in enumerate(sets.items()):
        for j, (style, what) in enumerate((("o-", ""), ("x:", ", rattlers"))):
            lags = [lag for lag, pair in points.items() if pair[j]]
            values = np.array([mean_error(points[lag][j]) for lag in lags]).reshape(-1, 2)
            if len(lags):
                axes.errorbar(lags, values[:, 0], yerr=bars(values[:, 0], values[:, 1]), fmt=style, lw=0.8, ms=4,
                              mfc="white", color=COLOURS[k], label=label.replace("<i>g</i>", "$g$") + what)
    every = [lag for points in sets.values() for lag in points]
    if every:
        x = np.array([min(every), max(every)])
        axes.plot(x, 2e-4 * np.sqrt(x / x[0]), color=GREY, lw=0.9, ls="--", label="root of time", gid="guide")
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.set_xlabel("time between (s)")
    axes.set_ylabel("rms displacement / diameter")
    axes.legend(loc="center left", bbox_to_anchor=(1.01, 0.5))
    return Figure("wander", picture, "Root mean square displacement against time; rattlers apart (crosses). Dashed: "
                                     "the slope "
                  "of diffusion.", "Root mean square displacement against time on logarithmic axes")
