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
 * The error can be trusted (`reliable`) when the record is at least LONG integrated correlation
 * times long, and its lowest frequencies tell the density at zero (slow_of). A period must repeat
 * there, too. Records of 100 to 200 tau are called long enough partly by chance, when their error
 * comes out small. So a reliable error is enlarged by (CHANCE tau/n)^2 of itself;
 * tests/physics/test_converged.c holds CHANCE to noise of known tau.
 */
#include "measure/error_bar.h"

#include <float.h>
#include <math.h>
#include <string.h>

#include "measure/sums.h"

enum { SHORTEST = 16, BLOCKS = 512, ORDERS = 27, FEWEST = 16, LONG = 64, CHANCE = 50 };
static const double foretold = 1e-3; /* of the variance: what is left then is no noise */

/* Means of whole blocks of b up to the record's end; their number. */
static size_t block_means(const double *x, size_t n, size_t b, double *y) {
  size_t blocks = n / b;
  if (b == 1) memcpy(y, x, n * sizeof *y);
  for (size_t k = 0; b > 1 && k < blocks; k++) y[k] = sums_mean(x + (n - (blocks - k) * b), b);
  return blocks;
}

/* Every other value of a record smoothed by 1/4, 1/2, 1/4, up to its end; their number. */
static size_t halved(const double *y, size_t n, double *half) {
  size_t count = (n - 1) / 2;
  const double *first = y + (n - 1 - 2 * count);
  for (size_t k = 0; k < count; k++)
    half[k] = first[2 * k] / 4 + first[2 * k + 1] / 2 + first[2 * k + 2] / 4;
  return count;
}

/* 1, 2, 3, 4, 6, 8, 12, ...: half octaves. */
static size_t larger(size_t b) { return b < 2 ? b + 1 : (b & (b - 1)) ? b / 3 * 4 : b / 2 * 3; }

/* Variance of the mean of a record without noise; is a period seen? */
static bool periodic_variance(const double *x, size_t n, double *square) {
  double y[BLOCKS], largest = 0;
  for (size_t b = 1; n / b >= FEWEST; b = larger(b)) {
    size_t blocks = block_means(x, n, b, y);
    double found = sums_variance(y, blocks) / (double)blocks,
           scatter = 1 / sqrt(2 * (double)blocks);
    if (found >= largest) *square = largest = found;
    *square = fmin(*square, found * (1 + scatter) * (1 + scatter));
  }
  return *square < largest;
}

/* Mean over orders with the weights exp(-AIC/2). */
static double weighted(const double *value, const double *criterion, size_t n) {
  double least = criterion[0], sum = 0, weights = 0;
  for (size_t p = 1; p < n; p++) least = criterion[p] < least ? criterion[p] : least;
  for (size_t p = 0; p < n; p++) {
    double weight = exp((least - criterion[p]) / 2);
    sum += weight * value[p];
    weights += weight;
  }
  return sum / weights;
}

/* Two neighbours at once: left to itself the compiler takes vectors across blocks of eight, and transposes them. */
typedef double pair __attribute__((vector_size(16)));
static inline pair pair_at(const double *x) {
  pair p;
  memcpy(&p, x, sizeof p);
  return p;
}

/* Reflection coefficient of forward errors f[0..n) and the backward errors that meet them; both go on with zeros. */
static double reflection(const double *restrict f, const double *restrict b, size_t n) {
  pair both[SUMS / 2] = {0}, squares[SUMS / 2] = {0};
  for (size_t t = 0; t < n; t += SUMS)
    for (size_t k = 0; k < SUMS / 2; k++) {
      const pair x = pair_at(f + t + 2 * k), y = pair_at(b + t + 2 * k);
      both[k] += x * y;
      squares[k] += x * x + y * y;
    }
  return 2 * sums_all((const double *)both) / sums_all((const double *)squares);
}

/* Errors of the next order, in place. */
static void reflect(double *restrict f, double *restrict b, size_t n, double k) {
  for (size_t t = 0; t < n; t += SUMS)
    for (size_t l = t; l < t + SUMS; l++) {
      double before = f[l];
      f[l] -= k * b[l];
      b[l] -= k * before;
    }
}

/* Spectral density at frequency zero of y[0..n), white noise having its variance everywhere; NAN: there is no noise. */
static double spectrum_at_zero(const double *y, size_t n) {
  double forward[BLOCKS + SUMS], backward[BLOCKS + SUMS], found[ORDERS + 1], criterion[ORDERS + 1];
  double mean = sums_mean(y, n), all = (double)n;
  for (size_t t = 0; t < n; t++) forward[t] = backward[t] = y[t] - mean;
  memset(forward + n, 0, SUMS * sizeof *forward);
  memset(backward + n, 0, SUMS * sizeof *backward);
  double variance = sums_variance(y, n) * (all - 1) / all, left = variance, gain = 1;
  size_t orders = (size_t)fmin(fmin(10 * log10(all), all / 4), ORDERS);
  for (size_t p = 0; left > foretold * variance; p++) {
    criterion[p] = all * log(left) + 2 * (double)p;
    found[p] = left * all / (all - 1 - (double)p) / (gain * gain);
    if (p == orders) return weighted(found, criterion, p + 1);
    /* forward error t meets backward error t - 1, which stands p places before it */
    size_t pairs = n - 1 - p;
    backward[pairs] = 0;
    double k = reflection(forward + p + 1, backward, pairs);
    reflect(forward + p + 1, backward, pairs, k);
    gain *= 1 - k;
    left *= 1 - k * k;
  }
  return NAN;
}

/* Variation that rounding alone brings into a record of this size counts as none. */
static bool is_constant(const double *x, size_t n) {
  double low = x[0], high = x[0];
  for (size_t k = 1; k < n; k++) {
    low = x[k] < low ? x[k] : low;
    high = x[k] > high ? x[k] : high;
  }
  return high - low <= 8 * DBL_EPSILON * fmax(fabs(low), fabs(high));
}

error_bar error_bar_of(const double *x, size_t n) {
  if (n < SHORTEST) return (error_bar){.error = NAN, .correlation = NAN, .slow = true};
  double y[BLOCKS] = {0}, half[BLOCKS];
  size_t blocks = block_means(x, n, (n + BLOCKS - 1) / BLOCKS, y);
  if (is_constant(y, blocks)) return (error_bar){.error = 0, .correlation = 0.5, .reliable = true};
  size_t halves = n > BLOCKS ? halved(y, blocks, half) : 0;
  double square = halves ? spectrum_at_zero(half, halves) / (double)halves
                         : spectrum_at_zero(y, blocks) / (double)blocks;
  bool noise = !isnan(square), period = !noise && periodic_variance(y, blocks, &square);
  double all = (double)n, tau = square / sums_variance(x, n) * all / 2;
  error_bar found = {.error = sqrt(square), .correlation = tau};
  if (noise) {
    const slow seen = slow_of(y, blocks, square * (double)blocks);
    found.slow = seen == SLOW_PARTS || all < LONG * tau;
    found.reliable = seen == SLOW_RESOLVED && !found.slow;
    if (found.reliable) found.error *= 1 + pow(CHANCE * tau / all, 2);
  } else {
    found.reliable = period && slow_repeats(y, blocks);
    found.slow = !found.reliable;
  }
  return found;
}

/* Can a record tell its own spectral density at frequency zero?
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

enum { SHORTEST_TEST = 32, LOWEST = 32, SLOWEST = 16, AGREE = 4, EVENTS = 16 };
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
    found[k] =
        (last[k] * last[k] + before[k] * before[k] - twice[k] * last[k] * before[k]) / (double)n;
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
  if (n < SHORTEST_TEST) return false;
  periodogram(y, n, power);
  return slow_part(y, n, power) < most_slow;
}

slow slow_of(const double *y, size_t n, double spectrum) {
  double power[LOWEST];
  if (n < SHORTEST_TEST) return SLOW_PARTS;
  periodogram(y, n, power);
  const double change = change_of(power, n / 4 < LOWEST ? n / 4 : LOWEST),
               lowest = mean_of(power, AGREE);
  if (!(change > -level && lowest < most * spectrum && slow_part(y, n, power) < most_slow))
    return SLOW_PARTS;
  return change < level && lowest > least * spectrum && events(y, n) > EVENTS ? SLOW_RESOLVED
                                                                              : SLOW_DIP;
}
