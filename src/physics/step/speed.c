/* speed.c: see speed.h. */
#include "physics/step/speed.h"

#include <assert.h>
#include <math.h>

void speed_begin(engine *e) {
  work *w = &e->work;
  const double limit = e->model->limits.displacement * w->per_dt;
  const bool compare = limit > 0.0 && e->state->fast_step < 0;
  w->speed_limit2 = compare ? limit * limit : HUGE_VAL;
}

void speed_check(engine *e, int64_t step) {
  sd_state *s = e->state;
  work *w = &e->work;
  double fastest = 0.0;
  size_t disk = 0;
  bool any = false;
  for (size_t i = 0; i < s->n_free; i++) {
    double v2 = s->vx[i] * s->vx[i] + s->vy[i] * s->vy[i], r2 = s->radius[i] * s->radius[i];
    if (!(v2 > r2 * w->speed_limit2)) continue;
    any = true;
    if (!(v2 / r2 > fastest)) continue; /* of equal ones the first slot */
    fastest = v2 / r2;
    disk = i;
  }
  if (!any) return;
  assert(s->fast_step < 0 && step >= 0 && s->id[disk] < e->model->n_disks);
  s->fast_step = step;
  s->fast_disk = s->id[disk];
  s->fast_displacement = sqrt(fastest) * w->dt;
  w->speed_limit2 = HUGE_VAL;
}
