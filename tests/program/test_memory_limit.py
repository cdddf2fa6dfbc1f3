"""A run that needs more memory than there is is refused before it starts, in every command: status 4, the sizes in the
message, and nothing is left behind. `check` says what a run needs, within a quarter."""
import json
import os
import pathlib
import re
import resource
import subprocess
import unittest

import h5py
import numpy

from results_common import PROGRAM, Folder, start, wait_for

MIB = 1 << 20
LEAST, MEANS = 432, 1640  # bytes of a disk that each run writes, also with measure.disks
DECK = """integrator = "verlet"; dt = 1e-5;
materials = ( { name = "grain"; k_n = 1e4; k_t = 5e3; gamma_n = 5; mu = 0.1; } );
container = { type = "box"; width = %g; height = %g; };
packings = (
  { %s density = 1; }
);
phases = ( { name = "go"; steps = %d; } );
"""
SWEEP = 'sweep = { parameters = ( { path = "materials[0].mu"; values = (0.1); } ); replicas = %d; };\n'
PLAIN = 'type = "square"; count = %d; spacing = 1.0; radius = 0.5;'
SANITIZED = b"__asan_init" in pathlib.Path(PROGRAM).read_bytes()  # these reserve terabytes of addresses
UNITS = {"kB": 1e3, "MB": 1e6, "GB": 1e9}


def limits(mib):
    def set_them():
        resource.setrlimit(resource.RLIMIT_CPU, (20, 20))
        resource.setrlimit(resource.RLIMIT_AS, (mib * MIB, mib * MIB))

    return set_them


@unittest.skipIf(SANITIZED, "sanitizers reserve terabytes of addresses")
class Memory(Folder):
    def write(self, packing, steps=20, size=9000, more=""):
        deck = self.folder / "d.cfg"
        deck.write_text(DECK % (size, size, packing, steps) + more)
        return deck

    def call(self, mib, *words):
        done = subprocess.run([PROGRAM, *map(str, words)], cwd=self.folder, preexec_fn=limits(mib), capture_output=True,
                              text=True, timeout=600, check=False)
        return done.returncode, done.stdout, done.stderr

    def refuse(self, pattern, mib, *words):
        before = sorted(os.listdir(self.folder))
        status, out, err = self.call(mib, *words)
        self.assertEqual(status, 4, (words, err))
        found = re.search(pattern + r".* at least ([\d.]+) (.B) of memory", out + err)
        self.assertTrue(found, (words, out + err))
        self.assertEqual(sorted(os.listdir(self.folder)), before, words)
        return float(found[1]) * UNITS[found[2]]

    def test_packings_are_refused_before_they_are_made(self):
        n, size = 50_000_000, 'sizes = "uniform"; lower = 0.4; upper = 0.5;'
        for packing, key in ((PLAIN % n, "count"), (f'type = "triangular"; count = {n}; radius = 0.5;', "count"),
                             (f'type = "random"; count = {n}; {size}', "count"),
                             ('type = "random"; fraction = 0.2; radius = 0.5;', "fraction"),
                             (f'type = "front"; count = {n}; {size}', "count"), ('type = "front"; radius = 0.5;', "type"),
                             (f'type = "rain"; count = {n}; rows = 3; radius = 0.5;', "count"),
                             (PLAIN % n + "tiles = 4;", "count"),
                             ('type = "square"; spacing = 1.0; radius = 0.5;', "spacing")):
            with self.subTest(packing):
                self.refuse(rf"^error: d\.cfg:5: packings\[0\]\.{key} = .*(?:disks|sites) need", 1024, "run", self.write(packing).name)

    def test_every_command_refuses(self):
        deck = self.write(PLAIN % 1_000_000, more=SWEEP % 2).name
        for words in (["run"], ["check"], ["check", "--json"], ["sweep"], ["sweep", "-j", "2"], ["view"]):
            with self.subTest(words):
                need = self.refuse(r"d\.cfg:5: packings\[0\]\.count = 1000000: 1000000 disks need", 400, words[0], deck, *words[1:])
                self.assertAlmostEqual(need / 1e6, LEAST, delta=10)

    def test_what_a_deck_measures_counts(self):
        deck = self.write(PLAIN % 100_000, more="measure = { disks = true; };\n" + SWEEP % 2).name
        for words in (["run"], ["check"], ["check", "--json"], ["sweep"], ["sweep", "-j", "2"]):
            with self.subTest(words):
                need = self.refuse(r"d\.cfg: the run needs", 150, words[0], deck, *words[1:])
                self.assertAlmostEqual(need / 1e5, MEANS, delta=40)

    def test_what_fits_runs(self):
        deck = self.write(PLAIN % 20_000).name
        status, _, err = self.call(150, "run", deck, "-o", "r.h5", "--threads", "1")
        self.assertEqual(status, 0, err)

    def test_resume(self):
        deck = self.write(PLAIN % 100_000, 10**9, more="measure = { disks = true; };\ncheckpoint = 0.1;\n")
        process = start("run", deck, "-o", self.result, "--quiet", "--threads", "1")
        wait_for(lambda: process.poll() is not None or any(self.parts.glob("checkpoint-*.h5")))
        process.kill()
        process.communicate()
        self.refuse(r"the run needs", 150, "resume", self.result)

    def test_check_says_what_a_run_needs(self):
        """In packings; runs without contacts need less."""
        packing = 'type = "front"; count = 20000; sizes = "uniform"; lower = 0.4; upper = 0.5;'
        for more in ("", "measure = { disks = true; };\n", "output = { frames = 1; contacts = 1; series = 1; };\n"):
            with self.subTest(more):
                deck = self.write(packing, size=130, more=more)
                out, _ = self.run_ok("check", deck, "--brief", "--no-probe")
                number, unit = re.search(r"^# memory +about ([\d.]+) (.B) in one process", out, re.M).groups()
                said = json.loads(self.run_ok("check", deck, "--brief", "--no-probe", "--json")[0])["result"]["memory"]
                self.assertAlmostEqual(said / (float(number) * UNITS[unit]), 1, delta=0.01)
                process = subprocess.Popen([PROGRAM, "run", deck, "--quiet", "--force", "--threads", "1", "-o", self.result])
                _, status, used = os.wait4(process.pid, 0)
                process.returncode = status
                self.assertEqual(status, 0)
                self.assertLess(abs(said / (1024 * used.ru_maxrss) - 1), 0.25, (said, used.ru_maxrss))

    def test_workers_share_the_machine(self):
        memory = sum(1024 * int(re.search(rf"^{key}: +(\d+) kB", pathlib.Path("/proc/meminfo").read_text(), re.M)[1])
                     for key in ("MemTotal", "SwapTotal"))
        deck = self.write(PLAIN % (memory // 4096 // LEAST * 1.2), more=SWEEP % 4096).name
        self.refuse(r"^error: -j 4096: each point needs", 2000, "sweep", deck, "-j", "4096", "-o", "s")

    def test_files(self):
        with h5py.File(self.folder / "many.h5", "w") as file:
            for name in ("x", "y", "radius"):
                file[f"t/{name}"] = numpy.ones(1_000_000)
        deck = self.folder / "d.cfg"
        deck.write_text(DECK[:DECK.index("packings")] % (10, 10) +
                        'disk_files = (\n { file = "many.h5"; dataset = "/t"; columns = ("x", "y", "radius"); density = 1; } );\nsteps = 10;\n')
        self.refuse(r'^error: d\.cfg:5: disk_files\[0\]\.file = "many\.h5": 1000000 disks need', 300, "run", deck.name)


if __name__ == "__main__":
    unittest.main()
