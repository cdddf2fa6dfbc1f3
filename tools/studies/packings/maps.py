"""Pictures of packings: disks coloured by a quantity, contacts as lines as wide as their forces, walls."""
import numpy as np
from matplotlib.cm import ScalarMappable
from matplotlib.collections import EllipseCollection, LineCollection
from matplotlib.colors import SymLogNorm
from matplotlib.ticker import FuncFormatter

from ratchet.style import BLACK, GREY, plt, power

DIVERGING = "RdBu_r"


def disks(axes, x, y, radius, colours, edge=GREY, width=0.4):
    size = 2 * np.asarray(radius)
    axes.add_collection(EllipseCollection(size, size, np.zeros(len(size)), units="xy", facecolors=colours,
                                          edgecolors=edge, linewidths=width, offsets=np.column_stack([x, y]),
                                          transOffset=axes.transData, zorder=2))


def contacts(axes, segments, force, widest=3.0, colour=BLACK):
    """Lines along contacts [n][2][2]; the mean force is a third of the widest line."""
    if len(segments) == 0:
        return
    width = np.clip(force / max(force.mean(), 1e-300) * widest / 3, 0, 2 * widest)
    keep = width > 0.02
    axes.add_collection(LineCollection(segments[keep], linewidths=width[keep], colors=colour, zorder=3,
                                       capstyle="round"))


def walls(axes, run, reach):
    """Walls within reach of ((x0, x1), (y0, y1))."""
    (x0, x1), (y0, y1) = reach
    size = max(x1 - x0, y1 - y0)
    for kind, points, radius in run.walls():
        if kind == "round":
            axes.add_patch(plt.Circle(points[0], radius, fill=False, lw=1.4, color=BLACK, zorder=1))
            continue
        ends = np.array(points)
        if kind == "line":
            direction = (ends[1] - ends[0]) / np.hypot(*(ends[1] - ends[0]))
            ends = np.array([ends[0] - 3 * size * direction, ends[0] + 3 * size * direction])
        axes.plot(*ends.T, color=BLACK, lw=1.4, zorder=1, solid_capstyle="butt")


def scale(values, clip=None):
    """Symmetric colours: logarithmic beyond a tenth of the rms, cut at clip (the largest value when None)."""
    values = np.asarray(values)
    rms = float(np.sqrt(np.mean(values ** 2))) or 1.0
    top = clip or float(np.abs(values).max()) or 1.0
    return SymLogNorm(min(0.1 * rms, 0.5 * top), linscale=0.5, vmin=-top, vmax=top, base=10)


def _ticks(norm):
    """Zero, and powers of ten beyond the linear part, few enough not to touch."""
    first = int(np.ceil(np.log10(4 * norm.linthresh)))
    last = int(np.floor(np.log10(norm.vmax)))
    powers = [10.0 ** k for k in range(first, last + 1)] or [norm.vmax]
    return [-p for p in powers[::-1]] + [0.0] + powers


def frame(axes, x, y, radius, margin=0.6, bottom=None):
    reach = tuple((float(np.min(c - radius)), float(np.max(c + radius))) for c in (x, y))
    rim = margin * float(np.max(radius))
    axes.set_xlim(reach[0][0] - rim, reach[0][1] + rim)
    axes.set_ylim((reach[1][0] if bottom is None else bottom) - rim, reach[1][1] + rim)
    axes.set_aspect("equal")
    axes.minorticks_off()
    return reach


def rotation_map(axes, run, norm, network=True, edge=GREY, width=0.4, widest=2.4):
    """A packing coloured by the mean angular velocities of its disks, with its contacts at the end of the run."""
    colours = plt.get_cmap(DIVERGING)(norm(run.omega))
    disks(axes, run.x_end, run.y_end, run.radius, colours, edge, width)
    if network:
        segments, force = run.contact_lines()
        contacts(axes, segments, force, widest)
    reach = frame(axes, run.x_end, run.y_end, run.radius)
    walls(axes, run, reach)
    axes.set_xlabel("$x$ (m)")
    axes.set_ylabel("$y$ (m)")


def colour_bar(picture, axes, norm, label, **more):
    symmetric = isinstance(norm, SymLogNorm)
    if symmetric:
        more["ticks"] = _ticks(norm)
        more["format"] = FuncFormatter(lambda value, _: f"${power(value, 2)}$")
    bar = picture.colorbar(ScalarMappable(norm, DIVERGING if symmetric else "viridis"), ax=axes, label=label, **more)
    if symmetric:
        bar.ax.minorticks_off()
    return bar
