/* step.h: one time step of one system. */
#ifndef PHYSICS_STEP_H
#define PHYSICS_STEP_H

#include "physics/work.h"

/* Advances by one step; every member of the team calls it, and waits once more before it reads the state
 * or work.status, or takes the next step. */
void step_once(engine *e, const team *t);
/* Before steps, on one thread, after whatever was done to prescribed bodies between steps. */
void step_begin(engine *e);

#endif
