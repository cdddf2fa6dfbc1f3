"""Do the results depend on the time step, the integrator, the noise interval, the seed?"""
import math

import numpy as np
from matplotlib.ticker import NullFormatter

from .data import Table
from .page import Figure, Numbers, Section
from .style import COLOURS, figure, legend_above, points
from .turning import OMEGA_B
from .verdict import Claim, chi_square, decide, scattering, missing, number, percent

PI = math.pi
INTEGRATORS = (("gear5", "Gear"), ("verlet", "Verlet"))
SCALE = 1e4


def sections(results):
    out = Section("convergence", "Convergence", "Random vibration (&epsilon;<sub>b</sub> = 10<sup>&minus;4</sup>, tilt "
                  "0.04&pi;) at a fixed measured time: time step and integrator (decks "
                  "<code>inputs/paper/step.cfg</code>, <code>step_turning.cfg</code>), steps between draws of the "
                  "noise (<code>interval.cfg</code>), seeds (<code>seeds.cfg</code>). Another time step is another "
                  "realisation of the noise, while the two integrators see the same one; turning supports have no "
                  "noise and show the step's own effect.", new=True)
    tables = {name: results.sweep(name) for name in ("step", "step_turning", "interval", "seeds")}
    out.missing = [line for table in tables.values() for line in table.missing]
    picture, axes = figure(2, 2, height=5.8)
    step(axes[0, 0], over_noise(tables["step"]))
    turning(axes[0, 1], tables["step_turning"].joined())
    interval(axes[1, 0], tables["interval"].joined())
    seeds(axes[1, 1], tables["seeds"])
    for panel in axes[0]:
        panel.set_xlim(7e-7, 3e-5)
        panel.xaxis.set_minor_formatter(NullFormatter())
    for panel in (axes[0, 0], axes[1, 0], axes[1, 1]):
        panel.set_ylabel(r"$t_g\,\Omega\times10^{4}$")
    out.figures.append(Figure("convergence", picture, "Random vibration against time step, noise interval and seed "
                              "(points with error bars; grey: mean of the seeds with its error); turning supports: "
                              "change of &Omega; relative to the smallest step.", "Convergence of the angular velocity "
                              "in time step and noise interval, and its scatter over seeds"))
    out.claims = [step_claim(over_noise(tables["step"])), integrator_claim(tables),
                  turning_claim(tables["step_turning"].joined()), interval_claim(tables["interval"].joined()),
                  seeds_claim(tables["seeds"])]
    out.tables += [
        numbers("Time step, random vibration", over_noise(tables["step"]), ("dt", "integrator")),
        numbers("Time step, turning supports", tables["step_turning"].joined(), ("phase", "dt", "integrator")),
        numbers("Noise interval", tables["interval"].joined(), ("interval",)),
        numbers("Seeds", tables["seeds"], ("replica", "seed"))]
    return [out]


def numbers(title, table, names):
    return Numbers(title, [*names, "&Omega;", "error", "<i>t<sub>g</sub></i>&Omega;", "transient", "residual",
                           "ns per step"], [[*(row[n] for n in names),
                                             *(row[c]
                                               for c in ("upper.omega", "upper.omega_error", "upper.scaled",
                                                         "upper.transient", "residual", "ns_per_step"))]
                                            for row in table.rows])


def over_noise(table):
    """Means over the realisations of the noise, which the deck counts as points and not as replicas."""
    sets = {}
    for row in table.rows:
        sets.setdefault((row["dt"], row["integrator"]), len(sets))
    return Table([{**row, "set": sets[row["dt"], row["integrator"]]} for row in table.rows], table.missing,
                 table.source).joined()


def step(axes, table):
    for k, (name, word) in enumerate(INTEGRATORS):
        line = table.where(integrator=name).sorted("dt")
        if line:
            shift = 1 + 0.06 * (k - 0.5)
            points(axes, shift * line.column("dt"), SCALE * line.disk("scaled"), SCALE * line.disk("scaled_error"),
                   word, k, "os"[k], line="none")
    axes.set_xscale("log")
    axes.set_title("random vibration", pad=38)
    axes.set_xlabel(r"time step $dt$")
    if table:
        legend_above(axes, 2)


def relative(table, phase, name):
    """(dt, Omega over that of the smallest step, minus 1) of one integrator, without the smallest step."""
    line = table.where(phase=phase, integrator=name).sorted("dt")
    if len(line) < 2:
        return np.array([]), np.array([])
    omega = line.disk("omega")
    return line.column("dt")[1:], omega[1:] / omega[0] - 1


def turning(axes, table):
    for k, (phase, title) in enumerate(((0.0, "in phase"), (PI, "opposite"))):
        for n, (name, word) in enumerate(INTEGRATORS):
            dt, change = relative(table, phase, name)
            if len(dt):
                axes.plot(dt * (1 + 0.08 * (n - 0.5)), 100 * np.abs(change), ls="none", marker="os^v"[2 * k + n],
                          mfc="white", ms=5, color=COLOURS[2 * k + n], label=f"{title}, {word}")
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.set_title("turning supports", pad=38)
    axes.set_xlabel(r"time step $dt$")
    axes.set_ylabel(r"change of $\Omega$ (%)")
    if axes.get_legend_handles_labels()[0]:
        legend_above(axes, 2, fontsize=9, labelspacing=0.2)


def interval(axes, table):
    line = table.sorted("interval")
    if line:
        points(axes, line.column("interval"), SCALE * line.disk("scaled"), SCALE * line.disk("scaled_error"), "", 0,
               "o", line="none")
    axes.set_xscale("log")
    axes.set_xlabel(r"noise interval $h/dt$")


def seeds(axes, table):
    line = table.sorted("replica")
    if len(line) > 1:
        value, error = SCALE * line.disk("scaled"), SCALE * line.disk("scaled_error")
        points(axes, line.column("replica") + 1, value, error, "", 0, "o", line="none")
        spread = value.std(ddof=1) / math.sqrt(len(value))
        axes.axhspan(value.mean() - spread, value.mean() + spread, color="#DDDDDD", zorder=0)
    axes.set_xlabel("seed number")


def equal(text, table, what, slug, note=""):
    """All values of t_g Omega agree within their error bars."""
    value, error = table.disk("scaled"), table.disk("scaled_error")
    good = np.isfinite(value) & (error > 0)
    value, error = value[good], error[good]
    if len(value) < 2:
        return missing(text, slug=slug)
    mean = np.sum(value / error ** 2) / np.sum(1 / error ** 2)
    chi2, chance = chi_square((value - mean) / error, len(value) - 1)
    return Claim(text, scattering(chi2, len(value) - 1, slug == "seeds-scatter"),
                 f"{len(value)} {what}: &chi;&sup2; = {chi2:.1f} for {len(value) - 1} degrees (a chance of "
                 f"{100 * chance:.2g} %), mean <i>t<sub>g</sub></i>&Omega; "
                 f"{number(mean, 1 / math.sqrt(np.sum(1 / error ** 2)))}, error bars "
                 f"{100 * float(np.median(error / abs(mean))):.0f} %{note}", slug=slug, rule="scatter")


def step_claim(table):
    return equal("Random vibration: &Omega; does not depend on the time step within its error bars.",
                 table.where(integrator="gear5"), "time steps, Gear", "step-random")


def integrator_claim(tables):
    text = "Gear and velocity Verlet give the same &Omega; at the same time step and noise."
    gaps = []
    for table, keys in ((tables["step"].joined(), ("dt", "noise")), (tables["step_turning"].joined(), ("dt", "phase"))):
        for row in table.where(integrator="gear5").rows:
            other = table.where(integrator="verlet", **{key: row[key] for key in keys}).rows
            if other:
                gaps.append(abs(other[0]["upper.omega"] / row["upper.omega"] - 1))
    if not gaps:
        return missing(text, slug="step-integrators")
    return decide(text, lambda factor: max(gaps) < factor * 1e-3, f"largest relative difference of {len(gaps)} pairs {number(max(gaps))} "
                  "(counted as the same below 10<sup>&minus;3</sup>)", slug="step-integrators")


def turning_claim(table):
    text = "A time step of 10<sup>&minus;5</sup> is small enough for turning supports."
    told, gaps = [], []
    for phase, title in ((0.0, "in phase"), (PI, "opposite")):
        line = table.where(phase=phase, integrator="gear5").sorted("dt")
        at = line.where(dt=1e-5).rows
        if len(line) < 2 or not at or line.rows[0]["dt"] > 0.9e-5:
            continue
        gaps.append(at[0]["upper.omega"] / line.rows[0]["upper.omega"] - 1)
        told.append(f"{title} {percent(gaps[-1], 3)} of &Omega; at {line.rows[0]['dt']:g} "
                    f"({number(at[0]['upper.omega'] / (0.04 * OMEGA_B), digits=5)} "
                    "&Theta;<sub>b</sub>&omega;<sub>b</sub>)")
    if not gaps:
        return missing(text, slug="step-turning")
    return decide(text, lambda factor: max(abs(g) for g in gaps) < factor * 0.002, "; ".join(told) + " (counted as small up to 0.2 %)",
                  slug="step-turning")


def interval_claim(table):
    return equal("&Omega; does not depend on the noise interval within its error "
                 "bars.", table,
                 "intervals",
                 "noise-interval",
                 f", longest {number(table.values('interval')[-1])} steps" if table.values("interval") else "")


def seeds_claim(table):
    claim = equal("Runs with different seeds scatter as their error bars say.", table, "seeds", "seeds-scatter")
    value, error = table.disk("scaled"), table.disk("scaled_error")
    if len(value) > 2:
        claim.numbers += f"; scatter {number(float(value.std(ddof=1)))}, mean error bar {number(float(error.mean()))}"
    return claim
