/* measure/slow.h: is a record long against the slowest of what is in it? */
#ifndef SLIPDISK_MEASURE_SLOW_H
#define SLIPDISK_MEASURE_SLOW_H

#include <stdbool.h>
#include <stddef.h>

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
