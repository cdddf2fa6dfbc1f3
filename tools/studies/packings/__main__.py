"""python3 -m packings: makes the results of one level and draws the study of packings.

Called by tools/studies/packings.sh."""
import argparse
import dataclasses
import os
import signal
import sys
import time
from html import escape

from ratchet import markdown
from ratchet.__main__ import collect, keep_all
from ratchet.page import Page, badge, missing_list
from ratchet.runs import STOPPED
from ratchet.verdict import CHECK, NO, OPEN, PAPER, YES

from . import (alone, budget, cages, controls, depths, drive, each, energy, flows, front, gentle, jamming, jumps, large,
               limits, low, memory, plan, quiet, scans, space)
from .runs import ROOT, Campaign, Stopped

TITLE = "Packings: shaken, compressed, poured"
MODULES = (gentle, alone, low, each, quiet, drive, energy, memory, cages, space, jumps, scans, depths, controls, budget,
           jamming, flows, large)


def options():
    parser = argparse.ArgumentParser(prog="tools/studies/packings.sh", description="Runs the decks of inputs/packing and "
                                     "draws what they show into one HTML page. What is finished is not run again.")
    parser.add_argument("--quick", dest="level", action="store_const", const="quick", help="coarse, a few minutes")
    parser.add_argument("--large", action="store_true", help="also the runs of 100000 disks, 25 minutes of one core")
    parser.add_argument("-o", dest="folder", default=os.path.join(ROOT, "build", "packings"), metavar="DIR",
                        help="where results and page go (build/packings)")
    parser.add_argument("-j", dest="jobs", type=int, default=os.cpu_count() or 1, metavar="N",
                        help="runs at a time (number of cores)")
    parser.add_argument("--program", default=os.path.join(ROOT, "build", "release", "slipdisk"), metavar="FILE")
    parser.add_argument("--only", action="append", default=[], metavar="NAME", help="only these: " + ", "
        "".join(plan.ENTRIES))
    parser.add_argument("--draw", action="store_true", help="run nothing, draw what is there; without results from "
                                                            "docs/studies/data alone")
    parser.add_argument("--keep", metavar="DIR", help="copy claims, numbers and figures to DIR/packings_study.md and "
                        "DIR/figures/packings (docs/studies, when they are to stay with the sources)")
    parser.set_defaults(level="default")
    args = parser.parse_args()
    unknown = [name for name in args.only if name not in plan.ENTRIES]
    if unknown:
        parser.error(f"--only {unknown[0]}: nothing is called that; there are " + ", ".join(plan.ENTRIES))
    args.large |= any(plan.ENTRIES[name].large for name in args.only)
    return args


def draw(campaign, keep=None, modules=MODULES):
    """Writes the page; returns its path and the number of each verdict."""
    name = "packings" if campaign.level == "default" else f"packings-{campaign.level}"
    page = Page(campaign.folder, name + ".html", campaign.store)
    found = collect(campaign, modules)
    campaign.keep_missing()
    claims = [claim for section in found for claim in section.claims]
    for claim in claims:  # one table for each section; the letter's statements are marked
        if claim.kind == PAPER:
            claim.kind, claim.place = CHECK, "letter"
    counts = {word: sum(claim.verdict == word for claim in claims) for word in (YES, NO, OPEN)}
    found = [front.section(campaign, found), *found, limits.section(found), front.data(found)]
    for section in found:
        page.add(section)
    page.write(TITLE, head(campaign, found, counts))
    text = page.path[:-len(".html")] + ".md"
    apart = [dataclasses.replace(section, data=[]) for section in found]  # the last section has all
    markdown.write(text, TITLE, lead(campaign), apart, data="data-" + campaign.level)
    if keep:
        keep_all(campaign, keep, text, found, "packings_study.md", "figures/packings")
    return page.path, counts


def head(campaign, found, counts):
    missing = list(dict.fromkeys(line for section in found for line in section.missing))
    lines = [f"<p><b>Level: {campaign.level}</b> &ndash; {plan.DESCRIPTIONS[campaign.level]}. SI units unless said "
             f"otherwise; error "
             "bars are single standard errors. Every verdict is computed from the numbers beside it.</p>",
             "<p>" + ", ".join(f"{counts[word]} {badge(word)}" for word in (YES, NO, OPEN)) + "</p>"]
    if missing:
        lines.append(missing_list(missing))
    if campaign.failed:
        lines.append('<div class="missing"><p>What went wrong:</p><ul>'
                     + "".join(f"<li>{escape(line)}</li>" for line in campaign.failed) + "</ul></div>")
    made = time.strftime("%Y-%m-%d %H:%M", time.gmtime())
    lines.append(f'<p class="small">Drawn {made} UTC. The head of each CSV file names the program that made it.</p>')
    return "\n".join(lines)


def lead(campaign):
    """What stands above the Markdown."""
    return [markdown.text_of(
        "The decks of <code>inputs/packing</code>, statement by statement. The vibrated boxes follow Moukarzel, Peraza-Mues "
        "and Carvente, Phys. Rev. Lett. 125, 028001 (2020). SI units unless said otherwise; errors are single standard "
        "errors; every verdict is computed from the numbers beside it; statements of theirs are marked (letter). Written "
        "by <code>tools/studies/packings.sh</code>, "
        f"level {campaign.level}: {plan.DESCRIPTIONS[campaign.level]}.")]


def main():
    args = options()
    os.makedirs(args.folder, exist_ok=True)
    campaign = Campaign(args.folder, args.level, args.program, args.jobs, dry=args.draw,
                        kept=os.path.join(ROOT, "docs", "studies", "data"), large=args.large)
    campaign.keep_program()
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        signal.signal(number, campaign.stop)
    status = 0
    try:
        campaign.make(args.only)
    except Stopped:
        status = STOPPED
        print("stopped; drawing what is there. The same command goes on.")
    path, counts = draw(campaign, args.keep)
    print(f"{path}: " + ", ".join(f"{number} {word}" for word, number in counts.items()))
    for line in campaign.failed:
        print(line, file=sys.stderr)
    sys.exit(status or (3 if campaign.failed else 0))


if __name__ == "__main__":
    main()
