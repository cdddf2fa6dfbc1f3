"""The study of packings (tools/studies/packings.sh): its numbers from made-up data, its table of runs, and a tiny
campaign."""
import os
import subprocess
import tempfile
import types
import unittest

import numpy

from studies_common import PROGRAM, ROOT
from packings import __main__ as study
from packings import (compare, depths, disks, drive, each, energy, flows, low, plan, quiet, scans,
                      statistics)
from packings.plan import Entry
from packings.runs import Campaign
from ratchet.runs import overrides
from ratchet.style import plt
from ratchet.verdict import NO, OPEN, YES

plt.rcParams["savefig.dpi"] = 30  # what is drawn is not looked at here
RNG = numpy.random.default_rng(5)


class Numbers(unittest.TestCase):
    def test_jackknife(self):
        """Of a mean it is the standard error; of groups that repeat each other it is that of the groups."""
        values = RNG.normal(size=12)
        mean, error = statistics.mean_error(values)
        found = statistics.jackknife(numpy.mean, values)
        self.assertAlmostEqual(found[0], mean, 12)
        self.assertAlmostEqual(found[1], error, 12)
        groups = [numpy.full(50, value) for value in values]
        self.assertAlmostEqual(statistics.jackknife(lambda g: numpy.concatenate(g).mean(), groups)[1], error, 12)

    def test_correlations(self):
        x = RNG.normal(size=400)
        self.assertAlmostEqual(statistics.spearman(x, numpy.exp(3 * x)), 1, 12)
        self.assertLess(statistics.pearson(x, numpy.exp(3 * x)), 0.9)
        self.assertEqual(list(statistics.ranks([3, 1, 1, 7])), [2, 0.5, 0.5, 3])

    def test_moments(self):
        mean, rms, skewness, kurtosis = statistics.moments([-1, 1, -1, 1])
        self.assertEqual((mean, rms, skewness, kurtosis), (0, 1, 0, -2))

    def test_line_and_power(self):
        x = numpy.arange(1, 9.0)
        slope, error, offset, _ = statistics.line(x, 3 * x - 2)
        self.assertAlmostEqual(slope, 3, 10)
        self.assertAlmostEqual(offset, -2, 10)
        self.assertLess(error, 1e-9)
        exponent, _, factor = statistics.power_law(x, 5 * x ** 1.7)
        self.assertAlmostEqual(exponent, 1.7, 10)
        self.assertAlmostEqual(factor, 5, 9)
        # The error of a slope is what repeated noise makes of it.
        fits = [statistics.line(x, x + 0.1 * RNG.normal(size=8)) for _ in range(400)]
        told, seen = numpy.mean([f[1] for f in fits]), numpy.std([f[0] for f in fits])
        self.assertAlmostEqual(told / seen, 1, delta=0.15)

    def test_crossing(self):
        x = numpy.array([0.1, 1, 10])
        self.assertAlmostEqual(statistics.crossing(x, [1e-4, 1e-2, 1], 1e-1), 10 ** 0.5, 9)
        self.assertTrue(numpy.isnan(statistics.crossing(x, [1e-4, 1e-3, 1e-2], 1)))
        self.assertTrue(0.1 < statistics.crossing(x, [0, 1e-2, 1], 1e-3) < 1)


class Comparisons(unittest.TestCase):
    def test_student(self):
        """Tabulated values."""
        for t, degrees, chance in ((12.706, 1, 0.05), (2.776, 4, 0.05), (4.604, 4, 0.01), (1.984, 100, 0.05)):
            self.assertAlmostEqual(compare.student(t, degrees), chance, 4)

    def test_groups(self):
        """Groups of one population differ by chance only; shifted ones are told."""
        chances = [compare.differ([RNG.normal(size=5) for _ in range(4)], seed) for seed in range(60)]
        self.assertAlmostEqual(numpy.mean(chances), 0.5, delta=0.12)
        self.assertLess(compare.differ([RNG.normal(size=5) + 3 * k for k in range(3)]), 0.01)
        self.assertTrue(numpy.isnan(compare.differ([[1.0], [2.0]])))

    def test_together(self):
        self.assertAlmostEqual(compare.together([0.05]), 0.05, 6)
        found = [compare.together(RNG.random(2)) for _ in range(400)]
        self.assertAlmostEqual(numpy.mean(numpy.array(found) < 0.1), 0.1, delta=0.05)
        self.assertTrue(numpy.isnan(compare.together([numpy.nan])))

    def test_exponent(self):
        x = numpy.repeat([40, 80, 160.0], 6)
        found = [compare.exponent(x, x ** -1 * numpy.exp(0.3 * RNG.normal(size=18))) for _ in range(300)]
        b, error, degrees = numpy.array(found).T
        self.assertAlmostEqual(b.mean(), -1, delta=0.03)
        self.assertAlmostEqual(error.mean() / b.std(), 1, delta=0.15)
        self.assertEqual(degrees[0], 16)

    def test_scans(self):
        """Each aim passes and fails as it should."""
        def groups(values, law, scatter=0.15, count=6):
            return {x: law(x) * numpy.exp(scatter * RNG.normal(size=count)) for x in values}

        values = (40, 80, 160.0)
        for aim, law, verdict in ((-1.0, lambda x: 1 / x, YES), (-1.0, lambda x: x, NO), (0.0, lambda x: 1, YES),
                                  (0.0, lambda x: x, NO), ("-", lambda x: 1 / x, YES), ("-", lambda x: x, NO),
                                  ("changes", lambda x: x, YES), ("alike", lambda x: x, NO)):
            judge = scans.judge_groups if aim in ("changes", "alike") else scans.judge_exponent
            found = [judge(aim, {0.7: groups(values, law), 2: groups(values, law)})[0] for _ in range(8)]
            self.assertGreater(found.count(verdict), 5, f"{aim} {found}")
        self.assertEqual(scans.judge_groups("alike", {2: {x: [1.0] for x in values}})[0], OPEN)

    def test_rows_of_scans(self):
        """What was varied in a run, and to which scans it belongs."""
        def row(entry, disks=60, **known):
            run = types.SimpleNamespace(parameters=known, radius=numpy.full(4, 0.02), y_end=numpy.zeros(4), seed=1,
                                        n_free=disks, measured=30.0, rms=0.1, median=0.05, significant=1.0,
                                        halves=lambda: (numpy.arange(4.0), numpy.arange(4.0)), sliding_fraction=0.5,
                                        openings_per_period=lambda frequency: 8 / frequency, coordination=3.0, wander=0)
            return scans.row_of(entry, "random", run)

        rows = [row("scan", mu=0.3, drive=2.0), row("scan", frequency=40.0, drive=0.7),
                row("scan", k_t=3700.0, drive=2.0), row("prepared", then="tap", drive=2.0),
                row("prepared", made="front", drive=2.0),
                row("size", 240, width=0.4, drive=2.0), row("size", 240, width=1.6, drive=2.0),
                row("size", width=0.4, drive=2.0), row("shake_1e4", 10000)]
        self.assertEqual(rows[1]["openings"], 0.2)
        found = {scan.key: list(scans.points_of(scan, rows)) for scan in scans.SCANS}
        self.assertEqual(found, {"mu": [(2.0, 0.1), (2.0, 0.3)], "stiffness": [(2.0, 0.37), (2.0, 0.5)],
                                 "frequency": [(0.7, 40.0), (2.0, 80.0)],
                                 "preparation": [(2.0, "rain"), (2.0, "front"), (2.0, "shaken down")],
                                 "depth": [(2.0, 60), (2.0, 240)], "width": [(2.0, 10.0), (2.0, 40.0)],
                                 "number": [(2.0, 60), (2.0, 10000)]})

    def test_large_is_asked_for(self):
        """A hundred thousand disks are neither run nor missing unless they are asked for."""
        with tempfile.TemporaryDirectory() as folder:
            for large in (False, True):
                campaign = Campaign(folder, program=PROGRAM, large=large)
                self.assertEqual("deposit_1e5" in [name for name, _ in campaign._order()], large)
                self.assertEqual(campaign.missing("shake_1e5"), ["shake_1e5: not finished"] if large else [])

    def test_depths(self):
        """Below the highest disk beside it, in mean diameters."""
        x, y = numpy.array([0, 0, 0, 5.0]), numpy.array([0, 1, 2, 0.0])
        self.assertEqual(list(depths.depths(x, y, numpy.full(4, 0.5))), [2.5, 1.5, 0.5, 0.5])


def box(omega, error, drive=1.0, replica=0, **more):
    """A made-up packing: disks in four contacts that slide, the same rotation in both halves."""
    omega = numpy.asarray(omega, float)
    n = len(omega)
    columns = {name: numpy.ones(n) for name in disks.COLUMNS}
    columns |= {"omega": omega, "error": numpy.broadcast_to(numpy.asarray(error, float), n).copy(), "omega_first": omega,
                "omega_second": omega, "persistent": numpy.full(n, 4.0), "radius": numpy.full(n, 0.02)}
    columns |= {name: numpy.asarray(values, float) for name, values in more.items()}
    whole = {"drive": drive, "replica": float(replica), "seed": 1.0, "measured": 100.0, "openings": 8.0, "sliding": 0.3,
             "coordination": 3.5, "wander": 1e-3, "drift": 1e-3, "farthest": 0.1, "noise": 1e-3}
    return disks.Box(whole, columns)


def packings(still, error=1e-4, n=60, count=6, **more):
    """Packings of which a part of the disks does not turn but for its error bar."""
    return [box(numpy.where(numpy.arange(n) < round(still * n), error * RNG.normal(size=n), RNG.choice([-1, 1], n)
                            * RNG.uniform(0.5, 2, n)), error, replica=k, **more) for k in range(count)]


class Shares(unittest.TestCase):
    def test_share(self):
        """Its error is that of independent disks where packings are alike, and larger where they are not."""
        alike, unlike = [(30, 60)] * 6, [(10, 60), (50, 60)] * 3
        self.assertEqual(statistics.share(alike)[0], 0.5)
        self.assertAlmostEqual(statistics.share(alike)[1], 0.5 / 360 ** 0.5, 4)
        self.assertGreater(statistics.share(unlike)[1], 3 * statistics.share(alike)[1])
        self.assertGreater(statistics.share([(0, 60)] * 3)[1], 0)  # none found is not none there
        self.assertTrue(numpy.isnan(statistics.share([])[0]))

    def test_two_sided(self):
        self.assertLess(statistics.two_sided(137.7, 220), 1e-5)  # error bars that are too large are found, too
        self.assertLess(statistics.two_sided(330, 220), 1e-5)
        self.assertGreater(statistics.two_sided(219, 220), 0.5)

    def test_weighted_power(self):
        """Points with large scatter count little; the error is what repeated noise makes of the exponent."""
        x, noise = numpy.array([0.1, 0.2, 0.5, 1, 2]), numpy.array([1.0, 0.5, 0.1, 0.1, 0.1])
        fits = []
        for _ in range(200):
            curves = [dict(zip(x, 3 * x ** 1.7 * numpy.exp(noise * RNG.normal(size=5)))) for _ in range(6)]
            fits.append(statistics.weighted_power(curves, x))
        found = numpy.array([(fit.exponent, fit.error, fit.weights) for fit in fits])
        self.assertAlmostEqual(found[:, 0].mean(), 1.7, delta=0.02)
        self.assertAlmostEqual(found[:, 1].mean() / found[:, 0].std(), 1, delta=0.4)  # of six packings it is too large
        self.assertAlmostEqual(found[:, 2].mean() / found[:, 0].std(), 1, delta=0.35)
        bent = [{point: point ** 2 + 0.05 * (1 + 0.01 * RNG.normal()) for point in x} for _ in range(6)]
        self.assertLess(statistics.weighted_power(bent, x).chance, 1e-3)
        self.assertEqual(statistics.weighted_power([{0.1: 1.0}], [0.1]).points, 0)  # one point of one packing: no fit
        str(statistics.weighted_power([], []))


class Each(unittest.TestCase):
    def verdict(self, found):
        return each.claim(found, 1.0, "each-disk-1").verdict

    def test_verdicts(self):
        self.assertEqual(self.verdict(packings(0)), YES)
        self.assertEqual(self.verdict(packings(0.4)), NO)
        self.assertEqual(self.verdict(packings(0.05)), OPEN)  # a few only
        self.assertEqual(self.verdict(packings(0.4, error=1)), OPEN)  # error bars as large as what is to be seen
        self.assertEqual(self.verdict([]), OPEN)

    def test_rattlers_do_not_count(self):
        """Disks that stand still and are loose refute nothing."""
        loose = numpy.where(numpy.arange(60) < 24, 1.0, 4.0)
        found = packings(0.4, persistent=loose)
        self.assertEqual(self.verdict(found), YES)
        self.assertEqual(each.census(found)["loose"][0], 0.4)
        self.assertEqual(each.census(found)["disks"], 216)

    def test_regimes(self):
        """Drives are sorted by openings, and all of a regime count together."""
        table = {0.1: packings(0.5), 2.0: packings(0), 9.0: packings(0)}
        for drives, openings in (((0.1,), 0.8), ((2.0, 9.0), 160)):
            for at in drives:
                for one in table[at]:
                    one.whole["openings"] = openings
        self.assertEqual([claim.verdict for claim in each.regimes(table)], [NO, YES])
        self.assertEqual([claim.verdict for claim in each.regimes({2.0: table[2.0]})], [OPEN, YES])

    def test_kinds(self):
        """Disks that never slide, that slide without turning, and undecided ones are told apart."""
        one = box([1, 0, 0, 0.5], [1e-3, 1e-3, 1e-3, 1], friction=[1, 0, 1, 1])
        self.assertEqual(list(each.kind_of(one)), [each.TURNS, each.STICKS, each.SLIDES, each.UNSEEN])

    def test_lasting(self):
        """A rotation that has died out, or has turned round, does not last."""
        one = box([1, 1, 1, 1], 1e-3, omega_first=[1, 2, -1, 1], omega_second=[1, 0.1, 1, 0.7])
        self.assertEqual(each.lasting([one])[0], 0.5)

    def test_smooth(self):
        """Disks within their errors, as many as a smooth distribution has there, are no sign that some stand still."""
        smooth = [box(RNG.normal(size=100), 0.05, replica=k) for k in range(24)]
        self.assertLess(each.census(smooth)[each.TURNS][0], 0.92)
        self.assertEqual(self.verdict(smooth), YES)
        for one in smooth:
            one["omega"][:25] = 0.05 * RNG.normal(size=25)
        self.assertEqual(self.verdict(smooth), OPEN)
        self.assertGreater(each.excess(smooth)[0], 3 * each.excess(smooth)[1])

    def test_chance(self):
        """Two in a hundred beyond three errors are no rotation."""
        found = packings(1.0, n=200)
        counts = each.census(found)
        self.assertLess(counts[each.TURNS][0], disks.CHANCE)
        self.assertIn("(0 % without", each.words(counts))


class Quiet(unittest.TestCase):
    def rows(self, turning, opened=0):
        n = numpy.arange(60)
        made = []
        for drive in (0.03, 0.2):
            found = [box(numpy.where(n < 60 * turning * (drive > 0.1), 1.0, 1e-6), 1e-3, drive, k,
                         openings=numpy.where(n < opened, 4.0, 0.0)) for k in range(4)]
            made.append(quiet.row("quiet", 1e5, drive, found))
        return made

    def test_openings(self):
        self.assertEqual(quiet.no_openings(self.rows(0.5)).verdict, YES)
        self.assertEqual(quiet.no_openings(self.rows(0.5, opened=1)).verdict, NO)

    def test_turning_without_openings(self):
        self.assertEqual(quiet.without_openings(self.rows(0.5)).verdict, YES)
        self.assertEqual(quiet.without_openings(self.rows(0)).verdict, NO)
        self.assertEqual(quiet.without_openings(self.rows(0.5, opened=30)).verdict, NO)  # those that open do not count

    def test_fades(self):
        self.assertEqual(quiet.vanishes(self.rows(0.5)).verdict, YES)
        self.assertEqual(quiet.vanishes(self.rows(0.5)[::1][:1]).verdict, OPEN)
        backwards = self.rows(0.5)
        backwards[0]["drive"], backwards[1]["drive"] = 0.2, 0.03
        self.assertEqual(quiet.vanishes(backwards).verdict, NO)


class Growth(unittest.TestCase):
    def claims(self, exponent, scatter=0.1):
        drives = numpy.array([0.1, 0.2, 0.3, 1, 2, 4])
        table = {d: [box(d ** exponent * numpy.exp(scatter * RNG.normal()) * RNG.choice([-1, 1], 40), 1e-6, d, k)
                     for k in range(6)] for d in drives}
        return {claim.slug: claim.verdict for claim in drive.growth(table, drives, 0.5)}

    def test_growth(self):
        self.assertEqual(self.claims(2), {"drive-rms": YES, "drive-median": YES})
        self.assertEqual(self.claims(-2), {"drive-rms": NO, "drive-median": NO})
        self.assertEqual(self.claims(0.1, scatter=1), {"drive-rms": OPEN, "drive-median": OPEN})

    def test_median_within_its_error(self):
        """Where half of the disks stand still the median is no rotation, and is not fitted."""
        self.assertEqual(drive.seen(packings(0.6)[0]), 0)
        self.assertGreater(drive.seen(packings(0.2)[0]), 0.1)


class Shape(unittest.TestCase):
    def setUp(self):
        self.rng = numpy.random.default_rng(2)

    def tails(self, draw):
        return {claim.slug: claim.verdict for claim in low.shape("low", *2 * [[draw(200) for _ in range(8)]])}

    def test_shape(self):
        self.assertEqual(self.tails(lambda n: self.rng.laplace(size=n)), {"low-symmetric": YES, "low-tails": YES})
        self.assertEqual(self.tails(lambda n: self.rng.uniform(-1, 1, n)), {"low-symmetric": YES, "low-tails": NO})
        self.assertEqual(self.tails(lambda n: self.rng.exponential(size=n))["low-symmetric"], NO)

    def test_tails_of_turning_disks(self):
        """A half at rest makes tails wide; the half that turns is judged without it."""
        found = [box(numpy.concatenate([numpy.zeros(300), self.rng.uniform(-1, 1, 300)]), 1e-3, replica=k) for k in range(8)]
        scaled = [one["omega"] / one.rms for one in found]
        claim = low.shape("low", scaled, low.turning_scaled(found))[1]
        self.assertEqual(claim.verdict, NO)
        self.assertGreater(statistics.moments(numpy.concatenate(scaled))[3], 0.3)

    def test_higher(self):
        """Those that turn at the top, at the bottom, anywhere."""
        for slope, verdict in ((1, YES), (-1, NO), (0, OPEN)):
            found = packings(0.4)
            for one in found:
                one.columns["height"] = 0.5 + slope * 0.1 * one.turns + 0.01 * self.rng.normal(size=60)
            self.assertEqual(low.deeper("low", found).verdict, verdict)

    def test_halves(self):
        """The same in both halves, and drawn anew."""
        same = packings(0)
        self.assertEqual([low.persists("low", same).verdict, low.ranked("low", same).verdict], [YES, YES])
        anew = [box(b["omega"], 1e-3, omega_second=RNG.permutation(b["omega"])) for b in packings(0)]
        self.assertEqual([low.persists("low", anew).verdict, low.ranked("low", anew).verdict], [NO, NO])


class Energy(unittest.TestCase):
    def test_friction(self):
        found = packings(0)
        for sign, verdict in ((1, YES), (-1, NO)):
            for one in found:
                one.columns["friction"] = 2 + sign * numpy.tanh(numpy.abs(one["omega"]) - 1)
            self.assertEqual(energy.friction("low", found).verdict, verdict)

    def test_level(self):
        """A cage is told from diffusion."""
        for exponent, verdict in ((0.0, YES), (0.8, NO)):
            points = {lag: (list(0.01 * lag ** exponent * (1 + 0.02 * RNG.normal(size=6))), []) for lag in (1, 2, 4, 8, 16)}
            self.assertEqual(energy.level("1 <i>g</i>", points).verdict, verdict)


class Flows(unittest.TestCase):
    def test_flanks(self):
        """A triangle of disks has the slope that it was made with."""
        slope = numpy.tan(numpy.radians(22))
        x, y = (a.ravel() for a in numpy.meshgrid(numpy.arange(-40, 41) + 3.0, 0.5 * numpy.arange(60)))
        inside = y < 20 - slope * numpy.abs(x - 3)
        angles, _ = flows.flanks(x[inside], y[inside], numpy.full(inside.sum(), 0.5))
        for angle in angles:
            self.assertAlmostEqual(angle, 22, delta=1)

    def test_beverloo(self):
        """The exponent is found within its error, and the error is neither zero nor everything."""
        width = numpy.array([4, 5, 6, 7, 8, 10, 12.0])
        rate = 0.7 * (width - 1.3) ** 1.5 * (1 + 0.01 * RNG.normal(size=7))
        a, a_error, k, k_error, factor, _, degrees = flows.beverloo(width, rate, 0.01 * rate)
        self.assertLess(abs(a - 1.5), 3 * a_error)
        self.assertLess(abs(k - 1.3), 3 * k_error)
        self.assertTrue(0.01 < a_error < 0.2, a_error)
        self.assertAlmostEqual(factor, 0.7, delta=0.3)
        self.assertEqual(degrees, 4)


@unittest.skipUnless(os.path.exists(PROGRAM), "the program is not built")
class Plans(unittest.TestCase):
    def call(self, *words):
        done = subprocess.run([PROGRAM, *map(str, words)], capture_output=True, text=True, check=False)
        self.assertEqual(done.returncode, 0, f"{words}\n{done.stderr}")
        return done.stdout

    def test_every_entry_can_be_run(self):
        """The program takes each deck with the keys of each level, but for files that other entries make."""
        for name, entry in plan.ENTRIES.items():
            for level in plan.LEVELS:
                keys = {**entry.keys, **(entry.quick if level == "quick" else {})}
                if any(callable(value) or "{folder}" in str(value) for value in keys.values()):
                    continue
                deck = ROOT / "inputs/packing" / entry.deck
                if entry.sweep:
                    self.assertGreater(int(self.call("sweep", deck, "--count", *overrides(keys))), 1, name)
                self.call("check", deck, "--brief", "--no-probe", *overrides(keys))


@unittest.skipUnless(os.path.exists(PROGRAM), "the program is not built")
class Campaigns(unittest.TestCase):
    DECK = """
dt = 1e-4; integrator = "verlet"; gravity = { g = 9.81; };
materials = ( { name = "grain"; k_n = 1e3; k_t = 5e2; gamma_n = 0.5; mu = 0.1; } );
container = { type = "box"; width = 0.2; height = 0.4; };
packings = ( { type = "random"; fraction = 0.3; group = "grains"; density = 3.57;
               sizes = "list"; radii = (0.015, 0.02, 0.025); y = (0, 0.2); } );
motions = ( { name = "shake"; wall = "floor"; coordinate = "y"; type = "harmonic"; acceleration = 1; frequency = 80; } );
phases = ( { name = "rest"; time = 0.3; motions = (); }, { name = "measure"; time = 0.5; } );
measure = { disks = true; };
sweep = { parameters = ( { path = "motions.shake.acceleration"; name = "drive"; values = (0.5, 1, 2); } ); replicas = 2; };
"""

    def test_end_to_end(self):
        """Made, read, drawn and kept; given again nothing is run; what is not there is said to be missing."""
        with tempfile.TemporaryDirectory() as folder:
            deck = os.path.join(folder, "tiny.cfg")
            with open(deck, "w") as file:
                file.write(self.DECK)
            entries = {**plan.ENTRIES, "low": Entry(deck, {"sweep.parameters.drive.values": "(0.5)"}), "drive": Entry(deck)}
            made = {}
            for turn in range(2):
                campaign = Campaign(os.path.join(folder, "out"), "default", PROGRAM, 2, strict=True, say=lambda _: None,
                                    entries=entries)
                campaign.make(["low", "drive"])
                self.assertEqual(campaign.failed, [])
                files = [*campaign.files("low"), *campaign.files("drive")]
                self.assertEqual(len(files), 8)
                times = {path: os.stat(path).st_mtime_ns for path in files}
                self.assertEqual(made.setdefault("times", times), times, f"run again at call {turn}")
            run = campaign.runs("low")[0]
            self.assertEqual(run.parameters["drive"], 0.5)
            self.assertTrue(all(numpy.isfinite(column).all() for column in (run.omega, *run.halves())))
            self.assertGreater(run.rms, 0)
            self.assertLess(abs(run.residual), 1e-2)
            self.assertGreater(run.openings_per_period(80), 0)
            path, counts = study.draw(campaign, keep=folder)
            self.assertEqual(campaign.failed, [])
            self.assertGreater(sum(counts.values()), 15)
            with open(os.path.join(folder, "packings_study.md")) as file:
                text = file.read()
            self.assertIn("](figures/packings/halves-low.png)", text)
            self.assertTrue(os.path.getsize(os.path.join(folder, "figures/packings/map-low.png")) > 100)
            with open(path) as file:
                self.assertIn("hopper: 0 of", file.read())


if __name__ == "__main__":
    unittest.main(verbosity=1)
