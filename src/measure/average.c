/* average.c: see average.h. */
#include "measure/average.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/text.h"
#include "measure/error_bar.h"
#include "model/model.h"

const observable *average_column(size_t number) {
  const size_t energies = energy_observables.n;
  if (number < energies) return &energy_observables.rows[number];
  number -= energies;
  return number < series_observables.n ? &series_observables.rows[number] : NULL;
}

int64_t average_interval(const sd_model *model) {
  for (size_t k = 0; k < model->n_phases; k++)
    if (model->phases[k].measure) return model->phases[k].series_every;
  return 0;
}

/* --- rows ------------------------------------------------------------------------------------- */

/* Returns the value of a column at this moment. */
static double value_of(const sd_average_term *t, const moment *now) {
  const observable *o = average_column(t->column);
  if (t->column < energy_observables.n) return observable_value(o, now->energy, 0);
  const resultant *sums = series_resultants(o, now);
  return sums ? observable_value(o, &sums[t->element], 0) : observable_value(o, now, t->element);
}

/* Returns the sum of a row: of values, and of changes per time since the last row. *last: the sum
 * of the columns in rate() in the last row, which becomes that of this row. span: time between
 * rows. */
static double sum_of(const sd_average_sum *s, const moment *now, double span, double *last) {
  double values = s->constant, rates = 0;
  for (size_t k = 0; k < s->n; k++)
    *(s->term[k].rate ? &rates : &values) += s->term[k].factor * value_of(&s->term[k], now);
  const double change = rates - *last;
  *last = rates;
  return values + change / span;
}

/* Returns the number of rows per bin: the smallest power of two for which `rows` rows do not fill
 * the record. */
static int64_t rows_per_bin(int64_t rows) {
  int64_t each = 1;
  while (rows / each >= SD_BINS) each *= 2;
  return each;
}

static void halve(double *bin) {
  for (size_t b = 0; b < SD_BINS / 2; b++) bin[b] = bin[2 * b] + bin[2 * b + 1];
  memset(bin + SD_BINS / 2, 0, SD_BINS / 2 * sizeof *bin);
}

void average_sample(sd_state *state, const moment *now, bool measured) {
  const double span = (double)average_interval(now->model) * now->model->dt;
  for (size_t k = 0; k < state->n_averages; k++) {
    double x[2], *bin = state->average_bin + 2 * k * SD_BINS;
    int64_t *rows = &state->average_rows[k];
    for (size_t side = 0; side < 2; side++)
      x[side] =
          sum_of(&now->model->averages[k].of[side], now, span, &state->average_last[2 * k + side]);
    if (!measured) continue;
    if (!isfinite(x[0]) || !isfinite(x[1])) {
      state->average_missing[k]++;
      continue;
    }
    const int64_t each = rows_per_bin(*rows);
    for (size_t side = 0; side < 2; side++) bin[side * SD_BINS + (size_t)(*rows / each)] += x[side];
    if (++*rows == SD_BINS * each)
      for (size_t side = 0; side < 2; side++) halve(bin + side * SD_BINS);
  }
}

/* --- means ------------------------------------------------------------------------------------ */

sd_average average_of(const sd_model *model, const sd_state *state, size_t k) {
  const int64_t rows = state->average_rows[k], missing = state->average_missing[k],
                each = rows_per_bin(rows);
  const size_t bins = (size_t)(rows / each);
  const double step = (double)average_interval(model) * model->dt, bin = (double)each * step,
               period = mean_period(model) / bin;
  sd_average a = {.mean = NAN,
                  .error = NAN,
                  .correlation = NAN,
                  .measured = (double)(rows + missing) * step,
                  .rows = rows + missing,
                  .missing = missing};
  if (bins == 0 || missing > 0) return a;
  const double *over = state->average_bin + 2 * k * SD_BINS;
  /* A ripple with a period shorter than a bin only adds noise: ignore it. */
  const sd_mean mean = mean_of_ratio(over, over + SD_BINS, bins, period >= 1 ? period : 0);
  a.mean = mean.mean;
  a.error = mean.error;
  a.correlation = mean.correlation * bin;
  a.transient = (double)mean.discarded * bin;
  a.converged = mean.converged;
  return a;
}

/* Returns the unit that all columns of a sum have, the sums of different units as "mixed"; the
 * caller frees it. */
static char *unit_of_sum(const sd_average_sum *s) {
  char *unit = NULL;
  for (size_t k = 0; k < s->n; k++) {
    const char *own = average_column(s->term[k].column)->unit;
    char *one = !s->term[k].rate        ? format_text("%s", own)
                : strcmp(own, "1") == 0 ? format_text("1/time")
                                        : format_text("%s/time", own);
    const bool same = !unit || strcmp(unit, one) == 0;
    free(unit);
    unit = same ? one : format_text("mixed");
    if (!same) free(one);
  }
  return unit ? unit : format_text("1");
}

char *average_unit(const sd_model *model, size_t k) {
  char *over = unit_of_sum(&model->averages[k].of[0]),
       *under = unit_of_sum(&model->averages[k].of[1]), *unit = over;
  if (strcmp(under, "1") != 0) {
    unit = strcmp(over, under) == 0 ? format_text("1") : format_text("%s/(%s)", over, under);
    free(over);
  }
  free(under);
  return unit;
}

#define AVERAGE(field, type, unit, meaning, column)                                                \
  OBSERVABLE_FIELD(#field, unit, meaning, type, sd_average, field, column, NULL)

static const observable rows[] = {
    AVERAGE(mean, F64, "of the expression", "mean of the measured rows of the series", "mean"),
    AVERAGE(error, F64, "of the expression", "one standard error of mean, correlations included",
            "mean_error"),
    AVERAGE(correlation, F64, "time", "integrated correlation time", "correlation"),
    AVERAGE(transient, F64, "time", "measured time discarded as transient", "transient"),
    AVERAGE(measured, F64, "time", "measured time, with the transient", "measured"),
    AVERAGE(rows, I64, "1", "measured rows of the series", NULL),
    AVERAGE(missing, I64, "1", "of these, rows with a number that is not finite: no mean", NULL),
    AVERAGE(converged, FLAG, "1", "1: the error bar is reliable", "converged"),
};
const observable_list average_observables = OBSERVABLES(
    "average", "of each of `measure.averages`, in /summary/average, with name, expression and unit",
    rows);
