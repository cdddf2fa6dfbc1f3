"""What others do to a run's files while it runs: its folder removed, moved, replaced by another run's, made read-only;
links and files planted at its names. For the mode `faults`."""
import dataclasses
import os
import shutil
import signal
import time

from . import faults, runs
from .trial import Row

NOBODY = 65534


def _is_under_way(place):
    return (place / "r.h5.parts").is_dir() and not (place / "r.h5").exists()


def _stopped(run, chance):
    """A run that stands still somewhere in its middle; (process, folder), or nothing when it was over too soon."""
    place = run.folder()
    process = run.start(place)
    deadline = time.monotonic() + 60
    while not any((place / "r.h5.parts").glob("checkpoint-*.h5")) and process.poll() is None:
        if time.monotonic() > deadline:
            break
        time.sleep(0.002)
    time.sleep(chance.uniform(0, 0.6) * run.seconds)
    process.send_signal(signal.SIGSTOP)
    if process.poll() is None and _is_under_way(place):
        return process, place
    process.kill()
    process.communicate()
    shutil.rmtree(place)
    return None


def _go_on(process):
    process.send_signal(signal.SIGCONT)
    try:
        out, err = process.communicate(timeout=runs.SECONDS)
    except Exception:
        process.kill()
        process.communicate()
        raise
    return runs.End(process.returncode, out, err)


# --- the folder of parts ------------------------------------------------------------------------------------

def _removed(place):
    shutil.rmtree(place / "r.h5.parts")


def _moved(place):
    (place / "r.h5.parts").rename(place / "aside")


def _emptied(place):
    for path in (place / "r.h5.parts").iterdir():
        path.unlink()


def _part_removed(place):
    sorted((place / "r.h5.parts").glob("part-*.h5"))[0].unlink()


def _checkpoints_removed(place):
    for path in (place / "r.h5.parts").glob("checkpoint-*.h5"):
        path.unlink()


def _disturbed(setup, run, number, act):
    """Does it while the run stands still; the rule holds afterwards."""
    found = _stopped(run, setup.random("folder", act.__name__, number))
    if not found:
        return None
    process, place = found
    act(place)
    end = _go_on(process)
    if (place / "aside").exists():
        shutil.rmtree(place / "aside")
    said = faults.judge(run, place, end, lost=True)
    shutil.rmtree(place)
    return said and f"trial {number}: {said}"


def replaced(setup, run, other, number, how):
    """Another run stands under the same name when the first goes on: alive, killed, or copied from elsewhere."""
    found = _stopped(run, setup.random("replaced", how, number))
    if not found:
        return None
    process, place = found
    (_moved if number % 2 else _removed)(place)
    second = _stopped_second(other, place)
    if how == "killed" and second:
        second.kill()
        second.communicate()
    elif second:
        second.send_signal(signal.SIGCONT)
    first = _go_on(process)
    other_end = _go_on(second) if how == "alive" and second else None
    shutil.rmtree(place / "aside", ignore_errors=True)
    said = ""
    if first.status == 0:
        said = "FALSE: the first run ends with 0"
    elif first.status not in (2, 4) or not runs.FILE.search(first.err):
        said = f"the first run ends with {first.status}: {runs.first_line(first.err)}"
    elif other_end and other_end.status != 0:
        said = f"the second run ends with {other_end.status}: {runs.first_line(other_end.err)}"
    elif not other_end and not _goes_on(other, place):
        said = "the killed second run has lost its checkpoints"
    else:
        said = other.false(place) or other.repair(place)
    shutil.rmtree(place)
    return said and f"trial {number}, {how}: {said}"


def _goes_on(other, place):
    return any((place / "r.h5.parts").glob("checkpoint-*.h5")) or (place / "r.h5").exists()


def _stopped_second(other, place):
    """The other run, started there, standing still when it has two parts."""
    process = other.start(place)
    deadline = time.monotonic() + 60
    while len(list((place / "r.h5.parts").glob("part-*.h5"))) < 2 and process.poll() is None:
        if time.monotonic() > deadline:
            break
        time.sleep(0.002)
    process.send_signal(signal.SIGSTOP)
    return process


def _read_only(setup, run, number):
    """No file can be made any more in the folder of parts, or beside the result. Root may always, so the run belongs to another user."""
    found = _stopped(run, setup.random("read-only", number))
    if not found:
        return None
    process, place = found
    closed = place / "r.h5.parts" if number % 2 else place
    closed.chmod(0o555)
    end = _go_on(process)
    closed.chmod(0o755)
    said = "" if end.status == 4 else f"ends with {end.status}: {runs.first_line(end.err)}"
    said = said or faults.judge(run, place, end)
    shutil.rmtree(place)
    return said and f"trial {number}: {said}"


# --- links and files at its names ---------------------------------------------------------------------------

VICTIM = "not slipdisk's\n" * 40


def _linked(run, name):
    """A link at a name that a run may write: what it leads to stays as it is."""
    place = run.folder()
    victim = place / "victim"
    (place / name).parent.mkdir(exist_ok=True)
    if name == "r.h5.parts":
        victim.mkdir()
        for k in range(3):
            (victim / f"part-00000{k + 1}.h5").write_text(VICTIM)
    else:
        victim.write_text(VICTIM)
    (place / name).symlink_to(victim)
    end = run.call(place)
    texts = [p.read_text(errors="replace") if p.exists() else None
             for p in ([victim / f"part-00000{k + 1}.h5" for k in range(3)] if victim.is_dir() else [victim])]
    said = "" if all(text == VICTIM for text in texts) else f"FALSE: what {name} leads to was overwritten"
    if not said and end.status not in (0, 2, 4):
        said = f"ends with {end.status}: {runs.first_line(end.err)}"
    if not said and end.status != 0 and name.split("/")[-1] not in end.err:
        said = f"the message does not name {name}: {runs.first_line(end.err)}"
    if not said and end.status == 0:
        said = run.wrong(place, left_over=True)
    if not said:
        if (place / name).is_symlink():
            (place / name).unlink()
        shutil.rmtree(victim) if victim.is_dir() else victim.unlink()
        if end.status != 0:
            said = run.repair(place)
    shutil.rmtree(place)
    return said and f"link at {name}: {said}"


def _appears(setup, run, number):
    """Another's file at the result's name: it stays, and the run's work is not lost."""
    found = _stopped(run, setup.random("appears", number))
    if not found:
        return None
    process, place = found
    (place / "r.h5").write_text(VICTIM)
    end = _go_on(process)
    said = "" if (place / "r.h5").read_text(errors="replace") == VICTIM else "FALSE: it was overwritten"
    if not said and (end.status not in (2, 4) or "r.h5" not in end.err):
        said = f"ends with {end.status}: {runs.first_line(end.err)}"
    if not said:
        (place / "r.h5").unlink()
        said = run.repair(place)
    shutil.rmtree(place)
    return said and f"trial {number}: {said}"


def rows(setup, home, short):
    longer = {"steps": 1500000, "checkpoint": 0.03, "series": 10000}
    run = runs.three(setup, home, **longer).prepare()
    other = runs.three(setup, home, seed=2, **longer).prepare()
    humble = run
    if os.geteuid() == 0:
        humble = dataclasses.replace(run, program=_for_all(run.program, home), user=NOBODY).prepare()
    n = setup.pick(4, 60)
    found = [runs.together(setup, f"the folder is {word}", range(n), lambda k, a=act: _disturbed(setup, run, k, a))
             for word, act in (("removed", _removed), ("moved away", _moved), ("emptied", _emptied),
                               ("short of a part", _part_removed), ("short of checkpoints", _checkpoints_removed))]
    found += [runs.together(setup, f"the folder is replaced by that of another run, {how}", range(n),
                            lambda k, h=how: replaced(setup, run, other, k, h)) for how in ("alive", "killed")]
    found.append(runs.together(setup, "the folder is read-only", range(n),
                               lambda k: _read_only(setup, humble, k)))
    names = ["r.h5.tmp", "r.h5.parts", "r.h5.parts/lock", "r.h5.parts/checkpoint-0.h5.tmp",
             "r.h5.parts/part-000001.h5.tmp", "r.h5.parts/checkpoint-0.h5", "r.h5.parts/part-000001.h5", "run.log"]
    logging = dataclasses.replace(short, words=[*short.words, "--log", "run.log"], beside=("run.log", "victim"))
    found.append(runs.together(setup, "a link at a name that a run uses", names, lambda name: _linked(logging, name)))
    found.append(runs.together(setup, "a file appears at the result's name", range(n),
                               lambda k: _appears(setup, run, k)))
    return found


def _for_all(program, home):
    """The program where every user can call it."""
    home.chmod(0o755)
    place = home / "slipdisk"
    shutil.copy(program, place)
    place.chmod(0o755)
    return place
