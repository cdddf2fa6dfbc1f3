/* sweep_diff.c: which keys another deck says otherwise, of a point, and of many; see sweep.h.
 *
 * Full decks are compared key by key, and not line by line: a line holds many keys, and what the user wants to know is
 * which -D is missing. What another sweep says of the same point is no difference, since full decks have no sweep.
 */
#include <stdlib.h>
#include <string.h>

#include "io/deck/deck.h"
#include "io/store/file.h"
#include "run/deck_diff.h"
#include "run/sweep_private.h"

/* Differences that are kept of a point, and of many together; letters of a value that are told. */
enum { MOST_KEPT = 20, MOST_TOLD = 20, LONGEST_VALUE = 60 };

typedef struct comparison {
  sweep_result *r;
  const char *other; /* the other deck, and its tree */
  const deck_node *there;
  deck *d;        /* of this deck, for memory */
  bool any_title; /* a run that was begun goes on with its title only */
} comparison;

/* False: no memory. A missing value is NULL. */
static bool add(sweep_result *r, const char *path, const char *there, const char *here) {
  sweep_difference *grown = realloc(r->differences, (r->n_differences + 1) * sizeof *grown);
  if (!grown) return false;
  r->differences = grown;
  sweep_difference one = {file_path("%s", path), there ? file_path("%s", there) : NULL,
                          here ? file_path("%s", here) : NULL};
  grown[r->n_differences++] = one;
  return one.path && (one.there || !there) && (one.here || !here);
}

/* --- trees -------------------------------------------------------------------------------------------------- */

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

/* "3.5", "(1.0, 2.0)", "4 entries" */
static const char *value_text(deck *d, const deck_node *n) {
  if (!n) return NULL;
  if (n->type == DECK_LIST && n->n > 0 && !is_scalar(n->child[0]))
    return deck_format(d, "%zu %s", n->n, n->n == 1 ? "entry" : "entries");
  const char *text = deck_value_text(d, n);
  return strlen(text) <= LONGEST_VALUE ? text : deck_format(d, "%.*s ...", LONGEST_VALUE, text);
}

static void tell(const comparison *c, const char *path, const deck_node *there, const deck_node *here) {
  if (c->r->n_differences < MOST_KEPT) add(c->r, path, value_text(c->d, there), value_text(c->d, here));
}

static bool is_ignored(const comparison *c, const deck_node *child) {
  if (!child->name || child->parent->parent) return false;
  return strcmp(child->name, "checkpoint") == 0 || (c->any_title && strcmp(child->name, "title") == 0);
}

static void compare(const comparison *c, const char *path, const deck_node *there, const deck_node *here);

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
      tell(c, name, child, NULL);
  }
  for (size_t k = 0; k < here->n; k++) {
    const deck_node *child = here->child[k];
    if (!deck_child(there, child->name) && !is_ignored(c, child))
      tell(c, path_of(c->d, path, child->name), NULL, child);
  }
}

/* As -D would name an entry of a list: by its name when it has one. */
static const char *entry_path(deck *d, const char *path, size_t k, const deck_node *there,
                              const deck_node *here) {
  const deck_node *a = there->type == DECK_GROUP ? deck_child(there, "name") : NULL,
                  *b = here->type == DECK_GROUP ? deck_child(here, "name") : NULL;
  if (a && b && a->type == DECK_STRING && same_scalar(a, b))
    return deck_format(d, "%s.%s", path, a->value.text);
  return deck_format(d, "%s[%zu]", path, k);
}

static void compare(const comparison *c, const char *path, const deck_node *there, const deck_node *here) {
  bool groups = there->type == DECK_GROUP && here->type == DECK_GROUP,
       lists = there->type == DECK_LIST && here->type == DECK_LIST && there->n == here->n;
  if (groups) {
    compare_groups(c, path, there, here);
  } else if (lists && there->n > 0 && !is_scalar(there->child[0])) {
    for (size_t k = 0; k < there->n; k++)
      compare(c, entry_path(c->d, path, k, there->child[k], here->child[k]), there->child[k], here->child[k]);
  } else {
    bool same = is_scalar(there) && is_scalar(here) && same_scalar(there, here);
    for (size_t k = 0; lists && (k == 0 || same) && k < there->n; k++)
      same = is_scalar(there->child[k]) && is_scalar(here->child[k]) &&
             same_scalar(there->child[k], here->child[k]);
    if (!same && !(lists && there->n == 0)) tell(c, path, there, here);
  }
}

/* --- two decks ---------------------------------------------------------------------------------------------- */

static sd_status with_both(deck *d, void *user) {
  comparison *c = user;
  c->d = d;
  if (d->root && c->there) compare(c, "", c->there, d->root);
  return d->root ? SD_OK : SD_ERROR_USER;
}

typedef struct both {
  comparison c;
  const char *here;
} both;

static sd_status with_other(deck *d, void *user) {
  both *b = user;
  b->c.there = d->root;
  return d->root ? deck_open(b->here, "this deck", 0, NULL, with_both, &b->c, NULL) : SD_ERROR_USER;
}

bool sweep_compare(sweep_result *r, const char *there, const char *here, bool any_title) {
  if (deck_same(there, here)) return true;
  both b = {{.r = r, .any_title = any_title}, here};
  if (*there && deck_open(there, "that deck", 0, NULL, with_other, &b, NULL) == SD_OK)
    return r->n_differences == 0;
  add(r, "its deck cannot be compared with this one", NULL, NULL);
  return false;
}

void sweep_differ(sweep_result *r, const char *why) { add(r, why, NULL, NULL); }

/* "gravity.tilt: 0.1 there, 0.2 here" */
static char *words(const sweep_difference *d) {
  if (!d->there && !d->here) return file_path("%s", d->path);
  if (!d->there) return file_path("%s: not there, %s here", d->path, d->here);
  if (!d->here) return file_path("%s: %s there, not here", d->path, d->there);
  return file_path("%s: %s there, %s here", d->path, d->there, d->here);
}

char *sweep_differences_text(const sweep_result *r) {
  enum { TOLD = 4 };
  char *text = file_path("%s", "");
  for (size_t k = 0; text && k < r->n_differences && k < TOLD; k++) {
    char *one = words(&r->differences[k]);
    char *longer = one ? file_path("%s%s%s", text, k ? "; " : "", one) : NULL;
    free(one);
    free(text);
    text = longer;
  }
  if (!text || r->n_differences <= TOLD) return text;
  char *longer = file_path("%s; and %zu more", text, r->n_differences - TOLD);
  free(text);
  return longer;
}

void sweep_differences_free(sweep_result *r) {
  for (size_t k = 0; k < r->n_differences; k++) {
    free(r->differences[k].path);
    free(r->differences[k].there);
    free(r->differences[k].here);
  }
  free(r->differences);
  r->differences = NULL;
  r->n_differences = 0;
}

/* --- of many points ----------------------------------------------------------------------------------------- */

static bool same_text(const char *a, const char *b) { return a && b ? strcmp(a, b) == 0 : a == b; }

static void count(sweep_tally *t, sweep_difference *d) {
  for (size_t k = 0; k < t->n; k++) {
    sweep_tally_line *line = &t->list[k];
    if (strcmp(line->first.path, d->path) != 0) continue;
    line->points++;
    line->varies =
        line->varies || !same_text(line->first.there, d->there) || !same_text(line->first.here, d->here);
    return;
  }
  sweep_tally_line *grown = t->n < MOST_TOLD ? realloc(t->list, (t->n + 1) * sizeof *grown) : NULL;
  if (!grown) {
    t->more++;
    return;
  }
  t->list = grown;
  grown[t->n++] = (sweep_tally_line){.first = *d, .points = 1};
  *d = (sweep_difference){0}; /* moved */
}

void sweep_tally_add(sweep_tally *t, sweep_result *r) {
  if (r->status != SWEEP_OTHER) return;
  t->points++;
  for (size_t k = 0; k < r->n_differences; k++) count(t, &r->differences[k]);
  sweep_differences_free(r);
}

char *sweep_tally_text(const sweep_tally *t, size_t k) {
  const sweep_tally_line *line = &t->list[k];
  char *one = words(&line->first),
       *text = one ? file_path("%s%s (%zu point%s)", one, line->varies ? ", and other values" : "",
                               line->points, line->points == 1 ? "" : "s")
                   : NULL;
  free(one);
  return text;
}

void sweep_tally_free(sweep_tally *t) {
  for (size_t k = 0; k < t->n; k++) {
    free(t->list[k].first.path);
    free(t->list[k].first.there);
    free(t->list[k].first.here);
  }
  free(t->list);
  *t = (sweep_tally){0};
}
