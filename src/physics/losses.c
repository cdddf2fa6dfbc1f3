/* losses.c: see losses.h. */
#include "physics/losses.h"

void losses_end(engine *e, pairs *p, size_t k) {
  sd_state *s = e->state;
  if (p->viscous[k] != 0.0) losses_share(e, s->past_viscous, p->a[k], p->b[k], p->viscous[k]);
  if (p->friction[k] != 0.0) losses_share(e, s->past_friction, p->a[k], p->b[k], p->friction[k]);
  if (p->gain[k] != 0.0) losses_share(e, s->past_gain, p->a[k], p->b[k], p->gain[k]);
  p->viscous[k] = p->friction[k] = p->gain[k] = 0.0;
}

/* In the order of the partners' keys. */
static void show(const engine *e, size_t i, const double *past, const double *of_contact, double *sum) {
  const incidence *n = &e->work.incidence;
  const pairs *p = &e->work.pairs;
  double now = 0.0;
  for (size_t at = n->start[i]; at < n->start[i + 1]; at++) {
    size_t k = n->entry[at] / 2;
    int32_t other = n->entry[at] & 1 ? p->a[k] : p->b[k];
    now += ((size_t)other < e->state->n_free ? 0.5 : 1.0) * of_contact[k];
  }
  sum[i] = past[i] + now;
}

void losses_show(engine *e) {
  sd_state *s = e->state;
  const pairs *p = &e->work.pairs;
  for (size_t i = 0; i < s->n_free; i++) {
    show(e, i, s->past_viscous, p->viscous, s->loss_viscous);
    show(e, i, s->past_friction, p->friction, s->loss_friction);
    show(e, i, s->past_gain, p->gain, s->gain_variant);
  }
}
