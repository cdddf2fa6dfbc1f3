"""Omega of a disk against its cage: what the contacts and the theory of three disks predict of it."""
import numpy as np

from ratchet.page import Figure, Numbers, Section
from ratchet.style import COLOURS, GREY, LIGHT, figure, legend_below, zero_line
from ratchet.verdict import MOTIONS, NO, OPEN, YES, Claim, beside, missing, number

from . import contacts
from .memory import BLOCK, DRIVES, at_random, shaken
from .statistics import jackknife, pearson, spearman

# name in the table: words
PREDICTIONS = {
    "all": "mean torque over all combinations of sliding, all contacts",
    "network": "the same, neighbours turn too",
    "measured": "measured covariance of sliding and force",
    "meshed": "the same, neighbours turn too",
    "gears": "nothing but neighbours: a gear between those that it touches",
}
ODD = (*(f"force_{m}" for m in range(1, 5)), *(f"contact_{m}" for m in range(1, 5)), "tilt", "tilt_load", "sizes",
       "lopsided")
EVEN = ("contacts", "aperture", "radius", "load_weight", "depth")
MANY = 500      # tables of contacts without which the covariance is not told
HALF = 0.5      # share of the variance that counts as predicted
SHUFFLES = 999
RNG = 20200710  # seed of the shuffles


def sections(campaign):
    return [section(campaign)]


# --- numbers of each disk -------------------------------------------------------------------------------------------
def numbers(campaign):
    """A row for each disk of each packing and drive, harmonic or random: Omega, what is predicted, and its cage."""
    found = [(0, *one) for one in shaken(campaign)] + [(1, *one) for one in at_random(campaign)]
    rows = [{"random": np.full(run.n_free, random), "drive": np.full(run.n_free, drive),
             "packing": np.full(run.n_free, packing), "disk": run.id, "omega": run.omega, "error": run.error,
             **of_run(run)} for random, drive, packing, run in found]
    return {key: np.concatenate([row[key] for row in rows]) for key in rows[0]} if rows else None


def of_run(run):
    """{column: a value per disk}: predictions, up to one factor for all disks of a column, and descriptors."""
    cage = contacts.Cage(run)
    out = {name: np.full(run.n_free, np.nan) for name in ("all", *ODD, *EVEN)}
    rectified = np.full(run.n_free, np.nan)
    for i in range(run.n_free):
        mine = cage.of(i)
        if len(mine) < 2:
            continue
        angle, force, closed = cage.angle[mine], cage.force[mine], cage.closed[mine]
        rectified[i] = cage.rectified[mine].sum()
        scale = force.sum() * run.radius[i]
        two = contacts.supports(angle, force)
        if two is not None:
            for name, value in supported(angle[two], force[two]).items():
                out[name][i] = value
        strong = np.argsort(force)[-contacts.MANY:]
        out["all"][i] = contacts.rectified_torque(angle[strong], force[strong], closed[strong]) / scale
        for name, value in descriptors(angle, force, closed, sizes(run, cage.other[mine]), two).items():
            out[name][i] = value
        out["load_weight"][i] = np.log(force.sum() / cage.weight[i])
    diameter = 2 * run.radius.mean()
    out["radius"], out["depth"] = run.radius / run.radius.mean(), (run.y.max() - run.y) / diameter
    total = np.bincount(cage.disk, cage.force, run.n_free)
    out["network"] = contacts.response(cage, out["all"] * total * run.radius)
    if len(run.result.contacts) < MANY:
        rectified[:] = np.nan
    out["measured"], out["meshed"] = contacts.response(cage, rectified, own=True), contacts.response(cage, rectified)
    out["gears"] = contacts.meshed(cage, run.omega)
    drag = np.pi / 2 * contacts.sliding_speed(run, cage)
    return {name: values * drag if name in PREDICTIONS and name != "gears" else values for name, values in out.items()}


def supported(angle, force):
    """Tilt and half aperture of two supports, left one first; tilt_load: from the direction of the load they carry."""
    tilt, aperture = contacts.geometry(angle)
    load = np.array([np.cos(angle), np.sin(angle)]) @ force
    return {"tilt": tilt, "aperture": aperture, "tilt_load": tilt - (np.arctan2(load[1], load[0]) + np.pi / 2)}


def sizes(run, others):
    """Radii of what a disk touches, 0 for walls."""
    return np.where(others < run.n_free, run.radius[np.minimum(others, run.n_free - 1)], 0.0) / run.radius.mean()


def descriptors(angle, force, closed, size, two):
    """Moments of the cage: odd ones change their sign in the mirror. Angles count from straight below."""
    psi = angle + np.pi / 2
    out = {f"force_{m}": np.sum(force * np.sin(m * psi)) / force.sum() for m in range(1, 5)}
    out.update((f"contact_{m}", np.sum(closed * np.sin(m * psi)) / closed.sum()) for m in range(1, 5))
    out["sizes"] = np.sum(closed * size * np.sin(psi)) / closed.sum()
    out["lopsided"] = 0.0 if two is None else (force[two[1]] - force[two[0]]) / force[two].sum()
    out["contacts"] = closed.sum()
    return out


# --- statistics ---------------------------------------------------------------------------------------------------
def shuffled(values, groups, rng):
    """The values in random order within each group."""
    out = np.array(values, float)
    for one in np.unique(groups):
        here = np.flatnonzero(groups == one)
        out[here] = out[rng.permutation(here)]
    return out


def chance(statistic, values, groups, count=SHUFFLES):
    """Share of shuffles of the values within their groups that give at least this |statistic|."""
    rng, found = np.random.default_rng(RNG), abs(statistic(values))
    return (1 + sum(abs(statistic(shuffled(values, groups, rng))) >= found for _ in range(count))) / (count + 1)


def scaled(values, groups):
    """Values over the rms of their group; what is not known counts as 0."""
    out = np.nan_to_num(np.asarray(values, float))
    for one in np.unique(groups):
        here = groups == one
        rms = np.sqrt(np.mean(out[here] ** 2))
        out[here] /= rms if rms > 0 else 1
    return out


PARTS = 5  # of the packings, left out one at a time


def kernels(odd, even):
    """Kernels for functions that change their sign in the mirror: linear in the odd descriptors, and Gaussian ones
    of all with several widths."""
    odd = odd / np.maximum(np.sqrt(np.mean(odd ** 2, axis=0)), 1e-300)
    even = (even - even.mean(axis=0)) / np.maximum(even.std(axis=0), 1e-300)
    found = {"linear": odd @ odd.T / odd.shape[1]}
    apart = ((even[:, None] - even[None]) ** 2).sum(2)
    for width in (0.5, 1, 2):
        scale = 2 * width ** 2 * (odd.shape[1] + even.shape[1])
        same, mirrored = (np.exp(-(((odd[:, None] - sign * odd[None]) ** 2).sum(2) + apart) / scale)
                          for sign in (1, -1))
        found[f"width {width}"] = same - mirrored
    return found


def left_out(kernel, values, groups, ridge):
    """Predictions of the values (columns are cases of their own) of each group from the others: kernel ridge
    regression."""
    out = np.empty_like(values)
    for one in np.unique(groups):
        test = groups == one
        inner = kernel[np.ix_(~test, ~test)]
        weight = np.linalg.solve(inner + ridge * np.eye(len(inner)), values[~test])
        out[test] = kernel[np.ix_(test, ~test)] @ weight
    return out


def explained(values, predicted):
    """Share of the variance about zero; below 0 for predictions that are worse than none."""
    return float(1 - np.sum((values - predicted) ** 2) / np.sum(values ** 2))


def regression(odd, even, values, groups, choices):
    """Predictions of each part of the groups by the kernel and ridge that do best among the other parts."""
    found, groups = kernels(odd, even), np.unique(groups, return_inverse=True)[1] % PARTS
    picked = [(found[name], ridge) for name in found if name.startswith(choices) for ridge in (0.03, 0.3, 3, 30)]
    out = np.empty_like(values)
    for one in np.unique(groups):
        rest = groups != one
        score = [explained(values[rest], left_out(k[np.ix_(rest, rest)], values[rest], groups[rest], ridge))
                 for k, ridge in picked]
        kernel, ridge = picked[int(np.argmax(score))]
        weight = np.linalg.solve(kernel[np.ix_(rest, rest)] + ridge * np.eye(rest.sum()), values[rest])
        out[~rest] = kernel[np.ix_(~rest, rest)] @ weight
    return out


# --- the section --------------------------------------------------------------------------------------------------
def section(campaign):
    table = campaign.numbers("cages", lambda: numbers(campaign), digits=5,
                             title="mean angular velocity (rad/s), predictions (rad/s) and the cage of each disk")
    out = Section("cages", "&Omega;<sub>i</sub> and its cage",
                  "For each disk the mean places of it and its neighbours, the mean normal force of each contact and "
                  "the share of the time for which it is closed, from tables of contacts at all phases of the floor "
                  "(<code>inputs/packing/cage_memory.cfg</code>). The experiment with "
                  "neighbours that do not turn stands <a href=\"#alone\">above</a>. Equation (19) of three disks, the mean torque of two supports over all "
                  "combinations of sliding, is no test here: its sign depends on the excitation. "
                  "Drag: contacts slide to and fro with a mean speed <i>v</i>, the power of friction over &mu; times "
                  "the normal forces, so that a mean velocity <i>V</i> of the surfaces shifts the mean sign of "
                  "sliding by 2<i>V</i>/&pi;<i>v</i>. The "
                  "covariance of sliding and normal force is that torque as it is in the run: it tells whether the "
                  "mechanism is the right one where the theory is not. Chances: shuffles of &Omega; among the disks "
                  "of a packing. Errors: leaving out ten neighbouring disks at a time.",
                  missing=campaign.missing(*DRIVES))
    if not table:
        out.claims.append(missing("The cage of a disk predicts its &Omega;.", kind="paper", slug="cage-predicts"))
        return out
    sets = {motion: parts_of(table.where(random=float(k))) for k, motion in enumerate(MOTIONS)}
    judges = (predicts, mechanism, gear)
    out.claims += beside(*([judge(drive, part) for drive, part in parts.items() for judge in judges]
                           for parts in sets.values()))
    if sets[MOTIONS[0]]:
        out.figures += [scatter_figure(sets[MOTIONS[0]]), summary_figure(sets)]
    out.tables.append(Numbers("Predictions of &Omega;<sub>i</sub>", [
        "motion", "drive/<i>g</i>", "from", "disks", "Pearson", "Spearman", "right sense of those beyond 3 errors",
        "measured over predicted"],
        [[motion, *row] for motion, parts in sets.items() for drive, part in parts.items() for row in part.rows(drive)]))
    return out


def parts_of(table):
    """{drive: disks} of the drives that the table has."""
    found = {drive: table.where(drive=drive) for drive in DRIVES.values()}
    return {drive: Part(some) for drive, some in found.items() if len(some)}


class Part:
    """Disks of one drive: Omega over the rms of the packing, predictions likewise."""

    def __init__(self, table):
        self.table, self.group = table, table.column("packing") + 1e3 * table.column("drive")
        self.block = self.group * 1e3 + table.column("disk") // BLOCK  # left out one at a time, for errors
        self.omega = scaled(table.column("omega"), self.group)
        self.sure = np.abs(table.column("omega")) > 3 * table.column("error")
        self.known = {name: np.isfinite(table.column(name)) for name in PREDICTIONS}
        self.predicted = {name: scaled(table.column(name), self.group) for name in PREDICTIONS}
        odd, even = (np.nan_to_num(np.column_stack([table.column(name) for name in names])) for names in (ODD, EVEN))
        self.fitted = {}
        if len(np.unique(self.group)) > 2:
            self.fitted = {"linear": regression(odd, even, self.omega, self.group, "linear"),
                           "cage": regression(odd, even, self.omega, self.group, ("linear", "width"))}
        self.both = self.predicted | self.fitted

    def jackknife(self, function, known, *columns):
        """A function of these columns and its error, of disks of which all is known."""
        if not known.any():
            return np.nan, np.nan
        values = np.column_stack(columns)
        return jackknife(lambda kept: function(*np.vstack(kept).T),
                         [values[known & (self.block == one)] for one in np.unique(self.block[known])])

    def told(self, name):
        """Disks of packings of which there are predictions."""
        return np.isin(self.group, np.unique(self.group[self.both[name] != 0]))

    def correlation(self, name, function=pearson):
        return self.jackknife(function, self.told(name), self.omega, self.both[name])

    def slope(self, name):
        """Measured over predicted, by least squares, with its error."""
        values = (np.nan_to_num(self.table.column(column)) for column in ("omega", name))
        return self.jackknife(lambda a, b: float(a @ b / (b @ b)) if b.any() else np.nan, self.told(name), *values)

    def chance(self, name):
        return chance(lambda omega: pearson(omega, self.both[name]), self.omega, self.group)

    def sense(self, name):
        """(share of the disks that turn for sure and are predicted whose sense is right, its error, their number)."""
        good = self.sure & self.known.get(name, True) & (self.both[name] != 0)
        right = np.sign(self.omega) == np.sign(self.both[name])
        return (*self.jackknife(lambda hit: float(np.mean(hit)), good, right.astype(float)), int(good.sum()))

    def r2(self, name):
        return self.jackknife(explained, self.told(name), self.omega, self.fitted[name])

    def rows(self, drive):
        words = PREDICTIONS | {"linear": "regression, linear", "cage": "regression, Gaussian kernel"}
        return [[drive, words[name], len(self.omega), number(*self.correlation(name)),
                 number(*self.correlation(name, spearman)), number(*self.sense(name)[:2]),
                 number(*self.slope(name)) if name in PREDICTIONS else ""]
                for name in (*PREDICTIONS, *self.fitted)]


def predicts(drive, part):
    text = (f"At {drive:g} <i>g</i> the contacts of a disk (angles, mean forces, number) predict its &Omega;: more "
            "than half of the variance in packings that the regression has not seen.")
    slug = f"cage-predicts-{drive:g}g"
    if "cage" not in part.fitted:
        return missing(text, kind="paper", slug=slug, why="fewer than three packings")
    value, error = part.r2("cage")
    verdict = YES if value - error >= HALF else NO if value + 2 * error < HALF else OPEN
    found = (f"share of the variance {number(value, error)}, linear regression {number(*part.r2('linear'))}; "
             f"correlation {number(*part.correlation('cage'))}, a chance of {100 * part.chance('cage'):.2g} %; right "
             f"sense for {percent_of(part.sense('cage'))}; {len(np.unique(part.group))} packings, {len(ODD)} odd and "
             f"{len(EVEN)} even descriptors")
    return Claim(text, verdict, found, kind="paper", slug=slug)


def percent_of(found):
    value, error, count = found
    return f"{number(100 * value, 100 * error)} % of {count} disks"


def mechanism(drive, part):
    value, error = part.correlation("meshed")
    need = np.sqrt(HALF)
    verdict = YES if value - error >= need else NO if value + 2 * error < need else OPEN
    return Claim(f"At {drive:g} <i>g</i> the torque that the covariance of sliding and normal force makes, as "
                 "measured, explains half of the variance of &Omega;.", verdict,
                 f"with neighbours that turn too: correlation {number(value, error)}, Spearman "
                 f"{number(*part.correlation('meshed', spearman))}, right sense for "
                 f"{percent_of(part.sense('meshed'))}; measured over predicted {number(*part.slope('meshed'))}; as "
                 f"if neighbours did not turn correlation {number(*part.correlation('measured'))}", kind="own check",
                 slug=f"rectification-predicts-{drive:g}g")


def gear(drive, part):
    value, error = part.correlation("gears")
    slope, its = part.slope("gears")
    good = error > 0 and its > 0
    verdict = (OPEN if not good else YES if value > 3 * error and abs(slope - 1) < 3 * its else
               NO if value < 2 * error or abs(slope - 1) > 5 * its else OPEN)
    return Claim(f"At {drive:g} <i>g</i> a disk turns as a gear between the disks that it touches would, but for its "
                 "own torque: &Omega; follows theirs, with the slope one.", verdict,
                 "correlation of &Omega; with the mean of neighbours, weighted by forces and radii, "
                 f"{number(value, error)}, slope {number(slope, its)}, right sense for "
                 f"{percent_of(part.sense('gears'))}", kind="own check",
                 slug=f"gear-between-neighbours-{drive:g}g")


# --- figures --------------------------------------------------------------------------------------------------------
SHOWN = ("network", "meshed", "gears")
TITLES = {"network": "combinations of sliding", "meshed": "measured covariance", "gears": "gear of its neighbours"}
TICKS = (-3, -1, 0, 1, 3)


def scatter_figure(parts):
    picture, axes = figure(columns=len(SHOWN), rows=len(parts), width=7.2, height=2.3 * len(parts), legend=True,
                           squeeze=False, sharex=True, sharey=True)
    for row, (drive, part) in zip(axes, parts.items()):
        for panel, name in zip(row, SHOWN):
            values = part.both[name]
            known = values != 0
            for chosen, colour, label in ((~part.sure, LIGHT, "within 3 errors of zero"),
                                          (part.sure, COLOURS[0], "beyond 3 errors")):
                panel.plot(values[known & chosen], part.omega[known & chosen], "o", ms=2.2, mew=0, color=colour, label=label)
            panel.plot([-9, 9], [-9, 9], color=GREY, lw=0.7, zorder=1, gid="guide")
            for scale, limit in ((panel.set_xscale, panel.set_xlim), (panel.set_yscale, panel.set_ylim)):
                scale("symlog", linthresh=0.3, linscale=0.8)
                limit(-9, 9)
            panel.set_xticks(TICKS, [f"{v:g}" for v in TICKS])
            panel.set_yticks(TICKS, [f"{v:g}" for v in TICKS])
            panel.minorticks_off()
            zero_line(panel)
            panel.axvline(0, color=LIGHT, lw=0.8, zorder=0, gid="guide")
            title = f"{TITLES[name]}\n" if drive == min(parts) else ""
            panel.set_title(f"{title}{int(known.sum())} disks, $r$ = {part.correlation(name)[0]:.2f}", fontsize=8.5)
        row[0].set_ylabel(rf"{drive:g} $g$: measured $\Omega_i$/rms", fontsize=9)
    for panel in axes[-1]:
        panel.set_xlabel(r"predicted $\Omega_i$/rms", fontsize=9)
    legend_below(picture, list(axes.flat), 2, markerscale=2)
    return Figure("cages-scatter", picture,
                  "Mean angular velocity of each disk against what its contacts predict, harmonic drive; both over the rms "
                  "of the packing, linear up to 0.3 and logarithmic beyond; the line: equal. From the left: the mean torque "
                  "over all combinations of sliding with neighbours that turn; the torque of the measured covariance of "
                  "sliding and force; the mean of the neighbours, as for gears. Above each: number of disks, correlation.",
                  "Scatter plots of measured against predicted mean angular velocities")


def summary_figure(sets):
    picture, axes = figure(columns=2, width=7.4, height=3.6, legend=True, sharey=True)
    names = [*PREDICTIONS, "cage"]
    labels = ["combinations of sliding", "the same, neighbours turn", "measured covariance", "the same, neighbours turn",
              "gears", "regression"]
    for panel, (motion, parts) in zip(axes, sets.items()):
        for k, (drive, part) in enumerate(parts.items()):
            known = [(j, *part.correlation(name)) for j, name in enumerate(names) if name in part.both]
            place, value, error = np.array(known, float).T
            panel.errorbar(place + 0.15 * (k - 1), value, yerr=np.nan_to_num(error), fmt="os^D"[k % 4], color=COLOURS[k],
                           mfc="white", label=f"{drive:g} $g$")
        zero_line(panel)
        panel.axhline(np.sqrt(HALF), color=GREY, lw=0.8, ls=":", gid="guide")
        panel.set_xticks(range(len(names)), labels, fontsize=8, rotation=50, ha="right", rotation_mode="anchor")
        panel.xaxis.set_tick_params(which="minor", bottom=False, top=False)
        panel.set_title(f"{motion} drive", fontsize=10)
    axes[0].set_ylabel(r"correlation with $\Omega_i$")
    legend_below(picture, axes, 3)
    return Figure("cages-correlation", picture,
                  "Correlation of predictions with the measured mean angular velocities. Dotted: half of the "
                  "variance. Bars: single errors.",
                  "Correlation of predictions with measured mean angular velocities")
