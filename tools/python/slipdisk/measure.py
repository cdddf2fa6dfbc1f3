"""What `slipdisk measure` finds in a packing, as named values and arrays; docs/measure.md defines them."""
from __future__ import annotations

import collections.abc
import ctypes
import math
from collections.abc import Iterator
from ctypes import byref
from typing import Any

import numpy as np

from . import library as lib
from .library import Messages, UserError, library

REAL, COUNT, FLAG = range(3)  # sd_quantity_kind


class Measurement(collections.abc.Mapping[str, Any]):
    """A packing at one moment: m["z"] or m.z, m.pressure, m.stress (2 x 2), m.g (an array over m.g_edges); nan: not known.

    units, meanings   dicts with the unit and the meaning of each
    json              dict of their names in `slipdisk measure --json`, OBJECT.NAME; "": not in it"""

    def __init__(self, struct):
        self._values, self.units, self.meanings, self.json = {}, {}, {}, {}
        for q in struct.quantities[:struct.n]:
            name = q.name.decode()
            self._values[name] = value(q)
            self.units[name], self.meanings[name], self.json[name] = q.unit.decode(), q.meaning.decode(), q.json.decode()

    def __getitem__(self, name: str) -> Any:
        if name not in self._values:
            raise lib.unknown(name, list(self), "a measurement")
        return self._values[name]

    def __getattr__(self, name: str) -> Any:
        try:
            return self.__dict__["_values"][name]
        except KeyError:
            raise AttributeError(f"no {name!r} in a measurement") from None

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
    array = np.array(q.values[:math.prod(shape)]).reshape(shape)
    return array.astype(bool) if q.kind == FLAG else array


def shown(item):
    return f"{item:.6g}" if isinstance(item, float) else f"{item}" if np.ndim(item) == 0 else f"array {np.shape(item)}"


def measured(function, *target, region, bins, messages, level=2):
    """Calls a function of the library that measures. target: its arguments before the region."""
    bins = lib.whole(bins, "measure: bins", 1, lib.MOST_INT)
    if region is not None:
        try:
            edges = np.asarray(region, float)
            if edges.shape != (4,):
                raise ValueError
            region = (ctypes.c_double * 4)(*edges)
        except (TypeError, ValueError):
            raise UserError(f"measure: region = {region!r:.80}: expected x0, x1, y0, y1") from None
    pointer = ctypes.POINTER(lib.Measured)()
    messages.check(function(*target, region, bins, byref(pointer), messages.pointer), level=level + 1)
    try:
        return Measurement(pointer.contents)
    finally:
        library().sd_measurement_free(pointer)


def stored(path, frames, region, bins):
    """Measurements of these frames of a result; -1: the last state. The file is closed again: h5py cannot open it meanwhile."""
    messages = Messages()
    result, at = lib.out()
    messages.check(library().sd_result_open(lib.path(path), at, messages.pointer), level=3)
    try:
        return [measured(library().sd_result_measure, result, k, region=region, bins=bins, messages=messages, level=3) for k in frames]
    finally:
        library().sd_result_close(result)
