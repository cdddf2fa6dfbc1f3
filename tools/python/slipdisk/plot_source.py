"""What pictures are made from: a result with its frames, walls, contacts and measured tables; quantities that colour disks."""
from __future__ import annotations

import functools
import io
import os
import tempfile
from typing import Any

import numpy as np
from numpy.typing import NDArray

from . import library as lib
from . import plot_style as style
from .arguments import ARGUMENTS, Fixed, checked, is_path
from .measure import mean
from .program import call
from .result import Result
from .stored import Columns, Frames

ARGUMENTS["Result"] = (lambda value: isinstance(value, Result)), "a Result"
LINE, SEGMENT, POLYLINE, CIRCLE, ARC = range(5)  # the points of an arc lie close together


def read_csv(path):
    """{column: array} of a table of numbers; empty cells are nan."""
    with open(path, encoding="utf-8") as file:
        names = file.readline().rstrip("\n").split(",")
        text = file.read()
    for empty, filled in ((",,", ",nan,"), (",,", ",nan,"), (",\n", ",nan\n")):  # numpy's reader is fast, but has no empty cells
        text = text.replace(empty, filled)
    table = np.loadtxt(io.StringIO(text), delimiter=",", ndmin=2) if text else np.empty((0, len(names)))
    return {name: table[:, k] for k, name in enumerate(names)}


class Source(Fixed):
    """A result, and what pictures ask of it; what has been read or measured once is kept."""

    @checked
    def __init__(self, result: lib.StrPath | Result) -> None:
        self._set(result=result if isinstance(result, Result) else Result(result))
        self._set(path=self.result.path)

    @classmethod
    def of(cls, result: Drawable) -> Source:
        return result if isinstance(result, cls) else cls(result)

    # --- what it is -------------------------------------------------------------------------------------------
    @functools.cached_property
    def series(self) -> Columns[NDArray[Any]]:
        return self.result.series

    @functools.cached_property
    def frames(self) -> Frames:
        return self.result.frames

    @functools.cached_property
    def n_frames(self) -> int:
        return len(self.frames)

    @functools.cached_property
    def frame_times(self) -> NDArray[np.float64]:
        return self.frames.time

    @functools.cached_property
    def rotation(self) -> NDArray[np.void]:
        return self.result.rotation

    @functools.cached_property
    def slide(self) -> NDArray[np.void]:
        return self.result.slide

    @functools.cached_property
    def _deck(self):
        try:
            return self.result.deck
        except lib.UserError:  # in a file that others have made
            return {}

    @functools.cached_property
    def title(self) -> str:
        return style.plain(self._deck.get("title", ""), 120)

    @functools.cached_property
    def gravity(self) -> NDArray[np.float64]:
        if self._whole:
            return np.asarray(self.result.rows("parameters/model/gravity"), float)
        gravity = self._deck.get("gravity", {})
        g, tilt = gravity.get("g", 0.0), gravity.get("tilt", 0.0)
        return -g * np.array([np.sin(tilt), np.cos(tilt)])

    @functools.cached_property
    def phases(self) -> list[tuple[str, float, float]]:
        """[(name, begin, end)] in time, of those that have begun."""
        found, begin, rows = [], 0, self.result.phases
        for row in rows if rows is not None else []:
            end = begin + int(row["steps"]) if row["steps"] else self.result.step
            if end > begin:
                found.append((style.plain(row["name"]), begin * self.result.dt, end * self.result.dt))
            begin = end
        return found

    @functools.cached_property
    def radius(self) -> NDArray[np.float64]:
        if self._whole:
            return self.result.rows("particles/disks/radius")
        return self.result.disks["radius"]

    @functools.cached_property
    def driven(self) -> NDArray[np.bool_]:
        if self._whole:
            return self.result.rows("particles/disks/driven") != 0
        held = np.ones(len(self.radius), bool)
        held[self.result.state["id"][:self.result.attributes("state").n_free]] = False
        return held

    @functools.cached_property
    def _whole(self):
        """Whether it is a finished file: unfinished runs have what does not change in their state and in /parameters/deck_bodies."""
        return os.path.isfile(self.path)

    def _bodies(self, kind):
        """Lines of this kind of /parameters/deck_bodies, as words."""
        return [line.split("\t")[1:] for line in self.result.rows("parameters/deck_bodies").split("\n") if line.startswith(kind + "\t")]

    # --- series -----------------------------------------------------------------------------------------------
    def parts(self, name: str) -> list[str]:
        """Names of the values that a row of a series has, as of disks or walls; empty for a single value."""
        row = self.result.rows(self.series._path(name), 0, 1)
        if row.ndim == 1:
            return []
        of = name.split("_")[0]
        disks = {"angle": "watched_disks", "angular": "watched_disks", "disk": "contact_disks"}
        if of in disks:
            return [self.disk_name(int(k)) for k in self.result.rows(f"observables/{disks[of]}")]
        return [style.plain(part) for part in self.result.rows(f"observables/{of}s").split("\n")[:row.shape[1]]]

    @functools.cached_property
    def columns(self) -> dict[str, tuple[str, str]]:
        """{name: (unit, meaning)} of the columns that there are in time: the series, what follows from them (DERIVED), and the
        single values of series that have several, as lid.wall_normal."""
        if "time" not in self.series or len(self.series["time"]) < 2:
            return {}
        found = {name: (self.series.unit(name), self.series.meaning(name)) for name in self.series}
        found |= {name: (one.unit, one.meaning) for name, one in DERIVED.items() if not one.lacks(self)}
        return found | {f"{part}.{name}": found[name] for name in self.series if name != "time" for part in self.parts(name)}

    def fraction_of(self, name: str) -> tuple[NDArray[Any], NDArray[Any] | None]:
        """(numerator, denominator) of a column, the latter None where there is none."""
        if name not in self.columns:
            raise lib.unknown(name, list(self.columns), f"the series of {self.path}")
        if name in DERIVED:
            return DERIVED[name].of(self)
        part, _, column = name.rpartition(".")
        return self.series[column] if not part else self.series[column][:, self.parts(column).index(part)], None

    def column(self, name: str) -> NDArray[Any]:
        """The rows of a column; nan where its denominator is not positive."""
        top, bottom = self.fraction_of(name)
        return top if bottom is None else top / np.where(bottom > 1e-3 * np.nanmax(bottom), bottom, np.nan)

    def averaged(self, name: str) -> Any:
        """A Record as slipdisk.mean gives it of a column over the measured time, of a ratio that of the means of numerator and
        denominator."""
        top, bottom = self.fraction_of(name)
        span = float(self.result.summary["measured_time"]) or self.phases[-1][2] - self.phases[-1][1]
        keep = self.series["time"] > self.result.time - span * (1 + 1e-9)
        return mean(top[keep], over=None if bottom is None else bottom[keep])

    def disk_name(self, number: int) -> str:
        return style.plain(self.names[number] or f"disk {number}")

    @functools.cached_property
    def names(self) -> list[str]:
        return self.result.names

    @functools.cached_property
    def body_names(self) -> list[str]:
        """Names of all bodies: disks, then walls."""
        return [self.disk_name(k) for k in range(self.result.summary["disks"])] + [style.plain(words[0]) for words in self._bodies("wall")]

    @functools.cached_property
    def groups(self) -> list[str]:
        return [style.plain(words[0]) for words in self._bodies("group")]

    @functools.cached_property
    def usual_frame(self) -> int:
        """The last frame in which at least half of the disks are there that ever are: a hopper is empty at the end."""
        if "activity" not in self.frames._names:
            return self.n_frames - 1
        count = (self.frames["activity"] == 0).sum(1)
        return int(np.flatnonzero(2 * count >= count.max())[-1])

    # --- frames -------------------------------------------------------------------------------------------------
    def frame_number(self, frame: int | None) -> int:
        """0 ... n - 1 of a number that may count from the end; None: the usual one."""
        if not self.n_frames:
            raise lib.UserError(f"{self.path}: there is no frame yet")
        if frame is None:
            return self.usual_frame
        number = frame + self.n_frames if frame < 0 else frame
        if not 0 <= number < self.n_frames:
            raise lib.UserError(f"{self.path}: there is no frame {frame}; it has {self.n_frames} frames")
        return number

    def frame(self, name: str, k: int, group: str = "disks") -> NDArray[Any]:
        """Quantity `name` of frame k."""
        return self.result.rows(f"particles/{group}/{name}/value", k, k + 1)[0]

    @functools.lru_cache(maxsize=4)  # noqa: B019  a source lives as long as its picture
    def in_play(self, k: int) -> NDArray[np.bool_]:
        """Which disks are there: neither waiting nor taken out."""
        if "activity" not in self.frames._names:
            return np.ones(len(self.radius), bool)
        return self.frame("activity", k) == 0

    @functools.cached_property
    def box(self) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.bool_]]:
        """(lower corner, edges, periodic) of the deck's box."""
        periodic, x, y = np.array(self._bodies("box")[0][0].split(), float).reshape(3, 2)
        lower, upper = np.array([x, y]).T
        if "edges" in self.result.groups("particles/disks/box"):
            edges = self.result.rows("particles/disks/box/edges/value")
        else:
            edges = np.where(periodic > 0, upper - lower, 0.0)
        return lower, np.asarray(edges, float), periodic > 0

    def box_at(self, k: int) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.bool_]]:
        """(lower corner, edges, periodic) at frame k: compression and deformation change the edges."""
        lower, edges, periodic = self.box
        edges = edges[k] if edges.ndim > 1 else edges
        return lower, edges.diagonal() if edges.ndim == 2 else edges, periodic

    def offset_at(self, k: int) -> float:
        """By how much a row of periodic images is shifted against the one below, in a box that deforms."""
        edges = self.box[1]
        return edges[k][1, 0] if edges.ndim == 3 else 0.0

    def place(self, k: int, whole: bool = False) -> NDArray[np.float64]:
        """[disk][2] of frame k; whole: with the periodic images that were crossed."""
        place = self.frame("position", k)
        if not whole:
            return place
        image = self.frame("image", k)
        shift = np.column_stack([image[:, 1] * self.offset_at(k), np.zeros(len(image))])
        return place + image * np.nan_to_num(self.box_at(k)[1]) + shift

    @functools.cached_property
    def shapes(self) -> Any:
        """[(kind, points, pivot, radius, closed)] of the walls as the deck has them."""
        if not len(self.result.wall_frames):
            return []
        if not self._whole:
            return [self._shape(words[2]) for words in self._bodies("wall")]
        at = "particles/walls/shape/"
        kind, count, points, pivot, radius, closed = (self.result.rows(at + name) for name in
                                                      ("kind", "count", "points", "pivot", "radius", "closed"))
        last = np.cumsum(count)
        return [(int(kind[i]), points[last[i] - count[i]:last[i]], pivot[i], float(radius[i]), bool(closed[i]))
                for i in range(len(kind))]

    @staticmethod
    def _shape(text):
        kind, closed, _, radius, *rest = map(float, text.split())
        return int(kind), np.array(rest[2:]).reshape(-1, 2), np.array(rest[:2]), radius, bool(closed)

    def walls(self, k: int) -> Any:
        """[(kind, points, radius, angle)] at frame k; of a circle the point is its centre."""
        if not self.shapes:
            return []
        place, angle = self.frame("position", k, "walls"), self.frame("angle", k, "walls")
        found = []
        for i, (kind, points, pivot, radius, closed) in enumerate(self.shapes):
            c, s = np.cos(angle[i]), np.sin(angle[i])
            if kind == CIRCLE:
                found.append((kind, place[i][None], radius, float(angle[i])))
                continue
            moved = (points - pivot) @ np.array([[c, s], [-s, c]]) + place[i]
            found.append((kind, np.vstack([moved, moved[:1]]) if closed else moved, 0.0, float(angle[i])))
        return found

    # --- bonds ----------------------------------------------------------------------------------------------------
    @functools.cached_property
    def breaks(self) -> dict[str, NDArray[Any]] | None:
        """Columns of the bonds that have broken so far: step, a, b, x, y, mode, energy, and time; None without bonds."""
        state = self.result.state
        if "break_step" not in state or not (len(state["break_step"]) or "bonds" in self.series):
            return None
        rows = {name: state[f"break_{name}"] for name in ("step", "a", "b", "x", "y", "mode", "energy")}
        return {**rows, "time": rows["step"] * self.result.dt}

    def pulls(self, k: int) -> NDArray[np.float64] | None:
        """Forces of the bonds in the contacts of frame k, in the order of `measured`, tension positive; nan where there is none. None
        without a contact table of that frame."""
        tables = self.result.contacts
        if not len(tables) or "bond" not in tables._names:
            return None
        rows = np.flatnonzero(tables.step == self.frames.step[k])
        if not len(rows):
            return None
        table = tables[int(rows[0])]
        return np.where(table["bond"] > 0, table["bond_pull"], np.nan)

    # --- tables of `slipdisk measure` -------------------------------------------------------------------------------
    def _measure(self, words):
        with tempfile.TemporaryDirectory(prefix="slipdisk-plot-") as folder:
            call("measure", self.path, *words, "--csv", folder, "-o", os.path.join(folder, "page.json"))
            return {name.removesuffix(".csv"): read_csv(os.path.join(folder, name)) for name in os.listdir(folder)
                    if name.endswith(".csv") and name not in ("rotation.csv", "means.csv")}

    @functools.lru_cache(maxsize=2)  # noqa: B019
    def measured(self, k: int) -> dict[str, dict[str, NDArray[np.float64]]]:
        """Tables of frame k by name: frames, disks, contacts, gr, forces."""
        return self._measure(["--frame", k])

    def pairs(self, k: int, wide: float) -> dict[str, NDArray[np.float64]]:
        """Table gr of frame k with bins of `wide`, as nearly as whole bins allow."""
        table = self.measured(k)["gr"]
        width = 2 * table["r"][0]
        if width > 1.2 * wide:
            return self._measure(["--frame", k, "--bins", int(np.ceil(len(table["r"]) * width / wide))])["gr"]
        return table

    @functools.cached_property
    def measured_frames(self) -> dict[str, NDArray[np.float64]]:
        """The table of all frames, a row each."""
        return self._measure(["--all"])["frames"]


# --- what follows from series ------------------------------------------------------------------------------------------
class Derived:
    """unit, meaning; lacks(source): what is missing for it, else None; of(source): (numerator, denominator or None)."""

    def __init__(self, unit, meaning, lacks, of):
        self.unit, self.meaning, self.lacks, self.of = unit, meaning, lacks, of


def lacks_stress(source):
    return None if "stress_xx" in source.series else "needs the stress in time: measure = { stress = true; } in the deck"


def is_sheared(source):
    return "strain_xy" in source.series and np.ptp(source.series["strain_xy"]) > 0


def lacks_shear(source):
    if not is_sheared(source):
        return "needs a periodic box that is sheared: cell = { rate_xy = ...; } in a phase"
    return lacks_stress(source)


def _lacks_outflow(source):
    return None if "outside" in source.series else "needs bounds in the deck"


def stresses(source):
    """(xx, yy, shear): stress of contacts and velocities, compression positive; the shear stress of a flow with a positive rate is
    positive."""
    s = source.series
    return s["stress_xx"] + s["kinetic_xx"], s["stress_yy"] + s["kinetic_yy"], -(s["stress_xy"] + s["stress_yx"]) / 2 - s["kinetic_xy"]


def _pressure(source):
    xx, yy, _ = stresses(source)
    return (xx + yy) / 2


def _deviator(source):
    xx, yy, shear = stresses(source)
    return np.hypot((xx - yy) / 2, shear)


DERIVED = {
    "shear_stress": Derived("force/length", "shear stress of a sheared box, positive along rate_xy > 0, of contacts and velocities",
                            lacks_shear, lambda source: (stresses(source)[2], None)),
    "stress_ratio": Derived("1", "shear_stress over the pressure of contacts and velocities", lacks_shear,
                            lambda source: (stresses(source)[2], _pressure(source))),
    "deviator_ratio": Derived("1", "deviator of the stress over the pressure, of contacts and velocities", lacks_stress,
                              lambda source: (_deviator(source), _pressure(source))),
    "outflow": Derived("1/time", "disks that go beyond the bounds or are taken out per time", _lacks_outflow,
                       lambda source: (np.gradient(source.series["outside"].astype(float), source.series["time"]), None)),
}


# --- what colours disks -------------------------------------------------------------------------------------------------
Drawable = lib.StrPath | Result | Source
ARGUMENTS["Drawable"] = (lambda value: isinstance(value, (Result, Source)) or is_path(value)), "a Result, or the path of one"


class Quantity:
    """name, label, unit and kind of colours ("diverging", "sequential", "groups"); lacks(source): what is missing for it, else
    None; of(source, frame, first): a value per disk, nan where there is none."""

    def __init__(self, name, text, unit, kind, of, lacks=lambda source: None):
        self.name, self.text, self.unit, self.kind, self.of, self.lacks = name, text, unit, kind, of, lacks


def _omega(source, k, first):
    means = source.result.means
    values = np.full(len(source.radius), np.nan)
    values[means["id"]] = means["omega"]
    return values


def _measured_column(column):
    def of(source, k, first):
        disks = source.measured(k)["disks"]
        values = np.full(len(source.radius), np.nan)
        values[disks["disk"].astype(int)] = disks[column]
        return values
    return of


def _needs_frames(source):
    if source.n_frames < 2 or source.frame_times[-1] <= source.frame_times[0]:
        return "needs two frames: set frames in a phase of the deck"
    return None


def _velocity(axis):
    return lambda source, k, first: source.frame("velocity", k)[:, axis]


QUANTITIES = {quantity.name: quantity for quantity in (
    Quantity("omega", r"mean angular velocity $\Omega$", "rad/time", "diverging", _omega,
             lambda source: None if source.result.means is not None and len(source.result.means)
             else "needs means of every disk: measure = { disks = true; } in the deck"),
    Quantity("turned", "angle turned", "rad", "diverging",
             lambda source, k, first: source.frame("angle", k) - source.frame("angle", first), _needs_frames),
    Quantity("spin", r"spin $\omega$", "rad/time", "diverging", lambda source, k, first: source.frame("angular_velocity", k)),
    Quantity("speed", "speed", "length/time", "sequential",
             lambda source, k, first: np.hypot(*source.frame("velocity", k).T)),
    Quantity("vx", "$v_x$", "length/time", "diverging", _velocity(0)),
    Quantity("vy", "$v_y$", "length/time", "diverging", _velocity(1)),
    Quantity("moved", "distance moved", "length", "sequential",
             lambda source, k, first: np.hypot(*(source.place(k, True) - source.place(first, True)).T), _needs_frames),
    Quantity("radius", "radius", "length", "sequential", lambda source, k, first: source.radius),
    Quantity("contacts", "contacts of a disk", "1", "sequential", _measured_column("contacts")),
    Quantity("pressure", "pressure on a disk", "force/length", "sequential", _measured_column("pressure")),
    Quantity("fraction", r"local packing fraction", "1", "sequential", _measured_column("fraction")),
    Quantity("group", "group", "1", "groups", lambda source, k, first: source.result.rows("particles/disks/group").astype(float),
             lambda source: None if source.groups and source._whole else "needs a finished run with groups of disks in the deck"),
)}


def usual_quantity(source):
    """Rotation as the file has it; pressures where nothing turns."""
    if not QUANTITIES["omega"].lacks(source):
        return "omega"
    if not np.ptp(source.frame("angle", source.n_frames - 1) - source.frame("angle", 0)):
        return "pressure"
    return "spin" if QUANTITIES["turned"].lacks(source) else "turned"


def quantity(source, name=None):
    """The quantity of this name; without one what is worth seeing in this file."""
    if name is None:
        name = usual_quantity(source)
    if name not in QUANTITIES:
        raise lib.unknown(name, list(QUANTITIES), "the quantities that colour disks")
    missing = QUANTITIES[name].lacks(source)
    if missing:
        raise lib.UserError(f"{source.path}: colour {name} {missing}")
    return QUANTITIES[name]
