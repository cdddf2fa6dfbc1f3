/* slow.c: can a record tell its own spectral density at frequency zero?
 *
 * An error bar extrapolates the spectrum to zero. Its correlation time does not say whether that is
 * possible: the rate of a disk that sticks is nearly all elastic noise, whose spectrum has a dip at
 * zero; the integrated correlation time is small, and the smaller the less of the dip is resolved.
 * So the lowest LOWEST frequencies, 1/n to LOWEST/n, are tested themselves. I_k: periodogram,
 * exponentially distributed about the spectral density.
 *
 * - Level: a parabola of k through the logarithms of means of pairs of I_k (Heidelberger & Welch,
 *   Commun. ACM 24, 233 (1981)) changes by less than `level` over that range. Noise of one
 *   correlation time tau, 1/(1 + (2 pi tau k/n)^2), needs some 110 tau; a dip must be as wide.
 * - Periods: frequencies up to SLOWEST/n hold less than half of the variance, so that a slow period
 *   comes SLOWEST times.
 * - Agreement: the mean of the lowest AGREE of I_k is near the density that the error bar has.
 * - Events: a variance made of N rare events is known to 1/sqrt(N); the fourth moment tells N.
 *
 * All of them together refuse two records of white noise in a hundred.
 */
#include "measure/slow.h"

#include <math.h>

#include "measure/sums.h"

enum { FEWEST = 32, LOWEST = 32, SLOWEST = 16, AGREE = 4, EVENTS = 16 };
static const double level = 1.75, most_slow = 0.5;
static const double least = 0.2, most = 2.6; /* chi^2 of 8 degrees below 1.6, above 20.8 */

/* Periodogram of y[0..n) less its mean at k/n, k = 1 .. LOWEST
 * (Goertzel, Am. Math. Mon. 65, 34 (1958)). */
static void periodogram(const double *y, size_t n, double found[LOWEST]) {
  double twice[LOWEST], last[LOWEST] = {0}, before[LOWEST] = {0};
  const double mean = sums_mean(y, n);
  for (size_t k = 0; k < LOWEST; k++) twice[k] = 2 * cos(2 * M_PI * (double)(k + 1) / (double)n);
  for (size_t t = 0; t < n; t++)
    for (size_t k = 0; k < LOWEST; k++) {
      const double next = y[t] - mean + twice[k] * last[k] - before[k];
      before[k] = last[k];
      last[k] = next;
    }
  for (size_t k = 0; k < LOWEST; k++)
    found[k] = (last[k] * last[k] + before[k] * before[k] - twice[k] * last[k] * before[k]) / (double)n;
}

/* Change of the parabola through the logarithms of pairs, from frequency zero to the last. */
static double change_of(const double *power, size_t frequencies) {
  const size_t count = frequencies / 2;
  const double pairs = (double)count;
  double x = 0, y = 0, xx = 0, xy = 0;
  for (size_t k = 0; k + 1 < frequencies; k += 2) {
    const double at = pow((double)k + 1.5, 2), value = log((power[k] + power[k + 1]) / 2);
    x += at / pairs;
    y += value / pairs;
    xx += at * at;
    xy += at * value;
  }
  return (xy - pairs * x * y) / (xx - pairs * x * x) * (double)(frequencies * frequencies);
}

static double mean_of(const double *x, size_t n) {
  double all = 0;
  for (size_t k = 0; k < n; k++) all += x[k];
  return all / (double)n;
}

/* Number of values that make the variance. */
static double events(const double *y, size_t n) {
  double second = 0, fourth = 0;
  const double mean = sums_mean(y, n);
  for (size_t t = 0; t < n; t++) {
    const double square = (y[t] - mean) * (y[t] - mean);
    second += square;
    fourth += square * square;
  }
  return (double)n / (fourth * (double)n / (second * second) - 1);
}

/* Part of the variance below SLOWEST/n. */
static double slow_part(const double *y, size_t n, const double *power) {
  const size_t few = n / 8 < SLOWEST ? n / 8 : SLOWEST;
  return 2 * mean_of(power, few) * (double)few / ((double)(n - 1) * sums_variance(y, n));
}

bool slow_repeats(const double *y, size_t n) {
  double power[LOWEST];
  if (n < FEWEST) return false;
  periodogram(y, n, power);
  return slow_part(y, n, power) < most_slow;
}

slow slow_of(const double *y, size_t n, double spectrum) {
  double power[LOWEST];
  if (n < FEWEST) return SLOW_PARTS;
  periodogram(y, n, power);
  const double change = change_of(power, n / 4 < LOWEST ? n / 4 : LOWEST), lowest = mean_of(power, AGREE);
  if (!(change > -level && lowest < most * spectrum && slow_part(y, n, power) < most_slow)) return SLOW_PARTS;
  return change < level && lowest > least * spectrum && events(y, n) > EVENTS ? SLOW_RESOLVED : SLOW_DIP;
}
