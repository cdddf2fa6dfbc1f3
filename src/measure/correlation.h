/* correlation.h: pair correlation g(r), distributions of contact forces and of mobilised friction.
 *
 * g(r) counts pairs of centres within a window W. Each pair has the weight
 * 1/|W intersected with W + d|, with d the vector between the centres (translation correction;
 * Stoyan, Kendall, Mecke, Stochastic Geometry, 1995, 4.3). The intersection is a rectangle: along a
 * periodic direction it has the length of the box, else the width of the window less |d|. Edges
 * therefore do not bias g(r):
 *   g(r) = sum of weights / (N (N - 1)/|W|^2 times the area of the ring).
 * W is the region, cut down to the bounding box of the disks along open directions. */
#ifndef MEASURE_CORRELATION_H
#define MEASURE_CORRELATION_H

#include "base/gsl.h"
#include "measure/configuration.h"

/* Distribution of positive values, measured in multiples of their mean. */
typedef struct distribution {
  size_t n;
  /* mean: mean of the values; the others: standard deviation, skewness and excess kurtosis (0 for a
   * Gaussian) of value/mean */
  double mean, deviation, skewness, kurtosis;
  double least, most;
  size_t beyond;            /* number of values above the last bin */
  gsl_histogram *histogram; /* histogram of value/mean; NULL without values */
} distribution;

typedef struct correlation {
  gsl_histogram *pairs; /* g(r); NULL for fewer than two disks */
  double reach;         /* largest r for which g(r) is computed */
  size_t n_disks;
  double density;      /* number of disks per area of the window */
  double peak_r, peak; /* position r and height of the highest bin of g(r) */
  /* distributions of |F_n| and |tau| of load-bearing contacts in the region; tangential includes
   * only contacts with friction: mu > 0, and a force above the critical load */
  distribution normal, tangential;
  /* distribution of the mobilised friction in these contacts: |tau| divided by its limit, mu times
   * config_contact.push; not divided by its mean */
  distribution mobilised;
  size_t n_limit; /* number of contacts counted in `mobilised` that slide */
} correlation;

/* CORRELATION_FORCES: upper limit of the force histograms, in multiples of the mean force.
 * correlation_new uses `bins` >= 1 bins in every histogram; g(r) extends to 5 mean diameters, in
 * small systems to half the window. Call correlation_free also when it fails. SD_ERROR_IO: out of
 * memory. */
enum { CORRELATION_FORCES = 10 };
sd_status correlation_new(correlation *t, const configuration *c, const region *g, size_t bins,
                          sd_messages *messages);
void correlation_free(correlation *t);
/* Returns the probability density in the bin with this index. */
double distribution_density(const distribution *d, size_t bin);

#endif
