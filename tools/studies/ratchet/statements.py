"""Statements of the paper that no figure shows: contacts, torques of steady rotation, senses that theory predicts,
printed equations."""
import math

import numpy as np

from .catalogue import complete, paper
from .page import Numbers, Section
from .runs import slipdisk
from .verdict import TOLERANCES, decide, missing, none, number, signed, within
from .vibration import name_of

PI = math.pi
SIGNS = {"pp": "S<sup>++</sup>", "mm": "S<sup>&minus;&minus;</sup>", "pm": "S<sup>+&minus;</sup>",
         "mp": "S<sup>&minus;+</sup>"}
K_N, GAMMA, MASS, MU, HALF_APERTURE, DAMPING, OMEGA = 1e3, 10, 0.1, 0.1, PI / 6, 0.5, 20 * PI  # of the paper
PRINTED = ("eq11-printed", "level-torques", "eq19-printed", "eq25-printed", "eq28-printed", "eq31-printed", "eq38-printed",
           "sync-balance")


def sections(results, claims):
    """claims: those of the other sections. Statements of the paper that no section judges stand here without data."""
    out = Section("statements", "Statements without a figure", "Some need runs of their own: "
                  "<code>inputs/three_disk/steady.cfg</code>, <code>frozen.cfg</code>, <code>weak.cfg</code>.")
    random = results.best("random").joined()
    own = [*contact_claims(random), *torque_claims(results, out), limit_claim(results, out), still_claim(results, "frozen", "frozen", out),
           still_claim(results, "weak", "no-sliding", out), *sense_claims(results, random), *printed_claims(results)]
    every = complete(claims + own)
    known = {id(claim) for claim in claims}
    out.claims = [claim for claim in every if id(claim) not in known]
    return [out]


def contact_claims(table):
    """The points of the figures: tilts up to 0.1 pi, amplitudes up to 1e-4."""
    if not table:
        return [missing(**paper(slug)) for slug in ("never-open", "forces-never-zero", "cutoff")]
    openings = table.column("upper.left.openings") + table.column("upper.right.openings")
    worst, steep = table.rows[int(np.argmax(openings))], table.column("tilt") > 0.081 * PI
    told = (f"contacts opened at {int((openings[~steep] > 0).sum())} of {int((~steep).sum())} points with tilts up to "
            f"0.08 &pi;, and at {int((openings[steep] > 0).sum())} of {int(steep.sum())} beyond")
    if openings.max() > 0:
        told += (f", most often ({int(openings.max())} times in {worst['replicas'] * worst['time']:g} time units) at "
                 f"{name_of(worst)}")
    least = np.minimum(table.column("upper.left.force_min"), table.column("upper.right.force_min"))
    shut = (least <= 0) & (openings == 0)
    return [decide(condition=not openings.max() > 0, numbers=told, **paper("never-open")),
            decide(condition=bool((least > 0).all()),
                   numbers=f"smallest normal force zero at {int((least <= 0).sum())} of {len(table)} points of random "
                           "vibration", **paper("forces-never-zero")),
            decide(condition=True if shut.any() else None,
                   numbers=f"at {int(shut.sum())} of {len(table)} points of random vibration the least normal force is "
                           "zero and yet no contact opened", **paper("cutoff"))]


def torque_claims(results, out):
    """Torque of the supports on an upper disk that cannot turn, against (15)-(18)."""
    theory = results.theory("torques", "three_disk/steady.cfg")
    claims, rows = [], []
    for key, name in SIGNS.items():
        path = results.run(f"steady_{key}")
        found = results.numbers(f"steady-{key}", lambda path=path: {"torque": float(
            slipdisk.Result(path).state["torque"][0])} if path else None, f"torque on the upper disk in S {key}")
        if not found:
            out.missing.append(f"steady_{key}: not run yet")
        aim = theory.rows[0].get(f"torque_{key}") if theory else None
        if not found or not isinstance(aim, float):
            claims.append(missing(**paper(f"tep-{key}")))
            continue
        torque = found.rows[0]["torque"]
        rows.append([name, torque, aim, 100 * (torque / aim - 1)])
        claims.append(within(value=torque, target=aim, tolerance=TOLERANCES["equal"],
                             names=("simulation", "theory"), **paper(f"tep-{key}")))
    out.tables.append(Numbers("Torques under steady rotation", ["", "simulation", "theory", "off, %"], rows))
    return claims


def limit_claim(results, out):
    """Torque of steadily turning supports on a disk whose centre is held fixed: same and opposite senses."""
    found = {}
    for key in ("pp", "pm"):
        path = results.run(f"fixed_{key}")

        def make(path=path):
            if not path:
                return None
            result = slipdisk.Result(path)
            return {"torque": float(result.state["torque"][0]), "left": float(result.slide[0]["force_min"][0]),
                    "right": float(result.slide[0]["force_min"][1])}

        table = results.numbers(f"fixed-{key}", make, f"torque and normal forces with the centre held fixed in S {key}")
        if not table:
            out.missing.append(f"fixed_{key}: not run yet")
            return missing(**paper("fixed-limit"))
        found[key] = table.rows[0]
    aim = MU * (found["pp"]["left"] + found["pp"]["right"])
    off = [found[key]["torque"] / aim - 1 for key in found]
    return decide(condition=lambda factor: max(map(abs, off)) < factor * TOLERANCES["equal"],
                  numbers=f"<i>n</i><sub>1</sub> = {number(found['pp']['left'])}, <i>n</i><sub>2</sub> = "
                  f"{number(found['pp']['right'])}: {SIGNS['pp']} {number(found['pp']['torque'], digits=5)}, {SIGNS['pm']} "
                  f"{number(found['pm']['torque'], digits=5)}; &mu;(<i>n</i><sub>1</sub> + <i>n</i><sub>2</sub>) = "
                  f"{number(aim, digits=5)}, &mu;(<i>n</i><sub>1</sub> &minus; <i>n</i><sub>2</sub>) = "
                  f"{number(MU * (found['pp']['left'] - found['pp']['right']), digits=5)}", **paper("fixed-limit"))


def still_claim(results, name, slug, out):
    info = results.info(name)
    if not info:
        out.missing.append(f"{name}: not run yet")
        return missing(**paper(slug))
    spin, slide = info["rotation"][0], info["sliding"][0]
    path = results.run(name)
    amplitude = results.numbers(f"{name}-drive", lambda: {
        "theta_b": slipdisk.Result(path).deck.motions[0].amplitude} if path else None, f"amplitude of the run {name}").rows[0]["theta_b"]
    claim = none(value=spin["turned"] / spin["measured"], unit=amplitude * OMEGA, **paper(slug))
    forces = ", ".join(number(c["force_min"]) for c in slide["contacts"])
    claim.numbers = (f"turned by {number(spin['turned'])} rad in {spin['measured']:g} time units at "
                     f"&Theta;<sub>b</sub> = {number(amplitude)}: {claim.numbers}; contacts slide for "
                     f"{1 - slide['stick']:.3f} of the time; least normal forces {forces}")
    return claim


def sense_claims(results, random):
    """The sign of the torque just after tilting against that of Omega at all points with tilt."""
    theory = results.theory("torques", "three_disk/steady.cfg")
    row, out = theory.rows[0] if theory else {}, []
    for slug, table, key, label in (("eq19-random", random, "slight_tilt", "(19)"),
                                    ("eq31-sync", results.best("sync").joined(),
                                     "slight_tilt_sync",
                                     "(31), corrected")):
        aim, tilted = row.get(key), table.such(lambda row: row["tilt"] > 0)
        if not isinstance(aim, float) or not tilted:
            out.append(missing(**paper(slug)))
            continue
        names = [name_of(row) for row in tilted.rows] if "eps_b" in tilted.rows[0] else None
        claim = signed(values=tilted.disk("omega"), errors=tilted.disk("omega_error"), sign=math.copysign(1, aim),
                       names=names, **paper(slug))
        claim.numbers = f"{label} is {number(aim)} at tilt 0.04 &pi;; {claim.numbers}"
        out.append(claim)
    return out


def eq38_claim(tilt, torque, same):
    """The equilibrium of (39) and (40) as printed: both forces of S++ from two linear equations."""
    left, right = HALF_APERTURE - tilt, HALF_APERTURE + tilt
    matrix = [[math.sin(left) + MU * math.cos(left), -(math.sin(right) - MU * math.cos(right))],
              [math.cos(left) - MU * math.sin(left), math.cos(right) + MU * math.sin(right)]]
    printed, right_one = (float(sum(np.linalg.solve(matrix, [0.0, weight]))) for weight in (1.0, MU))  # m g = R = 1
    claim = within(value=printed, target=torque, tolerance=same["tolerance"], names=("printed", "(15)"),
                   **paper("eq38-printed"))
    claim.numbers += f"; with &minus;&mu;<i>mg</i> {number(right_one, digits=5)}"
    return claim


def cycle_claims(tilt, pp, mm, theta=0.1):
    """(25), (43) and (28) as printed, with the torques at this tilt, against (22) to (24) and (30)."""
    inertia, unit = MASS / 2, 4 * theta * OMEGA / PI  # R = 1
    scale = 4 * MASS * theta * OMEGA ** 2
    times = [PI * pp * (PI ** 2 * mm + sign * scale) / (scale * OMEGA * (pp - mm)) for sign in (-1, 1)]

    def velocity(t):
        """(22), over one period from -pi on."""
        return -unit * (1 + 2 * OMEGA * t / PI) if t < 0 else -unit * (1 - 2 * OMEGA * t / PI)

    first, second = (velocity(t) for t in times)
    period = 2 * PI / OMEGA
    gaps = [abs(first + mm * (times[1] - times[0]) / inertia - second) / unit,
            abs(second + pp * (times[0] + period - times[1]) / inertia - first) / unit]
    mean = ((first + second) / 2 * (times[1] - times[0]) + (second + first) / 2 * (times[0] + period - times[1])) / period
    aim = unit * MU * math.tan(tilt)
    return [decide(condition=lambda factor: max(gaps) < factor * 1e-9, numbers=f"largest distance of the velocities that (23) and "
                   f"(24) match {number(max(gaps))} of 4<i>R</i>&Theta;<sub>b</sub>&omega;<sub>b</sub>/&pi; at "
                   f"&Theta;<sub>b</sub> = {theta:g}", **paper("eq25-printed")),
            within(value=mean, target=aim, tolerance=1e-6, names=("mean of (28)", "(30)"), **paper("eq28-printed"))]


def printed_claims(results):
    """Equations as they are printed, against the torques (15)-(18) from which they follow; and plain arithmetic."""
    ratio, time = GAMMA / 2 / math.sqrt(K_N * MASS), math.sqrt(5) / DAMPING / OMEGA
    out = [decide(condition=abs(ratio - 0.5) < 1e-9, numbers=f"{number(ratio)}", **paper("damping-ratio")),
           decide(condition=abs(time - 0.07) < 0.005, numbers=f"{number(time)}", **paper("correlation-time"))]
    theory = results.theory("torques", "three_disk/steady.cfg")
    level = results.theory("torques-level", "three_disk/steady.cfg", **{"gravity.tilt": 0})
    if not theory or not level or not theory.has("torque_pp"):
        return out + [missing(**paper(slug)) for slug in PRINTED]
    row, flat = theory.rows[0], level.rows[0]
    tilt = row["tilt"]
    pp, pm, mp, mm = (row[f"torque_{key}"] for key in ("pp", "pm", "mp", "mm"))
    tan, cos = math.tan(HALF_APERTURE), math.cos(HALF_APERTURE)
    eq19 = (MU ** 2 * (MU ** 2 + (1 + MU ** 2) * math.cos(2 * HALF_APERTURE)) / cos ** 3 * math.sin(tilt)
            / (2 * (1 + MU ** 2) * (MU ** 2 - tan ** 2)))
    eq31 = MU * math.sin(tilt) / (1 + MU ** 2) / cos
    mean, half = (pp + pm + mp + mm) / 4, (pp + mm) / 2
    times = -mm / (pp - mm), pp / (pp - mm)
    same = {"tolerance": 1e-6, "names": ("printed", "from (15)-(18)")}
    out += [eq38_claim(tilt, pp, same), *cycle_claims(tilt, pp, mm)]
    claim = within(value=eq31, target=half, **same, **paper("eq31-printed"))
    claim.numbers += f"; the print is {eq31 / half:.3g} times that, 1/&mu; = {1 / MU:g}"
    zeros = [flat[f"torque_{key}"] for key in ("pp", "mm", "pm", "mp")]
    return out + [within(value=(2 * pp + pm + mp) / 4, target=mean, **same, **paper("eq11-printed")),
                  decide(condition=abs(zeros[0] - zeros[1]) + abs(zeros[2]) + abs(zeros[3]) < 1e-9,
                         numbers="S<sup>++</sup>, S<sup>&minus;&minus;</sup>, S<sup>+&minus;</sup>, "
                                 "S<sup>&minus;+</sup>: " +
                         ", ".join(number(z, digits=5) for z in zeros)
                         + ": the first two have opposite signs", **paper("level-torques")),
                  within(value=eq19, target=mean, **same, **paper("eq19-printed")), claim,
                  decide(condition=abs(pp * times[0] + mm * times[1]) < 1e-12,
                         numbers="&Tau;<sup>++</sup><i>T</i><sup>++</sup> + "
                                 "&Tau;<sup>&minus;&minus;</sup><i>T</i><sup>&minus;&minus;</sup> = "
                                 f"{number(pp * times[0] + mm * times[1])}",
                         **paper("sync-balance"))]
