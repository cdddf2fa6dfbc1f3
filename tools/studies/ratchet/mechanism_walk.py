"""Permanent sliding at any strength of a random drive: I dOmega/dt = T(s1, s2) with the torques (15)-(18) and
s_i = sign(w_i - Omega).

The supports' velocities w_i are those of (52), with the linear response of the upper centre, so nothing is fitted. The
disk that catches up with a support goes along with it for a while, as torques are steps: a step of time is implicit.
Many copies at once, each of a duration of some 1/omega; the mean over all.
"""
import dataclasses
import math

import numpy as np

from .mechanism_theory import SIGNS, forces, torques

STEP, COPIES, WARM, TIME = 1e-4, 600, 0.4, 1.6


def propagator(drive, h):
    """Step of one oscillator (52): matrix, and Cholesky factor of the noise."""
    w, c = drive.omega, drive.damping
    w1, decay = w * math.sqrt(1 - c * c), math.exp(-c * w * h)
    cos, sin = math.cos(w1 * h), math.sin(w1 * h) / w1
    matrix = decay * np.array([[cos + c * w * sin, sin], [-w * w * sin, cos - c * w * sin]])
    law = np.diag([drive.eps ** 2, (w * drive.eps) ** 2])
    noise = law - matrix @ law @ matrix.T
    low = math.sqrt(max(noise[0, 0], 1e-300))
    cross = noise[0, 1] / low
    return matrix, np.array([[low, 0], [cross, math.sqrt(max(noise[1, 1] - cross ** 2, 0))]])


class Centre:
    """The upper centre on its normal springs, from where it rests without friction; `moved`: friction moves it, too."""

    def __init__(self, system, copies, moved):
        self.system, self.moved = system, moved
        s, c = math.sin(system.theta_h), math.cos(system.theta_h)
        self.normal = np.array([[-s, -c], [s, -c]])  # from the upper disk to the supports
        self.along = np.array([[c, -s], [c, s]])     # a positive torque pushes the upper surface this way
        self.rest = np.array(forces(dataclasses.replace(system, mu=0.0), (1, 1)))[:, None]
        self.place, self.speed, self.tau = np.zeros((2, copies)), np.zeros((2, copies)), np.zeros((2, copies))

    def step(self, u, v, h):
        """(velocities along the contacts that supports and centre have relative to each other, normal forces)
        u, v: x, y of support 1, then of support 2, and their velocities."""
        system = self.system
        pressed = np.stack([self.normal[i] @ (self.place - u[2 * i:2 * i + 2]) for i in (0, 1)])
        rate = np.stack([self.normal[i] @ (self.speed - v[2 * i:2 * i + 2]) for i in (0, 1)])
        extra = system.k_n * pressed + system.gamma_n * rate
        force = -self.normal.T @ extra
        if self.moved:
            force += self.along.T @ self.tau
        self.speed += h / system.mass * force
        self.place += h * self.speed
        drag = np.stack([self.along[i] @ (v[2 * i:2 * i + 2] - self.speed) for i in (0, 1)])
        return drag, np.maximum(self.rest + extra, 0)


def mean(system, drive, moved=False, seed=1):
    """(Omega, its error, fractions of time in S++ S+- S-+ S--, stuck) of independent signals. moved: with the normal
    forces of the moment, which friction changes as it moves the centre, in place of those at the equilibria."""
    random = np.random.default_rng(seed)
    planar = "x" in drive.coordinates
    n = 6 if planar or moved else 2
    matrix, noise = propagator(drive, STEP)
    used = np.array([True, True, *[planar] * (n - 2)])[:, None]
    u = random.standard_normal((n, COPIES)) * drive.eps * used
    v = random.standard_normal((n, COPIES)) * drive.eps * drive.omega * used
    centre, omega = Centre(system, COPIES, moved), np.zeros(COPIES)
    gain = STEP / system.inertia
    rise = {key: gain * value for key, value in torques(system).items()}
    total, parts, looks = np.zeros(COPIES), np.zeros(5), 0
    steps, warm = round((WARM + TIME) / STEP), round(WARM / STEP)
    for i in range(steps):
        a, b = random.standard_normal((2, n, COPIES)) * used
        u, v = (matrix[0, 0] * u + matrix[0, 1] * v + noise[0, 0] * a,
                matrix[1, 0] * u + matrix[1, 1] * v + noise[1, 0] * a + noise[1, 1] * b)
        w = -v[:2]
        if n > 2:
            drag, normal = centre.step(u[2:], v[2:], STEP)
            w = w + drag
        if moved:
            limit = gain * system.mu * normal
            rise = {key: s * limit[0] + t * limit[1] for key, (s, t) in SIGNS.items()}
        before = omega
        middle = np.clip(omega + np.where(w[0] > w[1], rise["pm"], rise["mp"]), w.min(axis=0), w.max(axis=0))
        omega = np.minimum(np.maximum(middle, omega + rise["mm"]), omega + rise["pp"])
        if moved:  # what slides has the friction of its limit, what sticks the rest of the torque
            tau = np.sign(w - omega) * system.mu * normal
            left = (omega - before) / gain - tau.sum(axis=0)
            centre.tau = tau + np.where(w == omega, left, 0.0)
        if i < warm:
            continue
        total += omega
        if i % 10 == 0:
            first, second = w > omega
            stuck = (w == omega).any(axis=0)
            parts += [np.mean(f & s & ~stuck) for f, s in ((first, second), (first, ~second), (~first, second),
                                                           (~first, ~second))] + [np.mean(stuck)]
            looks += 1
    values = total / (steps - warm)
    return float(values.mean()), float(values.std(ddof=1) / math.sqrt(COPIES)), parts / looks
