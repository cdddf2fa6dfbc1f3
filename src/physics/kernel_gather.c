/* kernel_gather.c: sums over the contacts of each body, in order of the partners' permanent ids, so that the
 * bits depend neither on the threads nor on what else is a candidate; compiled once per instruction set.
 */
#include "physics/kernel_path.h"
#include "physics/kernels.h"

#define LANE_WIDTH 1
#include "base/lane.h"
#undef LANE_WIDTH
#define LANE_WIDTH 4
#include "base/lane.h"

void KERNEL(kernel_gather)(engine *e, size_t begin, size_t end);

/* A row of PUSH_ROW numbers. */
LANE_INLINE real_w4 sum_of(const incidence *n, size_t i) {
  real_w4 sum = splat_w4(0.0);
  for (size_t at = n->start[i]; at < n->start[i + 1]; at++) sum = sum + load_w4(n->push + PUSH_ROW * at);
  return sum;
}

void KERNEL(kernel_gather)(engine *e, size_t begin, size_t end) {
  sd_state *s = e->state;
  const incidence *n = &e->work.incidence;
  for (size_t i = begin; i < end; i++) {
    real_w4 sum = sum_of(n, i);
    s->force_x[i] = sum[PUSH_X];
    s->force_y[i] = sum[PUSH_Y];
    s->torque[i] = s->radius[i] != 0.0 ? sum[PUSH_TURN] * s->radius[i] : sum[PUSH_TURN];
  }
}
