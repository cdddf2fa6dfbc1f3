/* test_kernels.c: the kernels of every instruction set: Philox against Random123, accuracy and quality of the normal
 * numbers, accuracy of sine and cosine, and the same bits from all of them. */
#include <Random123/philox.h>
#include <gsl/gsl_cdf.h>

#include "deck_runs.h"
#include "physics/system/kernels.h"

#define LANE_WIDTH 1
#include "base/lane.h"
#include "base/vmath.h"
#include "physics/motion/draws.h"
#include "physics/motion/motion_kernels.h"
#undef LANE_WIDTH

enum { PATHS = 3 };
static const char *const path_names[PATHS] = {"baseline", "avx2", "avx512"};

/* One draw from Random123's own generator: counter = (block low, block high, stream, purpose), key = seed. */
static void reference_draw(uint64_t seed, uint32_t stream, uint32_t purpose, uint64_t index,
                           double *a, double *b) {
  uint64_t block = index / 2, word[DRAW_BLOCKS][4];
  philox4x32_ctr_t counter = {{(uint32_t)block, (uint32_t)(block >> 32), stream, purpose}};
  philox4x32_key_t key = {{(uint32_t)seed, (uint32_t)(seed >> 32)}};
  philox4x32_ctr_t out = philox4x32_R(10, counter, key);
  double x[2 * DRAW_BLOCKS], y[2 * DRAW_BLOCKS];
  for (int k = 0; k < 4; k++) word[0][k] = out.v[k];
  draw_pairs_w1(word, 1, x, y);
  *a = x[index % 2];
  *b = y[index % 2];
}

static void philox_is_random123s(void **unused) {
  enum { N = 200 };
  const uint64_t seeds[] = {0, 1, 0xdeadbeefcafef00d, UINT64_MAX};
  const uint32_t streams[] = {0, 5, 0x12345678, UINT32_MAX};
  const int64_t firsts[] = {0, 3, 0xffffff80, ((int64_t)1 << 40) + 7};
  double a[N + 1], b[N + 1];
  for (int p = 0; p < PATHS; p++) {
    const kernels *k = kernels_named(path_names[p]);
    if (!k) {
      print_message("  %s does not run here\n", path_names[p]);
      continue;
    }
    for (int c = 0; c < 64; c++) {
      uint64_t seed = seeds[c & 3];
      uint32_t stream = streams[c >> 2 & 3], purpose = (uint32_t)c & 1;
      int64_t first = firsts[c >> 4];
      uint64_t count = (uint64_t)(N - c);
      a[count] = b[count] = 7.0;
      k->motion->normals(seed, stream, purpose, first, count, a, b);
      assert_true(a[count] == 7.0 && b[count] == 7.0); /* and no more */
      for (uint64_t n = 0; n < count; n++) {
        double x, y;
        reference_draw(seed, stream, purpose, (uint64_t)first + n, &x, &y);
        assert_memory_equal(&x, &a[n], 8);
        assert_memory_equal(&y, &b[n], 8);
      }
    }
  }
}

/* Error of the pair that two words give, against Box and Muller in extended precision; relative to what draws.h
 * says of radius and direction. */
static double pair_error(uint32_t w, uint32_t place, double *radius) {
  uint64_t word[DRAW_BLOCKS][4] = {{w, place, w, place}};
  double a[2 * DRAW_BLOCKS], b[2 * DRAW_BLOCKS];
  draw_pairs_w1(word, 1, a, b);
  const long double half = acosl(-1.0L) / 2;
  long double r = sqrtl(-2 * logl(((long double)w + 0.5L) * 0x1p-32L));
  long double angle = half * ((long double)(place >> 1 & 0x3fffffffu) + 0.5L) * 0x1p-30L;
  long double x = r * cosl(angle) * (place & 1 ? -1 : 1),
              y = r * sinl(angle) * (place >> 31 ? -1 : 1);
  long double measured = sqrtl((long double)a[0] * a[0] + (long double)b[0] * b[0]);
  *radius = (double)r;
  return (double)(fmaxl(fabsl(a[0] - x), fabsl(b[0] - y)) / (4e-10L + 9e-10L * r)) +
         (isfinite((double)measured) ? 0.0 : HUGE_VAL);
}

static void normals_are_box_and_mullers(void **unused) {
  double worst = 0.0, largest = 0.0, least = HUGE_VAL, r;
  uint64_t seed = 5;
  for (int k = 0; k < 400000; k++) {
    uint64_t bits = next_bits(&seed);
    uint32_t w = (uint32_t)bits, place = (uint32_t)(bits >> 32);
    if (k % 4 == 1) w >>= k / 4 % 33 == 32 ? 31 : k / 4 % 33; /* every octave */
    if (k % 4 == 2) w = UINT32_MAX - (w >> k / 4 % 32);
    if (k % 4 == 3)
      place = (place & 0x80000001u) | (uint32_t)(k & 4 ? k / 8 & 0xff : 0x3fffffff - (k / 8 & 0xff))
                                          << 1;
    if (k < 64) w = k & 1 ? UINT32_MAX - (uint32_t)k / 2 : (uint32_t)k / 2;
    worst = fmax(worst, pair_error(w, place, &r));
    largest = fmax(largest, r);
    least = fmin(least, r);
  }
  print_message("  largest error of a normal number / the bound: %.3g; radii %.3g to %.4g\n", worst,
                least, largest);
  between(worst, 0, 1.0, "error of a normal number / its bound");
  between(largest, sqrt(2 * log(0x1p33)) - 1e-8, sqrt(2 * log(0x1p33)) + 1e-8, "largest radius");
}

static double ulps(double value, long double exact) {
  double e = fabs((double)exact);
  double unit = e < 0x1p-1000 ? 0x1p-1052 : nextafter(e, HUGE_VAL) - e;
  return (double)fabsl((long double)value - exact) / unit;
}

/* sin and cos of 2 pi t, the argument reduced exactly first. */
static void exact_sine_cosine(double t, long double *s, long double *c) {
  long double turn = 2 * acosl(-1.0L), r = (long double)t - nearbyintl((long double)t);
  long double q = nearbyintl(4 * r), y = (r - q / 4) * turn;
  long double sy = sinl(y), cy = cosl(y);
  int quarter = ((int)q + 4) % 4;
  *s = quarter == 0 ? sy : quarter == 1 ? cy : quarter == 2 ? -sy : -cy;
  *c = quarter == 0 ? cy : quarter == 1 ? -sy : quarter == 2 ? -cy : sy;
}

static void sine_and_cosine_are_accurate(void **unused) {
  enum { N = 200000 };
  double *t = malloc(N * sizeof *t), *s = malloc(N * sizeof *s), *c = malloc(N * sizeof *c);
  uint64_t seed = 7;
  for (int k = 0; k < N; k++) {
    double u = next_uniform(&seed) - 0.5, scale = k % 4 == 0   ? 1.0
                                                  : k % 4 == 1 ? 1e-8
                                                  : k % 4 == 2 ? 1e6
                                                               : 1e12;
    t[k] = k < 64 ? 0.125 * (k - 32) : scale * u;
    if (k % 16 == 5) t[k] = 0.25 * (k % 7) + 1e-9 * u; /* next to the zeros */
  }
  for (int p = 0; p < PATHS; p++) {
    const kernels *path = kernels_named(path_names[p]);
    if (!path) continue;
    path->motion->sine_cosine(t, N, s, c);
    double worst = 0.0;
    for (int k = 0; k < N; k++) {
      long double es, ec;
      exact_sine_cosine(t[k], &es, &ec);
      worst = fmax(worst, fmax(ulps(s[k], es), ulps(c[k], ec)));
      double one_s, one_c;
      sine_cosine_w1(t[k], &one_s, &one_c);
      assert_memory_equal(&one_s, &s[k], 8);
      assert_memory_equal(&one_c, &c[k], 8);
    }
    print_message("  %s: sine and cosine within %.3f ulp\n", path_names[p], worst);
    between(worst, 0, 2.0, "ulps of sine or cosine");
  }
  free(t);
  free(s);
  free(c);
}

enum { DRAWS = 1 << 20 };
static double first[DRAWS + 8], second[DRAWS + 8];

static int ascending(const void *a, const void *b) {
  double x = *(const double *)a, y = *(const double *)b;
  return (x > y) - (x < y);
}

/* Mean, and z-score of mean of f over n samples of known mean and variance. */
static double z_of(double sum, double n, double mean, double variance) {
  return (sum / n - mean) / sqrt(variance / n);
}

static void check_moments(const double *x, const char *what) {
  /* <x^2k> = (2k-1)!!: 1, 3, 15, 105, 945, 10395, 135135 */
  static const double even[] = {1, 1, 3, 15, 105, 945, 10395, 135135};
  for (int power = 1; power <= 6; power++) {
    double sum = 0.0, mean = power % 2 ? 0.0 : even[power / 2];
    for (int n = 0; n < DRAWS; n++) sum += pow(x[n], power);
    between(z_of(sum, DRAWS, mean, even[power] - mean * mean), -4, 4, what);
  }
}

static void normals_are_normal(void **unused) {
  kernels_choose()->motion->normals(2024, 17, RANDOM_STEP, 0, DRAWS, first, second);
  check_moments(first, "z of a moment of the first numbers");
  check_moments(second, "z of a moment of the second numbers");
  double tails[] = {2, 3, 4, 4.5};
  for (int k = 0; k < 4; k++) {
    double p = erfc(tails[k] / sqrt(2)), count = 0.0;
    for (int n = 0; n < DRAWS; n++)
      count += (fabs(first[n]) > tails[k]) + (fabs(second[n]) > tails[k]);
    between((count - 2 * p * DRAWS) / sqrt(2 * p * DRAWS), -4, 4, "z of a tail's count");
  }
  /* the radius is independent of the angle, and squares of the pair are uncorrelated */
  double product = 0.0, squares = 0.0;
  for (int n = 0; n < DRAWS; n++) {
    product += first[n] * second[n];
    squares += (first[n] * first[n] - 1) * (second[n] * second[n] - 1);
  }
  between(z_of(product, DRAWS, 0, 1), -4, 4, "z of <a b>");
  between(z_of(squares, DRAWS, 0, 4), -4, 4, "z of <(a^2-1)(b^2-1)>");
  /* Kolmogorov and Smirnov */
  qsort(first, DRAWS, sizeof *first, ascending);
  double d = 0.0;
  for (int n = 0; n < DRAWS; n++) {
    double cdf = gsl_cdf_ugaussian_P(first[n]);
    d = fmax(d, fmax(cdf - (double)n / DRAWS, (double)(n + 1) / DRAWS - cdf));
  }
  print_message("  Kolmogorov-Smirnov: sqrt(n) D = %.3f (1.63 at 1 per cent)\n", d * sqrt(DRAWS));
  between(d * sqrt(DRAWS), 0, 1.95, "sqrt(n) D");
}

/* Far out: 2^24 draws. */
static void tails_are_normal(void **unused) {
  const double limit[] = {4, 4.5, 5, 5.5, 6.8};
  double count[5] = {0}, n = 0.0;
  for (int part = 0; part < 16; part++) {
    kernels_choose()->motion->normals(1, 0, RANDOM_STEP, (int64_t)part * DRAWS, DRAWS, first,
                                      second);
    for (int k = 0; k < DRAWS; k++) {
      double a = fabs(first[k]), b = fabs(second[k]);
      for (int l = 0; fmax(a, b) > 4 && l < 5; l++) count[l] += (a > limit[l]) + (b > limit[l]);
    }
    n += 2.0 * DRAWS;
  }
  for (int l = 0; l < 4; l++) {
    double expected = 2 * gsl_cdf_ugaussian_Q(limit[l]) * n;
    print_message("  beyond %.1f: %.0f, expected %.1f\n", limit[l], count[l], expected);
    /* Poisson: both tails at 3e-5 */
    assert_true(gsl_cdf_poisson_P((unsigned)count[l], expected) > 3e-5);
    assert_true(gsl_cdf_poisson_Q((unsigned)count[l], expected) > 3e-5);
  }
  assert_true(count[4] == 0.0); /* no radius is larger */
}

/* The four numbers of a block, and those of the next one: products, and products of squares. */
static void numbers_of_a_block_are_independent(void **unused) {
  kernels_choose()->motion->normals(7, 3, RANDOM_STEP, 0, DRAWS, first, second);
  double plain[8][8] = {{0}}, squares[8][8] = {{0}}, n = DRAWS / 4.0, chi2 = 0.0, worst = 0.0;
  for (int k = 0; k + 4 <= DRAWS; k += 4) { /* two blocks */
    double x[8];
    for (int i = 0; i < 4; i++) x[2 * i] = first[k + i], x[2 * i + 1] = second[k + i];
    for (int i = 0; i < 8; i++)
      for (int j = 0; j < i; j++) {
        plain[i][j] += x[i] * x[j];
        squares[i][j] += (x[i] * x[i] - 1) * (x[j] * x[j] - 1);
      }
  }
  for (int i = 0; i < 8; i++)
    for (int j = 0; j < i; j++) {
      double z[] = {z_of(plain[i][j], n, 0, 1), z_of(squares[i][j], n, 0, 4)};
      for (int k = 0; k < 2; k++) {
        chi2 += z[k] * z[k];
        worst = fmax(worst, fabs(z[k]));
      }
    }
  print_message("  chi2/n of 56 correlations within two blocks: %.3f, largest |z| %.2f\n",
                chi2 / 56, worst);
  between((chi2 - 56) / sqrt(2.0 * 56), -4, 4, "z of chi2 of the correlations within blocks");
  between(worst, 0, 4.2, "largest correlation within blocks, z");
}

static double correlation(const double *x, const double *y, int n) {
  double sum = 0.0;
  for (int k = 0; k < n; k++) sum += x[k] * y[k];
  return sum / sqrt((double)n);
}

/* Streams, purposes, seeds and neighbouring draws that differ in one number have nothing in common. */
static void streams_are_independent(void **unused) {
  enum { N = 1 << 16, SETS = 24 };
  static double x[SETS][N + 8], y[SETS][N + 8];
  for (uint32_t k = 0; k < SETS; k++) {
    /* neighbouring streams, purposes, seeds (also above 2^32), and blocks of steps */
    uint64_t seed = k < 12 ? 5 : k < 18 ? 5 + k : 5 + ((uint64_t)k << 32);
    kernels_choose()->motion->normals(seed, k < 8 ? k : 0, k >= 8 && k < 10 ? k - 7 : 0,
                                      k == 10   ? N
                                      : k == 11 ? 2 * N
                                                : 0,
                                      N, x[k], y[k]);
  }
  double chi2 = 0.0, worst = 0.0;
  int number = 0;
  for (int i = 0; i < SETS; i++)
    for (int j = 0; j <= i; j++) {
      double z[] = {correlation(x[i], y[j], N), i == j ? 0 : correlation(x[i], x[j], N),
                    correlation(x[i], x[j] + 1, N - 1), correlation(y[i], x[j] + 1, N - 1)};
      for (int k = 0; k < 4; k++) {
        if (i == j && k == 1) continue;
        chi2 += z[k] * z[k];
        worst = fmax(worst, fabs(z[k]));
        number++;
      }
    }
  print_message("  chi2/n of %d correlations: %.3f, largest |z| %.2f\n", number, chi2 / number,
                worst);
  between((chi2 - number) / sqrt(2.0 * number), -4, 4,
          "z of chi2 of the correlations between streams");
  between(worst, 0, 4.6, "largest correlation between streams, z");
}

static void oscillators_do_not_depend_on_the_path(void **unused) {
  static oscillators start, g;
  static double u[OSCILLATORS][OSCILLATOR_ROWS], v[OSCILLATORS][OSCILLATOR_ROWS];
  enum { BLOCKS = 35, NEW = 2 * BLOCKS };
  uint64_t seed = 3;
  for (size_t l = 0; l < OSCILLATORS; l++) {
    double *number[] = {&start.uu[l],      &start.uv[l],       &start.vu[l],      &start.vv[l],
                        &start.noise_u[l], &start.noise_vu[l], &start.noise_vv[l]};
    for (int k = 0; k < 7; k++) *number[k] = 1.4 * next_uniform(&seed) - 0.7;
    for (int k = 0; k < 2; k++)
      start.u[k][l] = next_uniform(&seed), start.v[k][l] = next_uniform(&seed);
    start.seed[l] = next_bits(&seed);
    start.stream[l] = next_bits(&seed) >> 32;
    start.block[l] = next_bits(&seed) >> (l % 2 ? 30 : 40);
    if (l == 5) start.block[l] = ((uint64_t)3 << 32) - 11; /* the high word changes on the way */
  }
  for (int p = 0; p < PATHS; p++) {
    const kernels *path = kernels_named(path_names[p]);
    for (size_t count = 1; path && count <= OSCILLATORS; count++) {
      g = start;
      g.count = count;
      path->motion->oscillate(&g, 2, BLOCKS);
      path->motion->spread(&g, NEW + 2, u, v);
      for (size_t l = 0; l < count; l++) {
        double x = start.u[1][l], y = start.v[1][l], a[NEW], b[NEW];
        path->motion->normals(start.seed[l], (uint32_t)start.stream[l], RANDOM_STEP,
                              (int64_t)(2 * start.block[l]), NEW, a, b);
        for (size_t k = 0; k < NEW; k++) {
          double next = start.uu[l] * x + (start.uv[l] * y + start.noise_u[l] * a[k]);
          y = start.vv[l] * y +
              (start.vu[l] * x + (start.noise_vu[l] * a[k] + start.noise_vv[l] * b[k]));
          x = next;
          assert_memory_equal(&x, &g.u[k + 2][l], 8);
          assert_memory_equal(&y, &g.v[k + 2][l], 8);
          assert_memory_equal(&x, &u[l][k + 2], 8);
          assert_memory_equal(&y, &v[l][k + 2], 8);
        }
      }
    }
  }
}

RUN_TESTS(TEST(philox_is_random123s), TEST(normals_are_box_and_mullers),
          TEST(sine_and_cosine_are_accurate), TEST(normals_are_normal), TEST(tails_are_normal),
          TEST(numbers_of_a_block_are_independent), TEST(streams_are_independent),
          TEST(oscillators_do_not_depend_on_the_path))
