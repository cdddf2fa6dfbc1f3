/* tiles.h: a packing that is made in tiles (sd_tiles in model.h).
 *
 * A tile has random numbers of its own, and knows walls and the disks that were there before the packing, but no other tile: disks lie
 * between its edges. So it is the same whoever makes it, and when.
 */
#ifndef PACK_TILES_H
#define PACK_TILES_H

#include "pack/place.h"
#include "pack/sizes.h"

/* Message of a tile that is too small: its number, how many tiles there are, disks that it holds, disks that it shall hold. */
#define TILES_FULL                                                                                 \
  "tile %zu of %zu holds %zu disks only, where %zu were asked for; expected fewer disks or a "     \
  "larger region"

/* How a region is filled with n disks. */
typedef struct tiles_fill {
  sd_packing_kind kind; /* not rain */
  const sizes *sizes;
  double spacing, jitter; /* of lattices */
} tiles_fill;

/* Draws n radii, and places disks; *placed <= n found room: radius[k] and position[k] of those, but for a random packing (place_random).
 * SD_ERROR_IO: out of memory. */
sd_status tiles_place(place_space *s, gsl_rng *rng, const tiles_fill *how, size_t n, double *radius,
                      double (*position)[2], size_t *placed);

/* Makes the disks of one tile of m->tiles (a packing's); *placed: as above, and where that is fewer than it shall hold no disk is filled in. */
sd_status tiles_make(const sd_model *m, size_t tile, sd_disk *disks, size_t *placed);

#endif
