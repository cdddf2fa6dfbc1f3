"""Runs that the trials disturb: their decks, their commands, and whether what they leave is right."""
import concurrent.futures
import dataclasses
import os
import pathlib
import re
import shutil
import subprocess
import tempfile
import time

from . import results
from .trial import ROOT, Row

THREE = ROOT / "inputs" / "three_disk" / "random.cfg"
SHAKE = (ROOT / "inputs" / "packing" / "shake.inc").read_text()
DEPOSIT = """
output = {{ series = 200; frames = {frames}; contacts = {frames}; }}; checkpoint = {checkpoint};
phases = ( {{ name = "deposit"; time = {time}; }} );
"""
# The packing of another run, shaken; means of every disk.
UNPACKED = SHAKE[:SHAKE.index("packings")] + SHAKE[SHAKE.index("measure"):]
SHAKEN = """
disk_files = ( {{ file = "deposited.h5"; dataset = "/particles/disks"; contacts = true; }} );
motions = ( {{ name = "shake"; wall = "floor"; coordinate = "y"; type = "harmonic"; acceleration = 2; frequency = 80;
               ramp = 0.05; }} );
output = {{ series = 200; frames = {frames}; contacts = {frames}; }}; checkpoint = {checkpoint};
phases = ( {{ name = "measure"; time = {time}; }} );
"""
FILE = re.compile(r"\.(h5|cfg|parts|tmp)\b|/lock\b|\s\.:")  # the name of one, or of the current folder, in a message
SECONDS = 300  # no run takes longer, unless it hangs


@dataclasses.dataclass
class End:
    """How a process has ended."""
    status: int
    out: str
    err: str


@dataclasses.dataclass
class Run:
    """A command in a folder of its own, and what an undisturbed one leaves there."""
    name: str
    program: pathlib.Path
    words: list                   # what is called, in the folder
    files: dict                   # name -> text or path, that must be there
    home: pathlib.Path            # of the reference and of the trials
    right: dict = None            # file -> content
    seconds: float = 0.0          # of the undisturbed run
    also: list = dataclasses.field(default_factory=list)  # what the program is called by (mpirun)
    beside: tuple = ()            # files that may be there or not
    user: int = None              # who runs it

    def folder(self, template=None):
        """A new one, with what is needed; or a copy of another."""
        place = pathlib.Path(tempfile.mkdtemp(prefix=f"{self.name}-".replace(" ", "-"), dir=self.home))
        if template:
            shutil.copytree(template, place, dirs_exist_ok=True)
            return place
        for name, what in self.files.items():
            if isinstance(what, pathlib.Path):
                shutil.copyfile(what, place / name)
            else:
                (place / name).write_text(what)
        if self.user is not None:
            os.chown(place, self.user, self.user)
        return place

    def start(self, place, env=None, **more):
        if self.user is not None:
            more |= {"user": self.user, "group": self.user, "extra_groups": []}
        return subprocess.Popen([*self.also, str(self.program), *self.words], cwd=place, env=env, text=True,
                                stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                                errors="replace", **more)

    def call(self, place, env=None, **more):
        process = self.start(place, env, **more)
        try:
            out, err = process.communicate(timeout=SECONDS)
        except subprocess.TimeoutExpired:
            process.kill()
            process.communicate()
            return End(-1, "", f"still running after {SECONDS} s")
        return End(process.returncode, out, err)

    def made(self, place):
        """All files but those that were there before."""
        return {str(p.relative_to(place)) for p in place.rglob("*") if not p.is_dir()} - {*self.files, *self.beside}

    def prepare(self):
        """The undisturbed run."""
        place = self.folder()
        began = time.monotonic()
        end = self.call(place)
        self.seconds = time.monotonic() - began
        if end.status != 0:
            raise RuntimeError(f"{self.name}: the undisturbed run ends with {end.status}: {end.err}")
        self.right = {name: results.whole(place / name) for name in self.made(place)}
        shutil.rmtree(place)
        return self

    def is_right(self, place, name):
        """Nothing, or what is wrong with this file."""
        if not (place / name).exists():
            return f"{name} is missing"
        try:
            other = results.differences(self.right[name], results.whole(place / name))
        except Exception as error:  # h5py raises many kinds for a damaged file
            return f"{name} cannot be read: {error}"
        return f"{name} differs in {len(other)}: {', '.join(other[:4])}" if other else ""

    def wrong(self, place, left_over=False):
        """Nothing, or what is wrong with what stands there; left_over: other files may be there, too."""
        more = self.made(place) - self.right.keys()
        for name in sorted(self.right):
            said = self.is_right(place, name)
            if said:
                return said
        return f"left over: {', '.join(sorted(more)[:4])}" if more and not left_over else ""

    def false(self, place):
        """Nothing, or which of the results that are there is false. Those that are missing are no lie."""
        for name in sorted(self.right):
            if name.endswith(".h5") and (place / name).exists() and self.is_right(place, name):
                return self.is_right(place, name)
        return ""

    def repair(self, place, tries=1, lost=False):
        """Gives the command again: nothing, or what is wrong afterwards. lost: others have taken away what it needs;
        then it may say so, and goes through with --force."""
        for _ in range(tries):
            end = self.call(place)
            if end.status == 0:
                break
        if lost and end.status == 4 and FILE.search(end.err):
            end = dataclasses.replace(self, words=[*self.words, "--force"]).call(place)
        # "finished already" is the right answer where everything had been done
        if end.status != 0 and not (end.status == 2 and "is finished already" in end.err):
            return f"given again it ends with {end.status}: {first_line(end.err)}"
        return self.wrong(place)


def first_line(text):
    lines = [line for line in text.strip().splitlines() if line]
    return (lines[0] if lines else "no message")[:200]


def scratch(setup):
    """In memory when there is such a place: trials synchronise many small files."""
    shm = pathlib.Path("/dev/shm")
    roomy = shm.is_dir() and os.access(shm, os.W_OK) and shutil.disk_usage(shm).free > 2**31
    return pathlib.Path(tempfile.mkdtemp(prefix="slipdisk-soak-", dir=shm if roomy else setup.work)).resolve()


# --- kinds of run -------------------------------------------------------------------------------------------

def three(setup, home, steps=40000, checkpoint=0.005, seed=1, name="three disks", series=1000, result="r.h5"):
    keys = {"phases.settle.steps": 20000, "phases.measure.steps": steps, "phases.settle.series": series,
            "phases.measure.series": series, "phases.measure.frames": max(steps // 10, 1),
            "phases.measure.contacts": max(steps // 4, 1), "checkpoint": float(checkpoint), "seed": seed}
    words = ["run", "deck.cfg", "--quiet", "--threads", "1", "-o", result]
    for key, value in keys.items():
        words += ["-D", f"{key}={value}"]
    return Run(name, setup.program, words, {"deck.cfg": THREE}, home)


def _packing(setup, home, name, deck, **files):
    words = ["run", "deck.cfg", "--quiet", "--threads", "1", "-o", "r.h5"]
    return Run(name, setup.program, words, {"deck.cfg": deck, **files}, home)


def deposit(setup, home, seconds=0.6, checkpoint=0.02, frames=3000):
    return _packing(setup, home, "deposition", SHAKE + DEPOSIT.format(time=seconds, checkpoint=checkpoint, frames=frames))


def shaking(setup, home, seconds=0.6, checkpoint=0.02, frames=3000):
    """Needs a deposited packing, which is made first."""
    before = deposit(setup, home)
    place = before.folder()
    end = before.call(place)
    if end.status != 0:
        raise RuntimeError(f"the deposition ends with {end.status}: {end.err}")
    deck = UNPACKED + SHAKEN.format(time=seconds, checkpoint=checkpoint, frames=frames)
    return _packing(setup, home, "shaking", deck, **{"deposited.h5": place / "r.h5"})


def sweep(setup, home, workers=2, steps=200000, checkpoint=0.02, points=4, ranks=0, name=None):
    tilts = ", ".join(f'"0.0{k} pi"' for k in range(1, points + 1))
    deck = (THREE.read_text() +
            f'\nsweep = {{ parameters = ( {{ path = "gravity.tilt"; values = ({tilts}); }} ); }};\n')
    words = ["sweep", "deck.cfg", "--quiet", "--threads", "1", "-o", "out"]
    for key, value in {"phases.settle.steps": 20000, "phases.measure.steps": steps, "phases.measure.series": 2000,
                       "checkpoint": float(checkpoint)}.items():
        words += ["-D", f"{key}={value}"]
    if ranks:
        launch = ["mpirun", "--allow-run-as-root", "--oversubscribe", "-n", str(ranks)]
        return Run(name or f"sweep on {ranks} ranks", setup.build.parent / "mpi" / "slipdisk", words,
                   {"deck.cfg": deck}, home, also=launch)
    return Run(name or f"sweep -j {workers}", setup.program, [*words, "-j", str(workers)], {"deck.cfg": deck}, home)


# --- many trials --------------------------------------------------------------------------------------------

def spread(n, most):
    """`most` of the numbers 1 ... n, evenly, with both ends; all when there are not more."""
    if n <= most:
        return list(range(1, n + 1))
    if most < 2:
        return [1][:most]
    return sorted({1 + round(k * (n - 1) / (most - 1)) for k in range(most)})


def together(setup, what, jobs, trial, note=""):
    """Makes all trials, as many at a time as there are processors; a trial returns "", or what went wrong; None when
    it did not come about."""
    with concurrent.futures.ThreadPoolExecutor(os.cpu_count() or 1) as pool:
        made = [text for text in pool.map(trial, jobs) if text is not None]
    said = [text for text in made if text]
    for text in said:
        setup.say(f"  failed: {what}: {text}", flush=True)
    return Row(what, len(made), len(said), said[0] if said else note)
