/* compress.h: isotropic compression. The lengths of the region, the poses of walls and the
 * positions of all disks are scaled by a common factor about the region's lower corner, until a
 * pressure or a packing fraction is reached.
 *
 * The pressure is the mean of the two principal stresses of the contacts: 2 A p = sum F_n r, with r
 * the distance of the two centres, or of the centre from a wall. In a box at rest without gravity
 * this is the mean of the pressures on its walls (physics.md). A clump adds the virial of its
 * internal forces: the contacts act on disk i with F_i, the clump balances it, which adds
 * -sum (x_i - X) F_i, with X the centre of the clump. */
#ifndef PACK_COMPRESS_H
#define PACK_COMPRESS_H

#include "physics/system/work.h"

/* All functions in this header except compress_inner and compress_area are collective. */

/* Number of steps between two changes of the lengths. */
enum { COMPRESS_EVERY = 8 };

/* Changes the lengths once towards the target of the running phase, between steps, on one thread of
 * each rank. Does nothing while disks wait for their release (rain). The potential energy that it
 * adds is added to state->work_driven. SD_ERROR_NUMERIC: a periodic box became too narrow, or an
 * overlap exceeds the limit. SD_ERROR_IO: out of memory. */
sd_status compress_step(engine *e, sd_messages *messages);
/* Returns true if the running phase's target is reached within its tolerance. */
bool compress_done(const engine *e);

/* Returns the pressure in the region from the current contacts, force/length. */
double compress_pressure(const engine *e);
/* Returns what the disk in this slot adds to the virial sum F_n r for the internal forces of its
 * clump: -(x_i - X) F_i, with x_i its centre, X the centre of the clump and F_i the sum of its
 * contact forces; 0 for a disk in no clump. */
double compress_inner(const sd_model *model, const sd_state *state, size_t slot);
/* Returns the packing fraction: area of the free disks in play divided by the area of the
 * region. */
double compress_fraction(const engine *e);
/* Returns the current area of the region. */
double compress_area(const sd_model *model, const sd_state *state);

#endif
