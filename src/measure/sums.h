/* measure/sums.h: means and variances of records, written for vectorisation. There are SUMS partial
 * sums on every processor, so the bits do not depend on the vector width. The summands are
 * differences from the first value, so that a constant record has exactly its value as mean. */
#ifndef SLIPDISK_MEASURE_SUMS_H
#define SLIPDISK_MEASURE_SUMS_H

#include <stddef.h>

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

#endif
