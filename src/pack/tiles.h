/* tiles.h: packings that are generated tile by tile (sd_tiles in model.h).
 *
 * A tile (vertical slab of the region) has its own random numbers and knows the walls and the disks
 * that were there before the packing, but no other tile: its disks lie between its edges. So its
 * contents depend neither on the rank nor on the order in which tiles are generated. */
#ifndef PACK_TILES_H
#define PACK_TILES_H

#include "pack/place.h"
#include "pack/sizes.h"

/* Message for a tile that is too small. Arguments: tile number, number of tiles, disks placed,
 * disks requested. */
#define TILES_FULL                                                                                 \
  "tile %zu of %zu holds %zu disks only, where %zu were asked for; expected fewer disks or a "     \
  "larger region"

/* Method by which a region is filled with disks. */
typedef struct tiles_fill {
  sd_packing_kind kind; /* any kind but SD_PACKING_RAIN */
  const sizes *sizes;
  /* lattices only: distance between sites; jitter, i.e. the largest displacement divided by
   * (spacing/2 - radius) */
  double spacing, jitter;
} tiles_fill;

/* Chooses up to n random radii and places these disks. *placed <= n is the number placed; radius[k]
 * and position[k] are those of disk k < *placed, except that a random packing leaves gaps with NAN
 * positions (place_random). SD_ERROR_IO: out of memory. */
sd_status tiles_place(place_space *s, gsl_rng *rng, const tiles_fill *how, size_t n, double *radius,
                      double (*position)[2], size_t *placed);

/* Generates the disks of one tile of m->tiles (a packing). *placed is the number placed; disks[] is
 * filled only if this is all disks of the tile (model_tile_size). SD_ERROR_IO: out of memory. */
sd_status tiles_make(const sd_model *m, size_t tile, sd_disk *disks, size_t *placed);

#endif
