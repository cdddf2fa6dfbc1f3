"""Heap and angle of repose, discharge of a hopper, rotating drum."""
import dataclasses
import functools

import numpy as np

from ratchet.data import Table
from ratchet.page import Figure, Numbers, Section
from ratchet.style import BLACK, COLOURS, GREY, figure, plt, points
from ratchet.verdict import decide, missing, number, percent

from . import maps
from .statistics import line, mean_error

DEGREE = 180 / np.pi
STEADY = 0.05  # relative change of a rate that still counts as none
NARROW = 10  # widest outlet that enters Beverloo's law: a third of the width of the hopper


def sections(campaign):
    return [heap(campaign), hopper(campaign), drum(campaign)]


# --- heap ---------------------------------------------------------------------------------------------------
def surface(x, y, radius, width):
    """(centres, heights) of the highest point of the disks in bins of this width."""
    place = np.floor(x / width).astype(int)
    found = {}
    for k, top in zip(place, y + radius):
        found[k] = max(found.get(k, -np.inf), top)
    keys = np.array(sorted(found))
    return (keys + 0.5) * width, np.array([found[k] for k in keys])


def flanks(x, y, radius, part=(0.25, 0.85)):
    """Slopes of the two flanks of a heap, in degrees: lines through its surface between these parts of the way from the
    middle (of its mass) to its ends."""
    middle, width = float(np.average(x, weights=radius ** 2)), 2 * float(radius.mean())
    place, height = surface(x, y, radius, width)
    angles, lines = [], []
    for side in (-1, 1):
        reach = float(np.max(side * (x - middle)))
        way = side * (place - middle) / reach
        chosen = (way > part[0]) & (way < part[1])
        slope, _, offset, _ = line(place[chosen], height[chosen])
        angles.append(float(np.arctan(-side * slope)) * DEGREE)
        lines.append((place[chosen], slope * place[chosen] + offset))
    return angles, lines


def heap(campaign):
    runs = sorted(campaign.runs("repose"), key=lambda run: (run.parameters.get("mu", 0), run.parameters.get("r", 0)))
    out = Section("repose", "Heap and angle of repose",
                  "<code>inputs/packing/repose.cfg</code>: disks are poured on a row of fixed disks, what rolls off "
                  "its ends is taken "
                  "away, until the heap rests. The slope is that of a line through the surface of each flank (highest "
                  "point in "
                  "every mean diameter, from 25 to 85 % of the way to the foot). Error bars: scatter of flanks and "
                  "replicas.",
                  missing=campaign.missing("repose"))
    found = {}
    for row in campaign.numbers("repose-flanks", lambda: slopes(runs), "slopes of the flanks, degrees").rows:
        found.setdefault(row["mu"], []).append(((row["left"], row["right"]), row["disks"]))
    text = "The angle of repose grows with friction."
    if not found:
        out.claims.append(missing(text, slug="repose-friction"))
        return out
    mu = np.array(list(found))
    mean = np.array([mean_error(np.concatenate([angles for angles, _ in some])) for some in found.values()])
    rise = (mean[-1, 0] - mean[0, 0]) / np.hypot(mean[0, 1], mean[-1, 1]) if len(mu) > 1 else 0
    out.claims.append(decide(text, bool(rise > 0) if abs(rise) > 3 else None, "; ".join(
        f"&mu; = {m:g}: {number(*pair)}&deg;" for m, pair in zip(mu, mean)), slug="repose-friction"))
    out.tables.append(Numbers("Angle of repose", ["&mu;", "heaps", "angle (degrees)", "error", "disks in the heap "
        "(mean)"],
                              [[float(m), len(found[m]), *map(float, pair), float(np.mean([n for _, n in found[m]]))]
                               for m, pair in zip(mu, mean)]))
    picture, axes = figure(height=3.6)
    points(axes, mu, mean[:, 0], mean[:, 1], None, 0, "o")
    axes.set_xlabel(r"coefficient of friction $\mu$")
    axes.set_ylabel("angle of repose (degrees)")
    axes.set_ylim(0, None)
    out.figures.append(Figure("repose", picture, "Angle of repose against friction.", "Angle of repose against "
        "friction"))
    shown = min(runs, key=lambda run: abs(run.parameters["mu"] - 0.5))
    out.figures.append(heap_figure(shown.parameters["mu"],
                                   campaign.numbers("repose-disks", lambda: heap_disks(shown), "a heap, in mean "
                                                    "diameters"),
                                   campaign.numbers("repose-forces", lambda: heap_forces(shown), "its contacts")))
    return out


def slopes(runs):
    rows = []
    for run in runs:
        here = run.activity == 0
        (left, right), _ = flanks(run.x_end[here], run.y_end[here], run.radius[here])
        rows.append({"mu": run.parameters["mu"], "left": left, "right": right, "disks": int(here.sum())})
    return Table(rows)


def heap_disks(run):
    here = run.activity == 0
    return {"x": run.x_end[here], "y": run.y_end[here], "radius": run.radius[here]}


def heap_forces(run):
    ends, force = run.contact_lines()
    return {"x0": ends[:, 0, 0], "y0": ends[:, 0, 1], "x1": ends[:, 1, 0], "y1": ends[:, 1, 1], "force": force}


def heap_figure(mu, disks, forces):
    x, y, radius = disks.column("x"), disks.column("y"), disks.column("radius")
    picture, axes = figure(width=7.2, height=2.9)
    maps.disks(axes, x, y, radius, plt.get_cmap("Greys")(np.full(len(x), 0.15)), width=0.3)
    ends = np.stack([[forces.column(name) for name in pair] for pair in (("x0", "y0"),
                                                                         ("x1", "y1"))]).transpose(2, 0, 1)
    maps.contacts(axes, ends, forces.column("force"), 2.0, COLOURS[1])
    _, lines = flanks(x, y, radius)
    for ends in lines:
        axes.plot(*ends, color=COLOURS[0], lw=1.6, zorder=4)
    maps.frame(axes, x, y, radius)
    axes.set_xlabel("$x$ / mean diameter")
    axes.set_ylabel("$y$ / mean diameter")
    return Figure("heap", picture, f"Heap at &mu; = {mu:g}; contacts as wide as their "
                                   f"forces; blue: fitted "
                  "flanks.", "Picture of a heap with its contact forces and fitted flanks")


# --- hopper -------------------------------------------------------------------------------------------------
@dataclasses.dataclass
class Discharge:
    rate: float      # disks per time
    early: float     # the same in the first and second half of the window
    late: float
    time: np.ndarray = None
    out: np.ndarray = None


def discharge(run, part=(0.05, 0.45)):
    """Rate at which disks pass the outlet (y = 0), from when `part[0]` of them are out until `part[1]` are."""
    time, place = run.frames()
    out = np.sum(place[:, :run.n_free, 1] < 0, axis=1)
    begin = np.searchsorted(out, max(1, part[0] * run.n_free))
    end = np.searchsorted(out, part[1] * run.n_free)
    end = min(end, len(out) - 1)
    if end - begin < 6:
        return None
    middle = (begin + end) // 2
    parts = (slice(begin, end + 1), slice(begin, middle + 1), slice(middle, end + 1))
    slope = [line(time[part], out[part])[0] for part in parts]
    return Discharge(*slope, time, out)


def beverloo(width, rate, error, exponent=None):
    """W = C (D - k)^a by weighted least squares in logarithms: (a, its error, k, its error, C, chi^2, degrees).

    Errors where chi^2 has grown by 1, times sqrt(chi^2/degrees) where that is above 1."""
    width, rate = np.asarray(width, float), np.asarray(rate, float)
    relative = np.maximum(np.asarray(error, float) / rate, 1e-6)
    y = np.log(rate)
    grid = np.linspace(-1, width.min() - 0.05, 1500)
    best = []
    for k in grid:
        x = np.log(width - k)
        if exponent is None:
            weight = relative ** -2
            mean_x, mean_y = np.average(x, weights=weight), np.average(y, weights=weight)
            a = np.sum(weight * (x - mean_x) * (y - mean_y)) / np.sum(weight * (x - mean_x) ** 2)
        else:
            a = exponent
        offset = np.average(y - a * x, weights=relative ** -2)
        best.append((np.sum(((y - a * x - offset) / relative) ** 2), a, offset))
    chi2, a, offset = (np.array([b[m] for b in best]) for m in range(3))
    least = int(np.argmin(chi2))
    degrees = len(width) - (2 if exponent is not None else 3)
    stretch = max(1.0, chi2[least] / degrees) if degrees > 0 else 1.0
    near = chi2 <= chi2[least] + stretch
    return (float(a[least]), float(np.ptp(a[near]) / 2), float(grid[least]), float(np.ptp(grid[near]) / 2),
            float(np.exp(offset[least])), float(chi2[least]), degrees)


def hopper(campaign):
    out = Section("hopper", "Discharge of a hopper",
                  "<code>inputs/packing/hopper.cfg</code>, walls inclined by 45&deg;, lengths in mean diameters "
                  "<i>d</i>, <i>g</i> = 1. "
                  "The rate <i>W</i> is that of disks passing the outlet while 5 to 45 % of them leave. Outlets up "
                  "to a third of the width are fitted. Beverloo's "
                  "law in "
                  "two dimensions: <i>W</i> = <i>C</i> (<i>D</i> &minus; <i>k "
                  "d</i>)<sup>3/2</sup>.", missing=campaign.missing("hopper"))
    runs, found = campaign.runs("hopper"), {}
    flows = functools.cache(lambda: [(run.parameters["outlet"], flow) for run in runs
                                     for flow in [discharge(run)] if flow])
    for row in campaign.numbers("hopper-rates", lambda: Table(
            {"outlet": outlet, **{name: getattr(flow, name) for name in ("rate", "early", "late")}}
            for outlet, flow in flows()), "disks per time; the same in the first and second half of the window").rows:
        found.setdefault(row["outlet"], []).append(Discharge(row["rate"], row["early"], row["late"]))
    found = dict(sorted(found.items()))
    curves = campaign.numbers("hopper-curves", lambda: discharged(flows()), "disks that are out: mean and range of "
                              "runs")
    text = "The rate follows Beverloo's law with the exponent 3/2."
    if sum(size <= NARROW for size in found) < 4:
        out.claims.append(missing(text, slug="hopper-beverloo"))
        return out
    width = np.array(list(found))
    rate = np.array([mean_error([flow.rate for flow in some]) for some in found.values()])
    if np.isfinite(rate[:, 1]).any():
        scatter = np.nanmean(rate[:, 1] / rate[:, 0])
    else:  # single runs: their two halves tell how far a rate may be off
        scatter = np.mean([abs(flow.late - flow.early) / (2 * flow.rate) for some in found.values() for flow in some])
    error = np.maximum(np.nan_to_num(rate[:, 1]), scatter * rate[:, 0])  # few replicas: no error below the mean one
    narrow = width <= NARROW
    a, a_error, k, k_error, factor, chi2, degrees = beverloo(width[narrow], rate[narrow, 0], error[narrow])
    fixed = beverloo(width[narrow], rate[narrow, 0], error[narrow], 1.5)
    every = beverloo(width, rate[:, 0], error)
    out.claims.append(decide(text, bool(abs(a - 1.5) < 2 * a_error) if a_error < 0.15 else None,
                             f"free exponent {number(a, a_error)} with k = {number(k, k_error)} (&chi;&sup2; = "
                             f"{chi2:.1f} "
                             f"for {degrees} degrees of freedom); exponent 3/2: k = {number(fixed[2], fixed[3])}, C = "
                             f"{number(fixed[4])}, &chi;&sup2; = {fixed[5]:.1f} for {fixed[6]}. With all outlets, also "
                             f"those wider than a third of the hopper: exponent {number(every[0], every[1])}, k = "
                             f"{number(every[2], every[3])}", slug="hopper-beverloo"))
    change = [flow.late / flow.early - 1 for some in found.values() for flow in some]
    mean, spread = mean_error(change)
    steady = True if abs(mean) + spread < STEADY else False if abs(mean) - 2 * spread > STEADY else None
    out.claims.append(decide("The rate is constant: it does not depend on the height of the filling.", steady,
                             f"second half of the window against the first: {percent(mean)} &plusmn; "
                             f"{100 * spread:.1f} %, "
                             f"counted as constant up to {100 * STEADY:g} %", slug="hopper-steady"))
    out.tables.append(Numbers("Discharge", ["D/d", "runs", "rate (disks per sqrt(d/g))", "error", "late/early"],
                              [[float(d), len(found[d]), float(r[0]), float(r[1]),
                                float(np.mean([flow.late / flow.early for flow in found[d]]))]
                               for d, r in zip(width, rate)]))
    out.figures.append(hopper_figure(curves, width, rate[:, 0], error, (a, a_error, k, factor), fixed))
    return out


def discharged(flows):
    """Disks out against the time since opening, of each outlet."""
    parts = []
    for size in sorted({outlet for outlet, _ in flows}):
        some = [flow for outlet, flow in flows if outlet == size]
        clocks = [flow.time - flow.time[np.argmax(flow.out > 0)] for flow in some]
        clock = np.linspace(0, min(c[-1] for c in clocks), 100)
        out = np.array([np.interp(clock, c, flow.out) for c, flow in zip(clocks, some)])
        parts.append({"outlet": np.full(100, size), "time": clock, "mean": out.mean(axis=0), "least": out.min(axis=0),
                      "most": out.max(axis=0)})
    return {name: np.concatenate([part[name] for part in parts]) for name in parts[0]} if parts else None


def hopper_figure(curves, width, rate, error, free, fixed):
    picture, axes = figure(columns=2, height=3.2)
    sizes = curves.values("outlet")
    for colour, size in zip(plt.get_cmap("viridis")(np.linspace(0, 0.9, len(sizes))), sizes):
        clock, mean, least, most = map(curves.where(outlet=size).column, ("time", "mean", "least", "most"))
        axes[0].plot(clock, mean, color=colour, label=f"{size:g}")
        axes[0].fill_between(clock, least, most, color=colour, alpha=0.3, lw=0)
    axes[0].set_xlabel(r"time since opening / $\sqrt{d/g}$")
    axes[0].set_ylabel("disks out")
    axes[0].set_xlim(0, None)
    axes[0].legend(title="$D/d$", fontsize=8.5, loc="lower right", ncol=2)
    axes[1].errorbar(width, rate, yerr=error, fmt="o", mfc="white", color=BLACK, zorder=3)
    x = np.linspace(width.min() * 0.97, width.max() * 1.03, 200)
    axes[1].plot(x, fixed[4] * (x - fixed[2]) ** 1.5, color=COLOURS[1], label=f"$a$ = 3/2, $k$ = {fixed[2]:.2f}")
    axes[1].plot(x, free[3] * (x - free[2]) ** free[0], color=COLOURS[0], ls="--", label=f"$a$ = {free[0]:.2f} ± "
        f"{free[1]:.2f}")
    axes[1].set_xlabel("outlet $D/d$")
    axes[1].set_ylabel(r"rate $W$ ($\sqrt{g/d}$)")
    axes[1].legend(loc="upper left", fontsize=9)
    return Figure("hopper", picture, "Left: disks that are out against time, mean and range of the replicas. "
                                     "Right: rate against outlet with the fits "
                  "<i>W</i> = <i>C</i> (<i>D</i> &minus; <i>k d</i>)<sup><i>a</i></sup>.", "Discharge of a hopper "
                      "against time and outlet")


# --- drum ---------------------------------------------------------------------------------------------------
def drum(campaign):
    out = Section("drum", "Rotating drum",
                  "<code>inputs/packing/drum.cfg</code>: a rough drum of 40 mean diameters turns clockwise at a "
                  "Froude number of "
                  "10<sup>&minus;3</sup>. The angle is that of the line from the centre of the drum to the centre of "
                  "mass, against the "
                  "vertical: the slope of a straight surface. Its error is from ten blocks of "
                  "time.", missing=campaign.missing("drum"))
    runs = campaign.runs("drum")
    if not runs:
        out.claims.append(missing("The packing flows at a steady dynamic angle of repose.", slug="drum-steady"))
        return out
    run = runs[0]
    table = campaign.numbers("drum-angles", lambda: drum_angles(run), "angle of the packing and of its surface, "
                             "degrees")
    time, angles, slopes = (table.column(name) for name in ("time", "angle", "surface"))
    blocks = [b.mean() for b in np.array_split(angles, 10)]
    mean, error = mean_error(blocks)
    late_mean, late_error = mean_error(blocks[5:])
    early_mean, early_error = mean_error(blocks[:5])
    drift, drift_error = late_mean - early_mean, float(np.hypot(late_error, early_error))
    out.claims.append(decide("The packing flows at a steady dynamic angle of "
                             "repose.", bool(mean > 5 and abs(drift) < 3 * drift_error),
                             f"{number(mean, error)}&deg;, standard deviation in time {angles.std():.1f}&deg;; second "
                             f"half minus first half "
                             f"{number(drift, drift_error)}&deg;; median slope of the surface in the middle half "
                             f"{np.median(slopes):.1f}&deg;; {run.n_free} disks, {len(time)} frames in "
                             f"{run.measured:g} time units", slug="drum-steady"))
    out.figures.append(drum_figure(run, campaign.numbers("drum-velocities", lambda: drum_velocities(run),
                                                           "velocities at the end"), mean, time, angles))
    return out


def drum_angles(run):
    time, place = run.frames()
    late = time >= time[-1] - run.measured
    time, place = time[late], place[late][:, :run.n_free]
    middle = np.average(place, axis=1, weights=run.mass)
    return {"time": time, "angle": np.arctan2(-middle[:, 0], -middle[:, 1]) * DEGREE,
            "surface": [_slope(frame, run.radius) for frame in place]}


def drum_velocities(run):
    return dict(zip(("vx", "vy"), run.velocities().T))


def _slope(place, radius):
    """Slope of the surface in the middle half, in degrees; single flying disks spoil it."""
    middle = np.abs(place[:, 0]) < 0.25 * np.ptp(place[:, 0])
    at, height = surface(place[middle, 0], place[middle, 1], radius[middle], 2 * float(radius.mean()))
    return float(np.arctan(-line(at, height)[0])) * DEGREE


def drum_figure(run, velocities, mean, time, angles):
    picture, axes = figure(columns=2, width=7.2, height=3.7, gridspec_kw={"width_ratios": [1.25, 1]})
    velocity = np.column_stack([velocities.column("vx"), velocities.column("vy")])
    speed = np.hypot(*velocity.T)
    norm = plt.Normalize(0, float(np.quantile(speed, 0.98)))
    maps.disks(axes[0], run.x_end, run.y_end, run.radius, plt.get_cmap("viridis")(norm(speed)), width=0.2)
    step = np.hypot(*velocity.T) > 0
    axes[0].quiver(run.x_end[step], run.y_end[step], *velocity[step].T, color=BLACK, width=0.003, zorder=4,
                   scale=float(np.quantile(speed, 0.98)) * 18, scale_units="width")
    box = [(-21, 21), (-21, 21)]
    maps.walls(axes[0], run, box)
    axes[0].set_xlim(*box[0])
    axes[0].set_ylim(*box[1])
    axes[0].set_aspect("equal")
    axes[0].set_xlabel("$x/d$")
    axes[0].set_ylabel("$y/d$")
    maps.colour_bar(picture, axes[0], norm, r"speed ($\sqrt{gd}$)", location="bottom", shrink=0.8)
    axes[1].plot(time, angles, color=COLOURS[0], lw=0.7)
    axes[1].axhline(mean, color=GREY, lw=0.9, gid="guide")
    axes[1].set_xlabel(r"time / $\sqrt{d/g}$")
    axes[1].set_ylabel("angle of the packing (degrees)")
    return Figure("drum", picture, "Left: disks coloured by speed at the end, with velocities. Right: angle of the "
                                   "packing "
                  "against time.", "Rotating drum: velocities, and angle against time")
