"""Frequency and waveform of the turning supports, which the paper does not give: in which of these fields its statements on
(30) and (35) hold."""
import math

import numpy as np

from .catalogue import paper
from .page import Figure, Numbers, Section
from .style import COLOURS, LIGHT, figure, in_pi, legend_below, power, zero_line
from .verdict import NO, OPEN, TOLERANCES, YES, Claim, approaching, close, in_fields, listed, missing, percent

PI = math.pi
MU, THETA_H = 0.1, PI / 6
KINDS = {"sync": (0.0, "in phase", "(30)"), "async": (PI, "opposite phases", "(35), corrected")}
WAVES = {"parabolic": "parabola", "harmonic": "sine"}
PAPER_K_N = 1e3
MARKS = {1e3: "o", 1e4: "^", 1e5: "s"}


def formula(kind, tilt):
    """(30), and (35) with the factor omega_b/pi that it lacks, over Theta_b omega_b."""
    if kind == "sync":
        return 4 * MU * math.tan(tilt) / PI
    factor = 1 + MU ** 2
    return 8 * MU * factor * tilt * math.cos(THETA_H) ** 2 / (PI * (factor * math.cos(2 * THETA_H) + MU ** 2 - 1))


class Field:
    """One frequency, waveform and stiffness: relative deviations and errors by amplitude and tilt."""

    def __init__(self, kind, rows):
        first = rows[0]
        self.kind, self.wave, self.k_n, self.omega = kind, first["wave"], first["k_n"], first["omega_b"]
        self.amplitudes = sorted({row["theta_b"] for row in rows})
        self.tilts = sorted({row["tilt"] for row in rows})
        self.off, self.error = {}, {}
        for row in rows:
            aim = formula(kind, row["tilt"]) * row["theta_b"] * row["omega_b"]
            at = row["theta_b"], row["tilt"]
            self.off[at], self.error[at] = row["upper.omega"] / aim - 1, row["upper.omega_error"] / abs(aim)
        self.converged = all(row["upper.converged"] > 0 for row in rows)

    def name(self):
        return f"{WAVES[self.wave]} at {self.omega / PI:g} &pi;"

    def worst(self, amplitude):
        """(largest |deviation| at all tilts, its error)"""
        tilt = max(self.tilts, key=lambda t: abs(self.off[amplitude, t]))
        return abs(self.off[amplitude, tilt]), self.error[amplitude, tilt]

    def excellent(self, factor=1.0):
        return close(*self.worst(self.amplitudes[-1]), factor * TOLERANCES["excellent"])

    def approaches(self, factor=1.0):
        off, error = (np.array(v) for v in zip(*(self.worst(a) for a in self.amplitudes)))
        return approaching(off, error, factor * TOLERANCES["excellent"])[2]

    def below(self):
        """Do all smaller amplitudes turn the disk more slowly than theory, by more than their error?"""
        return all(self.off[a, t] < -3 * self.error[a, t] for a in self.amplitudes[:-1] for t in self.tilts)


def fields(table):
    """All fields of which every amplitude and tilt is there, by kind, waveform, stiffness and frequency."""
    found = {}
    for row in table.rows:
        kind = "sync" if abs(row["phase"]) < 1e-9 else "async"
        found.setdefault((kind, row["wave"], row["k_n"], row["omega_b"]), []).append(row)
    full = max((len(rows) for rows in found.values()), default=0)
    return [Field(key[0], rows) for key, rows in sorted(found.items(), key=lambda item: (
        item[0][0] != "sync", item[0][1] != "parabolic", *item[0][2:])) if len(rows) == full]


def truth(verdict):
    return {YES: "yes", NO: "no", OPEN: "?"}[verdict]


def claim(found, kind, which):
    """approach or excellent: judged in each field of the paper's stiffness."""
    known, mine = paper(f"{kind}-{which}"), [f for f in found if f.kind == kind and f.k_n == PAPER_K_N]
    if not mine:
        return missing(**known)
    judge = Field.excellent if which == "excellent" else Field.approaches
    told = []
    for wave, word in WAVES.items():
        here = [f for f in mine if f.wave == wave]
        true = [f"{f.omega / PI:g}" for f in here if judge(f) == YES]
        off = [100 * f.off[f.amplitudes[-1], t] for f in here for t in f.tilts]
        told.append(f"{word}: " + (f"true at &omega;<sub>b</sub> = {listed(true, 12)} &pi;" if true else "nowhere")
                    + (f" of {len(here)} frequencies from {here[0].omega / PI:g} to {here[-1].omega / PI:g} &pi;; deviation at "
                       f"&Theta;<sub>b</sub> = {here[0].amplitudes[-1]:g} from {percent(min(off) / 100)} to "
                       f"{percent(max(off) / 100)}" if here else ""))
    return Claim(verdict=lambda factor: in_fields([judge(f, factor) for f in mine]), rule="fields",
                 numbers="; ".join(told) + f" (tolerance {100 * TOLERANCES['excellent']:g} %, tilts 0.04 and 0.08 &pi;, "
                 "<i>k<sub>n</sub></i> = 10<sup>3</sup>)", **known)


def best(found):
    """The frequency and waveform with the smallest largest deviation of both phases, and whether small amplitudes lie below."""
    pairs = {}
    for f in found:
        if f.k_n == PAPER_K_N:
            pairs.setdefault((f.wave, f.omega), {})[f.kind] = f
    scored = [(max(f.worst(f.amplitudes[-1])[0] for f in pair.values()), all(f.below() for f in pair.values()), pair)
              for pair in pairs.values() if len(pair) == 2]
    text = "In one field at least both agreements are excellent and all smaller amplitudes lie below theory, as the paper has it."
    if not scored:
        return missing(text, slug="fields-best")
    ranked = sorted(scored, key=lambda row: row[0])
    told = ", ".join(f"{pair['sync'].name()} {100 * off:.1f} %" for off, _, pair in ranked[:3])
    under = ", ".join(f"{pair['sync'].name()} {100 * off:.1f} %" for off, below, pair in ranked if below)
    return Claim(text, lambda factor: YES if any(
        below and all(f.excellent(factor) == YES for f in pair.values()) for _, below, pair in scored) else NO,
        f"largest deviation in either phase at the largest amplitude: least with the {told}, where smaller amplitudes do not lie "
        f"below in opposite phases; all smaller amplitudes lie below with the {under or 'parabola nowhere'}", slug="fields-best",
        rule="fields")


def facts(found):
    """Returns what the head of the page says of it."""
    mine, told = [f for f in found if f.k_n == PAPER_K_N], []
    if not mine:
        return {}
    for kind, (_, title, law) in KINDS.items():
        for wave, word in WAVES.items():
            here = [f for f in mine if (f.kind, f.wave) == (kind, wave)]
            true = [f.omega / PI for f in here if f.excellent() == YES]
            told.append(f"{law}, {'in ' * (kind == 'async')}{title}, by the {word} " + (f"at {', '.join(f'{w:g}' for w in true)}&pi;" if true else "nowhere"))
    return {"fields": f"At the largest amplitude, of twelve frequencies from 5 to 40&pi;, theory is met within "
            f"{100 * TOLERANCES['excellent']:g} %: " + "; ".join(told)}


def sections(results):
    out = Section("fields", "Supports that turn: which frequency, which waveform",
                  "The paper states excellent agreement with (30) and (35) at large amplitude and gives neither "
                  "&omega;<sub>b</sub> nor whether its simulations turn the supports by the sine (20) or by the parabolas (21). Deck "
                  "<code>inputs/paper/map.cfg</code>: both waveforms, twelve frequencies, three stiffnesses at the same damping "
                  "ratio, three amplitudes, two tilts. The two formulae are those of permanent sliding for the parabola; (35) is "
                  "corrected by &omega;<sub>b</sub>/&pi;.", new=True)
    table = results.sweep("map")
    out.missing = list(table.missing)
    found = fields(table)
    out.claims = [*(claim(found, kind, which) for kind in KINDS for which in ("approach", "excellent")), best(found)]
    out.facts = facts(found)
    out.figures.append(draw(found))
    by = {}
    for f in found:
        by.setdefault((f.wave, f.k_n, f.omega), {})[f.kind] = f
    rows = []
    for (wave, k_n, omega), pair in by.items():
        cells = []
        for kind in KINDS:
            f = pair.get(kind)
            cells += [*(100 * f.off[f.amplitudes[-1], t] for t in f.tilts), truth(f.approaches()), truth(f.excellent()),
                      "yes" if f.below() else "no"] if f else [math.nan, math.nan, "", "", ""]
        rows.append([WAVES[wave], k_n, omega / PI, *cells])
    columns = ["waveform", "<i>k<sub>n</sub></i>", "&omega;<sub>b</sub>/&pi;"]
    for _, title, _ in KINDS.values():
        columns += [f"{title}: off at 0.04 &pi;, %", "at 0.08 &pi;, %", "approaches", "excellent", "smaller below"]
    own = [row for row in rows if row[1] == PAPER_K_N]
    digits = {name: 2 for name in columns if "%" in name}
    out.tables += [Numbers("The paper's stiffness, &Theta;<sub>b</sub> = 0.1: deviation from (30) and from corrected (35), and what "
                           "holds", columns, own, shown=True, digits=digits),
                   Numbers("All stiffnesses", columns, rows, digits=digits)]
    return [out]


def draw(found):
    picture, axes = figure(2, 1, height=3.8, width=7.6, legend=True, sharey=True)
    limit = 100 * TOLERANCES["excellent"]
    for axis, (kind, (_, title, law)) in zip(axes, KINDS.items()):
        axis.axhspan(-limit, limit, color=LIGHT, alpha=0.5, lw=0, zorder=0, gid="guide")
        for wave, word in WAVES.items():
            for k, k_n in enumerate(MARKS):
                line = [f for f in found if (f.kind, f.wave, f.k_n) == (kind, wave, k_n)]
                if line:
                    axis.plot([f.omega / PI for f in line], [100 * f.off[f.amplitudes[-1], f.tilts[0]] for f in line],
                              ls="-" if wave == "parabolic" else ":", lw=1, marker=MARKS[k_n], ms=4.5,
                              mfc="white" if wave == "harmonic" else COLOURS[k], color=COLOURS[k],
                              label=f"{word}, $k_n={power(k_n)}$")
        zero_line(axis)
        axis.set_yscale("symlog", linthresh=5)
        axis.set_yticks([-100, -20, -5, -2, 0, 2, 5, 20, 100], ["$-100$", "$-20$", "$-5$", "$-2$", "0", "2", "5", "20", "100"])
        axis.set_yticks([], minor=True)
        in_pi(axis.xaxis, 10)
        axis.set_xlabel(r"frequency $\omega_b$")
        axis.set_title(f"{title}, from {law}", fontsize=10)
    axes[0].set_ylabel(r"deviation of $\Omega$ (%)")
    legend_below(picture, axes, 6, fontsize=8.5, columnspacing=0.9, handlelength=1.6, handletextpad=0.4)
    return Figure("fields", picture, "Deviation of &Omega; from (30) and from corrected (35) at &Theta;<sub>b</sub> = 0.1, tilt "
                  "0.04&pi;, against the frequency: parabola (filled, solid) and sine (open, dotted) at three stiffnesses. Grey: what "
                  "counts as excellent. The axis is linear between &minus;5 and 5 %, logarithmic beyond.",
                  "Deviation of the rotation from theory against frequency, for both waveforms and three stiffnesses")
