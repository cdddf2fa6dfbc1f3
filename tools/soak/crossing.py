"""Features of decks crossed with ways to run (tools/relations/crossing.py): thousands of decks, each in every way, in blocks of their
own so that a crash is a failure of one block. Builds of other compilers and of the validity checks that are there must have the same bits."""
import os
import subprocess
import sys

from .trial import ROOT, Row

BLOCK = 102
OTHERS = "check", "clang", "dev"


def run(setup):
    subprocess.run(["cmake", "--build", setup.build, "--target", "ways"], check=True, stdout=subprocess.DEVNULL)
    others = [ROOT / "build" / name for name in OTHERS if (ROOT / "build" / name / "tests" / "ways").exists()]
    count, first, failed, note = setup.pick(2 * BLOCK, 5000), setup.seed * 10**6, 0, ""
    # decks are written through the shared library, which builds that count or watch have not
    library = next((path for build in (setup.build, ROOT / "build" / "release") if (path := build / "libslipdisk.so").exists()), "")
    environment = {**os.environ, "PYTHONPATH": str(ROOT / "tools"), "SLIPDISK_BUILD_DIR": str(setup.build),
                   "SLIPDISK_LIBRARY": str(library), "SLIPDISK_PROGRAM": str(setup.program)}
    for at in range(0, count, BLOCK):
        words = [sys.executable, "-m", "relations.crossing", "--first", str(first + at), "--count", str(min(BLOCK, count - at)),
                 *(word for other in others for word in ("--build", str(other)))]
        done = subprocess.run(words, cwd=ROOT, env=environment, capture_output=True, text=True)
        lines = done.stdout.splitlines()
        if done.returncode not in (0, 1) or not lines:
            failed, note = failed + 1, f"decks from {first + at} on: status {done.returncode}: {done.stderr[-200:]}"
            continue
        wrong = int(lines[-1].split()[2])
        failed += wrong
        note = next((line for line in lines if line.startswith("deck ")), note) if wrong else note
    builds = "".join(f", also of build/{other.name}" for other in others)
    return [Row(f"decks with all features, each in every way to run{builds}", count, failed, note)]
