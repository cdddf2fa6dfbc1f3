"""Checksums of files: those that other programs compute (XXH3, xxhsum -H3), and those of versions up to 0.6."""
import pathlib
import re
import subprocess
import struct
import unittest
from shutil import which

import h5py
import numpy

from results_common import assert_same, changed, deck_arguments, run
from sweep_common import SweepTest, three_disks
from test_results import Started

XXHSUM = which("xxhsum")
SEAL = struct.Struct("<8sQQ")
SHORT = deck_arguments(settle=1000, measure=20000)


def xxhsum(data):
    said = subprocess.run([XXHSUM, "-H3", "-"], input=data, capture_output=True, check=True).stdout.decode()
    return re.search(r"\b[0-9a-f]{16}\b", said).group()


def words_hash(data):
    """hash_words of src/base/hash.c, the checksum of versions up to 0.6."""
    prime, mask, value = 1099511628211, (1 << 64) - 1, 14695981039346656037
    whole = len(data) // 8
    for (word,) in struct.iter_unpack("<Q", data[:8 * whole]):
        value = (value ^ word) * prime & mask
        value ^= value >> 32
    for byte in data[8 * whole:]:
        value = (value ^ byte) * prime & mask
    return value


def as_before(path):
    """Gives a file the seal of versions up to 0.6; returns its new checksum."""
    data = path.read_bytes()
    body, (mark, size, _) = data[:-SEAL.size], SEAL.unpack(data[-SEAL.size:])
    assert (mark, size) == (b"slipxxh3", len(body)), path
    value = words_hash(body)
    path.write_bytes(body + SEAL.pack(b"slipseal", size, value))
    return value


def signed(value):
    return value - (value >> 63 << 64)


def said_sums(text):
    return {pathlib.Path(name).name: digits for name, digits in re.findall(r"^(.*): sound, .* MB, XXH3 ([0-9a-f]{16})$", text, re.M)}


class Results(Started):
    def setUp(self):
        super().setUp()
        self.run_ok("run", *SHORT, "-o", self.result)

    def test_xxhsum(self):
        """`verify` prints what xxhsum prints of the file; the seal is what it prints of all before it."""
        out, _ = self.run_ok("verify", self.result)
        data = self.result.read_bytes()
        self.assertEqual(said_sums(out), {self.result.name: xxhsum(data)})
        self.assertEqual(data[-8:].hex(), xxhsum(data[:-SEAL.size]))

    def test_of_before(self):
        """A seal of before is compared too, and `verify` prints the sum that xxhsum prints."""
        as_before(self.result)
        out, _ = self.run_ok("verify", self.result)
        self.assertEqual(said_sums(out), {self.result.name: xxhsum(self.result.read_bytes())})
        self.run_ok("info", self.result)
        data = bytearray(self.result.read_bytes())
        for at in len(data) // 2, len(data) - 3:
            data[at] ^= 4
            self.result.write_bytes(data)
            status, _, err = run("verify", self.result)
            self.assertEqual(status, 4)
            self.assertIn("its checksum does not fit", err)
            data[at] ^= 4

    def test_seal_anew(self):
        """A file of before that is changed on purpose gets a checksum of today."""
        as_before(self.result)
        with h5py.File(self.result, "r+") as file:
            file["mine"] = [1.0, 2.0]
        self.run_ok("verify", "--seal", self.result)
        self.assertIn(b"slipxxh3", self.result.read_bytes()[-SEAL.size:])
        with h5py.File(self.result) as file:
            self.assertEqual(list(file["mine"]), [1.0, 2.0])


    def test_unfinished_run_of_before(self):
        """Parts, checkpoint and their chain of checksums as a version up to 0.6 left them: the run goes on."""
        words = deck_arguments(checkpoint=0.001)
        self.result.unlink()
        self.stop(self.started(*words))
        undisturbed = self.folder / "u.h5"
        sums = [0]
        for part in sorted(self.parts.glob("part-*.h5")):
            with changed(part) as file:
                file.attrs["after"] = signed(sums[-1])
            sums.append(as_before(part))
        self.assertGreater(len(sums), 1)
        for checkpoint in self.parts.glob("checkpoint-*.h5"):
            with changed(checkpoint) as file:
                file["checkpoint"].attrs["last_part"] = signed(sums[file["checkpoint"].attrs["parts"]])
            as_before(checkpoint)
        self.run_ok("verify", self.parts)
        self.run_ok("run", *words, "-o", self.result)
        self.run_ok("run", *words, "-o", undisturbed)
        assert_same(self, self.result, undisturbed)


class Tables(SweepTest):
    def test_tables(self):
        """The checksums in table.h5 are those of xxhsum; a list of before, with others, is compared too."""
        self.sweep(self.deck(three_disks('{ parameters = ( { path = "materials[0].mu"; values = (0.1, 0.2); } ); }', steps=2000)))
        with h5py.File(self.out / "table.h5") as file:
            lines = file["parameters/files"][()].decode().splitlines()
        tables = {name: (self.out / name).read_bytes() for name in ("table.csv", "means.csv")}
        self.assertEqual(lines[:2], [f"{name} XXH3_{xxhsum(data)}" for name, data in tables.items()])
        status, out, err = run("verify", self.out)
        self.assertEqual(status, 0, err)
        self.assertEqual({name: said_sums(out)[name] for name in tables}, {name: xxhsum(data) for name, data in tables.items()})
        with changed(self.out / "table.h5") as file:
            del file["parameters/files"]
            file["parameters/files"] = numpy.bytes_("".join(f"{line}\n" for line in (
                *(f"{name} {words_hash(data):016x}" for name, data in tables.items()), *lines[2:])))
        status, _, err = run("verify", self.out)
        self.assertEqual(status, 0, err)
        (self.out / "means.csv").write_bytes(tables["means.csv"].replace(b"1", b"2", 1))
        status, _, err = run("verify", self.out)
        self.assertEqual(status, 4)
        self.assertIn("is not the table that", err)


if __name__ == "__main__":
    unittest.main()
