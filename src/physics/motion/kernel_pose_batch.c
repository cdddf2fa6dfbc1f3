/* kernel_pose_batch.c: signals u(t) and prescribed poses of several systems, one system per vector
 * lane; compiled once per instruction set.
 */
#include <assert.h>

#include "physics/motion/pose_batch.h"
#include "physics/system/kernel_path.h"

#define LANE_WIDTH VECTOR_WIDTH
#include "base/lane.h"
#include "base/vmath.h"
#include "model/waveforms.h"
#include "physics/motion/signal_pass.h"

void KERNEL(kernel_lanes_signal)(lanes_signal *s, int64_t local, size_t n);
void KERNEL(kernel_lanes_sum)(const lanes_pose *p, size_t n);
bool KERNEL(kernel_lanes_beyond)(const lanes_pose *p, size_t n, double limit);

/* Destination of the values of a signal: memory of the signal itself, one or two poses that only
 * this signal moves, or several poses and possibly its own memory, too. */
typedef enum sink { OWN_ROWS, ONE_POSE, TWO_POSES, MANY } sink;

/* Memory that values and velocities are written to, `stride` numbers per step. base: number added
 * to the values. */
typedef struct target {
  double *value, *velocity;
  size_t stride;
  LANE(real) base;
} target;

LANE_INLINE target rows_of(const lanes_signal *s) {
  return (target){s->rows[0], s->rows[1], LANE_WIDTH, LANE(splat)(0.0)};
}

LANE_INLINE target pose_of(const lanes_pose *p) {
  return (target){p->value, p->velocity, p->stride, LANE(load)(p->base)};
}

LANE_INLINE void put_rows(const target *t, size_t k, LANE(real) u, LANE(real) v) {
  LANE(store)(t->value + k * t->stride, u);
  LANE(store)(t->velocity + k * t->stride, v);
}

LANE_INLINE void put_pose(const target *t, size_t k, LANE(real) u, LANE(real) v) {
  put_rows(t, k, u + t->base, v);
}

typedef struct targets {
  target first, second;
} targets;

LANE_INLINE targets targets_of(const lanes_signal *s, sink to) {
  targets t;
  t.first = to == OWN_ROWS || to == MANY ? rows_of(s) : pose_of(s->alone[0]);
  t.second = to == TWO_POSES ? pose_of(s->alone[1]) : t.first;
  return t;
}

/* Writes displacement u and velocity v at step k of the steps computed ahead to all destinations of
 * the signal. */
LANE_INLINE void put(const lanes_signal *s, sink to, const targets *t, size_t k, LANE(real) u,
                     LANE(real) v) {
  if (to == ONE_POSE || to == TWO_POSES) put_pose(&t->first, k, u, v);
  if (to == TWO_POSES) put_pose(&t->second, k, u, v);
  if (to == OWN_ROWS || (to == MANY && s->shared)) put_rows(&t->first, k, u, v);
  for (size_t n = 0; to == MANY && n < s->n_alone; n++) {
    target pose = pose_of(s->alone[n]);
    put_pose(&pose, k, u, v);
  }
}

/* Computes the phase of a wave at step `from`, a multiple of WAVE_STEPS. angles: true to compute
 * sine and cosine of the phase, too. */
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

/* Computes a harmonic wave: the phase is known exactly every WAVE_STEPS steps; from there sine and
 * cosine are rotated by a multiple of WAVE_FINE steps, then by single steps. */
LANE_INLINE void rotated(lanes_signal *s, sink to, int64_t local, int64_t n) {
  const targets where = targets_of(s, to);
  LANE(real) scale_u = LANE(load)(s->shape[0]), scale_v = LANE(load)(s->shape[1]);
  for (int64_t at = local, end = local + n; at < end;) {
    set_anchor(s, at & ~(int64_t)(WAVE_STEPS - 1), true);
    size_t coarse = WAVE_FINE + (size_t)(at % WAVE_STEPS) / WAVE_FINE;
    LANE(real) sine = LANE(load)(s->anchor_sine), cosine = LANE(load)(s->anchor_cosine);
    LANE(rotate)(&sine, &cosine, LANE(load)(s->sine[coarse]), LANE(load)(s->cosine[coarse]));
    LANE(phasor) p = LANE(phasor_of)(sine, cosine, scale_u, scale_v);
    for (int64_t next = (at | (WAVE_FINE - 1)) + 1; at < next && at < end; at++) {
      LANE(real) u, v;
      size_t fine = (size_t)(at % WAVE_FINE);
      LANE(phasor_at)(&p, LANE(load)(s->sine[fine]), LANE(load)(s->cosine[fine]), &u, &v);
      put(s, to, &where, (size_t)(at - local), u, v);
    }
  }
}

LANE_INLINE void phased(lanes_signal *s, sd_motion_kind form, sink to, int64_t local, int64_t n) {
  const targets where = targets_of(s, to);
  LANE(real) rate = LANE(load)(s->rate), shape[WAVE_SHAPE];
  for (int k = 0; k < WAVE_SHAPE; k++) shape[k] = LANE(load)(s->shape[k]);
  for (int64_t at = local, end = local + n; at < end;) {
    int64_t from = at & ~(int64_t)(WAVE_STEPS - 1);
    set_anchor(s, from, false);
    LANE(real) turns = LANE(load)(s->turns);
    for (; at < from + WAVE_STEPS && at < end; at++) {
      LANE(real) u, v;
      LANE(wave_at)(form, turns + LANE(splat)((double)(at - from)) * rate, shape, &u, &v);
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
    LANE(store)(s->rows[2] + k * LANE_WIDTH, LANE(product_rest)(c, at, u));
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
    double *at_u = s->rows[0] + k * LANE_WIDTH, *at_v = s->rows[1] + k * LANE_WIDTH,
           *at_low = s->rows[2] + k * LANE_WIDTH;
    LANE(real) u = LANE(load)(at_u), v = LANE(load)(at_v);
    LANE(real) r = LANE(fade)(LANE(splat)((double)(local + k)) * dt, ramp, &u, &v);
    LANE(store)(at_u, u);
    LANE(store)(at_v, v);
    if (s->low) LANE(store)(at_low, LANE(load)(at_low) * r);
  }
}

/* Returns not 0 if the signal still fades in at step `local` in some lane. */
LANE_INLINE int fades(const lanes_signal *s, int64_t local) {
  LANE(real) t = LANE(splat)((double)local) * LANE(load)(s->dt);
  return s->ramped && LANE(any)(LANE(greater)(LANE(load)(s->ramp), t));
}

LANE_INLINE void any_wave(lanes_signal *s, sink to, int64_t local, int64_t n) {
#define ROTATED(kind, ...)                                                                         \
  case kind:                                                                                       \
    rotated(s, to, local, n);                                                                      \
    return;
#define PHASED(kind, ...)                                                                          \
  case kind: phased(s, kind, to, local, n); return;
  switch (s->form) {
    ROTATED_WAVES(ROTATED)
    PHASED_WAVES(PHASED)
    default: assert(!"a wave");
  }
}

LANE_INLINE void wave_or_cubics(lanes_signal *s, sink to, int64_t local, int64_t n) {
  if (s->source == SIGNAL_WAVE)
    any_wave(s, to, local, n);
  else
    cubics(s, to, local, n);
}

static void wave_or_cubics_to(lanes_signal *s, int64_t local, int64_t n) {
  if (!s->posed)
    wave_or_cubics(s, OWN_ROWS, local, n);
  else if (s->n_alone == 1 && !s->shared)
    wave_or_cubics(s, ONE_POSE, local, n);
  else if (s->n_alone == 2 && !s->shared)
    wave_or_cubics(s, TWO_POSES, local, n);
  else
    wave_or_cubics(s, MANY, local, n);
}

/* Computes a random signal. If there is a random step in every time step and no fading, u and v are
 * not copied but point to the rows of the oscillators. */
static void draws_or_cubics(lanes_signal *s, bool fading, int64_t local, int64_t n) {
  if (s->interval > 1) {
    s->posed = !fading && s->n_alone > 0;
    wave_or_cubics_to(s, local, n);
  } else if (fading) {
    draws(s, local, n);
  } else {
    s->u = s->draws->u[local - s->draws->base[0]];
    s->v = s->draws->v[local - s->draws->base[0]];
    s->stride = OSCILLATORS;
  }
}

void KERNEL(kernel_lanes_signal)(lanes_signal *s, int64_t local, size_t n) {
  bool fading = fades(s, local);
  s->u = s->rows[0];
  s->v = s->rows[1];
  s->low = NULL;
  s->stride = LANE_WIDTH;
  s->posed = false;
  switch (s->source) {
    case SIGNAL_STEADY:
      steady(s, local, (int64_t)n);
      s->low = s->rows[2];
      break;
    case SIGNAL_WAVE:
      s->posed = !fading && s->n_alone > 0;
      wave_or_cubics_to(s, local, (int64_t)n);
      break;
    case SIGNAL_RANDOM: draws_or_cubics(s, fading, local, (int64_t)n); break;
    case SIGNAL_TABLE:
    case SIGNAL_FEEDBACK: assert(!"filled system by system, or not in lanes");
  }
  if (fading) fade_in(s, local, (int64_t)n);
}

/* Adds the signals of a coordinate. The order of summation is that of `sum` in kernel_signals.c, so
 * both give the same bits. */
LANE_INLINE void sum_signals(const lanes_pose *p, size_t n) {
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

void KERNEL(kernel_lanes_sum)(const lanes_pose *p, size_t n) {
  const lanes_signal *s = p->signals[0];
  if (p->n_signals > 1 || p->turned || s->low) {
    sum_signals(p, n);
    return;
  }
  const target to = pose_of(p);
  const double *u = s->u, *v = s->v;
  const size_t stride = s->stride;
  for (size_t k = 0; k < n; k++)
    put_pose(&to, k, LANE(load)(u + k * stride), LANE(load)(v + k * stride));
}

bool KERNEL(kernel_lanes_beyond)(const lanes_pose *p, size_t n, double limit) {
  LANE(mask) beyond = LANE(all_lanes)(0);
  for (size_t k = 0; k < n; k++) {
    LANE(bits) size = LANE(as_bits)(LANE(load)(p->value + k * p->stride)) & 0x7fffffffffffffffu;
    beyond = beyond | LANE(not )(LANE(within)(LANE(as_real)(size), LANE(splat)(limit)));
  }
  return LANE(any)(beyond);
}
