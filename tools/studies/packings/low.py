"""Low and moderate drive: every disk has a mean angular velocity of its own, which lasts."""
import dataclasses

import numpy as np

from ratchet.page import Figure, Numbers, Section
from ratchet.style import COLOURS, GREY, LIGHT, figure, legend_below, zero_line
from ratchet.verdict import SURE, decide, missing, number

from . import disks, maps
from .drive import lasts, random_floor
from .statistics import jackknife, mean_error, moments, pearson, pooled, spearman

PLAIN = {"low": "0.3 <i>g</i>", "moderate": "2 <i>g</i>"}
DRIVE = {"low": 0.3, "moderate": 2.0}
DECK = {"low": "shake_low.cfg", "moderate": "shake_moderate.cfg"}


def sections(campaign):
    return [*(persistence(campaign, name) for name in ("low", "moderate")), random_floor(campaign, random_claims(campaign))]


def random_claims(campaign):
    """The same statements under random drive, at each drive of the entry `random`: {drive: claims}."""
    runs = [run for run in campaign.runs("random") if run.has_means]
    made = {}
    for drive, found in disks.by_drive(disks.boxes(campaign, "random")).items():
        scaled = [box["omega"][box.held] / box.rms for box in found]
        some = [run for run in runs if run.parameters["drive"] == drive]
        claims = [persists("random", found), ranked("random", found), centred("random", found),
                  *shape("random", scaled, turning_scaled(found)), deeper("random", found), counter("random", some)]
        made[drive] = [dataclasses.replace(claim, text=f"At {drive:g} <i>g</i>: {claim.text[0].lower()}{claim.text[1:]}",
                                           slug=f"{claim.slug}-{drive:g}g") for claim in claims]
    return made


def persistence(campaign, name):
    found = disks.boxes(campaign, name, DRIVE[name])
    runs = [run for run in campaign.runs(name) if run.has_means]
    length = f"{found[0].whole['measured']:.0f} s" if found else "some hundred s"
    out = Section(name, f"{'Low' if name == 'low' else 'Moderate'} drive, {PLAIN[name]}, harmonic: persistent rotation",
                  f"{len(found)} packings of 60 disks (<code>inputs/packing/{DECK[name]}</code>), the floor harmonic "
                  f"at 80 Hz "
                  f"with peak acceleration {PLAIN[name]}, measured for {length} each after settling and a time to "
                  "thermalise. &Omega;<sub>i</sub> is the angle that a disk has turned by over the measured time. "
                  f"{disks.RULE} They are left out but where they are marked. Errors of pooled numbers are from "
                  f"leaving out "
                  "one packing at a time: packings are independent, disks of one packing need not be.",
                  missing=campaign.missing(name))
    if not found:
        out.claims.append(missing("Mean angular velocities of the first and second half of the time agree.",
                                  slug=f"{name}-persists"))
        return out
    scaled = [box["omega"][box.held] / box.rms for box in found]
    turning = turning_scaled(found)
    out.figures += [halves_figure(name, found), distribution_figure(name, found)]
    out.claims += [persists(name, found), ranked(name, found), centred(name, found), *shape(name, scaled, turning),
                   deeper(name, found)]
    if runs:
        out.figures.append(map_figure(name, runs[0]))
        out.claims.append(counter(name, runs))
    out.tables.append(numbers_table(name, found))
    return out


def numbers_table(name, found):
    return Numbers(f"Each packing at {PLAIN[name]}",
                   ["seed", "rattlers", "mean &Omega; (rad/s)", "rms &Omega;", "median |&Omega;|", "median error",
                    "beyond 3 errors", "correlation of halves", "wander/diameter", "contacts per "
                                                                                   "disk", "sliding fraction",
                    "openings per contact and period"],
                   [[str(box.whole["seed"]), float(np.sum(~box.held)), number(box["omega"][box.held].mean()),
                     *(number(value) for value in (
                         box.rms, box.median, box.noise, box.turns[box.held].mean(), pearson(*box.halves),
                         box.spread("rms"), box.whole["coordination"], box.whole["sliding"], box.openings))]
                    for box in found])


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


def halves_figure(name, found):
    picture, axes = figure(columns=2, height=3.3, legend=True)
    scatter, zoom = axes
    first, second = (np.concatenate([box[f"omega_{half}"] for box in found]) for half in ("first", "second"))
    rms = float(np.sqrt(np.mean(first ** 2)))
    for k, box in enumerate(found):
        for panel in axes:
            panel.plot(*box.halves, "o", ms=3, mew=0.6, mfc="none", color=COLOURS[k % len(COLOURS)], zorder=3)
            panel.plot(box["omega_first"][~box.held], box["omega_second"][~box.held], "x", ms=4, mew=0.8, color="black",
                       zorder=4)
    scatter.plot([], [], "o", ms=3, mew=0.6, mfc="none", color=GREY, label="disks, a colour per packing")
    scatter.plot([], [], "x", ms=4, mew=0.8, color="black", label="rattlers")
    top = 1.08 * max(np.abs(first).max(), np.abs(second).max())
    for panel, reach in ((scatter, top), (zoom, min(top, 1.0 * rms))):
        panel.plot([-reach, reach], [-reach, reach], color=GREY, lw=0.8, zorder=1, gid="guide")
        panel.set_xlim(-reach, reach)
        panel.set_ylim(-reach, reach)
        panel.set_aspect("equal")
        panel.set_xlabel(r"$\Omega_i$, first half (rad/s)")
        zero_line(panel)
    scatter.set_ylabel(r"$\Omega_i$, second half (rad/s)")
    scatter.set_title(f"all {len(first)} disks")
    zoom.set_title("the same, up to one rms")
    legend_below(picture, scatter, 2)
    rattlers = int(sum((~box.held).sum() for box in found))
    return Figure(f"halves-{name}", picture, "Mean angular velocity of each disk in the second half of the measured "
                                             "time "
                  f"against that in the first; a colour per packing; crosses: the {rattlers} rattlers; the line: "
                  f"equal.",
                  "Scatter plot of mean angular velocities in two halves of the runs")


def distribution_figure(name, found):
    """Disks beyond three errors as a density; those within, which a linear axis puts into one bin, as a fraction."""
    scaled = turning_scaled(found)
    resting = sum(int((box.held & ~box.turns).sum()) for box in found)
    picture, axes = figure(columns=2, width=7.0, height=3.5, legend=True, gridspec_kw={"width_ratios": [3, 1]})
    every = np.concatenate(scaled)
    edges = np.linspace(-5.25, 5.25, 22)
    parts = np.array([np.histogram(part, edges)[0] for part in scaled])
    count, width, middle = parts.sum(0), np.diff(edges), 0.5 * (edges[1:] + edges[:-1])
    error = np.sqrt(np.maximum(count, 1.0))  # at least: a packing or two say little about their scatter
    if len(scaled) > 1:
        error = np.maximum(parts.std(0, ddof=1) * np.sqrt(len(scaled)), error)
    norm = len(every) * width
    shown = count > 0
    low = np.minimum(error, 0.9 * count)  # a bar that does not leave the logarithmic axis
    axes[0].errorbar(middle[shown], (count / norm)[shown], yerr=[(low / norm)[shown], (error / norm)[shown]], fmt="o",
                     mfc="white", color=COLOURS[0], label=f"{len(every)} disks beyond {SURE:g} errors")
    x = np.linspace(-5.25, 5.25, 300)
    axes[0].plot(x, np.exp(-x * x / 2) / np.sqrt(2 * np.pi), color=GREY, lw=1, label="Gaussian", gid="guide")
    axes[0].plot(x, np.exp(-np.sqrt(2) * np.abs(x)) / np.sqrt(2), color=COLOURS[1], lw=1, ls="--", label="Laplace",
                 gid="guide")
    axes[0].set_yscale("log")
    axes[0].set_xlim(-5.25, 5.25)
    axes[0].set_ylim(0.3 / norm.max(), 5)
    axes[0].set_xlabel(r"$\Omega_i$ / rms of the turning disks of the packing")
    axes[0].set_ylabel("probability density")
    total = max(len(every) + resting, 1)
    axes[1].bar([0, 1], [len(every) / total, resting / total], 0.6, color=[COLOURS[0], LIGHT])
    axes[1].set_xticks([0, 1], [f"beyond\n{SURE:g} errors\n({len(every)})", f"within\n({resting})"])
    axes[1].minorticks_off()
    axes[1].set_ylim(0, 1)
    axes[1].set_ylabel("fraction of the disks")
    legend_below(picture, axes, 3)
    beyond = int(np.sum(np.abs(every) > 5.25))
    return Figure(f"distribution-{name}", picture, "Left: distribution of the mean angular velocities of the disks beyond "
                  f"{SURE:g} errors, no rattlers, each packing scaled by the rms of these. Bars: from the scatter of "
                  "packings, and no less than of independent disks. Right: how many these are, and how many are within "
                  f"{SURE:g} errors." + (f" {beyond} disks are beyond the axis." if beyond else ""),
                  "Distribution of mean angular velocities of turning disks, and the fractions that turn and rest")


def map_figure(name, run):
    picture, axes = figure(width=6.2, height=4.6)
    norm = maps.scale(run.omega)
    maps.rotation_map(axes, run, norm)
    maps.colour_bar(picture, axes, norm, r"$\Omega_i$ (rad/s)", shrink=0.85)
    return Figure(f"map-{name}", picture, "One packing at the end of its run. Colour: mean angular velocity, red "
                  "counter-clockwise, linear up to a tenth of the rms and logarithmic beyond. Lines: contacts between "
                  "disks, as wide as their normal forces.", "Map of a packing coloured by mean angular velocity")

