/* ranks.h: one simulation over several ranks.
 *
 * Each rank has an engine for its domain, some of the disks (halo.h). All ranks go through the
 * same session (session.h) and the same loop (loop.h). The number of ranks does not change a bit
 * of the results.
 *
 * Functions that return a status are collective and return the same status on all ranks; rank 0
 * gets the messages of the others. A rank that runs out of memory reports it and ends the job. */
#ifndef SLIPDISK_RUN_RANKS_H
#define SLIPDISK_RUN_RANKS_H

#include <signal.h>

#include "base/comm.h"
#include "measure/resultant.h"
#include "model/model.h"
#include "model/state.h"
#include "physics/system/work.h"
#include "slipdisk/simulation.h"

typedef struct ranks ranks;

/* Balance of the work between ranks at the last check. */
typedef struct ranks_balance {
  int64_t cuts; /* number of times that the domains were cut, the first included; 0: never */
  double
      excess; /* relative excess of the busiest rank's time over the mean; NAN: not checked yet */
  int64_t least, most; /* smallest and largest number of disks of a rank */
} ranks_balance;

/* Makes the ranks of one simulation. part: engine of this rank, with its model set. c:
 * communicator. stop: becomes nonzero if this rank gets a signal, and then, after the next steps,
 * on all ranks. */
ranks *ranks_new(const comm *c, engine *part, volatile sig_atomic_t *stop);
void ranks_free(ranks *r);

ranks_balance ranks_balance_of(const ranks *r);

/* Distributes the disks over the ranks. On entry each rank has any of the disks and of the contacts
 * (state); order: their slots in the order of all disks, ascending. Takes over both. threads:
 * threads of each rank; the value of rank 0 counts. */
sd_status ranks_spread(ranks *r, sd_state *state, uint32_t *order, int threads,
                       sd_messages *messages);
/* Makes the disks of step 0 (ranks_first.c), distributes them, and calls loop_begin_phase and
 * loop_start. */
sd_status ranks_start(ranks *r, int threads, sd_messages *messages);
/* Takes up to n steps, with the work between steps; state->step tells how many were taken. After a
 * failure or a stop they are fewer, and all ranks know of it. */
sd_status ranks_advance(ranks *r, int64_t n, sd_messages *messages);
/* Stores contacts, motions and poses of ghosts in the states of all ranks. rows: only what rows of
 * results need. */
sd_status ranks_store(ranks *r, bool rows, sd_messages *messages);
/* Returns the sums for a row of the series besides the energies; NULL: out of memory. The states
 * must be stored. */
const resultants *ranks_resultants(ranks *r, sd_messages *messages);
/* Writes the disks and contacts of each rank as a share (h5.h) of the checkpoint `path`; the path
 * of rank 0 counts. seals: [comm_size()] on rank 0, receives the checksums in their seals. If a
 * rank fails, all shares are removed. The states must be stored. */
sd_status ranks_write(ranks *r, const char *path, int64_t *seals, sd_messages *messages);
/* Adds to the rows of each rank its disks in frame number `frame` of the next part and its contacts
 * in contact table number `moment_number`; the numbers of rank 0 count. n_contacts: receives the
 * number of contacts of all ranks now; bytes: the memory of the rows of all ranks since the last
 * part. The states must be stored. */
sd_status ranks_sample(ranks *r, unsigned what, int64_t frame, int64_t moment_number,
                       size_t *n_contacts, size_t *bytes, sd_messages *messages);
/* Writes the rows of each rank as a share of the part `path`. seals: as in ranks_write. */
sd_status ranks_seal(ranks *r, const char *path, int64_t *seals, sd_messages *messages);

/* The disks that each rank has at step 0, before they are distributed by
 * position: some disks of the deck, anywhere in space (model/rows.h). */

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
