"""The numbers behind figures and tables as CSV: written beside the results, kept in docs/studies/data, and
read back from there where there are no results."""
import csv
import glob
import io
import math
import os
import shutil

import numpy as np

from .data import Table

CURVE = 500  # rows of a curve that is drawn
DIGITS = 8  # significant; what is drawn and judged has been rounded so, from results as from kept files
LOG = []  # sections as they begin, and names of numbers as they are asked for: which section is drawn from which


def assign(sections, there):
    """Gives the sections of one module the names of the numbers that they were made from, of those there are: asked
    for since each began, and before the first."""
    common, here = [], None
    for item in LOG:
        if not isinstance(item, str):
            here = item if any(item is section for section in sections) else here
        elif here is None:
            common.append(item)
        else:
            here.data.append(item)
    for section in sections:
        section.data[:] = sorted({name for name in common + section.data if name in there and name != "missing"})
    LOG.clear()


def rows_of(found):
    """Rows of a table, of {column: values} or of {column: value}; none of None."""
    if found is None:
        return []
    if isinstance(found, Table):
        return found.rows
    if not any(np.ndim(values) for values in found.values()):
        return [dict(found)] if found else []
    sizes = {name: len(values) for name, values in found.items()}
    if len(set(sizes.values())) > 1:
        raise ValueError(f"columns of different lengths: {sizes}")
    return [dict(zip(found, row)) for row in zip(*found.values())]


def thin(found, most=None):
    """A table or columns with every n-th row, and with the last one, so that there are not many more than `most`."""
    rows = rows_of(found)
    step = max(1, math.ceil((len(rows) - 1) / (most or CURVE)))
    return Table(rows[::step] + (rows[-1:] if (len(rows) - 1) % step else []))


def flatten(value, path=""):
    """{"a.0.b": value} of nested dictionaries and lists."""
    parts = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else None
    if parts is None:
        return {} if value is None else {path: value}
    return {key: cell for name, part in parts for key, cell in flatten(part, f"{path}.{name}".lstrip(".")).items()}


def nested(flat):
    """What flatten() has flattened; whole keys are those of lists."""
    found = {}
    for path, value in flat.items():
        here, names = found, path.split(".")
        for name in names[:-1]:
            here = here.setdefault(name, {})
        here[names[-1]] = value

    def lists(part):
        if not isinstance(part, dict):
            return part
        if part and all(key.isdigit() for key in part):
            return [lists(part[key]) for key in sorted(part, key=int)]
        return {key: lists(value) for key, value in part.items()}

    return lists(found)


def text_of(value, digits):
    """A cell: numbers with so many significant digits, whole ones with all of theirs; nothing for nan."""
    if value is None or isinstance(value, str):
        return value or ""
    value = float(value)
    if not math.isfinite(value):
        return ""
    if value == int(value) and abs(value) < 2 ** 53:
        return str(int(value))
    return f"{value:.{digits}g}"


def csv_text(rows, digits=DIGITS, head=()):
    out = io.StringIO()
    for line in head:
        out.write(f"# {' '.join(str(line).split())}\n")
    columns = list(dict.fromkeys(key for row in rows for key in row))
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow(columns)
    for row in rows:
        places = digits if isinstance(digits, int) else None
        writer.writerow([text_of(row.get(key), places or digits.get(key, DIGITS)) for key in columns])
    return out.getvalue()


def head_of(path):
    """{key: text} of the lines "# key: text" of a kept file."""
    found = {}
    with open(path) as file:
        for line in file:
            if not line.startswith("#"):
                break
            key, _, text = line[1:].partition(":")
            found[key.strip()] = text.strip()
    return found


INDEX = "index.csv"
README = """# Numbers behind the figures

Every figure and table of [paper.md](../paper.md) and [packings_study.md](../packings_study.md) as CSV: all points
with their parameters, seeds, steps and error bars.

Lines with `#` at the head of a file: what it holds, program and revision and machine that computed it, the level, and
the command with all keys that differ from the deck. Empty cells have no value. Angles are in radians; lengths, times
and angular velocities in the units of the deck: the paper's ($R = mg = 1$, $g = 10$), SI for the vibrated packings.
Columns of sweeps are those of [names.md](../../names.md). Numbers are rounded to 8 significant digits, those of sweeps
to 10, per-disk columns to 4 to 6.

`tools/studies/ratchet.sh --draw` and `tools/studies/packings.sh --draw` redraw all figures from these files alone: in
a fresh clone, without results and without the program. `--keep docs/studies` writes them anew from results.

`sweep-`: all points of a sweep; `theory-`: curves of theory; `info-`: what `slipdisk info` says of a run; `table-`:
tables as the page shows them; `runs-`, `disks-`, `contacts-`, `walls-`: runs of packings.

`shear`: mu(I) of [rheology.md](../rheology.md), by `tools/studies/rheology.sh` (the revision of all but rheology-more.csv is in the
history only as a part of version 0.5.0).
"""


class NotKept(Exception):
    """A result is asked for more than is kept of it: numbers that need it are read from their own file."""


class Store:
    """CSV files of one page in a folder, by name; `kept`: folder of those kept with the sources, "" for none."""

    def __init__(self, folder, kept=""):
        self.folder, self.kept = folder, kept
        self.used, self.from_kept = {}, []  # {name: path} of this page; those of them that were read from `kept`

    def about(self):
        """Head of the kept files: level, program, machine; empty where nothing is kept."""
        for path in sorted(glob.glob(os.path.join(self.kept, "*.csv"))) if self.kept else []:
            found = head_of(path)
            if "level" in found:
                return found
        return {}

    def path(self, name):
        """Where the numbers of this name are: written by this page, else kept; None for neither."""
        if name not in self.used and self.kept:
            path = os.path.join(self.kept, name + ".csv")
            if os.path.exists(path):
                self.used[name] = path
                self.from_kept.append(name)
        return self.used.get(name)

    def write(self, name, rows, digits=DIGITS, head=()):
        self.write_text(name, csv_text(rows, digits, head))

    def write_text(self, name, text):
        os.makedirs(self.folder, exist_ok=True)
        path = os.path.join(self.folder, name + ".csv")
        with open(path + ".new", "w") as file:
            file.write(text)
        os.replace(path + ".new", path)
        self.used[name] = path

    def keep(self, folder, sections, all_of_it):
        """Copies the files of this page to a folder, with a list of what is drawn from which; all_of_it: others there
        are of no page any more."""
        os.makedirs(folder, exist_ok=True)
        for name, path in self.used.items():
            place = os.path.join(folder, name + ".csv")
            if os.path.abspath(place) != os.path.abspath(path):
                shutil.copyfile(path, place)
        for path in glob.glob(os.path.join(folder, "*.csv")) if all_of_it else []:
            if os.path.basename(path)[:-len(".csv")] not in self.used and os.path.basename(path) != INDEX:
                os.remove(path)
        rows = []
        for section in sections:
            tables = [section.table_name(k) for k in range(len(section.tables))]
            rows += [{"figure": figure.name, "section": section.key, "numbers": " ".join(section.data),
                      "tables": " ".join(tables)} for figure in section.figures or [Nothing] if tables or section.data]
        with open(os.path.join(folder, INDEX), "w") as file:
            file.write(csv_text(rows))
        write_readme(os.path.dirname(folder))


class Nothing:
    """In place of a figure."""
    name = ""


def write_readme(folder):
    """README.md of docs/studies/data: which file belongs to which figure, of all pages."""
    with open(os.path.join(folder, "README.md"), "w") as file:
        file.write(README)
        for path in sorted(glob.glob(os.path.join(folder, "*", INDEX))):
            page = os.path.basename(os.path.dirname(path))
            file.write(f"\n## {page}\n\n| figure | section of the page | numbers behind it | tables "
                       "|\n|---|---|---|---|\n")
            for row in Table.read(path).rows:
                links = [", ".join(f"[{name}]({page}/{name}.csv)" for name in row[key].split()) for key in ("numbers",
                                                                                                            "tables")]
                file.write(f"| {row['figure']} | {row['section']} | {' | '.join(links)} |\n")
