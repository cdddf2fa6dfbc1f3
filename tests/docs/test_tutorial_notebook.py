"""docs/tutorial_python.ipynb: kept without outputs, executed by nbconvert, every cell; its inline pages in headless Chromium.

    SLIPDISK_SCREENSHOTS=FOLDER tests/docs/test_tutorial_notebook.py    keeps a picture of the executed notebook
"""
import html
import json
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import unittest

import chromium
import view_page

ROOT = pathlib.Path(os.environ.get("SLIPDISK_SOURCE_DIR", pathlib.Path(__file__).resolve().parents[2]))
BUILD = pathlib.Path(os.environ.get("SLIPDISK_BUILD_DIR", ROOT / "build/release"))
NOTEBOOK = ROOT / "docs/tutorial_python.ipynb"
SHOTS = os.environ.get("SLIPDISK_SCREENSHOTS")


class Tutorial(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        """Executes the notebook in a folder beside which the inputs lie, and makes a page of it."""
        temporary = tempfile.TemporaryDirectory(prefix="slipdisk-notebook-", ignore_cleanup_errors=True)
        cls.addClassCleanup(temporary.cleanup)
        cls.folder = pathlib.Path(temporary.name)
        (cls.folder / "docs").mkdir()
        (cls.folder / "inputs").symlink_to(ROOT / "inputs")
        path = cls.folder / "docs" / NOTEBOOK.name
        path.write_text(NOTEBOOK.read_text(encoding="utf-8"), encoding="utf-8")
        environment = {**os.environ, "HOME": str(cls.folder), "TMPDIR": str(cls.folder), "JUPYTER_PLATFORM_DIRS": "1", "OMP_NUM_THREADS": "1",
                       "PYTHONPATH": str(ROOT / "tools/python"), "SLIPDISK_LIBRARY": str(BUILD / "libslipdisk.so"),
                       "SLIPDISK_PROGRAM": os.environ.get("SLIPDISK_PROGRAM", str(BUILD / "slipdisk")), "PYDEVD_DISABLE_FILE_VALIDATION": "1"}
        for words in (("--to", "notebook", "--execute", "--inplace", "--ExecutePreprocessor.timeout=600"), ("--to", "html")):
            done = subprocess.run([sys.executable, "-m", "nbconvert", *words, path], env=environment, capture_output=True, text=True, check=False)
            if done.returncode:
                raise RuntimeError(done.stdout + done.stderr)
        cls.cells = [cell for cell in json.loads(path.read_text(encoding="utf-8"))["cells"] if cell["cell_type"] == "code"]
        cls.html = path.with_suffix(".html")

    def test_kept_without_outputs(self):
        self.assertLess(NOTEBOOK.stat().st_size, 20_000)
        cells = json.loads(NOTEBOOK.read_text(encoding="utf-8"))["cells"]
        self.assertEqual([cell for cell in cells if cell.get("outputs") or cell.get("execution_count")], [])
        for link in re.findall(r"\]\(([^()#\s]+)", "".join("".join(cell["source"]) for cell in cells if cell["cell_type"] == "markdown")):
            self.assertTrue((ROOT / "docs" / link).exists(), link)

    def outputs(self, source):
        """What the one cell with this text shows: {kind: data}, and what it prints."""
        cell, = [cell for cell in self.cells if source in "".join(cell["source"])]
        found = {"text": "".join("".join(out["text"]) for out in cell["outputs"] if out.get("name") == "stdout")}
        for out in cell["outputs"]:
            found.update({kind: "".join(data) for kind, data in out.get("data", {}).items()})
        return found

    def test_outputs(self):
        """All cells are executed, in order; what they show is as the text says."""
        self.assertEqual([cell["execution_count"] for cell in self.cells], list(range(1, len(self.cells) + 1)))
        self.assertEqual([out for cell in self.cells for out in cell["outputs"] if out["output_type"] == "error"], [])
        self.assertIn("0 of at most 5100000", self.outputs('"phases.measure.time": 50')["text/html"])
        self.assertRegex(self.outputs("omega = ratchet.rotation[0]")["text"], r"^Omega = -3\.\d+e-04 \+- .*reliable: True\n$")
        self.assertEqual(self.outputs("deck.gravity.tilt / np.pi")["text/plain"], "(0.04, 0.1, 62.83185307179586)")
        self.assertIn("contacts per disk", self.outputs("box.advance()")["text"])
        for cell in ("ratchet.disks.pandas", "result.series.pandas", "result.contacts.pandas", "sweep.pandas"):
            self.assertIn("<table", self.outputs(cell)["text/html"])
        self.assertGreater(len(self.outputs("slipdisk.plot.page")["image/png"]), 10_000)

    def test_pages(self):
        """The pages of `view` are those of the state and the result that they show."""
        for source, disks, frames, step in (("ratchet.view", 3, 1, 0), ("box.view", 400, 1, 40_000), ("result.view", 3, 102, 0)):
            shown = self.outputs(source)["text/html"]
            path = self.folder / "page.html"
            path.write_text(html.unescape(re.search(r'srcdoc="([^"]*)"', shown)[1]), encoding="utf-8")
            page = view_page.Page(path)
            self.assertEqual((len(page.frames), len(page.frames[0]["x"]), page.frames[0].head["step"]), (frames, disks, step), source)

    def test_in_a_browser(self):
        """The three pages draw their disks and load nothing."""
        driver = chromium.browser()
        self.addCleanup(driver.quit)
        driver.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", {"width": 1100, "height": 6500, "deviceScaleFactor": 1, "mobile": False})
        driver.get(self.html.as_uri())
        frames = driver.find_elements("css selector", "iframe")
        self.assertEqual(len(frames), 3)
        for frame, disks in zip(frames, (3, 400, 3)):
            driver.switch_to.frame(frame)
            drawn = driver.execute_async_script(
                "const done = arguments[0], begun = Date.now(); const look = () => { if (window.slipdisk && window.slipdisk.state.drawn > 0) done(true);"
                " else if (Date.now() - begun > 25000) done(false); else setTimeout(look, 100); }; look()")
            self.assertTrue(drawn, f"the page of {disks} disks draws nothing")
            driver.switch_to.default_content()
        asked = re.findall(r'"url":"(https?:[^"]*)"', "\n".join(entry["message"] for entry in driver.get_log("performance")))
        self.assertEqual([url for url in asked if "slipdisk" in url], [])
        if SHOTS:
            driver.save_screenshot(os.path.join(SHOTS, "tutorial_python.png"))


if __name__ == "__main__":
    unittest.main(verbosity=1)
