"""The pages of docs/cookbook, docs/tutorial.md, docs/coming_from.md and README.md are followed to the letter, each in a folder of its own.

Blocks of `sh` are run one after the other; where there is a cookbook, in a copy of inputs/cookbook and inputs/bonds; those of README.md in a folder
with the parts of a clone that has been built. Remarks in the pages, which
readers do not see, say what is to be found:

    <!-- file: tilt.cfg -->        the block below is this file of inputs/cookbook
    <!-- write: ball.cfg -->       the block below is written into the file by the reader
    <!-- test: shorter -D K=V -->  is added to each `slipdisk run` and `slipdisk sweep` of the next block
    <!-- test: status 5 -->        exit status of the next block
    <!-- test: not run -->         the next block is for other machines
    <!-- test: needs lmp -->       the next block is left out where this program is missing; so are remarks about it
    <!-- test: full -->            the next block is run with --full only
    <!-- test: way pip -->         the next block is run with --way=pip only
    <!-- test: 0.4 < peak < 0.5 -->  a number that the last block has printed behind this word
    <!-- test: made tilt.png -->   a file that is there now, and was not when the page began
    <!-- test: says TEXT -->       the last block has printed this
    <!-- test: shown -->           the block below consists of lines that the last block has printed

    tests/docs/test_cookbook.py [PAGE ...]    some pages; --write puts the files into the pages; --full
                                              leaves nothing shorter
    tests/docs/test_cookbook.py PAGE --way=NAME    follows README.md or docs/install.md in the clone that holds this file, from a bare
                                              shell; ways of install.md: source, own, pip
"""
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import time

ROOT = pathlib.Path(os.environ.get("SLIPDISK_SOURCE_DIR", pathlib.Path(__file__).resolve().parents[2]))
BUILD = pathlib.Path(os.environ.get("SLIPDISK_BUILD_DIR", ROOT / "build/release"))
COOKBOOK, BONDS = ROOT / "inputs/cookbook", ROOT / "inputs/bonds"
PAGES = [ROOT / "docs/tutorial.md", *sorted((ROOT / "docs/cookbook").glob("*.md")), ROOT / "docs/coming_from.md", ROOT / "README.md"]
PIECE = re.compile(r"<!-- (?P<key>file|write|test): (?P<value>.*?) -->\n|^```(?P<kind>\w*)\n(?P<body>.*?)^```\n",
                   re.DOTALL | re.MULTILINE)
RANGE = re.compile(r"(\S+) < (.+) < (\S+)$")
NUMBER = r"[-+]?\d+\.?\d*(?:e[-+]?\d+)?"


class Wrong(Exception):
    pass


def surroundings(folder):
    """The program, the package and the library of this build, as if they were installed."""
    tools = folder / "tools"
    tools.mkdir()
    (tools / "slipdisk").symlink_to(os.environ.get("SLIPDISK_PROGRAM", BUILD / "slipdisk"))
    (tools / "python3").symlink_to(sys.executable)
    (tools / "slipdisk.pc").write_text(f"Name: slipdisk\nDescription: this build\nVersion: 0\nCflags: -I{ROOT}/include -I{BUILD}/include\n"
                                       f"Libs: -L{BUILD} -Wl,-rpath,{BUILD} -lslipdisk\n")
    return dict(os.environ, PATH=f"{tools}:{os.environ['PATH']}", PYTHONPATH=str(ROOT / "tools/python"), PKG_CONFIG_PATH=str(tools),
                SLIPDISK_LIBRARY=str(BUILD / "libslipdisk.so"), SLIPDISK_PROGRAM=str(tools / "slipdisk"), SLIPDISK_PYTHON=sys.executable,
                MPLBACKEND="Agg", PYTHONDONTWRITEBYTECODE="1",
                OMPI_ALLOW_RUN_AS_ROOT="1", OMPI_ALLOW_RUN_AS_ROOT_CONFIRM="1")


def bare():
    """What a shell has after `env -i`, where pip finds packages, and what cmake and ccache are told."""
    return {"PATH": "/usr/sbin:/usr/bin:/sbin:/bin", "HOME": os.environ["HOME"], "LC_ALL": "C.UTF-8",
            **{name: value for name, value in os.environ.items() if name.startswith(("PIP_", "CC", "CMAKE_")) or name.lower().endswith("_proxy")}}


class Page:
    """A page on its way: what its remarks have asked for, and what its last block has printed."""

    def __init__(self, path, folder, environment, full, way=None):
        self.path, self.environment, self.full, self.way = path, environment, full, way
        self.folder = ROOT if way else folder / path.stem
        if way:
            pass
        elif path == PAGES[0]:
            self.folder.mkdir()
        elif path == PAGES[-1]:
            (self.folder / "build").mkdir(parents=True)
            (self.folder / "build/release").symlink_to(BUILD)
            for name in ("inputs", "tools"):
                (self.folder / name).symlink_to(ROOT / name)
        else:
            shutil.copytree(COOKBOOK, self.folder)
            shutil.copytree(BONDS, self.folder, dirs_exist_ok=True)
            shutil.copy(ROOT / "tools/cluster/sweep.sbatch", self.folder)
        self.there = {p.name for p in self.folder.rglob("*")}
        self.goes_on = ""  # a reader of README.md types all its blocks into one shell
        self.printed, self.pending, self.found, self.seconds, self.left_out, self.shown = "", {}, 0, 0.0, False, False

    def remark(self, value):
        limits = RANGE.fullmatch(value)
        word, _, rest = value.partition(" ")
        if value == "not run" or word in ("shorter", "status", "needs", "full", "way"):
            self.pending[word] = rest
        elif self.left_out:
            return
        elif value == "shown":
            self.shown = True
        elif limits:
            low, name, high = limits.groups()
            seen = re.search(rf"{re.escape(name)}\s+[=:]?\s*({NUMBER})", self.printed)
            if not seen:
                raise Wrong(f"no number behind {name!r} in\n{self.printed}")
            if not float(low) < float(seen[1]) < float(high):
                raise Wrong(f"{value}: it is {seen[1]}")
            self.found += 1
        elif word == "made":
            for name in rest.split():
                path = self.folder / name
                if name in self.there or not path.exists() or (path.is_file() and path.stat().st_size == 0):
                    raise Wrong(f"{name} was not made")
            self.found += 1
        elif word == "says":
            if rest not in self.printed:
                raise Wrong(f"{rest!r} is not in\n{self.printed}")
            self.found += 1
        else:
            raise Wrong(f"no remark {value!r}")

    def run(self, text):
        asked, self.pending = self.pending, {}
        self.left_out = "not" in asked or asked.get("way", self.way) != self.way or ("full" in asked and not self.full) or not shutil.which(asked.get("needs", "bash"))
        if self.left_out:
            return
        if "shorter" in asked and not self.full:
            text = re.sub(r"^(slipdisk (?:run|sweep) [^#|&\n]*)", rf"\1 {asked['shorter']} ", text, flags=re.MULTILINE)
        begin = time.monotonic()
        done = subprocess.run(["bash", "-e", "-o", "pipefail", "-c", self.goes_on + text], cwd=self.folder, env=self.environment,
                              stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        self.seconds += time.monotonic() - begin
        self.printed = done.stdout
        if done.returncode != int(asked.get("status", 0)):
            raise Wrong(f"exit status {done.returncode}\n{text}\n{done.stdout}")
        if self.way or self.path == PAGES[-1]:
            self.goes_on += "".join(f"{line}\n" for line in text.splitlines() if re.search("^export |&& cd |/activate", line))

    def file(self, key, value, body):
        if key == "write":
            (self.folder / value).write_text(body)
        elif body != (COOKBOOK / value).read_text():
            raise Wrong(f"{value} is not inputs/cookbook/{value}; give --write")

    def compare(self, body):
        """Lines of a page are among those that the last block has printed, up to blanks and the speed of the machine."""
        self.shown = False
        if self.left_out:
            return
        printed = {" ".join(line.split()) for line in self.printed.splitlines()}
        for line in body.splitlines():
            if " ".join(line.split()) not in printed and not line.startswith("# run time"):
                raise Wrong(f"{line!r} is not in\n{self.printed}")
        self.found += 1

    def follow(self):
        pending = None
        for piece in PIECE.finditer(self.path.read_text(encoding="utf-8")):
            line = self.path.read_text(encoding="utf-8")[:piece.start()].count("\n") + 1
            try:
                if piece["key"] == "test":
                    self.remark(piece["value"])
                elif piece["key"]:
                    pending = piece["key"], piece["value"]
                elif pending:
                    self.file(*pending, piece["body"])
                    pending = None
                elif piece["kind"] == "sh":
                    self.run(piece["body"])
                elif self.shown:
                    self.compare(piece["body"])
            except Wrong as wrong:
                raise Wrong(f"{self.path.relative_to(ROOT)}:{line}: {wrong}") from None


def write():
    for path in PAGES:
        text = path.read_text(encoding="utf-8")
        text = re.sub(r"(<!-- file: (\S+) -->\n+```\w*\n).*?^```\n", lambda m: m[1] + (COOKBOOK / m[2]).read_text() + "```\n", text,
                      flags=re.DOTALL | re.MULTILINE)
        path.write_text(text, encoding="utf-8")


def main(words):
    if "--write" in words:
        write()
    chosen = [word for word in words if not word.startswith("--")]
    way = next((word.removeprefix("--way=") for word in words if word.startswith("--way=")), None)
    wrong = 0
    with tempfile.TemporaryDirectory() as folder:
        environment = bare() if way else surroundings(pathlib.Path(folder))
        for path in [*PAGES, *([ROOT / "docs/install.md"] if way else [])]:
            if chosen and path.stem not in chosen:
                continue
            page = Page(path, pathlib.Path(folder), environment, "--full" in words, way)
            try:
                page.follow()
                if not page.found and path.stem != "index":
                    raise Wrong(f"{path.relative_to(ROOT)}: nothing is looked for")
                print(f"{path.relative_to(ROOT)}: {page.found} found as stated, {page.seconds:.1f} s", flush=True)
            except Wrong as error:
                wrong += 1
                print(error, flush=True)
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
