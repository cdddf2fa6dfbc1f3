"""The page of `slipdisk view` in a headless Chromium: what is drawn where, picking, time, plots, colours, themes, frame rate.

    SLIPDISK_SCREENSHOTS=FOLDER python3 tests/program/test_viewer.py    keeps pictures of the pages
"""
import io
import os
import pathlib
import re
import shutil
import subprocess
import tempfile
import time
import unittest

import h5py
import numpy
from chromium import browser, spills

ROOT = pathlib.Path(os.environ.get("SLIPDISK_SOURCE_DIR", pathlib.Path(__file__).resolve().parents[2]))
PROGRAM = os.environ.get("SLIPDISK_PROGRAM", str(ROOT / "build/release/slipdisk"))
VIEWER = ROOT / "src/app/view/page"
SHOTS = os.environ.get("SLIPDISK_SCREENSHOTS")
PATIENCE = 120  # seconds after which what is waited for will not come
LARGE = """title = "many disks fall"; integrator = "verlet"; dt = 5e-5; gravity = {{ g = 9.81; }};
materials = ( {{ name = "grain"; k_n = 1e4; k_t = 5e3; gamma_n = 0.5; mu = 0.1; }} );
container = {{ type = "box"; width = {width}; height = {width}; }};
packings = ( {{ type = "random"; count = {count}; density = 3.57; sizes = "list"; radii = (0.015, 0.02, 0.025); }} );
phases = ( {{ name = "fall"; steps = {steps}; frames = {every}; contacts = {every}; }} );
"""
OVERLAPS = """title = "three disks too near"; dt = 1e-4; gravity = { g = 9.81; };
materials = ( { name = "grain"; k_n = 1e4; k_t = 5e3; gamma_n = 2; mu = 0.5; } );
disks = ( { name = "a"; x = 0; y = 0.1; radius = 0.1; mass = 0.1; }, { name = "b"; x = 0.17; y = 0.1; radius = 0.1; mass = 0.1; },
  { name = "far"; x = 3; y = 0.1; radius = 0.1; mass = 0.1; } );
walls = ( { name = "floor"; type = "line"; points = ( (-1, 0), (1, 0) ); } );
phases = ( { name = "go"; time = 1; } );
"""
ICE = """title = "a disk glides"; dt = 1e-4; gravity = { g = 9.81; };
materials = ( { name = "ice"; k_n = 1e4; k_t = 5e3; gamma_n = 20; mu = 0; } );
disks = ( { name = "a"; x = 0; y = 0.0999; radius = 0.1; mass = 0.1; vx = 1; } );
walls = ( { name = "floor"; type = "line"; points = ( (-1, 0), (1, 0) ); } );
phases = ( { name = "go"; steps = 4000; frames = 1000; contacts = 1000; } );
"""
REST = """title = "at rest"; dt = 2e-5; gravity = { g = 10; }; integrator = "verlet";
materials = ( { name = "m"; k_n = 1e4; k_t = 8e3; gamma_n = 5; mu = 0.5; } );
walls = ( { name = "floor"; type = "line"; points = ((-1, 0), (1, 0)); } );
disks = ( { name = "a"; x = 0; y = 0.0999; radius = 0.1; mass = 0.1; }, { name = "b"; x = 0.5; y = 0.09998; radius = 0.1; mass = 0.1; } );
phases = ( { name = "go"; time = 1; frames = 2000; contacts = 2000; series = 500; } );
"""
HELD = """title = "one falls, one stops"; dt = 1e-3; gravity = { g = 10; };
materials = ( { name = "m"; k_n = 1e4; k_t = 8e3; gamma_n = 5; mu = 0.5; } );
disks = ( { name = "a"; x = 0; y = 3; radius = 0.5; mass = 1; fixed = true; }, { name = "b"; x = 4; y = 2; radius = 0.5; mass = 1; } );
phases = ( { steps = 300; frames = 100; }, { steps = 300; frames = 100; release = "a"; hold = "b"; } );
"""
FAR = """title = "one is far away"; dt = 1e-4; gravity = {{ g = 9.81; }};
materials = ( {{ name = "grain"; k_n = 1e4; k_t = 5e3; gamma_n = 2; mu = 0.5; }} );
disks = ( {disks} );
walls = ( {{ name = "floor"; type = "line"; points = ( (-1, 0), (1, 0) ); }} );
phases = ( {{ name = "go"; time = 1; }} );
"""


def slipdisk(*arguments):
    done = subprocess.run([PROGRAM, *map(str, arguments)], capture_output=True, text=True, check=False)
    if done.returncode not in (0, 5):
        raise RuntimeError(f"{arguments}: {done.returncode}\n{done.stdout}{done.stderr}")


class Viewer(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        folder = tempfile.TemporaryDirectory(prefix="slipdisk-viewer-")
        cls.addClassCleanup(folder.cleanup)
        cls.folder = pathlib.Path(folder.name)
        cls.driver = browser()
        cls.addClassCleanup(cls.driver.quit)
        slipdisk("run", ROOT / "inputs/walls/drum.cfg", "-q", "-o", cls.folder / "drum.h5",
                 *(w for p in ("fill", "turn") for c in ("frames", "contacts") for w in ("-D", f"phases.{p}.{c}=2500")))
        slipdisk("view", cls.folder / "drum.h5", "-o", cls.folder / "drum.html")

    # --- tools --------------------------------------------------------------------------------------

    own = ""  # an address that pages may ask
    looked = False

    def look(self, name, width=1280, height=720, scheme="light"):
        d = self.driver
        d.execute_cdp_cmd("Emulation.setDeviceMetricsOverride",
                          {"width": width, "height": height, "deviceScaleFactor": 1, "mobile": False})
        d.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": [{"name": "prefers-color-scheme", "value": scheme}]})
        d.get_log("browser"), d.get_log("performance")
        self.looked = True
        d.get(name if name.startswith("http:") else (self.folder / name).as_uri())
        self.wait(lambda: d.execute_script("return Boolean(window.slipdisk)"))

    def tearDown(self):
        self.assertEqual([entry["message"] for entry in self.driver.get_log("browser")], [])
        asked = re.findall(r'"documentURL":"[^"]*".*?"url":"((?!data:)[^"]*)"', "\n".join(
            entry["message"] for entry in self.driver.get_log("performance") if "Network.requestWillBeSent\"" in entry["message"]))
        self.assertTrue(asked or not self.looked, "the browser does not tell what pages ask for")
        self.assertEqual([url for url in asked if not url.startswith((self.folder.as_uri(), self.own or self.folder.as_uri()))], [])

    def wait(self, true, what="the page"):
        until = time.monotonic() + PATIENCE
        while not true():
            self.assertLess(time.monotonic(), until, f"{what} does not come")
            time.sleep(0.05)

    def state(self, key=None):
        state = self.driver.execute_script("return window.slipdisk.state")
        return state[key] if key else state

    def script(self, text, *arguments):
        return self.driver.execute_script(text, *arguments)

    def keys(self, *keys):
        from selenium.webdriver.common.action_chains import ActionChains
        ActionChains(self.driver).send_keys(*keys).perform()

    def picture(self, name=None):
        """Pixels [row][column][rgb] of the canvas, after what is asked for is drawn."""
        from PIL import Image
        self.driver.execute_async_script("const done = arguments[0]; requestAnimationFrame(() => requestAnimationFrame(() => done()))")
        png = self.driver.get_screenshot_as_png()
        if SHOTS and name:
            pathlib.Path(SHOTS).mkdir(parents=True, exist_ok=True)
            pathlib.Path(SHOTS, name + ".png").write_bytes(png)
        box = self.script("const r = document.getElementById('canvas').getBoundingClientRect(); return [r.x, r.y, r.right, r.bottom]")
        return numpy.asarray(Image.open(io.BytesIO(png)).convert("RGB")).astype(int)[int(box[1]):int(box[3]), int(box[0]):int(box[2])]

    def click(self, x, y, element="canvas"):
        from selenium.webdriver.common.action_chains import ActionChains
        target = self.driver.find_element("id", element) if isinstance(element, str) else element
        size = target.size
        ActionChains(self.driver).move_to_element_with_offset(target, int(round(x - size["width"] / 2)),
                                                              int(round(y - size["height"] / 2))).click().perform()

    def go(self, k):
        self.script("const e = document.getElementById('time'); e.value = arguments[0]; e.dispatchEvent(new Event('input'))", k)
        self.wait(lambda: self.state("frame") == k, f"frame {k}")

    def choose(self, quantity):
        self.script("const e = document.getElementById('quantity'); e.value = arguments[0]; e.dispatchEvent(new Event('change'))", quantity)
        self.assertEqual(self.state("quantity"), quantity)

    def text(self, name):
        return self.script("return document.getElementById(arguments[0]).innerText", name)

    # --- tests --------------------------------------------------------------------------------------

    def test_disks_are_drawn_where_the_file_has_them(self):
        self.look("drum.html", width=1700, height=1200)
        with h5py.File(self.folder / "drum.h5") as f:
            position, radius = f["particles/disks/position/value"][:], f["particles/disks/radius"][:]
            moment = f["particles/disks/position/time"][:]
        self.assertEqual(self.state("frames"), len(moment))
        last = len(moment) - 1
        for k in (0, last // 2, last):
            self.go(k)
            self.assertAlmostEqual(self.state("time"), moment[k], places=12)
            self.keys("m") if self.state("layers")["marks"] else None  # without angle marks
            pixels, zoom = self.picture(), self.state("zoom")
            self.assertTrue((pixels[5, 5] == 255).all(), "the ground is not white")
            for disk in range(0, len(radius), 7):
                x, y = self.script("return slipdisk.screen(arguments[0])", disk)
                column = self.script("return [slipdisk.column('x', arguments[0]), slipdisk.column('y', arguments[0])]", disk)
                numpy.testing.assert_allclose(column, position[k, disk], atol=1e-5 * radius[disk])
                inside = pixels[int(y), int(x + 0.4 * zoom * radius[disk])]
                self.assertLess(inside.min(), 250, f"disk {disk} of frame {k} is not drawn at {x}, {y}")
                edge = pixels[int(y), int(x + zoom * radius[disk]) - 3:int(x + zoom * radius[disk]) + 3]
                self.assertLess(edge.min(), 140, f"disk {disk} of frame {k} has no outline")
        drum = [pixels[row, pixels.shape[1] // 2] for row in range(60)]
        self.assertLess(min(p.max() for p in drum), 80, "the drum is not drawn")

    def test_a_click_picks_a_disk_with_the_numbers_of_the_file(self):
        self.look("drum.html")
        self.go(40)
        with h5py.File(self.folder / "drum.h5") as f:
            row = list(f["contacts/step"][:]).index(f["particles/disks/position/step"][40])
            rows = slice(f["contacts/first"][row], f["contacts/first"][row] + f["contacts/count"][row])
            a, b = f["contacts/a"][rows], f["contacts/b"][rows]
            disk = int(numpy.bincount(a).argmax())  # a disk with many contacts
            of = {name: f[f"particles/disks/{name}/value"][40, disk] for name in ("position", "angular_velocity", "angle")}
            numbers = {"x": of["position"][0], "y": of["position"][1], "spin": of["angular_velocity"], "angle": of["angle"]}
            radius, mass = f["particles/disks/radius"][disk], f["particles/disks/mass"][disk]
            force = f["contacts/force"][rows][(a == disk) | (b == disk)]
        self.click(*self.script(f"return slipdisk.screen({disk})"))
        self.assertEqual(self.state("selected"), disk)
        self.wait(lambda: len(self.driver.find_elements("css selector", "#disk-series canvas")) == 3, "the disk's series")
        self.picture("drum-picked")
        told = dict(line.split("\t") for line in self.text("disk-numbers").splitlines())
        powers = str.maketrans("⁻⁰¹²³⁴⁵⁶⁷⁸⁹", "-0123456789")

        def plain(text):
            return float(re.sub("·10(.*)", lambda m: "e" + m[1].translate(powers), text).replace("−", "-"))
        self.assertEqual(told["number"], str(disk))
        x, y = told["position x, y"].split(", ")
        for name, text in (("x", x), ("y", y), ("spin", told["spin ω"]), ("angle", told["angle"])):
            self.assertAlmostEqual(plain(text), numbers[name], delta=2e-5 * max(abs(numbers[name]), 1e-2), msg=name)
        self.assertAlmostEqual(plain(told["radius"]), radius, delta=1e-6)
        self.assertAlmostEqual(plain(told["mass"]), mass, delta=1e-6 * mass + 1e-8)
        self.assertGreater(len(force), 0)
        shown = [cell.text for cell in self.driver.find_elements("css selector", "#disk-contacts tr td:nth-child(2)")]
        numpy.testing.assert_allclose(sorted(map(plain, shown)), sorted(force), rtol=1e-3)
        self.click(6, 6)
        self.assertEqual(self.state("selected"), -1)
        self.script("document.getElementById('find-text').focus()")
        from selenium.webdriver.common.keys import Keys
        self.keys("17", Keys.ENTER)
        self.assertEqual(self.state("selected"), 17)
        numpy.testing.assert_allclose(self.state("center"), self.script("return [slipdisk.column('x', 17), slipdisk.column('y', 17)]"), atol=0.005)
        self.wait(lambda: len(self.driver.find_elements("css selector", "#disk-series canvas")) == 3, "the series of disk 17")
        self.picture()
        told = self.driver.find_element("css selector", "#disk-series .u-legend .u-value").text
        self.assertAlmostEqual(plain(told), self.state("time"), delta=1e-3 * self.state("time"))  # new plots know the time
        self.script("document.getElementById('find-text').select()")
        self.keys("nope", Keys.ENTER)
        self.assertEqual(self.text("find-message"), "no disk nope")
        self.assertEqual(self.state("selected"), 17)
        # what is found just after End is found where it is then
        self.script("document.getElementById('find-text').value = '31'; document.getElementById('canvas').dispatchEvent(new KeyboardEvent("
                    "'keydown', {key: 'End', bubbles: true})); document.getElementById('find').requestSubmit()")
        self.wait(lambda: self.state("frame") == self.state("frames") - 1, "the last frame")
        numpy.testing.assert_allclose(self.state("center"), self.script("return [slipdisk.column('x', 31), slipdisk.column('y', 31)]"), atol=1e-6)
        self.assertEqual(self.text("find-message"), "")

    def test_contacts_slide_as_the_file_has_it(self):
        (self.folder / "ice.cfg").write_text(ICE)
        slipdisk("run", self.folder / "ice.cfg", "-q", "-o", self.folder / "ice.h5")
        with h5py.File(self.folder / "ice.h5") as f:
            self.assertNotEqual(f["contacts/sliding"][-1], 0)
        slipdisk("view", self.folder / "ice.h5", "-o", self.folder / "ice.html")
        self.look("ice.html")
        self.go(self.state("frames") - 1)
        self.click(*self.script("return slipdisk.screen(0)"))
        self.assertIn("slides", self.text("disk-contacts"))

    def test_what_is_far_away_is_left_out_at_first(self):
        (self.folder / "far.cfg").write_text(FAR.format(disks=", ".join(
            f"{{ x = {x}; y = 0.1; radius = 0.1; mass = 0.1; }}" for x in [0.2 * k for k in range(60)] + [40])))
        slipdisk("view", self.folder / "far.cfg", "-o", self.folder / "far.html")
        self.look("far.html")
        near = self.state("zoom")
        self.assertGreater(self.script("return slipdisk.screen(60)")[0], self.picture().shape[1])
        self.keys("f")
        self.assertLess(self.state("zoom"), near / 2)
        self.assertLess(self.script("return slipdisk.screen(60)")[0], self.picture().shape[1])
        self.keys("f")
        self.assertEqual(self.state("zoom"), near)

    def test_time_by_slider_keys_play_and_plots(self):
        from selenium.webdriver.common.keys import Keys
        self.look("drum.html")
        self.assertEqual(self.state("frame"), 0)
        self.script("document.getElementById('canvas').focus()")
        for key, frame in ((Keys.ARROW_RIGHT, 1), (Keys.PAGE_DOWN, 11), (Keys.ARROW_LEFT, 10), (Keys.END, self.state("frames") - 1), (Keys.HOME, 0)):
            self.keys(key)
            self.wait(lambda wanted=frame: self.state("frame") == wanted, f"frame {frame} by a key")
        slider = self.driver.find_element("id", "time")
        self.click(slider.size["width"] / 2, slider.size["height"] / 2, slider)
        middle = (self.state("frames") - 1) / 2
        self.wait(lambda: abs(self.state("frame") - middle) < 4, "the middle of the slider")
        self.keys(Keys.HOME)
        self.script("document.activeElement.blur()")
        self.keys(" ")
        self.wait(lambda: self.state("playing") and self.state("frame") > 3, "playing")
        self.keys(" ")
        self.assertFalse(self.state("playing"))
        # the plots' line stands at the time, and a click in a plot goes there
        self.go(30)
        over = self.driver.find_element("css selector", "#plots .u-over")
        line = self.script("return new DOMMatrix(getComputedStyle(document.querySelector('#plots .plot-now')).transform).m41")
        with h5py.File(self.folder / "drum.h5") as f:
            moment, end = f["particles/disks/position/time"][:], f["observables/contacts/time"][-1]
        self.assertEqual(self.state("plotTime"), moment[30])
        self.assertAlmostEqual(line / over.size["width"], moment[30] / end, delta=0.02)
        self.click(0.75 * over.size["width"], 40, over)
        self.wait(lambda: abs(self.state("time") - 0.75 * end) < 0.1, "the time that was clicked in a plot")
        self.assertGreaterEqual(self.state("plots"), 3)

    def test_plots_tell_the_energy_that_disks_bring(self):
        (self.folder / "held.cfg").write_text(HELD)
        slipdisk("run", self.folder / "held.cfg", "-q", "-o", self.folder / "held.h5")
        slipdisk("view", self.folder / "held.h5", "-o", self.folder / "held.html")
        told = "return [...document.querySelectorAll('#plots .u-series')].map(e => e.textContent)"
        self.look("held.html")
        self.go(self.state("frames") - 1)
        # 30 with the one that is released; 15.5 and 4.5, potential and kinetic, gone with the one that is held
        self.wait(lambda: "brought by disks10" in self.script(told), "the energy that disks brought")
        self.look("drum.html")
        self.go(self.state("frames") - 1)
        self.assertEqual([text for text in self.script(told) if "brought" in text], [])

    def test_colours_forces_and_view(self):
        self.look("drum.html")
        self.go(60)
        before = self.picture("drum")
        seen = [before]
        for quantity in ("rotation", "speed", "contacts", "force", "radius", "group"):
            try:
                self.choose(quantity)
            except AssertionError:
                self.assertEqual(quantity, "group")  # there is one group only
                continue
            pixels = self.picture(f"drum-{quantity}")
            for other in seen:
                self.assertGreater((abs(pixels - other).max(axis=2) > 20).mean(), 0.02, f"{quantity} looks as another quantity")
            seen.append(pixels)
        self.choose("spin")
        self.assertAlmostEqual(self.state("range")[0], -self.state("range")[1])
        self.picture("drum-marks")
        self.keys("m")
        plain = self.picture()
        self.keys("n")
        forces = self.picture("drum-forces")
        dark, orange = (forces.max(axis=2) < 60).sum(), ((forces[..., 0] > 190) & (forces[..., 2] < 40) & (forces[..., 1] < 110)).sum()
        self.assertGreater(dark, (plain.max(axis=2) < 60).sum() + 500, "no forces are drawn")
        self.assertGreater(orange, 50, "no sliding contact is drawn")
        self.assertIn("slides", self.text("legend-forces"))
        self.keys("nm")
        zoom = self.state("zoom")
        self.keys("+")
        self.assertGreater(self.state("zoom"), 1.2 * zoom)
        self.keys("f")
        self.assertAlmostEqual(self.state("zoom"), zoom)
        self.assertLess((abs(self.picture() - before).max(axis=2) > 20).mean(), 1e-3, "not as before")
        at = self.script("return slipdisk.screen(5)")
        self.script("document.getElementById('canvas').dispatchEvent(new WheelEvent('wheel', {deltaY: -300, clientX: arguments[0] + "
                    "document.getElementById('canvas').getBoundingClientRect().x, clientY: arguments[1] + "
                    "document.getElementById('canvas').getBoundingClientRect().y, bubbles: true, cancelable: true}))", *at)
        numpy.testing.assert_allclose(self.script("return slipdisk.screen(5)"), at, atol=0.5)  # zooms at the cursor
        self.assertGreater(self.state("zoom"), 1.3 * zoom)
        self.script("const e = document.getElementById('range-mode'); e.value = 'manual'; e.dispatchEvent(new Event('change'));"
                    "const h = document.getElementById('range-high'), l = document.getElementById('range-low');"
                    "l.value = '-2'; h.value = '3'; h.dispatchEvent(new Event('change'))")
        self.assertEqual(self.state("range")[:2], [-2, 3])

    def test_legend_covers_no_disk(self):
        """It stands below the picture, whatever it says; the picture still fits."""
        for width in 1280, 420:
            self.look("drum.html", width=width, height=800)
            for quantity, forces in ("spin", False), ("speed", True), ("radius", True):
                self.choose(quantity)
                if self.state("layers")["forces"] != forces:
                    self.keys("n")
                self.picture()
                canvas, legend, footer = (self.script("const r = document.querySelector(arguments[0]).getBoundingClientRect();"
                                                      "return [r.top, r.bottom]", name) for name in ("#canvas", "#legend", "footer"))
                self.assertGreaterEqual(legend[0], canvas[1] - 0.01)
                self.assertGreaterEqual(footer[0], legend[1] - 0.01)
                self.assertGreater(canvas[1] - canvas[0], 400)
                for disk in range(0, self.script("return JSON.parse(document.getElementById('slipdisk-meta').textContent).disks"), 9):
                    x, y = self.script(f"return slipdisk.screen({disk})")
                    self.assertTrue(0 < x < width and 0 < y < canvas[1] - canvas[0], (width, quantity, disk, x, y))

    def test_picture_as_a_file(self):
        """The PNG has the pixels of the canvas, and below them the colour bar and words."""
        from PIL import Image
        self.driver.execute_cdp_cmd("Browser.setDownloadBehavior", {"behavior": "allow", "downloadPath": str(self.folder)})
        self.look("drum.html")
        self.go(40)
        for choice, how in ("spin", lambda: self.keys("s")), ("speed", lambda: self.driver.find_element("id", "save").click()):
            self.choose(choice)
            shown, path = self.picture(f"drum-{choice}"), self.folder / "drum-40.png"
            how()
            self.wait(path.exists, "the picture")
            self.wait(lambda: path.stat().st_size > 0, "the picture")
            saved = numpy.asarray(Image.open(path).convert("RGB")).astype(int)
            path.rename(self.folder / f"{choice}.png")
            height, width = shown.shape[:2]
            self.assertEqual(saved.shape, (height + 64, width, 3))
            middle = slice(60, height - 80), slice(20, width - 80)  # without what lies over the corners
            self.assertLess(abs(saved[:height][middle] - shown[middle]).mean(), 1)
            strip = saved[height:]
            bar = strip[32, 16:220]
            self.assertGreater(len({tuple(p) for p in bar.tolist()}), 60, "no colour bar")
            for part in strip[6:26, 14:200], strip[44:62, 14:230], strip[6:26, -150:], strip[26:50, -60:]:
                self.assertLess(part.min(), 130, "no words")
            if SHOTS:
                shutil.copy(self.folder / f"{choice}.png", pathlib.Path(SHOTS, f"saved-{choice}.png"))

    def test_axes_of_flat_lines(self):
        """A disk at rest: ticks differ, rounding is no scale, and 0 is 0."""
        (self.folder / "rest.cfg").write_text(REST)
        slipdisk("run", self.folder / "rest.cfg", "-q", "-o", self.folder / "rest.h5")
        slipdisk("view", self.folder / "rest.h5", "-o", self.folder / "rest.html")
        self.look("rest.html", height=1600)
        self.script("document.querySelectorAll('details').forEach((e) => e.open = true)")
        self.click(*self.script("return slipdisk.screen(0)"))
        self.wait(lambda: len(self.driver.find_elements("css selector", "#disk-series canvas")) == 3, "the disk's series")
        told = self.script("""const range = (low, high, least) => Plot.range(low, high, least), u = null;
            const ticks = (values, step) => Plot.ticks(u, values, 1, 0, step);
            return [range(10.5, 10.5 + 1e-12, 0), range(1e-17, 3e-17, 1e-14), range(0, 0, 0), range(2, 4, 0),
              ticks([10.537, 10.5371, 10.5372], 1e-4), ticks([-0.1, -1.4e-17, 0.1], 0.1), ticks([], 1), ticks([0], 1)]""")
        self.assertEqual([round(v, 6) for v in told[0]], [5.25, 15.75])
        self.assertEqual(told[1:3], [[-1, 1], [-1, 1]])
        self.assertTrue(told[3][0] <= 2 and told[3][1] >= 4, told)
        self.assertEqual(told[4:], [["10.537", "10.5371", "10.5372"], ["−0.1", "0", "0.1"], [], ["0"]])
        ends = self.script("return slipdisk.axes")
        self.assertGreater(len(ends), 6)
        for low, high in ends:
            self.assertGreater(high - low, 1e-12)
            self.assertGreater((high - low) / max(abs(low), abs(high)), 1e-7)
        self.picture("rest")

    def test_nothing_reaches_beyond_its_part_of_the_page(self):
        """In frames of any width, as notebooks have them; every canvas has a name."""
        self.look("drum.html")
        for width in (300, 360, 480, 600, 820, *range(821, 940, 17), 1280):
            self.assertEqual(spills(self.driver, width), [], width)
        self.assertGreater(self.script("return document.querySelectorAll('aside canvas').length"), 2)

    def test_dark_narrow_and_dialogs(self):
        self.look("drum.html", scheme="dark")
        self.assertEqual(self.state("theme"), "dark")
        self.assertLess(self.picture("drum-dark")[5, 5].max(), 40)
        bars = "return getComputedStyle(document.getElementById('legend-gradient')).backgroundImage"
        dark, of_dark = self.script(bars), self.picture()
        self.keys("d")
        self.assertGreater(self.picture()[5, 5].min(), 240)
        self.assertNotEqual(self.script(bars), dark)
        self.assertFalse((self.picture() == of_dark).all(axis=2).mean() > 0.5, "disks keep the colours of the other theme")
        self.keys("?")
        self.assertIn("play or pause", self.text("help-dialog"))
        self.picture("help")
        self.driver.find_element("css selector", "#help-dialog form button").click()
        self.driver.find_element("id", "about").click()
        self.assertIn("Leon Sorokin", self.text("about-dialog"))
        self.picture("about")
        self.look("drum.html", width=400, height=800)
        self.assertLessEqual(self.script("return document.documentElement.scrollWidth"), 401, "scrolls sideways")
        self.picture("drum-narrow")
        self.look("drum.html", width=700, height=800)
        gaps = self.script("const n = [...document.querySelectorAll('#legend-numbers span')].map((e) => e.getBoundingClientRect());"
                           "return n.slice(1).map((box, k) => box.left - n[k].right)")
        self.assertGreater(min(gaps), 5, "the numbers of the colour bar touch")

    def test_a_deck_shows_its_overlaps(self):
        (self.folder / "near.cfg").write_text(OVERLAPS)
        slipdisk("view", self.folder / "near.cfg", "-o", self.folder / "near.html")
        self.look("near.html")
        self.assertEqual((self.state("kind"), self.state("quantity")), ("deck", "overlap"))
        self.assertIn("overlap", self.text("message-list") + self.text("overlap-list"))
        before = self.state("zoom")
        self.driver.find_element("css selector", "#overlap-list button").click()
        self.assertGreater(self.state("zoom"), 2 * before)
        self.assertIn(self.state("selected"), (0, 1))
        pixels = self.picture("deck")
        a, b = (self.script("return slipdisk.screen(arguments[0])", k) for k in (0, 1))
        mark = pixels[int(a[1]), int((a[0] + b[0]) / 2)]
        self.assertGreater(abs(mark - pixels[int(a[1] + 0.25 * (b[0] - a[0])), int(a[0] - 5)]).max(), 30, "the overlap is not marked")

    def test_a_run_is_followed_live(self):
        server = subprocess.Popen([PROGRAM, "view", ROOT / "inputs/walls/drum.cfg", "--live", "-D", "phases.turn.time=1e4"], text=True,
                                  stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
        self.addCleanup(server.stdout.close)
        self.addCleanup(server.wait)
        self.addCleanup(server.kill)
        self.own = re.search(r"http://\S+", server.stdout.readline())[0]
        self.look(self.own)
        self.wait(lambda: self.state("frames") > 5 and self.state("rows") > 5, "frames and rows of the run")
        self.assertIn("running", self.text("state"))
        self.assertEqual(self.state("kind"), "live")
        self.picture("live")
        self.go(1)  # looking back stops following, frames go on coming
        before = self.state("frames")
        self.wait(lambda: self.state("frames") > before + 2, "more frames")
        self.assertEqual(self.state("frame"), 1)
        self.driver.find_element("id", "newest").click()
        self.wait(lambda: self.state("frame") > before, "the newest frame")
        self.assertEqual([entry["message"] for entry in self.driver.get_log("browser")], [])
        server.kill()
        self.wait(lambda: "no connection" in self.text("state"), "words about the lost connection")
        self.driver.get("about:blank")
        self.driver.get_log("browser")  # a refused connection is an error to the browser

    def test_a_result_without_frames_and_a_browser_without_webgl(self):
        page = (self.folder / "drum.html").read_text(encoding="utf-8")
        empty = re.sub(r'<script type="text/plain" class="slipdisk-chunk" data-name="frame"[^>]*>[^<]*</script>', "", page)
        (self.folder / "empty.html").write_text(empty, encoding="utf-8")
        self.look("empty.html")
        self.assertIn("frames", self.text("notice"))
        old = page.replace('canvas.getContext("webgl2"', 'canvas.getContext("none"')
        (self.folder / "old.html").write_text(old, encoding="utf-8")
        self.driver.get((self.folder / "old.html").as_uri())
        self.wait(lambda: "WebGL2" in self.text("notice"), "words about WebGL2")

    def test_licence_of_what_is_shipped(self):
        page = (self.folder / "drum.html").read_text(encoding="utf-8")
        self.assertIn((VIEWER / "uplot-LICENSE").read_text().strip(), page)
        self.assertNotRegex(page, r'(?:src|href)="(?!data:)')

    def test_many_disks(self):
        for count, steps, every in ((10000, 5000, 10), (100000, 10, 10)):
            deck, result = self.folder / f"{count}.cfg", self.folder / f"{count}.h5"
            deck.write_text(LARGE.format(count=count, steps=steps, every=every, width=0.053 * count ** 0.5))
            slipdisk("run", deck, "-q", "-o", result)
            slipdisk("view", result, "-o", self.folder / "large.html")
            begun = time.monotonic()
            self.look("large.html")
            print(f"{count} disks, {self.state('frames')} frames, {(self.folder / 'large.html').stat().st_size / 1e6:.0f} MB: "
                  f"first picture after {time.monotonic() - begun:.1f} s", end="")
            pixels = self.picture(f"large-{count}")
            self.assertGreater((pixels.min(axis=2) < 250).mean(), 0.2, "few disks are drawn")
            if self.state("frames") > 100:
                self.driver.find_element("id", "rate").send_keys("100")
                self.script("document.activeElement.blur()")
                self.keys(" ")
                self.wait(lambda: self.state("frame") > 60, "playing")
                time.sleep(3)
                played = self.state()
                self.keys(" ")
                print(f", {played['drawnRate']:.0f} pictures per second, {played['cachedBytes'] / 1e6:.0f} MB decoded", end="")
                self.assertTrue(played["playing"])
                self.assertLess(played["cachedBytes"], 200e6)
            at = self.script("return slipdisk.screen(arguments[0])", count // 2)
            self.click(*at)
            self.assertGreaterEqual(self.state("selected"), 0)
            before = self.state("drawn")
            self.driver.set_script_timeout(PATIENCE)
            took = self.driver.execute_async_script(
                "const done = arguments[0], begun = performance.now(); let n = 0; const step = () => { document.getElementById("
                "n++ % 2 ? 'zoom-in' : 'zoom-out').click(); if (n < 6) requestAnimationFrame(step); else done(performance.now() - begun); }; step()")
            print(f", {1000 * (self.state('drawn') - before) / took:.0f} per second while zooming")


if __name__ == "__main__":
    unittest.main(verbosity=2)
