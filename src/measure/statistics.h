/* statistics.h: moments, quantiles and correlations of n numbers; sums are exact before they are
 * rounded. */
#ifndef SLIPDISK_MEASURE_STATISTICS_H
#define SLIPDISK_MEASURE_STATISTICS_H

#include <stddef.h>

double statistics_mean(const double *x, size_t n);
/* Root of the sum of squares of x - mean, divided by `divisor`: n, or n - 1 for an estimate. */
double statistics_deviation(const double *x, size_t n, double mean, double divisor);
/* Mean of the power 3 or 4 of (x - mean)/deviation. */
double statistics_moment(const double *x, size_t n, double mean, double deviation, int power);
/* Quantile of ascending numbers; f: fraction of numbers below it. */
double statistics_median(const double *ascending, size_t n);
double statistics_quantile(const double *ascending, size_t n, double f);
double statistics_correlation(const double *x, const double *y, size_t n);
/* Replaces n numbers by their ranks 1 ... n; equal numbers get the mean of their ranks. order:
 * scratch. */
void statistics_ranks(double *x, size_t n, size_t *order);

#endif
