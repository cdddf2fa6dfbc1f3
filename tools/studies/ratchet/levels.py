"""What is run at which level: the one table to change.

A sweep is a deck of inputs/paper; the deck as it stands is the level "full" (or a study's). `points` thins out or
extends the sweep (it changes which points there are, not what a point is), `keys` change the points themselves.
Results of points whose deck is unchanged lie in a folder that levels share, so that --full goes on from the default.
"""
import dataclasses

LEVELS = ("quick", "default", "full")
STUDIES = ("errors", "errors-quick")  # runs and pages of their own: errors.py
DESCRIPTIONS = {
    "quick": "a coarse look: large time steps, short runs, few points. Error bars are more than twice those of the "
             "paper's length, and slow transients may not be over",
    "default": "random vibration at the paper's length (5&times;10<sup>8</sup> steps of 10<sup>&minus;6</sup>) at a "
               "part of its points; periodic drive at all points with a time step of 10<sup>&minus;5</sup>, and at "
               "four points at the paper's length",
    "full": "the paper's whole campaign: 5&times;10<sup>8</sup> steps of 10<sup>&minus;6</sup> at each of its points, "
            "and a second run of that length at points of the tilt curve, as far as the table of its points says",
    "errors": "how far time step and noise interval can be raised, and what it buys",
    "errors-quick": "the same, so short that it only shows that everything works",
}


@dataclasses.dataclass(frozen=True)
class Plan:
    keys: dict = dataclasses.field(default_factory=dict)    # -D of every point
    points: dict = dataclasses.field(default_factory=dict)  # -D of the group sweep


AS_IS = Plan()

COARSE = {"dt": 2e-5, "phases.measure.time": 100}        # random
COARSE_TURN = {"dt": 2e-5, "phases.measure.time": 30}    # periodic
TURN = {"dt": 1e-5, "phases.measure.time": 60}           # 17 relaxation times at Theta_b = 0.1, dt shown to be enough
HALF_EPS = {"sweep[0].parameters.eps_b.values": "(2e-5, 4e-5, 6e-5, 8e-5, 1e-4)"}
FEWER_EPS = {"sweep[0].parameters.eps_b.values": "(2e-5, 6e-5, 1e-4)",
             "sweep[1].parameters.eps_b.values": "(2e-5, 6e-5, 1e-4)",
             "sweep[1].parameters.tilt.values": '(0, "0.01 pi", "0.02 pi", "0.04 pi", "0.06 pi", "0.08 pi", "0.1 pi")'}
LONG = {"sweep.parameters.theta_b.values": "(0.04, 0.1)", "sweep.parameters.tilt.values": '("0.04 pi")'}
FEW_TILTS = {"sweep.parameters.tilt.values": '(0, "0.02 pi", "0.04 pi", "0.06 pi", "0.08 pi")'}
FEWER_STIFF = {f"sweep.parameters.{name}.values": values for name, values in (
    ("k_n", "(1e3, 4e3, 1e6)"), ("gamma_n", '(10, 20, "sqrt(1e5)")'), ("k_t", "(1e6, 1e6, 1e7)"))}
NO_FINE = "(2e-5, 1e-5, 5e-6)"

TWICE = {"sweep[1].replicas": 2}  # of the tilt curve; the first of each is the point of "random"
# Time step: eight realisations of the noise, a full vector, each shorter than the deck's one.
NOISES = Plan({"phases.measure.time": 100}, {"sweep.parameters.noise.values": "(1, 2, 3, 4, 5, 6, 7, 8)"})
FEW_SEEDS = {"sweep.parameters.noise.values": "(1, 2, 3)"}

SHORTER = {"sweep.parameters.length.values": "(25, 100)"}  # coverage
WIDE = {"dt": 5e-5}  # of its time step: all seeds have the same
SHORT = {"phases.measure.time": 20}  # random, mechanism
ONE_EPS = {f"sweep[{k}].parameters.eps_b.values": "(1e-4)" for k in (0, 1)}


FEW_FIELDS = {"sweep.parameters.omega_b.values": '("10 pi", "20 pi", "30 pi")',  # of the map
              "sweep.parameters.k_n.values": "(1e3, 1e5)", "sweep.parameters.gamma_n.values": "(10, 100)"}


def replicas(grids, number):
    """So many replicas in each of the first grids of a sweep."""
    return {f"sweep[{k}].replicas": number for k in range(grids)}


# name: (deck, {level: plan}); without a level it is not run there. The paper's figures first.
SWEEPS = {
    "sync": ("sync.cfg", {"quick": Plan(COARSE_TURN, FEW_TILTS), "default": Plan(TURN), "full": AS_IS}),
    "async": ("async.cfg", {"quick": Plan(COARSE_TURN, FEW_TILTS), "default": Plan(TURN), "full": AS_IS}),
    "random": ("random.cfg", {"quick": Plan(COARSE, FEWER_EPS), "default": Plan({}, HALF_EPS), "full": AS_IS}),
    "random_replicas": ("random.cfg", {"full": Plan({}, TWICE)}),
    "sync_long": ("sync.cfg", {"default": Plan({}, LONG)}),  # at level full these are among the points of "sync"
    "async_long": ("async.cfg", {"default": Plan({}, LONG)}),
    "phase": ("phase.cfg", {"quick": Plan(COARSE_TURN), "default": AS_IS, "full": AS_IS}),
    "waveform": ("waveform.cfg", {"quick": Plan(COARSE_TURN), "default": AS_IS, "full": AS_IS}),
    "waveform_stiff": ("waveform_stiff.cfg", {"quick": Plan({"dt": 5e-6, "phases.measure.time": 10}, FEWER_STIFF),
                                              "default": AS_IS, "full": AS_IS}),
    "frequency": ("frequency.cfg", {"quick": Plan(COARSE_TURN), "default": AS_IS, "full": AS_IS}),
    "frequency_random": ("frequency_random.cfg", {"quick": Plan(COARSE), "default": AS_IS, "full": AS_IS}),
    "level": ("level.cfg", {"quick": Plan(COARSE, {"sweep.replicas": 2}), "default": AS_IS, "full": AS_IS}),
    "rare": ("rare.cfg", {"quick": Plan(COARSE, {"sweep.replicas": 1}), "default": AS_IS, "full": AS_IS}),
    "bouncing": ("bouncing.cfg", {"quick": Plan(COARSE, {"sweep.replicas": 1}), "default": AS_IS, "full": AS_IS}),
    "step_turning": ("step_turning.cfg", {
        "quick": Plan({"phases.measure.time": 30}, {"sweep.parameters.dt.values": NO_FINE}),
        "default": AS_IS, "full": AS_IS}),
    "seeds": ("seeds.cfg", {"quick": Plan(COARSE), "default": AS_IS,
                            "full": Plan({}, {"sweep.replicas": 32})}),
    "interval": ("interval.cfg", {"quick": Plan(COARSE, {"sweep.replicas": 1}), "default": AS_IS,
                                  "full": Plan({}, {"sweep.replicas": 8})}),
    "step": ("step.cfg", {
        "quick": Plan({"phases.measure.time": 50}, {"sweep.parameters.dt.values": NO_FINE}),
        "default": NOISES, "full": NOISES}),
    "coverage": ("coverage.cfg", {"quick": Plan(WIDE, {**SHORTER, "sweep.replicas": 20}), "default": Plan(WIDE, SHORTER),
                                  "full": Plan(WIDE)}),
    "mechanism_scan_turning": ("mechanism_scan_turning.cfg", {"quick": Plan({"phases.measure.time": 20}),
                                                              "default": AS_IS,
                                                              "full": AS_IS}),
    "mechanism_scan": ("mechanism_scan.cfg", {"quick": Plan(SHORT, replicas(6, 2)),
                                              "default": Plan({}, replicas(6, 4)), "full": AS_IS}),
    "mechanism_noise": ("mechanism_noise.cfg", {"quick": Plan(SHORT, {**replicas(2, 1), **ONE_EPS}),
                                                "default": AS_IS, "full": AS_IS}),
    "mechanism_rotation": ("mechanism_rotation.cfg", {"quick": Plan(SHORT, replicas(3, 2)), "default": AS_IS,
                                                      "full": AS_IS}),
    "mechanism": ("mechanism.cfg", {"quick": Plan(SHORT, replicas(4, 2)), "default": AS_IS, "full": AS_IS}),
    "mechanism_turning": ("mechanism_turning.cfg", {"quick": Plan({"phases.rest.time": 10, "phases.measure.time": 5}),
                                                    "default": AS_IS, "full": AS_IS}),
    "map": ("map.cfg", {"quick": Plan({"dt": 2e-5, "phases.measure.time": 30}, FEW_FIELDS), "default": AS_IS,
                        "full": AS_IS}),
    "longer": ("longer.cfg", {"quick": Plan({"phases.measure.time": 50}, replicas(1, 1)), "default": AS_IS,
                              "full": AS_IS}),
    "rarer": ("rarer.cfg", {"quick": Plan({"phases.measure.time": 50}, {"sweep.replicas": 1}), "default": AS_IS,
                            "full": AS_IS}),
    "correlation": ("correlation.cfg", {"quick": Plan({"phases.measure.time": 2}), "default": AS_IS, "full": AS_IS}),
    "error_turning": ("error_turning.cfg", {"errors": AS_IS, "errors-quick": Plan(
        {"phases.measure.time": 25}, {"sweep.parameters.dt.values": "(1e-5, 2e-5, 5e-5, 1e-4, 2e-4)"})}),
    "error_step": ("error_step.cfg", {"errors": AS_IS, "errors-quick": Plan(
        {"phases.measure.time": 10}, {"sweep.parameters.dt.values": "(2e-5, 5e-5, 1e-4, 2e-4)",
                                      "sweep.parameters.interval.values": "(10, 4, 2, 1)", **FEW_SEEDS})}),
    "error_both": ("error_both.cfg", {"errors": AS_IS, "errors-quick": Plan(
        {"phases.measure.time": 20}, {"sweep.parameters.dt.values": "(2e-5, 5e-5, 1e-4, 2e-4)", **FEW_SEEDS})}),
    "error_interval": ("error_interval.cfg", {"errors": AS_IS, "errors-quick": Plan(
        {"phases.measure.time": 20}, {"sweep.parameters.interval.values": "(1, 10, 100, 1000)", **FEW_SEEDS})}),
}

# Single runs: name: (deck, {level: keys}, {keys at all levels}). Frames and contact tables are dense: they are short.
# The longest first: then no core waits long for the last.
_FINE = {"dt": 1e-6, "phases.rest.time": 40, "phases.measure.time": 0.2, "phases.measure.frames": 100,
         "phases.measure.contacts": 100}
_ROUGH = {"dt": 1e-5, "phases.rest.time": 20, "phases.measure.time": 0.2, "phases.measure.frames": 10,
          "phases.measure.contacts": 10}
_WAVE = {"quick": _ROUGH, "default": _FINE, "full": _FINE}
# The first 20 time units (200 periods) are over before anything is stored: the start's own drift has died out.
_OSCILLATOR = {"phases.rest.motions": "(0)", "phases.rest.time": 20, "phases.measure.time": 5,
               "phases.measure.frames": 200, "phases.measure.contacts": 200}


def _in_phase(theta_b, wave="parabolic"):
    return {"phases.rest.motions": "(0)", "motions[*].amplitude": theta_b, "motions[*].type": wave}


def _opposite(theta_b, wave="parabolic"):
    return {"phases.rest.motions": "(0, 1)", "motions[*].amplitude": theta_b, "motions[*].type": wave}


WEAK_DRIVE, STRONG_DRIVE = 0.002, 0.04  # Theta_b of figures sync and async
SOFT = {"materials[0].k_t": 20}  # elastic branches as long as the excursions
_ROUGH_EPO = {"dt": 1e-5, "phases.measure.frames": 20, "phases.measure.contacts": 20}
_EPO = {"quick": _ROUGH_EPO, "default": {}, "full": {}}
_SETTLED = {"phases.settle.time": 10}
_FROZEN = {"quick": {"dt": 1e-5, "phases.settle.time": 10, "phases.measure.time": 10}, "default": _SETTLED,
           "full": _SETTLED}
_WEAK = {"quick": {"dt": 1e-5, "phases.settle.time": 2, "phases.measure.time": 10}, "default": {}, "full": {}}
_STEADY = {"quick": {"dt": 1e-5, "phases.settle.time": 3, "phases.measure.time": 1}, "default": {}, "full": {}}


def _steady(left, right):
    return {"motions.left.velocity": left, "motions.right.velocity": right}


# Starts of the upper disk: none, and two with another spin and angle. Both supports turn for 60 time units first.
_SEEN = {"dt": 1e-5, "phases.rest.time": 60, "phases.measure.time": 0.3, "phases.measure.frames": 10}
_STARTS = {"quick": {**_SEEN, "phases.rest.time": 30}, "default": _SEEN, "full": _SEEN}
STARTS = {"rest": (0, 0), "left": (3, 1), "right": (-3, 2)}  # name: (spin, angle)
_CAUGHT = {"locks": "()", "dt": 2e-6, "phases.settle.time": 0.2, "phases.measure.time": 0.8,
           "phases.measure.frames": 40,
           "phases.measure.contacts": 40}
# The upper disk where frozen.cfg has it, with its centre locked; it has not caught up with the supports yet.
_FIXED = {"disks.upper.x": -0.000349899375, "disks.upper.y": -0.000664011148035,
          "locks[0].coordinates": '("x", "y")', "dt": 1e-5, "phases.settle.time": 0.12, "phases.measure.time": 0.05}
_WAVE_SLOW = {level: {**keys, "phases.measure.time": 0.4} for level, keys in _WAVE.items()}  # of half the frequency
_RANDOM_EPO = {"quick": {"phases.measure.time": 50}, "default": {}, "full": {}}
_ALWAYS = {"quick": {}, "default": {}, "full": {}}


def _start(spin, angle):
    return {"disks.upper.omega": spin, "disks.upper.theta": angle}


RUNS = {
    "epo_random": ("epo/random.cfg", _RANDOM_EPO, {}),
    "sync_weak": ("three_disk/sync.cfg", _WAVE, _in_phase(WEAK_DRIVE)),
    "sync_strong": ("three_disk/sync.cfg", _WAVE, _in_phase(STRONG_DRIVE)),
    "sync_sine": ("three_disk/sync.cfg", _WAVE, _in_phase(STRONG_DRIVE, "harmonic")),
    "async_weak": ("three_disk/async.cfg", _WAVE, _opposite(WEAK_DRIVE)),
    "async_strong": ("three_disk/async.cfg", _WAVE, _opposite(STRONG_DRIVE)),
    "async_sine": ("three_disk/async.cfg", _WAVE, _opposite(STRONG_DRIVE, "harmonic")),
    "portrait_random": ("three_disk/random.cfg", {level: {} for level in LEVELS},
                        {"dt": 1e-5, "phases.settle.time": 2, "phases.measure.time": 0.2,
                         "phases.measure.frames": 10, "phases.measure.contacts": 10}),
    "epo_symmetric": ("epo/symmetric.cfg", _EPO, _OSCILLATOR),
    "epo_asymmetric": ("epo/asymmetric.cfg", _EPO, _OSCILLATOR),
    "epo_soft_symmetric": ("epo/symmetric.cfg", _EPO, {**_OSCILLATOR, **SOFT}),
    "epo_soft_asymmetric": ("epo/asymmetric.cfg", _EPO, {**_OSCILLATOR, **SOFT}),
    "frozen": ("three_disk/frozen.cfg", _FROZEN, {}),
    "weak": ("three_disk/weak.cfg", _WEAK, {}),
    "steady_pp": ("three_disk/steady.cfg", _STEADY, _steady(-1, -1)),
    "steady_pm": ("three_disk/steady.cfg", _STEADY, _steady(-1, 1)),
    "steady_mp": ("three_disk/steady.cfg", _STEADY, _steady(1, -1)),
    "steady_mm": ("three_disk/steady.cfg", _STEADY, _steady(1, 1)),
    **{f"start_sync_{name}": ("three_disk/sync.cfg", _STARTS, {**_in_phase(STRONG_DRIVE), **_start(*start)})
       for name, start in STARTS.items()},
    **{f"start_async_{name}": ("three_disk/async.cfg", _STARTS, {**_opposite(STRONG_DRIVE), **_start(*start)})
       for name, start in STARTS.items()},
    **{f"fixed_{name}": ("three_disk/steady.cfg", _ALWAYS, {**_steady(*senses), **_FIXED})
       for name, senses in (("pp", (-1, -1)), ("pm", (-1, 1)))},
    "async_slow": ("three_disk/async.cfg", _WAVE_SLOW, {**_opposite(STRONG_DRIVE), "motions[*].omega": '"10 pi"'}),
    "catch_up": ("three_disk/steady.cfg", _ALWAYS, _CAUGHT),
    "loop_paper": ("paper/loop.cfg", _ALWAYS, {}),
    "loop_conservative": ("paper/loop.cfg", _ALWAYS, {"contact_variant": "conservative"}),
}
