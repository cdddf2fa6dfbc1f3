/* outside.h: disks that leave their bounds (sd_bounds in model.h): counted, reported, taken out or a reason to
 * stop. */
#ifndef PHYSICS_OUTSIDE_H
#define PHYSICS_OUTSIDE_H

#include "physics/work.h"

/* Steps between two looks. */
enum { OUTSIDE_EVERY = 256 };

/* Looks at all disks, between steps, on one thread. New ones beyond the bounds become SD_OUTSIDE or SD_REMOVED,
 * with a warning each (the first few, then counted); SD_ERROR_NUMERIC when the run shall stop. */
sd_status outside_look(engine *e, sd_messages *messages);

#endif
