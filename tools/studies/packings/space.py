"""Correlation of Omega_i and Omega_j with the distance of two disks and with the contacts between them."""
import collections

import numpy as np

from ratchet.page import Figure, Numbers, Section
from ratchet.style import figure, legend_below, points, zero_line
from ratchet.verdict import MOTIONS, NO, OPEN, SURE, YES, Claim, beside, missing, number, zero

from . import contacts
from .memory import BLOCK, DRIVES, at_random, measured, shaken
from .statistics import jackknife

CASES = [*(f"60 disks, {drive:g} <i>g</i>" for drive in DRIVES.values()), "10000 disks, 2 <i>g</i>"]
SLUGS = [*(f"{drive:g}g" for drive in DRIVES.values()), "1e4"]
FAR, DEEP = 8, 6   # largest distance in mean diameters; most contacts between two disks
SIDE = 4            # a large packing is divided into SIDE x SIDE blocks, which count as packings
SLACK = 0.02        # mean diameters: surfaces of neighbours are as near as this where there are no tables of contacts
LAYER = 5           # mean diameters: Omega of a large packing is taken over the rms of such a layer


def sections(campaign):
    return [section(campaign)]


def numbers(campaign):
    """Sums over pairs of disks: a row for each motion (its place in MOTIONS), case, packing or block, kind of distance and
    distance."""
    drives, rows = list(DRIVES.values()), []
    for motion, (some, large) in enumerate(((shaken, "shake_1e4"), (at_random, "shake_1e4_random"))):
        made = [row for drive, packing, run in some(campaign)
                for row in of_run(drives.index(drive), packing, run, contacts.Cage(run))]
        made += [row for run in measured(campaign, large) for row in of_run(len(drives), 0, run, None)]
        rows += [{"motion": motion, **row} for row in made]
    return {key: [row[key] for row in rows] for key in rows[0]} if rows else None


def of_run(case, first, run, cage):
    diameter = 2 * run.radius.mean()
    x, y, omega, sure = run.x / diameter, run.y / diameter, run.omega, np.abs(run.omega) > 3 * run.error
    block = 1000 * first + np.arange(len(x)) // BLOCK
    if cage is None:
        layer = ((y - y.min()) // LAYER).astype(int)
        omega = omega / np.sqrt(np.bincount(layer, omega ** 2) / np.bincount(layer))[layer]
        block = (cut(x) * SIDE + cut(y)).astype(int)
    neighbours = touching(x, y, run.radius / diameter) if cage is None else meshed(cage)
    square = float(np.mean(omega ** 2))
    rows = []
    for kind, (i, j, distance) in (("distance", near(x, y, FAR)), ("contacts", along(neighbours, DEEP))):
        step = distance if kind == "contacts" else 1 + np.maximum((distance - 0.75) // 0.5, 0) / 2
        product = omega[i] * omega[j]
        both = sure[i] & sure[j]
        for one in np.unique(block):
            here = block[i] == one
            for value in np.unique(step[here]):
                some = here & (step == value)
                rows.append({"case": case, "block": one, "kind": kind,
                             "distance": value,
                             "pairs": some.sum(), "product": product[some].sum() / square,
                             "sure": (some & both).sum(), "opposite": (some & both & (product < 0)).sum()})
    return rows


def cut(x):
    """Numbers 0 ... SIDE - 1 of equally wide strips."""
    return np.minimum((x - x.min()) / np.ptp(x) * SIDE, SIDE - 1e-9) // 1


def near(x, y, reach):
    """(i, j, distance) of all ordered pairs up to this distance."""
    i, j, apart = [], [], []
    order = np.argsort(x)
    for k, a in enumerate(order):
        last = np.searchsorted(x[order], x[a] + reach)
        b = order[k + 1:last]
        r = np.hypot(x[b] - x[a], y[b] - y[a])
        b, r = b[r <= reach], r[r <= reach]
        i += [np.full(len(b), a), b]
        j += [b, np.full(len(b), a)]
        apart += [r, r]
    return np.concatenate(i), np.concatenate(j), np.concatenate(apart)


def touching(x, y, radius):
    """Neighbours of each disk: disks whose surfaces are nearer than SLACK."""
    i, j, apart = near(x, y, 2 * radius.max() + SLACK)
    kept = apart < radius[i] + radius[j] + SLACK
    return lists(len(x), i[kept], j[kept])


def meshed(cage):
    """Neighbours of each disk that it touches for part of the time."""
    kept = cage.other < cage.n
    return lists(cage.n, cage.disk[kept], cage.other[kept])


def lists(n, i, j):
    found = [[] for _ in range(n)]
    for a, b in zip(i, j):
        found[a].append(int(b))
    return found


def along(neighbours, reach):
    """(i, j, contacts on the shortest way) of all ordered pairs up to so many."""
    i, j, steps = [], [], []
    for start in range(len(neighbours)):
        seen, queue = {start: 0}, collections.deque([start])
        while queue:
            one = queue.popleft()
            if seen[one] == reach:
                break
            for other in neighbours[one]:
                if other not in seen:
                    seen[other] = seen[one] + 1
                    queue.append(other)
        i += [start] * (len(seen) - 1)
        j += list(seen)[1:]
        steps += list(seen.values())[1:]
    return np.array(i), np.array(j), np.array(steps)


# --- the section --------------------------------------------------------------------------------------------------
def section(campaign):
    table = campaign.numbers("space", lambda: numbers(campaign), digits=6,
                             title="sums over pairs of disks by distance; case: number of the packing's kind")
    out = Section("space", "How far &Omega;<sub>i</sub> are correlated",
                  "&lang;&Omega;<sub>i</sub>&Omega;<sub>j</sub>&rang; over &lang;&Omega;&sup2;&rang; of pairs of "
                  "disks by the distance of their mean places and by the number of contacts on the shortest way "
                  "between them. 60 disks: all pairs of disks that touch for a tenth of the time "
                  f"are in contact; 10000 disks: surfaces of mean places nearer than {SLACK:g} diameters, &Omega; "
                  f"over the rms of its layer of {LAYER} diameters. Errors: leaving out ten neighbouring disks, or "
                  f"one of {SIDE * SIDE} blocks of the large one, at a time. Without any correlation 60 disks have "
                  "&minus;1/59.",
                  missing=campaign.missing(*DRIVES, "shake_1e4", "shake_1e4_random"))
    if not table:
        out.claims.append(missing("Disks in contact turn against each other, like gears.", slug="gears-contact"))
        return out
    curves = {word: {k: {kind: curve(table.where(motion=float(motion), case=float(k), kind=kind))
                         for kind in ("distance", "contacts")}
                     for k in range(len(CASES)) if len(table.where(motion=float(motion), case=float(k)))}
              for motion, word in enumerate(MOTIONS)}
    out.claims += beside(*([claim for k, found in some.items() for claim in claims(k, found)] for some in curves.values()))
    rows = [[word, CASES[k], int(row[0]), int(row[5]), number(row[1], row[2]), number(row[3], row[4])]
            for word, some in curves.items() for k, found in some.items() for row in zip(*found["contacts"])]
    out.figures.append(curves_figure(curves))
    out.tables.append(Numbers("By contacts between two disks", [
        "motion", "packing", "contacts", "pairs", "&lang;&Omega;<sub>i</sub>&Omega;<sub>j</sub>&rang;/&lang;&Omega;&sup2;&rang;",
        "share of opposite senses (both beyond 3 errors)"], rows))
    return out


def claims(k, found):
    made = [gears(CASES[k], SLUGS[k], found["contacts"]), second(CASES[k], SLUGS[k], found["contacts"])]
    return made + ([far(CASES[k], SLUGS[k], found["distance"])] if SLUGS[k] == "1e4" else [])


def curve(table):
    """(distances, correlations, errors, shares of opposite senses, errors, pairs)."""
    block, distance = table.column("block"), table.column("distance")
    columns = np.stack([table.column(name) for name in ("pairs", "product", "sure", "opposite")])
    out = []
    for value in np.unique(distance):
        groups = [columns[:, (distance == value) & (block == one)].sum(axis=1) for one in np.unique(block)]
        total = np.sum(groups, axis=0)
        if total[0] < 2:
            continue
        opposite = jackknife(lambda g: ratio(np.sum(g, axis=0), 3, 2), groups)
        out.append((value, *jackknife(lambda g: ratio(np.sum(g, axis=0), 1, 0), groups), *opposite, total[0] / 2))
    return np.array(out).T


def ratio(total, above, below):
    return float(total[above] / total[below]) if total[below] else np.nan


def at(steps, value):
    k = int(np.flatnonzero(steps[0] == value)[0])
    return steps[1][k], steps[2][k], steps[3][k], steps[4][k]


def gears(words, slug, steps):
    value, error, opposite, its = at(steps, 1)
    verdict = OPEN if not its > 0 else YES if opposite - SURE * its > 0.5 else NO if opposite + its < 0.5 else OPEN
    return Claim(f"{words}: disks in contact turn against each other, like gears.", verdict,
                 f"correlation of disks in contact {number(value, error)}, {number(100 * opposite, 100 * its)} % of "
                 "them turn in opposite senses (of those that turn for sure)", kind="own check",
                 slug=f"gears-contact-{slug}")


def second(words, slug, steps):
    value, error, opposite, its = at(steps, 2)
    verdict = OPEN if not its > 0 else YES if opposite + SURE * its < 0.5 else NO if opposite - its > 0.5 else OPEN
    return Claim(f"{words}: disks with one disk between them turn alike, as in a train of gears.", verdict,
                 f"correlation over two contacts {number(value, error)}, {number(100 * opposite, 100 * its)} % in "
                 "opposite senses", kind="own check", slug=f"gears-second-{slug}")


def far(words, slug, distance):
    some = distance[0] >= 4
    return zero(f"{words}: beyond 4 diameters there is no correlation.", distance[1][some], distance[2][some],
                what="correlation", kind="own check", slug=f"gears-far-{slug}")


def curves_figure(curves):
    picture, axes = figure(columns=2, rows=2, width=7.2, height=6.0, legend=True, sharex="col", sharey=True)
    for row, (word, some) in zip(axes, curves.items()):
        for k, found in some.items():
            plain = CASES[k].replace("<i>", "$").replace("</i>", "$")
            for panel, kind in zip(row, ("distance", "contacts")):
                near = found[kind][0] <= (8 if kind == "distance" else DEEP)
                points(panel, found[kind][0][near] + 0.04 * (k - 1.5), found[kind][1][near], found[kind][2][near], plain, k,
                       "os^D"[k])
        for panel in row:
            zero_line(panel)
        row[0].set_ylabel(f"{word} drive\n" + r"$\langle\Omega_i\Omega_j\rangle/\langle\Omega^2\rangle$")
    for panel, label in zip(axes[-1], (r"distance/mean diameter", "contacts between the disks")):
        panel.set_xlabel(label)
    legend_below(picture, axes[0], 4, fontsize=9)
    return Figure("space", picture,
                  "Correlation of the mean angular velocities of two disks with their distance (left; bins of half a "
                  "diameter) and with the number of contacts between them (right), harmonic drive above, random drive below.",
                  "Correlation of mean angular velocities against distance")
