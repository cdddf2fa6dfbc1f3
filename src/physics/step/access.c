/* access.c: see access.h. */
#include "physics/step/access.h"

int64_t engine_watched(const engine *e, size_t k) {
  const pairs *p = &e->work.pairs;
  int64_t first = e->work.watched[k];
  if (first < 0) return -1;
  int64_t pressed = first;
  if ((size_t)first >= p->n_round)
    for (size_t at = (size_t)first; at < p->count && p->a[at] == p->a[first] && p->b[at] == p->b[first]; at++)
      if (engine_contact_force(e, at) > engine_contact_force(e, (size_t)pressed) ||
          !engine_contact_closed(e, (size_t)pressed))
        pressed = (int64_t)at;
  return engine_contact_closed(e, (size_t)pressed) ? pressed : -1;
}
