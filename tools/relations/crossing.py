"""The product of features and ways to run: decks of tools/relations/decks.py, which build/release/tests/ways runs in every way and compares
bit by bit.

    python3 -m relations.crossing --count 1000      (in tools; or tools/soak.sh crossing)

The same number gives the same deck. Deck number n has feature n modulo their count. The table counts, of every feature and way, the
decks that the way took and those that it left."""
import argparse
import collections
import pathlib
import random
import subprocess
import sys
import tempfile

from soak import results

from . import decks, watch

FEATURES = [(dimension, row) for dimension, rows in decks.FEATURES.items() for row in rows]
ADDED = tuple(dimension for dimension in decks.FEATURES if dimension not in decks.ORDER)
FEW, SOME, MANY = (2, 1), (3, 3), (4, 11)  # for lanes, for all, and enough for windows of steps with chunks of 8 disks


def but(dimension, *names):
    return tuple(name for name in decks.FEATURES[dimension] if name not in names)


SUIT = {  # what lanes of small systems and windows of steps take, if motions are slow beside the margin of the lists
    FEW: {"field": ("none",), "box": ("open",), "walls": ("none", "drum", "pillar"), "bodies": ("free", "held", "forces", "inertia"),
          "motion": but("motion", "load", "servo", "lead", "lead a clump", "belt")},
    SOME: {},
    MANY: {"field": ("none",), "bodies": but("bodies", "clumps"), "motion": but("motion", "load", "servo", "lead", "lead a clump")}}
FEW_ADDED = {"measure": ("none", "single disks"), "phases": ("none", "settle", "until"), "bounds": ("none", "report")}


def slow_down(deck):
    for motion in deck.get("motions", ()):
        for key in "velocity", "amplitude", "factor":
            if key in motion:
                motion[key] *= 0.05


def make(seed):
    """The deck of a number: it has feature number seed modulo their count."""
    dimension, row = FEATURES[seed % len(FEATURES)]
    r = random.Random(f"crossing-{seed}")
    for _ in range(50):
        shape = r.choice((FEW, SOME, MANY, MANY))
        some = FEW_ADDED if shape == FEW else decks.FEATURES
        only = {name: ("none", *some.get(name, ())) if r.random() < 0.4 else ("none",) for name in ADDED}
        only[dimension] = (row,)
        suited = decks.joined(only, SUIT[shape])
        try:
            made = decks.make(r.randrange(10**9), suited or only, shape)
        except ValueError:
            continue
        if suited and shape == MANY:
            slow_down(made.deck)
        return made
    raise ValueError(f"nothing suits {dimension}: {row}")


ROUNDS = 2  # of one deck for each feature; only the first of them is run by several threads, too, which wait for each other on busy machines


def run_ways(build, words, decks_of):
    """Lines (deck's number, way, what came of it)."""
    done = subprocess.run([build / "tests" / "ways", *words, *decks_of], stdout=subprocess.PIPE, text=True)
    for line in done.stdout.splitlines():
        path, way, outcome = line.split("\t")
        yield int(pathlib.Path(path).stem), way, outcome
    if done.returncode not in (0, 1):
        raise RuntimeError(f"ways ended with {done.returncode}")


def results_of(folder, seeds):
    """Results in every way in which runs go that write them, in place of their names: same, or what differs."""
    plain = {}
    for seed, way, outcome in run_ways(watch.BUILD, ["--results"], [folder / f"{seed}.cfg" for seed in seeds]):
        if outcome.endswith(".h5"):
            content = results.content(outcome)
            differs = results.differences(plain.setdefault(seed, content), content, ("parameters@",))
            outcome = f"wrong: {', '.join(differs[:5])}" if differs else "same"
        yield seed, way, outcome


def ways(folder, seeds, others=()):
    """Lines (seed, features, way, what came of it) of these decks. others: builds that must give the same bits as the first."""
    has, hashes = {}, {}
    for seed in seeds:
        made = make(seed)
        has[seed] = made.has
        (folder / f"{seed}.cfg").write_text(made.text(watch.slipdisk.deck_text))
    threaded = [seed for seed in seeds if seed // len(FEATURES) % ROUNDS == 0]
    for words, some in ([], threaded), (["--alone"], [seed for seed in seeds if seed not in threaded]):
        for seed, way, outcome in run_ways(watch.BUILD, words, [folder / f"{seed}.cfg" for seed in some]):
            if way == "plain":
                hashes[seed] = outcome
            yield seed, has[seed], way, outcome
    for seed, way, outcome in results_of(folder, [seed for seed in seeds if seed in threaded or has[seed]["outputs"] != "none"]):
        yield seed, has[seed], way, outcome
    for other in others:
        for seed, way, outcome in run_ways(pathlib.Path(other), ["--alone"], [folder / f"{seed}.cfg" for seed in seeds]):
            if way == "plain" and outcome != hashes[seed]:
                outcome = f"wrong: {outcome} for {hashes[seed]}"
            yield seed, has[seed], f"{pathlib.Path(other).name}: {way}", outcome


def product(seeds, others=(), block=50):
    """({(feature, way): Counter of same, left, wrong}, lines of what was wrong)"""
    cells, wrong = collections.defaultdict(collections.Counter), []
    seeds = list(seeds)
    for at in range(0, len(seeds), block):
        with tempfile.TemporaryDirectory(prefix="slipdisk-crossing-") as folder:
            for seed, has, way, outcome in ways(pathlib.Path(folder), seeds[at:at + block], others):
                kind, _, said = outcome.partition(": ")
                if kind == "wrong":
                    wrong.append(f"deck {seed}, {way}: {said}\n  {has}\n  cd tools; python3 -m relations.crossing --first {seed} --deck")
                for feature in has.items():
                    cells[feature, way]["said nothing" if kind == "left" and not said else kind] += 1
    return cells, wrong


def table(cells):
    """Text: a row of each feature, a column of each way, taken/left."""
    names = list(dict.fromkeys(way for _, way in cells))
    lines = [" " * 34 + " ".join(f"{k:>7}" for k in range(len(names)))]
    for feature in FEATURES:
        counts = [cells.get((feature, way), collections.Counter()) for way in names]
        lines.append(f"{': '.join(feature):<34}" + " ".join(f"{c['same']:>3}/{c['left']:<3}" for c in counts))
    return "\n".join(lines + [f"{k}: {name}" for k, name in enumerate(names)])


def main():
    parser = argparse.ArgumentParser(prog="python3 -m relations.crossing", description=__doc__.split("\n")[0])
    parser.add_argument("--first", type=int, default=0, metavar="N", help="number of the first deck (0)")
    parser.add_argument("--count", type=int, default=2 * len(FEATURES), metavar="N", help="decks (two of each feature)")
    parser.add_argument("--build", action="append", default=[], metavar="DIR",
                        help="another build, which must give the same bits (as build/clang, build/dev); may be repeated")
    parser.add_argument("--deck", action="store_true", help="print the first deck, and stop")
    args = parser.parse_args()
    if args.deck:
        print(make(args.first).text(watch.slipdisk.deck_text))
        return 0
    cells, wrong = product(range(args.first, args.first + args.count), args.build)
    print(table(cells))
    print(*wrong, sep="\n")
    print(f"{args.count} tried {len(wrong)} failed")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
