/* sizes.h: distributions of radii (the key `sizes` of a packing).
 *
 * All but mono and list are drawn by inversion, R = Q(u) with u uniform in [0, 1). Q of a cut distribution with
 * cumulative F is F^-1(F(lower) + u (F(upper) - F(lower))), so nothing is rejected.
 */
#ifndef PACK_SIZES_H
#define PACK_SIZES_H

#include "base/gsl.h"
#include "model/model.h"

typedef struct sizes {
  sd_size_kind kind;
  double radius;    /* gaussian: mean; lognormal: median, before the cut */
  double deviation; /* gaussian: of R; lognormal: of ln R, before the cut */
  double exponent;  /* powerlaw: a in p(R) ~ R^-a */
  double lower,
      upper; /* smallest and largest radius that there can be, of every kind; 0 < lower <= upper */
  size_t n;  /* list */
  const double *radii, *weights; /* list: weights >= 0, of any positive sum */
} sizes;

/* Q(u) of mono, uniform, gaussian, lognormal, powerlaw; within [lower, upper]. */
double sizes_quantile(const sizes *s, double u);
/* Probability of [lower, upper] under the distribution before the cut; 1 for the others. */
double sizes_kept(const sizes *s);
/* Mean of pi R^2. */
double sizes_mean_area(const sizes *s);
/* Writes n radii. Of a list each radius comes as often as its weight says, to within one disk (largest
 * remainders), in random order. */
void sizes_draw(const sizes *s, gsl_rng *rng, size_t n, double *radius);

/* A generator of random numbers, for packing number `packing` of a deck with this seed. It is never
 * NULL. */
gsl_rng *sizes_random(uint64_t seed, size_t packing);

#endif
