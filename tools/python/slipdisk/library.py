"""The shared library: where it is, its functions and structs, its messages as exceptions and warnings."""
from __future__ import annotations

import contextlib
import ctypes
import difflib
import operator
import os
import pathlib
import re
import sys
import threading
import warnings
from collections.abc import Iterable
from ctypes import (POINTER, Structure, byref, c_bool, c_char_p, c_double, c_int, c_int32, c_int64, c_size_t, c_uint32,
                    c_uint64, c_void_p)
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np

HERE = pathlib.Path(__file__).resolve().parent

OK, USER, NUMERIC, IO, DOUBTFUL, INTERRUPTED = 0, 2, 3, 4, 5, 75

# Types of arguments.
StrPath = str | os.PathLike[str]
DeckLike = str | os.PathLike[str] | dict[str, Any]
Whole = int | np.integer[Any]
Count = int  # 1 or more
Positive = float
V = TypeVar("V")


# --- errors ---------------------------------------------------------------------------------------------------
class Error(Exception):
    """What went wrong: `messages` is a list of lines, `status` the exit status that the program has for it."""
    __module__ = "slipdisk"
    status: int | None = None

    def __init__(self, messages: str | Iterable[str], status: int | None = None) -> None:
        self.messages: list[str] = [messages] if isinstance(messages, str) else list(messages)
        if status is not None:
            self.status = status
        super().__init__("\n".join(self.messages))

    def __str__(self):
        return "\n".join(self.messages)

    def __reduce__(self):
        return type(self), (self.messages, self.status)


class UserError(Error, ValueError):
    """A mistake in a deck, a dict, arrays or arguments."""
    __module__ = "slipdisk"
    status = USER


class UnknownName(UserError, KeyError):
    """There is nothing of this name."""
    __module__ = "slipdisk"


class ReadOnly(UserError, AttributeError, TypeError):
    """An assignment that would have no effect: to an unknown attribute, to one that cannot be set, or to a part of a copy."""
    __module__ = "slipdisk"


class NumericError(Error, ArithmeticError):
    """A value is not finite, or an overlap is beyond the limit."""
    __module__ = "slipdisk"
    status = NUMERIC


class FileError(Error, OSError):
    """A file is missing, damaged or cannot be written; or there is no memory (OutOfMemory)."""
    __module__ = "slipdisk"
    status = IO


class OutOfMemory(FileError, MemoryError):
    """There is no memory for what was asked for. A simulation that was being changed may be lost; its calls are refused then. Where the
    library cannot say that memory is short, the interpreter ends: docs/python.md, Without memory."""
    __module__ = "slipdisk"


class Interrupted(Error):
    """The program was stopped by a signal, after a checkpoint: the same call goes on."""
    __module__ = "slipdisk"
    status = INTERRUPTED


class MissingPackage(Error, ImportError):
    """A call needs a Python package that is not installed; the message says how to install it."""
    __module__ = "slipdisk"
    status = IO


class Warning(UserWarning):  # noqa: A001  slipdisk.Warning
    """What the library or the program warns of."""


ERRORS = {kind.status: kind for kind in (UserError, NumericError, FileError, Interrupted)}


STARVED = re.compile(r"\b(no|out of|GB of) memory\b")  # in all messages of the library on memory, and in no others


def error(messages, status):
    kind = ERRORS.get(status, Error)
    if kind is FileError and any(map(STARVED.search, messages)):
        kind = OutOfMemory
    return kind(messages or [f"status {status}"], status)


def warn(lines):
    """Lines to Python's warnings, seen at the first caller outside this package."""
    frame, level = sys._getframe(), 1
    while frame.f_back and frame.f_globals.get("__name__", "").partition(".")[0] == "slipdisk":
        frame, level = frame.f_back, level + 1
    for line in lines:
        warnings.warn(line, Warning, stacklevel=level)


# --- where things are -------------------------------------------------------------------------------------------
def places(installed, built):
    """Candidates for a file: in the package (a wheel), in the installation to which it belongs, else in the checkout."""
    for up in (HERE, *HERE.parents):
        if (up / "CMakePresets.json").exists():  # a checkout
            yield from (up / "build" / build / built for build in ("release", "clang", "mpi"))
            yield up / "build" / built
            return
        yield from (path for pattern in installed for path in sorted(up.glob(pattern)))


def find(variable, installed, built, what):
    asked = os.environ.get(variable)
    candidates = [pathlib.Path(asked)] if asked else list(places(installed, built))
    for path in candidates:
        if path.exists():
            return str(path)
    tried = ", ".join(map(str, candidates)) or f"no installation above {HERE}"
    raise FileError(f"{what} not found ({tried}); build it (cmake --build --preset release) or set {variable}")


def program() -> str:
    """Path of the program `slipdisk`: SLIPDISK_PROGRAM, else that of the installation or checkout."""
    return find("SLIPDISK_PROGRAM", ["bin/slipdisk"], "slipdisk", "the program slipdisk")


def inputs() -> pathlib.Path:
    """Folder of the decks that come with slipdisk, a pathlib.Path: Simulation(slipdisk.inputs / "packing/heap.cfg")."""
    for up in (HERE, *HERE.parents):
        folder = up / ("inputs" if (up / "CMakePresets.json").exists() else "share/slipdisk/inputs")
        if folder.is_dir():
            return folder
    raise FileError(f"the decks of slipdisk are not found above {HERE}")


def lines(text):
    """The program's messages, without the words before them."""
    return [line.removeprefix("slipdisk: ").removeprefix("error: ") for line in text.splitlines() if line.strip()]


# --- structs ------------------------------------------------------------------------------------------------------
TYPES = [np.dtype("f8"), np.dtype("i8"), np.dtype("i4"), np.dtype("u4")]  # sd_type
(PER_RUN, PER_BODY, PER_FREE, PER_SURFACE, PER_CONTACT, PER_MOTION, PER_CELL, PER_CELL_DISK, PER_PHASE, PER_ROTATION,
 PER_ROTATION_BIN, PER_SLIDE, PER_SLIDE_COUNT, PER_SLIDE_CONTACT, PER_MEAN, PER_MEAN_BIN, PER_VISIT, PER_VISIT_CONTACT,
 PER_VISIT_PART, PER_VISIT_CLASS, PER_VISIT_SUM, PER_VISIT_AGE, PER_FIELDED, PER_CLUMP, PER_LAW_CONTACT,
 PER_LAW_FREE, PER_BREAK, PER_AVERAGE, PER_AVERAGE_FORM, PER_AVERAGE_BIN) = range(30)  # sd_extent

# sd_disk: a test sends one through the library and back.
DISK = np.dtype([("name", "u8"), ("position", "f8", 3), ("velocity", "f8", 3), ("radius", "f8"), ("mass", "f8"),
                 ("inertia", "f8"), ("force", "f8", 3), ("material", "i4"), ("group", "i4"), ("locked", "?", 3),
                 ("driven", "?"), ("waiting", "?"), ("clump", "i4"), ("held", "?"), ("holds", "?", 3)], align=True)


class Field(Structure):
    _fields_ = [("name", c_char_p), ("type", c_int), ("extent", c_int), ("offset", c_size_t), ("unit", c_char_p),
                ("meaning", c_char_p)]


class Deck(Structure):
    _fields_ = [("path", c_char_p), ("text", c_char_p), ("overrides", c_char_p), ("full", c_char_p),
                ("bodies", c_char_p), ("checkpoint_seconds", c_double), ("sweep_points", c_size_t)]


class Energy(Structure):
    _fields_ = [(name, c_double) for name in (
        "kinetic_translation", "kinetic_rotation", "elastic_normal", "elastic_tangential", "elastic_rolling", "elastic_bond",
        "cohesion", "external", "start", "work", "nonconservative_work", "viscous", "friction", "rolling", "bridge", "opening",
        "broken_tension", "broken_shear", "broken_bending", "drag", "damping", "relaxed", "residual", "scale")]


class Stage(Structure):
    _fields_ = [(name, c_int64) for name in ("step", "phase", "phase_step", "before")]


class Goal(Structure):
    _fields_ = [("value", c_double), ("error", c_double), ("goal", c_double), ("measured", c_double),
                ("converged", c_bool), ("reached", c_bool)]


class Rotation(Structure):
    _fields_ = [("disk", c_uint32), *((name, c_double) for name in (
        "omega", "error", "scaled", "scaled_error", "transient", "measured", "turned")), ("converged", c_bool)]


class Slide(Structure):
    _fields_ = [("disk", c_uint32), ("partner", c_uint32 * 2),
                *((name, c_double) for name in ("pp", "pm", "mp", "mm", "stick", "open")),
                *((name, c_double * 2) for name in ("contact_positive", "contact_negative", "contact_stuck",
                                                    "contact_open", "force_min")), ("openings", c_int64 * 2)]


class Configuration(Structure):
    _fields_ = [("disk", c_uint32), ("configuration", c_int32), ("steps", c_int64), ("torque", c_double),
                ("torque_sd", c_double), ("force", c_double * 2), ("force_sd", c_double * 2), ("visits", c_int64),
                ("dwell", c_double), ("dwell_sd", c_double), ("age_torque", c_double * 16), ("age_steps", c_int64 * 16)]


class DiskMean(Structure):
    _fields_ = [("disk", c_uint32), *((name, c_double) for name in (
        "omega", "error", "significance", "first", "second", "turned", "x", "y", "rms", "displacement", "coordination",
        "sliding", "force", "openings", "injected", "viscous", "friction", "opening", "translation", "rotation")),
        ("converged", c_bool)]


class Mean(Structure):
    _fields_ = [("mean", c_double), ("error", c_double), ("correlation", c_double), ("used", c_size_t),
                ("discarded", c_size_t), ("converged", c_bool)]


class Quantity(Structure):
    _fields_ = [("name", c_char_p), ("unit", c_char_p), ("meaning", c_char_p), ("json", c_char_p), ("kind", c_int),
                ("rank", c_size_t), ("shape", c_size_t * 2), ("values", POINTER(c_double))]


class Measured(Structure):
    _fields_ = [("n", c_size_t), ("quantities", POINTER(Quantity))]


class ForceColumns(Structure):
    _fields_ = [("step", c_int64), ("time", c_double), ("n_free", c_size_t), ("n_bodies", c_size_t),
                *((name, c_void_p) for name in (
                    "id", "x", "y", "theta", "turn", "vx", "vy", "omega", "radius", "mass", "inertia", "material",
                    "group", "activity", "force_x", "force_y", "torque"))]


SHARED = {"sd_field": Field, "sd_deck": Deck, "sd_energy": Energy, "sd_stage": Stage, "sd_goal": Goal, "sd_rotation": Rotation,
          "sd_slide": Slide, "sd_configuration": Configuration, "sd_disk_mean": DiskMean, "sd_mean": Mean,
          "sd_quantity": Quantity, "sd_measurement": Measured, "sd_force_columns": ForceColumns}

OBSERVER = ctypes.CFUNCTYPE(c_int, c_void_p, c_void_p)
FORCE_FIELD = ctypes.CFUNCTYPE(None, c_void_p, c_void_p)
TEXTS, OUT = POINTER(c_char_p), POINTER(c_void_p)

FUNCTIONS = {
    "sd_version": (c_char_p,),
    "sd_struct_size": (c_size_t, c_char_p),
    "sd_on_no_memory": (None, c_void_p),
    "sd_free": (None, c_void_p),
    "sd_messages_new": (c_void_p,),
    "sd_messages_free": (None, c_void_p),
    "sd_messages_clear": (None, c_void_p),
    "sd_messages_count": (c_size_t, c_void_p),
    "sd_messages_kind": (c_int, c_void_p, c_size_t),
    "sd_messages_text": (c_char_p, c_void_p, c_size_t),
    "sd_deck_load": (c_int, c_char_p, c_size_t, TEXTS, OUT, c_void_p),
    "sd_deck_load_text": (c_int, c_char_p, c_char_p, c_size_t, TEXTS, OUT, c_void_p),
    "sd_model_new": (c_void_p,),
    "sd_model_free": (None, c_void_p),
    "sd_model_advise": (None, c_void_p, c_void_p),
    "sd_model_add_disks": (c_uint32, c_void_p, c_size_t, c_void_p),
    "sd_model_disk": (c_void_p, c_void_p, c_uint32),
    "sd_model_disks": (c_size_t, c_void_p),
    "sd_model_walls": (c_size_t, c_void_p),
    "sd_model_dt": (c_double, c_void_p),
    "sd_model_steps": (c_int64, c_void_p),
    "sd_model_find": (c_uint32, c_void_p, c_char_p),
    "sd_model_body_name": (c_char_p, c_void_p, c_uint32, c_char_p, c_size_t),
    "sd_model_deck": (POINTER(Deck), c_void_p),
    "sd_simulation_new": (c_int, c_void_p, c_int, OUT, c_void_p),
    "sd_simulation_clone": (c_int, c_void_p, OUT, c_void_p),
    "sd_simulation_free": (None, c_void_p),
    "sd_simulation_advance": (c_int, c_void_p, c_int64, c_void_p),
    "sd_simulation_observe": (c_int, c_void_p, c_int64, OBSERVER, c_void_p),
    "sd_simulation_add_force_field": (c_int, c_void_p, FORCE_FIELD, c_void_p, c_void_p),
    "sd_simulation_add_disks": (c_int, c_void_p, c_size_t, c_void_p, POINTER(c_uint32), c_void_p),
    "sd_simulation_remove_disks": (c_int, c_void_p, c_size_t, c_void_p, c_void_p),
    "sd_simulation_bond": (c_int, c_void_p, c_size_t, c_void_p, c_void_p),
    "sd_simulation_set": (c_int, c_void_p, c_char_p, c_size_t, c_void_p, c_void_p, c_void_p),
    "sd_simulation_get": (c_double, c_void_p, c_char_p, c_uint32),
    "sd_simulation_index": (c_uint32, c_void_p, c_char_p, c_char_p, c_char_p),
    "sd_simulation_slot": (c_uint32, c_void_p, c_uint32),
    "sd_simulation_model": (c_void_p, c_void_p),
    "sd_simulation_step": (c_int64, c_void_p),
    "sd_simulation_time": (c_double, c_void_p),
    "sd_simulation_finished": (c_bool, c_void_p),
    "sd_simulation_state": (c_void_p, c_void_p),
    "sd_simulation_energy": (Energy, c_void_p),
    "sd_simulation_stage": (Stage, c_void_p),
    "sd_simulation_goal": (Goal, c_void_p),
    "sd_simulation_threads": (c_int, c_void_p),
    "sd_simulation_path": (c_char_p, c_void_p),
    "sd_simulation_save": (c_int, c_void_p, c_char_p, c_void_p),
    "sd_simulation_load": (c_int, c_char_p, c_int, OUT, c_void_p),
    "sd_simulation_save_memory": (c_int, c_void_p, OUT, POINTER(c_size_t), c_void_p),
    "sd_simulation_load_memory": (c_int, c_char_p, c_size_t, c_int, OUT, c_void_p),
    "sd_state_hash": (c_uint64, c_void_p),
    "sd_field_data": (c_void_p, c_void_p, POINTER(Field)),
    "sd_extent_size": (c_size_t, c_void_p, c_int),
    "sd_rotation_of": (Rotation, c_void_p, c_void_p, c_size_t),
    "sd_slide_of": (Slide, c_void_p, c_void_p, c_size_t),
    "sd_configuration_of": (Configuration, c_void_p, c_void_p, c_size_t),
    "sd_disk_mean_of": (DiskMean, c_void_p, c_void_p, c_size_t),
    "sd_mean_of": (Mean, c_void_p, c_size_t, c_bool),
    "sd_ratio_of": (Mean, c_void_p, c_void_p, c_size_t, c_bool),
    "sd_simulation_measure": (c_int, c_void_p, POINTER(c_double), c_size_t, POINTER(POINTER(Measured)), c_void_p),
    "sd_measurement_free": (None, POINTER(Measured)),
    "sd_result_open": (c_int, c_char_p, OUT, c_void_p),
    "sd_result_close": (None, c_void_p),
    "sd_set_program": (None, c_char_p),
    "sd_result_measure": (c_int, c_void_p, c_int64, POINTER(c_double), c_size_t, POINTER(POINTER(Measured)), c_void_p),
}


def load():
    name = "libslipdisk.so"
    path = find("SLIPDISK_LIBRARY", [f"lib/{name}", f"lib/*/{name}", f"lib64/{name}"], name, f"the library {name}")
    found = ctypes.CDLL(path)
    for name, (result, *arguments) in FUNCTIONS.items():
        function = getattr(found, name)
        function.restype, function.argtypes = result, arguments
    sizes = {**{name: ctypes.sizeof(struct) for name, struct in SHARED.items()}, "sd_disk": DISK.itemsize}
    others = [name for name, size in sizes.items() if found.sd_struct_size(name.encode()) != size]
    if others:
        raise FileError(f"{path}: this library is {found.sd_version().decode()}, and has other structs than the package: {', '.join(others)}")
    count = c_size_t.in_dll(found, "sd_field_count").value
    found.fields = {field.name.decode(): field for field in (Field * count).in_dll(found, "sd_fields")}
    with contextlib.suppress(FileError):  # without it the library reads files of others at once
        found.sd_set_program(os.fsencode(program()))
    found.advance = found["sd_simulation_advance"]  # for arguments that are of ctypes already
    found.sd_on_no_memory(NO_MEMORY)
    return found


SAVED = [b"nothing was saved by save()\n"]  # what the last words of the interpreter say


@ctypes.CFUNCTYPE(None, c_size_t)
def NO_MEMORY(size):
    """Ends the interpreter where the library has no memory for a small object and cannot return: its tables are half changed."""
    os.write(2, b"slipdisk: no memory (%d bytes more): the interpreter ends, since the library cannot go on; " % size + SAVED[0])
    os.abort()


def saved(path, step):
    """Tells NO_MEMORY what has been saved, in advance."""
    SAVED[0] = f"saved last: {os.fsdecode(path)}, step {step}\n".encode("utf-8", "replace")


LIBRARY = None


def library():
    """The library, loaded when it is first needed: reading results does without."""
    global LIBRARY
    if LIBRARY is None:
        LIBRARY = load()
    return LIBRARY


class Messages:
    """A list of messages of the library."""

    def __init__(self):
        self.library = library()
        self.pointer = self.library.sd_messages_new()
        if not self.pointer:
            raise MemoryError

    def __del__(self):
        if getattr(self, "pointer", None):
            self.library.sd_messages_free(self.pointer)

    def take(self):
        """(errors, warnings), lists of lines; the list is empty then."""
        found = [], []
        for k in range(self.library.sd_messages_count(self.pointer)):
            warning = self.library.sd_messages_kind(self.pointer, k) == OK
            found[warning].append(self.library.sd_messages_text(self.pointer, k).decode("utf-8", "replace"))
        self.library.sd_messages_clear(self.pointer)
        return found

    def check(self, status, line=lambda text: text):
        """Warns of warnings, and raises the error of a status."""
        errors, warned = ([line(text) for text in texts] for texts in self.take())
        warn(warned)
        if status != OK or errors:  # advice has no status
            raise error(errors, status or IO)


class Threads(threading.local):
    messages = None


THREADS = Threads()


def thread_messages():
    """A list of messages of this thread."""
    if THREADS.messages is None:
        THREADS.messages = Messages()
    return THREADS.messages


# --- arguments: ctypes takes numbers modulo 2^32, and texts up to their first null byte --------------------------
MOST_INT, MOST_STEPS = 2**31 - 1, 2**62


def whole(value, what, least, most=MOST_STEPS):
    """A whole number in a range."""
    try:
        if isinstance(value, (bool, np.bool_)):
            raise TypeError
        number = operator.index(value)
    except TypeError:
        raise UserError(f"{what} = {value!r:.80}: expected a whole number") from None
    if not least <= number <= most:
        raise UserError(f"{what} = {number}: expected {least} " + (f"... {most}" if most < MOST_STEPS or number > most else "or more"))
    return number


def octets(value, what):
    """Bytes, of anything that holds some."""
    try:
        return bytes(memoryview(value))
    except (TypeError, ValueError):
        raise UserError(f"{what}: {type(value).__name__}: expected bytes") from None


def text(value, what):
    """A text for C, in UTF-8."""
    if not isinstance(value, str):
        raise UserError(f"{what}: {value!r:.80}: expected a text")
    if "\0" in value:
        raise UserError(f"{what}: {value!r:.80}: a null byte in a text")
    return value.encode("utf-8", "surrogateescape")


def path(value):
    """The name of a file for C."""
    try:
        name = os.fsencode(value)
    except TypeError:
        raise UserError(f"{value!r:.80}: expected the path of a file") from None
    if b"\0" in name:
        raise UserError(f"{name.decode('utf-8', 'replace')!r:.80}: a null byte in the path of a file")
    return name


def structured(items, kind):
    """Structs as a structured array."""
    return np.array([np.frombuffer(item, kind)[0] for item in items], kind)


def unknown(name, names, where):
    """The error for a name that is not there."""
    near = difflib.get_close_matches(str(name), names, 1, 0.7)
    return UnknownName(f"no {name!r:.80} in {where}" + (f"; did you mean {near[0]!r}?" if near else f"; there are {', '.join(names)}"))


def refused_attribute(thing, name):
    """The error for an attribute that cannot be set."""
    kind = type(thing)
    if any(name in (*vars(each), *vars(each).get("__annotations__", ())) for each in kind.__mro__):
        return ReadOnly(f"{name} of {kind.__name__} cannot be set")
    near = difflib.get_close_matches(name, [each for each in dir(kind) if not each.startswith("_")], 1, 0.7)
    return ReadOnly(f"a {kind.__name__} has no attribute {name!r}"
                    + (f"; did you mean {near[0]!r}?" if near else "; a subclass may declare it in its body"))


def changeable(value):
    """A copy that can be changed: dicts and lists all the way down."""
    if isinstance(value, Record):
        return {name: changeable(item) for name, item in value.items()}
    if isinstance(value, tuple):
        return [changeable(item) for item in value]
    return value.copy() if isinstance(value, np.ndarray) else value


class Record(dict[str, V]):
    """A dict whose items are attributes, too. It is a copy of what was found, and cannot be changed; copy() makes a dict that can."""

    def __getattr__(self, name: str) -> V:
        if name in self:
            return self[name]
        raise AttributeError(str(unknown(name, list(self), "this record")))

    def __missing__(self, name: str) -> V:
        raise unknown(name, list(self), "this record")

    def copy(self) -> dict[str, Any]:
        """A dict of dicts and lists that can be changed."""
        return {name: changeable(item) for name, item in self.items()}

    def __reduce__(self):
        return type(self), (dict(self),)

    if not TYPE_CHECKING:
        def _refuse(self, *names: Any, **_: Any) -> None:
            raise ReadOnly(f"{names[0] if names and isinstance(names[0], str) else type(self).__name__}: this is a copy, whose change has no effect; "
                           "copy() makes a dict that can be changed")

        __setattr__ = __delattr__ = __setitem__ = __delitem__ = __ior__ = _refuse
        clear = pop = popitem = setdefault = update = _refuse

    def __dir__(self):
        return [*super().__dir__(), *self]

    def __repr__(self):
        width = max(map(len, self), default=0)
        return "\n".join(f"{name:<{width}}  {value}" for name, value in self.items())


def record(struct):
    return Record((name, getattr(struct, name)) for name, *_ in struct._fields_)


def out(kind=c_void_p):
    value = kind()
    return value, byref(value)

