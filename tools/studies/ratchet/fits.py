"""Numbers drawn from curves: an extremum or a crossing with its error, and whether the data contain one."""
import dataclasses
import math

import numpy as np


@dataclasses.dataclass
class Extremum:
    position: float
    error: float     # half the width of 68 % of the bootstrap, enlarged when chi^2 is
    value: float
    inside: float    # fraction of the bootstrap samples whose extremum is inside the range
    form: str        # "polynomial" or "quotient"
    terms: int
    chi2: float
    degrees: int
    curve: object    # function of x


def odd(x, c):
    """c_0 x + c_1 x^3 + c_2 x^5 + ..."""
    return sum(value * x ** (2 * k + 1) for k, value in enumerate(c))


def quotient(x, c):
    """c_0 x/(1 + c_1 x^2 + c_2 x^4): rises steeply and falls slowly, as no short polynomial does."""
    return c[0] * x / (1 + c[1] ** 2 * x ** 2 + c[2] ** 2 * x ** 4)


def fit_odd(x, y, error, n):
    """Weighted least squares with n terms: (coefficients, chi^2)."""
    design = np.stack([x ** (2 * k + 1) for k in range(n)], axis=1) / error[:, None]
    solution, *_ = np.linalg.lstsq(design, y / error, rcond=None)
    return solution, float(np.sum((design @ solution - y / error) ** 2))


def fit_quotient(x, y, error, start=None):
    """The same for the quotient, by Levenberg and Marquardt from several starts."""
    best = None
    starts = [start] if start is not None else [(y[0] / x[0] * (1 + f * f), f / x[0], g / x[-1] ** 2)
                                                for f in (0.1, 0.5, 1.0) for g in (0.3, 3.0)]
    for c in starts:
        c, damping = np.array(c, float), 1e-2
        rest = (quotient(x, c) - y) / error
        for _ in range(60):
            jacobian = np.empty((len(x), 3))
            for k in range(3):
                step = np.zeros(3)
                step[k] = 1e-6 * max(abs(c[k]), 1e-6)
                jacobian[:, k] = ((quotient(x, c + step) - y) / error - rest) / step[k]
            normal = jacobian.T @ jacobian
            change = np.linalg.lstsq(normal + damping * np.diag(np.diag(normal) + 1e-30), -jacobian.T @ rest,
                                     rcond=None)[0]
            trial = (quotient(x, c + change) - y) / error
            if trial @ trial < rest @ rest:
                gain = rest @ rest - trial @ trial
                c, rest, damping = c + change, trial, damping / 5
                if gain < 1e-8 * (1 + trial @ trial):
                    break
            else:
                damping *= 5
                if damping > 1e8:
                    break
        if best is None or rest @ rest < best[1]:
            best = (c, float(rest @ rest))
    return best


def _lowest(function, sign):
    """Place in (0, 1] where sign * function is least, and whether it is a turning point."""
    x = np.linspace(0, 1, 2001)[1:]
    k = int(np.argmin(sign * function(x)))
    return x[k], k < len(x) - 1


def best_form(x, y, error, start=None):
    """(form, terms, coefficients, chi^2) of the form with the least AICc: an odd polynomial of two to five terms, or
    the quotient. start: coefficients from which the quotient sets out."""
    forms = [("polynomial", n, *fit_odd(x, y, error, n)) for n in range(2, min(5, len(x) - 2) + 1)]
    if len(x) >= 5:
        forms.append(("quotient", 3, *fit_quotient(x, y, error, start)))
    return min(forms, key=lambda f: f[3] + 2 * f[1] + 2 * f[1] * (f[1] + 1) / max(len(x) - f[1] - 1, 0.5))


def extremum(x, y, error, samples=400, seed=1):
    """Extremum of an odd function through points with error bars; None when they are fewer than four.

    The error is half of what holds the middle 68 % of the extrema when each point is scattered by its error bar and
    the form is chosen anew each time (so that it contains what the choice of the form does), times
    sqrt(chi^2/degrees) where that is above 1.
    """
    x, y, error = (np.asarray(v, float) for v in (x, y, error))
    good = np.isfinite(y) & np.isfinite(error) & (error > 0) & (x > 0)
    order = np.argsort(x[good])
    x, y, error = x[good][order], y[good][order], error[good][order]
    if len(x) < 4:
        return None
    last = x.max()
    u = x / last
    form, n, c, chi2 = best_form(u, y, error)
    shapes = {"polynomial": odd, "quotient": quotient}
    start = c if form == "quotient" else fit_quotient(u, y, error)[0] if len(x) >= 5 else None
    sign = 1 if y[np.argmax(np.abs(y / error))] < 0 else -1
    position, _ = _lowest(lambda v: shapes[form](v, c), sign)
    rng = np.random.default_rng(seed)
    places, inside = [], 0
    for _ in range(samples):
        drawn = best_form(u, y + rng.normal(size=len(y)) * error, error, start)
        place, turning = _lowest(lambda v, d=drawn: shapes[d[0]](v, d[2]), sign)
        places.append(place)
        inside += turning
    stretch = max(1.0, np.sqrt(chi2 / (len(x) - n)))
    low, high = np.percentile(places, (15.87, 84.13)) if samples else (math.nan, math.nan)
    return Extremum(float(position * last), float(high - low) / 2 * last * stretch,
                    float(shapes[form](position, c)), inside / samples if samples else math.nan, form, n, chi2,
                    len(x) - n, lambda v: shapes[form](np.asarray(v, float) / last, c))


@dataclasses.dataclass
class Power:
    exponent: float
    error: float
    chi2: float
    degrees: int
    curve: object  # function of x


def power_law(x, y, error):
    """y = a x^b by weighted least squares in logarithms; None for fewer than three points."""
    x, y, error = (np.asarray(v, float) for v in (x, y, error))
    if len(x) < 3 or not (np.all(y > 0) and np.all(error > 0)):
        return None
    middle = np.log(x).mean()
    weight = y / error
    design = np.stack([np.ones(len(x)), np.log(x) - middle], axis=1) * weight[:, None]
    c, *_ = np.linalg.lstsq(design, np.log(y) * weight, rcond=None)
    spread = np.linalg.inv(design.T @ design)
    return Power(float(c[1]), float(np.sqrt(spread[1, 1])), float(np.sum((design @ c - np.log(y) * weight) ** 2)),
                 len(x) - 2, lambda v: np.exp(c[0] + c[1] * (np.log(np.asarray(v, float)) - middle)))


def crossing(x, y, error=None, samples=1000, seed=1):
    """(place where y changes sign, its error) by a cubic through the four points around it; None when there
    is none. The error has two parts: scattered error bars, and what the straight line says instead."""
    x, y = np.asarray(x, float), np.asarray(y, float)
    good = np.isfinite(x) & np.isfinite(y)
    x, y = x[good], y[good]
    error = np.zeros(len(x)) if error is None else np.nan_to_num(np.asarray(error, float)[good])
    order = np.argsort(x)
    x, y, error = x[order], y[order], error[order]
    change = np.nonzero(np.sign(y[:-1]) * np.sign(y[1:]) <= 0)[0]
    if len(change) == 0:
        return None
    k = int(change[0])
    first = min(max(0, k - 1), max(0, len(x) - 4))
    near = slice(first, first + 4)
    straight = x[k] - y[k] * (x[k + 1] - x[k]) / (y[k + 1] - y[k]) if y[k] != y[k + 1] else x[k]
    curved = _cubic_root(x[near], y[near], x[k], x[k + 1], straight)
    rng = np.random.default_rng(seed)
    drawn = [_cubic_root(x[near], y[near] + rng.normal(size=len(x[near])) * error[near], x[k], x[k + 1], straight)
             for _ in range(samples if error[near].any() else 0)]
    spread = float(np.std(drawn)) if drawn else 0.0
    return float(curved), float(np.hypot(spread, abs(curved - straight) / 2))


def _cubic_root(x, y, low, high, otherwise):
    middle = x.mean()
    roots = np.roots(np.polyfit(x - middle, y, len(x) - 1)) + middle
    real = roots[np.abs(roots.imag) < 1e-9].real
    slack = 0.5 * (high - low)
    real = real[(real >= low - slack) & (real <= high + slack)]
    return real[np.argmin(np.abs(real - otherwise))] if len(real) else otherwise
