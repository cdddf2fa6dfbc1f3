/* deck_columns.c: reads the key `columns`, allocates the rows of a table of disks, and reads tables
 * that are written in the deck itself. See deck_rows.h. */
#include <ctype.h>
#include <math.h>
#include <string.h>

#include "base/limits.h"
#include "base/text.h"
#include "io/deck/deck_expression.h"
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

/* --- names in files of other programs --------------------------------------------------------- */

/* Names that programs give to properties of disks, without case, blanks and punctuation, and the
 * arithmetic that makes ours of theirs. */
static const struct {
  const char *name;
  int column;
  const char *factor;
} others[] = {
    {"posx", COLUMN_X, ""},
    {"xpos", COLUMN_X, ""},
    {"positionx", COLUMN_X, ""},
    {"position0", COLUMN_X, ""},
    {"points0", COLUMN_X, ""},
    {"centerx", COLUMN_X, ""},
    {"centrex", COLUMN_X, ""},
    {"posy", COLUMN_Y, ""},
    {"ypos", COLUMN_Y, ""},
    {"positiony", COLUMN_Y, ""},
    {"position1", COLUMN_Y, ""},
    {"points1", COLUMN_Y, ""},
    {"centery", COLUMN_Y, ""},
    {"centrey", COLUMN_Y, ""},
    {"r", COLUMN_RADIUS, ""},
    {"radii", COLUMN_RADIUS, ""},
    {"diameter", COLUMN_RADIUS, "0.5 * "},
    {"diam", COLUMN_RADIUS, "0.5 * "},
    {"velx", COLUMN_VX, ""},
    {"velocityx", COLUMN_VX, ""},
    {"velocity0", COLUMN_VX, ""},
    {"vely", COLUMN_VY, ""},
    {"velocityy", COLUMN_VY, ""},
    {"velocity1", COLUMN_VY, ""},
    {"omegaz", COLUMN_OMEGA, ""},
};

/* Returns true if both names have the same letters and digits. */
static bool is_alike(const char *a, const char *b) {
  for (;; a++, b++) {
    while (ispunct((unsigned char)*a) || isspace((unsigned char)*a)) a++;
    while (ispunct((unsigned char)*b) || isspace((unsigned char)*b)) b++;
    if (tolower((unsigned char)*a) != tolower((unsigned char)*b)) return false;
    if (!*a) return true;
  }
}

const char *deck_columns_hint(deck *d, int column, const char *name) {
  const char *ours = deck_column_names[column], *shown = deck_quote(d, name, strlen(name));
  if (strcmp(name, ours) == 0) return ours;
  if (strpbrk(name, "\"\\")) return NULL; /* needs escapes */
  if (is_alike(name, ours)) return deck_format(d, "%s = %s", ours, shown);
  for (size_t k = 0; k < sizeof others / sizeof *others; k++)
    if (others[k].column == column && is_alike(name, others[k].name))
      return deck_format(d, "%s = %s%s", ours, others[k].factor, shown);
  return NULL;
}

static const char *names_of_columns(deck *d) {
  const char *text = deck_column_names[0];
  for (int k = 1; k < COLUMN_KINDS; k++)
    text =
        deck_format(d, "%s%s%s", text, k + 1 < COLUMN_KINDS ? ", " : " or ", deck_column_names[k]);
  return text;
}

/* --- arithmetic with a column of a file ------------------------------------------------------- */

/* The column that arithmetic names. */
typedef struct named {
  deck *d;
  deck_column_there *there;
  void *file;
  const char *column, *other; /* other: the first name that is none, nor a constant; NULL: none */
  double value;
} named;

static bool in_name(char c) { return isalnum((unsigned char)c) || c == '_'; }

/* Finds the longest name of a column with which the text begins (deck_lookup). */
static size_t find_column(void *user, const char *text, bool rate, double *x, const char **wrong) {
  (void)rate;
  named *in = user;
  size_t first = 0;
  *x = 1;
  for (size_t n = strlen(text); n > 0; n--) {
    if (in_name(text[n - 1]) && in_name(text[n])) continue;
    const char *name = deck_copy(in->d, text, n);
    if (!in->there(in->file, name)) continue;
    if (in->column && strcmp(in->column, name) != 0)
      *wrong = deck_format(in->d, "expected one column of the file; \"%s\" and \"%s\" are two",
                           in->column, name);
    in->column = name;
    return n;
  }
  while (in_name(text[first])) first++;
  const char *name = deck_copy(in->d, text, first);
  if (!in->other && text[first + strspn(text + first, " ")] != '(' && strcmp(name, "pi") != 0 &&
      !deck_has_constant(in->d, name))
    in->other = name;
  return 0;
}

void deck_columns_resolve(deck_group *g, deck_columns *t, deck_column_there *there, void *file) {
  for (size_t c = 0; c < t->n_columns; c++) {
    const char *text = t->source[c];
    if (t->column[c] >= COLUMN_NUMBERS || !strpbrk(text, "*/+-^(") || there(file, text)) continue;
    named in = {.d = g->d, .there = there, .file = file};
    const char *wrong = deck_expression_names(g->d, text, find_column, &in);
    if (!wrong && !in.column && !in.other) wrong = "it names no column of the file";
    if (wrong)
      deck_fail_key(g, "columns", "\"%s = %s\": %s", deck_column_names[t->column[c]],
                    deck_quote(g->d, text, strlen(text)), wrong);
    else
      t->source[c] = in.column ? in.column : in.other;
    t->formula[c] = text;
  }
}

/* Gives the value in the file to the name of the column (deck_lookup). */
static size_t column_value(void *user, const char *text, bool rate, double *x, const char **wrong) {
  (void)rate, (void)wrong;
  const named *in = user;
  const size_t n = strlen(in->column);
  if (strncmp(text, in->column, n) != 0 || (in_name(text[n - 1]) && in_name(text[n]))) return 0;
  *x = in->value;
  return n;
}

double deck_columns_value(deck *d, const deck_columns *t, size_t c, double value,
                          deck_place place) {
  if (!t->formula[c] || !isfinite(value)) return value;
  named in = {.column = t->source[c], .value = value};
  double x = NAN;
  const char *wrong = deck_expression_with(d, t->formula[c], column_value, &in, 0, &x);
  if (!wrong) return x;
  if (*wrong)
    deck_fail_place(d, place, "%s = %s with %s = %g: %s", deck_column_names[t->column[c]],
                    t->formula[c], in.column, value, wrong);
  return NAN;
}

/* --- the key `columns` ------------------------------------------------------------------------ */

static const char *trimmed(deck *d, const char *text) {
  while (isspace((unsigned char)*text)) text++;
  size_t n = strlen(text);
  while (n && isspace((unsigned char)text[n - 1])) n--;
  return deck_copy(d, text, n);
}

/* Parses an entry of `columns`, such as "radius" or "radius = NAME IN THE FILE", and adds the
 * column to the table. */
bool deck_columns_add(deck *d, deck_columns *table, const char *text, const deck_node *node,
                      deck_place place) {
  const char *equals = strchr(text, '=');
  size_t n = equals ? (size_t)(equals - text) : strlen(text);
  while (n && isspace((unsigned char)text[n - 1])) n--;
  const char *name = deck_copy(d, text, n);
  int column = deck_column(name);
  const char *wrong = NULL;
  if (column < 0) {
    const char *hint = NULL;
    for (int k = 0; k < COLUMN_KINDS && !hint; k++) hint = deck_columns_hint(d, k, name);
    wrong = deck_format(d, "no column of disks is called \"%s\"; %s%s%s", deck_quote(d, text, n),
                        hint ? "did you mean \"" : "expected ", hint ? hint : names_of_columns(d),
                        hint ? "\"?" : "");
  }
  for (size_t k = 0; k < table->n_columns && !wrong; k++)
    if (table->column[k] == column) wrong = deck_format(d, "column \"%s\" is there twice", name);
  if (wrong && node) deck_fail(d, node, "%s", wrong);
  if (wrong && !node) deck_fail_place(d, place, "%s", wrong);
  if (wrong) return false;
  table->source[table->n_columns] = equals ? trimmed(d, equals + 1) : name;
  table->column[table->n_columns++] = column;
  return true;
}

void deck_columns_read(deck_group *g, deck_columns *table) {
  deck_node *list = deck_get(g, "columns");
  if (!list && g->table == &deck_disk_rows)
    deck_fail_key(g, "columns", "missing: expected (\"x\", \"y\", \"radius\") or the like");
  for (size_t k = 0; k < deck_each_count(list); k++) {
    deck_node *node = deck_each(list, k);
    if (node->type == DECK_STRING && g->table == &deck_disk_rows && strchr(node->value.text, '='))
      deck_fail(g->d, node, "expected a name alone: the values are those of the rows");
    else if (node->type == DECK_STRING)
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
