"""Lists of what is measured, and the page that the site makes of them; and names of format 4, which are still read."""
import io
import json
import pathlib
import re
import sys
import tempfile
import unittest
import unittest.mock

import h5py
import numpy

from results_common import ROOT, deck_arguments, run

sys.path.insert(0, str(ROOT / "tools/docs"))
sys.dont_write_bytecode = True
import names  # noqa: E402

RENAMED = (("elastic_skin", "elastic_tangential"), ("variant", "nonconservative_work"))


class Names(unittest.TestCase):
    def test_the_page_has_what_the_program_prints(self):
        status, out, err = run("info", "--names")
        self.assertEqual((status, err), (0, ""))
        kept = (ROOT / "docs/names.md").read_text()
        before, after = kept.split(names.MARK)
        self.assertNotIn("|---", before + after)
        self.assertEqual(names.fill(kept), before + out + after)

    def test_every_name_has_a_unit_and_a_meaning(self):
        lists = re.split(r"^\*\*(\w+)\*\*: \S.*\n", names.tables(), flags=re.M)
        self.assertEqual(lists[0], "")
        self.assertGreater(len(lists[1::2]), 15)
        self.assertEqual(len(set(lists[1::2])), len(lists[1::2]))
        for title, text in zip(lists[1::2], lists[2::2]):
            rows = [re.split(r" (?<!\\)\| ?", line.strip("| ")) for line in text.splitlines() if line.startswith("| `")]
            self.assertTrue(rows, title)
            self.assertEqual(len({row[0] for row in rows}), len(rows), title)
            for row in rows:
                self.assertRegex(row[0], r"^`\w+`$", title)
                self.assertTrue(row[1] and row[-1] and not row[-1].startswith("`"), (title, row))
                self.assertNotIn(row[1], ("", "?"), title)

    def test_a_site_without_the_program(self):
        text = f"before\n{names.MARK}after\n"
        with unittest.mock.patch.object(names, "program", lambda: names.ROOT / "nowhere"), \
                unittest.mock.patch("sys.stderr", io.StringIO()) as told:
            self.assertEqual(names.fill(text), text)
        self.assertIn("is missing", told.getvalue())

    def test_columns_of_measure_are_on_its_page(self):
        page = (ROOT / "docs/measure.md").read_text()
        measured = run("info", "--names")[1].split("**measure**")[1]
        columns = re.findall(r"^\| `\w+` \| [^|]+ \| `(\w+)` \|", measured, re.M)
        self.assertGreater(len(columns), 30)
        self.assertEqual([name for name in columns if f"`{name}`" not in page and not re.match("(stress|kinetic)_", name)
                          and name != "step"], [])


class Format4(unittest.TestCase):
    """A result with the names and the number of format 4 gives the same numbers."""

    def test_old_names_are_read(self):
        with tempfile.TemporaryDirectory() as folder:
            path = str(pathlib.Path(folder) / "run.h5")
            self.assertEqual(run("run", *deck_arguments(measure=50000), "--quiet", "-o", path)[0], 0)
            before = json.loads(run("info", path, "--json")[1])["energy"]
            measured = json.loads(run("measure", path, "--json")[1])
            with h5py.File(path, "r+") as file:
                file["state"].attrs["format"] = numpy.int64(4)
                attributes = file["summary/energy"].attrs
                for old, new in RENAMED:
                    file.move(f"observables/{new}", f"observables/{old}")
                    attributes[old] = attributes[new]
                    del attributes[new]
                file.move("contacts/zeta", "contacts/stretch")
            self.assertEqual(run("verify", "--seal", "--quiet", path), (0, "", ""))
            self.assertEqual(json.loads(run("info", path, "--json")[1])["energy"], before)
            self.assertEqual(json.loads(run("measure", path, "--json")[1]), measured)


if __name__ == "__main__":
    unittest.main()
