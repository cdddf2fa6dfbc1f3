/* pairs.h: room for candidate pairs, and their memory from one list to the next. */
#ifndef PHYSICS_PAIRS_H
#define PHYSICS_PAIRS_H

#include "physics/system/work.h"

/* All return SD_ERROR_IO without memory. */
void pairs_free(pairs *p);
/* Room for so many; memories of those that are there are lost where it has to grow. */
sd_status pairs_reserve(pairs *p, size_t count);
/* Adds a pair; a = b = PAIR_OF_NOBODY fills up. */
enum { PAIR_OF_NOBODY = -1 };
sd_status pairs_push(pairs *p, int32_t a, int32_t b, int32_t part);
/* The round ones are complete: what follows begins with a whole block. */
sd_status pairs_end_round(pairs *p);
/* All are pushed: fills laws, and memories with that of the same pairs in `from`, whose losses go along. */
sd_status pairs_finish(const engine *e, pairs *from, pairs *to);

static inline bool pairs_closed(const pairs *p, size_t k) {
  return PAIR(p, k, ex) != 0.0 || PAIR(p, k, ey) != 0.0;
}

#endif
