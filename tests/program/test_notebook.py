"""The Python package in notebooks: decks as values, completion of names, tables, DataFrames and Datasets, inline pages, progress."""
import contextlib
import html
import io
import os
import pathlib
import re
import signal
import subprocess
import sys
import tempfile
import time
import types
import unittest
import unittest.mock
import warnings

import numpy as np

from package import PROGRAM, ROOT

import slipdisk
import view_page
from slipdisk import notebook
from slipdisk.deck import TEXTS, deck_values

RATCHET = ROOT / "inputs/three_disk/random.cfg"
SHORT = {"phases.settle.steps": 2000, "phases.measure.steps": 30_000, "phases.measure.series": 100, "phases.measure.frames": 500,
         "phases.measure.contacts": 1000}
WAVE = {"phases.measure.steps": 3000, "sweep": {"parameters": [{"path": "gravity.g", "name": "g", "values": [9, 10.0]}], "replicas": 2}}
BOX = {"dt": 1e-4, "title": "<script>alert(1)</script> & more", "gravity": {"g": 9.81, "tilt": "-1/3 deg"},
       "materials": {"a 1": {"k_n": 1e3, "k_t": 5e2, "gamma_n": 0.5, "mu": 0.1}}, "container": {"type": "box", "width": "2 * 0.1", "height": 0.4},
       "packings": [{"type": "random", "fraction": 0.3, "density": 3.57, "radius": 0.02, "y": [0, 0.2]}],
       "disks": {"1": {"x": 0, "y": 0.35, "radius": "0.01", "mass": 0.01, "vx": "2^-3", "omega": "20 pi"}},
       "phases": {"fall": {"steps": 1500, "frames": 500, "contacts": 500, "series": 500}}, "measure": {"rotation": ["1"]}}


class Folder(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        temporary = tempfile.TemporaryDirectory(prefix="slipdisk-test-")
        cls.addClassCleanup(temporary.cleanup)
        cls.folder = pathlib.Path(temporary.name)
        cls.ratchet = slipdisk.run(RATCHET, cls.folder / "ratchet.h5", SHORT)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", slipdisk.Warning)
            cls.box = slipdisk.run(BOX, cls.folder / "box.h5")


class Decks(Folder):
    def test_values(self):
        """Every way to write a number; names that look like numbers stay texts."""
        deck = self.box.deck
        self.assertEqual((deck.title, deck.dt, deck["gravity"]["g"]), (BOX["title"], 1e-4, 9.81))
        self.assertEqual(deck.gravity.tilt, -1 / 3 * (np.pi / 180))
        self.assertEqual((deck.container.width, deck.container.height), (0.2, 0.4))
        one = deck.disks["1"]
        self.assertEqual((one.name, one.radius, one.vx, one.omega), ("1", 0.01, 0.125, 20 * np.pi))
        self.assertEqual((one.force, one.fixed, deck.measure.rotation), ((0.0, 0.0), False, ("1",)))
        self.assertEqual((deck.materials["a 1"].k_n, deck.materials[0] is deck.materials["a 1"]), (1000.0, True))
        self.assertEqual(deck["phases"]["fall"]["frames"], 500)
        self.assertIn('tilt = "-1/3 deg"', self.box.deck_full)
        with self.assertRaisesRegex(slipdisk.UnknownName, "no 'fal' in the groups of this list; did you mean 'fall'"):
            deck.phases["fal"]
        with self.assertRaisesRegex(slipdisk.UserError, "deck:2: .* expected a deck that slipdisk has written"):
            deck_values("dt = 1;\n@include 'x'")
        text = deck_values('title = "a \\"b\\" \\\\ \\n \\x07 /* 3 */"; seed = 12345678901L; on = true; none = (); group = { };')
        self.assertEqual(dict(text), {"title": 'a "b" \\ \n \x07 /* 3 */', "seed": 12345678901, "on": True, "none": (), "group": {}})

    def test_is_a_deck(self):
        """What `deck` gives is a deck again: the same bits; so is its repr."""
        for deck, more in ((RATCHET, {}), (ROOT / "inputs/packing/heap.cfg", {}), (ROOT / "inputs/packing/hopper.cfg", {}), (BOX, {})):
            with warnings.catch_warnings():
                warnings.simplefilter("ignore", slipdisk.Warning)
                one = slipdisk.Simulation(deck, more, threads=1)
                two = slipdisk.Simulation(one.deck, threads=1)
                path = self.folder / "again.cfg"
                path.write_text(repr(one.deck))
                three = slipdisk.Simulation(path, threads=1)
            for simulation in (one, two, three):
                simulation.advance(300)
            self.assertEqual({two.hash(), three.hash()}, {one.hash()})
            self.assertEqual(two.deck, one.deck)

    def test_types(self):
        """In every deck that ships: a Python number for each key of numbers, a text for each of texts, as `check --keys` tells."""
        said = subprocess.run([PROGRAM, "check", "--keys"], capture_output=True, text=True, check=True).stdout
        kinds = {}
        for key, kind in re.findall(r"^\|`(\w+)`\|([^|]+)\|", said, re.M):
            kinds.setdefault(key, set()).add(kind)
        named = {key for key, kind in kinds.items() if kind & {"text", "name(s)", "name(s) or number(s)"}}
        self.assertEqual(named, {key.split(".")[-1] for key in TEXTS})
        wordy = {key for key, kind in kinds.items() if kind & {"choice", "coordinate(s)"}}
        found = {}

        def walk(value, key):
            if isinstance(value, dict):
                for name, item in value.items():
                    if key != "averages":  # its names are those of the deck
                        walk(item, name)
            elif isinstance(value, tuple):
                for item in value:
                    walk(item, key)
            else:
                found.setdefault(key, set()).add(type(value))

        decks = 0
        for path in sorted((ROOT / "inputs").rglob("*.cfg")):
            done = subprocess.run([PROGRAM, "check", path], capture_output=True, text=True, check=False)
            if "# full deck" in done.stdout:  # others need files that a run makes first
                decks += 1
                walk(deck_values(done.stdout[done.stdout.index("# full deck"):]), "")
        self.assertGreater(decks, 80)
        for key, seen in found.items():
            if str in seen:
                self.assertIn(key, named | wordy)
            if key in named - {"columns"} and key in ("name", "title", "material", "group"):
                self.assertEqual(seen, {str}, key)
        self.assertEqual((found["tilt"], found["k_n"], found["steps"]), ({float}, {float}, {int}))

    def test_added(self):
        s = slipdisk.Simulation({"dt": 1e-3, "time": 1, "materials": {"a": {"k_n": 1e4}}}, disks={"x": [0.0], "y": 0.0, "radius": 1, "mass": 1})
        s.add_disks(x=9, y=0, radius=1, mass=1)
        self.assertEqual((s.deck, s.deck_full), ({}, ""))
        for without in (s, slipdisk.Simulation(RATCHET).clone()):
            with self.assertRaisesRegex(slipdisk.UserError, "view: this simulation has no deck, .* view a simulation that was made from a deck"):
                without.view()


class Names(Folder):
    def test_completion(self):
        """IPython completes names wherever something is indexed by them."""
        from IPython.core.interactiveshell import InteractiveShell
        shell = InteractiveShell.instance()
        shell.user_ns.update(r=self.ratchet, s=slipdisk.Simulation(RATCHET, SHORT), b=self.box,
                             w=slipdisk.sweep(RATCHET, self.folder / "names.sweep", WAVE))
        for typed, name in (('s.columns["ang', None), ('s.columns["vx', "vx"), ('s.disks["ang', "angle"), ('s.walls["id', "id"),
                            ('s.contacts["over', "overlap"), ('s.energy["fric', "friction"), ('s.deck["gra', "gravity"),
                            ('r.series["fric', "friction"), ('r.frames["posi', "position"), ('b.wall_frames["posi', "position"),
                            ('r.contacts["slid', "sliding"), ('r.state["vx', "vx"), ('r.energy["fric', "friction"),
                            ('r.summary["cont', "contacts"), ('r.deck["grav', "gravity"), ('r.rotation["conv', "converged"),
                            ('r.disks["rad', "radius"), ("r.deck.grav", "gravity"), ("r.energy.fric", "friction"),
                            ('w["upper.omega_e', "upper.omega_error"), ('m["dis', "disk")):
            shell.user_ns["m"] = self.ratchet.deck.materials
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")
                found = [completion.text for completion in shell.Completer.completions(typed, len(typed))]
            self.assertEqual(any(name == text.strip("\"'") or text.endswith(name) for text in found) if name else bool(found), bool(name),
                             (typed, found))

    def test_names_are_read_only(self):
        for thing, name in ((self.ratchet, "series"), (slipdisk.Simulation(RATCHET, SHORT), "columns")):
            with self.assertRaisesRegex(AttributeError, f"{name} of {type(thing).__name__} cannot be set"):
                setattr(thing, name, 1)
            self.assertTrue(getattr(type(thing), name).__doc__)

    def test_contacts_by_name(self):
        contacts = self.ratchet.contacts
        np.testing.assert_array_equal(contacts["tau"], np.concatenate([table["tau"] for table in contacts]))
        with self.assertRaisesRegex(slipdisk.UnknownName, "no 'slidng' in contacts of .*; did you mean 'sliding'"):
            contacts["slidng"]
        self.assertEqual((contacts.unit("tau"), self.ratchet.frames.unit("velocity")), ("force", "length/time"))


class Tables(Folder):
    def test_html(self):
        """Tables of all that a notebook shows; nothing of a deck comes out as HTML."""
        s = slipdisk.Simulation(RATCHET, SHORT)
        s.advance(100)
        sweep = slipdisk.sweep(RATCHET, self.folder / "html.sweep", WAVE)
        for thing, said in ((s, "100 of at most 32000"), (self.ratchet, "frames: 62"), (self.box, "&lt;script&gt;alert(1)&lt;/script&gt; &amp; more"),
                            (sweep, "upper.omega"), (self.ratchet.frames, "length/time"), (self.ratchet.contacts, "overlap"),
                            (self.ratchet.series, "kinetic_rotation"), (s.columns, "vx"), (s.disks, "angle")):
            shown = thing._repr_html_()
            self.assertIn(said, shown)
            self.assertNotIn("<script", shown)
            for tag in ("table", "tr", "td", "th"):
                self.assertEqual(len(re.findall(f"<{tag}\\b", shown)), shown.count(f"</{tag}>"), tag)
        self.assertEqual(repr(self.ratchet.frames), "<slipdisk frames of disks: 62 moments, time 0 to 0.032>")

    def test_pandas(self):
        r = self.ratchet
        frames = r.frames.pandas()
        self.assertEqual(len(frames), 62 * 3)
        self.assertEqual(list(frames.columns[:4]), ["step", "time", "disk", "angle"])
        last = frames[frames.step == r.step]
        np.testing.assert_array_equal(last[["position[0]", "position[1]"]].to_numpy(), r.frames[-1]["position"])
        np.testing.assert_array_equal(last.disk, [0, 1, 2])
        contacts = r.contacts.pandas("a", "tau")
        self.assertEqual(list(contacts.columns), ["step", "time", "a", "tau"])
        np.testing.assert_array_equal(contacts[contacts.step == r.step].tau, r.contacts[-1]["tau"])
        np.testing.assert_array_equal(contacts.groupby("step").size(), r.contacts.count[r.contacts.count > 0])
        self.assertEqual(list(r.series.pandas("time", "angle").columns), ["time", "angle[0]"])
        s = slipdisk.Simulation(RATCHET, SHORT)
        np.testing.assert_array_equal(s.disks.pandas("x", "angle").x, s.disks["x"])
        self.assertEqual(len(s.columns.pandas("x", "vx")), 3)
        for wrong in (r.state.pandas, s.columns.pandas, lambda: r.state.pandas("x", "step")):
            with self.assertRaisesRegex(slipdisk.UserError, "columns of different length make no table .*name some of one length"):
                wrong()

    def test_xarray(self):
        r = self.ratchet
        frames = r.frames.xarray()
        self.assertEqual(dict(frames.sizes), {"time": 62, "disk": 3, "axis": 2})
        np.testing.assert_array_equal(frames.position.sel(axis="y", disk=0), r.frames["position"][:, 0, 1])
        self.assertEqual(frames.velocity.attrs, {"units": "length/time", "long_name": "velocity"})
        np.testing.assert_array_equal(frames.step, r.frames.step)
        self.assertEqual(self.box.wall_frames.xarray("angle").angle.dims, ("time", "wall"))
        contacts = r.contacts.xarray("force")
        np.testing.assert_array_equal(contacts.force[contacts.step == r.step], r.contacts[-1]["force"])
        series = r.series.xarray("work", "angle")
        np.testing.assert_array_equal(series.work, r.series["work"])
        self.assertEqual((series.work.attrs["units"], series.angle.dims, list(series.coords)), ("energy", ("time", "angle_1"), ["time", "step"]))
        s = slipdisk.Simulation(RATCHET, SHORT)
        for columns, dimension in ((s.disks, "disk"), (s.walls, "wall"), (s.columns, "slot"), (r.state, "slot")):
            self.assertEqual(columns.xarray("x").x.dims, (dimension,))

    def test_nothing_stored(self):
        """Results without frames, series or contact tables: tables without rows."""
        r = slipdisk.run(RATCHET, self.folder / "bare.h5", {"phases.settle.steps": 100, "phases.measure.steps": 100, "phases.settle.series": 0,
                                                            "phases.measure.series": 0})
        self.assertIn("stored", r._repr_html_())
        self.assertIn("moments", repr(r.contacts) + repr(r.wall_frames))
        self.assertEqual(len(r.wall_frames.pandas()), 0)

    def test_missing(self):
        """Without pandas or xarray the message says how to get it."""
        r = self.ratchet
        for package, call in (("pandas", r.frames.pandas), ("pandas", r.series.pandas), ("pandas", r.contacts.pandas), ("xarray", r.series.xarray),
                              ("xarray", r.frames.xarray), ("xarray", r.contacts.xarray)):
            with unittest.mock.patch.dict(sys.modules, {package: None}):
                with self.assertRaisesRegex(slipdisk.MissingPackage, f"python3 -m pip install {package}, .*apt install python3-{package}") as caught:
                    call()
            self.assertIsInstance(caught.exception, ImportError)


class Pages(Folder):
    def page(self, view):
        """The page of a View, as the browser has it from the iframe."""
        shown = view._repr_html_()
        found = re.fullmatch(r'<iframe srcdoc="([^"]*)" width="100%" height="(\d+)" [^>]*></iframe>', shown)
        self.assertEqual(html.unescape(found[1]), view.page)
        path = self.folder / "page.html"
        view.save(path)
        return view_page.Page(path), int(found[2])

    def test_running(self):
        """The page of a simulation has the state of now: at the start, later, within an observer."""
        s = slipdisk.Simulation(RATCHET, SHORT)
        seen = []
        s.observe(700, lambda sim: seen.append((sim.disks["x"], sim.disks["y"], sim.view())))
        for steps in (0, 1000, 2000):
            s.advance(steps)
            page, height = self.page(s.view(height=300))
            self.assertEqual((len(page.frames), height), (1, 300))
            np.testing.assert_allclose(page.frames[0]["x"], s.disks["x"].astype("f4"), rtol=1e-6)
            self.assertEqual(page.frames[0].head["step"], s.step)
        self.assertEqual(len(seen), 4)
        page, _ = self.page(seen[2][2])
        np.testing.assert_allclose(page.frames[0]["y"], seen[2][1].astype("f4"), rtol=1e-6)

    def test_result(self):
        page, height = self.page(self.ratchet.view())
        self.assertEqual((len(page.frames), height), (62, 640))
        page, _ = self.page(self.ratchet.view(frames="-1:"))
        self.assertEqual(page.frames[0].head["step"], self.ratchet.step)
        self.assertIn("MB", repr(self.ratchet.view()))
        self.page(slipdisk.sweep(RATCHET, self.folder / "page.sweep", WAVE)[1].view())

    def test_refused(self):
        with self.assertRaisesRegex(slipdisk.UserError, "frames"):
            self.ratchet.view(frames="all")
        for height in (10, "tall", 2.5):
            with self.assertRaisesRegex(slipdisk.UserError, "view: height = "):
                self.ratchet.view(height=height)
        with unittest.mock.patch.object(notebook, "LARGEST_PAGE", 1e5):
            with self.assertRaisesRegex(slipdisk.UserError, r"the page has 0\.\d+ MB, a notebook takes 0.1 MB: take fewer frames"):
                self.ratchet.view()


class Progress(Folder):
    def told(self, function, *, tqdm=True, screen=False):
        """(what function returns, what it writes to standard error)."""
        out = io.StringIO()
        out.isatty = lambda: screen
        hidden = {} if tqdm else {"tqdm": None, "tqdm.auto": None}
        with (unittest.mock.patch.object(notebook, "DELAY", 0.0), unittest.mock.patch.dict(sys.modules, hidden), contextlib.redirect_stderr(out)):
            return function(), out.getvalue()

    def calls(self):
        """Calls that take some pieces or polls, the total that they reach, and the name on their bar."""
        def advance(progress):
            s = slipdisk.Simulation(RATCHET, SHORT, threads=1)
            s._piece = 1000
            s.advance(progress=progress)
            return s.hash()

        def run(progress):
            return slipdisk.run(RATCHET, self.folder / "told.h5", {**SHORT, "phases.measure.steps": 300_000}, force=True,
                                progress=progress).rotation["omega"][0]

        def sweep(progress):
            with tempfile.TemporaryDirectory() as folder:
                return slipdisk.sweep(RATCHET, os.path.join(folder, "told.sweep"), {**WAVE, "phases.measure.steps": 30_000},
                                      progress=progress)["upper.omega"].tolist()

        return (advance, "advance"), (run, "told.h5"), (sweep, "told.sweep")

    def test_calls(self):
        """A bar of tqdm or a line that ends at 100 %, when it is asked for or on a terminal; the same numbers as without."""
        for call, name in self.calls():
            with self.subTest(name):
                plain, told = self.told(lambda: call(None))
                self.assertEqual(told, "")
                for tqdm, screen, progress in ((False, False, True), (True, True, None), (True, True, False)):
                    same, told = self.told(lambda: call(progress), tqdm=tqdm, screen=screen)
                    self.assertEqual(same, plain)
                    bar = rf"{name}: +\d+%\|" if tqdm else f"{name}: 100 %"  # tqdm may leave out the last
                    self.assertRegex(told, "^$" if progress is False else bar)

    def test_notebook(self):
        """In a kernel progress is shown though standard error is no terminal, and stays."""
        kernel = types.SimpleNamespace(get_ipython=lambda: types.SimpleNamespace(kernel=1))
        with unittest.mock.patch.dict(sys.modules, IPython=kernel):
            self.assertTrue(notebook.on_screen())
            _, told = self.told(lambda: self.calls()[0][0](None), tqdm=False)
        self.assertRegex(told, r"advance: 100 %.*\n$")
        self.assertFalse(self.told(notebook.on_screen)[0])

    def test_stops(self):
        """Ctrl-C, here sent to Python alone, comes out of run with and without progress, after a checkpoint that the next call uses."""
        code = ("import sys, slipdisk\n"
                "try:\n    slipdisk.run(sys.argv[1], sys.argv[2], {'phases.measure.steps': 500_000_000, 'checkpoint': 0.05}, progress=%s)\n"
                "except KeyboardInterrupt:\n    print(slipdisk.Result(sys.argv[2]).step)\n")
        for progress in (True, False):
            path = self.folder / f"stopped-{progress}.h5"
            process = subprocess.Popen([sys.executable, "-c", code % progress, RATCHET, path], stdout=subprocess.PIPE, text=True, start_new_session=True,
                                       stderr=subprocess.DEVNULL, env={**os.environ, "PYTHONPATH": str(ROOT / "tools/python")})
            end = time.monotonic() + 100
            before = 0
            while before < 10_000 and process.poll() is None and time.monotonic() < end:
                with contextlib.suppress(slipdisk.Error):
                    before = slipdisk.Result(path).step
                time.sleep(0.02)
            process.send_signal(signal.SIGINT)
            said, _ = process.communicate(timeout=100)
            self.assertEqual(process.returncode, 0)
            self.assertGreater(int(said), before)
            self.assertFalse(slipdisk.Result(path).finished)
            self.assertEqual(subprocess.run([PROGRAM, "info", path], capture_output=True).returncode, 0)  # nobody holds it


if __name__ == "__main__":
    unittest.main(verbosity=1)
