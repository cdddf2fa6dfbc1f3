/* sweep_survey.c: what can be said of a sweep's points before any of them runs: mistakes, lengths, time steps. */
#include <stdlib.h>
#include <string.h>

#include "app/app.h"
#include "app/sweep.h"
#include "io/file.h"
#include "run/ensemble.h"

/* More kinds of systems than this in one sweep are not looked for: what comes later runs alone. */
enum { MOST_KINDS = 64 };

typedef struct survey {
  const sweep *s;
  int64_t *steps;
  int *kinds;
  int n_kinds;
  sd_model *models[MOST_KINDS];  /* one of each */
  size_t n_warned, first_warned; /* sets of values with a warning, a point of the first */
  char *warning;                 /* of the first */
} survey;

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

static bool visit(void *user, size_t point, sd_model *model) {
  survey *v = user;
  v->steps[point] = sd_model_steps(model);
  sd_messages *mine = sd_messages_new();
  report_time_step(model, mine);
  if (sd_messages_count(mine) > 0 && v->n_warned++ == 0) {
    v->first_warned = point;
    v->warning = file_path("%s", sd_messages_text(mine, 0));
  }
  sd_messages_free(mine);
  return find_kind(v, model, &v->kinds[point]);
}

sd_status sweep_survey(const sweep *s, int64_t *steps, int *kinds, size_t *usable, sd_messages *messages) {
  survey v = {.s = s, .steps = steps, .kinds = kinds};
  size_t *first = malloc((s->deck.n_sets + 1) * sizeof *first);
  if (!first) return sd_fail(messages, SD_ERROR_IO, "no memory for the sweep");
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
  if (v.warning && !is_told(messages, v.warning))
    sd_warn(messages, "%s (point %zu, %s; %zu of %zu sets of values)", v.warning, v.first_warned,
            s->deck.points[v.first_warned].name, v.n_warned, s->deck.n_sets);
  for (int k = 0; k < v.n_kinds; k++) sd_model_free(v.models[k]);
  free(v.warning);
  free(first);
  return status;
}
