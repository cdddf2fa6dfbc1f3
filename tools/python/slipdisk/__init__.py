"""slipdisk from Python: simulations, results, sweeps. docs/python.md is the introduction.

Simulation   a running system, from a deck, a dict or arrays
run, sweep   runs and sweeps by the program, with results and checkpoints
Result       what a run has found, finished or not
Sweep        tables and points of a sweep
Measurement  a packing at one moment: contacts, packing fractions, stress, fabric, g(r), forces
mean         mean of a correlated record, with its error
plot, film   pictures and films, docs/plots.md
Error        what all errors derive from: UserError (UnknownName, ReadOnly), NumericError,
             FileError (OutOfMemory), Interrupted, MissingPackage
"""
from __future__ import annotations

from typing import TYPE_CHECKING, Any

from .deck import deck_text
from .library import (Error, FileError, Interrupted, MissingPackage, NumericError, OutOfMemory, ReadOnly, Record, UnknownName, UserError,
                      Warning)
from .measure import Measurement, mean
from .program import info, run, sweep
from .result import Result
from .simulation import Simulation
from .sweep import Sweep

if TYPE_CHECKING:
    import pathlib

    from . import film as film
    from . import plot as plot

__all__ = ["Error", "FileError", "Interrupted", "Measurement", "MissingPackage", "NumericError", "OutOfMemory", "ReadOnly", "Record", "Result", "Simulation",
           "Sweep", "UnknownName", "UserError", "Warning", "__version__", "deck_text", "info", "inputs", "mean", "run", "sweep", "version"]


__version__: str
inputs: pathlib.Path


def _attribute(name: str) -> Any:
    """slipdisk.plot and slipdisk.film, which need matplotlib, are loaded when they are asked for; so are the library, for its
    version, and the folder of the decks that are shipped, slipdisk.inputs."""
    if name == "__version__":
        return version()
    if name == "inputs":
        from .library import inputs
        return inputs()
    if name not in ("plot", "film"):
        raise AttributeError(f"module 'slipdisk' has no attribute {name!r}")
    import importlib
    return importlib.import_module(f"slipdisk.{name}")


def __dir__() -> list[str]:
    return sorted([*__all__, "film", "plot"])


if not TYPE_CHECKING:  # type checkers know the names above, and no others
    __getattr__ = _attribute


def version() -> str:
    """Version of the library."""
    from .library import library
    return library().sd_version().decode()
