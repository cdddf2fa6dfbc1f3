"""Calls of the program: single runs, sweeps, theory curves. What is finished is not run again."""
import concurrent.futures
import math
import os
import shlex
import subprocess
import sys

import numpy as np

from . import levels
from .data import Table
from .effort import Ledger, duration, machine
from .kept import CURVE, DIGITS, LOG, NotKept, Store, flatten, nested, rows_of, thin

ROOT = os.path.abspath(os.path.join(os.path.dirname(__file__), *3 * [os.pardir]))
sys.path.insert(0, os.path.join(ROOT, "tools", "python"))
import slipdisk  # noqa: E402

STOPPED = 75  # exit status of a run that a signal stopped
IN_DOUBT = 5  # of one that is done, with doubts that stand in its table
POINT_DIGITS = 10  # of sweeps, whose points are subtracted from each other
INFO_DIGITS = 12
NOT_KEPT = ("file", "datasets", "provenance", "doubts")  # of the answer to info
BOOKED = 5.0  # seconds after which the time of what runs is booked


class Stopped(Exception):
    """Interrupted: the same command continues."""


def read(path):
    if not os.path.exists(path):
        return ""
    with open(path) as file:
        return file.read()


def overrides(keys):
    words = []
    for path, value in keys.items():
        words += ["-D", f"{path}={value}"]
    return words


class Results:
    """The results of one level in a folder, made or only looked at."""
    PAGE = ""

    def __init__(self, folder, level="default", program="slipdisk", jobs=1, dry=False, strict=False, say=print,
                 kept=""):
        self.folder, self.level, self.program, self.jobs = folder, level, program, jobs
        self.dry = dry        # only look at what is there
        self.strict = strict  # a figure that fails is an error
        self.say = say
        self.failed = []  # messages about what did not work
        self.tables, self.found = {}, {}  # of sweeps; of numbers
        self.processes, self.stopping = set(), False
        self.ledger = Ledger(folder, level, jobs)
        os.makedirs(folder, exist_ok=True)
        self.kept = kept  # docs/studies/data: read where there are no results and nothing is to be run
        # The name of its folder in docs/studies/data
        self.page = self.PAGE or ("errors" if level in levels.STUDIES else "paper")
        self.store = Store(os.path.join(folder, "data-" + level))
        if dry and kept:
            self._adopt()

    # --- numbers behind figures ---------------------------------------------------------------------------------
    def _adopt(self):
        """Without results of this level its numbers are those of the kept page, which may be of another level."""
        self.store.kept = os.path.join(self.kept, self.page)
        level = self.store.about().get("level", self.level)
        if level != self.level and self.anything():
            self.store.kept = ""
        elif level != self.level:
            self.level = level
            self.store.folder = os.path.join(self.folder, "data-" + level)
            self.ledger = Ledger(self.folder, level, self.jobs)

    def anything(self):
        """Is there any result of this level?"""
        return any(self.run(name) for name in self.runs()) or any(os.path.isdir(self.sweep_folder(name))
                                                                  for name in self.sweeps())

    def numbers(self, name, make, title="", digits=DIGITS, **head):
        """Table of the columns that make() finds in results: {column: values}, {column: value} or a Table; None or
        nothing where there are none: then the kept numbers of this name, if any. What is returned has been rounded as
        it is kept. digits: significant ones, or {column: of this column}; title and head: lines of the file's head."""
        LOG.append(name)
        if name not in self.found:
            try:
                rows = rows_of(make())
            except NotKept:
                rows = []
            if rows:
                self.store.write(name, rows, digits, self._head(name, title, head))
            path = self.store.path(name)
            self.found[name] = Table.read(path, finished_only=False) if path else Table()
        return self.found[name]

    def _head(self, name, title, more):
        lines = {name: title, "program": self.made_by(), "level": self.level, **more}
        return [f"{key}: {text}" for key, text in lines.items()]

    def made_by(self):
        """Program and machine that made the results; of kept numbers where there are no others."""
        made = "; and by ".join(self.ledger.read()["made_by"])
        return made or self.store.about().get("program") or (self.provenance() or "?").splitlines()[0]

    def all_made_by(self):
        """The same of all numbers of the page: also of those that are kept from before."""
        kept = self.store.about().get("program") if self.store.kept else ""
        return "; and by ".join(text for text in dict.fromkeys((kept, self.made_by())) if text)

    # --- single runs ---------------------------------------------------------------------------------------
    def _run_folder(self):
        return os.path.join(self.folder, "runs" if self.level != "quick" else "runs-quick")

    def runs(self):
        """Names of the runs of this level."""
        return list(levels.RUNS) if self.level in levels.LEVELS else []

    def _run_path(self, name):
        return os.path.join(self._run_folder(), name + ".h5")

    def run(self, name):
        """Path of a finished run, or None."""
        path = self._run_path(name)
        return path if os.path.exists(path) else None

    def info(self, name):
        """What `slipdisk info --json` says of a run (without what it says of file and program), or None."""
        def make():
            if not self.run(name):
                return None
            try:
                found = slipdisk.info(self.run(name), self.program)
            except (slipdisk.Error, OSError):
                return None
            flat = flatten({key: value for key, value in found.items() if key not in NOT_KEPT})
            return {"key": list(flat), "value": list(flat.values())}

        table = self.numbers("info-" + name, make, f"slipdisk info --json of the run {name}", INFO_DIGITS,
                             run=read(self._run_path(name)[:-3] + ".txt"))
        return nested({row["key"]: row["value"] for row in table.rows}) if table else None

    def _make_run(self, name):
        deck, by_level, keys = levels.RUNS[name]
        path = self._run_path(name)
        words = [self.program, "run", os.path.join(ROOT, "inputs", deck), "-o", path, "--quiet",
                 *overrides({**keys, **by_level[self.level]})]
        note = path[:-3] + ".txt"
        text = shlex.join(["slipdisk", "run", "inputs/" + deck, *words[6:]])
        known = read(note) == text + "\n"
        if known and os.path.exists(path):
            return
        with open(note, "w") as file:
            file.write(text + "\n")
        self._call(words + ([] if known else ["--force"]), name)

    # --- sweeps -----------------------------------------------------------------------------------------------
    def sweep_folder(self, name):
        deck, plans = levels.SWEEPS[name]
        base = deck[:-len(".cfg")]
        if self.level in plans and plans[self.level].keys:
            base += "-" + self.level
        return os.path.join(self.folder, base)

    def _sweep_words(self, name):
        deck, plans = levels.SWEEPS[name]
        plan = plans[self.level]
        return [self.program, "sweep", os.path.join(ROOT, "inputs", "paper", deck), "-o", self.sweep_folder(name),
                *overrides({**plan.keys, **plan.points})]

    def has(self, name):
        return self.level in levels.SWEEPS[name][1]

    def sweeps(self):
        """Names of the sweeps of this level, in the order in which they are run."""
        return [name for name in levels.SWEEPS if self.has(name)]

    def size(self, name):
        """(points that are finished, their steps) of a sweep, or of all "runs"."""
        if name == "runs":
            made = [self.run(run) for run in self.runs() if self.run(run)]
            return len(made), float(sum(slipdisk.Result(path).step for path in made))
        table = self._table(name)
        return len(table), float(np.nansum(table.column("steps")))

    def best(self, name):
        """The sweep with replicas of its points where this level has it and any is there."""
        more = name + "_replicas"
        table = self.sweep(more) if more in levels.SWEEPS else Table()
        return table or self.sweep(name)

    def sweep(self, name):
        """Table of a sweep as far as it has got; empty when this level does not have it."""
        if not self.has(name):
            return Table()
        LOG.append("sweep-" + name)
        if name not in self.tables:
            self.tables[name] = self._table(name)
        return self.tables[name]

    def _table(self, name):
        # Two sweeps of one level may share a folder: the table is made for the points of this one, and put aside.
        kept, made = "sweep-" + name, os.path.join(self.sweep_folder(name), "table.csv")
        if not os.path.isdir(self.sweep_folder(name)):
            if self.store.path(kept):
                return Table.read(self.store.path(kept), label=name)
            done = self._ask([*self._sweep_words(name), "--list"])
            points = [line.split()[-1] for line in done.stdout.splitlines() if line.split()]
            return Table(missing=[f"{name} {point}: not begun" for point in points])
        done = self._ask([*self._sweep_words(name), "--table"])
        if done.returncode == 0 and os.path.exists(made):
            words = self._sweep_words(name)
            self.store.write(kept, Table.read(made, finished_only=False).rows, POINT_DIGITS, self._head(
                kept, f"points of inputs/paper/{os.path.basename(words[2])}", {"command": self._told(words)}))
        elif done.returncode:
            self.failed.append(f"table of {name}: {done.stderr.strip()}")
        return Table.read(self.store.path(kept) or made, label=name)

    @staticmethod
    def _ask(words):
        """A call of the program that is over at once; one that fails where there is no program."""
        try:
            return subprocess.run(words, capture_output=True, text=True, check=False)
        except OSError as error:
            return subprocess.CompletedProcess(words, 1, "", str(error))

    @staticmethod
    def _told(words):
        """The words of a call, without folders of this machine and what it writes."""
        words = [word.removeprefix(ROOT + os.sep) for word in words]
        out = next((k for k, word in enumerate(words) if word in ("-o", "--csv", "--wave")), len(words))
        return shlex.join(["slipdisk", *words[1:out], *words[out + 2:]])

    def _make_sweep(self, name):
        self._call([*self._sweep_words(name), "-j", str(self.jobs)], name, quiet=False)

    # --- theory -----------------------------------------------------------------------------------------------
    def theory(self, name, deck, **keys):
        """Table of `slipdisk theory` for a deck of inputs/ and further keys; kept beside the results."""
        return self._theory(name, deck, "--csv", keys)

    def theory_wave(self, name, deck, keys):
        return self._theory(name, deck, "--wave", keys)

    def _theory(self, name, deck, option, keys):
        def make():
            folder = os.path.join(self.folder, "theory")
            os.makedirs(folder, exist_ok=True)
            path = os.path.join(folder, name + ".csv")
            words = [self.program, "theory", os.path.join(ROOT, "inputs", deck), option, path, *overrides(keys)]
            done = self._ask(words)
            if done.returncode:
                problems.append(f"theory {name}: {done.stderr.strip() or done.stdout.strip()}")
                return None
            return thin(Table.read(path, finished_only=False), CURVE if option == "--wave" else math.inf)

        problems = []
        command = self._told([self.program, "theory", os.path.join(ROOT, "inputs", deck), option, "", *overrides(keys)])
        table = self.numbers("theory-" + name, make, "theory", command=command)
        self.failed += [] if table else problems
        return table

    # --- all of it ----------------------------------------------------------------------------------------------
    def make(self, only=()):
        """Runs what is not there yet. Raises Stopped when a signal arrives."""
        if self.dry:
            return
        names = [name for name in self.runs() if not only or name in only]
        self.ledger.call(f"{self.program_line()} on {machine()}, {self.jobs} "
                         f"job{'s' * (self.jobs != 1)}")
        try:
            if names:
                os.makedirs(self._run_folder(), exist_ok=True)
                self.say(f"runs: {len(names)}")
                self.ledger.begin("runs", lambda: self.size("runs"))
                with concurrent.futures.ThreadPoolExecutor(self.jobs) as pool:
                    for task in [pool.submit(self._make_run, name) for name in names]:
                        task.result()
            for name in self.sweeps():
                if only and name not in only:
                    continue
                self.ledger.end()
                self.say(f"sweep {name} (so far {duration(self.ledger.seconds())})")
                self.ledger.begin(name, lambda name=name: self.size(name))
                self._make_sweep(name)
        finally:
            self.ledger.end()

    def _call(self, words, name, quiet=True):
        if self.stopping:
            raise Stopped(name)
        pipe = subprocess.PIPE if quiet else None
        process = subprocess.Popen(words, stdout=pipe, stderr=pipe, text=True)
        self.processes.add(process)
        errors = self._wait(process)
        self.processes.discard(process)
        if process.returncode == STOPPED or self.stopping:
            raise Stopped(name)
        if process.returncode == IN_DOUBT:
            print(f"{name}: in doubt" + (f": {errors.strip()}" if quiet else ""), file=sys.stderr)
        elif process.returncode:
            message = f"{name}: exit status {process.returncode}" + (f": {errors.strip()}" if quiet else "")
            self.failed.append(message)
            print(message, file=sys.stderr)

    def _wait(self, process):
        """What it wrote to its standard error, when it has ended; the time is booked meanwhile."""
        while True:
            try:
                return process.communicate(timeout=BOOKED)[1]
            except subprocess.TimeoutExpired:
                self.ledger.tick(BOOKED)

    def stop(self, *_):
        """Handler of signals: what runs writes a checkpoint and stops, nothing else is begun."""
        self.stopping = True
        for process in list(self.processes):
            process.terminate()

    def provenance(self):
        return self._ask([self.program, "version"]).stdout.strip()

    def program_line(self):
        """Version, revision and compiler of the program."""
        return (self.provenance() or self.made_by()).splitlines()[0]
