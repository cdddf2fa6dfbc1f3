/* motion_kernels.h: the loops of physics/motion that are compiled once per instruction set, and
 * their data.
 *
 * For one system vector lanes hold consecutive steps; for several similar systems each lane holds
 * one of them. Both give the same bits.
 */
#ifndef PHYSICS_MOTION_KERNELS_H
#define PHYSICS_MOTION_KERNELS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "model/motions.h"

/* --- random draws ----------------------------------------------------------------------------- */

/* purpose of random numbers, one word of the Philox counter: a random step, or an initial state */
enum { RANDOM_STEP = 0, RANDOM_START = 1 };

/* Group of randomly forced oscillators, one per vector lane (signals.h). Rows of u and v hold
 * displacement and velocity after consecutive random steps. */
enum {
  OSCILLATORS = 8,
  OSCILLATOR_ROWS = 72 /* 64 steps ahead, and four rows before and after them */
};
typedef struct oscillators {
  _Alignas(64) double u[OSCILLATOR_ROWS][OSCILLATORS];
  double v[OSCILLATOR_ROWS][OSCILLATORS];
  /* coefficients of the propagator of (u, v) over one random step */
  double uu[OSCILLATORS], uv[OSCILLATORS], vu[OSCILLATORS], vv[OSCILLATORS];
  /* coefficients of the Cholesky factor of the noise in one random step */
  double noise_u[OSCILLATORS], noise_vu[OSCILLATORS], noise_vv[OSCILLATORS];
  uint64_t seed[OSCILLATORS], stream[OSCILLATORS],
      block[OSCILLATORS];     /* block: number of the Philox block that the next new row uses */
  int64_t start[OSCILLATORS]; /* step at which the motion was switched on, -1: it does not run */
  /* numbers of the random steps that row 0 and the last known row hold */
  int64_t base[OSCILLATORS], known[OSCILLATORS];
  int64_t interval; /* number of time steps in one random step */
  size_t count;
} oscillators;

/* Displacements u and velocities v after consecutive random steps; a random step is `interval` time
 * steps, a time h, long. base: number of the random step of u[0], v[0]; per_h: 1/h; per_interval:
 * 1/interval. */
typedef struct draw_series {
  const double *u, *v;
  double h, per_h, per_interval;
  int64_t interval, base;
} draw_series;

/* --- waves ------------------------------------------------------------------------------------ */

/* The phase of a wave is computed exactly every WAVE_STEPS steps, at anchors. From an anchor a
 * harmonic wave is rotated by a multiple of WAVE_FINE steps and then by single steps. */
enum { WAVE_STEPS = 64, WAVE_FINE = 8 };
/* Exact phase of a wave at one step, in turns, and sine and cosine of this phase. */
typedef struct wave_anchor {
  double turns, sine, cosine;
} wave_anchor;
/* Constants and anchors of a periodic signal. */
typedef struct wave {
  sd_motion_kind form;
  /* rate: frequency in turns per step, also as the sum rate_high + rate_low; offset: initial phase
   * in turns. */
  double rate, rate_high, rate_low, offset;
  double shape[WAVE_SHAPE]; /* constants of the waveform; see waveforms.h */
  /* Sine and cosine of the phase advance in 0, 1, ... 7 steps, then in 0, 8, ... 56 steps. */
  double sine[2 * WAVE_FINE], cosine[2 * WAVE_FINE];
  int64_t from; /* step of anchor[0]; anchor[1] is WAVE_STEPS later; -1: anchors are not computed */
  wave_anchor anchor[2];
} wave;

/* --- signals and poses ------------------------------------------------------------------------ */

/* Values of a signal at consecutive steps: displacement u, velocity v = du/dt, and low, the
 * rounding error of u: the exact displacement is u + low. low is NULL if u is exact. */
typedef struct signal_values {
  const double *u, *v, *low;
} signal_values;

/* Arguments of motion_kernels.sum, which adds the signals of a prescribed coordinate step by
 * step. */
typedef struct pose_sum {
  const signal_values *const *signals;
  size_t n_signals; /* number of signals, at least 1 */
  /* offset from wrapping, and base pose: value = ((sum of u - off) + base) + sum of low */
  double off, base;
  double *value, *velocity;
  double low, high; /* smallest and largest of the n values */
} pose_sum;

typedef struct lanes_signal lanes_signal; /* defined in pose_batch.h, like lanes_pose */
typedef struct lanes_pose lanes_pose;

typedef struct motion_kernels {
  /* Computes n pairs of independent standard normal numbers a[k], b[k] of a random stream. Pair k
   * comes from half (first + k) & 1 of Philox block (first + k)/2 of the stream. */
  void (*normals)(uint64_t seed, uint32_t stream, uint32_t purpose, int64_t first, size_t n,
                  double *a, double *b);
  /* Advances all oscillators by 2 * blocks random steps, with `blocks` Philox blocks, and stores
   * them in new rows from `row` on. */
  void (*oscillate)(oscillators *g, size_t row, size_t blocks);
  /* Transposes the first n rows of all oscillators to u[lane][row], v[lane][row]; n is rounded up
   * to a multiple of 8. */
  void (*spread)(const oscillators *g, size_t n, double (*u)[OSCILLATOR_ROWS],
                 double (*v)[OSCILLATOR_ROWS]);
  /* wave computes a periodic signal, cubics a random signal from cubics between random steps, fade
   * multiplies a signal by its fade-in. They write n steps of one system, from `local` steps after
   * the start of the signal on. n is a multiple of 8; up to eight numbers before and after the n
   * results may be overwritten. low may be NULL. */
  void (*wave)(wave *w, int64_t local, size_t n, double *u, double *v);
  void (*cubics)(const draw_series *d, int64_t local, size_t n, double *u, double *v);
  void (*fade)(double dt, double ramp, int64_t local, size_t n, double *u, double *v, double *low);
  /* Adds the signals of a prescribed coordinate at n steps; n is a multiple of 8. */
  void (*sum)(pose_sum *p, size_t n);
  /* lanes_signal computes n steps of a signal, and lanes_sum adds n steps of the signals of a
   * coordinate, for several systems side by side; n is any number. Oscillators of random signals
   * must be known up to the random step after the last step. */
  void (*lanes_signal)(lanes_signal *s, int64_t local, size_t n);
  void (*lanes_sum)(const lanes_pose *p, size_t n);
  /* True if any of the first n values in any lane is outside [-limit, limit], or is not a
   * number. */
  bool (*lanes_beyond)(const lanes_pose *p, size_t n, double limit);
  /* Computes sin(2 pi t[k]) and cos(2 pi t[k]); n is rounded up to a multiple of 8. */
  void (*sine_cosine)(const double *t, size_t n, double *sine, double *cosine);
} motion_kernels;

#endif
