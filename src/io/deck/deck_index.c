/* deck_index.c: numbers by name, so that many names cost no more than their sum. See deck.h. */
#include <string.h>

#include "io/deck/deck.h"

/* The slot of the name, or the empty one where it belongs. */
static deck_name *slot_of(const deck_index *x, const char *name) {
  uint64_t h = UINT64_C(14695981039346656037);
  for (const char *p = name; *p; p++) h = (h ^ (unsigned char)*p) * UINT64_C(1099511628211);
  size_t k = (size_t)(h ^ h >> 32) & (x->capacity - 1);
  while (x->slot[k].name && strcmp(x->slot[k].name, name) != 0) k = (k + 1) & (x->capacity - 1);
  return &x->slot[k];
}

bool deck_index_find(const deck_index *x, const char *name, uint32_t *number) {
  const deck_name *at = x->n ? slot_of(x, name) : NULL;
  if (!at || !at->name) return false;
  *number = at->index;
  return true;
}

bool deck_index_add(deck *d, deck_index *x, const char *name, uint32_t number) {
  if (2 * x->n >= x->capacity) {
    deck_index grown = {.n = x->n, .capacity = x->capacity ? 2 * x->capacity : 64};
    grown.slot = deck_alloc(d, grown.capacity, sizeof *grown.slot);
    for (size_t k = 0; k < x->capacity; k++)
      if (x->slot[k].name) *slot_of(&grown, x->slot[k].name) = x->slot[k];
    *x = grown;
  }
  deck_name *at = slot_of(x, name);
  if (at->name) return false;
  *at = (deck_name){name, number};
  x->n++;
  return true;
}
