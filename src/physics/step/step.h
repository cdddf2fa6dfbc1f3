/* step.h: one time step of one system. */
#ifndef PHYSICS_STEP_H
#define PHYSICS_STEP_H

#include "physics/system/clumps.h"
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

/* Prediction, evaluation of contacts and correction, chunk by chunk, while the data of a
 * chunk are in the cache. Used by the step, by step 0 and by compression.
 */

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

/* Predictor and corrector of clumps (physics/system/clumps.h), called before and
 * after those of the disks. */

/* Predicts the clumps: coordinates that are not prescribed by the predictor; the first thread also
 * sets the prescribed ones. Every thread of the team calls this and the next two functions for its
 * range of the clumps; the team must wait between the calls. */
void clumps_predict(engine *e, const team *t);
/* Places the disks of the clumps at the clumps' predicted poses. */
void clumps_place(engine *e, const team *t);
/* Corrects the clumps with the forces on their disks, and places the disks again. */
void clumps_correct(engine *e, const team *t);
/* Wraps angle and position of clump k into their ranges; its disks are wrapped on their own. */
void clumps_wrap(engine *e, size_t k);

/* --- multiplies the lengths of the region by a factor ----------------------------------------- */

/* Multiplies all lengths by f about the region's corner, then evaluates contacts, forces and
 * accelerations of the new state. Collective. Returns SD_ERROR_IO if memory runs out,
 * SD_ERROR_NUMERIC if an overlap is beyond the limit. */
sd_status rescale(engine *e, double f, sd_messages *messages);

/* The displacement limit: within one step no free disk should move by more than a fraction
 * of its radius, and no prescribed body by more than this fraction of the smallest radius, since
 * bodies might pass through each other (model->limits.displacement). A prescribed body that jumps,
 * moving farther than its velocity explains, is noted from a tenth of the limit on.
 *
 * The correctors compare v^2 with speed_limit2 R^2 and set thread_work.fast; the first disk beyond
 * the limit is noted in the state, and comparisons stop. Each disk is compared at the end of every
 * step with its speed at that time, so that threads, neighbour lists, lanes and restarts make no
 * difference. Prescribed bodies are compared only if a motion may move them far
 * (model/motions.h).
 */

/* Sets speed_limit2 and compare_motions from model and state. */
void speed_begin(engine *e);
/* Notes the fastest body in the state if it is beyond the limit. step: number of completed steps.
 * Call it on one thread. */
void speed_check(engine *e, int64_t step);

#endif
