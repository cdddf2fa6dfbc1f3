"""Time to a given error: how far time step and noise interval can be raised, and what that buys.

Random vibration is looked at in three ways: time step at the same noise (pairs of runs differ by the step alone), noise
interval at a fixed step, and both together, as the paper draws its noise. Turning supports have no noise. A setting
counts as good as the finer ones when Omega differs from their mean by less than ALLOWED, or by no more than chance does
in one case of a hundred; the settings of a series are looked at from the finest on, up to the first that fails.
"""
import dataclasses
import math

import numpy as np

from .page import Figure, Numbers, Section
from .style import COLOURS, figure, legend_above

PI = math.pi
AIM = 0.01      # the error that is asked for, relative to Omega
ALLOWED = 0.01  # difference that counts as none, relative to Omega
LEVEL = 2.576   # errors that a difference exceeds by chance in one case of a hundred
SETTLE = 1.0    # time units before random vibration is measured, as in the decks
REST = 0.5      # the same with turning supports
PERIOD = 0.1
INTEGRATORS = (("gear5", "Gear"), ("verlet", "Verlet"))
PHASES = ((0.0, "in phase"), (PI, "opposite phases"))


@dataclasses.dataclass
class Setting:
    """A setting and what it gives. change, spread: of Omega against the finer settings, and its error, relative."""
    dt: float
    h: float        # time between draws of the noise; nan without
    value: float    # t_g Omega (random), or largest change of Omega (turning)
    error: float
    ns: float       # per step
    runs: int
    measured: float  # time, of all runs
    change: float = math.nan
    spread: float = math.nan
    good: bool = False
    cost: float = math.nan  # core-seconds to AIM


@dataclasses.dataclass
class Series:
    name: str
    title: str
    raised: str      # "dt" or "h"
    integrator: str
    settings: list

    def best(self):
        """The coarsest setting that is as good as the finest; None when there is nothing to compare."""
        good = [s for s in self.settings if s.good]
        return good[-1] if len(self.settings) > 1 and good else None


def setting(rows):
    """Mean over runs that differ in their seed; needs dt of each."""
    value, error = (np.array([row[f"upper.{key}"] for row in rows]) for key in ("scaled", "scaled_error"))
    return Setting(rows[0]["dt"], rows[0]["h"], float(value.mean()), float(np.sqrt(np.sum(error ** 2)) / len(rows)),
                   float(np.median([row["ns_per_step"] for row in rows])), len(rows),
                   float(sum(row["upper.measured"] for row in rows)))


def by_setting(table, raised):
    """Rows of equal dt and h, the finest first."""
    groups = {}
    for row in table.rows:
        groups.setdefault((round(row["dt"], 12), round(row["h"], 12)), []).append(row)
    return [groups[key] for key in sorted(groups, key=lambda k: k[raised == "h"])]


def random_series(name, title, raised, table, paired):
    """Series of both integrators. paired: the same seed is the same noise at all settings."""
    out = []
    for integrator, word in INTEGRATORS:
        groups = by_setting(table.where(integrator=integrator), raised)
        series = Series(name, f"{title}, {word}", raised, integrator, [setting(rows) for rows in groups])
        (compare_pairs if paired else compare)(series.settings, groups)
        random_cost(series.settings)
        out.append(series)
    return out


def compare(settings, _=None):
    """Each setting against the weighted mean of the finer ones that were as good."""
    mean, weight, fine = math.nan, 0.0, True
    for k, s in enumerate(settings):
        if k:
            s.change = s.value / mean - 1
            s.spread = math.hypot(s.error, 1 / math.sqrt(weight)) / abs(mean)
            fine = fine and abs(s.change) <= max(ALLOWED, LEVEL * s.spread)
        s.good = fine
        if fine and s.error > 0:
            mean = ((0 if k == 0 else mean * weight) + s.value / s.error ** 2) / (weight + 1 / s.error ** 2)
            weight += 1 / s.error ** 2


def compare_pairs(settings, groups):
    """Each setting against the finest one, seed by seed; the error is that of the mean of the differences."""
    if not groups:
        return
    first = {row["noise"]: row["upper.scaled"] for row in groups[0]}
    unit, fine = abs(settings[0].value), True
    for k, (s, rows) in enumerate(zip(settings, groups)):
        gaps = np.array([row["upper.scaled"] - first[row["noise"]] for row in rows if row["noise"] in first])
        if k and len(gaps) > 1:
            s.change = float(gaps.mean()) / unit * math.copysign(1, settings[0].value)
            s.spread = float(gaps.std(ddof=1)) / math.sqrt(len(gaps)) / unit
            fine = fine and abs(s.change) <= max(ALLOWED, LEVEL * s.spread)
        s.good = fine


def random_cost(settings):
    """Core-seconds until the error bar is AIM: it falls as one over the root of the time, and its size at a time is
    taken from all settings of the series that are good, as it is the same for them."""
    noise = [s.error ** 2 * s.measured for s in settings if s.good]
    for s in settings:
        if s.good and s.value and noise:
            time = float(np.mean(noise)) / (AIM * s.value) ** 2
            s.cost = 1e-9 * s.ns * (SETTLE + time) / s.dt


def turning_series(table):
    """Per integrator and phase. Of the runs of a step (amplitudes, tilts) the one whose Omega changes most counts."""
    out = []
    for phase, title in PHASES:
        for integrator, word in INTEGRATORS:
            part = table.where(phase=phase, integrator=integrator)
            settings = [turning_setting(part, dt) for dt in part.values("dt")]
            fine = True
            for s in settings:
                fine = fine and not abs(s.value) > max(ALLOWED, LEVEL * s.error)
                s.good, s.change, s.spread = fine, s.value, s.error
            if settings:
                settings[0].change = settings[0].spread = math.nan
            out.append(Series("error_turning", f"{title}, {word}", "dt", integrator, settings))
    return out


def turning_setting(part, dt):
    rows, worst, error, time = part.where(dt=dt).rows, 0.0, 0.0, 0.0
    finest = part.where(dt=part.values("dt")[0])
    for row in rows:
        reference = finest.where(theta_b=row["theta_b"], tilt=row["tilt"]).rows
        if not reference:
            continue
        unit = abs(reference[0]["upper.omega"])
        change = (row["upper.omega"] - reference[0]["upper.omega"]) / unit * math.copysign(1, reference[0]["upper.omega"])
        if abs(change) >= abs(worst):
            worst = change
            error = math.hypot(row["upper.omega_error"], reference[0]["upper.omega_error"]) / unit
        used = row["upper.measured"] - row["upper.transient"]
        needed = used * (row["upper.omega_error"] / (AIM * unit)) ** 2 if unit else 0.0
        time = max(time, REST + row["upper.transient"] + max(PERIOD, needed))
    ns = float(np.median([row["ns_per_step"] for row in rows]))
    return Setting(dt, math.nan, worst, error, ns, len(rows), float(sum(row["upper.measured"] for row in rows)),
                   cost=1e-9 * ns * time / dt)


def tables(results):
    """The sweeps with the columns dt and h."""
    out = {name: results.sweep(name) for name in ("error_both", "error_step", "error_interval", "error_turning")}
    for row in out["error_both"].rows:
        row["h"] = row["dt"]
    for row in out["error_step"].rows:
        row["h"] = row["dt"] * row["interval"]
    for row in out["error_interval"].rows:
        row["dt"] = row["time"] / row["steps"]
        row["h"] = row["dt"] * row["interval"]
    return out


def sections(results):
    found = tables(results)
    both = random_series("error_both", "step and interval together", "dt", found["error_both"], False)
    step = random_series("error_step", "step, noise every 2&times;10<sup>&minus;4</sup>", "dt", found["error_step"], True)
    interval = random_series("error_interval", "interval, step 2&times;10<sup>&minus;5</sup>", "h",
                             found["error_interval"], False)
    turning = turning_series(found["error_turning"])
    everything = [*both, *step, *interval, *turning]
    out = Section("errors", "How far time step and noise interval can be raised", "Core-time until the error bar of &Omega; "
                  "is 1 %, at the largest setting that leaves &Omega; as it is. <i>dt</i>: time step; <i>h</i>: time between "
                  "draws of the noise.", new=True, missing=[line for table in found.values() for line in table.missing])
    out.figures.append(draw(both, step, interval, turning))
    out.tables.append(summary(everything))
    details = Section("errors-settings", "All settings", "Random vibration: &epsilon;<sub>b</sub> = 10<sup>&minus;4</sup>, "
                      "tilt 0.04&pi;; decks <code>inputs/paper/error_both.cfg</code> (noise drawn at each step), "
                      "<code>error_step.cfg</code> (the same noise at all steps: pairs of runs), "
                      "<code>error_interval.cfg</code>. Turning supports: <code>error_turning.cfg</code>, &Theta;<sub>b</sub> "
                      "= 0.004 and 0.04, tilt 0.02&pi; and 0.06&pi;; the run that changes most counts. A setting is good when "
                      "&Omega; differs from the mean of the finer ones (pairs, turning supports: from the finest) by less "
                      f"than {100 * ALLOWED:g} %, or by less than {LEVEL:g} errors of the difference (chance exceeds that in "
                      "one case of a hundred), and all finer ones are good. Core-time follows from the error bars of all good "
                      "settings and the measured time of a step; with turning supports it is that of the transient and one "
                      "period, or as many as the error bar wants.", new=True)
    details.tables += [Numbers(title, columns, rows) for title, columns, rows in
                       (side_by_side(everything[k:k + 2]) for k in range(0, len(everything), 2)) if rows]
    details.tables += [numbers(series) for series in everything if series.settings]
    return [out, details]


def number(value):
    return f"{value:.3g}" if math.isfinite(value) else ""


def with_error(value, error):
    """As -1.0 &plusmn; 2.7: two digits of the error, three decimals at most."""
    if not math.isfinite(value):
        return ""
    digits = min(3, max(0, 1 - math.floor(math.log10(error)))) if error > 0 else 3
    return f"{value:.{digits}f} &plusmn; {error:.{digits}f}"


def side_by_side(pair):
    """A series with Gear and with Verlet: change of Omega with Gear, cost with both."""
    gear, verlet = ({(s.dt, s.h if s.h == s.h else 0): s for s in series.settings} for series in pair)
    turning, rows = pair[0].name == "error_turning", []
    for key in sorted({*gear} & {*verlet}, key=lambda key: key[pair[0].raised == "h"]):
        a, b = gear[key], verlet[key]
        rows.append([number(a.dt), *([] if turning else [number(a.h)]), with_error(100 * a.change, 100 * a.spread),
                     "yes" if a.good and b.good else "no", number(a.cost if a.good else math.nan),
                     number(b.cost if b.good else math.nan)])
    kind = "Turning supports" if turning else "Random vibration"
    return (f"{kind}: {pair[0].title.rsplit(',', 1)[0]}",
            ["<i>dt</i>", *([] if turning else ["<i>h</i>"]), "change of &Omega; (Gear), %", "good", "core-s to 1 %, Gear",
             "Verlet"], rows)


def paper_cost(series):
    """Cost of the paper's way, Gear at the finest step of all, among series of one kind."""
    first = [s.settings[0] for s in series if s.integrator == "gear5" and s.settings]
    return min(first, key=lambda s: s.dt).cost if first else math.nan


def summary(everything):
    kinds = {name: [s for s in everything if (s.name == "error_turning") == (name == "turning")]
             for name in ("random", "turning")}
    rows = []
    for series in everything:
        best = series.best()
        if not best:
            continue
        kind = "turning" if series.name == "error_turning" else "random"
        same = [s for s in kinds[kind] if kind == "random" or s.title.split(",")[0] == series.title.split(",")[0]]
        ends = best is series.settings[-1]
        rows.append([("random: " if kind == "random" else "turning: ") + series.title, number(best.dt), number(best.h),
                     with_error(100 * best.change, 100 * best.spread), "all tried" if ends else "", number(best.cost),
                     number(paper_cost(same) / best.cost)])
    return Numbers("How far they can be raised", ["", "largest <i>dt</i>", "<i>h</i>", "change of &Omega;, %", "",
                                                  "core-s to 1 %", "times as fast as Gear at the finest step"], rows,
                   shown=True)


def numbers(series):
    turning = series.name == "error_turning"
    rows = [[s.dt, *([] if turning else [s.h, s.value, s.error]), 100 * s.change, 100 * s.spread,
             "yes" if s.good else "no", s.runs, s.measured, s.ns, s.cost if s.good else math.nan]
            for s in series.settings]
    kind = "Turning supports" if turning else "Random vibration"
    return Numbers(f"{kind}: {series.title}",
                   ["<i>dt</i>", *([] if turning else ["<i>h</i>", "<i>t<sub>g</sub></i>&Omega;", "error"]),
                    "change, %", "error, %", "as good", "runs", "measured time", "ns per step", "core-s to 1 %"], rows,
                   kept=False)


def draw(both, step, interval, turning):
    picture, axes = figure(2, 2, height=6.6, width=7.2)
    panel = axes[0, 0]
    for n, (lines, word) in enumerate(((both, "$h=dt$"), (interval, r"$dt=2\times10^{-5}$"))):
        for k, series in enumerate(lines):
            mark(panel, series, "h", lambda s: 1e4 * s.value, lambda s: 1e4 * s.error, 2 * n + k, word)
    panel.set_xlabel(r"noise interval $h$")
    panel.set_ylabel(r"$t_g\,\Omega\times10^{4}$")
    panel.set_title("random vibration", pad=38)
    panel = axes[0, 1]
    for k, series in enumerate(step):
        mark(panel, series, "dt", lambda s: 100 * s.change, lambda s: 100 * s.spread, k, "the same noise")
    panel.axhspan(-100 * ALLOWED, 100 * ALLOWED, color="#EEEEEE", zorder=0, gid="guide")
    panel.set_xlabel(r"time step $dt$")
    panel.set_ylabel(r"change of $\Omega$ (%)")
    panel.set_title(r"random vibration, $h=2\times10^{-4}$", pad=38)
    panel = axes[1, 0]
    for k, series in enumerate(turning):
        mark(panel, series, "dt", lambda s: 100 * abs(s.change), lambda s: 0, k, series.title.split(",")[0])
    panel.axhline(100 * ALLOWED, color="#BBBBBB", lw=0.8, zorder=0, gid="guide")
    panel.set_yscale("log")
    panel.set_xlabel(r"time step $dt$")
    panel.set_ylabel(r"largest change of $\Omega$ (%)")
    panel.set_title("turning supports", pad=38)
    panel = axes[1, 1]
    for k, (series, x, word) in enumerate(((*((s, "dt", "$h=dt$") for s in both),
                                            *((s, "h", r"$dt=2\times10^{-5}$") for s in interval),
                                            *((s, "dt", r"$h=2\times10^{-4}$") for s in step)))):
        mark(panel, series, x, lambda s: s.cost if s.good else math.nan, lambda s: 0, k, word)
    panel.set_yscale("log")
    panel.set_xlabel(r"$dt$, or $h$ where $dt$ is fixed")
    panel.set_ylabel("core-seconds to 1 %")
    panel.set_title("random vibration", pad=52)
    for panel in axes.flat:
        panel.set_xscale("log")
        if panel.get_legend_handles_labels()[0]:
            legend_above(panel, 2, fontsize=8.5, labelspacing=0.2, handlelength=1.2)
    return Figure("errors", picture, "Random vibration against the noise interval (above left; Gear and Verlet see the "
                  "same noise and nearly coincide); change of &Omega; with the time step at the same noise (above "
                  "right; grey: counted as none) and with turning supports (below left); core-time until the error "
                  "bar is 1 % (below right). Filled: as good as the finer settings.",
                  "Rotation against time step and noise interval, and the time to an error of one per cent")


def mark(panel, series, x, y, error, k, word):
    """Points of a series, filled where good; the integrators a little apart."""
    shift = 1.06 if series.integrator == "verlet" else 1 / 1.06
    shown = [s for s in series.settings if math.isfinite(y(s))]
    sign, colour = "osv^D<"[k], COLOURS[k]
    label = f"{word}, {dict(INTEGRATORS)[series.integrator]}"
    for s in shown:
        panel.errorbar(shift * getattr(s, x), y(s), yerr=error(s) or None, fmt=sign, ms=5, color=colour, mew=1.0, lw=0,
                       elinewidth=0.9, mfc=colour if s.good else "white", label=label)
        label = None
