/* deck_override.c: applies settings path=value to the tree of a deck, from -D or from a point of a
 * sweep. See deck_tree.h.
 *
 * Paths are written as in messages: gravity.tilt, motions[0].amplitude; also
 * motions.[0].amplitude as libconfig writes it, motions.left_x.amplitude for the entry named
 * left_x, and motions[*].amplitude for all entries. Groups of the path that the deck lacks are
 * added; if they are misspelt, the check of unknown keys reports them later. */
#include <ctype.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/types.h>

#include "base/limits.h"
#include "base/text.h"
#include "io/deck/deck_read.h"

static bool same_word(const char *word, size_t n, const char *text) {
  return strlen(text) == n && !memcmp(word, text, n);
}

/* Returns the location of a setting: file and line of its value in the sweep, or "-D path=value"
 * for the command line. */
static deck_place place_of(deck *d, const deck_setting *s) {
  return s->place.file
             ? s->place
             : (deck_place){deck_format(d, "-D %s", deck_quote(d, s->text, strlen(s->text))), 0};
}

/* Reports an error of a setting, as "-D path=value: ..." or, for a sweep, "file:line: path = value:
 * ...". */
static void fail(deck *d, const deck_setting *s, const char *format, ...) SD_PRINTF(3, 4);
static void fail(deck *d, const deck_setting *s, const char *format, ...) {
  const char *value = s->place.file ? strchr(s->text, '=') : NULL;
  va_list args;
  va_start(args, format);
  deck_report(d, place_of(d, s), value ? deck_quote(d, s->text, (size_t)(value - s->text)) : NULL,
              value ? deck_quote(d, value + 1, strlen(value + 1)) : NULL, format, args);
  va_end(args);
}

/* Parses the value of a setting in the syntax of a deck. Other texts that begin with neither a
 * bracket nor a quote become strings: -D motions[0].type=parabolic, -D gravity.tilt=0.04 pi.
 * Returns NULL after an error, which is reported. */
static deck_node *value_of(deck *d, const deck_setting *s, const char *text) {
  deck_place place = place_of(d, s);
  while (isspace((unsigned char)*text)) text++;
  bool word = !strchr("([{\"", *text) || !*text;
  sd_messages *all = d->messages, *mine = sd_messages_new();
  size_t reported = d->reported;
  d->messages = mine;
  deck_text scanned = deck_scan(d, deck_format(d, "value = %s;", text), (deck_place){"", 0}, true);
  bool bad_number = d->reported > reported && !scanned.broken;
  deck_node *root = scanned.broken || bad_number ? NULL : deck_parse(d, &scanned);
  bool one = root && root->n == 1;
  d->messages = all;
  char *end;
  double number = strtod(text, &end);
  bool too_large = end != text && !*end && !(fabs(number) < HUGE_VAL && number != 0);
  if (!one && word && !(bad_number && too_large)) {
    d->reported = reported;
    sd_messages_free(mine);
    deck_node *node = deck_node_new(d, NULL, NULL, DECK_STRING, place);
    node->value.text = deck_copy(d, text, strlen(text));
    if (text_printable(text)) return node;
    fail(d, s, "expected a text in UTF-8 without control characters");
    return NULL;
  }
  const char *why = sd_messages_count(mine) > 0 ? messages_at(mine, 0)->wrong : "";
  why = deck_copy(d, why, strlen(why));
  sd_messages_free(mine);
  /* If the value was parsed, the only possible error is a text that is not printable UTF-8 */
  bool bad_text = one && d->reported > reported;
  d->reported = reported;
  if (bad_text) fail(d, s, "expected a text in UTF-8 without control characters");
  if (one) return bad_text ? NULL : root->child[0];
  if (too_large)
    fail(d, s, "the number is out of range");
  else
    fail(d, s, "the value cannot be read%s%s", *why ? ": " : "", why);
  return NULL;
}

/* Returns the name of an entry of a list, its key `name`; NULL: none. An entry without it is named
 * by the last word of its key `path`: parameters of a sweep are named so in the table of results
 * (deck_grid.c). */
static const char *entry_name(const deck_node *entry) {
  const deck_node *name = deck_child(entry, "name");
  if (name) return name->type == DECK_STRING ? name->value.text : NULL;
  const deck_node *path = deck_child(entry, "path");
  if (path && path->type == DECK_LIST && path->n > 0) path = path->child[0];
  if (!path || path->type != DECK_STRING) return NULL;
  const char *dot = strrchr(path->value.text, '.');
  return dot ? dot + 1 : path->value.text;
}

/* Returns the entry of a list with the name `word` of n bytes; NULL: none. Names written in the
 * deck take precedence over names derived from paths. */
static deck_node *find_entry(const deck_node *list, const char *word, size_t n) {
  deck_node *found = NULL;
  for (size_t k = 0; k < list->n; k++) {
    const char *name = entry_name(list->child[k]);
    if (!name || !same_word(word, n, name)) continue;
    if (deck_child(list->child[k], "name")) return list->child[k];
    if (!found) found = list->child[k];
  }
  return found;
}

/* Returns "; expected "a" or "b"" with the names of all entries of a list; "" if there are none, or
 * more than FEW. */
static const char *names_of(deck *d, const deck_node *list) {
  enum { FEW = 6 };
  const char *text = "";
  size_t n = 0;
  for (size_t k = 0; k < list->n; k++) {
    const char *name = entry_name(list->child[k]);
    if (!name) continue;
    text = deck_format(d, "%s%s\"%s\"", text, n++ == 0 ? "; expected " : " or ", name);
    if (n > FEW) return "";
  }
  return text;
}

static deck_node *element(deck *d, const deck_setting *s, deck_node *list, const char *word,
                          size_t n) {
  deck_node *found = find_entry(list, word, n);
  if (found) return found;
  guess near = guess_start(deck_copy(d, word, n));
  for (size_t k = 0; k < list->n; k++) {
    const char *name = entry_name(list->child[k]);
    if (name) guess_add(&near, name);
  }
  const char *hint = names_of(d, list), *above = deck_node_path(d, list);
  if (strspn(near.word, "0123456789") == n)
    hint = deck_format(d, "; did you mean %s[%s]?", above, near.word);
  else if (near.best)
    hint = deck_hint(d, &near);
  fail(d, s, "%s has no entry named \"%s\"%s", above, near.word, hint);
  return NULL;
}

/* Follows one step of the path, "[3]" or "name", from the node `at`, and moves *p to the end of the
 * step. A key that a group lacks is added. Returns NULL after an error, which is reported. */
static deck_node *step(deck *d, const deck_setting *s, deck_node *at, const char **p) {
  if (**p == '.') ++*p;
  if (**p == '[') {
    char *end;
    unsigned long k = strtoul(*p + 1, &end, 10);
    if (end == *p + 1 || *end != ']' || !isdigit((unsigned char)(*p)[1])) {
      fail(d, s, "expected a number in [ ]");
      return NULL;
    }
    *p = end + 1;
    if (at->type == DECK_LIST && k < at->n) return at->child[k];
    fail(d, s, "%s has %s", *deck_node_path(d, at) ? deck_node_path(d, at) : "the deck",
         at->type != DECK_LIST ? "no entries [ ]"
                               : deck_format(d, "entries [0] to [%zd] only", (ssize_t)at->n - 1));
    return NULL;
  }
  size_t n = strcspn(*p, ".[");
  const char *word = *p;
  *p += n;
  if (n > LIMIT_QUOTE) {
    fail(d, s, "a key of %zu characters; expected at most %d", n, LIMIT_QUOTE);
    return NULL;
  }
  if (n == 0 || (at->type != DECK_GROUP && at->type != DECK_LIST)) {
    if (n == 0)
      fail(d, s, "expected path=value, such as gravity.tilt=0.1");
    else
      fail(d, s, "%s is a value and has no keys", deck_node_path(d, at));
    return NULL;
  }
  if (at->type == DECK_LIST) return element(d, s, at, word, n);
  deck_node *child = deck_child(at, deck_copy(d, word, n));
  if (child) return child;
  child = deck_node_new(d, at, deck_copy(d, word, n), DECK_GROUP, place_of(d, s));
  child->added = true;
  return child;
}

/* Copies a value and its children to the node `to`, all with the source location `place`. */
static void adopt(deck *d, deck_node *to, const deck_node *from, deck_place place) {
  to->type = from->type;
  to->value = from->value;
  to->place = place;
  to->n = to->capacity = 0;
  for (size_t k = 0; k < from->n; k++) {
    const deck_node *child = from->child[k];
    adopt(d, deck_node_new(d, to, child->name, child->type, place), child, place);
  }
}

/* Returns an upper bound on the number of steps in a path: 1 + the number of brackets and dots. */
static size_t path_depth(const char *p) {
  size_t n = 1;
  for (; *p; p++) n += *p == '.' || *p == '[';
  return n;
}

static void set(deck *d, const deck_setting *s, deck_node *at, const char *p,
                const deck_node *value) {
  while (*p) {
    if (strncmp(p, "[*]", 3) == 0 || strncmp(p, ".[*]", 4) == 0) {
      if (at->type != DECK_LIST) fail(d, s, "%s is no list", deck_node_path(d, at));
      for (size_t k = 0; at->type == DECK_LIST && k < at->n; k++)
        set(d, s, at->child[k], strchr(p, ']') + 1, value);
      return;
    }
    at = step(d, s, at, &p);
    if (!at) return;
    if (*p && !strchr(".[", *p)) {
      fail(d, s, "expected . or [ after ] in the path");
      return;
    }
  }
  /* Remove keys that must not be given together with this one, such as density beside mass */
  for (size_t k = 0; at->name && k < at->parent->n; k++)
    if (at->parent->child[k] != at && deck_keys_exclude(at->name, at->parent->child[k]->name))
      deck_remove(at->parent, at->parent->child[k--]);
  adopt(d, at, value, place_of(d, s));
}

void deck_override(deck *d, const deck_setting *setting) {
  const char *text = setting->text, *equals = strchr(text, '=');
  if (!equals || equals == text) {
    fail(d, setting, "expected path=value, such as gravity.tilt=0.1");
    return;
  }
  size_t n = (size_t)(equals - text);
  while (n && isspace((unsigned char)text[n - 1])) n--;
  const char *path = deck_copy(d, text, n);
  if (path_depth(path) > LIMIT_DEPTH) {
    fail(d, setting, "more than %d steps in the path", LIMIT_DEPTH);
    return;
  }
  const deck_node *value = value_of(d, setting, equals + 1);
  if (value) set(d, setting, d->root, path, value);
}

/* --- comparison of two paths ------------------------------------------------------------------ */

/* One step of a path as written: "word" or "[3]". */
typedef struct step_text {
  const char *start;
  size_t n;
} step_text;

static step_text next_step(const char **p, const char *end) {
  if (*p < end && **p == '.') ++*p;
  step_text one = {*p, 0};
  const char *stop = one.start + (one.start < end && *one.start == '[');
  while (stop < end && *stop != '.' && *stop != '[') stop++;
  one.n = (size_t)(stop - one.start);
  *p = stop;
  return one;
}

/* Returns true if only one of the two keys may be given, as for mass and density. */
static bool exclude(step_text a, step_text b) {
  char one[LIMIT_QUOTE + 1], two[LIMIT_QUOTE + 1];
  snprintf(one, sizeof one, "%.*s", (int)a.n, a.start);
  snprintf(two, sizeof two, "%.*s", (int)b.n, b.start);
  return a.n < sizeof one && b.n < sizeof two && deck_keys_exclude(one, two);
}

/* Returns the number of entries of a list that one step of a path selects (all of them for [*]);
 * *first is the index of the first one. */
static size_t entries_of(step_text one, const deck_node *list, size_t *first) {
  *first = 0;
  if (same_word(one.start, one.n, "[*]")) return list->n;
  if (*one.start == '[') {
    *first = strtoul(one.start + 1, NULL, 10);
    return *first < list->n;
  }
  const deck_node *found = find_entry(list, one.start, one.n);
  while (found && list->child[*first] != found) ++*first;
  return found != NULL;
}

/* Compares two paths step by step, from p to p_end and from q to q_end. at: node that both paths
 * have reached; NULL: the deck lacks it. */
static deck_paths_relation meet(const deck_node *at, const char *p, const char *p_end,
                                const char *q, const char *q_end) {
  /* One path is the start of the other, or both are the same */
  if (p == p_end || q == q_end) return DECK_SAME_KEY;
  step_text a = next_step(&p, p_end), b = next_step(&q, q_end);
  if (a.n == 0 || b.n == 0) return DECK_DIFFERENT_KEYS; /* A path is not valid */
  if (at && at->type == DECK_LIST) {
    deck_paths_relation met = DECK_DIFFERENT_KEYS;
    size_t from_a, from_b, n_a = entries_of(a, at, &from_a), n_b = entries_of(b, at, &from_b);
    for (size_t k = from_a > from_b ? from_a : from_b; k < from_a + n_a && k < from_b + n_b; k++)
      if (met == DECK_DIFFERENT_KEYS) met = meet(at->child[k], p, p_end, q, q_end);
    return met;
  }
  if (a.n == b.n && memcmp(a.start, b.start, a.n) == 0) {
    const deck_node *child = NULL;
    for (size_t k = 0; at && at->type == DECK_GROUP && k < at->n; k++)
      if (same_word(a.start, a.n, at->child[k]->name)) child = at->child[k];
    return meet(child, p, p_end, q, q_end);
  }
  bool last = p == p_end && q == q_end;
  return last && exclude(a, b) ? DECK_ALTERNATIVES : DECK_DIFFERENT_KEYS;
}

/* Returns a pointer to the end of a path: its "=" or the end of the text, less the blanks before
 * it. */
static const char *path_end(const char *path) {
  size_t n = strcspn(path, "=");
  while (n > 0 && isspace((unsigned char)path[n - 1])) n--;
  return path + n;
}

deck_paths_relation deck_paths_compare(const deck *d, const char *p, const char *q) {
  return meet(d->root, p, path_end(p), q, path_end(q));
}
