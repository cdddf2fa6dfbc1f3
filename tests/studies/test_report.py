"""The report of tools/studies/ratchet.sh: fits, verdicts, the page, and the table of what is run at each level."""
import html.parser
import os
import pathlib
import subprocess
import sys
import tempfile
import unittest
import zlib

import numpy

ROOT = pathlib.Path(os.environ.get("SLIPDISK_SOURCE_DIR", pathlib.Path(__file__).resolve().parents[2]))
PROGRAM = os.environ.get("SLIPDISK_PROGRAM", str(ROOT / "build/release/slipdisk"))
sys.path.insert(0, str(ROOT / "tools/studies"))
sys.dont_write_bytecode = True

from ratchet import __main__ as report  # noqa: E402
from ratchet import configurations, effort, errors, fits, levels, markdown, page, turning, verdict, vibration  # noqa: E402
from ratchet import (mechanism_noise, mechanism_portrait, mechanism_scan, mechanism_size, mechanism_tep,  # noqa: E402
                    mechanism_theory)
from ratchet.data import Table  # noqa: E402
from ratchet.page import Numbers, Page, Section  # noqa: E402
from ratchet.runs import Results, overrides  # noqa: E402
from ratchet.style import plt  # noqa: E402

plt.rcParams["savefig.dpi"] = 30  # what is drawn is not looked at here
PI = numpy.pi


class Reader(html.parser.HTMLParser):
    """Checks that elements are closed in order, that ids are unique, and that nothing outside is referred to."""
    VOID = {"meta", "img", "br", "link", "input", "hr"}

    def __init__(self):
        super().__init__()
        self.open, self.ids, self.targets, self.text = [], [], [], []

    def handle_starttag(self, tag, attributes):
        for name, value in attributes:
            if name == "id":
                assert value not in self.ids, f"id {value} twice"
                self.ids.append(value)
            if name == "src":
                assert value.startswith("data:"), value[:60]
            if name == "href":
                assert value.startswith(("data:", "#")), value[:60]
                self.targets += [value[1:]] if value.startswith("#") else []
            if tag == "img" and name == "alt":
                assert value
        assert tag != "img" or "alt" in dict(attributes), "an image without alt"
        assert tag not in ("script", "link"), tag
        if tag not in self.VOID:
            self.open.append(tag)

    def handle_endtag(self, tag):
        assert self.open and self.open[-1] == tag, f"</{tag}> where {self.open[-1:]} is open"
        self.open.pop()

    def handle_data(self, data):
        self.text.append(data)

    def close(self):
        super().close()
        assert not self.open, self.open
        assert set(self.targets) <= set(self.ids), set(self.targets) - set(self.ids)


def read_page(path):
    reader = Reader()
    with open(path) as file:
        reader.feed(file.read())
    reader.close()
    return " ".join("".join(reader.text).split())


class Synthetic(Results):
    """Results made up from formulas instead of runs. sign: -1 turns all rotation round; replicas: of the tilt curve."""

    def __init__(self, folder, sign=1, unfinished=0, replicas=0):
        super().__init__(folder, "full" if replicas else "default", "/bin/false", dry=True, strict=True)
        self.sign, self.unfinished, self.replicas = sign, unfinished, replicas

    def _row(self, name, omega, error, **parameters):
        row = {"name": name, "status": "done", "set": float(zlib.crc32(name.encode())),
               "upper.omega": self.sign * omega, "upper.omega_error": error,
               "upper.scaled": self.sign * omega / 5 ** 0.5,
               "upper.scaled_error": error / 5 ** 0.5, "upper.left.sliding": 0.8, "upper.right.sliding": 0.9,
               "upper.transient": 0.0, "upper.converged": 1.0, "residual": 1e-9, "steps": 5e8, "time": 500.0,
               "upper.open": 0.0, "upper.stick": 0.2, "upper.pp": 0.2, "upper.pm": 0.2, "upper.mp": 0.2,
               "upper.mm": 0.2}
        for side in ("left", "right"):
            row.update({f"upper.{side}.openings": 0.0, f"upper.{side}.force_min": 0.2})
        return {**row, **parameters}

    def sweep(self, name):
        rows = []
        if name == "random":
            for eps in (2e-5, 6e-5, 1e-4):
                for tilt in numpy.linspace(0, 0.1, 11) * PI:
                    rows.append(self._row(f"tilt={tilt:g},eps_b={eps:g}", -4e4 * eps ** 2
                                          * numpy.sin(tilt / (0.12 * PI) * PI), 1e-6, tilt=tilt, eps_b=eps))
        elif name == "random_replicas" and self.replicas:
            rng = numpy.random.default_rng(2)
            for row in self.sweep("random").rows:
                for replica in range(self.replicas):
                    off = 1e-6 * rng.normal()
                    rows.append({**row, "replica": float(replica), "upper.omega": row["upper.omega"] + off,
                                 "upper.scaled": row["upper.scaled"] + off / 5 ** 0.5})
        elif name in ("sync", "async"):
            for theta in (0.01, 0.1):
                for tilt in numpy.linspace(0, 0.08, 5) * PI:
                    size = 4 / PI * 0.1 * numpy.tan(tilt) if name == "sync" else -0.05 * tilt / (0.04 * PI)
                    rows.append(self._row(f"theta_b={theta:g},tilt={tilt:g}", size * theta * 20 * PI, 1e-9, tilt=tilt,
                                          theta_b=theta))
        missing = [f"{name} {row['name']}: waiting" for row in rows[:self.unfinished]]
        return Table(rows[self.unfinished:], missing)

    def run(self, name):
        return None

    def theory(self, name, deck, **keys):
        rows = []
        for row in self.sweep(name.split("-")[-1]).rows if name.startswith("points-") else []:
            rows.append({"name": row["name"], "first_order": 1.3 * row["upper.omega"], "mean": 1.3 * row["upper.omega"],
                         "limit": row["upper.omega"]})
        return Table(rows)


class Mechanism(unittest.TestCase):
    """Permanent sliding under random drive: closed forms."""

    def test_torques(self):
        """(15)-(18), and the zero of (19)."""
        tilt, theta, mu = 0.1, 0.5, 0.2
        found = mechanism_theory.torques(mechanism_theory.System(theta, tilt, mu))
        for sign, same, mixed in ((1, "pp", "pm"), (-1, "mm", "mp")):
            self.assertAlmostEqual(found[same], sign * mu * (numpy.cos(tilt) + sign * mu * numpy.sin(tilt))
                                   / ((1 + mu ** 2) * numpy.cos(theta)), 13)
            self.assertAlmostEqual(found[mixed], sign * mu * numpy.sin(tilt)
                                   / (numpy.sin(theta) + sign * mu * numpy.cos(theta)), 13)
        zero = mechanism_theory.slight_tilt_zero(mu)
        self.assertAlmostEqual(sum(mechanism_theory.torques(mechanism_theory.System(zero, 1e-3, mu)).values()), 0, 12)

    def test_alternating(self):
        """(30), and the limit of physics.md for opposite phases."""
        system = mechanism_theory.System(tilt=0.04 * PI)
        self.assertAlmostEqual(mechanism_theory.alternating(system, 0), 4 / PI * 0.1 * numpy.tan(system.tilt), 13)
        self.assertAlmostEqual(mechanism_theory.alternating(system, PI), -0.04776, 5)

    def test_quadrants(self):
        """The arcsine law at Omega = 0, products without correlation, and a sum of one."""
        for rho in (-1.0, -0.4, 0.0, 0.9, 1.0):
            parts = mechanism_theory.quadrants(numpy.array([[1, 2 * rho], [2 * rho, 4]]))
            self.assertAlmostEqual(parts["pp"], 0.25 + numpy.arcsin(rho) / (2 * PI), 12)
            self.assertAlmostEqual(sum(parts.values()), 1, 12)
        parts = mechanism_theory.quadrants(numpy.diag([1.0, 4.0]), 1.0)
        self.assertAlmostEqual(parts["pp"], mechanism_theory.normal(-1) * mechanism_theory.normal(-0.5), 12)

    def test_one_signal(self):
        """Both supports turn by one signal: P(w > Omega) is the fraction of S++ that balances the torques."""
        system = mechanism_theory.System(tilt=0.06 * PI)
        drive = mechanism_theory.Drive(1e-3, coordinates=("theta",), own=False)
        omega = mechanism_theory.predicted(system, drive) / (drive.eps * drive.omega)
        self.assertAlmostEqual(mechanism_theory.normal(-omega), (1 - 0.1 * numpy.tan(system.tilt)) / 2, 5)

    def test_rigid_supports(self):
        """Stiff disks: the centre goes where both distances stay as they are."""
        system = mechanism_theory.System(k_n=1e9, gamma_n=1e4)
        s, c = 0.5, 0.75 ** 0.5
        found = mechanism_theory.covariance(system, mechanism_theory.Drive()) / (1e-4 * 20 * PI) ** 2
        self.assertAlmostEqual(found[0, 0], 1 + (1 / c ** 2 + 1 / s ** 2) / 2, 2)
        self.assertAlmostEqual(found[0, 1], (1 / s ** 2 - 1 / c ** 2) / 2, 2)

    def test_nothing_there(self):
        with tempfile.TemporaryDirectory() as folder:
            results = Results(folder, "full", "/bin/false", dry=True, strict=True)
            results.store.kept = ""
            for module in (mechanism_tep, mechanism_size, mechanism_noise, mechanism_scan, mechanism_portrait):
                claims = [claim for section in module.sections(results) for claim in section.claims]
                self.assertEqual({claim.verdict for claim in claims} - {verdict.OPEN}, set(), module.__name__)
        plt.close("all")


class Fits(unittest.TestCase):
    def test_extremum(self):
        """A known extremum is found, and the error bar is the scatter of what is found."""
        x = numpy.linspace(0, 0.1, 11)
        true, found, said = 0.1 / numpy.sqrt(3), [], []
        rng = numpy.random.default_rng(3)
        for _ in range(30):
            y = -(x - x ** 3 / 0.1 ** 2) + rng.normal(size=len(x)) * 1e-3
            e = fits.extremum(x, y, numpy.full(len(x), 1e-3), samples=60)
            found.append(e.position)
            said.append(e.error)
            self.assertGreater(e.inside, 0.97)
        self.assertLess(abs(numpy.mean(found) - true), 3 * numpy.std(found) / 30 ** 0.5 + 1e-4)
        self.assertLess(abs(numpy.mean(said) / numpy.std(found) - 1), 0.5)

    def test_extremum_of_a_steep_rise(self):
        x = numpy.linspace(0, 0.1, 11)
        e = fits.extremum(x, -x / (1 + (x / 0.012) ** 2), numpy.full(len(x), 1e-4), samples=30)
        self.assertEqual(e.form, "quotient")
        self.assertAlmostEqual(e.position, 0.012, delta=3e-4)

    def test_power_law(self):
        """Exponents found from scattered points are as far from the true one as their errors say."""
        x, rng = numpy.array([2.0, 4.0, 6.0, 8.0, 10.0]), numpy.random.default_rng(4)
        y = 0.3 * x ** 0.8
        off = []
        for _ in range(60):
            law = fits.power_law(x, y * (1 + 0.02 * rng.normal(size=5)), 0.02 * y)
            off.append((law.exponent - 0.8) / law.error)
        self.assertTrue(0.75 < numpy.std(off) < 1.25 and abs(numpy.mean(off)) < 0.4, (numpy.std(off), numpy.mean(off)))
        self.assertGreater(fits.power_law(x, numpy.minimum(y, 1.1), 0.02 * y).chi2, 20)
        self.assertIsNone(fits.power_law(x[:2], y[:2], y[:2]))

    def test_no_extremum_inside(self):
        x = numpy.linspace(0, 0.1, 11)
        self.assertLess(fits.extremum(x, -x - 3 * x ** 3, numpy.full(len(x), 1e-4), samples=60).inside, 0.05)
        self.assertIsNone(fits.extremum(x[:4], x[:4], numpy.ones(4)))

    def test_crossing(self):
        x = numpy.linspace(0, 1, 11)
        place, error = fits.crossing(x, numpy.cos(2 * x), numpy.full(len(x), 1e-3))
        self.assertAlmostEqual(place, PI / 4, delta=5e-4)
        self.assertTrue(1e-4 < error < 5e-3, error)
        self.assertIsNone(fits.crossing(x, 1 + x))


class Data(unittest.TestCase):
    TEXT = ("point,name,status,set,replica,eps,wave,upper.omega,upper.omega_error,message\n"
            "0,eps=1,done,0,0,1,sine,2,0.3,\n1,\"eps=1,r=1\",done,0,1,1,sine,4,0.4,\n2,eps=2,waiting,1,0,2,sine,,,\n"
            "3,eps=3,failed,2,0,3,sine,,,\"too large, it says\"\n")

    def test_table(self):
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "table.csv")
            pathlib.Path(path).write_text(self.TEXT)
            table = Table.read(path, label="random")
        self.assertEqual(table.missing, ["random eps=2: waiting", "random eps=3: failed, too large, it says"])
        row, = table.joined().rows
        self.assertEqual((row["upper.omega"], row["upper.omega_error"], row["replicas"]), (3.0, 0.25, 2.0))
        self.assertAlmostEqual(row["scatter"], 1.0)
        self.assertEqual(len(table.where(wave="sine", eps=1.0)), 2)
        self.assertEqual(len(Table.read("/nowhere/table.csv", label="x").missing), 1)


class Pages(unittest.TestCase):
    def draw(self, **more):
        with tempfile.TemporaryDirectory() as folder:
            path, counts = report.draw(Synthetic(folder, **more), modules=(vibration, turning, configurations))
            figures = os.listdir(os.path.join(folder, "figures"))
            return read_page(path), counts, figures

    def test_page(self):
        text, counts, figures = self.draw(unfinished=3)
        self.assertIn("random-ex-tilt.png", figures)
        self.assertIn("async-vel.pdf", figures)
        self.assertIn("random tilt=0,eps_b=2e-05: waiting", text)
        self.assertGreater(counts[verdict.YES], 10)

    def test_nothing_there(self):
        """A page can be drawn before anything has been run; axes that are logarithmic, too."""
        with tempfile.TemporaryDirectory() as folder:
            path, counts = report.draw(Results(folder, "full", "/bin/false", dry=True, strict=True),
                                       modules=(configurations,))
            self.assertIn("no data yet", read_page(path))
        self.assertEqual((counts[verdict.YES], counts[verdict.NO]), (0, 0))

    def test_verdicts_follow_the_data(self):
        """Rotation turned round: what was reproduced is not any more."""
        with tempfile.TemporaryDirectory() as folder:
            for sign, wanted in ((1, verdict.YES), (-1, verdict.NO)):
                claims = [claim for module in (vibration, turning)
                          for section in module.sections(Synthetic(folder, sign=sign)) for claim in section.claims]
                signs = {claim.slug: claim.verdict for claim in claims}
                self.assertEqual([signs[name] for name in ("random-clockwise", "sync-sign", "async-sign")],
                                 [wanted] * 3)
        plt.close("all")

    def test_replicas(self):
        """Means over replicas are drawn, the extremum's error shrinks, and single replicas agree with it."""
        with tempfile.TemporaryDirectory() as folder:
            one, five = (vibration.sections(Synthetic(folder, replicas=n)) for n in (0, 5))
        plt.close("all")
        places, more = one[1].tables[0].rows, five[1].tables[0].rows
        self.assertEqual([len(five[0].tables[0].rows), len(more)], [33, 3])
        for a, b in zip(places, more):
            self.assertTrue(numpy.isnan(a[-2]) and b[-1] == 5)
            self.assertLess(b[2], 0.7 * a[2])
            self.assertLess(abs(b[1] - b[-3]), 4 * b[-2] + 1e-4)
        self.assertTrue(all(row[-2] == 5 and row[3] < 1e-6 / 10 ** 0.5 * 0.64 for row in five[0].tables[0].rows))
        verdicts = {claim.text: claim for claim in five[1].claims}
        self.assertEqual(verdicts["Replicas scatter as their error bars say."].verdict, verdict.YES)
        self.assertNotIn("Replicas scatter as their error bars say.", [claim.text for claim in one[1].claims])

    def test_time_is_added_up(self):
        """Calls of a level add up, also those that another process takes up; other levels are not touched."""
        with tempfile.TemporaryDirectory() as folder:
            for call in range(2):
                ledger = effort.Ledger(folder, "full", jobs=2)
                ledger.call("a machine")
                ledger.begin("random", lambda call=call: (3 + call, 30.0))
                ledger.since -= 10
                ledger.tick(60)
                self.assertLess(ledger.seconds(), 10 * call + 1)
                ledger.end()
                self.assertAlmostEqual(ledger.seconds(), 10 * (call + 1), delta=1)
            effort.Ledger(folder, "quick").call("another")
            entry = effort.Ledger(folder, "full").read()
            results = Synthetic(folder, replicas=1)
            text = effort.told(results)
            results.size = lambda _: (33, 1e9)
            table = effort.sections(results)[0].tables[0]
        self.assertEqual((entry["calls"], entry["made_by"], entry["parts"]["random"]["found"]), (2, ["a machine"], 3))
        self.assertAlmostEqual(entry["parts"]["random"]["core_seconds"], 40, delta=2)
        self.assertIn("20 s (2 calls) by a machine", text)
        self.assertEqual(table.rows[0][:3], ["random", 3, 30])
        self.assertAlmostEqual(table.rows[0][-1], 40, delta=2)  # core-nanoseconds per step

    def test_one_broken_figure(self):
        """A figure that fails is reported and does not take the others with it."""
        class Broken:
            __name__ = "broken"

            @staticmethod
            def sections(_):
                raise ValueError("no <such> thing")

        class Good:
            @staticmethod
            def sections(_):
                return [Section("good", "Good")]

        with tempfile.TemporaryDirectory() as folder:
            results = Synthetic(folder)
            results.strict = False
            path, _ = report.draw(results, modules=(Broken, Good))
            text = read_page(path)
        self.assertIn("ValueError: no <such> thing", text)
        self.assertIn("Good", text)

    def test_csv(self):
        with tempfile.TemporaryDirectory() as folder:
            section = vibration.sections(Synthetic(folder))[0]
            Page(folder).add(section)
            with open(os.path.join(folder, "data", "table-random-ex-vel.csv")) as file:
                lines = file.read().splitlines()[1:]
        self.assertEqual(len(lines), 34)
        self.assertTrue(lines[0].startswith("θT/π,εb,tgΩ,error,S++"), lines[0])

    def test_markdown(self):
        with tempfile.TemporaryDirectory() as folder:
            section = vibration.sections(Synthetic(folder))[0]
            long = section.tables[0]  # 33 rows: a link to the CSV file
            section.tables.append(Numbers("The first rows", long.columns, long.rows[:5]))
            Page(folder).add(section)
            path, docs = os.path.join(folder, "report.md"), os.path.join(folder, "docs")
            markdown.write(path, "Title", ["Lead."], [section], data="data-full")
            markdown.keep(docs, path, ["random-ex-vel"], "paper.md", "figures", "data/paper")
            self.assertTrue(os.path.getsize(os.path.join(docs, "figures", "random-ex-vel.png")) > 100)
            with open(os.path.join(docs, "paper.md")) as file:
                lines = file.read().splitlines()
        tables = [line for line in lines if line.startswith("|")]
        self.assertEqual(sum(line.startswith("| **") for line in tables), len(section.claims))
        self.assertEqual(len(tables), len(section.claims) + 2 * len({claim.kind for claim in section.claims}) + 5 + 2)
        self.assertIn(f"![{section.figures[0].alt}](figures/random-ex-vel.png)", lines)
        self.assertTrue(any("33 rows, [table-random-ex-vel.csv](data/paper/table-random-ex-vel.csv)" in line for line in lines))
        for line in tables:  # as many cells as the head of the table
            self.assertIn(line.replace("\\|", "").count("|"), (4, len(page.shown_table(long)[0]) + 1), line)


class Study(unittest.TestCase):
    """Time to a given error, from made-up tables."""
    STEPS = (1e-6, 1e-5, 1e-4, 2e-4)

    def table(self, bias, noise, same=False):
        """bias(dt): relative change of Omega; noise: of one run, relative. same: the noise belongs to the seed."""
        rng, rows = numpy.random.default_rng(1), []
        seeds = rng.normal(size=8)
        for dt in self.STEPS:
            for integrator in ("gear5", "verlet"):
                for seed in range(8):
                    value = -1e-4 * (1 + bias(dt) + noise * (seeds[seed] if same else rng.normal()))
                    rows.append({"dt": dt, "h": dt, "integrator": integrator, "noise": float(seed), "ns_per_step": 10.0,
                                 "upper.scaled": value, "upper.scaled_error": 1e-4 * noise, "upper.measured": 100.0})
        return Table(rows)

    def test_limits(self):
        for bias, best in ((lambda dt: 0.1 * (dt > 5e-5), 1e-5), (lambda dt: 0, 2e-4),
                           (lambda dt: 0.1 * (dt > 5e-6), 1e-6)):
            for paired, noise in ((False, 0.02), (True, 0.2)):
                for series in errors.random_series("error_both", "", "dt", self.table(bias, noise, paired), paired):
                    self.assertEqual(series.best().dt, best)

    def test_noise_hides_a_change_unless_paired(self):
        table = self.table(lambda dt: 0.04 * (dt > 5e-5), 0.3, True)
        self.assertEqual(errors.random_series("error_step", "", "dt", table, True)[0].best().dt, 1e-5)
        loose = self.table(lambda dt: 0.04 * (dt > 5e-5), 0.3)
        self.assertEqual(errors.random_series("error_both", "", "dt", loose, False)[0].best().dt, 2e-4)

    def test_cost(self):
        """8 runs of 100 with errors of 2 %: 0.71 % in a time of 800, so 1 % in 400 and the start."""
        series = errors.random_series("error_both", "", "dt", self.table(lambda dt: 0, 0.02), False)[0]
        self.assertAlmostEqual(series.settings[0].cost / (401 * 1e6 * 10e-9), 1, delta=0.05)
        self.assertAlmostEqual(series.settings[0].cost / series.settings[2].cost, 100, delta=10)

    def test_turning(self):
        rows = []
        for dt in self.STEPS:
            for theta, change in ((0.004, 300.0), (0.04, 3.0)):
                rows.append({"dt": dt, "phase": 0.0, "integrator": "gear5", "theta_b": theta, "tilt": 0.1,
                             "ns_per_step": 20.0, "upper.omega": 0.1 * (1 - change * dt), "upper.omega_error": 1e-7,
                             "upper.measured": 60.0, "upper.transient": 10.0})
        series, = [s for s in errors.turning_series(Table(rows)) if s.settings]
        self.assertEqual(series.best().dt, 1e-5)
        self.assertAlmostEqual(series.settings[2].change, -0.0297, delta=1e-3)
        self.assertAlmostEqual(series.settings[0].cost, (0.5 + 10 + 0.1) / 1e-6 * 20e-9, delta=1e-4)

    def test_page(self):
        """The page is drawn from what is there, here nothing."""
        with tempfile.TemporaryDirectory() as folder:
            path, _ = report.draw(Results(folder, "errors", "/bin/false", dry=True, strict=True), keep=folder)
            self.assertIn("error_both", read_page(path))
            self.assertTrue(os.path.exists(os.path.join(folder, "errors.md")))


@unittest.skipUnless(os.path.exists(PROGRAM), "the program is not built")
class Levels(unittest.TestCase):
    def call(self, *words):
        done = subprocess.run([PROGRAM, *map(str, words)], capture_output=True, text=True, check=False)
        self.assertEqual(done.returncode, 0, f"{words}\n{done.stderr}")
        return done.stdout

    def test_sweeps(self):
        """Every sweep of every level is one that the program understands, and more is run at each level."""
        points = {}
        for name, (deck, plans) in levels.SWEEPS.items():
            self.assertLessEqual(set(plans), {*levels.LEVELS, *levels.STUDIES})
            for level, plan in plans.items():
                points[name, level] = int(self.call("sweep", ROOT / "inputs/paper" / deck, "--count",
                                                    *overrides({**plan.keys, **plan.points})))
        for name in levels.SWEEPS:
            counts = [points[name, level] for level in levels.LEVELS if (name, level) in points]
            self.assertEqual(counts, sorted(counts), name)
        self.assertEqual(points["random", "full"], 80)
        self.assertEqual(points["random_replicas", "full"], 135)
        self.assertEqual((points["sync", "full"], points["async", "full"]), (63, 63))

    def test_replicas_go_on_from_single_runs(self):
        """The first replica of each point is the point of the sweep without replicas, of the same seed."""
        with tempfile.TemporaryDirectory() as folder:
            deck = ROOT / "inputs/paper/random.cfg"
            short = overrides({"phases.settle.time": 1e-5, "phases.measure.steps": 10,
                               "sweep[0].parameters.eps_b.values": "(2e-5)",
                               "sweep[1].parameters.eps_b.values": "(2e-5)"})
            self.call("sweep", deck, "-o", folder, "--quiet", *short)
            before = {path.name: path.stat().st_mtime_ns for path in pathlib.Path(folder, "points").glob("*.h5")}
            self.call("sweep", deck, "-o", folder, "--quiet", *short, *overrides(levels.TWICE))
            after = {path.name: path.stat().st_mtime_ns for path in pathlib.Path(folder, "points").glob("*.h5")}
            table = Table.read(os.path.join(folder, "table.csv"))
        self.assertEqual((len(before), len(after)), (11, 22))
        self.assertEqual({name: after[name] for name in before}, before)
        self.assertEqual([len(part) for part in table.sets()], [2] * 11)

    def test_runs(self):
        for name, (deck, by_level, keys) in levels.RUNS.items():
            for level in levels.LEVELS:
                self.call("check", ROOT / "inputs" / deck, "--brief", "--no-probe",
                          *overrides({**keys, **by_level[level]}))

    def test_folders_are_not_mixed(self):
        """Points whose deck differs never share a folder; those of equal decks do."""
        decks = {}
        for level in (*levels.LEVELS, *levels.STUDIES):
            with tempfile.TemporaryDirectory() as folder:
                results = Results(folder, level, PROGRAM)
                for name, (deck, plans) in levels.SWEEPS.items():
                    if level in plans:
                        what = (deck, tuple(sorted(plans[level].keys.items())))
                        where = os.path.relpath(results.sweep_folder(name), folder)
                        self.assertEqual(decks.setdefault(where, what), what)

    def test_end_to_end(self):
        """Two runs are made, the rest is missing, and the page says so; a second call runs nothing."""
        with tempfile.TemporaryDirectory() as folder:
            for _ in range(2):
                results = Results(folder, "quick", PROGRAM, say=lambda _: None)
                results.make(["steady_pp", "weak"])
                self.assertEqual(results.failed, [])
            made = {path.stem for path in pathlib.Path(folder, "runs-quick").glob("*.h5")}
            self.assertEqual(made, {"steady_pp", "weak"})
            claims = {claim.text: claim for claim in report.statements.sections(results, [])[0].claims}
            steady = next(claim for text, claim in claims.items() if "sliding steadily" in text and "(15)" in text)
            self.assertEqual(steady.verdict, verdict.YES, steady.numbers)
            self.assertEqual(next(c for t, c in claims.items() if "sliding steadily" in t and "(16)" in t).verdict, verdict.OPEN)
            self.assertEqual(next(c for t, c in claims.items() if "Without sliding" in t).verdict, verdict.YES)
            self.assertGreater(len(results.sweep("random").missing), 10)


if __name__ == "__main__":
    unittest.main(verbosity=1)
