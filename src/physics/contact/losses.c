/* losses.c: see losses.h. */
#include "physics/contact/losses.h"

#include <assert.h>

#include "physics/contact/pairs.h"

void losses_end(engine *e, pairs *p, size_t k) {
  sd_state *s = e->state;
  double *viscous = &PAIR(p, k, viscous), *friction = &PAIR(p, k, friction),
         *beyond = &PAIR(p, k, nonconservative_work);
  if (*viscous != 0.0) losses_share(e, s->past_viscous, p->a[k], p->b[k], *viscous);
  if (*friction != 0.0) losses_share(e, s->past_friction, p->a[k], p->b[k], *friction);
  if (*beyond != 0.0) losses_share(e, s->past_nonconservative_work, p->a[k], p->b[k], *beyond);
  assert((*viscous == 0.0 && *friction == 0.0 && *beyond == 0.0) || p->a[k] != PAIR_PADDING);
  if (p->more && MORE(p, k, rolling) != 0.0)
    losses_share(e, s->past_rolling, p->a[k], p->b[k], MORE(p, k, rolling));
  losses_forget(p, k);
}

/* Sums are added in the order of the pairs, by one thread; all look for pieces of the list in which there are any. */
enum { PIECES = 256 };
typedef struct look_task {
  const pairs *p;
  bool any[PIECES];
} look_task;

static size_t piece_begin(const pairs *p, size_t piece) {
  return (p->count + PAIR_BLOCK - 1) / PAIR_BLOCK * piece / PIECES;
}

static bool any_loss(const pairs *p, size_t block) {
  const pair_block *b = &p->block[block];
  bool any = false;
  for (size_t k = 0; k < PAIR_BLOCK; k++)
    any |= b->viscous[k] != 0.0 || b->friction[k] != 0.0 || b->nonconservative_work[k] != 0.0;
  for (size_t k = 0; p->more && k < PAIR_BLOCK; k++) any |= p->more[block].rolling[k] != 0.0;
  return any;
}

static void look_together(const team *t, void *with) {
  look_task *l = with;
  for (size_t piece = (size_t)t->rank; piece < PIECES; piece += (size_t)t->size) {
    l->any[piece] = false;
    for (size_t b = piece_begin(l->p, piece); b < piece_begin(l->p, piece + 1) && !l->any[piece]; b++)
      l->any[piece] = any_loss(l->p, b);
  }
}

void losses_end_all(engine *e, pairs *p) {
  look_task l = {.p = p};
  pool_run(work_pool(e), look_together, &l);
  for (size_t piece = 0; piece < PIECES; piece++)
    for (size_t b = piece_begin(p, piece); l.any[piece] && b < piece_begin(p, piece + 1); b++)
      for (size_t k = PAIR_BLOCK * b; k < PAIR_BLOCK * (b + 1) && k < p->count; k++)
        if (p->a[k] >= 0) losses_end(e, p, k);
}

/* In the order of the pairs. */
void losses_show(engine *e) {
  sd_state *s = e->state;
  const incidence *n = &e->work.incidence;
  const pairs *p = &e->work.pairs;
  for (size_t i = 0; i < s->n_free; i++) {
    double viscous = 0.0, friction = 0.0, beyond = 0.0;
    for (size_t at = n->start[i]; at < n->start[i + 1]; at++) {
      size_t k = n->entry[at] / 2, other = (size_t)(n->entry[at] & 1 ? p->a[k] : p->b[k]);
      double share = other < s->n_free + s->n_ghosts ? 0.5 : 1.0;
      viscous += share * PAIR(p, k, viscous);
      friction += share * PAIR(p, k, friction);
      beyond += share * PAIR(p, k, nonconservative_work);
    }
    s->loss_viscous[i] = s->past_viscous[i] + viscous;
    s->loss_friction[i] = s->past_friction[i] + friction;
    s->nonconservative_work[i] = s->past_nonconservative_work[i] + beyond;
  }
}
