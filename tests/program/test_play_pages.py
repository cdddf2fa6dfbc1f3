"""The pages with the engine inside, in a headless Chromium: settings, decks, links, bits, pulling, narrow screens, no network.

    SLIPDISK_SCREENSHOTS=FOLDER python3 tests/program/test_play_pages.py    keeps pictures of the pages
"""
import json
import os
import pathlib
import subprocess
import tempfile
import time
import unittest

from chromium import browser, spills

ROOT = pathlib.Path(os.environ.get("SLIPDISK_SOURCE_DIR", pathlib.Path(__file__).resolve().parents[2]))
PROGRAM = os.environ.get("SLIPDISK_PROGRAM", str(ROOT / "build/release/slipdisk"))
PAGES = pathlib.Path(os.environ.get("SLIPDISK_PLAY", ROOT / "build/play"))
SHOTS = os.environ.get("SLIPDISK_SCREENSHOTS")
PATIENCE = 120  # seconds after which what is waited for will not come
SCENES = "box", "drum", "heap", "shear"
LIMIT = 2_000_000  # bytes of a page


def slipdisk(*arguments):
    return subprocess.run([PROGRAM, *map(str, arguments)], capture_output=True, text=True, check=False)


class Pages(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.driver = browser()
        cls.folder = tempfile.TemporaryDirectory()
        cls.driver.set_script_timeout(PATIENCE)

    @classmethod
    def tearDownClass(cls):
        cls.driver.quit()
        cls.folder.cleanup()

    def setUp(self):
        self.screen(1280, 800)

    def tearDown(self):
        """Nothing was wrong on the pages, and they asked for nothing but themselves."""
        self.assertEqual([e["message"] for e in self.driver.get_log("browser") if e["level"] == "SEVERE"], [])
        for entry in self.driver.get_log("performance"):
            message = json.loads(entry["message"])["message"]
            if message["method"] == "Network.requestWillBeSent":
                self.assertRegex(message["params"]["request"]["url"], r"^(file:///.*\.html|data:|blob:)")

    def screen(self, width, height):
        self.driver.execute_cdp_cmd("Emulation.setDeviceMetricsOverride",
                                    {"width": width, "height": height, "deviceScaleFactor": 1, "mobile": width < 500})

    def open(self, page, address=""):
        self.driver.get("about:blank")
        self.driver.get((PAGES / page).as_uri() + address)
        self.wait("the first frame", lambda s: s["ready"] and s["step"] >= 0)

    def run_js(self, script, *arguments):
        return self.driver.execute_script(script, *arguments)

    @property
    def state(self):
        return self.run_js("return window.slipdisk && JSON.parse(JSON.stringify(window.slipdisk.state))")

    def wait(self, what, holds):
        end = time.monotonic() + PATIENCE
        while time.monotonic() < end:
            state = self.state
            if state and holds(state):
                return state
            time.sleep(0.05)
        raise AssertionError(f"{what} did not come: {self.state}")

    def set(self, **values):
        """Changes settings, and waits for the new run."""
        number = self.state["number"]
        self.run_js("window.slipdisk.set(arguments[0])", values)
        self.wait("a new run", lambda s: s["number"] > number and s["ready"])

    def until(self, step):
        """Goes to a step; the hash there."""
        reached = self.driver.execute_async_script(
            "const done = arguments[1]; window.slipdisk.until(arguments[0]).then(done)", step)
        self.assertEqual(reached["step"], step)
        return reached["hash"]

    def slide(self, key, place):
        """Moves a slider as a hand does, to a part of its way."""
        number = self.state["number"]
        self.run_js("""const input = document.getElementById(`set-${arguments[0]}`);
          input.value = Number(input.min) + arguments[1] * (input.max - input.min);
          input.dispatchEvent(new Event("input", { bubbles: true }));""", key, place)
        self.wait("a new run", lambda s: s["number"] > number and s["ready"])

    def click(self, name):
        self.run_js("document.getElementById(arguments[0]).click()", name)

    def copied(self, button):
        """The text that a button gives to the clipboard."""
        return self.driver.execute_async_script("""const [button, done] = arguments;
          Object.defineProperty(navigator, "clipboard", { configurable: true,
            value: { writeText: async (text) => done(text) } });
          document.getElementById(button).click();""", button)

    def check_deck(self, text):
        deck = pathlib.Path(self.folder.name) / "deck.cfg"
        deck.write_text(text)
        done = slipdisk("check", deck)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        return deck

    def shot(self, name):
        if SHOTS:
            pathlib.Path(SHOTS).mkdir(parents=True, exist_ok=True)
            self.driver.save_screenshot(str(pathlib.Path(SHOTS) / f"{name}.png"))


class Ratchet(Pages):
    def test_same_settings_same_bits_and_other_settings_other_bits(self):
        self.open("ratchet.html")
        first = self.until(100000)
        self.set(mu=0.2)
        self.assertNotEqual(self.until(100000), first)
        self.set(mu=0.1)
        self.assertEqual(self.until(100000), first)

    def test_every_slider_changes_the_run(self):
        self.open("ratchet.html", "#drive=random")
        before = self.until(80000)
        for key, place in (("tilt", 0.9), ("random", 0.8), ("frequency", 0.5), ("mu", 0.8), ("k_n", 0.5), ("damping", 0.9),
                           ("seed", 0.5)):
            self.slide(key, place)
            now = self.until(80000)
            self.assertNotEqual(now, before, key)
            before = now
        self.set(drive="turning")
        before = self.until(80000)
        for key, place in ("phase", 1), ("amplitude", 0.5), ("k_t", 0.4):
            self.slide(key, place)
            now = self.until(80000)
            self.assertNotEqual(now, before, key)
            before = now

    def test_deck_runs_in_the_program_with_the_same_bits(self):
        self.open("ratchet.html")
        self.set(length=100, phase=180, tilt=0.035)
        deck = self.check_deck(self.copied("copy-deck"))
        here = self.until(10050000)
        self.wait("the end", lambda s: s["over"])
        result = deck.with_suffix(".h5")
        done = slipdisk("run", deck, "-o", result, "--quiet")
        self.assertIn(done.returncode, (0, 5), done.stderr)
        with h5py.File(result) as file:
            there = file["state"].attrs["hash"]
        self.assertEqual(here, there.decode() if isinstance(there, bytes) else there)

    def test_decks_are_accepted(self):
        self.open("ratchet.html")
        for values in ({"drive": "random", "seed": 7}, {"drive": "turning", "wave": "harmonic", "phase": -35},
                       {"k_n": 1e5, "k_t": 1e7, "damping": 1, "frequency": 50}, {"mu": 0, "tilt": 0, "k_t": 1e3}):
            self.set(**values)
            self.check_deck(self.state["deck"])

    def test_link_restores_settings(self):
        self.open("ratchet.html")
        self.set(tilt=-0.03, drive="random", random=2e-4, seed=9, mu=0.25)
        here, values, link = self.until(70000), self.state["values"], self.copied("copy-link")
        self.driver.get("about:blank")
        self.driver.get(link)
        self.wait("the run of the link", lambda s: s["ready"])
        self.assertEqual(self.state["values"], values)
        self.assertEqual(self.until(70000), here)

    def test_rotation_is_that_of_theory(self):
        """In phase by (30), in opposite phases by (35): senses that differ, and speeds within 3 % of the stiff limit."""
        self.open("ratchet.html")
        for phase, margin in (0, 0.03), (180, 0.15):
            self.set(phase=phase)
            self.until(3000000)
            s = self.wait("the mean", lambda s: s["mean"] is not None and s["error"] and s["step"] == 3000000)
            theory = s["theory"]["value"]
            self.assertLess(abs(s["mean"] / theory - 1), margin, s)
            self.assertAlmostEqual(sum(s["parts"]), 1)
        self.set(phase=90)
        self.assertIn("reason", self.state["theory"])

    def test_keys_pause_and_take_steps(self):
        self.open("ratchet.html")
        self.wait("steps", lambda s: s["running"] and s["step"] > 60000)
        key = "dispatchEvent(new KeyboardEvent('keydown', { key: arguments[0], bubbles: true }))"
        self.run_js(key, " ")
        step = self.wait("a pause", lambda s: not s["running"] and s["rest"])["step"]
        self.run_js(key, ".")
        self.wait("one step", lambda s: s["step"] == step + 1)
        self.assertRegex(self.run_js("return document.getElementById('hash').textContent"), r"^[0-9a-f]{16} at step \d+$")
        self.run_js(key, " ")
        self.wait("more steps", lambda s: s["step"] > step + 1000)
        self.shot("ratchet")


class Packing(Pages):
    def test_scenes_run_and_their_decks_are_accepted(self):
        self.open("packing.html")
        for scene in SCENES:
            self.set(scene=scene, count=60)
            self.wait(f"{scene}: steps", lambda s: s["step"] > 2000)
            self.check_deck(self.copied("copy-deck"))
            self.assertGreaterEqual(self.state["disks"], 60)
            self.shot(scene)

    def test_same_settings_same_bits(self):
        self.open("packing.html", "#scene=drum&count=80")
        first = self.until(5000)
        self.click("again")
        self.wait("a new run", lambda s: s["ready"] and s["number"] > 1)
        self.assertEqual(self.until(5000), first)

    def test_a_disk_is_pulled(self):
        self.open("packing.html", "#scene=drum&count=60")
        self.wait("the disks at rest", lambda s: s["phase"] == 1)
        self.assertFalse(self.state["pulled"])
        held = self.run_js("""const api = window.slipdisk, canvas = document.getElementById("canvas");
          let best = 0;
          for (let k = 1; k < 60; k++) if (api.column("y", k) > api.column("y", best)) best = k;
          const box = canvas.getBoundingClientRect(), [x, y] = api.screen(best);
          window.pointer = (kind, x, y) => canvas.dispatchEvent(new PointerEvent(kind,
            { pointerId: 7, clientX: box.left + x, clientY: box.top + y, bubbles: true, isPrimary: true }));
          window.pointer("pointerdown", x, y);
          return { grabbed: api.state.grabbed, y: api.column("y", api.state.grabbed), at: [x, y] };""")
        self.assertGreaterEqual(held["grabbed"], 0)
        self.run_js("window.pointer('pointermove', arguments[0], 10)", held["at"][0])
        self.wait("the disk above", lambda s: s["pulled"] and self.run_js(
            "return window.slipdisk.column('y', arguments[0])", held["grabbed"]) > held["y"] + 1.5)
        self.shot("pulled")
        self.run_js("window.pointer('pointerup', arguments[0], 10)", held["at"][0])
        self.wait("the end of the pull", lambda s: s["grabbed"] == -1)

    def test_narrow_screens(self):
        for page in "ratchet.html", "packing.html":
            self.screen(360, 640)
            self.open(page)
            self.assertLessEqual(self.run_js("return document.documentElement.scrollWidth"), 360, page)
            for element in "play", "copy-deck", "copy-link":
                box = self.run_js("return document.getElementById(arguments[0]).getBoundingClientRect().toJSON()", element)
                self.assertGreaterEqual(box["left"], 0)
                self.assertLessEqual(box["right"], 360)
                self.assertGreater(box["width"], 20)
            self.shot(f"narrow-{page.removesuffix('.html')}")
            for width in (300, 360, 480, 700, 820, 860, 1280):
                self.assertEqual(spills(self.driver, width), [], (page, width))

    def test_nothing_stands_on_the_picture_but_the_buttons_of_the_zoom(self):
        """No wall, disk or force can cross the legend, the scale or the arrow of gravity."""
        for page in "ratchet.html", "packing.html":
            self.open(page)
            over = self.run_js("""const view = document.getElementById("view").getBoundingClientRect();
              return ["key", "meter", "gravity", "scale", "legend", "configurations", "zoom"].filter((id) => {
                const box = document.getElementById(id)?.getBoundingClientRect();
                return box && box.width > 0 && box.bottom > view.top + 0.5 && box.top < view.bottom - 0.5; })""")
            self.assertEqual(over, ["zoom"])

    def test_size(self):
        for page in "ratchet.html", "packing.html":
            self.assertLess((PAGES / page).stat().st_size, LIMIT)


if __name__ == "__main__":
    unittest.main(verbosity=2)
