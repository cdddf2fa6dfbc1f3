/* relax.h: steers velocities towards mechanical equilibrium (FIRE: Bitzek et al., Phys. Rev. Lett.
 * 97, 170201 (2006)), at a fixed time step, with the contact forces of the run, friction and
 * viscosity included.
 *
 * Coordinates are scaled by the square root of their mass or moment of inertia, so that x, y and
 * the angle have one unit. The algorithm's variables are part of the state: relax_alpha,
 * relax_steps, relaxed. */
#ifndef PACK_RELAX_H
#define PACK_RELAX_H

#include "base/exact_sum.h"
#include "base/team.h"
#include "physics/system/work.h"

/* Indices of the sums over the free coordinates: power F.v, squared speed sum M v^2, squared force
 * sum F^2/M; their number. Each thread has a relax_sums of its own; `total` of the first thread
 * holds the sums over all threads and ranks. */
enum { RELAX_POWER, RELAX_SPEED2, RELAX_PUSH2, RELAX_SUMS };
typedef struct relax_sums {
  exact_sum of[RELAX_SUMS];
  double total[RELAX_SUMS];
} relax_sums;

/* Resets the algorithm (FIRE) at the beginning of a phase that relaxes. */
void relax_begin(engine *e);
/* Changes the velocities after a completed step of a phase that relaxes. Called by all threads of
 * each rank (collective). The kinetic energy that it removes is added to state->relaxed. Prescribed
 * and locked coordinates, and disks that are not in play, stay as they are. of_team: one element
 * for each thread. */
void relax_step(engine *e, const team *t, relax_sums *of_team);

#endif
