"""Numbers kept with the sources (docs/studies/data): they are read back as they were judged, and every figure is
drawn from them alone, without results and without the program."""
import csv
import os
import pathlib
import tempfile
import unittest
import unittest.mock

import numpy

from studies_common import ROOT
import matplotlib.figure
from packings import __main__ as study
from packings.runs import Campaign
from ratchet import __main__ as report
from ratchet import argument, kept, markdown, page, style, summary
from ratchet.page import Numbers, Section
from ratchet.runs import Results
from ratchet.verdict import CHECK, DEPENDS, NO, PAPER, TRIVIAL, YES, Claim

style.plt.rcParams["savefig.dpi"] = 30  # what is drawn is not looked at here
save = matplotlib.figure.Figure.savefig


def save_once(picture, path, **more):
    """Each figure is drawn for its PNG; test_report and test_packings_report write PDFs as well."""
    if not str(path).endswith(".pdf"):
        save(picture, path, **more)

DATA, NONE = ROOT / "docs/studies/data", "/nonexistent/slipdisk"


def rows(path):
    with open(path, newline="") as file:
        return list(csv.reader(line for line in file if not line.startswith("#")))


def same(a, b):
    try:
        return numpy.isclose(float(a), float(b), rtol=1e-6, atol=1e-300)
    except ValueError:
        return a == b


class Numbered(unittest.TestCase):
    def results(self, folder, **more):
        return Results(folder, "full", NONE, dry=True, **more)

    def test_round_trip(self):
        """What is judged is what is kept: with results, from kept numbers, and from the same place once more."""
        columns = {"x": [1 / 3, numpy.nan, 1e-20], "seed": [2 ** 53 - 1, 0, 5], "name": ["a,b", "", "c"]}
        with tempfile.TemporaryDirectory() as folder, tempfile.TemporaryDirectory() as docs:
            made = self.results(folder)
            first = made.numbers("some-numbers", lambda: columns, "three rows", digits={"x": 4}, deck="inputs/a.cfg")
            self.assertEqual(list(first.column("x"))[::2], [0.3333, 1e-20])
            self.assertEqual(first.rows[0]["seed"], 2 ** 53 - 1)
            made.store.keep(os.path.join(docs, "paper"), [], True)
            with open(os.path.join(docs, "paper", "some-numbers.csv")) as file:
                head = file.read()
            self.assertIn("# level: full\n", head)
            self.assertIn("# deck: inputs/a.cfg\n", head)
            with tempfile.TemporaryDirectory() as empty:
                again = Results(empty, "default", NONE, dry=True, kept=docs)
                self.assertEqual(again.level, "full")
                for make in (lambda: None, lambda: {}, self.not_kept):
                    again.found.clear()
                    self.assertEqual(str(again.numbers("some-numbers", make).rows), str(first.rows))
                self.assertFalse(again.numbers("others", lambda: None))
                self.assertEqual(again.store.from_kept, ["some-numbers"])
            running = Results(folder, "full", NONE, kept=docs)  # what is to be run is not read from elsewhere
            self.assertFalse(running.numbers("some-numbers", lambda: None))

    @staticmethod
    def not_kept():
        raise kept.NotKept("a frame")

    def test_answers_of_info(self):
        found = {"rotation": [{"disk": 0, "omega": 0.5, "name": "upper"}], "until": None, "finished": True}
        flat = kept.flatten(found)
        self.assertEqual(flat["rotation.0.omega"], 0.5)
        self.assertEqual(kept.nested(flat), {"rotation": found["rotation"], "finished": True})

    def test_thin(self):
        table = kept.thin({"t": numpy.arange(1001.0)}, 100)
        self.assertEqual((len(table), table.rows[0]["t"], table.rows[-1]["t"]), (101, 0, 1000))

    def test_which_numbers_belong_to_which_section(self):
        kept.LOG.clear()
        kept.LOG.append("both")
        first = Section("first", "First")
        kept.LOG.append("own")
        second = Section("second", "Second")
        kept.LOG.extend(["other", "not-there"])
        kept.assign([first, second], {"both": 1, "own": 1, "other": 1})
        self.assertEqual((first.data, second.data), (["both", "own"], ["both", "other"]))


class Pages(unittest.TestCase):
    def test_digits(self):
        """Values are shown with the digits that their errors allow, errors beside them; the CSV has all."""
        table = Numbers("A", ["&Omega;", "error", "off, %", "seed"], [[0.00951962, 0.00030001, 0.00951962,
                                                                       5753210969526250.0],
                                                                     [1.5, numpy.nan, 25.0, 3.0]])
        columns, cells = page.shown_table(table)
        self.assertEqual(columns, ["&Omega;", "off, %", "seed"])
        self.assertEqual([text for text, _ in cells[0]], ["0.00952 &plusmn; 0.00030", "0.00952", "5753210969526250"])
        self.assertEqual([text for text, _ in cells[1]], ["1.5", "25", "3"])
        self.assertIn("0.00951962,0.00030001", page.csv_of(table))

    def test_markdown(self):
        """Unicode signs where there are any, no entities, and nothing that Markdown takes for something else."""
        for source, wanted in (
                ("S<sup>+&minus;</sup> at <i>k<sub>n</sub></i> = 10<sup>&minus;5</sup>", "S⁺⁻ at *k*ₙ = 10⁻⁵"),
                ("<i>t<sub>g</sub></i>&Omega; of &theta;<sub>T</sub>", "*t*<sub>g</sub>Ω of θ<sub>T</sub>"),
                ("<b>a</b> <code>b_c</code> 2 * 3, $x &lt; y$, &lt;b&gt;", r"**a** `b_c` 2 \* 3, \$x < y\$, \<b>"),
                ("<ul><li>one</li><li>two</li></ul>", "- one\n- two")):
            self.assertEqual(markdown.text_of(source), wanted)
        self.assertEqual(markdown.table(["a", "b"], [["|x|", 0.25], ["y", 1e-9]]),
                         ["| a | b |", "| --- | ---: |", "| \\|x\\| | 0.25 |", "| y | 1×10⁻⁹ |"])

    def test_first_page(self):
        """It counts the paper's statements only; a reason stands with the statement; paragraphs rest on verdicts."""
        section = Section("key", "A section")
        section.claims = [Claim("One.", YES, "1", "section 3", PAPER, "one"), Claim("Two.", NO, "2 of 3", "section 4",
                                                                                    PAPER, "two"),
                          Claim("Three.", NO, "x", "", CHECK), Claim("Four.", NO, "x", "section 2", TRIVIAL)]
        first, errata = summary.sections([section], (("eq. (1)", "a", "b", "two"),), {"two": "a reason"})
        text = markdown.text_of(first.lead)
        self.assertIn("Of the paper's 2 statements 1 are reproduced, 1 are not, none hold or fail with what the paper does not "
                      "give, and none cannot be decided", text)
        self.assertIn("Left out: the data here do not bear it out, or are missing: `premise-velocity`", text)
        self.assertEqual(section.claims[1].numbers, "2 of 3 &ndash; a reason")
        self.assertNotIn("Three.", text)
        self.assertIn("#key", errata.tables[0].rows[0][-1])
        self.assertEqual(first.tables[0].rows[0][1:], [1, 1, 0, 0, "0 of 1"])
        listed = summary.sections([section], (), {"two": "a reason"}, (PAPER, CHECK))[0]
        self.assertIn("Of the 3 statements 1 are reproduced, 2 are not", markdown.text_of(listed.lead))

    def test_argument(self):
        """A paragraph stands while the verdicts are as it says, and its figures stand with it and nowhere else."""
        for heading, text, rests in argument.PARAGRAPHS:
            self.assertLessEqual(set(rests.values()), {YES, NO, DEPENDS}, heading)
            section = Section("key", "A section")
            section.claims = [Claim("x", verdict, "", "section 4", PAPER, slug) for slug, verdict in rests.items()]
            figure = page.Figure(argument.FIGURES[0], None, "", "")
            section.figures.append(figure)
            first = argument.section([section], "")
            self.assertIn(text[:40].split("{")[0], first.lead, heading)
            self.assertEqual((first.figures, section.figures), ([figure], []))


class Redrawn(unittest.TestCase):
    """docs/studies/data alone makes the pages that are kept."""

    def drawn(self, name, kind, draw):
        if not list((DATA / name).glob("*.csv")):
            self.skipTest(f"no numbers are kept for {name}")
        empty = []
        mark, page.mark_empty = page.mark_empty, lambda picture: empty.append(picture) if mark(picture) else None
        with tempfile.TemporaryDirectory() as folder:
            try:
                results = kind(folder, "default", NONE, dry=True, strict=True, kept=str(DATA))
                with unittest.mock.patch.object(matplotlib.figure.Figure, "savefig", save_once):
                    draw(results)
            finally:
                page.mark_empty = mark
            self.assertEqual(results.failed, [])
            self.assertEqual(empty, [], "figures without data")
            tables = sorted(path.name for path in (DATA / name).glob("table-*.csv"))
            self.assertEqual(tables, sorted(path.name
                                            for path in pathlib.Path(results.store.folder).glob("table-*.csv")))
            for table in tables:
                here, there = rows(os.path.join(results.store.folder, table)), rows(DATA / name / table)
                self.assertEqual(len(here), len(there), table)
                for a, b in zip(here, there):
                    self.assertTrue(len(a) == len(b) and all(map(same, a, b)), f"{table}: {a} is not {b}")

    def test_paper(self):
        self.drawn("paper", Results, report.draw)

    def test_packings(self):
        self.drawn("packings", Campaign, study.draw)


if __name__ == "__main__":
    unittest.main()
