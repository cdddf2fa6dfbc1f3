"""The command `slipdisk` that pip installs starts the program of its own environment, whatever lies on PYTHONPATH."""
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

ROOT = pathlib.Path(os.environ.get("SLIPDISK_SOURCE_DIR", pathlib.Path(__file__).resolve().parents[2]))
LAUNCHER = ROOT / "tools/packaging/slipdisk.py"
SAYS = '#!/bin/sh\necho "{} $SLIPDISK_PYTHON $*"\n'


def executable(path, text):
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text)
    path.chmod(0o755)


class Launcher(unittest.TestCase):
    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="slipdisk-test-"))
        self.addCleanup(shutil.rmtree, self.folder)
        self.python = self.folder / "venv/bin/python"
        subprocess.run([sys.executable, "-m", "venv", "--without-pip", self.folder / "venv"], check=True)
        self.packages = pathlib.Path(subprocess.run([self.python, "-c", "import sysconfig; print(sysconfig.get_path('platlib'))"],
                                                    capture_output=True, text=True, check=True).stdout.strip())
        executable(self.packages / "slipdisk/bin/slipdisk", SAYS.format("own"))
        (self.packages / "slipdisk/__init__.py").write_text("raise ImportError('the launcher imports no package')\n")
        self.command = self.folder / "venv/bin/slipdisk"
        executable(self.command, LAUNCHER.read_text().replace("#!python", f"#!{self.python}", 1))  # as pip does

    def call(self, path=None, command=None, **more):
        environment = {"PATH": "/usr/bin:/bin", **({} if path is None else {"PYTHONPATH": str(path)}), **more}
        return subprocess.run([command or self.command, "a", "b c"], env=environment, cwd=self.folder, capture_output=True, text=True)

    def test_pythonpath(self):
        other = self.folder / "other"
        executable(other / "whole/slipdisk/bin/slipdisk", SAYS.format("other"))
        (other / "module").mkdir()
        (other / "module/slipdisk.py").write_text("raise SystemExit('imported')\n")
        (other / "shadows").mkdir()
        for name in ("importlib", "sysconfig", "pathlib", "slipdisk", "shutil", "site_packages"):
            (other / f"shadows/{name}.py").write_text("raise SystemExit('imported')\n")
        (other / "broken/slipdisk").mkdir(parents=True)
        (other / "broken/slipdisk/__init__.py").write_text("raise SystemExit('imported')\n")
        (other / "folder/slipdisk/bin/slipdisk").mkdir(parents=True)
        paths = [None, "", ":", ".", ROOT / "tools/python", self.packages, "/not/there", "other/whole", *other.iterdir(),
                 ":".join(map(str, [*other.iterdir(), ROOT / "tools/python"]))]
        for path in paths:
            with self.subTest(path):
                done = self.call(path)
                self.assertEqual((done.returncode, done.stdout, done.stderr), (0, f"own {self.python} a b c\n", ""))
        self.assertEqual(self.call(SLIPDISK_PYTHON="/mine").stdout, "own /mine a b c\n")

    def test_other_places(self):
        """pip install --target; packages on PYTHONPATH alone; none at all."""
        target = self.folder / "target"
        executable(target / "slipdisk/bin/slipdisk", SAYS.format("target"))
        executable(target / "bin/slipdisk", self.command.read_text())
        self.assertEqual(self.call(ROOT / "tools/python", target / "bin/slipdisk").stdout, f"target {self.python} a b c\n")
        shutil.rmtree(self.packages / "slipdisk")
        self.assertEqual(self.call(target).stdout, f"target {self.python} a b c\n")
        done = self.call(ROOT / "tools/python")
        self.assertEqual((done.returncode, done.stderr.count("\n")), (4, 1))
        self.assertIn(f"is not in the packages of {self.python}; install it", done.stderr)


if __name__ == "__main__":
    unittest.main()
