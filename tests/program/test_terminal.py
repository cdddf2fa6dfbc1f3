"""On a terminal progress is redrawn in one line; where TERM says that the terminal cannot do that (dumb, empty, unset), and wherever
the output is no terminal, no escape code is printed. There are no colours, so NO_COLOR has nothing to take away."""
import os
import pty
import subprocess
import unittest

from results_common import PROGRAM, Folder

DECK = """dt = 1e-4; phases = ( { name = "p"; steps = 2000; series = 100; frames = 1000; contacts = 1000; measure = true; } );
materials = ( { name = "m"; k_n = 1e3; } ); measure = { rotation = ("a"); };
disks = ( { name = "a"; x = 0; y = 0; radius = 1; mass = 1; omega = 1; } );
"""
SWEEP = DECK + 'sweep = { parameters = ( { path = "disks[0].omega"; values = (1, 2, 3); } ); };\n'
COMMANDS = (("run", "d.cfg", "--force", "--verbose"), ("resume", "d.h5"), ("sweep", "s.cfg", "--force", "-j", "2"), ("sweep", "s.cfg", "--list"),
            ("check", "d.cfg"), ("check", "s.cfg"), ("info", "d.h5"), ("info", "s.sweep"), ("measure", "d.h5"), ("export", "d.h5", "--to", "csv", "-o", "t"),
            ("view", "d.h5"), ("plot", "d.h5"), ("verify", "d.h5"), ("theory", "d.cfg"), ("help",), ("help", "run"), ("version",), ("rum",))


class Terminal(Folder):
    def setUp(self):
        super().setUp()
        (self.folder / "d.cfg").write_text(DECK)
        (self.folder / "s.cfg").write_text(SWEEP)

    def shown(self, *words, term):
        """What a command prints on a terminal of this kind."""
        environment = {key: value for key, value in os.environ.items() if key != "TERM"} | ({} if term is None else {"TERM": term})
        ours, theirs = pty.openpty()
        process = subprocess.Popen([PROGRAM, *words], cwd=self.folder, env=environment, stdin=theirs, stdout=theirs, stderr=theirs)
        os.close(theirs)
        text = b""
        try:
            while part := os.read(ours, 65536):
                text += part
        except OSError:  # the other end is closed
            pass
        os.close(ours)
        process.wait(60)
        self.assertGreater(len(text), 5, words)
        return text

    def test_a_terminal_that_cannot_redraw_gets_no_escape_code(self):
        for term in "dumb", "", None:
            for words in COMMANDS if term == "dumb" else COMMANDS[:3]:
                text = self.shown(*words, term=term)
                self.assertNotIn(b"\x1b", text, (term, words))
        self.assertIn(b"step 2000/2000", self.shown("run", "d.cfg", "--force", term="dumb"))

    def test_another_terminal_has_one_line_redrawn_and_no_colours(self):
        self.assertIn(b"\r\x1b[K", self.shown("run", "d.cfg", term="xterm-256color"))
        self.assertIn(b"\r\x1b[K", self.shown("sweep", "s.cfg", term="xterm-256color"))
        for words in COMMANDS:
            self.assertEqual(self.shown(*words, term="xterm-256color").replace(b"\x1b[K", b"").count(b"\x1b"), 0, words)


if __name__ == "__main__":
    unittest.main()
