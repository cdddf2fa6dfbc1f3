/* kernel_lanes_motion.c: signals and poses of several systems side by side (lanes_motion.h), one system per lane;
 * compiled once per instruction set.
 */
#include "physics/system/kernel_path.h"
#include "physics/system/kernels.h"
#include "physics/small/lanes_signal.h"

#define LANE_WIDTH VECTOR_WIDTH
#include "base/lane.h"
#include "base/vmath.h"
#include "physics/motion/signal_pass.h"

void KERNEL(kernel_lanes_signal)(lanes_signal *s, int64_t local, size_t n);
void KERNEL(kernel_lanes_place)(const lanes_place *p, size_t n);
bool KERNEL(kernel_lanes_beyond)(const lanes_place *p, size_t n, double limit);

/* Where the values of a signal go: to rows of its own, to the one or two places that it moves, or wherever
 * needed. */
typedef enum sink { OWN_ROWS, ONE_PLACE, TWO_PLACES, MANY } sink;

/* Rows of values and velocities; base: what is added. */
typedef struct target {
  double *value, *velocity;
  size_t stride;
  LANE(real) base;
} target;

LANE_INLINE target rows_of(const lanes_signal *s) {
  return (target){s->room[0], s->room[1], LANE_WIDTH, LANE(splat)(0.0)};
}

LANE_INLINE target place_of(const lanes_place *p) {
  return (target){p->value, p->velocity, p->stride, LANE(load)(p->base)};
}

LANE_INLINE void put_rows(const target *t, size_t k, LANE(real) u, LANE(real) v) {
  LANE(store)(t->value + k * t->stride, u);
  LANE(store)(t->velocity + k * t->stride, v);
}

LANE_INLINE void put_place(const target *t, size_t k, LANE(real) u, LANE(real) v) {
  put_rows(t, k, u + t->base, v);
}

typedef struct targets {
  target first, second;
} targets;

LANE_INLINE targets targets_of(const lanes_signal *s, sink to) {
  targets t;
  t.first = to == OWN_ROWS || to == MANY ? rows_of(s) : place_of(s->places[0]);
  t.second = to == TWO_PLACES ? place_of(s->places[1]) : t.first;
  return t;
}

LANE_INLINE void put(const lanes_signal *s, sink to, const targets *t, size_t k, LANE(real) u, LANE(real) v) {
  if (to == ONE_PLACE || to == TWO_PLACES) put_place(&t->first, k, u, v);
  if (to == TWO_PLACES) put_place(&t->second, k, u, v);
  if (to == OWN_ROWS || (to == MANY && s->elsewhere)) put_rows(&t->first, k, u, v);
  for (size_t n = 0; to == MANY && n < s->n_places; n++) {
    target place = place_of(s->places[n]);
    put_place(&place, k, u, v);
  }
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

LANE_INLINE void harmonic(lanes_signal *s, sink to, int64_t local, int64_t n) {
  const targets where = targets_of(s, to);
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
      put(s, to, &where, (size_t)(at - local), u, v);
    }
  }
}

LANE_INLINE void parabolic(lanes_signal *s, sink to, int64_t local, int64_t n) {
  const targets where = targets_of(s, to);
  LANE(real) a = LANE(load)(s->scale_u), b = LANE(load)(s->scale_v), rate = LANE(load)(s->rate);
  for (int64_t at = local, end = local + n; at < end;) {
    int64_t from = at & ~(int64_t)(WAVE_STEPS - 1);
    set_anchor(s, from, false);
    LANE(real) turns = LANE(load)(s->turns);
    for (; at < from + WAVE_STEPS && at < end; at++) {
      LANE(real) u, v;
      LANE(parabola)(turns + LANE(splat)((double)(at - from)) * rate, a, b, &u, &v);
      put(s, to, &where, (size_t)(at - local), u, v);
    }
  }
}

LANE_INLINE void cubics(const lanes_signal *s, sink to, int64_t local, int64_t n) {
  const targets where = targets_of(s, to);
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
      put(s, to, &where, (size_t)(at - local), u, v);
    }
  }
}

static void steady(const lanes_signal *s, int64_t local, int64_t n) {
  const target rows = rows_of(s);
  LANE(real) c = LANE(load)(s->per_step), v = LANE(load)(s->velocity);
  for (int64_t k = 0; k < n; k++) {
    LANE(real) at = LANE(splat)((double)(local + k)), u = c * at;
    put_rows(&rows, (size_t)k, u, v);
    LANE(store)(s->room[2] + k * LANE_WIDTH, LANE(product_rest)(c, at, u));
  }
}

static void draws(const lanes_signal *s, int64_t local, int64_t n) {
  const target rows = rows_of(s);
  const oscillators *g = s->draws;
  for (int64_t k = 0; k < n; k++)
    put_rows(&rows, (size_t)k, LANE(load)(g->u[local + k - g->base[0]]),
             LANE(load)(g->v[local + k - g->base[0]]));
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

LANE_INLINE void wave_or_cubics(lanes_signal *s, sink to, int64_t local, int64_t n) {
  if (s->kind == SD_MOTION_HARMONIC)
    harmonic(s, to, local, n);
  else if (s->kind == SD_MOTION_PARABOLIC)
    parabolic(s, to, local, n);
  else
    cubics(s, to, local, n);
}

static void compute(lanes_signal *s, int64_t local, int64_t n) {
  if (!s->placed)
    wave_or_cubics(s, OWN_ROWS, local, n);
  else if (s->n_places == 1 && !s->elsewhere)
    wave_or_cubics(s, ONE_PLACE, local, n);
  else if (s->n_places == 2 && !s->elsewhere)
    wave_or_cubics(s, TWO_PLACES, local, n);
  else
    wave_or_cubics(s, MANY, local, n);
}

void KERNEL(kernel_lanes_signal)(lanes_signal *s, int64_t local, size_t n) {
  int fading = fades(s, local);
  bool draws_as_they_are = s->kind == SD_MOTION_RANDOM && s->interval == 1;
  s->u = s->room[0];
  s->v = s->room[1];
  s->low = NULL;
  s->stride = LANE_WIDTH;
  s->placed = !fading && !draws_as_they_are && s->kind != SD_MOTION_VELOCITY && s->n_places > 0;
  if (s->kind == SD_MOTION_VELOCITY) {
    steady(s, local, (int64_t)n);
    s->low = s->room[2];
  } else if (!draws_as_they_are) {
    compute(s, local, (int64_t)n);
  } else if (fading) {
    draws(s, local, (int64_t)n);
  } else { /* where they are */
    s->u = s->draws->u[local - s->draws->base[0]];
    s->v = s->draws->v[local - s->draws->base[0]];
    s->stride = OSCILLATORS;
  }
  if (fading) fade_in(s, local, (int64_t)n);
}

/* As kernel place sums them. */
LANE_INLINE void place_sum(const lanes_place *p, size_t n) {
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
  }
}

void KERNEL(kernel_lanes_place)(const lanes_place *p, size_t n) {
  const lanes_signal *s = p->signals[0];
  if (p->n_signals > 1 || p->turned || s->low) {
    place_sum(p, n);
    return;
  }
  const target to = place_of(p);
  const double *u = s->u, *v = s->v;
  const size_t stride = s->stride;
  for (size_t k = 0; k < n; k++) put_place(&to, k, LANE(load)(u + k * stride), LANE(load)(v + k * stride));
}

bool KERNEL(kernel_lanes_beyond)(const lanes_place *p, size_t n, double limit) {
  LANE(mask) beyond = LANE(all_lanes)(0);
  for (size_t k = 0; k < n; k++) {
    LANE(bits) size = LANE(as_bits)(LANE(load)(p->value + k * p->stride)) & 0x7fffffffffffffffu;
    beyond = beyond | LANE(not )(LANE(within)(LANE(as_real)(size), LANE(splat)(limit)));
  }
  return LANE(any)(beyond);
}
