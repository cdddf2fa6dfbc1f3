/* numbers.h: growing lists of bodies or pairs, which may be as long as the system is large. */
#ifndef PHYSICS_NUMBERS_H
#define PHYSICS_NUMBERS_H

#include <stdint.h>

#include "base/memory.h"

/* Begins with {0}; goes with free(at). */
typedef struct numbers {
  uint32_t *at;
  size_t n, capacity;
  bool failed; /* no memory: some are missing */
} numbers;

static inline void numbers_add(numbers *l, size_t k) {
  if (l->n == l->capacity) {
    const size_t capacity = 2 * l->capacity + 64;
    l->failed = l->failed || !memory_resize(1, &(memory_column){&l->at, capacity, sizeof *l->at});
    if (l->failed) return;
    l->capacity = capacity;
  }
  l->at[l->n++] = (uint32_t)k;
}

#endif
