/* deck_read.c: functions that read values of keys, check their types and ranges, and report errors.
 * See deck_read.h. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/limits.h"
#include "base/memory.h"
#include "io/deck/deck_expression.h"
#include "io/deck/deck_read.h"

/* --- groups ----------------------------------------------------------------------------------- */

/* Returns "; expected g or tilt" with the keys of a small table, "" for a larger one. */
static const char *keys_of(deck *d, const deck_table *table) {
  enum { FEW = 8 };
  const char *text = "; expected ";
  const deck_key *key;
  size_t k = 0;
  for (; (key = deck_key_at(table, k)); k++)
    text = deck_format(d, "%s%s%s", text,
                       k == 0                      ? ""
                       : deck_key_at(table, k + 1) ? ", "
                                                   : " or ",
                       key->name);
  return k <= FEW ? text : "";
}

static void check_keys(deck *d, deck_node *node, const deck_table *table) {
  for (size_t k = 0; k < node->n; k++) {
    deck_node *child = node->child[k];
    if (deck_key_find(table, child->name)) continue;
    bool told = deck_error_limit_reached(d);
    guess near = guess_start(child->name);
    const deck_key *key;
    for (size_t j = 0; !told && (key = deck_key_at(table, j)); j++) guess_add(&near, key->name);
    const char *other = told ? NULL : deck_other_word(d, table, child->name);
    const char *hint = told        ? ""
                       : other     ? other
                       : near.best ? deck_hint(d, &near)
                                   : keys_of(d, table);
    bool top = table == &deck_top;
    if (top && !told && !other && !near.best && deck_has_constant(d, child->name))
      hint = deck_format(d, "; did you mean constants.%s?", child->name);
    deck_fail(d, child, "unknown key%s%s%s", top ? "" : " of ", top ? "" : table->name, hint);
  }
}

bool deck_enter(deck *d, deck_node *node, const deck_table *table, deck_group *g) {
  *g = (deck_group){d, node, table, NULL};
  if (node->type != DECK_GROUP) {
    deck_fail(d, node, "expected a group { key = value; ... }");
    return false;
  }
  node->table = table;
  check_keys(d, node, table);
  return true;
}

bool deck_enter_one(deck *d, const deck_table *table, deck_group *g) {
  deck_node *node = deck_child(d->root, table->name);
  if (!node) {
    node = deck_node_new(d, d->root, table->name, DECK_GROUP, d->root->place);
    node->defaulted = true;
  }
  return deck_enter(d, node, table, g);
}

deck_node *deck_groups(deck *d, deck_node *parent, const char *key) {
  deck_node *node = deck_child(parent, key);
  bool disks = strcmp(key, "disks") == 0 || strcmp(key, "disk_rows") == 0;
  if (node && node->type == DECK_LIST && node->n > LIMIT_ENTRIES && !disks) {
    deck_fail(d, node, "%zu entries; expected at most %d", node->n, LIMIT_ENTRIES);
    return NULL;
  }
  if (!node || node->type == DECK_LIST) return node;
  deck_fail(d, node, "expected a list of groups ( { key = value; ... }, { ... } )");
  return NULL;
}

bool deck_next(deck *d, const deck_table *table, size_t *k, deck_group *g) {
  const deck_node *list = deck_groups(d, d->root, table->name);
  while (list && *k < list->n)
    if (deck_enter(d, list->child[(*k)++], table, g)) return true;
  return false;
}

bool deck_given(const deck_group *g, const char *key) {
  const deck_node *node = deck_child(g->node, key);
  return node && !node->defaulted;
}

deck_node *deck_get(const deck_group *g, const char *key) { return deck_child(g->node, key); }

/* --- defaults --------------------------------------------------------------------------------- */

static deck_node *add(deck_group *g, const char *key, deck_type type) {
  deck_node *node = deck_node_new(g->d, g->node, key, type, g->node->place);
  node->defaulted = true;
  return node;
}

void deck_default_bool(deck_group *g, const char *key, bool value) {
  if (!deck_get(g, key)) add(g, key, DECK_BOOL)->value.flag = value;
}

void deck_default_integer(deck_group *g, const char *key, int64_t value) {
  if (!deck_get(g, key)) add(g, key, DECK_INT)->value.integer = value;
}

void deck_default_number(deck_group *g, const char *key, double value) {
  if (deck_get(g, key)) return;
  add(g, key, DECK_FLOAT)->value.number = value;
  if (g->members) *(double *)((char *)g->members + deck_key_find(g->table, key)->offset) = value;
}

void deck_default_text(deck_group *g, const char *key, const char *value) {
  if (!deck_get(g, key))
    add(g, key, DECK_STRING)->value.text = deck_copy(g->d, value, strlen(value));
}

deck_node *deck_default_list(deck_group *g, const char *key) {
  deck_node *node = deck_get(g, key);
  return node ? node : add(g, key, DECK_LIST);
}

void deck_default_pair(deck_group *g, const char *key, const double pair[2]) {
  if (deck_get(g, key)) return;
  deck_node *list = add(g, key, DECK_LIST);
  for (int k = 0; k < 2; k++)
    deck_node_new(g->d, list, NULL, DECK_FLOAT, list->place)->value.number = pair[k];
}

/* Returns the words that a key accepts as a list for messages: "a", "b". */
static const char *words_of(deck *d, const deck_key *key) {
  const char *list = "";
  for (const deck_shape *word = key->words; word->name; word++)
    list = deck_format(d, "%s%s\"%s\"", list, word == key->words ? "" : ", ", word->name);
  return list;
}

/* Adds the default of a key, which its table gives, to the tree and returns the new node. Returns
 * NULL if there is no default, or if the key is required (reported as an error). */
static deck_node *table_default(deck_group *g, const deck_key *key) {
  const char *text = key->initial;
  if (text[0] == '-' && !text[1]) return NULL;
  if (strcmp(text, "required") == 0 && key->kind == DECK_KEY_CHOICE) {
    deck_fail_key(g, key->name, "missing: expected one of %s", words_of(g->d, key));
    return NULL;
  }
  if (strcmp(text, "required") == 0) {
    deck_fail_key(g, key->name, "missing: expected %s%s%s (%s)", deck_kind_text(key->kind),
                  key->range ? " " : "", deck_range_text(key->range), key->meaning);
    return NULL;
  }
  switch (key->kind) {
    case DECK_KEY_BOOL:
      if (text[0] != '(') deck_default_bool(g, key->name, text[0] == 't');
      break;
    case DECK_KEY_INTEGER:
      if (text[0] != '(') deck_default_integer(g, key->name, strtoll(text, NULL, 10));
      break;
    case DECK_KEY_NUMBER:
    case DECK_KEY_ANGLE:
      if (text[0] != '(') add(g, key->name, DECK_FLOAT)->value.number = strtod(text, NULL);
      break;
    case DECK_KEY_TEXT:
    case DECK_KEY_CHOICE:
      if (text[0] == '"')
        add(g, key->name, DECK_STRING)->value.text = deck_copy(g->d, text + 1, strlen(text) - 2);
      break;
    case DECK_KEY_NUMBERS:
      if (strcmp(text, "(0.0, 0.0)") == 0) deck_default_pair(g, key->name, (double[2]){0, 0});
      break;
    case DECK_KEY_COORDINATES:
      if (strcmp(text, "()") == 0) deck_default_list(g, key->name);
      break;
    default: break;
  }
  return deck_get(g, key->name);
}

static deck_node *find(deck_group *g, const char *name, const deck_key **key) {
  *key = deck_key_find(g->table, name);
  deck_node *node = deck_get(g, name);
  return node ? node : *key ? table_default(g, *key) : NULL;
}

/* --- values ----------------------------------------------------------------------------------- */

/* Returns "it is 0.3; ", the computed value, for a text that is arithmetic, else "". */
static const char *computed(deck *d, const deck_node *node) {
  return node->remark ? deck_format(d, "it is %s; ", node->remark) : "";
}

double deck_number(deck_group *g, const char *name) {
  const deck_key *key;
  deck_node *node = find(g, name, &key);
  double x;
  if (!node || !deck_value_number(g->d, node, key->kind == DECK_KEY_ANGLE, &x)) return NAN;
  if (deck_in_range(key->range, x)) return x;
  deck_fail(g->d, node, "%sexpected a number %s", computed(g->d, node),
            deck_expected(key->range, x));
  return NAN;
}

int64_t deck_integer(deck_group *g, const char *name) {
  const deck_key *key;
  deck_node *node = find(g, name, &key);
  if (!node) return key->range == DECK_AT_LEAST_1;
  double x = node->type == DECK_FLOAT ? node->value.number : 0.5;
  if (node->type == DECK_STRING && !deck_value_number(g->d, node, false, &x))
    return key->range == DECK_AT_LEAST_1;
  /* A float such as 5e8 is a whole number too; beyond 2^53 a float no longer identifies one whole
   * number */
  bool whole = x == floor(x) && fabs(x) <= 9007199254740992.0;
  if (whole && node->type == DECK_FLOAT) {
    node->type = DECK_INT;
    node->value.integer = (int64_t)x;
  }
  int64_t value = whole ? (int64_t)x : 0;
  if (node->type == DECK_INT) value = node->value.integer;
  if ((whole || node->type == DECK_INT) && deck_in_range(key->range, (double)value)) return value;
  deck_fail(g->d, node, "%sexpected a whole number%s%s%s", computed(g->d, node),
            key->range ? " " : "", deck_range_text(key->range),
            node->remark && !whole ? ", such as round(...)" : "");
  return key->range == DECK_AT_LEAST_1;
}

bool deck_bool(deck_group *g, const char *name) {
  const deck_key *key;
  deck_node *node = find(g, name, &key);
  if (!node) return false;
  if (node->type == DECK_BOOL) return node->value.flag;
  deck_fail(g->d, node, "expected true or false");
  return false;
}

const char *deck_text_of(deck_group *g, const char *name) {
  const deck_key *key;
  deck_node *node = find(g, name, &key);
  if (!node) return NULL;
  if (node->type == DECK_STRING) return node->value.text;
  deck_fail(g->d, node, "expected a text in quotes");
  return NULL;
}

/* Returns the entry of the word list of a key that the deck names; NULL: the key is left out, or
 * its value is wrong (reported). */
static const deck_shape *choose(deck_group *g, const char *name) {
  const deck_key *key;
  deck_node *node = find(g, name, &key);
  if (!node) return NULL;
  guess near = guess_start(node->type == DECK_STRING ? node->value.text : "");
  for (const deck_shape *word = key->words; word->name; word++) {
    if (strcmp(near.word, word->name) == 0) return word;
    guess_add(&near, word->name);
  }
  const char *other = deck_other_value(g->d, key, near.word);
  deck_fail(g->d, node, "expected one of %s%s", words_of(g->d, key),
            other ? other : deck_hint(g->d, &near));
  return NULL;
}

int deck_choice(deck_group *g, const char *name) {
  const deck_shape *word = choose(g, name);
  return word ? word->kind : -1;
}

bool deck_pair(deck_group *g, const char *name, double pair[2]) {
  const deck_key *key;
  deck_node *node = find(g, name, &key);
  pair[0] = pair[1] = 0;
  if (!node) return false;
  if (node->type != DECK_LIST || node->n != 2) {
    deck_fail(g->d, node, "expected two numbers (a, b)");
    return false;
  }
  bool first = deck_value_number(g->d, node->child[0], false, &pair[0]);
  return deck_value_number(g->d, node->child[1], false, &pair[1]) && first;
}

size_t deck_each_count(const deck_node *node) {
  return !node ? 0 : node->type == DECK_LIST ? node->n : 1;
}
deck_node *deck_each(deck_node *node, size_t k) {
  return node->type == DECK_LIST ? node->child[k] : node;
}

unsigned deck_coordinates(deck_group *g, const char *name) {
  deck *d = g->d;
  static const char *const words[SD_MOVED] = {"x", "y", "theta", "surface"};
  const deck_key *key;
  deck_node *list = find(g, name, &key);
  /* "surface" is a coordinate of motions only; locks know x, y and theta */
  const int most = strcmp(name, "coordinate") == 0 ? SD_MOVED : SD_COORDINATES;
  unsigned mask = 0;
  for (size_t k = 0; k < deck_each_count(list); k++) {
    const deck_node *node = deck_each(list, k);
    unsigned bit = 0;
    for (int c = 0; c < most; c++)
      if (node->type == DECK_STRING && strcmp(node->value.text, words[c]) == 0) bit = 1u << c;
    if (!bit)
      deck_fail(d, node, "expected \"x\", \"y\"%s",
                most == SD_MOVED ? ", \"theta\" or, of walls, \"surface\"" : " or \"theta\"");
    if (mask & bit) deck_fail(d, node, "named twice");
    mask |= bit;
  }
  if (list && !mask && deck_each_count(list) == 0 && strcmp(key->initial, "required") == 0)
    deck_fail(d, list, "expected \"x\", \"y\", \"theta\" or a list of them");
  return mask;
}

/* --- alternatives and kinds ------------------------------------------------------------------- */

/* Returns which of the alternative keys in `keys`, such as "mass/density", is given; NULL: none.
 * Reports an error if several are given. */
static const char *given_of(deck_group *g, const char *keys) {
  const char *seen = NULL;
  char *copy = deck_copy(g->d, keys, strcspn(keys, " *")), *rest = NULL;
  for (char *key = strtok_r(copy, "/", &rest); key; key = strtok_r(NULL, "/", &rest)) {
    if (!deck_given(g, key)) continue;
    if (seen) deck_fail_key(g, key, "given together with %s; expected one of them", seen);
    seen = key;
  }
  return seen;
}

const char *deck_one_of(deck_group *g, const char *expected) {
  const char *seen = given_of(g, g->table->either);
  const char *first = deck_copy(g->d, g->table->either, strcspn(g->table->either, "/"));
  if (!seen) deck_fail_key(g, first, "missing: expected %s", expected);
  return seen;
}

/* Reports an error for each key of the group that this kind does not read, and for each key that it
 * requires and the group lacks. */
static void check_kind(deck_group *g, const deck_key *chooser, const deck_shape *kind) {
  for (size_t k = 0; k < g->node->n; k++) {
    const deck_node *child = g->node->child[k];
    if (!child->defaulted && !deck_reads(chooser, kind, child->name))
      deck_fail(g->d, child, "does not belong to %s \"%s\"", chooser->name, kind->name);
  }
  for (const char *p = kind->keys; *p; p += strspn(p, " ")) {
    size_t n = strcspn(p, " "), first = strcspn(p, "/* ");
    bool seen = given_of(g, p) != NULL;
    const deck_key *key = deck_key_find(g->table, deck_copy(g->d, p, first));
    if (p[n - 1] == '*' && !seen)
      deck_fail_key(g, deck_copy(g->d, p, n - 1), "missing: %s \"%s\" needs it (%s)", chooser->name,
                    kind->name, key ? key->meaning : "");
    p += n;
  }
}

bool deck_reads(const deck_key *chooser, const deck_shape *kind, const char *key) {
  if (kind && deck_listed(kind->keys, key)) return true;
  for (const deck_shape *other = chooser->words; other->name; other++)
    if (deck_listed(other->keys, key)) return false;
  return true;
}

const deck_shape *deck_shape_of(deck_group *g, const char *key) {
  const deck_shape *kind = choose(g, key);
  if (kind) check_kind(g, deck_key_find(g->table, key), kind);
  return kind;
}

/* --- members ---------------------------------------------------------------------------------- */

static void read_member(deck_group *g, const deck_key *key, void *member) {
  const deck_shape *word;
  const char *name = key->name;
  /* A number that is required and missing becomes NAN; deck_number reports it */
  if (strcmp(key->initial, "required") != 0 && !find(g, name, &key)) return;
  switch (key->target) {
    case DECK_SETS_NOTHING: break;
    case DECK_SETS_NUMBER: *(double *)member = deck_number(g, name); break;
    case DECK_SETS_INTEGER:
    case DECK_SETS_UNSIGNED: *(int64_t *)member = deck_integer(g, name); break;
    case DECK_SETS_PAIR: deck_pair(g, name, member); break;
    case DECK_SETS_TEXT: *(char **)member = memory_text(deck_text_of(g, name)); break;
    case DECK_SETS_BOOL:
      if (key->words)
        *(bool *)member = deck_choice(g, name) == true;
      else
        *(bool *)member = deck_bool(g, name);
      break;
    case DECK_SETS_OFF: *(bool *)member = !deck_bool(g, name); break;
    case DECK_SETS_ENUM:
      word = choose(g, name);
      if (word) *(int *)member = word->kind;
      break;
  }
}

bool deck_fill(deck_group *g, void *members) {
  g->members = members;
  enum { CHOOSERS = 2 };
  const deck_key *chooser[CHOOSERS];
  const deck_shape *kind[CHOOSERS];
  size_t n = 0;
  bool known = true;
  const deck_key *key;
  for (size_t k = 0; (key = deck_key_at(g->table, k)); k++) {
    if (!key->words || !key->words[0].keys || n == CHOOSERS) continue;
    chooser[n] = key;
    kind[n] = deck_shape_of(g, key->name);
    known = kind[n++] && known;
  }
  for (size_t k = 0; (key = deck_key_at(g->table, k)); k++) {
    bool reads = key->target != DECK_SETS_NOTHING;
    for (size_t j = 0; j < n; j++)
      reads = reads && key != chooser[j] && deck_reads(chooser[j], kind[j], key->name);
    if (reads) read_member(g, key, (char *)members + key->offset);
  }
  for (size_t j = 0; j < n; j++)
    if (kind[j] && chooser[j]->target == DECK_SETS_ENUM)
      *(int *)((char *)members + chooser[j]->offset) = kind[j]->kind;
  return known;
}

void deck_warn_tilt(const deck *d, double tilt, deck_place place, sd_messages *messages) {
  if (!(fabs(tilt) > M_PI / 2)) return;
  char line[24] = "";
  if (place.line > 0) snprintf(line, sizeof line, ":%d", place.line);
  sd_warn(messages,
          "%s%s: gravity.tilt = %.10g: more than a right angle; angles are in radians, degrees are "
          "\"%.10g deg\"",
          place.file ? place.file : d->path, line, tilt, tilt);
}
