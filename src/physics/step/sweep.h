/* sweep.h: chunk by chunk: trial coordinates, forces, correction, commit, while a chunk is in the cache. What the step, step 0
 * and compression are made of.
 */
#ifndef PHYSICS_SWEEP_H
#define PHYSICS_SWEEP_H

#include "physics/system/work.h"

/* Trial coordinates of chunk k at t + dt, once a step. */
void sweep_predict(engine *e, size_t k);
/* The same, and pairs see them; nothing has acted on its disks yet. */
void sweep_seat(engine *e, size_t k);
void sweep_correct(engine *e, thread_work *mine, size_t k);
/* The chunks of share t, but for corrections and commits that wait for others. */
void sweep_share(engine *e, int t);
/* Commits of share t that have waited for all, or all of them. */
void sweep_commit_last(engine *e, int t);
/* Forces at the present coordinates, to the state, and what contacts remember of them. On one thread, between steps. */
void sweep_forces(engine *e);

#endif
