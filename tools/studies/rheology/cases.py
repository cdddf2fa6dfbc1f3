"""What the friction of simple shear at I = 0.1 depends on: inputs/shear/rheology.cfg with one thing changed at a time.

tools/studies/rheology.sh --cases runs them and writes their table and figure."""
import collections
import math
import os
import re

import numpy as np

RATE, STRAIN, BLOCKS = 0.1, 8, (4, 10)  # inertial number; strain of a run; blocks of it for error bars: the larger error counts
BASE = {"I": RATE, "kappa": 1e3, "spread": 0.2, "disks": 4096, "damping": 0.59, "clipped": True, "friction": 0.4,
        "k_t": 0.5, "step": 1.0}
COLUMNS = ("group", "case", *BASE, "restitution", "seeds", "strain", "I_found", "mu", "mu_error", "mu_means",
           "mu_pressure", "mu_contacts", "mu_early", "mu_late", "phi", "phi_error", "xx_over_yy", "contacts")
TEXT = ("group", "case")
FOUND = 0.401, 0.003                    # of an independent deck: kappa 1e4, ± 25 %, 800 disks, e = 0.5 and 0.9


# --- laws ---------------------------------------------------------------------------------------------------------------
def restitution(damping, clipped):
    """Of a linear contact whose force cannot pull (clipped) or may; damping: in parts of the critical one."""
    swing = math.sqrt(1 - damping**2)
    phase = math.atan2(2 * damping * swing, swing**2 - damping**2) if clipped else 0
    return math.exp(-damping * (math.pi - phase) / swing)


def damping_of(wanted, clipped=True):
    low, high = 0.0, 1 - 1e-9
    for _ in range(80):
        middle = (low + high) / 2
        low, high = (middle, high) if restitution(middle, clipped) > wanted else (low, middle)
    return low


# --- cases --------------------------------------------------------------------------------------------------------------
Case = collections.namedtuple("Case", "group label keys seeds")
STIFF = {"kappa": 1e4}
INDEPENDENT = {"kappa": 1e4, "spread": 0.25, "disks": 800}
CASES = (
    Case("nothing", "the deck", {}, 4),
    Case("stiffness", "kappa 300", {"kappa": 300.0}, 2),
    Case("stiffness", "kappa 3000", {"kappa": 3e3}, 2),
    Case("stiffness", "kappa 1e4", STIFF, 2),
    Case("stiffness", "kappa 3e4", {"kappa": 3e4}, 1),
    Case("sizes", "± 10 %", {"spread": 0.1}, 2),
    Case("sizes", "± 25 %", {"spread": 0.25}, 4),
    Case("sizes", "± 40 %", {"spread": 0.4}, 2),
    Case("number of disks", "400", {"disks": 400}, 8),
    Case("number of disks", "800", {"disks": 800}, 8),
    Case("number of disks", "1600", {"disks": 1600}, 4),
    Case("damping", "e = 0.5", {"damping": damping_of(0.5)}, 2),
    Case("damping", "e = 0.9", {"damping": damping_of(0.9)}, 2),
    Case("damping", "e = 0.1, force may pull", {"clipped": False}, 2),
    Case("friction of the disks", "0.3", {"friction": 0.3}, 2),
    Case("friction of the disks", "0.5", {"friction": 0.5}, 2),
    Case("tangential stiffness", "k_t = k_n/4", {"k_t": 0.25}, 2),
    Case("tangential stiffness", "k_t = k_n", {"k_t": 1.0}, 2),
    Case("time step", "half of it", {"step": 0.5}, 1),
    Case("at kappa 1e4", "± 25 %", {**STIFF, "spread": 0.25}, 2),
    Case("at kappa 1e4", "800 disks", {**STIFF, "disks": 800}, 6),
    Case("at kappa 1e4", "e = 0.5", {**STIFF, "damping": damping_of(0.5)}, 1),
    Case("at kappa 1e4", "e = 0.9", {**STIFF, "damping": damping_of(0.9)}, 1),
    Case("at kappa 1e4", "e = 0.1, force may pull", {**STIFF, "clipped": False}, 1),
    Case("kappa 1e4, ± 25 %, 800 disks", "e = 0.5", {**INDEPENDENT, "damping": damping_of(0.5)}, 10),
    Case("kappa 1e4, ± 25 %, 800 disks", "e = 0.9", {**INDEPENDENT, "damping": damping_of(0.9)}, 10),
)


def name_of(case):
    return re.sub(r"[^A-Za-z0-9.]+", "-", f"{case.group}-{case.label}".replace("±", "pm")).strip("-")


def settings(case, seed):
    """{key of the deck: value}."""
    c = {**BASE, **case.keys}
    dt = 3.3e-3 * c["step"] * math.sqrt(1000 / c["kappa"])
    side = 88 * math.sqrt(c["disks"] / 4096)
    return {"seed": seed, "constants.I": c["I"], "constants.kappa": c["kappa"], "constants.strain": STRAIN, "dt": dt,
            "container.width": side, "container.height": side, "packings[0].count": c["disks"],
            "packings[0].lower": 0.5 * (1 - c["spread"]), "packings[0].upper": 0.5 * (1 + c["spread"]),
            "materials[0].k_t": c["k_t"] * c["kappa"], "materials[0].mu": c["friction"],
            "materials[0].gamma_n": 2 * c["damping"] * math.sqrt(c["kappa"] / 2),
            "materials[0].limit_damping": "true" if c["clipped"] else "false",
            "phases[2].series": max(1, round(STRAIN / c["I"] / dt / 2000))}


def cost(case):
    c = {**BASE, **case.keys}
    return c["disks"] * math.sqrt(c["kappa"]) / c["step"]


def runs(folder):
    """[(path, settings)]: the first seed of every case, then the others, short runs first."""
    todo = [(seed, case) for case in CASES for seed in range(1, case.seeds + 1)]
    todo.sort(key=lambda it: (it[0] > 1, cost(it[1]), it[0]))
    return [(path_of(folder, case, seed), settings(case, seed)) for seed, case in todo]


def path_of(folder, case, seed):
    return os.path.join(folder, "cases", f"{name_of(case)}-{seed}.h5")


# --- numbers ------------------------------------------------------------------------------------------------------------
def blocks_of(values, blocks):
    size = len(values) // blocks
    return [float(np.mean(values[k * size:(k + 1) * size])) for k in range(blocks)]


def error_of(runs_blocks):
    """Standard error of the mean over runs; of each its blocks, by every length."""
    pooled = [np.concatenate(it) for it in zip(*runs_blocks)]
    return max(it.std(ddof=1) / math.sqrt(len(it)) for it in pooled)


def measures(series):
    """Friction of one run by every way of taking its mean, and its blocks. The first is that of the page."""
    contact = -(series["stress_xy"] + series["stress_yx"]) / 2
    shear, yy = contact - series["kinetic_xy"], series["stress_yy"] + series["kinetic_yy"]
    xx = series["stress_xx"] + series["kinetic_xx"]
    mu, quarter = shear / yy, len(shear) // 4
    return {"mu": mu.mean(), "mu_means": shear.mean() / yy.mean(), "mu_pressure": (2 * shear / (xx + yy)).mean(),
            "mu_contacts": (contact / series["stress_yy"]).mean(), "mu_early": mu[:quarter].mean(),
            "mu_late": mu[-quarter:].mean(), "blocks": [blocks_of(mu, n) for n in BLOCKS]}


def row_of(case, found):
    """Of the runs of a case; found: [(row of rheology.evaluate, series)]."""
    c = {**BASE, **case.keys}
    ways = [measures(series) for _, series in found]
    out = {"group": case.group, "case": case.label, **{k: float(v) for k, v in c.items()},
           "restitution": restitution(c["damping"], c["clipped"]), "seeds": float(len(found)),
           "strain": sum(row["strain"] for row, _ in found), "I_found": np.mean([row["I"] for row, _ in found]),
           **{name: np.mean([way[name] for way in ways]) for name in ways[0] if name != "blocks"}}
    out["mu_error"] = error_of([way["blocks"] for way in ways])
    for name in ("phi", "xx_over_yy", "contacts"):
        out[name] = np.mean([row[name] for row, _ in found])
    density = [row["phi"] * it / it.mean() for row, it in ((row, 1 / (series["width"] * series["height"]))
                                                           for row, series in found)]
    out["phi_error"] = error_of([[blocks_of(it, n) for n in BLOCKS] for it in density])
    return {name: float(f"{out[name]:.6g}") if name not in TEXT else out[name] for name in COLUMNS}


def collect(folder, read, evaluate):
    """Rows of the cases that have results."""
    rows = []
    for case in CASES:
        paths = [path_of(folder, case, seed) for seed in range(1, case.seeds + 1)]
        found = [(evaluate(*it), it[1]) for it in map(read, filter(os.path.exists, paths))]
        if found:
            rows.append(row_of(case, found))
    return rows


# --- page ---------------------------------------------------------------------------------------------------------------
def base_of(rows):
    return next(row for row in rows if row["group"] == CASES[0].group)


def table(rows, pm):
    """Lines of the page: friction, its distance from that of the deck, and what its mean does to it."""
    base = base_of(rows)
    out = ["| changed | to | mu* | less the deck's | phi | contacts per disk | sigma_xx/sigma_yy | runs |", "|" + "---|" * 8]
    for row in rows:
        same = row is base
        off = "" if same else pm(row["mu"] - base["mu"], math.hypot(row["mu_error"], base["mu_error"]), sign=True)
        out.append("| " + " | ".join([row["group"], row["case"], pm(row["mu"], row["mu_error"]), off,
                                      pm(row["phi"], row["phi_error"]), f"{row['contacts']:.2f}",
                                      f"{row['xx_over_yy']:.3f}", f"{row['seeds']:.0f}"]) + " |")
    ways = (("mean of sigma_xy/sigma_yy (all other numbers here)", "mu"), ("ratio of the means", "mu_means"),
            ("mean of sigma_xy over the pressure (sigma_xx + sigma_yy)/2", "mu_pressure"),
            ("without the kinetic part", "mu_contacts"), ("first quarter of the strain", "mu_early"),
            ("last quarter", "mu_late"))
    shown = [base, *(row for row in rows if row["group"] == CASES[-1].group)]
    out += ["", "| how the mean is taken | " + " | ".join(row["case"] for row in shown) + " |", "|" + "---|" * (len(shown) + 1)]
    return out + [f"| {text} | " + " | ".join(f"{row[name]:.4f}" for row in shown) + " |" for text, name in ways]


def draw(rows, folder):
    from ratchet import style
    plt = style.plt
    base = base_of(rows)
    groups = list(dict.fromkeys(row["group"] for row in rows))
    picture, axis = plt.subplots(figsize=(style.WIDTH, 6.4), layout="constrained")
    axis.axvspan(base["mu"] - base["mu_error"], base["mu"] + base["mu_error"], color=style.GREY, alpha=0.25, lw=0)
    low, high = FOUND[0] - FOUND[1], FOUND[0] + FOUND[1]
    axis.axvspan(low, high, color=style.COLOURS[1], alpha=0.2, lw=0)
    axis.text(FOUND[0], -1.1, "independent deck", color=style.COLOURS[1], fontsize=8, va="center", ha="center")
    axis.text(base["mu"], -1.1, "the deck", color=style.GREY, fontsize=8, va="center", ha="center")
    at, ticks = 0.0, []
    for k, group in enumerate(groups):
        for row in (row for row in rows if row["group"] == group):
            axis.errorbar(row["mu"], at, xerr=row["mu_error"], fmt="o", ms=4, lw=1,
                          color=style.COLOURS[k % len(style.COLOURS)])
            ticks.append((at, row["case"] if group == CASES[0].group else f"{group}: {row['case']}"))
            at += 1
        at += 0.6
    axis.set_yticks([it[0] for it in ticks], [it[1] for it in ticks], fontsize=8)
    axis.tick_params(axis="y", which="minor", length=0)
    axis.set_ylim(at, -1.8)
    axis.set_xlabel(r"$\mu^*$ at $I = 0.1$")
    picture.savefig(os.path.join(folder, "rheology-cases.png"))
    plt.close(picture)
