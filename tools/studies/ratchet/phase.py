"""Omega against the phase between the supports, and where the sense of rotation turns over.

A phase psi other than 0 and pi breaks the reflection symmetry by itself: reflection takes (psi, tilt) to
(-psi, -tilt) and Omega to -Omega. So Omega(psi) has a part that is even in psi, which needs the tilt, and an odd
one, which does not; theory, which lets the centre follow at once, has the even part alone.
"""
import math

import numpy as np

from . import fits
from .catalogue import paper
from .page import Figure, Numbers, Section
from .style import BLACK, COLOURS, GREY, figure, in_pi, legend_above, points, zero_line
from .turning import OMEGA_B
from .verdict import Claim, closeness, decide, missing, number, signed

PI = math.pi
DENSE = "(" + ", ".join(f'"{k / 30:.6g} pi"' for k in range(-29, 31)) + ")"
WAVES = (("parabolic", "parabola"), ("harmonic", "sine"))
STRONG = 0.04


class Line:
    """Omega/(Theta_b w_b) against psi, and its even part."""

    def __init__(self, table, amplitude):
        table = table.sorted("phase")
        unit = amplitude * OMEGA_B
        self.psi = table.column("phase")
        self.omega, self.error = table.disk("omega") / unit, table.disk("omega_error") / unit

    def __bool__(self):
        return len(self.psi) > 0

    def halves(self, sign):
        """(psi >= 0, half sum (sign 1) or half difference (-1) of the values at psi and -psi, its error)"""
        out = []
        for psi, omega, error in zip(self.psi, self.omega, self.error):
            if psi < -1e-9:
                continue
            if psi < 1e-9 or psi > PI - 1e-9:
                out.append((psi, omega if sign > 0 else 0.0, error))
                continue
            other = np.nonzero(np.abs(self.psi + psi) < 1e-6)[0]
            if len(other):
                out.append((psi, (omega + sign * self.omega[other[0]]) / 2,
                            math.hypot(error, self.error[other[0]]) / 2))
        return tuple(np.array(v) for v in zip(*out)) if out else (np.array([]),) * 3


def sections(results):
    out = Section("phase", "Phase between the supports", "Parabola and sine, &omega;<sub>b</sub> = 20&pi;, deck "
                  "<code>inputs/paper/phase.cfg</code>. &psi; &gt; 0: the right support is ahead. In the limit of "
                  "strong drive theory lets the sense turn over at |&psi;| = &pi; (sin&sup2;&theta;<sub>h</sub> "
                  "&minus; &mu;&sup2; cos&sup2;&theta;<sub>h</sub>) = 0.2425&pi;, whatever waveform and tilt. A phase "
                  "other than 0 and &pi; breaks the reflection symmetry as a tilt does: reflection takes (&psi;, "
                  "&theta;<sub>T</sub>) to (&minus;&psi;, &minus;&theta;<sub>T</sub>) and &Omega; to &minus;&Omega;. "
                  "The half sum of &Omega; at &psi; and &minus;&psi; is what the tilt does.", new=True)
    table = results.sweep("phase").joined()
    out.missing = list(table.missing)
    theory = results.theory("curve-phase", "paper/phase.cfg", **{"sweep[0].parameters.phase.values": DENSE})
    plain = table.such(lambda row: row.get("wave"))
    lines = {(a, w): Line(plain.where(theta_b=a, wave=w), a) for a in (0.004, STRONG) for w, _ in WAVES}
    level = Line(table.where(tilt=0.0), STRONG)
    stiff = Line(table.such(lambda row: isinstance(row.get("k_n"), float)), STRONG)
    curves = {key: theory.where(theta_b=key[0], wave=key[1]).sorted("phase") for key in lines}
    out.figures.append(draw(lines, level, stiff, curves))
    turns = turning_points({**{(a, w, f"{dict(WAVES)[w]}, &Theta;<sub>b</sub> = {a:g}"): line for (a, w),
                               line in lines.items()},
                            (STRONG, "parabolic", "parabola, &Theta;<sub>b</sub> = "
                             f"{STRONG:g}, <i>k<sub>n</sub></i> = 10<sup>5</sup>"): stiff}, curves)
    out.claims = claims(lines, level, stiff, curves, turns)
    rows = []
    for name, line in [*((f"&Theta;<sub>b</sub> = {a:g}, {dict(WAVES)[w]}", line) for (a, w), line in lines.items()),
                       ("no tilt", level), ("<i>k<sub>n</sub></i> = 10<sup>5</sup>", stiff)]:
        rows += [[name, psi / PI, omega, error] for psi, omega, error in zip(line.psi, line.omega, line.error)]
    out.tables.append(Numbers("All points", ["", "&psi;/&pi;", "&Omega;/&Theta;<sub>b</sub>&omega;<sub>b</sub>",
                                             "error"], rows))
    out.tables.append(Numbers("Where the half sum changes its sign",
                              ["", "&psi;/&pi;, simulation", "error", "&psi;/&pi;, exact solution"],
                              [[name, *(np.array(f or (math.nan, math.nan)) / PI), (x[0] / PI if x else math.nan)]
                               for name, f, x in turns]))
    return [out]


def draw(lines, level, stiff, curves):
    picture, axes = figure(2, 2, height=6.4)
    for k, amplitude in enumerate((0.004, STRONG)):
        panel = axes[0, k]
        for n, (wave, word) in enumerate(WAVES):
            line, curve = lines[amplitude, wave], curves[amplitude, wave]
            if line:
                points(panel, line.psi / PI, line.omega, line.error, word, n, "os"[n], line="none", ms=4)
            if curve:
                panel.plot(curve.column("phase") / PI, curve.column("mean_normalised"), color=COLOURS[n], lw=1,
                           label=f"{word}, exact")
        panel.set_title(f"$\\Theta_b={amplitude:g}$, $\\theta_T=0.04\\pi$", pad=36)
        if any(lines[amplitude, wave] for wave, _ in WAVES):
            legend_above(panel, 2, fontsize=9, handlelength=1.4, labelspacing=0.2)
        in_pi(panel.xaxis, 0.5)
    panel = axes[1, 0]
    for n, amplitude in enumerate((0.004, STRONG)):
        psi, value, error = lines[amplitude, "parabolic"].halves(1)
        if len(psi):
            points(panel, psi / PI, value, error, f"$\\Theta_b={amplitude:g}$", n + 2, "^D"[n], line="none", ms=4)
        curve = curves[amplitude, "parabolic"].such(lambda row: row["phase"] > -1e-9)
        if curve:
            panel.plot(curve.column("phase") / PI, curve.column("mean_normalised"), color=COLOURS[n + 2], lw=1,
                       label=f"{amplitude:g}, exact")
    panel.axvline(0.2425, color=GREY, lw=0.8, ls=":", gid="guide")
    panel.set_title("parabola, half sum of $\\psi$ and $-\\psi$", pad=36)
    panel.set_xlabel(r"phase $|\psi|$")
    in_pi(panel.xaxis, 0.25)
    if panel.get_legend_handles_labels()[0]:
        legend_above(panel, 2, fontsize=9, handlelength=1.4, labelspacing=0.2)
    panel = axes[1, 1]
    for n, (line, word) in enumerate(((level, "no tilt"), (stiff, "$k_n=10^5$"))):
        if line:
            points(panel, line.psi / PI, line.omega, line.error, word, n + 4, "v>"[n], line="none", ms=4)
    curve = curves[STRONG, "parabolic"]
    if curve:
        panel.plot(curve.column("phase") / PI, curve.column("mean_normalised"), color=BLACK, lw=1,
                   label="exact, $0.04\\pi$")
    panel.set_title(f"parabola, $\\Theta_b={STRONG:g}$", pad=36)
    panel.set_xlabel(r"phase $\psi$")
    in_pi(panel.xaxis, 0.5)
    if panel.get_legend_handles_labels()[0]:
        legend_above(panel, 3, fontsize=9, handlelength=1.4)
    for panel in axes.flat:
        zero_line(panel)
    for panel in axes[:, 0]:
        panel.set_ylabel(r"$\Omega/\Theta_b\omega_b$")
    for panel in axes[0]:
        panel.set_xlabel(r"phase $\psi$")
    return Figure("phase", picture, "Mean angular velocity against the phase &psi; between the supports. Above: weak "
                  "and strong drive, both waveforms, with the exact solution of permanent sliding (lines). Below "
                  "left: the part even in &psi;; dotted: where theory lets it change its sign at strong drive. Below "
                  "right: without tilt, and with tilt 0.04&pi; and hundred times stiffer disks.",
                  "Angular velocity against the phase between the supports")


def turning_points(lines, curves):
    out = []
    for (amplitude, wave, name), line in lines.items():
        psi, value, error = line.halves(1)
        curve = curves[amplitude, wave].such(lambda row: row["phase"] > -1e-9)
        out.append((name, fits.crossing(psi, value, error) if len(psi) > 3 else None,
                    fits.crossing(curve.column("phase"), curve.column("mean_normalised")) if curve else None))
    return out


def claims(lines, level, stiff, curves, turns):
    out = []
    ends = [[(v, e) for line in lines.values() for v, e, psi in zip(line.omega, line.error,
                                                                    line.psi) if abs(psi - at) < 1e-6]
            for at in (0.0, PI)]
    if all(ends):
        value, error = np.array(ends[0] + ends[1]).T
        claim = signed(values=value * ([1] * len(ends[0]) + [-1] * len(ends[1])), errors=error, sign=1,
                       what="&Omega; in phase and &minus;&Omega; opposite", **paper("sense-reverses"))
        claim.numbers += (f"; in phase {number(min(ends[0])[0])} to {number(max(ends[0])[0])}, opposite "
                          f"{number(min(ends[1])[0])} to {number(max(ends[1])[0])} "
                          "&Theta;<sub>b</sub>&omega;<sub>b</sub>")
        out.append(claim)
    else:
        out.append(missing(**paper("sense-reverses")))
    text = "Without tilt the disk does not rotate, whatever the phase (as theory has it)."
    if level:
        k = int(np.argmax(np.abs(level.omega)))
        out.append(decide(text, lambda factor: bool(abs(level.omega[k]) <= max(factor * 0.002, 5 * level.error[k])), f"largest at &psi; = {level.psi[k] / PI:g} &pi;: "
                          f"{number(level.omega[k], level.error[k])} &Theta;<sub>b</sub>&omega;<sub>b</sub> (counted "
                          "as none below 0.002)", slug="phase-level"))
    else:
        out.append(missing(text, slug="phase-level"))
    text = ("Disks stiff enough to follow at once (<i>k<sub>n</sub></i> = 10<sup>5</sup>) obey the exact solution at "
            "all phases.")
    curve = curves[STRONG, "parabolic"]
    if stiff and curve:
        gap = np.abs(stiff.omega - np.interp(stiff.psi, curve.column("phase"), curve.column("mean_normalised")))
        out.append(decide(text, lambda factor: float(gap.max()) < factor * 0.002, f"largest difference at {len(gap)} phases "
                          f"{number(float(gap.max()))} &Theta;<sub>b</sub>&omega;<sub>b</sub> (counted as equal "
                          "below 0.002)", slug="phase-stiff"))
    else:
        out.append(missing(text, slug="phase-stiff"))
    for k, (name, found, exact) in enumerate(turns):
        text, slug = f"What the tilt does turns over where the exact solution has it ({name}).", f"phase-turn-{k + 1}"
        if not found or not exact:
            out.append(missing(text, why="no change of sign in the data yet", slug=slug))
            continue
        gap, error = (found[0] - exact[0]) / PI, found[1] / PI
        out.append(Claim(text, closeness(gap, error, 0.01), f"at {number(found[0] / PI, error)} &pi;, exact solution "
                         f"{number(exact[0] / PI, digits=4)} &pi; (counted as equal up to 0.01 &pi;); limit of "
                         "strong drive 0.2425 &pi;", slug=slug, rule="equal"))
    return out
