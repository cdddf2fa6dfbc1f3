"""One HTML page that needs nothing else: figures, tables and CSV files are inside it."""
import base64
import csv
import dataclasses
import html
import io
import math
import os
import re

from . import kept, verdict
from .style import mark_empty, plt


@dataclasses.dataclass
class Figure:
    name: str     # file name without its ending
    picture: object
    caption: str  # HTML
    alt: str


@dataclasses.dataclass
class Numbers:
    """The numbers behind a figure. A column called "error" holds the errors of the one before it: they are shown in one
    column, with the digits that the error allows; the CSV has both."""
    title: str
    columns: list
    rows: list
    shown: bool = False  # without being asked for
    kept: bool = True    # in the Markdown too
    digits: dict = dataclasses.field(default_factory=dict)  # {column: significant digits} where there is no error


@dataclasses.dataclass
class Section:
    key: str
    title: str
    lead: str = ""  # HTML: what is shown and how it was computed
    figures: list = dataclasses.field(default_factory=list)
    claims: list = dataclasses.field(default_factory=list)
    tables: list = dataclasses.field(default_factory=list)
    missing: list = dataclasses.field(default_factory=list)
    new: bool = False  # not a figure of the paper
    data: list = dataclasses.field(default_factory=list)  # names of the kept numbers it is drawn from
    facts: dict = dataclasses.field(default_factory=dict)  # {name: HTML} for the text at the head of the page

    def __post_init__(self):
        kept.LOG.append(self)

    def table_name(self, k):
        """Of the CSV file of its k-th table."""
        return f"table-{self.key}{'-' + str(k + 1) if k else ''}"


STYLE = """
:root { color-scheme: light; }
body { font: 16px/1.5 Georgia, "Times New Roman", serif; color: #1a1a1a; background: #fff; margin: 0 auto;
       max-width: 52rem; padding: 0 1rem 4rem; overflow-wrap: break-word; }
h1 { font-size: 1.6rem; line-height: 1.25; margin: 1.5rem 0 .5rem; }
h2 { font-size: 1.25rem; margin: 3rem 0 .5rem; padding-top: .5rem; border-top: 1px solid #ccc; }
figure { margin: 1rem 0; }
figure img { width: 100%; height: auto; display: block; }
figcaption { font-size: .92rem; color: #333; margin-top: .3rem; }
.scroll { overflow-x: auto; }
table { border-collapse: collapse; font: 13px/1.35 system-ui, sans-serif; font-variant-numeric: tabular-nums;
        margin: .5rem 0; }
th, td { border-bottom: 1px solid #ddd; padding: .2rem .55rem; text-align: left; vertical-align: top; }
th { border-bottom: 1.5px solid #666; }
td.n { text-align: right; white-space: nowrap; }
ul.claims { list-style: none; padding: 0; }
ul.claims li { margin: .6rem 0; padding-left: .8rem; border-left: 4px solid #999; }
ul.claims li.yes { border-color: #1b7837; } ul.claims li.no { border-color: #b2182b; }
ul.claims li.open { border-color: #b8860b; }
.verdict { font: 600 .8rem/1.4 system-ui, sans-serif; padding: 0 .4rem; border-radius: .2rem; color: #fff;
           background: #777; white-space: nowrap; }
.verdict.yes { background: #1b7837; } .verdict.no { background: #b2182b; } .verdict.open { background: #8a6508; }
.numbers { display: block; font-size: .9rem; color: #333; }
.kind { font: 600 .85rem/1.4 system-ui, sans-serif; color: #555; margin: 1rem 0 0; }
.place, .small { font-size: .85rem; color: #555; }
details { margin: .4rem 0; font-size: .95rem; }
summary { cursor: pointer; }
.missing { background: #fff7e0; border: 1px solid #e0c060; padding: .4rem .8rem; font-size: .9rem; }
nav ol { columns: 2; font-size: .95rem; } @media (max-width: 34rem) { nav ol { columns: 1; } }
a { color: #0b4a8f; }
""".strip()

CLASS = {verdict.YES: "yes", verdict.NO: "no", verdict.DEPENDS: "open", verdict.OPEN: "open"}


def badge(word):
    return f'<span class="verdict {CLASS[word]}">{word}</span>'


def digits_of(column):
    """Significant digits of numbers without an error."""
    name = plain(column)
    return 2 if name in ("residual", "transient") else 3 if "%" in name else 5 if name in (
        "simulation", "theory", "exact solution") else 4


def cell(value, error=None, digits=4):
    """(HTML, is a number)"""
    if isinstance(value, str):
        return value, False
    if value is None or not math.isfinite(value):
        return "", True
    if error is not None and math.isfinite(error) and error > 0:
        return verdict.number(value, error), True
    if value == int(value) and abs(value) < 1e6:
        return verdict.number(value, digits=7), True
    return verdict.number(value, digits=digits), True


def shown_table(table):
    """(columns, rows of cells) of a table as it is shown: errors stand beside their values."""
    errors = {k: k + 1 for k, name in enumerate(table.columns[1:]) if name == "error"}
    columns = [k for k in range(len(table.columns)) if k not in errors.values()]
    rows = []
    for row in table.rows:
        cells = []
        for k in columns:
            digits = table.digits.get(table.columns[k]) or digits_of(table.columns[k])
            error = row[errors[k]] if k in errors else None
            whole = plain(table.columns[k]) == "seed" and isinstance(row[k], float) and math.isfinite(row[k])
            cells.append((f"{row[k]:.0f}", True) if whole else cell(row[k], error if isinstance(error, (int, float))
                                                                    else None,
                                                                    digits))
        rows.append(cells)
    return [table.columns[k] for k in columns], rows


def kinds(section):
    """[(heading, claims)]: the paper's statements, own checks, and what holds by construction, each apart."""
    parts = [(heading, [claim for claim in section.claims if claim.kind == kind]) for kind, heading in HEADINGS.items()]
    parts = [(heading, some) for heading, some in parts if some]
    if len(parts) == 1 and not section.new and parts[0][0] == HEADINGS[verdict.CHECK]:
        return [("statement", section.claims)]  # of a page that is not about the paper
    return parts


def by_motion(claims):
    """(claims of no motion, {text: {motion: claim}} of the others)"""
    pairs = {}
    for claim in claims:
        if claim.motion:
            pairs.setdefault(claim.text, {})[claim.motion] = claim
    return [claim for claim in claims if not claim.motion], pairs


HEADINGS = {verdict.PAPER: "statement of the paper", verdict.CHECK: "own check",
            verdict.TRIVIAL: "holds by construction"}


def plain(text):
    """HTML as plain text, for CSV."""
    return html.unescape(re.sub(r"<[^>]*>", "", text))


def csv_of(table):
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow([plain(name) for name in table.columns])
    for row in table.rows:
        writer.writerow([plain(v) if isinstance(v, str) else "" if v is None or v != v else repr(float(v))
                         for v in row])
    return out.getvalue()


def html_table(columns, rows):
    """rows of cells (HTML, is a number)"""
    head = "".join(f'<th scope="col">{name}</th>' for name in columns)
    lines = ["<tr>" + "".join(f'<td class="n">{t}</td>' if n else f"<td>{t}</td>" for t, n in cells) + "</tr>"
             for cells in rows]
    body = "\n".join(lines)
    return f'<div class="scroll"><table><thead><tr>{head}</tr></thead><tbody>\n{body}\n</tbody></table></div>'


def plural(heading):
    """Above a list of such claims."""
    return {"statement of the paper": "Statements of the paper", "own check": "Own checks",
            "holds by construction": "By construction"}.get(heading, "Statements")


def data_link(text, name):
    coded = base64.b64encode(text.encode()).decode()
    return f'<a download="{name}" href="data:text/csv;charset=utf-8;base64,{coded}">{name}</a>'


class Page:
    """store: where the tables go as CSV."""

    def __init__(self, folder, name="report.html", store=None):
        self.folder, self.path = folder, os.path.join(folder, name)
        self.store = store or kept.Store(os.path.join(folder, "data"))
        self.parts, self.index = [], []
        os.makedirs(os.path.join(folder, "figures"), exist_ok=True)

    def add(self, section):
        self.index.append((section.key, section.title))
        out = [f'<section id="{section.key}"><h2>{section.title}</h2>']
        if section.new:
            out.append('<p class="small">Not a figure of the paper.</p>')
        if section.lead:
            out.append(f"<p>{section.lead}</p>")
        out += [self._figure(figure) for figure in section.figures]
        for heading, claims in kinds(section):
            single, pairs = by_motion(claims)
            out.append(f'<p class="kind">{plural(heading)}</p><ul class="claims">'
                       + "\n".join([*(self._claim(c) for c in single), *map(self._pair, pairs.values())]) + "</ul>")
        if section.missing:
            out.append(missing_list(section.missing))
        for k, table in enumerate(section.tables):
            name, text = section.table_name(k), csv_of(table)
            self.store.write_text(name, f"# {plain(table.title)}\n{text}")
            out.append(f"<details{' open' if table.shown else ''}><summary>{table.title} ({len(table.rows)} "
                       f"rows)</summary>{html_table(*shown_table(table))}<p class=\"small\">As CSV: "
                       f'{data_link(text, name + ".csv")}</p></details>')
        out.append("</section>")
        self.parts.append("\n".join(out))

    def _figure(self, figure):
        path = os.path.join(self.folder, "figures", figure.name)
        mark_empty(figure.picture)
        figure.picture.savefig(path + ".png")
        figure.picture.savefig(path + ".pdf")
        plt.close(figure.picture)
        with open(path + ".png", "rb") as file:
            coded = base64.b64encode(file.read()).decode()
        return (f'<figure><img alt="{html.escape(figure.alt, quote=True)}" src="data:image/png;base64,{coded}">'
                f"<figcaption>{figure.caption}</figcaption></figure>")

    @staticmethod
    def _claim(claim):
        place = f' <span class="place">({claim.place})</span>' if claim.place else ""
        return (f'<li class="{CLASS[claim.verdict]}">{badge(claim.verdict)} {claim.text}{place}'
                f'<span class="numbers">{claim.numbers}</span></li>')

    @staticmethod
    def _pair(found):
        first = next(iter(found.values()))
        place = f' <span class="place">({first.place})</span>' if first.place else ""
        return (f'<li class="{CLASS[first.verdict]}">{first.text}{place}' + "".join(
            f'<span class="numbers">{motion} {badge(claim.verdict)} {claim.numbers}</span>' for motion, claim in found.items())
            + "</li>")

    def write(self, title, head):
        """head: HTML that stands above the index."""
        links = "".join(f'<li><a href="#{key}">{name}</a></li>' for key, name in self.index)
        text = (f'<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n<title>{title}</title>\n<meta '
                'name="viewport" content="width=device-width, '
                f'initial-scale=1">\n<style>\n{STYLE}\n</style>\n</head>\n<body>\n'
                f"<h1>{title}</h1>\n{head}\n<nav><ol>{links}</ol></nav>\n" + "\n".join(self.parts)
                + "\n</body>\n</html>\n")
        temporary = self.path + ".new"
        with open(temporary, "w") as file:
            file.write(text)
        os.replace(temporary, self.path)


def missing_list(lines):
    shown = "".join(f"<li>{html.escape(line)}</li>" for line in lines)
    return (f'<div class="missing"><details><summary>{len(lines)} point{"s" * (len(lines) != 1)} missing'
            f"</summary><ul>{shown}</ul></details></div>")
