/* access.c: read access to a system; implements access.h. */
#include "physics/step/access.h"

#include "base/math.h"
#include "physics/contact/walls.h"
#include "physics/motion/motion.h"

int64_t engine_watched(const engine *e, size_t k) {
  const pairs *p = &e->work.pairs;
  int64_t first = e->work.watched[k];
  if (first < 0) return -1;
  int64_t pressed = first;
  if (pairs_is_segment(p, (size_t)first))
    for (size_t at = (size_t)first;
         at < p->count && p->a[at] == p->a[first] && p->b[at] == p->b[first]; at++)
      if (engine_contact_force(e, at) > engine_contact_force(e, (size_t)pressed) ||
          !engine_contact_closed(e, (size_t)pressed))
        pressed = (int64_t)at;
  return engine_contact_closed(e, (size_t)pressed) ? pressed : -1;
}

void engine_pose_walls(engine *e) { walls_pose(e); }

bool engine_outruns(engine *e) {
  return e->work.kernels->stale(e, 0, e->state->n_free, 1.0) || motion_outruns(e);
}

double engine_outrun_skin(const engine *e) {
  const sd_state *s = e->state;
  const work *w = &e->work;
  double most = 0.0;
  for (size_t i = 0; i < s->n_free; i++) {
    const double dx = s->x[i] + (s->vx[i] * w->dt + s->x2[i]) - w->x0[i],
                 dy = s->y[i] + (s->vy[i] * w->dt + s->y2[i]) - w->y0[i];
    most = math_max(most, math_hypot(dx, dy));
  }
  /* a margin of most/0.45 would just do (limit_of), so this one leaves a little room */
  return most / 0.44;
}
