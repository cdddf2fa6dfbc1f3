/* relax.h: steering velocities towards mechanical equilibrium (FIRE: Bitzek et al., Phys. Rev. Lett. 97, 170201
 * (2006)), at a fixed time step, with the contact forces as they are, friction and viscosity included.
 *
 * Coordinates are taken times the root of their mass or moment of inertia, so that x, y and the angle have one
 * unit. What has come out of the steering is state: relax_alpha, relax_steps, relaxed.
 */
#ifndef PACK_RELAX_H
#define PACK_RELAX_H

#include "physics/work.h"

/* A phase begins: the steering starts afresh. */
void relax_begin(engine *e);
/* After a completed step of a phase that relaxes, on one thread. The kinetic energy that is taken out is booked
 * in state->relaxed. Prescribed and locked coordinates and disks that are not in play are left alone. */
void relax_step(engine *e);

#endif
