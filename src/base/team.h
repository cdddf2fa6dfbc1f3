/* team.h: the threads that advance one simulation together, all in the same code.
 *
 * Work is shared by contiguous ranges, and each loop writes only its own indices, so results do not depend
 * on the number of threads. A team of one costs nothing.
 */
#ifndef BASE_TEAM_H
#define BASE_TEAM_H

#include <stddef.h>

typedef struct team {
  int rank, size;
} team;

/* This thread's part [*begin, *end) of n items, in multiples of 8 so that vectors are not split. */
static inline void team_share(const team *t, size_t n, size_t *begin, size_t *end) {
  if (t->size == 1) {
    *begin = 0;
    *end = n;
    return;
  }
  size_t blocks = (n + 7) / 8, size = (size_t)t->size, rank = (size_t)t->rank;
  *begin = blocks * rank / size * 8;
  *end = blocks * (rank + 1) / size * 8;
  if (*begin > n) *begin = n;
  if (*end > n) *end = n;
}

/* Waits for the whole team; what was written before is seen after. */
static inline void team_wait(const team *t) {
  if (t->size == 1) return;
#ifdef _OPENMP
#pragma omp barrier
#endif
}

#endif
