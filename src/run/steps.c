/* steps.c: takes steps, with several threads, over several ranks, or with several systems in SIMD
 * lanes; see steps.h. */
#include "run/steps.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/math.h"
#include "base/team.h"
#include "base/comm.h"
#include "base/comm_cuts.h"
#include "base/memory.h"
#include "base/subnormal.h"
#include "io/results/record.h"
#include "measure/sample.h"
#include "model/model.h"
#include "pack/relax.h"
#include "physics/motion/motion.h"
#include "physics/neighbours/neighbours.h"
#include "physics/step/access.h"
#include "physics/step/contacts.h"
#include "physics/step/engine.h"
#include "physics/step/step.h"
#include "physics/step/window.h"
#include "physics/system/halo.h"
#include "run/ranks_move.h"

/* Arguments of the threads that take the steps of one engine together. */
typedef struct steps_task {
  engine *e;
  int64_t until;
  bool measure;
  /* [number of threads] sums for the relaxation; NULL: the phase does not relax the system */
  relax_sums *sums;
  const volatile sig_atomic_t *stop;
  unsigned *bits;
} steps_task;

/* Returns true if another step may be taken; in a run over several ranks all ranks get the same
 * answer. */
static bool may_step(const steps_task *a, const team *t) {
  const int64_t step = a->e->state->step;
  if (!a->e->comm) return step < a->until;
  if (t->rank == 0) *a->bits = step_agree(a->e, a->stop && *a->stop);
  team_wait(t);
  if (*a->bits & (HALO_STALE | HALO_FAILED) || step == a->until) return false;
  return !(*a->bits & HALO_STOP) || step + 1 == a->until;
}

/* Returns true if the step has failed. In a run over several ranks a failure on any rank counts if
 * the phase relaxes the system, since relaxation needs sums over all ranks. */
static bool has_failed(const steps_task *a, const team *t) {
  const bool failed = engine_status(a->e) != SD_OK;
  if (!a->e->comm || !a->sums) return failed;
  if (t->rank == 0) *a->bits = comm_or(a->e->comm, failed);
  team_wait(t);
  return *a->bits != 0;
}

/* Returns how many steps can be taken before something looks at the disks, at most up to the last
 * step. */
static int64_t steps_unseen(const steps_task *a) {
  const int64_t left = a->until - a->e->state->step, seen = sample_steps_to_look(a->e);
  return a->measure && seen < left ? seen : left;
}

/* Takes steps in one thread; all threads of the team call it. */
static void take_steps(const steps_task *a, const team *t) {
  engine *e = a->e;
  const int64_t measured = e->state->measured, from = e->state->step;
  for (int64_t step = from; may_step(a, t); step++) {
    int64_t n = window_steps(e, t, steps_unseen(a));
    if (n < 2 || !window_run(e, t, n)) {
      n = 1;
      step_once(e, t);
    }
    step += n - 1;
    team_wait(t);
    const bool failed = has_failed(a, t);
    if (failed && !e->comm) return;
    if (failed) continue; /* go on to may_step, where all ranks learn of the failure */
    if (a->sums) relax_step(e, t, a->sums);
    if (!a->measure) continue;
    disks_step(e, t, measured + (step - from) + 1);
    if (t->rank == 0) sample_steps(e, n);
    team_wait(t);
  }
}

static void member(const team *t, void *with) {
  const steps_task *a = with;
  uint64_t mode = subnormal_off();
  if (engine_lanes(a->e))
    lanes_loop(engine_lanes(a->e), a->until - a->e->state->step, a->measure);
  else
    take_steps(a, t);
  subnormal_restore(mode);
}

void loop_steps(engine *e, pool *threads, int64_t until, const volatile sig_atomic_t *stop,
                unsigned *bits) {
  steps_task task = {
      .e = e, .until = until, .measure = steps_are_measured(e), .stop = stop, .bits = bits};
  if (e->model->phases[e->state->phase].relax)
    task.sums = memory_new((size_t)engine_threads(e), sizeof *task.sums);
  if (until > e->state->step) step_begin(e, until - e->state->step);
  pool_run(threads, member, &task);
  free(task.sums);
}

/* The plane is cut into domains again if the busiest rank works longer than the mean of the ranks
 * by more than this fraction. */
static const double IMBALANCE = 0.1;
enum { CUT_LEAST = 200 }; /* smallest number of steps between two cuts of the plane into domains */

ranks *ranks_new(const comm *c, engine *part, volatile sig_atomic_t *stop) {
  ranks *r = memory_new(1, sizeof *r);
  *r = (ranks){.comm = c,
               .model = part->model,
               .part = part,
               .stop = stop,
               .messages = sd_messages_new(),
               .balance.excess = NAN};
  record_new(&r->rows, r->model, RECORD_SHARE);
  resultants_new(&r->sums, r->model);
  return r;
}

/* Frees the engine, halo and state of this rank's domain. */
static void drop_part(ranks *r) {
  engine *e = r->part;
  halo *h = e->halo;
  if (e->state) engine_free(e);
  halo_free(h);
  sd_state_free(e->state);
  *e = (engine){.model = r->model};
}

void ranks_free(ranks *r) {
  if (!r) return;
  drop_part(r);
  pool_free(r->pool);
  record_free(&r->rows);
  resultants_free(&r->sums);
  comm_cuts_free(r->cuts);
  sd_messages_free(r->messages);
  free(r);
}

ranks_balance ranks_balance_of(const ranks *r) { return r->balance; }

/* --- Domains ---------------------------------------------------------------------------------- */

static sd_status renew_part(engine *e, sd_messages *messages);

sd_status ranks_take_part(ranks *r, const engine *from, bool first) {
  engine next = {
      .comm = r->comm, .renew = renew_part, .ranks = r, .model = r->model, .pool = r->pool};
  sd_status status = move_parts(r->cuts, from, first, r->skin, &next.state, &next.halo);
  drop_part(r);
  *r->part = next;
  if (status == SD_OK) status = engine_build(r->part, r->threads, r->messages);
  /* halo_list_prescribed is collective, so either all ranks call it or none. */
  if (comm_all_well(r->comm, status) && halo_list_prescribed(r->part) != SD_OK)
    status = SD_ERROR_IO;
  if (status != SD_OK && sd_messages_errors(r->messages) == 0)
    sd_fail(r->messages, status, "no memory for the disks of this rank");
  engine_ready(r->part, r->messages);
  engine_end(r->part, status);
  return status;
}

sd_status ranks_store_part(ranks *r, bool rows) {
  engine *e = r->part;
  halo_refresh(e, NULL);
  motion_store(e);
  const sd_status status = rows ? contacts_store_rows(e) : contacts_store(e);
  return status == SD_OK ? SD_OK
                         : sd_fail(r->messages, SD_ERROR_IO, "out of memory for the contacts");
}

/* Rebuilds the neighbour lists of one rank's domain, as its function for engine_renew. */
static sd_status renew_part(engine *e, sd_messages *messages) {
  ranks *r = e->ranks;
  (void)messages; /* messages of this rank go to r->messages */
  const sd_status status = comm_agree(r->comm, ranks_store_part(r, false));
  return status == SD_OK ? comm_agree(r->comm, ranks_take_part(r, e, false)) : status;
}

sd_status ranks_order_again(engine *e) {
  ranks *r = e->ranks;
  sd_status status = comm_agree(r->comm, ranks_store_part(r, false));
  if (status != SD_OK || r->model->n_free < ORDER_LEAST) return status;
  status = ranks_order(r->comm, r->model, e->state, e->halo->order);
  engine_find_slots(e);
  return comm_agree(r->comm, status == SD_OK ? ranks_take_part(r, e, false) : status);
}

/* Collective: measures how evenly the work is distributed over the ranks. */
static void note_balance(ranks *r) {
  const double mean = comm_total(r->comm, r->busy) / comm_size(r->comm),
               disks = (double)r->part->state->n_free;
  r->balance.excess = mean > 0.0 ? comm_largest(r->comm, r->busy) / mean - 1.0 : 0.0;
  r->balance.most = (int64_t)comm_largest(r->comm, disks);
  r->balance.least = (int64_t)-comm_largest(r->comm, -disks);
}

/* Rebuilds the neighbour lists: disks that have left the rectangle of their rank move to other
 * ranks, and new ghosts are chosen. Cuts the plane again if the work is unbalanced. */
static sd_status renew(ranks *r) {
  engine *e = r->part;
  const int64_t step = e->state->step;
  sd_status status = neighbours_check_finite(e, step, r->messages);
  if (!comm_all_well(r->comm, status)) return status;
  neighbours_tune(e);
  /* Verlet margin without the widening that a single fast step has needed */
  r->skin = r->model->skin > 0.0 ? r->model->skin : engine_skin(e);
  if (step - r->cut_step >= CUT_LEAST) {
    note_balance(r);
    if (r->balance.excess > IMBALANCE) {
      status = move_cut_again(r->cuts, r->part, r->busy);
      r->balance.cuts++;
    }
    r->cut_step = step;
    r->busy = 0.0;
    if (!comm_all_well(r->comm, status))
      return sd_fail(r->messages, SD_ERROR_IO, "cannot balance the ranks");
  }
  /* Widen the Verlet margin until no disk or wall can move out of it in one step. If a position is
   * not finite, no margin is wide enough. */
  for (;;) {
    status = ranks_store_part(r, false);
    if (comm_all_well(r->comm, status)) status = ranks_take_part(r, r->part, false);
    if (!comm_all_well(r->comm, status)) return status;
    if (!comm_or(r->comm, engine_outruns(r->part))) return SD_OK;
    status = neighbours_check_next(r->part, r->messages);
    if (!comm_all_well(r->comm, status)) return status;
    if (!isfinite(r->skin))
      return sd_fail(r->messages, SD_ERROR_NUMERIC, "step %lld: a wall is not finite",
                     (long long)step + 1);
    r->skin = math_max(1.5 * r->skin, comm_largest(r->comm, engine_outrun_skin(r->part)));
  }
}

/* --- Steps of ranks --------------------------------------------------------------------------- */

void ranks_steps(engine *e, int64_t n) {
  ranks *r = e->ranks;
  int64_t until = e->state->step + n;
  do {
    const double began = clock_seconds();
    e->halo->waited = 0.0;
    loop_steps(e, r->pool, until, r->stop, &r->bits);
    r->busy += clock_seconds() - began - e->halo->waited;
    if (r->bits & HALO_STALE && !(r->bits & HALO_FAILED)) {
      /* Neighbour lists serve further steps only: do not rebuild them after the last step, as in a
       * run in one process. */
      const int64_t step = e->state->step;
      const sd_status status =
          step < until ? renew(r) : neighbours_check_finite(e, step, r->messages);
      engine_end(e, status);
      if (!comm_all_well(r->comm, status)) r->bits |= HALO_FAILED;
    }
    const int64_t next = e->state->step + 1;
    if (r->bits & HALO_STOP && next < until) until = next;
  } while (!(r->bits & HALO_FAILED) && e->state->step < until);
}

/* Returns the number of measured steps until a bin of recorded angles is full in one of the
 * systems. */
static int64_t least_room(const lanes *l) {
  int64_t least = INT64_MAX;
  for (size_t k = 0; k < l->count; k++) {
    int64_t room = sample_steps_to_bin_end(l->system[k]);
    if (room < least) least = room;
  }
  return least;
}

/* Takes one general step of each system, because an angle leaves the range for which the lanes
 * work, or a motion cannot be computed ahead. */
static void general_step(lanes *l, bool measure) {
  const team alone = {.size = 1};
  lanes_store(l);
  for (size_t k = 0; k < l->count; k++) {
    engine *e = l->system[k];
    if (engine_status(e) != SD_OK) continue;
    if (l->motion) motion_resume(e);
    step_begin(e, 1);
    step_once(e, &alone);
    if (engine_status(e) == SD_OK && measure) sample_steps(e, 1);
    if (l->motion) motion_store(e);
  }
}

static bool any_wrong(const lanes *l) {
  bool wrong = false;
  for (size_t k = 0; k < l->count; k++) wrong = wrong || engine_status(l->system[k]) != SD_OK;
  return wrong;
}

/* Closes the bins of recorded angles that are full, in all systems. */
static void close_bins(const lanes *l) {
  lanes_show_angles(l);
  for (size_t k = 0; k < l->count; k++)
    if (engine_status(l->system[k]) == SD_OK) sample_bins(l->system[k]);
}

void lanes_loop(lanes *l, int64_t n, bool measure) {
  lanes_load(l);
  while (n > 0) {
    int64_t now = lanes_ready(l), room = measure ? least_room(l) : INT64_MAX;
    if (now == 0) {
      general_step(l, measure);
      n--;
      if (any_wrong(l)) return;
      lanes_load(l);
      continue;
    }
    assert(now > 0 && room > 0);
    if (now > room) now = room;
    int64_t taken = lanes_take(l, n < now ? n : now, measure);
    n -= taken;
    assert(n >= 0 && taken <= room);
    if (measure && taken == room) close_bins(l);
    if (any_wrong(l)) break;
  }
  lanes_store(l);
}

/* Returns the texts of the error messages, one after the other, each with its terminating zero. */
static char *errors_of(const sd_messages *m, size_t *length) {
  *length = 0;
  for (size_t k = 0; k < sd_messages_count(m); k++) *length += strlen(sd_messages_text(m, k)) + 1;
  char *text = memory_new(*length, 1), *at = text;
  for (size_t k = 0; k < sd_messages_count(m); k++) {
    if (sd_messages_kind(m, k) == SD_OK) continue;
    const size_t n = strlen(sd_messages_text(m, k)) + 1;
    memcpy(at, sd_messages_text(m, k), n);
    at += n;
  }
  *length = (size_t)(at - text);
  return text;
}

/* Collective: adds the error messages of all ranks to `messages` on rank 0; equal ones are added
 * once. */
static void tell_errors(const comm *c, sd_status status, const sd_messages *own,
                        sd_messages *messages) {
  size_t length, bytes = 0;
  char *mine = errors_of(own, &length);
  int *counts = memory_new((size_t)comm_size(c), sizeof *counts);
  comm_gather_counts(c, (int)length, counts);
  for (int q = 0; q < comm_size(c); q++) bytes += (size_t)counts[q];
  char *text = memory_new(bytes, 1);
  comm_gather(c, mine, text, counts, 1);
  for (size_t at = 0; messages && at < bytes; at += strlen(text + at) + 1)
    if (!messages_have(messages, text + at)) sd_fail(messages, status, "%s", text + at);
  free(mine);
  free(counts);
  free(text);
}

sd_status ranks_report(const comm *c, sd_status status, sd_messages *own, sd_messages *messages) {
  for (size_t k = 0; messages && k < sd_messages_count(own); k++)
    if (sd_messages_kind(own, k) == SD_OK) sd_warn(messages, "%s", sd_messages_text(own, k));
  if (status != SD_OK) tell_errors(c, status, own, messages);
  sd_messages_clear(own);
  return status;
}
