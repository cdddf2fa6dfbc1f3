/* kernel_signals.c: signals of one system, steps along the lanes; compiled once per instruction set.
 *
 * Pieces end where the anchor of a signal changes; vectors run over their ends, and the next piece writes there again.
 */
#include "physics/system/kernel_path.h"
#include "physics/system/kernels.h"

#define LANE_WIDTH VECTOR_WIDTH
#include "base/lane.h"
#include "base/vmath.h"
#include "physics/motion/signal_pass.h"

void KERNEL(kernel_anchors)(wave *w, int64_t from);
void KERNEL(kernel_harmonic)(const wave *w, int64_t local, size_t n, double *u, double *v);
void KERNEL(kernel_parabolic)(const wave *w, int64_t local, size_t n, double *u, double *v);
void KERNEL(kernel_cubics)(const draw_series *d, int64_t local, size_t n, double *u, double *v);
void KERNEL(kernel_fade)(double dt, double ramp, int64_t local, size_t n, double *u, double *v, double *low);

LANE_INLINE LANE(real) steps_from(int64_t at) {
  static const double count[8] = {0, 1, 2, 3, 4, 5, 6, 7};
  return LANE(splat)((double)at) + LANE(load)(count);
}

void KERNEL(kernel_anchors)(wave *w, int64_t from) {
  if (w->from == from) return;
  double turns[LANE_WIDTH], sine[LANE_WIDTH], cosine[LANE_WIDTH];
  LANE(real) at = LANE(splat)((double)from) + steps_from(0) * (double)WAVE_STEPS, s, c;
  LANE(real) t = LANE(turns)(LANE(splat)(w->rate_high), LANE(splat)(w->rate_low), LANE(splat)(w->offset), at);
  LANE(sine_cosine)(t, &s, &c);
  LANE(store)(turns, t);
  LANE(store)(sine, s);
  LANE(store)(cosine, c);
  for (int k = 0; k < 2; k++) w->anchor[k] = (wave_anchor){turns[k], sine[k], cosine[k]};
  w->from = from;
}

/* The anchor is exact every 64 steps, and turned on from there: first by eights, then by ones. */
void KERNEL(kernel_harmonic)(const wave *w, int64_t local, size_t n, double *u, double *v) {
  int64_t from = local & ~(int64_t)(WAVE_FINE - 1), end = local + (int64_t)n;
  for (; from < end; from += WAVE_FINE) {
    const wave_anchor *a = &w->anchor[(from & ~(int64_t)(WAVE_STEPS - 1)) != w->from];
    size_t coarse = (size_t)(from % WAVE_STEPS) / WAVE_FINE;
    LANE(real) s = LANE(splat)(a->sine), c = LANE(splat)(a->cosine);
    LANE(turn_on)
    (&s, &c, LANE(splat)(w->sine[WAVE_FINE + coarse]), LANE(splat)(w->cosine[WAVE_FINE + coarse]));
    LANE(arm) arm = LANE(arm_of)(s, c, LANE(splat)(w->scale_u), LANE(splat)(w->scale_v));
    for (int64_t k = 0; k < WAVE_FINE; k += LANE_WIDTH) {
      LANE(real) x, y;
      LANE(arm_at)(&arm, LANE(load)(w->sine + k), LANE(load)(w->cosine + k), &x, &y);
      LANE(store)(u + (from + k - local), x);
      LANE(store)(v + (from + k - local), y);
    }
  }
}

void KERNEL(kernel_parabolic)(const wave *w, int64_t local, size_t n, double *u, double *v) {
  LANE(real) a = LANE(splat)(w->scale_u), b = LANE(splat)(w->scale_v);
  for (int64_t at = local, end = local + (int64_t)n, next; at < end; at = next) {
    int64_t from = at & ~(int64_t)(WAVE_STEPS - 1);
    next = from + WAVE_STEPS;
    LANE(real) anchor = LANE(splat)(w->anchor[from != w->from].turns);
    for (int64_t k = at; k < next && k < end; k += LANE_WIDTH) {
      LANE(real) x, y;
      LANE(parabola)(anchor + steps_from(k - from) * w->rate, a, b, &x, &y);
      LANE(store)(u + (k - local), x);
      LANE(store)(v + (k - local), y);
    }
  }
}

void KERNEL(kernel_cubics)(const draw_series *d, int64_t local, size_t n, double *u, double *v) {
  LANE(real) h = LANE(splat)(d->h), per_h = LANE(splat)(d->per_h);
  int64_t m = d->interval, row = local / m - d->base;
  for (int64_t at = local, end = local + (int64_t)n, next; at < end; at = next, row++) {
    int64_t from = at - at % m;
    next = from + m;
    LANE(cubic)
    p = LANE(cubic_between)(LANE(splat)(d->u[row]), LANE(splat)(d->v[row]), LANE(splat)(d->u[row + 1]),
                            LANE(splat)(d->v[row + 1]), h, per_h);
    for (int64_t k = at; k < next && k < end; k += LANE_WIDTH) {
      LANE(real) x, y;
      LANE(cubic_at)(&p, steps_from(k - from) * d->per_interval, &x, &y);
      LANE(store)(u + (k - local), x);
      LANE(store)(v + (k - local), y);
    }
  }
}

void KERNEL(kernel_fade)(double dt, double ramp, int64_t local, size_t n, double *u, double *v, double *low) {
  for (size_t k = 0; k < n; k += LANE_WIDTH) {
    LANE(real) x = LANE(load)(u + k), y = LANE(load)(v + k);
    LANE(real) r = LANE(fade)(steps_from(local + (int64_t)k) * dt, LANE(splat)(ramp), &x, &y);
    LANE(store)(u + k, x);
    LANE(store)(v + k, y);
    if (low) LANE(store)(low + k, LANE(load)(low + k) * r);
  }
}
