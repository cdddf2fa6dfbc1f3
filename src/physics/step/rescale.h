/* rescale.h: a change of the lengths of the region. */
#ifndef PHYSICS_RESCALE_H
#define PHYSICS_RESCALE_H

#include "physics/system/work.h"

/* All lengths times f about the region's corner, with contacts, forces and accelerations of the new ones. SD_ERROR_IO: no
 * memory; SD_ERROR_NUMERIC: an overlap is beyond the limit. Collective. */
sd_status rescale(engine *e, double f, sd_messages *messages);

#endif
