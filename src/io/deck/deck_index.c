/* deck_index.c: numbers by name, so that many names cost no more than their sum. See deck_tree.h. */
#include <string.h>

#include "io/deck/deck_read.h"

/* Beyond so many names no nearest one is looked for. */
enum { MOST_GUESSES = 10000 };

/* The slot of the name, or the empty one where it belongs: 1 + its place among the names. */
static size_t *slot_of(const deck_index *x, const char *name) {
  uint64_t h = UINT64_C(14695981039346656037);
  for (const char *p = name; *p; p++) h = (h ^ (unsigned char)*p) * UINT64_C(1099511628211);
  size_t k = (size_t)(h ^ h >> 32) & (x->n_slots - 1);
  while (x->slot[k] && strcmp(x->name[x->slot[k] - 1].name, name) != 0) k = (k + 1) & (x->n_slots - 1);
  return &x->slot[k];
}

bool deck_index_find(const deck_index *x, const char *name, uint32_t *number) {
  size_t at = x->n ? *slot_of(x, name) : 0;
  if (at) *number = x->name[at - 1].number;
  return at > 0;
}

bool deck_index_add(deck *d, deck_index *x, const char *name, uint32_t number) {
  if (2 * x->n >= x->n_slots) {
    x->n_slots = x->n_slots ? 2 * x->n_slots : 64;
    x->slot = deck_alloc(d, x->n_slots, sizeof *x->slot);
    for (size_t k = 0; k < x->n; k++) *slot_of(x, x->name[k].name) = k + 1;
  }
  size_t *at = slot_of(x, name);
  if (*at) return false;
  x->name = deck_extend(d, x->name, x->n, &x->capacity, sizeof *x->name);
  x->name[x->n++] = (deck_name){name, number};
  *at = x->n;
  return true;
}

void deck_index_guess(const deck *d, const deck_index *x, guess *near) {
  for (size_t k = 0; k < x->n && k < MOST_GUESSES && !deck_told(d); k++) guess_add(near, x->name[k].name);
}

const char *deck_index_list(deck *d, const deck_index *x) {
  enum { FEW = 8 };
  const char *text = "", *before = x->n == 1 ? "; there is " : "; there are ";
  for (size_t k = 0; k < x->n && x->n <= FEW && !deck_told(d); k++) {
    const char *name = x->name[k].name;
    text = deck_format(d, "%s%s\"%s\"", text, before, deck_quote(d, name, strlen(name)));
    before = k + 2 < x->n ? ", " : " and ";
  }
  return text;
}

bool deck_index_look_up(deck *d, const deck_index *x, const char *what, const deck_node *node,
                        const char *remark, uint32_t *number) {
  const char *name = node->type == DECK_STRING ? node->value.text : "";
  if (deck_index_find(x, name, number)) return true;
  guess near = guess_start(name);
  deck_index_guess(d, x, &near);
  deck_fail(d, node, "no %s is called that%s%s", what,
            near.best ? deck_hint(d, &near) : deck_index_list(d, x), near.best ? "" : remark);
  return false;
}
