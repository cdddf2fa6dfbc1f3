/* deck_grid.c: reads the group `sweep`; see deck_grid.h.
 *
 * Values keep the text that they have in the deck: it names files and is what -D would be given. Computed
 * ones (linspace, logspace) are rounded to 12 digits, and that is the value then.
 */
#include "io/deck_grid.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "io/deck_read.h"

/* --- values ------------------------------------------------------------------------------------------------ */

/* A value as a deck has it. */
static const char *literal(deck *d, const deck_node *node) {
  char number[32];
  const char *text = "";
  switch (node->type) {
    case DECK_BOOL: return node->value.flag ? "true" : "false";
    case DECK_INT: return deck_format(d, "%lld", (long long)node->value.integer);
    case DECK_FLOAT:
      deck_number_text(node->value.number, number);
      return deck_copy(d, number, strlen(number));
    case DECK_STRING:
      for (const char *c = node->value.text; *c; c++)
        text = deck_format(d, strchr("\"\\", *c) ? "%s\\%c" : "%s%c", text, *c);
      return deck_format(d, "\"%s\"", text);
    case DECK_LIST:
      for (size_t k = 0; k < node->n; k++)
        text = deck_format(d, "%s%s%s", text, k ? ", " : "", literal(d, node->child[k]));
      return deck_format(d, "(%s)", text);
    case DECK_GROUP: break;
  }
  deck_fail(d, node, "expected a number, a text, true, false or a list");
  return "";
}

static grid_value value_of(deck *d, const deck_node *node) {
  grid_value v = {.literal = literal(d, node), .number = NAN, .place = node->place};
  v.text = node->type == DECK_STRING ? node->value.text : v.literal;
  double x;
  if (node->type == DECK_INT) v.number = (double)node->value.integer;
  if (node->type == DECK_FLOAT) v.number = node->value.number;
  if (node->type == DECK_STRING && deck_angle(v.text, &x)) v.number = x;
  /* shorter, and the same number: 1.0e-05 as it is written by people */
  if (node->type == DECK_FLOAT) {
    char text[32];
    for (int digits = 1; digits <= 17; digits++) {
      snprintf(text, sizeof text, "%.*g", digits, v.number);
      if (strtod(text, NULL) == v.number) break;
    }
    v.text = deck_copy(d, text, strlen(text));
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

/* The unit in which both ends of a range are written, as a factor: pi, one degree, or 1. */
static double unit_of(const deck_node *list, const char **suffix) {
  static const struct {
    const char *word;
    double factor;
  } units[] = {{"pi", 3.14159265358979323846}, {"deg", 3.14159265358979323846 / 180}};
  for (size_t u = 0; u < 2; u++) {
    size_t with = 0, zero = 0;
    for (size_t k = 0; k < 2; k++) {
      const deck_node *end = list->child[k];
      with += end->type == DECK_STRING && strstr(end->value.text, units[u].word);
      zero += (end->type == DECK_INT && end->value.integer == 0) ||
              (end->type == DECK_FLOAT && end->value.number == 0);
    }
    *suffix = units[u].word;
    if (with > 0 && with + zero == 2) return units[u].factor;
  }
  *suffix = NULL;
  return 1;
}

static grid_value number_value(deck *d, double x, const char *suffix, double unit, deck_place place) {
  const char *text = deck_format(d, "%.12g", x);
  x = strtod(text, NULL);
  grid_value v = {.text = text, .literal = text, .number = x * unit, .place = place};
  if (suffix) {
    v.text = deck_format(d, "%s %s", text, suffix);
    v.literal = deck_format(d, "\"%s\"", v.text);
    if (!deck_angle(v.text, &v.number)) v.number = x * unit;
  }
  return v;
}

/* linspace and logspace: (first, last, count). */
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
    deck_fail(d, list, "expected a whole number >= 1 as the count");
    return;
  }
  if (logarithmic && !(end[0] * end[1] > 0)) {
    deck_fail(d, list, "expected two numbers of the same sign, none of them 0");
    return;
  }
  size_t n = (size_t)count;
  a->values = deck_alloc(d, n, sizeof *a->values);
  for (size_t k = 0; k < n; k++) {
    double s = n > 1 ? (double)k / (double)(n - 1) : 0;
    double x = logarithmic ? end[0] * pow(end[1] / end[0], s) : end[0] + (end[1] - end[0]) * s;
    if (k + 1 == n && n > 1) x = end[1];
    a->values[a->n_values++] = number_value(d, x, suffix, unit, list->place);
  }
}

/* --- parameters -------------------------------------------------------------------------------------------- */

static bool good_name(const char *name) {
  return *name &&
         strspn(name, "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_.-") == strlen(name);
}

static void read_axis(deck *d, deck_node *node, grid_axis *a) {
  deck_group g;
  *a = (grid_axis){.node = node};
  if (!deck_enter(d, node, &deck_sweep_parameters, &g)) return;
  deck_node *path = deck_get(&g, "path");
  if (!path) deck_fail_key(d, node, "path", "missing: expected the key to set, such as \"gravity.tilt\"");
  a->paths = deck_alloc(d, deck_each_count(path) + 1, sizeof *a->paths);
  for (size_t k = 0; k < deck_each_count(path); k++) {
    const deck_node *one = deck_each(path, k);
    if (one->type != DECK_STRING || !*one->value.text || strchr(one->value.text, '='))
      deck_fail(d, one, "expected the path of a key, such as \"gravity.tilt\"");
    else if (strncmp(one->value.text, "sweep", 5) == 0 && strchr(".[", one->value.text[5]))
      deck_fail(d, one, "a sweep cannot vary itself");
    else
      a->paths[a->n_paths++] = one->value.text;
  }
  a->name = deck_text_of(&g, "name");
  a->named = a->name != NULL;
  if (a->name && !good_name(a->name))
    deck_fail_key(d, node, "name", "expected letters, digits, and _ . - only");

  static const char *const kinds[] = {"values", "linspace", "logspace"};
  const char *seen = NULL;
  for (size_t k = 0; k < 3; k++) {
    if (!deck_given(&g, kinds[k])) continue;
    if (seen) deck_fail_key(d, node, kinds[k], "given together with %s; expected one of them", seen);
    seen = kinds[k];
  }
  if (!seen) deck_fail_key(d, node, "values", "missing: expected values, linspace or logspace");
  read_values(&g, a);
  read_range(&g, "linspace", false, a);
  read_range(&g, "logspace", true, a);
}

/* Which axes advance together. */
static void find_dimensions(deck *d, grid *g) {
  g->length = deck_alloc(d, g->n_axes + 1, sizeof *g->length);
  for (size_t k = 0; k < g->n_axes; k++) {
    grid_axis *a = &g->axes[k];
    const deck_node *zip = deck_child(a->node, "zip");
    bool joined = false;
    for (size_t j = 0; j < k && zip && zip->type == DECK_STRING && !joined; j++) {
      const deck_node *other = deck_child(g->axes[j].node, "zip");
      if (!other || other->type != DECK_STRING || strcmp(other->value.text, zip->value.text) != 0) continue;
      joined = true;
      a->dimension = g->axes[j].dimension;
      if (a->n_values != g->length[a->dimension])
        deck_fail(d, zip, "%zu values here, and %zu in the parameter before it with the same word",
                  a->n_values, g->length[a->dimension]);
    }
    if (zip && zip->type != DECK_STRING) deck_fail(d, zip, "expected a text in quotes");
    if (joined) continue;
    a->dimension = g->n_dimensions;
    g->length[g->n_dimensions++] = a->n_values;
  }
}

static void read_grid(deck *d, deck_node *node, grid *g, deck_grids *all) {
  deck_group group;
  *g = (grid){.replicas = 1};
  if (!deck_enter(d, node, &deck_sweeps, &group)) return;
  g->replicas = deck_integer(&group, "replicas");
  deck_node *list = deck_groups(d, node, "parameters");
  size_t n = list ? list->n : 0;
  g->axes = deck_alloc(d, n + 1, sizeof *g->axes);
  for (size_t k = 0; k < n; k++) read_axis(d, list->child[k], &g->axes[g->n_axes++]);
  find_dimensions(d, g);
  deck_node *collect = deck_get(&group, "collect");
  size_t names = deck_each_count(collect);
  const char **grown = deck_alloc(d, all->n_collect + names + 1, sizeof *grown);
  if (all->n_collect) memcpy(grown, all->collect, all->n_collect * sizeof *grown);
  all->collect = grown;
  for (size_t k = 0; k < names; k++) {
    const deck_node *name = deck_each(collect, k);
    if (name->type != DECK_STRING)
      deck_fail(d, name, "expected the name of a column, such as \"upper.omega\"");
    else
      all->collect[all->n_collect++] = name->value.text;
  }
}

size_t deck_grid_points(const grid *g) {
  double n = (double)g->replicas;
  for (size_t k = 0; k < g->n_dimensions; k++) n *= (double)g->length[k];
  return n > GRID_MOST ? GRID_MOST + 1 : (size_t)n;
}

/* --- names ------------------------------------------------------------------------------------------------- */

static bool same_paths(const grid_axis *a, const grid_axis *b) {
  if (a->n_paths != b->n_paths) return false;
  for (size_t k = 0; k < a->n_paths; k++)
    if (strcmp(a->paths[k], b->paths[k]) != 0) return false;
  return true;
}

/* Another parameter of this name; NULL: none. Grids may share a parameter, with the same paths. */
static const grid_axis *rival(const deck_grids *all, const grid *mine, const grid_axis *a, const char *name) {
  for (size_t i = 0; i < all->n; i++)
    for (size_t k = 0; k < all->grid[i].n_axes; k++) {
      const grid_axis *other = &all->grid[i].axes[k];
      if (other == a || !other->name || strcmp(other->name, name) != 0) continue;
      if (&all->grid[i] == mine || !same_paths(a, other)) return other;
    }
  return NULL;
}

/* The last `words` words of a path, without brackets. */
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

/* Columns that the table of results has anyway. */
static bool reserved(const char *name) {
  static const char *const words[] = {"point",    "name",        "status",   "set",    "replica",
                                      "seed",     "steps",       "time",     "work",   "viscous",
                                      "friction", "ns_per_step", "residual", "message"};
  for (size_t k = 0; k < sizeof words / sizeof *words; k++)
    if (strcmp(words[k], name) == 0) return true;
  return false;
}

static void name_axes(deck *d, deck_grids *all) {
  for (size_t i = 0; i < all->n; i++)
    for (size_t k = 0; k < all->grid[i].n_axes; k++) {
      grid_axis *a = &all->grid[i].axes[k];
      for (int words = 1; !a->name && a->n_paths > 0 && words <= 3; words++) {
        const char *name = tail(d, a->paths[0], words);
        if (good_name(name) && !reserved(name) && !rival(all, &all->grid[i], a, name)) a->name = name;
      }
      if (!a->name && a->n_paths > 0)
        deck_fail_key(d, a->node, "name", "missing: the last words of the path are taken; expected a name");
      else if (a->named && (reserved(a->name) || rival(all, &all->grid[i], a, a->name)))
        deck_fail_key(d, a->node, "name", "%s; expected another",
                      reserved(a->name) ? "the table of results has a column of this name"
                                        : "another parameter has this name");
    }
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
    if (deck_grid_points(&all.grid[k]) > GRID_MOST) deck_fail(d, node, "more than %d points", GRID_MOST);
  return all;
}
