"""A running system; see docs/python.md."""
from __future__ import annotations

import ctypes
import functools
import os
import re
import sys
import tempfile
import threading
import time as clock
import weakref
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, TypeVar, overload

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import library as lib
from . import notebook
from .arguments import ANY, Fixed, array, checked, is_number, words
from .columns import Bodies, Columns, ForceColumns
from .deck import DiskArrays, deck_text, deck_values, value_text
from .library import Messages, UserError, library, record
from .measure import Measurement, fragments, measured
from .notebook import Progress, Shown, table_html
from .tables import copied, indexed, structured

if TYPE_CHECKING:
    from typing_extensions import Self

    from .deck import Deck

NO_BODY = 0xFFFFFFFF
PIECE_SECONDS = 0.05  # at most twice this long Ctrl-C waits
ENDLESS = 2**61 - 1  # steps of a run without an end
OFTEN_SECONDS = 0.001  # shorter calls are made the shortest way
Observer = TypeVar("Observer", bound="Callable[[Any], object]")
Force = TypeVar("Force", bound="Callable[[ForceColumns], object]")


class Handle:
    """Owns what the library has made; views of columns hold on to it."""

    def __init__(self, pointer, messages, model=None):
        self.library, self.pointer, self.model = library(), pointer, model
        self.messages, self.kept = messages, []  # what is kept: functions that the library calls
        self.views = weakref.WeakSet()

    def __del__(self):
        self.library.sd_simulation_free(self.pointer)
        self.library.sd_model_free(self.model)


class Entry:
    """While a simulation with functions of its user is stepped: what is raised before such a function has begun, Ctrl-C for one, would be
    printed and lost by ctypes (it goes to sys.unraisablehook). Here it is kept, and `advance` raises it."""
    depth, before, lock = 0, None, threading.RLock()

    def __init__(self, simulation):
        self.simulation = simulation

    def __enter__(self):
        stack = entered()
        stack.append(self.simulation)
        with Entry.lock:
            Entry.depth += 1
            if sys.unraisablehook is not keep_unraised:
                Entry.before, sys.unraisablehook = sys.unraisablehook, keep_unraised

    def __exit__(self, *_):
        entered().pop()
        with Entry.lock:
            Entry.depth -= 1
            if Entry.depth == 0 and sys.unraisablehook is keep_unraised:
                sys.unraisablehook = Entry.before


STACKS = threading.local()


def entered():
    """The simulations that this thread is stepping, the innermost last."""
    if not hasattr(STACKS, "stack"):
        STACKS.stack = []
    return STACKS.stack


def keep_unraised(what):
    """Hook of Entry: `object` or `err_msg` tells a callback of ctypes, by the version of Python."""
    stack = entered()
    if stack and "ctypes callback" in (what.err_msg or ""):
        stack[-1]._keep(what.exc_value if what.exc_value is not None else what.exc_type())
    else:
        Entry.before(what)


def often(simulation, steps):
    """`advance` of a simulation for a number of steps that is given again and again: nothing but the call, since what
    stands around it costs as much as twenty steps of three disks. Every 256th call looks for warnings."""
    handle, me = simulation._handle, weakref.ref(simulation)
    call, pointer, n, messages = handle.library.advance, handle.pointer, ctypes.c_int64(steps), simulation._list
    left, thread, now = 255, threading.get_ident(), threading.get_ident

    @functools.wraps(Simulation.advance)
    def advance(given=None, *, time=None, progress=None):
        nonlocal left
        if given is steps and left and time is None and now() == thread:
            left -= 1
            status = call(pointer, n, messages)
            if status:
                me()._end(status)
            return
        left = 255
        if me() is None:
            raise ReferenceError("the simulation is gone")
        Simulation.advance(me(), given, time=time, progress=progress)

    advance.handle = handle  # which must live as long as this
    return advance


class Simulation(Fixed, Shown):
    """A running system.

    deck       path of a deck, or a dict with a deck's structure
    overrides  {path: value}, as after -D: {"gravity.tilt": "0.04 pi"}
    disks      arrays of disks: dict(x=..., y=..., radius=..., density=1.0, material="grain", ...). Keys are those of
               `disks` in decks, each an array or one value for all. Their numbers follow those of the deck's own disks.
    threads    0: chosen from the number of disks. Results do not depend on it.

    Attributes that it has not, or that cannot be set, are refused (ReadOnly); a subclass declares its own in its body (count: int = 0).

    A simulation serves one call at a time: others, of another thread or of its own observers and forces, are refused (UserError) where
    they would change what is being used. After a fork the child starts threads of its own."""

    @checked
    def __init__(self, deck: lib.DeckLike, overrides: Mapping[str, Any] | None = None, *, disks: Mapping[str, Any] | None = None,
                 threads: lib.Whole = 0) -> None:
        if "_handle" in self.__dict__:
            raise UserError("__init__: this simulation has been made; make another one")
        messages = Messages()
        threads = lib.whole(threads, "threads", 0, lib.MOST_INT)
        arrays, path = None, None
        if disks is not None:
            arrays = DiskArrays(disks)
        if isinstance(deck, dict):
            if arrays:
                deck = {**deck, "disk_files": [*deck.get("disk_files", ()), arrays.group]}
            text = deck_text(deck)
        else:
            path = deck_path(deck)
            text = arrays and read(path) + "\n" + deck_text({"disk_files": [arrays.group]})
        words = [lib.text(f"{key}={value if isinstance(value, str) else value_text(value, key)}", "overrides")
                 for key, value in (overrides or {}).items()]
        words = (ctypes.c_char_p * len(words))(*words)

        def line(message):
            message = arrays.line(message) if arrays else message
            return message if path else re.sub(r"^deck:\d+: ", "", message)

        model, at = lib.out()
        if text is None:
            status = library().sd_deck_load(lib.path(path), len(words), words, at, messages.pointer)
        else:
            status = library().sd_deck_load_text(lib.text(text, "deck"), lib.path(path or "deck"), len(words), words, at,
                                                 messages.pointer)
        if status == lib.OK:
            library().sd_model_advise(model, messages.pointer)
        pointer, at = lib.out()
        if status == lib.OK:
            status = library().sd_simulation_new(model, threads, at, messages.pointer)
        try:
            messages.check(status, line)
        except Exception:  # also a warning that is to be one
            library().sd_simulation_free(pointer)
            library().sd_model_free(model)
            raise
        self._begin(Handle(pointer, messages, model))

    def _begin(self, handle):
        self._handle, self._pointer, self._library = handle, handle.pointer, library()
        self._made_by = threading.get_ident()
        self._piece = max(1, 1_000_000 // max(1000, self.n_disks))  # steps in a call of the library
        self._again, self._raised, self._watched, self._forces = None, None, False, (None, None)

    @property
    def _messages(self):
        """A thread that is refused while another one steps has a list of its own."""
        return self._handle.messages if threading.get_ident() == self._made_by else lib.thread_messages()

    @property
    def _list(self):
        return ctypes.c_void_p(self._messages.pointer)

    @classmethod
    def _made(cls, pointer, messages):
        self = cls.__new__(cls)
        self._begin(Handle(pointer, messages))
        return self

    @classmethod
    def _load(cls, function, *arguments, threads):
        messages = Messages()
        pointer, at = lib.out()
        threads = lib.whole(threads, "threads", 0, lib.MOST_INT)
        messages.check(function(*arguments, threads, at, messages.pointer))
        return cls._made(pointer, messages)

    @classmethod
    def load(cls, path: lib.StrPath, threads: lib.Whole = 0) -> Self:
        """What `save` has written, or a checkpoint of `slipdisk run`. Observers and forces are added again."""
        return cls._load(library().sd_simulation_load, lib.path(path), threads=threads)

    @classmethod
    def from_bytes(cls, data: bytes | bytearray | memoryview, threads: lib.Whole = 0) -> Self:
        """What `to_bytes` has made."""
        data = lib.octets(data, "from_bytes")
        return cls._load(library().sd_simulation_load_memory, data, len(data), threads=threads)

    def save(self, path: lib.StrPath) -> None:
        """Writes the whole system into a file; what is loaded from it goes on with the same bits."""
        self._messages.check(self._library.sd_simulation_save(self._pointer, lib.path(path), self._list))
        lib.saved(path, self.step)

    def to_bytes(self) -> bytes:
        """The whole system as bytes: to be kept, or sent to another process (pickle does this)."""
        data, at = lib.out()
        size, size_at = lib.out(ctypes.c_size_t)
        self._messages.check(self._library.sd_simulation_save_memory(self._pointer, at, size_at, self._list))
        found = ctypes.string_at(data, size.value)
        self._library.sd_free(data)
        return found

    def __reduce__(self):
        return Simulation.from_bytes, (self.to_bytes(),)

    def clone(self) -> Self:
        """Another one at the same step, which goes on with the same bits; without observers and forces."""
        messages = Messages()
        pointer, at = lib.out()
        messages.check(self._library.sd_simulation_clone(self._pointer, at, messages.pointer))
        return self._made(pointer, messages)

    __copy__ = clone

    def __deepcopy__(self, memo: Any) -> Self:
        return self.clone()

    # --- stepping -----------------------------------------------------------------------------------------------
    def advance(self, steps: lib.Whole | None = None, *, time: float | None = None, progress: bool | None = None) -> None:
        """Advances by a whole number of steps, or by a time, or without either to the end. Stops at the end of the last
        phase, or where an observer returned True; raises what an observer or a force raised, and NumericError. A warning
        says when the run ends before the time is over, or was over before.

        progress   True, False, or None: shown in notebooks and on terminals, for calls of more than a second"""
        if time is not None:
            if steps is not None:
                raise UserError("advance: expected steps or time, not both")
            if not is_number(time) or not 0 <= time <= 1e100:
                raise UserError(f"advance: time = {time!r:.80}: expected a number from 0 to 1e100")
            steps = round(time / self.dt)
        if progress is not None and not isinstance(progress, (bool, np.bool_)):
            raise UserError(f"advance: progress = {progress!r:.80}: expected True, False or None")
        if isinstance(steps, (float, np.floating)):
            raise UserError(f"advance({steps}): expected a whole number of steps, like {steps:.0f}, or advance(time={steps})")
        if steps is None and self.steps >= ENDLESS:
            raise UserError("advance(): this run has no end (its deck gives no steps, time or phases): expected steps, or time=...")
        asked = steps
        steps = 2**62 if steps is None else lib.whole(steps, "advance: steps", 0)
        before = self.step if time is not None or self.finished else None
        if not self._handle.kept:
            stopped = self._advance(steps, progress)
        else:
            with Entry(self):
                stopped = self._advance(steps, progress)
        if before is not None and asked and not stopped and self.step - before < steps:
            ended = f"step {self.step}, time {self.time:g}"
            lib.warn([f"advance: the run was over before, at {ended}: no step was made" if self.step == before else
                      f"advance: the run ended at {ended}, {steps - (self.step - before)} of {steps} steps before the time was over"])

    def _advance(self, steps, progress):
        """True: an observer stopped it."""
        asked, took, shown = steps, 0.0, None
        if steps == 0:  # refused where any other number is
            self._messages.check(self._library.sd_simulation_advance(self._pointer, 0, self._list))
        try:
            while steps > 0 and not self.finished:
                piece, begin = min(steps, self._piece), clock.perf_counter()
                status = self._library.sd_simulation_advance(self._pointer, piece, self._list)
                if (status or self._raised is not None or self._library.sd_messages_count(self._list)) and self._end(status):
                    return True
                steps -= piece
                took = clock.perf_counter() - begin
                if took < PIECE_SECONDS and piece == self._piece:
                    self._piece *= 2
                elif took > 2 * PIECE_SECONDS and self._piece > 1:
                    self._piece //= 2
                if steps > 0 or shown:
                    shown = shown or Progress("advance", "step", progress)
                    done = asked - steps
                    shown.at(done, min(asked, self.steps - self.step + done))
        finally:
            if shown:
                shown.close()
        if (0 < took < OFTEN_SECONDS and asked <= self._piece and asked is not self._again and not self._handle.kept
                and type(self).advance is Simulation.advance):
            self._again = asked
            self._set(advance=often(self, asked))
        return False

    def _end(self, status):
        """After a piece with a status or messages; True: an observer stopped it."""
        if status == lib.USER:  # refused: what a callback has raised is for the call that goes on
            self._messages.check(status)
        raised, self._raised = self._raised, None
        if raised is not None:
            self._messages.take()
            raise raised
        if status == lib.INTERRUPTED:
            self._messages.take()
            return True
        self._messages.check(status)
        return False

    def _keep(self, error):
        if self._raised is None:
            self._raised = error

    @overload
    def observe(self, every: lib.Whole) -> Callable[[Observer], Observer]: ...
    @overload
    def observe(self, every: lib.Whole, function: Callable[[Self], object]) -> None: ...
    def observe(self, every: lib.Whole, function: Any = None) -> Any:
        """Calls function(simulation) after steps that are multiples of `every`; it only reads. When it returns True
        `advance` stops there; it may return False or nothing, all else is refused. Without a function it is a decorator: @simulation.observe(1000)."""
        if function is None:
            return lambda function: self.observe(every, function) or function
        every = lib.whole(every, "observe: every", 1)
        callable_or_refused(function, "observe")
        me = weakref.ref(self)

        def call(_pointer, _user):
            simulation = me()
            if simulation is None or simulation._raised is not None:
                return lib.INTERRUPTED
            try:
                answer = function(simulation)
                if answer is not None and not isinstance(answer, (bool, np.bool_)):
                    raise UserError(f"an observer returned {answer!r:.80}: expected True, which stops, False or nothing")
                return lib.INTERRUPTED if answer else lib.OK
            except BaseException as error:  # to be raised by advance
                simulation._keep(error)
                return lib.INTERRUPTED

        self._observe(every, call)

    def _observe(self, every, call):
        kept = lib.OBSERVER(call)
        status = self._library.sd_simulation_observe(self._pointer, every, kept, None)
        if status == lib.USER:
            raise busy("observe")
        if status != lib.OK:
            raise lib.OutOfMemory("observe: no memory")
        self._keep_function(kept)

    def _keep_function(self, kept):
        self._handle.kept.append(kept)
        self.__dict__.pop("advance", None)  # the short way knows no functions
        self._again = None

    def add_force(self, function: Force) -> Force:
        """Adds a force on the free disks: function(columns) is called in every step and adds to columns.force_x,
        .force_y, .torque in place (ForceColumns); it assigns and returns nothing. It should be a function of the columns and of
        constants. Can be a decorator."""
        callable_or_refused(function, "add_force")
        me, failed = weakref.ref(self), False
        same = lib.ForceColumns.n_free.offset  # what comes behind step and time changes seldom
        size = ctypes.sizeof(lib.ForceColumns)

        def call(pointer, _user):
            simulation = me()
            if failed or simulation is None or simulation._raised is not None:
                return
            try:
                struct, key = lib.ForceColumns.from_address(pointer), ctypes.string_at(pointer + same, size - same)
                if key != simulation._forces[0]:  # kept there: views hold the handle, which holds this function
                    simulation._forces = key, ForceColumns(simulation._handle, struct)
                columns = simulation._forces[1]
                columns._set(step=struct.step, time=struct.time)
                answer = function(columns)
                if answer is not None:
                    raise UserError(f"a force returned {type(answer).__name__}, which is not seen: it adds to c.force_x, c.force_y, c.torque "
                                    "in place (c.force_x += ...), and returns nothing")
            except BaseException as error:  # to be raised by advance
                simulation._keep(error)

        kept = lib.FORCE_FIELD(call)
        with Entry(self):
            status = self._library.sd_simulation_add_force_field(self._pointer, kept, None, self._list)
        if status == lib.OK:
            self._keep_function(kept)
        self._messages.check(status)
        if self._raised is not None:  # at step 0: as if it had not been added
            failed = True
            self._end(lib.INTERRUPTED)
        if not self._watched:  # stops at the step whose force has failed
            self._observe(1, lambda _pointer, _user: lib.OK if me()._raised is None else lib.INTERRUPTED)
            self._watched = True
        return function

    # --- disks that come and go -----------------------------------------------------------------------------------
    def add_disks(self, *, x: ArrayLike, y: ArrayLike, radius: ArrayLike, mass: ArrayLike | None = None, density: ArrayLike | None = None,
                  **columns: ArrayLike) -> NDArray[np.int64]:
        """Adds free disks between two steps; each argument is an array of shape (N,), or one number for all: x, y, radius, mass or
        density, theta, vx, vy, omega, inertia, force_x, force_y, torque, material (its number in the deck). Returns
        their numbers. Views of columns must be gone (copy what is kept); walls move up."""
        if (mass is None) == (density is None):
            raise UserError("add_disks: expected mass or density")
        given = dict(x=x, y=y, radius=radius, **columns)
        places = {"x": ("position", 0), "y": ("position", 1), "theta": ("position", 2), "vx": ("velocity", 0),
                  "vy": ("velocity", 1), "omega": ("velocity", 2), "force_x": ("force", 0), "force_y": ("force", 1),
                  "torque": ("force", 2)}
        for key in given:
            if key not in places and key not in ("radius", "inertia", "material"):
                raise UserError(f"add_disks: {key}: expected one of {', '.join([*places, 'radius, mass, density, inertia, material'])}")
        given["mass" if density is None else "density"] = mass if density is None else density
        given = {key: array(value, f"add_disks: {key}", (), (ANY,)) for key, value in given.items()}
        lengths = {key: len(column) for key, column in given.items() if column.ndim}
        n = next(iter(lengths.values()), 1)
        if len(set(lengths.values())) > 1:
            raise UserError(f"add_disks: arrays differ in length: {', '.join(f'{key} {k}' for key, k in lengths.items())}")
        if density is not None:
            with np.errstate(over="ignore"):
                given["mass"] = given.pop("density") * np.pi * np.square(given["radius"])
        material = np.atleast_1d(given.get("material", 0.0))
        wrong = material[~((material == np.floor(material)) & (material >= 0) & (material < 2**31))]
        if len(wrong):
            raise UserError(f"add_disks: material = {wrong[0]:g}: expected the number of a material")
        rows = np.zeros(n, lib.DISK)
        rows["group"] = -1
        for key, column in given.items():
            name, k = places.get(key, (key, None))
            if k is None:
                rows[name] = column
            else:
                rows[name][:, k] = column
        # refused in callbacks, whose arrays count as views
        self._messages.check(self._library.sd_simulation_add_disks(self._pointer, 0, None, None, self._list))
        self._forces = None, None
        if len(self._handle.views):
            raise BufferError("add_disks: views of columns are still in use; delete them, or keep copies")
        first, at = lib.out(ctypes.c_uint32)
        self._messages.check(self._library.sd_simulation_add_disks(self._pointer, n, rows.ctypes.data, at, self._list))
        return np.arange(first.value, first.value + n)

    def remove_disks(self, disks: ArrayLike) -> None:
        """Takes disks (numbers or names) out between two steps; they keep their numbers, with activity 2."""
        found = [self.find(d) if isinstance(d, str) else lib.whole(d, "remove_disks: disk", 0, self.n_disks - 1)
                 for d in listed(disks, "remove_disks: disks")]
        found = np.array(found, np.uint32)
        self._messages.check(self._library.sd_simulation_remove_disks(self._pointer, len(found), found.ctypes.data, self._list))

    def bond(self, a: int | str, b: int | str) -> None:
        """Bonds two bodies (numbers or names) whose gap is at most bond_gap of their law."""
        pair = [self.find(one) if isinstance(one, str) else lib.whole(one, "bond: body", 0, self.n_disks + self.n_walls - 1) for one in (a, b)]
        found = np.array(pair, np.uint32)
        self._messages.check(self._library.sd_simulation_bond(self._pointer, 1, found.ctypes.data, self._list))

    # --- steering -------------------------------------------------------------------------------------------------
    def _indices(self, name, of):
        """Indices of sd_simulation_set, of disks, motions or materials by number or name; None: all disks."""
        quantity, law = lib.text(name, "set"), str(name).startswith("law.")
        self._messages.check(self._library.sd_simulation_set(self._pointer, quantity, 0, None, None, self._list))  # is there one?
        if of is None and name == "gravity":
            return np.array([0, 1], np.uint32)
        if of is None:
            if "." in str(name):
                raise UserError(f"{name}: expected the {'material, or a pair of them' if law else 'motion'} as the last argument")
            return np.arange(self.n_disks, dtype=np.uint32)
        found = []
        for one in [of] if lone(of, law) else listed(of, f"{name}: indices"):
            pair = one if isinstance(one, tuple) else (one, None)
            if isinstance(one, tuple) and not (law and len(one) == 2):
                raise UserError(f"{name}: {one!r:.80}: expected a name or a number")
            if not isinstance(pair[0], str):
                found.append(lib.whole(one, f"{name}: index", 0, NO_BODY - 1))
                continue
            words = [None if word is None else lib.text(word, name) for word in pair]
            index = self._library.sd_simulation_index(self._pointer, quantity, *words)
            if index == NO_BODY and "." not in str(name):
                index = self.find(one)  # says what is near
            if index == NO_BODY:
                raise lib.UnknownName([f"{name}: no {'material' if law else 'motion'} is called {one!r}"])
            found.append(index)
        return np.array(found, np.uint32)

    def set(self, name: str, values: ArrayLike, of: Any = None) -> None:
        """Sets a quantity between two steps: one number for all N elements of `of`, or an array of shape (N,); of position and
        velocity (2,) or (N, 2), of gravity (2,). Its energy counts as work.

        x, y, position (x, y), angle, vx, vy, velocity (vx, vy), omega, radius, mass, inertia: of disks, by number or name
        (none: all of them). held: 1 or 0, see hold. gravity: (x, y). law.mu, law.k_n, ...: of a material or a pair of them,
        ("steel", "glass"). motion.velocity, .amplitude, .force, .pressure: of a motion. What contacts and motions do, and
        what is refused, says simulation.h (sd_simulation_set)."""
        indices = self._indices(name, of)
        shape = (len(indices), 2) if name in ("position", "velocity") else (len(indices),)
        shapes = (shape,) if name == "gravity" and of is None else (shape[1:], shape)
        given = array(values, f"set: {name}", *shapes, kinds="iufb" if name == "held" else "iuf")
        given = np.ascontiguousarray(np.broadcast_to(given, shape))
        if name == "held":  # fixed disks get other rows when they are released
            self._forces, n_free = (None, None), self._library.sd_extent_size(self._state(), lib.PER_FREE)
            fixed = any(self._library.sd_simulation_slot(self._pointer, int(k)) >= n_free for k in indices)
            if fixed and len(self._handle.views):
                raise BufferError("set: views of columns are still in use; delete them, or keep copies")
        with Entry(self):
            status = self._library.sd_simulation_set(self._pointer, lib.text(name, "set"), len(indices), indices.ctypes.data,
                                                     given.ctypes.data, self._list)
        if self._raised is not None:
            self._end(lib.INTERRUPTED)
        self._messages.check(status)

    def get(self, name: str, of: Any = None) -> Any:
        """The present value of a quantity that `set` sets, an array; one number if `of` is one."""
        lib.text(name, "get")
        if name in ("position", "velocity"):
            pair = ("x", "y") if name == "position" else ("vx", "vy")
            return copied(np.stack([self.get(part, of) for part in pair], axis=-1))
        found = [self._library.sd_simulation_get(self._pointer, lib.text(name, "get"), int(k)) for k in self._indices(name, of)]
        if any(value != value for value in found):
            raise UserError(f"{name}: {of!r:.80}: there is none of this number")
        return found[0] if of is not None and lone(of, name.startswith("law.")) else copied(np.array(found, float))

    def hold(self, disks: Any) -> None:
        """Holds disks (numbers or names; None: all) where they are: forces do not move them, motions that name them do."""
        self.set("held", 1, disks)

    def release(self, disks: Any) -> None:
        """Releases disks (numbers or names; None: all) that are fixed, moved by motions, or held. They keep their velocity."""
        self.set("held", 0, disks)

    @property
    def gravity(self) -> NDArray[np.float64]:
        """The acceleration (x, y), a copy; another one can be assigned."""
        return self.get("gravity")

    @gravity.setter
    def gravity(self, acceleration: ArrayLike) -> None:
        self.set("gravity", acceleration)

    # --- reading --------------------------------------------------------------------------------------------------
    @property
    def _model(self):
        return self._library.sd_simulation_model(self._pointer) or refused("reading")

    @property
    def step(self) -> int:
        """Steps made so far."""
        step = self._library.sd_simulation_step(self._pointer)
        return step if step >= 0 else refused("step")

    @property
    def time(self) -> float:
        """step * dt"""
        time = self._library.sd_simulation_time(self._pointer)
        return time if time == time else refused("time")

    @property
    def dt(self) -> float:
        """Time step."""
        return self._library.sd_model_dt(self._model)

    @property
    def steps(self) -> int:
        """Steps of all phases: the most that there can be."""
        return self._library.sd_model_steps(self._model)

    @property
    def finished(self) -> bool:
        """True at the end of the last phase."""
        return self._library.sd_simulation_finished(self._pointer) or self.step < 0

    @indexed
    def stage(self) -> lib.Record[int]:
        """step, phase, phase_step; before: steps of the phase before this one."""
        stage = record(self._library.sd_simulation_stage(self._pointer))
        return stage if stage.step >= 0 else refused("stage")

    @property
    def n_disks(self) -> int:
        """How many disks there are, fixed ones included."""
        return self._library.sd_model_disks(self._model)

    @property
    def n_walls(self) -> int:
        """How many walls there are."""
        return self._library.sd_model_walls(self._model)

    def find(self, name: str) -> int:
        """Number of the disk or wall of this name."""
        number = self._library.sd_model_find(self._model, lib.text(name, "find"))
        if number == NO_BODY:
            names = [self.name(k) for k in range(min(self.n_disks + self.n_walls, 100))]
            raise lib.unknown(name, names, "the names of bodies")
        return number

    def name(self, number: lib.Whole) -> str:
        """Name of a body: its own, else "disk 17", "wall 3"."""
        number = lib.whole(number, "body", -lib.MOST_STEPS)
        if not 0 <= number < self.n_disks + self.n_walls:
            raise UserError(f"body {number}: expected 0 ... {self.n_disks + self.n_walls - 1}")
        room = ctypes.create_string_buffer(256)
        name = self._library.sd_model_body_name(self._model, number, room, len(room)).decode()
        own = re.fullmatch(r'\w+ "(.*)"', name)
        return own[1] if own else name

    @indexed
    def columns(self) -> Columns:
        """columns["x"]: a read-only numpy view, without copying, in the order of slots (free disks, driven disks, walls;
        columns["id"] has their numbers). Views of bodies follow the system; others are copies of the moment."""
        return Columns(self)

    @indexed
    def disks(self) -> Bodies:
        """disks["x"]: a copy, in the order of the disks' numbers; also disks["angle"]."""
        return Bodies(self, "disk", 0, self.n_disks)

    @indexed
    def walls(self) -> Bodies:
        """The same of walls: wall w is body n_disks + w."""
        return Bodies(self, "wall", self.n_disks, self.n_walls)

    @indexed
    def contacts(self) -> NDArray[np.void]:
        """Closed contacts now, a structured array (a copy): a, b (body numbers), part, force, overlap, zeta, ..."""
        state, columns = self._state(), self.columns
        found = {name[len("contact_"):]: columns._array(state, field) for name, field in library().fields.items()
                 if field.extent in (lib.PER_CONTACT, lib.PER_LAW_CONTACT)}
        return copied(structured({name: column for name, column in found.items() if len(column) == len(found["a"])}))

    @indexed
    def breaks(self) -> NDArray[np.void]:
        """Bonds that have broken, a structured array (a copy): step, a, b (body numbers), mode (1 tension, 2 shear, 3 bending), x, y, energy."""
        state, columns = self._state(), self.columns
        return copied(structured({name[len("break_"):]: columns._array(state, field) for name, field in library().fields.items()
                                  if field.extent == lib.PER_BREAK}))

    @indexed
    def energy(self) -> lib.Record[float]:
        """The energy budget since step 0 (kinetic_translation, ..., work, viscous, friction, residual, scale)."""
        energy = record(self._library.sd_simulation_energy(self._pointer))
        return energy if energy.start == energy.start else refused("energy")

    @checked
    def measure(self, region: Sequence[float] | None = None, bins: int = 100) -> Measurement:
        """Contacts, packing fractions, stress, fabric, g(r), forces now, a Measurement: m.z, m.fraction, m.pressure, m.stress.
        region: x0, x1, y0, y1 of the part that counts, else that of the deck; bins: of each histogram."""
        return measured(self._library.sd_simulation_measure, self._pointer, region=region, bins=bins, messages=self._messages)

    @checked
    def fragments(self) -> NDArray[np.void]:
        """Bodies of bonded free disks now, single disks too, the heaviest first, a structured array: mass, disks, first (lowest number)."""
        contacts, columns = self.contacts, self.columns
        free = np.flatnonzero(columns["activity"] == 0)
        return fragments(contacts, columns["id"][free], columns["mass"][free])

    def _state(self):
        state = self._library.sd_simulation_state(self._pointer)
        if not state:
            raise busy("reading the state")
        return state

    def _measured(self, kind, function, extent):
        state, model = self._state(), self._model
        n = self._library.sd_extent_size(state, extent)
        return copied(lib.structured([function(model, state, k) for k in range(n)], kind))

    @indexed
    def rotation(self) -> NDArray[np.void]:
        """Mean angular velocity of each watched disk with its error bar, a structured array: disk, omega, error, scaled,
        scaled_error, transient, measured, turned, converged."""
        return self._measured(lib.Rotation, self._library.sd_rotation_of, lib.PER_ROTATION)

    @indexed
    def slide(self) -> NDArray[np.void]:
        """Fractions of time in each configuration of sliding, of each watched pair of contacts."""
        return self._measured(lib.Slide, self._library.sd_slide_of, lib.PER_SLIDE)

    @indexed
    def configurations(self) -> NDArray[np.void]:
        """Torque, normal forces and visits in S++, S+-, S-+, S--, stick, open of each watched pair of contacts, when the deck says
        measure = { configurations = true; }."""
        return self._measured(lib.Configuration, self._library.sd_configuration_of, lib.PER_VISIT_CLASS)

    @indexed
    def means(self) -> NDArray[np.void]:
        """Means of every free disk, when the deck says measure = { disks = true; }."""
        return self._measured(lib.DiskMean, self._library.sd_disk_mean_of, lib.PER_MEAN)

    @indexed
    def deck(self) -> Deck:
        """The complete deck with all defaults, as nested dicts: deck.gravity.tilt, deck["materials"]["grain"]["k_n"]; empty where
        `deck_full` is."""
        return deck_values(self.deck_full)

    @property
    def deck_full(self) -> str:
        """The text of the complete deck with all defaults; "" after disks were added, and of clones and saved simulations."""
        found = self._library.sd_model_deck(self._model)
        return (found.contents.full or b"").decode() if found else ""

    @property
    def threads(self) -> int:
        """Threads that it is stepped with."""
        threads = self._library.sd_simulation_threads(self._pointer)
        return threads if threads > 0 else refused("threads")

    def hash(self) -> int:
        """A number for all bits of the state: equal systems have equal ones."""
        return self._library.sd_state_hash(self._state())

    # --- notebooks ------------------------------------------------------------------------------------------------
    def view(self, height: lib.Whole = 640) -> notebook.View:
        """The page of `slipdisk view` of the present state, which a notebook shows in place: zoom in, pick disks, see forces. `height`
        is in pixels. Not of clones, of what was loaded or unpickled, or after add_disks: the page needs the deck."""
        if not self.deck_full:
            raise UserError("view: this simulation has no deck, from which the page takes walls and laws: disks were added, it is a clone, "
                            "or it was loaded; view a simulation that was made from a deck, or a result")
        with tempfile.TemporaryDirectory(prefix="slipdisk-") as folder:
            self.save(os.path.join(folder, "simulation.h5"))
            return notebook.view("simulation.h5", None, height, cwd=folder)

    def __repr__(self):
        return (f"<slipdisk.Simulation: {self.n_disks} disks, {self.n_walls} walls, step {self.step}, time {self.time:g}"
                f"{', finished' if self.finished else ''}>")

    def _tables(self):
        e = self.energy
        yield table_html((), [
            ("step", f"{self.step} of {'' if self.finished else 'at most '}{self.steps}"), ("dt", self.dt),
            ("closed contacts", len(self.contacts)), ("kinetic energy", e.kinetic_translation + e.kinetic_rotation),
            ("elastic energy", e.elastic_normal + e.elastic_tangential + e.elastic_rolling + e.elastic_bond),
            ("work", e.work + e.nonconservative_work),
            ("lost", e.viscous + e.friction + e.rolling + e.bridge + e.opening + e.broken_tension + e.broken_shear + e.broken_bending
             + e.drag + e.damping + e.relaxed),
            ("missing in the energy budget", e.residual)])


def lone(of, law):
    """Is it one index, not several? A pair of materials is one."""
    return isinstance(of, (str, bytes)) or law and isinstance(of, tuple) or not hasattr(of, "__len__")


def listed(value, what):
    """Numbers and names in a row."""
    if isinstance(value, (dict, set, frozenset)) or np.ma.is_masked(value):
        raise UserError(f"{what} = {value!r:.80}: expected numbers or names in a row")
    if isinstance(value, np.ndarray):
        if value.ndim > 1:
            raise UserError(f"{what}: expected (N,), got {words(value.shape)}")
        value = value.tolist()
    return list(value) if hasattr(value, "__len__") and not isinstance(value, (str, bytes)) else [value]


def busy(call):
    return UserError(f"{call}: not now: within a force, an observer that only reads, while another thread is in a call, or since memory "
                     "ran out in an earlier one")


def refused(call):
    raise busy(call)


def callable_or_refused(function, call):
    if not callable(function):
        raise UserError(f"{call}: {function!r}: expected a function")


def deck_path(deck):
    path = os.fspath(deck)
    if "\n" in path or ";" in path:
        raise UserError("expected the path of a deck, or a dict; this is the text of one")
    return path


def read(path):
    try:
        with open(path, encoding="utf-8") as file:
            return file.read()
    except OSError as error:
        raise lib.error([f"{path}: {error.strerror}"], lib.USER if isinstance(error, FileNotFoundError) else lib.IO) from None
