"""The look of pictures: colours, labels with units, one way to write a file."""
import contextlib
import io
import os

import matplotlib
import numpy as np
from matplotlib.figure import Figure

from .library import FileError, UserError

# Okabe and Ito's palette without its yellow, which is too light on white: told apart by colour-blind readers.
COLOURS = ["#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#7F7F7F"]
MARKERS = "os^Dv<>"
DIVERGING, SEQUENTIAL = "RdBu_r", "viridis"
ENDINGS = (".png", ".svg", ".pdf")
LOOK = {
    "font.family": ["DejaVu Sans"], "font.size": 9, "axes.labelsize": 9.5, "axes.titlesize": 10, "legend.fontsize": 8.5,
    "axes.linewidth": 0.7, "lines.linewidth": 1.2, "lines.markersize": 4, "legend.frameon": True, "legend.framealpha": 0.8, "legend.edgecolor": "none", "legend.fancybox": False,
    "errorbar.capsize": 2, "axes.formatter.limits": (-3, 4), "axes.formatter.use_mathtext": True,
    "axes.prop_cycle": matplotlib.cycler(color=COLOURS), "pdf.fonttype": 42, "svg.fonttype": "none", "svg.hashsalt": "slipdisk",
    "axes.titlelocation": "left", "axes.spines.top": False, "axes.spines.right": False,
}
DARK = {"figure.facecolor": "#101418", "axes.facecolor": "#101418", "savefig.facecolor": "#101418", "axes.edgecolor": "#C8CDD2",
        "axes.labelcolor": "#E6E9EC", "text.color": "#E6E9EC", "xtick.color": "#C8CDD2", "ytick.color": "#C8CDD2",
        "axes.prop_cycle": matplotlib.cycler(color=["#56B4E9", "#E69F00", "#29C493", "#E59AC4", "#F07F3C", "#8FB8FF", "#A8A8A8"])}


def look(dark=False):
    """All of it for a `with`; the settings of the caller are left alone."""
    return matplotlib.rc_context({**LOOK, **(DARK if dark else {})})


def ink():
    return matplotlib.rcParams["text.color"]


def faint():
    """Grey between text and paper, for guides."""
    text, paper = (np.array(matplotlib.colors.to_rgb(matplotlib.rcParams[key])) for key in ("text.color", "axes.facecolor"))
    return tuple(0.35 * text + 0.65 * paper)


def colour(k):
    cycle = matplotlib.rcParams["axes.prop_cycle"].by_key()["color"]
    return cycle[k % len(cycle)]


def plain(text, most=60):
    """A name, title or word of a deck or file as it is shown: no formula, nothing unprintable, not too long."""
    shown = "".join(c if c.isprintable() else "\N{REPLACEMENT CHARACTER}" for c in str(text))
    shown = shown if len(shown) <= most else shown[:most - 3] + "..."
    return shown.replace("$", r"\$")


def words(text):
    """A label without the marks of its formulas, for a terminal."""
    return text.replace("$", "").replace("\\", "")


def label(text, unit=""):
    """Name of an axis with its unit; numbers without a unit have none."""
    return f"{text} ({unit})" if unit not in ("", "1", None) and unit not in text.split() else text


def number(value, error=None):
    """A value for a legend, rounded as its error allows."""
    if error is None or not np.isfinite(error) or error <= 0:
        return f"{value:.4g}"
    if abs(value) < error * 1e-6:
        value = 0.0
    power = int(np.floor(np.log10(max(abs(value), error))))
    digits = max(power - int(np.floor(np.log10(error))) + 1, 0)
    if -3 <= power < 5:
        return f"{value:.{max(digits - power, 0)}f} ± {error:.{max(digits - power, 0)}f}"
    scale = 10.0 ** power
    return f"({value / scale:.{digits}f} ± {error / scale:.{digits}f})·10$^{{{power}}}$"


def axes_of(ax):
    """The axes to draw into: those given, else new ones of pyplot."""
    if ax is not None:
        return ax
    from matplotlib import pyplot
    return pyplot.subplots(layout="constrained")[1]


def guide(ax, y=None, x=None):
    for value, draw in ((y, ax.axhline), (x, ax.axvline)):
        if value is not None:
            draw(value, color=faint(), lw=0.8, zorder=0, gid="guide")


def legend(ax, **options):
    """A legend where something has a name."""
    if ax.get_legend_handles_labels()[0]:
        ax.legend(**options)


def thinned(x, y, most=4000):
    """A curve of many points as the least and the largest of each of most/2 stretches: what is drawn looks the same."""
    if len(x) <= most:
        return x, y
    n = len(x) // (most // 2)
    rows = len(x) // n
    block = y[:rows * n].reshape(rows, n)
    pick = np.sort(np.column_stack([block.argmin(1), block.argmax(1)]), axis=1) + n * np.arange(rows)[:, None]
    pick = np.unique(np.concatenate([pick.ravel(), np.arange(rows * n, len(x))]))
    return x[pick], y[pick]


def limit_log(ax, values, decades=10):
    """A logarithmic axis of y from the largest value downwards, not to rounding errors."""
    values = np.concatenate([np.ravel(v) for v in values])
    values = values[np.isfinite(values) & (values > 0)]
    if not len(values):
        return
    ax.set_yscale("log")
    top = values.max()
    ax.set_ylim(max(values.min() * 0.5, top * 10.0 ** -decades), top * 3)


class Picture(Figure):
    """A figure that a notebook shows, also without pyplot."""

    def _repr_png_(self):
        data = io.BytesIO()
        self.savefig(data, format="png", dpi=100)
        return data.getvalue()


def figure(width, height):
    return Picture(figsize=(width, height), layout="constrained")


@contextlib.contextmanager
def written(path):
    """A name to write to; the file gets its own name when all is well, else there is none. It has the mode of the one that it replaces."""
    folder, name = os.path.split(os.fspath(path))
    stem, ending = os.path.splitext(name)
    part = os.path.join(folder, f".{stem}.{os.getpid()}.part{ending}")
    try:
        with contextlib.suppress(FileNotFoundError):
            mode = os.stat(path).st_mode & 0o777
            os.close(os.open(part, os.O_WRONLY | os.O_CREAT | os.O_TRUNC | os.O_NOFOLLOW, 0o600))
            os.chmod(part, mode | 0o200)  # while it is written
        yield part
        with contextlib.suppress(FileNotFoundError):
            os.chmod(part, os.stat(path).st_mode & 0o777)
        os.replace(part, path)
    except FileError:
        raise
    except OSError as error:
        raise FileError(f"{path}: cannot be written: {error.strerror or error}") from None
    finally:
        with contextlib.suppress(OSError):
            os.unlink(part)


def check_ending(path, endings):
    ending = os.path.splitext(path)[1].lower()
    if ending not in endings:
        raise UserError(f"{path}: unknown ending {ending or '(none)'}; expected {', '.join(endings[:-1])} or {endings[-1]}")
    return ending


def save(picture, path, dpi):
    ending = check_ending(path, ENDINGS)
    with written(path) as part:
        picture.savefig(part, dpi=dpi, format=ending[1:], metadata={"Date": None} if ending == ".svg" else None)
