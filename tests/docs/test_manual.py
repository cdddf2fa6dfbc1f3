"""Help, pages of the manual and completion for bash, all written from the tables of the commands: pages name every option
and are in order for groff and mandoc; the tab key completes; every example of a help runs."""
import os
import pathlib
import re
import shutil
import subprocess
import tempfile
import unittest

ROOT = pathlib.Path(os.environ.get("SLIPDISK_SOURCE_DIR", pathlib.Path(__file__).resolve().parents[2]))
PROGRAM = os.environ.get("SLIPDISK_PROGRAM", str(ROOT / "build/release/slipdisk"))


def told(*words, status=0):
    done = subprocess.run([PROGRAM, *words], capture_output=True, text=True, timeout=600)
    assert done.returncode == status, f"{words}: status {done.returncode}: {done.stderr}"
    return done.stdout if status == 0 else done.stderr


COMMANDS = re.findall(r"^  slipdisk ([a-z]+) +\[?[A-Z]", told("help"), re.M)
OPTION = re.compile(r"^  (?:-(\w),|   ) --([\w-]+)(?: (\S+))?", re.M)


def shown(page):
    """Text of a page as a reader sees it, in one line."""
    text = re.sub(r"\\f[BRI]", "", page).replace("\\-", "-").replace("\\e", "\\").replace("\\&", "")
    return " ".join(text.split())


class Pages(unittest.TestCase):
    def test_every_command_has_a_page_with_its_options(self):
        self.assertIn("run", COMMANDS)
        self.assertIn("help", COMMANDS)
        first = shown(told("help", "--man"))
        for command in COMMANDS:
            page, listing = told("help", "--man", command), told("help", command)
            self.assertEqual(listing, told(command, "--help"))
            self.assertRegex(page, rf"^\.TH SLIPDISK\\-{command.upper()} 1 ")
            self.assertIn(f"slipdisk-{command}(1)", first)
            for section in ("NAME", "SYNOPSIS", "DESCRIPTION", "OPTIONS", "EXIT STATUS", "EXAMPLES", "SEE ALSO"):
                self.assertIn(f"\n.SH {section}\n", page)
            options = OPTION.findall(listing)
            self.assertTrue(options)
            for letter, name, value in options:
                head = (f"-{letter}, " if letter else "") + f"--{name}" + (f" {value}" if value else "")
                self.assertIn(f".TP {head} ", shown(page), command)
        for section in ("COMMANDS", "EXIT STATUS", "ENVIRONMENT", "FILES", "EXAMPLES"):
            self.assertIn(f".SH {section}", first)

    def test_the_help_lists_the_statuses_of_the_page(self):
        numbers = re.findall(r"^  (\d+) ", told("help").split("Exit status:")[1], re.M)
        self.assertEqual(numbers, ["0", "2", "3", "4", "5", "6", "75"])
        page = told("help", "--man").split(".SH EXIT STATUS")[1].split(".SH")[0]
        self.assertEqual(re.findall(r"\.TP\n\\fB(\d+)", page), numbers)

    def test_formatters_have_nothing_to_say(self):
        tools = [words for words in (["groff", "-ww", "-z", "-man", "-Tutf8"], ["mandoc", "-T", "lint", "-W", "warning"])
                 if shutil.which(words[0])]
        for words in tools:
            for command in ["", *COMMANDS]:
                page = told("help", "--man", *filter(None, [command]))
                done = subprocess.run(words, input=page, capture_output=True, text=True, timeout=60)
                self.assertEqual((done.returncode, done.stdout + done.stderr), (0, ""), f"{words[0]}: {command}")

    def test_mistakes(self):
        self.assertIn('there is no command "rum"; did you mean "run"?', told("help", "--man", "rum", status=2))
        self.assertIn("unknown option --mann (did you mean --man?)", told("help", "--mann", status=2))
        self.assertIn("one command is expected", told("help", "run", "info", status=2))


class Completion(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)
        self.here = pathlib.Path(self.folder.name)
        (self.here / "slipdisk.bash").write_text(told("help", "--bash"))
        for name in ("deck.cfg", "other deck.cfg", "deck.h5", "notes.txt"):
            (self.here / name).touch()
        (self.here / "deck.sweep").mkdir()

    def complete(self, *words):
        """What the tab key offers behind these words, the last of which is begun; = is a word, as bash has it."""
        script = 'source ./slipdisk.bash; COMP_WORDS=("$@"); COMP_CWORD=$(($# - 1)); _slipdisk; printf "%s\\n" "${COMPREPLY[@]}"'
        done = subprocess.run(["bash", "--norc", "-c", script, "bash", "slipdisk", *words], cwd=self.here,
                              capture_output=True, text=True, timeout=60)
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        return sorted(filter(None, done.stdout.split("\n")))

    def test_commands(self):
        self.assertEqual(self.complete("ru"), ["run"])
        self.assertEqual(self.complete(""), sorted([*COMMANDS, "version", "--help", "--version"]))
        self.assertEqual(self.complete("help", "swe"), ["sweep"])

    def test_options_of_each_command(self):
        for command in COMMANDS:
            expected = set()
            for letter, name, _ in OPTION.findall(told("help", command)):
                expected |= {f"--{name}"} | ({f"-{letter}"} if letter else set())
            self.assertEqual(self.complete(command, "-"), sorted(expected))
        self.assertEqual(self.complete("sweep", "deck.cfg", "--no"), ["--no-lanes", "--no-wait"])

    def test_operands(self):
        wanted = {"DECK": ["deck.cfg", "other deck.cfg"], "FILE": ["deck.h5"], "SWEEP": [], "COMMAND": None}
        for command in COMMANDS:
            operands = re.search(r"^usage: slipdisk \S+ \[options\] (.*)", told("help", command), re.M).group(1)
            kinds = re.findall(r"[A-Z]+", operands)
            self.assertTrue(kinds and set(kinds) <= set(wanted), operands)
            if kinds != ["COMMAND"]:
                files = {name for kind in kinds for name in wanted[kind]} | {"deck.sweep"}
                self.assertEqual(self.complete(command, ""), sorted(files), command)

    def test_values(self):
        self.assertEqual(self.complete("run", "-o", ""),
                         ["deck.cfg", "deck.h5", "deck.sweep", "notes.txt", "other deck.cfg", "slipdisk.bash"])
        self.assertEqual(self.complete("run", "--log", "=", "no"), ["notes.txt"])
        self.assertEqual(self.complete("run", "--log", "="), self.complete("run", "--log", ""))
        self.assertEqual(self.complete("sweep", "-o", ""), ["deck.sweep"])
        self.assertEqual(self.complete("run", "--threads", ""), [])
        self.assertEqual(self.complete("run", "-D", "seed", "=", ""), [])
        self.assertEqual(self.complete("plot", "deck.h5", "-k", "st"), ["stress"])
        for extra, meant in (("plot", "stress"), "--kind stress"), (("export", "vtk"), "--to vtk"), (("film", "spin"), "--color spin"):
            self.assertIn(f'"{extra[1]}" is a second; did you mean {meant}?', told(extra[0], "deck.h5", extra[1], status=2))
        for command in COMMANDS:
            for letter, name, value in OPTION.findall(told("help", command)):
                if re.fullmatch(r"[a-z0-9-]+(\|[a-z0-9-]+)+", value):
                    self.assertEqual(self.complete(command, f"--{name}", ""), sorted(value.split("|")))
                    self.assertIn(f"expected {value}", told(command, f"--{name}", "nonsense", "deck.cfg", status=2))

    def test_kinds_of_pictures(self):
        """Those of the Python package, which draws them."""
        kinds = re.findall(r'^    Kind\("(\w+)"', (ROOT / "tools/python/slipdisk/plot.py").read_text(), re.M)
        self.assertEqual(self.complete("plot", "--kind", "=", ""), sorted([*kinds, "list"]))

    def test_paths_of_keys(self):
        """Behind -D: every key of the reference, and each is a path that -D knows."""
        self.assertEqual(self.complete("run", "deck.cfg", "-D", "gravity.t"), ["gravity.tilt="])
        self.assertEqual(self.complete("check", "--define", "=", "measure.sl"), ["measure.sliding[0].disk=", "measure.sliding[0].partners="])
        paths = self.complete("sweep", "-D", "")
        reference, table = set(), ""
        for line in (ROOT / "docs/deck.md").read_text(encoding="utf-8").splitlines():
            heading, key = re.match(r"### ([a-z_.]+)$", line), re.match(r"\|`(\w+)`\|([^|]+)\|", line)
            table = heading[1] if heading else table
            if key and key[2] not in ("group", "list of groups"):
                reference.add(f"{table}.{key[1]}".removeprefix("deck."))
        found = {re.sub(r"\[0\]|=$", "", path) for path in paths}
        self.assertEqual(reference - found, set())
        self.assertEqual(len(found), len(paths))
        (self.here / "least.cfg").write_text("dt = 1e-4;\n")
        for path in paths:
            done = subprocess.run([PROGRAM, "check", "least.cfg", "-D", path + "1"], cwd=self.here, capture_output=True, text=True, check=False)
            self.assertNotRegex(done.stderr, "unknown key|no such key", path)

    def test_bash_itself_calls_it(self):
        """With a terminal: what stands on the line after a tab."""
        keys = "source ./slipdisk.bash\nexport PS1=\nslipdisk run oth\t\x01echo \nexit\n"
        done = subprocess.run(["script", "-qec", "bash --norc --noprofile -i", "/dev/null"], cwd=self.here, input=keys,
                              capture_output=True, text=True, timeout=60, env={**os.environ, "TERM": "dumb", "HOME": "/nowhere"})
        self.assertIn("\nslipdisk run other deck.cfg", done.stdout.replace("\r", ""))


class Examples(unittest.TestCase):
    """In a folder with a deck of three disks and a sweep of it, in the order of the commands."""
    def test_they_run(self):
        with tempfile.TemporaryDirectory() as folder:
            here = pathlib.Path(folder)
            deck = (ROOT / "inputs/three_disk/sync.cfg").read_text()
            deck = deck.replace("dt = 1e-6", "dt = 1e-5").replace("steps = 5e5", "steps = 2e4")
            deck = deck.replace("steps = 2e7; series = 1e3", "steps = 2e5; series = 1e3; frames = 2e4; contacts = 2e4")
            self.assertIn("frames = 2e4", deck)
            (here / "deck.cfg").write_text(deck)
            (here / "sweep.cfg").write_text(
                deck + 'sweep = { parameters = ( { path = "gravity.tilt"; values = (0.1, 0.12); } ); };\n')
            for command in COMMANDS:
                lines = told("help", command).split("Examples:\n")
                self.assertEqual(len(lines), 2, f"{command} has no examples")
                for line in lines[1].splitlines():
                    if re.search(r"--(open|live)\b|man -l", line):
                        continue
                    with self.subTest(line.strip()):
                        done = subprocess.run(["bash", "-c", line], cwd=here, capture_output=True, text=True, timeout=600,
                                              env={**os.environ, "PATH": f"{pathlib.Path(PROGRAM).parent}:{os.environ['PATH']}"})
                        self.assertEqual(done.returncode, 0, done.stdout[-1000:] + done.stderr)
            for made in ("deck.h5", "two.h5", "sweep.sweep/means.csv", "tables", "wave.csv"):
                self.assertTrue((here / made).exists(), made)


if __name__ == "__main__":
    unittest.main()
