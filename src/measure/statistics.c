/* statistics.c: moments, quantiles and correlations; see statistics.h. */
#include "measure/statistics.h"

#include <math.h>

#include "base/exact_sum.h"
#include "base/gsl.h"

double statistics_mean(const double *x, size_t n) {
  exact_sum sum = {0};
  for (size_t k = 0; k < n; k++) exact_sum_add(&sum, x[k]);
  return exact_sum_value(&sum) / (double)n;
}

/* Sum of (x - a)(y - b). */
static double products(const double *x, double a, const double *y, double b, size_t n) {
  exact_sum sum = {0};
  for (size_t k = 0; k < n; k++) exact_sum_add(&sum, (x[k] - a) * (y[k] - b));
  return exact_sum_value(&sum);
}

double statistics_deviation(const double *x, size_t n, double mean, double divisor) {
  return sqrt(products(x, mean, x, mean, n) / divisor);
}

double statistics_moment(const double *x, size_t n, double mean, double deviation, int power) {
  exact_sum sum = {0};
  for (size_t k = 0; k < n; k++) {
    const double z = (x[k] - mean) / deviation;
    exact_sum_add(&sum, power == 3 ? z * z * z : z * z * z * z);
  }
  return exact_sum_value(&sum) / (double)n;
}

double statistics_median(const double *ascending, size_t n) {
  return (ascending[(n - 1) / 2] + ascending[n / 2]) / 2.0;
}

double statistics_quantile(const double *ascending, size_t n, double f) {
  const double at = f * (double)(n - 1);
  const size_t below = (size_t)at;
  const double rest = at - (double)below;
  if (below + 1 >= n) return ascending[n - 1];
  return (1.0 - rest) * ascending[below] + rest * ascending[below + 1];
}

double statistics_correlation(const double *x, const double *y, size_t n) {
  const double a = statistics_mean(x, n), b = statistics_mean(y, n);
  return products(x, a, y, b, n) / (sqrt(products(x, a, x, a, n)) * sqrt(products(y, b, y, b, n)));
}

void statistics_ranks(double *x, size_t n, size_t *order) {
  gsl_sort_index(order, x, 1, n);
  for (size_t first = 0, end; first < n; first = end) {
    const double value = x[order[first]];
    for (end = first + 1; end < n && x[order[end]] == value;) end++;
    for (size_t k = first; k < end; k++) x[order[k]] = 0.5 * (double)(first + 1 + end);
  }
}
