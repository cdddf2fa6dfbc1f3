/* rescale.h: multiplies the lengths of the region by a factor. */
#ifndef PHYSICS_RESCALE_H
#define PHYSICS_RESCALE_H

#include "physics/system/work.h"

/* Multiplies all lengths by f about the region's corner, then evaluates contacts, forces and
 * accelerations of the new state. Collective. Returns SD_ERROR_IO if memory runs out,
 * SD_ERROR_NUMERIC if an overlap is beyond the limit. */
sd_status rescale(engine *e, double f, sd_messages *messages);

#endif
