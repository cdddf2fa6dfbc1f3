/* deck_clumps.h: rigid bodies of several disks, for the entries of `clumps` and for packings
 * whose grains are clumps. */
#ifndef SLIPDISK_IO_DECK_CLUMPS_H
#define SLIPDISK_IO_DECK_CLUMPS_H

#include "io/deck/deck_read.h"

/* Shape of the grains of a packing, in units of the radius that is drawn: a single disk, or the
 * disks of a clump relative to its centre of mass. */
typedef struct deck_grain {
  size_t n;
  double *radius, (*at)[2]; /* [n]: radii and centres of the disks; NULL for a single disk */
  /* Radius of the circle about the centre of mass that encloses the grain */
  double reach;
  double area; /* Area divided by pi: the sum of squared radii */
} deck_grain;

/* Reads the packing's key `clump`. Returns false and a single disk if the key is missing or
 * wrong (reported). */
bool deck_read_grain(deck_group *packing, deck_grain *grain);
/* Adds a clump, turned by `angle` (rad), at the position of the disk `like`; like->mass is the
 * mass of the whole clump. */
void deck_push_grain(deck *d, const deck_grain *grain, const sd_disk *like, double radius,
                     double angle, const char *group, deck_place place);

#endif
