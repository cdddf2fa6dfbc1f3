/* deck_until.c: the group `until`, the error bar at which the last phase ends. See deck_tree.h and
 * sd_until in slipdisk/model.h.
 *
 * The last phase of the model has the largest possible number of steps (max_time); until.least
 * holds its own length. */
#include <math.h>
#include <string.h>

#include "io/deck/deck_read.h"

static const char *const quantities[] = {"omega", "scaled"};
enum { OMEGA, SCALED, QUANTITIES };

/* Returns the name of the k-th observed disk in the names of observables: its name, else its
 * number. */
static const char *watched_name(deck *d, size_t k) {
  uint32_t disk = d->model->rotations[k];
  const char *name = d->model->disks[disk].name;
  return name ? name : deck_format(d, "%u", disk);
}

/* Returns the index of the observed disk with this name or number; n_rotations: none. */
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

/* Makes the length of the last phase its least length, and max_time its greatest; both in steps. */
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
