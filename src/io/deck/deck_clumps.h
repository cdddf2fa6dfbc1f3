/* deck_clumps.h: rigid bodies of several disks, for the entries of `clumps` and for packings whose grains are clumps. */
#ifndef SLIPDISK_IO_DECK_CLUMPS_H
#define SLIPDISK_IO_DECK_CLUMPS_H

#include "io/deck/deck_read.h"

/* Grains of a packing, in units of the radius that is drawn: a disk, or the disks of a clump about its centre. */
typedef struct deck_grain {
  size_t n;
  double *radius, (*at)[2]; /* NULL of a disk */
  double reach;             /* radius of the circle about the centre in which it lies */
  double area;              /* sum of squared radii */
} deck_grain;

/* The packing's key `clump`. False: there is none, or it is wrong (reported): a disk. */
bool deck_read_grain(deck_group *packing, deck_grain *grain);
/* A clump turned by `angle`, at the place of the disk `like`, whose mass is that of all. */
void deck_push_grain(deck *d, const deck_grain *grain, const sd_disk *like, double radius,
                     double angle, const char *group, deck_place place);

#endif
