/* speed.h: the displacement limit: within one step no free disk should move by more than a fraction
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
#ifndef PHYSICS_SPEED_H
#define PHYSICS_SPEED_H

#include "physics/system/work.h"

/* Sets speed_limit2 and compare_motions from model and state. */
void speed_begin(engine *e);
/* Notes the fastest body in the state if it is beyond the limit. step: number of completed steps.
 * Call it on one thread. */
void speed_check(engine *e, int64_t step);

#endif
