"""python3 -m relations; called by tools/relations.sh and tools/soak.sh."""
import argparse
import collections
import json
import sys

from . import watch
from .table import RELATIONS, again, attempt, usual


def options(words=None):
    parser = argparse.ArgumentParser(prog="tools/relations.sh", description="Relations that must hold whatever the deck.")
    parser.add_argument("relations", nargs="*", metavar="RELATION", help="only these (all): " + ", ".join(RELATIONS))
    parser.add_argument("--list", action="store_true", help="say what each is, and stop")
    parser.add_argument("--first", type=int, default=0, metavar="N", help="number of the first deck (0)")
    parser.add_argument("--count", type=int, default=20, metavar="N", help="decks of each relation (20)")
    parser.add_argument("--deck", action="store_true", help="print the deck with which one failed")
    parser.add_argument("--json", action="store_true", help="a line for each trial, for programs")
    args = parser.parse_args(words)
    for name in args.relations:
        if name not in RELATIONS:
            parser.error(f"there is no relation {name}; there are {', '.join(RELATIONS)}")
    return args


def report(args, name, seed, outcome):
    what, said, made = outcome
    if args.json:
        print(json.dumps({"relation": name, "seed": seed, "outcome": what, "said": said,
                          "has": made.has if made else {}}), flush=True)
    elif what == "wrong":
        print(f"{name} {seed}: {said}\n  {made.has if made else ''}\n  {again(name, seed)}", flush=True)
        if args.deck and made:
            print(watch.slipdisk.deck_text(made.deck))


def main():
    args = options()
    if args.list:
        for relation in RELATIONS.values():
            print(f"{relation.name:<16} {relation.what()}")
        return 0
    failed = 0
    for name in args.relations or usual():
        found = collections.Counter()
        for seed in range(args.first, args.first + args.count):
            if args.json:
                print(json.dumps({"relation": name, "seed": seed, "outcome": "begun"}), flush=True)
            outcome = attempt(name, seed)
            found[outcome[0]] += 1
            report(args, name, seed, outcome)
        failed += found["wrong"]
        if not args.json:
            print(f"{name:<16} {args.count:>6} tried {found['wrong']:>6} failed {found['refused']:>6} refused", flush=True)
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
