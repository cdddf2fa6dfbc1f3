/* key.c: see key.h. */
#include "model/key.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/limits.h"

const deck_key *deck_key_at(const deck_table *table, size_t k) {
  if (k < table->n) return &table->key[k];
  return table->more ? deck_key_at(table->more, k - table->n) : NULL;
}

const deck_key *deck_key_find(const deck_table *table, const char *name) {
  const deck_key *key;
  for (size_t k = 0; (key = deck_key_at(table, k)); k++)
    if (strcmp(key->name, name) == 0) return key;
  return NULL;
}

/* --- ranges ----------------------------------------------------------------------------------------------- */

const char *deck_range_text(deck_range range) {
  static const char *const text[] = {"", "> 0", ">= 0", ">= 1", "> 0 and <= 1"};
  return text[range];
}

/* 1/x and products of three stay finite, and above the subnormal numbers. */
static bool has_size(double x) { return fabs(x) >= 1 / LIMIT_NUMBER && fabs(x) <= LIMIT_NUMBER; }

bool deck_in_range(deck_range range, double x) {
  switch (range) {
    case DECK_ANY: return fabs(x) <= LIMIT_NUMBER;
    case DECK_POSITIVE: return x > 0 && has_size(x);
    case DECK_NOT_NEGATIVE: return x == 0 || (x > 0 && has_size(x));
    case DECK_AT_LEAST_1: return x >= 1 && has_size(x);
    case DECK_UP_TO_1: return x > 0 && x <= 1 && has_size(x);
  }
  return true;
}

const char *deck_expected(deck_range range, double x) {
  static const char *const sized[] = {"from -1e100 to 1e100", "> 0, from 1e-100 to 1e100",
                                      "0 or from 1e-100 to 1e100", "from 1 to 1e100", "from 1e-100 to 1"};
  bool wrong_size = fabs(x) > LIMIT_NUMBER || (x != 0 && fabs(x) < 1 / LIMIT_NUMBER);
  return wrong_size ? sized[range] : deck_range_text(range);
}

/* --- members ---------------------------------------------------------------------------------------------- */

static int word_value(const deck_shape *word, const char *quoted) {
  for (; word->name; word++)
    if (strncmp(quoted + 1, word->name, strlen(word->name)) == 0 && quoted[1 + strlen(word->name)] == '"')
      return word->kind;
  return 0;
}

void deck_key_defaults(const deck_table *table, void *members) {
  const deck_key *key;
  for (size_t k = 0; (key = deck_key_at(table, k)); k++) {
    void *member = (char *)members + key->offset;
    const char *text = key->initial;
    if (text[0] == '(' || strcmp(text, "-") == 0 || strcmp(text, "required") == 0) continue;
    if (key->target == DECK_SETS_NUMBER) *(double *)member = strtod(text, NULL);
    if (key->target == DECK_SETS_INTEGER || key->target == DECK_SETS_UNSIGNED)
      *(int64_t *)member = strtoll(text, NULL, 10);
    if (key->target == DECK_SETS_BOOL) *(bool *)member = text[0] == 't';
    if (key->target == DECK_SETS_OFF) *(bool *)member = text[0] != 't';
    if (key->target == DECK_SETS_ENUM) *(int *)member = word_value(key->words, text);
  }
}

/* By hand, numbers may be of any size: what is far beyond a limit switches it off. */
static bool has_sign(deck_range range, double x) {
  switch (range) {
    case DECK_ANY: return true;
    case DECK_NOT_NEGATIVE: return x >= 0;
    case DECK_AT_LEAST_1: return x >= 1;
    case DECK_POSITIVE:
    case DECK_UP_TO_1: return x > 0;
  }
  return true;
}

void deck_key_check(const deck_table *table, const void *members, const char *place, sd_messages *messages) {
  const deck_key *key;
  for (size_t k = 0; (key = deck_key_at(table, k)); k++) {
    const void *member = (const char *)members + key->offset;
    bool number = key->target == DECK_SETS_NUMBER;
    if (!number && key->target != DECK_SETS_INTEGER) continue;
    double x = number ? *(const double *)member : (double)*(const int64_t *)member;
    bool absent = x == 0 && strchr("-(", key->initial[0]);
    if (!absent && !has_sign(key->range, x))
      sd_fail(messages, SD_ERROR_USER, "%s%s%s = %g: expected a number %s", place, *place ? "." : "",
              key->name, x, deck_range_text(key->range == DECK_UP_TO_1 ? DECK_POSITIVE : key->range));
  }
}
