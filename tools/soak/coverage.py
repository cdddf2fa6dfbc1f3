"""coverage: how much of each room of src/ is reached by tests that store and read, and by trials that let calls fail.

The build of the preset `coverage` counts lines and branches, gcovr adds them up. Left out: the branches of assert() (the
side on which it ends the program is never to be taken) and those that gcc adds to lines without a decision. Processes that
are killed, and workers, which leave by _exit, count nothing.
"""
import concurrent.futures
import importlib
import json
import os
import re
import subprocess

from .trial import ROOT, Row, Setup

BUILD = ROOT / "build" / "coverage"

# Room -> its files below src/; the first that fits counts.
ROOMS = {
    # this build has no MPI: test_ranks has ranks that are threads, and no shares
    "ranks": r"base/comm|run/(ranks|route|steps)|model/rows|io/store/h5_open",
    "deck reader": r"io/deck",
    "checkpoint": r"io/(results/checkpoint|store/file|store/folder|store/members)",
    "merge": r"io/(store/table|results/(merge|record|series|trajectory|frames))",
    "HDF5": r"io/store/h5",
    "summary": r"io/",
    "app": r"app/", "run": r"run/", "measure": r"measure/", "theory": r"theory/", "pack": r"pack/",
    "physics": r"physics/", "model": r"model/", "base": r"base/",
}
# Percent of branches below which a room must not fall; 95 is the aim of the first three.
LEAST = {"deck reader": 88, "checkpoint": 70, "merge": 82, "measure": 83, "physics": 79}

# The tests that reach most in a second: no tests of numbers and of speed, none that run for long.
TESTS = (r"^test_(deck|deck_.*|packings_(deck|check)|tiles|files_in_parts|model_part|sweep_(deck|folder)|check_sweep|checkpoint|restart"
         r"|rows|configuration|measure_command|disk_files|disk_results|results|large_files"
         r"|session_group|settle|settle_runs|ensemble|compress|compress_results|watch|bounds|walls|rain|relax|generators|motion"
         r"|lanes_motion|neighbours|ranks|theory_command|random|until|expressions|mistakes|advice|library|library_mistakes|json|export|h5md|cell_readers|clump_decks)$")
# The modes that lead into branches of failures and of features that meet, and their sizes
FAULTS = {"crossing": "small", "faults": "brief", "memory": "small", "altered": "brief"}


def call(*words, **more):
    return subprocess.run(list(map(str, words)), cwd=ROOT, check=False, **more)


def build():
    call("cmake", "--preset", "coverage", "--log-level=WARNING", stdout=subprocess.DEVNULL).check_returncode()
    done = call("cmake", "--build", "--preset", "coverage", capture_output=True, text=True)
    if done.returncode:
        raise SystemExit(done.stdout + done.stderr)
    for counters in BUILD.rglob("*.gcda"):
        counters.unlink()


def run_tests(say):
    done = call("ctest", "--preset", "coverage", "-R", TESTS, "-j", os.cpu_count(), stdout=subprocess.PIPE, text=True)
    if done.returncode:
        say(done.stdout)
    failed = re.search(r"(\d+) tests? failed out of (\d+)", done.stdout)
    if not failed:
        raise SystemExit(done.stdout)
    return Row("tests run for it", int(failed[2]), int(failed[1]))


def run_faults(setup):
    """Their verdicts are of no interest here: the counters' own files fail, too."""
    from .__main__ import MODES
    for mode, size in FAULTS.items():
        if mode in MODES:
            work = setup.work / mode
            work.mkdir()
            importlib.import_module(f".{mode}", __package__).run(
                Setup(BUILD / "slipdisk", BUILD, work, size, setup.seed, setup.say))


def count():
    """room -> [lines, reached, branches, taken]"""
    done = call("gcovr", "--root", ROOT, "--filter", "src/", "--object-directory", BUILD, BUILD / "CMakeFiles", "-j",
                os.cpu_count(), "--exclude-unreachable-branches", "--exclude-throw-branches",
                "--exclude-branches-by-pattern", r".*\bassert\(.*", "--json-summary", capture_output=True, text=True)
    if done.returncode:
        raise SystemExit(done.stderr)
    found = {room: [0, 0, 0, 0] for room in ROOMS}
    keys = "line_total", "line_covered", "branch_total", "branch_covered"
    files = {}
    for entry in json.loads(done.stdout)["files"]:
        name = entry["filename"].removeprefix("src/")
        files[name] = [entry[key] for key in keys]
        room = next(room for room, names in ROOMS.items() if re.match(names, name))
        found[room] = [a + b for a, b in zip(found[room], files[name])]
    return found, files


def percent(part, whole):
    return 100 * part / whole if whole else 100.0


def show(found, say):
    say(f"  {'room':<14}{'lines':>8}{'reached':>9}{'branches':>10}{'taken':>8}")
    for room, (lines, reached, branches, taken) in found.items():
        say(f"  {room:<14}{lines:>8}{percent(reached, lines):>7.1f} %{branches:>10}{percent(taken, branches):>6.1f} %")


def row(room, branches, taken):
    least = LEAST.get(room, 0)
    missing = max(0, round(least / 100 * branches) - taken)
    return Row(f"branches: {room}", branches, missing, f"{percent(taken, branches):.1f} %, at least {least} % wanted")


def run(setup):
    build()
    # trials leave cores idle, which tests take: counters are added up under locks
    with concurrent.futures.ThreadPoolExecutor() as pool:
        tests, faults = pool.submit(run_tests, setup.say), pool.submit(run_faults, setup)
        rows = [tests.result()]
        faults.result()
    found, files = count()
    show(found, setup.say)
    for name in sorted(files):
        if re.match("|".join(list(ROOMS.values())[:4]), name):
            setup.say(f"    {name:<28}{percent(*files[name][1::-1]):>6.1f} %{percent(*files[name][:1:-1]):>8.1f} %")
    return rows + [row(room, branches, taken) for room, (_, _, branches, taken) in found.items()]
