/* energy.h: the energy budget (physics.md 8). */
#ifndef PHYSICS_ENERGY_H
#define PHYSICS_ENERGY_H

#include "physics/system/work.h"
#include "slipdisk/simulation.h"

/* All terms from state and live contacts. */
sd_energy energy_of(const engine *e);

/* What the system holds now: kinetic, elastic and external. */
static inline double energy_total(const sd_energy *e) {
  return e->kinetic_translation + e->kinetic_rotation + e->elastic_normal + e->elastic_tangential +
         e->external;
}

#endif
