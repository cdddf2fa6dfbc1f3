"""What a page says first: what holds, what does not and why; and where the paper's equations are not as printed."""
import html
import re

from .page import Numbers, Section, plain
from .verdict import CHECK, NO, OPEN, PAPER, TRIVIAL, YES

# Why a statement is not reproduced, by its slug: shown where the verdict says so, beside no numbers of its own.
REASONS = {
    "forces-never-zero": "at large amplitude and tilt the lighter contact is unloaded at times",
    "never-open": "at large amplitude and tilt the lighter contact is unloaded at times and opens now and then",
    "lambda-path": "a closed path of the disks does not bring it back",
    "lambda-energy": "&lambda; returns, but the paper's force does not derive from the energy",
    "equal-durations": "reflection relates S<sup>++</sup> and S<sup>&minus;&minus;</sup> alone; S<sup>+&minus;</sup> "
                       "and S<sup>&minus;+</sup>, each its own mirror image, last about three times as long and not "
                       "equally",
    "durations-correlation": "durations hardly change where the correlation time changes a hundredfold",
    "random-slides": "at the smallest amplitudes of the figures a contact sticks most of the time",
    "random-configurations": "at the smallest amplitudes contacts stick most of the time, and not all four occur",
    "rare-sliding": "the disk turns with every slip, the more slowly the fewer there are",
    "eq35-printed": "the print lacks the factor &omega;<sub>b</sub>/&pi;",
    "async-configurations": "S<sup>&minus;&minus;</sup> occurs at weak drive only; at strong drive &Omega; is "
                            "negative all the time, and S<sup>++</sup> occurs twice in each period",
    "async-sequence-strong": "at strong drive &Omega; is negative all the time, and S<sup>++</sup> occurs twice in "
                             "each period",
    "async-straight": "the centre of the upper disk is still under way to its equilibrium; with <i>k<sub>n</sub></i> = "
                      "10<sup>5</sup> theory is met",
    "sync-approach": "&Omega; passes (30) and ends above it: disks of finite stiffness at this frequency",
    "sync-excellent": "&Omega; ends above (30): disks of finite stiffness at this frequency",
    "async-excellent": "the centre of the upper disk is still under way to its equilibrium",
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
    ("eq. (11)", "second term &Tau;<sup>++</sup><i>T</i><sup>&minus;&minus;</sup>",
     "&Tau;<sup>&minus;&minus;</sup><i>T</i><sup>&minus;&minus;</sup>", "eq11-printed"),
    ("before (19)", "no tilt: &Tau;<sup>++</sup> = &Tau;<sup>&minus;&minus;</sup>, &Tau;<sup>+&minus;</sup> = "
     "&Tau;<sup>&minus;+</sup> = 0", "&Tau;<sup>++</sup> = &minus;&Tau;<sup>&minus;&minus;</sup>, by (15) and (16)",
     "level-torques"),
    ("premise of (19)", "no tilt: all four configurations last equally long",
     "S<sup>++</sup> and S<sup>&minus;&minus;</sup> do, by reflection; S<sup>+&minus;</sup> and S<sup>&minus;+</sup> "
     "last longer", "equal-durations"),
    ("eq. (30)", "4&mu;&Theta;<sub>b</sub>&omega;<sub>b</sub> tan &theta;<sub>T</sub>/&pi; for rotation (20)",
     "that is for the parabolas (21); for the sine (20) &Theta;<sub>b</sub>&omega;<sub>b</sub> sin(&pi;&mu; tan "
     "&theta;<sub>T</sub>/2), &pi;&sup2;/8 as much at small tilt", "waveform-phase"),
    ("eq. (31)", "<i>mgR</i>&mu; sin &theta;<sub>T</sub>/((1 + &mu;&sup2;) cos &theta;<sub>h</sub>)",
     "<i>mgR</i>&mu;&sup2; &hellip;: the half sum of (15) and (16) has a further factor &mu;", "eq31-printed"),
    ("eq. (35)", "8&mu;(&mu;&sup2; + 1)&Theta;<sub>b</sub>&theta;<sub>T</sub> &hellip;, no velocity",
     "&omega;<sub>b</sub>/&pi; times that", "eq35-printed"),
    ("section 2.2", "no path dependence of the energy stored in the skin", "&lambda; returns on a closed path, but "
                                                                           "the force "
     "&tau; on the centres does work on it", "lambda-energy"),
    ("captions of figs. random-ex-vel, random-ex-tilt", "<i>t<sub>b</sub></i>&Omega;",
     "<i>t<sub>g</sub></i>&Omega;, <i>t<sub>g</sub></i> = &radic;(2<i>R</i>/<i>g</i>) as in the text", ""),
    ("caption of fig. sync-vel", "&Theta;<sub>b</sub> = 1&times;10<sup>&minus;3</sup>1",
     "1&times;10<sup>&minus;3</sup>", ""),
    ("sections 4.1, 4.2", "&omega;<sub>b</sub> is not given", "20&pi; here, that of section 3", "frequency-phase"),
)


def sections(found, errata=ERRATA, reasons=None, counts=(PAPER,)):
    """found: all other sections of the page. errata: of the paper, () for none. counts: kinds of claims that count."""
    out = [short(found, REASONS if reasons is None else reasons, counts)]
    claims = {claim.slug: claim for section in found for claim in section.claims if claim.slug}
    if errata:
        part = Section("errata", "Errata of the paper", "What is printed, what is right, and the numbers that tell; "
                       "the statements stand in the sections below.")
        part.tables.append(Numbers("Errata", ["where", "printed", "right", "checked"],
                                   [[*row[:3], claims[row[3]].numbers if row[3] in claims else "by the text"]
                                    for row in errata
                                    if wrong(claims.get(row[3]))], shown=True))
        out.append(part)
    return out


def wrong(claim):
    """Is this erratum one? Not when the numbers bear out what is printed."""
    return not claim or claim.kind == CHECK or claim.verdict != YES


def short(found, reasons, counts):
    out = Section("short", "What holds, and what does not")
    paper = CHECK not in counts
    every = [claim for section in found for claim in section.claims if claim.kind in counts]
    what = "the paper's" if paper else "the"
    parts = [f"<p><b>Of {what} {len(every)} statements {amount(every, YES)} are reproduced, {amount(every, NO)} are "
             f"not, and of "
             f"{amount(every, OPEN)} it cannot be told.</b> {besides(found) if paper else ''}</p>"]
    for word, title in ((NO, "Not reproduced"), (OPEN, "Cannot be told")):
        lines = [f"<li>{c.text.rstrip('.')}{place(c)} &ndash; {why(c, word, reasons)}.</li>"
                 for c in sorted(every, key=order)
                 if c.verdict == word]
        parts += [f"<p><b>{title}</b></p><ul>{''.join(lines)}</ul>"] if lines else []
    lines = [f"<li>{name}: {' '.join(texts)}</li>" for name, texts in by_section(found, every).items()]
    parts += [f"<p><b>Reproduced</b></p><ul>{''.join(lines)}</ul>"] if lines else []
    out.lead = "".join(parts)
    rows = []
    for section in found:
        of = [claim for claim in section.claims if claim.kind in counts]
        own = [claim for claim in section.claims if claim.kind == CHECK] if paper else []
        if of or own:
            rows.append([f'<a href="#{section.key}">{section.title}</a>', *(count(of, word)
                                                                            for word in (YES, NO, OPEN)),
                         *([f"{count(own, YES)} of {len(own)}" if own else ""] if paper else [])])
    out.tables.append(Numbers("Statements by section", ["", YES, NO, OPEN, *(["own checks met"] if paper else [])],
                              rows,
                              shown=True))
    return out


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
