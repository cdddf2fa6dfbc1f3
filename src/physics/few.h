/* few.h: the step of few free disks among prescribed ones, in one function.
 *
 * With three disks, the time of a step goes into calls, pointers and single numbers, not into the law. Here
 * the coordinates (x, y, theta, nothing) of a body stand side by side, so that predictor and corrector are
 * one vector each, and the whole step is one call. The text of law, commit, predictor and corrector is that
 * of the general step, the sums run in the same order, and so every bit is the same (a test compares).
 *
 * With Gear, history is written when the next step has its trial coordinates (or by few_finish): the commit
 * of one step and the forces of the next do not depend on each other but for lambda*, and a processor that
 * has both at hand waits for one chain of operations instead of two. Nothing else changes its order.
 *
 * While few_step is used, poses and derivatives live in struct few; few_store brings them to the state.
 * Contact memory, losses, angles of free disks and the step counter are in their usual places all the time.
 */
#ifndef PHYSICS_FEW_H
#define PHYSICS_FEW_H

#include "physics/motion.h"
#include "physics/work.h"

enum { FEW_FREE = 4, FEW_BODIES = 16 };

typedef double few_rows[FEW_BODIES][4]; /* x, y, theta, nothing of each slot */

typedef struct few_place {
  double *at, *speed;
  const double *force;
  placed *from;
} few_place;

typedef struct few {
  _Alignas(64) few_rows q, v, force;
  few_rows q_before, v_before;                /* corrected, of the step whose commit is pending */
  few_rows q2, q3, q4, q5, constant, inverse; /* free disks */
  double radius[FEW_BODIES][4];               /* radius in the first place */
  columns columns;                            /* the rows above as one long column */
  int32_t *a, *b;                             /* 4 * slot of each pair */
  size_t pairs_capacity;
  size_t n_places, places_capacity;
  few_place *places;
  bool pending;   /* the last step's history is not written yet */
  int64_t builds; /* of the list that a, b belong to */
} few;

/* Room for it when the system is of that kind (no straight walls, open box, one thread, neither rain nor
 * relaxer, compression, loads, servos, disks that are taken out or whose means are asked for), else nothing: e->work.few stays NULL. */
sd_status few_new(engine *e);
void few_free(engine *e);

/* Poses and derivatives from the state, and back. */
sd_status few_load(engine *e);
void few_store(engine *e);

/* Can the next step be taken by the few_step kernel? Computes motions ahead when their batch is used up. */
bool few_ready(engine *e);

/* What is rare, from within the kernels: lists are stale after the trial coordinates (a pending commit is
 * done first, on the old ones); contact events of a commit. */
sd_status few_rebuild(engine *e, few_measure *measure);
sd_status few_events(engine *e);

#endif
