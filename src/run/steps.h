/* steps.h: takes the steps of one engine with its threads, and those of the domains of ranks,
 * whose lists are rebuilt and whose disks move to other ranks in between. Used by loop.c and
 * ranks.c. */
#ifndef RUN_STEPS_H
#define RUN_STEPS_H

#include <signal.h>

#include "base/comm.h"
#include "base/comm_cuts.h"
#include "io/results/record.h"
#include "measure/resultant.h"
#include "physics/small/lanes.h"
#include "run/ranks.h"

/* A simulation that is shared by several ranks, as seen by one of them. */
struct ranks {
  const comm *comm;
  const sd_model *model;
  int threads;
  pool *pool;
  volatile sig_atomic_t *stop;
  comm_cuts *cuts;
  engine *part;  /* engine of this rank's domain; state NULL: the disks are not distributed yet */
  double skin;   /* Verlet margin, length; the same on all ranks */
  unsigned bits; /* bits HALO_STALE ... of all ranks after the last step */
  sd_messages *messages; /* messages of this rank */
  /* rows of this rank's disks and contacts since the last sealed part */
  record rows;
  resultants sums;  /* sums over all ranks for a row of the series */
  double busy;      /* seconds of work since the domains were last cut */
  int64_t cut_step; /* step of the last cut */
  ranks_balance balance;
};

/* Returns true if the running phase is measured. */
static inline bool steps_are_measured(const engine *e) {
  return e->state->phase < (int64_t)e->model->n_phases && e->model->phases[e->state->phase].measure;
}

/* Takes steps with the threads of one engine up to step `until`, within the running phase. In a run
 * over several ranks it ends earlier, with the bits of step_agree in *bits, if lists are stale, a
 * rank has failed, or a rank asks to stop (stop: this rank does if it becomes nonzero). */
void loop_steps(engine *e, pool *threads, int64_t until, const volatile sig_atomic_t *stop,
                unsigned *bits);

/* --- Domains of ranks ------------------------------------------------------------------------- */

/* Takes n steps, or fewer if a rank fails or asks to stop: see engine_status of each rank and
 * state->step. */
void ranks_steps(engine *part, int64_t n);
/* Sorts the disks into the order with which a phase begins. */
sd_status ranks_order_again(engine *part);
/* Rebuilds the engine of this rank from `from` after its disks have moved to the ranks that own
 * their positions. first: see move_parts. */
sd_status ranks_take_part(ranks *r, const engine *from, bool first);
/* Stores contacts, motions and poses of ghosts in the rank's state. rows: only what rows of results
 * need. */
sd_status ranks_store_part(ranks *r, bool rows);

/* --- Systems in lanes ------------------------------------------------------------------------- */

/* Takes n steps of all systems within a phase, and closes bins of angle records when they are full.
 * A step that lanes cannot do is a general step of each system. Takes fewer if one of the systems
 * fails: the others then stop at the same step, and the work.status of the failed system says so.
 * States are complete before and after. measure: the phase is measured. */
void lanes_loop(lanes *l, int64_t n, bool measure);

/* --- Messages of ranks ------------------------------------------------------------------------ */

/* Collective: passes messages to rank 0 and clears the own list. All ranks pass the same status.
 * Rank 0 (other ranks: messages NULL) gets the warnings of its own list, which every rank has
 * alike, and, after a failure, the errors of all ranks, equal ones once. Returns the status. */
sd_status ranks_tell(const comm *c, sd_status status, sd_messages *own, sd_messages *messages);

#endif
