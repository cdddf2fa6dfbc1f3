/* slot_table.h: finds the slot of a body in a state from the body's number.
 *
 * The table is an array if the state has all bodies. A rank with some of them uses a hash table
 * (open addressing), so that its memory does not grow with the whole system. The numbers on a
 * rank form runs, such as rows of a packing: blocks of 8 numbers stay together in the table, and
 * blocks are spread by multiplication with an odd number (Knuth's multiplicative hashing).
 */
#ifndef MODEL_SLOT_TABLE_H
#define MODEL_SLOT_TABLE_H

#include "model/state.h"

#define SLOT_NONE UINT32_MAX

typedef struct slot_table {
  uint32_t *slot; /* array: slot of each body; hash table: slot of each entry */
  /* Body number of each entry, SLOT_NONE: empty. NULL: the table is the array slot[body]. */
  uint32_t *body;
  uint32_t mask;   /* hash table: number of entries, a power of two, minus 1 */
  int shift;       /* hash table: 32 minus the number of bits of a block's index */
  size_t n_bodies; /* number of bodies in the model; clumps have the numbers that follow */
} slot_table;

/* Makes the table for the bodies and clumps of `state`; n_bodies: number of bodies in the model,
 * which clump numbers follow. False: out of memory. */
bool slot_table_new(slot_table *t, const sd_state *state, size_t n_bodies);
void slot_table_free(slot_table *t);
/* Updates the table after the same bodies have changed their slots. */
void slot_table_fill(slot_table *t, const sd_state *state);

/* Entry at which the search for a body begins. */
static inline uint32_t slot_table_home(const slot_table *t, uint32_t body) {
  return (body / 8 * UINT32_C(2654435769) >> t->shift) * 8 + body % 8;
}

/* Returns the slot of a body; SLOT_NONE: the state does not have it. */
static inline uint32_t slot_of(const slot_table *t, uint32_t body) {
  if (!t->body) return t->slot[body];
  uint32_t k = slot_table_home(t, body);
  while (t->body[k] != body && t->body[k] != SLOT_NONE) k = (k + 1) & t->mask;
  return t->body[k] == body ? t->slot[k] : SLOT_NONE;
}

#endif
