/* kernel_integrate.c: predictor and corrector of both integrators; compiled once per instruction
 * set. */
#include "model/field_kinds.h"
#include "physics/system/bodies.h"
#include "physics/system/fields.h"
#include "physics/system/kernel_path.h"
#include "physics/system/kernels.h"
#include "physics/contact/pairs.h"
#include "physics/neighbours/neighbours.h"

#define LANE_WIDTH 1
#include "base/lane.h"
#include "physics/step/integrate_pass.h"
#include "physics/step/field_pass.h"
#undef LANE_WIDTH
#define LANE_WIDTH VECTOR_WIDTH
#include "base/lane.h"
#include "physics/step/integrate_pass.h"
#include "physics/step/field_pass.h"

/* Runs `vector` for every full vector of slots in [begin, end), then `single` for each remaining
 * slot. */
#define FOR_LANES(vector, single)                                                                  \
  do {                                                                                             \
    size_t i = begin;                                                                              \
    for (; i + VECTOR_WIDTH <= end; i += VECTOR_WIDTH) vector;                                     \
    for (; i < end; i++) single;                                                                   \
  } while (0)

static void pack_alike(engine *e, size_t begin, size_t end, bool prescribed) {
  view v = view_of(e, begin);
  if (prescribed) {
    v.mass = NULL;
    v.omega = e->state->omega;
  }
  FOR_LANES((LANE(pack_at)(&v, i), LANE(clear_sum)(&v, i)),
            (pack_at_w1(&v, i), clear_sum_w1(&v, i)));
}

/* Writes the rows of packed bodies (work.packed, the data that pairs read) in slots [begin, end).
 * Prescribed bodies get the inverse mass 0 (an infinite mass), ghosts that of their own mass. */
static void pack(engine *e, size_t begin, size_t end) {
  const sd_state *s = e->state;
  const size_t first = s->n_free + s->n_ghosts, middle = begin > first ? begin
                                                         : end < first ? end
                                                                       : first;
  pack_alike(e, begin, middle, false);
  pack_alike(e, middle, end, true);
  for (size_t i = s->n_surfaces && begin < s->n_disks ? s->n_disks : begin;
       s->n_surfaces && i < end; i++)
    body_pack(e, i);
}

static bool stale(const engine *e, size_t begin, size_t end, double ahead) {
  const view v = view_of(e, begin);
  int any = 0;
  FOR_LANES(any |= LANE(stale_at)(&v, i, ahead), any |= stale_at_w1(&v, i, ahead));
  return any != 0;
}

LANE_INLINE void predict(const engine *e, size_t begin, size_t end, const int gear) {
  const view v = view_of(e, begin);
  FOR_LANES(LANE(predict_at)(&v, i, gear), predict_at_w1(&v, i, gear));
}

/* Corrects free disks in slots [begin, end). Lists disks whose angle or position must be wrapped in
 * mine->returns, and sets mine->fast if a disk is too fast. */
LANE_INLINE void correct(engine *e, thread_work *mine, size_t begin, size_t end, const int gear,
                         const body_forces *acting) {
  const view v = view_of(e, begin);
  sums_add_listed(e, begin, end);
  int out = 0, stale = 0;
  FOR_LANES(out |= LANE(correct_at)(&v, i, gear, acting, &stale),
            out |= correct_at_w1(&v, i, gear, acting, &stale));
  if (stale) mine->stale = true;
  for (size_t i = begin; out && i < end; i++) {
    if (out_of_range_w1(&v, v.k[SD_X].q[i], v.k[SD_Y].q[i], v.k[SD_THETA].q[i]))
      event_add(&mine->returns, (uint32_t)i);
    if (is_fast_at_w1(&v, i, v.k[SD_X].v[i], v.k[SD_Y].v[i])) mine->fast = true;
  }
}

static void gear_predict(engine *e, size_t begin, size_t end) { predict(e, begin, end, 1); }
static void gear_correct(engine *e, thread_work *mine, size_t begin, size_t end) {
  if (e->work.body_forces)
    correct(e, mine, begin, end, 1, e->work.body_forces);
  else
    correct(e, mine, begin, end, 1, NULL);
}
static void verlet_predict(engine *e, size_t begin, size_t end) { predict(e, begin, end, 0); }
static void verlet_correct(engine *e, thread_work *mine, size_t begin, size_t end) {
  if (e->work.body_forces)
    correct(e, mine, begin, end, 0, e->work.body_forces);
  else
    correct(e, mine, begin, end, 0, NULL);
}

/* Recomputes the forces of the model's fields on the free disks in slots [begin, end). They
 * depend on the coordinates and, for damping, on the contact forces, which the state holds. */
static void renew_fields(engine *e, size_t begin, size_t end) {
  const view v = view_of(e, begin);
  FOR_LANES(LANE(field_renew)(e->work.body_forces, &v, i),
            field_renew_w1(e->work.body_forces, &v, i));
}

/* Adds up the contact forces on bodies in slots [begin, end), of any kind, and stores them in the
 * state. Treats one body at a time, without vectors, since prescribed bodies are few. */
static void gather(engine *e, size_t begin, size_t end) {
  view v = view_of(e, begin);
  v.show = true;
  sums_add_listed(e, begin, end);
  for (size_t i = begin; i < end; i++) {
    const double *row = v.sums + SUM_ROW * (i + v.shift), radius = v.radius[i],
                 turn = row[SUM_TORQUE];
    double sum[SD_COORDINATES], slide = radius > 0.0   ? turn
                                        : radius < 0.0 ? -turn
                                                       : row[SUM_SURFACE];
    take_sum_w1(&v, i, sum);
    if (radius == 0.0) v.k[SD_THETA].force[i] = turn;
    if (i >= e->state->n_disks && e->state->n_surfaces > 0)
      e->state->surface_force[i - e->state->n_disks] = slide;
  }
}

extern void KERNEL(kernel_pairs)(engine *e, thread_work *mine, size_t begin, size_t end);
extern void KERNEL(kernel_lanes)(lanes *l, int64_t n);
extern const motion_kernels KERNEL(motion_kernels);
extern const kernels KERNEL(kernels);

const kernels KERNEL(kernels) = {
    .name = KERNEL_NAME(SD_PATH),
    .pairs = KERNEL(kernel_pairs),
    .lane_width = VECTOR_WIDTH,
    .lanes = KERNEL(kernel_lanes),
    .gather = gather,
    .pack = pack,
    .stale = stale,
    .fields = renew_fields,
    .predict = {[SD_GEAR5] = gear_predict, [SD_VERLET] = verlet_predict},
    .correct = {[SD_GEAR5] = gear_correct, [SD_VERLET] = verlet_correct},
    .motion = &KERNEL(motion_kernels),
};
