"""One HTML page that needs nothing else: figures, tables and CSV files are inside it."""
import base64
import csv
import dataclasses
import html
import io
import math
import os
import re

from . import verdict
from .style import mark_empty, plt


@dataclasses.dataclass
class Figure:
    name: str     # file name without its ending
    picture: object
    caption: str  # HTML
    alt: str


@dataclasses.dataclass
class Numbers:
    """The numbers behind a figure."""
    title: str
    columns: list
    rows: list
    shown: bool = False  # without being asked for
    kept: bool = True    # in the Markdown too


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
.place, .small { font-size: .85rem; color: #555; }
details { margin: .4rem 0; font-size: .95rem; }
summary { cursor: pointer; }
.missing { background: #fff7e0; border: 1px solid #e0c060; padding: .4rem .8rem; font-size: .9rem; }
nav ol { columns: 2; font-size: .95rem; } @media (max-width: 34rem) { nav ol { columns: 1; } }
a { color: #0b4a8f; }
""".strip()

CLASS = {verdict.YES: "yes", verdict.NO: "no", verdict.OPEN: "open"}


def badge(word):
    return f'<span class="verdict {CLASS[word]}">{word}</span>'


def cell(value):
    """(text, is a number)"""
    if isinstance(value, str):
        return value, False
    if value is None or isinstance(value, float) and not math.isfinite(value):
        return "", True
    if isinstance(value, float):
        value = int(value) if value == int(value) and abs(value) < 1e6 else value
    return (str(value) if isinstance(value, int) else f"{value:.6g}"), True


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
    head = "".join(f'<th scope="col">{name}</th>' for name in columns)
    lines = []
    for row in rows:
        cells = [cell(value) for value in row]
        lines.append("<tr>" + "".join(f'<td class="n">{t}</td>' if n else f"<td>{t}</td>" for t, n in cells) + "</tr>")
    body = "\n".join(lines)
    return f'<div class="scroll"><table><thead><tr>{head}</tr></thead><tbody>\n{body}\n</tbody></table></div>'


def data_link(text, name):
    coded = base64.b64encode(text.encode()).decode()
    return f'<a download="{name}" href="data:text/csv;charset=utf-8;base64,{coded}">{name}</a>'


class Page:
    def __init__(self, folder, name="report.html"):
        self.folder, self.path = folder, os.path.join(folder, name)
        self.parts, self.index = [], []
        os.makedirs(os.path.join(folder, "figures"), exist_ok=True)
        os.makedirs(os.path.join(folder, "tables"), exist_ok=True)

    def add(self, section):
        self.index.append((section.key, section.title))
        out = [f'<section id="{section.key}"><h2>{section.title}</h2>']
        if section.new:
            out.append('<p class="small">Not a figure of the paper.</p>')
        if section.lead:
            out.append(f"<p>{section.lead}</p>")
        out += [self._figure(figure) for figure in section.figures]
        if section.claims:
            out.append('<ul class="claims">' + "\n".join(self._claim(c) for c in section.claims) + "</ul>")
        if section.missing:
            out.append(missing_list(section.missing))
        for k, table in enumerate(section.tables):
            name = f"{section.key}{'-' + str(k + 1) if k else ''}.csv"
            text = csv_of(table)
            with open(os.path.join(self.folder, "tables", name), "w") as file:
                file.write(text)
            out.append(f"<details{' open' if table.shown else ''}><summary>{table.title} ({len(table.rows)} "
                       "rows)</summary>" f'{html_table(table.columns, table.rows)}<p class="small">As CSV: '
                       f'{data_link(text, name)}</p></details>')
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
