"""Pictures of what changes in time: rotation, sliding, energies, compression, stress, single contacts, paths."""
from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from . import library as lib
from . import plot_style as style
from .arguments import checked
from .plot_source import Source, lacks_shear, stresses
from .plot_style import axes_of, guide, label
from .plot_theory import theory_of

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from .plot_source import Drawable

CONFIGURATIONS = {"pp": "$S^{++}$", "pm": "$S^{+-}$", "mp": "$S^{-+}$", "mm": "$S^{--}$", "stick": "stick", "open": "open"}
MODES = {1: "tension", 2: "shear", 3: "bending"}


def within(times, span):
    """Which of these times are in span = (from, to), either None."""
    low, high = span or (None, None)
    keep = np.ones(len(times), bool)
    if low is not None:
        keep &= times >= low
    if high is not None:
        keep &= times <= high
    return keep


def mark_phases(ax, source, span=None, place=lambda time: time):
    """A thin line where a phase ends, with the names of phases above, when there are few. place: of a time on the axis of x."""
    phases = [phase for phase in source.phases if within(np.array([phase[2]]), (span or (None, None))[:1] + (None,))[0]]
    if len(phases) < 2:
        return
    low, high = ax.get_xlim()
    for name, *ends in phases:
        begin, end = map(place, ends)
        if low < begin < high:
            guide(ax, x=begin)
        begin, end = max(begin, low), min(end, high)
        if len(phases) <= 4 and end - begin > 0.02 * max(len(name), 3) * (high - low):
            ax.yaxis.get_offset_text().set(x=-0.01, ha="right")  # the names have the place of the power of ten
            ax.text((begin + end) / 2, 1.01, name, transform=ax.get_xaxis_transform(), ha="center", va="bottom", fontsize=7.5,
                    color=style.ink(), alpha=0.65)


def time_axis(ax, source, time, span, phases=True):
    if len(time) > 1:
        low, high = (given if given is not None else end for given, end in zip(span or (None, None), (time[0], time[-1])))
        if high > low:
            ax.set_xlim(low, high)
    ax.set_xlabel(label("$t$", "time"))
    if phases:
        mark_phases(ax, source, span)


# --- rotation -------------------------------------------------------------------------------------------------------
@checked
def rotation(result: Drawable, ax: Axes | None = None, *, time: Sequence[float | None] | None = None, windows: lib.Count = 50) -> Axes:
    """Mean angular velocity of the watched disks: means over windows of time (thin), the mean up to t (thick), and the mean of
    the run with its error band (one standard error)."""
    source, ax = Source.of(result), axes_of(ax)
    t, angles, names = source.series["time"], source.series["angle"], source.rotation
    start = source.result.time - max(float(row["measured"]) for row in names)
    keep = within(t, time or (start - 1e-9 * abs(start), None))
    t, angles = t[keep], angles[keep]
    theory = theory_of(source) if len(names) == 1 else None
    for k, row in enumerate(names):
        colour = style.colour(k)
        cuts = np.unique(np.linspace(0, len(t) - 1, min(windows, len(t) - 1) + 1).astype(int))
        means = np.diff(angles[cuts, k]) / np.diff(t[cuts])
        ax.stairs(means, t[cuts], baseline=None, color=colour, lw=0.8, alpha=0.55,
                  label=f"mean of a {'window' if len(names) == 1 else 'window: ' + source.disk_name(row['disk'])}")
        begin = source.result.time - row["measured"] + row["transient"]
        after = t > begin
        if after.sum() > 2:
            first = max(int(np.argmax(after)) - 1, 0)
            run = (angles[first + 1:, k] - angles[first, k]) / (t[first + 1:] - t[first])
            ax.plot(*style.thinned(t[first + 1:], run), color=colour, lw=1.6, label="mean up to $t$")
        value, error = float(row["omega"]), float(row["error"])
        band = np.isfinite(error)
        text = rf"$\Omega$ = {style.number(value, error if band else None)}"
        text += "" if row["converged"] else " (error bar not reliable)" if band else " (no error bar)"
        ax.plot([begin, t[-1]], [value, value], color=style.ink(), lw=1.0, ls="--", gid=f"omega {k}", label=text)
        if band:
            ax.fill_between([begin, t[-1]], value - error, value + error, color=style.ink(), alpha=0.18, lw=0, gid=f"band {k}")
        spread = np.concatenate([means[t[cuts[:-1]] >= begin], [value]])
        _frame(ax, spread[np.isfinite(spread)], k)
    if theory and np.isfinite(theory["mean"]):
        ax.axhline(theory["mean"], color="#CC79A7", lw=1.0, ls=":", label=rf"theory: {style.number(theory['mean'])}", gid="theory")
        _frame(ax, np.array([theory["mean"]]), 1)
    guide(ax, y=0)
    time_axis(ax, source, t, time)
    ax.set_ylabel(label(r"mean angular velocity $\Omega$", source.series.unit("angular_velocity")))
    style.legend(ax, loc="best", ncol=1)
    return ax


def _frame(ax, values, k):
    """Limits that hold these and, from the second call on, what was there."""
    low, high = min(values.min(), 0.0), max(values.max(), 0.0)
    if k:
        low, high = min(low, ax.get_ylim()[0]), max(high, ax.get_ylim()[1])
    rim = 0.06 * (high - low or 1.0) if not k else 0.0
    ax.set_ylim(low - rim, high + rim)


@checked
def spin(result: Drawable, ax: Axes | None = None, *, time: Sequence[float | None] | None = None) -> Axes:
    """Angular velocity of the watched disks at each row of the series."""
    source, ax = Source.of(result), axes_of(ax)
    t, omega = source.series["time"], source.series["angular_velocity"]
    keep = within(t, time)
    for k, row in enumerate(source.rotation):
        ax.plot(*style.thinned(t[keep], omega[keep, k]), color=style.colour(k), lw=0.7, label=source.disk_name(row["disk"]))
    guide(ax, y=0)
    time_axis(ax, source, t[keep], time)
    ax.set_ylabel(label(r"spin $\omega$", source.series.unit("angular_velocity")))
    if len(source.rotation) > 1:
        style.legend(ax, loc="best", ncol=min(len(source.rotation), 4))
    return ax


# --- sliding --------------------------------------------------------------------------------------------------------
@checked
def configurations(result: Drawable, ax: Axes | None = None) -> Axes:
    """Fractions of the measured time in each configuration of sliding; theory's as rings where the deck fits."""
    source, ax = Source.of(result), axes_of(ax)
    rows, names = source.slide, list(CONFIGURATIONS)
    width = 0.8 / len(rows)
    for k, row in enumerate(rows):
        x = np.arange(len(names)) + (k - (len(rows) - 1) / 2) * width
        values = [float(row[name]) for name in names]
        bars = ax.bar(x, values, width * 0.94, color=style.colour(k), label=source.disk_name(row["disk"]))
        ax.bar_label(bars, [f"{value:.3f}" if value >= 5e-4 or value == 0 else f"{value:.0e}" for value in values], fontsize=7.5,
                     padding=2, color=style.ink())
    theory = theory_of(source) if len(rows) == 1 else None
    if theory and np.isfinite(theory["pp"]):
        ax.plot(np.arange(5), [theory[name] for name in ("pp", "pm", "mp", "mm", "stuck")], ls="none", marker="o", ms=8, mfc="none",
                mec=style.ink(), mew=1.2, label="theory", gid="theory")
    ax.set_xticks(range(len(names)), list(CONFIGURATIONS.values()))
    partners = rows[0]["partner"]
    ax.set_xlabel("sliding: sign of the tangential force at " + ", ".join(source.body_names[int(p)] for p in np.ravel(partners)))
    ax.set_ylabel("fraction of the measured time")
    ax.set_ylim(0, max(1.15 * ax.get_ylim()[1], 0.1))
    if len(rows) > 1 or theory:
        style.legend(ax, loc="upper right")
    return ax


# --- energies -------------------------------------------------------------------------------------------------------
@checked
def energy_budget(result: Drawable, ax: Axes | None = None, *, time: Sequence[float | None] | None = None) -> Axes:
    """What went in and what was lost since step 0."""
    source, ax = Source.of(result), axes_of(ax)
    s = source.series
    t = s["time"]
    keep = within(t, time)
    # `external` jumps when disks come or go, `start` then jumps by all their energy: their height cancels, their motion is left
    brought = s["start"] - s["start"][0]
    released = "released by gravity" + (", motion of disks that came or went" if brought.any() else "")
    lines = [("work of drives", s["work"] + s["nonconservative_work"]), (released, s["external"][0] - s["external"] + brought)]
    lost = [("lost to friction", s["friction"]), ("lost to viscosity", s["viscous"]), ("lost in opening contacts", s["opening"])]
    if "broken_tension" in s:
        lost += [("lost in broken bonds", s["broken_tension"] + s["broken_shear"] + s["broken_bending"])]
    lost += [(name, s[key]) for key, name in (("rolling", "lost to rolling"), ("bridge", "lost in forming bridges"), ("drag", "lost to drag"),
                                              ("damping", "lost to damping"), ("relaxed", "taken out by the relaxer")) if key in s]
    largest = max(float(np.abs(values[keep]).max(initial=0)) for _, values in lines + lost)
    for k, (name, values) in enumerate(lines + lost):
        if np.abs(values[keep]).max(initial=0) > 1e-2 * largest:
            ax.plot(*style.thinned(t[keep], values[keep]), color=style.ink() if k == 0 else style.colour(k - 1),
                    ls="--" if k < 2 else "-", zorder=3 if k < 2 else 2, label=name)
    guide(ax, y=0)
    time_axis(ax, source, t[keep], time)
    ax.set_ylabel(label("since step 0", s.unit("work")))
    style.legend(ax, loc="best")
    return ax


@checked
def energies(result: Drawable, ax: Axes | None = None, *, time: Sequence[float | None] | None = None) -> Axes:
    """Kinetic and elastic energies."""
    source, ax = Source.of(result), axes_of(ax)
    s, t = source.series, source.series["time"]
    keep = within(t, time)
    shown = []
    for k, (name, text) in enumerate((("kinetic_translation", "kinetic, translation"), ("kinetic_rotation", "kinetic, rotation"),
                                      ("elastic_normal", "elastic, normal"), ("elastic_tangential", "elastic, tangential"),
                                      ("elastic_bond", "elastic, bonds"))):
        if name not in s:
            continue
        values = s[name][keep]
        if values.max(initial=0) > 0:
            ax.plot(*style.thinned(t[keep], np.where(values > 0, values, np.nan)), lw=0.9, color=style.colour(k), label=text)
            shown.append(values)
    if shown:
        style.limit_log(ax, shown)
        style.legend(ax, loc="best", ncol=2)
    time_axis(ax, source, t[keep], time, phases=False)
    ax.set_ylabel(label("energy", s.unit("kinetic_translation")))
    return ax


@checked
def energy_residual(result: Drawable, ax: Axes | None = None, *, time: Sequence[float | None] | None = None) -> Axes:
    """What the energy budget misses, over its scale; a run is in doubt beyond 0.01."""
    source, ax = Source.of(result), axes_of(ax)
    s, t = source.series, source.series["time"]
    keep = within(t, time)
    scale = s["scale"][keep]
    values = np.abs(s["residual"][keep]) / np.where(scale > 0, scale, np.nan)
    ax.plot(*style.thinned(t[keep], np.where(values > 0, values, np.nan)), color=style.colour(1), lw=0.9)
    style.limit_log(ax, [values, np.array([1e-2])], 14)
    ax.set_ylim(None, ax.get_ylim()[1] * 30)  # room for the words
    ax.axhline(1e-2, color=style.ink(), ls="--", lw=0.8)
    ax.annotate("in doubt above", (1, 1e-2), xycoords=ax.get_yaxis_transform(), xytext=(0, 2), textcoords="offset points", ha="right", va="bottom",
                fontsize=7.5)
    time_axis(ax, source, t[keep], time, phases=False)
    ax.set_ylabel("|residual| / scale")
    return ax


# --- compression, stress ----------------------------------------------------------------------------------------------
def coordination_series(source):
    """2 N_c/N of the series: contacts per free disk when there are no walls."""
    free = int((~source.driven).sum())
    return 2.0 * source.series["contacts"] / max(free, 1)


def _compression_values(source):
    s = source.series
    return {"time": (s["time"], label("$t$", "time")), "pressure": (s["pressure"], label("pressure $p$", s.unit("pressure"))),
            "fraction": (s["packing_fraction"], r"packing fraction $\phi$"),
            "contacts": (coordination_series(source), "contacts per disk $2N_c/N$")}


@checked
def compression(result: Drawable, ax: Axes | None = None, *, x: str = "time", y: str = "pressure",
                time: Sequence[float | None] | None = None) -> Axes:
    """One of pressure, packing fraction ("fraction") and contacts per disk ("contacts") against time or another of them; dots are
    the ends of phases, rings contacts per disk without rattlers, of stored frames."""
    source, ax = Source.of(result), axes_of(ax)
    values = _compression_values(source)
    t = values["time"][0]
    keep = within(t, time)
    (a, a_label), (b, b_label) = values[x], values[y]
    logs = {"x": x == "pressure", "y": y == "pressure"}
    if x != "time":
        keep &= (values["pressure"][0] > 0) | ("pressure" not in (x, y))
    shown_b = np.where(b > 0, b, np.nan) if logs["y"] else b
    ax.plot(a[keep], shown_b[keep], color=style.colour(0), lw=0.9, gid="series")
    ends = np.array([int(np.argmin(np.abs(t - end))) for _, _, end in source.phases])
    ends = ends[keep[ends]] if len(ends) else ends
    ax.plot(a[ends], shown_b[ends], "o", ms=4.5, color=style.colour(1), label="end of a phase")
    if y == "contacts":
        _backbone(ax, source, x, time)
    for axis, log in logs.items():
        positive = (a if axis == "x" else b)[keep]
        positive = positive[positive > 0]
        if log and len(positive) and positive.max() > 30 * positive.min():
            getattr(ax, f"set_{axis}scale")("log")
            if axis == "y":
                style.limit_log(ax, [positive], 8)
            else:
                ax.set_xlim(max(positive.min() / 2, positive.max() * 1e-8), positive.max() * 2)
    if x == "time":
        time_axis(ax, source, t[keep], time)
    ax.set_xlabel(a_label)
    ax.set_ylabel(b_label)
    if y == "contacts" or (x, y) == ("fraction", "pressure"):
        style.legend(ax, loc="best")
    return ax


def _backbone(ax, source, x, span):
    frames = source.measured_frames if source.n_frames <= 400 else None
    if frames is None:
        return
    column = {"time": "time", "pressure": "pressure", "fraction": "fraction"}[x]
    good = within(frames["time"], span) & (frames["bearing"] > 0)
    ax.plot(frames[column][good], frames["z_backbone"][good], "D", ms=5, mfc="none", mec=style.colour(2), label="without rattlers")


@checked
def stress(result: Drawable, ax: Axes | None = None, *, time: Sequence[float | None] | None = None) -> Axes:
    """Stress of the contacts in the region, compression positive."""
    source, ax = Source.of(result), axes_of(ax)
    s, t = source.series, source.series["time"]
    keep = within(t, time)
    xx, yy = s["stress_xx"][keep], s["stress_yy"][keep]
    shear = (s["stress_xy"][keep] + s["stress_yx"][keep]) / 2
    for k, (values, text) in enumerate(((xx, r"$\sigma_{xx}$"), (yy, r"$\sigma_{yy}$"), (shear, r"$\sigma_{xy}$"))):
        ax.plot(*style.thinned(t[keep], values), color=style.colour(k), lw=0.9, label=text)
    ax.plot(*style.thinned(t[keep], (xx + yy) / 2), color=style.ink(), lw=1.3, label="$p$")
    guide(ax, y=0)
    time_axis(ax, source, t[keep], time)
    ax.set_ylabel(label("stress", s.unit("stress_xx")))
    low, high = ax.get_ylim()
    ax.set_ylim(low, high + 0.15 * (high - low))  # the legend has a place of its own
    style.legend(ax, loc="upper center", ncol=4)
    return ax


@checked
def strain(result: Drawable, ax: Axes | None = None, *, time: Sequence[float | None] | None = None) -> Axes:
    """Deviator over pressure against the strain since the last phase began (measure.box and measure.stress)."""
    source, ax = Source.of(result), axes_of(ax)
    s, t = source.series, source.series["time"]
    keep = within(t, time or (source.phases[-1][1] if len(source.phases) > 1 else None, None))
    xx, yy, xy = s["stress_xx"][keep], s["stress_yy"][keep], (s["stress_xy"] + s["stress_yx"])[keep] / 2
    p, q = (xx + yy) / 2, np.hypot((xx - yy) / 2, xy)
    for k, (name, sign) in enumerate((("height", r"$\varepsilon_{yy}$"), ("width", r"$\varepsilon_{xx}$"))):
        size = s[name][keep]
        held = p > 1e-3 * np.nanmax(p)
        ax.plot(*style.thinned(1 - size[held] / size[0], q[held] / p[held]), color=style.colour(k), lw=0.9, label=f"against {sign}")
    ax.set_xlabel(r"strain $\varepsilon$, compression positive")
    ax.set_ylabel("deviator over pressure $q/p$")
    style.legend(ax, loc="best")
    return ax


@checked
def shear(result: Drawable, ax: Axes | None = None, *, time: Sequence[float | None] | None = None, of: str = "ratio",
          windows: lib.Count = 50) -> Axes:
    """Shear stress over pressure ("ratio") or both ("stress") of a sheared periodic box against the accumulated shear strain, the
    integral of rate_xy: each row of the series (thin) and means of windows (thick), of the ratio those of its parts. Stresses are
    of contacts and velocities, positive for a flow with a positive rate."""
    source, ax = Source.of(result), axes_of(ax)
    if lacks_shear(source):
        raise lib.UserError(f"{source.path}: kind shear {lacks_shear(source)}")
    keep = within(source.series["time"], time)
    t, strain = source.series["time"][keep], source.series["strain_xy"][keep]
    xx, yy, shear_stress = (values[keep] for values in stresses(source))
    p = (xx + yy) / 2
    cuts = np.unique(np.linspace(0, len(strain), min(windows, len(strain)) + 1).astype(int))
    middle, shear_means, p_means = (np.add.reduceat(values, cuts[:-1]) / np.diff(cuts) for values in (strain, shear_stress, p))
    if of == "ratio":
        held = p > 1e-3 * np.nanmax(p)
        lines = [("stress ratio", strain[held], shear_stress[held] / p[held], shear_means / np.where(p_means > 0, p_means, np.nan))]
    else:
        lines = [("shear stress", strain, shear_stress, shear_means), ("pressure $p$", strain, p, p_means)]
    for k, (name, x, rows, means) in enumerate(lines):
        ax.plot(*style.thinned(x, rows), color=style.colour(k), lw=0.6, alpha=0.35, gid=f"rows {k}")
        ax.plot(middle, means, color=style.colour(k), lw=1.6, label=name if of != "ratio" else None, gid=f"means {k}")
    if of == "ratio" and np.isfinite(lines[0][3]).any():  # a few rows of a dilute flow have hardly any pressure
        _frame(ax, np.concatenate([np.nanpercentile(lines[0][2], [2, 98]), lines[0][3][np.isfinite(lines[0][3])]]), 0)
    guide(ax, y=0)
    ax.set_xlabel(r"shear strain $\gamma$")
    ax.set_ylabel("shear stress over pressure" if of == "ratio" else label("stress", source.series.unit("stress_xy")))
    if np.ptp(strain) > 0:
        ax.set_xlim(strain.min(), strain.max())
    if (np.diff(strain) >= 0).all():
        mark_phases(ax, source, time, lambda moment: float(np.interp(moment, t, strain)))
    style.legend(ax, loc="best")
    return ax


@checked
def series(result: Drawable, ax: Axes | None = None, *, quantity: str = "contacts", x: str = "time",
           time: Sequence[float | None] | None = None) -> Axes:
    """A column of the series, or what follows from it, against time or another column: a line for each value of its rows."""
    source, ax = Source.of(result), axes_of(ax)
    keep = within(source.series["time"], time)
    values, along = source.column(quantity)[keep], source.column(x)[keep]
    if along.ndim > 1:
        raise lib.UserError(f"{source.path}: --x {x} has a value for each of {', '.join(source.parts(x))}; expected one, as "
                            f"{source.parts(x)[0]}.{x}")
    names = source.parts(quantity) if values.ndim > 1 else [None]
    for k, (name, line) in enumerate(zip(names, values.reshape(len(values), -1).T)):
        ax.plot(*style.thinned(along, line), color=style.colour(k), lw=0.9, label=name, gid=f"column {k}")
    if values.min(initial=0) < 0 < values.max(initial=0):
        guide(ax, y=0)
    if x == "time":
        time_axis(ax, source, along, time)
    else:
        ax.set_xlabel(label(style.plain(x).replace("_", " "), source.columns[x][0]))
    ax.set_ylabel(label(style.plain(quantity).replace("_", " "), source.columns[quantity][0]))
    style.legend(ax, loc="best", ncol=1 + len(names) // 12)
    return ax


@checked
def walls(result: Drawable, ax: Axes | None = None, *, time: Sequence[float | None] | None = None, component: str = "normal") -> Axes:
    """Force of the contacts on each wall: "normal" (sum of normal forces), "tangential", "x" or "y"."""
    source, ax = Source.of(result), axes_of(ax)
    name = f"wall_force_{component}" if component in ("x", "y") else f"wall_{component}"
    s, t = source.series, source.series["time"]
    keep, values = within(t, time), s[name]
    for k, wall in enumerate(source.result.rows("observables/walls").split("\n")[:values.shape[1]]):
        ax.plot(*style.thinned(t[keep], values[keep, k]), color=style.colour(k), lw=0.9, label=style.plain(wall))
    guide(ax, y=0)
    time_axis(ax, source, t[keep], time)
    ax.set_ylabel(label({"normal": "normal force on a wall", "tangential": "tangential force on a wall"}.get(
        component, f"{component} force on a wall"), s.unit(name)))
    style.legend(ax, loc="best", ncol=4)
    return ax


@checked
def flow(result: Drawable, ax: Axes | None = None, *, time: Sequence[float | None] | None = None) -> Axes:
    """Disks outside the bounds against time."""
    source, ax = Source.of(result), axes_of(ax)
    t, out = source.series["time"], source.series["outside"]
    keep = within(t, time)
    ax.plot(t[keep], out[keep], color=style.colour(0), label="disks outside")
    n = len(source.radius)
    steady = keep & (out > 0.1 * out.max()) & (out < 0.8 * out.max())
    if steady.sum() > 10:
        rate, start = np.polyfit(t[steady], out[steady], 1)
        ax.plot(t[steady], rate * t[steady] + start, color=style.colour(1), ls="--", label=f"{rate:.4g} per time, between 10 and 80 %")
    time_axis(ax, source, t[keep], time)
    ax.set_ylabel(f"disks outside the bounds (of {n})")
    style.legend(ax, loc="best")
    return ax


# --- bonds ------------------------------------------------------------------------------------------------------------
@checked
def breaks(result: Drawable, ax: Axes | None = None, *, time: Sequence[float | None] | None = None, of: str = "count") -> Axes:
    """Bonds that have broken, by the largest of their loads, cumulated in time: their number, or the energy that they held
    (of = "energy")."""
    source, ax = Source.of(result), axes_of(ax)
    rows = source.breaks
    t = source.series["time"] if "time" in source.series else rows["time"]
    t = t[within(t, time)]
    for k, (mode, text) in enumerate(MODES.items()):
        own = rows["mode"] == mode
        if own.any():
            sums = np.concatenate([[0], np.cumsum(rows["energy"][own]) if of == "energy" else np.arange(1, own.sum() + 1)])
            ax.plot(t, sums[np.searchsorted(rows["time"][own], t * (1 + 1e-12), side="right")], color=style.colour(k), label=text, gid=f"mode {mode}")
    time_axis(ax, source, t, time)
    ax.set_ylabel(label("energy of broken bonds", source.result.attribute("state/break_energy", "unit")) if of == "energy" else "broken bonds")
    style.legend(ax, loc="best")
    return ax


# --- few disks --------------------------------------------------------------------------------------------------------
@checked
def paths(result: Drawable, ax: Axes | None = None, *, time: Sequence[float | None] | None = None) -> Axes:
    """Paths of the centres over all frames, with the disks at their ends."""
    from .plot_scene import Scene
    source, ax = Source.of(result), axes_of(ax)
    kept = np.flatnonzero(within(source.frame_times, time))
    if not len(kept):
        raise lib.UserError(f"{source.path}: no frame is in this time; the frames are from {source.frame_times[0]:g} to {source.frame_times[-1]:g}")
    scene = Scene(source, ax, list(kept), plain=True, marks=True).show(int(kept[-1]))
    scene.disks.set_alpha(0.8)
    place = np.stack([source.place(k, True) for k in kept], axis=1)
    for k, path in enumerate(place):
        if not source.driven[k] or np.ptp(path, axis=0).max() > 0:
            ax.plot(*path.T, color=style.colour(k), lw=1.4, zorder=5, label=source.disk_name(k) if len(place) <= 10 else None)
            ax.plot(*path[0], "o", color=style.colour(k), ms=3.5, zorder=6)
    ax.set_xlabel(label("$x$", "length"))
    ax.set_ylabel(label("$y$", "length"))
    if len(place) <= 10:
        style.legend(ax, loc="best", ncol=4)
    return ax


def pairs_of(source):
    """{(a, b, part): rows} of the stored contact tables of few disks, and the time of each row."""
    contacts = source.result.contacts
    t = np.repeat(contacts.time, contacts.count)
    keys = np.stack([contacts[name] for name in ("a", "b", "part")], axis=1)
    found = {}
    for key in np.unique(keys, axis=0):
        found[tuple(int(k) for k in key)] = np.flatnonzero((keys == key).all(1))
    return found, t


@checked
def contact_forces(result: Drawable, ax: Axes | None = None, *, time: Sequence[float | None] | None = None, most: lib.Count = 3) -> Axes:
    """Normal and tangential force of each contact that was stored (of the `most` that were closed longest)."""
    source, ax = Source.of(result), axes_of(ax)
    found, t = pairs_of(source)
    force, tau = source.result.contacts["force"], source.result.contacts["tau"]
    moments = source.result.contacts.time
    for k, ((a, b, _), rows) in enumerate(sorted(found.items(), key=lambda item: -len(item[1]))[:most]):
        pair = f"{source.body_names[a]}–{source.body_names[b]}"
        for values, line, text in ((force, "-", "$F_n$"), (tau, "--", r"$\tau$")):
            full = np.zeros(len(moments))
            full[np.searchsorted(moments, t[rows])] = values[rows]
            keep = within(moments, time)
            ax.plot(*style.thinned(moments[keep], full[keep]), line, color=style.colour(k), lw=0.9, label=f"{text} {pair}")
    guide(ax, y=0)
    time_axis(ax, source, moments[within(moments, time)], time)
    ax.set_ylabel(label("force of a contact", source.result.attribute("contacts/force", "unit")))
    style.legend(ax, loc="best")
    return ax


@checked
def contact_loop(result: Drawable, ax: Axes | None = None, *, time: Sequence[float | None] | None = None, most: lib.Count = 3) -> Axes:
    """Tangential force against tangential displacement of each contact: loops are the energy lost."""
    source, ax = Source.of(result), axes_of(ax)
    found, t = pairs_of(source)
    zeta, tau = source.result.contacts["zeta"], source.result.contacts["tau"]
    for k, ((a, b, _), rows) in enumerate(sorted(found.items(), key=lambda item: -len(item[1]))[:most]):
        rows = rows[within(t[rows], time)]
        ax.plot(zeta[rows], tau[rows], color=style.colour(k), lw=0.6, marker=".", ms=1.5,
                label=f"{source.body_names[a]}–{source.body_names[b]}")
    guide(ax, y=0, x=0)
    ax.set_xlabel(label(r"tangential displacement $\zeta$", "length"))
    ax.set_ylabel(label(r"tangential force $\tau$", source.result.attribute("contacts/tau", "unit")))
    style.legend(ax, loc="best")
    return ax
