#!/usr/bin/env python3
"""Writes the tables of docs/deck.md anew from the rows of the program, when a key was added or changed:

    tools/deck_docs.py [build/release/slipdisk]

The text around the tables stays. A group that is new gets its heading and table at the place that it has in the program;
a group that is gone is left for the author to take out (test_deck_reference fails until then).
"""
import pathlib
import re
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
TABLE = re.compile(r"(?:^\|.*\n)+", re.M)
HEAD = "\n## All keys\n"


def groups(text):
    """[(heading, text up to the next)]; what comes before the first heading has None."""
    parts = re.split(r"^(### .*\n)", text, flags=re.M)
    return [(None, parts[0])] + list(zip(parts[1::2], parts[2::2]))


def main():
    if {"-h", "--help"} & set(sys.argv[1:]):
        print(__doc__)
        return
    program = sys.argv[1] if len(sys.argv) > 1 else ROOT / "build/release/slipdisk"
    keys = subprocess.run([program, "check", "--keys"], check=True, capture_output=True, text=True).stdout
    path = ROOT / "docs/deck.md"
    before, after = path.read_text().split(HEAD, 1)
    written = dict(groups(after))
    out = [before, HEAD, written.pop(None)]
    for heading, text in groups(keys)[1:]:
        old, tables = written.pop(heading, text), iter(TABLE.findall(text))
        out += [heading, TABLE.sub(lambda _: next(tables, ""), old), *(table + "\n" for table in tables)]
    out += [part for item in written.items() for part in item]
    path.write_text("".join(out))


if __name__ == "__main__":
    main()
