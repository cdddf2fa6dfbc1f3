#!/usr/bin/env python3
"""Runs the tests that a change touches: all that differs from the last commit, or, where nothing does, that commit.

    tools/touched.py BUILD [--list]

A test is touched that has changed itself; that includes, in C, a header from the folder of a changed source; that has a word of its
name. A changed header stands for the sources that include it. BROAD and a sample of decks in every way to run come with each change
of sources. Changes of other files, and of headers that more than three folders include, touch all but the longest.
"""
import os
import pathlib
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[1]
BROAD = {"test_core", "test_floors", "test_circles", "test_names", "test_golden", "test_deck", "test_windows", "test_lanes", "test_ranks"}
SAMPLE = 16  # decks; others with each commit
TESTS = {path.stem: path for path in (ROOT / "tests").rglob("test_*.*") if path.suffix in (".c", ".py", ".sh")}


def git(*words):
    return subprocess.run(["git", "-C", ROOT, *words], stdout=subprocess.PIPE, text=True).stdout.splitlines()


def named(*words):
    return {name for name in TESTS if set(words) & set(name.split("_"))}


def of_source(path):
    folder = path.parent.relative_to("src")
    return BROAD | named(path.stem, *path.stem.split("_"), folder.name) | {
        name for name, test in TESTS.items() if test.suffix == ".c" and f'#include "{folder}/' in test.read_text()}


def of_file(path):
    if path.stem in TESTS:
        return {path.stem}
    if path.parts[0] == "docs" or path.suffix == ".md":
        return {name for name, test in TESTS.items() if test.parent.name == "docs"}
    if path.parts[0] == "src" and path.suffix in (".c", ".h"):
        including = git("grep", "-lF", f'#include "{path.relative_to("src")}"', "src") if path.suffix == ".h" else []
        users = [path, *map(pathlib.Path, including)]
        if len({user.parent for user in users}) <= 3:
            return set().union(*map(of_source, users))
    return set(TESTS)


def main(build, *words):
    changed = git("diff", "--name-only", "HEAD") + git("ls-files", "--others", "--exclude-standard") or git("diff", "--name-only", "HEAD~1")
    touched = set().union(*(of_file(pathlib.Path(name)) for name in changed))
    print(f"{len(changed)} changed files touch {len(touched)} of {len(TESTS)} tests.", flush=True)
    if "--list" in words:
        print(*sorted(touched))
        return 0
    if touched >= BROAD:
        first = SAMPLE * int(git("rev-list", "--count", "HEAD")[0])
        subprocess.run([sys.executable, "-m", "relations.crossing", "--first", str(first), "--count", str(SAMPLE)], cwd=ROOT / "tools",
                       env=os.environ | {"SLIPDISK_BUILD_DIR": str(build), "SLIPDISK_PROGRAM": f"{build}/slipdisk"}, check=True)
    return subprocess.run(["ctest", "--test-dir", build, "--output-on-failure", "-LE", "^(slow|long)$", "-j", str(os.cpu_count()),
                           "-R", f"^({'|'.join(sorted(touched))})$"]).returncode


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
