"""When two results are the same: in every byte of every dataset and attribute that says nothing of the run's course."""
import csv
import functools
import pathlib
import sys

import h5py
import numpy

# Times, places and names of a run: they differ from run to run.
COURSE = {"parameters@" + name for name in
          ("run_id", "started", "ended", "host", "directory", "deck_path", "sessions", "step_seconds", "wall_seconds")}
COURSE |= {"summary@step_nanoseconds"}
COST = "ns_per_step"  # the column of a sweep's tables


_name = functools.cache(str)  # of a type of numbers


def _bytes(value):
    array = numpy.asarray(value)
    if array.dtype.kind == "O":  # texts of any length
        return repr(array.tolist()).encode()
    return f"{_name(array.dtype)} {array.shape} ".encode() + array.tobytes()


def _value(item, *where):
    """What h5py itself reads, at a third of its time; None: what has no plain type."""
    dtype = item.dtype
    if dtype.hasobject or dtype.subdtype or item.get_space().get_simple_extent_type() == h5py.h5s.NULL:
        return None
    array = numpy.empty(item.shape, dtype)
    if array.size:
        item.read(*where, array)
    return array[()]


def content(path):
    """name -> bytes, of all datasets ("a/b") and attributes ("a/b@name"); links by what they lead to"""
    found = {}
    with h5py.File(path, "r") as file:
        def visit(name):
            item, name = h5py.h5o.open(file.id, name or b"/"), name.decode()
            if isinstance(item, h5py.h5d.DatasetID):
                value = _value(item, h5py.h5s.ALL, h5py.h5s.ALL)
                found[name] = _bytes(file[name][()] if value is None else value)
            for k in range(h5py.h5a.get_num_attrs(item)):
                attribute = h5py.h5a.open(item, index=k)
                key, value = attribute.name.decode(), _value(attribute)
                found[f"{name}@{key}"] = _bytes(file[name or "/"].attrs[key] if value is None else value)

        visit(b"")
        h5py.h5o.visit(file.id, visit)
    return {name: value for name, value in found.items() if name not in COURSE and COST not in name}


def differences(one, two, but=()):
    """Names of what differs between two contents; `but`: beginnings of names that do not count."""
    names = sorted(name for name in one.keys() | two.keys() if one.get(name) != two.get(name))
    return [name for name in names if not name.startswith(tuple(but))]


def table(path):
    """The rows of a sweep's CSV table, without what a step has cost."""
    with open(path, newline="") as file:
        return [{k: v for k, v in row.items() if k != COST} for row in csv.DictReader(file)]


def whole(path):
    """What a file of either kind holds, to be compared."""
    if path.suffix == ".h5":
        return content(path)
    if path.suffix == ".csv":
        return {str(k): repr(row) for k, row in enumerate(table(path))}
    return {"bytes": path.read_bytes()}


def _compare(first, others):
    """Prints for each of the others how it reads beside the first. h5py may crash with a damaged file: then nothing."""
    right = content(first)
    for path in others:
        try:
            word = "other" if differences(right, content(path)) else "same"
        except Exception:  # any kind is a refusal
            word = "refused"
        print(word, flush=True)


if __name__ == "__main__":
    _compare(pathlib.Path(sys.argv[1]), map(pathlib.Path, sys.argv[2:]))
