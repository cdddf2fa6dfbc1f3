/* walls.c: poses of straight walls; see walls.h. */
#include "physics/contact/walls.h"

#include <assert.h>
#include <math.h>

void walls_pose(engine *e) {
  const sd_state *s = e->state;
  for (size_t k = 0; k < e->model->n_segments; k++) {
    const sd_segment *from = &e->model->segments[k];
    uint32_t b = e->work.slot[from->body];
    assert(b >= s->n_disks && b < s->n_bodies && s->radius[b] == 0.0);
    double angle = s->theta[b] + s->turn[b], c = cos(angle), i = sin(angle);
    e->work.segments[k] = (placed_segment){
        .x = s->x[b] + s->box_scale * (c * from->start[0] - i * from->start[1]),
        .y = s->y[b] + s->box_scale * (i * from->start[0] + c * from->start[1]),
        .tx = c * from->tangent[0] - i * from->tangent[1],
        .ty = i * from->tangent[0] + c * from->tangent[1],
        .length = from->length,
        .px = c * from->previous[0] - i * from->previous[1],
        .py = i * from->previous[0] + c * from->previous[1],
        .backwards = from->length < HUGE_VAL ? 0.0 : -HUGE_VAL,
        .arc = from->arc,
        .end_cap = from->end_cap,
        .joined = from->next >= 0,
    };
  }
  for (size_t k = 0; k < e->model->n_segments; k++) {
    placed_segment *g = &e->work.segments[k];
    if (!g->joined) continue;
    assert((size_t)e->model->segments[k].next < e->model->n_segments);
    g->end_x = e->work.segments[e->model->segments[k].next].x;
    g->end_y = e->work.segments[e->model->segments[k].next].y;
  }
}
