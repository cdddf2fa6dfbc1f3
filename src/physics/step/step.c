/* step.c: the step, one page.
 *
 * place prescribed bodies at t + dt -> force fields of the program -> (stale? rebuild neighbours, carrying contacts) -> chunk by chunk: predict the free
 * disks of its pairs, evaluate each contact once (force, lambda*, losses), correct -> chunks that wait for other threads
 * -> rare events.
 *
 * Every loop writes only its own indices; each wait makes what was written visible to the whole team.
 */
#include "physics/step/step.h"

#include <assert.h>

#include "physics/step/contacts.h"
#include "physics/step/engine.h"
#include "physics/system/fields.h"
#include "physics/system/kernels.h"
#include "physics/motion/motion.h"
#include "physics/neighbours/neighbours.h"
#include "physics/contact/pairs.h"
#include "physics/neighbours/rows.h"
#include "physics/neighbours/validity.h"
#include "physics/step/sweep.h"
#include "physics/contact/walls.h"

static bool any_stale(const work *w) {
  bool stale = false;
  for (int k = 0; k < w->n_threads; k++) stale |= w->threads[k].stale;
  return stale;
}

/* --- step -------------------------------------------------------------------------------------------- */

/* Shares are those of n_threads; a team may be smaller. */
#define FOR_SHARES(t, share, w) for (int share = (t)->rank; share < (w)->n_threads; share += (t)->size)
#define FOR_CHUNKS(k, w, share)                                                                              \
  for (size_t k = (w)->chunks.share[share]; k < (w)->chunks.share[(share) + 1]; k++)

static void predict_all(engine *e, const team *t) {
  FOR_SHARES(t, share, &e->work) FOR_CHUNKS(k, &e->work, share) sweep_predict(e, k);
}

/* Marks every chunk as predicted, or none. New lists forget it. */
static void note_predicted(engine *e, bool all) {
  chunks *c = &e->work.chunks;
  for (size_t k = 0; k < c->count; k++) {
    c->predicted[k] = e->state->step + all;
    c->packed[k] = INT64_MIN;
  }
}

/* Lists for the coming step, on one thread. If a disk outruns the list within one step, rebuild at the predicted positions. */
static sd_status renew_lists(engine *e) {
  work *w = &e->work;
  const team alone = {0, 1};
  neighbours_tune(e);
  sd_status status = neighbours_build(e, w->messages);
  note_predicted(e, w->predict_all);
  if (status != SD_OK || w->predict_all || !w->kernels->stale(e, 0, e->state->n_free, true)) return status;
  predict_all(e, &alone);
  status = neighbours_build(e, w->messages);
  note_predicted(e, true);
  return status;
}

void step_begin(engine *e, int64_t n) {
  const sd_state *s = e->state;
  work *w = &e->work;
  assert(n > 0 && s->phase >= 0 && (size_t)s->phase < e->model->n_phases);
  w->kernels->pack(e, s->n_free, s->n_bodies);
  w->show_from = s->step + n;
  w->predict_all = e->model->phases[s->phase].relax || motion_drives_free(e) || e->fields;
  for (int t = 0; t < w->n_threads; t++) w->threads[t].stale = false;
  w->threads[0].stale = w->kernels->stale(e, 0, s->n_free, true);
  note_predicted(e, false);
}

/* Where velocities change between steps, or predictions of single coordinates are overwritten: predicts all disks first,
 * and checks the lists. */
static void predict_and_check(engine *e, const team *t) {
  work *w = &e->work;
  predict_all(e, t);
  FOR_SHARES(t, share, w) {
    const chunks *c = &w->chunks;
    const size_t begin = c->begin[c->share[share]], end = c->begin[c->share[share + 1]];
    w->threads[share].stale = begin < end && w->kernels->stale(e, begin, end, false);
  }
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
    if (motion_moves_walls(e)) walls_pose(e);
    w->stale = any_stale(w);
    pairs_clear_single(e);
  }
  team_wait(t);
  if (w->stale) {
    if (first) w->status = renew_lists(e);
    team_wait(t);
    if (w->status != SD_OK) return;
  }

  if (w->chunks.any_boundary_first) {
    FOR_SHARES(t, share, w) FOR_CHUNKS(k, w, share) if (w->chunks.boundary_first[k]) sweep_pack(e, k);
    team_wait(t);
  }
  FOR_SHARES(t, share, w) sweep_share(e, share);
  team_wait(t);

  FOR_SHARES(t, share, w)
  FOR_CHUNKS(k, w, share) if (w->chunks.boundary_last[k]) sweep_correct(e, &w->threads[share], k);
  if (first) {
    assert(!w->chunks.count || w->chunks.predicted[0] == e->state->step + 1);
    w->kernels->gather(e, e->state->n_free, e->state->n_bodies);
  }
  team_wait(t);
  if (first) {
    motion_work(e);
    fields_work(e);
    if (contacts_any_event(w)) w->status = contacts_events(e, w->messages);
    /* no other step will show the forces; where chunks share rows they are gone */
    if (w->status != SD_OK && !w->chunks.shares) w->kernels->gather(e, 0, e->state->n_free);
    e->state->step++;
    if (validity_due(e->state->step) && w->status == SD_OK) validity_check_step(e);
  }
}
