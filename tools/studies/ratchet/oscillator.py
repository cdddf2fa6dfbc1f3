"""The elasto-plastic oscillator: force against displacement, and what becomes of the position (fig. epo-force)."""
import functools
import math

import numpy as np

from .catalogue import paper
from .kept import CURVE, thin
from .page import Figure, Numbers, Section
from .runs import slipdisk
from .style import BLACK, COLOURS, GREY, figure, legend_above, zero_line
from .verdict import TOLERANCES, decide, missing, none, number, signed, within

PERMANENT = ("The oscillator's drift is that of permanent sliding, <i>A</i>&omega; "
             "sin(&pi;<i>f</i>/2&mu;<i>mg</i>).")


class Record:
    """A result: a disk that cannot turn, on a wall that is shaken along itself; x is that of the disk seen from the
    wall."""

    def __init__(self, path):
        result = slipdisk.Result(path)
        deck, frames, contacts = result.deck, result.frames, result.contacts
        time, block = frames.time, frames["position"][:, 0, 0]
        wall = result.wall_frames["position"][:, 0, 0]
        moment = contacts.time[contacts.count == 1]  # one contact: with the wall
        tau, sliding, weight = (contacts[name] for name in ("tau", "sliding", "force"))
        self.push, self.mu = deck.disks[0].force[0], deck.materials[0].mu
        self.amplitude, self.omega = deck.motions[0].amplitude, deck.motions[0].omega
        k = np.searchsorted(time, moment - 1e-9)
        self.time, self.place, self.x = time[k], block[k], block[k] - wall[k]
        self.force = tau + self.push  # of contact and constant force together, along the wall
        self.sliding, self.weight = sliding, float(np.median(weight))
        last = self.time > self.time[-1] - 4.9  # dense data only, not the frame of step 0
        for name in ("time", "place", "x", "force", "sliding"):
            setattr(self, name, getattr(self, name)[last])

    def drift(self):
        """(velocity over whole periods, its error from the scatter of ten parts)."""
        period = 2 * math.pi / self.omega
        step = (self.time[-1] - self.time[0]) / (len(self.time) - 1)
        per = round(period / step)
        marks = self.place[::per]
        speed = np.diff(marks) / (per * step)
        parts = speed[:len(speed) // 10 * 10].reshape(10, -1).mean(axis=1)
        return float(speed.mean()), float(parts.std(ddof=1) / math.sqrt(10))

    def slope(self):
        """(mean, scatter) of the change of force per displacement while the joint is stuck."""
        stuck = self.sliding == 0
        both = stuck[1:] & stuck[:-1]
        slope = np.diff(self.force)[both] / np.diff(self.x)[both]
        return (float(slope.mean()), float(slope.std())) if both.any() else (math.nan, math.nan)

    def numbers(self):
        speed, error = self.drift()
        slope, spread = self.slope()
        return {"push": self.push, "mu": self.mu, "amplitude": self.amplitude, "omega": self.omega,
                "weight": self.weight, "force_min": self.force.min(), "force_max": self.force.max(),
                "sliding": np.mean(self.sliding != 0), "drift": speed, "drift_error": error, "slope": slope,
                "slope_spread": spread, "duration": self.time[-1] - self.time[0]}

    def loop(self):
        """Of the last four periods."""
        last = self.time > self.time[-1] - 8 * math.pi / self.omega
        return thin({"x": self.x[last], "force": self.force[last], "sliding": self.sliding[last]})

    def trace(self):
        return thin({"time": self.time - self.time[0], "place": self.place - self.place[0]}, 2 * CURVE)


class Oscillator:
    """What is drawn and judged of a record."""

    def __init__(self, one, loop, trace):
        for name, value in one.rows[0].items():
            setattr(self, name, value)
        self.limits = (-self.mu * self.weight + self.push, self.mu * self.weight + self.push)
        self.loop, self.trace = loop, trace

    def permanent(self):
        """Drift when the elastic phase lasts no time and A w^2 is far above mu g (docs/validation.md)."""
        return self.amplitude * self.omega * math.sin(math.pi / 2 * self.push / (self.mu * self.weight))


def oscillator_of(results, name, out):
    """The oscillator of a run, or None."""
    path = results.run(name)
    record = functools.cache(lambda: Record(path))
    key, units = name.replace("_", "-"), "lengths in R, forces in mg"
    parts = [results.numbers(key + part, lambda make=make: getattr(record(), make)() if path else None,
                             f"{title}; {units}")
             for part, make, title in (("", "numbers", "oscillator"), ("-loop", "loop", "force against displacement"),
                                       ("-trace", "trace", "position against time"))]
    if not all(parts):
        out.missing.append(f"{name}: not run yet")
        return None
    return Oscillator(*parts)


def loop(axes, o, title):
    x, force = o.loop.column("x"), o.loop.column("force")
    x = 100 * (x - x[0])
    axes.plot(x, force, color=COLOURS[0], lw=1.0)
    for k, (limit, name) in enumerate(zip(o.limits, ("F_1", "F_2"))):
        axes.axhline(limit, color=GREY, lw=0.8, ls="--")
        axes.annotate(f"${name}={limit:+.2f}$", (1, limit), xycoords=("axes fraction", "data"),
                      textcoords="offset points", xytext=(-4, -11 if k == 0 else 4), ha="right", fontsize=10,
                      color=BLACK)
    zero_line(axes)
    ends = np.nonzero(np.diff(o.loop.column("sliding")))[0]
    for begin, end in list(zip(ends[:-1], ends[1:]))[-5:-1]:  # a period: two elastic branches, two of sliding
        k, width = (begin + end) // 2, max(2, (end - begin) // 10)
        axes.annotate("", (x[k + width], force[k + width]), (x[k - width], force[k - width]),
                      arrowprops={"arrowstyle": "-|>,head_width=0.22,head_length=0.45", "color": COLOURS[0], "lw": 0.8})
    axes.set_ylim(-0.165, 0.165)
    axes.set_title(title)
    axes.set_xlabel("displacement from the wall $100\\,x/R$")
    axes.set_ylabel("force $F/mg$")


def sections(results):
    out = Section("epo-force", "Elasto-plastic oscillator (figs. epo, epo-force)", "A disk that cannot turn, pressed "
                  "by its weight on a wall that is shaken along itself (harmonically, amplitude 0.01, &omega; = "
                  "20&pi;): the contact is a spring of stiffness <i>k<sub>t</sub></i> in series with a slip joint. A "
                  "constant force <i>f</i> = 0.02 along the wall shifts the limits to <i>F</i><sub>1</sub> = "
                  "&minus;&mu;<i>mg</i> + <i>f</i> and <i>F</i><sub>2</sub> = &mu;<i>mg</i> + <i>f</i>. Decks "
                  "<code>inputs/epo/symmetric.cfg</code>, <code>asymmetric.cfg</code>; the loops use a softer skin "
                  "(<i>k<sub>t</sub></i> = 20), whose elastic branches can be seen. The first 20 time units are "
                  "discarded.")
    names = ("epo_symmetric", "epo_asymmetric", "epo_soft_symmetric", "epo_soft_asymmetric")
    found = {name: oscillator_of(results, name, out) for name in names}
    found = {name: o for name, o in found.items() if o}
    picture, axes = figure(2, 2, height=5.6)
    for k, kind in enumerate(("symmetric", "asymmetric")):
        soft, stiff = found.get(f"epo_soft_{kind}"), found.get(f"epo_{kind}")
        if soft:
            loop(axes[0, k], soft, "$|F_1|=|F_2|$" if kind == "symmetric" else "$|F_1|<|F_2|$")
        below, unit = axes[1, k], (1000 if kind == "symmetric" else 1)
        for n, (o, label) in enumerate(((stiff, "$k_t=10^6$"), (soft, "$k_t=20$"))):
            if o:
                below.plot(o.trace.column("time"), unit * o.trace.column("place"), color=COLOURS[n], lw=0.8,
                           label=label)
        if stiff and stiff.push:
            time = np.array([0, stiff.duration])
            below.plot(time, unit * stiff.permanent() * time, color=BLACK, ls=":", lw=1.4, label="theory")
        zero_line(below)
        below.set_xlabel("time $t$")
        below.set_ylabel("position $1000\\,x/R$" if unit > 1 else "position $x/R$")
        if stiff or soft:
            legend_above(below, 3)
    axes[1, 0].set_ylim(-2.5, 2.5)
    out.figures.append(Figure("epo-force", picture, "Above: force on the disk (contact and constant force) against its "
                              "displacement from the wall, four periods. The force is linear in the displacement "
                              "between the limits <i>F</i><sub>1</sub> and <i>F</i><sub>2</sub>, and constant while "
                              "the joint slides. Below: position against time (mind the scale on the left), with the "
                              "drift of permanent sliding. Left: equal limits; right: unequal ones.",
                              "Force-displacement " "loops and positions of the elasto-plastic oscillator with equal "
                              "and unequal limits"))
    out.claims, rows = claims(found)
    out.tables.append(Numbers("Oscillator", ["run", "<i>f</i>", "<i>F</i><sub>1</sub>", "<i>F</i><sub>2</sub>",
                                             "least force", "largest force", "sliding (fraction)", "drift velocity",
                                             "error", "permanent sliding"], rows))
    return [out]


def claims(found):
    """(claims, rows of the table)"""
    symmetric, asymmetric = found.get("epo_symmetric"), found.get("epo_asymmetric")
    soft, out = found.get("epo_soft_asymmetric"), []
    if soft:
        slope, spread, low, high = soft.slope, soft.slope_spread, soft.force_min, soft.force_max
        excess = max(abs(low - soft.limits[0]), abs(high - soft.limits[1])) / (soft.limits[1] - soft.limits[0])
        equal = TOLERANCES["equal"]
        out.append(decide(condition=lambda factor: bool(excess < factor * equal and spread < factor * equal * abs(slope)),
                          numbers=f"slope while stuck {number(slope, digits=5)} (spread {number(spread)}; "
                                  f"&minus;<i>k<sub>t</sub></i> = &minus;20), extremes {number(low, digits=4)} and "
                                  f"{number(high, digits=4)}; limits {number(soft.limits[0], digits=4)} and "
                                  f"{number(soft.limits[1], digits=4)} (counted as equal up to {100 * equal:g} "
                                  "%)", **paper("epo-force")))
    else:
        out.append(missing(**paper("epo-force")))
    out.append(none(value=symmetric.drift, unit=symmetric.amplitude * symmetric.omega,
                    unit_name="of the wall's top speed",
                    **paper("epo-symmetric")) if symmetric else missing(**paper("epo-symmetric")))
    if asymmetric:
        v, e = asymmetric.drift, asymmetric.drift_error
        direction = 1 if abs(asymmetric.limits[0]) < abs(asymmetric.limits[1]) else -1
        claim = signed(values=[v], errors=[e], sign=direction, what="the drift", **paper("epo-asymmetric"))
        claim.numbers = (f"drift {number(v, e)} with <i>F</i><sub>1</sub> = {number(asymmetric.limits[0])}, "
                         f"<i>F</i><sub>2</sub> = {number(asymmetric.limits[1])}")
        out += [claim, within(PERMANENT, v, asymmetric.permanent(), TOLERANCES["equal"],
                              error=e, slug="epo-permanent")]
    else:
        out += [missing(**paper("epo-asymmetric")), missing(PERMANENT, slug="epo-permanent")]
    rows = []
    for name, o in found.items():
        rows.append([name, o.push, *o.limits, o.force_min, o.force_max, o.sliding, o.drift, o.drift_error,
                     o.permanent()])
    return out, rows
