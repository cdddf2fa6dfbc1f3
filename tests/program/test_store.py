"""What lies around a run: links, files and folders that come, go and are replaced; checksums of what is finished."""
import pathlib
import shutil
import tempfile
import unittest

import h5py
import numpy

from results_common import LONG, SELDOM, assert_same, changed, deck_arguments, run, start, wait_for
from test_results import Started, long_deck

SHORT = deck_arguments(settle=1000, measure=20000)


class Links(Started):
    """None is followed where slipdisk makes names of its own."""

    def setUp(self):
        super().setUp()
        self.victim = self.folder / "victim"
        self.victim.mkdir()
        (self.victim / "part-000001.h5").write_text("mine")
        self.file = self.victim / "text"
        self.file.write_text("mine")

    def refused(self, *words):
        status, _, err = run("run", *SHORT, "-o", self.result, *words)
        self.assertEqual(status, 2, err)
        self.assertIn("symbolic link", err)
        self.assertEqual(self.file.read_text(), "mine")
        self.assertEqual((self.victim / "part-000001.h5").read_text(), "mine")

    def test_parts(self):
        self.parts.symlink_to(self.victim)
        self.refused()
        self.refused("--force")

    def test_result(self):
        self.result.symlink_to(self.file)
        self.refused("--force")
        self.result.unlink()
        self.result.symlink_to(self.folder / "nothing")
        self.refused()

    def test_log(self):
        log = self.folder / "log"
        log.symlink_to(self.file)
        self.refused("--log", log)

    def test_lock(self):
        self.parts.mkdir()
        (self.parts / "lock").symlink_to(self.file)
        status, _, err = run("run", *SHORT, "-o", self.result)
        self.assertEqual(status, 4, err)
        self.assertIn("lock", err)
        self.assertEqual(self.file.read_text(), "mine")

    def test_drafts(self):
        """Names of before, that could be foreseen."""
        for path in self.folder / "r.h5.tmp", self.parts / "checkpoint-0.h5.tmp", self.parts / "part-000001.h5.tmp":
            path.parent.mkdir(exist_ok=True)
            path.symlink_to(self.file)
        self.run_ok("run", *SHORT, "-o", self.result)
        self.assertEqual(self.file.read_text(), "mine")


class Names(Started):
    """Nothing that is not this run's is overwritten or removed."""

    @classmethod
    def setUpClass(cls):
        cls.where = pathlib.Path(tempfile.mkdtemp(prefix="slipdisk-store-"))
        cls.addClassCleanup(shutil.rmtree, cls.where)
        cls.words = long_deck()
        cls.undisturbed = cls.where / "whole.h5"
        status, _, err = run("run", *cls.words, *SELDOM, "-o", cls.undisturbed)
        assert status == 0, err

    def at_work(self, *more):
        """A run that has a checkpoint beyond step 0, and is not held at a gate, which would be within its writing."""
        process = start("run", *self.words, *more, "-o", self.result)
        wait_for(lambda: self.checkpoints() and self.checkpoints()[0] > 0 or process.poll() is not None)
        return process

    def ends(self, process, status, text):
        _, err = process.communicate(timeout=LONG)
        self.assertEqual(process.returncode, status, err)
        self.assertIn(text, err)

    def test_a_file_appears(self):
        process = self.started(*self.words)
        self.result.write_text("mine")
        self.gate.open()
        self.ends(process, 4, "is not overwritten")
        self.assertEqual(self.result.read_text(), "mine")
        status, _, err = run("run", *self.words, "-o", self.result)  # told at once, not at the end
        self.assertEqual(status, 2, err)
        self.assertIn("Move it away", err)
        self.result.unlink()
        self.run_ok("run", *self.words, *SELDOM, "-o", self.result)
        assert_same(self, self.result, self.undisturbed)

    def test_force_replaces_what_was_there(self):
        self.run_ok("run", *SHORT, "-o", self.result)
        old = self.result.read_bytes()
        self.stop(self.started(*self.words, "--force"))
        self.result.write_bytes(b"mine")
        status, _, err = run("run", *self.words, "-o", self.result)
        self.assertEqual(status, 2, err)
        self.assertEqual(self.result.read_bytes(), b"mine")
        self.result.write_bytes(old)
        self.run_ok("run", *self.words, *SELDOM, "-o", self.result)
        assert_same(self, self.result, self.undisturbed)

    def test_folder_removed(self):
        process = self.at_work("-D", "phases.measure.steps=1000000000000")
        shutil.rmtree(self.parts, ignore_errors=True)
        shutil.rmtree(self.parts, ignore_errors=True)  # a file may have come meanwhile
        self.ends(process, 4, "was removed or replaced")
        self.assertFalse(self.result.exists())
        self.run_ok("run", *self.words, *SELDOM, "-o", self.result)

    def test_folder_of_another_run(self):
        """The folder is moved away and another run started under the same name."""
        first = self.at_work()
        self.parts.rename(self.folder / "moved")
        second = start("run", *self.words, "-D", "seed=2", "-o", self.result)
        self.ends(first, 4, "was removed or replaced")
        out, err = second.communicate(timeout=LONG)
        self.assertEqual(second.returncode, 0, err)
        with h5py.File(self.result) as file:
            self.assertEqual(file["parameters"].attrs["seed"], 2)
            steps = file["observables/work/step"][()]
            self.assertTrue((numpy.diff(steps) > 0).all())
        other = self.folder / "other.h5"
        self.run_ok("run", *self.words, *SELDOM, "-D", "seed=2", "-o", other)
        assert_same(self, self.result, other)
        # and the first goes on where its folder is
        self.result.unlink()
        (self.folder / "moved").rename(self.parts)
        self.run_ok("run", *self.words, *SELDOM, "-o", self.result)
        assert_same(self, self.result, self.undisturbed)


class Checksums(Started):
    def setUp(self):
        super().setUp()
        self.run_ok("run", *SHORT, "-o", self.result)

    def flip(self, at):
        data = bytearray(self.result.read_bytes())
        data[at] ^= 16
        self.result.write_bytes(data)

    def test_verify(self):
        out, _ = self.run_ok("verify", self.result)
        self.assertIn("sound", out)
        for at in 100, 5000, -30, -3:
            self.flip(at)
            for words in (["verify"], ["info"], ["info", "--json"], ["measure"]):
                status, out, err = run(*words, self.result)
                self.assertEqual(status, 4, (at, words, err))
                self.assertIn("r.h5 is damaged", err)
            self.flip(at)
        self.run_ok("verify", self.result, "--quiet")

    def test_changed_on_purpose(self):
        with h5py.File(self.result, "r+") as file:
            file["mine"] = [1.0, 2.0]
        status, _, err = run("info", self.result)
        self.assertEqual(status, 4)
        self.assertIn("changed by another program", err)
        self.run_ok("verify", "--seal", self.result)
        self.run_ok("info", self.result)
        with h5py.File(self.result) as file:
            self.assertEqual(file["mine"][1], 2.0)

    def test_without_checksum(self):
        """A result of before is read; that nothing is known of it is told."""
        with h5py.File(self.result, "r+") as file:
            del file.attrs["sealed"]
        self.run_ok("info", self.result)
        status, _, err = run("verify", self.result)
        self.assertEqual(status, 4)
        self.assertIn("has no checksum", err)

    def test_of_others(self):
        with changed(self.result) as file:
            file["state"].attrs["format"] = 1000
            file["h5md/creator"].attrs["version"] = "7.5"
        for words in (["info"], ["measure"]):
            status, _, err = run(*words, self.result)
            self.assertEqual(status, 2, err)
            self.assertIn("newer slipdisk, version 7.5", err)
        with changed(self.result) as file:
            file["h5md/creator"].attrs["name"] = "granulate"
        status, _, err = run("info", self.result)
        self.assertEqual(status, 2, err)
        self.assertIn("written by granulate", err)

    def test_info_steps_back(self):
        self.result.unlink()
        self.stop(self.started(*long_deck()))
        newest = self.parts / f"checkpoint-{self.checkpoints()[0]}.h5"
        data = bytearray(newest.read_bytes())
        data[-200] ^= 1
        newest.write_bytes(data)
        _, err = self.run_ok("info", self.result)
        self.assertIn(f"{newest.name} is damaged", err)
        self.assertIn("an older checkpoint is read", err)
        status, _, err = run("verify", self.result)
        self.assertEqual(status, 4)
        self.assertIn(newest.name, err)


if __name__ == "__main__":
    unittest.main(defaultTest=["Links", "Names", "Checksums"])
