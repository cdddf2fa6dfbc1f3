/* outside.h: disks that leave the bounds of the run (sd_bounds in model.h). They are counted and
 * reported; the model says whether they go on, are removed or stop the run. */
#ifndef PHYSICS_OUTSIDE_H
#define PHYSICS_OUTSIDE_H

#include "physics/system/work.h"

/* Number of steps between two checks of the bounds. */
enum { OUTSIDE_EVERY = 256 };
/* Number of disks that are reported one by one, during a run and at its end; further ones are only
 * counted. */
enum { OUTSIDE_TOLD = 8 };

/* Checks the bounds for the disks of all ranks, between steps; collective, called by one thread of
 * each rank. A disk newly outside becomes SD_OUTSIDE or SD_REMOVED; the first few give a warning
 * each, further ones are only counted. A disk that comes back becomes SD_IN_PLAY again. Bounds are
 * scaled with the box. The energy of removed disks is subtracted from state->energy_start. Returns
 * SD_ERROR_NUMERIC if the run is to stop, SD_ERROR_IO if memory runs out. */
sd_status outside_check(engine *e, sd_messages *messages);

/* Returns the number of this state's free disks that are outside the bounds now, or were
 * removed. */
int64_t outside_count(const sd_state *state);

#endif
