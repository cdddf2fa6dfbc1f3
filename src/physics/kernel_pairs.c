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
  in->was_closed = p->overlap[at] > 0.0;
  in->active = q.active;
  /* an open contact begins on the side where the disk is */
  q.crossed = p->side[at] != 0.0 && p->side[at] != q.side;
  if (q.crossed) q.side = p->side[at];
  in->arc = s->radius[a] * s->theta[a] + q.side * q.arc;
  return q;
}

/* The wall feels the torque about its pivot: -tau R_a, and the arm from there to the disk's centre. */
static inline void store_segment_force(engine *e, size_t at, law_push_w1 push) {
  const sd_state *s = e->state;
  work *w = &e->work;
  int32_t a = w->pairs.a[at], b = w->pairs.b[at];
  store_force_w1(w, at, &push);
  double rx = s->x[a] - s->x[b], ry = s->y[a] - s->y[b];
  w->incidence.push[w->pairs.push_b[at] + PUSH_TURN] = rx * push.fy - ry * push.fx - push.tau * s->radius[a];
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
  if (pass & PASS_FORCE) store_segment_force(e, at, law_force_w1(&g, &out, &k, q.flat ? 1.0 : g.lever));
  if (pass & PASS_COMMIT) {
    law_memory_w1 before, m;
    law_booked_w1 b = slide_w1(w, at, &in, &g, &out, &k, 0, &before, &m);
    if (any_w1(b.rare | law_near_w1(&in, &g, &out, w->dt)))
      turn_over_w1(w, mine, at, &in, &g, &out, &k, e->model->max_overlap * in.sum, &before, &m, &b);
    store_memory_w1(p, at, &m, &b, 0);
    p->side[at] = out.touching ? q.side : 0.0;
    /* it went around a free end */
    event *v = out.closed && q.crossed ? event_add(&mine->events, (uint32_t)at, 0.0) : NULL;
    if (v) v->ex = p->ex[at], v->ey = p->ey[at];
  }
}

void KERNEL(kernel_pairs)(engine *e, thread_work *mine, size_t begin, size_t end, int pass);

/* Whole vectors of pairs, as many as they are given at a time: the roots and divisions of some are under way while
 * others are waited for. */
enum { SIGHTS = 16 };
LANE_INLINE void block_of_pairs(engine *e, thread_work *mine, size_t at, size_t vectors, int pass) {
  LANE(law_geometry) seen[SIGHTS];
  for (size_t k = 0; k < vectors; k++) seen[k] = LANE(see)(&e->work, at + k * VECTOR_WIDTH);
  for (size_t k = 0; k < vectors; k++) LANE(meet)(e, mine, at + k * VECTOR_WIDTH, &seen[k], pass);
}

LANE_INLINE void all_pairs(engine *e, thread_work *mine, size_t begin, size_t end, int pass) {
  size_t n_round = e->work.pairs.n_round, at = begin, round_end = end < n_round ? end : n_round;
  while (at + VECTOR_WIDTH <= round_end) {
    size_t vectors = (round_end - at) / VECTOR_WIDTH;
    if (vectors > SIGHTS) vectors = SIGHTS;
    block_of_pairs(e, mine, at, vectors, pass);
    at += vectors * VECTOR_WIDTH;
  }
#if VECTOR_WIDTH > 2
  for (; at + 2 <= round_end; at += 2) round_pass_w2(e, mine, at, pass);
#endif
  for (; at < round_end; at++) round_pass_w1(e, mine, at, pass);
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
