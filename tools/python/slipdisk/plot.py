"""Pictures of results and sweeps: `slipdisk plot`, and functions for notebooks; docs/plots.md.

page(path)                       the picture that fits the file, as a matplotlib Figure
rotation, spin, configurations, energy_budget, energies, energy_residual, compression, stress, strain, shear, walls, breaks, flow, paths,
series, contact_forces, contact_loop, map, network, bonds, forces, gr, profile, means, curve
                                 one of them into axes of your own: slipdisk.plot.map(result, ax=axes, color="spin")
"""
from __future__ import annotations

import argparse
import os
import sys
import warnings
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from . import library as lib
from . import plot_style as style
from .arguments import checked
from .plot_packing import bonds, forces, gr, map, means, network, profile  # noqa: A004
from .plot_scene import extent
from .plot_series import (breaks, compression, configurations, contact_forces, contact_loop, energies, energy_budget, energy_residual, flow,
                          paths, rotation, series, shear, spin, strain, stress, walls, within)
from .plot_source import QUANTITIES, Source, lacks_shear, lacks_stress, usual_quantity
from .plot_sweep import Curves, curve, list_of, theory
from .sweep import Sweep

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from .plot_source import Drawable

__all__ = ["KINDS", "Source", "bonds", "breaks", "compression", "configurations", "contact_forces", "contact_loop", "curve", "energies", "energy_budget",
           "energy_residual", "flow", "forces", "gr", "map", "means", "network", "page", "paths", "profile", "rotation", "series", "shear",
           "spin", "strain", "stress", "walls"]

DPI = 200
FEW = 10  # disks that are told apart by name


# --- what there can be ------------------------------------------------------------------------------------------------
class Kind:
    """name; what it shows; lacks(source): what is missing for it, or None; panels(source, o): ([[axes functions]], width, height)
    in inches, rows of panels from the top."""

    def __init__(self, name, text, lacks, panels):
        self.name, self.text, self.lacks, self.panels = name, text, lacks, panels


def _series(*names, hint):
    def lacks(source):
        return None if all(name in source.series for name in names) and len(source.series["time"]) > 1 else hint
    return lacks


def _watched(source):
    if source.rotation is None or not len(source.rotation):
        return "needs watched disks: measure = { rotation = (...); } in the deck"
    return _series("angle", hint="needs a time series: series in the phase")(source)


def _sliding(source):
    return None if source.slide is not None and len(source.slide) else "needs a watched pair of contacts: measure.sliding in the deck"


def _framed(source):
    return None if source.n_frames else "needs a frame: none is stored yet"


def _filled(source):
    if _framed(source):
        return _framed(source)
    return None if (~source.driven).sum() > FEW else f"needs more than {FEW} free disks"


def _moving(source):
    if source.n_frames < 3:
        return "needs frames: set frames in the phase"
    return None if len(source.radius) <= 50 else "is for 50 disks at most; see kind map with --color moved"


def _tables(source):
    if len(source.radius) > FEW:
        return f"is for {FEW} disks at most"
    return None if len(source.result.contacts) > 2 and source.result.contacts.count.sum() else "needs contact tables: set contacts in the phase"


def _compressed(source):
    return _series("pressure", "packing_fraction", hint="needs a phase that compresses: compress = { ... } in the deck")(source)


def _out(source):
    lacks = _series("outside", hint="needs bounds in the deck")(source)
    return lacks or (None if source.series["outside"].max() > 0 else "shows disks that left the bounds: none has")


def _bonded(source):
    if source.breaks is None:
        return "needs bonds: bond = { ... } in a phase of the deck"
    if _framed(source):
        return _framed(source)
    return None if any(source.pulls(k) is not None for k in range(source.n_frames)) else "needs contact tables at frames: set contacts in the phase"


def _broken(source):
    if source.breaks is None:
        return "needs bonds: bond = { ... } in a phase of the deck"
    return None if len(source.breaks["time"]) else "shows broken bonds: none has broken"


def _mean_disks(source):
    return QUANTITIES["omega"].lacks(source)


def _one(draw, width=6.0, height=4.0, **options):
    """A kind of one panel; options: of the function, by name of the command's option."""
    return lambda source, o: ([[lambda ax: draw(source, ax, **{own: getattr(o, given) for own, given in options.items()})]], width, height)


def _map_size(source, k, bar, region):
    (x0, x1), (y0, y1) = extent(source, [k], region)
    aspect = float(np.clip((y1 - y0) / (x1 - x0), 0.2, 3))
    width = 6.0 if aspect < 1 else 6.0 / aspect
    return max(width, 2.2) + bar, max(width, 2.2) * aspect + (1.5 if bar and aspect < 0.5 else 0.7)


def _scene(draw, bar, *names):
    def panels(source, o):
        k = source.frame_number(o.frame)
        return [[lambda ax: draw(source, ax, frame=k, **{name: getattr(o, name) for name in names})]], *_map_size(source, k, bar, o.region)
    return panels


def _energy(source, o):
    return [[lambda ax: energy_budget(source, ax, time=o.time)], [lambda ax: energies(source, ax, time=o.time)],
            [lambda ax: energy_residual(source, ax, time=o.time)]], 6.0, 9.0


def _compression(source, o):
    def panel(x, y):
        return lambda ax: compression(source, ax, x=x, y=y, time=o.time)
    return [[panel("time", "pressure"), panel("fraction", "pressure")], [panel("time", "fraction"), panel("pressure", "contacts")],
            [panel("time", "contacts"), panel("fraction", "contacts")]], 9.0, 8.5


def _stress(source, o):
    own = [lambda ax: stress(source, ax, time=o.time)]
    if {"width", "height"} <= set(source.series):
        own.append(lambda ax: strain(source, ax, time=o.time))
    return [own], 4.0 * len(own) + 1, 4.0


def _shear(source, o):
    return [[lambda ax: shear(source, ax, time=o.time), lambda ax: shear(source, ax, time=o.time, of="stress")]], 9.0, 4.0


def _curve(source, o):
    return [[lambda ax: series(source, ax, quantity=o.quantity or "contacts", x=o.x or "time", time=o.time)]], 7.0, 4.5


def _profile(source, o):
    color = o.color if o.color in QUANTITIES and o.color not in ("contacts", "fraction", "group") else None
    turning = color or usual_quantity(source)
    return [[(lambda of: lambda ax: profile(source, ax, of=of, frame=o.frame, first=o.first))(of)
             for of in ("fraction", "contacts", turning)]], 7.0, 4.0


def _contact(source, o):
    return [[lambda ax: contact_forces(source, ax, time=o.time), lambda ax: contact_loop(source, ax, time=o.time)]], 10.0, 4.0


def _breaks(source, o):
    return [[lambda ax: breaks(source, ax, time=o.time)], [lambda ax: breaks(source, ax, time=o.time, of="energy")]], 6.0, 6.0


def _walls(source, o):
    return [[lambda ax: walls(source, ax, time=o.time)], [lambda ax: walls(source, ax, time=o.time, component="tangential")]], 6.0, 6.0


KINDS = {kind.name: kind for kind in (
    Kind("rotation", "mean angular velocity of the watched disks in time, with its error band", _watched, _one(rotation, time="time")),
    Kind("spin", "angular velocity of the watched disks at each moment", _watched, _one(spin, time="time")),
    Kind("configurations", "fractions of time in the configurations of sliding", _sliding, _one(configurations)),
    Kind("energy", "energy budget: put in, lost, stored, missing", _series("work", "residual", hint="needs a time series: series in the phase"),
         _energy),
    Kind("contact", "forces of single contacts in time, and against their displacement", _tables, _contact),
    Kind("paths", "paths of the disks", _moving, _one(paths, 5.5, 5.0, time="time")),
    Kind("map", "disks coloured by a quantity (--color)", _framed, _scene(map, 1.0, "color", "first", "region")),
    Kind("network", "contacts as lines as wide as their force", _filled, _scene(network, 0.0, "region")),
    Kind("bonds", "bonds as bars coloured by their force, and where bonds have broken", _bonded, _scene(bonds, 1.0, "region")),
    Kind("breaks", "broken bonds and their energy in time, by tension, shear and bending", _broken, _breaks),
    Kind("forces", "distribution of the contact forces", _filled, _one(forces, 5.0, 4.0, frame="frame")),
    Kind("gr", "pair correlation function", _filled, _one(gr, 5.0, 4.0, frame="frame")),
    Kind("profile", "packing fraction, contacts and rotation over height", _filled, _profile),
    Kind("means", "mean rotation of every disk: second half of the time against the first", _mean_disks, _one(means, 5.0, 5.0)),
    Kind("compression", "pressure, packing fraction and contacts in time and against each other", _compressed, _compression),
    Kind("stress", "stress in time, deviator against strain", lacks_stress, _stress),
    Kind("shear", "shear stress, and its ratio to pressure, against the shear strain of a sheared box", lacks_shear, _shear),
    Kind("walls", "forces on the walls in time", _series("wall_normal", hint="needs measure = { walls = true; } in the deck"), _walls),
    Kind("flow", "disks outside the bounds in time", _out, _one(flow, time="time")),
    Kind("curve", "a column of the series against time or another (--quantity, --x; --quantity list names them)",
         _series("time", hint="needs a time series: series in the phase"), _curve),
)}


def default_kinds(source):
    """What is worth seeing of this result."""
    if not _sliding(source):
        wanted = ["rotation", "configurations", "spin", "energy"]
    elif (~source.driven).sum() <= FEW:
        wanted = ["paths", "contact", "spin", "energy"]
        if source.n_frames < 3:
            wanted = ["contact", "spin", "energy"]
        spins = source.series["angular_velocity"] if "angular_velocity" in source.series else np.zeros(1)
        if not np.abs(spins).max(initial=0) > 0:
            wanted.remove("spin")
    elif not _broken(source):
        wanted = ["bonds", "breaks", "map", "energy"]
    elif not lacks_shear(source):
        wanted = ["shear", "map", "network", "forces"]
    elif not _compressed(source) and not (lacks_stress(source) is None and "strain_xx" in source.series):
        wanted = ["compression", "map", "network"]
    elif "stress_xx" in source.series:
        wanted = ["stress", "map", "network", "profile", "forces", "gr"]
    elif not _out(source):
        wanted = ["flow", "map", "network", "profile"]
    else:
        wanted = ["map", "network", "profile", "forces", "gr", "energy"]
        if not _mean_disks(source):
            wanted[5] = "means"
    return [name for name in wanted if not KINDS[name].lacks(source)]


# --- a page -----------------------------------------------------------------------------------------------------------
def _draw(place, panels):
    axes = place.subplots(len(panels), len(panels[0]), squeeze=False)
    for row, line in zip(axes, panels):
        for ax, draw in zip(row, line):
            draw(ax)
        for ax in row[1:]:  # heights are told once
            if ax.get_ylabel() == row[0].get_ylabel():
                ax.set_ylabel("")
                row[0].set_ylim(min(ax.get_ylim()[0], row[0].get_ylim()[0]), max(ax.get_ylim()[1], row[0].get_ylim()[1]))
                ax.sharey(row[0])


def _columns(parts):
    """Columns of the parts (name, panels, width, height): the tallest part goes to the shortest column; within a column, and of
    columns, the order is that of the parts."""
    columns = [[] for _ in range(1 if len(parts) == 1 else 2 if len(parts) < 5 else 3)]
    for k in sorted(range(len(parts)), key=lambda k: (-parts[k][3], k)):
        min(columns, key=lambda column: sum(parts[i][3] for i in column)).append(k)
    return [[parts[k] for k in sorted(column)] for column in sorted(columns, key=min)]


def _map_dpi(picture, source, options):
    """Pixels per inch at which a disk of a map is ten pixels wide, 200 to 600."""
    (x0, x1), (y0, y1) = extent(source, [source.frame_number(options.frame)], options.region)
    width, height = picture.get_size_inches()
    inches = 2 * float(np.median(source.radius)) * min(width / (x1 - x0), height / (y1 - y0))
    return float(np.clip(12 / inches, DPI, 600))


def page_of_result(source, names, options):
    parts = [(name, *KINDS[name].panels(source, options)) for name in names]
    columns = _columns(parts)
    widths = [max(part[2] for part in column) for column in columns]
    heights = [sum(part[3] for part in column) for column in columns]
    picture = style.figure(*(options.size or (sum(widths), np.mean(heights) + 0.3)))
    places = np.atleast_1d(picture.subfigures(1, len(columns), width_ratios=widths)) if len(columns) > 1 else [picture]
    for place, column in zip(places, columns):
        cells = np.atleast_1d(place.subfigures(len(column), 1, height_ratios=[part[3] for part in column])) if len(column) > 1 else [place]
        for cell, part in zip(cells, column):
            _draw(cell, part[1])
    title = style.plain(os.path.basename(source.path)) + (f": {source.title}" if source.title else "")
    if len(parts) == 1 and parts[0][0] in ("map", "network"):
        picture.set_dpi(_map_dpi(picture, source, options))
    picture.suptitle(title + ("" if source.result.finished else f" (unfinished, t = {source.result.time:g})"), x=0.01, ha="left", fontsize=10)
    return picture


def page_of_sweep(sweep, options):
    c = Curves(sweep, options.x, options.quantity)
    expected = theory(sweep) if c.y.endswith(".omega") else {}
    if c.apart:
        columns = min(len(c.groups), 3)
        rows = -(-len(c.groups) // columns)
        picture = style.figure(*(options.size or (4.0 * columns, 3.0 * rows + 0.4)))
        axes = picture.subplots(rows, columns, squeeze=False, sharex=True).ravel()
        for k, ax in enumerate(axes):
            if k >= len(c.groups):
                ax.set_axis_off()
                continue
            curve(sweep, ax, curves=c, only=k, rows_of_theory=expected)
            ax.tick_params(labelbottom=True)
            if k < len(c.groups) - columns:
                ax.set_xlabel("")
            if k % columns:
                ax.set_ylabel("")
    else:
        picture = style.figure(*(options.size or (7.0, 4.5)))
        curve(sweep, picture.subplots(), curves=c, rows_of_theory=expected)
    done = int((sweep["status"] == "done").sum())
    picture.suptitle(style.plain(os.path.basename(sweep.folder)) + ("" if done == len(sweep) else f" ({done} of {len(sweep)} points)"), x=0.01, ha="left",
                     fontsize=10)
    return picture


@checked
def options_of(*, frame: int | None = None, time: Sequence[float | None] | None = None, color: str | None = None, first: int = 0,
               size: tuple[float, float] | None = None, x: str | None = None, quantity: str | None = None, region: Sequence[float] | None = None,
               dark: bool = False) -> argparse.Namespace:
    """The options that `page` understands."""
    return argparse.Namespace(**locals())


@checked
def page(path: Drawable | Sweep, kinds: list[str] | tuple[str, ...] | None = None, **options: Any) -> Figure:
    """The picture of a result or a folder of a sweep, a matplotlib Figure: of these kinds, else what fits. Options: frame, time, color,
    first, size (inches), x, quantity, region, dark, as of `slipdisk plot`."""
    options = options_of(**options)
    with style.look(options.dark):
        if isinstance(path, Sweep) or (isinstance(path, (str, os.PathLike)) and os.path.isdir(os.path.join(path, "points"))):
            sweep = path if isinstance(path, Sweep) else Sweep(path)
            if kinds and list(kinds) != ["curve"]:
                raise lib.UserError(f"{sweep.folder}: a sweep has kind curve only; expected a result, {sweep.folder}/points/....h5, for {kinds[0]}")
            return page_of_sweep(sweep, options)
        source = Source.of(path)
        if options.quantity or options.x:
            kinds = kinds or ["curve"]
            if "curve" not in kinds:
                raise lib.UserError(f"--{'quantity' if options.quantity else 'x'} belongs to kind curve, and not to {', '.join(kinds)}")
        kinds = _checked(source, kinds)
        _check_time(source, options.time)
        return page_of_result(source, kinds, options)


def _checked(source, kinds):
    if not kinds:
        kinds = default_kinds(source)
        if not kinds:
            raise lib.UserError(f"{source.path}: there is nothing to be drawn yet")
    for name in kinds:
        if name not in KINDS:
            raise lib.unknown(name, [*KINDS, "list"], "the kinds of pictures")
        missing = KINDS[name].lacks(source)
        if missing:
            has = ", ".join(other for other in KINDS if not KINDS[other].lacks(source))
            raise lib.UserError(f"{source.path}: kind {name} {missing}; this file has: {has}")
    return list(kinds)


def _check_time(source, span):
    """An error when nothing is left of what there is in time."""
    low, high = span or (None, None)
    asked = ":".join("" if end is None else f"{end:g}" for end in (low, high))
    if low is not None and high is not None and low >= high:
        raise lib.UserError(f"--time {asked}: expected FROM < TO")
    series = "time" in source.series and len(source.series["time"]) > 1
    times = source.series["time"] if series else source.frame_times if source.n_frames else ()
    if span and len(times) and within(times, span).sum() < 2:
        raise lib.UserError(f"--time {asked}: fewer than two moments are there; the {'series' if series else 'frames'} of {source.path} "
                            f"run{'s' * series} from {times[0]:g} to {times[-1]:g}")


def list_kinds(path):
    """Lines on what there can be of this file."""
    if os.path.isdir(os.path.join(path, "points")):
        sweep = Sweep(path)
        c = Curves(sweep)
        return [f"curve          {c.y} against {c.x} (--quantity, --x name others)"]
    source = Source(path)
    first = default_kinds(source)
    lines = []
    for name, kind in KINDS.items():
        missing = kind.lacks(source)
        lines.append(f"{'*' if name in first else '-' if missing else ' '} {name:<15}{missing or kind.text}")
    return [*lines, "* without --kind; - not of this file"]


def list_quantities(path):
    """Lines on what a result or a sweep can be drawn by."""
    if os.path.isdir(os.path.join(path, "points")):
        return list_of(Sweep(path))
    source = Source(path)
    lines = ["--quantity, against time or --x:"]
    lines += [f"  {name:<24}{unit:<16}{meaning}" for name, (unit, meaning) in source.columns.items()]
    lines += ["--color of disks, - not of this file:"]
    for name, one in QUANTITIES.items():
        missing = one.lacks(source)
        lines.append(f"{'-' if missing else ' '} {name:<24}{one.unit:<16}{missing or style.words(one.text)}")
    return lines


# --- the command ------------------------------------------------------------------------------------------------------
def pair(text, kind=float, separator="x"):
    low, _, high = text.partition(separator)
    return kind(low), kind(high)


def span(text):
    low, _, high = text.partition(":")
    return (float(low) if low else None), (float(high) if high else None)


def region_of(text):
    return tuple(float(word) for word in text.split(","))


def default_output(path, ending):
    """NAME.ending in the current folder."""
    name = os.path.basename(os.path.normpath(path))
    stem = os.path.splitext(name.removesuffix(".parts"))[0] or name
    return stem + ending


def tell(command, work):
    """Runs a command; messages on stderr, and the exit status that they have."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", lib.Warning)
            work()
            sys.stdout.flush()
        return 0
    except lib.Error as error:
        for line in error.messages:
            print(f"error: {line}", file=sys.stderr)
        return error.status or lib.USER
    except MemoryError:
        print(f"error: slipdisk {command}: no memory", file=sys.stderr)
    except OSError as error:
        print(f"error: {error}", file=sys.stderr)
    except KeyboardInterrupt:
        return 130
    return lib.IO


def plot(a):
    if a.kind == ["list"]:
        print("\n".join(list_kinds(a.file)))
        return
    if a.quantity == "list":
        print("\n".join(list_quantities(a.file)))
        return
    output = a.output or default_output(a.file, ".png")
    style.check_ending(output, style.ENDINGS)
    with style.look(a.dark):
        picture = page(a.file, a.kind, frame=a.frame, time=a.time, color=a.color, size=a.size, x=a.x, quantity=a.quantity, region=a.region,
                       dark=a.dark)
        style.save(picture, output, a.dpi or max(picture.get_dpi(), DPI))
    print(output)


def main(words=None):
    parser = argparse.ArgumentParser(prog="slipdisk plot", allow_abbrev=False)
    parser.add_argument("file")
    parser.add_argument("--output")
    parser.add_argument("--kind", action="append")
    parser.add_argument("--frame", type=int)
    parser.add_argument("--time", type=span)
    parser.add_argument("--color")
    parser.add_argument("--quantity")
    parser.add_argument("--x")
    parser.add_argument("--size", type=pair)
    parser.add_argument("--region", type=region_of)
    parser.add_argument("--dpi", type=float)
    parser.add_argument("--dark", action="store_true")
    a = parser.parse_args(words)
    return tell("plot", lambda: plot(a))


if __name__ == "__main__":
    sys.exit(main())
