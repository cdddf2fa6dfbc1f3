"""Jamming of compressed packings: density and coordination against pressure, and coordination against friction."""
import numpy as np

from ratchet.data import Table
from ratchet.page import Figure, Numbers, Section
from ratchet.style import COLOURS, GREY, LIGHT, figure, points
from ratchet.verdict import decide, missing, number

from .statistics import jackknife, line, mean_error

PHI, TOLERANCE = 0.84, 0.01
NEAR = 0.1      # coordination counts as equal
TARGET = 0.05   # targets below are pressures in units of k_n, above packing fractions


def coordination(a, b, n, least):
    """(contacts per disk, the same without rattlers, their fraction, isostatic value of so many disks) of contacts a-b.

    Rattlers have fewer than `least` contacts; they are taken away until none is left."""
    alive = np.ones(n, bool)
    while True:
        held = alive[a] & alive[b]
        count = np.bincount(np.concatenate([a[held], b[held]]), minlength=n)
        loose = alive & (count < least)
        if not loose.any():
            break
        alive &= ~loose
    rest = int(alive.sum())
    if rest == 0:
        return 2 * len(a) / n, np.nan, 1.0, np.nan
    return 2 * len(a) / n, 2 * int(held.sum()) / rest, 1 - rest / n, 4 - 2 / rest


def final(run):
    """(pressure, packing fraction) at the end."""
    _, pressure, fraction = run.series("pressure", "packing_fraction")
    return float(pressure[-1]), float(fraction[-1])


def stages(run):
    """[(pressure asked for, pressure, packing fraction, contacts per disk, the same without rattlers)] where phases
    that seek a pressure end; contacts are those of the last table in the phase."""
    time, pressure, fraction, contacts = run.series("pressure", "packing_fraction", "contacts")
    found = []
    for phase, end in zip(run.phases, np.cumsum([phase["steps"] for phase in run.phases])):
        row = int(np.searchsorted(time, (end + 0.5) * run.dt)) - 1
        if 0 < phase["target_goal"] < TARGET:
            found.append((phase["target_goal"], pressure[row], fraction[row], 2 * contacts[row] / run.n_free,
                          coordination(*run.neighbours_at((end + 0.5) * run.dt), run.n_free, 3)[1]))
    return found


STAGE = ("goal", "pressure", "fraction", "contacts", "without_rattlers")
ENDS = ("pressure", "fraction", "contacts", "without_rattlers", "rattlers", "isostatic")


def held(campaign, runs):
    """stages() of each run, in order of pressure."""
    found = campaign.numbers("jam-stages", lambda: Table({"run": k, **dict(zip(STAGE, stage))} for k,
                                                         run in enumerate(runs)
                                                         for stage in sorted(stages(run))),
                             "where a pressure is reached; pressures in k_n")
    return [list(zip(*(part.column(name) for name in STAGE))) for part in (found.where(run=k)
                                                                           for k in found.values("run"))]


def last_contacts(campaign, name, runs, columns=ENDS[2:]):
    """[run][column] of the contacts at the end: what coordination() finds, and final()."""
    def make():
        rows = [(*final(run), *coordination(*run.neighbours()[:2], run.n_free, 3 if run.parameters.get("mu", 0) == 0
                                            else 2))
                for run in runs]
        return dict(zip(ENDS, zip(*rows))) if rows else None

    table = campaign.numbers(f"{name}-contacts", make, "each run at its end: contacts per disk, share of rattlers")
    return np.column_stack([table.column(column) for column in columns])


def sections(campaign):
    return [frictionless(campaign), friction(campaign)]


def frictionless(campaign):
    runs = campaign.runs("jam")
    out = Section("jamming", "Jamming of frictionless disks",
                  "<code>inputs/packing/jam.cfg</code>: frictionless disks 1 : 1.4, half of each, are compressed past "
                  "jamming, "
                  "relaxed, and let down in pressure, at each pressure to force balance. &phi;<sub>J</sub> is that of "
                  "a straight "
                  "line in the pressure at zero; rattlers (fewer than three contacts) are left out of <i>z</i>. "
                  "Errors: scatter of "
                  "packings.", missing=campaign.missing("jam"))
    text = f"The packing fraction at jamming is the known {PHI:g}."
    if not runs:
        out.claims.append(missing(text, slug="jamming-density"))
        return out
    table = held(campaign, runs)
    rows = [[mean_error([stage[k][j] for stage in table]) for j in range(5)] for k in range(len(table[0]))]
    few = max(2, len(rows) // 2)  # the least pressures, where the line is straight
    phi, error = jackknife(lambda some: float(np.mean([line(*np.array(t)[:few, 1:3].T)[2] for t in some])), table)
    out.claims.append(decide(text, bool(abs(phi - PHI) < TOLERANCE),
                             f"{number(phi, error)} from {len(runs)} packing{'s' * (len(runs) > 1)} of "
                             f"{runs[0].n_free} disks and the {few} "
                             f"least pressures; "
                             f"counted as equal up to {TOLERANCE:g}", slug="jamming-density"))
    z = last_contacts(campaign, "jam", runs)
    mean, spread = mean_error(z[:, 1])
    out.claims.append(decide("Without rattlers the coordination number tends to 4, the isostatic "
                             "value.", bool(abs(mean - 4) < NEAR),
                             f"{number(mean, spread)} at the least pressure, {number(rows[0][1][0])} "
                             f"<i>k<sub>n</sub></i> (isostatic for "
                             f"as many disks, 4 &minus; 2/N: {z[:, 3].mean():.4f}); counted as equal up to {NEAR:g}; "
                             f"{100 * z[:, 2].mean():.1f} % rattlers", slug="jamming-isostatic"))
    out.tables.append(Numbers("Compressed packings, at each pressure",
                              ["pressure/<i>k<sub>n</sub></i>", "reached", "packing fraction", "contacts per disk, "
                                  "rattlers included", "without rattlers"],
                              [[float(r[0][0]), *(number(*r[j]) for j in (1, 2, 3, 4))] for r in rows]))
    out.figures.append(jamming_figure(rows, few, phi))
    return out


def jamming_figure(rows, few, phi):
    picture, axes = figure(columns=2, height=3.2)
    pressure = np.array([r[1][0] for r in rows])
    for panel, k, colour, label in ((axes[0], 2, 0, None), (axes[1], 4, 0, "without rattlers"), (axes[1], 3, 4, "all")):
        value, error = np.array([r[k] for r in rows]).T
        points(panel, pressure, value, np.nan_to_num(error), label, colour, "os"[colour > 0], line="none")
        panel.set_xscale("log")
        panel.set_xlabel("pressure / $k_n$")
    x = np.geomspace(pressure.min(), pressure[:few].max() * 3, 50)
    slope, _, offset, _ = line(pressure[:few], [r[2][0] for r in rows[:few]])
    axes[0].plot(x, offset + slope * x, color=COLOURS[1], label=f"line, {phi:.4f} at zero")
    axes[0].set_ylabel("packing fraction")
    axes[0].legend(loc="upper left")
    axes[1].axhline(4, color=GREY, lw=0.8, ls="--", gid="guide", label="isostatic, without rattlers")
    axes[1].set_ylabel("contacts per disk")
    axes[1].legend(loc="upper left")
    return Figure("jamming", picture, "Packing fraction and contacts per disk of compressed frictionless disks against "
                  "pressure; the isostatic value 4 is that of contacts without rattlers.",
                  "Packing fraction and coordination against pressure")


def friction(campaign):
    out = Section("jam-friction", "Coordination against friction",
                  "<code>inputs/packing/jam_friction.cfg</code>: packings of frictional disks compressed to a low "
                  "pressure. Rattlers have "
                  "fewer than two contacts here. Friction lets fewer contacts carry a packing: between 4 without it "
                  "and 3 at most.",
                  missing=campaign.missing("jam_friction"))
    table = {}
    runs = campaign.runs("jam_friction")
    for run, ends in zip(runs, last_contacts(campaign, "jam_friction", runs, ENDS) if runs else ()):
        table.setdefault(run.parameters.get("mu", 0.0), []).append(ends)
    text = "With friction the coordination number falls from 4 towards 3."
    if len(table) < 3:
        out.claims.append(missing(text, slug="jamming-friction"))
        return out
    table = dict(sorted(table.items()))
    mu = np.array(list(table))
    means = [[mean_error(np.array(some)[:, k]) for k in range(5)] for some in table.values()]
    z, error = np.array([m[3] for m in means]).T
    falls = bool(np.all(np.diff(z) < 3 * np.nan_to_num(np.hypot(error[1:], error[:-1]), nan=0.05)))
    out.claims.append(decide(text, bool(abs(z[0] - 4) < NEAR and falls and abs(z[-1] - 3) < 2 * NEAR),
                             "; ".join(f"&mu; = {m:g}: {number(*pair)}" for m, pair in zip(mu, zip(z, error))),
                             slug="jamming-friction"))
    out.tables.append(Numbers("Packings with friction", ["&mu;", "packings", "pressure", "packing fraction", "z of all",
                                                         "z without rattlers", "rattlers"],
                              [[float(m), len(table[m]), float(v[0][0]), *(number(*v[k]) for k in (1, 2, 3, 4))]
                               for m, v in zip(mu, means)]))
    picture, axes = figure(columns=2, height=3.1)
    place = np.where(mu > 0, mu, 0.3 * mu[mu > 0].min())
    for panel, k, label in ((axes[0], 3, "$z$ without rattlers"), (axes[1], 1, "packing fraction")):
        value, bar = np.array([m[k] for m in means]).T
        points(panel, place, value, np.nan_to_num(bar), None, 0, "o")
        panel.set_xscale("log")
        panel.set_xlabel(r"$\mu$ (leftmost: $\mu$ = 0)" if mu[0] == 0 else r"$\mu$")
        panel.set_ylabel(label)
    for level in (3, 4):
        axes[0].axhline(level, color=LIGHT, lw=0.8, gid="guide")
    out.figures.append(Figure("jam-friction", picture, "Coordination number and packing fraction against friction.",
                              "Coordination number against friction"))
    return out
