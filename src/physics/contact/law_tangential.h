/* law_tangential.h: tangential force of a contact, with all features of the law; contact_step.h
 * includes it once per LANE_WIDTH.
 *
 *   K    = k_t, or k_t sqrt(delta) with Mindlin's law (Mindlin and Deresiewicz, J. Appl. Mech. 20,
 *          327, in the form of most codes)
 *   zeta = lambda - lambda*, the tangential displacement; lambda* is shifted so that
 *          |zeta| <= cap = mu F/K, with F = max(elastic + viscous normal force - F_c, 0), no
 *          attraction; F_c: critical_load, in most laws 0 (Seto, Mari, Morris and Denn, Phys. Rev.
 *          Lett. 111, 218301)
 *   tau  = -(K zeta + gamma_t dlambda/dt), |tau| <= mu F
 *
 * The spring takes its part of the limit mu F first; the dashpot gets at most the rest of it and
 * never shifts lambda*, so it never supplies energy. mu is mu_kinetic if the contact slid in the
 * previous step.
 *
 * With Mindlin's law the energy K zeta^2/2 stays constant while only delta changes: it is y^2/2
 * with y = sqrt(K) zeta, and y_new = y + (sqrt(K) + sqrt(K_new))/2 dlambda. */

/* Factor K/k_t in the previous step (before) and in this step (now), and 1/now (inverse). */
typedef struct LANE(stiffness_factor) {
  LANE(real) before, now, inverse;
} LANE(stiffness_factor);

/* Computes the factor K/k_t: sqrt(overlap) with Mindlin's law, else 1. before: overlap in the
 * previous step; overlap: that in this step, not negative. */
LANE_INLINE void LANE(firmness_of)(const LANE(contact_constants) * k, LANE(real) before,
                                   LANE(real) overlap, LANE(stiffness_factor) * f) {
  const LANE(real) zero = LANE(splat)(0.0), one = LANE(splat)(1.0);
  const LANE(mask) mindlin = LANE(greater)(k->mindlin, zero);
  f->before = LANE(select)(mindlin, LANE(sqrt)(LANE(max)(before, zero)), one);
  f->now = LANE(select)(mindlin, LANE(sqrt)(overlap), one);
  f->inverse = 1.0 / LANE(max)(f->now, LANE(splat)(1e-100));
}

/* Advances the tangential spring and its dashpot by one step: updates m->lambda_ref, m->zeta and
 * m->tau, sets out->friction and out->slip, and adds the loss of the dashpot to out->viscous.
 * closed: lanes whose contact is closed after the step; limit: F + F_c, at least 0 (see the top of
 * this file); overlap: not negative. */
LANE_INLINE void LANE(tangential_history)(const LANE(pair_geometry) * g,
                                          const LANE(contact_constants) * k, LANE(mask) closed,
                                          LANE(real) overlap, LANE(real) limit,
                                          const unsigned features, LANE(contact_memory) * m,
                                          LANE(contact_output) * out) {
  const LANE(real) one = LANE(splat)(1.0), half = LANE(splat)(0.5);
  LANE(stiffness_factor) f = {one, one, one};
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
  if (features & LAW_CRITICAL) limit = LANE(max)(limit - k->critical_load, LANE(splat)(0.0));
  zeta = LANE(mask_zero)(closed, zeta);
  cap = cap * limit * f.inverse;
  LANE(real) capped = LANE(max)(LANE(min)(zeta, cap), -cap), slip = zeta - capped, both = capped;
  LANE(real) stiffness = k->k_t * f.now;
  if (features & LAW_DASHPOT) {
    both = LANE(max)(LANE(min)(capped + k->dashpot_ratio * f.inverse * g->slide, cap), -cap);
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
