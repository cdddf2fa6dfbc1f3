"""Supports that turn to and fro: Omega against tilt in phase and in opposite phases, and sine against parabola
(figs. sync-vel, async-vel)."""
import math

import numpy as np

from .page import Figure, Numbers, Section
from .style import (BLACK, COLOURS, GREY, TURNING_MARKERS, figure, in_pi, legend_above, legend_below, legend_right, marker, plt, points,
                    power, zero_line)
from .verdict import NO, OPEN, YES, Claim, decide, missing, number, percent, signed

PI = math.pi
OMEGA_B = 20 * PI  # of the decks sync.cfg and async.cfg
FINE = "(" + ", ".join(f'"{0.002 * k:g} pi"' for k in range(41)) + ")"
EQUAL = 0.03  # "excellent agreement"
FACTS = {"sync": dict(title="Supports in phase: rotation against tilt (fig. sync-vel)",
                      place="section 4.1, fig. sync-vel", sign=1, formula="(30)",
                      law="&Omega; = (4/&pi;) &mu; &Theta;<sub>b</sub>&omega;<sub>b</sub> tan &theta;<sub>T</sub>"),
         "async": dict(title="Supports in opposite phases: rotation against tilt (fig. async-vel)",
                       place="section 4.2, fig. async-vel", sign=-1, formula="(35), corrected",
                       law="first order in the tilt, with the factor &omega;<sub>b</sub>/&pi; that the print lacks"),}


def sections(results):
    out = [tilt_section(results, kind) for kind in ("sync", "async")]
    return out + [waveform_section(results)]


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
    picture, (left, right) = figure(2, 1, width=7.6, height=4.2, legend=True)
    formula = facts["formula"].split(",")[0]
    for k, theta in enumerate(table.values("theta_b")):
        line = table.where(theta_b=theta).sorted("tilt")
        rank, sign = marker(TURNING_MARKERS, theta, k)
        look = {"line": "--", "ms": 8 if sign in "*+" else 5}
        points(left, line.column("tilt") / PI, OMEGA_B * line.column("size"), OMEGA_B * line.column("size_error"),
               f"${power(theta)}$", rank, sign, **look)
        tilted = line.such(lambda row: row["tilt"] > 0)
        unit = tilted.column("theory.first_order") / tilted.column("theta_b") / OMEGA_B
        points(right, tilted.column("tilt") / PI, tilted.column("size") / unit,
               tilted.column("size_error") / np.abs(unit), None, rank, sign, **look)
    if curve:
        tilt, first = curve.column("tilt") / PI, curve.column("first_order")
        left.plot(tilt, first / 0.1, color=BLACK, lw=1.3, label=formula, zorder=1)
        left.plot(tilt, curve.column("limit") / 0.1, color=BLACK, lw=1.3, ls=":", label="exact limit", zorder=1)
        some = tilt > 0
        right.plot(tilt[some], curve.column("limit")[some] / first[some], color=BLACK, lw=1.3, ls=":", zorder=1)
    zero_line(left)
    right.axhline(1, color=BLACK, lw=1.3, zorder=1, gid="guide")
    for axes in (left, right):
        in_pi(axes.xaxis, 0.02)
        axes.set_xlabel(r"tilt $\theta_T$")
    left.set_ylabel(r"$\Omega/\Theta_b$")
    right.set_ylabel(r"$\Omega/\Omega_{" + formula.replace("(", "").replace(")", "") + "}$")
    if table or curve:
        legend_below(picture, left, 9, fontsize=9.5, handlelength=1.6, columnspacing=1)
    return Figure(f"{kind}-vel", picture, "Left: mean angular velocity over amplitude against tilt, for seven amplitudes, "
                  f"with theory. Right: the same over {formula}, which tells the amplitudes &Theta;<sub>b</sub> "
                  "(symbols) apart. Dashed lines join "
                  "points; error bars are smaller than the symbols.",
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
            axis.plot(line.column("theta_b"), 100 * line.column(column), "osv^D<>p"[k % 8] + "-", ms=4, lw=0.8, mfc="white",
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
    place, sign = facts["place"], facts["sign"]
    word = "counter-clockwise (&Omega; &gt; 0)" if sign > 0 else "clockwise (&Omega; &lt; 0)"
    out = []
    flat, tilted = table.where(tilt=0.0), table.such(lambda row: row["tilt"] > 0)
    text = "Without tilt the disk does not rotate."
    if flat:
        worst = float(np.abs(flat.column("size")).max())
        out.append(decide(text, worst < 1e-3, f"largest |&Omega;| is {number(worst)} "
                          f"&Theta;<sub>b</sub>&omega;<sub>b</sub> at {len(flat)} amplitudes (counted as none below "
                          "10<sup>&minus;3</sup>)", place))
    else:
        out.append(missing(text, place))
    out.append(signed(f"With tilt the disk always rotates {word}.", tilted.disk("omega"), tilted.disk("omega_error"),
                      sign, place))
    amplitudes = tilted.values("theta_b")
    worst = {theta: np.abs(tilted.where(theta_b=theta).column("off.first_order")).max() for theta in amplitudes}
    text = f"&Omega; approaches {facts['formula']} as &Theta;<sub>b</sub> grows."
    if len(amplitudes) > 1 and all(np.isfinite(list(worst.values()))):
        told = ", ".join(f"{100 * v:.1f} % at {theta:g}" for theta, v in worst.items())
        falls = worst[amplitudes[-1]] < 0.2 * worst[amplitudes[0]]
        out.append(decide(text, falls, f"largest deviation over all tilts: {told}", place))
        last = amplitudes[-1]
        out.append(decide(f"The agreement with {facts['formula']} is excellent at large &Theta;<sub>b</sub>.",
                          worst[last] <= EQUAL, f"at &Theta;<sub>b</sub> = {last:g} within {100 * worst[last]:.1f} % "
                          f"at all tilts (counted as excellent up to {100 * EQUAL:g} %)", place))
        exact = np.abs(tilted.where(theta_b=last).column("off.mean")).max()
        if np.isfinite(exact):
            why = ("" if exact <= EQUAL else "; the centre is under way to its equilibrium for much of each "
                   "configuration, and theory becomes exact for stiffer disks or a slower drive (docs/validation.md)")
            out.append(decide("The exact periodic solution of permanent sliding is met at large &Theta;<sub>b</sub>.",
                              exact <= EQUAL, f"at &Theta;<sub>b</sub> = {last:g} within {100 * exact:.1f} % at all "
                              f"tilts (counted as met up to {100 * EQUAL:g} %){why}"))
        if kind == "async":
            row = tilted.where(theta_b=last).rows[0]
            printed = row["theory.first_order"] * PI / OMEGA_B  # without the factor w_b/pi
            ratio = row["upper.omega"] / printed
            out.append(decide("Equation (35) as printed gives &Omega;.", abs(ratio - 1) <= EQUAL, "&Omega; is "
                              f"{ratio:.2f} times the printed value; &omega;<sub>b</sub>/&pi; = {OMEGA_B / PI:g}",
                              place))
    else:
        out += [missing(text, place), missing(f"The agreement with {facts['formula']} is excellent at large "
                                              "&Theta;<sub>b</sub>.", place)]
    return out


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
            "10<sup>&minus;6</sup>.")
    out.claims.append(decide(text, max(abs(g) for g in gaps) < 0.003, "; ".join(told)
                             + " (counted as equal up to 0.3 %)") if gaps else missing(text))
    out.tables.append(Numbers("Runs of the paper's length",
                              ["&Theta;<sub>b</sub>", "&theta;<sub>T</sub>/&pi;", "&Omega;", "error", "steps",
                               "&Omega;, short run", "error", "steps"], rows))


def waveform_section(results):
    out = Section("waveform", "Sine against parabola", "The paper computes with parabolas in place of its sines. Deck "
                  "<code>inputs/paper/waveform.cfg</code>: tilt 0.02&pi;, both waveforms at the same amplitude. In "
                  "the limit of strong drive and small tilt the sine turns the disk &pi;&sup2;/8 = 1.234 times as "
                  "fast.", new=True)
    table = matched(results, "waveform", "waveform.cfg", sweep_points(results, "waveform"))
    out.missing = list(table.missing)
    dense = "(" + ", ".join(f"{0.001 * 10 ** (k / 20):.6g}" for k in range(41)) + ")"
    curve = results.theory("curve-waveform", "paper/waveform.cfg", **{"sweep.parameters.theta_b.values": dense})
    picture, axes = figure(height=4.0)
    rows, last = [], {}
    for k, (phase, title) in enumerate(((0.0, "in phase"), (PI, "opposite phases"))):
        ratios = []
        for theta in table.values("theta_b"):
            pair = [table.where(phase=phase, theta_b=theta, wave=wave).rows for wave in ("harmonic", "parabolic")]
            if not all(pair):
                continue
            sine, parabola = pair[0][0], pair[1][0]
            ratio = sine["upper.omega"] / parabola["upper.omega"]
            error = abs(ratio) * math.hypot(sine["upper.omega_error"] / sine["upper.omega"],
                                            parabola["upper.omega_error"] / parabola["upper.omega"])
            known = [row.get("theory.mean", math.nan) for row in (sine, parabola)]
            exact = known[0] / known[1] if all(isinstance(v, float) for v in known) else math.nan
            ratios.append((theta, ratio, error))
            rows.append([title, theta, sine["upper.omega"], sine["upper.omega_error"], parabola["upper.omega"],
                         parabola["upper.omega_error"], ratio, error, exact])
        if ratios:
            theta, ratio, error = (np.array(v) for v in zip(*ratios))
            points(axes, theta, ratio, error, f"{title}, simulation", k, "os"[k], line="none")
            last[title] = (theta[-1], ratio[-1], error[-1])
        sine, parabola = (curve.where(phase=phase, wave=wave).sorted("theta_b") for wave in ("harmonic", "parabolic"))
        if len(sine) and len(sine) == len(parabola):
            axes.plot(sine.column("theta_b"), sine.column("mean") / parabola.column("mean"), color=COLOURS[k], ls="--",
                      lw=1, label=f"{title}, exact solution")
    axes.axhline(PI ** 2 / 8, color=GREY, lw=1, label=r"$\pi^2/8$", gid="guide")
    axes.set_xscale("log")
    axes.set_xlabel(r"amplitude $\Theta_b$")
    axes.set_ylabel(r"$\Omega_\mathrm{sine}/\Omega_\mathrm{parabola}$")
    legend_above(axes, 3)
    out.figures.append(Figure("waveform", picture, "Ratio of the mean angular velocities under sine and parabola of "
                              "the same amplitude.", "Ratio of the rotation under sine and parabola against amplitude"))
    for title in ("in phase", "opposite phases"):
        text = f"At strong drive the sine turns the disk &pi;&sup2;/8 times as fast as the parabola, {title}."
        if title not in last:
            out.claims.append(missing(text))
            continue
        theta, ratio, error = last[title]
        off = ratio / (PI ** 2 / 8) - 1
        out.claims.append(Claim(text, YES if abs(off) < 0.01 else NO if abs(off) - 3 * error > 0.01 else OPEN,
                                f"at &Theta;<sub>b</sub> = {theta:g}: {number(ratio, error)}, {percent(off)} from "
                                "&pi;&sup2;/8 (counted as equal up to 1 %)"))
    out.tables.append(Numbers("Sine and parabola",
                              ["", "&Theta;<sub>b</sub>", "&Omega;, sine", "error", "&Omega;, parabola", "error",
                               "ratio", "error", "exact"], rows))
    return out
