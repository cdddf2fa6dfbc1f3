"""slipdisk from Python: simulations, results, sweeps. docs/python.md is the introduction.

Simulation   a running system, from a deck, a dict or arrays
run, sweep   runs and sweeps by the program, with results and checkpoints
Result       what a run has found, finished or not
Sweep        tables and points of a sweep
Measurement  a packing at one moment: contacts, packing fractions, stress, fabric, g(r), forces
mean         mean of a correlated record, with its error
plot, film   pictures and films, docs/plots.md
Error        what all errors derive from: UserError, NumericError, FileError, Interrupted
"""
from .deck import deck_text
from .library import (Error, FileError, Interrupted, NumericError, Record, UnknownName, UserError, Warning, mean)
from .measure import Measurement
from .program import info, run, sweep
from .result import Result
from .simulation import Simulation
from .sweep import Sweep

__all__ = ["Error", "FileError", "Interrupted", "Measurement", "NumericError", "Record", "Result", "Simulation", "Sweep", "UnknownName",
           "UserError",
           "Warning", "deck_text", "info", "mean", "run", "sweep", "version"]


def __getattr__(name):
    """slipdisk.plot and slipdisk.film, which need matplotlib, are loaded when they are asked for."""
    if name not in ("plot", "film"):
        raise AttributeError(f"module 'slipdisk' has no attribute {name!r}")
    import importlib
    return importlib.import_module(f"slipdisk.{name}")


def version():
    """Version of the library."""
    from .library import library
    return library().sd_version().decode()
