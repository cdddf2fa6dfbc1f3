/* clump_step.h: predictor and corrector of clumps (physics/system/clumps.h), called before and
 * after those of the disks. */
#ifndef PHYSICS_CLUMP_STEP_H
#define PHYSICS_CLUMP_STEP_H

#include "physics/system/clumps.h"

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

#endif
