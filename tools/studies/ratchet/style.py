"""One look for all figures: sizes, fonts, colours, and the markers that the paper's captions name."""
import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402  (after the choice of a backend without a display)
from matplotlib.ticker import FuncFormatter  # noqa: E402

WIDTH = 6.4  # inches; text of 10 points is then about that of the page

# Okabe and Ito's palette without its yellow, which is too light on white: told apart by colour-blind readers.
COLOURS = ["#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000", "#7F7F7F"]
BLACK, GREY, LIGHT = "#111111", "#7A7A7A", "#C8C8C8"

TILT_MARKERS = {0: "o", 0.02: "v", 0.04: "^", 0.06: "s", 0.08: "D"}  # fig. random-ex-vel; tilt/pi
RANDOM_MARKERS = {2e-5: "o", 4e-5: "v", 6e-5: "^", 8e-5: "s", 1e-4: "D"}  # fig. random-ex-tilt
TURNING_MARKERS = {1e-3: "o", 4e-3: "s", 7e-3: "+", 1e-2: "*", 4e-2: ">", 7e-2: "<", 1e-1: "v"}  # sync-vel
CONFIGURATIONS = {"pp": ("$S^{++}$", "o"), "pm": ("$S^{+-}$", "^"), "mp": ("$S^{-+}$", "v"),
                  "mm": ("$S^{--}$", "s"), "stick": ("a contact sticks", "x"), "open": ("a contact is open", "D")}

plt.rcParams.update({
    "font.family": "STIXGeneral", "mathtext.fontset": "stix", "font.size": 11,
    "axes.labelsize": 12, "axes.titlesize": 11, "legend.fontsize": 10, "xtick.labelsize": 10, "ytick.labelsize": 10,
    "axes.linewidth": 0.8, "lines.linewidth": 1.1, "lines.markersize": 5,
    "xtick.direction": "in", "ytick.direction": "in", "xtick.top": True, "ytick.right": True,
    "xtick.minor.visible": True, "ytick.minor.visible": True,
    "legend.frameon": False, "errorbar.capsize": 2, "figure.dpi": 100, "savefig.dpi": 180, "figure.max_open_warning": 0,
    "axes.formatter.use_mathtext": True, "axes.formatter.limits": (-3, 4), "pdf.fonttype": 42,
})


def marker(table, value, k=0):
    """(k, marker) that belong to this value in all figures: the paper's marker, else one of others."""
    for rank, (known, sign) in enumerate(table.items()):
        if abs(value - known) <= 1e-6 * max(abs(known), 1e-6):
            return rank, sign
    return len(table) + k, "oxPXdph8"[k % 8]


def figure(columns=1, rows=1, width=WIDTH, height=None, legend=False, **more):
    """(figure, axes), laid out without overlaps; legend: a row below is kept free for legend_below."""
    height = height or 0.62 * width / columns * rows + 0.3
    if not legend:
        return plt.subplots(rows, columns, figsize=(width, height), layout="constrained", **more)
    picture = plt.figure(figsize=(width, height + 0.3), layout="constrained")
    above, below = picture.subfigures(2, 1, height_ratios=[height, 0.3])
    picture.legend_place = below
    return picture, above.subplots(rows, columns, **more)


def legend_below(picture, axes, columns=4, **more):
    """Legend of the first of the axes that has something to say, in the row that figure(legend=True) kept."""
    for one in axes if hasattr(axes, "__len__") else [axes]:
        handles, labels = one.get_legend_handles_labels()
        if handles:
            picture.legend_place.legend(handles, labels, loc="center", ncol=columns, **more)
            return


def points(axes, x, y, error, label, k, sign, line="-", **more):
    """Measured points with error bars, joined by a thin line; k-th colour."""
    options = {"color": COLOURS[k % len(COLOURS)], "mfc": "white", "mew": 1.0, "lw": 0.7, "elinewidth": 0.9}
    options.update(more)
    return axes.errorbar(x, y, yerr=error, fmt=sign, ls=line, label=label, **options)


def configuration(name):
    """Colour, symbol and label of a sliding configuration, the same in all figures: arguments of points()."""
    k = list(CONFIGURATIONS).index(name)
    return {"k": k, "sign": CONFIGURATIONS[name][1], "label": CONFIGURATIONS[name][0]}


def zero_line(axes):
    axes.axhline(0, color=LIGHT, lw=0.8, zorder=0, gid="guide")


def mark_empty(picture):
    """Says so in axes that show guides only: their points have not been run yet. Returns how many there are."""
    empty = 0
    for axes in picture.get_axes():
        shown = [a for a in (*axes.lines, *axes.collections, *axes.patches) if a.get_gid() != "guide"]
        if axes.axison and not shown:
            axes.text(0.5, 0.6, "no data yet", transform=axes.transAxes, ha="center", va="center", color=GREY)
            empty += 1
    return empty


def legend_right(axes, title=None, **more):
    """Legend beside the axes, never on the data."""
    return axes.legend(loc="center left", bbox_to_anchor=(1.01, 0.5), title=title, borderaxespad=0.3, **more)


def legend_above(axes, columns=4, **more):
    """Legend above the axes, in columns."""
    options = {"columnspacing": 1.2, "handletextpad": 0.5}
    options.update(more)
    return axes.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncol=columns, **options)


def in_pi(axis, step=None):
    """Ticks of an axis of angles, which is drawn in units of pi."""
    if step:
        axis.set_major_locator(matplotlib.ticker.MultipleLocator(step))
    axis.set_major_formatter(FuncFormatter(pi_label))


def pi_label(x, _=None):
    x = round(x, 9)
    return "0" if x == 0 else "$\\pi$" if x == 1 else "$-\\pi$" if x == -1 else f"${x:g}\\pi$"


def power(x, digits=3):
    """x as text for mathtext: 4 x 10^-5 without the dollars."""
    text = f"{x:.{digits}g}"
    if "e" not in text and 1e-2 <= abs(x) < 1e4 or x == 0:
        return text
    mantissa, exponent = f"{x:.{digits - 1}e}".split("e")
    mantissa = mantissa.rstrip("0").rstrip(".") if "." in mantissa else mantissa
    return f"10^{{{int(exponent)}}}" if mantissa == "1" else f"{mantissa}\\times10^{{{int(exponent)}}}"
