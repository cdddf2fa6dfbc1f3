/* kernel_integrate.c: predictor and corrector of both integrators; compiled once per instruction set.
 */
#include "physics/kernel_path.h"
#include "physics/kernels.h"

#define LANE_WIDTH 1
#include "base/lane.h"
#include "physics/integrate_pass.h"
#undef LANE_WIDTH
#define LANE_WIDTH VECTOR_WIDTH
#include "base/lane.h"
#include "physics/integrate_pass.h"

/* The whole vectors of [begin, end), then single lanes. */
#define FOR_LANES(vector, single)                                                                            \
  do {                                                                                                       \
    size_t i = begin;                                                                                        \
    for (; i + VECTOR_WIDTH <= end; i += VECTOR_WIDTH) vector;                                               \
    for (; i < end; i++) single;                                                                             \
  } while (0)

/* A function of its own for one coordinate: few columns at a time, so that they stay in registers. */
#define COORDINATE_PASS(pass)                                                                                \
  static __attribute__((noinline)) void pass##_range(const columns *k, size_t begin, size_t end, double a,   \
                                                     double b) {                                             \
    FOR_LANES(LANE(pass##_at)(k, i, a, b), LANE_PASTE(pass##_at, 1)(k, i, a, b));                            \
  }
COORDINATE_PASS(gear_predict)
COORDINATE_PASS(gear_correct)
COORDINATE_PASS(verlet_predict)
COORDINATE_PASS(verlet_correct)

extern void KERNEL(kernel_gather)(engine *e, size_t begin, size_t end);

/* So many disks at a time that what one loop leaves in the cache is there for the next; a multiple of 8. */
enum { BLOCK = 128 };
#define FOR_BLOCKS(first, last, statement)                                                                   \
  for (size_t first = begin; first < end; first += BLOCK) {                                                  \
    const size_t last = first + BLOCK < end ? first + BLOCK : end;                                           \
    statement;                                                                                               \
  }

LANE_INLINE int any_stale(const engine *e, size_t begin, size_t end) {
  int stale = 0;
  FOR_LANES(stale |= LANE(stale)(e, i), stale |= stale_w1(e, i));
  return stale;
}

/* Disks whose angle or position must return into its range. */
LANE_INLINE void note_returns(engine *e, thread_work *mine, size_t begin, size_t end) {
  int out = 0;
  FOR_LANES(out |= LANE(out_of_range)(e, i), out |= out_of_range_w1(e, i));
  for (size_t i = begin; out && i < end; i++)
    if (out_of_range_w1(e, i)) event_add(&mine->returns, (uint32_t)i, 0.0);
}

/* Poses to where the pairs see them. */
static void seat(engine *e, size_t begin, size_t end) { FOR_LANES(LANE(seat_at)(e, i), seat_at_w1(e, i)); }

typedef void coordinate_pass(const columns *k, size_t begin, size_t end, double a, double b);

LANE_INLINE void predict(engine *e, thread_work *mine, size_t begin, size_t end, coordinate_pass *pass) {
  int stale = 0;
  FOR_BLOCKS(i, next, {
    for (int c = 0; c < SD_COORDINATES; c++) pass(&e->work.columns[c], i, next, e->work.dt, e->work.per_dt);
    stale |= any_stale(e, i, next);
    seat(e, i, next);
  })
  mine->stale = stale != 0;
}

LANE_INLINE void correct(engine *e, thread_work *mine, size_t begin, size_t end, coordinate_pass *pass) {
  FOR_BLOCKS(i, next, {
    KERNEL(kernel_gather)(e, i, next);
    for (int c = 0; c < SD_COORDINATES; c++)
      pass(&e->work.columns[c], i, next, e->work.half_dt2, e->work.per_dt);
    note_returns(e, mine, i, next);
    if (e->model->integrator == SD_GEAR5) seat(e, i, next); /* the commit looks again */
  })
}

static void gear_predict(engine *e, thread_work *mine, size_t begin, size_t end) {
  predict(e, mine, begin, end, gear_predict_range);
}
static void gear_correct(engine *e, thread_work *mine, size_t begin, size_t end) {
  correct(e, mine, begin, end, gear_correct_range);
}
static void verlet_predict(engine *e, thread_work *mine, size_t begin, size_t end) {
  predict(e, mine, begin, end, verlet_predict_range);
}
static void verlet_correct(engine *e, thread_work *mine, size_t begin, size_t end) {
  correct(e, mine, begin, end, verlet_correct_range);
}

extern void KERNEL(kernel_pairs)(engine *e, thread_work *mine, size_t begin, size_t end, int pass);
extern void KERNEL(kernel_lanes)(lanes *l, int64_t n);
extern void KERNEL(kernel_normals)(uint64_t seed, uint32_t stream, uint32_t purpose, int64_t first, size_t n,
                                   double *a, double *b);
extern void KERNEL(kernel_oscillate)(oscillators *g, size_t row, size_t blocks);
extern void KERNEL(kernel_spread)(const oscillators *g, size_t n, double (*u)[OSCILLATOR_ROWS],
                                  double (*v)[OSCILLATOR_ROWS]);
extern void KERNEL(kernel_anchors)(wave *w, int64_t from);
extern void KERNEL(kernel_harmonic)(const wave *w, int64_t local, size_t n, double *u, double *v);
extern void KERNEL(kernel_parabolic)(const wave *w, int64_t local, size_t n, double *u, double *v);
extern void KERNEL(kernel_cubics)(const draw_series *d, int64_t local, size_t n, double *u, double *v);
extern void KERNEL(kernel_fade)(double dt, double ramp, int64_t local, size_t n, double *u, double *v,
                                double *low);
extern void KERNEL(kernel_place)(place_batch *b, size_t n);
extern void KERNEL(kernel_lanes_signal)(lanes_signal *s, int64_t local, size_t n);
extern void KERNEL(kernel_lanes_place)(const lanes_place *p, size_t n);
extern bool KERNEL(kernel_lanes_beyond)(const lanes_place *p, size_t n, double limit);
extern void KERNEL(kernel_sine_cosine)(const double *t, size_t n, double *sine, double *cosine);
extern const kernels KERNEL(kernels);

const kernels KERNEL(kernels) = {
    .name = KERNEL_NAME(SD_PATH),
    .pairs = KERNEL(kernel_pairs),
    .lane_width = VECTOR_WIDTH,
    .lanes = KERNEL(kernel_lanes),
    .gather = KERNEL(kernel_gather),
    .seat = seat,
    .predict = {[SD_GEAR5] = gear_predict, [SD_VERLET] = verlet_predict},
    .correct = {[SD_GEAR5] = gear_correct, [SD_VERLET] = verlet_correct},
    .normals = KERNEL(kernel_normals),
    .oscillate = KERNEL(kernel_oscillate),
    .spread = KERNEL(kernel_spread),
    .anchors = KERNEL(kernel_anchors),
    .harmonic = KERNEL(kernel_harmonic),
    .parabolic = KERNEL(kernel_parabolic),
    .cubics = KERNEL(kernel_cubics),
    .fade = KERNEL(kernel_fade),
    .place = KERNEL(kernel_place),
    .lanes_signal = KERNEL(kernel_lanes_signal),
    .lanes_place = KERNEL(kernel_lanes_place),
    .lanes_beyond = KERNEL(kernel_lanes_beyond),
    .sine_cosine = KERNEL(kernel_sine_cosine),
};
