/* correlation.h: pair correlation g(r), distributions of contact forces and of mobilised friction.
 *
 * g(r) counts pairs of centres within a window W, each weighted by 1/|W intersected with W + d|, d the vector from one to
 * the other (translation correction; Stoyan, Kendall, Mecke, Stochastic Geometry, 1995, 4.3): along a periodic direction
 * the length of the box, else the width of the window less |d|. So edges do not bias it:
 *   g(r) = sum of weights / (N (N - 1)/|W|^2 times the area of the ring).
 * W is the region, cut down to the rectangle about the disks along directions that are open.
 */
#ifndef MEASURE_CORRELATION_H
#define MEASURE_CORRELATION_H

#include "base/gsl.h"
#include "measure/configuration.h"

/* Of positive values, as multiples of their mean. */
typedef struct distribution {
  size_t n;
  double mean, deviation, skewness,
      kurtosis; /* mean: of the values; the rest: of value/mean; kurtosis 0: Gaussian */
  double least, most;
  size_t beyond;            /* values above the last bin */
  gsl_histogram *histogram; /* NULL: there are no values */
} distribution;

typedef struct correlation {
  gsl_histogram *pairs; /* g(r); NULL: fewer than two disks */
  double reach;         /* of g(r) */
  size_t n_disks;
  double density;      /* disks per area of the window */
  double peak_r, peak; /* highest bin */
  distribution normal,
      tangential;         /* load-bearing contacts of the region; tangential: with mu > 0 */
  distribution mobilised; /* |tau|/(mu F_n), not divided by the mean */
  size_t n_limit;         /* contacts that slide */
} correlation;

/* bins of every histogram, at least one; g(r) reaches to 5 mean diameters, less in small systems;
 * forces to CORRELATION_FORCES means. correlation_free also when it fails. */
enum { CORRELATION_FORCES = 10 };
sd_status correlation_new(correlation *t, const configuration *c, const region *g, size_t bins,
                          sd_messages *messages);
void correlation_free(correlation *t);
/* Value of a bin as a probability density. */
double distribution_density(const distribution *d, size_t bin);

#endif
