/* kernel_integrate.c: predictor and corrector of both integrators; compiled once per instruction set.
 *
 * Gear, fifth order, Nordsieck form for second-order equations (physics.md 4): column k holds dt^k/k! times
 * the k-th derivative; velocities are kept as such. Velocity Verlet uses column 2 only; its forces see the
 * velocity predicted with the old acceleration.
 */
#include "physics/kernel_path.h"
#include "physics/kernels.h"

/* 3/16 because the forces depend on velocity (Allen & Tildesley, Computer Simulation of Liquids, app. E). */
#define GEAR0 (3.0 / 16.0)
#define GEAR1 (251.0 / 360.0)
#define GEAR3 (11.0 / 18.0)
#define GEAR4 (1.0 / 6.0)
#define GEAR5 (1.0 / 60.0)

typedef struct columns {
  double *restrict q, *restrict v, *restrict q2, *restrict q3, *restrict q4, *restrict q5;
  const double *restrict force, *restrict constant, *restrict inverse;
} columns;

static columns coordinate(engine *e, int c) {
  sd_state *s = e->state;
  const work *w = &e->work;
  if (c == SD_X)
    return (columns){s->x, s->vx, s->x2, s->x3, s->x4, s->x5, s->force_x, w->constant_x, w->inverse_mass_x};
  if (c == SD_Y)
    return (columns){s->y, s->vy, s->y2, s->y3, s->y4, s->y5, s->force_y, w->constant_y, w->inverse_mass_y};
  return (columns){s->theta, s->omega,  s->theta2,          s->theta3,         s->theta4, s->theta5,
                   s->torque, w->constant_torque, w->inverse_inertia};
}

/* A comparison that a coordinate which is not a number also fails. */
static inline bool stale(const engine *e, size_t begin, size_t end) {
  const double *x = e->state->x, *y = e->state->y, *x0 = e->work.x0, *y0 = e->work.y0;
  double limit = e->work.moved_limit2;
  int far = 0;
  for (size_t i = begin; i < end; i++) {
    double dx = x[i] - x0[i], dy = y[i] - y0[i];
    far |= !(dx * dx + dy * dy <= limit);
  }
  return far;
}

static void note_returns(engine *e, thread_work *mine, size_t begin, size_t end) {
  const sd_state *s = e->state;
  const work *w = &e->work;
  int out = 0;
  for (size_t i = begin; i < end; i++) {
    out |= (s->theta[i] > 4.0) | (s->theta[i] < -4.0);
    out |= (s->x[i] < w->lower[0]) | (s->x[i] >= w->upper[0]);
    out |= (s->y[i] < w->lower[1]) | (s->y[i] >= w->upper[1]);
  }
  for (size_t i = begin; out && i < end; i++)
    if (s->theta[i] > 4.0 || s->theta[i] < -4.0 || s->x[i] < w->lower[0] || s->x[i] >= w->upper[0] ||
        s->y[i] < w->lower[1] || s->y[i] >= w->upper[1])
      event_add(&mine->returns, (uint32_t)i, 0.0);
}

static void gear_predict(engine *e, thread_work *mine, size_t begin, size_t end) {
  double dt = e->work.dt, per_dt = 1.0 / dt;
  for (int c = 0; c < SD_COORDINATES; c++) {
    columns k = coordinate(e, c);
    for (size_t i = begin; i < end; i++) {
      double q1 = k.v[i] * dt, q2 = k.q2[i], q3 = k.q3[i], q4 = k.q4[i], q5 = k.q5[i];
      k.q[i] += q1 + (q2 + (q3 + (q4 + q5)));
      k.v[i] += (2.0 * q2 + (3.0 * q3 + (4.0 * q4 + 5.0 * q5))) * per_dt;
      k.q2[i] = q2 + (3.0 * q3 + (6.0 * q4 + 10.0 * q5));
      k.q3[i] = q3 + (4.0 * q4 + 10.0 * q5);
      k.q4[i] = q4 + 5.0 * q5;
    }
  }
  mine->stale = stale(e, begin, end);
}

static void gear_correct(engine *e, thread_work *mine, size_t begin, size_t end) {
  double dt = e->work.dt, per_dt = 1.0 / dt, half_dt2 = 0.5 * dt * dt;
  for (int c = 0; c < SD_COORDINATES; c++) {
    columns k = coordinate(e, c);
    for (size_t i = begin; i < end; i++) {
      double error = half_dt2 * ((k.force[i] + k.constant[i]) * k.inverse[i]) - k.q2[i];
      k.q[i] += GEAR0 * error;
      k.v[i] += GEAR1 * per_dt * error;
      k.q2[i] += error;
      k.q3[i] += GEAR3 * error;
      k.q4[i] += GEAR4 * error;
      k.q5[i] += GEAR5 * error;
    }
  }
  note_returns(e, mine, begin, end);
}

static void verlet_predict(engine *e, thread_work *mine, size_t begin, size_t end) {
  double dt = e->work.dt, per_dt = 1.0 / dt;
  for (int c = 0; c < SD_COORDINATES; c++) {
    columns k = coordinate(e, c);
    for (size_t i = begin; i < end; i++) {
      k.q[i] += k.v[i] * dt + k.q2[i];
      k.v[i] += 2.0 * per_dt * k.q2[i];
    }
  }
  mine->stale = stale(e, begin, end);
}

static void verlet_correct(engine *e, thread_work *mine, size_t begin, size_t end) {
  double dt = e->work.dt, per_dt = 1.0 / dt, half_dt2 = 0.5 * dt * dt;
  for (int c = 0; c < SD_COORDINATES; c++) {
    columns k = coordinate(e, c);
    for (size_t i = begin; i < end; i++) {
      double q2 = half_dt2 * ((k.force[i] + k.constant[i]) * k.inverse[i]);
      k.v[i] += per_dt * (q2 - k.q2[i]);
      k.q2[i] = q2;
    }
  }
  note_returns(e, mine, begin, end);
}

extern void KERNEL(kernel_pairs)(engine *e, thread_work *mine, size_t begin, size_t end, int pass);
extern void KERNEL(kernel_normals)(uint64_t seed, uint32_t stream, uint32_t purpose, int64_t first, size_t n,
                                   double *a, double *b);
extern void KERNEL(kernel_sine_cosine)(const double *t, size_t n, double *sine, double *cosine);
extern const kernels KERNEL(kernels);

const kernels KERNEL(kernels) = {
    .name = KERNEL_NAME(SD_PATH),
    .pairs = KERNEL(kernel_pairs),
    .predict = {[SD_GEAR5] = gear_predict, [SD_VERLET] = verlet_predict},
    .correct = {[SD_GEAR5] = gear_correct, [SD_VERLET] = verlet_correct},
    .normals = KERNEL(kernel_normals),
    .sine_cosine = KERNEL(kernel_sine_cosine),
};
