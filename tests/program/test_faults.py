"""Single calls that fail (inject/calls.c), a full disk, another run's folder: the right result, or a message and nothing
false. A small sample of what `tools/soak.sh kill faults` tries."""
import os
import pathlib
import shutil
import tempfile
import unittest

from results_common import PROGRAM, ROOT
from soak import faults, folders, kill, runs
from soak.inject import Fault
from soak.trial import Setup

SHIM = pathlib.Path(os.environ.get("SLIPDISK_BUILD_DIR", ROOT / "build/release")) / "tests/calls.so"
REFUSED = "EIO", "ENOSPC", "EACCES"


class Faults(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        program = pathlib.Path(PROGRAM)
        work = pathlib.Path(tempfile.mkdtemp(prefix="slipdisk-test-"))
        cls.setup = Setup(program, program.parent, work, "small", 1)
        cls.home = runs.scratch(cls.setup)
        cls.addClassCleanup(shutil.rmtree, cls.home, ignore_errors=True)
        cls.addClassCleanup(shutil.rmtree, work, ignore_errors=True)
        cls.run_ = runs.three(cls.setup, cls.home, series=5000).prepare()
        # all that is left is the merge
        cls.merging = kill.interrupted(cls.run_, SHIM, Fault("rename,link", 1, "kill", name="*/r.h5"))

    def count(self, **which):
        """Calls that the merge makes."""
        return len(kill.logged(self.run_, SHIM, which["call"], self.merging, which.get("name", "")))

    def tries(self, most, errors, times=1, **which):
        """Up to so many calls fail while the run merges; the errors take turns."""
        n = self.count(**which)
        self.assertGreater(n, 0, "no such call is made")
        cases = [Fault(when=when, do=errors[k % len(errors)], times=times, **which)
                 for k, when in enumerate(runs.spread(n, most))]
        row = runs.together(self.setup, str(which), cases,
                            lambda fault: faults.trial(self.run_, SHIM, self.merging, fault))
        self.assertEqual((row.trials, row.failed), (len(cases), 0), row.note)

    def test_writes(self):
        """Datasets were zeros, with status 0."""
        self.tries(14, ("ENOSPC", "EIO"), call="pwrite")
        self.tries(4, ("short",), call="write,pwrite", times=0)

    def test_parts(self):
        """A part that could not be looked at was left out, with status 0."""
        self.tries(9, ("EIO", "EACCES", "ESTALE"), call="open,stat,read", name="*/part-*")

    def test_what_makes_a_file_a_result(self):
        self.tries(6, REFUSED, call="rename,link,fsync,unlink,truncate")

    def test_interrupted(self):
        """A signal is no failure."""
        self.tries(6, ("EINTR",), call="open,read,write,fsync,lock,close", name="*/r.h5*", origin="program")

    def test_full_disk(self):
        for room in 0, 60000, 250000:
            said = faults.trial(self.run_, SHIM, None, Fault(room=room, do="ENOSPC"))
            self.assertFalse(said, said)

    def test_folder_of_a_killed_run(self):
        """Parts of another run, which had stood in the place of the first's, were merged."""
        longer = {"steps": 1000000, "checkpoint": 0.03, "series": 20000}
        first = runs.three(self.setup, self.home, **longer).prepare()
        second = runs.three(self.setup, self.home, seed=2, **longer).prepare()
        for number in range(1):
            said = folders.replaced(self.setup, first, second, number, "killed")
            self.assertEqual(said, "")

    def test_killed_at_calls(self):
        n = len(kill.logged(self.run_, SHIM, template=self.merging))
        for when in runs.spread(n, 4):
            for do in "kill", "torn":
                said = kill.at_call(self.run_, SHIM, self.merging, do, when)
                self.assertFalse(said, said)


if __name__ == "__main__":
    unittest.main()
