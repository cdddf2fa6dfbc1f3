/* signals.h: signals u(t) of the motions of one system, computed a batch of steps ahead (kinds: model/motions.h). */
#ifndef PHYSICS_SIGNALS_H
#define PHYSICS_SIGNALS_H

#include "base/gsl.h"
#include "physics/motion/motion.h"
#include "physics/motion/motion_kernels.h"
#include "physics/motion/oscillators.h"

/* Constants of one signal, and its values over the batch. */
typedef struct signal {
  signal_values now; /* of the batch's first step; low is NULL where nothing is lost */
  wave wave;
  random_step step; /* random */
  size_t group, lane;
  gsl_spline *spline; /* table */
  gsl_interp_accel *accel;
  double values[3][WAVE_FINE + MOTION_BATCH +
                   WAVE_FINE]; /* u, v, low; kernels write a little beyond the batch */
} signal;

typedef struct signals {
  signal *item; /* [n_motions] */
  size_t n_groups;
  oscillators *groups; /* random motions of the same interval, side by side */
  double (*draws)[2][OSCILLATORS][OSCILLATOR_ROWS]; /* of each group: u, v, one behind the other */
} signals;

sd_status signals_new(const engine *e, signals *all, sd_messages *messages);
void signals_free(const engine *e, signals *all);
/* Oscillators from the state, and back at state->step. */
void signals_load(const engine *e, signals *all);
void signals_store(const engine *e, const signals *all);
/* Values of every running signal at step first and the MOTION_BATCH - 1 after it. */
void signals_fill(const engine *e, signals *all, int64_t first);
/* Of one table, after `local` steps and on. */
void signals_fill_table(const engine *e, signal *s, size_t motion, int64_t local);
/* A random signal begins in its stationary law: displacement and velocity at the start and at the first draw. */
void signals_start_random(const engine *e, const signals *all, size_t motion);

#endif
