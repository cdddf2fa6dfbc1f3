/* ranks_first.h: the disks that ranks have at step 0, before they are shared out: each has some of
 * those of the deck, wherever they lie (model/rows.h). */
#ifndef SLIPDISK_RUN_RANKS_FIRST_H
#define SLIPDISK_RUN_RANKS_FIRST_H

#include "base/comm.h"
#include "model/model.h"
#include "model/state.h"

/* Collective. The model of a deck, of which each rank keeps its part (model_part): text, path and
 * overrides are those of rank 0, which alone gets messages. Of a text that is NULL the file at path
 * is read. Errors: those of sd_deck_load, and decks that ranks do not share (ranks_suit). */
sd_status ranks_load(const comm *c, const char *text, const char *path, size_t n_overrides,
                     const char *const *overrides, sd_model **out, sd_messages *messages);

/* Collective. The state of this rank's disks, with the prescribed bodies, and its slots in the
 * whole (order[n_free], which ascend); model->mine is empty then. Both are the caller's, also
 * after a failure. Without memory the job ends. */
sd_status ranks_first_new(const comm *c, const sd_model *model, sd_state **state, uint32_t **order);

/* --- which runs several ranks can share ------------------------------------------------------- */

/* SD_ERROR_USER, with a message for each reason: this run is for one process. */
sd_status ranks_suit(const sd_model *model, sd_messages *messages);

#endif
