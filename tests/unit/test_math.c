/* test_math.c: elementary functions are rounded correctly, have the bits of every processor, and treat zeros, infinities and NAN as
 * C demands; what is computed with them agrees with GSL. */
#include <gsl/gsl_cdf.h>
#include <gsl/gsl_sort.h>
#include <gsl/gsl_spline.h>
#include <gsl/gsl_statistics_double.h>

#include "unit.h"
#include "base/math.h"
#include "base/quadrature.h"
#include "measure/statistics.h"
#include "pack/normal.h"
#include "physics/motion/spline.h"

enum { TRIALS = 20000 };

static const struct function {
  const char *name;
  double (*of)(double);
  long double (*right)(long double);
  double low, high; /* range of arguments */
  bool powers;      /* arguments +-2^x, x in this range */
} functions[] = {
    {"sin", math_sin, sinl, -10, 10, false},     {"sin", math_sin, sinl, -30, 1000, true},
    {"cos", math_cos, cosl, -10, 10, false},     {"cos", math_cos, cosl, -30, 1000, true},
    {"tan", math_tan, tanl, -10, 10, false},     {"tan", math_tan, tanl, -30, 1000, true},
    {"asin", math_asin, asinl, -1, 1, false},    {"asin", math_asin, asinl, -30, 0, true},
    {"acos", math_acos, acosl, -1, 1, false},    {"acos", math_acos, acosl, -30, 0, true},
    {"atan", math_atan, atanl, -3, 3, false},    {"atan", math_atan, atanl, -30, 70, true},
    {"exp", math_exp, expl, -700, 700, false},   {"exp", math_exp, expl, -60, 0, true},
    {"expm1", math_expm1, expm1l, -2, 2, false}, {"expm1", math_expm1, expm1l, -60, 9, true},
    {"log", math_log, logl, 0, 2, false},        {"log", math_log, logl, -1000, 1000, true},
    {"log10", math_log10, log10l, 0, 2, false},  {"log10", math_log10, log10l, -1000, 1000, true},
    {"log1p", math_log1p, log1pl, -1, 2, false}, {"log1p", math_log1p, log1pl, -60, 1000, true},
};
enum { FUNCTIONS = sizeof functions / sizeof *functions };

static const struct function_of_two {
  const char *name;
  double (*of)(double, double);
  long double (*right)(long double, long double);
  double low[2], high[2];
  double units; /* largest error in units of the last place */
} of_two[] = {
    {"atan2", math_atan2, atan2l, {-1, -1}, {1, 1}, 0.502},
    {"pow", math_pow, powl, {0, -30}, {10, 30}, 0.502},
    {"hypot", math_hypot, hypotl, {-1, -1}, {1, 1}, 0.6},
};
enum { OF_TWO = sizeof of_two / sizeof *of_two };

static uint64_t stream;

/* In [0, 1). */
static double draw(void) {
  stream = stream * 6364136223846793005u + 1442695040888963407u;
  return (double)(stream >> 11) * 0x1p-53;
}

static double argument(const struct function *f) {
  const double x = f->low + draw() * (f->high - f->low);
  if (!f->powers) return x;
  const double size = ldexp(1.0 + draw(), (int)floor(x) - 1);
  return draw() < 0.5 && f->of != math_log && f->of != math_log10 && f->high < 500 ? -size : size;
}

static double units(double found, long double right) {
  int exponent;
  frexpl(right, &exponent);
  return (double)(fabsl((long double)found - right) / ldexpl(1.0L, exponent - DBL_MANT_DIG));
}

static void mix(uint64_t *hash, double x) {
  uint64_t bits;
  memcpy(&bits, &x, sizeof bits);
  *hash = (*hash ^ bits) * 0x100000001b3u;
}

/* The hash is that of x86-64; tools/arm.sh runs this test for aarch64. */
static void rounded_correctly_with_the_same_bits(void **unused) {
  uint64_t hash = 0xcbf29ce484222325u;
  stream = 1;
  for (size_t k = 0; k < FUNCTIONS; k++)
    for (int n = 0; n < TRIALS; n++) {
      const double x = argument(&functions[k]), y = functions[k].of(x);
      mix(&hash, y);
      const double error = units(y, functions[k].right((long double)x));
      if (!(error < 0.502)) fail_msg("%s(%a) = %a: %g units", functions[k].name, x, y, error);
    }
  for (size_t k = 0; k < OF_TWO; k++)
    for (int n = 0; n < TRIALS; n++) {
      const struct function_of_two *f = &of_two[k];
      const double x = f->low[0] + draw() * (f->high[0] - f->low[0]);
      const double y = f->low[1] + draw() * (f->high[1] - f->low[1]), z = f->of(x, y);
      mix(&hash, z);
      const double error = units(z, f->right((long double)x, (long double)y));
      if (!(error < f->units)) fail_msg("%s(%a, %a) = %a: %g units", f->name, x, y, z, error);
    }
  assert_int_equal(hash, 0x16c8360847895f22);
}

static void same_kind(const char *name, double x, double y, double found, double c) {
  const bool same = isnan(c) ? isnan(found)
                             : signbit(found) == signbit(c) &&
                                   (found == c || fabs(found - c) <= 2 * DBL_EPSILON * fabs(c));
  if (!same) fail_msg("%s(%g, %g) = %g, of C %g", name, x, y, found, c);
}

static void zeros_infinities_and_nan_as_in_c(void **unused) {
  static const double values[] = {0.0,    -0.0,   1.0,      -1.0,      0.5,    -0.5,       2.0,
                                  -2.0,   3.0,    -3.0,     2.5,       1e-310, -1e-310,    5e-324,
                                  1e308,  -1e308, INFINITY, -INFINITY, NAN,    700.0,      710.0,
                                  -710.0, -745.0, -750.0,   1e17,      0x1p53, 0x1p53 - 1, M_PI,
                                  1e22,   0.785,  M_PI_4,   1000.0,    1e-30};
  enum { VALUES = sizeof values / sizeof *values };
  static double (*const of_c[])(double) = {sin,  sin,  cos,   cos,   tan,   tan,  asin,  asin,
                                           acos, acos, atan,  atan,  exp,   exp,  expm1, expm1,
                                           log,  log,  log10, log10, log1p, log1p};
  static double (*const two_of_c[])(double, double) = {atan2, pow, hypot};
  for (size_t i = 0; i < VALUES; i++) {
    for (size_t k = 0; k < FUNCTIONS; k++)
      same_kind(functions[k].name, values[i], 0, functions[k].of(values[i]), of_c[k](values[i]));
    for (size_t j = 0; j < VALUES; j++)
      for (size_t k = 0; k < OF_TWO; k++)
        same_kind(of_two[k].name, values[i], values[j], of_two[k].of(values[i], values[j]),
                  two_of_c[k](values[i], values[j]));
  }
}

static void smaller_and_larger(void **unused) {
  assert_true(math_min(1, 2) == 1 && math_min(2, 1) == 1 && math_max(1, 2) == 2 &&
              math_max(2, 1) == 2);
  assert_true(math_min(NAN, 1) == 1 && math_min(1, NAN) == 1 && math_max(NAN, 1) == 1 &&
              math_max(1, NAN) == 1);
  assert_true(signbit(math_min(0.0, -0.0)) && !signbit(math_min(-0.0, 0.0)));
  assert_true(signbit(math_max(0.0, -0.0)) && !signbit(math_max(-0.0, 0.0)));
}

static void near(double found, double expected, double relative) {
  if (!(fabs(found - expected) <= relative * fabs(expected)))
    fail_msg("%.17g, expected %.17g", found, expected);
}

static void normal_distribution_as_in_gsl(void **unused) {
  stream = 2;
  for (int n = 0; n < TRIALS; n++) {
    const double x = (draw() - 0.5) * (n % 2 ? 70 : 12), p = n % 2 ? draw() : exp(-600 * draw());
    near(normal_below(x), gsl_cdf_ugaussian_P(x), 1e-14);
    near(normal_above(x), gsl_cdf_ugaussian_Q(x), 1e-14);
    near(normal_at(p), gsl_cdf_ugaussian_Pinv(p), 1e-14);
  }
  assert_true(normal_at(0) == -HUGE_VAL && normal_at(1) == HUGE_VAL && normal_at(0.5) == 0);
}

static void splines_as_in_gsl(void **unused) {
  enum { MOST = 30 };
  stream = 3;
  for (size_t n = 3; n < MOST; n++)
    for (int periodic = 0; periodic < 2; periodic++) {
      double x[MOST], y[MOST], at = draw();
      for (size_t k = 0; k < n; k++) {
        x[k] = at, y[k] = draw() - 0.5;
        at += 0.01 + draw();
      }
      if (periodic) y[n - 1] = y[0];
      spline s;
      assert_true(spline_new(&s, x, y, n, periodic));
      gsl_spline *g =
          gsl_spline_alloc(periodic ? gsl_interp_cspline_periodic : gsl_interp_cspline, n);
      assert_int_equal(gsl_spline_init(g, x, y, n), 0);
      for (size_t k = 0; k < 200; k++) {
        const double t = k < n ? x[k] : x[0] + draw() * (x[n - 1] - x[0]);
        assert_true(fabs(spline_value(&s, t) - gsl_spline_eval(g, t, NULL)) < 1e-12);
        assert_true(fabs(spline_slope(&s, t) - gsl_spline_eval_deriv(g, t, NULL)) < 1e-10);
      }
      gsl_spline_free(g);
      spline_free(&s);
    }
  spline none;
  assert_false(spline_new(&none, (double[]){0, 1, 1}, (double[]){0, 1, 2}, 3, false));
  spline_free(&none);
}

static double half_circle(double x, void *user) {
  (void)user;
  return sqrt(math_max(0, 1 - x * x));
}

static void integrals(void **unused) {
  near(quadrature(half_circle, NULL, -1, 1), M_PI / 2, 1e-11);
  near(quadrature(half_circle, NULL, -3, 2), M_PI / 2, 1e-11);
}

static void statistics_as_in_gsl(void **unused) {
  enum { N = 101 };
  double x[N], y[N], work[2 * N];
  size_t order[N];
  stream = 4;
  for (size_t k = 0; k < N; k++) {
    x[k] = floor(20 * draw()); /* with equal ones */
    y[k] = x[k] * x[k] * draw();
  }
  const double mean = gsl_stats_mean(x, 1, N), sd = gsl_stats_sd(x, 1, N);
  near(statistics_mean(x, N), mean, 1e-15);
  near(statistics_deviation(x, N, mean, N - 1), sd, 1e-15);
  near(statistics_moment(y, N, 10, 20, 3), gsl_stats_skew_m_sd(y, 1, N, 10, 20), 1e-14);
  near(statistics_moment(y, N, 10, 20, 4) - 3, gsl_stats_kurtosis_m_sd(y, 1, N, 10, 20), 1e-14);
  near(statistics_correlation(x, y, N), gsl_stats_correlation(x, 1, y, 1, N), 1e-14);
  const double ranked = gsl_stats_spearman(x, 1, y, 1, N, work);
  statistics_ranks(x, N, order);
  statistics_ranks(y, N, order);
  near(statistics_correlation(x, y, N), ranked, 1e-14);
  gsl_sort(y, 1, N);
  for (size_t n = N - 1; n <= N; n++) {
    near(statistics_median(y, n), gsl_stats_median_from_sorted_data(y, 1, n), 1e-15);
    for (double f = 0; f <= 1; f += 0.0625)
      near(statistics_quantile(y, n, f), gsl_stats_quantile_from_sorted_data(y, 1, n, f), 1e-15);
  }
}

RUN_TESTS(TEST(rounded_correctly_with_the_same_bits), TEST(zeros_infinities_and_nan_as_in_c),
          TEST(smaller_and_larger), TEST(normal_distribution_as_in_gsl), TEST(splines_as_in_gsl),
          TEST(integrals), TEST(statistics_as_in_gsl))
