/* error_bar.h: the steps of sd_mean_of, which computes the mean of a correlated record and its
 * error bar; declared here so that each can be tested. */
#ifndef SLIPDISK_MEASURE_ERROR_BAR_H
#define SLIPDISK_MEASURE_ERROR_BAR_H

#include <stdbool.h>
#include <stddef.h>

#include "slipdisk/measure.h"

typedef struct error_bar {
  double error;       /* standard error of the mean; NAN if it is not known */
  double correlation; /* integrated correlation time, in samples */
  bool reliable;      /* true if the record is long enough for this error to be trusted */
  /* true if the record is too short for its slow components, one of which may be a drift */
  bool slow;
} error_bar;

/* Returns the standard error of the mean of x[0..n), which is assumed to be stationary. */
error_bar error_bar_of(const double *x, size_t n);

/* Limits of drift.sigmas, the significance of a drift: above DRIFT_SEEN the drift is cut off or
 * enters the error bar, above DRIFT_CERTAIN the mean does not count as converged. */
enum { DRIFT_SEEN = 2, DRIFT_CERTAIN = 3 };

/* Drift that remains in a record of samples. */
typedef struct drift {
  /* difference between the means of the first quarter and of the rest, divided by its standard
   * error */
  double sigmas;
  /* half the difference between the means of the two halves of the record: the bias left by a short
   * relaxation */
  double half;
  /* (q3 - q4)/(q1 - q2), with q1 ... q4 the means of the four quarters of the record; 0 if
   * negative */
  double ratio;
} drift;

/* Returns the drift of x[0..n). error: standard error of its mean. */
drift drift_of(const double *x, size_t n, double error);

typedef struct transient {
  size_t length; /* number of samples to discard at the start of the record */
  /* bias that the transient is likely to leave in the mean of the rest of the record */
  double tail;
  bool inside; /* true if the transient ends within the first half of the record */
  /* true if the naive error (for independent samples) of the rest is at most a hundredth of that of
   * the whole record */
  bool quiet;
  error_bar rest; /* standard error of the mean of the rest of the record */
  drift left;     /* drift that is left in the rest of the record */
} transient;

transient transient_of(const double *x, size_t n);
/* Returns a transient of length 0, with the error and drift of the whole record. */
transient transient_none(const double *x, size_t n);

/* --- test whether a record resolves its slowest components ------------------------------------ */

typedef enum slow {
  SLOW_RESOLVED, /* the record determines its own spectral density at frequency zero */
  /* the record does not determine the density at frequency zero: the extrapolated one is more
   * likely too large */
  SLOW_DIP,
  /* the record does not determine the density at frequency zero: the extrapolated one may miss slow
   * components */
  SLOW_PARTS
} slow;

/* Classifies a record by its block means y[0..n). spectrum: its extrapolated spectral density at
 * frequency zero, in units in which the density of white noise is its variance. */
slow slow_of(const double *y, size_t n, double spectrum);
/* Returns true if frequencies up to 16 periods per record (SLOWEST) hold less than half of the
 * variance of y[0..n). */
bool slow_repeats(const double *y, size_t n);

/* --- means and variances of records ----------------------------------------------------------- */

/* Number of partial sums in means and variances, which are written so that compilers vectorise
 * them. The number is the same on every processor, so the results do not depend on the vector
 * width. The summands are differences from the first value, so that a constant record has exactly
 * its value as mean. */

enum { SUMS = 8 };

static inline double sums_all(const double sum[SUMS]) {
  return ((sum[0] + sum[4]) + (sum[2] + sum[6])) + ((sum[1] + sum[5]) + (sum[3] + sum[7]));
}

/* Returns the mean of x[0..n), n >= 1. */
static inline double sums_mean(const double *x, size_t n) {
  double sum[SUMS] = {0};
  const double first = x[0];
  size_t whole = n / SUMS * SUMS;
  for (size_t t = 0; t < whole; t += SUMS)
    for (size_t k = 0; k < SUMS; k++) sum[k] += x[t + k] - first;
  for (size_t t = whole; t < n; t++) sum[t - whole] += x[t] - first;
  return first + sums_all(sum) / (double)n;
}

/* Returns the variance of x[0..n) about its mean, divided by n - 1. */
static inline double sums_variance(const double *x, size_t n) {
  double sum[SUMS] = {0};
  const double mean = sums_mean(x, n);
  size_t whole = n / SUMS * SUMS;
  for (size_t t = 0; t < whole; t += SUMS)
    for (size_t k = 0; k < SUMS; k++) sum[k] += (x[t + k] - mean) * (x[t + k] - mean);
  for (size_t t = whole; t < n; t++) sum[t - whole] += (x[t] - mean) * (x[t] - mean);
  return sums_all(sum) / ((double)n - 1);
}

/* --- means of records of a driven system, used by all measurements ---------------------------- */

/* Returns the shortest common period of all prescribed motions in the measured phases, unit: time;
 * 0: there is none. */
double mean_period(const sd_model *model);
/* Returns the mean of x[0..n) and its error bar, with the transient cut off, for a record that may
 * contain a periodic ripple. period: period of the ripple in samples; 0: no ripple. */
sd_mean mean_of_record(const double *x, size_t n, double period);
/* The same for the mean of over[0..n) divided by that of under[0..n). */
sd_mean mean_of_ratio(const double *over, const double *under, size_t n, double period);

#endif
