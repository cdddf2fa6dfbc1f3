"""What the build says of packages that are missing: libraries in one message, tests in the last lines, and tools/test.sh fails.

Every module and command that a test uses without having brought it has a row in tests/needs.cmake."""
import ast
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

CC = os.environ.get("CC", "cc")
ROOT = pathlib.Path(os.environ.get("SLIPDISK_SOURCE_DIR", pathlib.Path(__file__).resolve().parents[2]))
NEEDS = [row.split(" ", 4) for row in re.findall(r'^  "(\w+ \S+ \S+ \S+ .*?)"\)?$', (ROOT / "tests/needs.cmake").read_text(), re.M)]
DEPENDENCIES = (ROOT / "tools/install_deps.sh").read_text()
# Of Debian's essential packages, and those that others bring along
ALWAYS = {"binutils", "bsdutils", "python3-jinja2", "python3-yaml", "python3-pil"}
OWN = {"slipdisk", "names"} | {path.stem for folder in ("tests", "tools", "tools/studies") for path in (ROOT / folder).iterdir()}
HELPERS = {path.stem: path for path in (ROOT / "tests").rglob("*.py")}


def said_by(*words, **more):
    return subprocess.run(words, capture_output=True, text=True, check=True, **more).stdout


def used(path, seen):
    """Modules and commands of a test and of its helpers."""
    seen.add(path)
    found, text = set(), path.read_text(encoding="utf-8")
    for node in ast.walk(ast.parse(text)):
        names = [alias.name for alias in node.names] if isinstance(node, ast.Import) else [getattr(node, "module", None)]
        for name in (name.split(".")[0] for name in names if name):
            if name in HELPERS and HELPERS[name] not in seen:
                found |= used(HELPERS[name], seen)
            elif name not in HELPERS and name not in sys.stdlib_module_names:
                found.add(name)
    found |= set(re.findall(r'"-m", "(\w+)"', text)) - sys.stdlib_module_names
    return found | set(re.findall(r'which\("([\w-]+)"\)', text))


class Rows(unittest.TestCase):
    def test_every_test_says_what_it_needs(self):
        wanting = set()
        for path in (path for path in HELPERS.values() if path.stem.startswith("test_")):
            rows = {name for _, name, _, _, pattern in NEEDS if re.fullmatch(pattern, path.name)}
            # OVITO and freud are not in Debian; the others the build needs itself
            rows |= {"h5py", "numpy", "ovito", "freud", "bash", "cc", "pkg-config"}
            wanting |= {(path.stem, name) for name in used(path, set()) - rows - OWN}
        self.assertEqual(wanting, set())

    def test_packages_are_those_that_the_script_installs(self):
        self.assertGreater(len(NEEDS), 30)
        names = set(re.findall(r"[\w.+-]+", DEPENDENCIES)) | ALWAYS
        self.assertEqual({package for _, _, package, _, _ in NEEDS} - names, set())
        tests = {path.name for path in (ROOT / "tests").rglob("test_*")}
        for row in NEEDS:
            self.assertTrue(any(re.fullmatch(row[4], name) for name in tests), row)


class Folder(unittest.TestCase):
    def setUp(self):
        temporary = tempfile.TemporaryDirectory(prefix="slipdisk-test-")
        self.addCleanup(temporary.cleanup)
        self.folder = pathlib.Path(temporary.name)


class Configured(Folder):
    def script(self, name, text):
        path = self.folder / name
        path.parent.mkdir(exist_ok=True)
        path.write_text("#!/bin/sh\n" + text)
        path.chmod(0o755)
        return path

    def configure(self, *words, packages=()):
        """(exit status, output) in a new folder, where pkg-config knows these packages only."""
        known = self.folder / "pkgconfig"
        known.mkdir()
        for name in packages:
            place = said_by("pkg-config", "--variable=pcfiledir", name).strip()
            shutil.copy(f"{place}/{name}.pc", known)
        done = subprocess.run(["cmake", "-S", ROOT, "-B", self.folder / "build", *words], stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                              text=True, env=os.environ | {"PKG_CONFIG_LIBDIR": str(known)})
        return done.returncode, done.stdout

    def test_libraries(self):
        """One message names all, their packages, and the script; with MPI also Zoltan."""
        status, said = self.configure("-DSLIPDISK_MPI=ON", "-DCMAKE_IGNORE_PREFIX_PATH=/usr", *(
            f"-DCMAKE_DISABLE_FIND_PACKAGE_{name}=ON" for name in ("GSL", "HDF5", "ZLIB", "MPI")),
            "-DZOLTAN_INCLUDE_DIR=ZOLTAN_INCLUDE_DIR-NOTFOUND", "-DPKG_CONFIG_EXECUTABLE=" + str(shutil.which("pkg-config")))
        self.assertEqual((status, said.count("CMake Error")), (1, 1), said)
        rows = re.findall(r"^ +(\S+): (.*) \(conda-forge: \S+\)$", said, re.M)
        self.assertEqual([name for name, _ in rows], ["GSL", "HDF5", "zlib", "libconfig", "jansson", "xxhash", "MPI", "Zoltan"])
        for package in " ".join(packages for _, packages in rows).split():
            self.assertRegex(DEPENDENCIES, rf"[ (]{package}[ )\n]")
        self.assertIn("tools/install_deps.sh --mpi installs", " ".join(said.split()))

    def test_tests(self):
        """Without cmocka, browser, node and the like: each is named with its package and the tests, in the last lines."""
        python = self.script("python", f'PATH=/nowhere exec {sys.executable} "$@"\n')
        status, said = self.configure(f"-DSLIPDISK_PYTHON={python}", packages=("libconfig", "jansson"))
        self.assertEqual(status, 0, said)
        lines = said.split("-- Configuring done")[0].splitlines()
        told = [line for line in lines if line.startswith("-- Left out without ")]
        self.assertEqual(lines[-len(told):], told)
        said = "\n".join(told)
        self.assertRegex(said, r"without libcmocka-dev \(tools/install_deps.sh --tests\): \d+ tests \(tests_left_out.txt\)")
        self.assertRegex(said, r"without chromium \(tools/install_deps.sh --tests\): .*test_viewer")
        self.assertRegex(said, r"without libmicrohttpd-dev \(tools/install_deps.sh\): slipdisk run --live, test_view_live")
        self.assertRegex(said, r"without nodejs \(tools/install_deps.sh --play\): test_play")
        there = said_by("ctest", "-N", cwd=self.folder / "build")
        self.assertIn(" test_sweep\n", there)
        named = re.findall(r"\btest_\w+", (self.folder / "build/tests_left_out.txt").read_text())
        self.assertIn("test_mean", named)
        self.assertEqual([name for name in named if f" {name}\n" in there], [])

    def test_changed_file(self):
        """From a fresh folder and after a change, make and ninja put every object into the library, which is one object. In place of a
        compiler works one that makes the object `before`, and later `after`, of any source."""
        for name in "before", "after":
            subprocess.run([CC, "-x", "c", "-c", "-o", self.folder / f"{name}.o", "-"], check=True, text=True,
                           input=f"static int {name} __attribute__((used));")
        quick = self.script("quick", """while [ $# -gt 0 ]; do case $1 in -o) o=$2;; -MF) d=$2;; -MT) t=$2;; -c) c=$2;; esac; shift; done
          echo "$t: $c" >"$d"
          cp "${0%/*}/object" "$o"
        """)
        for path in ("CMakeLists.txt", "src", "include", "tools/cmake", "tools/packaging", "tools/docs.sh", "inputs", "LICENSE",
                     "docs/licence.md"):
            copy = self.folder / "tree" / path
            copy.parent.mkdir(parents=True, exist_ok=True)
            (shutil.copytree if (ROOT / path).is_dir() else shutil.copy)(ROOT / path, copy)
        for generator, target in ("Unix Makefiles", "slipdisk"), ("Ninja", "libslipdisk.a"):
            build = self.folder / generator
            said_by("cmake", "-S", self.folder / "tree", "-B", build, "-G", generator, "-DSLIPDISK_TESTS=OFF",
                    f"-DCMAKE_C_COMPILER={CC}", f"-DCMAKE_C_COMPILER_LAUNCHER={quick}")
            symbols = []
            for name in "before", "after":
                shutil.copy(self.folder / f"{name}.o", self.folder / "object")
                built = subprocess.run(["cmake", "--build", build, "--target", target, "-j2"], stdout=subprocess.PIPE,
                                       stderr=subprocess.STDOUT, text=True)
                self.assertEqual(built.returncode, 0, built.stdout[-2000:])
                symbols += [said_by("nm", build / "libslipdisk.a").split()]
                (self.folder / "tree/src/physics/step/step.c").touch()
            files = symbols[0].count("before")
            self.assertGreater(files, 100)
            self.assertEqual([(them.count("before"), them.count("after")) for them in symbols], [(files, 0), (files - 1, 1)], generator)

    def test_promised(self):
        """tools/test.sh fails where a package of --tests is missing, and says which; one of --play is not its business."""
        shutil.copytree(ROOT / "tools", self.folder / "tree/tools")
        self.script("stubs/ctest", "")
        for row, status in (("libcmocka-dev --tests test_mean", 1), ("libmicrohttpd-dev -- test_view_live", 1),
                            ("nodejs --play test_play", 0)):
            self.script("stubs/cmake", f'if [ "$1" = --preset ]; then mkdir -p build/$2; echo "{row}" >build/$2/tests_left_out.txt; fi\n')
            done = subprocess.run(["bash", self.folder / "tree/tools/test.sh", "dev", "release"], capture_output=True, text=True,
                                  env=os.environ | {"PATH": f"{self.folder}/stubs:{os.environ['PATH']}"})
            self.assertEqual(done.returncode, status, done.stderr)
            self.assertEqual(row in done.stderr, bool(status))


class Touched(Folder):
    """tools/touched.py in a small clone."""

    def write(self, name, text=""):
        path = self.folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)

    def git(self, *words):
        said_by("git", "-c", "user.name=t", "-c", "user.email=t", *words, cwd=self.folder)

    def touched(self, name=None):
        """Tests that a change of this file touches, but those of every source."""
        if name:
            self.write(name, "changed")
        told = said_by(sys.executable, self.folder / "tools/touched.py", "build", "--list").split("\n")[1].split()
        self.git("checkout", "-q", ".")
        return [test for test in told if test in self.tests], len(told) > len(self.tests)

    def test_rules(self):
        self.write("tools/touched.py", (ROOT / "tools/touched.py").read_text())
        self.write("src/wide/all.h")
        for folder in ("heap", "wave", "box", "rain"):
            self.write(f"src/{folder}/{folder}_sum.c", '#include "wide/all.h"')
        self.write("src/heap/inner.h")
        self.write("src/wave/user.c", '#include "heap/inner.h"')
        self.write("tests/unit/test_some.c", '#include "heap/inner.h"')
        for name in ("unit/test_wave.c", "unit/test_big_sum.c", "program/test_other.py", "docs/test_page.py"):
            self.write(f"tests/{name}")
        self.write("docs/page.md")
        self.tests = ["test_big_sum", "test_other", "test_page", "test_some", "test_wave"]
        self.git("init", "-q")
        for message in ("first", "second"):
            self.write("docs/page.md", message)
            self.git("add", ".")
            self.git("commit", "-qm", message)
        for name, tests, broad in (("src/heap/heap_sum.c", ["test_big_sum", "test_some"], True),
                                   ("src/heap/inner.h", ["test_some", "test_wave"], True), ("src/wide/all.h", self.tests, False),
                                   ("tests/program/test_other.py", ["test_other"], False), ("docs/page.md", ["test_page"], False),
                                   (None, ["test_page"], False), ("CMakeLists.txt", self.tests, False)):
            self.assertEqual(self.touched(name), (tests, broad), name)


if __name__ == "__main__":
    unittest.main()
