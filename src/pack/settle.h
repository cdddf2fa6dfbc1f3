/* settle.h: is a packing at rest? (sd_settle in model.h) */
#ifndef PACK_SETTLE_H
#define PACK_SETTLE_H

#include "base/exact_sum.h"
#include "physics/system/work.h"

/* Over the free disks in play and within the bounds: kinetic energy per disk, of translation and rotation; mean
 * resultant force on one (contacts, gravity, body forces; coordinates that are free) over the mean normal force of
 * the closed contacts, 0 when there is neither, infinite without contacts. Both infinite when all are beyond. */
typedef struct settle_measure {
  double kinetic, unbalanced;
} settle_measure;

settle_measure settle_look(const engine *e);
/* The sums that it is made of: those of one rank of several, and what they make. */
enum { SETTLE_KINETIC, SETTLE_FORCE, SETTLE_CONTACT, SETTLE_SUMS };
typedef struct settle_sums {
  exact_sum of[SETTLE_SUMS];
  size_t disks, contacts, outside;
} settle_sums;
void settle_add_up(const engine *e, settle_sums *all);
settle_measure settle_of_sums(const settle_sums *all);
/* All criteria of the running phase hold, no disk waits, servo walls are within 1 % of their force, and walls under a
 * load have no more kinetic energy than a disk may have. */
bool settle_reached(const engine *e, const settle_measure *now);

#endif
