/* list.h: growing lists, for use within a step or while neighbour lists are built. */
#ifndef PHYSICS_LIST_H
#define PHYSICS_LIST_H

#include <stdint.h>

#include "base/memory.h"

/* Makes sure that a list of n elements has memory for one more; the list may move. list: address of
 * the pointer to the first element; size: bytes per element. Returns false if there is no
 * memory. */
static inline bool list_room(void *list, size_t n, size_t *capacity, size_t size) {
  if (n < *capacity) return true;
  const size_t more = 2 * n + 64;
  if (!memory_resize_row(list, more, size)) return false;
  *capacity = more;
  return true;
}

/* --- growing lists of bodies or pairs, which may be as long as the system is large ------------ */

/* Growing list of 32-bit integers. Initialise it with {0}; release it with free(at). */
typedef struct numbers {
  uint32_t *at;
  size_t n, capacity;
  bool failed; /* true: memory ran out, and some numbers are missing */
} numbers;

/* Appends k to the list; if memory runs out, sets l->failed instead. */
static inline void numbers_add(numbers *l, size_t k) {
  l->failed = l->failed || !list_room(&l->at, l->n, &l->capacity, sizeof *l->at);
  if (!l->failed) l->at[l->n++] = (uint32_t)k;
}

#endif
