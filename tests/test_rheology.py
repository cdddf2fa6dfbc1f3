"""mu(I) (tools/rheology.py): numbers from made-up series, lines and verdicts that can fail, the page
and figures from kept numbers."""
import importlib.util
import math
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

import numpy

ROOT = pathlib.Path(os.environ.get("SLIPDISK_SOURCE_DIR", pathlib.Path(__file__).resolve().parent.parent))
PROGRAM = os.environ.get("SLIPDISK_PROGRAM", str(ROOT / "build/release/slipdisk"))
sys.dont_write_bytecode = True
spec = importlib.util.spec_from_file_location("rheology", ROOT / "tools/rheology.py")
rheology = importlib.util.module_from_spec(spec)
spec.loader.exec_module(rheology)


def row(inertial, mu, phi):
    return {**dict.fromkeys(rheology.COLUMNS, 1.0), "I_set": inertial, "I": inertial, "mu": mu, "phi": phi,
            "mu_error": 1e-3,
            "phi_error": 1e-4}


def rows(mu_s=0.25, b=1.1, phi_max=0.81, c=0.3):
    return [row(x, mu_s + b * x, phi_max - c * x) for x in rheology.POINTS]


class Numbers(unittest.TestCase):
    def test_block_error(self):
        """Of white noise the standard error of the mean; of noise that lasts, more."""
        noise = numpy.random.default_rng(1).normal(size=100000)
        self.assertAlmostEqual(rheology.block_error(noise) * math.sqrt(len(noise)), 1, delta=0.5)
        lasting = numpy.convolve(noise, numpy.ones(100) / 10, "valid")      # variance 1, correlated over 100
        self.assertGreater(rheology.block_error(lasting) * math.sqrt(len(lasting)), 5)
        self.assertTrue(math.isnan(rheology.block_error([1, 2])))

    def test_evaluate(self):
        """Shear stress is positive where the rate is; kinetic parts belong to it; I has the pressure that was there."""
        n = 100
        flat = {"stress_xy": -0.8, "stress_yx": -1.0, "kinetic_xy": -0.1, "stress_yy": 3.5, "kinetic_yy": 0.5,
                "stress_xx": 4.1,
                "kinetic_xx": 0.3, "width": 5.0, "height": 2.0, "coordination": 3.0}
        series = {name: numpy.full(n, value) for name, value in flat.items()}
        series["time"], series["step"] = numpy.arange(n) * 0.5, numpy.arange(n) * 100
        found = rheology.evaluate(0.1, series, 8.0)
        self.assertAlmostEqual(found["mu"], 0.25)
        self.assertAlmostEqual(found["I"], 0.05)
        self.assertAlmostEqual(found["phi"], 0.8)
        self.assertAlmostEqual(found["xx_over_yy"], 1.1)
        self.assertAlmostEqual(found["strain"], 4.95)
        self.assertEqual(set(found), set(rheology.COLUMNS))

    def test_straight(self):
        x = numpy.linspace(0, 1, 11)
        a, b, a_error, b_error, chi = rheology.straight(x, 2 + 3 * x, numpy.full(11, 0.1))
        self.assertAlmostEqual(a, 2)
        self.assertAlmostEqual(b, 3)
        self.assertAlmostEqual(chi, 0)
        self.assertAlmostEqual(b_error, 0.1 / math.sqrt(((x - 0.5)**2).sum()))
        self.assertGreater(a_error, 0)
        bent = rheology.straight(x, x**2, numpy.full(11, 1e-3))
        self.assertGreater(bent[4], 100)
        self.assertGreater(bent[3], 10 * 1e-3)      # errors grow with what a line cannot follow

    def test_verdict(self):
        """The published lines agree with themselves, and each number alone can fail."""
        self.assertTrue(all(it[-1] for it in rheology.verdict(rheology.fits(rows()))))
        for name, wrong in (("mu_s", 0.30), ("b", 1.6), ("phi_max", 0.84), ("c", 0.5)):
            found = {it[0]: it[-1] for it in rheology.verdict(rheology.fits(rows(**{name: wrong})))}
            self.assertEqual([key for key, holds in found.items() if not holds], [name])
        self.assertIsNone(rheology.fits(rows()[-2:]))


class Page(unittest.TestCase):
    def test_round_trip(self):
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "a", "r.csv")
            rheology.write_csv(path, ["head"], rheology.COLUMNS, rows())
            for got, expected in zip(rheology.read_csv(path), rows(), strict=True):
                for name, value in expected.items():
                    self.assertAlmostEqual(got[name] / value, 1, 7)
            self.assertEqual(pathlib.Path(path).read_text().splitlines()[0], "# head")

    def test_page(self):
        text = "\n".join(rheology.page(rows(b=1.6)))
        self.assertIn("| b | 1.600 ± 0.0", text)
        self.assertIn("| 1.1 | 0.3 | **differs** |", text)
        self.assertIn("| 0.25 | 0.03 | agrees |", text)

    def test_kept(self):
        """Without results, and without the program, page and figures come out of the kept numbers as they are."""
        with tempfile.TemporaryDirectory() as folder:
            docs = pathlib.Path(folder)
            (docs / "figures").mkdir()
            shutil.copy(ROOT / "docs/rheology.md", docs)
            subprocess.run([sys.executable, "-B", str(ROOT / "tools/rheology.py"), "--draw", "--keep", folder, "-o",
                            str(docs / "none"),
                            "--program", "/nonexistent"], check=True, stdout=subprocess.DEVNULL)
            self.assertEqual((docs / "rheology.md").read_text(), (ROOT / "docs/rheology.md").read_text())
            for name in ("rheology.png", "rheology-series.png"):
                self.assertGreater((docs / "figures" / name).stat().st_size, 10000)


class Deck(unittest.TestCase):
    def test_small(self):
        """A hundred disks that flow fast: pressure held, friction and density between wide bounds."""
        with tempfile.TemporaryDirectory() as folder:
            keys = {"packings[0].count": 128, "container.width": 15.6, "container.height": 15.6, "constants.strain": 2}
            words = [PROGRAM, "run", str(ROOT / "inputs/shear/rheology.cfg"), "-o", os.path.join(folder, "small.h5"),
                     "--quiet", "-D",
                     "constants.I=0.2"] + [word for key, value in keys.items() for word in ("-D", f"{key}={value}")]
            self.assertIn(subprocess.run(words, check=False).returncode, (0, 5))
            found = rheology.evaluate(*rheology.read(os.path.join(folder, "small.h5")))
        self.assertAlmostEqual(found["I_set"], 0.2)
        self.assertAlmostEqual(found["strain"], 2, delta=0.02)
        self.assertAlmostEqual(found["pressure"], 1, delta=0.1)
        self.assertTrue(0.3 < found["mu"] < 0.6, found)
        self.assertTrue(0.65 < found["phi"] < 0.82, found)


if __name__ == "__main__":
    sys.exit(unittest.main(verbosity=1))
