"""The golden decks: short versions of the decks in inputs/, and the bits that come out; see tests/golden.csv.

Of a result three hashes are kept. `state` is that of the whole final state (attribute `hash` of /state, sd_state_hash:
FNV-1a over every column of sd_fields in the table's order), so that it changes with every new or altered column.
`trajectory` is made here from what moves: the step, and of every body the position, images, angle and velocities, of
every contact lambda* and its reference direction, in the order of body numbers. It is the same whatever other columns
there are, in whichever order they or the slots stand. `results` is made of all datasets and attributes that readers of
a result use: series, frames, contacts, the summary with the means of every disk.
"""
import concurrent.futures
import csv
import dataclasses
import hashlib
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile

import h5py
import numpy

from .results import content, differences

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
TABLE = ROOT / "tests" / "golden.csv"
PATHS = ("avx512", "avx2", "baseline")

# One table of what is short: three disks see two periods and a half, packings fall, press, slide and turn.
RANDOM = {"dt": 4e-6, "motions.shake.ramp": 0.02, "phases.settle.steps": 10000, "phases.measure.steps": 50000}
SYNC = {"dt": 4e-6, "phases.rest.steps": 10000, "phases.measure.steps": 50000}
SHAKE = {"motions.shake.acceleration": 2, "motions.shake.ramp": 0.05, "phases.rest.time": 0.6, "phases.thermalise.time": 0.15,
         "phases.measure.time": 0.3}
VERLET, GEAR = {"integrator": "verlet"}, {"integrator": "gear5"}
# Eleven points: a full vector of the widest kind and a rest.
TILTS = {"sweep.replicas": 1, "sweep.parameters": '({ path = "gravity.tilt"; values = (%s); })' % ", ".join(
    str(k / 100) for k in range(11))}

ARC_PACKING = ('({ type = "triangular"; count = 40; spacing = 0.065; jitter = 0.9; x = [ -1.0, -0.6 ]; y = [ 1.1, 1.8 ]; '
               'sizes = "lognormal"; radius = 0.02; deviation = 0.15; density = 3.57; material = "grain"; group = "grains"; })')
ARC_MOTION = ('({ name = "sway"; wall = "left"; coordinate = "theta"; type = "table"; times = (0, 0.1, 0.25, 0.4); '
              'values = (0, 0.02, -0.02, 0); periodic = true; })')


@dataclasses.dataclass(frozen=True)
class Deck:
    name: str
    file: str
    keys: dict
    radius: float = 0.0  # mean, of decks whose lists of neighbours can be old; 0: there are none
    sweep: bool = False
    begins: str = ""  # the deck with whose result it begins, contacts and all

    def overrides(self, more=()):
        # a row of the series is where a run can be stopped
        keys = {"output.series": 2000, **self.keys, **dict(more)}
        return [word for key, value in keys.items() for word in ("-D", f"{key}={value}")]


def decks():
    three = [("random", "three_disk/random.cfg", {**RANDOM, "phases.measure.series": 2000}),
             ("sync", "three_disk/sync.cfg", {**SYNC, "phases.measure.series": 2000})]
    found = []
    for name, file, keys in three:
        for integrator, more in ("gear", GEAR), ("verlet", VERLET):
            found.append(Deck(f"{name}_{integrator}", file, {**keys, **more}))
            found.append(Deck(f"{name}_{integrator}_sweep", file, {**keys, **more, **TILTS}, sweep=True))
    return tuple(found) + (
        Deck("deposit", "packing/deposit.cfg", {"phases.deposit.time": 2}, 0.02),
        Deck("shake", "packing/shake_low.cfg", SHAKE, 0.02),
        Deck("shake_gear", "packing/shake_low.cfg", {**SHAKE, **GEAR}, 0.02),
        Deck("drum", "packing/drum.cfg", {
            "container.radius": 8, "packings[0].count": 100, "motions.turn.velocity": -0.1, "motions.turn.ramp": 1,
            "phases.fill.time": 8, "phases.start.time": 4, "phases.flow.time": 8}, 0.5),
        Deck("compress", "packing/jam_friction.cfg", {
            "phases.gather.compress.rate": 2e-3, "phases.press.compress.rate": 1e-3, "phases.press.time": 400,
            "phases.relax.time": 100}, 0.6),
        Deck("servo", "packing/servo.cfg", {
            "container.width": 12, "container.height": 12, "phases.isotropic.time": 5, "phases.biaxial.time": 3}, 0.5),
        Deck("clumps", "clumps/dimers.cfg", {"packings[0].count": 40, "container.width": 0.25, "phases.fall.time": 0.6}, 0.01),
        Deck("cell", "shear/simple.cfg", {"packings[0].count": 100, "container.width": 11.7, "container.height": 11.7,
                                          "phases.slow.time": 5, "phases.fast.time": 3}, 0.5),
        Deck("hertz", "laws/hertz_mindlin.cfg", {"packings[0].count": 60, "container.width": 8, "phases.pour.time": 4}, 0.5),
        Deck("wet", "laws/wet.cfg", {"packings[0].count": 80, "phases.settle.time": 20, "phases.stand.time": 20}, 0.5),
        # rolling resistance; what leaves the bounds is taken out
        Deck("bounds", "laws/heap_rolling.cfg", {"packings[0].count": 60, "packings[0].interval": 0.5, "bounds.x": "(-5, 5)",
                                                 "phases.pour.time": 40}, 0.5),
        Deck("tiles", "packing/jam_friction.cfg", {
            "packings[0].tiles": 4, "phases.gather.compress.rate": 2e-3, "phases.press.compress.rate": 1e-3,
            "phases.press.time": 200, "phases.relax.time": 50}, 0.6),
        # random radii and places, arcs of which one moves by a table, and disks in free flight
        Deck("arc", "walls/arc.cfg", {"packings": ARC_PACKING, "motions": ARC_MOTION, "phases[0].time": 1.5}, 0.02),
        # bonds that bend and break
        Deck("bonds", "bonds/agglomerate.cfg", {
            "packings[0].count": 60, "packings[0].x": "(-6, 6)", "packings[0].y": "(-5, 5)", "constants.speed": 0.3,
            "phases.gather.time": 40, "phases.loose.time": 5, "phases.hit.time": 15, "phases.after.time": 1}, 0.5),
        Deck("carried", "packing/shake_low.cfg", {**SHAKE, "phases.rest.time": 0.03, "packings": "()"}, 0.02, begins="shake"),
    )


# --- running ----------------------------------------------------------------------------------------------------------


class Failed(Exception):
    """A run that did not end as it should."""


def command(program, deck, result, threads=1, skin=None, lanes=True, more=()):
    more = {**dict(more), **({} if skin is None else {"skin": skin})}
    if deck.begins:
        start = pathlib.Path(result).parent / f"{deck.begins}-start.h5"
        if not start.exists():
            finish(command(program, next(d for d in decks() if d.name == deck.begins), start))
        more["disk_files"] = f'({{ file = "{start}"; contacts = true; }})'
    words = [str(program), "sweep" if deck.sweep else "run", str(ROOT / "inputs" / deck.file), *deck.overrides(more)]
    words += ["-o", str(result), "--quiet"] if lanes or not deck.sweep else ["-o", str(result), "--quiet", "--no-lanes"]
    # any number of threads ends lanes
    return words + (["--threads", str(threads)] if threads > 1 or not deck.sweep else [])


def environment(path=None):
    found = {key: value for key, value in os.environ.items() if key != "SLIPDISK_PATH"}
    return {**found, "SLIPDISK_PATH": path} if path else found


def finish(words, path=None, seconds=1800):
    done = subprocess.run(words, env=environment(path), stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
                          timeout=seconds)
    if done.returncode:
        raise Failed(f"exit status {done.returncode}: {done.stdout.strip()[-300:]}")


def remove(result):
    shutil.rmtree(result, ignore_errors=True) if result.is_dir() else result.unlink(missing_ok=True)


def results_of(result):
    """The files of a run or of a sweep's points."""
    return sorted((result / "points").glob("*.h5")) if result.is_dir() else [result]


def path_of(result):
    """The instructions that a run was advanced with."""
    with h5py.File(results_of(result)[0]) as file:
        return text(file["parameters"].attrs["cpu_path"])


# --- bits -------------------------------------------------------------------------------------------------------------


def text(value):
    return value.decode() if isinstance(value, bytes) else str(value)


BODIES = ("x", "y", "image_x", "image_y", "turn", "theta", "vx", "vy", "omega")
CONTACTS = ("contact_lambda_ref", "contact_ex", "contact_ey")


def moving(state):
    """name -> array, of what the trajectory's hash is made of."""
    found = {"step": numpy.asarray(state["step"][()])}
    order = numpy.argsort(state["id"][()], kind="stable")
    for name in BODIES:
        found[name] = state[name][()][order]
    a, b, part = (state[f"contact_{end}"][()] for end in ("a", "b", "part"))
    order = numpy.lexsort((part, b, a))
    for name in ("contact_a", "contact_b", "contact_part", *CONTACTS):
        found[name] = state[name][()][order]
    return found


def trajectory_hash(state):
    sum_ = hashlib.sha256()
    for array in moving(state).values():
        sum_.update(numpy.ascontiguousarray(array, dtype=array.dtype.newbyteorder("<")).tobytes())
    return sum_.hexdigest()[:16]


RESULTS = ("observables", "particles", "contacts", "summary")


def results_hash(path):
    sum_ = hashlib.sha256()
    for name, value in sorted(content(path).items()):
        if name.startswith(RESULTS):
            sum_.update(name.encode() + value)
    return sum_.hexdigest()[:16]


@dataclasses.dataclass(frozen=True)
class Bits:
    """What the table keeps of a deck; a sweep's hashes are those of its points' hashes."""
    steps: int
    contacts: int
    state: str
    trajectory: str
    results: str


HASHES = ("state", "trajectory", "results")


def bits(result):
    hashes, steps, contacts = [], 0, 0
    for path in results_of(result):
        with h5py.File(path) as file:
            state = file["state"]
            hashes.append((text(state.attrs["hash"]), trajectory_hash(state), results_hash(path)))
            steps += int(state["step"][()])
            contacts += int(state.attrs["n_contacts"])
    if not hashes:
        raise Failed("there is no result")
    if len(hashes) == 1:
        return Bits(steps, contacts, *hashes[0])
    return Bits(steps, contacts, *(hashlib.sha256("".join(x).encode()).hexdigest()[:16] for x in zip(*hashes)))


def column_of(file, name):
    return file["state"][name][()] if name in file["state"] else None


def difference(one, two):
    """The first column of the state that differs between two results, what moves first; "": none does."""
    for a, b in zip(results_of(one), results_of(two)):
        with h5py.File(a) as f, h5py.File(b) as g:
            x, y = moving(f["state"]), moving(g["state"])
            for name in [*x, *f["state"]]:
                p, q = (x[name], y[name]) if name in x else (column_of(f, name), column_of(g, name))
                if q is None or numpy.asarray(p).tobytes() != numpy.asarray(q).tobytes():
                    return f"{name} ({a.stem})" if len(results_of(one)) > 1 else name
        for name in differences(content(a), content(b)):
            if name.startswith(RESULTS):
                return f"{name} ({a.stem})" if len(results_of(one)) > 1 else name
    return ""


# --- the table --------------------------------------------------------------------------------------------------------

HEAD = """\
# The final states of short runs, in bits; the decks are in tools/soak/golden.py, which says what the hashes are of.
# tests/physics/test_golden.py holds the default build to them, tools/soak.sh determinism all builds
# and ways to run.
#
# When results are meant to change:  SLIPDISK_GOLDEN=write tools/soak.sh determinism
# writes the table anew, after all variants have agreed with one another. `state` changes with every column of the state,
# `trajectory` with what moves only: where only `state` changes no disk goes another way.
# `results` changes with what the summary, series, frames and contacts of the result file say.
#
# The bits are those of every processor, C library and compiler: tools/arm.sh runs the decks on another processor.
"""


def read(table=TABLE):
    """name -> Bits"""
    with open(table, newline="") as file:
        rows = csv.DictReader(line for line in file if not line.startswith("#"))
        return {row["deck"]: Bits(int(row["steps"]), int(row["contacts"]), *(row[name] for name in HASHES)) for row in rows}


def write(found, table=TABLE):
    lines = [HEAD + ",".join(("deck", "steps", "contacts", *HASHES))]
    lines += [",".join(map(str, (name, *dataclasses.astuple(b)))) for name, b in found.items()]
    table.write_text("\n".join(lines) + "\n")


def against(name, now, table=TABLE):
    """What is to be said of a deck whose bits are not the table's; "": they are."""
    kept = read(table).get(name)
    if kept is None:
        return f"{name}: is not in {table.name}"
    if kept == now:
        return ""
    what = ("state and trajectory" if kept.trajectory != now.trajectory else
            "state, but not the trajectory," if kept.state != now.state else "results, but not the state,")
    pairs = ", ".join(f"{n} {getattr(now, n)} instead of {getattr(kept, n)}" for n in HASHES if getattr(now, n) != getattr(kept, n))
    return (f"{name}: {what} differ from {table.name}: {pairs}, {now.steps} steps instead of {kept.steps}")


def main(program, names):
    """Compares a program with the table; the decks run side by side, one on each core."""
    chosen = [deck for deck in decks() if not names or deck.name in names]
    with tempfile.TemporaryDirectory() as folder, concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        def differs(deck):
            result = pathlib.Path(folder) / (deck.name if deck.sweep else f"{deck.name}.h5")
            try:
                finish(command(program, deck, result))
                return against(deck.name, bits(result))
            except (Failed, OSError, subprocess.TimeoutExpired) as error:
                return f"{deck.name}: {error}"

        wrong = 0
        for deck, found in zip(chosen, pool.map(differs, chosen)):
            print(found or f"{deck.name}: the bits of the table", flush=True)
            wrong += bool(found)
    print(f"{len(chosen) - wrong} of {len(chosen)} decks have the bits of {TABLE.name}")
    return bool(wrong or not chosen)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1], sys.argv[2:]))
