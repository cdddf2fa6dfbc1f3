"""Decks: their text from dicts and arrays (docs/deck.md), and the values of a complete deck as nested dicts."""
from __future__ import annotations

import math
import re
import tempfile
from collections.abc import Mapping
from typing import Any

import numpy as np

from .arguments import checked
from .library import Record, UserError, unknown

# Keys of `disks` that an array can give: a value per disk. Others hold for all.
COLUMNS = ("x", "y", "theta", "vx", "vy", "omega", "radius", "mass", "density", "inertia", "fixed", "name", "material", "group")
COMMON = ("locked", "force", "torque")
# Keys of the deck whose value is a list of groups, and may be a dict of named groups here.
NAMED = ("materials", "disks", "walls", "motions", "fields", "phases")


def quoted(text):
    return '"' + text.replace("\\", "\\\\").replace('"', '\\"').replace("\n", "\\n").replace("\t", "\\t") + '"'


def value_text(value, key):
    """A value as it stands in a deck; floats keep all their bits."""
    if isinstance(value, np.ndarray):
        value = value.tolist()
    elif isinstance(value, np.generic):
        value = value.item()
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, int):
        return str(value)
    if isinstance(value, float):
        if not np.isfinite(value):
            raise UserError(f"{key} = {value}: expected a finite number")
        return repr(value)
    if isinstance(value, str):
        return quoted(value)
    if isinstance(value, dict):
        return "{ " + members(value, key) + "}"
    if isinstance(value, (list, tuple)):
        return "(" + ", ".join(value_text(item, f"{key}[{k}]") for k, item in enumerate(value)) + ")"
    raise UserError(f"{key}: expected a number, text, bool, list or dict, not {type(value).__name__}")


def named(key, name, item):
    if not isinstance(item, dict):
        more = "; arrays of disks are the argument disks of Simulation" if key == "disks" else ""
        raise UserError(f"{key}.{name}: expected a dict, not {type(item).__name__}{more}")
    return {"name": name, **item}


def members(group, path=""):
    found = []
    for key, value in group.items():
        if value is None:
            continue
        if not isinstance(key, str) or not re.fullmatch(r"[A-Za-z*][-A-Za-z0-9_*]*", key):
            raise UserError(f"{path + '.' if path else ''}{key}: expected a key of a deck, a word")
        place = f"{path}.{key}" if path else key
        if not path and key in NAMED and isinstance(value, dict):
            value = [named(key, name, item) for name, item in value.items()]
        found.append(f"{key} = {value_text(value, place)};" + ("\n" if not path else " "))
    return "".join(found)


class DiskArrays:
    """Arrays of disks as a group of `disk_files`, whose table is in a temporary file until the deck is read."""

    def __init__(self, disks):
        columns, wrong = {}, []
        for key, value in disks.items():
            if np.ma.is_masked(value):
                wrong.append(f"disks.{key}: {np.ma.count_masked(value)} values are masked")
            if key not in (*COLUMNS, *COMMON):
                wrong.append(str(unknown(key, [*COLUMNS, *COMMON], "the keys of disks")))
            elif key in COLUMNS and (is_row(value) or key in ("x", "y")):
                try:
                    columns[key] = np.atleast_1d(value)
                except ValueError:  # rows of different length
                    raise UserError(f"disks.{key} = {value!r:.80}: expected a value for each disk") from None
                if columns[key].ndim != 1:
                    wrong.append(f"disks.{key}: expected one value or (N,), got {columns[key].shape}")
        lengths = {key: len(array) for key, array in columns.items()}
        most = max(lengths.values(), default=0)
        for key in ("x", "y"):
            if key in columns and not is_row(disks[key]):
                columns[key] = np.repeat(columns[key], most)
        lengths = {key: len(array) for key, array in columns.items()}
        if len(set(lengths.values())) > 1:
            wrong.append("disks: arrays differ in length: " + ", ".join(f"{key} {n}" for key, n in lengths.items()))
        wrong += [f"disks.{key}: missing" for key in ("x", "y", "radius") if key not in disks]
        if not {"mass", "density"} & set(disks):
            wrong.append("disks: expected mass or density")
        if wrong:
            raise UserError(wrong)
        common = {key: value for key, value in disks.items() if key not in columns}
        self.file = tempfile.NamedTemporaryFile("w", prefix="disks-", suffix=".csv")  # removed when it is closed
        self.file.write(",".join(columns) + "\n")
        if most:
            self.file.write("\n".join(map(",".join, zip(*map(self._cells, columns, columns.values())))) + "\n")
        self.file.flush()
        self.group = {**common, "file": self.file.name, "format": "csv"}

    @staticmethod
    def _cells(key, array):
        if array.dtype.kind == "b" and key == "fixed":
            return ["1" if cell else "0" for cell in array.tolist()]
        if array.dtype.kind in "iuf" and key != "name":
            return list(map(repr, array.tolist()))
        if array.dtype.kind in "UO":
            return list(map(str, array.tolist()))
        raise UserError(f"disks.{key}: expected numbers or texts, not {array.dtype}")

    def line(self, message):
        """A message about line n of the table is one about disk n - 2."""
        return re.sub(re.escape(self.file.name) + r"(?::(\d+))?",
                      lambda m: f"disks[{int(m[1]) - 2}]" if m[1] and int(m[1]) > 1 else "disks", message)


def is_row(value):
    return isinstance(value, (list, tuple)) or np.ndim(value) > 0


@checked
def deck_text(deck: Mapping[str, Any]) -> str:
    """The text of a deck from a dict with its structure: dicts are groups, lists and tuples lists, texts texts (also
    angles: "0.04 pi"). `materials`, `disks`, `walls`, `motions`, `fields` and `phases` may be dicts of groups by name."""
    return members(deck)


# --- complete decks as Python values ----------------------------------------------------------------------------------
# Keys whose texts stay texts even if they look like numbers: names, words of the user, files.
TEXTS = {"title", "name", "file", "dataset", "material", "materials", "group", "disk", "except", "wall", "clump", "partners", "columns",
         "path", "zip", "observable", "collect", "motions", "fields", "hold", "release", "rotation", "measure.contacts"}
TOKEN = re.compile(r"""\s+ | [#][^\n]*
                       | "(?P<text>(?:[^"\\]|\\.)*)"(?:\ /[*]\ (?P<value>\S+)\ [*]/)?
                       | (?P<number>[-+]?[.\d][-+.\w]*) | (?P<word>[A-Za-z*][-\w*]*) | (?P<mark>[{}(),;=])""", re.X | re.S)
ESCAPED = re.compile(r"\\(x[0-9A-Fa-f]{2}|.)", re.S)
LETTERS = {"n": "\n", "t": "\t", "r": "\r", "f": "\f"}
NUMBER = r"(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?"
ARITHMETIC = re.compile(rf"(?:\s|[-+*/^]|{NUMBER}|\b(?:pi|deg|rad)\b)+")
UNITS = {"pi": math.pi, "deg": math.pi / 180, "rad": 1.0}


class Groups(tuple):
    """A list of groups of a deck: deck["phases"][1], or by name deck["phases"]["measure"]."""

    def __getitem__(self, which: Any) -> Any:
        if not isinstance(which, str):
            return super().__getitem__(which)
        names = [group.get("name") for group in self]
        if which not in names:
            raise unknown(which, list(filter(None, names)), "the groups of this list")
        return super().__getitem__(names.index(which))

    def _ipython_key_completions_(self):
        return [group.name for group in self if "name" in group]

    def __repr__(self):
        return value_text(self, "deck").replace("}, {", "},\n {")


class Group(Record[Any]):
    """A group of a deck: a dict whose items are attributes."""

    def __repr__(self):
        return value_text(self, "deck")


class Deck(Group):
    """A complete deck: a dict whose items are attributes. Groups are dicts (Group), lists are tuples, those of groups also by name
    (Groups); numbers that the deck writes as text ("0.04 pi") are numbers. Simulation and run take it as a deck, with overrides:
    Simulation(sim.deck, {"dt": 1e-5}); copy() makes a dict of it that can be changed."""

    def __repr__(self):
        return deck_text(self).rstrip("\n")


def number(text):
    """A number of a deck; also "0.04 pi", "1/3 pi", "20 deg". ValueError: the text is none."""
    if not ARITHMETIC.fullmatch(text):
        raise ValueError(text)
    real = re.sub(NUMBER, lambda m: repr(float(m[0])), text)
    real = re.sub(r"(?<=[\d.])\s*(?=pi|deg|rad)", "*", real).replace("^", "**")
    try:
        return eval(real.strip(), {"__builtins__": {}}, UNITS)  # digits, operators and units only
    except SyntaxError:
        raise ValueError(text) from None


def deck_values(text: str) -> Deck:
    """A complete deck (`deck_full` of a result or simulation) as a Deck."""
    tokens, at = [], 0
    while at < len(text):
        found = TOKEN.match(text, at)
        if not found:
            raise UserError(f"deck:{text.count(chr(10), 0, at) + 1}: {text[at:at + 20]!r}: expected a deck that slipdisk has written")
        at = found.end()
        if found.lastgroup:
            tokens.append(found)
    tokens.reverse()

    def value(path, key):
        token = tokens.pop()
        if token["mark"] == "{":
            return group(key)
        if token["mark"] == "(":
            items = []
            while tokens[-1]["mark"] != ")":
                items.append(value(path, key))
                if tokens[-1]["mark"] == ",":
                    tokens.pop()
            tokens.pop()
            return (Groups if items and all(isinstance(item, Group) for item in items) else tuple)(items)
        if token["word"]:
            return token["word"] == "true"
        if token["number"]:
            digits = token["number"].rstrip("L")
            return int(digits) if re.fullmatch(r"[-+]?\d+", digits) else float(digits)
        if token["text"] is None:
            raise IndexError
        if token["value"]:  # arithmetic: the full deck has its value behind it
            return float(token["value"])
        said = ESCAPED.sub(lambda m: chr(int(m[1][1:], 16)) if m[1][0] == "x" and m[1] != "x" else LETTERS.get(m[1], m[1]), token["text"])
        if key in TEXTS or f"{path}.{key}" in TEXTS:
            return said
        try:
            return number(said)
        except ValueError:
            return said

    def group(path):
        found: dict[str, Any] = {}
        while tokens and tokens[-1]["mark"] != "}":
            key = tokens.pop()["word"]
            tokens.pop()  # =
            found[key] = value(path, key)
            tokens.pop()  # ;
        if tokens:
            tokens.pop()
        return Group(found) if path else Deck(found)

    try:
        return group("")
    except IndexError:  # a mark where a value should be, or an end
        raise UserError("deck: expected a deck that slipdisk has written") from None
