/* slot_table.h: the slot of each body that a state has, by the body's number.
 *
 * Where all bodies are here it is an array; of a rank's part, a hash table (open addressing), so that nothing on a rank is
 * as large as the whole.
 */
#ifndef MODEL_SLOT_TABLE_H
#define MODEL_SLOT_TABLE_H

#include "model/state.h"

#define SLOT_NONE UINT32_MAX

typedef struct slot_table {
  uint32_t *slot; /* of a body, or of an entry */
  uint32_t *body; /* of an entry, SLOT_NONE: it is empty; NULL: slot[body] */
  uint32_t mask;  /* entries are a power of two, less 1 */
} slot_table;

/* Of a model with so many bodies, and of its clumps, which stand behind them. False: no memory. */
bool slot_table_new(slot_table *t, const sd_state *state, size_t n_bodies);
void slot_table_free(slot_table *t);
/* Anew, when the same bodies stand in other slots. */
void slot_table_fill(slot_table *t, const sd_state *state);

/* SLOT_NONE: the body is not here. */
static inline uint32_t slot_of(const slot_table *t, uint32_t body) {
  if (!t->body) return t->slot[body];
  uint32_t k = body & t->mask;
  while (t->body[k] != body && t->body[k] != SLOT_NONE) k = (k + 1) & t->mask;
  return t->body[k] == body ? t->slot[k] : SLOT_NONE;
}

#endif
