/* sweep_survey.c: what can be said of a sweep's points before any of them runs: mistakes, lengths, time steps, columns
 * of the table that there will not be. */
#include <fnmatch.h>
#include <stdlib.h>
#include <string.h>

#include "base/text.h"
#include "app/app.h"
#include "app/sweep.h"
#include "io/store/file.h"
#include "io/results/summary_disks.h"
#include "run/ensemble.h"

/* More kinds of systems than this in one sweep are not looked for: what comes later runs alone. */
enum { MOST_KINDS = 64 };

typedef struct survey {
  const sweep *s;
  int64_t *steps;
  int *kinds;
  int n_kinds;
  sd_model *models[MOST_KINDS]; /* one of each */
  size_t n_warned, warned;      /* sets of values with a warning of the time step, a point of the worst */
  double worst;                 /* time step over shortest contact period of that point */
  char *warning;
  bool *collected; /* [n_collect]: the pattern is a column of some point */
} survey;

/* --- columns of the table ----------------------------------------------------------------------------------- */

/* The table is made in run/sweep_table.c, of what runs have found; tests/test_check_sweep.py compares the two. */
static const char *const of_all[] = {"point",
                                     "name",
                                     "status",
                                     "set",
                                     "replica",
                                     "seed",
                                     "message",
                                     "steps",
                                     "time",
                                     "work",
                                     "residual",
                                     "kinetic_translation",
                                     "kinetic_rotation",
                                     "viscous",
                                     "friction",
                                     "ns_per_step"};
static const char *const of_rotations[] = {"omega",     "omega_error", "scaled",   "scaled_error",
                                           "transient", "measured",    "converged"};
static const char *const of_slides[] = {"pp", "pm", "mp", "mm", "stick", "open"};
static const char *const of_contacts[] = {"sliding", "force_min", "openings"};
#define COUNT(list) (sizeof(list) / sizeof *(list))

/* Is owner.word a column that is asked for? */
static bool has_word(const char *pattern, const char *owner, const char *const *words, size_t n) {
  bool found = false;
  for (size_t k = 0; k < n && !found; k++) {
    char *name = *owner ? format_text("%s.%s", owner, words[k]) : format_text("%s", words[k]);
    found = !name || fnmatch(pattern, name, 0) == 0; /* no memory: nothing is told */
    free(name);
  }
  return found;
}

/* As summaries name bodies. */
static const char *name_of(const sd_model *m, uint32_t body, char *text, size_t size) {
  const char *own = body < m->n_disks ? m->disks[body].name : m->walls[body - m->n_disks].name;
  return own && *own ? own : sd_model_body_name(m, body, text, size);
}

static bool has_slide(const char *pattern, const sd_model *m, const sd_slide_watch *watch) {
  char text[96], other[96];
  const char *disk = name_of(m, watch->disk, text, sizeof text);
  bool found = has_word(pattern, disk, of_slides, COUNT(of_slides));
  for (int c = 0; c < 2 && !found; c++) {
    char *owner = format_text("%s.%s", disk, name_of(m, watch->partner[c], other, sizeof other));
    found = !owner || has_word(pattern, owner, of_contacts, COUNT(of_contacts));
    free(owner);
  }
  return found;
}

static bool has_column(const sweep *s, const sd_model *m, const char *pattern) {
  char text[96];
  bool found = has_word(pattern, "", of_all, COUNT(of_all));
  for (size_t k = 0; k < s->deck.n_parameters && !found; k++)
    found = fnmatch(pattern, s->deck.parameters[k].name, 0) == 0;
  for (size_t k = 0; k < m->n_rotations && !found; k++)
    found =
        has_word(pattern, name_of(m, m->rotations[k], text, sizeof text), of_rotations, COUNT(of_rotations));
  for (size_t k = 0; k < m->n_slides && !found; k++) found = has_slide(pattern, m, &m->slides[k]);
  for (size_t k = 0; m->measure_disks && k < summary_total_count && !found; k++)
    found = fnmatch(pattern, summary_totals[k].name, 0) == 0;
  return found || (m->until.asked && fnmatch(pattern, "goal", 0) == 0);
}

/* --- points -------------------------------------------------------------------------------------------------- */

static bool is_told(const sd_messages *messages, const char *text) {
  for (size_t k = 0; k < sd_messages_count(messages); k++)
    if (strcmp(sd_messages_text(messages, k), text) == 0) return true;
  return false;
}

/* True: the model is kept, as the first of its kind. */
static bool find_kind(survey *v, sd_model *model, int *kind) {
  *kind = SWEEP_ALONE;
  if (!ensemble_takes(model)) return false;
  for (*kind = 0; *kind < v->n_kinds; ++*kind)
    if (ensemble_alike(v->models[*kind], model)) return false;
  if (v->n_kinds == MOST_KINDS) {
    *kind = SWEEP_ALONE;
    return false;
  }
  v->models[v->n_kinds++] = model;
  return true;
}

/* One warning for all points is enough, that of the point which needs the shortest step. */
static void look_at_time_step(survey *v, size_t point, const sd_model *model) {
  sd_messages *mine = app_messages();
  report_time_step(model, mine);
  double ratio = model->dt / sd_model_shortest_period(model, NULL);
  if (sd_messages_count(mine) > 0 && (v->n_warned++ == 0 || ratio > v->worst)) {
    v->worst = ratio;
    v->warned = point;
    free(v->warning);
    v->warning = format_text("%s", sd_messages_text(mine, 0));
  }
  sd_messages_free(mine);
}

static bool visit(void *user, size_t point, sd_model *model) {
  survey *v = user;
  v->steps[point] = sd_model_steps(model);
  look_at_time_step(v, point, model);
  for (size_t k = 0; k < v->s->deck.n_collect; k++)
    v->collected[k] = v->collected[k] || has_column(v->s, model, v->s->deck.collect[k]);
  return find_kind(v, model, &v->kinds[point]);
}

/* What is told when all points have been looked at. all: none of them has mistakes. */
static void conclude(const survey *v, bool all, sd_messages *messages) {
  const deck_sweep *d = &v->s->deck;
  if (!d->written)
    sd_warn(messages, "%s: there is no group sweep: one point, \"%s\", is the deck as it stands",
            d->deck_path, d->points[0].name);
  if (v->warning && !is_told(messages, v->warning))
    sd_warn(messages, "%s (point %zu, %s%s; %zu of %zu sets of values)", v->warning, v->warned,
            d->points[v->warned].name, v->n_warned > 1 ? ", the worst" : "", v->n_warned, d->n_sets);
  for (size_t k = 0; all && k < d->n_collect; k++)
    if (!v->collected[k]) sd_warn(messages, "collect: \"%s\" will be no column of the table", d->collect[k]);
}

sd_status sweep_survey(const sweep *s, int64_t *steps, int *kinds, size_t *usable, sd_messages *messages) {
  survey v = {.s = s, .steps = steps, .kinds = kinds};
  size_t *first = malloc((s->deck.n_sets + 1) * sizeof *first);
  v.collected = calloc(s->deck.n_collect + 1, sizeof *v.collected);
  if (!first || !v.collected) {
    free(first);
    free(v.collected);
    return sd_fail(messages, SD_ERROR_IO, "no memory for the sweep");
  }
  for (size_t k = 0; k < s->deck.n_sets; k++) first[k] = SIZE_MAX;
  for (size_t k = 0; k < s->deck.n_points; k++) {
    steps[k] = 0;
    kinds[k] = SWEEP_ALONE;
  }
  sd_status status = sweep_check(s, visit, &v, usable, messages);
  /* points of one set are equally long and of one kind, and the first of them was visited */
  for (size_t k = 0; k < s->deck.n_points; k++) {
    size_t *mine = &first[s->deck.points[k].set];
    if (*mine == SIZE_MAX) *mine = k;
    steps[k] = steps[*mine];
    kinds[k] = kinds[*mine];
  }
  conclude(&v, status == SD_OK, messages);
  for (int k = 0; k < v.n_kinds; k++) sd_model_free(v.models[k]);
  free(v.warning);
  free(v.collected);
  free(first);
  return status;
}
