"""What `slipdisk measure` finds in a packing, as named values and arrays; docs/measure.md defines them."""
from __future__ import annotations

import collections.abc
import ctypes
import math
from collections.abc import Iterator
from ctypes import byref
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import library as lib
from .arguments import ANY, Fixed, array, checked
from .library import Messages, Record, library, record
from .tables import copied, structured

REAL, COUNT, FLAG = range(3)  # sd_quantity_kind


class Measurement(Fixed, collections.abc.Mapping[str, Any]):
    """A packing at one moment: m["z"] or m.z, m.pressure, m.stress (2 x 2), m.g (an array over m.g_edges); nan: not known.

    units, meanings   dicts with the unit and the meaning of each
    json              dict of their names in `slipdisk measure --json`, OBJECT.NAME; "": not in it"""

    units: dict[str, str]
    meanings: dict[str, str]
    json: dict[str, str]
    _items = "a measurement cannot be changed"

    def __init__(self, struct):
        self._values = {}
        self._set(units={}, meanings={}, json={})
        for q in struct.quantities[:struct.n]:
            name = q.name.decode()
            self._values[name] = value(q)
            self.units[name], self.meanings[name], self.json[name] = q.unit.decode(), q.meaning.decode(), q.json.decode()

    def __getitem__(self, name: str) -> Any:
        if not isinstance(name, str) or name not in self._values:
            raise lib.unknown(name, list(self), "a measurement")
        return self._values[name]

    def __getattr__(self, name: str) -> Any:
        try:
            return self.__dict__["_values"][name]
        except KeyError:
            raise AttributeError(str(lib.unknown(name, list(self.__dict__.get("_values", ())), "a measurement"))) from None

    def __dir__(self):
        return [*super().__dir__(), *self]

    def __iter__(self) -> Iterator[str]:
        return iter(self._values)

    def __len__(self) -> int:
        return len(self._values)

    def unit(self, name: str) -> str:
        """Unit of a value, in terms of length, mass, force, time."""
        self[name]
        return self.units[name]

    def meaning(self, name: str) -> str:
        """Meaning of a value, in a few words."""
        self[name]
        return self.meanings[name]

    def __repr__(self):
        return "\n".join(f"{name:<24}{shown(self[name]):<14}{self.units[name]:<16}{self.meanings[name]}" for name in self)


def value(q):
    """The value of a quantity of the library: a float, an int, a bool or an array."""
    if q.rank == 0:
        number = q.values[0]
        return number if q.kind == REAL or math.isnan(number) else (int, bool)[q.kind == FLAG](number)
    shape = tuple(q.shape[:q.rank])
    values = np.array(q.values[:math.prod(shape)]).reshape(shape)
    return copied(values.astype(bool) if q.kind == FLAG else values)


def shown(item):
    return f"{item:.6g}" if isinstance(item, float) else f"{item}" if np.ndim(item) == 0 else f"array {np.shape(item)}"


def measured(function, *target, region, bins, messages):
    """Calls a function of the library that measures. target: its arguments before the region."""
    bins = lib.whole(bins, "measure: bins", 1, lib.MOST_INT)
    if region is not None:
        region = (ctypes.c_double * 4)(*region)
    pointer = ctypes.POINTER(lib.Measured)()
    messages.check(function(*target, region, bins, byref(pointer), messages.pointer))
    try:
        return Measurement(pointer.contents)
    finally:
        library().sd_measurement_free(pointer)


@checked
def mean(x: ArrayLike, transient: bool = True, *, over: ArrayLike | None = None) -> Record[float]:
    """Mean of a correlated, evenly spaced record with one standard error; a Record of `mean`, `error`,
    `correlation` (time, in samples), `used`, `discarded` (as transient), `converged`. over: another record of the same length; then
    the mean of x divided by that of `over`. A nan in a record makes the mean nan."""
    first = array(x, "mean: x", (ANY,), kinds="biuf")
    records = [first] if over is None else [first, array(over, "mean: over", first.shape, kinds="biuf")]
    found = library().sd_mean_of if over is None else library().sd_ratio_of
    return record(found(*(each.ctypes.data for each in records), len(first), bool(transient)))


def stored(path, frames, region, bins):
    """Measurements of these frames of a result; -1: the last state. The file is closed again: h5py cannot open it meanwhile."""
    messages = Messages()
    result, at = lib.out()
    messages.check(library().sd_result_open(lib.path(path), at, messages.pointer))
    try:
        return [measured(library().sd_result_measure, result, k, region=region, bins=bins, messages=messages) for k in frames]
    finally:
        library().sd_result_close(result)


def fragments(contacts: NDArray[np.void], numbers: NDArray[Any], masses: NDArray[np.float64]) -> NDArray[np.void]:
    """Bodies of bonded disks, a structured array, the heaviest first: mass, disks (how many), first (lowest number of them).
    contacts: a table of contacts; numbers, masses: of the free disks. Walls and prescribed disks join nothing."""
    parent = {int(k): int(k) for k in numbers}

    def root(k):
        while parent[k] != k:
            parent[k] = k = parent[parent[k]]
        return k

    bonds = contacts[contacts["bond"] > 0] if "bond" in (contacts.dtype.names or ()) else contacts[:0]
    for a, b in zip(bonds["a"].tolist(), bonds["b"].tolist()):
        if a in parent and b in parent:
            low, high = sorted((root(a), root(b)))
            parent[high] = low
    first, body = np.unique([root(int(k)) for k in numbers], return_inverse=True)
    mass = np.bincount(body, masses, minlength=len(first))
    order = np.lexsort((first, -mass))
    return structured({"mass": mass[order], "disks": np.bincount(body, minlength=len(first))[order], "first": first[order].astype(np.uint32)})
