"""Further series of inputs/shear/rheology.cfg: with the stiffness and restitution of da Cruz et al., and slow flow for long.

tools/studies/rheology.sh --series runs them and writes their tables; numbers in docs/studies/data/shear/rheology-more.csv."""
import math
import os

REFERENCE, SLOW = "reference", "slow"
TEXT = {REFERENCE: "k_n/P = 1e4, restitution 0.1 (a force that may pull), 1024 disks",
        SLOW: "the deck, 400 disks, strain 5 before and 5 measured"}
POINTS = {REFERENCE: (1e-3, 3e-3, 0.01, 0.02, 0.05, 0.1, 0.2, 0.3), SLOW: (1e-4,)}
DISKS = {REFERENCE: 1024, SLOW: 400}
STIFF = 1e4


def keys(name, rate):
    """{key of the deck: value} of a point."""
    side = 88 * math.sqrt(DISKS[name] / 4096)
    found = {"constants.I": rate, "packings[0].count": DISKS[name], "container.width": side, "container.height": side}
    if name == REFERENCE:
        dt = 3.3e-3 * math.sqrt(1000 / STIFF)
        strain = min(8, 0.7 * (rate / 1e-4) ** 0.4)
        found |= {"constants.kappa": STIFF, "dt": dt, "materials[0].limit_damping": "false",
                  "phases[2].series": max(1, round(strain / rate / dt / 2000))}
    if name == SLOW:
        found |= {"constants.wait": 5, "constants.strain": 5}
    return found


def path_of(folder, name, rate):
    return os.path.join(folder, name, f"I{rate:g}.h5")


def runs(folder):
    """[(path, keys)], the fastest first."""
    return [(path_of(folder, name, rate), keys(name, rate)) for name in (REFERENCE, SLOW)
            for rate in sorted(POINTS[name], reverse=True)]


def collect(folder, read, evaluate):
    """Rows of the points that have results."""
    return [{"series": name, **evaluate(*read(path_of(folder, name, rate)))} for name in POINTS for rate in POINTS[name]
            if os.path.exists(path_of(folder, name, rate))]


def of(rows, name):
    return [row for row in rows if row["series"] == name]
