"""Results and `slipdisk export --to h5md3d` keep every rule of the specification of H5MD 1.1
(https://www.nongnu.org/h5md/releases/h5md-1.1.0.html); and the checker notices when one is broken.
"""
import os
import shutil
import sys
import unittest

import h5py
import numpy

from export_common import Exports
from results_common import ROOT, run

VECTORS = {"position", "image", "velocity", "force"}
SCALARS = {"mass", "species", "id", "charge"}
WHOLE = {"species", "id"}


class Checker:
    """Mistakes of a file, a line each."""

    def __init__(self, path):
        self.mistakes = []
        with h5py.File(path, "r") as self.file:
            self.metadata()
            for name, group in self.file.get("particles", {}).items():
                self.particles(f"/particles/{name}", group)
            if "observables" in self.file:
                self.observables("/observables", self.file["observables"])
            if "connectivity" in self.file:
                self.bad("/connectivity", "is not known to this checker")

    def bad(self, where, what):
        self.mistakes.append(f"{where}: {what}")

    def need(self, good, where, what):
        if not good:
            self.bad(where, what)
        return good

    # --- attributes ---

    def text(self, item, name):
        """A fixed-length string in a scalar dataspace."""
        where = f"{item.name}@{name}"
        if not self.need(name in item.attrs, where, "is missing"):
            return
        attr = item.attrs.get_id(name)
        self.need(attr.shape == () and attr.get_space().get_simple_extent_type() == h5py.h5s.SCALAR, where,
                  "is no scalar")
        kind = attr.get_type()
        self.need(kind.get_class() == h5py.h5t.STRING and not kind.is_variable_str(), where,
                  "is no string of fixed length")

    def whole(self, item, name, shape):
        where = f"{item.name}@{name}"
        if not self.need(name in item.attrs, where, "is missing"):
            return None
        attr = item.attrs.get_id(name)
        self.need(attr.get_type().get_class() == h5py.h5t.INTEGER, where, "is no integer")
        self.need(attr.shape == shape, where, f"has the shape {attr.shape}, not {shape}")
        return item.attrs[name]

    def metadata(self):
        if not self.need(isinstance(self.file.get("h5md"), h5py.Group), "/h5md", "is no group"):
            return
        head = self.file["h5md"]
        version = self.whole(head, "version", (2,))
        self.need(version is not None and list(version) == [1, 1], "/h5md@version", "is not (1, 1)")
        for name, words in ("author", ["name"]), ("creator", ["name", "version"]):
            if self.need(isinstance(head.get(name), h5py.Group), f"/h5md/{name}", "is no group"):
                for word in words:
                    self.text(head[name], word)
        if "email" in head["author"].attrs if "author" in head else False:
            self.text(head["author"], "email")
            address = head["author"].attrs["email"]
            self.need(str(address).count("@") == 1, "/h5md/author@email", "is no address")
        for name, module in head.get("modules", {}).items():
            self.need(isinstance(module, h5py.Group), f"/h5md/modules/{name}", "is no group")
            self.whole(module, "version", (2,))

    # --- elements ---

    def clock(self, where, group, name, rows):
        """Step or time: a value per row, or a constant increment."""
        data = group[name]
        kinds = "iu" if name == "step" else "iuf"
        self.need(data.dtype.kind in kinds, f"{where}/{name}", "is of a wrong type")
        if data.shape == ():
            if "offset" in data.attrs:
                self.need(data.attrs.get_id("offset").shape == (), f"{where}/{name}@offset", "is no scalar")
            return
        if self.need(data.shape == (rows,), f"{where}/{name}", f"has the shape {data.shape}, not ({rows},)"):
            self.need((numpy.diff(data[:]) > 0).all(), f"{where}/{name}", "does not increase")

    def is_element(self, item):
        return isinstance(item, h5py.Dataset) or "value" in item

    def element(self, where, item):
        """Shape and type of the data of a moment."""
        if isinstance(item, h5py.Dataset):
            return item.shape, item.dtype
        value = item["value"]
        self.need(isinstance(value, h5py.Dataset) and value.shape != (), f"{where}/value", "has no rows")
        if self.need("step" in item, where, "has no step"):
            self.clock(where, item, "step", value.shape[0])
        if "time" in item:
            self.clock(where, item, "time", value.shape[0])
        if "time" in item and "step" in item:
            scalar = [item[name].shape == () for name in ("step", "time")]
            self.need(scalar[0] == scalar[1], where, "step and time are stored in different ways")
        return value.shape[1:], value.dtype

    def linked(self, where, one, other, names=("step", "time")):
        """Both time-dependent elements share these datasets by hard links."""
        if isinstance(one, h5py.Dataset) or isinstance(other, h5py.Dataset):
            return
        for name in names:
            self.need((name in one) == (name in other) and (name not in one or one[name] == other[name]),
                      f"{where}/{name}", "is no hard link to that of the position")

    # --- particles ---

    def particles(self, where, group):
        if not self.need(isinstance(group.get("box"), h5py.Group), f"{where}/box", "is no group"):
            return
        dimension = self.box(f"{where}/box", group)
        numbers = set()
        for name, item in group.items():
            if name == "box" or not self.is_element(item) or (isinstance(item, h5py.Dataset) and item.dtype.kind in "SO"):
                continue
            shape, kind = self.element(f"{where}/{name}", item)
            if name in VECTORS:
                self.need(shape[1:] == (dimension,), f"{where}/{name}", f"has no vectors of {dimension} numbers")
                self.need(kind.kind in "iuf", f"{where}/{name}", "holds no numbers")
            if name in SCALARS:
                self.need(len(shape) == 1, f"{where}/{name}", "has no number per particle")
            if name in WHOLE:
                self.need(kind.kind in "iu", f"{where}/{name}", "holds no integers")
            if name == "mass":
                self.need(kind.kind == "f", f"{where}/{name}", "is no float")
            numbers.add(shape[0] if shape else None)
        self.need(len(numbers) <= 1, where, f"elements of different numbers of particles: {sorted(map(str, numbers))}")
        if "id" in group and isinstance(group["id"], h5py.Dataset):
            self.need(len(set(group["id"][:])) == group["id"].size, f"{where}/id", "is not unique")
        if "image" in group and self.need("position" in group, f"{where}/image", "stands without position"):
            self.linked(f"{where}/image", group["image"], group["position"])
        if "position" in group:
            edges = group["box"].get("edges")
            if isinstance(edges, h5py.Group):
                self.linked(f"{where}/box/edges", edges, group["position"])

    def box(self, where, group):
        box = group["box"]
        dimension = self.whole(box, "dimension", ())
        boundary = []
        if self.need("boundary" in box.attrs, f"{where}@boundary", "is missing"):
            attr = box.attrs.get_id("boundary")
            kind = attr.get_type()
            self.need(kind.get_class() == h5py.h5t.STRING and not kind.is_variable_str(), f"{where}@boundary",
                      "holds no strings of fixed length")
            self.need(attr.shape == (dimension,), f"{where}@boundary", f"has not {dimension} words")
            boundary = [b.decode() if isinstance(b, bytes) else b for b in numpy.atleast_1d(box.attrs["boundary"])]
            self.need(set(boundary) <= {"periodic", "none"}, f"{where}@boundary", f"says {boundary}")
        if "edges" in box:
            shape, kind = self.element(f"{where}/edges", box["edges"])
            self.need(shape in ((dimension,), (dimension, dimension)), f"{where}/edges", f"has the shape {shape}")
            self.need(kind.kind in "iuf", f"{where}/edges", "holds no numbers")
        else:
            self.need(set(boundary) == {"none"}, f"{where}/edges", "is missing in a periodic box")
        return dimension

    # --- observables ---

    def observables(self, where, group):
        for name, item in group.items():
            if self.is_element(item):
                self.element(f"{where}/{name}", item)
            else:
                self.observables(f"{where}/{name}", item)


def put_attr(name, value, dtype=None):
    return lambda item: item.attrs.create(name, value, dtype=dtype)


def remake(name, values, **more):
    def change(group):
        del group[name]
        group.create_dataset(name, data=values, **more)
    return change


# Where, what is done there, and a word of the complaint.
BREAKS = [
    ("h5md", lambda g: g.attrs.__delitem__("version"), "version: is missing"),
    ("h5md", put_attr("version", [1.0, 1.0]), "no integer"),
    ("h5md", put_attr("version", [1, 0]), "is not (1, 1)"),
    ("h5md/author", put_attr("name", "variable", h5py.string_dtype()), "no string of fixed length"),
    ("h5md/creator", lambda g: g.attrs.__delitem__("version"), "is missing"),
    ("particles/disks/box", put_attr("dimension", [2]), "has the shape (1,)"),
    ("particles/disks/box", put_attr("dimension", 3), "has not 3 words"),
    ("particles/disks/box", put_attr("boundary", numpy.array([b"none", b"open"])), "says"),
    ("particles/disks/box/edges", remake("step", numpy.arange(6)), "hard link"),
    ("particles/disks/position", remake("step", numpy.arange(6.0)), "wrong type"),
    ("particles/disks/position", remake("step", numpy.arange(5)), "has the shape (5,)"),
    ("particles/disks/position", remake("time", numpy.array([0, 2, 1, 3, 4, 5.0])), "does not increase"),
    ("particles/disks/image", remake("time", numpy.arange(6.0)), "hard link"),
    ("particles/disks", remake("mass", numpy.ones(7)), "different numbers"),
    ("particles/disks", remake("mass", numpy.ones(40, int)), "no float"),
    ("particles/disks", remake("id", numpy.zeros(40, int)), "not unique"),
    ("particles/disks/velocity", remake("value", numpy.zeros((6, 40, 3))), "vectors of 2"),
    ("particles/disks", lambda g: g.__delitem__("box"), "is no group"),
    ("particles/disks/box", lambda g: g.__delitem__("edges"), "missing in a periodic box"),
    ("observables/contacts", lambda g: g.__delitem__("step"), "has no step"),
]


class H5md(Exports):
    def check(self, path):
        self.assertEqual(Checker(path).mistakes, [], path)

    def test_results(self):
        for name in "rich", "shrinking", "open":
            self.check(self.made / f"{name}.h5")

    def test_shipped_decks(self):
        short = "-D", "phases[*].steps=200", "-D", "phases[*].frames=50", "-D", "phases[*].contacts=100"
        for deck in "three_disk/random", "paper/step", "packing/servo", "walls/drum", "packing/jam":
            out = self.folder / (deck.replace("/", "-") + ".h5")
            status, _, err = run("run", ROOT / "inputs" / f"{deck}.cfg", "--quiet", "-o", out, *short)
            self.assertIn(status, (0, 5), err)
            self.check(out)

    def test_exports(self):
        for name in "rich", "shrinking", "open":
            self.check(self.export(name, "h5md3d", out=f"{name}.h5md"))
            self.check(self.export(name, "h5md3d", "--frames", "-1", out=f"{name}-last.h5md"))

    def test_the_checker_notices(self):
        for where, change, expected in BREAKS:
            path = self.folder / "broken.h5"
            shutil.copy(self.made / "shrinking.h5", path)
            with h5py.File(path, "r+") as file:
                change(file[where])
            found = Checker(path).mistakes
            self.assertTrue(any(expected in line for line in found), f"{where}: {expected}: {found}")

    def author(self, **environment):
        out = self.folder / "author.h5"
        status, _, err = run("run", self.made / "open.cfg", "--quiet", "--force", "-o", out,
                             env={**os.environ, **environment})
        self.assertEqual(status, 0, err)
        with h5py.File(out) as file:
            name = file["h5md/author"].attrs["name"]
            return name.decode() if isinstance(name, bytes) else name

    def test_author(self):
        self.assertEqual(self.author(SLIPDISK_AUTHOR="Ada Lovelace"), "Ada Lovelace")
        self.assertEqual(self.author(SLIPDISK_AUTHOR="Ada\nLovelace"), "Ada")
        self.assertNotIn(self.author(SLIPDISK_AUTHOR=""), ("root", ""))


if __name__ == "__main__":
    sys.exit(unittest.main(verbosity=1))
