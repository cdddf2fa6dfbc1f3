"""Pictures of packings: maps, force networks, distributions of forces, pair correlation, profiles, means of every disk."""
from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.lines import Line2D

from . import library as lib
from . import plot_style as style
from .arguments import checked
from .plot_scene import Scene, in_reach, sliding_colour
from .plot_source import QUANTITIES, Source
from .plot_style import axes_of, guide, label

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from .plot_source import Drawable


def _named(ax, source, k):
    ax.set_xlabel(label("$x$", "length"))
    ax.set_ylabel(label("$y$", "length"))
    inside = in_reach(source.place(k), source.radius, ax.get_xlim(), ax.get_ylim())
    beyond = int((source.in_play(k) & ~inside).sum())
    ax.set_title(f"t = {source.frame_times[k]:.6g}" + (f" ({beyond} disk{'s' * (beyond > 1)} outside the picture)" if beyond else ""),
                 fontsize=9)


@checked
def map(result: Drawable, ax: Axes | None = None, *, frame: int | None = None, color: str | None = None, network: bool = False,
        first: int = 0, region: Sequence[float] | None = None) -> Axes:
    """Disks of a frame coloured by a quantity: omega, turned, spin, speed, vx, vy, moved, radius, contacts, pressure, fraction,
    group; by default what the file has of the first three. `first`: the frame from which angles and distances count."""
    source, ax = Source.of(result), axes_of(ax)
    k = source.frame_number(frame)
    scene = Scene(source, ax, [k], color, network, source.frame_number(first), region=region).show(k)
    bar = scene.colour_bar()
    if scene.one.name in ("turned", "moved"):
        bar.set_label(f"{bar.ax.get_ylabel() or bar.ax.get_xlabel()} since t = {source.frame_times[source.frame_number(first)]:.6g}")
    _named(ax, source, k)
    return ax


@checked
def network(result: Drawable, ax: Axes | None = None, *, frame: int | None = None, region: Sequence[float] | None = None) -> Axes:
    """Contacts of a frame as lines as wide as the normal force; sliding ones in another colour."""
    source, ax = Source.of(result), axes_of(ax)
    k = source.frame_number(frame)
    scene = Scene(source, ax, [k], network=True, plain=True, marks=False, region=region).show(k)
    _named(ax, source, k)
    if scene.mean_force:
        width = scene.line
        table = source.measured(k)["contacts"]
        known, slides = np.isfinite(table["sliding"]).any(), (np.nan_to_num(table["sliding"] * table["tau"]) != 0).any()
        handles = [Line2D([], [], color=style.ink(), lw=width * n, label=text) for n, text in
                   ((1, rf"$\langle F_n\rangle$ = {scene.mean_force:.3g}"), (3, r"$3\langle F_n\rangle$"))]
        if slides:
            handles.append(Line2D([], [], color=sliding_colour(), lw=max(width, 1.5), label="sliding"))
        ax.legend(handles=handles, loc="lower right", bbox_to_anchor=(1, 1.0), ncol=3, borderaxespad=0.1,
                  title=None if known else "sliding is not known: contacts were not stored with this frame", title_fontsize=7.5)
    return ax


@checked
def bonds(result: Drawable, ax: Axes | None = None, *, frame: int | None = None, region: Sequence[float] | None = None) -> Axes:
    """Bonds of a frame as bars coloured by their force, tension positive; crosses where bonds have broken so far."""
    source, ax = Source.of(result), axes_of(ax)
    k = source.frame_number(frame)
    scene = Scene(source, ax, [k], bonds=True, plain=True, marks=False, region=region).show(k)
    ax.figure.colorbar(scene.forces, cax=ax.inset_axes([1.03, 0, 0.035, 1]), extend="both",
                       label=label("force of a bond, tension > 0", source.result.attribute("contacts/bond_pull", "unit")))
    _named(ax, source, k)
    return ax


# --- distributions ------------------------------------------------------------------------------------------------------
def _merged(values, m):
    """Means of each m neighbours."""
    n = len(values) // m * m
    return values[:n].reshape(-1, m).mean(1)


@checked
def forces(result: Drawable, ax: Axes | None = None, *, frame: int | None = None) -> Axes:
    """Densities of the normal forces (and tangential ones) over their means, with the counting error; the dashed line is e^-f."""
    source, ax = Source.of(result), axes_of(ax)
    tables = source.measured(source.frame_number(frame))
    table, bearing = tables["forces"], float(tables["frames"]["bearing"][0])
    m = 1 if bearing > 5000 else 2 if bearing > 1000 else 5
    low, high = table["low"][::m][:len(table["low"]) // m], table["high"][m - 1::m]
    middle, width = (low + high) / 2, high - low
    top, lowest = 0.0, 1.0
    for k, (name, text) in enumerate((("normal", r"$F_n/\langle F_n\rangle$"), ("tangential", r"$|\tau|/\langle|\tau|\rangle$"))):
        density = _merged(table[name], m)
        if not np.isfinite(density).any() or not np.nansum(density):
            continue
        error = np.sqrt(density / (bearing * width))
        seen = density > 0
        ax.errorbar(middle[seen], density[seen], np.minimum(error, 0.999 * density)[seen], fmt=style.MARKERS[k], ms=3.5, lw=0.8,
                    color=style.colour(k), label=text)
        top, lowest = max(top, middle[seen].max() + width[0]), min(lowest, density[seen].min())
    x = np.linspace(0, top or 1, 50)
    ax.plot(x, np.exp(-x), color=style.faint(), ls="--", lw=1, zorder=0, label="$e^{-f}$")
    ax.set_yscale("log")
    ax.set_ylim(0.5 * lowest, None)
    ax.set_xlim(0, top or 1)
    ax.set_xlabel("force over its mean $f$")
    ax.set_ylabel("density $P(f)$")
    ax.legend(title=f"{bearing:.0f} contacts bear load", title_fontsize=8.5)
    return ax


@checked
def gr(result: Drawable, ax: Axes | None = None, *, frame: int | None = None) -> Axes:
    """Pair correlation function, over the mean diameter."""
    source, ax = Source.of(result), axes_of(ax)
    k = source.frame_number(frame)
    n = int(source.in_play(k).sum())
    diameter = 2 * float(source.radius[source.in_play(k) & ~source.driven].mean())
    wide = (0.05 if n < 1000 else 0.02) * diameter
    table = source.pairs(k, wide)
    m = max(int(round(wide / (2 * table["r"][0]))), 1)
    r = _merged(table["r"], m) / diameter
    g = _merged(table["g"] * table["r"], m) / (r * diameter)
    ax.plot(r, g, color=style.colour(0), drawstyle="steps-mid" if n < 1000 else "default")
    guide(ax, y=1)
    ax.set_xlim(0, None)
    ax.set_ylim(0, None)
    ax.set_xlabel(r"distance over mean diameter $r/\langle d\rangle$")
    ax.set_ylabel("pair correlation $g(r)$")
    return ax


# --- profiles -------------------------------------------------------------------------------------------------------------
@checked
def profile(result: Drawable, ax: Axes | None = None, *, of: str = "fraction", frame: int | None = None, bins: lib.Count | None = None,
            first: int = 0) -> Axes:
    """Means over layers of height with their standard errors: "fraction" (area of disks over that of their closed cells),
    "contacts" per disk, or a quantity of `map`."""
    source, ax = Source.of(result), axes_of(ax)
    k = source.frame_number(frame)
    disks = source.measured(k)["disks"]
    number = disks["disk"].astype(int)
    free = disks["prescribed"] == 0
    g = source.gravity
    up = -g / np.hypot(*g) if np.hypot(*g) > 0 else np.array([0.0, 1.0])
    height = disks["x"] * up[0] + disks["y"] * up[1]
    diameter = 2 * float(disks["radius"][free].mean())
    bins = bins or int(np.clip(np.ptp(height[free]) / diameter, 3, 40))
    edges = np.linspace(height[free].min(), height[free].max() * (1 + 1e-12) + 1e-300, bins + 1)
    layer = np.clip(np.digitize(height, edges) - 1, 0, bins - 1)
    middle = (edges[1:] + edges[:-1]) / 2
    if of == "fraction":
        use = free & (disks["closed"] == 1)
        area, cell = np.pi * disks["radius"] ** 2, disks["cell"]
        text, unit = r"$\phi$ of closed cells", "1"
    else:
        one = QUANTITIES.get(of)
        if one is None:
            raise lib.unknown(of, list(QUANTITIES), "what profiles are made of")
        missing = one.lacks(source)
        if missing:
            raise lib.UserError(f"{source.path}: {of} {missing}")
        area = one.of(source, k, source.frame_number(first))[number]
        cell = np.ones(len(area))
        use, text, unit = free & np.isfinite(area), {"omega": r"$\Omega$", "contacts": "contacts"}.get(of, one.text), one.unit
    mean, error = np.full(bins, np.nan), np.full(bins, np.nan)
    for n in range(bins):
        here = use & (layer == n)
        if here.sum() > 1:
            mean[n] = area[here].sum() / cell[here].sum()
            error[n] = np.sqrt(((area - mean[n] * cell)[here] ** 2).sum() * here.sum() / (here.sum() - 1)) / cell[here].sum()
    ax.errorbar(mean, middle, xerr=error, fmt="o-", ms=3, lw=0.8, color=style.colour(0), gid="profile")
    if of in ("omega", "turned", "spin", "vx", "vy"):
        guide(ax, x=0)
    ax.set_xlabel(label(text, unit))
    ax.set_ylabel(label("height" if np.hypot(*g) > 0 else "$y$", "length"))
    return ax


@checked
def means(result: Drawable, ax: Axes | None = None) -> Axes:
    """Mean angular velocity of every disk in the second half of the measured time against that in the first: on the diagonal
    where rotation persists. Bars are one standard error."""
    source, ax = Source.of(result), axes_of(ax)
    table = source.result.means
    a, b, error = table["omega_first"], table["omega_second"], table["error"]
    good = np.isfinite(a) & np.isfinite(b)
    a, b, error = a[good], b[good], np.nan_to_num(error[good])
    if len(a) <= 500:
        ax.errorbar(a, b, error, error, fmt="o", ms=3, lw=0.6, capsize=0, color=style.colour(0), gid="means")
    else:
        ax.plot(a, b, ".", ms=2, alpha=0.5, color=style.colour(0), rasterized=True, gid="means")
    top = 1.1 * max(np.abs(a).max(initial=0), np.abs(b).max(initial=0), 1e-300)
    ax.plot([-top, top], [-top, top], color=style.faint(), lw=0.8, zorder=0)
    guide(ax, y=0, x=0)
    ax.set_xlim(-top, top)
    ax.set_ylim(-top, top)
    ax.set_aspect("equal")
    totals = source.result.totals
    ax.set_title(f"persistence {totals.persistence:.3f}; {totals.significant:.0%} of {int(totals.disks)} disks turn significantly", fontsize=9)
    unit = source.result.attribute("summary/disks/omega", "unit")
    ax.set_xlabel(label(r"$\Omega$, first half", unit))
    ax.set_ylabel(label(r"$\Omega$, second half", unit))
    return ax
