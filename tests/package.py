"""For tests of the Python package: the package of the sources with the library of the build. The test is left out where there is none."""
import os
import pathlib
import sys

ROOT = pathlib.Path(os.environ.get("SLIPDISK_SOURCE_DIR", pathlib.Path(__file__).resolve().parents[1]))
BUILD = pathlib.Path(os.environ.get("SLIPDISK_BUILD_DIR", ROOT / "build/release"))
LIBRARY = BUILD / "libslipdisk.so"
if not LIBRARY.exists():
    print(f"no {LIBRARY} (sanitizer builds have none): the test is left out")
    sys.exit(0)
os.environ["SLIPDISK_LIBRARY"] = str(LIBRARY)
PROGRAM = os.environ.setdefault("SLIPDISK_PROGRAM", str(BUILD / "slipdisk"))
sys.path[:0] = [str(ROOT / "tools" / "python"), str(ROOT / "tools")]
sys.dont_write_bytecode = True
