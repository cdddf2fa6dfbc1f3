"""What the results cost: time of all calls of one level, part by part, and the machine that did it.

The times lie in took.json beside the results. They are added up every few seconds, so that a call that was stopped
or killed counts with what it did; a call that finds everything finished adds next to nothing."""
import json
import os
import platform
import threading
import time

import numpy as np

from .data import Table
from .page import Numbers, Section

PAPER = ("runs", "sync", "async", "random")  # with these the paper's figures are complete, in this order


def machine():
    """Processor, cores that may be used, and the widest vectors that the program can choose, in one line."""
    model, flags = platform.processor() or platform.machine(), []
    try:
        with open("/proc/cpuinfo") as file:
            lines = dict(line.split(":", 1) for line in file.read().split("\n\n")[0].splitlines() if ":" in line)
        lines = {key.strip(): value.strip() for key, value in lines.items()}
        model, flags = lines.get("model name", model), lines.get("flags", "").split()
    except OSError:
        pass
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    vectors = ("AVX-512" if {"avx512f", "avx512dq", "avx512vl"} <= set(flags) else "AVX2" if "avx2" in flags
               else "no AVX2")
    chosen = os.environ.get("SLIPDISK_PATH")
    return (f"{model} ({platform.machine()}), {cores} core{'s' * (cores != 1)}, {vectors}"
            + (f", SLIPDISK_PATH={chosen}" if chosen else ""))


class Ledger:
    """Time spent at one level. part(name) is entered around the work; tick() books what has passed so far."""

    def __init__(self, folder, level, jobs=1):
        self.path, self.level, self.jobs = os.path.join(folder, "took.json"), level, jobs
        self.lock, self.name, self.since = threading.Lock(), None, 0.0

    def _all(self):
        try:
            with open(self.path) as file:
                return json.load(file)
        except (OSError, ValueError):  # none yet, or cut short by a full disk
            return {}

    def read(self):
        return {"calls": 0, "made_by": [], "parts": {}, **self._all().get(self.level, {})}

    def _write(self, entry):
        every = self._all()
        every[self.level] = entry
        with open(self.path + ".new", "w") as file:
            json.dump(every, file, indent=1)
        os.replace(self.path + ".new", self.path)

    def call(self, made_by):
        """A call begins; made_by: machine and program."""
        entry = self.read()
        entry["calls"] += 1
        if made_by not in entry["made_by"]:
            entry["made_by"].append(made_by)
        self._write(entry)

    def begin(self, name, look=lambda: (0, 0.0)):
        """A part begins. look() tells how many points, with how many steps, are there already: it is asked when this
        level begins the part for the first time."""
        entry = self.read()
        if name not in entry["parts"]:
            found, steps = look()
            entry["parts"][name] = {"seconds": 0.0, "core_seconds": 0.0, "found": found, "found_steps": steps}
        self._write(entry)
        self.name, self.since = name, time.monotonic()

    def tick(self, least=0.0):
        with self.lock:
            now = time.monotonic()
            if not self.name or now - self.since < least:
                return
            entry = self.read()
            part = entry["parts"][self.name]
            part["seconds"] += now - self.since
            part["core_seconds"] += (now - self.since) * self.jobs
            self.since = now
            self._write(entry)

    def end(self):
        self.tick()
        self.name = None

    def seconds(self, names=None):
        return sum(part["seconds"] for name, part in self.read()["parts"].items() if names is None or name in names)


def cost(new):
    """Core-nanoseconds per step of (points, steps, seconds, core-seconds)."""
    return 1e9 * new[3] / new[1] if new[1] > 0 else None


def duration(seconds):
    if seconds < 100:
        return f"{seconds:.0f} s"
    return f"{seconds / 60:.1f} min" if seconds < 6000 else f"{seconds / 3600:.1f} h"


def record(results):
    """What each part took, one row each; kept like other numbers."""
    def make():
        entry, rows = results.ledger.read(), []
        for name, part in entry["parts"].items():
            points, steps = results.size(name)
            rows.append({"part": name, "found": part["found"], "points": points - part["found"],
                         "steps": steps - part["found_steps"], "seconds": part["seconds"],
                         "core_seconds": part["core_seconds"], "calls": entry["calls"]})
        if rows and results.store.kept:  # parts whose results are not here: what is kept of them
            path = os.path.join(results.store.kept, "effort.csv")
            before = Table.read(path, finished_only=False).rows if os.path.exists(path) else []
            rows = [row for row in before if row["part"] not in entry["parts"]] + rows
        return Table(rows)

    results.found.pop("effort", None)  # it grows
    return results.numbers("effort", make, "what each part took")


def told(results, html=False):
    """Sentences about time and machine; empty when nothing was run here."""
    table = record(results)
    if not table:
        return ""
    calls = int(sum({row["calls"] for row in table.rows}))  # of each folder of results
    text = (f"Computed in {duration(table.column('seconds').sum())} ({calls} call{'s' * (calls != 1)}) by "
            f"{results.all_made_by()}.")
    return text.replace("&", "&amp;").replace("<", "&lt;").replace(">", "&gt;") if html else text


def sections(results):
    """Table of what each part took. Nothing when nothing was run here."""
    table = record(results)
    if not table:
        return []
    rows, every = [], np.zeros(4)
    parts = [row["part"] for row in table.rows]
    for row in table.rows:
        new = np.array([row[name] for name in ("points", "steps", "seconds", "core_seconds")])
        every += new
        rows.append([row["part"], row["found"], *map(float, new[:3]), cost(new)])
        if row["part"] == PAPER[-1] and set(PAPER) <= set(parts):
            rows.append(["<b>so far, the paper's figures</b>", None, *map(float, every[:3]), cost(every)])
    rows.append(["<b>all</b>", None, *map(float, every[:3]), cost(every)])
    out = Section("effort", "What it took", told(results, html=True) + " Points that another level had computed "
                  "before are left out. Core-time is the time of a part times the number of jobs, idle cores "
                  "included.", new=True)
    out.tables.append(Numbers("Time of each part", ["", "points there before", "points", "steps of all points",
                                                    "time, s", "core-ns per step"], rows, shown=True))
    return [out]
