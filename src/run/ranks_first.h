/* ranks_first.h: the disks that ranks have at step 0, before they are shared out: rank 0 those of
 * its deck, but where the last ones are made part by part (model/tiles.h) each rank makes some,
 * wherever they lie. */
#ifndef SLIPDISK_RUN_RANKS_FIRST_H
#define SLIPDISK_RUN_RANKS_FIRST_H

#include "base/comm.h"
#include "model/model.h"
#include "model/state.h"

/* Collective. The state of this rank's disks, with the prescribed bodies, and its slots in the
 * whole (order[n_free], which ascend). Both are the caller's, also after a failure.
 * SD_ERROR_USER, on that rank: no room for a tile's disks; SD_ERROR_IO: a file cannot be read, or
 * has changed. Without memory the job ends. */
sd_status ranks_first_new(const comm *c, const sd_model *model, sd_state **state, uint32_t **order,
                          sd_messages *messages);

#endif
