/* error_bar.h: the parts of sd_mean_of, exposed so that each can be tested. */
#ifndef SLIPDISK_MEASURE_ERROR_BAR_H
#define SLIPDISK_MEASURE_ERROR_BAR_H

#include <stdbool.h>
#include <stddef.h>

typedef struct error_bar {
  double error;       /* standard error of the mean; NAN if it is not known */
  double correlation; /* integrated correlation time, in samples */
  bool reliable;      /* true if the record is long enough for this error to be trusted */
  /* true if the record is too short for its slow components, one of which may be a drift */
  bool slow;
} error_bar;

/* Returns the standard error of the mean of x[0..n), taken as a stationary record. */
error_bar error_bar_of(const double *x, size_t n);

/* Significance of a drift in sigmas: above DRIFT_SEEN it is cut off or enters the error bar, above
 * DRIFT_CERTAIN the mean does not count as converged. */
enum { DRIFT_SEEN = 2, DRIFT_CERTAIN = 3 };

/* Drift that remains in a record. */
typedef struct drift {
  /* difference between the means of the first quarter and of the rest, over its standard error */
  double sigmas;
  /* half the difference between the means of the two halves: the bias left by a short relaxation */
  double half;
  /* (q3 - q4)/(q1 - q2) with the means q of the four quarters, at least 0 */
  double ratio;
} drift;

/* Returns the drift of x[0..n). error: standard error of its mean. */
drift drift_of(const double *x, size_t n, double error);

typedef struct transient {
  size_t length; /* number of samples to discard at the start */
  double tail;   /* bias that the transient is likely to leave in the mean of the rest */
  bool inside;   /* true if the transient ends within the first half of the record */
  /* true if the naive error of the rest is at most a hundredth of that of the whole record */
  bool quiet;
  error_bar rest; /* standard error of the mean of the rest */
  drift left;     /* drift of the rest */
} transient;

transient transient_of(const double *x, size_t n);
/* Returns a transient of length 0, with the error and drift of the whole record. */
transient transient_none(const double *x, size_t n);

/* --- test whether a record resolves its slowest components ------------------------------------ */

typedef enum slow {
  SLOW_RESOLVED, /* the record determines its spectral density at frequency zero */
  SLOW_DIP,      /* not determined: the extrapolated density is more likely too large */
  SLOW_PARTS     /* not determined: the extrapolated density may miss slow components */
} slow;

/* Classifies a record by its block means y[0..n). spectrum: the extrapolated density at frequency
 * zero, in units in which white noise has its variance. */
slow slow_of(const double *y, size_t n, double spectrum);
/* Returns true if frequencies up to 16 periods per record (SLOWEST) hold less than half of the
 * variance of y[0..n). */
bool slow_repeats(const double *y, size_t n);

#endif
