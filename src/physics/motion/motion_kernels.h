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

enum { RANDOM_STEP = 0, RANDOM_START = 1 }; /* purpose of a draw: random step, or initial state */

/* Group of randomly forced oscillators, one per lane (signals.h). Rows of u and v hold
 * displacement and velocity at consecutive draws. */
enum { OSCILLATORS = 8, OSCILLATOR_ROWS = 72 /* a batch of 64, four rows before and after it */ };
typedef struct oscillators {
  _Alignas(64) double u[OSCILLATOR_ROWS][OSCILLATORS];
  double v[OSCILLATOR_ROWS][OSCILLATORS];
  /* propagator of (u, v) over one draw */
  double uu[OSCILLATORS], uv[OSCILLATORS], vu[OSCILLATORS], vv[OSCILLATORS];
  /* Cholesky factor of the noise */
  double noise_u[OSCILLATORS], noise_vu[OSCILLATORS], noise_vv[OSCILLATORS];
  uint64_t seed[OSCILLATORS], stream[OSCILLATORS],
      block[OSCILLATORS];     /* block: random block that the next new row uses */
  int64_t start[OSCILLATORS]; /* step at which the motion was switched on, -1: it does not run */
  int64_t base[OSCILLATORS], known[OSCILLATORS]; /* draw numbers of the first and the last row */
  int64_t interval;                              /* number of steps between draws */
  size_t count;
} oscillators;

/* Displacements u and velocities v at draws that are `interval` steps, a time h, apart; the first
 * draw has the number base. per_h: 1/h; per_interval: 1/interval. */
typedef struct draw_series {
  const double *u, *v;
  double h, per_h, per_interval;
  int64_t interval, base;
} draw_series;

/* --- waves ------------------------------------------------------------------------------------ */

/* The phase of a wave is computed exactly every WAVE_STEPS steps (anchors). A harmonic wave is
 * rotated from there, by multiples of WAVE_FINE steps and then by single steps. */
enum { WAVE_STEPS = 64, WAVE_FINE = 8 };
/* Phase of a wave at one step, in turns, with its sine and cosine. */
typedef struct wave_anchor {
  double turns, sine, cosine;
} wave_anchor;
/* Periodic signal of one motion. */
typedef struct wave {
  sd_motion_kind form;
  /* Turns per step, and the same as a sum of two parts; initial phase in turns. */
  double rate, rate_high, rate_low, offset;
  double shape[WAVE_SHAPE]; /* constants of the waveform; see waveforms.h */
  /* Sine and cosine of the phase of 0, 1, ... 7 steps, then of 0, 8, ... 56 steps. */
  double sine[2 * WAVE_FINE], cosine[2 * WAVE_FINE];
  int64_t from; /* the anchors are at steps from and from + WAVE_STEPS; -1: not computed */
  wave_anchor anchor[2];
} wave;

/* --- signals and poses ------------------------------------------------------------------------ */

/* Values of a signal at consecutive steps: u, v = du/dt, and low, the rounding error of u to be
 * added to it; low is NULL if u is exact. */
typedef struct signal_values {
  const double *u, *v, *low;
} signal_values;

/* Sum of the signals of a prescribed coordinate over n steps. */
typedef struct pose_sum {
  const signal_values *const *signals;
  size_t n_signals; /* at least 1 */
  double off, base; /* value = ((sum of u - off) + base) + sum of low */
  double *value, *velocity;
  double low, high; /* smallest and largest value */
} pose_sum;

typedef struct lanes_signal lanes_signal; /* defined in pose_batch.h, as is lanes_pose */
typedef struct lanes_pose lanes_pose;

typedef struct motion_kernels {
  /* Computes n pairs of independent standard normal numbers: a[k], b[k] is draw first + k of a
   * stream, which is half (first + k) & 1 of block (first + k)/2. */
  void (*normals)(uint64_t seed, uint32_t stream, uint32_t purpose, int64_t first, size_t n,
                  double *a, double *b);
  /* Computes new rows of all oscillators from `row` on, two from each of `blocks` random blocks. */
  void (*oscillate)(oscillators *g, size_t row, size_t blocks);
  /* Transposes the first n rows to u[lane][row], v[lane][row]; n is rounded up to a multiple of
   * 8. */
  void (*spread)(const oscillators *g, size_t n, double (*u)[OSCILLATOR_ROWS],
                 double (*v)[OSCILLATOR_ROWS]);
  /* Compute (wave, cubics) or fade in (fade) a signal of one system at n steps, from `local` steps
   * after its start on. n is a multiple of 8; up to eight numbers before and after the n results
   * may be overwritten. low may be NULL. */
  void (*wave)(wave *w, int64_t local, size_t n, double *u, double *v);
  void (*cubics)(const draw_series *d, int64_t local, size_t n, double *u, double *v);
  void (*fade)(double dt, double ramp, int64_t local, size_t n, double *u, double *v, double *low);
  /* Adds the signals of a prescribed coordinate; n is a multiple of 8. */
  void (*sum)(pose_sum *p, size_t n);
  /* Compute a signal or add the signals of a coordinate for several systems side by side, for any
   * n. Draws must be known up to the one after the last step. */
  void (*lanes_signal)(lanes_signal *s, int64_t local, size_t n);
  void (*lanes_sum)(const lanes_pose *p, size_t n);
  /* True if any of the first n values in any lane is outside [-limit, limit], or is not a
   * number. */
  bool (*lanes_beyond)(const lanes_pose *p, size_t n, double limit);
  /* Computes sin(2 pi t[k]) and cos(2 pi t[k]); n is rounded up to a multiple of 8. */
  void (*sine_cosine)(const double *t, size_t n, double *sine, double *cosine);
} motion_kernels;

#endif
