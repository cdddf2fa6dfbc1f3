/* window.c: several steps at once, chunk by chunk; implements window.h.
 *
 * A chunk can take its next step as soon as the chunks that its pairs read, and those whose pairs
 * read it, have taken the step before. So the chunks are passed in a wave: at place m, chunk m
 * takes the first step of the window, chunk m - d the second, chunk m - 2 d the third. All that
 * these steps need is in the cache, and memory is read and written once in a window. d is twice the
 * reach, the largest distance of chunks with a common pair: events of chunk k are handled when
 * chunk k + reach has taken the same step, so that both disks are corrected, and before chunk
 * k - reach takes the next one.
 *
 * Lists stay as they are in a window, which changes no bit. If a disk moves too far for them before
 * the last step, if a contact overlaps too deeply or a body is too fast, the window is undone: each
 * chunk is copied before its first step.
 */
#include "physics/step/window.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "physics/contact/pairs.h"
#include "physics/contact/walls.h"
#include "physics/motion/motion.h"
#include "physics/neighbours/chunks.h"
#include "physics/neighbours/neighbours.h"
#include "physics/neighbours/validity.h"
#include "physics/step/contacts.h"
#include "physics/step/step.h"
#include "physics/system/bodies.h"
#include "physics/system/kernels.h"
#include "physics/system/list.h"

/* Largest number of wall segments in lists, and of prescribed bodies: they are placed anew for each
 * chunk. */
enum { MOST_PIECES = 32 };

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
static void keep_rare(engine *e, rare_kind kind, uint32_t i) {
  const sd_state *s = e->state;
  window *v = &e->work.window;
  if (i >= s->n_free) return;
  if (!list_room(&v->rare, v->n_rare, &v->rare_capacity, sizeof *v->rare)) {
    v->failed = true;
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
static void keep_of_pair(engine *e, const event *v) {
  const pairs *p = &e->work.pairs;
  const size_t k = v->index;
  const bool ends = !pairs_closed(p, k);
  if (!ends && (v->was_closed || v->dropped == 0.0)) return;
  keep_rare(e, ends ? RARE_LOSSES : RARE_BRIDGE, (uint32_t)p->a[k]);
  keep_rare(e, ends ? RARE_LOSSES : RARE_BRIDGE, (uint32_t)p->b[k]);
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
  if (motion_moves_walls(e)) walls_pose_listed(e);
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

/* Adds the forces of chunk k on prescribed bodies to their sums of this step, in the order of the
 * pairs, and clears the rows of single contacts for the next step. */
static void add_prescribed(engine *e, size_t k, int64_t s) {
  const work *w = &e->work;
  const sums *m = &w->sums;
  const incidence *n = &w->incidence;
  const chunks *c = &w->chunks;
  for (size_t j = 0; j < m->n_listed; j++) {
    const size_t first = n->start[m->listed[j]];
    size_t *at = &w->window.reached[(size_t)s * m->n_listed + j];
    double *sum = w->window.sums + SUM_ROW * ((size_t)s * m->n_listed + j);
    for (; *at < m->single[j + 1] - m->single[j]; ++*at) {
      const size_t pair = n->entry[first + *at] / 2;
      const size_t *end = pairs_is_segment(&w->pairs, pair) ? c->segment : c->pair;
      double *row = m->row + SUM_ROW * (m->single[j] + *at);
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
  work *w = &e->work;
  sums *m = &w->sums;
  const int64_t from = e->state->step;
  const size_t listed = m->n_listed;
  copy_prescribed(e, true);
  for (int64_t s = 0; s < n; s++) {
    e->state->step = from + s;
    motion_pose(e, &w->threads[0]);
    for (size_t j = 0; j < listed && s + 1 < n; j++)
      memcpy(m->row + SUM_ROW * (size_t)w->row[m->listed[j]],
             w->window.sums + SUM_ROW * ((size_t)s * listed + j), SUM_ROW * sizeof *m->row);
    m->n_listed = s + 1 < n ? 0 : listed; /* the rows of contacts are those of the last step */
    w->kernels->gather(e, e->state->n_free, e->state->n_bodies);
    motion_work(e);
  }
  if (motion_moves_walls(e)) walls_pose_listed(e);
  e->state->step = from;
}

/* --- events ----------------------------------------------------------------------------------- */

static bool queue_add(window_queue *q, const event *v, size_t chunk, bool wraps) {
  if (!list_room(&q->item, q->n, &q->capacity, sizeof *q->item)) return false;
  q->item[q->n++] = (window_event){*v, chunk, wraps};
  return true;
}

/* Moves the events that chunk k has noted in step s of the window to the queue of this step. */
static void queue_events(engine *e, size_t k, int64_t s) {
  window *v = &e->work.window;
  thread_work *mine = &e->work.threads[0];
  v->failed |= mine->events.failed || mine->returns.failed || mine->fast;
  contacts_sort_events(e);
  for (size_t n = 0; n < mine->events.count; n++)
    v->failed |= !queue_add(&v->queue[s], &mine->events.item[n], k, false);
  for (size_t n = 0; n < mine->returns.count; n++)
    v->failed |= !queue_add(&v->queue[s], &mine->returns.item[n], k, true);
  mine->events.count = mine->returns.count = 0;
}

/* Handles the events of the chunks before `end` in step s of the window: first those of contacts,
 * then disks whose angle or position is wrapped. */
static void handle_events(engine *e, size_t end, int64_t s) {
  window *v = &e->work.window;
  window_queue *q = &v->queue[s];
  for (; q->done < q->n && q->item[q->done].chunk < end && !v->failed; q->done++) {
    const window_event *one = &q->item[q->done];
    if (one->wraps) {
      keep_rare(e, RARE_PLACE, one->event.index);
      contacts_wrap(e, one->event.index);
    } else {
      keep_of_pair(e, &one->event);
      v->failed |= contacts_pair_event(e, &one->event, v->messages) != SD_OK;
    }
  }
}

/* --- the wave --------------------------------------------------------------------------------- */

/* Takes step s of the window with chunk k; state->step is the step before. last: it is the last
 * step of the window. */
static void take_chunk(engine *e, size_t k, int64_t s, bool last) {
  work *w = &e->work;
  const chunks *c = &w->chunks;
  thread_work *mine = &w->threads[0];
  place_prescribed(e);
  for (size_t n = c->need_start[k]; s == 0 && n < c->need_start[k + 1]; n++)
    if (c->predicted[c->need[n]] != e->state->step + 1) copy_disks(e, c->need[n], false);
  if (s == 0) copy_pairs(e, k, false);
  sweep_chunk(e, mine, k);
  if (!last && w->sums.n_listed) add_prescribed(e, k, s);
  queue_events(e, k, s);
}

/* Undoes the steps of the window: of the first `places` chunks, and of those that they read. */
static void undo(engine *e, size_t places) {
  work *w = &e->work;
  window *v = &w->window;
  chunks *c = &w->chunks;
  thread_work *mine = &w->threads[0];
  for (size_t k = 0; k < c->count; k++) {
    if (k < places) copy_pairs(e, k, true);
    if (c->predicted[k] > e->state->step) copy_disks(e, k, true);
    c->predicted[k] = e->state->step;
    c->packed[k] = INT64_MIN;
  }
  while (v->n_rare > 0) restore_rare(e, &v->rare[--v->n_rare]);
  copy_prescribed(e, true);
  w->kernels->pack(e, e->state->n_free, e->state->n_bodies);
  if (motion_moves_walls(e)) walls_pose_listed(e);
  mine->stale = mine->fast = mine->events.failed = mine->returns.failed = false;
  mine->events.count = mine->returns.count = 0;
}

void window_free(window *v) {
  for (int64_t s = 0; s < v->steps; s++) free(v->queue[s].item);
  free(v->disks);
  free(v->blocks);
  free(v->flags);
  free(v->more);
  free(v->pieces);
  free(v->sums);
  free(v->reached);
  free(v->queue);
  free(v->rare);
  sd_messages_free(v->messages);
  *v = (window){.plain_until = v->plain_until, .taken = v->taken, .undone = v->undone};
}

/* Makes room for the copies of windows of up to n steps, with the present lists. */
static sd_status reserve(engine *e, int64_t n) {
  const work *w = &e->work;
  window *v = &e->work.window;
  const pairs *p = &w->pairs;
  const size_t disks = SD_COORDINATES * copied_columns(e) * e->state->n_free,
               blocks = p->first_segment / PAIR_BLOCK, listed = w->sums.n_listed;
  if (v->builds == w->builds && v->steps >= n) return SD_OK;
  window_free(v);
  if (!memory_rows(8,
                   (memory_column[]){{&v->disks, disks, sizeof *v->disks},
                                     {&v->blocks, blocks, sizeof *v->blocks},
                                     {&v->flags, blocks, sizeof *v->flags},
                                     {&v->more, p->more ? blocks : 0, sizeof *v->more},
                                     {&v->pieces, p->count - p->first_segment, sizeof *v->pieces},
                                     {&v->sums, (size_t)n * listed, SUM_ROW * sizeof *v->sums},
                                     {&v->reached, (size_t)n * listed, sizeof *v->reached},
                                     {&v->queue, (size_t)n, sizeof *v->queue}}))
    return SD_ERROR_IO;
  v->messages = sd_messages_new();
  v->builds = w->builds;
  v->steps = n;
  return SD_OK;
}

bool window_run(engine *e, int64_t n) {
  work *w = &e->work;
  window *v = &w->window;
  thread_work *mine = &w->threads[0];
  const size_t count = w->chunks.count, reach = w->chunks.reach, d = 2 * reach,
               listed = (size_t)n * w->sums.n_listed;
  const int64_t from = e->state->step;
  assert(n > 1 && n <= v->steps && !mine->stale && v->n_rare == 0);
  memset(v->sums, 0, listed * SUM_ROW * sizeof *v->sums);
  memset(v->reached, 0, listed * sizeof *v->reached);
  for (int64_t s = 0; s < n; s++) v->queue[s].n = v->queue[s].done = 0;
  v->failed = false;
  copy_prescribed(e, false);
  pairs_clear_single(e);
  bool stale = false;
  size_t m = 0;
  for (; m < count + d * (size_t)(n - 1) && !v->failed; m++)
    for (int64_t s = 0; s < n && m >= d * (size_t)s && !v->failed; s++) {
      const size_t k = m - d * (size_t)s;
      if (k >= count) continue;
      e->state->step = from + s;
      take_chunk(e, k, s, s + 1 == n);
      handle_events(e, k + 1 == count ? count : k + 1 > reach ? k + 1 - reach : 0, s);
      if (mine->stale && s + 1 < n) v->failed = true;
      stale |= mine->stale;
      mine->stale = false;
    }
  e->state->step = from;
  const double work_driven = e->state->work_driven;
  if (!v->failed) follow_prescribed(e, n);
  v->failed |= mine->fast;
  if (v->failed) {
    e->state->work_driven = work_driven;
    undo(e, m < count ? m : count);
    v->plain_until = from + n;
    v->undone++;
    return false;
  }
  v->taken++;
  v->n_rare = 0;
  e->state->step = from + n;
  mine->stale = stale;
  return true;
}

/* --- how many steps --------------------------------------------------------------------------- */

/* True if nothing that the steps have to do needs all disks after each step. */
static bool can_wait(engine *e) {
  const work *w = &e->work;
  size_t n;
  if (w->chunks.window < 2 || w->n_threads > 1 || e->halo || e->comm || e->fields) return false;
  if (w->predict_all || w->cell.on || w->body_forces || w->clumps.count || w->lanes) return false;
  if (e->state->n_slides || w->threads[0].stale) return false;
  motion_prescribed(e, &n);
  return n <= WINDOW_PRESCRIBED && w->n_pieces <= MOST_PIECES && w->sums.n_listed <= MOST_PIECES &&
         motion_ahead(e) && !motion_corrects(e);
}

/* Returns for how many of the next n steps the lists will probably do: disks go on as they move
 * now, or half as fast again. */
static int64_t steps_of_list(const engine *e, int64_t n) {
  while (n > 1 && e->work.kernels->stale(e, 0, e->state->n_free, 1.5 * (double)n)) n /= 2;
  return n;
}

int64_t window_steps(engine *e, int64_t most) {
  const work *w = &e->work;
  if (most < 2 || e->state->step < w->window.plain_until || !can_wait(e)) return 1;
  const int64_t computed = MOTION_BATCH - motion_index(e);
  int64_t n = most < w->chunks.window ? most : w->chunks.window;
  if (computed < n) n = computed;
  for (int64_t s = 1; s < n; s++)
    if (validity_due(e->state->step + s)) n = s;
  n = steps_of_list(e, n);
  return n > 1 && reserve(e, w->chunks.window) == SD_OK ? n : 1;
}
