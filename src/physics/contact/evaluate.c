/* evaluate.c: see evaluate.h. */
#include "physics/contact/evaluate.h"

#include "physics/contact/pairs.h"
#include "physics/contact/walls.h"

#define LANE_WIDTH 1
#include "base/lane.h"
#include "physics/contact/contact_step.h"
#include "physics/contact/pair_pass.h"
#include "physics/contact/segment_pass.h"

/* Of a round pair, as the pass sees it. */
static pair_input_w1 round_input(const engine *e, size_t k) {
  const sd_state *s = e->state;
  const work *w = &e->work;
  const int32_t a = w->pairs.a[k], b = w->pairs.b[k];
  pair_input_w1 in = {.dx = s->x[b] - s->x[a],
                      .dy = s->y[b] - s->y[a],
                      .dvx = s->vx[b] - s->vx[a],
                      .dvy = s->vy[b] - s->vy[a],
                      .sum = s->radius[b] + s->radius[a],
                      .arc = s->radius[b] * s->theta[b] + s->radius[a] * s->theta[a],
                      .ex = PAIR(&w->pairs, k, ex),
                      .ey = PAIR(&w->pairs, k, ey)};
  if (w->periodic[0]) in.dx -= w->length[0] * nearest_w1(in.dx * w->inverse_length[0]);
  if (w->periodic[1]) in.dy -= w->length[1] * nearest_w1(in.dy * w->inverse_length[1]);
  return in;
}

contact_geometry contact_geometry_of(const engine *e, size_t k) {
  assert(k < e->work.pairs.count && e->work.pairs.a[k] != PAIR_PADDING);
  pair_input_w1 in;
  nearest_points_w1 found;
  if (pairs_is_segment(&e->work.pairs, k))
    nearest_of_w1(e, k, &in, &found);
  else
    in = round_input(e, k);
  const pair_geometry_w1 g = pair_geometry_of_w1(&in);
  return (contact_geometry){g.nx, g.ny, g.reach, g.lambda, g.turned};
}

void contact_evaluate_again(engine *e, size_t k) {
  assert(pairs_is_segment(&e->work.pairs, k) && k < e->work.pairs.count);
  evaluate_segments_w1(e, &e->work.threads[0], k, 0);
}
