/* deck_averages.c: reads measure.averages, means of columns of the series, of sums of columns and
 * of ratios of such sums.
 *
 * deck_expression evaluates a sum at several values of its columns, which gives the constant and
 * the factors; two further points show whether it is a sum at all. */
#include <ctype.h>
#include <math.h>
#include <string.h>

#include "base/limits.h"
#include "base/memory.h"
#include "io/deck/deck_read.h"
#include "measure/average.h"

static const char expected[] =
    "expected a sum of columns with factors, or a ratio of two, as (stress_xx - stress_yy)/(2 * "
    "stress_yy)";

/* A sum that is being read: its columns, and a value for each of them. */
typedef struct reader {
  deck *d;
  sd_average_sum sum;
  double value[SD_AVERAGE_TERMS];
} reader;

/* --- names of columns ------------------------------------------------------------------------- */

static size_t word_length(const char *p) {
  size_t n = 0;
  while (isalpha((unsigned char)p[n]) || p[n] == '_' || (n > 0 && isdigit((unsigned char)p[n])))
    n++;
  return n;
}

static size_t blanks(const char *p) { return strspn(p, " \t\r\n"); }

static bool find_column(const char *name, uint32_t *column) {
  const observable *o;
  for (*column = 0; (o = average_column(*column)); ++*column)
    if (strcmp(o->name, name) == 0) return true;
  return false;
}

/* Returns true if the model records this column; if the deck only has to ask for it (measure.box,
 * stress, walls ...), asks. */
static bool records(sd_model *m, const observable *o) {
  if (!o->when || o->when(m)) return true;
  for (size_t k = 0; k < deck_measure.n; k++) {
    const deck_key *flag = &deck_measure.key[k];
    if (flag->target != DECK_SETS_BOOL) continue;
    const double before = deck_key_value(flag, m);
    deck_key_store(flag, m, 1.0);
    if (o->when(m)) return true;
    deck_key_store(flag, m, before);
  }
  return false;
}

/* Returns the name of element k of a column, that of a disk, wall or group; its number if it has no
 * name. */
static const char *element_name(deck *d, const observable *o, size_t k) {
  const sd_model *m = d->model;
  const uint32_t disk = o->width == OBSERVABLE_WATCHED  ? m->rotations[k]
                        : o->width == OBSERVABLE_CHOSEN ? m->contact_disks[k]
                                                        : 0;
  if (o->width == OBSERVABLE_GROUPS) return m->groups[k];
  const char *name = o->width == OBSERVABLE_WALLS ? m->walls[k].name : m->disks[disk].name;
  return name ? name : deck_format(d, "%zu", o->width == OBSERVABLE_WALLS ? k : (size_t)disk);
}

/* Finds the element of a column that `text`, such as "[bottom]", names; without a text the column
 * must have one element. Returns an error message; NULL: found. */
static const char *find_element(deck *d, const observable *o, const char *text, uint32_t *element) {
  const size_t n = observable_width(o, d->model);
  guess near = guess_start(text ? text : "");
  if (!text && n == 1) return NULL;
  for (size_t k = 0; text && o->width != 1 && k < n; k++) {
    const char *name = element_name(d, o, k);
    *element = (uint32_t)k;
    if (strcmp(name, text) == 0) return NULL;
    guess_add(&near, name);
  }
  if (o->width == 1) return deck_format(d, "%s has no elements; expected no brackets", o->name);
  if (!text)
    return deck_format(d, "%s has %zu elements; expected the name of one, as %s[%s]", o->name, n,
                       o->name, element_name(d, o, 0));
  return deck_format(d, "%s has no element \"%s\"%s", o->name, text, deck_hint(d, &near));
}

/* Reads the name of a column at the beginning of a text, as "pressure" or "wall_force_y[bottom]".
 * Returns its length; 0: there is none. */
static size_t read_column(reader *r, const char *text, sd_average_term *t, const char **wrong) {
  deck *d = r->d;
  size_t n = word_length(text), inner = n + blanks(text + n);
  const char *name = deck_copy(d, text, n), *element = NULL;
  if (n == 0 || !find_column(name, &t->column)) return 0;
  const observable *o = average_column(t->column);
  if (text[inner] == '[') {
    const char *from = text + inner + 1, *end = strchr(from, ']');
    if (end) {
      from += blanks(from);
      size_t length = (size_t)(end - from);
      while (length > 0 && isspace((unsigned char)from[length - 1])) length--;
      element = deck_copy(d, from, length);
      n = (size_t)(end + 1 - text);
    } else {
      *wrong = "a ] is missing";
    }
  }
  if (deck_has_constant(d, name))
    *wrong = deck_format(d,
                         "%s is a constant of the deck and a column of the series; expected "
                         "another name of the constant",
                         name);
  else if (!*wrong && !records(d->model, o))
    *wrong = deck_format(d, "the series of this run does not have %s: %s", name, o->meaning);
  else if (!*wrong)
    *wrong = find_element(d, o, element, &t->element);
  return n;
}

/* Adds a column to the sum, unless it is there. Returns its index; SD_AVERAGE_TERMS: too many. */
static size_t add_term(reader *r, const sd_average_term *t) {
  sd_average_sum *s = &r->sum;
  size_t k = 0;
  while (k < s->n && (s->term[k].column != t->column || s->term[k].element != t->element ||
                      s->term[k].rate != t->rate))
    k++;
  if (k == s->n && k < SD_AVERAGE_TERMS) s->term[s->n++] = *t;
  return k;
}

/* Looks up a column (deck_lookup). */
static size_t look_up(void *user, const char *text, bool rate, double *x, const char **wrong) {
  reader *r = user;
  deck *d = r->d;
  sd_average_term term = {.rate = rate};
  const size_t n = read_column(r, text, &term, wrong), length = word_length(text);
  const char *name = deck_copy(d, text, length);
  if (n == 0) {
    if (text[length + blanks(text + length)] == '(' || deck_has_constant(d, name) ||
        strcmp(name, "pi") == 0)
      return 0;
    guess near = guess_start(name);
    for (uint32_t k = 0; average_column(k); k++) guess_add(&near, average_column(k)->name);
    *wrong = deck_format(d, "no column of the series and no constant is called \"%s\"%s",
                         deck_quote(d, name, length), deck_hint(d, &near));
  }
  const size_t k = *wrong ? 0 : add_term(r, &term);
  if (k == SD_AVERAGE_TERMS)
    *wrong = deck_format(d, "expected at most %d columns in a sum", SD_AVERAGE_TERMS);
  if (!*wrong) *x = r->value[k];
  return n;
}

/* --- sums and ratios -------------------------------------------------------------------------- */

/* Returns true if the text names a column of the series. */
static bool has_column(deck *d, const char *text) {
  uint32_t column;
  for (size_t n; *text; text += n > 0 ? n : 1) {
    n = word_length(text);
    if (n > 0 && find_column(deck_copy(d, text, n), &column)) return true;
  }
  return false;
}

/* Returns true if p, in the text that begins at `text`, is an operator between two operands, not a
 * sign nor part of a number such as 1e-3. */
static bool is_operator(const char *text, const char *p) {
  if (!strchr("+-*/", *p)) return false;
  const char *before = p;
  while (before > text && isspace((unsigned char)before[-1])) before--;
  if (before == text || strchr("+-*/^(", before[-1])) return false;
  const bool exponent = before == p && p - text > 1 && strchr("eE", p[-1]) &&
                        (isdigit((unsigned char)p[-2]) || p[-2] == '.');
  return *p == '*' || *p == '/' || !exponent;
}

/* Returns the next operator outside brackets that is one of `which`, from `from` on; NULL: none. */
static const char *next_operator(const char *text, const char *from, const char *which) {
  int depth = 0;
  for (const char *p = text; *p; p++) {
    depth += (*p == '(' || *p == '[') - (*p == ')' || *p == ']');
    if (depth == 0 && p >= from && strchr(which, *p) && is_operator(text, p)) return p;
  }
  return NULL;
}

/* Value of column k at the point at which a sum is tested. */
static double test_value(size_t k) { return 1 + 0.37 * sqrt((double)k + 2); }

/* Evaluates the sum where column k has the value test_value(k) * scale, or, if `one` is an index,
 * where the column `one` has the value 1 and all others are 0. */
static const char *evaluate(reader *r, const char *text, double scale, size_t one, double *x) {
  for (size_t k = 0; k < SD_AVERAGE_TERMS; k++)
    r->value[k] = one == SIZE_MAX ? test_value(k) * scale : k == one ? 1 : 0;
  return deck_expression_with(r->d, text, look_up, r, 1, x);
}

/* Reads a sum of columns with factors. Returns an error message; NULL: it is one. */
static const char *read_sum(deck *d, const char *text, sd_average_sum *sum) {
  reader r = {.d = d};
  double above, below, part = 0, size;
  const char *wrong = evaluate(&r, text, 1, SIZE_MAX, &above);
  if (wrong) return wrong;
  if (evaluate(&r, text, -1, SIZE_MAX, &below) || evaluate(&r, text, 0, SIZE_MAX, &r.sum.constant))
    return expected;
  /* A constant inside of rate( ) changes this value of the sum. */
  if (deck_expression_with(d, text, look_up, &r, 2, &size) || size != r.sum.constant)
    return "a constant in rate( ): expected columns with factors";
  size = fabs(r.sum.constant) + fabs(above) + fabs(below);
  for (size_t k = 0; k < r.sum.n; k++) {
    double *factor = &r.sum.term[k].factor;
    if (evaluate(&r, text, 1, k, factor)) return expected;
    *factor -= r.sum.constant;
    part += *factor * test_value(k);
    size += fabs(*factor);
  }
  *sum = r.sum;
  const double off = fabs(r.sum.constant + part - above) + fabs(r.sum.constant - part - below);
  return off <= 1e-12 * size ? NULL : expected;
}

/* Reads a sum, or a ratio of two: the text is divided at its last / with columns behind. */
static const char *read_ratio(deck *d, const char *text, sd_average_watch *a) {
  const char *split = NULL;
  for (const char *p = next_operator(text, text, "/"); p; p = next_operator(text, p + 1, "/"))
    if (has_column(d, p + 1)) split = p;
  a->of[1].constant = 1;
  if (!split) return read_sum(d, text, &a->of[0]);
  const char *over = deck_copy(d, text, (size_t)(split - text)), *under = split + 1;
  if (next_operator(over, over, "+-") || next_operator(under, under, "+-*/")) return expected;
  const char *wrong = read_sum(d, over, &a->of[0]);
  if (!wrong) wrong = read_sum(d, under, &a->of[1]);
  return wrong;
}

static void read_average(deck *d, const deck_node *node) {
  sd_model *m = d->model;
  sd_average_watch a = {0};
  uint32_t body;
  if (node->type != DECK_STRING) {
    deck_fail(d, node, "expected a text, such as \"-stress_xy/stress_yy\"");
    return;
  }
  if (deck_index_find(&d->disks, node->name, &body) ||
      deck_index_find(&d->walls, node->name, &body))
    deck_fail(d, node,
              "a body is called \"%s\", too, and tables have columns by both names; "
              "expected another name",
              node->name);
  const char *wrong = read_ratio(d, node->value.text, &a);
  if (!wrong && a.of[0].n + a.of[1].n == 0) wrong = "it names no column of the series";
  if (wrong && *wrong) deck_fail(d, node, "%s", wrong);
  if (wrong) return;
  a.name = memory_text(node->name);
  a.text = memory_text(node->value.text);
  m->averages = memory_grow(m->averages, m->n_averages + 1, sizeof *m->averages);
  m->averages[m->n_averages++] = a;
}

/* Reports measured phases without a series, and phases whose series differ. */
static void check_rows(deck *d, const deck_node *group) {
  const sd_model *m = d->model;
  const int64_t every = average_interval(m);
  bool measured = false, same = true;
  for (size_t k = 0; k < m->n_phases; k++) {
    measured = measured || m->phases[k].measure;
    same = same && (!m->phases[k].measure || m->phases[k].series_every == every);
  }
  if (!measured)
    deck_fail(d, group, "no phase measures; expected measure = true in one");
  else if (!same)
    deck_fail(d, group,
              "phases that measure have different `series`; expected rows at one "
              "distance, as by output.series");
  else if (every == 0)
    deck_fail(d, group, "phases that measure have series = 0; expected rows to average");
}

void deck_read_averages(deck *d, const deck_node *group) {
  if (!group) return;
  if (group->type != DECK_GROUP) {
    deck_fail(d, group, "expected a group { name = \"expression\"; ... }");
    return;
  }
  for (size_t k = 0; k < group->n; k++) read_average(d, group->child[k]);
  if (d->model->n_phases > 0) check_rows(d, group);
}
