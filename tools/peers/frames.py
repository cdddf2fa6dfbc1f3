"""Frames of each program as the same arrays, and what is compared of them: contacts, overlaps, kinetic energy, places.

Contacts are found here, from positions, by one function for all: what a program counts itself is not asked."""
import dataclasses

import numpy as np
from slipdisk import sealed

from . import inputs


@dataclasses.dataclass
class Frame:
    step: int
    x: np.ndarray
    y: np.ndarray
    vx: np.ndarray
    vy: np.ndarray
    omega: np.ndarray
    floor: float                # height of the floor


def floor_at(step):
    """Height and velocity of the floor."""
    angle = 2 * np.pi * (step % inputs.PERIOD) / inputs.PERIOD
    return inputs.AMPLITUDE * (1 - np.cos(angle)), inputs.AMPLITUDE * inputs.W * np.sin(angle)


def of_slipdisk(path):
    with sealed.read(path) as file:
        disks = file["particles/disks"]
        steps = disks["position/step"][:]
        return [Frame(int(step), *disks["position/value"][k].T, *disks["velocity/value"][k].T,
                      disks["angular_velocity/value"][k], float(floor_at(step)[0])) for k, step in enumerate(steps)]


def of_dump(path, first=0, floor_rests=False):
    """Frames of a dump with the columns id x y vx vy omegaz, sorted by id. first: the step that counts as 0.
    floor_rests: they are seen from the floor, and are taken back to where it moves."""
    frames = []
    with open(path) as file:
        while True:
            head = [file.readline() for _ in range(9)]
            if not head[0]:
                return frames
            step, count = int(head[1]) - first, int(head[3])
            columns = head[8].split()[2:]
            if columns != ["id", "x", "y", "vx", "vy", "omegaz"]:
                raise ValueError(f"{path}: columns {columns}")
            table = np.loadtxt(file, max_rows=count, ndmin=2)
            if not np.array_equal(table[:, 0], np.arange(1, count + 1)):
                raise ValueError(f"{path}: step {step + first}: disks are missing")
            height, speed = floor_at(step)
            frame = Frame(step, *table[:, 1:].T.copy(), float(height))
            if floor_rests:
                frame.y += height
                frame.vy += speed
            frames.append(frame)


# --- what is compared -----------------------------------------------------------------------------------------
def pairs(x, y, reach, width):
    """All pairs of disks that are nearer than reach, as two arrays of numbers; periodic along x over width."""
    columns = max(int(width / reach), 1)
    column = np.floor(x / width * columns).astype(int) % columns
    row = np.floor((y - y.min()) / reach).astype(int) + 1
    rows = row.max() + 2
    cell = column * rows + row
    order = np.argsort(cell, kind="stable")
    number, begin, count = np.unique(cell[order], return_index=True, return_counts=True)
    start, size = np.zeros(columns * rows, dtype=int), np.zeros(columns * rows, dtype=int)
    start[number], size[number] = begin, count
    found = []
    # Each cell with half of its neighbours; with one or two columns neighbours would be met twice.
    offsets = {(dc % columns, dr) for dc, dr in ((0, 0), (0, 1), (1, -1), (1, 0), (1, 1))}
    if columns < 3:
        raise ValueError("a box of at least three cells is needed")
    for dc, dr in offsets:
        other = (column + dc) % columns * rows + row + dr
        for k in range(size.max()):
            has = np.flatnonzero(size[other] > k)
            partner = order[start[other[has]] + k]
            keep = has < partner if (dc, dr) == (0, 0) else np.ones(len(has), dtype=bool)
            a, b = has[keep], partner[keep]
            dx, dy = x[b] - x[a], y[b] - y[a]
            dx -= width * np.round(dx / width)
            near = dx * dx + dy * dy < reach * reach
            found.append((a[near], b[near]))
    return tuple(np.concatenate(part) for part in zip(*found))


def overlaps(frame, radius, width):
    """Overlaps of all closed contacts, first those of disks with each other, then with the floor."""
    a, b = pairs(frame.x, frame.y, 2.001 * radius.max(), width)
    dx = frame.x[b] - frame.x[a]
    dx -= width * np.round(dx / width)
    between = radius[a] + radius[b] - np.hypot(dx, frame.y[b] - frame.y[a])
    below = radius - (frame.y - frame.floor)
    return np.concatenate([between[between > 0], below[below > 0]])


def kinetic_energy(frame, mass, radius):
    """Per disk, of translation and rotation."""
    energy = 0.5 * mass * (frame.vx**2 + frame.vy**2) + 0.25 * mass * (radius * frame.omega)**2
    return float(energy.mean())


@dataclasses.dataclass
class Physics:
    contacts: float             # closed, per disk, mean over frames
    overlap: float              # mean over contacts and frames
    kinetic: float              # per disk, mean over frames
    last: Frame


def physics(frames, packing):
    """Means over frames, without the one at step 0, which is the same for all."""
    contacts, overlap, kinetic = [], [], []
    for frame in frames:
        if frame.step == 0:
            continue
        found = overlaps(frame, packing.radius, packing.width)
        contacts.append(len(found) / packing.count)
        overlap.append(found.mean())
        kinetic.append(kinetic_energy(frame, packing.mass, packing.radius))
    return Physics(float(np.mean(contacts)), float(np.mean(overlap)), float(np.mean(kinetic)), frames[-1])


def distance(one, other, width):
    """Root mean square distance between the disks of two frames."""
    dx = one.x - other.x
    dx -= width * np.round(dx / width)
    return float(np.sqrt(np.mean(dx**2 + (one.y - other.y)**2)))
