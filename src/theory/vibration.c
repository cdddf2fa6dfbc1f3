/* vibration.c: stationary covariances of the random vibration (52),
 *   x'' + 2 c w x' + w^2 x = xi, <xi xi'> = 4 c w^3 rms^2 delta(t - t').
 *
 * By the regression theorem <x(0) x(t)>/rms^2 = exp(-c w t) (C + c w S) with C = cos(w1 t),
 * S = sin(w1 t)/w1, w1^2 = w^2 (1 - c^2), of which the others are derivatives. C and S are entire
 * functions of w1^2: cosh and sinh above critical damping, 1 and t at it.
 */
#include <math.h>

#include "slipdisk/theory.h"

/* exp(-g t) C and exp(-g t) S, g = damping * omega. */
static void decaying(double omega, double damping, double t, double *c, double *s) {
  double g = damping * omega, d = omega * omega * (1 - damping) * (1 + damping), z = d * t * t;
  if (fabs(z) < 1e-3) { /* series to z^5: 1e-15 z^6/12! is far below rounding */
    double envelope = exp(-g * t), even = 1, odd = 1, ce = 1, so = 1;
    for (int k = 1; k <= 5; k++) {
      even *= -z / ((2 * k - 1) * (2 * k));
      odd *= -z / ((2 * k) * (2 * k + 1));
      ce += even;
      so += odd;
    }
    *c = envelope * ce;
    *s = envelope * so * t;
  } else if (d > 0) {
    double w1 = sqrt(d), envelope = exp(-g * t);
    *c = envelope * cos(w1 * t);
    *s = envelope * sin(w1 * t) / w1;
  } else {
    /* the slow exponent g - w1 = w^2/(g + w1) is formed without cancellation, and nothing overflows */
    double w1 = sqrt(-d), slow = exp(-omega * omega / (g + w1) * t), gone = exp(-2 * w1 * t);
    *c = slow * (1 + gone) / 2;
    *s = slow * (1 - gone) / (2 * w1);
  }
}

void sd_vibration_covariance(double omega, double damping, double rms, double lag, double c[3]) {
  double even, odd, variance = rms * rms, g = damping * omega;
  decaying(omega, damping, lag, &even, &odd);
  c[0] = variance * (even + g * odd);
  c[1] = -variance * omega * omega * odd;
  c[2] = variance * omega * omega * (even - g * odd);
}
