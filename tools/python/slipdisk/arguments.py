"""Arguments as they must be, and objects that refuse assignments without effect: nothing that is given is dropped without a word."""
from __future__ import annotations

import collections.abc
import functools
import inspect
import math
import numbers
import operator
import os
import re
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np

from .library import ReadOnly, UserError, refused_attribute

F = TypeVar("F", bound=Callable[..., Any])
ANY = None  # in a shape: a length that the caller compares


def short(value):
    """A value in a message, on one line."""
    return f"{' '.join(repr(value).split()):.80}"


# --- arrays -----------------------------------------------------------------------------------------------------------
def words(shape):
    """A shape in words: (3,), (3, 2), "one number"."""
    return "one number" if shape == () else str(shape).replace("None", "N")


def array(value, what, *shapes, kinds="iuf"):
    """Numbers of one of these shapes, as floats; ANY is any length. kinds: of numpy; "b" allows True and False."""
    try:
        given = np.asarray(value)
    except ValueError:  # rows of different length
        raise UserError(f"{what} = {short(value)}: expected numbers") from None
    if given.size and given.dtype.kind not in kinds:
        raise UserError(f"{what} = {short(value)}: expected numbers, not {type(value).__name__ if given.ndim == 0 else given.dtype}")
    if np.ma.is_masked(value):
        raise UserError(f"{what}: {np.ma.count_masked(value)} values are masked: expected numbers")
    if not any(len(shape) == given.ndim and all(n in (ANY, m) for n, m in zip(shape, given.shape)) for shape in shapes):
        raise UserError(f"{what}: expected {' or '.join(map(words, shapes))}, got {words(given.shape)}")
    return np.ascontiguousarray(given, float).reshape(given.shape)


def index(which, n, what):
    """Number 0 ... n - 1 of one that may count from the end. IndexError beyond it, as in sequences."""
    try:
        if isinstance(which, (bool, np.bool_)):
            raise TypeError
        k = operator.index(which)
    except TypeError:
        raise UserError(f"{what}[{short(which)}]: expected a whole number, a slice or a name") from None
    if not -n <= k < n:
        raise IndexError(f"{what}[{which}]: there {'is 1' if n == 1 else f'are {n}'}")
    return k % n


# --- other arguments, by their annotations --------------------------------------------------------------------------
def is_number(value):
    return isinstance(value, numbers.Real) and not isinstance(value, (bool, np.bool_)) and abs(value) < math.inf


def is_whole(value):
    return isinstance(value, numbers.Integral) and not isinstance(value, bool)


def is_path(value):
    return isinstance(value, (str, os.PathLike)) and isinstance(os.fspath(value), str) and "\0" not in os.fspath(value)


def row_of(good, n=ANY):
    """A row of n values, each of which is good."""
    return lambda value: isinstance(value, (list, tuple, np.ndarray)) and n in (ANY, len(value)) and all(map(good, value))


WHOLE, FUNCTION, ANYTHING = (is_whole, "a whole number"), (callable, "a function"), (lambda value: True, "")
TEXTS = row_of(lambda value: isinstance(value, str)), "a list of texts"
# Annotation -> is a value good? and what is expected. A new kind of argument is a row; modules add rows for classes of their own.
ARGUMENTS = {
    "None": (lambda value: value is None, "None"),
    "str": (lambda value: isinstance(value, str), "a text"),
    "bool": (lambda value: isinstance(value, (bool, np.bool_)), "True or False"),
    "int": WHOLE, "Whole": WHOLE,
    "Count": (lambda value: is_whole(value) and value > 0, "a whole number above 0"),
    "float": (is_number, "a finite number"),
    "Positive": (lambda value: is_number(value) and value > 0, "a number above 0"),
    "StrPath": (is_path, "a path"),
    "DeckLike": (lambda value: isinstance(value, dict) or is_path(value), "the path of a deck, or a dict"),
    "Mapping[str, Any]": (lambda value: isinstance(value, collections.abc.Mapping) or hasattr(value, "items"), "a dict"),
    "tuple[int, int]": (row_of(lambda value: is_whole(value) and value > 0, 2), "two whole numbers above 0"),
    "tuple[float, float]": (row_of(lambda value: is_number(value) and value > 0, 2), "two numbers above 0"),
    "Sequence[float]": (row_of(is_number, 4), "x0, x1, y0, y1, four numbers"),
    "Sequence[float | None]": (row_of(lambda value: value is None or is_number(value), 2), "from, to, two numbers or None"),
    "dict[int, Any]": (lambda value: isinstance(value, dict), "a dict"),
    "list[str]": TEXTS, "tuple[str, ...]": TEXTS,
    "Callable[[int, int], object]": FUNCTION,
    "Axes": (lambda value: hasattr(value, "plot") and hasattr(value, "transAxes"), "axes of matplotlib"),
    "Any": ANYTHING, "ArrayLike": ANYTHING, "Self": ANYTHING,  # which the function itself looks at
}


def checks(function):
    """{parameter: (is a value good?, what is expected)} of an annotated function."""
    found = {}
    for name, parameter in inspect.signature(function).parameters.items():
        if parameter.annotation is not parameter.empty:
            kinds = [ARGUMENTS[part.removeprefix("lib.")] for part in re.split(r" \| (?![^[]*\])", parameter.annotation)]
            if all(kind is not ANYTHING for kind in kinds):
                found[name] = [good for good, _ in kinds], " or ".join(dict.fromkeys(said for _, said in kinds if said != "None"))
    return found


def checked(function: F) -> F:
    """A function that refuses arguments which are not as their annotations say (ARGUMENTS)."""
    signature, expected = inspect.signature(function), checks(function)
    what = function.__qualname__.removesuffix(".__init__")

    @functools.wraps(function)
    def call(*given, **named):
        try:
            bound = signature.bind(*given, **named)
        except TypeError:
            return function(*given, **named)  # Python says what is missing
        for name, value in bound.arguments.items():
            if name in expected and not any(good(value) for good in expected[name][0]):
                raise UserError(f"{what}: {name} = {short(value)}: expected {expected[name][1]}")
            if name in expected and isinstance(value, np.ndarray):
                bound.arguments[name] = tuple(value.tolist())
        return function(*bound.args, **bound.kwargs)

    return call  # type: ignore[return-value]


# --- assignments -------------------------------------------------------------------------------------------------
def settable(kind, name):
    """Can an attribute be set? Private ones, those with a setter, and those that a subclass of the user declares in its body."""
    ours = False
    for each in kind.__mro__:
        ours = ours or each.__module__.partition(".")[0] == "slipdisk"
        if name in vars(each) or name in vars(each).get("__annotations__", ()):
            return not ours or getattr(vars(each).get(name), "fset", None) is not None
    return False


class Fixed:
    """What refuses assignments without effect (`settable`). `_set(name=value)` sets what it refuses."""

    __slots__ = ()
    _items = "its items cannot be set"

    def _set(self, **values):
        for name, value in values.items():
            object.__setattr__(self, name, value)

    if not TYPE_CHECKING:  # type checkers know what can be set; for them __setattr__ would allow all
        def __setattr__(self, name, value):
            if not name.startswith("_") and not settable(type(self), name):
                raise refused_attribute(self, name)
            object.__setattr__(self, name, value)

        def __setitem__(self, key, value):
            raise ReadOnly(f"{type(self).__name__}[{key!r:.40}]: {self._items}")
