"""Claims, and how data decide about them.

A claim is a sentence of the paper (or of the theory) in own words. Its verdict follows from numbers by one of
the rules below and from nothing else; a claim whose data are missing or too noisy says so. A rule with a tolerance
is a function of the factor on it, so that each claim knows where its verdict would turn.
"""
import dataclasses
import math

import numpy as np

YES, NO, OPEN = "reproduced", "not reproduced", "cannot tell"
DEPENDS = "depends"  # on what the paper does not give: true in some fields, false in others
WORDS = (YES, NO, DEPENDS, OPEN)
PAPER, CHECK, TRIVIAL = "paper", "own check", "by construction"  # TRIVIAL: geometry, waveforms, identities
MOTIONS = ("harmonic", "random")  # of a floor that shakes packings
SURE = 3.0  # errors that count as significant
REFUTED, DOUBTED = 1e-4, 0.01  # chances of chi^2: above it, and on either side
TOLERANCES = {
    "equal": 0.01,
    "excellent": 0.02,
    "curve": 0.05,
    "none": 1e-3,
    "absent": 1e-3,
    "most": 0.5,
    "proportional": 0.1,
    "rare": 0.1,
    "estimate": 0.2,
    "depends": 0.1,
}
MEANING = {
    "equal": "relative: a number and its formula",
    "excellent": "relative: \"excellent agreement\", a theory that is met, the end of an approach",
    "curve": "of its largest value: a curve and its formula",
    "none": "of the drive's speed: rotation without noise that counts as none",
    "absent": "fraction of time: what lasts less does not occur",
    "proportional": "relative, either way: a ratio that is to be the same",
    "most": "fraction of time: most of the time",
    "rare": "fraction of time: neither contact slides longer, or elastic deformation lasts no longer",
    "estimate": "relative: a value and what can be used as an estimate of it",
    "depends": "relative: a change of &Omega; from the paper's value of a parameter to the next one",
}
RULES = {
    "zero": f"&chi;&sup2; of all values from zero: a chance below {100 * REFUTED:g} % for a larger one refutes; a "
            f"chance below {100 * DOUBTED:g} % on either side leaves it open (a &chi;&sup2; that is too small means "
            "error bars that are too large). Tolerance: these chances",
    "scatter": "&chi;&sup2; of values from their mean, as for zero; where error bars themselves are judged a chance "
               f"below {100 * REFUTED:g} % on either side refutes. Tolerance: these chances",
    "none": "without noise: the speed is below the tolerance, in units of the drive's speed",
    "sign": f"every point has the sign by more than {SURE:g} errors; one with the other sign refutes, by as many "
            f"errors as chance gives one of so many points as seldom as a single one {SURE:g} (Bonferroni); else open, "
            "and the undecided points are named. Tolerance: these errors",
    "growth": "as for a sign, of the steps from each point to the next",
    "equal": f"the relative difference is within the tolerance by {SURE:g} errors; beyond it by {SURE:g} errors "
             "refutes; else open",
    "approach": "the largest relative deviation falls by more than its error from each amplitude to the next until it "
                "is within what counts as excellent, and stays there; a rise, or an end outside, refutes",
    "excellent": "as for equal, for the largest relative deviation at the largest amplitude",
    "fields": "the statement is judged for each value of what the paper does not give: true in all of these fields it "
              "is reproduced, true in none it is not, else it depends on the field",
    "extremum": "at every amplitude one of the inner tilts turns the disk faster than the largest tilt does, by as "
                "many errors as a sign needs; the other way round at all inner tilts of one amplitude refutes. "
                "Tolerance: these errors",
    "exponent": f"it is within {SURE:g} errors of what is expected, and its error is small enough to tell; beyond "
                f"{SURE:g} errors refutes. Tolerance: these errors",
    "threshold": "a condition that stands beside the numbers. Tolerance: the number in it, if there is one",
}
FACTORS = tuple(10 ** (k / 20) for k in range(1, 61))  # of a tolerance, in search of the one that turns a verdict


@dataclasses.dataclass
class Claim:
    text: str     # HTML
    verdict: str  # YES, NO, OPEN or DEPENDS; or a function that gives it, or True, False, None, for a factor on the
                  # tolerance: then half, double and turns are known
    numbers: str  # HTML: what was found
    place: str = ""  # where the paper says so; "": a statement that is not the paper's
    kind: str = ""   # PAPER, CHECK or TRIVIAL; "": PAPER with a place, CHECK without
    slug: str = ""   # short unique name, "random-clockwise" say
    rule: str = "threshold"  # of RULES; "": no data
    half: str = ""    # verdict at half the tolerance
    double: str = ""  # and at twice
    turns: float = math.nan  # nearest factor on the tolerance that turns the verdict; infinite: none up to 1000
    motion: str = ""  # of MOTIONS: the same statement, judged for each of them

    def __post_init__(self):
        self.kind = self.kind or (PAPER if self.place else CHECK)
        if callable(self.verdict):
            def judge(factor, rule=self.verdict):
                return word(rule(factor))
            self.verdict, self.half, self.double = judge(1.0), judge(0.5), judge(2.0)
            self.turns = turning_factor(judge)


def word(verdict):
    """Returns the verdict for True, False and None."""
    return verdict if isinstance(verdict, str) else OPEN if verdict is None else YES if verdict else NO


def turning_factor(judge):
    """The factor nearest to 1 at which the verdict is another one than at 1; infinite where there is none."""
    here = judge(1.0)
    for low, high in zip((1.0, *FACTORS), FACTORS):
        for sign in (1, -1):
            if judge(high ** sign) != here:
                same, other = low ** sign, high ** sign
                for _ in range(12):
                    middle = math.sqrt(same * other)
                    same, other = (same, middle) if judge(middle) != here else (middle, other)
                return other
    return math.inf


def beside(*claims):
    """Claims of the same statements, a list for each of MOTIONS, which are shown side by side: those with the same slug, but
    for the motion in it. Slugs of all but the first motion name it."""
    first = {claim.slug.replace(MOTIONS[0], "*"): claim for claim in claims[0]}
    for motion, some in zip(MOTIONS, claims):
        for claim in some:
            same = first.get(claim.slug.replace(motion, "*"), claim)
            claim.motion, claim.text = motion, same.text
            if motion != MOTIONS[0] and motion not in claim.slug:
                claim.slug += f"-{motion}"
    return [claim for some in claims for claim in some]


def missing(text, place="", why="no data yet", **kind):
    """kind: kind and slug of the claim, here and below."""
    return Claim(text, OPEN, why, place, **{**kind, "rule": ""})


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


def chance(chi2, degrees):
    """Chance of a chi^2 as far out as this one, on either side."""
    above = survival(chi2, degrees)
    return 2 * min(above, 1 - above)


def judged(chi2, degrees, either=False, factor=1.0):
    """Verdict on values that are to scatter as their error bars say. either: too little scatter refutes as well."""
    fluke = chance(chi2, degrees)
    return (NO if (fluke if either else survival(chi2, degrees)) < factor * REFUTED
            else OPEN if fluke < factor * DOUBTED else YES)


def scattering(chi2, degrees, either=False):
    """judged() as a function of the factor on the chances."""
    return lambda factor: judged(chi2, degrees, either, factor)


def close(off, error, tolerance):
    """Is |off| within the tolerance? 3 errors on either side of it decide."""
    off, error = abs(off), SURE * error if math.isfinite(error) else math.inf
    return YES if off + error <= tolerance else NO if off - error > tolerance else OPEN


def closeness(off, error, tolerance):
    """close() as a function of the factor on the tolerance."""
    return lambda factor: close(off, error, factor * tolerance)


def together(verdicts):
    """YES where all are, NO where one is, else OPEN."""
    return NO if NO in verdicts else OPEN if OPEN in verdicts or not verdicts else YES


def in_fields(verdicts):
    """Judges a statement for each value of what the paper does not give."""
    known = [verdict for verdict in verdicts if verdict != OPEN]
    if not known:
        return OPEN
    return DEPENDS if len(set(known)) > 1 else known[0] if len(known) == len(verdicts) else OPEN


def beyond(number_of_points, factor=1.0):
    """Errors that one of so many points exceeds on one side as seldom as a single one exceeds 3 (Bonferroni)."""
    sure = factor * SURE
    low, high, aim = sure, 12.0 + sure, math.erfc(sure / math.sqrt(2)) / max(1, number_of_points)
    for _ in range(60):
        middle = (low + high) / 2
        low, high = (middle, high) if math.erfc(middle / math.sqrt(2)) > aim else (low, middle)
    return high


def listed(names, most=6):
    """The first of some names, and how many more there are."""
    return ", ".join(names[:most]) + (f" and {len(names) - most} more" if len(names) > most else "")


def zero(text, values, errors, place="", what="&Omega;", **kind):
    """All values are zero within their errors."""
    kind.setdefault("rule", "zero")
    values, errors = np.asarray(values, float), np.asarray(errors, float)
    good = np.isfinite(values) & (errors > 0)
    if not good.any():
        return missing(text, place, **kind)
    z = values[good] / errors[good]
    chi2, above = chi_square(z, len(z))
    worst = float(np.abs(z).max())
    numbers = (f"{len(z)} value{'s' * (len(z) > 1)}, largest |{what}| {worst:.1f} errors from zero, &chi;&sup2; = "
               f"{chi2:.1f} (a chance of {100 * above:.2g} % for more)")
    if judged(chi2, len(z)) == OPEN and above > 0.5:
        numbers += "; too small: the error bars are too large to tell"
    return Claim(text, scattering(chi2, len(z)), numbers, place, **kind)


def none(text, value, unit, place="", unit_name="&Theta;<sub>b</sub>&omega;<sub>b</sub>", **kind):
    """A speed without noise is none at all, in a unit of what drives it."""
    kind.setdefault("rule", "none")
    limit = TOLERANCES["none"]
    return Claim(text, closeness(value / unit, 0, limit), f"{number(abs(value) / unit)} {unit_name} (counted as none up to "
                 f"{number(limit)})", place, **kind)


def signs(values, errors, sign, factor=1.0):
    """(verdict, errors that count against it, right, wrong, undecided): indices of points."""
    values, errors = np.asarray(values, float), np.asarray(errors, float)
    z = sign * values / np.maximum(errors, 1e-300)
    against, sure = beyond(len(z), factor), factor * SURE
    right, wrong = np.nonzero(z > sure)[0], np.nonzero(z < -against)[0]
    undecided = np.nonzero((z <= sure) & (z >= -against))[0]
    return (NO if len(wrong) else OPEN if len(undecided) else YES), against, right, wrong, undecided


def _errors(value, error):
    z = value / max(error, 1e-300)
    return _minus(f"{z:+.1f} errors") if abs(z) < 100 else "over 100 errors"


def signed(text, values, errors, sign, place="", what="&Omega;", names=None, **kind):
    """Every value has this sign. names: of the points, to say which are undecided."""
    kind.setdefault("rule", "sign")
    values, errors = np.asarray(values, float), np.asarray(errors, float)
    good = np.isfinite(values) & (errors >= 0)
    if not good.any():
        return missing(text, place, **kind)
    names = [name for name, fine in zip(names, good) if fine] if names is not None else None
    values, errors = values[good], errors[good]
    _, against, right, wrong, undecided = signs(values, errors, sign)
    same, other = ("positive", "negative") if sign > 0 else ("negative", "positive")
    told = (f"of {len(values)} values of {what} {len(right)} are {same} by more than {SURE:g} errors, {len(wrong)} "
            f"{other} by more than {against:.1f}, {len(undecided)} undecided")
    for points in (wrong, undecided):
        if len(points) and names:
            told += ("; " + other if points is wrong else "; undecided") + ": " + listed(
                [f"{names[k]} ({_errors(values[k], errors[k])})" for k in points])
    if len(undecided) > 1 and not len(wrong):
        weight = 1 / np.maximum(errors[undecided], 1e-300) ** 2
        joint = sign * float(np.sum(values[undecided] * weight) / math.sqrt(np.sum(weight)))
        told += f"; their weighted mean is {same if joint > 0 else other} by {abs(joint):.1f} errors"
    return Claim(text, lambda factor: signs(values, errors, sign, factor)[0], told, place, **kind)


def grows(text, steps, errors, place="", what="amplitude", names=None, **kind):
    """Every step from one point to the next is up; names: of the steps."""
    kind.setdefault("rule", "growth")
    steps, errors = np.asarray(steps, float), np.asarray(errors, float)
    if not len(steps):
        return missing(text, place, **kind)
    _, against, up, down, undecided = signs(steps, errors, 1)
    told = (f"of {len(steps)} steps from one {what} to the next {len(up)} are up by more than {SURE:g} errors, "
            f"{len(down)} down by more than {against:.1f}, {len(undecided)} undecided")
    if names and len(undecided):
        told += ": " + listed([names[k] for k in undecided])
    return Claim(text, lambda factor: signs(steps, errors, 1, factor)[0], told, place, **kind)


def within(text, value, target, tolerance, place="", error=0.0, names=("found", "expected"), **kind):
    """value equals target within a relative tolerance; the error decides whether this can be told."""
    kind.setdefault("rule", "equal")
    if value is None or target is None or not (math.isfinite(value) and math.isfinite(target)):
        return missing(text, place, **kind)
    off = (value - target) / abs(target)
    spread = (error if math.isfinite(error) else 0) / abs(target)
    numbers = (f"{names[0]} {number(value, error, 5)}, {names[1]} {number(target, digits=5)}: {percent(off)} "
               f"(counted as equal up to {100 * tolerance:g} %)")
    return Claim(text, closeness(off, spread, tolerance), numbers, place, **kind)


def approaches(text, amplitudes, deviations, errors, place="", unit="", **kind):
    """The largest relative deviation falls from step to step until it is within the tolerance, and stays there."""
    kind.setdefault("rule", "approach")
    off, error, limit = np.abs(deviations), np.asarray(errors, float), TOLERANCES["excellent"]
    if len(off) < 2 or not np.isfinite(off).all():
        return missing(text, place, **kind)
    rises, end, _ = approaching(off, error, limit)
    told = "largest deviation " + ", ".join(f"{100 * o:.{1 if o < 0.2 else 0}f} % at {a:g}{unit}"
                                            for a, o in zip(amplitudes, off))
    if len(rises):
        told += "; it rises at " + ", ".join(f"{amplitudes[k]:g}" for k in rises)
    if end == NO:
        told += "; it does not end within the tolerance"
    return Claim(text, lambda factor: approaching(off, error, factor * limit)[2],
                 told + f" (tolerance {100 * limit:g} %)", place, **kind)


def approaching(off, error, limit):
    """(indices of amplitudes at which the deviation rises outside the limit, verdict on the end, verdict)"""
    change, known = np.diff(off), SURE * np.hypot(error[1:], error[:-1])
    rises = np.nonzero((off[1:] > limit) & (change > known))[0] + 1
    falls = (off[1:] <= limit) | (change < -known)
    end = close(off[-1], error[-1], limit)
    return rises, end, NO if len(rises) or end == NO else YES if end == YES and falls.all() else OPEN


def excellent(text, deviation, error, numbers, place="", **kind):
    """The largest relative deviation at the largest amplitude is within what counts as excellent."""
    kind.setdefault("rule", "excellent")
    limit = TOLERANCES["excellent"]
    if not math.isfinite(deviation):
        return missing(text, place, **kind)
    return Claim(text, closeness(deviation, error, limit), f"{numbers} (counted as excellent up to {100 * limit:g} "
                                                       "%)", place, **kind)


def decide(text, condition, numbers, place="", **kind):
    """condition: True, False, or None when it cannot be told; or a function that says so for a factor on its limit."""
    kind.setdefault("rule", "threshold")
    return Claim(text, condition if callable(condition) else word(condition), numbers, place, **kind)
