"""Supports that turn to and fro: Omega against tilt in phase and in opposite phases (figs. sync-vel, async-vel)."""
import math

import numpy as np

from .catalogue import paper
from .page import Figure, Numbers, Section
from .style import (BLACK, TURNING_MARKERS, figure, in_pi, legend_right, marker, plt, points, power,
                    zero_line)
from .verdict import TOLERANCES, approaches, decide, excellent, missing, none, percent, signed, within

PI = math.pi
SHOWN = (1e-3, 1e-2, 1e-1)  # amplitudes of the left panel
OMEGA_B = 20 * PI  # of the decks sync.cfg and async.cfg
FINE = "(" + ", ".join(f'"{0.002 * k:g} pi"' for k in range(41)) + ")"
STIFF = ("; the centre is under way to its equilibrium for much of each configuration, and theory becomes exact for "
         "stiffer disks or a slower drive (docs/validation.md)")
FACTS = {"sync": dict(title="Supports in phase: rotation against tilt (fig. sync-vel)",
                      sign=1, formula="(30)",
                      law="&Omega; = (4/&pi;) &mu; &Theta;<sub>b</sub>&omega;<sub>b</sub> tan &theta;<sub>T</sub>"),
         "async": dict(title="Supports in opposite phases: rotation against tilt (fig. async-vel)",
                       sign=-1, formula="(35), corrected",
                       law="first order in the tilt, with the factor &omega;<sub>b</sub>/&pi; that the print lacks"),}


def sections(results):
    return [tilt_section(results, kind) for kind in ("sync", "async")]


def matched(results, name, deck, keys=None):
    """(simulated rows joined with the theory of the same points). Theory is one row per set, by the same parameters."""
    table = results.sweep(name).joined()
    theory = results.theory(f"points-{name}", f"paper/{deck}", **(keys or {}))
    by_name = {strip(row["name"]): row for row in theory.rows}
    for row in table.rows:
        known = by_name.get(strip(row["name"]), {})
        row.update({f"theory.{key}": known[key] for key in known if key not in ("name", "set")})
    return table


def strip(name):
    """Name of a point without its replica."""
    return name.split(",r=")[0]


def sweep_points(results, name):
    """The -D of the level that change which points there are, for `slipdisk theory`."""
    from . import levels
    plans = levels.SWEEPS[name][1]
    return plans[results.level].points if results.level in plans else {}


def tilt_section(results, kind):
    facts = FACTS[kind]
    out = Section(f"{kind}-vel", facts["title"], "Parabolic motion (21) with &omega;<sub>b</sub> = 20&pi; (the paper "
                  f"does not give &omega;<sub>b</sub>), deck <code>inputs/paper/{kind}.cfg</code>. Solid line: "
                  f"{facts['formula']}, {facts['law']}. Dotted: permanent sliding at any tilt for &Theta;<sub>b</sub> "
                  "&rarr; &infin; (exact limit).")
    table = matched(results, kind, f"{kind}.cfg", sweep_points(results, kind))
    out.missing = list(table.missing)
    curve = results.theory(f"curve-{kind}", f"paper/{kind}.cfg",
                           **{"sweep.parameters.tilt.values": FINE,
                              "sweep.parameters.theta_b.values": "(0.1)"}).sorted("tilt")
    for row in table.rows:
        unit = row["theta_b"] * OMEGA_B
        row["size"], row["size_error"] = row["upper.omega"] / unit, row["upper.omega_error"] / unit
        for key in ("first_order", "limit", "mean"):
            value = row.get(f"theory.{key}", math.nan)
            value = value if isinstance(value, float) else math.nan
            row[f"off.{key}"] = row["upper.omega"] / value - 1 if value and row["tilt"] > 0 else math.nan
    out.figures += [velocity_figure(table, curve, kind, facts), deviation_figure(table, kind, facts)]
    out.claims = claims(table, facts, kind)
    long_runs(results, kind, table, out)
    rows = [[row["theta_b"], row["tilt"] / PI, OMEGA_B * row["size"], OMEGA_B * row["size_error"],
             *(row.get(f"theory.{k}", math.nan) / row["theta_b"] if isinstance(row.get(f"theory.{k}"), float)
               else math.nan for k in ("first_order", "mean", "limit")), 100 * row["off.first_order"], 100
             * row["off.mean"], row["upper.transient"], row["upper.converged"], row["upper.left.openings"]
             + row["upper.right.openings"], row["residual"]] for row in table.rows]
    out.tables.append(Numbers("All points", ["&Theta;<sub>b</sub>", "&theta;<sub>T</sub>/&pi;",
                                             "&Omega;/&Theta;<sub>b</sub>", "error", facts["formula"],
                                             "exact at this &Theta;<sub>b</sub>", "exact limit",
                                             f"off {facts['formula']}, %", "off exact, %", "transient", "converged",
                                             "openings", "residual"], rows))
    return out


def velocity_figure(table, curve, kind, facts):
    picture, (left, right) = figure(2, 1, width=7.8, height=4.0)
    formula = facts["formula"].split(",")[0]
    for k, theta in enumerate(table.values("theta_b")):
        line = table.where(theta_b=theta).sorted("tilt")
        rank, sign = marker(TURNING_MARKERS, theta, k)
        look = {"line": "--", "ms": 8 if sign in "*+" else 5}
        if theta in SHOWN:
            points(left, line.column("tilt") / PI, OMEGA_B * line.column("size"), OMEGA_B * line.column("size_error"),
                   None, rank, sign, **look)
        tilted = line.such(lambda row: row["tilt"] > 0)
        unit = tilted.column("theory.first_order") / tilted.column("theta_b") / OMEGA_B
        points(right, tilted.column("tilt") / PI, tilted.column("size") / unit,
               tilted.column("size_error") / np.abs(unit), f"${power(theta)}$", rank, sign, **look)
    if curve:
        tilt, first = curve.column("tilt") / PI, curve.column("first_order")
        left.plot(tilt, first / 0.1, color=BLACK, lw=1.3, zorder=1)
        left.plot(tilt, curve.column("limit") / 0.1, color=BLACK, lw=1.3, ls=":", zorder=1)
        right.plot([], [], color=BLACK, lw=1.3, label=formula)
        right.plot([], [], color=BLACK, lw=1.3, ls=":", label="exact limit")
        some = tilt > 0
        right.plot(tilt[some], curve.column("limit")[some] / first[some], color=BLACK, lw=1.3, ls=":", zorder=1)
    zero_line(left)
    right.axhline(1, color=BLACK, lw=1.3, zorder=1, gid="guide")
    for axes in (left, right):
        in_pi(axes.xaxis, 0.02)
        axes.set_xlabel(r"tilt $\theta_T$")
    left.set_ylabel(r"$\Omega/\Theta_b$ (1/time)")
    right.set_ylabel(r"$\Omega/\Omega_{" + formula.replace("(", "").replace(")", "") + "}$")
    if table or curve:
        legend_right(right, r"amplitude $\Theta_b$", fontsize=9.5, handlelength=1.6)
    return Figure(f"{kind}-vel", picture, "Left: mean angular velocity over amplitude against tilt, for the least, a middle "
                                          "and the largest amplitude, with theory; the others lie between. Right: all seven "
                                          f"over {formula}. Dashed lines join points; "
                                          "error bars are smaller than the symbols.",
                  f"Angular velocity over amplitude against tilt, supports {kind}, with theory curves")


def deviation_figure(table, kind, facts):
    # In phase the parabola's (30) is the exact solution: one panel says it all.
    columns = [("off.first_order", f"from {facts['formula']}"), ("off.mean", "from the exact solution")]
    columns = columns[:1] if kind == "sync" else columns
    picture, axes = figure(len(columns), 1, height=3.4, sharey=True, squeeze=False)
    for (column, title), axis in zip(columns, axes[0]):
        tilts = [t for t in table.values("tilt") if t > 0]
        for k, tilt in enumerate(tilts):
            line = table.where(tilt=tilt).sorted("theta_b")
            axis.plot(line.column("theta_b"), 100 * line.column(column),
                      "osv^D<>p"[k % 8] +
                      "-", ms=4, lw=0.8,
                      mfc="white",
                      color=plt.get_cmap("viridis")(0.9 * k / max(1, len(tilts) - 1)), label=f"{tilt / PI:g}$\\pi$")
        zero_line(axis)
        axis.set_xscale("log")
        axis.set_yscale("symlog", linthresh=1, linscale=0.6)
        axis.set_yticks([-100, -10, -1, 0, 1, 10, 100], ["$-100$", "$-10$", "$-1$", "0", "1", "10", "100"])
        axis.set_yticks([], minor=True)
    off = 100 * np.array([row[column] for row in table.rows for column, _ in columns], float)
    if np.isfinite(off).any():
        axes[0, 0].set_ylim(min(1.5 * np.nanmin(off), -0.5), max(1.5 * np.nanmax(off), 0.5))
    for (_, title), axis in zip(columns, axes[0]):
        axis.set_title(title)
        axis.set_xlabel(r"amplitude $\Theta_b$")
    axes[0, 0].set_ylabel("deviation of $\\Omega$ (%)")
    if table:
        legend_right(axes[0, -1], r"tilt $\theta_T$")
    return Figure(f"{kind}-vel-deviation", picture, f"Deviation of the simulated &Omega; from {facts['formula']}"
                  + (", which is also the " "exact solution." if kind == "sync"
                     else " and from the exact periodic solution at the same amplitude and tilt."),
                  f"Relative deviation from theory against amplitude, supports {kind}")


def claims(table, facts, kind):
    out, sign = [], facts["sign"]
    flat, tilted = table.where(tilt=0.0), table.such(lambda row: row["tilt"] > 0)
    if flat:
        out.append(none(value=float(np.abs(flat.column("size")).max()), unit=1,
                        unit_name=f"&Theta;<sub>b</sub>&omega;<sub>b</sub> at most, at {len(flat)} "
                                  "amplitudes", **paper(f"{kind}-level")))
    else:
        out.append(missing(**paper(f"{kind}-level")))
    out.append(signed(values=tilted.disk("omega"), errors=tilted.disk("omega_error"), sign=sign, names=[
        f"&Theta;<sub>b</sub> = {row['theta_b']:g}, tilt {row['tilt'] / PI:g} &pi;" for row in tilted.rows],
        **paper(f"{kind}-sign")))
    amplitudes = tilted.values("theta_b")
    if not amplitudes:
        return out
    last = amplitudes[-1]
    at = f"at &Theta;<sub>b</sub> = {last:g} within {{:.1f}} % at all tilts"
    exact, spread = largest(tilted.where(theta_b=last), "mean")
    out.append(excellent("The exact periodic solution of permanent sliding is met at large &Theta;<sub>b</sub> "
                         f"({'in phase' if kind == 'sync' else 'opposite phases'}).", exact, spread,
                         at.format(100 * exact)
                         + STIFF * (exact > TOLERANCES["excellent"]), slug=f"{kind}-exact"))
    return out + (sync_claims(tilted) if kind == "sync" else [printed(tilted.where(theta_b=last).rows[0])])


def largest(line, theory):
    """(largest relative deviation from a theory at all tilts, its error)"""
    off = np.abs(line.column("off." + theory))
    if not len(off) or not np.isfinite(off).all():
        return math.nan, math.nan
    k = int(np.argmax(off))
    return float(off[k]), float(line.disk("omega_error")[k] / abs(line.column("theory." + theory)[k]))


def printed(row):
    """(35) without the factor w_b/pi."""
    value = row.get("theory.first_order", math.nan) * PI / OMEGA_B
    claim = within(value=row["upper.omega"], target=value, tolerance=TOLERANCES["excellent"],
                   error=row["upper.omega_error"],
                   names=("&Omega;", "printed"), **paper("eq35-printed"))
    claim.numbers += (f"; &Omega; is {row['upper.omega'] / value:.2f} times the printed value, &omega;<sub>b</sub>/&pi; "
                      "= " \
                      f"{OMEGA_B / PI:g}")
    return claim


def sync_claims(tilted):
    """Durations against (26), (27), and the time in which contacts stick, at all tilts."""
    amplitudes, gaps, stick = tilted.values("theta_b"), [], []
    for theta in amplitudes:
        line = tilted.where(theta_b=theta)
        if not line.has("theory.torque_pp"):
            return [missing(**paper(slug)) for slug in ("sync-durations", "sync-elastic")]
        pp, mm = line.column("theory.torque_pp"), line.column("theory.torque_mm")
        known = -mm / (pp - mm), pp / (pp - mm)
        gaps.append(max(float(np.abs(line.disk(part) / aim - 1).max()) for part, aim in zip(("pp", "mm"), known)))
        stick.append(float(line.disk("stick").mean()))
    durations = approaches(amplitudes=amplitudes, deviations=gaps, errors=[0.0] * len(gaps), **paper("sync-durations"))
    falls = bool(np.all(np.diff(stick) < 0)) if len(stick) > 1 else None
    return [durations, decide(condition=falls, numbers="a contact sticks for " + ", ".join(
        f"{100 * v:.2g} % of the time at {theta:g}" for theta, v in zip(amplitudes, stick)), **paper("sync-elastic"))]


def long_runs(results, kind, table, out):
    """Runs of the paper's own length and time step, where this level has them beside the shorter ones."""
    if not results.has(f"{kind}_long"):
        return
    long = results.sweep(f"{kind}_long").joined()
    out.missing += long.missing
    told, gaps, rows = [], [], []
    for row in long.rows:
        short = table.where(theta_b=row["theta_b"], tilt=row["tilt"]).rows
        if short:
            gaps.append(short[0]["upper.omega"] / row["upper.omega"] - 1)
            told.append(f"&Theta;<sub>b</sub> = {row['theta_b']:g}: {percent(gaps[-1], 3)}")
            rows.append([row["theta_b"], row["tilt"] / PI, row["upper.omega"], row["upper.omega_error"], row["steps"],
                         short[0]["upper.omega"], short[0]["upper.omega_error"], short[0]["steps"]])
    text = ("Shorter runs with a larger time step give the &Omega; of 5&times;10<sup>8</sup> steps of "
            f"10<sup>&minus;6</sup> ({'in phase' if kind == 'sync' else 'opposite phases'}).")
    out.claims.append(decide(text, lambda factor: max(abs(g) for g in gaps) < factor * 0.003, "; ".join(told)
                             + " (counted as equal up to 0.3 %)", slug=f"{kind}-short") if gaps
                      else missing(text, slug=f"{kind}-short"))
    out.tables.append(Numbers("Runs of the paper's length",
                              ["&Theta;<sub>b</sub>", "&theta;<sub>T</sub>/&pi;", "&Omega;", "error", "steps",
                               "&Omega;, short run", "error", "steps"], rows))
