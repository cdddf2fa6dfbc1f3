/* chunk_pass.c: prediction, contacts and correction chunk by chunk; implements chunk_... and
 * chunks_... of step.h. */
#include "physics/step/step.h"

#include <assert.h>

#include "model/model.h"
#include "physics/contact/evaluate.h"
#include "physics/contact/pairs.h"
#include "physics/neighbours/chunks.h"
#include "physics/neighbours/neighbours.h"
#include "physics/system/bodies.h"
#include "physics/system/halo.h"
#include "physics/system/kernels.h"

void chunk_predict(engine *e, size_t k) {
  chunks *c = &e->work.chunks;
  if (c->predicted[k] == e->state->step + 1) return;
  /* a chunk is predicted at most once per step */
  assert(k < c->count && c->predicted[k] <= e->state->step);
  c->predicted[k] = e->state->step + 1;
  e->work.kernels->predict[e->model->integrator](e, c->begin[k], c->begin[k + 1]);
}

/* Writes the rows of packed bodies (the data that pairs read) of chunk k, unless `mark` shows that
 * this was done before: packed[k] == mark. */
static void pack(engine *e, size_t k, int64_t mark) {
  chunks *c = &e->work.chunks;
  if (c->packed[k] == mark) return;
  c->packed[k] = mark;
  e->work.kernels->pack(e, c->begin[k], c->begin[k + 1]);
}

/* chunk_predict writes the rows of packed bodies, too. So pack() is called only for a chunk that
 * was predicted earlier. */
void chunk_pack(engine *e, size_t k) {
  chunks *c = &e->work.chunks;
  const int64_t next = e->state->step + 1;
  if (c->predicted[k] == next) {
    pack(e, k, next);
  } else {
    chunk_predict(e, k);
    c->packed[k] = next;
  }
}

void chunk_correct(engine *e, thread_work *mine, size_t k) {
  const chunks *c = &e->work.chunks;
  assert(k < c->count && c->predicted[k] == e->state->step + 1);
  e->work.kernels->correct[e->model->integrator](e, mine, c->begin[k], c->begin[k + 1]);
}

static void sum_pairs(engine *e, size_t begin, size_t end) {
  for (size_t k = begin; k < end; k++)
    if (pairs_closed(&e->work.pairs, k)) contact_sum(e, k);
}

static void sum_chunk(engine *e, size_t k) {
  const chunks *c = &e->work.chunks;
  sum_pairs(e, c->pair[k], c->pair[k + 1]);
  sum_pairs(e, c->segment[k], c->segment[k + 1]);
}

void chunk_round_pairs(engine *e, thread_work *mine, size_t k) {
  const chunks *c = &e->work.chunks;
  e->work.kernels->pairs(e, mine, c->pair[k], c->pair[k + 1]);
}

void chunk_segments(engine *e, thread_work *mine, size_t k) {
  const chunks *c = &e->work.chunks;
  if (c->segment[k] < c->segment[k + 1])
    e->work.kernels->pairs(e, mine, c->segment[k], c->segment[k + 1]);
}

/* Evaluates the contacts of chunk k, once per step: forces, lambda_ref, losses. */
static void evaluate(engine *e, thread_work *mine, size_t k) {
  chunk_round_pairs(e, mine, k);
  chunk_segments(e, mine, k);
}

void chunks_step(engine *e, int t) {
  work *w = &e->work;
  const chunks *c = &w->chunks;
  assert(t < c->n_threads && c->share[t] <= c->share[t + 1] && c->share[t + 1] <= c->count);
  thread_work *mine = &w->threads[t];
  for (size_t k = c->share[t]; k < c->share[t + 1]; k++) {
    for (size_t at = c->need_start[k]; at < c->need_start[k + 1]; at++) {
      const size_t n = c->need[at];
      if (n >= c->share[t] && n < c->share[t + 1]) chunk_pack(e, n);
      /* the rows of chunk n were written just now or, if it is marked boundary_first, before by
       * another thread */
      assert(c->packed[n] == e->state->step + 1);
    }
    evaluate(e, mine, k);
    if (!c->boundary_last[k]) chunk_correct(e, mine, k);
    if (e->halo && t == 0) halo_progress(e->halo);
  }
}

void chunks_ghosts(engine *e, int t) {
  const work *w = &e->work;
  const pairs *p = &w->pairs;
  const size_t blocks = (p->first_segment - p->first_ghost) / PAIR_BLOCK, n = (size_t)w->n_threads;
  const size_t from = blocks * (size_t)t / n, to = blocks * ((size_t)t + 1) / n;
  w->kernels->pairs(e, &w->threads[t], p->first_ghost + PAIR_BLOCK * from,
                    p->first_ghost + PAIR_BLOCK * to);
}

/* Adds R omega to the packed bodies (work.packed) of ghosts. Passes with simple contact laws do not
 * write it, but contacts that begin with a ghost read it. */
static void pack_spins(engine *e) {
  const sd_state *s = e->state;
  for (size_t i = s->n_free; i < s->n_free + s->n_ghosts; i++)
    e->work.packed[PACKED_ROW * e->work.row[i] + PACKED_SPIN] = body_spin(s, i);
}

void chunks_forces(engine *e, chunks_kind kind) {
  work *w = &e->work;
  const chunks *c = &w->chunks;
  const size_t n_free = e->state->n_free, n_bodies = e->state->n_bodies;
  for (size_t k = 0; k < c->count; k++) c->packed[k] = INT64_MIN;
  pairs_clear_single(e);
  w->kernels->pack(e, n_free, n_bodies);
  pack_spins(e);
  for (int t = 0; t < w->n_threads; t++)
    for (size_t k = c->share[t]; k < c->share[t + 1]; k++) {
      for (size_t n = c->need_start[k]; n < c->need_start[k + 1]; n++)
        pack(e, c->need[n], INT64_MAX);
      if (kind == CHUNKS_SUM)
        sum_chunk(e, k);
      else
        evaluate(e, &w->threads[0], k);
      if (!c->boundary_last[k]) w->kernels->gather(e, c->begin[k], c->begin[k + 1]);
    }
  for (int t = 0; e->halo && kind == CHUNKS_EVALUATE && t < w->n_threads; t++) chunks_ghosts(e, t);
  if (kind == CHUNKS_SUM) sum_pairs(e, w->pairs.first_ghost, w->pairs.first_segment);
  for (size_t k = 0; k < c->count; k++)
    if (c->boundary_last[k]) w->kernels->gather(e, c->begin[k], c->begin[k + 1]);
  if (e->halo) halo_gather_prescribed(e);
  w->kernels->gather(e, n_free + e->state->n_ghosts, n_bodies);
}
