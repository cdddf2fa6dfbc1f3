/* list.h: lists that grow in a step or while lists of neighbours are made, with the system. */
#ifndef PHYSICS_LIST_H
#define PHYSICS_LIST_H

#include <stdint.h>

#include "base/memory.h"

/* Room for one more behind n elements of the list whose pointer stands at `list`. False: there is
 * no memory. */
static inline bool list_room(void *list, size_t n, size_t *capacity, size_t size) {
  if (n < *capacity) return true;
  const size_t more = 2 * n + 64;
  if (!memory_resize_row(list, more, size)) return false;
  *capacity = more;
  return true;
}

/* --- growing lists of bodies or pairs, which may be as long as the system is large ------------ */

/* Begins with {0}; goes with free(at). */
typedef struct numbers {
  uint32_t *at;
  size_t n, capacity;
  bool failed; /* no memory: some are missing */
} numbers;

static inline void numbers_add(numbers *l, size_t k) {
  l->failed = l->failed || !list_room(&l->at, l->n, &l->capacity, sizeof *l->at);
  if (!l->failed) l->at[l->n++] = (uint32_t)k;
}

#endif
