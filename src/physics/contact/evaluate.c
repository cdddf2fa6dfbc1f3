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

/* direct: the tangential force acts at the lever 1. */
static pair_geometry_w1 present(const engine *e, size_t k, bool *direct) {
  assert(k < e->work.pairs.count && e->work.pairs.a[k] != PAIR_PADDING);
  pair_input_w1 in;
  nearest_points_w1 found;
  *direct = !e->work.conservative;
  if (pairs_is_segment(&e->work.pairs, k)) {
    nearest_of_w1(e, k, &in, &found);
    *direct = found.flat[0] > 0.0;
  } else {
    in = round_input(e, k);
  }
  return pair_geometry_of_w1(&in);
}

contact_geometry contact_geometry_of(const engine *e, size_t k) {
  bool direct;
  const pair_geometry_w1 g = present(e, k, &direct);
  return (contact_geometry){g.nx, g.ny, g.reach, g.lambda, g.turned};
}

contact_reaction contact_reaction_of(const engine *e, size_t k) {
  const sd_state *s = e->state;
  const pairs *p = &e->work.pairs;
  bool direct;
  const pair_geometry_w1 g = present(e, k, &direct);
  const contact_constants_w1 law = {.k_t = e->work.laws[PAIR(p, k, law)].k_t};
  const contact_memory_w1 m = {.zeta = PAIR(p, k, zeta), .force = PAIR(p, k, force)};
  contact_output_w1 out;
  contact_force_w1(&g, &law, direct ? 1.0 : g.lever, &m, &out);
  const int32_t a = p->a[k], b = p->b[k];
  const double rx = s->x[a] - s->x[b], ry = s->y[a] - s->y[b];
  return (contact_reaction){.fx = out.fx,
                            .fy = out.fy,
                            .torque_a = out.tau * s->radius[a],
                            .torque_b = pairs_is_segment(p, k)
                                            ? rx * out.fy - ry * out.fx - out.tau * s->radius[a]
                                            : out.tau * s->radius[b]};
}

void contact_evaluate_again(engine *e, size_t k) {
  assert(pairs_is_segment(&e->work.pairs, k) && k < e->work.pairs.count);
  evaluate_segments_w1(e, &e->work.threads[0], k, 0);
}
