"""The disks of the vibrated boxes as columns, kept as tables: all that is said of them follows without result files."""
import dataclasses

import numpy as np

from ratchet.verdict import MOTIONS, SURE

SHARE = 0.1      # a contact that is closed in so many of the stored tables is persistent
HELD = 2         # a disk with fewer persistent contacts is a rattler, as for `slipdisk measure`
CHANCE = 0.02    # so many disks that do not turn are beyond three errors, at most (docs/physics.md, section 9)
LIMIT = 1.96     # errors that an upper limit of 95 % lies above what was found
SWEEPS = ("drive", "random")  # entries of plan.py with all drives, for each of MOTIONS
PERIOD = 1 / 80  # of the floor
OPEN = 0.1       # openings per contact and period that separate the regimes: from here on contacts open
MANY = 1.0       # so many: they bounce

# Columns of disks that are kept: of every run (reading.py), and further ones.
KEPT = {"radius": "radius", "height": "y_end", "omega": "omega", "error": "error", "omega_first": "first",
        "omega_second": "second", "rms": "rms_place", "coordination": "contacts"}
MORE = ("persistent", "sliding", "openings", "injected", "friction", "viscous", "displacement")
COLUMNS = (*KEPT, *MORE)
WHOLE = {"openings": "openings", "sliding": "sliding_fraction", "coordination": "coordination", "wander": "wander",
         "drift": "drift", "farthest": "farthest", "noise": "noise", "seed": "seed", "measured": "measured"}
DIGITS = 5
RULE = (f"Rattlers are disks with fewer than {HELD} persistent contacts; a contact is persistent when it is closed in "
        f"{100 * SHARE:.0f} % of the stored tables or more.")


@dataclasses.dataclass
class Box:
    """One packing at one drive: numbers of the whole in `whole`, of each free disk in `columns`."""
    whole: dict
    columns: dict

    def __getitem__(self, name):
        return self.columns[name]

    @property
    def drive(self):
        return self.whole["drive"]

    @property
    def replica(self):
        return self.whole["replica"]

    @property
    def held(self):
        """Which disks are no rattlers."""
        return self["persistent"] >= HELD

    @property
    def rms(self):
        """Of the angular velocities of the disks that are no rattlers."""
        return root(self["omega"][self.held])

    @property
    def median(self):
        return float(np.median(np.abs(self["omega"][self.held]))) if self.held.any() else np.nan

    @property
    def turns(self):
        """Which disks rotate by more than three errors."""
        return np.abs(self["omega"]) > SURE * self["error"]

    @property
    def halves(self):
        """Mean angular velocities in both halves of the measured time, of the disks that are no rattlers."""
        return self["omega_first"][self.held], self["omega_second"][self.held]

    @property
    def noise(self):
        """Median error bar of the disks that are no rattlers."""
        return float(np.median(self["error"][self.held])) if self.held.any() else np.nan

    def spread(self, name, loose=False):
        """Root mean square of `rms` (about the mean place) or `displacement` (of it), in mean diameters."""
        return root(self[name][~self.held if loose else self.held]) / (2 * float(self["radius"].mean()))

    @property
    def openings(self):
        """Openings per closed contact and period."""
        return self.whole["openings"] * PERIOD


def root(values):
    """Root mean square; nan of nothing."""
    return float(np.sqrt(np.mean(np.square(values)))) if len(values) else np.nan


def persistent_contacts(run):
    """Per free disk: its contacts that are closed in a tenth of the tables of the measured time. Without tables the
    mean number of contacts stands for it."""
    tables = run.result.contacts
    times = np.asarray(tables.time)
    chosen = np.flatnonzero(times > times[-1] - run.measured) if len(times) else []
    if not len(chosen):
        return np.asarray(run.means["coordination"], float)
    met = {}
    for k in chosen:
        for pair in set(zip(tables[k]["a"].tolist(), tables[k]["b"].tolist())):
            met[pair] = met.get(pair, 0) + 1
    found = np.zeros(run.n_free)
    slot = {int(number): k for k, number in enumerate(run.id)}
    for pair, count in met.items():
        if count >= SHARE * len(chosen):
            for number in pair:
                if number in slot:
                    found[slot[number]] += 1
    return found


def _runs(campaign, name):
    runs = [run for run in campaign.runs(name) if run.has_means] if name in campaign.entries else []
    return sorted(runs, key=lambda run: (run.parameters.get("drive", 0.0), run.parameters.get("r", 0.0)))


def boxes(campaign, name, drive=np.nan):
    """The packings of a run or sweep, in order of drive (this one where it is not swept) and replica, from results or
    from kept tables."""
    runs = _runs(campaign, name)

    def more():
        if not runs or not all(run.path for run in runs):
            return None
        number = np.concatenate([np.full(run.n_free, k) for k, run in enumerate(runs)])
        return {"packing": number, **{key: np.concatenate([persistent_contacts(run) if key == "persistent"
                                                           else run.means[key] for run in runs]) for key in MORE}}

    table = campaign.numbers(f"cages-{name}", more, "contacts, powers and displacements of disks; packing: counts the "
                             "runs by drive and replica", DIGITS)
    number = table.column("packing")
    columns = {key: table.column(key) for key in MORE}
    found = []
    for k, run in enumerate(runs):
        whole = {"drive": float(run.parameters.get("drive", drive)), "replica": float(run.parameters.get("r", 0)),
                 **{key: getattr(run, value) for key, value in WHOLE.items()}}
        own = {key: np.asarray(getattr(run, value), float) for key, value in KEPT.items()}
        found.append(Box(whole, own | {key: values[number == k] for key, values in columns.items()}))
    return found


def of_motions(campaign):
    """{motion: {drive: boxes}} of the sweeps of drives."""
    return {motion: by_drive(boxes(campaign, name)) for motion, name in zip(MOTIONS, SWEEPS)}


def by_drive(found):
    """{drive: boxes}, in order."""
    table = {}
    for box in found:
        table.setdefault(box.drive, []).append(box)
    return dict(sorted(table.items()))


# --- displacements ------------------------------------------------------------------------------------------------
LAGS = (1, 2, 4, 8, 16, 32, 64)  # in frames, which are at one phase of the floor


def square_displacements(run):
    """[lag][disk] means over all starts of the squared displacement, in mean diameters, and the lags in time."""
    time, place = (np.asarray(values) for values in run.frames())
    chosen = np.flatnonzero(time > time[-1] - run.measured)
    step = float(np.median(np.diff(time[chosen]))) if len(chosen) > 1 else np.nan
    if len(chosen) > 1 and time[chosen[-1]] - time[chosen[-2]] < 0.99 * step:  # the end of the run, at another phase
        chosen = chosen[:-1]
    place = place[chosen][:, np.asarray(run.id, int)] / (2 * float(run.radius.mean()))
    lags = [lag for lag in LAGS if lag < len(place)]
    squares = [np.mean(np.sum((place[lag:] - place[:-lag]) ** 2, axis=2), axis=0) for lag in lags]
    return np.array(lags) * step, np.array(squares)


def wandering(campaign, name, found):
    """Table of root mean square displacements against lag: columns packing, lag, held, loose (rattlers), in "
      "diameters."""
    runs = _runs(campaign, name)

    def make():
        if not all(run.path for run in runs):
            return None
        columns = {"packing": [], "lag": [], "held": [], "loose": []}
        for k, (run, box) in enumerate(zip(runs, found)):
            for lag, square in zip(*square_displacements(run)):
                values = [np.sqrt(square[part].mean()) if part.any() else np.nan for part in (box.held, ~box.held)]
                for key, value in zip(columns, (k, lag, *values)):
                    columns[key].append(value)
        return columns if columns["lag"] else None

    return campaign.numbers(f"displacements-{name}", make, f"rms displacement against time, {name}, in diameters",
                            digits=DIGITS)
