"""Damaged files in all that reads them: every command and Python's `Result` refuse them, and nothing crashes; also where no checksum
tells of the damage.
"""
import dataclasses
import json
import os
import pathlib
import shutil
import subprocess
import sys

from . import runs
from .trial import ROOT, Row

SEAL = 24  # bytes of the last mark: src/io/store/h5_seal.c
# {} is the file; what they write goes to `out`
COMMANDS = (["verify", "{}"], ["info", "{}"], ["measure", "--all", "{}"], ["export", "{}", "--to", "csv", "-o", "out"],
            ["view", "{}", "-o", "out"])
SEALING = ["verify", "--seal", "{}"]
PICTURES = ["plot", "{}", "--kind", "list"]  # starts matplotlib: of one in PLOTTED
PLOTTED = 25
NO_SEAL = "without its checksum"
BLOCK = 4096


# --- ways to alter ------------------------------------------------------------------------------------------

def flip(data, at):
    return data[:at] + bytes([data[at] ^ 0xFF]) + data[at + 1:]


def zero(data, at):
    return data[:at] + b"\0" + data[at + 1:]


def at_random(data, chance):
    """(what, bytes); never the same bytes as before"""
    while True:
        n = len(data)
        kind, at = chance.choice(("byte", "bit", "zero", "hole", "length", "swap", "longer")), chance.randrange(n)
        if kind == "byte":
            found = data[:at] + bytes([chance.randrange(256)]) + data[at + 1:]
        elif kind == "bit":
            found = data[:at] + bytes([data[at] ^ (1 << chance.randrange(8))]) + data[at + 1:]
        elif kind == "zero":
            found = zero(data, at)
        elif kind == "hole":
            at -= at % BLOCK
            found = data[:at] + bytes(len(data[at:at + BLOCK])) + data[at + BLOCK:]
        elif kind == "length":
            found = data[:at]
        elif kind == "swap":
            at, other = sorted(chance.randrange(max(n // BLOCK, 2)) * BLOCK for _ in range(2))
            found = (data[:at] + data[other:other + BLOCK] + data[at + BLOCK:other] + data[at:at + BLOCK] +
                     data[other + BLOCK:]) if other > at and other + BLOCK <= n else data
        else:
            found = data + bytes(chance.randrange(256) for _ in range(chance.choice((1, 24, 5000))))
        if found != data:
            return f"{kind} at {at}", found


def everywhere(data, most):
    """(what, bytes) of every byte inverted and zeroed, and every length; of up to `most` of each, evenly spread"""
    for at in (k - 1 for k in runs.spread(len(data), most)):
        yield f"byte {at} inverted", flip(data, at)
        if data[at]:
            yield f"byte {at} zeroed", zero(data, at)
        yield f"cut to {at} bytes", data[:at]


# --- who reads ----------------------------------------------------------------------------------------------

def without_seal(data):
    """As a version without checksums would have left it: the file does not say that it has one, either."""
    mark = data.rindex(b"slipdata") if b"slipdata" in data[-2 * SEAL:] else len(data) - SEAL
    return data[:mark].replace(b"sealed\0", b"unseal\0")


def remove(place):
    shutil.rmtree(place) if place.is_dir() else place.unlink(missing_ok=True)


def told(end, words, may_pass):
    """Nothing, or what is wrong with how a command has ended."""
    if end.status < 0:
        return f"{' '.join(words)} ends by signal {-end.status}"
    if end.status == 0:
        return "" if may_pass else f"FALSE: {' '.join(words)} takes it for sound"
    return "" if end.status in (2, 4) and end.err.strip() else f"{' '.join(words)} ends with {end.status}: {runs.first_line(end.err)}"


def _trial(reader, place, what, bytes_of, number, may_pass):
    path = place / f"{number}.h5"
    for words in (*COMMANDS, *([PICTURES] if number % PLOTTED == 0 else []), SEALING):
        path.write_bytes(bytes_of)
        call = [word.format(path.name) for word in words]
        said = told(dataclasses.replace(reader, words=call).call(place), words, may_pass or words is SEALING)
        remove(place / "out")
        if said:
            return f"number {number}, {what}: {said}"
    path.unlink()
    return ""


def commands(setup, home, name, data, many, sealed=True):
    """A row: `many` files, each damaged in one place, by all commands."""
    reader = runs.Run("damaged", setup.program, [], {}, home)
    whole = data if sealed else without_seal(data)
    (home / "sound.h5").write_bytes(whole)
    right = dataclasses.replace(reader, words=["info", "sound.h5"]).call(home)
    if right.status:
        return Row(f"commands: {name}", 1, 1, f"the sound file is refused: {runs.first_line(right.err)}")

    def one(number):
        what, bytes_of = at_random(whole, setup.random("damaged", name, number))
        place = pathlib.Path(reader.folder())
        said = _trial(reader, place, what, bytes_of, number, not sealed)
        shutil.rmtree(place)
        return said
    calls = len(COMMANDS) + 1
    return runs.together(setup, f"all commands: {name}{'' if sealed else ', ' + NO_SEAL}", range(many), one,
                         f"{calls} commands each, {len(whole)} bytes")


def results(setup, home, name, data, many, sealed=True):
    """A row: the same by Python's `Result`, many files in one interpreter."""
    whole = data if sealed else without_seal(data)
    place = home / "results"
    place.mkdir()
    for k in range(many):
        (place / f"{k}.h5").write_bytes(at_random(whole, setup.random("damaged", name, k))[1])
    (place / "sound.h5").write_bytes(whole)
    names = ["sound.h5", *(f"{k}.h5" for k in range(many))]
    env = {**os.environ, "PYTHONPATH": str(ROOT / "tools" / "python"), "SLIPDISK_PROGRAM": str(setup.program)}
    done = subprocess.run([sys.executable, "-c", READER, *names], cwd=place, env=env, capture_output=True, text=True, check=False)
    shutil.rmtree(place)
    said = done.stdout.splitlines()
    right = json.loads(said[0])[1] if said else None
    wrong = [] if right else ["the sound file is refused: " + runs.first_line(done.stderr)]
    for number, line in enumerate(said[1:]):
        file, content = json.loads(line)
        if content and sealed:
            wrong.append(f"number {number}, {file}: read as {'the sound one' if content == right else 'something else'}")
    if done.returncode:
        wrong.append(f"the interpreter ends with {done.returncode} at file {len(said)}: {runs.first_line(done.stderr)}")
    for text in wrong:
        setup.say(f"  failed: Result: {name}: {text}", flush=True)
    return Row(f"Result: {name}{'' if sealed else ', ' + NO_SEAL}", many, len(wrong), wrong[0] if wrong else f"{len(whole)} bytes")


# Prints [name, what was read, or nothing where it was refused] of each file.
READER = """
import hashlib, json, sys
import numpy
import slipdisk
def content(path):
    r = slipdisk.Result(path)
    sums = hashlib.sha256(repr(sorted(r.summary.items())).encode())
    for group in (r.series, r.state):
        for name in group:
            sums.update(numpy.ascontiguousarray(group[name]).tobytes())
    for frame in r.frames:
        for name in frame:
            sums.update(numpy.ascontiguousarray(frame[name]).tobytes())
    return sums.hexdigest()
for path in sys.argv[1:]:
    try:
        found = content(path)
    except (OSError, ValueError, KeyError, IndexError, AttributeError, TypeError, RuntimeError, MemoryError):
        found = None
    print(json.dumps([path, found]), flush=True)
"""


def rows(setup, home, files):
    """files: name -> bytes."""
    found = []
    for name, data in files.items():
        many = setup.pick(40, 1000)
        found.append(commands(setup, home, name, data, many))
        found.append(results(setup, home, name, data, setup.pick(100, 1000)))
        found.append(commands(setup, home, name, data, setup.pick(20, 1000), sealed=False))
    return found
