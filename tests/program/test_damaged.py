"""Damaged files are refused by every command and by Python's `Result`; nothing crashes. A small sample of `tools/soak.sh altered`."""
import os
import pathlib
import shutil
import sys
import tempfile
import unittest

from results_common import PROGRAM, ROOT, Folder, run, start, wait_for

sys.path[:0] = [str(ROOT / "tools"), str(ROOT / "tools" / "python")]
os.environ.setdefault("SLIPDISK_PROGRAM", str(PROGRAM))
import slipdisk  # noqa: E402
from soak import altered, damaged, runs  # noqa: E402
from soak.trial import Setup  # noqa: E402


class Damaged(Folder):
    @classmethod
    def setUpClass(cls):
        cls.work = pathlib.Path(tempfile.mkdtemp(prefix="slipdisk-test-"))
        cls.setup = Setup(pathlib.Path(PROGRAM), pathlib.Path(PROGRAM).parent, cls.work, "small", 5)
        made = runs.Run("tiny", cls.setup.program, ["run", "deck.cfg", "--quiet", "--threads", "1", "-o", "r.h5"],
                        {"deck.cfg": altered.TINY}, cls.work)
        cls.data = altered._result(made)

    @classmethod
    def tearDownClass(cls):
        shutil.rmtree(cls.work)

    def good(self, row):
        self.assertEqual(row.failed, 0, row.note)

    def test_commands(self):
        self.good(damaged.commands(self.setup, self.work, "test", self.data, 8))

    def test_result(self):
        self.good(damaged.results(self.setup, self.work, "test", self.data, 40))

    def test_without_checksum(self):
        """Files of versions without checksums are read; damaged ones crash nothing."""
        self.good(damaged.commands(self.setup, self.work, "test", self.data, 6, sealed=False))

    def test_every_bit_of_the_seal(self):
        """The checksum may be damaged, too: each of its bits, and those of the small data's."""
        path = self.work / "bit.h5"
        for at in range(len(self.data) - 2 * damaged.SEAL, len(self.data), 5):
            data = bytearray(self.data)
            data[at] ^= 1 << at % 8
            path.write_bytes(data)
            with self.assertRaises(slipdisk.FileError, msg=at):
                slipdisk.Result(path)

    def test_sealing(self):
        """`verify --seal` leaves a file that cannot be read as it is, and makes a good one sound."""
        path = self.work / "seal.h5"
        bad = self.data[:len(self.data) // 2]
        path.write_bytes(bad)
        status, _, err = run("verify", "--seal", path)
        self.assertEqual(status, 4, err)
        self.assertEqual(path.read_bytes(), bad)
        path.write_bytes(damaged.without_seal(self.data))
        self.assertEqual(run("verify", path)[0], 4)
        self.assertEqual(run("verify", "--unsealed", path)[0], 0)
        self.assertEqual(run("verify", "--seal", path)[0], 0)
        self.assertEqual(run("verify", path)[0], 0)

    def test_while_it_is_read(self):
        """What changes after it was compared is compared again; verify=False looks at nothing."""
        path = self.work / "later.h5"
        path.write_bytes(self.data)
        result = slipdisk.Result(path)
        x = result.frames["position"]
        at = self.data.index(x[0, 0].tobytes()) if x[0, 0].tobytes() in self.data else len(self.data) - 30
        path.write_bytes(altered.flip(self.data, at))
        with self.assertRaises(slipdisk.FileError):
            result.frames["position"]
        path.write_bytes(self.data + b"x" * 30)  # no checksum at its end
        with self.assertRaises(slipdisk.FileError):
            slipdisk.Result(path)
        self.assertEqual(slipdisk.Result(path, verify=False).step, result.step)

    def test_parts(self):
        """Of an unfinished run checkpoint and parts are compared."""
        place = self.work / "run"
        place.mkdir()
        (place / "deck.cfg").write_text(altered.TINY.replace("steps = 2000", "time = 1e6"))
        process, parts = start("run", "deck.cfg", "--quiet", "-o", "r.h5", cwd=place), place / "r.h5.parts"
        wait_for(lambda: len(list(parts.glob("part-*.h5"))) > 2)
        process.terminate()
        process.communicate()
        self.assertGreater(len(slipdisk.Result(place / "r.h5").series["time"]), 0)
        part = parts / "part-000001.h5"
        part.write_bytes(altered.flip(part.read_bytes(), 3000))
        broken = slipdisk.Result(place / "r.h5")
        with self.assertRaisesRegex(slipdisk.FileError, "part-000001.h5 is damaged"):
            broken.series["time"]


if __name__ == "__main__":
    unittest.main()
