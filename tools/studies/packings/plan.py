"""What is run: the one table to change. Decks are those of inputs/packing; `keys` differ from the deck as it stands."""
import dataclasses

from . import alone

LEVELS = ("quick", "default")
DESCRIPTIONS = {
    "quick": "a coarse look: few packings, short runs. Many statements are left undecided",
    "default": "the campaign of docs/studies/packings_study.md, about three hours of one core. The decks ask for 500 s "
               "and ten packings at each point. Low drive is measured for 500 s, moderate drive for 200 s, the sweep of "
               "drives and random vibration for 60 s, with six packings; harmonic against random drive of the same rms "
               "displacement for 500 s with four; disks whose neighbours do not turn for 8 s (20 s at 0.3 <i>g</i>) with "
               "eight",
}


@dataclasses.dataclass(frozen=True)
class Entry:
    deck: str
    # -D at every level; {folder} is where results are, and what a function is given.
    keys: dict = dataclasses.field(default_factory=dict)
    quick: dict = dataclasses.field(default_factory=dict)  # -D at level quick, besides
    sweep: bool = True          # a sweep, else one run
    threads: bool = False       # one run on all cores
    skip_quick: bool = False
    large: bool = False         # only with --large
    first: int = 0              # so many replicas come before the rest of any sweep: there is early something of all
    replicas: str = "sweep.replicas"  # where the deck has their number: sweep[*].replicas of a list of grids


SHORT = {"phases.thermalise.time": 1, "phases.measure.time": 4}
EACH = "sweep[*].replicas"
SIX = {"sweep.replicas": 6}
STIFF = {"materials[0].k_n": 1e6, "materials[0].k_t": 5e5, "materials[0].gamma_n": 3, "dt": 6.25e-6,
         "measure.every": 71}  # 1/50 of the shortest period again
DRIVES = "(0.1, 0.2, 0.3, 0.5, 0.7, 1, 2, 4, 9)"


def _times(thermalise, measure):
    return {"phases.thermalise.time": thermalise, "phases.measure.time": measure}


def _starts(count):
    """Values of `start` in a sweep: so many packings of cage_start.cfg."""
    files = ["base", *(f"r={k}" for k in range(1, count))]
    return "(" + ", ".join(f'"{{folder}}/cage_start/points/{file}.h5"' for file in files) + ")"


def _memory(drive, thermalise, measure, packings, every=1507):
    """One packing with several histories: `packings` of them with the first, two with all."""
    keys = {"constants.drive": drive, **_times(thermalise, measure), "phases.measure.contacts": every,
            "disk_files[0].file": "{folder}/cage_start/points/base.h5", "sweep[*].parameters.start.values": _starts(2)}
    return Entry("cage_memory.cfg", {**keys, "sweep[0].parameters.start.values": _starts(packings)},
                 {**SHORT, "sweep[*].parameters.start.values": _starts(2),
                  "sweep[0].parameters.start.values": _starts(3)})


# The motion of measuring and of what precedes it: random with the same rms displacement.
NOISE = {"phases.thermalise.motions": '"noise"', "phases.measure.motions": '"noise"'}


def _alone(drive, thermalise, measure, packings=8, single=()):
    """All disks of a packing, and those of one set at a time: alone.py."""
    return Entry("cage_alone.cfg", {"constants.drive": drive, **_times(thermalise, measure),
                                    "sweep": lambda folder: alone.grids(folder, packings, single)},
                 {**SHORT, "sweep": lambda folder: alone.grids(folder, 1, single)}, skip_quick=bool(single))


def _records(frames, contacts):
    """Steps between frames, which are at one phase of the floor (at dt = 3e-5, 1250 are three periods of 80 Hz), and
    between tables of contacts, which are at all phases."""
    return {"phases.measure.frames": frames, "phases.measure.contacts": contacts}


_SMALL = {"packings[0].count": 100, "container.width": 15.24, "container.height": 15.24}

# docs/studies/data has columns of disks and contacts of these runs; numbers only of all others.
WITH_DISKS = ("low", "moderate", "drive", "random", "frictionless", "cage", "drum", "quiet", "quiet_random", "quiet_stiff", "quiet_long")

# Cheap and needed by others first.
ENTRIES = {
    "low": Entry("shake_low.cfg", {**_records(125000, 123457), **SIX}, {**SHORT, "sweep.replicas": 2}, first=4),
    "drum": Entry("drum.cfg", {}, {"phases.start.time": 20, "phases.flow.time": 30}, sweep=False),
    "cage": Entry("cage.cfg", {}, SHORT),
    "frictionless": Entry("shake_drive.cfg", {"materials[0].mu": 0, **_times(5, 20), "sweep.replicas": 2,
                                              "sweep.parameters.drive.values": "(0.5, 2, "
                                                  "6)"}, {**SHORT, "sweep.replicas": 1}),
    "drive": Entry("shake_drive.cfg", {**_times(5, 60), **_records(25000, 24691), **SIX,
                                       "sweep.parameters.drive.values": DRIVES},
                   {**SHORT, "sweep.replicas": 2, "sweep.parameters.drive.values": "(0.3, 1, 3)"}, first=2),
    "step": Entry("shake_step.cfg", {}, {"phases.measure.time": 2, "sweep.replicas": 1}, first=1),
    "moderate": Entry("shake_moderate.cfg", {**_times(20, 200), **_records(50000, 49391), **SIX},
                      {**SHORT, "sweep.replicas": 2}, first=3),
    "random": Entry("shake_random.cfg", {**_times(5, 60), **_records(25000, 24691), **SIX,
                                         "sweep.parameters.drive.values": DRIVES},
                    {**SHORT, "sweep.replicas": 2, "sweep.parameters.drive.values": "(0.3, 1, 3)"}, first=2),
    **{name + end: Entry(deck, {replicas: count, **motion}, {**SHORT, replicas: 1}, first=1, replicas=replicas)
       for end, motion in (("", {}), ("_random", NOISE))
       for name, deck, replicas, count in (("scan", "shake_scan.cfg", EACH, 2),
                                           ("size", "shake_size.cfg", "sweep.replicas", 1),
                                           ("prepared", "shake_prepared.cfg", EACH, 2))},
    "hopper": Entry("hopper.cfg", {"container.width": 30, "container.height": 75, "phases.flow.time": 150,
                                   "sweep.parameters.outlet.values": "(4, 5, 6, 7, 8, 10)", "sweep.replicas": 3},
                    {"container.height": 35, "sweep.replicas": 1,
                     "sweep.parameters.outlet.values": "(4, 6, 8, 10)"}, first=1),
    "cage_start": Entry("cage_start.cfg"),
    "cage_moderate": _memory(2, 5, 40, 8),
    "cage_middle": _memory(0.7, 5, 40, 8),
    "cage_low": _memory(0.3, 15, 60, 6),
    "gentle": Entry("cage_gentle.cfg", {"sweep[*].parameters.start.values": _starts(4)},
                    {**SHORT, "sweep[*].parameters.start.values": _starts(1)}),
    **{f"alone_{name}": _alone(drive, *times) for name, drive, *times in (("middle", 0.7, 2, 8), ("moderate", 2, 2, 8),
                                                                         ("low", 0.3, 5, 20))},
    "alone_single": _alone(0.7, 2, 6, 1, single=(0,)),
    **{name: Entry("quiet.cfg", {**_times(20, 200), **_records(125000, 123457), "sweep.replicas": 3, **motion},
                   {**SHORT, "sweep.replicas": 1, "sweep.parameters.drive.values": "(0.05, 0.2)"}, first=2)
       for name, motion in (("quiet", {}), ("quiet_random", NOISE))},
    "quiet_stiff": Entry("quiet.cfg", {**_times(10, 100), **_records(200000, 197531), **STIFF, "sweep.replicas": 3,
                                       "sweep.parameters.drive.values": "(0.05, 0.1)"}, skip_quick=True, first=1),
    "quiet_long": Entry("quiet.cfg", {"sweep.replicas": 2, "sweep.parameters.drive.values": "(0.1)"}, skip_quick=True,
                        first=1),
    "repose": Entry("repose.cfg", {}, {"packings[0].count": 400, "sweep.replicas": 1,
                                       "sweep.parameters.mu.values": "(0.1, 0.5)"}, first=1),
    "jam": Entry("jam.cfg", {"sweep.replicas": 5}, {**_SMALL, "sweep.replicas": 2}, first=1),
    "jam_friction": Entry("jam_friction.cfg", {"sweep.replicas": 5}, {**_SMALL, "sweep.replicas": 2}, first=1),
    "deposit_1e4": Entry("deposit_1e4.cfg", {}, {}, sweep=False, threads=True, skip_quick=True),
    **{name: Entry("shake_1e4.cfg", {"disk_files[0].file": "{folder}/deposit_1e4.h5", **motion}, sweep=False,
                   threads=True, skip_quick=True) for name, motion in (("shake_1e4", {}), ("shake_1e4_random", NOISE))},
    "deposit_1e5": Entry("deposit_1e5.cfg", {}, {}, sweep=False, threads=True, skip_quick=True, large=True),
    "shake_1e5": Entry("shake_1e5.cfg", {"disk_files[0].file": "{folder}/deposit_1e5.h5"}, sweep=False,
                       threads=True, skip_quick=True, large=True),
}
