/* deck_columns.c: reads the key `columns`, allocates the rows of a table of disks, and reads tables
 * that are written in the deck itself. See deck_rows.h. */
#include <ctype.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "base/limits.h"
#include "base/text.h"
#include "io/deck/deck_read.h"
#include "io/deck/deck_rows.h"

const char *const deck_column_names[COLUMN_KINDS] = {
    "x",    "y",       "theta",   "vx",    "vy",   "omega",    "radius",
    "mass", "density", "inertia", "fixed", "name", "material", "group"};

int deck_column(const char *name) {
  for (int k = 0; k < COLUMN_KINDS; k++)
    if (strcmp(deck_column_names[k], name) == 0) return k;
  return -1;
}

/* --- the key `columns` ------------------------------------------------------------------------ */

/* Names of columns in files of other programs, in lower case. Others are not guessed: a column that
 * is only spelt alike, such as Rho, would give wrong disks without a word. */
static const struct column_word {
  const char *word;
  int column;
  const char *factor;
} column_words[] = {{"posx", COLUMN_X, ""},
                    {"posy", COLUMN_Y, ""},
                    {"pos_x", COLUMN_X, ""},
                    {"pos_y", COLUMN_Y, ""},
                    {"position_x", COLUMN_X, ""},
                    {"position_y", COLUMN_Y, ""},
                    {"position.x", COLUMN_X, ""},
                    {"position.y", COLUMN_Y, ""},
                    {"points:0", COLUMN_X, ""},
                    {"points:1", COLUMN_Y, ""},
                    {"x", COLUMN_X, ""},
                    {"y", COLUMN_Y, ""},
                    {"r", COLUMN_RADIUS, ""},
                    {"rad", COLUMN_RADIUS, ""},
                    {"radius", COLUMN_RADIUS, ""},
                    {"radii", COLUMN_RADIUS, ""},
                    {"d", COLUMN_RADIUS, "0.5 * "},
                    {"diam", COLUMN_RADIUS, "0.5 * "},
                    {"dia", COLUMN_RADIUS, "0.5 * "},
                    {"diameter", COLUMN_RADIUS, "0.5 * "}};

const char *deck_columns_entry(deck *d, const char *source, int *column) {
  for (size_t k = 0; k < sizeof column_words / sizeof *column_words; k++) {
    const struct column_word *w = &column_words[k];
    if (strcasecmp(w->word, source) != 0) continue;
    *column = w->column;
    const char *ours = deck_column_names[w->column];
    return strcmp(ours, source) == 0 ? ours
                                     : deck_format(d, "%s = %s%s", ours, w->factor,
                                                   deck_quote(d, source, strlen(source)));
  }
  return NULL;
}

/* Takes a factor off the text: returns the name behind "NUMBER *", or the whole text. */
static const char *factor_of(const char *text, double *factor) {
  char *end;
  const double value = strtod(text, &end);
  *factor = 1.0;
  while (end != text && isspace((unsigned char)*end)) end++;
  if (end == text || *end != '*' || !isfinite(value)) return text;
  *factor = value;
  for (end++; isspace((unsigned char)*end);) end++;
  return end;
}

/* Returns the message for a name that no column of disks has, with a hint if one is known. */
static const char *unknown_column(deck *d, const char *name, const char *shown) {
  int column;
  const char *entry = deck_columns_entry(d, name, &column);
  guess near = guess_start(name);
  for (int k = 0; k < COLUMN_KINDS; k++) guess_add(&near, deck_column_names[k]);
  return entry ? deck_format(d, "no column of disks is called \"%s\"; did you mean \"%s\"?", shown,
                             entry)
         : near.best
             ? deck_format(d, "no column of disks is called \"%s\"; did you mean \"%s\"?", shown,
                           near.best)
             : deck_format(d,
                           "no column of disks is called \"%s\"; expected x, y, radius, mass, ...",
                           shown);
}

/* Parses an entry of `columns`, such as "radius", "radius = NAME IN THE FILE" or "radius = 0.5 *
 * NAME IN THE FILE", and adds the column to the table. */
bool deck_columns_add(deck *d, deck_columns *table, const char *text, const deck_node *node,
                      deck_place place) {
  const char *equals = strchr(text, '=');
  size_t n = equals ? (size_t)(equals - text) : strlen(text);
  while (n && isspace((unsigned char)text[n - 1])) n--;
  const char *name = deck_copy(d, text, n), *source = equals ? equals + 1 : name;
  const char *shown = deck_quote(d, text, n);
  while (isspace((unsigned char)*source)) source++;
  int column = deck_column(name);
  const char *wrong = column < 0 ? unknown_column(d, name, shown) : NULL;
  double factor = 1.0;
  if (equals) source = factor_of(source, &factor);
  if (!wrong && factor != 1.0 && column >= COLUMN_NUMBERS)
    wrong = deck_format(d, "column \"%s\" has words; expected a name without a factor", name);
  for (size_t k = 0; k < table->n_columns && !wrong; k++)
    if (table->column[k] == column) wrong = deck_format(d, "column \"%s\" is there twice", name);
  if (wrong && node) deck_fail(d, node, "%s", wrong);
  if (wrong && !node) deck_fail_place(d, place, "%s", wrong);
  if (wrong) return false;
  table->source[table->n_columns] = source;
  table->factor[table->n_columns] = factor;
  table->column[table->n_columns++] = column;
  return true;
}

void deck_columns_read(deck_group *g, deck_columns *table) {
  deck_node *list = deck_get(g, "columns");
  if (!list && g->table == &deck_disk_rows)
    deck_fail_key(g, "columns", "missing: expected (\"x\", \"y\", \"radius\") or the like");
  for (size_t k = 0; k < deck_each_count(list); k++) {
    deck_node *node = deck_each(list, k);
    if (node->type == DECK_STRING)
      deck_columns_add(g->d, table, node->value.text, node, node->place);
    else
      deck_fail(g->d, node, "expected the name of a column in quotes");
  }
}

/* --- cells ------------------------------------------------------------------------------------ */

void deck_columns_reserve(deck *d, deck_columns *t, size_t capacity) {
  size_t cells = capacity * t->n_columns, before = t->n_rows * t->n_columns;
  bool texts = false;
  for (size_t c = 0; c < t->n_columns; c++) texts |= t->column[c] >= COLUMN_NUMBERS;
  t->number = deck_array_grow(d, t->number, before, cells, sizeof *t->number);
  if (texts) t->text = deck_array_grow(d, t->text, before, cells, sizeof *t->text);
  t->place = deck_array_grow(d, t->place, t->n_rows, capacity, sizeof *t->place);
  t->capacity = capacity;
}

bool deck_columns_add_row(deck *d, deck_columns *t, deck_place place) {
  if (t->n_rows >= LIMIT_DISKS) {
    deck_fail_place(d, place, "more than %d disks", LIMIT_DISKS);
    return false;
  }
  if (t->n_rows == t->capacity) deck_columns_reserve(d, t, 2 * t->capacity + 64);
  t->place[t->n_rows++] = place;
  return true;
}

void deck_columns_from_rows(deck_group *g, deck_columns *t) {
  deck *d = g->d;
  deck_node *rows = deck_get(g, "rows");
  if (!rows || rows->type != DECK_LIST) {
    deck_fail_key(g, "rows", "expected a list of rows ( (1.0, 2.0, 0.5), ... )");
    return;
  }
  for (size_t r = 0; r < rows->n && t->n_columns; r++) {
    deck_node *row = rows->child[r];
    if (row->type != DECK_LIST || row->n != t->n_columns) {
      deck_fail(d, row, "expected %zu values in ( ), one per column", t->n_columns);
      continue;
    }
    if (!deck_columns_add_row(d, t, row->place)) return;
    for (size_t c = 0; c < t->n_columns; c++) {
      deck_node *cell = row->child[c];
      size_t at = (t->n_rows - 1) * t->n_columns + c;
      bool angle = t->column[c] == COLUMN_THETA || t->column[c] == COLUMN_OMEGA;
      t->number[at] = NAN;
      if (t->column[c] == COLUMN_FIXED && cell->type == DECK_BOOL)
        t->number[at] = cell->value.flag;
      else if (t->column[c] < COLUMN_NUMBERS)
        deck_value_number(d, cell, angle, &t->number[at]);
      else if (cell->type == DECK_STRING)
        t->text[at] = cell->value.text;
      else
        deck_fail(d, cell, "expected a text in quotes");
    }
  }
}

bool deck_columns_have(const deck_columns *t, int column) {
  for (size_t k = 0; k < t->n_columns; k++)
    if (t->column[k] == column) return true;
  return false;
}
