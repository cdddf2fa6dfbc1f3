/* summary.c: computes the summary of a run's results, writes and reads it; see summary.h. Warnings
 * about a result (doubts) are in summary_doubts.c. */
#include "io/results/summary.h"

#include <math.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include "base/math.h"
#include "base/memory.h"
#include "base/team.h"
#include "base/text.h"
#include "io/store/members.h"
#include "model/model.h"
#include "pack/rain.h"
#include "physics/step/outside.h"

/* --- Tables of the numbers that are stored ---------------------------------------------------- */

#define FACT(field, type, unit, meaning, column, json)                                             \
  { #field, unit, meaning, type, 1, offsetof(summary, field), NULL, column, json, NULL }

OBSERVABLE_GET(time_of, summary, (double)at->step * at->dt)
OBSERVABLE_GET(measured_time, summary, (double)at->measured * at->dt)

static const observable fact_rows[] = {
    FACT(step, OBSERVABLE_I64, "1", "steps done, of all phases", "steps", NULL),
    FACT(steps, OBSERVABLE_I64, "1", "the most that there can be", NULL, NULL),
    {"time", "time", "time of the model", OBSERVABLE_F64, 1, 0, time_of, "time", NULL, NULL},
    FACT(dt, OBSERVABLE_F64, "time", "time step", NULL, NULL),
    FACT(phase, OBSERVABLE_I64, "1", "index of the phase", NULL, NULL),
    FACT(phases, OBSERVABLE_I64, "1", "number of phases: the index when all are over", NULL, NULL),
    FACT(measured, OBSERVABLE_I64, "1", "steps measured", NULL, "measured_steps"),
    {"measured_time", "time", "time measured", OBSERVABLE_F64, 1, 0, measured_time, NULL,
     "measured", NULL},
    FACT(disks, OBSERVABLE_I64, "1", "disks", NULL, NULL),
    FACT(walls, OBSERVABLE_I64, "1", "walls", NULL, NULL),
    FACT(contacts, OBSERVABLE_I64, "1", "closed contacts", NULL, NULL),
    FACT(waiting, OBSERVABLE_I64, "1", "disks that rain has not let go", NULL, NULL),
    FACT(outside, OBSERVABLE_I64, "1", "disks beyond the bounds or taken out", NULL, NULL),
    FACT(left, OBSERVABLE_I64, "1", "times that a disk left the bounds", NULL, NULL),
};
const observable_list fact_observables =
    OBSERVABLES("summary", "attributes of /summary, beside phase_name and lost", fact_rows);

static double relative_residual(const void *row, size_t k) {
  const sd_energy *e = &((const summary *)row)->energy;
  (void)k;
  return e->scale > 0 ? e->residual / e->scale : NAN;
}

static const observable outcome_rows[] = {
    {"relative_residual", "1", "residual of the energy budget, over its scale", OBSERVABLE_F64, 1,
     0, relative_residual, "residual", "", NULL},
    FACT(step_nanoseconds, OBSERVABLE_F64, "ns",
         "wall time per step; of points side by side the share of each", "ns_per_step", NULL),
};
const observable_list outcome_observables =
    OBSERVABLES("outcome", "further attributes of /summary", outcome_rows);

OBSERVABLE_GET(goal_reached, summary, at->until_step >= 0)

static const observable until_rows[] = {
    OBSERVABLE_FIELD("value", "rad/time or rad", "the observable", F64, summary, goal.value, NULL,
                     NULL),
    OBSERVABLE_FIELD("error", "as value", "one standard error", F64, summary, goal.error, NULL,
                     NULL),
    OBSERVABLE_FIELD("goal", "as value", "error bar asked for", F64, summary, goal.goal, NULL,
                     NULL),
    OBSERVABLE_FIELD("relative", "1", "the goal as a fraction of the value; NAN: given as it is",
                     F64, summary, relative, NULL, NULL),
    OBSERVABLE_FIELD("measured", "time", "time measured", F64, summary, goal.measured, NULL, ""),
    OBSERVABLE_FIELD("converged", "1", "1: the error is reliable", FLAG, summary, goal.converged,
                     NULL, NULL),
    {"reached", "1", "1: the run ended with its goal", OBSERVABLE_FLAG, 1, 0, goal_reached, "goal",
     NULL, NULL},
    OBSERVABLE_FIELD("step", "1", "step at which it did; -1: it did not", I64, summary, until_step,
                     NULL, ""),
};
const observable_list until_observables = OBSERVABLES(
    "until", "of the goal of `until`: attributes of /summary/until, with observable, its name",
    until_rows);

#define PHASE(field, type, unit, meaning)                                                          \
  { #field, unit, meaning, type, 1, offsetof(summary_phase, field), NULL, NULL, NULL, NULL }

static const observable phase_rows[] = {
    PHASE(steps, OBSERVABLE_I64, "1", "steps that the phase took, 0: not over"),
    PHASE(most, OBSERVABLE_I64, "1", "its length, the most it may take"),
    PHASE(asked, OBSERVABLE_I32, "1", "to settle 1, to compress 2, both 3"),
    PHASE(reached, OBSERVABLE_I32, "1", "1: ended with what was asked for"),
    PHASE(kinetic, OBSERVABLE_F64, "energy", "kinetic energy per disk at the end"),
    PHASE(kinetic_goal, OBSERVABLE_F64, "energy", "asked for; 0: nothing"),
    PHASE(unbalanced, OBSERVABLE_F64, "1",
          "mean resultant force on a disk over mean contact force at the end"),
    PHASE(unbalanced_goal, OBSERVABLE_F64, "1", "asked for; 0: nothing"),
    PHASE(target, OBSERVABLE_F64, "force/length or 1",
          "compression: pressure or packing fraction at the end"),
    PHASE(target_goal, OBSERVABLE_F64, "force/length or 1", "asked for; 0: nothing"),
};
const observable_list phase_observables =
    OBSERVABLES("phase", "of each phase, in /summary/phase", phase_rows);

/* Description of the arrays of structures in the summary. They are stored with the names of the
 * bodies or phases that the rows describe. */
static const struct group {
  const char *path, *names_path, *first;
  const observable_list *list;
  /* offsets in struct summary of: number of rows, pointer to the rows, pointer to the names */
  size_t count, rows, names;
  size_t stride, each; /* size of a row in bytes; number of names per row */
} groups[] = {
    {"/summary/rotation", "/summary/rotation/name", "/summary/rotation/disk", &rotation_observables,
     offsetof(summary, n_rotations), offsetof(summary, rotations),
     offsetof(summary, rotation_names), sizeof(sd_rotation), 1},
    {"/summary/slide", "/summary/slide/name", "/summary/slide/disk", &slide_observables,
     offsetof(summary, n_slides), offsetof(summary, slides), offsetof(summary, slide_names),
     sizeof(sd_slide), 3},
    {"/summary/configuration", "/summary/configuration/name", "/summary/configuration/disk",
     &configuration_observables, offsetof(summary, n_configurations),
     offsetof(summary, configurations), offsetof(summary, configuration_names),
     sizeof(sd_configuration), 1},
    {"/summary/average", "/summary/average/name", "/summary/average/mean", &average_observables,
     offsetof(summary, n_averages), offsetof(summary, averages), offsetof(summary, average_names),
     sizeof(sd_average), 3},
    {"/summary/phase", "/summary/phase/name", "/summary/phase/steps", &phase_observables,
     offsetof(summary, n_stages), offsetof(summary, stages), offsetof(summary, stage_names),
     sizeof(summary_phase), 1},
};
enum { GROUPS = sizeof groups / sizeof *groups };

static size_t *count_of(const summary *s, const struct group *g) {
  return (size_t *)(void *)((char *)(uintptr_t)s + g->count);
}

static void **rows_of(const summary *s, const struct group *g) {
  return (void **)(void *)((char *)(uintptr_t)s + g->rows);
}

static char ***names_of(const summary *s, const struct group *g) {
  return (char ***)(void *)((char *)(uintptr_t)s + g->names);
}

/* --- Collecting the summary from the state ---------------------------------------------------- */

const char *const summary_configurations[] = {"pp", "pm", "mp", "mm", "stick", "open"};

/* Returns a copy of the body's name in the deck, else a name such as "disk 17". */
static char *name_of(const sd_model *model, uint32_t body) {
  char text[80];
  const char *own =
      body < model->n_disks ? model->disks[body].name : model->walls[body - model->n_disks].name;
  return memory_text(own && *own ? own : sd_model_body_name(model, body, text, sizeof text));
}

static void collect_stages(summary *s, const sd_model *model, const sd_state *state) {
  for (size_t k = 0; k < s->n_stages; k++) {
    const sd_phase *p = &model->phases[k];
    s->stages[k] = (summary_phase){
        .steps = state->phase_steps[k],
        .most = p->steps,
        .asked =
            (p->settle.asked ? SUMMARY_SETTLE : 0) | (p->compress.asked ? SUMMARY_COMPRESS : 0),
        .reached = state->phase_reached[k],
        .kinetic = state->phase_kinetic[k],
        .kinetic_goal = p->settle.kinetic,
        .unbalanced = state->phase_unbalanced[k],
        .unbalanced_goal = p->settle.unbalanced,
        .target = state->phase_target[k],
        .target_goal = p->compress.pressure > 0.0 ? p->compress.pressure : p->compress.fraction};
  }
}

/* Lists the disks that have left the bounds or have been removed. */
static summary_lost lost_of(const sd_state *state) {
  summary_lost lost = {.n = outside_count(state)};
  for (size_t i = 0; i < state->n_free && lost.told < SUMMARY_LOST; i++)
    if (state->activity[i] == SD_OUTSIDE || state->activity[i] == SD_REMOVED)
      lost.first[lost.told++] =
          (struct summary_lost_disk){state->id[i], (uint32_t)i, state->x[i], state->y[i]};
  return lost;
}

/* Sets the number of disks outside the bounds, the number of disks that wait for insertion, and the
 * text that lists the first disks outside. */
static void collect_lost(summary *s, const sd_model *model, const sd_state *state,
                         const summary_lost *lost) {
  s->outside = lost->n;
  s->left = state->outside;
  s->waiting = rain_waiting(model, state);
  s->lost = memory_text("");
  for (const struct summary_lost_disk *d = lost->first; d < lost->first + lost->told; d++) {
    char name[96];
    s->lost = append_text(s->lost, "%s%s at (%.6g, %.6g)", d > lost->first ? ", " : "",
                          sd_model_body_name(model, d->disk, name, sizeof name), d->x, d->y);
  }
}

static void collect_until(summary *s, const sd_model *model, const sd_state *state) {
  const sd_until *u = &model->until;
  if (!u->asked) return;
  uint32_t disk = model->rotations[u->rotation];
  const char *name = model->disks[disk].name, *what = u->scaled ? "scaled" : "omega";
  s->observable = name ? format_text("%s.%s", name, what) : format_text("%u.%s", disk, what);
  s->relative = u->relative > 0 ? u->relative : NAN;
  s->goal = sd_goal_of(model, state);
  if (s->goal.reached && s->phase == s->phases) s->until_step = s->step;
}

void summary_new(summary *s, const sd_model *model) {
  *s = (summary){.steps = sd_model_steps(model),
                 .dt = model->dt,
                 .phases = (int64_t)model->n_phases,
                 .disks = (int64_t)model->n_disks,
                 .walls = (int64_t)model->n_walls,
                 .n_rotations = model->n_rotations,
                 .n_slides = model->n_slides,
                 .n_configurations =
                     model->measure_configurations ? SD_CONFIGURATIONS * model->n_slides : 0,
                 .n_averages = model->n_averages,
                 .n_stages = model->n_phases,
                 .has_until = model->until.asked,
                 .until_step = -1};
  for (const struct group *g = groups; g < groups + GROUPS; g++) {
    size_t n = *count_of(s, g);
    *rows_of(s, g) = memory_new(n, g->stride);
    *names_of(s, g) = memory_new(g->each * n, sizeof(char *));
  }
  for (size_t k = 0; k < s->n_rotations; k++)
    s->rotation_names[k] = name_of(model, model->rotations[k]);
  for (size_t k = 0; k < 3 * s->n_slides; k++) {
    const sd_slide_watch *watch = &model->slides[k / 3];
    s->slide_names[k] = name_of(model, k % 3 ? watch->partner[k % 3 - 1] : watch->disk);
  }
  for (size_t k = 0; k < s->n_configurations; k++) {
    const char *disk = s->slide_names[3 * (k / SD_CONFIGURATIONS)],
               *configuration = summary_configurations[k % SD_CONFIGURATIONS];
    s->configuration_names[k] = format_text("%s.%s", disk, configuration);
  }
  for (size_t k = 0; k < s->n_averages; k++) {
    const sd_average_watch *watch = &model->averages[k];
    s->average_names[3 * k] = memory_text(watch->name);
    s->average_names[3 * k + 1] = memory_text(watch->text);
    s->average_names[3 * k + 2] = average_unit(model, k);
  }
  for (size_t k = 0; k < s->n_stages; k++) {
    const char *name = model->phases[k].name;
    s->stage_names[k] = name ? memory_text(name) : format_text("%zu", k);
  }
}

summary_sums summary_sums_of(const sd_state *state) {
  summary_sums total = {.contacts = state->n_contacts,
                        .farthest = summary_farthest(state),
                        .not_finite = summary_not_finite(state),
                        .lost = lost_of(state)};
  for (size_t c = 0; c < state->n_contacts; c++) {
    exact_sum_add(&total.overlap, math_max(state->contact_overlap[c], 0.0));
    total.bonds += state->law_columns && state->contact_bond[c] > 0.0;
  }
  return total;
}

void summary_collect(summary *s, const sd_model *model, const sd_state *state,
                     const summary_sums *total, const sd_energy *energy, double step_nanoseconds) {
  const summary_sums all = total ? *total : summary_sums_of(state);
  summary_new(s, model);
  s->step = state->step;
  s->phase = state->phase;
  s->measured = state->measured;
  s->contacts = (int64_t)all.contacts;
  s->step_nanoseconds = step_nanoseconds;
  s->energy = *energy;
  bool running = state->phase >= 0 && (size_t)state->phase < model->n_phases;
  const char *phase = running ? model->phases[state->phase].name : NULL;
  s->phase_name = memory_text(phase ? phase : "");
  for (size_t k = 0; k < s->n_rotations; k++) s->rotations[k] = sd_rotation_of(model, state, k);
  for (size_t k = 0; k < s->n_slides; k++) s->slides[k] = sd_slide_of(model, state, k);
  for (size_t k = 0; k < s->n_configurations; k++)
    s->configurations[k] = sd_configuration_of(model, state, k);
  for (size_t k = 0; k < s->n_averages; k++) s->averages[k] = average_of(model, state, k);
  collect_stages(s, model, state);
  collect_until(s, model, state);
  collect_lost(s, model, state, &all.lost);
  summary_disks_announce(&s->packing, model, state);
  summary_judge(s, &model->limits, model, state, &all);
}

void summary_free(summary *s) {
  summary_disks_free(&s->packing);
  summary_doubts_free(s);
  for (const struct group *g = groups; g < groups + GROUPS; g++) {
    char **names = *names_of(s, g);
    for (size_t k = 0; names && k < g->each * *count_of(s, g); k++) free(names[k]);
    free(names);
    free(*rows_of(s, g));
  }
  free(s->lost);
  free(s->phase_name);
  free(s->observable);
  *s = (summary){0};
}

bool summary_is_column(const char *name, bool of_body) {
  static const observable_list *const of_points[] = {&fact_observables, &total_observables,
                                                     &until_observables, &energy_observables,
                                                     &outcome_observables};
  static const observable_list *const of_bodies[] = {
      &rotation_observables, &slide_observables, &configuration_observables, &average_observables};
  size_t n = of_body ? sizeof of_bodies / sizeof *of_bodies : sizeof of_points / sizeof *of_points;
  for (size_t l = 0; l < n; l++) {
    const observable_list *list = of_body ? of_bodies[l] : of_points[l];
    for (size_t k = 0; k < list->n; k++)
      if (list->rows[k].column && strcmp(list->rows[k].column, name) == 0) return true;
  }
  return false;
}

/* --- Writing and reading ---------------------------------------------------------------------- */

void summary_write(const summary *s, h5_file *file) {
  h5_group(file, "/summary/energy");
  members_write_attrs(file, "/summary", &fact_observables, s);
  members_write_attrs(file, "/summary", &outcome_observables, s);
  h5_attr_text(file, "/summary", "phase_name", s->phase_name);
  h5_attr_text(file, "/summary", "lost", s->lost);
  members_write_attrs(file, "/summary/energy", &energy_observables, &s->energy);
  for (const struct group *g = groups; g < groups + GROUPS; g++) {
    size_t n = *count_of(s, g);
    /* Averages came later than the other groups: results without them stay as they were. */
    if (n == 0 && g->list == &average_observables) continue;
    members_write(file, g->path, g->list, *rows_of(s, g), g->stride, n);
    members_write_lines(file, g->names_path, g->each * n, *names_of(s, g));
    h5_attr_i64(file, g->path, "count", (int64_t)n);
  }
  if (s->has_until) {
    h5_group(file, "/summary/until");
    h5_attr_text(file, "/summary/until", "observable", s->observable);
    members_write_attrs(file, "/summary/until", &until_observables, s);
  }
  summary_disks_write(&s->packing, file);
  summary_doubts_write(s, file);
}

/* Reads the lengths of the arrays of the summary and allocates them. Each length is first compared
 * with that of a dataset, since a damaged file may ask for more memory than there is. */
static sd_status read_counts(summary *s, const h5_file *file, sd_messages *messages) {
  for (const struct group *g = groups; g < groups + GROUPS; g++) {
    int64_t n = h5_exists(file, g->path) ? h5_get_attr_i64(file, g->path, "count", 0) : 0;
    if (n < 0 || (n > 0 && h5_check(file, g->first, (size_t)n, messages) != SD_OK))
      return sd_fail(messages, SD_ERROR_IO, "the summary is damaged");
    const memory_column rows[] = {{rows_of(s, g), (size_t)n, g->stride},
                                  {names_of(s, g), g->each * (size_t)n, sizeof(char *)}};
    if (!memory_rows(sizeof rows / sizeof *rows, rows))
      return sd_fail(messages, SD_ERROR_IO, "no memory for the summary");
    *count_of(s, g) = (size_t)n;
  }
  return SD_OK;
}

static sd_status read_until(summary *s, const h5_file *file, sd_messages *messages) {
  s->has_until = h5_exists(file, "/summary/until");
  s->until_step = -1;
  if (!s->has_until) return SD_OK;
  members_read_attrs(file, "/summary/until", &until_observables, s);
  s->goal.reached = s->goal.converged && s->goal.error <= s->goal.goal;
  s->observable = h5_get_attr_text(file, "/summary/until", "observable");
  return s->observable ? SD_OK : sd_fail(messages, SD_ERROR_IO, "the summary is damaged");
}

sd_status summary_read(summary *s, const h5_file *file, sd_messages *messages) {
  *s = (summary){0};
  if (!h5_exists(file, "/summary"))
    return sd_fail(messages, SD_ERROR_USER,
                   "this is not a result of slipdisk: there is no /summary in it");
  members_read_attrs(file, "/summary", &fact_observables, s);
  members_read_attrs(file, "/summary", &outcome_observables, s);
  members_read_attrs(file, "/summary/energy", &energy_observables, &s->energy);
  s->phase_name = h5_get_attr_text(file, "/summary", "phase_name");
  s->lost = h5_get_attr_text(file, "/summary", "lost");
  if (!s->phase_name) s->phase_name = memory_text("");
  if (!s->lost) s->lost = memory_text("");
  sd_status status = read_counts(s, file, messages);
  for (const struct group *g = groups; g < groups + GROUPS; g++) {
    size_t n = *count_of(s, g);
    if (status != SD_OK || n == 0) continue;
    status = members_read(file, g->path, g->list, *rows_of(s, g), g->stride, n, messages);
    if (status == SD_OK) members_read_lines(file, g->names_path, g->each * n, *names_of(s, g));
  }
  if (status == SD_OK) status = read_until(s, file, messages);
  if (status == SD_OK) status = summary_disks_read(&s->packing, file, messages);
  if (status == SD_OK) status = summary_doubts_read(s, file, messages);
  return status;
}

/* Recomputes the mean rotations from the bins in a file. */
static void renew_rotations(summary *s, const sd_model *model, const h5_file *file) {
  size_t n = s->n_rotations;
  sd_status status = SD_OK;
  double *bins = h5_column(file, "/state/rotation_bin", SD_F64, n * SD_BINS, &status, NULL),
         *zero = memory_new(n, sizeof *zero);
  sd_state state = {.measured = s->measured,
                    .n_rotations = n,
                    .rotation_bin = bins,
                    .rotation_start = zero,
                    .rotation_last = zero};
  bool there = bins && h5_get(file, "/state/bins", SD_I64, 1, &state.bins, NULL) == SD_OK &&
               h5_get(file, "/state/bin_steps", SD_I64, 1, &state.bin_steps, NULL) == SD_OK;
  for (size_t k = 0; there && state.bins <= SD_BINS && k < n; k++) {
    double turned = s->rotations[k].turned;
    s->rotations[k] = sd_rotation_of(model, &state, k);
    s->rotations[k].turned = turned;
  }
  free(bins);
  free(zero);
}

/* Recomputes the averages of the series from the bins in a file. */
static void renew_averages(summary *s, const sd_model *model, const h5_file *file) {
  const size_t n = s->n_averages;
  sd_status status = SD_OK;
  int64_t *rows = h5_column(file, "/state/average_rows", SD_I64, n, &status, NULL),
          *missing = h5_column(file, "/state/average_missing", SD_I64, n, &status, NULL);
  double *bins = h5_column(file, "/state/average_bin", SD_F64, 2 * n * SD_BINS, &status, NULL);
  const sd_state state = {.average_rows = rows, .average_missing = missing, .average_bin = bins};
  for (size_t k = 0; rows && missing && bins && k < n; k++)
    if (rows[k] >= 0) s->averages[k] = average_of(model, &state, k);
  free(rows);
  free(missing);
  free(bins);
}

void summary_renew(summary *s, const sd_model *model, const h5_file *file) {
  if (s->n_rotations > 0 && s->n_rotations == model->n_rotations) renew_rotations(s, model, file);
  if (s->n_averages > 0 && s->n_averages == model->n_averages) renew_averages(s, model, file);
}

/* --- Means of every disk ---------------------------------------------------------------------- */
static const char group[] = "/summary/disks", fastest_group[] = "/summary/fastest";

static sd_status no_memory(sd_messages *messages) {
  return sd_fail(messages, SD_ERROR_IO, "no memory for the means of disks");
}

/* Returns |Omega|, the magnitude of the mean angular velocity of a disk; -1 if it is not known. */
static double speed_of(const sd_disk_mean *d) { return isnan(d->omega) ? -1 : fabs(d->omega); }

/* Stores the SUMMARY_FASTEST disks of largest |Omega| (mean angular velocity) in s->fastest, in
 * descending order. */
static void find_fastest(summary_disks *s) {
  sd_disk_mean *list = s->fastest;
  size_t n = 0;
  for (size_t k = 0; k < s->n; k++) {
    const sd_disk_mean *d = &s->disks[k];
    if (!(speed_of(d) > 0) || (n == SUMMARY_FASTEST && speed_of(d) <= speed_of(&list[n - 1])))
      continue;
    size_t at = n < SUMMARY_FASTEST ? n++ : n - 1;
    for (; at > 0 && speed_of(&list[at - 1]) < speed_of(d); at--) list[at] = list[at - 1];
    list[at] = *d;
  }
  s->n_fastest = n;
}

/* Sorts the time averages of n disks by body number. place: [n_disks] work memory, all zero on
 * entry. */
static void sort_by_number(const sd_disk_mean *means, size_t n, size_t n_disks, uint32_t *place,
                           sd_disk_mean *sorted) {
  /* mark the disks that have time averages */
  for (size_t k = 0; k < n; k++) place[means[k].disk] = 1;
  uint32_t before = 0;
  for (size_t i = 0; i < n_disks; i++) {
    const uint32_t there = place[i];
    place[i] = before;
    before += there;
  }
  for (size_t k = 0; k < n; k++) sorted[place[means[k].disk]] = means[k];
}

typedef struct means_task {
  sd_disk_mean *means;
  size_t n;
  const sd_model *model;
  const sd_state *state;
} means_task;

/* Computes the time averages of this thread's range of disks. Disks are independent, so results do
 * not depend on the number of threads. */
static void means_together(const team *t, void *with) {
  const means_task *f = with;
  size_t begin, end;
  team_share(t, f->n, &begin, &end);
  for (size_t k = begin; k < end; k++) f->means[k] = sd_disk_mean_of(f->model, f->state, k);
}

void summary_disks_means(sd_disk_mean *means, size_t n, const sd_model *model,
                         const sd_state *state, int threads) {
  enum { FEW = 1024 }; /* number of disks below which one thread is faster */
  pool *c = threads > 1 && n > FEW ? pool_new(threads) : NULL;
  pool_run(c, means_together, &(means_task){means, n, model, state});
  pool_free(c);
}

void summary_disks_announce(summary_disks *s, const sd_model *model, const sd_state *state) {
  *s = (summary_disks){.n = model->measure_disks ? model->n_free : 0,
                       .looks = state->mean_samples,
                       .bins = state->mean_bins,
                       .measured = (double)state->measured * model->dt};
}

sd_status summary_disks_fill(summary_disks *s, const sd_model *model, const sd_state *state,
                             const sd_disk_mean *means, sd_messages *messages) {
  uint32_t *place;
  const memory_column rows[] = {{&s->disks, s->n, sizeof *s->disks},
                                {&place, model->n_disks, sizeof *place}};
  if (!memory_rows(sizeof rows / sizeof *rows, rows)) return no_memory(messages);
  s->totals = sd_disk_totals_of(model, state, means);
  sort_by_number(means, s->n, model->n_disks, place, s->disks);
  free(place);
  if (shortage_seen()) return no_memory(messages);
  find_fastest(s);
  return SD_OK;
}

sd_status summary_disks_collect(summary_disks *s, const sd_model *model, const sd_state *state,
                                int threads, sd_messages *messages) {
  summary_disks_announce(s, model, state);
  if (s->n == 0) return SD_OK;
  sd_disk_mean *means;
  if (!memory_row(&means, s->n, sizeof *means)) return no_memory(messages);
  summary_disks_means(means, s->n, model, state, threads);
  const sd_status status = summary_disks_fill(s, model, state, means, messages);
  free(means);
  return status;
}

void summary_disks_free(summary_disks *s) {
  free(s->disks);
  *s = (summary_disks){0};
}

void summary_disks_write(const summary_disks *s, h5_file *file) {
  if (s->n == 0) return;
  h5_group(file, group);
  h5_attr_i64(file, group, "count", (int64_t)s->n);
  h5_attr_i64(file, group, "looks", s->looks);
  h5_attr_i64(file, group, "bins", s->bins);
  h5_attr_f64(file, group, "measured", s->measured);
  if (!s->disks) return;
  members_write(file, group, &disk_observables, s->disks, sizeof *s->disks, s->n);
  members_write(file, fastest_group, &disk_observables, s->fastest, sizeof *s->fastest,
                s->n_fastest);
  members_write_attrs(file, group, &total_observables, &s->totals);
}

sd_status summary_disks_read(summary_disks *s, const h5_file *file, sd_messages *messages) {
  *s = (summary_disks){0};
  if (!h5_exists(file, group)) return SD_OK;
  int64_t count = h5_get_attr_i64(file, group, "count", 0);
  if (count < 0 || count > UINT32_MAX)
    return sd_fail(messages, SD_ERROR_IO, "the summary is damaged");
  s->n = (size_t)count;
  s->looks = h5_get_attr_i64(file, group, "looks", 0);
  s->bins = h5_get_attr_i64(file, group, "bins", 0);
  s->measured = h5_get_attr_f64(file, group, "measured", NAN);
  s->later = !h5_exists(file, "/summary/disks/id");
  if (s->later) return SD_OK;
  members_read_attrs(file, group, &total_observables, &s->totals);
  /* Older files have no list of the fastest disks, so these are searched among all disks. */
  if (!h5_exists(file, fastest_group)) {
    sd_status status = summary_disks_read_all(s, file, messages);
    if (status == SD_OK) find_fastest(s);
    return status;
  }
  int rank;
  size_t dims[H5_MAX_RANK] = {0};
  sd_status status = h5_shape(file, "/summary/fastest/id", &rank, dims, messages);
  if (status == SD_OK && dims[0] > SUMMARY_FASTEST)
    status = sd_fail(messages, SD_ERROR_IO, "the summary is damaged");
  s->n_fastest = status == SD_OK ? dims[0] : 0;
  if (status != SD_OK) return status;
  return members_read(file, fastest_group, &disk_observables, s->fastest, sizeof *s->fastest,
                      s->n_fastest, messages);
}

sd_status summary_disks_read_all(summary_disks *s, const h5_file *file, sd_messages *messages) {
  if (s->n == 0 || s->disks || s->later) return SD_OK;
  sd_status status = h5_check(file, "/summary/disks/id", s->n, messages);
  if (status != SD_OK) return status;
  if (!memory_row(&s->disks, s->n, sizeof *s->disks)) return no_memory(messages);
  return members_read(file, group, &disk_observables, s->disks, sizeof *s->disks, s->n, messages);
}
