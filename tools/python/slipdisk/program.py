"""Runs and sweeps by the program: they write results and checkpoints, and can be stopped and continued."""
from __future__ import annotations

import json
import os
import re
import tempfile
from collections.abc import Mapping
from typing import Any

from .arguments import checked
from .deck import deck_text, value_text
from .library import DeckLike, StrPath, Whole
from .notebook import Progress
from .process import call
from .result import Result
from .sweep import Sweep


def override_words(overrides):
    """{"gravity.tilt": "0.04 pi"} as -D words."""
    words = []
    for path, value in (overrides or {}).items():
        words += ["-D", f"{path}={value if isinstance(value, str) else value_text(value, path)}"]
    return words


def deck_path(deck, beside):
    """The path of a deck; a dict is written beside the result."""
    if not isinstance(deck, dict):
        return os.fspath(deck)
    path = beside + ".cfg"
    text = deck_text(deck)
    with open(path, "w", encoding="utf-8") as file:
        file.write(text)
    return path


def logged(path):
    """(steps that are done, steps of all) by the log of a run; (0, 0) while it has none."""
    try:
        with open(path, encoding="utf-8") as file:
            found = re.findall(r"step (\d+)(?:/| of (?:about|at most) )(\d+)", file.read())
    except OSError:
        found = []
    return tuple(map(int, found[-1])) if found else (0, 0)


@checked
def run(deck: DeckLike, output: StrPath, overrides: Mapping[str, Any] | None = None, *, force: bool = False, threads: Whole | None = None,
        program: StrPath | None = None, progress: bool | None = None) -> Result:
    """`slipdisk run`: runs a deck (a path, or a dict, which is written beside the result as NAME.cfg) into the file
    `output`, or continues it, and returns the Result. A finished result is refused unless `force` is given.

    progress   True, False, or None: shown in notebooks and on terminals, for runs of more than a second"""
    output = os.fspath(output)
    words = ["run", deck_path(deck, output.removesuffix(".h5")), "-o", output, "--quiet", *override_words(overrides)]
    words += ["--threads", threads] if threads is not None else []
    words += ["--force"] if force else []
    with Progress(os.path.basename(output), "step", progress) as shown, tempfile.TemporaryDirectory(prefix="slipdisk-") as folder:
        log = os.path.join(folder, "log")
        words += ["--log", log] if shown.wanted else []
        call(*words, program=program, poll=(lambda: shown.at(*logged(log))) if shown.wanted else None)
    return Result(output)


@checked
def sweep(deck: DeckLike, folder: StrPath, overrides: Mapping[str, Any] | None = None, *, jobs: Whole = 1, program: StrPath | None = None,
          progress: bool | None = None) -> Sweep:
    """`slipdisk sweep`: runs all points that are not done, `jobs` at a time, and returns the Sweep. `progress`: as of `run`, in
    points."""
    folder = os.fspath(folder)
    words = ["sweep", deck_path(deck, folder.removesuffix(".sweep")), *override_words(overrides)]
    points = os.path.join(folder, "points")

    def done():
        return sum(name.endswith(".h5") for name in os.listdir(points)) if os.path.isdir(points) else 0

    with Progress(os.path.basename(folder), "point", progress) as shown:
        total = int(call(*words, "--count", program=program)[1]) if shown.wanted else 0
        call(*words, "-o", folder, "-j", jobs, "--quiet", program=program, poll=(lambda: shown.at(done(), total)) if shown.wanted else None)
    return Sweep(folder)


@checked
def info(path: StrPath, program: StrPath | None = None) -> dict[str, Any]:
    """`slipdisk info --json`: what is known of a result, as a dict."""
    return json.loads(call("info", path, "--json", program=program)[1])
