"""kill -9 at random moments and at every call that writes: the same command afterwards makes the result of a run that
was left alone, and leaves nothing beside it."""
import os
import pathlib
import shutil
import signal
import subprocess
import time

from . import inject, runs
from .inject import Fault
from .trial import Row


def _children(pid):
    try:
        return [int(word) for word in pathlib.Path(f"/proc/{pid}/task/{pid}/children").read_text().split()]
    except OSError:
        return []


def _strike(process, victim):
    """Kills the process, its group, or one of its children."""
    try:
        if victim == "group":
            os.killpg(process.pid, signal.SIGKILL)
        elif victim == "worker" and _children(process.pid):
            os.kill(_children(process.pid)[0], signal.SIGKILL)
        else:
            process.kill()
    except ProcessLookupError:
        pass


def _is_over(pid):
    """A process that has ended, though its parent has not asked for its status."""
    try:
        return pathlib.Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] == "Z"
    except OSError:
        return True


def _await(process, launcher):
    """Waits for the end of it, or says that it hangs. Open MPI's mpirun (4.1) itself may, in PMIx_server_finalize, when a
    rank was killed in MPI_Init: a launcher whose ranks have all ended is told to end, too."""
    for _ in range(runs.SECONDS // 10):
        try:
            process.communicate(timeout=10)
            return True
        except subprocess.TimeoutExpired:
            ranks = _children(process.pid)
            if launcher and ranks and all(map(_is_over, ranks)):
                process.kill()
    return False


def _random_kills(setup, run, number, victims):
    """Kills the run again and again until it gets through; (kills, what is wrong)."""
    chance = setup.random("kill", run.name, number)
    place, kills = run.folder(), 0
    while True:
        process, began = run.start(place, start_new_session=True), time.monotonic()
        try:
            # the delay grows, so that there is an end
            _, err = process.communicate(timeout=chance.uniform(0.005, 1.2 * run.seconds) * (1 + kills / 10))
            if not kills:
                # the machine may have been busy when the reference was made
                run.seconds = min(run.seconds, time.monotonic() - began)
            break
        except subprocess.TimeoutExpired:
            ranks = _children(process.pid) if run.also else []
            _strike(process, chance.choice(victims))
            kills += 1
            # a sweep whose worker was killed goes on; workers of a killed one end by themselves, and hold the pipes
            if not _await(process, launcher=bool(run.also)):
                _strike(process, "group")
                process.communicate()
                return kills, f"hangs after kill {kills} of trial {number}"
            # ranks may outlive a killed mpirun for a moment, and the next run leaves points to them
            for _ in range(100 * runs.SECONDS):
                if all(map(_is_over, ranks)):
                    break
                time.sleep(0.01)
    # the last of these may have been a sweep whose worker was killed before
    said = run.repair(place, tries=2) if process.returncode != 0 else run.wrong(place)
    shutil.rmtree(place)
    return kills, said and f"seed {setup.seed}, trial {number}, {kills} kills: {said}"


def _at_random(setup, run, quota, victims=("process",)):
    # one run after the other: they take all processors, and the moments shall be those of a run that has one
    kills, number, said = 0, 0, []
    while kills < quota and number < 3 * quota:
        number += 1
        more, wrong = _random_kills(setup, run, number, victims)
        kills += more
        if wrong:
            said.append(wrong)
            setup.say(f"  failed: {run.name}: {wrong}", flush=True)
    note = said[0] if said else f"{number} runs"
    return Row(f"{run.name}, at random moments", kills, len(said), note)


def logged(run, shim, kinds="writing", template=None, name=""):
    """All calls of these kinds that the run makes below its folder."""
    place = run.folder(template)
    log = place.parent / f"{place.name}.log"
    end = run.call(place, Fault(kinds, name=name, log=log).environment(shim, place))
    found = inject.calls(log)
    shutil.rmtree(place)
    log.unlink(missing_ok=True)
    if end.status != 0:
        raise RuntimeError(f"{run.name}: the counting run ends with {end.status}: {end.err}")
    return found


def interrupted(run, shim, *faults):
    """A folder in which the run was killed by one of these, the first that comes about; a template for runs that
    continue."""
    for fault in faults:
        place = run.folder()
        end = run.call(place, fault.environment(shim, place))
        if end.status == -signal.SIGKILL:
            return place
    raise RuntimeError(f"{run.name}: {fault} did not kill it: {end.status} {end.err}")


def stages(run, shim, result="r.h5"):
    """(name, template) of a run that begins, one that continues, and one whose merge is all that is left."""
    # the last checkpoint comes at the end, however fast the run is
    early = [Fault("rename,link", k, "kill", name="*/checkpoint-*") for k in (3, 2)]
    return [("fresh", None), ("continuing", interrupted(run, shim, *early)),
            ("merging", interrupted(run, shim, Fault("rename,link", 1, "kill", name=f"*/{result}")))]


def at_call(run, shim, template, do, when, tries=1):
    place = run.folder(template)
    fault = Fault("writing", when, do)
    end = run.call(place, fault.environment(shim, place))
    said = ""
    if end.status == 0:
        said = run.wrong(place)  # this time it had fewer calls
    elif end.status < 0 or tries > 1:
        said = run.repair(place, tries)
    else:
        said = f"ends with {end.status}: {runs.first_line(end.err)}"
    shutil.rmtree(place)
    return said and f"{fault}: {said}"


def _at_calls(setup, run, shim, most, cases, tries=1):
    rows = []
    for name, template in cases:
        n = len(logged(run, shim, template=template))
        jobs = [(do, k) for do in ("kill", "torn") for k in runs.spread(n, most if do == "kill" else most // 4)]
        rows.append(runs.together(setup, f"{run.name}, {name}, at system calls", jobs,
                                  lambda job, t=template: at_call(run, shim, t, *job, tries), f"of {n} calls"))
    return rows


def run(setup):
    home = runs.scratch(setup)
    try:
        rows = _random(setup, home)
        shim = inject.library(home)
        if not shim:
            return rows + [Row("at system calls", 0, 0, "left out: no compiler")]
        short = runs.three(setup, home).prepare()
        rows += _at_calls(setup, short, shim, setup.pick(40, 100000), stages(short, shim))
        packing = runs.deposit(setup, home, 0.3, checkpoint=0.002).prepare()
        rows += _at_calls(setup, packing, shim, setup.pick(15, 100000), stages(packing, shim)[:setup.pick(1, 3)])
        lanes = runs.sweep(setup, home, 2, steps=20000, checkpoint=0.005).prepare()
        return rows + _at_calls(setup, lanes, shim, setup.pick(15, 300), [("fresh", None)], tries=2)
    finally:
        shutil.rmtree(home, ignore_errors=True)


def _random(setup, home):
    quota = setup.pick(12, 170)
    rows = [_at_random(setup, make(setup, home).prepare(), quota) for make in
            (lambda s, h: runs.three(s, h, steps=600000, checkpoint=0.02, series=10000), runs.deposit, runs.shaking)]
    all_of = ("process", "group", "worker")
    for workers in 1, 2:
        rows.append(_at_random(setup, runs.sweep(setup, home, workers).prepare(), quota, all_of))
    program = setup.build.parent / "mpi" / "slipdisk"
    if program.exists() and shutil.which("mpirun"):
        # who is killed is mpirun, or one of its ranks: it then ends the others
        rows.append(_at_random(setup, runs.sweep(setup, home, ranks=3).prepare(), quota, ("group", "worker")))
    else:
        rows.append(Row("sweep on MPI ranks, at random moments", 0, 0, "left out: build/mpi/slipdisk is not there"))
    return rows
