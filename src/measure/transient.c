/* transient.c: length of the transient by the marginal standard error rule, MSER.
 *
 * Of all truncations d take the one that makes the naive error of the mean of the rest least:
 * sum_{i >= d} (y_i - mean_d)^2/(m - d)^2, y_i the m means of a batch of samples (White, Simulation 69, 323
 * (1997); batches of 5: White, Cobb & Spratt, Winter Simulation Conference (2000)). What is left of a transient
 * is of the size of the batches' noise, and adds up over the transient's length, so that batches of 5 leave
 * a bias of several errors in a long record; here a batch grows with the record, up to sqrt(n). Only the first
 * half is searched, as the statistic is erratic near the end; a minimum at the edge means that no stationary
 * part was found.
 *
 * A stationary record has such a minimum too, wherever chance put it, and a cut there selects: what is left has
 * less scatter than the whole, so that its error bar is too small. So a cut counts only if what it takes away
 * differs from the rest: the mean of the first part, or of its first half, quarter or eighth, by more than
 * `distinct` errors of the difference, from the error bar of the rest.
 *
 * What is left of a relaxation behind such a cut is of the size of the noise of the batches, but adds up. It is
 * told in two ways: from the decay within what is cut off (tail_of), and from the means of the first quarter and
 * the rest of what is kept (drift_of). While the first is more than half the error bar or the second more than
 * two of its own, a sixteenth of the record is cut off as well, up to half of it. What is still left belongs in
 * the error bar.
 *
 * A record without noise that relaxes for ever (a deterministic drive) has no minimum before the edge, and what
 * is left of it never looks stationary. It is called quiet when the naive error falls to a hundredth of that of
 * the whole record; the search ends at a thousandth of this.
 */
#include <float.h>
#include <math.h>
#include <stdlib.h>

#include "base/memory.h"
#include "measure/error_bar.h"
#include "measure/sums.h"

enum { SMALLEST = 5, FEWEST_BATCHES = 64, PARTS = 4, STEPS = 16, BATCHES = 64, ENOUGH = 16 };
static const double quiet_at = 1e-2, enough = 1e-5, distinct = 3;

/* Square of the naive error for truncations 0 .. last batches, of m. */
static void naive(const double *x, size_t batch, size_t m, size_t last, double *square) {
  /* running moments (Welford): going backwards, one pass serves all truncations */
  double scale = 0, mean = 0, squares = 0;
  for (size_t d = m; d-- > 0;) {
    double y = sums_mean(x + d * batch, batch), kept = (double)(m - d), off = y - mean;
    scale = fmax(scale, fabs(y));
    mean += off / kept;
    squares += off * (y - mean);
    if (d > last) continue;
    /* below the rounding of the samples all truncations are equally good */
    double variance = fmax(squares / (kept - 1), pow(4 * DBL_EPSILON * scale, 2));
    square[d] = variance * (kept - 1) / (kept * kept);
  }
}

/* Standard deviation of means of `part` of n samples, from those that there are; 0: too few. */
static double scatter_of(const double *x, size_t n, size_t part) {
  double y[BATCHES];
  size_t count = n / part < BATCHES ? n / part : BATCHES;
  for (size_t k = 0; k < count; k++) y[k] = sums_mean(x + (n - (k + 1) * part), part);
  return count < ENOUGH ? 0 : sqrt(sums_variance(y, count));
}

/* Is x[0..d), or the start of it, unlike x[d..n)? Samples that anticorrelate scatter more over a short part than the
 * error bar of the rest has it. */
static bool stands_out(const double *x, size_t d, size_t n) {
  double rest = sums_mean(x + d, n - d), error = error_bar_of(x + d, n - d).error;
  size_t part = d;
  for (int k = 0; k < PARTS && part > 0; k++, part /= 2) {
    double short_one = fmax(error * sqrt((double)(n - d) / (double)part), scatter_of(x + d, n - d, part));
    double sigma = hypot(error, short_one);
    /* without an error bar there is nothing against the cut */
    if (!(fabs(sums_mean(x, part) - rest) <= distinct * sigma)) return true;
  }
  return false;
}

drift drift_of(const double *x, size_t n, double error) {
  size_t quarter = n / 4;
  drift result = {.ratio = 0};
  if (n < ENOUGH) return result;
  double q[4];
  for (size_t k = 0; k < 4; k++) q[k] = sums_mean(x + (n - (4 - k) * quarter), quarter);
  double fall = fabs(q[0] - (q[1] + q[2] + q[3]) / 3);
  bool rounding = fall <= 8 * DBL_EPSILON * fabs(q[3]);
  /* variance of a mean over a length L: error^2 n/L, and of bounded noise c/L^2, which a sixteenth tells */
  double bounded = fmax(0, pow(scatter_of(x, n, n / ENOUGH), 2) - 16 * error * error);
  double sigma = sqrt((4 + 4. / 3) * error * error + bounded * (1. / 16 + 1. / 144));
  result.sigmas = rounding ? 0 : fall / sigma;
  result.half = fabs(q[0] + q[1] - q[2] - q[3]) / 4;
  result.ratio = (q[2] - q[3]) / (q[0] - q[1]);
  if (!(result.ratio > 0)) result.ratio = 0;
  return result;
}

/* Bias that the rest of a relaxation over x[0..d) leaves in the mean of x[d..n): its mean excess in two halves goes
 * on as a geometric series. */
static double tail_of(const double *x, size_t d, size_t n) {
  size_t half = d / 2;
  if (half == 0) return 0;
  double rest = sums_mean(x + d, n - d);
  double first = sums_mean(x, half) - rest, second = sums_mean(x + (d - half), half) - rest;
  double ratio = fmin(second / first, 0.75);
  return ratio > 0 ? fabs(second) * ratio / (1 - ratio) * (double)half / (double)(n - d) : 0;
}

/* Lengthens a cut while something of the relaxation is seen behind it, and tells what error and drift are left. */
static void cut_drift(const double *x, size_t n, transient *found) {
  for (size_t step = n / STEPS;; found->length += step) {
    const double *rest = x + found->length;
    size_t kept = n - found->length;
    found->rest = error_bar_of(rest, kept);
    const double error = found->rest.error;
    found->left = drift_of(rest, kept, error);
    found->tail = tail_of(x, found->length, n);
    if (!(found->tail > error / 2 || found->left.sigmas > DRIFT_SEEN)) return;
    if (step > 0 && found->length + step <= n / 2) continue;
    found->inside &= found->tail <= error;
    return;
  }
}

transient transient_none(const double *x, size_t n) {
  transient found = {.inside = true, .rest = error_bar_of(x, n)};
  found.left = drift_of(x, n, found.rest.error);
  return found;
}

transient transient_of(const double *x, size_t n) {
  size_t batch = (size_t)fmin((double)n / FEWEST_BATCHES, sqrt((double)n));
  if (batch < SMALLEST) batch = SMALLEST;
  size_t m = n / batch, last = m / 2, best = 0, start = n - m * batch; /* whole batches up to the end */
  if (m < 4) return transient_none(x, n);

  /* some for the fewest batches, some for the root of n: small */
  double *square = memory_new(last + 1, sizeof *square);
  naive(x + start, batch, m, last, square);
  double whole = square[0], goal = enough * enough * whole;
  for (size_t d = 1; d <= last && square[best] > goal; d++)
    if (square[d] < square[best]) best = d;
  bool quiet = square[best] <= quiet_at * quiet_at * whole;
  free(square);
  transient found = {.length = start + best * batch, .inside = best < last || quiet, .quiet = quiet};
  if (quiet) {
    found.rest = error_bar_of(x + found.length, n - found.length);
    found.left = drift_of(x + found.length, n - found.length, found.rest.error);
    return found;
  }
  if (found.length > 0 && !stands_out(x, found.length, n)) found = (transient){.inside = true};
  cut_drift(x, n, &found);
  return found;
}
