/* energy.h: the energy budget (physics.md 8). */
#ifndef PHYSICS_ENERGY_H
#define PHYSICS_ENERGY_H

#include "base/exact_sum.h"
#include "physics/system/work.h"
#include "slipdisk/simulation.h"

/* All terms from state and live contacts. */
sd_energy energy_of(const engine *e);

/* The sums over disks and contacts that it is made of, a member of sd_energy each; those of one rank of several, whose poses
 * of ghosts are refreshed. They are exact, so that sums of the ranks' sums are those of one process. */
enum { ENERGY_SUMS = sizeof(sd_energy) / sizeof(double) };
typedef struct energy_sums {
  exact_sum of[ENERGY_SUMS];
} energy_sums;
void energy_add_up(const engine *e, energy_sums *sums);
/* The budget that they make. */
sd_energy energy_of_sums(const sd_state *s, const energy_sums *sums);

/* What the system holds now: kinetic, elastic and external. */
static inline double energy_total(const sd_energy *e) {
  return e->kinetic_translation + e->kinetic_rotation + e->elastic_normal + e->elastic_tangential +
         e->elastic_rolling + e->cohesion + e->external;
}

/* Sum of its losses. */
static inline double energy_lost(const sd_energy *e) {
  return e->viscous + e->friction + e->rolling + e->bridge + e->opening + e->drag + e->damping + e->relaxed;
}

#endif
