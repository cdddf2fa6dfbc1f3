/* relax.h: steering velocities towards mechanical equilibrium (FIRE: Bitzek et al., Phys. Rev. Lett. 97, 170201
 * (2006)), at a fixed time step, with the contact forces as they are, friction included.
 */
#ifndef PACK_RELAX_H
#define PACK_RELAX_H

#include "physics/work.h"

/* After a completed step of a phase that relaxes, on one thread. The kinetic energy that is taken out is booked
 * in state->relaxed. */
void relax_step(engine *e);

#endif
