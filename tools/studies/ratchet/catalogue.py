"""All statements of the paper that can be checked, in its order: the one list of what the report has to judge.

A module that judges one takes its sentence from here, as in `zero(values=..., errors=...,
                                                                   **paper("random-level"))`. One
that no module judges stands on the page all the same, without data.
"""
from .verdict import PAPER, TRIVIAL, missing

NEEDS = "needs the sweeps of the mechanism"
ELSEWHERE = "docs/studies/packings_study.md judges it"
VELOCITY, TILT = "section 3, fig. random-ex-vel", "section 3, fig. random-ex-tilt"
EPO, ANALYSIS = "section 4, fig. epo-force", "section 4"
IN_PHASE, OPPOSITE = "section 4.1", "section 4.2"
SYNC, ASYNC = "section 4.1, fig. sync-vel", "section 4.2, fig. async-vel"
S_PP, S_PM, S_MP, S_MM = (f"S<sup>{signs}</sup>" for signs in ("++", "+&minus;", "&minus;+", "&minus;&minus;"))
TORQUE = "With both contacts sliding steadily in {} the torque is {}."

# slug, kind, place, sentence in own words, why there are no data (when no module has any)
STATEMENTS = (
    ("forces-never-zero", PAPER, "section 1", "Under gentle driving (amplitudes and tilts of the figures) the normal "
                                              "forces are never zero.", ""),
    ("bouncing-rotation", PAPER, "section 1", "The upper disk rotates persistently when it bounces on its supports, "
                                              "too.",
     ""),
    ("bouncing-process", PAPER, "section 1", "Bouncing, it rotates by another process: where contacts are open most of "
                                             "the time the sense is another one.", ""),
    ("aperture", TRIVIAL, "section 2", "The contact lines make an angle &alpha;<sub>1</sub> + &alpha;<sub>2</sub> = "
                                       "&pi;/3.",
     ""),
    ("tilt", TRIVIAL, "section 2", "The tilt is half the difference of the contact angles, (&alpha;<sub>2</sub> "
                                   "&minus; &alpha;<sub>1</sub>)/2.", ""),
    ("depends-mu", PAPER, "section 2", "&Omega; depends on the friction coefficient.", ""),
    ("depends-kn", PAPER, "section 2", "&Omega; depends on the normal stiffness.", ""),
    ("depends-kt", PAPER, "section 2", "&Omega; depends on the tangential stiffness.", ""),
    ("depends-aperture", PAPER, "section 2", "&Omega; depends on the angle between the contacts.", ""),
    ("cutoff", TRIVIAL, "section 2.1", "The normal force can be zero before the disks part, by the viscous part.", ""),
    ("lambda-path", PAPER, "section 2.2, eq. (4)", "The displacement &lambda; follows from the present positions: on a "
                                                   "closed path without slipping it returns.", ""),
    ("damping-ratio", TRIVIAL, "section 3", "&gamma;/2&radic;(<i>k<sub>n</sub>m</i>) = 0.5: underdamped.", ""),
    ("correlation-time", TRIVIAL, "section 3", "<i>t<sub>c</sub>/t<sub>g</sub></i> = &radic;5/<i>c</i>&omega; &asymp; "
                                               "0.07.",
     ""),
    ("random-level", PAPER, VELOCITY, "Under random vibration the disk does not rotate without tilt.", ""),
    ("random-growth", PAPER, VELOCITY, "At each tilt |&Omega;| grows with the amplitude (as the figure shows).", ""),
    ("random-clockwise", PAPER, TILT, "Under random vibration the rotation is clockwise (&Omega; &lt; 0) at all "
                                      "amplitudes and tilts.", ""),
    ("random-nonmonotonic", PAPER, TILT, "&Omega; depends on the tilt non-monotonically: it has an extremum inside the "
                                         "range.",
     ""),
    ("never-open", PAPER, "section 3", "The upper disk never loses contact with the supports (at the points of the "
                                       "figures).",
     ""),
    ("epo-force", PAPER, EPO, "The oscillator's force changes linearly with the displacement until a limit is reached, "
                              "and is constant while the joint slides.", ""),
    ("epo-symmetric", PAPER, ANALYSIS, "Oscillator with equal limits: no systematic drift.", ""),
    ("epo-diffusion", PAPER, ANALYSIS, "Oscillator with equal limits under random forcing: normal diffusion, "
                                       "&lang;<i>x</i>&sup2;&rang; &prop; <i>t</i>.", ""),
    ("epo-asymmetric", PAPER, ANALYSIS, "Oscillator with unequal limits under harmonic forcing: it drifts towards the "
                                        "smaller one.", ""),
    ("epo-random-drift", PAPER, ANALYSIS, "Oscillator with unequal limits under random forcing: it drifts towards the "
                                          "smaller one.", ""),
    ("random-slides", PAPER, ANALYSIS, "Under random vibration (amplitudes of the figures) the contacts slide most of "
                                       "the time.",
     ""),
    ("rare-sliding", PAPER, ANALYSIS, "Where the supports move with low intensity and sliding is rare, there is no "
                                      "sustained rotation.", ""),
    ("eq38-printed", TRIVIAL, "section 4, eq. (38), (40)", "Equations (38) and (40) as printed, with &minus;<i>mg</i>, "
                                                           "give the torque (15).", ""),
    ("elastic-short", PAPER, ANALYSIS, "Where the supports move much faster than the upper disk turns, elastic "
                                       "deformations last much shorter than a sliding configuration.", NEEDS),
    ("no-sliding", PAPER, "sections 4, 5", "Without sliding there is no rotation.", ""),
    ("tep-pp", PAPER, "section 4, eq. (15)", TORQUE.format(S_PP, "(15)"), ""),
    ("tep-mm", PAPER, "section 4, eq. (16)", TORQUE.format(S_MM, "(16)"), ""),
    ("tep-pm", PAPER, "section 4, eq. (17)", TORQUE.format(S_PM, "(17)"), ""),
    ("tep-mp", PAPER, "section 4, eq. (18)", TORQUE.format(S_MP, "(18)"), ""),
    ("catch-up", PAPER, ANALYSIS, "On supports that go on turning one way the upper disk catches up with them.", ""),
    ("elastic-after", PAPER, ANALYSIS, "After that it performs elastic rotational oscillations: contacts slide no "
                                       "more, and its speed swings about that of the supports.", ""),
    ("premise-velocity", PAPER, ANALYSIS, "Configurations change before the velocity of the upper disk becomes of the "
                                          "order of the supports' (random vibration).", NEEDS),
    ("tep-torque", PAPER, ANALYSIS, "Under random vibration the torque of its equilibrium (TEP) can be used as an "
                                    "estimate of the mean torque in each configuration.", NEEDS),
    ("tep-forces", PAPER, ANALYSIS, "Under random vibration the mean contact forces in each configuration are those of "
                                    "its equilibrium (TEP).", NEEDS),
    ("tep-torque-in-phase", PAPER, "sections 4.1, 4.2", "Turning in phase, strongly, the mean torque of each "
                                                        "configuration is that of its TEP.", NEEDS),
    ("tep-torque-opposite-phases", PAPER, "sections 4.1, 4.2",
     "Turning opposite phases, strongly, the mean torque of each configuration is that of its TEP.", NEEDS),
    ("durations-correlation", PAPER, ANALYSIS, "The duration of each configuration (its correlation time) is "
                                               "proportional to the correlation time of the motion.", NEEDS),
    ("tep-correlation-time", PAPER, ANALYSIS, "The mean torques are the nearer to their TEP values, the longer the "
                                              "correlation time (random vibration of a given velocity).", NEEDS),
    ("short-configurations", PAPER, ANALYSIS, "At very short correlation times the disk does not rotate.", ""),
    ("torque-balance", PAPER, "section 4, eq. (11), (41)", "In the steady state torque times duration, summed over the "
                                                           "configurations with their TEP torques, is zero.", NEEDS),
    ("torque-balance-in-phase", PAPER, "section 4, eq. (41)",
     "With the TEP torques the durations satisfy (41), in phase, strong drive.", NEEDS),
    ("torque-balance-opposite-phases", PAPER, "section 4, eq. (41)",
     "With the TEP torques the durations satisfy (41), opposite phases, strong drive.", NEEDS),
    ("eq11-printed", TRIVIAL, "section 4, eq. (11)", "Equation (11) as printed is the mean torque (its second term has "
                                                     "&Tau;<sup>++</sup> with <i>T</i><sup>&minus;&minus;</sup>).", ""),
    ("level-torques", TRIVIAL, ANALYSIS, "Without tilt &Tau;<sup>++</sup> = &Tau;<sup>&minus;&minus;</sup> and "
                                         "&Tau;<sup>+&minus;</sup> = &Tau;<sup>&minus;+</sup> = 0, as printed.", ""),
    ("equal-durations", PAPER, ANALYSIS, "Without tilt all four configurations last equally long under random "
                                         "vibration.",
     ""),
    ("eq19-printed", TRIVIAL, "section 4, eq. (19)", "Equation (19) as printed is the mean of the four torques "
                                                     "(15)-(18).",
     ""),
    ("eq19-random", PAPER, "section 4, eq. (19)", "The sign of (19) predicts the sense under random vibration.", ""),
    ("frozen", PAPER, ANALYSIS, "With all centres held fixed the upper disk does not rotate, although "
                                "<i>n</i><sub>1</sub> &ne; <i>n</i><sub>2</sub>.", ""),
    ("fixed-limit", PAPER, ANALYSIS, "With all centres held fixed the limit of the torque is &mu;(<i>n</i><sub>1</sub> + "
                                     "<i>n</i><sub>2</sub>) in all configurations.", ""),
    ("sense-reverses", PAPER, "sections 4, 5", "The sense of rotation depends on the excitation: in phase and in "
                                               "opposite phases it is not the same.", ""),
    ("parabolas", TRIVIAL, "section 4.1, eq. (21)", "The parabolas agree with the sine at its zeros and extrema and "
                                                    "are close to it in between.", ""),
    ("sync-configurations", PAPER, IN_PHASE, f"In phase {S_PM} and {S_MP} cannot be reached.", ""),
    ("sync-period", PAPER, IN_PHASE, "In phase a periodic state is reached whose period is that of the drive.", ""),
    ("sync-start", PAPER, IN_PHASE, "In phase the periodic state is the same regardless of the start.", ""),
    ("sync-sequence-weak", PAPER, "section 4.1, fig. sync", f"In phase, in a period {S_MM} and {S_PP} follow each "
                                                            "other (weak drive).", ""),
    ("sync-sequence-strong", PAPER, "section 4.1, fig. sync",
     f"In phase, in a period {S_MM} and {S_PP} follow each other (strong drive).", ""),
    ("sync-straight", PAPER, "section 4.1, fig. sync, eq. (28)",
     "In phase the velocity of the upper disk is piecewise straight and follows (28).", ""),
    ("eq25-printed", TRIVIAL, "section 4.1, eq. (25), (43)", "The times (25) and (43) as printed solve (23) and (24).", ""),
    ("eq28-printed", TRIVIAL, "section 4.1, eq. (28)", "(28) as printed is continuous and has the mean (30).", ""),
    ("sync-durations", PAPER, "section 4.1, eq. (26), (27)",
     "In phase the durations approach (26) and (27) at large &Theta;<sub>b</sub>.", ""),
    ("sync-balance", TRIVIAL, IN_PHASE, "(26) and (27) make the mean torque zero.", ""),
    ("sync-level", PAPER, SYNC, "In phase the disk does not rotate without tilt.", ""),
    ("sync-sign", PAPER, SYNC, "In phase the disk always rotates counter-clockwise (&Omega; &gt; 0).", ""),
    ("sync-approach", PAPER, SYNC, "In phase &Omega; approaches (30) as &Theta;<sub>b</sub> grows.", ""),
    ("sync-excellent", PAPER, SYNC, "In phase the agreement with (30) is excellent at large &Theta;<sub>b</sub>.", ""),
    ("sync-elastic", PAPER, IN_PHASE, "At low amplitudes contacts spend more of the time in the elastic phase (in "
                                      "phase).",
     ""),
    ("eq31-printed", TRIVIAL, "section 4.1, eq. (31)", "Equation (31) as printed is the half sum of (15) and (16).",
     ""),
    ("eq31-sync", PAPER, "section 4.1, eq. (31)", "The sign of (31) predicts the sense in phase (corrected by the "
                                                  "factor &mu; that the print lacks; the sign is the same).", ""),
    ("async-level", PAPER, ASYNC, "In opposite phases the disk does not rotate without tilt.", ""),
    ("async-sign", PAPER, ASYNC, "In opposite phases the disk always rotates clockwise (&Omega; &lt; 0).", ""),
    ("async-configurations", PAPER, OPPOSITE, "In opposite phases all four configurations occur (cycle (32)-(34)).", ""),
    ("random-configurations", PAPER, OPPOSITE, "Under random vibration all four configurations occur.", ""),
    ("async-sequence-weak", PAPER, "section 4.2, fig. async",
     f"In opposite phases, in a period {S_MM}, {S_MP}, {S_PP}, {S_PM} follow each other (weak drive).", ""),
    ("async-straight", PAPER, "section 4.2, fig. async, eq. (34)",
     "In opposite phases the velocity of the upper disk is piecewise straight and follows (34).", ""),
    ("async-period", PAPER, OPPOSITE, "In opposite phases a periodic state is reached whose period is that of the "
                                      "drive.",
     ""),
    ("async-start", PAPER, OPPOSITE, "In opposite phases the periodic state is the same regardless of the start.", ""),
    ("eq35-printed", TRIVIAL, "section 4.2, eq. (35)", "Equation (35) as printed gives &Omega; in opposite phases.", ""),
    ("async-approach", PAPER, ASYNC, "In opposite phases &Omega; approaches (35) as &Theta;<sub>b</sub> grows "
                                     "(corrected by the factor &omega;<sub>b</sub>/&pi; that the print lacks).", ""),
    ("async-excellent", PAPER, ASYNC, "In opposite phases the agreement with (35), so corrected, is excellent at large "
                                      "&Theta;<sub>b</sub>.", ""),
    ("eq19-async", PAPER, OPPOSITE, "The sign of (19) predicts the sense in opposite phases.", ""),
    ("packings", PAPER, "section 5", "In packings that are vibrated from the bottom each disk acquires a rotational "
                                     "velocity.",
     ELSEWHERE),
)
_BY_SLUG = {row[0]: row for row in STATEMENTS}


def paper(slug):
    """Sentence, place, kind and slug of a statement, as the rules take them."""
    _, kind, place, text, _ = _BY_SLUG[slug]
    return {"text": text, "place": place, "slug": slug, "kind": kind}


def complete(claims):
    """One claim for each statement, in the paper's order: those that were judged, and those without data."""
    found = {claim.slug: claim for claim in claims if claim.slug}
    return [found.get(row[0]) or missing(**paper(row[0]), why=row[4] or "no data yet") for row in STATEMENTS]
