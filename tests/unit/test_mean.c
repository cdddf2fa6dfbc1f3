/* test_mean.c: error bars against records whose true error is known, and what is made of a state. */
#include <gsl/gsl_randist.h>
#include <gsl/gsl_rng.h>

#include "unit.h"
#include "model/model.h"
#include "brief.h"
#include "measure/error_bar.h"
#include "model/state.h"
#include "slipdisk/measure.h"

enum { N = 4096 };
static double x[N];

static void between(double value, double low, double high, const char *what) {
  if (!(value >= low && value <= high)) {
    print_error("%s: %.10g, expected %.10g to %.10g\n", what, value, low, high);
    fail();
  }
}

/* Mean 5, variance 1, correlation rho^|lag|, started from the stationary law. */
static void autoregressive(gsl_rng *random, size_t n, double rho) {
  double y = gsl_ran_gaussian(random, 1);
  for (size_t k = 0; k < n; k++) {
    x[k] = 5 + y;
    y = rho * y + sqrt(1 - rho * rho) * gsl_ran_gaussian(random, 1);
  }
}

/* Standard error of the mean of such a record, exactly. */
static double true_error(size_t n, double rho) {
  double m = (double)n;
  double sum = (1 + rho) / (1 - rho) - 2 * rho * (1 - pow(rho, m)) / (m * (1 - rho) * (1 - rho));
  return sqrt(sum / m);
}

typedef struct coverage {
  size_t n;
  double rho;
  bool transient;
  double low, high; /* allowed mean of error/true error, of the records that are called converged */
  double least;     /* part that is to be */
} coverage;

static void error_bars_cover(void **unused) {
  enum { SEEDS = 400 };
  const coverage cases[] = {
      {N, 0, false, 0.95, 1.05, 0.9},     {N, 0, true, 0.95, 1.05, 0.9},
      {N, 0.6, true, 0.93, 1.07, 0.9},    {N, 0.9, false, 0.93, 1.07, 0.9},
      {N, 0.9, true, 0.92, 1.07, 0.9},    {N, 0.97, true, 0.90, 1.1, 0.4},
      {N, -0.6, true, 0.95, 1.15, 0.9},   {1024, 0.6, true, 0.90, 1.1, 0.9},
      {2048, 0.9, false, 0.90, 1.1, 0.9}, {256, 0, false, 0.92, 1.08, 0.9},
  };
  gsl_rng *random = gsl_rng_alloc(gsl_rng_mt19937);
  for (size_t c = 0; c < sizeof cases / sizeof *cases; c += BRIEF(1, 4)) {
    double sum = 0, within = 0, correlation = 0, expected = true_error(cases[c].n, cases[c].rho);
    int converged = 0;
    for (int seed = 0; seed < SEEDS; seed++) {
      autoregressive(random, cases[c].n, cases[c].rho);
      sd_mean mean = sd_mean_of(x, cases[c].n, cases[c].transient);
      correlation += mean.correlation / SEEDS;
      if (!mean.converged) continue;
      sum += mean.error / expected;
      within += fabs(mean.mean - 5) < mean.error;
      converged++;
    }
    sum /= converged, within /= converged;
    double tau = (1 + cases[c].rho) / (1 - cases[c].rho) / 2;
    print_message(
        "  n %4zu rho %5.2f: error/true %.3f, within one error %.3f, correlation %.2f (%.2f)\n",
        cases[c].n, cases[c].rho, sum, within, correlation, tau);
    between(sum, cases[c].low, cases[c].high, "error/true error");
    between(within, 0.60, 0.76, "coverage of one error"); /* 0.683 +- 0.023 from 400 seeds */
    between(correlation / tau, 0.85, 1.3, "correlation time");
    assert_true(converged > cases[c].least * SEEDS);
  }
  gsl_rng_free(random);
}

/* Increments of an angle that walks at random, by `walk` in squares per sample, under bounded noise of variance 1 and
 * correlation time tau: of a disk that sticks, is turned elastically to and fro, and slips now and then. */
static void bounded_noise(gsl_rng *random, size_t n, double tau, double walk) {
  double rho = exp(-1 / tau), y = gsl_ran_gaussian(random, 1);
  for (size_t k = 0; k < n; k++) {
    double next = rho * y + sqrt(1 - rho * rho) * gsl_ran_gaussian(random, 1);
    x[k] = 5 + next - y + gsl_ran_gaussian(random, sqrt(walk));
    y = next;
  }
}

static void error_bars_of_bounded_noise_cover(void **unused) {
  enum { SEEDS = 200 };
  const struct {
    size_t n;
    double tau, walk,
        high; /* allowed mean of error/true error; blocks of the rule of Lee et al. gave 1.07 to 2 */
  } cases[] = {{N, 5, 1, 1.1},  {N, 5, 0.1, 1.15},    {N, 5, 0.02, 1.25},
               {N, 20, 1, 1.1}, {2441, 1, 0.1, 1.15}, {1024, 5, 0.1, 1.3}};
  gsl_rng *random = gsl_rng_alloc(gsl_rng_mt19937);
  for (size_t c = 0; c < sizeof cases / sizeof *cases; c++) {
    double n = (double)cases[c].n, sum = 0, one = 0, two = 0;
    double expected = sqrt(cases[c].walk / n + 2 * (1 - exp(-n / cases[c].tau)) / (n * n));
    for (int seed = 0; seed < SEEDS; seed++) {
      bounded_noise(random, cases[c].n, cases[c].tau, cases[c].walk);
      sd_mean mean = sd_mean_of(x, cases[c].n, true);
      sum += mean.error / expected / SEEDS;
      one += (fabs(mean.mean - 5) < mean.error) / (double)SEEDS;
      two += (fabs(mean.mean - 5) < 2 * mean.error) / (double)SEEDS;
    }
    print_message("  n %4zu tau %2g walk %4g: error/true %.3f, within one error %.3f, two %.3f\n",
                  cases[c].n, cases[c].tau, cases[c].walk, sum, one, two);
    between(sum, 0.95, cases[c].high, "error/true error");
    between(one, 0.58, 0.85, "coverage of one error");
    between(two, 0.90, 1, "coverage of two errors");
  }
  gsl_rng_free(random);
}

static void slow_records_are_said_not_to_converge(void **unused) {
  gsl_rng *random = gsl_rng_alloc(gsl_rng_mt19937);
  int converged = 0;
  for (int seed = 0; seed < 100; seed++) {
    autoregressive(random, N, 0.999); /* correlation time of a quarter of the record */
    converged += sd_mean_of(x, N, true).converged;
  }
  gsl_rng_free(random);
  assert_true(converged < 20);
}

static void constant_records_have_no_error(void **unused) {
  const double values[] = {0, 0.1, -1e300, 1e-300};
  for (size_t v = 0; v < 4; v++) {
    for (size_t k = 0; k < N; k++) x[k] = values[v];
    sd_mean mean = sd_mean_of(x, N, true);
    between(mean.mean / (values[v] == 0 ? 1 : values[v]), values[v] == 0 ? 0 : 1 - 1e-14, 1 + 1e-14,
            "mean");
    between(mean.error, 0, 0, "error");
    assert_int_equal(mean.discarded, 0);
    assert_true(mean.converged);
  }
}

static void short_records_have_none_either(void **unused) {
  for (size_t k = 0; k < 15; k++) x[k] = (double)(k % 3);
  assert_true(isnan(sd_mean_of(x, 0, true).mean));
  assert_true(isnan(sd_mean_of(NULL, 0, true).error));
  for (size_t n = 1; n < 16; n++) {
    sd_mean mean = sd_mean_of(x, n, true);
    assert_true(isfinite(mean.mean) && isnan(mean.error) && !mean.converged);
  }
}

/* Bin averages of 3 + cos(2 pi t/period): what a deterministic drive leaves in the bins. */
static void periodic(double period, double phase) {
  double w = 2 * M_PI / period;
  for (size_t k = 0; k < N; k++) {
    double t = (double)k + phase;
    x[k] = 3 + (sin(w * (t + 1)) - sin(w * t)) / w;
  }
}

static void periodic_records_have_small_errors(void **unused) {
  const double commensurate[] = {1, 2, 4, 16}, others[] = {2.7, 7.3, 50.1, 101.7, 333.3};
  for (size_t k = 0; k < 4; k++) {
    periodic(commensurate[k], 0.3);
    sd_mean mean = sd_mean_of(x, N, true);
    between(fabs(mean.mean - 3), 0, 1e-13, "mean, commensurate");
    between(mean.error, 0, 1e-12, "error, commensurate");
  }
  for (size_t k = 0; k < 5; k++)
    for (double phase = 0; phase < 1; phase += 0.13) {
      periodic(others[k], phase * others[k]);
      sd_mean mean = sd_mean_of(x, N, true);
      /* the true error is at most period/(pi N); that of an independent record would be 0.7/sqrt(N) = 0.011 */
      between(fabs(mean.mean - 3), 0, 5 * mean.error + 1e-4, "mean");
      between(mean.error, 0, fmax(others[k] * 2e-4, 5e-4), "error");
    }
}

static void transients_are_found(void **unused) {
  gsl_rng *random = gsl_rng_alloc(gsl_rng_mt19937);
  double within = 0;
  int converged = 0;
  for (int seed = 0; seed < 200; seed++) {
    autoregressive(random, N, 0.6);
    for (size_t k = 0; k < N; k++) x[k] += 10 * exp(-(double)k / 150);
    sd_mean mean = sd_mean_of(x, N, true);
    between((double)mean.discarded, 300, 1800, "discarded");
    assert_int_equal(mean.discarded + mean.used, N);
    converged += mean.converged;
    within += (fabs(mean.mean - 5) < 2 * mean.error) / 200.0;
    assert_true(fabs(sd_mean_of(x, N, false).mean - 5) > 0.2);
  }
  between(within, 0.88, 1, "within two errors");
  assert_true(converged > 180);
  gsl_rng_free(random);

  /* no noise at all: the relaxation never ends, but is soon small */
  for (size_t k = 0; k < N; k++) x[k] = 3 - 3 * exp(-(double)k / 200);
  sd_mean mean = sd_mean_of(x, N, true);
  assert_true(mean.converged);
  between(fabs(mean.mean - 3), 0, 1e-3, "relaxed");
  between(mean.error, fabs(mean.mean - 3) / 5, 1e-3, "its error");

  /* as short as what the whole batches up to the end leave out */
  for (size_t k = 0; k < 453; k++) x[k] = 3 + (k < 3) + 1e-3 * cos(2.1 * (double)k);
  mean = sd_mean_of(x, 453, true);
  between((double)mean.discarded, 3, 50, "discarded");
  between(fabs(mean.mean - 3), 0, 1e-5, "without it");

  /* a drift never ends */
  for (size_t k = 0; k < N; k++) x[k] = (double)k;
  assert_false(sd_mean_of(x, N, true).converged);
  /* neither has a relaxation as long as the record */
  for (size_t k = 0; k < N; k++) x[k] = exp(-(double)k / N);
  assert_false(sd_mean_of(x, N, true).converged);
}

/* x = k under an error that dwarfs the scatter: q1 ... q4 are n/4 apart, and the difference of the
 * first from the mean of the others has the variance (4 + 4/3) error^2. Rounding is no drift. */
static void drifts_are_measured_in_their_error(void **unused) {
  for (size_t k = 0; k < N; k++) x[k] = (double)k;
  drift seen = drift_of(x, N, 1e6);
  between(seen.sigmas, 0.999999 * 2 * (N / 4) / (sqrt(16. / 3) * 1e6),
          1.000001 * 2 * (N / 4) / (sqrt(16. / 3) * 1e6), "standard errors");
  between(seen.half, N / 4, N / 4, "half");
  between(seen.ratio, 1, 1, "ratio");
  for (size_t k = 0; k < N; k++) x[k] = k < N / 4 ? 1 + DBL_EPSILON : 1;
  between(drift_of(x, N, 1e-18).sigmas, 0, 0, "rounding");
}

/* What looks like a transient in a stationary record is chance. */
static void stationary_records_keep_their_start(void **unused) {
  enum { SEEDS = BRIEF(400, 100) };
  const double rho[] = {0, 0.6, 0.9, 0.967};
  gsl_rng *random = gsl_rng_alloc(gsl_rng_mt19937);
  for (size_t c = 0; c < 4; c++) {
    double cut = 0, discarded = 0;
    for (int seed = 0; seed < SEEDS; seed++) {
      autoregressive(random, N, rho[c]);
      sd_mean mean = sd_mean_of(x, N, true);
      cut += (mean.discarded > 0) / (double)SEEDS;
      discarded += (double)mean.discarded / N / SEEDS;
    }
    print_message("  rho %5.3f: cut %.3f, discarded %.4f\n", rho[c], cut, discarded);
    between(cut, 0, 0.12, "cut");
    between(discarded, 0, 0.03, "discarded");
  }
  gsl_rng_free(random);
}

/* Slow or weak relaxations under noise: found, or in the error bar. */
static void slow_transients_are_covered(void **unused) {
  enum { SEEDS = 200 };
  const struct {
    double height, time, least, most_converged;
  } cases[] = {{1, 150, 0.58, 1}, {1, 400, 0.55, 1}, {10, 400, 0.56, 1}, {10, 800, 0, 0.1}};
  gsl_rng *random = gsl_rng_alloc(gsl_rng_mt19937);
  for (size_t c = 0; c < 4; c++) {
    int one = 0, two = 0, converged = 0;
    for (int seed = 0; seed < SEEDS; seed++) {
      autoregressive(random, N, 0.6);
      for (size_t k = 0; k < N; k++) x[k] += cases[c].height * exp(-(double)k / cases[c].time);
      sd_mean mean = sd_mean_of(x, N, true);
      one += fabs(mean.mean - 5) < mean.error;
      two += fabs(mean.mean - 5) < 2 * mean.error;
      converged += mean.converged;
    }
    print_message("  %2g exp(-k/%g): of %d within one error %d, two %d, converged %d\n",
                  cases[c].height, cases[c].time, SEEDS, one, two, converged);
    between(one, cases[c].least * SEEDS, SEEDS, "within one error");
    between(two, 0.85 * SEEDS, SEEDS, "within two errors");
    between(converged, 0, cases[c].most_converged * SEEDS, "converged");
  }
  gsl_rng_free(random);
}

static void rotation_of_a_state(void **unused) {
  sd_disk disks[2] = {{.radius = 2}, {.radius = 0.5}};
  uint32_t watched[2] = {1, 0};
  sd_model model = {.dt = 1e-3,
                    .gravity = {-3, -4},
                    .n_disks = 2,
                    .disks = disks,
                    .n_rotations = 2,
                    .rotations = watched};
  double *bins = calloc(2 * SD_BINS, sizeof *bins), start[2] = {1, 2}, last[2] = {1, 2};
  for (size_t k = 0; k < 1000; k++) {
    bins[k] = 0.25;
    bins[SD_BINS + k] = k % 2 ? -0.5 : -0.25;
    last[0] += bins[k];
    last[1] += bins[SD_BINS + k];
  }
  sd_state state = {.measured = 10007,
                    .bin_steps = 10,
                    .bins = 1000,
                    .n_rotations = 2,
                    .rotation_bin = bins,
                    .rotation_start = start,
                    .rotation_last = last};
  sd_rotation a = sd_rotation_of(&model, &state, 0), b = sd_rotation_of(&model, &state, 1);
  assert_int_equal(a.disk, 1);
  assert_int_equal(b.disk, 0);
  between(a.omega, 25 - 1e-12, 25 + 1e-12, "omega");
  between(a.error, 0, 0, "error");
  between(a.scaled, 25 * sqrt(0.2) - 1e-12, 25 * sqrt(0.2) + 1e-12, "t_g omega");
  between(a.turned, 250 - 1e-10, 250 + 1e-10, "turned");
  between(a.measured, 10.007 - 1e-12, 10.007 + 1e-12, "measured");
  between(b.omega, -37.5 - 1e-12, -37.5 + 1e-12, "omega");
  between(b.scaled, -37.5 * sqrt(0.8) - 1e-12, -37.5 * sqrt(0.8) + 1e-12, "t_g omega");
  assert_true(a.converged && b.converged);

  model.gravity[0] = model.gravity[1] = 0;
  a = sd_rotation_of(&model, &state, 0);
  assert_true(isnan(a.scaled) && isnan(a.scaled_error) && !isnan(a.omega));
  state.bins = 0;
  a = sd_rotation_of(&model, &state, 0);
  assert_true(isnan(a.omega) && isnan(a.error) && !a.converged);
  free(bins);
}

/* Rotation of a disk whose rate, in bins of unit time, is 3 + height exp(-t/time) + ripple cos(2 pi t/period). */
static sd_rotation driven(size_t bins, double height, double time, double period,
                          const sd_motion *motions, size_t n_motions) {
  static double record[SD_BINS];
  const double ripple = 5, w = 2 * M_PI / period;
  for (size_t k = 0; k < bins; k++) {
    double t = (double)k;
    record[k] = 3 + height * time * exp(-t / time) * (1 - exp(-1 / time)) +
                ripple * (sin(w * (t + 1) + 0.4) - sin(w * t + 0.4)) / w;
  }
  bool active[2] = {true, true};
  double zero = 0;
  sd_disk disk = {.radius = 1};
  uint32_t watched = 0;
  sd_phase phase = {.active = active, .measure = true};
  sd_motion copies[2] = {motions[0], motions[n_motions - 1]};
  sd_model model = {.dt = 0.01,
                    .n_disks = 1,
                    .disks = &disk,
                    .n_rotations = 1,
                    .rotations = &watched,
                    .n_motions = n_motions,
                    .motions = copies,
                    .n_phases = 1,
                    .phases = &phase};
  sd_state state = {.measured = (int64_t)bins * 100,
                    .bin_steps = 100,
                    .bins = (int64_t)bins,
                    .n_rotations = 1,
                    .rotation_bin = record,
                    .rotation_start = &zero,
                    .rotation_last = &zero};
  return sd_rotation_of(&model, &state, 0);
}

static void ripples_of_a_drive_fall_out(void **unused) {
  const double periods[] = {0.37, 1, 2.7, 12.207, 97.656};
  for (size_t p = 0; p < 5; p++) {
    sd_motion wave[2] = {{.kind = SD_MOTION_PARABOLIC, .omega = 2 * M_PI / periods[p]}};
    /* relaxations of a fiftieth, a seventeenth and a third of the record */
    sd_rotation fast = driven(2441, 2, 50, periods[p], wave, 1),
                gradual = driven(2441, -2, 144, periods[p], wave, 1);
    sd_rotation slowest = driven(2441, 2, 800, periods[p], wave, 1);
    between(fabs(fast.omega - 3), 0, 2 * fast.error, "fast");
    between(fabs(gradual.omega - 3), 0, 2 * gradual.error, "gradual");
    between(fast.error, 0, 3e-4, "error, fast");
    between(gradual.error, 0, 2e-3, "error, gradual");
    assert_true(fast.converged && gradual.converged && !slowest.converged);
    between(fabs(slowest.omega - 3), 0, 2 * slowest.error, "slowest");
  }

  /* periods of 2 and 3 have the common one of 6; a random one has none */
  sd_motion two[2] = {{.kind = SD_MOTION_HARMONIC, .omega = M_PI},
                      {.kind = SD_MOTION_HARMONIC, .omega = 2 * M_PI / 3}};
  between(driven(2441, 2, 50, 6, two, 2).error, 0, 1e-4, "error, common period");
  two[1].kind = SD_MOTION_RANDOM;
  between(driven(2441, 2, 50, 6.1, two, 2).error, 1e-4, 1, "error, no period");
  /* three periods say nothing */
  assert_false(driven(290, 0, 50, 97, two, 1).converged);
}

static void sliding_of_a_state(void **unused) {
  sd_slide_watch watch[2] = {{0, {1, 2}}, {3, {7, 5}}};
  sd_model model = {.n_slides = 2, .slides = watch};
  int64_t count[32] = {0}, openings[4] = {0, 0, 3, 4};
  double force[4] = {1, 2, 0.5, 0.25};
  for (int k = 0; k < 16; k++) count[16 + k] = k + 1; /* 136 steps */
  sd_state state = {.measured = 136,
                    .n_slides = 2,
                    .slide_count = count,
                    .slide_openings = openings,
                    .slide_force_min = force};
  sd_slide s = sd_slide_of(&model, &state, 1);
  assert_int_equal(s.disk, 3);
  assert_int_equal(s.partner[0], 7);
  assert_int_equal(s.openings[1], 4);
  between(s.force_min[0], 0.5, 0.5, "force");
  between(s.pp * 136, 1 - 1e-12, 1 + 1e-12, "++");
  between(s.pm * 136, 2 - 1e-12, 2 + 1e-12, "+-");
  between(s.mp * 136, 5 - 1e-12, 5 + 1e-12, "-+");
  between(s.mm * 136, 6 - 1e-12, 6 + 1e-12, "--");
  between(s.stick * 136, 3 + 7 + 9 + 10 + 11 - 1e-12, 40 + 1e-12, "stick");
  between(s.open * 136, 4 + 8 + 12 + 13 + 14 + 15 + 16 - 1e-12, 82 + 1e-12, "open");
  between(s.contact_negative[0] * 136, 26 - 1e-12, 26 + 1e-12, "first contact, negative");
  between(s.contact_negative[1] * 136, 32 - 1e-12, 32 + 1e-12, "second contact, negative");
  for (int c = 0; c < 2; c++)
    between(s.contact_positive[c] + s.contact_negative[c] + s.contact_stuck[c] + s.contact_open[c],
            1 - 1e-12, 1 + 1e-12, "all of a contact");

  state.measured = 0;
  s = sd_slide_of(&model, &state, 0);
  assert_true(isnan(s.pp) && isnan(s.stick) && isnan(s.open) && isnan(s.contact_open[1]));
}

RUN_TESTS(TEST(error_bars_cover), TEST(error_bars_of_bounded_noise_cover),
          TEST(slow_records_are_said_not_to_converge), TEST(constant_records_have_no_error),
          TEST(short_records_have_none_either), TEST(periodic_records_have_small_errors),
          TEST(transients_are_found), TEST(drifts_are_measured_in_their_error),
          TEST(stationary_records_keep_their_start), TEST(slow_transients_are_covered),
          TEST(rotation_of_a_state), TEST(ripples_of_a_drive_fall_out), TEST(sliding_of_a_state))
