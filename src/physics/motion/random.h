/* random.h: the exact discrete step of the randomly forced oscillator (eq. 52).
 *
 * u'' + 2 c w u' + w^2 u = xi, <xi xi'> = 4 c w^3 rms^2 delta(t - t'). Over a time h the pair (u, u') goes to
 * propagator * (u, u') + cholesky * (g1, g2) with independent standard normal g1, g2.
 */
#ifndef PHYSICS_RANDOM_H
#define PHYSICS_RANDOM_H

typedef struct random_step {
  double propagator[2][2];
  double cholesky[3]; /* lower triangle: uu, vu, vv */
} random_step;

/* omega > 0, damping ratio c > 0 (under-, critically or over-damped), rms >= 0, h > 0. The
 * covariance is a Gauss-Legendre quadrature of positive terms: no digits are lost when w h is
 * small (physics.md 7). */
random_step random_step_new(double omega, double damping, double rms, double h);

#endif
