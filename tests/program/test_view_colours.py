"""Colour bars of the pages: the ends of each palette stand out from every ground of its theme (contrast 3 or more, as WCAG has it for
graphics); magnitudes get lighter all the way, so that they can be told without hues."""
import os
import pathlib
import re
import unittest

ROOT = pathlib.Path(os.environ.get("SLIPDISK_SOURCE_DIR", pathlib.Path(__file__).resolve().parents[2]))
PAGE = ROOT / "src/app/view/page"
LEAST = 3


def luminance(hexadecimal):
    parts = [int(hexadecimal[k:k + 2], 16) / 255 for k in (0, 2, 4)]
    red, green, blue = (part / 12.92 if part <= 0.04045 else ((part + 0.055) / 1.055) ** 2.4 for part in parts)
    return 0.2126 * red + 0.7152 * green + 0.0722 * blue


def contrast(one, other):
    low, high = sorted((luminance(one), luminance(other)))
    return (high + 0.05) / (low + 0.05)


def grounds():
    """{theme: [grounds]} of the style."""
    rules = re.findall(r"^:root(?:\[data-theme=\"(\w+)\"\])? \{(.*?)^\}", (PAGE / "style.css").read_text(), re.M | re.S)
    return {theme or "light": re.findall(r"--(?:back|card|stage): #(\w{6})", rule) for theme, rule in rules}


def palettes():
    """{theme: {name: [colours]}}"""
    text = (PAGE / "palette.js").read_text()
    themes = re.findall(r"^  (light|dark): \{\n(.*?)^  \}", text[text.index("PALETTES"):text.index("THEMES")], re.M | re.S)
    return {theme: {name: colours.split() for name, colours in re.findall(r'(\w+): "([0-9a-f ]+)"', body)} for theme, body in themes}


class Colours(unittest.TestCase):
    def test_ends_of_colour_bars_stand_out_in_both_themes(self):
        self.assertEqual(set(palettes()), {"light", "dark"})
        for theme, found in palettes().items():
            self.assertEqual(len(grounds()[theme]), 3)
            for name in "sequential", "diverging":
                for end in found[name][0], found[name][-1]:
                    for ground in grounds()[theme]:
                        self.assertGreaterEqual(contrast(end, ground), LEAST, (theme, name, end, ground))

    def test_magnitudes_get_lighter(self):
        for found in palettes().values():
            lights = [luminance(colour) for colour in found["sequential"]]
            self.assertEqual(lights, sorted(lights))

    def test_signed_quantities_leave_the_ground_on_both_sides(self):
        for theme, found in palettes().items():
            steps = [contrast(colour, grounds()[theme][0]) for colour in found["diverging"]]
            middle = len(steps) // 2
            self.assertEqual(steps[:middle + 1], sorted(steps[:middle + 1], reverse=True))
            self.assertEqual(steps[middle:], sorted(steps[middle:]))


if __name__ == "__main__":
    unittest.main()
