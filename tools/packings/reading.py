"""One result of the program, read: what the figures need, in columns per free disk."""
import functools
import os

import numpy as np
from report.runs import slipdisk


def _parameters(path):
    """What a point of a sweep sets, from its name: {"drive": 0.5}; the number of the replica under "r"."""
    found = {}
    for word in os.path.basename(path)[:-len(".h5")].split(","):
        name, _, value = word.partition("=")
        if value:
            try:
                found[name] = float(value)
            except ValueError:
                found[name] = value
    return found


class Run:
    """Energies, cost and state of any run; means of disks where the deck asked for them (`has_means`)."""

    def __init__(self, path):
        self.path, self.parameters = path, _parameters(path)
        self.result = result = slipdisk.Result(path)
        self.dt, self.steps = result.dt, result.step
        self.nanoseconds = result.summary.step_nanoseconds
        self.measured = result.summary.measured * self.dt
        self.energy = result.energy
        run = result.provenance
        self.wall, self.step_seconds, self.threads, self.seed = run.wall_seconds, run.step_seconds, run.threads, run.seed
        self.phases = result.phases
        state = result.state
        sizes = result.attributes("state")
        self.n_free, self.n_disks = sizes.n_free, sizes.n_disks
        free = slice(0, self.n_free)
        self.id = state["id"][free]
        self.radius, self.mass = state["radius"][free], state["mass"][free]
        self.x_end, self.y_end = state["x"][free], state["y"][free]
        self.activity = state["activity"]
        totals = result.totals
        self.has_means = bool(totals) and totals.disks > 0
        if self.has_means:
            self._read_means(result.means, totals)

    def _read_means(self, means, totals):
        """Columns of /summary/disks (docs/results.md), and the totals of the packing."""
        order = np.argsort(means["id"])  # means are in the order of numbers, the state in that of slots
        means = means[order[np.searchsorted(means["id"][order], self.id)]]
        self.means = means
        self.omega, self.error = means["omega"], means["error"]
        self.first, self.second = means["omega_first"], means["omega_second"]
        self.x, self.y = means["x"], means["y"]  # mean places
        self.contacts = means["coordination"]
        diameter = 2 * float(self.radius.mean())
        self.wander = totals.position_rms        # rms distance from the mean places, over the mean diameter
        self.drift = totals.displacement_rms     # rms displacement since measuring began, likewise
        self.farthest = float(np.nanmax(means["rms"])) / diameter
        self.coordination, self.sliding_fraction = totals.coordination, totals.sliding
        self.openings, self.noise = totals.openings, totals.omega_noise

    # --- rotation ----------------------------------------------------------------------------------------
    def halves(self):
        """Mean angular velocities of the first and of the second half of the measured time."""
        return self.first, self.second

    def openings_per_period(self, frequency):
        """Contacts that open, per closed contact and period."""
        return self.openings / frequency

    @property
    def rms(self):
        return float(np.sqrt(np.mean(self.omega ** 2)))

    @property
    def median(self):
        return float(np.median(np.abs(self.omega)))

    @property
    def significant(self):
        """Fraction of the disks whose mean is more than three errors from zero."""
        return float(np.mean(np.abs(self.omega) > 3 * self.error))

    # --- contacts -----------------------------------------------------------------------------------------
    @functools.cached_property
    def _contacts(self):
        state, contacts = self.result.state, self.result.last_contacts
        number = state["id"]
        order = np.full(len(number), -1)
        order[number] = np.arange(len(order))
        return (order[contacts["a"]], order[contacts["b"]], contacts["force"], state["x"], state["y"], self.result.box)

    def neighbours(self):
        """(i, j, force) of closed contacts between free disks at the end; i and j count free disks."""
        a, b, force, *_ = self._contacts
        pair = (a < self.n_free) & (b < self.n_free)
        return a[pair], b[pair], force[pair]

    def neighbours_at(self, time):
        """(a, b) of the contacts between free disks in the last table until this time; empty without tables."""
        tables = self.result.contacts
        k = int(np.searchsorted(tables.time, time, side="right")) - 1
        if k < 0:
            return np.empty(0, int), np.empty(0, int)
        a, b = tables[k]["a"], tables[k]["b"]
        pair = (a < self.n_free) & (b < self.n_free)  # in these decks free disks come first
        return a[pair], b[pair]

    def contact_lines(self):
        """([n][2][2] end points, force) of the contacts between disks at the end, for drawing."""
        a, b, force, x, y, box = self._contacts
        pair = (a < self.n_disks) & (b < self.n_disks)
        a, b, force = a[pair], b[pair], force[pair]
        near = np.ones(len(a), bool)
        for values, edge in ((x, box[0]), (y, box[1])):
            if edge:
                near &= np.abs(values[a] - values[b]) < edge / 2
        ends = np.stack([np.column_stack([x[a], y[a]]), np.column_stack([x[b], y[b]])], axis=1)
        return ends[near], force[near]

    # --- walls and series -----------------------------------------------------------------------------------
    def walls(self):
        """(kind, points, radius) of the walls at the end: "round", "line" or "segment"."""
        frames = self.result.wall_frames
        if not len(frames):
            return []
        place, found, first = frames["position"], [], 0
        shape = {name: self.result.rows(f"particles/walls/shape/{name}") for name in ("kind", "count", "points", "radius")}
        for k, (kind, count) in enumerate(zip(shape["kind"], shape["count"])):
            own = shape["points"][first:first + count] + place[-1, k] - place[0, k]  # given as in the deck
            first += count
            found.append((WALL_KINDS.get(int(kind), "segment"), own if count else place[-1, k:k + 1],
                          float(shape["radius"][k])))
        return found

    def series(self, *names):
        """Time and these observables."""
        return [self.result.series[name] for name in ("time", *names)]

    def frames(self):
        """(times, positions [frame][disk][2]) of all disks, in the order of the deck."""
        frames = self.result.frames
        return frames.time, frames["position"]

    def velocities(self):
        """[n][2] of the free disks at the end."""
        state = self.result.state
        return np.column_stack([state["vx"][:self.n_free], state["vy"][:self.n_free]])

    def measured_residual(self):
        """What the budget of the measured time misses, over the work of driven bodies in it; nan where that is not
        what keeps the system going."""
        time, residual, work, *losses = self.series("residual", "work", "viscous", "friction", "opening")
        begin = int(np.searchsorted(time, time[-1] - self.measured * (1 + 1e-9)))
        done = abs(work[-1] - work[begin])
        lost = sum(loss[-1] - loss[begin] for loss in losses)
        return abs(residual[-1] - residual[begin]) / done if done > 0.3 * lost > 0 else np.nan

    @property
    def residual(self):
        """Energy that the budget misses, over the work done and lost."""
        return self.energy["residual"] / self.energy["scale"]


WALL_KINDS = {0: "line", 1: "segment", 2: "segment", 3: "round"}
