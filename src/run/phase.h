/* phase.h: how phases begin and end for one engine, that of a whole system or of one rank of several. */
#ifndef RUN_PHASE_H
#define RUN_PHASE_H

#include "pack/settle.h"
#include "physics/system/work.h"

/* Does the present phase measure? */
bool phase_measures(const engine *e);
void phase_measure_begin(engine *e);
/* The settle criteria are looked at after this step, if there are any. */
bool phase_settles(const engine *e);
/* Stops measuring, notes the goals of the phase and its values at the end, and goes on to the next, which has not begun.
 * rest: of all disks; NULL: the phase has no settle criteria. */
void phase_end(engine *e, const settle_measure *rest);

#endif
