"""Rotation against depth within a packing: disks near the surface and near the floor."""
import itertools

import numpy as np

from ratchet.page import Figure, Numbers, Section
from ratchet.style import COLOURS, figure, legend_below
from ratchet.verdict import MOTIONS, SURE, beside, decide, missing, number

from .drive import bars
from .scans import DRIVES, is_base, row_of, runs_of
from .statistics import mean_error, spearman

LAYER = 2.0   # mean diameters
SHOWN = ((60, 10), (240, 10), (500, 29), (10000, 100))  # disks, width
TEXT = "Disks turn faster the nearer they are to the surface"


def sections(campaign):
    out = Section("depths", "Rotation against depth",
                  "The boxes of <code>shake_size.cfg</code>, <code>shake_1e4.cfg</code> and those of 60 disks of the "
                  "scans. The depth of a disk is that of its centre below the highest point of the packing within a mean diameter to its sides, at "
                  "the end of the run. Error bars: scatter of packings; of the 10000 disks, of tenths of its width.")
    ranks = campaign.numbers("depth-ranks", lambda: rank_rows(campaign), "each packing: Spearman's correlation of "
                             "|Omega| and depth; share of the top layer in the sum of Omega^2, and among the disks")
    table = campaign.numbers("depths", lambda: profile_rows(campaign), "rms and median of |Omega| (rad/s) against "
                             "depth (mean diameters)")
    out.claims += beside(*([claim(drive, [row for row in ranks.rows if row["drive"] == drive and row["motion"] == motion])
                            for drive in DRIVES] for motion in MOTIONS))
    if table.rows:
        out.figures.append(profiles(table))
    out.tables.append(Numbers("Depth and rotation: each size of box",
                              ["motion", "disks", "width/d", "drive/<i>g</i>", "packings", "correlation of |&Omega;| with depth",
                               "error", "share of the top layer in &Omega;&sup2;", "error", "of the disks", "error"],
                              summary(ranks.rows)))
    return [out]


def boxes_of(campaign):
    """(motion, disks, width, drive, run) of what is compared: the boxes of all sizes, and that which all scans share."""
    for entry, motion, run in runs_of(campaign):
        row = row_of(entry, motion, run)
        if row["varied"] == "size" or is_base(row):
            yield motion, row["disks"], int(round(row["width"])), row["drive"], run


def depths(x, y, radius):
    """Depth of each disk, in mean diameters, below the highest point within a mean diameter to its sides."""
    diameter = 2 * float(np.mean(radius))
    order = np.argsort(x)
    left, right = np.searchsorted(x[order], x - diameter), np.searchsorted(x[order], x + diameter, side="right")
    top = (y + radius)[order]
    return (np.array([top[a:b].max() for a, b in zip(left, right)]) - y) / diameter


def rank_rows(campaign):
    found = []
    for motion, disks, width, drive, run in boxes_of(campaign):
        depth = depths(run.x_end, run.y_end, run.radius)
        top = depth < LAYER
        found.append({"motion": motion, "disks": disks, "width": width, "drive": drive, "seed": run.seed,
                      "correlation": spearman(depth, np.abs(run.omega)),
                      "share": float(np.sum(run.omega[top] ** 2) / np.sum(run.omega ** 2)), "of": float(top.mean())})
    return {key: [row[key] for row in found] for key in found[0]} if found else None


def profile_rows(campaign):
    """rms in layers of the boxes that are drawn, mean and error over packings (or tenths of a large one)."""
    groups = {}
    for motion, disks, width, drive, run in boxes_of(campaign):
        if (disks, width) in SHOWN:
            depth = depths(run.x_end, run.y_end, run.radius)
            parts = [np.ones(len(depth), bool)]
            if disks >= 5000:
                place = np.minimum((10 * (run.x_end - run.x_end.min()) / np.ptp(run.x_end)).astype(int), 9)
                parts = [place == k for k in range(10)]
            groups.setdefault((motion, disks, width, drive), []).extend((depth[part], run.omega[part]) for part in parts)
    found = []
    for (motion, disks, width, drive), samples in groups.items():
        deepest = max(float(depth.max()) for depth, _ in samples)
        edges = np.arange(0, deepest + LAYER, LAYER) if disks < 5000 else np.concatenate(
            [np.arange(0, 12, LAYER), np.geomspace(12, deepest + 1, 8)])
        for low, high in zip(edges[:-1], edges[1:]):
            layers = [omega[(depth >= low) & (depth < high)] for depth, omega in samples]
            layers = [layer for layer in layers if len(layer)]
            if sum(map(len, layers)) >= 10:
                rms = mean_error([float(np.sqrt(np.mean(layer ** 2))) for layer in layers])
                median = mean_error([float(np.median(np.abs(layer))) for layer in layers])
                found.append({"motion": motion, "disks": disks, "width": width, "drive": drive, "depth": 0.5 * (low + high),
                              "rms": rms[0], "rms_error": rms[1], "median": median[0], "median_error": median[1],
                              "number": sum(map(len, layers))})
    return {key: [row[key] for row in found] for key in found[0]} if found else None


def claim(drive, rows):
    text, slug = f"{TEXT}, at {drive:g} <i>g</i>.", f"depth-{drive:g}g"
    boxes = {}
    for row in rows:
        boxes.setdefault((row["disks"], row["width"]), []).append(row["correlation"])
    mean, error = mean_error([value for values in boxes.values() for value in values])
    if not error > 0:
        return missing(text, slug=slug)
    sizes = "; ".join(f"{disks:g} disks, {width:g} wide: {number(*mean_error(values))}"
                      for (disks, width), values in sorted(boxes.items()))
    return decide(text, False if mean > SURE * error else True if mean < -SURE * error else None,
                  f"Spearman's correlation of |&Omega;| and depth: {number(mean, error)} in the mean of "
                  f"{sum(map(len, boxes.values()))} packings of all sizes ({sizes})", slug=slug)


def summary(rows):
    boxes = {}
    for row in rows:
        boxes.setdefault((row["motion"], row["disks"], row["width"], row["drive"]), []).append(row)
    return [[motion, disks, width, drive, len(some), *(cell for name in ("correlation", "share", "of")
                                                for cell in mean_error([row[name] for row in some]))]
            for (motion, disks, width, drive), some in sorted(boxes.items())]


def profiles(table):
    picture, axes = figure(columns=2 * len(DRIVES), rows=2, width=8.4, height=5.2, legend=True, sharex=True, sharey="row")
    for column, (motion, drive) in zip(axes.T, itertools.product(MOTIONS, DRIVES)):
        for panel, quantity in zip(column, ("rms", "median")):
            for k, (disks, width) in enumerate(SHOWN):
                here = table.where(motion=motion, disks=disks, width=width, drive=drive)
                if here.rows:
                    x, y, error = map(here.column, ("depth", quantity, quantity + "_error"))
                    panel.errorbar(x, y, yerr=bars(y, error), fmt="osD^"[k] + "-", lw=0.7, ms=4, color=COLOURS[k],
                                   mfc="white", label=f"{disks} disks")
            panel.set_xscale("log")
            panel.set_yscale("log")
            panel.set_xticks([1, 3, 10, 30, 100], ["1", "3", "10", "30", "100"])
        column[0].set_title(f"{motion}, {drive:g} $g$", fontsize=10)
        column[1].set_xlabel("depth / mean diameter")
    legend_below(picture, list(axes[0])[::-1], 4)
    axes[0, 0].set_ylabel(r"rms $\Omega$ of the layer (rad/s)")
    axes[1, 0].set_ylabel(r"median $|\Omega|$ (rad/s)")
    return Figure("depths", picture, "Rms and median of the mean angular velocities of the disks in layers of the "
                                     "packing against their depth below the surface. Deep down the rms is that of few "
                                     "loose disks.", "Angular velocity against depth in the packing")
