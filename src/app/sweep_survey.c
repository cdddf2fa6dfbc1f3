/* sweep_survey.c: what can be said of a sweep's points before any of them runs: mistakes, lengths, time steps. */
#include <stdlib.h>
#include <string.h>

#include "app/app.h"
#include "app/sweep.h"
#include "io/file.h"

typedef struct survey {
  const sweep *s;
  int64_t *steps;
  size_t n_warned, first_warned; /* sets of values with a warning, a point of the first */
  char *warning;                 /* of the first */
} survey;

static bool is_told(const sd_messages *messages, const char *text) {
  for (size_t k = 0; k < sd_messages_count(messages); k++)
    if (strcmp(sd_messages_text(messages, k), text) == 0) return true;
  return false;
}

static void visit(void *user, size_t point, const sd_model *model) {
  survey *v = user;
  v->steps[point] = sd_model_steps(model);
  sd_messages *mine = sd_messages_new();
  report_time_step(model, mine);
  if (sd_messages_count(mine) > 0 && v->n_warned++ == 0) {
    v->first_warned = point;
    v->warning = file_path("%s", sd_messages_text(mine, 0));
  }
  sd_messages_free(mine);
}

sd_status sweep_survey(const sweep *s, int64_t *steps, size_t *usable, sd_messages *messages) {
  survey v = {.s = s, .steps = steps};
  for (size_t k = 0; k < s->deck.n_points; k++) steps[k] = 0;
  int64_t *length = calloc(s->deck.n_sets + 1, sizeof *length);
  if (!length) return sd_fail(messages, SD_ERROR_IO, "no memory for the sweep");
  sd_status status = sweep_check(s, visit, &v, usable, messages);
  /* points of one set are equally long, and the first of them was visited */
  for (size_t k = 0; k < s->deck.n_points; k++) {
    int64_t *mine = &length[s->deck.points[k].set];
    if (steps[k] > 0) *mine = steps[k];
    steps[k] = *mine;
  }
  if (v.warning && !is_told(messages, v.warning))
    sd_warn(messages, "%s (point %zu, %s; %zu of %zu sets of values)", v.warning, v.first_warned,
            s->deck.points[v.first_warned].name, v.n_warned, s->deck.n_sets);
  free(v.warning);
  free(length);
  return status;
}
