"""The documentation site, as a reader has it: built from docs/ with warnings as errors, opened from files without a network.

- `tools/docs.sh` builds it: no broken link, reference, toctree or docstring.
- Every page of docs/ is in the navigation and in the search index; nothing is loaded from elsewhere.
- Names of results are on their page, as the program prints them.
- In headless Chromium, from file://: pages load all that they ask for and report no error, formulas are set, a search finds the page
  with the word, among the first three for words that users type (WORDS), wide pages scroll inside their tables on a narrow screen, dark
  pages are dark.

SLIPDISK_SCREENSHOTS=FOLDER keeps pictures of the pages.
"""
import json
import os
import pathlib
import re
import shutil
import subprocess
import tempfile
import time
import unittest

ROOT = pathlib.Path(os.environ.get("SLIPDISK_SOURCE_DIR", pathlib.Path(__file__).resolve().parents[2]))
DOCS = ROOT / "docs"
SHOTS = os.environ.get("SLIPDISK_SCREENSHOTS")
# Words that users type, and a page that they find among the first three.
WORDS = {"silo": "packings", "hopper": "packings", "pip": "install", "conda": "install", "jupyter": "python", "notebook": "python",
         "angle of repose": "gallery", "avalanche": "deck_tasks", "drum": "packings", "restart": "results", "benchmark": "performance",
         "GPU": "performance", "periodic": "deck", "biaxial": "cookbook/shear", "shear": "cookbook/shear", "cohesion": "laws",
         "polydisperse": "packings", "rattler": "glossary", "messages": "deck", "omega_error": "names"}
PAGES = ("index", "physics", "deck", "deck_tasks", "units", "glossary", "api/simulation", "api_python", "gallery", "measure")


def browser():
    """Headless Chromium by selenium."""
    from selenium import webdriver
    from selenium.webdriver.chrome.service import Service
    options = webdriver.ChromeOptions()
    options.binary_location = shutil.which("chromium")
    for word in ("--headless=new", "--no-sandbox", "--disable-gpu", "--hide-scrollbars", "--proxy-server=127.0.0.1:9"):
        options.add_argument(word)
    return webdriver.Chrome(options=options, service=Service(shutil.which("chromedriver")))


class Site(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory(prefix="slipdisk-site-")
        cls.addClassCleanup(cls.folder.cleanup)
        cls.site = pathlib.Path(cls.folder.name, "site")
        cls.built = subprocess.run([ROOT / "tools/docs.sh", "--no-install", "--output", cls.site], capture_output=True, text=True,
                                   check=False)

    def setUp(self):
        self.assertEqual(self.built.returncode, 0, self.built.stdout + self.built.stderr)

    def pages(self):
        """All but docs/paper, which goes to a journal."""
        return sorted(str(path.relative_to(DOCS).with_suffix("")) for path in DOCS.rglob("*.md") if path.parent.name != "paper")

    def test_pages_are_in_navigation_and_search(self):
        index = (self.site / "searchindex.js").read_text()
        index = json.loads(index.removeprefix("Search.setIndex(").removesuffix(")"))
        self.assertEqual(sorted(index["docnames"]), self.pages())
        start = (self.site / "index.html").read_text()
        for page in self.pages():
            self.assertTrue(page == "index" or f'href="{page}.html"' in start, f"{page} is not in the navigation")
        for word, page in (("gamma_n", "deck"), ("overlap", "glossary"), ("mu", "deck_tasks")):
            found = index["terms"].get(word, [])
            self.assertIn(index["docnames"].index(page), found if isinstance(found, list) else [found], word)

    def test_names_of_results(self):
        program = os.environ.get("SLIPDISK_PROGRAM", ROOT / "build/release/slipdisk")
        said = subprocess.run([program, "info", "--names"], capture_output=True, text=True, check=True).stdout
        cells = re.findall(r"<code[^>]*><span class=\"pre\">(\w+)</span></code>", (self.site / "names.html").read_text())
        names = re.findall(r"^\| `(\w+)`", said, re.M)
        self.assertGreater(len(names), 200)
        for name in set(names):
            self.assertGreaterEqual(cells.count(name), names.count(name), name)

    def test_nothing_is_loaded_from_elsewhere(self):
        for path in self.site.rglob("*.html"):
            for tag in re.findall(r"<(?:script|link|img|source|iframe)\b[^>]*>", path.read_text()):
                address = re.search(r'\b(?:src|href)="([^"]*)"', tag)
                if address and "data:" not in address[1][:5]:
                    self.assertNotRegex(address[1], r"^(\w+:)?//", f"{path.name}: {tag}")
                    target = (path.parent / re.split("[?#]", address[1])[0]).resolve()
                    self.assertTrue(target.exists(), f"{path.name}: {tag}")
        for path in self.site.rglob("*.css"):
            for address in re.findall(r"url\(['\"]?([^)'\"]+)", path.read_text()):
                self.assertNotRegex(address, r"^(\w+:)?//|^/", f"{path.name}: {address}")

    def test_in_a_browser(self):
        driver = browser()
        self.addCleanup(driver.quit)
        for width, scheme, pages in ((1300, "light", PAGES), (1300, "dark", PAGES[:3]), (390, "light", PAGES)):
            driver.execute_cdp_cmd("Emulation.setDeviceMetricsOverride",
                                   {"width": width, "height": 1000, "deviceScaleFactor": 1, "mobile": False})
            driver.execute_cdp_cmd("Emulation.setEmulatedMedia",
                                   {"features": [{"name": "prefers-color-scheme", "value": scheme}]})
            for page in pages:
                with self.subTest(page, width=width, scheme=scheme):
                    self.look(driver, page, width, scheme)
        self.search(driver)

    def look(self, driver, page, width, scheme):
        driver.get((self.site / (page + ".html")).as_uri())
        self.assertEqual([entry["message"] for entry in driver.get_log("browser")], [])
        formulas = driver.execute_script("return document.querySelectorAll('.math').length")
        self.assertEqual(driver.execute_script("return document.querySelectorAll('.math .katex').length"), formulas)
        self.assertEqual(driver.execute_script("return document.querySelectorAll('.katex-error').length"), 0)
        if page in ("physics", "measure"):
            self.assertGreater(formulas, 0)
        pictures = "return [...document.images].filter(i => !i.complete || !i.naturalWidth).map(i => i.src)"
        self.assertEqual(driver.execute_script(pictures), [])
        light = driver.execute_script("return getComputedStyle(document.body).backgroundColor.match(/\\d+/g).map(Number)")
        self.assertTrue(min(light) > 200 if scheme == "light" else max(light) < 60, light)
        self.assertLessEqual(driver.execute_script("return document.documentElement.scrollWidth"), width + 1, "scrolls sideways")
        if SHOTS:
            pathlib.Path(SHOTS).mkdir(parents=True, exist_ok=True)
            driver.save_screenshot(os.path.join(SHOTS, f"{page.replace('/', '-')}-{width}-{scheme}.png"))

    def found(self, driver, word):
        """Addresses that a search shows, the best first."""
        from selenium.webdriver.common.by import By
        from selenium.webdriver.common.keys import Keys
        driver.get((self.site / "index.html").as_uri())
        driver.find_element(By.CSS_SELECTOR, "input.sidebar-search").send_keys(word, Keys.ENTER)
        until = time.monotonic() + 20
        summary = "return document.querySelector('#search-results .search-summary')?.textContent ?? ''"
        while "Search finished" not in driver.execute_script(summary) and time.monotonic() < until:
            time.sleep(0.1)
        return driver.execute_script("return [...document.querySelectorAll('#search-results li a')].map(a => a.href)")

    def search(self, driver):
        driver.execute_cdp_cmd("Emulation.setDeviceMetricsOverride",
                               {"width": 1300, "height": 1000, "deviceScaleFactor": 1, "mobile": False})
        for word, page in (("Hertz", "physics"), ("restitution", "deck"), ("gravity.tilt", "deck"), ("sd_simulation_clone", "api/simulation"),
                           ("add_force", "api_python")):
            found = self.found(driver, word)
            self.assertTrue(any(f"/{page}.html" in address for address in found), f"{word}: {found}")
            if page == "deck":
                self.assertTrue(any("#key-" in address for address in found), f"{word}: {found}")
            if SHOTS:
                driver.save_screenshot(os.path.join(SHOTS, f"search-{word}.png"))
        for word, page in WORDS.items():
            with self.subTest(word):
                found = self.found(driver, word)
                self.assertTrue(any(f"/{page}.html" in address for address in found[:3]), found[:3])


if __name__ == "__main__":
    unittest.main()
