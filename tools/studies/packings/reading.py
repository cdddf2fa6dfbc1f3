"""Results of the program, read: what the figures need, in columns per free disk.

Of every run three tables are kept with the sources, so that a page is drawn without results: numbers of the run
(SCALARS), columns of its disks (DISKS), and its contacts at the end. A Run is made of their rows, with results and
without; series, frames and whatever else is read from a result goes through Campaign.numbers of the module that needs
it.
"""
import functools
import os

import numpy as np
from ratchet.kept import NotKept
from ratchet.runs import slipdisk



def _parameters(name):
    """What a point of a sweep sets, from its name: {"drive": 0.5}; the number of the replica under "r"."""
    found = {}
    for word in name.split(","):
        key, _, value = word.partition("=")
        if value:
            try:
                found[key] = float(value)
            except ValueError:
                found[key] = value
    return found


class Reading:
    """What is taken from one result."""

    def __init__(self, path):
        self.path, self.result = path, slipdisk.Result(path)
        sizes = self.result.attributes("state")
        self.n_free, self.n_disks = sizes.n_free, sizes.n_disks
        self.totals = self.result.totals
        self.has_means = bool(self.totals) and self.totals.disks > 0

    def scalars(self):
        result, run, energy = self.result, self.result.provenance, self.result.energy
        summary = result.summary
        box = result.box
        found = {"name": os.path.basename(self.path)[:-len(".h5")], "seed": run.seed, "dt": result.dt,
                 "steps": result.step, "measured": summary.measured * result.dt, "n_free": self.n_free,
                 "n_disks": self.n_disks, "box_x": box[0], "box_y": box[1],
                 "nanoseconds": summary.step_nanoseconds, "wall": run.wall_seconds, "step_seconds": run.step_seconds,
                 "threads": run.threads, "residual": energy["residual"] / energy["scale"] if energy["scale"]
                 else np.nan,
                 "measured_residual": self.measured_residual(), "has_means": self.has_means}
        if self.has_means:
            found.update({name: getattr(self.totals, key) for name, key in TOTALS.items()})
            found["noise"] = float(np.sqrt(np.mean(self.means["error"] ** 2)))
        return {**found, "version": run.version, "revision": run.revision}

    def measured_residual(self):
        """What the budget of the measured time misses, over the work of driven bodies in it; nan where that is not
        what keeps the system going."""
        series, measured = self.result.series, self.result.summary.measured * self.result.dt
        time, residual, work, *losses = [series[name] for name in ("time", "residual", "work", "viscous", "friction",
                                                                   "opening")]
        if not len(time):
            return np.nan
        begin = int(np.searchsorted(time, time[-1] - measured * (1 + 1e-9)))
        done = abs(work[-1] - work[begin])
        lost = sum(loss[-1] - loss[begin] for loss in losses)
        return abs(residual[-1] - residual[begin]) / done if done > 0.3 * lost > 0 else np.nan

    def disks(self):
        """Columns of all disks in the order of the state, the free ones first; means of the free ones alone."""
        state, n = self.result.state, self.n_disks
        found = {"id": state["id"][:n], "radius": state["radius"][:n], "x_end": state["x"][:n],
                 "y_end": state["y"][:n], "activity": state["activity"][:n]}
        if self.has_means:
            blank = np.full(n - self.n_free, np.nan)
            found.update({name: np.concatenate([self.means[key].astype(float), blank]) for name, key in MEANS.items()})
        return found

    @functools.cached_property
    def means(self):
        """/summary/disks (docs/results.md), in the order of the state."""
        means, number = self.result.means, self.result.state["id"][:self.n_free]
        order = np.argsort(means["id"])  # means are in the order of numbers, the state in that of slots
        found = means[order[np.searchsorted(means["id"][order], number)]]
        if tuple(map(int, self.result.provenance.version.split("."))) < ERRORS_SINCE:
            state = self.result.state
            count, length = int(state["mean_bins"]), float(state["mean_bin_steps"]) * self.result.dt
            for row, bins in zip(found, state["mean_bin"].reshape(self.n_free, -1)):
                mean = slipdisk.mean(bins[:count])
                row["omega"], row["error"] = mean.mean / length, mean.error / length
        return found

    def contacts(self):
        """Closed contacts between disks at the end, counted as in disks()."""
        state, contacts = self.result.state, self.result.last_contacts
        order = np.full(len(state["id"]), -1)
        order[state["id"]] = np.arange(len(order))
        a, b = order[contacts["a"]], order[contacts["b"]]
        pair = (a < self.n_disks) & (b < self.n_disks)
        return {"a": a[pair], "b": b[pair], "force": contacts["force"][pair]}

    def walls(self):
        """Points of the walls at the end: "round", "line" or "segment", one row each."""
        frames = self.result.wall_frames
        if not len(frames):
            return {}
        place, rows, first = frames["position"], [], 0
        shape = {name: self.result.rows(f"particles/walls/shape/{name}") for name in ("kind", "count", "points",
                                                                                      "radius")}
        for k, (kind, count) in enumerate(zip(shape["kind"], shape["count"])):
            own = shape["points"][first:first + count] + place[-1, k] - place[0, k]  # given as in the deck
            first += count
            for x, y in own if count else place[-1, k:k + 1]:
                rows.append((k, WALL_KINDS.get(int(kind), "segment"), x, y, float(shape["radius"][k])))
        return dict(zip(("wall", "kind", "x", "y", "radius"), zip(*rows)))


WALL_KINDS = {0: "line", 1: "segment", 2: "segment", 3: "round"}
# Of all disks together: wander and drift are rms distances from the mean places and from where measuring began, over
# the mean diameter.
TOTALS = {"wander": "position_rms", "drift": "displacement_rms", "coordination": "coordination",
          "sliding_fraction": "sliding", "openings": "openings", "noise": "omega_noise"}
MEANS = {"omega": "omega", "error": "error", "first": "omega_first", "second": "omega_second", "rms_place": "rms",
         "contacts": "coordination"}
DIGITS = {"x_end": 6, "y_end": 6, "radius": 6, "omega": 6, "first": 6, "second": 6, "error": 4, "rms_place": 4,
          "contacts": 5, "force": 5}


ERRORS_SINCE = (0, 4, 0)  # error bars of older results are taken anew from the bins that they hold
NO_CONTACTS = {"a": np.zeros(0, int), "b": np.zeros(0, int), "force": np.zeros(0)}


class Run:
    """Numbers of a run, its free disks, its contacts and walls at the end. Further columns are read from its file."""

    def __init__(self, row, disks=None, contacts=None, walls=None, path=""):
        """disks, contacts, walls: {column: array}, or None for what is not kept. path: of the result, "" without."""
        self.__dict__.update({key: np.nan if value == "" else value for key, value in row.items() if key != "name"})
        self.parameters, self.path = _parameters(row["name"]), path
        for name in ("n_free", "n_disks", "steps", "threads", "seed"):
            setattr(self, name, int(row[name]))
        self.has_means = bool(row["has_means"]) and (disks is not None or bool(path))
        self._kept = {"disks": disks, "contacts": contacts, "walls": walls}

    @functools.cached_property
    def reading(self):
        """The result itself, to read more: only where it is there."""
        if not self.path:
            raise NotKept(f"{self.parameters}: the result is not there, and this is not kept")
        return Reading(self.path)

    @property
    def result(self):
        return self.reading.result

    @property
    def means(self):
        return self.reading.means

    @property
    def x(self):
        """Mean places."""
        return self.means["x"]

    @property
    def y(self):
        return self.means["y"]

    def _table(self, name):
        if self._kept[name] is None:
            self._kept[name] = getattr(self.reading, name)()
        return self._kept[name]

    def __getattr__(self, name):
        """Columns of the free disks."""
        if name.startswith("_") or name not in DISKS:
            raise AttributeError(name)
        return self._table("disks")[name][:self.n_free]

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

    @property
    def farthest(self):
        """Of all disks the largest rms distance from the mean place, over the mean diameter."""
        return float(np.nanmax(self.rms_place)) / (2 * float(self.radius.mean()))

    # --- contacts -----------------------------------------------------------------------------------------
    def neighbours(self):
        """(i, j, force) of closed contacts between free disks at the end; i and j count free disks."""
        a, b, force = (self._table("contacts")[name] for name in ("a", "b", "force"))
        a, b = a.astype(int), b.astype(int)
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
        x, y = self._table("disks")["x_end"], self._table("disks")["y_end"]
        a, b, force = (self._table("contacts")[name] for name in ("a", "b", "force"))
        a, b = a.astype(int), b.astype(int)
        near = np.ones(len(a), bool)
        for values, edge in ((x, self.box_x), (y, self.box_y)):
            if edge:
                near &= np.abs(values[a] - values[b]) < edge / 2
        ends = np.stack([np.column_stack([x[a], y[a]]), np.column_stack([x[b], y[b]])], axis=1)
        return ends[near], force[near]

    # --- walls, and what is read from the result -----------------------------------------------------------------
    def walls(self):
        """(kind, points, radius) of the walls at the end: "round", "line" or "segment"."""
        table, found = self._table("walls"), []
        for k in dict.fromkeys(table.get("wall", ())):
            own = np.asarray(table["wall"]) == k
            first = int(np.argmax(own))
            points = np.column_stack([np.asarray(table["x"])[own], np.asarray(table["y"])[own]])
            found.append((table["kind"][first], points, float(table["radius"][first])))
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

    @functools.cached_property
    def mass(self):
        return self.result.state["mass"][:self.n_free]

    @property
    def phases(self):
        return self.result.phases


DISKS = {"id", "radius", "x_end", "y_end", "activity", *MEANS}
