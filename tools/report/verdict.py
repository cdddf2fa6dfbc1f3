"""Claims, and how data decide about them.

A claim is a sentence of the paper (or of the theory) in own words. Its verdict follows from numbers by one of
the rules below and from nothing else; a claim whose data are missing or too noisy says so.
"""
import dataclasses
import math

import numpy as np

YES, NO, OPEN = "reproduced", "not reproduced", "cannot tell"
PAPER, CHECK, TRIVIAL = "paper", "own check", "by construction"  # TRIVIAL: geometry, waveforms, identities
SURE = 3.0  # errors that count as significant


@dataclasses.dataclass
class Claim:
    text: str     # HTML
    verdict: str  # YES, NO or OPEN
    numbers: str  # HTML: what was found
    place: str = ""  # where the paper says so; "": a statement that is not the paper's
    kind: str = ""   # PAPER, CHECK or TRIVIAL; "": PAPER with a place, CHECK without
    slug: str = ""   # short unique name, "random-clockwise" say

    def __post_init__(self):
        self.kind = self.kind or (PAPER if self.place else CHECK)


def missing(text, place="", why="no data yet", **kind):
    """kind: kind and slug of the claim, here and below."""
    return Claim(text, OPEN, why, place, **kind)


def number(x, error=None, digits=3):
    """x or x +- error in HTML, rounded by the error."""
    if x is None or not math.isfinite(x):
        return "&ndash;"
    if error is None or not math.isfinite(error) or error <= 0:
        text, exponent = f"{x:.{digits}g}", 0
        if "e" in text:
            text, exponent = text.split("e")
        return _minus(text) + _power(int(exponent))
    exponent = math.floor(math.log10(max(abs(x), error)))
    if -3 <= exponent < 4:
        exponent = 0
    scale = 10.0 ** exponent
    places = min(max(0, 1 - math.floor(math.log10(error / scale))), 6)
    if error / scale < 0.5 * 10 ** -places:  # more digits than anybody wants
        return f"{number(x, digits=7)} &plusmn; {number(error, digits=1)}"
    text = f"{x / scale:.{places}f} &plusmn; {error / scale:.{places}f}"
    return _minus(f"({text})" if exponent else text) + _power(exponent)


def _minus(text):
    return text.replace("-", "&minus;")


def _power(exponent):
    return f"&times;10<sup>{_minus(str(exponent))}</sup>" if exponent else ""


def percent(x, digits=2):
    return "&ndash;" if not math.isfinite(x) else _minus(f"{100 * x:+.{digits if abs(x) < 0.1 else 0}f}") + " %"


def sliding(signs):
    """S with these signs, "+-" say, in HTML."""
    return f"S<sup>{_minus(signs)}</sup>"


def chi_square(residuals, degrees):
    """(chi^2, probability of a larger one) for residuals in units of their errors."""
    chi2 = float(np.sum(np.square(residuals)))
    return chi2, survival(chi2, degrees)


def survival(chi2, degrees):
    """Probability that chi^2 of so many degrees of freedom is larger: the regularised Gamma function Q."""
    a, x = degrees / 2, chi2 / 2
    if degrees < 1 or x <= 0:
        return 1.0
    if x < a + 1:  # series for P
        term = total = 1 / a
        for k in range(1, 1000):
            term *= x / (a + k)
            total += term
            if term < total * 1e-14:
                break
        return 1 - total * math.exp(-x + a * math.log(x) - math.lgamma(a))
    b, c = x + 1 - a, 1e300  # continued fraction for Q (Lentz)
    d = h = 1 / b
    for k in range(1, 1000):
        an = -k * (k - a)
        b += 2
        d = 1 / (an * d + b)
        c = b + an / c
        h *= d * c
        if abs(d * c - 1) < 1e-14:
            break
    return h * math.exp(-x + a * math.log(x) - math.lgamma(a))


def zero(text, values, errors, place="", what="&Omega;", **kind):
    """All values are zero within their errors."""
    values, errors = np.asarray(values, float), np.asarray(errors, float)
    good = np.isfinite(values) & (errors > 0)
    if not good.any():
        return missing(text, place, **kind)
    z = values[good] / errors[good]
    chi2, chance = chi_square(z, len(z))
    worst = float(np.abs(z).max())
    numbers = (f"{len(z)} value{'s' * (len(z) > 1)}, largest |{what}| {worst:.1f} errors from zero, &chi;&sup2; = "
               f"{chi2:.1f} (a chance of {100 * chance:.3g} %)")
    verdict = YES if chance > 0.01 else NO if chance < 1e-4 else OPEN
    return Claim(text, verdict, numbers, place, **kind)


def signed(text, values, errors, sign, place="", what="&Omega;", **kind):
    """All values have this sign: none has the other one significantly, and most have this one so."""
    values, errors = np.asarray(values, float), np.asarray(errors, float)
    good = np.isfinite(values) & (errors >= 0)
    if not good.any():
        return missing(text, place, **kind)
    z = sign * values[good] / np.maximum(errors[good], 1e-300)
    word, other = ("positive", "negative") if sign > 0 else ("negative", "positive")
    right, wrong = int((z > SURE).sum()), int((z < -SURE).sum())
    numbers = (f"of {len(z)} values of {what} {right} are {word} by more than {SURE:g} errors, {wrong} {other} by more "
               f"than that, {len(z) - right - wrong} undecided")
    verdict = NO if wrong else YES if right > len(z) / 2 else OPEN
    return Claim(text, verdict, numbers, place, **kind)


def within(text, value, target, tolerance, place="", error=0.0, names=("found", "expected"), **kind):
    """value equals target within a relative tolerance; the error decides whether this can be told."""
    if value is None or target is None or not (math.isfinite(value) and math.isfinite(target)):
        return missing(text, place, **kind)
    off = (value - target) / abs(target)
    spread = (error if math.isfinite(error) else 0) / abs(target)
    numbers = (f"{names[0]} {number(value, error, 5)}, {names[1]} {number(target, digits=5)}: {percent(off)} "
               f"(counted as equal up to {100 * tolerance:g} %)")
    verdict = YES if abs(off) + spread <= tolerance else NO if abs(off) - 2 * spread > tolerance else OPEN
    return Claim(text, verdict, numbers, place, **kind)


def decide(text, condition, numbers, place="", **kind):
    """condition: True, False, or None when it cannot be told."""
    return Claim(text, OPEN if condition is None else YES if condition else NO, numbers, place, **kind)
