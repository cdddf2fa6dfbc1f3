/* pairs.c: see pairs.h. */
#include "physics/contact/pairs.h"

#include <stdlib.h>
#include <string.h>

#include "base/room.h"

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
