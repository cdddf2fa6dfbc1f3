/* deck_read.c: typed getters with diagnostics. See deck_read.h. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/limits.h"
#include "io/deck/deck_read.h"

static const double pi = 3.14159265358979323846;

/* --- groups --------------------------------------------------------------------------------------------- */

static const char *hint(deck *d, const char *best) {
  return best ? deck_format(d, "; did you mean \"%s\"?", best) : "";
}

/* "; expected g or tilt" for a table of few keys, "" for a longer one. */
static const char *keys_of(deck *d, const deck_table *table) {
  enum { FEW = 8 };
  const char *text = "; expected ";
  for (size_t k = 0; k < table->n; k++)
    text = deck_format(d, "%s%s%s", text, k == 0 ? "" : k + 1 < table->n ? ", " : " or ", table->key[k].name);
  return table->n <= FEW ? text : "";
}

static void check_keys(deck *d, deck_node *node, const deck_table *table) {
  for (size_t k = 0; k < node->n; k++) {
    deck_node *child = node->child[k];
    if (deck_key_find(table, child->name)) continue;
    deck_guess guess = deck_guess_start(child->name);
    for (size_t j = 0; j < table->n && !deck_told(d); j++) deck_guess_add(&guess, table->key[j].name);
    deck_fail(d, child, "unknown key%s%s%s", table == &deck_top ? "" : " of ",
              table == &deck_top ? "" : table->name,
              deck_told(d) ? ""
              : guess.best ? hint(d, guess.best)
                           : keys_of(d, table));
  }
}

bool deck_enter(deck *d, deck_node *node, const deck_table *table, deck_group *g) {
  *g = (deck_group){d, node, table};
  if (node->type != DECK_GROUP) {
    deck_fail(d, node, "expected a group { key = value; ... }");
    return false;
  }
  node->table = table;
  check_keys(d, node, table);
  return true;
}

bool deck_enter_one(deck *d, deck_node *parent, const char *key, const deck_table *table, deck_group *g) {
  deck_node *node = deck_child(parent, key);
  if (!node) {
    node = deck_node_new(d, parent, key, DECK_GROUP, parent->place);
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

bool deck_given(const deck_group *g, const char *key) {
  const deck_node *node = deck_child(g->node, key);
  return node && !node->defaulted;
}

deck_node *deck_get(const deck_group *g, const char *key) { return deck_child(g->node, key); }

/* --- defaults ------------------------------------------------------------------------------------------- */

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
  if (!deck_get(g, key)) add(g, key, DECK_FLOAT)->value.number = value;
}

void deck_default_text(deck_group *g, const char *key, const char *value) {
  if (!deck_get(g, key)) add(g, key, DECK_STRING)->value.text = deck_copy(g->d, value, strlen(value));
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

/* The default that the table gives, as a node; NULL when it gives none. */
static deck_node *table_default(deck_group *g, const deck_key *key) {
  const char *text = key->initial;
  if (text[0] == '-' && !text[1]) return NULL;
  if (strcmp(text, "required") == 0) {
    deck_fail_key(g->d, g->node, key->name, "missing: expected %s%s%s (%s)", deck_kind_text(key->kind),
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

/* --- values --------------------------------------------------------------------------------------------- */

static const char *skip_space(const char *p) {
  while (*p == ' ' || *p == '\t') p++;
  return p;
}

/* [number] [*] [pi | deg | rad] [/ number] */
bool deck_angle(const char *text, double *x) {
  const char *p = skip_space(text);
  char *end;
  double value = 1, sign = 1;
  bool number = false, unit = true;
  if ((p[0] == '-' || p[0] == '+') && strncmp(skip_space(p + 1), "pi", 2) == 0) {
    sign = p[0] == '-' ? -1 : 1;
    p = skip_space(p + 1);
  }
  if (strchr("+-.0123456789", *p) && *p) {
    value = strtod(p, &end);
    if (end == p) return false;
    number = true;
    p = skip_space(end);
    if (*p == '*') p = skip_space(p + 1);
  }
  if (strncmp(p, "pi", 2) == 0) {
    value *= pi;
    p += 2;
  } else if (strncmp(p, "deg", 3) == 0 && number) {
    value *= pi / 180;
    p += 3;
  } else if (strncmp(p, "rad", 3) == 0 && number) {
    p += 3;
  } else {
    unit = false;
  }
  p = skip_space(p);
  if (*p == '/') {
    p = skip_space(p + 1);
    double divisor = strtod(p, &end);
    if (end == p || divisor == 0) return false;
    value /= divisor;
    p = skip_space(end);
  }
  if (*p || !(number || unit) || !isfinite(value)) return false;
  *x = sign * value;
  return true;
}

/* Behind "expected a number". Kinds of values differ in words: a sweep tells of each once. */
static const char *but_not(const deck_node *node) {
  switch (node->type) {
    case DECK_BOOL: return ", not true or false";
    case DECK_LIST: return ", not a list";
    case DECK_GROUP: return ", not a group";
    default: return "";
  }
}

bool deck_value_number(deck *d, deck_node *node, bool angle, double *x) {
  *x = 0;
  if (node->type == DECK_INT) {
    node->type = DECK_FLOAT;
    node->value.number = (double)node->value.integer;
  }
  if (node->type == DECK_FLOAT) {
    *x = node->value.number;
    if (deck_in_range(DECK_ANY, *x)) return true;
    deck_fail(d, node, "expected a number %s", deck_expected(DECK_ANY, *x));
    return false;
  }
  if (angle && node->type == DECK_STRING && deck_angle(node->value.text, x)) return true;
  if (angle)
    deck_fail(d, node, "expected a number or a text such as \"0.04 pi\" or \"7.2 deg\"%s", but_not(node));
  else
    deck_fail(d, node, "expected a number%s", but_not(node));
  return false;
}

double deck_number(deck_group *g, const char *name) {
  const deck_key *key;
  deck_node *node = find(g, name, &key);
  double x;
  if (!node || !deck_value_number(g->d, node, key->kind == DECK_KEY_ANGLE, &x)) return NAN;
  if (deck_in_range(key->range, x)) return x;
  deck_fail(g->d, node, "expected a number %s", deck_expected(key->range, x));
  return NAN;
}

int64_t deck_integer(deck_group *g, const char *name) {
  const deck_key *key;
  deck_node *node = find(g, name, &key);
  if (!node) return key->range == DECK_AT_LEAST_1;
  /* 5e8 is a whole number too; beyond 2^53 a float no longer says which one is meant */
  if (node->type == DECK_FLOAT) {
    double x = node->value.number;
    if (x == floor(x) && fabs(x) <= 9007199254740992.0) {
      node->type = DECK_INT;
      node->value.integer = (int64_t)x;
    }
  }
  if (node->type == DECK_INT && deck_in_range(key->range, (double)node->value.integer))
    return node->value.integer;
  deck_fail(g->d, node, "expected a whole number%s%s", key->range ? " " : "", deck_range_text(key->range));
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

int deck_choice(deck_group *g, const char *name) {
  const deck_key *key;
  deck_node *node = find(g, name, &key);
  if (!node) return -1;
  char *choices = deck_copy(g->d, key->choices, strlen(key->choices)), *rest = choices;
  deck_guess guess = deck_guess_start(node->type == DECK_STRING ? node->value.text : "");
  const char *list = "";
  int number = 0;
  for (char *word = strtok_r(choices, " ", &rest); word; word = strtok_r(NULL, " ", &rest), number++) {
    if (strcmp(guess.word, word) == 0) return number;
    deck_guess_add(&guess, word);
    list = deck_format(g->d, "%s%s\"%s\"", list, number ? ", " : "", word);
  }
  deck_fail(g->d, node, "expected one of %s%s", list, hint(g->d, guess.best));
  return -1;
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

size_t deck_each_count(const deck_node *node) { return !node ? 0 : node->type == DECK_LIST ? node->n : 1; }
deck_node *deck_each(deck_node *node, size_t k) { return node->type == DECK_LIST ? node->child[k] : node; }

unsigned deck_coordinates(deck *d, deck_group *g, const char *name) {
  static const char *const words[] = {"x", "y", "theta"};
  const deck_key *key;
  deck_node *list = find(g, name, &key);
  unsigned mask = 0;
  for (size_t k = 0; k < deck_each_count(list); k++) {
    const deck_node *node = deck_each(list, k);
    unsigned bit = 0;
    for (int c = 0; c < 3; c++)
      if (node->type == DECK_STRING && strcmp(node->value.text, words[c]) == 0) bit = 1u << c;
    if (!bit) deck_fail(d, node, "expected \"x\", \"y\" or \"theta\"");
    if (mask & bit) deck_fail(d, node, "named twice");
    mask |= bit;
  }
  if (list && !mask && deck_each_count(list) == 0 && strcmp(key->initial, "required") == 0)
    deck_fail(d, list, "expected \"x\", \"y\", \"theta\" or a list of them");
  return mask;
}

/* --- shapes --------------------------------------------------------------------------------------------- */

/* Is name one of the words of a shape's list? star: of its alternatives, the word ended in one. */
static bool listed(const char *keys, const char *name) {
  size_t n = strlen(name);
  for (const char *p = keys; (p = strstr(p, name)); p += n)
    if ((p == keys || strchr(" /", p[-1])) && (!p[n] || strchr(" /*", p[n]))) return true;
  return false;
}

bool deck_shape_reads(const deck_shape *shape, const char *key) { return listed(shape->keys, key); }

/* The key that chooses the shape. */
static const char *chooser(const deck_shape *all) { return all == deck_size_kinds ? "sizes" : "type"; }

/* "frequency/omega*": exactly one must be given. */
static void check_alternatives(deck_group *g, const deck_shape *shape, const deck_shape *all, char *word) {
  size_t n = strlen(word);
  bool required = n && word[n - 1] == '*';
  if (required) word[n - 1] = 0;
  const char *text = deck_copy(g->d, word, strlen(word)), *seen = NULL, *first = NULL;
  char *rest = word;
  for (char *key = strtok_r(word, "/", &rest); key; key = strtok_r(NULL, "/", &rest)) {
    if (!first) first = key;
    if (!deck_given(g, key)) continue;
    if (seen) deck_fail_key(g->d, g->node, key, "given together with %s; expected one of them", seen);
    seen = key;
  }
  const deck_key *key = deck_key_find(g->table, first);
  if (required && !seen)
    deck_fail_key(g->d, g->node, text, "missing: %s \"%s\" needs it (%s)", chooser(all), shape->name,
                  key ? key->meaning : "");
}

void deck_check_shape(deck_group *g, const deck_shape *shape, const deck_shape *all, size_t n_all) {
  /* keys of other shapes only */
  for (size_t k = 0; k < g->node->n; k++) {
    const char *name = g->node->child[k]->name;
    bool elsewhere = false;
    for (size_t j = 0; j < n_all; j++) elsewhere |= listed(all[j].keys, name);
    if (elsewhere && !listed(shape->keys, name) && !g->node->child[k]->defaulted)
      deck_fail(g->d, g->node->child[k], "does not belong to %s \"%s\"", chooser(all), shape->name);
  }
  char *keys = deck_copy(g->d, shape->keys, strlen(shape->keys)), *rest = keys;
  for (char *word = strtok_r(keys, " ", &rest); word; word = strtok_r(NULL, " ", &rest))
    check_alternatives(g, shape, all, word);
}
