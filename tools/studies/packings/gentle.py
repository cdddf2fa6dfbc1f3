"""Harmonic and random vibration of the same rms displacement in the same packings: two answers."""
import numpy as np

from ratchet.page import Figure, Numbers, Section
from ratchet.runs import slipdisk
from ratchet.style import COLOURS, GREY, figure, legend_below
from ratchet.verdict import MOTIONS as WORDS
from ratchet.verdict import SURE, beside, decide, missing, number

from . import alone, each, memory
from .disks import Box, of_motions, persistent_contacts
from .reading import Reading, Run
from .statistics import jackknife, pearson, share, spearman

TIMES = (0.25, 0.5, 0.75, 1)  # parts of the measured time: quarters
MOTIONS = ("harmonic", "noise 1", "noise 2")
ALIKE = 0.1    # difference of two fractions up to which they count as the same
LEVEL = 0.05   # of the disks: the fraction that turns has come to a level when the second half adds no more
SHARP = 0.1    # error of the exponent from which on it is told
LOW = 0.3      # drives in units of g up to which contacts hardly open
DIGITS = 5


# --- numbers of each disk ---------------------------------------------------------------------------------------------
def numbers(campaign):
    """{column: a value for each disk of each run}; motion: of MOTIONS."""
    rows = {}
    for path in campaign.files("gentle"):
        run = Run(Reading(path).scalars(), path=path)
        known, means = run.parameters, run.means
        columns = {"drive": known["drive"], "packing": memory.packing_of(known), "motion": known.get("noise", 0.0),
                   "measured": run.measured, "disk": run.id, "radius": run.radius, "omega": run.omega, "error": run.error,
                   "omega_first": run.first, "omega_second": run.second, "persistent": persistent_contacts(run),
                   **{name: means[name] for name in ("openings", "friction", "injected")}, **ratios(run)}
        for name, values in columns.items():
            rows.setdefault(name, []).append(np.broadcast_to(values, run.n_free))
    return {name: np.concatenate(values) for name, values in rows.items()} if rows else None


def ratios(run):
    """{"sure_1": |Omega| over its error after the first quarter of the time, ...} of each disk, from the bins of its
    angle."""
    state = run.result.state
    count = int(state["mean_bins"])
    bins = state["mean_bin"].reshape(-1, state["mean_bin"].size // run.n_free)[:, :count]
    found = {}
    for quarter, part in enumerate(TIMES, 1):
        known = [slipdisk.mean(row[:round(part * count)]) for row in bins]
        found[f"sure_{quarter}"] = [abs(one.mean) / one.error if one.error > 0 else 0.0 for one in known]
    return found


def boxes(table):
    """{drive: {motion: boxes}}"""
    found = {}
    for drive, motion, packing in sorted({(r["drive"], r["motion"], r["packing"]) for r in table.rows}):
        part = table.where(drive=drive, motion=motion, packing=packing)
        columns = {name: part.column(name) for name in part.rows[0]}
        whole = {"drive": drive, "replica": packing, "measured": part.rows[0]["measured"]}
        found.setdefault(drive, {}).setdefault(int(motion), []).append(Box(whole, columns))
    return found


# --- the section --------------------------------------------------------------------------------------------------------
def sections(campaign):
    table = campaign.numbers("gentle", lambda: numbers(campaign), "mean angular velocity (rad/s), openings per second and "
                             "powers (W) of each disk; motion 0: harmonic, 1, 2: realisations of the noise; sure_n: "
                             "|Omega| over its error after n quarters of the time", DIGITS, **campaign.told("gentle"))
    found = boxes(table) if table else {}
    length = next((part[0][0].whole["measured"] for part in found.values() if 0 in part), 0)
    count = max((len(part.get(0, ())) for part in found.values()), default=0)
    out = Section("gentle", "Harmonic and random drive, matched rms displacement",
                  f"<code>inputs/packing/cage_gentle.cfg</code>: the same {count} packings of 60 disks, shaken by the "
                  "harmonic motion of peak acceleration <i>a</i> and by two realisations of the random one, whose "
                  "<i>rms displacement is the same</i>, <i>a</i>/&radic;2&omega;&sup2; (the key <code>acceleration</code> "
                  f"of a random motion is &omega;&sup2; times its rms displacement). Each run is measured for {length:.0f} "
                  f"s after 10 s, at a time step of 6&times;10<sup>&minus;5</sup> s. Rattlers are left out. A fraction "
                  "against time counts the disks that would be beyond 3 errors had the run ended then.",
                  missing=campaign.missing("gentle"))
    if not found:
        out.claims.append(missing("As many disks turn under random drive as under harmonic drive.", slug="gentle-equal"))
        return [out]
    for drive, part in found.items():
        if len(part) == len(MOTIONS):
            out.claims += [equal(drive, part), repeats(drive, part), carried(drive, part), levelled(drive, part),
                           *both(drive, part)]
    strong = alone.packings_of(*alone.tables_of(campaign))[0]
    for drive in sorted({key[0] for key in strong if (key[0], 0.0) in strong and (key[0], 1.0) in strong}):
        out.claims.append(carried_strongly(drive, strong[drive, 0.0], strong[drive, 1.0]))
    sweeps = of_motions(campaign)
    out.claims += beside(*([dissipation({d: some for d, some in table.items() if d <= LOW}, word)]
                           for word, table in sweeps.items()))
    out.figures += [fractions_figure(found), kinds_figure(*sweeps.values())]
    out.tables.append(numbers_table(found))
    return [out]


def turning(found):
    """(fraction, error) of the disks beyond three errors."""
    return share([(int(box.turns[box.held].sum()), int(box.held.sum())) for box in found])


def never(found):
    return share([(int((box["openings"][box.held] == 0).sum()), int(box.held.sum())) for box in found])


def equal(drive, part):
    """Judged by the difference of the fractions, noise 1 and 2 together."""
    (a, da), (b, db) = turning(part[0]), turning(part[1] + part[2])
    error = float(np.hypot(da, db))
    verdict = None if not error > 0 else False if abs(b - a) - SURE * error > 0 and abs(b - a) > ALIKE \
        else True if abs(b - a) + 2 * error < ALIKE else None
    return decide(f"At {drive:g} <i>g</i> as many disks turn under random drive as under harmonic drive.", verdict,
                  f"beyond {SURE:g} errors {each.percent((a, da))} under harmonic drive, {each.percent((b, db))} under "
                  f"random drive; no contact ever opens at {each.percent(never(part[0]))} and "
                  f"{each.percent(never(part[1] + part[2]))} of the disks", slug=f"gentle-equal-{drive:g}g")


def both(drive, part):
    """That each disk turns, for either motion."""
    where = f"{drive:g} <i>g</i> ({part[0][0].whole['measured']:.0f} s)"
    return beside(*([each.claim(some, drive, f"gentle-each-{word}-{drive:g}g", where)]
                    for some, word in zip((part[0], part[1] + part[2]), WORDS)))


def pairs(part, a, b):
    """[(omega in a, in b, sure in both)] of each packing, no rattlers."""
    return [(x["omega"][both], y["omega"][both], (x.turns & y.turns)[both])
            for x, y in zip(part[a], part[b]) for both in [x.held & y.held]]


def same_sense(found):
    return share([(int(((a * b > 0) & sure).sum()), int(sure.sum())) for a, b, sure in found])


def compared(found):
    """Numbers of two histories, in HTML."""
    linear = jackknife(lambda groups: pearson(*(np.concatenate([g[k] for g in groups]) for k in range(2))), found)
    ranks = jackknife(lambda groups: spearman(*(np.concatenate([g[k] for g in groups]) for k in range(2))), found)
    return f"correlation {number(*linear)}, of ranks {number(*ranks)}"


def likeness(drive, found, text, slug):
    """Do disks that turn in both do so in the same sense?"""
    value, error = same_sense(found)
    count = int(sum(sure.sum() for _, _, sure in found))
    verdict = None if not error > 0 or count < 10 else True if value - 2 * error > 0.8 else \
        False if value + 2 * error < 0.8 else None
    return decide(text, verdict, f"same sense {each.percent((value, error))} of {count} disks beyond {SURE:g} errors in "
                                 f"both; {compared(found)}", slug=f"{slug}-{drive:g}g")


def repeats(drive, part):
    return likeness(drive, pairs(part, 1, 2), f"At {drive:g} <i>g</i> disks turn in the same sense, more than four out of "
                    "five, in two realisations of the noise.", "gentle-repeats")


def carried(drive, part):
    return likeness(drive, pairs(part, 0, 1) + pairs(part, 0, 2), f"At {drive:g} <i>g</i> disks turn in the same sense, "
                    "more than four out of five, under random drive as under harmonic drive.", "gentle-carried")


def carried_strongly(drive, harmonic, random):
    """The same of the packings of alone.py: at 0.7 and 2 g in ten seconds."""
    some = [(a.omega[both], b.omega[both], (a.turns & b.turns)[both])
            for a, b in zip(harmonic, random) for both in [a.held & b.held]]
    return likeness(drive, some, f"At {drive:g} <i>g</i>, in eight packings, disks turn in the same sense, more than four "
                    "out of five, under random drive as under harmonic drive.", "gentle-carried-eight")


def fraction_at(found, n):
    """(fraction, error) beyond three errors after n quarters of the time."""
    return share([(int((box[f"sure_{n}"][box.held] > SURE).sum()), int(box.held.sum())) for box in found])


def levelled(drive, part):
    """Does the second half of the time add disks that turn, under random drive?"""
    some = part[1] + part[2]
    values = [fraction_at(some, quarter) for quarter in range(1, 5)]
    step = [(int(((box["sure_4"] > SURE).astype(int) - (box["sure_2"] > SURE))[box.held].sum()), int(box.held.sum()))
            for box in some]
    value, error = jackknife(lambda groups: sum(g[0] for g in groups) / sum(g[1] for g in groups), step)
    verdict = None if not error >= 0 else True if value + 2 * error < LEVEL else False if value - 2 * error > LEVEL else None
    time = some[0].whole["measured"]
    told = "; ".join(f"{each.percent(v)} after {time * t:.0f} s" for v, t in zip(values, TIMES))
    return decide(f"At {drive:g} <i>g</i>, random drive, the fraction of disks that turn has come to a level: the second "
                  f"half of the time adds less than {100 * LEVEL:.0f} % of the disks.", verdict,
                  f"it adds {number(100 * value, 100 * error)} %; {told}", slug=f"gentle-level-{drive:g}g")


def dissipation(table, word):
    """The follow-up's argument at low drive, as it can be put: the power that comes in goes into friction, and rotation
    takes a fixed share of it, mu N R |Omega| ~ P. Then rms Omega ~ P, packing by packing."""
    curves = {}
    for found in table.values():
        for box in found:
            power = float(np.mean(box["friction"][box.held]))
            if power > 0 and box.rms > 0:
                curves.setdefault(box.replica, []).append((power, box.rms))
    text = ("Low drive: the typical &Omega; follows from dissipation, rms &Omega; ~ power of friction.")
    logs = [np.log(np.array(points)) for points in curves.values() if len(points) >= 3]
    if not logs:
        return missing(text, kind="paper", slug=f"dissipation-{word}")
    value, error = jackknife(lambda groups: slope(groups), logs)
    left = np.concatenate([slope_residuals(points) for points in logs])
    spread = float(np.sqrt(np.sum(left ** 2) / max(len(left) - 2 * len(logs), 1)
                           / sum(np.sum((points[:, 0] - points[:, 0].mean()) ** 2) for points in logs)))
    error = float(np.nanmax([error, spread]))
    verdict = False if abs(value - 1) > SURE * error else True if error < SHARP else None
    drives = ", ".join(f"{drive:g}" for drive in table)
    return decide(text, verdict, f"rms &Omega; ~ power<sup><i>b</i></sup>, <i>b</i> = {number(value, error)} at {drives} "
                  f"<i>g</i>, {len(logs)} packings; expected 1", kind="paper", slug=f"dissipation-{word}")


def slope(groups):
    """Common slope of several sets of points (x, y), each about its own mean."""
    rows = np.vstack([points - points.mean(axis=0) for points in groups])
    return float(rows[:, 0] @ rows[:, 1] / (rows[:, 0] @ rows[:, 0]))


def slope_residuals(points):
    rows = points - points.mean(axis=0)
    return rows[:, 1] - slope([points]) * rows[:, 0]


# --- tables and figures -------------------------------------------------------------------------------------------------
def numbers_table(found):
    rows = []
    for drive, part in found.items():
        for motion, some in part.items():
            counts = each.census(some)
            rows.append([drive, MOTIONS[motion], len(some), counts["disks"], *(number(100 * v, 100 * e) for v, e in (
                counts[each.TURNS], counts["still"], counts["lasting"], never(some))),
                float(np.mean([box.rms for box in some])), float(np.median(np.concatenate([box["error"][box.held]
                                                                                          for box in some])))])
    return Numbers("The same packings under harmonic and random drive, disks in per cent", [
        "drive/<i>g</i>", "motion", "packings", "disks", "beyond 3 errors", "stand still", "same in both halves, of those "
        "that turn", "no contact ever opens", "rms &Omega; (rad/s)", "median error (rad/s)"], rows, shown=True)


def kinds_figure(harmonic, random):
    picture, axes = figure(columns=2, width=7.2, height=3.3, legend=True, sharey=True,
                           gridspec_kw={"width_ratios": [max(len(harmonic), 1), max(len(random), 1)]})
    for panel, table, word in zip(axes, (harmonic, random), ("harmonic", "random")):
        each.shares_panel(panel, table, "drive / $g$")
        panel.set_title(f"{word} drive", fontsize=10)
    axes[0].set_ylabel("fraction of the disks")
    legend_below(picture, axes, 4)
    return Figure("each-disk", picture, "What the disks do that are no rattlers, under harmonic drive (sweep of drives, 60 s) "
                  "and under random drive of the same rms displacement. Error bars: leaving out packings. Dotted: "
                  f"{100 * each.CHANCE:.0f} %, so many disks that do not turn may be beyond {SURE:g} errors by chance.",
                  "Stacked bars of what disks do against drive, harmonic and random")


def fractions_figure(found):
    picture, axes = figure(columns=2, width=7.2, height=3.2, legend=True)
    drives = np.array(list(found))
    shown = drives[::(len(drives) + 1) // 2]
    for motion, (word, sign) in enumerate(zip(MOTIONS, "osD")):
        some = [drive for drive in drives if motion in found[drive]]
        value, error = np.array([turning(found[drive][motion]) for drive in some]).reshape(-1, 2).T
        axes[0].errorbar(some, value, yerr=np.nan_to_num(error), fmt=sign + "-", lw=0.8, mfc="white",
                         color=COLOURS[min(motion, 1)], label=word)
        for drive, dash in zip(shown, (":", "--", "-")):
            if motion in found[drive]:
                time = found[drive][motion][0].whole["measured"]
                values = [fraction_at(found[drive][motion], quarter)[0] for quarter in range(1, 5)]
                axes[1].plot(np.array(TIMES) * time, values, dash, marker=sign, ms=3.5, mfc="white", lw=0.9,
                             color=COLOURS[min(motion, 1)])
    for drive, dash in zip(shown, (":", "--", "-")):
        axes[0].plot([], [], dash, color=GREY, lw=0.9, label=f"{drive:g} $g$ (right)")
    axes[0].set_xscale("log")
    axes[0].set_xticks(drives, [f"{d:g}" for d in drives])
    axes[0].minorticks_off()
    axes[0].set_xlabel("drive / $g$")
    axes[1].set_xlabel("measured time (s)")
    for panel in axes:
        panel.set_ylim(-0.03, 1.03)
    axes[0].set_ylabel("fraction beyond 3 errors")
    axes[1].set_xlim(left=0)
    legend_below(picture, axes, 6, fontsize=8, columnspacing=1.0)
    return Figure("gentle", picture, "Fraction of the disks (no rattlers) whose mean angular velocity is beyond 3 errors, "
                  "in the same packings under the harmonic motion and under two realisations of the random one with the "
                  "same rms displacement. Left: at the end, against drive (peak acceleration of the harmonic motion). "
                  "Right: against the measured time.",
                  "Fraction of disks that turn under harmonic and random drive, against drive and against time")
