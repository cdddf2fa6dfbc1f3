/* ranks.h: one simulation over the ranks of an MPI job.
 *
 * Rank 0 leads: it has the session and, between steps, may have the whole state. The others serve: they wait for its word, and
 * do the same at the same time. While the disks are spread over the ranks each has an engine of its part (halo.h), and the whole state is
 * as old as the last ranks_collect. What ranks cannot share (phases that relax or compress) is done on the whole, by rank 0, as
 * in a run on one rank; then the disks are spread again. Nothing of it changes a bit.
 *
 * A failure in a step is told by all ranks, and rank 0 returns it. Without memory, a rank says so and ends the job.
 */
#ifndef SLIPDISK_RUN_RANKS_H
#define SLIPDISK_RUN_RANKS_H

#include <signal.h>

#include "io/results/summary.h"
#include "measure/resultant.h"
#include "pack/settle.h"
#include "physics/system/work.h"
#include "slipdisk/simulation.h"

typedef struct ranks ranks;

/* How evenly the work was shared, when that was last looked at. */
typedef struct ranks_balance {
  int64_t cuts;  /* how often the disks were shared out anew, the first time included; 0: they never were */
  double excess; /* by which part the busiest rank worked longer than the mean; NAN: not looked at yet */
  int64_t least, most; /* disks of a rank */
} ranks_balance;

/* The job has several ranks. stop: becomes true where this rank gets a signal, and then on rank 0,
 * too. NULL: no memory for the rows of results. */
ranks *ranks_new(const sd_model *model, volatile sig_atomic_t *stop);
void ranks_free(ranks *r);

/* --- rank 0 --------------------------------------------------------------------------------------------- */
bool ranks_are_spread(const ranks *r);
/* Shares out the disks, whose contacts stand in whole->state if it has no lists; ranks_advance does it where they are not. */
sd_status ranks_spread(ranks *r, engine *whole, sd_messages *messages);
/* The same at step 0, of a whole without lists, once the first phase's motions run: engine_start; and measuring begins. */
sd_status ranks_start(ranks *r, engine *whole, bool measure, sd_messages *messages);
/* n steps at most; whole->state->step tells how many. Fewer after a failure or a stop. */
sd_status ranks_advance(ranks *r, engine *whole, int64_t n, bool measure, sd_messages *messages);
/* Brings whole->state up to date, contacts too. SD_ERROR_IO: no memory. */
sd_status ranks_collect(ranks *r, engine *whole);
/* The same; then rank 0 has everything, and whole->work is complete. */
sd_status ranks_center(ranks *r, engine *whole, sd_messages *messages);
ranks_balance ranks_balance_of(const ranks *r);
/* How near all disks are to rest; whole->state then knows how fast walls move. */
settle_measure ranks_rest(ranks *r, engine *whole);
/* Batches of rain that are due fall. */
sd_status ranks_rain(ranks *r, engine *whole, sd_messages *messages);
/* outside_look, where the run does not stop by it; would it of the whole change anything? */
sd_status ranks_outside(ranks *r, engine *whole, sd_messages *messages);
bool ranks_outside_is_due(ranks *r);
/* The phase ends, also for whole->state, and the next one begins, which must be one that ranks can share; the disks stay where they are. */
sd_status ranks_end_phase(ranks *r, engine *whole, sd_messages *messages);
/* Energies of the whole, and all else that a row of the series sums up (NULL: no memory): each rank adds up its own disks and
 * contacts, without rounding, so that these are the bits of one process. */
sd_energy ranks_energy(ranks *r);
const resultants *ranks_resultants(ranks *r, sd_messages *messages);
/* Each rank writes its disks and contacts as a share (h5.h) of the checkpoint `path`; whole->state then has the rest. seals
 * [comm_size()]: their sums. contacts, lost: of all ranks. When any fails none is left. */
sd_status ranks_write(ranks *r, engine *whole, const char *path, int64_t *seals, summary_contacts *contacts,
                      summary_lost *lost, sd_messages *messages);
/* Each rank keeps its rows of frame `frame`, or of the contacts of moment `moment_number`, of the next part; whole->state then
 * has the rest, as above. n_contacts, bytes: of all ranks, now and since the last part. */
sd_status ranks_sample(ranks *r, engine *whole, unsigned what, int64_t frame, int64_t moment_number,
                       size_t *n_contacts, size_t *bytes, sd_messages *messages);
/* Each writes them as a share of the part `path`; also when they are not spread any more. */
sd_status ranks_seal(ranks *r, const char *path, int64_t *seals, sd_messages *messages);
/* The others may go home, with this exit status. */
void ranks_dismiss(int status);

/* --- the others ------------------------------------------------------------------------------------------- */
/* Returns the status that ranks_dismiss was given. */
int ranks_serve(ranks *r);

#endif
