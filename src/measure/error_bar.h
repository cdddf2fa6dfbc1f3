/* error_bar.h: the parts of sd_mean_of, apart so that each can be tested. */
#ifndef SLIPDISK_MEASURE_ERROR_BAR_H
#define SLIPDISK_MEASURE_ERROR_BAR_H

#include <stdbool.h>
#include <stddef.h>

typedef struct error_bar {
  double error;       /* of the mean; NAN when it cannot be told */
  double correlation; /* integrated correlation time, samples */
  bool reliable;      /* the record is long enough for it */
  bool slow; /* it is too short for slow parts that are in it: a drift may be one of them */
} error_bar;

/* Standard error of the mean of x[0..n) as a stationary record. */
error_bar error_bar_of(const double *x, size_t n);

/* From here on, in sigmas, a drift is cut off or put into the error bar; and it spoils convergence. */
enum { DRIFT_SEEN = 2, DRIFT_CERTAIN = 3 };

/* Remaining drift of a record. */
typedef struct drift {
  double sigmas; /* difference of the first quarter's mean and the rest's, in its errors */
  double
      half; /* half the difference of the means of the halves: the bias left by a short relaxation */
  double ratio; /* difference of the last two quarters over that of the first two, >= 0 */
} drift;

/* error: that of the mean of x[0..n). */
drift drift_of(const double *x, size_t n, double error);

typedef struct transient {
  size_t length;  /* samples to discard at the start */
  double tail;    /* bias that it is likely to leave in the mean of the rest */
  bool inside;    /* it ends before half the record */
  bool quiet;     /* what follows is steady to a hundredth of the whole, by the naive error */
  error_bar rest; /* of the mean of what follows */
  drift left;     /* in it */
} transient;

transient transient_of(const double *x, size_t n);
/* Nothing is discarded. */
transient transient_none(const double *x, size_t n);

/* --- is a record long against the slowest of what is in it? ----------------------------------- */

typedef enum slow {
  SLOW_RESOLVED, /* the record tells its spectral density at frequency zero */
  SLOW_DIP,      /* it does not: the extrapolated density is rather too large */
  SLOW_PARTS     /* it does not: the extrapolated density may miss slow parts */
} slow;

/* y[0..n): means of the blocks of a record. spectrum: the extrapolated density, in units in which
 * white noise has its variance. */
slow slow_of(const double *y, size_t n, double spectrum);
/* Is most of the variance faster than a sixteenth of the record? */
bool slow_repeats(const double *y, size_t n);

#endif
