"""Weak drive and stiff contacts: is there rotation where no contact opens?"""
import numpy as np

from ratchet.page import Figure, Numbers, Section
from ratchet.style import COLOURS, GREY, figure, legend_below
from ratchet.verdict import MOTIONS, SURE, beside, decide, missing, number

from . import each
from .disks import CHANCE, PERIOD, RULE, boxes, by_drive
from .drive import bars
from .statistics import mean_error, share, weighted_power

# Entry, stiffness of a contact, label: the sweep of drives is there to compare with.
SETS = (("drive", 1e4), ("quiet", 1e5), ("quiet_stiff", 1e6), ("quiet_long", 1e5), ("random", 1e4), ("quiet_random", 1e5))
OWN = {MOTIONS[0]: ("quiet", "quiet_stiff", "quiet_long"), MOTIONS[1]: ("quiet_random",)}
WEAK = 0.3  # in units of g; beyond it the sweep of drives is no weak drive


def power(stiffness):
    return f"10<sup>{round(np.log10(stiffness))}</sup>"


def closed(box):
    """Which disks, rattlers left out, had no contact that opened while measured."""
    return box.held & (box["openings"] == 0)


def never_opened(found):
    """(share, error) of disks that are no rattlers none of whose contacts opened."""
    return share([(int(closed(box).sum()), int(box.held.sum())) for box in found])


def turning_closed(found):
    """(share, error) that turns, alike in both halves, of the disks that slid and none of whose contacts opened."""
    chosen = [closed(box) & (box["friction"] > 0) for box in found]
    return share([(int((box.turns & each.alike(box) & part).sum()), int(part.sum()))
                  for box, part in zip(found, chosen)])


def openings(found):
    """Openings per contact and period at disks that are no rattlers: means over packings."""
    rates = [np.sum(box["openings"][box.held]) * PERIOD / max(np.sum(box["coordination"][box.held]), 1e-300)
             for box in found if box.held.any()]
    return mean_error(rates)


def row(name, stiffness, drive, found):
    held = [box.held for box in found]
    return {"name": name, "stiffness": stiffness, "drive": drive, "boxes": found,
            "measured": found[0].whole["measured"], "counts": each.census(found),
            "closed": never_opened(found), "openings": openings(found), "turning": turning_closed(found),
            "sliding": mean_error([float(np.mean(box["sliding"][part])) for box, part in zip(found, held)]),
            "rms": mean_error([box.rms for box in found]), "median": mean_error([box.median for box in found]),
            "noise": mean_error([float(np.median(box["error"][part])) for box, part in zip(found, held)])}


def rows_of(campaign):
    made, own = [], [name for names in OWN.values() for name in names]
    for name, stiffness in SETS:
        for drive, found in by_drive(boxes(campaign, name)).items():
            if name in own or drive <= WEAK:
                made.append(row(name, stiffness, drive, found))
    return made


def label(r):
    return f"{r['drive']:g} <i>g</i>, <i>k</i><sub>n</sub> = {power(r['stiffness'])} ({r['measured']:.0f} s)"


def sections(campaign):
    rows = rows_of(campaign)
    own = {motion: [r for r in rows if r["name"] in names] for motion, names in OWN.items()}
    out = Section("quiet", "Stiff contacts, weak drive: rotation without openings",
                  "<code>inputs/packing/quiet.cfg</code>: contacts ten times as stiff as in the other boxes, so that "
                  "the lowest resonance lies above the 80 Hz of the floor (a chain of eight disks has 138 Hz, with the "
                  "soft contacts 44 Hz); a hundred times as stiff; and two packings for 2000 s. "
                  "<i>k</i><sub>t</sub>/<i>k</i><sub>n</sub> = 0.5 as elsewhere, velocity-Verlet at a 50th of the "
                  "shortest period. Random drive has the rms displacement of the harmonic one. The weakest drives of the sweep with soft contacts stand beside them. An opening is "
                  f"a contact that ends, at any step. {RULE}", missing=campaign.missing(*OWN[MOTIONS[0]], *OWN[MOTIONS[1]]))
    if not own[MOTIONS[0]]:
        out.claims.append(missing("Disks turn although none of their contacts ever opens.", slug="quiet-turning"))
        return [out]
    out.claims += beside(*([no_openings(some), without_openings(some), vanishes(some),
                            *(each.claim(r["boxes"], r["drive"], slug_of(r), label(r)) for r in some),
                            *(lasts(r) for r in some if r["name"] == "quiet_long")] for some in own.values() if some))
    out.figures.append(against_drive(rows))
    out.figures.append(sizes(own[MOTIONS[0]]))
    out.tables.append(numbers_table(rows))
    return [out]


def slug_of(r):
    return f"each-disk-{r['name'].replace('_random', '').replace('_', '-')}-{r['drive']:g}"


def no_openings(rows):
    """Judged at the weakest drive: there it must hold, if anywhere."""
    weakest = min(rows, key=lambda r: (r["drive"], -r["stiffness"]))
    none = bool(all((box["openings"][box.held] == 0).all() for box in weakest["boxes"]))
    told = "; ".join(f"{label(r)}: {each.percent(r['closed'])} of the disks never, "
                     f"{number(*r['openings'], digits=2)} openings per contact and period" for r in rows)
    return decide(f"At the weakest drive, {weakest['drive']:g} <i>g</i>, no contact of a disk that is no rattler "
                  f"opens.",
                  none, told, slug="quiet-no-openings")


def without_openings(rows):
    """Over all drives, whose errors are independent: the scatter between drives is no error."""
    parts = [(*r["turning"], sum(int((closed(box) & (box["friction"] > 0)).sum()) for box in r["boxes"])) for r in rows]
    value, error, count = np.array([part for part in parts if part[2]], float).reshape(-1, 3).T
    told = "; ".join(f"{label(r)}: {each.percent(r['turning'])}" for r in rows)
    text = (f"Disks turn by sliding alone: of those that slide and none of whose contacts opens more turn than the "
            f"{100 * CHANCE:.0f} % that chance allows.")
    if not len(count):
        return missing(text, why="no disk slides without openings", slug="quiet-turning")
    mean, spread = np.average(value, weights=count), np.hypot.reduce(error * count) / count.sum()
    verdict = True if mean - SURE * spread > CHANCE else False if mean + SURE * spread < each.SIZEABLE else None
    return decide(text, verdict, f"{each.percent((mean, spread))} of {count.sum():.0f}, in the same sense and at "
                                 f"about the same "
                  f"speed in both halves of the time; {told}", slug="quiet-turning")


def vanishes(rows):
    """The part that turns at the weakest and the strongest drive of the sweep with stiff contacts."""
    swept = sorted((r for r in rows if r["name"] in ("quiet", "quiet_random")), key=lambda r: r["drive"])
    text = "The weaker the drive, the fewer disks turn: rotation fades with sliding."
    if len(swept) < 2:
        return missing(text, slug="quiet-fades")
    (low, low_error), (high, high_error) = (r["counts"][each.TURNS] for r in (swept[0], swept[-1]))
    step, error = high - low, np.hypot(low_error, high_error)
    verdict = None if not error > 0 else True if step > SURE * error else False if step < SURE * error * -1 else None
    curves = replicas(swept)
    drives = [r["drive"] for r in swept]
    fit = weighted_power(curves, drives)
    return decide(text, verdict, "; ".join(f"{r['drive']:g} <i>g</i>: {each.percent(r['counts'][each.TURNS])} turn, "
                                           f"{number(100 * r['sliding'][0], 100 * r['sliding'][1])} % of the contacts "
                                           f"slide"
                                           for r in swept)
                  + f"; rms &Omega; ~ drive<sup><i>a</i></sup> with <i>a</i> = {fit}", slug="quiet-fades")


def replicas(rows):
    """{drive: rms} of each packing, known by its number."""
    curves = {}
    for r in rows:
        for box in r["boxes"]:
            if box.rms > 0:
                curves.setdefault(box.replica, {})[r["drive"]] = box.rms
    return list(curves.values())


def lasts(r):
    """The long run: what turns in its first half turns in its second."""
    ranks, scaled = each.consistency(r["boxes"])
    value, error = r["counts"]["lasting"]
    verdict = None if not np.isfinite(value) else True if value - SURE * np.nan_to_num(error) > 0.5 else \
        False if value + SURE * np.nan_to_num(error) < 0.5 else None
    return decide(f"For {r['measured']:.0f} s disks that turn go on turning: most do so in both halves, in the same "
                  f"sense and "
                  "at no less than half the speed.", verdict,
                  f"{each.percent(r['counts']['lasting'])} of those that turn; halves, scaled by the rms of each "
                  f"packing: "
                  f"Pearson {number(*scaled)}, Spearman {number(*ranks)}", slug="quiet-lasts")


def numbers_table(rows):
    made = []
    for r in rows:
        counts = r["counts"]
        made.append([r["name"], r["stiffness"], float(r["drive"]), len(r["boxes"]), float(r["measured"]),
                     number(*r["openings"]), *(number(100 * v, 100 * e) for v, e in (
                         r["closed"], r["sliding"], counts[each.TURNS], counts[each.SLIDES], counts[each.STICKS],
                         counts[each.UNSEEN], r["turning"], counts["lasting"])),
                     number(*r["rms"]), number(*r["median"]), number(*r["noise"])])
    return Numbers("Weak drive; fractions in per cent, disks that are no rattlers; angular velocities in rad/s",
                   ["runs", "<i>k</i><sub>n</sub> (N/m)", "drive/<i>g</i>", "packings", "measured (s)",
                    "openings per contact and period", "disks that never open", "sliding contacts", "turn",
                    "slide, stand still", "never slide", "undecided", "turn, of those that slide and never open",
                    "same in both halves, of those that turn", "rms &Omega;", "median |&Omega;|", "median error"], made)


LOOK = {"drive": (COLOURS[0], "o", "$k_n = 10^4$"), "quiet": (COLOURS[1], "s", "$k_n = 10^5$"),
        "quiet_stiff": (COLOURS[2], "^", "$k_n = 10^6$"), "quiet_long": (COLOURS[3], "D", "$k_n = 10^5$, 2000 s"),
        "random": (COLOURS[0], "o", "$k_n = 10^4$, random"), "quiet_random": (COLOURS[1], "s", "$k_n = 10^5$, random")}


def against_drive(rows):
    picture, axes = figure(columns=2, rows=2, width=7.2, height=5.8, sharex=True, legend=True)
    panels = ((axes[0, 0], "openings", "openings per contact\nand period", True),
              (axes[0, 1], "closed", "disks that never open", False),
              (axes[1, 0], "turning", "turn, of those that slide\nand never open", False),
              (axes[1, 1], "rms", r"rms $\Omega$ (rad/s)", True))
    for name, (colour, sign, text) in LOOK.items():
        part = sorted((r for r in rows if r["name"] == name), key=lambda r: r["drive"])
        if not part:
            continue
        drives = np.array([r["drive"] for r in part])
        for panel, key, _, logarithmic in panels:
            value, error = (np.array([r[key][k] for r in part], float) for k in range(2))
            shown = (value > 0) if logarithmic else np.isfinite(value)
            spread = bars(value, error)[:, shown] if logarithmic else np.nan_to_num(error)[shown]
            random = "random" in name
            panel.errorbar(drives[shown], value[shown], yerr=spread, fmt=sign + ("--" if random else "-"), lw=0.7,
                           mfc=colour if random else "white", color=colour, label=text)
    for panel, key, text, logarithmic in panels:
        panel.set_xscale("log")
        panel.set_ylabel(text)
        if logarithmic:
            panel.set_yscale("log")
        else:
            panel.set_ylim(-0.03, 1.03)
        if key == "turning":
            panel.axhline(CHANCE, color=GREY, lw=0.8, ls=":", gid="guide")
    drives = sorted({r["drive"] for r in rows})
    for panel in axes[1]:
        panel.set_xlabel("peak acceleration of the floor / $g$")
        panel.set_xticks(drives, [f"{d:g}" for d in drives])
        panel.minorticks_off()
    legend_below(picture, axes[0, 1], 5, fontsize=8, columnspacing=1.0)
    return Figure("quiet", picture, "Weak drive, harmonic (open symbols) and random with the same rms displacement (full), with "
                                    "soft, stiff and very stiff contacts; disks that are no rattlers. "
                                    "Where no "
                  "contact opened the point is missing in the logarithmic panel. Dotted: what chance allows.",
                  "Openings, fractions of disks that never open and that turn, and rms angular velocity against weak drive")


def sizes(rows):
    """How large the rotations are at each weak drive."""
    picked = {f"{r['drive']:g} $g$": r["boxes"] for r in rows if r["name"] == "quiet"}
    picked = picked or {f"{r['drive']:g} $g$": r["boxes"] for r in rows}
    return each.sizes_figure(picked, "quiet-sizes")
