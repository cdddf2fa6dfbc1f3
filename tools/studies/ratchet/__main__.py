"""python3 -m ratchet: makes the results of one level and draws the report.

Called by tools/studies/ratchet.sh."""
import argparse
import os
import signal
import sys
import time

from . import (configurations, convergence, coverage, diffusion, durations, effort, errors, fields, frequency, geometry,
               levels, markdown, mechanism_noise, mechanism_portrait, mechanism_scan, mechanism_size, mechanism_tep,
               oscillator, phase, regimes, starts, statements, summary, turning, verdicts, vibration, waveform, waves)
from .kept import LOG, assign
from .page import Page, badge, missing_list
from .runs import ROOT, STOPPED, Results, Stopped
from .verdict import PAPER, WORDS

TITLE = "Sustained rotation in a vibrated disk: the paper's figures, computed anew"
MODULES = (geometry, oscillator, diffusion, vibration, regimes, waves, starts, turning, fields, waveform, configurations, phase,
           mechanism_tep, durations, mechanism_size, mechanism_noise, mechanism_scan, mechanism_portrait, convergence,
           coverage, frequency, effort)
STUDY_TITLE = "Three disks: time to a given error"
STUDY_MODULES = (errors, effort)


def options():
    parser = argparse.ArgumentParser(prog="tools/studies/ratchet.sh", description="Runs the decks of inputs/paper and "
                                     "draws the figures of the paper into one HTML page. What is finished is not run again.")
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
    parser.add_argument("--draw", action="store_true", help="run nothing, draw what is there; without results from "
                                                            "docs/studies/data alone")
    parser.add_argument("--keep", metavar="DIR", help="copy claims, numbers and figures to DIR/paper.md (--errors: "
                        "DIR/errors.md) and DIR/figures (docs/studies, when they are to stay with the sources)")
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
    page = Page(results.folder, "report.html" if results.level == "default" else f"report-{results.level}.html",
                results.store)
    found = collect(results, modules or (STUDY_MODULES if study else MODULES))
    if not study:
        LOG.clear()
        rest = statements.sections(results, [claim for section in found for claim in section.claims])
        assign(rest, results.store.used)
        found = summary.sections(rest + found) + rest + found
    claims = [claim for section in found for claim in section.claims]
    counts = {word: sum(c.verdict == word and c.kind == PAPER for c in claims) for word in WORDS}
    for section in found:
        page.add(section)
    title = STUDY_TITLE if study else TITLE
    page.write(title, head(results, found, counts))
    text = page.path[:-len(".html")] + ".md"
    markdown.write(text, title, lead(results), found, data="data-" + results.level)
    if keep:
        keep_all(results, keep, text, found, "errors.md" if study else "paper.md", "figures")
        if not study:
            verdicts.write(keep, claims, results.all_made_by())
    return page.path, counts


def collect(results, modules):
    """Sections of all modules, each with the names of the numbers behind it."""
    found = []
    for module in modules:
        LOG.clear()
        try:
            sections = module.sections(results)
            assign(sections, results.store.used)
            found += sections
        except Exception as error:  # one figure that fails must not take the others with it
            if results.strict:
                raise
            results.failed.append(f"figures of {module.__name__}: {type(error).__name__}: {error}")
    return found


def keep_all(results, folder, text, sections, name, pictures):
    """Page, figures and numbers go to where they stay: folder/name, folder/pictures, folder/data."""
    markdown.keep(folder, text, [figure.name for section in sections for figure in section.figures], name, pictures,
                  f"data/{results.page}")
    results.store.keep(os.path.join(folder, "data", results.page), sections, not results.failed)


def head(results, sections, counts):
    missing = list(dict.fromkeys(line for section in sections for line in section.missing))
    lines = ["<p>Model and statements: G. G. Peraza-Mues and C. F. Moukarzel, <i>Sustained rotation in a vibrated disk "
             "with asymmetric supports</i>. All numbers are in the paper's units, <i>R</i> = <i>mg</i> = 1, <i>g</i> "
             "= 10; error bars are single standard errors. Every verdict is computed from the numbers beside it.</p>",
             f"<p><b>Level: {results.level}</b> &ndash; {levels.DESCRIPTIONS[results.level]}.</p>", "<p>"
             + ", ".join(f"{counts[word]} " f"{badge(word)}" for word in WORDS) + "</p>"]
    if missing:
        lines.append(missing_list(missing))
    if results.failed:
        lines.append('<div class="missing"><p>What went wrong:</p><ul>' +
                     "".join(f"<li>{escape(line)}</li>" for line in results.failed) + "</ul></div>")
    made_at = time.strftime("%Y-%m-%d %H:%M", time.gmtime())
    lines.append(f'<p class="small">{effort.told(results, html=True)} Drawn {made_at} UTC{from_kept(results)}. The '
                 "figures lie beside this page as PDF and PNG, the tables as CSV.</p>")
    return "\n".join(lines)


def from_kept(results):
    """What was not computed here."""
    names = results.store.from_kept
    return f" from {len(names)} of {len(results.store.used)} tables of docs/studies/data/{results.page}" if names else ""


def made(results):
    """How long it took, and who computed it."""
    return effort.told(results) or f"Made by {results.made_by()}."


def lead(results):
    """What stands above the Markdown."""
    if results.level in levels.STUDIES:
        return [f"`tools/studies/ratchet.sh --errors`: {levels.DESCRIPTIONS[results.level]}."]
    return [markdown.text_of(
        "Model and statements: G. G. Peraza-Mues and C. F. Moukarzel, <i>Sustained rotation in a vibrated disk with "
        "asymmetric supports</i>. <i>R</i> = <i>mg</i> = 1, <i>g</i> = 10; error bars are single standard errors. "
        "Every verdict is "
        'computed from the numbers beside it: <a href="reproduce.md">reproduce.md</a> has the rules. Written by '
        f"<code>tools/studies/ratchet.sh</code>, level {results.level}: {levels.DESCRIPTIONS[results.level]}. "
        + ('Programs, machines and time: <a href="#what-it-took">what it took</a>.' if effort.told(results)
           else escape(made(results))))]


def escape(text):
    return text.replace("&", "&amp;").replace("<", "&lt;").replace(">", "&gt;")


def main():
    args = options()
    results = Results(args.folder, args.level, args.program, args.jobs, dry=args.draw,
                      kept=os.path.join(ROOT, "docs", "studies", "data"))
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
