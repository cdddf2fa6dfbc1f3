/* test_kernels.c: the kernels of every instruction set: Philox against Random123, accuracy of sine, cosine
 * and logarithm, quality of the normal numbers, and the same bits from all of them. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

#include <cmocka.h>
#include <Random123/philox.h>

#include "deck_runs.h"
#include "physics/kernels.h"

#define LANE_WIDTH 1
#include "base/lane.h"
#include "base/vmath.h"
#undef LANE_WIDTH
#define LANE_WIDTH 2
#include "base/lane.h"
#include "base/vmath.h"
#undef LANE_WIDTH
#define LANE_WIDTH 4
#include "base/lane.h"
#include "base/vmath.h"
#undef LANE_WIDTH
#define LANE_WIDTH 8
#include "base/lane.h"
#include "base/vmath.h"
#undef LANE_WIDTH

enum { PATHS = 3 };
static const char *const path_names[PATHS] = {"baseline", "avx2", "avx512"};

/* --- Philox ------------------------------------------------------------------------------------------ */

/* One draw from Random123's own generator: counter = (index low, index high, stream, purpose), key = seed. */
static void reference_draw(uint64_t seed, uint32_t stream, uint32_t purpose, uint64_t index, double *a,
                           double *b) {
  philox4x32_ctr_t counter = {{(uint32_t)index, (uint32_t)(index >> 32), stream, purpose}};
  philox4x32_key_t key = {{(uint32_t)seed, (uint32_t)(seed >> 32)}};
  philox4x32_ctr_t out = philox4x32_R(10, counter, key);
  uint64_t first = (uint64_t)out.v[1] << 32 | out.v[0], second = (uint64_t)out.v[3] << 32 | out.v[2];
  double u = ((double)(first >> 12) + 0.5) * 0x1p-52, v = ((double)(second >> 12) + 0.5) * 0x1p-52, s, c;
  double r = sqrt(-2.0 * logarithm_w1(u));
  sine_cosine_w1(v, &s, &c);
  *a = r * c;
  *b = r * s;
}

static void philox_is_random123s(void **unused) {
  (void)unused;
  enum { N = 200 };
  const uint64_t seeds[] = {0, 1, 0xdeadbeefcafef00d, UINT64_MAX};
  const uint32_t streams[] = {0, 5, 0x12345678, UINT32_MAX};
  const int64_t firsts[] = {0, 3, 0xffffff80, ((int64_t)1 << 40) + 7};
  double a[N + 8], b[N + 8];
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
      k->normals(seed, stream, purpose, first, N, a, b);
      for (uint64_t n = 0; n < N; n++) {
        double x, y;
        reference_draw(seed, stream, purpose, (uint64_t)first + n, &x, &y);
        assert_memory_equal(&x, &a[n], 8);
        assert_memory_equal(&y, &b[n], 8);
      }
    }
  }
}

/* The same, through the C library in extended precision: Box and Muller as they are known. */
static void normals_are_box_and_mullers(void **unused) {
  (void)unused;
  enum { N = 100000 };
  double *a = malloc((N + 8) * sizeof *a), *b = malloc((N + 8) * sizeof *b), worst = 0.0;
  kernels_choose()->normals(99, 3, RANDOM_STEP, 0, N, a, b);
  const long double turn = 2 * acosl(-1.0L);
  for (uint32_t n = 0; n < N; n++) {
    philox4x32_ctr_t counter = {{n, 0, 3, RANDOM_STEP}};
    philox4x32_ctr_t out = philox4x32_R(10, counter, (philox4x32_key_t){{99, 0}});
    long double u = ((long double)(((uint64_t)out.v[1] << 32 | out.v[0]) >> 12) + 0.5L) * 0x1p-52L;
    long double v = ((long double)(((uint64_t)out.v[3] << 32 | out.v[2]) >> 12) + 0.5L) * 0x1p-52L;
    long double r = sqrtl(-2 * logl(u));
    double e = (double)fmaxl(fabsl(a[n] - r * cosl(turn * v)), fabsl(b[n] - r * sinl(turn * v))) / (double)r;
    worst = fmax(worst, e);
  }
  print_message("  largest error of a normal number / its radius: %.3g\n", worst);
  between(worst, 0, 4.5e-16, "error of a normal number / radius");
  free(a);
  free(b);
}

/* --- elementary functions ---------------------------------------------------------------------------- */

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
  (void)unused;
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
    path->sine_cosine(t, N, s, c);
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

static void logarithm_is_accurate_in_every_width(void **unused) {
  (void)unused;
  enum { N = 400000 };
  uint64_t seed = 11;
  double worst = 0.0;
  for (int k = 0; k < N / 8; k++) {
    double x[8];
    for (int l = 0; l < 8; l++) {
      double u = next_uniform(&seed);
      x[l] = l == 0   ? 0x1p-53 * (1.0 + 1000 * u)
             : l == 1 ? 1.0 - 1e-6 * u
             : l == 2 ? 1.0 - 0x1p-53 * (double)(k + 1)
             : l == 3 ? ldexp(1.0 + u, k % 2000 - 1000)
             : l == 4 ? sqrt(0.5) + 1e-10 * (u - 0.5)
                      : u + 0x1p-53;
    }
    double y8[8], y4[8], y2[8];
    store_w8(y8, logarithm_w8(load_w8(x)));
    for (int l = 0; l < 8; l += 4) store_w4(y4 + l, logarithm_w4(load_w4(x + l)));
    for (int l = 0; l < 8; l += 2) store_w2(y2 + l, logarithm_w2(load_w2(x + l)));
    for (int l = 0; l < 8; l++) {
      double y = logarithm_w1(x[l]);
      assert_memory_equal(&y, &y8[l], 8);
      assert_memory_equal(&y, &y4[l], 8);
      assert_memory_equal(&y, &y2[l], 8);
      worst = fmax(worst, ulps(y, logl(x[l])));
    }
  }
  print_message("  logarithm within %.3f ulp\n", worst);
  between(worst, 0, 1.0, "ulps of the logarithm");
}

/* --- quality of the normal numbers ------------------------------------------------------------------- */

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
  (void)unused;
  kernels_choose()->normals(2024, 17, RANDOM_STEP, 0, DRAWS, first, second);
  check_moments(first, "z of a moment of the first numbers");
  check_moments(second, "z of a moment of the second numbers");
  double tails[] = {2, 3, 4, 4.5};
  for (int k = 0; k < 4; k++) {
    double p = erfc(tails[k] / sqrt(2)), count = 0.0;
    for (int n = 0; n < DRAWS; n++) count += (fabs(first[n]) > tails[k]) + (fabs(second[n]) > tails[k]);
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
    double cdf = 0.5 * erfc(-first[n] / sqrt(2));
    d = fmax(d, fmax(cdf - (double)n / DRAWS, (double)(n + 1) / DRAWS - cdf));
  }
  print_message("  Kolmogorov-Smirnov: sqrt(n) D = %.3f (1.63 at 1 per cent)\n", d * sqrt(DRAWS));
  between(d * sqrt(DRAWS), 0, 1.95, "sqrt(n) D");
}

static double correlation(const double *x, const double *y, int n) {
  double sum = 0.0;
  for (int k = 0; k < n; k++) sum += x[k] * y[k];
  return sum / sqrt((double)n);
}

/* Streams, purposes, seeds and neighbouring draws that differ in one number have nothing in common. */
static void streams_are_independent(void **unused) {
  (void)unused;
  enum { N = 1 << 16, SETS = 24 };
  static double x[SETS][N + 8], y[SETS][N + 8];
  for (uint32_t k = 0; k < SETS; k++) {
    /* neighbouring streams, purposes, seeds (also above 2^32), and blocks of steps */
    uint64_t seed = k < 12 ? 5 : k < 18 ? 5 + k : 5 + ((uint64_t)k << 32);
    kernels_choose()->normals(seed, k < 8 ? k : 0, k >= 8 && k < 10 ? k - 7 : 0,
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
  print_message("  chi2/n of %d correlations: %.3f, largest |z| %.2f\n", number, chi2 / number, worst);
  between((chi2 - number) / sqrt(2.0 * number), -4, 4, "z of chi2 of the correlations between streams");
  between(worst, 0, 4.6, "largest correlation between streams, z");
}

/* --- all paths, the same bits ------------------------------------------------------------------------ */

static void oscillators_do_not_depend_on_the_path(void **unused) {
  (void)unused;
  static oscillators start, g;
  uint64_t seed = 3;
  for (size_t l = 0; l < OSCILLATORS; l++) {
    double *number[] = {&start.uu[l],      &start.uv[l],       &start.vu[l],      &start.vv[l],
                        &start.noise_u[l], &start.noise_vu[l], &start.noise_vv[l]};
    for (int k = 0; k < 7; k++) *number[k] = 1.4 * next_uniform(&seed) - 0.7;
    for (int k = 0; k < 2; k++) start.u[l][k] = next_uniform(&seed), start.v[l][k] = next_uniform(&seed);
    for (int k = 0; k < OSCILLATOR_DRAWS; k++)
      start.normal1[l][k] = next_uniform(&seed) - 0.5, start.normal2[l][k] = next_uniform(&seed) - 0.5;
  }
  for (int p = 0; p < PATHS; p++) {
    const kernels *path = kernels_named(path_names[p]);
    for (size_t count = 1; path && count <= OSCILLATORS; count++) {
      g = start;
      g.count = count;
      path->oscillate(&g, OSCILLATOR_DRAWS - 2);
      for (size_t l = 0; l < count; l++) {
        double u = start.u[l][1], v = start.v[l][1];
        for (size_t k = 0; k < OSCILLATOR_DRAWS - 2; k++) {
          double a = start.normal1[l][k], b = start.normal2[l][k];
          double next = start.uu[l] * u + (start.uv[l] * v + start.noise_u[l] * a);
          v = start.vv[l] * v + (start.vu[l] * u + (start.noise_vu[l] * a + start.noise_vv[l] * b));
          u = next;
          assert_memory_equal(&u, &g.u[l][k + 2], 8);
          assert_memory_equal(&v, &g.v[l][k + 2], 8);
        }
      }
    }
  }
}

/* A box with everything in it: round and straight walls, two materials, random and harmonic motions. */
static sd_model *packing(int n, const char *integrator, const char *variant) {
  text t = {0};
  text_add(&t,
           "dt = 2e-5; seed = 77; integrator = \"%s\"; contact_variant = \"%s\"; gravity = { g = 9.81; tilt "
           "= 0.1; };\n",
           integrator, variant);
  text_add(&t, "materials = ( { name = \"a\"; k_n = 1e4; k_t = 5e3; gamma_n = 2; mu = 0.5; },"
               "{ name = \"b\"; k_n = 2e4; k_t = 1e4; gamma_n = 1; mu = 0.2; } );\n"
               "material_pairs = ( { materials = (\"a\", \"b\"); k_n = 1.5e4; k_t = 8e3; gamma_n = 3; mu = "
               "0.3; } );\n");
  text_add(
      &t, "disk_rows = ( { columns = (\"x\", \"y\", \"radius\"); density = 3.57; material = \"a\"; rows = (");
  add_lattice(&t, n, 9, 0.03, 0.03, 0.042, 0.02, 5);
  text_add(&t, "); } );\nwalls = ( { name = \"box\"; type = \"polyline\"; material = \"b\"; points = ((0, "
               "1), (0, 0), (0.4, 0), (0.4, 1)); },\n"
               "{ name = \"knob\"; type = \"circle\"; material = \"b\"; center = (0.2, -0.03); radius = "
               "0.04; side = \"outside\"; } );\n"
               "motions = ( { wall = \"box\"; coordinate = \"y\"; type = \"harmonic\"; amplitude = 2e-4; "
               "frequency = 80; },\n"
               "{ wall = \"knob\"; coordinate = (\"y\", \"theta\"); type = \"random\"; amplitude = 1e-3; "
               "frequency = 40; } );\n"
               "steps = 10000;\n");
  sd_model *model = model_of(t.s);
  free(t.s);
  return model;
}

static void runs_do_not_depend_on_the_path(void **unused) {
  (void)unused;
  const int sizes[] = {1, 3, 9, 61};
  for (int c = 0; c < 16; c++) {
    sd_model *model = packing(sizes[c / 4], c & 1 ? "verlet" : "gear5", c & 2 ? "conservative" : "paper");
    uint64_t hash = 0;
    for (int p = 0; p < PATHS; p++) {
      if (!kernels_named(path_names[p])) continue;
      setenv("SLIPDISK_PATH", path_names[p], 1);
      sd_simulation *sim = begin_run(model, 1);
      assert_string_equal(sd_simulation_path(sim), path_names[p]);
      advance(sim, 3000);
      uint64_t now = sd_state_hash(sd_simulation_state(sim));
      if (p == 0) hash = now;
      assert_int_equal(now, hash);
      sd_simulation_free(sim);
    }
    unsetenv("SLIPDISK_PATH");
    sd_model_free(model);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(philox_is_random123s),
      cmocka_unit_test(normals_are_box_and_mullers),
      cmocka_unit_test(sine_and_cosine_are_accurate),
      cmocka_unit_test(logarithm_is_accurate_in_every_width),
      cmocka_unit_test(normals_are_normal),
      cmocka_unit_test(streams_are_independent),
      cmocka_unit_test(oscillators_do_not_depend_on_the_path),
      cmocka_unit_test(runs_do_not_depend_on_the_path),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
