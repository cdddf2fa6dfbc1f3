/* blocking.c: standard error of the mean of a correlated record.
 *
 * Means of blocks of B samples give the error err_B = sqrt(var(block means) B/n), which grows with B up to a
 * plateau once B exceeds the correlation time (Flyvbjerg & Petersen, J. Chem. Phys. 91, 461 (1989)).
 *
 * Rule for B: the least for which B^3 > 2 n (err_B/err_1)^4. It balances the bias, about tau/B, against the
 * statistical error, about sqrt(2 B/n) (Wolff, Comput. Phys. Commun. 156, 143 (2004); Lee et al., Phys. Rev. E
 * 83, 066706 (2011)), and lets B grow by itself with the correlation seen. At least 8 blocks must be left;
 * without such a B the largest err_B seen is returned and `plateau` is false. Of the bias, which is
 * 1 - tau/B in err_B^2 for an exponential correlation, the first order is put back with the tau found.
 *
 * A periodic drive makes records that anticorrelate: err_B goes on falling as 1/sqrt(B) behind the rule's B.
 * So a larger B (with 16 blocks or more) is taken when its error is less by more than chance would have it,
 * three standard deviations of an error estimated from that many blocks. What is picked for being low is low by
 * chance as well: one standard deviation is put back.
 */
#include "measure/blocking.h"

#include <float.h>
#include <gsl/gsl_statistics_double.h>
#include <math.h>
#include <stdlib.h>

#include "base/shortage.h"
#include "model/state.h"

enum { SHORTEST = 16, FEWEST = 8, FEWEST_FALLING = 16 };

/* 1, 2, 3, 4, 6, 8, 12, ...: half octaves. */
static size_t larger(size_t b) { return b < 2 ? b + 1 : (b & (b - 1)) ? b / 3 * 4 : b / 2 * 3; }

/* err_B, from whole blocks counted from the record's end; room: n/b doubles. */
static double error_of_blocks(const double *x, size_t n, size_t b, double *room) {
  size_t blocks = n / b;
  const double *first = x + (n - blocks * b);
  for (size_t k = 0; k < blocks; k++) room[k] = gsl_stats_mean(first + k * b, 1, b);
  return sqrt(gsl_stats_variance(room, 1, blocks) * (double)b / (double)n);
}

/* Variation that rounding alone brings into a record of this size counts as none. */
static bool is_constant(const double *x, size_t n) {
  double low, high;
  gsl_stats_minmax(&low, &high, x, 1, n);
  return high - low <= 8 * DBL_EPSILON * fmax(fabs(low), fabs(high));
}

blocking blocking_error(const double *x, size_t n) {
  blocking result = {.error = NAN, .correlation = NAN, .plateau = false};
  if (n < SHORTEST) return result;
  if (is_constant(x, n)) return (blocking){.error = 0, .correlation = 0.5, .plateau = true};
  double few[SD_BINS], *room = n <= SD_BINS ? few : malloc(n * sizeof *room);
  if (!room) {
    shortage_note();
    return result;
  }

  double single = error_of_blocks(x, n, 1, room), chosen = 0, largest = 0;
  size_t b = 1, chosen_b = 1;
  for (; n / b >= FEWEST && !result.plateau; b = larger(b)) {
    double error = error_of_blocks(x, n, b, room), ratio = error / single;
    result.plateau = (double)b * (double)b * (double)b > 2 * (double)n * pow(ratio, 4);
    if (!result.plateau && error < largest) continue;
    largest = fmax(largest, error);
    chosen = error;
    chosen_b = b;
  }

  /* anticorrelation */
  double base = chosen;
  for (; result.plateau && n / b >= FEWEST_FALLING; b = larger(b)) {
    double error = error_of_blocks(x, n, b, room);
    size_t blocks = n / b;
    double scatter = 1 / sqrt(2 * (double)blocks);
    if (error >= base * (1 - 3 * scatter)) continue;
    chosen = error * (1 + scatter);
    chosen_b = b;
  }
  if (room != few) free(room);

  double tau = (chosen / single) * (chosen / single) / 2;
  result.error = chosen * sqrt(1 + tau / (double)chosen_b);
  result.correlation = tau * (1 + tau / (double)chosen_b);
  return result;
}
