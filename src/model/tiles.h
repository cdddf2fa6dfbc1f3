/* tiles.h: a model that lacks its last disks, which the ranks of a run make part by part (sd_tiles, pack/tiles.h, deck_make_part).
 *
 * Rank 0 reads the deck with a sample of them, which stands for all in what is checked and advised. Then they are counted as free
 * disks, so that walls have the numbers that they have in one process; the rows of these disks are zeros that nothing is written
 * to, as those of all free disks are on the other ranks (image.h).
 */
#ifndef SLIPDISK_MODEL_TILES_H
#define SLIPDISK_MODEL_TILES_H

#include "model/model.h"

/* Disks whose rows are in the model, once the others are counted. */
static inline size_t model_held(const sd_model *m) { return m->tiles.away ? m->tiles.first : m->n_disks; }

/* The first disk of a part among those that are made in parts; of part n: how many there are. */
size_t model_tile_begin(const sd_tiles *tiles, size_t part);
/* A disk of a packing. */
sd_disk model_tile_disk(const sd_tiles *tiles, double radius, const double position[2]);

/* With the sample in the model. NULL, or why all disks must be there: then the deck is to be read again. */
const char *model_needs_tiles(const sd_model *model);
/* Does the model bear n <= sample of these disks? Lowers the limit of the time step (at first that of the sample) to what they say.
 * sd_model_finish is to be called again after the last of them. */
bool model_bears(sd_model *model, size_t n, const sd_disk *disks, sd_step_limit *limit);
/* Counts the disks in place of the sample. False: no memory. */
bool model_count_tiles(sd_model *model, sd_step_limit limit);

#endif
