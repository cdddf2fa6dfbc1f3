/* law_radius.h: stiffnesses that depend on the radii of a contact, those of laws with E_star and of
 * bonds with bond_E; contact_step.h includes it once per LANE_WIDTH.
 *
 *   k_n = 4/3 E* sqrt(R_eff), k_t = k_n 3 (1 - nu)/(2 - nu), R_eff = R_a R_b/(R_a + R_b)
 *
 *   bonds of length L = R_a + R_b, at walls R_a: k_n = E width/L, k_t = k_n/(2 (1 + nu)),
 *   k_r = E width^3/(12 L R_eff^2)
 *
 * (Johnson, Contact Mechanics, sections 4.2 and 7.2; an elastic beam). The table of laws has the
 * values for R_eff = 1; law_at (model/normal_laws.h) does the same for single contacts. */

/* Returns 1/(ra + rb), or 1 if the sum is 0, as for padding pairs. */
LANE_INLINE LANE(real) LANE(inverse_sum)(LANE(real) ra, LANE(real) rb) {
  const LANE(real) sum = ra + rb;
  return 1.0 / LANE(select)(LANE(equal)(sum, LANE(splat)(0.0)), LANE(splat)(1.0), sum);
}

/* Returns R_eff of two round bodies; rb: negative for a round wall around the disk. */
LANE_INLINE LANE(real) LANE(effective_radius)(LANE(real) ra, LANE(real) rb) {
  return ra * rb * LANE(inverse_sum)(ra, rb);
}

/* Multiplies the stiffnesses that depend on R_eff (arm), and the constants that follow from them,
 * in the lanes whose law has E_star. */
LANE_INLINE void LANE(scale_by_radius)(LANE(real) arm, LANE(contact_constants) * k) {
  const LANE(real) zero = LANE(splat)(0.0), one = LANE(splat)(1.0);
  /* R_eff is 0 for padding pairs; avoid 1/0 */
  const LANE(real) root = LANE(sqrt)(LANE(max)(LANE(max)(arm, -arm), LANE(splat)(1e-200)));
  const LANE(real) normal = LANE(select)(LANE(greater)(k->scales_k_n, zero), root, one);
  const LANE(real) tangential = LANE(select)(LANE(greater)(k->scales_k_t, zero), root, one);
  k->k_n = k->k_n * normal;
  k->tsuji = k->tsuji * LANE(sqrt)(normal);
  k->k_t = k->k_t * tangential;
  k->half_k_t = k->half_k_t * tangential;
  k->cap = k->cap / tangential;
  k->cap_kinetic = k->cap_kinetic / tangential;
  k->dashpot_ratio = k->dashpot_ratio / tangential;
}

/* Divides the stiffnesses of bonds that are beams by their length, and the rolling stiffness by
 * R_eff^2 (arm), too. */
LANE_INLINE void LANE(scale_by_length)(LANE(real) length, LANE(real) arm,
                                       LANE(contact_constants) * k) {
  const LANE(real) zero = LANE(splat)(0.0), one = LANE(splat)(1.0);
  const LANE(mask) beam = LANE(greater)(k->is_beam, zero) & LANE(greater)(length, zero);
  const LANE(real) along = 1.0 / LANE(select)(beam, length, one);
  k->bond_k_n = k->bond_k_n * along;
  k->bond_k_t = k->bond_k_t * along;
  k->bond_k_r = k->bond_k_r * (along / LANE(select)(beam, arm * arm, one));
}
