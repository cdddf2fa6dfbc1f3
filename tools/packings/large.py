"""Ten thousand and a hundred thousand disks: cost, budget, and a map."""
import numpy as np

from report.page import Figure, Numbers, Section
from report.style import figure
from report.verdict import decide, missing, number

from . import maps
from .low import neighbour_correlation
from .statistics import pearson

RUNS = (("deposit_1e4", "deposition"), ("shake_1e4", "shaken"), ("deposit_1e5", "deposition"), ("shake_1e5", "shaken"))


def sections(campaign):
    out = Section("large", "Ten thousand and a hundred thousand disks",
                  "<code>inputs/packing/deposit_1e4.cfg</code>, <code>shake_1e4.cfg</code> and the same with "
                  "10<sup>5</sup>: a "
                  "packing is deposited once and saved; the shaken box begins with it, its contacts included.",
                  missing=campaign.missing(*(name for name, _ in RUNS)))
    rows = []
    for name, what in RUNS:
        for run in campaign.runs(name):
            rows.append([what, run.n_free, run.steps, run.steps * run.dt, run.wall, run.threads,
                         run.n_free * run.steps / run.step_seconds, abs(run.residual)])
    out.tables.append(Numbers("Cost", ["run", "disks", "steps", "time of the model (s)", "wall time (s)", "threads",
                                       "disk-steps per second", "residual / scale"], rows))
    shaken = [(name, run) for name in ("shake_1e4", "shake_1e5") for run in campaign.runs(name) if run.has_means]
    if not shaken:
        out.claims.append(missing("Disks rotate persistently in large packings, too."))
    for name, run in shaken:
        first, second = run.halves()
        out.claims.append(decide(f"Disks rotate persistently among {run.n_free}, too.", pearson(first, second) > 0.5,
                                 f"correlation of halves {pearson(first, second):.3f} in {run.measured:g} s; rms "
                                 f"&Omega; "
                                 f"{number(run.rms)}, mean {number(float(run.omega.mean()))} rad/s, "
                                 f"{100 * run.significant:.1f} % "
                                 "beyond 3 errors; neighbours' "
                                 f"&lang;&Omega;<sub>i</sub>&Omega;<sub>j</sub>&rang;/&lang;&Omega;&sup2;&rang; "
                                 f"{number(neighbour_correlation(run)[0])}; wander {number(run.wander)} diameters"))
        fast = np.abs(run.omega) > run.rms
        near = run.contacts
        out.claims.append(decide(f"Among {run.n_free} disks those that turn fast are loose: they have fewer contacts.",
                                 bool(near[fast].mean() < near[~fast].mean()),
                                 f"{int(fast.sum())} disks with |&Omega;| above the rms have {near[fast].mean():.2f} contacts in "
                                 f"the mean, the others {near[~fast].mean():.2f}"))
    for name, run in shaken[:1]:
        out.figures.append(map_figure(run))
    return [out]


def map_figure(run):
    height = (run.y_end.max() - run.y_end.min()) / (run.x_end.max() - run.x_end.min()) * 6.0
    picture, axes = figure(width=7.2, height=min(height + 0.9, 8))
    clip = 3 * run.rms
    norm = maps.scale(run.omega, clip=clip)
    maps.rotation_map(axes, run, norm, edge="none", width=0, widest=0.7)
    maps.colour_bar(picture, axes, norm, r"$\Omega_i$ (rad/s)", shrink=0.8, extend="both")
    return Figure("map-large", picture, f"{run.n_free} disks coloured by mean angular velocity (cut at three times "
                                        f"the rms), with the "
                  "contact network at the end.", "Map of ten thousand disks coloured by mean angular velocity")

