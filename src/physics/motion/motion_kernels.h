/* motion_kernels.h: the loops of this room that are compiled once per instruction set, and what they work on.
 *
 * One system: steps along the lanes. Several alike ones: one system per lane, the same bits.
 */
#ifndef PHYSICS_MOTION_KERNELS_H
#define PHYSICS_MOTION_KERNELS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "model/motions.h"

/* --- random draws ------------------------------------------------------------------------------------ */

enum { RANDOM_STEP = 0, RANDOM_START = 1 }; /* purposes of a stream's draws */

/* Oscillators under random forces, one per lane (oscillators.h). Rows: at consecutive draws. */
enum { OSCILLATORS = 8, OSCILLATOR_ROWS = 72 /* a batch of 64, four before and after it */ };
typedef struct oscillators {
  _Alignas(64) double u[OSCILLATOR_ROWS][OSCILLATORS];
  double v[OSCILLATOR_ROWS][OSCILLATORS];
  double uu[OSCILLATORS], uv[OSCILLATORS], vu[OSCILLATORS], vv[OSCILLATORS]; /* propagator */
  double noise_u[OSCILLATORS], noise_vu[OSCILLATORS], noise_vv[OSCILLATORS]; /* Cholesky factor */
  uint64_t seed[OSCILLATORS], stream[OSCILLATORS],
      block[OSCILLATORS];     /* block: of the next new row */
  int64_t start[OSCILLATORS]; /* step at which the motion was switched on, -1: it does not run */
  int64_t base[OSCILLATORS], known[OSCILLATORS]; /* numbers of the first row, and of the last one */
  int64_t interval;                              /* steps between draws */
  size_t count;
} oscillators;

/* Draws that are `interval` steps, a time h, apart; the first of them has the number base. */
typedef struct draw_series {
  const double *u, *v;
  double h, per_h, per_interval;
  int64_t interval, base;
} draw_series;

/* --- waves ------------------------------------------------------------------------------------------- */

/* The phase is exact every WAVE_STEPS steps. A rotated wave is rotated from there, by WAVE_FINE steps and then by ones. */
enum { WAVE_STEPS = 64, WAVE_FINE = 8 };
typedef struct wave_anchor {
  double turns, sine, cosine;
} wave_anchor;
typedef struct wave {
  sd_motion_kind form;
  double rate, rate_high, rate_low, offset;          /* turns per step, also in two parts; turns */
  double shape[WAVE_SHAPE];                          /* waveforms.h */
  double sine[2 * WAVE_FINE], cosine[2 * WAVE_FINE]; /* of 0, 1, ... 7 steps, and of 0, 8, ... 56 */
  int64_t from; /* the anchors are at from and from + WAVE_STEPS steps */
  wave_anchor anchor[2];
} wave;

/* --- signals and poses ------------------------------------------------------------------------------- */

/* u, du/dt, and what u lost to rounding, at consecutive steps; low is NULL where nothing is lost. */
typedef struct signal_values {
  const double *u, *v, *low;
} signal_values;

/* A prescribed coordinate over n steps: its signals added up. */
typedef struct pose_sum {
  const signal_values *const *signals;
  size_t n_signals; /* > 0 */
  double off, base; /* value = ((sum of u - off) + base) + sum of low */
  double *value, *velocity;
  double low, high; /* range of the values */
} pose_sum;

typedef struct lanes_signal lanes_signal; /* pose_batch.h */
typedef struct lanes_pose lanes_pose;

typedef struct motion_kernels {
  /* n pairs of independent standard normal numbers: draw first + k of a stream in a[k], b[k], which is half
   * (first + k) & 1 of block (first + k)/2. */
  void (*normals)(uint64_t seed, uint32_t stream, uint32_t purpose, int64_t first, size_t n,
                  double *a, double *b);
  /* New rows from `row` on, two of each block. */
  void (*oscillate)(oscillators *g, size_t row, size_t blocks);
  /* Columns of the first n rows, one behind the other: u[lane][row], v[lane][row]; n is rounded up to a multiple of 8. */
  void (*spread)(const oscillators *g, size_t n, double (*u)[OSCILLATOR_ROWS],
                 double (*v)[OSCILLATOR_ROWS]);
  /* Signals of one system, n steps from `local` steps after their beginning; n is a multiple of 8, and eight numbers
   * before and after what is asked for are written too. low may be NULL. */
  void (*wave)(wave *w, int64_t local, size_t n, double *u, double *v);
  void (*cubics)(const draw_series *d, int64_t local, size_t n, double *u, double *v);
  void (*fade)(double dt, double ramp, int64_t local, size_t n, double *u, double *v, double *low);
  /* n is a multiple of 8. */
  void (*sum)(pose_sum *p, size_t n);
  /* The same of several systems side by side, for any n. Draws must reach far enough. */
  void (*lanes_signal)(lanes_signal *s, int64_t local, size_t n);
  void (*lanes_sum)(const lanes_pose *p, size_t n);
  /* Is some value of some lane not within [-limit, limit]? */
  bool (*lanes_beyond)(const lanes_pose *p, size_t n, double limit);
  /* sin and cos of 2 pi t[k]; n is rounded up to a multiple of 8. */
  void (*sine_cosine)(const double *t, size_t n, double *sine, double *cosine);
} motion_kernels;

#endif
