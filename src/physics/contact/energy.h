/* energy.h: the energy budget (physics.md 8). */
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
  return e->viscous + e->friction + e->rolling + e->bridge + e->opening + e->drag + e->damping + e->relaxed;
}

#endif
