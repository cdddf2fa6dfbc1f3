"""One packing, several histories: does each disk turn in the same way?"""
import re

import numpy as np

from ratchet.page import Figure, Numbers, Section
from ratchet.style import COLOURS, GREY, figure, legend_below
from ratchet.verdict import NO, OPEN, YES, Claim, missing, number

from .statistics import jackknife, pearson, spearman

DRIVES = {"cage_low": 0.3, "cage_middle": 0.7, "cage_moderate": 2.0}  # entries of plan.py, peak acceleration/g
LONGER = {"low": 0.3, "moderate": 2.0}  # entries whose runs are long
FEW = 40  # tables of contacts that tell the mean forces in a cage
VARIANTS = ("reference", "phase", "spin_plus", "spin_minus", "forgotten", "noise_1", "noise_2")
# slug, pairs that are compared, label of the figure, the claim's words, is it the paper's
COMPARISONS = (
    ("seed", (("noise_1", "noise_2"),), "other random\nnumbers", "under random vibration with other random numbers",
     True),
    ("start", (("reference", "phase"),), "floor half a\nperiod later",
     "when the harmonic drive begins half a period later", True),
    ("spin", (("reference", "spin_plus"), ("reference", "spin_minus")), "spins of\n$\\pm$5 rad/s",
     "when all disks spin at 5 or at &minus;5 rad/s at the start", True),
    ("memory", (("reference", "forgotten"),), "contacts\nforgotten",
     "when the contacts begin anew, with relaxed tangential springs", True),
)
EQUAL = 0.1  # share of the variance up to which two runs count as the same
BLOCK = 10   # disks that are left out together for error bars: they are neighbours in the rain


def sections(campaign):
    return [section(campaign)]


def measured(campaign, name):
    """Runs of an entry whose results are there, with means of the disks; none where only kept numbers are."""
    return [run for run in campaign.runs(name) if run.path and run.has_means]


def histories(campaign, name):
    """{(packing, variant): run} of an entry of DRIVES."""
    runs = measured(campaign, name)
    return {(packing_of(run.parameters), variant_of(run.parameters)): run for run in runs}


def shaken(campaign):
    """[(drive, number of the packing, run)]: harmonic runs at these drives with tables of contacts, as they are.
    Packings of LONGER are those of cage_start.cfg and count once; those of the sweep of drives are others and count
    from 100 on."""
    found = [(drive, packing, run) for name, drive in DRIVES.items()
             for (packing, variant), run in sorted(histories(campaign, name).items()) if variant == "reference"]
    found += [(drive, replica_of(run), run) for name, drive in LONGER.items() for run in measured(campaign, name)]
    found += [(run.parameters.get("drive"), 100 + k, run) for k, run in enumerate(measured(campaign, "drive"))]
    once = {}
    for drive, packing, run in found:
        if drive in DRIVES.values() and len(run.result.contacts) >= FEW:
            once.setdefault((drive, packing), run)
    return [(*key, run) for key, run in once.items()]


def replica_of(run):
    return int(run.parameters.get("r", 0))


def at_random(campaign):
    """[(drive, number of the packing, run)] under random vibration, one history of each packing."""
    found = [(drive, packing, run) for name, drive in DRIVES.items()
             for (packing, variant), run in sorted(histories(campaign, name).items()) if variant == "noise_1"]
    found += [(run.parameters.get("drive"), 100 + k, run) for k, run in enumerate(measured(campaign, "random"))]
    return [one for one in found if one[0] in DRIVES.values() and len(one[2].result.contacts) >= FEW]


def packing_of(parameters):
    """Number of the packing that a run began with: 0 of base.h5, k of r=k.h5, which is r_k.h5 in a point's name."""
    found = re.search(r"_r_(\d+)\.h5$", str(parameters.get("start", "")))
    return int(found[1]) if found else 0


def variant_of(parameters):
    """What a point of inputs/packing/cage_memory.cfg does otherwise, from its parameters."""
    if "spin" in parameters:
        return "spin_plus" if parameters["spin"] > 0 else "spin_minus"
    if "noise" in parameters:
        return f"noise_{parameters['noise']:.0f}"
    return "phase" if "phase" in parameters else "forgotten" if "contacts" in parameters else "reference"


def numbers(campaign):
    """A row for each disk of each packing and drive: Omega with its error and halves in each history, mean places."""
    columns = ["drive", "packing", "disk", "radius"]
    columns += [f"{variant}{part}" for variant in VARIANTS for part in ("", "_error", "_first", "_second", "_x", "_y")]
    rows = []
    for name, drive in DRIVES.items():
        runs = histories(campaign, name)
        for packing in sorted({packing for packing, variant in runs if variant != "reference"}):
            parts = {variant: per_disk(runs[packing, variant]) for variant in VARIANTS if (packing, variant) in runs}
            some = runs[packing, next(iter(parts))]
            empty = np.full((some.n_free, 6), np.nan)
            known = np.column_stack([np.full(some.n_free, drive), np.full(some.n_free, packing), some.id, some.radius])
            rows.append(np.hstack([known, *(parts.get(variant, empty) for variant in VARIANTS)]))
    return dict(zip(columns, np.vstack(rows).T)) if rows else None


def per_disk(run):
    return np.column_stack([run.omega, run.error, run.first, run.second, run.x, run.y])


class Disks:
    """Omega of the same disks in two histories: one row per disk."""

    def __init__(self, table, drive, pair):
        here = table.column("drive") == drive
        both = here & np.isfinite(table.column(pair[0])) & np.isfinite(table.column(pair[1]))
        self.packing = table.column("packing")[both]
        self.number = table.column("disk")[both]
        for side, variant in zip("ab", pair):
            for part in ("", "_error", "_first", "_second", "_x", "_y"):
                setattr(self, side + part, table.column(variant + part)[both])
        self.diameter = 2 * np.mean(table.column("radius"))

    def __len__(self):
        return len(self.a)

    @property
    def apart(self):
        """Distance of the mean places in the two histories, in mean diameters."""
        return np.hypot(self.a_x - self.b_x, self.a_y - self.b_y) / self.diameter

    def columns(self):
        return np.column_stack([self.a, self.a_first, self.a_second, self.b, self.b_first, self.b_second])

    def blocks(self):
        """Rows of `columns` in blocks of disks that lie near each other, for error bars."""
        block = self.packing * 1000 + self.number // BLOCK
        return [self.columns()[block == one] for one in np.unique(block)]


def not_repeated(rows):
    """Share of the variance of Omega that two histories do not have in common: mean (a - b)^2 over mean a^2 + b^2. 0:
    the same in both; 1: not related at all."""
    a, b = rows[:, 0], rows[:, 3]
    total = np.mean(a * a + b * b)
    return float(np.mean((a - b) ** 2) / total) if total > 0 else np.nan


def wandering(rows):
    """The same share that the scatter of a mean makes in one history: (first - second)^2/4 is its square."""
    _, a1, a2, _, b1, b2 = rows.T
    total = np.mean((a1 + a2) ** 2 + (b1 + b2) ** 2) / 4
    return float(np.mean((a1 - a2) ** 2 + (b1 - b2) ** 2) / 4 / total) if total > 0 else np.nan


def rank_loss(rows):
    """By how much Spearman's correlation of halves of two histories is below that of the halves of one."""
    _, a1, a2, _, b1, b2 = rows.T
    return (spearman(a1, a2) + spearman(b1, b2) - spearman(a1, b2) - spearman(b1, a2)) / 2


def together(function, pairs):
    """(function of all disks of these pairs, its error from leaving out blocks of disks)."""
    blocks = [block for pair in pairs for block in pair.blocks()]
    return jackknife(lambda kept: function(np.vstack(kept)), blocks)


def same(share, noise, loss):
    """Verdict on the share that is not repeated, what of it the scatter of means explains, and the loss of rank
    correlation, each (value, error): both small, or one surely too large."""
    if not all(np.isfinite([*share, *noise, *loss])):
        return OPEN
    if share[0] + share[1] <= EQUAL and abs(loss[0]) + loss[1] <= EQUAL:
        return YES
    beyond = share[0] - noise[0] - 2 * np.hypot(share[1], noise[1])
    return NO if beyond > EQUAL or loss[0] - 2 * loss[1] > EQUAL else OPEN


def section(campaign):
    table = campaign.numbers("memory", lambda: numbers(campaign), digits=6,
                             title="mean angular velocity (rad/s), its error, halves, mean place (m) in each history")
    out = Section("memory", "One packing, several histories: what &Omega;<sub>i</sub> remembers",
                  "Packings of 60 disks at rest (<code>inputs/packing/cage_start.cfg</code>) are shaken several "
                  "times, each time from the same places (<code>cage_memory.cfg</code>). If the cage sets "
                  "&Omega;<sub>i</sub>, it is the same in all these runs; if the contacts' memory does, it is not. Harmonic and "
                  "random drive have the same rms displacement. "
                  "What two runs do not have in common is the mean square of their differences over twice the mean "
                  f"&Omega;&sup2;. They count as the same when it is at most {EQUAL:g} and the rank correlation of "
                  f"halves of two runs is at most {EQUAL:g} below that of halves of one. Errors are from leaving out "
                  f"{BLOCK} neighbouring disks at a time.", missing=campaign.missing("cage_start", *DRIVES))
    if not table:
        out.claims.append(missing("Each disk turns in the same way in all histories of its packing."))
        return out
    rows = []
    for drive in DRIVES.values():
        for slug, pairs, _, words, paper in COMPARISONS:
            compared = [pair for pair in (Disks(table, drive, pair) for pair in pairs) if len(pair)]
            if compared:
                claim, row = judge(slug, words, paper, drive, compared)
                out.claims.append(claim)
                rows.append(row)
    out.figures += [scatter_figure(table), correlation_figure(table)]
    out.tables.append(Numbers("Two histories of the same packings", [
        "drive/<i>g</i>", "history", "packings", "disks", "not in common", "by scatter of means", "Pearson", "Spearman",
        "Pearson of halves", "Spearman of halves", "rms difference (rad/s)", "beyond 3 errors",
        "largest distance of mean places/<i>d</i>"], rows, shown=True))
    return out


def judge(slug, words, paper, drive, pairs):
    share, noise, loss = (together(function, pairs) for function in (not_repeated, wandering, rank_loss))
    between = [together(lambda rows, f=f: f(rows[:, 0], rows[:, 3]), pairs) for f in (pearson, spearman)]
    within = [together(lambda rows, f=f: (f(rows[:, 1], rows[:, 2]) + f(rows[:, 4], rows[:, 5])) / 2, pairs)
              for f in (pearson, spearman)]
    a, b, error = (np.concatenate(parts) for parts in zip(*((p.a, p.b, np.hypot(p.a_error, p.b_error)) for p in pairs)))
    packings = len(np.unique(np.concatenate([p.packing for p in pairs])))
    apart = np.concatenate([p.apart for p in pairs])
    differ = float(np.mean(np.abs(a - b) > 3 * error))
    rms = float(np.sqrt(np.mean((a - b) ** 2)))
    text = f"At {drive:g} <i>g</i> each disk has the same &Omega; {words}."
    found = (f"{number(*share)} of the variance is not in common, {number(*noise)} by the scatter of means; Pearson "
             f"{number(*between[0])}, Spearman {number(*between[1])}, of the halves of one run {number(*within[0])} "
             f"and {number(*within[1])}; {100 * differ:.0f} % of {len(a)} disks in {packings} "
             f"packing{'s' * (packings > 1)} differ by more than 3 errors, rms difference {number(rms)} rad/s; mean "
             f"places differ by {number(float(np.median(apart)))} diameters (median), {number(float(apart.max()))} "
             "at most")
    claim = Claim(text, same(share, noise, loss), found, kind="paper" if paper else "own check",
                  slug=f"quenched-{slug}-{drive:g}g")
    label = next(label for one, _, label, _, _ in COMPARISONS if one == slug).replace("\n", " ").replace("$\\pm$", "±")
    return claim, [drive, label, packings, len(a), number(*share), number(*noise),
                   *(number(*pair) for pair in (*between, *within)), rms, differ, float(apart.max())]


def scatter_figure(table):
    """Omega in one history against another: a row of panels per drive."""
    shown = [c for c in COMPARISONS if c[0] in ("seed", "start", "spin", "memory")]
    picture, axes = figure(columns=len(shown), rows=3, width=7.4, height=6.0)
    for row, drive in zip(axes, DRIVES.values()):
        here = table.column("drive") == drive
        values = np.concatenate([table.column(variant)[here] for variant in VARIANTS])
        values = values[np.isfinite(values)]
        if not len(values):
            continue
        rms, top = float(np.sqrt(np.mean(values ** 2))), 1.4 * float(np.abs(values).max())
        for panel, (slug, pairs, label, _, _) in zip(row, shown):
            panel.plot([-top, top], [-top, top], color=GREY, lw=0.7, zorder=1, gid="guide")
            for pair in pairs:
                disks = Disks(table, drive, pair)
                for k in np.unique(disks.packing):
                    one = disks.packing == k
                    panel.errorbar(disks.a[one], disks.b[one], xerr=disks.a_error[one], yerr=disks.b_error[one],
                                   fmt="o",
                                   ms=2.2, mew=0, lw=0.5, capsize=0, color=COLOURS[int(k) % len(COLOURS)], zorder=3)
            for scale, limit in ((panel.set_xscale, panel.set_xlim), (panel.set_yscale, panel.set_ylim)):
                scale("symlog", linthresh=0.1 * rms, linscale=0.5)
                limit(-top, top)
            for axis in (panel.xaxis, panel.yaxis):
                axis.set_major_locator(Powers(0.1 * rms, top))
                axis.set_minor_locator(Powers(np.inf, 0))
            panel.tick_params(labelsize=7)
            panel.set_title(label.replace("\n", " ") if drive == min(DRIVES.values()) else "", fontsize=9)
        row[0].set_ylabel(rf"{drive:g} $g$: $\Omega_i$ (rad/s)", fontsize=10)
    for panel in axes[-1]:
        panel.set_xlabel(r"$\Omega_i$ (rad/s)", fontsize=10)
    return Figure("memory-scatter", picture,
                  "Mean angular velocity of each disk in one history of its packing against that in another, at "
                  "three drives; logarithmic beyond a tenth of the rms; a colour per packing; line: equal. Bars: "
                  "errors of the means.", "Scatter plots of mean angular velocities in two histories")


class Powers:
    """Ticks at zero and at two powers of ten of each sign between these values."""

    def __new__(cls, least, top):
        from matplotlib.ticker import FixedLocator
        if not np.isfinite(least):
            return FixedLocator([])
        last = int(np.floor(np.log10(top)))
        powers = [10.0 ** k for k in (last - 1, last) if 10.0 ** k > 1.5 * least]
        return FixedLocator([-p for p in powers] + [0.0] + powers)


def correlation_figure(table):
    """Pearson and Spearman of two histories beside those of the halves of one run."""
    picture, axes = figure(columns=3, width=7.4, height=3.2, legend=True, sharey=True)
    for panel, drive in zip(axes, DRIVES.values()):
        for k, (slug, pairs, label, _, _) in enumerate(COMPARISONS):
            compared = [pair for pair in (Disks(table, drive, pair) for pair in pairs) if len(pair)]
            if not compared:
                continue
            for j, (f, name) in enumerate(((pearson, "Pearson"), (spearman, "Spearman"))):
                cross = together(lambda r, f=f: (f(r[:, 1], r[:, 5]) + f(r[:, 4], r[:, 2])) / 2, compared)
                own = together(lambda r, f=f: (f(r[:, 1], r[:, 2]) + f(r[:, 4], r[:, 5])) / 2, compared)
                for value, shift, fill, what in ((own, -0.12, "white", "halves of one run"),
                                                 (cross, 0.12, COLOURS[j], "halves of two runs")):
                    panel.errorbar(k + shift + 0.08 * (j - 0.5), value[0], yerr=value[1], fmt="os"[j], ms=5,
                                   mfc=fill, color=COLOURS[j], lw=0.9, label=None if k else f"{name}, {what}")
        panel.axhline(1, color=GREY, lw=0.6, gid="guide")
        panel.set_xticks(range(len(COMPARISONS)), [c[2].replace("\n", " ") for c in COMPARISONS], rotation=55,
                         ha="right", rotation_mode="anchor", fontsize=8)
        panel.xaxis.set_tick_params(which="minor", bottom=False, top=False)
        panel.set_title(f"{drive:g} $g$")
        panel.set_xlim(-0.6, len(COMPARISONS) - 0.4)
    axes[0].set_ylabel("correlation of halves")
    legend_below(picture, axes, fontsize=8, columnspacing=1.0, handletextpad=0.2)
    return Figure("memory-correlation", picture,
                  "Correlation of the mean angular velocities of two halves: of one run (open) and of two runs with "
                  "different histories (filled). Where they agree the history does not matter.",
                  "Correlations within and between histories of a packing")
