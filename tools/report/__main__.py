"""python3 -m report: makes the results of one level and draws the report. Called by tools/reproduce.sh."""
import argparse
import os
import signal
import sys
import time

from . import (configurations, convergence, coverage, diffusion, effort, errors, frequency, geometry, levels, markdown,
               mechanism_noise, mechanism_portrait, mechanism_scan, mechanism_size, mechanism_tep, oscillator, phase,
               regimes, starts, statements, turning, verdicts, vibration, waveform, waves)
from .page import Page, badge, missing_list
from .runs import ROOT, STOPPED, Results, Stopped
from .verdict import NO, OPEN, PAPER, YES

TITLE = "Sustained rotation in a vibrated disk: the paper's figures, computed anew"
MODULES = (geometry, oscillator, diffusion, vibration, regimes, waves, starts, turning, waveform, configurations, phase,
           mechanism_tep, mechanism_size, mechanism_noise, mechanism_scan, mechanism_portrait, convergence, coverage, frequency,
           effort)
STUDY_TITLE = "Three disks: time to a given error"
STUDY_MODULES = (errors, effort)


def options():
    parser = argparse.ArgumentParser(prog="tools/reproduce.sh", description="Runs the decks of inputs/paper and draws "
                                     "the figures of the paper into one HTML page. What is finished is not run again.")
    level = parser.add_mutually_exclusive_group()
    level.add_argument("--quick", dest="level", action="store_const", const="quick", help="coarse, under two minutes")
    level.add_argument("--full", dest="level", action="store_const", const="full",
                       help="the paper's whole campaign")
    parser.add_argument("--errors", action="store_true", help="instead of the paper's figures: how far time step and "
                        "noise interval can be raised, and what it buys; with --quick: whether it works")
    parser.add_argument("-o", dest="folder", default=os.path.join(ROOT, "build", "reproduce"), metavar="DIR",
                        help="where results and report go (build/reproduce)")
    parser.add_argument("-j", dest="jobs", type=int, default=os.cpu_count() or 1, metavar="N",
                        help="runs at a time (number of cores)")
    parser.add_argument("--program", default=os.path.join(ROOT, "build", "release", "slipdisk"), metavar="FILE")
    parser.add_argument("--only", action="append", default=[], metavar="NAME",
                        help="only these runs and sweeps: " + ", ".join([*levels.SWEEPS, *levels.RUNS]))
    parser.add_argument("--draw", action="store_true", help="run nothing, draw what is there")
    parser.add_argument("--keep", metavar="DIR", help="copy claims, numbers and figures to DIR/paper.md (--errors: "
                        "DIR/errors.md) and DIR/figures (docs, when they are to stay with the sources)")
    parser.set_defaults(level="default")
    args = parser.parse_args()
    if args.errors:
        if args.level == "full":
            parser.error("--errors has one length, and --quick")
        args.level = "errors-quick" if args.level == "quick" else "errors"
    unknown = [name for name in args.only if name not in levels.SWEEPS and name not in levels.RUNS]
    if unknown:
        parser.error(f"--only {unknown[0]}: no run or sweep is called that; there are "
                     + ", ".join([*levels.SWEEPS, *levels.RUNS]))
    return args


def draw(results, modules=None, keep=None):
    """Writes the page; returns its path and the number of each verdict on the paper's statements."""
    study = results.level in levels.STUDIES
    page = Page(results.folder, "report.html" if results.level == "default" else f"report-{results.level}.html")
    found = []
    for module in modules or (STUDY_MODULES if study else MODULES):
        try:
            found += module.sections(results)
        except Exception as error:  # one figure that fails must not take the others with it
            if results.strict:
                raise
            results.failed.append(f"figures of {module.__name__}: {type(error).__name__}: {error}")
    claims = [claim for section in found for claim in section.claims]
    if not study:
        summary = statements.sections(results, claims)
        claims += summary[0].claims
        found = summary + found
    counts = {word: sum(c.verdict == word and c.kind == PAPER for c in claims) for word in (YES, NO, OPEN)}
    for section in found:
        page.add(section)
    title = STUDY_TITLE if study else TITLE
    page.write(title, head(results, found, counts))
    text = page.path[:-len(".html")] + ".md"
    markdown.write(text, title, lead(results, counts), found, "figures")
    if keep:
        markdown.keep(keep, text, [figure.name for section in found for figure in section.figures],
                      "errors.md" if study else "paper.md")
        results.store.keep(os.path.join(keep, "data", results.page), not results.failed)
        if not study:
            verdicts.write(keep, claims, lead(results, counts)[-1].split(". ", 1)[-1])
    return page.path, counts


def head(results, sections, counts):
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
    lines.append(f'<p class="small">{effort.told(results, html=True)} Drawn {made} UTC with '
                 f"{escape(results.program_line())}. The figures lie beside this page as PDF and PNG, the tables as "
                 "CSV.</p>")
    return "\n".join(lines)


def lead(results, counts):
    """What stands above the Markdown."""
    if results.level in levels.STUDIES:
        return [f"`tools/reproduce.sh --errors`: {levels.DESCRIPTIONS[results.level]}."]
    by = effort.told(results, html=True) or f"Drawn with {escape(results.program_line())}."
    return ["Model and statements: G. G. Peraza-Mues and C. F. Moukarzel, *Sustained rotation in a vibrated disk with "
            "asymmetric supports*. R = mg = 1, g = 10; error bars are single standard errors. Every verdict is computed "
            "from the numbers beside it; [reproduce.md](reproduce.md) has the rules and the reasons of what is not "
            "reproduced.", "", f"Level: {results.level}, " + levels.DESCRIPTIONS[results.level] + ".", "",
            "Written by `tools/reproduce.sh`: " + ", ".join(f"{number} {word}" for word, number in counts.items())
            + f". {by}"]


def escape(text):
    return text.replace("&", "&amp;").replace("<", "&lt;").replace(">", "&gt;")


def main():
    args = options()
    results = Results(args.folder, args.level, args.program, args.jobs, dry=args.draw,
                      kept=os.path.join(ROOT, "docs", "data"))
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        signal.signal(number, results.stop)
    status = 0
    try:
        results.make(args.only)
    except Stopped:
        status = STOPPED
        print("stopped; drawing what is there. The same command goes on.")
    begin = time.monotonic()
    path, counts = draw(results, keep=args.keep)
    if effort.told(results):
        print(effort.told(results))
    print(f"drawn in {time.monotonic() - begin:.0f} s: {path}, "
          + ", ".join(f"{number} {word}" for word, number in counts.items()))
    for line in results.failed:
        print(line, file=sys.stderr)
    sys.exit(status or (3 if results.failed else 0))


if __name__ == "__main__":
    main()
