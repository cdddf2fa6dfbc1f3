/* deck_grid.c: reads the group `sweep`; see deck_grid.h.
 *
 * A value of a parameter keeps the text that is written in the deck, since this text becomes part
 * of file names, and is applied as the setting -D path=value. Computed values (linspace, logspace)
 * are rounded to 12 digits, and the rounded number is used. */
#include "io/deck/deck_grid.h"

#include <ctype.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/math.h"
#include "io/deck/deck_expression.h"
#include "io/deck/deck_read.h"
#include "io/results/summary.h"

/* --- values ----------------------------------------------------------------------------------- */

/* Returns the shortest text that reads back as the same number: 0.0001, 1e-05, 100000. */
static const char *number_text(deck *d, double x) {
  char text[40];
  if (x == floor(x) && fabs(x) < 1e15) {
    snprintf(text, sizeof text, "%.0f", x == 0 ? 0 : x);
  } else {
    for (int digits = 1; digits <= 17; digits++) {
      snprintf(text, sizeof text, "%.*g", digits, x);
      if (strtod(text, NULL) == x) break;
    }
  }
  return deck_copy(d, text, strlen(text));
}

static bool has_group(const deck_node *node) {
  bool found = node->type == DECK_GROUP;
  for (size_t k = 0; node->type == DECK_LIST && k < node->n; k++)
    found = found || has_group(node->child[k]);
  return found;
}

static grid_value value_of(deck *d, const deck_node *node) {
  grid_value v = {.text = "", .literal = "", .number = NAN, .place = node->place};
  if (has_group(node)) {
    deck_fail(d, node, "expected a number, a text, true, false or a list of them");
    return v;
  }
  v.text = v.literal = deck_value_text(d, node);
  if (node->type == DECK_INT) {
    v.number = (double)node->value.integer;
    v.text = v.literal = deck_format(d, "%lld", (long long)node->value.integer);
  } else if (node->type == DECK_FLOAT) {
    v.number = node->value.number;
    v.text = v.literal = number_text(d, v.number);
  } else if (node->type == DECK_STRING) {
    v.text = node->value.text;
    if (!deck_arithmetic(d, v.text, &v.number)) v.number = NAN;
  }
  return v;
}

static void read_values(deck_group *g, grid_axis *a) {
  deck_node *list = deck_get(g, "values");
  if (!list) return;
  if (list->type != DECK_LIST || list->n == 0) {
    deck_fail(g->d, list, "expected a list of values ( a, b, c )");
    return;
  }
  a->values = deck_alloc(g->d, list->n, sizeof *a->values);
  for (size_t k = 0; k < list->n; k++) a->values[a->n_values++] = value_of(g->d, list->child[k]);
}

/* Returns true if the text is a number with the unit `word`, such as "0.1 pi", and not a
 * formula. */
static bool has_word(const char *text, const char *word) {
  const char *at = strstr(text, word);
  return at && !isalpha((unsigned char)at[strlen(word)]) &&
         !(at > text && isalpha((unsigned char)at[-1])) && strcspn(text, "(_") == strlen(text);
}

/* Returns the factor of the unit (pi, pi/180 or 1) in which both ends of a range are written.
 * *suffix: receives the name of the unit, "pi" or "deg"; NULL without a unit. */
static double unit_of(const deck_node *list, const char **suffix) {
  static const struct {
    const char *word;
    double factor;
  } units[] = {{"pi", 3.14159265358979323846}, {"deg", 3.14159265358979323846 / 180}};
  for (size_t u = 0; u < 2; u++) {
    size_t with = 0, zero = 0;
    for (size_t k = 0; k < 2; k++) {
      const deck_node *end = list->child[k];
      with += end->type == DECK_STRING && has_word(end->value.text, units[u].word);
      zero += (end->type == DECK_INT && end->value.integer == 0) ||
              (end->type == DECK_FLOAT && end->value.number == 0);
    }
    *suffix = units[u].word;
    if (with > 0 && with + zero == 2) return units[u].factor;
  }
  *suffix = NULL;
  return 1;
}

/* Returns a computed number as a value of the sweep, rounded to 12 digits. suffix, unit: name and
 * factor of its unit, as unit_of finds them. */
static grid_value number_value(deck *d, double x, const char *suffix, double unit,
                               deck_place place) {
  const char *text = number_text(d, strtod(deck_format(d, "%.12g", x), NULL));
  grid_value v = {.text = text, .literal = text, .number = strtod(text, NULL), .place = place};
  if (suffix) {
    v.text = deck_format(d, "%s %s", text, suffix);
    v.literal = deck_format(d, "\"%s\"", v.text);
    if (!deck_arithmetic(d, v.text, &v.number)) v.number *= unit;
  }
  return v;
}

/* Returns value k of the n values of a range from end[0] to end[1]. A linear value that is 0 except
 * for rounding becomes exactly 0. */
static double range_value(const double end[2], size_t k, size_t n, bool logarithmic) {
  if (k == 0) return end[0];
  if (k + 1 == n) return end[1];
  double s = (double)k / (double)(n - 1);
  if (logarithmic) return end[0] * math_pow(end[1] / end[0], s);
  double x = end[0] + (end[1] - end[0]) * s;
  return fabs(x) < 1e-12 * (fabs(end[0]) + fabs(end[1])) ? 0 : x;
}

/* Reads the key linspace or logspace, a list (first, last, count), and sets the values of the
 * axis. */
static void read_range(deck_group *g, const char *key, bool logarithmic, grid_axis *a) {
  deck *d = g->d;
  deck_node *list = deck_get(g, key);
  if (!list) return;
  if (list->type != DECK_LIST || list->n != 3) {
    deck_fail(d, list, "expected (first, last, count)");
    return;
  }
  const char *suffix;
  double unit = unit_of(list, &suffix), end[2], count;
  for (size_t k = 0; k < 2; k++) {
    if (!deck_value_number(d, list->child[k], true, &end[k])) return;
    end[k] /= unit;
  }
  if (!deck_value_number(d, list->child[2], false, &count)) return;
  if (!(count >= 1 && count <= GRID_MOST && count == floor(count))) {
    deck_fail(d, list, "expected a whole number from 1 to %d as the count", GRID_MOST);
    return;
  }
  if (logarithmic && (end[0] == 0 || end[1] == 0 || signbit(end[0]) != signbit(end[1]))) {
    deck_fail(d, list, "expected two numbers of the same sign, none of them 0");
    return;
  }
  size_t n = (size_t)count;
  a->values = deck_alloc(d, n, sizeof *a->values);
  for (size_t k = 0; k < n; k++)
    a->values[a->n_values++] =
        number_value(d, range_value(end, k, n, logarithmic), suffix, unit, list->place);
}

/* --- parameters ------------------------------------------------------------------------------- */

static bool good_name(const char *name) {
  static const char letters[] = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_.-";
  return *name && !strchr("_.-", *name) && strspn(name, letters) == strlen(name);
}

static void read_paths(deck_group *g, grid_axis *a) {
  deck *d = g->d;
  deck_node *path = deck_get(g, "path");
  if (!path) deck_fail_key(g, "path", "missing: expected the key to set, such as \"gravity.tilt\"");
  if (path && deck_each_count(path) == 0)
    deck_fail(d, path, "expected the path of a key, such as \"gravity.tilt\"");
  a->paths = deck_alloc(d, deck_each_count(path) + 1, sizeof *a->paths);
  for (size_t k = 0; k < deck_each_count(path); k++) {
    const deck_node *one = deck_each(path, k);
    const char *text = one->type == DECK_STRING ? one->value.text : "";
    if (!*text || strpbrk(text, "=\n"))
      deck_fail(d, one, "expected the path of a key, such as \"gravity.tilt\"");
    else if (strncmp(text, "sweep", 5) == 0 && strchr(".[", text[5]))
      deck_fail(d, one, "a sweep cannot vary itself");
    else
      a->paths[a->n_paths++] = text;
  }
}

static void read_axis(deck *d, deck_node *node, grid_axis *a) {
  deck_group g;
  *a = (grid_axis){.node = node};
  if (!deck_enter(d, node, &deck_sweep_parameters, &g)) return;
  read_paths(&g, a);
  a->name = deck_text_of(&g, "name");
  a->named = a->name != NULL;
  if (a->name && !good_name(a->name))
    deck_fail_key(&g, "name", "expected letters, digits, and _ . - only, a letter or digit first");

  deck_one_of(&g, "values, linspace or logspace");
  read_values(&g, a);
  read_range(&g, "linspace", false, a);
  read_range(&g, "logspace", true, a);
}

/* Assigns a dimension of the grid to each axis: axes with the same word `zip` share a dimension, so
 * that their values advance together. */
static void find_dimensions(deck *d, grid *g) {
  g->length = deck_alloc(d, g->n_axes + 1, sizeof *g->length);
  for (size_t k = 0; k < g->n_axes; k++) {
    grid_axis *a = &g->axes[k];
    const deck_node *zip = deck_child(a->node, "zip");
    bool joined = false;
    for (size_t j = 0; j < k && zip && zip->type == DECK_STRING && !joined; j++) {
      const deck_node *other = deck_child(g->axes[j].node, "zip");
      if (!other || other->type != DECK_STRING || strcmp(other->value.text, zip->value.text) != 0)
        continue;
      joined = true;
      a->dimension = g->axes[j].dimension;
      if (a->n_values != g->length[a->dimension] && a->n_values > 0 && g->length[a->dimension] > 0)
        deck_fail(d, zip, "%zu values here, and %zu in the parameter before it with the same word",
                  a->n_values, g->length[a->dimension]);
    }
    if (zip && zip->type != DECK_STRING) deck_fail(d, zip, "expected a text in quotes");
    if (joined) continue;
    a->dimension = g->n_dimensions;
    g->length[g->n_dimensions++] = a->n_values;
  }
}

static bool has_path(const grid_axis *a, const char *path) {
  for (size_t k = 0; k < a->n_paths; k++)
    if (strcmp(a->paths[k], path) == 0) return true;
  return false;
}

/* Reports an error if path p of axis a sets a key that an earlier path of the grid sets too, or an
 * alternative of it. Two paths of one axis may set the same key. At most one error is reported. */
static void check_path(deck *d, const grid *g, const grid_axis *a, size_t p) {
  for (const grid_axis *other = g->axes; other <= a; other++)
    for (size_t q = 0; q < (other == a ? p : other->n_paths); q++) {
      deck_paths_relation met = deck_paths_compare(d, a->paths[p], other->paths[q]);
      if (met == DECK_DIFFERENT_KEYS || (other == a && met == DECK_SAME_KEY)) continue;
      const deck_place *place = &deck_child(other->node, "path")->place;
      const char *where =
          place->line > 0 ? deck_format(d, "%s:%d", place->file, place->line) : place->file;
      const char *whose = other == a ? "this" : "another";
      if (met == DECK_ALTERNATIVES)
        deck_fail_child(d, a->node, "path",
                        "%s takes %s away, which %s parameter sets (%s); expected one of them",
                        a->paths[p], other->paths[q], whose, where);
      else if (strcmp(a->paths[p], other->paths[q]) == 0)
        deck_fail_child(d, a->node, "path", "%s is set by another parameter already (%s)",
                        a->paths[p], where);
      else
        deck_fail_child(d, a->node, "path", "%s is set by another parameter already, as %s (%s)",
                        a->paths[p], other->paths[q], where);
      return;
    }
}

/* Checks that each key is set by only one parameter of the grid, and the seed either by replicas or
 * by a parameter. */
static void check_paths(deck *d, grid *g) {
  for (size_t k = 0; k < g->n_axes; k++) {
    const grid_axis *a = &g->axes[k];
    g->seed_varies = g->seed_varies || has_path(a, "seed");
    for (size_t p = 0; p < a->n_paths; p++) check_path(d, g, a, p);
  }
  if (g->seed_varies && g->replicas > 1)
    deck_fail_child(d, g->node, "replicas",
                    "a parameter sets the seed; expected either this or replicas");
}

static void read_collect(deck *d, deck_node *collect, deck_grids *all) {
  size_t names = deck_each_count(collect);
  all->collect = deck_array_grow(d, all->collect, all->n_collect, all->n_collect + names + 1,
                                 sizeof *all->collect);
  for (size_t k = 0; k < names; k++) {
    const deck_node *name = deck_each(collect, k);
    if (name->type != DECK_STRING)
      deck_fail(d, name, "expected the name of a column, such as \"upper.omega\"");
    else
      all->collect[all->n_collect++] = name->value.text;
  }
}

static void read_grid(deck *d, deck_node *node, grid *g, deck_grids *all) {
  deck_group group;
  *g = (grid){.replicas = 1, .node = node};
  if (!deck_enter(d, node, &deck_sweeps, &group)) return;
  g->replicas = deck_integer(&group, "replicas");
  deck_node *list = deck_groups(d, node, "parameters");
  size_t n = list ? list->n : 0;
  g->axes = deck_alloc(d, n + 1, sizeof *g->axes);
  for (size_t k = 0; k < n; k++) read_axis(d, list->child[k], &g->axes[g->n_axes++]);
  find_dimensions(d, g);
  check_paths(d, g);
  read_collect(d, deck_get(&group, "collect"), all);
}

size_t deck_grid_points(const grid *g) {
  double n = (double)g->replicas;
  for (size_t k = 0; k < g->n_dimensions; k++) n *= (double)g->length[k];
  return n > GRID_MOST ? GRID_MOST + 1 : (size_t)n;
}

/* --- names ------------------------------------------------------------------------------------ */

static bool same_paths(const grid_axis *a, const grid_axis *b) {
  if (a->n_paths != b->n_paths) return false;
  for (size_t k = 0; k < a->n_paths; k++)
    if (strcmp(a->paths[k], b->paths[k]) != 0) return false;
  return true;
}

/* Returns true if another parameter has this name already. before: only parameters before axis a
 * count. Parameters of two grids may share a name if they set the same paths. */
static bool is_taken(const deck_grids *all, const grid *mine, const grid_axis *a, bool before,
                     const char *name) {
  for (size_t i = 0; i < all->n; i++)
    for (size_t k = 0; k < all->grid[i].n_axes; k++) {
      const grid_axis *other = &all->grid[i].axes[k];
      if (other == a && before) return false;
      if (other == a || !other->name || strcmp(other->name, name) != 0) continue;
      if (&all->grid[i] == mine || !same_paths(a, other)) return true;
    }
  return false;
}

/* Returns the last `words` words of a path (dots separate its words); brackets are removed. */
static const char *tail(deck *d, const char *path, int words) {
  const char *start = path + strlen(path);
  while (start > path && words > 0)
    if (*--start == '.' && --words == 0) start++;
  char *name = deck_copy(d, start, strlen(start)), *to = name;
  for (const char *from = name; *from; from++)
    if (!strchr("[]*", *from)) *to++ = *from;
  *to = 0;
  return name;
}

static bool among(const char *word, const char *const *words, size_t n) {
  for (size_t k = 0; k < n; k++)
    if (strcmp(words[k], word) == 0) return true;
  return false;
}

static bool ends_in(const char *name, const char *ending) {
  size_t n = strlen(name), m = strlen(ending);
  return n >= m && strcmp(name + n - m, ending) == 0;
}

/* Returns true for names of columns that every table of results has (run/sweep_table.c), and for
 * "r", which stands for the replica in the names of points. */
static bool reserved(const char *name) {
  static const char *const columns[] = {"point",    "name", "status",  "set", "replica",
                                        "replicas", "seed", "message", "r",   "deck_path"};
  const char *last = strrchr(name, '.');
  return among(name, columns, sizeof columns / sizeof *columns) || summary_is_column(name, false) ||
         (last && summary_is_column(last + 1, true)) || ends_in(name, "_error") ||
         ends_in(name, "_scatter");
}

static void name_axis(deck *d, const deck_grids *all, const grid *g, grid_axis *a) {
  for (int words = 1; !a->name && words <= 3; words++) {
    const char *name = tail(d, a->paths[0], words);
    if (good_name(name) && !reserved(name) && !is_taken(all, g, a, false, name)) a->name = name;
  }
  if (a->name && !a->named) return;
  const char *name = a->name ? a->name : tail(d, a->paths[0], 1), *why = NULL;
  if (is_taken(all, g, a, a->named, name)) why = "another parameter has this name";
  if (reserved(name)) why = "the tables of results have a column of this name";
  if (a->named && why)
    deck_fail_child(d, a->node, "name", "%s; expected another", why);
  else if (!a->named)
    deck_fail_child(d, a->node, "name",
                    "missing: \"%s\" cannot be taken from the path (%s); expected a name", name,
                    why ? why : "only letters, digits, and _ . - can");
}

static void name_axes(deck *d, deck_grids *all) {
  for (size_t i = 0; i < all->n; i++)
    for (size_t k = 0; k < all->grid[i].n_axes; k++)
      if (all->grid[i].axes[k].n_paths > 0) name_axis(d, all, &all->grid[i], &all->grid[i].axes[k]);
}

deck_grids deck_read_grids(deck *d) {
  deck_grids all = {0};
  deck_node *node = deck_child(d->root, "sweep");
  if (!node) return all;
  if (node->type != DECK_LIST && node->type != DECK_GROUP) {
    deck_fail(d, node, "expected a group { key = value; ... } or a list of them");
    return all;
  }
  size_t n = deck_each_count(node);
  all.grid = deck_alloc(d, n + 1, sizeof *all.grid);
  for (size_t k = 0; k < n; k++) read_grid(d, deck_each(node, k), &all.grid[all.n++], &all);
  name_axes(d, &all);
  for (size_t k = 0; k < all.n; k++)
    if (deck_grid_points(&all.grid[k]) > GRID_MOST)
      deck_fail(d, node, "more than %d points", GRID_MOST);
  return all;
}
