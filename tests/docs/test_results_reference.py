"""docs/names.md against the lists of what is measured, both ways; and names of format 4, which are still read."""
import json
import pathlib
import re
import tempfile
import unittest

import h5py
import numpy

from results_common import ROOT, deck_arguments, run

RENAMED = (("elastic_skin", "elastic_tangential"), ("variant", "nonconservative_work"))


class Names(unittest.TestCase):
    def test_the_page_has_what_the_program_prints(self):
        status, out, err = run("info", "--names")
        self.assertEqual((status, err), (0, ""))
        page = (ROOT / "docs/names.md").read_text()
        block = re.search(r"<!-- names: slipdisk info --names -->\n(.*?)<!-- end of names -->", page, re.S).group(1)
        said, written = out.splitlines(), block.splitlines()
        missing = [line for line in said if line and line not in written]
        stale = [line for line in written if line and line not in said]
        self.assertEqual((missing, stale), ([], []), "put the output of `slipdisk info --names` into docs/names.md")

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
