/* sizes.c: computes quantiles of the distributions of radii, and random radii (see sizes.h). */
#include "base/gsl.h"
#include "pack/sizes.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>

#include "base/math.h"
#include "base/memory.h"
#include "base/quadrature.h"
#include "pack/normal.h"

/* Returns the quantile at u of the density p(R) ~ R^-a on [lower, upper]. The integral of R^-a is
 * written with expm1 of a non-positive argument: accurate near a = 1, where it becomes a logarithm,
 * and finite for any a. */
static double power_quantile(const sizes *s, double u) {
  double q = 1 - s->exponent, l = math_log(s->upper / s->lower);
  if (fabs(q * l) < 1e-12) return s->lower * math_exp(u * l);
  if (q < 0) return s->lower * math_exp(math_log1p(u * math_expm1(q * l)) / q);
  return s->upper * math_exp(math_log1p((1 - u) * math_expm1(-q * l)) / q);
}

/* Returns the quantile at u of a standard normal variable truncated to [a, b], a < b. For a > 0 the
 * mirrored interval is used, since probabilities near 0 keep more digits than those near 1. */
static double normal_quantile(double a, double b, double u) {
  if (a > 0) return -normal_quantile(-b, -a, 1 - u);
  double p = normal_below(a);
  return normal_at(p + u * (normal_below(b) - p));
}

static double scaled(const sizes *s, double radius) {
  return s->kind == SD_SIZES_LOGNORMAL ? math_log(radius / s->radius) / s->deviation
                                       : (radius - s->radius) / s->deviation;
}

double sizes_quantile(const sizes *s, double u) {
  double x = s->radius;
  switch (s->kind) {
    case SD_SIZES_UNIFORM: x = s->lower + u * (s->upper - s->lower); break;
    case SD_SIZES_POWERLAW: x = power_quantile(s, u); break;
    case SD_SIZES_GAUSSIAN:
    case SD_SIZES_LOGNORMAL: {
      double z = normal_quantile(scaled(s, s->lower), scaled(s, s->upper), u);
      x = s->kind == SD_SIZES_GAUSSIAN ? s->radius + s->deviation * z
                                       : s->radius * math_exp(s->deviation * z);
      break;
    }
    default: break;
  }
  return math_max(s->lower, math_min(s->upper, x));
}

double sizes_kept(const sizes *s) {
  if (s->kind != SD_SIZES_GAUSSIAN && s->kind != SD_SIZES_LOGNORMAL) return 1;
  double a = scaled(s, s->lower), b = scaled(s, s->upper);
  return a > 0 ? normal_above(a) - normal_above(b) : normal_below(b) - normal_below(a);
}

static double area_at(double u, void *user) {
  double r = sizes_quantile(user, u);
  return M_PI * r * r;
}

double sizes_mean_area(const sizes *s) {
  if (s->kind == SD_SIZES_LIST) {
    double sum = 0, weight = 0;
    for (size_t k = 0; k < s->n; k++) {
      sum += s->weights[k] * M_PI * s->radii[k] * s->radii[k];
      weight += s->weights[k];
    }
    return sum / weight;
  }
  if (s->kind == SD_SIZES_MONO) return M_PI * s->radius * s->radius;
  return quadrature(area_at, (void *)(uintptr_t)s, 0, 1);
}

/* Writes n radii of a list with weights w_k, sum W: radius k occurs floor(n w_k/W) times, and those
 * with the largest remainders once more, until there are n. */
static void draw_list(const sizes *s, size_t n, double *radius) {
  assert(s->n > 0);
  double *remainder = memory_new(s->n, sizeof *remainder), total = 0;
  size_t *count = memory_new(s->n, sizeof *count), *order = memory_new(s->n, sizeof *order),
         given = 0;
  for (size_t k = 0; k < s->n; k++) total += s->weights[k];
  for (size_t k = 0; k < s->n; k++) {
    double share = (double)n * (s->weights[k] / total);
    count[k] = (size_t)math_min(share, (double)(n - given));
    remainder[k] = -(share - (double)count[k]);
    given += count[k];
  }
  gsl_sort_index(order, remainder, 1, s->n);
  for (size_t k = 0; given < n; k = (k + 1) % s->n)
    if (s->weights[order[k]] > 0) {
      count[order[k]]++;
      given++;
    }
  for (size_t k = 0, at = 0; k < s->n; k++)
    for (size_t j = 0; j < count[k]; j++) radius[at++] = s->radii[k];
  free(remainder);
  free(count);
  free(order);
}

void sizes_draw(const sizes *s, gsl_rng *rng, size_t n, double *radius) {
  if (s->kind == SD_SIZES_LIST) {
    draw_list(s, n, radius);
    if (n > 1) gsl_ran_shuffle(rng, radius, n, sizeof *radius);
    return;
  }
  for (size_t k = 0; k < n; k++)
    radius[k] = s->kind == SD_SIZES_MONO ? s->radius : sizes_quantile(s, gsl_rng_uniform(rng));
}

gsl_rng *sizes_random(uint64_t seed, size_t packing) {
  gsl_error_handler_t *handler = gsl_set_error_handler_off();
  gsl_rng *rng = gsl_rng_alloc(gsl_rng_mt19937);
  gsl_set_error_handler(handler);
  if (!rng) memory_lacks(0);
  /* GSL's seed has 32 bits: mix seed and packing number with the finaliser of splitmix64. */
  uint64_t z = seed + (packing + 1) * 0x9e3779b97f4a7c15u;
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
  gsl_rng_set(rng, (z ^ (z >> 31)) >> 32);
  return rng;
}
