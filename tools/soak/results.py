"""When two results are the same: in every byte of every dataset and attribute that says nothing of the run's course."""
import csv
import pathlib
import sys

import h5py
import numpy

# Times, places and names of a run: they differ from run to run.
COURSE = {"parameters@" + name for name in
          ("run_id", "started", "ended", "host", "directory", "deck_path", "sessions", "step_seconds", "wall_seconds")}
COURSE |= {"summary@step_nanoseconds"}
COST = "ns_per_step"  # the column of a sweep's tables


def _bytes(value):
    array = numpy.asarray(value)
    if array.dtype.kind == "O":  # texts of any length
        return repr(array.tolist()).encode()
    return f"{array.dtype} {array.shape} ".encode() + array.tobytes()


def content(path):
    """name -> bytes, of all datasets ("a/b") and attributes ("a/b@name"); links by what they lead to"""
    found = {}
    with h5py.File(path, "r") as file:
        def visit(name, item):
            if isinstance(item, h5py.Dataset):
                found[name] = _bytes(item[()])
            for key, value in item.attrs.items():
                found[f"{name}@{key}"] = _bytes(value)

        visit("", file)
        file.visititems(visit)
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
