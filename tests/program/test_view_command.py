"""slipdisk view: the numbers in the page are those of the result, ranges of frames, decks before they run, bad input."""
import os
import resource
import signal
import unittest

import h5py
import numpy

from results_common import BRIEF, Folder, PROGRAM, deck_arguments, run, start, steps_for, wait_for
from view_page import Page

BOX = """
title = "a box <b>that</b> is shaken & sheared";
dt = 1e-4; integrator = "verlet"; seed = 3; gravity = { g = 9.81; tilt = 0.1; };
materials = ( { name = "grain"; k_n = 1e4; k_t = 5e3; gamma_n = 0.5; mu = 0.3; } );
container = { type = "box"; width = %(width)g; height = %(width)g; };
packings = ( { type = "triangular"; count = %(count)d; sizes = "uniform"; lower = 0.015; upper = 0.02; density = 3.57;
               group = "grains"; } );
motions = ( { name = "shake"; wall = "floor"; coordinate = "y"; type = "harmonic"; amplitude = 1e-3; frequency = 20; } );
phases = ( { name = "fall"; steps = 400; frames = 100; contacts = 100; series = 20; },
           { name = "shake"; steps = 400; frames = 200; contacts = 200; series = 20; } );
measure = { walls = true; groups = true; disks = true; };
"""
LOOSE = """
dt = 1e-4; gravity = { g = 9.81; };
materials = ( { name = "m"; k_n = 1e3; k_t = 1e3; gamma_n = 1; mu = 0.1; } );
box = { periodic = "x"; x = (0, 10); };
walls = ( { name = "floor"; type = "line"; points = ((0, 0), (1, 0)); } );
disks = (
  { name = "a"; x = 2;    y = 1;          radius = 1; mass = 1; },
  { name = "b"; x = 3.99; y = 1;          radius = 1; mass = 1; },
  { name = "c"; x = 9.7;  y = %(height)s; radius = 1; mass = 1; }
);
phases = ( { time = 1; } );
"""
FLOAT = 6e-8  # of a number in single precision


class View(Folder):
    def make(self, text, name="box.cfg", **values):
        deck = self.folder / name
        deck.write_text(text % values)
        return deck

    def ran(self, **values):
        self.run_ok("run", self.make(BOX, **values), "-o", self.result, "--quiet")
        return self.result

    def view(self, *words, page="page.html"):
        out, err = self.run_ok("view", *words, "-o", self.folder / page)
        self.assertIn(f"page: {self.folder / page}", out)
        return Page(self.folder / page), out + err

    def left(self):
        return sorted(path.name for path in self.folder.iterdir())


class Numbers(View):
    def check_frame(self, file, page, k, row, near):
        disks, frame = file["particles/disks"], page.frames[k]
        n = len(disks["radius"])
        self.assertEqual(frame.head["time"], disks["position/time"][row])
        self.assertEqual(frame.head["step"], disks["position/step"][row])
        self.assertEqual(page.marks[k], {"time": frame.head["time"], "step": frame.head["step"]})
        position, velocity = disks["position/value"][row], disks["velocity/value"][row]
        near(frame, "x", position[:, 0], 1e-4 * 0.015)
        near(frame, "y", position[:, 1], 1e-4 * 0.015)
        near(frame, "vx", velocity[:, 0])
        near(frame, "vy", velocity[:, 1])
        near(frame, "spin", disks["angular_velocity/value"][row])
        near(frame, "turned", disks["angle/value"][row] - disks["angle/value"][0], 1e-3)
        self.assertNotIn("activity", frame)
        self.assertEqual(len(frame["x"]), n)

    def check_walls(self, file, page, k, row):
        walls, frame = file["particles/walls"], page.frames[k]
        numpy.testing.assert_array_equal(frame["wall_x"], walls["position/value"][row][:, 0])
        numpy.testing.assert_array_equal(frame["wall_y"], walls["position/value"][row][:, 1])
        numpy.testing.assert_array_equal(frame["wall_angle"], walls["angle/value"][row])

    def check_contacts(self, file, frame, near):
        c = file["contacts"]
        row = int(numpy.flatnonzero(c["step"][:] == frame.head["step"])[0])
        first, n = int(c["first"][row]), int(c["count"][row])
        rows = slice(first, first + n)
        for ours, theirs in ("a", "a"), ("b", "b"), ("part", "part"), ("sliding", "sliding"):
            numpy.testing.assert_array_equal(frame["contact_" + ours], c[theirs][rows])
        for name in "force", "tau", "overlap":
            near(frame, "contact_" + name, c[name][rows])
        return n

    def check_series(self, file, page):
        observables, names = file["observables"], [s["name"] for s in page.meta["series"]]
        self.assertEqual(sorted(names), sorted(set(page.series.columns) - {"time"}))
        numpy.testing.assert_array_equal(page.series["time"], observables["kinetic_translation/time"][:])
        elements = {"angle": "watched_disks", "angular_velocity": "watched_disks"}
        told = 0
        for name in observables:
            if isinstance(observables[name], h5py.Dataset):
                continue
            value = observables[name + "/value"][:]
            if value.ndim == 1:
                numpy.testing.assert_array_equal(page.series[name], value)
                told += 1
                continue
            if name in elements:
                who = [page.meta["disk_names"][k] for k in observables[elements[name]][:]]
            else:
                key = "walls" if name.startswith("wall_") else "groups"
                who = observables[key][()].decode().split("\n")
            for k in range(value.shape[1]):
                numpy.testing.assert_array_equal(page.series[f"{name}[{who[k]}]"], value[:, k])
                told += 1
        self.assertEqual(told, len(names))
        for s in page.meta["series"]:
            here = observables[s["name"].split("[")[0] + "/value"].attrs
            self.assertEqual((s["unit"], s["description"]), (here["unit"].decode(), here["description"].decode()))
        budget = page.meta["budget"]
        supplied = sum(page.series[name] for name in budget["supplied"])
        stored = sum(page.series[name] for name in budget["stored"])
        lost = sum(page.series[name] for name in budget["lost"])
        numpy.testing.assert_allclose(stored + lost - supplied, page.series["residual"], atol=1e-9 * numpy.max(abs(stored)) + 1e-15)

    def test_three_disks_to_the_last_digit_of_single_precision(self):
        self.run_ok("run", *deck_arguments(2000, 7000), "-o", self.result, "--quiet")
        page, _ = self.view(self.result)

        def near(frame, name, value, _=0):
            numpy.testing.assert_allclose(frame[name], value, rtol=FLOAT, atol=1e-37, err_msg=name)

        with h5py.File(self.result) as file:
            times = file["particles/disks/position/step"][:]
            self.assertEqual([f.head["step"] for f in page.frames], list(times))
            self.assertEqual((page.meta["frames"], page.meta["stored_frames"]), (len(times), len(times)))
            for k in range(len(times)):
                self.check_frame(file, page, k, k, near)
            self.assertGreater(self.check_contacts(file, page.frames[-1], near), 0)
            tables = set(file["contacts/step"][:])
            self.assertEqual([f.head["step"] for f in page.frames if "contact_a" in f], [t for t in times if t in tables])
            self.assertLess(len(tables), len(times))
            self.check_series(file, page)
            self.assertEqual(page.meta["disk_names"], file["particles/disks/name"][()].decode().splitlines())
            numpy.testing.assert_allclose(page.static["radius"], file["particles/disks/radius"][:], rtol=FLOAT)
            numpy.testing.assert_array_equal(page.static["driven"], file["particles/disks/driven"][:])
            rotation = page.meta["summary"]["rotation"]
            self.assertEqual([r["omega"] for r in rotation], list(file["summary/rotation/omega"][:]))
            self.assertEqual([r["error"] for r in rotation], list(file["summary/rotation/error"][:]))
        self.assertEqual([p["name"] for p in page.meta["phases"]], ["settle", "measure"])
        self.assertEqual(page.meta["phases"][1]["to"], page.frames[-1].head["time"])

    def check_box(self, count, width, near):
        self.ran(count=count, width=width)
        page, _ = self.view(self.result)
        with h5py.File(self.result) as file:
            rows = range(len(file["particles/disks/position/step"]))
            self.assertEqual(len(page.frames), len(rows))
            for k in rows:
                self.check_frame(file, page, k, k, near)
                self.check_walls(file, page, k, k)
            self.assertGreater(sum(self.check_contacts(file, frame, near) for frame in page.frames), 10)
            self.check_series(file, page)
            means = file["summary/disks"]
            numpy.testing.assert_allclose(page.static["omega"][means["id"][:]], means["omega"][:], rtol=FLOAT, atol=1e-30)
        self.assertEqual(page.meta["title"], "a box <b>that</b> is shaken & sheared")
        self.assertNotIn("<b>that", page.text)  # it cannot end the script in which it stands
        self.assertEqual((page.meta["groups"], page.meta["materials"]), (["grains"], ["grain"]))
        self.assertEqual([w["name"] for w in page.meta["walls"]][:1], ["floor"])
        self.assertEqual(page.meta["laws"], [[[1e4, 5e3, 0.5, 0.3]]])
        numpy.testing.assert_array_equal(page.static["group"], numpy.zeros(count))

    def test_walls_groups_and_means(self):
        def near(frame, name, value, _=0):
            numpy.testing.assert_allclose(frame[name], value, rtol=FLOAT, atol=1e-37, err_msg=name)

        self.check_box(40, 0.4, near)

    def test_large_packings_are_told_as_far_as_can_be_seen(self):
        def near(frame, name, value, off=0):
            numpy.testing.assert_allclose(frame[name], value, rtol=2**-11, atol=off or 1e-37, err_msg=name)
            numpy.testing.assert_array_equal(frame[name][value == 0], 0, err_msg=name)

        self.check_box(1500, 1.6, near)

    def test_periodic_box_that_is_compressed_and_disks_that_wait(self):
        deck = self.make("""
dt = 1e-3; seed = 2; integrator = "verlet";
materials = ( { name = "m"; k_n = 1; k_t = 1; gamma_n = 0.5; mu = 0.2; } );
box = { periodic = "xy"; x = (-3, 9); y = (1, 13); };
packings = ( { type = "random"; count = 40; radius = 0.5; density = 1; } );
phases = ( { name = "press"; steps = 3000; frames = 1000; compress = { fraction = 0.3; rate = 0.05; }; } );
""")
        self.run_ok("run", deck, "-o", self.result, "--quiet")
        page, _ = self.view(self.result)
        with h5py.File(self.result) as file:
            box = file["particles/disks/box"]
            for k, frame in enumerate(page.frames):
                numpy.testing.assert_array_equal(frame.head["edges"], box["edges/value"][k])
                self.assertEqual(frame.head["scale"], box["scale/value"][k])
                self.assertEqual(frame.head["lower"], [-3, 1])
            self.assertLess(page.frames[-1].head["scale"], 0.99)
        self.assertEqual(page.meta["box"], {"lower": [-3, 1], "edges": [12, 12], "periodic": [True, True]})


class Frames(View):
    def steps(self, *words):
        page, said = self.view(*words)
        return [frame.head["step"] for frame in page.frames], said

    def test_ranges(self):
        self.ran(count=20, width=0.4)
        everything = [0, 100, 200, 300, 400, 600, 800]
        self.assertEqual(self.steps(self.result)[0], everything)
        for text, wanted in ("-1:", [800]), ("::3", everything[::3]), ("2", [200]), ("1:4", everything[1:4]):
            self.assertEqual(self.steps(self.result, "--frames=" + text)[0], wanted)
        page, _ = self.view(self.result, "--frames=3:")  # turns are counted from its first frame
        self.assertEqual(numpy.count_nonzero(page.frames[0]["turned"]), 0)
        for text in "x", "9", "5:2":
            status, _, err = run("view", self.result, "-o", self.folder / "no.html", "--frames", text)
            self.assertEqual(status, 2, err)
            self.assertIn("--frames", err)
        self.assertNotIn("no.html", self.left())

    def test_many_frames_and_rows_are_thinned_evenly(self):
        self.run_ok("run", *deck_arguments(1000, 21000, frames=10, series=1), "-o", self.result, "--quiet")
        steps, said = self.steps(self.result)
        self.assertIn(f"{len(steps)} frames of {2101 + 1}", said)
        self.assertLessEqual(len(steps), 501)
        self.assertGreater(len(steps), 250)
        self.assertEqual(len(set(numpy.diff(steps))), 1)
        self.assertEqual(steps[-1], 22000)
        page, _ = self.view(self.result)
        rows = page.meta["series_rows"]
        with h5py.File(self.result) as file:
            value = file["observables/external/value"][:]
        self.assertEqual(rows["stored"], len(value))
        self.assertGreater(rows["every"], 1)
        numpy.testing.assert_array_equal(page.series["external"][:-1], value[::rows["every"]][:len(page.series["time"]) - 1])
        self.assertEqual(page.series["external"][-1], value[-1])
        self.assertEqual(len(self.steps(self.result, "--frames", ":")[0]), 2102)

    def test_result_without_frames_but_the_ends(self):
        self.run_ok("run", *deck_arguments(1000, 2000, frames=0), "-o", self.result, "--quiet")
        steps, said = self.steps(self.result)
        self.assertEqual(steps, [0, 3000])
        self.assertIn("frames = 15 makes 200", said)

    def test_unfinished_run_and_its_checkpoint(self):
        process = start("run", *deck_arguments(1000, steps_for(60), checkpoint=0.2, frames=1000), "-o", self.result, "--quiet")
        wait_for(lambda: len(self.checkpoints()) > 1)
        process.send_signal(signal.SIGINT)
        process.communicate()
        self.assertEqual(process.returncode, 75)
        newest = self.checkpoints()[0]
        for name in self.result, self.parts:
            steps, _ = self.steps(name, "--frames", ":")
            self.assertEqual(steps[:3], [0, 1000, 2000])
            self.assertEqual(steps[-1], newest)
        page, _ = self.view(self.parts / f"checkpoint-{newest}.h5")
        self.assertEqual([frame.head["step"] for frame in page.frames], [newest])
        self.assertIsNone(page.series)
        page, _ = self.view(self.result)
        self.assertEqual(page.meta["disk_names"][0], "upper")
        self.assertIn("angle[upper]", page.series)


class Decks(View):
    def test_deck_that_is_right(self):
        page, said = self.view(self.make(LOOSE, height="4"))
        self.assertEqual(page.meta["kind"], "deck")
        self.assertEqual(len(page.frames), 1)
        frame = page.frames[0]
        self.assertEqual(list(zip(frame["contact_a"], frame["contact_b"])), [(0, 1)])
        numpy.testing.assert_allclose(frame["contact_overlap"], [0.01], rtol=1e-5)
        numpy.testing.assert_allclose(frame["contact_force"], [10], rtol=1e-5)
        self.assertIn("1 pair overlaps", said)
        self.assertEqual(page.meta["phases"], [{"name": "", "from": 0, "to": 1}])
        self.assertEqual([m["level"] for m in page.meta["messages"] if m["disks"]], ["note"])

    def test_mistakes_in_where_disks_are_can_be_looked_at(self):
        deck, page = self.make(LOOSE, height="0.3"), self.folder / "page.html"
        status, out, err = run("view", deck, "-o", page)
        self.assertEqual(status, 2)
        self.assertIn("page: ", out)
        self.assertIn('disk "c" sits', err)
        shown = Page(page)
        frame = shown.frames[0]
        pairs = set(zip(frame["contact_a"], frame["contact_b"]))
        self.assertEqual(pairs, {(0, 1), (2, 3)})
        errors = [m for m in shown.meta["messages"] if m["level"] == "error"]
        self.assertIn('disk "c" sits', errors[0]["text"])
        self.assertEqual(errors[-1]["disks"], [2])
        self.assertEqual(shown.meta["max_overlap"], 0.5)
        checked, _, told = run("check", deck)
        self.assertEqual(checked, status)
        self.assertEqual(told, err)  # the same messages

    def test_across_the_edge_of_the_box(self):
        page, _ = self.view(self.make(LOOSE, height="1"), "-D", "disks.a.x=1.4", "-D", "disks.b.x=5")
        frame = page.frames[0]
        self.assertEqual(set(zip(frame["contact_a"], frame["contact_b"])), {(0, 2)})

    def test_warnings_of_check_are_messages(self):
        page, said = self.view(self.make(LOOSE, height="4"), "-D", "materials.m.k_t=0")
        self.assertIn("warning", said)
        warnings = [m["text"] for m in page.meta["messages"] if m["level"] == "warning"]
        self.assertTrue(warnings)
        for text in warnings:
            self.assertIn(text, said)

    def test_disks_that_wait(self):
        page, said = self.view(self.make(LOOSE, height="4"), "-D", "packings=({type=\"rain\"; count=5; radius=0.1; density=1; y=(6, 9);})")
        self.assertIn("; 5 disks wait and fall in while it runs", said)
        self.assertIn("5 disks wait and fall in while it runs", [m["text"] for m in page.meta["messages"]])
        self.assertEqual(sorted(page.frames[0]["activity"]), [0] * 3 + [1] * 5)

    def test_many_disks_in_one_place_end(self):
        deck = self.make("""
dt = 1e-4; max_overlap = 0.5;
materials = ( { name = "m"; k_n = 1e3; k_t = 1e3; gamma_n = 1; mu = 0.1; } );
disk_rows = ( { columns = ("x", "y"); radius = 1; mass = 1; rows = (%(rows)s); } );
phases = ( { steps = 10; } );
""", rows=", ".join("(0, 0)" for _ in range(2000)))
        status, out, err = run("view", deck, "-o", self.folder / "page.html")
        self.assertEqual(status, 2, err)
        self.assertLess(len(Page(self.folder / "page.html").frames[0]["contact_a"]), 2000 * 33)

    def test_deck_that_cannot_be_read_is_told_as_check_does(self):
        deck = self.folder / "wrong.cfg"
        for text in "dt = 1e-4; disks = ( { x = ", "dt = -1; hello = 3;", "", "\0\1\2":
            deck.write_text(text)
            status, out, err = run("view", deck)
            self.assertEqual((status, err, out), (*(run("check", deck)[k] for k in (0, 2)), ""))
            self.assertEqual(self.left(), ["wrong.cfg"])


class Bad(View):
    def refused(self, wanted, *words, **more):
        before = self.left()
        status, out, err = run("view", *words, cwd=self.folder, **more)
        self.assertEqual(status, wanted, out + err)
        self.assertTrue(err.startswith("error: "), err)
        self.assertEqual(self.left(), before)
        return err

    def test_nonsense(self):
        self.ran(count=20, width=0.4)
        self.refused(2, "nothing.h5")
        self.refused(2, "nothing.cfg")
        self.refused(2)
        self.refused(2, self.result, "-D", "dt=1")
        self.refused(2, "box.cfg", "--frames", "1")
        self.refused(2, self.result, "--live")
        self.refused(2, "box.cfg", "--threads", "2")
        self.assertIn("that is a result, which would be lost", self.refused(2, self.result, "-o", self.result))
        self.assertIn("that is a deck, which would be lost", self.refused(2, "box.cfg", "-o", "./box.cfg"))
        self.refused(2, self.folder)
        other = self.folder / "other.h5"
        with h5py.File(other, "w") as file:
            file["x"] = [1, 2]
        self.assertIn("not a result", self.refused(2, other))
        other.write_bytes(b"\x89PNG\r\n\x1a\n" + bytes(100))
        self.refused(4, other)
        broken = bytearray(self.result.read_bytes())
        broken[len(broken) // 2] ^= 255
        other.write_bytes(broken)
        self.assertIn("damaged", self.refused(4, other))
        other.write_bytes(broken[:1000])
        self.refused(4, other)

    def test_page_that_cannot_be_written(self):
        self.ran(count=20, width=0.4)
        self.refused(4, self.result, "-o", "no/page.html")
        self.refused(4, self.result, "-o", self.folder)
        self.refused(2, self.result, "-o", "-")
        old = self.folder / "page.html"
        old.write_text("old")

        def small():
            resource.setrlimit(resource.RLIMIT_FSIZE, (5000, 5000))

        err = self.refused(4, self.result, "-o", "page.html", preexec_fn=small)
        self.assertIn("page.html", err)
        self.assertEqual(old.read_text(), "old")
        if os.geteuid() != 0:
            (self.folder / "locked").mkdir(mode=0o500)
            self.refused(4, self.result, "-o", "locked/page.html")

    def test_stopped_while_it_writes(self):
        self.run_ok("run", *deck_arguments(1000, 200000, frames=10), "-o", self.result, "--quiet")
        before = self.left()
        process = start("view", self.result, "--frames", ":", cwd=self.folder)
        wait_for(lambda: self.left() != before or process.poll() is not None)
        process.send_signal(signal.SIGINT)
        _, err = process.communicate()
        self.assertEqual((process.returncode, err), (75, "stopped: no page is written\n"))
        self.assertEqual(self.left(), before)

    def test_open_without_a_browser(self):
        self.ran(count=20, width=0.4)
        status, out, err = run("view", self.result, "--open", cwd=self.folder, env={"PATH": "/nowhere"})
        self.assertEqual(status, 0, err)
        self.assertIn("there is no xdg-open here", err)
        self.assertTrue((self.folder / "r.html").exists())
        tool = self.folder / "xdg-open"
        tool.write_text('#!/bin/sh\necho "$1" > opened\n')
        tool.chmod(0o755)
        status, out, err = run("view", self.result, "--open", cwd=self.folder, env={"PATH": f"{self.folder}:/bin:/usr/bin"})
        self.assertEqual((status, err), (0, ""))
        self.assertEqual((self.folder / "opened").read_text(), "r.html\n")

    @unittest.skipIf(BRIEF, "a sanitizer keeps memory that was freed")
    def test_memory_is_that_of_a_frame(self):
        self.run_ok("run", *deck_arguments(1000, 30000, frames=10), "-o", self.result, "--quiet")
        peak = []
        for words in (["--frames", "0"], ["--frames", ":"]):
            process = start("view", self.result, "-o", self.folder / "page.html", *words)
            with process.stdout, process.stderr:
                process.stdout.read(), process.stderr.read()
            _, status, used = os.wait4(process.pid, 0)
            process.returncode = status
            self.assertEqual(status, 0)
            peak.append(used.ru_maxrss)
        self.assertGreater(len(Page(self.folder / "page.html").frames), 3000)
        self.assertLess(peak[1], peak[0] + 4000)  # kB; the frames take 4 MB as they stand in the page


if __name__ == "__main__":
    assert PROGRAM
    unittest.main()
