/* deck_phases.c: reads phases, output intervals and measurements. See deck_tree.h. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/limits.h"
#include "base/math.h"
#include "base/memory.h"
#include "io/deck/deck_read.h"
#include "io/deck/deck_rows.h"
#include "model/laws.h"
#include "model/motions.h"

/* Largest number of free disks for which the rotation of all of them is measured by default. */
enum { MOST_WATCHED = 16 };

/* --- length ----------------------------------------------------------------------------------- */

/* Returns the length of a phase in steps, from its key `steps` or `time`; 1 after an error. */
static int64_t read_steps(deck_group *g) {
  const char *key = deck_one_of(g, "the length in steps or time");
  if (!key) return 1;
  if (deck_given(g, "steps")) return deck_integer(g, "steps");
  double n = round(deck_number(g, "time") / g->d->model->dt);
  if (isnan(n)) return 1; /* An invalid time was reported before */
  if (n >= 1 && n < 9e18) return (int64_t)n;
  deck_fail_key(g, "time", n < 1 ? "shorter than half a time step" : "more than 9e18 time steps");
  return 1;
}

/* --- motions and fields of a phase ------------------------------------------------------------ */

/* A key of a phase, "motions" or "fields". Its list names the entries of the deck's top-level list
 * of the same name that are active in the phase. */
typedef struct switched {
  const char *key, *what; /* Key and its singular: "motions", "motion" */
  const deck_index *index;
} switched;

/* Finds the motion or field that the node names; *entry: its index in the deck's top-level list.
 * Returns false after an error, which is reported. */
static bool find_entry(deck *d, const switched *of, const deck_node *node, size_t *entry) {
  const deck_node *list = deck_child(d->root, of->key);
  size_t n = list && list->type == DECK_LIST ? list->n : 0;
  if (node->type == DECK_INT) {
    *entry = (size_t)node->value.integer;
    if (node->value.integer >= 0 && (uint64_t)node->value.integer < n) return true;
    deck_fail(d, node, "no %s has this number; there are %zu, counted from 0", of->what, n);
    return false;
  }
  if (node->type != DECK_STRING) {
    deck_fail(d, node, "expected the name or the number of a %s", of->what);
    return false;
  }
  uint32_t found;
  if (!deck_index_look_up(d, of->index, of->what, node, "", &found)) return false;
  *entry = found;
  return true;
}

/* Appends the name of a motion, field or disk to a list; its number if it has no name. */
static void add_entry(deck *d, deck_node *list, const char *name, size_t number) {
  deck_node *node = deck_node_new(d, list, NULL, name ? DECK_STRING : DECK_INT, list->place);
  if (name)
    node->value.text = name;
  else
    node->value.integer = (int64_t)number;
}

/* Fills the phase's list `key` with all entries of the deck's top-level list of the same name. */
static void default_entries(deck_group *g, const char *key) {
  const deck_node *all = deck_child(g->d->root, key);
  deck_node *list = deck_default_list(g, key);
  for (size_t k = 0; all && all->type == DECK_LIST && k < all->n; k++) {
    const deck_node *name = deck_child(all->child[k], "name");
    add_entry(g->d, list, name && name->type == DECK_STRING ? name->value.text : NULL, k);
  }
}

/* Returns an array with one bool per motion or field of the deck: true if it is active in the
 * phase. */
static bool *read_switches(deck_group *g, const switched *of) {
  deck *d = g->d;
  const deck_node *all = deck_child(d->root, of->key);
  const size_t n = all && all->type == DECK_LIST ? all->n : 0;
  bool *on = deck_alloc(d, n + 1, sizeof *on);
  deck_node *list = deck_get(g, of->key);
  if (!list) {
    default_entries(g, of->key);
    memset(on, true, n + 1);
    return on;
  }
  for (size_t j = 0; j < deck_each_count(list); j++) {
    size_t entry;
    if (find_entry(d, of, deck_each(list, j), &entry)) on[entry] = true;
  }
  return on;
}

static void read_active(deck_group *g, sd_phase *phase) {
  deck *d = g->d;
  const sd_model *m = d->model;
  const bool *on = read_switches(g, &(switched){"motions", "motion", &d->motions});
  phase->active = memory_new(m->n_motions, sizeof *phase->active);
  for (size_t k = 0; k < m->n_motions; k++) phase->active[k] = on[d->motion_entry[k]];
  if (m->n_fields == 0 && !deck_get(g, "fields")) return;
  on = read_switches(g, &(switched){"fields", "field", &d->fields});
  phase->fields = memory_new(m->n_fields, sizeof *phase->fields);
  memcpy(phase->fields, on, m->n_fields * sizeof *phase->fields);
}

/* --- disks that a phase holds or releases ----------------------------------------------------- */

/* Reads the key `hold` or `release` of a phase, and makes its disks holdable. */
static void read_held(deck_group *g, const char *key, const unsigned char *moved, size_t *n,
                      const uint32_t **out) {
  sd_model *m = g->d->model;
  const deck_bodies named = deck_disks_named(g, key);
  uint32_t *list = NULL;
  for (size_t k = 0; k < named.n; k++) {
    const uint32_t i = named.body[k];
    const char *what = m->disks[i].clump > 0
                           ? "belongs to a clump; expected a disk that moves by itself"
                       : m->disks[i].waiting ? "waits for rain"
                                             : NULL;
    if (what) {
      deck_fail_key(g, key, "%s %s", deck_body_name(g->d, i), what);
      continue;
    }
    model_make_holdable(m, i, moved[i]);
    list = memory_grow(list, *n + 1, sizeof *list);
    list[(*n)++] = i;
  }
  *out = list;
}

void deck_read_holds(deck *d) {
  sd_model *m = d->model;
  deck_node *list = deck_child(d->root, "phases");
  if (!list || list->type != DECK_LIST || list->n > LIMIT_PHASES) return;
  unsigned char *moved = model_moved(m);
  if (!moved) longjmp(d->out_of_memory, 1);
  deck_own(d, moved);
  m->phases = memory_new(list->n, sizeof *m->phases);
  for (size_t k = 0; k < list->n; k++) {
    deck_group g = {.d = d, .node = list->child[k], .table = &deck_phases};
    m->n_phases = k + 1;
    if (list->child[k]->type != DECK_GROUP) continue;
    read_held(&g, "hold", moved, &m->phases[k].n_hold, &m->phases[k].hold);
    read_held(&g, "release", moved, &m->phases[k].n_release, &m->phases[k].release);
  }
}

/* --- phases ----------------------------------------------------------------------------------- */

static void read_settle(deck_group *g, sd_settle *settle) {
  deck_node *node = deck_get(g, "settle");
  deck_group s;
  if (!node || !deck_enter(g->d, node, &deck_settle, &s)) return;
  settle->asked = true;
  deck_fill(&s, settle);
  if (!deck_given(&s, "kinetic") && !deck_given(&s, "unbalanced"))
    deck_fail(g->d, node, "it has no criterion; expected kinetic, unbalanced or both");
}

static void read_compress(deck_group *g, sd_compress *compress) {
  deck *d = g->d;
  const sd_model *m = d->model;
  deck_node *node = deck_get(g, "compress");
  deck_group c;
  if (!node || !deck_enter(d, node, &deck_compress, &c)) return;
  compress->asked = true;
  deck_fill(&c, compress);
  if (deck_given(&c, "pressure") == deck_given(&c, "fraction"))
    deck_fail(d, node, "expected one target, either pressure or fraction");
  if (m->region_upper[0] <= m->region_lower[0] || m->region_upper[1] <= m->region_lower[1])
    deck_fail(d, node,
              "there is nothing to compress; expected a container, or a box with edges x and y");
}

/* Reads the group `cell`, in which each strain component has either a rate or a stress. */
static void read_cell(deck_group *g, sd_cell *cell) {
  static const char *const rates[] = {"rate_xx", "rate_yy", "rate_xy"};
  static const char *const stresses[] = {"stress_xx", "stress_yy", "stress_xy"};
  deck_node *node = deck_get(g, "cell");
  deck_group c;
  if (!node || !deck_enter(g->d, node, &deck_cell, &c)) return;
  cell->asked = true;
  for (int k = 0; k < SD_CELL_COMPONENTS; k++) {
    cell->controlled[k] = deck_given(&c, stresses[k]);
    if (cell->controlled[k] && deck_given(&c, rates[k]))
      deck_fail_key(&c, stresses[k], "given together with %s; expected one of them", rates[k]);
  }
  deck_fill(&c, cell);
}

/* Reads the pairs of disks in a file. */
static void read_pairs(deck_group *g, sd_bonding *bond) {
  static const char *const names[2] = {"a", "b"};
  deck *d = g->d;
  const deck_node *file = deck_get(g, "file");
  const size_t before = d->reported;
  double *column[2] = {NULL, NULL};
  const size_t n = deck_csv_pair(d, file, names, &column[0], &column[1]);
  if (d->reported > before) return;
  if (n == 0) deck_fail(d, file, "it names no pair; expected rows with the numbers of two disks");
  uint32_t(*pairs)[2] = memory_new(n + 1, sizeof *pairs);
  for (size_t k = 0; k < n && d->reported == before; k++) {
    const double a = column[0][k], b = column[1][k];
    const double disks = (double)d->model->n_disks;
    if (!(a >= 0 && b >= 0 && a < disks && b < disks && a == floor(a) && b == floor(b)))
      deck_fail(d, file, "row %zu: disks %g and %g; expected two numbers from 0 to %zu", k + 1, a,
                b, d->model->n_disks - 1);
    else if (a == b)
      deck_fail(d, file, "row %zu: a bond of disk %g with itself", k + 1, a);
    if (d->reported > before) break;
    pairs[k][0] = (uint32_t)a;
    pairs[k][1] = (uint32_t)b;
  }
  bond->pairs = (const uint32_t(*)[2])pairs;
  bond->n_pairs = d->reported > before ? 0 : n;
}

static bool any_bonds(const sd_model *m) {
  for (size_t k = 0; k < m->n_materials * m->n_materials; k++)
    if (law_bonds(&m->laws[k])) return true;
  return false;
}

static void read_bond(deck_group *g, sd_bonding *bond) {
  deck_node *node = deck_get(g, "bond");
  deck_group b;
  if (!node || !deck_enter(g->d, node, &deck_bond, &b)) return;
  bond->asked = true;
  deck_fill(&b, bond);
  const bool named = deck_given(&b, "disk") || deck_given(&b, "group") || deck_given(&b, "wall");
  if (!any_bonds(g->d->model))
    deck_fail(g->d, node,
              "no law has bonds; expected bond_k_n, or bond_E and bond_width, in materials or "
              "material_pairs");
  if (deck_given(&b, "file") && named)
    deck_fail_key(&b, "file", "given together with disk, group or wall; expected one of them");
  if (deck_given(&b, "file") && bond->sinter)
    deck_fail_key(&b, "sinter", "the file lists the pairs; leave out one of the two");
  if (bond->later && !bond->sinter)
    deck_fail_key(&b, "begin", "no bond is ever made; expected sinter = true, or begin = true");
  if (named) {
    const deck_bodies bodies = deck_select(&b, true);
    bond->between = memory_copy(bodies.body, bodies.n * sizeof *bodies.body);
    bond->n_between = bodies.n;
  } else if (deck_given(&b, "file")) {
    read_pairs(&b, bond);
  }
}

static void read_phase(deck_group *g, deck_group *output, sd_phase *phase, bool last) {
  static const char *const cadences[] = {"series", "frames", "contacts"};
  phase->steps = read_steps(g);
  read_active(g, phase);
  deck_default_bool(g, "measure", last);
  for (int k = 0; k < 3; k++) {
    int64_t usual = k > 0 ? 0 : phase->steps < 1000 ? 1 : phase->steps / 1000;
    deck_default_integer(g, cadences[k],
                         deck_get(output, cadences[k]) ? deck_integer(output, cadences[k]) : usual);
  }
  deck_fill(g, phase);
  read_settle(g, &phase->settle);
  read_compress(g, &phase->compress);
  read_cell(g, &phase->cell);
  read_bond(g, &phase->bond);
}

void deck_read_phases(deck *d) {
  sd_model *m = d->model;
  deck_group top = {d, d->root, &deck_top, NULL}, output;
  deck_node *list = deck_groups(d, d->root, "phases");
  if (list && list->n > LIMIT_PHASES) {
    deck_fail(d, list, "%zu phases; expected at most %d", list->n, LIMIT_PHASES);
    return;
  }
  bool short_form = deck_given(&top, "steps") || deck_given(&top, "time");
  if (!deck_enter_one(d, &deck_output, &output)) return;
  if (!list && deck_get(&top, "phases")) return;
  if (list && short_form)
    deck_fail_key(&top, deck_given(&top, "steps") ? "steps" : "time",
                  "given together with phases; expected a length in each phase");
  /* A deck with a top-level `steps` or `time` has one phase; the full deck shows it in the list
   * `phases` */
  if (!list && short_form) {
    list = deck_default_list(&top, "phases");
    deck_node *phase = deck_node_new(d, list, NULL, DECK_GROUP, list->place);
    for (int k = 0; k < 2; k++) {
      deck_node *key = deck_get(&top, k ? "time" : "steps");
      if (!key) continue;
      deck_node *copy = deck_node_new(d, phase, key->name, key->type, key->place);
      copy->value = key->value;
      deck_remove(d->root, key);
    }
  }
  if (!list && d->endless && !deck_child(d->root, "until")) return;
  if (!list || list->n == 0) {
    deck_fail_key(&top, "steps", "missing: expected steps, time or phases");
    return;
  }
  if (!m->phases) m->phases = memory_new(list->n, sizeof *m->phases);
  for (size_t k = 0; k < list->n; k++) {
    deck_group g;
    if (m->n_phases < k + 1) m->n_phases = k + 1;
    if (deck_enter(d, list->child[k], &deck_phases, &g))
      read_phase(&g, &output, &m->phases[k], k + 1 == list->n);
  }
}

/* --- measurements ----------------------------------------------------------------------------- */

/* Appends the disks that a key names to *list, which has *n elements; reports disks that are named
 * twice. */
static void add_disks(deck *d, deck_node *names, size_t *n, uint32_t **list) {
  for (size_t k = 0; k < deck_each_count(names); k++) {
    deck_node *node = deck_each(names, k);
    uint32_t disk;
    size_t before = 0;
    if (!deck_find_body(d, node, false, &disk)) continue;
    while (before < *n && (*list)[before] != disk) before++;
    if (before < *n) {
      deck_fail(d, node, "named twice");
      continue;
    }
    *list = memory_grow(*list, *n + 1, sizeof **list);
    (*list)[(*n)++] = disk;
  }
}

static void read_rotation(deck_group *g) {
  deck *d = g->d;
  sd_model *m = d->model;
  deck_node *list = deck_get(g, "rotation");
  if (!list) {
    list = deck_default_list(g, "rotation");
    for (size_t i = 0; m->n_free <= MOST_WATCHED && i < m->n_disks; i++)
      if (!m->disks[i].driven) add_entry(d, list, m->disks[i].name, i);
  }
  add_disks(d, list, &m->n_rotations, &m->rotations);
}

static void read_sliding(deck *d, deck_node *node) {
  sd_model *m = d->model;
  deck_group g;
  if (!deck_enter(d, node, &deck_sliding, &g)) return;
  sd_slide_watch watch;
  deck_node *disk = deck_get(&g, "disk"), *partners = deck_get(&g, "partners");
  if (!disk) deck_fail_key(&g, "disk", "missing: expected the name or the number of a disk");
  if (!partners || partners->type != DECK_LIST || partners->n != 2)
    deck_fail_key(&g, "partners", "expected two disks or walls (\"a\", \"b\")");
  if (!disk || !deck_find_body(d, disk, false, &watch.disk)) return;
  if (m->disks[watch.disk].driven)
    deck_fail(d, disk, "this disk is fixed or moved by motions; expected a free one");
  if (!partners || partners->type != DECK_LIST || partners->n != 2) return;
  bool found = deck_find_body(d, partners->child[0], true, &watch.partner[0]);
  if (!deck_find_body(d, partners->child[1], true, &watch.partner[1]) || !found) return;
  if (watch.partner[0] == watch.partner[1]) deck_fail(d, partners, "expected two different ones");
  if (watch.partner[0] == watch.disk || watch.partner[1] == watch.disk)
    deck_fail(d, partners, "a disk does not touch itself");
  m->slides = memory_grow(m->slides, m->n_slides + 1, sizeof *m->slides);
  m->slides[m->n_slides++] = watch;
}

void deck_read_measure(deck *d) {
  deck_group g;
  if (!deck_enter_one(d, &deck_measure, &g)) return;
  read_rotation(&g);
  sd_model *m = d->model;
  deck_fill(&g, m);
  add_disks(d, deck_get(&g, "contacts"), &m->n_contact_disks, &m->contact_disks);
  if (m->measure_walls && m->n_walls == 0) deck_fail_key(&g, "walls", "there are no walls");
  if (m->measure_groups && m->n_groups == 0)
    deck_fail_key(&g, "groups", "no disk has a group; expected a `group` of disks or packings");
  deck_node *list = deck_groups(d, g.node, "sliding");
  for (size_t k = 0; list && k < list->n; k++) read_sliding(d, list->child[k]);
  deck_read_averages(d, deck_get(&g, "averages"));
}

/* --- until ------------------------------------------------------------------------------------ */

/* The group `until` sets the standard error at which the last phase ends (sd_until in
 * slipdisk/model.h). The model's last phase then has the largest possible number of steps
 * (max_time); until.least holds the length that the deck gives the phase. */

static const char *const quantities[] = {"omega", "scaled"};
enum { OMEGA, SCALED, QUANTITIES };

/* Returns the first part of an observable's name for the k-th observed disk: the name of the disk,
 * or its number. */
static const char *watched_name(deck *d, size_t k) {
  uint32_t disk = d->model->rotations[k];
  const char *name = d->model->disks[disk].name;
  return name ? name : deck_format(d, "%u", disk);
}

/* Returns the index of a disk among the observed disks, found by its name or number; n_rotations:
 * not there. */
static size_t find_watched(deck *d, const char *name) {
  const sd_model *m = d->model;
  for (size_t k = 0; k < m->n_rotations; k++)
    if (strcmp(watched_name(d, k), name) == 0) return k;
  for (size_t k = 0; k < m->n_rotations; k++)
    if (strcmp(deck_format(d, "%u", m->rotations[k]), name) == 0) return k;
  return m->n_rotations;
}

static void read_disk(deck *d, const deck_node *node, const char *name) {
  sd_model *m = d->model;
  m->until.rotation = find_watched(d, name);
  if (m->until.rotation < m->n_rotations) return;
  guess near = guess_start(name);
  for (size_t k = 0; k < m->n_rotations; k++) guess_add(&near, watched_name(d, k));
  deck_fail(d, node, "measure.rotation watches no disk that is called \"%s\"%s", name,
            deck_hint(d, &near));
}

static void read_quantity(deck *d, const deck_node *node, const char *word) {
  guess near = guess_start(word);
  int kind = 0;
  while (kind < QUANTITIES && strcmp(quantities[kind], word) != 0)
    guess_add(&near, quantities[kind++]);
  if (kind == QUANTITIES)
    deck_fail(d, node, "expected \"NAME.omega\" or \"NAME.scaled\", NAME that of a watched disk%s",
              deck_hint(d, &near));
  d->model->until.scaled = kind == SCALED;
  if (kind == SCALED && d->model->gravity[0] == 0 && d->model->gravity[1] == 0)
    deck_fail(d, node, "t_g Omega does not exist without gravity; expected \"NAME.omega\"");
}

/* Reads the key `observable`, such as "upper.omega"; the disk's name may contain dots. */
static void read_observable(deck_group *g) {
  deck *d = g->d;
  if (d->model->n_rotations == 0) {
    deck_fail_key(g, "observable", "no disk is watched; expected measure.rotation to name one");
    return;
  }
  deck_default_text(g, "observable", deck_format(d, "%s.omega", watched_name(d, 0)));
  const char *text = deck_text_of(g, "observable");
  if (!text) return;
  const deck_node *node = deck_get(g, "observable");
  const char *dot = strrchr(text, '.');
  read_quantity(d, node, dot ? dot + 1 : "");
  if (dot) read_disk(d, node, deck_copy(d, text, (size_t)(dot - text)));
}

/* Takes the length of the last phase as its least length, and max_time as its greatest; both are
 * stored in steps. */
static void read_length(deck_group *g, sd_phase *last) {
  deck *d = g->d;
  d->model->until.least = last->steps;
  double most = round(deck_number(g, "max_time") / d->model->dt);
  if (isnan(most)) return; /* An invalid max_time was reported before */
  if (most >= 9e18)
    deck_fail_key(g, "max_time", "more than 9e18 time steps");
  else if (most < (double)last->steps)
    deck_fail_key(g, "max_time", "expected at least the length of the last phase, %g",
                  (double)last->steps * d->model->dt);
  else
    last->steps = (int64_t)most;
}

void deck_read_until(deck *d) {
  sd_model *m = d->model;
  deck_group g;
  if (!deck_child(d->root, "until")) return;
  if (!deck_enter_one(d, &deck_until, &g)) return;
  m->until.asked = true;
  read_observable(&g);
  deck_one_of(&g, "the standard error to be reached, error or relative");
  deck_fill(&g, &m->until);
  if (m->n_phases == 0) return; /* Missing phases were reported before */
  sd_phase *last = &m->phases[m->n_phases - 1];
  if (!last->measure)
    deck_fail(d, g.node, "the last phase does not measure; expected measure = true in it");
  read_length(&g, last);
}
