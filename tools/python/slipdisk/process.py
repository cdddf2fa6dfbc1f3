"""Calls of the program `slipdisk`."""
import os
import signal
import subprocess

from . import library as lib

POLL_SECONDS = 0.2


def call(*words, program=None, ok=(lib.OK,), poll=None, cwd=None):
    """Calls the program, in the folder cwd: (exit status, standard output). Raises its messages as an error; those of a run in doubt are
    warnings. `poll()` is called five times a second while it runs, and at the end. Ctrl-C is passed on: the program saves before it
    ends."""
    program = program or lib.program()
    try:
        started = subprocess.Popen([program, *map(str, words)], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, cwd=cwd)
    except OSError as failed:
        raise lib.FileError(f"{os.fspath(program)}: {failed.strerror}") from None
    with started as process:
        try:
            while True:
                try:
                    printed, told = process.communicate(timeout=POLL_SECONDS if poll else None)
                    break
                except subprocess.TimeoutExpired:
                    poll()
        except BaseException:
            process.send_signal(signal.SIGINT)
            process.communicate()
            raise
    said = lib.lines(told)
    if process.returncode not in (*ok, lib.DOUBTFUL):
        raise lib.error(said or [f"{' '.join(map(str, words))}: status {process.returncode}"], process.returncode)
    if poll:
        poll()
    lib.warn([line.removeprefix("warning: ") for line in said])
    return process.returncode, printed
