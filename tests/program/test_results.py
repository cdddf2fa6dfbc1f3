"""The finished file, and what `run`, `resume` and `info` do with what is already there."""
import json
import os
import pathlib
import resource
import shutil
import signal
import subprocess
import tempfile
import unittest

import h5py
import numpy

from results_common import (CONTACTS, DECK, FRAMES, LONG, MEASURE, SELDOM, SERIES, SETTLE, Folder, assert_same,
                            deck_arguments, run, start, steps_for, wait_for)

SECONDS = 1.5  # of a run that is to be interrupted


def long_deck(checkpoint=0.03):
    steps = steps_for(SECONDS)
    return deck_arguments(measure=steps, series=steps // 200, frames=steps // 200, checkpoint=checkpoint)


class Started(Folder):
    def stop(self, process, number=signal.SIGTERM):
        process.send_signal(number)
        out, err = process.communicate(timeout=LONG)
        return process.returncode, out, err


class Layout(Folder):
    """H5MD 1.1 as h5py sees it."""

    @classmethod
    def setUpClass(cls):
        cls.where = pathlib.Path(tempfile.mkdtemp(prefix="slipdisk-results-"))
        cls.path = cls.where / "a.h5"
        cls.status, cls.out, cls.err = run("run", *deck_arguments(), "-o", cls.path)

    @classmethod
    def tearDownClass(cls):
        shutil.rmtree(cls.where)

    def setUp(self):
        super().setUp()
        self.assertEqual(self.status, 0, self.err)
        self.file = h5py.File(self.path)

    def tearDown(self):
        self.file.close()
        super().tearDown()

    def test_h5md(self):
        h5md = self.file["h5md"]
        self.assertEqual(list(h5md.attrs["version"]), [1, 1])
        self.assertTrue(h5md["author"].attrs["name"])
        self.assertEqual(h5md["creator"].attrs["name"], b"slipdisk")
        box = self.file["particles/disks/box"]
        self.assertEqual(box.attrs["dimension"], 2)
        self.assertEqual([b.decode() for b in box.attrs["boundary"]], ["none", "none"])
        self.assertEqual(box["edges"].shape, (2,))

    def test_elements_share_their_clock(self):
        disks = self.file["particles/disks"]
        for name in "velocity", "image", "angle", "angular_velocity":
            self.assertEqual(disks[name]["step"], disks["position/step"])
            self.assertEqual(disks[name]["time"], disks["position/time"])
        for name, item in self.file["observables"].items():
            if isinstance(item, h5py.Group):
                self.assertEqual(item["step"], self.file["observables/work/step"], name)
                self.assertEqual(item["value"].shape[0], item["step"].shape[0], name)

    def test_rows_are_where_the_deck_wants_them(self):
        end = SETTLE + MEASURE
        self.assertEqual(list(self.file["observables/work/step"][()]),
                         sorted({0, end} | set(range(0, SETTLE + 1, 1000)) | set(range(SETTLE, end + 1, SERIES))))
        self.assertEqual(list(self.file["particles/disks/position/step"][()]),
                         sorted({0, end} | set(range(SETTLE, end + 1, FRAMES))))
        self.assertEqual(list(self.file["contacts/step"][()]),
                         sorted({0, end} | set(range(SETTLE, end + 1, CONTACTS))))
        numpy.testing.assert_allclose(self.file["observables/work/time"][()],
                                      1e-6 * self.file["observables/work/step"][()], rtol=1e-15)

    def test_frames(self):
        disks = self.file["particles/disks"]
        n = disks["position/step"].shape[0]
        self.assertEqual(disks["position/value"].shape, (n, 3, 2))
        self.assertEqual(disks["angle/value"].shape, (n, 3))
        self.assertEqual(list(disks["id"][()]), [0, 1, 2])
        numpy.testing.assert_array_equal(disks["radius"][()], [1, 1, 1])
        state = self.file["state"]
        order = numpy.argsort(state["id"][()])
        numpy.testing.assert_array_equal(disks["position/value"][-1][:, 0], state["x"][()][order])
        numpy.testing.assert_array_equal(disks["angle/value"][-1], (state["turn"][()] + state["theta"][()])[order])

    def test_contacts(self):
        contacts = self.file["contacts"]
        first, count = contacts["first"][()], contacts["count"][()]
        numpy.testing.assert_array_equal(first, numpy.cumsum(count) - count)
        self.assertEqual(contacts["a"].shape[0], count.sum())
        k_n, k_t, mu = 1e3, 1e6, 0.1
        force, tau = contacts["force"][()], contacts["tau"][()]
        numpy.testing.assert_allclose(tau, -k_t * contacts["zeta"][()], rtol=1e-12)
        self.assertTrue((abs(tau) <= mu * force * (1 + 1e-12)).all())
        sliding = contacts["sliding"][()]
        self.assertTrue((numpy.sign(tau[sliding != 0]) == sliding[sliding != 0]).all())
        self.assertTrue((force[count[0]:] > 0.01 * k_n * contacts["overlap"][()][count[0]:]).all())

    def test_energy_budget_closes(self):
        o = {name: item["value"][()] for name, item in self.file["observables"].items()
             if isinstance(item, h5py.Group)}
        residual = (o["kinetic_translation"] + o["kinetic_rotation"] + o["elastic_normal"] + o["elastic_tangential"] +
                    o["elastic_rolling"] + o["cohesion"] + o["external"] - o["start"] - o["work"] -
                    o["nonconservative_work"] + o["viscous"] + o["friction"] + o["rolling"] + o["bridge"] + o["opening"] +
                    o["drag"] + o["damping"])
        numpy.testing.assert_allclose(residual, o["residual"], atol=1e-12)

    def test_every_column_has_a_unit(self):
        missing = []
        for name in "observables", "particles", "contacts", "state":
            self.file[name].visititems(lambda path, item: missing.append(path) if isinstance(item, h5py.Dataset) and
                                       "unit" not in item.attrs and not path.endswith(("name", "watched_disks"))
                                       else None)
        self.assertEqual(missing, [])

    def test_provenance(self):
        p = self.file["parameters"]
        self.assertIn(b"three disks", p["deck_text"][()])
        self.assertIn(b"phases.measure.steps", p["deck_overrides"][()])
        for key in "version", "revision", "compiler", "hdf5", "gsl", "libconfig", "host", "started", "run_id", "cpu_path":
            self.assertTrue(p.attrs[key], key)
        self.assertEqual(p.attrs["seed"], 1)
        self.assertEqual(p.attrs["sessions"], 1)
        self.assertGreater(p.attrs["wall_seconds"], 0)

    def test_report(self):
        for words in "t_g Omega", "S++", "energy budget", "residual", "ns per step", str(self.path):
            self.assertIn(words, self.out)

    def test_info(self):
        out, _ = self.run_ok("info", "--json", self.path)
        info = json.loads(out)
        self.assertTrue(info["finished"])
        self.assertEqual(info["step"], SETTLE + MEASURE)
        self.assertEqual(info["rotation"][0]["name"], "upper")
        self.assertAlmostEqual(sum(info["sliding"][0][c] for c in ("S++", "S+-", "S-+", "S--", "stick", "open")), 1)
        self.assertEqual(info["energy"]["residual"], self.file["summary/energy"].attrs["residual"])
        self.assertIn("/contacts/tau", [d["path"] for d in info["datasets"]])
        out, _ = self.run_ok("info", self.path)
        self.assertIn("finished", out)
        for option, name in ("--deck", "deck_full"), ("--deck-as-read", "deck_text"):
            out, _ = self.run_ok("info", option, self.path)
            self.assertEqual(out.encode(), self.file[f"parameters/{name}"][()])

    def test_no_leftovers(self):
        self.assertEqual([p.name for p in self.where.iterdir()], ["a.h5"])


class Again(Folder):
    def test_finished_is_not_overwritten(self):
        words = ["run", *deck_arguments(measure=20000), "-o", self.result]
        self.run_ok(*words)
        before = self.result.read_bytes()
        status, _, err = run(*words)
        self.assertEqual(status, 2)
        self.assertIn("--force", err)
        self.assertEqual(self.result.read_bytes(), before)
        self.run_ok("resume", self.result)
        self.run_ok(*words, "--force")
        with h5py.File(self.result) as file:
            self.assertNotIn(file["parameters"].attrs["run_id"], before)
        self.assertEqual([p.name for p in self.folder.iterdir()], ["r.h5"])

    def test_foreign_file_is_not_overwritten(self):
        self.result.write_text("a letter\n")
        status, _, err = run("run", *deck_arguments(), "-o", self.result)
        self.assertEqual(status, 2, err)
        self.assertEqual(self.result.read_text(), "a letter\n")
        self.assertFalse(self.parts.exists())

    def test_pipe_is_not_replaced(self):
        os.mkfifo(self.result)
        status, _, err = run("run", *deck_arguments(measure=1000), "--force", "-o", self.result)
        self.assertEqual(status, 2)
        self.assertIn("is a device or a pipe", err)
        self.assertTrue(self.result.is_fifo())
        self.assertFalse(self.parts.exists())

    def test_default_name(self):
        status, _, err = run("run", *deck_arguments(measure=1000), cwd=self.folder)
        self.assertEqual(status, 0, err)
        self.assertTrue((self.folder / "random.h5").is_file())

    def test_quiet(self):
        out, err = self.run_ok("run", *deck_arguments(measure=1000), "-o", self.result, "--quiet")
        self.assertEqual(out + err, "")

    def test_log(self):
        log = self.folder / "log"
        self.run_ok("run", *deck_arguments(measure=1000), "-o", self.result, "--quiet", "--log", log)
        self.assertIn("energy budget", log.read_text())

    def test_mistakes(self):
        for words in (["run"], ["run", "a", "b"], ["run", "--frobnicate", "a"], ["run", "a", "--threads", "0"],
                      ["run", "none.cfg"], ["resume", "none.h5"], ["info", "none.h5"], ["info"], ["fly"], []):
            status, _, err = run(*words)
            self.assertEqual(status, 2, words)
            self.assertTrue(err, words)

    def test_hints(self):
        for words, wanted in ((["runn", "a"], '"run"'), (["run", "--forse", "a"], "--force"),
                              (["info", "--jsn", "a"], "--json"), (["info", str(self.folder)], "is a folder"),
                              (["info", str(DECK)], "is a deck; slipdisk run"),
                              (["run", *deck_arguments(), "-o", str(self.folder / "none/r.h5")], "no folder")):
            status, _, err = run(*words)
            self.assertEqual(status, 2, err)
            self.assertIn(wanted, err)
        for words in (["--help"], ["run", "--help"], ["info", "-h"], ["resume", "--help"], ["check", "--help"]):
            out, err = self.run_ok(*words)
            self.assertIn("slipdisk", out, words)

    def test_numerical_error(self):
        status, _, err = run("run", *deck_arguments(), "-D", "max_overlap=1e-4", "-o", self.result)
        self.assertEqual(status, 3, err)
        self.assertTrue(list(self.parts.glob("emergency-*.h5")), err)
        self.assertTrue(self.checkpoints())
        self.assertFalse(self.result.exists())
        self.run_ok("info", self.parts)
        emergency = list(self.parts.glob("emergency-*.h5"))[0]
        self.run_ok("info", emergency)


class Stopped(Started):
    """An interrupted run goes on as if nothing had been."""

    @classmethod
    def setUpClass(cls):
        cls.where = pathlib.Path(tempfile.mkdtemp(prefix="slipdisk-results-"))
        cls.whole = cls.where / "whole.h5"
        cls.words = long_deck()
        status, _, err = run("run", *cls.words, *SELDOM, "-o", cls.whole)
        assert status == 0, err

    @classmethod
    def tearDownClass(cls):
        shutil.rmtree(cls.where)

    def test_signals(self):
        process = self.started(*self.words)
        for number in signal.SIGINT, signal.SIGTERM, signal.SIGUSR1:
            status, _, err = self.stop(process, number)
            self.assertEqual(status, 75, err)
            self.assertIn("continue with", err)
            self.assertEqual(len(self.checkpoints()), 2)
            process = self.started(*self.words)
        status, _, err = self.stop(process)
        self.assertEqual(status, 75, err)
        info = json.loads(self.run_ok("info", "--json", self.result)[0])
        self.assertFalse(info["finished"])
        self.assertGreater(info["step"], 0)
        self.assertEqual(info["provenance"]["sessions"], 4)
        self.run_ok("info", self.parts)
        self.run_ok("resume", self.parts / f"checkpoint-{self.checkpoints()[0]}.h5")
        assert_same(self, self.result, self.whole)
        self.assertFalse(self.parts.exists())

    def test_two_processes(self):
        process = self.started(*self.words)
        status, _, err = run("run", *self.words, "-o", self.result)
        self.assertEqual(status, 2)
        self.assertIn("another process", err)
        status, _, err = run("run", *self.words, "--force", "-o", self.result)
        self.assertEqual(status, 2)
        self.gate.open()
        out, err = process.communicate(timeout=LONG)
        self.assertEqual(process.returncode, 0, err)
        assert_same(self, self.result, self.whole)

    def test_another_deck(self):
        process = self.started(*self.words)
        self.stop(process)
        before = self.checkpoints()
        status, _, err = run("run", *self.words, "-D", "seed=7", "-o", self.result)
        self.assertEqual(status, 2)
        self.assertIn("seed: 1 there, 7 here", err)
        self.assertNotIn("checkpoint", err)
        self.assertEqual(self.checkpoints(), before)

    def test_another_table(self):
        """A motion's table is too long to stand in the full deck: that its file has changed is seen all the same."""
        deck, table = self.folder / "table.cfg", self.folder / "table.csv"
        # rows of a series, so that signals are soon heard where steps are slow
        deck.write_text("""dt = 1e-5; time = 1e6; checkpoint = 0.1; output = { series = 5000; };
            materials = ( { name = "m"; k_n = 1e4; k_t = 0; gamma_n = 0; mu = 0; } );
            disks = ( { name = "a"; x = 0; y = 0; radius = 1; mass = 1; fixed = true; },
                      { name = "b"; x = 3; y = 0; radius = 1; mass = 1; } );
            motions = ( { disk = "a"; coordinate = "x"; type = "table"; file = "table.csv"; } );""")
        rows = [f"{0.001 * k},{0.01 * (k % 7)}" for k in range(2000)]
        table.write_text("\n".join(["time,value", *rows, ""]))
        self.stop(self.started(deck))
        before = self.checkpoints()
        table.write_text("\n".join(["time,value", *rows[:-1], "1.999,0.5", ""]))
        status, _, err = run("run", deck, "-o", self.result)
        self.assertEqual(status, 2)
        self.assertIn("a file that the deck names", err)
        self.assertEqual(self.checkpoints(), before)
        table.write_text("\n".join(["time,value", *rows, ""]))
        self.assertEqual(self.stop(self.started(deck))[0], 75)

    def test_same_deck_said_otherwise(self):
        """How often a run is saved is no difference, nor is a default that is written out."""
        process = self.started(*self.words)
        self.stop(process)
        out, err = self.run_ok("run", *self.words, "-D", "checkpoint=7", "-D", "skin=0", "-D", "max_overlap=0.5",
                               "-o", self.result)
        self.assertIn("continuing", err)
        assert_same(self, self.result, self.whole)

    def test_stop_in_log(self):
        log = self.folder / "log"
        process = self.started(*self.words, "--quiet", "--log", log)
        self.stop(process)
        self.assertIn("stopped at step", log.read_text())
        self.assertIn("continue with: slipdisk resume", log.read_text())

    def test_damaged_checkpoint(self):
        process = self.started(*self.words)
        self.stop(process)
        newest = self.parts / f"checkpoint-{self.checkpoints()[0]}.h5"
        data = bytearray(newest.read_bytes())
        data[len(data) // 2] ^= 1
        newest.write_bytes(data)
        out, err = self.run_ok("run", *self.words, *SELDOM, "-o", self.result)
        self.assertIn("damaged", err)
        assert_same(self, self.result, self.whole)

    def test_truncated_checkpoint(self):
        process = self.started(*self.words)
        self.stop(process)
        newest = self.parts / f"checkpoint-{self.checkpoints()[0]}.h5"
        newest.write_bytes(newest.read_bytes()[:5000])
        self.run_ok("resume", self.result)
        assert_same(self, self.result, self.whole)

    def test_force_over_unfinished(self):
        process = self.started(*self.words)
        self.stop(process)
        self.run_ok("run", *deck_arguments(measure=1000), "--force", "-o", self.result)
        self.assertFalse(self.parts.exists())

    def test_forced_run_keeps_the_old_result_until_it_is_done(self):
        self.run_ok("run", *deck_arguments(measure=1000), "-o", self.result)
        before = self.result.read_bytes()
        self.stop(self.started(*self.words, "--force"))
        self.assertEqual(self.result.read_bytes(), before)
        self.run_ok("run", *self.words, *SELDOM, "-o", self.result)
        assert_same(self, self.result, self.whole)

    def test_kill_between_result_and_removal(self):
        process = self.started(*self.words)
        self.stop(process)
        copy = self.folder / "copy"
        shutil.copytree(self.parts, copy)
        self.run_ok("run", *self.words, *SELDOM, "-o", self.result)
        copy.rename(self.parts)
        status, _, err = run("run", *self.words, "-D", "gravity.g=9", "-o", self.result)
        self.assertEqual(status, 2, err)
        self.assertIn("is the result of another deck", err)
        _, err = self.run_ok("run", *self.words, *SELDOM, "-o", self.result)
        self.assertIn("finished already", err)
        self.assertFalse(self.parts.exists())

    def test_a_finished_result_of_another_deck_or_of_other_files_is_told(self):
        deck = self.folder / "d.cfg"
        rows = self.folder / "rows.csv"
        deck.write_text('dt = 1e-3; steps = 10; materials = ( { name = "m"; k_n = 1e3; } ); disk_files = ( { file = "rows.csv"; density = 1; } );\n')
        table = "x,y,radius\n" + "".join(f"{k},0,0.1\n" for k in range(1001))  # a shorter one is a part of the deck
        rows.write_text(table)
        self.run_ok("run", deck, "-o", self.result)
        before = self.result.read_bytes()
        for words, told in (((), ["is finished already; --force"]), (("-D", "checkpoint=7"), ["is finished already; --force"]),
                            (("-D", "seed=2"), ["is the result of another deck", "seed: 1 there, 2 here"]),
                            (("-D", "steps=20"), ["is the result of another deck", "phases[0].steps: 10 there, 20 here"])):
            status, _, err = run("run", deck, *words, "-o", self.result)
            self.assertEqual(status, 2, words)
            for text in told:
                self.assertIn(text, err)
        rows.write_text(table.replace("0.1", "0.2"))
        status, _, err = run("run", deck, "-o", self.result)
        self.assertEqual((status, err.count("\n")), (2, 1), err)
        self.assertIn("a file that the deck names", err)
        self.assertEqual(self.result.read_bytes(), before)


def limit_file_size(size):
    return lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (size, resource.RLIM_INFINITY))


class Full(Started):
    """When the disk is full nothing that was written is lost."""

    def whole(self, words):
        path = self.folder / "whole.h5"
        self.run_ok("run", *words, "-o", path)
        return path

    def test_file_size_limit(self):
        words = deck_arguments(measure=3000000, series=100, frames=100, checkpoint=0.1)
        whole = self.whole(words)
        # parts fit, the merged file does not; and then not even the parts
        for size, what in (whole.stat().st_size * 2 // 3, "r.h5"), (150000, "r.h5.parts"):
            status, _, err = run("run", *words, "-o", self.result, preexec_fn=limit_file_size(size))
            self.assertEqual(status, 4, err)
            self.assertIn(what, err)
            self.assertFalse(self.result.exists())
            self.assertEqual(list(self.folder.rglob("*.tmp")), [])
            if what == "r.h5":
                self.run_ok("run", *words, "-o", self.result)
                assert_same(self, self.result, whole)
                self.result.unlink()
        self.run_ok("run", *words, "-o", self.result)
        assert_same(self, self.result, whole)

    def test_full_disk(self):
        if os.geteuid() != 0:
            self.skipTest("only root can mount a small disk")
        words = deck_arguments(measure=3000000, series=100, frames=100, checkpoint=0.1)
        whole = self.whole(words)
        small = self.folder / "small"
        small.mkdir()
        size = whole.stat().st_size
        if subprocess.run(["mount", "-t", "tmpfs", "-o", f"size={size * 3 // 2}", "tmpfs", small]).returncode:
            self.skipTest("mounting is not allowed here")
        try:
            result = small / "r.h5"
            status, _, err = run("run", *words, "-o", result)
            self.assertEqual(status, 4, err)
            self.assertIn("No space left", err)
            self.assertFalse(result.exists())
            moved = self.folder / "r.h5.parts"
            shutil.copytree(small / "r.h5.parts", moved)
        finally:
            subprocess.run(["umount", small])
        self.run_ok("run", *words, "-o", self.folder / "r.h5")
        assert_same(self, self.folder / "r.h5", whole)

    def test_no_permission(self):
        status, _, err = run("run", *deck_arguments(), "-o", "/proc/nothing.h5")
        self.assertEqual(status, 4, err)
        self.assertIn("/proc/nothing.h5", err)

    def flip(self, path):
        data = bytearray(path.read_bytes())
        data[len(data) // 3] ^= 8
        path.write_bytes(data)

    def test_damaged_parts(self):
        """They are found when a run continues; nothing is removed, and nothing is left out."""
        words = long_deck()
        whole = self.whole(words)
        for _ in range(10):  # a checkpoint soon after another may have no rows of its own: then once more from the start
            self.stop(self.started(*words))
            counts = []
            for path in self.parts.glob("checkpoint-*.h5"):
                with h5py.File(path) as f:
                    counts.append(int(f["checkpoint"].attrs["parts"]))
            if len(set(counts)) == 2 and min(counts) >= 1:
                break
            shutil.rmtree(self.parts)
        parts = sorted(self.parts.glob("part-*.h5"))
        first, last = parts[0].read_bytes(), parts[-1].read_bytes()
        there = sorted(p.name for p in self.parts.iterdir())
        for spoil in self.flip, lambda p: p.write_bytes(last), lambda p: p.unlink(), lambda p: p.write_bytes(b""):
            spoil(parts[0])
            status, _, err = run("run", *words, "-o", self.result)
            self.assertEqual(status, 4, err)
            self.assertIn(parts[0].name, err)
            self.assertIn("is left as it is", err)
            status, _, err = run("verify", self.result)
            self.assertEqual(status, 4)
            self.assertIn(parts[0].name, err)
            parts[0].write_bytes(first)
            self.assertEqual(sorted(p.name for p in self.parts.iterdir()), there)
        # only the newest checkpoint needs the last part
        self.flip(parts[-1])
        _, err = self.run_ok("run", *words, "-o", self.result)
        self.assertIn(f"{parts[-1].name} is damaged", err)
        self.assertIn("is taken", err)
        assert_same(self, self.result, whole)


if __name__ == "__main__":
    unittest.main()
