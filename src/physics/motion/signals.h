/* signals.h: signals u(t), prescribed displacements, of the motions of one system, computed
 * MOTION_BATCH steps ahead (a batch). The kinds of signals are in model/motions.h. */
#ifndef PHYSICS_SIGNALS_H
#define PHYSICS_SIGNALS_H

#include "model/state.h"
#include "physics/motion/motion.h"
#include "physics/motion/motion_kernels.h"
#include "physics/motion/spline.h"
#include "physics/system/work.h"

/* --- randomly forced oscillators (eq. 52) ----------------------------------------------------- */

/* Oscillators stand side by side in vector lanes: several random motions of one system, or one
 * motion of several systems.
 *
 * The random steps of a motion, each with one pair of normal numbers, are numbered from its start:
 * number 0 is the stationary initial state; number k > 0 uses half k & 1 of Philox block start +
 * k/2 of its random stream, where start is the step at which the motion was switched on. (A motion
 * that runs for n steps uses n/2 blocks, so a motion that starts after it uses other blocks.) Row r
 * of a lane holds random step number base + r. Both halves of a block are always used together: new
 * rows begin with an even number, and values that the state does not hold are recomputed.
 */

/* The exact discrete step of the randomly forced oscillator (eq. 52 of the paper).
 *
 * u'' + 2 c w u' + w^2 u = xi, <xi xi'> = 4 c w^3 rms^2 delta(t - t'). Over a time h the pair (u,
 * u') becomes propagator * (u, u') + cholesky * (g1, g2) with independent standard normal numbers
 * g1, g2.
 */
typedef struct random_step {
  double propagator[2][2];
  double cholesky[3]; /* lower triangle of the Cholesky factor of the noise: uu, vu, vv */
} random_step;

/* Returns propagator and noise of a random step of length h. omega > 0; damping: ratio c > 0
 * (under-, critically or over-damped); rms >= 0; h > 0. The covariance of the noise is computed by
 * Gauss-Legendre quadrature of positive terms, so no digits are lost when w h is small
 * (docs/physics.md, section 7). */
random_step random_step_new(double omega, double damping, double rms, double h);

/* Returns n groups of oscillators, all zero, aligned for vector loads; the caller releases them
 * with free. */
oscillators *oscillators_new(size_t n);
/* Sets the constants and the random stream of the oscillator in a lane, and marks it as not
 * running. */
void oscillators_set(oscillators *g, size_t lane, const random_step *step, uint64_t seed,
                     uint32_t stream);

/* oscillators_load copies the oscillator of running motion k from the state to a lane;
 * oscillators_store copies it back, as of state->step. interval: number of time steps between
 * random steps. */
void oscillators_load(oscillators *g, size_t lane, const sd_state *s, size_t k, int64_t interval);
void oscillators_store(const oscillators *g, size_t lane, sd_state *s, size_t k, int64_t interval);
/* Marks the oscillator in a lane as not running. */
void oscillators_rest(oscillators *g, size_t lane);

/* Advances all running oscillators so that their rows cover the n time steps from first[lane] on:
 * from the last random step before these steps to the first one after them. Returns the number of
 * rows. */
size_t oscillators_ahead(const motion_kernels *k, oscillators *g, const int64_t *first, int64_t n,
                         int64_t interval);

/* --- signals ---------------------------------------------------------------------------------- */

/* Constants of one signal, and its values at the steps computed ahead. */
typedef struct motion_signal {
  signal_values now;  /* values from the first step computed ahead on */
  wave wave;          /* constants, if the signal is a wave */
  random_step step;   /* propagator and noise, if the motion is random */
  size_t group, lane; /* position of its oscillator in signals.groups, if the motion is random */
  spline spline;      /* through a table, if the motion has one */
  /* Memory for u, v and low; kernels may write up to WAVE_FINE numbers before and after the
   * MOTION_BATCH values. */
  double values[3][WAVE_FINE + MOTION_BATCH + WAVE_FINE];
} motion_signal;

typedef struct signals {
  motion_signal *item; /* [n_motions] signal of each motion of the model */
  size_t n_groups;
  /* [n_groups] oscillators of random motions with the same interval, side by side in vector
   * lanes */
  oscillators *groups;
  /* [n_groups] displacement and velocity (u, v) of each oscillator of a group, by row */
  double (*draws)[2][OSCILLATORS][OSCILLATOR_ROWS];
} signals;

/* Allocates the signals of the model's motions. SD_ERROR_USER: no spline can be put through a
 * table. */
sd_status signals_new(const engine *e, signals *all, sd_messages *messages);
void signals_free(const engine *e, signals *all);
/* signals_load copies the oscillators of random motions from the state; signals_store copies them
 * back, as of state->step. */
void signals_load(const engine *e, signals *all);
void signals_store(const engine *e, const signals *all);
/* Computes the values of all running signals at step `first` and the MOTION_BATCH - 1 steps after
 * it. */
void signals_fill(const engine *e, signals *all, int64_t first);
/* Computes MOTION_BATCH values of one tabulated motion, from `local` steps after its start on. */
void signals_fill_table(const engine *e, motion_signal *s, size_t motion, int64_t local);
/* Starts a random signal: chooses displacement and velocity at random from the stationary
 * distribution, and computes the first random step after them. */
void signals_start_random(const engine *e, const signals *all, size_t motion);

/* --- access of pose_batch.c to the motions of one system (motion.c) --------------------------- */

/* Returns the signals of the model's motions; owned by the engine. */
signals *motion_signals(const engine *e);
/* Returns the index in the model of the motion that is summand number t of a prescribed
 * coordinate. */
size_t motion_term(const engine *e, const prescribed *p, size_t t);
/* Sets *off (full turns or periods removed by wrapping) and *base (pose without running motions) of
 * a coordinate: its value is the sum of its signals - *off + *base. */
void motion_offset(const engine *e, uint32_t slot, int coordinate, double *off, double *base);
/* True if a coordinate is in its range: angles in [-4, 4] rad, positions in the box, displacements
 * of a surface within half of body_surface_turn. */
bool motion_in_range(const engine *e, int coordinate, double at);

/* Walls whose motion depends on the contact forces: loads and servos (docs/physics.md, section 6).
 *
 * Their motion cannot be computed ahead: before the forces of a step are evaluated, each wall moves
 * to its pose at t + dt, which follows from the forces at t in the state. The work that the wall
 * does on the disks is added to the budget like that of prescribed bodies; the wall's own energy is
 * not part of the budget.
 */

/* One running load or servo, which moves one wall along one coordinate. */
typedef struct feedback {
  size_t motion;      /* index of the motion in the model */
  uint32_t slot;      /* slot of the wall */
  int coordinate;     /* SD_X or SD_Y */
  double *at, *speed; /* pointers to position and velocity of the wall in the state */
  /* pointers to contact force, and to the position without running motions, in the state */
  const double *force, *base;
  /* pointer to the number of periods by which the wall was wrapped along the coordinate, in the
   * state */
  const int32_t *image;
  /* displacement in the last step, and contact force before that step */
  double moved, force_before;
} feedback;

/* All running loads and servos. */
typedef struct feedbacks {
  size_t count;
  feedback *item; /* memory for all loads and servos of the model */
  /* Weight of the latest force in the exponential average that servos use: 1 - exp(-dt/P), P:
   * shortest contact period. */
  double smoothing;
} feedbacks;

/* Allocates the list of loads and servos, which is empty until feedback_list is called. */
void feedback_new(const engine *e, feedbacks *all);
void feedback_free(feedbacks *all);
/* Lists the loads and servos that run according to the state. */
void feedback_list(engine *e, feedbacks *all);

/* Begins load or servo k, which was switched on: its wall starts at rest from its present
 * position. */
void feedback_begin(engine *e, size_t k);
/* Ends load or servo k, which was switched off: its wall stays at its present position. */
void feedback_end(engine *e, size_t k);

/* Moves the walls of loads and servos to their positions at step state->step + 1, with predicted
 * velocities. Sets mine->stale if a wall makes the neighbour list stale, and adds walls that must
 * be wrapped to mine->returns. */
void feedback_pose(engine *e, feedbacks *all, thread_work *mine);
/* True if the next step of the walls of loads and servos would make the neighbour list stale. The
 * state is not changed. */
bool feedback_outruns(const engine *e, const feedbacks *all);
/* Corrects the velocities of loads with the forces after the step. Returns the sum over all loads
 * and servos of (contact force before + after the step) times displacement: twice the work that
 * contacts do on their walls. */
double feedback_correct(engine *e, feedbacks *all);

#endif
