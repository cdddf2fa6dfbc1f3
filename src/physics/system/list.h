/* list.h: lists that grow in a step or while lists of neighbours are made, with the system. */
#ifndef PHYSICS_LIST_H
#define PHYSICS_LIST_H

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

#endif
