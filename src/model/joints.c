/* joints.c: finds ends of walls that meet and numbers their vertices; see joints.h. */
#include "model/joints.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>

#include "base/memory.h"
#include "model/arc.h"
#include "model/motions.h"

/* --- ends ----------------------------------------------------------------------------------- */

/* True if the wall has two free ends. */
static bool has_ends(const sd_wall *w) {
  if (w->kind == SD_WALL_ARC) return !arc_is_ring(w);
  return w->n_points >= 2 &&
         (w->kind == SD_WALL_SEGMENT || (w->kind == SD_WALL_POLYLINE && !w->closed));
}

/* Returns the first (0) or last (1) end of a wall. */
static wall_end end_of(const sd_wall *w, uint32_t number, int end) {
  wall_end e = {.wall = number, .end = end};
  if (w->kind == SD_WALL_ARC) {
    const double angle = end ? w->to : w->from, sign = end ? -1.0 : 1.0;
    const double d[2] = {cos(angle), sin(angle)};
    for (int c = 0; c < 2; c++) e.at[c] = w->center[c] + w->radius * d[c];
    e.way[0] = -sign * d[1];
    e.way[1] = sign * d[0];
    e.along = w->radius * (w->to - w->from);
    return e;
  }
  const double *p = w->points[end ? w->n_points - 1 : 0], *q = w->points[end ? w->n_points - 2 : 1];
  e.along = hypot(q[0] - p[0], q[1] - p[1]);
  for (int c = 0; c < 2; c++) {
    e.at[c] = p[c];
    e.way[c] = (q[c] - p[c]) / e.along;
  }
  return e;
}

/* Moves an end into the periodic box, so that ends that meet across an edge get the same
 * position; ends within rounding of an edge go to the lower one. */
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

/* The two terms are the rounding errors of lengths and of coordinates. */
double joints_tolerance(const wall_end *e) {
  return 1e-9 * e->along + 16.0 * DBL_EPSILON * (fabs(e->at[0]) + fabs(e->at[1]));
}

bool joints_meet(const wall_end *a, const wall_end *b) {
  return hypot(b->at[0] - a->at[0], b->at[1] - a->at[1]) <=
         fmin(joints_tolerance(a), joints_tolerance(b));
}

size_t joints_near(const wall_end *ends, size_t n, size_t k) {
  size_t last = k + 1;
  while (last < n && ends[last].at[0] - ends[k].at[0] <= joints_tolerance(&ends[k])) last++;
  return last;
}

/* --- motions -------------------------------------------------------------------------------- */

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

/* --- vertices ------------------------------------------------------------------------------- */

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

/* Numbers the vertices of each wall by itself, from 1 on; a line has none, 0. */
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

/* Number of the vertex at an end of a wall. */
static uint32_t vertex_at(const sd_model *m, const size_t *first, const wall_end *e) {
  return m->segments[e->end ? first[e->wall + 1] - 1 : first[e->wall]].vertex[e->end];
}

/* Merges the vertices of ends that meet and stay together in all motions, and marks them in
 * `meets`. */
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
