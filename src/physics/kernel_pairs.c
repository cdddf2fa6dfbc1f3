/* kernel_pairs.c: forces and commits of all candidate pairs; compiled once per instruction set.
 *
 * Round pairs (disks, round walls) go through whole vectors, then by two (the 3-disk system has two) and
 * one, pieces of straight walls one by one.
 */
#include "physics/kernel_path.h"
#include "physics/kernels.h"
#include "physics/walls.h"

#define LANE_WIDTH 1
#include "base/lane.h"
#include "physics/law.h"
#include "physics/pair_pass.h"
#undef LANE_WIDTH
#if VECTOR_WIDTH > 2
#define LANE_WIDTH 2
#include "base/lane.h"
#include "physics/law.h"
#include "physics/pair_pass.h"
#undef LANE_WIDTH
#endif
#define LANE_WIDTH VECTOR_WIDTH
#include "base/lane.h"
#include "physics/law.h"
#include "physics/pair_pass.h"

/* Fills what the law needs for disk a and one straight piece: the nearest point of the piece is a surface of
 * radius 0, and lambda = R_a (th_a - turned) + side * (arc length of that point). physics.md 3. */
static inline nearest_point segment_input(const engine *e, size_t at, law_input_w1 *in) {
  const sd_state *s = e->state;
  const pairs *p = &e->work.pairs;
  int32_t a = p->a[at], b = p->b[at];
  const placed_segment *g = &e->work.segments[p->part[at]];
  nearest_point q = walls_nearest(g, s->x[a], s->y[a]);
  in->dx = q.dx;
  in->dy = q.dy;
  /* velocity of the wall's material at that point */
  double lx = s->x[a] + q.dx - s->x[b], ly = s->y[a] + q.dy - s->y[b];
  in->dvx = (s->vx[b] - s->omega[b] * ly) - s->vx[a];
  in->dvy = (s->vy[b] + s->omega[b] * lx) - s->vy[a];
  in->sum = s->radius[a];
  in->star = p->star[at];
  in->ex = p->ex[at];
  in->ey = p->ey[at];
  in->was_closed = law_is_closed_w1(in->ex, in->ey);
  in->active = q.active;
  /* an open contact begins on the side where the disk is */
  q.crossed = p->side[at] != 0.0 && p->side[at] != q.side;
  if (q.crossed) q.side = p->side[at];
  in->arc = s->radius[a] * s->theta[a] + q.side * q.arc;
  return q;
}

static inline void segment_pass(engine *e, thread_work *mine, size_t at, int pass) {
  work *w = &e->work;
  pairs *p = &w->pairs;
  law_input_w1 in;
  nearest_point q = segment_input(e, at, &in);
  law_constants_w1 k = constants_w1(w, p->law + at);
  law_geometry_w1 g = law_geometry_of_w1(&in);
  law_output_w1 out = law_w1(&in, &g, &k);
  /* the force that derives from the skin's energy, in both variants: the paper has no walls */
  if (pass & PASS_FORCE) store_force_w1(p, at, &in, &g, &out, &k, q.flat ? 1.0 : in.sum * g.inverse_r);
  if (pass & PASS_COMMIT) {
    commit_w1(p, mine, at, &in, &g, &out, &k, e->model->max_overlap * in.sum, 0, w->dt);
    p->side[at] = out.touching ? q.side : 0.0;
    /* it went around a free end */
    event *v = out.closed && q.crossed ? event_add(&mine->events, (uint32_t)at, 0.0) : NULL;
    if (v) v->ex = p->ex[at], v->ey = p->ey[at];
  }
}

void KERNEL(kernel_pairs)(engine *e, thread_work *mine, size_t begin, size_t end, int pass);

LANE_INLINE void all_pairs(engine *e, thread_work *mine, size_t begin, size_t end, int pass) {
  const sd_state *s = e->state;
  const pair_view view = {s->x, s->y, s->theta, s->vx, s->vy, s->radius, e->work.pairs.a, e->work.pairs.b};
  size_t n_round = e->work.pairs.n_round, at = begin, round_end = end < n_round ? end : n_round;
  for (; at + VECTOR_WIDTH <= round_end; at += VECTOR_WIDTH) LANE(round_pass)(e, mine, &view, at, pass);
#if VECTOR_WIDTH > 2
  for (; at + 2 <= round_end; at += 2) round_pass_w2(e, mine, &view, at, pass);
#endif
  for (; at < round_end; at++) round_pass_w1(e, mine, &view, at, pass);
  for (; at < end; at++) segment_pass(e, mine, at, pass);
}

/* One copy for each kind of pass, so that what it does not do costs nothing. */
void KERNEL(kernel_pairs)(engine *e, thread_work *mine, size_t begin, size_t end, int pass) {
  if (pass == PASS_FORCE)
    all_pairs(e, mine, begin, end, PASS_FORCE);
  else if (pass == PASS_COMMIT)
    all_pairs(e, mine, begin, end, PASS_COMMIT);
  else
    all_pairs(e, mine, begin, end, PASS_FORCE | PASS_COMMIT);
}
