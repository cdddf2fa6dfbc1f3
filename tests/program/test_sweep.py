"""`slipdisk sweep`: what it makes does not depend on how it is run, tables say what the results say, a sweep can grow."""
import os
import shutil
import unittest

import h5py
import numpy

from results_common import ROOT, assert_same, run
from sweep_common import ReferenceTest, SweepTest, column, number, results, rows, sessions, stamps, three_disks

GRID = """{ parameters = ( { path = "gravity.tilt"; values = (0, "0.04 pi"); },
    { path = "motions[*].amplitude"; name = "eps_b"; values = (1e-4, 2e-4); } ); replicas = 2; }"""


class Whole(ReferenceTest):
    """Eight points, run in all ways."""

    POINTS = 8

    @classmethod
    def setUpClass(cls):
        cls.make(three_disks(GRID))

    def test_what_is_there(self):
        names = [f"tilt={t},eps_b={e}{r}" for t in ("0", "0.04pi") for e in ("0.0001", "0.0002") for r in ("", ",r=1")]
        self.assertEqual(sorted(p.name for p in self.reference.iterdir()),
                         ["lock", "means.csv", "points", "table.csv", "table.h5"])
        self.assertEqual(sorted(p.name for p in (self.reference / "points").iterdir()), sorted(f"{n}.h5" for n in names))
        self.assertEqual(column(self.reference, "name"), names)
        self.assertEqual(column(self.reference, "status"), ["done"] * 8)
        self.assertEqual(column(self.reference, "set"), [str(k // 2) for k in range(8)])
        self.assertEqual(column(self.reference, "replica"), ["0", "1"] * 4)
        self.assertEqual(len(set(column(self.reference, "seed"))), 8)
        self.assertEqual(self.err.count("upper: Omega ="), 8)

    def test_number_of_workers(self):
        for words in ["-j", 1], ["-j", 4], []:
            with self.subTest(words=words):
                out = self.folder / f"out{len(words)}{words[-1:]}"
                self.sweep(self.path, *words, out=out)
                self.assert_same_results(out, self.reference)

    def test_one_by_one(self):
        for k in reversed(range(8)):
            self.sweep(self.path, "--point", k, "--quiet")
        said = self.sweep(self.path, "--point", 3)
        self.assertIn("is done already", said)
        self.assertFalse((self.out / "table.csv").exists())
        self.assertIn("table.csv", self.sweep(self.path, "--table"))
        self.assert_same_results(self.out, self.reference)

    def test_point_is_a_run(self):
        """A point is what `run` makes of the deck with the same -D."""
        row = rows(self.reference)[5]
        self.assertEqual((row["name"], row["replica"]), ("tilt=0.04pi,eps_b=0.0001,r=1", "1"))
        alone = self.folder / "alone.h5"
        status, _, err = run("run", self.path, "-o", alone, "--quiet", "-D", "gravity.tilt=0.04 pi", "-D",
                             "motions.shake.amplitude=1e-4", "-D", f"seed={row['seed']}")
        self.assertEqual(status, 0, err)
        assert_same(self, alone, results(self.reference)[row["name"]])
        # and another seed is another motion
        hashes = set()
        for path in results(self.reference).values():
            with h5py.File(path) as file:
                hashes.add(file["state"].attrs["hash"])
        self.assertEqual(len(hashes), 8)
        self.assertEqual(list(sessions(self.reference).values()), [1] * 8)

    def test_table_says_what_results_say(self):
        for row in rows(self.reference):
            with h5py.File(results(self.reference)[row["name"]]) as file:
                found = file["summary/rotation"]
                for name in "omega", "error", "scaled", "scaled_error", "transient", "measured":
                    cell = row["upper." + {"error": "omega_error"}.get(name, name)]
                    numpy.testing.assert_equal(number(cell), found[name][0], name)
                self.assertEqual(number(row["upper.converged"]), found["converged"][0])
                self.assertEqual(int(row["seed"]), file["parameters"].attrs["seed"])
                self.assertEqual(int(row["steps"]), 20000)
                self.assertEqual(float(row["work"]), file["summary/energy"].attrs["work"])
                self.assertEqual(float(row["tilt"]), 0.04 * numpy.pi * ("0.04pi" in row["name"]))
                five = [float(row[f"upper.{c}"]) for c in ("pp", "pm", "mp", "mm", "stick", "open")]
                self.assertAlmostEqual(sum(five), 1)
                self.assertGreater(float(row["upper.left.force_min"]), 0)

    def test_error_bars_of_older_results(self):
        """Tables take them from the bins in the result, whatever its summary says."""
        shutil.copytree(self.reference, self.out)
        for path in results(self.out).values():
            with h5py.File(path, "r+") as file:
                file["summary/rotation/error"][...] = 7
                file["summary/rotation/scaled_error"][...] = 7
            self.assertEqual(run("verify", "--seal", path)[0], 0)
        self.sweep(self.path, "--table")
        for one, other in zip(rows(self.reference), rows(self.out)):
            self.assertEqual(one, other)

    def test_csv_is_h5(self):
        with h5py.File(self.reference / "table.h5") as file:
            for group, name in ("points", "table.csv"), ("means", "means.csv"):
                table = rows(self.reference, name)
                self.assertEqual(set(table[0]), set(file[group]))
                for key, item in file[group].items():
                    self.assertTrue(item.attrs["description"], key)
                    cells = [row[key] for row in table]
                    if item.dtype.kind == "S":
                        self.assertEqual([t.decode() for t in item], cells, key)
                    else:
                        numpy.testing.assert_array_equal(item[()], [number(c) for c in cells], key)
            self.assertIn(b"sweep =", file["parameters/deck_text"][()])
            self.assertEqual(file["parameters"].attrs["tilt"], b"gravity.tilt")
            self.assertEqual(file["points/upper.omega"].attrs["unit"], b"rad/time")

    def test_means(self):
        table, means = rows(self.reference), rows(self.reference, "means.csv")
        self.assertEqual(len(means), 4)
        for mean in means:
            replicas = [r for r in table if r["set"] == mean["set"]]
            self.assertEqual(mean["replicas"], "2")
            self.assertEqual((mean["tilt"], mean["eps_b"]), (replicas[0]["tilt"], replicas[0]["eps_b"]))
            for name in "upper.omega", "work", "upper.left.sliding", "upper.scaled":
                values = numpy.array([number(r[name]) for r in replicas])
                numpy.testing.assert_allclose(number(mean[name]), values.mean(), rtol=1e-14, err_msg=name)
                if f"{name}_error" in table[0]:
                    errors = numpy.array([number(r[f"{name}_error"]) for r in replicas])
                    numpy.testing.assert_allclose(number(mean[f"{name}_error"]), numpy.sqrt((errors**2).sum()) / 2,
                                                  rtol=1e-14)
                    numpy.testing.assert_allclose(number(mean[f"{name}_scatter"]), values.std(ddof=1) / numpy.sqrt(2),
                                                  rtol=1e-13)
                else:
                    self.assertNotIn(f"{name}_scatter", mean)
            self.assertNotIn("ns_per_step", mean)
            self.assertNotIn("seed", mean)

    def test_status(self):
        self.assertEqual(self.sweep(self.path, "--count"), "8\n")
        said = self.sweep(self.path, "--list", out=self.reference).splitlines()
        self.assertEqual(len(said), 9)
        self.assertRegex(said[5], r"^ +5 +done +tilt=0\.04pi,eps_b=0\.0001,r=1 +upper: Omega = \S+ \+- \S+ \*$")
        self.assertIn("not reliable", said[8])
        said = self.sweep(self.path, "--status", out=self.reference)
        self.assertEqual(said, f"{self.reference}: 8 points: 8 done\n")
        # where nothing is nothing is made
        self.assertEqual(self.sweep(self.path, "--status"), f"{self.out}: 8 points: 8 waiting\n")
        self.assertIn("no point has been run", self.sweep(self.path, "--table", status=2))
        self.assertFalse(self.out.exists())

    def test_again(self):
        before = stamps(self.reference)
        said = self.sweep(self.path, "-j", 2, out=self.reference)
        self.assertIn("8 points, 8 done", said)
        self.assertIn("8 of 8 points done", said)
        self.assertEqual(stamps(self.reference), before)
        self.assertEqual(self.sweep(self.path, "-j", 2, "--quiet", out=self.reference), "")

    def test_force(self):
        shutil.copytree(self.reference, self.out)
        before = stamps(self.out)
        self.sweep(self.path, "--point", 2, "--force")
        after = stamps(self.out)
        self.assertEqual([n for n in before if before[n] != after[n]], ["tilt=0,eps_b=0.0002"])
        self.sweep(self.path, "--force")
        after = stamps(self.out)
        self.assertEqual([n for n in before if before[n] == after[n]], [])
        self.assert_same_results(self.out, self.reference)

    def test_run_and_check(self):
        """They take the deck as it stands, and say so; a point is not told."""
        _, _, err = run("run", self.path, "-o", self.folder / "one.h5")
        self.assertIn("warning: ", err)
        self.assertIn("has a sweep of 8 points, which `slipdisk sweep` runs; this is the deck as it stands", err)
        status, out, err = run("check", self.path, "--brief", "--no-probe")
        self.assertEqual((status, err), (0, ""))
        self.assertIn("# sweep       8 points, 4 sets of values; `slipdisk sweep` runs them", out)
        self.assertIn("1.6e+05 steps in all", out)
        self.assertNotIn("has a sweep", self.sweep(self.path, "--point", 1))
        deck = self.deck(three_disks('{ parameters = ( { path = "gravity.tlt"; values = (0, 1); } ); }'))
        status, out, err = run("check", deck, "--brief", "--no-probe")
        self.assertEqual(status, 2)
        self.assertEqual(err.count("error"), 1)
        self.assertRegex(err, r'deck\.cfg:\d+: gravity\.tlt = 0: unknown key of gravity; did you mean "tilt"\?')
        # the full deck of a point is a deck without sweep
        path = results(self.reference)["tilt=0,eps_b=0.0001"]
        with h5py.File(path) as file:
            full = self.deck(file["parameters/deck_full"][()].decode(), "full.cfg")
        _, _, err = run("run", full, "-o", self.folder / "two.h5")
        self.assertNotIn("has a sweep", err)
        with h5py.File(self.folder / "two.h5") as one, h5py.File(path) as two:
            self.assertEqual(one["state"].attrs["hash"], two["state"].attrs["hash"])

    def test_growing(self):
        """Values, replicas, grids and comments are added: what is done stays."""
        shutil.copytree(self.reference, self.out)
        before = stamps(self.out)
        deck = self.deck(three_disks("""( { parameters = ( # more of them
            { path = "gravity.tilt"; values = ("0.04 pi", "0.02 pi", 0); },
            { path = "motions[*].amplitude"; name = "eps_b"; values = (1e-4, 2e-4); } ); replicas = 3; },
            { parameters = ( { path = "materials[0].mu"; linspace = (0.1, 0.2, 2); } ); } )""", more="# a comment\n"))
        self.assertIn("20 points: 12 waiting, 8 done", self.sweep(deck, "--status"))
        said = self.sweep(deck, "-j", 2)
        self.assertIn("20 of 20 points done", said)
        after = stamps(self.out)
        self.assertEqual({n: after[n] for n in before}, before)
        old, new = ({r["name"]: r for r in rows(f)} for f in (self.reference, self.out))
        for name, row in old.items():
            self.assertEqual((row["seed"], row["upper.omega"]), (new[name]["seed"], new[name]["upper.omega"]))
        self.assertEqual(new["mu=0.2"]["tilt"], "")
        self.assertEqual(new["mu=0.2"]["mu"], "0.2")

    def test_other_deck(self):
        shutil.copytree(self.reference, self.out)
        before = stamps(self.out)
        difference = "gravity.g: 10.0 there, 9.0 here"
        said = self.sweep(self.path, "-D", "gravity.g=9", "-j", 2, "--mix", status=2)
        self.assertEqual(said.count(f"other deck: {difference}; --force runs the point again\n"), 8, said)
        self.assertIn("0 of 8 points done, 8 with a result that is not this deck's", said)
        said = self.sweep(self.path, "-D", "gravity.g=9", "--status")
        self.assertIn(f"8 other deck\nother deck: {difference} (8 points)\n", said)
        self.assertEqual(set(column(self.out, "message")), {difference})
        self.assertEqual(set(column(self.out, "status")), {"other deck"})
        self.assertEqual(set(column(self.out, "upper.omega") if "upper.omega" in rows(self.out)[0] else [""]), {""})
        said = self.sweep(self.path, "-D", "gravity.g=9", "--point", 3, status=2)
        self.assertIn("at least 7 points", said)
        said = self.sweep(self.path, "-D", "gravity.g=9", "--point", 3, "--mix", status=2)
        self.assertIn("point 3, tilt=0,eps_b=0.0002,r=1, is there already: other deck: gravity.g: ", said)
        self.assertEqual(stamps(self.out), before)
        self.assertEqual(sorted(p.suffix for p in (self.out / "points").iterdir()), [".h5"] * 8)
        self.sweep(self.path, "-D", "gravity.g=9", "--point", 3, "--force", "--quiet")
        self.assertEqual(sum(a != b for a, b in zip(sorted(stamps(self.out).items()), sorted(before.items()))), 1)
        said = self.sweep(self.path, "-j", 2, "--mix", status=2)
        self.assertIn("7 of 8 points done, 1 with a result that is not this deck's", said)

    def test_leftovers_of_a_kill(self):
        """A kill between the result and the removal of its parts: the next sweep cleans up."""
        shutil.copytree(self.reference, self.out)
        name = "tilt=0,eps_b=0.0001"
        parts = self.out / "points" / f"{name}.h5.parts"
        parts.mkdir()
        (parts / "lock").touch()
        before = stamps(self.out)
        self.assertIn("8 points: 1 stopped, 7 done", self.sweep(self.path, "--status"))
        self.sweep(self.path, "-j", 2)
        self.assertFalse(parts.exists())
        self.assertEqual(stamps(self.out), before)
        self.assert_same_results(self.out, self.reference)

    def test_command_line(self):
        for words, wanted in ((["-j", 0], "whole number"), (["-j", "many"], "whole number"), (["--point", 8], "0 to 7"),
                              (["--point", -1], "expected K or K-L, points of this sweep are 0 to 7"),
                              (["--point", "5-3"], "expected K or K-L"), (["--point", "x"], "--point x: expected K or K-L"),
                              (["--point", "1,2"], "expected K or K-L"), (["--point", ""], "expected K or K-L"),
                              (["--point", 1, "--point", 2], "given twice, 1 and 2"), (["--list", "--status"], "exclude"),
                              (["--point", 1, "-j", 2], "no meaning"), (["--frce"], "--force"), (["-D"], "needs a value"),
                              (["another.cfg"], "is a second")):
            with self.subTest(words=words):
                self.assertIn(wanted, self.sweep(self.path, *words, status=2))
        self.assertEqual(run("sweep")[0], 2)
        self.assertEqual(run("sweep", "none.cfg")[0], 2)
        self.assertIn("there is no folder", self.sweep(self.path, out=self.folder / "none/out", status=2))
        self.assertFalse(self.out.exists())


class Kinds(SweepTest):
    """Decks of all kinds."""

    def test_without_sweep(self):
        text = three_disks("()", 1000)
        deck = self.deck(text[:text.index("sweep =")])
        self.assertEqual(self.sweep(deck, "--count"), "1\n")
        self.sweep(deck, "-j", 1)
        self.assertEqual(list(results(self.out)), ["base"])
        self.assertEqual(column(self.out, "seed"), ["1"])

    def test_elsewhere(self):
        """@include, files of disks and swept files are seen from the deck's folder, wherever the sweep is run."""
        decks = self.folder / "decks"
        (decks / "data").mkdir(parents=True)
        for k in 1, 2:
            (decks / "data" / f"{k}.csv").write_text(f"x, y, radius\n0, 0, 1\n{3 * k}, 0, 0.5\n")
        (decks / "part.cfg").write_text('materials = ( { name = "m"; k_n = 100; } );\n'
                                        'sweep = { parameters = ( { path = "disk_files[0].file"; name = "grains"; '
                                        'values = ("data/1.csv", "data/2.csv"); } ); };\n')
        deck = self.deck('dt = 1e-3; steps = 100;\n@include "part.cfg"\n'
                         'disk_files = ( { file = "data/1.csv"; density = 1; } );\n'
                         'measure = { rotation = 0; };\n', "decks/deck.cfg")
        there = self.folder / "there"
        there.mkdir()
        self.sweep(os.path.relpath(deck, there), "-j", 2, out="made", cwd=there)
        found = results(there / "made")
        self.assertEqual(len(found), 2)
        for name, path in found.items():
            self.assertRegex(name, r"^grains=data_[12]\.csv,[0-9a-f]{8}$")
            with h5py.File(path) as file:
                x = file["particles/disks/position/value"][-1][1, 0]
            self.assertEqual(x, 3 * int(name[len("grains=data_")]))
        self.assertEqual(sorted(column(there / "made", "grains")), ["data/1.csv", "data/2.csv"])
        # a file that has changed makes another deck, although no word of the deck has
        (decks / "data/1.csv").write_text("x, y, radius\n0, 0, 1\n3, 0, 0.75\n")
        said = self.sweep(deck, "--status", out=there / "made")
        self.assertIn("1 done, 1 other deck", said)

    def test_phases_and_integrators(self):
        """Lengths, texts, several paths, zipped."""
        deck = self.deck(three_disks("""{ parameters = (
            { path = "phases[0].steps"; name = "n"; values = (100, 2e3); zip = "length"; },
            { path = "dt"; values = (2e-6, 1e-6); zip = "length"; },
            { path = "integrator"; values = ("gear5", "verlet"); },
            { path = [ "disks.left.fixed", "disks.right.fixed" ]; name = "fixed"; values = (true); } ); }"""))
        self.sweep(deck, "-j", 2)
        self.assertEqual(column(self.out, "steps"), ["100", "100", "2000", "2000"])
        numpy.testing.assert_allclose([float(t) for t in column(self.out, "time")], [2e-4, 2e-4, 2e-3, 2e-3])
        self.assertEqual(column(self.out, "integrator"), ["gear5", "verlet"] * 2)
        self.assertEqual(column(self.out, "fixed"), ["true"] * 4)
        # as time, in place of steps
        deck = self.deck(three_disks('{ parameters = ( { path = "phases[0].time"; name = "t"; values = (1e-4, 3e-4); } ); }'))
        self.sweep(deck, "-j", 2, out=self.folder / "times")
        self.assertEqual(column(self.folder / "times", "steps"), ["100", "300"])

    def test_swept_seed(self):
        deck = self.deck(three_disks('{ parameters = ( { path = "seed"; name = "noise"; values = (3, 4); } ); }', 1000))
        self.sweep(deck)
        self.assertEqual(column(self.out, "seed"), ["3", "4"])
        alone = self.folder / "alone.h5"
        self.assertEqual(run("run", deck, "-D", "seed=4", "-o", alone, "--quiet")[0], 0)
        assert_same(self, alone, results(self.out)["noise=4"])

    def test_until(self):
        """The goal ends the points at different steps."""
        shutil.copy(ROOT / "inputs/collisions/disk_wall.cfg", self.folder)
        deck = self.deck("""@include "disk_wall.cfg"
            until = { error = 1; max_time = 0.5; };
            sweep = { parameters = ( { path = "until.error"; name = "wanted"; values = (1e-6, 1e-30); } ); };""")
        said = self.sweep(deck, "-j", 2)
        done = rows(self.out)
        self.assertEqual([r["goal"] for r in done], ["1", "0"])
        self.assertEqual([r["steps"] for r in done], ["30000", "50000"])
        self.assertEqual(said.count("    warning: max_time came before the goal"), 1)

    def test_collect(self):
        deck = self.deck(three_disks("""( { parameters = ( { path = "gravity.g"; values = (9, 10); } );
            collect = [ "upper.omega*", "resid?al" ]; }, { collect = "nothing"; } )""", 1000))
        said = self.sweep(deck, "-j", 2)
        self.assertIn('warning: collect: "nothing" is no column of the table', said)
        self.assertEqual(list(rows(self.out)[0]), ["point", "name", "status", "set", "replica", "seed", "g", "message",
                                                   "upper.omega", "upper.omega_error", "residual"])
        with h5py.File(self.out / "table.h5") as file:
            self.assertEqual(set(file["points"]), set(rows(self.out)[0]))

    def test_strange_names(self):
        """Of points and of disks."""
        text = three_disks('{ parameters = ( { path = "title"; values = ("a, \\"b\\"", "a/b", "../up", "naïve", " ", '
                           '"line\\nbreak", "tab\\x09", "100%"); } ); }', 500)
        deck = self.deck(text.replace('"upper"', '"up, per/disk \\"1\\""'))
        self.sweep(deck, "-j", 2)
        self.assertEqual(column(self.out, "title"), ['a, "b"', "a/b", "../up", "naïve", " ", "line\nbreak", "tab\t", "100%"])
        self.assertEqual(len(results(self.out)), 8)
        for name in results(self.out):
            self.assertRegex(name, r"^title=[A-Za-z0-9._+-]*(,[0-9a-f]{8})?$")
        self.assertEqual(len(set(column(self.out, 'up, per/disk "1".omega'))), 8)
        with h5py.File(self.out / "table.h5") as file:
            self.assertEqual(file['points/up, per/disk "1".omega'].shape, (8,))
        self.assertEqual(sorted(p.name for p in self.folder.iterdir()), ["deck.cfg", "out"])
        # the deck of a point is complete
        first = results(self.out)[column(self.out, "name")[5]]
        with h5py.File(first) as file:
            self.assertEqual(file["parameters"].attrs["title"], b"line\nbreak")

    def test_name_and_folder(self):
        """The default folder is named after the deck."""
        deck = self.deck(three_disks("{ replicas = 2; }", 500), "some name.v2.cfg")
        status, _, err = run("sweep", deck, cwd=self.folder)
        self.assertEqual(status, 0, err)
        self.assertEqual(sorted(results(self.folder / "some name.v2.sweep")), ["base", "r=1"])

    def test_many(self):
        """A few hundred points are listed, checked and told at once."""
        deck = self.deck(three_disks('{ parameters = ( { path = "gravity.g"; linspace = (9, 10, 300); } ); replicas = 2; }', 1))
        self.assertEqual(len(self.sweep(deck, "--list").splitlines()), 600)
        self.sweep(deck, "--point", 599, "--quiet")
        self.assertIn("600 points: 599 waiting, 1 done", self.sweep(deck, "--status"))


if __name__ == "__main__":
    unittest.main()
