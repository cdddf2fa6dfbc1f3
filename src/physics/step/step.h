/* step.h: one time step of one system. */
#ifndef PHYSICS_STEP_H
#define PHYSICS_STEP_H

#include "physics/system/work.h"

/* Advances by one step; every member of the team calls it, and waits once more before it reads the state
 * or work.status, or takes the next step. */
void step_once(engine *e, const team *t);
/* Before n steps, on one thread, after whatever was done to bodies between steps. The forces on free disks are in the state
 * after the last of them, and where velocities are steered after each; not after a step that failed in a large system. */
void step_begin(engine *e, int64_t n);

/* Collective, of an engine with a halo, by one thread before each step and after the last: bits HALO_STALE ... of all ranks. With
 * HALO_STALE no step may follow before new lists. stop: this rank wants all to stop. */
unsigned step_agree(engine *e, bool stop);

#endif
