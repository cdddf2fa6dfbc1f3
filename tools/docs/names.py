"""The tables of the page docs/names.md, which the site's build takes from the program (`slipdisk info --names`)."""
import os
import pathlib
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
MARK = "<!-- slipdisk info --names -->\n"


def program():
    return pathlib.Path(os.environ.get("SLIPDISK_PROGRAM") or ROOT / "build/release/slipdisk")


def tables():
    """What `slipdisk info --names` prints; None if the program has not been built."""
    if not program().exists():
        return None
    return subprocess.run([program(), "info", "--names"], capture_output=True, text=True, check=True).stdout


def fill(text):
    """The page with its tables. Without the program it stays as it is, and standard error says so."""
    assert text.count(MARK) == 1, f"docs/names.md: no {MARK}"
    made = tables()
    if made is None:
        print(f"docs/names.md has no tables on this site: {program()} is missing", file=sys.stderr)
        return text
    return text.replace(MARK, made)
