"""Results whose datasets are logically far larger than memory: `info` and `measure` read what they need and no more.

A small run gives the layout. Its datasets are made anew with up to a thousand million rows, of which only those that are
asked for are really there (chunks that were never written take no room on disk)."""
import json
import os
import subprocess
import sys

import h5py
import numpy

from results_common import PROGRAM, Folder, unittest

DECK = """
integrator = "verlet";
dt = 0.002;
gravity = { g = 9.81; };
seed = 7;
materials = ( { name = "m"; k_n = 1000; k_t = 500; gamma_n = 1; mu = 0.3; } );
container = { type = "box"; width = 4; height = 6; };
packings = ( { type = "square"; count = 12; radius = 0.4; density = 1; spacing = 1; jitter = 0.9; } );
phases = ( { name = "go"; steps = %d; } );
output = { series = 10; frames = %d; contacts = %d; };
measure = { rotation = (); disks = true; };
"""
FRAMES = 10**9  # of 12 disks: 780 GB
WANTED = 777777777
DISKS = 5 * 10**7  # with means: 8.6 GB


def cost(*words):
    """standard output, MiB at most in memory, bytes read"""

    def read():
        with open("/proc/self/io") as io:  # those of children that were waited for are counted
            return int(io.readline().split()[1])

    before = read()
    # the address sanitizer would keep 256 MB of what was freed
    plain = dict(os.environ, ASAN_OPTIONS=os.environ.get("ASAN_OPTIONS", "") + ":quarantine_size_mb=1")
    process = subprocess.Popen([PROGRAM, *map(str, words)], stdout=subprocess.PIPE, env=plain)
    with process.stdout as pipe:
        out = pipe.read()
    _, status, used = os.wait4(process.pid, 0)
    process.returncode = status
    assert status == 0, out
    return out.decode(), used.ru_maxrss / 1024, read() - before


def enlarge(file, path, rows, wanted=None, values=None, fill=0):
    """Makes a dataset anew with so many rows, of which row `wanted` is written."""
    old = file[path]
    attributes, kind, shape = dict(old.attrs), old.dtype, old.shape[1:]
    del file[path]
    new = file.create_dataset(path, (rows, *shape), kind, chunks=(4096, *shape), compression=1, shuffle=True,
                              fillvalue=fill)
    new.attrs.update(attributes)
    if wanted is not None:
        new[wanted] = values


class Large(Folder):
    def make(self, steps=1000, frames=200, contacts=200):
        deck = self.folder / "r.cfg"
        deck.write_text(DECK % (steps, frames, contacts))
        self.run_ok("run", deck, "-o", self.result, "--quiet")

    def test_frames(self):
        self.make()
        small, memory, _ = cost("measure", self.result, "--frame", 3, "--json")
        with h5py.File(self.result, "r+") as f:
            del f.attrs["sealed"]  # a file without a checksum, of which nothing is read but what is asked for
            disks, contacts = f["particles/disks"], f["contacts"]
            step, first, count = (int(x[3]) for x in (disks["position/step"], contacts["first"], contacts["count"]))
            time = disks["position/time"][3]
            for name in "position", "velocity", "angle", "angular_velocity", "image":
                for bodies in "disks", "walls":
                    path = f"particles/{bodies}/{name}/value"
                    enlarge(f, path, FRAMES, WANTED, f[path][3])
            enlarge(f, "particles/disks/activity/value", FRAMES, WANTED, disks["activity/value"][3])
            # moments before are at -1; what comes behind is not looked at
            enlarge(f, "particles/disks/position/step", FRAMES, WANTED, step, -1)
            enlarge(f, "particles/disks/position/time", FRAMES, WANTED, time, -1.0)
            rows = {k: contacts[k][first:first + count] for k in "a b part overlap force tau zeta sliding".split()}
            at, n = 20 * WANTED, WANTED + 1
            for name, values in rows.items():
                enlarge(f, f"contacts/{name}", 20 * FRAMES, slice(at, at + count), values)
            for name, value in ("step", step), ("time", time), ("first", at), ("count", count):
                enlarge(f, f"contacts/{name}", n, WANTED, value, -1)
        self.assertLess(self.result.stat().st_size, 1e7)
        for words in (), ("--json",):
            _, used, read = cost("info", self.result, *words)
            self.assertLess(read, 2e6)
            self.assertLess(used, memory + 16)
        large, used, read = cost("measure", self.result, "--frame", WANTED, "--json")
        print(f"  one of 1e9 frames: {used - memory:.1f} MiB more than one of 6, {read / 1e6:.1f} MB read")
        self.assertLess(read, 2e7)
        self.assertLess(used, memory + 48)
        one, other = (json.loads(text)["frames"][0] for text in (small, large))
        self.assertEqual((other["frame"], other["step"]), (WANTED, step))
        self.assertFalse(other["contacts"]["recomputed"])
        for key in set(one) - {"frame"}:
            self.assertEqual(one[key], other[key], key)

    def test_nearest(self):
        """Found by bisection: as by looking at all."""
        self.make(steps=97, frames=5, contacts=0)
        with h5py.File(self.result) as f:
            times = f["particles/disks/position/time"][:]
        for time in [-1, 0, 0.002, 0.01, 0.0049, 0.0051, 0.1, 0.1849, 0.1851, 0.1919, 0.1921, 0.194, 5]:
            out, _, _ = cost("measure", self.result, "--time", time, "--json")
            expected = int(numpy.argmin(abs(times - time)))
            self.assertEqual(json.loads(out)["frames"][0]["frame"], expected, time)

    def test_means(self):
        """The page shows ten disks, and reads ten."""
        self.make()
        page, memory, _ = cost("info", self.result)
        self.assertIn("fastest disks", page)
        with h5py.File(self.result, "r+") as f:
            del f.attrs["sealed"]  # a file without a checksum, of which nothing is read but what is asked for
            means = f["summary/disks"]
            fastest = f["summary/fastest"]
            order = numpy.argsort(-abs(means["omega"][:]), kind="stable")[:10]
            for name in fastest:
                numpy.testing.assert_array_equal(fastest[name][:], means[name][:][order], name)
            for name in list(means):
                enlarge(f, f"summary/disks/{name}", DISKS)
            means.attrs["count"] = numpy.int64(DISKS)
        again, used, read = cost("info", self.result)
        self.assertLess(used, memory + 16)
        self.assertLess(read, 2e6)
        cut = [text[text.index("fastest disks"):text.index("energy budget")] for text in (page, again)]
        self.assertEqual(*cut)

    def test_json_of_all(self):
        """Written frame by frame: memory does not grow with their number."""
        self.make(steps=2000, frames=1, contacts=0)
        _, memory, _ = cost("measure", self.result, "--frame", 3, "--json")
        out, used, _ = cost("measure", self.result, "--all", "--json")
        print(f"  all of 2001 frames: {used - memory:.1f} MiB more than one, {len(out) / 1e6:.1f} MB of JSON")
        found = json.loads(out)
        self.assertEqual(found["stored"], 2001)
        self.assertEqual([f["step"] for f in found["frames"]], list(range(2001)))
        self.assertLess(used, memory + 24)
        target = self.folder / "all.json"
        cost("measure", self.result, "--all", "-o", target)
        self.assertEqual(target.read_text(), out)


if __name__ == "__main__":
    if not os.access("/proc/self/io", os.R_OK):
        sys.exit(0)  # nothing can be counted here
    unittest.main()
