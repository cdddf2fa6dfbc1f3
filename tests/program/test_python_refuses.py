"""Nothing that Python is given is dropped: every argument of every public function, each with all values of one table, is refused with a
message or has its documented effect; so are assignments to attributes, items and copies, and what callbacks assign and return."""
import contextlib
import copy
import inspect
import io
import os
import pathlib
import pickle
import shutil
import tempfile
import unittest
import warnings

import numpy as np

import package  # noqa: F401

os.environ["MPLBACKEND"] = "agg"

import slipdisk  # noqa: E402
from slipdisk import columns, film, notebook, plot, stored  # noqa: E402

N = 9
DECK = {"dt": 1e-3, "steps": 1000, "integrator": "verlet", "materials": {"grain": {"k_n": 1e4}},
        "walls": {"floor": {"type": "line", "points": [[-1, -5], [50, -5]]}}}
DISKS = {"x": np.arange(N) * 1.0, "y": 0.0, "radius": 0.4, "mass": 1.0, "name": [f"d{k}" for k in range(N)]}
BONDED = {**DECK, "materials": {"grain": {"k_n": 1e4, "bond_k_n": 1e3, "bond_gap": 0.3, "bond_extension": 0.1}}}
SHORT = {"phases.settle.steps": 2000, "phases.measure.steps": 4000, "phases.measure.frames": 1000, "phases.measure.contacts": 1000}
RATCHET = slipdisk.inputs / "three_disk/random.cfg"
SWEPT = {**SHORT, "sweep": {"parameters": [{"path": "gravity.g", "name": "g", "values": [9, 10.0]}]}}

VALUES = {
    "float": 1.5, "int": 1, "negative": -1, "huge": 2**70, "text": "nix", "bytes": b"x", "None": None, "nan": float("nan"), "inf": float("inf"),
    "true": True, "complex": 1j, "dict": {"a": 1}, "set": {1}, "object": object(), "function": lambda *_: None, "(0,)": np.zeros(0),
    "(1,)": np.full(1, 2.0), "(2,)": (2.0, 3.0), "(3,)": np.zeros(3), "(N-1,)": np.zeros(N - 1),
    "(N,)": np.arange(N) * 2.0, "(N+1,)": np.zeros(N + 1),
    "(2N,)": np.zeros(2 * N), "(2,N)": np.zeros((2, N)), "(N,2)": np.stack([np.arange(N) * 2.0] * 2, 1), "(N,1)": np.zeros((N, 1)),
    "(N,2,1)": np.zeros((N,2,1)), "texts": ["1"] * N, "nans": np.full(N, np.nan), "Nones": [None] * N, "ragged": [1, [2, 3]],
    "masked": np.ma.array(np.zeros(N), mask=[1] + [0] * (N - 1)), "dates": np.zeros(N, "M8[s]"), "complexes": np.zeros(N, complex),
    "rows": np.zeros(N, [("x", "f8")])}
NUMBER = "float int negative"
PER_DISK = "float int (N,)"
# By annotation, of functions whose other values are not tried here: what they may be given.
TAKEN = {"bool": "true", "int": "int negative huge", "Whole": "int negative huge", "Count": "int huge", "float": "float int negative huge",
         "Positive": "float int huge true", "str": "text", "StrPath": "text", "Drawable": "text", "Sweep": "", "Result": "", "Axes": "", "Curves": "",
         "None": "None", "Sequence[float]": "", "Sequence[float | None]": "(2,)", "tuple[int, int]": "", "dict[int, Any]": "dict",
         "list[str]": "texts (0,)", "tuple[str, ...]": "texts (0,)", "Callable[[int, int], object]": "function"}
DRAWING = [getattr(plot, name) for name in plot.__all__ if callable(getattr(plot, name))] + [film.film]
PUBLIC = [getattr(slipdisk, name) for name in slipdisk.__all__ if callable(getattr(slipdisk, name))]
PUBLIC = [thing for thing in PUBLIC if not (inspect.isclass(thing) and issubclass(thing, (Exception, dict)))]
PUBLIC += [columns.Columns, columns.Bodies, stored.Columns, stored.Frames, stored.Contacts, notebook.View]


def parameters():
    """"Class.method:parameter" of all that is public."""
    for thing in PUBLIC:
        if inspect.isfunction(thing):
            yield from (f"{thing.__name__}:{name}" for name in inspect.signature(thing).parameters)
            continue
        for kind in (kind for kind in thing.__mro__ if kind.__module__.startswith("slipdisk")):
            for name, item in vars(kind).items():
                item = getattr(item, "__func__", item)
                if inspect.isfunction(item) and (not name.startswith("_") or name in ("__getitem__", "__setitem__")
                                                 or name == "__init__" and item.__annotations__):
                    yield from (f"{thing.__name__}.{name}:{each}" for each in list(inspect.signature(item).parameters)[1:])


def entries(folder, r, sw):
    """{"name:parameter": (call(simulation, value), kinds of VALUES that are taken)}; several calls of one have a word behind."""
    def new(s, **changes):
        return slipdisk.Simulation(DECK, disks={**DISKS, **changes}, threads=1)

    def stepped(s, hook, *arguments):
        hook(*arguments)
        s.advance(2)

    m, out = r.measure(), str(folder / "out.h5")
    names = {
        **{f"{name}:{parameter}": (call, "") for name, parameter, call in (
            ("Columns.__getitem__", "name", lambda s, v: s.columns[v]), ("Columns.unit", "name", lambda s, v: s.columns.unit(v)),
            ("Columns.meaning", "name", lambda s, v: s.columns.meaning(v)), ("Columns.array", "names", lambda s, v: s.columns.array(v)),
            ("Columns.pandas", "names", lambda s, v: r.series.pandas(v)), ("Columns.xarray", "names", lambda s, v: r.series.xarray(v)),
            ("Columns.__setitem__", "key", lambda s, v: s.columns.__setitem__(v, 1.0)),
            ("Columns.__setitem__", "value", lambda s, v: s.columns.__setitem__("x", v)),
            ("Bodies.__getitem__", "name", lambda s, v: s.disks[v]), ("Bodies.unit", "name", lambda s, v: s.disks.unit(v)),
            ("Bodies.meaning", "name", lambda s, v: s.disks.meaning(v)), ("Bodies.array", "names", lambda s, v: s.disks.array(v)),
            ("Bodies.pandas", "names", lambda s, v: s.walls.pandas(v)), ("Bodies.xarray", "names", lambda s, v: s.walls.xarray(v)),
            ("Bodies.__setitem__", "name", lambda s, v: s.disks.__setitem__(v, 1.0)),
            ("Bodies.__setitem__", "key", lambda s, v: s.walls.__setitem__(v, 1.0)),
            ("Bodies.__setitem__", "value", lambda s, v: s.walls.__setitem__("x", v)),
            ("Measurement.__getitem__", "name", lambda s, v: m[v]), ("Measurement.unit", "name", lambda s, v: m.unit(v)),
            ("Measurement.meaning", "name", lambda s, v: m.meaning(v)), ("Measurement.__setitem__", "key", lambda s, v: m.__setitem__(v, 1)),
            ("Measurement.__setitem__", "value", lambda s, v: m.__setitem__("z", v)),
            ("Frames.unit", "name", lambda s, v: r.frames.unit(v)), ("Frames.meaning", "name", lambda s, v: r.frames.meaning(v)),
            ("Frames.pandas", "names", lambda s, v: r.frames.pandas(v)), ("Frames.xarray", "names", lambda s, v: r.frames.xarray(v)),
            ("Contacts.unit", "name", lambda s, v: r.contacts.unit(v)), ("Contacts.meaning", "name", lambda s, v: r.contacts.meaning(v)),
            ("Contacts.pandas", "names", lambda s, v: r.contacts.pandas(v)), ("Contacts.xarray", "names", lambda s, v: r.contacts.xarray(v)),
            ("Sweep.unit", "name", lambda s, v: sw.unit(v)), ("Simulation.find", "name", lambda s, v: s.find(v)),
            ("Simulation.set", "name", lambda s, v: s.set(v, 1.0)), ("Simulation.get", "name", lambda s, v: s.get(v)),
            ("Simulation.from_bytes", "data", lambda s, v: slipdisk.Simulation.from_bytes(v)),
            ("Simulation.__init__", "deck", lambda s, v: slipdisk.Simulation(v)), ("run", "deck", lambda s, v: slipdisk.run(v, out)),
            ("sweep", "deck", lambda s, v: slipdisk.sweep(v, folder / "s")), ("Result.rows", "path", lambda s, v: r.rows(v)),
            ("Result.attribute", "path", lambda s, v: r.attribute(v, "unit")), ("Result.attributes", "path", lambda s, v: r.attributes(v)),
            ("Result.__init__", "path", lambda s, v: slipdisk.Result(v)), ("Sweep.__init__", "folder", lambda s, v: slipdisk.Sweep(v)),
            ("info", "path", lambda s, v: slipdisk.info(v)), ("Simulation.load", "path", lambda s, v: slipdisk.Simulation.load(v)),
            ("Simulation.view", "height", lambda s, v: s.view(v)), ("View.__init__", "height", lambda s, v: notebook.View("page", v)),
            ("Result.view", "height", lambda s, v: r.view(height=v)), ("run", "program", lambda s, v: slipdisk.run(RATCHET, out, program=v)
             if v is not None else refuse()),
            ("sweep", "program", lambda s, v: slipdisk.sweep(RATCHET, out, program=v) if v is not None else refuse()),
            ("info", "program", lambda s, v: slipdisk.info(out, program=v) if v is not None else refuse()),
            ("View.__setitem__", "key", lambda s, v: notebook.View("", 100).__setitem__(v, 1)),
            ("run", "overrides", lambda s, v: slipdisk.run(RATCHET, out, v) if v is not None else refuse()),
            ("sweep", "overrides", lambda s, v: slipdisk.sweep(RATCHET, out, v) if v is not None else refuse()))},
        **{f"{kind}.__setitem__:{part}": (lambda s, v, thing=thing, part=part: thing.__setitem__(*((v, 1) if part == "key" else (0, v))), "")
           for kind, thing in (("Frames", r.frames), ("Contacts", r.contacts), ("Sweep", sw), ("Result", r), ("View", notebook.View("", 100)))
           for part in ("key", "value")},
        "Simulation.__setitem__:key": (lambda s, v: s.__setitem__(v, 1), ""),
        "Simulation.__setitem__:value": (lambda s, v: s.__setitem__("x", v), ""),
        "Simulation.__init__:overrides": (lambda s, v: slipdisk.Simulation(DECK, v, disks=DISKS), "None"),
        "Simulation.__init__:overrides value": (lambda s, v: slipdisk.Simulation(DECK, {"dt": v}, disks=DISKS), ""),
        "Simulation.__init__:disks": (lambda s, v: slipdisk.Simulation(DECK, disks=v) if v is not None else refuse(), ""),
        **{f"Simulation.__init__:disks {key}": (lambda s, v, key=key: new(s, **{key: v}), taken) for key, taken in {
            "x": "(N,)", "y": f"{NUMBER} (N,) texts", "theta": f"{NUMBER} None (N,) texts", "radius": "",
            "name": "None", "material": "None", "locked": "None (0,)", "fixed": "true None texts (N,)", "force": "None (2,)"}.items()},
        "Simulation.__init__:threads": (lambda s, v: slipdisk.Simulation(DECK, disks=DISKS, threads=v), "int"),
        "Simulation.load:threads": (lambda s, v: (s.save(out), slipdisk.Simulation.load(out, v)), "int"),
        "Simulation.from_bytes:threads": (lambda s, v: slipdisk.Simulation.from_bytes(s.to_bytes(), v), "int"),
        "Simulation.save:path": (lambda s, v: s.save(v), "text bytes"),
        "Simulation.advance:steps": (lambda s, v: s.advance(v), "int None"),
        "Simulation.advance:time": (lambda s, v: s.advance(time=v), "float int None"),
        "Simulation.advance:progress": (lambda s, v: s.advance(1, progress=v), "true None"),
        "Simulation.observe:every": (lambda s, v: s.observe(v, print), "int"),
        "Simulation.observe:function": (lambda s, v: s.observe(1, v), "function None"),
        "Simulation.observe:function returns": (lambda s, v: stepped(s, s.observe, 1, lambda _: v), "true None"),
        "Simulation.add_force:function": (lambda s, v: s.add_force(v), "function"),
        "Simulation.add_force:function returns": (lambda s, v: stepped(s, s.add_force, lambda c: v), "None"),
        **{f"Simulation.add_force:function assigns {name}": (lambda s, v, name=name: stepped(s, s.add_force, lambda c: setattr(c, name, v)), "")
           for name in (*columns.ForceColumns.__slots__, "fx")},
        **{f"Simulation.add_disks:{'columns ' * (key not in 'x y radius mass density'.split())}{key}": (
            lambda s, v, key=key: s.add_disks(**{"x": np.arange(N) * 1.0, "y": 900.0, "radius": 0.1,
                                            **({} if key == "density" else {"mass": 1.0}), key: v}),
            taken) for key, taken in {"x": f"{NUMBER} (0,) (1,) (2,) (N,)", "y": NUMBER, "radius": "", "mass": "float int", "density": "float int",
                                      "vx": f"{NUMBER} (N,)", "material": "", "colour": ""}.items()},
        "Simulation.remove_disks:disks": (lambda s, v: s.remove_disks(v), "int (0,)"),
        "Simulation.bond:a": (lambda s, v: slipdisk.Simulation(BONDED, disks=DISKS).bond(v, 0), "int"),
        "Simulation.bond:b": (lambda s, v: slipdisk.Simulation(BONDED, disks=DISKS).bond(0, v), "int"),
        **{f"Simulation.set:values {name}": (lambda s, v, name=name: s.set(name, v), taken) for name, taken in {
            "x": "(N,)", "position": "(N,2)", "velocity": "(2,) (N,2)", "vx": f"{NUMBER} (N,)", "angle": f"{NUMBER} (N,)", "mass": "float int",
            "held": "int true", "gravity": "(2,)"}.items()},
        "Simulation.set:values law.mu": (lambda s, v: s.set("law.mu", v, "grain"), "float int (1,)"),
        "Simulation.set:values position of one": (lambda s, v: s.set("position", v, "d8"), "(2,)"),
        "Simulation.set:values vx of one": (lambda s, v: s.set("vx", v, "d8"), f"{NUMBER} (1,)"),
        "Simulation.set:of": (lambda s, v: s.set("vx", 1.0, v), "int None (0,)"), "Simulation.get:of": (lambda s, v: s.get("vx", v), "int None (0,)"),
        "Simulation.hold:disks": (lambda s, v: s.hold(v), "int None (0,)"), "Simulation.release:disks": (lambda s, v: s.release(v), "int None (0,)"),
        "Simulation.name:number": (lambda s, v: s.name(v), "int"),
        "Simulation.measure:region": (lambda s, v: s.measure(v), "None"), "Simulation.measure:bins": (lambda s, v: s.measure(bins=v), "int"),
        "Bodies.__setitem__:values": (lambda s, v: s.disks.__setitem__("vx", v), f"{NUMBER} (N,)"),
        "mean:x": (lambda s, v: slipdisk.mean(v), "(0,) (1,) (2,) (3,) (N-1,) (N,) (N+1,) (2N,) nans"),
        "mean:transient": (lambda s, v: slipdisk.mean(np.arange(20.0), v), "true"),
        "mean:over": (lambda s, v: slipdisk.mean(np.ones(N), over=v), "None (N,) nans"),
        "deck_text:deck": (lambda s, v: slipdisk.deck_text(v), "dict"),
        "run:output": (lambda s, v: slipdisk.run(RATCHET, fresh(v), SHORT), "text"),
        "run:force": (lambda s, v: slipdisk.run(RATCHET, r.path, SHORT, force=v), "true"),
        "run:threads": (lambda s, v: slipdisk.run(RATCHET, out, SHORT, force=True, threads=v), "int None"),
        "run:progress": (lambda s, v: slipdisk.run(RATCHET, out, SHORT, force=True, progress=v), "true None"),
        "sweep:folder": (lambda s, v: slipdisk.sweep(RATCHET, fresh(v), SWEPT), "text"),
        "sweep:jobs": (lambda s, v: slipdisk.sweep(RATCHET, sw.folder, SWEPT, jobs=v), "int"),
        "sweep:progress": (lambda s, v: slipdisk.sweep(RATCHET, sw.folder, SWEPT, progress=v), "true None"),
        "Result.__init__:verify": (lambda s, v: slipdisk.Result(r.path, verify=v), "true"),
        "Sweep.__init__:verify": (lambda s, v: slipdisk.Sweep(sw.folder, verify=v), "true"),
        "Result.fragments:table": (lambda s, v: r.fragments(v), "int negative"),
        "Result.rows:first": (lambda s, v: r.rows("state/x", v), "int"), "Result.rows:last": (lambda s, v: r.rows("state/x", 0, v), "int None"),
        "Result.groups:path": (lambda s, v: r.groups(v), "text"), "Result.datasets:path": (lambda s, v: r.datasets(v), "text"),
        "Result.attribute:name": (lambda s, v: r.attribute("state/x", v), "text"), "Result.table:path": (lambda s, v: r.table(v), "text"),
        "Result.measure:frame": (lambda s, v: r.measure(v), "int negative None (0,)"),
        "Result.measure:region": (lambda s, v: r.measure(region=v), "None"),
        "Result.measure:bins": (lambda s, v: r.measure(bins=v), "int"), "Result.view:frames": (lambda s, v: r.view(v), "None"),
        "Frames.__getitem__:which": (lambda s, v: r.frames[v], "int negative"),
        "Contacts.__getitem__:which": (lambda s, v: r.contacts[v], "int negative"),
        "Sweep.__getitem__:which": (lambda s, v: sw[v], "int negative"), "Sweep.path:name": (lambda s, v: sw.path(v), "text"),
        "Sweep.pandas:means": (lambda s, v: sw.pandas(v), "true"), "View.__init__:page": (lambda s, v: notebook.View(v, 100), "text"),
        "View.save:path": (lambda s, v: notebook.View("", 100).save(fresh(v)), "text")}
    return names


def fresh(path):
    """A path at which nothing is."""
    shutil.rmtree("nix", ignore_errors=True)
    pathlib.Path("nix").unlink(missing_ok=True)
    return path


def refuse():
    raise slipdisk.UserError("None is the default")


class Given(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        temporary = tempfile.TemporaryDirectory(prefix="slipdisk-test-")
        cls.addClassCleanup(temporary.cleanup)
        cls.folder = pathlib.Path(temporary.name)
        cls.addClassCleanup(os.chdir, os.getcwd())
        os.chdir(cls.folder)
        cls.result = slipdisk.run(RATCHET, cls.folder / "r.h5", SHORT)
        cls.sweep = slipdisk.sweep(RATCHET, cls.folder / "g.sweep", SWEPT)
        cls.simulation = slipdisk.Simulation(DECK, disks=DISKS, threads=1)

    def setUp(self):
        context = warnings.catch_warnings()
        context.__enter__()
        self.addCleanup(context.__exit__, None, None, None)
        warnings.simplefilter("ignore")

    def attempt(self, name, kind, call, taken):
        """The message of a refusal; "" if the value is taken."""
        with contextlib.redirect_stderr(io.StringIO()):
            try:
                call()
                said, good = "", taken
            except (slipdisk.Error, IndexError) as error:
                said, good = str(error), not taken and (isinstance(error, slipdisk.Error) or kind == "huge" or "sweep[1]" in str(error))
            except Exception as error:
                said, good = f"{type(error).__name__}: {error}", False
        with self.subTest(name):
            self.assertTrue(good, f"{name} given {kind}: {said or 'taken'}")
        return said

    def test_every_argument(self):
        table = entries(self.folder, self.result, self.sweep)
        self.assertEqual(sorted(set(parameters()) - {name.split(" ")[0] for name in table}), [], "without a row of this table")
        before, shapes = self.simulation.hash(), 0
        for name, (call, taken) in table.items():
            for kind, value in VALUES.items():
                good = kind in taken.split(" ") or f"{kind} {{}}".replace(" {}", "") in taken.replace("(N,2)", "") .split(" ") or (
                    kind == "(N,2)" and "(N,2)" in taken)
                s = self.simulation.clone() if good or name.startswith(("Simulation.add_force", "Simulation.observe")) else self.simulation
                said = self.attempt(name, kind, lambda: call(s, value), good)
                if kind == "(2,N)" and "got (2, 9)" in said:
                    self.assertRegex(said, r"(?m)expected .*\(.*\), got \(2, 9\)$")
                    shapes += 1
        self.assertEqual(self.simulation.hash(), before)
        self.assertGreater(shapes, 20)
        self.assertRaisesRegex(slipdisk.UserError, r"set: velocity: expected \(2,\) or \(9, 2\), got \(2, 9\)",
                               self.simulation.set, "velocity", np.zeros((2, N)))

    def test_every_argument_of_pictures(self):
        for function in DRAWING:
            signature = inspect.signature(function)
            rest = {"output": "f.mp4"} if "output" in signature.parameters else {}
            for name, parameter in signature.parameters.items():
                if parameter.kind is parameter.VAR_KEYWORD:
                    parts = {"time": "Sequence[float | None] | None", "frame": "int | None", "size": "tuple[float, float] | None"}
                else:
                    parts = {name: parameter.annotation}
                for key, annotation in parts.items():
                    kinds = annotation.replace("float | None]", "float or None]").split(" | ")
                    taken = " ".join(TAKEN.get(part.removeprefix("lib.").replace(" or ", " | "), "(2,)") for part in kinds).split(" ")
                    for kind in set(VALUES) - set(taken):
                        given = {**rest, key: VALUES[kind]} if key in rest or list(signature.parameters)[0] != key else rest
                        first = VALUES[kind] if list(signature.parameters)[0] == key else self.sweep if function is plot.curve else self.result
                        said = self.attempt(f"{function.__name__}:{key}", kind, lambda: function(first, **given), False)
                        self.assertRegex(said, f"(?s){key} = .*: expected ")
        self.attempt("page", "colour", lambda: self.assertRaisesRegex(TypeError, "colour", plot.page, self.result, colour="spin"), True)

    def test_attributes(self):
        """Unknown attributes and those that cannot be set are refused, and so are items; a subclass has those that it declares."""
        s, r = self.simulation, self.result
        seen = []
        stepping = s.clone()
        stepping.add_force(lambda c: seen.append(c))
        things = [s, s.columns, s.disks, s.walls, s.energy, s.stage, s.deck, s.deck["materials"]["grain"], s.measure(), s.view(),
                  r, r.frames, r.wall_frames,
                  r.contacts, r.series, r.state, r.energy, r.summary, r.provenance, r.deck, r.frames[0], self.sweep, slipdisk.mean([1, 2]), seen[0],
                  plot.Source(r)]
        before = s.hash()
        for thing in things:
            kind = type(thing).__name__
            for name in ("gravty", "Gravity", *(name for name in dir(thing) if not name.startswith("_"))):
                if (kind, name) == ("Simulation", "gravity"):
                    continue
                with self.assertRaisesRegex(slipdisk.ReadOnly, name, msg=f"{kind}.{name}"):
                    setattr(thing, name, 3)
            with self.assertRaises(slipdisk.UnknownName if kind == "Bodies" and len(thing["x"]) == N else slipdisk.ReadOnly, msg=kind):
                thing["force_x"] = 3
        self.assertRaisesRegex(slipdisk.ReadOnly, "did you mean 'gravity'", setattr, s, "gravty", (0, -1))
        self.assertRaisesRegex(AttributeError, "did you mean 'viscous'", getattr, s.energy, "viscus")
        self.assertRaisesRegex(KeyError, "did you mean 'viscous'", s.energy.__getitem__, "viscus")
        for change in (lambda d: d.update(dt=5), lambda d: d.pop("dt"), lambda d: d.clear(), lambda d: d.setdefault("a", 1), lambda d: d.popitem(),
                       lambda d: d.__delitem__("dt"), lambda d: d.__ior__({"dt": 5})):
            self.assertRaisesRegex(slipdisk.ReadOnly, "copy", change, s.deck)
        self.assertEqual(s.hash(), before)
        changed = s.deck.copy()
        changed["dt"], changed["materials"][0]["k_n"] = 5e-4, 2e4
        other = slipdisk.Simulation(changed)
        self.assertEqual((other.dt, other.deck["materials"]["grain"].k_n), (5e-4, 2e4))
        for again in (copy.deepcopy(s.deck), pickle.loads(pickle.dumps(s.deck))):
            self.assertEqual((again, type(again)), (s.deck, type(s.deck)))

        class Counting(slipdisk.Simulation):
            count = 0
            label: str

        counting = Counting(DECK, disks=DISKS)
        counting.count, counting.label, counting.gravity, counting._own = 1, "a", (0, -1), 2
        self.assertEqual((counting.count, counting.label, counting.gravity.tolist(), counting._own), (1, "a", [0, -1], 2))
        self.assertRaisesRegex(slipdisk.ReadOnly, "declare it", setattr, counting, "total", 3)

    def test_copies(self):
        """What is written into a copy is refused where it would look as if it changed the system; `+=` makes an array of one's own."""
        s = slipdisk.Simulation(RATCHET)
        s.advance(3000)
        before, taken = s.hash(), []
        copies = {"gravity": s.gravity, "get": s.get("x"), "position": s.get("position"), "disks": s.disks["x"], "columns": s.columns["x"],
                  "contact columns": s.columns["contact_force"], "contacts": s.contacts, "force": s.contacts["force"], "rotation": s.rotation,
                  "omega": s.rotation["omega"], "stress": s.measure().stress, "array": s.measure().g}
        for name, array in copies.items():
            for write in (lambda a: a.__setitem__(0, a[0]), lambda a: a.fill(0),
                          lambda a: np.copyto(a, np.zeros_like(a)), lambda a: a[:1].__setitem__(0, a[0])):
                try:
                    write(array)
                    taken.append(name)
                except (slipdisk.ReadOnly, ValueError) as error:
                    self.assertRegex(str(error), "read-only|a copy")
            mine = array.copy()
            mine[0] = array[0]
        self.assertEqual(taken, [])
        self.assertEqual(s.hash(), before)
        s.gravity += (0, 1)
        np.testing.assert_allclose(s.gravity - copies["gravity"], (0, 1), atol=1e-12)

    def test_callbacks(self):
        """A force adds in place; an observer stops by True, also by one of numpy."""
        s = self.simulation.clone()

        @s.add_force
        def add(c):
            c.force_x += 1
            c.force_y[:] += 2

        s.advance(1)
        np.testing.assert_allclose([s.disks["vx"], s.disks["vy"]], [[1e-3] * N, [2e-3] * N])
        s.observe(1, lambda s: s.columns["vx"].max() > 2e-3)
        s.advance(100)
        self.assertLess(s.step, 10)
        failing = self.simulation.clone()
        for pattern, force in (("in place: c.force_x \\+=", lambda c: setattr(c, "force_x", c.force_x + 4)),
                               ("returned tuple", lambda c: (c.force_x, c.force_y))):
            self.assertRaisesRegex(slipdisk.UserError, pattern, failing.add_force, force)
        failing.advance(1)
        self.assertEqual(failing.disks["vx"].tolist(), [0] * N)


if __name__ == "__main__":
    unittest.main()
