"""Energy budgets: residual of every run, and how it falls with the time step."""
import os

import numpy as np
from matplotlib.ticker import NullFormatter

from ratchet.page import Figure, Numbers, Section
from ratchet.style import COLOURS, figure, points
from ratchet.verdict import decide, missing, number

from .drive import bars
from .statistics import mean_error, power_law

AIM = 1e-3


def sections(campaign):
    out = Section("budget", "Energy residual",
                  "What the energy budget misses at the decks' own time steps: over a whole run, deposition included, "
                  "in "
                  "units of its scale (work of driven bodies plus losses); and over the measured time alone, in units "
                  "of the "
                  "work that the driven bodies do in it.", missing=campaign.missing("step"))
    rows, worst, cost = [], [], []
    for name, entry in campaign.entries.items():
        runs = campaign.runs(name)
        if runs:
            cost.append([f"<code>{os.path.basename(entry.deck)}</code> ({name})", len(runs), effort(runs)])
        if name == "step" or not runs:
            continue
        first = max(runs, key=lambda run: abs(run.residual))
        work = [v for v in (run.measured_residual for run in runs) if np.isfinite(v)]
        rows.append([f"<code>{os.path.basename(entry.deck)}</code> ({name})", len(runs), first.dt, abs(first.residual),
                     max(work) if work else np.nan])
        worst += [(max(work) if work else abs(first.residual), name)]
    text = f"The energy residual of every run is below {AIM:g} of the work done, at the deck's own time step."
    if worst:
        over = [f"{name} {number(value)}" for value, name in worst if value > AIM]
        out.claims.append(decide(text, not over, f"largest {number(max(worst)[0])} ({max(worst)[1]}), of the work of "
                                                 f"driven bodies in the "
                                 "measured time where they do any, else of the scale of the whole run"
                                 + (f"; above: {', '.join(over)}" if over else ""), slug="energy-residual"))
    else:
        out.claims.append(missing(text, slug="energy-residual"))
    out.tables.append(Numbers("Largest residual of the runs of each deck",
                              ["deck", "runs", "dt", "whole run / scale", "measured time / work"], rows))
    out.tables.append(Numbers("Cost: steps times the least time of a step and disk among the runs of a deck, on one core",
                              ["deck", "runs", "core-minutes"], [[*some, round(time, 1)] for *some, time in cost]
                              + [["all", sum(count for _, count, _ in cost), round(sum(time for *_, time in cost))]]))
    out.claims += convergence(campaign.runs("step"), out)
    return [out]


def effort(runs):
    """Minutes of one core; other programs that ran beside made most runs slower."""
    least = min(run.nanoseconds * run.threads / run.n_free for run in runs)
    return sum(run.steps * run.n_free for run in runs) * least * 1e-9 / 60


def convergence(runs, out):
    text = "It falls with the time step."
    by_scheme = {}
    for run in runs:
        steps = by_scheme.setdefault(run.parameters.get("integrator", ""), {})
        steps.setdefault(run.parameters.get("dt"), []).append(run)
    by_scheme = {name: dict(sorted(steps.items())) for name, steps in by_scheme.items() if len(steps) > 2}
    if not by_scheme:
        return [missing(text, slug="residual-falls")]
    picture, axes = figure(height=3.9)
    claims = []
    for k, (name, steps) in enumerate(sorted(by_scheme.items())):
        dt = np.array(list(steps))
        size = [mean_error([abs(run.residual) for run in some]) for some in steps.values()]
        value, error = np.array(size).T
        slope, spread, factor = power_law(dt, value)
        points(axes, dt * 1e6, value, bars(value, error), f"{name}: slope {slope:.2f} ± "
            f"{spread:.2f}", k, "os^v"[k],
               line="none")
        x = np.geomspace(dt.min(), dt.max(), 20)
        axes.plot(x * 1e6, factor * x ** slope, color=COLOURS[k], lw=0.9)
        claims.append(decide(f"The residual falls with the time step "
                             f"({name}).", True if slope > 2 * spread else False if slope < 0 else None,
                             f"|residual|/scale ~ dt<sup>{number(slope, spread)}</sup>, from "
                             f"{number(value[-1], error[-1])} at "
                             f"{dt[-1]:g} s to {number(value[0], error[0])} at {dt[0]:g} s "
                             f"({len(list(steps.values())[0])} at each step)", slug=f"residual-falls-{name}"))
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.set_xlabel(r"time step (µs)")
    axes.set_ylabel("|residual| / scale")
    axes.legend()
    axes.set_xticks(dt * 1e6, [f"{1e6 * step:g}" for step in dt])
    axes.xaxis.set_minor_formatter(NullFormatter())
    out.figures.append(Figure("residual", picture, "Residual of the energy budget of the shaken box against the time "
                                                   "step, means over "
                              "packings.", "Energy residual against time step for two integrators"))
    return claims
