"""For tests of the Python package: the package of the sources with the library of the build. Builds without a shared library, as those
with sanitizers, leave these tests out (tests/CMakeLists.txt)."""
import os

from sources import BUILD, PROGRAM, ROOT  # noqa: F401

LIBRARY = BUILD / "libslipdisk.so"
assert LIBRARY.exists(), LIBRARY
os.environ["SLIPDISK_LIBRARY"] = str(LIBRARY)
