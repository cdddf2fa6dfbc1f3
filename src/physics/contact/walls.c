/* walls.c: poses of pieces of walls; see walls.h. */
#include "physics/contact/walls.h"

#include <assert.h>
#include <math.h>

/* Of a wall, from which all its pieces are placed, which follow one another. */
typedef struct wall_pose {
  uint32_t body;
  bool known;
  double x, y, c, i, scale;
} wall_pose;

static void turn_by(double c, double i, const double from[2], double *x, double *y) {
  *x = c * from[0] - i * from[1];
  *y = i * from[0] + c * from[1];
}

/* Of an arc its centre, and the directions of its ends and its middle; arc: the length to its middle. */
static void place_arc(const sd_segment *from, double c, double i, placed_segment *g) {
  g->piece = from->piece;
  g->radius = from->radius;
  g->wide = from->wide;
  g->joined = false;
  g->arc = from->arc + 0.5 * from->length;
  turn_by(c, i, from->first, &g->fx, &g->fy);
  turn_by(c, i, from->last, &g->lx, &g->ly);
  turn_by(c, i, from->middle, &g->mx, &g->my);
}

void walls_bounds(const placed_segment *g, double lower[2], double upper[2]) {
  if (g->piece == SD_PIECE_STRAIGHT) {
    const bool line = g->backwards < 0.0;
    const double from[2] = {g->x, g->y}, along[2] = {g->tx, g->ty};
    for (int c = 0; c < 2; c++) {
      const double to = from[c] + (line ? 0.0 : g->length * along[c]);
      lower[c] = line ? -HUGE_VAL : fmin(from[c], to);
      upper[c] = line ? HUGE_VAL : fmax(from[c], to);
    }
    return;
  }
  const double center[2] = {g->x, g->y};
  for (int c = 0; c < 2; c++)
    for (int side = -1; side <= 1; side += 2) {
      /* as far as the circle goes where the piece does, else the farther end */
      const double ux = c == 0 ? side : 0.0, uy = c == 1 ? side : 0.0;
      const bool curve = g->piece == SD_PIECE_CURVE;
      const nearest_point q = walls_nearest_arc(g, g->x + g->radius * ux, g->y + g->radius * uy);
      const double first = c ? g->fy : g->fx, last = c ? g->ly : g->lx;
      const double end = g->piece == SD_PIECE_FIRST_END  ? first
                         : g->piece == SD_PIECE_LAST_END ? last
                         : side > 0                      ? fmax(first, last)
                                                         : fmin(first, last);
      const double edge = center[c] + g->radius * (curve && q.active ? side : end);
      if (side > 0)
        upper[c] = edge;
      else
        lower[c] = edge;
    }
}

static void point_of(const wall_pose *w, const double from[2], double *x, double *y) {
  *x = w->x + w->scale * (w->c * from[0] - w->i * from[1]);
  *y = w->y + w->scale * (w->i * from[0] + w->c * from[1]);
}

static placed_segment place(const sd_segment *from, const wall_pose *w) {
  placed_segment g = {.c = w->c,
                      .i = w->i,
                      .length = from->length,
                      .backwards = from->length < HUGE_VAL ? 0.0 : -HUGE_VAL,
                      .arc = from->arc,
                      .end_cap = from->end_cap,
                      .joined = from->next >= 0,
                      .image = {from->image[0], from->image[1]},
                      .cells = {from->cells[0], from->cells[1]},
                      .shared = from->vertex[0] || from->vertex[1],
                      .meets = from->meets[0] || from->meets[1]};
  point_of(w, from->start, &g.x, &g.y);
  turn_by(w->c, w->i, from->tangent, &g.tx, &g.ty);
  turn_by(w->c, w->i, from->previous, &g.px, &g.py);
  turn_by(w->c, w->i, from->center, &g.middle_x, &g.middle_y);
  if (from->piece != SD_PIECE_STRAIGHT) place_arc(from, w->c, w->i, &g);
  return g;
}

placed_segment walls_place(const sd_segment *from, double x, double y, double c, double i, double scale) {
  return place(from, &(wall_pose){.x = x, .y = y, .c = c, .i = i, .scale = scale});
}

static void pose_piece(engine *e, size_t k, wall_pose *wall) {
  const sd_state *s = e->state;
  const sd_segment *from = &e->model->segments[k];
  placed_segment *g = &e->work.segments[k];
  if (!wall->known || wall->body != from->body) {
    const uint32_t b = slot_of(&e->work.slots, from->body);
    assert(b >= s->n_disks && b < s->n_bodies && s->radius[b] == 0.0);
    const double angle = s->theta[b] + s->turn[b];
    *wall = (wall_pose){from->body, true, s->x[b], s->y[b], cos(angle), sin(angle), s->box_scale};
  }
  /* of a wall that has not turned only the points move */
  if (g->c == wall->c && g->i == wall->i)
    point_of(wall, from->start, &g->x, &g->y);
  else
    *g = place(from, wall);
  if (!g->joined) return;
  assert((size_t)from->next < e->model->n_segments);
  point_of(wall, e->model->segments[from->next].start, &g->end_x, &g->end_y);
}

void walls_pose(engine *e) {
  wall_pose wall = {.known = false};
  for (size_t k = 0; k < e->model->n_segments; k++) pose_piece(e, k, &wall);
}

void walls_pose_listed(engine *e) {
  wall_pose wall = {.known = false};
  for (size_t k = 0; k < e->work.n_pieces; k++) pose_piece(e, e->work.pieces[k], &wall);
}
