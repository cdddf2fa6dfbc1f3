"""Calls between the files of src/ go one way: no file needs, through others, a file that needs it, and none needs a file of a
floor or a room above its own.

What a file needs and has is read from the object files of the build (nm): functions and tables of other files. So a
newcomer can read from the bottom upwards, and every file can be tested with those below it alone. The core (base, model,
physics, measure, pack) needs no library but GSL, prints nothing by itself, and does not end the process.
"""
import collections
import os
import pathlib
import re
import subprocess
import sys
import unittest

from test_floors import FLOORS, ROOMS

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


def symbols(found):
    """name -> (has, needs)"""
    names = {str(path): name for name, paths in found.items() for path in paths}
    out = {name: (set(), set()) for name in found}
    said = subprocess.run(["nm", "-P", "-A", *names], check=True, stdout=subprocess.PIPE, text=True).stdout
    for line in said.splitlines():
        path, symbol, kind = line.split()[:3]
        has, needs = out[names[path.removesuffix(":")]]
        if kind in "TDBRVW":
            has.add(symbol)
        elif kind == "U":
            needs.add(symbol)
    return out


def calls(found):
    """name -> {file that it needs: [names]}"""
    has = {symbol: name for name, (own, _) in found.items() for symbol in own}
    out = {name: collections.defaultdict(list) for name in found}
    for name, (_, wanted) in found.items():
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


CORE = ("base", "model", "physics", "measure", "pack")
OUTSIDE = ("base/comm_job.c", "base/comm_queue.c", "base/comm_cuts.c", "base/comm_cuts_zoltan.c")
# The tables of kernels of one instruction set name those of all rooms.
TABLES = {("physics/step/kernel_integrate.c", "physics/small/kernel_lanes.c"),
          ("physics/system/kernels.c", "physics/step/kernel_integrate.c")}
# Of the C library, and of others. base/memory.c ends a process that has no memory and no handler for it.
NEVER = re.compile(r"^(printf|__printf_chk|puts|putchar|perror|stdout|stderr|exit|_exit|_Exit|quick_exit|abort"
                   r"|H5|config_|json_|MPI_|Zoltan_|deflate)")


def is_above(name, other):
    """Does `other` lie on a floor, or in a room, above?"""
    one, two = name.split("/"), other.split("/")
    if one[0] != two[0]:
        return FLOORS.index(two[0]) > FLOORS.index(one[0])
    rooms = ROOMS.get(one[0])
    return bool(rooms) and rooms.index(two[1]) > rooms.index(one[1])


class Circles(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.found = symbols(objects())
        cls.needs = calls(cls.found)

    def test_finds_them(self):
        self.assertEqual(circles({"a": ["b"], "b": ["c", "d"], "c": ["a"], "d": []}), [["a", "b", "c"]])
        self.assertEqual(circles({"a": ["b", "c"], "b": ["c"], "c": []}), [])

    def test_there_are_none(self):
        self.assertGreater(len(self.needs), 100)
        self.assertGreater(sum(map(len, self.needs.values())), 500)
        told = [f"{name} needs {other} for {', '.join(self.needs[name][other])}" for circle in circles(self.needs)
                for name in circle for other in self.needs[name] if other in circle]
        self.assertFalse(told, "\n" + "\n".join(told))

    def test_calls_go_down(self):
        told = [f"{name} needs {other} for {', '.join(names)}" for name, needs in self.needs.items()
                for other, names in needs.items() if is_above(name, other) and (name, other) not in TABLES]
        self.assertFalse(told, "\n" + "\n".join(told))

    def test_core_stands_alone(self):
        told = []
        for name, (_, needs) in self.found.items():
            if name.split("/")[0] not in CORE or name in OUTSIDE:
                continue
            never = sorted(symbol for symbol in needs if NEVER.match(symbol))
            if never and (name, never) != ("base/memory.c", ["abort"]):
                told.append(f"{name} needs {', '.join(never)}")
        self.assertFalse(told, "\n" + "\n".join(told))


if __name__ == "__main__":
    sys.setrecursionlimit(10000)
    unittest.main()
