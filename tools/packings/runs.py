"""Calls of the program for the campaign of packings. What is finished is not run again."""
import filecmp
import glob
import os
import shlex
import shutil
import subprocess
import time

from report.runs import ROOT, Results, Stopped, overrides, read

from . import plan
from .reading import Run

__all__ = ["ROOT", "Campaign", "Stopped"]


class Campaign(Results):
    """Results of one level in a folder. Runs and sweeps are named as in plan.py."""

    PAGE = "packings"

    def __init__(self, folder, level="default", program="slipdisk", jobs=1, dry=False, strict=False, say=print,
                 entries=None, kept="", large=False):
        self.large = large
        self.entries = plan.ENTRIES if entries is None else entries
        super().__init__(folder, level, program, jobs, dry, strict, say, kept)
        self._read = {}

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
        keys = {path: str(value).replace("{folder}", os.path.join(self.folder, self.level))
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
        """The finished results of a run or sweep, read. A file that cannot be read is named among what failed."""
        found = []
        for path in self.files(name) if name in self.entries else []:
            if os.path.isdir(path):
                continue
            if path not in self._read:
                try:
                    self._read[path] = Run(path)
                except (OSError, KeyError) as error:
                    self.failed.append(f"{path}: {error}")
                    self._read[path] = None
            if self._read[path]:
                found.append(self._read[path])
        return found

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
        """What of these is not there: one line each."""
        lines = []
        for name in names:
            if not self.wanted(name):
                continue
            if not self.entries[name].sweep:
                lines += [] if self.files(name) else [f"{name}: not finished"]
                continue
            done = subprocess.run([*self._words(name), "--count"], capture_output=True, text=True, check=False)
            wanted = int(done.stdout) if done.returncode == 0 and done.stdout.strip().isdigit() else None
            have = len(self.files(name))
            if wanted is None:
                lines.append(f"{name}: {done.stderr.strip().splitlines()[0] if done.stderr.strip() else 'unknown'}")
            elif have < wanted:
                lines.append(f"{name}: {have} of {wanted} points are there")
        return lines
