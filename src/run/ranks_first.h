/* ranks_first.h: the disks that each rank has at step 0, before they are distributed by
 * position: some disks of the deck, anywhere in space (model/rows.h). */
#ifndef SLIPDISK_RUN_RANKS_FIRST_H
#define SLIPDISK_RUN_RANKS_FIRST_H

#include "base/comm.h"
#include "model/model.h"
#include "model/state.h"

/* Collective: loads the model of a deck; each rank keeps its part of the disks (model_part). Text,
 * path and overrides are those of rank 0, which alone gets messages. text NULL: the file at `path`
 * is read. Errors: those of sd_deck_load, and SD_ERROR_USER for decks that ranks cannot share
 * (ranks_suit). */
sd_status ranks_load(const comm *c, const char *text, const char *path, size_t n_overrides,
                     const char *const *overrides, sd_model **out, sd_messages *messages);

/* Collective: makes the state of this rank's disks and the prescribed bodies, and order[n_free],
 * the slots of the disks in the order of all disks, ascending. Empties model->mine. The caller
 * frees both, also after a failure. A rank without memory ends the job. */
sd_status ranks_first_new(const comm *c, const sd_model *model, sd_state **state, uint32_t **order);

/* --- Runs that several ranks can share -------------------------------------------------------- */

/* Returns SD_ERROR_USER, with a message for each reason, if the run is only possible in one
 * process. */
sd_status ranks_suit(const sd_model *model, sd_messages *messages);

#endif
