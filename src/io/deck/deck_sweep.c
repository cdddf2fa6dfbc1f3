/* deck_sweep.c: forms all points (sets of parameter values) of a sweep; see deck.h. The group
 * `sweep` is read by deck_grid.c. */
#include "base/hash.h"
#include "base/memory.h"
#include "io/deck/deck.h"

#include <ctype.h>
#include <errno.h>
#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "io/deck/deck_expression.h"
#include "io/deck/deck_grid.h"
#include "io/deck/deck_read.h"
#include "slipdisk/deck.h"

/* Largest length of the name of a point; longer names, which become file names, are cut. */
enum { LONGEST_NAME = 120 };

typedef struct expansion {
  deck *d;
  deck_sweep *out;
  size_t capacity;
  int64_t seed;      /* Seed of random numbers in the deck */
  deck_index points; /* Map from names of points to their numbers */
} expansion;

/* --- names and seeds -------------------------------------------------------------------------- */

/* Returns a seed made from a checksum: hashed with the finaliser of splitmix64, of which 53 bits
 * are kept, as many as a double holds. */
static int64_t mixed(uint64_t z) {
  z += UINT64_C(0x9e3779b97f4a7c15);
  z = (z ^ (z >> 30)) * UINT64_C(0xbf58476d1ce4e5b9);
  z = (z ^ (z >> 27)) * UINT64_C(0x94d049bb133111eb);
  return (int64_t)((z ^ (z >> 31)) >> 11);
}

/* Returns a hash of the point's settings, the number of its replica and the deck's seed. It
 * does not depend on the other points of the sweep. */
static uint64_t point_sum(const sweep_point *p, int64_t replica, int64_t seed) {
  uint64_t sum = hash_words(HASH_WORDS, &seed, sizeof seed);
  for (size_t k = 0; k < p->n_overrides; k++)
    sum = hash_words(sum, p->overrides[k], strlen(p->overrides[k]) + 1);
  return hash_words(sum, &replica, sizeof replica);
}

/* Turns the text of a value into a part of a file name, in place: characters other than letters,
 * digits and ._+- become _. number: blanks, as in "0.1 pi", are dropped. Returns false if
 * characters other than blanks were lost, so that the result may not be unique. */
static bool file_word(char *text, bool number) {
  bool good = true;
  char *to = text;
  for (const char *from = text; *from; from++) {
    if (isalnum((unsigned char)*from) || strchr("._+-", *from)) {
      *to++ = *from;
    } else if (*from != ' ' || !number) {
      good = false;
      if (to > text && to[-1] != '_') *to++ = '_';
    }
  }
  if (!good && to > text && to[-1] == '_') to--;
  *to = 0;
  return good;
}

/* Returns the name of a point, such as "tilt=0.04pi,eps=0.0001,r=2". A checksum of the settings is
 * added if a text does not fit into a file name, or the name is too long. */
static const char *name_of(deck *d, const deck_sweep *s, const sweep_point *p) {
  const char *name = "";
  bool good = true;
  for (size_t k = 0; k < s->n_parameters; k++) {
    if (!p->texts[k]) continue;
    char *text = deck_copy(d, p->texts[k], strlen(p->texts[k]));
    if (!file_word(text, isfinite(p->values[k]))) good = false;
    name = deck_format(d, "%s%s%s=%s", name, *name ? "," : "", s->parameters[k].name, text);
  }
  if (!good || strlen(name) > LONGEST_NAME)
    name = deck_format(d, "%.*s,%08x", LONGEST_NAME, name, (unsigned)point_sum(p, 0, 0));
  if (!*name && p->replica == 0) return "base";
  if (p->replica > 0) name = deck_format(d, "%s%sr=%" PRId64, name, *name ? "," : "", p->replica);
  return name;
}

/* --- points ----------------------------------------------------------------------------------- */

static size_t column_of(const deck_sweep *s, const grid_axis *a) {
  for (size_t k = 0; k < s->n_parameters; k++)
    if (strcmp(s->parameters[k].name, a->name) == 0) return k;
  return s->n_parameters;
}

static void add_parameters(expansion *e, const grid *g) {
  deck_sweep *s = e->out;
  for (size_t k = 0; k < g->n_axes; k++) {
    const grid_axis *a = &g->axes[k];
    bool text = false;
    for (size_t v = 0; v < a->n_values; v++) text = text || isnan(a->values[v].number);
    size_t column = column_of(s, a);
    if (column < s->n_parameters) {
      s->parameters[column].text = s->parameters[column].text || text;
      continue;
    }
    s->parameters = memory_grow(s->parameters, s->n_parameters + 1, sizeof *s->parameters);
    sweep_parameter *p = &s->parameters[s->n_parameters++];
    *p = (sweep_parameter){.text = text};
    const char *path = "";
    for (size_t j = 0; j < a->n_paths; j++)
      path = deck_format(e->d, "%s%s%s", path, j ? " " : "", a->paths[j]);
    p->name = memory_text(a->name);
    p->path = memory_text(path);
  }
}

static const char *keep_file(deck_sweep *s, const char *file) {
  for (size_t k = 0; k < s->n_files; k++)
    if (strcmp(s->files[k], file) == 0) return s->files[k];
  s->files = memory_grow(s->files, s->n_files + 1, sizeof *s->files);
  s->files[s->n_files] = memory_text(file);
  return s->files[s->n_files++];
}

static void add_override(expansion *e, sweep_point *p, const char *text, deck_place place) {
  p->overrides = memory_grow(p->overrides, p->n_overrides + 1, sizeof *p->overrides);
  p->places = memory_grow(p->places, p->n_overrides + 1, sizeof *p->places);
  /* A value that -D has put into the sweep has no line; its file name is then the whole setting,
   * "-D path=value" */
  p->places[p->n_overrides] =
      (sweep_place){keep_file(e->out, place.file ? place.file : e->d->path), place.line};
  p->overrides[p->n_overrides] = memory_text(text);
  p->n_overrides++;
}

/* Returns the seed that a value of the sweep stands for; `otherwise` if the value is not a seed, an
 * error that is reported when the model is built. */
static int64_t seed_value(const grid_value *v, int64_t otherwise) {
  char *end;
  errno = 0;
  long long x = strtoll(v->literal, &end, 10);
  return errno == 0 && end != v->literal && !*end && x >= 0 ? (int64_t)x : otherwise;
}

static void set_value(expansion *e, sweep_point *p, const grid_axis *a, const grid_value *v) {
  size_t column = column_of(e->out, a);
  p->values[column] = v->number;
  p->texts[column] = memory_text(v->text);
  for (size_t j = 0; j < a->n_paths; j++) {
    add_override(e, p, deck_format(e->d, "%s=%s", a->paths[j], v->literal), v->place);
    if (strcmp(a->paths[j], "seed") == 0) p->seed = seed_value(v, e->seed);
  }
}

/* Appends a new point. place[dimension]: index of the value that the axes of this dimension
 * have. */
static sweep_point *add_point(expansion *e, const grid *g, const size_t *place, int64_t replica) {
  deck *d = e->d;
  deck_sweep *s = e->out;
  if (s->n_points == e->capacity) {
    e->capacity = 2 * e->capacity + 16;
    s->points = memory_grow(s->points, e->capacity, sizeof *s->points);
  }
  sweep_point *p = &s->points[s->n_points++];
  *p = (sweep_point){.replica = replica, .seed = e->seed};
  p->values = memory_new(s->n_parameters, sizeof *p->values);
  p->texts = memory_new(s->n_parameters, sizeof *p->texts);
  for (size_t k = 0; k < s->n_parameters; k++) p->values[k] = NAN;
  for (size_t k = 0; g && k < g->n_axes; k++)
    set_value(e, p, &g->axes[k], &g->axes[k].values[place[g->axes[k].dimension]]);
  p->name = memory_text(name_of(d, s, p));
  for (size_t k = 0; k < s->n_parameters; k++)
    if (!p->texts[k]) p->texts[k] = memory_text("");
  return p;
}

static void point_free(sweep_point *p, size_t n_parameters) {
  for (size_t k = 0; k < p->n_overrides; k++) free(p->overrides[k]);
  for (size_t k = 0; k < n_parameters; k++) free(p->texts[k]);
  free(p->overrides);
  free(p->places);
  free(p->texts);
  free(p->values);
  free(p->name);
}

/* Returns true if two points with the same name have the same values. Equal names do not show this,
 * since characters that do not fit into a file name are lost. */
static bool same_values(const deck_sweep *s, const sweep_point *p, const sweep_point *q) {
  for (size_t k = 0; k < s->n_parameters; k++)
    if (strcmp(p->texts[k], q->texts[k]) != 0 && !(p->values[k] == q->values[k])) return false;
  return true;
}

static void add_replicas(expansion *e, const grid *g, const size_t *place, int64_t replicas) {
  deck_sweep *s = e->out;
  size_t set = s->n_sets;
  for (int64_t r = 0; r < replicas; r++) {
    sweep_point *p = add_point(e, g, place, r);
    uint32_t other;
    /* If another grid has the same point already, that one is kept and this one is dropped */
    if (deck_index_find(&e->points, p->name, &other)) {
      if (g && !same_values(s, p, &s->points[other]))
        deck_fail(e->d, g->node, "two points would have the same name, %s", p->name);
      set = s->points[other].set;
      point_free(p, s->n_parameters);
      s->n_points--;
      continue;
    }
    deck_index_add(e->d, &e->points, p->name, (uint32_t)(s->n_points - 1));
    p->set = set;
    if (g && !g->seed_varies) {
      p->seed = mixed(point_sum(p, p->replica, e->seed));
      add_override(e, p, deck_format(e->d, "seed=%" PRId64, p->seed), g->node->place);
    }
  }
  s->n_sets += set == s->n_sets;
}

/* Adds the points of all combinations of the grid's values; the last dimension varies fastest. */
static void add_grid(expansion *e, const grid *g) {
  size_t *place = deck_alloc(e->d, g->n_dimensions + 1, sizeof *place), k;
  if (deck_grid_points(g) == 0) return;
  do {
    add_replicas(e, g, place, g->replicas);
    for (k = g->n_dimensions; k > 0; k--) {
      if (++place[k - 1] < g->length[k - 1]) break;
      place[k - 1] = 0;
    }
  } while (k > 0);
}

/* Reads the deck's seed like deck_integer, but without messages; 1 if it is missing or wrong. */
static void find_seed(expansion *e) {
  const deck_node *seed = deck_child(e->d->root, "seed");
  double x;
  e->seed = 1;
  if (seed && seed->type == DECK_STRING &&
      !deck_expression(e->d, seed->value.text, DECK_NAMES_CONSTANTS, false, &x) &&
      fabs(x) <= 9007199254740992.0)
    e->seed = (int64_t)x;
  if (seed && seed->type == DECK_INT) e->seed = seed->value.integer;
  if (seed && seed->type == DECK_FLOAT && fabs(seed->value.number) <= 9007199254740992.0)
    e->seed = (int64_t)seed->value.number;
}

static bool names_files(const deck_node *node) {
  bool found = node->name && strcmp(node->name, "file") == 0;
  if (node->type != DECK_GROUP && node->type != DECK_LIST) return found;
  for (size_t k = 0; k < node->n && !found; k++) found = names_files(node->child[k]);
  return found;
}

static bool sets_files(const deck_grids *all) {
  for (size_t i = 0; i < all->n; i++)
    for (size_t k = 0; k < all->grid[i].n_axes; k++)
      for (size_t j = 0; j < all->grid[i].axes[k].n_paths; j++)
        if (strstr(all->grid[i].axes[k].paths[j], "file")) return true;
  return false;
}

/* Forms the points of all grids and returns their number; 0 if there is no grid, or after an error.
 * `reported`: number of errors before the grids were read. */
static size_t expand(deck *d, deck_grids all, size_t reported, deck_sweep *s) {
  expansion e = {.d = d, .out = s};
  if (d->reported > reported) return 0;
  find_seed(&e);
  s->written = all.n > 0;
  s->reads_files = names_files(d->root) || sets_files(&all);
  for (size_t k = 0; k < all.n; k++) add_parameters(&e, &all.grid[k]);
  for (size_t k = 0; k < all.n; k++) add_grid(&e, &all.grid[k]);
  if (all.n == 0) add_replicas(&e, NULL, NULL, 1);
  s->collect = memory_new(all.n_collect, sizeof *s->collect);
  for (size_t k = 0; k < all.n_collect; k++)
    s->collect[s->n_collect++] = memory_text(all.collect[k]);
  return d->reported > reported || all.n == 0 ? 0 : s->n_points;
}

/* --- interface -------------------------------------------------------------------------------- */

/* Warns if points of the sweep overwrite a -D setting; they may write the path of its key in
 * another way. */
static void warn_of_overrides(const deck *d, const deck_grids *all, const deck_sweep *s,
                              sd_messages *messages) {
  for (size_t o = 0; o < s->n_overrides; o++) {
    deck_paths_relation met = DECK_DIFFERENT_KEYS;
    for (size_t i = 0; i < all->n; i++)
      for (size_t k = 0; k < all->grid[i].n_axes; k++)
        for (size_t j = 0; j < all->grid[i].axes[k].n_paths && met == DECK_DIFFERENT_KEYS; j++)
          met = deck_paths_compare(d, s->overrides[o], all->grid[i].axes[k].paths[j]);
    if (met != DECK_DIFFERENT_KEYS)
      sd_warn(messages, "-D %s: the sweep sets %s; it counts for points that do not set it",
              s->overrides[o],
              met == DECK_SAME_KEY ? "this key" : "a key that takes this one away");
  }
}

/* Returns true if the value is a text with a unit, such as "90 deg", or a value of a range whose
 * ends are such texts. */
static bool has_unit(const grid_axis *a, const grid_value *v) {
  static const char *const ranges[] = {"linspace", "logspace"};
  bool unit = *v->literal == '"';
  for (size_t k = 0; k < 2; k++) {
    const deck_node *range = deck_child(a->node, ranges[k]);
    for (size_t j = 0; range && j < range->n; j++)
      unit = unit || range->child[j]->type == DECK_STRING;
  }
  return unit;
}

/* Warns of values of gravity.tilt in a sweep that may be meant in degrees, once per parameter. */
static void warn_of_tilts(const deck *d, const deck_grids *all, sd_messages *messages) {
  for (size_t i = 0; i < all->n; i++)
    for (size_t k = 0; k < all->grid[i].n_axes; k++) {
      const grid_axis *a = &all->grid[i].axes[k];
      bool tilts = false;
      for (size_t j = 0; j < a->n_paths; j++)
        tilts = tilts || deck_paths_compare(d, a->paths[j], "gravity.tilt") == DECK_SAME_KEY;
      const grid_value *worst = NULL;
      for (size_t v = 0; tilts && v < a->n_values; v++)
        if (!isnan(a->values[v].number) && !has_unit(a, &a->values[v]) &&
            (!worst || fabs(a->values[v].number) > fabs(worst->number)))
          worst = &a->values[v];
      if (worst) deck_warn_tilt(d, worst->number, worst->place, messages);
    }
}

bool deck_sweep_read(deck *d, deck_sweep *out, sd_messages *messages) {
  size_t reported = d->reported;
  deck_grids all = deck_read_grids(d);
  expand(d, all, reported, out);
  if (d->reported > 0) return false;
  warn_of_overrides(d, &all, out, messages);
  warn_of_tilts(d, &all, messages);
  return true;
}

size_t deck_sweep_count(deck *d) {
  deck_sweep s = {0};
  size_t reported = d->reported;
  deck_grids all = deck_read_grids(d);
  size_t n = expand(d, all, reported, &s);
  deck_sweep_free(&s);
  return n;
}

void deck_sweep_free(deck_sweep *s) {
  for (size_t k = 0; k < s->n_points; k++) point_free(&s->points[k], s->n_parameters);
  for (size_t k = 0; k < s->n_parameters; k++) {
    free(s->parameters[k].name);
    free(s->parameters[k].path);
  }
  for (size_t k = 0; k < s->n_overrides; k++) free(s->overrides[k]);
  for (size_t k = 0; k < s->n_collect; k++) free(s->collect[k]);
  for (size_t k = 0; k < s->n_files; k++) free(s->files[k]);
  free(s->points);
  free(s->parameters);
  free(s->overrides);
  free(s->collect);
  free(s->files);
  free(s->deck_path);
  free(s->deck_text);
  *s = (deck_sweep){0};
}
