"""Annotations of the Python package: mypy --strict accepts a user's script and refuses its mistakes, every public function has them, and
values have the types that they promise."""
import inspect
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import types
import typing
import unittest

import numpy as np

from package import ROOT

import slipdisk
from slipdisk import columns, deck, film, library, notebook, plot, simulation, stored

SCRIPT = '''
import pickle
import shutil
from pathlib import Path
from typing import Any

import numpy as np
import slipdisk
import slipdisk.film
from numpy.typing import NDArray
from slipdisk import plot
from slipdisk.columns import ForceColumns

RATCHET: Path = slipdisk.inputs / "three_disk/random.cfg"
SHORT: dict[str, Any] = {"phases.settle.steps": 2000, "phases.measure.steps": 20_000, "phases.measure.frames": 1000}
GRAINS = {"integrator": "verlet", "dt": 1e-4, "time": 0.5, "gravity": {"g": 9.81, "tilt": "20 deg"},
          "materials": {"grain": {"k_n": 1e4, "k_t": 5e3, "gamma_n": 3, "mu": 0.3}}}


def spread(sim: slipdisk.Simulation) -> float:
    return float(np.hypot(sim.disks["x"], sim.disks["y"]).max())


def lost(energy: slipdisk.Record[float]) -> float:
    return energy.viscous + energy["friction"]


class Tumbler(slipdisk.Simulation):
    def turns(self) -> NDArray[Any]:
        return self.disks["angle"] / (2 * np.pi)


# Running systems.
sim = slipdisk.Simulation(GRAINS, {"dt": 2e-4}, disks={"x": np.arange(0, 0.5, 0.1), "y": 0.0199, "radius": 0.02, "density": 3.57}, threads=1)
seen: list[float] = []
sim.observe(100, lambda s: seen.append(s.time))


@sim.observe(every=1000)
def watch(s: slipdisk.Simulation) -> bool:
    return s.step >= 2000


@sim.add_force
def draw(c: ForceColumns) -> None:
    n = c.n_free
    c.force_x -= 2 * c.x[:n] + 0.3 * c.vx[:n]
    c.force_y[:] -= 2 * c.y[:n]


sim.advance(10)
sim.advance(100)
sim.advance(time=0.01, progress=False)
numbers: NDArray[np.int64] = sim.add_disks(x=[9.0, -9.0], y=0.0, radius=0.7, density=1.0, vx=[-3.0, 3.0])
sim.remove_disks(numbers)
sim.advance()
draw_again = draw
units: list[str] = [sim.columns.unit("x"), sim.columns.meaning("x"), sim.name(0), sim.deck_full]
forces: NDArray[Any] = sim.contacts["force"]
print(spread(sim), lost(sim.energy), sim.stage.phase + 1, sim.threads, sim.finished, len(seen), units, forces.sum(), sim.columns.array("x", "y")["x"])
tumbler = Tumbler(RATCHET, SHORT)
tumbler.advance(tumbler.steps - 100)
tumbler.save("tumbler.h5")
same: list[Tumbler] = [tumbler.clone(), Tumbler.load("tumbler.h5"), Tumbler.from_bytes(tumbler.to_bytes())]
print({s.hash() for s in (*same, pickle.loads(pickle.dumps(tumbler)))}, same[0].turns(), tumbler.find("upper"))
tumbler.view(height=300).save("page.html")

# Runs and results.
result = slipdisk.run(RATCHET, Path("r.h5"), SHORT, force=True, progress=False)
omega: float = result.rotation["omega"][0]
work: float = result.series["work"][-1] - result.series["work"][0]
for table in result.contacts:
    print(table["force"].sum())
print(result.frames[-1]["position"].shape, result.frames["angle"].mean(), result.frames.time[0], len(result.frames[::2]), result.frames.unit("angle"))
print(result.frames[np.argmax(result.frames.time)]["angle"], result.refresh().deck.phases["settle"].steps, result.summary.disks + 1, result.state["step"])
if result.means is not None and result.totals is not None:
    print(result.means["omega"], result.totals.omega_rms)
record = slipdisk.mean(result.series["angular_velocity"][:, 0])
error: float = record.error
print(omega, work, error, result.names, result.box, [doubt.message for doubt in result.doubts], slipdisk.info("r.h5")["steps"])
try:
    print(len(result.frames.pandas("angle")), result.series.xarray("work"))
except slipdisk.MissingPackage as missing:
    print(missing.messages, missing.status)

# Sweeps.
points = {"sweep": {"parameters": [{"path": "gravity.g", "name": "g", "values": [9, 10.0]}], "replicas": 2}}
sweep: slipdisk.Sweep = slipdisk.sweep(RATCHET, "g.sweep", {**SHORT, **points}, jobs=1)
name, first = next(sweep.results())
print(name, first.finished, sweep[1].time, sweep[sweep.names[0]].step, sweep["g"].max(), sweep.table["g"], sweep.done[["g"]], sweep.means.dtype.names)

# Pictures.
axes = plot.map(result, color="spin", frame=-1)
plot.page("r.h5", ["rotation"], time=(0.0, None)).savefig("page.png")
plot.curve(sweep, quantity="upper.omega")
if shutil.which("ffmpeg"):
    count, rate, (width, height) = slipdisk.film.film(result, "r.gif", frames="::10", progress=lambda done, of: print(done, of))

# Mistakes.
try:
    slipdisk.Simulation({"dt": -1})
except (slipdisk.UserError, slipdisk.NumericError, slipdisk.FileError, slipdisk.Interrupted) as mistake:
    messages: list[str] = mistake.messages
try:
    sim.find("nobody")
except slipdisk.UnknownName as unknown:
    print(unknown.status, slipdisk.Warning, slipdisk.Error)
print(slipdisk.__version__.split("."), slipdisk.version() == slipdisk.__version__, slipdisk.deck_text({"dt": 1e-4}))
'''

BEGIN = '''
import slipdisk
import slipdisk.film
from slipdisk import plot
class Other: pass
def watch(s: slipdisk.Simulation) -> bool: return True
def seconds(s: float) -> float: return s
def check(sim: slipdisk.Simulation, result: slipdisk.Result, sweep: slipdisk.Sweep, other: Other) -> None:
'''
MISTAKES = [  # a mistake each
    "sim.advanse(10)", "slipdisk.Simulaton", "plot.mapp", "sim.step = 3", "result.rotation = sim.rotation", "sim.find()",
    "sim.advance(10, True)", "slipdisk.run('a.cfg')", "result.series['time', 'work']", "result.frames['position', 1]", "sweep[1.5]",
    "result.means['omega']", "sim.observe('often', watch)", "sim.observe(10, seconds)", "sim.add_force(seconds)",
    "sim.add_disks(x=0, y=other, radius=1, mass=1)", "slipdisk.Simulation(3)", "slipdisk.Simulation('a.cfg', threads='all')",
    "slipdisk.Simulation('a.cfg', ['dt=1'])", "sim.advance('10')", "sim.advance(time='1 s')", "sim.save(3)",
    "slipdisk.Simulation.from_bytes('text')", "sim.find(3)", "sim.name('upper')", "sim.view('tall')", "slipdisk.run('a.cfg', None)",
    "slipdisk.run('a.cfg', 'a.h5', 'dt=1')", "slipdisk.run('a.cfg', 'a.h5', progress='yes')", "slipdisk.sweep('a.cfg', 'a.sweep', jobs='many')",
    "slipdisk.Result(3)", "slipdisk.Result('r.h5', verify='no')", "slipdisk.Sweep(None)", "slipdisk.info(3)", "slipdisk.deck_text('dt = 1')",
    "slipdisk.mean(other)", "result.view(frames=3)", "result.rows(3)", "result.frames.unit(3)", "plot.page('r.h5', 'map')", "plot.map(3)",
    "plot.map(result, color=3)", "plot.spin(result, time=3)", "plot.curve(result)", "slipdisk.film.film(result, 'r.mp4', frames=3)",
    # Values that mypy took for Any would be accepted.
    *(f"x{k}: Other = {value}" for k, value in enumerate((
        "slipdisk.__version__", "slipdisk.inputs", "slipdisk.version()", "sim.step", "sim.time", "sim.columns", "sim.columns['x']",
        "sim.disks['x']", "sim.contacts", "sim.energy", "sim.energy.work", "sim.stage.step", "sim.deck", "sim.clone()", "sim.to_bytes()",
        "sim.hash()", "sim.view().page", "result.path", "result.finished", "result.summary", "result.series", "result.series['time']",
        "result.frames[0]", "result.frames[0]['position']", "result.frames['position']", "result.frames[1:]", "result.contacts[0]",
        "result.contacts.count", "result.frames.box", "result.disks", "result.box", "result.names", "sweep.table", "sweep[0]", "sweep[1:]",
        "list(sweep)", "sweep.names", "dict(sweep.results())", "slipdisk.mean([1.0]).error", "slipdisk.UserError('a').messages",
        "slipdisk.info('r.h5')", "slipdisk.run('a.cfg', 'a.h5')", "slipdisk.film.film(result, 'r.mp4')", "plot.Source('r.h5').n_frames")))]

PUBLIC = [getattr(slipdisk, name) for name in slipdisk.__all__ if callable(getattr(slipdisk, name))]
PUBLIC += [columns.Columns, columns.Bodies, stored.Columns, stored.Frames, stored.Contacts, notebook.View, library.inputs, film.film]
PUBLIC += [getattr(plot, name) for name in plot.__all__ if callable(getattr(plot, name))]


def names(thing):
    """What an annotation may name: the module's own, and what it imports for type checkers only."""
    module = sys.modules[thing.__module__]
    return {**{name: typing.Any for name in ("Self", "Axes", "Figure", "pandas", "xarray")}, "Deck": deck.Deck, "Drawable": typing.Any, **vars(module)}


def functions(things):
    """(name, function) of functions, and of methods and properties of classes in the package."""
    for thing in things:
        if inspect.isfunction(thing):
            yield thing.__name__, thing
            continue
        for kind in (kind for kind in thing.__mro__ if kind.__module__.split(".")[0] == "slipdisk"):
            for name, item in vars(kind).items():
                function = (getattr(item, "fget", None) or getattr(item, "_function", None) or getattr(item, "func", None)
                            or getattr(item, "__func__", None) or getattr(item, "__wrapped__", None) or item)
                if inspect.isfunction(function) and not name.startswith("_"):
                    yield f"{thing.__name__}.{name}", function


def fits(value, kind):
    """True where a value is of an annotated type; of arrays also the type of their elements."""
    if kind is typing.Any or isinstance(kind, typing.TypeVar):
        return True
    if typing.get_origin(kind) in (typing.Union, types.UnionType):
        return any(fits(value, one) for one in typing.get_args(kind))
    origin, inner = typing.get_origin(kind) or kind, typing.get_args(kind)
    if origin is np.ndarray:
        element = typing.get_args(inner[1])[0]
        return isinstance(value, np.ndarray) and (not isinstance(element, type) or issubclass(value.dtype.type, element))
    if origin is list:
        return isinstance(value, list) and all(fits(item, inner[0]) for item in value)
    if origin is library.Record:
        return isinstance(value, library.Record) and all(fits(item, inner[0]) for item in value.values())
    return isinstance(value, (int, float) if origin is float else origin or type(None))


class Folder(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        temporary = tempfile.TemporaryDirectory(prefix="slipdisk-test-")
        cls.addClassCleanup(temporary.cleanup)
        cls.folder = pathlib.Path(temporary.name)
        (cls.folder / "site").mkdir()
        (cls.folder / "site/slipdisk").symlink_to(ROOT / "tools/python/slipdisk")  # as installed: nothing else of the sources is there

    def script(self, text):
        path = self.folder / "script.py"
        path.write_text(text.lstrip("\n"))
        return path


class Mypy(Folder):
    def mypy(self, text):
        """(exit status, lines with mistakes, all that mypy says) of a script."""
        done = subprocess.run([sys.executable, "-m", "mypy", "--strict", "--cache-dir", self.folder / "cache",
                               self.script(text).name], cwd=self.folder, env={**os.environ, "PYTHONPATH": str(self.folder / "site")},
                              capture_output=True, text=True)
        return done.returncode, [int(line) for line in re.findall(r"^script\.py:(\d+): error: ", done.stdout, re.M)], done.stdout + done.stderr

    def test_accepted(self):
        status, _, said = self.mypy(SCRIPT)
        self.assertEqual((status, said.startswith("Success")), (0, True), said)

    def test_refused(self):
        """Every mistake is found, on its line, and nothing else."""
        lines = [*BEGIN.strip("\n").split("\n"), *(f"    {line}" for line in MISTAKES)]
        status, found, said = self.mypy("\n".join(lines) + "\n")
        self.assertEqual(status, 1, said)
        self.assertEqual([lines[k - 1].strip() for k in dict.fromkeys(found)], MISTAKES, said)


class Values(Folder):
    def test_script(self):
        """The script that mypy accepts also runs."""
        done = subprocess.run([sys.executable, self.script(SCRIPT).name], cwd=self.folder, capture_output=True, text=True,
                              env={**os.environ, "PYTHONPATH": str(ROOT / "tools/python"), "MPLBACKEND": "agg"})
        self.assertEqual(done.returncode, 0, done.stderr)

    def test_all_annotated(self):
        """Every parameter and every return value of public functions, methods and properties."""
        lacking = []
        for name, function in functions(PUBLIC):
            parameters = list(inspect.signature(function).parameters.values())[("." in name):]
            lacking += [f"{name}: {p.name}" for p in parameters if p.annotation is p.empty]
            lacking += [] if "return" in function.__annotations__ else [name]
        self.assertEqual(lacking, [], ", ".join(lacking))

    def test_values(self):
        """Properties of running systems, results and sweeps are what they are annotated with."""
        short = {"phases.settle.steps": 2000, "phases.measure.steps": 8000, "phases.measure.frames": 1000, "phases.measure.contacts": 1000,
                 "phases.measure.series": 100}
        disks = {"measure.disks": True, "phases": [{"steps": 2000, "frames": 500, "contacts": 500, "series": 100}]}
        for deck_of, overrides in (("three_disk/random.cfg", short), ("packing/heap.cfg", disks)):
            sim = slipdisk.Simulation(slipdisk.inputs / deck_of, overrides)
            sim.advance(1000)
            result = slipdisk.run(slipdisk.inputs / deck_of, self.folder / "values.h5", overrides, force=True)
            values = [sim, result, result.frames, result.contacts, sim.view(), plot.Source(result)]
            if overrides is short:
                values.append(slipdisk.sweep(slipdisk.inputs / deck_of, self.folder / "values.sweep", {
                    **short, "sweep": {"parameters": [{"path": "gravity.g", "name": "g", "values": [9, 10.0]}]}}))
            seen = 0
            for thing in values:
                for name, function in functions([type(thing)]):
                    name = name.split(".")[1]
                    if inspect.isroutine(getattr(type(thing), name)):
                        continue
                    kind = eval(function.__annotations__["return"], names(function))
                    self.assertTrue(fits(getattr(thing, name), kind), f"{deck_of}: {type(thing).__name__}.{name}: {kind}: {getattr(thing, name)!r:.200}")
                    seen += 1
                for name, kind in vars(type(thing)).get("__annotations__", {}).items():
                    self.assertTrue(fits(getattr(thing, name), eval(kind, names(type(thing)))), f"{type(thing).__name__}.{name}")
                    seen += 1
            self.assertGreater(seen, 50)

            def look(c):
                for name, kind in columns.ForceColumns.__annotations__.items():
                    self.assertTrue(fits(getattr(c, name), eval(kind, names(columns.ForceColumns))), name)
                self.assertEqual(set(columns.ForceColumns.__annotations__), set(columns.ForceColumns.__slots__))

            sim.add_force(look)
            sim.advance(1)
            self.assertEqual(sim.add_disks(x=[], y=[], radius=[], mass=[]).dtype, np.int64)


if __name__ == "__main__":
    unittest.main(verbosity=1)
