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
 * A record without noise that relaxes for ever (a deterministic drive) has no minimum before the edge, and what
 * is left of it never looks stationary. So the search ends where the naive error has fallen to a thousandth of
 * that of the whole record, and such a rest is called quiet.
 */
#include <float.h>
#include <gsl/gsl_rstat.h>
#include <gsl/gsl_statistics_double.h>
#include <math.h>
#include <stdlib.h>

#include "measure/blocking.h"

enum { SMALLEST = 5, FEWEST_BATCHES = 64 };
static const double enough = 1e-3;

/* Square of the naive error for truncations 0 .. last batches, of m. */
static bool naive(const double *x, size_t batch, size_t m, size_t last, double *square) {
  /* gsl_rstat's moments are running ones: going backwards, one pass serves all truncations */
  gsl_rstat_workspace *rest = gsl_rstat_alloc();
  if (!rest) return false;
  double scale = 0;
  for (size_t d = m; d-- > 0;) {
    double y = gsl_stats_mean(x + d * batch, 1, batch), kept = (double)(m - d);
    scale = fmax(scale, fabs(y));
    gsl_rstat_add(y, rest);
    if (d > last) continue;
    /* below the rounding of the samples all truncations are equally good */
    double variance = fmax(gsl_rstat_variance(rest), pow(4 * DBL_EPSILON * scale, 2));
    square[d] = variance * (kept - 1) / (kept * kept);
  }
  gsl_rstat_free(rest);
  return true;
}

transient transient_of(const double *x, size_t n) {
  size_t batch = (size_t)fmin((double)n / FEWEST_BATCHES, sqrt((double)n));
  if (batch < SMALLEST) batch = SMALLEST;
  size_t m = n / batch, last = m / 2, best = 0, start = n - m * batch; /* whole batches up to the end */
  if (m < 4) return (transient){.inside = true};

  double *square = malloc((last + 1) * sizeof *square);
  if (!square || !naive(x + start, batch, m, last, square)) {
    free(square);
    return (transient){.inside = false};
  }
  double goal = enough * enough * square[0];
  for (size_t d = 1; d <= last && square[best] > goal; d++)
    if (square[d] < square[best]) best = d;
  bool quiet = square[best] <= goal;
  free(square);
  return (transient){.length = best == 0 ? 0 : start + best * batch, .inside = best < last, .quiet = quiet};
}
