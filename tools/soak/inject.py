"""The library that lets system calls fail (tests/inject/calls.c): building it, and what it is told."""
import dataclasses
import errno
import os
import pathlib
import subprocess

from .trial import ROOT

SOURCE = ROOT / "tests" / "inject" / "calls.c"


def library(folder):
    """The library, compiled into the folder; None where there is no compiler for it."""
    made = pathlib.Path(folder) / "calls.so"
    if not made.exists():
        words = [os.environ.get("CC", "cc"), "-shared", "-fPIC", "-O1", "-o", made, SOURCE, "-ldl"]
        try:
            subprocess.run(words, check=True, capture_output=True)
        except (OSError, subprocess.CalledProcessError):
            return None
    return made


@dataclasses.dataclass
class Fault:
    """What goes wrong: the n-th call of some kinds; see calls.c."""
    call: str = "any"
    when: int = 0
    do: str = ""          # name of an errno, or short, kill, torn, wait
    times: int = 1        # 0: for ever
    name: str = ""        # only paths like this one
    origin: str = ""      # program or library: only calls from there
    room: int = -1        # bytes that can be written
    log: str = ""
    gate: str = ""        # wait: until this file is gone

    def settings(self):
        """The variables that are set, but for those that every trial has."""
        number = getattr(errno, self.do, None)
        found = {}
        if self.room < 0 or self.log:
            found["INJECT_CALL"] = self.call
        if self.when:
            found |= {"INJECT_WHEN": str(self.when), "INJECT_TIMES": str(self.times),
                      "INJECT_DO": self.do if number is None else str(number)}
        if self.name:
            found["INJECT_NAME"] = self.name
        if self.origin:
            found["INJECT_FROM"] = self.origin
        if self.room >= 0:
            found["INJECT_BYTES"] = str(self.room)
        if self.gate:
            found["INJECT_GATE"] = str(self.gate)
        if self.log:
            found["INJECT_LOG"] = str(self.log)
        return found

    def environment(self, shim, below):
        more = {"LD_PRELOAD": str(shim), "INJECT_BELOW": str(pathlib.Path(below).resolve())}
        # a program with sanitizers wants to be first, or to be told that it is not
        asan = ":".join(filter(None, [os.environ.get("ASAN_OPTIONS"), "verify_asan_link_order=0"]))
        return os.environ | {"ASAN_OPTIONS": asan} | more | self.settings()

    def __str__(self):
        return " ".join(f"{k}={v}" for k, v in self.settings().items() if k != "INJECT_LOG")


def calls(log):
    """[(kind, path)] of all calls that a run has logged, in order."""
    lines = pathlib.Path(log).read_text().splitlines() if pathlib.Path(log).exists() else []
    return [tuple(line.removeprefix("! ").split(" ", 1)) for line in lines]


def struck(log):
    """The calls that were made to fail."""
    lines = pathlib.Path(log).read_text().splitlines() if pathlib.Path(log).exists() else []
    return [line.removeprefix("! ") for line in lines if line.startswith("! ")]
