/* measure/blocking.h: the parts of sd_mean_of, apart so that each can be tested. */
#ifndef SLIPDISK_MEASURE_BLOCKING_H
#define SLIPDISK_MEASURE_BLOCKING_H

#include <stdbool.h>
#include <stddef.h>

typedef struct blocking {
  double error;       /* of the mean; NAN when it cannot be told */
  double correlation; /* integrated correlation time, samples */
  bool plateau;       /* the rule found a block size */
} blocking;

/* Standard error of the mean of x[0..n) as a stationary record. */
blocking blocking_error(const double *x, size_t n);

typedef struct transient {
  size_t length; /* samples to discard at the start */
  bool inside;   /* it ends before half the record */
  bool quiet;    /* what follows is steady to a thousandth of it, by the naive error */
} transient;

transient transient_of(const double *x, size_t n);

#endif
