#!/usr/bin/env python3
"""Stepping from Python in pieces of 1000 steps beside `slipdisk run`: nanoseconds per step.

    tests/bench/bench_python.py [--repeats N] [--divide N]

Of three disks and of a packing of 10000. Processor time of one thread, so that other work on the machine counts little,
in alternation; the program's without its start and its end. The table has medians, and the median of the ratios of
neighbours.
"""
import argparse
import os
import pathlib
import resource
import statistics
import sys
import tempfile
import time

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
# deck, steps, key of their number, further overrides
CASES = {
    "three disks": (ROOT / "inputs" / "three_disk" / "random.cfg", 5_000_000, "phases.measure.steps",
                    {"phases.settle.steps": 1000}),
    "packing of 10000": (PACKING, 10_000, "phases.rest.steps", {}),
}


def children():
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def by_program(deck, overrides, key, steps, folder):
    """Beginning and end are the same in a run of a fifth of the steps: the difference is steps alone."""
    took = []
    for n in (steps // 5, steps):
        begin = children()
        slipdisk.run(deck, os.path.join(folder, "r.h5"), {**overrides, key: n}, force=True, threads=1)
        took.append(children() - begin)
    return 1e9 * (took[1] - took[0]) / (steps - steps // 5)


def by_python(deck, overrides, key, steps):
    simulation = slipdisk.Simulation(deck, {**overrides, key: steps}, threads=1)
    begin = time.process_time()
    for _ in range(simulation.steps // PIECE):
        simulation.advance(PIECE)
    return 1e9 * (time.process_time() - begin) / simulation.step


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--repeats", type=int, default=9)
    parser.add_argument("--divide", type=int, default=1, metavar="N", help="an N-th of the steps")
    args = parser.parse_args()
    print("| system | steps | `slipdisk run`, ns per step | Python, pieces of 1000 | Python over program |\n|---|---|---|---|---|")
    with tempfile.TemporaryDirectory(prefix="slipdisk-bench-") as folder:
        for name, (deck, steps, key, overrides) in CASES.items():
            steps //= args.divide
            program, python = [], []
            for _ in range(args.repeats):
                program.append(by_program(deck, overrides, key, steps, folder))
                python.append(by_python(deck, overrides, key, steps))
            ratio = statistics.median(b / a for a, b in zip(program, python))
            print(f"| {name} | {steps} | {statistics.median(program):.1f} | {statistics.median(python):.1f} | "
                  f"{ratio:.4f} |", flush=True)


if __name__ == "__main__":
    main()
