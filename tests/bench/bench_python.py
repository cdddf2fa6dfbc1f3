#!/usr/bin/env python3
"""Stepping from Python in pieces of 1000 steps beside `slipdisk run`: nanoseconds per step.

    tests/bench/bench_python.py [--repeats N]

Of three disks and of a packing of 10000, one thread each. The program's own time for steps, without its start and its end, and
that of a loop in Python, in alternation. Other work on the machine only adds to the times, so the table has lower
quartiles. On a machine that is busy even they say little; what a call costs beyond its steps is then seen best within one
process, in stretches of 10000 steps (0.8 ms), in one call and in ten: the last lines.
"""
import argparse
import os
import pathlib
import sys
import tempfile
import time

import numpy as np

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
sys.path.insert(0, str(ROOT / "tools" / "python"))
import slipdisk  # noqa: E402

PIECE = 1000
PACKING = {
    "dt": 1e-4, "integrator": "verlet", "gravity": {"g": 9.81}, "materials": {"grain": {"k_n": 1e4, "k_t": 5e3, "gamma_n": 2, "mu": 0.5}},
    "container": {"type": "box", "width": 4.001, "height": 5},
    "packings": [{"type": "triangular", "count": 10000, "radius": 0.02, "density": 3.57}],
    "phases": {"rest": {"time": 1}},
}
# deck, repeats, steps, key of their number, further overrides
CASES = {
    "three disks": (ROOT / "inputs" / "three_disk" / "random.cfg", 100, 500_000, "phases.measure.steps", {"phases.settle.steps": 1000}),
    "packing of 10000": (PACKING, 9, 3_000, "phases.rest.steps", {}),
}


def by_program(deck, overrides, folder):
    result = slipdisk.run(deck, os.path.join(folder, "r.h5"), overrides, force=True, threads=1)
    return 1e9 * result.provenance.step_seconds / result.step


def by_python(deck, overrides):
    simulation = slipdisk.Simulation(deck, overrides, threads=1)
    begin = time.perf_counter()
    for _ in range(simulation.steps // PIECE):
        simulation.advance(PIECE)
    return 1e9 * (time.perf_counter() - begin) / simulation.step


def by_stretches(repeats):
    """(one call, ten calls) for 10000 steps of three disks, us: 5 % of the stretches were shorter."""
    deck, *_, key, overrides = CASES["three disks"]
    simulation = slipdisk.Simulation(deck, {**overrides, key: 10**9}, threads=1)
    simulation.advance(1_000_000)
    took = []
    for _ in range(repeats):
        begin = time.perf_counter()
        simulation.advance(10 * PIECE)
        between = time.perf_counter()
        for _ in range(10):
            simulation.advance(PIECE)
        took.append((between - begin, time.perf_counter() - between))
    return 1e6 * np.percentile(took, 5, axis=0)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--repeats", type=float, default=1, metavar="F", help="so many times as many repeats")
    args = parser.parse_args()
    print("| system | repeats | steps | `slipdisk run`, ns per step | Python, pieces of 1000 | ratio |\n|---|---|---|---|---|---|")
    with tempfile.TemporaryDirectory(prefix="slipdisk-bench-") as folder:
        for name, (deck, repeats, steps, key, overrides) in CASES.items():
            program, python = [], []
            repeats = max(1, round(args.repeats * repeats))
            for _ in range(repeats):
                program.append(by_program(deck, {**overrides, key: steps}, folder))
                python.append(by_python(deck, {**overrides, key: steps}))
            a, b = np.percentile(program, 25), np.percentile(python, 25)
            print(f"| {name} | {repeats} | {steps} | {a:.1f} | {b:.1f} | {b / a:.3f} |", flush=True)
    one, ten = by_stretches(round(5000 * args.repeats))
    print(f"10000 steps of three disks: {one:.1f} us in one call, {ten:.1f} us in ten: {(ten - one) / 9:.2f} us per call, "
          f"{100 * (ten / one - 1):.1f} %")


if __name__ == "__main__":
    main()
