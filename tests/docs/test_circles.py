"""Calls between the files of src/ go one way: no file needs, through others, a file that needs it.

What a file needs and has is read from the object files of the build (nm): functions and tables of other files. So a
newcomer can read from the bottom upwards, and every file can be tested with those below it alone.
"""
import collections
import os
import pathlib
import shutil
import subprocess
import sys
import unittest

BUILD = pathlib.Path(os.environ["SLIPDISK_BUILD_DIR"])
SRC = pathlib.Path(os.environ["SLIPDISK_SOURCE_DIR"]) / "src"


def objects():
    """name of a file below src/ -> its object files: kernels are compiled once per instruction set."""
    found = collections.defaultdict(list)
    for path in BUILD.glob("CMakeFiles/*.dir/src/**/*.c.o"):
        name = path.as_posix().split(".dir/src/")[1].removesuffix(".o")
        if (SRC / name).exists():  # the objects of files that are gone stay in the build tree
            found[name].append(path)
    return found


def symbols(paths):
    """(has, needs) of object files."""
    said = subprocess.run(["nm", "-P", *paths], check=True, stdout=subprocess.PIPE, text=True).stdout
    rows = [line.split() for line in said.splitlines()]
    return ({row[0] for row in rows if len(row) > 1 and row[1] in "TDBRVW"},
            {row[0] for row in rows if len(row) > 1 and row[1] == "U"})


def calls(found):
    """file -> {file that it needs: [names]}"""
    has, needs = {}, {}
    for name, paths in found.items():
        own, needs[name] = symbols(paths)
        has.update(dict.fromkeys(own, name))
    out = {name: collections.defaultdict(list) for name in found}
    for name, wanted in needs.items():
        for symbol in sorted(wanted):
            if has.get(symbol, name) != name:
                out[name][has[symbol]].append(symbol)
    return out


def circles(needs):
    """Files that need each other, through others or not (Tarjan, SIAM J. Comput. 1, 146 (1972))."""
    number, low, stack, out = {}, {}, [], []

    def visit(name):
        number[name] = low[name] = len(number)
        stack.append(name)
        for other in needs[name]:
            if other not in number:
                visit(other)
                low[name] = min(low[name], low[other])
            elif other in stack:
                low[name] = min(low[name], number[other])
        if low[name] == number[name]:
            at = stack.index(name)
            out.append(stack[at:])
            del stack[at:]

    for name in needs:
        if name not in number:
            visit(name)
    return [sorted(names) for names in out if len(names) > 1]


class Circles(unittest.TestCase):
    def test_finds_them(self):
        self.assertEqual(circles({"a": ["b"], "b": ["c", "d"], "c": ["a"], "d": []}), [["a", "b", "c"]])
        self.assertEqual(circles({"a": ["b", "c"], "b": ["c"], "c": []}), [])

    def test_there_are_none(self):
        needs = calls(objects())
        self.assertGreater(len(needs), 100)
        self.assertGreater(sum(map(len, needs.values())), 500)
        told = [f"{name} needs {other} for {', '.join(needs[name][other])}" for circle in circles(needs)
                for name in circle for other in needs[name] if other in circle]
        self.assertFalse(told, "\n" + "\n".join(told))


if __name__ == "__main__":
    if not shutil.which("nm"):
        print("nm not found: calls between files are not looked at")
        sys.exit(77)
    sys.setrecursionlimit(10000)
    unittest.main()
