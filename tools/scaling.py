#!/usr/bin/env python3
"""How one run scales over MPI ranks and threads: tools/scaling.py [-h]

A lattice of disks at touch, in a periodic box, accelerates at an angle, so that lists are renewed and disks change ranks. Ways are
tried in turn, several rounds; what is told is the median of the wall time a step, and its ratio to the first way.

--fit fits the model of a step (docs/performance.md) and tells what it predicts. Each round makes, of n disks a rank: one program
alone, two at once, which know nothing of each other, and two ranks of one run. The last two differ by what ranks cost:

    step(n) = alone(n) + fixed + per_length * length of the border of a rank, in diameters
"""
import argparse
import json
import math
import os
import pathlib
import statistics
import subprocess
import tempfile

import numpy

ROOT = pathlib.Path(__file__).resolve().parent.parent
DECK = """title = "lattice at touch"; integrator = "verlet"; dt = 1e-3; checkpoint = 100000.0; gravity = { g = 0.01; tilt = "0.25 pi"; };
constants = { n = 100; };
materials = ( { name = "grain"; k_n = 1e4; k_t = 5e3; gamma_n = 2; mu = 0.4; } );
box = { x = [ 0, "n" ]; y = [ 0, "0.866 * n" ]; periodic = "xy"; };
packings = ( { type = "triangular"; spacing = 1.001; jitter = 1.0; x = [ 0, "n" ]; y = [ 0, "0.866 * n" ]; radius = 0.5;
               density = 1.27; } );
phases = ( { steps = 100; series = 0; } );
"""


def start(arguments, folder, width, steps, ranks, threads, name):
    launch = [*arguments.launcher.split(), "-n", str(ranks)] if ranks > 1 else []
    return subprocess.Popen([*launch, arguments.program, "run", folder / "deck.cfg", "--quiet", "--force", "--threads", str(threads),
                             "-o", folder / name, "-D", f"constants.n={width}", "-D", f"phases[0].steps={steps}"],
                            stderr=subprocess.PIPE, text=True, env=os.environ | {"OMP_NUM_THREADS": str(threads)})


def finish(arguments, folder, process, name):
    """Seconds a step."""
    _, said = process.communicate()
    if process.returncode:
        raise SystemExit(said)
    told = subprocess.run([arguments.program, "info", "--json", folder / name], check=True, capture_output=True, text=True)
    return 1e-9 * json.loads(told.stdout)["step_nanoseconds"]


def seconds_a_step(arguments, folder, width, steps, ranks, threads):
    return finish(arguments, folder, start(arguments, folder, width, steps, ranks, threads, "r.h5"), "r.h5")


# --- model of a step ----------------------------------------------------------------------------------------------------

BYTES = 542  # a disk-step moves, to and from memory (tests/bench/README.md)
HEIGHT = 0.866  # of the box, over its width
GHOSTS = 1.6, 80  # disks per diameter of border, and bytes of each


def without_ends(arguments, folder, width, steps, ranks, programs=1):
    """Seconds a step, without the time in which disks are spread and come together: two runs of different length."""
    took = []
    for n in (steps, 3 * steps):
        running = [start(arguments, folder, width, n, ranks, 1, f"r{k}.h5") for k in range(programs)]
        took.append(n * statistics.mean([finish(arguments, folder, p, f"r{k}.h5") for k, p in enumerate(running)]))
    return (took[1] - took[0]) / (2 * steps)


def border(disks, ranks):
    """Of one rank, in diameters: of two in a periodic box both ends of a strip, of many the sides of a square."""
    return 2 * HEIGHT * math.sqrt(2 * disks) if ranks == 2 else 4 * math.sqrt(HEIGHT * disks)


def fit(disks, pair, two):
    """fixed, per_length: least squares of relative deviations."""
    beyond = [(t - p) / t for t, p in zip(two, pair)]
    rows = [[1 / t, border(n, 2) / t] for n, t in zip(disks, two)]
    return numpy.linalg.lstsq(numpy.array(rows), numpy.array(beyond), rcond=None)[0]


def predict(total, cores, alone, fixed, per_length, arguments):
    """Parts of a step, in seconds. Not measured: what the arguments say, an imbalance of half its limit, and half a microsecond
    for each of COLLECTIVES messages to every other rank where lists are renewed, every 50 steps."""
    COLLECTIVES = 11
    disks = total / cores
    length = border(disks, cores)
    compute = disks * max(alone, BYTES / arguments.memory)
    return {"compute": compute, "imbalance": 0.05 * compute, "border": per_length * length,
            "bytes": GHOSTS[0] * GHOSTS[1] * length / arguments.network,
            "latency": fixed + arguments.latency * (1 + 2 * math.ceil(math.log2(cores))),
            "renewals": COLLECTIVES * cores * 0.5e-6 / 50}


def fit_model(arguments, folder):
    disks, alone, pair, two = [], [], [], []
    print("| disks a rank | one program | two programs | two ranks | more than two programs |\n|---:|---:|---:|---:|---:|")
    for width in map(int, arguments.widths.split(",")):
        steps, wide = max(20, int(arguments.work / width ** 2)), round(width * math.sqrt(2))
        rounds = [(without_ends(arguments, folder, width, steps, 1), without_ends(arguments, folder, width, steps, 1, 2),
                   without_ends(arguments, folder, wide, steps, 2)) for _ in range(arguments.rounds)]
        a, p, t = (statistics.median(column) for column in zip(*rounds))
        disks.append(width ** 2)
        alone.append(a)
        pair.append(p)
        two.append(t)
        print(f"| {width ** 2} | {1e6 * a:.4g} us | {1e6 * p:.4g} us | {1e6 * t:.4g} us | {1e6 * (t - p):+.3g} us |", flush=True)
    fixed, per_length = fit(disks, pair, two)
    print(f"\nfixed {1e6 * fixed:.3g} us, {1e9 * per_length:.3g} ns per diameter of border; model over measured: "
          + ", ".join(f"{(p + fixed + per_length * border(n, 2)) / t:.2f}" for n, p, t in zip(disks, pair, two)))
    for total, cores in ((1e7, 100), (1e8, 1000)):
        parts = predict(total, cores, pair[-1] / disks[-1], fixed, per_length, arguments)
        whole = sum(parts.values())
        print(f"{total:.0e} disks on {cores} cores: {1e3 * whole:.3g} ms a step, efficiency {parts['compute'] / whole:.2f}; "
              + ", ".join(f"{name} {1e6 * part:.3g} us" for name, part in parts.items()))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--program", default=str(ROOT / "build/mpi/slipdisk"), help="a build with MPI (build/mpi/slipdisk)")
    parser.add_argument("--launcher", default="mpirun", help='starts ranks ("mpirun")')
    parser.add_argument("--widths", default="32,100,316", help="disks along x: about so many squared each (32,100,316)")
    parser.add_argument("--ways", default="1x1,2x1,1x2", help="ranks x threads (1x1,2x1,1x2)")
    parser.add_argument("--rounds", type=int, default=5, help="5")
    parser.add_argument("--work", type=float, default=2e7, help="disk-steps of a run (2e7)")
    parser.add_argument("--fit", action="store_true", help="the model of a step in place of the table of ways")
    parser.add_argument("--latency", type=float, default=2e-6, help="of a message between nodes, in s, for predictions (2e-6)")
    parser.add_argument("--network", type=float, default=2e8, help="bytes a second and core between nodes (2e8: 64 cores share 100 Gbit/s)")
    parser.add_argument("--memory", type=float, default=6e9, help="bytes a second and core from memory (6e9: 64 cores share 400 GB/s)")
    arguments = parser.parse_args()
    ways = [tuple(map(int, way.split("x"))) for way in arguments.ways.split(",")]
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        (folder / "deck.cfg").write_text(DECK)
        if arguments.fit:
            return fit_model(arguments, folder)
        print("| disks | " + " | ".join(f"{r} rank{'s' * (r > 1)} of {t}" for r, t in ways) + " |")
        print("|---|" + "---:|" * len(ways))
        for width in map(int, arguments.widths.split(",")):
            steps = max(20, int(arguments.work / width ** 2))
            took = {way: [] for way in ways}
            for _ in range(arguments.rounds):
                for way in ways:
                    took[way].append(seconds_a_step(arguments, folder, width, steps, *way))
            middle = {way: statistics.median(list_) for way, list_ in took.items()}
            print(f"| {width ** 2} | " + " | ".join(
                f"{1e6 * middle[way]:.4g} us ({middle[ways[0]] / middle[way]:.2f})" for way in ways) + " |", flush=True)


if __name__ == "__main__":
    main()
