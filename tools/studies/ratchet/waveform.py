"""Sine against parabola: the ratio of what they do, and why theory fails at weak drive."""
import math

import numpy as np

from .page import Figure, Numbers, Section
from .style import COLOURS, GREY, figure, legend_above, points
from .turning import matched, sweep_points
from .verdict import TOLERANCES, Claim, closeness, missing, number, percent, within

PI = math.pi
PHASES = ((0.0, "in phase"), (PI, "opposite phases"))
WAVES = (("parabolic", "parabola"), ("harmonic", "sine"))
LEAD = ("The paper computes with parabolas in place of its sines. Deck <code>inputs/paper/waveform.cfg</code>: tilt "
        "0.02&pi;, both waveforms at the same amplitude. In the limit of strong drive and small tilt the sine turns "
        "the disk &pi;&sup2;/8 = 1.234 times as fast. Theory is drawn where contacts never stick in it, with either "
        "waveform.")


def sections(results):
    out = Section("waveform", "Sine against parabola", LEAD, new=True)
    table = matched(results, "waveform", "waveform.cfg", sweep_points(results, "waveform"))
    stiff = matched(results, "waveform_stiff", "waveform_stiff.cfg", sweep_points(results, "waveform_stiff"))
    out.missing = table.missing + stiff.missing
    dense = "(" + ", ".join(f"{0.001 * 10 ** (k / 20):.6g}" for k in range(41)) + ")"
    curve = results.theory("curve-waveform", "paper/waveform.cfg", **{"sweep.parameters.theta_b.values": dense})
    if stiff:
        out.lead += explained(stiff)
    found = {title: ratios(table.where(phase=phase)) for phase, title in PHASES}
    out.figures.append(draw(found, curve, stiff))
    out.claims = [strong_claim(title, found[title]) for _, title in PHASES] + [stiff_claim(stiff)]
    out.tables.append(Numbers("Sine and parabola",
                              ["", "&Theta;<sub>b</sub>", "&Omega;, sine", "error", "&Omega;, parabola", "error",
                               "ratio", "error", "exact", "contacts never stick in theory"],
                              [[title, *row] for _, title in PHASES for row in found[title]]))
    out.tables.append(Numbers("Stiffer disks, in phase, &Theta;<sub>b</sub> = 0.001",
                              ["", "<i>k<sub>n</sub></i>", "<i>k<sub>t</sub></i>", "&Omega;", "error", "exact",
                               "a contact sticks", "in theory"],
                              [[word, row["k_n"], row["k_t"], row["upper.omega"], row["upper.omega_error"],
                                row.get("theory.mean", math.nan), row["upper.stick"], row.get("theory.stuck", math.nan)]
                               for wave, word in WAVES for row in stiff.where(wave=wave).rows]))
    return [out]


def pair(sine, parabola):
    """(ratio of two rows, its error, that of the exact solution, whether contacts never stick in it)"""
    ratio = sine["upper.omega"] / parabola["upper.omega"]
    error = abs(ratio) * math.hypot(*(row["upper.omega_error"] / row["upper.omega"] for row in (sine, parabola)))
    known = [row.get("theory.mean", math.nan) for row in (sine, parabola)]
    exact = known[0] / known[1] if all(isinstance(v, float) for v in known) else math.nan
    never = all(row.get("theory.permanent") == 1 for row in (sine, parabola))
    return ratio, error, exact, never


def ratios(table):
    """A row per amplitude: Theta_b, Omega and error of sine and parabola, pair()."""
    rows = []
    for theta in table.values("theta_b"):
        both = [table.where(theta_b=theta, wave=wave).rows for wave in ("harmonic", "parabolic")]
        if all(both):
            sine, parabola = both[0][0], both[1][0]
            ratio, error, exact, never = pair(sine, parabola)
            rows.append([theta, sine["upper.omega"], sine["upper.omega_error"], parabola["upper.omega"],
                         parabola["upper.omega_error"], ratio, error, exact, "yes" if never else "no"])
    return rows


def at(stiff, k_n, k_t):
    """The two waveforms at these stiffnesses, sine first; None unless both are there."""
    rows = [stiff.where(wave=wave, k_n=k_n, k_t=k_t).rows for wave in ("harmonic", "parabolic")]
    return (rows[0][0], rows[1][0]) if all(rows) else None


def explained(stiff):
    """Why the simulated ratio is not that of theory at weak drive."""
    soft, last = at(stiff, 1e3, 1e6), stiffest(stiff)
    if not soft or not last:
        return ""
    sine, parabola = soft
    torque = parabola["theory.torque_pp"] / 0.05  # over I = m R^2/2
    drive = parabola["theory.amplitude"] * parabola["theory.omega"] ** 2
    off = [row["upper.omega"] / row["theory.mean"] - 1 for row in (parabola, sine)]
    return (" <b>Weak drive.</b> At &Theta;<sub>b</sub> = 0.001 in phase the ratio is "
            f"{number(pair(*soft)[0], digits=3)} where the exact solution has {number(pair(*soft)[2], digits=3)}. "
            f"There the torque turns the disk almost as fast as the supports: {number(torque, digits=2)} beside an "
            f"acceleration of the supports of {number(8 / PI ** 2 * drive, digits=2)} (parabola, constant) and at most "
            f"{number(drive, digits=2)} (sine). In theory the parabola outruns the disk all the time; the sine sticks "
            f"to it for {100 * sine['theory.stuck']:.0f} % of the period, which costs it rotation: hence a ratio below "
            "1. In the simulation normal forces need a while to come to their new equilibrium after each reversal, "
            f"and until then the torque is another one: a contact sticks for {100 * parabola['upper.stick']:.0f} % of "
            f"the time with the parabola and {100 * sine['upper.stick']:.0f} % with the sine, &Omega; is "
            f"{percent(off[0])} and {percent(off[1])} off. It is <i>k<sub>n</sub></i> that matters, "
            f"<i>k<sub>t</sub></i> hardly does. With <i>k<sub>n</sub></i> = {number(last[0]['k_n'])}, "
            f"<i>k<sub>t</sub></i> = {number(last[0]['k_t'])} the ratio is {number(pair(*last)[0], digits=3)}: theory "
            "is right, and does not apply to soft disks.")


def stiffest(stiff):
    """Sine and parabola of the stiffest disks of which both are there."""
    found = [at(stiff, row["k_n"], row["k_t"]) for row in stiff.rows]
    return max((p for p in found if p), key=lambda p: p[0]["k_n"] * p[0]["k_t"], default=None)


def stiff_claim(stiff):
    text = ("At weak drive (&Theta;<sub>b</sub> = 0.001) in phase stiff disks have the exact solution's ratio of sine "
            "and parabola.")
    last = stiffest(stiff) if stiff else None
    if not last:
        return missing(text, slug="waveform-stiff")
    ratio, error, exact, _ = pair(*last)
    return within(text, ratio, exact, TOLERANCES["excellent"], error=error, slug="waveform-stiff")


def strong_claim(title, rows):
    text = f"At strong drive the sine turns the disk &pi;&sup2;/8 times as fast as the parabola, {title}."
    slug = "waveform-" + title.split()[-1]
    if not rows:
        return missing(text, slug=slug)
    theta, ratio, error = rows[-1][0], *rows[-1][5:7]
    off, limit = ratio / (PI ** 2 / 8) - 1, TOLERANCES["equal"]
    return Claim(text, closeness(off, error / ratio, limit), f"at &Theta;<sub>b</sub> = {theta:g}: {number(ratio, error)}, "
                                                         f"{percent(off)} from &pi;&sup2;/8 (counted as equal up to "
                                                         f"{100 * limit:g} %)", slug=slug,
                 rule="equal")


def draw(found, curve, stiff):
    picture, (left, right) = figure(2, 1, height=4.0, width=7.6)
    for k, (phase, title) in enumerate(PHASES):
        if found[title]:
            theta, ratio, error = (np.array([row[n] for row in found[title]]) for n in (0, 5, 6))
            points(left, theta, ratio, error, title, k, "os"[k], line="none")
        sine, parabola = (curve.where(phase=phase, wave=wave).sorted("theta_b") for wave in ("harmonic", "parabolic"))
        if len(sine) and len(sine) == len(parabola):
            never = (sine.column("permanent") == 1) & (parabola.column("permanent") == 1)
            left.plot(sine.column("theta_b")[never], (sine.column("mean") / parabola.column("mean"))[never],
                      color=COLOURS[k], ls="--", lw=1, label=f"{title}, exact")
    left.axhline(PI ** 2 / 8, color=GREY, lw=1, label=r"$\pi^2/8$", gid="guide")
    left.set_xscale("log")
    left.set_xlabel(r"amplitude $\Theta_b$")
    left.set_ylabel(r"$\Omega_\mathrm{sine}/\Omega_\mathrm{parabola}$")
    for k, (wave, word) in enumerate(WAVES):
        line = stiff.where(wave=wave).such(lambda row: row["k_n"] > 1e3 or row["k_t"] < 1e7)
        line = line.such(lambda row: not (row["k_n"] > 1e5 and row["k_t"] < 1e7)).sorted("k_n")
        if line and line.has("theory.mean"):
            exact = line.column("theory.mean")
            points(right, line.column("k_n"), line.disk("omega") / exact, line.disk("omega_error") / exact, word, k + 2,
                   "^D"[k])
    right.axhline(1, color=GREY, lw=1, label="exact", gid="guide")
    right.set_xscale("log")
    right.set_xlabel(r"normal stiffness $k_n$")
    right.set_ylabel(r"$\Omega/\Omega_\mathrm{exact}$")
    right.set_title(r"in phase, $\Theta_b=0.001$", pad=36)
    left.set_title("all amplitudes", pad=50)
    for axes, columns in ((left, 2), (right, 3)):
        legend_above(axes, columns, fontsize=9, handlelength=1.4)
    return Figure("waveform", picture, "Left: ratio of the mean angular velocities under sine and parabola of the same "
                                       "amplitude; theory (dashed) where contacts never stick in it. Right: &Omega; "
                                       "over that of the exact solution at the weakest drive, against the stiffness "
                                       "(<i>k<sub>t</sub></i> from 10<sup>6</sup> to 10<sup>8</sup> with it).",
                  "Ratio of the rotation under sine and parabola against amplitude, and rotation against stiffness")
