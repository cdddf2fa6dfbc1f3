/* slot_table.h: the slot of each body that a state has, by the body's number.
 *
 * It is an array if all bodies are here. A rank with some of them has a hash table (open addressing),
 * so that nothing on a rank is as large as the whole. Numbers on a rank are runs, such as rows of a
 * packing: blocks of 8 stay together, and are spread by the product with an odd number (Knuth's
 * multiplicative hashing).
 */
#ifndef MODEL_SLOT_TABLE_H
#define MODEL_SLOT_TABLE_H

#include "model/state.h"

#define SLOT_NONE UINT32_MAX

typedef struct slot_table {
  uint32_t *slot; /* of a body, or of an entry */
  uint32_t *body; /* of an entry, SLOT_NONE: it is empty; NULL: slot[body] */
  uint32_t mask;  /* entries are a power of two, less 1 */
  int shift;      /* 32 less the bits of a block's number in the table */
  size_t n_bodies;
} slot_table;

/* n_bodies: of the model. Clumps stand behind them. False: no memory. */
bool slot_table_new(slot_table *t, const sd_state *state, size_t n_bodies);
void slot_table_free(slot_table *t);
/* Anew, when the same bodies stand in other slots. */
void slot_table_fill(slot_table *t, const sd_state *state);

/* The entry where a body stands if no other one does. */
static inline uint32_t slot_table_home(const slot_table *t, uint32_t body) {
  return (body / 8 * UINT32_C(2654435769) >> t->shift) * 8 + body % 8;
}

/* SLOT_NONE: the body is not here. */
static inline uint32_t slot_of(const slot_table *t, uint32_t body) {
  if (!t->body) return t->slot[body];
  uint32_t k = slot_table_home(t, body);
  while (t->body[k] != body && t->body[k] != SLOT_NONE) k = (k + 1) & t->mask;
  return t->body[k] == body ? t->slot[k] : SLOT_NONE;
}

#endif
