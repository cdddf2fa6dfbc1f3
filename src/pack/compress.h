/* compress.h: isotropic compression: the lengths of the region, the poses of walls and the positions of all
 * disks change by a common factor about the region's lower corner, until a pressure or a packing fraction is
 * reached.
 */
#ifndef PACK_COMPRESS_H
#define PACK_COMPRESS_H

#include "physics/work.h"

/* Steps between two changes of the lengths. */
enum { COMPRESS_EVERY = 8 };

/* One change, between steps, on one thread. The work of the box is booked in state->work_driven. */
sd_status compress_step(engine *e, sd_messages *messages);
/* The running phase's target is reached within its tolerance. */
bool compress_done(const engine *e);
/* Pressure in the region, force/length: virial of the contacts over its area, by 2. */
double compress_pressure(const engine *e);
/* Area of the free disks in play over that of the region. */
double compress_fraction(const engine *e);

#endif
