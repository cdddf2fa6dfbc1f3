/* clumps.h: clumps, which are rigid bodies made of several disks (sd_clump). */
#ifndef MODEL_CLUMPS_H
#define MODEL_CLUMPS_H

#include "model/model.h"

/* Lists the disks of each clump, computes the centre, mass and moment of inertia of the clump
 * unless given, and checks it. Disks must have their inertias and `driven` flags before.
 * SD_ERROR_USER: errors were reported; SD_ERROR_IO: out of memory. */
sd_status clumps_derive(sd_model *model, sd_messages *messages);

/* A grain that is dropped by rain, which releases disks in batches: a single disk, or a clump
 * whose disks have consecutive numbers. disks: number of disks in the grain; radius: radius of
 * the circle about the centre of mass that encloses them. */
typedef struct clump_grain {
  size_t disks;
  double radius;
} clump_grain;
/* Returns the grain that begins with disk `first`, among the disks before `end`. */
clump_grain clumps_grain(const sd_model *model, size_t first, size_t end);

/* Returns a copy of a disk for estimates of time steps. If the disk belongs to a clump of mass M
 * and inertia I, its mass and inertia are replaced by those of a single disk that yields as much
 * to a normal force (1/M + d^2/I) and to a tangential one (1/M + (d + R)^2/I), where d is the
 * distance of the disk from the clump's centre. These are the smallest effective mass and
 * inertia that the disk has in any contact. */
sd_disk clump_effective_disk(const sd_model *model, size_t disk);

/* True if both disks belong to the same clump, so that they do not interact. */
static inline bool clumps_join(const sd_model *m, size_t a, size_t b) {
  return m->disks[a].clump > 0 && m->disks[a].clump == m->disks[b].clump;
}

#endif
