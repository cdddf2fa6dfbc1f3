"""What `slipdisk theory` says of a deck, for pictures."""
import csv
import os
import tempfile

import numpy as np

from . import library as lib
from .program import call


def theory_row(deck):
    """The row of `slipdisk theory --csv` of a deck's text: {column: number}; None: the theory does not fit this deck."""
    with tempfile.TemporaryDirectory(prefix="slipdisk-plot-") as folder:
        path = os.path.join(folder, "deck.cfg")
        with open(path, "w", encoding="utf-8") as file:
            file.write(deck)
        try:
            text = call("theory", path, "--csv", "-")[1]
        except lib.UserError:
            return None
    row = next(csv.DictReader(text.splitlines()), None)
    if row is None:
        return None
    return {name: float(cell) if cell else np.nan for name, cell in row.items() if name != "name"}


def theory_of(source):
    """The same of a result, once; None where there is no periodic solution."""
    if not hasattr(source, "_theory"):
        source._theory = theory_row(source.result.deck_full) if len(source.radius) <= 100 else None
    found = source._theory
    return found if found and "mean" in found and np.isfinite(found["mean"]) else None
