"""Long runs and a long sweep: memory and descriptors stay as they are, checkpoints are pruned, files are as large as
`check` said.

Counters, angles and images near the ends of their ranges are the business of tests/unit/test_limits.c, which puts
states there.
"""
import dataclasses
import os
import pathlib
import re
import resource
import subprocess
import time

import h5py

from . import golden
from .trial import Clock, Row

PERIOD = 0.02            # between looks, s
WARM = 0.25              # of the looks are not judged
MEMORY = 4 << 20         # bytes that a process may grow by afterwards
MERGE = 32 << 20         # more that it may take while it puts the result together: a chunk of each compressed column
DESCRIPTORS = 32         # at any time; files that are written, and the merge, take some for a moment
CHECKPOINTS = 3          # at a time: two, and the one that is being written
SIZE = 0.2               # of the size that is foretold
UNITS = {"kB": 1e3, "MB": 1e6, "GB": 1e9}


# --- looking ----------------------------------------------------------------------------------------------------------


def memory_of(pid):
    """Resident bytes, or None when it is gone."""
    try:
        found = re.search(r"^VmRSS:\s+(\d+) kB", pathlib.Path(f"/proc/{pid}/status").read_text(), re.M)
        return int(found[1]) << 10 if found else None
    except OSError:
        return None


def descriptors_of(pid):
    try:
        return len(os.listdir(f"/proc/{pid}/fd"))
    except OSError:
        return None


def children_of(pid):
    try:
        return [int(word) for word in pathlib.Path(f"/proc/{pid}/task/{pid}/children").read_text().split()]
    except OSError:
        return []


@dataclasses.dataclass
class Looks:
    """What was seen while a command ran: a number per look."""
    memory: list = dataclasses.field(default_factory=list)          # of the process
    descriptors: list = dataclasses.field(default_factory=list)
    workers: list = dataclasses.field(default_factory=list)         # the largest of its children
    worker_descriptors: list = dataclasses.field(default_factory=list)
    checkpoints: list = dataclasses.field(default_factory=list)
    merge: list = dataclasses.field(default_factory=list)           # memory while the result is put together
    seconds: float = 0.0
    cpu: float = 0.0


def is_merging(result):
    """Among the parts there is the draft of the result, or it has its name already."""
    return result.is_file() or any(result.with_name(f"{result.name}.parts").glob("result.h5.*.tmp"))


def look(pid, result, found):
    merging, memory, descriptors = is_merging(result), memory_of(pid), descriptors_of(pid)
    if memory and descriptors:
        (found.merge if merging or is_merging(result) else found.memory).append(memory)
        found.descriptors.append(descriptors)
    children = [pair for pair in ((memory_of(p), descriptors_of(p)) for p in children_of(pid)) if all(pair)]
    if children:
        found.workers.append(max(memory for memory, _ in children))
        found.worker_descriptors.append(max(descriptors for _, descriptors in children))
    parts = result.with_name(f"{result.name}.parts")
    if parts.is_dir():
        found.checkpoints.append(sum(1 for p in parts.glob("checkpoint-*.h5")))


def cpu_seconds():
    """Of all children that have ended."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def watch(words, result):
    clock, found, before = Clock(), Looks(), cpu_seconds()
    process = subprocess.Popen(list(map(str, words)), stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
    while process.poll() is None:
        look(process.pid, result, found)
        time.sleep(PERIOD)
    said = process.stderr.read()
    process.stderr.close()
    if process.returncode:
        raise golden.Failed(f"exit status {process.returncode}: {said[-300:]}")
    found.seconds, found.cpu = clock.seconds(), cpu_seconds() - before
    return found


# --- judging ----------------------------------------------------------------------------------------------------------


def judge_flat(what, values, most, unit=1.0, name=""):
    """After the warm part no value lies above the largest of it by more than so much."""
    warm = max(1, round(WARM * len(values)))
    late = values[warm:]
    if not late:
        return Row(what, 1, 1, f"{len(values)} looks are too few")
    base = max(values[:warm])
    above = [value for value in late if value > base + most]
    return Row(what, len(late), len(above),
               f"{base / unit:.4g}{name} when warm, then {min(late) / unit:.4g} to {max(late) / unit:.4g}")


def judge_descriptors(what, values):
    """None stays open: at the end there are moments with no more than in the warm part, and never are there many."""
    warm = max(1, round(WARM * len(values)))
    late = values[warm:]
    if not late:
        return Row(what, 1, 1, f"{len(values)} looks are too few")
    base, end = max(values[:warm]), min(late[len(late) // 3:])
    return Row(what, len(late), int(end > base) + sum(n > DESCRIPTORS for n in late),
               f"{base} when warm, then {min(late)} to {max(late)}")


def judge_merge(what, seen):
    base, most = max(seen.memory, default=0), max(seen.merge, default=0)
    return Row(f"{what}: memory while it is put together", len(seen.merge), sum(n > base + MERGE for n in seen.merge),
               f"{most / 1e6:.4g} MB at most" if seen.merge else "too short to be seen")


def foretold(program, words):
    """Bytes that `check` says a result will have."""
    said = subprocess.run([program, "check", *words, "--brief", "--no-probe"], capture_output=True, text=True, check=True).stdout
    found = re.search(r"^# result .*about ([\d.]+) (.B)", said, re.M)
    return float(found[1]) * UNITS[found[2]]


def judge_size(what, program, words, result):
    said, size = foretold(program, words), result.stat().st_size
    return Row(f"{what}: size as `check` said", 1, int(abs(said / size - 1) > SIZE),
               f"{size / 1e6:.4g} MB, {said / size:.3f} of it foretold")


def budget(result):
    with h5py.File(result) as file:
        seen = file["observables"]
        return float(seen["residual/value"][-1] / seen["scale/value"][-1])


# --- runs -------------------------------------------------------------------------------------------------------------


def long_run(setup, what, deck, steps, overrides):
    result = setup.work / "long.h5"
    words = [str(golden.ROOT / "inputs" / deck)]
    for key, value in overrides.items():
        words += ["-D", f"{key}={value}"]
    seen = watch([setup.program, "run", *words, "--threads", 1, "--quiet", "-o", result], result)
    rows = [judge_flat(f"{what}: memory", seen.memory, MEMORY, 1e6, " MB"),
            judge_merge(what, seen),
            judge_descriptors(f"{what}: descriptors", seen.descriptors),
            Row(f"{what}: checkpoints at a time", len(seen.checkpoints), sum(n > CHECKPOINTS for n in seen.checkpoints),
                f"{max(seen.checkpoints, default=0)} at most"),
            judge_size(what, setup.program, words, result)]
    with h5py.File(result) as file:
        taken = int(file["state/step"][()])
        path = golden.text(file["parameters"].attrs["cpu_path"])
    rows[0].note += (f"; {taken:.3g} steps in {seen.seconds:.0f} s, {1e9 * seen.cpu / taken:.3g} ns of a processor each "
                     f"({path}), residual {budget(result):.1e} of the budget")
    if taken != steps:
        rows[0].failed += 1
        rows[0].note = f"{taken} steps instead of {steps}"
    golden.remove(result)
    return rows


def three_disks(setup):
    steps = setup.pick(10**7, 5 * 10**8)
    return long_run(setup, "three disks", "three_disk/random.cfg", steps, {
        "phases.settle.steps": 10**6, "phases.measure.steps": steps - 10**6, "phases.measure.series": 10**4,
        "phases.measure.frames": 10**5, "phases.measure.contacts": 10**5, "checkpoint": setup.pick(0.05, 0.5)})


def packing(setup):
    steps = setup.pick(5 * 10**5, 10**7)
    rest = 30000
    return long_run(setup, "shaken packing", "packing/shake_low.cfg", steps, {
        "motions.shake.acceleration": 2, "phases.rest.time": rest * 3e-5, "phases.thermalise.time": rest * 3e-5,
        "phases.measure.time": (steps - 2 * rest) * 3e-5, "phases.measure.frames": 10**3, "phases.measure.contacts": 10**3,
        "checkpoint": setup.pick(0.05, 0.5)})


def sweep(setup):
    points, result = setup.pick(200, 1000), setup.work / "long.sweep"
    words = [setup.program, "sweep", golden.ROOT / "inputs/three_disk/random.cfg", "--quiet", "-j", 2, "-o", result]
    for key, value in {"phases.settle.steps": 1000, "phases.measure.steps": 2000, "sweep.replicas": points}.items():
        words += ["-D", f"{key}={value}"]
    seen = watch(words, result)
    done = len(golden.results_of(result))
    left = sum(1 for _ in (result / "points").glob("*.parts"))
    golden.remove(result)
    return [Row("sweep: points that are finished", points, abs(points - done) + left, f"{seen.seconds:.0f} s"),
            judge_flat("sweep: memory", seen.memory, MEMORY, 1e6, " MB"),
            judge_descriptors("sweep: descriptors", seen.descriptors),
            judge_flat("sweep: memory of the largest worker", seen.workers, MEMORY, 1e6, " MB"),
            judge_descriptors("sweep: descriptors of the worker with most", seen.worker_descriptors)]


def run(setup):
    rows = []
    for trial in three_disks, packing, sweep:
        try:
            rows += trial(setup)
        except (golden.Failed, OSError, subprocess.SubprocessError) as error:
            rows.append(Row(trial.__name__.replace("_", " "), 1, 1, str(error)))
    return rows
