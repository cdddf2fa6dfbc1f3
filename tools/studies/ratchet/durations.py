"""How long each sliding configuration lasts: the correlation time of the configuration, which converges as the noise interval
goes to zero, and the mean visit, which does not; and how fast the upper disk is beside its supports meanwhile."""
import math
import os

import numpy as np

from .catalogue import paper
from .data import Table
from .mechanism_theory import SIGNS
from .page import Figure, Numbers, Section
from .runs import slipdisk
from .style import configuration, figure, legend_below, points
from .verdict import NO, TOLERANCES, Claim, close, in_fields, missing, number, sliding, together

PI = math.pi
DAMPING = 0.5  # t_c = 1/(c w)
OMEGA = 20 * PI
LEFT, RIGHT = 1, 2  # numbers of the supports in the deck
WORDS = {"pp": "++", "pm": "+-", "mp": "-+", "mm": "--"}
DRIVES = ("all coordinates", "rotation")
TITLES = {"all coordinates": "as in the figures", "rotation": "strong, rotation alone"}
CONVERGED = 0.2  # relative, either way: a correlation time beside a mean visit that changes several times over
ORDER = 0.5  # of the supports' velocity: from there on the upper disk's is of its order


def autocorrelation(x):
    """Returns the autocorrelation of a series, 1 at no lag; means over all pairs of moments that far apart."""
    n, wave = len(x), np.fft.rfft(x - np.mean(x), 2 * len(x))
    found = np.fft.irfft(wave * wave.conj())[:n] / np.arange(n, 0, -1)
    return found / found[0] if found[0] > 0 else np.full(n, math.nan)


def correlation_time(x, step):
    """Integral of the autocorrelation to its first zero."""
    found = autocorrelation(np.asarray(x, float))
    below = np.nonzero(found <= 0)[0]
    return float(np.trapz(found[:below[0]], dx=step)) if len(below) else math.nan


def read(path):
    """Correlation time of each configuration, and rms angular velocity of the upper disk, of one run while it is measured."""
    result = slipdisk.Result(path)
    contacts, since = result.contacts, float(result.deck.phases[0].time)
    moment, state = np.repeat(np.arange(len(contacts.count)), contacts.count), np.zeros((2, len(contacts.count)), int)
    for side, disk in enumerate((LEFT, RIGHT)):
        own = contacts["b"] == disk
        state[side, moment[own]] = contacts["sliding"][own]
    late, step = contacts.time > since, float(np.median(np.diff(contacts.time)))
    found = {name: correlation_time(((state[0] == a) & (state[1] == b))[late], step) for name, (a, b) in SIGNS.items()}
    spin = result.series["angular_velocity"][result.series["time"] > since, 0]
    return {**found, "rms": float(np.sqrt(np.mean(spin ** 2)))}


def measured(results):
    """One row for each run: drive, frequency, amplitude, noise interval, correlation times, mean visits, rms velocity."""
    table = results.sweep("correlation")

    def make():
        rows = []
        for row in table.rows:
            path = os.path.join(results.sweep_folder("correlation"), "points", f"{row['name']}.h5")
            if not os.path.exists(path):
                return None
            step = row["dt"] if isinstance(row.get("dt"), float) else 1e-5
            rows.append({"drive": DRIVES[row.get("coordinates") == "theta"], "set": row["set"],
                         "omega": value(row, "omega_b", OMEGA), "interval": step * value(row, "interval", 1.0),
                         "scan": "interval" if isinstance(row.get("interval"), float) else "frequency",
                         "eps_b": value(row, "eps_b", 1e-4), **read(path),
                         **{f"visit_{name}": row[f"upper.{name}.dwell"] for name in SIGNS}})
        return Table(rows)

    found = results.numbers("correlation-times", make, "correlation time and mean visit (visit_) of each sliding "
                            "configuration, rms angular velocity of the upper disk; one row a run", digits=6)
    return found, table.missing


def value(row, name, otherwise):
    return row[name] if isinstance(row.get(name), float) and math.isfinite(row[name]) else otherwise


def line(found, drive, scan, column):
    """(x, {name: (means, errors)}) of the sets of one scan, by x; columns of all configurations, visits and rms."""
    sets = sorted((part for part in found.where(drive=drive, scan=scan).sets()), key=lambda part: part.rows[0][column])
    out = {}
    for name in (*SIGNS, *(f"visit_{name}" for name in SIGNS), "rms"):
        values = [part.column(name) for part in sets]
        out[name] = (np.array([v.mean() for v in values]), np.array([
            v.std(ddof=1) / math.sqrt(len(v)) if len(v) > 1 else math.nan for v in values]))
    return np.array([part.rows[0][column] for part in sets]), np.array([part.rows[0]["eps_b"] for part in sets]), out


def alike(ratio, error, limit=TOLERANCES["proportional"]):
    """(verdict as a function of the factor on the tolerance, index of the least, of the largest): all the same, either way."""
    low, high = int(np.argmin(ratio)), int(np.argmax(ratio))
    middle, spread = (ratio[low] + ratio[high]) / 2, math.hypot(*np.nan_to_num(error[[low, high]])) / 2
    return (lambda factor: close((ratio[high] - middle) / middle, spread / middle, factor * limit)), low, high


def proportional(found):
    """The ratio of the configuration's and the drive's correlation time is the same at all frequencies, for each drive."""
    judges, told = {}, []
    for drive in DRIVES:
        omega, _, lines = line(found, drive, "frequency", "omega")
        if len(omega) < 3:
            continue
        t_c, parts = 1 / (DAMPING * omega), []
        for name in SIGNS:
            ratio, error = lines[name][0] / t_c, lines[name][1] / t_c
            judge, low, high = alike(ratio, error)
            judges.setdefault(drive, []).append(judge)
            parts.append(f"{sliding(WORDS[name])} {number(ratio[low], error[low])} (<i>t<sub>c</sub></i> = "
                         f"{number(t_c[low])}) to {number(ratio[high], error[high])} ({number(t_c[high])})")
        told.append(f"{TITLES[drive]}: " + ", ".join(parts))
    if not judges:
        return missing(**paper("durations-correlation"))
    limit = TOLERANCES["proportional"]
    return Claim(verdict=lambda factor: in_fields([together([judge(factor) for judge in part]) for part in judges.values()]),
                 numbers="correlation time of the configuration over that of the drive, least and largest; "
                 + "; ".join(told) + f" (counted as the same within &plusmn;{100 * limit:g} %)", rule="fields",
                 **paper("durations-correlation"))


def converges(found):
    """The correlation time does not depend on the noise interval; the mean visit may."""
    text = ("The correlation time of the configuration does not depend on the noise interval between 10<sup>&minus;6</sup> and "
            "10<sup>&minus;3</sup>; the mean visit does.")
    judges, told, visits = [], [], []
    for drive in DRIVES:
        interval, _, lines = line(found, drive, "interval", "interval")
        if len(interval) < 3:
            continue
        for name in SIGNS:
            ratio, error = lines[name]
            judge, low, high = alike(ratio, error, CONVERGED)
            judges.append(judge)
            told.append(ratio[high] / ratio[low])
            visits.append(lines[f"visit_{name}"][0][-1] / lines[f"visit_{name}"][0][0])
    if not judges:
        return missing(text, slug="durations-interval")
    return Claim(text, lambda factor: together([judge(factor) for judge in judges]) if min(visits) > 2 else NO,
                 f"largest over least correlation time at most {max(told):.2f} (counted as the same within "
                 f"&plusmn;{100 * CONVERGED:g} %); the mean visit grows {min(visits):.1f} to "
                 f"{max(visits):.1f} times as long", slug="durations-interval", rule="equal")


def premise(found):
    """The upper disk stays slow beside its supports: rms velocities."""
    told, judges = [], []
    for drive in DRIVES:
        omega, eps, lines = line(found, drive, "frequency", "omega")
        at = np.nonzero(np.abs(omega / OMEGA - 1) < 1e-6)[0]
        if not len(at):
            continue
        unit = eps[at[0]] * OMEGA
        ratio, error = (part[at[0]] / unit for part in lines["rms"])
        judges.append(lambda factor, ratio=ratio, error=error: close(ratio, error, factor * ORDER))
        told.append(f"{TITLES[drive]} (&epsilon;<sub>b</sub> = {number(eps[at[0]])}): {number(ratio, error)}")
    if not judges:
        return missing(**paper("premise-velocity"))
    return Claim(verdict=lambda factor: in_fields([judge(factor) for judge in judges]),
                 numbers="&Omega;<sub>rms</sub>/&epsilon;<sub>b</sub>&omega; at tilt 0.04 &pi;, &omega; = 20 &pi;: "
                 + "; ".join(told) + f" (counted as of the same order from {ORDER:g} on)", rule="fields",
                 **paper("premise-velocity"))


def facts(found):
    """Returns what the head of the page says of it."""
    out = {}
    for drive, word in zip(DRIVES, ("weak", "strong")):
        omega, eps, lines = line(found, drive, "frequency", "omega")
        at = np.nonzero(np.abs(omega / OMEGA - 1) < 1e-6)[0]
        if not len(at):
            continue
        out[word] = f"{lines['rms'][0][at[0]] / (eps[at[0]] * OMEGA):.2g}"
        ratio = lines["pp"][0] * omega * DAMPING if word == "weak" else np.concatenate(
            [lines[name][0] * omega * DAMPING for name in SIGNS])
        out[f"tau_{word}"] = f"{ratio.max():.2f} to {ratio.min():.2f}" if word == "weak" else f"{ratio.min():.2f} to {ratio.max():.2f}"
    return out


def sections(results):
    out = Section("durations", "Correlation time of the configurations, and the premise",
                  "Random vibration at tilt 0.04&pi; (deck <code>inputs/paper/correlation.cfg</code>): all coordinates as in the "
                  "figures, and supports that only turn, a hundred times as strongly. The correlation time of a configuration is "
                  "the integral of the autocorrelation of its indicator (1 while the contacts slide so, else 0) up to its first "
                  "zero. <i>t<sub>c</sub></i> = 1/<i>c</i>&omega; is varied at a fixed rms velocity of the supports. The mean "
                  "visit is no such measure: velocities under (52) are as rough as a random walk, so that they cross many times "
                  "where they meet, the more often the finer the noise is resolved. It is that of the cut-off.", new=True)
    found, out.missing = measured(results)
    out.claims = [premise(found), proportional(found), converges(found)]
    out.facts = facts(found)
    picture, axes = figure(3, 1, height=3.3, width=7.8, legend=True)
    for axis, drive in zip(axes, DRIVES):
        omega, _, lines = line(found, drive, "frequency", "omega")
        t_c = 1 / (DAMPING * omega)
        for name in SIGNS if len(omega) else ():
            points(axis, t_c, lines[name][0] / t_c, np.nan_to_num(lines[name][1] / t_c), **configuration(name))
        axis.set_xlabel(r"correlation time of the drive $t_c$")
        axis.set_title(TITLES[drive], fontsize=10)
        axis.set_xscale("log")
        axis.set_ylim(0, 0.2)
    axes[0].set_ylabel(r"correlation time $\tau/t_c$")
    interval, _, lines = line(found, "all coordinates", "interval", "interval")
    for name in SIGNS if len(interval) else ():
        look = configuration(name)
        points(axes[2], interval, lines[name][0], np.nan_to_num(lines[name][1]), **{**look, "label": None})
        points(axes[2], interval, lines[f"visit_{name}"][0], np.nan_to_num(lines[f"visit_{name}"][1]),
               **{**look, "label": None, "line": ":"})
    axes[2].set_xscale("log")
    axes[2].set_yscale("log")
    axes[2].set_xlabel("noise interval")
    axes[2].set_ylabel(r"$\tau$ (solid), mean visit (dotted)")
    axes[2].set_title("as in the figures", fontsize=10)
    legend_below(picture, axes, 4)
    out.figures.append(Figure("durations", picture, "Left, middle: correlation time of each configuration over that of the "
                              "drive; proportional: a level line. Right: the same (lines) and the mean visit (dotted) against "
                              "the interval between draws of the noise, &omega; = 20&pi;.",
                              "Correlation time of the sliding configurations against that of the drive and the noise interval"))
    out.tables += tables(found)
    return [out]


def tables(found):
    rows, frequency = [], []
    for drive in DRIVES:
        interval, _, lines = line(found, drive, "interval", "interval")
        for k, h in enumerate(interval):
            rows.append([TITLES[drive], float(h), *(float(v[k]) for name in SIGNS for v in lines[name]),
                         *(float(lines[f"visit_{name}"][0][k]) for name in SIGNS)])
        omega, eps, lines = line(found, drive, "frequency", "omega")
        for k, w in enumerate(omega):
            frequency.append([TITLES[drive], w / PI, float(eps[k]), 2 / w, *(float(v[k] * w / 2) for name in SIGNS
                                                                            for v in lines[name]),
                              *(float(v[k] / (eps[k] * w)) for v in lines["rms"])])
    names = [v for name in SIGNS for v in (f"&tau; {sliding(WORDS[name])}", "error")]
    return [Numbers("Against the noise interval, &omega; = 20&pi;", ["drive", "interval", *names, *(
        f"mean visit {sliding(WORDS[name])}" for name in SIGNS)], rows, shown=True, digits={
            f"mean visit {sliding(WORDS[name])}": 2 for name in SIGNS}),
            Numbers("Against the frequency, in units of <i>t<sub>c</sub></i>", [
                "drive", "&omega;/&pi;", "&epsilon;<sub>b</sub>", "<i>t<sub>c</sub></i>", *names,
                "&Omega;<sub>rms</sub>/&epsilon;<sub>b</sub>&omega;", "error"], frequency)]
