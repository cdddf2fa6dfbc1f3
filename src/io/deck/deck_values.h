/* deck_values.h: shapes of the grains of a packing, before bodies are made from them. */
#ifndef SLIPDISK_IO_DECK_VALUES_H
#define SLIPDISK_IO_DECK_VALUES_H

#include "io/deck/deck_read.h"
#include "pack/tiles.h"

struct deck_group;

/* --- radii of a packing ----------------------------------------------------------------------- */

/* Completes a size distribution whose keys were read: its limits, or for a list its radii and
 * weights. Reports errors. */
void deck_finish_sizes(struct deck_group *g, sizes *s);

/* --- clumps: rigid bodies of several disks, as entries of `clumps` or grains of a packing ----- */

/* Shape of the grains of a packing, in units of a grain's random radius: a single disk, or the
 * disks of a clump relative to its centre of mass. */
typedef struct deck_grain {
  size_t n;
  /* [n]: radii and centres of the disks in a grain; NULL for a single disk */
  double *radius, (*at)[2];
  /* Radius of the circle about the centre of mass that encloses the grain */
  double reach;
  double area; /* Sum of the squared radii, which is the area of the disks divided by pi */
} deck_grain;

/* Reads the key `clump` of a packing. If it is missing or wrong (reported), returns false and sets
 * *grain to a single disk. */
bool deck_read_grain(struct deck_group *packing, deck_grain *grain);
/* Adds a clump, turned by `angle` (rad) and scaled by `radius`, whose centre of mass is at the
 * position of the disk `like`; like->mass is the mass of the whole clump. */
void deck_push_grain(deck *d, const deck_grain *grain, const sd_disk *like, double radius,
                     double angle, deck_place place);

#endif
