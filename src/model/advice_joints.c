/* advice_joints.c: walls of which a disk may touch two in one point. See advice.h. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "model/advice.h"
#include "model/joints.h"
#include "model/rows.h"

static double cross(const double a[2], const double b[2]) { return a[0] * b[1] - a[1] * b[0]; }
static double dot(const double a[2], const double b[2]) { return a[0] * b[0] + a[1] * b[1]; }

/* A place where walls are twice. */
typedef struct twice {
  size_t count;
  uint32_t a, b; /* the first pair of walls, ... */
  double at[2];  /* and where */
} twice;

static void note(twice *t, uint32_t a, uint32_t b, const double at[2]) {
  if (t->count++ > 0) return;
  t->a = a;
  t->b = b;
  for (int c = 0; c < 2; c++) t->at[c] = at[c];
}

typedef bool disk_place(const double at[2], const void *user);

/* Is any disk that moves at such a place? Those that wait for rain have none yet. */
static bool any_disk(const sd_model *m, disk_place *is, const void *user) {
  bool any = false;
  for (size_t row = 0; row < rows_count(m) && !any; row++) {
    const sd_disk *d = rows_disk(m, row);
    any = !d->driven && !d->waiting && is(d->position, user);
  }
  return rows_any(m, any);
}

/* --- ends that meet, of walls that move apart ------------------------------------------------------------- */

/* Between the walls of a corner both are touched in their own points; elsewhere in the point of the corner. */
static bool is_beyond_corner(const double at[2], const void *user) {
  const wall_end *const *e = user, *a = e[0], *b = e[1];
  const double p[2] = {at[0] - a->at[0], at[1] - a->at[1]}, opens = cross(a->way, b->way);
  return !(fabs(opens) > 1e-9) || cross(a->way, p) * opens < 0.0 || cross(p, b->way) * opens < 0.0;
}

static void look_at_ends(const sd_model *m, const wall_end *ends, size_t n, twice *found) {
  for (size_t k = 0; k < n; k++)
    for (size_t j = k + 1, last = joints_near(ends, n, k); j < last; j++) {
      const wall_end *two[2] = {&ends[k], &ends[j]};
      if (joints_meet(two[0], two[1]) && !joints_rigid(m, two[0], two[1]) &&
          any_disk(m, is_beyond_corner, two))
        note(found, ends[k].wall, ends[j].wall, ends[k].at);
    }
}

/* --- a wall that ends on another --------------------------------------------------------------------------- */

/* The surface of a wall at a point of it: a line, or a circle. */
typedef struct surface {
  const double *at, *center; /* NULL: straight */
  double normal[2], radius;
  double side; /* of the wall that ends there */
} surface;

/* The surface of side k of a wall, if the end lies on it, but for its own ends. */
static bool lies_on(const sd_wall *w, size_t k, const wall_end *e, double near, surface *s) {
  *s = (surface){.at = e->at};
  if (w->kind == SD_WALL_CIRCLE || w->kind == SD_WALL_ARC) {
    s->center = w->kind == SD_WALL_ARC ? w->center : w->pivot;
    s->radius = w->radius;
    for (int c = 0; c < 2; c++) s->normal[c] = (e->at[c] - s->center[c]) / w->radius;
    const double angle = remainder(atan2(s->normal[1], s->normal[0]) - 0.5 * (w->from + w->to), 2.0 * M_PI);
    return fabs(hypot(s->normal[0], s->normal[1]) - 1.0) * w->radius <= near &&
           (w->kind == SD_WALL_CIRCLE || (0.5 * (w->to - w->from) - fabs(angle)) * w->radius > near);
  }
  const double *p = w->points[k], *q = w->points[(k + 1) % w->n_points];
  const double along[2] = {q[0] - p[0], q[1] - p[1]}, from[2] = {e->at[0] - p[0], e->at[1] - p[1]};
  const double length = hypot(along[0], along[1]), on = dot(along, from) / length;
  const bool first = k == 0 && !w->closed, last = k + 2 == w->n_points && !w->closed;
  s->normal[0] = -along[1] / length;
  s->normal[1] = along[0] / length;
  return fabs(dot(s->normal, from)) <= near &&
         (w->kind == SD_WALL_LINE || (on > (first ? near : -near) && on < length - (last ? near : -near)));
}

static bool is_on_other_side(const double at[2], const void *user) {
  const surface *s = user;
  double side;
  if (s->center) {
    side = hypot(at[0] - s->center[0], at[1] - s->center[1]) - s->radius;
  } else {
    const double p[2] = {at[0] - s->at[0], at[1] - s->at[1]};
    side = dot(s->normal, p);
  }
  return !(side * s->side > 0.0);
}

static size_t sides_of(const sd_wall *w) {
  if (w->kind != SD_WALL_POLYLINE) return 1;
  return w->n_points - (w->closed ? 0 : 1);
}

/* From where to where a wall goes along x. */
static void bounds_of(const sd_wall *w, double *lower, double *upper) {
  *lower = w->kind == SD_WALL_CIRCLE ? w->pivot[0] - w->radius : HUGE_VAL;
  *upper = w->kind == SD_WALL_CIRCLE ? w->pivot[0] + w->radius : -HUGE_VAL;
  for (size_t k = 0; k < w->n_points; k++) {
    *lower = fmin(*lower, w->points[k][0]);
    *upper = fmax(*upper, w->points[k][0]);
  }
  if (w->kind == SD_WALL_ARC) *lower = w->center[0] - w->radius, *upper = w->center[0] + w->radius;
  if (w->kind == SD_WALL_LINE) *lower = -HUGE_VAL, *upper = HUGE_VAL;
}

static size_t first_from(const wall_end *ends, size_t n, double x) {
  size_t from = 0;
  while (from < n) {
    const size_t middle = from + (n - from) / 2;
    if (ends[middle].at[0] + joints_tolerance(&ends[middle]) < x)
      from = middle + 1;
    else
      n = middle;
  }
  return from;
}

static void look_at_surfaces(const sd_model *m, const wall_end *ends, size_t n, twice *found) {
  double lower, upper;
  for (uint32_t w = 0; w < m->n_walls; w++) {
    bounds_of(&m->walls[w], &lower, &upper);
    for (size_t e = first_from(ends, n, lower); e < n; e++) {
      const double near = joints_tolerance(&ends[e]);
      surface s;
      bool on = false;
      if (ends[e].at[0] - near > upper) break;
      for (size_t k = 0; ends[e].wall != w && !on && k < sides_of(&m->walls[w]); k++)
        on = lies_on(&m->walls[w], k, &ends[e], near, &s);
      if (!on) continue;
      s.side = dot(s.normal, ends[e].way);
      if (fabs(s.side) < 1e-9) s.side = 0.0; /* one lies on the other */
      if (any_disk(m, is_on_other_side, &s)) note(found, ends[e].wall, w, ends[e].at);
    }
  }
}

/* --- warnings ----------------------------------------------------------------------------------------------- */

static double tell(const sd_model *m, const twice *t, const char *where, const char *advice,
                   sd_messages *messages) {
  char one[96], two[96], more[48] = "";
  if (t->count == 0) return 0.0;
  if (t->count > 1) snprintf(more, sizeof more, " (and %zu more)", t->count - 1);
  sd_warn(messages, "%s %s %s at (%g, %g)%s: %s",
          sd_model_body_name(m, (uint32_t)m->n_disks + t->a, one, sizeof one), where,
          sd_model_body_name(m, (uint32_t)m->n_disks + t->b, two, sizeof two), t->at[0], t->at[1], more,
          advice);
  return (double)t->count;
}

double advice_joints(const sd_model *m, sd_messages *messages) {
  twice ends = {0}, surfaces = {0};
  size_t n;
  wall_end *all = joints_ends(m, &n);
  look_at_ends(m, all, n, &ends);
  look_at_surfaces(m, all, n, &surfaces);
  free(all);
  const double apart = tell(m, &ends, "meets",
                            "they move apart, so a disk there feels both; name both in the same motions, or "
                            "draw them as one polyline",
                            messages);
  return fmax(apart,
              tell(m, &surfaces, "ends on",
                   "a disk on its other side feels both there; let the first end before it, or draw the "
                   "second in two parts whose ends meet there",
                   messages));
}
