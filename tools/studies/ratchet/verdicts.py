"""docs/studies/verdicts.md: rules and tolerances of the verdicts, and statement by statement the verdict, how far the tolerance is from
turning it, and the verdict of the report before."""
import csv
import math
import os

from . import catalogue, markdown
from .runs import ROOT
from .verdict import CHECK, MEANING, PAPER, RULES, TOLERANCES, TRIVIAL, WORDS

OLD = os.path.join(ROOT, "docs", "studies", "data", "verdicts-old.csv")
TITLES = ((PAPER, "The paper's statements"), (CHECK, "Own checks"),
          (TRIVIAL, "By construction: geometry, waveforms, printed equations"))


def old_verdicts(path=OLD):
    """{slug: row of the report before: kind, verdict, what is judged differently now, statement}"""
    with open(path, newline="") as file:
        return {row["slug"]: row for row in csv.DictReader(line for line in file if not line.startswith("#"))}


def counted(claims):
    return ", ".join(f"{sum(claim.verdict == word for claim in claims)} {word}" for word in WORDS)


def margin(claim):
    """(factor on the tolerance that turns the verdict, verdict at half and at twice the tolerance)"""
    if not claim.half:
        return "", "", ""
    turns = "none" if math.isinf(claim.turns) else f"{claim.turns:.2g}"
    return turns, *("&ndash;" if verdict == claim.verdict else verdict for verdict in (claim.half, claim.double))


def rows(claims, old):
    out = []
    for claim in claims:
        before = old.get(claim.slug, {})
        different = before.get("different", "") if before else "judged since"
        if before and before["verdict"] != claim.verdict and not different:
            different = "the rule as it was, other data"
        place = f" ({claim.place})" if claim.place else ""
        was = before.get("verdict", "&ndash;") + (f" ({before['kind']})" if before and before["kind"] != claim.kind else "")
        out.append([f"<code>{claim.slug}</code>", claim.text + place, was, f"<b>{claim.verdict}</b>", claim.rule, *margin(claim),
                    different])
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
           "(`tools/studies/ratchet/verdict.py`). The tables of statements show", "",
           "- *before*: the verdict of the report before this one, and what is judged differently since;",
           "- *turns at*: the factor on the tolerance, nearest to 1, that turns the verdict (none: no factor from 1/1000 to 1000 "
           "does; empty: the rule has no tolerance);",
           "- *half*, *twice*: the verdict at half and at twice the tolerance, – where it is the same. A rule without a name means "
           "that there are no data.", "",
           f"Written by `tools/studies/ratchet.sh --keep docs/studies`; computed by {by}.", "",
           "## Rules", "", *markdown.table(["rule", "verdict"], rules), "",
           "## Tolerances", "", *markdown.table(["name", "value", "of"], tolerances)]
    head = ["name", "statement", "before", "now", "rule", "turns at", "half", "twice", "what is judged differently"]
    for kind, title in TITLES:
        chosen = [claim for claim in every if claim.kind == kind]
        before = [row["verdict"] for row in old.values() if row["kind"] == kind]
        out += ["", f"## {title}", "", counted(chosen) + ". Before: " + ", ".join(
            f"{before.count(word)} {word}" for word in WORDS if word in before) + ".", "",
            *markdown.table(head, rows(chosen, old))]
    gone = [row for slug, row in old.items() if slug not in {claim.slug for claim in every}]
    if gone:
        out += ["", "## No longer judged by themselves", "", *markdown.table(
            ["name", "statement", "before", "why"],
            [[f"<code>{row['slug']}</code>", row["statement"], row["verdict"], row["different"]] for row in gone])]
    with open(os.path.join(folder, "verdicts.md"), "w") as file:
        file.write("\n".join(out) + "\n")
