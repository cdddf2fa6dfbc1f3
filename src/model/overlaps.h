/* overlaps.h: finds the bodies that overlap at the start, and the distance between two bodies. */
#ifndef SLIPDISK_MODEL_OVERLAPS_H
#define SLIPDISK_MODEL_OVERLAPS_H

#include "model/rows.h"

/* An overlap of disk a with b, which is a disk of at least its radius, or a wall. */
typedef struct overlap {
  uint32_t a, b;   /* body numbers */
  size_t row;      /* row of disk a among the disks of this rank (rows.h) */
  double depth;    /* depth of the overlap, > 0 */
  bool coincident; /* true for two disks with the same centre */
} overlap;

/* Returns the elastic normal force at this overlap; 0: the two materials have no contact law. */
double overlap_force(const sd_model *model, const overlap *found);

/* Function that is called for each overlap found. Returning true ends the search for further
 * overlaps of disk a. */
typedef bool overlap_visitor(void *user, const overlap *found);

/* Calls `visit` once for each overlapping pair among the disks that all ranks store, prescribed
 * or not, periodic images included; disks of one clump do not count. SD_ERROR_IO: out of memory. */
sd_status overlaps_of_disks(const sd_model *model, overlap_visitor *visit, void *user);
/* Calls `visit` for each overlap of a wall with a free disk of this rank; disks that wait for
 * their release are skipped. */
void overlaps_with_walls(const sd_model *model, overlap_visitor *visit, void *user);

/* Gap between a disk whose centre is x and another disk or wall at `pose` (x, y of its centre or
 * pivot, angle turned since the start); < 0: overlap. Uses the nearest periodic image. */
double overlaps_gap(const sd_model *model, uint32_t disk, const double x[2], uint32_t body,
                    const double pose[3]);
/* Returns the gap between a disk and another body at the start, using the nearest periodic
 * image; < 0: overlap. */
double overlaps_first_gap(const sd_model *model, uint32_t disk, uint32_t body);

#endif
