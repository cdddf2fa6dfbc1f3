/* overlaps.h: which bodies overlap at the start, and how far apart two of them are. */
#ifndef SLIPDISK_MODEL_OVERLAPS_H
#define SLIPDISK_MODEL_OVERLAPS_H

#include "model/rows.h"

/* Disk a overlaps b, a disk that is as large or larger, or a wall. */
typedef struct overlap {
  uint32_t a, b;   /* body numbers */
  size_t row;      /* of disk a (rows.h) */
  double depth;    /* > 0 */
  bool coincident; /* two disks with the same centre */
} overlap;

/* True: other disks that overlap disk a are not looked for. */
typedef bool overlap_visitor(void *user, const overlap *found);

/* Pairs of disks that are held (rows.h), periodic images included: each once, whatever holds them.
 * SD_ERROR_IO: no memory. */
sd_status overlaps_of_disks(const sd_model *model, overlap_visitor *visit, void *user);
/* Free disks in play, of this rank, and walls. */
void overlaps_with_walls(const sd_model *model, overlap_visitor *visit, void *user);

/* Distance between the surfaces of a disk, moved to x, and another disk or wall, moved by `pose` (x, y, angle: where its
 * centre or pivot is, and how far it has turned); < 0: they overlap. Nearest image of a periodic box. */
double overlaps_gap(const sd_model *model, uint32_t disk, const double x[2], uint32_t body,
                    const double pose[3]);
/* The same at the start. */
double overlaps_first_gap(const sd_model *model, uint32_t disk, uint32_t body);

#endif
