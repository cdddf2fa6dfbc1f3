"""The rules of the house (docs/architecture.md) that can be read off the sources.

- A file under src/ includes only headers of its own floor or of a floor below; public headers are for all.
- A floor with rooms: a file includes only headers of its own room or of rooms below, so that no circle runs through two.
- Files outside a room with doors include its doors only.
- A public header includes public headers and the C library only.
- libconfig, HDF5, MPI, Zoltan and xxHash are each seen by the files of one name only; GSL is seen by the core through base/gsl.h.
- `work` is the engine's own: outside physics/ nothing reaches into it (physics/step/access.h is the door).
- Nothing below app/ ends the process.
- No source file and no test has 800 lines or more. Two source files have one name only if they are about one thing.
"""
import os
import pathlib
import re
import sys
import unittest

ROOT = pathlib.Path(os.environ.get("SLIPDISK_SOURCE_DIR", pathlib.Path(__file__).resolve().parents[2]))
SRC = ROOT / "src"
ROOMS = {"physics": ["system", "contact", "neighbours", "motion", "step", "small"], "io": ["store", "results", "deck"]}
# Headers of a room that files outside may include.
DOORS = {"io/deck": ["deck"], "io/store": ["file", "folder", "h5"],
         "io/results": ["checkpoint", "constants", "frames", "merge", "provenance", "record", "summary"],
         "app/check": [], "app/export": [], "app/measure": ["measure"], "app/sweep": ["sweep"], "app/theory": [],
         "app/view": ["view"]}
FLOORS = ["base", "model", "physics", "pack", "theory", "measure", "io", "run", "app"]
ONLY = {"libconfig.h": "io/deck/", "hdf5.h": "io/store/h5", "hdf5_hl.h": "io/store/h5", "mpi.h": "base/comm",
        "zoltan.h": "base/comm_cuts", "xxhash.h": "io/store/file_sum"}
LINES = 800
INCLUDE = re.compile(r'^[ \t]*#[ \t]*include[ \t]*([<"])([^>"]+)[>"]', re.M)
ENDS = re.compile(r"\b(?:exit|_exit|_Exit|quick_exit|abort)\s*\(")


def code_of(text):
    """The text with comments and string literals blanked out, lines kept."""
    pattern = re.compile(r'/\*.*?\*/|//[^\n]*|"(?:\\.|[^"\\\n])*"|\'(?:\\.|[^\'\\\n])*\'', re.S)
    return pattern.sub(lambda m: re.sub(r"[^\n]", " ", m.group()), text)


def uncommented(text):
    """The text with comments blanked out (string literals and include paths stay)."""
    pattern = re.compile(r'("(?:\\.|[^"\\\n])*")|/\*.*?\*/|//[^\n]*', re.S)
    return pattern.sub(lambda m: m.group(1) or re.sub(r"[^\n]", " ", m.group()), text)


def line_of(text, position):
    return text.count("\n", 0, position) + 1


def resolve(path, name):
    """The included file as a path under src/, or None when it is not one of ours."""
    for candidate in (path.parent / name, SRC / name):
        candidate = candidate.resolve()
        if candidate.is_file() and SRC.resolve() in candidate.parents:
            return candidate.relative_to(SRC.resolve())
    return None


def level(floor):
    """0 at the bottom; a folder that is no floor (reported by a test of its own) counts as the top."""
    return FLOORS.index(floor) if floor in FLOORS else len(FLOORS)


class Floors(unittest.TestCase):
    def setUp(self):
        self.files = sorted(p for p in SRC.rglob("*.[ch]"))
        self.assertTrue(self.files, "no source files under src/")

    def check(self, problems):
        self.assertFalse(problems, "\n" + "\n".join(problems))

    def test_every_file_is_on_a_floor(self):
        self.check([f"{p.relative_to(ROOT)}: src/{p.relative_to(SRC).parts[0]} is none of {FLOORS}"
                    for p in self.files if p.relative_to(SRC).parts[0] not in FLOORS])

    def test_includes_go_down(self):
        problems = []
        for path in self.files:
            floor = path.relative_to(SRC).parts[0]
            text = uncommented(path.read_text())
            for found in INCLUDE.finditer(text):
                name = found.group(2)
                if name.startswith("slipdisk/"):
                    if not (ROOT / "include" / name).is_file():
                        problems.append(f"{path.relative_to(ROOT)}:{line_of(text, found.start())}: no {name}")
                    continue
                target = resolve(path, name)
                if target is None:
                    if found.group(1) == '"' and name != "version.h":
                        problems.append(f"{path.relative_to(ROOT)}:{line_of(text, found.start())}: "
                                        f'"{name}" is not under src/ (write <{name}> for a library)')
                elif level(target.parts[0]) > level(floor):
                    problems.append(f"{path.relative_to(ROOT)}:{line_of(text, found.start())}: "
                                    f"{floor}/ must not know {target}")
        self.check(problems)

    def test_rooms_include_down(self):
        problems = []
        for path in self.files:
            parts = path.relative_to(SRC).parts
            rooms = ROOMS.get(parts[0])
            if not rooms:
                continue
            if len(parts) != 3 or parts[1] not in rooms:
                problems.append(f"{path.relative_to(ROOT)}: in none of the rooms {rooms}")
                continue
            text = uncommented(path.read_text())
            for found in INCLUDE.finditer(text):
                target = resolve(path, found.group(2))
                if target and target.parts[0] == parts[0] and rooms.index(target.parts[1]) > rooms.index(parts[1]):
                    problems.append(f"{path.relative_to(ROOT)}:{line_of(text, found.start())}: {parts[1]}/ must not "
                                    f"know {target}")
        self.check(problems)

    def test_rooms_are_entered_by_their_doors(self):
        problems = []
        for path in self.files:
            room = "/".join(path.relative_to(SRC).parts[:2])
            text = uncommented(path.read_text())
            for found in INCLUDE.finditer(text):
                target = resolve(path, found.group(2))
                entered = "/".join(target.parts[:2]) if target else None
                inside = room == entered or (entered == "io/store" and room == "io/results")
                if entered in DOORS and not inside and target.stem not in DOORS[entered]:
                    problems.append(f"{path.relative_to(ROOT)}:{line_of(text, found.start())}: {target} is no door")
        self.check(problems)

    def test_public_headers_stand_alone(self):
        problems = []
        for path in sorted((ROOT / "include").rglob("*.h")):
            text = uncommented(path.read_text())
            for found in INCLUDE.finditer(text):
                name = found.group(2)
                if found.group(1) == '"' and not (ROOT / "include" / name).is_file():
                    problems.append(f"{path.relative_to(ROOT)}:{line_of(text, found.start())}: {name} is not public")
                if name in ONLY:
                    problems.append(f"{path.relative_to(ROOT)}:{line_of(text, found.start())}: {name} in public")
        self.check(problems)

    def test_gsl_comes_through_its_header(self):
        problems = []
        for path in self.files:
            place = path.relative_to(SRC).as_posix()
            if place == "base/gsl.h" or place.split("/")[0] not in ("base", "model", "physics", "measure", "pack"):
                continue
            for found in INCLUDE.finditer(uncommented(path.read_text())):
                if found.group(2).startswith("gsl/"):
                    problems.append(f"src/{place}: {found.group(2)} comes through base/gsl.h")
        self.check(problems)

    def test_libraries_have_one_room(self):
        problems = []
        for path in self.files:
            text = uncommented(path.read_text())
            place = path.relative_to(SRC).as_posix()
            for found in INCLUDE.finditer(text):
                room = ONLY.get(found.group(2))
                if room and not place.startswith(room):
                    problems.append(f"src/{place}:{line_of(text, found.start())}: only src/{room}* sees "
                                    f"{found.group(2)}")
        self.check(problems)

    def test_work_is_private_to_physics(self):
        problems = []
        for path in self.files:
            if path.relative_to(SRC).parts[0] == "physics":
                continue
            text = code_of(path.read_text())
            problems += [f"{path.relative_to(ROOT)}:{line_of(text, found.start())}: {found.group()}..."
                         for found in re.finditer(r"(?:->|\.)work\s*(?:\.|;)|PAIR\(", text)
                         if not re.search(r"energy(?:->|\.)work|e(?:->|\.)work;", text[found.start() - 8:found.end()])]
        self.check(problems)

    def test_nothing_below_app_ends_the_process(self):
        problems = []
        for path in self.files:
            if path.relative_to(SRC).parts[0] == "app" or path.name == "h5_probe.c":  # the end of a child of its own
                continue
            text = code_of(path.read_text())
            if path.name == "memory.c":  # once, without memory and without a handler
                self.assertEqual(len(ENDS.findall(text)), 1)
                continue
            problems += [f"{path.relative_to(ROOT)}:{line_of(text, found.start())}: {found.group().strip()}...)"
                         for found in ENDS.finditer(text)]
        self.check(problems)

    def test_names_that_occur_twice(self):
        """Files of one name in two folders are about one thing: these are."""
        names = [path.stem for path in self.files if path.suffix == ".c"]
        self.assertEqual({name for name in names if names.count(name) > 1}, {"cell", "clumps", "measure", "sweep", "walls"})

    def test_files_are_short(self):
        tests = [p for p in (ROOT / "tests").rglob("*") if p.suffix in (".c", ".h", ".py", ".sh")]
        self.assertTrue(tests, "no tests under tests/")
        problems = []
        for path in self.files + sorted((ROOT / "include").rglob("*.h")) + sorted(tests):
            lines = len(path.read_text().splitlines())
            if lines >= LINES:
                problems.append(f"{path.relative_to(ROOT)}: {lines} lines, fewer than {LINES} allowed")
        self.check(problems)


if __name__ == "__main__":
    sys.exit(unittest.main(verbosity=1))
