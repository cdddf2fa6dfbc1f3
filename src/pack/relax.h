/* relax.h: steering velocities towards mechanical equilibrium (FIRE: Bitzek et al., Phys. Rev. Lett. 97, 170201
 * (2006)), at a fixed time step, with the contact forces as they are, friction and viscosity included.
 *
 * Coordinates are taken times the root of their mass or moment of inertia, so that x, y and the angle have one
 * unit. What has come out of the steering is state: relax_alpha, relax_steps, relaxed.
 */
#ifndef PACK_RELAX_H
#define PACK_RELAX_H

#include "base/team.h"
#include "physics/system/work.h"

/* Of the whole team: what its threads have summed, block of disks by block. */
enum { RELAX_BLOCKS = 64 };
typedef struct relax_sums {
  double power[RELAX_BLOCKS], speed2[RELAX_BLOCKS], push2[RELAX_BLOCKS];
} relax_sums;

/* A phase begins: the steering starts afresh. */
void relax_begin(engine *e);
/* After a completed step of a phase that relaxes, by the whole team; velocities are the new ones after it. The
 * kinetic energy that is taken out is booked in state->relaxed. Prescribed and locked coordinates and disks that
 * are not in play are left alone. */
void relax_step(engine *e, const team *t, relax_sums *team_sums);

#endif
