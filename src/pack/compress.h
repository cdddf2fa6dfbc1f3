/* compress.h: isotropic compression: the lengths of the region, the poses of walls and the positions of all
 * disks change by a common factor about the region's lower corner, until a pressure or a packing fraction is
 * reached.
 *
 * The pressure is the mean of the two principal stresses of the contacts, 2 A p = sum F_n r, with r the distance
 * of two centres, for a wall that of the centre from the wall. In a box at rest without gravity this is the mean
 * of the pressures on its walls (physics.md). Clumps add what their inner forces do: the contacts pull disk i with F_i, the clump
 * holds it back, - sum (x_i - X) F_i with X the centre of its clump.
 */
#ifndef PACK_COMPRESS_H
#define PACK_COMPRESS_H

#include "physics/system/work.h"

/* All but compress_inner and compress_area are collective. */

/* Steps between two changes of the lengths. */
enum { COMPRESS_EVERY = 8 };

/* One change towards the running phase's target, between steps, on one thread of each rank;
 * nothing while disks wait. The potential energy that it puts in is booked in state->work_driven.
 * SD_ERROR_NUMERIC: a periodic box has become too narrow, an overlap is beyond the limit. */
sd_status compress_step(engine *e, sd_messages *messages);
/* The running phase's target is reached within its tolerance. */
bool compress_done(const engine *e);

/* Pressure in the region, force/length, of the live contacts. */
double compress_pressure(const engine *e);
/* Of the disk in this slot: what it adds to the virial sum F_n r for being in a clump, 0 for other disks. */
double compress_inner(const sd_model *model, const sd_state *state, size_t slot);
/* Area of the free disks in play over that of the region. */
double compress_fraction(const engine *e);
/* Of the region. */
double compress_area(const sd_model *model, const sd_state *state);

#endif
