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
  double *q, *v, *q2, *q3, *q4, *q5;
  const double *force, *constant, *inverse;
} columns;

#define LANE_WIDTH 1
#include "base/lane.h"
#include "physics/integrate_pass.h"
#undef LANE_WIDTH
#define LANE_WIDTH VECTOR_WIDTH
#include "base/lane.h"
#include "physics/integrate_pass.h"

/* The whole vectors of [begin, end), then single lanes. */
#define FOR_LANES(vector, single)                                   \
  do {                                                              \
    size_t i = begin;                                               \
    for (; i + VECTOR_WIDTH <= end; i += VECTOR_WIDTH) vector;      \
    for (; i < end; i++) single;                                    \
  } while (0)

/* pass(columns, i, a, b) over all three coordinates. */
#define FOR_COORDINATES(pass, a, b)                                                                           \
  do {                                                                                                        \
    const sd_state *s = e->state;                                                                             \
    const work *w = &e->work;                                                                                 \
    const columns x = {s->x,  s->vx, s->x2,      s->x3,         s->x4,                                        \
                       s->x5, s->force_x, w->constant_x, w->inverse_mass_x};                                  \
    const columns y = {s->y,  s->vy, s->y2,      s->y3,         s->y4,                                        \
                       s->y5, s->force_y, w->constant_y, w->inverse_mass_y};                                  \
    const columns theta = {s->theta,  s->omega,  s->theta2,          s->theta3,         s->theta4,            \
                           s->theta5, s->torque, w->constant_torque, w->inverse_inertia};                     \
    FOR_LANES(LANE(pass)(&x, i, a, b), LANE_PASTE(pass, 1)(&x, i, a, b));                                     \
    FOR_LANES(LANE(pass)(&y, i, a, b), LANE_PASTE(pass, 1)(&y, i, a, b));                                     \
    FOR_LANES(LANE(pass)(&theta, i, a, b), LANE_PASTE(pass, 1)(&theta, i, a, b));                             \
  } while (0)

LANE_INLINE void note_stale(const engine *e, thread_work *mine, size_t begin, size_t end) {
  int stale = 0;
  FOR_LANES(stale |= LANE(stale)(e, i), stale |= stale_w1(e, i));
  mine->stale = stale != 0;
}

/* Disks whose angle or position must return into its range. */
LANE_INLINE void note_returns(engine *e, thread_work *mine, size_t begin, size_t end) {
  int out = 0;
  FOR_LANES(out |= LANE(out_of_range)(e, i), out |= out_of_range_w1(e, i));
  for (size_t i = begin; out && i < end; i++)
    if (out_of_range_w1(e, i)) event_add(&mine->returns, (uint32_t)i, 0.0);
}

static void gear_predict(engine *e, thread_work *mine, size_t begin, size_t end) {
  FOR_COORDINATES(gear_predict, e->work.dt, e->work.per_dt);
  note_stale(e, mine, begin, end);
}

static void gear_correct(engine *e, thread_work *mine, size_t begin, size_t end) {
  FOR_COORDINATES(gear_correct, e->work.half_dt2, e->work.per_dt);
  note_returns(e, mine, begin, end);
}

static void verlet_predict(engine *e, thread_work *mine, size_t begin, size_t end) {
  FOR_COORDINATES(verlet_predict, e->work.dt, e->work.per_dt);
  note_stale(e, mine, begin, end);
}

static void verlet_correct(engine *e, thread_work *mine, size_t begin, size_t end) {
  FOR_COORDINATES(verlet_correct, e->work.half_dt2, e->work.per_dt);
  note_returns(e, mine, begin, end);
}

extern void KERNEL(kernel_pairs)(engine *e, thread_work *mine, size_t begin, size_t end, int pass);
extern void KERNEL(kernel_normals)(uint64_t seed, uint32_t stream, uint32_t purpose, int64_t first, size_t n,
                                   double *a, double *b);
extern void KERNEL(kernel_oscillate)(oscillators *g, size_t n);
extern void KERNEL(kernel_sine_cosine)(const double *t, size_t n, double *sine, double *cosine);
extern const kernels KERNEL(kernels);

const kernels KERNEL(kernels) = {
    .name = KERNEL_NAME(SD_PATH),
    .pairs = KERNEL(kernel_pairs),
    .predict = {[SD_GEAR5] = gear_predict, [SD_VERLET] = verlet_predict},
    .correct = {[SD_GEAR5] = gear_correct, [SD_VERLET] = verlet_correct},
    .normals = KERNEL(kernel_normals),
    .oscillate = KERNEL(kernel_oscillate),
    .sine_cosine = KERNEL(kernel_sine_cosine),
};
