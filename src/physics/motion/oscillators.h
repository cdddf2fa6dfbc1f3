/* oscillators.h: randomly forced oscillators (eq. 52), side by side in lanes: several random motions of one
 * system, or one motion of several systems.
 *
 * Draws are numbered from the motion's start: number 0 is the stationary start, number k > 0 comes from half k & 1 of
 * block start + k/2 of its stream, where start is the step at which the motion was switched on. (A motion that runs
 * for n steps uses n/2 blocks, so a later start meets other blocks.) Row r of a lane holds number base + r.
 * Blocks are used whole: rows are added from an even number on, and what the state does not hold is
 * computed again.
 */
#ifndef PHYSICS_OSCILLATORS_H
#define PHYSICS_OSCILLATORS_H

#include "model/state.h"
#include "physics/motion/motion_kernels.h"

/* The exact discrete step of the randomly forced oscillator (eq. 52).
 *
 * u'' + 2 c w u' + w^2 u = xi, <xi xi'> = 4 c w^3 rms^2 delta(t - t'). Over a time h the pair (u, u') goes to
 * propagator * (u, u') + cholesky * (g1, g2) with independent standard normal g1, g2.
 */
typedef struct random_step {
  double propagator[2][2];
  double cholesky[3]; /* lower triangle: uu, vu, vv */
} random_step;

/* omega > 0, damping ratio c > 0 (under-, critically or over-damped), rms >= 0, h > 0. The
 * covariance is a Gauss-Legendre quadrature of positive terms: no digits are lost when w h is
 * small (physics.md 7). */
random_step random_step_new(double omega, double damping, double rms, double h);

/* n zeroed groups whose rows begin where vectors do; goes with free. */
oscillators *oscillators_new(size_t n);
void oscillators_set(oscillators *g, size_t lane, const random_step *step, uint64_t seed,
                     uint32_t stream);

/* Takes a lane from the state: motion k runs, and its draws are `interval` steps apart. Back: at state->step. */
void oscillators_load(oscillators *g, size_t lane, const sd_state *s, size_t k, int64_t interval);
void oscillators_store(const oscillators *g, size_t lane, sd_state *s, size_t k, int64_t interval);
/* Not running. */
void oscillators_rest(oscillators *g, size_t lane);

/* Brings the rows of every lane that runs to a batch of n values, the first of them at step first[lane]: from the last
 * draw before it to the first one after it. Returns how many rows there are. */
size_t oscillators_ahead(const motion_kernels *k, oscillators *g, const int64_t *first, int64_t n,
                         int64_t interval);

#endif
