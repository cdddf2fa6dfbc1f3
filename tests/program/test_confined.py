"""--confined, and SLIPDISK_CONFINED: a deck, or the deck in a result, reads no file outside of its folder, by whatever key or path it
names it, and no message quotes a word of one; what lies inside is read as ever."""
import os
import re
import subprocess
import unittest

from results_common import PROGRAM, ROOT, Folder

DECK = """dt = 1e-4; steps = 20; materials = ( { name = "m"; k_n = 1e4; bond_k_n = 1.0; bond_extension = 0.01; } );
disks = ( { name = "a"; x = 0.5; y = 0.5; radius = 0.1; mass = 1; fixed = true; } );
"""
# key of the reference: what a deck says, with the path in place of PATH, and what the file holds
KEYS = {
    "disk_files.file": ('disk_files = ( { file = "PATH"; density = 1; } );', "x,y,radius\n2,2,0.1\n"),
    "box.file": ('box = { periodic = "x"; file = "PATH"; };', "ITEM: TIMESTEP\n0\nITEM: NUMBER OF ATOMS\n0\nITEM: BOX BOUNDS pp pp pp\n"
                                                           "0 4\n0 4\n-0.5 0.5\nITEM: ATOMS id type x y radius\n"),
    "motions.file": ('motions = ( { disk = "a"; coordinate = "x"; type = "table"; file = "PATH"; } );',
                     "time,value\n0,0\n0.001,0\n0.002,0\n"),
    "phases.file": ('disk_rows = ( { columns = ("x", "y"); radius = 0.1; '
                    'mass = 1; rows = ( (1.5, 0.5), (1.7, 0.5) ); } ); phases = ( { steps = 20; bond = { file = "PATH"; }; } );', "a,b\n0,1\n"),
}
INCLUDE = '\n@include "PATH"\n', 'title = "read";\n'
ENDINGS = {"box.file": ".dump"}


def keys_of_files():
    """Keys of the reference whose values are paths of files."""
    found, table = set(), ""
    for line in (ROOT / "docs/deck.md").read_text(encoding="utf-8").splitlines():
        heading = re.match(r"#+ (\w+)$", line)
        table = heading[1] if heading else table
        key = re.match(r"\|`(\w+)`\|text\|.*\|([^|]*)\|$", line)
        if key and re.search(r"\b(file|path from|dump|folder)\b", key[2]) and "file names" not in key[2]:
            found.add(f"{table}.{key[1]}")
    return found


class Confined(Folder):
    def setUp(self):
        super().setUp()
        self.home = self.folder / "home"
        (self.home / "sub").mkdir(parents=True)
        (self.home / "out").symlink_to(self.folder)

    def told(self, *words, status, **more):
        done = subprocess.run([PROGRAM, *map(str, words)], capture_output=True, text=True, timeout=120, cwd=self.folder,
                              env={**os.environ, **more}, check=False)
        self.assertEqual(done.returncode, status, (words, done.stdout[-300:], done.stderr))
        return done.stderr

    def paths(self, name):
        """Ways to a file of this name beside the deck's folder."""
        for link in ("link" + name, "sub/link" + name):
            if not os.path.lexists(self.home / link):
                (self.home / link).symlink_to(self.folder / name)
        return [f"../{name}", str(self.folder / name), f"sub/../../{name}", f"out/{name}", f"out/home/../{name}", "link" + name, "sub/link" + name]

    def deck(self, text, path, where="deck.cfg"):
        base = DECK.replace("steps = 20; ", "") if "phases" in text else DECK
        (self.home / where).write_text(base + text.replace("PATH", str(path)))
        return self.home / where

    def test_the_keys_of_this_test_are_all(self):
        self.assertEqual(keys_of_files(), set(KEYS))

    def test_files_outside_are_refused(self):
        for key, (text, content) in {**KEYS, "@include": INCLUDE}.items():
            name = "secret" + ENDINGS.get(key, ".csv")
            (self.folder / name).write_text(content)
            for path in self.paths(name):
                deck = self.deck(text, path)
                self.told("check", deck, "--brief", status=0)
                told = self.told("check", deck, "--brief", "--confined", status=2)
                self.assertIn(f'"{path}"', told)
                self.assertEqual(told.count("\n"), 1, told)
                self.assertIn("outside of the folder that --confined", told)

    def test_files_inside_are_read(self):
        for key, (text, content) in {**KEYS, "@include": INCLUDE}.items():
            name = "own" + ENDINGS.get(key, ".csv")
            for place in name, f"sub/{name}":
                (self.home / place).write_text(content)
                for path in place, self.home / place, f"out/home/{place}", f"sub/../{place}":
                    self.told("check", self.deck(text, path), "--confined", status=0)

    def test_a_file_included_from_a_folder_below_may_step_up_to_the_deck(self):
        (self.home / "sub/one.inc").write_text('@include "../two.inc"\n')
        (self.home / "two.inc").write_text('title = "two";\n')
        self.told("check", self.deck(INCLUDE[0], "sub/one.inc"), "--confined", status=0)
        (self.home / "sub/one.inc").write_text('@include "../../secret"\n')
        (self.folder / "secret").write_text("root:x:0:0\n")
        told = self.told("check", self.home / "deck.cfg", "--confined", status=2)
        self.assertIn("sub/one.inc:1: @include", told)
        self.assertNotIn("root", told)

    def test_nothing_is_told_of_what_is_outside(self):
        """Neither words of a file, nor whether there is one, nor names like it."""
        (self.folder / "secret.csv").write_text("password,radius\nhunter2,1\n")
        for text, _ in *KEYS.values(), INCLUDE:
            self.assertRegex(self.told("check", self.deck(text, "../secret.csv"), status=2), "password|secret")
            there, absent = (re.sub("secre.", "*", self.told("check", self.deck(text, f"{way}/{name}.csv"), "--confined", status=2))
                             for name, way in (("secret", "out"), ("secreu", "out")))
            self.assertEqual(there, absent)
            self.assertNotRegex(there, "password|hunter2|did you mean")
        (self.home / "dangling.csv").symlink_to(self.folder / "absent.csv")
        for text, _ in *KEYS.values(), INCLUDE:
            self.assertIn("outside of the folder", self.told("check", self.deck(text, "dangling.csv"), "--confined", status=2))

    def test_values_of_a_sweep_and_settings(self):
        text, content = KEYS["disk_files.file"]
        for path in self.home / "own.csv", self.folder / "secret.csv":
            path.write_text(content)
        sweep = text + '\nsweep = { parameters = ( { path = "disk_files[0].file"; name = "f"; values = ("own.csv", "../secret.csv"); } ); };'
        deck = self.deck(sweep, "own.csv")
        for words in ("sweep", deck, "-q", "-j", 2), ("check", deck):
            self.assertIn("../secret.csv", self.told(*words, "--confined", status=2))
        self.assertIn("outside", self.told("run", self.deck(text, "own.csv"), "--confined", "-D", 'disk_files[0].file="../secret.csv"', status=2))

    def test_commands(self):
        """Every command that reads decks, and those that read the deck of a result again."""
        text, content = KEYS["disk_files.file"]
        (self.folder / "secret.csv").write_text(content)
        deck = self.deck(text, "../secret.csv")
        for command in ("run", "-q"), ("check",), ("sweep",), ("view",), ("theory",):
            self.assertIn("outside of the folder", self.told(*command, deck, "--confined", status=2), command)
            self.assertIn("outside of the folder", self.told(*command, deck, SLIPDISK_CONFINED=str(self.home), status=2), command)
        helped = {name for name in ("run", "resume", "check", "sweep", "info", "measure", "export", "view", "theory")
                  if "--confined" in subprocess.run([PROGRAM, name, "--help"], capture_output=True, text=True, check=True).stdout}
        self.assertEqual(len(helped), 9, helped)
        self.assertIn("files of one folder", self.told("info", "home/a.h5", "b.h5", "--confined", status=2))

    def test_a_stopped_run(self):
        """The deck stands in the checkpoint, with its folder as its maker says it."""
        text, content = KEYS["disk_files.file"]
        (self.folder / "secret.csv").write_text(content)
        deck = self.deck(text, "../secret.csv")
        result = self.home / "r.h5"
        done = subprocess.Popen([PROGRAM, "run", deck, "-q", "-o", result, "-D", "steps=2e9"], cwd=self.folder)
        try:
            while not list(self.home.glob("r.h5.parts/*.h5")):
                self.assertIsNone(done.poll())
        finally:
            done.terminate()
        self.assertEqual(done.wait(60), 75)
        self.assertIn("outside of the folder", self.told("resume", result, "-q", "--confined", status=2))


if __name__ == "__main__":
    unittest.main()
