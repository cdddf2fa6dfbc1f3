"""Mean contacts of each disk, from the contact tables of a run, and what balance of forces makes of sliding in them."""
import itertools

import numpy as np

MU = 0.1         # of all decks of shaken boxes
CLOSED = 0.1     # share of the time from which a contact belongs to the cage
MANY = 7         # contacts of which all combinations of signs are looked at


class Cage:
    """Mean contacts of a run: a row for each disk and each contact of it. Angles are those from the centre to the
    contact, force is the mean normal force (open counts as 0), closed the share of the time, mobilised the mean of
    tau/(mu F_n), rectified the covariance of that and F_n: their product and this together are the mean tangential
    force over mu."""

    def __init__(self, run, mu=MU):
        tables = run.result.contacts
        a, b, force, tau = (tables[name] for name in ("a", "b", "force", "tau"))
        slot = np.arange(run.n_disks + len(run.walls()))  # contacts have numbers of bodies, all else here is by slot
        slot[np.asarray(run.id, int)] = np.arange(run.n_free)
        a, b = slot[a], slot[b]
        moments, n = len(tables), run.n_free
        with np.errstate(divide="ignore", invalid="ignore"):
            share = np.where(force > 0, np.clip(tau / (mu * force), -1, 1), 0.0)
        pairs, row = np.unique(a.astype(np.int64) << 32 | b.astype(np.int64), return_inverse=True)
        seen = np.bincount(row)
        first, second = (pairs >> 32).astype(int), (pairs & 0xffffffff).astype(int)
        mean = np.bincount(row, force) / moments
        mobilised = np.bincount(row, share) / moments
        rectified = np.bincount(row, share * force) / moments - mobilised * mean
        angle = directions(run, first, second)
        side = [np.concatenate([first, second]), np.concatenate([second, first])]
        both = [np.tile(v, 2) for v in (seen / moments, mean, mobilised, rectified)]
        keep = (side[0] < n) & (both[0] >= CLOSED)
        self.disk, self.other = side[0][keep], side[1][keep]
        self.angle = np.concatenate([angle, angle + np.pi])[keep]
        self.closed, self.force, self.mobilised, self.rectified = (v[keep] for v in both)
        self.n, self.radius, self.weight = n, run.radius, 9.81 * run.mass

    def of(self, i):
        """Rows of disk i."""
        return np.flatnonzero(self.disk == i)


def directions(run, first, second):
    """Angles from the bodies `first`, disks, to `second`, disks or walls, by the mean places."""
    x, y, n = run.x, run.y, run.n_disks
    walls = run.walls()
    angle = np.empty(len(first))
    for k, (i, j) in enumerate(zip(first, second)):
        if j < n:
            angle[k] = np.arctan2(y[j] - y[i], x[j] - x[i])
            continue
        (px, py), (qx, qy) = walls[j - n][1][:2]
        length = np.hypot(qx - px, qy - py)
        normal = np.array([-(qy - py), qx - px]) / length
        away = (px - x[i]) * normal[0] + (py - y[i]) * normal[1]
        angle[k] = np.arctan2(*(np.sign(away) * normal)[::-1])
    return angle


def rectified_torque(angle, force, stiffness, mu=MU, signs=None):
    """Mean of sum_j s_j n_j over combinations of sliding signs s_j, with tau_j = s_j mu n_j in all contacts, where
    the normal forces n_j = N_j + k_j (u . e_j) have come to balance: of two contacts (15)-(18) over mu R. signs:
    rows of combinations, all of them by default. In balance with no friction the forces are N_j. Contacts that would
    pull are taken out."""
    angle, force, stiffness = (np.asarray(v, float) for v in (angle, force, stiffness))
    if len(angle) < 2:
        return np.nan
    if signs is None:
        signs = np.array(list(itertools.product((1, -1), repeat=len(angle))))
    total = [balance(angle, force, stiffness, mu * s) for s in np.asarray(signs, float)]
    found = [float(np.sum(s * n)) for s, n in zip(signs, total) if n is not None]
    return float(np.mean(found)) if found else np.nan


def balance(angle, force, stiffness, friction):
    """Normal forces n_j with tangential forces friction_j n_j that carry the same load as the forces N_j without;
    None when there is no such place of the centre."""
    normal = np.array([np.cos(angle), np.sin(angle)])
    tangent = np.array([-normal[1], normal[0]])
    acts = -normal + friction * tangent  # of n_j = 1, on the disk
    load = normal @ force
    active = np.ones(len(angle), bool)
    for _ in range(len(angle)):
        k = np.where(active, stiffness, 0)
        matrix = (acts * k) @ normal.T
        if abs(np.linalg.det(matrix)) < 1e-6 * np.sum(k) ** 2:
            return None
        u = np.linalg.solve(matrix, -load - acts @ np.where(active, force, 0))
        n = np.where(active, force + k * (u @ normal), 0)
        if (n >= 0).all():
            return n
        active &= n >= 0
        if active.sum() < 2:
            return None
    return None


def supports(angle, force):
    """The two contacts below the centre with the largest forces, left one first; None without two."""
    below = np.flatnonzero(np.sin(angle) < -1e-9)
    if len(below) < 2:
        return None
    two = below[np.argsort(force[below])[-2:]]
    return two[np.argsort(np.cos(angle[two]))]


def geometry(angle):
    """(tilt, half aperture) of two supports, left one first, with the load along gravity: alpha_1 = half - tilt is
    the angle of the left one from it, alpha_2 = half + tilt that of the right one (physics.md, section 10)."""
    left, right = -np.pi / 2 - angle[0], angle[1] + np.pi / 2
    left, right = (np.arctan2(np.sin(v), np.cos(v)) for v in (left, right))
    return (right - left) / 2, (right + left) / 2


def response(cage, torque, own=False):
    """Omega times 2/(pi v), from torques over mu R of all disks, where v is the mean speed of sliding: a small mean
    velocity of the surfaces, V = R_i Omega_i + R_j Omega_j, on top of a Gaussian one that has no mean shifts the
    mean sign of sliding by 2 V/(pi v). own: as if the neighbours did not turn."""
    matrix = np.zeros((cage.n, cage.n))
    np.add.at(matrix, (cage.disk, cage.disk), cage.force * cage.radius[cage.disk])
    if not own:
        near = cage.other < cage.n
        i, j = cage.disk[near], cage.other[near]
        np.add.at(matrix, (i, j), cage.force[near] * cage.radius[j])
    torque = np.where(np.isfinite(torque), torque, 0.0)
    used = np.diag(matrix) > 1e-6 * np.mean(np.diag(matrix))
    out = np.full(cage.n, np.nan)
    out[used] = np.linalg.lstsq(matrix[np.ix_(used, used)], torque[used], rcond=1e-6)[0]
    return out


def meshed(cage, omega):
    """Omega of each disk if it were a gear without a torque of its own between the disks that it touches."""
    total = np.bincount(cage.disk, cage.force * cage.radius[cage.disk], cage.n)
    near = cage.other < cage.n
    i, j = cage.disk[near], cage.other[near]
    push = np.bincount(i, cage.force[near] * cage.radius[j] * omega[j], cage.n)
    return np.where(total > 0, -push / np.where(total > 0, total, 1), np.nan)


def sliding_speed(run, cage, mu=MU):
    """Mean speed of sliding: the power of friction over mu times the sum of the mean normal forces."""
    inner = cage.other < cage.n
    return run.result.totals.power_friction / (mu * (cage.force[~inner].sum() + cage.force[inner].sum() / 2))
