/* lanes_loop.h: steps of systems in lanes, with what belongs to them: angle records, steps that need the general text. */
#ifndef SLIPDISK_RUN_LANES_LOOP_H
#define SLIPDISK_RUN_LANES_LOOP_H

#include "physics/small/lanes.h"

/* n steps within a phase, or fewer when one of the systems goes wrong: the others are then where it was, and its
 * work.status says so. States are complete before and after. */
void lanes_loop(lanes *l, int64_t n, bool measure);

#endif
