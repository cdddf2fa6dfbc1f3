"""For tests of the tools and of the Python package: where sources and build lie, and the way to the modules."""
import os
import pathlib
import sys

ROOT = pathlib.Path(os.environ.get("SLIPDISK_SOURCE_DIR", pathlib.Path(__file__).resolve().parents[1]))
BUILD = pathlib.Path(os.environ.get("SLIPDISK_BUILD_DIR", ROOT / "build/release"))
PROGRAM = os.environ.setdefault("SLIPDISK_PROGRAM", str(BUILD / "slipdisk"))
sys.path[:0] = [str(ROOT / "tools" / "python"), str(ROOT / "tools")]
sys.dont_write_bytecode = True
