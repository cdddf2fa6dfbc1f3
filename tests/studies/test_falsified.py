"""Verdicts that could not fail: the numbers kept with the sources are falsified, and each of the paper's statements that they bear out
has to turn."""
import tempfile
import unittest
import zlib

import numpy

from studies_common import ROOT
from ratchet import __main__ as report
from ratchet import (catalogue, mechanism_noise, mechanism_portrait, mechanism_scan, mechanism_size, page,
                    verdict)
from ratchet.data import Table
from ratchet.runs import Results
from ratchet.style import plt

DATA, NONE = ROOT / "docs/studies/data", "/nonexistent/slipdisk"
MODULES = [module for module in report.MODULES  # the others judge nothing that the paper says
           if module not in (mechanism_noise, mechanism_portrait, mechanism_size)]
mechanism_scan.draw = lambda found: page.Figure("mechanism-scan", None, "", "")  # its curves take seconds
FALSE = {  # name: what becomes of a result
    "turned round": lambda values, rng: -values,
    "scattered": lambda values, rng: values * numpy.exp(rng.normal(size=len(values))) * rng.choice([-1, 1], len(values)),
    "raised": lambda values, rng: values + numpy.abs(values).max(initial=1.0),
}
ERRORS = ("_error", "error", "_sd")  # error bars stay: they say how well the false is known


class Falsified(Results):
    """The kept results; what is measured is falsified, parameters and theory are not."""

    def __init__(self, folder, false=None):
        super().__init__(folder, "default", NONE, dry=True, strict=True, kept=str(DATA))
        self.false = false

    def falsified(self, table, name, results):
        if not self.false:
            return table
        rng, rows = numpy.random.default_rng(zlib.crc32(name.encode())), [dict(row) for row in table.rows]
        for column in results:
            at = [k for k, row in enumerate(rows) if isinstance(row.get(column), float) and numpy.isfinite(row[column])]
            for k, value in zip(at, self.false(numpy.array([rows[k][column] for k in at]), rng)):
                rows[k][column] = float(value)
        return Table(rows, table.missing, table.source)

    def sweep(self, name):
        table = super().sweep(name)
        columns = list(table.rows[0]) if table else []
        after = columns[columns.index("message") + 1:] if "message" in columns else []
        return self.falsified(table, name, [c for c in after if c.startswith("upper.") and not c.endswith(ERRORS)
                                            and not c.endswith(("measured", "transient", "visits"))])

    def numbers(self, name, make, title="", digits=8, **head):
        table = super().numbers(name, make, title, digits, **head)
        if not table or name.startswith(("theory-", "effort", "geometry")):
            return table
        fixed = ("t", "time", "lag", "set", "omega_b", "theta_b", "eps_b", "interval", "omega", "drive", "scan", "tilt",
                 "push", "mu", "amplitude", "weight", "duration")
        return self.falsified(table, name, [c for c in table.rows[0] if not c.endswith(ERRORS) and (
            c not in fixed or name.startswith("start-") and c == "omega")])


def claims_of(results):
    """{slug: claim}; false numbers may be such that a section cannot be drawn: it then judges nothing."""
    found = []
    for module in MODULES:
        try:
            found += [claim for section in module.sections(results) for claim in section.claims]
        except (ArithmeticError, ValueError, IndexError, KeyError, numpy.linalg.LinAlgError):
            if not results.false:
                raise
    return {claim.slug: claim for claim in found + report.statements.sections(results, found)[0].claims if claim.rule}


class False_(unittest.TestCase):
    def test_each_statement_can_fail(self):
        """A statement that holds, or depends, on the kept numbers does not on at least one kind of false ones."""
        verdicts = {}
        with tempfile.TemporaryDirectory() as folder:
            true = claims_of(Falsified(folder))
            for name, false in FALSE.items():
                try:
                    verdicts[name] = {slug: claim.verdict for slug, claim in claims_of(Falsified(folder, false)).items()}
                finally:
                    plt.close("all")
        stays = [row[0] for row in catalogue.STATEMENTS if row[1] == verdict.PAPER
                 and row[0] in true and true[row[0]].verdict in (verdict.YES, verdict.DEPENDS)
                 and all(those.get(row[0], true[row[0]].verdict) == true[row[0]].verdict for those in verdicts.values())]
        self.assertEqual(stays, [], "statements that false numbers bear out as well as true ones")

    def test_each_tolerance_turns_a_verdict(self):
        """A rule with a tolerance knows where its verdict turns: there it is another one, and half and twice are as said."""
        claim = verdict.within("", 1.005, 1.0, 0.01)
        self.assertEqual((claim.verdict, claim.half, claim.double), (verdict.YES, verdict.YES, verdict.YES))
        self.assertAlmostEqual(claim.turns, 0.5, delta=0.01)
        claim = verdict.within("", 1.015, 1.0, 0.01)
        self.assertEqual((claim.verdict, claim.half, claim.double), (verdict.NO, verdict.NO, verdict.YES))
        self.assertAlmostEqual(claim.turns, 1.5, delta=0.01)
        self.assertTrue(numpy.isinf(verdict.decide("", lambda factor: True, "").turns))
        self.assertTrue(numpy.isnan(verdict.decide("", True, "").turns))
        self.assertEqual(verdict.in_fields([verdict.YES, verdict.NO]), verdict.DEPENDS)
        self.assertEqual(verdict.in_fields([verdict.YES, verdict.OPEN]), verdict.OPEN)
        self.assertEqual([verdict.in_fields([v, v]) for v in (verdict.YES, verdict.NO)], [verdict.YES, verdict.NO])


if __name__ == "__main__":
    unittest.main(verbosity=1)
