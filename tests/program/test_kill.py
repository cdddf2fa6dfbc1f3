"""kill -9 at random moments, again and again: the result is that of a run that was left alone."""
import unittest

from results_common import SELDOM, Folder, assert_same, brief, deck_arguments, steps_for


class Kill(Folder):
    def test_while_running(self):
        words = deck_arguments(measure=steps_for(2), series=10000, frames=10000, checkpoint=0.02)
        whole = self.folder / "whole.h5"
        self.run_ok("run", *words, *SELDOM, "-o", whole)
        for seed in range(brief(3, 1)):
            kills = self.kill_until_done(words, 0.5, seed)
            self.assertGreater(kills, 0)
            assert_same(self, self.result, whole)
            self.assertEqual(sorted(p.name for p in self.folder.iterdir()), ["r.h5", "whole.h5"])
            self.result.unlink()

    def test_while_merging(self):
        words = deck_arguments(measure=200000, series=2, frames=2, checkpoint=0.2)
        whole = self.folder / "whole.h5"
        self.run_ok("run", *words, "-o", whole)
        cut = self.kill_while_merging(words, 6)
        self.assertGreater(cut, 0, "no merge was cut short")
        self.run_ok("resume", self.result)
        assert_same(self, self.result, whole)
        self.assertEqual(sorted(p.name for p in self.folder.iterdir()), ["r.h5", "whole.h5"])


if __name__ == "__main__":
    unittest.main()
