/* deck_compare.c: finds the keys in which two decks differ; see deck.h.
 *
 * The full decks (with all defaults) are compared key by key, and not line by line: a line holds
 * many keys, and the user wants to know which -D setting is missing. Full decks have no group
 * `sweep`, so a different sweep is no difference. A key that the other deck lacks is no difference
 * either if it has its default value here: the program that wrote the other deck did not know the
 * key. */
#include <string.h>

#include "base/memory.h"
#include "base/text.h"
#include "io/deck/deck.h"
#include "io/deck/deck_read.h"
#include "io/deck/deck_tree.h"

enum { LONGEST_VALUE = 60 };

typedef struct comparison {
  deck_difference *tell;
  void *user;
  const char *here;      /* Text of the second deck, `here` in deck_compare */
  const deck_node *root; /* Tree of the first deck, `there` in deck_compare */
  deck *d;               /* Second deck; its arena is used */
  /* True: titles may differ. False: they must be equal, as for a run that is continued */
  bool any_title;
} comparison;

/* --- trees ------------------------------------------------------------------------------------ */

static bool is_number(const deck_node *n) { return n->type == DECK_INT || n->type == DECK_FLOAT; }

static double number_of(const deck_node *n) {
  return n->type == DECK_INT ? (double)n->value.integer : n->value.number;
}

static bool same_scalar(const deck_node *a, const deck_node *b) {
  if (is_number(a) && is_number(b) && a->type != b->type) return number_of(a) == number_of(b);
  if (a->type != b->type) return false;
  if (a->type == DECK_BOOL) return a->value.flag == b->value.flag;
  if (a->type == DECK_INT) return a->value.integer == b->value.integer;
  if (a->type == DECK_FLOAT) return a->value.number == b->value.number;
  return strcmp(a->value.text, b->value.text) == 0;
}

static bool is_scalar(const deck_node *n) { return n->type != DECK_GROUP && n->type != DECK_LIST; }

/* Returns a value as text for messages, such as "3.5", "(1.0, 2.0)" or "4 entries"; NULL if n is
 * NULL. */
static const char *value_text(deck *d, const deck_node *n) {
  if (!n) return NULL;
  if (n->type == DECK_LIST && n->n > 0 && !is_scalar(n->child[0]))
    return deck_format(d, "%zu %s", n->n, n->n == 1 ? "entry" : "entries");
  const char *text = deck_value_text(d, n);
  return strlen(text) <= LONGEST_VALUE ? text : deck_format(d, "%.*s ...", LONGEST_VALUE, text);
}

static void differ(const comparison *c, const char *path, const deck_node *there,
                   const deck_node *here) {
  c->tell(c->user, path, value_text(c->d, there), value_text(c->d, here));
}

static bool is_ignored(const comparison *c, const deck_node *child) {
  if (!child->name || child->parent->parent) return false;
  return strcmp(child->name, "checkpoint") == 0 ||
         (c->any_title && strcmp(child->name, "title") == 0);
}

/* Returns true if a key has its default value. Callers then ignore that the other deck lacks the
 * key, since an older version of the program may not have known it. */
static bool is_default(deck *d, const deck_node *n) {
  const char *table = "";
  for (const deck_node *group = n->parent; group && group->parent; group = group->parent)
    if (group->name) table = *table ? deck_format(d, "%s.%s", group->name, table) : group->name;
  const deck_key *key = NULL;
  for (size_t t = 0; t < deck_table_count; t++)
    if (strcmp(deck_tables[t]->name, *table ? table : deck_top.name) == 0)
      key = deck_key_find(deck_tables[t], n->name);
  return key && strcmp(deck_value_text(d, n), key->initial) == 0;
}

static void compare(const comparison *c, const char *path, const deck_node *there,
                    const deck_node *here);

static const char *path_of(deck *d, const char *path, const char *name) {
  return *path ? deck_format(d, "%s.%s", path, name) : name;
}

static void compare_groups(const comparison *c, const char *path, const deck_node *there,
                           const deck_node *here) {
  for (size_t k = 0; k < there->n; k++) {
    const deck_node *child = there->child[k], *match = deck_child(here, child->name);
    if (is_ignored(c, child)) continue;
    const char *name = path_of(c->d, path, child->name);
    if (match)
      compare(c, name, child, match);
    else
      differ(c, name, child, NULL);
  }
  for (size_t k = 0; k < here->n; k++) {
    const deck_node *child = here->child[k];
    if (!deck_child(there, child->name) && !is_ignored(c, child) && !is_default(c->d, child))
      differ(c, path_of(c->d, path, child->name), NULL, child);
  }
}

/* Returns the path of entry k of a list as written after -D: PATH.NAME if the entry has the same
 * name in both decks, else PATH[k]. */
static const char *entry_path(deck *d, const char *path, size_t k, const deck_node *there,
                              const deck_node *here) {
  const deck_node *a = there->type == DECK_GROUP ? deck_child(there, "name") : NULL,
                  *b = here->type == DECK_GROUP ? deck_child(here, "name") : NULL;
  if (a && b && a->type == DECK_STRING && same_scalar(a, b))
    return deck_format(d, "%s.%s", path, a->value.text);
  return deck_format(d, "%s[%zu]", path, k);
}

static void compare(const comparison *c, const char *path, const deck_node *there,
                    const deck_node *here) {
  bool groups = there->type == DECK_GROUP && here->type == DECK_GROUP,
       lists = there->type == DECK_LIST && here->type == DECK_LIST && there->n == here->n;
  if (groups) {
    compare_groups(c, path, there, here);
  } else if (lists && there->n > 0 && !is_scalar(there->child[0])) {
    for (size_t k = 0; k < there->n; k++)
      compare(c, entry_path(c->d, path, k, there->child[k], here->child[k]), there->child[k],
              here->child[k]);
  } else {
    bool same = is_scalar(there) && is_scalar(here) && same_scalar(there, here);
    for (size_t k = 0; lists && (k == 0 || same) && k < there->n; k++)
      same = is_scalar(there->child[k]) && is_scalar(here->child[k]) &&
             same_scalar(there->child[k], here->child[k]);
    if (!same && !(lists && there->n == 0)) differ(c, path, there, here);
  }
}

/* --- two decks -------------------------------------------------------------------------------- */

static sd_status with_both(deck *d, void *user) {
  comparison *c = user;
  c->d = d;
  if (d->root && c->root) compare(c, "", c->root, d->root);
  return d->root ? SD_OK : SD_ERROR_USER;
}

static sd_status with_one(deck *d, void *user) {
  comparison *c = user;
  c->root = d->root;
  return d->root ? deck_open(c->here, "this deck", 0, NULL, with_both, c, NULL) : SD_ERROR_USER;
}

bool deck_compare(const char *there, const char *here, bool any_title, deck_difference *tell,
                  void *user) {
  comparison c = {.here = here, .any_title = any_title, .tell = tell, .user = user};
  return deck_open(there, "that deck", 0, NULL, with_one, &c, NULL) == SD_OK;
}

char *deck_difference_text(const char *path, const char *there, const char *here) {
  if (!there && !here) return memory_text(path);
  if (!there) return format_text("%s: not there, %s here", path, here);
  if (!here) return format_text("%s: %s there, not here", path, there);
  return format_text("%s: %s there, %s here", path, there, here);
}
