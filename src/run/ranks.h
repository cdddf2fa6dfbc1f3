/* ranks.h: one simulation over several ranks.
 *
 * Each rank has an engine of its part of the disks (halo.h), and all go through the same session
 * (session.h) and the same loop (loop.h). Nothing of it changes a bit.
 *
 * All functions that return a status are collective, and all ranks return the same one; rank 0
 * hears what the others had to say. Without memory, a rank says so and ends the job.
 */
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

/* How evenly the work was shared, when that was last looked at. */
typedef struct ranks_balance {
  int64_t
      cuts; /* how often the disks were shared out anew, the first time included; 0: they never were */
  double
      excess; /* by which part the busiest rank worked longer than the mean; NAN: not looked at yet */
  int64_t least, most; /* disks of a rank */
} ranks_balance;

/* part: the engine of this rank, whose model is set. c: its ranks. stop: becomes true where this
 * rank gets a signal, and after steps on all ranks. */
ranks *ranks_new(const comm *c, engine *part, volatile sig_atomic_t *stop);
void ranks_free(ranks *r);

ranks_balance ranks_balance_of(const ranks *r);

/* Shares out the disks. Each rank has some of them, wherever they lie, with some of the contacts
 * (state), whose slots in the whole ascend (order). Both are taken over. threads: of each, as
 * rank 0 says. */
sd_status ranks_spread(ranks *r, sd_state *state, uint32_t *order, int threads,
                       sd_messages *messages);
/* Disks of step 0 (ranks_first.c), shared out; then loop_begin_phase and loop_start. */
sd_status ranks_start(ranks *r, int threads, sd_messages *messages);
/* n steps at most, and what is done between them; state->step tells how many. Fewer after a
 * failure or a stop, which then all ranks know of. */
sd_status ranks_advance(ranks *r, int64_t n, sd_messages *messages);
/* Contacts, motions and poses of ghosts to the states of all ranks, whole or for rows of results.
 * */
sd_status ranks_store(ranks *r, bool rows, sd_messages *messages);
/* All that a row of the series sums up beside energies; NULL: no memory. The states are stored. */
const resultants *ranks_resultants(ranks *r, sd_messages *messages);
/* Each rank writes its disks and contacts as a share (h5.h) of the checkpoint `path`, which rank
 * 0 says. seals [comm_size()], on rank 0: their sums. When any fails none is left. The states are
 * stored. */
sd_status ranks_write(ranks *r, const char *path, int64_t *seals, sd_messages *messages);
/* Each rank keeps its rows of frame `frame`, or of the contacts of moment `moment_number` (rank 0
 * says which), of the next part. n_contacts, bytes: of all ranks, now and since the last part. The
 * states are stored. */
sd_status ranks_sample(ranks *r, unsigned what, int64_t frame, int64_t moment_number,
                       size_t *n_contacts, size_t *bytes, sd_messages *messages);
/* Each writes them as a share of the part `path`. */
sd_status ranks_seal(ranks *r, const char *path, int64_t *seals, sd_messages *messages);

/* The disks that ranks have at step 0, before they are shared out: each has some of
 * those of the deck, wherever they lie (model/rows.h). */

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
