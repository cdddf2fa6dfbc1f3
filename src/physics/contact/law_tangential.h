/* law_tangential.h: tangential force with all features; included by contact_step.h once per LANE_WIDTH.
 *
 *   K    = k_t, or k_t sqrt(delta) (Mindlin and Deresiewicz, J. Appl. Mech. 20, 327, as in most codes)
 *   zeta = lambda - lambda*; |zeta| <= cap = mu F/K by shifting lambda*, F: normal force without attraction, if it pushes
 *   tau  = -(K zeta + gamma_t dlambda/dt), |tau| <= mu F
 *
 * The dashpot has what the spring leaves of the limit and shifts nothing: it never gives energy. mu is mu_kinetic where
 * the contact slid in the step before.
 *
 * Mindlin's energy K zeta^2/2 does not change where only delta does: with y = sqrt(K) zeta it is y^2/2, and
 * y_new = y + (sqrt(K) + sqrt(K_new))/2 dlambda. */

/* K over k_t, and its inverse. */
typedef struct LANE(firmness) {
  LANE(real) before, now, inverse;
} LANE(firmness);

LANE_INLINE void LANE(firmness_of)(const LANE(contact_constants) * k, LANE(real) before,
                                   LANE(real) overlap, LANE(firmness) * f) {
  const LANE(real) zero = LANE(splat)(0.0), one = LANE(splat)(1.0);
  const LANE(mask) mindlin = LANE(greater)(k->mindlin, zero);
  f->before = LANE(select)(mindlin, LANE(sqrt)(LANE(max)(before, zero)), one);
  f->now = LANE(select)(mindlin, LANE(sqrt)(overlap), one);
  f->inverse = 1.0 / LANE(max)(f->now, LANE(splat)(1e-100));
}

/* limit: F. overlap: not negative. Adds to out->viscous. */
LANE_INLINE void LANE(tangential_history)(const LANE(pair_geometry) * g,
                                          const LANE(contact_constants) * k, LANE(mask) closed,
                                          LANE(real) overlap, LANE(real) limit,
                                          const unsigned features, LANE(contact_memory) * m,
                                          LANE(contact_output) * out) {
  const LANE(real) one = LANE(splat)(1.0), half = LANE(splat)(0.5);
  LANE(firmness) f = {one, one, one};
  const LANE(real) way = g->lambda - m->lambda_ref, moved = way - m->zeta;
  LANE(real) zeta = way, kept = m->zeta, cap = k->cap;
  if (features & LAW_MINDLIN) {
    LANE(firmness_of)(k, m->overlap, overlap, &f);
    const LANE(real) root = LANE(sqrt)(f.before * f.inverse);
    kept = root * m->zeta;
    zeta = LANE(select)(LANE(greater)(k->mindlin, LANE(splat)(0.0)),
                        kept + half * (root + 1.0) * moved, zeta);
  }
  if (features & LAW_KINETIC) cap = LANE(select)(m->slid, k->cap_kinetic, cap);
  zeta = LANE(mask_zero)(closed, zeta);
  cap = cap * limit * f.inverse;
  LANE(real) capped = LANE(max)(LANE(min)(zeta, cap), -cap), slip = zeta - capped, both = capped;
  LANE(real) stiffness = k->k_t * f.now;
  if (features & LAW_DASHPOT) {
    both = LANE(max)(LANE(min)(capped + k->lag * f.inverse * g->slide, cap), -cap);
    LANE(real)
    drag = stiffness * (both - capped), drag_before = -m->tau - (k->k_t * f.before) * m->zeta;
    out->viscous = out->viscous + half * (drag_before + drag) * LANE(mask_zero)(closed, moved);
  }
  out->friction = half * stiffness * (kept + capped) * slip;
  out->slip = slip;
  m->lambda_ref = m->lambda_ref + LANE(mask_zero)(closed, way - capped);
  m->zeta = capped;
  m->tau = -(stiffness * both);
}
