"""The final states of short runs are those of tests/golden.csv, bit by bit; and what the table's three hashes notice."""
import dataclasses
import shutil
import sys
import unittest

import h5py
import numpy

from results_common import PROGRAM, ROOT
from sweep_common import temporary_folder

sys.path.insert(0, str(ROOT / "tools"))
sys.dont_write_bytecode = True

from soak import determinism, golden  # noqa: E402


class Golden(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = temporary_folder()
        cls.addClassCleanup(shutil.rmtree, cls.folder)

    def result(self, deck):
        path = self.folder / (deck.name if deck.sweep else f"{deck.name}.h5")
        if not path.exists():
            golden.finish(golden.command(PROGRAM, deck, path))
        return path

    def test_the_table(self):
        kept = golden.read()
        self.assertEqual([deck.name for deck in golden.decks()], list(kept))
        for deck in golden.decks():
            with self.subTest(deck=deck.name):
                self.assertEqual(golden.against(deck.name, golden.bits(self.result(deck))), "")

    def test_the_decks_are_lively(self):
        """Contacts slide and turn; in packings they open and close, too."""
        for deck in golden.decks():
            with self.subTest(deck=deck.name), h5py.File(golden.results_of(self.result(deck))[0]) as file:
                state = file["state"]
                self.assertGreater(state["loss_friction"][()].sum(), 0)
                self.assertGreater(state.attrs["n_contacts"], 1)
                if deck.radius:
                    self.assertGreater(state["past_friction"][()].sum(), 0)  # of contacts that have ended
                    self.assertGreater(abs(state["theta"][()]).max(), 0.01)

    def test_what_the_hashes_notice(self):
        deck = next(d for d in golden.decks() if d.name == "compress")
        original, other = self.result(deck), self.folder / "other.h5"
        with h5py.File(original) as file:
            trajectory = golden.trajectory_hash(file["state"])
        for column, moves in ("theta", True), ("contact_lambda_ref", True), ("image_x", True), ("loss_viscous", False):
            with self.subTest(column=column):
                shutil.copy(original, other)
                with h5py.File(other, "r+") as file:
                    values = file["state"][column]
                    # the smallest change that there is
                    last = values[-1]
                    values[-1] = last + 1 if values.dtype.kind == "i" else numpy.nextafter(last, numpy.inf)
                    self.assertEqual(golden.trajectory_hash(file["state"]) != trajectory, moves)
                self.assertEqual(golden.difference(original, other), column)

    def test_means_of_disks_are_results(self):
        deck = next(d for d in golden.decks() if d.name == "shake")
        original, other = self.result(deck), self.folder / "means.h5"
        shutil.copy(original, other)
        for name in "disks/force", "fastest/omega":
            before = golden.results_hash(other)
            with h5py.File(other, "r+") as file:
                values = file["summary"][name]
                values[0] = numpy.nextafter(values[0], numpy.inf)
            self.assertNotEqual(golden.results_hash(other), before)
        kept = golden.bits(original)
        self.assertEqual(golden.bits(other), dataclasses.replace(kept, results=golden.results_hash(other)))
        self.assertIn("summary/disks/force", golden.difference(original, other))

    def test_slots_and_further_columns_are_of_no_account(self):
        deck = next(d for d in golden.decks() if d.name == "compress")
        original, other = self.result(deck), self.folder / "slots.h5"
        shutil.copy(original, other)
        shuffle = numpy.random.default_rng(1).permutation
        with h5py.File(original) as file, h5py.File(other, "r+") as copy:
            state, bodies, contacts = copy["state"], len(file["state/id"]), file["state"].attrs["n_contacts"]
            by_body, by_contact = shuffle(bodies), shuffle(int(contacts))
            for name in (*golden.BODIES, "id"):
                state[name][...] = file["state"][name][()][by_body]
            for name in state:
                if name.startswith("contact_") and len(file["state"][name]):
                    state[name][...] = file["state"][name][()][by_contact]
            state["another"] = numpy.arange(3.0)
            self.assertEqual(golden.trajectory_hash(state), golden.trajectory_hash(file["state"]))

    def test_what_is_said(self):
        deck = golden.decks()[0]
        kept = golden.bits(self.result(deck))
        table = self.folder / "table.csv"
        none = "0" * 16
        for change, said in ({"state": none}, "state, but not the trajectory"), ({"trajectory": none}, "state and trajectory"):
            golden.write({deck.name: golden.Bits(**{**vars(kept), **change})}, table)
            found = golden.against(deck.name, kept, table)
            self.assertIn(said, found)
            self.assertIn(none, found)
            # a run that differs from the table, and runs that differ from one another
            self.assertIn("agree with one another", determinism.note_of_table([found], 0))
            self.assertNotIn("agree with one another", determinism.note_of_table([found], 1))
        golden.write({deck.name: kept}, table)
        self.assertEqual(golden.against(deck.name, kept, table), "")
        self.assertIn("is not in", golden.against("another", kept, table))


if __name__ == "__main__":
    unittest.main()
