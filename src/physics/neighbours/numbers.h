/* numbers.h: growing lists of bodies or pairs, which may be as long as the system is large. */
#ifndef PHYSICS_NUMBERS_H
#define PHYSICS_NUMBERS_H

#include <stdint.h>

#include "physics/system/list.h"

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
