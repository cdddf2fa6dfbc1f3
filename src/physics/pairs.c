/* pairs.c: see pairs.h. */
#include "physics/pairs.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

#include "base/room.h"
#include "physics/chunks.h"

/* --- room -------------------------------------------------------------------------------------------- */

void pairs_free(pairs *p) {
  room_free(p->a);
  room_free(p->b);
  room_free(p->part);
  room_free(p->side);
  room_free(p->block);
  *p = (pairs){0};
}

static sd_status grow(void **column, size_t count, size_t capacity, size_t size) {
  void *more = room_for(capacity, size);
  if (!more) return SD_ERROR_IO;
  if (*column) memcpy(more, *column, count * size);
  room_free(*column);
  *column = more;
  return SD_OK;
}

/* Blocks and sides are filled after all pairs are known. */
sd_status pairs_reserve(pairs *p, size_t count) {
  if (count <= p->capacity) return SD_OK;
  size_t capacity = (count + 2 * PAIR_BLOCK) / PAIR_BLOCK * PAIR_BLOCK;
  int32_t **whole[] = {&p->a, &p->b, &p->part};
  for (size_t k = 0; k < sizeof whole / sizeof *whole; k++)
    if (grow((void **)whole[k], p->count, capacity, sizeof(int32_t)) != SD_OK) return SD_ERROR_IO;
  room_free(p->side);
  room_free(p->block);
  p->side = room_for(capacity, sizeof *p->side);
  p->block = room_for(capacity / PAIR_BLOCK, sizeof *p->block);
  p->capacity = p->side && p->block ? capacity : 0;
  return p->capacity ? SD_OK : SD_ERROR_IO;
}

sd_status pairs_push(pairs *p, int32_t a, int32_t b, int32_t part) {
  if (p->count == p->capacity && pairs_reserve(p, p->count + p->count / 2 + 1) != SD_OK) return SD_ERROR_IO;
  p->a[p->count] = a;
  p->b[p->count] = b;
  p->part[p->count++] = part;
  return SD_OK;
}

sd_status pairs_end_round(pairs *p) {
  p->n_round = p->count;
  sd_status status = SD_OK;
  while (p->count % PAIR_BLOCK && status == SD_OK) status = pairs_push(p, PAIR_OF_NOBODY, PAIR_OF_NOBODY, 0);
  p->first_piece = p->count;
  return status;
}

/* --- memory ------------------------------------------------------------------------------------------ */

static bool same_pair(const pairs *p, size_t k, const pairs *q, size_t n) {
  return p->a[k] == q->a[n] && p->b[k] == q->b[n] && p->part[k] == q->part[n];
}

static bool stands_before(const pairs *p, size_t k, const pairs *q, size_t n) {
  if (p->a[k] != q->a[n]) return p->a[k] < q->a[n];
  if (p->b[k] != q->b[n]) return p->b[k] < q->b[n];
  return p->part[k] < q->part[n];
}

static void carry_pair(pairs *from, size_t k, pairs *to, size_t n) {
  PAIR(to, n, star) = PAIR(from, k, star);
  PAIR(to, n, ex) = PAIR(from, k, ex);
  PAIR(to, n, ey) = PAIR(from, k, ey);
  PAIR(to, n, overlap) = PAIR(from, k, overlap);
  PAIR(to, n, force) = PAIR(from, k, force);
  PAIR(to, n, stretch) = PAIR(from, k, stretch);
  PAIR(to, n, turned) = PAIR(from, k, turned);
  PAIR(to, n, slip) = PAIR(from, k, slip);
  PAIR(to, n, viscous) = PAIR(from, k, viscous);
  PAIR(to, n, friction) = PAIR(from, k, friction);
  PAIR(to, n, gain) = PAIR(from, k, gain);
  to->side[n] = from->side[k];
  /* what is left in the old list is of contacts that end */
  PAIR(from, k, viscous) = PAIR(from, k, friction) = PAIR(from, k, gain) = 0.0;
}

/* Both lists have the same order, so one sweep finds what the old one remembers. */
static void carry(pairs *from, pairs *to, size_t from_begin, size_t from_end, size_t begin, size_t end) {
  size_t k = from_begin;
  for (size_t n = begin; n < end; n++) {
    while (k < from_end && stands_before(from, k, to, n)) k++;
    if (k == from_end) return;
    if (same_pair(from, k, to, n) && pairs_closed(from, k)) carry_pair(from, k, to, n);
  }
}

static int32_t law_of(const engine *e, const pairs *p, size_t k) {
  const int32_t *material = e->state->material;
  if (p->a[k] < 0) return 0;
  return material[p->a[k]] * (int32_t)e->model->n_materials + material[p->b[k]];
}

sd_status pairs_finish(const engine *e, pairs *from, pairs *to) {
  if (pairs_reserve(to, to->count + 1) != SD_OK) return SD_ERROR_IO;
  memset(to->block, 0, (to->count + PAIR_BLOCK - 1) / PAIR_BLOCK * sizeof *to->block);
  memset(to->side, 0, to->count * sizeof *to->side);
  for (size_t k = 0; k < to->count; k++) PAIR(to, k, law) = law_of(e, to, k);
  carry(from, to, 0, from->n_round, 0, to->n_round);
  carry(from, to, from->first_piece, from->count, to->first_piece, to->count);
  return SD_OK;
}

/* --- contacts of each body --------------------------------------------------------------------------- */

static sd_status list_incidence(engine *e) {
  const sd_state *s = e->state;
  const pairs *p = &e->work.pairs;
  incidence *n = &e->work.incidence;
  if (!n->start) n->start = malloc((s->n_bodies + 2) * sizeof *n->start);
  if (2 * p->count > n->capacity) {
    free(n->entry);
    n->capacity = 2 * p->capacity;
    n->entry = malloc(n->capacity * sizeof *n->entry);
  }
  if (!n->start || (n->capacity && !n->entry)) return SD_ERROR_IO;
  memset(n->start, 0, (s->n_bodies + 2) * sizeof *n->start);
  for (size_t k = 0; k < p->count; k++) {
    if (p->a[k] < 0) continue;
    n->start[p->a[k] + 2]++;
    n->start[p->b[k] + 2]++;
  }
  for (size_t b = 2; b < s->n_bodies + 2; b++) n->start[b] += n->start[b - 1];
  for (size_t k = 0; k < p->count; k++) {
    if (p->a[k] < 0) continue;
    n->entry[n->start[p->a[k] + 1]++] = (uint32_t)(2 * k);
    n->entry[n->start[p->b[k] + 1]++] = (uint32_t)(2 * k + 1);
  }
  return SD_OK;
}

/* --- seats and sums ---------------------------------------------------------------------------------- */

/* How many bodies have, with that of nobody. */
static size_t count_rows(const engine *e) {
  return e->work.chunks.rows + e->state->n_bodies - e->state->n_free + 1;
}

static sd_status reserve_rows(engine *e) {
  work *w = &e->work;
  if (!w->row) w->row = malloc((e->state->n_bodies + 1) * sizeof *w->row);
  if (count_rows(e) > w->seats_capacity) {
    room_free(w->seats);
    w->seats_capacity = count_rows(e) + count_rows(e) / 4;
    w->seats = room_for(w->seats_capacity, SEAT_ROW * sizeof *w->seats);
  }
  return w->row && w->seats ? SD_OK : SD_ERROR_IO;
}

/* Rows of free disks, of the other bodies, and of nobody: at (0, 0) without a radius, where it touches nothing. */
static sd_status list_rows(engine *e) {
  const size_t n_bodies = e->state->n_bodies, n_free = e->state->n_free;
  work *w = &e->work;
  const chunks *c = &w->chunks;
  pairs *p = &w->pairs;
  if (reserve_rows(e) != SD_OK) return SD_ERROR_IO;
  for (size_t k = 0; k < c->count; k++)
    for (size_t slot = c->begin[k]; slot < c->begin[k + 1]; slot++)
      w->row[slot] = (int32_t)(c->row[k] + slot - c->begin[k]);
  for (size_t slot = n_free; slot <= n_bodies; slot++) w->row[slot] = (int32_t)(c->rows + slot - n_free);
  memset(w->seats + SEAT_ROW * (size_t)w->row[n_bodies], 0, SEAT_ROW * sizeof *w->seats);
  for (size_t k = 0; k < p->count; k++) {
    const bool nobody = p->a[k] < 0;
    const int32_t a = w->row[nobody ? n_bodies : (size_t)p->a[k]];
    const int32_t b = w->row[nobody ? n_bodies : (size_t)p->b[k]];
    PAIR(p, k, seat_a) = SEAT_ROW * a;
    PAIR(p, k, seat_b) = SEAT_ROW * b;
    PAIR(p, k, sum_a) = SUM_ROW * a;
    PAIR(p, k, sum_b) = SUM_ROW * b;
  }
  return SD_OK;
}

/* Are the contacts of this body wanted one by one, or in the share of another thread? */
static bool is_listed(const engine *e, size_t slot) {
  const work *w = &e->work;
  const incidence *n = &w->incidence;
  if (slot >= e->state->n_free) return true;
  if (w->columns[SD_X].inverse[slot] == 0.0 || w->columns[SD_Y].inverse[slot] == 0.0 ||
      w->columns[SD_THETA].inverse[slot] == 0.0)
    return true;
  const int mine = w->n_threads > 1 ? chunks_thread_of_disk(e, slot) : 0;
  for (size_t at = n->start[slot]; w->n_threads > 1 && at < n->start[slot + 1]; at++)
    if (chunks_thread_of_pair(e, n->entry[at] / 2) != mine) return true;
  return false;
}

/* Bodies whose contacts stand one by one. */
static sd_status list_listed(engine *e) {
  work *w = &e->work;
  sums *m = &w->sums;
  m->n_listed = 0;
  for (size_t slot = 0; slot < e->state->n_bodies; slot++) {
    if (!is_listed(e, slot)) continue;
    if (m->n_listed + 1 >= m->listed_capacity) {
      size_t capacity = 2 * m->listed_capacity + 16;
      uint32_t *more = realloc(m->listed, capacity * sizeof *more);
      if (!more) return SD_ERROR_IO;
      m->listed = more;
      m->listed_capacity = capacity;
    }
    m->listed[m->n_listed++] = (uint32_t)slot;
    if (slot < e->state->n_free) chunks_put_off(&w->chunks, slot);
  }
  return SD_OK;
}

static sd_status reserve_sums(engine *e) {
  sums *m = &e->work.sums;
  const incidence *n = &e->work.incidence;
  size_t rows = count_rows(e);
  for (size_t k = 0; k < m->n_listed; k++) rows += n->start[m->listed[k] + 1] - n->start[m->listed[k]];
  if (rows > m->capacity) {
    room_free(m->row);
    m->capacity = rows + rows / 4;
    m->row = room_for(m->capacity, SUM_ROW * sizeof *m->row);
  }
  free(m->single);
  m->single = malloc((m->n_listed + 1) * sizeof *m->single);
  return m->row && m->single ? SD_OK : SD_ERROR_IO;
}

static sd_status list_sums(engine *e) {
  work *w = &e->work;
  sums *m = &w->sums;
  const incidence *n = &w->incidence;
  if (reserve_sums(e) != SD_OK) return SD_ERROR_IO;
  m->end = count_rows(e);
  for (size_t k = 0; k < m->n_listed; k++) {
    m->single[k] = m->end;
    for (size_t at = n->start[m->listed[k]]; at < n->start[m->listed[k] + 1]; at++, m->end++) {
      size_t pair = n->entry[at] / 2;
      *(n->entry[at] & 1 ? &PAIR(&w->pairs, pair, sum_b) : &PAIR(&w->pairs, pair, sum_a)) =
          (int32_t)(SUM_ROW * m->end);
    }
  }
  m->single[m->n_listed] = m->end;
  pairs_clear_single(e); /* the rows of another list stood here */
  return SD_OK;
}

void pairs_clear_single(engine *e) {
  sums *m = &e->work.sums;
  const size_t from = e->work.chunks.rows;
  memset(m->row + SUM_ROW * from, 0, (m->end - from) * SUM_ROW * sizeof *m->row);
}

void pairs_clear_sums(engine *e) {
  sums *m = &e->work.sums;
  memset(m->row, 0, m->end * SUM_ROW * sizeof *m->row);
}

void sums_add_listed(const work *w, size_t begin, size_t end) {
  const sums *m = &w->sums;
  size_t low = 0, high = m->n_listed;
  while (low < high) {
    size_t middle = (low + high) / 2;
    if (m->listed[middle] < begin)
      low = middle + 1;
    else
      high = middle;
  }
  for (size_t n = low; n < m->n_listed && m->listed[n] < end; n++) {
    double *sum = m->row + SUM_ROW * (size_t)w->row[m->listed[n]];
    for (size_t c = 0; c < SUM_ROW; c++) sum[c] = 0.0;
    for (size_t at = m->single[n]; at < m->single[n + 1]; at++)
      for (size_t c = 0; c < SUM_ROW; c++) sum[c] += m->row[SUM_ROW * at + c];
  }
}

sd_status pairs_list(engine *e) {
  work *w = &e->work;
  if (chunks_plan(e) != SD_OK || list_incidence(e) != SD_OK || list_listed(e) != SD_OK) return SD_ERROR_IO;
  chunks_plan_commits(&w->chunks);
  if (chunks_plan_rows(&w->chunks, e->state->n_free) != SD_OK || list_rows(e) != SD_OK) return SD_ERROR_IO;
  return list_sums(e);
}

void pairs_list_free(engine *e) {
  work *w = &e->work;
  chunks_free(&w->chunks);
  free(w->incidence.start);
  free(w->incidence.entry);
  room_free(w->sums.row);
  free(w->sums.listed);
  free(w->sums.single);
  room_free(w->seats);
  free(w->row);
  w->incidence = (incidence){0};
  w->seats = NULL;
  w->row = NULL;
  w->seats_capacity = 0;
  w->sums = (sums){0};
}
