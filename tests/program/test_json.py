"""JSON for programs: `check --json` says what the page says, `sweep --status --json` what --list says, `info` takes several files."""
import json
import math
import re
import unittest

import h5py

from results_common import ROOT, Folder, run

WATCHED = """
integrator = "verlet"; dt = 1e-3; gravity = { g = 10.0; };
materials = ( { name = "m"; k_n = 1e4; k_t = 5e3; gamma_n = 2.0; mu = 0.5; } );
walls = ( { name = "floor"; type = "line"; points = ((0.0, 0.0), (1.0, 0.0)); } );
disks = (
  { name = "a"; x = 0.0; y = 0.95; radius = 1.0; mass = 1.0; },
  { name = "b"; x = 2.5; y = 1.0; radius = 1.0; mass = 1.0; fixed = true; }
);
phases = ( { name = "settle"; steps = 1000; }, { name = "measure"; steps = 2000; } );
measure = { sliding = ( { disk = "a"; partners = ("floor", "b"); } ); };
"""
SWEEP = 'sweep = { parameters = ( { path = "disks.a.x"; values = (0, 0.1, 0.2); } ); };\n'


def no_nan(word):
    raise ValueError(f"{word} is no JSON")


class Json(Folder):
    def check(self, *words, status=0):
        found, out, err = run("check", *words, "--json")
        self.assertEqual((found, err), (status, ""))
        return json.loads(out, parse_constant=no_nan)

    def write(self, text):
        deck = self.folder / "deck.cfg"
        deck.write_text(text)
        return deck

    def test_check_says_what_the_page_says(self):
        deck = self.write(WATCHED)
        said = self.check(deck, "--brief")
        page, err = run("check", deck, "--brief")[1:]
        self.assertNotIn("full", said)
        self.assertEqual([f"{m['kind']}: {m['text']}" for m in said["messages"]], err.splitlines())
        self.assertEqual(len(said["messages"]), 2, err)
        step, overlap = said["time_step"], said["overlap"]
        for line in (f"# disks       {said['disks']}: {said['free']} free, 1 fixed",
                     f"shortest contact period {step['period']:.4g} ({step['period_of']})",
                     f"stable up to {step['limit']:.3g} ({step['limit_by']} of {step['limit_of']}, {step['integrator']})",
                     f"# overlap     at most {overlap['relative']:.3g} of the radius: disk \"a\" and wall \"floor\", force "
                     f"{overlap['force']:.3g}, {overlap['force'] / overlap['weight']:.3g} times the weight",
                     f"e = {said['restitution'][0]['e']:.4f} (a free disk on a fixed body",
                     f"# result      {said['result']['series']} rows of the series, {said['result']['frames']} frames",
                     f"# contacts    {said['contacts']} at the start",
                     "# watched     disk \"a\" and disk \"b\" begin 0.5 radii apart"):
            self.assertIn(line, page)
        self.assertAlmostEqual(overlap["depth"], 0.05, 12)
        self.assertAlmostEqual(said["watched"][1]["gap"], 0.5, 2)
        self.assertEqual([p["steps"] for p in said["phases"]], [1000, 2000])
        self.assertGreater(said["speed"]["run_seconds"], 0)
        self.assertIsNone(said["sweep"])
        self.assertIsNone(self.check(deck, "--no-probe")["speed"])

    def test_restitution_at_this_dt(self):
        """The range holds what impacts of the deck itself give, and the page tells it when it is off by more than 0.1 %."""
        dt, speed = 1e-4 * math.pi, 0.01
        text = """dt = {dt}; integrator = "{integrator}"; materials = ( {{ name = "m"; k_n = 1.0; {law} }} );
            disks = ( {{ name = "a"; x = 0; y = {y}; vy = -{speed}; radius = 1; mass = 1e-4; }} );
            walls = ( {{ type = "line"; points = ((-1, 0), (1, 0)); }} ); steps = 120; output = {{ series = 120; frames = 120; }};"""
        for integrator, law in (("gear5", "restitution = 0.8;"), ("verlet", "gamma_n = 1.414e-3;"),
                                ("gear5", "restitution = 0.5; limit_damping = false;")):
            def deck(part, steps):
                step = dt * 100 / steps  # a contact has about so many steps
                return self.write(text.format(dt=step, integrator=integrator, law=law, y=1 + part * step * speed, speed=speed))
            coarse = self.check(deck(0, 36), "--no-probe")["restitution"][0]
            nominal, (least, most) = coarse["e"], coarse["e_at_dt"]
            self.assertTrue(least < nominal - 0.001 and most > nominal + 0.001, (least, most))
            self.assertLess(most - least, 0.03)
            self.assertIn(f", {least:.4f} to {most:.4f} at this dt\n", run("check", deck(0, 36), "--brief", "--no-probe")[1])
            for part in 1 / 32, 21 / 32:
                self.run_ok("run", deck(part, 36), "--force", "-q", "-o", self.result)
                with h5py.File(self.result) as file:
                    e = file["particles/disks/velocity/value"][-1, 0, 1] / speed
                self.assertTrue(least - 1e-6 <= e <= most + 1e-6, (least, e, most))
            fine = self.check(deck(0, 2000), "--no-probe")["restitution"][0]
            self.assertLess(max(abs(e - fine["e"]) for e in fine["e_at_dt"]), 1e-3 * fine["e"])
            self.assertNotIn("at this dt", run("check", deck(0, 2000), "--brief", "--no-probe")[1])
        self.assertEqual(self.check(deck(0, 1e5), "--no-probe")["restitution"][0]["e_at_dt"], [None, None])

    def test_the_full_deck_is_a_deck(self):
        full = self.check(ROOT / "inputs/packing/jam.cfg", "--no-probe")["full"]
        again = self.check(self.write(full), "--no-probe")
        self.assertEqual(re.sub(" *# default", "", again["full"]), re.sub(" *# default", "", full))
        compress = again["phases"][0]["compress"]
        self.assertEqual((compress["fraction"], compress["pressure"]), (0.8, None))
        self.assertTrue(500 < compress["time"] < 1500, compress)

    def test_mistakes(self):
        said = self.check(self.write("dt = 1; stpes = 3;"), status=2)
        self.assertEqual(said["status"], 2)
        self.assertTrue(all(m["kind"] == "error" for m in said["messages"]))
        self.assertIn("did you mean", said["messages"][0]["text"])
        self.assertNotIn("time_step", said)

    def test_sweeps(self):
        deck, out = self.write(WATCHED + SWEEP), self.folder / "out"
        said = self.check(deck, "--brief")["sweep"]
        self.assertEqual((said["points"], said["steps"]), (3, 9000))
        run("sweep", deck, "-o", out, "--point", "0-1", "--quiet")
        for words in ["--status"], ["--list", "--skip"]:
            status, text, err = run("sweep", deck, "-o", out, *words, "--json")
            self.assertEqual(status, 0, err)
            there = json.loads(text, parse_constant=no_nan)
            self.assertEqual((there["count"]["done"], there["count"]["waiting"]), (2, 1))
            self.assertEqual([p["status"] for p in there["points"]], ["done", "done", "waiting"])
            self.assertEqual([p["progress"] for p in there["points"]], [1, 1, None])
            self.assertEqual([p["doubts"] for p in there["points"]], [["open"], ["open"], []])
            self.assertIn("with b was open 100 %", there["points"][0]["message"])
            self.assertEqual(there["points"][1]["rotation"][0]["name"], "a")
        status, _, err = run("sweep", deck, "-o", out, "--json")
        self.assertEqual(status, 2)
        self.assertIn("--json belongs to --status or --list", err)

    def test_info_of_several(self):
        deck = self.write(WATCHED)
        results = [self.folder / name for name in ("one.h5", "two.h5")]
        for result in results:
            run("run", deck, "--quiet", "-o", result)
        status, page, err = run("info", *results)
        self.assertEqual((status, err), (0, ""))
        single = [run("info", result)[1] for result in results]
        self.assertEqual(page, "\n".join(single))
        there = json.loads(run("info", "--json", *results)[1])
        self.assertEqual([one["file"] for one in there], [str(r) for r in results])
        self.assertEqual(there, [json.loads(run("info", "--json", r)[1]) for r in results])
        # one that is not there does not hide the others
        status, text, err = run("info", "--json", self.folder / "none.h5", *results)
        self.assertEqual(status, 2)
        self.assertIn("none.h5", err)
        self.assertEqual(json.loads(text), there)
        status, _, err = run("info", "--deck", *results)
        self.assertEqual(status, 2)
        self.assertIn("want one result", err)

    def test_size_is_warned_of(self):
        deck = self.write(WATCHED)
        words = "-D", "output.frames=1", "-D", "phases.measure.steps=1e12"
        said = [m["text"] for m in self.check(deck, "--no-probe", *words)["messages"]]
        self.assertTrue(any(re.match(r"the result will have about .* GB \(2001 rows of the series, 1000000001001 frames", t) for t in said), said)


if __name__ == "__main__":
    unittest.main()
