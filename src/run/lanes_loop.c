/* lanes_loop.c: see lanes_loop.h. */
#include "run/lanes_loop.h"

#include "measure/watch.h"
#include "physics/motion.h"
#include "physics/step.h"

static int64_t least_room(const lanes *l) {
  int64_t least = INT64_MAX;
  for (size_t k = 0; k < l->count; k++) {
    int64_t room = watch_room(l->system[k]);
    if (room < least) least = room;
  }
  return least;
}

/* An angle leaves its range, or a batch of motions cannot tell: one step of each system by itself. */
static void general_step(lanes *l, bool measure) {
  const team alone = {0, 1};
  lanes_store(l);
  for (size_t k = 0; k < l->count; k++) {
    engine *e = l->system[k];
    if (e->work.status != SD_OK) continue;
    if (l->motion && motion_resume(e) != SD_OK)
      e->work.status = sd_fail(e->work.messages, SD_ERROR_IO, "out of memory for the motions");
    if (e->work.status == SD_OK) step_once(e, &alone);
    if (e->work.status == SD_OK && measure) watch_step(e);
    if (l->motion) motion_store(e);
  }
}

static bool any_wrong(const lanes *l) {
  bool wrong = false;
  for (size_t k = 0; k < l->count; k++) wrong = wrong || l->system[k]->work.status != SD_OK;
  return wrong;
}

static void close_bins(const lanes *l) {
  lanes_show_angles(l);
  for (size_t k = 0; k < l->count; k++)
    if (l->system[k]->work.status == SD_OK) watch_bins(l->system[k]);
}

void lanes_loop(lanes *const *l, size_t vectors, int64_t n, bool measure) {
  bool wrong = false;
  for (size_t v = 0; v < vectors; v++) lanes_load(l[v]);
  while (n > 0 && !wrong) {
    int64_t now = n, room = INT64_MAX;
    for (size_t v = 0; v < vectors; v++) {
      int64_t ready = lanes_ready(l[v]), bin = measure ? least_room(l[v]) : INT64_MAX;
      now = ready < now ? ready : now;
      room = bin < room ? bin : room;
    }
    if (now == 0) {
      for (size_t v = 0; v < vectors; v++) general_step(l[v], measure);
      n--;
    } else {
      now = room < now ? room : now;
      n -= lanes_take(l, vectors, now, measure);
      for (size_t v = 0; v < vectors && measure && now == room; v++) close_bins(l[v]);
    }
    for (size_t v = 0; v < vectors; v++) wrong = wrong || any_wrong(l[v]);
    for (size_t v = 0; v < vectors && now == 0 && !wrong; v++) lanes_load(l[v]);
    if (wrong && now == 0) return;
  }
  for (size_t v = 0; v < vectors; v++) lanes_store(l[v]);
}
