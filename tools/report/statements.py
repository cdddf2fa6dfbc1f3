"""All statements of the paper with their verdicts: those of the figures, and some that need runs of their own."""
import math

import numpy as np

from .page import Numbers, Section, badge, plain
from .runs import slipdisk
from .verdict import decide, missing, number, percent

PI = math.pi
SIGNS = {"pp": ("S<sup>++</sup>", "(15)"), "mm": ("S<sup>&minus;&minus;</sup>", "(16)"),
         "pm": ("S<sup>+&minus;</sup>", "(17)"), "mp": ("S<sup>&minus;+</sup>", "(18)")}


def sections(results, claims):
    """claims: those of the other sections; the paper's among them are repeated in the table of statements."""
    out = Section("statements", "All statements of the paper", "Statements of the figures above, and some that need "
                  "runs of their own: <code>inputs/three_disk/steady.cfg</code>, <code>frozen.cfg</code>, "
                  "<code>weak.cfg</code>.")
    own = [*contact_claims(results), *torque_claims(results, out), still_claim(results, "frozen", out),
           still_claim(results, "weak", out), slight_tilt_claim(results)]
    out.claims = own
    every = [claim for claim in claims + own if claim.place]
    out.tables.append(Numbers("Statements of the paper", ["where", "statement", "verdict", "numbers"],
                              [[c.place, c.text, badge(c.verdict), c.numbers]
                               for c in sorted(every, key=lambda c: order(c.place))], shown=True))
    return [out]


def order(place):
    """Section number of the paper first."""
    digits = plain(place).replace("sections", "section").split("section ")[-1].split(",")[0]
    try:
        return float(digits)
    except ValueError:
        return 9.0


def contact_claims(results):
    text, place = "The upper disk never loses contact with the supports.", "section 3"
    out = []
    table = results.best("random").joined()
    if not table:
        out.append(missing(text, place))
    else:
        openings = table.column("upper.left.openings") + table.column("upper.right.openings")
        worst, steep = table.rows[int(np.argmax(openings))], table.column("tilt") > 0.081 * PI
        told = (f"contacts opened at {int((openings[~steep] > 0).sum())} of {int((~steep).sum())} points with tilts up "
                f"to 0.08 &pi;, and at {int((openings[steep] > 0).sum())} of {int(steep.sum())} beyond")
        if openings.max() > 0:
            told += (f", most often ({int(openings.max())} times in {worst['replicas'] * worst['time']:g} time units) at "
                     f"&epsilon;<sub>b</sub> = {worst['eps_b']:g}, tilt {worst['tilt'] / PI:g} &pi;")
        out.append(decide(text, not openings.max() > 0, told, place))
    text, place = "Normal forces are never zero in this regime.", "section 1"
    if table:
        least = np.minimum(table.column("upper.left.force_min"), table.column("upper.right.force_min"))
        out.append(decide(text, bool((least > 0).all()), f"smallest normal force zero at {int((least <= 0).sum())} of "
                          f"{len(table)} points of random vibration, where a contact parts faster than its viscous "
                          "part lets it expand; the overlap may stay positive", place))
    else:
        out.append(missing(text, place))
    return out


def torque_claims(results, out):
    """Torque of the supports on an upper disk that cannot turn, against (15)-(18)."""
    theory = results.theory("torques", "three_disk/steady.cfg")
    claims, rows = [], []
    for key, (name, label) in SIGNS.items():
        text, place = f"While both contacts slide steadily in {name} the torque is {label}.", f"section 4, eq. {label}"
        path = results.run(f"steady_{key}")
        found = results.numbers(f"steady-{key}", lambda path=path: {"torque": float(
            slipdisk.Result(path).state["torque"][0])} if path else None, f"torque on the upper disk in S {key}")
        if not found:
            out.missing.append(f"steady_{key}: not run yet")
        aim = theory.rows[0].get(f"torque_{key}") if theory else None
        if not found or not isinstance(aim, float):
            claims.append(missing(text, place))
            continue
        torque = found.rows[0]["torque"]
        rows.append([name, torque, aim, 100 * (torque / aim - 1)])
        claims.append(decide(text, abs(torque / aim - 1) < 0.01, f"{number(torque, digits=5)}, theory "
                             f"{number(aim, digits=5)}: {percent(torque / aim - 1)} (counted as equal up to 1 %)",
                             place))
    out.tables.append(Numbers("Torques under steady rotation", ["", "simulation", "theory", "off, %"], rows))
    return claims


def still_claim(results, name, out):
    text, place = {"frozen": ("With all centres held fixed the upper disk does not rotate, although "
                              "<i>n</i><sub>1</sub> &ne; <i>n</i><sub>2</sub>.", "section 4"),
                   "weak": ("At very weak drive, " "where contacts hardly " "slide, the upper disk " "does not rotate.",
                            "section 4")}[name]
    info = results.info(name)
    if not info:
        out.missing.append(f"{name}: not run yet")
        return missing(text, place)
    spin, slide = info["rotation"][0], info["sliding"][0]
    path = results.run(name)
    amplitude = results.numbers(f"{name}-drive", lambda: {"theta_b": float(slipdisk.Result(path).deck.split(
        "amplitude = ")[1].split(";")[0])} if path else None, f"amplitude of the run {name}").rows[0]["theta_b"]
    speed = spin["turned"] / spin["measured"] / (amplitude * 20 * PI)
    forces = ", ".join(number(c["force_min"]) for c in slide["contacts"])
    return decide(text, abs(speed) < 1e-3, f"turned by {number(spin['turned'])} rad in {spin['measured']:g} time "
                  f"units: {number(speed)} &Theta;<sub>b</sub>&omega;<sub>b</sub> (counted as none below "
                  f"10<sup>&minus;3</sup>); contacts slide for {1 - slide['stick']:.3f} of the time; least normal "
                  f"forces {forces}", place)


def slight_tilt_claim(results):
    """Signs of (19) and (31) against those found."""
    text = ("The torque just after tilting predicts the sense: (19) for random vibration and opposite phases, (31) in "
            "phase.")
    place = "section 4, eq. (19), (31)"
    theory = results.theory("torques", "three_disk/steady.cfg")
    row = theory.rows[0] if theory else {}
    predicted = row.get("slight_tilt"), row.get("slight_tilt_sync")
    if not all(isinstance(v, float) for v in predicted):
        return missing(text, place)
    found, told = [], [f"(19) = {number(predicted[0])}, (31) = {number(predicted[1])}"]
    for name, aim, title in (("random", predicted[0], "random"), ("async", predicted[0], "opposite"),
                             ("sync", predicted[1], "in phase")):
        table = results.best(name).joined().such(lambda row: row["tilt"] > 0)
        if not table:
            return missing(text, place)
        z = table.disk("omega") / table.disk("omega_error")
        good, bad = int((np.sign(aim) * z > 3).sum()), int((np.sign(aim) * z < -3).sum())
        found.append(good > 0 and not bad)
        told.append(f"{title}: {good} of {len(table)} points have this sign by more than 3 errors, {bad} the other")
    return decide(text, all(found), "; ".join(told), place)
