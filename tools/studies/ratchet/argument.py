"""How the page of the paper begins: what was asked, what holds for which drive, and why.

A paragraph stands on verdicts. When the data turn one of them, the paragraph says so in the place of its text."""
from .page import Section
from .verdict import DEPENDS, NO, OPEN, YES

FIGURES = ("random-ex-tilt", "durations", "fields")  # those that show it; they stand here and not in their sections

# (heading, text with {facts}, {slug: verdict that the text rests on})
PARAGRAPHS = (
    ("What was asked.",
     "A disk lies on two others and is tilted. When the supports vibrate it turns. The paper explains this by sliding: each of the "
     "two contacts slides one way or the other, which makes four configurations S<sup>&plusmn;&plusmn;</sup>. In each the centre of "
     "the upper disk has an equilibrium of its own, the translational equilibrium point (TEP), and friction exerts the torque "
     "(15)-(18) there. With tilt these torques do not cancel; the disk turns so fast that the durations of the configurations "
     "balance them. From this follow senses, (19) and (31), and for supports that turn to and fro two speeds, (30) and (35). Here "
     "the same model runs at the paper's parameters, and each statement is judged by a rule from the numbers. Three drives have to be "
     "told apart: the random vibration of the figures (&epsilon;<sub>b</sub> up to 10<sup>&minus;4</sup>), random turning a "
     "hundred times as strong, and periodic turning.", {}),
    ("What holds for every drive.",
     "Tilted, the disk turns; level, it does not; without sliding it does not; with all centres held fixed it does not. Under random "
     "vibration and in opposite phases it turns clockwise, in phase counter-clockwise. With steady sliding the torques are "
     "(15)-(18). Under random vibration |&Omega;| grows with the amplitude and has its largest value at a tilt inside the range "
     "(first figure).",
     {"random-clockwise": YES, "random-level": YES, "no-sliding": YES, "frozen": YES, "async-sign": YES, "sync-sign": YES,
      "tep-pp": YES, "tep-mm": YES, "tep-pm": YES, "tep-mp": YES, "random-growth": YES, "random-nonmonotonic": YES}),
    ("What holds for strong drives only.",
     "The theory presupposes that a configuration is over before the upper disk is as fast as its supports. In the paper's figures it "
     "is not: &Omega;<sub>rms</sub> = {weak} &epsilon;<sub>b</sub>&omega;. The light disk is dragged along, sticks to one support or "
     "the other for 20 to 90 % of the time, and what the theory says about durations and torques fails: the correlation time of "
     "S<sup>++</sup> goes from {tau_weak} of <i>t<sub>c</sub></i> (second figure), and the torques come no nearer to those of the TEPs "
     "beyond <i>t<sub>c</sub></i> &asymp; 0.06. Supports that only turn, a hundred times as strongly, leave the disk behind "
     "({strong} &epsilon;<sub>b</sub>&omega;): there correlation times are {tau_strong} of <i>t<sub>c</sub></i> at all "
     "frequencies, contacts stick for 1 % of the time, and the torques approach those of the TEPs to 2 %.",
     {"premise-velocity": DEPENDS, "durations-correlation": DEPENDS, "tep-correlation-time": DEPENDS, "elastic-short": YES}),
    ("Why the sense is right all the same.",
     "The TEP torques are within 17 % of the measured ones, and any centre that moves towards its TEP at all gives their order. The "
     "premise of (19), four configurations that last equally long without tilt, is wrong: S<sup>+&minus;</sup> and "
     "S<sup>&minus;+</sup> last about three times as long as S<sup>++</sup> and S<sup>&minus;&minus;</sup>, because the light disk soon "
     "catches up with the slower support and then lies between the two velocities, where only "
     "&mu;(<i>n</i><sub>1</sub> &minus; <i>n</i><sub>2</sub>)<i>R</i> acts. In S<sup>&minus;+</sup> friction carries part of the "
     "weight, in S<sup>+&minus;</sup> it presses the disk down, so that with tilt their two torques leave a clockwise sum; "
     "S<sup>++</sup> and S<sup>&minus;&minus;</sup> leave a smaller counter-clockwise one. The longer the mixed configurations last, the "
     "more the clockwise sum counts: the sense is that of (19) at the paper's aperture, and a drive that never reaches them, in phase, "
     "turns the disk the other way. At apertures above 0.25&pi;, where (19) turns "
     "over, the sense does not; where all four last equally long it does.",
     {"tep-torque": YES, "equal-durations": NO, "eq19-random": YES, "aperture-sign": NO, "aperture-sign-quarter": YES}),
    ("What depends on what the paper does not give.",
     "(30) and (35) are formulae for rigid disks and parabolas. The paper gives neither the frequency of the turning supports nor the "
     "waveform of its simulations. {fields} (third figure). (35) in addition lacks the factor "
     "&omega;<sub>b</sub>/&pi; in print, and lets configurations follow each other that do so at weak drive only.",
     {"sync-excellent": DEPENDS, "async-excellent": DEPENDS, "eq35-printed": NO, "async-configurations": NO}),
    ("What does not hold.",
     "At large amplitude and tilt the lighter contact is unloaded at times, and opens. The TEPs do not give the mean normal forces "
     "under random vibration, nor do their torques balance with the durations. With the centre held fixed the limit of the torque is "
     "not &mu;(<i>n</i><sub>1</sub> + <i>n</i><sub>2</sub>) where the contacts slide oppositely. (19) does not apply to opposite "
     "phases, whose sense is another one than its sign at six apertures of twelve.",
     {"forces-never-zero": NO, "never-open": NO, "tep-forces": NO, "torque-balance": NO, "fixed-limit": NO, "eq19-async": NO}),
)


def section(found, counted):
    """found: all other sections; counted: a sentence on how many statements hold. Takes its figures out of their sections."""
    claims = {claim.slug: claim.verdict for part in found for claim in part.claims}
    facts = {key: value for part in found for key, value in part.facts.items()}
    out, parts = Section("short", "What was asked, what holds, and why"), [f"<p>{counted}</p>"]
    for heading, text, rests in PARAGRAPHS:
        turned = [slug for slug, verdict in rests.items() if claims.get(slug, OPEN) != verdict]
        known = {**{name: "(no data)" for name in ("weak", "strong", "tau_weak", "tau_strong", "fields")}, **facts}
        parts.append(f"<p><b>{heading}</b> " + (text.format(**known) if not turned else
                     "(Left out: the data here do not bear it out, or are missing: " + ", ".join(
                         f"<code>{slug}</code>" for slug in turned) + ".)") + "</p>")
    out.lead = "".join(parts)
    for name in FIGURES:
        for part in found:
            mine = [figure for figure in part.figures if figure.name == name]
            if mine:
                out.figures += mine
                part.figures[:] = [figure for figure in part.figures if figure.name != name]
                out.data[:] = sorted({*out.data, *part.data})
    return out
