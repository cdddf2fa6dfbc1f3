/* configurations.c: torque, normal forces and visits in each sliding configuration of a watched
 * pair of contacts. */
#include <math.h>

#include "measure/observable.h"
#include "model/model.h"
#include "model/visits.h"

/* Returns the steps in a class, a sum over counts of the 4 x 4 states of two contacts. */
static int64_t steps_in(const int64_t *count, int class) {
  int64_t steps = 0;
  for (int first = 0; first < 4; first++)
    for (int second = 0; second < 4; second++)
      if (visits_class(first, second) == class) steps += count[4 * first + second];
  return steps;
}

/* Return mean and standard deviation of n values from their sum and sum of squares; NAN for n =
 * 0. */
static double mean_from(double sum, int64_t n) { return n > 0 ? sum / (double)n : NAN; }
static double deviation_from(double sum, double squares, int64_t n) {
  double mean = mean_from(sum, n);
  return n > 0 ? sqrt(fmax(0, squares / (double)n - mean * mean)) : NAN;
}

/* Fills steps and mean torque by age of the visit. now: the current visit is in configuration k, so
 * its unfinished part is added. */
static void add_ages(sd_configuration *c, const sd_state *s, size_t k, bool now) {
  const size_t watch = k / VISIT_CLASSES;
  const int64_t since = s->visit_since[watch], from = s->visit_from[watch];
  for (int b = 0; b < VISIT_AGES; b++) {
    const size_t at = VISIT_AGES * k + (size_t)b;
    const bool here = now && since >= 0 && visits_octave(from - since) == b;
    c->age_steps[b] = s->visit_age_steps[at] + (here ? s->measured - from : 0);
    c->age_torque[b] = mean_from(s->visit_age_torque[at] +
                                     (here ? s->visit_part[VISIT_SUMS * watch + VISIT_TORQUE] : 0),
                                 c->age_steps[b]);
  }
}

sd_configuration sd_configuration_of(const sd_model *model, const sd_state *s, size_t k) {
  const size_t watch = k / VISIT_CLASSES;
  sd_configuration c = {.disk = UINT32_MAX, .configuration = (int32_t)(k % VISIT_CLASSES)};
  const bool known = watch < s->n_visits;
  if (known) {
    c.disk = model->slides[watch].disk;
    c.steps = steps_in(s->slide_count + 16 * watch, c.configuration);
    c.visits = s->visit_count[k];
  }
  double sum[VISIT_SUMS] = {0};
  /* A pair is in no configuration until measuring begins. */
  const bool now = known && s->measured > 0 && s->visit_class[watch] == c.configuration;
  for (size_t q = 0; known && q < VISIT_SUMS; q++)
    sum[q] = s->visit_sum[VISIT_SUMS * k + q] + (now ? s->visit_part[VISIT_SUMS * watch + q] : 0);
  c.torque = mean_from(sum[VISIT_TORQUE], c.steps);
  c.torque_sd = deviation_from(sum[VISIT_TORQUE], sum[VISIT_TORQUE2], c.steps);
  for (size_t side = 0; side < 2; side++) {
    c.force[side] = (known ? s->visit_reference[2 * watch + side] : 0) +
                    mean_from(sum[VISIT_FORCE + 2 * side], c.steps);
    c.force_sd[side] =
        deviation_from(sum[VISIT_FORCE + 2 * side], sum[VISIT_FORCE2 + 2 * side], c.steps);
  }
  c.dwell = known ? model->dt * mean_from((double)s->visit_steps[k], c.visits) : NAN;
  c.dwell_sd =
      known ? model->dt * deviation_from((double)s->visit_steps[k], s->visit_steps2[k], c.visits)
            : NAN;
  if (known) add_ages(&c, s, k, now);
  for (int b = 0; !known && b < VISIT_AGES; b++) c.age_torque[b] = NAN;
  return c;
}

#define ROW(field, type, unit, meaning, column, json)                                              \
  {                                                                                                \
#field, unit, meaning, OBSERVABLE_##type, 1, offsetof(sd_configuration, field), NULL, column,  \
        json, NULL                                                                                 \
  }
#define CONTACT(field, unit, meaning)                                                              \
  {                                                                                                \
#field, unit, meaning, OBSERVABLE_F64, 2, offsetof(sd_configuration, field), NULL, #field,     \
        NULL, NULL                                                                                 \
  }
#define AGE(field, type, unit, meaning)                                                            \
  {                                                                                                \
#field, unit, meaning, OBSERVABLE_##type, SD_AGES, offsetof(sd_configuration, field), NULL,    \
        NULL, NULL, NULL                                                                           \
  }

static const observable rows[] = {
    ROW(disk, U32, "1", "body number", NULL, ""),
    ROW(configuration, I32, "1", "S++ 0, S+- 1, S-+ 2, S-- 3, stick 4, open 5", NULL, ""),
    ROW(steps, I64, "1", "measured steps in it", NULL, NULL),
    ROW(torque, F64, "force length", "mean torque of the two contacts on the disk", "torque", NULL),
    ROW(torque_sd, F64, "force length", "its standard deviation, over steps", "torque_sd", NULL),
    CONTACT(force, "force", "mean normal force"),
    CONTACT(force_sd, "force", "its standard deviation, over steps"),
    ROW(visits, I64, "1", "visits that began and ended while measured", "visits", NULL),
    ROW(dwell, F64, "time", "mean duration of these visits", "dwell", NULL),
    ROW(dwell_sd, F64, "time", "its standard deviation, over visits", "dwell_sd", NULL),
    AGE(age_torque, F64, "force length",
        "mean torque by age of the visit: below 32 steps, then octaves"),
    AGE(age_steps, I64, "1", "measured steps by age of the visit"),
};
const observable_list configuration_observables = OBSERVABLES(
    "configuration",
    "of each watched pair of contacts in each sliding configuration (`measure.configurations`), in "
    "/summary/configuration",
    rows);
