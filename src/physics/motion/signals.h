/* signals.h: signals u(t) of the motions of one system, computed a batch of steps ahead (kinds:
 * model/motions.h). */
#ifndef PHYSICS_SIGNALS_H
#define PHYSICS_SIGNALS_H

#include "base/gsl.h"
#include "physics/motion/motion.h"
#include "physics/motion/motion_kernels.h"
#include "physics/motion/oscillators.h"

/* Constants of one signal, and its values over the batch. */
typedef struct signal {
  signal_values now;  /* values from the batch's first step on */
  wave wave;          /* constants of a wave */
  random_step step;   /* constants of a random motion */
  size_t group, lane; /* oscillator of a random motion, in signals.groups */
  gsl_spline *spline; /* spline through a table; NULL: no table */
  gsl_interp_accel *accel;
  /* Memory for u, v and low; kernels may write WAVE_FINE numbers beyond both ends of the batch. */
  double values[3][WAVE_FINE + MOTION_BATCH + WAVE_FINE];
} signal;

typedef struct signals {
  signal *item; /* [n_motions] signal of each motion of the model */
  size_t n_groups;
  oscillators *groups; /* [n_groups] random motions with the same interval, side by side */
  /* [n_groups] u and v of each oscillator by row */
  double (*draws)[2][OSCILLATORS][OSCILLATOR_ROWS];
} signals;

/* Allocates the signals of the model's motions. SD_ERROR_USER: no spline goes through a table. */
sd_status signals_new(const engine *e, signals *all, sd_messages *messages);
void signals_free(const engine *e, signals *all);
/* signals_load copies the oscillators of random motions from the state; signals_store copies them
 * back, as of state->step. */
void signals_load(const engine *e, signals *all);
void signals_store(const engine *e, const signals *all);
/* Computes the values of all running signals at step `first` and the MOTION_BATCH - 1 steps after
 * it. */
void signals_fill(const engine *e, signals *all, int64_t first);
/* Computes a batch of values of one tabulated motion, from `local` steps after its start on. */
void signals_fill_table(const engine *e, signal *s, size_t motion, int64_t local);
/* Starts a random signal: draws displacement and velocity from the stationary distribution, and
 * computes the first draw after them. */
void signals_start_random(const engine *e, const signals *all, size_t motion);

#endif
