/* outside.h: disks that leave their bounds (sd_bounds in model.h): counted, reported, taken out or a reason to
 * stop. */
#ifndef PHYSICS_OUTSIDE_H
#define PHYSICS_OUTSIDE_H

#include "physics/system/work.h"

/* Steps between two looks. */
enum { OUTSIDE_EVERY = 256 };
/* So many are told of one by one, in a run and at its end; the rest is counted. */
enum { OUTSIDE_TOLD = 8 };

/* Looks at the disks of all ranks, between steps, on one thread of each; collective. Those newly
 * beyond the bounds become SD_OUTSIDE or SD_REMOVED, with a warning each (the first few, then
 * counted); one that comes back is in play as before. Bounds change with the lengths of the
 * region. The energy that removed disks take along is booked in state->energy_start.
 * SD_ERROR_NUMERIC when the run shall stop. */
sd_status outside_look(engine *e, sd_messages *messages);

/* Disks that are beyond the bounds now, or were taken out. */
int64_t outside_count(const sd_state *state);

#endif
