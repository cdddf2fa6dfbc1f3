#!/usr/bin/env python3
"""Are the tests sharp? Changes one thing in a file of physics, measure, model or pack, builds, and runs the tests of tools/test.sh until
one fails:

    tools/mutants.py --first 0 --count 300 -o build/mutants.csv

A mutant is an operator, a sign, a constant, a comparison, a branch or a statement, drawn by its number. Works in a clone of HEAD
(build/mutants), so the tree can be edited meanwhile. Goes on where the table ends. Columns: number, file, line, what, before, after,
outcome (found, survived, does not compile), test, seconds."""
import argparse
import csv
import os
import pathlib
import random
import re
import subprocess
import time

ROOT = pathlib.Path(__file__).resolve().parent.parent
ROOMS = ("physics", "measure", "model", "pack")
# (what is built, tests to run): those that find most in the shortest time come first, then all others of the preset quick.
STAGES = (
    ("slipdisk_program", ["-R", "^test_(golden|validation|conservation)$"]),
    ("all", ["-R", "^test_(crossing|laws_mixed|mean|disk_means|motion|advice|configuration|cell|clumps|windows|lanes|bounds|waves)$"]),
    ("all", ["-LE", "^(slow|long|install)$"]),
)
RULES = [
    ("operator", r"(?<=[\w)\]] )(\+|-|\*|/)(?= [\w(&-])", lambda r, s: r.choice([o for o in "+-*/" if o != s])),
    ("comparison", r"(?<= )(<=|>=|==|!=|<|>)(?= )", lambda r, s: r.choice([o for o in ("<=", ">=", "==", "!=", "<", ">") if o != s])),
    ("logic", r"(?<= )(&&|\|\|)(?= )", lambda r, s: "||" if s == "&&" else "&&"),
    ("sign", r"(?<=[=(,] )-(?=[\w(])", lambda r, s: ""),
    ("constant", r"(?<![\w.])(\d+\.\d+|[1-9]\d*)(?![\w.])", lambda r, s: f"({s} + 0.01)" if "." in s else str(int(s) + 1)),
    ("branch", r"(?<=\bif \()([^()]+|[^()]*\([^()]*\)[^()]*)(?=\) )", lambda r, s: r.choice(("true || ", "false && ")) + f"({s})"),
    ("statement", r"(?m)^ +[\w>.\[\]-]+ [-+*|]?= [^;{}]+;$", lambda r, s: ";"),
]
CODE = re.compile(r'//[^\n]*|/\*.*?\*/|"(?:\\.|[^"\\])*"|^\s*#(?:\\\n|[^\n])*|_Static_assert[^;]*;|\bassert\([^;]*;', re.S | re.M)


def code_only(text):
    """The text with comments, strings, directives and assertions blanked."""
    return CODE.sub(lambda m: re.sub(r"[^\n]", " ", m[0]), text)


def mutant(tree, number):
    """(file, position, rule, before, after)"""
    r = random.Random(f"mutant-{number}")
    files = sorted(p for room in ROOMS for p in (tree / "src" / room).rglob("*.[ch]"))
    sizes = [p.stat().st_size for p in files]
    while True:
        path = r.choices(files, sizes)[0]
        name, pattern, change = r.choice(RULES)
        found = list(re.finditer(pattern, code_only(path.read_text())))
        if found:
            m = r.choice(found)
            before = path.read_text()[m.start():m.end()]
            return path, m.start(), name, before, change(r, before)


def run(words, tree, seconds=3600):
    try:
        return subprocess.run(words, cwd=tree, capture_output=True, text=True, timeout=seconds)
    except subprocess.TimeoutExpired:
        return None


def ctest(tree, *words):
    """The name of the first test that fails, or None."""
    done = run(["ctest", "--test-dir", "build/release", "--stop-on-failure", "-j", str(os.cpu_count()), "--timeout", "300", *words], tree)
    if done is not None and done.returncode == 0:
        return None
    names = re.findall(r"\d+ - (\S+) \((?!Skipped|Disabled)", done.stdout) if done else []
    return names[0] if names else "it hangs"


def first_failure(tree):
    """The name of the first test that fails, twice; "": it does not compile; None: all pass."""
    for target, tests in STAGES:
        done = run(["cmake", "--build", "build/release", "--target", target], tree)
        if done is None or done.returncode:
            return ""
        while (name := ctest(tree, *tests)) is not None:
            if name == "it hangs" or ctest(tree, "-R", f"^{name}$"):
                return name
            print("once only:", name, flush=True)
    return None


def clone(folder):
    if not folder.exists():
        subprocess.run(["git", "clone", "-q", ROOT, folder], check=True)
        subprocess.run(["cmake", "--preset", "release", "--log-level=WARNING"], cwd=folder, check=True, stdout=subprocess.DEVNULL)
    head = subprocess.run(["git", "rev-parse", "HEAD"], cwd=folder, check=True, capture_output=True, text=True).stdout
    passed = folder / "build" / "passed"
    if passed.exists() and passed.read_text() == head:
        return
    failure = first_failure(folder)
    if failure is not None:
        raise SystemExit(f"{folder}: {failure or 'the build'} fails without a mutant")
    passed.write_text(head)


def trial(tree, number):
    path, at, rule, before, after = mutant(tree, number)
    text, began = path.read_text(), time.monotonic()
    path.write_text(text[:at] + after + text[at + len(before):])
    try:
        test = first_failure(tree)
    finally:
        path.write_text(text)
    outcome = "does not compile" if test == "" else "found" if test else "survived"
    line = text[:at].count("\n") + 1
    return [number, path.relative_to(tree), line, rule, before.strip(), after, outcome, test or "", f"{time.monotonic() - began:.0f}"]


def main():
    parser = argparse.ArgumentParser(prog="tools/mutants.py", description=__doc__.split("\n")[0])
    parser.add_argument("--first", type=int, default=0, metavar="N")
    parser.add_argument("--count", type=int, default=10, metavar="N")
    parser.add_argument("-o", dest="table", type=pathlib.Path, default=ROOT / "build" / "mutants.csv", metavar="FILE")
    parser.add_argument("--list", action="store_true", help="say which they are, and stop")
    args = parser.parse_args()
    numbers = range(args.first, args.first + args.count)
    if args.list:
        for number in numbers:
            path, at, rule, before, after = mutant(ROOT, number)
            print(number, f"{path.relative_to(ROOT)}:{path.read_text()[:at].count(chr(10)) + 1}", rule, repr(before), "->", repr(after))
        return
    done = {int(row[0]) for row in csv.reader(args.table.open())} if args.table.exists() else set()
    tree = ROOT / "build" / "mutants"
    clone(tree)
    for number in numbers:
        if number in done:
            continue
        row = trial(tree, number)
        with args.table.open("a", newline="") as file:
            csv.writer(file).writerow(row)
        print(*row, flush=True)


if __name__ == "__main__":
    main()
