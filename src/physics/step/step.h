/* step.h: one time step of one system, its parts, and the displacement limit. */
#ifndef PHYSICS_STEP_H
#define PHYSICS_STEP_H

#include "physics/system/clumps.h"
#include "physics/system/work.h"

/* Advances the system by one step. Every thread of the team calls it. After the call threads must
 * wait once more (team_wait) before they read the state or work.status, or take the next step. */
void step_once(engine *e, const team *t);
/* Prepares for n steps, also after bodies were changed; call it on one thread. Contact forces on
 * free disks are stored in the state only after the last of these steps (in phases that change
 * velocities between steps, after each). They are not stored if a step fails in a system with so
 * many disks that chunks reuse rows. */
void step_begin(engine *e, int64_t n);

/* Exchanges flags between ranks. Returns the bits (HALO_STALE, ...) that at least one rank has set;
 * HALO_STALE means that the lists must be rebuilt before the next step. stop: true if this rank
 * wants all ranks to stop. Collective; one thread of each rank calls it before each step and after
 * the last. */
unsigned step_agree(engine *e, bool stop);

/* Prediction, evaluation of contacts and correction, chunk by chunk, while the data of a chunk are
 * in the cache. Step 0 and the compression of a packing use these functions, too. */

/* Predicts the free disks of chunk k at t + dt; only the first call in a step has an effect. */
void chunk_predict(engine *e, size_t k);
/* Predicts the disks of chunk k, unless this was done in this step already. Copies the predicted
 * coordinates to the rows of packed bodies, which pairs read, and clears the disks' force sums. */
void chunk_pack(engine *e, size_t k);
void chunk_correct(engine *e, thread_work *mine, size_t k);
/* Evaluates the contacts of chunk k with round bodies, and with wall segments: forces, lambda_ref,
 * losses. The disks that the pairs read must be packed. */
void chunk_round_pairs(engine *e, thread_work *mine, size_t k);
void chunk_segments(engine *e, thread_work *mine, size_t k);
/* Predicts, evaluates and corrects the chunks of thread t. Chunks marked boundary_last are
 * corrected later, after the other threads. */
void chunks_step(engine *e, int t);
/* Evaluates the contacts with ghosts of thread t, after halo_finish has received the poses of the
 * ghosts. The disks are corrected later. */
void chunks_ghosts(engine *e, int t);
/* Computes the contact forces on all bodies at the present coordinates, and stores them in the
 * state; call it on one thread, between steps. CHUNKS_EVALUATE evaluates each contact and updates
 * its record; CHUNKS_SUM only adds up the forces that follow from the records. */
typedef enum chunks_kind { CHUNKS_EVALUATE, CHUNKS_SUM } chunks_kind;
void chunks_forces(engine *e, chunks_kind kind);

/* Predictor and corrector of clumps (physics/system/clumps.h), called after those of the disks. */

/* Predicts the coordinates of clumps; the first thread then sets the prescribed ones from their
 * motions. Every thread of the team calls this and the next two functions for its range of clumps,
 * and the team must wait between the calls. */
void clumps_predict(engine *e, const team *t);
/* Moves the disks of the clumps to the clumps' predicted poses. */
void clumps_place(engine *e, const team *t);
/* Corrects the clumps with the contact forces on their disks, and moves the disks to the corrected
 * poses. */
void clumps_correct(engine *e, const team *t);
/* Wraps the angle of clump k into [-4, 4] and its position into the periodic box. The clump's disks
 * are wrapped one by one by contacts_events. */
void clumps_wrap(engine *e, size_t k);

/* --- multiplies the lengths of the region by a factor ----------------------------------------- */

/* Multiplies all lengths by f, about the lower corner of the region, then evaluates contacts,
 * forces and accelerations of the new state. Collective. Returns SD_ERROR_IO if memory runs out,
 * SD_ERROR_NUMERIC if an overlap is beyond the limit. */
sd_status rescale(engine *e, double f, sd_messages *messages);
/* Evaluates all contacts of a system whose bodies or constants were changed between two steps, at
 * their present overlaps: they may open, begin or slide. Forces and accelerations follow. Viscous
 * losses and nonconservative work stay as they were, so that only sliding loses energy.
 * Collective; statuses as those of rescale. */
sd_status renew_forces(engine *e, sd_messages *messages);

/* The displacement limit (model->limits.displacement), a warning against steps in which bodies
 * might pass through each other: in one step no free disk should move by more than this fraction of
 * its radius, and no prescribed body by more than this fraction of the smallest radius. A
 * prescribed body that jumps, that is, moves farther than its velocity explains, is noted from a
 * tenth of the limit on.
 *
 * The correctors compare v^2 with speed_limit2 R^2 and set thread_work.fast. The first disk beyond
 * the limit is noted in the state, and comparisons stop. Each disk is compared at the end of every
 * step, with its velocity at that time, so that the result does not depend on threads, neighbour
 * lists, SIMD lanes or restarts. Prescribed bodies are compared only if a motion may move them far
 * (model/motions.h).
 */

/* Prepares the comparison of speeds with the displacement limit: sets speed_limit2 and
 * compare_motions from model and state. */
void speed_begin(engine *e);
/* Stores the fastest body in the state (fast_step, fast_disk, fast_displacement) if it exceeds the
 * displacement limit. step: number of completed steps. Call it on one thread. */
void speed_check(engine *e, int64_t step);

#endif
