/* pairs.c: memory of the list of candidate pairs, and the contact records in it; implements
 * pairs.h. */
#include "physics/contact/pairs.h"

#include <string.h>

#include "base/memory.h"
#include "model/model.h"
#include "physics/system/list.h"

/* --- memory ----------------------------------------------------------------------------------- */

void pairs_free(pairs *p) {
  arena_free(p->a);
  arena_free(p->b);
  arena_free(p->part);
  arena_free(p->side);
  arena_free(p->block);
  arena_free(p->more);
  arena_free(p->flags);
  *p = (pairs){0};
}

/* Replaces a column by one of `capacity` elements of `size` bytes, and copies the first `count`
 * elements. */
static sd_status grow(void **column, size_t count, size_t capacity, size_t size) {
  void *more = arena_for(capacity, size);
  if (!more) return SD_ERROR_IO;
  if (*column) memcpy(more, *column, count * size);
  arena_free(*column);
  *column = more;
  return SD_OK;
}

/* Copies the columns a, b and part when they grow. The other columns are replaced without a copy,
 * since they are filled in only after all pairs are known. */
sd_status pairs_reserve(pairs *p, size_t count) {
  if (count <= p->capacity) return SD_OK;
  size_t capacity = (count + 2 * PAIR_BLOCK) / PAIR_BLOCK * PAIR_BLOCK;
  int32_t **whole[] = {&p->a, &p->b, &p->part};
  for (size_t k = 0; k < sizeof whole / sizeof *whole; k++)
    if (grow((void **)whole[k], p->count, capacity, sizeof(int32_t)) != SD_OK) return SD_ERROR_IO;
  arena_free(p->side);
  arena_free(p->block);
  arena_free(p->more);
  arena_free(p->flags);
  p->more = p->wants_more ? arena_for(capacity / PAIR_BLOCK, sizeof *p->more) : NULL;
  p->flags = arena_for(capacity, sizeof *p->flags);
  p->side = arena_for(capacity, sizeof *p->side);
  p->block = arena_for(capacity / PAIR_BLOCK, sizeof *p->block);
  const bool whole_too = p->side && p->block && p->flags && (p->more || !p->wants_more);
  p->capacity = whole_too ? capacity : 0;
  assert(p->capacity == 0 || (p->capacity >= count && p->capacity % PAIR_BLOCK == 0));
  return p->capacity ? SD_OK : SD_ERROR_IO;
}

sd_status pairs_fill_block(pairs *p) {
  if (pairs_reserve(p, p->count + PAIR_BLOCK) != SD_OK) return SD_ERROR_IO;
  for (; p->count % PAIR_BLOCK; p->count++) {
    p->a[p->count] = p->b[p->count] = PAIR_PADDING;
    p->part[p->count] = 0;
  }
  return SD_OK;
}

/* --- record of one pair ----------------------------------------------------------------------- */

void pairs_set_flags(pairs *p, size_t k, bool closed, int slide_sign) {
  pair_flags *flags = &p->flags[pairs_flags_at(p, k)];
  const unsigned bit = pairs_flag_bit(p, k);
  assert(k < p->count && p->a[k] != PAIR_PADDING);
  assert(slide_sign == 0 || (closed && (slide_sign == 1 || slide_sign == -1)));
  flags->closed = (uint8_t)((flags->closed & ~bit) | (closed ? bit : 0u));
  flags->slides_positive = (uint8_t)((flags->slides_positive & ~bit) | (slide_sign > 0 ? bit : 0u));
  flags->slides_negative = (uint8_t)((flags->slides_negative & ~bit) | (slide_sign < 0 ? bit : 0u));
}

sd_contact_record pairs_record(const pairs *p, size_t k) {
  sd_contact_record found;
  double row[SD_CONTACT_ALL] = {0};
  for (size_t c = 0; c < SD_CONTACT_COLUMNS; c++) row[c] = PAIR(p, k, record[c]);
  for (size_t c = 0; p->more && c < SD_CONTACT_EXTRA; c++)
    row[SD_CONTACT_COLUMNS + c] = MORE(p, k, record[c]);
  memcpy(&found, row, sizeof found);
  return found;
}

void pairs_set_record(pairs *p, size_t k, const sd_contact_record *record) {
  double row[SD_CONTACT_ALL];
  assert(k < p->count && p->a[k] != PAIR_PADDING);
  memcpy(row, record, sizeof row);
  for (size_t c = 0; c < SD_CONTACT_COLUMNS; c++) PAIR(p, k, record[c]) = row[c];
  for (size_t c = 0; p->more && c < SD_CONTACT_EXTRA; c++)
    MORE(p, k, record[c]) = row[SD_CONTACT_COLUMNS + c];
}

/* --- rare events ------------------------------------------------------------------------------ */

event *event_add(event_list *list, uint32_t index) {
  if (!list_room(&list->item, list->count, &list->capacity, sizeof *list->item)) {
    list->failed = true;
    return NULL;
  }
  assert(list->count < list->capacity);
  list->item[list->count] = (event){.index = index};
  return &list->item[list->count++];
}

void crossing_add(crossing_list *list, const crossing *c) {
  if (list_room(&list->item, list->count, &list->capacity, sizeof *list->item))
    list->item[list->count++] = *c;
  else
    list->failed = true;
}

void event_add_pair(event_list *list, const pairs *p, size_t k, const event *v) {
  assert(k < p->count && p->a[k] != PAIR_PADDING);
  event *added = event_add(list, (uint32_t)k);
  if (!added) return;
  *added = *v;
  added->index = (uint32_t)k;
}

/* --- from one list to the next ---------------------------------------------------------------- */

static bool same_pair(const pairs *p, size_t k, const pairs *q, size_t n) {
  return p->a[k] == q->a[n] && p->b[k] == q->b[n] && p->part[k] == q->part[n];
}

/* Returns true if pair k of p comes before pair n of q in the order of pairs: by slot of a, then
 * slot of b, then segment. */
static bool stands_before(const pairs *p, size_t k, const pairs *q, size_t n) {
  if (p->a[k] != q->a[n]) return p->a[k] < q->a[n];
  if (p->b[k] != q->b[n]) return p->b[k] < q->b[n];
  return p->part[k] < q->part[n];
}

/* Moves the contact record of pair k in the old list to pair n in the new one. The losses of the
 * old record are set to 0, so that losses which remain in the old list belong to contacts that
 * ended. */
static void carry_pair(pairs *from, size_t k, pairs *to, size_t n) {
  for (size_t c = 0; c < SD_CONTACT_COLUMNS; c++) PAIR(to, n, record[c]) = PAIR(from, k, record[c]);
  for (size_t c = 0; from->more && c < SD_CONTACT_EXTRA; c++)
    MORE(to, n, record[c]) = MORE(from, k, record[c]);
  to->side[n] = from->side[k];
  pairs_set_flags(to, n, true, pairs_slide_sign(from, k));
  PAIR(from, k, viscous) = PAIR(from, k, friction) = PAIR(from, k, nonconservative_work) = 0.0;
  if (from->more) MORE(from, k, rolling) = 0.0;
}

/* Returns the first pair in [k, end) of p that does not come before pair n of q; `end` if there is
 * none. */
static size_t first_from(const pairs *p, size_t k, size_t end, const pairs *q, size_t n) {
  while (k < end) {
    const size_t middle = k + (end - k) / 2;
    if (stands_before(p, middle, q, n))
      k = middle + 1;
    else
      end = middle;
  }
  return k;
}

/* Moves the records of closed contacts in [from_begin, from_end) of the old list to the same pairs
 * in [begin, end) of the new list. Both lists are in the same order, so they are passed through
 * only once. */
static void carry(pairs *from, pairs *to, size_t from_begin, size_t from_end, size_t begin,
                  size_t end) {
  if (begin >= end) return;
  size_t k = first_from(from, from_begin, from_end, to, begin);
  for (size_t n = begin; n < end; n++) {
    while (k < from_end && stands_before(from, k, to, n)) k++;
    if (k == from_end) return;
    if (same_pair(from, k, to, n) && pairs_closed(from, k)) carry_pair(from, k, to, n);
  }
}

/* Returns the row of the table of contact laws for pair k; 0 for padding. */
static int32_t law_of(const engine *e, const pairs *p, size_t k) {
  const int32_t *material = e->state->material;
  if (p->a[k] < 0) return 0;
  return material[p->a[k]] * (int32_t)e->model->n_materials + material[p->b[k]];
}

typedef struct finish_task {
  const engine *e;
  pairs *from, *to;
} finish_task;

static size_t least(size_t a, size_t b) { return a < b ? a : b; }
static size_t most(size_t a, size_t b) { return a > b ? a : b; }

/* Clears the columns of the new list, sets the law of each pair and moves the contact records;
 * called by all threads. Each thread has a range of whole blocks, so that no two threads write into
 * one block. */
static void finish_together(const team *t, void *with) {
  const finish_task *f = with;
  pairs *from = f->from, *to = f->to;
  size_t begin, end;
  team_share(t, to->first_segment / PAIR_BLOCK + (to->count - to->first_segment), &begin, &end);
  memset(to->flags + begin, 0, (end - begin) * sizeof *to->flags);
  team_share(t, to->count, &begin, &end);
  const size_t block = begin / PAIR_BLOCK, blocks = (end + PAIR_BLOCK - 1) / PAIR_BLOCK - block;
  if (begin < end) memset(to->block + block, 0, blocks * sizeof *to->block);
  if (begin < end && to->more) memset(to->more + block, 0, blocks * sizeof *to->more);
  memset(to->side + begin, 0, (end - begin) * sizeof *to->side);
  for (size_t k = begin; k < end; k++) PAIR(to, k, law) = law_of(f->e, to, k);
  team_wait(t); /* all flags must be cleared before records are carried over */
  carry(from, to, 0, from->n_round, begin, least(end, to->n_round));
  carry(from, to, from->first_segment, from->count, most(begin, to->first_segment), end);
}

sd_status pairs_finish(const engine *e, pairs *from, pairs *to) {
  assert(from != to && to->first_segment % PAIR_BLOCK == 0);
  assert(to->n_round <= to->first_ghost && to->end_ghost <= to->first_segment);
  /* with several ranks a new engine is built for each list, so there is no old list */
  assert(!e->halo || from->count == 0);
  if (pairs_reserve(to, to->count + 1) != SD_OK) return SD_ERROR_IO;
  pool_run(work_pool(e), finish_together, &(finish_task){e, from, to});
  assert(to->count <= to->capacity);
  return SD_OK;
}
