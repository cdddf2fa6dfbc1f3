/* rounding.c: see rounding.h. */
#include "model/rounding.h"

#include <float.h>
#include <math.h>

#include "model/rows.h"

/* Coordinates that are rounded by more than this part of the smallest radius have no contacts. */
static const double COARSE = 0.01;

static double farthest_of(const sd_wall *w) {
  double far = fmax(fabs(w->pivot[0]), fabs(w->pivot[1]));
  if (w->kind == SD_WALL_ARC) far = fmax(far, fmax(fabs(w->center[0]), fabs(w->center[1])));
  for (size_t k = 0; k < w->n_points; k++)
    far = fmax(far, fmax(fabs(w->points[k][0]), fabs(w->points[k][1])));
  return far;
}

/* True: it is told. */
static bool tell(const sd_model *m, uint32_t body, double far, sd_messages *msg) {
  char name[96];
  const double rounding = DBL_EPSILON * far;
  if (!(rounding > COARSE * m->smallest_radius)) return false;
  sd_fail(
      msg, SD_ERROR_USER,
      "%s: a coordinate of %.3g is rounded by %.2g, and the smallest disk has a radius of %g: expected at "
      "most %.3g",
      sd_model_body_name(m, body, name, sizeof name), far, rounding, m->smallest_radius,
      COARSE * m->smallest_radius / DBL_EPSILON);
  return true;
}

void rounding_check(const sd_model *m, sd_messages *msg) {
  for (size_t row = 0; row < rows_count(m); row++) {
    const double *at = rows_disk(m, row)->position;
    if (tell(m, rows_number(m, row), fmax(fabs(at[0]), fabs(at[1])), msg)) return;
  }
  for (uint32_t w = 0; w < m->n_walls; w++)
    if (tell(m, (uint32_t)m->n_disks + w, farthest_of(&m->walls[w]), msg)) return;
}
