/* pieces.c: the pieces of walls, of which contacts are made; see bodies.h. */
#include <assert.h>
#include <math.h>
#include <stdlib.h>

#include "model/arc.h"
#include "model/bodies.h"
#include "model/joints.h"

bool model_moves_surfaces(const sd_model *m) {
  for (size_t k = 0; k < m->n_motions; k++)
    if (m->motions[k].coordinate == SD_SURFACE) return true;
  return false;
}

static void derive_wall(const sd_wall *w, uint32_t body, sd_segment *first, size_t number) {
  size_t n = wall_segments(w);
  double arc = 0.0;
  for (size_t k = 0; k < n; k++) {
    sd_segment *s = &first[k];
    const double *p = w->points[k], *q = w->points[(k + 1) % w->n_points];
    double dx = q[0] - p[0], dy = q[1] - p[1], length = hypot(dx, dy);
    *s = (sd_segment){.body = body,
                      .start = {p[0] - w->pivot[0], p[1] - w->pivot[1]},
                      .tangent = {dx / length, dy / length},
                      .length = w->kind == SD_WALL_LINE ? HUGE_VAL : length,
                      .arc = arc,
                      .next = -1};
    arc += length;
  }
  for (size_t k = 0; k < n; k++) {
    bool last = k + 1 == n, joined = !last || w->closed;
    first[k].end_cap = !joined;
    first[k].next = joined ? (int64_t)(number + (k + 1) % n) : -1;
    bool has_previous = k > 0 || w->closed;
    const sd_segment *before = &first[(k + n - 1) % n];
    for (int c = 0; c < 2; c++)
      first[k].previous[c] = has_previous ? before->tangent[c] : -first[k].tangent[c];
  }
}

sd_status model_find_pieces(sd_model *m) {
  free(m->segments);
  m->n_segments = 0;
  for (size_t w = 0; w < m->n_walls; w++) m->n_segments += wall_segments(&m->walls[w]);
  m->segments = calloc(m->n_segments ? m->n_segments : 1, sizeof *m->segments);
  if (!m->segments) return SD_ERROR_IO;
  size_t at = 0;
  for (size_t w = 0; w < m->n_walls; w++) {
    const sd_wall *wall = &m->walls[w];
    const uint32_t body = (uint32_t)(m->n_disks + w);
    if (wall->kind == SD_WALL_ARC)
      arc_pieces(wall, body, m->segments + at, (int64_t)at);
    else
      derive_wall(wall, body, m->segments + at, at);
    at += wall_segments(&m->walls[w]);
  }
  assert(at == m->n_segments);
  for (size_t k = 0; k < m->n_segments; k++)
    assert(m->segments[k].next < (int64_t)m->n_segments && m->segments[k].body >= m->n_disks);
  return joints_number(m);
}
