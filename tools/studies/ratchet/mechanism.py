"""Shared by the sections on the mechanism: points of sweeps with their errors, and what a value depends on."""
import math

import numpy as np

from .data import DISK, Table
from .verdict import number, sliding

PI = math.pi
FEW = 4  # replicas: the scatter of fewer says little
BASE = {"theta_h": PI / 6, "tilt": 0.04 * PI, "mu": 0.1, "k_n": 1e3, "gamma_n": 10.0, "k_t": 1e6, "omega_b": 20 * PI,
        "eps_b": 1e-4, "theta_b": 0.04}


def key(row, name):
    """Value of a parameter in a row of a sweep, that of the deck where the row does not set it."""
    return row[name] if isinstance(row.get(name), float) and math.isfinite(row[name]) else BASE[name]


def all_coordinates(row):
    return "x" in (row.get("coordinates") or "x")


def name_of(configuration):
    """S with its signs in HTML; configuration: "pm" say."""
    return sliding("".join("+" if letter == "p" else "-" for letter in configuration))


def mean(members, column):
    """(mean, standard error) of a column over the replicas of a set: from their scatter, of less than four from their
    error bars where they have any."""
    values, errors = members.column(column), members.column(column + "_error")
    good = np.isfinite(values)
    values, errors = values[good], errors[good]
    n = len(values)
    if n == 0:
        return math.nan, math.nan
    if n > 1 and (n >= FEW or not np.isfinite(errors).all()):
        return float(values.mean()), float(values.std(ddof=1) / math.sqrt(n))
    return float(values.mean()), float(np.sqrt(np.sum(errors ** 2)) / n)


def points(table, unit):
    """A row for each set: its keys, and omega, error in units of unit(row)."""
    rows = []
    for members in table.sets():
        row = members.rows[0]
        value, error = mean(members, f"{DISK}.omega")
        scale = unit(row)
        rows.append({**row, "omega": value / scale, "error": error / scale, "replicas": float(len(members))})
    return Table(rows, table.missing, table.source)


def told(value, error):
    """A value with its error; without it where it is too small to be shown."""
    return number(value, error if error and error > 1e-3 * abs(value) else None)

