/* law.h: the contact law of one pair (eqs. 2, 4, tau, 36), branch-free over lanes.
 *
 * Included once per LANE_WIDTH after base/lane.h. The same text serves one system (pairs along the lanes, and
 * tails of width 1) and several side by side; a lane's bits do not depend on the width.
 *
 *   F_n  = max(k_n delta - gamma_n u_n, 0) while delta > 0
 *   zeta = lambda - lambda*, |zeta| <= mu F_n / k_t by shifting lambda*
 *   tau  = -k_t zeta
 *
 * lambda is measured from the contact's reference direction e: lambda = arc - sum * turned, arc = R_a th_a +
 * R_b th_b, turned = angle from e to n. The contact is re-based after a step in which |sin(turned)| exceeds
 * LAW_REBASE, so that three terms of the series of asin(e x n) are exact to rounding.
 */
#ifndef LAW_COMMON
#define LAW_COMMON
#define LAW_REBASE 0.015625
#define LAW_SIGN 0x8000000000000000u
#endif

typedef struct LANE(law_constants) {
  LANE(real) k_n, k_t, half_k_t, gamma_n, cap; /* cap: mu/k_t, 0 where k_t is: no skin */
} LANE(law_constants);

typedef struct LANE(law_input) {
  LANE(real) dx, dy;       /* from a to b */
  LANE(real) dvx, dvy;     /* velocity of b's surface point relative to a's centre */
  LANE(real) sum;          /* R_a + R_b; negative inside a round container */
  LANE(real) arc;          /* lambda but for the turning of the contact line */
  LANE(real) star, ex, ey; /* memory: lambda*, reference direction (0, 0) when open */
  LANE(mask) was_closed;   /* the contact has a memory */
  LANE(mask) active;       /* false: cannot touch here (another piece of the wall does) */
} LANE(law_input);

/* What follows from places and velocities. */
typedef struct LANE(law_geometry) {
  LANE(real) nx, ny;        /* from a to b's surface */
  LANE(real) reach;         /* overlap, negative where there is a gap */
  LANE(real) approach;      /* u_n, separation positive */
  LANE(real) lambda;        /* from the reference direction */
  LANE(real) turned, sine2; /* angle from e to n, its squared sine */
  LANE(real) lever;         /* (R_a + R_b)/r */
} LANE(law_geometry);

typedef struct LANE(law_output) {
  LANE(real) delta;   /* overlap, 0 when not touching */
  LANE(real) elastic; /* k_n delta */
  LANE(real) force;   /* F_n */
  LANE(real) stretch; /* zeta after the cap */
  LANE(real) slip;    /* what the cap took off zeta */
  LANE(mask) touching, closed;
} LANE(law_output);

/* What is seen of two bodies. The rest of the geometry waits for the root and the division, so that these are under way
 * while something else is worked out. */
typedef struct LANE(law_sight) {
  LANE(real) dx, dy, sum, arc;
  LANE(real) dot;   /* of the way and the velocity */
  LANE(real) cross; /* of the reference direction and the way */
  LANE(real) r;     /* length of the way, with the sign of sum: negative inside a round container */
  LANE(real) inverse_r;
} LANE(law_sight);

/* Field by field, here and below: compilers take copies of the whole apart. */
LANE_INLINE void LANE(law_look)(const LANE(law_input) * in, LANE(law_sight) * g) {
  g->dx = in->dx;
  g->dy = in->dy;
  g->sum = in->sum;
  g->arc = in->arc;
  g->dot = in->dvx * in->dx + in->dvy * in->dy;
  g->cross = in->ex * in->dy - in->ey * in->dx;
  /* the floor under r^2 keeps a centre on a centre finite; it also turns a pose that is not a number into a touch, so
   * that the step in which it came to be is the one that is looked at */
  LANE(real) r = LANE(root)(LANE(most)(in->dx * in->dx + in->dy * in->dy, LANE(splat)(1e-280)));
  g->r = LANE(as_real)(LANE(as_bits)(r) | (LANE(as_bits)(in->sum) & LAW_SIGN));
  g->inverse_r = 1.0 / g->r;
}

LANE_INLINE void LANE(law_geometry_at)(const LANE(law_sight) * in, LANE(law_geometry) * g) {
  LANE(real) inverse_r = in->inverse_r;
  g->nx = in->dx * inverse_r;
  g->ny = in->dy * inverse_r;
  g->reach = in->sum - in->r;
  g->approach = in->dot * inverse_r;
  g->lever = in->sum * inverse_r;
  /* angle since the reference direction: asin series */
  LANE(real) s = in->cross * inverse_r, z = s * s;
  LANE(real) turned = s + (s * z) * (((15.0 / 336.0) * z + 3.0 / 40.0) * z + 1.0 / 6.0);
  g->sine2 = z;
  g->turned = turned;
  g->lambda = in->arc - in->sum * turned;
}

LANE_INLINE LANE(law_geometry) LANE(law_geometry_of)(const LANE(law_input) * in) {
  LANE(law_sight) sight;
  LANE(law_geometry) g;
  LANE(law_look)(in, &sight);
  LANE(law_geometry_at)(&sight, &g);
  return g;
}

LANE_INLINE LANE(law_output)
    LANE(law)(const LANE(law_input) * in, const LANE(law_geometry) * g, const LANE(law_constants) * k) {
  LANE(law_output) out;
  LANE(real) zero = LANE(splat)(0.0);
  out.touching = LANE(greater)(g->reach, zero) & in->active;
  out.closed = in->was_closed & out.touching;
  out.delta = LANE(keep)(out.touching, g->reach);

  /* normal force: never pulls */
  out.elastic = k->k_n * out.delta;
  out.force = LANE(keep)(out.touching, LANE(most)(out.elastic - k->gamma_n * g->approach, zero));

  /* skin: stretch, and Amonton's cap */
  LANE(real) zeta = LANE(keep)(out.closed, g->lambda - in->star);
  LANE(real) cap = k->cap * out.force;
  out.stretch = LANE(most)(LANE(least)(zeta, cap), -cap);
  out.slip = zeta - out.stretch;
  return out;
}

/* On b: the force, and tau. */
typedef struct LANE(law_push) {
  LANE(real) fx, fy, tau;
} LANE(law_push);

/* F_n n - scale tau t, with t = (-n_y, n_x); scale is 1, or (R_a + R_b)/r in the conservative variant. */
LANE_INLINE LANE(law_push) LANE(law_force)(const LANE(law_geometry) * g, const LANE(law_output) * out,
                                           const LANE(law_constants) * k, LANE(real) scale) {
  LANE(real) tau = -(k->k_t * out->stretch), push = tau * scale;
  return (LANE(law_push)){out->force * g->nx + push * g->ny, out->force * g->ny - push * g->nx, tau};
}

/* What a contact remembers, as of its last commit. */
typedef struct LANE(law_memory) {
  LANE(real) star;
  LANE(real) force, overlap, stretch, turned;
  LANE(real) slip;    /* of that step: which way it slides */
  LANE(real) damping; /* force - k_n overlap: follows from these */
} LANE(law_memory);

/* What a commit books: losses of the step, and what must be looked at one by one. */
typedef struct LANE(law_booked) {
  LANE(real) viscous, friction, gain;
  LANE(real) drop;                  /* energy that was left in contacts that opened */
  LANE(mask) opened, begun, turned; /* turned: these, and contacts that turned far */
  LANE(mask) rare;                  /* and those that overlap too deeply */
} LANE(law_booked);

/* Slides the skin and books the losses of the step: trapezoid between the last committed
 * values and the new ones (physics.md 9). limit: largest overlap allowed. variant: the paper's tangential force
 * does work that is not the skin's. */
LANE_INLINE LANE(law_booked)
    LANE(law_commit)(const LANE(law_input) * in, const LANE(law_geometry) * g, const LANE(law_output) * out,
                     const LANE(law_constants) * k, LANE(real) limit, int variant, LANE(law_memory) * m) {
  LANE(law_booked) b;
  LANE(real) zero = LANE(splat)(0.0), half = LANE(splat)(0.5), half_k_t = k->half_k_t;
  LANE(real) rise = out->delta - m->overlap, stretch = m->stretch;
  LANE(real) damping = out->force - out->elastic, torn = stretch * m->overlap + out->stretch * out->delta;
  b.viscous = half * (m->damping + damping) * rise;
  b.friction = half_k_t * (stretch + out->stretch) * out->slip;
  b.gain = variant ? half_k_t * torn * (m->turned - g->turned) : zero;
  b.opened = in->was_closed & LANE(not )(out->touching);
  b.begun = LANE(not )(in->was_closed) & out->touching;
  LANE(mask) far = LANE(greater)(g->sine2, LANE(splat)(LAW_REBASE * LAW_REBASE)) & out->closed;
  b.turned = b.opened | b.begun | far;
  b.rare = b.turned | LANE(greater)(out->delta, limit);
  b.drop = zero;
  m->star = m->star + out->slip;
  m->force = out->force;
  m->overlap = out->delta;
  m->stretch = out->stretch;
  m->turned = g->turned;
  m->slip = out->slip;
  m->damping = damping;
  return b;
}

/* The rest of a commit where contacts have opened or begun. before: overlap and stretch that were remembered.
 *
 * The force with which a contact begins worked over the whole way of the step, not only over the part of it on which
 * the disks overlapped. What an opening contact loses is booked as such. */
LANE_INLINE void LANE(law_turn_over)(const LANE(law_input) * in, const LANE(law_geometry) * g,
                                     const LANE(law_output) * out, const LANE(law_constants) * k,
                                     const LANE(law_memory) * before, LANE(real) dt, LANE(law_memory) * m,
                                     LANE(law_booked) * b) {
  LANE(real) half = LANE(splat)(0.5), rise = out->delta - before->overlap;
  b->drop = LANE(keep)(b->opened, b->viscous + k->half_k_t * before->stretch * before->stretch);
  LANE(real) way = LANE(keep)(b->begun, -(g->approach * dt) - rise);
  b->viscous = LANE(keep)(out->touching, b->viscous + half * out->force * way);
  b->friction = LANE(keep)(out->closed, b->friction);
  b->gain = LANE(keep)(out->closed, b->gain);
  /* memory: keep, start (lambda* = lambda, reference direction = n), or forget */
  m->star = LANE(keep)(out->touching, LANE(select)(out->closed, m->star, in->arc));
  m->turned = LANE(keep)(out->closed, m->turned);
}

/* A component of the reference direction after a commit: it begins with n, and is 0 when open. */
LANE_INLINE LANE(real) LANE(law_direction)(const LANE(law_booked) * b, const LANE(law_output) * out,
                                           LANE(real) e, LANE(real) n) {
  return LANE(keep)(out->touching, LANE(select)(b->begun, n, e));
}

/* A disk that arrives at touch to rounding: the force at the trial coordinates acted, and the corrected ones do not
 * touch, or the other way round. What the losses have for this step is then wrong by the force's work. near: open
 * contacts for which this may be so; missed: that work, with the normal force that acted: an open contact has no other. */
LANE_INLINE LANE(mask) LANE(law_near)(const LANE(law_input) * in, const LANE(law_geometry) * g,
                                      const LANE(law_output) * out, LANE(real) dt) {
  return LANE(not )(in->was_closed | out->touching) & in->active &
         LANE(greater)(g->reach, 2.0 * dt * g->approach);
}

LANE_INLINE LANE(real) LANE(law_missed)(const LANE(law_input) * in, const LANE(law_geometry) * g,
                                        const LANE(law_output) * out, LANE(real) acted, LANE(real) dt) {
  LANE(real) zero = LANE(splat)(0.0);
  LANE(mask) felt = LANE(greater)(acted, zero);
  LANE(real) wrong = LANE(select)(out->touching, LANE(select)(felt, zero, -out->force), acted);
  return LANE(select)(in->was_closed, zero, -(wrong * g->approach * dt));
}

/* Does more happen in a commit than that contacts slide? limit: largest overlap. */
LANE_INLINE LANE(mask)
    LANE(law_rare)(const LANE(law_geometry) * g, LANE(mask) was_closed, LANE(real) limit, LANE(real) two_dt) {
  LANE(mask) touching = LANE(greater)(g->reach, LANE(splat)(0.0));
  LANE(mask) near = LANE(greater)(g->reach, two_dt * g->approach) & LANE(not )(touching);
  LANE(mask)
  far = LANE(greater)(g->sine2, LANE(splat)(LAW_REBASE * LAW_REBASE)); /* not where there is no direction */
  return (touching ^ was_closed) | far | near | LANE(greater)(g->reach, limit);
}
