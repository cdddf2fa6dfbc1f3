/* tiles.h: a model that lacks most disks of its last packing, which the ranks of a run make in tiles (sd_tiles, pack/tiles.h).
 *
 * Rank 0 reads the deck with the first tile alone, whose disks stand for all in what is checked and advised. Then the others are counted
 * as free disks, so that walls have the numbers that they have in one process; the rows of these disks are zeros that nothing is
 * written to, as those of all free disks are on the other ranks (image.h).
 */
#ifndef SLIPDISK_MODEL_TILES_H
#define SLIPDISK_MODEL_TILES_H

#include "model/model.h"

/* Disks whose rows are in the model. */
static inline size_t model_held(const sd_model *m) {
  return m->tiles.away ? m->tiles.first + (m->tiles.count + m->tiles.n - 1) / m->tiles.n : m->n_disks;
}

/* A disk of the packing. */
sd_disk model_tile_disk(const sd_tiles *tiles, double radius, const double position[2]);
/* Counts the disks that are not there. NULL, or why all must be there: then the deck is to be read again. */
const char *model_count_tiles(sd_model *model);

#endif
