/* kernels.h: the loops that are compiled once per instruction set and chosen at run time.
 *
 * All paths give the same bits: no fused multiply-add, no reassociation.
 */
#ifndef PHYSICS_KERNELS_H
#define PHYSICS_KERNELS_H

#include "physics/work.h"

/* What a pass over the pairs does: forces for the gather, or committing lambda* and the losses, or both. */
enum { PASS_FORCE = 1, PASS_COMMIT = 2 };

enum { RANDOM_STEP = 0, RANDOM_START = 1 }; /* purposes of a stream's draws */

/* Random motions that are advanced together, one per lane (eq. 52; random.h). */
enum { OSCILLATORS = 8, OSCILLATOR_DRAWS = 80 /* a batch and two, and rounding */ };
typedef struct oscillators {
  size_t count;
  size_t motion[OSCILLATORS];
  double uu[OSCILLATORS], uv[OSCILLATORS], vu[OSCILLATORS], vv[OSCILLATORS]; /* propagator */
  double noise_u[OSCILLATORS], noise_vu[OSCILLATORS], noise_vv[OSCILLATORS]; /* Cholesky factor */
  double u[OSCILLATORS][OSCILLATOR_DRAWS], v[OSCILLATORS][OSCILLATOR_DRAWS]; /* at consecutive draws */
  double normal1[OSCILLATORS][OSCILLATOR_DRAWS], normal2[OSCILLATORS][OSCILLATOR_DRAWS];
} oscillators;

/* A prescribed coordinate over n steps: each signal is n values of u, n of du/dt, n of what u lost to
 * rounding. Kernel place fills value, velocity and the range of the values. */
typedef struct place_batch {
  const double *const *signals;
  size_t n_signals;
  double off, base; /* value = ((sum of u - off) + base) + what was lost */
  double *value, *velocity;
  double low, high;
} place_batch;

typedef struct kernels {
  const char *name;
  /* Pairs [begin, end) in one pass; begin is a multiple of 8. */
  void (*pairs)(engine *e, thread_work *mine, size_t begin, size_t end, int pass);
  /* Sums the contacts of each body [begin, end) into force_x, force_y, torque, in order of the partners'
   * keys. The torque of a straight wall is about its pivot. */
  void (*gather)(engine *e, size_t begin, size_t end);
  /* Adds the step's losses of each free disk [begin, end): half of a contact's, the whole where the other
   * side is a wall or prescribed. */
  void (*losses)(engine *e, size_t begin, size_t end);
  /* Free disks [begin, end), by sd_integrator. */
  void (*predict[2])(engine *e, thread_work *mine, size_t begin, size_t end);
  void (*correct[2])(engine *e, thread_work *mine, size_t begin, size_t end);
  /* n steps of small systems side by side (lanes.h), lane_width of them or one. */
  size_t lane_width;
  void (*lanes)(lanes *l, int64_t n);
  /* n pairs of independent standard normal numbers: draw first + k of a stream in a[k], b[k].
   * n is rounded up to a multiple of 16 (room for that must be there). */
  void (*normals)(uint64_t seed, uint32_t stream, uint32_t purpose, int64_t first, size_t n, double *a,
                  double *b);
  /* From draws 0 and 1 on, n more of each oscillator. */
  void (*oscillate)(oscillators *g, size_t n);
  /* n is a multiple of 8. */
  void (*place)(place_batch *b, size_t n);
  /* sin and cos of 2 pi t[k]; n is rounded up to a multiple of 8. */
  void (*sine_cosine)(const double *t, size_t n, double *sine, double *cosine);
} kernels;

/* The fastest path that this machine runs; SLIPDISK_PATH=baseline|avx2|avx512 asks for another. */
const kernels *kernels_choose(void);
/* A path by name, NULL when it was not built or does not run here. */
const kernels *kernels_named(const char *name);

#endif
