/* error_bar.c: standard error of the mean of a correlated record.
 *
 * n times the squared error is the spectral density S of the record at frequency zero. It is
 * estimated by fitting autoregressive models to the means of at most 512 blocks (spectral method:
 * Heidelberger & Welch, Commun. ACM 24, 233 (1981); autoregressive fit: Plummer et al., R News 6, 7
 * (2006)): S = s/(1 - a_1 - ... - a_p)^2, with s the variance that the model does not predict. The
 * sum in brackets is the product of 1 - k_i over Burg's reflection coefficients k_i. Results of all
 * orders p are averaged with the weights exp(-AIC/2) (Burnham & Anderson, Model Selection and
 * Multimodel Inference (2002)).
 *
 * Correlations of both signs count. The angle of a disk that sticks and slips has bounded, elastic
 * noise on top of its random walk: its increments anticorrelate, S is a small part of their
 * variance, and errors from blocks of B samples approach it slowly, as sqrt(S + c/B). Their
 * spectrum rises with the frequency. To reduce aliasing to frequency zero, blocks of long records
 * are smoothed before every other one is taken.
 *
 * A record that is periodic, or relaxes, has no noise to fit: the model predicts all of it. Periods
 * shorter than the blocks average out in their means. The error is then the smallest one from block
 * lengths beyond that with the largest error, with 16 blocks or more. One standard deviation is
 * added to it, since the smallest of several estimates is low by chance as well.
 *
 * An error is `reliable` if the record is at least LONG integrated correlation times long, and its
 * lowest frequencies determine the density at zero (slow_of). A periodic record must contain enough
 * periods, too (slow_repeats). Records of 100 to 200 tau pass partly by chance, when their error
 * comes out small, so a reliable error is increased by the fraction (CHANCE tau/n)^2;
 * tests/physics/test_converged.c checks CHANCE on noise of known tau. */
#include "measure/error_bar.h"

#include <float.h>
#include <math.h>
#include <string.h>

#include "base/math.h"

enum { SHORTEST = 16, BLOCKS = 512, ORDERS = 27, FEWEST = 16, LONG = 64, CHANCE = 50 };
/* A record has no noise if the autoregressive model predicts all but this fraction of its
 * variance. */
static const double foretold = 1e-3;

/* Computes the means y[] of n/b blocks of b samples each, the last of which ends with the record.
 * Returns the number of blocks. */
static size_t block_means(const double *x, size_t n, size_t b, double *y) {
  size_t blocks = n / b;
  if (b == 1) memcpy(y, x, n * sizeof *y);
  for (size_t k = 0; b > 1 && k < blocks; k++) y[k] = sums_mean(x + (n - (blocks - k) * b), b);
  return blocks;
}

/* Smooths a record with the weights 1/4, 1/2, 1/4 and keeps every other value, counted from its
 * end. Returns the number of values kept. */
static size_t halved(const double *y, size_t n, double *half) {
  size_t count = (n - 1) / 2;
  const double *first = y + (n - 1 - 2 * count);
  for (size_t k = 0; k < count; k++)
    half[k] = first[2 * k] / 4 + first[2 * k + 1] / 2 + first[2 * k + 2] / 4;
  return count;
}

/* Returns the next block length in 1, 2, 3, 4, 6, 8, 12, ... (half octaves). */
static size_t larger(size_t b) { return b < 2 ? b + 1 : (b & (b - 1)) ? b / 3 * 4 : b / 2 * 3; }

/* Computes the squared error of the mean of a record without noise, which is periodic or relaxes.
 * Returns true if the error decreases beyond some block length, as it does for a periodic
 * record. */
static bool periodic_variance(const double *x, size_t n, double *square) {
  double y[BLOCKS], largest = 0;
  for (size_t b = 1; n / b >= FEWEST; b = larger(b)) {
    size_t blocks = block_means(x, n, b, y);
    double found = sums_variance(y, blocks) / (double)blocks,
           scatter = 1 / sqrt(2 * (double)blocks);
    if (found >= largest) *square = largest = found;
    *square = math_min(*square, found * (1 + scatter) * (1 + scatter));
  }
  return *square < largest;
}

/* Returns the mean of n values, one for each order of the autoregressive model, with the weights
 * exp(-AIC/2). criterion: AIC of each order. */
static double weighted(const double *value, const double *criterion, size_t n) {
  double least = criterion[0], sum = 0, weights = 0;
  for (size_t p = 1; p < n; p++) least = criterion[p] < least ? criterion[p] : least;
  for (size_t p = 0; p < n; p++) {
    double weight = math_exp((least - criterion[p]) / 2);
    sum += weight * value[p];
    weights += weight;
  }
  return sum / weights;
}

/* Vector of two neighbouring numbers. Without this type the compiler vectorises across blocks of
 * eight and transposes them. */
typedef double pair __attribute__((vector_size(16)));
static inline pair pair_at(const double *x) {
  pair p;
  memcpy(&p, x, sizeof p);
  return p;
}

/* Returns Burg's reflection coefficient of the forward prediction errors f[0..n) and the backward
 * prediction errors b[0..n). Both arrays are padded with zeros to a multiple of SUMS. */
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

/* Updates the forward prediction errors f and the backward ones b in place to the next order of the
 * autoregressive model. k: reflection coefficient. */
static void reflect(double *restrict f, double *restrict b, size_t n, double k) {
  for (size_t t = 0; t < n; t += SUMS)
    for (size_t l = t; l < t + SUMS; l++) {
      double before = f[l];
      f[l] -= k * b[l];
      b[l] -= k * before;
    }
}

/* Returns the spectral density of y[0..n) at frequency zero, in units in which the density of white
 * noise is its variance; NAN if the record has no noise. */
static double spectrum_at_zero(const double *y, size_t n) {
  double forward[BLOCKS + SUMS], backward[BLOCKS + SUMS], found[ORDERS + 1], criterion[ORDERS + 1];
  double mean = sums_mean(y, n), all = (double)n;
  for (size_t t = 0; t < n; t++) forward[t] = backward[t] = y[t] - mean;
  memset(forward + n, 0, SUMS * sizeof *forward);
  memset(backward + n, 0, SUMS * sizeof *backward);
  double variance = sums_variance(y, n) * (all - 1) / all, left = variance, gain = 1;
  size_t orders = (size_t)math_min(math_min(10 * math_log10(all), all / 4), ORDERS);
  for (size_t p = 0; left > foretold * variance; p++) {
    criterion[p] = all * math_log(left) + 2 * (double)p;
    found[p] = left * all / (all - 1 - (double)p) / (gain * gain);
    if (p == orders) return weighted(found, criterion, p + 1);
    /* Pair forward prediction error t with backward prediction error t - 1, which has the index t -
     * 1 - p in `backward`. */
    size_t pairs = n - 1 - p;
    backward[pairs] = 0;
    double k = reflection(forward + p + 1, backward, pairs);
    reflect(forward + p + 1, backward, pairs, k);
    gain *= 1 - k;
    left *= 1 - k * k;
  }
  return NAN;
}

/* Returns true if a record varies by no more than rounding errors of its values. */
static bool is_constant(const double *x, size_t n) {
  double low = x[0], high = x[0];
  for (size_t k = 1; k < n; k++) {
    low = x[k] < low ? x[k] : low;
    high = x[k] > high ? x[k] : high;
  }
  return high - low <= 8 * DBL_EPSILON * math_max(fabs(low), fabs(high));
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
    const double part = CHANCE * tau / all;
    if (found.reliable) found.error *= 1 + part * part;
  } else {
    found.reliable = period && slow_repeats(y, blocks);
    found.slow = !found.reliable;
  }
  return found;
}

/* Test whether a record determines its own spectral density at frequency zero.
 *
 * An error bar extrapolates the spectrum to zero. The correlation time does not tell whether that
 * is possible: the rate of a disk that sticks is nearly all elastic noise, whose spectrum has a dip
 * at zero; the integrated correlation time is small, and it is smaller the less of the dip is
 * resolved. Therefore the lowest LOWEST frequencies, 1/n to LOWEST/n, are tested. I_k is the
 * periodogram, exponentially distributed about the spectral density.
 *
 *   - Level: a parabola in k through the logarithms of means of pairs of I_k (Heidelberger &
 *     Welch, Commun. ACM 24, 233 (1981)) changes by less than `level` over that range. Noise of
 *     one correlation time tau, 1/(1 + (2 pi tau k/n)^2), needs some 110 tau; a dip must be as
 *     wide.
 *   - Periods: frequencies up to SLOWEST/n hold less than half of the variance, so that a slow
 *     period repeats SLOWEST times.
 *   - Agreement: the mean of the lowest AGREE of I_k is near the density used for the error bar.
 *   - Events: a variance made of N rare events has the relative error 1/sqrt(N); N follows from
 *     the fourth moment.
 *
 * All of them together reject two records of white noise in a hundred. */

enum { SHORTEST_TEST = 32, LOWEST = 32, SLOWEST = 16, AGREE = 4, EVENTS = 16 };
static const double level = 1.75, most_slow = 0.5;
/* limits for (mean of the lowest AGREE values of the periodogram)/(density used for the error bar):
 * 1.6 and 20.8, limits of chi^2 with 8 degrees of freedom, divided by 8 */
static const double least = 0.2, most = 2.6;

/* Computes the periodogram of y[0..n) minus its mean at the frequencies k/n, k = 1 .. LOWEST
 * (Goertzel, Am. Math. Mon. 65, 34 (1958)). */
static void periodogram(const double *y, size_t n, double found[LOWEST]) {
  double twice[LOWEST], last[LOWEST] = {0}, before[LOWEST] = {0};
  const double mean = sums_mean(y, n);
  for (size_t k = 0; k < LOWEST; k++)
    twice[k] = 2 * math_cos(2 * M_PI * (double)(k + 1) / (double)n);
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

/* Fits a parabola in the frequency to the logarithms of means of pairs of the periodogram `power`.
 * Returns the change of the parabola from frequency zero to the last frequency. */
static double change_of(const double *power, size_t frequencies) {
  const size_t count = frequencies / 2;
  const double pairs = (double)count;
  double x = 0, y = 0, xx = 0, xy = 0;
  for (size_t k = 0; k + 1 < frequencies; k += 2) {
    const double at = ((double)k + 1.5) * ((double)k + 1.5),
                 value = math_log((power[k] + power[k + 1]) / 2);
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

/* Returns the effective number of values y[k] that contribute to the variance, from the second and
 * fourth moments. */
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

/* Returns the fraction of the variance of y[0..n) at frequencies up to SLOWEST/n. power:
 * periodogram. */
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
