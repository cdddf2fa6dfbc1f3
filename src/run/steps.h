/* steps.h: steps of one engine by its threads, and of the parts that ranks have, whose lists are made anew
 * and whose disks move on the way. For loop.c and ranks.c. */
#ifndef RUN_STEPS_H
#define RUN_STEPS_H

#include <signal.h>

#include "base/comm.h"
#include "base/comm_cuts.h"
#include "io/results/record.h"
#include "measure/resultant.h"
#include "physics/small/lanes.h"
#include "run/ranks.h"

struct ranks {
  const comm *comm;
  const sd_model *model;
  int threads;
  pool *pool;
  volatile sig_atomic_t *stop;
  comm_cuts *cuts;
  engine *part; /* of this rank; state NULL: not spread */
  double skin;
  unsigned bits;         /* of all ranks, after the last step */
  sd_messages *messages; /* of this rank */
  record rows;           /* of this rank, since the last part */
  resultants sums;       /* of all ranks, for a row of the series */
  double busy;           /* seconds of work since the last cut */
  int64_t cut_step;
  ranks_balance balance;
};

/* The present phase measures. */
static inline bool steps_are_measured(const engine *e) {
  return e->state->phase < (int64_t)e->model->n_phases && e->model->phases[e->state->phase].measure;
}

/* Steps of the team of one engine up to step `until`, in the present phase. Where ranks share
 * them it ends before, with the bits of step_agree in *bits, when lists are stale, a rank has
 * failed, or any is to stop (stop: this one). */
void loop_steps(engine *e, pool *threads, int64_t until, const volatile sig_atomic_t *stop,
                unsigned *bits);

/* --- parts of ranks --------------------------------------------------------------------------- */

/* n steps, or fewer when a rank fails or is to stop: engine_status of each, state->step. */
void ranks_steps(engine *part, int64_t n);
/* Puts the disks into the order that a phase begins with. */
sd_status ranks_order_again(engine *part);
/* A new engine of the part `from` after its disks have gone where they belong; first: see move_parts. */
sd_status ranks_take_part(ranks *r, const engine *from, bool first);
/* The part as a state that can be sent; or for rows of results alone. */
sd_status ranks_store_part(ranks *r, bool rows);

/* Steps of systems in lanes, with what belongs to them: angle records, steps that need the general text. */

/* n steps within a phase, or fewer when one of the systems goes wrong: the others are then where it was, and its
 * work.status says so. States are complete before and after. */
void lanes_loop(lanes *l, int64_t n, bool measure);

/* --- what ranks say when one of them cannot go on --------------------------------------------- */

/* Collective, with a status on which all ranks agree. Rank 0 (the others: messages NULL) gets the
 * warnings of its own list, which every rank has alike, and after a failure the errors of all
 * ranks, equal ones once. The list is empty then. Returns the status. */
sd_status ranks_tell(const comm *c, sd_status status, sd_messages *own, sd_messages *messages);

#endif
