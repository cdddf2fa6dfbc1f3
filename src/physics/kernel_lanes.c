/* kernel_lanes.c: steps of small systems in lanes (lanes.h); compiled once per instruction set.
 */
#include "physics/kernel_path.h"
#include "physics/kernels.h"
#include "physics/lanes.h"

#define LANE_WIDTH 2
#include "base/lane.h"
#include "physics/integrate_pass.h"
#include "physics/law.h"
#include "physics/lanes_pass.h"
#if VECTOR_WIDTH > 2
#undef LANE_WIDTH
#define LANE_WIDTH VECTOR_WIDTH
#include "base/lane.h"
#include "physics/integrate_pass.h"
#include "physics/law.h"
#include "physics/lanes_pass.h"
#endif

void KERNEL(kernel_lanes)(lanes *l, int64_t n);

/* Disk on two supports, the paper's variant: what is known here costs nothing in the loop. One system by itself fills
 * both lanes of the narrowest vector: scalar code would have branches where vectors have masks. */
#define SHAPES(name, width, single)                                                                          \
  static void name##_gear(lanes *l, int64_t n) {                                                             \
    steps_w##width(l, n, (shape_w##width){1, 2, true, false, single});                                       \
  }                                                                                                          \
  static void name##_verlet(lanes *l, int64_t n) {                                                           \
    steps_w##width(l, n, (shape_w##width){1, 2, false, false, single});                                      \
  }                                                                                                          \
  static void name##_general(lanes *l, int64_t n) {                                                          \
    steps_w##width(l, n, (shape_w##width){l->n_free, l->n_pairs, l->gear, l->conservative, single});         \
  }                                                                                                          \
  static void name(lanes *l, int64_t n) {                                                                    \
    if (l->n_free != 1 || l->n_pairs != 2 || l->conservative)                                                \
      name##_general(l, n);                                                                                  \
    else if (l->gear)                                                                                        \
      name##_gear(l, n);                                                                                     \
    else                                                                                                     \
      name##_verlet(l, n);                                                                                   \
  }
SHAPES(one, 2, true)
#if VECTOR_WIDTH == 8
SHAPES(many, 8, false)
#elif VECTOR_WIDTH == 4
SHAPES(many, 4, false)
#else
SHAPES(many, 2, false)
#endif

void KERNEL(kernel_lanes)(lanes *l, int64_t n) {
  if (l->motion)
    many(l, n);
  else
    one(l, n);
}
