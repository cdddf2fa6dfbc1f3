/* test_converged.c: records that are called converged, and how often their error bars cover the true
 * mean: processes whose mean is known, short and long ones, and three disks at weak and strong
 * vibration. */
#include <gsl/gsl_randist.h>
#include <gsl/gsl_rng.h>

#include "brief.h"
#include "validation.h"

enum {
  N = 4096,
  SEEDS = BRIEF(400, 40),
  LEAST = BRIEF(150, 1000)
}; /* LEAST: records that tell a coverage */
static double x[N];
static gsl_rng *generator;

static double normal(double deviation) { return gsl_ran_gaussian_ziggurat(generator, deviation); }

typedef struct process {
  const char *name;
  void (*add)(size_t n, double a, double b);
  double a, b;
  size_t n;
  double least, most; /* part that is called converged */
} process;

/* Integrated correlation time a, variance b. */
static void add_noise(size_t n, double a, double b) {
  const double rho = (2 * a - 1) / (2 * a + 1), kick = sqrt((1 - rho * rho) * b);
  double y = normal(sqrt(b));
  for (size_t k = 0; k < n; k++) {
    x[k] += y;
    y = rho * y + normal(kick);
  }
}

/* Increments of bounded noise of correlation time a, and of a random walk of variance b per sample. */
static void add_bounded(size_t n, double a, double b) {
  const double rho = exp(-1 / a), kick = sqrt(1 - rho * rho);
  double y = normal(1);
  for (size_t k = 0; k < n; k++) {
    const double next = rho * y + normal(kick);
    x[k] += next - y + normal(sqrt(b));
    y = next;
  }
}

/* An oscillation of period a, which noise drives, damped over a time b. */
static void add_oscillation(size_t n, double a, double b) {
  const double first = 2 * exp(-1 / b) * cos(2 * M_PI / a), second = -exp(-2 / b);
  double before = 0, last = 0;
  for (size_t k = 0, begin = (size_t)(8 * b) + 8; k < n + begin; k++) {
    const double y = first * last + second * before + normal(1);
    before = last;
    last = y;
    if (k >= begin) x[k - begin] += y;
  }
}

/* 0 or 1, for mean times of a and b. */
static void add_telegraph(size_t n, double a, double b) {
  const double mean = b / (a + b);
  bool up = gsl_rng_uniform(generator) < mean;
  for (size_t k = 0; k < n; k++) {
    x[k] += up - mean;
    if (gsl_rng_uniform(generator) * (up ? b : a) < 1) up = !up;
  }
}

/* a events in a record, independent of one another. */
static void add_events(size_t n, double a, double b) {
  (void)b;
  for (size_t k = 0; k < n; k++) x[k] += gsl_ran_poisson(generator, a / (double)n) - a / (double)n;
}

static const process processes[] = {
    {"white noise", add_noise, 0.5, 1, N, 0.93, 1},
    {"white noise", add_noise, 0.5, 1, 128, 0.9, 1},
    {"white noise, 16 samples", add_noise, 0.5, 1, 16, 0, 0},
    {"noise, 2048 tau", add_noise, 2, 1, N, 0.93, 1},
    {"noise, 256 tau", add_noise, 16, 1, N, 0.9, 1},
    {"noise, 256 tau", add_noise, 1, 1, 256, 0.9, 1},
    {"noise, 48 tau", add_noise, 85, 1, N, 0, 0.05},
    {"noise, 48 tau", add_noise, 5.3, 1, 256, 0, 0.05},
    {"noise, 24 tau", add_noise, 170, 1, N, 0, 0.03},
    {"bounded, wide dip", add_bounded, 5, 0.1, N, 0.9, 1},
    {"bounded, dip", add_bounded, 20, 0.05, N, 0.8, 1},
    {"bounded, narrow dip", add_bounded, 5, 0.01, 1024, 0, 0.2},
    {"bounded, no walk", add_bounded, 20, 1e-5, N, 0, 0.1},
    {"oscillation, 4 periods", add_oscillation, N / 4, N / 4, N, 0, 0.03},
    {"oscillation, 8 periods", add_oscillation, N / 8, 5 * N / 8, N, 0, 0.03},
    {"oscillation, 16 periods", add_oscillation, N / 16, N / 16, N, 0, 0.05},
    {"oscillation, 64 periods", add_oscillation, N / 64, 5 * N / 64, N, 0.9, 1},
    {"oscillation, 1024 periods", add_oscillation, 4, 12, N, 0.9, 1},
    {"telegraph, 273 tau", add_telegraph, 30, 30, N, 0.9, 1},
    {"telegraph, 10 visits", add_telegraph, 400, 5, N, 0, 0.05},
    {"10 events", add_events, 10, 0, N, 0, 0.15},
    {"100 events", add_events, 100, 0, N, 0.9, 1},
    {"1000 events", add_events, 1000, 0, N, 0.93, 1},
};

/* Of many records: those called converged, and the others. */
typedef struct counts {
  int n, within, two;
  double error; /* sum of error bars */
} counts;

static void count(counts *c, double off, double error) {
  c->n++;
  c->within += fabs(off) < error;
  c->two += fabs(off) < 2 * error;
  c->error += error;
}

/* Four standard deviations of a binomial. */
static void covers(const counts *c, const char *name) {
  const double n = c->n, one = 4 * sqrt(0.683 * 0.317 / n), two = 4 * sqrt(0.954 * 0.046 / n);
  between(c->within / n, 0.683 - one, 0.683 + one, name);
  between(c->two / n, 0.954 - two - 0.02, 1, name);
}

static void records_called_converged_are_covered(void **unused) {
  generator = gsl_rng_alloc(gsl_rng_mt19937);
  counts all = {0};
  for (size_t p = 0; p < sizeof processes / sizeof *processes; p++) {
    const process *q = &processes[p];
    counts good = {0}, other = {0};
    double squares = 0;
    for (int seed = 0; seed < SEEDS; seed++) {
      for (size_t k = 0; k < q->n; k++) x[k] = 0;
      q->add(q->n, q->a, q->b);
      const sd_mean whole = sd_mean_of(x, q->n, false), mean = sd_mean_of(x, q->n, true);
      squares += whole.mean * whole.mean / SEEDS;
      count(mean.converged ? &good : &other, mean.mean, mean.error);
    }
    const double error = sqrt(squares), part = (double)good.n / SEEDS,
                 chance = 1.5 / sqrt(SEEDS) * BRIEF(0, 1);
    print_message(
        "  %-25s n %4zu: converged %.3f, error/true %.2f, within one %.3f; others %.2f, %.3f\n",
        q->name, q->n, part, good.error / good.n / error, (double)good.within / good.n,
        other.error / other.n / error, (double)other.within / other.n);
    between(part, q->least - chance, q->most + chance, q->name);
    /* a bar that is not called reliable is not too small either */
    if (other.n >= LEAST) between(other.error / other.n / error, 0.9, 10, q->name);
    if (good.n < LEAST) continue;
    covers(&good, q->name);
    between(good.error / good.n / error, 0.88, 1.2, q->name);
    all.n += good.n, all.within += good.within, all.two += good.two, all.error += good.error;
  }
  gsl_rng_free(generator);
  if (all.n < LEAST) return;
  print_message("  all: of %d within one %.4f, two %.4f\n", all.n, (double)all.within / all.n,
                (double)all.two / all.n);
  between((double)all.within / all.n, 0.66, 0.71, "all, within one");
  between((double)all.two / all.n, 0.93, 0.97, "all, within two");
}

/* The upper disk over a measured time. At weak vibration it sticks most of the time, and its rate is
 * nearly all elastic noise: the bars of 1.5 time units are 2 to 2.5 times too large. */
static void three_disks_are_covered(void **unused) {
  enum { RUNS = BRIEF(100, 4) };
  const struct {
    double amplitude, time, least, most;
  } cases[] = {
      {1e-5, 1.5, 0, 0.12}, {1e-4, 1.5, 0, 0.12}, {6e-4, 1.5, 0, 0.05}, {6e-4, 6, 0.85, 1}};
  for (size_t c = 0; c < sizeof cases / sizeof *cases; c++) {
    double omega[RUNS], error[RUNS], mean = 0;
    bool converged[RUNS];
    for (unsigned r = 0; r < RUNS; r++) {
      char more[128];
      snprintf(more, sizeof more, "motions[*].amplitude=%.17g;integrator=verlet;",
               cases[c].amplitude);
      const sd_rotation found = vibrate(0.02, 4e-5, cases[c].time, r + 1, more).rotation;
      omega[r] = found.omega;
      error[r] = found.error;
      converged[r] = found.converged;
      mean += found.omega / RUNS;
    }
    counts good = {0}, other = {0};
    for (unsigned r = 0; r < RUNS; r++)
      count(converged[r] ? &good : &other, (omega[r] - mean) * sqrt(RUNS / (RUNS - 1.0)), error[r]);
    print_message("  eps %g, %g time units: converged %d of %d, within one %d, of the others %d\n",
                  cases[c].amplitude, cases[c].time, good.n, RUNS, good.within, other.within);
    between(good.n, BRIEF(cases[c].least, 0) * RUNS, BRIEF(cases[c].most, 1) * RUNS, "converged");
    if (good.n >= RUNS / 2) covers(&good, "three disks");
    if (other.n >= RUNS / 2) between((double)other.within / other.n, 0.6, 1, "not converged");
  }
}

RUN_TESTS(TEST(records_called_converged_are_covered), TEST(three_disks_are_covered))
