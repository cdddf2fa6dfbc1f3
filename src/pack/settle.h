/* settle.h: tests whether a packing is at rest (sd_settle in model.h). */
#ifndef PACK_SETTLE_H
#define PACK_SETTLE_H

#include "physics/system/work.h"

/* Averages over the free disks in play within the bounds; a clump counts as one body. kinetic:
 * kinetic energy per disk, translation and rotation. unbalanced: mean resultant force on a disk
 * (contacts, gravity, body forces; free coordinates only) divided by the mean normal force of the
 * closed contacts; 0 if the resultants are 0, else infinite without contacts. Without disks both
 * are 0, or infinite if disks lie beyond the bounds. settle_measure_now is collective. */
typedef struct settle_measure {
  double kinetic, unbalanced;
} settle_measure;

settle_measure settle_measure_now(const engine *e);
/* Returns true if all criteria of the running phase are met, no disk waits for its release (rain),
 * servo walls and a box under stress control are within 1 % of their targets, and no wall under a
 * load has more kinetic energy than a disk may have. */
bool settle_reached(const engine *e, const settle_measure *now);

#endif
