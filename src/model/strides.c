/* strides.c: see strides.h. */
#include "model/strides.h"

#include <math.h>
#include <stdlib.h>

#include "base/memory.h"
#include "base/shortage.h"
#include "model/motion_kinds.h"

double strides_arm(const sd_model *m, uint32_t body) {
  if (body < m->n_disks || body >= m->n_disks + m->n_walls) return 0;
  const sd_wall *w = &m->walls[body - m->n_disks];
  double ends = 0;
  if (w->kind == SD_WALL_CIRCLE) return 0;
  if (w->kind == SD_WALL_ARC)
    ends = hypot(w->center[0] - w->pivot[0], w->center[1] - w->pivot[1]) + w->radius;
  for (size_t k = 0; k < w->n_points; k++)
    ends = fmax(ends, hypot(w->points[k][0] - w->pivot[0], w->points[k][1] - w->pivot[1]));
  return ends;
}

/* Per unit of the motion, over the radius of the smallest free disk. */
static double lever(const sd_model *m, const sd_motion *q, uint32_t body) {
  if (!(m->smallest_radius > 0) || !isfinite(m->smallest_radius) || q->coordinate == SD_SURFACE) return 0;
  return (q->coordinate == SD_THETA ? strides_arm(m, body) : 1) / m->smallest_radius;
}

static bool runs(const sd_model *m, size_t motion) {
  bool any = m->n_phases == 0;
  for (size_t k = 0; k < m->n_phases; k++) any = any || !m->phases[k].active || m->phases[k].active[motion];
  return any;
}

bool strides_longest(const sd_model *m, stride *longest) {
  const size_t n = model_movables(m);
  stride *all;
  double *sums;
  *longest = (stride){0};
  if (!memory_rows(2, (memory_column[]){{&all, n, sizeof *all}, {&sums, n, sizeof *sums}})) {
    shortage_note();
    return false;
  }
  for (size_t k = 0; k < m->n_motions; k++) {
    const sd_motion *q = &m->motions[k];
    const double far = runs(m, k) ? motion_stride(q, m->dt) : 0;
    for (size_t b = 0; b < q->n_bodies && far > 0; b++) {
      const uint32_t body = q->bodies[b];
      const double length = far * lever(m, q, body);
      sums[body] += length;
      if (length > all[body].length) all[body] = (stride){body, k, length};
      if (sums[body] > longest->length) *longest = (stride){body, all[body].motion, sums[body]};
    }
  }
  free(all);
  free(sums);
  return longest->length > 0;
}

/* Chance, or the spline through a table, goes farther than motion_stride says, by less than that. */
static const double FARTHER = 3;

bool strides_are_long(const sd_model *m) {
  const double limit = m->limits.displacement;
  stride longest;
  if (!(limit > 0) || m->n_motions == 0) return false;
  for (size_t k = 0; k < m->n_motions; k++) {
    const sd_motion *q = &m->motions[k];
    if (motion_is_feedback(q)) return true;
    if (FARTHER * strides_first_jump(m, k) > STRIDES_JUMP * limit) return true;
  }
  return strides_longest(m, &longest) && FARTHER * longest.length > STRIDES_JUMP * limit;
}

double strides_first_jump(const sd_model *m, size_t motion) {
  const sd_motion *q = &m->motions[motion];
  double most = 0;
  if (!runs(m, motion)) return 0;
  for (size_t b = 0; b < q->n_bodies; b++) most = fmax(most, lever(m, q, q->bodies[b]));
  return most * fabs(motion_first(q));
}
