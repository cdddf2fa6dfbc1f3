"""Runs that end when an error bar is small enough: what they write and say, stopped and resumed."""
import json
import pathlib
import shutil
import signal
import tempfile
import unittest

import h5py

from results_common import (LONG, SELDOM, SETTLE, Folder, assert_same, brief, deck_arguments, run, start, steps_for,
                            wait_for)

DT = 1e-6
LEAST = 100000


def words_of(error, most=50 * LEAST, least=LEAST, more=(), **cadence):
    words = deck_arguments(measure=least, **cadence)
    for text in (f"until.error={error:.6g}", f"until.max_time={most * DT:.9g}", *more):
        words += ["-D", text]
    return words


def goal_for(steps):
    """The error bar that this deck has after so many steps, roughly."""
    return 1.1e-4 * (20e6 / steps) ** 0.5


def looks(least, most):
    found = [least]
    while found[-1] < most:
        found.append(min(most, found[-1] + found[-1] // 20 + 1))
    return found


class Until(Folder):
    def info(self, name):
        return json.loads(self.run_ok("info", "--json", name)[0])


class Ends(Until):
    def test_goal_is_reached(self):
        error = goal_for(8 * LEAST)
        out, err = self.run_ok("run", *words_of(error), "-o", self.result)
        self.assertNotIn("warning", err)
        with h5py.File(self.result) as file:
            found = file["summary"].attrs
            until = dict(file["summary/until"].attrs)
            step = int(found["step"])
            self.assertEqual(found["steps"], SETTLE + 50 * LEAST)
            self.assertIn(step - SETTLE, looks(LEAST, 50 * LEAST)[1:-1])
            self.assertEqual(until["observable"], b"upper.omega")
            self.assertEqual([until["reached"], until["converged"], until["step"]], [1, 1, step])
            self.assertEqual(until["goal"], float(f"{error:.6g}"))
            self.assertLessEqual(until["error"], until["goal"])
            self.assertEqual(until["error"], file["summary/rotation/error"][0])
            self.assertEqual(until["value"], file["summary/rotation/omega"][0])
            self.assertEqual(found["measured"], step - SETTLE)
            # the last step is recorded, whatever the cadence
            for path in "observables/work/step", "particles/disks/position/step", "contacts/step":
                self.assertEqual(file[path][-1], step)
                self.assertEqual(len(set(file[path][()])), len(file[path]))
            self.assertEqual(file["state/phase"][()], 2)
            self.assertEqual(file["state/step"][()], step)
        self.assertIn(f"reached at step {step}", out)
        self.assertIn("of at most", out)
        info = self.info(self.result)
        self.assertTrue(info["finished"])
        self.assertEqual((info["until"]["reached"], info["until"]["step"]), (True, step))
        self.assertIn(f"reached at step {step}", self.run_ok("info", self.result)[0])
        self.run_ok("resume", self.result)

        # the same in every bit as a run of just that length
        fixed = self.folder / "fixed.h5"
        self.run_ok("run", *deck_arguments(measure=step - SETTLE), "-o", fixed)
        with h5py.File(self.result) as one, h5py.File(fixed) as two:
            self.assertEqual(one["state"].attrs["hash"], two["state"].attrs["hash"])
            self.assertNotIn("until", two["summary"])
        self.assertIsNone(self.info(fixed)["until"])

    def test_goal_is_given_up(self):
        words = words_of(1e-9, most=2 * LEAST, more=["until.observable=upper.scaled"])
        out, err = self.run_ok("run", *words, "-o", self.result)
        self.assertIn("warning: max_time came before the goal of until", err)
        self.assertIn("upper.scaled", err)
        self.assertIn("NOT reached", out)
        until = self.info(self.result)["until"]
        self.assertEqual((until["reached"], until["step"], until["goal"]), (False, None, 1e-9))
        self.assertEqual(self.info(self.result)["step"], SETTLE + 2 * LEAST)
        self.assertFalse(self.parts.exists())

    def test_relative_goal(self):
        words = words_of(1, more=["until.relative=1.5"])  # takes `error` away
        self.run_ok("run", *words, "-o", self.result)
        until = self.info(self.result)["until"]
        self.assertEqual(until["relative"], 1.5)
        self.assertEqual(until["goal"], 1.5 * abs(until["value"]))
        self.assertEqual(until["reached"], until["converged"] and until["error"] <= until["goal"])

    def test_progress(self):
        log = self.folder / "log"
        self.run_ok("run", *words_of(goal_for(4 * LEAST)), "-o", self.result, "--log", log)
        lines = [line for line in log.read_text().splitlines() if "ETA" in line]
        self.assertIn("100.0 %", lines[-1])
        self.assertRegex(lines[-1], r"error \S+ of \S+")
        self.assertNotIn("nan", log.read_text())

    def test_check(self):
        out, _ = self.run_ok("check", *words_of(1e-3), "--brief", "--no-probe")
        self.assertIn(f"ends after {LEAST} steps", out)

    def test_mistakes(self):
        for more, told in ((["until.max_time=0.01"], "at least the length of the last phase"),
                           (["until.observable=uper.omega"], 'did you mean "upper"?'),
                           (["phases.measure.measure=false"], "the last phase does not measure")):
            status, _, err = run("run", *words_of(1e-3, more=more), "-o", self.result)
            self.assertEqual(status, 2, err)
            self.assertIn(told, err)
            self.assertFalse(self.parts.exists())


class Killed(Until):
    """kill -9 and continue: the end is at the same step, and the file the same in every bit."""

    @classmethod
    def setUpClass(cls):
        steps = steps_for(1)
        cls.words = words_of(goal_for(steps), most=20 * steps, least=max(1000, steps // 10), series=10000, frames=10000,
                             checkpoint=0.02)
        cls.where = pathlib.Path(tempfile.mkdtemp(prefix="slipdisk-until-"))
        cls.whole = cls.where / "whole.h5"
        status, _, err = run("run", *cls.words, *SELDOM, "-o", cls.whole)
        assert status == 0, err

    @classmethod
    def tearDownClass(cls):
        shutil.rmtree(cls.where)

    def same(self, whole):
        assert_same(self, self.result, whole)
        until = self.info(whole)["until"]
        self.assertTrue(until["reached"])
        self.assertEqual(self.info(self.result)["until"], until)
        self.assertFalse(self.parts.exists())

    def test_stopped_and_resumed(self):
        process = self.started(*self.words)
        process.send_signal(signal.SIGTERM)
        _, err = process.communicate(timeout=LONG)
        self.assertEqual(process.returncode, 75, err)
        self.assertIn("of at most", err)
        until = self.info(self.result)["until"]
        self.assertEqual((until["reached"], until["step"]), (False, None))
        self.run_ok("resume", self.result)
        self.same(self.whole)

    def test_while_merging(self):
        # so many rows that the merge takes a while; the goal is reached long before max_time
        words = words_of(goal_for(3 * LEAST), series=brief(2, 10), frames=brief(2, 10), checkpoint=0.2)
        whole = self.folder / "whole.h5"
        self.run_ok("run", *words, "-o", whole)
        end = self.info(whole)["step"]
        cut = self.kill_while_merging(words, 4)
        self.assertGreater(cut, 0, "no merge was cut short")
        if self.parts.exists():
            self.assertEqual(self.checkpoints()[0], end)
        self.run_ok("resume", self.result)
        self.same(whole)
        self.assertEqual(sorted(p.name for p in self.folder.iterdir()), ["r.h5", "whole.h5"])


if __name__ == "__main__":
    unittest.main()
