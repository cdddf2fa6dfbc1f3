"""Random vibration beyond the figures: no tilt with ten seeds, where sliding is rare, and where the disk bounces."""
import math

import numpy as np

from .catalogue import paper
from .data import Table
from .page import Figure, Numbers, Section
from .style import COLOURS, configuration, figure, in_pi, legend_right, points, power, zero_line
from .verdict import NO, OPEN, SURE, TOLERANCES, YES, Claim, beyond, decide, missing, number, signed, signs, zero
from .vibration import SCALE, longer, name_of

PI = math.pi
FOUR = ("pp", "pm", "mp", "mm")
FEW = 4  # points at which no rotation is seen say nothing about all
CONTRASTS = {"S+- and S-+ against S++ and S--": (-1, 1, 1, -1),
             "S+- against S-+": (0, 1, -1, 0),
             "S++ against S--": (1, 0, 0, -1)}


def sections(results):
    return [level_section(results), rare_section(results), bouncing_section(results)]


def scattered(members, values):
    """Mean over replicas and its standard error from their scatter."""
    error = float(np.std(values, ddof=1) / math.sqrt(len(members))) if len(members) > 1 else math.nan
    return float(np.mean(values)), error


def normal(value, error, degrees):
    """An error with which value counts as far out as its t of so many degrees of freedom is (Wallace)."""
    t = value / error if error > 0 else math.nan
    z = (8 * degrees + 1) / (8 * degrees + 3) * math.sqrt(degrees * math.log1p(t * t / max(degrees, 1)))
    return abs(value) / z if z > 0 else error


# --- without tilt ---------------------------------------------------------------------------------------------------
def level_section(results):
    out = Section("level", "Random vibration without tilt: ten seeds",
                  "Deck <code>inputs/paper/level.cfg</code>: each point has ten runs of 500 time units with other "
                  "seeds; means and their errors are those of the ten.", new=True)
    table = results.sweep("level")
    out.missing = list(table.missing)
    rows, gaps, errors, omega, omega_error = [], [], [], [], []
    for members in sorted(table.sets(), key=lambda part: part.rows[0]["eps_b"]):
        mean, error = scattered(members, members.disk("omega"))
        parts = np.array([members.disk(part) for part in FOUR])
        known = [scattered(members, part) for part in parts]
        rows.append([members.rows[0]["eps_b"], len(members), mean / 5 ** 0.5, error / 5 ** 0.5,
                     *(v for pair in known for v in pair)])
        omega.append(mean)
        omega_error.append(normal(mean, error, len(members) - 1))
        if parts.mean(axis=1).min() <= TOLERANCES["absent"]:
            continue  # contacts slide too seldom for all four to occur
        for weights in CONTRASTS.values():
            gap, spread = scattered(members, weights @ parts / parts.sum(axis=0))
            gaps.append(gap)
            errors.append(normal(gap, spread, len(members) - 1))
    out.claims = [level_claim(results, table.joined()),
                  zero("Ten seeds at each amplitude: without tilt the mean over them is zero within its error from "
                       "their scatter.",
                       omega, omega_error, slug="random-level-seeds"), durations_claim(rows, gaps, errors)]
    out.figures.append(draw_durations(rows))
    out.tables.append(Numbers("Without tilt", ["&epsilon;<sub>b</sub>", "runs", "<i>t<sub>g</sub></i>&Omega;", "error",
                                               *(v for name in ("++", "+&minus;", "&minus;+", "&minus;&minus;")
                                                 for v in (f"S<sup>{name}</sup>", "error"))], rows))
    return out


def level_claim(results, ten):
    """The points of the figure, joined with the ten runs at the same amplitude."""
    flat = results.best("random").joined().where(tilt=0.0)
    both = longer(flat, ten) or ten
    claim = zero(values=both.disk("omega"), errors=both.disk("omega_error"), **paper("random-level"))
    if flat and ten:
        z = np.abs(flat.disk("omega") / flat.disk("omega_error"))
        worst = flat.rows[int(np.argmax(z))]
        again = ten.where(eps_b=worst["eps_b"]).rows
        claim.numbers += f"; of the figure's points alone {name_of(worst)} was {z.max():.1f} errors off"
        if again:
            off = again[0]["upper.omega"] / again[0]["upper.omega_error"]
            claim.numbers += f", ten further runs of it are {abs(off):.1f} off"
    return claim


def durations_claim(rows, gaps, errors):
    if not gaps:
        return missing(**paper("equal-durations"))
    claim = zero(values=gaps, errors=errors, what="difference", **paper("equal-durations"))
    last = rows[-1]
    claim.numbers = ("fractions of time in S<sup>++</sup>, S<sup>+&minus;</sup>, S<sup>&minus;+</sup>, "
                     f"S<sup>&minus;&minus;</sup> at &epsilon;<sub>b</sub> = {number(last[0])}: " +
                     ", ".join(number(last[k], last[k + 1]) for k in (4, 6, 8, 10))
                     + "; differences at all amplitudes at which all four occur: " + claim.numbers)
    return claim


def draw_durations(rows):
    picture, axes = figure(height=3.4)
    for k, name in enumerate(("++", "+-", "-+", "--")):
        if rows:
            eps, value, error = (np.array([row[n] for row in rows]) for n in (0, 4 + 2 * k, 5 + 2 * k))
            points(axes, 1e5 * eps, value, error, ms=9 if k == 0 else 5, **configuration(FOUR[k]))
    axes.set_ylim(bottom=0)
    axes.set_xlabel(r"amplitude $\epsilon_b\times10^{5}$")
    axes.set_ylabel("fraction of time")
    if rows:
        legend_right(axes, "no tilt")
    return Figure("level-durations", picture, "Fractions of time in the four sliding configurations without tilt; "
                                              "error bars are smaller than the "
                                              "symbols.", "Fractions of time in the four sliding configurations "
                                                          "without tilt against amplitude")


# --- rare sliding ---------------------------------------------------------------------------------------------------
def slides(table):
    """Fraction of time in which the contact slides that slides more."""
    return np.maximum(table.disk("left.sliding"), table.disk("right.sliding"))


def rare_section(results):
    limit = TOLERANCES["rare"]
    out = Section("rare", "Random vibration where contacts seldom slide",
                  "Deck <code>inputs/paper/rare.cfg</code>. The paper says of such runs, without showing them, that "
                  "sustained rotation was never observed. <code>rarer.cfg</code>: smaller amplitudes and tilts. "
                  f"Rare: neither contact slides for more than {100 * limit:g} % of the time.", new=True)
    tables = [results.sweep(name).joined() for name in ("rare", "rarer")]
    table = Table([row for part in tables for row in part.rows])
    out.missing = [line for part in tables for line in part.missing]
    out.figures.append(draw_rare(table))
    out.claims = [rare_claim(table), never_claim(table)]
    rows = [[row["eps_b"], row["tilt"] / PI, row["upper.left.sliding"], row["upper.right.sliding"], row["upper.stick"],
             row["upper.scaled"], row["upper.scaled_error"], row["replicas"],
             row["upper.left.openings"] + row["upper.right.openings"]]
            for row in sorted(table.rows, key=lambda row: (row["eps_b"], row["tilt"]))]
    out.tables.append(Numbers("Weak drive", ["&epsilon;<sub>b</sub>", "&theta;<sub>T</sub>/&pi;", "left contact slides",
                                             "right contact slides",
                                             "a contact sticks",
                                             "<i>t<sub>g</sub></i>&Omega;",
                                             "error",
                                             "runs", "openings"], rows))
    return out


def turning(table):
    """How many of the points rotate by more than 3 errors, either way."""
    return int((np.abs(table.disk("omega")) > SURE * table.disk("omega_error")).sum())


def rare_claim(table):
    """Points with tilt between no sliding at all and sliding that is not rare any more."""
    limit, most = TOLERANCES["rare"], slides(table) if table else np.array([])
    rare, often = (Table([row for row, part in zip(table.rows, most) if low <= part < high])
                   for low, high in ((1e-12, limit), (limit, 2.0)))
    if not rare:
        return missing(**paper("rare-sliding"), why="no points between never and often" if table else "no data yet")

    def judge(factor):
        some = Table([row for row, part in zip(table.rows, most) if 1e-12 <= part < factor * limit])
        z = some.disk("omega") / some.disk("omega_error") if some else np.array([])
        return NO if (np.abs(z) > beyond(len(z))).any() else OPEN if len(z) < FEW else YES

    strongest = max(rare.rows, key=lambda row: abs(row["upper.omega"] / row["upper.omega_error"]))
    told = (f"{turning(rare)} of {len(rare)} points rotate by more than {SURE:g} errors ({beyond(len(rare)):.1f} refute), "
            f"most clearly {name_of(strongest)}: <i>t<sub>g</sub></i>&Omega; = "
            f"{number(strongest['upper.scaled'], strongest['upper.scaled_error'])} ("
            f"{abs(strongest['upper.omega'] / strongest['upper.omega_error']):.1f} errors) while the contacts slide for "
            f"{100 * strongest['upper.left.sliding']:.1f} and {100 * strongest['upper.right.sliding']:.1f} % of the time")
    if often:
        told += f"; where one slides longer {turning(often)} of {len(often)} points rotate"
    return Claim(verdict=judge, numbers=told, **paper("rare-sliding"))


def never_claim(table):
    """Without any sliding nothing is left but elastic motion."""
    still = table.such(lambda row: max(row["upper.left.sliding"], row["upper.right.sliding"]) == 0)
    text = "Where contacts do not slide at all under random vibration there is no rotation."
    if not still:
        return missing(text, slug="random-no-sliding", why="contacts slide at all points" if table else "no data yet")
    worst = float(np.abs(still.disk("omega") / (still.column("eps_b") * 20 * PI)).max())
    return decide(text, lambda factor: worst < factor * TOLERANCES["none"], f"{len(still)} points, largest |&Omega;| {number(worst)} "
                                                    "&epsilon;<sub>b</sub>&omega; (counted as none below "
                                                    f"{number(TOLERANCES['none'])})",
                  slug="random-no-sliding",
                  rule="none")


def draw_rare(table):
    picture, axes = figure(height=3.8)
    shown = np.maximum(slides(table), 1e-6) if table else np.array([])
    for k, eps in enumerate(table.values("eps_b")):
        chosen = np.array([abs(row["eps_b"] / eps - 1) < 1e-6 for row in table.rows])
        sign = "os^DvP*X"[k % 8]
        line = table.where(eps_b=eps)
        unit = 1e-3 * eps
        points(axes, shown[chosen], line.disk("scaled") / unit, line.disk("scaled_error") / unit,
               f"${power(eps)}$", k, sign, line="none")
    axes.axvline(TOLERANCES["rare"], color=COLOURS[-1], lw=0.8, ls=":", gid="guide")
    zero_line(axes)
    axes.set_xscale("log")
    axes.set_yscale("symlog", linthresh=1)
    axes.set_xlabel("fraction of time in which the contact slides that slides more")
    axes.set_ylabel(r"$t_g\,\Omega/\epsilon_b\times10^{3}$")
    if table:
        low = 1e3 * float(np.min(table.disk("scaled") / table.column("eps_b")))
        axes.set_ylim(min(2 * low, -2), 10)
        legend_right(axes, r"amplitude $\epsilon_b$")
    return Figure("rare", picture, "Scaled angular velocity over amplitude against the fraction of time in which the "
                                   "contact slides that slides more; dotted: what counts as rare. The axis is linear between &minus;1 and 1, logarithmic beyond.",
                  "Rotation against the fraction of time in which contacts slide, at weak random vibration")


# --- bouncing -------------------------------------------------------------------------------------------------------
def bouncing_section(results):
    out = Section("bouncing", "Random vibration where the disk bounces",
                  "Deck <code>inputs/paper/bouncing.cfg</code>: ten times and more the amplitudes of the figures, four "
                  "runs of 500 time units a point.", new=True)
    table = results.sweep("bouncing").joined()
    out.missing = list(table.missing)
    out.claims = [bouncing_claim(table), process_claim(table)]
    flat = table.where(tilt=0.0)
    out.claims.append(zero("Bouncing, the disk does not rotate without "
                           "tilt.", flat.disk("omega"), flat.disk("omega_error"),
                           slug="bouncing-level"))
    out.figures.append(draw_bouncing(table))
    rows = [[row["eps_b"], row["tilt"] / PI, row["upper.open"],
             row["upper.left.openings"] + row["upper.right.openings"],
             row["upper.scaled"], row["upper.scaled_error"], row["scatter"] / 5 ** 0.5, row["replicas"]]
            for row in sorted(table.rows, key=lambda row: (row["eps_b"], row["tilt"]))]
    out.tables.append(Numbers("Bouncing", ["&epsilon;<sub>b</sub>",
                                           "&theta;<sub>T</sub>/&pi;",
                                           "a contact is open",
                                           "openings",
                                           "<i>t<sub>g</sub></i>&Omega;", "error", "error from scatter", "runs"], rows))
    return out


def bouncing_claim(table):
    """Rotation, of either sense, at points with tilt at which a contact is open for a while."""
    bounce = table.such(lambda row: row["tilt"] > 0 and row["upper.open"] > TOLERANCES["absent"])
    if not bounce:
        return missing(**paper("bouncing-rotation"))
    told = []
    for eps in bounce.values("eps_b"):
        line = bounce.where(eps_b=eps).sorted("tilt")
        z = line.disk("omega") / line.disk("omega_error")
        told.append(f"&epsilon;<sub>b</sub> = {number(eps)} (a contact open for "
                    f"{100 * float(line.disk('open').mean()):.0f} % of the time): {int((np.abs(z) > SURE).sum())} of "
                    f"{len(z)} tilts by more than {SURE:g} errors, {int((z < -SURE).sum())} of them clockwise")

    def judge(factor):
        parts = [bounce.where(eps_b=eps) for eps in bounce.values("eps_b")]
        seen = [YES in [signs(part.disk("omega"), part.disk("omega_error"), sense, factor)[0] for sense in (-1, 1)]
                for part in parts]
        z = np.abs(bounce.disk("omega") / bounce.disk("omega_error"))
        return YES if all(seen) else NO if (z <= factor * SURE).all() and len(bounce) > 3 else OPEN

    return Claim(verdict=judge, numbers="; ".join(told), rule="sign", **paper("bouncing-rotation"))


def process_claim(table):
    """The disk whose contacts are open most of the time turns the other way than with closed ones: counter-clockwise."""
    flying = table.such(lambda row: row["tilt"] > 0 and row["upper.open"] > TOLERANCES["most"])
    claim = signed(values=flying.disk("omega"), errors=flying.disk("omega_error"), sign=1,
                   names=[name_of(row) for row in flying.rows], **paper("bouncing-process"))
    closer = table.such(lambda row: row["tilt"] > 0 and row["upper.open"] <= TOLERANCES["most"])
    if flying and closer:
        claim.numbers += (f" (with permanent contacts it is negative); where a contact is open for "
                          f"{100 * float(closer.disk('open').min()):.0f} to {100 * float(closer.disk('open').max()):.0f} % of the "
                          f"time {int((closer.disk('omega') < -SURE * closer.disk('omega_error')).sum())} of {len(closer)} are "
                          "still negative")
    return claim


def draw_bouncing(table):
    picture, axes = figure(height=3.8)
    for k, eps in enumerate(table.values("eps_b")):
        line = table.where(eps_b=eps).sorted("tilt")
        points(axes, line.column("tilt") / PI, SCALE * line.disk("scaled"), SCALE * line.disk("scaled_error"),
               f"${power(eps)}$", k,
               "os^D"[k % 4])
    zero_line(axes)
    axes.set_yscale("symlog", linthresh=1)
    in_pi(axes.xaxis, 0.02)
    axes.set_xlabel(r"tilt $\theta_T$")
    axes.set_ylabel(r"$t_g\,\Omega\times10^{4}$")
    if table:
        legend_right(axes, r"amplitude $\epsilon_b$")
    return Figure("bouncing", picture, "Scaled angular velocity against tilt where the upper disk bounces. The axis is "
                                       "linear between &minus;1 and 1, logarithmic "
                                       "beyond.", "Rotation against tilt for a bouncing disk")
