/* kernels.h: the loops that are compiled once per instruction set and chosen at run time.
 *
 * All paths give the same bits: no fused multiply-add, no reassociation.
 */
#ifndef PHYSICS_KERNELS_H
#define PHYSICS_KERNELS_H

#include "physics/system/work.h"

enum { RANDOM_STEP = 0, RANDOM_START = 1 }; /* purposes of a stream's draws */

/* Oscillators under random forces, one per lane (oscillators.h). Rows: at consecutive draws. */
enum { OSCILLATORS = 8, OSCILLATOR_ROWS = 72 /* a batch of 64, four before and after it */ };
typedef struct oscillators {
  _Alignas(64) double u[OSCILLATOR_ROWS][OSCILLATORS];
  double v[OSCILLATOR_ROWS][OSCILLATORS];
  double uu[OSCILLATORS], uv[OSCILLATORS], vu[OSCILLATORS], vv[OSCILLATORS]; /* propagator */
  double noise_u[OSCILLATORS], noise_vu[OSCILLATORS], noise_vv[OSCILLATORS]; /* Cholesky factor */
  uint64_t seed[OSCILLATORS], stream[OSCILLATORS], block[OSCILLATORS];       /* block: of the next new row */
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

/* A harmonic or parabolic signal: its angle is exact every WAVE_STEPS steps, and turned on from there, by WAVE_FINE
 * steps and then by ones. */
enum { WAVE_STEPS = 64, WAVE_FINE = 8 };
typedef struct wave_anchor {
  double turns, sine, cosine;
} wave_anchor;
typedef struct wave {
  double rate, rate_high, rate_low, offset;          /* turns per step, also in two parts; turns */
  double scale_u, scale_v;                           /* signal_pass.h */
  double sine[2 * WAVE_FINE], cosine[2 * WAVE_FINE]; /* of 0, 1, ... 7 steps, and of 0, 8, ... 56 */
  int64_t from;                                      /* the anchors are at from and from + WAVE_STEPS steps */
  wave_anchor anchor[2];
} wave;

/* u, du/dt, and what u lost to rounding, at consecutive steps; low is NULL where nothing is lost. */
typedef struct signal_values {
  const double *u, *v, *low;
} signal_values;

/* A prescribed coordinate over n steps. Kernel place fills value, velocity and the range of the values. */
typedef struct place_batch {
  const signal_values *const *signals;
  size_t n_signals; /* > 0 */
  double off, base; /* value = ((sum of u - off) + base) + sum of low */
  double *value, *velocity;
  double low, high;
} place_batch;

typedef struct lanes_signal lanes_signal;
typedef struct lanes_place lanes_place;

typedef struct kernels {
  const char *name;
  /* Evaluates pairs [begin, end) once: forces are added to the sums, history is written. Round pairs go in whole blocks,
   * and not together with wall segments. */
  void (*pairs)(engine *e, thread_work *mine, size_t begin, size_t end);
  /* Here and below, but for stale: of free disks those of one chunk at a time, where chunks share rows. */
  /* Bodies [begin, end): the sums to force_x, force_y, torque. That of a straight wall is about its pivot. */
  void (*gather)(engine *e, size_t begin, size_t end);
  /* Packs the bodies [begin, end) from their poses; clears the forces on them. */
  void (*pack)(engine *e, size_t begin, size_t end);
  /* Has a free disk of [begin, end) moved too far since the lists were built; ahead: will it have, after a step? */
  bool (*stale)(const engine *e, size_t begin, size_t end, bool ahead);
  /* Free disks [begin, end), by sd_integrator; predict packs them, correct gathers first. */
  void (*predict[2])(engine *e, size_t begin, size_t end);
  void (*correct[2])(engine *e, thread_work *mine, size_t begin, size_t end);
  /* n steps of small systems side by side (lanes.h), lane_width of them or one. */
  size_t lane_width;
  void (*lanes)(lanes *l, int64_t n);
  /* n pairs of independent standard normal numbers: draw first + k of a stream in a[k], b[k], which is half
   * (first + k) & 1 of block (first + k)/2. */
  void (*normals)(uint64_t seed, uint32_t stream, uint32_t purpose, int64_t first, size_t n, double *a,
                  double *b);
  /* New rows from `row` on, two of each block. */
  void (*oscillate)(oscillators *g, size_t row, size_t blocks);
  /* Columns of the first n rows, one behind the other: u[lane][row], v[lane][row]; n is rounded up to a multiple of 8. */
  void (*spread)(const oscillators *g, size_t n, double (*u)[OSCILLATOR_ROWS], double (*v)[OSCILLATOR_ROWS]);
  /* Signals of one system, n steps from `local` steps after their beginning; n is a multiple of 8, and room for
   * eight numbers before and after what is asked for must be there. */
  void (*anchors)(wave *w, int64_t from);
  void (*harmonic)(const wave *w, int64_t local, size_t n, double *u, double *v);
  void (*parabolic)(const wave *w, int64_t local, size_t n, double *u, double *v);
  void (*cubics)(const draw_series *d, int64_t local, size_t n, double *u, double *v);
  /* low may be NULL */
  void (*fade)(double dt, double ramp, int64_t local, size_t n, double *u, double *v, double *low);
  /* n is a multiple of 8. */
  void (*place)(place_batch *b, size_t n);
  /* The same of several systems side by side (lanes_signal.h), for any n. Draws must reach far enough. */
  void (*lanes_signal)(lanes_signal *s, int64_t local, size_t n);
  void (*lanes_place)(const lanes_place *p, size_t n);
  /* Is some value of some lane not within [-limit, limit]? */
  bool (*lanes_beyond)(const lanes_place *p, size_t n, double limit);
  /* sin and cos of 2 pi t[k]; n is rounded up to a multiple of 8. */
  void (*sine_cosine)(const double *t, size_t n, double *sine, double *cosine);
} kernels;

/* The fastest path that this machine runs; SLIPDISK_PATH=baseline|avx2|avx512 asks for another. */
const kernels *kernels_choose(void);
/* A path by name, NULL when it was not built or does not run here. */
const kernels *kernels_named(const char *name);

#endif
