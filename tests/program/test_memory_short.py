"""Allocations that fail: the right result, or a message and status 4; the same trials as tools/soak.sh memory, fewer."""
import pathlib
import re
import shutil
import sys
import tempfile
import unittest

from results_common import PROGRAM, ROOT

sys.path.insert(0, str(ROOT / "tools"))
from soak import memory  # noqa: E402
from soak.trial import Setup  # noqa: E402

PROGRAM_FOLDER = pathlib.Path(PROGRAM).parent


SAVED = re.compile(r"error: no memory \(\d+ bytes more\); everything until step (\d+) is saved, continue with: "
                   r"slipdisk resume (\S+)\n")
FOUR = ["-D", "sweep.replicas=1", "-D", 'sweep.parameters=({ path = "gravity.tilt"; values = (0.0, 0.01, 0.02, 0.03); })']


@unittest.skipUnless((PROGRAM_FOLDER / "tests/libinject_memory.so").exists(), "sanitizers have their own allocator")
class Memory(unittest.TestCase):
    def setUp(self):
        self.work = pathlib.Path(tempfile.mkdtemp(prefix="slipdisk-test-"))
        self.addCleanup(shutil.rmtree, self.work)
        self.setup = Setup(pathlib.Path(PROGRAM), PROGRAM_FOLDER, self.work, "small", 2)

    def test_nothing_false_and_nothing_silent(self):
        rows = memory.run(self.setup, own=3, most=2)
        self.assertGreater(sum(row.trials for row in rows), 80)
        self.assertEqual([f"{row.what}: {row.note}" for row in rows if row.failed], [])

    def test_libraries_that_crash_are_told(self):
        trials, crashes = memory.Trials(self.setup), 0
        for n in range(20, 400, 10):
            end = trials.call(["check", memory.THREE / "random.cfg", "--no-probe"], self.work, at=n)
            self.assertIn(end.status, (0, 2, 4), n)
            self.assertTrue(end.status == 0 or end.err.startswith(b"error: "), (n, end.err))
            crashes += b"a library has crashed" in end.err
        self.assertGreater(crashes, 0)

    def test_a_run_says_what_is_saved(self):
        trials = memory.Trials(self.setup)
        memory.begin(trials, self.work / "begun")
        last = max(int(path.stem.split("-")[1]) for path in (self.work / "begun").glob("*.parts/checkpoint-*.h5"))
        told = None
        for n in range(200, 7000, 400):
            folder = self.work / f"from-{n}"
            shutil.copytree(self.work / "begun", folder)
            end = trials.call(["resume", "DIR/r.h5", "--threads", "1", "--quiet"], folder, at=n, on=True, own=True)
            told = SAVED.search(end.err.decode())
            if told:
                break
        self.assertTrue(told, "no message of the kind")
        self.assertEqual(end.status, 4)
        self.assertGreaterEqual(int(told[1]), last)
        self.assertEqual(told[2], str(folder / "r.h5"))
        self.assertEqual(trials.call(["resume", told[2], "--quiet"], folder).status, 0)

    def test_points_of_a_worker_without_memory(self):
        trials = memory.Trials(self.setup)
        words = ["sweep", memory.THREE / "random.cfg", *memory.STEPS, *FOUR, "-j", "2", "--no-lanes", "-o", "DIR/s"]
        for n in range(1000, 12000, 500):
            folder = self.work / f"at-{n}"
            folder.mkdir()
            end = trials.call(words, folder, at=n, own=True)
            if b": failed: no memory" in end.err:
                break
        self.assertIn(b": failed: no memory", end.err)
        self.assertEqual(end.status, 4)
        self.assertEqual(trials.call(words, folder).status, 0)


if __name__ == "__main__":
    unittest.main()
