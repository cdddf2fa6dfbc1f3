/* kernel_lanes.c: steps of small systems in SIMD lanes (lanes.h); compiled once per instruction
 * set.
 *
 * A single system uses vectors of two lanes, both with the same numbers, since scalar code would
 * branch where vectors use masks. Builds with address sanitizer compile only the general variant
 * (KNOWN_SHAPES 0), since the others would take minutes to compile.
 */
#include <assert.h>

#include "physics/system/kernel_path.h"
#include "physics/system/kernels.h"
#include "physics/small/lanes.h"

#if defined(__SANITIZE_ADDRESS__)
#define KNOWN_SHAPES 0
#elif defined(__has_feature)
#if __has_feature(address_sanitizer)
#define KNOWN_SHAPES 0
#endif
#endif
#ifndef KNOWN_SHAPES
#define KNOWN_SHAPES 1
#endif

#define LANE_WIDTH 2
#include "base/lane.h"
#include "physics/step/integrate_pass.h"
#include "physics/contact/contact_step.h"
#define LANES_TEXT any
#define LANES_KNOWN 0
#define LANES_STRAIGHT WALLS_SOME
#include "physics/small/lanes_pass.h"
#undef LANES_TEXT
#undef LANES_KNOWN
#undef LANES_STRAIGHT
#define LANES_TEXT wall
#define LANES_KNOWN 1
#define LANES_STRAIGHT WALLS_ALL
#include "physics/small/lanes_pass.h"
#undef LANES_TEXT
#undef LANES_KNOWN
#undef LANES_STRAIGHT
#define LANES_TEXT three
#define LANES_KNOWN 2
#define LANES_STRAIGHT WALLS_NONE
#include "physics/small/lanes_pass.h"
#if VECTOR_WIDTH > 2
#undef LANE_WIDTH
#define LANE_WIDTH VECTOR_WIDTH
#include "base/lane.h"
#include "physics/step/integrate_pass.h"
#include "physics/contact/contact_step.h"
#include "physics/small/lanes_pass.h"
#undef LANES_TEXT
#undef LANES_KNOWN
#undef LANES_STRAIGHT
#define LANES_TEXT wall
#define LANES_KNOWN 1
#define LANES_STRAIGHT WALLS_ALL
#include "physics/small/lanes_pass.h"
#undef LANES_TEXT
#undef LANES_KNOWN
#undef LANES_STRAIGHT
#define LANES_TEXT any
#define LANES_KNOWN 0
#define LANES_STRAIGHT WALLS_SOME
#include "physics/small/lanes_pass.h"
#endif

void KERNEL(kernel_lanes)(lanes *l, int64_t n);

#define SHAPES(name, width, single)                                                                \
  static void name##_three_gear(lanes *l, int64_t n) {                                             \
    steps_three_w##width(l, n, (shape_three_w##width){1, 2, true, false, 0, single});              \
  }                                                                                                \
  static void name##_three_verlet(lanes *l, int64_t n) {                                           \
    steps_three_w##width(l, n, (shape_three_w##width){1, 2, false, false, 0, single});             \
  }                                                                                                \
  static void name##_wall(lanes *l, int64_t n) {                                                   \
    if (l->gear)                                                                                   \
      steps_wall_w##width(l, n, (shape_wall_w##width){1, 1, true, true, 0, single});               \
    else                                                                                           \
      steps_wall_w##width(l, n, (shape_wall_w##width){1, 1, false, true, 0, single});              \
  }                                                                                                \
  static void name##_any(lanes *l, int64_t n) {                                                    \
    steps_any_w##width(l, n,                                                                       \
                       (shape_any_w##width){l->n_free, l->n_pairs, l->gear, l->conservative,       \
                                            l->features, single});                                 \
  }                                                                                                \
  static void name(lanes *l, int64_t n) {                                                          \
    if (KNOWN_SHAPES && l->n_pairs == 1 && l->straight[0] && !l->features)                         \
      name##_wall(l, n);                                                                           \
    else if (!KNOWN_SHAPES || l->n_free != 1 || l->n_pairs != 2 || l->any_straight ||              \
             l->conservative || l->features)                                                       \
      name##_any(l, n);                                                                            \
    else if (l->gear)                                                                              \
      name##_three_gear(l, n);                                                                     \
    else                                                                                           \
      name##_three_verlet(l, n);                                                                   \
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
  assert(l->width == (l->motion ? VECTOR_WIDTH : 2));
  if (l->motion)
    many(l, n);
  else
    one(l, n);
}
