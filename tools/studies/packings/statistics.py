"""Numbers with error bars from several packings: packings are independent of each other, disks of one are not."""
import dataclasses

import numpy as np

from ratchet.verdict import number, survival


def mean_error(values):
    """(mean, standard error) of independent values; the error is nan for fewer than two."""
    values = np.asarray([v for v in values if np.isfinite(v)], float)
    if len(values) == 0:
        return np.nan, np.nan
    return float(values.mean()), float(values.std(ddof=1) / np.sqrt(len(values))) if len(values) > 1 else np.nan


def jackknife(function, groups):
    """(function of all groups, its standard error from leaving out one group at a time)."""
    groups = list(groups)
    value, n = function(groups), len(groups)
    if n < 2:
        return value, np.nan
    left = np.array([function(groups[:k] + groups[k + 1:]) for k in range(n)])
    return value, float(np.sqrt((n - 1) / n * np.sum((left - left.mean()) ** 2)))


def pearson(a, b):
    a, b = np.asarray(a, float), np.asarray(b, float)
    if len(a) < 3 or a.std() == 0 or b.std() == 0:
        return np.nan
    return float(np.corrcoef(a, b)[0, 1])


def ranks(values):
    """Ranks from 0; equal values share the mean of theirs."""
    values = np.asarray(values, float)
    order = np.argsort(values, kind="stable")
    out = np.empty(len(values))
    out[order] = np.arange(len(values))
    _, where, count = np.unique(values, return_inverse=True, return_counts=True)
    return (np.bincount(where, out) / count)[where]


def spearman(a, b):
    return pearson(ranks(a), ranks(b))


def pooled(function):
    """function of two samples as a function of groups of such pairs, for jackknife."""
    return lambda groups: function(*(np.concatenate([g[k] for g in groups]) for k in range(2)))


def moments(values):
    """(mean, rms, skewness, excess kurtosis); the last two about the mean."""
    values = np.asarray(values, float)
    centred = values - values.mean()
    variance = np.mean(centred ** 2)
    if variance == 0:
        return float(values.mean()), 0.0, np.nan, np.nan
    return (float(values.mean()), float(np.sqrt(np.mean(values ** 2))), float(np.mean(centred ** 3) / variance ** 1.5),
            float(np.mean(centred ** 4) / variance ** 2 - 3))


def line(x, y, error=None):
    """Straight line by least squares: (slope, its error, intercept, its error). Without error bars: by scatter."""
    x, y = np.asarray(x, float), np.asarray(y, float)
    good = np.isfinite(x) & np.isfinite(y)
    weight = np.ones(len(x)) if error is None else 1 / np.asarray(error, float) ** 2
    good &= np.isfinite(weight)
    x, y, weight = x[good], y[good], weight[good]
    if len(x) < 2 or np.ptp(x) == 0:
        return (np.nan,) * 4
    design = np.stack([x, np.ones(len(x))], axis=1)
    covariance = np.linalg.inv(design.T @ (design * weight[:, None]))
    slope, offset = covariance @ (design.T @ (weight * y))
    rest = float(np.sum(weight * (y - slope * x - offset) ** 2))
    degrees = len(x) - 2
    if error is None:
        stretch = rest / degrees if degrees else np.nan
    else:  # error bars count as given, unless the points scatter more
        stretch = max(1.0, rest / degrees) if degrees else 1.0
    errors = np.sqrt(np.diag(covariance) * stretch)
    return float(slope), float(errors[0]), float(offset), float(errors[1])


def power_law(x, y):
    """Exponent of y ~ x^a by a straight line through logarithms, all points alike: (a, error, factor)."""
    x, y = np.asarray(x, float), np.asarray(y, float)
    good = (x > 0) & (y > 0)
    slope, error, offset, _ = line(np.log(x[good]), np.log(y[good]))
    return slope, error, float(np.exp(offset))


def two_sided(chi2, degrees):
    """Chance of a chi^2 as far from what is expected, to either side: small too where error bars are too large."""
    above = survival(chi2, degrees)
    return min(1.0, 2 * min(above, 1 - above))


@dataclasses.dataclass
class Power:
    """y ~ factor x^exponent through means of log y over packings, each with the weight that its scatter gives."""
    exponent: float = np.nan
    error: float = np.nan    # from leaving out one packing at a time
    weights: float = np.nan  # from the error bars of the points
    factor: float = np.nan
    chi2: float = np.nan
    points: int = 0

    @property
    def chance(self):
        return two_sided(self.chi2, self.points - 2) if self.points > 2 else np.nan

    def __str__(self):
        fit = (f", &chi;&sup2; = {number(self.chi2, digits=2)} for {self.points - 2} (a chance of "
               f"{100 * self.chance:.2g} %)"
               if self.points > 2 else "")
        alone = f"; by the weights of the points &plusmn; {number(self.weights, digits=2)}"
        return f"{number(self.exponent, self.error)} ({self.points} drives{fit}{alone})"


FEW = 4  # packings: of fewer their own scatter says little, and that of all points stands for it


def _log_means(curves, x):
    """Means of log y at each x with their errors; curves: {x: y} of each packing."""
    logs = [np.log([curve[point] for curve in curves if curve.get(point, 0) > 0]) for point in x]
    spread = np.array([values.std(ddof=1) if len(values) > 1 else np.nan for values in logs])
    if min(map(len, logs), default=0) < FEW:
        spread = np.full(len(x), np.sqrt(np.nanmean(spread ** 2)) if np.isfinite(spread).any() else np.nan)
    return (np.array([values.mean() if len(values) else np.nan for values in logs]),
            spread / np.sqrt([max(len(values), 1) for values in logs]))


def _power(curves, x):
    mean, error = _log_means(curves, x)
    good = np.isfinite(mean) & (error > 0)
    if good.sum() < 2:
        return Power(points=int(good.sum()))
    x = np.log(np.asarray(x, float)[good])
    mean, weight = mean[good], error[good] ** -2
    middle = np.average(x, weights=weight)
    width = float(np.sum(weight * (x - middle) ** 2))
    slope = float(np.sum(weight * (x - middle) * mean) / width)
    offset = float(np.average(mean, weights=weight) - slope * middle)
    chi2 = float(np.sum(weight * (mean - slope * x - offset) ** 2))
    return Power(slope, np.nan, width ** -0.5, float(np.exp(offset)), chi2, len(x))


def weighted_power(curves, x):
    """Power for {x: y} of each packing, at these x; its error from leaving out one packing at a time."""
    found = _power(curves, x)
    found.error = jackknife(lambda part: _power(part, x).exponent, curves)[1] if len(curves) > 2 else found.weights
    return found


def share(groups):
    """(part, error) of pairs (how many, of how many), one for each packing: by the scatter of packings, and no less
    than if all were independent."""
    groups = [g for g in groups if g[1]]
    if not groups:
        return np.nan, np.nan
    value, error = jackknife(lambda part: sum(g[0] for g in part) / sum(g[1] for g in part), groups)
    some, every = (sum(g[k] for g in groups) for k in range(2))
    likely = (some + 1) / (every + 2)  # not zero where none is found
    return value, float(np.nanmax([error, np.sqrt(likely * (1 - likely) / every)]))


def crossing(x, y, level):
    """Where y first rises through a level, between two points of a curve in logarithms; nan when it does not.

    Points with y = 0 count as a thousandth of the least positive value, so that an onset from zero has a place."""
    x, y = np.asarray(x, float), np.asarray(y, float)
    if not (y > 0).any():
        return np.nan
    y = np.where(y > 0, y, y[y > 0].min() * 1e-3)
    for k in range(len(x) - 1):
        if y[k] < level <= y[k + 1]:
            part = (np.log(level) - np.log(y[k])) / (np.log(y[k + 1]) - np.log(y[k]))
            return float(np.exp(np.log(x[k]) + part * (np.log(x[k + 1]) - np.log(x[k]))))
    return np.nan


def trend(curves):
    """(rank correlation of x and y over all packings, its error); curves: {x: y} of each packing."""
    return jackknife(lambda part: spearman([x for c in part for x in c], [y for c in part for y in c.values()]), curves)
