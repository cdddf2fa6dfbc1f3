"""docs/studies/verdicts.md: rules and tolerances of the verdicts, and statement by statement the verdicts of the
first report and of today."""
import csv
import os

from . import catalogue, markdown
from .runs import ROOT
from .verdict import CHECK, MEANING, NO, OPEN, PAPER, RULES, TOLERANCES, TRIVIAL, YES

OLD = os.path.join(ROOT, "docs", "studies", "data", "verdicts-old.csv")


def old_verdicts(path=OLD):
    """{slug: (verdict of the first report, what is judged differently now)}"""
    with open(path, newline="") as file:
        rows = list(csv.DictReader(line for line in file if not line.startswith("#")))
    return {slug: (row["verdict"], row["different"]) for row in rows for slug in row["slugs"].split()}


def counted(claims):
    return ", ".join(f"{sum(claim.verdict == word for claim in claims)} {word}" for word in (YES, NO, OPEN))


def rows(claims, old):
    out = []
    for claim in claims:
        before, different = old.get(claim.slug, ("", ""))
        if before and before != claim.verdict and not different:
            different = "the rule as it was, other data"
        place = f" ({claim.place})" if claim.place else ""
        out.append([f"<code>{claim.slug}</code>", claim.text + place, before or "not judged", f"<b>{claim.verdict}</b>",
                    claim.rule, different])
    return out


def write(folder, claims, by):
    """claims: all of the page; by: what made it."""
    old, every = old_verdicts(), catalogue.complete(claims)
    named = {row[0] for row in catalogue.STATEMENTS}
    every += [claim for claim in claims if claim.slug not in named]
    rules = [[f"<code>{name}</code>", text] for name, text in RULES.items()]
    tolerances = [[f"<code>{name}</code>", value, MEANING[name]] for name, value in TOLERANCES.items()]
    out = ["# Verdicts: rules, and statement by statement", "",
           "Every verdict of [paper.md](paper.md) follows from the numbers beside it by one of these rules "
           "(`tools/studies/ratchet/verdict.py`). The tables of statements compare the verdicts of the first report, whose "
           "rules let some pass too easily, with those of today; a rule without a name there means that there are no "
           "data.",
           "",
           f"Written by `tools/studies/ratchet.sh --keep docs/studies`; computed by {by}.", "",
           "## Rules", "", *markdown.table(["rule", "verdict"], rules), "",
           "## Tolerances", "", *markdown.table(["name", "value", "of"], tolerances)]
    head = ["name", "statement", "first report", "now", "rule", "what is judged differently"]
    for kind, title in ((PAPER, "The paper's statements"), (CHECK, "Own checks"),
                        (TRIVIAL, "By construction: geometry, waveforms, printed equations")):
        chosen = [claim for claim in every if claim.kind == kind]
        out += ["", f"## {title}", "", counted(chosen) + ".", "", *markdown.table(head, rows(chosen, old))]
    with open(os.path.join(folder, "verdicts.md"), "w") as file:
        file.write("\n".join(out) + "\n")
