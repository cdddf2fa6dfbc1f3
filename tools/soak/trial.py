"""What the modes share: the settings of a call, and the rows that come out."""
import dataclasses
import pathlib
import random
import time

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
SIZES = ("brief", "small", "full")


@dataclasses.dataclass
class Row:
    """One kind of trial: how many were made, how many of them failed."""
    what: str
    trials: int
    failed: int
    note: str = ""  # of failures: the first; else what is worth knowing


@dataclasses.dataclass
class Setup:
    """What a mode is given."""
    program: pathlib.Path
    build: pathlib.Path   # build tree of the program
    work: pathlib.Path    # empty scratch folder of the mode's own, removed afterwards
    size: str             # one of SIZES
    seed: int
    say: object = print   # progress

    def pick(self, small, full):
        """What belongs to the size; a number is a quarter of small in brief, which is for builds that are slow."""
        if self.size == "brief" and isinstance(small, int):
            return (small + 3) // 4
        return full if self.size == "full" else small

    def random(self, *parts):
        """A stream of random numbers of its own for each trial: any one can be repeated alone."""
        return random.Random(f"{self.seed}-{'-'.join(map(str, parts))}")


class Clock:
    def __init__(self):
        self.began = time.monotonic()

    def seconds(self):
        return time.monotonic() - self.began
