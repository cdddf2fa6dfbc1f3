/* outside.h: disks that leave the bounds of the run (sd_bounds in model.h): they are counted and
 * reported, and may be taken out or stop the run. */
#ifndef PHYSICS_OUTSIDE_H
#define PHYSICS_OUTSIDE_H

#include "physics/system/work.h"

/* Number of steps between two checks. */
enum { OUTSIDE_EVERY = 256 };
/* Disks that are reported one by one, during a run and at its end; any more are only counted. */
enum { OUTSIDE_TOLD = 8 };

/* Checks the disks of all ranks, between steps, on one thread of each rank; collective. Disks newly
 * outside the bounds become SD_OUTSIDE or SD_REMOVED, each with a warning (the first few; the rest
 * is counted); a disk that comes back is in play as before. Bounds scale with the lengths of the
 * region. The energy of removed disks is subtracted from state->energy_start. Returns
 * SD_ERROR_NUMERIC if the run is to stop, SD_ERROR_IO if memory runs out. */
sd_status outside_look(engine *e, sd_messages *messages);

/* Returns the number of disks that are outside the bounds now, or were taken out. */
int64_t outside_count(const sd_state *state);

#endif
