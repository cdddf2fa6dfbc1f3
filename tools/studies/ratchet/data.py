"""Results as tables: the CSV that `slipdisk sweep` and `slipdisk theory` write, and what is missing in it."""
import csv
import math
import os

import numpy as np

DISK = "upper"


def _value(text):
    try:
        return float(text)
    except (TypeError, ValueError):
        return text or ""


def same(a, b):
    if isinstance(a, str) or isinstance(b, str):
        return a == b
    return math.isclose(a, b, rel_tol=1e-6, abs_tol=1e-12)


class Table:
    """Rows of a table, by column. `missing` lists the points that are not there, with the reason."""

    def __init__(self, rows=(), missing=(), source=""):
        self.rows, self.missing, self.source = list(rows), list(missing), source

    @classmethod
    def read(cls, path, finished_only=True, label=""):
        """A table.csv; points whose status is not "done" go to `missing`, with the label before their names."""
        if not os.path.exists(path):
            return cls(missing=[f"{label or path}: all points"], source=path)
        with open(path, newline="") as file:
            lines = [line for line in file if line.strip() and not line.startswith("#")]
        rows = [{key: _value(text) for key, text in row.items()} for row in csv.DictReader(lines)]
        missing = []
        if finished_only and rows and "status" in rows[0]:
            missing = [f"{label} {row['name']}: {row['status'] or 'not begun'}".strip() +
                       (f", {row['message']}" if row.get("message") else "") for row in rows if row["status"] != "done"]
            rows = [row for row in rows if row["status"] == "done"]
        return cls(rows, missing, path)

    def __len__(self):
        return len(self.rows)

    def __bool__(self):
        return bool(self.rows)

    def where(self, **conditions):
        """Rows in which these columns have these values; a name's dots are written as double underscores."""
        wanted = {key.replace("__", "."): value for key, value in conditions.items()}
        return Table([row for row in self.rows if all(key in row and same(row[key], value) for key,
                                                      value in wanted.items())], [], self.source)

    def such(self, condition):
        return Table([row for row in self.rows if condition(row)], [], self.source)

    def has(self, name):
        return any(isinstance(row.get(name), float) and math.isfinite(row[name]) or
                   isinstance(row.get(name), str) and row[name] for row in self.rows)

    def column(self, name):
        return np.array([row[name] if isinstance(row.get(name), float) else math.nan for row in self.rows])

    def disk(self, name):
        """A column of the upper disk."""
        return self.column(f"{DISK}.{name}")

    def values(self, name):
        """Sorted different values of a column; empty cells do not count."""
        found = []
        for row in self.rows:
            value = row.get(name, "")
            if value == "" or isinstance(value, float) and not math.isfinite(value):
                continue
            if not any(same(value, other) for other in found):
                found.append(value)
        return sorted(found, key=lambda v: (isinstance(v, str), v))

    def sorted(self, name):
        return Table(sorted((row for row in self.rows if isinstance(row.get(name), float) and math.isfinite(row[name])),
                            key=lambda row: row[name]), [], self.source)

    def sets(self):
        """A table of each set of values: its replicas."""
        found = {}
        for row in self.rows:
            found.setdefault(row.get("set", len(found)), []).append(row)
        return [Table(rows, [], self.source) for rows in found.values()]

    def joined(self):
        """One row per set: replicas averaged, errors joined; `scatter` is the standard error from the replicas."""
        rows = []
        for members in (part.rows for part in self.sets()):
            n, row = len(members), dict(members[0])
            for key in row:
                values = [m[key] for m in members]
                if n == 1 or not all(isinstance(v, float) for v in values):
                    continue
                if key.endswith("_error"):
                    row[key] = math.sqrt(sum(v * v for v in values)) / n
                elif key.endswith("force_min"):
                    row[key] = min(values)
                elif key.endswith("openings"):
                    row[key] = sum(values)
                elif key.startswith(DISK + ".") or key == "residual":
                    row[key] = sum(values) / n
            omega = [m.get(f"{DISK}.omega", math.nan) for m in members]
            row["replicas"] = float(n)
            row["scatter"] = float(np.std(omega, ddof=1) / math.sqrt(n)) if n > 1 else math.nan
            rows.append(row)
        return Table(rows, self.missing, self.source)
