"""All disks but one kept from turning: how much of Omega is the cage's, how much is gearing, and what is left."""
import os
import re

import numpy as np

from ratchet.data import Table
from ratchet.page import Figure, Numbers, Section
from ratchet.runs import slipdisk
from ratchet.style import COLOURS, GREY, LIGHT, figure, legend_below
from ratchet.verdict import SURE, beside, decide, missing, number

from . import contacts
from .disks import HELD, Box
from .each import percent
from .memory import packing_of
from .reading import Reading, Run
from .statistics import jackknife, pearson, share, spearman

SINGLE = "alone_single"
ENTRIES = {"alone_low": 0.3, "alone_middle": 0.7, "alone_moderate": 2.0, SINGLE: 0.7}  # of plan.py, drive/g
FREE = "grains"  # in a point's name: all disks turn
HALF = 0.5       # share of the variance that counts as most of it
RCOND = 1e-3     # least singular value of 1 - G, over the largest: a row of gears that nothing holds has none
DIGITS = 5

NEAR = 0.1  # gap in mean diameters up to which two disks count as neighbours where sets are chosen


def sets(x, y, radius):
    """Lists of disks that may turn in the same run: none of a list touches another of it, or a disk that another of it
    touches. Greedy colouring of the graph of second neighbours, disks with the most neighbours first."""
    x, y, radius = (np.asarray(values, float) for values in (x, y, radius))
    gap = np.hypot(x[:, None] - x, y[:, None] - y) - radius[:, None] - radius
    near = gap < NEAR * 2 * radius.mean()
    second = (near.astype(int) @ near) > 0  # a disk is its own neighbour, so first neighbours are among these
    found = []
    for i in np.argsort(-second.sum(axis=1), kind="stable"):
        free = [one for one in found if not second[i, one].any()]
        if free:
            min(free, key=len).append(int(i))
        else:
            found.append([int(i)])
    return [sorted(one) for one in found]


def grids(folder, packings=8, single=()):
    """Text of the sweep: a grid per packing of cage_start.cfg, of runs in which all disks turn, and one of runs in which
    those of one set do; for packings of `single`, of runs in which one disk does."""
    motion = ('{ path = ("phases.thermalise.motions", "phases.measure.motions"); name = "motion"; '
              'values = ("shake", "noise"); }')
    out = []
    for k in range(packings):
        file = os.path.join(folder, "cage_start", "points", f"r={k}.h5" if k else "base.h5")
        if not os.path.exists(file):
            continue
        result = slipdisk.Result(file)
        n = result.attributes("state").n_free
        chosen = [[i] for i in range(n)] if k in single else sets(*(result.state[key][:n] for key in ("x", "y", "radius")))
        start = f'{{ path = "disk_files[0].file"; name = "start"; values = ("{file}"); }}'
        free = ", ".join("(" + ", ".join(map(str, one)) + ")" for one in chosen)
        out += [f'{{ parameters = ({start}, {{ path = "locks[0].except"; name = "free"; values = ({free}); }}, {motion}); }}',
                f'{{ parameters = ({start}, {{ path = "locks[0].except"; name = "free"; values = ("grains"); }}, {{ path = '
                f'"phases.measure.contacts"; name = "contacts"; values = (307); }}, {motion}); }}']
    return "(" + ", ".join(out) + ")"


# --- numbers of each disk ---------------------------------------------------------------------------------------------
def numbers(campaign):
    """(a row for each disk of each packing, drive and motion; a row for each contact of them), or (None, None)."""
    disks, links = [], []
    for name, drive in ENTRIES.items():
        for (random, packing), files in sorted(histories(campaign.files(name)).items()):
            if FREE in files:
                key = {"single": float(name == SINGLE), "drive": drive, "random": float(random),
                       "packing": float(packing)}
                one, contact = of_packing(files)
                disks += [{**key, **row} for row in one]
                links += [{**key, **row} for row in contact]
    return (Table(disks), Table(links)) if disks else (None, None)


def histories(files):
    """{(random, packing): {"grains" or numbers of the disks that turn: file}}"""
    found = {}
    for path in files:
        free = re.search(r"free=([0-9_]+|grains)", os.path.basename(path))[1]
        random = "motion=noise" in os.path.basename(path)
        start = re.search(r"start=([^,]*)", os.path.basename(path))[1]
        found.setdefault((random, packing_of({"start": start})), {})[free] = path
    return found


def of_packing(files):
    """Rows of the disks and of the contacts of one packing under one motion."""
    reading = Reading(files[FREE])
    run = Run(reading.scalars(), path=files[FREE])
    cage = contacts.Cage(run)
    alone = np.full((2, run.n_free), np.nan)
    for free, path in files.items():
        if free != FREE:
            means, chosen = Reading(path).means, [int(word) for word in free.split("_")]
            alone[:, chosen] = means["omega"][chosen], means["error"][chosen]
    load = np.bincount(cage.disk, cage.force, run.n_free)
    held = np.bincount(cage.disk, minlength=run.n_free)
    disks = [{"disk": float(k), "radius": run.radius[k], "omega": run.omega[k], "error": run.error[k],
              "first": run.first[k], "second": run.second[k], "alone": alone[0, k], "alone_error": alone[1, k],
              "contacts": float(held[k]), "load": load[k], "friction": run.means["friction"][k]} for k in range(run.n_free)]
    near = (cage.other < run.n_free) & (cage.disk < cage.other)
    return disks, [{"a": float(a), "b": float(b), "force": force}
                   for a, b, force in zip(cage.disk[near], cage.other[near], cage.force[near])]


class Packing:
    """Omega of the disks of a packing: measured, alone, and what the gears make of it. `held`: no rattlers."""

    def __init__(self, disks, links):
        column = {name: disks.column(name) for name in disks.rows[0]}
        self.column = column
        self.omega, self.error, self.alone, self.alone_error = (
            column[name] for name in ("omega", "error", "alone", "alone_error"))
        self.first, self.second = column["first"], column["second"]
        self.held = (column["contacts"] >= HELD) & np.isfinite(self.alone)
        self.gears = gears(column["radius"], column["load"], *(links.column(name) for name in ("a", "b", "force")))
        own = np.nan_to_num(self.alone)
        self.together = np.linalg.lstsq(np.eye(len(own)) - self.gears, own, rcond=RCOND)[0]
        self.neighbours = self.gears @ self.omega
        self.rms = float(np.sqrt(np.mean(self.omega[self.held] ** 2)))

    @property
    def turns(self):
        return np.abs(self.omega) > SURE * self.error

    @property
    def turns_alone(self):
        return np.abs(self.alone) > SURE * self.alone_error

    def box(self, drive, replica):
        """The packing as the other sections take it."""
        column = self.column
        whole = {"drive": drive, "replica": float(replica), "measured": np.nan}
        return Box(whole, {"radius": column["radius"], "omega": self.omega, "error": self.error, "omega_first": self.first,
                           "omega_second": self.second, "persistent": column["contacts"], "friction": column["friction"]})

    def columns(self):
        """Measured, alone, cage and gears together, gears of the measured neighbours: over the rms, no rattlers."""
        return np.column_stack([self.omega, self.alone, self.together, self.neighbours])[self.held] / self.rms


def gears(radius, load, a, b, force):
    """Matrix G of Omega = Omega_0 + G Omega: -R_j N_ij/(R_i N_i), from mean normal forces N_ij of contacts between free
    disks and the sum N_i over all contacts of a disk, walls included."""
    matrix, a, b = np.zeros((len(radius), len(radius))), a.astype(int), b.astype(int)
    for i, j in ((a, b), (b, a)):
        good = load[i] > 0
        np.add.at(matrix, (i[good], j[good]), -(radius[j] * force / (radius[i] * np.where(load[i] > 0, load[i], 1)))[good])
    return matrix


# --- statistics -------------------------------------------------------------------------------------------------------
def explained(measured, predicted, free=False):
    """Share of the variance about zero that a prediction explains; free: up to one factor."""
    factor = float(measured @ predicted / (predicted @ predicted)) if free and predicted.any() else 1.0
    return float(1 - np.sum((measured - factor * predicted) ** 2) / np.sum(measured ** 2))


def pooled_share(packings, k, free=False):
    """(share, error from leaving out one packing at a time); k: column of Packing.columns."""
    return jackknife(lambda part: explained(*np.vstack(part)[:, [0, k]].T, free), [p.columns() for p in packings])


def balance(packings):
    """(share of the variance, factors of Omega_0 and G Omega) of Omega = x Omega_0 + y G Omega, each with its error."""
    def fit(part):
        rows = np.vstack(part)
        return np.linalg.lstsq(rows[:, [1, 3]], rows[:, 0], rcond=None)[0]

    groups = [p.columns() for p in packings]
    share = jackknife(lambda part: (lambda rows: explained(rows[:, 0], rows[:, 1] + rows[:, 3]))(np.vstack(part)), groups)
    return share, *(jackknife(lambda part, k=k: float(fit(part)[k]), groups) for k in range(2))


def shares(packings):
    """{cage, gearing, neighbours, neither, noise}: (share of the variance, error). Cage: what Omega_0 explains up to one
    factor; gearing: what (1 - G)^-1 Omega_0 explains beyond it; neighbours: what x Omega_0 + y G Omega with the measured
    Omega of the neighbours explains beyond that; neither: the rest; noise: error bars of Omega, median over packings,
    since a disk that settles late has a large one."""
    groups = [p.columns() for p in packings]

    def of(part):
        rows = np.vstack(part)
        solved = explained(rows[:, 0], rows[:, 2], True)
        both = rows[:, [1, 3]]
        fitted = explained(rows[:, 0], both @ np.linalg.lstsq(both, rows[:, 0], rcond=None)[0])
        return explained(rows[:, 0], rows[:, 1], True), solved, max(fitted, solved)

    noise = [np.mean((p.error[p.held] / p.rms) ** 2) for p in packings]
    return {"cage": jackknife(lambda part: of(part)[0], groups),
            "gearing": jackknife(lambda part: of(part)[1] - of(part)[0], groups),
            "neighbours": jackknife(lambda part: of(part)[2] - of(part)[1], groups),
            "neither": jackknife(lambda part: 1 - of(part)[2], groups),
            "noise": (float(np.median(noise)), np.nan)}


def counted(packings, chosen, hit):
    """(fraction, error) of the chosen disks of which `hit` holds; both are functions of a packing."""
    return share([(int((hit(p) & chosen(p)).sum()), int(chosen(p).sum())) for p in packings])


# --- the section ------------------------------------------------------------------------------------------------------
LEAD = (
    "All disks but some are kept from turning; they still move (<code>inputs/packing/cage_alone.cfg</code>, "
    "<a href=\"../deck.md#locks\">locks</a>). &Omega;<sub>0</sub> is the mean angular velocity of a disk whose neighbours "
    "do not turn: the part that its cage makes. Eight packings of <code>cage_start.cfg</code>, each shaken by the "
    "harmonic motion and by the random one of the same rms displacement. In a run the disks of one set turn: no two of "
    "them touch each other or the same disk, so that each has neighbours that do not turn and 8 or 9 runs do for 60 "
    "disks. {check}</p><p><b>Gears.</b> A contact of the disks <i>i</i> and <i>j</i> slides to and fro with a mean speed "
    "<i>v</i> that is much larger than that of the mean rotation. The tangential force is &plusmn;&mu;<i>N<sub>ij</sub></i>"
    ". A mean velocity <i>R<sub>i</sub></i>&Omega;<sub>i</sub> + <i>R<sub>j</sub></i>&Omega;<sub>j</sub> of the surfaces "
    "shifts the mean sign of sliding, to first order by &minus;2(<i>R<sub>i</sub></i>&Omega;<sub>i</sub> + "
    "<i>R<sub>j</sub></i>&Omega;<sub>j</sub>)/&pi;<i>v</i> for velocities with a Gaussian distribution. So the mean torque "
    "on disk <i>i</i> vanishes when <i>T<sub>i</sub></i> = (2&mu;<i>R<sub>i</sub></i>/&pi;<i>v</i>) &Sigma;<sub>j</sub> "
    "<i>N<sub>ij</sub></i>(<i>R<sub>i</sub></i>&Omega;<sub>i</sub> + <i>R<sub>j</sub></i>&Omega;<sub>j</sub>), where "
    "<i>T<sub>i</sub></i> is the torque of its cage. Divided by the drag of the disk itself, with <i>N<sub>i</sub></i> = "
    "&Sigma;<sub>j</sub> <i>N<sub>ij</sub></i> over all its contacts, walls included: &Omega; = &Omega;<sub>0</sub> + "
    "<i>G</i>&Omega;, <i>G<sub>ij</sub></i> = &minus;<i>R<sub>j</sub>N<sub>ij</sub></i>/(<i>R<sub>i</sub>N<sub>i</sub></i>)"
    ". Nothing is fitted: &Omega;<sub>0</sub> is measured alone, <i>N<sub>ij</sub></i> are the mean normal forces of the "
    "run in which all turn. <i>Cage</i>: share of the variance of &Omega; that &Omega;<sub>0</sub> explains up to one "
    "factor; <i>gearing</i>: what (1 &minus; <i>G</i>)<sup>&minus;1</sup>&Omega;<sub>0</sub> explains beyond; "
    "<i>neighbours</i>: what <i>x</i>&Omega;<sub>0</sub> + <i>yG</i>&Omega; with the measured &Omega; of the neighbours "
    "explains beyond that, an upper bound of gearing, since neighbours also follow the disk itself; <i>neither</i>: the rest. "
    "Error bars of &Omega;: median over packings. Disks with fewer than two "
    "contacts that are closed a tenth of the time are left out. Errors: leaving out one packing at a time.")
MOTIONS = {0.0: "harmonic", 1.0: "random"}


def packings_of(table, links):
    """{(drive, random): packings}; {random: packings of the runs with one disk at a time}"""
    found, single = {}, {}
    keys = sorted({(row["single"], row["drive"], row["random"], row["packing"]) for row in table.rows})
    for key in keys:
        where = dict(zip(("single", "drive", "random", "packing"), key))
        one = Packing(table.where(**where), links.where(**where))
        (single.setdefault(key[2], []) if key[0] else found.setdefault(key[1:3], [])).append(one)
    return found, single


def tables_of(campaign):
    made = []

    def make(k):
        if not made:
            made.append(numbers(campaign))
        return made[0][k]

    return (campaign.numbers("alone", lambda: make(0), "mean angular velocity (rad/s) of each disk where all turn, and "
                             "where its neighbours do not (alone); load: sum of the mean normal forces (N); single: one "
                             "disk turns at a time, else one set", DIGITS, **campaign.told(*ENTRIES)),
            campaign.numbers("alone-contacts", lambda: make(1), "mean normal force (N) of the contacts between disks where "
                             "all turn", 4))


def sections(campaign):
    table, links = tables_of(campaign)
    found, single = packings_of(table, links) if table else ({}, {})
    out = Section("alone", "The cage alone: all disks but one kept from turning", LEAD.format(check=agreement(found, single)),
                  missing=campaign.missing(*ENTRIES))
    if not found:
        out.claims.append(missing("&Omega; of a disk is set by its cage.", kind="paper", slug="alone-cage"))
        return [out]
    judges = (cage_turns, set_by_cage, with_gears, balanced)
    made = {key: [judge(key, packings) for judge in judges] for key, packings in found.items()}
    for drive in sorted({key[0] for key in made}):
        out.claims += beside(*(made.get((drive, random), []) for random in MOTIONS))
    out.figures += [shares_figure(found), scatter_figure(found)]
    out.tables.append(shares_table(found, single))
    return [out]


def at(key):
    return f"At {key[0]:g} <i>g</i> "


def slug_of(key):
    return f"{MOTIONS[key[1]]}-{key[0]:g}g"


def agreement(found, single):
    """How well a set at a time agrees with one disk at a time."""
    told = []
    for random, packings in single.items():
        a = packings[0]
        b = found.get((0.7, random), [None])[0]
        if b is not None:
            told.append(f"{likeness_of(a, b):.3f} under {MOTIONS[random]} drive")
    return ("Of one packing at 0.7 <i>g</i> each disk has turned alone, too, in 60 runs (last rows of the table): "
            "&Omega;<sub>0</sub> of both kinds of runs is correlated by " + " and ".join(told) + ". Sets do for single disks "
            "where that is near one; where it is not, the rotation of a disk depends on which disks far from it may turn."
            ) if told else ""


def likeness_of(one, other):
    """Correlation of Omega_0 of the same packing from two kinds of runs."""
    both = one.held & other.held
    return pearson(one.alone[both], other.alone[both])


def cage_turns(key, packings):
    value, error = counted(packings, lambda p: p.held, lambda p: p.turns_alone)
    also = counted(packings, lambda p: p.held & p.turns, lambda p: p.turns_alone)
    verdict = None if not error > 0 else True if value - SURE * error > HALF else False if value + SURE * error < HALF \
        else None
    return decide(f"{at(key)}most disks turn although none of their neighbours does.", verdict,
                  f"{percent((value, error))} are beyond {SURE:g} errors, of those that turn where all do "
                  f"{percent(also)}", slug=f"alone-turns-{slug_of(key)}")


def beyond(value, error, limit=HALF):
    """Verdict on a share that is to be above a limit, by two errors."""
    return None if not error > 0 else True if value - 2 * error > limit else False if value + 2 * error < limit else None


def set_by_cage(key, packings):
    part = shares(packings)
    sense = counted(packings, lambda p: p.held & p.turns & p.turns_alone, lambda p: p.omega * p.alone > 0)
    values = [p.columns() for p in packings]
    linear, ranks = (jackknife(lambda part, f=f: f(*np.vstack(part)[:, :2].T), values) for f in (pearson, spearman))
    rms = [np.sqrt(np.mean(np.concatenate([getattr(p, name)[p.held] for p in packings]) ** 2)) for name in ("omega", "alone")]
    return decide(f"{at(key)}&Omega; of a disk is set by its cage: more than half of its variance is that of "
                  "&Omega;<sub>0</sub>.", beyond(*part["cage"]),
                  f"share {number(*part['cage'])}; correlation {number(*linear)}, of ranks {number(*ranks)}; same sense "
                  f"{percent(sense)} of those beyond {SURE:g} errors in both; rms {number(rms[0])} rad/s, alone "
                  f"{number(rms[1])} rad/s", kind="paper", slug=f"alone-cage-{slug_of(key)}")


def with_gears(key, packings):
    part = shares(packings)
    exact = pooled_share(packings, 2)
    value = jackknife(lambda some: explained(*np.vstack(some)[:, [0, 2]].T, True), [p.columns() for p in packings])
    sense = counted(packings, lambda p: p.held & p.turns, lambda p: p.omega * p.together > 0)
    return decide(f"{at(key)}cage and gearing together, (1 &minus; <i>G</i>)<sup>&minus;1</sup>&Omega;<sub>0</sub>, make "
                  "more than half of the variance.", beyond(*value),
                  f"share {number(*value)}, with the factor one {number(*exact)}; gearing adds {number(*part['gearing'])}; "
                  f"error bars of &Omega; {number(*part['noise'])}; same sense {percent(sense)}",
                  slug=f"alone-gears-{slug_of(key)}")


def balanced(key, packings):
    value, own, other = balance(packings)
    good = all(error > 0 for _, error in (own, other))
    fits = good and all(abs(v - 1) < 2 * e for v, e in (own, other))
    off = good and any(abs(v - 1) > SURE * e for v, e in (own, other))
    verdict = None if not good else False if off else True if fits and max(own[1], other[1]) < 0.2 else None
    return decide(f"{at(key)}&Omega; = &Omega;<sub>0</sub> + <i>G</i>&Omega; holds with the measured &Omega; of the "
                  "neighbours: both factors are one.", verdict,
                  f"&Omega; = <i>x</i>&Omega;<sub>0</sub> + <i>yG</i>&Omega; with <i>x</i> = {number(*own)}, <i>y</i> = "
                  f"{number(*other)}; with both one it explains {number(*value)} of the variance",
                  slug=f"alone-balance-{slug_of(key)}")


# --- tables and figures -----------------------------------------------------------------------------------------------
def shares_table(found, single):
    rows = []
    for key, packings in [*found.items(), *(((0.7, random), some) for random, some in single.items())]:
        part, (value, own, other) = shares(packings), balance(packings)
        apart = packings is single.get(key[1])
        rows.append([key[0], MOTIONS[key[1]] + ", one disk at a time" * apart, len(packings),
                     int(sum(p.held.sum() for p in packings)),
                     *(number(*part[name]) for name in ("cage", "gearing", "neighbours", "neither", "noise")),
                     number(*pooled_share(packings, 2)), number(*value), number(*own), number(*other),
                     float(np.median(np.concatenate([p.error[p.held] for p in packings]))),
                     float(np.median(np.concatenate([p.alone_error[p.held] for p in packings])))])
    return Numbers("Shares of the variance of &Omega;", [
        "drive/<i>g</i>", "motion", "packings", "disks", "cage", "gearing", "neighbours", "neither", "error bars",
        "cage and gearing, factor one", "&Omega;<sub>0</sub> + <i>G</i>&Omega;", "<i>x</i>", "<i>y</i>",
        "median error (rad/s)", "alone (rad/s)"], rows, shown=True)


PARTS = (("cage", COLOURS[0], "cage alone"), ("gearing", COLOURS[1], "gearing, solved"),
         ("neighbours", COLOURS[4], "measured neighbours"), ("neither", LIGHT, "neither"))
SHIFT = {"cage": -0.18, "gearing": 0.0, "neighbours": 0.18}


def shares_figure(found):
    picture, axes = figure(columns=2, width=7.0, height=3.0, legend=True, sharey=True)
    for panel, (random, word) in zip(axes, MOTIONS.items()):
        keys = [key for key in found if key[1] == random]
        for k, key in enumerate(keys):
            part, under = shares(found[key]), 0.0
            for name, colour, label in PARTS:
                value, error = part[name]
                panel.bar(k, max(value, 0), 0.66, under, color=colour, edgecolor="white", lw=0.5,
                          label=None if k or panel is axes[1] else label)
                under += max(value, 0)
                if name != "neither":
                    panel.errorbar(k + SHIFT[name], under, yerr=np.nan_to_num(error), fmt="none",
                                   ecolor="black", lw=1, capsize=2)
        panel.set_xticks(range(len(keys)), [f"{key[0]:g} $g$" for key in keys])
        panel.minorticks_off()
        panel.set_title(f"{word} drive", fontsize=10)
        panel.set_ylim(0, 1.05)
    axes[0].set_ylabel(r"fraction of the variance of $\Omega_i$")
    legend_below(picture, axes, 4)
    return Figure("alone-shares", picture, "Fraction of the variance of &Omega;<sub>i</sub> that is explained by the cage "
                  "alone (&Omega;<sub>0</sub>, neighbours kept from turning), by gearing beyond it, (1 &minus; "
                  "<i>G</i>)<sup>&minus;1</sup>&Omega;<sub>0</sub>, by the measured &Omega; of the neighbours beyond that, and "
                  "by neither. Bars: leaving out one packing at a time.",
                  "Stacked bars of the variance explained by cage and gearing at three drives, harmonic and random")


def scatter_figure(found):
    """Measured against alone (above) and against cage and gearing (below), at the drive in the middle."""
    drive = sorted({key[0] for key in found})[len({key[0] for key in found}) // 2]
    picture, axes = figure(columns=2, rows=2, width=6.6, height=6.0, sharex=True, sharey=True)
    for column, (random, word) in enumerate(MOTIONS.items()):
        packings = found.get((drive, random), [])
        rows = np.vstack([p.columns() for p in packings]) if packings else np.zeros((0, 4))
        for panel, k in ((axes[0, column], 1), (axes[1, column], 2)):
            panel.plot([-9, 9], [-9, 9], color=GREY, lw=0.8, zorder=1, gid="guide")
            panel.plot(rows[:, k], rows[:, 0], "o", ms=2.4, mew=0, alpha=0.6, color=COLOURS[column])
            for scale, limit in ((panel.set_xscale, panel.set_xlim), (panel.set_yscale, panel.set_ylim)):
                scale("symlog", linthresh=0.3, linscale=0.8)
                limit(-9, 9)
            panel.set_xticks([-3, -1, 0, 1, 3], ["$-3$", "$-1$", "0", "1", "3"])
            panel.set_yticks([-3, -1, 0, 1, 3], ["$-3$", "$-1$", "0", "1", "3"])
            panel.minorticks_off()
            panel.set_title(f"{word} drive, {len(rows)} disks, $r$ = {pearson(rows[:, 0], rows[:, k]):.2f}"
                            if len(rows) else word, fontsize=9)
    for panel, text in zip(axes[:, 0], (r"$\Omega_0$ (neighbours do not turn)", r"$(1-G)^{-1}\Omega_0$")):
        panel.set_ylabel(r"$\Omega_i$ / rms")
        for one in (panel, axes[list(axes[:, 0]).index(panel), 1]):
            one.set_xlabel(text + " / rms")
            one.xaxis.set_tick_params(labelbottom=True)
    return Figure("alone-scatter", picture, f"Mean angular velocity of each disk at {drive:g} <i>g</i>, all disks turning, "
                  "against that which its cage alone gives (above), and against cage and gearing (below). Both over the "
                  "rms of the packing, logarithmic beyond 0.3; the line: equal.",
                  "Scatter plots of measured angular velocities against those of the cage alone and with gearing")
