/* ranks.h: one simulation over several ranks.
 *
 * Each rank has an engine for its domain, which has some of the disks (halo.h). All ranks go
 * through the same session (session.h) and the same loop (loop.h). The results are the same, bit
 * for bit, for any number of ranks.
 *
 * Functions that return a status are collective and return the same status on all ranks; rank 0
 * gets the messages of the others. A rank that runs out of memory reports it and ends the job. */
#ifndef SLIPDISK_RUN_RANKS_H
#define SLIPDISK_RUN_RANKS_H

#include <signal.h>

#include "base/comm.h"
#include "measure/resultant.h"
#include "slipdisk/model.h"
#include "model/state.h"
#include "physics/system/work.h"
#include "slipdisk/simulation.h"

typedef struct ranks ranks;

/* Balance of the work between ranks, as last measured. */
typedef struct ranks_balance {
  /* number of times that the plane was cut into domains, with the first time; 0: not yet */
  int64_t cuts;
  /* (busy time of the busiest rank)/(mean of all ranks) - 1; NAN: not measured yet */
  double excess;
  int64_t least, most; /* smallest and largest number of disks that a rank has */
} ranks_balance;

/* Makes the data of this rank for a simulation over the ranks of `c`. part: engine of this rank,
 * with its model set. stop: a signal handler sets it to nonzero on any rank; after the next steps
 * it is nonzero on all ranks. */
ranks *ranks_new(const comm *c, engine *part, volatile sig_atomic_t *stop);
void ranks_free(ranks *r);

ranks_balance ranks_balance_of(const ranks *r);

/* Distributes the disks over the ranks. On entry the state of each rank has some of the disks and
 * of the contacts, whatever their positions; order: slots of these disks in the sorted order of the
 * disks of all ranks, ascending. Takes over state and order. threads: number of threads of each
 * rank; that of rank 0 counts. */
sd_status ranks_spread(ranks *r, sd_state *state, uint32_t *order, int threads,
                       sd_messages *messages);
/* Makes the state at step 0 (ranks_first.c), distributes its disks over the ranks, and calls
 * loop_begin_phase and loop_start. */
sd_status ranks_start(ranks *r, int threads, sd_messages *messages);
/* Takes up to n steps and does the work between them; state->step is the step reached. After a
 * failure or a stop on any rank all ranks have taken the same smaller number of steps. */
sd_status ranks_advance(ranks *r, int64_t n, sd_messages *messages);
/* Stores contacts, motions and poses of ghosts, which the engine has in its own arrays, in the
 * states of all ranks. rows: only the part needed to write rows of results. */
sd_status ranks_store(ranks *r, bool rows, sd_messages *messages);
/* Returns the sums over all ranks for a row of the time series, except the energies; NULL: out of
 * memory. The states must have been stored (ranks_store). */
const resultants *ranks_resultants(ranks *r, sd_messages *messages);
/* Writes the disks and contacts of each rank to a file of its own, a share of the checkpoint `path`
 * (h5.h); the path given on rank 0 counts. seals: [comm_size()] on rank 0, receives the checksum of
 * each of these files. If a rank fails, all of them are removed. The states must have been
 * stored. */
sd_status ranks_write(ranks *r, const char *path, int64_t *seals, sd_messages *messages);
/* Adds the disks and contacts of each rank to its rows in memory, as parts of frame number `frame`
 * and of contact table number `moment_number` in the next part file; the numbers given on rank 0
 * count. n_contacts: receives the present number of contacts of all ranks; bytes: receives the
 * memory of the rows of all ranks that are not yet written. The states must have been stored. */
sd_status ranks_sample(ranks *r, unsigned what, int64_t frame, int64_t moment_number,
                       size_t *n_contacts, size_t *bytes, sd_messages *messages);
/* Writes the rows in memory of each rank to a file of its own, a share of the part file `path`.
 * seals: as for ranks_write. */
sd_status ranks_seal(ranks *r, const char *path, int64_t *seals, sd_messages *messages);

/* Disks that each rank has at step 0, before they are distributed by position: some disks of the
 * deck, anywhere in space (model/rows.h). */

/* Collective: loads the model of a deck; each rank keeps only some of the disks (model_part). Text,
 * path and overrides given on rank 0 count; only rank 0 gets messages. text NULL: the file at
 * `path` is read. Errors: those of sd_deck_load, and SD_ERROR_USER for decks that cannot run on
 * several ranks (ranks_suit). */
sd_status ranks_load(const comm *c, const char *text, const char *path, size_t n_overrides,
                     const char *const *overrides, sd_model **out, sd_messages *messages);

/* Collective: makes the state with this rank's disks and the prescribed bodies, and order[n_free],
 * the slots of these disks in the sorted order of the disks of all ranks, ascending. Empties
 * model->mine. The caller frees state and order, also after a failure. A rank without memory ends
 * the job. */
sd_status ranks_first_new(const comm *c, const sd_model *model, sd_state **state, uint32_t **order);

/* --- Runs that several ranks can share -------------------------------------------------------- */

/* Returns SD_OK if the model can run on several ranks; else SD_ERROR_USER, with a message for each
 * reason. */
sd_status ranks_suit(const sd_model *model, sd_messages *messages);

#endif
