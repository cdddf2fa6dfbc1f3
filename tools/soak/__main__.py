"""python3 -m soak: runs the modes that were asked for and prints their rows. Called by tools/soak.sh."""
import argparse
import concurrent.futures
import dataclasses
import importlib
import json
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile

from . import page
from .trial import ROOT, SIZES, Clock, Setup

# Each is a file of this folder with a function run(setup) that returns a list of rows.
MODES = {
    "memory": "allocations that fail, the n-th or all from the n-th on",
    "determinism": "the same bits from all builds, threads, instruction sets, restarts, lanes and lists",
    "long": "long runs and sweeps: memory, descriptors and checkpoints stay as they are, files as `check` said",
    "kill": "kill -9 at random moments and at every call that writes; then the same command again",
    "faults": "calls that fail once or for ever, full disks, folders that go away",
    "power": "power cuts on a file system of its own; then the same command again",
    "altered": "files with other bytes than those that were written, and files of other versions",
    "fuzz": "damaged decks, -D, CSV, LAMMPS and HDF5 under sanitizers (needs clang)",
    "relations": "decks at random: mirrors, turns, shifts, frames, orders, restarts, shapes of a wall, balance of forces",
    "crossing": "every feature of decks in every way to run: threads, widths, windows, lanes, ranks, saved, copied, rebuilt",
    "coverage": "lines and branches of src/ that tests and faults reach, room by room",
}

ALONE = {"determinism", "kill", "power"}  # one after the other, with nothing beside them
APART = {"coverage"}  # only when it is asked for: it tries nothing, and makes a build of its own


def options(words=None):
    parser = argparse.ArgumentParser(prog="tools/soak.sh", description="Tries to make slipdisk lose or falsify a result.")
    parser.add_argument("modes", nargs="*", metavar="MODE", help="only these (all): " + ", ".join(MODES))
    parser.add_argument("--list", action="store_true", help="name the modes and stop")
    parser.add_argument("--size", choices=SIZES, default="small", help="how many trials (small)")
    parser.add_argument("--seed", type=int, default=1, help="of all random choices (1)")
    parser.add_argument("-o", dest="folder", type=pathlib.Path, default=ROOT / "build" / "soak", metavar="DIR",
                        help="where MODE.json goes (build/soak)")
    parser.add_argument("--program", type=pathlib.Path, default=ROOT / "build" / "release" / "slipdisk", metavar="FILE")
    parser.add_argument("--keep", type=pathlib.Path, metavar="DIR",
                        help="put the tables of all modes that have been run into DIR/reliability.md (docs)")
    args = parser.parse_args(words)
    for mode in args.modes:
        if mode not in MODES:
            parser.error(f"there is no mode {mode}; there are {', '.join(MODES)}")
    return args


def build(program):
    """The program, built where it is missing."""
    if program.exists():
        return
    for words in (["cmake", "--preset", "release"], ["cmake", "--build", "--preset", "release"]):
        subprocess.run(words, cwd=ROOT, check=True, stdout=subprocess.DEVNULL)


def show(rows):
    for row in rows:
        print(f"  {row.what:<58} {row.trials:>9} {row.failed:>7}  {row.note}", flush=True)


def run_mode(mode, args):
    clock = Clock()
    scratch = pathlib.Path(tempfile.mkdtemp(prefix=f"slipdisk-soak-{mode}-"))
    print(f"{mode}: {MODES[mode]}\n  {'':<58} {'trials':>9} {'failed':>7}", flush=True)
    try:
        setup = Setup(args.program.resolve(), args.program.resolve().parent, scratch, args.size, args.seed)
        rows = importlib.import_module(f".{mode}", __package__).run(setup)
    finally:
        shutil.rmtree(scratch, ignore_errors=True)
    show(rows)
    print(f"  {clock.seconds():.0f} s", flush=True)
    args.folder.mkdir(parents=True, exist_ok=True)
    (args.folder / f"{mode}.json").write_text(json.dumps(
        {"mode": mode, "what": MODES[mode], "size": args.size, "seed": args.seed, "seconds": clock.seconds(),
         "rows": [dataclasses.asdict(row) for row in rows]}, indent=1))
    if rows and all(row.trials == 0 and row.note.startswith("left out") for row in rows):
        return 0
    # A mode without a trial shows nothing: that is a failure, too.
    return sum(row.failed for row in rows) if sum(row.trials for row in rows) else 1


def beside(mode, args):
    """The mode in a process of its own, its rows when it is over: whether nothing failed."""
    words = [sys.executable, "-m", __package__, mode, "--size", args.size, "--seed", str(args.seed), "-o", args.folder.resolve(),
             "--program", args.program.resolve()]
    done = subprocess.run(words, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False)
    # the last line sums up this mode alone
    print(done.stdout if done.returncode not in (0, 1) else done.stdout.rpartition("\n")[0].rpartition("\n")[0], flush=True)
    return done.returncode


def run_modes(modes, args):
    """mode -> failures. Most modes try one thing after the other, so as many go side by side as there are processors; then those
    that want a machine of their own: threads that wait for each other take three times as long beside another mode, and ranks that
    outlive a killed mpirun keep the next run from their points."""
    together = [mode for mode in modes if mode not in ALONE]
    workers = min(len(together), os.cpu_count() or 1)
    if workers < 2:
        return {mode: run_mode(mode, args) for mode in modes}
    with concurrent.futures.ThreadPoolExecutor(workers) as pool:
        failed = dict(zip(together, pool.map(lambda mode: beside(mode, args), together)))
    return failed | {mode: run_mode(mode, args) for mode in modes if mode in ALONE}


def main():
    args = options()
    if args.list:
        for mode, what in MODES.items():
            print(f"{mode:<12} {what}")
        return 0
    build(args.program)
    failed = run_modes(args.modes or [mode for mode in MODES if mode not in APART], args)
    if args.keep:
        page.keep(args.folder, args.keep / "reliability.md", MODES)
    bad = [mode for mode, n in failed.items() if n]
    print("nothing failed" if not bad else "failures in: " + ", ".join(bad))
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main())
