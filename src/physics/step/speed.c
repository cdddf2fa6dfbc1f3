/* speed.c: the displacement limit; implements speed_begin and speed_check of step.h. */
#include "physics/step/step.h"

#include <assert.h>
#include <math.h>

#include "model/model.h"
#include "model/motions.h"
#include "physics/motion/motion.h"

void speed_begin(engine *e) {
  work *w = &e->work;
  const double limit = e->model->limits.displacement * w->per_dt;
  const bool compare = limit > 0.0 && e->state->fast_step < 0;
  w->speed_limit2 = compare ? limit * limit : HUGE_VAL;
  w->compare_motions = compare && strides_are_long(e->model);
}

/* Finds the fastest free disk that exceeds the displacement limit, and sets *disk to its slot.
 * Returns its displacement per step divided by its radius; 0 if there is no such disk. */
static double fastest_disk(const engine *e, size_t *disk) {
  const sd_state *s = e->state;
  double fastest = 0.0;
  for (size_t i = 0; i < s->n_free; i++) {
    double v2 = s->vx[i] * s->vx[i] + s->vy[i] * s->vy[i], r2 = s->radius[i] * s->radius[i];
    if (!(v2 > r2 * e->work.speed_limit2)) continue;
    /* of disks with equal speed, take the one in the lowest slot */
    if (!(v2 / r2 > fastest)) continue;
    fastest = v2 / r2;
    *disk = i;
  }
  return sqrt(fastest) * e->work.dt;
}

void speed_check(engine *e, int64_t step) {
  sd_state *s = e->state;
  work *w = &e->work;
  size_t disk = 0, body = 0;
  double fastest = fastest_disk(e, &disk);
  const double moved = w->compare_motions ? motion_fastest(e, &body) : 0.0;
  if (moved > fastest) {
    fastest = moved;
    disk = body;
  }
  if (!(fastest > 0.0)) return;
  assert(s->fast_step < 0 && step >= 0 && s->id[disk] < e->model->n_disks + e->model->n_walls);
  s->fast_step = step;
  s->fast_disk = s->id[disk];
  s->fast_displacement = fastest;
  w->speed_limit2 = HUGE_VAL;
  w->compare_motions = false;
}
