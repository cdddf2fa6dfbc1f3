"""How often the two contacts slide in which direction, against amplitude and against tilt."""
import math

import numpy as np

from .page import Figure, Numbers, Section
from .style import COLOURS, CONFIGURATIONS, figure, in_pi, legend_below
from .verdict import decide, missing, number

PI = math.pi
PARTS = tuple(CONFIGURATIONS)


def fractions(axes, table, x, scale):
    for k, part in enumerate(PARTS):
        value = table.disk(part)
        if part == "open" and not (value > 0).any():
            continue
        label, sign = CONFIGURATIONS[part]
        axes.plot(scale * table.column(x), value, ls="-", lw=0.8, marker=sign, ms=5, mfc="white", color=COLOURS[k],
                  label=label)
    top = max((float(table.disk(p).max()) for p in PARTS), default=0) if table else 0
    axes.set_ylim(-0.03, max(0.63, 1.08 * top))


def panel(axes, table, x, title):
    """table: points of one line, against x ("tilt" in units of pi, or an amplitude)."""
    line = table.sorted(x)
    fractions(axes, line, x, {"tilt": 1 / PI, "eps_b": 1e5, "theta_b": 1}[x])
    if x == "tilt":
        in_pi(axes.xaxis, 0.04)
        axes.set_xlabel(r"tilt $\theta_T$")
    elif x == "eps_b":
        axes.set_xlabel(r"amplitude $\epsilon_b\times10^5$")
    else:
        if line:  # without points an axis has no place for its ticks
            axes.set_xscale("log")
        axes.set_xlabel(r"amplitude $\Theta_b$")
    axes.set_title(title)


def sections(results):
    tables = {name: results.best(name).joined() for name in ("random", "sync", "async")}
    out = Section("configurations", "Sliding configurations", "Fractions of the measured time. The first sign is that "
                  "of the tangential force at the left contact, the second at the right one; a contact that sticks "
                  "for a moment while its sliding turns round counts as sticking.", new=True,
                  missing=[line for table in tables.values() for line in table.missing])
    picture, axes = figure(3, 2, height=5.4, width=7.4, legend=True)
    chosen = (("random", "eps_b", 1e-4, "random"), ("sync", "theta_b", 0.04, "in phase"),
              ("async", "theta_b", 0.04, "opposite phases"))
    for k, (name, amplitude, value, title) in enumerate(chosen):
        table = tables[name]
        panel(axes[0, k], table.where(tilt=0.04 * PI), amplitude, f"{title}, $\\theta_T=0.04\\pi$")
        panel(axes[1, k], table.where(**{amplitude: value}), "tilt", f"{title}, "
              + (r"$\epsilon_b=10^{-4}$" if k == 0 else r"$\Theta_b=0.04$"))
    for row in axes:
        row[0].set_ylabel("fraction of time")
    legend_below(picture, axes[1] if not tables["random"] else [axes[1, 0]], 6)
    out.figures.append(Figure("configurations", picture, "Fractions of time in the four sliding configurations, and "
                              "with a contact that sticks or is open, against amplitude (above) and tilt (below), for "
                              "random vibration and for supports that turn in phase and in opposite phases.",
                              "Fractions of time in each sliding configuration against amplitude and tilt"))
    out.claims = claims(tables)
    rows = []
    for name, amplitude, _, title in chosen:
        rows += [[title, row[amplitude], row["tilt"] / PI, *(row[f"upper.{part}"] for part in PARTS),
                  row["upper.left.sliding"], row["upper.right.sliding"]] for row in tables[name].rows]
    out.tables.append(Numbers("All fractions",
                              ["", "amplitude", "&theta;<sub>T</sub>/&pi;", *(plain(part) for part in PARTS),
                               "left contact slides", "right contact slides"], rows))
    return [out]


def plain(part):
    return {"pp": "S<sup>++</sup>", "pm": "S<sup>+&minus;</sup>", "mp": "S<sup>&minus;+</sup>",
            "mm": "S<sup>&minus;&minus;</sup>", "stick": "a contact sticks", "open": "a contact is open"}[part]


def claims(tables):
    out = []
    text, place = "In phase S<sup>+&minus;</sup> and S<sup>&minus;+</sup> cannot be reached.", "section 4.1"
    sync = tables["sync"]
    if sync:
        most = float(max(sync.disk("pm").max(), sync.disk("mp").max()))
        out.append(decide(text, most < 1e-3, f"largest fraction of either at {len(sync)} points {number(most)} "
                          "(counted as none below 10<sup>&minus;3</sup>)", place))
    else:
        out.append(missing(text, place))
    for name, text, place in (("async", "In opposite phases all four configurations occur.", "section 4.2"),
                              ("random", "Under random vibration all four configurations occur.", "section 4.2")):
        table = tables[name].such(lambda row: row["tilt"] > 0)
        if not table:
            out.append(missing(text, place))
            continue
        least = np.min([table.disk(part) for part in ("pp", "pm", "mp", "mm")], axis=0)
        every = int((least > 1e-3).sum())
        amplitude = "theta_b" if name == "async" else "eps_b"
        strong = sorted({row[amplitude] for row, value in zip(table.rows, least) if value <= 1e-3})
        told = f"all four last longer than 0.1 % of the time at {every} of {len(table)} points with tilt"
        if strong:
            told += "; not at all tilts at amplitudes " + ", ".join(f"{a:g}" for a in strong)
        out.append(decide(text, every == len(table), told, place))
    text, place = "The contacts slide most of the time under random vibration.", "section 4"
    table = tables["random"]
    if table:
        contact = np.minimum(table.disk("left.sliding"), table.disk("right.sliding"))
        both = sum(table.disk(part) for part in ("pp", "pm", "mp", "mm"))
        weakest = table.rows[int(np.argmin(contact))]
        enough = [e for e in table.values("eps_b")
                  if all(c > 0.5 for c, row in zip(contact, table.rows) if row["eps_b"] >= e * 0.999)]
        told = (f"each contact slides for a fraction of {number(float(contact.min()))} to "
                f"{number(float(contact.max()))} of the time, both at once for {number(float(both.min()))} to "
                f"{number(float(both.max()))}; least at &epsilon;<sub>b</sub> = {weakest['eps_b']:g}, tilt "
                f"{weakest['tilt'] / PI:g} &pi;")
        if enough:
            told += f"; each for more than half of it at all tilts from &epsilon;<sub>b</sub> = {enough[0]:g} on"
        out.append(decide(text, bool((contact > 0.5).all()), told, place))
    else:
        out.append(missing(text, place))
    return out
