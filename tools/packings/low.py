"""Low drive: every disk has a mean angular velocity of its own, which lasts."""
import numpy as np

from report.page import Figure, Numbers, Section
from report.style import COLOURS, GREY, figure, legend_above, zero_line
from report.verdict import SURE, decide, missing, number

from . import maps
from .drive import lasts
from .statistics import jackknife, mean_error, moments, pearson, pooled, spearman

PLAIN = {"low": "0.3 <i>g</i>", "moderate": "2 <i>g</i>"}
DECK = {"low": "shake_low.cfg", "moderate": "shake_moderate.cfg"}


def sections(campaign):
    return [persistence(campaign, name) for name in ("low", "moderate")]


def persistence(campaign, name):
    runs = [run for run in campaign.runs(name) if run.has_means]
    length = f"{runs[0].measured:.0f} s" if runs else "some hundred s"
    out = Section(name, f"{'Low' if name == 'low' else 'Moderate'} drive, {PLAIN[name]}: persistent rotation",
                  f"{len(runs)} packings of 60 disks (<code>inputs/packing/{DECK[name]}</code>), the floor harmonic "
                  f"at 80 Hz "
                  f"with peak acceleration {PLAIN[name]}, measured for {length} each after settling and a time to "
                  "thermalise. &Omega;<sub>i</sub> is the angle that a disk has turned by over the measured time. "
                  "Errors "
                  "of pooled numbers are from leaving out one packing at a time: packings are independent, disks "
                  "of one packing need not be.", missing=campaign.missing(name))
    if not runs:
        out.claims.append(missing("Mean angular velocities of the first and second half of the time agree."))
        return out
    groups = [run.halves() for run in runs]
    linear, order = jackknife(pooled(pearson), groups), jackknife(pooled(spearman), groups)
    out.figures.append(halves_figure(name, runs, groups, linear[0]))
    out.figures.append(distribution_figure(name, runs))
    out.figures.append(map_figure(name, runs[0]))
    out.claims += [persists(linear, order, groups), centred(runs), skewed(runs), significant(runs), counter(runs)]
    out.tables.append(Numbers(f"Each packing at {PLAIN[name]}",
                              ["seed", "mean &Omega; (rad/s)", "rms &Omega;", "median |&Omega;|", "beyond 3 errors",
                               "correlation of halves", "wander/diameter", "contacts per disk", "sliding fraction",
                               "openings per contact and period"],
                              [[str(run.seed), float(run.omega.mean()), run.rms, run.median, run.significant,
                                pearson(*run.halves()), run.wander, run.coordination, run.sliding_fraction,
                                run.openings_per_period(80)] for run in runs]))
    return out


def persists(linear, order, groups):
    # Against chance: the halves of one disk compared with the second half of another of the same packing.
    shifted = jackknife(pooled(pearson), [(a, np.roll(b, 1)) for a, b in groups])
    return decide("Each disk keeps its own mean angular velocity: those of the first and of the second half of the "
                  "time are "
                  "correlated.", lasts(linear),
                  f"Pearson {number(*linear)}, Spearman (ranks) {number(*order)}; with the next disk's second half "
                  f"instead "
                  f"{number(*shifted)}")


def centred(runs):
    mean, error = mean_error([run.omega.mean() for run in runs])
    ratio = abs(mean) / error
    return decide("The distribution of &Omega;<sub>i</sub> is centred at "
                  "zero.", ratio < SURE if np.isfinite(ratio) else None,
                  f"mean over packings {number(mean, error)} rad/s, {ratio:.1f} errors from zero; rms "
                  f"{number(*mean_error([run.rms for run in runs]))} rad/s")


def skewed(runs):
    value, error = jackknife(lambda groups: moments(np.concatenate(groups))[2], [run.omega / run.rms for run in runs])
    kurtosis = jackknife(lambda groups: moments(np.concatenate(groups))[3], [run.omega / run.rms for run in runs])
    return decide("It is symmetric: both senses of rotation are "
                  "alike.", abs(value) < SURE * error if error > 0 else None,
                  f"skewness {number(value, error)}, excess kurtosis {number(*kurtosis)} (0 for a Gaussian, 3 for a "
                  f"Laplace "
                  "distribution), each packing scaled by its rms")


def significant(runs):
    mean, error = mean_error([run.significant for run in runs])
    return decide("Many disks rotate significantly: their &Omega; is more than 3 of their errors from zero.",
                  mean > 0.1, f"{number(100 * mean, 100 * error)} % of the disks (0.3 % would by chance)")


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


def counter(runs):
    both = np.array([neighbour_correlation(run) for run in runs])
    (near, error), (every, other) = mean_error(both[:, 0]), mean_error(both[:, 1])
    opposite = mean_error([float(np.mean(run.omega[a] * run.omega[b] < 0)) for run in runs
                           for a, b, _ in [run.neighbours()] if len(a)])
    return decide("Disks in contact turn against each other, like "
                  "gears.", near + SURE * error < 0 if error > 0 else None,
                  "&lang;&Omega;<sub>i</sub>&Omega;<sub>j</sub>&rang;/&lang;&Omega;&sup2;&rang; over contacts "
                  f"{number(near, error)}, over all pairs {number(every, other)}; "
                  f"{number(100 * opposite[0], 100 * opposite[1])}"
                  " % of the contacts join disks that turn in opposite senses")


def halves_figure(name, runs, groups, correlation):
    picture, axes = figure(columns=2, height=3.2)
    scatter, zoom = axes
    first, second = (np.concatenate([g[k] for g in groups]) for k in range(2))
    rms = float(np.sqrt(np.mean(first ** 2)))
    for k, (a, b) in enumerate(groups):
        for panel in axes:
            panel.plot(a, b, "o", ms=3, mew=0.6, mfc="none", color=COLOURS[k % len(COLOURS)], zorder=3)
    top = 1.08 * max(np.abs(first).max(), np.abs(second).max())
    for panel, reach in ((scatter, top), (zoom, min(top, 1.0 * rms))):
        panel.plot([-reach, reach], [-reach, reach], color=GREY, lw=0.8, zorder=1, gid="guide")
        panel.set_xlim(-reach, reach)
        panel.set_ylim(-reach, reach)
        panel.set_aspect("equal")
        panel.set_xlabel(r"$\Omega_i$, first half (rad/s)")
        zero_line(panel)
    scatter.set_ylabel(r"$\Omega_i$, second half (rad/s)")
    scatter.set_title(f"all {len(first)} disks, $r$ = {correlation:.3f}")
    zoom.set_title("the same, up to one rms")
    return Figure(f"halves-{name}", picture, "Mean angular velocity of each disk in the second half of the measured "
                                             "time against "
                  "that in the first; a colour per packing; the line: equal.",
                  "Scatter plot of mean angular velocities in two halves of the runs")


def distribution_figure(name, runs):
    picture, axes = figure(height=3.9)
    scaled = np.concatenate([run.omega / run.rms for run in runs])
    edges = np.linspace(-5.25, 5.25, 22)
    count, _ = np.histogram(scaled, edges)
    width, middle = np.diff(edges), 0.5 * (edges[1:] + edges[:-1])
    parts = np.array([np.histogram(run.omega / run.rms, edges)[0] for run in runs])
    error = parts.std(0, ddof=1) * np.sqrt(len(runs)) if len(runs) > 1 else np.sqrt(count)
    norm = len(scaled) * width
    shown = count > 0
    low = np.minimum(error, 0.9 * count)  # a bar that does not leave the logarithmic axis
    axes.errorbar(middle[shown], (count / norm)[shown], yerr=[(low / norm)[shown], (error / norm)[shown]], fmt="o",
                  mfc="white", color=COLOURS[0], label=f"{len(scaled)} disks")
    x = np.linspace(-5.25, 5.25, 300)
    axes.plot(x, np.exp(-x * x / 2) / np.sqrt(2 * np.pi), color=GREY, lw=1, label="Gaussian", gid="guide")
    axes.plot(x, np.exp(-np.sqrt(2) * np.abs(x)) / np.sqrt(2), color=COLOURS[1], lw=1, ls="--", label="Laplace",
              gid="guide")
    axes.set_yscale("log")
    axes.set_xlim(-5.25, 5.25)
    axes.set_ylim(0.3 / norm.max(), 2)
    axes.set_xlabel(r"$\Omega_i$ / rms of the packing")
    axes.set_ylabel("probability density")
    legend_above(axes, 3)
    beyond = int(np.sum(np.abs(scaled) > 5.25))
    return Figure(f"distribution-{name}", picture, "Distribution of the mean angular velocities, each packing scaled "
                                                   "by its rms. "
                  "Bars: from the scatter of packings." + (f" {beyond} disks are beyond the axis." if beyond else ""),
                  "Distribution of mean angular velocities on a logarithmic scale")


def map_figure(name, run):
    picture, axes = figure(width=6.2, height=4.6)
    norm = maps.scale(run.omega)
    maps.rotation_map(axes, run, norm)
    maps.colour_bar(picture, axes, norm, r"$\Omega_i$ (rad/s)", shrink=0.85)
    return Figure(f"map-{name}", picture, "One packing at the end of its run. Colour: mean angular velocity, red "
                  "counter-clockwise, linear up to a tenth of the rms and logarithmic beyond. Lines: contacts between "
                  "disks, as wide as their normal forces.", "Map of a packing coloured by mean angular velocity")

