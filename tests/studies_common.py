"""Tests of the studies share: the sources and the program of this build, and the modules of tools/studies, which want matplotlib."""
import os
import pathlib
import sys

ROOT = pathlib.Path(os.environ.get("SLIPDISK_SOURCE_DIR", pathlib.Path(__file__).resolve().parents[1]))
PROGRAM = os.environ.get("SLIPDISK_PROGRAM", str(ROOT / "build/release/slipdisk"))
sys.path.insert(0, str(ROOT / "tools/studies"))
sys.dont_write_bytecode = True
