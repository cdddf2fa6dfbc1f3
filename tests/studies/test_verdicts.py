"""The rules of the report's verdicts, and what judges made-up tables by them."""
import os
import pathlib
import sys
import tempfile
import unittest

import numpy

ROOT = pathlib.Path(os.environ.get("SLIPDISK_SOURCE_DIR", pathlib.Path(__file__).resolve().parents[2]))
sys.path.insert(0, str(ROOT / "tools/studies"))
sys.dont_write_bytecode = True

from ratchet import __main__ as report  # noqa: E402
from ratchet import catalogue, diffusion, durations, fields, regimes, starts, verdict, verdicts  # noqa: E402
from ratchet.data import Table  # noqa: E402
from ratchet.runs import Results  # noqa: E402
from ratchet.style import plt  # noqa: E402

PI = numpy.pi


class Verdicts(unittest.TestCase):
    def test_chi_square(self):
        for chi2, degrees, chance in ((3.841, 1, 0.05), (18.307, 10, 0.05), (2.0, 10, 0.99634), (60.0, 10, 3.6244e-9)):
            self.assertAlmostEqual(verdict.survival(chi2, degrees) / chance, 1, delta=0.01)

    def test_rules(self):
        one = numpy.ones(6)
        self.assertEqual(verdict.zero("", 0.5 * one, one).verdict, verdict.YES)
        self.assertEqual(verdict.zero("", 9 * one, one).verdict, verdict.NO)
        self.assertEqual(verdict.zero("", [], []).verdict, verdict.OPEN)
        self.assertEqual(verdict.signed("", -9 * one, one, -1).verdict, verdict.YES)
        self.assertEqual(verdict.signed("", 9 * one, one, -1).verdict, verdict.NO)
        self.assertEqual(verdict.signed("", -one, one, -1).verdict, verdict.OPEN)
        self.assertEqual(verdict.within("", 1.005, 1, 0.01).verdict, verdict.YES)
        self.assertEqual(verdict.within("", 1.05, 1, 0.01).verdict, verdict.NO)
        self.assertEqual(verdict.within("", 1.005, 1, 0.01, error=0.02).verdict, verdict.OPEN)

    def test_zero_tells_error_bars_that_are_too_large(self):
        values, errors = 0.02 * numpy.ones(40), numpy.ones(40)
        claim = verdict.zero("", values, errors)
        self.assertEqual(claim.verdict, verdict.OPEN)
        self.assertIn("too large", claim.numbers)
        self.assertAlmostEqual(verdict.chance(137.7, 220) / 6.0e-6, 1, delta=0.05)
        self.assertEqual([verdict.judged(chi2, 220, True) for chi2 in (137.7, 220, 340)],
                         [verdict.NO, verdict.YES, verdict.NO])
        self.assertEqual([verdict.judged(chi2, 220) for chi2 in (137.7, 220, 340)],
                         [verdict.OPEN, verdict.YES, verdict.NO])

    def test_a_sign_needs_every_point(self):
        """A point that is not significant leaves it open; the other sign has to exceed what chance gives."""
        values, errors = numpy.full(9, -9.0), numpy.ones(9)
        values[4] = 2.8
        claim = verdict.signed("", values, errors, -1, names=[f"point {k}" for k in range(9)])
        self.assertEqual(claim.verdict, verdict.OPEN)
        self.assertIn("undecided: point 4 (+2.8 errors)", claim.numbers)
        values[4] = 3.3  # one of nine: not yet a contradiction
        self.assertEqual(verdict.signed("", values, errors, -1).verdict, verdict.OPEN)
        values[4] = 4.0
        self.assertEqual(verdict.signed("", values, errors, -1).verdict, verdict.NO)
        values[4] = -3.1
        self.assertEqual(verdict.signed("", values, errors, -1).verdict, verdict.YES)
        self.assertEqual(verdict.signed("", [], [], -1).verdict, verdict.OPEN)
        self.assertAlmostEqual(verdict.beyond(1), 3.0, places=3)
        self.assertAlmostEqual(verdict.beyond(70), 4.116, places=2)

    def test_growth(self):
        errors = numpy.ones(4)
        for steps, wanted in (([9, 9, 9, 4], verdict.YES), ([9, 9, 9, 1], verdict.OPEN), ([9, 9, 9, -2], verdict.OPEN),
                              ([9, 9, 9, -5], verdict.NO)):
            self.assertEqual(verdict.grows("", steps, errors).verdict, wanted)
        self.assertEqual(verdict.grows("", [], []).verdict, verdict.OPEN)

    def test_approach(self):
        """The deviation has to fall all the way, and to end where it counts as excellent."""
        x, small = [1, 2, 3, 4], numpy.full(4, 1e-4)
        for off, error, wanted in (([0.5, 0.1, 0.03, 0.01], small, verdict.YES),
                                   ([0.5, 0.1, 0.015, 0.018], small, verdict.YES),    # within the tolerance it may rise
                                   ([0.5, 0.1, 0.015, 0.021], small, verdict.NO),     # and out of it not
                                   ([0.5, 0.1, 0.2, 0.01], small, verdict.NO),
                                   ([0.5, 0.1, 0.08, 0.05], small, verdict.NO),       # it ends elsewhere
                                   ([-0.5, -0.1, 0.03, 0.01], small, verdict.YES),
                                   ([0.5, 0.1, 0.03, 0.01], numpy.full(4, 0.01), verdict.OPEN),
                                   ([0.5, 0.1, 0.11, 0.01], numpy.full(4, 3e-3), verdict.OPEN)):
            self.assertEqual(verdict.approaches("", x, off, error).verdict, wanted, off)
        self.assertEqual(verdict.approaches("", [], [], []).verdict, verdict.OPEN)

    def test_excellent_is_one_number(self):
        for off, wanted in ((0.015, verdict.YES), (0.021, verdict.NO), (0.0199, verdict.OPEN)):
            self.assertEqual(verdict.excellent("", off, 1e-4, "").verdict, wanted)
        self.assertEqual(verdict.TOLERANCES["excellent"], 0.02)
        self.assertIn("| 2 % |", (ROOT / "docs/validation.md").read_text())

    def test_none(self):
        self.assertEqual(verdict.none("", 1e-4, 1).verdict, verdict.YES)
        self.assertEqual(verdict.none("", -1e-2, 1).verdict, verdict.NO)

    def test_kinds(self):
        """Every claim says what it is: the paper's have a place, what holds by construction is apart."""
        self.assertEqual(verdict.missing("", "section 3").kind, verdict.PAPER)
        self.assertEqual(verdict.missing("").kind, verdict.CHECK)
        slugs = [row[0] for row in catalogue.STATEMENTS]
        self.assertEqual(len(slugs), len(set(slugs)))
        texts = [row[3] for row in catalogue.STATEMENTS]
        self.assertEqual(len(texts), len(set(texts)), "a sentence twice")
        self.assertEqual({row[1] for row in catalogue.STATEMENTS}, {verdict.PAPER, verdict.TRIVIAL})
        found = verdict.decide(condition=True, numbers="x", **catalogue.paper("frozen"))
        every = catalogue.complete([found])
        self.assertEqual([claim.slug for claim in every], slugs)
        self.assertEqual([claim.verdict for claim in every].count(verdict.YES), 1)
        self.assertLessEqual({claim.rule for claim in every if claim.rule}, set(verdict.RULES))
        self.assertEqual(set(verdict.TOLERANCES), set(verdict.MEANING))

    def test_all_claims_have_slugs_and_rules(self):
        """Each claim of the page is the list's or an own check, under a name of its own."""
        with tempfile.TemporaryDirectory() as folder:
            results = Results(folder, "full", "/bin/false", dry=True, strict=True)
            claims = [claim for module in report.MODULES for section in module.sections(results)
                      for claim in section.claims]
            claims += report.statements.sections(results, claims)[0].claims
            verdicts.write(folder, claims, "a test")
            text = pathlib.Path(folder, "verdicts.md").read_text()
        plt.close("all")
        slugs = [claim.slug for claim in claims]
        self.assertNotIn("", slugs)
        self.assertEqual(len(slugs), len(set(slugs)), sorted(s for s in slugs if slugs.count(s) > 1))
        listed = {row[0] for row in catalogue.STATEMENTS}
        self.assertEqual({claim.slug for claim in claims if claim.kind != verdict.CHECK}, listed)
        before = {slug for slug, row in verdicts.old_verdicts().items() if row["kind"] != verdict.CHECK}
        self.assertEqual(before - set(slugs), {"async-sequence-strong"})
        self.assertIn("No longer judged by themselves", text)
        for slug in slugs:
            self.assertIn(f"{slug}", text)

    def test_numbers(self):
        self.assertEqual(verdict.number(-1.2345e-4, 2e-6), "(&minus;1.234 &plusmn; 0.020)&times;10<sup>&minus;4</sup>")
        self.assertEqual(verdict.number(0.0377, 0.0017), "0.0377 &plusmn; 0.0017")
        self.assertEqual(verdict.number(float("nan")), "&ndash;")


class Regimes(unittest.TestCase):
    """Made-up tables of runs beyond the figures."""

    @staticmethod
    def row(**columns):
        row = {"tilt": 0.1, "eps_b": 1e-5, "upper.omega": -1e-6, "upper.omega_error": 1e-7, "upper.scaled": -5e-7,
               "upper.scaled_error": 5e-8, "upper.left.sliding": 0.05, "upper.right.sliding": 0.04, "upper.open": 0.0,
               "upper.pp": 0.01, "upper.pm": 0.01, "upper.mp": 0.01, "upper.mm": 0.01}
        return {**row, **{key.replace("__", "."): value for key, value in columns.items()}}

    def test_rare(self):
        """One point that turns where sliding is rare refutes; a few that do not leave it open."""
        turns, still = [self.row() for _ in range(5)], [self.row(upper__omega=s * 1e-7) for s in (1, -1, 0.5, 0.2, -0.4)]
        often = [self.row(upper__left__sliding=0.2)]
        for rows, wanted in ((turns + often, verdict.NO), (still + turns[:1], verdict.NO), (still + often, verdict.YES),
                             (still[:2] + often, verdict.OPEN), (often, verdict.OPEN), ([], verdict.OPEN)):
            self.assertEqual(regimes.rare_claim(Table(rows)).verdict, wanted)
        never = Table([self.row(upper__left__sliding=0.0, upper__right__sliding=0.0)])
        self.assertEqual(regimes.never_claim(never).verdict, verdict.NO)  # 1e-6 beside 1e-5 * 20 pi
        never.rows[0]["upper.omega"] = 1e-9
        self.assertEqual(regimes.never_claim(never).verdict, verdict.YES)

    def test_few_replicas(self):
        """t of 9 degrees of freedom beyond 3.25 is as rare as 2.58 errors of a normal number."""
        self.assertAlmostEqual(1 / regimes.normal(3.25, 1.0, 9) * 3.25, 2.576, delta=0.01)
        self.assertAlmostEqual(regimes.normal(1.0, 0.3, 10 ** 6), 0.3, places=4)

    def test_bouncing(self):
        opened = {"upper__open": 0.3}
        turns = [self.row(tilt=t, **opened) for t in (0.1, 0.2, 0.3, 0.4)]
        still = [self.row(tilt=t, upper__omega=1e-8, **opened) for t in (0.1, 0.2, 0.3, 0.4)]
        for rows, wanted in ((turns, verdict.YES), (still, verdict.NO), (turns[:2] + still[2:], verdict.OPEN),
                             ([self.row()], verdict.OPEN)):
            self.assertEqual(regimes.bouncing_claim(Table(rows)).verdict, wanted)

    def test_equal_durations(self):
        rng, rows = numpy.random.default_rng(5), []
        for equal in (True, False):
            table = []
            for seed in range(10):
                parts = dict(zip(("pp", "pm", "mp", "mm"), (0.2, 0.2, 0.2, 0.2) if equal else (0.1, 0.28, 0.32, 0.1)))
                table.append(self.row(tilt=0.0, set=0.0, replica=float(seed), upper__omega=1e-7 * rng.normal(),
                                      **{f"upper__{k}": v + 1e-3 * rng.normal() for k, v in parts.items()}))
            results = Results("/tmp", "full", "/bin/false", dry=True, strict=True)
            results.tables["level"] = Table(table)
            claims = {claim.slug: claim.verdict for claim in regimes.level_section(results).claims}
            rows.append((claims["random-level-seeds"], claims["equal-durations"]))
        plt.close("all")
        self.assertEqual(rows, [(verdict.YES, verdict.YES), (verdict.YES, verdict.NO)])

    def test_correlation_time(self):
        """A two-state process that flips at the rate k each way has the correlation time 1/(2k)."""
        rng, rate, step = numpy.random.default_rng(7), 2.0, 0.005
        flips = rng.random(2_000_000) < rate * step
        found = durations.correlation_time(numpy.cumsum(flips) % 2, step)
        self.assertAlmostEqual(found * 2 * rate, 1, delta=0.05)
        self.assertTrue(numpy.isnan(durations.correlation_time(numpy.ones(100), step)))

    def runs_with(self, power, noise=0.001):
        """Made-up rows: correlation times of the configurations go as a power of that of the drive at strong drive."""
        rng, rows = numpy.random.default_rng(8), []
        for scan in ("frequency", "interval"):
            for drive in durations.DRIVES:
                for k, omega in enumerate((10 * PI, 20 * PI, 40 * PI)):
                    for _ in range(4):
                        t_c = 2 / omega if scan == "frequency" else 0.03
                        rows.append({"drive": drive, "scan": scan, "set": float(len(rows) // 4), "omega": omega,
                                     "interval": 10.0 ** -k, "eps_b": 1e-4, "rms": 20 * PI * 1e-4 * (
                                         2 if drive == "all coordinates" else 0.05) * (1 + noise * rng.normal()),
                                     **{name: 0.1 * t_c ** (power if drive == "rotation" else 0.5) * (1 + noise * rng.normal())
                                        for name in durations.SIGNS},
                                     **{f"visit_{name}": 10.0 ** -k for name in durations.SIGNS}})
        return Table(rows)

    def test_durations(self):
        """Proportional for one drive alone: it depends; for none: it does not hold; noisy: open."""
        for table, wanted in ((self.runs_with(1.0), verdict.DEPENDS), (self.runs_with(0.5), verdict.NO),
                              (self.runs_with(1.0, 0.3), verdict.OPEN)):
            self.assertEqual(durations.proportional(table).verdict, wanted)
        self.assertEqual(durations.proportional(Table()).verdict, verdict.OPEN)
        self.assertEqual(durations.premise(self.runs_with(1.0)).verdict, verdict.DEPENDS)

    def test_fields(self):
        """The four statements on (30) and (35) are read from the map: all fields, some, none."""
        def table(off):
            return Table([{"phase": phase, "wave": wave, "k_n": 1e3, "omega_b": omega, "theta_b": theta, "tilt": tilt,
                           "upper.omega": (1 + off(omega, theta)) * fields.formula(kind, tilt) * theta * omega,
                           "upper.omega_error": 1e-12, "upper.converged": 1.0}
                          for kind, (phase, _, _) in fields.KINDS.items() for wave in fields.WAVES
                          for omega in (10 * PI, 20 * PI) for theta in (1e-3, 1e-2, 0.1) for tilt in (0.1, 0.2)])

        good = {1e-3: -0.5, 1e-2: -0.1, 0.1: -0.01}
        for off, wanted, best in ((lambda w, a: good[a], verdict.YES, verdict.YES),
                                  (lambda w, a: good[a] + 0.2 * (w > 15 * PI), verdict.DEPENDS, verdict.YES),
                                  (lambda w, a: good[a] + 0.2, verdict.NO, verdict.NO)):
            found = fields.fields(table(off))
            self.assertEqual([fields.claim(found, kind, which).verdict for kind in fields.KINDS
                              for which in ("approach", "excellent")], [wanted] * 4)
            self.assertEqual(fields.best(found).verdict, best)
        self.assertEqual(fields.claim([], "sync", "excellent").verdict, verdict.OPEN)

    def test_period_and_start(self):
        time = numpy.linspace(0, 0.2, 401)
        one, half, slow = (numpy.sin(2 * PI * time / period) for period in (0.1, 0.05, 0.2))
        yes, no = verdict.YES, verdict.NO
        for waves, wanted in (((one, one, one), [yes, yes]), ((half, half, half), [no, yes]),
                              ((slow, slow, slow), [no, yes]), ((one, one, -one), [yes, no])):
            found = {k: Table([{"time": t, "omega": v} for t, v in zip(time, wave)]) for k, wave in enumerate(waves)}
            self.assertEqual([claim.verdict for claim in starts.period_claims("sync", found)], wanted)
        self.assertEqual([claim.verdict for claim in starts.period_claims("sync", {})], [verdict.OPEN] * 2)

    def test_closed_path(self):
        law = {"change": 1e-15, "extent": 0.06, "work": 1.4e-2, "stored": 10.0, "rounds": 100.0}
        other = {**law, "work": 1e-16}
        self.assertEqual([c.verdict for c in starts.loop_claims({"paper": law, "conservative": other})],
                         [verdict.YES, verdict.NO])
        path = starts.loop_claims({"paper": {**other, "change": 1e-3}, "conservative": other})
        self.assertEqual([c.verdict for c in path], [verdict.NO, verdict.YES])

    def test_elastic(self):
        found = {"last_slide": 0.5, "end": 1.0, "crossings": 200.0, "swing": 1e-6}
        self.assertEqual(starts.elastic_claim(found).verdict, verdict.YES)
        self.assertEqual(starts.elastic_claim({**found, "last_slide": 0.95}).verdict, verdict.NO)
        self.assertEqual(starts.elastic_claim({**found, "crossings": 3.0}).verdict, verdict.NO)

    def test_diffusion(self):
        """The exponent of random walks is 1 within its error, that of a drift is 2."""
        rng = numpy.random.default_rng(6)
        walk = numpy.cumsum(rng.normal(size=(2000, 16)), axis=0)
        power, error = diffusion.exponent(*diffusion.spread(walk, 0.1))
        self.assertTrue(abs(power - 1) < 3 * error and error < 0.1, (power, error))
        power, error = diffusion.exponent(*diffusion.spread(numpy.arange(2000.0)[:, None] * rng.uniform(1, 2, 16), 0.1))
        self.assertAlmostEqual(power, 2, delta=1e-6)


if __name__ == "__main__":
    unittest.main(verbosity=1)
