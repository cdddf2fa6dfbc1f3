"""Jumps of Omega_i: where the mean angular velocity of a disk changes, and whether its cage changes then."""
import numpy as np

from ratchet.data import Table
from ratchet.page import Figure, Numbers, Section
from ratchet.style import COLOURS, GREY, figure
from ratchet.verdict import MOTIONS, NO, OPEN, YES, Claim, beside, missing, number

from .memory import DRIVES, LONGER, VARIANTS, histories, measured, replica_of
from .statistics import jackknife

WIDTH = 0.45     # s: Omega is taken over blocks of this length, or from frame to frame where these are further apart
SHORTEST = 4     # blocks on each side of a jump
SURE = 6.0       # errors
LEAST = 0.05     # of the rms of Omega of the packing: smaller jumps do not count
MOVE = 1e-5      # mean diameters: smaller displacements do not count; a tenth of the overlap that a disk's weight makes
LOOKS = 5        # tables of contacts in a block from which on shares of the time are told
SWITCH = 0.5     # a contact is closed for this much more or less of the time than before
WITHIN = 2       # blocks: as near in time counts as together
ENOUGH, SEVERAL = 10, 3  # jumps and packings without which nothing can be told


def sections(campaign):
    return [section(campaign)]


# --- change points --------------------------------------------------------------------------------------------------
def changes(values, least, sure=SURE, shortest=SHORTEST):
    """Places where the mean of the values changes by at least `least` and by more than so many errors, first those that
    are clearest, then the parts on both sides (binary segmentation). Values from a place on belong to what is after
    it."""
    values = np.asarray(values, float)
    found, floor = [], 1e-12 * float(np.abs(values).max() or 1)

    def look(first, last):
        count = last - first
        if count < 2 * shortest:
            return
        part = values[first:last]
        total, square = np.cumsum(part), np.cumsum(part ** 2)
        k = np.arange(shortest, count - shortest + 1)
        before, after = total[k - 1] / k, (total[-1] - total[k - 1]) / (count - k)
        within = np.maximum(square[-1] - k * before ** 2 - (count - k) * after ** 2, 0) / (count - 2)
        spread = np.maximum(np.sqrt(within), floor)
        score = np.abs(after - before) / (spread * np.sqrt(1 / k + 1 / (count - k)))
        best = int(np.argmax(score))
        if score[best] > sure and abs(after[best] - before[best]) >= least:
            place = first + int(k[best])
            look(first, place)
            found.append(place)
            look(place, last)

    look(0, len(values))
    return found


def switches(closed, shortest=SHORTEST, least=SWITCH):
    """Places where the share of the time for which a contact is closed changes by at least `least` within a few
    blocks."""
    total = np.concatenate([[0], np.cumsum(closed)])
    k = np.arange(shortest, len(closed) - shortest + 1)
    if not len(k):
        return []
    step = np.abs(total[k + shortest] + total[k - shortest] - 2 * total[k]) / shortest
    found = []
    while step.size and step.max() >= least:
        best = int(np.argmax(step))
        found.append(int(k[best]))
        step[max(0, best - shortest):best + shortest + 1] = 0
    return sorted(found)


def near(places, count, within=WITHIN):
    """Whether each block is within so many blocks of one of the places."""
    out = np.zeros(count, bool)
    for place in places:
        out[max(0, place - within):place + within + 1] = True
    return out


# --- a run --------------------------------------------------------------------------------------------------------
class Record:
    """Angular velocities, places and contacts of the disks of a run in blocks of time."""

    def __init__(self, run):
        frames = run.result.frames
        time = frames.time
        step = np.median(np.diff(time))
        first = int(np.searchsorted(time, run.steps * run.dt - run.measured - step / 2))
        frame = max(1, round(WIDTH / step))
        time, count = time[first:], (len(time) - first - 1) // frame
        angle = frames["angle"][first:first + count * frame + 1, :run.n_free]
        place = frames["position"][first:first + count * frame, :run.n_free] / (2 * run.radius.mean())
        self.width = frame * step
        self.start, self.count = time[0], count
        self.omega = np.diff(angle[::frame], axis=0).T / self.width
        self.place = place.reshape(count, frame, run.n_free, 2).mean(axis=1).transpose(1, 2, 0)
        self._read_contacts(run)

    def _read_contacts(self, run):
        """{(a, b): share of the time for which it is closed, in each block}."""
        tables = run.result.contacts
        block = ((tables.time - self.start) / self.width).astype(int)
        row = np.repeat(np.arange(len(tables)), tables.count)
        a, b = tables["a"].astype(np.int64), tables["b"].astype(np.int64)
        good = (tables.time[row] >= self.start) & (block[row] < self.count) & (block[row] >= 0)
        pairs, which = np.unique((a << 32 | b)[good], return_inverse=True)
        looks = np.bincount(block[(tables.time >= self.start) & (block < self.count)], minlength=self.count)
        seen = np.bincount(which * self.count + block[row][good], minlength=len(pairs) * self.count)
        closed = seen.reshape(len(pairs), self.count) / np.maximum(looks, 1)
        self.looks = float(looks.mean())
        self.closed = {(int(p >> 32), int(p & 0xffffffff)): share for p, share in zip(pairs, closed)}

    def rearrangements(self):
        """For each disk the blocks near which its cage changes: it moves, or a contact of it comes or goes, or a disk
        that it touches moves."""
        n, own = len(self.omega), []
        for i in range(n):
            moved = [k for axis in self.place[i] for k in changes(axis, MOVE)]
            own.append(moved)
        cage = [list(moved) for moved in own]
        for (a, b), share in self.closed.items():
            switched = switches(share) if self.looks >= LOOKS else []
            for one, other in ((a, b), (b, a)):
                if one < n:
                    cage[one] += switched
                    if other < n and share.mean() > SWITCH:
                        cage[one] += own[other]
        return cage


def runs(campaign):
    """[(drive, packing and history, run)] with frames and tables of contacts; packings of LONGER are those of
    cage_start.cfg."""
    found = []
    for name, drive in DRIVES.items():
        found += [({"drive": drive, "packing": packing, "variant": VARIANTS.index(variant)}, run)
                  for (packing, variant), run in sorted(histories(campaign, name).items())]
    for name, drive in LONGER.items():
        found += [({"drive": drive, "packing": replica_of(run), "variant": len(VARIANTS)}, run)
                  for run in measured(campaign, name)]
    return [(key, run) for key,
            run in found if len(run.result.frames) > SHORTEST and len(run.result.contacts) > SHORTEST]


class Found:
    """Rows of all jumps, rows of all disks, and the traces of the clearest jump, of all runs."""

    def __init__(self, campaign):
        self.jumps, self.disks, self.trace, best = [], [], None, 0.0
        for key, run in runs(campaign):
            record = Record(run)
            if record.count < 3 * SHORTEST:
                continue
            jumps, disks = of_record(record, run.rms)
            self.jumps += [{**key, **row} for row in jumps]
            self.disks += [{**key, **row} for row in disks]
            shown = 1.0 if record.looks >= LOOKS else 1e-3  # where contacts are known as means
            clear = [row for row in jumps if row["together"] and shown * row["size"] > best]
            if clear:
                row = max(clear, key=lambda row: row["size"])
                best, self.trace = shown * row["size"], trace(record, int(row["disk"]), key)

    def columns(self, rows):
        return {key: [row[key] for row in rows] for key in rows[0]} if rows else None


def of_record(record, rms):
    """(a row for each jump, a row for each disk) of a run."""
    jumps, disks, rng = [], [], np.random.default_rng(1)
    for i, (omega, cage) in enumerate(zip(record.omega, record.rearrangements())):
        known, places = near(cage, record.count), changes(omega, LEAST * rms)
        covered = float(known[SHORTEST:record.count - SHORTEST + 1].mean())
        for k in places:
            size = abs(omega[k:k + SHORTEST].mean() - omega[k - SHORTEST:k].mean()) / rms
            jumps.append({"disk": i, "time": record.start + k * record.width, "size": size,
                          "together": float(known[k]), "covered": covered})
        events, turned = merged(cage), near(places, record.count)
        disks.append({"disk": i, "time": record.count * record.width, "jumps": len(places), "covered": covered,
                      "shuffled": len(changes(rng.permutation(omega), LEAST * rms)), "events": len(events),
                      "turned": int(sum(turned[min(k, record.count - 1)] for k in events))})
    return jumps, disks


def merged(places):
    """Places without those that follow another within a few blocks."""
    out = []
    for place in sorted(places):
        if not out or place - out[-1] > WITHIN:
            out.append(place)
    return out


def trace(record, i, key):
    """What is drawn of one disk: Omega, distance from its first place, contacts, in blocks."""
    place = record.place[i] - record.place[i][:, :1]
    count = sum((share for pair, share in record.closed.items() if i in pair), np.zeros(record.count))
    columns = {"time": record.start + (np.arange(record.count) + 0.5) * record.width, "omega": record.omega[i],
               "moved": np.hypot(*place), "contacts": count}
    return {**{name: np.full(record.count, value) for name, value in {**key, "disk": i}.items()}, **columns}


# --- the section --------------------------------------------------------------------------------------------------
def section(campaign):
    found = []  # read once, and only when a table asks for it

    def read():
        if not found:
            found.append(Found(campaign))
        return found[0]

    disks = campaign.numbers("jumps_disks", lambda: read().columns(read().disks), digits=5,
                             title="jumps and rearrangements of each disk; variant: number of the history")
    jumps = campaign.numbers("jumps", lambda: read().columns(read().jumps), digits=5,
                             title="jumps of mean angular velocities; sizes over the rms of the packing")
    traced = campaign.numbers("jumps_trace", lambda: read().trace, digits=5,
                              title="a disk with a jump, means over blocks: rad/s, mean diameters")
    out = Section("jumps", "Jumps of &Omega;<sub>i</sub> at rearrangements",
                  "All runs of <code>inputs/packing/cage_memory.cfg</code>, and the long ones of "
                  "<code>shake_low.cfg</code> and <code>shake_moderate.cfg</code>. Angles of each disk, taken at "
                  f"the same phase of the floor, give its mean angular velocity in blocks of {WIDTH:g} s, of the "
                  f"long runs from frame to frame. A jump: the mean changes by more than {SURE:g} errors and "
                  f"{LEAST:g} of the packing's rms (binary segmentation; errors from the scatter on both sides). A "
                  "rearrangement of its cage: it or a disk that it touches moves lastingly by more than "
                  "10<sup>&minus;5</sup> diameters, a tenth of the overlap that its weight makes, or a contact of "
                  f"it is closed for {SWITCH:g} of the time more or less than before. Together: within {WITHIN} "
                  "blocks. By chance: the share of the time that is so near a rearrangement of the disk's cage. "
                  "Errors: leaving out one packing at a time.", missing=campaign.missing(*DRIVES))
    if not disks:
        out.claims.append(missing("&Omega; of a disk jumps when its cage rearranges.", slug="jumps-at-rearrangements"))
        return out
    made = {motion: [judge(drive, of_motion(motion, disks, drive), of_motion(motion, jumps, drive))
                     for drive in DRIVES.values() if len(of_motion(motion, disks, drive))] for motion in MOTIONS}
    out.claims += beside(*([claim for claim, _ in some] for some in made.values()))
    rows = [[motion, *row] for motion, some in made.items() for _, row in some]
    if traced:
        out.figures.append(trace_figure(traced, jumps))
    out.tables.append(Numbers("Jumps and rearrangements", [
        "motion", "drive/<i>g</i>", "runs", "time of disks (10<sup>3</sup> s)", "jumps", "in shuffled blocks",
        "per disk and 100 s",
        "with a rearrangement", "by chance", "rearrangements of cages", "with a jump"], rows, shown=True))
    return out


def of_motion(motion, table, drive):
    """The rows at one drive whose history is one of this motion."""
    random = {float(k) for k, variant in enumerate(VARIANTS) if variant.startswith("noise")}
    return Table([row for row in table.where(drive=drive).rows if (row["variant"] in random) == (motion != MOTIONS[0])])


def run_of(table):
    """A number for the run of each row."""
    return table.column("packing") * 100 + table.column("variant")


def judge(drive, disks, jumps):
    runs = run_of(disks)
    hit, covered = jumps.column("together"), jumps.column("covered")
    packing = jumps.column("packing")  # histories of a packing have the same rearrangements
    groups = [np.column_stack([hit, covered])[packing == one] for one in np.unique(packing)]
    mean = [jackknife(lambda g, k=k: float(np.vstack(g)[:, k].mean()), groups) if groups else (np.nan, np.nan)
            for k in range(2)]
    excess = jackknife(lambda g: float(np.diff(np.vstack(g).mean(axis=0))[0]), groups) if groups else (np.nan, np.nan)
    time = float(disks.column("time").sum())
    false, events = disks.column("shuffled").sum(), disks.column("events").sum()
    turned = disks.column("turned").sum() / events if events else np.nan
    verdict = OPEN
    if len(hit) >= ENOUGH and len(groups) >= SEVERAL and excess[1] > 0:
        more, half = -excess[0], mean[0][0] - 0.5
        verdict = (YES if more > 3 * excess[1] and half > mean[0][1] else
                   NO if more < excess[1] or half < -2 * mean[0][1] else OPEN)
    count = len(np.unique(disks.column("packing")))
    found = (f"{len(hit)} jumps in {len(np.unique(runs))} runs of {count} packings, {number(1e2 * len(hit) / time)} "
             f"per disk and 100 s (blocks in random order have {int(false)}); "
             f"{number(100 * mean[0][0], 100 * mean[0][1])} % come with a rearrangement of the cage, "
             f"{number(100 * mean[1][0], 100 * mean[1][1])} % would by chance; of {int(events)} rearrangements "
             f"{number(100 * turned)} % come with a jump")
    claim = Claim(f"At {drive:g} <i>g</i> &Omega; of a disk jumps when its cage rearranges: most of its jumps do.",
                  verdict,
                  found, kind="own check", slug=f"jumps-at-rearrangements-{drive:g}g")
    return claim, [drive, len(np.unique(runs)), time / 1e3, len(hit), int(false), 1e2 * len(hit) / time,
                   number(*mean[0]), number(*mean[1]), int(events), turned]


def trace_figure(traced, jumps):
    """Omega of a disk, its displacement and its contacts against time, with the jumps that are found."""
    picture, axes = figure(rows=3, width=6.4, height=4.4, sharex=True)
    first = traced.rows[0]
    own = jumps.where(**{name: first[name] for name in ("drive", "packing", "variant", "disk")})
    time = traced.column("time")
    for panel, name, label, colour in zip(axes, ("omega", "moved", "contacts"), (
            r"$\Omega_i$ (rad/s)", "displacement\n(mean diameters)", "contacts"), COLOURS):
        panel.plot(time, traced.column(name), color=colour, lw=1.0, drawstyle="steps-mid")
        panel.set_ylabel(label, fontsize=10)
        for moment, together in zip(own.column("time"), own.column("together")):
            panel.axvline(moment, color=GREY, lw=0.8, ls="-" if together else ":", gid="guide")
    axes[-1].set_xlabel("time (s)")
    return Figure("jumps", picture,
                  f"A disk at {first['drive']:g} <i>g</i>: its angular velocity, its displacement since measuring "
                  "began, and the number of its contacts, means over blocks. Vertical lines: jumps of &Omega;, full "
                  "where its cage rearranges, dotted where it does not.",
                  "Angular velocity, displacement and contacts of a disk against time")
