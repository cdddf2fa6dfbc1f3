/* energy.h: the energy budget of the disks (docs/physics.md, section 8), and the energy lost in
 * contacts. */
#ifndef PHYSICS_ENERGY_H
#define PHYSICS_ENERGY_H

#include "physics/system/work.h"
#include "slipdisk/simulation.h"

/* Returns the energy budget of the disks of all ranks, computed from the state and the closed
 * contacts. Collective. */
sd_energy energy_of(engine *e);
/* Returns the residual of the budget of all ranks, to compare it before and after a change between
 * two steps: faster than energy_of, and what the change leaves alone cancels. Collective. */
double energy_residual(engine *e);
/* Returns the energy budget of the disks of this rank and of the contacts that this rank counts: a
 * contact across two ranks is counted by one of them (halo_counts). Not collective. */
sd_energy energy_of_part(const engine *e);

/* Returns the present energy of the system: kinetic, elastic, cohesive and potential energy
 * (external). */
static inline double energy_total(const sd_energy *e) {
  return e->kinetic_translation + e->kinetic_rotation + e->elastic_normal + e->elastic_tangential +
         e->elastic_rolling + e->elastic_bond + e->cohesion + e->external;
}

/* Returns the sum of all losses in an energy budget. */
static inline double energy_lost(const sd_energy *e) {
  return e->viscous + e->friction + e->rolling + e->bridge + e->opening + e->broken_tension +
         e->broken_shear + e->broken_bending + e->drag + e->damping + e->relaxed;
}

/* Energy losses of contacts. They are summed for each contact while it is closed, and for each body
 * afterwards.
 *
 * Each step adds the losses of a contact to the contact's record. When the contact ends, these sums
 * are added to those of the two bodies (state->past_*): half to each disk, or all to the disk if
 * its partner is a wall or prescribed. state->loss_viscous, loss_friction and nonconservative_work
 * include contacts that have ended and those that are closed now; losses_update updates them before
 * they are read.
 */

/* Adds x, a loss in the contact of the bodies in slots a and b, to the column `sum`: half to each
 * free disk, or all to a if b is a wall or prescribed. The half of a ghost is added by the rank
 * that owns the disk. */
static inline void losses_share(const engine *e, double *sum, int32_t a, int32_t b, double x) {
  const sd_state *s = e->state;
  sum[a] += (size_t)b < s->n_free + s->n_ghosts ? 0.5 * x : x;
  if ((size_t)b < s->n_free) sum[b] += 0.5 * x;
}

/* Adds the losses of contact k, which has ended, to the sums of its bodies, and sets those in its
 * record to 0. */
void losses_end(engine *e, pairs *p, size_t k);
/* Adds the energy losses that the contacts of a list of pairs still hold to the losses of their
 * bodies. */
void losses_end_all(engine *e, pairs *p);
/* Sets the losses in the record of contact k to 0. */
static inline void losses_forget(pairs *p, size_t k) {
  PAIR(p, k, viscous) = PAIR(p, k, friction) = PAIR(p, k, nonconservative_work) = 0.0;
  if (p->more) MORE(p, k, rolling) = 0.0;
}
/* Updates loss_viscous, loss_friction and nonconservative_work in the state, for every free
 * disk. */
void losses_update(engine *e);

#endif
