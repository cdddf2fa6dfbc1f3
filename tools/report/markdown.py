"""The claims and the numbers of the page as Markdown, for documentation that is kept with the sources.

Markdown takes HTML within a line, so texts are carried over as they are."""
import glob
import os
import re
import shutil

from PIL import Image, ImageChops

from .page import cell

UNSEEN = 8  # levels of 255
LONGEST = 16  # rows: longer tables are on the HTML page, and there as CSV files


def _line(text):
    return re.sub(r"\s*\n\s*", " ", re.sub(r"</?span[^>]*>", "", text)).replace("|", "&#124;")


def _row(cells):
    return "| " + " | ".join(_line(text) for text in cells) + " |"


def table(columns, rows):
    numeric = [bool(rows) and all(cell(row[k])[1] for row in rows) for k in range(len(columns))]
    out = [_row(columns), "|" + "|".join("---:" if n else "---" for n in numeric) + "|"]
    return out + [_row([cell(value)[0] for value in row]) for row in rows]


def keep(folder, page, figures, name="paper.md"):
    """Copies a page of write() to a file in the folder, and its figures (names) to folder/figures."""
    os.makedirs(os.path.join(folder, "figures"), exist_ok=True)
    with open(page) as file:
        text = file.read()
    with open(os.path.join(folder, name), "w") as file:
        file.write(text)
    for figure in figures:
        keep_picture(os.path.join(os.path.dirname(page), "figures", figure + ".png"), os.path.join(folder, "figures"))
    for film in glob.glob(os.path.join(os.path.dirname(page), "figures", "*.gif")):
        shutil.copy(film, os.path.join(folder, "figures"))


def keep_picture(path, folder):
    """Copies a picture; with a palette of 256 colours where no pixel changes visibly, as in plots of lines."""
    with Image.open(path) as picture:
        full = picture.convert("RGB")
    few = full.quantize(256, Image.Quantize.MAXCOVERAGE, dither=Image.Dither.NONE)
    change = max(high for _, high in ImageChops.difference(full, few.convert("RGB")).getextrema())
    (few if change <= UNSEEN else full).save(os.path.join(folder, os.path.basename(path)), optimize=True)


def write(path, title, lead, sections, pictures=None):
    """pictures: folder of the PNG files as seen from the page; None: without them."""
    out = [f"# {title}", "", *lead, ""]
    for section in sections:
        out += [f"## {_line(section.title)}", ""]
        if section.lead:
            out += [_line(section.lead), ""]
        for figure in section.figures if pictures else []:
            out += [f"![{_line(figure.alt)}]({pictures}/{figure.name}.png)", "", _line(figure.caption), ""]
        if section.claims:
            claims = [[f"**{c.verdict}**", c.text + (f" ({c.place})" if c.place else ""), c.numbers] for c in section.claims]
            out += [*table(["verdict", "statement", "found"], claims), ""]
        for numbers in section.tables:
            if numbers.kept and 0 < len(numbers.rows) <= LONGEST:
                out += [f"{_line(numbers.title)}:", "", *table(numbers.columns, numbers.rows), ""]
    temporary = path + ".new"
    with open(temporary, "w") as file:
        file.write("\n".join(out).rstrip() + "\n")
    os.replace(temporary, path)
