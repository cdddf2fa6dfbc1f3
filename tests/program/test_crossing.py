"""Every feature of decks in every way to run (tools/relations/crossing.py): the bits of the plainest way, or said that it is left. What the
decks of the generator never set is listed here with its reason."""
import os
import re
import subprocess
import unittest

from sources import BUILD, ROOT

from relations import crossing

PER_FEATURE = 2 if os.environ.get("CI") == "true" else 1  # decks
# Under sanitizers a deck takes 4 s in all ways: one in so many, other features in the first round than in the second
SPREAD = 16 if os.environ.get("SLIPDISK_BRIEF") == "1" else 1

# Read or written, or only names: nothing of the motion depends on them.
NOT_MOTION = {"deck:title", "deck:sweep", "deck:constants", "phases:name", "materials:name", "limits:open", "limits:unstable_step", "limits:residual"}
# Another way to say what another key says.
SAME_AS = {"deck:steps": "phases", "deck:time": "phases", "phases:time": "steps", "disks:mass": "density", "packings:mass": "density",
           "until:error": "relative", "until:observable": "the first watched disk", "motions:phase": "a wave", "motions:periodic": "a table",
           "motions:length": "pressure"}
# Files beside the deck: test_disk_files, test_files_in_parts, test_box_from_files.
FILES = {"deck:disk_files", "box:file", "box:timestep", "motions:file", "motions:columns"}
# Only speed (skin, tiles of packings), or what the run refuses (max_overlap).
ELSEWHERE = {"deck:skin": "test_neighbours", "deck:max_overlap": "test_ranks", "packings:tiles": "test_tiles", "packings:radii": "sizes list",
             "packings:gap": "test_generators", "packings:spacing": "test_generators"}


def keys_of_the_program():
    """GROUP:KEY of all tables of `slipdisk check --keys`."""
    text = subprocess.run([BUILD / "slipdisk", "check", "--keys"], stdout=subprocess.PIPE, text=True, check=True).stdout
    group, keys = "", set()
    for line in text.splitlines():
        if line.startswith("### "):
            group = line[4:].strip()
        elif line.startswith("|`") and not line.startswith('|`"') and "." not in group:
            keys.add(f"{group}:{line[2:].split('`')[0]}")
    return keys


def keys_of(deck):
    found = {f"deck:{key}" for key in deck}
    for group, value in deck.items():
        for one in value if isinstance(value, list) else [value]:
            if isinstance(one, dict):
                found |= {f"{group}:{key}" for key in one}
    for columns in (row["columns"] for row in deck.get("disk_rows", ())):
        found |= {f"disks:{name}" for name in columns}
    return found


class Crossing(unittest.TestCase):
    def test_every_way_gives_the_bits_of_the_plainest_or_says_that_it_does_not_take_the_deck(self):
        count = PER_FEATURE * len(crossing.FEATURES)
        cells, wrong = crossing.product(range(0, (2 if SPREAD > 1 else 1) * count, SPREAD))
        print(crossing.table(cells))
        self.assertEqual(wrong, [])
        if SPREAD > 1:
            return
        names = list(dict.fromkeys(way for _, way in cells))
        for feature in crossing.FEATURES:
            with self.subTest(feature):
                self.assertGreater(cells[feature, "plain"]["same"], 0, "no deck with it runs")
            for way in names:
                tried = cells[feature, way]
                with self.subTest(feature=feature, way=way):
                    self.assertGreater(tried["same"] + tried["left"], 0, "no deck with it was tried in this way")
                    self.assertEqual(tried["said nothing"], 0)
        for way in names:  # none is left throughout
            self.assertGreater(sum(cells[feature, way]["same"] for feature in crossing.FEATURES), 0, way)

    def test_the_generator_sets_every_key_that_can_change_the_motion(self):
        seen = set()
        for seed in range(8 * len(crossing.FEATURES)):
            seen |= keys_of(crossing.make(seed).deck)
        known = keys_of_the_program()
        excused = NOT_MOTION | FILES | set(SAME_AS) | set(ELSEWHERE)
        groups = {"sweep", "disk_files", "material_pairs"}
        self.assertEqual(sorted(k for k in known - seen - excused if k.split(":")[0] not in groups), [])
        self.assertEqual(sorted((NOT_MOTION | FILES | set(SAME_AS) | set(ELSEWHERE)) - known), [], "no longer keys of the program")

    def test_the_generator_sets_every_quantity_that_a_program_can_set(self):
        text = (ROOT / "src/run/simulation_steer.c").read_text()
        seen = {call.split()[2] for seed in range(12 * len(crossing.FEATURES)) for call in crossing.make(seed).calls if " set " in call}
        laws = re.findall(r'\{"(\w+)", NUMBER\(', (ROOT / "src/model/laws.c").read_text())
        self.assertEqual(seen, {*re.findall(r'\{"([\w.]+)", STEER_', text), *(f"law.{key}" for key in laws)})

    def test_the_same_number_gives_the_same_deck(self):
        self.assertEqual(crossing.make(17).deck, crossing.make(17).deck)
        self.assertNotEqual(crossing.make(17).deck, crossing.make(18).deck)


if __name__ == "__main__":
    unittest.main()
