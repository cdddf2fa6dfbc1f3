"""docs/coming_from_python.md: the table has the lines of each task in the page and in the scripts for LAMMPS and YADE. Empty lines and
comments are not counted.

    tests/docs/test_twenty_tasks.py --write    puts in the counted lines
"""
import os
import pathlib
import re
import sys
import unittest

ROOT = pathlib.Path(os.environ.get("SLIPDISK_SOURCE_DIR", pathlib.Path(__file__).resolve().parents[2]))
PAGE = ROOT / "docs/coming_from_python.md"
SCRIPTS = [ROOT / "inputs/cookbook" / name for name in ("twenty_yade.py", "twenty_lammps.py")]
TASK = re.compile(r"^#+ (\d+\. .*)\n", re.MULTILINE)


def lines_of(text):
    """{"1. Title": lines of code behind this heading}"""
    pieces = TASK.split(text)
    return {title: [line for line in body.splitlines() if line.strip() and not line.strip().startswith("#")]
            for title, body in zip(pieces[1::2], pieces[2::2])}


def of_page(text):
    """The page with its prose and outputs left out."""
    return "".join(m[1] or m[2] for m in re.finditer(r"^(#+ \d[^\n]*\n)|^```python\n(.*?)^```", text, re.MULTILINE | re.DOTALL))


def rows(tasks):
    """The rows of the table."""
    counts = {title: [len(one.get(title, ())) for one in tasks] for title in tasks[0]}
    counts["all"] = [sum(column) for column in zip(*counts.values())]
    return "".join(f"|{title} |" + " |".join(str(n or "-") for n in numbers) + "|\n" for title, numbers in counts.items())


class Twenty(unittest.TestCase):
    def setUp(self):
        self.text = PAGE.read_text(encoding="utf-8")
        self.tasks = [lines_of(of_page(self.text)), *(lines_of(path.read_text(encoding="utf-8")) for path in SCRIPTS)]

    def test_same_tasks(self):
        for tasks, where in zip(self.tasks, [PAGE, *SCRIPTS]):
            self.assertEqual(list(tasks), list(self.tasks[0]), where)
            self.assertEqual([int(title.split(".")[0]) for title in tasks], list(range(1, 21)), where)

    def test_lines_are_not_hidden(self):
        for tasks, where in zip(self.tasks, [PAGE, *SCRIPTS]):
            for title, lines in tasks.items():
                for line in lines:
                    self.assertLessEqual(len(line), 100, f"{where}: {title}: {line}")
                    self.assertNotRegex(line, r";", f"{where}: {title}: two statements in a line: {line}")

    def test_table(self):
        self.assertIn(rows(self.tasks), self.text)


def write():
    text = PAGE.read_text(encoding="utf-8")
    made = rows([lines_of(of_page(text)), *(lines_of(path.read_text(encoding="utf-8")) for path in SCRIPTS)])
    PAGE.write_text(re.sub(r"(\|---\|---\|---\|---\|\n)(?:\|(?:\d+\.|all) .*\n)*", lambda m: m[1] + made, text, count=1), encoding="utf-8")


if __name__ == "__main__":
    if "--write" in sys.argv:
        write()
    else:
        unittest.main()
