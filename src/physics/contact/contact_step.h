/* contact_step.h: one contact in one step (eqs. 2, 4, tau, 36), branch-free over lanes.
 *
 * Included once per LANE_WIDTH after base/lane.h. Round pairs, wall segments and small systems call the same text; a
 * lane's bits do not depend on the width.
 *
 *   F_n  = max(F_el(delta) - gamma_n u_n, 0) while delta > 0
 *   zeta = lambda - lambda*, |zeta| <= mu F_n / k_t by shifting lambda*
 *   tau  = -k_t zeta
 *
 * The rest of other laws is written where `features` (model/laws.h) ask for it: law_tangential.h, law_rolling.h,
 * model/law_cohesion.h. In plain passes they are a constant 0, in general ones the same number for all pairs.
 *
 * lambda is measured from the contact's reference direction e: lambda = arc - sum * turned, arc = R_a th_a +
 * R_b th_b, turned = angle from e to n. The contact is re-based after a step in which |sin(turned)| exceeds
 * CONTACT_REBASE, so that three terms of the series of asin(e x n) are exact to rounding.
 *
 * History is committed in the one evaluation whose forces act: with velocity Verlet at the new positions, with Gear at the
 * predicted ones (PEC). The losses of a step are the trapezoid between the evaluation before and this one (physics.md 8).
 */
#include "model/law_cohesion.h"
#include "model/normal_laws.h"

#ifndef CONTACT_STEP_COMMON
#include "model/law_features.h"
#define CONTACT_STEP_COMMON
#define CONTACT_REBASE 0.015625
#define CONTACT_SIGN 0x8000000000000000u
#endif

/* --- geometry -------------------------------------------------------------------------------------------- */

/* Of two bodies, a and b. */
typedef struct LANE(pair_input) {
  LANE(real) dx, dy;   /* from a to b */
  LANE(real) dvx, dvy; /* velocity of b's surface point relative to a's centre */
  LANE(real) sum;      /* R_a + R_b; negative inside a round container */
  LANE(real) arc;      /* R_a th_a + R_b th_b */
  LANE(real) ex, ey;   /* reference direction, (0, 0) when open */
} LANE(pair_input);

/* The root and the division are under way while something else is worked out. */
typedef struct LANE(pair_distance) {
  LANE(real) dx, dy, sum, arc;
  LANE(real) dot;   /* of distance and relative velocity */
  LANE(real) cross; /* of reference direction and distance */
  LANE(real) r;     /* distance, with the sign of sum */
  LANE(real) inverse_r;
  LANE(real) away;  /* cells between, squared; of a box that deforms */
  LANE(real) swing; /* distance x relative velocity; of general passes */
} LANE(pair_distance);

typedef struct LANE(pair_geometry) {
  LANE(real) nx, ny;        /* from a to b's surface */
  LANE(real) reach;         /* overlap, negative where there is a gap */
  LANE(real) approach;      /* u_n, separation positive */
  LANE(real) arc;           /* R_a th_a + R_b th_b */
  LANE(real) lambda;        /* from the reference direction */
  LANE(real) turned, sine2; /* angle from e to n, its squared sine */
  LANE(real) lever;         /* (R_a + R_b)/r */
  LANE(real) slide;         /* dlambda/dt; where dashpots want it, or a contact begins */
  LANE(real)
  rho, rolls; /* R_eff (theta_a - theta_b), its derivative, R_eff: where rolling wants it */
  LANE(real) arm;
} LANE(pair_geometry);

/* Field by field: compilers take copies of the whole apart. */
LANE_INLINE void LANE(pair_distance_of)(const LANE(pair_input) * in, LANE(pair_distance) * d) {
  d->dx = in->dx;
  d->dy = in->dy;
  d->sum = in->sum;
  d->arc = in->arc;
  d->dot = in->dvx * in->dx + in->dvy * in->dy;
  d->cross = in->ex * in->dy - in->ey * in->dx;
  /* The floor under r^2 keeps coincident centres finite; it also turns a pose that is not a number into a contact, so
   * that the step in which it appears is examined. */
  LANE(real) r = LANE(sqrt)(LANE(max)(in->dx * in->dx + in->dy * in->dy, LANE(splat)(1e-280)));
  d->r = LANE(as_real)(LANE(as_bits)(r) | (LANE(as_bits)(in->sum) & CONTACT_SIGN));
  d->inverse_r = 1.0 / d->r;
}

LANE_INLINE void LANE(pair_geometry_at)(const LANE(pair_distance) * d, LANE(pair_geometry) * g) {
  LANE(real) inverse_r = d->inverse_r;
  g->nx = d->dx * inverse_r;
  g->ny = d->dy * inverse_r;
  g->reach = d->sum - d->r;
  g->approach = d->dot * inverse_r;
  g->lever = d->sum * inverse_r;
  /* angle since the reference direction: asin series */
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

/* --- step of a contact ----------------------------------------------------------------------------------- */

typedef struct LANE(contact_constants) {
  LANE(real) k_n, k_t, half_k_t, gamma_n, cap; /* cap: mu/k_t, 0 where k_t is: frictionless */
  LANE(real) normal, tsuji;             /* law's number, law_tsuji sqrt(m_eff k_n): LAW_NORMAL */
  LANE(mask) pulls;                     /* LAW_PULLS */
  LANE(real) cap_kinetic, mindlin, lag; /* LAW_TANGENTIAL; as in law_row */
  LANE(real) k_r, cap_r, lag_r;         /* LAW_ROLLING */
  LANE(cohesion) cohesion;              /* LAW_COHESION */
} LANE(contact_constants);

/* Elastic force, the coefficient of damping, and stored energy, at overlap delta. Without LAW_NORMAL all contacts have the
 * linear law. */
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

/* Record of a contact (sd_contact_record) without its sums; general: slid, in the step before. */
typedef struct LANE(contact_memory) {
  LANE(real) lambda_ref, ex, ey, force, overlap, zeta, turned;
  LANE(real) tau, pull, rho_ref, rho, roll;
  LANE(mask) slid;
} LANE(contact_memory);

/* Masks before the step, and after it. */
typedef struct LANE(contact_closed) {
  LANE(mask) before, now;
} LANE(contact_closed);

/* The step of a contact: force on b (on a the opposite) and tau, which turns both; losses; rare events. */
typedef struct LANE(contact_output) {
  LANE(real) fx, fy, tau;
  LANE(real)
  viscous, friction,
      work;           /* losses of the step; work of the paper's force beyond that of a potential */
  LANE(real) dropped; /* energy left in contacts that opened */
  LANE(real) slip;    /* length by which lambda* was shifted; its sign is opposite to tau's */
  LANE(real) couple;  /* on a, the opposite on b */
  LANE(real) rolling, bridge; /* losses of the step */
} LANE(contact_output);

#include "physics/contact/law_rolling.h"
#include "physics/contact/law_tangential.h"

/* Contacts in which more happens than sliding: they begin or end, have turned far, or overlap beyond limit. A limit of the
 * smallest body flags more of them than there are. */
LANE_INLINE LANE(mask) LANE(contact_is_deep)(const LANE(pair_geometry) * g, LANE(real) limit) {
  return LANE(greater)(g->sine2, LANE(splat)(CONTACT_REBASE * CONTACT_REBASE)) |
         LANE(greater)(g->reach, limit);
}

/* Contacts that are closed after the step: attraction begins and ends them beyond touch. */
LANE_INLINE LANE(mask)
    LANE(contact_touches)(const LANE(pair_geometry) * g, const LANE(contact_constants) * k,
                          LANE(mask) was_closed, const unsigned features) {
  LANE(real) gap = LANE(splat)(0.0);
  if (features & LAW_COHESION) gap = LANE(select)(was_closed, k->cohesion.ends, k->cohesion.begins);
  return LANE(greater)(g->reach, -gap);
}

/* Coincident centres have no direction, and do not touch. */
LANE_INLINE LANE(mask) LANE(has_direction)(const LANE(pair_geometry) * g) {
  const LANE(real) zero = LANE(splat)(0.0);
  return LANE(not )(LANE(equal)(g->nx, zero) & LANE(equal)(g->ny, zero));
}

/* Energy of what acts along the normal. */
LANE_INLINE LANE(real) LANE(normal_energy)(const LANE(contact_constants) * k, LANE(real) reach,
                                           const unsigned features) {
  return LANE(law_stored)(k, LANE(max)(reach, LANE(splat)(0.0)), features) +
         LANE(cohesion_energy)(&k->cohesion, reach);
}

/* Normal force of contacts of which some may be apart; limit: without attraction, if it pushes. Where a step takes surfaces
 * together or apart the trapezoid is no work of a smooth force: what it gives beyond the stored energy is booked as lost. */
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
    push = LANE(select)(k->pulls, push, pushes);
  else
    push = pushes;
  push = LANE(mask_zero)(deep, push);
  *limit = LANE(mask_zero)(deep, pushes);
  LANE(real) pull = zero;
  if (features & LAW_COHESION)
    pull = LANE(mask_zero)(
        touching, k->cohesion.pull_off *
                      LANE(cohesion_part)(&k->cohesion, g->reach, (features & LAW_BRIDGE) != 0));
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

/* History of a step with any features. */
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
  /* at a gap nothing slides: what has slid is for surfaces that touch (mu_kinetic) */
  if (features & LAW_COHESION) out->slip = LANE(mask_zero)(LANE(greater)(now, zero), out->slip);
  if (!(features & LAW_ROLLING)) return;
  LANE(rolling_history)(g, k, touching, limit, m, out);
  out->couple = m->roll * g->arm;
}

/* History of a step. touching: contacts with a memory, also those that contact_begin has given one; closed: these without
 * those. paper: the paper's tangential force, tau instead of tau (R_a + R_b)/r. */
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

  /* normal force: never pulls */
  LANE(real)
  delta = LANE(mask_zero)(touching, g->reach), elastic = LANE(law_elastic)(k, delta, features);
  LANE(real)
  force = LANE(mask_zero)(
      touching, LANE(max)(elastic - LANE(law_damping)(k, delta, features) * g->approach, zero));

  /* tangential displacement, and Amonton's cap */
  LANE(real) zeta = LANE(mask_zero)(touching, g->lambda - m->lambda_ref), cap = k->cap * force;
  LANE(real) capped = LANE(max)(LANE(min)(zeta, cap), -cap), slip = zeta - capped;

  /* losses */
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

/* F_n n - lever tau t with t = (-n_y, n_x); lever: (R_a + R_b)/r, or 1 with the paper's force. */
LANE_INLINE void LANE(contact_force)(const LANE(pair_geometry) * g,
                                     const LANE(contact_constants) * k, LANE(real) lever,
                                     const unsigned features, const LANE(contact_memory) * m,
                                     LANE(contact_output) * out) {
  LANE(real) tau = features & LAW_GENERAL ? m->tau : -(k->k_t * m->zeta), push = tau * lever;
  out->fx = m->force * g->nx + push * g->ny;
  out->fy = m->force * g->ny - push * g->nx;
  out->tau = tau;
}

/* The whole step of a contact; the pass over round pairs puts other work between the two. */
LANE_INLINE void LANE(contact_step)(const LANE(pair_geometry) * g,
                                    const LANE(contact_constants) * k, LANE(mask) touching,
                                    LANE(mask) closed, LANE(real) lever, const int paper,
                                    const unsigned features, LANE(contact_memory) * m,
                                    LANE(contact_output) * out) {
  LANE(contact_history)(g, k, touching, closed, paper, features, m, out);
  LANE(contact_force)(g, k, lever, features, m, out);
}

/* --- contacts that begin and end ------------------------------------------------------------------------- */

/* Time since the surfaces met, within this step: delta/(-u_n). 0 where they cannot have met in it, as at the start of a
 * run, or where attraction begins at a gap. */
LANE_INLINE LANE(real) LANE(since_touch)(const LANE(pair_geometry) * g, LANE(real) dt) {
  const LANE(real) zero = LANE(splat)(0.0), closing = -g->approach;
  const LANE(real) since = LANE(max)(g->reach, zero) / LANE(max)(closing, LANE(splat)(1e-290));
  const LANE(mask) within = LANE(greater)(closing, zero) & LANE(greater)(2.0 * dt, since);
  return LANE(mask_zero)(within, LANE(min)(since, dt));
}

/* Contacts that begin, and those whose surfaces meet in this step after attraction closed them at a gap. was: overlap before. */
LANE_INLINE LANE(mask)
    LANE(surfaces_meet)(const LANE(pair_geometry) * g, LANE(real) was, LANE(mask) touching,
                        LANE(mask) was_closed, const unsigned features) {
  const LANE(mask) begun = touching & LANE(not )(was_closed);
  if (!(features & LAW_COHESION)) return begun;
  const LANE(real) zero = LANE(splat)(0.0);
  return begun | (touching & was_closed & LANE(not )(LANE(greater)(was, zero)) &
                  LANE(greater)(g->reach, zero));
}

/* Before the step of contacts whose surfaces meet: lambda* and rho* are those of the moment of touch, found by going back
 * along the velocities (physics.md 2). Taken at the end of the step they would lack the way since then. Mindlin's stiffness
 * has grown as sqrt(t) meanwhile: sqrt(K) zeta is 4/5 of its last value times the way, and the trapezoid takes 1/2. */
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

/* A spring and its dashpot in the step in which their contact begins or ends. */
typedef struct LANE(edge_spring) {
  LANE(real) stiffness, q, force; /* force = -(stiffness q + drag): after a begin, before an end */
  LANE(real) way;                 /* by which the surfaces move in the whole step */
} LANE(edge_spring);

/* The trapezoid of its work goes over the whole step, though the contact was there for a part of it. What the spring neither
 * takes nor stores is lost by sliding; most of it comes back at the other end of the contact. Returns the loss of the dashpot. */
LANE_INLINE LANE(real)
    LANE(edge_losses)(const LANE(edge_spring) * s, LANE(mask) begun, LANE(real) * sliding) {
  const LANE(real) half = LANE(splat)(0.5), pull = s->stiffness * s->q;
  *sliding = half * pull * (s->way - LANE(mask_zero)(begun, s->q));
  return -half * (s->force + pull) * s->way;
}

LANE_INLINE LANE(real) LANE(edge_stored)(const LANE(edge_spring) * s) {
  return 0.5 * s->stiffness * s->q * s->q;
}

/* As contact_begin_end, of the tangential spring and of rolling. Adds to the losses of edges; out->dropped: the energy left. */
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

/* The rest of a step in which contacts begin or end; before: what they remembered; bent: dt^2/2 times the relative
 * acceleration of the centres along n before the step, by which the way of the step is shorter than u_n dt.
 *
 * The force with which a contact begins works over the whole way of the step, not only over the part of it on which
 * the disks overlap, and so does that with which it ends: the losses of both make up for each other, so that the budget of
 * elastic contacts does not drift. The energy left in the springs of a contact that opens is booked as such. */
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
    out->bridge = LANE(mask_zero)(begun, LANE(bridge_energy)(&k->cohesion));
    stored = stored + LANE(cohesion_energy)(&k->cohesion, overlap) + out->bridge;
  }
  const LANE(real) done =
      half * LANE(select)(begun, m->force * way, before->force * (before->overlap - g->reach));
  out->viscous =
      LANE(select)(begun, done - stored, LANE(select)(opened, stored - done, out->viscous));
  if (features & LAW_COHESION) { /* without what the springs have added */
    const LANE(real) met = half * (before->force + m->force) * (m->overlap - before->overlap) -
                           (LANE(normal_energy)(k, m->overlap, features) - stored);
    out->viscous = LANE(select)(meet & was_closed, met, out->viscous);
  }
  LANE(springs_begin_end)(g, k, meet, meet | opened, dt, features, before, m, out);
  out->viscous = LANE(mask_zero)(was_closed | touching, out->viscous);
  out->friction = LANE(mask_zero)(was_closed | touching, out->friction);
  out->dropped = LANE(mask_zero)(opened, out->dropped);
  /* e = n where it begins; an open contact remembers nothing */
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
