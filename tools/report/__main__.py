"""python3 -m report: makes the results of one level and draws the report. Called by tools/reproduce.sh."""
import argparse
import os
import platform
import signal
import sys
import time

from . import (configurations, convergence, frequency, geometry, levels, markdown, oscillator, phase, statements,
               turning, vibration, waves)
from .page import Page, badge, missing_list
from .runs import ROOT, STOPPED, Results, Stopped
from .verdict import NO, OPEN, YES

TITLE = "Sustained rotation in a vibrated disk: the paper's figures, computed anew"
MODULES = (geometry, oscillator, vibration, waves, turning, configurations, phase, convergence, frequency)


def options():
    parser = argparse.ArgumentParser(prog="tools/reproduce.sh", description="Runs the decks of inputs/paper and draws "
                                     "the figures of the paper into one HTML page. What is finished is not run again.")
    level = parser.add_mutually_exclusive_group()
    level.add_argument("--quick", dest="level", action="store_const", const="quick", help="coarse, under two minutes")
    level.add_argument("--full", dest="level", action="store_const", const="full",
                       help="the paper's whole campaign, hours")
    parser.add_argument("-o", dest="folder", default=os.path.join(ROOT, "build", "reproduce"), metavar="DIR",
                        help="where results and report go (build/reproduce)")
    parser.add_argument("-j", dest="jobs", type=int, default=os.cpu_count() or 1, metavar="N",
                        help="runs at a time (number of cores)")
    parser.add_argument("--program", default=os.path.join(ROOT, "build", "release", "slipdisk"), metavar="FILE")
    parser.add_argument("--only", action="append", default=[], metavar="NAME",
                        help="only these runs and sweeps: " + ", ".join([*levels.SWEEPS, *levels.RUNS]))
    parser.add_argument("--draw", action="store_true", help="run nothing, draw what is there")
    parser.add_argument("--keep", metavar="DIR", help="copy claims, numbers and figures to DIR/paper.md and DIR/figures "
                        "(docs, when they are to stay with the sources)")
    parser.set_defaults(level="default")
    args = parser.parse_args()
    unknown = [name for name in args.only if name not in levels.SWEEPS and name not in levels.RUNS]
    if unknown:
        parser.error(f"--only {unknown[0]}: no run or sweep is called that; there are "
                     + ", ".join([*levels.SWEEPS, *levels.RUNS]))
    return args


def draw(results, seconds=None, modules=MODULES, keep=None):
    """Writes the page; returns its path and the number of each verdict."""
    page = Page(results.folder, "report.html" if results.level == "default" else f"report-{results.level}.html")
    found = []
    for module in modules:
        try:
            found += module.sections(results)
        except Exception as error:  # one figure that fails must not take the others with it
            if results.strict:
                raise
            results.failed.append(f"figures of {module.__name__}: {type(error).__name__}: {error}")
    claims = [claim for section in found for claim in section.claims]
    summary = statements.sections(results, claims)
    counts = {word: sum(c.verdict == word for c in claims + summary[0].claims) for word in (YES, NO, OPEN)}
    found = summary + found
    for section in found:
        page.add(section)
    page.write(TITLE, head(results, found, counts, seconds))
    text = page.path[:-len(".html")] + ".md"
    markdown.write(text, TITLE, lead(results, counts), found, "figures")
    if keep:
        markdown.keep(keep, text, [figure.name for section in found for figure in section.figures])
    return page.path, counts


def head(results, sections, counts, seconds):
    missing = list(dict.fromkeys(line for section in sections for line in section.missing))
    lines = ["<p>Model and statements: G. G. Peraza-Mues and C. F. Moukarzel, <i>Sustained rotation in a vibrated disk "
             "with asymmetric supports</i>. All numbers are in the paper's units, <i>R</i> = <i>mg</i> = 1, <i>g</i> "
             "= 10; error bars are single standard errors. Every verdict is computed from the numbers beside it.</p>",
             f"<p><b>Level: {results.level}</b> &ndash; {levels.DESCRIPTIONS[results.level]}.</p>", "<p>"
             + ", ".join(f"{counts[word]} " f"{badge(word)}" for word in (YES, NO, OPEN)) + "</p>"]
    if missing:
        lines.append(missing_list(missing))
    if results.failed:
        lines.append('<div class="missing"><p>What went wrong:</p><ul>' +
                     "".join(f"<li>{escape(line)}</li>" for line in results.failed) + "</ul></div>")
    made = time.strftime("%Y-%m-%d %H:%M", time.gmtime())
    took = f", its last call took {seconds / 60:.1f} min on {results.jobs} core{'s' * (results.jobs > 1)}" if seconds else ""
    program = escape((results.provenance() or "?").splitlines()[0])
    lines.append(f'<p class="small">Drawn {made} UTC by {program} on {platform.machine()}{took}. The figures lie '
                 "beside this page as PDF and PNG, the tables as CSV.</p>")
    return "\n".join(lines)


def lead(results, counts):
    """What stands above the Markdown."""
    program = (results.provenance() or "?").splitlines()[0]
    return ["Model and statements: G. G. Peraza-Mues and C. F. Moukarzel, *Sustained rotation in a vibrated disk with "
            "asymmetric supports*. R = mg = 1, g = 10; error bars are single standard errors. Every verdict is computed "
            "from the numbers beside it; [reproduce.md](reproduce.md) has the rules and the reasons of what is not "
            "reproduced.", "", f"Level: {results.level}, " + levels.DESCRIPTIONS[results.level] + ".", "",
            f"Written by `tools/reproduce.sh` with {program} on {platform.machine()}: "
            + ", ".join(f"{number} {word}" for word, number in counts.items()) + "."]


def escape(text):
    return text.replace("&", "&amp;").replace("<", "&lt;").replace(">", "&gt;")


def main():
    args = options()
    results = Results(args.folder, args.level, args.program, args.jobs, dry=args.draw)
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        signal.signal(number, results.stop)
    begin, status = time.monotonic(), 0
    try:
        results.make(args.only)
    except Stopped:
        status = STOPPED
        print("stopped; drawing what is there. The same command goes on.")
    path, counts = draw(results, None if args.draw else time.monotonic() - begin, keep=args.keep)
    print(f"{path}: " + ", ".join(f"{number} {word}" for word, number in counts.items()))
    for line in results.failed:
        print(line, file=sys.stderr)
    sys.exit(status or (3 if results.failed else 0))


if __name__ == "__main__":
    main()
