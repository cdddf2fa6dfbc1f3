/* rows.c: see rows.h. */
#include "physics/neighbours/rows.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

#include "base/arena.h"
#include "physics/neighbours/chunks.h"

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
  assert(n->start[s->n_bodies + 1] == 2 * (p->count - (p->first_segment - p->n_round)));
  assert(n->start[s->n_bodies + 1] <= n->capacity && p->count <= UINT32_MAX / 2);
  for (size_t k = 0; k < p->count; k++) {
    if (p->a[k] < 0) continue;
    n->entry[n->start[p->a[k] + 1]++] = (uint32_t)(2 * k);
    n->entry[n->start[p->b[k] + 1]++] = (uint32_t)(2 * k + 1);
  }
  assert(n->start[0] == 0 && n->start[s->n_bodies] == n->start[s->n_bodies + 1]);
  return SD_OK;
}

/* --- packed and sums ---------------------------------------------------------------------------------- */

/* How many bodies have, with that of nobody. */
static size_t count_rows(const engine *e) {
  return e->work.chunks.rows + e->state->n_bodies - e->state->n_free + 1;
}

static sd_status reserve_rows(engine *e) {
  work *w = &e->work;
  if (!w->row) w->row = malloc((e->state->n_bodies + 1) * sizeof *w->row);
  if (count_rows(e) > w->packed_capacity) {
    arena_free(w->packed);
    w->packed_capacity = count_rows(e) + count_rows(e) / 4;
    w->packed = arena_for(w->packed_capacity, PACKED_ROW * sizeof *w->packed);
  }
  return w->row && w->packed ? SD_OK : SD_ERROR_IO;
}

/* Rows of free disks, of the other bodies, and of nobody: at (0, 0) without a radius, where it touches nothing. */
static sd_status list_rows(engine *e) {
  const size_t n_bodies = e->state->n_bodies, n_free = e->state->n_free;
  work *w = &e->work;
  const chunks *c = &w->chunks;
  pairs *p = &w->pairs;
  if (reserve_rows(e) != SD_OK) return SD_ERROR_IO;
  assert(count_rows(e) <= INT32_MAX / PACKED_ROW && count_rows(e) <= w->packed_capacity);
  for (size_t k = 0; k < c->count; k++)
    for (size_t slot = c->begin[k]; slot < c->begin[k + 1]; slot++)
      w->row[slot] = (int32_t)(c->row[k] + slot - c->begin[k]);
  for (size_t slot = n_free; slot <= n_bodies; slot++) w->row[slot] = (int32_t)(c->rows + slot - n_free);
  assert((size_t)w->row[n_bodies] + 1 == count_rows(e)); /* that of padding is the last */
  memset(w->packed + PACKED_ROW * (size_t)w->row[n_bodies], 0, PACKED_ROW * sizeof *w->packed);
  for (size_t k = 0; k < p->count; k++) {
    const bool nobody = p->a[k] < 0;
    const int32_t a = w->row[nobody ? n_bodies : (size_t)p->a[k]];
    const int32_t b = w->row[nobody ? n_bodies : (size_t)p->b[k]];
    PAIR(p, k, packed_a) = PACKED_ROW * a;
    PAIR(p, k, packed_b) = PACKED_ROW * b;
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
    assert(m->n_listed == 0 || m->listed[m->n_listed - 1] < slot);
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
    arena_free(m->row);
    m->capacity = rows + rows / 4;
    m->row = arena_for(m->capacity, SUM_ROW * sizeof *m->row);
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
  assert(m->end <= m->capacity && m->end <= INT32_MAX / SUM_ROW);
  pairs_clear_single(e); /* the rows of another list stood here */
  return SD_OK;
}

void pairs_clear_single(engine *e) {
  sums *m = &e->work.sums;
  const size_t from = e->work.chunks.rows;
  assert(from <= m->end && m->end <= m->capacity);
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
  assert(low == m->n_listed || m->listed[low] >= begin);
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
  if (chunks_plan_rows(&w->chunks, e->state->n_free) != SD_OK || list_rows(e) != SD_OK) return SD_ERROR_IO;
  return list_sums(e);
}

void pairs_list_free(engine *e) {
  work *w = &e->work;
  chunks_free(&w->chunks);
  free(w->incidence.start);
  free(w->incidence.entry);
  arena_free(w->sums.row);
  free(w->sums.listed);
  free(w->sums.single);
  arena_free(w->packed);
  free(w->row);
  w->incidence = (incidence){0};
  w->packed = NULL;
  w->row = NULL;
  w->packed_capacity = 0;
  w->sums = (sums){0};
}
