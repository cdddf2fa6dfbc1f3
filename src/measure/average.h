/* average.h: means with error bars of columns of the series, of sums of them and of ratios of such
 * sums, which the key "measure.averages" of a deck names.
 *
 * Rows of the series in measured phases are added up in bins, those of numerator and denominator
 * apart. A ratio is the mean of the numerator over the mean of the denominator. Its error is that
 * of the mean of a_k/B - R b_k/B, with a_k, b_k numerator and denominator of row k, R the ratio, B
 * the mean of b_k: the first order in the deviations of both, with their covariance and with
 * correlations in time (delta method). */
#ifndef SLIPDISK_MEASURE_AVERAGE_H
#define SLIPDISK_MEASURE_AVERAGE_H

#include "measure/observable.h"

/* Mean of the measured rows of the series. A transient at their beginning is left out. */
typedef struct sd_average {
  double mean, error;         /* mean and one standard error of it, in the unit of the expression */
  double correlation;         /* integrated correlation time, time */
  double transient, measured; /* measured time discarded as transient; total measured time */
  int64_t rows;               /* number of measured rows */
  int64_t missing;            /* number of these in which a value was not finite */
  bool converged;             /* true: the error bar can be trusted (docs/physics.md 9) */
} sd_average;

extern const observable_list average_observables; /* quantities of an sd_average */

/* Returns average k of the model from the bins in a state. If a row had a value that is not finite,
 * or there is no row, mean and error are NAN. */
sd_average average_of(const sd_model *model, const sd_state *state, size_t k);
/* Adds a row of the series to all averages. now: the moment of the row. measured: true if the row
 * ends an interval of a measured phase; false: the row only begins one, for rate(). */
void average_sample(sd_state *state, const moment *now, bool measured);
/* Returns the number of steps between rows of the series in measured phases; 0: there are none. */
int64_t average_interval(const sd_model *model);
/* Returns the column of the series with this number; NULL: there is none. Energies come first. */
const observable *average_column(size_t number);
/* Returns the unit of average k; the caller frees it. */
char *average_unit(const sd_model *model, size_t k);

#endif
