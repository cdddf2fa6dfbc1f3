"""Random vibration: Omega against amplitude and against tilt (figs. random-ex-vel, random-ex-tilt)."""
import math

import numpy as np

from . import fits
from .catalogue import paper
from .data import Table
from .page import Figure, Numbers, Section
from .style import (COLOURS, RANDOM_MARKERS, TILT_MARKERS, figure, in_pi, legend_right, marker, pi_label, points, power,
                    zero_line)
from .verdict import (NO, OPEN, YES, Claim, beyond, chance, grows, missing, number, scattering, signed, survival,
                      together)

PI = math.pi
SCALE = 1e4  # t_g Omega is shown in 10^-4
LEAST_CHANCE = 1e-3  # of chi^2: a worse fit says nothing about the extremum


def sections(results):
    every = results.best("random")
    more = results.sweep("longer")
    table = longer(every.joined(), more.joined())
    table.missing = [*every.missing, *more.missing]
    first = Section("random-ex-vel", "Random vibration: rotation against amplitude (fig. random-ex-vel)",
                    "All three coordinates of both supports vibrate at random (52), &omega; = 20&pi;, <i>c</i> = 0.5; "
                    "deck <code>inputs/paper/random.cfg</code>; <code>longer.cfg</code>: points whose order that length does not tell, "
                    "for 4000 time units (at 0.02&pi; 16000), joined with these by their errors. At 0.02&pi; the step from 9&times;10<sup>&minus;5</sup> "
                    "to 10<sup>&minus;4</sup> stood at 2.99 errors then; the runs of these two amplitudes were made twice as many "
                    "after that.", missing=list(table.missing))
    second = Section("random-ex-tilt", "Random vibration: rotation against tilt (fig. random-ex-tilt)",
                     "The same runs, and further tilts. For each amplitude an odd function of the tilt is fitted by "
                     "weighted least squares: a polynomial of two to five terms, or <i>ax</i>/(1 + "
                     "<i>b</i>&sup2;<i>x</i>&sup2; + <i>c</i>&sup2;<i>x</i><sup>4</sup>), chosen by AICc. The error of "
                     "its extremum is half the width that holds 68 % of the extrema when all points are scattered by "
                     "their error bars and the form is chosen anew, larger by &radic;(&chi;&sup2;/degrees) where the "
                     "fit is poor. A fit whose &chi;&sup2; has a chance below 10<sup>&minus;3</sup>, as when there are "
                     "few tilts, is not used." + replicas_told(every),
                     missing=list(table.missing))
    against_amplitude(table, first)
    against_tilt(table, every, results.sweep("rare").joined(), second)
    rows = [[row["tilt"] / PI, row["eps_b"],
             *(row[f"upper.{c}"] for c in ("scaled", "scaled_error", "pp", "pm", "mp", "mm", "stick", "open",
                                           "left.force_min", "right.force_min")), row["upper.left.openings"]
             + row["upper.right.openings"], row["residual"], row["replicas"] * row["steps"], row["replicas"],
             row["scatter"] * row["upper.scaled"] / row["upper.omega"] if row["upper.omega"] else math.nan]
            for row in sorted(table.rows, key=lambda r: (r["tilt"], r["eps_b"]))]
    first.tables.append(Numbers("All points of random vibration",
                                ["&theta;<sub>T</sub>/&pi;", "&epsilon;<sub>b</sub>", "<i>t<sub>g</sub></i>&Omega;",
                                 "error", "S<sup>++</sup>", "S<sup>+&minus;</sup>", "S<sup>&minus;+</sup>",
                                 "S<sup>&minus;&minus;</sup>", "a contact sticks", "a contact is open",
                                 "least <i>n</i><sub>1</sub>", "least <i>n</i><sub>2</sub>", "openings", "residual",
                                 "steps", "replicas", "error from their scatter"], rows))
    return [first, second]


def replicas_told(every):
    """A sentence for the lead when points have several independent runs."""
    most = int(max((row["replicas"] for row in every.joined().rows), default=1))
    if most < 2:
        return ""
    return (f" Each point of the tilt curve is the mean of up to {most} independent runs; its error is that of the "
            "mean of their error bars. The last columns of the table below hold the extrema of the curves of single "
            "runs: their mean, and its error from their scatter, which owes nothing to the error bars.")


def against_amplitude(table, out):
    picture, axes = figure(height=4.2)
    drawn = table.such(lambda row: round(row["tilt"] / PI, 6) in TILT_MARKERS)
    for k, tilt in enumerate(drawn.values("tilt")):
        line = drawn.where(tilt=tilt).sorted("eps_b")
        points(axes, 1e5 * line.column("eps_b"), SCALE * line.disk("scaled"), SCALE * line.disk("scaled_error"),
               pi_label(tilt / PI), *marker(TILT_MARKERS, tilt / PI, k))
    zero_line(axes)
    axes.set_xlabel(r"amplitude $\epsilon_b\times10^{5}$")
    axes.set_ylabel(r"$t_g\,\Omega\times10^{4}$")
    if table:
        legend_right(axes, r"tilt $\theta_T$")
    out.figures.append(Figure("random-ex-vel", picture, "Scaled mean angular velocity of the upper disk against the "
                              "rms amplitude of the supports, for several tilts. Lines join points.",
                              "Scaled angular velocity against vibration amplitude for several tilts"))
    out.claims.append(growth(table.such(lambda row: row["tilt"] > 0)))


def name_of(row):
    """A point for people."""
    return f"&epsilon;<sub>b</sub> = {number(row['eps_b'])}, tilt {row['tilt'] / PI:g} &pi;"


def longer(table, more):
    """Points joined with those of longer runs at the same amplitude and tilt, weighted by their errors."""
    out = []
    for row in table.rows:
        joint, same = dict(row), more.where(eps_b=row["eps_b"], tilt=row["tilt"]).rows
        for name in ("upper.omega", "upper.scaled") if same else ():
            values = [(r[name], r[name + "_error"]) for r in (row, *same) if r[name + "_error"] > 0]
            weight = sum(1 / e ** 2 for _, e in values)
            joint.update({name: sum(v / e ** 2 for v, e in values) / weight, name + "_error": weight ** -0.5})
        out.append(joint)
    return Table(out)


def growth(table):
    """|Omega| grows from each amplitude to the next, at each tilt of the figure."""
    steps, errors, names = [], [], []
    for tilt in (tilt for tilt in table.values("tilt") if round(tilt / PI, 6) in TILT_MARKERS):
        line = table.where(tilt=tilt).sorted("eps_b")
        size, error = np.abs(line.disk("omega")), line.disk("omega_error")
        steps += list(np.diff(size))
        errors += list(np.hypot(error[1:], error[:-1]))
        names += [f"{name_of(a)} to {number(b['eps_b'])}" for a, b in zip(line.rows[:-1], line.rows[1:])]
    return grows(steps=steps, errors=errors, names=names, **paper("random-growth"))


def single_runs(every, amplitude):
    """(mean, its standard error, number) of the extrema of the curves of single replicas, in units of pi."""
    places = []
    for replica in every.values("replica"):
        line = every.where(eps_b=amplitude, replica=replica).sorted("tilt")
        if len(line) < 8:
            continue
        found = fits.extremum(line.column("tilt"), line.disk("scaled"), line.disk("scaled_error"), samples=0)
        if found and found.position < 0.999 * line.column("tilt").max():
            places.append(found.position / PI)
    if len(places) < 2:
        return math.nan, math.nan, len(places)
    return float(np.mean(places)), float(np.std(places, ddof=1) / math.sqrt(len(places))), len(places)


def scatter_claim(every):
    """Do replicas of a point scatter as their error bars say? None when there are none."""
    chi2 = degrees = 0
    for members in every.sets():
        value, error = members.disk("omega"), members.disk("omega_error")
        good = np.isfinite(value) & (error > 0)
        value, error = value[good], error[good]
        if len(value) > 1:
            mean = np.sum(value / error ** 2) / np.sum(1 / error ** 2)
            chi2, degrees = chi2 + float(np.sum(((value - mean) / error) ** 2)), degrees + len(value) - 1
    if not degrees:
        return None
    ratio, fluke = math.sqrt(chi2 / degrees), chance(chi2, degrees)
    return Claim("Replicas scatter as their error bars say.", scattering(chi2, degrees, True),
                 f"&chi;&sup2; = {chi2:.1f} for {degrees} degrees (a chance of {100 * fluke:.2g} % to be as far out on "
                 f"either side): scatter over error bar {ratio:.2f}", slug="replicas-scatter", rule="scatter")


def nonmonotonic(lines, extrema):
    """At each amplitude an inner tilt turns the disk faster than the largest tilt."""
    told, parts = [], []
    places = {a: e for a, e in extrema if e.inside > 0.5}
    for line in lines:
        if len(line) < 3:
            continue
        size, error = np.abs(line.disk("scaled")), line.disk("scaled_error")
        z = (size[:-1] - size[-1]) / np.hypot(error[:-1], error[-1])
        k, amplitude = int(np.argmax(z)), line.rows[0]["eps_b"]
        parts.append(z)
        told.append(f"&epsilon;<sub>b</sub> = {number(amplitude)}: |<i>t<sub>g</sub></i>&Omega;| = {number(size[k], error[k])} at "
                    f"{line.rows[k]['tilt'] / PI:.3g} &pi;, {number(size[-1], error[-1])} at {line.rows[-1]['tilt'] / PI:.3g} &pi; "
                    f"({z[k]:.1f} errors" + (f"; extremum of the fit at {number(places[amplitude].position / PI, places[amplitude].error / PI)}"
                                             " &pi;)" if amplitude in places else ")"))
    if not parts:
        return missing(**paper("random-nonmonotonic"))

    def judge(factor):
        return together([YES if z.max() > beyond(len(z), factor) else NO if (z < -beyond(len(z), factor)).all() else OPEN
                         for z in parts])

    return Claim(verdict=judge, numbers="; ".join(told), rule="extremum", **paper("random-nonmonotonic"))


def scaling(extrema, out):
    """How the extremum's tilt goes with the amplitude: figure and claim, from three amplitudes on."""
    text = "The tilt of the extremum grows with the amplitude."
    sure = [(a, e) for a, e in extrema if e.inside >= 0.975]
    if len(sure) < 3:
        out.claims.append(missing(text, slug="extremum-grows", why="fewer than three amplitudes have an extremum"))
        return
    amplitude = np.array([a for a, _ in sure])
    place, error = (np.array([getattr(e, key) / PI for _, e in sure]) for key in ("position", "error"))
    law = fits.power_law(amplitude, place, error)
    chance = survival(law.chi2, law.degrees)
    local = np.diff(np.log(place)) / np.diff(np.log(amplitude))
    told = (f"exponent of a power law {number(law.exponent, law.error)}, &chi;&sup2; = {law.chi2:.1f} for "
            f"{law.degrees} degree{'s' * (law.degrees != 1)} (a chance of {100 * chance:.2g} %"
            + (": it is none)" if chance < LEAST_CHANCE else ")"))
    claim = grows(text, np.diff(place), np.hypot(error[1:], error[:-1]), slug="extremum-grows")
    claim.numbers += "; exponents from one to the next " + ", ".join(f"{x:.2f}" for x in local) + "; " + told
    out.claims.append(claim)
    picture, axes = figure(height=3.4, width=4.6)
    points(axes, 1e5 * amplitude, place, error, "", 0, "o", line="none")
    if chance > LEAST_CHANCE:
        fine = np.geomspace(amplitude.min(), amplitude.max(), 60)
        axes.plot(1e5 * fine, law.curve(fine), color=COLOURS[1], lw=0.9)
    axes.set_xlim(left=0)
    axes.set_ylim(bottom=0)
    in_pi(axes.yaxis, 0.02)
    axes.set_xlabel(r"amplitude $\epsilon_b\times10^{5}$")
    axes.set_ylabel(r"tilt of the extremum")
    out.figures.append(Figure("random-extrema", picture, "Tilt at which the rotation is fastest against the "
                              "amplitude" + (f"; line: power law with exponent {number(law.exponent, law.error)}."
                                             if chance > LEAST_CHANCE else "; no power law fits."),
                              "Tilt of the fastest rotation against vibration amplitude"))


def against_tilt(table, every, rare, out):
    amplitudes = [e for e in table.values("eps_b") if len(table.where(eps_b=e)) >= 4 and
                  any(abs(e - known) < 1e-9 for known in RANDOM_MARKERS)]
    picture, axes = figure(height=4.2)
    rows, extrema = [], []
    for k, amplitude in enumerate(amplitudes):
        line = table.where(eps_b=amplitude).sorted("tilt")
        rank, sign = marker(RANDOM_MARKERS, amplitude, k)
        tilt, y, error = line.column("tilt"), line.disk("scaled"), line.disk("scaled_error")
        unit = amplitude ** 2 / 1e-4  # the axis is in 10^4 epsilon_b^2
        points(axes, tilt / PI, y / unit, error / unit, f"${power(amplitude)}$", rank, sign, line="none")
        found = fits.extremum(tilt, y, error)
        if not found:
            continue
        fitting = survival(found.chi2, found.degrees) > LEAST_CHANCE
        if fitting:
            extrema.append((amplitude, found))
            curve = np.linspace(0, tilt.max(), 200)
            axes.plot(curve / PI, found.curve(curve) / unit, color=COLOURS[rank], lw=0.9)
        else:  # no form fits: the points are joined
            axes.plot(tilt / PI, y / unit, color=COLOURS[rank], lw=0.9, ls=":")
        inside = fitting and found.inside > 0.5
        if inside:
            axes.errorbar(found.position / PI, found.value / unit, xerr=found.error / PI, fmt="|", ms=13, mew=1.6,
                          color=COLOURS[rank])
        rows.append([amplitude, found.position / PI if inside else math.nan, found.error / PI if inside else math.nan,
                     found.value, found.inside, f"{found.form}, {found.terms} terms", found.chi2, found.degrees,
                     float(tilt.max() / PI), *single_runs(every, amplitude)])
    zero_line(axes)
    in_pi(axes.xaxis, 0.02)
    axes.set_xlabel(r"tilt $\theta_T$")
    axes.set_ylabel(r"$t_g\,\Omega/\epsilon_b^2\times10^{-4}$")
    if amplitudes:
        legend_right(axes, r"amplitude $\epsilon_b$")
    out.figures.append(Figure("random-ex-tilt", picture, "Scaled mean angular velocity over the square of the "
                              "amplitude against tilt. Curves: fits, dotted where no form fits; bars across them: their extrema "
                              "with errors.", "Scaled angular velocity against tilt for several amplitudes, with fits"))
    tilted = longer(table.such(lambda row: row["tilt"] > 0), rare)
    out.claims.append(signed(values=tilted.disk("omega"), errors=tilted.disk("omega_error"), sign=-1,
                             names=[name_of(row) for row in tilted.rows], **paper("random-clockwise")))
    out.claims.append(nonmonotonic([table.where(eps_b=eps).such(lambda row: row["tilt"] > 0).sorted("tilt") for eps in amplitudes],
                                   extrema))
    scaling(extrema, out)
    scatters = scatter_claim(every)
    if scatters:
        out.claims.append(scatters)
    out.tables.append(Numbers("Extrema", ["&epsilon;<sub>b</sub>", "&theta;<sub>T</sub>/&pi; at the extremum", "error",
                                          "<i>t<sub>g</sub></i>&Omega; there", "samples with an extremum inside",
                                          "form", "&chi;&sup2;", "degrees", "largest tilt/&pi;", "single runs: mean",
                                          "error", "number"], rows))
