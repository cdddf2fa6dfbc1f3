/* clump_step.h: predictor and corrector of clumps (physics/system/clumps.h), around those of the disks. */
#ifndef PHYSICS_CLUMP_STEP_H
#define PHYSICS_CLUMP_STEP_H

#include "physics/system/clumps.h"

/* Each thread of the team takes its share of the clumps; between the calls the team waits. */
void clumps_predict(
    engine *e,
    const team *t); /* coordinates that are not prescribed; the first thread poses those that are */
void clumps_place(engine *e, const team *t); /* their disks */
void clumps_correct(engine *e,
                    const team *t); /* from the forces on the disks, which are placed again */
/* Angle and position back into range; its disks return by themselves. */
void clumps_wrap(engine *e, size_t k);

#endif
