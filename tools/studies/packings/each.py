"""Does each disk of a packing turn, or do only many?"""
import numpy as np

from ratchet.page import Figure, Numbers, Section
from ratchet.style import COLOURS, GREY, LIGHT, figure, legend_above
from ratchet.verdict import MOTIONS, SURE, beside, decide, missing, number

from .disks import CHANCE, HELD, LIMIT, MANY, OPEN, RULE, boxes, of_motions
from .statistics import jackknife, mean_error, pearson, pooled, share, spearman

TIGHT = 0.01     # of the packing's rms: an upper limit on |Omega| below it shows that a disk stands still
SIZEABLE = 0.05  # so many disks that stand still refute "each"
ALIKE = 0.5      # the smaller of both halves over the larger, from which on a rotation is the same in both

# Kinds of disks, in the order in which they are asked for.
TURNS, STICKS, SLIDES, UNSEEN = "turns", "sticks", "slides", "unseen"
KINDS = {TURNS: f"turns: beyond {SURE:g} errors", SLIDES: "slides without turning",
         STICKS: "never slides", UNSEEN: "undecided"}


def limits(box):
    """Upper limits of 95 % on |Omega| of each disk."""
    return np.abs(box["omega"]) + LIMIT * box["error"]


def kind_of(box):
    """What each disk does: turns; never slides; stands still although it slides; or its error bar is too large."""
    still = limits(box) < TIGHT * box.rms
    return np.select([box.turns, box["friction"] == 0, still], [TURNS, STICKS, SLIDES], UNSEEN)


def part(found, kind, least=HELD):
    """(share, error) of the disks with at least so many persistent contacts that are of this kind."""
    groups = []
    for box in found:
        chosen = box["persistent"] >= least
        groups.append((int(np.sum(kind_of(box)[chosen] == kind)), int(chosen.sum())))
    return share(groups)


def alike(box):
    """Which disks turn in the same sense in both halves, in one at least half as fast as in the other."""
    a, b = box["omega_first"], box["omega_second"]
    return (a * b > 0) & (np.minimum(np.abs(a), np.abs(b)) >= ALIKE * np.maximum(np.abs(a), np.abs(b)))


def lasting(found):
    """(share, error) of the turning disks that turn in the same sense in both halves, in one at least half as fast."""
    turning = [box.held & box.turns for box in found]
    return share([(int(np.sum(alike(box) & part)), int(part.sum())) for box, part in zip(found, turning)])


def excess(found):
    """(share, error) of the disks within three errors beyond what a smooth distribution has there, which is half of
    those between three and nine errors. A distribution with a peak at zero has more, so this is an upper bound."""
    groups = []
    for box in found:
        ratio = np.abs(box["omega"][box.held]) / np.maximum(box["error"][box.held], 1e-300)
        groups.append((np.sum(ratio < SURE), np.sum((ratio >= SURE) & (ratio < 3 * SURE)), len(ratio)))
    total = np.sum(groups, axis=0) if groups else np.zeros(3)
    if not total[2]:
        return np.nan, np.nan
    value, error = jackknife(lambda part: (lambda t: (t[0] - 0.5 * t[1]) / max(t[2], 1))(np.sum(part, axis=0)), groups)
    independent = np.sqrt(max(total[0], 1) + 0.25 * max(total[1], 1)) / total[2]
    return float(value), float(np.nanmax([error, independent]))


def census(found):
    """Shares of the kinds among disks that are no rattlers, and what else the verdict says, as (value, error)."""
    still = [limits(box)[box.held & np.isin(kind_of(box), (STICKS, SLIDES))] / box.rms for box in found]
    still = np.concatenate(still) if still else np.array([])
    return {**{kind: part(found, kind) for kind in KINDS}, "disks": int(sum(box.held.sum() for box in found)),
            "loose": share([(int((~box.held).sum()), len(box["omega"])) for box in found]),
            "still": share([(int(np.isin(kind_of(box)[box.held], (STICKS, SLIDES)).sum()), int(box.held.sum()))
                            for box in found]),
            "excess": excess(found),
            "caged": part(found, TURNS, 3), "limit": float(np.median(still)) if len(still) else np.nan,
            "lasting": lasting(found)}


def each(counts):
    """True: all but a few turn, chance taken off, or those within their errors are no more than a smooth distribution
    has there; False: a sizeable part stands still; None: undecided."""
    turning, error = counts[TURNS]
    turning = (turning - CHANCE) / (1 - CHANCE)
    if turning - SURE * error > 1 - SIZEABLE:
        return True
    more, spread = counts["excess"]
    if more + SURE * spread < SIZEABLE:
        return True
    still, error = counts["still"]
    return False if still - SURE * error > SIZEABLE else None


def percent(value):
    return f"{number(100 * value[0], 100 * value[1])} %"


def words(counts):
    turning = (counts[TURNS][0] - CHANCE) / (1 - CHANCE)
    told = (f"{percent(counts[TURNS])} of {counts['disks']} disks are beyond {SURE:g} errors "
            f"({100 * max(turning, 0):.0f} % without those that may be so by chance); {percent(counts['still'])} stand "
            f"still ({percent(counts[STICKS])} never slide)")
    if np.isfinite(counts["limit"]):
        told += f", to {number(counts['limit'], digits=2)} of the rms (limit of 95 %, median)"
    return (told + f"; within {SURE:g} errors there are {percent(counts['excess'])} of the disks more than a smooth "
            "distribution has there")


def claim(found, drive, slug, where=""):
    """The claim of the follow-up, of all packings at one drive."""
    counts = census(found)
    if not counts["disks"]:
        return missing(f"At {where or f'{drive:g} <i>g</i>'} each disk turns.", slug=slug)
    return decide(f"At {where or f'{drive:g} <i>g</i>'} each disk turns.",
                  each(counts), words(counts), slug=slug)


# --- the section ----------------------------------------------------------------------------------------------------
def sections(campaign):
    harmonic, random = of_motions(campaign).values()
    long = {"low": boxes(campaign, "low", 0.3), "moderate": boxes(campaign, "moderate", 2.0)}
    out = Section("each", "Does each disk turn?",
                  "The claim is that <i>each</i> disk of a vibrated packing has a mean angular velocity that is not "
                  f"zero. A disk <i>turns</i> when |&Omega;| is beyond {SURE:g} of its errors; it <i>stands still</i> "
                  "when it is not, and the upper limit of 95 % on |&Omega;| is below a hundredth of the rms of its "
                  "packing. Of those the ones whose friction has done no work at all while measured "
                  f"<i>never slide</i>. {RULE} They are left out. The claim is refuted when "
                  f"more than {100 * SIZEABLE:.0f} % of the disks stand still. It is met when fewer than that do not "
                  f"turn, or "
                  f"when those within {SURE:g} errors are no more, up to as many, than a smooth distribution of "
                  f"&Omega; would "
                  f"put there by chance: half of those between {SURE:g} and {3 * SURE:g} errors, so that nothing "
                  f"points to "
                  f"disks that stand still. All by {SURE:g} errors, which are from leaving out packings.",
                  missing=campaign.missing("drive", "random"))
    lists = [{(drive, ""): found for drive, found in table.items()} for table in (harmonic, random)]
    lists[0].update({(found[0].drive, name): found for name, found in long.items() if found})
    if not lists[0]:
        out.claims.append(missing("Each disk turns.", slug="each-disk"))
        return [out]
    out.claims += beside(*map(regimes, (harmonic, random)))
    out.claims += beside(*([claim(found, drive, f"each-disk-{name or f'{drive:g}'}", f"{drive:g} <i>g</i> "
                                  f"({found[0].whole['measured']:.0f} s, {len(found)} packings)")
                            for (drive, name), found in sorted(some.items())] for some in lists))
    picked = {f"{drive:g} $g$": harmonic[drive] for drive in (0.1, 0.3, 1.0, 2.0, 9.0) if drive in harmonic}
    picked = picked or {f"{found[0].drive:g} $g$": found for found in long.values() if found}
    out.figures.append(sizes_figure(picked, "each-sizes"))
    out.tables.append(numbers_table([(f"{drive:g} <i>g</i>, {motion}{', ' + name if name else ''}", found)
                                     for motion, some in zip(MOTIONS, lists) for (drive, name), found in sorted(some.items())]))
    return [out]


def regimes(table):
    """The claim for all drives of a regime together: contacts hardly open, or open in each period."""
    rate = {drive: np.mean([box.openings for box in found]) for drive, found in table.items()}
    made = []
    for slug, chosen, what in (("sliding", [d for d in rate if rate[d] < OPEN],
                                f"Where contacts hardly open, less than {OPEN:g} times in a period"),
                               ("bouncing", [d for d in rate if rate[d] >= MANY],
                                "Where each contact opens once in a period or more")):
        text = f"{what}, each disk turns."
        counts = census([box for drive in chosen for box in table[drive]])
        made.append(decide(text, each(counts), f"at {', '.join(f'{d:g}' for d in chosen)} <i>g</i>: {words(counts)}",
                           slug=f"each-disk-{slug}") if counts["disks"]
                    else missing(text, why="no such drive", slug=f"each-disk-{slug}"))
    return made


def numbers_table(rows):
    names = (TURNS, SLIDES, STICKS, UNSEEN, "loose", "lasting", "caged")
    made = []
    for label, found in rows:
        counts = census(found)
        ratio = mean_error([box.median / box.rms for box in found if box.rms > 0])
        made.append([label, len(found), float(found[0].whole["measured"]),
                     *(number(100 * counts[name][0], 100 * counts[name][1]) for name in names), number(*ratio)])
    return Numbers("What the disks do, in per cent of those that are no rattlers",
                   ["drive", "packings", "measured (s)", "turn", "slide, stand still", "never slide", "undecided",
                    "rattlers (of all)", "same in both halves (of those that turn)", "turn, with three contacts or "
                                                                                     "more",
                    "median/rms of |&Omega;|"], made)


def shares_panel(axes, table, label):
    """Stacked bars: which fraction of the disks does what, at each drive."""
    places, under = np.arange(len(table)), np.zeros(len(table))
    colours = dict(zip(KINDS, (COLOURS[0], COLOURS[1], COLOURS[4], LIGHT)))
    for kind, text in KINDS.items():
        values = np.array([part(found, kind) for found in table.values()]).reshape(-1, 2)
        axes.bar(places, values[:, 0], 0.72, under, color=colours[kind], label=text, edgecolor="white", lw=0.5)
        if kind == TURNS:
            axes.errorbar(places, values[:, 0], yerr=np.nan_to_num(values[:, 1]), fmt="none", ecolor="black", lw=1)
        under = under + np.nan_to_num(values[:, 0])
    axes.axhline(CHANCE, color="black", lw=0.8, ls=":", gid="guide")
    axes.set_xticks(places, [f"{drive:g}" for drive in table])
    axes.minorticks_off()
    axes.set_ylim(0, 1)
    axes.set_xlabel(label)


def sizes_figure(picked, name):
    """Fraction of the disks with |Omega|/rms above x, and what could have been seen."""
    picture, axes = figure(height=3.8)
    for k, (label, found) in enumerate(picked.items()):
        sizes = np.sort(np.concatenate([np.abs(box["omega"][box.held]) / box.rms for box in found]))[::-1]
        noise = np.sort(np.concatenate([SURE * box["error"][box.held] / box.rms for box in found]))[::-1]
        rank = np.arange(1, len(sizes) + 1) / len(sizes)
        colour = COLOURS[k % len(COLOURS)]
        axes.step(np.maximum(sizes, 1e-9), rank, color=colour, lw=1.4, label=label, where="post")
        axes.plot(np.maximum(noise, 1e-9), rank, color=colour, lw=0.9, ls=":")
    axes.plot([], [], color=GREY, lw=0.9, ls=":", label=f"{SURE:g} errors")
    axes.set_xscale("log")
    axes.set_xlim(1e-7, 10)
    axes.set_ylim(0, 1.02)
    axes.set_xlabel(r"$x$")
    axes.set_ylabel(r"fraction of the disks with $|\Omega_i|$/rms $> x$")
    legend_above(axes, 6)
    return Figure(name, picture, "How large the mean angular velocities are, harmonic drive, over the rms of their packing: the "
                  f"fraction of the disks (no rattlers) above <i>x</i>. Dotted: the same for {SURE:g} error bars, below which "
                  "nothing is seen. Where the line bends over and goes on at a level, disks are of two kinds: some turn, others "
                  "do not.",
                  "Cumulative distribution of absolute mean angular velocities over the rms")


def consistency(found):
    """(Spearman within packings, Pearson scaled by the rms of each packing) of both halves, with errors."""
    ranks = mean_error([spearman(*box.halves) for box in found])
    scaled = [tuple(half / box.rms for half in box.halves) for box in found if box.rms > 0]
    return ranks, jackknife(pooled(pearson), scaled)
