"""kill -9 at random moments, again and again: the result is that of a run that was left alone."""
import pathlib
import random
import shutil
import signal
import subprocess
import tempfile
import time
import unittest

from results_common import assert_same, deck_arguments, run, start, steps_for, wait_for


class Kill(unittest.TestCase):
    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="slipdisk-kill-"))
        self.result = self.folder / "r.h5"

    def tearDown(self):
        shutil.rmtree(self.folder, ignore_errors=True)

    def kill_until_done(self, words, longest, seed):
        chance = random.Random(seed)
        kills = 0
        while True:
            process = start("run", *words, "-o", self.result)
            try:
                # the delay grows, so that there is an end
                _, err = process.communicate(timeout=chance.uniform(0.01, longest) * (1 + kills / 20))
                self.assertEqual(process.returncode, 0, err)
                return kills
            except subprocess.TimeoutExpired:
                process.send_signal(signal.SIGKILL)
                process.communicate()
                kills += 1
                # the kill came after the end
                if self.result.exists() and not pathlib.Path(f"{self.result}.parts").exists():
                    return kills

    def test_while_running(self):
        words = deck_arguments(measure=steps_for(2), series=10000, frames=10000, checkpoint=0.02)
        whole = self.folder / "whole.h5"
        status, _, err = run("run", *words, "-o", whole)
        self.assertEqual(status, 0, err)
        for seed in range(3):
            kills = self.kill_until_done(words, 0.5, seed)
            self.assertGreater(kills, 0)
            assert_same(self, self.result, whole)
            self.assertEqual(sorted(p.name for p in self.folder.iterdir()), ["r.h5", "whole.h5"])
            self.result.unlink()

    def test_while_merging(self):
        words = deck_arguments(measure=200000, series=2, frames=2, checkpoint=0.2)
        whole = self.folder / "whole.h5"
        status, _, err = run("run", *words, "-o", whole)
        self.assertEqual(status, 0, err)
        temporary = self.folder / "r.h5.tmp"
        chance = random.Random(1)
        cut = 0
        for _ in range(6):
            process = start("run", *words, "-o", self.result)
            wait_for(lambda p=process: temporary.exists() or p.poll() is not None)
            time.sleep(chance.uniform(0, 0.1))
            process.send_signal(signal.SIGKILL)
            process.communicate()
            cut += temporary.exists()
            if self.result.exists():
                break
        self.assertGreater(cut, 0, "no merge was cut short")
        status, _, err = run("resume", self.result)
        self.assertEqual(status, 0, err)
        assert_same(self, self.result, whole)
        self.assertEqual(sorted(p.name for p in self.folder.iterdir()), ["r.h5", "whole.h5"])


if __name__ == "__main__":
    unittest.main()
