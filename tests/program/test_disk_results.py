"""Means of every disk: /summary/disks, the report, `info` of a finished and of an unfinished run, the table of a sweep."""
import csv
import json
import os
import signal
import unittest

import h5py
import numpy

from results_common import LONG, Folder, changed, run, start, wait_for

DECK = """
dt = 5e-5; integrator = "verlet"; seed = 3; gravity = { g = 9.81; };
materials = ( { name = "grain"; k_n = 1e4; k_t = 5e3; gamma_n = 0.5; mu = 0.2; } );
walls = ( { name = "cup"; type = "polyline"; points = ( (-0.1, 0.6), (-0.1, 0), (0.13, 0), (0.13, 0.6) ); } );
disks = ( { name = "nail"; x = -0.05; y = -0.5; radius = 0.02; density = 3.57; fixed = true; } );
disk_rows = ( { columns = ("x", "y", "radius"); density = 3.57; rows = (%s); } );
motions = ( { name = "shake"; wall = "cup"; coordinate = "y"; type = "harmonic"; amplitude = 4e-5; frequency = 80; } );
phases = ( { name = "rest"; time = 0.3; motions = (); }, { name = "measure"; time = 1; } );
measure = { disks = true; every = 5; rotation = (); };
checkpoint = 0.1;
sweep = { parameters = ( { path = "motions.shake.amplitude"; name = "drive"; values = (0, 4e-5); } ); replicas = 2; };
"""
MANY = 17000  # more than a checkpoint has means of
MANY_DECK = """
dt = 0.002; integrator = "verlet"; gravity = { g = 1; };
materials = ( { name = "grain"; k_n = 1000; k_t = 500; gamma_n = 1; mu = 0.3; } );
container = { type = "box"; width = 150; height = 150; };
packings = ( { type = "front"; count = %d; sizes = "uniform"; lower = 0.4; upper = 0.6; density = 1; } );
phases = ( { name = "go"; steps = 100000000; } );
measure = { disks = true; rotation = (); };
checkpoint = 0.1;
"""
ROWS = ", ".join(f"({-0.075 + 0.044 * (k % 5) + 0.003 * (k // 5 % 2)}, {0.022 + 0.043 * (k // 5)}, {0.016 + 0.002 * (k % 3)})"
                 for k in range(20))
MEANS = ("omega error significance omega_first omega_second turned x y rms displacement coordination sliding force openings "
         "injected viscous friction opening translation rotation").split()


def ranks(x):
    order = numpy.empty(len(x))
    order[numpy.argsort(x)] = numpy.arange(len(x))
    return order


class Means(Folder):
    def setUp(self):
        super().setUp()
        self.deck = self.folder / "cup.cfg"
        self.deck.write_text(DECK % ROWS)

    def info(self, path):
        out, _ = self.run_ok("info", path, "--json")
        return json.loads(out)["means"]

    def test_file_report_and_info(self):
        out, _ = self.run_ok("run", self.deck, "-o", self.result)
        told, _ = self.run_ok("info", self.result)
        with h5py.File(self.result) as file:
            group = file["summary/disks"]
            totals = dict(group.attrs)
            d = {name: group[name][:] for name in group}
            for name in group:
                self.assertTrue(group[name].attrs["unit"] and group[name].attrs["description"], name)
            state, energy = file["state"], dict(file["summary/energy"].attrs)
            self.assertEqual(sorted(d), sorted(["id", "converged", *MEANS]))
            self.assertEqual(list(d["id"]), list(range(1, 21)))  # disk 0 is fixed
            bins, length = int(state["mean_bins"][()]), int(state["mean_bin_steps"][()]) * 5e-5
            record = state["mean_bin"][:].reshape(20, -1)[:, :bins]
            contacts = state["contact_a"][:], state["contact_b"][:]
            measured = int(state["measured"][()]) * 5e-5
        half = bins // 2
        numpy.testing.assert_allclose(d["omega_first"], record[:, :half].mean(1) / length, rtol=1e-9, atol=1e-15)
        numpy.testing.assert_allclose(d["omega_second"], record[:, -half:].mean(1) / length, rtol=1e-9, atol=1e-15)
        omega = d["omega"]
        self.assertEqual((totals["disks"], totals["bins"], totals["looks"]), (20, bins, round(measured / 5e-5) // 5))
        rms = numpy.sqrt(numpy.mean(omega ** 2))
        deviation = (omega - omega.mean()) / omega.std(ddof=1)
        expected = {
            "omega_mean": omega.mean(), "omega_mean_error": omega.std(ddof=1) / 20 ** 0.5, "omega_rms": rms,
            "omega_rms_error": (omega ** 2).std(ddof=1) / 20 ** 0.5 / 2 / rms, "omega_median": numpy.median(abs(omega)),
            "omega_noise": numpy.sqrt(numpy.mean(d["error"] ** 2)), "significant": numpy.mean(abs(omega) > 3 * d["error"]),
            "reliable": d["converged"].mean(), "skewness": numpy.mean(deviation ** 3),
            "persistence": numpy.corrcoef(d["omega_first"], d["omega_second"])[0, 1],
            "persistence_rank": numpy.corrcoef(ranks(d["omega_first"]), ranks(d["omega_second"]))[0, 1],
            "coordination": d["coordination"].mean(),
            "sliding": (d["sliding"] * d["coordination"]).sum() / d["coordination"].sum(),
            "force": (d["force"] * d["coordination"]).sum() / d["coordination"].sum(),
            "openings": d["openings"].sum() / d["coordination"].sum(), "power_injected": d["injected"].sum(),
            "power_friction": d["friction"].sum(), "mean_rotation": d["rotation"].mean()}
        pairs = [(a - 1, b - 1) for a, b in zip(*contacts) if 0 < a <= 20 and 0 < b <= 20]
        self.assertGreater(len(pairs), 4)
        expected["neighbours"] = numpy.mean([omega[a] * omega[b] for a, b in pairs]) / rms ** 2
        for name, value in expected.items():
            numpy.testing.assert_allclose(totals[name], value, rtol=1e-9, atol=1e-18, err_msg=name)
            self.assertIn(name.replace("_error", ""), out)
        # the work is done in the measured phase alone; looks every 5 steps, 50 in a period
        self.assertAlmostEqual(totals["power_injected"] * measured / energy["work"], 1, delta=0.01)
        self.assertTrue(1.2 < totals["coordination"] < 5 and 0 < totals["displacement_rms"] < 1)
        for text in out, told:
            self.assertIn("means of 20 of 20 free disks", text)
            self.assertIn("fastest disks", text)
        means = self.info(self.result)
        self.assertEqual(means["id"], list(range(1, 21)))
        for name in MEANS:
            numpy.testing.assert_array_equal(numpy.array(means[name], float), d[name], name)
        for name, value in expected.items():
            self.assertAlmostEqual(means["totals"][name] / value, 1, 9, name)

    def test_unfinished_and_short(self):
        """An unfinished run tells what it has so far; its losses are those of the measured steps."""
        process = start("run", self.deck, "-D", "phases.measure.time=1e4", "-D", "phases.measure.series=10000000", "-o",
                        self.result)
        wait_for(lambda: self.checkpoints() and self.checkpoints()[0] > 12000 or process.poll() is not None)
        self.assertIsNone(process.poll())
        process.send_signal(signal.SIGTERM)
        process.communicate(timeout=LONG)
        means = self.info(self.result)
        self.assertEqual(len(means["omega"]), 20)
        self.assertTrue(0 < means["totals"]["power_friction"] < 1 and means["totals"]["power_viscous"] > 0)
        short, _ = self.run_ok("run", self.deck, "-D", "phases.measure.steps=12", "--force", "-o", self.result)
        self.assertIn("too short a record: there are no error bars", short)
        self.assertIsNone(self.info(self.result)["totals"]["significant"])
        status, _, _ = run("run", self.deck, "--quiet", "-D", "measure.disks=false", "--force", "-o", self.result)
        self.assertEqual(status, 0)
        self.assertIsNone(self.info(self.result))
        with h5py.File(self.result) as file:
            self.assertNotIn("disks", file["summary"])

    def check_many(self, means, file):
        """As the bins of the state in the file have them."""
        state = file["state"]
        n, bins, length = MANY, int(state["mean_bins"][()]), int(state["mean_bin_steps"][()]) * 0.002
        free = state["id"][:n]
        record = state["mean_bin"][:].reshape(n, -1)[:, :bins]
        half = bins // 2
        self.assertEqual((list(means["id"]), means["bins"]), (list(range(n)), bins))
        for name, part in ("omega_first", record[:, :half]), ("omega_second", record[:, -half:]):
            expected = numpy.empty(n)
            expected[free] = part.mean(1) / length
            numpy.testing.assert_allclose(numpy.array(means[name], float), expected, rtol=1e-9, atol=1e-12)
        omega = numpy.array(means["omega"], float)
        numpy.testing.assert_allclose(means["totals"]["omega_rms"], numpy.sqrt(numpy.mean(omega ** 2)), rtol=1e-9)
        return omega

    def test_many(self):
        """Of very many disks a checkpoint has the state alone: all that read it compute the means from it, a result has them."""
        deck = self.folder / "many.cfg"
        deck.write_text(MANY_DECK % MANY)
        process = start("run", deck, "-o", self.result)
        wait_for(lambda: self.checkpoints() and self.checkpoints()[0] > 4 or process.poll() is not None)
        self.assertIsNone(process.poll())
        process.send_signal(signal.SIGTERM)
        process.communicate(timeout=LONG)
        newest = self.parts / f"checkpoint-{self.checkpoints()[0]}.h5"
        means = self.info(self.result)
        with h5py.File(newest) as file:
            self.assertEqual(list(file["summary/disks"]), [])
            self.assertNotIn("fastest", file["summary"])
            self.assertEqual(file["summary/disks"].attrs["count"], MANY)
            omega = self.check_many(means, file)
        page, _ = self.run_ok("info", newest)
        self.assertRegex(page, f"means of {MANY} free disks over time .*: the result will have them, and info --json computes them now")
        self.run_ok("measure", newest, "--csv", self.folder)
        with open(self.folder / "means.csv", encoding="utf-8") as file:
            table = list(csv.DictReader(file))
        numpy.testing.assert_allclose([float(row["omega"]) for row in table], omega, rtol=1e-14)
        self.run_ok("view", newest, "-o", self.folder / "page.html")
        deck_told, _ = self.run_ok("info", newest, "--deck")
        self.assertIn("packings", deck_told)
        # a deck that cannot be read again takes no more than the means away
        with changed(newest) as file:
            del file["parameters/deck_full"]
            file["parameters/deck_full"] = "nonsense"
        status, page, err = run("info", "--json", newest)
        self.assertEqual((status, "energy" in json.loads(page), json.loads(page)["means"]), (0, True, None), err)
        self.assertIn("the means of every disk cannot be told", err)
        self.run_ok("run", deck, "--quiet", "--force", "-D", "phases.go.steps=20", "-o", self.result)
        with h5py.File(self.result) as file:
            d = {name: file["summary/disks"][name][:] for name in file["summary/disks"]}
            totals = dict(file["summary/disks"].attrs)
            self.check_many({**d, "bins": totals["bins"], "totals": totals}, file)
        pages = {run("measure", self.result, "--json", env={**os.environ, "OMP_NUM_THREADS": str(n)}) for n in (1, 2, 5)}
        self.assertEqual([status for status, _, _ in pages], [0])  # one page, whatever the threads

    def test_sweep(self):
        """The totals are columns of the tables; without drive nothing turns and nothing is injected."""
        folder = self.folder / "s"
        self.run_ok("sweep", self.deck, "--quiet", "-D", "phases.measure.time=0.2", "-o", folder)
        with open(folder / "table.csv", encoding="utf-8") as file:
            rows = list(csv.DictReader(file))
        self.assertEqual(len(rows), 4)
        for row in rows:
            drive, injected = float(row["drive"]), float(row["power_injected"])
            self.assertEqual(injected > 0, drive > 0)
            self.assertTrue(row["omega_rms"] and row["coordination"])
        with open(folder / "means.csv", encoding="utf-8") as file:
            means = list(csv.DictReader(file))
        self.assertEqual(len(means), 2)
        self.assertTrue(means[1]["omega_rms_error"] and means[1]["omega_rms_scatter"])
        self.assertIn("coordination", means[1])


if __name__ == "__main__":
    unittest.main(verbosity=1)
