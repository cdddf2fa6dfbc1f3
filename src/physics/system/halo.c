/* halo.c: messages between ranks (processes) in a step; see halo.h. */
#include "physics/system/halo.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

#include "base/team.h"
#include "base/comm.h"
#include "base/memory.h"
#include "physics/system/list.h"

static void free_rows(halo_rows *r) {
  free(r->start);
  free(r->from);
  free(r->mine);
  free(r->all);
  free(r->mine_at);
  free(r->counts);
  *r = (halo_rows){0};
}

void halo_free(halo *h) {
  if (!h) return;
  comm_links_free(h->links);
  free(h->order);
  free(h->send_slot);
  free(h->ghost_slot);
  free(h->send);
  free(h->receive);
  free(h->x2);
  free(h->y2);
  free(h->sent);
  free(h->rebased.item);
  free(h->wrapped.item);
  free(h->shifted.item);
  free_rows(&h->prescribed);
  free(h);
}

sd_status halo_connect(halo *h, const int *to, const int *from) {
  const size_t row = HALO_ROW * sizeof(double);
  if (!memory_rows(5, (memory_column[]){{&h->send, h->n_send, row},
                                        {&h->receive, h->n_ghosts, row},
                                        {&h->sent, h->n_own, sizeof *h->sent},
                                        {&h->x2, h->n_ghosts, sizeof *h->x2},
                                        {&h->y2, h->n_ghosts, sizeof *h->y2}}))
    return SD_ERROR_IO;
  for (size_t k = 0; k < h->n_send; k++) {
    assert(h->send_slot[k] < h->n_own);
    h->sent[h->send_slot[k]] = true;
  }
  h->links = comm_links_new(h->comm, h->send, to, h->receive, from, row);
  return SD_OK;
}

sd_status halo_wait_for(halo_waits *list, halo_wait wait) {
  if (!list_room(&list->item, list->count, &list->capacity, sizeof *list->item)) return SD_ERROR_IO;
  list->item[list->count++] = wait;
  return SD_OK;
}

/* --- messages of a step ----------------------------------------------------------------------- */

unsigned halo_agree(halo *h) {
  const double began = clock_seconds();
  if (h->rebased.count + h->wrapped.count > 0) h->bits |= HALO_WAITS;
  const unsigned all = comm_or(h->comm, h->bits);
  h->bits = 0;
  h->waited += clock_seconds() - began;
  return all;
}

static void wait_for_rows(halo *h) {
  const double began = clock_seconds();
  comm_links_wait(h->links);
  h->waited += clock_seconds() - began;
}

void halo_start(engine *e) {
  halo *h = e->halo;
  const double *packed = e->work.packed;
  const int32_t *row = e->work.row;
  const size_t bytes = PACKED_ROW * sizeof(double);
  const sd_state *s = e->state;
  for (size_t k = 0; k < h->n_send; k++) {
    const uint32_t i = h->send_slot[k];
    double *to = h->send + HALO_ROW * k;
    memcpy(to, packed + PACKED_ROW * (size_t)row[i], bytes);
    /* The packed body lacks the spin if the contact laws do not need it. */
    to[PACKED_SPIN] = s->radius[i] * s->omega[i];
    to[PACKED_ROW] = s->x2[i];
    to[PACKED_ROW + 1] = s->y2[i];
  }
  comm_links_start(h->links);
}

void halo_progress(halo *h) { comm_links_progress(h->links); }

void halo_finish(engine *e) {
  halo *h = e->halo;
  const int32_t *row = e->work.row;
  wait_for_rows(h);
  for (size_t k = 0; k < h->n_ghosts; k++) {
    const uint32_t i = h->ghost_slot[k];
    const double *from = h->receive + HALO_ROW * k;
    memcpy(e->work.packed + PACKED_ROW * (size_t)row[i], from, PACKED_ROW * sizeof(double));
    h->x2[i - h->n_own] = from[PACKED_ROW];
    h->y2[i - h->n_own] = from[PACKED_ROW + 1];
  }
}

/* Columns of a message row of halo_refresh. */
enum {
  POSE_X,
  POSE_Y,
  POSE_THETA,
  POSE_TURN,
  POSE_VX,
  POSE_VY,
  POSE_OMEGA,
  POSE_IMAGES, /* image_x and image_y, two 32-bit integers in one double */
  /* position before wrapping if changes are requested (change not NULL), else acceleration */
  POSE_BEFORE_X,
  POSE_BEFORE_Y,
  POSE_ROW
};
static_assert((int)POSE_ROW <= (int)HALO_ROW, "a row of the messages");

void halo_refresh(engine *e, halo_wait *change) {
  halo *h = e->halo;
  sd_state *s = e->state;
  for (size_t k = 0; k < h->n_send; k++) {
    double *row = h->send + HALO_ROW * k;
    const uint32_t i = h->send_slot[k];
    row[POSE_X] = s->x[i];
    row[POSE_Y] = s->y[i];
    row[POSE_THETA] = s->theta[i];
    row[POSE_TURN] = s->turn[i];
    row[POSE_VX] = s->vx[i];
    row[POSE_VY] = s->vy[i];
    row[POSE_OMEGA] = s->omega[i];
    const int32_t images[2] = {s->image_x[i], s->image_y[i]};
    memcpy(&row[POSE_IMAGES], images, sizeof images);
    row[POSE_BEFORE_X] = change ? s->x[i] : s->x2[i];
    row[POSE_BEFORE_Y] = change ? s->y[i] : s->y2[i];
    for (size_t n = 0; change && n < h->shifted.count; n++) {
      if (h->shifted.item[n].index != i) continue;
      row[POSE_BEFORE_X] = h->shifted.item[n].x;
      row[POSE_BEFORE_Y] = h->shifted.item[n].y;
    }
  }
  comm_links_start(h->links);
  wait_for_rows(h);
  for (size_t k = 0; k < h->n_ghosts; k++) {
    const double *row = h->receive + HALO_ROW * k;
    const uint32_t i = h->ghost_slot[k];
    if (change)
      change[i - h->n_own] = (halo_wait){.index = i,
                                         .turn = row[POSE_TURN] - s->turn[i],
                                         .x = row[POSE_BEFORE_X],
                                         .y = row[POSE_BEFORE_Y]};
    if (!change) {
      h->x2[i - h->n_own] = row[POSE_BEFORE_X];
      h->y2[i - h->n_own] = row[POSE_BEFORE_Y];
    }
    s->x[i] = row[POSE_X];
    s->y[i] = row[POSE_Y];
    s->theta[i] = row[POSE_THETA];
    s->turn[i] = row[POSE_TURN];
    s->vx[i] = row[POSE_VX];
    s->vy[i] = row[POSE_VY];
    s->omega[i] = row[POSE_OMEGA];
    int32_t images[2];
    memcpy(images, &row[POSE_IMAGES], sizeof images);
    s->image_x[i] = images[0];
    s->image_y[i] = images[1];
  }
}

/* --- forces on prescribed bodies -------------------------------------------------------------- */

/* Sort key of one row of forces on a prescribed body: by body, then in the global order of pairs.
 * body: number of the prescribed body; order: global slot of the disk in contact; part: wall
 * segment; from: row number in halo_rows.all. */
typedef struct row_key {
  uint32_t body, order, part, from;
} row_key;

static int by_order(const void *one, const void *two) {
  const row_key *p = one, *q = two;
  if (p->body != q->body) return p->body < q->body ? -1 : 1;
  if (p->order != q->order) return p->order < q->order ? -1 : 1;
  return p->part < q->part ? -1 : p->part > q->part;
}

/* Returns the slot of the first prescribed body. */
static size_t first_of(const engine *e) { return e->halo->n_own + e->halo->n_ghosts; }

/* Returns the number of candidate contacts of this rank's disks with prescribed bodies. */
static size_t count_rows(const engine *e) {
  const incidence *n = &e->work.incidence;
  return n->start[e->state->n_bodies] - n->start[first_of(e)];
}

/* Lists the sort key of each of this rank's rows of forces on prescribed bodies, and the row of
 * work.sums that it is copied from. */
static void fill_keys(const engine *e, row_key *key, uint32_t *row) {
  const work *w = &e->work;
  const incidence *n = &w->incidence;
  const size_t first = first_of(e);
  size_t at = 0;
  for (size_t k = 0; k < w->sums.n_listed; k++) {
    const size_t slot = w->sums.listed[k];
    if (slot < first) continue;
    for (size_t i = n->start[slot]; i < n->start[slot + 1]; i++, at++) {
      const size_t pair = n->entry[i] / 2;
      key[at] = (row_key){.body = (uint32_t)(slot - first),
                          .order = e->halo->order[w->pairs.a[pair]],
                          .part = (uint32_t)w->pairs.part[pair]};
      row[at] = (uint32_t)(w->sums.single[k] + (i - n->start[slot]));
    }
  }
  assert(at == count_rows(e));
}

sd_status halo_list_prescribed(engine *e) {
  halo_rows *r = &e->halo->prescribed;
  const size_t bodies = e->state->n_bodies - first_of(e), mine = count_rows(e);
  free_rows(r);
  r->n_mine = mine;
  const comm *c = e->halo->comm;
  r->counts = memory_new((size_t)comm_size(c), sizeof *r->counts);
  comm_gather_counts(c, (int)mine, r->counts);
  size_t all = 0;
  for (int k = 0; k < comm_size(c); k++) all += (size_t)r->counts[k];
  row_key *key, *every;
  if (!memory_rows(7, (memory_column[]){{&key, mine, sizeof *key},
                                        {&every, all, sizeof *every},
                                        {&r->start, bodies + 1, sizeof *r->start},
                                        {&r->from, all, sizeof *r->from},
                                        {&r->mine, mine, SUM_ROW * sizeof *r->mine},
                                        {&r->all, all, SUM_ROW * sizeof *r->all},
                                        {&r->mine_at, mine, sizeof *r->mine_at}})) {
    comm_fail(c, "no memory");
    return SD_ERROR_IO;
  }
  fill_keys(e, key, r->mine_at);
  comm_gather(c, key, every, r->counts, sizeof *key);
  for (size_t k = 0; k < all; k++) {
    every[k].from = (uint32_t)k;
    r->start[every[k].body + 1]++;
  }
  for (size_t b = 0; b < bodies; b++) r->start[b + 1] += r->start[b];
  if (all > 1) qsort(every, all, sizeof *every, by_order);
  for (size_t k = 0; k < all; k++) r->from[k] = every[k].from;
  free(key);
  free(every);
  return SD_OK;
}

void halo_gather_prescribed(engine *e) {
  halo *h = e->halo;
  halo_rows *r = &h->prescribed;
  const double began = clock_seconds();
  for (size_t k = 0; k < r->n_mine; k++)
    memcpy(r->mine + SUM_ROW * k, e->work.sums.row + SUM_ROW * (size_t)r->mine_at[k],
           SUM_ROW * sizeof *r->mine);
  comm_gather(h->comm, r->mine, r->all, r->counts, SUM_ROW * sizeof *r->mine);
  h->waited += clock_seconds() - began;
}

void halo_sum_prescribed(const halo *h, size_t k, double *sum) {
  const halo_rows *r = &h->prescribed;
  for (size_t c = 0; c < SUM_ROW; c++) sum[c] = 0.0;
  for (size_t at = r->start[k]; at < r->start[k + 1]; at++)
    for (size_t c = 0; c < SUM_ROW; c++) sum[c] += r->all[SUM_ROW * (size_t)r->from[at] + c];
}
