"""Determinism: the bits of the golden decks, in all ways to build and to run them.

Every way is compared with the default build's straight run, and that with tests/golden.csv. The small size tries the
program that is there; the full one also gcc and clang with -O0 ... -O3, whose trees are build/soak/COMPILER-OPTIMISATION
(a few minutes the first time). SLIPDISK_GOLDEN=write writes the table anew when all ways have agreed.
"""
import concurrent.futures
import dataclasses
import os
import shutil
import signal
import subprocess
import time

from . import golden
from .trial import ROOT, Row

STOPS = 3  # times that a resumed run is stopped
OPTIMISATIONS = ("-O0", "-O1", "-O2", "-O3")
# Threads wait for one another in every step, so on few cores they take long: other builds try them with these only.
THREADED = ("random_gear", "shake_gear", "compress", "drum")


@dataclasses.dataclass(frozen=True)
class Way:
    """How a deck is run."""
    kind: str      # its row
    build: str = "default"
    path: str = ""         # "": the best of the machine
    threads: int = 1
    skin: float = None     # in mean radii; None: chosen as the run goes
    lanes: bool = True
    workers: int = 1       # of a sweep
    resumed: bool = False

    def suits(self, deck):
        if self.skin is not None and not deck.radius:
            return False
        if self.threads > 1 and self.build != "default" and deck.name not in THREADED:
            return False
        # threads and restarts of three disks are those of single runs
        return deck.sweep if not self.lanes or self.workers > 1 else not deck.sweep or self.threads == 1

    def __str__(self):
        words = [self.build, self.path, f"{self.threads} threads" if self.threads > 1 else "",
                 f"skin {self.skin:g} radii" if self.skin is not None else "", "" if self.lanes else "--no-lanes",
                 f"-j {self.workers}" if self.workers > 1 else "", f"stopped {STOPS} times" if self.resumed else ""]
        return ", ".join(word for word in words if word)


# --- builds -----------------------------------------------------------------------------------------------------------


def build(compiler, optimisation):
    """The program of a tree of its own."""
    tree = ROOT / "build" / "soak" / f"{compiler}{optimisation}"
    # a build type without flags of its own, so that the level is the only one
    words = ["cmake", "-S", ROOT, "-B", tree, "-G", "Ninja", f"-DCMAKE_C_COMPILER={compiler}", "-DCMAKE_BUILD_TYPE=Plain",
             f"-DCMAKE_C_FLAGS={optimisation}", "-DSLIPDISK_TESTS=OFF"]
    for command in words, ["cmake", "--build", tree, "--target", "slipdisk_program"]:
        done = subprocess.run(list(map(str, command)), stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        if done.returncode:
            raise golden.Failed(f"{tree.name} cannot be built: {done.stdout[-300:]}")
    return tree / "slipdisk"


def builds(setup):
    """name -> program; the compilers that are not there; what has gone wrong."""
    found, missing, wrong = {"default": setup.program}, [], []
    if setup.size == "full":
        for compiler in "gcc", "clang":
            if not shutil.which(compiler):
                missing.append(compiler)
                continue
            for optimisation in OPTIMISATIONS:
                try:
                    found[f"{compiler} {optimisation}"] = build(compiler, optimisation)
                    setup.say(f"  built {compiler} {optimisation}")
                except golden.Failed as error:
                    wrong.append(str(error))
    return found, missing, wrong


def paths(program, work):
    """The instruction sets that this machine and build have: a run says which one it took."""
    deck, found = golden.decks()[0], []
    for path in golden.PATHS:
        result = work / f"path-{path}.h5"
        golden.finish(golden.command(program, deck, result, more={"phases.settle.steps": 10, "phases.measure.steps": 10}), path)
        if golden.path_of(result) == path:
            found.append(path)
    return found


def ways(setup, names, here):
    found = []
    for name in names:
        first = name == "default"
        found += [Way("instruction sets, compilers, optimisation", name, path) for path in here]
        found += [Way("lists at every step and rarely", name, skin=skin) for skin in (1e-6, 0.02, 1)]
        found += [Way("sweeps one by one instead of in lanes", name, lanes=False)]
        found += [Way("sweeps with two workers", name, workers=2)]
        found += [Way(f"stopped {STOPS} times, going on with other instructions", name, here[0], resumed=True)]
        threads = setup.pick((2,), (2, 3, 4, 8) if first else (3,))
        found += [Way("threads", name, threads=n) for n in threads]
        if first and setup.size == "full":
            found += [Way("threads", name, path, n) for path in here[1:] for n in (3,)]
    return found


# --- a trial ----------------------------------------------------------------------------------------------------------


def stop_at(words, path, parts, fraction, total):
    """Runs until a checkpoint at this fraction of the run is there, and stops it with a signal. False: it came to its end."""
    process = subprocess.Popen(words, env=golden.environment(path), stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    while process.poll() is None:
        steps = [int(p.stem.split("-")[1]) for p in parts.glob("checkpoint-*.h5")]
        if max(steps, default=0) >= fraction * total:
            process.send_signal(signal.SIGTERM)
            break
        time.sleep(0.0005)
    said, _ = process.communicate(timeout=600)
    if process.returncode not in (0, 75):
        raise golden.Failed(f"exit status {process.returncode}: {said[-300:]}")
    return process.returncode == 75


def run_resumed(program, deck, result, total, here):
    """Stopped three times on the way, each time going on with another instruction set."""
    parts = result.with_name(result.name + ".parts")
    # a checkpoint after every row of the series
    words = golden.command(program, deck, result, more={"checkpoint": 1e-6})
    for attempt in range(1, 6):
        stopped = [stop_at(words, here[k % len(here)], parts, (k + 1) / (STOPS + 1) / attempt, total) for k in range(STOPS)]
        if all(stopped):
            golden.finish(words, here[STOPS % len(here)])
            return
        result.unlink()
    raise golden.Failed("ended before it could be stopped")


def carry_out(programs, deck, way, work, total, here):
    """(Bits, result) of a deck in a way."""
    label = "".join(c if c.isalnum() else "-" for c in f"{deck.name} {way}")
    result = work / (label if deck.sweep else f"{label}.h5")
    if way.resumed and not deck.sweep:
        run_resumed(programs[way.build], deck, result, total, here)
    else:
        skin = None if way.skin is None else way.skin * deck.radius
        words = golden.command(programs[way.build], deck, result, way.threads, skin, way.lanes)
        golden.finish(words + (["-j", str(way.workers)] if way.workers > 1 else []), way.path)
        if way.path and golden.path_of(result) != way.path:
            raise golden.Failed(f"was run with {golden.path_of(result)}")
    return golden.bits(result), result


def compare(programs, deck, way, work, reference, here):
    """What is wrong; "": nothing."""
    kept, original = reference[deck.name]
    try:
        now, result = carry_out(programs, deck, way, work, kept.steps, here)
    except (golden.Failed, subprocess.TimeoutExpired, OSError) as error:
        return f"{deck.name}, {way}: {error}"
    column = "" if now == kept else golden.difference(original, result) or "the hash alone"
    golden.remove(result)
    return column and f"{deck.name}, {way}: {column} differs: state {now.state} instead of {kept.state}"


def compare_all(programs, work, reference, here, all_ways, say):
    """kind -> [what is wrong with each trial]; a difference is told at once."""
    trials = [(deck, way) for way in all_ways for deck in golden.decks()
              if way.suits(deck) and not (way.resumed and deck.sweep)]
    found = {way.kind: [] for way in all_ways}
    cores = os.cpu_count() or 1
    for many, workers in (False, cores), (True, 1):
        chosen = [(deck, way) for deck, way in trials if (way.threads > 1) == many]
        with concurrent.futures.ThreadPoolExecutor(workers) as pool:
            said = pool.map(lambda pair: compare(programs, *pair, work, reference, here), chosen)
            for (_, way), wrong in zip(chosen, said):
                found[way.kind].append(wrong)
                if wrong:
                    say(f"  {wrong}")
    return found


# --- rows -------------------------------------------------------------------------------------------------------------


def note_of_table(wrong, others):
    """Have the results changed, or do ways to run differ from one another?"""
    if not wrong:
        return "tests/golden.csv"
    if others:
        return wrong[0]
    return (f"{wrong[0]}; all ways to run and build it agree with one another: if the results have changed on purpose, "
            "SLIPDISK_GOLDEN=write writes the table anew")


def renew_table(reference, others, setup):
    if others:
        raise golden.Failed(f"{others} ways differ from one another: the table is not written")
    golden.write({name: bits for name, (bits, _) in reference.items()})
    setup.say(f"  {golden.TABLE} is written")


def run(setup):
    programs, missing, unbuilt = builds(setup)
    here = paths(setup.program, setup.work)
    left_out = [path for path in golden.PATHS if path not in here] + missing
    reference = {}
    for deck in golden.decks():
        reference[deck.name] = carry_out(programs, deck, Way("straight"), setup.work, 0, here)
    all_ways = ways(setup, programs, here)
    found = compare_all(programs, setup.work, reference, here, all_ways, setup.say)
    others = sum(bool(wrong) for said in found.values() for wrong in said)
    if os.environ.get("SLIPDISK_GOLDEN") == "write":
        renew_table(reference, others, setup)
    wrong = [said for name, (bits, _) in reference.items() if (said := golden.against(name, bits))]
    rows = [Row("the table of golden states", len(reference), len(wrong), note_of_table(wrong, others))]
    for kind, said in found.items():
        bad = [text for text in said if text]
        rows.append(Row(kind, len(said), len(bad), bad[0] if bad else ""))
    rows.insert(1, Row("builds", len(programs) + len(unbuilt), len(unbuilt), unbuilt[0] if unbuilt else ", ".join(programs)))
    rows[2].note = rows[2].note or ", ".join(here) + (f"; left out: {', '.join(left_out)}" if left_out else "")
    return rows
