"""Directions and levers of contacts, written down a second time: from poses of bodies, as physics.md has them."""
import math

import numpy as np


def pieces_of(wall):
    """Of a straight wall."""
    return len(wall["points"]) - 1 + bool(wall.get("closed"))


class Wall:
    """A wall of a deck, which has moved to a pose (x, y, angle)."""

    def __init__(self, wall):
        self.wall = wall
        self.kind = wall["type"]
        points = wall.get("points", ())
        self.pivot = np.array(wall.get("pivot", wall.get("center", np.mean(points, axis=0) if len(points) else (0, 0))), float)

    def ends(self, part):
        points = self.wall["points"]
        return np.array(points[part], float), np.array(points[(part + 1) % len(points)], float)

    def to_wall(self, pose, at):
        c, s = math.cos(pose[2]), math.sin(pose[2])
        x, y = at[0] - pose[0], at[1] - pose[1]
        return np.array([c * x + s * y, -s * x + c * y]) + self.pivot

    def from_wall(self, pose, way):
        c, s = math.cos(pose[2]), math.sin(pose[2])
        return np.array([c * way[0] - s * way[1], s * way[0] + c * way[1]])

    def nearest(self, at, part, radius):
        """(way from `at` to the nearest point, lever of the tangential force, arm of rolling), in the wall's frame."""
        if self.kind == "arc":
            return self.on_arc(at, radius)
        a, b = self.ends(part)
        along = float(np.dot(at - a, b - a) / np.dot(b - a, b - a))
        if self.kind == "line" or 0 < along < 1:
            return a + along * (b - a) - at, 1.0, radius
        way = (a if along <= 0 else b) - at
        return way, radius / float(np.hypot(*way)), radius

    def on_arc(self, at, radius):
        centre, rho = np.array(self.wall["center"], float), self.wall["radius"]
        out = at - centre
        r = float(np.hypot(*out))
        turn = (math.atan2(out[1], out[0]) - self.wall["from"]) % (2 * math.pi)
        if turn <= self.wall["to"] - self.wall["from"]:
            side = -1.0 if r < rho else 1.0  # inside: as a round wall of negative radius
            return out * (rho / r - 1), (radius + side * rho) / (abs(rho - r) + side * rho), radius * rho / (rho + side * radius)
        ends = [centre + rho * np.array([math.cos(a), math.sin(a)]) - at for a in (self.wall["from"], self.wall["to"])]
        way = min(ends, key=lambda w: np.hypot(*w))
        return way, radius / float(np.hypot(*way)), radius


class Scene:
    """Bodies of a deck by number; edges of the periodic box, 0 where there are none."""

    def __init__(self, deck, edges):
        self.edges, self.walls = edges, [Wall(wall) for wall in deck.get("walls", ())]
        self.radii = [d["radius"] for d in deck["disks"]]
        self.paper = deck.get("contact_variant", "paper") == "paper"

    def least(self, d):
        return d - np.where(self.edges > 0, self.edges * np.round(d / np.where(self.edges > 0, self.edges, 1.0)), 0.0)

    def contact(self, row, poses):
        """(n from a's centre to b's surface, lever of tau, arm of rolling, radius of b as the law has it, way from b to a)"""
        a, b = int(row["a"]), int(row["b"])
        n_disks, radius = len(self.radii), self.radii[a]
        pose = poses[b]
        if b >= n_disks and self.walls[b - n_disks].kind != "circle":
            at, way, lever, arm = self.piece(self.walls[b - n_disks], pose, poses[a][:2], radius, row["overlap"])
            return way / np.hypot(*way), lever, arm, 0.0, at - pose[:2]
        d = self.least(pose[:2] - poses[a][:2])
        other = self.radii[b] if b < n_disks else self.walls[b - n_disks].wall["radius"]
        if b >= n_disks and self.walls[b - n_disks].wall["side"] == "inside":
            other = -other
        r = math.copysign(float(np.hypot(*d)), radius + other)
        return d / r, 1.0 if self.paper else (radius + other) / r, radius * other / (radius + other), other, -d

    def piece(self, wall, pose, disk, radius, overlap):
        """The piece of a wall, and the image of the disk, that have this overlap; pieces of images have numbers of their own."""
        best, found = 1e9, None
        for x in (0, 1, -1) if self.edges[0] > 0 else (0,):
            for y in (0, 1, -1) if self.edges[1] > 0 else (0,):
                at = disk + self.edges * (x, y)
                for part in range(1 if wall.kind == "arc" else pieces_of(wall.wall)):
                    way, lever, arm = wall.nearest(wall.to_wall(pose, at), part, radius)
                    off = abs(np.hypot(*way) - (radius - overlap))
                    if off < best - 1e-12:
                        best, found = off, (at, wall.from_wall(pose, way), lever, arm)
        return found
