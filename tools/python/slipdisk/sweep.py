"""Folders that `slipdisk sweep` has made, complete or not; docs/sweep.md."""
from __future__ import annotations

import collections.abc
import csv
import os
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any, SupportsIndex, overload

import numpy as np
from numpy.typing import NDArray

from .arguments import ARGUMENTS, Fixed, checked, index
from .library import FileError, StrPath, unknown
from .notebook import Shown, array_html
from .result import NotYet, Result, plain
from .sealed import read
from .tables import indexed, structured, to_pandas

if TYPE_CHECKING:
    import pandas
    from typing_extensions import Self


class Sweep(Fixed, Shown, collections.abc.Sequence[Result]):
    """A sweep: `table` and `means` as structured arrays, and its points as results, finished or not.

    sweep["upper.omega"]   a column of the table
    sweep[17]              the Result of point 17; also by its name, "tilt=0.04pi"

    verify=False reads tables and results without comparing checksums. The table is the one that `slipdisk sweep` wrote last (every 15 s, and at the end); `refresh()` reads it again."""

    folder: str

    @checked
    def __init__(self, folder: StrPath, *, verify: bool = True) -> None:
        self._verify = verify
        self._set(folder=os.fspath(folder).rstrip("/"))
        if not os.path.isdir(os.path.join(self.folder, "points")):
            raise FileError(f"{self.folder}: not the folder of a sweep (no {self.folder}/points)")
        self.refresh()

    def refresh(self) -> Self:
        """Reads the tables again. Returns self."""
        path = os.path.join(self.folder, "table.h5")
        self._units, self._columns, self._means, self._sources = {}, {}, {}, {}
        if os.path.exists(path):
            try:
                with read(path, self._verify) as file:
                    self._columns = self._read(file, "points", "table.csv")
                    self._means = self._read(file, "means", "means.csv")
            except FileError:
                raise
            except OSError as error:
                raise FileError(f"{path}: {error}") from None
        return self

    def _read(self, file, group, ordered):
        columns = {}
        for name, item in file.get(group, {}).items():
            self._units[name] = plain(item.attrs.get("unit", ""))
            values = item[:]
            columns[name] = np.array(plain(values), str) if values.dtype.kind in "SO" else values
        try:  # HDF5 has its datasets by name
            with open(os.path.join(self.folder, ordered), newline="", encoding="utf-8") as table:
                names = [name for name in next(csv.reader(table), []) if name in columns]
        except OSError:
            names = []
        return {name: columns[name] for name in [*names, *(name for name in columns if name not in names)]}

    def _known(self, columns):
        if not columns:
            raise FileError(f"{self.folder}: no table yet; slipdisk sweep DECK -o {self.folder} --table makes it")
        return columns

    @indexed
    def table(self) -> NDArray[np.void]:
        """A row for each point: what it sets, and what was found; nan where it is not finished."""
        return structured(self._known(self._columns))

    @indexed
    def done(self) -> NDArray[np.void]:
        """The rows of the table that are finished."""
        return self.table[self["status"] == "done"]

    @indexed
    def means(self) -> NDArray[np.void]:
        """A row for each set of values: means over the replicas, with `_error` and `_scatter`."""
        return structured(self._known(self._means))

    @checked
    def pandas(self, means: bool = False) -> pandas.DataFrame:
        """The table, or the means, as a pandas.DataFrame."""
        return to_pandas(self._known(self._means if means else self._columns))

    def unit(self, name: str) -> str:
        """Unit of a column of the table."""
        if not isinstance(name, str) or name not in self._units:
            raise unknown(name, list(self._units), f"the table of {self.folder}")
        return self._units[name]

    @property
    def names(self) -> list[str]:
        """Names of the points: all that the table has, else those that are begun."""
        if self._columns:
            return self._columns["name"].tolist()
        found = os.listdir(os.path.join(self.folder, "points"))
        return sorted({name.removesuffix(".parts").removesuffix(".h5") for name in found if name.endswith((".h5", ".h5.parts"))})

    @checked
    def path(self, name: str) -> str:
        """Path of the result of a point."""
        return os.path.join(self.folder, "points", name + ".h5")

    def _result(self, name):
        return Result(self.path(name), verify=self._verify)

    def __len__(self) -> int:
        return len(self.names)

    @overload
    def __getitem__(self, which: str) -> Any: ...
    @overload
    def __getitem__(self, which: SupportsIndex) -> Result: ...
    @overload
    def __getitem__(self, which: slice) -> list[Result]: ...
    def __getitem__(self, which: Any) -> Any:
        if isinstance(which, str):
            if which in self._columns:
                return self._columns[which]
            if which in self.names:
                return self._result(which)
            raise unknown(which, [*self._columns, *self.names], f"the table of {self.folder}")
        if isinstance(which, slice):
            return [self[k] for k in range(*which.indices(len(self)))]
        return self._result(self.names[index(which, len(self), "sweep")])

    def results(self) -> Iterator[tuple[str, Result]]:
        """(name, Result) of all points that have any result."""
        for name in self.names:
            if os.path.exists(self.path(name)) or os.path.exists(self.path(name) + ".parts"):
                try:
                    yield name, self._result(name)
                except NotYet:
                    continue  # begun, without a checkpoint

    def __repr__(self):
        done = int(np.sum(self._columns["status"] == "done")) if self._columns else "?"
        return f"<slipdisk.Sweep {self.folder!r}: {len(self)} points, {done} done>"

    def _tables(self):
        table = self._means or self._columns
        if table:
            yield array_html(structured(table))

    def _ipython_key_completions_(self):
        return [*self._columns, *self.names]


ARGUMENTS["Sweep"] = (lambda value: isinstance(value, Sweep)), "a Sweep"
