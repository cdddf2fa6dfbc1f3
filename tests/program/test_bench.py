"""bench_steps: cases and their CSV, the Markdown of a CSV, two builds in alternation, packings, mistakes. Not how fast anything is."""
import csv
import os
import pathlib
import re
import subprocess
import tempfile
import unittest

ROOT = pathlib.Path(os.environ.get("SLIPDISK_SOURCE_DIR", pathlib.Path(__file__).resolve().parents[2]))
PROGRAM = pathlib.Path(os.environ.get("SLIPDISK_BUILD_DIR", ROOT / "build/release")) / "tests/bench_steps"
ONLY = "sync/gear5/baseline,sync/verlet/baseline,epo/gear5/baseline"
SINGLE = ["sync/gear5/baseline", "sync/verlet/baseline", "epo/gear5/baseline"]
LANES = ["sync/gear5/baseline/lanes", "sync/verlet/baseline/lanes"]

# An older build: it has no lanes, and asked for anything else it says 1000, then 2000, and so on.
OLDER = """#!/bin/sh
[ "$1" = --serve ] || exit 1
n=0
while read -r name; do
  case $name in
    */lanes*) echo - ;;
    *) n=$((n + 1000)); echo $n ;;
  esac
done
"""


def run(*words):
    """(exit status, standard output, standard error)"""
    done = subprocess.run([PROGRAM, *map(str, words)], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
                          timeout=600, check=False)
    return done.returncode, done.stdout, done.stderr


def rows(path):
    with open(path, encoding="utf-8") as file:
        return {row["case"]: row for row in csv.DictReader(line for line in file if not line.startswith("#"))}


class Bench(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory(prefix="slipdisk-bench-")
        self.addCleanup(self.folder.cleanup)
        self.csv = pathlib.Path(self.folder.name) / "bench.csv"

    def run_ok(self, *words):
        status, out, err = run(*words)
        self.assertEqual((status, err), (0, ""), out)
        return out

    def test_names(self):
        names = self.run_ok("--list").split()
        self.assertEqual(len(names), len(set(names)))
        for system in ("random", "random10", "sync", "harmonic", "steady"):
            for integrator in ("gear5", "verlet"):
                for end in ("", "/lanes"):
                    self.assertIn(f"{system}/{integrator}/baseline{end}", names)
        for system in ("epo", "heap", "packing"):
            self.assertIn(f"{system}/gear5/baseline", names)
            self.assertNotIn(f"{system}/gear5/baseline/lanes", names)
        chosen = self.run_ok("--list", "--only", "steady/gear5/baseline,packing/verlet/baseline").split()
        self.assertEqual(chosen, ["steady/gear5/baseline", "steady/gear5/baseline/lanes", "packing/verlet/baseline"])

    def test_csv_and_markdown(self):
        out = self.run_ok("--quick", "--repeats", "3", "--only", ONLY, "--csv", self.csv)
        table = rows(self.csv)
        self.assertEqual(sorted(table), sorted(SINGLE + LANES))
        for name, row in table.items():
            self.assertEqual("/".join([row["system"], row["integrator"], row["path"]] +
                                      (["lanes"] if row["vectors"] == "1" else [])), name)
            self.assertEqual(row["members"], "2" if name in LANES else "1")  # the narrowest vector has two lanes
            self.assertEqual(row["free_disks"], "1")
            self.assertEqual(row["repeats"], "3")
            least, low, median, high = (float(row[f"{key}_ns"]) for key in ("least", "quartile1", "median",
                                                                            "quartile3"))
            self.assertTrue(0 < least <= low <= median <= high, row)
            line = next(line for line in out.splitlines() if line.split()[:1] == [name])
            self.assertAlmostEqual(float(line.split()[4]), median, delta=0.006)
        # the Markdown has these medians, each in its column, and nothing else
        lines = self.run_ok("--markdown", self.csv).splitlines()
        cells = [[cell.strip() for cell in line.strip("|").split("|")] for line in lines if line.startswith("| ")]
        self.assertEqual(cells[0], ["system", "integrator", "AVX-512", "AVX2", "baseline", "AVX-512, lanes",
                                    "AVX2, lanes", "baseline, 2 lanes"])
        self.assertEqual(len(cells), 1 + len(SINGLE))
        for name, line in zip(SINGLE, cells[1:]):
            system, integrator, _ = name.split("/")
            self.assertEqual(line[:4], [f"`{system}`", integrator, "-", "-"])
            self.assertAlmostEqual(float(line[4]), float(table[name]["median_ns"]), delta=0.51)
            self.assertEqual(line[5:7], ["-", "-"])
            if f"{name}/lanes" in table:
                self.assertAlmostEqual(float(line[7]), float(table[f"{name}/lanes"]["median_ns"]), delta=0.51)
            else:
                self.assertEqual(line[7], "-")

    def test_markdown_of_packings(self):
        title = ("case,system,integrator,path,members,vectors,free_disks,contacts,steps,repeats,median_ns,least_ns,"
                 "quartile1_ns,quartile3_ns,median_ns_per_disk\n")
        self.csv.write_text("# here and now\n" + title +
                            "heap/gear5/avx512,heap,gear5,avx512,1,0,45,79,100,15,1800,1700,1782,1818,40\n"
                            "heap/gear5/avx2,heap,gear5,avx2,1,0,45,79,100,15,90.25,80,90.25,90.25,2\n")
        out = self.run_ok("--markdown", self.csv)
        self.assertTrue(out.startswith("here and now  \n"), out)
        self.assertIn("\n| system | integrator | AVX-512 | AVX2 | baseline | per disk-step, AVX-512 |\n", out)
        self.assertIn("\n| `heap` | gear5 | 1800 | 90.2 | - | 40.0 |\n", out)
        self.assertRegex(out, re.compile(r"quartiles are 1\.0 % .* 2\.0 % at most\s+\(`heap/gear5/avx512`\)", re.S))

    def test_a_build_against_itself(self):
        for _ in range(3):  # other programs may take the processor from one of the two for a while, but not each time
            out = self.run_ok("--quick", "--only", "sync/gear5/baseline", "--compare", PROGRAM, "--csv", self.csv)
            table = rows(self.csv)
            if all(0.5 < float(row["ratio"]) < 2 for row in table.values()):
                break
        self.assertEqual(sorted(table), ["sync/gear5/baseline", "sync/gear5/baseline/lanes"])
        for name, row in table.items():
            self.assertIn(name, out)
            ratio = float(row["ratio"])
            self.assertAlmostEqual(ratio, float(row["this_median_ns"]) / float(row["other_median_ns"]), delta=1e-3)
            self.assertTrue(0.5 < ratio < 2, row)
            self.assertLessEqual(float(row["ratio_quartile1"]), float(row["ratio_quartile3"]))

    def test_an_older_build(self):
        older = pathlib.Path(self.folder.name) / "older"
        older.write_text(OLDER)
        older.chmod(0o755)
        out = self.run_ok("--quick", "--repeats", "3", "--only", "sync/gear5/baseline", "--compare", older, "--csv",
                          self.csv)
        self.assertRegex(out, r"\nsync/gear5/baseline/lanes +the other has no such case\n")
        table = rows(self.csv)
        self.assertEqual(list(table), ["sync/gear5/baseline"])
        # the first answer, 1000, prepares and does not count
        self.assertEqual(float(table["sync/gear5/baseline"]["other_median_ns"]), 3000)

    def test_scaling(self):
        out = self.run_ok("--scaling", "--quick", "--repeats", "3", "--sizes", "50,1e3,2000", "--threads", "1",
                          "--shuffle", "--csv", self.csv)
        table = rows(self.csv)
        names = [f"floor/{disks}/{numbers}/{integrator}/1" for numbers in ("placed", "shuffled")
                 for disks in (50, 1000, 2000) for integrator in ("gear5", "verlet")]
        self.assertEqual(list(table), names)
        for name, row in table.items():
            self.assertIn(name, out)
            least, low, median, high = (float(row[f"{key}_ns"]) for key in ("least", "quartile1", "median",
                                                                            "quartile3"))
            self.assertTrue(0 < least <= low <= median <= high, row)
            self.assertTrue(median < float(row["total_ns"]), row)
            # what is copied keeps its contacts
            self.assertTrue(1.5 < float(row["contacts_per_disk"]) < float(row["candidates_per_disk"]) < 3, row)
            self.assertGreaterEqual(int(row["all_steps"]), 64 + 3 * int(row["steps"]))
        lines = self.run_ok("--markdown", self.csv).splitlines()
        cells = [[cell.strip() for cell in line.strip("|").split("|")] for line in lines if line.startswith("| ")]
        path = table[names[0]]["path"]
        self.assertEqual(cells[0], ["packing", "disks", "numbers", "contacts", "candidates",
                                    f"gear5, {path}, 1 thread", f"verlet, {path}, 1 thread"])
        self.assertEqual([line[1:3] for line in cells[1:]],
                         [[disks, numbers] for numbers in ("placed", "shuffled") for disks in ("50", "1000", "2000")])
        for line in cells[1:]:
            for k, integrator in ((5, "gear5"), (6, "verlet")):
                total = float(table[f"floor/{line[1]}/{line[2]}/{integrator}/1"]["total_ns"])
                self.assertAlmostEqual(float(line[k].split()[0]), total, delta=0.06)

    def test_packings_of_few_and_many_contacts(self):
        kinds = ["gas", "fluid", "thrown", "shaken", "floor", "smooth", "pressed"]
        self.run_ok("--scaling", "--repeats", "15", "--sizes", "100", "--packings", "all", "--only", "verlet", "--csv",
                    self.csv)
        table = rows(self.csv)
        self.assertEqual(list(table), [f"{kind}/100/placed/verlet/1" for kind in kinds])
        contacts = {row["packing"]: float(row["contacts_per_disk"]) for row in table.values()}
        self.assertLess(contacts["gas"], 1)
        self.assertLess(contacts["gas"], contacts["shaken"])
        self.assertLess(contacts["shaken"], contacts["smooth"])
        self.assertGreater(contacts["pressed"], 2)

    def test_mistakes(self):
        other = self.csv.with_name("other.csv")
        other.write_text("case,ratio\na,1\n")
        for words, says in ((["--only", "nothing"], "no such case"), (["--repeats", "0"], "--repeats N"),
                            (["--fast"], "--quick"), (["--markdown", self.csv], "bench.csv"),
                            (["--markdown", other], "not a table"), (["--sizes", "1000"], "--scaling"),
                            (["--scaling", "--sizes", "1001"], "multiples of 10"),
                            (["--scaling", "--sizes", "1e3;1e4"], "whole numbers"),
                            (["--scaling", "--packings", "pile"], "no such packing"),
                            (["--quick", "--only", "sync/gear5/baseline", "--compare", self.csv], "bench.csv"),
                            (["--only", "sync", "--csv", self.csv / "x"], "bench.csv/x")):
            status, _, err = run(*words)
            self.assertEqual(status, 1, words)
            self.assertIn(says, err)


if __name__ == "__main__":
    unittest.main()
