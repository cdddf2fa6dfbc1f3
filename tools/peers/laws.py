"""Each contact law of LAMMPS' pair style granular in keys of slipdisk: here the parameters are matched.

A pair has R_eff = R_a R_b/(R_a + R_b) and m_eff = m_a m_b/(m_a + m_b); at a wall they are R and m of the disk. LAMMPS
multiplies some of its numbers by them, slipdisk only with E_star (docs/laws.md): else a pair of materials has numbers of
its own, so that disks of two sizes are two materials here, and the wall is a third one.

  LAMMPS                          force                                             slipdisk
  hooke K g, damping velocity     K delta - g u_n                                   k_n = K, gamma_n = g
    damping mass_velocity         K delta - m_eff g u_n                             gamma_n = m_eff g
    damping tsuji                 K delta - alpha(g) sqrt(m_eff K) u_n              gamma_n = alpha(g) sqrt(m_eff K)
  hertz K g                       K sqrt(R_eff) delta^(3/2)                         k_n = K sqrt(R_eff)
    damping viscoelastic          m_eff g sqrt(R_eff delta) u_n                     has none that grows like this
    damping tsuji                 alpha(g) sqrt(m_eff K) (R_eff delta)^(1/4) u_n    restitution = g
  tangential linear_history K x mu                                                  k_t = K, gamma_t = x damping
  tangential mindlin K x mu       stiffness K sqrt(R_eff delta)                     "mindlin", k_t = K sqrt(R_eff)
  rolling sds K g mu              rate R_eff (omega_a - omega_b), force <= mu F_n   k_r = K, gamma_r = g, mu_r = mu
  dmt E g nu w                    hertz 4/3 E/(2 (1 - nu^2)) g less 4 pi w R_eff    "constant", pull_off = 4 pi w R_eff

alpha(e) is the polynomial that LAMMPS fits to the damping of Tsuji, Tanaka and Ishida (Powder Technology 71, 239)."""
import functools
import math
import typing

import numpy as np

RADII, DENSITY = {"a": 0.008, "b": 0.012}, 3.57     # of the two sizes; mass per area
MASSES = {name: DENSITY * math.pi * radius**2 for name, radius in RADII.items()}
K, K_T, GAMMA, MU = 1e4, 5e3, 0.5, 0.5              # linear
K_HERTZ, K_MINDLIN = 1.5e7, 8e6                     # of LAMMPS: times sqrt(R_eff)
E, MASS_RATE, VISCOELASTIC = 0.6, 1000.0, 2e6       # restitution; damping times m_eff; times m_eff sqrt(R_eff delta)
K_R, GAMMA_R, MU_R = 2e3, 0.1, 0.02                 # rolling
ADHESION = 0.02                                     # energy per area: dmt
MATCHED = 0.1                                       # speed at which a damping that is not ours has the same restitution


class Law(typing.NamedTuple):
    lammps: str             # words of pair_coeff and fix wall/gran
    keys: typing.Callable   # (R_eff, m_eff) -> keys of a slipdisk material or pair
    why: str                # what is left of a difference
    rolls: bool = False     # has rolling resistance


def tsuji(e):
    """alpha of LAMMPS for a coefficient of restitution e."""
    return float(np.polyval((4.8218, -18.022, 27.467, -22.348, 11.087, -4.2783, 1.2728), e))


def tsuji_e(e, limited=False):
    """Restitution that LAMMPS' alpha(e) gives: alpha = sqrt(5) b (docs/physics.md). Its polynomial is for a damping
    with the mass of a sphere; with m_eff, half of it, alpha is too small by sqrt(2). limited: the force never pulls."""
    b = tsuji(e) / math.sqrt(5)
    w = math.sqrt(1 - b * b)
    turn = math.pi - math.atan2(2 * b * w, w * w - b * b) if limited else math.pi
    return math.exp(-b * turn / w)


def effective(one, other):
    """(R_eff, m_eff) of two sizes; other "w": a wall."""
    if other == "w":
        return RADII[one], MASSES[one]
    radius, mass = RADII, MASSES
    return (radius[one] * radius[other] / (radius[one] + radius[other]),
            mass[one] * mass[other] / (mass[one] + mass[other]))


def restitution(force, damping, m_eff, speed, limited, steps=4000):
    """e of a collision along the line of centres with F = force(delta) - damping(delta) d(delta)/dt; limited: F >= 0.
    Fourth-order Runge-Kutta, until the bodies part."""
    largest = 1.0                                       # about: brings the step to the scale of the collision
    while force(largest) * largest > m_eff * speed**2:
        largest /= 2
    dt = largest / speed / steps

    def rate(delta, u):
        delta = max(delta, 0.0)
        push = force(delta) + damping(delta) * u
        return u, -(max(push, 0.0) if limited else push) / m_eff

    delta, u = 0.0, speed
    for _ in range(20 * steps):
        a = rate(delta, u)
        b = rate(delta + dt / 2 * a[0], u + dt / 2 * a[1])
        c = rate(delta + dt / 2 * b[0], u + dt / 2 * b[1])
        d = rate(delta + dt * c[0], u + dt * c[1])
        before = delta, u
        delta += dt / 6 * (a[0] + 2 * b[0] + 2 * c[0] + d[0])
        u += dt / 6 * (a[1] + 2 * b[1] + 2 * c[1] + d[1])
        if delta <= 0:                                  # on the way through 0
            return -(before[1] + (u - before[1]) * before[0] / (before[0] - delta)) / speed
    return 0.0


@functools.cache
def viscoelastic_e(radius, mass, speed=MATCHED):
    """Restitution of LAMMPS' hertz with damping viscoelastic, which falls with the speed."""
    return restitution(lambda d: K_HERTZ * math.sqrt(radius) * d**1.5,
                       lambda d: VISCOELASTIC * mass * math.sqrt(radius * d),
                       mass, speed, False)


# --- keys of slipdisk -----------------------------------------------------------------------------------------
def linear(**more):
    return lambda radius, mass: {"k_n": K, "gamma_n": GAMMA, "k_t": K_T, "mu": MU, **more}


def hertz(radius, **more):
    return {"law": "hertz", "k_n": K_HERTZ * math.sqrt(radius), "mu": MU, **more}


def mindlin(radius, _mass):
    return hertz(radius, restitution=tsuji_e(E, True), tangential="mindlin", k_t=K_MINDLIN * math.sqrt(radius))


def dmt(radius, _mass):
    return hertz(radius, gamma_n=GAMMA, limit_damping=False, k_t=K_T, cohesion="constant", range=1e-9,
                 pull_off=4 * math.pi * ADHESION * radius)


SLIDER = f"linear_history {K_T!r} 0.0 {MU!r}"
HOOKE = f"hooke {K!r} {GAMMA!r} damping velocity tangential {SLIDER}"
TSUJI = f"hertz {K_HERTZ!r} {E!r} damping tsuji tangential"
ARM = "tangential force at R - delta/2 in LAMMPS, at R here"
PULLS = "while the damping pulls, friction is limited by mu times the size of F_n in LAMMPS, by 0 here"

LAWS = {
    "hooke": Law(f"{HOOKE} limit_damping", linear(), ARM),
    "hooke, may pull": Law(HOOKE, linear(limit_damping=False), PULLS),
    "hooke, mass_velocity": Law(
        f"hooke {K!r} {MASS_RATE!r} damping mass_velocity tangential {SLIDER} limit_damping",
        lambda radius, mass: {**linear()(radius, mass), "gamma_n": MASS_RATE * mass}, ARM),
    "hooke, tsuji": Law(
        f"hooke {K!r} {E!r} damping tsuji tangential {SLIDER}",
        lambda radius, mass: {**linear(limit_damping=False)(radius, mass), "gamma_n": tsuji(E) * math.sqrt(mass * K)},
        f"{PULLS}. alpha is meant for hertz: e is not the {E} that is asked for"),
    "hooke, gamma_t": Law(f"{HOOKE.replace(' 0.0 ', ' 0.5 ')} limit_damping",
                          linear(gamma_t=0.5 * GAMMA),
                          "while a contact slides, LAMMPS' spring has the limit less the dashpot, slipdisk's the "
                          "limit and the dashpot what is left of it: seen at 60 degrees"),
    "hertz, velocity": Law(f"hertz {K_HERTZ!r} {GAMMA!r} damping velocity tangential {SLIDER} limit_damping",
                           lambda radius, mass: hertz(radius, gamma_n=GAMMA, k_t=K_T), ARM),
    "hertz, viscoelastic": Law(
        f"hertz {K_HERTZ!r} {VISCOELASTIC!r} damping viscoelastic tangential {SLIDER}",
        lambda radius, mass: hertz(radius, restitution=viscoelastic_e(radius, mass), limit_damping=False, k_t=K_T),
        f"damping that grows with sqrt(delta) is not in slipdisk: restitution chosen to be the same at {MATCHED} m/s"),
    "hertz, tsuji": Law(f"{TSUJI} {SLIDER}",
                        lambda radius, mass: hertz(radius, restitution=tsuji_e(E), limit_damping=False, k_t=K_T),
                        f"asked for e = {E} LAMMPS gives 0.70, slipdisk is asked for that. {PULLS}"),
    "mindlin": Law(f"{TSUJI} mindlin {K_MINDLIN!r} 0.0 {MU!r} limit_damping", mindlin,
                   "LAMMPS keeps the displacement while the stiffness falls or grows: it makes and loses energy"),
    "mindlin_rescale": Law(f"{TSUJI} mindlin_rescale {K_MINDLIN!r} 0.0 {MU!r} limit_damping", mindlin,
                           "LAMMPS shortens the displacement on unloading like a, force like a^2: it "
                           "loses energy"),
    "mindlin/force": Law(f"{TSUJI} mindlin/force {K_MINDLIN!r} 0.0 {MU!r} limit_damping", mindlin,
                         "LAMMPS keeps the force when only delta changes: makes energy on unloading"),
    "mindlin_rescale/force": Law(f"{TSUJI} mindlin_rescale/force {K_MINDLIN!r} 0.0 {MU!r} limit_damping", mindlin,
                                 "LAMMPS lets the force fall like a on unloading, slipdisk like sqrt(a), which keeps "
                                 "the energy"),
    "rolling sds": Law(f"hooke {K!r} {GAMMA!r} damping velocity tangential {SLIDER} rolling sds {K_R!r} "
                       f"{GAMMA_R!r} {MU_R!r} limit_damping",
                       linear(k_r=K_R, gamma_r=GAMMA_R, mu_r=MU_R), ARM, rolls=True),
    "dmt": Law(f"dmt {1.5 * K_HERTZ!r} {GAMMA!r} 0.0 {ADHESION!r} damping velocity tangential {SLIDER}", dmt,
               "LAMMPS' limit of friction is mu (repulsion + pull-off), slipdisk's mu times the repulsion; its "
               "pull-off begins at touch, slipdisk's over a range of 1e-9"),
}


# --- decks and scripts ----------------------------------------------------------------------------------------
def value(it):
    if isinstance(it, bool):
        return "true" if it else "false"
    return f'"{it}"' if isinstance(it, str) else repr(float(it))


def group(keys):
    return " ".join(f"{name} = {value(it)};" for name, it in keys.items())


def materials(law):
    """Two sizes and a wall, each pair with the numbers that LAMMPS' law has for it."""
    own = [f'  {{ name = "{name}"; {group(law.keys(*effective(name, name)))} }}' for name in RADII]
    own.append(f'  {{ name = "w"; k_n = {K!r}; }}')     # a wall never touches a wall
    pairs = [f'  {{ materials = ("{one}", "{other}"); {group(law.keys(*effective(one, other)))} }}'
             for one, other in (("a", "b"), ("a", "w"), ("b", "w"))]
    return ("materials = (\n" + ",\n".join(own) + "\n);\nmaterial_pairs = (\n" + ",\n".join(pairs) + "\n);\n")
