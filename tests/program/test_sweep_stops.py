"""`slipdisk sweep` when things go wrong: signals, kills, failing points, full disks, and several sweeps at once."""
import fcntl
import os
import resource
import shutil
import signal
import subprocess
import time
import unittest

from results_common import LONG, run, start, steps_for, wait_for
from sweep_common import (ReferenceTest, SweepTest, children, column, is_alive, results, rows, sessions, stamps,
                          three_disks)

SECONDS = 0.5  # of a point that is to be interrupted
FOUR = '{ parameters = ( { path = "gravity.tilt"; values = (0, "0.01 pi", "0.02 pi", "0.03 pi"); } ); }'


class Interrupted(ReferenceTest):
    """Four points that take a while, each by itself. However they are stopped: what comes out in the end is the same.
    Points in lanes are in test_sweep_lanes.py."""

    POINTS = 4

    @classmethod
    def setUpClass(cls):
        cls.make(three_disks(FOUR, steps_for(SECONDS), checkpoint=0.03))

    def started(self, workers, *words, **more):
        alone = () if "--point" in words else ("--no-lanes",)
        return self.begin(workers, self.path, *alone, *words, **more)

    def unfinished(self):
        return sorted(p.name for p in (self.out / "points").glob("*.parts"))

    def test_signals(self):
        process = self.started(2, "-j", 2)
        said = self.stop(process, signal.SIGINT, 75)
        self.assertIn("stopped, everything is saved: give the command again", said)
        self.assertEqual(len(self.unfinished()), 2)
        self.assertEqual(column(self.out, "status"), ["stopped"] * 2 + ["waiting"] * 2)
        self.assertIn("2 waiting, 2 stopped", self.sweep(self.path, "--status"))
        process = self.started(2, "-j", 2)
        said = self.stop(process, signal.SIGTERM, 75)
        self.assertIn("stopped", said)
        # one of the two may have come to its end
        twice = [name for name, status in zip(column(self.out, "name"), column(self.out, "status")[:2]) if status == "stopped"]
        self.assertTrue(twice)
        self.finish("-j", 2)
        self.assertEqual([sessions(self.out)[name] for name in twice], [3] * len(twice))

    def test_terminal(self):
        """Ctrl-C goes to the sweep and to all of its workers."""
        process = self.started(2, "-j", 2, "--quiet", start_new_session=True)
        os.killpg(process.pid, signal.SIGINT)
        out, err = process.communicate(timeout=LONG)
        self.assertEqual((process.returncode, out + err), (75, ""))
        self.finish("-j", 4)

    def test_killed(self):
        """kill -9 of the sweep: its workers end by themselves, with checkpoints, and soon."""
        process = self.started(2, "-j", 2)
        workers = children(process.pid)
        self.assertEqual(len(workers), 2)
        began = time.monotonic()
        self.stop(process, signal.SIGKILL, -signal.SIGKILL)
        wait_for(lambda: not any(is_alive(pid) for pid in workers), 30)
        self.assertLess(time.monotonic() - began, 20)
        self.assertEqual(len(self.unfinished()), 2)
        self.assertIn("2 stopped", self.sweep(self.path, "--status"))
        self.finish("-j", 2)

    def test_killed_workers(self):
        """A worker that dies is one failed point, which the next sweep runs to its end."""
        for number, word in (signal.SIGKILL, "signal 9"), (signal.SIGSEGV, ""):
            process = self.started(2, "-j", 2)
            victim = children(process.pid)[0]
            os.kill(victim, number)
            self.gate.open()
            _, err = process.communicate(timeout=LONG)
            self.assertEqual(process.returncode, 3, err)
            self.assertIn(f"failed: the process that ran it {word and 'was ended by '}{word}".rstrip(), err)
            self.assertIn("3 of 4 points done, 1 failed", err)
            self.assertEqual(column(self.out, "status").count("failed"), 1)
            self.assertEqual(len([m for m in column(self.out, "message") if "the process that ran it" in m]), 1)
            self.assertEqual(len(list((self.out / "points").glob("*.failed"))), 1)
            self.assertIn("the process that ran it", self.sweep(self.path, "--status"))
            self.finish("-j", 2)
            shutil.rmtree(self.out)

    def test_stopped_worker(self):
        """One that is asked to stop is no failure; it can be continued on its own, from anywhere."""
        process = self.started(2, "-j", 2)
        victim = children(process.pid)[0]
        os.kill(victim, signal.SIGTERM)
        self.gate.open()
        _, err = process.communicate(timeout=LONG)
        self.assertEqual(process.returncode, 75, err)
        self.assertIn("3 of 4 points done", err)
        (parts,) = self.unfinished()
        status, _, err = run("resume", f"out/points/{parts[:-len('.parts')]}", cwd=self.folder)
        self.assertEqual(status, 0, err)
        self.assertNotIn("has a sweep", err)
        self.finish("-j", 2)

    def test_stopped_point(self):
        process = self.started(1, "--point", 1)
        said = self.stop(process, signal.SIGINT, 75)
        again = [line for line in said.splitlines() if line.startswith("continue with: slipdisk ")]
        self.assertEqual(again, [f"continue with: slipdisk resume {self.out}/points/tilt=0.01pi.h5"])
        self.finish("-j", 2)

    def test_force_is_stopped(self):
        """The old results stay until new ones replace them."""
        shutil.copytree(self.reference, self.out)
        before = stamps(self.out)
        process = self.started(1, "-j", 1, "--force")
        self.stop(process, signal.SIGINT, 75)
        self.assertEqual(stamps(self.out), before)
        self.assertIn("1 stopped, 3 done", self.sweep(self.path, "--status"))
        said = self.sweep(self.path, "-j", 1)
        self.assertEqual(said.count("] point "), 1, said)
        self.assert_same_results(self.out, self.reference)

    def test_at_once(self):
        """What one of two leaves unfinished the other takes up."""
        self.sweep_twice_at_once("-j", 1, "--no-lanes")
        self.assert_same_results(self.out, self.reference)
        shutil.rmtree(self.out)
        one = self.started(1, "-j", 1)
        other = start("sweep", self.path, "-j", 1, "--no-lanes", "-o", self.out)
        wait_for(lambda: len(self.unfinished()) == 2)
        self.stop(one, signal.SIGINT, 75)
        _, err = other.communicate(timeout=LONG)
        self.assertEqual(other.returncode, 0, err)
        self.assert_all_done(err)
        self.assert_same_results(self.out, self.reference)

    def test_running_elsewhere(self):
        one = self.started(1, "-j", 1)
        self.assertIn("1 running", self.sweep(self.path, "--status"))
        said = self.sweep(self.path, "--point", 0, "--no-wait", status=6)
        self.assertIn("point 0, tilt=0, is left to another process, which runs it", said)
        said = self.sweep(self.path, "--table")
        self.assertEqual(column(self.out, "status")[0], "running")
        self.stop(one, signal.SIGTERM, 75)
        self.assertEqual(list((self.out / "points").glob("*.failed")), [])
        self.finish("-j", 2)

    def test_file_size_limit(self):
        """Parts can be written, the results cannot: clear words, status 4, and nothing is lost."""
        words = ("-D", "output.series=20", "-D", "checkpoint=60")
        path = self.where / "short.cfg"
        path.write_text(three_disks(FOUR, 200000, more=""))
        whole = self.folder / "whole"
        self.sweep(path, "-j", 2, *words, out=whole)
        least = min(p.stat().st_size for p in results(whole).values())
        for limit, jobs in (least * 3 // 4, ("-j", 2)), (20000, ("-j", 2)), (20000, ()):
            said = self.sweep(path, *jobs, *words, status=4,
                              preexec_fn=lambda n=limit: resource.setrlimit(resource.RLIMIT_FSIZE, (n, n)))
            self.assertIn("cannot write", said)
            self.assertIn("File too large", said)
            self.assertNotIn("everything is saved", said)
            self.assertEqual(results(self.out), {})
            self.assertEqual(list(self.out.rglob("*.tmp")), [])
        self.sweep(path, "-j", 2, *words)
        self.assert_same_results(self.out, whole)

    def test_full_disk(self):
        small = self.small_disk("64k")
        (small / "filler").write_bytes(bytes(12 * 1024))
        for jobs in ("-j", 2), ():
            said = self.sweep(self.path, *jobs, status=4, out=small / "out")
            self.assertIn("No space left on device", said)
            self.assertNotIn("everything is saved", said)
        self.assertEqual(results(small / "out"), {})

    def test_read_only(self):
        small = self.small_disk("8m")
        deck = self.deck(three_disks(FOUR, 1000))
        self.sweep(deck, "--point", 1, "--quiet", out=small / "out")
        subprocess.run(["mount", "-o", "remount,ro", small], check=True)
        for words in ("-j", 2), (), ("--point", 0), ("--table",):
            said = self.sweep(deck, *words, status=4, out=small / "out")
            self.assertIn("Read-only file system", said, words)
        said = self.sweep(deck, "-j", 2, status=4, out=small / "new")
        self.assertIn("Read-only file system", said)
        # looking is possible
        self.assertIn("3 waiting, 1 done", self.sweep(deck, "--status", out=small / "out"))

    def test_no_permission(self):
        said = self.sweep(self.path, "-j", 2, status=4, out="/proc/nothing")
        self.assertIn("/proc/nothing", said)


class Held(SweepTest):
    """Points that another process runs, here a lock of this one: status 0 means that all points asked for are done."""

    WAYS = ("-j", 2), (), ("--point", "0-3"), ("--point", 1)

    def setUp(self):
        super().setUp()
        self.path = self.deck(three_disks(FOUR, 1000))

    def hold(self):
        """Takes the lock of point 1."""
        parts = self.out / "points/tilt=0.01pi.h5.parts"
        parts.mkdir(parents=True)
        lock = open(parts / "lock", "w")
        self.addCleanup(lock.close)
        fcntl.flock(lock, fcntl.LOCK_EX)
        return lock

    def waiting(self, *words):
        """A sweep that has come so far that it waits; returns it and what it has said."""
        process, said = start("sweep", self.path, *words, "-o", self.out), ""
        while "waiting for" not in said:
            line = process.stderr.readline()
            self.assertTrue(line, said)
            said += line
        return process, said

    def test_it_waits_and_takes_them_over(self):
        for words in self.WAYS:
            lock = self.hold()
            process, said = self.waiting(*words)
            self.assertIsNone(process.poll())
            self.assertRegex(said, "waiting for (1 point that other processes run: #1|point 1, tilt=0.01pi, which another)")
            lock.close()
            _, err = process.communicate(timeout=LONG)
            self.assertEqual(process.returncode, 0, said + err)
            self.assertEqual(len(results(self.out)), 1 if 1 in words else 4, words)
            if "--point" not in words:
                self.assertEqual(column(self.out, "status"), ["done"] * 4)
            shutil.rmtree(self.out)

    def test_what_they_finish_is_not_run_again(self):
        self.sweep(self.path, "-j", 2)
        for words in self.WAYS:
            lock = self.hold()
            process, said = self.waiting(*words)
            shutil.rmtree(self.out / "points/tilt=0.01pi.h5.parts")  # as a run at its end does
            lock.close()
            _, err = process.communicate(timeout=LONG)
            self.assertEqual(process.returncode, 0, said + err)
            self.assertEqual(list(sessions(self.out).values()), [1] * 4)

    def test_without_waiting_it_tells_what_is_left(self):
        for words in self.WAYS:
            lock = self.hold()
            said = self.sweep(self.path, *words, "--no-wait", status=6)
            self.assertRegex(said, "left to other processes: 1 point; the same command|point 1, tilt=0.01pi, is left to another process")
            if "--point" not in words:
                self.assertEqual(column(self.out, "status"), ["done", "running", "done", "done"])
                self.assertIn("4 points: 1 running, 3 done", self.sweep(self.path, "--table"))
            lock.close()
            shutil.rmtree(self.out)

    def test_waiting_can_be_stopped(self):
        for words in self.WAYS:
            lock = self.hold()
            process, _ = self.waiting(*words)
            process.send_signal(signal.SIGINT)
            self.assertIn("stopped", process.communicate(timeout=LONG)[1])
            self.assertEqual(process.returncode, 75)
            lock.close()
            shutil.rmtree(self.out)

    def test_results_of_another_deck_made_meanwhile_are_told(self):
        self.sweep(self.path, "--point", 1, "-D", "phases.measure.steps=2000", out=self.folder / "other")
        lock = self.hold()
        process, said = self.waiting("-j", 1)
        shutil.copy(results(self.folder / "other")["tilt=0.01pi"], self.out / "points")
        shutil.rmtree(self.out / "points/tilt=0.01pi.h5.parts")
        lock.close()
        _, err = process.communicate(timeout=LONG)
        self.assertEqual(process.returncode, 2, said + err)
        self.assertIn("3 of 4 points done, 1 with a result that is not this deck's", err)


class Failing(SweepTest):
    """Points that cannot be run do not keep the others from being run."""

    def test_numeric(self):
        """The amplitude is so large that the disks overlap too much."""
        deck = self.deck(three_disks('{ parameters = ( { path = "motions.shake.amplitude"; values = (1e-4, 5, 2e-4); } ); }',
                                     200000))
        for words in ("-j", 2), (), ("-j", 1):
            said = self.sweep(deck, *words, status=3)
            self.assertIn("point 1, amplitude=5: failed: ", said)
            self.assertIn("2 of 3 points done, 1 failed", said)
            table = rows(self.out)
            self.assertEqual([r["status"] for r in table], ["done", "failed", "done"])
            self.assertRegex(table[1]["message"], "overlap")
            self.assertEqual(table[1]["upper.omega"], "")
            self.assertNotEqual(table[2]["upper.omega"], "")
            self.assertIn("overlap", (self.out / "points/amplitude=5.failed").read_text())
            self.assertIn("overlap", self.sweep(deck, "--status"))
        said = self.sweep(deck, "--point", 1, status=3)
        self.assertIn("overlap", said)
        self.assertEqual(rows(self.out, "means.csv")[1]["replicas"], "0")

    def test_mistakes_of_some_points(self):
        deck = self.deck(three_disks('{ parameters = ( { path = "max_overlap"; values = (0.5, 7, 0.25); } ); replicas = 2; }',
                                     1000))
        status, _, err = run("check", deck, "--brief", "--no-probe")
        self.assertEqual(status, 2)
        wanted = r"error: \S+deck\.cfg:\d+: max_overlap = 7: expected a number > 0 and <= 1 \(point 2, max_overlap=7\)\n"
        self.assertRegex(err, wanted)
        for words in ("-j", 2), (), ("--point", "0-1"), ("--list",):
            said = self.sweep(deck, *words, status=2)
            self.assertRegex(said, wanted)
            self.assertEqual(said.count("error: "), 1, said)
            if words != ("--list",):
                self.assertIn("nothing is run: 2 of 3 sets of values have no mistakes, --skip runs them", said)
        self.assertRegex(self.sweep(deck, "--count", status=2), rf"\A{wanted}\Z")
        self.assertEqual(self.sweep(deck, "--count", "--skip"), "6\n")
        self.assertFalse(self.out.exists())
        for words in ("-j", 2), ():
            said = self.sweep(deck, *words, "--skip", status=3)
            self.assertRegex(said, wanted)
            self.assertIn("2 of 3 sets of values are run", said)
            self.assertIn("4 of 6 points done, 2 failed", said)
        self.assertIn("max_overlap = 7", rows(self.out)[2]["message"])
        # mended
        deck.write_text(deck.read_text().replace(" 7,", " 0.75,"))
        said = self.sweep(deck, "-j", 2)
        self.assertIn("6 of 6 points done", said)

    def test_mistakes_of_all_points(self):
        """Nothing is made."""
        for grid, wanted in (('path = "gravity.tlt"; values = (0, 1);', "gravity.tlt = 0: unknown key of gravity"),
                             ('path = "gravity.tilt"; values = ();', "values = (): expected a list")):
            deck = self.deck(three_disks("{ parameters = ( { " + grid + " } ); }"))
            for words in ("-j", 2), ():
                said = self.sweep(deck, *words, status=2)
                self.assertIn(wanted, said)
                self.assertEqual(said.count("error: "), 1, said)
            self.assertFalse(self.out.exists())
        deck = self.deck(three_disks('{ parameters = ( { path = "gravity.tlt"; values = (0, 1); } ); }'))
        said = self.sweep(deck, "--point", 1, status=2)
        self.assertIn("gravity.tlt = 1: unknown key", said)

    def test_damaged_result(self):
        """One that cannot be read is told, and left alone."""
        deck = self.deck(three_disks(FOUR, 1000))
        self.sweep(deck, "-j", 2, "--quiet")
        path = results(self.out)["tilt=0.01pi"]
        path.write_bytes(path.read_bytes()[:3000])
        said = self.sweep(deck, "-j", 2, status=2)
        self.assertRegex(said, r"point 1, tilt=0\.01pi: damaged: \S+\.h5 is not a readable HDF5 file: \w*truncated")
        self.assertIn("3 of 4 points done, 1 with a damaged result", said)
        self.assertEqual(column(self.out, "status"), ["done", "damaged", "done", "done"])
        self.assertIn("3 done, 1 damaged", self.sweep(deck, "--status"))
        self.assertIn("damaged", self.sweep(deck, "--point", 1, status=2))
        self.assertEqual(path.stat().st_size, 3000)
        self.sweep(deck, "-j", 2, "--force", "--quiet")
        self.assertEqual(column(self.out, "status"), ["done"] * 4)

    def test_time_step(self):
        """One warning for all."""
        deck = self.deck(three_disks('{ parameters = ( { path = "dt"; values = (1e-6, 1e-4, 2e-4); } ); }', 10, more="integrator = \"verlet\";\n"))
        said = self.sweep(deck, "--threads", 1, "-j", 2)
        self.assertEqual(said.count("warning: "), 1, said)
        self.assertRegex(said, r"warning: dt = 0\.0002 is more than .* \(point 2, dt=0\.0002, the worst; 2 of 3 sets of values\)")


if __name__ == "__main__":
    unittest.main()
