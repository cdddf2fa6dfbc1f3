/* pieces.c: the pieces of walls, of which contacts are made; see bodies.h. */
#include <assert.h>
#include <math.h>
#include <stdlib.h>

#include "base/memory.h"
#include "model/arc.h"
#include "model/bodies.h"
#include "model/joints.h"
#include "model/wall_images.h"

bool model_moves_surfaces(const sd_model *m) {
  for (size_t k = 0; k < m->n_motions; k++)
    if (m->motions[k].coordinate == SD_SURFACE) return true;
  return false;
}

/* Of side k of a wall the pieces into which it is cut; *arc: the length of the wall so far. Returns how many there are. */
static size_t derive_side(const sd_model *m, const sd_wall *w, size_t k, uint32_t body, sd_segment *first,
                          double *arc) {
  const double *p = w->points[k], *q = w->points[(k + 1) % w->n_points];
  const double dx = q[0] - p[0], dy = q[1] - p[1], length = hypot(dx, dy);
  const bool line = w->kind == SD_WALL_LINE;
  const size_t n = wall_cuts(m, w, k);
  for (size_t j = 0; j < n; j++) {
    const double part = (double)j / (double)n;
    first[j] = (sd_segment){.body = body,
                            .start = {p[0] + part * dx - w->pivot[0], p[1] + part * dy - w->pivot[1]},
                            .tangent = {dx / length, dy / length},
                            .length = line ? HUGE_VAL : length / (double)n,
                            .arc = *arc,
                            .next = -1};
    *arc += length / (double)n;
  }
  return n;
}

static void derive_wall(const sd_model *m, size_t wall, uint32_t body, sd_segment *first, size_t number) {
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
      arc_pieces(wall, body, m->segments + at, (int64_t)at);
    else
      derive_wall(m, w, body, m->segments + at, at);
    const size_t n = wall_pieces(m, wall);
    for (size_t k = at; k < at + n; k++) wall_piece_images(m, wall->kind == SD_WALL_LINE, &m->segments[k]);
    at += n;
  }
  assert(at == m->n_segments);
  for (size_t k = 0; k < m->n_segments; k++)
    assert(m->segments[k].next < (int64_t)m->n_segments && m->segments[k].body >= m->n_disks);
  joints_number(m);
}
