/* test_generators.c: radii against their distributions; lattices, random placement and fronts as geometry. */
#include <gsl/gsl_cdf.h>
#include <gsl/gsl_integration.h>
#include <gsl/gsl_math.h>
#include <gsl/gsl_randist.h>
#include <gsl/gsl_sort_double.h>
#include <gsl/gsl_statistics_double.h>

#include "unit.h"
#include "model/rows.h"
#include "pack/place.h"
#include "pack/sizes.h"
#include "pack/tiles.h"

enum { DRAWS = 40000 };

static void near_to(double value, double expected, double tolerance, const char *what) {
  if (fabs(value - expected) <= tolerance) return;
  print_error("%s: %.12g, expected %.12g within %.2g\n", what, value, expected, tolerance);
  fail();
}

/* Density before the cut, up to a factor. */
static double density_at(double r, const sizes *s) {
  switch (s->kind) {
    case SD_SIZES_GAUSSIAN: return gsl_ran_gaussian_pdf(r - s->radius, s->deviation);
    case SD_SIZES_LOGNORMAL: return gsl_ran_lognormal_pdf(r, log(s->radius), s->deviation);
    case SD_SIZES_POWERLAW: return pow(r, -s->exponent);
    default: return 1;
  }
}

typedef struct moment {
  const sizes *s;
  int power;
} moment;

static double moment_at(double r, void *user) {
  const moment *m = user;
  return gsl_pow_int(r, m->power) * density_at(r, m->s);
}

/* Integral of R^power p(R) from lower to r. */
static double integral(const sizes *s, int power, double r) {
  gsl_integration_glfixed_table *table = gsl_integration_glfixed_table_alloc(64);
  moment m = {s, power};
  gsl_function f = {moment_at, &m};
  double sum = 0;
  for (int k = 0; k < 8; k++)
    sum += gsl_integration_glfixed(&f, s->lower + (r - s->lower) * k / 8,
                                   s->lower + (r - s->lower) * (k + 1) / 8, table);
  gsl_integration_glfixed_table_free(table);
  return sum;
}

static void check_distribution(const char *name, const sizes *s) {
  static double radius[DRAWS];
  gsl_rng *rng = sizes_random(17, 0);
  sizes_draw(s, rng, DRAWS, radius);
  gsl_rng_free(rng);
  double all = integral(s, 0, s->upper), mean = integral(s, 1, s->upper) / all;
  double square = integral(s, 2, s->upper) / all, fourth = integral(s, 4, s->upper) / all;
  double variance = square - mean * mean;
  near_to(gsl_stats_mean(radius, 1, DRAWS), mean, 4 * sqrt(variance / DRAWS), name);
  /* the mean of R^2, whose error is known, in place of the variance */
  double sum = 0;
  for (size_t k = 0; k < DRAWS; k++) sum += radius[k] * radius[k] / DRAWS;
  near_to(sum, square, 4 * sqrt((fourth - square * square) / DRAWS), name);
  near_to(sizes_mean_area(s), M_PI * square, 1e-7 * M_PI * square, name);
  /* largest distance of the two cumulative distributions: beyond 1.95/sqrt(n) once in 1000 times */
  gsl_sort(radius, 1, DRAWS);
  assert_true(radius[0] >= s->lower && radius[DRAWS - 1] <= s->upper);
  double distance = 0;
  for (size_t k = 0; k < DRAWS; k += 20)
    distance = fmax(distance, fabs(integral(s, 0, radius[k]) / all - (k + 0.5) / DRAWS));
  if (distance * sqrt(DRAWS) > 1.95) {
    print_error("%s: cumulative distributions differ by %g/sqrt(n)\n", name,
                distance * sqrt(DRAWS));
    fail();
  }
  /* the quantiles are those of the distribution, digit by digit, also near the ends */
  for (int k = 0; k <= 10; k++) {
    double u = k == 0 ? 1e-6 : k == 10 ? 1 - 1e-6 : 0.1 * k;
    near_to(integral(s, 0, sizes_quantile(s, u)) / all, u, 1e-9, name);
  }
}

static void test_sizes(void **state) {
  check_distribution("uniform", &(sizes){.kind = SD_SIZES_UNIFORM, .lower = 1, .upper = 3});
  check_distribution(
      "gaussian",
      &(sizes){
          .kind = SD_SIZES_GAUSSIAN, .radius = 2, .deviation = 0.5, .lower = 0.5, .upper = 3.5});
  check_distribution(
      "gaussian cut on one side",
      &(sizes){
          .kind = SD_SIZES_GAUSSIAN, .radius = 2, .deviation = 0.5, .lower = 3.2, .upper = 4.5});
  check_distribution("lognormal", &(sizes){.kind = SD_SIZES_LOGNORMAL,
                                           .radius = 1,
                                           .deviation = 0.4,
                                           .lower = exp(-1.2),
                                           .upper = exp(1.2)});
  static const double exponents[] = {-2, 0, 1 - 1e-9, 1, 1.001, 2.5, 4};
  for (size_t k = 0; k < sizeof exponents / sizeof *exponents; k++)
    check_distribution(
        "powerlaw",
        &(sizes){.kind = SD_SIZES_POWERLAW, .exponent = exponents[k], .lower = 0.5, .upper = 4});
}

/* Symmetric cuts keep the mean, and a steep power stays finite. */
static void test_size_limits(void **state) {
  sizes s = {.kind = SD_SIZES_GAUSSIAN, .radius = 2, .deviation = 0.5, .lower = 0.5, .upper = 3.5};
  near_to(sizes_quantile(&s, 0.5), 2, 1e-12, "median");
  near_to(sizes_kept(&s), 0.99730020393674, 1e-12, "part within 3 deviations");
  s.lower = 6;
  s.upper = 7;
  assert_true(sizes_kept(&s) > 0 && sizes_kept(&s) < 1e-14);
  sizes p = {.kind = SD_SIZES_POWERLAW, .exponent = 2000, .lower = 1, .upper = 3};
  for (int k = 0; k < 100; k++)
    assert_true(sizes_quantile(&p, 0.01 * k) >= 1 && sizes_quantile(&p, 0.01 * k) < 1.01);
  p.exponent = -2000;
  for (int k = 1; k < 100; k++)
    assert_true(sizes_quantile(&p, 0.01 * k) > 2.99 && sizes_quantile(&p, 0.01 * k) <= 3);
}

static void test_list(void **state) {
  const double radii[] = {1, 2, 3, 4}, weights[] = {1, 0, 2, 3};
  sizes s = {
      .kind = SD_SIZES_LIST, .n = 4, .radii = radii, .weights = weights, .lower = 1, .upper = 4};
  for (size_t n = 1; n < 40; n++) {
    double radius[40];
    size_t count[5] = {0};
    gsl_rng *rng = sizes_random(n, 3);
    sizes_draw(&s, rng, n, radius);
    gsl_rng_free(rng);
    for (size_t k = 0; k < n; k++) count[(size_t)radius[k]]++;
    for (size_t k = 0; k < 4; k++) assert_true(fabs((double)count[k + 1] - n * weights[k] / 6) < 1);
    assert_int_equal(count[2], 0);
  }
  near_to(sizes_mean_area(&s), M_PI * (1 + 2 * 9 + 3 * 16) / 6, 1e-12, "mean area");
}

/* Not sorted: the mean place of each radius is that of a shuffled deck. */
static void test_list_is_shuffled(void **state) {
  enum { N = 10000, HALF = N / 2 };
  static double radius[N];
  const double radii[] = {1, 2}, weights[] = {1, 1};
  sizes s = {
      .kind = SD_SIZES_LIST, .n = 2, .radii = radii, .weights = weights, .lower = 1, .upper = 2};
  gsl_rng *rng = sizes_random(1, 0);
  sizes_draw(&s, rng, N, radius);
  gsl_rng_free(rng);
  double place = 0;
  for (size_t k = 0; k < N; k++) place += radius[k] > 1.5 ? (double)k / HALF : 0;
  near_to(place / N, 0.5, 4 * 0.29 / sqrt(HALF), "mean place");
}

static void test_seeds(void **state) {
  double first[3][2];
  for (int k = 0; k < 3; k++) {
    gsl_rng *rng = sizes_random(k == 1 ? 2 : 1, k == 2);
    for (int j = 0; j < 2; j++) first[k][j] = gsl_rng_uniform(rng);
    gsl_rng_free(rng);
  }
  for (int a = 0; a < 3; a++)
    for (int b = 0; b < a; b++)
      assert_true(first[a][0] != first[b][0] && first[a][1] != first[b][1]);
}

/* An empty model, with a periodic box from 0 to `box` where that is > 0. */
static sd_model model_of(double box_x, double box_y) {
  return (sd_model){.periodic = {box_x > 0, box_y > 0}, .upper = {box_x, box_y}};
}

static double apart(const sd_model *m, const double *a, const double *b) {
  double square = 0;
  for (int c = 0; c < 2; c++) {
    double d = fabs(a[c] - b[c]), length = m->upper[c] - m->lower[c];
    if (m->periodic[c]) d = fmin(d, length - d);
    square += d * d;
  }
  return sqrt(square);
}

/* Every pair, and every edge: no overlap beyond rounding. */
static void check_clear(const sd_model *m, const double *lower, const double *upper, size_t n,
                        const double *radius, double (*position)[2]) {
  for (size_t i = 0; i < n; i++) {
    for (int c = 0; c < 2; c++) {
      double x = position[i][c], margin = m->periodic[c] ? 0 : radius[i] * (1 - 1e-9);
      assert_true(x - margin >= lower[c] && x + margin <= upper[c]);
      if (m->periodic[c]) assert_true(x < upper[c]);
    }
    for (size_t j = 0; j < i; j++) {
      double least = (radius[i] + radius[j]) * (1 - 1e-9), r = apart(m, position[i], position[j]);
      if (r >= least) continue;
      print_error("disks %zu and %zu are %g apart, radii %g and %g\n", i, j, r, radius[i],
                  radius[j]);
      fail();
    }
  }
}

static size_t lattice(const sd_model *m, sd_packing_kind kind, double width, double height,
                      double spacing, double jitter, double (*position)[2], size_t most) {
  const double lower[2] = {0, 0}, upper[2] = {width, height};
  container inside = {0};
  place_space s;
  assert_int_equal(place_begin(&s, m, m->n_disks, &inside, lower, upper, most), SD_OK);
  size_t n = lattice_sites(&s, kind, spacing, most, position);
  double *radius = malloc((n + 1) * sizeof *radius);
  assert_non_null(radius);
  for (size_t k = 0; k < n; k++) radius[k] = k % 3 ? 0.5 * spacing : 0.35 * spacing;
  gsl_rng *rng = sizes_random(5, 0);
  lattice_jitter(&s, rng, spacing, jitter, n, radius, position);
  gsl_rng_free(rng);
  place_end(&s);
  check_clear(m, lower, upper, n, radius, position);
  free(radius);
  return n;
}

static void test_lattices(void **state) {
  enum { MOST = 400 };
  double p[MOST][2];
  sd_model open = model_of(0, 0), channel = model_of(10, 0), full = model_of(10, 10);
  /* 10 columns; 11 rows of height sqrt(3)/2, of 10 and 9 in turn; the last 5 of a square one */
  assert_int_equal(lattice(&open, SD_PACKING_SQUARE, 10, 10, 1, 0, p, MOST), 100);
  near_to(p[0][0], 0.5, 1e-12, "x of the first site");
  near_to(p[99][1], 9.5, 1e-12, "y of the last site");
  assert_int_equal(lattice(&open, SD_PACKING_TRIANGULAR, 10, 10, 1, 0, p, MOST), 105);
  near_to(p[10][1], 0.5 + sqrt(0.75), 1e-12, "y of the second row");
  near_to(p[10][0], 1, 1e-12, "x of the second row");
  assert_int_equal(lattice(&open, SD_PACKING_TRIANGULAR, 10.5, 10, 1, 0, p, MOST), 110);
  assert_int_equal(lattice(&open, SD_PACKING_TRIANGULAR, 10, 10, 1, 0, p, 25), 25);
  assert_int_equal(lattice(&open, SD_PACKING_TRIANGULAR, 1, 1, 1, 0, p, MOST), 1);
  assert_int_equal(lattice(&open, SD_PACKING_TRIANGULAR, 0.99, 10, 1, 0, p, MOST), 0);
  /* periodic: as many as fit, the rest is shared */
  assert_int_equal(lattice(&channel, SD_PACKING_TRIANGULAR, 10, 10, 1.02, 0, p, MOST), 9 * 11);
  near_to(p[1][0] - p[0][0], 10.0 / 9, 1e-12, "stretched spacing");
  assert_int_equal(lattice(&full, SD_PACKING_TRIANGULAR, 10, 10, 1, 0, p, MOST), 100);
  near_to(p[10][1] - p[0][1], 1, 1e-12, "rows of the periodic lattice");
  assert_int_equal(lattice(&full, SD_PACKING_SQUARE, 10, 10, 1, 0, p, MOST), 100);
}

/* With jitter 1 disks stay in their own circles, in every direction, and use them. */
static void test_jitter(void **state) {
  enum { MOST = 400 };
  double still[MOST][2], p[MOST][2], longest = 0, sum = 0;
  sd_model open = model_of(0, 0), full = model_of(10, 10);
  size_t n = lattice(&open, SD_PACKING_SQUARE, 20, 20, 1, 0, still, MOST), moved = 0;
  assert_int_equal(lattice(&open, SD_PACKING_SQUARE, 20, 20, 1, 1, p, MOST), n);
  for (size_t k = 0; k < n; k++) {
    double way = hypot(p[k][0] - still[k][0], p[k][1] - still[k][1]);
    if (k % 3) assert_true(way < 1e-12); /* no room */
    if (k % 3) continue;
    moved++;
    sum += way * way;
    longest = fmax(longest, way);
  }
  assert_true(longest <= 0.15 * (1 + 1e-12) && longest > 0.14);
  /* the mean square of the distance in a disk is half its radius squared, with a variance of 1/12 */
  near_to(sum / moved / (0.15 * 0.15), 0.5, 4 * sqrt(1 / 12.0 / moved), "mean square displacement");
  lattice(&full, SD_PACKING_TRIANGULAR, 10, 10, 1, 1, p, MOST);
}

enum { N = 2400 };
static double radius[N], position[N][2];

static size_t generate(const sd_model *m, const container *inside, const double *lower,
                       const double *upper, bool front, size_t n, const sizes *s) {
  place_space space;
  size_t placed = 0;
  gsl_rng *rng = sizes_random(3, 0);
  sizes_draw(s, rng, n, radius);
  assert_int_equal(place_begin(&space, m, m->n_disks, inside, lower, upper, n), SD_OK);
  if (front)
    assert_int_equal(front_fill(&space, n, radius, position, &placed), SD_OK);
  else
    assert_int_equal(place_random(&space, rng, n, radius, position, &placed), SD_OK);
  gsl_rng_free(rng);
  place_end(&space);
  return placed;
}

static double area_of(size_t n) {
  double sum = 0;
  for (size_t k = 0; k < n; k++) sum += M_PI * radius[k] * radius[k];
  return sum;
}

static const sizes wide = {.kind = SD_SIZES_POWERLAW, .exponent = 2, .lower = 0.1, .upper = 1.5};
static const sizes narrow = {.kind = SD_SIZES_UNIFORM, .lower = 0.35, .upper = 0.65};

static void test_random(void **state) {
  const double lower[2] = {0, 0}, upper[2] = {30, 30};
  container inside = {0};
  for (int box = 0; box < 3; box++) {
    sd_model m = model_of(box > 0 ? 30 : 0, box > 1 ? 30 : 0);
    for (int k = 0; k < 2; k++) {
      size_t n = k ? 500 : 900;
      assert_int_equal(generate(&m, &inside, lower, upper, false, n, k ? &narrow : &wide), n);
      check_clear(&m, lower, upper, n, radius, position);
    }
  }
}

/* Random sequential addition ends: the fraction of equal disks stays below 0.547, and what was placed is clear. */
static void test_random_ends(void **state) {
  const double lower[2] = {0, 0}, upper[2] = {20, 20};
  container inside = {0};
  sd_model m = model_of(20, 20);
  sizes s = {.kind = SD_SIZES_MONO, .radius = 0.5, .lower = 0.5, .upper = 0.5};
  size_t placed = generate(&m, &inside, lower, upper, false, 400, &s), at = 0;
  double fraction = placed * M_PI / 4 / 400;
  assert_true(fraction > 0.5 && fraction < 0.56);
  for (size_t k = 0; k < 400; k++) {
    if (isnan(position[k][0])) continue;
    for (int c = 0; c < 2; c++) position[at][c] = position[k][c];
    at++;
  }
  assert_int_equal(at, placed);
  check_clear(&m, lower, upper, placed, radius, position);
}

/* Bodies that disk k touches: disks, and edges of the region. */
static int touching(const sd_model *m, const double *lower, const double *upper, size_t n,
                    size_t k) {
  int count = 0;
  double slack = 1e-7 * radius[k];
  for (size_t j = 0; j < n; j++)
    if (j != k && apart(m, position[j], position[k]) < radius[j] + radius[k] + slack) count++;
  if (position[k][1] - radius[k] < lower[1] + slack) count++;
  for (int side = 0; side < 2 && !m->periodic[0]; side++)
    if (fabs(position[k][0] - (side ? upper : lower)[0]) < radius[k] + slack) count++;
  return count;
}

static void test_front(void **state) {
  const double lower[2] = {0, 0}, upper[2] = {24, 28};
  container inside = {0};
  for (int box = 0; box < 3; box++)
    for (int k = 0; k < 2; k++) {
      sd_model m = model_of(box > 0 ? 24 : 0, box > 1 ? 28 : 0);
      const sizes *s = k ? &narrow : &wide;
      size_t n = generate(&m, &inside, lower, upper, true, N, s);
      assert_true(n > 500 && n < N); /* full */
      check_clear(&m, lower, upper, n, radius, position);
      for (size_t i = 1; i < n; i++) assert_true(touching(&m, lower, upper, n, i) >= 2);
      double fraction = area_of(n) / (24 * 28);
      assert_true(fraction > 0.76 && fraction < 0.9);
    }
}

/* All radii that were drawn are placed, in another order only. */
static void test_front_keeps_radii(void **state) {
  const double lower[2] = {0, 0}, upper[2] = {24, 150};
  container inside = {0};
  sd_model m = model_of(0, 0);
  static double drawn[N];
  assert_int_equal(generate(&m, &inside, lower, upper, true, N, &narrow), N);
  gsl_rng *rng = sizes_random(3, 0);
  sizes_draw(&narrow, rng, N, drawn);
  gsl_rng_free(rng);
  gsl_sort(drawn, 1, N);
  gsl_sort(radius, 1, N);
  assert_memory_equal(drawn, radius, sizeof drawn);
}

/* Equal disks on a floor of a whole number of diameters: the triangular lattice, layer by layer. */
static void test_front_of_equal_disks(void **state) {
  const double lower[2] = {0, 0}, upper[2] = {10.5, 11};
  container inside = {0};
  sd_model m = model_of(0, 0);
  sizes s = {.kind = SD_SIZES_MONO, .radius = 0.5, .lower = 0.5, .upper = 0.5};
  assert_int_equal(generate(&m, &inside, lower, upper, true, 200, &s),
                   120); /* the 12th row ends at 10.53 */
  for (size_t k = 0; k < 120; k++) {
    double row = (position[k][1] - 0.5) / sqrt(0.75);
    near_to(row, rint(row), 1e-9, "row of the lattice");
  }
}

static void test_obstacles(void **state) {
  const double lower[2] = {0, 0}, upper[2] = {20, 20};
  container inside = {0};
  sd_model m = model_of(20, 0);
  /* a large disk across the edge of the box, one that waits, a peg and a piece of wall */
  sd_disk disks[2] = {{.position = {19.5, 6}, .radius = 3},
                      {.position = {10, 10}, .radius = 4, .waiting = true}};
  double points[2][2] = {{4, 12}, {14, 9}};
  sd_wall walls[2] = {{.kind = SD_WALL_CIRCLE, .pivot = {0.5, 17}, .radius = 2},
                      {.kind = SD_WALL_SEGMENT, .n_points = 2, .points = points}};
  m.disks = disks;
  m.n_disks = 2;
  m.walls = walls;
  m.n_walls = 2;
  for (int front = 0; front < 2; front++) {
    size_t n = generate(&m, &inside, lower, upper, front, front ? 600 : 150, &narrow);
    if (!front) assert_int_equal(n, 150);
    check_clear(&m, lower, upper, n, radius, position);
    bool middle = false;
    for (size_t k = 0; k < n; k++) {
      double least = radius[k] * (1 - 1e-9);
      assert_true(apart(&m, position[k], disks[0].position) >= 3 + least);
      assert_true(apart(&m, position[k], walls[0].pivot) >= 2 + least);
      double along = ((position[k][0] - 4) * 10 + (position[k][1] - 12) * -3) / 109;
      along = fmax(0, fmin(1, along));
      assert_true(hypot(position[k][0] - 4 - 10 * along, position[k][1] - 12 + 3 * along) >= least);
      middle |= hypot(position[k][0] - 10, position[k][1] - 10) < 4;
    }
    assert_true(middle); /* where a disk waits there is room */
  }
}

/* Half the width of a symmetric container at height y; negative: outside. */
static double half_width(const container *c, double y) {
  double span[2];
  if (!container_span(c, y, span)) return -1;
  assert_true(span[0] == -span[1]);
  return span[1];
}

static void test_interiors(void **state) {
  container drum = {.kind = SD_CONTAINER_DRUM, .origin = {1, 2}, .radius = 5};
  container_shape(&drum);
  const double low[2] = {-4, -3}, high[2] = {6, 7}, half_low[2] = {1, -3}, half_high[2] = {6, 2};
  near_to(container_area(&drum, low, high), M_PI * 25, 1e-6, "area of a drum");
  near_to(container_area(&drum, half_low, half_high), M_PI * 25 / 4, 1e-6, "area of a quarter");
  near_to(half_width(&drum, 5), 4, 1e-12, "half a chord");
  assert_true(half_width(&drum, 7.1) < 0);
  /* 2 at the outlet, 8 from y = 3 on */
  container hopper = {
      .kind = SD_CONTAINER_HOPPER, .width = 8, .height = 10, .outlet = 2, .open = true};
  hopper.angle = M_PI / 4;
  container_shape(&hopper);
  const double lower[2] = {-4, 0}, upper[2] = {4, 10};
  near_to(container_area(&hopper, lower, upper), 5 * 3 + 8 * 7, 1e-6, "area of a hopper");
  near_to(half_width(&hopper, 1.5), 2.5, 1e-12, "half the width of a hopper");
  assert_true(half_width(&hopper, -0.1) < 0);
  container box = {0};
  near_to(container_area(&box, lower, upper), 80, 1e-12, "area of a rectangle");
}

/* The drum's wall keeps disks in; in the corners of its square there are none. */
static void test_drum(void **state) {
  container drum = {.kind = SD_CONTAINER_DRUM, .origin = {3, 0}, .radius = 9};
  container_shape(&drum);
  sd_wall wall = {.kind = SD_WALL_CIRCLE, .pivot = {3, 0}, .radius = 9, .inside = true};
  const double lower[2] = {-6, -9}, upper[2] = {12, 9};
  sd_model m = model_of(0, 0);
  m.walls = &wall;
  m.n_walls = 1;
  for (int front = 0; front < 2; front++) {
    size_t n = generate(&m, &drum, lower, upper, front, front ? 500 : 100, &narrow);
    assert_true(front ? n > 200 && n < 500 : n == 100);
    check_clear(&m, lower, upper, n, radius, position);
    double fraction = area_of(n) / (M_PI * 81);
    if (front) assert_true(fraction > 0.74 && fraction < 0.9);
    for (size_t k = 0; k < n; k++)
      assert_true(hypot(position[k][0] - 3, position[k][1]) <= 9 - radius[k] * (1 - 1e-9));
  }
}

static void test_waiting(void **state) {
  double p[100][2];
  place_waiting(-3, 3, 10, 1.05, 0, 100, p);
  for (size_t i = 0; i < 100; i++) {
    assert_true(p[i][0] >= -3 + 0.525 && p[i][0] <= 3 - 0.525 && p[i][1] >= 10);
    for (size_t j = 0; j < i; j++)
      assert_true(hypot(p[i][0] - p[j][0], p[i][1] - p[j][1]) > 1.04999);
  }
  near_to(p[99][1], 10 + 19 * 1.05, 1e-9, "the last row"); /* 5 in a row */
}

/* Tiles know nothing of each other, but of what was there; together they are clear, and each is the same whoever makes it. */
static void test_tiles(void **state) {
  static const sd_packing_kind kinds[] = {SD_PACKING_SQUARE, SD_PACKING_TRIANGULAR,
                                          SD_PACKING_RANDOM, SD_PACKING_FRONT};
  enum { MOST = 400, TILES = 7 };
  sd_disk there = {.position = {0.5, 10, 0}, .radius = 3}; /* also at the other end of the box */
  for (size_t k = 0; k < sizeof kinds / sizeof *kinds; k++) {
    sd_model m = model_of(40, 0);
    m.n_disks = 1;
    m.disks = &there;
    m.seed = 3;
    m.tiles = (sd_tiles){.n = TILES, .first = 1, .count = MOST, .upper = {40, 40}, .most = 0.6};
    const packing_spec spec = {.kind = kinds[k],
                               .spacing = 1.3,
                               .jitter = 1,
                               .density = 2,
                               .sizes = {.kind = SD_SIZES_LIST,
                                         .lower = 0.4,
                                         .upper = 0.6,
                                         .n = 2,
                                         .radii = (const double[]){0.4, 0.6},
                                         .weights = (const double[]){1, 3}}};
    sd_disk disks[MOST], again[MOST];
    size_t placed;
    for (size_t t = TILES; t-- > 0;) {
      const size_t first = model_tile_begin(&m.tiles, t),
                   n = model_tile_begin(&m.tiles, t + 1) - first;
      assert_int_equal(n, MOST / TILES + (t < MOST % TILES));
      assert_int_equal(tiles_make(&m, &spec, t, disks, &placed), SD_OK);
      assert_int_equal(placed, n);
      assert_int_equal(tiles_make(&m, &spec, t, again, &placed), SD_OK);
      assert_memory_equal(again, disks, n * sizeof *again);
      for (size_t i = 0; i < n; i++) {
        radius[first + i] = disks[i].radius;
        for (int c = 0; c < 2; c++) position[first + i][c] = disks[i].position[c];
      }
      for (size_t i = first; i < first + n; i++) {
        assert_true(position[i][0] - radius[i] >= 40.0 * t / TILES - 1e-9);
        assert_true(position[i][0] + radius[i] <= 40.0 * (t + 1) / TILES + 1e-9);
        assert_true(apart(&m, position[i], there.position) >= (radius[i] + 3) * (1 - 1e-9));
      }
      if (t > 0) assert_true(position[first][1] != position[first + n - 1][1]);
    }
    assert_int_equal(model_tile_begin(&m.tiles, TILES), MOST);
    check_clear(&m, m.tiles.lower, m.tiles.upper, MOST, radius, position);
    const sd_disk disk = packing_disk(&spec, 2, position[0]);
    near_to(disk.mass, 8 * M_PI, 1e-12, "mass");
    sd_model *finished = sd_model_new();
    sd_model_add_material(finished, "grain", &(sd_contact_law){.k_n = 1e4});
    sd_model_add_disk(finished, &disk);
    sd_model_set(finished, "dt", 1e-4);
    sd_model_add_phase(finished, &(sd_phase){.steps = 1});
    assert_int_equal(sd_model_finish(finished, NULL), SD_OK);
    near_to(finished->disks[0].inertia, 16 * M_PI, 1e-12, "moment of inertia");
    sd_model_free(finished);
  }
}

RUN_TESTS(TEST(test_sizes), TEST(test_size_limits), TEST(test_list), TEST(test_list_is_shuffled),
          TEST(test_seeds), TEST(test_lattices), TEST(test_jitter), TEST(test_random),
          TEST(test_random_ends), TEST(test_front), TEST(test_front_keeps_radii),
          TEST(test_front_of_equal_disks), TEST(test_obstacles), TEST(test_interiors),
          TEST(test_drum), TEST(test_waiting), TEST(test_tiles))
