#!/usr/bin/env python3
"""Are the tests sharp? Changes one thing in a file of physics, measure, model or pack, builds, and runs tests until one fails:

    tools/mutants.py --first 0 --count 300 --jobs 2

A mutant is an operator, a sign, a constant, a comparison, a branch or a statement, drawn by its number. It runs only tests that come to
its line, those first that find most in a second: once, each test of the preset quick runs in a build that counts lines, for
build/mutants/coverage.json. Builds have one kernel and little optimisation, which compiles fast and gives the same bits. They lie in clones
of HEAD (tree-0, ...), so the tree can be edited meanwhile: remove build/mutants to try another HEAD.

Goes on where the table ends. Columns: number, file, line, what, before, after, outcome, test that failed, tests that ran, tests that come
to the line, seconds. Outcomes: found; survived; not all (--most left tests out); no test comes here; same code (the compiler writes the
same library); does not compile."""
import argparse
import collections
import concurrent.futures
import csv
import json
import os
import pathlib
import random
import re
import signal
import subprocess
import time

ROOT = pathlib.Path(__file__).resolve().parent.parent
WORK = ROOT / "build" / "mutants"
ROOMS = ("physics", "measure", "model", "pack")
FLAGS = ("-G", "Ninja", "-DCMAKE_BUILD_TYPE=Mutant", *(f"-DSLIPDISK_{name}" for name in (
    "HAS_AVX2=OFF", "HAS_AVX512=OFF", "CCACHE=ON", "WERROR=OFF")))
SCRIPTS = ("slipdisk_program", "slipdisk_shared", "calls", "inject_memory", "ways")  # what tests that are no programs need
BUILDS = {"plain": "-O1 -mavx2", "counting": "-O1 -mavx2 --coverage -fprofile-filter-files=/src/[mp][a-z]*/"}
RULES = [
    ("operator", r"(?<=[\w)\]] )(\+|-|\*|/)(?= [\w(&-])", lambda r, s: r.choice([o for o in "+-*/" if o != s])),
    ("comparison", r"(?<= )(<=|>=|==|!=|<|>)(?= )", lambda r, s: r.choice([o for o in ("<=", ">=", "==", "!=", "<", ">") if o != s])),
    ("logic", r"(?<= )(&&|\|\|)(?= )", lambda r, s: "||" if s == "&&" else "&&"),
    ("sign", r"(?<=[=(,] )-(?=[\w(])", lambda r, s: ""),
    ("constant", r"(?<![\w.])(\d+\.\d+|[1-9]\d*)(?![\w.])", lambda r, s: f"({s} + 0.01)" if "." in s else str(int(s) + 1)),
    ("branch", r"(?<=\bif \()([^()]+|[^()]*\([^()]*\)[^()]*)(?=\) )", lambda r, s: r.choice(("true || ", "false && ")) + f"({s})"),
    ("statement", r"(?m)^ +[\w>.\[\]-]+ [-+*|]?= [^;{}]+;$", lambda r, s: ";"),
]
NO_CODE = re.compile(r'//[^\n]*|/\*.*?\*/|"(?:\\.|[^"\\])*"|^\s*#(?:\\\n|[^\n])*|_Static_assert[^;]*;|\bassert\([^;]*;', re.S | re.M)


def mutant(tree, number):
    """(file, position, rule, before, after)"""
    r = random.Random(f"mutant-{number}")
    files = sorted(p for room in ROOMS for p in (tree / "src" / room).rglob("*.[ch]"))
    sizes = [p.stat().st_size for p in files]
    while True:
        path = r.choices(files, sizes)[0]
        name, pattern, change = r.choice(RULES)
        text = path.read_text()
        if found := list(re.finditer(pattern, NO_CODE.sub(lambda m: re.sub(r"[^\n]", " ", m[0]), text))):
            m = r.choice(found)
            before = text[m.start():m.end()]
            return path, m.start(), name, before, change(r, before)


def run(words, tree, seconds=3600, **more):
    """(exit status, output); status None after that many seconds: then all its processes end."""
    more = os.environ | {"CCACHE_BASEDIR": str(tree), "CCACHE_NOHASHDIR": "1"} | more
    process = subprocess.Popen(list(map(str, words)), cwd=tree, env=more, start_new_session=True, text=True,
                               stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
    try:
        said = process.communicate(timeout=seconds)[0]
        return process.returncode, said
    except subprocess.TimeoutExpired:
        os.killpg(process.pid, signal.SIGKILL)
        return None, process.communicate()[0]


def build(tree, kind, *targets):
    """Exit status"""
    if not (tree / "build" / kind).exists():
        run(["cmake", "-S", ".", "-B", f"build/{kind}", *FLAGS, f"-DCMAKE_C_FLAGS_MUTANT={BUILDS[kind]}"], tree)
    return run(["ninja", "-C", f"build/{kind}", "-j", os.cpu_count(), *targets], tree)[0]


def ctest(tree, kind, name, seconds=3600, **more):
    """Exit status of a test; None: it hangs. No process takes more than 8 GB of memory or writes a larger file."""
    words = f"prlimit --data=8000000000 --fsize=8000000000 ctest --test-dir build/{kind} -R ^{name}$"
    return run(words.split(), tree, seconds, **more)[0]


def count_lines(tree):
    """coverage.json: {test: seconds} and {file: {line with code: tests that come there}}"""
    build(tree, "counting", "-k", "0")  # the examples do not link with counters
    names = re.findall(r"Test +#\d+: (\S+)", run(["ctest", "--test-dir", "build/counting", "-N", "-LE", "^(slow|long|install)$"], tree)[1])
    built, seconds, table = tree / "build" / "counting", {}, collections.defaultdict(dict)

    def one(name):
        folder, began = WORK / "counters" / name, time.monotonic()
        for notes in built.rglob("*.gcno"):  # gcov looks for them beside the counters
            (folder / notes.relative_to(built)).parent.mkdir(parents=True, exist_ok=True)
            (folder / notes.relative_to(built)).symlink_to(notes)
        if ctest(tree, "counting", name, GCOV_PREFIX=str(folder), GCOV_PREFIX_STRIP=str(len(built.parts) - 1)) == 0:
            seconds[name] = time.monotonic() - began
        said = run(["gcov", "--json-format", "--stdout", *folder.rglob("*.gcda")], folder)[1]
        for entry in [entry for row in said.splitlines() if row.startswith("{") for entry in json.loads(row)["files"]]:
            lines = table[entry["file"].rpartition("/src/")[2]]
            for line in entry["lines"]:
                lines.setdefault(line["line_number"], set()).update([name] if line["count"] and name in seconds else [])
        run(["rm", "-r", folder], WORK)
    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        list(pool.map(one, names))
    (WORK / "coverage.json").write_text(json.dumps([seconds, table], default=sorted))


class Chooser:
    """Tests that come to a line; first those that are likely to find most in a second, as learned on the way"""
    def __init__(self):
        self.seconds, self.lines = json.loads((WORK / "coverage.json").read_text())
        self.found, self.tried = collections.Counter(), collections.Counter()

    def come_to(self, file, text, line):
        lines, first, rows = self.lines.get(file, {}), line, text.split("\n")
        while str(first) not in lines and first > 1 and not re.search(r"[;{}]\s*(//.*|/\*.*)?$", rows[first - 2]):
            first -= 1  # a statement counts at one of its lines
        # a row of a table has no code: all tests that use the file, or all there are
        hits = [lines[str(at)] for at in range(first, line + 1) if str(at) in lines] or lines.values() or [self.seconds]
        share = collections.Counter(test for hit in lines.values() for test in hit)

        def rate(test):
            return (self.found[test] + share[test] / max(len(lines), 1)) / (self.tried[test] + 1) / (1 + self.seconds[test])
        return sorted({test for hit in hits for test in hit}, key=rate, reverse=True)


def library(tree):
    """What the compiler makes; None: an error"""
    return None if build(tree, "plain", "slipdisk_inside") else (tree / "build" / "plain" / "libslipdisk_inside.a").read_bytes()


def examine(tree, unchanged, chooser, tests, most):
    """(outcome, test that failed, tests that ran)"""
    compiled = library(tree)
    if compiled in (None, unchanged) or not tests:
        return "does not compile" if compiled is None else "same code" if compiled == unchanged else "no test comes here", "", 0
    ran = 0
    for test in tests:
        seconds = chooser.seconds[test]
        if seconds > most:
            continue
        most, ran = most - seconds, ran + 1
        build(tree, "plain", *([test] if list((tree / "tests").rglob(f"{test}.c")) else SCRIPTS))
        chooser.tried[test] += 1
        status = ctest(tree, "plain", test, max(60, 10 * seconds))
        if status is None or status and ctest(tree, "plain", test, max(60, 10 * seconds)) != 0:  # not if it fails only once
            chooser.found[test] += 1
            return "found", test + (" hangs" if status is None else ""), ran
    return ("survived" if ran == len(tests) else "not all"), "", ran


def trial(tree, unchanged, number, chooser, most):
    path, at, rule, before, after = mutant(tree, number)
    text, began = path.read_text(), time.monotonic()
    line = text[:at].count("\n") + 1
    tests = chooser.come_to(str(path.relative_to(tree / "src")), text, line)
    path.write_text(text[:at] + after + "\n" * before.count("\n") + text[at + len(before):])
    try:
        outcome = examine(tree, unchanged, chooser, tests, most)
    finally:
        path.write_text(text)
    return [number, path.relative_to(tree), line, rule, " ".join(before.split()), after, *outcome, len(tests),
            f"{time.monotonic() - began:.0f}"]


def main():
    parser = argparse.ArgumentParser(prog="tools/mutants.py", description=__doc__.split("\n")[0])
    parser.add_argument("--first", type=int, default=0, metavar="N")
    parser.add_argument("--count", type=int, default=10, metavar="N")
    parser.add_argument("--jobs", type=int, default=1, metavar="N", help="mutants at a time, each in a clone of its own")
    parser.add_argument("--most", type=float, default=1e9, metavar="SECONDS", help="of tests per mutant, by their usual time")
    parser.add_argument("-o", dest="table", type=pathlib.Path, default=WORK / "mutants.csv", metavar="FILE")
    args = parser.parse_args()
    trees = [WORK / f"tree-{job}" for job in range(args.jobs)]
    for tree in trees:
        if not tree.exists():
            subprocess.run(["git", "clone", "-q", ROOT, tree], check=True)
            (tree / "CITATION.cff").open("a").write("\n")  # so that no mutant changes the revision in the program
        run(["git", "checkout", "src"], tree)
    if not (WORK / "coverage.json").exists():
        count_lines(trees[0])
    free, chooser = [(tree, library(tree)) for tree in trees], Chooser()
    done = {int(row[0]) for row in csv.reader(args.table.open())} if args.table.exists() else set()

    def one(number):
        place = free.pop()
        row = trial(*place, number, chooser, args.most)
        free.append(place)
        with args.table.open("a", newline="") as file:
            csv.writer(file).writerow(row)
            print(*row, flush=True)
    with concurrent.futures.ThreadPoolExecutor(args.jobs) as pool:
        list(pool.map(one, sorted(set(range(args.first, args.first + args.count)) - done)))


if __name__ == "__main__":
    main()
