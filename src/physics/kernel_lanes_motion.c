/* kernel_lanes_motion.c: signals and poses of several systems side by side (lanes_motion.h), one system per lane;
 * compiled once per instruction set.
 */
#include "physics/kernel_path.h"
#include "physics/kernels.h"
#include "physics/lanes_signal.h"

#define LANE_WIDTH VECTOR_WIDTH
#include "base/lane.h"
#include "base/vmath.h"
#include "physics/signal_pass.h"

void KERNEL(kernel_lanes_signal)(lanes_signal *s, int64_t local, size_t n);
void KERNEL(kernel_lanes_place)(lanes_place *p, size_t n);

LANE_INLINE void put(const lanes_signal *s, size_t k, LANE(real) u, LANE(real) v) {
  LANE(store)(s->room[0] + k * LANE_WIDTH, u);
  LANE(store)(s->room[1] + k * LANE_WIDTH, v);
}

/* Brings the anchor to a multiple of WAVE_STEPS. */
LANE_INLINE void set_anchor(lanes_signal *s, int64_t from, bool angles) {
  if (s->anchor == from) return;
  LANE(real)
  t = LANE(turns)(LANE(load)(s->rate_high), LANE(load)(s->rate_low), LANE(load)(s->offset),
                  LANE(splat)((double)from));
  LANE(store)(s->turns, t);
  s->anchor = from;
  if (!angles) return;
  LANE(real) sine, cosine;
  LANE(sine_cosine)(t, &sine, &cosine);
  LANE(store)(s->anchor_sine, sine);
  LANE(store)(s->anchor_cosine, cosine);
}

static void harmonic(lanes_signal *s, int64_t local, int64_t n) {
  LANE(real) scale_u = LANE(load)(s->scale_u), scale_v = LANE(load)(s->scale_v);
  for (int64_t at = local, end = local + n; at < end;) {
    set_anchor(s, at & ~(int64_t)(WAVE_STEPS - 1), true);
    size_t coarse = WAVE_FINE + (size_t)(at % WAVE_STEPS) / WAVE_FINE;
    LANE(real) sine = LANE(load)(s->anchor_sine), cosine = LANE(load)(s->anchor_cosine);
    LANE(turn_on)(&sine, &cosine, LANE(load)(s->sine[coarse]), LANE(load)(s->cosine[coarse]));
    LANE(arm) arm = LANE(arm_of)(sine, cosine, scale_u, scale_v);
    for (int64_t next = (at | (WAVE_FINE - 1)) + 1; at < next && at < end; at++) {
      LANE(real) u, v;
      size_t fine = (size_t)(at % WAVE_FINE);
      LANE(arm_at)(&arm, LANE(load)(s->sine[fine]), LANE(load)(s->cosine[fine]), &u, &v);
      put(s, (size_t)(at - local), u, v);
    }
  }
}

static void parabolic(lanes_signal *s, int64_t local, int64_t n) {
  LANE(real) a = LANE(load)(s->scale_u), b = LANE(load)(s->scale_v), rate = LANE(load)(s->rate);
  for (int64_t at = local, end = local + n; at < end;) {
    int64_t from = at & ~(int64_t)(WAVE_STEPS - 1);
    set_anchor(s, from, false);
    LANE(real) turns = LANE(load)(s->turns);
    for (; at < from + WAVE_STEPS && at < end; at++) {
      LANE(real) u, v;
      LANE(parabola)(turns + LANE(splat)((double)(at - from)) * rate, a, b, &u, &v);
      put(s, (size_t)(at - local), u, v);
    }
  }
}

static void cubics(const lanes_signal *s, int64_t local, int64_t n) {
  const oscillators *g = s->draws;
  LANE(real) h = LANE(load)(s->h), per_h = LANE(load)(s->per_h);
  int64_t m = s->interval, row = local / m - g->base[0];
  for (int64_t at = local, end = local + n, next; at < end; row++) {
    int64_t from = at - at % m;
    next = from + m;
    LANE(cubic)
    p = LANE(cubic_between)(LANE(load)(g->u[row]), LANE(load)(g->v[row]), LANE(load)(g->u[row + 1]),
                            LANE(load)(g->v[row + 1]), h, per_h);
    for (; at < next && at < end; at++) {
      LANE(real) u, v;
      LANE(cubic_at)(&p, LANE(splat)((double)(at - from)) * s->per_interval, &u, &v);
      put(s, (size_t)(at - local), u, v);
    }
  }
}

static void steady(const lanes_signal *s, int64_t local, int64_t n) {
  LANE(real) c = LANE(load)(s->per_step), v = LANE(load)(s->velocity);
  for (int64_t k = 0; k < n; k++) {
    LANE(real) at = LANE(splat)((double)(local + k)), u = c * at;
    put(s, (size_t)k, u, v);
    LANE(store)(s->room[2] + k * LANE_WIDTH, LANE(product_rest)(c, at, u));
  }
}

static void draws(const lanes_signal *s, int64_t local, int64_t n) {
  const oscillators *g = s->draws;
  for (int64_t k = 0; k < n; k++)
    put(s, (size_t)k, LANE(load)(g->u[local + k - g->base[0]]), LANE(load)(g->v[local + k - g->base[0]]));
}

static void fade_in(lanes_signal *s, int64_t local, int64_t n) {
  LANE(real) dt = LANE(load)(s->dt), ramp = LANE(load)(s->ramp);
  for (int64_t k = 0; k < n; k++) {
    double *at_u = s->room[0] + k * LANE_WIDTH, *at_v = s->room[1] + k * LANE_WIDTH,
           *at_low = s->room[2] + k * LANE_WIDTH;
    LANE(real) u = LANE(load)(at_u), v = LANE(load)(at_v);
    LANE(real) r = LANE(fade)(LANE(splat)((double)(local + k)) * dt, ramp, &u, &v);
    LANE(store)(at_u, u);
    LANE(store)(at_v, v);
    if (s->low) LANE(store)(at_low, LANE(load)(at_low) * r);
  }
}

LANE_INLINE int fades(const lanes_signal *s, int64_t local) {
  LANE(real) t = LANE(splat)((double)local) * LANE(load)(s->dt);
  return s->ramped && LANE(any)(LANE(greater)(LANE(load)(s->ramp), t));
}

void KERNEL(kernel_lanes_signal)(lanes_signal *s, int64_t local, size_t n) {
  int fading = fades(s, local);
  s->u = s->room[0];
  s->v = s->room[1];
  s->low = NULL;
  s->stride = LANE_WIDTH;
  switch (s->kind) {
    case SD_MOTION_HARMONIC: harmonic(s, local, (int64_t)n); break;
    case SD_MOTION_PARABOLIC: parabolic(s, local, (int64_t)n); break;
    case SD_MOTION_VELOCITY:
      steady(s, local, (int64_t)n);
      s->low = s->room[2];
      break;
    case SD_MOTION_RANDOM:
      if (s->interval > 1) {
        cubics(s, local, (int64_t)n);
      } else if (fading) {
        draws(s, local, (int64_t)n);
      } else { /* where they are */
        s->u = s->draws->u[local - s->draws->base[0]];
        s->v = s->draws->v[local - s->draws->base[0]];
        s->stride = OSCILLATORS;
      }
      break;
    default: break;
  }
  if (fading) fade_in(s, local, (int64_t)n);
}

/* As kernel place sums them. */
void KERNEL(kernel_lanes_place)(lanes_place *p, size_t n) {
  LANE(real) low = LANE(splat)(HUGE_VAL), high = LANE(splat)(-HUGE_VAL);
  LANE(real) off = LANE(load)(p->off), base = LANE(load)(p->base);
  const lanes_signal *s = p->signals[0];
  for (size_t k = 0; k < n; k++) {
    LANE(real) u = LANE(load)(s->u + k * s->stride), v = LANE(load)(s->v + k * s->stride);
    for (size_t t = 1; t < p->n_signals; t++) {
      u = u + LANE(load)(p->signals[t]->u + k * p->signals[t]->stride);
      v = v + LANE(load)(p->signals[t]->v + k * p->signals[t]->stride);
    }
    u = (u - off) + base;
    for (size_t t = 0; t < p->n_signals; t++)
      if (p->signals[t]->low) u = u + LANE(load)(p->signals[t]->low + k * p->signals[t]->stride);
    LANE(store)(p->value + k * p->stride, u);
    LANE(store)(p->velocity + k * p->stride, v);
    low = LANE(least)(u, low);
    high = LANE(most)(u, high);
  }
  LANE(store)(p->low, low);
  LANE(store)(p->high, high);
}
