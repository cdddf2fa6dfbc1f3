"""Numbers with error bars from several packings: packings are independent of each other, disks of one are not."""
import numpy as np


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
    """Exponent of y ~ x^a by a straight line through logarithms: (a, error, factor)."""
    x, y = np.asarray(x, float), np.asarray(y, float)
    good = (x > 0) & (y > 0)
    slope, error, offset, _ = line(np.log(x[good]), np.log(y[good]))
    return slope, error, float(np.exp(offset))


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
