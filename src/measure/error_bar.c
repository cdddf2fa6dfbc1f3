/* error_bar.c: standard error of the mean of a correlated record.
 *
 * n times its square is the spectral density of the record at frequency zero, S. S is that of autoregressive models of
 * the means of at most 512 blocks (Heidelberger & Welch, Commun. ACM 24, 233 (1981), and after them Plummer et al., R
 * News 6, 7 (2006), who fit such models): S = s/(1 - a_1 - ... - a_p)^2, s the variance of what the model does not
 * foretell. The sum in brackets is the product of 1 - k_i over Burg's reflection coefficients. Orders p are averaged
 * with the weights exp(-AIC/2) (Burnham & Anderson, Model Selection and Multimodel Inference (2002)).
 *
 * Correlations of both signs count. The angle of a disk that sticks and slips has bounded, elastic noise on top of its
 * random walk: its increments anticorrelate, S is a small part of their variance, and errors from blocks of B samples
 * come down to it slowly, as sqrt(S + c/B). Its spectrum rises with the frequency: so that little of it folds back to zero,
 * blocks of long records are smoothed before every other one is taken.
 *
 * A record that is periodic, or relaxes, has no noise to fit: the model foretells all of it. Periods shorter than blocks
 * fall out of their means, so there the error is the least that blocks give behind the largest, 16 of them or more,
 * with one standard deviation put back, as what is picked for being low is low by chance as well.
 *
 * The error can be trusted (`reliable`) when the record is at least 64 integrated correlation times long.
 */
#include "measure/error_bar.h"

#include <float.h>
#include <gsl/gsl_statistics_double.h>
#include <math.h>

enum { SHORTEST = 16, BLOCKS = 512, ORDERS = 27, FEWEST = 16, LONG = 64 };
static const double foretold = 1e-3; /* of the variance: what is left then is no noise */

/* Means of whole blocks of b up to the record's end; their number. */
static size_t block_means(const double *x, size_t n, size_t b, double *y) {
  size_t blocks = n / b;
  for (size_t k = 0; k < blocks; k++) y[k] = gsl_stats_mean(x + (n - (blocks - k) * b), 1, b);
  return blocks;
}

/* Every other value of a record smoothed by 1/4, 1/2, 1/4, up to its end; their number. */
static size_t halved(const double *y, size_t n, double *half) {
  size_t count = (n - 1) / 2;
  const double *first = y + (n - 1 - 2 * count);
  for (size_t k = 0; k < count; k++) half[k] = first[2 * k] / 4 + first[2 * k + 1] / 2 + first[2 * k + 2] / 4;
  return count;
}

/* 1, 2, 3, 4, 6, 8, 12, ...: half octaves. */
static size_t larger(size_t b) { return b < 2 ? b + 1 : (b & (b - 1)) ? b / 3 * 4 : b / 2 * 3; }

/* Variance of the mean of a record without noise; is a period seen? */
static bool periodic_variance(const double *x, size_t n, double *square) {
  double y[BLOCKS], largest = 0;
  for (size_t b = 1; n / b >= FEWEST; b = larger(b)) {
    size_t blocks = block_means(x, n, b, y);
    double found = gsl_stats_variance(y, 1, blocks) / (double)blocks, scatter = 1 / sqrt(2 * (double)blocks);
    if (found >= largest) *square = largest = found;
    *square = fmin(*square, found * (1 + scatter) * (1 + scatter));
  }
  return *square < largest;
}

/* Mean over orders with the weights exp(-AIC/2). */
static double weighted(const double *value, const double *criterion, size_t n) {
  double least = gsl_stats_min(criterion, 1, n), sum = 0, weights = 0;
  for (size_t p = 0; p < n; p++) {
    double weight = exp((least - criterion[p]) / 2);
    sum += weight * value[p];
    weights += weight;
  }
  return sum / weights;
}

/* Spectral density at frequency zero of y[0..n), white noise having its variance everywhere; NAN: there is no noise. */
static double spectrum_at_zero(const double *y, size_t n) {
  double forward[BLOCKS] = {0}, backward[BLOCKS] = {0}, found[ORDERS + 1], criterion[ORDERS + 1];
  double mean = gsl_stats_mean(y, 1, n), all = (double)n;
  for (size_t t = 0; t < n; t++) forward[t] = backward[t] = y[t] - mean;
  double variance = gsl_stats_variance(y, 1, n) * (all - 1) / all, left = variance, gain = 1;
  size_t orders = (size_t)fmin(fmin(10 * log10(all), all / 4), ORDERS);
  for (size_t p = 0; left > foretold * variance; p++) {
    criterion[p] = all * log(left) + 2 * (double)p;
    found[p] = left * all / (all - 1 - (double)p) / (gain * gain);
    if (p == orders) return weighted(found, criterion, p + 1);
    double both = 0, squares = 0;
    for (size_t t = p + 1; t < n; t++) {
      both += forward[t] * backward[t - 1];
      squares += forward[t] * forward[t] + backward[t - 1] * backward[t - 1];
    }
    double k = 2 * both / squares;
    for (size_t t = n - 1; t > p; t--) {
      double before = forward[t];
      forward[t] -= k * backward[t - 1];
      backward[t] = backward[t - 1] - k * before;
    }
    gain *= 1 - k;
    left *= 1 - k * k;
  }
  return NAN;
}

/* Variation that rounding alone brings into a record of this size counts as none. */
static bool is_constant(const double *x, size_t n) {
  double low, high;
  gsl_stats_minmax(&low, &high, x, 1, n);
  return high - low <= 8 * DBL_EPSILON * fmax(fabs(low), fabs(high));
}

error_bar error_bar_of(const double *x, size_t n) {
  if (n < SHORTEST) return (error_bar){.error = NAN, .correlation = NAN, .reliable = false};
  double y[BLOCKS] = {0}, half[BLOCKS];
  size_t blocks = block_means(x, n, (n + BLOCKS - 1) / BLOCKS, y);
  if (is_constant(y, blocks)) return (error_bar){.error = 0, .correlation = 0.5, .reliable = true};
  size_t halves = n > BLOCKS ? halved(y, blocks, half) : 0;
  double square =
      halves ? spectrum_at_zero(half, halves) / (double)halves : spectrum_at_zero(y, blocks) / (double)blocks;
  bool noise = !isnan(square), period = !noise && periodic_variance(y, blocks, &square);
  double tau = square / gsl_stats_variance(x, 1, n) * (double)n / 2;
  bool reliable = noise ? (double)n >= LONG * tau : period;
  return (error_bar){.error = sqrt(square), .correlation = tau, .reliable = reliable};
}
