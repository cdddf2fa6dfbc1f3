"""Millions of damaged inputs, under sanitizers, with a limit on time and memory of each.

The harnesses are tests/fuzz/fuzz_*.c (libFuzzer, clang), their seeds tests/fuzz/corpus and the decks of inputs/.
"""
import concurrent.futures
import os
import pathlib
import re
import subprocess
import sys

import h5py
import numpy

from .trial import ROOT, Row

# Harness: share of the executions, longest input in bytes. HDF5 is slow: each execution writes and reads a file.
HARNESSES = {"deck": (0.40, 6000), "override": (0.20, 600), "csv": (0.16, 2000), "lammps": (0.16, 2000),
             "hdf5": (0.08, 400)}
SMALL, FULL = 100_000, 10_000_000
SECONDS, RSS, ALLOCATION = 10, 1500, 700   # of one execution; MiB of the process, and of one allocation

DECK = """dt = 1e-4; gravity = { g = 9.81; }; materials = ( { name = "m"; k_n = 1e4; k_t = 5e3; gamma_n = 3; mu = 0.5; } );
disks = ( { name = "a"; x = 0; y = 0.999; radius = 1; mass = 1; group = "g"; },
  { x = 1.9995; y = 0.999; radius = 1; mass = 1; fixed = true; }, { x = 0.9; y = 2.785; radius = 1; mass = 1; } );
walls = ( { name = "floor"; type = "line"; points = ( (-9, 0), (9, 0) ); },
  { type = "polyline"; points = ( (-0.9995, 0), (-0.9995, 4), (-2, 5) ); } );
phases = ( { name = "p"; steps = 40; }, { steps = 60; } ); output = { series = 50; frames = 50; contacts = 50; };
measure = { rotation = ("a"); sliding = ( { disk = "a"; partners = ("floor", 1); } ); disks = true; };
"""


def build():
    """The folder of the harnesses."""
    for words in (["cmake", "--preset", "fuzz"], ["cmake", "--build", "--preset", "fuzz"]):
        done = subprocess.run(words, cwd=ROOT, check=False, capture_output=True, text=True)
        if done.returncode != 0:
            sys.exit(f"{' '.join(words)} failed:\n{done.stdout}{done.stderr}")
    return ROOT / "build" / "fuzz" / "tests" / "fuzz"


def sound_files(setup):
    """A result and tables of each form: what the harness of HDF5 alters."""
    (setup.work / "sound.cfg").write_text(DECK)
    result, table = setup.work / "sound.h5", setup.work / "table.h5"
    sealed = setup.work / "sealed.h5"
    subprocess.run([setup.program, "run", setup.work / "sound.cfg", "-o", sealed, "--quiet"], check=True)
    # without its checksum, which would keep the readers from all that is altered
    with h5py.File(sealed) as new, h5py.File(result, "w") as old:
        for key in new:
            new.copy(key, old)
        old.attrs.update({name: value for name, value in new.attrs.items() if name != "sealed"})
    x, radius = numpy.array([0.0, 3.0, 6.0]), numpy.array([1.0, 1.0, 0.5])
    with h5py.File(table, "w") as file:
        rows = numpy.zeros(3, dtype=[("x", "f8"), ("y", "f4"), ("radius", "f8"), ("id", "i8")])
        rows["x"], rows["radius"] = x, radius
        file["compound"] = rows
        file["matrix"] = numpy.column_stack([x, 0 * x, radius])
        file["matrix"].attrs["columns"] = "x,y,radius"
        for name, values in (("x", x), ("y", 0 * x), ("radius", radius)):
            file[f"columns/{name}"] = values
        disks = file.create_group("particles/disks")
        disks["position/value"] = numpy.zeros((2, 3, 2))
        disks["position/step"] = disks["position/time"] = numpy.arange(2)
        disks["velocity/value"] = numpy.zeros((2, 3, 2))
        disks["velocity/step"], disks["angular_velocity/step"] = disks["position/step"], 1
        disks["angular_velocity/value"] = numpy.zeros((2, 3))
        disks["id"] = numpy.array([4, 2, -1])
        disks["box/edges"] = numpy.eye(3)
        disks["radius"] = radius
    return f"{result}:{table}"


def harness(setup, folder, name, n, files):
    """Runs one; a row."""
    share, longest = HARNESSES[name]
    runs = max(1000, int(n * share))
    grown, found = setup.work / f"grown_{name}", setup.work / f"found_{name}"
    grown.mkdir()
    found.mkdir()
    seeds = [ROOT / "tests" / "fuzz" / "corpus" / name] + ([ROOT / "inputs"] if name == "deck" else [])
    words = [folder / f"fuzz_{name}", f"-runs={runs}", f"-seed={setup.seed}", f"-timeout={SECONDS}",
             f"-rss_limit_mb={RSS}", f"-malloc_limit_mb={ALLOCATION}", f"-max_len={longest}", "-len_control=0",
             "-print_final_stats=1", "-verbosity=1", f"-artifact_prefix={found}/", grown, *seeds]
    done = subprocess.run(words, cwd=setup.work, env=dict(os.environ, SLIPDISK_FUZZ_FILES=files), check=False,
                          stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                          text=True, errors="replace")
    count = re.search(r"stat::number_of_executed_units:\s*(\d+)", done.stdout)
    executed = int(count.group(1)) if count else 0
    if done.returncode == 0 and executed >= runs:
        peak = re.search(r"stat::peak_rss_mb:\s*(\d+)", done.stdout)
        return Row(f"fuzz {name}", executed, 0, f"at most {peak.group(1)} MiB" if peak else "")
    kept = keep(setup, name, found, done.stdout)
    why = re.search(r"(ERROR: .*|runtime error: .*|.*Assertion .* failed.*)", done.stdout)
    return Row(f"fuzz {name}", executed, 1, f"{why.group(1)[:160] if why else 'ended early'}; see {kept}")


def keep(setup, name, found, output):
    """The inputs that were found, and what was said, out of the scratch folder."""
    folder = pathlib.Path(setup.build) / "fuzz_findings" / name
    folder.mkdir(parents=True, exist_ok=True)
    for path in found.iterdir():
        (folder / path.name).write_bytes(path.read_bytes())
    (folder / "output.txt").write_text(output)
    return folder


def run(setup):
    folder, files = build(), sound_files(setup)
    n = setup.pick(SMALL, FULL)
    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as workers:
        return list(workers.map(lambda name: harness(setup, folder, name, n, files), HARNESSES))
