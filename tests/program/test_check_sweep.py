"""What is said of a sweep before any of its points runs, by `check` and by `sweep`: each mistake once, the time step of the
worst point, tilts that look like degrees, columns that there will not be, how long it takes."""
import csv
import shutil
import unittest

from results_common import run
from sweep_common import temporary_folder, three_disks

BAD_STEPS = "{ parameters = ( { path = \"gravity.tilt\"; values = (0, 0.1); }, " \
            "{ path = \"materials.disk.k_t\"; values = (1e6, 1e10, 1e12, 1e11); } ); }"
UNSTABLE = "limits = { unstable_step = true; };\n"


class Survey(unittest.TestCase):
    def setUp(self):
        self.folder = temporary_folder()
        self.deck = self.folder / "deck.cfg"

    def tearDown(self):
        shutil.rmtree(self.folder)

    def write(self, sweep, **more):
        self.deck.write_text(three_disks(sweep, **more) if sweep else three_disks("()", **more).replace("sweep = ();", ""))

    def check(self, sweep, *words, status=0, **more):
        """standard output, and the lines of standard error"""
        self.write(sweep, **more)
        found, out, err = run("check", self.deck, "--brief", "--no-probe", *words)
        self.assertEqual(found, status, err)
        return out, err.splitlines()

    def said_by_sweep(self, *words):
        status, _, err = run("sweep", self.deck, "-o", self.folder / "out", *words)
        self.assertEqual(status, 0, err)
        return err

    def test_time_steps(self):
        """The point that needs the shortest step is named, not the first that is warned of."""
        _, err = self.check(BAD_STEPS, more=UNSTABLE)
        self.assertEqual(len(err), 1, err)
        for words in "dt = 1e-06 is beyond the limit of stability 1.03e-07 (gear5, tangential spring)", "take 2e-08 or less", \
                "(point 2, tilt=0,k_t=1000000000000, the worst; 6 of 8 sets of values)":
            self.assertIn(words, err[0])
        _, err = self.check(BAD_STEPS.replace("1e10, 1e12, 1e11", "1e10"))
        self.assertEqual(len(err), 1, err)
        self.assertIn("dt = 1e-06 is more than 1/20 of the shortest contact period 8.112e-06; take 2e-07 or less", err[0])
        self.assertIn("(point 1, tilt=0,k_t=10000000000, the worst; 2 of 4 sets of values)", err[0])
        _, err = self.check(BAD_STEPS.replace("1e10, 1e12, 1e11", "1e7"))
        self.assertEqual(err, [])

    def test_stability(self):
        """Verlet: dt at which the period has pi steps; `run` says the same as `check`, and refuses what is not asked for."""
        for dt, said in (2.57e-4, "is more than 1/20"), (2.6e-4, "is beyond the limit of stability"):
            _, err = self.check(None, "-D", f"dt={dt}", "-D", "integrator=verlet", more=UNSTABLE)
            self.assertEqual(len(err), 1, err)
            self.assertIn(said, err[0])
            words = "-D", f"dt={dt}", "-D", "integrator=verlet", "-D", "limits.unstable_step=false"
            _, err = self.check(None, *words, status=2 if "beyond" in said else 0, more=UNSTABLE)
            self.assertIn("dt = 0.00026: beyond 0.000258" if "beyond" in said else said, err[0])
            _, _, ran = run("run", self.deck, "-D", f"dt={dt}", "-D", "integrator=verlet", "-D", "phases.measure.steps=1", "-o", self.folder / "a.h5", "--force")
            self.assertIn(said, ran)

    def test_tilts(self):
        hint = "more than a right angle; angles are in radians, degrees are \"%s deg\""
        _, err = self.check(None, "-D", "gravity.tilt=3")
        self.assertEqual(err, [f"warning: -D gravity.tilt=3: gravity.tilt = 3: {hint % 3}"])
        for tilt in "1.57", "-1.57", "91 deg", "1 pi":
            self.assertEqual(self.check(None, "-D", f"gravity.tilt={tilt}")[1], [])
        line = three_disks("{").count("\n")
        _, err = self.check('{ parameters = ( { path = "gravity.tilt"; values = (0, 3, -6, "120 deg"); } ); }')
        self.assertEqual(err, [f"warning: {self.deck}:{line}: gravity.tilt = -6: {hint % -6}"])
        for values in 'linspace = ("90 deg", "1 pi", 3)', 'values = (0, 1.5, "170 deg")':
            self.assertEqual(self.check('{ parameters = ( { path = "gravity.tilt"; %s; } ); }' % values)[1], [])

    def test_kinds_of_mistakes(self):
        """Each kind once, and in the same call."""
        _, err = self.check('{ parameters = ( { path = "gravity.tilt"; values = ("3 degrees", "4 degrees", true); } ); }', status=2)
        self.assertEqual(len(err), 2, err)
        self.assertIn('gravity.tilt = "3 degrees": "degrees" behind a number; did you mean "deg"?', err[0])
        self.assertIn("others: 2 of 3 sets of values", err[0])
        self.assertIn('gravity.tilt = true: expected a number or a text such as "0.04 pi" or "7.2 deg", not true or false', err[1])
        _, err = self.check('{ parameters = ( { path = "materials.disk.mu"; values = ("a", true, 0.1, -1); } ); }', status=2)
        self.assertEqual(len(err), 3, err)

    def test_without_group(self):
        self.write(None, steps=100)
        self.assertIn('there is no group sweep: one point, "base", is the deck as it stands', self.said_by_sweep())
        self.write("{ replicas = 1; }", steps=100)
        self.assertNotIn("there is no group", self.said_by_sweep("--force"))

    def test_collect(self):
        """What is a column of the table is known before, and what is not, too."""
        grid = '{ parameters = ( { path = "gravity.tilt"; values = (0, 0.1); }, { path = "title"; values = ("a"); } ); %s }'
        everything = ["-D", "measure.disks=true", "-D", "until.error=1", "-D", "until.max_time=0.01"]
        self.write(grid % "", steps=2000)
        self.said_by_sweep(*everything)
        with open(self.folder / "out/table.csv", newline="") as file:
            columns = next(csv.reader(file))
        self.assertIn("upper.left.openings", columns)
        names = ", ".join(f'"{name}"' for name in columns)
        self.assertEqual(self.check(grid % f"collect = ({names});", *everything, steps=2000)[1], [])
        for pattern in "topp.*", "upper.openings", "goal", "coordination", "left.omega", "upper.?":
            _, err = self.check(grid % f'collect = ("*.omega", "{pattern}");')
            self.assertEqual(err, [f'warning: collect: "{pattern}" will be no column of the table'])

    def test_time(self):
        """With one worker, and in lanes where there are any."""
        self.write(BAD_STEPS.replace("1e10, 1e12, 1e11", "1e7"), steps=1000000)
        _, out, _ = run("check", self.deck, "--brief")
        self.assertRegex(out, r"4e\+06 steps in all, about .* with one worker, (in lanes|one after the other); -j N shares them")
        self.assertEqual("side by side" in out, "with one worker, in lanes" in out)
        self.write("{ replicas = 1; }")
        _, out, _ = run("check", self.deck, "--brief")
        self.assertRegex(out, r"# +2e\+04 steps in all, about .* with one worker, one after the other\n")

    def test_bounds(self):
        """A disk that may fall for ever is told of, and bounds without limits are enough against it."""
        self.assertIn("# bounds      none", self.check(None)[0])
        self.assertNotIn("# bounds", self.check(None, "-D", "gravity.g=0")[0])
        self.deck.write_text(three_disks("()").replace("sweep = ();", "bounds = { };"))
        _, out, _ = run("check", self.deck, "--no-probe")
        self.assertNotIn("# bounds", out)
        self.assertIn('outside = "report"', out)


if __name__ == "__main__":
    unittest.main()
