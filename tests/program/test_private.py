"""A file that is written anew keeps its mode: what was private stays so, whatever writes it, and what belongs to it is not open meanwhile."""
import os
import pathlib
import shutil
import stat
import sys

from results_common import PROGRAM, ROOT, Folder, run

sys.path[:0] = [str(ROOT / "tools" / "python")]
os.environ.setdefault("SLIPDISK_PROGRAM", str(PROGRAM))
DECK = """dt = 1e-3; materials = ( { name = "m"; k_n = 1e3; } ); seed = 1;
disks = ( { name = "a"; x = 0.3; y = 0.5; radius = 0.1; mass = 1; vx = 1; }, { x = 0.7; y = 0.5; radius = 0.1; mass = 1; fixed = true; } );
steps = 400; output = { series = 20; frames = 50; contacts = 50; }; measure = { rotation = ("a"); };
"""
SWEEP = DECK + 'sweep = { parameters = ( { path = "disks[0].vx"; values = (0.5, 1); } ); };\n'


def mode(path):
    return stat.S_IMODE(os.stat(path).st_mode)


class Private(Folder):
    def setUp(self):
        super().setUp()
        (self.folder / "d.cfg").write_text(DECK)
        (self.folder / "s.cfg").write_text(SWEEP)
        self.ok("run", "d.cfg", "-o", "d.h5", "--quiet")

    def ok(self, *words):
        status, _, err = run(*words, cwd=self.folder)
        self.assertEqual(status, 0, err)

    def keeps(self, *words, made, modes=(0o600, 0o640, 0o664)):
        """The command, given again, leaves the modes of all files that it has made as they are."""
        self.ok(*words)
        for wanted in modes:
            files = [path for name in made for path in self.folder.glob(name) if path.is_file()]
            self.assertGreaterEqual(len(files), len(made), (words, made))
            for path in files:
                path.chmod(wanted)
            before = {path: path.stat().st_ino for path in files}
            self.ok(*words)
            for path in files:
                self.assertEqual(oct(mode(path)), oct(wanted), (words, path))
            self.assertTrue(any(path.stat().st_ino != inode for path, inode in before.items()), words)

    def test_results(self):
        self.keeps("run", "d.cfg", "-o", "r.h5", "--quiet", "--force", made=["r.h5"])

    def test_sweeps(self):
        self.keeps("sweep", "s.cfg", "-o", "s.sweep", "--quiet", "--force",
                   made=["s.sweep/points/*.h5", "s.sweep/*.csv", "s.sweep/*.h5"], modes=[0o600])

    def test_tables_and_exports(self):
        for form, name in ("lammps-data", "x.data"), ("lammps-dump", "x.dump"), ("extxyz", "x.xyz"), ("h5md3d", "x.h5md"):
            self.keeps("export", "d.h5", "--to", form, "-o", name, made=[name], modes=[0o640])
        self.keeps("measure", "d.h5", "--csv", "tables", made=["tables/*.csv"], modes=[0o600])
        self.keeps("measure", "d.h5", "--json", "-o", "m.json", made=["m.json"], modes=[0o600])
        self.keeps("view", "d.h5", "-o", "v.html", made=["v.html"], modes=[0o600])
        self.keeps("view", "d.cfg", "-o", "w.html", made=["w.html"], modes=[0o600])

    def test_folders(self):
        """An empty folder that an export fills stays as private."""
        for wanted in 0o700, 0o755:
            os.mkdir(self.folder / "csv", wanted)
            (self.folder / "csv").chmod(wanted)
            self.ok("export", "d.h5", "--to", "csv", "-o", "csv")
            self.assertEqual(oct(mode(self.folder / "csv")), oct(wanted))
            shutil.rmtree(self.folder / "csv")

    def test_simulations(self):
        library = pathlib.Path(os.environ["SLIPDISK_BUILD_DIR"]) / "libslipdisk.so"
        if not library.exists():
            self.skipTest("no library: sanitizer builds have none")
        os.environ["SLIPDISK_LIBRARY"] = str(library)
        import slipdisk
        simulation = slipdisk.Simulation(self.folder / "d.cfg")
        simulation.save(self.folder / "s.h5")
        (self.folder / "s.h5").chmod(0o600)
        simulation.save(self.folder / "s.h5")
        self.assertEqual(oct(mode(self.folder / "s.h5")), "0o600")

    def test_pictures(self):
        self.keeps("plot", "d.h5", "-k", "energy", "-o", "p.png", made=["p.png"], modes=[0o600])
        self.keeps("film", "d.h5", "--size", "160x160", "-o", "f.gif", made=["f.gif"], modes=[0o600])

    def test_parts(self):
        """The parts of a run that replaces a private result are private, too; others are as the umask has it."""
        deck = DECK.replace("steps = 400", "time = 1e9") + "checkpoint = 1e-9;\n"
        (self.folder / "long.cfg").write_text(deck)
        from results_common import start, wait_for
        for wanted in 0o600, 0o640, 0o644:
            (self.folder / "d.h5").chmod(wanted)
            process = start("run", "long.cfg", "--force", "--quiet", "-o", "d.h5", cwd=self.folder)
            parts = self.folder / "d.h5.parts"
            wait_for(lambda parts=parts: any(parts.glob("checkpoint-*.h5")))
            process.terminate()
            process.communicate()
            self.assertEqual(oct(mode(parts)), oct(wanted | 0o700 | (wanted & 0o444) >> 2))
            shutil.rmtree(parts)


if __name__ == "__main__":
    import unittest
    unittest.main()
