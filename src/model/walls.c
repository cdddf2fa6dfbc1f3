/* walls.c: makes the segments of walls, and checks walls in periodic boxes; see walls.h. */
#include "model/walls.h"

#include <assert.h>
#include <float.h>
#include <math.h>
#include <stdlib.h>

#include "base/math.h"
#include "base/memory.h"
#include "model/cell.h"
#include "model/motions.h"

bool model_moves_surfaces(const sd_model *m) {
  for (size_t k = 0; k < m->n_motions; k++)
    if (m->motions[k].coordinate == SD_SURFACE) return true;
  return false;
}

/* Makes the segments into which side k of a wall is cut; *arc: length of the wall up to this
 * side, which is updated. Returns their number. */
static size_t derive_side(const sd_model *m, const sd_wall *w, size_t k, uint32_t body,
                          sd_segment *first, double *arc) {
  const double *p = w->points[k], *q = w->points[(k + 1) % w->n_points];
  const double dx = q[0] - p[0], dy = q[1] - p[1], length = math_hypot(dx, dy);
  const bool line = w->kind == SD_WALL_LINE;
  const size_t n = wall_cuts(m, w, k);
  for (size_t j = 0; j < n; j++) {
    const double part = (double)j / (double)n;
    first[j] =
        (sd_segment){.body = body,
                     .start = {p[0] + part * dx - w->pivot[0], p[1] + part * dy - w->pivot[1]},
                     .tangent = {dx / length, dy / length},
                     .length = line ? HUGE_VAL : length / (double)n,
                     .arc = *arc,
                     .next = -1};
    *arc += length / (double)n;
  }
  return n;
}

/* Makes the segments of a wall that is no arc and links each to the next; number: index of the
 * wall's first segment in the model. */
static void derive_wall(const sd_model *m, size_t wall, uint32_t body, sd_segment *first,
                        size_t number) {
  const sd_wall *w = &m->walls[wall];
  size_t n = 0;
  double arc = 0.0;
  int cells[2];
  for (size_t k = 0; k < wall_segments(w); k++) n += derive_side(m, w, k, body, first + n, &arc);
  const bool repeats = wall_meets_image(m, wall, cells), around = w->closed || repeats;
  for (size_t k = 0; k < n; k++) {
    bool last = k + 1 == n, joined = !last || around;
    first[k].end_cap = !joined;
    first[k].next = joined ? (int64_t)(number + (k + 1) % n) : -1;
    for (int c = 0; last && repeats && c < 2; c++) first[k].cells[c] = cells[c];
    bool has_previous = k > 0 || around;
    const sd_segment *before = &first[(k + n - 1) % n];
    for (int c = 0; c < 2; c++)
      first[k].previous[c] = has_previous ? before->tangent[c] : -first[k].tangent[c];
  }
}

void model_find_pieces(sd_model *m) {
  free(m->segments);
  m->n_segments = 0;
  for (size_t w = 0; w < m->n_walls; w++) m->n_segments += wall_pieces(m, &m->walls[w]);
  m->segments = memory_new(m->n_segments, sizeof *m->segments);
  size_t at = 0;
  for (size_t w = 0; w < m->n_walls; w++) {
    const sd_wall *wall = &m->walls[w];
    const uint32_t body = (uint32_t)(m->n_disks + w);
    if (wall->kind == SD_WALL_ARC)
      arc_segments(wall, body, m->segments + at, (int64_t)at);
    else
      derive_wall(m, w, body, m->segments + at, at);
    const size_t n = wall_pieces(m, wall);
    for (size_t k = at; k < at + n; k++)
      wall_piece_images(m, wall->kind == SD_WALL_LINE, &m->segments[k]);
    at += n;
  }
  assert(at == m->n_segments);
  for (size_t k = 0; k < m->n_segments; k++)
    assert(m->segments[k].next < (int64_t)m->n_segments && m->segments[k].body >= m->n_disks);
  joints_number(m);
}

/* --- periodic boxes --------------------------------------------------------------------------- */

/* Relative tolerance of positions and directions in a periodic box. */
static const double NEARLY = 1e-9;
/* Sides of up to WHOLE box lengths are not cut in a periodic box: disks are smaller than the
 * gap between a segment and its image (check_width). Longer sides are cut into CUTS_PER_PERIOD
 * segments per box length. So are walls that continue in their own images, because with three
 * segments it is unique which one follows which. */
static const double WHOLE = 0.5, CUTS_PER_PERIOD = 3.0;
/* Upper limit of the number of segments of all walls together. */
static const double MOST_PIECES = 1e7;

/* Length of the box along coordinate c; 0: not periodic. */
static double period_of(const sd_model *m, int c) {
  const double length = m->upper[c] - m->lower[c];
  return m->periodic[c] && length > 0.0 ? length : 0.0;
}

/* Length of the box along its shorter periodic direction; 0: no direction is periodic. */
static double shortest_period(const sd_model *m) {
  const double x = period_of(m, 0), y = period_of(m, 1);
  return x > 0.0 && y > 0.0 ? math_min(x, y) : math_max(x, y);
}

/* --- pieces in a periodic box ----------------------------------------------------------------- */

/* True if the last point of an open wall is a periodic image of the first. cells: number of box
 * lengths between these two points, along x and y. */
static bool ends_on_image(const sd_model *m, const sd_wall *w, int cells[2]) {
  if ((w->kind != SD_WALL_SEGMENT && w->kind != SD_WALL_POLYLINE) || w->closed || w->n_points < 2)
    return false;
  cells[0] = cells[1] = 0;
  for (int c = 0; c < 2; c++) {
    const double way = w->points[w->n_points - 1][c] - w->points[0][c], period = period_of(m, c);
    const double n = period > 0.0 ? nearbyint(way / period) : 0.0,
                 near = NEARLY * shortest_period(m);
    if (!(fabs(n) < 1e6) || !(fabs(way - n * period) <= near)) return false;
    cells[c] = (int)n;
  }
  return cells[0] != 0 || cells[1] != 0;
}

/* Length of side k of a wall, from point k to the next one. */
static double side_of(const sd_wall *w, size_t k) {
  const double *p = w->points[k], *q = w->points[(k + 1) % w->n_points];
  return math_hypot(q[0] - p[0], q[1] - p[1]);
}

/* Number of segments into which side k of a wall is cut; a double, since it may be too large for
 * an integer. */
static double cuts_of(const sd_model *m, const sd_wall *w, size_t k) {
  int cells[2];
  const double shortest = shortest_period(m);
  if (!(shortest > 0.0) || w->kind == SD_WALL_LINE || w->kind == SD_WALL_ARC) return 1.0;
  const double periods = side_of(w, k) / shortest;
  if (periods <= WHOLE + NEARLY && !ends_on_image(m, w, cells)) return 1.0;
  return math_max(ceil(CUTS_PER_PERIOD * periods - NEARLY), 1.0);
}

size_t wall_cuts(const sd_model *m, const sd_wall *w, size_t k) { return (size_t)cuts_of(m, w, k); }

/* Number of segments of a wall after cutting, as a double. */
static double count_pieces(const sd_model *m, const sd_wall *w) {
  double n = 0.0;
  for (size_t k = 0; k < wall_segments(w); k++) n += cuts_of(m, w, k);
  return n;
}

size_t wall_pieces(const sd_model *m, const sd_wall *w) { return (size_t)count_pieces(m, w); }

/* Returns the index of a motion that turns wall w; n_motions: none does. */
static size_t turned_by(const sd_model *m, size_t w) {
  for (size_t k = 0; k < m->n_motions; k++)
    for (size_t b = 0; m->motions[k].coordinate == SD_THETA && b < m->motions[k].n_bodies; b++)
      if (m->motions[k].bodies[b] == m->n_disks + w) return k;
  return m->n_motions;
}

bool wall_meets_image(const sd_model *m, size_t w, int cells[2]) {
  return ends_on_image(m, &m->walls[w], cells) && turned_by(m, w) == m->n_motions;
}

void wall_piece_images(const sd_model *m, bool endless, sd_segment *s) {
  for (int c = 0; c < 2; c++) {
    /* an infinite line along coordinate c has no images along c */
    s->image[c] = period_of(m, c) > 0.0 && (!endless || fabs(s->tangent[c]) <= NEARLY);
    switch (s->piece) {
      case SD_PIECE_STRAIGHT: s->center[c] = endless ? 0.0 : 0.5 * s->length * s->tangent[c]; break;
      case SD_PIECE_CURVE:
        s->center[c] = s->wide ? 0.0 : 0.5 * s->radius * (s->first[c] + s->last[c]);
        break;
      case SD_PIECE_FIRST_END: s->center[c] = s->radius * s->first[c]; break;
      case SD_PIECE_LAST_END: s->center[c] = s->radius * s->last[c]; break;
    }
  }
}

/* --- checks ----------------------------------------------------------------------------------- */

/* Diameter of the smallest circle around the longest segment of a wall. */
static double width_of(const sd_model *m, const sd_wall *w) {
  const double part = arc_is_ring(w) ? 2.0 * M_PI / 3.0 : w->to - w->from;
  if (w->kind == SD_WALL_ARC) return 2.0 * w->radius * (part > M_PI ? 1.0 : math_sin(0.5 * part));
  double longest = 0.0;
  for (size_t k = 0; w->kind != SD_WALL_LINE && k < wall_segments(w); k++)
    longest = math_max(longest, side_of(w, k) / cuts_of(m, w, k));
  return longest;
}

/* Difference between the largest and smallest coordinate c of a wall's points. */
static double span_of(const sd_wall *w, int c) {
  double lower = HUGE_VAL, upper = -HUGE_VAL;
  for (size_t k = 0; k < w->n_points; k++) {
    lower = math_min(lower, w->points[k][c]);
    upper = math_max(upper, w->points[k][c]);
  }
  return upper - lower;
}

static const char *periodic_in(const sd_model *m) {
  return m->periodic[0] && m->periodic[1] ? "x and y" : m->periodic[0] ? "x" : "y";
}

/* Reports a line that is neither along x nor along y, or that a motion turns: it does not fit
 * its images. */
static void check_line(const sd_model *m, size_t w, sd_messages *msg) {
  const sd_wall *wall = &m->walls[w];
  const double dx = wall->points[1][0] - wall->points[0][0],
               dy = wall->points[1][1] - wall->points[0][1];
  const size_t turned = turned_by(m, w);
  char motion[96];
  if (math_min(fabs(dx), fabs(dy)) > NEARLY * math_hypot(dx, dy))
    fail_about(msg, about_wall(m, w),
               "a line along (%g, %g) does not fit to its images in a box that is periodic in %s; "
               "expected a line along x or y, or a segment or polyline",
               dx, dy, periodic_in(m));
  else if (turned < m->n_motions)
    fail_about(msg, about_wall(m, w),
               "%s turns a line, which does not fit to its images in a box that is periodic in %s; "
               "expected a segment or polyline, which has ends",
               model_motion_name(m, turned, motion, sizeof motion), periodic_in(m));
}

/* Reports a wall whose images are so near that a disk could touch two of them; contacts use only
 * the image whose midpoint is nearest. */
static void check_width(const sd_model *m, size_t w, sd_messages *msg) {
  const sd_wall *wall = &m->walls[w];
  double gap;
  const double least = cell_least_length(m, &gap), largest = (least - 2.0 * gap) / 4.8;
  const double width = width_of(m, wall);
  for (int c = 0; c < 2; c++) {
    const double period = period_of(m, c);
    const double room = period - 2.0 * (largest + gap);
    if (!(period > 0.0) || width < room) continue;
    if (wall->kind == SD_WALL_ARC)
      fail_about(msg, about_wall(m, w),
                 "the arc, %g wide, and its image in %c can touch a disk at the same time; "
                 "expected less than %g, or several arcs",
                 width, "xy"[c], room);
    else
      fail_about(msg, about_wall(m, w),
                 "the wall and its image in %c can touch a disk at the same time: box.%c has the "
                 "length %g; expected more than %g",
                 "xy"[c], "xy"[c], period, width + 2.0 * (largest + gap));
  }
}

/* True if two sides of a wall, of which side `other` is displaced by v, overlap along side k for
 * a finite length and are nowhere farther apart than `near`. */
static bool lie_together(const sd_wall *w, size_t k, size_t other, const double v[2], double near) {
  const double *p = w->points[k], *q = w->points[(k + 1) % w->n_points], length = side_of(w, k);
  const double t[2] = {(q[0] - p[0]) / length, (q[1] - p[1]) / length};
  double along[2], across[2];
  for (size_t end = 0; end < 2; end++) {
    const double *at = w->points[(other + end) % w->n_points];
    const double dx = at[0] + v[0] - p[0], dy = at[1] + v[1] - p[1];
    along[end] = dx * t[0] + dy * t[1];
    across[end] = fabs(dx * t[1] - dy * t[0]);
  }
  const double from = math_max(0.0, math_min(along[0], along[1])),
               to = math_min(length, math_max(along[0], along[1]));
  return math_max(across[0], across[1]) < near && to - from > NEARLY * length;
}

/* True if the wall lies on a periodic image of itself. near: distance below which a side counts
 * as lying on its own image. */
static bool covers_image(const sd_model *m, const sd_wall *w, double near) {
  const double x = period_of(m, 0), y = period_of(m, 1);
  const double wide[2] = {span_of(w, 0), span_of(w, 1)}, slight = NEARLY * shortest_period(m);
  const int64_t most[2] = {x > 0.0 ? (int64_t)((wide[0] + slight) / x) : 0,
                           y > 0.0 ? (int64_t)((wide[1] + slight) / y) : 0};
  const size_t n = wall_segments(w);
  for (int64_t v = -most[1]; v <= most[1]; v++)
    for (int64_t u = -most[0]; u <= most[0]; u++)
      for (size_t k = 0; k < n && (u != 0 || v != 0); k++)
        for (size_t j = 0; j < n; j++)
          if (lie_together(w, k, j, (const double[2]){(double)u * x, (double)v * y},
                           j == k ? near : slight))
            return true;
  return false;
}

/* Reports a wall longer than the box that lies on its own image, or may turn onto it: a disk
 * would be pushed twice. */
static void check_length(const sd_model *m, size_t w, sd_messages *msg) {
  enum { MOST_SIDES = 2000 };
  const sd_wall *wall = &m->walls[w];
  const size_t turned = turned_by(m, w);
  const double wide[2] = {span_of(wall, 0), span_of(wall, 1)}, slight = NEARLY * shortest_period(m);
  char motion[96];
  double gap;
  const double least = cell_least_length(m, &gap), near = 2.0 * ((least - 2.0 * gap) / 4.8 + gap);
  bool longer = false;
  for (int c = 0; c < 2; c++)
    longer = longer || (m->periodic[c] && wide[c] > period_of(m, c) - slight);
  if (wall->kind == SD_WALL_LINE || wall->kind == SD_WALL_ARC) return;
  if (turned < m->n_motions && math_hypot(wide[0], wide[1]) > shortest_period(m) - slight)
    fail_about(msg, about_wall(m, w),
               "%s turns a wall of size %g, which may come to lie on its own image; expected less "
               "than the length %g of the periodic box",
               model_motion_name(m, turned, motion, sizeof motion), math_hypot(wide[0], wide[1]),
               shortest_period(m));
  else if (longer && (wall_segments(wall) > MOST_SIDES || covers_image(m, wall, near)))
    fail_about(
        msg, about_wall(m, w),
        "longer than the periodic box, it lies on or too near to its own image, which would push "
        "as well; expected a line, or a wall whose last point is the image of its first");
}

/* True if wall b is a periodic image of wall a that was added as a wall of its own. */
static bool is_copy(const sd_model *m, const sd_wall *a, const sd_wall *b) {
  const bool line = a->kind == SD_WALL_LINE, arc = a->kind == SD_WALL_ARC;
  const double near = NEARLY * shortest_period(m);
  bool shifted = false;
  if (a->kind != b->kind || a->n_points != b->n_points || a->closed != b->closed) return false;
  if (arc && (fabs(a->radius - b->radius) > near || fabs(a->from - b->from) > NEARLY ||
              fabs(a->to - b->to) > NEARLY))
    return false;
  for (int c = 0; c < 2; c++) {
    const bool along = line && span_of(a, c) > near;
    const double period = period_of(m, c);
    const double first = arc ? b->center[c] - a->center[c] : b->points[0][c] - a->points[0][c];
    const double n = period > 0.0 ? nearbyint(first / period) : 0.0;
    if (along && !(span_of(b, c) > near)) return false;
    shifted = shifted || (!along && n != 0.0);
    for (size_t k = 0; !along && !arc && k < a->n_points; k++)
      if (fabs(b->points[k][c] - a->points[k][c] - n * period) > near) return false;
    if (arc && fabs(first - n * period) > near) return false;
  }
  return shifted;
}

/* Reports an error if wall w lies where a periodic image of an earlier wall is. */
static void check_copies(const sd_model *m, size_t w, sd_messages *msg) {
  /* only the first MOST_WALLS walls are compared, each with all before it */
  enum { MOST_WALLS = 1000 };
  char other[96];
  for (size_t k = 0; k < w && w < MOST_WALLS; k++) {
    if (!is_copy(m, &m->walls[k], &m->walls[w])) continue;
    sd_model_body_name(m, (uint32_t)(m->n_disks + k), other, sizeof other);
    fail_about(msg, about_wall(m, w),
               "it stands where an image of %s is, which pushes as well; expected one of them",
               other);
    return;
  }
}

void wall_images_check(const sd_model *m, sd_messages *msg) {
  double pieces = 0.0;
  if (!(shortest_period(m) > 0.0)) return;
  for (size_t w = 0; w < m->n_walls; w++) {
    const sd_wall *wall = &m->walls[w];
    if (wall->kind == SD_WALL_CIRCLE) continue;
    if (wall->kind == SD_WALL_LINE) check_line(m, w, msg);
    check_width(m, w, msg);
    check_length(m, w, msg);
    check_copies(m, w, msg);
    pieces += count_pieces(m, wall);
    if (pieces <= MOST_PIECES) continue;
    fail_about(msg, about_wall(m, w),
               "too long for a box of length %g: it would be cut into more than %g pieces; "
               "expected a line, or a shorter wall",
               shortest_period(m), MOST_PIECES);
    return;
  }
}

/* --- periodic images near a wall -------------------------------------------------------------- */

wall_bounds wall_bounds_of(const sd_wall *w) {
  const bool round = w->kind == SD_WALL_CIRCLE || w->kind == SD_WALL_ARC;
  wall_bounds b;
  for (int c = 0; c < 2; c++) {
    const double middle = w->kind == SD_WALL_ARC ? w->center[c] : w->pivot[c];
    b.lower[c] = round ? middle - w->radius : HUGE_VAL;
    b.upper[c] = round ? middle + w->radius : -HUGE_VAL;
    for (size_t k = 0; !round && k < w->n_points; k++) {
      b.lower[c] = math_min(b.lower[c], w->points[k][c]);
      b.upper[c] = math_max(b.upper[c], w->points[k][c]);
    }
  }
  return b;
}

wall_range wall_range_of(const sd_model *m, const sd_wall *w, const wall_bounds *b,
                         const double at[2], double reach) {
  wall_range r = {0};
  for (int c = 0; c < 2; c++) {
    const double lower = b->lower[c], upper = b->upper[c], period = period_of(m, c);
    /* a wall without points has no position */
    if (!(period > 0.0) || !(lower <= upper)) continue;
    /* an infinite line has no images along itself; a disk in a round container touches one image
     * only */
    if (w->kind == SD_WALL_LINE && upper - lower > NEARLY * side_of(w, 0)) continue;
    r.length[c] = period;
    if (w->kind == SD_WALL_CIRCLE && w->inside) {
      r.first[c] = r.last[c] = nearbyint((0.5 * (lower + upper) - at[c]) / period);
      continue;
    }
    r.first[c] = ceil((lower - reach - at[c]) / period);
    r.last[c] = floor((upper + reach - at[c]) / period);
  }
  return r;
}

/* --- finds ends of walls that meet and numbers their vertices --------------------------------- */

/* --- ends ------------------------------------------------------------------------------------- */

/* True if the wall has two ends: a segment, open polyline or arc. */
static bool has_ends(const sd_wall *w) {
  if (w->kind == SD_WALL_ARC) return !arc_is_ring(w);
  return w->n_points >= 2 &&
         (w->kind == SD_WALL_SEGMENT || (w->kind == SD_WALL_POLYLINE && !w->closed));
}

/* Returns one end of a wall; end: 0 for the first point, 1 for the last. */
static wall_end end_of(const sd_wall *w, uint32_t number, int end) {
  wall_end e = {.wall = number, .end = end};
  if (w->kind == SD_WALL_ARC) {
    const double angle = end ? w->to : w->from, sign = end ? -1.0 : 1.0;
    double d[2];
    math_sine_cosine(angle, &d[1], &d[0]);
    for (int c = 0; c < 2; c++) e.at[c] = w->center[c] + w->radius * d[c];
    e.way[0] = -sign * d[1];
    e.way[1] = sign * d[0];
    e.along = w->radius * (w->to - w->from);
    return e;
  }
  const double *p = w->points[end ? w->n_points - 1 : 0], *q = w->points[end ? w->n_points - 2 : 1];
  e.along = math_hypot(q[0] - p[0], q[1] - p[1]);
  for (int c = 0; c < 2; c++) {
    e.at[c] = p[c];
    e.way[c] = (q[c] - p[c]) / e.along;
  }
  return e;
}

/* Moves the end of a wall into the periodic box, so that ends that meet across an edge get the
 * same position; ends within rounding of an edge go to the lower edge. */
static void into_box(const sd_model *m, wall_end *e) {
  for (int c = 0; c < 2; c++) {
    const double length = m->upper[c] - m->lower[c];
    if (!m->periodic[c] || !(length > 0.0)) continue;
    const double n = floor((e->at[c] - m->lower[c]) / length + 1e-6);
    if (!(fabs(n) < 1e9)) continue;
    e->at[c] -= length * n;
    e->cells[c] = -(int)n;
  }
}

static int by_x(const void *one, const void *two) {
  const wall_end *a = one, *b = two;
  if (a->at[0] != b->at[0]) return a->at[0] < b->at[0] ? -1 : 1;
  return a->wall != b->wall ? (a->wall < b->wall ? -1 : 1) : a->end - b->end;
}

wall_end *joints_ends(const sd_model *m, size_t *n) {
  wall_end *ends = memory_new(2 * m->n_walls, sizeof *ends);
  *n = 0;
  for (size_t w = 0; w < m->n_walls; w++)
    for (int end = 0; has_ends(&m->walls[w]) && end < 2; end++) {
      ends[*n] = end_of(&m->walls[w], (uint32_t)w, end);
      into_box(m, &ends[(*n)++]);
    }
  if (*n > 1) qsort(ends, *n, sizeof *ends, by_x);
  return ends;
}

/* The first term is the rounding error of lengths, the second that of coordinates. */
double joints_tolerance(const wall_end *e) {
  return 1e-9 * e->along + 16.0 * DBL_EPSILON * (fabs(e->at[0]) + fabs(e->at[1]));
}

bool joints_meet(const wall_end *a, const wall_end *b) {
  return math_hypot(b->at[0] - a->at[0], b->at[1] - a->at[1]) <=
         math_min(joints_tolerance(a), joints_tolerance(b));
}

size_t joints_near(const wall_end *ends, size_t n, size_t k) {
  size_t last = k + 1;
  while (last < n && ends[last].at[0] - ends[k].at[0] <= joints_tolerance(&ends[k])) last++;
  return last;
}

/* --- motions ---------------------------------------------------------------------------------- */

static bool moves(const sd_motion *q, uint32_t body) {
  for (size_t k = 0; k < q->n_bodies; k++)
    if (q->bodies[k] == body) return true;
  return false;
}

bool joints_rigid(const sd_model *m, const wall_end *one, const wall_end *two) {
  const uint32_t a = one->wall, b = two->wall;
  const bool image = one->cells[0] != two->cells[0] || one->cells[1] != two->cells[1];
  const sd_wall *p = &m->walls[a], *q = &m->walls[b];
  for (size_t k = 0; k < m->n_motions; k++) {
    const sd_motion *motion = &m->motions[k];
    const bool first = moves(motion, (uint32_t)m->n_disks + a),
               second = moves(motion, (uint32_t)m->n_disks + b);
    if (motion->coordinate == SD_SURFACE || !(first || second))
      continue; /* a moving surface leaves the wall in place */
    if (first != second || motion_is_feedback(motion)) return false;
    if (motion->coordinate == SD_THETA &&
        (image || p->pivot[0] != q->pivot[0] || p->pivot[1] != q->pivot[1]))
      return false;
  }
  return true;
}

/* --- vertices --------------------------------------------------------------------------------- */

/* Root of vertex v in a union-find forest of coinciding vertices: same[v] is its parent,
 * same[root] = root. */
static uint32_t first_of(uint32_t *same, uint32_t v) {
  while (same[v] != v) v = same[v] = same[same[v]];
  return v;
}

/* Lists the index of each wall's first segment: wall w has first[w] ... first[w + 1] - 1. */
static void list_pieces(const sd_model *m, size_t *first) {
  size_t at = 0;
  for (size_t w = 0; w <= m->n_walls; w++) {
    while (at < m->n_segments && m->segments[at].body < m->n_disks + w) at++;
    first[w] = at;
  }
}

/* Numbers the vertices of all walls from 1 on, so that no two walls share a vertex; infinite
 * lines have none, 0. */
static void number_own(sd_model *m, const size_t *first) {
  uint32_t last = 0;
  for (size_t w = 0; w < m->n_walls; w++) {
    const size_t n = first[w + 1] - first[w];
    sd_segment *s = m->segments + first[w];
    if (n == 0 || m->walls[w].kind == SD_WALL_LINE) continue;
    if (s->piece == SD_PIECE_FIRST_END) {
      s[0].vertex[0] = s[1].vertex[0] = ++last;
      s[1].vertex[1] = s[2].vertex[1] = ++last;
      continue;
    }
    for (size_t k = 0; k < n; k++) s[k].vertex[0] = ++last;
    for (size_t k = 0; k + 1 < n; k++) s[k].vertex[1] = s[k + 1].vertex[0];
    s[n - 1].vertex[1] = s[n - 1].next >= 0 ? s[0].vertex[0] : ++last;
  }
}

/* Returns the number of the vertex at an end of a wall. first: index of each wall's first
 * segment. */
static uint32_t vertex_at(const sd_model *m, const size_t *first, const wall_end *e) {
  return m->segments[e->end ? first[e->wall + 1] - 1 : first[e->wall]].vertex[e->end];
}

/* Merges the vertices of wall ends that meet and stay together in all motions: same[] links
 * equal vertices, and meets[v] becomes true for the vertices that were merged. */
static void join(const sd_model *m, const size_t *first, const wall_end *ends, size_t n,
                 uint32_t *same, bool *meets) {
  for (size_t k = 0; k < n; k++)
    for (size_t j = k + 1, end = joints_near(ends, n, k); j < end; j++) {
      if (!joints_meet(&ends[k], &ends[j]) || !joints_rigid(m, &ends[k], &ends[j])) continue;
      const uint32_t p = first_of(same, vertex_at(m, first, &ends[k])),
                     q = first_of(same, vertex_at(m, first, &ends[j]));
      meets[vertex_at(m, first, &ends[k])] = meets[vertex_at(m, first, &ends[j])] = true;
      same[p > q ? p : q] = p > q ? q : p;
    }
}

void joints_number(sd_model *m) {
  const size_t n_vertices = 2 * m->n_segments + 1; /* vertex numbers begin at 1 */
  size_t n;
  wall_end *ends = joints_ends(m, &n);
  size_t *first = memory_new(m->n_walls + 1, sizeof *first);
  uint32_t *same = memory_new(n_vertices, sizeof *same);
  bool *meets = memory_new(n_vertices, sizeof *meets);
  list_pieces(m, first);
  number_own(m, first);
  for (size_t v = 0; v < n_vertices; v++) same[v] = (uint32_t)v;
  join(m, first, ends, n, same, meets);
  for (size_t k = 0; k < m->n_segments; k++)
    for (int end = 0; end < 2; end++) {
      const uint32_t v = m->segments[k].vertex[end];
      m->segments[k].meets[end] = meets[v];
      m->segments[k].vertex[end] = first_of(same, v);
    }
  free(ends);
  free(first);
  free(same);
  free(meets);
}
