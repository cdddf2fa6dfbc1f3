"""Columns by name as structured arrays, as DataFrames of pandas and as Datasets of xarray."""
from __future__ import annotations

import collections.abc
import importlib
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from .arguments import Fixed
from .library import MissingPackage, ReadOnly, UserError, V, refused_attribute
from .notebook import table_html

if TYPE_CHECKING:
    import pandas
    import xarray


def package(name):
    """A package that only some calls need."""
    try:
        return importlib.import_module(name)
    except ImportError as error:
        raise MissingPackage(f"{name} cannot be imported ({error}): python3 -m pip install {name}, or on Debian and Ubuntu "
                             f"apt install python3-{name}") from error


class Indexed:
    """A property whose value is indexed by names. IPython completes names behind result.series only if it may evaluate result.series,
    and from version 8.9 on it evaluates no `property`."""

    def __init__(self, function):
        self._function, self.__doc__ = function, function.__doc__

    def __set_name__(self, owner, name):
        self._name = name

    def __get__(self, thing, kind=None):
        return self if thing is None else self._function(thing)

    def __set__(self, thing, value):
        raise refused_attribute(thing, self._name)


if TYPE_CHECKING:
    indexed = property
else:
    indexed = Indexed


class Copied(np.ndarray):
    """A copy of a column. Writing to an element is refused, since it would not reach the simulation; `x = x + 1`,
    `x += 1` and x.copy() make ordinary arrays."""

    def __setitem__(self, key, value):
        if not self.flags.writeable:
            raise ReadOnly("this array is a copy: to change the simulation, assign a whole column, sim.disks[name] = values, "
                            "or call sim.set(name, values, disks); to change the copy, take a copy() of it")
        super().__setitem__(key, value)


def in_place(name):
    """An operator like += that leaves a copied column as it is and returns an ordinary array."""
    return lambda self, other: getattr(np.ndarray, name)(self if self.flags.writeable else np.array(self), other)


for operation in ("add", "sub", "mul", "truediv", "floordiv", "mod", "pow"):
    setattr(Copied, f"__i{operation}__", in_place(f"__i{operation}__"))


def copied(array):
    """A copy that refuses to be written to."""
    array = array.view(Copied)
    array.flags.writeable = False
    return array


def structured(columns):
    """{name: array} as one structured array."""
    rows = len(next(iter(columns.values()))) if columns else 0
    table = np.empty(rows, [(name, column.dtype, column.shape[1:]) for name, column in columns.items()])
    for name, column in columns.items():
        table[name] = column
    return table


def to_pandas(columns):
    """A pandas.DataFrame of {name: array}; of arrays with rows of several values a column each."""
    pandas, flat = package("pandas"), {}
    for name, column in columns.items():
        if column.ndim == 1:
            flat[name] = column
        else:
            flat.update((f"{name}[{k}]", part) for k, part in enumerate(column.reshape(len(column), -1).T))
    return pandas.DataFrame(flat)


def to_xarray(columns, coordinates, dimensions, unit, meaning):
    """An xarray.Dataset. dimensions(name, array): names of the dimensions of a column; coordinates: {name: (dimensions, values)};
    unit(name), meaning(name): the attributes `units` and `long_name` of a column."""
    return package("xarray").Dataset(
        {name: (dimensions(name, column), column, {"units": unit(name), "long_name": meaning(name)}) for name, column in columns.items()},
        coordinates)


class Named(Fixed, collections.abc.Mapping[str, V]):
    """Columns by name: of a mapping {name: array} with `unit(name)` and `meaning(name)`. Notebooks complete the names."""
    _dimension = "row"  # name of the dimension of rows in xarray

    def _ipython_key_completions_(self):
        return list(self)

    def _columns(self, names):
        """{name: array} of these names, or of all; arrays must be of one length."""
        found = {name: self[name] for name in names or self}
        lengths = {name: len(column) if np.ndim(column) else "one number" for name, column in found.items()}
        if len(set(lengths.values())) > 1 or "one number" in lengths.values():
            some = ", ".join(f"{name}: {n}" for name, n in list(lengths.items())[:5])
            raise UserError(f"columns of different length make no table ({some}{', ...' if len(lengths) > 5 else ''}): name some of one length")
        return found

    def array(self, *names: str) -> NDArray[np.void]:
        """The columns of these names, or all, as a structured array."""
        return structured(self._columns(names))

    def pandas(self, *names: str) -> pandas.DataFrame:
        """The columns of these names, or all, as a pandas.DataFrame."""
        return to_pandas(self._columns(names))

    def xarray(self, *names: str) -> xarray.Dataset:
        """The columns of these names, or all, as an xarray.Dataset."""
        found = self._columns(names)
        timed = [name for name in ("time", "step") if self._dimension == "time" and name in self]
        coordinates = {name: (self._dimension, found.pop(name) if name in found else self[name]) for name in timed}
        return to_xarray(found, coordinates, lambda name, column: (self._dimension, *(f"{name}_{k}" for k in range(1, column.ndim))),
                         self.unit, self.meaning)

    def __repr__(self):
        return "\n".join(f"{name:<24}{self.unit(name):<16} {self.meaning(name)}" for name in self)

    def _repr_html_(self):
        return table_html(("name", "unit", "meaning"), [(name, self.unit(name), self.meaning(name)) for name in self])
