/* outside.h: disks that leave their bounds (sd_bounds in model.h): counted, reported, taken out or a reason to
 * stop. */
#ifndef PHYSICS_OUTSIDE_H
#define PHYSICS_OUTSIDE_H

#include "physics/system/work.h"

/* Steps between two looks. */
enum { OUTSIDE_EVERY = 256 };
/* So many are told of one by one, in a run and at its end; the rest is counted. */
enum { OUTSIDE_TOLD = 8 };

/* Looks at all disks, between steps, on one thread. Those newly beyond the bounds become SD_OUTSIDE or SD_REMOVED,
 * with a warning each (the first few, then counted); one that comes back is in play as before. Bounds change with
 * the lengths of the region. The energy that removed disks take along is booked in state->energy_start.
 * SD_ERROR_NUMERIC when the run shall stop. */
sd_status outside_look(engine *e, sd_messages *messages);

/* The same in parts, of a run that ranks share (ranks_phase.c). */
typedef struct outside_left {
  uint32_t order, disk, slot; /* order: slot of the whole */
  double x, y;
} outside_left;
/* Disks that are back are in play; *list, to be freed, those that have left since the last look. SD_ERROR_IO: no memory. */
sd_status outside_find(engine *e, outside_left **list, size_t *n);
/* Counts disks of all ranks, in their order, and warns of them. SD_ERROR_NUMERIC: as above. */
sd_status outside_tell(engine *e, const outside_left *list, size_t n, sd_messages *messages);
/* Those of this part are outside, or taken out. */
void outside_mark(engine *e, const outside_left *list, size_t n);

/* Would outside_look change anything? */
bool outside_is_due(const engine *e);

/* Disks that are beyond the bounds now, or were taken out. */
int64_t outside_count(const sd_state *state);

#endif
