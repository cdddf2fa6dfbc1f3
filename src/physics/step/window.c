/* window.c: several steps at once, chunk by chunk; implements window.h.
 *
 * A chunk can take its next step as soon as the chunks that its pairs read, and those whose pairs
 * read it, have taken the step before. So the steps go over the chunks one behind the other, d =
 * CHUNKS_APART (neighbours/chunks.h) chunks apart: all that they need is in the cache, and memory
 * is read and written once in a window. Threads that look for work take the next chunk of the last
 * step that can go on. Events of chunk k are handled when chunk k + reach has taken the same step,
 * so that both disks are corrected, and before chunk k - reach takes the next one.
 *
 * Each step has its own copy of the engine, with the number of the step, rows of packed bodies and
 * of force sums. Lists stay as they are in a window, which changes no bit. If a disk moves too far
 * for them before the last step, if a contact overlaps too deeply or a body is too fast, the window
 * is undone: each chunk is copied before its first step.
 */
#include "physics/step/window.h"

#include <assert.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "model/model.h"
#include "physics/contact/pairs.h"
#include "physics/contact/walls.h"
#include "physics/motion/motion.h"
#include "physics/neighbours/chunks.h"
#include "physics/neighbours/neighbours.h"
#include "physics/neighbours/validity.h"
#include "physics/step/contacts.h"
#include "physics/step/step.h"
#include "physics/step/window_check.h"
#include "physics/system/bodies.h"
#include "physics/system/kernels.h"
#include "physics/system/list.h"

/* Largest number of wall segments in lists, and of prescribed bodies: they are placed anew for each
 * chunk. */
enum { MOST_PIECES = 32 };

/* Event of a chunk in a step: of a contact, or (wraps) of a disk. */
typedef struct window_event {
  event event;
  size_t chunk;
  bool wraps;
} window_event;

/* One step of a window. */
typedef struct window_step {
  engine e;       /* the engine at this step, with the state and the rows below */
  sd_state state; /* the columns of the engine's state, and the number of this step */
  double *packed, *sums;
  size_t taken;        /* number of chunks that have taken this step */
  bool busy;           /* true while a thread takes it with the next chunk */
  bool stale;          /* as in thread_work, by the chunks so far */
  window_event *event; /* events that wait for other chunks; the first `handled` are done */
  size_t n_events, handled, capacity;
} window_step;

/* The steps that are under way. */
struct window_wave {
  pthread_mutex_t turn;  /* held to read and write members `taken` and `busy` of the steps */
  pthread_cond_t moved;  /* one of them has changed */
  atomic_uint moves;     /* number of these changes */
  int asleep;            /* number of threads that wait for `moved` */
  atomic_llong fits;     /* number of steps for which the lists will do */
  pthread_mutex_t walls; /* held while prescribed bodies are posed for one chunk and step */
  double *packed, *sums; /* of all steps */
  window_step step[];
};

/* --- copies ----------------------------------------------------------------------------------- */

/* Columns of a disk that the integrators change, from columns. */
enum { COPIED = 6 };
static double *copied(const columns *k, int c) {
  double *const of[COPIED] = {k->q, k->v, k->q2, k->q3, k->q4, k->q5};
  return of[c];
}

static size_t copied_columns(const engine *e) {
  return e->model->integrator == SD_VERLET ? 3 : COPIED;
}

/* Copies the disks of chunk k to the window's memory, or (back) from there. */
static void copy_disks(engine *e, size_t k, bool back) {
  const work *w = &e->work;
  const size_t begin = w->chunks.begin[k], n = w->chunks.begin[k + 1] - begin,
               each = copied_columns(e);
  double *at = w->window.disks + SD_COORDINATES * each * begin;
  for (int c = 0; c < SD_COORDINATES; c++)
    for (size_t j = 0; j < each; j++, at += n) {
      double *column = copied(&w->columns[c], (int)j) + begin;
      memcpy(back ? column : at, back ? at : column, n * sizeof *at);
    }
}

/* Copies the contact records of the pairs of chunk k, likewise. */
static void copy_pairs(engine *e, size_t k, bool back) {
  work *w = &e->work;
  pairs *p = &w->pairs;
  window *v = &w->window;
  const chunks *c = &w->chunks;
  /* only the paper's variant changes the last two columns */
  const size_t bytes = w->conservative
                           ? offsetof(pair_block, turned) - offsetof(pair_block, lambda_ref)
                           : sizeof p->block->record;
  for (size_t b = c->pair[k] / PAIR_BLOCK; b < c->pair[k + 1] / PAIR_BLOCK; b++) {
    double *record = p->block[b].record[0];
    memcpy(back ? record : v->blocks[b].record[0], back ? v->blocks[b].record[0] : record, bytes);
    *(back ? &p->flags[b] : &v->flags[b]) = *(back ? &v->flags[b] : &p->flags[b]);
    if (p->more) *(back ? &p->more[b] : &v->more[b]) = *(back ? &v->more[b] : &p->more[b]);
  }
  for (size_t at = c->segment[k]; at < c->segment[k + 1]; at++) {
    window_piece *one = &v->pieces[at - p->first_segment];
    if (p->a[at] < 0) continue;
    if (back) {
      pairs_set_record(p, at, &one->record);
      p->flags[pairs_flags_at(p, at)] = one->flags;
      p->side[at] = one->side;
    } else {
      *one = (window_piece){pairs_record(p, at), p->side[at], p->flags[pairs_flags_at(p, at)]};
    }
  }
}

/* Columns of a disk that only events change: losses when a contact ends or, with a capillary
 * bridge, begins; the place when the disk is wrapped. Others are not read, since that costs as much
 * as the event. */
typedef enum rare_kind { RARE_LOSSES, RARE_BRIDGE, RARE_PLACE } rare_kind;
enum { RARE_MOST = 5 };
typedef struct window_rare {
  rare_kind kind;
  uint32_t slot;
  double value[RARE_MOST];
  int64_t openings;
  int32_t image_x, image_y;
} window_rare;

/* Sets of[] to the columns of this kind; returns their number. */
static size_t rare_columns(const engine *e, rare_kind kind, double *of[RARE_MOST]) {
  const sd_state *s = e->state;
  double *const losses[] = {s->past_viscous, s->past_friction, s->past_nonconservative_work,
                            s->loss_opening, s->past_rolling},
                *const bridge[] = {s->loss_bridge},
                *const place[] = {s->turn, e->work.x0, e->work.y0};
  double *const *from = kind == RARE_LOSSES ? losses : kind == RARE_BRIDGE ? bridge : place;
  const size_t n = kind == RARE_LOSSES ? (s->law_columns ? 5 : 4) : kind == RARE_BRIDGE ? 1 : 3;
  memcpy(of, from, n * sizeof *of);
  return n;
}

/* Copies the columns of this kind of disk i to the window's memory. */
static void keep_rare(window *v, const engine *e, rare_kind kind, uint32_t i) {
  const sd_state *s = e->state;
  if (i >= s->n_free) return;
  if (!list_room(&v->rare, v->n_rare, &v->rare_capacity, sizeof *v->rare)) {
    v->lost = true;
    return;
  }
  window_rare *r = &v->rare[v->n_rare++];
  double *of[RARE_MOST];
  const size_t n = rare_columns(e, kind, of);
  *r = (window_rare){.kind = kind, .slot = i};
  for (size_t k = 0; k < n; k++) r->value[k] = of[k][i];
  if (kind == RARE_LOSSES && s->n_means) r->openings = s->sum_openings[i];
  if (kind != RARE_PLACE) return;
  r->image_x = s->image_x[i];
  r->image_y = s->image_y[i];
}

static void restore_rare(engine *e, const window_rare *r) {
  sd_state *s = e->state;
  double *of[RARE_MOST];
  const size_t n = rare_columns(e, r->kind, of);
  for (size_t k = 0; k < n; k++) of[k][r->slot] = r->value[k];
  if (r->kind == RARE_LOSSES && s->n_means) s->sum_openings[r->slot] = r->openings;
  if (r->kind != RARE_PLACE) return;
  s->image_x[r->slot] = r->image_x;
  s->image_y[r->slot] = r->image_y;
}

/* Copies what the event of a contact is about to change. */
static void keep_of_pair(window *v, const engine *e, const event *one) {
  const pairs *p = &e->work.pairs;
  const size_t k = one->index;
  const bool ends = !pairs_closed(p, k);
  if (!ends && (one->was_closed || one->dropped == 0.0)) return;
  keep_rare(v, e, ends ? RARE_LOSSES : RARE_BRIDGE, (uint32_t)p->a[k]);
  keep_rare(v, e, ends ? RARE_LOSSES : RARE_BRIDGE, (uint32_t)p->b[k]);
}

/* --- prescribed bodies ------------------------------------------------------------------------ */

/* Places the prescribed bodies for the step after state->step. Unlike motion_pose it can go back
 * and forth. */
static void place_prescribed(engine *e) {
  size_t n;
  const prescribed *p = motion_prescribed(e, &n);
  const int64_t k = motion_index(e);
  for (size_t j = 0; j < n; j++) {
    *p[j].at = p[j].value[k];
    *p[j].speed = p[j].velocity[k];
    body_pack(e, p[j].slot);
  }
}

/* Copies coordinates, velocities and what motion_work needs of the prescribed bodies to the
 * window's memory, or back. */
static void copy_prescribed(engine *e, bool back) {
  size_t n;
  prescribed *p = motion_prescribed(e, &n);
  for (size_t j = 0; j < n; j++, p++) {
    double *const of[WINDOW_KEPT] = {p->at,
                                     p->speed,
                                     &p->last,
                                     &p->moved,
                                     &p->force_before,
                                     &p->speed_before,
                                     (double *)p->force};
    double *kept = e->work.window.prescribed[j];
    for (size_t i = 0; i < WINDOW_KEPT; i++)
      *(back ? of[i] : &kept[i]) = *(back ? &kept[i] : of[i]);
  }
}

/* Adds the forces of chunk k on prescribed bodies to their sums of step s, in the order of the
 * pairs, and clears the rows of single contacts for the next window. */
static void add_prescribed(engine *e, size_t k, int64_t s) {
  const window *v = &e->work.window;
  const sums *m = &v->wave->step[s].e.work.sums;
  const incidence *n = &e->work.incidence;
  const chunks *c = &e->work.chunks;
  for (size_t j = 0; j < v->n_fixed; j++) {
    const size_t body = v->fixed + j, first = n->start[m->listed[body]],
                 count = m->single[body + 1] - m->single[body];
    size_t *at = &v->reached[(size_t)s * v->n_fixed + j];
    double *sum = v->sums + SUM_ROW * ((size_t)s * v->n_fixed + j);
    for (; *at < count; ++*at) {
      const size_t pair = n->entry[first + *at] / 2;
      const size_t *end = pairs_is_segment(&e->work.pairs, pair) ? c->segment : c->pair;
      double *row = m->row + SUM_ROW * (m->single[body] + *at);
      if (pair >= end[k + 1]) break;
      for (size_t i = 0; i < SUM_ROW; i++) {
        sum[i] += row[i];
        row[i] = 0.0;
      }
    }
  }
}

/* Moves the prescribed bodies through the steps of the window, and adds the work of each step, as
 * the steps do one by one. */
static void follow_prescribed(engine *e, int64_t n) {
  const window *v = &e->work.window;
  sums *m = &e->work.sums;
  const int64_t from = e->state->step;
  const size_t listed = m->n_listed, single = e->work.chunks.rows;
  copy_prescribed(e, true);
  for (int64_t s = 0; s < n; s++) {
    e->state->step = from + s;
    motion_pose(e, &e->work.threads[0]);
    for (size_t j = 0; j < v->n_fixed && s + 1 < n; j++)
      memcpy(m->row + SUM_ROW * (size_t)e->work.row[m->listed[v->fixed + j]],
             v->sums + SUM_ROW * ((size_t)s * v->n_fixed + j), SUM_ROW * sizeof *m->row);
    if (s + 1 == n) /* the rows of contacts are those of the last step */
      memcpy(m->row + SUM_ROW * single, v->wave->step[s].sums + SUM_ROW * single,
             SUM_ROW * (m->end - single) * sizeof *m->row);
    m->n_listed = s + 1 < n ? 0 : listed;
    e->work.kernels->gather(e, e->state->n_free, e->state->n_bodies);
    motion_work(e);
  }
  if (motion_moves(e) & MOVES_WALLS) walls_pose_listed(e);
  e->state->step = from;
}

/* --- events ----------------------------------------------------------------------------------- */

static bool queue_add(window_step *at, const event_list *list, size_t chunk, bool wraps) {
  for (size_t n = 0; n < list->count; n++) {
    if (!list_room(&at->event, at->n_events, &at->capacity, sizeof *at->event)) return false;
    at->event[at->n_events++] = (window_event){list->item[n], chunk, wraps};
  }
  return true;
}

/* Moves what a thread has noted while it took a step with chunk k to this step. Returns false if
 * only single steps can handle it. */
static bool take_notes(window_step *at, thread_work *mine, size_t k) {
  bool well = !mine->events.failed && !mine->returns.failed && !mine->fast;
  at->stale |= mine->stale;
  mine->stale = false;
  contacts_sort_events(&at->e, mine);
  well = queue_add(at, &mine->events, k, false) && queue_add(at, &mine->returns, k, true) && well;
  mine->events.count = mine->returns.count = 0;
  return well;
}

static bool handle_event(window *v, engine *own, const window_event *one) {
  if (one->wraps) {
    keep_rare(v, own, RARE_PLACE, one->event.index);
    contacts_wrap(own, one->event.index);
    return true;
  }
  keep_of_pair(v, own, &one->event);
  return contacts_pair_event(own, &one->event, v->messages) == SD_OK;
}

/* Places the prescribed bodies for the step of this engine, and keeps other threads from placing
 * them for another one, until unlock_prescribed. */
static void lock_prescribed(window_wave *wave, engine *own) {
  pthread_mutex_lock(&wave->walls);
  place_prescribed(own);
  if (motion_moves(own) & MOVES_WALLS) walls_pose_listed(own);
}
static void unlock_prescribed(window_wave *wave) { pthread_mutex_unlock(&wave->walls); }

/* Handles the events of the chunks before `end` in a step of the window: first those of contacts,
 * then disks whose angle or position is wrapped. Returns false if only single steps can do so. */
static bool handle_events(window *v, window_step *at, size_t end) {
  if (at->handled == at->n_events || at->event[at->handled].chunk >= end) return true;
  bool well = true;
  lock_prescribed(v->wave, &at->e);
  for (; well && at->handled < at->n_events && at->event[at->handled].chunk < end; at->handled++)
    well = handle_event(v, &at->e, &at->event[at->handled]);
  well = well && !v->lost;
  unlock_prescribed(v->wave);
  return well;
}

/* --- the wave --------------------------------------------------------------------------------- */

/* Copies what the first step will change when it is taken with chunk k. */
static void keep_chunk(engine *e, size_t k) {
  const chunks *c = &e->work.chunks;
  for (size_t n = c->need_start[k]; n < c->need_start[k + 1]; n++)
    if (c->predicted[c->need[n]] != e->state->step + 1) copy_disks(e, c->need[n], false);
  copy_pairs(e, k, false);
}

static void take_segments(window_wave *wave, engine *own, thread_work *mine, size_t k) {
  const chunks *c = &own->work.chunks;
  if (c->segment[k] == c->segment[k + 1]) return;
  const bool moved = motion_moves(own) & (MOVES_WALLS | MOVES_SURFACES);
  if (moved) lock_prescribed(wave, own);
  chunk_segments(own, mine, k);
  if (moved) unlock_prescribed(wave);
}

/* Takes step s of the window with chunk k. Returns false if something came up that only single
 * steps can handle. last: it is the last step of the window. */
static bool take_chunk(engine *e, thread_work *mine, size_t k, int64_t s, bool last) {
  window *v = &e->work.window;
  window_step *at = &v->wave->step[s];
  engine *own = &at->e;
  const chunks *c = &own->work.chunks;
  if (s == 0) keep_chunk(e, k);
  for (size_t n = c->need_start[k]; n < c->need_start[k + 1]; n++) chunk_pack(own, c->need[n]);
  chunk_round_pairs(own, mine, k);
  take_segments(v->wave, own, mine, k);
  chunk_correct(own, mine, k);
  sums_clear_listed(own, c->begin[k], c->begin[k + 1]);
  if (!last && v->n_fixed) add_prescribed(e, k, s);
  if (!take_notes(at, mine, k) || (at->stale && !last)) return false;
  const size_t next = k + 1;
  return handle_events(v, at, next == c->count ? next : next > c->reach ? next - c->reach : 0);
}

/* Returns the last of n steps that can go on now; n: none can; -1: all are done. */
static int64_t step_to_take(const engine *e, int64_t n) {
  const chunks *c = &e->work.chunks;
  const window_step *step = e->work.window.wave->step;
  if (e->work.window.failed || step[n - 1].taken == c->count) return -1;
  for (int64_t s = n - 1; s >= 0; s--) {
    if (step[s].busy || step[s].taken == c->count) continue;
    const size_t before = s > 0 ? step[s - 1].taken : c->count;
    if (before == c->count || before >= step[s].taken + CHUNKS_APART(c)) return s;
  }
  return n;
}

/* Waits for a change of the steps, first awake for some microseconds. The caller holds wave->turn,
 * before and afterwards. */
static void wait_for_move(window_wave *wave) {
  enum { LOOKS = 2000 };
  const unsigned moves = atomic_load(&wave->moves);
  pthread_mutex_unlock(&wave->turn);
  for (int k = 0; k < LOOKS && atomic_load(&wave->moves) == moves; k++) team_pause();
  pthread_mutex_lock(&wave->turn);
  if (atomic_load(&wave->moves) != moves) return;
  wave->asleep++;
  pthread_cond_wait(&wave->moved, &wave->turn);
  wave->asleep--;
}

/* Takes steps with chunks until none is left; every thread of the team does so. */
static void take_chunks(engine *e, const team *t, int64_t n) {
  window *v = &e->work.window;
  window_wave *wave = v->wave;
  pthread_mutex_lock(&wave->turn);
  for (int64_t s; (s = step_to_take(e, n)) >= 0;) {
    if (s == n) {
      wait_for_move(wave);
      continue;
    }
    window_step *at = &wave->step[s];
    at->busy = true;
    pthread_mutex_unlock(&wave->turn);
    const bool well = take_chunk(e, &e->work.threads[t->rank], at->taken, s, s + 1 == n);
    pthread_mutex_lock(&wave->turn);
    at->busy = false;
    at->taken++;
    v->failed |= !well;
    atomic_fetch_add(&wave->moves, 1);
    if (wave->asleep) pthread_cond_broadcast(&wave->moved);
  }
  pthread_mutex_unlock(&wave->turn);
}

/* Makes the engines of the steps. */
static void begin(engine *e, int64_t n) {
  work *w = &e->work;
  window *v = &w->window;
  const size_t single = w->chunks.rows, bodies = rows_of_bodies(e);
  assert(n > 1 && n <= v->steps && v->n_rare == 0);
  memset(v->sums, 0, (size_t)n * v->n_fixed * SUM_ROW * sizeof *v->sums);
  memset(v->reached, 0, (size_t)n * v->n_fixed * sizeof *v->reached);
  v->failed = v->lost = false;
  copy_prescribed(e, false);
  for (int64_t s = 0; s < n; s++) {
    window_step *at = &v->wave->step[s];
    at->n_events = at->handled = at->taken = 0;
    at->stale = at->busy = false;
    at->state = *e->state;
    at->state.step += s;
    at->e = *e;
    at->e.state = &at->state;
    at->e.work.packed = at->packed;
    at->e.work.sums.row = at->sums;
    memcpy(at->packed + PACKED_ROW * single, w->packed + PACKED_ROW * single,
           PACKED_ROW * (bodies - single) * sizeof *at->packed);
    memset(at->sums + SUM_ROW * single, 0, SUM_ROW * (w->sums.end - single) * sizeof *at->sums);
    place_prescribed(&at->e);
  }
}

/* Undoes the steps of the window. */
static void undo(engine *e) {
  work *w = &e->work;
  window *v = &w->window;
  chunks *c = &w->chunks;
  for (size_t k = 0; k < c->count; k++) {
    if (k < v->wave->step[0].taken) copy_pairs(e, k, true);
    if (c->predicted[k] > e->state->step) copy_disks(e, k, true);
    c->predicted[k] = e->state->step;
    c->packed[k] = INT64_MIN;
  }
  while (v->n_rare > 0) restore_rare(e, &v->rare[--v->n_rare]);
  copy_prescribed(e, true);
  w->kernels->pack(e, e->state->n_free, e->state->n_bodies);
  if (motion_moves(e) & MOVES_WALLS) walls_pose_listed(e);
  for (int t = 0; t < w->n_threads; t++) {
    thread_work *mine = &w->threads[t];
    mine->stale = mine->fast = mine->events.failed = mine->returns.failed = false;
    mine->events.count = mine->returns.count = 0;
  }
}

static void wave_free(window_wave *wave, int64_t steps) {
  if (!wave) return;
  for (int64_t s = 0; s < steps; s++) free(wave->step[s].event);
  arena_free(wave->packed);
  arena_free(wave->sums);
  pthread_mutex_destroy(&wave->walls);
  pthread_mutex_destroy(&wave->turn);
  pthread_cond_destroy(&wave->moved);
  free(wave);
}

void window_free(window *v) {
  wave_free(v->wave, v->steps);
  free(v->disks);
  free(v->blocks);
  free(v->flags);
  free(v->more);
  free(v->pieces);
  free(v->sums);
  free(v->reached);
  free(v->rare);
  sd_messages_free(v->messages);
  *v = (window){
      .plain_until = v->plain_until, .taken = v->taken, .undone = v->undone, .trial = v->trial};
}

/* Makes a wave of n steps; NULL: no memory. */
static window_wave *wave_new(const engine *e, size_t n) {
  const size_t rows = PACKED_ROW * rows_of_bodies(e), sum_rows = SUM_ROW * e->work.sums.end;
  window_wave *wave = memory_new(1, sizeof *wave + n * sizeof *wave->step);
  pthread_mutex_init(&wave->walls, NULL);
  pthread_mutex_init(&wave->turn, NULL);
  pthread_cond_init(&wave->moved, NULL);
  wave->packed = arena_for(n * rows, sizeof *wave->packed);
  wave->sums = arena_for(n * sum_rows, sizeof *wave->sums);
  for (size_t s = 0; s < n && wave->packed && wave->sums; s++) {
    wave->step[s].packed = wave->packed + s * rows;
    wave->step[s].sums = wave->sums + s * sum_rows;
  }
  if (wave->packed && wave->sums) return wave;
  wave_free(wave, 0);
  return NULL;
}

/* Makes room for the copies of windows of up to n steps, with the present lists. */
static sd_status reserve(engine *e, int64_t n) {
  const work *w = &e->work;
  window *v = &e->work.window;
  const pairs *p = &w->pairs;
  const size_t disks = SD_COORDINATES * copied_columns(e) * e->state->n_free,
               blocks = p->first_segment / PAIR_BLOCK, n_fixed = v->n_fixed;
  if (v->builds == w->builds && v->steps >= n) return SD_OK;
  const size_t fixed = v->fixed;
  window_free(v);
  v->fixed = fixed;
  v->n_fixed = n_fixed;
  if (!memory_rows(7,
                   (memory_column[]){{&v->disks, disks, sizeof *v->disks},
                                     {&v->blocks, blocks, sizeof *v->blocks},
                                     {&v->flags, blocks, sizeof *v->flags},
                                     {&v->more, p->more ? blocks : 0, sizeof *v->more},
                                     {&v->pieces, p->count - p->first_segment, sizeof *v->pieces},
                                     {&v->sums, (size_t)n * n_fixed, SUM_ROW * sizeof *v->sums},
                                     {&v->reached, (size_t)n * n_fixed, sizeof *v->reached}}))
    return SD_ERROR_IO;
  v->wave = wave_new(e, (size_t)n);
  if (!v->wave) return SD_ERROR_IO;
  v->messages = sd_messages_new();
  v->builds = w->builds;
  v->steps = n;
  return SD_OK;
}

/* Ends the window: goes on from its last step, or undoes it. work_driven: before the window. */
static void end(engine *e, int64_t n, double work_driven) {
  work *w = &e->work;
  window *v = &w->window;
  if (!v->failed) follow_prescribed(e, n);
  v->failed |= w->threads[0].fast;
  if (v->failed) {
    e->state->work_driven = work_driven;
    undo(e);
    v->plain_until = e->state->step + n;
    v->undone++;
    return;
  }
  v->taken++;
  if (!VALIDITY_CHECKED) v->n_rare = 0; /* else check_window undoes the window */
  e->state->step += n;
  w->threads[0].stale = v->wave->step[n - 1].stale;
}

/* Undoes the window that has just ended and takes its n steps one by one; an error if they differ
 * in any bit. work_driven: that of the state before the window. */
static void check_window(engine *e, const team *t, int64_t n, double work_driven) {
  step_image *image = NULL;
  if (t->rank == 0) {
    image = step_image_new(e);
    e->state->step -= n;
    e->state->work_driven = work_driven;
    undo(e);
  }
  team_wait(t);
  for (int64_t s = 0; s < n && e->work.status == SD_OK; s++) {
    step_once(e, t);
    team_wait(t);
  }
  if (t->rank == 0) {
    if (e->work.status == SD_OK)
      e->work.status = step_image_compare(image, e, e->state->step - n, e->work.messages);
    step_image_free(image);
  }
  team_wait(t);
}

bool window_run(engine *e, const team *t, int64_t n) {
  const double work_driven = e->state->work_driven;
  if (t->rank == 0) begin(e, n);
  team_wait(t);
  take_chunks(e, t, n);
  team_wait(t);
  if (t->rank == 0) end(e, n, work_driven);
  team_wait(t);
  if (e->work.window.failed) return false;
  if (VALIDITY_CHECKED) check_window(e, t, n, work_driven);
  return true;
}

/* --- how many steps --------------------------------------------------------------------------- */

/* Laws and motions that windows take: those that tests/unit/test_windows.c compares with single
 * steps. With any other one, steps are taken one by one. */
enum {
  WINDOW_LAWS = LAW_NORMAL | LAW_PULLS | LAW_KINETIC | LAW_MINDLIN | LAW_DASHPOT | LAW_ROLLING |
                LAW_COHESION | LAW_BRIDGE | LAW_RADIUS | LAW_CRITICAL,
  WINDOW_MOVES = MOVES_WALLS | MOVES_SURFACES | MOVES_DISKS
};

/* True if windows take all features of this system, and nothing needs all disks after each step. */
static bool takes_features(engine *e) {
  const work *w = &e->work;
  size_t n;
  motion_prescribed(e, &n);
  return !(w->features & ~(unsigned)WINDOW_LAWS) && !(motion_moves(e) & ~(unsigned)WINDOW_MOVES) &&
         n <= WINDOW_PRESCRIBED && w->n_pieces <= MOST_PIECES && w->window.n_fixed <= MOST_PIECES &&
         !e->halo && !e->comm && !e->fields && !w->predict_all && !w->cell.on && !w->body_forces &&
         !w->clumps.count && !w->lanes && !e->state->n_slides;
}

/* True if the next steps can be taken with the present lists and the values computed ahead. */
static bool is_ready(engine *e) {
  for (int t = 0; t < e->work.n_threads; t++)
    if (e->work.threads[t].stale) return false;
  return motion_ahead(e);
}

/* Number of steps after which each way of taking them has been timed, and for which the cheaper one
 * then goes on. */
enum { TRIAL_STEPS = 48, CHOSEN_STEPS = 4096 };

/* True if windows are to be taken now. What they save in memory traffic and cost in copies depends
 * on the machine and on the packing, so both ways are timed; results have the same bits. The
 * environment variable SLIPDISK_WINDOWS decides instead if it is "always" or "never". */
static bool prefers_windows(const engine *e, window_trial *t) {
  const char *asked = getenv("SLIPDISK_WINDOWS");
  if (asked && strcmp(asked, "always") == 0) return true;
  if (asked && strcmp(asked, "never") == 0) return false;
  const int64_t done = e->state->step - t->step;
  const bool lists = t->builds != e->work.builds; /* new lists would be part of the time */
  if (done >= (t->way < 2 ? TRIAL_STEPS : CHOSEN_STEPS) || (lists && t->way < 2) || done < 0) {
    const double now = clock_seconds();
    if (t->way < 2 && !lists) t->cost[t->way] = (now - t->began) / (double)done;
    const int next = t->way < 2 && lists ? t->way : (t->way + 1) % 3;
    *t = (window_trial){next, now, e->state->step, e->work.builds, {t->cost[0], t->cost[1]}};
  }
  return t->way == 1 || (t->way == 2 && t->cost[1] < t->cost[0]);
}

/* Returns how many of the next `most` steps a window may have, whatever the lists are. */
static int64_t most_steps(engine *e, int64_t most) {
  const work *w = &e->work;
  window *v = &e->work.window;
  if (most < 2 || e->state->step < v->plain_until) return 1;
  v->fixed = sums_first_listed(&w->sums, e->state->n_free);
  v->n_fixed = w->sums.n_listed - v->fixed;
  if (!takes_features(e) || !is_ready(e) || !prefers_windows(e, &v->trial)) return 1;
  const int64_t computed = MOTION_BATCH - motion_index(e);
  int64_t n = most < w->chunks.window ? most : w->chunks.window;
  if (computed < n) n = computed;
  if (n < 2 || reserve(e, w->chunks.window) != SD_OK) return 1;
  atomic_store(&v->wave->fits, n);
  return n;
}

/* Returns for how many of the next n steps the lists will probably do for the disks in slots
 * [begin, end): disks go on as they move now, or half as fast again. */
static int64_t steps_of_list(const engine *e, size_t begin, size_t end, int64_t n) {
  while (n > 1 && begin < end && e->work.kernels->stale(e, begin, end, 1.5 * (double)n)) n /= 2;
  return n;
}

int64_t window_steps(engine *e, const team *t, int64_t most) {
  window *v = &e->work.window;
  if (e->work.chunks.window < 2) return 1;
  if (t->rank == 0) v->most = most_steps(e, most);
  team_wait(t);
  if (v->most < 2) return 1;
  size_t begin, end;
  team_share(t, e->state->n_free, &begin, &end);
  const long long mine = steps_of_list(e, begin, end, v->most);
  long long fits = atomic_load(&v->wave->fits);
  while (mine < fits && !atomic_compare_exchange_weak(&v->wave->fits, &fits, mine)) continue;
  team_wait(t);
  return atomic_load(&v->wave->fits);
}
