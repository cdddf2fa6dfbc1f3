/* arc.c: segments and points of walls that are circular arcs; see arc.h. */
#include "model/arc.h"

#include <math.h>

bool arc_is_ring(const sd_wall *w) { return w->to - w->from >= ARC_RING - 1e-9; }

/* Unit vector at an angle; exact at multiples of a quarter turn, where most arcs end and cos and
 * sin would be rounded. */
static void direction(double angle, double d[2]) {
  d[0] = cos(angle);
  d[1] = sin(angle);
  for (int c = 0; c < 2; c++)
    if (fabs(d[c]) < 1e-15) {
      d[c] = 0.0;
      d[1 - c] = d[1 - c] > 0.0 ? 1.0 : -1.0;
    }
}

void arc_trace(sd_wall *w) {
  w->n_points = ARC_POINTS;
  for (size_t k = 0; k < ARC_POINTS; k++) {
    double d[2];
    direction(w->from + (w->to - w->from) * (double)k / (ARC_POINTS - 1), d);
    for (int c = 0; c < 2; c++) w->points[k][c] = w->center[c] + w->radius * d[c];
  }
}

/* The segments are first end, curve, last end; of a full circle three curves, joined to one
 * another. Arc length counts from the middle. */
void arc_pieces(const sd_wall *w, uint32_t body, sd_segment piece[3], int64_t number) {
  const bool ring = arc_is_ring(w);
  const double opening = ring ? 2.0 * M_PI : w->to - w->from, part = ring ? opening / 3.0 : opening;
  for (int k = 0; k < 3; k++) {
    const double from = w->from + (ring ? k * part : 0.0);
    sd_segment *s = &piece[k];
    *s = (sd_segment){.body = body,
                      .piece = ring || k == 1 ? SD_PIECE_CURVE
                               : k == 0       ? SD_PIECE_FIRST_END
                                              : SD_PIECE_LAST_END,
                      .start = {w->center[0] - w->pivot[0], w->center[1] - w->pivot[1]},
                      .radius = w->radius,
                      .length = ring || k == 1 ? w->radius * part : 0.0,
                      .arc = w->radius * part *
                             (ring     ? k - 1.5
                              : k == 2 ? 0.5
                                       : -0.5),
                      .wide = part > M_PI,
                      .next = k < 2  ? number + k + 1
                              : ring ? number
                                     : -1};
    direction(from, s->first);
    direction(from + part, s->last);
    direction(from + 0.5 * part, s->middle);
  }
  /* neighbouring segments share the direction of their joint, so that no point lies in both or
   * in neither */
  for (int k = 0; ring && k < 3; k++)
    for (int c = 0; c < 2; c++) piece[k].last[c] = piece[(k + 1) % 3].first[c];
}

double arc_distance(const sd_wall *w, const double at[2]) {
  const double x = at[0] - w->center[0], y = at[1] - w->center[1];
  const double middle = 0.5 * (w->from + w->to), half = 0.5 * (w->to - w->from);
  if (fabs(remainder(atan2(y, x) - middle, 2.0 * M_PI)) <= half)
    return fabs(hypot(x, y) - w->radius);
  double end[2], nearest = HUGE_VAL;
  for (int k = 0; k < 2; k++) {
    direction(k ? w->to : w->from, end);
    nearest = fmin(nearest, hypot(x - w->radius * end[0], y - w->radius * end[1]));
  }
  return nearest;
}
