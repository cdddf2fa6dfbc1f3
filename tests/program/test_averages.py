"""measure.averages: means with error bars of columns of the series, of sums and of ratios; against the rows that are stored, in
sweeps, and what is said of mistakes and of records that are too short."""
import csv
import json
import os
import sys
import unittest

import h5py
import numpy as np

import results_common
from results_common import ROOT, run

sys.path.insert(0, str(ROOT / "tools/python"))
LIBRARY = os.path.join(os.environ.get("SLIPDISK_BUILD_DIR", ROOT / "build/release"), "libslipdisk.so")
os.environ["SLIPDISK_LIBRARY"] = LIBRARY
import slipdisk  # noqa: E402

# Sheared at constant area, in a box of 20 disks that a phase before compresses.
SHEAR = """
integrator = "verlet"; dt = 2e-3; constants = { N = 20; };
materials = ( { name = "disk"; k_n = 1e3; k_t = 5e2; mu = 0.5; gamma_n = 10; } );
container = { type = "periodic"; width = 5.3; height = 5.3; };
packings = ( { type = "random"; count = 20; density = "4 / pi"; sizes = "uniform"; lower = 0.4; upper = 0.6; } );
phases = ( { name = "squeeze"; time = 20; compress = { fraction = 0.79; rate = 0.02; }; },
           { name = "first"; steps = %d; cell = { rate_xy = 0.3; }; series = %d; measure = true; },
           { name = "between"; steps = 500; cell = { rate_xy = 0.3; }; },
           { name = "second"; steps = %d; cell = { rate_xy = 0.3; }; series = %d; } );
measure = { rotation = (); averages = { mu = "-stress_xy/stress_yy"; p = "(stress_xx + stress_yy)/2"; Z = "2 * contacts / N";
  power = "rate(work)"; loss = "rate(viscous + friction)/rate(work)"; anisotropy = "(stress_xx - stress_yy)/(stress_xx + stress_yy)";
  share = "1 - sliding_contacts/N"; phi = "packing_fraction"; }; };
"""
OF = {"mu": lambda c: (-c["stress_xy"], c["stress_yy"]), "p": lambda c: ((c["stress_xx"] + c["stress_yy"]) / 2, 1),
      "Z": lambda c: (c["contacts"] / 10, 1), "power": lambda c: (c["work'"], 1),
      "loss": lambda c: (c["viscous'"] + c["friction'"], c["work'"]),
      "anisotropy": lambda c: (c["stress_xx"] - c["stress_yy"], c["stress_xx"] + c["stress_yy"]),
      "share": lambda c: (1 - c["sliding_contacts"] / 20, 1), "phi": lambda c: (c["packing_fraction"], 1)}
UNITS = {"mu": "1", "p": "force/length", "Z": "1", "power": "energy/time", "loss": "1", "anisotropy": "1", "share": "1", "phi": "1"}

# A box with a bed of disks that a servo holds; rows of which nothing is there are not finite.
BED = """
integrator = "verlet"; dt = 1e-3; gravity = { g = 1; };
materials = ( { name = "m"; k_n = 1e3; k_t = 5e2; gamma_n = 2; mu = 0.4; } );
container = { type = "box"; width = 4; height = 6; };
packings = ( { type = "square"; count = 12; x = (-2, 2); y = (0, 6); radius = 0.4; density = 1; group = "grains"; } );
steps = 3000;
measure = { contacts = (3); rotation = (1, 2); averages = { %s }; };
"""


class Averages(results_common.Folder):
    def make(self, text, *words, status=0):
        deck = self.folder / "deck.cfg"
        deck.write_text(text)
        found, _, err = run("run", deck, "-o", self.result, "--quiet", "--force", *words)
        self.assertEqual(found, status, err)
        return slipdisk.Result(self.result), err

    def rows(self, result):
        """The columns in measured phases, with the changes per time of those that grow."""
        s, names, ends = result.series, [], np.cumsum(result.phases["steps"])
        step, columns = s["step"], {}
        keep = ((step > ends[0]) & (step <= ends[1])) | ((step > ends[2]) & (step <= ends[3]))
        for name in "stress_xx", "stress_xy", "stress_yy", "contacts", "sliding_contacts", "packing_fraction", "work", "viscous", "friction":
            columns[name] = s[name][keep].astype(float)
            columns[name + "'"] = (np.diff(s[name].astype(float), prepend=np.nan) / np.diff(s["time"], prepend=np.nan))[keep]
        self.assertTrue(all(np.isfinite(c).all() for c in columns.values()), names)
        return columns

    def test_against_the_rows(self):
        """Mean of a ratio is the ratio of means; its error that of the linearised record, which sd_mean_of gives alone."""
        for steps, every in ((10000, 20), (9000, 2)):  # the second fills its bins, which are then four rows long
            result, _ = self.make(SHEAR % (steps, every, steps, every))
            columns, n = self.rows(result), 2 * steps // every
            each = 1 if n < 4096 else 4
            self.assertEqual(list(result.averages), list(OF))
            for name, a in result.averages.items():
                over, under = (np.resize(x, n) if np.ndim(x) == 0 else x for x in OF[name](columns))
                self.assertEqual((a.rows, a.missing, len(over), a.unit), (n, 0, n, UNITS[name]))
                self.assertAlmostEqual(a.measured, n * every * 2e-3)
                over, under = (x.reshape(-1, each).mean(1) for x in (over, under))
                cut = round(a.transient / (each * every * 2e-3))
                ratio = over[cut:].mean() / under[cut:].mean()
                self.assertAlmostEqual(a.mean, ratio, delta=1e-9 * abs(ratio), msg=name)
                if not os.path.exists(LIBRARY):  # sanitizer builds have none; the release build's test compares the errors
                    continue
                alone = slipdisk.mean(ratio + (over - ratio * under) / under[cut:].mean())
                pair = slipdisk.mean(over, over=under)
                self.assertAlmostEqual(pair.mean, ratio, delta=1e-9 * abs(ratio), msg=name)
                self.assertAlmostEqual(pair.error, alone.error, delta=1e-6 * alone.error + 1e-12, msg=name)
                self.assertEqual((pair.discarded, pair.converged), (cut, alone.converged), name)
                self.assertEqual(alone.discarded, cut, name)
                self.assertAlmostEqual(a.error, alone.error, delta=1e-6 * alone.error + 1e-12, msg=name)
                self.assertEqual(a.converged, alone.converged, name)
                self.assertAlmostEqual(a.correlation, alone.correlation * each * every * 2e-3, delta=1e-6 * a.correlation, msg=name)
            self.assertLess(result.averages.mu.error, 0.1)
            self.assertGreater(result.averages.mu.error, 0.001)

    def test_elements(self):
        result, _ = self.make(BED % 'a = "wall_force_y[floor]"; b = "wall_normal[right] + wall_normal[ left ]"; c = "disk_normal"; '
                                    'd = "angular_velocity[2]"; e = "group_contacts[grains]/wall_contacts[floor]"; f = "height"')
        s = result.series
        walls = {name: k for k, name in enumerate(h5py.File(self.result)["observables/walls"][()].decode().split("\n"))}
        for name, column in (("d", s["angular_velocity"][:, 1]), ("a", s["wall_force_y"][:, walls["floor"]]), ("f", s["height"]), ("c", s["disk_normal"][:, 0]),
                             ("b", s["wall_normal"][:, walls["right"]] + s["wall_normal"][:, walls["left"]])):
            a = result.averages[name]
            cut = 1 + round(a.transient / 3e-3)
            self.assertAlmostEqual(a.mean, column[cut:].mean(), delta=1e-12 * abs(a.mean) + 1e-15, msg=name)
        self.assertEqual(result.averages.e.of, "group_contacts[grains]/wall_contacts[floor]")

    def test_words(self):
        """Too few rows, a denominator of 0, no rows: text, JSON and Python say so, and exit statuses."""
        result, err = self.make(BED % 'a = "contacts"; b = "contacts/(0 * height)"', "-D", "output={series=300;}", status=5)
        self.assertIn("the average b has no value: the mean of the denominator of contacts/(0 * height) is 0", err)
        self.assertIn("too few rows for an error bar", repr(result.averages.a))
        self.assertEqual(repr(result.averages.b), "no mean: the denominator is 0")
        text, _ = self.run_ok("info", self.result)
        self.assertIn("= contacts; too few rows for an error bar", text)
        self.assertIn("= contacts/(0 * height); no mean: IN DOUBT tells why", text)
        found = {a["name"]: a for a in json.loads(self.run_ok("info", self.result, "--json")[0])["averages"]}
        self.assertEqual((found["a"]["error"], found["a"]["rows"], found["b"]["mean"], found["a"]["unit"]), (None, 10, None, "1"))
        result, _ = self.make(BED % 'a = "contacts"')
        self.assertIn("error not reliable" if not result.averages.a.converged else "+-", repr(result.averages.a))

    def test_prints(self):
        a = slipdisk.result.Average(mean=0.29004, error=0.00461, rows=9, missing=0, converged=True)
        self.assertEqual(repr(a), "0.2900 +- 0.0046")
        for values, text in (({"mean": 12345.6, "error": 123.4}, "12345.6 +- 1.2e+02"), ({"error": 0.0, "mean": 0.79}, "0.79 +- 0"),
                             ({"error": 0.5, "converged": False}, "0.29 +- 0.50 (error not reliable)"), ({"rows": 0}, "no measured rows yet"),
                             ({"mean": np.nan, "missing": 3}, "no mean: 3 of 9 rows are not finite")):
            self.assertEqual(repr(slipdisk.result.Average({**a, **values})), text)

    def test_sweep(self):
        """Columns of tables with error and scatter; the picture takes the average by its name."""
        deck, folder = self.folder / "deck.cfg", self.folder / "s.sweep"
        deck.write_text(SHEAR % (2000, 20, 2000, 20) + 'sweep = { parameters = ( { path = "materials[0].mu"; name = "mu"; '
                        "values = (0.1, 0.5); } ); replicas = 3; };\n")
        self.run_ok("sweep", deck, "-o", folder, "-j", 2, "--quiet")
        with open(folder / "means.csv", newline="") as file:
            means = list(csv.DictReader(file))
        sweep = slipdisk.Sweep(folder)
        for k, row in enumerate(means):
            own = [sweep[n].averages.mu for n in range(3 * k, 3 * k + 3)]
            self.assertAlmostEqual(float(row["mu.mean"]), np.mean([a.mean for a in own]))
            self.assertAlmostEqual(float(row["mu.mean_error"]), np.sqrt(np.sum([a.error ** 2 for a in own])) / 3)
            self.assertAlmostEqual(float(row["mu.mean_scatter"]), np.std([a.mean for a in own], ddof=1) / np.sqrt(3))
        self.assertEqual((sweep.unit("p.mean"), sweep.unit("p.mean_error"), sweep.unit("mu.mean")), ("force/length", "force/length", "1"))
        from slipdisk.plot_sweep import Curves
        self.assertEqual([Curves(sweep, quantity=q).y for q in (None, "p", "p.mean", "Z")], ["mu.mean", "p.mean", "p.mean", "Z.mean"])
        self.assertTrue((Curves(sweep, quantity="p").errors > 0).all())
        self.assertIn("mu.mean", self.run_ok("info", "--names")[0] + "".join(means[0]))

    def test_mistakes(self):
        deck = self.folder / "deck.cfg"
        ratio = "expected a sum of columns with factors, or a ratio of two"
        for text, said in (
                ('"presure"', 'is called "presure"; did you mean "pressure"?'), ('"contacts + none"', 'is called "none"'),
                ('"contacts +"', "the expression is not complete"), ('"contacts 2"', "an operator is missing"), ("5", "expected a text"),
                ('"2 * 3"', "it names no column"), ('""', "expected a number"), ('"rate(work"', "a ) is missing"),
                ('"rate(2)"', "a constant in rate( )"), ('"rate(work + 1)"', "a constant in rate( )"), ('"rate"', "expected rate(SUM)"),
                ('"rate(rate(work))"', "a rate of a rate"), ('"rate(height * width)"', ratio), ('"2 - rate(work - viscous)/2"', None),
                ('"contacts * height"', ratio), ('"contacts / height / width"', ratio), ('"contacts / height * 2"', ratio),
                ('"height + contacts / width"', ratio), ('"abs(contacts)"', ratio), ('"sqrt(contacts)"', ratio),
                ('"contacts ^ 2"', ratio), ('"max(width, height)"', ratio), ('"1/(width + 1)"', None), ('"-1e-3*width/-height"', None),
                ('"wall_force_x"', "wall_force_x has 4 elements; expected the name of one, as wall_force_x["),
                ('"wall_force_x[flor]"', 'no element "flor"; did you mean "floor"?'), ('"wall_force_x[floor"', "a ] is missing"),
                ('"height[0]"', "height has no elements"), ('"pressure"', "the series of this run does not have pressure: "),
                ('"disk_normal[4]"', 'no element "4"'), ('"nonaffine_x"', "does not have nonaffine_x"),
                ('"' + "+".join(f"wall_force_{x}[{w}]" for x in "xy" for w in ("floor", "left", "right", "lid")) + ' + width"', "at most 8 columns"),
        ):
            deck.write_text((BED % f"a = {text};").replace('"box"; width', '"box"; open = false; width').replace(
                "= (1, 2)", "= ()"))
            status, _, err = run("check", deck)
            self.assertEqual(status, 2 if said else 0, (text, err))
            for word in (said, "deck.cfg:7: measure.averages.a") if said else ():
                self.assertIn(word, err, text)
        for change, said in ((("steps = 3000;", "steps = 3000; constants = { width = 2; };"), "is a constant of the deck and a column"),
                             (("steps = 3000;", "phases = ( { steps = 100; measure = true; series = 2; }, { steps = 100; series = 5; } );"),
                              "phases that measure have different `series`"),
                             (("steps = 3000;", "phases = ( { steps = 100; measure = false; } );"), "no phase measures"),
                             (("steps = 3000;", "steps = 3000; output = { series = 0; };"), "series = 0; expected rows"),
                             (('a = "width"', 'floor = "width"'), 'a body is called "floor"')):
            deck.write_text((BED % 'a = "width";').replace(*change))
            status, _, err = run("check", deck)
            self.assertEqual((status, said in err), (2, True), (change, err))


if __name__ == "__main__":
    unittest.main()
