"""Names in result files that others have made: whatever they are, readers show them and do nothing else with them."""
import json
import os
import re
import shutil
import unittest

import h5py

from results_common import Folder, changed, run

DECK = """dt = 1e-4; title = "tttt"; gravity = { g = 10; };
materials = ( { name = "m"; k_n = 1e4; gamma_n = 1; k_t = 1e4; mu = 0.3; } );
disks = ( { name = "aaaa"; group = "gggg"; x = 0; y = 0.1; radius = 0.1; mass = 1; },
          { name = "bbbb"; group = "gggg"; x = 0.199; y = 0.1; radius = 0.1; mass = 1; } );
walls = ( { name = "wwww"; type = "line"; points = ((-2, 0), (2, 0)); } );
measure = { rotation = ("aaaa"); sliding = ( { disk = "aaaa"; partners = ("wwww", "bbbb"); } ); walls = true; groups = true;
            contacts = ("bbbb"); };
phases = ( { name = "pppp"; steps = 400; series = 20; frames = 100; contacts = 100; measure = true; } );
"""
USUAL = b"aaaa", b"bbbb", b"wwww", b"gggg", b"pppp", b"tttt"
TEXTS = ("observables/groups", "observables/walls", "parameters/deck_bodies", "parameters/deck_full", "parameters/deck_text",
         "particles/disks/name", "particles/walls/name", "summary/rotation/name", "summary/slide/name", "summary/phase/name")
NAMES = (("</script><script>alert(1)</script>", "<img src=x onerror=alert(1)>", "$\\frac{$", "$(touch pwned)", "`touch pwned`", "a$b"),
         ("\x1b[31mred\x07", "a\rb", "%s%n%d", "../../evil", "&lt;b&gt;", "\u202egnp.exe"),
         ("=cmd|x", '"quoted", comma', "x" * 70000, "'; DROP", "  ", "_hidden"),
         ("", "@SUM(1)", "NaN", "\u00ff", "0", "disk 1"))
FORMATS = "csv", "lammps-dump", "lammps-data", "extxyz", "vtk", "h5md3d"
PICTURES = "rotation", "configurations", "contact", "walls"


class HostileNames(Folder):
    def setUp(self):
        super().setUp()
        deck = self.folder / "d.cfg"
        deck.write_text(DECK)
        status, _, err = run("run", deck, "-o", self.folder / "usual.h5", "--quiet")
        self.assertIn(status, (0, 5), err)

    def named(self, names):
        """The result with these names in the places of the usual ones, sealed."""
        shutil.copy(self.folder / "usual.h5", self.result)
        with changed(self.result) as file:
            for path in TEXTS:
                text, attributes = file[path][()], dict(file[path].attrs)
                for usual, name in zip(USUAL, names):
                    text = text.replace(usual, name.encode())
                del file[path]
                file.create_dataset(path, data=text, dtype=h5py.string_dtype("utf-8"))
                file[path].attrs.update(attributes)

    def shown(self, *words):
        status, out, err = run(*words)
        self.assertEqual(status, 0, (words, err[-400:]))
        for text in out, err:
            self.assertIsNone(re.search("[\x00-\x08\x0b-\x1f\x7f]", text), (words, text[-400:]))
        return out

    def test_every_reader(self):
        os.chdir(self.folder)
        for n, names in enumerate(NAMES):
            with self.subTest(names=[name[:30] for name in names]):
                self.named(names)
                written = self.folder / f"out{n}"
                written.mkdir()
                self.shown("info", self.result)
                json.loads(self.shown("info", "--json", self.result))
                self.shown("measure", self.result)
                page = written / "page.html"
                self.shown("view", self.result, "-o", page)
                for code in "<script>alert", "<img src=x":
                    self.assertNotIn(code, page.read_text())
                for kind in FORMATS:
                    self.shown("export", self.result, "--to", kind, "-o", written / kind)
                self.shown("plot", self.result, *(word for kind in PICTURES for word in ("-k", kind)), "-o", written / "p.png")
                for path in written.rglob("*"):
                    if path.is_file() and path.suffix not in (".png", ".vtp", ".html") and path.name != "h5md3d":
                        self.assertIsNone(re.search(b"[\x07\x1b]", path.read_bytes()), path)
        self.assertFalse((self.folder / "pwned").exists() or (self.folder.parent / "evil").exists())


if __name__ == "__main__":
    unittest.main(verbosity=2)
