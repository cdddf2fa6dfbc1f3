"""The laws as Markdown: the tables of law_runs.compare."""
import math

from . import law_runs, laws


def table(columns, rows):
    out = ["| " + " | ".join(columns) + " |", "|---" + "|---:" * (len(columns) - 1) + "|"]
    return out + ["| " + " | ".join(row) + " |" for row in rows]


def worst(own, other):
    """The difference other - own of largest size."""
    return max((b - a for a, b in zip(own, other)), key=abs)


def differences(it):
    """Largest differences of LAMMPS to slipdisk: (e, rebound angle in degrees, R omega / speed)."""
    (own_e, own), (e, oblique) = it["collisions"]["slipdisk"], it["collisions"]["LAMMPS"]
    return (worst(own_e, e), *(worst([row[k] for row in own], [row[k] for row in oblique]) for k in (0, 1)))


def spread(own, other):
    """Difference of two means over its standard error."""
    error = math.hypot(own[1], other[1])
    return f"{(other[0] - own[0]) / error:+.1f}" if error > 0 else "-"


def both(found, text, *shown):
    """Numbers of slipdisk and LAMMPS in one cell."""
    return " / ".join(format(shown[0](found[who]), text) for who in ("slipdisk", "LAMMPS") if who in found)


def largest(rows):
    compared = {name: it for name, it in rows.items() if "LAMMPS" in it["collisions"]}
    if not compared:
        return []
    return ["Largest difference LAMMPS - slipdisk over all collisions: restitution, angle of rebound "
            "of the surfaces, R omega of the smaller disk over the speed:", "",
            *table(["law of LAMMPS", "e", "angle, degrees", "spin", "what is left of a difference"],
                   [[name, *(f"{value:+.1e}" for value in differences(it)), laws.LAWS[name].why]
                    for name, it in compared.items()]), ""]


def collisions(rows):
    out = [f"Restitution of two disks of radius {laws.RADII['a']:g}, slipdisk / LAMMPS:", "",
            *table(["law", *(f"{speed:g} m/s" for speed in law_runs.SPEEDS)],
                   [[name, *(both(it["collisions"], ".4f", lambda one, k=k: one[0][k])
                             for k in range(len(law_runs.SPEEDS)))]
                    for name, it in rows.items()]), "",
            f"Oblique impact at {law_runs.SPEED:g} m/s, radii {laws.RADII['a']:g} and {laws.RADII['b']:g}: "
            "angle of rebound of the surfaces in degrees (negative: they come back), by the angle of "
            "impact, slipdisk / LAMMPS:", "",
            *table(["law", *(f"{angle}" for angle in law_runs.ANGLES)],
                   [[name, *(both(it["collisions"], ".2f", lambda one, k=k: one[1][k][0])
                             for k in range(len(law_runs.ANGLES)))]
                    for name, it in rows.items()]), ""]
    for name, it in rows.items():
        if "rolling" in it:
            out += [f"Rolling to rest on a plane ({name}), distance in m:", "",
                    *table(["speed", "2/3 mu_r g", *it["rolling"]],
                           [[f"{speed:g} m/s", f"{law_runs.expected_rolling(speed):.6f}",
                             *(f"{distances[k]:.6f}" for distances in it["rolling"].values())]
                            for k, speed in enumerate(law_runs.ROLL_SPEEDS)]), ""]
    return out


def steps(it):
    names = list(it["rows"][0][1])
    return [f"Smaller time steps (hooke): e - {it['e']:.7f}, which is exact, and the angle of rebound at "
            f"{law_runs.ANGLES[0]} and {law_runs.ANGLES[3]} degrees:", "",
            *table(["dt", *(f"{what}, {who}" for what in ("e", *(f"{law_runs.ANGLES[k]} degrees" for k in (0, 3)))
                            for who in names)],
                   [[f"{dt:g}", *(f"{row[who][0] - it['e']:+.1e}" for who in names),
                     *(f"{row[who][1][k]:.3f}" for k in (0, 3) for who in names)] for dt, row in it["rows"]]), ""]


def packings(rows, seeds):
    return [f"{law_runs.COUNT} disks of both sizes fall into a box {law_runs.WIDTH:g} wide, {seeds} "
            "starts; slipdisk / LAMMPS, and the difference in standard errors. Contacts are those with walls, too; the "
            "elastic energy is that of the normal forces:", "",
            *table(["law", "mean height, mm", "", "contacts per disk", "", "elastic energy per disk, uJ", ""],
                   [[name, *(cell for k, scale in ((0, 1e3), (1, 1), (2, 1e6))
                             for cell in packing_cells(it["packing"], k, scale))]
                    for name, it in rows.items()]), ""]


def render(found):
    rows = found["laws"]
    return [*largest(rows), *collisions(rows), *steps(found["steps"]), *packings(rows, found["seeds"])]


def brief(found):
    """Of all tables the two on docs/performance.md."""
    return [*largest(found["laws"]), *steps(found["steps"])]


def packing_cells(found, k, scale):
    cell = both(found, ".3f", lambda one: scale * one[0][k])
    if "LAMMPS" not in found:
        return [cell, "-"]
    return [cell, spread(*((found[who][0][k], found[who][1][k]) for who in ("slipdisk", "LAMMPS")))]
