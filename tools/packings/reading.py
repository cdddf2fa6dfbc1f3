"""One result of the program, read: what the figures need, in columns per free disk."""
import functools
import os

import h5py
import numpy as np


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
        with h5py.File(path, "r") as file:
            head = dict(file["summary"].attrs)
            self.dt, self.steps = float(head["dt"]), int(head["step"])
            self.nanoseconds = float(head["step_nanoseconds"])
            self.measured = float(head["measured"]) * self.dt
            self.energy = {key: float(value) for key, value in file["summary/energy"].attrs.items()}
            self.wall = float(file["parameters"].attrs["wall_seconds"])
            self.step_seconds = float(file["parameters"].attrs["step_seconds"])
            self.threads = int(file["parameters"].attrs["threads"])
            self.seed = int(file["parameters"].attrs["seed"])
            stage = file["summary/phase"]
            self.phases = [{name: stage[name][k] for name in ("steps", "most", "reached", "target_goal")}
                           for k in range(len(stage["steps"]))]
            state = file["state"]
            self.n_free, self.n_disks = int(state.attrs["n_free"]), int(state.attrs["n_disks"])
            free = slice(0, self.n_free)
            self.id = state["id"][free]
            self.radius, self.mass = state["radius"][free], state["mass"][free]
            self.x_end, self.y_end = state["x"][free], state["y"][free]
            self.activity = state["activity"][:]
            self.has_means = "disks" in file["summary"] and int(file["summary/disks"].attrs["disks"]) > 0
            if self.has_means:
                self._read_means(file["summary/disks"])

    def _read_means(self, means):
        """Columns of /summary/disks (docs/results.md), and the totals of the packing."""
        self.omega, self.error = means["omega"][:], means["error"][:]
        self.first, self.second = means["omega_first"][:], means["omega_second"][:]
        self.contacts = means["coordination"][:]
        diameter = 2 * float(self.radius.mean())
        totals = {key: float(value) for key, value in means.attrs.items() if np.isscalar(value)}
        self.wander = totals["position_rms"]        # rms distance from the mean places, over the mean diameter
        self.drift = totals["displacement_rms"]     # rms displacement since measuring began, likewise
        self.farthest = float(np.nanmax(means["rms"][:])) / diameter
        self.coordination, self.sliding_fraction = totals["coordination"], totals["sliding"]
        self.openings, self.noise = totals["openings"], totals["omega_noise"]

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
        with h5py.File(self.path, "r") as file:
            state, particles = file["state"], file["particles"]
            edges = particles["disks/box/edges"]
            edges = edges["value"][-1] if isinstance(edges, h5py.Group) else edges[:]  # a group when it was compressed
            periodic = [word in (b"periodic", "periodic") for word in particles["disks/box"].attrs["boundary"]]
            box = [edge if p else 0.0 for edge, p in zip(edges, periodic)]
            order = np.full(int(state.attrs["n_bodies"]), -1)
            order[state["id"][:]] = np.arange(len(order))
            return (order[state["contact_a"][:]], order[state["contact_b"][:]], state["contact_force"][:],
                    state["x"][:], state["y"][:], state["radius"][:], box)

    def neighbours(self):
        """(i, j, force) of closed contacts between free disks at the end; i and j count free disks."""
        a, b, force, *_ = self._contacts
        pair = (a < self.n_free) & (b < self.n_free)
        return a[pair], b[pair], force[pair]

    def contact_lines(self):
        """([n][2][2] end points, force) of the contacts between disks at the end, for drawing."""
        a, b, force, x, y, _, box = self._contacts
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
        with h5py.File(self.path, "r") as file:
            if "walls" not in file["particles"]:
                return []
            group = file["particles/walls"]
            shape, place = group["shape"], group["position/value"][:]
            kinds, counts, points = shape["kind"][:], shape["count"][:], shape["points"][:]
            found, first = [], 0
            for k, (kind, count) in enumerate(zip(kinds, counts)):
                own = points[first:first + count] + place[-1, k] - place[0, k]  # given as in the deck
                first += count
                found.append((WALL_KINDS.get(int(kind), "segment"), own if count else place[-1, k:k + 1],
                              float(shape["radius"][k])))
            return found

    def series(self, *names):
        """Time and these observables."""
        with h5py.File(self.path, "r") as file:
            table = file["observables"]
            groups = [group for group in table.values() if isinstance(group, h5py.Group)]
            clock = next(group["time"] for group in groups if "time" in group)
            return [clock[:],
                    *(table[name]["value"][:] for name in names)]

    def frames(self):
        """(times, positions [frame][disk][2]) of all disks, in the order of the deck."""
        with h5py.File(self.path, "r") as file:
            place = file["particles/disks/position"]
            return place["time"][:], place["value"][:]

    def velocities(self):
        """[n][2] of the free disks at the end."""
        with h5py.File(self.path, "r") as file:
            return np.column_stack([file["state/vx"][:self.n_free], file["state/vy"][:self.n_free]])

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
