/* normal_laws.c: the table of normal contact laws, and damping from a coefficient of
 * restitution; see normal_laws.h. */
#include "base/math.h"
#include "model/normal_laws.h"

#define ROW_OF(number, word, keys, meaning)                                                        \
  [number] = {#word,         word##_force,    word##_energy, word##_stiffness,                     \
              word##_factor, word##_viscosity},
const normal_law normal_laws[SD_NORMAL_LAWS] = {NORMAL_LAWS(ROW_OF)};
#undef ROW_OF

void law_complete(sd_contact_law *law) {
  const double nu = law->poisson;
  if (law->E_star > 0 && law->k_n == 0) law->k_n = 4.0 / 3.0 * law->E_star;
  if (law->E_star > 0 && nu > 0 && law->k_t == 0) law->k_t = law->k_n * 3 * (1 - nu) / (2 - nu);
}

/* Coefficient of restitution e(b) of a damped oscillator with w_0 = 1 and damping ratio b whose
 * force never pulls (docs/physics.md 2); it falls from 1 towards 0 as b grows. */
static double restitution_of(double b) {
  double t;
  if (b < 1.0) {
    double w = sqrt((1.0 - b) * (1.0 + b));
    t = 2.0 * math_atan2(w, b) / w;
  } else {
    double v = sqrt((b - 1.0) * (b + 1.0));
    t = v > 0.0 ? 2.0 * math_log(b + v) / v : 2.0;
  }
  return math_exp(-b * t);
}

double law_damping_ratio(double e, bool pulls) {
  if (pulls) /* inverse of e = exp(-pi b/sqrt(1 - b^2)) */
    return -math_log(e) / math_hypot(M_PI, math_log(e));
  double low = 0.0, high = 1.0;
  while (restitution_of(high) > e && high < 1e6) high *= 2.0;
  for (int k = 0; k < 200 && high - low > 1e-16 * high; k++) {
    double middle = 0.5 * (low + high);
    *(restitution_of(middle) > e ? &low : &high) = middle;
  }
  return low;
}

double law_tsuji(const sd_contact_law *law) {
  if (!(law->restitution > 0.0 && law->restitution < 1.0)) return 0.0;
  return normal_laws[law->normal].factor(law_damping_ratio(law->restitution, law->damping_pulls));
}
