/* deck_sweep.c: the points of a sweep; see deck_sweep.h. How the deck's group is read: deck_grid.c. */
#include "io/deck_sweep.h"

#include <ctype.h>
#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "io/deck_grid.h"
#include "io/file.h"
#include "slipdisk/deck.h"

/* Names of files are cut here. */
enum { LONGEST_NAME = 120 };

typedef struct expansion {
  deck *d;
  deck_sweep *out;
  size_t capacity;
  int64_t seed; /* of the deck */
  bool seed_varies;
  size_t *slots, n_slots; /* hash table of the points by name: number + 1, 0 where there is none */
} expansion;

/* --- names and seeds --------------------------------------------------------------------------------------- */

/* Mixes the bits of a sum (the finaliser of splitmix64), and keeps as many as a double holds. */
static int64_t mixed(uint64_t z) {
  z += UINT64_C(0x9e3779b97f4a7c15);
  z = (z ^ (z >> 30)) * UINT64_C(0xbf58476d1ce4e5b9);
  z = (z ^ (z >> 27)) * UINT64_C(0x94d049bb133111eb);
  return (int64_t)((z ^ (z >> 31)) >> 11);
}

/* What is set, replica and seed of the deck: whatever else is in the sweep has no part in it. */
static uint64_t point_sum(const sweep_point *p, int64_t seed) {
  uint64_t sum = file_sum(FILE_SUM, &seed, sizeof seed);
  for (size_t k = 0; k < p->n_overrides; k++)
    sum = file_sum(sum, p->overrides[k], strlen(p->overrides[k]) + 1);
  return file_sum(sum, &p->replica, sizeof p->replica);
}

/* "tilt=0.04pi,eps=1e-4,r=2"; where a text does not go into a file name, a sum of all stands for it. */
static const char *name_of(deck *d, const deck_sweep *s, const sweep_point *p) {
  const char *name = "";
  bool lossy = false;
  for (size_t k = 0; k < s->n_parameters; k++) {
    if (!*p->texts[k]) continue;
    char *text = deck_copy(d, p->texts[k], strlen(p->texts[k])), *to = text;
    for (const char *from = text; *from; from++) {
      if (isalnum((unsigned char)*from) || strchr("._+-", *from))
        *to++ = *from;
      else if (*from != ' ')
        lossy = true;
    }
    *to = 0;
    name = deck_format(d, "%s%s%s=%s", name, *name ? "," : "", s->parameters[k].name, text);
  }
  if (strlen(name) > LONGEST_NAME) lossy = true;
  if (lossy) name = deck_format(d, "%.*s,%08x", LONGEST_NAME, name, (unsigned)point_sum(p, 0));
  if (!*name && p->replica == 0) return "base";
  if (p->replica > 0) name = deck_format(d, "%s%sr=%" PRId64, name, *name ? "," : "", p->replica);
  return name;
}

/* --- points ------------------------------------------------------------------------------------------------ */

static size_t column_of(const deck_sweep *s, const grid_axis *a) {
  for (size_t k = 0; k < s->n_parameters; k++)
    if (strcmp(s->parameters[k].name, a->name) == 0) return k;
  return s->n_parameters;
}

static void add_parameters(expansion *e, const grid *g) {
  deck_sweep *s = e->out;
  for (size_t k = 0; k < g->n_axes; k++) {
    const grid_axis *a = &g->axes[k];
    bool text = true;
    for (size_t v = 0; v < a->n_values; v++) text = text && isnan(a->values[v].number);
    size_t column = column_of(s, a);
    if (column < s->n_parameters) {
      s->parameters[column].text = s->parameters[column].text && text;
      continue;
    }
    s->parameters = deck_grow(e->d, s->parameters, s->n_parameters + 1, sizeof *s->parameters);
    sweep_parameter *p = &s->parameters[s->n_parameters++];
    *p = (sweep_parameter){.text = text};
    const char *path = "";
    for (size_t j = 0; j < a->n_paths; j++) {
      path = deck_format(e->d, "%s%s%s", path, j ? " " : "", a->paths[j]);
      if (strcmp(a->paths[j], "seed") == 0) e->seed_varies = true;
    }
    p->name = deck_keep_text(e->d, a->name);
    p->path = deck_keep_text(e->d, path);
  }
}

static void add_override(deck *d, sweep_point *p, const char *text) {
  p->overrides = deck_grow(d, p->overrides, p->n_overrides + 1, sizeof *p->overrides);
  p->overrides[p->n_overrides++] = deck_keep_text(d, text);
}

/* A new point at the end of the list, whose values come from place[dimension] of each axis. */
static sweep_point *add_point(expansion *e, const grid *g, const size_t *place, int64_t replica) {
  deck *d = e->d;
  deck_sweep *s = e->out;
  if (s->n_points == e->capacity) {
    e->capacity = 2 * e->capacity + 16;
    s->points = deck_grow(d, s->points, e->capacity, sizeof *s->points);
  }
  sweep_point *p = &s->points[s->n_points++];
  *p = (sweep_point){.replica = replica, .seed = e->seed};
  p->values = deck_keep(d, s->n_parameters + 1, sizeof *p->values);
  p->texts = deck_keep(d, s->n_parameters + 1, sizeof *p->texts);
  for (size_t k = 0; k < s->n_parameters; k++) p->values[k] = NAN;
  for (size_t k = 0; g && k < g->n_axes; k++) {
    const grid_axis *a = &g->axes[k];
    const grid_value *v = &a->values[place[a->dimension]];
    size_t column = column_of(s, a);
    p->values[column] = v->number;
    p->texts[column] = deck_keep_text(d, v->text);
    for (size_t j = 0; j < a->n_paths; j++)
      add_override(d, p, deck_format(d, "%s=%s", a->paths[j], v->literal));
    for (size_t j = 0; j < a->n_paths; j++)
      if (strcmp(a->paths[j], "seed") == 0 && isfinite(v->number)) p->seed = (int64_t)v->number;
  }
  for (size_t k = 0; k < s->n_parameters; k++)
    if (!p->texts[k]) p->texts[k] = deck_keep_text(d, "");
  p->name = deck_keep_text(d, name_of(d, s, p));
  return p;
}

static void point_free(sweep_point *p, size_t n_parameters) {
  for (size_t k = 0; k < p->n_overrides; k++) free(p->overrides[k]);
  for (size_t k = 0; p->texts && k < n_parameters; k++) free(p->texts[k]);
  free(p->overrides);
  free(p->texts);
  free(p->values);
  free(p->name);
}

/* The place in the hash table of the point of this name: 0 there, when there is none yet. */
static size_t *slot_of(const expansion *e, const char *name) {
  size_t k = (size_t)file_sum(FILE_SUM, name, strlen(name)) % e->n_slots;
  while (e->slots[k] && strcmp(e->out->points[e->slots[k] - 1].name, name) != 0) k = (k + 1) % e->n_slots;
  return &e->slots[k];
}

static void add_replicas(expansion *e, const grid *g, const size_t *place, int64_t replicas) {
  deck_sweep *s = e->out;
  size_t set = s->n_sets;
  for (int64_t r = 0; r < replicas; r++) {
    sweep_point *p = add_point(e, g, place, r);
    size_t *slot = slot_of(e, p->name);
    if (*slot) { /* an equal point of another grid: it stays */
      set = s->points[*slot - 1].set;
      point_free(p, s->n_parameters);
      s->n_points--;
      continue;
    }
    *slot = s->n_points;
    p->set = set;
    if (g && !e->seed_varies) {
      p->seed = mixed(point_sum(p, e->seed));
      add_override(e->d, p, deck_format(e->d, "seed=%" PRId64, p->seed));
    }
  }
  s->n_sets += set == s->n_sets;
}

/* All combinations, the last dimension fastest. */
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

static void find_seed(expansion *e) {
  const deck_node *seed = deck_child(e->d->root, "seed");
  e->seed = seed && seed->type == DECK_INT ? seed->value.integer : 1;
}

static sd_status expand(deck *d, void *user) {
  expansion e = {.d = d, .out = user};
  deck_sweep *s = user;
  s->deck_text = deck_keep_text(d, d->text);
  deck_grids all = deck_read_grids(d);
  if (d->reported > 0) return SD_ERROR_USER;
  find_seed(&e);
  for (size_t k = 0; k < all.n; k++) add_parameters(&e, &all.grid[k]);
  for (size_t k = 0; k < all.n; k++)
    if (e.seed_varies && all.grid[k].replicas > 1)
      deck_fail_key(d, deck_child(d->root, "sweep"), "replicas", "given although the seed is varied");
  if (d->reported > 0) return SD_ERROR_USER;
  e.n_slots = 16;
  for (size_t k = 0; k < all.n; k++) e.n_slots += 2 * deck_grid_points(&all.grid[k]);
  e.slots = deck_alloc(d, e.n_slots, sizeof *e.slots);
  for (size_t k = 0; k < all.n; k++) add_grid(&e, &all.grid[k]);
  if (all.n == 0) add_replicas(&e, NULL, NULL, 1);
  s->collect = deck_keep(d, all.n_collect, sizeof *s->collect);
  for (size_t k = 0; k < all.n_collect; k++) s->collect[s->n_collect++] = deck_keep_text(d, all.collect[k]);
  return SD_OK;
}

/* --- interface --------------------------------------------------------------------------------------------- */

sd_status deck_sweep_load(const char *path, size_t n_overrides, const char *const *overrides, deck_sweep *out,
                          sd_messages *messages) {
  *out = (deck_sweep){.deck_path = file_path("%s", path)};
  out->overrides = calloc(n_overrides + 1, sizeof *out->overrides);
  sd_status status;
  char *text = deck_file_text(path, messages, &status);
  if (!text) return status;
  bool good = out->deck_path && out->overrides;
  for (size_t k = 0; good && k < n_overrides; k++) {
    out->overrides[k] = file_path("%s", overrides[k]);
    good = out->overrides[k] != NULL;
    out->n_overrides++;
  }
  if (good)
    status = deck_open(text, out->deck_path, n_overrides, overrides, expand, out, messages);
  else
    status = sd_fail(messages, SD_ERROR_IO, "%s: out of memory", path);
  free(text);
  return status;
}

void deck_sweep_free(deck_sweep *s) {
  for (size_t k = 0; k < s->n_points; k++) point_free(&s->points[k], s->n_parameters);
  for (size_t k = 0; k < s->n_parameters; k++) {
    free(s->parameters[k].name);
    free(s->parameters[k].path);
  }
  for (size_t k = 0; k < s->n_overrides; k++) free(s->overrides[k]);
  for (size_t k = 0; k < s->n_collect; k++) free(s->collect[k]);
  free(s->points);
  free(s->parameters);
  free(s->overrides);
  free(s->collect);
  free(s->deck_path);
  free(s->deck_text);
  *s = (deck_sweep){0};
}

sd_status deck_sweep_model(const deck_sweep *s, size_t point, sd_model **out, sd_messages *messages) {
  const sweep_point *p = &s->points[point];
  size_t n = s->n_overrides + p->n_overrides;
  const char **all = calloc(n + 1, sizeof *all);
  *out = NULL;
  if (!all) return sd_fail(messages, SD_ERROR_IO, "%s: out of memory", s->deck_path);
  for (size_t k = 0; k < n; k++)
    all[k] = k < s->n_overrides ? s->overrides[k] : p->overrides[k - s->n_overrides];
  sd_status status = sd_deck_load_text(s->deck_text, s->deck_path, n, all, out, messages);
  free(all);
  return status;
}
