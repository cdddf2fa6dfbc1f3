/* step.c: one time step, in these stages:
 *
 * 1. Set prescribed bodies and the box at t + dt; call the force fields of the program. 2. If the
 * neighbour lists are stale, rebuild them; contact records are carried over. 3. Chunk by chunk:
 * predict the free disks in the chunk's pairs, evaluate each contact once (force, lambda_ref,
 * losses), correct the disks of the chunk; with several ranks, messages with ghosts travel
 * meanwhile. 4. Evaluate contacts with ghosts. 5. Correct chunks that had to wait for contacts with
 * ghosts or for other threads. 6. Handle rare events.
 *
 * Every loop writes only at its own indices; each wait makes all writes before it visible to the
 * whole team of threads.
 */
#include "physics/step/step.h"

#include <assert.h>

#include "physics/contact/walls.h"
#include "physics/motion/motion.h"
#include "physics/neighbours/neighbours.h"
#include "physics/neighbours/validity.h"
#include "physics/step/bonds.h"
#include "physics/step/cell.h"
#include "physics/step/contacts.h"
#include "physics/system/fields.h"
#include "physics/system/halo.h"
#include "physics/system/kernels.h"

static bool any_stale(const work *w) {
  bool stale = false;
  for (int k = 0; k < w->n_threads; k++) stale |= w->threads[k].stale;
  return stale;
}

/* --- step ------------------------------------------------------------------------------------- */

/* Loop of one thread over its ranges of chunks. The chunks are divided into n_threads ranges; if
 * the team has fewer threads, each takes several ranges. */
#define FOR_SHARES(t, share, w)                                                                    \
  for (int share = (t)->rank; share < (w)->n_threads; share += (t)->size)
#define FOR_CHUNKS(k, w, share)                                                                    \
  for (size_t k = (w)->chunks.share[share]; k < (w)->chunks.share[(share) + 1]; k++)

static void predict_all(engine *e, const team *t) {
  FOR_SHARES(t, share, &e->work) FOR_CHUNKS(k, &e->work, share) chunk_predict(e, k);
}

/* Marks every chunk (all) or no chunk as predicted for the coming step. After a rebuild of the
 * lists the marks are lost and must be set again. */
static void note_predicted(engine *e, bool all) {
  chunks *c = &e->work.chunks;
  for (size_t k = 0; k < c->count; k++) {
    c->predicted[k] = e->state->step + all;
    c->packed[k] = INT64_MIN;
  }
}

/* Rebuilds the lists for the coming step. If a disk moves so far in this step that even the new
 * lists would be stale, they are built again at the predicted positions. */
static sd_status renew_lists(engine *e) {
  work *w = &e->work;
  const team alone = {.size = 1};
  neighbours_tune(e);
  sd_status status = neighbours_build(e, w->messages);
  note_predicted(e, w->predict_all);
  if (status != SD_OK || w->predict_all) return status;
  const bool outruns = w->kernels->stale(e, 0, e->state->n_free, 1.0);
  if (outruns) predict_all(e, &alone);
  cell_pose(e, e->state->step + 1);
  if (!outruns) return status;
  status = neighbours_build(e, w->messages);
  note_predicted(e, true);
  return status;
}

/* Rebuilds the lists: the first thread runs renew_lists, the others help it in loops over long
 * lists. */
static void renew_together(engine *e, const team *t) {
  team_wait(t); /* until all threads have read the status that is written below */
  if (t->rank > 0) {
    team_help(t);
    return;
  }
  team_lead(t);
  e->work.status = renew_lists(e);
  team_release(t);
}

void step_begin(engine *e, int64_t n) {
  const sd_state *s = e->state;
  work *w = &e->work;
  assert(n > 0 && s->phase >= 0 && (size_t)s->phase < e->model->n_phases);
  if (w->body_forces && w->body_forces->phase != s->phase) body_forces_fill(e);
  w->kernels->pack(e, s->n_free, s->n_bodies);
  w->show_from = s->step + n;
  w->predict_all = e->model->phases[s->phase].relax || motion_moves(e) & MOVES_FREE || e->fields ||
                   w->clumps.count > 0;
  for (int t = 0; t < w->n_threads; t++) w->threads[t].stale = false;
  w->threads[0].stale = w->kernels->stale(e, 0, s->n_free, 1.0);
  note_predicted(e, false);
}

/* Predicts all disks, then checks whether the lists are stale. Without this order the check comes
 * at the end of the step before; that is not enough if velocities change between steps, or if
 * predicted coordinates are overwritten (prescribed ones, clumps). */
static void predict_and_check(engine *e, const team *t) {
  work *w = &e->work;
  predict_all(e, t);
  if (w->clumps.count) {
    clumps_predict(e, t);
    team_wait(t);
    clumps_place(e, t);
    team_wait(t);
  }
  FOR_SHARES(t, share, w) {
    const chunks *c = &w->chunks;
    const size_t begin = c->begin[c->share[share]], end = c->begin[c->share[share + 1]];
    w->threads[share].stale = begin < end && w->kernels->stale(e, begin, end, 0.0);
  }
}

unsigned step_agree(engine *e, bool stop) {
  work *w = &e->work;
  halo *h = e->halo;
  /* check again, since velocities may have changed after the corrector's check */
  if (w->status == SD_OK && (any_stale(w) || motion_outruns(e) ||
                             (w->predict_all && w->kernels->stale(e, 0, e->state->n_free, 1.0))))
    h->bits |= HALO_STALE;
  if (w->status != SD_OK) h->bits |= HALO_FAILED;
  if (stop) h->bits |= HALO_STOP;
  const unsigned all = halo_agree(h);
  if (all & HALO_WAITS && contacts_update_ghosts(e) != SD_OK)
    w->status = sd_fail(w->messages, SD_ERROR_IO, "out of memory for contact events");
  if (all & HALO_BROKE && bonds_gather(e) != SD_OK)
    w->status = sd_fail(w->messages, SD_ERROR_IO, "out of memory for broken bonds");
  h->shifted.count = 0;
  return all;
}

/* Stores the contact forces on prescribed bodies in the state, summed over all ranks. With several
 * ranks this is skipped in steps after which the forces are not needed. */
static void gather_prescribed(engine *e) {
  const sd_state *s = e->state;
  const work *w = &e->work;
  if (e->halo && !motion_runs(e) && s->step + 1 < w->show_from) return;
  if (e->halo) halo_gather_prescribed(e);
  w->kernels->gather(e, s->n_free + s->n_ghosts, s->n_bodies);
}

void step_once(engine *e, const team *t) {
  work *w = &e->work;
  const bool first = t->rank == 0;
  assert(t->rank >= 0 && t->rank < t->size && t->size <= w->n_threads);
  if (w->predict_all) {
    predict_and_check(e, t);
    team_wait(t);
  }
  if (first) {
    motion_pose(e, &w->threads[0]);
    fields_apply(e);
    body_forces_at(e, e->state->step + 1);
    if (motion_moves(e) & MOVES_WALLS) walls_pose_listed(e);
    /* with several ranks, step_agree has asked for the flags of all of them */
    w->stale = !e->halo && any_stale(w);
    if (w->predict_all || !w->stale)
      cell_pose(e, e->state->step + 1); /* else renew_lists calls cell_pose */
    pairs_clear_single(e);
  }
  team_wait(t);
  if (w->status != SD_OK) return; /* a force field of the program reported an error */
  if (w->stale) {
    renew_together(e, t);
    if (w->status != SD_OK) return;
  }

  if (w->chunks.any_boundary_first) {
    FOR_SHARES(t, share, w)
    FOR_CHUNKS(k, w, share) if (w->chunks.boundary_first[k]) chunk_pack(e, k);
    team_wait(t);
  }
  if (e->halo && first) halo_start(e);
  FOR_SHARES(t, share, w) chunks_step(e, share);
  if (e->halo) {
    if (first) halo_finish(e);
    team_wait(t);
    FOR_SHARES(t, share, w) chunks_ghosts(e, share);
  }
  team_wait(t);

  FOR_SHARES(t, share, w)
  FOR_CHUNKS(k, w, share) if (w->chunks.boundary_last[k]) chunk_correct(e, &w->threads[share], k);
  if (first) {
    assert(!w->chunks.count || w->chunks.predicted[0] == e->state->step + 1);
    gather_prescribed(e);
  }
  team_wait(t);
  if (w->clumps.count) {
    clumps_correct(e, t);
    team_wait(t);
  }
  if (first) {
    motion_work(e);
    fields_work(e);
    w->status = cell_work(e, false);
    if (w->status == SD_OK && contacts_any_event(w)) w->status = contacts_events(e, w->messages);
    /* Store the forces now, since no further step will follow. This is impossible if later chunks
     * reuse rows of earlier ones: the force sums are then overwritten. */
    if (w->status != SD_OK && !w->chunks.shares) w->kernels->gather(e, 0, e->state->n_free);
    e->state->step++;
    if (validity_due(e->state->step) && w->status == SD_OK) validity_check_step(e);
  }
}
