"""Permanent sliding under random and periodic drive: what the paper's torques and the supports' statistics
predict.

The configuration is set by the signs of w_i - Omega, where w_i is the velocity with which support i drags the upper
disk's surface. Under the vibration (52) the w_i are Gaussian, and so is the motion of the upper disk's centre that
the normal springs pass on. With the torques (15)-(18) and a steady Omega (strong drive) the balance

    sum T(s1, s2) P(s1, s2; Omega) = 0

then gives Omega without a free parameter.
"""
import dataclasses
import math

import numpy as np

SIGNS = {"pp": (1, 1), "pm": (1, -1), "mp": (-1, 1), "mm": (-1, -1)}
NODES, NODE_WEIGHTS = np.polynomial.legendre.leggauss(64)


@dataclasses.dataclass(frozen=True)
class System:
    """The paper's three disks, R = m g = 1."""
    theta_h: float = math.pi / 6
    tilt: float = 0.0
    mu: float = 0.1
    k_n: float = 1e3
    gamma_n: float = 10.0
    mass: float = 0.1

    @property
    def inertia(self):
        return self.mass / 2


def forces(system, signs):
    """Normal forces (n1, n2) in equilibrium of the centre with both contacts sliding: (13), (14)."""
    a1, a2 = system.theta_h - system.tilt, system.theta_h + system.tilt
    p1, p2 = (s * math.atan(system.mu) for s in signs)
    scale = math.cos(p1) / math.sin(2 * system.theta_h + p1 - p2)
    return math.sin(a2 - p2) * scale, math.sin(a1 + p1) * scale


def torque(system, signs):
    """(15)-(18)"""
    return system.mu * sum(s * n for s, n in zip(signs, forces(system, signs)))


def torques(system):
    return {key: torque(system, signs) for key, signs in SIGNS.items()}


def stable(system):
    """Whether the centre has an equilibrium in each configuration: all normal forces compressive, S-+ attracts."""
    return math.tan(system.theta_h) > system.mu and all(n > 0 for s in SIGNS.values() for n in forces(system, s))


@dataclasses.dataclass(frozen=True)
class Drive:
    """Random vibration of the supports; `own`: by signals of their own."""
    eps: float = 1e-4
    omega: float = 20 * math.pi
    damping: float = 0.5
    coordinates: tuple = ("x", "y", "theta")
    supports: tuple = (0, 1)
    own: bool = True


def covariance(system, drive):
    """Covariance of (w1, w2): integrals of the supports' spectrum over the linear response of the centre."""
    sine, cosine = math.sin(system.theta_h), math.cos(system.theta_h)
    # Frequencies: dense around the resonances, with the 1/f^2 tail of the velocity's spectrum.
    f = drive.omega * np.tan(np.linspace(0, math.pi / 2, 20001)[1:-1])
    step = np.gradient(f)
    w, c = drive.omega, drive.damping
    spectrum = 2 / math.pi * 2 * c * w ** 3 * drive.eps ** 2 * f ** 2 / ((w ** 2 - f ** 2) ** 2 + (2 * c * w * f) ** 2)
    follow = []
    for part in (sine, cosine):  # the centre's mode in x and in y
        spring = 2 * system.k_n * part ** 2 / system.mass + 2j * f * system.gamma_n * part ** 2 / system.mass
        follow.append(spring / (spring - f ** 2))
    x, y = follow
    cot, tan = cosine / sine, sine / cosine
    # Rows: w1, w2; columns: x, y, theta of support 1, then of support 2. The centre is taken along by
    # x (X1 + X2 + cot (Y1 - Y2))/2 and y (tan (X1 - X2) + Y1 + Y2)/2.
    zero, one = np.zeros_like(x), np.ones_like(x)
    gain = np.array([[cosine - cosine * x / 2 + sine * tan * y / 2, -sine - cosine * cot * x / 2 + sine * y / 2, -one,
                      -cosine * x / 2 - sine * tan * y / 2, cosine * cot * x / 2 + sine * y / 2, zero],
                     [-cosine * x / 2 - sine * tan * y / 2, -cosine * cot * x / 2 - sine * y / 2, zero,
                      cosine - cosine * x / 2 + sine * tan * y / 2, sine + cosine * cot * x / 2 - sine * y / 2, -one]])
    names = ("x", "y", "theta")
    used = [[float(name in drive.coordinates and k in drive.supports) for name in names] for k in (0, 1)]
    gain = gain.reshape(2, 2, 3, -1) * np.array(used)[None, :, :, None]
    gain = gain.reshape(2, 6, -1) if drive.own else gain.sum(axis=1)
    return np.real(np.einsum("ikf,jkf,f->ij", gain, gain.conj(), spectrum * step))


def normal(x):
    return 0.5 * math.erfc(-x / math.sqrt(2))


def quadrants(covariance, omega=0.0):
    """Probabilities of the four configurations, {"pp": ..., ...}."""
    deviation = np.sqrt(np.maximum(np.diag(covariance), 1e-300))
    rho = min(1.0, max(-1.0, covariance[0, 1] / (deviation[0] * deviation[1])))
    h, k = -omega / deviation
    top = math.asin(rho)
    t = top * (NODES + 1) / 2
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        density = np.exp(-(h * h - 2 * h * k * np.sin(t) + k * k) / (2 * np.cos(t) ** 2)) / (2 * math.pi)
    both = normal(h) * normal(k) + top / 2 * float(np.sum(NODE_WEIGHTS * np.nan_to_num(density)))
    return {"pp": both, "pm": normal(h) - both, "mp": normal(k) - both, "mm": 1 - normal(h) - normal(k) + both}


def mean_torque(torque_of, weight_of):
    return sum(torque_of[key] * weight_of[key] for key in SIGNS)


def steady(torque_of, covariance):
    """Omega at which the torques balance: the mean torque falls as Omega rises."""
    reach = 8 * math.sqrt(max(covariance[0, 0], covariance[1, 1]))
    low, high = -reach, reach
    if not mean_torque(torque_of, quadrants(covariance, low)) > 0 > mean_torque(torque_of, quadrants(covariance, high)):
        return math.nan
    for _ in range(60):
        middle = (low + high) / 2
        if mean_torque(torque_of, quadrants(covariance, middle)) > 0:
            low = middle
        else:
            high = middle
    return (low + high) / 2


def predicted(system, drive):
    """Omega of the strong drive, NaN where a configuration has no equilibrium."""
    return steady(torques(system), covariance(system, drive)) if stable(system) else math.nan


def alternating(system, phase):
    """Omega/(Theta_b w_b) of supports that turn as parabolas `phase` = 0, pi/2 or pi apart, strong drive."""
    if not stable(system):
        return math.nan
    t = torques(system)
    same, mixed, width = t["pp"] + t["mm"], t["pm"] + t["mp"], t["pp"] - t["mm"]
    if phase == 0:
        x = same / width
    elif phase == math.pi:
        x = mixed / (2 * (t["pp"] if mixed < 0 else -t["mm"]) + abs(mixed))  # S++ occurs, or S-- does
    else:  # S++ and S-- last 1/4 -+ x/2, the other two 1/4
        x = (same + mixed) / (2 * width)
    return 4 / math.pi * x


def slight_tilt_zero(mu):
    """theta_h at which (19) changes its sign."""
    return math.acos(-mu ** 2 / (1 + mu ** 2)) / 2
