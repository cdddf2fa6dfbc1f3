/* clumps.h: rigid bodies of several disks (sd_clump). */
#ifndef MODEL_CLUMPS_H
#define MODEL_CLUMPS_H

#include "model/model.h"

/* Lists the disks of each clump, fills in its centre, mass and inertia, and checks it. Call when disks have inertias and
 * `driven` is known. */
sd_status clumps_derive(sd_model *model, sd_messages *messages);

/* The grain at disk `first` in a row of disks before `end`: a disk, or a clump whose disks follow one another. How many disks,
 * and the radius of the circle about its centre in which they lie. */
typedef struct clump_grain {
  size_t disks;
  double radius;
} clump_grain;
clump_grain clumps_grain(const sd_model *model, size_t first, size_t end);

/* A disk of a clump as contacts feel it at most: with the mass and inertia of a single disk that yields as much to a normal force
 * (1/M + d^2/I) and to a tangential one (1/M + (d + R)^2/I), d from the centre; any other disk as it is. */
sd_disk clumps_felt(const sd_model *model, size_t disk);

/* Do both disks belong to one clump? Then they do not touch. */
static inline bool clumps_join(const sd_model *m, size_t a, size_t b) {
  return m->disks[a].clump > 0 && m->disks[a].clump == m->disks[b].clump;
}

#endif
