/* slot_table.c: table of the slots of bodies, an array or a hash table; see slot_table.h. */
#include "model/slot_table.h"

#include <assert.h>
#include <stdlib.h>

#include "base/memory.h"

void slot_table_free(slot_table *t) {
  free(t->slot);
  free(t->body);
  *t = (slot_table){0};
}

void slot_table_fill(slot_table *t, const sd_state *s) {
  for (uint32_t k = 0; t->body && k <= t->mask; k++) t->body[k] = SLOT_NONE;
  for (uint32_t i = 0; i < s->n_bodies; i++) {
    uint32_t k = t->body ? slot_table_home(t, s->id[i]) : s->id[i];
    assert(s->id[i] < t->n_bodies);
    while (t->body && t->body[k] != SLOT_NONE) {
      assert(t->body[k] != s->id[i]);
      k = (k + 1) & t->mask;
    }
    if (t->body) t->body[k] = s->id[i];
    t->slot[k] = i;
  }
  for (uint32_t c = 0; c < s->n_clumps; c++) t->slot[s->n_bodies + c] = (uint32_t)s->n_bodies + c;
}

bool slot_table_new(slot_table *t, const sd_state *s, size_t n_bodies) {
  size_t n = n_bodies + s->n_clumps, entries = 0;
  *t = (slot_table){.n_bodies = n_bodies};
  assert(s->n_bodies <= n_bodies && (s->n_bodies == n_bodies || s->n_clumps == 0));
  assert(s->n_bodies <= UINT32_MAX / 4);
  if (s->n_bodies < n_bodies) {
    t->shift = 31;
    for (n = 16; n < 2 * s->n_bodies; n *= 2) t->shift--;
    entries = n;
  }
  if (!memory_resize_row(&t->slot, n, sizeof *t->slot)) return false;
  if (entries > 0 && !memory_resize_row(&t->body, entries, sizeof *t->body)) {
    slot_table_free(t);
    return false;
  }
  t->mask = (uint32_t)(n - 1);
  slot_table_fill(t, s);
  return true;
}
