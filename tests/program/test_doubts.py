"""Results that are in doubt: told on stderr with --quiet, in /summary, `info`, the log, tables, and by exit status 5."""
import json
import os
import re
import signal
import subprocess
import unittest

import h5py

from results_common import DECK, Gate, PROGRAM, Folder, assert_same, run, start
from sweep_common import SweepTest, column, results, three_disks

IN_DOUBT = 5
SHORT = "-D", "integrator=gear5", "-D", "phases.settle.steps=5000", "-D", "phases.measure.steps=50000", "-D", "phases.measure.series=1000", \
    "-D", "limits.unstable_step=true"
UNCLOSED = "the energy budget does not close"
OPEN = "the watched contacts of upper were open 100 % of the time"
FAST = 'disk "upper" moves by '

BULLET = """
dt = 1e-3;
steps = 100;
integrator = "verlet";
materials = ( { name = "steel"; k_n = 1e5; k_t = 1e5; gamma_n = 10.0; mu = 0.3; } );
disks = (
  { name = "target"; x = 0; y = 0; radius = 0.5; mass = 1; fixed = true; },
  { name = "bullet"; x = -22.5; y = 0; vx = 5000; radius = 0.5; mass = 1; }
);
"""

WATCHED = """
integrator = "verlet"; dt = 1e-3; gravity = { g = 10.0; };
materials = ( { name = "m"; k_n = 1e4; k_t = 5e3; gamma_n = 2.0; mu = 0.5; } );
walls = ( { name = "floor"; type = "line"; points = ((0.0, 0.0), (1.0, 0.0)); } );
disks = (
  { name = "a"; x = 0.0; y = 1.0; radius = 1.0; mass = 1.0; },
  { name = "b"; x = 2.03; y = 1.0; radius = 1.0; mass = 1.0; fixed = true; }
);
phases = ( { name = "settle"; steps = 1000; }, { name = "measure"; steps = 2000; } );
measure = { sliding = ( { disk = "a"; partners = ("floor", "b"); } ); };
"""


class Doubts(Folder):
    def doubted(self, names, words, *, status=IN_DOUBT):
        """Runs quietly, and finds these doubts wherever they are told; returns what was said."""
        log = self.folder / "log"
        log.unlink(missing_ok=True)
        found, out, err = run("run", *words, "--quiet", "--force", "-o", self.result, "--log", log, "--threads", 1)
        self.assertEqual(found, status, err)
        self.assertEqual(out, "")
        self.assertFalse(self.parts.exists())
        warned = re.findall("warning: in doubt: (.*)", err)
        logged = re.findall("warning: in doubt: (.*)", log.read_text())
        self.assertEqual(logged, warned)
        found, out, told = run("info", "--json", self.result)
        self.assertEqual((found, told), (0, ""))
        doubts = json.loads(out)["doubts"]
        self.assertEqual([d["name"] for d in doubts], names)
        self.assertEqual([d["message"] for d in doubts], warned)
        for d in doubts:
            self.assertGreater(d["value"], d["limit"])
        with h5py.File(self.result) as file:
            group = file["summary/doubts"]
            self.assertEqual(group.attrs["count"], len(names))
            self.assertEqual(sorted(group), sorted(names))
            for d in doubts:
                stored = group[d["name"]].attrs
                self.assertEqual(stored["message"].decode() if isinstance(stored["message"], bytes) else stored["message"],
                                 d["message"])
                self.assertEqual((stored["value"], stored["limit"]), (d["value"], d["limit"]))
                self.assertIn("unit", stored)
                self.assertIn("description", stored)
        found, out, _ = run("info", self.result)
        self.assertEqual(found, 0)
        self.assertEqual("IN DOUBT" in out, bool(names))
        for line in warned:
            self.assertIn(f"\n  {line}\n", out)
        found, _, err = run("resume", self.result)
        self.assertEqual(found, 0, err)
        return warned

    def test_clean(self):
        self.assertEqual(self.doubted([], [DECK, *SHORT], status=0), [])

    def test_energy_budget(self):
        """dt beyond stability: with the issue's 2e-3 the residual is 0.9 of the scale."""
        words = [DECK, *SHORT, "-D", "dt=2e-3"]
        said = self.doubted(["residual", "unstable"], words)
        self.assertIn(UNCLOSED, said[0])
        said = self.doubted(["unstable"], [*words, "-D", "limits.residual=0"])
        self.assertRegex(said[0], "^dt = 0.002 is beyond the limit of stability .*: results mean nothing")
        self.doubted(["unstable"], [*words, "-D", "limits.residual=10"])
        self.doubted(["residual"], [DECK, *SHORT, "-D", "limits.residual=1e-15"])

    def test_thrown_off(self):
        said = self.doubted(["open", "displacement", "unstable"], [DECK, *SHORT, "-D", "dt=5e-3"])
        self.assertRegex(said[0], f"^{OPEN} \\(with left: it had opened before measuring began, and never closed, .* radii apart at the end, "
                                  "and with right: it had opened ")
        self.assertIn(FAST, said[1])
        self.doubted(["unstable"], [DECK, *SHORT, "-D", "dt=5e-3", "-D", "limits={open=1; displacement=0; unstable_step=true;}"])

    def test_bullet(self):
        """It passes through the target at 5 diameters a step."""
        deck = self.folder / "bullet.cfg"
        for integrator in "verlet", "gear5":
            deck.write_text(BULLET.replace("verlet", integrator))
            said = self.doubted(["displacement"], [deck])
            self.assertRegex(said[0], 'disk "bullet" moves by 10 of its radius in a step, after step 0,')
            with h5py.File(self.result) as file:
                self.assertEqual(file["state/fast_step"][()], 0)
                self.assertGreater(file["particles/disks/position/value"][-1][:, 0].max(), 100)
        deck.write_text(BULLET.replace("vx = 5000", "vx = 40"))
        self.doubted([], [deck], status=0)

    def test_walls_that_pass_through(self):
        """Walls and prescribed disks that go four radii in a step, or jump: whatever shape and motion; none of slow ones."""
        segment = 'type = "segment"; points = ((-9.0, -5.0), (9.0, -5.0));'
        moves, jumps = "moves by .* radii of the smallest disk in a step, after step %d, and may have passed", "jumps by 0.04 radii"
        far, later = moves % 0, moves % 1  # a servo begins at rest
        velocity = 'coordinate = "y"; type = "velocity"; velocity = %s;'
        for shape, motion, said in (
                (segment, velocity % "2e3", far), (segment, velocity % "40.0", None), (segment, velocity % "1e49", far),
                ('type = "line"; points = ((-9.0, -5.0), (9.0, -5.0));', velocity % "2e3", far),
                ('type = "arc"; center = (0.0, 45.0); radius = 50.0; from = -2.0; to = -1.0;', velocity % "2e3", far),
                ('type = "circle"; center = (5.0, -5.1); radius = 0.1; side = "outside";', velocity % "2e3", far),
                (None, velocity % "2e3", far), (None, velocity % "40.0", None),
                (segment, 'coordinate = "y"; type = "servo"; force = 10.0; speed = 2e3;', later),
                (segment, 'coordinate = "y"; type = "load"; mass = 1e-9; force = 1.0;', "moves by"),
                (segment, 'coordinate = "y"; type = "table"; times = (0.0, 1e-3, 1.1e-3, 1.0); values = (0.0, 0.0, 9.0, 9.0);', "moves by"),
                (segment, 'coordinate = "y"; type = "harmonic"; amplitude = 0.02; omega = 6.0; phase = "0.5 pi";', jumps),
                (segment, 'coordinate = "y"; type = "harmonic"; amplitude = 0.02; omega = 6.0;', None)):
            wall = f'walls = ( {{ name = "w"; {shape} }} );' if shape else ""
            held = "" if shape else ', { name = "w"; x = 0.0; y = -5.0; radius = 0.5; mass = 1.0; fixed = true; }'
            deck = self.folder / "far.cfg"
            deck.write_text('integrator = "verlet"; dt = 1e-3; steps = 4; materials = ( { name = "m"; k_n = 1e4; } );\n'
                            f'disks = ( {{ x = 0.0; y = 1.0; radius = 0.5; mass = 1.0; }}{held} );\n{wall}\n'
                            f'motions = ( {{ {"wall" if shape else "disk"} = "w"; {motion} }} );\n')
            with self.subTest(shape=shape, motion=motion):
                warned = self.doubted(["displacement"] if said else [], [deck], status=IN_DOUBT if said else 0)
                if said:
                    self.assertRegex(warned[0], said)

    def test_why_open(self):
        """Never closed, parted early, opened often: each is said, with the distances."""
        deck = self.folder / "watched.cfg"
        deck.write_text(WATCHED)
        for words, said in (
                ([], "with b was open 100 % of the time: it never closed, 0.03 radii apart at the start, 0.03 radii apart at the end"),
                (["disks.b.x=2", "disks.a.vx=-3"],
                 "with b was open 100 % of the time: it had opened before measuring began, and never closed, 6.1 radii apart at the end"),
                (["disks.a.vy=40"], "(with floor: it had opened before measuring began, and never closed, 75 radii apart at the end, and with b: it never closed"),
                (["disks.a.vx=1", "phases.settle.steps=1"], "it opened once, ")):
            words = [word for key in words for word in ("-D", key)]
            self.assertIn(said, self.doubted(["open"], [deck, *words])[0])

    def test_not_quiet(self):
        status, out, err = run("run", DECK, *SHORT, "-D", "dt=5e-3", "-o", self.result)
        self.assertEqual(status, IN_DOUBT)
        self.assertIn(f"IN DOUBT\n  {OPEN} (with left: ", out)
        self.assertIn(f"warning: in doubt: {OPEN} (with left: ", err)

    def test_killed(self):
        """What was noted before a kill is told at the end, and the state is the same in every bit."""
        words = [DECK, *SHORT[:2], *SHORT[-2:], "-D", "dt=5e-3", "-D", "phases.settle.steps=5000",
                 "-D", "phases.measure.steps=3e6", "-D", "phases.measure.series=1e4", "-D", "checkpoint=0.02"]
        said = self.doubted(["open", "displacement", "unstable"], words)
        again = self.folder / "again.h5"
        parts = self.folder / "again.h5.parts"
        gate = Gate(self, parts)
        process = start("run", *words, "--quiet", "-o", again, env=gate.environment)
        gate.wait(process)
        process.send_signal(signal.SIGKILL)
        process.communicate()
        self.assertTrue(parts.exists(), "it was over before it could be killed")
        status, out, err = run("resume", again, "--quiet")
        self.assertEqual(status, IN_DOUBT, err)
        self.assertEqual(re.findall("warning: in doubt: (.*)", err), said)
        assert_same(self, self.result, again)


class Limits(Folder):
    """The deck's group."""

    def test_check(self):
        _, out, _ = run("check", DECK, "--no-probe")
        self.assertIn("# limits      in doubt beyond: residual 0.01 open 0.99 displacement 0.1\n", out)
        _, out, _ = run("check", DECK, "--no-probe", "-D", "limits.open=0", "-D", "limits.residual=1e-3")
        self.assertIn("# limits      in doubt beyond: residual 0.001 displacement 0.1\n", out)
        self.assertIn("limits = { residual = 0.001; open = 0.0; displacement = 0.1; };", out)

    def test_mistakes(self):
        status, _, err = run("check", DECK, "--no-probe", "-D", "limits.residual=-1", "-D", "limits.opened=1")
        self.assertEqual(status, 2)
        self.assertIn("error: -D limits.residual=-1: limits.residual = -1: expected a number >= 0\n", err)
        self.assertIn("unknown key of limits; did you mean open?", err.replace(chr(34), ""))


class Sweeps(SweepTest):
    """The same doubts of points, side by side or not, and the exit status of the whole."""

    def test_table(self):
        deck = self.deck(three_disks('{ parameters = ( { path = "dt"; values = (1e-6, 2e-3, 5e-3); } ); }', 50000,
                                     more="limits = { residual = 1e-3; unstable_step = true; };\n"))
        for words in ("-j", 2), ("--force",), ("-j", 2, "--no-lanes", "--force"):
            said = self.sweep(deck, *words, "--quiet", status=IN_DOUBT)
            self.assertEqual(said.count(OPEN), 1, said)
            self.assertIn("1 point in which a disk or a wall moves too far in a step", said)
            self.assertIn("1 point whose energy budget does not close", said)
            messages = column(self.out, "message")
            self.assertEqual(messages[0], "")
            self.assertIn(UNCLOSED, messages[1])
            self.assertRegex(messages[2], f"^{OPEN} \\(with left: it opened [0-9]+ times, [^;]*\\); {FAST}")
            self.assertEqual(column(self.out, "status"), ["done"] * 3)
        # those that an earlier command has run count as well
        said = self.sweep(deck, "-j", 2, status=IN_DOUBT)
        self.assertIn("3 of 3 points done", said)
        self.sweep(deck, "--status")
        self.sweep(deck, "--point", 0)
        self.sweep(deck, "--point", 1, "--quiet", status=IN_DOUBT)
        self.sweep(deck, "--point", "0-1", status=IN_DOUBT)
        said = self.sweep(deck, "--point", 2, "--force", "--quiet", status=IN_DOUBT)
        self.assertIn(f"warning: in doubt: {OPEN} (with left: ", said)
        # what a run says is what the table says
        for name, message in zip(column(self.out, "name"), messages):
            _, out, _ = run("info", "--json", results(self.out)[name])
            self.assertEqual("; ".join(d["message"] for d in json.loads(out)["doubts"]), message)

    def test_failures_come_first(self):
        text = three_disks('{ parameters = ( { path = "disks.upper.vy"; values = (50, -2e4); } ); }', 2000)
        said = self.sweep(self.deck(text), "-j", 2, status=3)
        self.assertIn("1 of 2 points done, 1 failed", said)
        self.assertIn("1 point whose watched contacts were open", said)


class Threads(Folder):
    """More than cores, or than disks are worth."""

    def said(self, threads, cores):
        words = [PROGRAM, "run", str(DECK), "-D", "phases.settle.steps=10", "-D", "phases.measure.steps=10", "--quiet", "--force",
                 "-o", str(self.result)]
        there = sorted(os.sched_getaffinity(0))[:cores]
        done = subprocess.run(words + (["--threads", str(threads)] if threads else []), capture_output=True, text=True, check=True,
                              preexec_fn=lambda: os.sched_setaffinity(0, there))
        return done.stderr

    def test_warnings(self):
        self.assertEqual(self.said(None, 1), "")
        self.assertEqual(self.said(1, 1), "")
        self.assertIn("warning: --threads 2: this process may use 1 core, ", self.said(2, 1))
        self.assertIn("give --threads 1, or leave it out", self.said(2, 1))
        if len(os.sched_getaffinity(0)) > 1:
            said = self.said(2, 2)
            self.assertIn("warning: --threads 2: ", said)
            self.assertIn("fewer than 1000 free disks, here are 1; give --threads 1", said)


if __name__ == "__main__":
    unittest.main()
