"""The head of the page: what was asked, what holds for which drive, why, and the figures that show it."""
from ratchet.page import Numbers, Section
from ratchet.verdict import MOTIONS, NO, OPEN, YES

from . import alone, each, gentle, low
from .statistics import share

FIGURES = ("each-disk", "gentle", "alone-shares")  # of the sections, which the first page shows instead
WORDS = {YES: "yes", NO: "no", OPEN: "undecided"}


def section(campaign, found):
    """found: all other sections; the figures of the first page are taken out of them."""
    claims = {claim.slug: claim for part in found for claim in part.claims}
    out = Section("short", "What was asked, and what holds")
    out.lead = "".join(f"<p>{text}</p>" for text in (asked(), *answers(campaign), why(campaign)) if text)
    for part in found:
        out.figures += [figure for figure in part.figures if figure.name in FIGURES]
        part.figures[:] = [figure for figure in part.figures if figure.name not in FIGURES]
    rows = by_drive(claims)
    if rows:
        out.tables.append(Numbers("What holds for which drive", ["statement", "harmonic", "random"], rows, shown=True))
    out.tables.append(Numbers("Statements by section", ["", YES, NO, OPEN], [
        [f'<a href="#{part.key}">{part.title}</a>', *(sum(claim.verdict == word for claim in part.claims)
                                                     for word in (YES, NO, OPEN))]
        for part in found if part.claims], shown=True))
    return out


def data(found):
    """Returns one table of the kept numbers that each section is drawn from."""
    out = Section("data", "Data", "Numbers behind each section, in <code>docs/studies/data/packings</code>; the head of each "
                  "file names the program, the command and the level that made it.")
    rows = [[f'<a href="#{part.key}">{part.title}</a>',
             ", ".join(f'<a href="data/packings/{name}.csv">{name}</a>' for name in part.data)] for part in found if part.data]
    out.tables.append(Numbers("Files", ["section", "numbers"], rows, shown=True))
    return out


def asked():
    return ("<b>Asked.</b> The letter states three things of packings of disks that are vibrated from below: each disk has "
            "a mean angular velocity that is not zero; the broken mirror symmetry of its cage sets it; at low drive "
            "contacts persist, disks turn by sliding, and dissipation gives the typical angular velocity against drive. "
            "They are judged here for harmonic and for random vibration of the floor.")


def both(values):
    """(harmonic, random) in HTML, of (value, error) each, in per cent."""
    return f"{each.percent(values[0])} under harmonic and {each.percent(values[1])} under random drive"


def answers(campaign):
    """Paragraphs on each disk and on its cage, from the numbers."""
    table = campaign.numbers("gentle", lambda: None)
    found = {drive: part for drive, part in (gentle.boxes(table) if table else {}).items() if len(part) == 3}
    if found:
        told = "; ".join(f"{drive:g} <i>g</i>: {both((gentle.turning(part[0]), gentle.turning(part[1] + part[2])))}"
                         for drive, part in found.items())
        drive = max(found)
        sense, other = (gentle.same_sense(some) for some in (
            gentle.pairs(found[drive], 1, 2), gentle.pairs(found[drive], 0, 1) + gentle.pairs(found[drive], 0, 2)))
        yield (f"<b>Does each disk turn? Two answers.</b> Beyond 3 errors are, in the same packings, with the same rms "
               f"displacement of the floor and after the same time, at {told}. At {drive:g} <i>g</i> two realisations of "
               f"the noise turn a disk in the same sense for {each.percent(sense)} of the disks, harmonic and random drive "
               f"for {each.percent(other)}.")
    strong, _ = alone.packings_of(*alone.tables_of(campaign))
    drives = sorted({key[0] for key in strong if (key[0], 0.0) in strong and (key[0], 1.0) in strong})
    if drives:
        told = []
        for random, word in alone.MOTIONS.items():
            told.append(f"<i>{word} drive</i>: " + "; ".join(parts(drive, alone.shares(strong[drive, random]))
                                                             for drive in drives))
        yield ("<b>Is &Omega; set by the cage?</b> All disks but some were kept from turning. A disk whose neighbours do not "
               "turn has an angular velocity &Omega;<sub>0</sub> that its cage makes. Gearing with the neighbours follows from "
               "the drag of each contact, in proportion to its mean normal force: &Omega; = &Omega;<sub>0</sub> + "
               "<i>G</i>&Omega;, nothing fitted. The lower number of gearing is what its solution explains beyond the cage; the "
               "upper one takes the measured &Omega; of the neighbours. Of the variance of &Omega; are: " + ". ".join(told) + ".")


def parts(drive, found):
    """Shares of the variance at one drive, in words."""
    upper = (found["gearing"][0] + found["neighbours"][0], found["neighbours"][1])
    return (f"at {drive:g} <i>g</i> the cage's {each.percent(found['cage'])}, by gearing {each.percent(found['gearing'])} to "
            f"{each.percent(upper)}, neither {each.percent(found['neither'])}")


def why(campaign):
    table = campaign.numbers("gentle", lambda: None)
    found = {drive: part for drive, part in (gentle.boxes(table) if table else {}).items() if len(part) == 3}
    if not found:
        return ""
    drive = sorted(found)[len(found) // 2]
    part = found[drive]
    sticks = [share([(int(((box["friction"] == 0) & box.held).sum()), int(box.held.sum())) for box in some])
              for some in (part[0], part[1] + part[2])]
    opens = [gentle.never(some) for some in (part[0], part[1] + part[2])]
    return (f"<b>Why.</b> Under harmonic drive the packing repeats its motion in each period: a contact that does not slide in "
            f"one does not in the next. At {drive:g} <i>g</i> disks whose friction does no work at all are {both(sticks)}, "
            f"those none of whose contacts ever opens {both(opens)}. Random drive has stronger moments, so that contacts slide "
            "sooner or later, and averages over many motions of the packing. That average is what &Omega; = "
            "&Omega;<sub>0</sub> + <i>G</i>&Omega; assumes. Under harmonic drive the motion is one of many possible ones, "
            "and it is another one when other disks cannot turn" + other(campaign) + ": there &Omega;<sub>0</sub> says less "
            "about &Omega;.")


def other(campaign):
    """How well Omega_0 repeats when other disks far away may turn, in brackets."""
    found, single = alone.packings_of(*alone.tables_of(campaign))
    told = [f"{alone.likeness_of(some[0], found[0.7, random][0]):.2f} under {alone.MOTIONS[random]} drive"
            for random, some in sorted(single.items()) if (0.7, random) in found]
    return (" (&Omega;<sub>0</sub> with one disk at a time against sets of disks that turn, far from each other, at 0.7 "
            f"<i>g</i>: correlation {', '.join(told)})") if told else ""


STATEMENTS = (  # slugs, * for the drive; statement
    ("gentle-each-{motion}-*g", "each disk turns (500 s)"),
    ("each-disk-*", "each disk turns (60 s)"),
    ("alone-turns-{motion}-*g", "most disks turn although none of their neighbours does"),
    ("alone-cage-{motion}-*g", "the cage alone makes more than half of the variance of &Omega;"),
    ("alone-gears-{motion}-*g", "cage and gearing together make more than half"),
    ("alone-balance-{motion}-*g", "&Omega; = &Omega;<sub>0</sub> + <i>G</i>&Omega;, both factors one"),
    ("cage-predicts-*g", "mean forces and angles of its contacts predict more than half of the variance"),
    ("gears-contact-*g", "disks in contact turn against each other"),
    ("*-friction-rotation", "disks that turn faster lose more by friction"),
    ("drive-rms", "rms &Omega; grows with the drive"),
    ("dissipation-{motion}", "low drive: rms &Omega; ~ power of friction"),
)


def by_drive(claims):
    """Rows (statement, harmonic, random): verdicts, with the drives that have them."""
    rows = []
    for slug, text in STATEMENTS:
        cells = [verdicts(claims, slug, motion) for motion in MOTIONS]
        if any(cells):
            rows.append([text, *(one or "&ndash;" for one in cells)])
    return rows


def verdicts(claims, slug, motion):
    """Verdicts of the claims with this slug, in words, with their drives: "yes at 2 g; no at 0.3 g"."""
    before, asterisk, after = slug.replace("{motion}", motion).partition("*")
    after += f"-{motion}" if motion != MOTIONS[0] and motion not in before + after else ""
    found = {}
    for name, claim in claims.items():
        middle = name[len(before):len(name) - len(after)] if asterisk else ""
        drive = known_drive(middle, not before)
        if name == before + middle + after and claim.motion == motion and (not asterisk or drive):
            found.setdefault(WORDS[claim.verdict], []).append(drive)
    return "; ".join(word + (f" at {', '.join(f'{d:g}' for d in sorted(drives))} <i>g</i>" if asterisk else "")
                     for word, drives in found.items())


def known_drive(text, by_name):
    """The drive that a part of a slug tells, in g, or (by_name) the run; 0 for another part."""
    try:
        return low.DRIVE.get(text, 0.0) if by_name else float(text)
    except ValueError:
        return 0.0
