"""Omega against aperture, friction, stiffnesses, damping and frequency, for three drives."""
import math

import numpy as np

from . import fits
from .catalogue import paper
from .mechanism import BASE, PI, all_coordinates, key, points
from .mechanism import told as shown
from .mechanism_theory import Drive, System, alternating, predicted, slight_tilt_zero
from .page import Figure, Numbers, Section
from .style import COLOURS, figure, in_pi, legend_below, zero_line
from .style import points as draw_points
from .verdict import CHECK, NO, OPEN, PAPER, SURE, TOLERANCES, YES, Claim, beyond, decide, missing, number, percent

DRIVES = ("random", "in phase", "opposite phases", "a quarter apart")
PHASE = {"in phase": 0.0, "opposite phases": PI}
# name of the swept key, its symbol, whether the axis is logarithmic, keys that go with it
SCANS = (("theta_h", r"half aperture $\theta_h$", False, ()), ("mu", r"friction $\mu$", True, ()),
         ("k_n", r"normal stiffness $k_n$", True, ("gamma_n",)), ("k_t", r"tangential stiffness $k_t$", True, ("dt",)),
         ("gamma_n", r"damping $\gamma_n$", True, ()), ("omega_b", r"frequency $\omega$", True, ("eps_b", "theta_b")))
NAMES = {"theta_h": "the angle between the contacts", "mu": "the friction coefficient", "k_n": "the normal stiffness",
         "k_t": "the tangential stiffness", "gamma_n": "the damping", "omega_b": "the frequency"}
SLUGS = {"theta_h": "depends-aperture", "mu": "depends-mu", "k_n": "depends-kn", "k_t": "depends-kt",
         "gamma_n": "depends-damping"}
PLACE = "section 2"


def number_in(row, name):
    return isinstance(row.get(name), float) and math.isfinite(row[name])


def scan(table, name, extra):
    """The points at which this key and those that go with it are set, and no other of the scans."""
    others = {n for n, *_ in SCANS} - {name, *extra}
    return table.such(lambda row: number_in(row, name) and not any(number_in(row, n) for n in others)
                      and all(number_in(row, n) for n in extra if n != "eps_b" and n != "theta_b")).sorted(name)


def quarter(table):
    """Half sums of Omega at the phases pi/2 and -pi/2, stiff disks, against the aperture."""
    stiff = table.such(lambda row: abs(abs(row["phase"]) - PI / 2) < 1e-6)
    rows = []
    for theta in stiff.values("theta_h"):
        both = stiff.where(theta_h=theta).rows
        if len(both) == 2:
            rows.append({**both[0], "omega": sum(r["omega"] for r in both) / 2,
                         "error": math.hypot(*(r["error"] for r in both)) / 2})
    return type(table)(rows)


def lines(results):
    """{(drive, scan): points}, Omega in units of the velocity of the supports."""
    random = points(results.sweep("mechanism_scan"), lambda r: key(r, "eps_b") * key(r, "omega_b"))
    turning = points(results.sweep("mechanism_scan_turning"), lambda r: key(r, "theta_b") * key(r, "omega_b"))
    out = {}
    for name, _, _, extra in SCANS:
        out["random", name] = scan(random, name, extra).such(all_coordinates)
        for drive, phase in PHASE.items():
            out[drive, name] = scan(turning.where(phase=phase), name, extra)
    out["a quarter apart", "theta_h"] = quarter(turning)
    return out, [*random.missing, *turning.missing]


def theory(drive, name, value):
    """Strong drive, centre in its equilibrium at once: Omega in units of the velocity."""
    keys = {n: BASE[n] for n in ("theta_h", "tilt", "mu", "k_n", "gamma_n")}
    if name == "k_n":
        keys["gamma_n"] = math.sqrt(value * 0.1)
    if name in keys:
        keys[name] = value
    system = System(**keys)
    if drive != "random":
        return alternating(system, {**PHASE, "a quarter apart": PI / 2}[drive])
    omega = value if name == "omega_b" else BASE["omega_b"]
    return predicted(system, Drive(eps=1 / omega, omega=omega))


def draw(found):
    picture, axes = figure(3, 2, width=7.6, height=5.6, legend=True)
    for axis, (name, label, log, _) in zip(axes.flat, SCANS):
        scale = 1 / PI if name in ("theta_h", "omega_b") else 1
        for k, drive in enumerate(DRIVES):
            line = found.get((drive, name))
            if not line:
                continue
            x = line.column(name)
            draw_points(axis, scale * x, line.column("omega"), line.column("error"), drive, k, "os^D"[k], line="none",
                        ms=4)
            dense = np.geomspace(x[0], x[-1], 60) if log else np.linspace(x[0], x[-1], 60)
            axis.plot(scale * dense, [theory(drive, name, v) for v in dense], color=COLOURS[k], lw=1, gid="guide")
        zero_line(axis)
        if log:
            axis.set_xscale("log")
        if name == "mu":
            axis.set_xticks([0.02, 0.05, 0.1, 0.2, 0.5], ["0.02", "0.05", "0.1", "0.2", "0.5"])
        if scale != 1:
            in_pi(axis.xaxis)
        axis.set_ylim(-0.115, 0.072)
        axis.set_xlabel(label)
    for axis in axes[:, 0]:
        axis.set_ylabel(r"$\Omega\,/\,$velocity")
    legend_below(picture, axes.flat, 4)
    return Figure("mechanism-scan", picture, "Mean angular velocity against one parameter at a time, in units of the "
                  "supports' velocity (&Theta;<sub>b</sub>&omega;<sub>b</sub>; random: rms velocity "
                  "&epsilon;<sub>b</sub>&omega;). Lines: the limit of strong drive with the centre in its "
                  "equilibrium at "
                  "once (no free parameter); they end where a configuration has no equilibrium. Points beyond the axes "
                  "are in the table.", "Angular velocity against aperture, friction, stiffness, damping and frequency")


def sections(results):
    out = Section("mechanism-scan", "What the rotation depends on", "Decks "
                                                                    "<code>inputs/paper/mechanism_scan.cfg</code> "
                  "(random vibration, &epsilon;<sub>b</sub> = 10<sup>&minus;4</sup>; errors from the scatter of "
                  "replicas) "
                  "and <code>mechanism_scan_turning.cfg</code> (parabolas, &Theta;<sub>b</sub> = 0.04), tilt 0.04&pi;, "
                  "everything else as in the paper. <i>k<sub>n</sub></i> is varied at a damping ratio of 0.5, the "
                  "frequency at a fixed velocity of the supports. A quarter apart: half sum of the phases &pi;/2 and "
                  "&minus;&pi;/2 with <i>k<sub>n</sub></i> = 10<sup>5</sup>; all four configurations then last equally "
                  "long without tilt, which is the premise of (19).", new=True)
    found, out.missing = lines(results)
    out.figures.append(draw(found))
    out.claims = [*(depends(found, name) for name in SLUGS), *aperture_sign(found), short(found)]
    rows = [[drive, name.replace("_", ""), row[name] / (PI if name in ("theta_h", "omega_b") else 1), row["omega"],
             row["error"], theory(drive, name, row[name]),
             *(row.get(f"upper.{part}", math.nan) for part in ("pp", "pm", "mp", "mm", "stick", "open"))]
            for (drive, name), line in found.items() for row in line.rows]
    out.tables.append(Numbers("All points of the scans", [
        "drive", "parameter", "value (angles, &omega;: /&pi;)", "&Omega;/velocity", "error", "strong drive",
        "S<sup>++</sup>", "S<sup>+&minus;</sup>", "S<sup>&minus;+</sup>", "S<sup>&minus;&minus;</sup>",
        "a contact sticks", "a contact is open"], rows))
    return [out]


def depends(found, name):
    """Does Omega change from the paper's value of the parameter to the next ones on either side?"""
    text = f"&Omega; depends on {NAMES[name]}."
    kind = PAPER if name != "gamma_n" else CHECK
    place = PLACE if kind == PAPER else ""
    line = found["random", name]
    x, value, error = (line.column(key) for key in (name, "omega", "error"))
    good = np.isfinite(value) & (error > 0)
    x, value, error = x[good], value[good], error[good]
    at = int(np.argmin(np.abs(np.log(x / BASE[name])))) if len(x) else -1
    if at < 1 or at + 1 >= len(x):
        return missing(text, place, slug=SLUGS[name], kind=kind)
    changes = [(value[k] / value[at] - 1, math.hypot(error[k], error[at] * value[k] / value[at]) / abs(value[at]), x[k])
               for k in (at - 1, at + 1)]

    def judge(factor, limit=TOLERANCES["depends"]):
        far = [abs(change) - SURE * spread > factor * limit for change, spread, _ in changes]
        near = [abs(change) + SURE * spread <= factor * limit for change, spread, _ in changes]
        return YES if any(far) else NO if all(near) else OPEN

    unit = PI if name == "theta_h" else 1
    told = [f"random vibration, from the paper's {number(x[at] / unit)}{' &pi;' * (unit == PI)}: "
            + ", ".join(f"{percent(change)} (&plusmn; {100 * spread:.1f}) at {number(place_of / unit)}{' &pi;' * (unit == PI)}"
                        for change, spread, place_of in changes)
            + f" (counted as a change beyond {100 * TOLERANCES['depends']:g} %); from {span(line, name)}"]
    told += [f"{drive}: from {span(found[drive, name], name)}" for drive in PHASE if found[drive, name]]
    return Claim(text, judge, "; ".join(told) + " (&Omega; over the supports' velocity)", place, kind, SLUGS[name])


def span(line, name):
    def at(row):
        x = row[name] / PI if name == "theta_h" else row[name]
        return f"{shown(row['omega'], row['error'])} at {number(x)}" + (" &pi;" if name == "theta_h" else "")
    rows = sorted(line.rows, key=lambda row: row["omega"])
    return f"{at(rows[0])} to {at(rows[-1])}"


def aperture_sign(found):
    """Is the sign of Omega that of (19) at all apertures? For each drive."""
    out, zero = [], slight_tilt_zero(BASE["mu"])
    told = f"(19) is negative below {zero / PI:.4f} &pi; and positive above"
    for drive, facts in (
            ("random", {"text": "The sign of (19) is the sense of rotation under random vibration, at all apertures.",
                        "kind": CHECK, "slug": "aperture-sign"}), ("opposite phases", paper("eq19-async"))):
        line = found.get((drive, "theta_h"))
        if not line or len(line) < 4:
            out.append(missing(**facts))
            continue
        theta, z = line.column("theta_h"), line.column("omega") / np.maximum(line.column("error"), 1e-300)
        z *= np.sign(theta - zero)

        def judge(factor, z=z):
            sure, against = factor * SURE, beyond(len(z), factor)
            return NO if (z < -against).any() else YES if (z > sure).all() else OPEN

        wrong = ", ".join(f"{t / PI:.2g} &pi;" for t, v in zip(theta, z) if v < -SURE)
        out.append(Claim(verdict=judge, rule="sign", numbers=f"{told}; &Omega; has its sign by more than {SURE:g} errors at "
                         f"{int((z > SURE).sum())} of {len(z)} half apertures, the other at {int((z < -SURE).sum())}"
                         + (f" ({wrong})" if wrong else ""), **facts))
    text = "Where all four configurations last equally long without tilt, the sense turns over at the aperture at which (19) changes its sign."
    line = found.get(("a quarter apart", "theta_h"))
    crossing = fits.crossing(*(line.column(key) for key in ("theta_h", "omega", "error"))) if line and len(line) > 3 else None
    if not crossing:
        return [*out, missing(text, slug="aperture-sign-quarter")]
    off = abs(crossing[0] - zero) / PI
    return [*out, decide(text, lambda factor: bool(off < factor * 0.005), f"(19) changes its sign at {zero / PI:.4f} &pi;, "
                         f"&Omega; at {crossing[0] / PI:.4f} &pi; (counted as equal up to 0.005 &pi;)",
                         slug="aperture-sign-quarter")]


def short(found):
    text, place = "The disk does not rotate when the configurations are very short.", "section 4"
    told, parts = [], []
    for drive in ("random", *PHASE):
        line = found[drive, "omega_b"]
        if len(line) < 3:
            return missing(text, place, slug="short-configurations")
        value, error = line.column("omega"), line.column("error")
        last, largest = line.rows[-1], float(np.abs(value).max())
        parts.append((abs(value[-1]) + max(error[-1], 0)) / largest)
        told.append(f"{drive}: {shown(value[-1], error[-1])} at &omega; = "
                    f"{last['omega_b'] / PI:g} &pi;, at most "
                    f"{number(largest, digits=2)} at lower frequencies")
    return decide(text, lambda factor: max(parts) < factor * 0.02, "; ".join(told) + " (&Omega; over the supports' velocity, which is the same at all "
                  "frequencies; counted as none below 2 % of the largest)", place, slug="short-configurations")
