"""A film of one period: the three disks with their forces, and their velocities beside them."""
import math
import os

import numpy as np
from matplotlib.animation import FuncAnimation, PillowWriter

from .mechanism_theory import SIGNS
from .style import BLACK, COLOURS, GREY, plt, zero_line

FRAMES, PER_SECOND = 60, 10
TURN = 0.5    # rad: amplitude of the supports' angles as drawn
SHIFT = 250   # displacements of the upper centre are drawn so many times larger
ARROW = 1.0   # length of a normal force m g
NAMES = {**{key: "$S^{" + "".join("+" if s > 0 else "-" for s in signs) + "}$" for key, signs in SIGNS.items()},
         "stick": "a contact sticks", "open": "a contact is open"}


def write(table, folder):
    """folder/figures/cycle.gif; table: one period as of mechanism_portrait."""
    os.makedirs(os.path.join(folder, "figures"), exist_ok=True)
    ks = np.linspace(0, len(table) - 1, FRAMES, endpoint=False).round().astype(int)
    picture, (left, right) = plt.subplots(1, 2, figsize=(7.2, 3.5), width_ratios=(1, 1.25), layout="constrained")
    scene = Scene(left, table)
    marker = velocities(right, table)
    title = picture.suptitle(" ", fontsize=12)

    def update(k):
        scene.show(k)
        marker.set_xdata([table.rows[k]["time"] / table.rows[-1]["time"]] * 2)
        title.set_text(NAMES[table.rows[k]["configuration"]])
        return ()

    update(0)
    picture.canvas.draw()
    picture.set_layout_engine("none")  # else the axes move from frame to frame
    film = FuncAnimation(picture, lambda n: update(ks[n]), frames=len(ks))
    film.save(os.path.join(folder, "figures", "cycle.gif"), writer=PillowWriter(PER_SECOND), dpi=80)
    plt.close(picture)


def velocities(axis, table):
    """Velocities of the surfaces over the period; returns the line that marks the time."""
    time = table.column("time") / table.rows[-1]["time"]
    unit = np.abs(table.column("spin_left")).max()
    axis.plot(time, -table.column("spin_left") / unit, color=BLACK, lw=1.2, label="left support")
    axis.plot(time, -table.column("spin_right") / unit, color=BLACK, lw=1.2, ls="--", label="right support")
    axis.plot(time, table.column("spin_upper") / unit, color=COLOURS[1], lw=1.8, label="upper disk")
    zero_line(axis)
    axis.set(xlim=(0, 1), xlabel="time / period", ylabel="velocity of the surface")
    axis.legend(loc="lower center", bbox_to_anchor=(0.5, 1), ncol=3, fontsize=8, handlelength=1.6, columnspacing=0.8)
    return axis.axvline(0, color=GREY, lw=1)


class Scene:
    """Three disks with marks, the contacts' normal (grey) and tangential forces on the upper disk (coloured)."""

    def __init__(self, axis, table):
        self.table, self.axis = table, axis
        self.magnify = TURN / max(np.ptp(table.column("angle_left")) / 2, 1e-300)
        self.middle = [float(table.column(c).mean()) for c in ("angle_upper", "angle_left", "angle_right")]
        self.centre = [float(table.column(c).mean()) for c in ("x", "y")]
        first = table.rows[0]
        self.places = [(0.0, 0.0), (first["x_left"], first["y_left"]), (first["x_right"], first["y_right"])]
        self.disks = [axis.add_patch(plt.Circle(place, 1, fc="#E8EEF4" if k else "#FBE6D8", ec=BLACK, lw=1))
                      for k, place in enumerate(self.places)]
        self.marks = [axis.plot([], [], color=BLACK if k else COLOURS[1], lw=1.6)[0] for k in range(3)]
        self.arrows = []
        axis.set(xlim=(-2.1, 2.1), ylim=(-2.85, 1.45), aspect="equal", xticks=[], yticks=[])
        axis.spines[:].set_visible(False)

    def show(self, k):
        row = self.table.rows[k]
        centre = [SHIFT * (row[c] - m) for c, m in zip(("x", "y"), self.centre)]
        places = [centre, *self.places[1:]]
        self.disks[0].center = centre
        for mark, place, name, middle in zip(self.marks, places, ("upper", "left", "right"), self.middle):
            turned = self.magnify * (row[f"angle_{name}"] - middle) + math.pi / 2
            cos, sin = math.cos(turned), math.sin(turned)
            mark.set_data([place[0], place[0] + cos], [place[1], place[1] + sin])
        for arrow in self.arrows:
            arrow.remove()
        self.arrows = []
        for (x, y), n, tau in zip(self.places[1:], (row["n1"], row["n2"]), (row["tau1"], row["tau2"])):
            length = math.hypot(x, y)
            normal = np.array([-x, -y]) / length           # from the support to the upper disk
            along = np.array([normal[1], -normal[0]])      # a positive torque pushes its surface this way
            start = np.array([x, y]) + normal
            self.arrow(start, ARROW * n * normal, GREY)
            self.arrow(start, 5 * ARROW * tau * along, COLOURS[0 if tau > 0 else 3])

    def arrow(self, start, way, colour):
        self.arrows.append(self.axis.annotate("", start + way, start, arrowprops={
            "arrowstyle": "-|>", "color": colour, "lw": 2, "shrinkA": 0, "shrinkB": 0, "mutation_scale": 10}))
