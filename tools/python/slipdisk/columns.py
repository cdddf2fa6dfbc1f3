"""Columns of a simulation as numpy sees them: views of the state, copies by number of disk, what a force sees."""
from __future__ import annotations

from collections.abc import Iterator
from ctypes import byref
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import library as lib
from .arguments import Fixed, array
from .library import ReadOnly, library
from .tables import Named, copied

BODIES = lib.PER_BODY, lib.PER_FREE, lib.PER_FIELDED, lib.PER_CELL_DISK, lib.PER_LAW_FREE
LASTING = *BODIES, lib.PER_CLUMP  # their columns stay where they are
ADDED = "force_x", "force_y", "torque"  # what forces add to
SETTABLE = "x", "y", "angle", "vx", "vy", "omega", "radius", "mass", "inertia"  # of disks


class Memory:
    """Memory of the library as numpy sees it. An array made of it keeps the owner alive."""

    def __init__(self, owner, address, n, dtype, writable=False):
        self.owner = owner
        self.__array_interface__ = {"version": 3, "shape": (n,), "typestr": dtype.str, "data": (address, not writable)}


def view(owner, address, n, dtype, writable=False):
    if n == 0:
        return np.empty(0, dtype)
    return np.asarray(Memory(owner, address, n, dtype, writable))


class Columns(Named[NDArray[Any]]):
    """Columns of a simulation by name, in the order of slots; `unit` and `meaning` of each; those of one length as `array()`,
    `pandas()`, `xarray()`."""
    _dimension = "slot"
    _items = "a view of the state; sim.disks[name] = values, or sim.set(name, values, disks), changes the simulation"

    def __init__(self, simulation):
        self._simulation = simulation

    def _field(self, name):
        field = library().fields.get(name) if isinstance(name, str) else None
        if field is None:
            raise lib.unknown(name, list(self), "the columns of a simulation")
        return field

    def _array(self, state, field):
        handle = self._simulation._handle
        n = handle.library.sd_extent_size(state, field.extent)
        found = view(handle, handle.library.sd_field_data(state, byref(field)), n, lib.TYPES[field.type])
        if field.extent not in LASTING:
            return copied(found.copy())  # does not stay where it is
        if found.base is not None:
            handle.views.add(found.base)
        return found

    def __getitem__(self, name: str) -> NDArray[Any]:
        field = self._field(name)
        return self._array(self._simulation._state(), field)

    def __iter__(self) -> Iterator[str]:
        return iter(library().fields)

    def __len__(self) -> int:
        return len(library().fields)

    def unit(self, name: str) -> str:
        """Unit of a column, in terms of length, mass, time."""
        return self._field(name).unit.decode()

    def meaning(self, name: str) -> str:
        """Meaning of a column, in a few words."""
        return self._field(name).meaning.decode()


class Bodies(Named[NDArray[Any]]):
    """Copies of the columns of disks, or of walls, in the order of their numbers; `angle` is turn + theta. What only free
    disks have is nan (or -1) for others. `unit` and `meaning` of each; some or all as `array()`, `pandas()`, `xarray()`.
    disks["vx"] = values sets a column (see Simulation.set)."""

    def __init__(self, simulation, kind, first, n):
        self._slots, self._dimension, self._first, self._n = simulation.columns, kind, first, n

    def __getitem__(self, name: str) -> NDArray[Any]:
        if not isinstance(name, str) or name not in list(self):
            raise lib.unknown(name, list(self), "the columns of bodies")
        state, fields = self._slots._simulation._state(), library().fields
        number, *parts = (self._slots._array(state, fields[part])
                          for part in ("id", *(("turn", "theta") if name == "angle" else (name,))))
        values = sum(parts[1:], parts[0])
        number = number[:len(values)].astype(np.int64) - self._first
        mine = (number >= 0) & (number < self._n)
        found = np.full(self._n, np.nan if values.dtype.kind == "f" else -1).astype(values.dtype)
        found[number[mine]] = values[mine]
        return copied(found)

    def __setitem__(self, name: str, values: ArrayLike) -> None:
        """Sets a quantity of all disks, one value or a value for each. Those of disks that cannot be set, such as fixed
        ones, must be as they are."""
        simulation = self._slots._simulation
        if self._first > 0:
            raise ReadOnly("walls cannot be set; motions move them (motion.velocity, motion.amplitude)")
        if not isinstance(name, str) or name not in SETTABLE:
            raise lib.unknown(name, SETTABLE, "what can be set")
        now, new = self[name], np.broadcast_to(array(values, name, (), (self._n,)), self._n)
        changed = np.flatnonzero(~((new == now) | (np.isnan(new) & np.isnan(now))))
        if len(changed):
            simulation.set(name, new[changed], changed)

    def __iter__(self) -> Iterator[str]:
        yield "angle"
        yield from (name for name, field in library().fields.items() if field.extent in BODIES)

    def __len__(self) -> int:
        """How many columns; len(d["x"]) is how many bodies."""
        return sum(1 for _ in self)

    def unit(self, name: str) -> str:
        """Unit of a column, in terms of length, mass, time."""
        return "rad" if isinstance(name, str) and name == "angle" else self._slots.unit(name)

    def meaning(self, name: str) -> str:
        """Meaning of a column, in a few words."""
        return "angle, not wrapped: turn + theta" if isinstance(name, str) and name == "angle" else self._slots.meaning(name)


class ForceColumns(Fixed):
    """What a force field sees, by slot: `id`, `x`, `y`, `theta`, `turn`, `vx`, `vy`, `omega`, `radius`, `mass`, `inertia`,
    `material`, `group`, `activity`; `step`, `time`, `n_free`, `n_bodies`; and to be added to `force_x`, `force_y`,
    `torque`, one for each of the n_free free disks, in place: c.force_x += ... Valid during the call."""

    __slots__ = ("step", "time", "n_free", "n_bodies", *(name for name, _ in lib.ForceColumns._fields_[4:]))
    step: int
    time: float
    n_free: int
    n_bodies: int
    id: NDArray[np.uint32]
    x: NDArray[np.float64]
    y: NDArray[np.float64]
    theta: NDArray[np.float64]
    turn: NDArray[np.float64]
    vx: NDArray[np.float64]
    vy: NDArray[np.float64]
    omega: NDArray[np.float64]
    radius: NDArray[np.float64]
    mass: NDArray[np.float64]
    inertia: NDArray[np.float64]
    material: NDArray[np.int32]
    group: NDArray[np.int32]
    activity: NDArray[np.int32]
    force_x: NDArray[np.float64]
    force_y: NDArray[np.float64]
    torque: NDArray[np.float64]
    KINDS = {"id": "u4", "material": "i4", "group": "i4", "activity": "i4"}

    def __init__(self, handle, struct):
        self._set(n_free=struct.n_free, n_bodies=struct.n_bodies)
        for name, _ in struct._fields_[4:]:
            n = self.n_free if name in ADDED or name == "activity" else self.n_bodies
            column = view(handle, getattr(struct, name), n, np.dtype(self.KINDS.get(name, "f8")), name in ADDED)
            if column.base is not None:
                handle.views.add(column.base)  # one that is kept outlives the call
            self._set(**{name: column})

    if not TYPE_CHECKING:
        def __setattr__(self, name, value):
            if name in ADDED and value is not getattr(self, name):  # it is the same one in c.force_x += 1
                raise ReadOnly(f"{name}: an assigned array is not seen; a force adds to it in place: c.{name} += ..., or c.{name}[k] += ...")
            if name not in ADDED:
                super().__setattr__(name, value)
