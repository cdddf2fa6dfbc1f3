"""The size that `slipdisk check` foretells is that of the result, within a fifth; so are the numbers of rows."""
import re
import unittest

import h5py

from results_common import ROOT, Folder

DECKS = {
    "series": ("three_disk/random.cfg", {
        "phases.settle.steps": 10000, "phases.measure.steps": 100000, "phases.measure.series": 20}),
    "frames of three disks": ("three_disk/random.cfg", {
        "phases.settle.steps": 10000, "phases.measure.steps": 100000, "phases.measure.frames": 10, "phases.measure.contacts": 30}),
    "frames of a packing": ("packing/shake_low.cfg", {
        "motions.shake.acceleration": 2, "phases.rest.time": 1.23, "phases.thermalise.time": 0.001, "phases.measure.time": 0.3001,
        "phases.measure.frames": 10, "phases.measure.contacts": 50}),
    "hardly anything": ("walls/drum.cfg", {"phases[0].steps": 1000}),
}
UNITS = {"kB": 1e3, "MB": 1e6, "GB": 1e9}


class Size(Folder):
    def foretold(self, *words):
        said, _ = self.run_ok("check", *words, "--brief", "--no-probe")
        found = re.search(r"^# result +(at most )?(\d+) rows of the series, (\d+) frames, (\d+) contact tables: "
                          r"about ([\d.]+) (.B)", said, re.M)
        self.assertIsNotNone(found, said)
        return bool(found[1]), [int(n) for n in found.groups()[1:4]], float(found[5]) * UNITS[found[6]]

    def test_sizes(self):
        for name, (deck, keys) in DECKS.items():
            with self.subTest(name):
                words = [ROOT / "inputs" / deck]
                for key, value in keys.items():
                    words += ["-D", f"{key}={value}"]
                may_end, rows, size = self.foretold(*words)
                self.run_ok("run", *words, "--quiet", "--force", "-o", self.result)
                have = self.result.stat().st_size
                self.assertLess(abs(size / have - 1), 0.2, f"{size} and {have}")
                with h5py.File(self.result) as file:
                    found = [len(file[path]) for path in
                             ("observables/residual/step", "particles/disks/position/step", "contacts/step")]
                for most, have in zip(rows, found):
                    self.assertTrue(have <= most if may_end else have == most, f"{rows} and {found}")

    def test_a_phase_may_end_early(self):
        self.assertTrue(self.foretold(ROOT / "inputs/packing/deposit.cfg")[0])
        self.assertFalse(self.foretold(ROOT / "inputs/three_disk/sync.cfg")[0])


if __name__ == "__main__":
    unittest.main()
