/* settle.h: is a packing at rest? (sd_settle in model.h) */
#ifndef PACK_SETTLE_H
#define PACK_SETTLE_H

#include "physics/system/work.h"

/* Over the free disks in play and within the bounds: kinetic energy per disk, of translation and
 * rotation; mean resultant force on one (contacts, gravity, body forces; coordinates that are
 * free) over the mean normal force of the closed contacts, 0 when there is neither, infinite
 * without contacts. Both infinite when all are beyond. settle_look is collective. */
typedef struct settle_measure {
  double kinetic, unbalanced;
} settle_measure;

settle_measure settle_look(const engine *e);
/* All criteria of the running phase hold, no disk waits, servo walls are within 1 % of their force, and walls under a
 * load have no more kinetic energy than a disk may have. */
bool settle_reached(const engine *e, const settle_measure *now);

#endif
