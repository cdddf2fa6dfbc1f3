"""What the first lines of the decks in inputs tell their readers to type: every command has options that exist and a deck that is
there and in order with its settings, makes what later ones read, and draws kinds that there are; every -D is a key of its deck."""
import os
import pathlib
import re
import shlex
import subprocess
import tempfile
import unittest

ROOT = pathlib.Path(os.environ.get("SLIPDISK_SOURCE_DIR", pathlib.Path(__file__).resolve().parents[2]))
PROGRAM = os.environ.get("SLIPDISK_PROGRAM", str(ROOT / "build/release/slipdisk"))
KINDS = re.findall(r'^    Kind\("(\w+)"', (ROOT / "tools/python/slipdisk/plot.py").read_text(), re.M)
SETTING = re.compile(r"-D ('[^']*'|\S+)")
DECKS = sorted(path for path in (ROOT / "inputs").rglob("*") if path.suffix in (".cfg", ".inc"))


def told(*words, cwd=ROOT):
    done = subprocess.run([PROGRAM, *map(str, words)], capture_output=True, text=True, cwd=cwd, check=False)
    return done.returncode, done.stderr


def asked(deck):
    """(line number, words) of each command, and of each remark with -D, as the command `check` of this deck."""
    for number, line in enumerate(deck.read_text(encoding="utf-8").splitlines(), 1):
        comment = line.partition("#")[2]
        command = re.match(r" {3}slipdisk (.*?)(?: {2,}.*)?$", comment)
        if command:
            yield number, shlex.split(command[1])
            continue
        for part in re.split(r"  +(?=[a-z ]+:)", comment):  # "slower: -D ...    faster: -D ..."
            settings = [shlex.split(text)[0] for text in SETTING.findall(part)]
            if settings and not any(setting.endswith("=...") for setting in settings):
                yield number, ["check", str(deck), *(word for setting in settings for word in ("-D", setting))]


class Headers(unittest.TestCase):
    def follow(self, deck, words, made):
        """One command in the folder of the deck, or of the clone if it names the deck from there; made: results of those before."""
        command, operand = words[0], next(word for word in words[1:] if not word.startswith("-"))
        if command in ("run", "sweep", "check"):
            place = ROOT if operand.startswith("inputs/") else deck.parent
            settings = [word for k, word in enumerate(words) if word == "-D" or words[k - 1] == "-D"]
            self.assertTrue((place / operand).is_file(), operand)
            if settings:  # other tests check decks as they are
                status, error = told("check", operand, "--brief", *settings, cwd=place)
                self.assertEqual(status, 0, error)
            with tempfile.TemporaryDirectory() as folder:  # the options: a file that is not there is the only mistake
                _, error = told(*("none.cfg" if word == operand else word for word in words), cwd=folder)
            self.assertRegex(error, r"none.cfg.*cannot be read|^$")
            name = words[words.index("-o") + 1] if "-o" in words else pathlib.Path(operand).stem + (".sweep" if command == "sweep" else ".h5")
            made.add(pathlib.Path(name).name)
        elif command == "plot":
            self.assertIn(operand, made)
            _, error = told(*words, cwd=deck.parent)
            self.assertNotIn("see slipdisk plot --help", error)
            self.assertLessEqual({word for k, word in enumerate(words) if words[k - 1] in ("-k", "--kind")}, set(KINDS))
        else:
            self.fail(f"a command that this test does not know: {words}")

    def test_every_command_works(self):
        count = 0
        for deck in DECKS:
            made = set()
            for number, words in asked(deck):
                with self.subTest(f"{deck.relative_to(ROOT)}:{number}", words=words):
                    self.follow(deck, words, made)
                count += 1
        self.assertGreater(count, 40)


if __name__ == "__main__":
    unittest.main()
