"""What a result stores: columns, frames and contact tables, read when they are asked for."""
from __future__ import annotations

import collections.abc
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any, SupportsIndex, overload

import numpy as np
from numpy.typing import NDArray

from .arguments import Fixed, index
from .library import Record, V, unknown
from .notebook import Shown, table_html
from .tables import Named, structured, to_pandas, to_xarray

if TYPE_CHECKING:
    import pandas
    import xarray


class Columns(Named[V]):
    """Arrays by name, read when asked for; `unit` and `meaning` of each, and all together as a structured `array()`, as `pandas()`
    or as `xarray()`."""

    def __init__(self, result, where, paths):
        self._result, self._where, self._paths = result, where, paths
        self._dimension = "time" if where == "series" else "slot"

    def _path(self, name):
        if not isinstance(name, str) or name not in self._paths:
            raise unknown(name, list(self._paths), f"{self._where} of {self._result.path}")
        return self._paths[name]

    def __getitem__(self, name: str) -> V:
        return self._result.rows(self._path(name))

    def __iter__(self) -> Iterator[str]:
        return iter(self._paths)

    def __len__(self) -> int:
        return len(self._paths)

    def unit(self, name: str) -> str:
        """Unit of a column, in terms of length, mass, time."""
        return self._result.attribute(self._path(name), "unit")

    def meaning(self, name: str) -> str:
        """Meaning of a column, in a few words."""
        return self._result.attribute(self._path(name), "description")


class Moments(Fixed, Shown, collections.abc.Sequence[V]):
    """What is stored at some moments of a run: of moment k by number, a column of all moments by name; `step` and `time` of each,
    `unit` and `meaning` of a column."""

    def __init__(self, result, what, names, path, moment):
        self._result, self._what, self._names = result, what, names
        self._paths = path, moment  # of a column, and of step or time; {} is the name

    def __len__(self) -> int:
        return len(self.step)

    def _path(self, name):
        if not isinstance(name, str) or name not in self._names:
            raise unknown(name, self._names, f"{self._what} of {self._result.path}")
        return self._paths[0].format(name)

    @overload
    def __getitem__(self, which: str) -> NDArray[Any]: ...
    @overload
    def __getitem__(self, which: SupportsIndex) -> V: ...
    @overload
    def __getitem__(self, which: slice) -> list[V]: ...
    def __getitem__(self, which: Any) -> Any:
        if isinstance(which, str):
            return self._result.rows(self._path(which))
        if isinstance(which, slice):
            return [self[k] for k in range(*which.indices(len(self)))]
        return self._moment(index(which, len(self), self._what))

    def _ipython_key_completions_(self):
        return self._names

    def _columns(self, names):
        return {name: self._result.rows(self._path(name)) for name in names or self._names}

    @property
    def step(self) -> NDArray[np.int64]:
        """Step of each moment."""
        return self._result.rows(self._paths[1].format("step")) if self._names else np.empty(0, "i8")

    @property
    def time(self) -> NDArray[np.float64]:
        """Time of each moment."""
        return self._result.rows(self._paths[1].format("time")) if self._names else np.empty(0)

    def unit(self, name: str) -> str:
        """Unit of a column, in terms of length, mass, time."""
        return self._result.attribute(self._path(name), "unit")

    def meaning(self, name: str) -> str:
        """Meaning of a column, in a few words."""
        return self._result.attribute(self._path(name), "description")

    def __repr__(self):
        time = self.time
        return f"<slipdisk {self._what}: {len(time)} moments" + (f", time {time[0]:g} to {time[-1]:g}>" if len(time) else ">")

    def _tables(self):
        yield table_html(("name", "unit", "meaning"), [(name, self.unit(name), self.meaning(name)) for name in self._names])


class Frames(Moments[Record[NDArray[Any]]]):
    """Stored frames: frames[k]["position"] is [disk][2] of frame k, frames["position"] is [frame][disk][2] of all;
    `time`, `step`, `box` and `box_offset` of each, and frames[k].box, frames[k].box_offset."""

    def __init__(self, result, group, body):
        names = result.groups(group)
        super().__init__(result, f"frames of {body}s", names, group + "/{}/value", f"{group}/{names[0] if names else ''}/{{}}")
        self._group, self._body = group, body

    def _moment(self, k):
        edges = self._edges(k, k + 1)[0]
        return Record({**{name: self._result.rows(self._path(name), k, k + 1)[0] for name in self._names},
                       "box": edges.diagonal(), "box_offset": edges[1, 0]})

    def pandas(self, *names: str) -> pandas.DataFrame:
        """A pandas.DataFrame with a row for each frame and body: step, time, disk (or wall), and the columns of these names, or all;
        vectors as position[0], position[1]."""
        found, step, time = self._columns(names), self.step, self.time
        n = next(iter(found.values())).shape[1] if found else 0
        return to_pandas({"step": np.repeat(step, n), "time": np.repeat(time, n), self._body: np.tile(np.arange(n), len(step)),
                          **{name: column.reshape(-1, *column.shape[2:]) for name, column in found.items()}})

    def xarray(self, *names: str) -> xarray.Dataset:
        """An xarray.Dataset of the columns of these names, or all, with the dimensions time, disk (or wall) and axis."""
        found = self._columns(names)
        axes = "time", self._body, "axis"
        sizes = {axis: n for column in found.values() for axis, n in zip(axes, column.shape)}
        at = {"time": ("time", self.time), "step": ("time", self.step)}
        at.update({self._body: (self._body, np.arange(sizes[self._body]))} if self._body in sizes else {})
        at.update({"axis": ("axis", ["x", "y"])} if "axis" in sizes else {})
        return to_xarray(found, at, lambda name, column: axes[:column.ndim], self.unit, self.meaning)

    def _edges(self, first=0, last=None):
        """[frame][2][2]: edge vectors of the box of frames [first, last), in rows."""
        path = f"{self._group}/box"
        if "edges" in self._result.groups(path):
            edges = np.asarray(self._result.rows(f"{path}/edges/value", first, last), float)
        else:  # it stays as it is
            edges = np.repeat([self._result._deck_box()], (len(self) if last is None else last) - first, axis=0)
        return edges if edges.ndim == 3 else edges[:, :, np.newaxis] * np.eye(2)

    @property
    def box(self) -> NDArray[np.float64]:
        """Lengths of the periodic box in each frame, [frame][2]; 0 where it is open."""
        return self._edges().diagonal(axis1=1, axis2=2)

    @property
    def box_offset(self) -> NDArray[np.float64]:
        """By how much a row of periodic images is shifted along x against the one below, in each frame."""
        return self._edges()[:, 1, 0]


class Contacts(Moments[NDArray[np.void]]):
    """Stored contact tables: contacts[k] is a structured array of moment k, contacts["force"] a column of all moments, one after the
    other; `time`, `step` and `count` of each moment."""

    def __init__(self, result):
        names = [name for name in result.datasets("contacts") if name not in ("step", "time", "first", "count")]
        super().__init__(result, "contacts", names, "contacts/{}", "contacts/{}")
        self._first = None

    def _moment(self, k):
        if self._first is None:
            self._first = np.concatenate([[0], np.cumsum(self.count)])
        return structured({name: self._result.rows(self._path(name), self._first[k], self._first[k + 1]) for name in self._names})

    def _moments(self):
        """Step and time of each contact."""
        return {"step": np.repeat(self.step, self.count), "time": np.repeat(self.time, self.count)}

    def pandas(self, *names: str) -> pandas.DataFrame:
        """A pandas.DataFrame with a row for each contact of each moment: step, time, and the columns of these names, or all."""
        return to_pandas({**self._moments(), **self._columns(names)})

    def xarray(self, *names: str) -> xarray.Dataset:
        """An xarray.Dataset of the columns of these names, or all, with the dimension contact, and step and time of each."""
        at = {name: ("contact", values) for name, values in self._moments().items()}
        return to_xarray(self._columns(names), at, lambda name, column: ("contact",), self.unit, self.meaning)

    @property
    def count(self) -> NDArray[np.int64]:
        """Number of contacts in each table."""
        return self._result.rows("contacts/count") if self._names else np.empty(0, "i8")
