/* rain.h: disks that wait are released in batches (sd_rain in model.h).
 *
 * A batch is rows from edge to edge of the rain's strip: disks by number, side by side until ROW_FILL of the width
 * is taken, the rest of the width in random gaps, small disks at random heights within their row. The random
 * numbers follow from seed, rain and batch (GSL's MT19937), so a batch is the same whenever it falls.
 */
#ifndef PACK_RAIN_H
#define PACK_RAIN_H

#include "physics/system/work.h"

/* The first step after `step` at which a batch is due; INT64_MAX: none. */
int64_t rain_next(const engine *e, int64_t step);
/* Releases what is due at state->step, between steps, on one thread of each rank; collective. The
 * energy that the disks bring is booked in state->energy_start. SD_ERROR_NUMERIC: a wall or the
 * end of the bounds is where a disk should be. */
sd_status rain_release(engine *e, sd_messages *messages);
/* Some disk waits. */
bool rain_waits(const engine *e);
/* How many disks that is. */
int64_t rain_waiting(const sd_model *model, const sd_state *state);

/* Disks of a batch: their radii, where the model has none. */
typedef struct rain_sizes {
  const sd_model *model;
  const double *radius; /* from disk `first` on; NULL: in the model */
  size_t first;
} rain_sizes;

/* How many of the disks first ... end - 1 stand in one row of the given width. */
size_t rain_row(const rain_sizes *sizes, size_t first, size_t end, double width);

#endif
