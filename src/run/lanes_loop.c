/* lanes_loop.c: see lanes_loop.h. */
#include "run/lanes_loop.h"

#include <assert.h>

#include "measure/sample.h"
#include "physics/motion/motion.h"
#include "physics/step/access.h"
#include "physics/step/step.h"

static int64_t least_room(const lanes *l) {
  int64_t least = INT64_MAX;
  for (size_t k = 0; k < l->count; k++) {
    int64_t room = sample_room(l->system[k]);
    if (room < least) least = room;
  }
  return least;
}

/* An angle leaves its range, or a batch of motions cannot tell: one step of each system by itself. */
static void general_step(lanes *l, bool measure) {
  const team alone = {.size = 1};
  lanes_store(l);
  for (size_t k = 0; k < l->count; k++) {
    engine *e = l->system[k];
    if (engine_status(e) != SD_OK) continue;
    if (l->motion) motion_resume(e);
    step_begin(e, 1);
    step_once(e, &alone);
    if (engine_status(e) == SD_OK && measure) sample_step(e);
    if (l->motion) motion_store(e);
  }
}

static bool any_wrong(const lanes *l) {
  bool wrong = false;
  for (size_t k = 0; k < l->count; k++) wrong = wrong || engine_status(l->system[k]) != SD_OK;
  return wrong;
}

static void close_bins(const lanes *l) {
  lanes_show_angles(l);
  for (size_t k = 0; k < l->count; k++)
    if (engine_status(l->system[k]) == SD_OK) sample_bins(l->system[k]);
}

void lanes_loop(lanes *l, int64_t n, bool measure) {
  lanes_load(l);
  while (n > 0) {
    int64_t now = lanes_ready(l), room = measure ? least_room(l) : INT64_MAX;
    if (now == 0) {
      general_step(l, measure);
      n--;
      if (any_wrong(l)) return;
      lanes_load(l);
      continue;
    }
    assert(now > 0 && room > 0);
    if (now > room) now = room;
    int64_t taken = lanes_take(l, n < now ? n : now, measure);
    n -= taken;
    assert(n >= 0 && taken <= room);
    if (measure && taken == room) close_bins(l);
    if (any_wrong(l)) break;
  }
  lanes_store(l);
}
