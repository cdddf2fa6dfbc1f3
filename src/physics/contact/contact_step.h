/* contact_step.h: one contact in one step (eqs. 2, 4, tau, 36), branch-free over lanes.
 *
 * Included once per LANE_WIDTH after base/lane.h. Round pairs, wall segments and small systems all
 * use this code; the bits of a lane's result do not depend on LANE_WIDTH.
 *
 *   F_n  = max(F_el(delta) - gamma_n u_n, 0) while delta > 0
 *   zeta = lambda - lambda*; lambda* is shifted so that |zeta| <= mu F_n / k_t
 *   tau  = -k_t zeta
 *
 * Further parts of a law (law_tangential.h, law_rolling.h, model/law_cohesion.h) are evaluated if
 * their bit is set in `features` (model/model.h). In passes over plain laws features is the
 * constant 0; in passes over general laws it is the same number for all pairs.
 *
 * lambda is measured from the contact's reference direction e: lambda = arc - sum * turned, with
 * arc = R_a th_a + R_b th_b and turned = angle from e to n. After a step with |sin(turned)| >
 * CONTACT_REBASE the contact gets a new e, so the terms of the series of asin(e x n) that are used
 * below are exact to rounding.
 *
 * History is committed in the one evaluation whose forces act: with velocity Verlet at the new
 * positions, with Gear at the predicted ones (PEC). The losses of a step are the trapezoidal work
 * between the previous evaluation and this one (docs/physics.md, section 8).
 */
#include "model/law_cohesion.h"
#include "model/normal_laws.h"

#ifndef CONTACT_STEP_COMMON
#include "model/model.h"
#define CONTACT_STEP_COMMON
#define CONTACT_REBASE 0.015625
#define CONTACT_SIGN 0x8000000000000000u
#endif

/* --- geometry --------------------------------------------------------------------------------- */

/* Positions, velocities and angles of a pair of bodies a and b, from which its geometry follows. */
typedef struct LANE(pair_input) {
  LANE(real) dx, dy;   /* vector from a's centre to b's centre or nearest surface point */
  LANE(real) dvx, dvy; /* velocity of that point of b relative to a's centre */
  LANE(real) sum;      /* R_a + R_b; negative inside a round container */
  LANE(real) arc;      /* R_a theta_a + R_b theta_b */
  LANE(real) ex, ey;   /* reference direction of the contact, a unit vector; (0, 0): open */
} LANE(pair_input);

/* First part of a pair's geometry. It is a struct of its own so that other instructions can run
 * while its square root and division are under way. */
typedef struct LANE(pair_distance) {
  LANE(real) dx, dy, sum, arc; /* copies of the members of pair_input */
  LANE(real) dot;              /* scalar product of (dx, dy) and the relative velocity */
  LANE(real) cross;            /* cross product of the reference direction and (dx, dy) */
  LANE(real) r;                /* distance, with the sign of sum */
  LANE(real) inverse_r;        /* 1/r */
  LANE(real) away;  /* nx^2 + ny^2 for image (nx, ny) of b; only set in a box that deforms */
  LANE(real) swing; /* cross product of (dx, dy) and the relative velocity; only for PASS_GENERAL */
} LANE(pair_distance);

/* Geometry and relative motion of a pair of bodies a and b. */
typedef struct LANE(pair_geometry) {
  LANE(real) nx, ny;        /* unit normal, from a towards b's surface */
  LANE(real) reach;         /* overlap, negative for a gap */
  LANE(real) approach;      /* normal relative velocity u_n, positive when the bodies separate */
  LANE(real) arc;           /* R_a theta_a + R_b theta_b */
  LANE(real) lambda;        /* tangential coordinate, measured from the reference direction e */
  LANE(real) turned, sine2; /* angle from e to n in rad, and its squared sine */
  LANE(real) lever;         /* lever of the tangential force, (R_a + R_b)/r */
  LANE(real) slide; /* dlambda/dt; only set for tangential dashpots and when a contact begins */
  /* Rolling displacement R_eff (theta_a - theta_b), its time derivative, and R_eff (arm); only set
   * for laws with rolling resistance. */
  LANE(real) rho, rolls;
  LANE(real) arm;
} LANE(pair_geometry);

/* Computes the part of the geometry up to 1/r. Members are copied one by one, since compilers do
 * poorly with a copy of the whole struct. */
LANE_INLINE void LANE(pair_distance_of)(const LANE(pair_input) * in, LANE(pair_distance) * d) {
  d->dx = in->dx;
  d->dy = in->dy;
  d->sum = in->sum;
  d->arc = in->arc;
  d->dot = in->dvx * in->dx + in->dvy * in->dy;
  d->cross = in->ex * in->dy - in->ey * in->dx;
  /* The lower bound of r^2 keeps results finite for coincident centres. It also turns a pose that
   * is NaN into a contact, so the step in which it appears is examined. */
  LANE(real) r = LANE(sqrt)(LANE(max)(in->dx * in->dx + in->dy * in->dy, LANE(splat)(1e-280)));
  d->r = LANE(as_real)(LANE(as_bits)(r) | (LANE(as_bits)(in->sum) & CONTACT_SIGN));
  d->inverse_r = 1.0 / d->r;
}

/* Completes the geometry from the distance; slide, rho, rolls and arm are left to the caller. */
LANE_INLINE void LANE(pair_geometry_at)(const LANE(pair_distance) * d, LANE(pair_geometry) * g) {
  LANE(real) inverse_r = d->inverse_r;
  g->nx = d->dx * inverse_r;
  g->ny = d->dy * inverse_r;
  g->reach = d->sum - d->r;
  g->approach = d->dot * inverse_r;
  g->lever = d->sum * inverse_r;
  /* angle from the reference direction to n: series of asin(s) */
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

/* Returns the elastic normal force at overlap delta >= 0. Without LAW_NORMAL in `features` all
 * contacts have the linear law, here and in the two functions below. */
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

/* Returns the coefficient of normal damping, force over velocity, at overlap delta >= 0. */
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

/* Returns the elastic energy stored at overlap delta >= 0. */
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

/* Record of a contact (sd_contact_record) without the accumulated losses. slid: the contact slid in
 * the previous step; the second and third line are only used with general laws. */
typedef struct LANE(contact_memory) {
  LANE(real) lambda_ref, ex, ey, force, overlap, zeta, turned;
  LANE(real) tau, pull, rho_ref, rho, roll;
  LANE(mask) slid;
} LANE(contact_memory);

/* Lanes whose contact is closed before the step, and after it. */
typedef struct LANE(contact_closed) {
  LANE(mask) before, now;
} LANE(contact_closed);

/* Results of one step of a contact. */
typedef struct LANE(contact_output) {
  LANE(real) fx, fy, tau; /* force on b (a gets the opposite); tangential force tau */
  /* Energies of the step: losses by viscosity and by sliding, and the nonconservative work that the
   * paper's tangential force puts in. */
  LANE(real) viscous, friction, work;
  LANE(real) dropped; /* energy left in the springs of a contact that opened */
  LANE(real) slip;    /* length by which lambda* was shifted; its sign is opposite to tau's */
  LANE(real) couple;  /* torque of rolling resistance on a (b gets the opposite) */
  LANE(real) rolling, bridge; /* energies lost in the step by rolling and by forming a bridge */
} LANE(contact_output);

#include "physics/contact/law_rolling.h"
#include "physics/contact/law_tangential.h"

/* True for contacts that the slow path must handle: the normal has turned by more than
 * CONTACT_REBASE from the reference direction, or the overlap exceeds `limit`. With the limit of
 * the smallest body the test is conservative: it flags a superset of the contacts that exceed their
 * own limit. */
LANE_INLINE LANE(mask) LANE(contact_is_deep)(const LANE(pair_geometry) * g, LANE(real) limit) {
  return LANE(greater)(g->sine2, LANE(splat)(CONTACT_REBASE * CONTACT_REBASE)) |
         LANE(greater)(g->reach, limit);
}

/* True for contacts that are closed after the step. With cohesion a contact begins and ends at a
 * gap between the surfaces, `begins` and `ends`; else at zero overlap. */
LANE_INLINE LANE(mask)
    LANE(contact_touches)(const LANE(pair_geometry) * g, const LANE(contact_constants) * k,
                          LANE(mask) was_closed, const unsigned features) {
  LANE(real) gap = LANE(splat)(0.0);
  if (features & LAW_COHESION) gap = LANE(select)(was_closed, k->ends, k->begins);
  return LANE(greater)(g->reach, -gap);
}

/* False for coincident centres: they define no normal, so the pair is treated as open. */
LANE_INLINE LANE(mask) LANE(has_direction)(const LANE(pair_geometry) * g) {
  const LANE(real) zero = LANE(splat)(0.0);
  return LANE(not )(LANE(equal)(g->nx, zero) & LANE(equal)(g->ny, zero));
}

/* Returns the potential energy of the normal force: elastic energy and energy of the attraction.
 * reach: overlap, negative for a gap. */
LANE_INLINE LANE(real) LANE(normal_energy)(const LANE(contact_constants) * k, LANE(real) reach,
                                           const unsigned features) {
  const LANE(cohesion) attraction = LANE(cohesion_of)(k);
  return LANE(law_stored)(k, LANE(max)(reach, LANE(splat)(0.0)), features) +
         LANE(cohesion_energy)(&attraction, reach);
}

/* Computes the normal force of contacts, some of which may be held at a gap by cohesion: updates
 * m->force, m->pull and m->overlap, and sets out->viscous. *limit: the force that friction is
 * limited by, that is the normal force without attraction, at least 0. If the overlap of a closed
 * contact changes sign within the step, the trapezoidal work is inexact; its difference from the
 * change of stored energy is booked as a loss. */
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
  if (features & LAW_COHESION) {
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

/* Advances the history of contacts by one step, with any features of the law. Arguments as in
 * contact_history. */
LANE_INLINE void LANE(general_history)(const LANE(pair_geometry) * g,
                                       const LANE(contact_constants) * k, LANE(mask) touching,
                                       LANE(mask) closed, const int paper, const unsigned features,
                                       LANE(contact_memory) * m, LANE(contact_output) * out) {
  const LANE(real) zero = LANE(splat)(0.0), half = LANE(splat)(0.5);
  const LANE(real) torn = paper ? m->tau * m->overlap : zero;
  LANE(real) limit, was = m->overlap, now;
  LANE(normal_history)(g, k, touching, closed, features, m, out, &limit);
  now = m->overlap;
  m->overlap = was;
  LANE(tangential_history)(g, k, touching, LANE(max)(now, zero), limit, features, m, out);
  m->overlap = now;
  out->work = paper ? half * (torn + m->tau * m->overlap) * (g->turned - m->turned) : zero;
  m->turned = paper ? g->turned : zero;
  /* surfaces at a gap do not slide: mu, not mu_kinetic, holds in the next step */
  if (features & LAW_COHESION) out->slip = LANE(mask_zero)(LANE(greater)(now, zero), out->slip);
  if (!(features & LAW_ROLLING)) return;
  LANE(rolling_history)(g, k, touching, limit, m, out);
  out->couple = m->roll * g->arm;
}

/* Advances the history of contacts by one step: updates the record *m and sets all of *out except
 * fx, fy, tau and dropped. touching: contacts closed after the step, including those that
 * contact_begin has initialised; closed: those of them that were closed before, too. paper: not 0
 * for the paper's tangential force, tau instead of tau (R_a + R_b)/r. */
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

  /* tangential displacement zeta, limited to +-mu F_n/k_t (Amontons' law) */
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

/* Sets the force on b, F_n n - lever tau t with t = (-n_y, n_x), and tau in *out. lever:
 * (R_a + R_b)/r, or 1 with the paper's force. */
LANE_INLINE void LANE(contact_force)(const LANE(pair_geometry) * g,
                                     const LANE(contact_constants) * k, LANE(real) lever,
                                     const unsigned features, const LANE(contact_memory) * m,
                                     LANE(contact_output) * out) {
  LANE(real) tau = features & LAW_GENERAL ? m->tau : -(k->k_t * m->zeta), push = tau * lever;
  out->fx = m->force * g->nx + push * g->ny;
  out->fy = m->force * g->ny - push * g->nx;
  out->tau = tau;
}

/* Advances the history of contacts by one step and computes their forces. (The pass over round
 * pairs calls the two functions itself, to do other work between them.) */
LANE_INLINE void LANE(contact_step)(const LANE(pair_geometry) * g,
                                    const LANE(contact_constants) * k, LANE(mask) touching,
                                    LANE(mask) closed, LANE(real) lever, const int paper,
                                    const unsigned features, LANE(contact_memory) * m,
                                    LANE(contact_output) * out) {
  LANE(contact_history)(g, k, touching, closed, paper, features, m, out);
  LANE(contact_force)(g, k, lever, features, m, out);
}

/* --- contacts that begin and end -------------------------------------------------------------- */

/* Returns the time since the surfaces touched, delta/(-u_n), at most dt. Returns 0 if they cannot
 * have touched within this step, as at the start of a run, or if attraction closes the contact at a
 * gap. */
LANE_INLINE LANE(real) LANE(since_touch)(const LANE(pair_geometry) * g, LANE(real) dt) {
  const LANE(real) zero = LANE(splat)(0.0), closing = -g->approach;
  const LANE(real) since = LANE(max)(g->reach, zero) / LANE(max)(closing, LANE(splat)(1e-290));
  const LANE(mask) within = LANE(greater)(closing, zero) & LANE(greater)(2.0 * dt, since);
  return LANE(mask_zero)(within, LANE(min)(since, dt));
}

/* True for contacts that begin in this step, and for those that attraction had closed at a gap and
 * whose surfaces touch in this step. was: overlap before the step. */
LANE_INLINE LANE(mask)
    LANE(surfaces_meet)(const LANE(pair_geometry) * g, LANE(real) was, LANE(mask) touching,
                        LANE(mask) was_closed, const unsigned features) {
  const LANE(mask) begun = touching & LANE(not )(was_closed);
  if (!(features & LAW_COHESION)) return begun;
  const LANE(real) zero = LANE(splat)(0.0);
  return begun | (touching & was_closed & LANE(not )(LANE(greater)(was, zero)) &
                  LANE(greater)(g->reach, zero));
}

/* Initialises contacts whose surfaces touch in this step (`meet`), before contact_step. lambda* and
 * rho* are set to lambda and rho at the moment of touch, extrapolated back with the present
 * velocities (docs/physics.md, section 3): their values at the end of the step would omit the
 * displacement since then. With Mindlin's law the stiffness has grown in proportion to sqrt(t)
 * since the touch, so sqrt(K) zeta should be 4/5 of sqrt(K) times the displacement; the trapezoid
 * gives 1/2, hence the factor 1.6. */
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

/* Tangential or rolling spring with its dashpot, in the step in which the contact begins or
 * ends. */
typedef struct LANE(edge_spring) {
  /* q: displacement of the spring; force = -(stiffness q + dashpot force). Both are taken after the
   * step if the contact begins, before it if the contact ends. */
  LANE(real) stiffness, q, force;
  LANE(real) way; /* relative displacement of the surfaces in the whole step */
} LANE(edge_spring);

/* Computes the losses of a spring and its dashpot in the first or last step of a contact. The
 * trapezoidal work covers the whole step, though the contact was closed for part of it only. The
 * part of this work that the spring does not store is booked as sliding loss (*sliding); most of it
 * is balanced at the other end of the contact. Returns the loss of the dashpot. */
LANE_INLINE LANE(real)
    LANE(edge_losses)(const LANE(edge_spring) * s, LANE(mask) begun, LANE(real) * sliding) {
  const LANE(real) half = LANE(splat)(0.5), pull = s->stiffness * s->q;
  *sliding = half * pull * (s->way - LANE(mask_zero)(begun, s->q));
  return -half * (s->force + pull) * s->way;
}

/* Returns the energy stored in the spring. */
LANE_INLINE LANE(real) LANE(edge_stored)(const LANE(edge_spring) * s) {
  return 0.5 * s->stiffness * s->q * s->q;
}

/* Part of contact_begin_end for the tangential and the rolling spring: in lanes `edge`, whose
 * contacts begin (`begun`) or end, adds the losses of the dashpots to out->viscous and replaces
 * out->friction and out->rolling. Sets out->dropped to the energy left in the springs. */
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

/* Completes a step in which contacts begin or end. before: record before the step; bent: dt^2/2
 * times the relative acceleration of the centres along n before the step, so the surfaces approach
 * by bent - u_n dt in this step.
 *
 * The first force of a contact works over the whole approach in its step, not only over the part in
 * which the disks overlap; so does its last force. The losses booked for the two steps balance each
 * other, so the energy budget of elastic contacts does not drift. The energy left in the springs of
 * a contact that opens is returned in out->dropped. */
LANE_INLINE void LANE(contact_begin_end)(const LANE(pair_geometry) * g,
                                         const LANE(contact_constants) * k, LANE(mask) touching,
                                         LANE(mask) was_closed, LANE(real) dt, LANE(real) bent,
                                         const unsigned features,
                                         const LANE(contact_memory) * before,
                                         LANE(contact_memory) * m, LANE(contact_output) * out) {
  const LANE(mask) opened = was_closed & LANE(not )(touching),
                   begun = LANE(not )(was_closed) & touching;
  const LANE(mask) meet = LANE(surfaces_meet)(g, before->overlap, touching, was_closed, features);
  const LANE(real) half = LANE(splat)(0.5), way = bent - g->approach * dt;
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
  /* replaces out->viscous, to which the dashpots' losses have not been added yet */
  if (features & LAW_COHESION) {
    const LANE(real) met = half * (before->force + m->force) * (m->overlap - before->overlap) -
                           (LANE(normal_energy)(k, m->overlap, features) - stored);
    out->viscous = LANE(select)(meet & was_closed, met, out->viscous);
  }
  LANE(springs_begin_end)(g, k, meet, meet | opened, dt, features, before, m, out);
  out->viscous = LANE(mask_zero)(was_closed | touching, out->viscous);
  out->friction = LANE(mask_zero)(was_closed | touching, out->friction);
  out->dropped = LANE(mask_zero)(opened, out->dropped);
  /* e = n in contacts that begin; all history is 0 in open ones */
  m->lambda_ref = LANE(mask_zero)(touching, m->lambda_ref);
  m->turned = LANE(mask_zero)(touching, m->turned);
  m->ex = LANE(mask_zero)(touching, LANE(select)(begun, g->nx, before->ex));
  m->ey = LANE(mask_zero)(touching, LANE(select)(begun, g->ny, before->ey));
  if (!(features & LAW_GENERAL)) return;
  out->rolling = LANE(mask_zero)(was_closed | touching, out->rolling);
  m->rho_ref = LANE(mask_zero)(touching, m->rho_ref);
  m->tau = LANE(mask_zero)(touching, m->tau);
  m->pull = LANE(mask_zero)(touching, m->pull);
  m->rho = LANE(mask_zero)(touching, m->rho);
  m->roll = LANE(mask_zero)(touching, m->roll);
}
