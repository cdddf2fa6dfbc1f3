"""Files of HDF5 are compared with their checksums before HDF5 sees them: it would return what a flipped bit makes of them, or crash."""
import contextlib
import os
import subprocess

from .library import FileError, error, lines, program
from .shares import opened

AT_ONCE = 500  # files in one call of the program


def facts(path):
    """What changes when a file is written or replaced."""
    it = os.stat(path)
    return it.st_dev, it.st_ino, it.st_size, it.st_mtime_ns, it.st_ctime_ns


def compare(paths):
    """Compares all bytes of files with their checksums, by `slipdisk verify`; those of older versions, without, must be readable."""
    try:
        command = [program(), "verify", "--quiet", "--unsealed", "--"]
    except FileError as missing:
        raise FileError(f"{missing}; verify=False reads without comparing checksums") from None
    for first in range(0, len(paths), AT_ONCE):
        done = subprocess.run([*command, *paths[first:first + AT_ONCE]], capture_output=True, text=True, check=False)
        if done.returncode:
            said = lines(done.stderr) or [f"{paths[first]}: slipdisk verify ends with status {done.returncode}"]
            raise error(said, done.returncode if done.returncode > 0 else FileError.status)


class Verified:
    """Remembers which files are as they were written; `opened(path, beside)` opens one of them, which must not change while it is
    looked at. verify=False: everything is read as it is."""

    def __init__(self, verify=True):
        self._verify, self._sound = verify, {}

    def _compare(self, path, beside):
        now = {path: facts(path)}
        if self._sound.get(path) != now[path]:
            for other in beside:  # in the same call
                with contextlib.suppress(OSError):
                    now[other] = facts(other)
            fresh = [name for name in now if self._sound.get(name) != now[name]]
            try:
                compare(fresh)
            except FileError:
                os.stat(path)  # a file that has gone meanwhile is not damaged
                raise
            self._sound.update(now)
        return now[path]

    def opened(self, path, beside=()):
        while self._verify:
            before = self._compare(path, beside)
            file = opened(path)
            if facts(path) == before:
                return file
            file.close()
        return opened(path)


@contextlib.contextmanager
def read(path, verify=True):
    """A file of slipdisk, open for reading."""
    with Verified(verify).opened(path) as file:
        yield file
