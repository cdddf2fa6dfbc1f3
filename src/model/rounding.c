/* rounding.c: see rounding.h. */
#include "model/rounding.h"

#include <float.h>
#include <math.h>

/* Coordinates that are rounded by more than this part of the smallest radius have no contacts. */
static const double COARSE = 0.01;

static double farthest_of(const sd_wall *w) {
  double far = fmax(fabs(w->pivot[0]), fabs(w->pivot[1]));
  if (w->kind == SD_WALL_ARC) far = fmax(far, fmax(fabs(w->center[0]), fabs(w->center[1])));
  for (size_t k = 0; k < w->n_points; k++)
    far = fmax(far, fmax(fabs(w->points[k][0]), fabs(w->points[k][1])));
  return far;
}

void rounding_check(const sd_model *m, sd_messages *msg) {
  char name[96];
  for (uint32_t b = 0; b < m->n_disks + m->n_walls; b++) {
    const double *at = b < m->n_disks ? m->disks[b].position : NULL;
    const double far = at ? fmax(fabs(at[0]), fabs(at[1])) : farthest_of(&m->walls[b - m->n_disks]);
    const double rounding = DBL_EPSILON * far;
    if (!(rounding > COARSE * m->smallest_radius)) continue;
    sd_fail(
        msg, SD_ERROR_USER,
        "%s: a coordinate of %.3g is rounded by %.2g, and the smallest disk has a radius of %g: expected at "
        "most %.3g",
        sd_model_body_name(m, b, name, sizeof name), far, rounding, m->smallest_radius,
        COARSE * m->smallest_radius / DBL_EPSILON);
    return;
  }
}
