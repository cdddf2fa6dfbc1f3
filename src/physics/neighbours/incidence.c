/* incidence.c: builds the tables that follow from a list of pairs; implements pairs_list,
 * pairs_clear_... and sums_add_listed of neighbours.h. */
#include "physics/neighbours/neighbours.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "physics/contact/pairs.h"
#include "physics/neighbours/chunks.h"
#include "physics/system/halo.h"
#include "physics/system/list.h"

/* --- contacts of each body -------------------------------------------------------------------- */

static size_t partner_of(const pairs *p, uint32_t entry) {
  return (size_t)(entry & 1 ? p->a[entry / 2] : p->b[entry / 2]);
}

/* Sorts the contacts of a disk of this rank with round bodies by the global slots of the partners,
 * the slots that they would have in a run on one rank. */
static void order_partners(const engine *e, size_t slot) {
  const incidence *n = &e->work.incidence;
  const pairs *p = &e->work.pairs;
  uint32_t *entry = n->entry;
  for (size_t k = n->start[slot]; k < n->start[slot + 1] && !pairs_is_segment(p, entry[k] / 2);
       k++) {
    const uint32_t moved = entry[k];
    const uint64_t here = halo_order(e, partner_of(p, moved));
    size_t at = k;
    for (; at > n->start[slot] && halo_order(e, partner_of(p, entry[at - 1])) > here; at--)
      entry[at] = entry[at - 1];
    entry[at] = moved;
  }
}

/* Part of the lists of contacts of each body that one thread builds: those of the free disks in
 * slots [begin, end); thread 0 also builds those of all other bodies. The thread treats the pairs
 * whose first body is in this range. If the second body belongs to another thread, the pair is
 * listed in `away`, for that thread. */
typedef struct incidence_share {
  size_t begin, end;       /* range of slots, all of free disks */
  size_t pair, pair_end;   /* range of pairs of round bodies */
  size_t ghost, ghost_end; /* range of pairs with ghosts */
  size_t piece, piece_end; /* range of pairs with wall segments */
  numbers away;            /* pairs whose second body belongs to another thread, ascending */
  size_t entries;
} incidence_share;

typedef struct incidence_task {
  engine *e;
  incidence_share share[WORK_MAX_THREADS];
} incidence_task;

static bool stands_here(const incidence_task *f, const incidence_share *mine, int32_t slot) {
  const size_t b = (size_t)slot;
  return (b >= mine->begin && b < mine->end) || (mine == &f->share[0] && b >= f->e->state->n_free);
}

/* Adds the contacts that other threads found for bodies of this thread: those with wall segments if
 * `pieces`, else those of round bodies. fill: true stores the contacts, false only counts them. */
static void take_away(const incidence_task *f, const team *t, bool pieces, bool fill) {
  incidence *n = &f->e->work.incidence;
  const pairs *p = &f->e->work.pairs;
  const incidence_share *mine = &f->share[t->rank];
  for (int other = 0; other < t->size; other++) {
    const numbers *l = &f->share[other].away;
    for (size_t at = 0; at < l->n; at++) {
      const size_t k = l->at[at];
      if (pairs_is_segment(p, k) != pieces || !stands_here(f, mine, p->b[k])) continue;
      if (fill)
        n->entry[n->start[p->b[k] + 1]++] = (uint32_t)(2 * k + 1);
      else
        n->start[p->b[k] + 2]++;
    }
  }
}

static void count_own(const incidence_task *f, incidence_share *mine) {
  size_t *start = f->e->work.incidence.start;
  const pairs *p = &f->e->work.pairs;
  for (size_t k = mine->pair; k < mine->pair_end; k++) {
    start[p->a[k] + 2]++;
    if ((size_t)p->b[k] < mine->end)
      start[p->b[k] + 2]++;
    else
      numbers_add(&mine->away, k);
  }
  for (size_t k = mine->ghost; k < mine->ghost_end; k++) {
    start[p->a[k] + 2]++;
    numbers_add(&mine->away, k);
  }
  for (size_t k = mine->piece; k < mine->piece_end; k++) {
    start[p->a[k] + 2]++;
    numbers_add(&mine->away, k);
  }
}

static void fill_own(const incidence_task *f, const incidence_share *mine) {
  incidence *n = &f->e->work.incidence;
  const pairs *p = &f->e->work.pairs;
  for (size_t k = mine->pair; k < mine->pair_end; k++) {
    n->entry[n->start[p->a[k] + 1]++] = (uint32_t)(2 * k);
    if ((size_t)p->b[k] < mine->end) n->entry[n->start[p->b[k] + 1]++] = (uint32_t)(2 * k + 1);
  }
  for (size_t k = mine->ghost; k < mine->ghost_end; k++)
    n->entry[n->start[p->a[k] + 1]++] = (uint32_t)(2 * k);
  for (size_t k = mine->piece; k < mine->piece_end; k++)
    n->entry[n->start[p->a[k] + 1]++] = (uint32_t)(2 * k);
}

static void clear_counts(const incidence_task *f, const incidence_share *mine) {
  size_t *start = f->e->work.incidence.start;
  const size_t n_free = f->e->state->n_free, others = f->e->state->n_bodies - n_free;
  memset(start + mine->begin + 2, 0, (mine->end - mine->begin) * sizeof *start);
  if (mine != &f->share[0]) return;
  start[0] = start[1] = 0;
  memset(start + n_free + 2, 0, others * sizeof *start);
}

/* Turns the number of contacts of each body into the index of its first contact (prefix sum). */
static void add_up(const incidence_task *f, const team *t) {
  size_t *start = f->e->work.incidence.start, before = 0;
  const size_t n_free = f->e->state->n_free;
  const incidence_share *mine = &f->share[t->rank];
  for (int other = 0; other < t->rank; other++) before += f->share[other].entries;
  for (size_t b = mine->begin; b < mine->end; b++) start[b + 2] = before += start[b + 2];
  team_wait(t);
  if (t->rank > 0) return;
  for (size_t b = n_free; b < f->e->state->n_bodies; b++) start[b + 2] += start[b + 1];
}

static void incidence_together(const team *t, void *with) {
  incidence_task *f = with;
  const engine *e = f->e;
  const pairs *p = &e->work.pairs;
  const size_t *start = e->work.incidence.start;
  incidence_share *mine = &f->share[t->rank];
  team_share(t, e->state->n_free, &mine->begin, &mine->end);
  mine->pair = pairs_from(p, 0, p->n_round, mine->begin);
  mine->pair_end = pairs_from(p, 0, p->n_round, mine->end);
  mine->ghost = pairs_from(p, p->first_ghost, p->end_ghost, mine->begin);
  mine->ghost_end = pairs_from(p, p->first_ghost, p->end_ghost, mine->end);
  mine->piece = pairs_from(p, p->first_segment, p->count, mine->begin);
  mine->piece_end = pairs_from(p, p->first_segment, p->count, mine->end);
  clear_counts(f, mine);
  team_wait(t);
  count_own(f, mine);
  team_wait(t);
  take_away(f, t, false, false);
  take_away(f, t, true, false);
  for (size_t b = mine->begin; b < mine->end; b++) mine->entries += start[b + 2];
  team_wait(t);
  add_up(f, t);
  team_wait(t);
  take_away(f, t, false, true);
  fill_own(f, mine);
  take_away(f, t, true, true);
  team_wait(t);
  for (size_t i = mine->begin; e->halo && i < mine->end; i++) order_partners(e, i);
}

/* Enlarges the tables with a row per body, or per contact of a body, if they are too small. */
static sd_status reserve_tables(engine *e) {
  work *w = &e->work;
  incidence *n = &w->incidence;
  const size_t n_bodies = e->state->n_bodies, capacity = 2 * w->pairs.capacity;
  if (w->row && 2 * w->pairs.count <= n->capacity) return SD_OK;
  if (!memory_resize(3, (memory_column[]){{&n->start, n_bodies + 2, sizeof *n->start},
                                          {&n->entry, capacity, sizeof *n->entry},
                                          {&w->row, n_bodies + 1, sizeof *w->row}}))
    return SD_ERROR_IO;
  n->capacity = capacity;
  return SD_OK;
}

static sd_status list_incidence(engine *e) {
  const sd_state *s = e->state;
  const pairs *p = &e->work.pairs;
  const incidence *n = &e->work.incidence;
  assert(p->count <= UINT32_MAX / 2);
  incidence_task f = {.e = e};
  pool_run(work_pool(e), incidence_together, &f);
  bool failed = false;
  for (size_t t = 0; t < WORK_MAX_THREADS; t++) {
    failed |= f.share[t].away.failed;
    free(f.share[t].away.at);
  }
  if (failed) return SD_ERROR_IO;
  assert(n->start[s->n_bodies] <= 2 * p->count);
  assert(n->start[0] == 0 && n->start[s->n_bodies] == n->start[s->n_bodies + 1]);
  return SD_OK;
}

/* --- rows of packed bodies and force sums ----------------------------------------------------- */

size_t rows_of_bodies(const engine *e) {
  return e->work.chunks.rows + e->state->n_bodies - e->state->n_free + 1;
}

static sd_status reserve_rows(engine *e) {
  work *w = &e->work;
  if (rows_of_bodies(e) > w->packed_capacity) {
    arena_free(w->packed);
    w->packed_capacity = rows_of_bodies(e) + rows_of_bodies(e) / 4;
    w->packed = arena_for(w->packed_capacity, PACKED_ROW * sizeof *w->packed);
  }
  return w->packed ? SD_OK : SD_ERROR_IO;
}

/* Assigns rows to the free disks, and stores in each pair the offsets of the rows of its two
 * bodies. */
static void rows_together(const team *t, void *with) {
  engine *e = with;
  const size_t n_bodies = e->state->n_bodies, size = (size_t)t->size, rank = (size_t)t->rank;
  work *w = &e->work;
  const chunks *c = &w->chunks;
  pairs *p = &w->pairs;
  for (size_t k = c->count * rank / size; k < c->count * (rank + 1) / size; k++)
    for (size_t slot = c->begin[k]; slot < c->begin[k + 1]; slot++)
      w->row[slot] = (int32_t)(c->row[k] + slot - c->begin[k]);
  team_wait(t);
  size_t begin, end;
  team_share(t, p->count, &begin, &end);
  for (size_t k = begin; k < end; k++) {
    const bool nobody = p->a[k] < 0;
    const int32_t a = w->row[nobody ? n_bodies : (size_t)p->a[k]];
    const int32_t b = w->row[nobody ? n_bodies : (size_t)p->b[k]];
    PAIR(p, k, packed_a) = PACKED_ROW * a;
    PAIR(p, k, packed_b) = PACKED_ROW * b;
    PAIR(p, k, sum_a) = SUM_ROW * a;
    PAIR(p, k, sum_b) = SUM_ROW * b;
  }
}

/* Assigns rows to all bodies. Padding pairs get a row of their own, with position (0, 0) and radius
 * 0, so that they are never in contact. */
static sd_status list_rows(engine *e) {
  const size_t n_bodies = e->state->n_bodies, n_free = e->state->n_free;
  work *w = &e->work;
  const chunks *c = &w->chunks;
  if (reserve_rows(e) != SD_OK) return SD_ERROR_IO;
  assert(rows_of_bodies(e) <= INT32_MAX / PACKED_ROW && rows_of_bodies(e) <= w->packed_capacity);
  for (size_t slot = n_free; slot <= n_bodies; slot++)
    w->row[slot] = (int32_t)(c->rows + slot - n_free);
  assert((size_t)w->row[n_bodies] + 1 == rows_of_bodies(e)); /* the last row is that of padding */
  memset(w->packed + PACKED_ROW * (size_t)w->row[n_bodies], 0, PACKED_ROW * sizeof *w->packed);
  pool_run(work_pool(e), rows_together, e);
  return SD_OK;
}

/* Returns true if each contact of this body needs its own row of forces. This holds for prescribed
 * bodies, for disks with a held coordinate, and for disks with a contact that another thread
 * evaluates or that is with a ghost. */
static bool is_listed(const engine *e, size_t slot) {
  const work *w = &e->work;
  const incidence *n = &w->incidence;
  if (slot >= e->state->n_free) return true;
  if (w->columns[SD_X].inverse[slot] == 0.0 || w->columns[SD_Y].inverse[slot] == 0.0 ||
      w->columns[SD_THETA].inverse[slot] == 0.0)
    return true;
  for (size_t at = n->start[slot]; e->halo && at < n->start[slot + 1]; at++)
    if (halo_is_ghost(e, partner_of(&w->pairs, n->entry[at]))) return true;
  const int mine = w->n_threads > 1 ? chunks_thread_of_disk(e, slot) : 0;
  for (size_t at = n->start[slot]; w->n_threads > 1 && at < n->start[slot + 1]; at++)
    if (chunks_thread_of_pair(e, n->entry[at] / 2) != mine) return true;
  return false;
}

typedef struct listed_task {
  const engine *e;
  numbers found[WORK_MAX_THREADS];
} listed_task;

static void listed_together(const team *t, void *with) {
  listed_task *f = with;
  size_t begin, end;
  team_share(t, f->e->state->n_bodies, &begin, &end);
  for (size_t slot = begin; slot < end; slot++)
    if (is_listed(f->e, slot)) numbers_add(&f->found[t->rank], slot);
}

/* Joins the lists of all threads into m->listed, and makes room for as many entries in
 * m->single. */
static sd_status join_listed(const listed_task *f, sums *m) {
  size_t n = 0;
  for (size_t t = 0; t < WORK_MAX_THREADS; t++) {
    if (f->found[t].failed) return SD_ERROR_IO;
    n += f->found[t].n;
  }
  if (n + 1 > m->listed_capacity) {
    const size_t capacity = 2 * n + 16;
    if (!memory_resize(2, (memory_column[]){{&m->listed, capacity, sizeof *m->listed},
                                            {&m->single, capacity, sizeof *m->single}}))
      return SD_ERROR_IO;
    m->listed_capacity = capacity;
  }
  m->n_listed = 0;
  for (size_t t = 0; t < WORK_MAX_THREADS; t++)
    for (size_t k = 0; k < f->found[t].n; k++) m->listed[m->n_listed++] = f->found[t].at[k];
  return SD_OK;
}

/* Lists the bodies for which each contact has its own row of forces. Marks the chunks of such disks
 * as boundary_last: they are corrected after all threads have evaluated their pairs. */
static sd_status list_listed(engine *e) {
  work *w = &e->work;
  sums *m = &w->sums;
  listed_task f = {.e = e};
  pool_run(work_pool(e), listed_together, &f);
  const sd_status status = join_listed(&f, m);
  for (size_t t = 0; t < WORK_MAX_THREADS; t++) free(f.found[t].at);
  for (size_t k = 0; status == SD_OK && k < m->n_listed && m->listed[k] < e->state->n_free; k++) {
    assert(k == 0 || m->listed[k - 1] < m->listed[k]);
    chunks_mark_boundary_last(&w->chunks, m->listed[k]);
  }
  return status;
}

static sd_status reserve_sums(engine *e) {
  sums *m = &e->work.sums;
  const incidence *n = &e->work.incidence;
  size_t rows = rows_of_bodies(e);
  for (size_t k = 0; k < m->n_listed; k++)
    rows += n->start[m->listed[k] + 1] - n->start[m->listed[k]];
  if (rows > m->capacity) {
    arena_free(m->row);
    m->capacity = rows + rows / 4;
    m->row = arena_for(m->capacity, SUM_ROW * sizeof *m->row);
  }
  return m->row ? SD_OK : SD_ERROR_IO;
}

static sd_status list_sums(engine *e) {
  work *w = &e->work;
  sums *m = &w->sums;
  const incidence *n = &w->incidence;
  if (reserve_sums(e) != SD_OK) return SD_ERROR_IO;
  m->end = rows_of_bodies(e);
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
  pairs_clear_single(e); /* clears what the rows held for earlier lists */
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

size_t sums_first_listed(const sums *m, size_t slot) {
  size_t low = 0, high = m->n_listed;
  while (low < high) {
    size_t middle = (low + high) / 2;
    if (m->listed[middle] < slot)
      low = middle + 1;
    else
      high = middle;
  }
  assert(low == m->n_listed || m->listed[low] >= slot);
  return low;
}

void sums_clear_listed(engine *e, size_t begin, size_t end) {
  const sums *m = &e->work.sums;
  for (size_t n = sums_first_listed(m, begin); n < m->n_listed && m->listed[n] < end; n++)
    memset(m->row + SUM_ROW * m->single[n], 0,
           SUM_ROW * (m->single[n + 1] - m->single[n]) * sizeof *m->row);
}

void sums_add_listed(const engine *e, size_t begin, size_t end) {
  const work *w = &e->work;
  const sums *m = &w->sums;
  const size_t prescribed = e->halo ? e->state->n_free + e->state->n_ghosts : SIZE_MAX;
  for (size_t n = sums_first_listed(m, begin); n < m->n_listed && m->listed[n] < end; n++) {
    double *sum = m->row + SUM_ROW * (size_t)w->row[m->listed[n]];
    if (m->listed[n] >= prescribed) {
      halo_sum_prescribed(e->halo, m->listed[n] - prescribed, sum);
      continue;
    }
    for (size_t c = 0; c < SUM_ROW; c++) sum[c] = 0.0;
    for (size_t at = m->single[n]; at < m->single[n + 1]; at++)
      for (size_t c = 0; c < SUM_ROW; c++) sum[c] += m->row[SUM_ROW * at + c];
  }
}

sd_status pairs_list(engine *e) {
  work *w = &e->work;
  if (chunks_plan(e) != SD_OK || reserve_tables(e) != SD_OK) return SD_ERROR_IO;
  if (list_incidence(e) != SD_OK || list_listed(e) != SD_OK) return SD_ERROR_IO;
  chunks_plan_rows(&w->chunks, e->state->n_free);
  if (list_rows(e) != SD_OK) return SD_ERROR_IO;
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
}
