/* step.c: the step, one page.
 *
 * place prescribed bodies at t + dt -> (stale? rebuild neighbours, carrying contacts) -> chunk by chunk: predict the free
 * disks that its pairs see, one force per contact, correct, commit lambda* and book losses -> what waits for other threads
 * -> rare events.
 *
 * Every loop writes only its own indices; each wait makes what was written visible to the whole team.
 */
#include "physics/step.h"

#include "physics/chunks.h"
#include "physics/contacts.h"
#include "physics/engine.h"
#include "physics/kernels.h"
#include "physics/motion.h"
#include "physics/neighbours.h"
#include "physics/pairs.h"
#include "physics/walls.h"

static bool any_stale(const work *w) {
  bool stale = false;
  for (int k = 0; k < w->n_threads; k++) stale |= w->threads[k].stale;
  return stale;
}

/* --- chunks ------------------------------------------------------------------------------------------ */

/* Trial coordinates at t + dt, once a step. */
static void predict(engine *e, size_t k) {
  chunks *c = &e->work.chunks;
  if (c->predicted[k] == e->state->step + 1) return;
  c->predicted[k] = e->state->step + 1;
  e->work.kernels->predict[e->model->integrator](e, chunks_begin(c, k), chunks_end(c, k, e->state->n_free));
}

static void correct(engine *e, thread_work *mine, size_t k) {
  const chunks *c = &e->work.chunks;
  e->work.kernels->correct[e->model->integrator](e, mine, chunks_begin(c, k),
                                                 chunks_end(c, k, e->state->n_free));
}

static void pass_pairs(engine *e, thread_work *mine, size_t k, int pass) {
  const work *w = &e->work;
  const chunks *c = &w->chunks;
  w->kernels->pairs(e, mine, c->pair[k], c->pair[k + 1], pass);
  if (c->piece[k] < c->piece[k + 1]) w->kernels->pairs(e, mine, c->piece[k], c->piece[k + 1], pass);
}

/* History is written once a step, from the corrected coordinates: of the chunks for which those of k were missing. */
static void commit(engine *e, thread_work *mine, size_t k) {
  const chunks *c = &e->work.chunks;
  for (size_t n = c->commit_start[k]; n < c->commit_start[k + 1]; n++)
    pass_pairs(e, mine, c->commit[n], PASS_COMMIT);
}

/* Of the chunks of share t that have waited for all, or all of them. */
static void commit_last(engine *e, int t) {
  const chunks *c = &e->work.chunks;
  for (size_t k = c->share[t]; k < c->share[t + 1]; k++)
    if (e->work.commit_last || c->last[k] == c->count) pass_pairs(e, &e->work.threads[t], k, PASS_COMMIT);
}

/* The chunks of share t. With velocity Verlet trial positions are final, so lambda* is committed with the forces. */
static void advance_chunks(engine *e, int t) {
  work *w = &e->work;
  const chunks *c = &w->chunks;
  thread_work *mine = &w->threads[t];
  const bool one_pass = e->model->integrator == SD_VERLET;
  const size_t from = c->share[t], to = c->share[t + 1];
  for (size_t k = from; k < to; k++) {
    for (size_t n = c->need_start[k]; n < c->need_start[k + 1]; n++)
      if (c->need[n] >= from && c->need[n] < to) predict(e, c->need[n]);
    pass_pairs(e, mine, k, one_pass ? PASS_FORCE | PASS_COMMIT : PASS_FORCE);
    if (c->late[k]) continue;
    correct(e, mine, k);
    if (!one_pass && !w->commit_last) commit(e, mine, k);
  }
}

/* --- step -------------------------------------------------------------------------------------------- */

/* Shares are those of n_threads; a team may be smaller. */
#define FOR_SHARES(t, share, w) for (int share = (t)->rank; share < (w)->n_threads; share += (t)->size)
#define FOR_CHUNKS(k, w, share)                                                                              \
  for (size_t k = (w)->chunks.share[share]; k < (w)->chunks.share[(share) + 1]; k++)

static void predict_all(engine *e, const team *t) {
  FOR_SHARES(t, share, &e->work) FOR_CHUNKS(k, &e->work, share) predict(e, k);
}

/* Have all disks the trial coordinates of the coming step, or none? New lists forget it. */
static void note_predicted(engine *e, bool all) {
  chunks *c = &e->work.chunks;
  for (size_t k = 0; k < c->count; k++) c->predicted[k] = e->state->step + all;
}

/* Lists for the coming step, on one thread. What moves farther in one step than lists bear is taken where it arrives. */
static sd_status renew_lists(engine *e) {
  work *w = &e->work;
  const team alone = {0, 1};
  neighbours_tune(e);
  sd_status status = neighbours_build(e, w->messages);
  note_predicted(e, w->whole);
  if (status != SD_OK || w->whole || !w->kernels->stale(e, 0, e->state->n_free, true)) return status;
  predict_all(e, &alone);
  status = neighbours_build(e, w->messages);
  note_predicted(e, true);
  return status;
}

void step_begin(engine *e, int64_t n) {
  const sd_state *s = e->state;
  work *w = &e->work;
  w->kernels->seat(e, s->n_free, s->n_bodies);
  w->begun = s->step;
  w->show_from = s->step + n;
  w->whole = e->model->phases[s->phase].relax || motion_drives_free(e);
  w->commit_last = motion_corrects(e);
  for (int t = 0; t < w->n_threads; t++) w->threads[t].stale = false;
  w->threads[0].stale = w->kernels->stale(e, 0, s->n_free, true);
  note_predicted(e, false);
}

/* Where velocities change between steps, or predictions of single coordinates are overwritten: predicts all disks and
 * looks at them before anything else. */
static void look_at_all(engine *e, const team *t) {
  work *w = &e->work;
  predict_all(e, t);
  FOR_SHARES(t, share, w) {
    size_t begin = w->chunks.share[share] * w->chunks.size, end = w->chunks.share[share + 1] * w->chunks.size;
    if (end > e->state->n_free) end = e->state->n_free;
    w->threads[share].stale = begin < end && w->kernels->stale(e, begin, end, false);
  }
}

void step_once(engine *e, const team *t) {
  work *w = &e->work;
  const bool first = t->rank == 0, one_pass = e->model->integrator == SD_VERLET;
  if (w->whole) {
    look_at_all(e, t);
    team_wait(t);
  }
  if (first) {
    motion_place(e, &w->threads[0]);
    if (motion_moves_walls(e)) walls_place(e);
    w->stale = any_stale(w);
    /* should this be the end, the state has the forces of the last step */
    if (w->stale && !w->whole && e->state->step > w->begun) w->kernels->gather(e, 0, e->state->n_free);
    pairs_clear_single(e);
  }
  team_wait(t);
  if (w->stale) {
    if (first) w->status = renew_lists(e);
    team_wait(t);
    if (w->status != SD_OK) return;
  }

  if (w->chunks.any_early) {
    FOR_SHARES(t, share, w) FOR_CHUNKS(k, w, share) if (w->chunks.early[k]) predict(e, k);
    team_wait(t);
  }
  FOR_SHARES(t, share, w) advance_chunks(e, share);
  team_wait(t);

  FOR_SHARES(t, share, w) FOR_CHUNKS(k, w, share) if (w->chunks.late[k]) correct(e, &w->threads[share], k);
  if (first) w->kernels->gather(e, e->state->n_free, e->state->n_bodies);
  team_wait(t);
  if (first) motion_work(e);
  if (!one_pass) {
    team_wait(t);
    FOR_SHARES(t, share, w) commit_last(e, share);
    team_wait(t);
  }
  if (first) {
    if (contacts_any_event(w)) w->status = contacts_events(e, w->messages);
    if (w->status != SD_OK)
      w->kernels->gather(e, 0, e->state->n_free); /* no other step will show the forces */
    e->state->step++;
  }
}
