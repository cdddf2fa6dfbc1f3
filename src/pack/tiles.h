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

/* Specification of a packing: what an entry of `packings` of a deck says of its disks. */
typedef struct packing_spec {
  sd_packing_kind kind;
  size_t number;   /* index of the packing in the deck, which its random numbers follow from */
  int64_t count;   /* number of disks or clumps to make; 0: not given */
  double fraction; /* packing fraction to reach; 0: not given */
  int64_t tiles;   /* number of tiles; 0: the packing is made as a whole */
  /* lattices: distance between sites; rain: distance of the disks that wait. jitter: largest
   * displacement of a site divided by (spacing/2 - radius) */
  double spacing, jitter;
  int64_t rows;    /* rain: number of rows of disks in a batch */
  double interval; /* rain: time between batches */
  sd_rain rain;
  double mass, density; /* mass of a disk or clump, or mass per area; the other one is 0 */
  int material, group;  /* index of the material, index of the group; group -1: none */
  sizes sizes;          /* distribution of the radii */
} packing_spec;

/* Chooses up to n random radii and places these disks by the method how->kind, which is not
 * SD_PACKING_RAIN. *placed <= n is the number placed; radius[k] and position[k] are those of disk k
 * < *placed, except that a random packing leaves gaps with NAN positions (place_random).
 * SD_ERROR_IO: out of memory. */
sd_status tiles_place(place_space *s, gsl_rng *rng, const packing_spec *how, size_t n,
                      double *radius, double (*position)[2], size_t *placed);

/* Generates the disks of one tile of m->tiles (the packing `how`). *placed is the number placed;
 * disks[] is filled only if this is all disks of the tile (model_tile_size). SD_ERROR_IO: out of
 * memory. */
sd_status tiles_make(const sd_model *m, const packing_spec *how, size_t tile, sd_disk *disks,
                     size_t *placed);

/* Returns a disk of a packing, with the mass, material and group of its specification. */
sd_disk packing_disk(const packing_spec *of, double radius, const double position[2]);

#endif
