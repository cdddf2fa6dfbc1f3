/* summary_doubts.c: compares a summary with the limits of its deck and writes the texts of the
 * warnings, called doubts; see summary.h. */
#include <float.h>
#include <inttypes.h>
#include <math.h>
#include <stdlib.h>

#include "base/math.h"
#include "base/memory.h"
#include "base/text.h"
#include "io/results/summary.h"
#include "model/advice.h"
#include "model/motions.h"
#include "model/normal_laws.h"
#include "model/overlaps.h"

const struct doubt_row doubt_kinds[DOUBT_KINDS] = {
    [DOUBT_RESIDUAL] = {"residual", "residual of the energy budget over its scale",
                        "whose energy budget does not close: a smaller dt is needed"},
    [DOUBT_OPEN] = {"open", "fraction of the measured time in which a watched contact was open",
                    "whose watched contacts were open nearly all the time"},
    [DOUBT_DISPLACEMENT] =
        {"displacement",
         "displacement in one step over the radius: of a free disk over its own, "
         "of a prescribed body over that of the smallest free disk",
         "in which a disk or a wall moves too far in a step"},
    [DOUBT_FINITE] = {"finite", "a number of the result is not finite",
                      "with numbers that are not finite"},
    [DOUBT_UNSTABLE] = {"unstable", "dt over the limit of stability",
                        "whose dt is beyond the limit of stability: results mean nothing"},
    [DOUBT_BONDS] = {"bonds", "bonds that broke in one step over all",
                     "whose bonds all broke in one step"},
};

/* Gap between two bodies, divided by the radius, below which they count as touching. */
static const double TOUCHING = 1e-6;

/* --- Comparison with the limits --------------------------------------------------------------- */

/* Stores a warning (doubt) in the summary, which then owns `text`. */
static void doubt(summary *s, doubt_kind kind, double value, double limit, char *text) {
  s->doubts[kind] = (summary_doubt){text, value, limit};
}

double summary_farthest(const sd_state *state) {
  double farthest = 0;
  for (size_t i = 0; i < state->n_disks; i++)
    farthest = math_max(farthest, fabs(state->x[i]) + fabs(state->y[i]) + state->radius[i]);
  return farthest;
}

/* Estimates the error of the elastic energy due to rounding of positions: largest stiffness
 * times the sum of overlaps times the rounding error of the largest position. */
static double rounding(const sd_model *model, const summary_sums *sums) {
  double stiffest = 0;
  for (size_t k = 0; k < model->n_materials * model->n_materials; k++)
    stiffest = math_max(stiffest, law_typical_stiffness(&model->laws[k], model->largest_radius));
  return 4 * DBL_EPSILON * stiffest * sums->farthest * exact_sum_value(&sums->overlap);
}

static void judge_residual(summary *s, double limit, double floor, const sd_model *model) {
  const sd_energy *e = &s->energy;
  /* A residual of the energy budget that is NAN is reported, too. */
  if (!(limit > 0) || fabs(e->residual) <= math_max(limit * e->scale, floor)) return;
  double part = fabs(e->residual) / e->scale;
  char *first = model ? advice_first_jump(model) : NULL;
  doubt(s, DOUBT_RESIDUAL, part, limit,
        format_text("the energy budget does not close: %s (residual %.2g of its scale, "
                    "limits.residual is %g)",
                    first ? first : "a smaller dt is needed", part, limit));
  free(first);
}

/* Returns the present gap between the surfaces of a disk and of the other body of a contact; NAN:
 * not known. */
static double gap_now(const sd_model *model, const sd_state *state, uint32_t disk,
                      uint32_t partner) {
  double pose[3] = {NAN, NAN, NAN}, x[2] = {NAN, NAN};
  for (size_t i = 0; i < state->n_bodies && state->box_scale == 1.0; i++) {
    if (state->id[i] == disk) {
      x[0] = state->x[i];
      x[1] = state->y[i];
    }
    if (state->id[i] == partner) {
      pose[0] = state->x[i];
      pose[1] = state->y[i];
      pose[2] = state->theta[i] + state->turn[i];
    }
  }
  return overlaps_gap(model, disk, x, partner, pose);
}

/* Explains why a watched contact was open, such as ": it opened 3 times, 0.2 radii apart at the
 * end"; "" without a state. The caller frees the text. one: 0 or 1, the first or the second watched
 * contact of the disk. */
static char *why_open(const sd_slide *w, size_t one, const sd_model *model, const sd_state *state) {
  if (!model || !state) return memory_text("");
  double radius = model->disks[w->disk].radius,
         first = overlaps_first_gap(model, w->disk, w->partner[one]) / radius,
         last = gap_now(model, state, w->disk, w->partner[one]) / radius;
  char *text;
  if (w->openings[one] == 1)
    text = format_text(": it opened once");
  else if (w->openings[one] > 0)
    text = format_text(": it opened %" PRId64 " times", w->openings[one]);
  else if (w->contact_open[one] < 1)
    text = format_text(": it closed late");
  else if (first > TOUCHING && !model->disks[w->disk].waiting)
    text = format_text(": it never closed, %.3g radii apart at the start", first);
  else
    text = format_text(": it had opened before measuring began, and never closed");
  if (last > TOUCHING) text = append_text(text, ", %.3g radii apart at the end", last);
  return text;
}

/* Warns about the first disk whose watched contacts were open too long: about one of the two
 * contacts if only that one exceeds the limit, else about both together. */
static void judge_open(summary *s, double limit, const sd_model *model, const sd_state *state) {
  size_t k = 0;
  while (k < s->n_slides && !(s->slides[k].open > limit)) k++;
  if (!(limit > 0) || k == s->n_slides) return;
  const sd_slide *w = &s->slides[k];
  char *const *names = &s->slide_names[3 * k];
  bool first = w->contact_open[0] > limit, second = w->contact_open[1] > limit,
       both = first == second;
  size_t one = first ? 0 : 1;
  char *why[2] = {why_open(w, both ? 0 : one, model, state),
                  both ? why_open(w, 1, model, state) : NULL},
       *text;
  if (!both)
    text = format_text("the watched contact of %s with %s was open %.3g %% of the time%s", names[0],
                       names[1 + one], 100 * w->contact_open[one], why[0]);
  else if (*why[0])
    text = format_text(
        "the watched contacts of %s were open %.3g %% of the time (with %s%s, and with %s%s)",
        names[0], 100 * w->open, names[1], why[0], names[2], why[1]);
  else
    text = format_text("the watched contacts of %s were open %.3g %% of the time", names[0],
                       100 * w->open);
  doubt(s, DOUBT_OPEN, both ? w->open : w->contact_open[one], limit, text);
  free(why[0]);
  free(why[1]);
}

/* Writes the text of the warning about a prescribed body that moved too far in a step. For a sudden
 * jump the limit is STRIDES_JUMP (a tenth) of the usual one; see physics/step/step.h. */
static char *why_far(const sd_model *model, const sd_state *state, const char *name, double limit) {
  char *first = advice_first_jump(model), *text;
  if (state->fast_displacement > limit)
    text = format_text("%s moves by %.3g radii of the smallest disk in a step, after step %" PRId64
                       ", and may have passed through disks: %s (limits.displacement is %g)",
                       name, state->fast_displacement, state->fast_step,
                       first ? first : "a slower motion or a smaller dt is needed", limit);
  else
    text = format_text("%s jumps by %.3g radii of the smallest disk in a step, after step %" PRId64
                       ", and disks there are thrown: %s (limits.displacement is %g)",
                       name, state->fast_displacement, state->fast_step,
                       first ? first : "spread its motion over more time", limit);
  free(first);
  return text;
}

static void judge_displacement(summary *s, double limit, const sd_model *model,
                               const sd_state *state) {
  if (!(limit > 0) || state->fast_step < 0) return;
  char name[96];
  const uint32_t body = (uint32_t)state->fast_disk;
  sd_model_body_name(model, body, name, sizeof name);
  if (body >= model->n_disks || model->disks[body].driven)
    doubt(s, DOUBT_DISPLACEMENT, state->fast_displacement,
          state->fast_displacement > limit ? limit : STRIDES_JUMP * limit,
          why_far(model, state, name, limit));
  else
    doubt(s, DOUBT_DISPLACEMENT, state->fast_displacement, limit,
          format_text("%s moves by %.3g of its radius in a step, after step %" PRId64
                      ", and disks may have passed through others: a smaller dt is needed "
                      "(limits.displacement is %g)",
                      name, state->fast_displacement, state->fast_step, limit));
}

static const char *const finite_columns[] = {"vx", "vy", "omega", "force_x", "force_y", "torque"};
enum { FINITE_COLUMNS = sizeof finite_columns / sizeof *finite_columns };

unsigned summary_not_finite(const sd_state *state) {
  const double *const columns[FINITE_COLUMNS] = {state->vx,      state->vy,      state->omega,
                                                 state->force_x, state->force_y, state->torque};
  unsigned found = 0;
  for (unsigned c = 0; c < FINITE_COLUMNS; c++)
    for (size_t i = 0; i < state->n_bodies; i++)
      if (!isfinite(columns[c][i])) found |= 1u << c;
  return found;
}

/* Returns the name of the first quantity that is not finite; NULL: all are finite. Omega is
 * expected to be finite once the first time bin is full. columns: bits of the columns in which
 * summary_not_finite has found such a number. */
static const char *not_finite(const summary *s, const sd_state *state, unsigned columns) {
  for (unsigned c = 0; c < FINITE_COLUMNS; c++)
    if (columns >> c & 1) return finite_columns[c];
  for (const observable *o = energy_observables.rows;
       o < energy_observables.rows + energy_observables.n; o++)
    if (!isfinite(observable_value(o, &s->energy, 0))) return o->name;
  for (size_t k = 0; k < s->n_rotations; k++)
    if (state->bins > 0 && !isfinite(s->rotations[k].omega)) return "Omega";
  for (size_t k = 0; k < 2 * s->n_slides; k++)
    if (isnan(s->slides[k / 2].force_min[k % 2])) return "force_min";
  return NULL;
}

static void judge_finite(summary *s, const sd_state *state, unsigned columns) {
  const char *name = not_finite(s, state, columns);
  if (name)
    doubt(s, DOUBT_FINITE, NAN, NAN,
          format_text("a number is not finite (%s): a smaller dt is needed", name));
  for (size_t k = 0; k < s->n_averages && !name; k++) {
    const sd_average *a = &s->averages[k];
    if (a->rows == 0 || isfinite(a->mean)) continue;
    name = s->average_names[3 * k];
    doubt(s, DOUBT_FINITE, NAN, NAN,
          a->missing > 0 ? format_text("the average %s has no value: in %" PRId64 " of %" PRId64
                                       " rows %s is not finite",
                                       name, a->missing, a->rows, s->average_names[3 * k + 1])
                         : format_text("the average %s has no value: the mean of the denominator "
                                       "of %s is 0",
                                       name, s->average_names[3 * k + 1]));
  }
}

/* Warns about a time step dt beyond the limit of stability. A model can have such a dt only if its
 * deck allows it (limits.unstable_step). */
static void judge_unstable(summary *s, const sd_model *model) {
  /* Unless the deck sets unstable_step, such a dt is refused before the run. */
  if (!model || !model->limits.unstable_step) return;
  const double limit = sd_model_step_limit(model).dt;
  if (model->dt > limit)
    doubt(s, DOUBT_UNSTABLE, model->dt / limit, 1,
          format_text(
              "dt = %g is beyond the limit of stability %.3g: results mean nothing: a smaller dt "
              "is needed",
              model->dt, limit));
}

/* Warns if there were bonds and all of them broke in the same step. */
static void judge_bonds(summary *s, const sd_state *state, int64_t bonds) {
  const size_t n = state->n_breaks;
  if (n < 2 || bonds > 0 || state->break_step[0] != state->break_step[n - 1]) return;
  doubt(s, DOUBT_BONDS, 1, 1,
        format_text("all %zu bonds broke in step %" PRId64
                    ": they are weaker than the forces there, or too stiff for dt",
                    n, state->break_step[0]));
}

void summary_judge(summary *s, const sd_limits *limits, const sd_model *model,
                   const sd_state *state, const summary_sums *sums) {
  judge_residual(s, limits->residual, sums ? rounding(model, sums) : 0, model);
  judge_open(s, limits->open, model, state);
  judge_unstable(s, model);
  if (!state || !sums) return;
  judge_displacement(s, limits->displacement, model, state);
  judge_finite(s, state, sums->not_finite);
  judge_bonds(s, state, sums->bonds);
}

size_t summary_doubts(const summary *s) {
  size_t n = 0;
  for (size_t k = 0; k < DOUBT_KINDS; k++) n += s->doubts[k].text != NULL;
  return n;
}

char *summary_doubts_text(const summary *s) {
  char *all = memory_text("");
  for (size_t k = 0; k < DOUBT_KINDS; k++)
    if (s->doubts[k].text) all = append_text(all, "%s%s", *all ? "; " : "", s->doubts[k].text);
  return all;
}

void summary_doubts_free(summary *s) {
  for (size_t k = 0; k < DOUBT_KINDS; k++) free(s->doubts[k].text);
}

/* --- Writing and reading ---------------------------------------------------------------------- */

static char *group_of(size_t kind) {
  return format_text("/summary/doubts/%s", doubt_kinds[kind].name);
}

void summary_doubts_write(const summary *s, h5_file *file) {
  h5_group(file, "/summary/doubts");
  h5_attr_i64(file, "/summary/doubts", "count", (int64_t)summary_doubts(s));
  for (size_t k = 0; k < DOUBT_KINDS; k++) {
    if (!s->doubts[k].text) continue;
    char *group = group_of(k);
    h5_group(file, group);
    h5_attr_text(file, group, "message", s->doubts[k].text);
    h5_attr_f64(file, group, "value", s->doubts[k].value);
    h5_attr_f64(file, group, "limit", s->doubts[k].limit);
    h5_attr_text(file, group, "unit", "1");
    h5_attr_text(file, group, "description", doubt_kinds[k].meaning);
    free(group);
  }
}

sd_status summary_doubts_read(summary *s, const h5_file *file, sd_messages *messages) {
  /* limits of those versions that did not store the warnings */
  const sd_limits before = {.residual = 0.01, .open = 0.99};
  int64_t n = h5_exists(file, "/summary/doubts")
                  ? h5_get_attr_i64(file, "/summary/doubts", "count", -1)
                  : -2;
  if (n == -2) {
    summary_judge(s, &before, NULL, NULL, NULL);
    return SD_OK;
  }
  for (size_t k = 0; k < DOUBT_KINDS; k++) {
    char *group = group_of(k);
    if (h5_exists(file, group))
      s->doubts[k] = (summary_doubt){h5_get_attr_text(file, group, "message"),
                                     h5_get_attr_f64(file, group, "value", NAN),
                                     h5_get_attr_f64(file, group, "limit", NAN)};
    free(group);
  }
  return n == (int64_t)summary_doubts(s) ? SD_OK
                                         : sd_fail(messages, SD_ERROR_IO, "the summary is damaged");
}
