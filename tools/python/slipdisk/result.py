"""Results of runs, finished or not; docs/results.md says what is in the files."""
import collections.abc
import contextlib
import os
import re

import h5py
import numpy as np

from .library import FileError, Record, unknown
from .sealed import Verified

FIRST = ("name", "disk", "partner")  # columns of tables that come first


def plain(value):
    """What h5py gives, as Python has it: texts are str, scalars numbers."""
    if isinstance(value, h5py.Empty):
        return ""
    if isinstance(value, bytes):
        return value.rstrip(b"\0").decode("utf-8", "replace")
    if isinstance(value, np.generic):
        return plain(value.item())
    if isinstance(value, np.ndarray) and value.dtype.kind in "SO":
        return [plain(item) for item in value.tolist()]
    return value


def attributes(item):
    return Record((name, plain(value)) for name, value in item.attrs.items())


def text_lines(item):
    """Lines of a dataset that is a text."""
    return plain(item[()]).removesuffix("\n").split("\n")


def structured(columns):
    """{name: array} as one structured array."""
    rows = len(next(iter(columns.values()))) if columns else 0
    table = np.empty(rows, [(name, column.dtype, column.shape[1:]) for name, column in columns.items()])
    for name, column in columns.items():
        table[name] = column
    return table


def to_pandas(columns):
    """A pandas.DataFrame of {name: array}; of arrays with rows of several values a column each."""
    import pandas
    flat = {}
    for name, column in columns.items():
        if column.ndim == 1:
            flat[name] = column
        else:
            flat.update((f"{name}[{k}]", part) for k, part in enumerate(column.reshape(len(column), -1).T))
    return pandas.DataFrame(flat)


class Columns(collections.abc.Mapping):
    """Arrays by name, read when asked for; `unit` and `meaning` of each, and all together as a structured `array()` or
    as `pandas()`."""

    def __init__(self, result, where, paths):
        self._result, self._where, self._paths = result, where, paths

    def _path(self, name):
        if name not in self._paths:
            raise unknown(name, list(self._paths), f"{self._where} of {self._result.path}")
        return self._paths[name]

    def __getitem__(self, name):
        return self._result.rows(self._path(name))

    def __iter__(self):
        return iter(self._paths)

    def __len__(self):
        return len(self._paths)

    def unit(self, name):
        """Unit of a column, in terms of length, mass, time."""
        return self._result.attribute(self._path(name), "unit")

    def meaning(self, name):
        """Meaning of a column, in a few words."""
        return self._result.attribute(self._path(name), "description")

    def array(self, *names):
        """The columns of these names, or all, as a structured array."""
        return structured({name: self[name] for name in names or self})

    def pandas(self, *names):
        """The columns of these names, or all, as a pandas.DataFrame."""
        return to_pandas({name: self[name] for name in names or self})

    def __repr__(self):
        return "\n".join(f"{name:<24}{self.unit(name):<16}{self.meaning(name)}" for name in self)


class Frames(collections.abc.Sequence):
    """Stored frames: frames[k]["position"] is [disk][2] of frame k, frames["position"] is [frame][disk][2] of all;
    `time`, `step`, `box` and `box_offset` of each."""

    def __init__(self, result, group):
        self._result, self._group = result, group
        self._names = result.groups(group)

    def __len__(self):
        return len(self.step) if self._names else 0

    def _path(self, name):
        if name not in self._names:
            raise unknown(name, self._names, f"frames of {self._result.path}")
        return f"{self._group}/{name}/value"

    def __getitem__(self, which):
        if isinstance(which, str):
            return self._result.rows(self._path(which))
        if isinstance(which, slice):
            return [self[k] for k in range(*which.indices(len(self)))]
        k = which + len(self) if which < 0 else which
        if not 0 <= k < len(self):
            raise IndexError(f"frame {which} of {len(self)}")
        return Record((name, self._result.rows(self._path(name), k, k + 1)[0]) for name in self._names)

    @property
    def step(self):
        """Step of each frame."""
        return self._result.rows(f"{self._group}/{self._names[0]}/step") if self._names else np.empty(0, "i8")

    @property
    def time(self):
        """Time of each frame."""
        return self._result.rows(f"{self._group}/{self._names[0]}/time") if self._names else np.empty(0)


    def _edges(self):
        """[frame][2][2]: edge vectors of the box, in rows."""
        framed = "edges" in self._result.groups(f"{self._group}/box")
        edges = np.asarray(self._result.rows(f"{self._group}/box/edges" + ("/value" if framed else "")), float)
        if not framed:
            edges = np.repeat(edges[np.newaxis], len(self), axis=0)
        return edges if edges.ndim == 3 else edges[:, :, np.newaxis] * np.eye(2)

    @property
    def box(self):
        """Lengths of the periodic box in each frame, [frame][2]; 0 where it is open."""
        return self._edges().diagonal(axis1=1, axis2=2)

    @property
    def box_offset(self):
        """By how much a row of periodic images is shifted along x against the one below, in each frame."""
        return self._edges()[:, 1, 0]


class Contacts(collections.abc.Sequence):
    """Stored contact tables: contacts[k] is a structured array of moment k; `time`, `step` and `count` of each."""

    def __init__(self, result):
        self._result = result
        self._names = [name for name in result.datasets("contacts") if name not in ("step", "time", "first", "count")]
        self._first = None

    def __len__(self):
        return len(self.step)

    def __getitem__(self, which):
        if isinstance(which, slice):
            return [self[k] for k in range(*which.indices(len(self)))]
        if self._first is None:
            self._first = np.concatenate([[0], np.cumsum(self.count)])
        k = which + len(self) if which < 0 else which
        if not 0 <= k < len(self):
            raise IndexError(f"contacts of moment {which} of {len(self)}")
        return structured({name: self._result.rows(f"contacts/{name}", self._first[k], self._first[k + 1]) for name in self._names})

    def all(self, name):
        """A column over all moments, one after the other."""
        return self._result.rows(f"contacts/{name}")

    @property
    def step(self):
        """Step of each table."""
        return self._result.rows("contacts/step") if self._names else np.empty(0, "i8")

    @property
    def time(self):
        """Time of each table."""
        return self._result.rows("contacts/time") if self._names else np.empty(0)

    @property
    def count(self):
        """Number of contacts in each table."""
        return self._result.rows("contacts/count") if self._names else np.empty(0, "i8")


class Average(Record):
    """Mean of columns of the series: mean, error, correlation, transient, measured, rows, missing, converged, and what it is the
    mean of: of, unit. It prints as 0.2900 +- 0.0046, and says when the error cannot be trusted."""

    def __repr__(self):
        if not self.rows:
            return "no measured rows yet"
        if not np.isfinite(self.mean):
            return f"no mean: {self.missing} of {self.rows} rows are not finite" if self.missing else "no mean: the denominator is 0"
        if not np.isfinite(self.error):
            return f"{self.mean:.6g} +- ? (too few rows for an error bar)"
        digits = 1 - int(np.floor(np.log10(self.error))) if self.error > 0 else -1
        text = f"{self.mean:.{digits}f} +- {self.error:.{digits}f}" if 0 <= digits < 7 else f"{self.mean:.6g} +- {self.error:.2g}"
        return text + ("" if self.converged else " (error not reliable)")


class NotYet(FileError):
    """There is neither a result nor a checkpoint yet."""


class Result:
    """What a run has found, finished or not.

    path     the result NAME.h5, whether it is there or still NAME.h5.parts; or a checkpoint
    verify   compare all bytes of its files with their checksums before they are read, by `slipdisk verify`: a damaged one is a
             FileError. False: read what is there, which may be other numbers than those written, or end the interpreter

    Of an unfinished run it is what the newest checkpoint has; `refresh()` looks again. Arrays are read when they are asked
    for."""

    def __init__(self, path, *, verify=True):
        self.path = re.sub(r"\.parts/?$", "", os.fspath(path))
        self._files = Verified(verify)
        self.refresh()

    def refresh(self):
        """Looks again at what a run has written. Returns self."""
        for _ in range(5):  # checkpoints go while they are looked for, and the folder when the run is finished
            if self._look():
                return self
        raise NotYet(f"{self.path}: no result, and no checkpoint in {self.path}.parts yet")

    def _look(self):
        folder = self.path + ".parts"
        if os.path.isfile(self.path):
            self._head, self._parts = self.path, [self.path]
        else:
            try:
                names = os.listdir(folder)
            except OSError:
                raise NotYet(f"{self.path}: no such result, nor {folder}") from None
            found = [(int(m[1]), name) for name in names if (m := re.fullmatch(r"checkpoint-(\d+)\.h5", name))]
            if not found:
                return False
            self._head = os.path.join(folder, max(found)[1])
            self._parts = []
        try:
            with self._file(self._head) as file:
                if not {"state", "parameters", "summary"} <= set(file):
                    raise FileError(f"{self.path}: not a result of slipdisk")
                self.summary, self.provenance = attributes(file["summary"]), attributes(file["parameters"])
                self.finished = "checkpoint" not in file and self.summary.phase == self.summary.phases
                if not self._parts:
                    count = int(file["checkpoint"].attrs["parts"])
                    self._parts = [os.path.join(folder, f"part-{k:06d}.h5") for k in range(1, count + 1)]
        except FileNotFoundError:
            return False
        return True

    @contextlib.contextmanager
    def _file(self, path):
        try:
            file = self._files.opened(path, self._parts if path in self._parts else ())
        except (FileNotFoundError, FileError):
            raise
        except OSError as error:
            raise FileError(f"{path}: {error}") from None
        with file:
            yield file

    # --- what all else is read by -----------------------------------------------------------------------------------
    def rows(self, path, first=0, last=None):
        """Rows [first, last) of a dataset, those of all parts one after the other."""
        found, done = [], 0
        for part in self._parts if len(self._parts) and not self._in_head(path) else [self._head]:
            with self._file(part) as file:
                if path not in file:
                    raise unknown(path, list(file), part)
                data = file[path]
                if data.shape == ():
                    return plain(data[()])
                n = len(data)
                if last is None or done < last or not found:  # a piece without rows still has their type
                    found.append(data[max(first - done, 0):None if last is None else min(last - done, n)])
                done += n
        kept = [piece for piece in found if len(piece)] or found
        return kept[0] if len(kept) == 1 else np.concatenate(kept)

    def _in_head(self, path):
        return path.split("/")[0] in ("state", "summary", "parameters")

    def _some(self, path):
        """A file that has this group, if any has."""
        return self._head if self._in_head(path) else (self._parts or [self._head])[0]

    def groups(self, path):
        """Names of what has values in a group."""
        with self._file(self._some(path)) as file:
            group = file.get(path, {})
            return [name for name in group if isinstance(group[name], h5py.Group) and "value" in group[name]]

    def datasets(self, path):
        """Names of the datasets in a group."""
        with self._file(self._some(path)) as file:
            group = file.get(path, {})
            return [name for name in group if isinstance(group[name], h5py.Dataset)]

    def attribute(self, path, name):
        """An attribute of a group or dataset; an empty text where there is none."""
        with self._file(self._some(path)) as file:
            return plain(file[path].attrs.get(name, ""))

    def attributes(self, path):
        """Attributes of a group or dataset."""
        with self._file(self._some(path)) as file:
            return attributes(file[path])

    def table(self, path):
        """A group of columns as a structured array, with `name` where there are names; None: there is none."""
        with self._file(self._some(path)) as file:
            if path not in file:
                return None
            group, columns, names = file[path], {}, None
            for name, item in group.items():
                if isinstance(item, h5py.Dataset) and item.shape:
                    columns[name] = item[:]
                elif isinstance(item, h5py.Dataset) and name == "name":
                    names = np.array(text_lines(item), str)
        rows = max(map(len, columns.values()), default=0)
        if names is not None and rows and len(names) % rows == 0:  # of watched contacts also those of both partners
            columns["name"] = names if len(names) == rows else names.reshape(rows, -1)
        columns = {name: columns[name] for name in sorted(columns, key=lambda name: (name not in FIRST, name))}
        return structured({name: column for name, column in columns.items() if len(column) == rows})

    # --- the run ------------------------------------------------------------------------------------------------------
    @property
    def step(self):
        """Step of the last state."""
        return self.summary["step"]

    @property
    def time(self):
        """Time of the last state."""
        return self.summary["time"]

    @property
    def dt(self):
        """Time step."""
        return self.summary["dt"]

    @property
    def deck(self):
        """The complete deck with all defaults."""
        return self.rows("parameters/deck_full")

    @property
    def deck_text(self):
        """The deck as it was written, without overrides."""
        return self.rows("parameters/deck_text")

    # --- what was found ---------------------------------------------------------------------------------------------
    @property
    def energy(self):
        """The energy budget at the end."""
        with self._file(self._head) as file:
            return attributes(file["summary/energy"])

    @property
    def doubts(self):
        """A list of `name`, `message`, `value`, `limit`: why the numbers may mean nothing."""
        with self._file(self._head) as file:
            group = file.get("summary/doubts", {})
            return [Record(name=name, **attributes(group[name])) for name in group]

    @property
    def rotation(self):
        """Mean angular velocity of each watched disk, a structured array: name, disk, omega, error, scaled, ..."""
        return self.table("summary/rotation")

    @property
    def averages(self):
        """Averages of the series, which the deck's measure.averages names: averages["mu"] has mean, error, converged, ..., and prints
        as 0.2900 +- 0.0046."""
        table = self.table("summary/average")
        rows = [] if table is None else table
        return Record((str(row["name"][0]), Average({name: row[name].item() for name in table.dtype.names if name != "name"},
                                                    of=str(row["name"][1]), unit=str(row["name"][2]))) for row in rows)

    @property
    def slide(self):
        """Fractions of time in each configuration of sliding, of each watched pair of contacts."""
        return self.table("summary/slide")

    @property
    def configurations(self):
        """Torque, normal forces and visits in S++, S+-, S-+, S--, stick, open of each watched pair of contacts, when the deck says
        measure = { configurations = true; }."""
        return self.table("summary/configuration")

    @property
    def phases(self):
        """What became of each phase: name, steps, most, reached, ..."""
        return self.table("summary/phase")

    @property
    def means(self):
        """Means of every free disk: with measure = { disks = true; }, else None; None also while a run of very many goes on."""
        with self._file(self._head) as file:
            known = "summary/disks/id" in file
        return self.table("summary/disks") if known else None

    @property
    def totals(self):
        """Means over all disks: omega_rms, significant, coordination, ...; None where `means` is."""
        with self._file(self._head) as file:
            return attributes(file["summary/disks"]) if "summary/disks/id" in file else None

    @property
    def series(self):
        """Time series: series["time"], series["work"], ..."""
        names = self.groups("observables")
        first = {name: f"observables/{names[0]}/{name}" for name in ("step", "time")} if names else {}
        return Columns(self, "series", {**first, **{name: f"observables/{name}/value" for name in names}})

    @property
    def frames(self):
        """Stored frames of the disks: frames[-1]["position"], frames["angle"], frames.time."""
        return Frames(self, "particles/disks")

    @property
    def wall_frames(self):
        """The same of the walls."""
        return Frames(self, "particles/walls")

    @property
    def contacts(self):
        """Stored contact tables: contacts[-1]["force"], contacts.time."""
        return Contacts(self)

    @property
    def state(self):
        """Columns of the last state, in the order of slots (state["id"] has the numbers)."""
        return Columns(self, "state", {name: f"state/{name}" for name in self.datasets("state")})

    @property
    def last_contacts(self):
        """Closed contacts of the last state, a structured array: a, b, part, force, overlap, ..."""
        state = self.state
        columns = {name[len("contact_"):]: state[name] for name in state if name.startswith("contact_")}
        return structured({name: column for name, column in columns.items() if len(column) == len(columns["a"])})

    def _deck_box(self):
        """Lengths of the periodic box of the deck, 0 where it is open."""
        for line in self.rows("parameters/deck_bodies").split("\n"):
            kind, *numbers = line.split()
            if kind == "box":
                periodic, x, y = np.array(numbers, float).reshape(3, 2)
                return np.where(periodic > 0, [x[1] - x[0], y[1] - y[0]], 0.0)
        raise FileError(f"{self.path}: it does not say what its box is")

    def _cell(self):
        """How a box that deforms stands: its lengths over those before, and its offset over its width before."""
        state = self.state
        cell = state["cell"] if "cell" in state else ()
        return np.array([*cell[:3]]) if len(cell) else np.array([1.0, 1.0, 0.0])

    @property
    def box(self):
        """Lengths of the periodic box at the end, compressed or deformed, 0 where it is open."""
        return self._deck_box() * self.state["box_scale"] * self._cell()[:2]

    @property
    def box_offset(self):
        """By how much a row of periodic images is shifted along x against the one below at the end: a box that was sheared."""
        return float(self._deck_box()[0] * np.ravel(self.state["box_scale"])[0] * self._cell()[2])

    @property
    def names(self):
        """Names of the disks, in their order; "" where the deck gives none."""
        names = [""] * self.summary["disks"]
        for line in self.rows("parameters/deck_bodies").split("\n"):
            kind, *rest = line.split("\t")
            if kind == "disk":
                names[int(rest[0])] = rest[1]
        return names

    @property
    def disks(self):
        """The disks in the last state, a structured array in the order of their numbers: radius, mass, inertia, material,
        x, y, vx, vy, angle, omega."""
        state, n = self.state, self.summary["disks"]
        number = state["id"]
        order = np.empty(n, int)
        mine = number < n
        order[number[mine]] = np.flatnonzero(mine)
        columns = {name: state[name][order] for name in ("radius", "mass", "inertia", "material", "x", "y", "vx", "vy", "omega")}
        return structured({**columns, "angle": (state["turn"] + state["theta"])[order]})

    def __repr__(self):
        return f"<slipdisk.Result {self.path!r}: step {self.step}, time {self.time:g}{'' if self.finished else ', not finished'}>"
