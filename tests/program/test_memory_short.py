"""Allocations that fail: the right result, or a message and status 4; the same trials as tools/soak.sh memory, fewer."""
import pathlib
import shutil
import sys
import tempfile
import unittest

from results_common import PROGRAM, ROOT

sys.path.insert(0, str(ROOT / "tools"))
from soak import memory  # noqa: E402
from soak.trial import Setup  # noqa: E402

PROGRAM_FOLDER = pathlib.Path(PROGRAM).parent


@unittest.skipUnless((PROGRAM_FOLDER / "tests/libinject_memory.so").exists(), "sanitizers have their own allocator")
class Memory(unittest.TestCase):
    def test_nothing_false_and_nothing_silent(self):
        work = pathlib.Path(tempfile.mkdtemp(prefix="slipdisk-test-"))
        try:
            rows = memory.run(Setup(pathlib.Path(PROGRAM), PROGRAM_FOLDER, work, "small", 2), own=3, most=2)
        finally:
            shutil.rmtree(work)
        self.assertGreater(sum(row.trials for row in rows), 80)
        self.assertEqual([f"{row.what}: {row.note}" for row in rows if row.failed], [])


if __name__ == "__main__":
    unittest.main()
