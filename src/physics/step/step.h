/* step.h: one time step of one system. */
#ifndef PHYSICS_STEP_H
#define PHYSICS_STEP_H

#include "physics/system/work.h"

/* Advances the system by one step. Every thread of the team calls it, and must wait once more
 * (team_wait) before it reads the state or work.status, or takes the next step. */
void step_once(engine *e, const team *t);
/* Prepares for n steps, after bodies may have been changed; call it on one thread. Contact forces
 * on free disks are stored in the state after the last of these steps (after every step while
 * velocities are changed between steps), but not if a step fails in a large system. */
void step_begin(engine *e, int64_t n);

/* Exchanges flags between ranks: returns the bits HALO_STALE ... that any rank has set. Collective;
 * one thread of an engine with a halo calls it before each step and after the last. After
 * HALO_STALE lists must be rebuilt before the next step. stop: this rank wants all ranks to
 * stop. */
unsigned step_agree(engine *e, bool stop);

#endif
