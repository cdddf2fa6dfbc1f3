/* sweep_precheck.c: what can be said of a sweep's points before any of them runs: mistakes, lengths, time steps, columns
 * of the table that there will not be. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "app/app.h"
#include "app/sweep/sweep.h"
#include "base/memory.h"
#include "model/advice.h"
#include "model/state.h"
#include "run/ensemble.h"

/* More kinds of systems than this in one sweep are not looked for: what comes later runs alone. */
enum { MOST_KINDS = 64 };
/* Points that --point K looks at besides its own. */
enum { SAMPLE = 8 };

/* Messages of one check about the points. */
typedef struct advice {
  size_t n, point; /* sets of values with a warning, a point of the worst */
  double worst;
  char *warning;
} advice;

/* Bytes of memory that points need. */
typedef struct needs {
  double least, most; /* of any, in any case; of the largest, by the estimate */
  size_t largest;     /* this point */
  size_t refused;     /* sets of values that one process has no memory for */
  size_t first;       /* a point of these, ... */
  char *why;          /* ... and its message */
} needs;

typedef struct precheck {
  const sweep *s;
  int64_t *steps;
  int *kinds;
  int n_kinds;
  sd_model *models[MOST_KINDS]; /* one of each */
  advice *advice;               /* [advice_count] */
  needs needs;
  bool *collected; /* [n_collect]: the pattern is a column of some point */
} precheck;

/* --- points -------------------------------------------------------------------------------------------------- */

static bool is_told(const sd_messages *messages, const char *text) {
  for (size_t k = 0; k < sd_messages_count(messages); k++)
    if (strcmp(sd_messages_text(messages, k), text) == 0) return true;
  return false;
}

/* True: the model is kept, as the first of its kind. */
static bool find_kind(precheck *v, sd_model *model, int *kind) {
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

/* One warning of a kind for all points is enough, that of the worst. */
static void look_at_advice(precheck *v, size_t point, const sd_model *model) {
  for (size_t k = 0; k < advice_count; k++) {
    advice *a = &v->advice[k];
    sd_messages *mine = sd_messages_new();
    double bad = advice_checks[k](model, mine);
    if (bad > 0 && (a->n++ == 0 || bad > a->worst)) {
      free(a->warning);
      *a = (advice){a->n, point, bad, memory_text(sd_messages_text(mine, 0))};
    }
    sd_messages_free(mine);
  }
}

static void look_at_memory(needs *n, size_t point, const sd_model *model) {
  const double usual = size_memory(model);
  sd_messages *mine = sd_messages_new();
  n->least = fmin(n->least, state_least_bytes(model));
  if (usual > n->most) {
    n->most = usual;
    n->largest = point;
  }
  if (state_refuse(model, mine) != SD_OK && n->refused++ == 0) {
    n->first = point;
    n->why = memory_text(sd_messages_text(mine, 0));
  }
  sd_messages_free(mine);
}

static bool visit(void *user, size_t point, sd_model *model) {
  precheck *v = user;
  v->steps[point] = sd_model_steps(model);
  look_at_advice(v, point, model);
  look_at_memory(&v->needs, point, model);
  sweep_columns(v->s, point, model, v->collected);
  return find_kind(v, model, &v->kinds[point]);
}

/* Warnings after all points have been checked. all: none of them has mistakes. */
static void conclude(const precheck *v, bool all, sd_messages *messages) {
  const deck_sweep *d = &v->s->deck;
  if (!d->written)
    sd_warn(messages, "%s: there is no group sweep: one point, \"%s\", is the deck as it stands",
            d->deck_path, d->points[0].name);
  for (size_t k = 0; k < advice_count; k++) {
    const advice *a = &v->advice[k];
    if (a->warning && !is_told(messages, a->warning))
      sd_warn(messages, "%s (point %zu, %s%s; %zu of %zu sets of values)", a->warning, a->point,
              d->points[a->point].name, a->n > 1 ? ", the worst" : "", a->n, d->n_sets);
  }
  for (size_t k = 0; all && k < d->n_collect; k++)
    if (!v->collected[k])
      sd_warn(messages, "collect: \"%s\" will be no column of the table", d->collect[k]);
}

/* Points that run side by side share the memory of the machine. */
static sd_status conclude_memory(const needs *n, const sweep *s, size_t workers,
                                 sd_messages *messages) {
  const deck_sweep *d = &s->deck;
  char need[40], there[40];
  if (n->refused > 0)
    return sd_fail(messages, SD_ERROR_IO, "%s (point %zu, %s; %zu of %zu sets of values)", n->why,
                   n->first, d->points[n->first].name, n->refused, d->n_sets);
  size_t side_by_side = 0;
  for (size_t k = 0; k < d->n_points && side_by_side < workers; k++) {
    const sweep_status there_is = sweep_peek(s, k);
    side_by_side += there_is != SWEEP_DONE && there_is != SWEEP_RUNNING;
  }
  if (side_by_side < 2) return SD_OK;
  const double limit = memory_limit(side_by_side);
  if (n->most <= limit) return SD_OK;
  size_t fewer = side_by_side;
  while (fewer > 1 && n->most > memory_limit(fewer)) fewer--;
  size_text(limit, there, sizeof there);
  if (n->least > limit)
    return sd_fail(
        messages, SD_ERROR_IO,
        "-j %zu: each point needs at least %s of memory, and each of %zu processes can have %s; "
        "expected -j %zu at most",
        workers, size_text(n->least, need, sizeof need), side_by_side, there, fewer);
  sd_warn(messages,
          "-j %zu: point %zu, %s, needs about %s of memory, and each of %zu processes can have %s: "
          "they may "
          "be killed; expected -j %zu at most",
          workers, n->largest, d->points[n->largest].name, size_text(n->most, need, sizeof need),
          side_by_side, there, fewer);
  return SD_OK;
}

sd_status sweep_precheck(const sweep *s, size_t workers, int64_t *steps, int *kinds, size_t *usable,
                         sd_messages *messages) {
  precheck v = {.s = s,
                .steps = steps,
                .kinds = kinds,
                .needs.least = HUGE_VAL,
                .collected = memory_new(s->deck.n_collect, sizeof *v.collected),
                .advice = memory_new(advice_count, sizeof *v.advice)};
  size_t *first = memory_new(s->deck.n_sets, sizeof *first);
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
  *usable -= v.needs.refused;
  const sd_status room = conclude_memory(&v.needs, s, workers, messages);
  if (room != SD_OK && v.needs.refused == 0) *usable = 0; /* of all together */
  if (status == SD_OK) status = room;
  free(v.needs.why);
  for (int k = 0; k < v.n_kinds; k++) sd_model_free(v.models[k]);
  for (size_t k = 0; k < advice_count; k++) free(v.advice[k].warning);
  free(v.advice);
  free(v.collected);
  free(first);
  return status;
}

/* --- the folder -------------------------------------------------------------------------------------------- */

/* Points of another deck among some of those outside [first, end) that are there. */
static sd_status look_at_sample(const sweep *s, const sweep_contents *there, size_t first,
                                size_t end, sd_messages *messages) {
  sweep_tally others = {0};
  size_t n = 0, met = 0;
  for (size_t k = 0; k < s->deck.n_points; k++) n += there->has[k] && (k < first || k >= end);
  size_t every = n / SAMPLE + 1;
  others.sampled = every > 1 || n < there->known;
  for (size_t k = 0; k < s->deck.n_points; k++) {
    if (!there->has[k] || (k >= first && k < end) || met++ % every != 0) continue;
    sweep_result r;
    sweep_look(s, k, &r);
    sweep_tally_add(&others, &r);
    sweep_result_free(&r);
  }
  sd_status status = sweep_refuse_others(s, &others, "nothing is run", messages);
  sweep_tally_free(&others);
  return status;
}

sd_status sweep_guard(const sweep *s, const sweep_command *c, size_t first, size_t end,
                      sd_messages *messages) {
  sweep_contents there;
  if (c->mix) return SD_OK;
  sweep_list(s, &there);
  sd_status status = sweep_refuse_strangers(s, &there, "nothing is run", messages);
  if (status == SD_OK && !c->force) status = look_at_sample(s, &there, first, end, messages);
  sweep_contents_free(&there);
  return status;
}
