"""Curves of sweeps: a quantity against what is swept, with error bars, and with theory where there is one."""
from __future__ import annotations

import concurrent.futures
import fnmatch
import os
import warnings
from typing import TYPE_CHECKING, Any

import matplotlib
import numpy as np

from . import library as lib
from . import plot_style as style
from .arguments import ARGUMENTS, checked
from .plot_source import DERIVED, Source, is_sheared
from .plot_style import axes_of, guide, label
from .plot_theory import theory_row
from .result import Result, plain
from .sealed import read
from .sweep import Sweep

if TYPE_CHECKING:
    from matplotlib.axes import Axes

PALE = 0.35  # opacity of points whose error bar is not reliable
# (name, condition on a finished point): the first that a sweep has is drawn, what its deck measures for its own sake.
PREFERRED = (("*.mean", None), ("stress_ratio", None), ("pressure", is_sheared), ("*.omega", None), ("omega_rms", None), ("coordination", None), ("outflow", None),
             ("deviator_ratio", None), ("*.wall_normal", None), ("*.group_normal", None), ("*.disk_normal", None),
             ("z_backbone", lambda source: "packing_fraction" in source.series))

# Columns of frames.csv that a sweep can be drawn by, measured when asked for: (text, unit).
MEASURED = {"z": ("contacts per disk $z$", "1"), "z_bearing": ("load-bearing contacts per disk", "1"),
            "z_backbone": ("contacts per disk without rattlers $z$", "1"), "fraction": (r"packing fraction $\phi$", "1"),
            "fraction_inside": (r"packing fraction $\phi$ of closed cells", "1"), "pressure": ("pressure $p$", "force/length"),
            "deviator": ("deviator $q$", "force/length"), "anisotropy": ("anisotropy $a$", "1"), "mobilised_mean": (r"mean $|\tau|/\mu F_n$", "1"),
            "unbalanced": ("unbalanced force", "1")}


def keys(sweep):
    """Names of what is swept, the one with the most values first."""
    means = sweep.means
    names = means.dtype.names[1:means.dtype.names.index("replicas")]
    found = [name for name in names if len(np.unique(means[name][_known(means[name])])) > 1]
    return sorted(found, key=lambda name: -len(np.unique(means[name][_known(means[name])])))


def unit(sweep, name):
    """Unit of a column: of keys that are angles rad, of other keys none."""
    with read(os.path.join(sweep.folder, "table.h5")) as file:
        path = plain(file["parameters"].attrs.get(name, ""))
    return "rad" if path.endswith(("tilt", "phase", "angle")) else sweep.unit(name)


def _known(column):
    return column != "" if column.dtype.kind in "US" else np.isfinite(column)


def quantities(sweep):
    """Names of columns of means.csv that can be drawn."""
    names = sweep.means.dtype.names
    after = names[names.index("replicas") + 1:]
    return [name for name in after if not name.endswith(("_error", "_scatter"))]


def source_of(sweep, name):
    """The Source of a point, kept until the sweep is read again."""
    if name not in sweep._sources:
        sweep._sources[name] = Source(sweep.path(str(name)))
    return sweep._sources[name]


def first_source(sweep):
    """The Source of the first finished point; None without any."""
    done = np.flatnonzero(sweep["status"] == "done")
    return source_of(sweep, sweep["name"][done[0]]) if len(done) else None


def in_time(sweep):
    """{name: (unit, meaning)} of the columns of the series that can be drawn, as means over the measured time. If a box is not
    sheared, its pressure is that of the last state (MEASURED), in which it has come to rest."""
    source = first_source(sweep)
    if source is None:
        return {}
    skipped = {"time", "step", "start", "scale", *quantities(sweep), *(() if is_sheared(source) else MEASURED)}
    return {name: about for name, about in source.columns.items()
            if name not in skipped and (name in DERIVED or "." in name or not source.parts(name))}


def every_quantity(sweep):
    """{name: (unit, meaning, where it is from)} of all that a sweep can be drawn by."""
    own = {name: (sweep.unit(name), "", "columns of means.csv") for name in quantities(sweep)}
    series = {name: (*about, "means over the measured time of the series") for name, about in in_time(sweep).items()}
    return own | series | {name: (unit, style.words(text), "in the last state, as slipdisk measure has it") for name, (text, unit) in MEASURED.items()
                           if name not in own and name not in series}


def list_of(sweep):
    """Lines on what a sweep can be drawn by."""
    every, lines = every_quantity(sweep), []
    for group in dict.fromkeys(where for _, _, where in every.values()):
        lines += [f"--quantity, {group}:"]
        lines += [f"  {name:<24}{unit:<16}{text}".rstrip() for name, (unit, text, where) in every.items() if where == group]
    return [*lines, "--x:", *(f"  {name:<24}{unit(sweep, name)}".rstrip() for name in keys(sweep))]


def default_quantity(sweep):
    names, source = every_quantity(sweep), first_source(sweep)
    for wanted, condition in PREFERRED:
        found = next((name for name in names if fnmatch.fnmatchcase(name, wanted)), None)
        if found and (condition is None or source is not None and condition(source)):
            return found
    return next((name for name in names if name != "time"), "time")


def averaged(sweep, name):
    """(means, errors, reliable) over replicas of a column of the series, over the measured time; nan where no point of a set is
    done. The error is the larger of that from the error bars and from the scatter of replicas."""
    sets = sweep.means["set"]
    values, errors, reliable = (np.full(len(sets), np.nan) for _ in range(3))
    for row, one in enumerate(sets):
        points = np.flatnonzero((sweep["set"] == one) & (sweep["status"] == "done"))
        found = [source_of(sweep, sweep["name"][k]).averaged(name) for k in points]
        if found:
            means, bars = (np.array([getattr(record, part) for record in found]) for part in ("mean", "error"))
            values[row] = means.mean()
            scatter = np.std(means, ddof=1) / np.sqrt(len(found)) if len(found) > 1 else np.nan
            errors[row] = np.fmax(np.sqrt((bars**2).sum()) / len(found), scatter)
            reliable[row] = np.mean([record.converged for record in found])
    return values, errors if np.isfinite(errors).any() else None, reliable


def measured(sweep, name):
    """(means, errors) over replicas of a column of frames.csv of `slipdisk measure`, in the last state; nan where no point of a set
    is done."""
    table, sets = sweep.table, sweep.means["set"]
    found = {}
    for k in np.flatnonzero(table["status"] == "done"):
        source = source_of(sweep, table["name"][k])
        found.setdefault(int(table["set"][k]), []).append(float(source.measured(source.n_frames - 1)["frames"][name][0]))
    values = np.array([np.mean(found[int(s)]) if int(s) in found else np.nan for s in sets])
    errors = np.array([np.std(found[int(s)], ddof=1) / np.sqrt(len(found[int(s)])) if len(found.get(int(s), ())) > 1 else np.nan for s in sets])
    return values, errors if np.isfinite(errors).any() else None


def _error(means, name):
    """The larger of the error from error bars and from the scatter of replicas; None when there is neither."""
    found = [means[name + end] for end in ("_error", "_scatter") if name + end in means.dtype.names]
    found = [column for column in found if np.isfinite(column).any()]
    return np.fmax.reduce(found) if found else None


def theory(sweep):
    """{set: row of `slipdisk theory --csv`} of the sets with a finished point for whose deck there is a periodic solution."""
    decks, table = {}, sweep.table
    for k in np.flatnonzero(table["status"] == "done"):
        decks.setdefault(int(table["set"][k]), sweep.path(str(table["name"][k])))

    def row(path):
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", lib.Warning)
            return theory_row(Result(path).deck_full)
    sets = list(decks)
    if not sets or row(decks[sets[0]]) is None:
        return {}
    with concurrent.futures.ThreadPoolExecutor(os.cpu_count() or 1) as pool:
        rows = dict(zip(sets, pool.map(row, [decks[one] for one in sets])))
    return {one: found for one, found in rows.items() if found and np.isfinite(found.get("mean", np.nan))}


def _in_pi(values, unit):
    """Whether an axis of angles reads better in units of pi."""
    turns = values / np.pi
    return unit == "rad" and np.abs(turns).max() > 0 and np.allclose(turns, np.round(turns, 4), atol=1e-9)


def _log(values):
    values = np.unique(values)
    if len(values) < 3 or values[0] <= 0 or values[-1] / values[0] < 8:
        return False
    steps = np.diff(values)
    return np.ptp(np.diff(np.log(values))) < 0.5 * np.ptp(steps / steps.max()) * np.log(values[-1] / values[0]) or values[-1] / values[0] > 100


class Curves:
    """What of a sweep is drawn: `groups`, a list of (name, rows of means) with a curve each."""

    def __init__(self, sweep, x=None, quantity=None):
        self.sweep = sweep
        self.means = sweep.means
        all_keys = keys(sweep)
        if not all_keys:
            raise lib.UserError(f"{sweep.folder}: nothing in it is swept; expected a key with two values or more")
        numeric = [name for name in all_keys if self.means[name].dtype.kind not in "US"]
        self.x = x or (numeric or all_keys)[0]
        if self.x not in all_keys:
            raise lib.unknown(self.x, all_keys, f"the keys that {sweep.folder} sweeps")
        self.y = quantity or default_quantity(sweep)
        own, every = quantities(sweep), every_quantity(sweep)
        if self.y + ".mean" in own:  # the name of an average
            self.y += ".mean"
        if self.y not in every:
            raise lib.unknown(self.y, [*every], f"the quantities of {sweep.folder}")
        self.unit = every[self.y][0]
        x_values = self.means[self.x]
        self.words = sorted(set(x_values.tolist())) if x_values.dtype.kind in "US" else None
        self.xs = np.array([self.words.index(v) for v in x_values], float) if self.words else x_values.astype(float)
        self.pi = not self.words and _in_pi(self.xs[np.isfinite(self.xs)], unit(sweep, self.x))
        others = [name for name in all_keys if name != self.x]
        groups = {}
        for row in range(len(self.means)):
            known = [name for name in others if _known(self.means[name][row:row + 1])[0]]
            name = tuple((name, self.means[name][row].item()) for name in known)
            groups.setdefault(name, []).append(row)
        self.groups = [(self._text(name), np.array(sorted(rows, key=lambda r: self.xs[r]))) for name, rows in groups.items()]
        useful = [(name, rows) for name, rows in self.groups if np.isfinite(self.xs[rows]).sum() > 1]
        self.groups = useful or self.groups
        self.doubtful = np.zeros(len(self.means), bool)
        if self.y in own:
            self.values, self.errors = self.means[self.y].astype(float), _error(self.means, self.y)
            reliable = self.y.rpartition(".")[0] + ".converged" if self.y.endswith((".omega", ".scaled", ".mean")) else None
            if reliable in own:
                self.doubtful = self.means[reliable] < 1
        elif self.y in in_time(sweep):
            self.values, self.errors, reliable = averaged(sweep, self.y)
            self.doubtful = reliable < 1
        else:
            self.values, self.errors = measured(sweep, self.y)
        noise = np.zeros(len(self.values)) if self.errors is None else np.nan_to_num(self.errors)
        seen = np.where(np.abs(self.values) > 2 * noise, np.abs(self.values), 0.0)
        tops = [top for top in (seen[rows].max(initial=0) for _, rows in self.groups) if top > 0]
        self.apart = 1 < len(self.groups) <= 12 and len(tops) > 1 and max(tops) > 30 * min(tops)

    def _text(self, name):
        def one(key, value):
            if isinstance(value, str):
                return f"{style.plain(key)} = {style.plain(value)}"
            if unit(self.sweep, key) == "rad" and value and np.isclose(value / np.pi, np.round(value / np.pi, 4), atol=1e-9):
                factor = {1.0: "", -1.0: "-"}.get(turns := np.round(value / np.pi, 4), f"{turns:g}")
                return rf"{style.plain(key)} = {factor}$\pi$"
            return f"{style.plain(key)} = {value:.4g}"
        return ", ".join(one(*item) for item in name)


def _pale(ax, drawn, doubtful, marker):
    """Makes these points of an errorbar pale."""
    if not doubtful.any():
        return
    line, caps, bars = drawn.lines
    for part in (line, *caps):
        part.set_markevery([int(k) for k in np.flatnonzero(~doubtful)])
    for part in bars:
        part.set_alpha(np.where(doubtful, PALE, 1.0))
    ax.plot(line.get_xdata()[doubtful], line.get_ydata()[doubtful], marker, color=line.get_color(), mfc=ax.get_facecolor(), ms=4.5, alpha=PALE,
            gid="pale")


ARGUMENTS["Curves"] = (lambda value: isinstance(value, Curves)), "Curves"


@checked
def curve(result: lib.StrPath | Sweep, ax: Axes | None = None, *, x: str | None = None, quantity: str | None = None, only: int | None = None,
          with_theory: bool = True, curves: Curves | None = None, rows_of_theory: dict[int, Any] | None = None) -> Axes:
    """A quantity of a sweep (by default the rotation of the watched disk) against the key with the most values, a curve for each
    combination of the others; bars are one standard error, of replicas the larger of their own and of their scatter; pale where they
    are not reliable. `only`: the number of one of the curves."""
    ax = axes_of(ax)
    sweep = result if isinstance(result, Sweep) else Sweep(result)
    c = curves or Curves(sweep, x, quantity)
    only = only if only is None else lib.whole(only, "curve: only", 0, len(c.groups) - 1)
    if rows_of_theory is None:
        rows_of_theory = theory(sweep) if with_theory and c.y.endswith(".omega") else {}
    scale = np.pi if c.pi else 1.0
    drawn_theory = False
    for k, (name, rows) in enumerate(c.groups):
        if only is not None and k != only:
            continue
        good = rows[np.isfinite(c.values[rows]) & np.isfinite(c.xs[rows])]
        colour = style.colour(k) if len(c.groups) <= 7 else matplotlib.colormaps[style.SEQUENTIAL](0.85 * k / (len(c.groups) - 1))
        error = c.errors[good] if c.errors is not None else None
        marker = style.MARKERS[k % len(style.MARKERS)]
        drawn = ax.errorbar(c.xs[good] / scale, c.values[good], None if error is None else np.nan_to_num(error),
                            label=(name or None) if only is None else None, fmt=marker, color=colour, mfc=ax.get_facecolor(), lw=0.9, ms=4.5,
                            gid=f"curve {k}", ls="none" if rows_of_theory else "-")
        _pale(ax, drawn, c.doubtful[good], marker)
        expected = [(c.xs[r] / scale, rows_of_theory[int(c.means["set"][r])]["mean"]) for r in rows
                    if int(c.means["set"][r]) in rows_of_theory]
        if expected:
            ax.plot(*np.array(expected).T, color=colour, lw=1.0, ls="--", marker="", gid=f"theory {k}")
            drawn_theory = True
    if drawn_theory:
        ax.plot([], [], color=style.ink(), lw=1.0, ls="--", label="theory")
    pale = bool((c.doubtful & np.isfinite(c.values) & np.isfinite(c.xs)).any())
    if pale:
        ax.plot([], [], "o", color=style.ink(), mfc=ax.get_facecolor(), ms=4.5, alpha=PALE, label="pale: error bar\nnot reliable yet")
    if c.words:
        ax.set_xticks(range(len(c.words)), [style.plain(word, 24) for word in c.words])
    elif _log(c.xs[np.isfinite(c.xs)]):
        ax.set_xscale("log")
    if c.y.endswith((".omega", ".scaled")):
        guide(ax, y=0)
    ax.set_xlabel(f"{style.plain(c.x)} / π" if c.pi else label(style.plain(c.x), unit(sweep, c.x)))
    names = {"omega": r"mean angular velocity $\Omega$", "scaled": r"$t_g\Omega$"}
    disk, _, what = c.y.rpartition(".")
    text = f"{names[what]} of {style.plain(disk)}" if what in names else style.plain(c.y).replace("_", " ")
    text = f"average {style.plain(disk)}" if what == "mean" else text
    if c.y in MEASURED and c.y not in quantities(sweep):
        text = MEASURED[c.y][0]
    ax.set_ylabel(label(text, c.unit))
    if only is not None:
        ax.set_title(c.groups[only][0], fontsize=9)
        if (drawn_theory or pale) and only == 0:
            ax.legend(loc="best")
    elif len(c.groups) > 1 or drawn_theory or pale:
        n = len(c.groups) + drawn_theory + 2 * pale
        ax.legend(loc="center left", bbox_to_anchor=(1.01, 0.5), ncol=1 + n // 24)
    return ax
