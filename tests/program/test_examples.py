"""The examples of inputs/examples do what their first lines say."""
import os
import pathlib
import re
import subprocess
import tempfile
import unittest

SOURCE = pathlib.Path(os.environ["SLIPDISK_SOURCE_DIR"])
BUILD = pathlib.Path(os.environ["SLIPDISK_BUILD_DIR"])


def run(name, *arguments, cwd=None):
    done = subprocess.run([BUILD / "examples" / name, *arguments], capture_output=True, text=True, cwd=cwd)
    if done.returncode or done.stderr:
        raise AssertionError(f"{name}: status {done.returncode}\n{done.stdout}{done.stderr}")
    return done.stdout


def numbers(text, pattern):
    return [tuple(map(float, found)) for found in re.findall(pattern, text)]


class Examples(unittest.TestCase):
    def test_every_example_is_tried_here(self):
        tried = {name[5:] for name in dir(self) if name.startswith("test_") and "every" not in name}
        self.assertEqual(tried, {p.stem for p in (SOURCE / "inputs/examples").glob("*.c")})

    def test_ratchet(self):
        rows = numbers(run("ratchet"), r"tilt +(\S+) +Omega +(\S+) \+- (\S+)")
        (_, left, left_error), (_, level, _), (_, right, right_error) = rows
        self.assertGreater(right, 10 * right_error)
        self.assertLess(abs(left + right), 3 * (left_error + right_error))
        self.assertLess(abs(level), 0.01 * right)

    def test_drum(self):
        rows = numbers(run("drum", SOURCE / "inputs/packing/drum.cfg"), r"time +(\S+) +slope +(\S+) deg")
        self.assertEqual(len(rows), 11)
        flowing = [slope for _, slope in rows[4:]]
        self.assertTrue(all(-35 < slope < -18 for slope in flowing), flowing)

    def test_force_field(self):
        rows = numbers(run("force_field"), r"mean spin (\S+) +work of the field +(\S+) +residual of the budget +(\S+)")
        self.assertEqual(len(rows), 5)
        for spin, work, residual in rows:
            self.assertAlmostEqual(spin, 0.2, delta=0.005)
            self.assertGreater(work, 50)
            self.assertLess(abs(residual), 1e-4)

    def test_packing(self):
        with tempfile.TemporaryDirectory() as folder:
            rows = numbers(run("packing", cwd=folder), r"from a speed of +(\S+): it lies at a height of (\S+)")
            page = subprocess.run([os.environ["SLIPDISK_PROGRAM"], "info", "packing.h5"], cwd=folder,
                                  capture_output=True, text=True)
        (slow, high), (fast, deep) = rows
        self.assertLess(slow, fast)
        self.assertLess(deep, high)
        self.assertEqual(page.returncode, 0, page.stderr)
        self.assertIn("400 disks", page.stdout)


if __name__ == "__main__":
    unittest.main()
