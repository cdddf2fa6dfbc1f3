/* energy.h: the energy budget (docs/physics.md, section 8), and the energy lost in contacts. */
#ifndef PHYSICS_ENERGY_H
#define PHYSICS_ENERGY_H

#include "physics/system/work.h"
#include "slipdisk/simulation.h"

/* Returns the energy budget of the disks of all ranks, from the state and the closed contacts.
 * Collective. */
sd_energy energy_of(engine *e);
/* Returns the energy budget of the disks of this rank and of the contacts that it counts
 * (halo_counts). Not collective. */
sd_energy energy_of_part(const engine *e);

/* Returns the present energy of the system: kinetic, elastic, cohesive and external. */
static inline double energy_total(const sd_energy *e) {
  return e->kinetic_translation + e->kinetic_rotation + e->elastic_normal + e->elastic_tangential +
         e->elastic_rolling + e->cohesion + e->external;
}

/* Returns the sum of all losses in a budget. */
static inline double energy_lost(const sd_energy *e) {
  return e->viscous + e->friction + e->rolling + e->bridge + e->opening + e->drag + e->damping +
         e->relaxed;
}

/* Losses of contacts. They are summed per contact while it lasts, and per body afterwards.
 *
 * Each step adds the losses of a contact to its record. When the contact ends, the sums are added
 * to those of its bodies (state->past_*): half to each disk, or all to the disk if its partner is a
 * wall or prescribed. state->loss_viscous, loss_friction and nonconservative_work include both
 * ended and present contacts; losses_show updates them before they are read.
 */

/* Distributes x, a loss of the contact of a and b, to the column `sum`: half to each free disk, or
 * all to a if b is a wall or prescribed. The half of a ghost is added on its own rank. */
static inline void losses_share(const engine *e, double *sum, int32_t a, int32_t b, double x) {
  const sd_state *s = e->state;
  sum[a] += (size_t)b < s->n_free + s->n_ghosts ? 0.5 * x : x;
  if ((size_t)b < s->n_free) sum[b] += 0.5 * x;
}

/* Moves the losses of contact k, which has ended, to its bodies. */
void losses_end(engine *e, pairs *p, size_t k);
/* Moves the losses that are left in a list of pairs to the bodies. */
void losses_end_all(engine *e, pairs *p);
/* Sets the losses in the record of contact k to 0. */
static inline void losses_forget(pairs *p, size_t k) {
  PAIR(p, k, viscous) = PAIR(p, k, friction) = PAIR(p, k, nonconservative_work) = 0.0;
  if (p->more) MORE(p, k, rolling) = 0.0;
}
/* Updates loss_viscous, loss_friction and nonconservative_work in the state, for every free
 * disk. */
void losses_show(engine *e);

#endif
