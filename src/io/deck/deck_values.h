/* deck_values.h: values of the keys of a container and of a packing, before bodies are made from
 * them. */
#ifndef SLIPDISK_IO_DECK_VALUES_H
#define SLIPDISK_IO_DECK_VALUES_H

#include "io/deck/deck_read.h"
#include "pack/place.h"
#include "pack/sizes.h"

struct deck_group;

typedef struct deck_container_values {
  sd_container_kind kind;
  double width, height, radius, outlet, angle, origin[2];
  bool open;
  int material;
  place_interior interior;
} deck_container_values;

typedef struct deck_packing_values {
  sd_packing_kind kind;
  int64_t count;   /* Number of disks; 0: not given */
  double fraction; /* Packing fraction; 0: not given */
  double jitter;
  int64_t tiles; /* Number of tiles; 0: not given */
  int64_t rows;
  double speed;
  double mass, density; /* Mass of a grain, and density per area; one of them is 0 */
  sizes sizes;
} deck_packing_values;

/* --- radii of a packing ----------------------------------------------------------------------- */

/* Completes a size distribution whose keys are read: its limits, or the radii and weights of a
 * list. Reports mistakes. */
void deck_finish_sizes(struct deck_group *g, sizes *s);

/* Rigid bodies of several disks, for the entries of `clumps` and for packings
 * whose grains are clumps. */

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
bool deck_read_grain(struct deck_group *packing, deck_grain *grain);
/* Adds a clump, turned by `angle` (rad), at the position of the disk `like`; like->mass is the
 * mass of the whole clump. */
void deck_push_grain(deck *d, const deck_grain *grain, const sd_disk *like, double radius,
                     double angle, const char *group, deck_place place);

#endif
