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
  *viscous = *friction = *beyond = 0.0;
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
      double share = other < s->n_free ? 0.5 : 1.0;
      viscous += share * PAIR(p, k, viscous);
      friction += share * PAIR(p, k, friction);
      beyond += share * PAIR(p, k, nonconservative_work);
    }
    s->loss_viscous[i] = s->past_viscous[i] + viscous;
    s->loss_friction[i] = s->past_friction[i] + friction;
    s->nonconservative_work[i] = s->past_nonconservative_work[i] + beyond;
  }
}
