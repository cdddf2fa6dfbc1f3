/* collision.c: closed forms of single collisions, for tests. */
#include <math.h>

#include "slipdisk/theory.h"

/* With b = gamma_n/(2 m) and w^2 = k_n/m - b^2 the force of (2) vanishes when tan(w t) = -2 b w/(w^2 - b^2).
 * 2 b w/(w^2 - b^2) = tan(2 atan(b/w)), so t_c = (pi - 2 atan(b/w))/w = (2/w) atan(w/b) on every branch;
 * there the speed is exp(-b t_c) of the first. Above critical damping w = i v and atan becomes atanh. */
sd_collision sd_restitution(double k_n, double gamma_n, double m_eff) {
  double b = gamma_n / (2 * m_eff), w0 = sqrt(k_n / m_eff), t;
  if (b < w0) {
    double w = sqrt((w0 - b) * (w0 + b));
    t = 2 * atan2(w, b) / w;
  } else if (b == w0) {
    t = 2 / b;
  } else {
    /* atanh(v/b) = ln((b + v)/w0): the second has no cancellation as v -> b, the first none as v -> 0 */
    double v = sqrt((b - w0) * (b + w0));
    t = 2 * (v < b / 2 ? atanh(v / b) : log((b + v) / w0)) / v;
  }
  return (sd_collision){.restitution = exp(-b * t), .duration = t};
}

sd_oblique sd_gross_sliding(double mass, double inertia, double radius, double mu, double restitution,
                            double v_n, double v_t, double spin) {
  double surface = v_t + radius * spin, sense = surface < 0 ? -1 : 1;
  double impulse = mu * mass * (1 + restitution) * v_n; /* of friction */
  sd_oblique after = {
      .v_n = restitution * v_n,
      .v_t = v_t - sense * impulse / mass,
      .spin = spin - sense * impulse * radius / inertia,
  };
  after.sliding = sense * (after.v_t + radius * after.spin) >= 0;
  return after;
}

/* Friction mu m g slows the centre and spins the disk until v = R spin (I = m R^2/2: t = u/(3 mu g)). */
void sd_slide_to_roll(double mass, double inertia, double radius, double mu, double g, double u, double *time,
                      double *speed) {
  double ratio = mass * radius * radius / inertia;
  *time = u / (mu * g * (1 + ratio));
  *speed = u * ratio / (1 + ratio);
}
