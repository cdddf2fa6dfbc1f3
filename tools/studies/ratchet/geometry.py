"""The 3-disk system drawn from a result: labelled as in the paper, seen with gravity pointing down."""
import math

import numpy as np
from matplotlib.patches import Arc, Circle

from .catalogue import paper
from .page import Figure, Numbers, Section
from .runs import slipdisk
from .style import BLACK, COLOURS, GREY, plt
from .verdict import number, within

RUN = "sync_strong"


def read(path):
    """Named disks of a result of a 3-disk deck, with its tilt."""
    result = slipdisk.Result(path)
    named = [(k, name) for k, name in enumerate(result.names) if name]
    which, place = [k for k, _ in named], result.frames[0]["position"]
    tilt = result.deck.gravity.tilt
    return {"name": [name for _, name in named], "x": place[which, 0], "y": place[which, 1],
            "radius": result.disks["radius"][which], "tilt": [tilt] * len(named)}


def notation(table):
    """Centres, radii and tilt of the named disks; angles of the contact lines."""
    centre = {row["name"]: np.array([row["x"], row["y"]]) for row in table.rows}
    radius = {row["name"]: row["radius"] for row in table.rows}
    tilt = table.rows[0]["tilt"]
    down = np.array([-math.sin(tilt), -math.cos(tilt)])
    alpha = []
    for name in ("left", "right"):
        line = centre[name] - centre["upper"]
        alpha.append(math.acos(line @ down / np.linalg.norm(line)))
    return centre, radius, tilt, alpha


def turned(vector, angle):
    c, s = math.cos(angle), math.sin(angle)
    return np.array([c * vector[0] - s * vector[1], s * vector[0] + c * vector[1]])


def arrow(axes, start, by, colour, width=1.6):
    axes.annotate("", xy=start + by, xytext=start, zorder=6,
                  arrowprops={"arrowstyle": "-|>,head_width=0.25,head_length=0.5", "color": colour, "lw": width,
                              "shrinkA": 0, "shrinkB": 0})


def draw(centre, radius, tilt, alpha):
    """The picture is turned so that gravity points down; the supports then stand at an angle."""
    place = {name: turned(r, tilt) for name, r in centre.items()}
    upper = place["upper"]
    place = {name: r - upper for name, r in place.items()}
    figure, axes = plt.subplots(figsize=(5.6, 5.2), layout="constrained")
    fill = {"upper": "#dbe9f6", "left": "#eeeeee", "right": "#eeeeee"}
    for name, r in place.items():
        axes.add_patch(Circle(r, radius[name], fc=fill[name], ec=BLACK, lw=1.1, zorder=1))
        axes.plot(*r, ".", color=BLACK, ms=4, zorder=5)
    axes.plot([0, 0], [0.25, -2.75], ls=(0, (6, 4)), color=GREY, lw=0.9, zorder=2)
    middle = turned(np.array([0, -1.0]), tilt)  # bisector of the contact lines
    axes.plot(*np.stack([np.zeros(2), 2.45 * middle]).T, ls=":", color=COLOURS[1], lw=1.3, zorder=2)

    for k, name in enumerate(("left", "right")):
        line = place[name]
        unit = line / np.linalg.norm(line)
        axes.plot(*np.stack([np.zeros(2), line]).T, color=GREY, lw=0.9, zorder=2)
        contact = unit * radius["upper"]
        side = turned(unit, math.pi / 2)  # of a positive tau on the upper disk
        arrow(axes, contact, -0.62 * unit, COLOURS[0])
        arrow(axes, contact, 0.62 * side, COLOURS[2])
        off = np.array([-0.26, 0.02]) if k == 0 else np.array([0.2, 0.08])
        axes.text(*(contact - 0.5 * unit + off), f"$n_{k + 1}$", color=COLOURS[0], fontsize=15, ha="center",
                  va="center")
        shift = np.array([-0.27, -0.11]) if k == 0 else np.array([0.17, -0.02])
        axes.text(*(contact + 0.62 * side + shift), f"$\\tau_{k + 1}$", color=COLOURS[2], fontsize=15,
                  ha="center", va="center")
        outer = line + radius[name] * turned(np.array([(-1) ** (k + 1), 0]), (-1) ** (k + 1) * 0.9)
        axes.plot(*np.stack([line, outer]).T, color=BLACK, lw=0.9)
        axes.text(*((line + outer) / 2 + np.array([0.12 * (-1) ** k, 0.08])), "$R$", fontsize=14, ha="center",
                  va="center")
        axes.text(*(line + np.array([0.13 * (-1) ** (k + 1), -0.2])), f"support {k + 1}", fontsize=11, ha="center",
                  va="center")

    for k, (size, reach) in enumerate(((1.3, 0.8), (1.3, 0.8))):
        first, last = (-90 - math.degrees(alpha[0]), -90) if k == 0 else (-90, -90 + math.degrees(alpha[1]))
        axes.add_patch(Arc((0, 0), size, size, theta1=first, theta2=last, color=BLACK, lw=1.1, zorder=4))
        angle = math.radians((first + last) / 2)
        axes.text(reach * math.cos(angle) + (-0.03 if k == 0 else 0.05), reach * math.sin(angle), f"$\\alpha_{k + 1}$",
                  fontsize=15, ha="center", va="center", zorder=7)
    low, high = sorted((-90.0, math.degrees(math.atan2(middle[1], middle[0]))))
    axes.add_patch(Arc((0, 0), 4.5, 4.5, theta1=low, theta2=high, color=COLOURS[1], lw=1.3, zorder=4))
    axes.text(2.45 * math.cos(math.radians((low + high) / 2)) + 0.02, 2.47 * math.sin(math.radians((low + high) / 2)),
              "$\\theta_T$", color=COLOURS[1], fontsize=15, ha="center", va="center")
    last = math.degrees(math.atan2(*place["right"][::-1]))
    axes.add_patch(Arc((0, 0), 3.3, 3.3, theta1=math.degrees(math.atan2(middle[1], middle[0])), theta2=last, color=GREY,
                       lw=1.1, zorder=4))
    angle = math.radians(last - 0.25 * math.degrees(alpha[0] + alpha[1]))
    axes.text(1.84 * math.cos(angle), 1.84 * math.sin(angle), "$\\theta_h$", color=GREY, fontsize=15, ha="center",
              va="center")
    start = np.array([-2.05, 0.65])
    arrow(axes, start, np.array([0, -0.75]), BLACK, 2.2)
    axes.text(*(start + np.array([-0.2, -0.4])), "$g$", fontsize=16, ha="center", va="center")
    axes.add_patch(Arc((0, 0), 1.1, 1.1, theta1=50, theta2=140, color=BLACK, lw=1.2, zorder=4))
    tip = 0.55 * np.array([math.cos(math.radians(140)), math.sin(math.radians(140))])
    arrow(axes, tip + 0.02 * np.array([0.64, 0.77]), np.array([-0.06, -0.08]), BLACK)
    axes.text(0, 0.68, "$\\theta,\\ \\Omega$", fontsize=14, ha="center", va="center")
    axes.text(-0.62, 0.12, "upper disk", fontsize=11, ha="center", va="center")
    axes.set_aspect("equal")
    axes.set_xlim(-2.45, 2.3)
    axes.set_ylim(-2.95, 1.05)
    axes.axis("off")
    return figure


def sections(results):
    out = Section("geometry", "The three disks (fig. disks-notation)",
                  "Drawn from the positions, radii and the tilt of gravity in a result of "
                  "<code>inputs/three_disk/sync.cfg</code>, turned so that gravity points down.")
    path = results.run(RUN)
    table = results.numbers("geometry", lambda: read(path) if path else None, "named disks in units of R, tilt of "
                            "gravity")
    if not table:
        out.missing.append(f"{RUN}: not run yet")
        return [out]
    centre, radius, tilt, alpha = notation(table)
    out.figures.append(Figure("geometry", draw(centre, radius, tilt, alpha), "Upper disk on its two supports. "
                              "<i>n<sub>i</sub></i> and <i>&tau;<sub>i</sub></i>: normal force, and tangential force "
                              "in its positive sense, of support <i>i</i> on the upper disk; "
                              "<i>&alpha;<sub>i</sub></i>: angle of the contact line to the direction of gravity "
                              "(dashed); dotted: bisector of the contact lines, at the tilt "
                              "<i>&theta;<sub>T</sub></i> to gravity; the angle between a contact line and the "
                              "bisector is <i>&theta;<sub>h</sub></i>. Positive angles are counter-clockwise.",
                              "Three disks: an upper " "one resting on two supports, with contact angles, forces, tilt "
                              "and gravity labelled"))
    half, found = (alpha[0] + alpha[1]) / 2, (alpha[1] - alpha[0]) / 2
    out.claims += [within(value=alpha[0] + alpha[1], target=math.pi / 3, tolerance=1e-3, **paper("aperture")),
                   within(value=found, target=tilt, tolerance=1e-3, names=("from the positions", "deck's tilt of "
                                                                           "gravity"), **paper("tilt"))]
    rows = [[f"centre of the {name} disk, x, y", f"{r[0]:.6g}, {r[1]:.6g}"] for name, r in centre.items()]
    rows += [["radii", ", ".join(f"{r:g}" for r in radius.values())],
             ["&alpha;<sub>1</sub>/&pi;, " "&alpha;<sub>2</sub>/&pi;", f"{alpha[0] / math.pi:.6f}, "
              f"{alpha[1] / math.pi:.6f}"], ["&theta;<sub>h</sub>/&pi;, &theta;<sub>T</sub>/&pi;",
                                             f"{half / math.pi:.6f}, {found / math.pi:.6f}"],
             ["tilt of gravity in the " "deck/&pi;", number(tilt / math.pi)]]
    out.tables.append(Numbers("Geometry", ["what", "value"], rows))
    return [out]
