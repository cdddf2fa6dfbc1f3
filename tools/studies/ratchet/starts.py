"""The periodic state from several starts, the disk that catches up with its supports, and lambda on a closed path."""
import functools
import math

import numpy as np

from . import levels
from .catalogue import paper
from .kept import CURVE, thin
from .page import Figure, Numbers, Section
from .runs import slipdisk
from .style import BLACK, COLOURS, figure, legend_above, zero_line
from .verdict import TOLERANCES, decide, missing, number, percent

PI = math.pi
PERIOD = 0.1
TITLES = {"sync": "in phase", "async": "opposite phases"}
SAME = 1e-3  # of the range of Omega


def sections(results):
    return [start_section(results), caught_section(results), loop_section(results)]


# --- starts ---------------------------------------------------------------------------------------------------------
def last_periods(path):
    """Omega of the upper disk over the last two periods, time from their begin."""
    frames = slipdisk.Result(path).frames
    time, spin = frames.time, frames["angular_velocity"][:, 0]
    chosen = time > time[-1] - 2 * PERIOD - 1e-6
    return {"time": time[chosen] - time[chosen][0], "omega": spin[chosen]}


def start_section(results):
    out = Section("starts", "The periodic state", "Supports that turn at &Theta;<sub>b</sub> = "
                                                  f"{levels.STRONG_DRIVE:g} (parabola, tilt 0.04&pi;), upper disk at "
                                                  "rest and with other spins and angles at the start; its velocity "
                                                  "after 60 time units (600 periods).", new=True)
    picture, axes = figure(2, 1, height=3.4)
    rows = []
    for k, (kind, title) in enumerate(TITLES.items()):
        found = {}
        for name in levels.STARTS:
            path = results.run(f"start_{kind}_{name}")
            table = results.numbers(f"start-{kind}-{name}", lambda path=path: last_periods(path) if path else None,
                                    f"angular velocity over two periods, {title}, start: {name}")
            if table:
                found[name] = table
            else:
                out.missing.append(f"start_{kind}_{name}: not run yet")
        out.claims += period_claims(kind, found)
        for n, (name, table) in enumerate(found.items()):
            spin, angle = levels.STARTS[name]
            rows.append([title, float(spin), float(angle), float(table.column("omega").mean()), *repeats(table)])
            axes[k].plot(table.column("time") / PERIOD, table.column("omega"), color=COLOURS[n], lw=(3.5, 2.0,
                                                                                                     0.8)[n % 3],
                         label=f"{spin:g}")
        axes[k].set_title(title, pad=56)
        axes[k].set_xlabel("time $t/T$")
        if found:
            legend_above(axes[k], 3, title=r"$\Omega$ at the start")
    axes[0].set_ylabel(r"upper disk $\Omega$")
    out.figures.append(Figure("starts", picture, "Angular velocity of the upper disk over two periods of the drive, "
                                                 "from three starts: the lines lie on each "
                                                 "other.", "Angular velocity over two periods from three starts"))
    out.tables.append(Numbers("Starts", ["", "spin at the start",
                                         "angle at the start",
                                         "mean &Omega;",
                                         "change after a period",
                                         "change after half a period"], rows))
    return out


def repeats(table):
    """Largest change of Omega after a whole and after half a period, over its range."""
    time, omega = table.column("time"), table.column("omega")
    first, extent = time < PERIOD * (1 + 1e-6), float(np.ptp(omega))
    return [float(np.abs(np.interp(time[first] + shift, time, omega) - omega[first]).max()) / extent
            for shift in (PERIOD, PERIOD / 2)]


def period_claims(kind, found):
    if len(found) < len(levels.STARTS):
        return [missing(**paper(f"{kind}-period")), missing(**paper(f"{kind}-start"))]
    whole, half = zip(*(repeats(table) for table in found.values()))
    tables = list(found.values())
    time, omega = tables[0].column("time"), tables[0].column("omega")
    gap = max(float(np.abs(np.interp(time, t.column("time"), t.column("omega")) - omega).max())
              for t in tables[1:]) / float(np.ptp(tables[0].column("omega")))
    told = " (counted as none below " + number(SAME) + " of the range of &Omega;)"
    return [decide(condition=lambda factor: max(whole) < factor * SAME and min(half) > factor * SAME,
                   numbers=f"{len(found)} starts: largest change after one period {number(max(whole))}, after half a "
                           f"period {number(min(half))}{told}", **paper(f"{kind}-period")),
            decide(condition=lambda factor: gap < factor * SAME, numbers=f"largest difference between {len(found)} starts {number(gap)}{told}",
                   **paper(f"{kind}-start"))]


# --- catching up ------------------------------------------------------------------------------------------------------
class Caught:
    """The run in which the upper disk may turn on supports that go on turning one way."""

    def __init__(self, path):
        result = slipdisk.Result(path)
        frames, contacts = result.frames, result.contacts
        self.time, spin = frames.time[1:], frames["angular_velocity"][1:]
        self.omega, self.aim = spin[:, 0], float(-spin[-1, 1])
        sliding, count, first = contacts["sliding"], contacts.count, np.cumsum(contacts.count) - contacts.count
        self.slides = np.array([np.any(sliding[f:f + c] != 0) for f, c in zip(first, count)])[1:]
        self.contact_time = contacts.time[1:]

    def trace(self):
        return thin({"time": self.time, "omega": self.omega}, 2 * CURVE)

    def numbers(self):
        """Sizes after the disk has caught up; what goes on at the end, in the last tenth of a time unit."""
        met = float(self.time[np.argmax(self.omega >= self.aim)]) if (self.omega >= self.aim).any() else math.nan
        off = self.omega[self.time > met] / self.aim - 1 if met == met else np.array([math.nan])
        late = self.time > self.time[-1] - 0.1
        swing = self.omega[late] - self.omega[late].mean()
        slid = self.contact_time[self.slides]
        return {"aim": self.aim, "met": met, "largest": float(np.abs(off).max()),
                "late": float(np.abs(self.omega[late] / self.aim - 1).max()),
                "crossings": float((np.diff(np.sign(swing)) != 0).sum()), "swing": float(swing.std()),
                "last_slide": float(slid[-1]) if len(slid) else 0.0, "end": float(self.time[-1])}


def caught_section(results):
    out = Section("catch-up", "Supports that go on turning one way",
                  "Deck <code>inputs/three_disk/steady.cfg</code>, S<sup>++</sup>, with an upper disk that may turn; "
                  "the supports reach their speed 1 after 0.1 time units.", new=True)
    path = results.run("catch_up")
    record = functools.cache(lambda: Caught(path))
    trace, one = (results.numbers("catch-up" + part, lambda make=make: getattr(record(), make)() if path else None,
                                  title)
                  for part, make, title in (("-trace", "trace", "angular velocity of the upper disk"),
                                            ("", "numbers", "catching up with the supports")))
    theory = results.theory("torques", "three_disk/steady.cfg")
    if not trace or not one:
        out.missing.append("catch_up: not run yet")
        out.claims = [missing(**paper("catch-up")), missing(**paper("elastic-after"))]
        return out
    found = one.rows[0]
    picture, axes = figure(2, 1, height=3.2, width=7.4)
    time, omega = trace.column("time"), trace.column("omega")
    axes[0].plot(time, omega, color=COLOURS[0], lw=1.2)
    axes[0].axhline(found["aim"], color=BLACK, lw=0.8, ls="--")
    axes[0].set_ylabel(r"upper disk $\Omega$")
    after = time > found["met"]
    axes[1].plot(time[after], 1e3 * (omega[after] / found["aim"] - 1), color=COLOURS[0], lw=0.8)
    zero_line(axes[1])
    axes[1].set_ylabel(r"$10^3(\Omega/\Omega_\mathrm{supports}-1)$")
    for panel in axes:
        panel.set_xlabel("time $t$")
    out.figures.append(Figure("catch-up", picture, "Left: angular velocity of the upper disk; dashed: of the supports' "
                                                   "surfaces. Right: difference from it after the disk has caught up.",
                              "Angular velocity of a disk that catches up with its supports"))
    torque = theory.rows[0].get("torque_pp") if theory else None
    told = f"it meets their speed at {number(found['met'], digits=4)}"
    if isinstance(torque, float):
        told += (" (at constant torque (15), with supports that speed up over 0.1: "
                 f"{number(found['aim'] * 0.05 / torque, digits=4)})")
    limit = TOLERANCES["equal"]
    out.claims = [decide(condition=lambda factor: bool(found["met"] == found["met"] and found["largest"] < factor * limit),
                         numbers=f"{told}; then it stays within {percent(found['largest'])} of it (counted as caught "
                                 f"up within {100 * limit:g} %)", **paper("catch-up")),
                  elastic_claim(found)]
    return out


def elastic_claim(found):
    sticks = found["last_slide"] < found["end"] - 0.1
    return decide(condition=lambda factor: sticks and found["crossings"] >= factor * 20, numbers="contacts slide for the last time at "
                                                       f"{number(found['last_slide'], digits=4)}; in the last 0.1 time "
                                                       f"units &Omega; crosses its mean {found['crossings']:g} times "
                                                       "(counted as swinging from 20 on), rms swing "
                                                       f"{number(found['swing'])}: it dies out by the viscosity of the "
                                                       "contacts", **paper("elastic-after"))


# --- lambda -----------------------------------------------------------------------------------------------------------
def rounds(path):
    """Change of the skin's stretch from one round to the next, work of the force on the centres, energy stored."""
    result = slipdisk.Result(path)
    period, contacts, series = 0.02, result.contacts, result.series
    begin = 0.1 - 1e-9
    time = contacts.time[contacts.count > 0]
    zeta = contacts["zeta"][time > begin]
    per = round(period / 1e-3)
    after, work = series["time"] > begin, series["nonconservative_work"]
    number_of_rounds = (series["time"][-1] - series["time"][after][0]) / period
    return {"change": float(np.abs(zeta[per:] - zeta[:-per]).max()), "extent": float(np.ptp(zeta)),
            "work": float((work[-1] - work[after][0]) / number_of_rounds),
            "stored": float((series["elastic_normal"] + series["elastic_tangential"])[after].max()),
            "rounds": float(round(number_of_rounds))}


def loop_section(results):
    out = Section("loop", "The displacement &lambda; on a closed path",
                  "Deck <code>inputs/paper/loop.cfg</code>: a disk is led a hundred times round a closed path about "
                  "another one, without slipping: approach, turn, retreat, turn back. The paper's law: torque "
                  "&tau;<i>R</i>, force &tau;; for comparison the force &tau;(<i>R<sub>a</sub></i> + "
                  "<i>R<sub>b</sub></i>)/<i>r</i> that derives from the stored energy.", new=True)
    found = {}
    for name in ("paper", "conservative"):
        path = results.run(f"loop_{name}")
        table = results.numbers(f"loop-{name}", lambda path=path: rounds(path) if path else None,
                                f"closed path, force on the centres: {name}")
        if table:
            found[name] = table.rows[0]
        else:
            out.missing.append(f"loop_{name}: not run yet")
    out.claims = loop_claims(found)
    out.tables.append(Numbers("Per round", ["force on the centres",
                                            "change of &lambda; &minus; &lambda;*",
                                            "work gained",
                                            "largest energy stored"],
                              [[name, row["change"], row["work"], row["stored"]] for name, row in found.items()]))
    return out


ENERGY = "A closed path without slipping costs nothing (the paper does not say so)."


def loop_claims(found):
    if len(found) < 2:
        return [missing(**paper("lambda-path")), missing(ENERGY, slug="lambda-energy")]
    law, other = found["paper"], found["conservative"]
    limit = 1e-9
    return [decide(condition=lambda factor: law["change"] < factor * limit * law["extent"],
                   numbers=f"largest change from round to round {number(law['change'])} of an extent of "
                           f"{number(law['extent'])} in {law['rounds']:g} rounds (counted as none below "
                           "10<sup>&minus;9</sup> of it)",
                   **paper("lambda-path")),
            decide(ENERGY, lambda factor: abs(law["work"]) < factor * limit * law["stored"],
                   f"the paper's force gains {number(law['work'], digits=4)} per round, "
                   f"{percent(law['work'] / law['stored'])} of the largest energy stored (counted as none "
                   "below 10<sup>&minus;9</sup> of it): &lambda; returns, but the force on the centres does "
                   "not derive from the stored energy; the one that does gains "
                   f"{number(other['work'])}", slug="lambda-energy")]
