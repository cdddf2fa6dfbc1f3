/* deck_expression.c: arithmetic in texts, by recursive descent; see deck_expression.h.
 *
 *   sum     = product { (+ | -) product }
 *   product = signed { (* | /) signed | [*] unit }  unit: pi, deg, rad; "1/3 pi" is (1/3) pi
 *   signed  = { + | - } power
 *   power   = atom [ (^ | **) signed ]
 *   atom    = number | name | pi | function ( sum { , sum } ) | ( sum )
 *
 * libmuparser is not used: it reads "1/3 pi" as 1/(3 pi) and, through its interface for C, ends
 * the process at an expression longer than its buffer for messages. */
#include "io/deck/deck_expression.h"

#include <ctype.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/limits.h"
#include "base/math.h"
#include "io/deck/deck_read.h"

static const double pi = 3.14159265358979323846;

typedef struct parser {
  deck *d;
  const char *p;
  deck_names names;
  deck_lookup *lookup; /* Meaning of further names; NULL: there are none */
  void *user;
  double per_rate; /* Factor of what rate( ) encloses */
  int rates;       /* Number of rate( ) that enclose the current position */
  bool angle, empty;
  int depth;         /* Nesting depth of brackets and exponents at the current position */
  int functions;     /* Number of function calls that enclose the current position */
  const char *wrong; /* First mistake found; NULL: none */
} parser;

static double sum(parser *e);

/* --- functions, units and names --------------------------------------------------------------- */

static double lesser(double a, double b) { return a < b ? a : b; }
static double greater(double a, double b) { return a > b ? a : b; }

static const struct function {
  const char *name;
  double (*of)(double);
  double (*of_two)(double, double);
} functions[] = {
    {"sqrt", sqrt, NULL},        {"exp", math_exp, NULL},     {"log", math_log, NULL},
    {"log10", math_log10, NULL}, {"sin", math_sin, NULL},     {"cos", math_cos, NULL},
    {"tan", math_tan, NULL},     {"asin", math_asin, NULL},   {"acos", math_acos, NULL},
    {"atan", math_atan, NULL},   {"atan2", NULL, math_atan2}, {"hypot", NULL, math_hypot},
    {"abs", fabs, NULL},         {"floor", floor, NULL},      {"ceil", ceil, NULL},
    {"round", round, NULL},      {"min", NULL, lesser},       {"max", NULL, greater},
};
enum { FUNCTIONS = sizeof functions / sizeof *functions };

static const struct unit {
  const char *name;
  double factor;
} units[] = {{"pi", 3.14159265358979323846}, {"deg", 3.14159265358979323846 / 180}, {"rad", 1}};
enum { UNITS = sizeof units / sizeof *units };

/* Physical units that users may write. Such a word is not taken for a misspelt "deg", "rad" or
 * "pi". */
static const char *const foreign_units[] = {
    "m",   "dm",  "cm",   "mm",  "um", "nm", "km", "s",  "ms",  "us",  "ns",  "min", "h",
    "kg",  "g",   "mg",   "t",   "N",  "mN", "uN", "kN", "MN",  "Pa",  "kPa", "MPa", "GPa",
    "hPa", "bar", "mbar", "psi", "J",  "mJ", "W",  "Hz", "kHz", "MHz", "rpm", "rps", "K"};
enum { FOREIGN_UNITS = sizeof foreign_units / sizeof *foreign_units };

static bool same_word(const char *word, size_t n, const char *text) {
  return strlen(text) == n && memcmp(word, text, n) == 0;
}

static bool begins_name(char c) { return isalpha((unsigned char)c) || c == '_'; }

static size_t name_length(const char *p) {
  size_t n = 0;
  while (begins_name(p[n]) || (n > 0 && isdigit((unsigned char)p[n]))) n++;
  return n;
}

static const struct unit *find_unit(const char *name, size_t n) {
  for (size_t k = 0; k < UNITS; k++)
    if (same_word(name, n, units[k].name)) return &units[k];
  return NULL;
}

static bool is_foreign(const char *name, size_t n) {
  for (size_t k = 0; k < FOREIGN_UNITS; k++)
    if (same_word(name, n, foreign_units[k])) return true;
  return false;
}

static const struct function *find_function(const char *name, size_t n) {
  for (size_t k = 0; k < FUNCTIONS; k++)
    if (same_word(name, n, functions[k].name)) return &functions[k];
  return NULL;
}

/* --- grammar ---------------------------------------------------------------------------------- */

static double fail(parser *e, const char *why) {
  if (!e->wrong) e->wrong = why;
  e->p = ""; /* Leaves no text to parse, which ends parsing */
  return 1;
}

static void skip(parser *e) { e->p += strspn(e->p, " \t\r\n"); }

/* Skips blanks, then consumes the character c if it comes next. Returns whether it did. */
static bool take(parser *e, char c) {
  skip(e);
  if (*e->p != c) return false;
  e->p++;
  return true;
}

static const char *rest(parser *e) { return deck_quote(e->d, e->p, strlen(e->p)); }

static double unexpected(parser *e) {
  skip(e);
  return fail(e, *e->p      ? deck_format(e->d, "unexpected \"%s\"", rest(e))
                 : e->empty ? "expected a number"
                            : "the expression is not complete");
}

size_t deck_number_length(const char *p, bool *real) {
  const char *q = p;
  *real = false;
  if (*q == '+' || *q == '-') q++;
  const char *digits = q;
  while (isdigit((unsigned char)*q)) q++;
  size_t n = (size_t)(q - digits);
  if (*q == '.') {
    *real = true;
    for (q++; isdigit((unsigned char)*q); q++) n++;
  }
  if (n == 0) return 0;
  if (*q == 'e' || *q == 'E') {
    const char *e = q + 1;
    if (*e == '+' || *e == '-') e++;
    if (isdigit((unsigned char)*e)) {
      *real = true;
      for (q = e; isdigit((unsigned char)*q);) q++;
    }
  }
  return (size_t)(q - p);
}

static double number(parser *e) {
  bool real, nonzero = false;
  size_t n = deck_number_length(e->p, &real);
  if (n == 0) return unexpected(e);
  const char *token = deck_copy(e->d, e->p, n);
  double x = strtod(token, NULL);
  for (const char *p = token; *p && *p != 'e' && *p != 'E'; p++) nonzero |= *p >= '1' && *p <= '9';
  if (!isfinite(x) || (x == 0 && nonzero))
    return fail(e, deck_format(e->d, "%s: number too %s", deck_quote(e->d, token, n),
                               x == 0 ? "small" : "large"));
  e->p += n;
  return x;
}

static bool deeper(parser *e) {
  if (++e->depth <= LIMIT_DEPTH) return true;
  fail(e, deck_format(e->d, "more than %d brackets or powers inside each other", LIMIT_DEPTH));
  return false;
}

static double bracket(parser *e) {
  double x = deeper(e) ? sum(e) : 1;
  e->depth--;
  if (!e->wrong && !take(e, ')')) return *e->p ? unexpected(e) : fail(e, "a ) is missing");
  return x;
}

static double call(parser *e, const struct function *f) {
  double x[2] = {0, 0};
  if (!deeper(e)) return 1;
  e->functions++;
  x[0] = sum(e);
  if (f->of_two && !e->wrong) {
    if (!take(e, ','))
      return fail(e, deck_format(e->d, "%s takes two numbers with a comma between", f->name));
    x[1] = sum(e);
  }
  e->functions--;
  e->depth--;
  if (!e->wrong && !take(e, ')')) return *e->p ? unexpected(e) : fail(e, "a ) is missing");
  double y = f->of_two ? f->of_two(x[0], x[1]) : f->of(x[0]);
  if (isfinite(y) || e->wrong || e->names == DECK_NAMES_ANY) return y;
  return fail(e, deck_format(e->d, "%s of %.10g is %s", f->name, x[0],
                             isnan(y) ? "no number" : "not finite"));
}

static double of_unit(parser *e, const struct unit *u) {
  e->p += strlen(u->name);
  if (u->factor == pi || e->angle || e->functions > 0 || e->names == DECK_NAMES_ANY)
    return u->factor;
  return fail(e, deck_format(e->d, "%s belongs to angles; expected a number", u->name));
}

static const char *constant_value(deck *d, const char *name, double *x);

/* Reads rate(SUM), the rate of change of a sum of names that `lookup` knows. */
static double rate(parser *e) {
  e->p += strlen("rate");
  if (!take(e, '(')) return fail(e, "expected rate(SUM), with columns in SUM");
  if (e->rates++ > 0) return fail(e, "a rate of a rate");
  double x = e->per_rate * bracket(e);
  e->rates--;
  return x;
}

static double word(parser *e) {
  const char *start = e->p, *unknown = NULL;
  double x = 1;
  size_t n = name_length(start);
  if (e->per_rate != 0 && same_word(start, n, "rate")) return rate(e);
  const size_t taken = e->lookup ? e->lookup(e->user, start, e->rates > 0, &x, &unknown) : 0;
  if (unknown) return fail(e, unknown);
  e->p += taken;
  if (taken > 0) return x;
  const struct unit *u = find_unit(start, n);
  if (u) return u->factor == pi ? of_unit(e, u) : unexpected(e);
  e->p += n;
  const char *name = deck_copy(e->d, start, n);
  skip(e);
  if (*e->p == '(') {
    const struct function *f = find_function(start, n);
    e->p++;
    if (f) return call(e, f);
    guess near = guess_start(name);
    for (size_t k = 0; k < FUNCTIONS; k++) guess_add(&near, functions[k].name);
    return fail(e, deck_format(e->d, "no function is called \"%s\"%s", deck_quote(e->d, name, n),
                               deck_hint(e->d, &near)));
  }
  const char *wrong = e->names == DECK_NAMES_CONSTANTS ? constant_value(e->d, name, &x)
                      : e->names == DECK_NAMES_ANY     ? NULL
                                                       : "no constants here";
  return wrong ? fail(e, wrong) : x;
}

static double atom(parser *e) {
  skip(e);
  if (take(e, '(')) return bracket(e);
  if (begins_name(*e->p)) return word(e);
  return isdigit((unsigned char)*e->p) || *e->p == '.' ? number(e) : unexpected(e);
}

static double signed_power(parser *e);

static double power(parser *e) {
  double x = atom(e);
  skip(e);
  bool two = e->p[0] == '*' && e->p[1] == '*';
  if (!two && *e->p != '^') return x;
  e->p += 1 + two;
  double y = deeper(e) ? signed_power(e) : 1;
  e->depth--;
  return math_pow(x, y);
}

static double signed_power(parser *e) {
  bool minus = false;
  for (skip(e); *e->p == '-' || *e->p == '+'; skip(e)) minus ^= *e->p++ == '-';
  double x = power(e);
  return minus ? -x : x;
}

/* Reports an error for text that follows a number or a bracket without an operator. */
static double behind(parser *e) {
  size_t n = name_length(e->p);
  if (n == 0)
    return fail(e, deck_format(e->d, "a comma or an operator is missing before \"%s\"", rest(e)));
  guess near = guess_start(deck_copy(e->d, e->p, n));
  for (size_t k = 0; k < UNITS && !is_foreign(e->p, n); k++) {
    guess_add(&near, units[k].name);
    /* A longer word with the same first three letters, such as "degrees", is taken for this unit
     * too */
    if (n > 3 && strncmp(e->p, units[k].name, 3) == 0) near.best = units[k].name;
  }
  if (near.best)
    return fail(e, deck_format(e->d, "\"%s\" behind a number%s", rest(e), deck_hint(e->d, &near)));
  return fail(
      e, deck_format(
             e->d,
             "\"%s\": units are not written, any consistent set will do; expected the bare number "
             "(a product needs *)",
             rest(e)));
}

static double product(parser *e) {
  double x = signed_power(e);
  bool has_unit = false;
  for (skip(e); *e->p && !e->wrong; skip(e)) {
    const char *start = e->p;
    bool times = take(e, '*');
    skip(e);
    const struct unit *u = find_unit(e->p, name_length(e->p));
    if (u && !has_unit && !(times && u->factor == pi)) {
      x *= of_unit(e, u);
      has_unit = !times;
    } else if (times) {
      x *= signed_power(e);
    } else if (take(e, '/')) {
      double divisor = signed_power(e);
      if (divisor == 0 && e->names != DECK_NAMES_ANY) return fail(e, "division by zero");
      x /= divisor;
    } else if (u) {
      return unexpected(e);
    } else if (begins_name(*start) || isdigit((unsigned char)*start) || strchr(".(", *start)) {
      return behind(e);
    } else {
      break;
    }
  }
  return x;
}

static double sum(parser *e) {
  double x = product(e);
  while (!e->wrong) {
    if (take(e, '+'))
      x += product(e);
    else if (take(e, '-'))
      x -= product(e);
    else
      break;
  }
  return x;
}

static const char *evaluate(parser *e, double *x) {
  e->empty = e->p[strspn(e->p, " \t\r\n")] == 0;
  *x = sum(e);
  skip(e);
  if (!e->wrong && *e->p) unexpected(e);
  if (!e->wrong && !isfinite(*x) && e->names != DECK_NAMES_ANY) fail(e, "the value is not finite");
  return e->wrong;
}

const char *deck_expression(deck *d, const char *text, deck_names names, bool angle, double *x) {
  return evaluate(&(parser){.d = d, .p = text, .names = names, .angle = angle}, x);
}

const char *deck_expression_with(deck *d, const char *text, deck_lookup *lookup, void *user,
                                 double per_rate, double *x) {
  parser e = {.d = d,
              .p = text,
              .names = DECK_NAMES_CONSTANTS,
              .lookup = lookup,
              .user = user,
              .per_rate = per_rate};
  return evaluate(&e, x);
}

const char *deck_expression_names(deck *d, const char *text, deck_lookup *lookup, void *user) {
  double x;
  return evaluate(
      &(parser){.d = d, .p = text, .names = DECK_NAMES_ANY, .lookup = lookup, .user = user}, &x);
}

bool deck_arithmetic(deck *d, const char *text, double *x) {
  return !deck_expression(d, text, DECK_NAMES_NONE, true, x);
}

/* --- constants -------------------------------------------------------------------------------- */

typedef enum constant_state { UNREAD, OPEN, GOOD, WRONG } constant_state;

struct deck_constants {
  deck_index index;
  deck_node **node;
  constant_state *state;
  bool *used; /* True if an expression has the constant */
  double *value;
  int depth; /* Number of constants being evaluated, each referred to by the one before */
};

static struct deck_constants *constants_of(deck *d) {
  if (d->constants) return d->constants;
  struct deck_constants *c = d->constants = deck_alloc(d, 1, sizeof *c);
  deck_node *group = deck_child(d->root, "constants");
  if (!group || group->type != DECK_GROUP) return c;
  c->node = deck_alloc(d, group->n + 1, sizeof *c->node);
  c->state = deck_alloc(d, group->n + 1, sizeof *c->state);
  c->used = deck_alloc(d, group->n + 1, sizeof *c->used);
  c->value = deck_alloc(d, group->n + 1, sizeof *c->value);
  for (size_t k = 0; k < group->n; k++)
    if (deck_index_add(d, &c->index, group->child[k]->name, (uint32_t)k))
      c->node[k] = group->child[k];
  return c;
}

bool deck_has_constant(deck *d, const char *name) {
  uint32_t k;
  return deck_index_find(&constants_of(d)->index, name, &k);
}

static bool good_name(deck *d, const deck_node *node) {
  size_t n = strlen(node->name);
  if (name_length(node->name) != n)
    deck_fail(d, node, "expected a name of letters, digits and _, a letter first");
  else if (find_unit(node->name, n) || find_function(node->name, n))
    deck_fail(d, node, "%s has a meaning of its own; expected another name", node->name);
  else
    return true;
  return false;
}

static void read_constant(deck *d, struct deck_constants *c, size_t k) {
  if (c->state[k] != UNREAD) return;
  c->state[k] = OPEN;
  c->depth++;
  bool good = good_name(d, c->node[k]) && deck_value_number(d, c->node[k], true, &c->value[k]);
  c->depth--;
  c->state[k] = good ? GOOD : WRONG;
}

/* Evaluates the constant with this name. Returns NULL on success, "" if the constant has an error
 * that was reported already, else an error message. */
static const char *constant_value(deck *d, const char *name, double *x) {
  struct deck_constants *c = constants_of(d);
  uint32_t k;
  const char *shown = deck_quote(d, name, strlen(name));
  if (!deck_index_find(&c->index, name, &k)) {
    guess near = guess_start(name);
    deck_index_guess(d, &c->index, &near);
    if (near.best)
      return deck_format(d, "no constant is called \"%s\"%s", shown, deck_hint(d, &near));
    return deck_format(d, "expected a number; no constant is called \"%s\"%s", shown,
                       is_foreign(name, strlen(name)) ? "; units are not written" : "");
  }
  if (c->state[k] == OPEN) return deck_format(d, "%s depends on itself", shown);
  if (c->depth >= LIMIT_DEPTH)
    return deck_format(d, "more than %d constants that follow from each other", LIMIT_DEPTH);
  c->used[k] = true;
  read_constant(d, c, k);
  *x = c->value[k];
  return c->state[k] == GOOD ? NULL : "";
}

void deck_read_constants(deck *d) {
  deck_node *group = deck_child(d->root, "constants");
  if (group && group->type != DECK_GROUP) {
    deck_fail(d, group, "expected a group { name = number; ... }");
    return;
  }
  struct deck_constants *c = constants_of(d);
  for (size_t k = 0; k < c->index.n; k++) read_constant(d, c, k);
}

void deck_check_constants(deck *d) {
  struct deck_constants *c = constants_of(d);
  for (size_t k = 0; k < c->index.n; k++) {
    if (!c->node[k]->added || c->used[k]) continue;
    guess near = guess_start(c->index.name[k].name);
    for (size_t other = 0; other < c->index.n; other++)
      if (other != k) guess_add(&near, c->index.name[other].name);
    deck_fail(d, c->node[k], "the deck has no such constant and uses none%s", deck_hint(d, &near));
  }
}

/* --- numbers of the deck ---------------------------------------------------------------------- */

/* Returns the end of the message "expected a number, not ...". It depends only on the type of the
 * value, so that a sweep reports each type once. */
static const char *but_not(const deck_node *node) {
  switch (node->type) {
    case DECK_BOOL: return ", not true or false";
    case DECK_LIST: return ", not a list";
    case DECK_GROUP: return ", not a group";
    default: return "";
  }
}

/* Returns the value that the full deck shows after an arithmetic text; NULL if the text shows the
 * value itself, such as a plain number or the angle "0.04 pi". */
static const char *computed_value(deck *d, const char *text, bool angle, double x) {
  bool real;
  double same;
  if (deck_number_length(text, &real) == strlen(text)) return NULL;
  if (angle && !strchr(text, '(') && deck_arithmetic(d, text, &same)) return NULL;
  char value[32];
  deck_number_text(x, value);
  size_t n = strlen(value);
  return deck_copy(d, value, n > 2 && strcmp(value + n - 2, ".0") == 0 ? n - 2 : n);
}

static bool text_number(deck *d, deck_node *node, bool angle, double *x) {
  const char *wrong = deck_expression(d, node->value.text, DECK_NAMES_CONSTANTS, angle, x);
  if (!wrong && !deck_in_range(DECK_ANY, *x))
    wrong = deck_format(d, "it is %g; expected a number %s", *x, deck_expected(DECK_ANY, *x));
  if (!wrong) {
    node->remark = computed_value(d, node->value.text, angle, *x);
    return true;
  }
  if (*wrong) deck_fail(d, node, "%s", wrong);
  *x = 0;
  return false;
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
  if (node->type == DECK_STRING) return text_number(d, node, angle, x);
  if (angle)
    deck_fail(d, node, "expected a number or a text such as \"0.04 pi\" or \"7.2 deg\"%s",
              but_not(node));
  else
    deck_fail(d, node, "expected a number%s", but_not(node));
  return false;
}
