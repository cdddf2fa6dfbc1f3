/* rain.h: disks that wait are released in batches (sd_rain in model.h). */
#ifndef PACK_RAIN_H
#define PACK_RAIN_H

#include "physics/work.h"

/* The first step after `step` at which a batch is due; INT64_MAX: none. */
int64_t rain_next(const engine *e, int64_t step);
/* Releases what is due at state->step, between steps, on one thread. */
sd_status rain_release(engine *e, sd_messages *messages);
/* Some disk waits. */
bool rain_waits(const engine *e);

#endif
