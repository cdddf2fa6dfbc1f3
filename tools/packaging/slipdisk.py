#!python
"""The command `slipdisk` of an environment of Python: becomes the program that lies in the package, without importing it. What lies on
PYTHONPATH comes last: it may be the sources of another slipdisk, or modules with names of the standard library."""
import os
import sys


def program():
    """The program beside this script's own packages; None: there is none."""
    given = os.environ.get("PYTHONPATH", "").split(os.pathsep)
    given += [os.path.abspath(folder) for folder in given]
    above = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))  # pip install --target
    for folder in [above, *(folder for folder in sys.path if folder not in given), *sys.path]:
        path = os.path.join(folder, "slipdisk", "bin", "slipdisk")
        if os.path.isfile(path) and os.access(path, os.X_OK):
            return path
    return None


found = program()
if not found:
    print(f"error: the program slipdisk is not in the packages of {sys.executable}; install it there: pip install . in the sources",
          file=sys.stderr)
    sys.exit(4)
os.environ.setdefault("SLIPDISK_PYTHON", sys.executable)  # plots and films are drawn by this Python
os.execv(found, sys.argv)
