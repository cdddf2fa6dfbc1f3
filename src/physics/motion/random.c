/* random.c: propagator and noise of the random vibration; see random.h. */
#include "physics/motion/random.h"

#include <gsl/gsl_errno.h>
#include <gsl/gsl_integration.h>
#include <math.h>

#include "base/memory.h"

/* Response g(t) to a unit kick of the velocity, and its derivative. */
static void kick(double omega, double c, double t, double *g, double *dg) {
  double w2 = omega * omega * (1.0 - c * c), w = sqrt(fabs(w2)), x = w * t, ratio, cosine;
  double decay = exp(-c * omega * t);
  if (x < 1e-4) { /* sin x / w and sinh x / w, also at critical damping */
    double sign = w2 > 0.0 ? -1.0 : 1.0;
    ratio = decay * t * (1.0 + sign * x * x / 6.0);
    cosine = decay * (1.0 + sign * x * x / 2.0);
  } else if (w2 > 0.0) {
    ratio = decay * sin(x) / w;
    cosine = decay * cos(x);
  } else { /* each exponential with its own decay, so that neither overflows */
    double slow = exp((w - c * omega) * t), fast = exp(-(w + c * omega) * t);
    ratio = 0.5 * (slow - fast) / w;
    cosine = 0.5 * (slow + fast);
  }
  *g = ratio;
  *dg = cosine - c * omega * ratio;
}

random_step random_step_new(double omega, double c, double rms, double h) {
  random_step step;
  double g, dg;
  kick(omega, c, h, &g, &dg);
  /* u(t) from u(0) = 1: dg + 2 c w g; the velocities follow from u'' = -2 c w u' - w^2 u */
  step.propagator[0][0] = dg + 2.0 * c * omega * g;
  step.propagator[0][1] = g;
  step.propagator[1][0] = -omega * omega * g;
  step.propagator[1][1] = dg;

  /* covariance = 4 c w^3 rms^2 int_0^h (g, g')(g, g')^T dt, in panels short against every time scale */
  enum { POINTS = 16 };
  gsl_error_handler_t *handler = gsl_set_error_handler_off();
  gsl_integration_glfixed_table *table = gsl_integration_glfixed_table_alloc(POINTS);
  gsl_set_error_handler(handler);
  if (!table) memory_lacks(0);
  double fastest = omega * (c + sqrt(fabs(1.0 - c * c)) + 1.0), uu = 0.0, vu = 0.0, vv = 0.0;
  double span =
      fmin(h, 50.0 / (omega * (c > 1.0 ? c - sqrt(c * c - 1.0) : c))); /* beyond it, nothing is left */
  int panels = 1 + (int)fmin(ceil(span * fastest / 2.0), 1e6);
  for (int k = 0; k < panels; k++)
    for (size_t p = 0; p < POINTS; p++) {
      double t, weight;
      gsl_integration_glfixed_point(span * k / panels, span * (k + 1) / panels, p, &t, &weight, table);
      kick(omega, c, t, &g, &dg);
      uu += weight * g * g;
      vu += weight * g * dg;
      vv += weight * dg * dg;
    }
  gsl_integration_glfixed_table_free(table);
  double strength = 4.0 * c * omega * omega * omega * rms * rms;
  step.cholesky[0] = sqrt(strength * uu);
  step.cholesky[1] = uu > 0.0 ? sqrt(strength) * vu / sqrt(uu) : 0.0;
  step.cholesky[2] = uu > 0.0 ? sqrt(strength * fmax(vv - vu * vu / uu, 0.0)) : 0.0;
  return step;
}
