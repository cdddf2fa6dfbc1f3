"""Waveforms of the supports, and velocities over one period of the periodic state (figs. sine-parabola-approx, -async,
sync, async)."""
import math

import numpy as np

from . import levels
from .catalogue import paper
from .kept import thin
from .page import Figure, Numbers, Section
from .runs import slipdisk
from .style import BLACK, COLOURS, GREY, figure, legend_above, legend_below, power, zero_line
from .verdict import NO, OPEN, TOLERANCES, YES, Claim, decide, in_fields, missing, number, percent, sliding

NAMES = {(1, 1): "++", (1, -1): "+-", (-1, 1): "-+", (-1, -1): "--"}
LABELS = {"sync": {"--": 1, "++": 2}, "async": {"--": 1, "-+": 2, "++": 3, "+-": 4}}  # t_1 ... begin these


def read(path):
    """Frames of the last but one whole period of a run: time in periods, angles in Theta_b, speeds in Theta_b w_b."""
    result = slipdisk.Result(path)
    motion, frames = result.deck.motions[0], result.frames
    amplitude, omega = motion.amplitude, motion.omega
    period, time = 2 * math.pi / omega, frames.time
    t = time / period - math.ceil((time[-1] - 1.5 * period) / period - 1e-6)
    inside = (t > -1e-6) & (t < 1 + 1e-6)
    unit, found = amplitude * omega, {"t": np.round(t[inside], 9)}
    found["upper"] = frames["angular_velocity"][inside, 0] / unit
    for i in (1, 2):
        found[f"support{i}"] = -frames["angular_velocity"][inside, i] / unit
        found[f"angle{i}"] = frames["angle"][inside, i] / amplitude
    return thin({**found, "theta_b": np.full(len(found["t"]), amplitude), "omega_b": np.full(len(found["t"]), omega)})


class Wave:
    """One period of a run with dense frames, as read() has it."""

    def __init__(self, table):
        self.t, self.upper = table.column("t"), table.column("upper")
        self.support = np.stack([table.column("support1"), table.column("support2")])
        self.angle = np.stack([table.column("angle1"), table.column("angle2")])
        self.amplitude, self.omega = table.rows[0]["theta_b"], table.rows[0]["omega_b"]
        self.period = 2 * math.pi / self.omega
        self.mean = float(np.trapz(self.upper, self.t) / (self.t[-1] - self.t[0]))


def wave_of(results, name, out):
    """The wave of a run, or None."""
    path = results.run(name)
    table = results.numbers(f"wave-{name}", lambda: read(path) if path else None,
                            "one period: t/T, velocities in Theta_b omega_b, angles in Theta_b")
    out.missing += [] if table else [f"{name}: not run yet"]
    return Wave(table) if table else None


def changes(t, support, upper):
    """[(time, configuration that begins)] within one period, by linear interpolation of the crossings."""
    sign = np.where(support > upper, 1, -1)
    out = []
    for k in np.nonzero((sign[:, 1:] != sign[:, :-1]).any(axis=0))[0]:
        moments = []
        for i in range(2):
            a, b = support[i, k] - upper[k], support[i, k + 1] - upper[k + 1]
            if sign[i, k] != sign[i, k + 1]:
                moments.append(t[k] + (t[k + 1] - t[k]) * a / (a - b))
        out.append((float(np.mean(moments)), NAMES[tuple(sign[:, k + 1])]))
    return out


def theory_wave(results, name):
    deck, _, keys = levels.RUNS[name]
    keys = {key: value for key, value in keys.items() if key.startswith("motions")}
    table = results.theory_wave(f"wave-{name}", deck, keys)
    if not table:
        return None
    t, upper = table.column("t"), table.column("Omega")
    support = np.stack([table.column("support1"), table.column("support2")])
    return t, support, upper


def velocities(results, kind, out):
    """Figure and claims of `sync` or `async`."""
    picture, axes = figure(2, 2, height=5.6, legend=True, sharex=True)
    rows, found = [], {}
    for k, strength in enumerate(("weak", "strong")):
        name = f"{kind}_{strength}"
        wave = wave_of(results, name, out)
        if not wave:
            continue
        theory = theory_wave(results, name)
        above, below = axes[0, k], axes[1, k]
        if kind == "sync":
            above.plot(wave.t, wave.support[0], color=BLACK, lw=1.2, label="supports")
        else:
            above.plot(wave.t, wave.support[0], color=BLACK, lw=1.2, label="support 1")
            above.plot(wave.t, wave.support[1], color=BLACK, lw=1.2, ls="--", label="support 2")
        moments = changes(wave.t, wave.support, wave.upper)
        for panel in (above, below):
            panel.plot(wave.t, wave.upper, color="#9A9A9A", lw=2.6, label="upper disk", zorder=2)
            if theory:
                t, _, upper = theory
                unit = wave.amplitude * wave.omega
                panel.plot(t / wave.period, upper / unit, color=COLOURS[1], lw=1.1, ls="-", label="exact solution",
                           zorder=3)
            zero_line(panel)
        for moment, configuration in moments:
            for panel in (above, below):
                panel.axvline(moment, color=GREY, lw=0.7, ls=":")
        labels(above, below, kind, moments)
        above.set_title(f"$\\Theta_b={power(wave.amplitude)}$", pad=18)
        below.set_xlabel("time $t/T$")
        values = [wave.upper] + ([theory[2] / (wave.amplitude * wave.omega)] if theory else [])
        low, high = min(v.min() for v in values), max(v.max() for v in values)
        below.set_ylim(low - 0.3 * (high - low), high + 0.15 * (high - low))
        below.set_xlim(0, 1)
        found[strength] = (wave, theory, moments)
        rows += numbers(kind, wave, theory, moments)
    axes[0, 0].set_ylabel(r"velocity $/\,\Theta_b\omega_b$")
    axes[1, 0].set_ylabel(r"upper disk $\Omega/\Theta_b\omega_b$")
    legend_below(picture, axes[0])
    return picture, rows, found


def labels(above, below, kind, moments):
    """t_1 ... above the upper axes, the configurations at the bottom of the lower ones."""
    shown = [(moment, LABELS[kind][name]) for moment, name in moments if name in LABELS[kind]]
    for k, (moment, label) in enumerate(shown):
        side = "center"
        if k + 1 < len(shown) and shown[k + 1][0] - moment < 0.1:
            side = "right"
        elif k and moment - shown[k - 1][0] < 0.1:
            side = "left"
        above.text(moment, 1.02, f"$t_{label}$", transform=above.get_xaxis_transform(), ha=side, va="bottom")
    edges = [0.0] + [moment for moment, _ in moments] + [1.0]
    names = [moments[-1][1]] + [name for _, name in moments] if moments else []
    for first, second, name in zip(edges[:-1], edges[1:], names):
        middle, short = (first + second) / 2, second - first < 0.1
        below.annotate("$S^{" + name + "}$", (middle, 0.21 if short else 0.03), (middle + 0.05 * short,
                                                                                 0.13 if short else 0.03),
                       xycoords=below.get_xaxis_transform(), ha="left" if short else "center", va="bottom", color=GREY,
                       arrowprops={"arrowstyle": "-", "color": GREY,
                                   "lw": 0.6,
                                   "shrinkA": 0,
                                   "shrinkB": 0} if short else None)


def numbers(kind, wave, theory, moments):
    rows = []
    known = changes(theory[0] / wave.period, theory[1], theory[2]) if theory else []
    for moment, configuration in moments:
        same = [m for m, c in known if c == configuration]
        label = LABELS[kind].get(configuration)
        rows.append([f"{wave.amplitude:g}", f"<i>t</i><sub>{label}</sub>: {sliding(configuration)} begins", moment,
                     min(same, key=lambda m: abs(m - moment)) if same else math.nan])
    mean = math.nan
    if theory:
        t, _, upper = theory
        mean = float(np.trapz(upper, t) / (t[-1] - t[0])) / (wave.amplitude * wave.omega)
    rows.append([f"{wave.amplitude:g}", "mean of &Omega;/&Theta;<sub>b</sub>&omega;<sub>b</sub>", wave.mean, mean])
    return rows


def deviation(wave, theory):
    """Largest distance of the two curves of the upper disk, in units of the exact solution's largest value."""
    t, _, upper = theory
    upper = upper / (wave.amplitude * wave.omega)
    return float(np.abs(np.interp(wave.t, t / wave.period, upper) - wave.upper).max() / np.abs(upper).max())


def waveform_section(results):
    out = Section("waveforms", "Waveforms of the supports (figs. sine-parabola-approx, -async)",
                  "Angles of the supports " "over one period, from runs of <code>inputs/three_disk/sync.cfg</code> and "
                  "<code>async.cfg</code> " "with harmonic (20) and parabolic (21) motion.")
    picture, axes = figure(2, 1, height=3.1, sharey=True)
    rows, worst, ends = [], math.nan, math.nan
    for k, (kind, title) in enumerate((("sync", "in phase"), ("async", "opposite phases"))):
        sine, parabola = [wave_of(results, f"{kind}_{wave}", out) for wave in ("sine", "strong")]
        if not (sine and parabola):
            continue
        for i in range(2 if kind == "async" else 1):
            which = f" {i + 1}" if kind == "async" else "s"
            axes[k].plot(sine.t, sine.angle[i], color=COLOURS[i], ls=":", lw=2, label=f"sine, support{which}")
            axes[k].plot(parabola.t, parabola.angle[i], color=COLOURS[i], lw=1.1, label=f"parabola, support{which}")
        zero_line(axes[k])
        axes[k].set_xlim(0, 1)
        axes[k].set_title(title, pad=42)
        axes[k].set_xlabel("time $t/T$")
        legend_above(axes[k], 2, fontsize=8.5)
        marks = [int(np.argmin(np.abs(parabola.t - q))) for q in (0, 0.25, 0.5, 0.75, 1)]
        gap = parabola.angle[0] - np.interp(parabola.t, sine.t, sine.angle[0])
        worst = float(np.abs(gap).max())
        ends = float(np.abs(gap[marks]).max())
        rows += [[title, float(t), float(s), float(p)] for t, s,
                 p in zip(parabola.t[::max(1, len(gap) // 40)],
                          np.interp(parabola.t, sine.t, sine.angle[0])[::max(1, len(gap) // 40)],
                          parabola.angle[0][::max(1, len(gap) // 40)])]
    axes[0].set_ylabel(r"angle $\theta_i/\Theta_b$")
    out.figures.append(Figure("waveforms", picture, "Angles of the supports: sine (dotted) and the parabolas that "
                              "agree with it at zeros and extrema (solid). In opposite phases the right support's "
                              "angle is minus the left one's.", "Sine and parabola waveforms of the supports over one "
                              "period"))
    out.claims.append(missing(**paper("parabolas")) if math.isnan(worst)
                      else decide(condition=lambda factor: ends < factor * 1e-3 and worst < factor * 0.1,
                                  numbers=f"largest difference at zeros and extrema {number(ends)}, anywhere "
                                          f"{number(worst)} (of &Theta;<sub>b</sub>)", **paper("parabolas")))
    out.tables.append(Numbers("Left support", ["", "<i>t/T</i>", "sine", "parabola"], rows))
    return out


def sequence(moments):
    """Configurations in the order in which they begin, from S-- (or the first) on."""
    names = [c for _, c in moments]
    start = names.index("--") if "--" in names else 0
    return names[start:] + names[:start]


def velocity_section(results, kind):
    title = {"sync": "Velocities over one period, in phase (fig. sync)",
             "async": "Velocities over one period, opposite phases (fig. async)"}[kind]
    out = Section(kind, title, "Surface velocities of the supports as the upper disk feels them, "
                  "&minus;d&theta;<sub>i</sub>/d<i>t</i>, and angular velocity of the upper disk in the periodic "
                  "state (after 20 or more time units, 200 periods), at a weak and a strong drive; parabola, "
                  "&omega;<sub>b</sub> = 20&pi;, tilt 0.04&pi;. The exact solution is that of permanent sliding with "
                  "the centre in its equilibrium at once. <i>t<sub>i</sub></i>: velocities meet, another sliding "
                  "configuration begins.")
    picture, rows, found = velocities(results, kind, out)
    out.figures.append(Figure(kind, picture, "Above: velocities of supports (black) and upper disk (grey); below: the "
                              "upper disk alone. Dotted: times at which velocities meet in the simulation.",
                              f"Velocities over one period: {title}"))
    out.tables.append(Numbers("Transition times and means", ["&Theta;<sub>b</sub>", "", "simulation", "exact solution"],
                              rows))
    expected = ["--", "++"] if kind == "sync" else ["--", "-+", "++", "+-"]
    for strength, drive in (("weak", levels.WEAK_DRIVE), ("strong", levels.STRONG_DRIVE)):
        if (kind, strength) == ("async", "strong"):
            continue  # async-configurations says so: S-- does not occur
        known = paper(f"{kind}-sequence-{strength}")
        if strength in found:
            names = sequence(found[strength][2])
            out.claims.append(decide(condition=names == expected, numbers=f"&Theta;<sub>b</sub> = {drive:g}: found "
                                     + ", ".join(sliding(c) for c in names), **known))
        else:
            out.claims.append(missing(**known))
    fields = {} if kind == "sync" else {"async_slow": wave_of(results, "async_slow", out)}
    slow = {name: (wave, theory_wave(results, name)) for name, wave in fields.items() if wave}
    out.claims.append(straight(found, slow, paper(f"{kind}-straight")))
    return out


def straight(found, slow, known):
    """The curves of simulation and theory at strong drive, in phase at 20 pi, in opposite phases also at another frequency."""
    if not all(s in found and found[s][1] for s in ("weak", "strong")):
        return missing(**known, why="no data or no theory curve yet")
    gaps, limit = {s: deviation(*found[s][:2]) for s in found}, TOLERANCES["curve"]
    fields = {found["strong"][0].omega: gaps["strong"], **{wave.omega: deviation(wave, theory) for wave, theory in slow.values()
                                                          if theory}}
    told = "; ".join(f"&Theta;<sub>b</sub> = {found[s][0].amplitude:g}: largest distance {percent(g)} of the largest "
                     "|&Omega;|" for s, g in gaps.items())
    told += "".join(f"; &Theta;<sub>b</sub> = {found['strong'][0].amplitude:g} at &omega;<sub>b</sub> = {omega / math.pi:g} &pi;: "
                    f"{percent(gap)}" for omega, gap in list(fields.items())[1:])

    def judge(factor):
        """Two of the frequencies that the paper may mean refute nothing in opposite phases."""
        verdict = in_fields([YES if gap < factor * limit else NO for gap in fields.values()])
        return OPEN if verdict == NO and slow else verdict

    return Claim(verdict=judge,
                 numbers=f"{told} (counted as equal up to {100 * limit:g} % at the strong drive)", rule="fields", **known)


def sections(results):
    return [waveform_section(results), velocity_section(results, "sync"), velocity_section(results, "async")]
