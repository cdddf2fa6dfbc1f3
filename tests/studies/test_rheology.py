"""mu(I) (tools/studies/rheology.sh): numbers from made-up series, lines and verdicts that can fail, the page
and figures from kept numbers."""
import math
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

import numpy

ROOT = pathlib.Path(os.environ.get("SLIPDISK_SOURCE_DIR", pathlib.Path(__file__).resolve().parents[2]))
PROGRAM = os.environ.get("SLIPDISK_PROGRAM", str(ROOT / "build/release/slipdisk"))
STUDIES = str(ROOT / "tools/studies")
sys.path.insert(0, STUDIES)
sys.dont_write_bytecode = True

from rheology import __main__ as rheology  # noqa: E402


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
        self.assertEqual({it[-1] for it in rheology.verdict(rheology.fits(rows()))}, {"agrees"})
        for name, wrong in (("mu_s", 0.265), ("b", 1.27), ("phi_max", 0.817), ("c", 0.345)):  # 6 to 15 % off
            found = {it[0]: it[-1] for it in rheology.verdict(rheology.fits(rows(**{name: wrong})))}
            self.assertEqual([key for key, word in found.items() if word != "agrees"], [name])
            self.assertEqual(found[name], "**differs**")
        near = {it[0]: it[-1] for it in rheology.verdict(rheology.fits(rows(mu_s=0.2601)))}
        self.assertEqual(near["mu_s"], "undecided")
        self.assertIsNone(rheology.fits(rows()[-2:]))


class Cases(unittest.TestCase):
    def test_restitution(self):
        """A damped contact, integrated until its force ends: the closed forms, and their inverse."""
        for damping in (0.03, 0.26, 0.59, 0.9):
            for clipped in (True, False):
                x, v, dt = 0.0, 1.0, 1e-4                   # overlap and its rate; stiffness and mass 1
                for _ in range(200000):
                    force = x + 2 * damping * v
                    if (force <= 0 if clipped else x < 0) and v < 0:
                        break
                    v -= dt * force
                    x += dt * v
                found = rheology.cases.restitution(damping, clipped)
                self.assertAlmostEqual(found, -v, delta=2e-3)
                self.assertAlmostEqual(rheology.cases.damping_of(found, clipped), damping, places=9)
        self.assertAlmostEqual(rheology.cases.restitution(0.59, True), 0.25, delta=0.01)     # as the page says
        self.assertAlmostEqual(rheology.cases.restitution(0.59, False), 0.1, delta=0.01)

    def test_settings(self):
        """Every case but the first differs from the deck in what it says, and in what follows from that; names are apart."""
        base = rheology.cases.settings(rheology.cases.CASES[0], 1)
        self.assertAlmostEqual(base["dt"], 3.3e-3)
        self.assertAlmostEqual(base["materials[0].gamma_n"], 1.18 * math.sqrt(500))
        self.assertEqual((base["packings[0].lower"], base["packings[0].upper"]), (0.4, 0.6))
        self.assertEqual(len({rheology.cases.name_of(case) for case in rheology.cases.CASES}), len(rheology.cases.CASES))
        for case in rheology.cases.CASES[1:]:
            self.assertNotEqual(rheology.cases.settings(case, 1), base, case)
            self.assertLessEqual(set(case.keys), set(rheology.cases.BASE))
        paths = [path for path, _ in rheology.cases.runs("f")]
        self.assertEqual(len(set(paths)), sum(case.seeds for case in rheology.cases.CASES))

    def test_row(self):
        """Means over runs in every way, and errors from blocks: made-up series."""
        n, rng = 4000, numpy.random.default_rng(2)
        found = []
        for _ in range(4):
            noise = rng.normal(size=n)
            series = {"stress_xy": -0.4 - 0.1 * noise, "stress_yx": -0.4 - 0.1 * noise, "kinetic_xy": numpy.full(n, 0.02),
                      "stress_yy": 1 + 0.1 * rng.normal(size=n), "kinetic_yy": numpy.zeros(n),
                      "stress_xx": numpy.full(n, 3.0), "kinetic_xx": numpy.zeros(n), "width": numpy.full(n, 2.0),
                      "height": 3 + 0.1 * rng.normal(size=n)}
            found.append(({"strain": 8, "I": 0.1, "phi": 0.8, "xx_over_yy": 3, "contacts": 2}, series))
        row = rheology.cases.row_of(rheology.cases.CASES[0], found)
        self.assertAlmostEqual(row["mu_means"], 0.38, delta=2e-3)
        self.assertAlmostEqual(row["mu"], 0.38 * 1.0103, delta=2e-3)         # mean of 1/x is larger than 1/mean
        self.assertAlmostEqual(row["mu_pressure"], 0.19, delta=2e-3)
        self.assertAlmostEqual(row["mu_contacts"], 0.4 * 1.0103, delta=2e-3)
        self.assertAlmostEqual(row["mu_error"], 0.107 / math.sqrt(4 * n), delta=4e-4)
        self.assertEqual((row["seeds"], row["strain"], row["phi"]), (4, 32, 0.8))
        self.assertEqual(set(row), set(rheology.cases.COLUMNS))


class Series(unittest.TestCase):
    def test_keys(self):
        """The reference's stiffness and restitution; a strain of 5 before and after."""
        stiff = rheology.series.keys("reference", 0.1)
        self.assertEqual((stiff["constants.kappa"], stiff["materials[0].limit_damping"]), (1e4, "false"))
        slow = rheology.series.keys("slow", 1e-4)
        self.assertEqual((slow["constants.wait"], slow["constants.strain"]), (5, 5))
        paths = [path for path, _ in rheology.series.runs("f")]
        self.assertEqual(len(set(paths)), len(paths))

    def test_slow(self):
        """The longer strain agrees, differs, or is undecided."""
        for off, word in ((0.001, "friction agrees"), (0.01, "friction **differs**"), (0.0036, "friction is undecided")):
            late = {**row(1e-4, 0.25 + off, 0.81), "series": "slow"}
            text = "\n".join(rheology.slow_lines([row(1e-4, 0.25, 0.81)], [late]))
            self.assertIn(word, text)


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
        self.assertIn("| 1.1 | 0.11 | **differs** |", text)
        self.assertIn("| 0.25 | 0.01 | agrees |", text)

    def test_kept(self):
        """Without results, and without the program, page and figures come out of the kept numbers as they are."""
        with tempfile.TemporaryDirectory() as folder:
            docs = pathlib.Path(folder)
            (docs / "figures").mkdir()
            shutil.copy(ROOT / "docs/studies/rheology.md", docs)
            for more in ([], ["--cases"], ["--series"]):
                subprocess.run([sys.executable, "-B", "-m", "rheology", "--draw", "--keep", folder, "-o", str(docs / "none"),
                                "--program", "/nonexistent", *more], check=True, stdout=subprocess.DEVNULL,
                               env={**os.environ, "PYTHONPATH": STUDIES})
            self.assertEqual((docs / "rheology.md").read_text(), (ROOT / "docs/studies/rheology.md").read_text())
            for name in ("rheology.png", "rheology-series.png", "rheology-cases.png"):
                self.assertGreater((docs / "figures" / name).stat().st_size, 10000)


class Deck(unittest.TestCase):
    def test_small(self):
        """A hundred disks that flow fast: pressure held, friction and density between wide bounds."""
        with tempfile.TemporaryDirectory() as folder:
            keys = {"packings[0].count": 128, "container.width": 15.6, "container.height": 15.6, "constants.strain": 8}
            words = [PROGRAM, "run", str(ROOT / "inputs/shear/rheology.cfg"), "-o", os.path.join(folder, "small.h5"),
                     "--quiet", "-D",
                     "constants.I=0.2"] + [word for key, value in keys.items() for word in ("-D", f"{key}={value}")]
            self.assertIn(subprocess.run(words, check=False).returncode, (0, 5))
            found = rheology.evaluate(*rheology.read(os.path.join(folder, "small.h5")))
        self.assertAlmostEqual(found["I_set"], 0.2)
        self.assertAlmostEqual(found["strain"], 8, delta=0.02)
        self.assertAlmostEqual(found["pressure"], 1, delta=0.1)
        self.assertTrue(0.3 < found["mu"] < 0.6, found)
        self.assertTrue(0.65 < found["phi"] < 0.82, found)


if __name__ == "__main__":
    sys.exit(unittest.main(verbosity=1))
