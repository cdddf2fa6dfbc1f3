"""What a page says first: what holds, what does not and why; and where the paper's equations are not as printed."""
import html
import re

from . import argument
from .page import Numbers, Section, plain
from .verdict import CHECK, DEPENDS, NO, OPEN, PAPER, TRIVIAL, WORDS, YES

# Why a statement is not reproduced, by its slug: shown where the verdict says so, beside no numbers of its own.
REASONS = {
    "forces-never-zero": "at large amplitude and tilt the lighter contact is unloaded at times",
    "never-open": "at large amplitude and tilt the lighter contact opens now and then",
    "lambda-path": "a closed path of the disks does not bring it back",
    "lambda-energy": "&lambda; returns, but the paper's force does not derive from the energy",
    "equal-durations": "reflection relates S<sup>++</sup> and S<sup>&minus;&minus;</sup> alone; S<sup>+&minus;</sup> "
                       "and S<sup>&minus;+</sup> are each their own mirror image",
    "premise-velocity": "false for the drive of the figures, true for a strong one",
    "durations-correlation": "at the drive of the figures the disk is dragged along, the more the slower the drive",
    "tep-correlation-time": "at the drive of the figures larger excursions at low frequency undo it",
    "random-slides": "at the smallest amplitudes of the figures a contact sticks most of the time",
    "rare-sliding": "the disk turns with every slip, the more slowly the fewer there are",
    "depends-kt": "the tangential springs are as good as rigid at the paper's value",
    "eq35-printed": "the print lacks the factor &omega;<sub>b</sub>/&pi;",
    "eq38-printed": "the print lacks a factor &mu; before <i>mg</i>",
    "fixed-limit": "where the contacts slide oppositely it is &mu;(<i>n</i><sub>1</sub> &minus; <i>n</i><sub>2</sub>)",
    "async-configurations": "S<sup>&minus;&minus;</sup> occurs at weak drive only; at strong drive &Omega; is "
                            "negative all the time, and S<sup>++</sup> occurs twice in each period",
    "eq19-async": "its premise, equal durations without tilt, does not hold there",
    "tep-torque": "a visit to a configuration is over long before the centre of the upper disk is in equilibrium",
    "tep-forces": "a visit to a configuration is over long before the centre of the upper disk is in equilibrium",
    "torque-balance": "the torques of the equilibria are off by some per cent, and their small differences are what "
                      "counts",
    "aperture-sign": "S<sup>+&minus;</sup> and S<sup>&minus;+</sup> last longer at any aperture; where all four last "
                     "equally long it is met",
}

ROOM = 160  # signs
# (place, as printed, what is right, slug of the claim whose numbers tell)
ERRATA = (
    ("eqs. (38), (40)", "&hellip; &minus; <i>mg</i>", "&hellip; &minus; &mu;<i>mg</i>: both sides are multiplied by &mu;",
     "eq38-printed"),
    ("after (38)", "equilibrium: third derivative of <i>x</i> = 0", "second derivative", ""),
    ("eq. (11)", "second term &Tau;<sup>++</sup><i>T</i><sup>&minus;&minus;</sup>",
     "&Tau;<sup>&minus;&minus;</sup><i>T</i><sup>&minus;&minus;</sup>", "eq11-printed"),
    ("before (19)", "no tilt: &Tau;<sup>++</sup> = &Tau;<sup>&minus;&minus;</sup>, &Tau;<sup>+&minus;</sup> = "
     "&Tau;<sup>&minus;+</sup> = 0", "&Tau;<sup>++</sup> = &minus;&Tau;<sup>&minus;&minus;</sup>, by (15) and (16)",
     "level-torques"),
    ("premise of (19)", "no tilt: all four configurations last equally long",
     "S<sup>++</sup> and S<sup>&minus;&minus;</sup> do, by reflection; S<sup>+&minus;</sup> and S<sup>&minus;+</sup> "
     "last longer", "equal-durations"),
    ("fixed centres, section 4", "limit &mu;(<i>n</i><sub>1</sub> + <i>n</i><sub>2</sub>) in all configurations",
     "in S<sup>+&minus;</sup> and S<sup>&minus;+</sup> &mu;(<i>n</i><sub>1</sub> &minus; <i>n</i><sub>2</sub>)", "fixed-limit"),
    ("eq. (19), section 4.2", "predicts the sense in opposite phases", "its premise does not hold there: without tilt "
     "S<sup>+&minus;</sup> and S<sup>&minus;+</sup> last nearly all the time at strong drive", "eq19-async"),
    ("eqs. (32)-(34)", "S<sup>&minus;&minus;</sup>, S<sup>&minus;+</sup>, S<sup>++</sup>, S<sup>+&minus;</sup> in each period",
     "at weak drive only; at strong drive S<sup>&minus;+</sup>, S<sup>++</sup>, S<sup>+&minus;</sup>, S<sup>++</sup>",
     "async-configurations"),
    ("eq. (30)", "4&mu;&Theta;<sub>b</sub>&omega;<sub>b</sub> tan &theta;<sub>T</sub>/&pi; for rotation (20)",
     "that is for the parabolas (21); for the sine (20) &Theta;<sub>b</sub>&omega;<sub>b</sub> sin(&pi;&mu; tan "
     "&theta;<sub>T</sub>/2), &pi;&sup2;/8 as much at small tilt", "waveform-phase"),
    ("eq. (31)", "<i>mgR</i>&mu; sin &theta;<sub>T</sub>/((1 + &mu;&sup2;) cos &theta;<sub>h</sub>)",
     "<i>mgR</i>&mu;&sup2; &hellip;: the half sum of (15) and (16) has a further factor &mu;", "eq31-printed"),
    ("eq. (35)", "8&mu;(&mu;&sup2; + 1)&Theta;<sub>b</sub>&theta;<sub>T</sub> &hellip;, no velocity",
     "&omega;<sub>b</sub>/&pi; times that", "eq35-printed"),
    ("captions of figs. random-ex-vel, random-ex-tilt", "<i>t<sub>b</sub></i>&Omega;",
     "<i>t<sub>g</sub></i>&Omega;, <i>t<sub>g</sub></i> = &radic;(2<i>R</i>/<i>g</i>) as in the text", ""),
    ("caption of fig. sync-vel", "&Theta;<sub>b</sub> = 1&times;10<sup>&minus;3</sup>1",
     "1&times;10<sup>&minus;3</sup>", ""),
    ("sections 4.1, 4.2", "&omega;<sub>b</sub> and the waveform of the simulations are not given", "20&pi; and the parabola in "
     "the figures here; agreement depends on both", "sync-excellent"),
)


def sections(found, errata=ERRATA, reasons=None, counts=(PAPER,)):
    """found: all other sections of the page. errata: of the paper, () for none. counts: kinds of claims that count: the paper's
    alone on its page, which begins with the argument; with own checks: a page that begins with lists."""
    if CHECK in counts:
        out = [short(found, REASONS if reasons is None else reasons, counts)]
    else:
        out = [argument.section(found, counted(found))]
        out[0].tables.append(by_parts(found, counts))
        for claim in (claim for section in found for claim in section.claims):
            reason = (REASONS if reasons is None else reasons).get(claim.slug)
            if reason and claim.verdict in (NO, DEPENDS):
                claim.numbers += f" &ndash; {reason}"
    claims = {claim.slug: claim for section in found for claim in section.claims if claim.slug}
    if errata:
        part = Section("errata", "Errata of the paper", "What is printed, what is right, and the statement below whose numbers tell. "
                       "None of them is counted.")
        part.tables.append(Numbers("Errata", ["where", "printed", "right", "checked"],
                                   [[*row[:3], checked(claims.get(row[3]), found)] for row in errata
                                    if wrong(claims.get(row[3]))], shown=True))
        out.append(part)
    return out


def checked(claim, found):
    """Returns the place of the numbers of an erratum."""
    if not claim:
        return "by the text"
    section = next(part for part in found if any(c is claim for c in part.claims))
    return f'<code>{claim.slug}</code>, <a href="#{section.key}">{section.title}</a>'


def counted(found):
    every = [claim for section in found for claim in section.claims if claim.kind == PAPER]
    return (f"<b>Of the paper's {len(every)} statements {amount(every, YES)} are reproduced, {amount(every, NO)} are not, "
            f"{amount(every, DEPENDS)} hold or fail with what the paper does not give, and {amount(every, OPEN)} cannot be decided "
            f'here.</b> {besides(found)} Rules, margins and what earlier reports said: <code>docs/studies/verdicts.md</code>.')


def wrong(claim):
    """Is this erratum one? Not when the numbers bear out what is printed."""
    return not claim or claim.kind == CHECK or claim.verdict != YES


def short(found, reasons, counts):
    out = Section("short", "What holds, and what does not")
    every = [claim for section in found for claim in section.claims if claim.kind in counts]
    parts = [f"<p><b>Of the {len(every)} statements {amount(every, YES)} are reproduced, {amount(every, NO)} are "
             f"not, and of {amount(every, OPEN)} it cannot be told.</b> </p>"]
    for word, title in ((NO, "Not reproduced"), (OPEN, "Cannot be told")):
        lines = [f"<li>{c.text.rstrip('.')}{place(c)} &ndash; {why(c, word, reasons)}.</li>"
                 for c in sorted(every, key=order)
                 if c.verdict == word]
        parts += [f"<p><b>{title}</b></p><ul>{''.join(lines)}</ul>"] if lines else []
    lines = [f"<li>{name}: {' '.join(texts)}</li>" for name, texts in by_section(found, every).items()]
    parts += [f"<p><b>Reproduced</b></p><ul>{''.join(lines)}</ul>"] if lines else []
    out.lead = "".join(parts)
    out.tables.append(by_parts(found, counts))
    return out


def by_parts(found, counts):
    """How many statements hold, by section of the page."""
    paper, rows = CHECK not in counts, []
    words = WORDS if paper else (YES, NO, OPEN)
    for section in found:
        of = [claim for claim in section.claims if claim.kind in counts]
        own = [claim for claim in section.claims if claim.kind == CHECK] if paper else []
        if of or own:
            rows.append([f'<a href="#{section.key}">{section.title}</a>', *(count(of, word) for word in words),
                         *([f"{count(own, YES)} of {len(own)}" if own else ""] if paper else [])])
    return Numbers("Statements by section", ["", *words, *(["own checks met"] if paper else [])], rows, shown=True)


def by_section(found, every):
    """{where: sentences that hold}: sections of the paper in their order; without them those of the page."""
    titles = {id(claim): section.title for section in found for claim in section.claims}
    where = {}
    for claim in every:
        if claim.verdict == YES:
            number = order(claim)
            where.setdefault(f"section {number:g}" if number else titles[id(claim)], []).append(claim.text)
    return {name: where[name] for name in (sorted(where) if any(name.startswith("section ") for name in where)
                                           else where)}


def order(claim):
    """Number of the paper's section; 0 for none."""
    found = re.search(r"sections? ([\d.]+)", claim.place)
    return float(found[1]) if found else 0.0


def count(claims, word):
    return sum(claim.verdict == word for claim in claims)


def amount(claims, word):
    return count(claims, word) or "none"


def besides(found):
    own = [claim for section in found for claim in section.claims if claim.kind == CHECK]
    trivial = [claim for section in found for claim in section.claims if claim.kind == TRIVIAL]
    return (f"Apart from these, {count(own, YES)} of {len(own)} own checks are met, and {len(trivial)} statements "
            f"about "
            "geometry, waveforms and printed equations hold or fail by construction; neither are counted.")


def place(claim):
    return f" ({claim.place})" if claim.place else ""


def why(claim, word, reasons):
    """Its reason, or what of its numbers has room in a line or two."""
    known = reasons.get(claim.slug) if word == NO else ""
    parts = re.sub(r"&(?!lt|gt|amp)\w+;", lambda sign: html.unescape(sign[0]), claim.numbers.rstrip(".")).split("; ")
    fits = [k for k in range(1, len(parts) + 1) if len(plain("; ".join(parts[:k]))) < ROOM]
    return known or "; ".join(parts[:max(fits, default=1)])
