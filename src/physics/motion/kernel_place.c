/* kernel_place.c: values of a prescribed coordinate over a batch, from its signals; compiled once per
 * instruction set.
 */
#include "physics/system/kernel_path.h"
#include "physics/system/kernels.h"

#define LANE_WIDTH VECTOR_WIDTH
#include "base/lane.h"

void KERNEL(kernel_place)(place_batch *b, size_t n);

/* Turn and images are taken off before the small parts are added. */
void KERNEL(kernel_place)(place_batch *b, size_t n) {
  LANE(real) low = LANE(splat)(HUGE_VAL), high = LANE(splat)(-HUGE_VAL);
  for (size_t k = 0; k < n; k += LANE_WIDTH) {
    LANE(real) u = LANE(load)(b->signals[0]->u + k), v = LANE(load)(b->signals[0]->v + k);
    for (size_t t = 1; t < b->n_signals; t++) {
      u = u + LANE(load)(b->signals[t]->u + k);
      v = v + LANE(load)(b->signals[t]->v + k);
    }
    u = (u - b->off) + b->base;
    for (size_t t = 0; t < b->n_signals; t++)
      if (b->signals[t]->low) u = u + LANE(load)(b->signals[t]->low + k);
    LANE(store)(b->value + k, u);
    LANE(store)(b->velocity + k, v);
    low = LANE(least)(u, low);
    high = LANE(most)(u, high);
  }
  double lows[LANE_WIDTH], highs[LANE_WIDTH];
  LANE(store)(lows, low);
  LANE(store)(highs, high);
  b->low = lows[0];
  b->high = highs[0];
  for (int l = 1; l < LANE_WIDTH; l++) {
    b->low = lows[l] < b->low ? lows[l] : b->low;
    b->high = highs[l] > b->high ? highs[l] : b->high;
  }
}
