"""One run over the ranks of an MPI job: the result of one process in every bit, also when ranks are stopped, killed, or
cannot write. Ranks have one thread each, since there are more of them than cores."""
import json
import os
import pathlib
import random
import re
import signal
import subprocess
import sys
import time
import unittest

import numpy as np

from ranks_common import ranks_of
from results_common import LONG, PROGRAM, SELDOM, Folder, assert_same, run, wait_for

sys.path.insert(0, str(pathlib.Path(os.environ["SLIPDISK_SOURCE_DIR"]) / "tools/python"))
import slipdisk  # noqa: E402

MPIEXEC = os.environ["SLIPDISK_MPIEXEC"].split()
SHIM = pathlib.Path(os.environ["SLIPDISK_BUILD_DIR"]) / "tests/calls.so"
COUNT = 300
FALL, SHAKE = 1000, 2500
DECK = f"""
title = "disks that fall into a shaken box";
integrator = "verlet";
dt = 4e-5;
gravity = {{ g = 9.81; }};
materials = ( {{ name = "grain"; k_n = 1e4; k_t = 5e3; gamma_n = 0.5; mu = 0.3; }} );
container = {{ type = "box"; width = 0.9; height = 0.6; open = false; }};
packings = ( {{ type = "random"; count = {COUNT}; density = 3.57; sizes = "list"; radii = (0.012, 0.015, 0.018); }} );
motions = ( {{ wall = "floor"; coordinate = "y"; type = "harmonic"; acceleration = 2; frequency = 80; }} );
phases = ( {{ name = "fall"; steps = {FALL}; series = 100; frames = 500; contacts = 500; }},
           {{ name = "shake"; steps = {SHAKE}; measure = true; series = 100; frames = 500; contacts = 500; }} );
measure = {{ rotation = (); sliding = (); disks = true;
             averages = {{ force = "wall_force_y[floor]"; share = "sliding_contacts/contacts"; power = "rate(work)"; }}; }};
"""
# A periodic box with a disk that turns, which all ranks have, and frames between the rows of the series.
TURNING = f"""
title = "disks around one that turns";
integrator = "verlet";
dt = 4e-5;
materials = ( {{ name = "grain"; k_n = 1e4; k_t = 5e3; gamma_n = 0.5; mu = 0.3; }} );
box = {{ x = (-0.4, 0.4); y = (-0.4, 0.4); }};
gravity = {{ g = 9.81; }};
disks = ( {{ name = "wheel"; x = 0.0; y = 0.0; radius = 0.05; density = 3.57; }} );
packings = ( {{ type = "random"; count = 500; density = 3.57; sizes = "list"; radii = (0.012, 0.015, 0.018); }} );
motions = ( {{ disk = "wheel"; coordinate = ("x", "y"); type = "fixed"; }},
            {{ disk = "wheel"; coordinate = "theta"; type = "velocity"; velocity = 50.0; }} );
phases = ( {{ name = "turn"; steps = 2000; series = 300; frames = 70; contacts = 110; }} );
measure = {{ rotation = (); sliding = (); }};
"""
ENDLESS = "-D", "phases.shake.steps=100000000"
OFTEN = "-D", "checkpoint=0.02"


class Ranks(Folder):
    def setUp(self):
        super().setUp()
        self.deck = self.folder / "shaken.cfg"
        self.deck.write_text(DECK)
        self.log = open(self.folder / "log", "a+")
        self.addCleanup(self.log.close)

    def said(self):
        return (self.folder / "log").read_text()

    def words(self, *more):
        return ["run", str(self.deck), "-o", str(self.result), "--threads", "1", "--quiet", *OFTEN, *more]

    def start(self, ranks, words, faulty=None, environment=()):
        """faulty: a rank with this environment."""
        self.log.truncate(0)
        command = list(MPIEXEC)
        for rank in range(ranks) if faulty is not None else ():
            own = ["env", *environment] if rank == faulty else []
            command += [*(":" if rank else ""), "-n", "1", *own, PROGRAM, *words]
        if faulty is None:
            command += ["-n", str(ranks), PROGRAM, *words]
        return subprocess.Popen(command, stdout=self.log, stderr=self.log)

    def finish(self, ranks, words, status=0, **more):
        found = self.start(ranks, words, **more).wait(timeout=LONG)
        self.assertEqual(found, status, self.said())
        self.assertNotIn("every rank", self.said())

    def reference(self, *more):
        """What one process makes."""
        path = self.folder / "reference.h5"
        self.run_ok("run", self.deck, "-o", path, "--threads", 1, *more)
        return path

    def shares(self):
        """step -> number of shares"""
        found = {}
        for path in self.parts.glob("checkpoint-*-*.h5"):
            step = int(path.stem.split("-")[1])
            found[step] = found.get(step, 0) + 1
        return found

    def heads(self):
        return sorted(int(path.stem.split("-")[1]) for path in self.parts.glob("checkpoint-*.h5")
                      if path.stem.count("-") == 1)

    def at_work(self, process, ranks):
        """Their process ids, once a checkpoint has shares of all."""
        def begun():
            self.assertIsNone(process.poll(), f"ended too soon\n{self.said()}")
            shares = self.shares()
            return any(shares.get(step) == ranks for step in self.heads() if step > self.before)

        wait_for(begun)
        found = ranks_of(process.pid)
        self.assertEqual(sorted(found), list(range(ranks)))
        return found

    def interrupt(self, ranks, how, *more, status=None):
        """how(ranks' process ids, launcher) ends the run; status None: any but 0."""
        self.before = max([FALL, *self.heads()])
        process = self.start(ranks, self.words(*ENDLESS, *more))
        there = self.at_work(process, ranks)
        how(there, process.pid)
        found = process.wait(timeout=LONG)
        if status is None:
            self.assertNotEqual(found, 0, self.said())
        else:
            self.assertEqual(found, status, self.said())
        wait_for(lambda: not ranks_of(process.pid))

    def test_same_on_any_number_of_ranks(self):
        whole = self.reference()
        for ranks in 1, 2, 3, 4, 7:
            with self.subTest(ranks=ranks):
                self.finish(ranks, self.words("-D", "checkpoint=0.2"))
                assert_same(self, self.result, whole)
                self.assertFalse(self.parts.exists())
                self.result.unlink()

    def test_driven_disk_in_a_periodic_box(self):
        self.deck.write_text(TURNING)
        whole = self.reference()
        self.finish(3, self.words("-D", "checkpoint=0.5"))
        assert_same(self, self.result, whole)

    def test_shares_read_as_one_file(self):
        """All commands say of a checkpoint in shares what they say of a run that ends at its step in one process."""
        self.interrupt(3, lambda ranks, launcher: os.kill(launcher, signal.SIGUSR1), status=75)
        step = self.heads()[-1]
        self.assertEqual(self.shares()[step], 3)
        self.assertTrue(list(self.parts.glob("part-*-2.h5")))
        whole = self.reference("-D", f"phases.shake.steps={step - FALL}")
        last = [json.loads(self.run_ok("measure", path, "--json")[0])["frames"] for path in (self.result, whole)]
        for frames in last:
            self.assertEqual(frames[0].pop("step"), step)
            frames[0].pop("frame")
        self.assertEqual(*last)
        for name, path in ("shares", self.result), ("whole", whole):
            self.run_ok("export", path, "--to", "csv", "--frames", "-1", "-o", self.folder / name)
        for table in "disks", "contacts":
            one, other = (self.folder / name / f"{table}.csv" for name in ("shares", "whole"))
            self.assertEqual(one.read_text(), other.read_text())
        shared, one = slipdisk.Result(self.result), slipdisk.Result(whole)
        self.assertEqual(shared.step, step)
        self.assertEqual(len(shared.contacts), len(shared.contacts.step))
        last = len(shared.frames) - 1
        self.assertEqual(shared.frames.step[last], one.frames.step[last])
        for name in "position", "velocity", "angle":
            np.testing.assert_array_equal(shared.frames[last][name], one.frames[last][name])
        np.testing.assert_array_equal(shared.disks, one.disks)
        np.testing.assert_array_equal(shared.last_contacts, one.last_contacts)
        self.assertIn(f"step {step} of", self.run_ok("info", self.result)[0])
        self.assertIn("give the result", run("info", self.parts / f"checkpoint-{step}-1.h5")[2])
        self.run_ok("view", self.result, "-o", self.folder / "page.html")
        self.run_ok("verify", self.result)
        # a share of another checkpoint, a damaged one, one that is missing
        share, other = (self.parts / f"checkpoint-{step}-{k}.h5" for k in (1, 2))
        good = share.read_bytes()
        for bad in other.read_bytes(), good[:1000] + b"?" + good[1001:], None:
            share.unlink()
            if bad:
                share.write_bytes(bad)
            status, _, err = run("info", f"{self.parts}/checkpoint-{step}.h5")
            self.assertEqual(status, 4)
            self.assertIn(share.name, err)

    def test_killed_and_gone_on_with_others(self):
        """kill -9 of each rank at some moment: the job ends, and another number of ranks goes on."""
        end = "-D", "phases.shake.steps=20000"
        whole = self.reference(*end)
        chance = random.Random(1)
        for ranks, victim in (3, 0), (2, 1), (4, 3), (3, 1):
            def kill(there, _, victim=victim):
                time.sleep(chance.uniform(0, 0.2))
                os.kill(there[victim], signal.SIGKILL)

            self.interrupt(ranks, kill, *end, status=137)
        self.finish(2, self.words(*end, *SELDOM))
        assert_same(self, self.result, whole)
        self.assertFalse(self.parts.exists())

    def test_killed_while_writing(self):
        """Of each file that a rank makes, before it is there and when it has its name."""
        end = "-D", "phases.shake.steps=20000"
        whole = self.reference(*end)
        chance = random.Random(2)
        self.interrupt(3, lambda there, launcher: os.kill(launcher, signal.SIGUSR1), *end, status=75)
        for faulty in 0, 1, 2:
            for call in "write,fsync", "rename":
                environment = (f"LD_PRELOAD={SHIM}", f"INJECT_BELOW={self.folder}", "INJECT_NAME=*/r.h5.parts/*.h5*",
                               f"INJECT_CALL={call}", f"INJECT_WHEN={chance.randint(3, 8)}", "INJECT_DO=kill")
                self.finish(3, self.words(*end), 137, faulty=faulty, environment=environment)
        self.finish(2, self.words(*end, *SELDOM))
        assert_same(self, self.result, whole)

    def test_killed_while_merging(self):
        """All is computed: another number of ranks merges it, and writes no checkpoint."""
        whole = self.reference()
        shim = f"LD_PRELOAD={SHIM}", f"INJECT_BELOW={self.folder}"
        kill = "INJECT_NAME=*result.h5*", "INJECT_CALL=pwrite", "INJECT_WHEN=100", "INJECT_DO=kill"
        self.finish(3, self.words(), 137, faulty=0, environment=(*shim, *kill))
        self.finish(2, self.words(), faulty=1, environment=(*shim, "INJECT_NAME=*/checkpoint-*", "INJECT_BYTES=10000"))
        assert_same(self, self.result, whole)

    def test_stopped_by_any_rank(self):
        end = "-D", "phases.shake.steps=20000"
        whole = self.reference(*end)
        for ranks, told, how in (3, 0, signal.SIGTERM), (2, 1, signal.SIGUSR1):
            self.interrupt(ranks, lambda there, _, told=told, how=how: os.kill(there[told], how), *end, status=75)
            self.assertEqual(self.shares()[self.heads()[-1]], ranks)
        # one process, without the deck
        self.run_ok("resume", self.result)
        assert_same(self, self.result, whole)

    def test_full_disk_of_one_rank(self):
        whole = self.reference()
        for faulty, files, room in (0, "*/checkpoint-*", 900000), (2, "*/checkpoint-*", 600000), (1, "*/part-*", 60000):
            with self.subTest(faulty=faulty, files=files):
                environment = (f"LD_PRELOAD={SHIM}", f"INJECT_BELOW={self.folder}", f"INJECT_NAME={files}",
                               f"INJECT_BYTES={room}")
                self.finish(3, self.words(), 4, faulty=faulty, environment=environment)
                self.assertIn("No space left on device", self.said())
                self.assertRegex(self.said(), f"cannot write .*{files[2:]}[0-9]+(-{faulty})?.h5".replace("-*", "-"))
                self.assertIn(f"the run can continue from step {self.heads()[-1]}", self.said())
                self.assertLessEqual(set(self.shares()), set(self.heads()))
                self.finish(4, self.words())
                assert_same(self, self.result, whole)
                self.result.unlink()

    def numbers(self, state):
        """What info says of it, but for costs and names."""
        out, _ = self.run_ok("info", "--json", state)
        found = json.loads(out)
        return {key: found[key] for key in ("step", "time", "contacts", "energy", "disks", "doubts")}

    def test_numerical_error(self):
        """Found by one rank: the message and the state are those of one process."""
        for what in ("max_overlap=0.01",):
            with self.subTest(what=what):
                alone = self.folder / "alone.h5"
                status, _, err = run(*self.words("-D", what, "--force", "-o", alone))
                self.assertEqual(status, 3, err)
                self.finish(3, self.words("-D", what), 3)
                errors = [line for line in err.splitlines() if line.startswith("error: ")]
                self.assertTrue(errors)
                for line in errors:
                    self.assertIn(line, self.said())
                kept = [p for p in self.parts.glob("emergency-*.h5") if re.fullmatch(r"emergency-\d+", p.stem)]
                self.assertEqual(len(kept), 1)
                self.assertEqual(len(list(self.parts.glob(f"{kept[0].stem}-*.h5"))), 3)
                there = next((self.folder / "alone.h5.parts").glob("emergency-*.h5"))
                self.assertEqual(self.numbers(there), self.numbers(kept[0]))


if __name__ == "__main__":
    unittest.main()
