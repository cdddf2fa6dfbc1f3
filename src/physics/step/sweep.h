/* sweep.h: prediction, evaluation of contacts and correction, chunk by chunk, while the data of a
 * chunk are in the cache. Used by the step, by step 0 and by compression.
 */
#ifndef PHYSICS_SWEEP_H
#define PHYSICS_SWEEP_H

#include "physics/system/work.h"

/* Predicts the disks of chunk k at t + dt, once per step. */
void sweep_predict(engine *e, size_t k);
/* Predicts chunk k unless that has been done, packs its bodies, and clears their force sums. */
void sweep_pack(engine *e, size_t k);
void sweep_correct(engine *e, thread_work *mine, size_t k);
/* Treats the chunks of thread range t, except corrections that must wait for other threads. */
void sweep_share(engine *e, int t);
/* Evaluates range t of the contacts with ghosts, after halo_finish; the disks are corrected
 * later. */
void sweep_ghosts(engine *e, int t);
/* Computes the contact forces on all bodies at the present coordinates, and stores them in the
 * state; call it on one thread, between steps. SWEEP_EVALUATE evaluates each contact and updates
 * its record; SWEEP_SUM adds up the forces in the records. */
typedef enum sweep_kind { SWEEP_EVALUATE, SWEEP_SUM } sweep_kind;
void sweep_forces(engine *e, sweep_kind kind);

#endif
