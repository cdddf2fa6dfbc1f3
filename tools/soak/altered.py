"""Files with other bytes than those that were written: refused with a message, or read as if nothing had been altered.
`verify` finds every alteration. Files of other versions and programs are named."""
import dataclasses
import re
import shutil
import subprocess
import sys

import h5py
import numpy

from . import damaged, faults, inject, kill, results, runs
from .damaged import at_random, everywhere, flip  # noqa: F401
from .inject import Fault
from .trial import Row

TINY = """dt = 1e-6; gravity = { g = 10; tilt = 0.1; };
materials = ( { name = "disk"; k_n = 1e3; k_t = 1e6; gamma_n = 10; mu = 0.1; } );
disks = ( { name = "upper"; x = 0; y = 0; radius = 1; mass = 0.1; },
  { x = -1; y = -1.7320508075688772; radius = 1; mass = 0.1; fixed = true; },
  { x = 1; y = -1.7320508075688772; radius = 1; mass = 0.1; fixed = true; } );
phases = ( { name = "measure"; steps = 2000; } ); output = { series = 500; frames = 1000; contacts = 1000; };
measure = { rotation = (); }; checkpoint = 1e-9;
"""
READERS = (["info"], ["info", "--json"], ["info", "--deck"], ["measure"], ["measure", "--json"], ["measure", "--all"])
BATCH = 200  # files of one call of verify


# --- verify -------------------------------------------------------------------------------------------------

def _batches(found):
    batch = []
    for item in found:
        batch.append(item)
        if len(batch) == BATCH:
            yield batch
            batch = []
    if batch:
        yield batch


def _verified(setup, home, name, data, found):
    """Every altered file is called damaged, and the unaltered one sound."""
    place = home / f"verify-{name}".replace(" ", "-")
    place.mkdir()
    trials, said = 0, []
    program = runs.Run("verify", setup.program, ["verify", "good.h5"], {}, home)
    (place / "good.h5").write_bytes(data)
    if program.call(place).status != 0:
        said.append("the unaltered file is called damaged")
    for batch in _batches(found):
        for k, (_, altered) in enumerate(batch):
            (place / f"{k}.h5").write_bytes(altered)
        end = dataclasses.replace(program, words=["verify", *(f"{k}.h5" for k in range(len(batch)))]).call(place)
        sound = {line.split(":")[0] for line in end.out.splitlines() if ": sound" in line}
        said += [f"{what}: called sound" for k, (what, _) in enumerate(batch) if f"{k}.h5" in sound]
        if end.status != 4:
            said.append(f"one of {batch[0][0]} ... {batch[-1][0]}: verify ends with {end.status}: "
                        f"{runs.first_line(end.err)}")
        trials += len(batch)
    shutil.rmtree(place)
    for text in said:
        setup.say(f"  failed: verify of {name}: {text}", flush=True)
    return Row(f"verify: {name}", trials, len(said), said[0] if said else f"{len(data)} bytes")


# --- commands that read -------------------------------------------------------------------------------------

def _said(end):
    """What a command has printed, without the length of the file."""
    return re.sub(r"\([0-9.e+-]+ MB\)", "", end.out)


def _read(run, place, words, right):
    """Nothing, or how the output of a command differs though it does not say that anything is wrong."""
    end = dataclasses.replace(run, words=words).call(place)
    if end.status < 0:
        return f"{' '.join(words)} ends by signal {-end.status}"
    if end.status == 0:
        return "" if _said(end) == _said(right) else f"FALSE: {' '.join(words)} prints something else, status 0"
    if end.status not in (2, 4) or not end.err.strip():
        return f"{' '.join(words)} ends with {end.status}: {runs.first_line(end.err)}"
    return ""


def _readers(setup, run, name, data, many, commands=READERS):
    """All commands on files that were altered at random."""
    reader = dataclasses.replace(run, files={})
    calls = [[word[0], "r.h5", *word[1:]] for word in commands]
    place = reader.folder()
    (place / "r.h5").write_bytes(data)
    right = [dataclasses.replace(reader, words=words).call(place) for words in calls]
    rows, used = [], [(words, end) for words, end in zip(calls, right) if end.status == 0]

    def one(number):
        what, altered = at_random(data, setup.random("altered", name, number))
        place = reader.folder()
        (place / "r.h5").write_bytes(altered)
        said = [text for text in (_read(reader, place, words, end) for words, end in used) if text]
        shutil.rmtree(place)
        return said and f"number {number}, {what}: {said[0]}"

    rows.append(runs.together(setup, f"info, measure: {name}", range(many), one,
                              f"{len(used)} commands each, {len(data)} bytes"))
    rows.append(_by_h5py(setup, name, data, many, place))
    shutil.rmtree(place)
    return rows


def _by_h5py(setup, name, data, many, place):
    """For information: files of which h5py reads something else, without an error."""
    found = (at_random(data, setup.random("altered", name, number)) for number in range(many))
    said = []
    for batch in _batches(found):
        names = [f"{k}.h5" for k in range(len(batch))]
        for file, (_, altered) in zip(names, batch):
            (place / file).write_bytes(altered)
        while names:
            # by another process, for it may crash
            end = subprocess.run([sys.executable, results.__file__, "r.h5", *names], cwd=place, capture_output=True,
                                 text=True)
            said += end.stdout.split() + (["crash"] if end.returncode else [])
            names = names[len(end.stdout.split()) + 1:] if end.returncode else []
    counts = ", ".join(f"{said.count(word)} {word}" for word in ("same", "other", "refused", "crash"))
    return Row(f"h5py, for information: {name}", many, 0, counts)


# --- going on from altered files ----------------------------------------------------------------------------

def _continued(setup, run, template, many):
    """A checkpoint or a part of an unfinished run is altered; then it is continued."""
    names = sorted(p.name for p in (template / "r.h5.parts").glob("*.h5"))

    def one(number):
        chance = setup.random("continued", number)
        name = chance.choice(names)
        place = run.folder(template)
        path = place / "r.h5.parts" / name
        what, altered = at_random(path.read_bytes(), chance)
        path.write_bytes(altered)
        said = faults.judge(run, place, run.call(place), lost=True)
        shutil.rmtree(place)
        return said and f"number {number}, {name}, {what}: {said}"

    return runs.together(setup, "continuing from altered checkpoints and parts", range(many), one)


# --- versions -----------------------------------------------------------------------------------------------

def _with_format(number):
    def act(path):
        with h5py.File(path, "r+") as file:
            file["state"].attrs["format"] = numpy.int64(number)
    return act


def _foreign(path):
    path.unlink()
    with h5py.File(path, "w") as file:
        file["x"] = numpy.arange(10)
        file.create_group("summary").attrs["step"] = 3


def _text(path):
    path.write_text("time,x,y\n0,1,2\n")


def _empty(path):
    path.write_bytes(b"")


STRANGE = (("of a newer format", _with_format(99), "format|newer"), ("of an older format", _with_format(1), "format|older"),
           ("of another program", _foreign, "no[t a]* result of slipdisk"),
           ("of text", _text, "not an? HDF5|no checkpoint that can be"),
           ("that is empty", _empty, "not an? HDF5|empty|no checkpoint that can be"))


def _strange(setup, run, template, data, can_seal):
    """Each is named by what it is, as a result and as a checkpoint."""
    def one(job):
        (what, act, words), where = job
        place = run.folder(template if where == "checkpoint" else None)
        paths = [place / "r.h5"]
        if where == "result":
            paths[0].write_bytes(data)
            calls = [["info", "r.h5"], ["measure", "r.h5"], ["info", "--json", "r.h5"]]
        else:
            paths = sorted((place / "r.h5.parts").glob("checkpoint-*.h5"))
            calls = [["info", "r.h5"], ["resume", "r.h5", "--quiet"]]
        before = [dataclasses.replace(run, words=call).call(place) if call[0] != "resume" else None for call in calls]
        for path in paths:
            act(path)
            # what a newer version would have written has a checksum that fits
            if can_seal and act not in (_text, _empty):
                dataclasses.replace(run, words=["verify", "--seal", path.name]).call(path.parent)
        said = ""
        for call, right in zip(calls, before):
            end = dataclasses.replace(run, words=call).call(place)
            if "older" in what and end.status == 0 and call[0] != "resume" and _said(end) == _said(right):
                continue  # what has not changed since can be read
            if end.status not in (2, 4):
                said = said or f"{' '.join(call)} ends with {end.status}"
            elif not runs.FILE.search(end.err) or not re.search(words, end.err):
                said = said or f"{' '.join(call)} does not say so: {runs.first_line(end.err)}"
        shutil.rmtree(place)
        return said and f"a {where} {what}: {said}"

    return runs.together(setup, "files of other versions and programs are named",
                         [(kind, where) for kind in STRANGE for where in ("result", "checkpoint")], one)


def run(setup):
    home = runs.scratch(setup)
    try:
        tiny = runs.Run("tiny", setup.program, ["run", "deck.cfg", "--quiet", "--threads", "1", "-o", "r.h5"],
                        {"deck.cfg": TINY}, home).prepare()
        data = _result(tiny)
        packing = _result(runs.deposit(setup, home))
        rows = []
        shim = inject.library(home)
        template = kill.interrupted(tiny, shim, Fault("rename,link", 1, "kill", name="*/r.h5")) if shim else None
        can_verify = "slipdisk verify" in dataclasses.replace(tiny, words=["help"]).call(home).out
        if can_verify:
            rows += _all_verified(setup, home, data, packing, template)
        else:
            rows.append(Row("verify", 0, 0, "left out: this program has no such command"))
        rows += _readers(setup, tiny, "a small result", data, setup.pick(60, 2000))
        rows += _readers(setup, tiny, "a larger result", packing, setup.pick(60, 2000))
        if can_verify:
            rows += damaged.rows(setup, home, {"a small result": data, "a larger result": packing})
        if template:
            parts = template / "r.h5.parts"
            newest = max(parts.glob("checkpoint-*.h5"), key=lambda p: int(p.stem.split("-")[1]))
            rows += _readers(setup, tiny, "a checkpoint", newest.read_bytes(), setup.pick(40, 2000), READERS[:3])
            rows.append(_continued(setup, tiny, template, setup.pick(100, 2000)))
            rows.append(_strange(setup, tiny, template, data, can_verify))
        return rows
    finally:
        shutil.rmtree(home, ignore_errors=True)


def _result(run):
    place = run.folder()
    run.call(place)
    data = (place / "r.h5").read_bytes()
    shutil.rmtree(place)
    return data


def _all_verified(setup, home, data, packing, template):
    most = setup.pick(1500, 10**9)
    rows = [_verified(setup, home, "every byte of a small result", data, everywhere(data, most))]
    for kind in ("checkpoint", "part") if template else ():
        some = sorted((template / "r.h5.parts").glob(f"{kind}-*.h5"))[-1].read_bytes()
        rows.append(_verified(setup, home, f"every byte of a {kind}", some, everywhere(some, most)))
    random = (at_random(packing, setup.random("verify", k)) for k in range(setup.pick(300, 2000)))
    return [*rows, _verified(setup, home, "a larger result, at random", packing, random)]
