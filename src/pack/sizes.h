/* sizes.h: distributions of radii (the deck key `sizes` of a packing).
 *
 * Random radii of all kinds but mono and list are computed by inversion, R = Q(u) with u uniform in
 * [0, 1). For a distribution with cumulative function F, truncated to [lower, upper], Q(u) =
 * F^-1(F(lower) + u (F(upper) - F(lower))), so no random number is rejected. */
#ifndef PACK_SIZES_H
#define PACK_SIZES_H

#include "base/gsl.h"
#include "slipdisk/model.h"

typedef enum sd_size_kind {
  SD_SIZES_MONO,
  SD_SIZES_LIST,
  SD_SIZES_UNIFORM,
  SD_SIZES_GAUSSIAN,
  SD_SIZES_LOGNORMAL,
  SD_SIZES_POWERLAW
} sd_size_kind;

typedef struct sizes {
  sd_size_kind kind;
  /* mono: radius of all disks; gaussian: mean radius; lognormal: median radius; both before
   * truncation */
  double radius;
  /* gaussian: standard deviation of R; lognormal: standard deviation of ln R; both before
   * truncation */
  double deviation;
  double exponent; /* powerlaw: exponent a in p(R) ~ R^-a */
  /* smallest and largest possible radius, for every kind; 0 < lower <= upper */
  double lower, upper;
  size_t n;                      /* list: number of different radii */
  const double *radii, *weights; /* list: radii, and their weights >= 0, with any positive sum */
} sizes;

/* Returns the quantile Q(u) of the radius, clamped to [lower, upper], for mono, uniform, gaussian,
 * lognormal and powerlaw. */
double sizes_quantile(const sizes *s, double u);
/* Returns the probability of [lower, upper] under a gaussian or lognormal distribution before
 * truncation; 1 for other kinds. */
double sizes_kept(const sizes *s);
/* Returns the mean area of a disk, i.e. the mean of pi R^2 under the distribution. */
double sizes_mean_area(const sizes *s);
/* Writes n random radii of the distribution. For a list, each radius occurs in proportion to its
 * weight to within one disk (largest remainders), in random order. */
void sizes_draw(const sizes *s, gsl_rng *rng, size_t n, double *radius);

/* Returns a random number generator (MT19937) for packing number `packing` of a deck with this
 * seed; never NULL. The caller frees it with gsl_rng_free. */
gsl_rng *sizes_random(uint64_t seed, size_t packing);

#endif
