/* rain.h: releases waiting disks in batches (sd_rain in model.h).
 *
 * A batch is a stack of rows that span the width of the rain's strip: disks in the order of their
 * numbers, side by side until they take ROW_FILL of the width; random gaps take the rest, and small
 * disks get random heights within their row. The random numbers depend only on seed, rain and batch
 * number (GSL's MT19937), so a batch is the same whenever it falls. */
#ifndef PACK_RAIN_H
#define PACK_RAIN_H

#include "physics/system/work.h"

/* Returns the first step after `step` at which a batch is due; INT64_MAX: none. */
int64_t rain_next(const engine *e, int64_t step);
/* Releases the batches due at state->step, between steps, on one thread of each rank; collective.
 * The energy that the disks bring is added to state->energy_start. SD_ERROR_NUMERIC: a wall, or the
 * limit of the bounds or of the box, is in the way of a disk. SD_ERROR_IO: out of memory. */
sd_status rain_release(engine *e, sd_messages *messages);
/* Returns true if some disk still waits for its release. */
bool rain_waits(const engine *e);
/* Returns the number of disks that wait for their release. */
int64_t rain_waiting(const sd_model *model, const sd_state *state);

/* Radii of the disks of a batch. They may be given in an array, since the model of one rank lacks
 * the disks of other ranks. */
typedef struct rain_sizes {
  const sd_model *model;
  const double *radius; /* radii of disks `first`, first + 1, ...; NULL: read them from the model */
  size_t first;
} rain_sizes;

/* Returns how many of the disks first ... end - 1 go into one row of the given width, at least one
 * disk or clump. */
size_t rain_row(const rain_sizes *sizes, size_t first, size_t end, double width);

#endif
