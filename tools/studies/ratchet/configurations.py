"""How often the two contacts slide in which direction, against amplitude and against tilt."""
import math

import numpy as np

from .catalogue import paper
from .page import Figure, Numbers, Section
from .style import COLOURS, CONFIGURATIONS, RANDOM_MARKERS, figure, in_pi, legend_below
from .verdict import TOLERANCES, decide, missing, number

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


FOUR = ("pp", "pm", "mp", "mm")


def claims(tables):
    return [sync_claim(tables["sync"]), four_claim(tables["async"], "async"), four_claim(named(tables["random"]), "random"),
            slides_claim(named(tables["random"]))]


def sync_claim(sync):
    if not sync:
        return missing(**paper("sync-configurations"))
    most, limit = float(max(sync.disk("pm").max(), sync.disk("mp").max())), TOLERANCES["absent"]
    return decide(condition=lambda factor: most < factor * limit, numbers=f"largest fraction of either at {len(sync)} points {number(most)} "
                  f"(counted as none below {number(limit)})", **paper("sync-configurations"))


def named(table):
    """The points of random vibration at amplitudes that the paper names."""
    return table.such(lambda row: any(abs(row["eps_b"] / eps - 1) < 1e-6 for eps in RANDOM_MARKERS))


def four_claim(table, name):
    """Each configuration is reached at every point with tilt: under random vibration at all, without noise for a while."""
    table, limit = table.such(lambda row: row["tilt"] > 0), TOLERANCES["absent"] if name == "async" else 0.0
    if not table:
        return missing(**paper(f"{name}-configurations"))
    least = np.min([table.disk(part) for part in FOUR], axis=0)
    amplitude = "theta_b" if name == "async" else "eps_b"
    lacking = sorted({row[amplitude] for row, value in zip(table.rows, least) if value <= limit})
    told = (f"all four {f'last longer than {100 * limit:g} % of the time' if limit else 'are reached'} at "
            f"{int((least > limit).sum())} of {len(table)} points with tilt")
    if not lacking:
        told += f", the rarest for {number(float(least.min()))} of the time"
    if lacking:
        told += "; not at all tilts at amplitudes " + ", ".join(f"{a:g}" for a in lacking)
    return decide(condition=(lambda factor: bool((least > factor * limit).all())) if limit else not lacking, numbers=told,
                  **paper(f"{name}-configurations"))


def slides_claim(table):
    if not table:
        return missing(**paper("random-slides"))
    sides, most = (table.disk("left.sliding"), table.disk("right.sliding")), TOLERANCES["most"]
    contact, middle = np.minimum(*sides), sum(sides) / 2
    both = sum(table.disk(part) for part in FOUR)
    weakest = table.rows[int(np.argmin(contact))]
    enough = [e for e in table.values("eps_b")
              if all(c > most for c, row in zip(contact, table.rows) if row["eps_b"] >= e * 0.999)]
    told = (f"mean of both contacts {number(float(middle.min()))} to {number(float(middle.max()))} of the time; the contact "
            f"that slides less does so for {number(float(contact.min()))} to "
            f"{number(float(contact.max()))} of the time, more than half of it at {int((contact > most).sum())} of "
            f"{len(table)} points; both at once for {number(float(both.min()))} to {number(float(both.max()))}; least "
            f"at &epsilon;<sub>b</sub> = {weakest['eps_b']:g}, tilt {weakest['tilt'] / PI:g} &pi;")
    if enough:
        told += f"; each for more than half of it at all tilts from &epsilon;<sub>b</sub> = {enough[0]:g} on"
    return decide(condition=lambda factor: bool((middle > factor * most).all()), numbers=told, **paper("random-slides"))
