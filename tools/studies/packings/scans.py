"""On what the rotation depends: friction, stiffness, frequency, preparation, size of the box."""
import dataclasses
import math

import numpy as np
from matplotlib.lines import Line2D
from matplotlib.ticker import NullFormatter

from ratchet.page import Figure, Numbers, Section
from ratchet.style import COLOURS, GREY, plt
from ratchet.verdict import MOTIONS, NO, OPEN, YES, Claim, beside, decide, missing, number

from .compare import differ, exponent, percent, student, together
from .drive import bars, lasts
from .statistics import mean_error, pearson, spearman

DRIVES = (0.7, 2.0)
ENTRIES = ("scan", "size", "prepared")  # of plan.py; those under random drive end on _random
LARGE = "shake_1e4"
CLEAR = 0.01     # chance below which groups differ
SAME = 0.05      # and above which they may be alike
OFF = 0.002      # chance below which an exponent is another one
COARSE = 0.2     # points known less well than this (relative) may differ unnoticed
FINE = 0.25      # error of ln(rms) over the range of values above which an exponent tells nothing
QUANTITIES = ("rms", "median", "significant", "correlation", "openings", "sliding", "contacts", "wander")


@dataclasses.dataclass(frozen=True)
class Scan:
    key: str
    title: str          # of what
    axis: str           # label of the axis
    pick: object        # what belongs to it: value of a row of the table, or None
    place: dict = None  # value -> where it is drawn, of values that are no numbers
    ticks: tuple = ()


MADE = {"rain": 0, "random": 1, "front": 2, "shaken down": 3, "pressed": 4}
SCANS = (
    Scan("mu", "friction", r"$\mu$",
         lambda row: row["mu"] if row["varied"] == "mu" else None,
         ticks=(0.01, 0.1, 1)),
    Scan("stiffness", "tangential stiffness", "$k_t/k_n$",
         lambda row: row["ratio"] if row["varied"] == "k_t" else None,
         ticks=(0.4, 0.6, 1)),
    Scan("frequency", "frequency", "frequency (Hz)",
         lambda row: row["frequency"] if row["varied"] == "frequency" else None,
         ticks=(40, 80, 160)),
    Scan("preparation", "preparation", "",
         lambda row: row["made"] if row["varied"] == "made" else None,
         MADE),
    Scan("depth", "depth, one width", "disks",
         lambda row: row["disks"] if row["varied"] == "size" and row["width"] < 12 else None,
         ticks=(30, 60, 120, 240)),
    Scan("width", "width, one depth", "width / mean diameter",
         lambda row: row["width"] if row["varied"] == "size" and row["disks"] in (60, 240)
         and not (row["disks"] == 240 and row["width"] < 12) else None,
         ticks=(10, 20, 40)),
    Scan("number", "number, about one shape", "number of disks",
         lambda row: row["disks"] if row["varied"] == "size" and (row["disks"], round(row["width"])) in
         ((60, 10), (500, 29), (10000, 100)) else None,
         ticks=(100, 1000, 10000)),
)
# (slug, scan, quantity, statement, aim): the expected exponent, "-" for a negative one, or whether points differ.
CLAIMS = (
    ("scan-mu", "mu", "rms", "The rms of &Omega; depends on the coefficient of friction", "changes"),
    ("scan-mu-median", "mu", "median", "The more friction, the slower the median disk turns", "-"),
    ("scan-stiffness", "stiffness", "rms", "The rms of &Omega; does not depend on <i>k<sub>t</sub></i>/<i>k<sub>n</sub>"
                                           "</i>", 0.0),
    ("scan-frequency", "frequency", "rms", "At a given acceleration the rms of &Omega; follows the velocity of the "
                                           "floor, 1/frequency", -1.0),
    ("scan-preparation", "preparation", "rms", "The rms of &Omega; does not depend on how the packing was made",
     "alike"),
    ("scan-depth", "depth", "rms", "In deeper boxes of one width the rms of &Omega; is smaller", "-"),
    ("scan-width", "width", "rms", "The rms of &Omega; does not depend on the width of the box at the same depth", 0.0),
    ("scan-number", "number", "rms", "The rms of &Omega; does not depend on the number of disks in boxes of about one "
                                     "shape", 0.0),
    ("scan-number-median", "number", "median", "The median disk turns as fast among many disks as among few, in boxes "
                                               "of about one shape", 0.0),
)


def sections(campaign):
    out = Section("scans", "On what the rotation depends",
                  "<code>inputs/packing/shake_scan.cfg</code>, <code>shake_size.cfg</code>, "
                  "<code>shake_prepared.cfg</code>: one parameter at a time, at 0.7 <i>g</i> and 2 <i>g</i>, 30 s "
                  "measured after 5 s; every run deposits a packing of its own. All else as in the other boxes: 60 "
                  "disks, 10 mean diameters wide, &mu; = 0.1, <i>k<sub>t</sub></i>/<i>k<sub>n</sub></i> = 0.5, 80 Hz, "
                  "rain. Prepared: <i>random</i> disks fall all at once, a <i>front</i> is placed densely, "
                  "<i>shaken down</i> is 5 s at 5 <i>g</i>, <i>pressed</i> is 5 s under a lid of thirty times the "
                  "weight. The box with none of these changed is run for each scan; its packings count in all of them. "
                  "Error bars: scatter of packings; none for a single one.",
                  missing=campaign.missing(*ENTRIES, *(name + "_random" for name in ENTRIES)))
    table = campaign.numbers("scans", lambda: rows(campaign), "each packing: angular velocities in rad/s, lengths in "
                             "mean diameters, openings per contact and period")
    if not table.rows:
        out.claims.append(missing("The rotation lasts whatever the parameters.", slug="scan-lasts"))
        return [out]
    parts = {motion: [row for row in table.rows if row["motion"] == motion] for motion in MOTIONS}
    sets = {motion: {scan.key: points_of(scan, part) for scan in SCANS} for motion, part in parts.items() if part}
    out.claims += beside(*([all_last(found), *(made for claim in CLAIMS for made in claims_of(*claim, found[claim[1]])),
                            reference(parts[motion])] for motion, found in sets.items()))
    for name, scans in (("scans", SCANS[:4]), ("scans-size", SCANS[4:])):
        out.figures += [overview(f"{name}-{motion}", motion, scans, found) for motion, found in sets.items()
                        if any(found[scan.key] for scan in scans)]
    out.tables.append(Numbers("Each point of the scans (rms and median in rad/s)",
                              ["motion", "scan", "value", "drive/<i>g</i>", "packings",
                               *(name for q in QUANTITIES for name in (q, "error"))],
                              [[motion, scan.title, plain(value), drive, len(some),
                                *(cell for q in QUANTITIES for cell in mean_error([row[q] for row in some]))]
                               for motion, found in sets.items() for scan in SCANS
                               for (drive, value), some in found[scan.key].items()]))
    return [out]


# --- table --------------------------------------------------------------------------------------------------
def rows(campaign):
    """A row for each packing, with what was varied in it."""
    found = [row_of(entry, motion, run) for entry, motion, run in runs_of(campaign)]
    return {key: [row[key] for row in found] for key in found[0]} if found else None


def runs_of(campaign):
    """(entry, motion, run) of all that is compared."""
    for motion, end in zip(MOTIONS, ("", "_random")):
        for entry in (*ENTRIES, LARGE):
            yield from ((entry, motion, run) for run in campaign.runs(entry + end) if run.has_means)


def row_of(entry, motion, run):
    known = run.parameters
    diameter = 2 * float(run.radius.mean())
    frequency = known.get("frequency", 80.0)
    varied = {"size": "size", LARGE: "size", "prepared": "made"}.get(entry) or next(
        name for name in ("mu", "k_t", "frequency") if name in known)
    made = {"tap": "shaken down", "press": "pressed"}.get(known.get("then"), known.get("made", "rain"))
    first, second = run.halves()
    return {"motion": motion, "varied": varied, "drive": known.get("drive", 2.0), "mu": known.get("mu", 0.1),
            "ratio": known.get("k_t", 5e3) / 1e4, "frequency": frequency, "made": made, "disks": run.n_free,
            "width": round(known.get("width", 4.0 if entry == LARGE else 0.4) / diameter, 2),
            "depth": float(np.max(run.y_end + run.radius)) / diameter, "seed": run.seed, "seconds": run.measured,
            "rms": run.rms, "median": run.median, "significant": run.significant,
            "correlation": pearson(first, second), "ranks": spearman(first, second),
            "openings": run.openings_per_period(frequency), "sliding": run.sliding_fraction,
            "contacts": run.coordination, "wander": run.wander}


def plain(value):
    return value if isinstance(value, str) else number(value)


BASE = {"mu": 0.1, "stiffness": 0.5, "frequency": 80.0, "preparation": "rain", "depth": 60, "width": 10.0, "number": 60}


def is_base(row):
    """The box that is a point of each scan."""
    return (row["mu"], row["ratio"], row["frequency"], row["made"], row["disks"], round(row["width"])) == (
        0.1, 0.5, 80, "rain", 60, 10)


def points_of(scan, rows_):
    """{(drive, value): rows}, in order of drive and value."""
    found = {}
    for row in rows_:
        value = BASE[scan.key] if is_base(row) else scan.pick(row)
        if value is not None and row["drive"] in DRIVES:
            found.setdefault((row["drive"], value), []).append(row)
    order = (scan.place or {}).get
    return dict(sorted(found.items(), key=lambda item: (item[0][0], order(item[0][1], item[0][1]))))


# --- claims -------------------------------------------------------------------------------------------------
def all_last(found):
    """Rotation lasts at every point: one claim, with the least correlation."""
    verdicts, lowest = [], (2, "")
    for scan in SCANS:
        for (drive, value), some in found[scan.key].items():
            mean, error = mean_error([row["correlation"] for row in some])
            if len(some) > 1:
                verdicts.append((lasts((mean, error)), mean, f"{scan.title} {plain(value)} "
                                 f"at {drive:g} <i>g</i>: {number(mean, error)}"))
    text = ("Rotation lasts whatever friction, stiffness, frequency, preparation and size (correlation of halves above "
            "0.5).")
    if not verdicts:
        return missing(text, slug="scan-lasts")
    wrong = [told for verdict, _, told in verdicts if verdict is False]
    unsure = [told for verdict, _, told in verdicts if verdict is None]
    lowest = min(verdicts, key=lambda item: item[1])[2]
    return decide(text, False if wrong else None if unsure else True,
                  f"{len(verdicts)} points, {len(wrong)} not, {len(unsure)} undecided; least: {lowest}"
                  + (f"; not: {'; '.join(wrong)}" if wrong else ""), slug="scan-lasts")


def claims_of(slug, _, quantity, text, aim, points):
    """One claim; on an expected exponent one for each drive, since regimes may differ."""
    drives = {}
    for (drive, value), some in points.items():
        drives.setdefault(drive, {})[value] = [row[quantity] for row in some]
    drives = {drive: groups for drive, groups in drives.items() if len(groups) > 1}
    if not drives:
        return [missing(text + ".", slug=slug)]
    if aim in ("changes", "alike", "-"):
        judge = judge_exponent if aim == "-" else judge_groups
        return [Claim(text + ".", *judge(aim, drives), slug=slug)]
    return [Claim(f"{text}, at {drive:g} <i>g</i>.", *judge_exponent(aim, {drive: groups}), slug=f"{slug}-{drive:g}g")
            for drive, groups in drives.items()]


def values(drive, groups):
    return f"at {drive:g} <i>g</i> " + ", ".join(f"{number(*mean_error(some))} ({plain(value)})"
                                                 for value, some in groups.items()) + " rad/s"


def judge_groups(aim, drives):
    """(verdict, numbers) on {drive: {value: rms or median of each packing}}: do they differ anywhere?"""
    chances = [differ(list(groups.values())) for groups in drives.values()]
    chance = together(chances)
    told = ("a chance for equal ones of " + ", ".join(f"{percent(one)} at {drive:g} <i>g</i>"
                                                      for drive, one in zip(drives, chances))
            + f", together {percent(chance)}; " + "; ".join(values(*item) for item in drives.items()))
    fine = np.mean([spread(groups) for groups in drives.values()]) < COARSE
    if not math.isfinite(chance):
        return OPEN, told
    changed = True if chance < CLEAR else False if chance > SAME and fine else None
    return OPEN if changed is None else YES if changed == (aim == "changes") else NO, told


def judge_exponent(aim, drives):
    """The same on the exponent of a power of the value: aim, or negative for "-"."""
    wanted, found, reach = 0.0 if aim == "-" else aim, {}, []
    for drive, groups in drives.items():
        x = np.concatenate([np.full(len(some), value) for value, some in groups.items()])
        b, error, degrees = exponent(x, np.concatenate(list(groups.values())))
        if degrees >= 1 and error > 0:
            found[drive] = b, error, student((b - wanted) / error, degrees)
            reach.append(error * float(np.log(x.max() / x.min())))
    told = "; ".join(values(*item) for item in drives.items())
    if not found:
        return OPEN, told
    b, _, chances = np.array(list(found.values())).T
    chance = together(chances)
    told = ("exponent " + ", ".join(f"{number(*pair)} at {drive:g} <i>g</i>" for drive, (*pair, _) in found.items())
            + f", {'together ' * (len(found) > 1)}a chance of {percent(chance)} for {number(wanted)}; {told}")
    if aim == "-":
        return YES if chance < OFF and (b < 0).all() else NO if chance < OFF and (b > 0).all() else OPEN, told
    return NO if chance < OFF else YES if chance > SAME and max(reach) < FINE else OPEN, told


def spread(groups):
    """Error of a group's mean relative to it: what differences cannot be seen."""
    mean, error = np.array([mean_error(some) for some in groups.values()]).T
    return float(np.mean(error / mean)) if np.isfinite(error).all() else math.inf


def reference(rows_):
    """The same box is run for each scan, with packings of its own: these must agree."""
    text = "The box that all scans share is the same in each of them."
    verdicts, told = [], []
    for drive in DRIVES:
        groups = {}
        for row in rows_:
            if is_base(row) and row["drive"] == drive:
                groups.setdefault(row["varied"], []).append(row["rms"])
        groups = list(groups.values())
        chance = differ(groups)
        if math.isfinite(chance):
            verdicts.append(YES if chance > SAME else NO if chance < 0.001 else OPEN)
            every = np.concatenate(groups)
            told.append(f"at {drive:g} <i>g</i> {number(*mean_error(every))} rad/s of {len(every)} packings, a chance "
                        f"of {percent(chance)} for {len(groups)} groups")
    if not verdicts:
        return missing(text, slug="scan-reference")
    return Claim(text, NO if NO in verdicts else YES if all(v == YES for v in verdicts) else OPEN, "; ".join(told),
                 slug="scan-reference")


# --- figures ------------------------------------------------------------------------------------------------
PANELS = ((("rms", "rms", "o", "-"), ("median", "median", "s", ":")),
          (("significant", "beyond 3 errors", "^", "-"), ("correlation", "correlation of halves", "D", ":")),
          (("openings", "openings", "v", "-"),))
LABELS = (r"$|\Omega|$ (rad/s)", "fraction", "openings per\ncontact and period")


def overview(name, motion, scans, found):
    picture = plt.figure(figsize=(7.6, 7.1), layout="constrained")
    above, below = picture.subfigures(2, 1, height_ratios=[0.55, 6.55])
    axes = below.subplots(3, len(scans), sharey="row", sharex="col", squeeze=False)
    for column, scan in zip(axes.T, scans):
        for panel, quantities in zip(column, PANELS):
            for k, drive in enumerate(DRIVES):
                points = {value: some for (at, value), some in found[scan.key].items() if at == drive}
                for quantity in quantities:
                    draw(panel, scan, points, k, *quantity)
            ticks(panel, scan)
        column[0].set_yscale("log")
        column[1].set_ylim(-0.05, 1.12)
        column[2].set_yscale("log")
        column[0].set_title(scan.title, fontsize=10)
        column[2].set_xlabel(scan.axis, fontsize=10.5)
    for panel, label in zip(axes[:, 0], LABELS):
        panel.set_ylabel(label)
    colours = [Line2D([], [], color=COLOURS[k], lw=3, label=f"{drive:g} $g$") for k, drive in enumerate(DRIVES)]
    signs = [Line2D([], [], color=GREY, marker=sign, ls=line, mfc=GREY if line == "-" else "white", label=label)
             for part in PANELS for _, label, sign, line in part]
    above.legend(handles=colours + signs, loc="center", ncol=4, fontsize=9.5)
    return Figure(name, picture, f"{motion.capitalize()} drive: rms and median of the mean angular velocities, fraction of the disks beyond 3 "
                                 "errors and correlation of the two halves of the time, openings of contacts. "
                                 "Error bars: scatter of packings (10000 disks: one packing).",
                  f"Rotation against parameters, {motion} drive: " + ", ".join(scan.title for scan in scans))


def draw(panel, scan, points, k, name, _, sign, line):
    """One quantity at one drive; the two drives stand a little beside each other."""
    points = {value: some for value, some in points.items() if any(np.isfinite(row[name]) for row in some)}
    if not points:
        return
    x = np.array([(scan.place or {}).get(value, value) for value in points], float)
    x = x + 0.16 * (k - 0.5) if scan.place else x * 1.05 ** (k - 0.5)
    mean, error = np.array([mean_error([row[name] for row in some]) for some in points.values()]).T
    size = np.nan_to_num(error) if name in ("significant", "correlation") else bars(mean, error)
    panel.errorbar(x, mean, yerr=size, fmt=sign, ls="none" if scan.place else line, color=COLOURS[k], ms=4.2, lw=0.7,
                   mfc=COLOURS[k] if line == "-" else "white")


def ticks(panel, scan):
    if scan.place:
        panel.set_xticks(list(scan.place.values()), list(scan.place), rotation=60, fontsize=9)
        panel.set_xlim(-0.5, len(scan.place) - 0.5)
        panel.tick_params(axis="x", which="minor", bottom=False, top=False)
        return
    panel.set_xscale("log")
    if scan.ticks:
        panel.set_xticks(scan.ticks, [f"{value:g}" for value in scan.ticks])
        panel.xaxis.set_minor_formatter(NullFormatter())
        panel.tick_params(axis="x", which="minor", bottom=False, top=False)
