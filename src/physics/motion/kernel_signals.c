/* kernel_signals.c: signals u(t) and prescribed coordinates of one system, with consecutive steps
 * in the vector lanes; and the table of the kernels of physics/motion. Compiled once per
 * instruction set.
 *
 * The exact phase of a wave is known at its anchors, WAVE_STEPS apart; the steps between two
 * anchors are computed as one part. The last vector of a part may write beyond the end of the part;
 * the next part overwrites these values.
 */
#include <assert.h>

#include "physics/motion/motion_kernels.h"
#include "physics/system/kernel_path.h"

#define LANE_WIDTH VECTOR_WIDTH
#include "base/lane.h"
#include "base/vmath.h"
#include "model/waveforms.h"
#include "physics/motion/signal_pass.h"

/* Returns the vector of step numbers at, at + 1, at + 2, ... */
LANE_INLINE LANE(real) steps_from(int64_t at) {
  static const double count[8] = {0, 1, 2, 3, 4, 5, 6, 7};
  return LANE(splat)((double)at) + LANE(load)(count);
}

/* --- waves ------------------------------------------------------------------------------------ */

/* Computes the exact phase of the wave at its two anchors, steps `from` and `from` + WAVE_STEPS. */
static void set_anchors(wave *w, int64_t from) {
  if (w->from == from) return;
  double turns[LANE_WIDTH], sine[LANE_WIDTH], cosine[LANE_WIDTH];
  LANE(real) at = LANE(splat)((double)from) + steps_from(0) * (double)WAVE_STEPS, s, c;
  LANE(real)
  t = LANE(turns)(LANE(splat)(w->rate_high), LANE(splat)(w->rate_low), LANE(splat)(w->offset), at);
  LANE(sine_cosine)(t, &s, &c);
  LANE(store)(turns, t);
  LANE(store)(sine, s);
  LANE(store)(cosine, c);
  for (int k = 0; k < 2; k++) w->anchor[k] = (wave_anchor){turns[k], sine[k], cosine[k]};
  w->from = from;
}

/* Computes a harmonic wave: from the exact phase at an anchor, sine and cosine are rotated by a
 * multiple of WAVE_FINE steps, then by single steps. */
static void rotated(const wave *w, int64_t local, size_t n, double *u, double *v) {
  int64_t from = local & ~(int64_t)(WAVE_FINE - 1), end = local + (int64_t)n;
  for (; from < end; from += WAVE_FINE) {
    const wave_anchor *a = &w->anchor[(from & ~(int64_t)(WAVE_STEPS - 1)) != w->from];
    size_t coarse = (size_t)(from % WAVE_STEPS) / WAVE_FINE;
    LANE(real) s = LANE(splat)(a->sine), c = LANE(splat)(a->cosine);
    LANE(rotate)
    (&s, &c, LANE(splat)(w->sine[WAVE_FINE + coarse]), LANE(splat)(w->cosine[WAVE_FINE + coarse]));
    LANE(phasor) p = LANE(phasor_of)(s, c, LANE(splat)(w->shape[0]), LANE(splat)(w->shape[1]));
    for (int64_t k = 0; k < WAVE_FINE; k += LANE_WIDTH) {
      LANE(real) x, y;
      LANE(phasor_at)(&p, LANE(load)(w->sine + k), LANE(load)(w->cosine + k), &x, &y);
      LANE(store)(u + (from + k - local), x);
      LANE(store)(v + (from + k - local), y);
    }
  }
}

/* Computes a wave that is not harmonic (triangle, pulse and others) from its phase at each step. */
LANE_INLINE void phased(const wave *w, sd_motion_kind form, int64_t local, size_t n, double *u,
                        double *v) {
  LANE(real) shape[WAVE_SHAPE];
  for (int k = 0; k < WAVE_SHAPE; k++) shape[k] = LANE(splat)(w->shape[k]);
  for (int64_t at = local, end = local + (int64_t)n, next; at < end; at = next) {
    int64_t from = at & ~(int64_t)(WAVE_STEPS - 1);
    next = from + WAVE_STEPS;
    LANE(real) anchor = LANE(splat)(w->anchor[from != w->from].turns);
    for (int64_t k = at; k < next && k < end; k += LANE_WIDTH) {
      LANE(real) x, y;
      LANE(wave_at)(form, anchor + steps_from(k - from) * w->rate, shape, &x, &y);
      LANE(store)(u + (k - local), x);
      LANE(store)(v + (k - local), y);
    }
  }
}

static void any_wave(wave *w, int64_t local, size_t n, double *u, double *v) {
  set_anchors(w, local & ~(int64_t)(WAVE_STEPS - 1));
#define ROTATED(kind, ...)                                                                         \
  case kind:                                                                                       \
    rotated(w, local, n, u, v);                                                                    \
    return;
#define PHASED(kind, ...)                                                                          \
  case kind: phased(w, kind, local, n, u, v); return;
  switch (w->form) {
    ROTATED_WAVES(ROTATED)
    PHASED_WAVES(PHASED)
    default: assert(!"a wave");
  }
}

/* --- other signals ---------------------------------------------------------------------------- */

static void cubics(const draw_series *d, int64_t local, size_t n, double *u, double *v) {
  LANE(real) h = LANE(splat)(d->h), per_h = LANE(splat)(d->per_h);
  int64_t m = d->interval, row = local / m - d->base;
  for (int64_t at = local, end = local + (int64_t)n, next; at < end; at = next, row++) {
    int64_t from = at - at % m;
    next = from + m;
    LANE(cubic)
    p = LANE(cubic_between)(LANE(splat)(d->u[row]), LANE(splat)(d->v[row]),
                            LANE(splat)(d->u[row + 1]), LANE(splat)(d->v[row + 1]), h, per_h);
    for (int64_t k = at; k < next && k < end; k += LANE_WIDTH) {
      LANE(real) x, y;
      LANE(cubic_at)(&p, steps_from(k - from) * d->per_interval, &x, &y);
      LANE(store)(u + (k - local), x);
      LANE(store)(v + (k - local), y);
    }
  }
}

static void fade(double dt, double ramp, int64_t local, size_t n, double *u, double *v,
                 double *low) {
  for (size_t k = 0; k < n; k += LANE_WIDTH) {
    LANE(real) x = LANE(load)(u + k), y = LANE(load)(v + k);
    LANE(real) r = LANE(fade)(steps_from(local + (int64_t)k) * dt, LANE(splat)(ramp), &x, &y);
    LANE(store)(u + k, x);
    LANE(store)(v + k, y);
    if (low) LANE(store)(low + k, LANE(load)(low + k) * r);
  }
}

/* --- prescribed coordinates ------------------------------------------------------------------- */

/* Adds the signals of a coordinate. The offset `off` (full turns or periods removed by wrapping) is
 * subtracted before the rounding errors `low` are added, so that `low` is not lost to rounding. */
static void sum(pose_sum *p, size_t n) {
  LANE(real) low = LANE(splat)(HUGE_VAL), high = LANE(splat)(-HUGE_VAL);
  for (size_t k = 0; k < n; k += LANE_WIDTH) {
    LANE(real) u = LANE(load)(p->signals[0]->u + k), v = LANE(load)(p->signals[0]->v + k);
    for (size_t t = 1; t < p->n_signals; t++) {
      u = u + LANE(load)(p->signals[t]->u + k);
      v = v + LANE(load)(p->signals[t]->v + k);
    }
    u = (u - p->off) + p->base;
    for (size_t t = 0; t < p->n_signals; t++)
      if (p->signals[t]->low) u = u + LANE(load)(p->signals[t]->low + k);
    LANE(store)(p->value + k, u);
    LANE(store)(p->velocity + k, v);
    low = LANE(min)(u, low);
    high = LANE(max)(u, high);
  }
  double lows[LANE_WIDTH], highs[LANE_WIDTH];
  LANE(store)(lows, low);
  LANE(store)(highs, high);
  p->low = lows[0];
  p->high = highs[0];
  for (int l = 1; l < LANE_WIDTH; l++) {
    p->low = lows[l] < p->low ? lows[l] : p->low;
    p->high = highs[l] > p->high ? highs[l] : p->high;
  }
}

/* --- table of the kernels --------------------------------------------------------------------- */

extern void KERNEL(kernel_normals)(uint64_t seed, uint32_t stream, uint32_t purpose, int64_t first,
                                   size_t n, double *a, double *b);
extern void KERNEL(kernel_oscillate)(oscillators *g, size_t row, size_t blocks);
extern void KERNEL(kernel_spread)(const oscillators *g, size_t n, double (*u)[OSCILLATOR_ROWS],
                                  double (*v)[OSCILLATOR_ROWS]);
extern void KERNEL(kernel_sine_cosine)(const double *t, size_t n, double *sine, double *cosine);
extern void KERNEL(kernel_lanes_signal)(lanes_signal *s, int64_t local, size_t n);
extern void KERNEL(kernel_lanes_sum)(const lanes_pose *p, size_t n);
extern bool KERNEL(kernel_lanes_beyond)(const lanes_pose *p, size_t n, double limit);
extern const motion_kernels KERNEL(motion_kernels);

const motion_kernels KERNEL(motion_kernels) = {
    .normals = KERNEL(kernel_normals),
    .oscillate = KERNEL(kernel_oscillate),
    .spread = KERNEL(kernel_spread),
    .wave = any_wave,
    .cubics = cubics,
    .fade = fade,
    .sum = sum,
    .lanes_signal = KERNEL(kernel_lanes_signal),
    .lanes_sum = KERNEL(kernel_lanes_sum),
    .lanes_beyond = KERNEL(kernel_lanes_beyond),
    .sine_cosine = KERNEL(kernel_sine_cosine),
};
