/* kernel_pairs.c: forces and commits of all candidate pairs; compiled once per instruction set.
 *
 * Round pairs (disks, round walls) go in whole vectors, pieces of straight walls one by one.
 */
#include <stddef.h>

#include "physics/kernel_path.h"
#include "physics/kernels.h"
#include "physics/walls.h"

#define LANE_WIDTH 1
#include "base/lane.h"
#include "physics/law.h"
#include "physics/pair_pass.h"
#undef LANE_WIDTH
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
  in->star = PAIR(p, at, star);
  in->ex = PAIR(p, at, ex);
  in->ey = PAIR(p, at, ey);
  in->was_closed = PAIR(p, at, overlap) > 0.0;
  in->active = q.active;
  /* an open contact begins on the side where the disk is */
  q.crossed = p->side[at] != 0.0 && p->side[at] != q.side;
  if (q.crossed) q.side = p->side[at];
  in->arc = s->radius[a] * s->theta[a] + q.side * q.arc;
  return q;
}

/* The wall feels the torque about its pivot: -tau R_a, and the arm from there to the disk's centre. */
static inline void act_segment(engine *e, size_t at, law_push_w1 push) {
  const sd_state *s = e->state;
  work *w = &e->work;
  const pairs *p = &w->pairs;
  int32_t a = p->a[at], b = p->b[at];
  double rx = s->x[a] - s->x[b], ry = s->y[a] - s->y[b];
  double turn = rx * push.fy - ry * push.fx - push.tau * s->radius[a];
  double *on_a = w->sums.row + PAIR(p, at, sum_a), *on_b = w->sums.row + PAIR(p, at, sum_b);
  on_b[SUM_X] += push.fx;
  on_b[SUM_Y] += push.fy;
  on_b[SUM_TURN] += turn;
  on_a[SUM_X] -= push.fx;
  on_a[SUM_Y] -= push.fy;
  on_a[SUM_TURN] += push.tau;
}

static inline void segment_pass(engine *e, thread_work *mine, size_t at, int pass) {
  work *w = &e->work;
  pairs *p = &w->pairs;
  place_w1 here = place_of_w1(p, at);
  law_input_w1 in;
  nearest_point q = segment_input(e, at, &in);
  law_constants_w1 k = constants_of_w1(w, here.b->law + here.l);
  law_geometry_w1 g = law_geometry_of_w1(&in);
  law_output_w1 out = law_w1(&in, &g, &k);
  double acted = here.b->acted[here.l];
  if (pass & PASS_FORCE) {
    /* the force that derives from the skin's energy, in both variants: the paper has no walls */
    law_push_w1 push = law_force_w1(&g, &out, &k, q.flat ? 1.0 : g.lever);
    act_segment(e, at, push);
    acted = here.b->acted[here.l] = size_of_w1(&push);
  }
  if (pass & PASS_COMMIT) {
    law_memory_w1 before, m;
    law_booked_w1 b = slide_w1(w, here, &in, &g, &out, &k, 0, &before, &m);
    if (any_w1(b.rare | law_near_w1(&in, &g, &out, w->dt)))
      turn_over_w1(w, mine, here, &in, &g, &out, &k, e->model->max_overlap * in.sum, acted, &before, &m, &b);
    store_memory_w1(here, &m, &b, 0);
    p->side[at] = out.touching ? q.side : 0.0;
    /* it went around a free end */
    event *v = out.closed && q.crossed ? event_add(&mine->events, (uint32_t)at, 0.0) : NULL;
    if (v) v->ex = PAIR(p, at, ex), v->ey = PAIR(p, at, ey);
  }
}

void KERNEL(kernel_pairs)(engine *e, thread_work *mine, size_t begin, size_t end, int pass);

/* Round pairs go block by block: while the forces of one are worked out, roots and divisions of the next are under way. */
enum { BLOCK_VECTORS = PAIR_BLOCK / VECTOR_WIDTH, STAGES = 2 * BLOCK_VECTORS };

/* The columns of a later block are on their way meanwhile: processors do not foresee them, and have room for some twenty
 * lines at a time, so that each stage asks for a few. (Not a function: one that only fetches is taken for one that does
 * nothing.) */
enum { LINES = offsetof(pair_block, acted) / 64, AHEAD = 8 };
#define FETCH(block, stage)                                                                                  \
  for (size_t line = LINES * (stage) / STAGES; line < LINES * ((stage) + 1) / STAGES; line++)                \
  __builtin_prefetch((const char *)(block) + 64 * line, 0, 3)

LANE_INLINE void see_block(const engine *e, pair_block *b, LANE(law_geometry) g[BLOCK_VECTORS]) {
  LANE(law_sight) seen[BLOCK_VECTORS];
#pragma GCC unroll 4
  for (size_t v = 0; v < BLOCK_VECTORS; v++) {
    FETCH(b + AHEAD, v);
    LANE(see)(&e->work, (LANE(place)){b, v * VECTOR_WIDTH}, &seen[v]);
  }
  for (size_t v = 0; v < BLOCK_VECTORS; v++) LANE(law_geometry_at)(&seen[v], &g[v]);
}

LANE_INLINE void round_pairs(engine *e, thread_work *mine, pair_block *b, size_t blocks, const int kind) {
  const LANE(pass_constants) one = LANE(pass_constants_of)(&e->work);
  LANE(law_geometry) g[2][BLOCK_VECTORS];
  double *sum = e->work.sums.row;
  see_block(e, b, g[0]);
  for (size_t k = 0; k < blocks; k++, b++) {
    if (k + 1 < blocks) see_block(e, b + 1, g[(k + 1) % 2]);
#pragma GCC unroll 4
    for (size_t v = 0; v < BLOCK_VECTORS; v++) {
      FETCH(b + 1 + AHEAD, BLOCK_VECTORS + v);
      LANE(meet)(e, mine, (LANE(place)){b, v * VECTOR_WIDTH}, &g[k % 2][v], &one, sum, kind);
    }
  }
}

static __attribute__((noinline)) void some_pieces(engine *e, thread_work *mine, size_t begin, size_t end,
                                                  int pass) {
  for (size_t at = begin; at < end; at++) segment_pass(e, mine, at, pass);
}

LANE_INLINE void all_pairs(engine *e, thread_work *mine, size_t begin, size_t end, const int kind) {
  const pairs *p = &e->work.pairs;
  const size_t round_end = end < p->first_piece ? end : p->first_piece;
  if (begin < round_end)
    round_pairs(e, mine, p->block + begin / PAIR_BLOCK, (round_end - begin) / PAIR_BLOCK, kind);
  else if (begin < end)
    some_pieces(e, mine, begin, end, kind & (PASS_FORCE | PASS_COMMIT));
}

/* A copy for each kind of pass, so that what it does not do costs nothing. */
#define COPY(kind)                                                                                           \
  case kind:                                                                                                 \
    all_pairs(e, mine, begin, end, kind);                                                                    \
    break
#define COPIES(kind)                                                                                         \
  COPY(kind | PASS_FORCE);                                                                                   \
  COPY(kind | PASS_COMMIT);                                                                                  \
  COPY(kind | PASS_FORCE | PASS_COMMIT)
void KERNEL(kernel_pairs)(engine *e, thread_work *mine, size_t begin, size_t end, int pass) {
  const work *w = &e->work;
  switch (pass | (w->conservative ? 0 : PASS_VARIANT) | (w->one_law ? 0 : PASS_LAWS)) {
    COPIES(0);
    COPIES(PASS_VARIANT);
    COPIES(PASS_LAWS);
    COPIES(PASS_VARIANT | PASS_LAWS);
  }
}
