"""Runs and sweeps by the program: they write results and checkpoints, and can be stopped and continued."""
import json
import os
import subprocess

from . import library as lib
from .deck import deck_text, value_text
from .result import Result
from .sweep import Sweep


def override_words(overrides):
    """{"gravity.tilt": "0.04 pi"} as -D words."""
    words = []
    for path, value in (overrides or {}).items():
        words += ["-D", f"{path}={value if isinstance(value, str) else value_text(value, path)}"]
    return words


def call(*words, program=None, ok=(lib.OK,)):
    """Calls the program: (exit status, standard output). Raises its messages as an error; those of a run in doubt are
    warnings."""
    done = subprocess.run([program or lib.program(), *map(str, words)], capture_output=True, text=True, check=False)
    said = lib.lines(done.stderr)
    if done.returncode not in (*ok, lib.DOUBTFUL):
        raise lib.error(said or [f"{' '.join(map(str, words))}: status {done.returncode}"], done.returncode)
    lib.warn([line.removeprefix("warning: ") for line in said], 3)
    return done.returncode, done.stdout


def deck_path(deck, beside):
    """The path of a deck; a dict is written beside the result."""
    if not isinstance(deck, dict):
        return os.fspath(deck)
    path = beside + ".cfg"
    text = deck_text(deck)
    with open(path, "w", encoding="utf-8") as file:
        file.write(text)
    return path


def run(deck, output, overrides=None, *, force=False, threads=None, program=None):
    """`slipdisk run`: runs a deck (a path, or a dict, which is written beside the result as NAME.cfg) into the file
    `output`, or continues it, and returns the Result. A finished result is refused unless `force` is given."""
    output = os.fspath(output)
    words = ["run", deck_path(deck, output.removesuffix(".h5")), "-o", output, "--quiet", *override_words(overrides)]
    words += ["--threads", threads] if threads is not None else []
    call(*words, *(["--force"] if force else []), program=program)
    return Result(output)


def sweep(deck, folder, overrides=None, *, jobs=1, program=None):
    """`slipdisk sweep`: runs all points that are not done, `jobs` at a time, and returns the Sweep."""
    folder = os.fspath(folder)
    path = deck_path(deck, folder.removesuffix(".sweep"))
    call("sweep", path, "-o", folder, "-j", jobs, "--quiet", *override_words(overrides), program=program)
    return Sweep(folder)


def info(path, program=None):
    """`slipdisk info --json`: what is known of a result, as a dict."""
    return json.loads(call("info", path, "--json", program=program)[1])
