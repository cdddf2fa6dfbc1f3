"""Do groups of packings differ? Tests for few, unequal groups; a packing is one number."""
import math

import numpy as np

from ratchet.verdict import survival

from .statistics import ranks

SHUFFLES = 4000


def student(t, degrees):
    """Chance of a larger |t|: with t = sqrt(degrees) tan(a) Student's density is ~ cos(a)^(degrees - 1)."""
    if degrees < 1 or not math.isfinite(t):
        return math.nan
    angle = np.linspace(0, math.pi / 2, 2001)
    density = np.cos(angle) ** (degrees - 1)
    begin = math.atan(abs(t) / math.sqrt(degrees))
    tail = np.linspace(begin, math.pi / 2, 2001)
    return float(np.trapz(np.cos(tail) ** (degrees - 1), tail) / np.trapz(density, angle))


def percent(chance):
    if chance < 1e-5:
        return "less than 0.001 %"
    return f"{100 * chance:.0f} %" if chance > 0.1 else f"{100 * chance:.2g} %"


def differ(groups, seed=1):
    """Chance that groups of one population differ as much in their mean ranks (Kruskal and Wallis), by shuffling."""
    groups = [np.asarray(g, float) for g in groups if len(g)]
    sizes = [len(g) for g in groups]
    if len(groups) < 2 or sum(sizes) - len(groups) < 2:
        return math.nan
    place, ends = ranks(np.concatenate(groups)), np.cumsum(sizes)[:-1]

    def statistic(orders):
        return sum(part.sum(axis=1) ** 2 / part.shape[1] for part in np.split(orders, ends, axis=1))

    shuffled = np.random.default_rng(seed).permuted(np.tile(place, (SHUFFLES, 1)), axis=1)
    above = int(np.sum(statistic(shuffled) >= statistic(place[None])[0] * (1 - 1e-12)))
    return (above + 1) / (SHUFFLES + 1)


def together(chances):
    """Chance that independent tests of one statement give such chances (Fisher)."""
    chances = [chance for chance in chances if math.isfinite(chance)]
    return survival(-2 * sum(math.log(max(c, 1e-300)) for c in chances), 2 * len(chances)) if chances else math.nan


def exponent(x, y):
    """y ~ x^b through all packings: (b, its error, degrees). Error from the scatter of packings."""
    x, y = np.log(np.asarray(x, float)), np.log(np.asarray(y, float))
    degrees = len(x) - 2
    if degrees < 1 or np.ptp(x) == 0:
        return math.nan, math.nan, degrees
    centred = x - x.mean()
    slope = float(np.sum(centred * y) / np.sum(centred ** 2))
    rest = y - y.mean() - slope * centred
    return slope, float(math.sqrt(np.sum(rest ** 2) / degrees / np.sum(centred ** 2))), degrees
