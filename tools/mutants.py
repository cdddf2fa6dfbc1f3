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
# Tests that find most come first, then all others of the preset quick.
FIRST = ("test_golden", "test_crossing", "test_conservation", "test_laws_mixed", "test_validation", "test_mean", "test_disk_means",
         "test_motion", "test_advice")
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


def build(tree):
    done = run(["cmake", "--build", "build/release"], tree)
    return done is not None and done.returncode == 0


def failing_test(tree):
    """The name of the first test that fails; None: all pass."""
    first = "^(" + "|".join(FIRST) + ")$"
    rest = ["-LE", "^(slow|long|install)$"]
    for words in (["-R", first], ["-E", first, *rest]):
        done = run(["ctest", "--test-dir", "build/release", "--stop-on-failure", "-j", str(os.cpu_count()), "--timeout", "300", *words], tree)
        if done is None or done.returncode:
            names = re.findall(r"\d+ - (\S+) \(", done.stdout) if done else []
            return names[0] if names else "it hangs"
    return None


def clone(folder):
    if not folder.exists():
        subprocess.run(["git", "clone", "-q", ROOT, folder], check=True)
        subprocess.run(["cmake", "--preset", "release", "--log-level=WARNING"], cwd=folder, check=True, stdout=subprocess.DEVNULL)
    if not build(folder) or failing_test(folder):
        raise SystemExit(f"{folder}: the tests do not pass without a mutant")


def trial(tree, number):
    path, at, rule, before, after = mutant(tree, number)
    text, began = path.read_text(), time.monotonic()
    path.write_text(text[:at] + after + text[at + len(before):])
    try:
        test = failing_test(tree) if build(tree) else ""
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
