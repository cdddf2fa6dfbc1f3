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

void KERNEL(kernel_lanes)(lanes *const *l, size_t vectors, int64_t n);

/* Disk on two supports, the paper's variant: what is known here costs nothing in the loop. One system by itself fills
 * both lanes of the narrowest vector: scalar code would have branches where vectors have masks. */
#define SHAPES(name, width, vectors, single)                                                                 \
  static void name##_gear(lanes *const *l, int64_t n) {                                                      \
    steps_w##width(l, vectors, n, (shape_w##width){1, 2, true, false, single});                              \
  }                                                                                                          \
  static void name##_verlet(lanes *const *l, int64_t n) {                                                    \
    steps_w##width(l, vectors, n, (shape_w##width){1, 2, false, false, single});                             \
  }                                                                                                          \
  static void name(lanes *const *l, int64_t n) {                                                             \
    const lanes *a = l[0];                                                                                   \
    if (a->n_free != 1 || a->n_pairs != 2 || a->conservative)                                                \
      for (size_t v = 0; v < (vectors); v++)                                                                 \
        steps_w##width(l + v, 1, n,                                                                          \
                       (shape_w##width){a->n_free, a->n_pairs, a->gear, a->conservative, single});           \
    else if (a->gear)                                                                                        \
      name##_gear(l, n);                                                                                     \
    else                                                                                                     \
      name##_verlet(l, n);                                                                                   \
  }
SHAPES(alone, 2, 1, true)
#if VECTOR_WIDTH == 8
SHAPES(one, 8, 1, false)
SHAPES(two, 8, 2, false)
#elif VECTOR_WIDTH == 4
SHAPES(one, 4, 1, false)
SHAPES(two, 4, 2, false)
#else
SHAPES(one, 2, 1, false)
SHAPES(two, 2, 2, false)
#endif

void KERNEL(kernel_lanes)(lanes *const *l, size_t vectors, int64_t n) {
  if (!l[0]->motion)
    alone(l, n);
  else if (vectors == 1)
    one(l, n);
  else
    two(l, n);
}
