"""Relations between decks that must hold whatever the deck (tools/relations): thousands of decks at random, in processes of
their own, so that a crash is a failure of one of them."""
import collections
import concurrent.futures
import json
import os
import subprocess
import sys

from relations.table import RELATIONS, again, usual
from .trial import ROOT, Row

CHUNK = 40   # decks that a process tries
WORKERS = 2


def chunk(setup, name, first, count):
    """[(seed, outcome, what was said)]"""
    words = [sys.executable, "-m", "relations", name, "--first", str(first), "--count", str(count), "--json"]
    environment = {**os.environ, "PYTHONPATH": str(ROOT / "tools"), "SLIPDISK_BUILD_DIR": str(setup.build),
                   "SLIPDISK_LIBRARY": str(setup.build / "libslipdisk.so"), "SLIPDISK_PROGRAM": str(setup.program)}
    done = subprocess.run(words, cwd=ROOT, env=environment, capture_output=True, text=True)
    lines = [json.loads(line) for line in done.stdout.splitlines()]
    found = [(line["seed"], line["outcome"], line["said"]) for line in lines if line["outcome"] != "begun"]
    if len(found) < count:  # the process ended in the middle
        begun = lines[-1]["seed"] if lines else first
        found.append((begun, "wrong", f"the process ended with status {done.returncode}: {done.stderr[-300:]}"))
        if begun + 1 < first + count:
            found += chunk(setup, name, begun + 1, first + count - begun - 1)
    return found


def relation(setup, pool, name):
    count = setup.pick(12, 1200) // RELATIONS[name].cost
    first = setup.seed * 10**6
    chunks = [(first + k, min(CHUNK, count - k)) for k in range(0, count, CHUNK)]
    found = [trial for part in pool.map(lambda c: chunk(setup, name, *c), chunks) for trial in part]
    outcomes = collections.Counter(outcome for _, outcome, _ in found)
    wrong = [(seed, said) for seed, outcome, said in found if outcome == "wrong"]
    for seed, said in wrong[:20]:
        setup.say(f"  {again(name, seed)}: {said.strip().splitlines()[-1]}", flush=True)
    note = f"{outcomes['refused']} decks refused" if outcomes["refused"] else ""
    if wrong:
        note = f"{again(name, wrong[0][0])}: {wrong[0][1].strip().splitlines()[-1]}"
    # a relation that hardly any deck suits shows nothing
    return Row(f"{name}: {RELATIONS[name].what()}"[:58], len(found), len(wrong) + (outcomes["held"] * 2 < len(found)), note)


def run(setup):
    with concurrent.futures.ThreadPoolExecutor(WORKERS) as pool:
        return [relation(setup, pool, name) for name in usual()]
