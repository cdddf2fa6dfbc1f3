/* contact_step.h: one contact in one step, without branches: each lane of a vector is one
 * contact. Equations 2, 4, tau and 36 of the paper (docs/physics.md, sections 2 and 3).
 *
 * Included once per LANE_WIDTH after base/lane.h. Round pairs, wall segments and small systems
 * all use this code; the bits of a lane's result do not depend on LANE_WIDTH.
 *
 *   F_n  = max(F_el(delta) - gamma_n u_n, 0) while delta > 0
 *   zeta = lambda - lambda*; lambda* is shifted so that |zeta| <= mu F_n / k_t
 *   tau  = -k_t zeta
 *
 * Further parts of a law (law_tangential.h, law_rolling.h, law_bond.h, law_radius.h,
 * model/law_cohesion.h) are evaluated if their bit is set in `features` (model/law_features.h). In
 * passes over plain laws features is the constant 0; in passes over general laws it is the same
 * number for all pairs.
 *
 * lambda is measured from the contact's reference direction e: lambda = arc - sum * turned, with
 * arc = R_a th_a + R_b th_b and turned = angle from e to n. After a step with |sin(turned)| >
 * CONTACT_REBASE the contact gets a new e, so the terms of the series of asin(e x n) that are
 * used below are exact to rounding.
 *
 * Each step evaluates a contact once and changes its history there: with velocity Verlet at the
 * new positions, with Gear at the predicted ones (predict, evaluate, correct). The losses of a
 * step are the trapezoidal work between the previous evaluation and this one (docs/physics.md,
 * section 8). */
#include "model/law_cohesion.h"
#include "model/normal_laws.h"

#ifndef CONTACT_STEP_COMMON
#define CONTACT_STEP_COMMON
#define CONTACT_REBASE 0.015625
#define CONTACT_SIGN 0x8000000000000000u
#endif

/* --- geometry --------------------------------------------------------------------------------- */

/* Input of the geometry of a pair of bodies a and b: their relative position and velocity, radii
 * and angles. */
typedef struct LANE(pair_input) {
  /* vector from a's centre to b's centre, or to the nearest point of a wall segment */
  LANE(real) dx, dy;
  LANE(real) dvx, dvy; /* velocity of this point of b (material of b) relative to a's centre */
  /* R_a + R_b, where R_b < 0 for a round wall around the disk; R_a for a wall segment */
  LANE(real) sum;
  LANE(real) arc;    /* R_a theta_a + R_b theta_b, a length */
  LANE(real) ex, ey; /* reference direction of the contact, a unit vector; (0, 0): open */
} LANE(pair_input);

/* First part of a pair's geometry, with a square root and a division. It has its own struct so that
 * the processor can execute other instructions until these two are completed. */
typedef struct LANE(pair_distance) {
  LANE(real) dx, dy, sum, arc; /* copies of the members of pair_input */
  LANE(real) dot;              /* scalar product of (dx, dy) and (dvx, dvy) */
  LANE(real) cross;            /* cross product of the reference direction (ex, ey) and (dx, dy) */
  LANE(real) r;                /* length of (dx, dy), with the sign of `sum` */
  LANE(real) inverse_r;        /* 1/r */
  /* nx^2 + ny^2, if the nearest image of b is (nx, ny) cells away; only set in a deforming box */
  LANE(real) away;
  /* cross product of (dx, dy) and (dvx, dvy); only set in passes of kind PASS_GENERAL */
  LANE(real) cross_velocity;
} LANE(pair_distance);

/* Geometry and relative motion of a pair of bodies a and b. */
typedef struct LANE(pair_geometry) {
  LANE(real) nx, ny;   /* unit normal, from a's centre towards the surface of b */
  LANE(real) reach;    /* overlap, negative for a gap */
  LANE(real) approach; /* normal relative velocity u_n, positive while the bodies separate */
  LANE(real) arc;      /* R_a theta_a + R_b theta_b, a length */
  /* tangential coordinate lambda, a length, measured from the reference direction e of the
   * contact */
  LANE(real) lambda;
  LANE(real) turned, sine2; /* angle from e to the normal, rad; square of its sine */
  LANE(real) lever;         /* lever of the tangential force, (R_a + R_b)/r; 1 at zero overlap */
  /* dlambda/dt; only set if laws have tangential dashpots, and when a contact begins */
  LANE(real) slide;
  /* rho: rolling displacement R_eff (theta_a - theta_b); rolls: its time derivative; arm: R_eff.
   * All are only set for laws with rolling resistance. */
  LANE(real) rho, rolls;
  LANE(real) arm;
} LANE(pair_geometry);

/* Computes the first part of a pair's geometry, up to 1/r. Members are copied one by one, since
 * compilers translate a copy of the whole struct poorly. */
LANE_INLINE void LANE(pair_distance_of)(const LANE(pair_input) * in, LANE(pair_distance) * d) {
  d->dx = in->dx;
  d->dy = in->dy;
  d->sum = in->sum;
  d->arc = in->arc;
  d->dot = in->dvx * in->dx + in->dvy * in->dy;
  d->cross = in->ex * in->dy - in->ey * in->dx;
  /* The lower bound of r^2 keeps results finite if the centres coincide. It also makes the pair
   * count as a contact if a coordinate is not a number, so that the step in which this happens is
   * examined. */
  LANE(real) r = LANE(sqrt)(LANE(max)(in->dx * in->dx + in->dy * in->dy, LANE(splat)(1e-280)));
  d->r = LANE(as_real)(LANE(as_bits)(r) | (LANE(as_bits)(in->sum) & CONTACT_SIGN));
  d->inverse_r = 1.0 / d->r;
}

/* Completes the geometry from its first part. The caller must set slide, rho, rolls and arm if they
 * are needed. */
LANE_INLINE void LANE(pair_geometry_at)(const LANE(pair_distance) * d, LANE(pair_geometry) * g) {
  LANE(real) inverse_r = d->inverse_r;
  g->nx = d->dx * inverse_r;
  g->ny = d->dy * inverse_r;
  g->reach = d->sum - d->r;
  g->approach = d->dot * inverse_r;
  g->lever = d->sum * inverse_r;
  /* angle from the reference direction to the normal: first terms of the series of asin(s) */
  LANE(real) s = d->cross * inverse_r, z = s * s;
  LANE(real) turned = s + (s * z) * (((15.0 / 336.0) * z + 3.0 / 40.0) * z + 1.0 / 6.0);
  g->sine2 = z;
  g->turned = turned;
  g->arc = d->arc;
  g->lambda = d->arc - d->sum * turned;
}

LANE_INLINE LANE(pair_geometry) LANE(pair_geometry_of)(const LANE(pair_input) * in) {
  LANE(pair_distance) d;
  LANE(pair_geometry) g;
  LANE(pair_distance_of)(in, &d);
  LANE(pair_geometry_at)(&d, &g);
  return g;
}

/* --- step of a contact ------------------------------------------------------------------------ */

#define LAW_LANES(features, name, value) LANE(real) name;
typedef struct LANE(contact_constants) {
  LANE(real) k_n, k_t, half_k_t, gamma_n, cap; /* cap: mu/k_t; 0 if k_t is 0 (frictionless) */
  /* Only set with LAW_NORMAL: number of the normal law, and law_tsuji sqrt(m_eff k_n), which scales
   * its damping. */
  LANE(real) normal, tsuji;
  LAW_CONSTANTS(LAW_LANES) /* each only set with its features */
} LANE(contact_constants);
#undef LAW_LANES

/* Returns the constants of the attraction. */
LANE_INLINE LANE(cohesion) LANE(cohesion_of)(const LANE(contact_constants) * k) {
  return (LANE(cohesion)){.bridge = LANE(greater)(k->bridge, LANE(splat)(0.0)),
                          .pull_off = k->pull_off,
                          .range = k->range,
                          .per_range = k->per_range,
                          .broken = k->broken};
}

/* Returns the elastic normal force at overlap delta >= 0. Without LAW_NORMAL in `features` the law
 * is linear; this holds for the two functions below, too. */
LANE_INLINE LANE(real) LANE(law_elastic)(const LANE(contact_constants) * k, LANE(real) delta,
                                         const unsigned features) {
  const int mixed = (features & LAW_NORMAL) != 0;
  LANE(real) force = LANE(linear_elastic)(k->k_n, delta);
#define LAW_CASE(number, word, keys, meaning)                                                      \
  if (mixed && number != SD_NORMAL_LINEAR)                                                         \
    force = LANE(select)(LANE(equal)(k->normal, LANE(splat)((double)number)),                      \
                         LANE(word##_elastic)(k->k_n, delta), force);
  NORMAL_LAWS(LAW_CASE)
#undef LAW_CASE
  return force;
}

/* Returns the coefficient of normal damping (force divided by normal velocity) at overlap delta >=
 * 0. */
LANE_INLINE LANE(real) LANE(law_damping)(const LANE(contact_constants) * k, LANE(real) delta,
                                         const unsigned features) {
  const int mixed = (features & LAW_NORMAL) != 0;
  LANE(real) gamma = mixed ? LANE(linear_damping)(k->gamma_n, k->tsuji, delta) : k->gamma_n;
#define LAW_CASE(number, word, keys, meaning)                                                      \
  if (mixed && number != SD_NORMAL_LINEAR)                                                         \
    gamma = LANE(select)(LANE(equal)(k->normal, LANE(splat)((double)number)),                      \
                         LANE(word##_damping)(k->gamma_n, k->tsuji, delta), gamma);
  NORMAL_LAWS(LAW_CASE)
#undef LAW_CASE
  return gamma;
}

/* Returns the elastic energy of the normal force at overlap delta >= 0. */
LANE_INLINE LANE(real)
    LANE(law_stored)(const LANE(contact_constants) * k, LANE(real) delta, const unsigned features) {
  LANE(real) energy = LANE(linear_stored)(k->k_n, delta);
#define LAW_CASE(number, word, keys, meaning)                                                      \
  if (features & LAW_NORMAL && number != SD_NORMAL_LINEAR)                                         \
    energy = LANE(select)(LANE(equal)(k->normal, LANE(splat)((double)number)),                     \
                          LANE(word##_stored)(k->k_n, delta), energy);
  NORMAL_LAWS(LAW_CASE)
#undef LAW_CASE
  return energy;
}

/* Record of a contact (sd_contact_record), without the accumulated losses. Members from `slid` on
 * are only used with general laws. slid: the contact slid in the previous step. */
#define MEMORY_LANES(name, ...) LANE(real) name;
typedef struct LANE(contact_memory) {
  LANE(real) lambda_ref, ex, ey, force, overlap, zeta, turned;
  LANE(mask) slid;
  SD_CONTACT_MEMORY(MEMORY_LANES)
} LANE(contact_memory);
#undef MEMORY_LANES

/* Masks of the lanes whose contact is closed before the step (before), and after it (now). */
typedef struct LANE(contact_closed) {
  LANE(mask) before, now;
} LANE(contact_closed);

/* Forces and energies of one contact in one step. */
typedef struct LANE(contact_output) {
  LANE(real) fx, fy, tau; /* force on b (a gets the opposite force); tangential force tau */
  /* Energies of this step: losses by viscosity and by sliding, and the nonconservative work of the
   * tangential force in the paper's variant (docs/physics.md, section 3). */
  LANE(real) viscous, friction, work;
  /* elastic energy left in the tangential and rolling springs of a contact that opened */
  LANE(real) dropped;
  /* length by which lambda* was shifted when the contact slid; its sign is opposite to that of
   * tau */
  LANE(real) slip;
  LANE(real) couple; /* torque of rolling resistance on a (b gets the opposite torque) */
  /* energies lost in this step by rolling, and by forming a capillary bridge */
  LANE(real) rolling, bridge;
} LANE(contact_output);

#include "physics/contact/law_bond.h"
#include "physics/contact/law_radius.h"
#include "physics/contact/law_rolling.h"
#include "physics/contact/law_tangential.h"

/* True for contacts that the slow path must handle: the normal has turned by more than
 * CONTACT_REBASE from the reference direction, or the overlap exceeds `limit`. If `limit` is that
 * of the smallest body, the test is also true for some contacts that do not exceed their own limit,
 * but it misses none. */
LANE_INLINE LANE(mask) LANE(contact_is_deep)(const LANE(pair_geometry) * g, LANE(real) limit) {
  return LANE(greater)(g->sine2, LANE(splat)(CONTACT_REBASE * CONTACT_REBASE)) |
         LANE(greater)(g->reach, limit);
}

/* True for contacts that are closed after the step. With cohesion a contact begins when the gap
 * between the surfaces falls below k->begins and ends when it exceeds k->ends; without, it begins
 * and ends at zero overlap. A bond keeps it closed. m: record after bond_step. */
LANE_INLINE LANE(mask)
    LANE(contact_touches)(const LANE(pair_geometry) * g, const LANE(contact_constants) * k,
                          const LANE(contact_memory) * m, LANE(mask) was_closed,
                          const unsigned features) {
  LANE(real) gap = LANE(splat)(0.0);
  if (features & LAW_COHESION) gap = LANE(select)(was_closed, k->ends, k->begins);
  LANE(mask) touches = LANE(greater)(g->reach, -gap);
  if (features & LAW_BOND) touches = touches | LANE(greater)(m->bond, LANE(splat)(0.0));
  return touches;
}

/* False if the two centres coincide: there is then no normal, and the pair is treated as open. */
LANE_INLINE LANE(mask) LANE(has_direction)(const LANE(pair_geometry) * g) {
  const LANE(real) zero = LANE(splat)(0.0);
  return LANE(not )(LANE(equal)(g->nx, zero) & LANE(equal)(g->ny, zero));
}

/* Returns the potential energy of the normal force: the elastic energy plus that of the attraction.
 * reach: overlap, negative for a gap. */
LANE_INLINE LANE(real) LANE(normal_energy)(const LANE(contact_constants) * k, LANE(real) reach,
                                           const unsigned features) {
  const LANE(cohesion) attraction = LANE(cohesion_of)(k);
  return LANE(law_stored)(k, LANE(max)(reach, LANE(splat)(0.0)), features) +
         LANE(cohesion_energy)(&attraction, reach);
}

/* Computes the normal force of contacts, some of which may be held at a gap by cohesion or a bond.
 * Updates m->force, m->pull and m->overlap, and sets out->viscous. *limit: set to the force that
 * limits friction and rolling: the normal force without attraction, at least 0. If the overlap of a
 * closed contact changes sign within the step, the trapezoidal work is inexact; its difference from
 * the change of the stored energy is counted as viscous loss. */
LANE_INLINE void LANE(normal_history)(const LANE(pair_geometry) * g,
                                      const LANE(contact_constants) * k, LANE(mask) touching,
                                      LANE(mask) closed, const unsigned features,
                                      LANE(contact_memory) * m, LANE(contact_output) * out,
                                      LANE(real) * limit) {
  const LANE(real) zero = LANE(splat)(0.0), half = LANE(splat)(0.5);
  const LANE(real) was = m->overlap, now = LANE(mask_zero)(touching, g->reach), way = now - was;
  const LANE(real) was_deep = LANE(max)(was, zero), delta = LANE(max)(now, zero);
  const LANE(mask) deep = LANE(greater)(delta, zero);
  LANE(real) elastic = LANE(law_elastic)(k, delta, features);
  LANE(real) push = elastic - LANE(law_damping)(k, delta, features) * g->approach;
  LANE(real) pushes = LANE(max)(push, zero);
  if (features & LAW_PULLS)
    push = LANE(select)(LANE(greater)(k->pulls, zero), push, pushes);
  else
    push = pushes;
  push = LANE(mask_zero)(deep, push);
  *limit = LANE(mask_zero)(deep, pushes);
  LANE(real) pull = zero;
  const LANE(cohesion) attraction = LANE(cohesion_of)(k);
  if (features & LAW_COHESION)
    pull =
        LANE(mask_zero)(touching, k->pull_off * LANE(cohesion_part)(&attraction, g->reach,
                                                                    (features & LAW_BRIDGE) != 0));
  LANE(real) before_damping = m->force - LANE(law_elastic)(k, was_deep, features);
  if (features & LAW_COHESION) before_damping = before_damping + m->pull;
  out->viscous = half * (before_damping + (push - elastic)) * way;
  if (features & LAW_GAP) {
    const LANE(mask) crossed = closed & (LANE(greater)(was, zero) ^ deep);
    if (__builtin_expect(LANE(any)(crossed), 0))
      out->viscous = LANE(select)(
          crossed,
          half * (m->force + (push - pull)) * way -
              (LANE(normal_energy)(k, now, features) - LANE(normal_energy)(k, was, features)),
          out->viscous);
  }
  m->force = push - pull;
  m->pull = pull;
  m->overlap = now;
}

/* Advances the history of contacts by one step, for laws with any of the features. Arguments are as
 * in contact_history. */
LANE_INLINE void LANE(general_history)(const LANE(pair_geometry) * g,
                                       const LANE(contact_constants) * k, LANE(mask) touching,
                                       LANE(mask) closed, const int paper, const unsigned features,
                                       LANE(contact_memory) * m, LANE(contact_output) * out) {
  const LANE(real) zero = LANE(splat)(0.0), half = LANE(splat)(0.5);
  const LANE(real) torn = paper ? m->tau * m->overlap : zero;
  LANE(real) limit, was = m->overlap, now;
  LANE(normal_history)(g, k, touching, closed, features, m, out, &limit);
  if (features & LAW_BOND) limit = LANE(select)(LANE(bond_is_alone)(k, m), zero, limit);
  now = m->overlap;
  m->overlap = was;
  LANE(tangential_history)(g, k, touching, LANE(max)(now, zero), limit, features, m, out);
  m->overlap = now;
  out->work = paper ? half * (torn + m->tau * m->overlap) * (g->turned - m->turned) : zero;
  m->turned = paper ? g->turned : zero;
  /* surfaces at a gap do not slide, so the next step uses the static mu, not mu_kinetic */
  if (features & LAW_GAP) out->slip = LANE(mask_zero)(LANE(greater)(now, zero), out->slip);
  if (features & LAW_BOND) out->slip = LANE(select)(LANE(bond_is_alone)(k, m), zero, out->slip);
  if (!(features & LAW_ROLLING)) return;
  LANE(rolling_history)(g, k, touching, limit, m, out);
  out->couple = m->roll * g->arm;
}

/* Advances the history of contacts by one step: updates the record *m and sets all members of *out
 * except fx, fy, tau and dropped. touching: lanes whose contact is closed after the step; records
 * of new contacts must have been initialised by contact_begin. closed: those of these lanes whose
 * contact was closed before, too. paper: not 0 for the paper's tangential force, which is tau
 * instead of tau (R_a + R_b)/r. */
LANE_INLINE void LANE(contact_history)(const LANE(pair_geometry) * g,
                                       const LANE(contact_constants) * k, LANE(mask) touching,
                                       LANE(mask) closed, const int paper, const unsigned features,
                                       LANE(contact_memory) * m, LANE(contact_output) * out) {
  const LANE(real) zero = LANE(splat)(0.0), half = LANE(splat)(0.5);
  out->couple = out->rolling = out->bridge = zero;
  if (features & LAW_GENERAL) {
    LANE(general_history)(g, k, touching, closed, paper, features, m, out);
    return;
  }
  const LANE(real) before_damping = m->force - LANE(law_elastic)(k, m->overlap, features);

  /* normal force, at least 0 */
  LANE(real)
  delta = LANE(mask_zero)(touching, g->reach), elastic = LANE(law_elastic)(k, delta, features);
  LANE(real)
  force = LANE(mask_zero)(
      touching, LANE(max)(elastic - LANE(law_damping)(k, delta, features) * g->approach, zero));

  /* tangential displacement zeta, limited to the range from -mu F_n/k_t to mu F_n/k_t (Amontons'
   * law) */
  LANE(real) zeta = LANE(mask_zero)(touching, g->lambda - m->lambda_ref), cap = k->cap * force;
  LANE(real) capped = LANE(max)(LANE(min)(zeta, cap), -cap), slip = zeta - capped;

  LANE(real) damping = force - elastic, torn = m->zeta * m->overlap + capped * delta;
  out->viscous = half * (before_damping + damping) * (delta - m->overlap);
  out->friction = k->half_k_t * (m->zeta + capped) * slip;
  out->work = paper ? k->half_k_t * torn * (m->turned - g->turned) : zero;
  out->slip = slip;

  m->lambda_ref = m->lambda_ref + slip;
  m->force = force;
  m->overlap = delta;
  m->zeta = capped;
  m->turned = paper ? g->turned : zero;
}

/* Sets the force on b in *out to F_n n - lever tau t, with t = (-n_y, n_x), and sets tau. lever:
 * (R_a + R_b)/r, or 1 in the paper's variant (docs/physics.md, section 3). */
LANE_INLINE void LANE(contact_force)(const LANE(pair_geometry) * g,
                                     const LANE(contact_constants) * k, LANE(real) lever,
                                     const unsigned features, const LANE(contact_memory) * m,
                                     LANE(contact_output) * out) {
  LANE(real) tau = features & LAW_GENERAL ? m->tau : -(k->k_t * m->zeta), push = tau * lever;
  out->fx = m->force * g->nx + push * g->ny;
  out->fy = m->force * g->ny - push * g->nx;
  out->tau = tau;
}

/* Advances the history of contacts by one step and computes their forces. (pair_pass.h calls the
 * two functions itself, with other work between them.) */
LANE_INLINE void LANE(contact_step)(const LANE(pair_geometry) * g,
                                    const LANE(contact_constants) * k, LANE(mask) touching,
                                    LANE(mask) closed, LANE(real) lever, const int paper,
                                    const unsigned features, LANE(contact_memory) * m,
                                    LANE(contact_output) * out) {
  LANE(contact_history)(g, k, touching, closed, paper, features, m, out);
  LANE(contact_force)(g, k, lever, features, m, out);
}

/* --- contacts that begin and end -------------------------------------------------------------- */

/* Returns the time since the surfaces touched, delta/(-u_n), at most dt. The result is 0 if they
 * cannot have touched within this step, as at the start of a run, and if attraction closes the
 * contact at a gap. */
LANE_INLINE LANE(real) LANE(since_touch)(const LANE(pair_geometry) * g, LANE(real) dt) {
  const LANE(real) zero = LANE(splat)(0.0), closing = -g->approach;
  const LANE(real) since = LANE(max)(g->reach, zero) / LANE(max)(closing, LANE(splat)(1e-290));
  const LANE(mask) within = LANE(greater)(closing, zero) & LANE(greater)(2.0 * dt, since);
  return LANE(mask_zero)(within, LANE(min)(since, dt));
}

/* True for contacts that begin in this step, and for contacts that were closed at a gap by the
 * attraction of their law or a bond and whose surfaces touch in this step. before: record before
 * the step. */
LANE_INLINE LANE(mask)
    LANE(surfaces_meet)(const LANE(pair_geometry) * g, const LANE(contact_constants) * k,
                        const LANE(contact_memory) * before, LANE(mask) touching,
                        LANE(mask) was_closed, const unsigned features) {
  const LANE(mask) begun = touching & LANE(not )(was_closed);
  if (!(features & LAW_GAP)) return begun;
  const LANE(real) zero = LANE(splat)(0.0);
  LANE(mask)
  met = touching & was_closed & LANE(not )(LANE(greater)(before->overlap, zero)) &
        LANE(greater)(g->reach, zero);
  if (!(features & LAW_BOND)) met = met & LANE(greater)(k->ends, zero);
  return begun | met;
}

/* Initialises the contacts whose surfaces touch in this step (mask `meet`); call it before
 * contact_step. lambda* and rho* are set to lambda and rho at the moment of touch, extrapolated
 * back with the present velocities (docs/physics.md, section 3). With lambda and rho at the end of
 * the step, the displacement since that moment would be lost. With Mindlin's law the stiffness K
 * has grown in proportion to sqrt(t) since then, so sqrt(K) zeta should be 4/5 of sqrt(K) times the
 * displacement; the trapezoidal rule gives 1/2, hence the factor 1.6. */
LANE_INLINE void LANE(contact_begin)(const LANE(pair_geometry) * g,
                                     const LANE(contact_constants) * k, LANE(mask) meet,
                                     LANE(real) dt, const unsigned features,
                                     LANE(contact_memory) * m) {
  const LANE(real) since = LANE(since_touch)(g, dt);
  LANE(real) way = g->slide * since;
  if (features & LAW_MINDLIN)
    way = LANE(select)(LANE(greater)(k->mindlin, LANE(splat)(0.0)), 1.6 * way, way);
  m->lambda_ref = LANE(select)(meet, g->lambda - way, m->lambda_ref);
  if (features & LAW_ROLLING)
    m->rho_ref = LANE(select)(meet, g->rho - g->rolls * since, m->rho_ref);
}

/* Tangential or rolling spring and its dashpot, in the first or last step of a contact. */
typedef struct LANE(edge_spring) {
  /* q: displacement of the spring; force: total force, -(stiffness q + dashpot force). Both are
   * values after the step if the contact begins, before it if the contact ends. */
  LANE(real) stiffness, q, force;
  LANE(real) way; /* relative displacement of the surfaces in the whole step */
} LANE(edge_spring);

/* Computes the losses of a spring and its dashpot in the first or last step of a contact. The
 * trapezoidal work is that of the whole step, though the contact was closed for only a part of it.
 * *sliding: set to the part of this work that the spring does not store, which counts as sliding
 * loss; most of it is compensated between the first and the last step of the contact. Returns the
 * loss of the dashpot. */
LANE_INLINE LANE(real)
    LANE(edge_losses)(const LANE(edge_spring) * s, LANE(mask) begun, LANE(real) * sliding) {
  const LANE(real) half = LANE(splat)(0.5), pull = s->stiffness * s->q;
  *sliding = half * pull * (s->way - LANE(mask_zero)(begun, s->q));
  return -half * (s->force + pull) * s->way;
}

/* Returns the energy stored in the spring, stiffness q^2/2. */
LANE_INLINE LANE(real) LANE(edge_stored)(const LANE(edge_spring) * s) {
  return 0.5 * s->stiffness * s->q * s->q;
}

/* Does the part of contact_begin_end that concerns the tangential and the rolling spring. edge:
 * lanes in which contacts begin or end; begun: those in which they begin. In lanes `edge` the
 * losses of the dashpots are added to out->viscous, and out->friction and out->rolling are
 * replaced. out->dropped is set to the energy in the springs. */
LANE_INLINE void LANE(springs_begin_end)(const LANE(pair_geometry) * g,
                                         const LANE(contact_constants) * k, LANE(mask) begun,
                                         LANE(mask) edge, LANE(real) dt, const unsigned features,
                                         const LANE(contact_memory) * before,
                                         const LANE(contact_memory) * m,
                                         LANE(contact_output) * out) {
  const LANE(real) k_t = k->half_k_t + k->half_k_t;
  LANE(edge_spring)
  s = {.stiffness = k_t,
       .q = LANE(select)(begun, m->zeta, before->zeta),
       .way = LANE(select)(begun, g->slide * dt, g->lambda - before->lambda_ref - before->zeta)};
  LANE(real) sliding;
  if (features & LAW_MINDLIN) {
    const LANE(real) deep =
        LANE(max)(LANE(select)(begun, m->overlap, before->overlap), LANE(splat)(0.0));
    s.stiffness =
        LANE(select)(LANE(greater)(k->mindlin, LANE(splat)(0.0)), k_t * LANE(sqrt)(deep), k_t);
  }
  s.force =
      features & LAW_GENERAL ? LANE(select)(begun, m->tau, before->tau) : -(s.stiffness * s.q);
  out->viscous = out->viscous + LANE(mask_zero)(edge, LANE(edge_losses)(&s, begun, &sliding));
  out->friction = LANE(select)(edge, sliding, out->friction);
  out->dropped = LANE(edge_stored)(&s);
  if (!(features & LAW_ROLLING)) return;
  s = (LANE(edge_spring)){
      .stiffness = k->k_r,
      .q = LANE(select)(begun, m->rho, before->rho),
      .force = LANE(select)(begun, m->roll, before->roll),
      .way = LANE(select)(begun, g->rolls * dt, g->rho - before->rho_ref - before->rho)};
  out->viscous = out->viscous + LANE(mask_zero)(edge, LANE(edge_losses)(&s, begun, &sliding));
  out->rolling = LANE(select)(edge, sliding, out->rolling);
  out->dropped = out->dropped + LANE(edge_stored)(&s);
}

/* Completes a step in which contacts begin or end. before: record before the step;
 * half_relative_acceleration: dt^2/2 times the acceleration of b relative to a along the normal
 * before the step, so that the surfaces approach by half_relative_acceleration - u_n dt in this
 * step.
 *
 * The first force of a contact is taken to act over the whole approach in its step, not only
 * over the part in which the disks overlap, and so is the last force. The errors of the losses
 * in these two steps compensate each other, so that the energy budget of elastic contacts does
 * not drift. out->dropped is set to the energy left in the springs of a contact that opens. */
LANE_INLINE void LANE(contact_begin_end)(const LANE(pair_geometry) * g,
                                         const LANE(contact_constants) * k, LANE(mask) touching,
                                         LANE(mask) was_closed, LANE(real) dt,
                                         LANE(real) half_relative_acceleration,
                                         const unsigned features,
                                         const LANE(contact_memory) * before,
                                         LANE(contact_memory) * m, LANE(contact_output) * out) {
  const LANE(mask) opened = was_closed & LANE(not )(touching),
                   begun = LANE(not )(was_closed) & touching;
  const LANE(mask) meet = LANE(surfaces_meet)(g, k, before, touching, was_closed, features);
  const LANE(real) half = LANE(splat)(0.5), way = half_relative_acceleration - g->approach * dt;
  const LANE(real) overlap = LANE(select)(begun, m->overlap, before->overlap);
  LANE(real) stored = LANE(law_stored)(k, LANE(max)(overlap, LANE(splat)(0.0)), features);
  if (features & LAW_COHESION) {
    const LANE(cohesion) attraction = LANE(cohesion_of)(k);
    out->bridge = LANE(mask_zero)(begun, LANE(bridge_energy)(&attraction));
    stored = stored + LANE(cohesion_energy)(&attraction, overlap) + out->bridge;
  }
  const LANE(real) done =
      half * LANE(select)(begun, m->force * way, before->force * (before->overlap - g->reach));
  out->viscous =
      LANE(select)(begun, done - stored, LANE(select)(opened, stored - done, out->viscous));
  /* this replaces out->viscous; the losses of the dashpots are added to it below */
  if (features & LAW_GAP) {
    const LANE(real) met = half * (before->force + m->force) * (m->overlap - before->overlap) -
                           (LANE(normal_energy)(k, m->overlap, features) - stored);
    out->viscous = LANE(select)(meet & was_closed, met, out->viscous);
  }
  LANE(springs_begin_end)(g, k, meet, meet | opened, dt, features, before, m, out);
  out->viscous = LANE(mask_zero)(was_closed | touching, out->viscous);
  out->friction = LANE(mask_zero)(was_closed | touching, out->friction);
  out->dropped = LANE(mask_zero)(opened, out->dropped);
  /* in a contact that begins the reference direction is the normal; the record of an open pair is
   * 0 */
  m->lambda_ref = LANE(mask_zero)(touching, m->lambda_ref);
  m->turned = LANE(mask_zero)(touching, m->turned);
  m->ex = LANE(mask_zero)(touching, LANE(select)(begun, g->nx, before->ex));
  m->ey = LANE(mask_zero)(touching, LANE(select)(begun, g->ny, before->ey));
  if (!(features & LAW_GENERAL)) return;
#define MEMORY_MASK(name, ...) m->name = LANE(mask_zero)(touching, m->name);
#define LOSS_MASK(name, ...) out->name = LANE(mask_zero)(was_closed | touching, out->name);
  SD_CONTACT_MEMORY(MEMORY_MASK)
  SD_CONTACT_LOSSES(LOSS_MASK)
#undef MEMORY_MASK
#undef LOSS_MASK
}
