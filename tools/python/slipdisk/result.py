"""Results of runs, finished or not; docs/results.md says what is in the files."""
from __future__ import annotations

import contextlib
import os
import re
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import h5py
import numpy as np
from numpy.typing import NDArray

from .arguments import Fixed, checked
from .deck import Deck, deck_values
from .library import FileError, Record, StrPath, UserError, Whole, unknown, whole
from .measure import Measurement, fragments, stored
from .notebook import Shown, View, array_html, table_html, view
from .sealed import Verified
from .stored import Columns, Contacts, Frames
from .tables import indexed, structured

if TYPE_CHECKING:
    from typing_extensions import Self

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


class Average(Record[Any]):
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


class Result(Fixed, Shown):
    """What a run has found, finished or not.

    path     the result NAME.h5, whether it is there or still NAME.h5.parts; or a checkpoint
    verify   compare all bytes of its files with their checksums before they are read, by `slipdisk verify`: a damaged one is a
             FileError. False: read what is there, which may be other numbers than those written, or end the interpreter

    Of an unfinished run it is what the newest checkpoint has; `refresh()` looks again. Arrays are read when they are asked
    for."""

    path: str
    finished: bool
    summary: Record[Any]
    provenance: Record[Any]

    @checked
    def __init__(self, path: StrPath, *, verify: bool = True) -> None:
        self._set(path=re.sub(r"\.parts/?$", "", os.fspath(path)))
        self._files = Verified(verify)
        self.refresh()

    def refresh(self) -> Self:
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
                summary = attributes(file["summary"])
                self._set(summary=summary, provenance=attributes(file["parameters"]),
                          finished="checkpoint" not in file and summary.phase == summary.phases)
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
    @checked
    def rows(self, path: str, first: int = 0, last: int | None = None) -> Any:
        """Rows [first, last) of a dataset, those of all parts one after the other."""
        first, last = whole(first, "rows: first", 0), None if last is None else whole(last, "rows: last", 0)
        found, done = [], 0
        for part in self._parts if len(self._parts) and not self._in_head(path) else [self._head]:
            with self._file(part) as file:
                data = self._there(file, path)
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

    @checked
    def groups(self, path: str) -> list[str]:
        """Names of what has values in a group."""
        with self._file(self._some(path)) as file:
            group = file.get(path, {})
            return [name for name in group if isinstance(group[name], h5py.Group) and "value" in group[name]]

    @checked
    def datasets(self, path: str) -> list[str]:
        """Names of the datasets in a group."""
        with self._file(self._some(path)) as file:
            group = file.get(path, {})
            return [name for name in group if isinstance(group[name], h5py.Dataset)]

    @checked
    def attribute(self, path: str, name: str) -> Any:
        """An attribute of a group or dataset; an empty text where there is none."""
        with self._file(self._some(path)) as file:
            return plain(self._there(file, path).attrs.get(name, ""))

    @checked
    def attributes(self, path: str) -> Record[Any]:
        """Attributes of a group or dataset."""
        with self._file(self._some(path)) as file:
            return attributes(self._there(file, path))

    def _there(self, file, path):
        if path not in file:
            raise unknown(path, list(file), self.path)
        return file[path]

    @checked
    def table(self, path: str) -> NDArray[np.void] | Any:
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
    def step(self) -> int:
        """Step of the last state."""
        return self.summary["step"]

    @property
    def time(self) -> float:
        """Time of the last state."""
        return self.summary["time"]

    @property
    def dt(self) -> float:
        """Time step."""
        return self.summary["dt"]

    @indexed
    def deck(self) -> Deck:
        """The complete deck with all defaults, as nested dicts: deck.gravity.tilt, deck["materials"]["grain"]["k_n"]."""
        return deck_values(self.deck_full)

    @property
    def deck_full(self) -> str:
        """The text of the complete deck with all defaults."""
        return self.rows("parameters/deck_full")

    @property
    def deck_text(self) -> str:
        """The deck as it was written, without overrides."""
        return self.rows("parameters/deck_text")

    # --- what was found ---------------------------------------------------------------------------------------------
    @indexed
    def energy(self) -> Record[float]:
        """The energy budget at the end."""
        with self._file(self._head) as file:
            return attributes(file["summary/energy"])

    @property
    def doubts(self) -> list[Record[Any]]:
        """A list of `name`, `message`, `value`, `limit`: why the numbers may mean nothing."""
        with self._file(self._head) as file:
            group = file.get("summary/doubts", {})
            return [Record(name=name, **attributes(group[name])) for name in group]

    @indexed
    def rotation(self) -> NDArray[np.void]:
        """Mean angular velocity of each watched disk, a structured array: name, disk, omega, error, scaled, ..."""
        return self.table("summary/rotation")

    @indexed
    def averages(self) -> Record[Average]:
        """Averages of the series, which the deck's measure.averages names: averages["mu"] has mean, error, converged, ..., and prints
        as 0.2900 +- 0.0046."""
        table = self.table("summary/average")
        rows = [] if table is None else table
        return Record((str(row["name"][0]), Average({name: row[name].item() for name in table.dtype.names if name != "name"},
                                                    of=str(row["name"][1]), unit=str(row["name"][2]))) for row in rows)

    @indexed
    def slide(self) -> NDArray[np.void]:
        """Fractions of time in each configuration of sliding, of each watched pair of contacts."""
        return self.table("summary/slide")

    @indexed
    def configurations(self) -> NDArray[np.void]:
        """Torque, normal forces and visits in S++, S+-, S-+, S--, stick, open of each watched pair of contacts, when the deck says
        measure = { configurations = true; }."""
        return self.table("summary/configuration")

    @indexed
    def phases(self) -> NDArray[np.void]:
        """What became of each phase: name, steps, most, reached, ..."""
        return self.table("summary/phase")

    @indexed
    def means(self) -> NDArray[np.void] | None:
        """Means of every free disk: with measure = { disks = true; }, else None; None also while a run of very many goes on."""
        with self._file(self._head) as file:
            known = "summary/disks/id" in file
        return self.table("summary/disks") if known else None

    @indexed
    def totals(self) -> Record[Any] | None:
        """Means over all disks: omega_rms, significant, coordination, ...; None where `means` is."""
        with self._file(self._head) as file:
            return attributes(file["summary/disks"]) if "summary/disks/id" in file else None

    @indexed
    def series(self) -> Columns[NDArray[Any]]:
        """Time series: series["time"], series["work"], ..."""
        names = self.groups("observables")
        first = {name: f"observables/{names[0]}/{name}" for name in ("step", "time")} if names else {}
        return Columns(self, "series", {**first, **{name: f"observables/{name}/value" for name in names}})

    @indexed
    def frames(self) -> Frames:
        """Stored frames of the disks: frames[-1]["position"], frames["angle"], frames.time."""
        return Frames(self, "particles/disks", "disk")

    @indexed
    def wall_frames(self) -> Frames:
        """The same of the walls."""
        return Frames(self, "particles/walls", "wall")

    @indexed
    def contacts(self) -> Contacts:
        """Stored contact tables: contacts[-1]["force"], contacts.time."""
        return Contacts(self)

    @checked
    def measure(self, frame: Any = None, region: Sequence[float] | None = None, bins: int = 100) -> Any:
        """Contacts, packing fractions, stress, fabric, g(r), forces, a Measurement: m.z, m.fraction, m.pressure, m.stress.
        frame: number of a stored frame, -1 the last one; several, or slice(None) for all: a list, for which the file is opened
        once; None: the last state. region: x0, x1, y0, y1 of the part that counts, else that of the deck; bins: of each histogram."""
        if frame is None:
            return stored(self._head, [-1], region, bins)[0]
        n = len(self.frames)
        if n == 0:
            raise UserError(f"{self.path}: no frames are stored in it; measure() is of the last state")
        several = range(*frame.indices(n)) if isinstance(frame, slice) else frame
        one = not isinstance(several, (list, tuple, range)) and (not isinstance(several, np.ndarray) or several.ndim == 0)
        several = [whole(k, "measure: frame", -n, n - 1) % n for k in ([several] if one else several)]
        found = stored(self.path, several, region, bins)
        return found[0] if one else found

    @indexed
    def state(self) -> Columns[Any]:
        """Columns of the last state, in the order of slots (state["id"] has the numbers)."""
        return Columns(self, "state", {name: f"state/{name}" for name in self.datasets("state")})

    @indexed
    def last_contacts(self) -> NDArray[np.void]:
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
    def box(self) -> NDArray[np.float64]:
        """Lengths of the periodic box at the end, compressed or deformed, 0 where it is open."""
        return self._deck_box() * self.state["box_scale"] * self._cell()[:2]

    @property
    def box_offset(self) -> float:
        """By how much a row of periodic images is shifted along x against the one below at the end: a box that was sheared."""
        return float(self._deck_box()[0] * np.ravel(self.state["box_scale"])[0] * self._cell()[2])

    @property
    def names(self) -> list[str]:
        """Names of the disks, in their order; "" where the deck gives none."""
        names = [""] * self.summary["disks"]
        for line in self.rows("parameters/deck_bodies").split("\n"):
            kind, *rest = line.split("\t")
            if kind == "disk":
                names[int(rest[0])] = rest[1]
        return names

    @indexed
    def disks(self) -> NDArray[np.void]:
        """The disks in the last state, a structured array in the order of their numbers: radius, mass, inertia, material,
        x, y, vx, vy, angle, omega."""
        state, n = self.state, self.summary["disks"]
        number = state["id"]
        order = np.empty(n, int)
        mine = number < n
        order[number[mine]] = np.flatnonzero(mine)
        columns = {name: state[name][order] for name in ("radius", "mass", "inertia", "material", "x", "y", "vx", "vy", "omega")}
        return structured({**columns, "angle": (state["turn"] + state["theta"])[order]})

    @checked
    def fragments(self, table: Whole = -1) -> NDArray[np.void]:
        """Bodies of bonded free disks, single disks too, the heaviest first, a structured array: mass, disks, first (lowest number).
        table: number of a stored contact table, -1 the last one."""
        state, contacts = self.state, self.contacts[table]
        free = np.flatnonzero(state["activity"] == 0)
        return fragments(contacts, state["id"][free], state["mass"][free])

    # --- notebooks --------------------------------------------------------------------------------------------------
    @checked
    def view(self, frames: str | None = None, height: Whole = 640) -> View:
        """The page of `slipdisk view`, which a notebook shows in place: play the frames, zoom in, pick disks.

        frames   as slices in Python: "-1:" the last one, "::10"; by default at most 501, evenly spaced
        height   in pixels"""
        return view(self.path, frames, height)

    def __repr__(self):
        return f"<slipdisk.Result {self.path!r}: step {self.step}, time {self.time:g}{'' if self.finished else ', not finished'}>"

    def _tables(self):
        s, frames, contacts = self.summary, self.frames, self.contacts
        series = self.series
        yield table_html((), [
            ("title", self.deck.get("title", "")), ("bodies", f"{s.disks} disks, {s.walls} walls"),
            ("closed contacts", s.contacts), ("dt", self.dt),
            ("stored", f"series: {len(series['step']) if len(series) else 0} rows; frames: {len(frames)}; contact tables: {len(contacts)}"),
            *(("in doubt", doubt.message) for doubt in self.doubts)])
        if self.rotation is not None and len(self.rotation):
            names = [name for name in ("name", "omega", "error", "scaled", "scaled_error", "converged") if name in self.rotation.dtype.names]
            yield array_html(self.rotation[names])

