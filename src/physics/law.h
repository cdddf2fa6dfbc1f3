/* law.h: the contact law of one pair (eqs. 2, 4, tau, 36), branch-free over lanes.
 *
 * Included once per LANE_WIDTH after base/lane.h. The same text serves the single run (pairs along the
 * lanes) and tails of width 1; a lane's bits do not depend on the width.
 *
 *   F_n  = max(k_n delta - gamma_n u_n, 0) while delta > 0
 *   zeta = lambda - lambda*, |zeta| <= mu F_n / k_t by shifting lambda*
 *   tau  = -k_t zeta
 *
 * lambda is measured from the contact's reference direction e: lambda = arc - sum * turned, arc = R_a th_a +
 * R_b th_b, turned = angle from e to n. The contact is re-based after a step in which |sin(turned)| exceeds
 * LAW_REBASE, so a short series of asin(e x n) is exact to rounding.
 */
#ifndef LAW_COMMON
#define LAW_COMMON
#define LAW_REBASE 0.015625
#endif

typedef struct LANE(law_constants) {
  LANE(real) k_n, k_t, inverse_k_t, gamma_n, mu; /* inverse_k_t is 0 where k_t is: no skin */
} LANE(law_constants);

typedef struct LANE(law_input) {
  LANE(real) dx, dy;       /* from a to b */
  LANE(real) dvx, dvy;     /* velocity of b's surface point relative to a's centre */
  LANE(real) sum;          /* R_a + R_b; negative inside a round container */
  LANE(real) arc;          /* lambda but for the turning of the contact line */
  LANE(real) star, ex, ey; /* memory: lambda*, reference direction (0, 0) when open */
  LANE(mask) active;       /* false: cannot touch here (another piece of the wall does) */
} LANE(law_input);

typedef struct LANE(law_output) {
  LANE(real) nx, ny;       /* unit vector from a to b's surface */
  LANE(real) inverse_r;    /* 1/r, r signed as sum */
  LANE(real) delta;        /* overlap, 0 when not touching */
  LANE(real) reach;        /* overlap, negative where there is a gap */
  LANE(real) approach;     /* u_n, separation positive */
  LANE(real) force;        /* F_n */
  LANE(real) stretch;      /* zeta after the cap */
  LANE(real) slip;         /* what the cap took off zeta */
  LANE(real) turned, sine; /* angle and sine from e to n */
  LANE(mask) touching, closed;
} LANE(law_output);

LANE_INLINE LANE(law_output) LANE(law)(const LANE(law_input) * in, const LANE(law_constants) * k) {
  LANE(law_output) out;
  /* geometry; the floor under r^2 only keeps a centre on a centre finite */
  LANE(real) r = LANE(root)(LANE(most)(in->dx * in->dx + in->dy * in->dy, LANE(splat)(1e-280)));
  r = LANE(select)(in->sum < 0.0, -r, r);
  out.inverse_r = 1.0 / r;
  out.nx = in->dx * out.inverse_r;
  out.ny = in->dy * out.inverse_r;
  LANE(real) delta = in->sum - r, zero = LANE(splat)(0.0);
  out.reach = delta;
  out.touching = (delta > 0.0) & in->active;
  out.closed = (in->ex * in->ex + in->ey * in->ey > 0.5) & out.touching;
  out.delta = LANE(select)(out.touching, delta, zero);

  /* normal force: never pulls */
  out.approach = (in->dvx * in->dx + in->dvy * in->dy) * out.inverse_r;
  LANE(real) force = LANE(most)(k->k_n * out.delta - k->gamma_n * out.approach, zero);
  out.force = LANE(select)(out.touching, force, zero);

  /* angle since the reference direction: asin series to s^9, exact to rounding up to twice LAW_REBASE */
  LANE(real) s = (in->ex * in->dy - in->ey * in->dx) * out.inverse_r, z = s * s;
  out.sine = s;
  out.turned =
      s + (s * z) * (((3.0 / 40.0) * z + 1.0 / 6.0) + (z * z) * ((35.0 / 1152.0) * z + 15.0 / 336.0));

  /* skin: stretch, and Amonton's cap */
  LANE(real) zeta = (in->arc - in->sum * out.turned) - in->star;
  zeta = LANE(select)(out.closed, zeta, zero);
  LANE(real) cap = k->mu * out.force * k->inverse_k_t;
  out.stretch = LANE(most)(LANE(least)(zeta, cap), -cap);
  out.slip = zeta - out.stretch;
  return out;
}
