"""Calls of the program for the campaign of packings. What is finished is not run again."""
import filecmp
import glob
import os
import shlex
import shutil
import time

import numpy as np
from ratchet.data import Table
from ratchet.kept import LOG, head_of
from ratchet.runs import POINT_DIGITS, ROOT, Results, Stopped, overrides, read, slipdisk

from . import plan
from .reading import DIGITS, NO_CONTACTS, Reading, Run

__all__ = ["ROOT", "Campaign", "Stopped"]


TITLES = {"disks": "disks at the end, means over the measured time: lengths as in the deck, rad/s",
          "contacts": "contacts between disks at the end; a, b count the disks of a run", "walls": "walls at the end"}


class Campaign(Results):
    """Results of one level in a folder. Runs and sweeps are named as in plan.py."""

    PAGE = "packings"

    def __init__(self, folder, level="default", program="slipdisk", jobs=1, dry=False, strict=False, say=print,
                 entries=None, kept="", large=False):
        self.large = large
        self.entries = plan.ENTRIES if entries is None else entries
        super().__init__(folder, level, program, jobs, dry, strict, say, kept)
        self._read, self._made, self._missing = {}, None, {}

    def keep_program(self):
        """Runs with a copy of the program, so that building it anew changes nothing half-way."""
        copy = os.path.join(self.folder, "slipdisk")
        if self.dry:
            self.program = copy if os.path.exists(copy) else self.program
            return
        if not (os.path.exists(copy) and filecmp.cmp(self.program, copy, shallow=False)):
            shutil.copy2(self.program, copy + ".new")
            os.replace(copy + ".new", copy)
        self.program = copy

    def _place(self, name):
        return os.path.join(self.folder, self.level, name)

    def _words(self, name):
        entry = self.entries[name]
        deck = entry.deck if os.path.isabs(entry.deck) else os.path.join(ROOT, "inputs", "packing", entry.deck)
        folder = os.path.abspath(os.path.join(self.folder, self.level))
        keys = {path: value(folder) if callable(value) else str(value).replace("{folder}", folder)
                for path, value in {**entry.keys, **(entry.quick if self.level == "quick" else {})}.items()}
        path = self._place(name) + ("" if entry.sweep else ".h5")
        return [self.program, "sweep" if entry.sweep else "run", deck, "-o", path, *overrides(keys)]

    def files(self, name):
        """Paths of the finished results."""
        entry, place = self.entries[name], self._place(name)
        return sorted(glob.glob(os.path.join(place, "points", "*.h5") if entry.sweep else place + ".h5"))

    def anything(self):
        return any(self.files(name) for name in self.entries)

    def runs(self, name):
        """The finished results of a run or sweep, as the tables tell that are kept of them: reading.py. A file that
        cannot be read is named among what failed."""
        LOG.extend(f"{part}-{name}" for part in ("runs", *TITLES))
        return self._all(name)

    def _all(self, name):
        if name not in self._read:
            files = [path for path in self.files(name) if not os.path.isdir(path)] if name in self.entries else []
            self._read[name] = self._runs(name, files)
        return self._read[name]

    def _runs(self, name, files):
        read = {}
        for path in files:
            try:
                read[path] = Reading(path)
                read[path].rows = read[path].scalars()
            except (OSError, KeyError) as error:
                self.failed.append(f"{path}: {error}")
                read.pop(path, None)
        rows = self.numbers("runs-" + name, lambda: Table(one.rows for one in read.values()), "finished runs",
                            POINT_DIGITS, **self.told(name)).rows
        disks, contacts, walls = (self._parts(name, part, read) for part in ("disks", "contacts", "walls"))
        paths = {one.rows["name"]: path for path, one in read.items()}
        found = []
        for row in rows:
            run, whole = row["name"], row["name"] in disks  # with its disks all is there that is kept
            found.append(Run(row, disks.get(run), contacts.get(run, NO_CONTACTS if whole else None),
                             walls.get(run, {} if whole else None), paths.get(run, "")))
        return found

    def told(self, *names):
        """{"command": calls of the program that make these}, for heads of kept numbers; without folders of this machine,
        and without keys that are computed (a function in plan.py)."""
        calls = []
        for name in names:
            if name in self.entries and self.files(name):
                computed = [f"{key}=" for key, value in self.entries[name].keys.items() if callable(value)]
                words = [word.replace(os.path.abspath(self.folder), "build/packings") for word in self._words(name)]
                calls.append(self._told([next((f"{key}..." for key in computed if word.startswith(key)), word)
                                         for word in words]))
        return {"command": "; ".join(calls)} if calls else {}

    def _parts(self, name, part, read):
        """{run: {column: array}} of the disks, contacts or walls of the runs, one table for all."""
        if name in plan.ENTRIES and name not in plan.WITH_DISKS:
            return {}

        def make():
            made = {}
            for one in read.values():
                columns = getattr(one, part)()
                if columns:
                    made.setdefault("run", []).extend([one.rows["name"]] * len(next(iter(columns.values()))))
                    for key, values in columns.items():
                        made.setdefault(key, []).extend(values)
            return made

        found = {}
        for row in self.numbers(f"{part}-{name}", make, TITLES[part], DIGITS).rows:
            found.setdefault(row["run"], []).append(row)
        return {run: {key: np.array([row[key] if row[key] != "" else np.nan for row in rows]) for key in rows[0]}
                for run, rows in found.items()}

    def _head(self, name, title, more):
        """Numbers that follow from kept ones have the head that they were kept with."""
        path = os.path.join(self.store.kept, name + ".csv") if self.store.kept and not self.anything() else ""
        if os.path.exists(path):
            return [f"{key}: {text}" for key, text in head_of(path).items()]
        return super()._head(name, title, more)

    def made_by(self):
        """Programs that made the results that are there; of kept numbers where there are no others."""
        if self._made is None:
            found = {}
            for name in self.entries:
                for path in self.files(name):
                    try:
                        run = slipdisk.Result(path).provenance
                        found[f"slipdisk {run.version} ({run.revision}), {run.compiler}, {run.cpu_path}"] = None
                    except (OSError, KeyError):
                        pass
            self._made = "; and by ".join(found) or super().made_by()
        return self._made

    def wall(self, name):
        """Seconds of wall time that the last call took, or None."""
        text = read(self._place(name) + ".seconds")
        return float(text) if text else None

    def make(self, only=()):
        if self.dry:
            return
        os.makedirs(os.path.join(self.folder, self.level), exist_ok=True)
        begin = time.monotonic()
        for name, part in self._order():
            if only and name not in only:
                continue
            self.say(f"{name}{', first part' if part else ''} (after {time.monotonic() - begin:.0f} s)")
            self._make(name, self.entries[name], part)

    def _order(self):
        """[(name, is it a first part only)]: something of everything, then the rest, then what is large."""
        wanted = [name for name in self.entries if self.wanted(name)]
        if self.level == "quick":
            return [(name, False) for name in wanted]
        small = [name for name in wanted if not self.entries[name].threads]
        return ([(name, self.entries[name].first > 0) for name in small]
                + [(name, False) for name in small if self.entries[name].first]
                + [(name, False) for name in wanted if self.entries[name].threads])

    def wanted(self, name):
        """Does this belong to what is run?"""
        entry = self.entries.get(name)
        return bool(entry) and not (self.level == "quick" and entry.skip_quick) and (self.large or not entry.large)

    def _make(self, name, entry, early):
        words, note = self._words(name), self._place(name) + ".txt"
        text = shlex.join([os.path.basename(words[0]), words[1], os.path.basename(words[2]), *words[5:]]) + "\n"
        if entry.sweep:
            extra = ["-j", str(self.jobs), *(["-D", f"{entry.replicas}={entry.first}"] if early else [])]
        elif read(note) == text:
            if os.path.exists(words[4]):
                return
            extra = ["--quiet"]
        else:
            extra = ["--quiet", "--force"]
        with open(note, "w") as file:
            file.write(text)
        begin = time.monotonic()
        threads = ["--threads", str(self.jobs)] if entry.threads else []
        self._call([*words, *extra, *threads], name, quiet=not entry.sweep)
        with open(self._place(name) + ".seconds", "w") as file:
            file.write(f"{time.monotonic() - begin:.1f}\n")

    def missing(self, *names):
        """What of these is not there: one line each; of kept numbers what was not there when they were made."""
        names = [name for name in names if self.wanted(name)]
        if self.store.kept and not self.anything():
            return [row["missing"] for row in self.numbers("missing", lambda: None).rows if row["entry"] in names]
        self._missing.update((name, self._lacks(name)) for name in names)
        return [self._missing[name] for name in names if self._missing[name]]

    def keep_missing(self):
        """So that a page drawn from kept numbers says it, too."""
        self.numbers("missing", lambda: Table({"entry": name, "missing": line} for name, line in self._missing.items()
                                              if line),
                     "what was not there when the page was made")

    def _lacks(self, name):
        have = len(self.files(name))
        if not have:
            path = os.path.join(self.store.kept, "missing.csv") if self.store.kept else ""
            known = Table.read(path, finished_only=False).rows if path and os.path.exists(path) else []
            line = [row["missing"] for row in known if row["entry"] == name]
            if line or self._all(name):  # drawn from what is kept
                return line[0] if line else ""
        if not self.entries[name].sweep:
            return "" if have else f"{name}: not finished"
        done = self._ask([*self._words(name), "--count"])
        if done.returncode or not done.stdout.strip().isdigit():
            return f"{name}: {done.stderr.strip().splitlines()[0] if done.stderr.strip() else 'unknown'}"
        wanted = int(done.stdout)
        return f"{name}: {have} of {wanted} points are there" if have < wanted else ""
