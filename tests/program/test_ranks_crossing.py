"""Decks of all features (tools/relations) over the ranks of an MPI job: results of one process in every bit, or a deck that ranks do not take and
say so. More ranks and features than here meet as threads of one process in test_crossing."""
import unittest

from sources import ROOT  # noqa: F401  finds the tools
from ranks_common import run
from results_common import Folder, assert_same

from relations import added, crossing, watch

ALONE = "without mpirun"
ROWS = {"series": 10, "frames": 50, "contacts": 60}


def deck_of(seed):
    """A deck with rows of results, of more than two disks."""
    made = crossing.make(seed)
    deck = made.deck
    if made.has["outputs"] == "none":
        deck["output"] = ROWS
        added.measure_sums(deck)
    return made.has, watch.slipdisk.deck_text(deck)


class Crossing(Folder):
    def same(self, seed, text):
        """Whether ranks take the deck."""
        deck, results = self.folder / f"{seed}.cfg", [self.folder / f"{seed}-{ranks}.h5" for ranks in (0, 3)]
        deck.write_text(text)
        status, _, err = run(3, "run", deck, "--quiet", "-o", results[1])
        if status == 2 and ALONE in err:
            return False
        alone = run(0, "run", deck, "--quiet", "--threads", 1, "-o", results[0])
        self.assertEqual(status, alone[0], err + alone[2])
        if status in (0, 5):
            assert_same(self, *results)
        return status in (0, 5)

    def test_results_of_ranks_are_those_of_one_process(self):
        taken = set()
        for seed in range(len(crossing.FEATURES)):
            has, text = deck_of(seed)
            if text.count("radius =") < 3 or has["bodies"] == "clumps" or has["measure"] in ("single disks", "watched contacts"):
                continue
            with self.subTest(seed=seed, has=has):
                if self.same(seed, text):
                    taken |= set(has.items())
        self.assertGreater(len(taken), 0.75 * len(crossing.FEATURES), sorted(set(crossing.FEATURES) - taken))


if __name__ == "__main__":
    unittest.main()
