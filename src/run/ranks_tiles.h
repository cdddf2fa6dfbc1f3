/* ranks_tiles.h: the first parts of a run whose last disks are made part by part (model/tiles.h): each rank makes some, wherever they lie, and
 * the ranks agree on the order that all disks have in the whole. Collective. */
#ifndef SLIPDISK_RUN_RANKS_TILES_H
#define SLIPDISK_RUN_RANKS_TILES_H

#include "physics/system/halo.h"
#include "physics/system/work.h"

/* An engine with nothing but state and halo->order, as move_parts takes it: disks of the tiles of this rank; on rank 0 also those that
 * the model has, and `whole` gives the rest to all (NULL on the others). SD_ERROR_USER, on that rank: no room for a tile's disks; SD_ERROR_IO: a
 * file cannot be read, or has changed.
 * Without memory the job ends. ranks_tiles_free in any case. */
sd_status ranks_tiles_new(const comm *c, const sd_model *model, const engine *whole, engine *made,
                          sd_messages *messages);
void ranks_tiles_free(engine *made);

#endif
