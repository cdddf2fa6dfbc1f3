"""Permanent sliding at any strength of a random drive: I dOmega/dt = T(s1, s2) with the torques (15)-(18) and
s_i = sign(w_i - Omega).

The supports' velocities w_i are those of (52), with the linear response of the upper centre, so nothing is fitted. The
disk that catches up with a support goes along with it for a while, as torques are steps: a step of time is implicit.
Many copies at once, each of a duration of some 1/omega; the mean over all.
"""
import math

import numpy as np

from .mechanism_theory import torques

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
    """The upper centre, carried along by the normal springs."""

    def __init__(self, system, copies):
        s, c = math.sin(system.theta_h), math.cos(system.theta_h)
        self.s, self.c = s, c
        self.spring = 2 * system.k_n / system.mass * np.array([[s * s], [c * c]])
        self.drag = 2 * system.gamma_n / system.mass * np.array([[s * s], [c * c]])
        self.place, self.speed = np.zeros((2, copies)), np.zeros((2, copies))

    def aim(self, u):
        """Where the springs would hold the centre; u: x, y of support 1, then of support 2."""
        cot = self.c / self.s
        return np.stack([(u[0] + u[2] + cot * (u[1] - u[3])) / 2, ((u[0] - u[2]) / cot + u[1] + u[3]) / 2])

    def step(self, u, v, h):
        """The velocities along the contacts that supports and centre have relative to each other."""
        self.speed += h * (self.spring * (self.aim(u) - self.place) + self.drag * (self.aim(v) - self.speed))
        self.place += h * self.speed
        x, y = self.speed
        return self.c * (v[0] - x) - self.s * (v[1] - y), self.c * (v[2] - x) + self.s * (v[3] - y)


def mean(system, drive, seed=1):
    """(Omega, its error, fractions of time in S++ S+- S-+ S--, stuck) of independent signals."""
    random = np.random.default_rng(seed)
    planar = "x" in drive.coordinates
    n = 6 if planar else 2
    matrix, noise = propagator(drive, STEP)
    u = random.standard_normal((n, COPIES)) * drive.eps
    v = random.standard_normal((n, COPIES)) * drive.eps * drive.omega
    centre, omega = Centre(system, COPIES), np.zeros(COPIES)
    rise = {key: STEP / system.inertia * value for key, value in torques(system).items()}
    total, parts, looks = np.zeros(COPIES), np.zeros(5), 0
    steps, warm = round((WARM + TIME) / STEP), round(WARM / STEP)
    for i in range(steps):
        a, b = random.standard_normal((2, n, COPIES))
        u, v = (matrix[0, 0] * u + matrix[0, 1] * v + noise[0, 0] * a,
                matrix[1, 0] * u + matrix[1, 1] * v + noise[1, 0] * a + noise[1, 1] * b)
        w1, w2 = -v[0], -v[1]
        if planar:
            along = centre.step(u[2:], v[2:], STEP)
            w1, w2 = w1 + along[0], w2 + along[1]
        middle = np.clip(omega + np.where(w1 > w2, rise["pm"], rise["mp"]), np.minimum(w1, w2), np.maximum(w1, w2))
        omega = np.minimum(np.maximum(middle, omega + rise["mm"]), omega + rise["pp"])
        if i < warm:
            continue
        total += omega
        if i % 10 == 0:
            first, second, stuck = w1 > omega, w2 > omega, (omega == w1) | (omega == w2)
            parts += [np.mean(f & s & ~stuck) for f, s in ((first, second), (first, ~second), (~first, second),
                                                           (~first, ~second))] + [np.mean(stuck)]
            looks += 1
    values = total / (steps - warm)
    return float(values.mean()), float(values.std(ddof=1) / math.sqrt(COPIES)), parts / looks
