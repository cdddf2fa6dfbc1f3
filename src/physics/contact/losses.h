/* losses.h: what contacts have lost, by contact while they last, and by body afterwards.
 *
 * The commit adds to a contact's own sums, which are its memory. When it ends they go to its bodies: half to each
 * disk, all to the disk whose partner is a wall or prescribed. state->loss_viscous, _friction and nonconservative_work are
 * the sums of both, and are brought up to date where they are read.
 */
#ifndef PHYSICS_LOSSES_H
#define PHYSICS_LOSSES_H

#include "physics/system/work.h"

/* Half of x, or the whole, to the free disks of a contact; a ghost's half is added on its own rank. */
static inline void losses_share(const engine *e, double *sum, int32_t a, int32_t b, double x) {
  const sd_state *s = e->state;
  sum[a] += (size_t)b < s->n_free + s->n_ghosts ? 0.5 * x : x;
  if ((size_t)b < s->n_free) sum[b] += 0.5 * x;
}

/* Contact k of a list has ended: what it has lost becomes its bodies' past. */
void losses_end(engine *e, pairs *p, size_t k);
/* The same for all of a list. */
void losses_end_all(engine *e, pairs *p);
/* Sums of contact k begin anew. */
static inline void losses_forget(pairs *p, size_t k) {
  PAIR(p, k, viscous) = PAIR(p, k, friction) = PAIR(p, k, nonconservative_work) = 0.0;
  if (p->more) MORE(p, k, rolling) = 0.0;
}
/* loss_viscous, loss_friction and nonconservative_work of every free disk, up to now. */
void losses_show(engine *e);

#endif
