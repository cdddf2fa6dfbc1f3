#!python
"""The command `slipdisk` of an environment of Python: becomes the program that lies in the package, without importing it."""
import importlib.util
import os
import sys

package = os.path.dirname(importlib.util.find_spec("slipdisk").origin)
os.environ.setdefault("SLIPDISK_PYTHON", sys.executable)  # plots and films are drawn by this Python
os.execv(os.path.join(package, "bin", "slipdisk"), sys.argv)
