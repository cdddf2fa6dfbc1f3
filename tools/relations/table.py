"""The relations, a row each."""
import dataclasses
import traceback

from . import balance, decks, files, shapes, symmetries, watch, ways


@dataclasses.dataclass
class Relation:
    name: str
    test: object      # test(seed) raises Wrong or Refused
    cost: int = 1     # 4: it runs the program

    def what(self):
        return self.test.__doc__.split("\n")[0].rstrip(".")


CHEAP = (symmetries.mirror, symmetries.quarter, symmetries.shift, symmetries.images, symmetries.order, symmetries.phases,
         symmetries.zero, symmetries.attraction, symmetries.idle, symmetries.boost, symmetries.reverse, symmetries.rain, balance.balance,
         shapes.straight_walls, shapes.joined_walls, shapes.round_walls, ways.later, ways.forced, ways.lone, ways.budget, ways.loaded)
DEAR = (files.written, files.taken_over, files.exported, files.lanes, files.stress)  # they run the program
# Not yet: they are tried when they are named.
LATER = ()
RELATIONS = {f.__name__: Relation(f.__name__, f, cost) for functions, cost in ((CHEAP, 1), (DEAR, 4), (LATER, 1)) for f in functions}


def attempt(name, seed):
    """("held", "refused" or "wrong", what was said, the last deck that was made)"""
    decks.LAST = None
    try:
        RELATIONS[name].test(seed)
    except watch.Refused as refused:
        return "refused", str(refused).splitlines()[0], decks.LAST
    except watch.Wrong as wrong:
        return "wrong", str(wrong), decks.LAST
    except Exception:  # any other failure is one of the trial, too
        return "wrong", traceback.format_exc(limit=-2), decks.LAST
    return "held", "", decks.LAST


def again(name, seed):
    """The command that repeats a trial."""
    return f"tools/relations.sh {name} --first {seed} --count 1 --deck"


def usual():
    """Names of the relations that hold."""
    return [name for name, relation in RELATIONS.items() if relation.test not in LATER]
