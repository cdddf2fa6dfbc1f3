/* steps.h: takes the steps of one engine with its threads, and the steps of several ranks, whose
 * neighbour lists are rebuilt and whose disks move to other ranks in between. Used by loop.c and
 * ranks.c. */
#ifndef RUN_STEPS_H
#define RUN_STEPS_H

#include <signal.h>

#include "model/model.h"
#include "base/comm.h"
#include "base/comm_cuts.h"
#include "io/results/record.h"
#include "measure/resultant.h"
#include "physics/small/lanes.h"
#include "run/ranks.h"

/* Data of one rank about a simulation that several ranks share. */
struct ranks {
  const comm *comm;
  const sd_model *model;
  int threads;
  pool *pool;
  volatile sig_atomic_t *stop;
  comm_cuts *cuts;
  engine *part;  /* engine of this rank's domain; state NULL: the disks are not distributed yet */
  double skin;   /* Verlet margin, a length; the same on all ranks */
  unsigned bits; /* bits HALO_STALE, HALO_STOP, ... that any rank has set in the last step */
  sd_messages *messages; /* messages of this rank */
  /* rows of this rank's disks and contacts that are not yet written to a part file */
  record rows;
  resultants sums;  /* sums over all ranks for a row of the time series */
  double busy;      /* seconds of work of this rank since the plane was last cut into domains */
  int64_t cut_step; /* step at which the plane was last cut into domains */
  ranks_balance balance;
};

/* Returns true if the running phase measures. */
static inline bool steps_are_measured(const engine *e) {
  return e->state->phase < (int64_t)e->model->n_phases && e->model->phases[e->state->phase].measure;
}

/* Takes steps with the threads of one engine up to step `until`, which must be in the running
 * phase. stop: nonzero if this rank is asked to stop. In a run over several ranks it returns
 * earlier, with the bits of step_agree in *bits, if neighbour lists are out of date, or if a rank
 * has failed or is asked to stop. */
void loop_steps(engine *e, pool *threads, int64_t until, const volatile sig_atomic_t *stop,
                unsigned *bits);

/* --- Domains of ranks ------------------------------------------------------------------------- */

/* Takes n steps, or fewer if a rank fails or is asked to stop; engine_status of each rank and
 * state->step tell the outcome. */
void ranks_steps(engine *part, int64_t n);
/* Sorts the disks in space before a phase begins. */
sd_status ranks_order_again(engine *part);
/* Moves the disks of `from` to the ranks in whose domains they are, and rebuilds the engine of this
 * rank. first: as for move_parts. */
sd_status ranks_take_part(ranks *r, const engine *from, bool first);
/* Stores contacts, motions and poses of ghosts in this rank's state. rows: only the part needed to
 * write rows of results. */
sd_status ranks_store_part(ranks *r, bool rows);

/* --- Systems in lanes ------------------------------------------------------------------------- */

/* Takes n steps of all systems in the SIMD lanes, which must all be in one phase; closes bins of
 * recorded angles when they are full. A step that the lanes cannot do is done as a general step of
 * each system. If a system fails, all systems stop at the same step, and work.status of that system
 * tells it. States are complete before and after. measure: true if the phase measures. */
void lanes_loop(lanes *l, int64_t n, bool measure);

/* --- Messages of ranks ------------------------------------------------------------------------ */

/* Collective: passes the messages of all ranks to rank 0 and clears the list `own` of this rank.
 * All ranks must pass the same status, which is returned. messages: on rank 0, receives the
 * warnings of its own list, since all ranks have the same ones, and after a failure the errors of
 * all ranks, equal ones once; NULL on the other ranks. */
sd_status ranks_report(const comm *c, sd_status status, sd_messages *own, sd_messages *messages);

#endif
