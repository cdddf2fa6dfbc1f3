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
/* Releases what is due at state->step, between steps, on one thread. The energy that the disks bring is booked in
 * state->energy_start. SD_ERROR_NUMERIC: a wall or the end of the bounds is where a disk should be. */
sd_status rain_release(engine *e, sd_messages *messages);
/* The same in parts, of a run that ranks share (ranks_phase.c): rank 0 says where the disks of a batch go, and each rank sets out its own. */
typedef struct rain_drop {
  uint32_t disk, leads; /* leads: the first of its grain */
  double x, y;
} rain_drop;
/* Is a batch due now, and how many disks has it? */
bool rain_due(const engine *e, const sd_rain *r);
size_t rain_count(const engine *e, const sd_rain *r);
/* Top of the highest disk of this part over the rain's strip, no lower than its floor less its gap. */
double rain_top(const engine *e, const sd_rain *r);
/* Radii of the disks of the batch [rain_count()] that are here; 0: elsewhere. */
void rain_radii(const engine *e, const sd_rain *r, double *radius);
/* drops[rain_count()]: above `top`; walls posed (engine_pose_walls). radius NULL: as the model has them. SD_ERROR_NUMERIC: as above. */
sd_status rain_plan(const engine *e, const sd_rain *r, double top, const double *radius, rain_drop *drops,
                    sd_messages *messages);
/* Those that are here are in play; then, with their constants (bodies_fill_constants), they fall. */
void rain_set_out(engine *e, const sd_rain *r, const rain_drop *drops);
void rain_accelerate(engine *e, const sd_rain *r);
/* Some disk waits. */
bool rain_waits(const engine *e);
/* How many disks that is. */
int64_t rain_waiting(const sd_model *model, const sd_state *state);

/* How many of the disks first ... end - 1 stand in one row of the given width. */
size_t rain_row(const sd_model *model, size_t first, size_t end, double width);

#endif
