"""What is read from outside is bounded: time, memory, what is opened, what reaches the terminal. Every call runs under
a limit of its CPU time and memory, so that reading without end fails here."""
import json
import os
import pathlib
import resource
import shutil
import subprocess
import tempfile
import unittest

import h5py
import numpy

from results_common import PROGRAM

CPU, MEMORY = 20, 1500 << 20
SANITIZED = b"__asan_init" in pathlib.Path(PROGRAM).read_bytes()  # these reserve terabytes of addresses

MANY = 4000 if SANITIZED else 40000

HEAD = 'dt = 1e-4; steps = 10; materials = ( { name = "m"; k_n = 1e5; } );\n'
DISK = "disks = ( { x = 0.0; y = 0.0; radius = 1.0; mass = 1.0; } );\n"
NO_FILE = "it is a device or a pipe, not a file"


def limited():
    resource.setrlimit(resource.RLIMIT_CPU, (CPU, CPU))
    if not SANITIZED:
        resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))


class Limits(unittest.TestCase):
    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="slipdisk-input-"))
        self.addCleanup(shutil.rmtree, self.folder)

    def call(self, *words):
        """(exit status, standard output, standard error) in bytes"""
        done = subprocess.run([PROGRAM, *words], cwd=self.folder, preexec_fn=limited, capture_output=True, timeout=120,
                              stdin=subprocess.DEVNULL, check=False)
        for stream in (done.stdout, done.stderr):
            stream.decode()  # UTF-8
            self.assertFalse([c for c in stream if c < 0x20 and c not in b"\n\t"], stream[:400])
        return done.returncode, done.stdout, done.stderr

    def write(self, name, text):
        (self.folder / name).write_bytes(text if isinstance(text, bytes) else text.encode())
        return name

    def refuse(self, text, *messages, status=2):
        """The deck is refused, in few words."""
        found, _, err = self.call("check", "--brief", self.write("deck.cfg", text))
        self.assertEqual(found, status, err[:2000])
        for message in messages:
            self.assertIn(message, err.decode())
        self.assertLess(len(err), 100 * 1000)
        return err.decode()

    def test_materials_beyond_the_limit_have_their_names(self):
        many = "".join(f'{{ name = "m{k}"; k_n = 1e5; }}, ' for k in range(1001))
        disks = DISK.replace("mass = 1.0;", 'mass = 1.0; material = "m1000";')
        said = self.refuse(f"dt = 1e-4; steps = 10;\nmaterials = ( {many[:-2]} );\n{disks}", "1001 materials; expected at most 1000")
        self.assertNotIn("is called that", said)

    def unseal(self, one, two):
        """A result as versions without checksums have written it: what is altered in it is read."""
        with h5py.File(self.folder / one) as new, h5py.File(self.folder / two, "w") as old:
            for key in new:
                new.copy(key, old)
            old.attrs.update({name: value for name, value in new.attrs.items() if name != "sealed"})

    def accept(self, text):
        found, _, err = self.call("check", "--brief", self.write("deck.cfg", text))
        self.assertEqual(found, 0, err[:2000])


class Names(Limits):
    def test_empty_names(self):
        self.write("deck.cfg", HEAD + DISK)
        for words in (["run", "deck.cfg", "-o"], ["run", "deck.cfg", "--log"], ["resume", "x.h5", "--log"],
                      ["sweep", "deck.cfg", "-o"], ["measure", "x.h5", "-o"], ["measure", "x.h5", "--csv"],
                      ["theory", "deck.cfg", "--csv"], ["theory", "deck.cfg", "--wave"]):
            status, _, err = self.call(*words, "")
            self.assertEqual(status, 2, words)
            self.assertIn(f"{words[-1]} needs the name of a file or a folder", err.decode())
        self.assertEqual(os.listdir(self.folder), ["deck.cfg"])

    def test_only_files_are_opened(self):
        os.mkfifo(self.folder / "pipe")
        os.mkdir(self.folder / "folder.cfg")
        for name in ("/dev/zero", "/dev/urandom", "pipe"):
            self.refuse(HEAD + DISK + f'@include "{name}"\n', f'@include "{name}": {NO_FILE}')
            for form in ('format = "csv"; mass = 1;', 'format = "lammps"; density = 1;',
                         'format = "hdf5"; dataset = "/a"; mass = 1;', 'format = "hdf5"; contacts = true;'):
                self.refuse(HEAD + f'disk_files = ( {{ file = "{name}"; {form} }} );', NO_FILE)
            self.refuse(HEAD + 'disks = ( { x = 0; y = 0; radius = 1; mass = 1; fixed = true; } );\n' +
                        f'motions = ( {{ disk = 0; coordinate = "x"; type = "table"; file = "{name}"; }} );', NO_FILE)
            self.refuse(HEAD + DISK + f'box = {{ periodic = "x"; file = "{name}"; }};', NO_FILE)
            for command, expected in (("check", 2), ("run", 2), ("theory", 2), ("info", 4), ("measure", 4)):
                status, _, err = self.call(command, name)
                self.assertEqual(status, expected, (command, err))
                self.assertIn(NO_FILE, err.decode())
        status, _, err = self.call("check", "folder.cfg")
        self.assertEqual(status, 2)
        self.assertIn("it is a folder, not a file", err.decode())


class Size(Limits):
    def test_keys(self):
        err = self.refuse(HEAD + DISK + "skin = 0.1;\n" * MANY, "skin: key given twice; first on line 3",
                          "more errors like these")
        self.assertLess(err.count("\n"), 110)
        self.refuse(HEAD + DISK + "".join(f"key{k} = 1;\n" for k in range(MANY)), "more than 256 keys in one group")
        self.refuse(HEAD + DISK + "a" * 10**7 + " = 1;", "aaa...: a key of 10000000 characters; expected at most 80")
        self.refuse(HEAD + DISK + 'title = "' + "a" * 10**6 + '"; title = 1;', "key given twice")
        self.refuse(HEAD + DISK + 'seed = "' + "a" * 10**6 + '";', 'aaa...": expected a number; no constant')
        self.refuse(HEAD + DISK + "skin = " + "1" * 10**6 + "x;", "111...: number too large")
        self.refuse(HEAD + "disks = (" + "{ x = q; }," * MANY + "{});", "q: expected a number, or quotes")
        self.refuse(HEAD + "disks = (" + "{ a = 1; }," * MANY + "{});", "disks[0].a = 1: unknown key")

    def test_includes(self):
        for k in range(10):
            self.write(f"in{k}.cfg", f'@include "in{(k + 1) % 10}.cfg"\n' * 10)
        self.refuse('@include "in0.cfg"\n', "more than 8 files inside each other")
        self.write("empty.cfg", "")
        self.refuse(HEAD + DISK + '@include "empty.cfg"\n' * 1002, "more than 1000 files are included")
        self.write("mib.cfg", "# 3456789\n" * 100000)
        self.refuse(HEAD + DISK + '@include "mib.cfg"\n' * 20, "more than 16 MiB with all that it includes")
        self.refuse("#" * (17 << 20), "it has 17.0 MiB; expected at most 16 MiB")

    def test_lists(self):
        some = ", ".join('{ disk = 0; coordinate = "x"; type = "fixed"; }' for _ in range(10001))
        self.refuse(HEAD + DISK + f"motions = ( {some} );", "10001 entries; expected at most 10000")
        self.refuse("dt = 1e-4; steps = 10;" + DISK + "materials = ( " +
                    ", ".join(f'{{ name = "m{k}"; k_n = 1; }}' for k in range(1001)) + " );", "1001 materials")
        many = "".join(f'{{ name = "m{k}"; disk = 0; coordinate = "theta"; type = "fixed"; }},' for k in range(9999))
        self.accept(HEAD + DISK + f"motions = ( {many} {{ name = \"m\"; disk = 0; coordinate = \"x\"; type = \"fixed\"; }} );")

    def test_disks(self):
        n = MANY
        deck = HEAD + 'disk_files = ( { file = "a.csv"; mass = 1.0; } );'
        self.write("a.csv", "x,y,radius\n" + "0,0,1\n" * n)
        self.refuse(deck, "have the same centre", f"{n - 1} more disks overlap others too much")
        self.write("a.csv", "x,y,radius\n" + "".join(f"0,0,{1 + k / n}\n" for k in range(n)))
        self.refuse(deck, "more disks overlap others too much")
        self.write("a.csv", "x,y,radius\n" + "1e99,0,1\n" * n)
        self.refuse(deck, "more disks overlap others too much")
        # as many small ones within the cell of a large one
        self.write("a.csv", "x,y,radius\n" + "".join(f"{3 * k},0,1\n" for k in range(n + 2)) +
                   "".join(f"{k % 200 * 1e-4 + 1.4},{k // 200 * 1e-4},4e-5\n" for k in range(n)))
        self.assertEqual(self.refuse(deck + "key = 1;", "key = 1: unknown key").count("\n"), 1)
        self.write("a.csv", "x,y,radius,group,name\n" + "".join(f"{3 * k},0,1,g{k},n{k}\n" for k in range(n)))
        self.accept(deck + "forces = ( { group = (" + ", ".join(f'"g{k}"' for k in range(n)) + "); force = (1, 0); } );")
        wall = ", ".join(f"({3 * k}, {-2 - k % 2})" for k in range(n))
        self.assertEqual(self.refuse(deck + f'walls = ( {{ type = "polyline"; points = ( {wall} ); }} ); key = 1;',
                                     "key = 1: unknown key").count("\n"), 1)
        self.write("a.csv", "x,y,radius\n" + "x,y,z\n" * n)
        self.refuse(deck, "x = x: expected a number", "more errors like these")
        self.write("a.csv", ",".join("c" for _ in range(2000)) + "\n")
        self.refuse(deck, "2000 columns; expected at most 1000")

    def test_overrides(self):
        self.write("deck.cfg", HEAD + DISK)
        for word, message in (("a." * 60 + "b=1", "more than 40 steps in the path"),
                              ("k" * 1000 + "=1", "a key of 1000 characters"),
                              ("seed=" + "9" * 1000, "out of range"),
                              ("seed=" + "(" * 1000, "cannot be read"),
                              ("title=\x1b[31m", "control characters"), ('title="\x1b[31m"', "control characters"),
                              ("box.x=(1, \"\\xff\")", "control characters")):
            status, _, err = self.call("check", "deck.cfg", "-D", word)
            self.assertEqual(status, 2)
            self.assertIn(message, err.decode())
            self.assertLess(len(err), 500)

    def test_numbers(self):
        for key, value in (("dt", "1e-308"), ("dt", "1e-310"), ("dt", "1e+200"), ("skin", "1e-200")):
            self.refuse(HEAD.replace("dt = 1e-4;", "" if key == "dt" else "dt = 1e-4;") + DISK + f"{key} = {value};",
                        f"{key} = {value}", "1e100")
        self.refuse(HEAD + DISK.replace("mass = 1.0", "mass = 1e-308"), "mass = 1e-308", "from 1e-100 to 1e100")
        self.refuse(HEAD + DISK.replace("x = 0.0", "x = 1e200"), "x = 1e+200: expected a number from -1e100 to 1e100")
        self.refuse(HEAD + DISK.replace("mass = 1.0", "density = 1e-90").replace("radius = 1.0", "radius = 1e-20"),
                    "the mass is 3.14159e-130")
        self.write("a.csv", "x,y,radius,mass\n0,0,1,1e-308\n")
        self.refuse(HEAD + 'disk_files = ( { file = "a.csv"; } );', "a.csv:2: mass: 1e-308: expected a number > 0, from")


class Texts(Limits):
    def test_decks(self):
        for text in (b"a\x1b[31mb", b"a\\x1b[31mb", b"f\xfcr", b"\\xff", "a\u0085b".encode(), b"\x7f"):
            self.refuse((HEAD + DISK).encode() + b'title = "' + text + b'";', "deck.cfg:3: title",
                        "expected a text in UTF-8 without control characters")
        self.accept((HEAD + DISK + 'title = "f\u00fcr \u03bc"; # ').encode() + b"f\xfcr \x1b[31m\n")
        self.refuse((HEAD + DISK).encode() + b"\x1b[31m = 1;", "unexpected byte 0x1b")
        self.write("a.csv", b"x,y,radius,name\n0,0,1,\x1b[31m\n")
        self.refuse(HEAD + 'disk_files = ( { file = "a.csv"; mass = 1; } );', "a.csv:2: name: expected a text in UTF-8")
        self.write("a.csv", b"x,y,radius\n0,0,\x1b[31m\n")
        self.refuse(HEAD + 'disk_files = ( { file = "a.csv"; mass = 1; } );', "radius = \\x1b[31m: expected a number")

    def test_names(self):
        for words in (["run", b"no\x1b[31m.cfg"], ["info", b"no\x1b[31m\xff.h5"], [b"\x1b[31m"], ["run", b"--\x1b[31m"],
                      ["check", "deck.cfg", "-D", b"\x1b[31m=1"]):
            self.write("deck.cfg", HEAD + DISK)
            status, _, err = self.call(*words)
            self.assertEqual(status, 2, err)
            self.assertIn(b"\\x1b[31m", err)
        result = b"odd\x1b[31m\xff.h5"
        self.assertEqual(self.call("run", "deck.cfg", "-o", result)[0], 0)
        for words in (["info"], ["info", "--json"], ["measure"], ["measure", "--json"]):
            status, out, err = self.call(*words, result)
            self.assertEqual(status, 0, err)
            if "--json" in words:
                self.assertEqual(json.loads(out)["file"], "odd?[31m?.h5")

    def test_old_results(self):
        """Earlier versions have stored what is refused today."""
        self.write("deck.cfg", HEAD + DISK + 'title = "xx titled"; measure = { rotation = (0); };\n')
        self.assertEqual(self.call("run", "deck.cfg", "-o", "new.h5", "--quiet")[0], 0)
        self.unseal("new.h5", "old.h5")
        with h5py.File(self.folder / "old.h5", "a") as old:
            old["parameters"].attrs["title"] = numpy.bytes_(b"f\xfcr \x1b[31m")
            old["summary"].attrs["phase_name"] = numpy.bytes_(b"\xff\x1b")
            del old["summary/rotation/name"]
            old["summary/rotation/name"] = numpy.bytes_(b"\x1b[31m\xc3\n")
            old[b"odd\xff\x1b"] = [1.0]
            group = old.create_group("ring")
            group["one"] = group
        for words in (["info", "old.h5"], ["info", "--deck", "old.h5"], ["info", "--json", "old.h5"]):
            status, out, err = self.call(*words)
            if status == 0 and "--json" in words:
                self.assertEqual(json.loads(out)["rotation"][0]["name"], "?[31m?")
                self.assertEqual(json.loads(out)["provenance"]["title"], "f?r ?[31m")
            self.assertIn((status, b"cannot list its contents" in err), [(0, False), (4, True)], err)
        with h5py.File(self.folder / "old.h5", "a") as old:
            del old["ring"]
        status, out, err = self.call("info", "--json", "old.h5")
        self.assertEqual(status, 0, err)
        self.assertEqual(json.loads(out)["provenance"]["title"], "f?r ?[31m")
        self.assertEqual(json.loads(out)["rotation"][0]["name"], "?[31m?")
        self.assertEqual(self.call("info", "old.h5")[0], 0)


class Tables(Limits):
    def deck(self, more=""):
        return HEAD + f'disk_files = ( {{ file = "a.h5"; dataset = "/t"; mass = 1; {more} }} );'

    def columns(self, **more):
        """/t/x, /t/y, /t/radius of three disks, but for those given."""
        with h5py.File(self.folder / "a.h5", "w") as file:
            for name, values in dict({"x": [0, 3, 6], "y": [0, 0, 0], "radius": [1, 1, 1]}, **more).items():
                if callable(values):
                    values(file, f"t/{name}")
                else:
                    file[f"t/{name}"] = numpy.array(values, dtype="f8")

    def test_many_rows(self):
        n = 240_000_000

        def zeros(file, name):
            file.create_dataset(name, (n,), "f8", chunks=(1 << 20,), compression="gzip", fillvalue=0)
            file[name][:1 << 20] = 0
        self.columns(x=zeros, y=zeros, radius=zeros)
        self.refuse(self.deck(), "/t has 240000000 rows; expected at most 200000000")
        with h5py.File(self.folder / "a.h5", "w") as file:
            file.create_dataset("t", (n,), numpy.dtype([("x", "f8"), ("y", "f8"), ("radius", "f8")]), chunks=(1 << 16,))
        self.refuse(self.deck(), "/t has 240000000 rows; expected at most 200000000")

    def test_wide(self):
        names = ["x", "y", "radius", *(f"c{k}" for k in range(997))]
        for width in 1000, 1_000_000:
            with h5py.File(self.folder / "a.h5", "w") as file:
                file.create_dataset("t", (1000, width), "f8", chunks=(1000, 1000), compression="gzip")
                file["t"][:, :1000] = 0
                file["t"][:, 0] = numpy.arange(1000) * 3
                file["t"][:, 2] = 1
                file["t"].attrs["columns"] = numpy.array(names, "S8")
            if width == 1000:
                self.accept(self.deck())
        self.refuse(self.deck(), '1000000 columns, and its attribute "columns" 1000 names')

    def test_not_written(self):
        self.columns(x=lambda file, name: file.create_dataset(name, (5_000_000,), "f8", chunks=(1 << 16,)))
        self.refuse(self.deck(), "column \"x\": cannot be read as numbers")
        self.columns(x=lambda file, name: file.create_dataset(name, (1 << 24,), "f8", chunks=(1 << 24,),
                                                              compression="gzip"))
        self.refuse(self.deck(), "its chunks are too large")

    def test_elsewhere(self):
        with h5py.File(self.folder / "other.h5", "w") as file:
            file["x"] = numpy.array([0.0, 3.0, 6.0])
        numpy.zeros(3).tofile(self.folder / "raw")

        def virtual(file, name):
            layout = h5py.VirtualLayout((3,), "f8")
            layout[:] = h5py.VirtualSource("other.h5", "x", (3,))
            file.create_virtual_dataset(name, layout)
        self.columns()
        self.accept(self.deck())
        for values, message in ((lambda file, name: file.__setitem__(name, h5py.ExternalLink("other.h5", "/x")),
                                 'column "x": is a link, which is not followed'),
                                (lambda file, name: file.__setitem__(name, h5py.SoftLink("/t/y")),
                                 'column "x": is a link, which is not followed'),
                                (virtual, "its values stand in other datasets (a virtual dataset)"),
                                (lambda file, name: file.create_dataset(name, (3,), "f8", external=[("raw", 0, 24)]),
                                 "its values stand in other files (external storage)")):
            self.columns(x=values)
            self.refuse(self.deck(), message)
        with h5py.File(self.folder / "a.h5", "w") as file:
            file["t"] = h5py.ExternalLink("other.h5", "/")
        self.refuse(self.deck(), "/t is a link, which is not followed")

    def test_results(self):
        """A result with a column that stands elsewhere, and with numbers of things that are not there."""
        self.write("deck.cfg", HEAD + DISK)
        self.assertEqual(self.call("run", "deck.cfg", "-o", "new.h5", "--quiet")[0], 0)

        def alter(change):
            self.unseal("new.h5", "a.h5")
            with h5py.File(self.folder / "a.h5", "a") as old:
                change(old)
        go = HEAD + 'disk_files = ( { file = "a.h5"; contacts = true; } );'
        alter(lambda file: None)
        self.accept(go)

        def link(file):
            del file["state/theta"]
            file["state/theta"] = h5py.ExternalLink("new.h5", "/state/theta")
        alter(link)
        self.refuse(go, "/state/theta is a link, which is not followed", "the state in this file is damaged")
        for name in ("n_contacts", "n_bodies", "n_disks"):
            alter(lambda file, name=name: file["state"].attrs.__setitem__(name, numpy.int64(70_000_000)))
            self.refuse(go, "the state in this file is damaged")
        for group in ("rotation", "slide", "configuration", "phase"):
            alter(lambda file, group=group: file[f"summary/{group}"].attrs.__setitem__("count", numpy.int64(1 << 31)))
            status, _, err = self.call("info", "a.h5")
            self.assertEqual(status, 4, err)
            self.assertIn("the summary is damaged", err.decode())


if __name__ == "__main__":
    unittest.main()
