"""A page as Markdown in Unicode, for documentation that is kept with the sources: GitHub and the site both show it."""
import glob
import html.parser
import os
import re
import shutil

from PIL import Image, ImageChops

from .page import by_motion, cell, kinds, shown_table
from .verdict import MOTIONS

UNSEEN = 20  # levels of 255
LONGEST = 8  # rows: longer tables are in docs/studies/data, and on the HTML page

SUB = dict(zip("0123456789+−=()aehijklmnoprstuvxβγρφχ", "₀₁₂₃₄₅₆₇₈₉₊₋₌₍₎ₐₑₕᵢⱼₖₗₘₙₒₚᵣₛₜᵤᵥₓᵦᵧᵨᵩᵪ"))
SUP = dict(zip("0123456789+−=()abcdefghijklmnoprstuvwxyz", "⁰¹²³⁴⁵⁶⁷⁸⁹⁺⁻⁼⁽⁾ᵃᵇᶜᵈᵉᶠᵍʰⁱʲᵏˡᵐⁿᵒᵖʳˢᵗᵘᵛʷˣʸᶻ"))


class Converter(html.parser.HTMLParser):
    """The few elements that the modules write. Emphasis covers letters only: a sign beside it would undo it."""

    def __init__(self, table=False, anchors=None):
        """anchors: {key of a section: that of its heading}"""
        super().__init__(convert_charrefs=True)
        self.table, self.anchors, self.out, self.open, self.address = table, anchors or {}, [], [], ""

    def handle_starttag(self, tag, attributes):
        self.open.append(tag)
        if tag == "br":
            self.open.pop()
            self.out.append("<br>" if self.table else "  \n")
        elif tag == "li":
            self.out.append("\n- ")
        elif tag in ("ul", "p"):
            self.out.append("\n\n")
        elif tag == "a":
            address = dict(attributes).get("href", "")
            self.address = "#" + self.anchors[address[1:]] if address[1:] in self.anchors else address
            self.out.append("[")

    def handle_endtag(self, tag):
        if tag in self.open:
            del self.open[len(self.open) - 1 - self.open[::-1].index(tag)]
        if tag in ("ul", "p"):
            self.out.append("\n\n")
        elif tag == "a":
            self.out.append(f"]({self.address})")

    def handle_data(self, data):
        data = re.sub(r"\s*\n\s*", " ", data)
        raised = [tag for tag in self.open if tag in ("sub", "sup")]
        if "code" in self.open:
            self.out.append("`" + (data.replace("|", "\\|") if self.table else data) + "`")
        elif raised:
            known = SUB if raised[-1] == "sub" else SUP
            whole = all(sign in known for sign in data)
            self.out.append("".join(known[sign] for sign in data) if whole
                            else f"<{raised[-1]}>{escape(data)}</{raised[-1]}>")
        else:
            mark = "**" if "b" in self.open else "*" if "i" in self.open or "em" in self.open else ""
            self.out.append(marked(escape(data, self.table), mark))

    def text(self):
        return re.sub(r"\n{3,}", "\n\n", "".join(self.out)).strip()


def marked(text, mark):
    """Emphasis around a text, but not around the blanks at its ends."""
    inner = text.strip()
    if not mark or not inner or not re.search(r"\w", inner):
        return text
    return text.replace(inner, mark + inner + mark, 1)


def escape(text, table=False):
    text = re.sub(r"([*$`\[\]~])", r"\\\1", text)
    text = re.sub(r"(?<!\w)_|_(?!\w)", r"\\_", text)
    text = re.sub(r"<(?=[A-Za-z/!])", r"\\<", text)
    return text.replace("|", "\\|") if table else text


def text_of(source, table=False, anchors=None):
    """HTML of the modules as Markdown."""
    converter = Converter(table, anchors)
    converter.feed(source)
    converter.close()
    return converter.text()


def bare(source):
    """The same without any marks, for the text in place of a picture."""
    return re.sub(r"\s+", " ", re.sub(r"<[^>]*>|[*\\`]", "", text_of(source)))


def anchor(title):
    """Of a heading, as GitHub and the site make it."""
    return re.sub(r"[^\w\- ]", "", re.sub(r"<[^>]*>|\*", "", title).lower()).replace(" ", "-")


def table(columns, rows, anchors=None):
    """rows of values, or of cells (HTML, is a number)"""
    rows = [[value if isinstance(value, tuple) else cell(value) for value in row] for row in rows]
    numeric = [bool(rows) and all(row[k][1] for row in rows) for k in range(len(columns))]
    lines = [[text_of(name, True) for name in columns], ["---:" if n else "---" for n in numeric],
             *([text_of(text, True, anchors) for text, _ in row] for row in rows)]
    return ["| " + " | ".join(line) + " |" for line in lines]


def placed(claim):
    return claim.text + (f" ({claim.place})" if claim.place else "")


def write(path, title, lead, sections, pictures="figures", data=""):
    """pictures, data: folders of the PNG files and of the CSV files as seen from the page."""
    out, anchors = [f"# {text_of(title)}", "", *lead, ""], {part.key: anchor(text_of(part.title)) for part in sections}
    for section in sections:
        out += [f"## {text_of(section.title)}", ""]
        if section.lead:
            out += [text_of(section.lead, anchors=anchors), ""]
        for figure in section.figures:
            out += [f"![{bare(figure.alt)}]({pictures}/{figure.name}.png)", "", text_of(figure.caption), ""]
        for heading, claims in kinds(section):
            single, pairs = by_motion(claims)
            rows = [[f"<b>{c.verdict}</b>", placed(c), c.numbers] for c in single]
            out += [*table(["verdict", heading, "found"], rows), ""] if rows else []
            rows = [[placed(next(iter(pair.values()))), *(f"<b>{pair[m].verdict}</b>: {pair[m].numbers}" if m in pair else ""
                                                          for m in MOTIONS)] for pair in pairs.values()]
            out += [*table([heading, *(f"{motion} drive" for motion in MOTIONS)], rows), ""] if rows else []
        for k, part in enumerate(section.tables):
            if not part.kept or not part.rows:
                continue
            name = section.table_name(k)
            if len(part.rows) <= LONGEST or part.shown:
                out += [f"{text_of(part.title)}:", "", *table(*shown_table(part), anchors), ""]
            else:
                out += [f"{text_of(part.title)}: {len(part.rows)} rows, [{name}.csv]({data}/{name}.csv).", ""]
    rows = [[f'<a href="#{section.key}">{section.title}</a>', ", ".join(
        f'<a href="{data}/{name}.csv">{name}</a>' for name in section.data)] for section in sections if section.data]
    if rows:
        out += ["## Numbers behind the figures", "", *table(["section", "files"], rows, anchors), ""]
    temporary = path + ".new"
    with open(temporary, "w") as file:
        file.write("\n".join(out).rstrip() + "\n")
    os.replace(temporary, path)


def keep(folder, page, figures, name, pictures, data):
    """Copies a page of write() to folder/name, its figures to folder/pictures; data: where its CSV files are."""
    os.makedirs(os.path.join(folder, pictures), exist_ok=True)
    with open(page) as file:
        text = re.sub(r"\]\(data-\w[\w-]*/", f"]({data}/", file.read().replace("](figures/", f"]({pictures}/"))
    with open(os.path.join(folder, name), "w") as file:
        file.write(text)
    for figure in figures:
        keep_picture(os.path.join(os.path.dirname(page), "figures", figure + ".png"), os.path.join(folder, pictures))
    for film in glob.glob(os.path.join(os.path.dirname(page), "figures", "*.gif")):
        shutil.copy(film, os.path.join(folder, pictures))


def keep_picture(path, folder):
    """Copies a picture; with a palette of 256 colours where no pixel changes visibly, as in plots of lines."""
    with Image.open(path) as picture:
        full = picture.convert("RGB")
    few = full.quantize(256, Image.Quantize.MAXCOVERAGE, kmeans=4, dither=Image.Dither.NONE)
    change = max(high for _, high in ImageChops.difference(full, few.convert("RGB")).getextrema())
    (few if change <= UNSEEN else full).save(os.path.join(folder, os.path.basename(path)), optimize=True)
