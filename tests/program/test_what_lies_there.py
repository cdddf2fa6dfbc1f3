"""What lies at a name is read before it is believed: (what lies there) x (command) -> status and message. A file that the
disk keeps from being read is never called damaged or finished, and nothing is overwritten because of it."""
import os
import pathlib
import re
import shutil
import tempfile
import unittest

from results_common import CALLS, Fault, run, start, wait_for

DECK = """dt = 1e-4; gravity = { g = 10.0; }; materials = ( { name = "m"; k_n = 1e4; } ); checkpoint = 0.02;
disks = ( { x = 0.0; y = 0.0; radius = 1.0; mass = 1.0; fixed = true; }, { x = 0.0; y = 1.9999; radius = 1.0; mass = 1.0; } );
output = { series = 100; };
"""
SHORT = DECK + 'phases = ( { name = "measure"; steps = 200; } );\n'
LONG = DECK + 'phases = ( { name = "measure"; steps = 1000000000; } );\n'
SWEEP = SHORT + 'sweep = { parameters = ( { path = "gravity.g"; values = (9.0, 10.0, 11.0); } ); };\n'
NO_FILE, NOT_READ = "it is a device or a pipe", r"cannot (open|read|read the end of) \S+: {}"
# Content of r.h5: answers (status, message) of resume and of the others that read results, and the answer of run.
FILES = {
    "truncated": ((4, "truncated file"), (2, "damaged or no result")),
    "empty": ((4, "not an HDF5 file"), (2, "damaged or no result")),
    "python": ((4, "not an HDF5 file"), (2, "damaged or no result")),
    "flipped": ((4, "checksum does not fit"), (2, "damaged or no result")),
    "pipe": ((4, NO_FILE), (2, "is a device or a pipe")),
    "link to a device": ((4, NO_FILE), (2, "symbolic link")),
    "not read": ((4, NOT_READ.format("Input/output")), (4, NOT_READ.format("Input/output"))),
    "not opened": ((4, NOT_READ.format("Permission")), (4, NOT_READ.format("Permission"))),
    "checkpoint": (None, (2, "damaged or no result")),
    "sound": ((0, "r.h5|2 disks"), (2, "finished already")),
}
READERS = ("resume", "r.h5"), ("info", "r.h5"), ("measure", "r.h5"), ("verify", "r.h5"), ("view", "r.h5", "-o", "page.html"), \
    ("export", "r.h5", "--to", "csv", "-o", "made")


class There(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.base = pathlib.Path(tempfile.mkdtemp(prefix="slipdisk-there-"))
        cls.addClassCleanup(shutil.rmtree, cls.base)
        for name, text in ("short", SHORT), ("long", LONG), ("sweep", SWEEP):
            (cls.base / f"{name}.cfg").write_text(text)
        assert run("run", "short.cfg", "-q", "-o", "good.h5", cwd=cls.base)[0] == 0
        assert run("sweep", "sweep.cfg", "-q", cwd=cls.base)[0] == 0
        process, parts = start("run", "long.cfg", "-q", cwd=cls.base), cls.base / "long.h5.parts"
        wait_for(lambda: len(list(parts.glob("part-*.h5"))) > 3)
        process.terminate()
        assert process.wait() == 75

    def setUp(self):
        self.top = pathlib.Path(tempfile.mkdtemp(prefix="slipdisk-there-"))
        self.addCleanup(shutil.rmtree, self.top)
        shutil.copytree(self.base, self.top, dirs_exist_ok=True)
        self.parts = self.top / "long.h5.parts"
        self.good = (self.top / "good.h5").read_bytes()

    def newest(self):
        return max(self.parts.glob("checkpoint-*.h5"), key=lambda path: int(path.stem.split("-")[1]))

    def without(self, call, error, name):
        """An environment in which such calls fail for files of such names."""
        fault = Fault(call=call, when=1, do=error, times=0, name=name)
        return {**os.environ, **fault.environment(CALLS, self.top)}

    def ask(self, status, message, *words, env=None):
        found, out, err = run(*words, cwd=self.top, env=env)
        self.assertEqual(found, status, (words, out[:300] + err))
        self.assertRegex(out + err, message, words)
        return out + err

    def lay(self, what, path):
        """Puts it there; returns the environment of the command."""
        flipped = bytearray(self.good)
        flipped[len(flipped) // 2] ^= 4
        content = {"truncated": self.good[:5000], "empty": b"", "python": b"print(1)\n", "flipped": bytes(flipped),
                   "checkpoint": self.newest().read_bytes()}
        if what == "pipe":
            os.mkfifo(path)
        elif what == "link to a device":
            path.symlink_to("/dev/null")
        else:
            path.write_bytes(content.get(what, self.good))
        if what == "not read":
            return self.without("read,pread", "EIO", f"*/{path.name}")
        return self.without("open", "EACCES", f"*/{path.name}") if what == "not opened" else None

    def test_files(self):
        path = self.top / "r.h5"
        for what, (read, ran) in FILES.items():
            env = self.lay(what, path)
            before = path.read_bytes() if path.is_file() else None
            for words in READERS if read else ():
                with self.subTest(what, command=words[0]):
                    self.ask(*read, *words, env=env)
                    shutil.rmtree(self.top / "made", ignore_errors=True)
            with self.subTest(what, command="run"):
                said = self.ask(*ran, "run", "short.cfg", "-q", "-o", "r.h5", env=env)
                self.assertEqual("--force" in said, ran[0] == 2 and path.is_file() and not path.is_symlink(), said)
            self.assertEqual(path.read_bytes() if path.is_file() else None, before)
            self.assertFalse((self.top / "r.h5.parts").exists())
            path.unlink()
        self.ask(4, NO_FILE, "resume", "/dev/null")

    def test_one_status_for_what_a_command_does_not_read(self):
        """Every command, with a deck where a result is expected, the other way round, and with a name of nothing."""
        results = {"info": (), "measure": (), "verify": (), "plot": (), "film": (), "resume": (), "export": ("--to", "csv")}
        decks = {"run": (), "check": (), "theory": (), "sweep": ()}
        known = {*results, *decks, "view", "help"}
        self.assertEqual(set(re.findall(r"^  slipdisk ([a-z]+) .*  [A-Z]", run("help")[1], re.M)) - {"version"}, known)
        shutil.copy(self.top / "short.cfg", self.top / "part.inc")
        for command, more in results.items():
            for name, said in ("short.cfg", "short.cfg is a deck; slipdisk run short.cfg makes"), ("part.inc", "part.inc is a deck"), \
                    ("none.h5", "there is neither a result none.h5 nor"), ("none.cfg", "there is neither a result none.cfg nor"):
                with self.subTest(command, name=name):
                    self.ask(2, said, command, name, *more)
        for command in decks:
            for name, said in ("good.h5", "it is an HDF5 file, not a text"), ("none.cfg", "No such file"):
                with self.subTest(command, name=name):
                    self.ask(2, said, command, name)

    def test_disks_of_a_deck(self):
        """The reason stands beside the place in the deck."""
        (self.top / "disks.cfg").write_text('dt = 1e-4; steps = 1; materials = ( { name = "m"; k_n = 1e4; } );\n'
                                            'disk_files = ( { file = "r.h5"; } );\n')
        words = {"python": "it is a text", "sound": "1 free, 1 fixed", "checkpoint": "1 free, 1 fixed",
                 "not read": "Input/output error", "not opened": "Permission denied"}
        for what, (read, _) in FILES.items():
            env = self.lay(what, self.top / "r.h5")
            with self.subTest(what):
                self.ask(0 if what in ("sound", "checkpoint") else 2, words.get(what) or read[1], "check", "disks.cfg",
                         "--no-probe", env=env)
            (self.top / "r.h5").unlink()

    def test_reads_that_fail_once(self):
        """A sound result is none that is damaged because one call has failed."""
        shutil.copy(self.top / "good.h5", self.top / "r.h5")
        for when in range(1, 6):
            fault = Fault(call="read,pread", when=when, do="EIO", name="*/r.h5")
            env = {**os.environ, **fault.environment(CALLS, self.top)}
            said = run("run", "short.cfg", "-q", "-o", "r.h5", cwd=self.top, env=env)
            self.assertRegex(f"{said[0]} {said[2]}", r"\A(2 error: r.h5 is finished already|4 error: cannot read)")

    def test_a_checkpoint_is_no_result(self):
        """Nor is its run finished: its parts were removed."""
        shutil.copy(self.newest(), self.top / "away.h5")
        self.ask(2, "is a checkpoint away from its folder", "resume", "away.h5")
        self.ask(0, "NOT finished", "info", "away.h5")
        shutil.copy(self.newest(), self.top / "long.h5")
        before = sorted(path.name for path in self.parts.iterdir())
        self.ask(2, "has appeared, or was changed", "run", "long.cfg", "-q")
        self.assertEqual(sorted(path.name for path in self.parts.iterdir()), before)

    def test_unfinished_runs(self):
        """What cannot be read is not set aside as damaged, and no advice is given to begin anew."""
        before = sorted(path.name for path in self.parts.iterdir())
        for name in "*/checkpoint-*", "*/part-*":
            said = self.ask(4, "long.h5 cannot go on now; what is saved is left as it is", "run", "long.cfg", "-q",
                            env=self.without("read,pread", "EIO", name))
            self.assertRegex(said, "Input/output error")
            self.assertNotIn("--force", said)
            self.assertEqual(sorted(path.name for path in self.parts.iterdir()), before)
        (self.parts / "part-000002.h5").unlink()
        for words in ("info",), ("info", "--json"), ("measure",):
            self.ask(0, r"warning: \S+part-000002\.h5 is missing", *words, "long.h5")
        for words in ("verify", "long.h5"), ("resume", "long.h5", "-q"):
            self.ask(4, "part-000002.h5: No such file", *words)
        for path in self.parts.glob("checkpoint-*"):
            path.unlink()
        self.ask(4, "has parts but no checkpoint", "verify", "long.h5")

    def test_folders(self):
        """There must be something to verify."""
        for name in "folder", "r.h5.parts", "r.sweep/points":
            (self.top / name).mkdir(parents=True)
        for name in "folder", "r.h5.parts", "r.h5", "r.sweep":
            self.ask(2, "there is nothing to verify in", "verify", name)
        self.ask(0, "good.h5: sound", "verify", ".")

    def test_sweeps(self):
        """(what is wrong with a finished sweep) x (command) -> status, message; its table is never made poorer by a disk."""
        self.ask(0, "6 files, 0 damaged", "verify", "sweep.sweep")
        table, point = self.top / "sweep.sweep/table.csv", self.top / "sweep.sweep/points/g=10.h5"
        before = table.read_bytes()
        for call, error in ("read,pread", "EIO"), ("open", "EACCES"):
            env = self.without(call, error, "*/g=10.h5")
            for words in (), ("-j", "2"), ("--table",), ("--point", "1"), ("--point", "0-2"), ("--status",):
                said = self.ask(0 if words == ("--status",) else 4, NOT_READ.format("(Input|Permission)"), "sweep", "sweep.cfg",
                                *words, env=env)
                self.assertNotIn("--force", said)
                self.assertNotIn("damaged", said)
                self.assertEqual(table.read_bytes(), before, words)
            self.ask(4, NOT_READ.format("(Input|Permission)"), "verify", "sweep.sweep", env=env)
        wrongs = {
            r"g=10\.h5 is missing": point.unlink,
            r"table\.csv is not the table that": lambda: table.write_text("junk"),
            r"means\.csv is not the table that": lambda: (table.parent / "means.csv").write_text("junk"),
            r"means\.csv is missing": (table.parent / "means.csv").unlink,
            r"table\.h5 is not an HDF5 file": lambda: (table.parent / "table.h5").write_text("junk"),
            r"g=9\.h5 is missing": lambda: shutil.rmtree(table.parent / "points"),
        }
        for message, harm in wrongs.items():
            harm()
            said = self.ask(4, message, "verify", "sweep.sweep")
            self.assertRegex(said, r"\d files, [1-9] damaged|error: ")
            shutil.rmtree(self.top / "sweep.sweep")
            shutil.copytree(self.base / "sweep.sweep", self.top / "sweep.sweep")


if __name__ == "__main__":
    unittest.main()
