/* law_linear.h: linear law, F_el = k_n delta (eq. 2 of the paper). Included by normal_laws.h.
 *
 * Damping is gamma_n plus, for a coefficient of restitution, gamma = 2 b sqrt(m_eff k_n) with the
 * damping ratio b that law_damping_ratio computes.
 */
#ifndef MODEL_LAW_LINEAR_H
#define MODEL_LAW_LINEAR_H

static inline double linear_force(double k, double delta) { return k * delta; }
static inline double linear_energy(double k, double delta) { return 0.5 * k * delta * delta; }
static inline double linear_stiffness(double k, double delta) { return (void)delta, k; }
static inline double linear_viscosity(double tsuji, double delta) { return (void)delta, tsuji; }
static inline double linear_factor(double b) { return 2.0 * b; }

#endif

#ifdef LANE_WIDTH

LANE_INLINE LANE(real) LANE(linear_elastic)(LANE(real) k, LANE(real) delta) { return k * delta; }
LANE_INLINE LANE(real)
    LANE(linear_damping)(LANE(real) gamma_n, LANE(real) tsuji, LANE(real) delta) {
  return (void)delta, gamma_n + tsuji;
}
LANE_INLINE LANE(real) LANE(linear_stored)(LANE(real) k, LANE(real) delta) {
  return 0.5 * k * delta * delta;
}

#endif
