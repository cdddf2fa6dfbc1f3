"""Elasto-plastic oscillators under random forcing: normal diffusion with equal limits, drift with unequal ones."""
import functools
import math

import numpy as np

from .catalogue import paper
from .kept import CURVE, thin
from .page import Figure, Numbers, Section
from .runs import slipdisk
from .style import BLACK, COLOURS, figure, legend_above
from .verdict import NO, OPEN, SURE, YES, Claim, missing, number, signed, zero

EQUAL = 16                 # of the blocks of inputs/epo/random.cfg; the others are pushed
FIRST, LAST = 1.0, 20.0    # lags of the fit
LARGEST_ERROR = 0.05       # of an exponent that can be told from those beside it


class Record:
    """Displacement of each block since the drive was on."""

    def __init__(self, path):
        frames = slipdisk.Result(path).frames
        begin = np.argmax(frames.time > 1 - 1e-9)  # the settled state
        self.time = frames.time[begin:] - frames.time[begin]
        self.x = frames["position"][begin:, :, 0] - frames["position"][begin, :, 0]

    def trace(self):
        return thin({"time": self.time, **{f"x{k}": column for k, column in enumerate(self.x.T)}}, CURVE // 2)

    def squares(self):
        lags, msd = spread(self.x[:, :EQUAL], self.time[1] - self.time[0])
        return {"lag": lags, **{f"x{k}": column for k, column in enumerate(msd.T)}}


def spread(x, step):
    """(lags, mean square displacement of each block at them)"""
    lags = np.unique(np.round(np.geomspace(1, len(x) // 4, 24)).astype(int))
    return lags * step, np.array([np.mean((x[lag:] - x[:-lag]) ** 2, axis=0) for lag in lags])


def blocks(table):
    """Columns x0, x1, ... side by side."""
    return np.stack([table.column(f"x{k}") for k in range(sum(key.startswith("x") for key in table.rows[0]))], axis=1)


def exponent(lags, msd):
    """(exponent of the mean over blocks, its error from leaving each out)"""
    inside = (lags >= FIRST * 0.999) & (lags <= LAST * 1.001)

    def slope(chosen):
        return np.polyfit(np.log(lags[inside]), np.log(chosen[inside].mean(axis=1)), 1)[0]

    n = msd.shape[1]
    parts = np.array([slope(np.delete(msd, k, axis=1)) for k in range(n)])
    return float(slope(msd)), float(math.sqrt((n - 1) / n * np.sum((parts - parts.mean()) ** 2)))


def sections(results):
    out = Section("diffusion", "Elasto-plastic oscillators under random forcing",
                  "Deck <code>inputs/epo/random.cfg</code>: 24 disks that cannot turn, each on a wall of its own that "
                  "is shaken at random along itself (rms amplitude 10<sup>&minus;3</sup>, &omega; = 20&pi;, rms "
                  "acceleration 3.9 <i>&mu;g</i>); 16 with equal limits, 8 pushed by <i>f</i> = 0.02. Exponent of "
                  f"&lang;<i>x</i>&sup2;&rang; between {FIRST:g} and {LAST:g} time units, its error from leaving out "
                  "each oscillator in turn.")
    path = results.run("epo_random")
    record = functools.cache(lambda: Record(path))
    made = (lambda: record().trace() if path else None), (lambda: record().squares() if path else None)
    trace = results.numbers("epo-random", made[0], "displacement of each oscillator", digits=5)
    squares = results.numbers("epo-random-msd", made[1], "mean square displacement of each", digits=5)
    slugs = ("epo-diffusion", "epo-random-drift")
    if not trace or not squares:
        out.missing.append("epo_random: not run yet")
        out.claims = [missing(**paper(slug)) for slug in slugs]
        return [out]
    time, x, lags, msd = trace.column("time"), blocks(trace), squares.column("lag"), blocks(squares)
    power, error = exponent(lags, msd)
    speed = x[-1] / time[-1]
    out.figures.append(draw(time, x, lags, msd, power))
    off = abs(power - 1)
    mean = [(float(v.mean()), float(v.std(ddof=1) / math.sqrt(len(v)))) for v in (speed[:EQUAL], speed[EQUAL:])]
    constant = float(np.mean(msd[-1]) / lags[-1] / 2)
    out.claims = [Claim(verdict=lambda factor: NO if off > factor * SURE * error
                        else OPEN if error > LARGEST_ERROR else YES, numbers=f"exponent {number(power, error)} (counted as 1 within {SURE:g} "
                                                 f"errors, when its error is below {LARGEST_ERROR:g}); diffusion "
                                                 f"constant {number(constant, digits=2)}",
                        rule="exponent", **paper("epo-diffusion")),
                  zero("Oscillators with equal limits under random forcing do not drift.", [mean[0][0]], [mean[0][1]],
                       what="drift", slug="epo-random-level"),
                  signed(values=[mean[1][0]], errors=[mean[1][1]], sign=1,
                         what="the mean drift", **paper("epo-random-drift"))]
    out.claims[-1].numbers += (f"; drift {number(*mean[1])} of {len(speed) - EQUAL} oscillators with limits "
                               "&minus;0.08 and 0.12")
    out.tables.append(Numbers("Mean square displacement", ["lag", "&lang;<i>x</i>&sup2;&rang;", "error"],
                              [[t, float(v.mean()), float(v.std(ddof=1) / math.sqrt(len(v)))]
                               for t, v in zip(lags, msd)]))
    return [out]


def draw(time, x, lags, msd, power):
    picture, (left, right) = figure(2, 1, height=3.6, width=7.4)
    for k in range(x.shape[1]):
        pushed = k >= EQUAL
        left.plot(time, x[:, k], color=COLOURS[int(pushed)], lw=0.6, label=("$f=0.02$" if pushed else
                                                                            "$f=0$") if k in (0, EQUAL) else None)
    left.set_xlabel("time $t$")
    left.set_ylabel("position $x/R$")
    legend_above(left, 2)
    mean, error = msd.mean(axis=1), msd.std(axis=1, ddof=1) / math.sqrt(msd.shape[1])
    right.errorbar(lags, mean, yerr=error, fmt="o", ms=4,
                   mfc="white", color=COLOURS[0], lw=0, elinewidth=0.9,
                   label="$f=0$")
    inside = (lags >= FIRST * 0.999) & (lags <= LAST * 1.001)
    level = np.exp(np.mean(np.log(mean[inside]) - power * np.log(lags[inside])))
    right.plot(lags[inside], level * lags[inside] ** power, color=BLACK, lw=1, label=f"exponent {power:.2f}")
    right.set_xscale("log")
    right.set_yscale("log")
    right.set_xlabel("lag")
    right.set_ylabel(r"$\langle x^2\rangle/R^2$")
    legend_above(right, 2)
    return Figure("epo-diffusion", picture, "Left: positions of the oscillators. Right: mean square displacement of "
                                            "those with equal limits; line: fitted power "
                                            "law.", "Positions of randomly forced oscillators, and their mean square "
                                                    "displacement")
