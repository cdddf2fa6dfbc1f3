"""Signals that ask a run to stop: at a checkpoint, or at once where nothing has begun; twice does no harm."""
import os
import pathlib
import resource
import signal
import unittest

from results_common import LONG, ROOT, Folder, assert_same, deck_arguments, start, steps_for, wait_for

STOPS = [signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGUSR1, signal.SIGUSR2, signal.SIGXCPU, signal.SIGALRM]
# So many disks take seconds to be placed.
CROWD = [str(ROOT / "inputs/packing/jam_1e4.cfg"), "-D", "packings[0].count=1000000", "-D", "container.width=1500.0",
         "-D", "container.height=1500.0"]


class Signals(Folder):
    def stop(self, words, *numbers):
        """Starts, waits for checkpoints of its own, and sends them, one at once after the other."""
        process = self.started(*words)
        for number in numbers:
            process.send_signal(number)
        _, err = process.communicate(timeout=LONG)
        self.assertEqual(process.returncode, 75, f"{numbers}: {err}")
        self.assertIn("everything is saved", err)

    def test_each_stops_at_a_checkpoint(self):
        # each stop takes two or three checkpoints; a whole run has some fifty, however slow the build
        steps = steps_for(2)
        words = deck_arguments(measure=steps, series=steps // 100, frames=steps, checkpoint=0.02)
        whole = self.folder / "whole.h5"
        self.run_ok("run", *words, "-o", whole)
        for number in STOPS:
            self.stop(words, number)
        # a second one changes nothing, whichever it is
        self.stop(words, signal.SIGTERM, signal.SIGINT, signal.SIGUSR2, signal.SIGINT)
        self.run_ok("run", *words, "-o", self.result)
        assert_same(self, self.result, whole)

    def test_limit_of_processor_time(self):
        process = start("run", *deck_arguments(measure=10**11, series=10**9, frames=10**9), "-o", self.result, "--quiet",
                        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_CPU, (1, 20)))
        _, err = process.communicate(timeout=LONG)
        self.assertEqual(process.returncode, 75, err)
        self.assertTrue(self.checkpoints())

    def test_before_anything_has_begun(self):
        for number in (signal.SIGINT, signal.SIGUSR2, signal.SIGXCPU):
            process = start("run", *CROWD, "-o", self.result)
            self.wait_for_handler(process, number)
            process.send_signal(number)
            _, err = process.communicate(timeout=LONG)
            self.assertEqual(process.returncode, 75, err)
            self.assertIn("stopped before the first step", err)
            self.assertEqual(os.listdir(self.folder), [])

    def test_what_only_reads_ends_as_usual(self):
        process = start("check", *CROWD)
        wait_for(lambda: process.poll() is not None or self.ticks(process) > 5)
        process.send_signal(signal.SIGUSR2)
        process.communicate(timeout=LONG)
        self.assertEqual(process.returncode, -signal.SIGUSR2)

    def ticks(self, process):
        """Processor time that it has used."""
        return int(pathlib.Path(f"/proc/{process.pid}/stat").read_text().rpartition(")")[2].split()[11])

    def wait_for_handler(self, process, number):
        """The loader of libraries is no part of the program: it is over when the signal is caught."""
        def caught():
            with open(f"/proc/{process.pid}/status") as status:
                mask = next(line.split()[1] for line in status if line.startswith("SigCgt:"))
            return int(mask, 16) >> (number - 1) & 1

        wait_for(lambda: caught() or process.poll() is not None)


if __name__ == "__main__":
    unittest.main()
