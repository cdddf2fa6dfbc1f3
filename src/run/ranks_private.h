/* ranks_private.h: what the files of `ranks` share. All functions are collective, the same on every rank; a status is of this rank. */
#ifndef SLIPDISK_RUN_RANKS_PRIVATE_H
#define SLIPDISK_RUN_RANKS_PRIVATE_H

#include "base/comm_cuts.h"
#include "io/results/record_share.h"
#include "model/advice.h"
#include "run/ranks.h"

struct ranks {
  const sd_model *model;
  int threads;
  pool *pool;
  volatile sig_atomic_t *stop;
  comm_cuts *cuts;
  engine part; /* of this rank; state NULL: not spread */
  double skin;
  unsigned bits;         /* of all ranks, after the last step */
  sd_messages *messages; /* of this rank */
  record_share rows;     /* of this rank, since the last part */
  resultants sums;       /* of all ranks, for a row of the series */
  int64_t collected;     /* step of the whole state */
  double busy;           /* seconds of work since the last cut */
  int64_t cut_step;
  ranks_balance balance;
  first_overlap
      deepest; /* at the start, of all ranks, where the deck's check did not see all pairs; relative 0: none */
};

/* --- ranks.c ---------------------------------------------------------------------------------------------- */
/* False: some rank could not. */
bool ranks_all_well(sd_status status);
/* The part that this rank has now, of the disks that `from` has (NULL: nothing): an engine with lists. */
sd_status ranks_take_part(ranks *r, const engine *from);
/* The part as a state that can be sent. Not collective but for poses of ghosts. */
sd_status ranks_store_part(ranks *r);

/* --- ranks_phase.c ---------------------------------------------------------------------------------------- */
sd_energy ranks_add_energies(ranks *r);
/* The whole (rank 0) learns how fast walls move. */
settle_measure ranks_rest_of(ranks *r, sd_state *whole);
/* Batches of rain that are due fall. */
sd_status ranks_release_rain(ranks *r);
/* Disks that have left the bounds, or come back. Rank 0 tells of them in messages (the others: NULL). */
sd_status ranks_look_outside(ranks *r, sd_messages *messages);
/* Step 0, once motions run: engine_start. kept: contacts of the packing, of all ranks. */
sd_status ranks_start_part(ranks *r, bool measure, double *kept);
/* The phase ends after so many steps; the next one begins. */
sd_status ranks_end_part(ranks *r, int64_t phase_step);

#endif
