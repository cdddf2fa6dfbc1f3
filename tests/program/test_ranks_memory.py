"""What the first rank of a run needs beyond the others, at its start and when it goes on: no state of the whole."""
import pathlib
import signal
import subprocess
import sys
import unittest

from ranks_common import MPIEXEC
from results_common import LONG, PROGRAM, Folder, wait_for

COUNT = 400_000
DECK = f"""
title = "a lattice that falls"; integrator = "verlet"; dt = 1e-4; gravity = {{ g = 1.0; }};
materials = ( {{ name = "grain"; k_n = 1e4; k_t = 5e3; gamma_n = 2; mu = 0.4; }} );
box = {{ x = (0, 1000); periodic = "x"; }};
walls = ( {{ name = "floor"; type = "line"; points = ((0, 0), (1, 0)); }} );
packings = ( {{ type = "square"; count = {COUNT}; y = (0, 500); spacing = 1.0; radius = 0.5; density = 1.27; }} );
phases = ( {{ steps = 60; series = 20; }} );
"""
TILES = DECK.replace("count =", "tiles = 8; count =")
# Runs the program and writes its exit status and its largest memory, in bytes, to a file named after its rank. Its own status is 0:
# after another mpiexec ends the others before they have written.
PEAK = """import os, signal, sys
pid = os.spawnv(os.P_NOWAIT, sys.argv[2], sys.argv[2:])
signal.signal(signal.SIGUSR1, lambda *_: os.kill(pid, signal.SIGUSR1))
_, status, used = os.wait4(pid, 0)
open(f"{sys.argv[1]}-{os.environ['OMPI_COMM_WORLD_RANK']}", "w").write(f"{os.waitstatus_to_exitcode(status)} {1024 * used.ru_maxrss}")
"""
RANKS = 4
# Bytes of a disk of the run that the first rank may need beyond the others. The model has 136, and 210 while a packing is made;
# columns that all states keep 36. A state has some 300 more, and a file in memory as many again.
MOST = 300
# Of disks in tiles the first rank has 136 bytes in the model for those of one tile alone; a result is written column by column.
MOST_OF_TILES = 120


class Memory(Folder):
    def setUp(self):
        super().setUp()
        self.deck = self.folder / "lattice.cfg"
        self.deck.write_text(DECK)
        (self.folder / "peak.py").write_text(PEAK)

    def start(self, *words):
        return subprocess.Popen([*MPIEXEC, "-n", str(RANKS), sys.executable, self.folder / "peak.py", self.folder / "peak", PROGRAM, "run",
                                 self.deck, "-o", self.result, "--threads", "1", "--quiet", *words], stderr=subprocess.DEVNULL)

    def assert_little(self, what, process, status, most=MOST):
        self.assertEqual(process.wait(timeout=LONG), 0)
        ended, (first, *others) = zip(*[map(int, pathlib.Path(f"{self.folder}/peak-{rank}").read_text().split()) for rank in range(RANKS)])
        self.assertEqual(set(ended), {status})
        self.assertLess((first - max(others)) / COUNT, most, (what, first, others))

    def steps_saved(self):
        return [int(path.stem.split("-")[1]) for path in self.parts.glob("checkpoint-*.h5") if path.stem.count("-") == 1]

    def test_from_start_to_end(self):
        self.assert_little("a whole run", self.start(), 0)

    def test_tiles(self):
        self.deck.write_text(TILES)
        self.assert_little("a packing in tiles", self.start(), 0, MOST_OF_TILES)

    def test_rain(self):
        self.deck.write_text(TILES.replace('type = "square"', 'type = "rain"; rows = 2; interval = 7e-4').replace(" spacing = 1.0;", ""))
        self.assert_little("disks that wait for rain", self.start(), 0, MOST_OF_TILES)

    def test_file(self):
        first = self.folder / "first.h5"
        sticky = DECK.replace("mu = 0.4;", 'mu = 0.4; cohesion = "constant"; pull_off = 1e-3; range = 0.01;')
        self.deck.write_text(sticky)
        subprocess.run([PROGRAM, "run", self.deck, "-o", first, "--quiet", "-D", "phases[0].steps=1"], check=True)
        text = sticky.splitlines()
        for what, contacts in ("disks of a file", "false"), ("contacts of a file", "true"):
            self.deck.write_text("\n".join(f'disk_files = ( {{ file = "first.h5"; contacts = {contacts}; }} );' if line.startswith("packings") else line for line in text))
            self.assert_little(what, self.start(), 0, MOST_OF_TILES)
            self.result.unlink()

    def test_going_on(self):
        endless = "-D", "phases[0].steps=100000000", "-D", "checkpoint=0.2"
        last = 0
        for what in "a run that is stopped", "one that goes on":
            process = self.start(*endless)
            wait_for(lambda: max(self.steps_saved(), default=0) > last)
            process.send_signal(signal.SIGUSR1)
            self.assert_little(what, process, 75)
            last = max(self.steps_saved())


if __name__ == "__main__":
    unittest.main()
