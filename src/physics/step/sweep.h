/* sweep.h: chunk by chunk: prediction, forces and history, correction, while a chunk is in the cache. The step, step 0 and
 * compression are made of it.
 */
#ifndef PHYSICS_SWEEP_H
#define PHYSICS_SWEEP_H

#include "physics/system/work.h"

/* Predicts chunk k at t + dt, once a step. */
void sweep_predict(engine *e, size_t k);
/* The same, and packs its bodies, with no force on them yet. */
void sweep_pack(engine *e, size_t k);
void sweep_correct(engine *e, thread_work *mine, size_t k);
/* The chunks of share t, but for corrections that wait for other threads. */
void sweep_share(engine *e, int t);
/* After halo_finish: share t of the contacts with ghosts, whose disks wait for their corrections. */
void sweep_ghosts(engine *e, int t);
/* Forces on all bodies at the present coordinates, to the state; on one thread, between steps.
 * SWEEP_EVALUATE evaluates each contact and commits its history; SWEEP_SUM adds up the forces that
 * contacts remember. */
typedef enum sweep_kind { SWEEP_EVALUATE, SWEEP_SUM } sweep_kind;
void sweep_forces(engine *e, sweep_kind kind);

#endif
