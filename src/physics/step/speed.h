/* speed.h: the displacement limit: no free disk should move by more than a fraction of its radius in a step, and no
 * prescribed body by more than that of the smallest disk, or one may pass through others (model->limits.displacement). A
 * prescribed body that jumps, farther than its velocities take it, is noted from a tenth of that on.
 *
 * The correctors compare v^2 with speed_limit2 R^2 and set thread_work.fast; the first disk beyond the limit is noted in the
 * state, and nothing is compared from then on. Each disk is compared at the end of every step with the speed that it has then,
 * so that threads, neighbour lists, lanes and restarts make no difference. Prescribed bodies are compared where a motion may move them
 * far (model/motions.h).
 */
#ifndef PHYSICS_SPEED_H
#define PHYSICS_SPEED_H

#include "physics/system/work.h"

/* Sets speed_limit2 and compare_motions from model and state. */
void speed_begin(engine *e);
/* Notes the fastest disk in the state when it is beyond the limit; `step`: completed steps. One thread. */
void speed_check(engine *e, int64_t step);

#endif
