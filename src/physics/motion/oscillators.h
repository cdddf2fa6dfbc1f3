/* oscillators.h: randomly forced oscillators (eq. 52), side by side in vector lanes: several random
 * motions of one system, or one motion of several systems.
 *
 * The draws of a motion are numbered from its start: number 0 is the stationary initial state;
 * number k > 0 uses half k & 1 of block start + k/2 of its random stream, where start is the step
 * at which the motion was switched on. (A motion that runs for n steps uses n/2 blocks, so a motion
 * that starts after it uses other blocks.) Row r of a lane holds draw number base + r. Blocks are
 * always used whole: new rows begin with an even number, and values that the state does not hold
 * are recomputed.
 */
#ifndef PHYSICS_OSCILLATORS_H
#define PHYSICS_OSCILLATORS_H

#include "model/state.h"
#include "physics/motion/motion_kernels.h"

/* The exact discrete step of the randomly forced oscillator (eq. 52).
 *
 * u'' + 2 c w u' + w^2 u = xi, <xi xi'> = 4 c w^3 rms^2 delta(t - t'). Over a time h the pair (u,
 * u') goes to propagator * (u, u') + cholesky * (g1, g2) with independent standard normal g1, g2.
 */
typedef struct random_step {
  double propagator[2][2];
  double cholesky[3]; /* lower triangle of the Cholesky factor of the noise: uu, vu, vv */
} random_step;

/* Returns the exact step of length h. omega > 0; damping: ratio c > 0 (under-, critically or
 * over-damped); rms >= 0; h > 0. The covariance is computed by Gauss-Legendre quadrature of
 * positive terms, so no digits are lost when w h is small (docs/physics.md, section 7). */
random_step random_step_new(double omega, double damping, double rms, double h);

/* Returns n zeroed groups of oscillators, aligned for vectors; the caller releases them with
 * free. */
oscillators *oscillators_new(size_t n);
/* Sets the constants and the random stream of a lane; it does not run yet. */
void oscillators_set(oscillators *g, size_t lane, const random_step *step, uint64_t seed,
                     uint32_t stream);

/* oscillators_load copies running motion k from the state to a lane; oscillators_store copies it
 * back, as of state->step. interval: number of steps between draws. */
void oscillators_load(oscillators *g, size_t lane, const sd_state *s, size_t k, int64_t interval);
void oscillators_store(const oscillators *g, size_t lane, sd_state *s, size_t k, int64_t interval);
/* Marks a lane as not running. */
void oscillators_rest(oscillators *g, size_t lane);

/* Extends the rows of all running lanes to cover a batch of n steps that begins at step
 * first[lane]: from the last draw before the batch to the first one after it. Returns the number of
 * rows. */
size_t oscillators_ahead(const motion_kernels *k, oscillators *g, const int64_t *first, int64_t n,
                         int64_t interval);

#endif
