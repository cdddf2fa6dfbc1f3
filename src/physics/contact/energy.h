/* energy.h: the energy budget (physics.md 8), and what contacts have lost. */
#ifndef PHYSICS_ENERGY_H
#define PHYSICS_ENERGY_H

#include "physics/system/work.h"
#include "slipdisk/simulation.h"

/* All terms from state and live contacts, of the disks of all ranks. Collective. */
sd_energy energy_of(engine *e);
/* The terms of those disks and contacts that this rank counts. Not collective. */
sd_energy energy_of_part(const engine *e);

/* What the system holds now: kinetic, elastic and external. */
static inline double energy_total(const sd_energy *e) {
  return e->kinetic_translation + e->kinetic_rotation + e->elastic_normal + e->elastic_tangential +
         e->elastic_rolling + e->cohesion + e->external;
}

/* Sum of its losses. */
static inline double energy_lost(const sd_energy *e) {
  return e->viscous + e->friction + e->rolling + e->bridge + e->opening + e->drag + e->damping +
         e->relaxed;
}

/* Losses of contacts: kept by contact while it lasts, and by body afterwards.
 *
 * The commit adds to a contact's own sums, which are its memory. When it ends they go to its bodies: half to each
 * disk, all to the disk whose partner is a wall or prescribed. state->loss_viscous, _friction and nonconservative_work are
 * the sums of both, and are brought up to date where they are read.
 */

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
