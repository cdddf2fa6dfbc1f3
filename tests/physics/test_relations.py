"""Relations that must hold whatever the deck (tools/relations), on decks at random: mirrors, turns, shifts, other frames and
orders, restarts, shapes of a wall, balance of forces. A small sample of what `tools/soak.sh relations` tries."""
import unittest

import package  # noqa: F401

from relations import decks, maps, table, watch

DECKS = 16      # of a relation that is tried in this process, a quarter of it where the program is run
APART = 10_000  # numbers of decks of one relation and the next


class Relations(unittest.TestCase):
    seen = set()  # pairs of features

    def hold(self, number, name):
        """Prints the command that repeats what fails."""
        outcomes = []
        for seed in range(number * APART, number * APART + DECKS // table.RELATIONS[name].cost):
            outcome, said, made = table.attempt(name, seed)
            self.assertNotEqual(outcome, "wrong", f"{table.again(name, seed)}\n{said}\n{made and made.has}")
            outcomes.append(outcome)
            if made and outcome == "held":
                Relations.seen |= made.pairs()
        self.assertGreaterEqual(outcomes.count("held") * 2, len(outcomes), "hardly any deck suits")


def add(number, name):
    def test(self):
        self.hold(number, name)
    test.__doc__ = table.RELATIONS[name].what()
    setattr(Relations, f"test_{name}", test)


for row, relation in enumerate(table.usual()):
    add(row, relation)


class Generator(unittest.TestCase):
    def test_all_pairs(self):
        """A thousand decks have nearly all pairs of features that suit one another, and every feature."""
        pairs = set().union(*(decks.make(seed).pairs() for seed in range(1000)))
        self.assertGreater(len(pairs), 0.97 * decks.count_pairs())
        self.assertEqual({row for pair in pairs for row in pair}, {(d, name) for d in decks.ORDER for name in decks.FEATURES[d]})

    def test_the_same_number_is_the_same_deck(self):
        self.assertEqual(decks.make(5).deck, decks.make(5).deck)
        self.assertNotEqual(decks.make(5).deck, decks.make(6).deck)

    def test_faults_are_found(self):
        """A deck that is off by 1e-6 in one number does not pass for the same."""
        deck = decks.make(3, {"box": ("open",), "walls": ("line",), "motion": ("none",)}).deck
        other = maps.mapped(maps.MIRROR, deck)
        for k, key in ((0, "x"), (4, "omega"), (7, "vy")):
            changed = maps.mapped(maps.MIRROR, other)
            changed["disks"][k][key] *= 1 + 1e-6
            with self.assertRaises(watch.Wrong):
                watch.same(watch.follow(deck, 60, 30), watch.follow(changed, 60, 30), 1e-8)
        watch.same(watch.follow(deck, 60, 30), watch.follow(maps.mapped(maps.MIRROR, other), 60, 30), 1e-8)


if __name__ == "__main__":
    unittest.main()
