/* test_random.c: random vibration (eq. 52): the exact step against series in extended precision, the
 * covariance of (x, x') in runs against theory, draws at longer intervals, and whose numbers are whose. */
#include "deck_runs.h"
#include "model/model.h"
#include "physics/motion/signals.h"
#include "slipdisk/theory.h"

typedef struct exact_step {
  long double p[2][2];    /* propagator */
  long double uu, vu, vv; /* covariance */
} exact_step;

/* Taylor series of exp(A h) and of dQ/dh = A Q + Q A' + B over a short time, where all terms of Q's leading
 * orders are exact; then doubling, Q(2h) = Q + P Q P', whose diagonal terms are all positive. */
static exact_step exact_of(double omega, double c, double rms, double h) {
  long double w = omega, g = 2.0L * (long double)c * w, a10 = -w * w, a11 = -g, t = h;
  int doublings = 0;
  while (t * w * (1 + 2 * (long double)c) > 0.125L) {
    t /= 2;
    doublings++;
  }
  exact_step e = {.p = {{1, 0}, {0, 1}}};
  long double term[2][2] = {{1, 0}, {0, 1}};
  for (int k = 1; k < 30; k++) {
    long double n[2][2] = {
        {term[1][0], term[1][1]},
        {a10 * term[0][0] + a11 * term[1][0], a10 * term[0][1] + a11 * term[1][1]}};
    for (int i = 0; i < 4; i++) e.p[i / 2][i % 2] += term[i / 2][i % 2] = n[i / 2][i % 2] * t / k;
  }
  long double uu = 0, vu = 0, vv = 2 * g * w * w * (long double)rms * (long double)rms * t;
  for (int k = 1; k < 30; k++) {
    e.uu += uu;
    e.vu += vu;
    e.vv += vv;
    long double nuu = 2 * vu, nvu = vv + a10 * uu + a11 * vu, nvv = 2 * (a10 * vu + a11 * vv);
    uu = nuu * t / (k + 1);
    vu = nvu * t / (k + 1);
    vv = nvv * t / (k + 1);
  }
  for (; doublings > 0; doublings--) {
    long double(*p)[2] = e.p, quu = e.uu, qvu = e.vu, qvv = e.vv;
    e.uu += p[0][0] * p[0][0] * quu + 2 * p[0][0] * p[0][1] * qvu + p[0][1] * p[0][1] * qvv;
    e.vu += p[0][0] * p[1][0] * quu + (p[0][0] * p[1][1] + p[0][1] * p[1][0]) * qvu +
            p[0][1] * p[1][1] * qvv;
    e.vv += p[1][0] * p[1][0] * quu + 2 * p[1][0] * p[1][1] * qvu + p[1][1] * p[1][1] * qvv;
    long double s[2][2] = {{p[0][0] * p[0][0] + p[0][1] * p[1][0], p[0][1] * (p[0][0] + p[1][1])},
                           {p[1][0] * (p[0][0] + p[1][1]), p[1][0] * p[0][1] + p[1][1] * p[1][1]}};
    memcpy(e.p, s, sizeof s);
  }
  return e;
}

static double relative(double value, long double exact) {
  return (double)(fabsl((long double)value - exact) / fabsl(exact));
}

/* Largest relative error of the covariance, and of the propagator against the size of its own row. */
static void step_errors(double omega, double c, double h, double *noise, double *propagator) {
  random_step s = random_step_new(omega, c, 3e-4, h);
  exact_step e = exact_of(omega, c, 3e-4, h);
  long double left = e.vv - e.vu * e.vu / e.uu; /* of what the first draw does not give */
  double l0 = s.cholesky[0], l1 = s.cholesky[1], l2 = s.cholesky[2];
  *noise = fmax(relative(l0 * l0, e.uu), relative(l1 * l1 + l2 * l2, e.vv));
  *noise = fmax(*noise, relative(l2 * l2, left));
  *noise = fmax(*noise, fabs((double)(l1 * l0 - e.vu)) / sqrt((double)(e.uu * e.vv)));
  long double row0 = fabsl(e.p[0][0]) + fabsl(e.p[0][1]) * omega,
              row1 = fabsl(e.p[1][0]) + fabsl(e.p[1][1]) * omega;
  *propagator = 0.0;
  for (int k = 0; k < 2; k++) {
    long double scale = k ? omega : 1.0L;
    *propagator = fmax(*propagator, (double)(fabsl(s.propagator[0][k] - e.p[0][k]) * scale / row0));
    *propagator = fmax(*propagator, (double)(fabsl(s.propagator[1][k] - e.p[1][k]) * scale / row1));
  }
}

static void one_step_is_exact(void **unused) {
  const double dampings[] = {0.01, 0.1, 0.5, 0.9, 0.999999, 1.0, 1.000001, 1.1, 2.0, 5.0};
  const double steps[] = {1e-6, 1e-5, 6.28e-5, 1e-3, 1e-2, 0.1, 0.3, 1.0, 2.0, 5.0}; /* omega h */
  double worst_noise = 0.0, worst_propagator = 0.0;
  for (int c = 0; c < 10; c++)
    for (int h = 0; h < 10; h++) {
      double noise, propagator, omega = 62.8;
      step_errors(omega, dampings[c], steps[h] / omega, &noise, &propagator);
      if (noise > 1e-12 || propagator > 1e-13)
        print_message("  c %g, w h %g: noise %.2g, propagator %.2g\n", dampings[c], steps[h], noise,
                      propagator);
      worst_noise = fmax(worst_noise, noise);
      worst_propagator = fmax(worst_propagator, propagator);
    }
  print_message("  relative errors: covariance %.2g, propagator %.2g\n", worst_noise,
                worst_propagator);
  between(worst_noise, 0, 1e-12, "relative error of the covariance of a step");
  between(worst_propagator, 0, 1e-13, "relative error of the propagator");
}

/* Q = S - P S P' with the stationary S: the law of (52) is kept, at any length of the step. */
static void a_step_keeps_the_stationary_law(void **unused) {
  for (int c = 0; c < 6; c++) {
    double omega = 2.0, damping = 0.2 * (c + 1) * (c + 1), rms = 0.7;
    for (double h = 1e-3; h < 100; h *= 3) {
      random_step s = random_step_new(omega, damping, rms, h);
      double(*p)[2] = s.propagator, S[2] = {rms * rms, omega * omega * rms * rms};
      double uu =
          p[0][0] * p[0][0] * S[0] + p[0][1] * p[0][1] * S[1] + s.cholesky[0] * s.cholesky[0];
      double vu =
          p[0][0] * p[1][0] * S[0] + p[0][1] * p[1][1] * S[1] + s.cholesky[0] * s.cholesky[1];
      double vv = p[1][0] * p[1][0] * S[0] + p[1][1] * p[1][1] * S[1] +
                  s.cholesky[1] * s.cholesky[1] + s.cholesky[2] * s.cholesky[2];
      between(uu / S[0], 1 - 1e-13, 1 + 1e-13, "variance of the displacement after a step");
      between(vv / S[1], 1 - 1e-13, 1 + 1e-13, "variance of the velocity after a step");
      between(vu / sqrt(S[0] * S[1]), -1e-13, 1e-13, "covariance after a step");
    }
  }
}

enum { SIDE = 8 }; /* of a square of disks */

/* n driven disks in a row, x, y and theta random; with company: free disks after them, a wall that moves at
 * random, and other motions before, after and on the same coordinates. */
static sd_model *shaken(int n, double omega, double damping, double dt, int interval,
                        bool company) {
  text t = {0};
  text_add(&t, "dt = %.17g; seed = 4711; materials = ( { name = \"m\"; k_n = 1e3; } );\n", dt);
  text_add(&t, "disk_rows = ( { columns = (\"x\", \"y\", \"radius\"); mass = 1; fixed = true; "
               "group = \"g\"; rows = (");
  for (int k = 0; k < n; k++) text_add(&t, "%s(%d, 0, 0.4)", k ? ", " : "", 8 * (k - n / 2));
  text_add(&t, "); }");
  if (company)
    text_add(&t, ", { columns = (\"x\", \"y\", \"radius\"); mass = 1; rows = ((3, 4, 0.3), (3.5, "
                 "4.4, 0.2)); }");
  text_add(&t, ");\n");
  if (company)
    text_add(&t,
             "walls = ( { name = \"far\"; type = \"line\"; points = ((0, 90), (1, 90)); } );\n");
  text_add(&t, "motions = (");
  if (company)
    text_add(
        &t,
        "{ disk = 1; coordinate = \"theta\"; type = \"velocity\"; velocity = 0; },\n"
        "{ wall = \"far\"; coordinate = (\"x\", \"y\"); type = \"random\"; amplitude = 1e-3; omega "
        "= 5; },\n");
  text_add(&t,
           "{ name = \"r\"; group = \"g\"; independent = true; coordinate = (\"x\", \"y\", "
           "\"theta\"); type = \"random\";"
           "amplitude = 2e-3; omega = %.17g; damping = %.17g; interval = %d; }",
           omega, damping, interval);
  if (company)
    text_add(&t, ", { disk = [0, 1]; coordinate = \"x\"; type = \"velocity\"; velocity = 0; },\n"
                 "{ disk = 1; coordinate = \"y\"; type = \"random\"; amplitude = 0; omega = 3; }");
  text_add(&t, ");\nsteps = 100000000;\n");
  return model_of_text(&t);
}

enum { STREAMS = 3 * SIDE, LAGS = 6, RING = 128 };

typedef struct correlator {
  double sum[LAGS][3][STREAMS]; /* <x x'>, <x v'>, <v v'> of each stream */
  double cross[STREAMS][STREAMS];
  double x[RING][STREAMS], v[RING][STREAMS];
  int64_t n;
} correlator;

static void read_streams(const sd_model *m, const sd_state *s, double *x, double *v) {
  for (int b = 0; b < SIDE; b++) {
    x[3 * b] = s->x[b] - m->disks[b].position[0];
    x[3 * b + 1] = s->y[b];
    x[3 * b + 2] = s->theta[b];
    v[3 * b] = s->vx[b];
    v[3 * b + 1] = s->vy[b];
    v[3 * b + 2] = s->omega[b];
  }
}

static void correlate(correlator *c, const int *lags, sd_simulation *sim, int64_t steps) {
  const sd_model *m = sd_simulation_model(sim);
  for (int64_t k = 0; k < steps; k++) {
    advance(sim, 1);
    double *x = c->x[k % RING], *v = c->v[k % RING];
    read_streams(m, engine_of(sim)->state, x, v);
    if (k < RING) continue;
    c->n++;
    for (int l = 0; l < LAGS; l++) {
      const double *x0 = c->x[(k - lags[l]) % RING], *v0 = c->v[(k - lags[l]) % RING];
      for (int i = 0; i < STREAMS; i++) {
        c->sum[l][0][i] += x0[i] * x[i];
        c->sum[l][1][i] += x0[i] * v[i];
        c->sum[l][2][i] += v0[i] * v[i];
      }
    }
    for (int i = 0; i < STREAMS && k % 8 == 0; i++)
      for (int j = 0; j < i; j++) c->cross[i][j] += 8 * x[i] * x[j];
  }
}

/* z of the mean over streams, with the error from their scatter. */
static double z_over_streams(const double *sum, double n, double expected) {
  double mean = 0.0, square = 0.0;
  for (int i = 0; i < STREAMS; i++) mean += sum[i] / n / STREAMS;
  for (int i = 0; i < STREAMS; i++) square += (sum[i] / n - mean) * (sum[i] / n - mean);
  return (mean - expected) / sqrt(square / (STREAMS * (STREAMS - 1.0)));
}

static void covariance_is_that_of_the_theory(void **unused) {
  const double dampings[] = {0.2, 0.5, 1.0, 3.0};
  const int lags[LAGS] = {0, 1, 4, 12, 40, 120};
  const double omega = 20 * M_PI, dt = 1e-3, rms = 2e-3;
  static correlator c;
  double chi2 = 0.0;
  int terms = 0;
  for (int d = 0; d < 4; d++) {
    memset(&c, 0, sizeof c);
    sd_model *model = shaken(SIDE, omega, dampings[d], dt, 1, false);
    sd_simulation *sim = begin_run(model, 1);
    correlate(&c, lags, sim, 150000);
    for (int l = 0; l < LAGS; l++) {
      double expected[3];
      sd_vibration_covariance(omega, dampings[d], rms, lags[l] * dt, expected);
      for (int k = 0; k < 3; k++) {
        double z = z_over_streams(c.sum[l][k], (double)c.n, expected[k]);
        between(z, -5, 5, "z of a covariance"); /* Student, 23 degrees of freedom: 5 is 5e-5 */
        chi2 += z * z * 21 / 23;                /* <t^2> = 23/21 */
        terms++;
      }
    }
    /* equal times, different streams: each of variance rms^4 (1 + 4 c^2)/(c w)/2 per time, two-sided */
    double corr = (1 + 4 * dampings[d] * dampings[d]) / (2 * dampings[d] * omega), sum = 0.0;
    double variance = pow(rms, 4) * corr / ((double)c.n * dt);
    for (int i = 0; i < STREAMS; i++)
      for (int j = 0; j < i; j++) {
        double mean = c.cross[i][j] / (double)c.n;
        sum += mean * mean / variance / (STREAMS * (STREAMS - 1) / 2);
      }
    print_message("  c = %g: chi2/n of the correlations between 276 pairs of streams: %.3f\n",
                  dampings[d], sum);
    between(sum, 0.6, 1.5, "chi2/n of the correlations between streams");
    end_run(sim, model);
  }
  print_message("  chi2/n of %d covariances: %.3f\n", terms, chi2 / terms);
  between(chi2 / terms, 0.4, 2.0, "chi2/n of the covariances");
}

/* Over many bodies, from the first step on. */
static void vibration_is_stationary_from_the_first_step(void **unused) {
  enum { N = 2000 };
  const double rms = 2e-3, omega = 20 * M_PI;
  const int intervals[] = {1, 16};
  for (int c = 0; c < 2; c++) {
    sd_model *model = shaken(N, omega, 0.5, 1e-3, intervals[c], false);
    sd_simulation *sim = begin_run(model, 1);
    int64_t step = 0;
    const int64_t at[] = {1, 2, 16, 48, 64, 80, 320};
    for (int k = 0; k < 7; k++) {
      advance(sim, at[k] - step);
      step = at[k];
      if (step % intervals[c] != 0) continue;
      const sd_state *s = engine_of(sim)->state;
      double xx = 0.0, xv = 0.0, vv = 0.0, n = 3.0 * N;
      for (int b = 0; b < N; b++) {
        double x[] = {s->x[b] - model->disks[b].position[0], s->y[b], s->theta[b]},
               v[] = {s->vx[b], s->vy[b], s->omega[b]};
        for (int i = 0; i < 3; i++) {
          xx += x[i] * x[i] / (rms * rms);
          xv += x[i] * v[i] / (rms * rms * omega);
          vv += v[i] * v[i] / (rms * rms * omega * omega);
        }
      }
      between((xx / n - 1) / sqrt(2 / n), -4.2, 4.2, "z of <x^2> early on");
      between(xv / n / sqrt(1 / n), -4.2, 4.2, "z of <x x'> early on");
      between((vv / n - 1) / sqrt(2 / n), -4.2, 4.2, "z of <x'^2> early on");
    }
    end_run(sim, model);
  }
}

/* interval m at dt, and interval 1 at m dt: the same at the multiples; with m dt exact, to the bit. */
static void intervals_are_exact_at_their_multiples(void **unused) {
  const int m[] = {2, 8, 64, 128};
  for (int c = 0; c < 4; c++) {
    sd_model *fine = shaken(3, 10, 0.5, 0x1p-12, m[c], false),
             *coarse = shaken(3, 10, 0.5, m[c] * 0x1p-12, 1, false);
    sd_simulation *a = begin_run(fine, 1), *b = begin_run(coarse, 1);
    for (int k = 0; k < 200; k++) {
      advance(a, m[c]);
      advance(b, 1);
      const sd_state *s = engine_of(a)->state, *t = engine_of(b)->state;
      assert_memory_equal(s->x, t->x, 3 * sizeof(double));
      assert_memory_equal(s->omega, t->omega, 3 * sizeof(double));
    }
    sd_simulation_free(a);
    end_run(b, fine);
    sd_model_free(coarse);
  }
}

/* Between the draws: the velocity is the derivative, to third order in dt, and neither jumps at a draw. */
static void between_draws_the_velocity_is_the_derivative(void **unused) {
  enum { M = 100, N = 5000 };
  const double dt = 1e-5, rms = 2e-3, omega = 20 * M_PI, h = M * dt;
  sd_model *model = shaken(1, omega, 0.5, dt, M, false);
  sd_simulation *sim = begin_run(model, 1);
  static double x[N + 1], v[N + 1];
  advance(sim, 1);
  for (int k = 0; k <= N; k++) {
    x[k] = engine_of(sim)->state->y[0];
    v[k] = engine_of(sim)->state->vy[0];
    advance(sim, 1);
  }
  double inside = 0.0, jump = 0.0, bend = 0.0;
  for (int k = 0; k < N; k++) {
    /* Simpson and Hermite: the trapezoid's error over a step is third order in dt, of a cubic exactly known */
    double trapezoid = x[k + 1] - x[k] - 0.5 * dt * (v[k] + v[k + 1]);
    bend = fmax(bend, fabs(trapezoid));
    jump = fmax(jump, fabs(v[k + 1] - v[k]));
    if (k + 3 > N || (k + 1) / M != (k + 4) / M) continue;
    /* four points of one cubic: the third difference of x is six times its leading term, of v's second */
    double third = x[k + 3] - 3 * x[k + 2] + 3 * x[k + 1] - x[k],
           second = v[k + 2] - 2 * v[k + 1] + v[k];
    inside = fmax(inside, fabs(third - dt * second));
  }
  double acceleration =
      30 * rms * omega / sqrt(omega * h) * omega; /* a generous scale of u'' of one cubic */
  print_message(
      "  trapezoid's defect %.2g, third against second difference %.2g, largest change of v %.2g\n",
      bend, inside, jump);
  between(inside, 0, 2e-17, "u and u' of one cubic");
  between(bend, 0, acceleration * dt * dt * dt / h, "defect of the trapezoid");
  between(jump, 0, acceleration * dt, "change of the velocity in a step");
  end_run(sim, model);
}

/* Variance half way between draws: of the cubic through both, from the theory's covariances. */
static double middle_variance(double omega, double damping, double h) {
  double c[3], z[3];
  sd_vibration_covariance(omega, damping, 1, h, c);
  sd_vibration_covariance(omega, damping, 1, 0, z);
  /* u = (u0 + u1)/2 + h (v0 - v1)/8; <u0 v1> = c[1] = -<v0 u1> */
  return (z[0] + c[0]) / 2 + h * h * (z[2] - c[2]) / 32 - h * c[1] / 4 * 1;
}

static void longer_intervals_converge(void **unused) {
  const double omega = 20 * M_PI, rms = 2e-3;
  double before = 0.0;
  for (int k = 0; k < 6; k++) { /* the deviation of the variance is third order in w h */
    double deviation = fabs(middle_variance(omega, 0.5, 0.4 / omega / (1 << k)) - 1);
    if (k > 1)
      between(before / deviation, 7.0, 9.0, "ratio of the deviations for halved intervals");
    before = deviation;
  }
  /* and runs have that variance */
  enum { N = 4000, M = 16 };
  sd_model *model = shaken(N, omega, 0.5, 2e-3, M, false); /* w h = 2 */
  sd_simulation *sim = begin_run(model, 1);
  double expected = middle_variance(omega, 0.5, M * 2e-3), sum = 0.0;
  advance(sim, M / 2);
  for (int k = 0; k < 20; k++) {
    const sd_state *s = engine_of(sim)->state;
    for (int b = 0; b < N; b++)
      sum += (s->y[b] * s->y[b] + s->theta[b] * s->theta[b]) / (rms * rms);
    advance(sim, 3 * M); /* w lag = 6: independent but for exp(-3) */
  }
  double n = 20.0 * 2 * N;
  print_message("  variance half way, w h = 2: %.4f, theory %.4f\n", sum / n, expected);
  between((sum / n / expected - 1) / sqrt(2.05 / n), -4, 4, "z of the variance half way");
  assert_true(fabs(expected - 1) > 10 * sqrt(2.05 / n)); /* else this tells nothing */
  end_run(sim, model);
}

static void numbers_belong_to_body_and_coordinate(void **unused) {
  sd_model *plain = shaken(5, 20, 0.5, 1e-3, 3, false), *other = shaken(5, 20, 0.5, 1e-3, 3, true);
  sd_simulation *a = begin_run(plain, 1), *b = begin_run(other, 3);
  for (int k = 0; k < 400; k++) {
    advance(a, 7);
    for (int piece = 0; piece < 7; piece++) advance(b, 1);
    const sd_state *s = engine_of(a)->state, *u = engine_of(b)->state;
    for (uint32_t body = 0; body < 5; body++) {
      uint32_t i = sd_simulation_slot(a, body), j = sd_simulation_slot(b, body);
      assert_memory_equal(&s->x[i], &u->x[j], 8);
      assert_memory_equal(&s->y[i], &u->y[j], 8);
      assert_memory_equal(&s->theta[i], &u->theta[j], 8);
      assert_memory_equal(&s->omega[i], &u->omega[j], 8);
    }
  }
  sd_simulation_free(a);
  end_run(b, plain);
  sd_model_free(other);
}

RUN_TESTS(TEST(one_step_is_exact), TEST(a_step_keeps_the_stationary_law),
          TEST(covariance_is_that_of_the_theory), TEST(vibration_is_stationary_from_the_first_step),
          TEST(intervals_are_exact_at_their_multiples),
          TEST(between_draws_the_velocity_is_the_derivative), TEST(longer_intervals_converge),
          TEST(numbers_belong_to_body_and_coordinate))
