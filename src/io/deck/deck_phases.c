/* deck_phases.c: phases, output cadences and measurements. See deck.h. */
#include <math.h>
#include <string.h>

#include "base/limits.h"
#include "io/deck/deck_read.h"

/* All free disks are watched when there are no more than these. */
enum { MOST_WATCHED = 16 };

/* --- length ------------------------------------------------------------------------------------------------ */

/* The keys steps and time of a phase, or of the deck itself. */
static int64_t read_steps(deck_group *g) {
  deck *d = g->d;
  bool steps = deck_given(g, "steps"), time = deck_given(g, "time");
  if (steps && time) deck_fail_key(d, g->node, "time", "given together with steps; expected one of them");
  if (!steps && !time) deck_fail_key(d, g->node, "steps", "missing: expected the length in steps or time");
  if (steps) return deck_integer(g, "steps");
  if (!time) return 1;
  double n = round(deck_number(g, "time") / d->model->dt);
  if (isnan(n)) return 1; /* reported */
  if (n >= 1 && n < 9e18) return (int64_t)n;
  deck_fail_key(d, g->node, "time", n < 1 ? "shorter than half a time step" : "more than 9e18 time steps");
  return 1;
}

/* --- motions that are on ------------------------------------------------------------------------------------ */

/* Place of the motion in the deck; false: reported. */
static bool find_motion(deck *d, const deck_node *node, size_t *entry) {
  const deck_node *list = deck_child(d->root, "motions");
  size_t n = list && list->type == DECK_LIST ? list->n : 0;
  if (node->type == DECK_INT) {
    *entry = (size_t)node->value.integer;
    if (node->value.integer >= 0 && (uint64_t)node->value.integer < n) return true;
    deck_fail(d, node, "no motion has this number; there are %zu, counted from 0", n);
    return false;
  }
  if (node->type != DECK_STRING) {
    deck_fail(d, node, "expected the name or the number of a motion");
    return false;
  }
  uint32_t found;
  if (deck_index_find(&d->motions, node->value.text, &found)) {
    *entry = found;
    return true;
  }
  deck_guess guess = deck_guess_start(node->value.text);
  for (size_t k = 0; k < n && !deck_told(d); k++) {
    const deck_node *name = deck_child(list->child[k], "name");
    if (name && name->type == DECK_STRING) deck_guess_add(&guess, name->value.text);
  }
  deck_fail(d, node, "no motion is called that%s%s%s", guess.best ? "; did you mean \"" : "",
            guess.best ? guess.best : "", guess.best ? "\"?" : "");
  return false;
}

/* Every motion of the deck, by name where it has one. */
static void default_motions(deck_group *g) {
  const deck_node *all = deck_child(g->d->root, "motions");
  deck_node *list = deck_default_list(g, "motions");
  for (size_t k = 0; all && all->type == DECK_LIST && k < all->n; k++) {
    const deck_node *name = deck_child(all->child[k], "name");
    bool text = name && name->type == DECK_STRING;
    deck_node *node = deck_node_new(g->d, list, NULL, text ? DECK_STRING : DECK_INT, list->place);
    if (text)
      node->value.text = name->value.text;
    else
      node->value.integer = (int64_t)k;
  }
}

static void read_active(deck_group *g, sd_phase *phase) {
  deck *d = g->d;
  const sd_model *m = d->model;
  phase->active = deck_keep(d, m->n_motions, sizeof *phase->active);
  deck_node *list = deck_get(g, "motions");
  if (!list) {
    default_motions(g);
    for (size_t k = 0; k < m->n_motions; k++) phase->active[k] = true;
    return;
  }
  const deck_node *all = deck_child(d->root, "motions");
  bool *on = deck_alloc(d, all ? all->n + 1 : 1, sizeof *on);
  for (size_t j = 0; j < deck_each_count(list); j++) {
    size_t entry;
    if (find_motion(d, deck_each(list, j), &entry)) on[entry] = true;
  }
  for (size_t k = 0; k < m->n_motions; k++) phase->active[k] = on[d->motion_entry[k]];
}

/* --- cadences ------------------------------------------------------------------------------------------------ */

static void read_cadence(deck_group *g, deck_group *output, const char *key, int64_t otherwise,
                         int64_t *every) {
  int64_t usual = deck_get(output, key) ? deck_integer(output, key) : otherwise;
  deck_default_integer(g, key, usual);
  *every = deck_integer(g, key);
}

/* --- settling, relaxing, compressing -------------------------------------------------------------------------- */

static void read_settle(deck_group *g, sd_settle *settle) {
  deck *d = g->d;
  deck_node *node = deck_get(g, "settle");
  deck_group s;
  if (!node || !deck_enter(d, node, &deck_settle, &s)) return;
  settle->asked = true;
  bool kinetic = deck_given(&s, "kinetic"), unbalanced = deck_given(&s, "unbalanced");
  if (kinetic) settle->kinetic = deck_number(&s, "kinetic");
  if (unbalanced) settle->unbalanced = deck_number(&s, "unbalanced");
  if (!kinetic && !unbalanced)
    deck_fail(d, node, "it has no criterion; expected kinetic, unbalanced or both");
  settle->every = deck_integer(&s, "every");
}

static void read_compress(deck_group *g, sd_compress *compress) {
  deck *d = g->d;
  deck_node *node = deck_get(g, "compress");
  deck_group c;
  if (!node || !deck_enter(d, node, &deck_compress, &c)) return;
  compress->asked = true;
  bool pressure = deck_given(&c, "pressure"), fraction = deck_given(&c, "fraction");
  if (pressure == fraction) deck_fail(d, node, "expected one target, either pressure or fraction");
  if (pressure) compress->pressure = deck_number(&c, "pressure");
  if (fraction) compress->fraction = deck_number(&c, "fraction");
  compress->rate = deck_number(&c, "rate");
  compress->tolerance = deck_number(&c, "tolerance");
  if (d->model->region_upper[0] <= d->model->region_lower[0] ||
      d->model->region_upper[1] <= d->model->region_lower[1])
    deck_fail(d, node, "there is nothing to compress; expected a container, or a box with edges x and y");
}

static void read_phase(deck_group *g, deck_group *output, sd_phase *phase, bool last) {
  deck *d = g->d;
  phase->name = deck_keep_text(d, deck_text_of(g, "name"));
  phase->steps = read_steps(g);
  read_active(g, phase);
  deck_default_bool(g, "measure", last);
  phase->measure = deck_bool(g, "measure");
  int64_t thousandth = phase->steps < 1000 ? 1 : phase->steps / 1000;
  read_cadence(g, output, "series", thousandth, &phase->series_every);
  read_cadence(g, output, "frames", 0, &phase->frames_every);
  read_cadence(g, output, "contacts", 0, &phase->contacts_every);
  read_settle(g, &phase->settle);
  phase->relax = deck_bool(g, "relax");
  read_compress(g, &phase->compress);
}

void deck_read_phases(deck *d) {
  sd_model *m = d->model;
  deck_group top = {d, d->root, &deck_top}, output;
  deck_node *list = deck_groups(d, d->root, "phases");
  if (list && list->n > LIMIT_PHASES) {
    deck_fail(d, list, "%zu phases; expected at most %d", list->n, LIMIT_PHASES);
    return;
  }
  bool short_form = deck_given(&top, "steps") || deck_given(&top, "time");
  if (!deck_enter_one(d, d->root, "output", &deck_output, &output)) return;
  if (!list && deck_get(&top, "phases")) return;
  if (list && short_form)
    deck_fail_key(d, d->root, deck_given(&top, "steps") ? "steps" : "time",
                  "given together with phases; expected a length in each phase");
  /* steps = ... alone is a deck with one phase, and is echoed as one */
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
  if (!list || list->n == 0) {
    deck_fail_key(d, d->root, "steps", "missing: expected steps, time or phases");
    return;
  }
  m->phases = deck_keep(d, list->n, sizeof *m->phases);
  for (size_t k = 0; k < list->n; k++) {
    deck_group g;
    m->n_phases = k + 1;
    if (deck_enter(d, list->child[k], &deck_phases, &g))
      read_phase(&g, &output, &m->phases[k], k + 1 == list->n);
  }
}

/* --- measurements -------------------------------------------------------------------------------------------- */

static void add_rotation(deck *d, uint32_t disk, const deck_node *node) {
  sd_model *m = d->model;
  for (size_t k = 0; k < m->n_rotations; k++)
    if (m->rotations[k] == disk) {
      deck_fail(d, node, "named twice");
      return;
    }
  m->rotations = deck_grow(d, m->rotations, m->n_rotations + 1, sizeof *m->rotations);
  m->rotations[m->n_rotations++] = disk;
}

static void read_rotation(deck_group *g) {
  deck *d = g->d;
  const sd_model *m = d->model;
  deck_node *list = deck_get(g, "rotation");
  size_t n_free = 0;
  for (size_t i = 0; i < m->n_disks; i++) n_free += !deck_is_driven(d, i);
  if (!list) {
    list = deck_default_list(g, "rotation");
    for (size_t i = 0; n_free <= MOST_WATCHED && i < m->n_disks; i++) {
      if (deck_is_driven(d, i)) continue;
      bool named = m->disks[i].name != NULL;
      deck_node *node = deck_node_new(d, list, NULL, named ? DECK_STRING : DECK_INT, list->place);
      if (named)
        node->value.text = m->disks[i].name;
      else
        node->value.integer = (int64_t)i;
    }
  }
  for (size_t k = 0; k < deck_each_count(list); k++) {
    uint32_t disk;
    if (deck_find_body(d, deck_each(list, k), false, &disk)) add_rotation(d, disk, deck_each(list, k));
  }
}

static void read_sliding(deck *d, deck_node *node) {
  sd_model *m = d->model;
  deck_group g;
  if (!deck_enter(d, node, &deck_sliding, &g)) return;
  sd_slide_watch watch;
  deck_node *disk = deck_get(&g, "disk"), *partners = deck_get(&g, "partners");
  if (!disk) deck_fail_key(d, node, "disk", "missing: expected the name or the number of a disk");
  if (!partners || partners->type != DECK_LIST || partners->n != 2)
    deck_fail_key(d, node, "partners", "expected two disks or walls (\"a\", \"b\")");
  if (!disk || !deck_find_body(d, disk, false, &watch.disk)) return;
  if (deck_is_driven(d, watch.disk))
    deck_fail(d, disk, "this disk is fixed or moved by motions; expected a free one");
  if (!partners || partners->type != DECK_LIST || partners->n != 2) return;
  bool found = deck_find_body(d, partners->child[0], true, &watch.partner[0]);
  if (!deck_find_body(d, partners->child[1], true, &watch.partner[1]) || !found) return;
  if (watch.partner[0] == watch.partner[1]) deck_fail(d, partners, "expected two different ones");
  if (watch.partner[0] == watch.disk || watch.partner[1] == watch.disk)
    deck_fail(d, partners, "a disk does not touch itself");
  m->slides = deck_grow(d, m->slides, m->n_slides + 1, sizeof *m->slides);
  m->slides[m->n_slides++] = watch;
}

void deck_read_measure(deck *d) {
  deck_group g;
  if (!deck_enter_one(d, d->root, "measure", &deck_measure, &g)) return;
  read_rotation(&g);
  d->model->measure_disks = deck_bool(&g, "disks");
  d->model->measure_every = deck_integer(&g, "every");
  deck_node *list = deck_groups(d, g.node, "sliding");
  for (size_t k = 0; list && k < list->n; k++) read_sliding(d, list->child[k]);
}
