/* sweep.c: see sweep.h. */
#include "physics/step/sweep.h"

#include "physics/neighbours/chunks.h"
#include "physics/system/kernels.h"
#include "physics/contact/pairs.h"
#include "physics/neighbours/rows.h"

void sweep_predict(engine *e, size_t k) {
  chunks *c = &e->work.chunks;
  if (c->predicted[k] == e->state->step + 1) return;
  c->predicted[k] = e->state->step + 1;
  e->work.kernels->predict[e->model->integrator](e, c->begin[k], c->begin[k + 1]);
}

/* What its rows show is named by `mark`. */
static void seat(engine *e, size_t k, int64_t mark) {
  chunks *c = &e->work.chunks;
  if (c->seated[k] == mark) return;
  c->seated[k] = mark;
  e->work.kernels->seat(e, c->begin[k], c->begin[k + 1]);
}

/* The predictor does it by the way. */
void sweep_seat(engine *e, size_t k) {
  chunks *c = &e->work.chunks;
  const int64_t next = e->state->step + 1;
  if (c->predicted[k] == next) {
    seat(e, k, next);
  } else {
    sweep_predict(e, k);
    c->seated[k] = next;
  }
}

void sweep_correct(engine *e, thread_work *mine, size_t k) {
  const chunks *c = &e->work.chunks;
  e->work.kernels->correct[e->model->integrator](e, mine, c->begin[k], c->begin[k + 1]);
}

static void pass_pairs(engine *e, thread_work *mine, size_t k, int pass) {
  const work *w = &e->work;
  const chunks *c = &w->chunks;
  w->kernels->pairs(e, mine, c->pair[k], c->pair[k + 1], pass);
  if (c->piece[k] < c->piece[k + 1]) w->kernels->pairs(e, mine, c->piece[k], c->piece[k + 1], pass);
}

/* Chunks n that the pairs of k see, of share t. */
#define FOR_NEEDS(n, c, k, t)                                                                                \
  for (size_t at = (c)->need_start[k], n; at < (c)->need_start[(k) + 1]; at++)                               \
    if ((n = (c)->need[at]) >= (c)->share[t] && n < (c)->share[(t) + 1])

/* History is written once a step, from the corrected coordinates: of the chunks for which those of k were missing. */
static void commit(engine *e, thread_work *mine, size_t k) {
  const chunks *c = &e->work.chunks;
  for (size_t n = c->commit_start[k]; n < c->commit_start[k + 1]; n++)
    pass_pairs(e, mine, c->commit[n], PASS_COMMIT);
}

/* With velocity Verlet trial positions are final, so lambda* is committed with the forces. */
void sweep_share(engine *e, int t) {
  work *w = &e->work;
  const chunks *c = &w->chunks;
  thread_work *mine = &w->threads[t];
  const bool one_pass = e->model->integrator == SD_VERLET;
  for (size_t k = c->share[t]; k < c->share[t + 1]; k++) {
    FOR_NEEDS(n, c, k, t) sweep_seat(e, n);
    pass_pairs(e, mine, k, one_pass ? PASS_FORCE | PASS_COMMIT : PASS_FORCE);
    if (c->late[k]) continue;
    sweep_correct(e, mine, k);
    if (!one_pass && !w->commit_last) commit(e, mine, k);
  }
}

/* Where all have waited, shared rows show later chunks. The others show the corrected coordinates already. */
void sweep_commit_last(engine *e, int t) {
  const work *w = &e->work;
  const chunks *c = &w->chunks;
  for (size_t k = c->share[t]; k < c->share[t + 1]; k++) {
    if (!w->commit_last && c->last[k] < c->count) continue;
    if (w->commit_last && c->shares) {
      FOR_NEEDS(n, c, k, t) {
        if (!c->kept[n]) seat(e, n, ~(e->state->step + 1));
      }
    }
    pass_pairs(e, &e->work.threads[t], k, PASS_COMMIT);
  }
}

void sweep_forces(engine *e) {
  work *w = &e->work;
  const chunks *c = &w->chunks;
  const size_t n_free = e->state->n_free, n_bodies = e->state->n_bodies;
  for (size_t k = 0; k < c->count; k++) c->seated[k] = INT64_MIN;
  pairs_clear_single(e);
  w->kernels->seat(e, n_free, n_bodies);
  for (int t = 0; t < w->n_threads; t++)
    for (size_t k = c->share[t]; k < c->share[t + 1]; k++) {
      for (size_t n = c->need_start[k]; n < c->need_start[k + 1]; n++) seat(e, c->need[n], INT64_MAX);
      pass_pairs(e, &w->threads[0], k, PASS_FORCE | PASS_COMMIT);
      if (!c->late[k]) w->kernels->gather(e, c->begin[k], c->begin[k + 1]);
    }
  for (size_t k = 0; k < c->count; k++)
    if (c->late[k]) w->kernels->gather(e, c->begin[k], c->begin[k + 1]);
  w->kernels->gather(e, n_free, n_bodies);
}
