/* law_hertz.h: Hertz's law, F_el = k_n delta^(3/2). Included by normal_laws.h.
 *
 * Damping is gamma_n, or follows from a coefficient of restitution e that does not depend on the
 * speed: gamma = alpha sqrt(m_eff k_n) delta^(1/4) (Tsuji, Tanaka, Ishida, Powder Technology 71,
 * 239). In the variable y = (2/sqrt 5) delta^(5/4) a collision obeys the equation of the linear law
 * with frequency w_0 = 1 and damping ratio b = alpha/sqrt 5, also if the force is cut off at 0. So
 * e(b) is the function of the linear law, and alpha = sqrt 5 b.
 */
#ifndef MODEL_LAW_HERTZ_H
#define MODEL_LAW_HERTZ_H

static inline double hertz_force(double k, double delta) { return k * delta * sqrt(delta); }
static inline double hertz_energy(double k, double delta) {
  return 0.4 * k * delta * delta * sqrt(delta);
}
static inline double hertz_stiffness(double k, double delta) { return 1.5 * k * sqrt(delta); }
static inline double hertz_viscosity(double tsuji, double delta) {
  return tsuji * sqrt(sqrt(delta));
}
static inline double hertz_factor(double b) { return sqrt(5.0) * b; }

#endif

#ifdef LANE_WIDTH

LANE_INLINE LANE(real) LANE(hertz_elastic)(LANE(real) k, LANE(real) delta) {
  return k * delta * LANE(sqrt)(delta);
}
LANE_INLINE LANE(real) LANE(hertz_damping)(LANE(real) gamma_n, LANE(real) tsuji, LANE(real) delta) {
  return gamma_n + tsuji * LANE(sqrt)(LANE(sqrt)(delta));
}
LANE_INLINE LANE(real) LANE(hertz_stored)(LANE(real) k, LANE(real) delta) {
  return 0.4 * k * delta * delta * LANE(sqrt)(delta);
}

#endif
