/* energy.h: the energy budget (physics.md 9). */
#ifndef PHYSICS_ENERGY_H
#define PHYSICS_ENERGY_H

#include "physics/work.h"
#include "slipdisk/simulation.h"

/* All terms from state and live contacts. */
sd_energy energy_of(const engine *e);

#endif
