"""One run over the ranks of an MPI job: the bits of one process, for any ranks and threads, also continued on others."""
import os
import pathlib
import shutil
import signal
import tempfile
import time
import unittest

import h5py
import numpy

from ranks_common import DECKS, GRAIN, SHIM, ranks_of, run, some, start
from results_common import LONG, Folder, assert_same, wait_for


class Ranks(Folder):
    @classmethod
    def setUpClass(cls):
        cls.made = pathlib.Path(tempfile.mkdtemp(prefix="slipdisk-made-"))
        cls.addClassCleanup(shutil.rmtree, cls.made)

    def setUp(self):
        super().setUp()
        self.alone = {}

    def make(self, name):
        """The result of a deck that others read: it is made once."""
        result = self.made / f"{name}.h5"
        if not result.exists():
            self.ok(0, "run", self.deck(name), "--quiet", "-o", result)
        shutil.copy(result, self.folder)

    def deck(self, name):
        path = self.folder / f"{name}.cfg"
        if not path.exists():
            path.write_text(DECKS[name])
        return path

    def by_one(self, name, *more):
        """The result of one process."""
        if name not in self.alone:
            self.alone[name] = self.folder / f"{name}-alone.h5"
            self.ok(0, "run", self.deck(name), "--quiet", "--threads", 1, "-o", self.alone[name], *more)
        return self.alone[name]

    def ok(self, ranks, *words, **more):
        status, out, err = run(ranks, *words, **more)
        self.assertEqual(status, 0, err)
        return out, err

    def same(self, name, ranks, threads=1, **more):
        result = self.folder / f"{name}-{ranks}-{threads}.h5"
        result.unlink(missing_ok=True)
        with self.subTest(deck=name, ranks=ranks, threads=threads, **more):
            _, err = self.ok(ranks, "run", self.deck(name), "--quiet", "--threads", threads, "-o", result, threads=threads, **more)
            assert_same(self, self.by_one(name), result)
            return err

    def test_collapse(self):
        for ranks in 1, 2, 3, 4, 7:
            self.same("collapse", ranks)

    def test_threads(self):
        for ranks in some((1, 2, 3, 4, 7), (2, 7)):
            self.same("laws", ranks, threads=2)

    def test_slam(self):
        for ranks in some((2, 3), (3,)):
            self.same("slam", ranks)

    def test_not_finite(self):
        """On one rank only: its message and one emergency file, as of one process."""
        status, _, alone = run(0, "run", self.deck("lost"), "--quiet", "-o", self.folder / "alone.h5")
        self.assertEqual(status, 3, alone)
        errors = [line for line in alone.splitlines() if line.startswith("error: ")]
        for ranks in some((2, 4), (4,)):
            result = self.folder / f"{ranks}.h5"
            status, _, err = run(ranks, "run", self.deck("lost"), "--quiet", "-o", result)
            self.assertEqual(status, 3, err)
            self.assertEqual([line for line in err.splitlines() if line.startswith("error: ")], errors)
            kept = sorted(p.name for p in self.folder.glob(f"{ranks}.h5.parts/emergency-*.h5"))
            self.assertEqual(len(kept), 1 + ranks, kept)

    def test_rain(self):
        for ranks in some((2, 3), (3,)):
            self.same("showers", ranks)
            self.same("lost drop", ranks)
            self.same("last drop", ranks)

    def test_bounds(self):
        """Disks that cross them and come back, and some that stay outside."""
        for ranks in some((2, 3, 7), (3,)):
            self.same("slide", ranks)
        for ranks in some((2, 4), (4,)):
            self.same("leave", ranks, threads=2)

    def test_tiles(self):
        """Disks that each rank makes itself, wherever it is cut to be."""
        for ranks in some((2, 3, 4, 7), (2, 7)):
            self.same("tiles", ranks)
        for ranks in some((2, 3), (3,)):
            self.same("levels", ranks, threads=2)

    def test_rain_in_tiles(self):
        for ranks in some((2, 3, 7), (7,)):
            self.same("drops", ranks)
        for ranks in some((2, 3), (3,)):
            self.same("lost drops", ranks)
            self.same("front in rain", ranks)

    def test_rain_in_tiles_goes_on(self):
        self.goes_on("drops", (3, 2, 0), ("-D", "phases[1].steps=3000", "-D", "checkpoint=0.1"))

    def test_files_in_parts(self):
        """Disks that each rank reads itself."""
        self.make("prepared")
        for ranks in some((2, 3, 4, 7), (2, 7)):
            self.same("file", ranks)
        for ranks in some((2, 3), (3,)):
            self.same("columns", ranks, threads=2)

    def test_contacts_in_parts(self):
        """Contacts of a file, which each rank reads some of, reach the ranks of their disks."""
        self.make("bed")
        _, _, alone = run(0, "run", self.deck("known"), "--quiet", "-o", self.folder / "alone.h5")
        self.assertRegex(alone, r'[0-9]+ of [0-9]+ contacts are with walls .* \(the first: wall 0 "post" of the file\)')
        self.assertRegex(alone, "[0-9]+ of [0-9]+ contacts of the packing do not touch at the start")
        for ranks in some((2, 3, 4, 7), (2, 7)):
            err = self.same("known", ranks, threads=2 if ranks == 2 else 1)
            self.assertLessEqual(set(alone.splitlines()), set(err.splitlines()))
        self.same("carried", 3)
        with h5py.File(self.folder / "bed.h5") as old, h5py.File(self.by_one("carried")) as new:
            old, new = ({(a - more, b - more): force for a, b, force in zip(*(file["contacts"][name][part] for name in ("a", "b", "force")))}
                        for file, part, more in ((old, slice(int(old["contacts/first"][-1]), None), 0),
                                                 (new, slice(0, int(new["contacts/count"][0])), 1)))
        both = [pair for pair in old.keys() & new.keys() if max(pair) < 21000]
        self.assertGreater(len(both), 10000)
        self.assertEqual([pair for pair in both if old[pair] != new[pair]], [])
        self.assertRegex(self.same("wider", 3), "[0-9]+ of [0-9]+ contacts of the packing do not touch at the start")

    def test_files_that_overlap(self):
        """Disks of two parts of a file, which no rank sees together before the start: a mistake, and a warning."""
        n = 70000
        deck = self.folder / "overlap.cfg"
        deck.write_text(f"""dt = 1e-3; steps = 10; {GRAIN}
disk_files = ( {{ file = "t.h5"; dataset = "t"; columns = ("x", "y"); radius = 0.4; density = 1; }} );""")
        for x, told, overlap in ((0.8, 2, "overlap by 0.5, more than max_overlap = 0.5 of the smaller radius 0.4"),
                                 (-0.27, 0, "overlap by 0.03 at the start, 0.075 of the radius: a force of 300 throws them apart")):
            with h5py.File(self.folder / "t.h5", "w") as file:
                file["t/x"] = numpy.append(numpy.arange(n - 1) % 250 + 0.5, x)
                file["t/y"] = numpy.append(numpy.arange(n - 1) // 250, 0) + 0.5
            for ranks in some((0, 2, 4), (0, 4)):
                status, _, err = run(ranks, "run", deck, "--quiet", "--force")
                self.assertEqual(status, told, err)
                self.assertRegex(err, f"disk (0 and disk 69999|69999 and disk 0) {overlap}")

    def test_files_in_parts_go_on(self):
        self.make("prepared")
        self.goes_on("file", (2, 3, 0), ("-D", "phases[1].steps=1000", "-D", "checkpoint=0.1"))

    def test_contacts_in_parts_go_on(self):
        self.make("bed")
        self.goes_on("known", (3, 2, 0), ("-D", "phases[1].steps=400", "-D", "checkpoint=0.1"))

    def test_tiles_go_on(self):
        """What ranks have made goes on where one process makes it, and on other ranks."""
        long = "-D", "phases[1].steps=4000", "-D", "checkpoint=0.1"
        self.goes_on("tiles", (2, 3, 0), long)

    def test_tiles_too_small(self):
        """Those of another rank: its message, and no result."""
        deck = self.folder / "full.cfg"
        # tiles beside the first hold a disk that leaves too little room
        deck.write_text(DECKS["tiles"].replace("x = 0; y = 60; radius = 1;", "x = 0; y = 24; radius = 4.2;").replace("y = (0.1, 50);", "y = (0.1, 33);"))
        status, _, alone = run(0, "run", deck, "--quiet", "-o", self.result)
        self.assertEqual(status, 2, alone)
        expected = r"packings\[0\].count.*: tile 3 of 7 holds [0-9]+ disks only, where 1143 were asked for; expected fewer disks or a larger region"
        self.assertRegex(alone, expected)
        for ranks in some((2, 4), (2,)):
            status, _, err = run(ranks, "run", deck, "--quiet", "-o", self.result)
            self.assertEqual(status, 2, err)
            self.assertRegex(err, expected)
            self.assertFalse(self.result.exists())

    def test_tiles_near_a_limit(self):
        """The smallest disk of another tile forbids the time step."""
        deck = self.folder / "gaussian.cfg"
        deck.write_text(DECKS["tiles"].replace('"gear5"', '"verlet"').replace(
            'sizes = "list"; radii = (0.2, 0.28);', 'sizes = "gaussian"; radius = 0.2; deviation = 0.05; lower = 0.01; upper = 0.28;'))
        for seed in 2, 3:
            status, _, alone = run(0, "run", deck, "--quiet", "-o", self.result, "-D", f"seed={seed}")
            self.assertEqual(status, 2, alone)
            self.assertIn("blows up", alone)
            status, _, err = run(2, "run", deck, "--quiet", "-o", self.result, "-D", f"seed={seed}")
            self.assertEqual((status, err.splitlines()[0]), (2, alone.splitlines()[0]))

    def test_uneven(self):
        """Few disks, and clocks that leap: ranks without a disk, and cuts anew every 200 steps."""
        for seed in some(range(1, 9), (1, 2, 3)):
            self.same("few", 4, environment=(f"LD_PRELOAD={SHIM}", f"INJECT_CLOCK={seed}"))
        for seed in some((1, 2), (1,)):
            self.same("channel", 3, environment=(f"LD_PRELOAD={SHIM}", f"INJECT_CLOCK={seed}"))

    def goes_on(self, name, numbers, long):
        """Stopped by a signal, and continued on other numbers of ranks."""
        by_one = self.by_one(name, *long)
        words = "run", self.deck(name), "--quiet", "--threads", 1, *long, "-o", self.result
        stopped = 0
        for ranks in numbers:
            if self.result.exists():
                break
            before = set(self.parts.glob("checkpoint*"))
            process = start(ranks, *words)
            # all ranks listen to signals when they have made steps
            wait_for(lambda p=process, b=before: p.poll() is not None or set(self.parts.glob("checkpoint*")) - b)
            time.sleep(0.2)
            process.send_signal(signal.SIGUSR1)
            out, err = process.communicate(timeout=LONG)
            self.assertIn(process.returncode, (0, 75), out + err)
            stopped += process.returncode == 75
        self.assertGreater(stopped, 0)
        if not self.result.exists():
            self.ok(4, *words)
        assert_same(self, by_one, self.result)

    def test_restart(self):
        self.goes_on("collapse", (3, 1, 2, 0), ("-D", "phases[1].steps=20000", "-D", "checkpoint=0.1"))

    def test_rows_once(self):
        """The second rank is told to stop where a row is due at every step: none is lost, none is there twice."""
        deck = self.folder / "rows.cfg"
        deck.write_text(DECKS["collapse"].replace("series = 200", "series = 1"))
        alone = self.folder / "alone.h5"
        self.ok(0, "run", deck, "--quiet", "--threads", 1, "-o", alone)
        words = "run", deck, "--quiet", "--threads", 1, "-o", self.result
        stopped = 0
        for _ in range(8):
            before = set(self.parts.glob("checkpoint*"))
            process = start(2, *words, "-D", "checkpoint=0.1")
            wait_for(lambda p=process, b=before: p.poll() is not None or set(self.parts.glob("checkpoint*")) - b)
            if 1 in (there := ranks_of(process.pid)):
                os.kill(there[1], signal.SIGUSR1)
            out, err = process.communicate(timeout=LONG)
            self.assertIn(process.returncode, (0, 75), out + err)
            stopped += process.returncode == 75
        self.assertGreater(stopped, 4)
        if not self.result.exists():
            self.ok(2, *words)
        assert_same(self, alone, self.result)

    def test_tells_how_evenly(self):
        out, err = self.ok(2, "run", self.deck("pressed"), "-v", "-o", self.folder / "two.h5")
        self.assertRegex(out + err, "the ranks shared out the disks [1-9][0-9]* times?; in the end each had [0-9]+ to [0-9]+, "
                         "and the busiest worked [0-9]+ % longer than the mean")

    def test_relaxes(self):
        """Phases that relax and compress, on all ranks, also of disks that they make themselves."""
        cases = {"pressed": DECKS["pressed"].replace('name = "hold";', 'name = "hold"; relax = true;'),
                 "levels": DECKS["levels"].replace("steps = 400;", "steps = 200; relax = true; compress = { fraction = 0.5; rate = 0.5; };")}
        for name, text in cases.items():
            with self.subTest(name):
                deck, one, three = (self.folder / f"relaxed-{name}{end}" for end in (".cfg", ".h5", "-3.h5"))
                deck.write_text(text)
                self.ok(0, "run", deck, "--quiet", "-o", one)
                _, err = self.ok(3, "run", deck, "--quiet", "-o", three)
                self.assertNotIn("every rank makes all", err)
                assert_same(self, one, three)

    def test_refused(self):
        """What ranks do not share: told at the start, with what to do; nothing is written. One process runs it."""
        few = f'{GRAIN} dt = 1e-3; phases = ( {{ steps = 10; }} ); disks = ( {{ x = 0; y = 0; radius = 1; density = 1; }}%s );'
        row = ", ".join(f"{{ x = {3 * k}; y = 5; radius = 1; density = 1; }}" for k in range(40))
        many = few % (", " + row)
        box = 'box = { x = (-10, 130); y = (-10, 20); periodic = "xy"; };'
        cases = {
            "clumps: rigid bodies": many + 'clumps = ( { disk = (3, 4); } );',
            "phases[0].cell: a box that deforms": many.replace("steps = 10;", "steps = 16; cell = { rate_xy = 0.1; };") + box,
            "measure.rotation: means of single disks": many + "measure = { rotation = (3, 4); };",
            'motions[0]: it moves a free disk': many + 'motions = ( { name = "push"; disk = 2; coordinate = "x"; type = "velocity"; velocity = 1; } );',
            "disks: 1 free disk, so few are for one process": few % "" + 'walls = ( { type = "line"; points = ((-5, -1), (5, -1)); } );'}
        for message, text in cases.items():
            with self.subTest(message=message):
                deck, result = self.folder / "refused.cfg", self.folder / "refused.h5"
                deck.write_text(text)
                status, out, err = run(2, "run", deck, "--quiet", "-o", result)
                self.assertEqual((status, err.count("error: ")), (2, 1), err)
                self.assertIn(f"error: {deck}:1: {message}", err)
                self.assertIn("without mpirun", err)
                self.assertEqual(list(self.folder.glob("refused.h5*")), [])
                self.ok(0, "run", deck, "--quiet", "-o", result)
                result.unlink()
        # begun by one process, it is not continued by two
        deck, result = self.folder / "begun.cfg", self.folder / "begun.h5"
        deck.write_text(cases["measure.rotation: means of single disks"].replace("steps = 10;", "steps = 1000000000;"))
        process = start(0, "run", deck, "--quiet", "-o", result)
        wait_for(lambda: list(self.folder.glob("begun.h5.parts/checkpoint-*.h5")))
        process.send_signal(signal.SIGTERM)
        process.communicate(timeout=LONG)
        self.assertEqual(process.returncode, 75)
        status, out, err = run(2, "resume", result, "--quiet")
        self.assertEqual((status, err.count("error: ")), (2, 1), err)
        self.assertIn("begun.cfg:1: measure.rotation: means of single disks", err)
        status, out, err = run(2, "run", self.deck("pressed"), "--live", "--quiet", "-o", self.folder / "live.h5")
        self.assertEqual((status, err.count("error: ")), (2, 1), err)
        self.assertIn("--live shows the disks of one process", err)


if __name__ == "__main__":
    unittest.main()
