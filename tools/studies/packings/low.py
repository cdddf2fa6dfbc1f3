"""Low and moderate drive: every disk has a mean angular velocity of its own, which lasts."""
import numpy as np

from ratchet.page import Figure, Numbers, Section
from ratchet.style import COLOURS, GREY, LIGHT, figure, legend_below, zero_line
from ratchet.verdict import MOTIONS, SURE, beside, decide, missing, number

from . import disks, maps
from .drive import lasts
from .memory import Powers
from .statistics import jackknife, mean_error, moments, pearson, pooled, spearman

PLAIN = {"low": "0.3 <i>g</i>", "moderate": "2 <i>g</i>"}
DRIVE = {"low": 0.3, "moderate": 2.0}
DECK = {"low": "shake_low.cfg", "moderate": "shake_moderate.cfg"}


def sections(campaign):
    return [persistence(campaign, name) for name in DRIVE]


def persistence(campaign, name):
    drive = DRIVE[name]
    sets = {MOTIONS[0]: disks.boxes(campaign, name, drive),
            MOTIONS[1]: disks.by_drive(disks.boxes(campaign, "random")).get(drive, [])}
    runs = {MOTIONS[0]: campaign.runs(name),
            MOTIONS[1]: [run for run in campaign.runs("random") if run.parameters.get("drive") == drive]}
    out = Section(name, f"{'Low' if name == 'low' else 'Moderate'} drive, {PLAIN[name]}: persistent rotation",
                  f"Packings of 60 disks, the floor harmonic at 80 Hz with peak acceleration {PLAIN[name]} "
                  f"(<code>inputs/packing/{DECK[name]}</code>, {length(sets[MOTIONS[0]])}), or at random with the same rms "
                  f"displacement (<code>shake_random.cfg</code>, {length(sets[MOTIONS[1]])}). &Omega;<sub>i</sub> is the angle "
                  f"that a disk has turned by over the measured time. {disks.RULE} They are left out but where they are marked. "
                  "Errors of pooled numbers are from leaving out one packing at a time: packings are independent, disks of one "
                  "packing need not be.", missing=campaign.missing(name, "random"))
    if not sets[MOTIONS[0]]:
        out.claims.append(missing("Mean angular velocities of the first and second half of the time agree.",
                                  slug=f"{name}-persists"))
        return out
    out.claims += beside(*(judged(name, found, [run for run in runs[motion] if run.has_means])
                           for motion, found in sets.items()))
    sets = {motion: found for motion, found in sets.items() if found}
    out.figures += [halves_figure(name, sets), distribution_figure(name, sets)]
    if runs[MOTIONS[0]]:
        out.figures.append(map_figure(name, runs[MOTIONS[0]][0]))
    out.tables.append(numbers_table(name, sets))
    return out


def length(found):
    return f"{found[0].whole['measured']:.0f} s, {len(found)} packings" if found else "not run"


def judged(name, found, runs):
    """The claims of one motion."""
    if not found:
        return []
    scaled = [box["omega"][box.held] / box.rms for box in found]
    return [persists(name, found), ranked(name, found), centred(name, found), *shape(name, scaled, turning_scaled(found)),
            deeper(name, found), *([counter(name, runs)] if runs else [])]


def numbers_table(name, sets):
    return Numbers(f"Each packing at {PLAIN[name]}",
                   ["motion", "seed", "rattlers", "mean &Omega; (rad/s)", "rms &Omega;", "median |&Omega;|", "median error",
                    "beyond 3 errors", "correlation of halves", "wander/diameter", "contacts per "
                                                                                   "disk", "sliding fraction",
                    "openings per contact and period"],
                   [[motion, str(box.whole["seed"]), float(np.sum(~box.held)), number(box["omega"][box.held].mean()),
                     *(number(value) for value in (
                         box.rms, box.median, box.noise, box.turns[box.held].mean(), pearson(*box.halves),
                         box.spread("rms"), box.whole["coordination"], box.whole["sliding"], box.openings))]
                    for motion, found in sets.items() for box in found])


def persists(name, found):
    # Against chance: the halves of one disk compared with the second half of another of the same packing.
    scaled = [tuple(half / box.rms for half in box.halves) for box in found]
    linear = jackknife(pooled(pearson), scaled)
    shifted = jackknife(pooled(pearson), [(a, np.roll(b, 1)) for a, b in scaled])
    plain = jackknife(pooled(pearson), [box.halves for box in found])
    return decide("Disks keep mean angular velocities of their own: those of the first and of the second half of the "
                  "time are correlated.", lasts(linear),
                  f"Pearson {number(*linear)} where each packing is scaled by its rms, {number(*plain)} without; with "
                  f"the next disk's second half instead {number(*shifted)}", slug=f"{name}-persists")


def ranked(name, found):
    """By ranks a disk counts the same however slow it is; then the same of those that turn only."""
    ranks = mean_error([spearman(*box.halves) for box in found])
    turning = mean_error([spearman(*(half[box.turns[box.held]] for half in box.halves)) for box in found])
    return decide("It does in ranks, too, where slow disks count as much as fast ones: a rank correlation above 0.5.",
                  lasts(ranks), f"Spearman, mean over packings: {number(*ranks)} of all disks, {number(*turning)} of "
                                f"those "
                  f"beyond {SURE:g} errors", slug=f"{name}-ranks")


def deeper(name, found):
    """Where the disks are that turn, and those that do not: heights in mean diameters, and how much of the time their
    contacts slide."""
    steps, sliding = [], {True: [], False: []}
    for box in found:
        parts = [box["height"][box.held & (box.turns == turn)] for turn in (True, False)]
        if min(map(len, parts)) >= 3:
            steps.append((parts[0].mean() - parts[1].mean()) / (2 * float(box["radius"].mean())))
        for turn in (True, False):
            chosen = box["sliding"][box.held & (box.turns == turn)]
            sliding[turn] += [float(chosen.mean())] if len(chosen) else []
    step, error = mean_error(steps)
    verdict = None if not error >= 0 else True if step > SURE * error else False if step < -SURE * error else None
    return decide("Disks that turn lie higher than those that do not.", verdict,
                  f"by {number(step, error)} mean diameters; contacts of those that turn slide for "
                  f"{number(*mean_error(sliding[True]))} of the time, of those that do not for "
                  f"{number(*mean_error(sliding[False]))}", slug=f"{name}-higher")


def centred(name, found):
    mean, error = mean_error([box["omega"][box.held].mean() for box in found])
    ratio = abs(mean) / error if error > 0 else np.nan
    return decide("The distribution of &Omega;<sub>i</sub> is centred at "
                  "zero.", ratio < SURE if np.isfinite(ratio) else None,
                  f"mean over packings {number(mean, error)} rad/s, {ratio:.1f} errors from zero; rms "
                  f"{number(*mean_error([box.rms for box in found]))} rad/s", slug=f"{name}-centred")


def turning_scaled(found):
    """Angular velocities of the disks beyond three errors of each packing, over their rms; no rattlers."""
    parts = [box["omega"][box.held & box.turns] for box in found]
    return [part / np.sqrt(np.mean(part ** 2)) for part in parts if len(part)]


def shape(name, scaled, turning):
    """Skewness and tails of the distribution; scaled: angular velocities of each packing over its rms, turning: those of
    turning_scaled, by which tails are judged: disks at rest alone make tails wide."""
    skewness, kurtosis = (jackknife(lambda groups, k=k: moments(np.concatenate(groups))[k], scaled) for k in (2, 3))
    even = abs(skewness[0]) < SURE * skewness[1] if skewness[1] > 0 else None
    excess, error = own = jackknife(lambda groups: moments(np.concatenate(groups))[3], turning)
    tails = None if not error > 0 else True if excess > SURE * error else False if excess < -SURE * error else None
    told = (f"excess kurtosis {number(*own)} of the {sum(map(len, turning))} disks beyond {SURE:g} errors, "
            f"{number(*kurtosis)} of all {sum(map(len, scaled))}, those at rest included: 0 for a Gaussian, 3 for a Laplace "
            f"distribution")
    return [decide("It is symmetric: both senses of rotation are alike.", even,
                   f"skewness {number(*skewness)}, each packing scaled by its rms", slug=f"{name}-symmetric"),
            decide("Of the disks that turn it has wider tails than a Gaussian, each packing scaled by its rms.", tails,
                   told, slug=f"{name}-tails")]


def neighbour_correlation(run):
    """<Omega_i Omega_j> over contacts, and over all pairs of disks, each over <Omega^2>."""
    a, b, _ = run.neighbours()
    omega = run.omega
    square = float(np.mean(omega ** 2))
    if len(a) == 0 or square == 0:
        return np.nan, np.nan
    n = len(omega)
    return (float(np.mean(omega[a] * omega[b]) / square),
            float((omega.sum() ** 2 - np.sum(omega ** 2)) / (n * (n - 1)) / square))


def counter(name, runs):
    both = np.array([neighbour_correlation(run) for run in runs])
    (near, error), (every, other) = mean_error(both[:, 0]), mean_error(both[:, 1])
    opposite = mean_error([float(np.mean(run.omega[a] * run.omega[b] < 0)) for run in runs
                           for a, b, _ in [run.neighbours()] if len(a)])
    return decide("Disks in contact turn against each other, like "
                  "gears.", near + SURE * error < 0 if error > 0 else None,
                  "&lang;&Omega;<sub>i</sub>&Omega;<sub>j</sub>&rang;/&lang;&Omega;&sup2;&rang; over contacts "
                  f"{number(near, error)}, over all pairs {number(every, other)}; "
                  f"{number(100 * opposite[0], 100 * opposite[1])}"
                  " % of the contacts join disks that turn in opposite senses", slug=f"{name}-gears")


def halves_figure(name, sets):
    picture, axes = figure(columns=len(sets), width=7.0, height=3.7, legend=True, squeeze=False)
    for panel, (motion, found) in zip(axes[0], sets.items()):
        rms = float(np.sqrt(np.mean(np.concatenate([box["omega_first"][box.held] for box in found]) ** 2)))
        top = 1.3 * max(np.abs(box[f"omega_{half}"]).max() for box in found for half in ("first", "second"))
        for k, box in enumerate(found):
            panel.plot(*box.halves, "o", ms=3, mew=0.6, mfc="none", color=COLOURS[k % len(COLOURS)], zorder=3)
            panel.plot(box["omega_first"][~box.held], box["omega_second"][~box.held], "x", ms=4, mew=0.8, color="black",
                       zorder=4)
        panel.plot([-top, top], [-top, top], color=GREY, lw=0.8, zorder=1, gid="guide")
        for scale, limit, axis in ((panel.set_xscale, panel.set_xlim, panel.xaxis),
                                   (panel.set_yscale, panel.set_ylim, panel.yaxis)):
            scale("symlog", linthresh=0.1 * rms, linscale=0.5)
            limit(-top, top)
            axis.set_major_locator(Powers(0.1 * rms, top))
            axis.set_minor_locator(Powers(np.inf, 0))
        panel.set_aspect("equal")
        panel.set_xlabel(r"$\Omega_i$, first half (rad/s)")
        panel.set_title(f"{motion} drive", fontsize=10)
        zero_line(panel)
    axes[0, 0].set_ylabel(r"$\Omega_i$, second half (rad/s)")
    axes[0, 0].plot([], [], "o", ms=3, mew=0.6, mfc="none", color=GREY, label="disks, a colour per packing")
    axes[0, 0].plot([], [], "x", ms=4, mew=0.8, color="black", label="rattlers")
    legend_below(picture, axes[0, 0], 2)
    return Figure(f"halves-{name}", picture, "Mean angular velocity of each disk in the second half of the measured time "
                  "against that in the first; logarithmic beyond a tenth of the rms; the line: equal.",
                  "Scatter plots of mean angular velocities in two halves of the runs, harmonic and random")


def distribution_figure(name, sets):
    """Disks beyond three errors as a density; those within, which a linear axis puts into one bin, as a fraction."""
    picture, axes = figure(columns=len(sets) + 1, width=7.4, height=3.5, legend=True,
                           gridspec_kw={"width_ratios": [3] * len(sets) + [1.6]})
    beyond = 0
    for k, (panel, (motion, found)) in enumerate(zip(axes, sets.items())):
        scaled = turning_scaled(found)
        beyond += density(panel, scaled, COLOURS[k])
        panel.set_title(f"{motion} drive", fontsize=10)
        count = sum(map(len, scaled)), sum(int(box.held.sum()) for box in found)
        axes[-1].bar(k, count[0] / max(count[1], 1), 0.6, color=COLOURS[k])
        axes[-1].bar(k, 1 - count[0] / max(count[1], 1), 0.6, count[0] / max(count[1], 1), color=LIGHT)
        axes[-1].text(k, 0.03, f"{count[0]} of {count[1]}", rotation=90, ha="center", va="bottom", fontsize=8, color="white")
    axes[0].set_ylabel("probability density")
    axes[-1].set_xticks(range(len(sets)), list(sets), rotation=30)
    axes[-1].minorticks_off()
    axes[-1].set_ylim(0, 1)
    axes[-1].set_ylabel(f"fraction beyond {SURE:g} errors")
    legend_below(picture, axes, 3)
    return Figure(f"distribution-{name}", picture, "Left and middle: distribution of the mean angular velocities of the disks "
                  f"beyond {SURE:g} errors, no rattlers, each packing scaled by the rms of these. Bars: from the scatter of "
                  f"packings, and no less than of independent disks. Right: how many disks are beyond {SURE:g} errors (full)."
                  + (f" {beyond} disks are beyond the axis." if beyond else ""),
                  "Distribution of mean angular velocities of turning disks, and the fractions that turn and rest")


def density(panel, scaled, colour):
    """Draws one; returns the number of disks beyond the axis."""
    every = np.concatenate(scaled) if scaled else np.zeros(0)
    edges = np.linspace(-5.25, 5.25, 22)
    parts = np.array([np.histogram(part, edges)[0] for part in scaled]).reshape(-1, len(edges) - 1)
    count, width, middle = parts.sum(0), np.diff(edges), 0.5 * (edges[1:] + edges[:-1])
    error = np.sqrt(np.maximum(count, 1.0))  # at least: a packing or two say little about their scatter
    if len(scaled) > 1:
        error = np.maximum(parts.std(0, ddof=1) * np.sqrt(len(scaled)), error)
    norm = max(len(every), 1) * width
    shown = count > 0
    low = np.minimum(error, 0.9 * count)  # a bar that does not leave the logarithmic axis
    panel.errorbar(middle[shown], (count / norm)[shown], yerr=[(low / norm)[shown], (error / norm)[shown]], fmt="o",
                   mfc="white", color=colour, label=f"disks beyond {SURE:g} errors")
    x = np.linspace(-5.25, 5.25, 300)
    panel.plot(x, np.exp(-x * x / 2) / np.sqrt(2 * np.pi), color=GREY, lw=1, label="Gaussian", gid="guide")
    panel.plot(x, np.exp(-np.sqrt(2) * np.abs(x)) / np.sqrt(2), color=COLOURS[3], lw=1, ls="--", label="Laplace",
               gid="guide")
    panel.set_yscale("log")
    panel.set_xlim(-5.25, 5.25)
    panel.set_ylim(0.3 / norm.max(), 5)
    panel.set_xlabel(r"$\Omega_i$ / rms of the turning disks", fontsize=10)
    return int(np.sum(np.abs(every) > 5.25))


def map_figure(name, run):
    picture, axes = figure(width=6.2, height=4.6)
    norm = maps.scale(run.omega)
    maps.rotation_map(axes, run, norm)
    maps.colour_bar(picture, axes, norm, r"$\Omega_i$ (rad/s)", shrink=0.85)
    return Figure(f"map-{name}", picture, "One packing at the end of its run. Colour: mean angular velocity, red "
                  "counter-clockwise, linear up to a tenth of the rms and logarithmic beyond. Lines: contacts between "
                  "disks, as wide as their normal forces.", "Map of a packing coloured by mean angular velocity")

