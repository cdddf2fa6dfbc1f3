/* law_rolling.h: rolling resistance; contact_step.h includes it once per LANE_WIDTH.
 *
 *   rho = R_eff (theta_a - theta_b) - rho*, R_eff = R_a R_b/(R_a + R_b);
 *         rho* is shifted so that |rho| <= mu_r F/k_r
 *   f   = -(k_r rho + gamma_r drho/dt), |f| <= mu_r F, and -drag_r drho/dt without limit
 *   couple: R_eff f on a, the opposite on b
 *
 * (Luding, Granular Matter 10, 235; Ai, Chen, Rotter, Ooi, Powder Technology 206, 269, model C).
 * rho, like lambda, is a function of the two angles, so it cannot drift. F and the dashpot are
 * those of law_tangential.h. */

/* Computes for two round bodies the rolling displacement (g->rho), its time derivative (g->rolls)
 * and R_eff (g->arm). ra, rb: radii; arc_a, arc_b: R theta of each body; spin_a, spin_b: R omega of
 * each body. */
LANE_INLINE void LANE(rolled)(LANE(real) ra, LANE(real) rb, LANE(real) arc_a, LANE(real) arc_b,
                              LANE(real) spin_a, LANE(real) spin_b, LANE(pair_geometry) * g) {
  const LANE(real) per_sum = LANE(inverse_sum)(ra, rb);
  g->rho = (rb * arc_a - ra * arc_b) * per_sum;
  g->rolls = (rb * spin_a - ra * spin_b) * per_sum;
  g->arm = ra * rb * per_sum;
}

/* Advances the rolling spring and its dashpot by one step: updates m->rho_ref, m->rho and m->roll,
 * sets out->rolling to the loss by rolling, and adds the loss of the dashpot to out->viscous.
 * closed: lanes whose contact is closed after the step; limit: the force F above; m->overlap: that
 * after the step. */
LANE_INLINE void LANE(rolling_history)(const LANE(pair_geometry) * g,
                                       const LANE(contact_constants) * k, LANE(mask) closed,
                                       LANE(real) limit, LANE(contact_memory) * m,
                                       LANE(contact_output) * out) {
  const LANE(real) half = LANE(splat)(0.5);
  LANE(real)
  rho = LANE(mask_zero)(closed, g->rho - m->rho_ref), moved = LANE(mask_zero)(closed, rho - m->rho);
  LANE(real) cap = k->cap_r * limit;
  LANE(real) capped = LANE(max)(LANE(min)(rho, cap), -cap), slip = rho - capped;
  LANE(real) both = LANE(max)(LANE(min)(capped + k->dashpot_ratio_r * g->rolls, cap), -cap);
  const LANE(mask) deep = LANE(greater)(m->overlap, LANE(splat)(0.0)); /* not across a gap */
  LANE(real) free = LANE(mask_zero)(deep, k->drag_r * g->rolls);
  LANE(real) drag = k->k_r * (both - capped) + free, drag_before = -m->roll - k->k_r * m->rho;
  out->rolling = half * k->k_r * (m->rho + capped) * slip;
  out->viscous = out->viscous + half * (drag_before + drag) * moved;
  m->rho_ref = m->rho_ref + slip;
  m->rho = capped;
  m->roll = -(k->k_r * both) - free;
}
