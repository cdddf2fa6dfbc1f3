"""Disks, walls and contacts of a frame as collections of matplotlib, which a film moves on from frame to frame."""
import numpy as np
from matplotlib.cm import ScalarMappable
from matplotlib.collections import EllipseCollection, LineCollection
from matplotlib.colors import BoundaryNorm, ListedColormap, Normalize, to_rgba
from matplotlib.lines import Line2D

from . import library as lib
from . import plot_style as style
from .plot_source import CIRCLE, LINE, Source, quantity


def _trimmed(place, radius):
    """Which disks are not strays: few (5 %) that are ten diameters away from the rest."""
    keep = np.ones(len(place), bool)
    gap, most = 20 * float(np.median(radius)), len(place) // 20
    for axis in range(2):
        order = np.argsort(place[:, axis])
        wide = np.flatnonzero(np.diff(place[order, axis]) > gap)
        for after in wide[wide < most]:
            keep[order[:after + 1]] = False
        for after in wide[wide >= len(order) - 1 - most]:
            keep[order[after + 1:]] = False
    return keep


def in_reach(place, radius, xlim, ylim):
    """Which disks are seen within these limits."""
    return ((place + radius[:, None] > [xlim[0], ylim[0]]) & (place - radius[:, None] < [xlim[1], ylim[1]])).all(1)


def _check_region(source, ks, region):
    """An error when no disk of these frames is in it."""
    for k in ks:
        here = source.in_play(k)
        if in_reach(source.place(k)[here], source.radius[here], region[:2], region[2:]).any():
            return
    (x0, x1), (y0, y1) = extent(source, ks[-1:])
    raise lib.UserError(f"--region {','.join(f'{edge:g}' for edge in region)}: no disk is there; {source.path} reaches from x = {x0:.4g} to "
                        f"{x1:.4g}, y = {y0:.4g} to {y1:.4g}")


def extent(source, ks, region=None):
    """((x0, x1), (y0, y1)) that shows the disks of these frames, and round walls about them; or region = (x0, x1, y0, y1)."""
    if region:
        _check_region(source, ks, region)
        return tuple(region[:2]), tuple(region[2:])
    low, high = np.full(2, np.inf), np.full(2, -np.inf)
    for k in ks:
        here = source.in_play(k)
        if here.any():
            place, radius = source.place(k)[here], source.radius[here]
            keep = _trimmed(place, radius)
            place, radius = place[keep], radius[keep][:, None]
            low, high = np.minimum(low, (place - radius).min(0)), np.maximum(high, (place + radius).max(0))
        for kind, points, radius, _ in source.walls(k):
            if kind == CIRCLE:
                low, high = np.minimum(low, points[0] - radius), np.maximum(high, points[0] + radius)
    if not np.isfinite(low).all():
        low, high = np.zeros(2), np.ones(2)
    rim = 0.02 * (high - low).max()
    low, high = low - rim, high + rim
    lower, _, periodic = source.box_at(ks[0])
    edges = np.max([source.box_at(k)[1] for k in ks], axis=0)
    low, high = np.where(periodic, lower, low), np.where(periodic, lower + np.nan_to_num(edges), high)
    return (low[0], high[0]), (low[1], high[1])


def colour_norm(one, values, source):
    """(norm, colour map, which ends of the bar go on) of these values: symmetric about 0 where signs count, and cut where less
    than one disk in a hundred is beyond."""
    values = values[np.isfinite(values)]
    if one.kind == "groups":
        n = max(len(source.groups), 1)
        return BoundaryNorm(np.arange(n + 1) - 0.5, n), ListedColormap([style.colour(k) for k in range(n)]), "neither"
    if one.kind == "diverging":
        largest = float(np.abs(values).max()) if len(values) else 0.0
        top = float(np.percentile(np.abs(values), 99)) if len(values) > 50 else largest
        if top < 1e-3 * largest:
            top = largest
        return Normalize(-(top or 1.0), top or 1.0), style.DIVERGING, "both" if top < largest else "neither"
    low, high = (float(values.min()), float(values.max())) if len(values) else (0.0, 1.0)
    top = float(np.percentile(values, 99)) if len(values) > 50 else high
    if top <= low + 1e-3 * (high - low):
        top = high
    if one.name in ("speed", "moved", "pressure"):
        low = 0.0
    return Normalize(low, top if top > low else low + (abs(low) or 1.0)), style.SEQUENTIAL, "max" if top < high else "neither"


def points_per_length(ax):
    """Points of print per unit of length, from the limits and the place of the axes."""
    box = ax.get_window_extent()
    width, height = (abs(np.diff(lim()))[0] for lim in (ax.get_xlim, ax.get_ylim))
    return min(box.width / width, box.height / height) * 72 / ax.figure.dpi


class Scene:
    """Disks of a result in `ax`, coloured by a quantity; `show(k)` moves all to frame k."""

    def __init__(self, source, ax, ks, color=None, network=False, first=0, marks=None, plain=False, region=None, bonds=False):
        self.source, self.ax, self.first, self.network, self.bonds = Source.of(source), ax, first, network, bonds
        self.one = None if plain else quantity(self.source, color)
        ax.set_xlim(*(reach := extent(self.source, ks, region))[0])
        ax.set_ylim(*reach[1])
        ax.set_aspect("equal")
        self.ends = "neither"
        colours = {"edgecolors": style.faint(), "facecolors": ax.get_facecolor()} if plain else {"edgecolors": "#404040"}
        self.disks = EllipseCollection([], [], [], units="xy", offsets=np.empty((0, 2)), transOffset=ax.transData, zorder=2,
                                       **colours)
        if not plain:
            sample = ks if len(ks) <= 20 else [ks[i] for i in np.linspace(0, len(ks) - 1, 20).astype(int)]
            values = np.concatenate([self.one.of(self.source, k, first)[self.source.in_play(k)] for k in sample])
            self.norm, cmap, self.ends = colour_norm(self.one, values, self.source)
            self.disks.set_norm(self.norm)
            self.disks.set_cmap(cmap)
            self.disks.cmap = self.disks.cmap.with_extremes(bad="#B5B5B5")
        self.radii = Line2D([], [], color=style.ink() if plain else "#9A9A9A" if network else "#202020", zorder=3)
        self.marks = marks
        self.walls = LineCollection([], colors=style.ink(), linewidths=1.3, zorder=1, capstyle="butt")
        self.forces = LineCollection([], zorder=4, capstyle="round")
        self.cracks = Line2D([], [], color=crack_colour(), ls="none", marker="x", zorder=5)
        self.moving = [self.walls, self.disks, self.radii, self.forces, self.cracks]
        for artist in self.moving:
            ax.add_artist(artist)
        self.mean_force = None
        self.before = {}  # frame shown before another one, if that is not the one before it in the file
        self.resize()

    def resize(self):
        """Widths of lines, from the size of the disks in print."""
        size = 2 * float(np.median(self.source.radius)) * points_per_length(self.ax)
        edge = float(np.clip(0.04 * size, 0.0, 0.7))
        self.thick = max(size, 1.0)
        self.line = min(0.09 * self.thick, 2.0)  # points, of the mean force
        self.with_marks = size > 5 if self.marks is None else self.marks
        self.disks.set_linewidths(edge)
        self.radii.set_linewidth(max(edge, 0.3))
        self.cracks.set(markersize=float(np.clip(0.5 * size, 3, 8)), markeredgewidth=float(np.clip(0.1 * size, 0.8, 1.5)))

    def show(self, k):
        """Moves all to frame k."""
        source = self.source
        which = np.flatnonzero(source.in_play(k))
        place, radius, angle = source.place(k)[which], source.radius[which], source.frame("angle", k)[which]
        images, own = [place], [np.arange(len(which))]
        lower, edges, periodic = source.box_at(k)
        offset = source.offset_at(k)
        for axis in np.flatnonzero(periodic)[::-1]:  # disks that stick out on one side are seen on the other
            for i in range(len(images)):
                for side, near in ((1, images[i][:, axis] - radius[own[i]] < lower[axis]),
                                   (-1, images[i][:, axis] + radius[own[i]] > lower[axis] + edges[axis])):
                    shift = np.zeros(2)
                    shift[axis] = side * edges[axis]
                    copy = images[i][near] + shift
                    if axis == 1 and offset:  # back into the box along x
                        copy[:, 0] = lower[0] + np.mod(copy[:, 0] + side * offset - lower[0], edges[0])
                    images.append(copy)
                    own.append(own[i][near])
        place, own = np.concatenate(images), np.concatenate(own)
        radius, angle = radius[own], angle[own]
        disks = self.disks
        disks._widths = disks._heights = radius  # half the lengths, as the collection keeps them
        disks._angles = np.zeros(len(radius))
        disks.set_offsets(place)
        if self.one:
            disks.set_array(np.ma.masked_invalid(self.one.of(source, k, self.first)[which][own]))
        if self.with_marks:
            tip = place + radius[:, None] * np.column_stack([np.cos(angle), np.sin(angle)])
            gap = np.full_like(tip, np.nan)  # one line is drawn much faster than a collection
            self.radii.set_data(*np.stack([place, tip, gap], axis=1).reshape(-1, 2).T)
        self.walls.set_segments(self._wall_lines(k))
        if self.network:
            self._show_forces(k)
        if self.bonds:
            self._show_bonds(k)
        if source.breaks:
            self._show_breaks(k)
        return self

    def _show_breaks(self, k):
        """Crosses where bonds have broken since the frame before; with `bonds` since the start."""
        breaks, times = self.source.breaks, self.source.frame_times
        shown = breaks["time"] <= times[k] * (1 + 1e-12)
        if not self.bonds:
            shown &= breaks["time"] > (times[self.before.get(k, k - 1)] if k else -np.inf)
        self.cracks.set_data(breaks["x"][shown], breaks["y"][shown])

    def _wall_lines(self, k):
        (x0, x1), (y0, y1) = self.ax.get_xlim(), self.ax.get_ylim()
        size, lines = 2 * np.hypot(x1 - x0, y1 - y0), []
        for kind, points, radius, angle in self.source.walls(k):
            if kind == CIRCLE:
                turn = np.linspace(0, 2 * np.pi, 361) + angle
                rim = points[0] + radius * np.column_stack([np.cos(turn), np.sin(turn)])
                lines += [rim, np.array([rim[0], points[0] + 0.96 * (rim[0] - points[0])])]
            elif kind == LINE:
                middle = np.array([(x0 + x1) / 2, (y0 + y1) / 2])
                along = (points[1] - points[0]) / np.hypot(*(points[1] - points[0]))
                foot = points[0] + along * ((middle - points[0]) @ along)
                lines.append(np.array([foot - size * along, foot + size * along]))
            else:
                lines.append(points)
        lower, edges, periodic = self.source.box_at(k)
        upper = lower + np.nan_to_num(edges)
        for axis in np.flatnonzero(periodic):
            low = np.where(np.arange(2) == axis, lower, [x0, y0])
            high = np.where(np.arange(2) == axis, upper, [x1, y1])
            for value in (lower[axis], upper[axis]):
                ends = np.array([low, high])
                ends[:, axis] = value
                lines.append(ends)
        return lines

    def _show_forces(self, k):
        """Lines from centre to contact, as wide as the normal force."""
        table = self.source.measured(k)["contacts"]
        force = table["force"]
        bearing = force > 0
        if self.mean_force is None and bearing.any():
            self.mean_force = float(force[bearing].mean())
        width = np.clip(force / (self.mean_force or 1.0) * self.line, 0, 0.5 * self.thick)
        lines, rows = self._halves(k, bearing)
        slides = (np.nan_to_num(table["sliding"]) * np.nan_to_num(table["tau"]))[rows] != 0
        self.forces.set_segments(lines)
        self.forces.set_linewidths(width[rows])
        self.forces.set_colors(np.where(slides[:, None], sliding_colour(), stuck_colour()) if len(slides) else [])

    def _show_bonds(self, k):
        """Bars from centre to centre, coloured by the forces of the bonds."""
        pulls = self.source.pulls(k)
        lines, rows = self._halves(k, np.isfinite(pulls))
        if self.forces.get_array() is None:
            top = float(np.percentile(np.abs(pulls[rows]), 98)) if len(rows) else 0.0
            self.forces.set(norm=Normalize(-(top or 1.0), top or 1.0), cmap=style.DIVERGING, linewidths=2 * self.line)
        self.forces.set_segments(lines)
        self.forces.set_array(pulls[rows])

    def _halves(self, k, which):
        """(lines, rows): of `which` of the measured contacts of frame k a line from each centre to the point of contact, and its row."""
        source, table = self.source, self.source.measured(k)["contacts"]
        point = np.column_stack([table["x"], table["y"]])
        n, place = len(source.radius), source.place(k)
        _, edges, periodic = source.box_at(k)
        lines, found = [], []
        for column in ("a", "b"):
            body = table[column].astype(int)
            own = np.flatnonzero(which & (body < n))
            centre, end = place[body[own]], point[own]
            for axis in np.flatnonzero(periodic)[::-1]:
                rows = np.round((end - centre)[:, axis] / edges[axis])
                end[:, axis] -= edges[axis] * rows
                if axis == 1:
                    end[:, 0] -= source.offset_at(k) * rows
            lines.append(np.stack([centre, end], axis=1))
            found.append(own)
        return np.concatenate(lines), np.concatenate(found)

    @property
    def mappable(self):
        return ScalarMappable(self.norm, self.disks.cmap)

    def colour_bar(self, place=None, below=False):
        """The bar beside the axes, as high as they are; below low ones; or in axes of its own."""
        one = self.one
        (x0, x1), (y0, y1) = self.ax.get_xlim(), self.ax.get_ylim()
        if place is not None:
            where = {"cax": place, "orientation": "horizontal" if below else "vertical"}
        elif y1 - y0 < 0.5 * (x1 - x0):
            where = {"ax": self.ax, "location": "bottom", "aspect": 50}
        else:
            where = {"cax": self.ax.inset_axes([1.03, 0, 0.035, 1])}
        bar = self.ax.figure.colorbar(self.mappable, label=style.label(one.text, one.unit), extend=self.ends, **where)
        if one.kind == "groups":
            bar.set_ticks(range(len(self.source.groups)), labels=self.source.groups)
        elif one.name in ("contacts",):
            bar.locator.set_params(integer=True)
        return bar


def stuck_colour():
    return np.array(to_rgba(style.ink()))


def sliding_colour():
    return np.array(to_rgba("#D55E00"))


def crack_colour():
    return np.array(to_rgba("#CC0000"))
