/* relax.h: steering velocities towards mechanical equilibrium (FIRE: Bitzek et al., Phys. Rev. Lett. 97, 170201
 * (2006)), at a fixed time step, with the contact forces as they are, friction and viscosity included.
 *
 * Coordinates are taken times the root of their mass or moment of inertia, so that x, y and the angle have one
 * unit. What has come out of the steering is state: relax_alpha, relax_steps, relaxed.
 */
#ifndef PACK_RELAX_H
#define PACK_RELAX_H

#include "base/exact_sum.h"
#include "base/team.h"
#include "physics/system/work.h"

/* Sums over the free coordinates: power, and the squares of both norms. One a thread; `total`, in
 * the first, is of all, on all ranks. */
enum { RELAX_POWER, RELAX_SPEED2, RELAX_PUSH2, RELAX_SUMS };
typedef struct relax_sums {
  exact_sum of[RELAX_SUMS];
  double total[RELAX_SUMS];
} relax_sums;

/* A phase begins: the steering starts afresh. */
void relax_begin(engine *e);
/* After a completed step of a phase that relaxes, by the whole team of each rank (collective);
 * velocities are the new ones after it. The kinetic energy that is taken out is booked in
 * state->relaxed. Prescribed and locked coordinates and disks that are not in play are left
 * alone. of_team: one for each thread of the team. */
void relax_step(engine *e, const team *t, relax_sums *of_team);

#endif
