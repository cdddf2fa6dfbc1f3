/* test_laws_normal.c: restitution against speed, by every way of damping, with and without the cutoff. */
#include "brief.h"
#include "laws.h"

static const double speeds[] = {1e-3, 1e-2, 0.1, 1, 10};
enum { SPEEDS = sizeof speeds / sizeof *speeds };

/* Of a contact without damping; Hertz: Landau and Lifshitz, Theory of Elasticity 9. */
static double duration(const law *l, double mass, double speed) {
  const double integral = sqrt(M_PI) * tgamma(1.4) / tgamma(0.9);
  return l->normal == SD_NORMAL_HERTZ
             ? 2 * pow(1.25 * mass / l->k_n, 0.4) * pow(speed, -0.2) * integral
             : M_PI * sqrt(mass / l->k_n);
}

/* What a disk hits: free disk, floor, held disk, round walls. */
enum { FREE, FLOOR, HELD, ROUND, DRUM, TARGETS };
static const char *const targets[] = {"disk", "floor", "held disk", "round wall", "drum"};

static hit head_on(const law *l, double speed, sd_integrator integrator, int target, int parts) {
  hit h = {.floor = target == FLOOR,
           .fixed = target == HELD,
           .round = target == ROUND  ? 1
                    : target == DRUM ? -1
                                     : 0,
           .radius = {1, target == DRUM ? 3 : 1.5},
           .mass = {0.1, 0.3},
           .beta = 0.7,
           .integrator = integrator};
  h.dt = duration(l, hit_mass(&h), speed) / parts;
  h.gap = 10.3 * speed * h.dt;
  if (target == FLOOR)
    h.velocity[0][1] = -speed;
  else
    h.velocity[0][0] = speed * cos(h.beta), h.velocity[0][1] = speed * sin(h.beta);
  return h;
}

/* Speed after over speed before; the contact is over. */
static double restitution(const law *l, const hit *h, double speed, double *residual) {
  sd_simulation *s = laws_impact(l, h);
  double lasts = duration(l, hit_mass(h), speed);
  for (int k = 0; k < 12 && (k < 2 || sd_simulation_state(s)->n_contacts); k++)
    system_advance(s, (int64_t)(0.8 * lasts / h->dt));
  assert_int_equal(sd_simulation_state(s)->n_contacts, 0);
  system_body a = system_at(s, 0), b = {0};
  if (!h->floor) b = system_at(s, 1); /* a wall has no velocity */
  double after = h->floor ? a.vy : (b.vx - a.vx) * cos(h->beta) + (b.vy - a.vy) * sin(h->beta);
  *residual = laws_residual(s);
  system_end(s);
  return after / speed;
}

static void look(const law *l, double expected, const char *what) {
  double worst = 0, worst_residual = 0;
  for (int i = 0; i < 2; i++)
    for (int target = 0; target < TARGETS; target++)
      for (int k = i; k < SPEEDS; k += BRIEF(target < HELD ? 1 : 4, 4)) {
        hit h = head_on(l, speeds[k], (sd_integrator)i, target, BRIEF(100000, 20000));
        h.general = target % 2 == 0;
        double residual, e = restitution(l, &h, speeds[k], &residual);
        SYSTEM_NEAR(e, expected, BRIEF(1e-4, 5e-4), "%s, %s, %s, speed %g: restitution", what,
                    targets[target], system_integrators[i], speeds[k]);
        worst = fmax(worst, fabs(e - expected));
        worst_residual = fmax(worst_residual, residual);
      }
  print_message("%s: e = %.4f, error %.1e, residual %.1e\n", what, expected, worst, worst_residual);
  assert_true(worst_residual < 1e-6);
}

/* Without the cutoff: exp(-b pi/w), w^2 = k_n/m - b^2. */
static double without_cutoff(double b) { return exp(-M_PI * b / sqrt(1 - b * b)); }

/* A viscosity that makes b the same for both pairs of masses. */
static void linear_viscosity(void **unused) {
  for (int pulls = 0; pulls < 2; pulls++)
    for (double b = 0.05; b < 0.8; b *= 3) {
      double expected = pulls ? without_cutoff(b) : sd_restitution(1, 2 * b, 1).restitution;
      for (int floor = 0; floor < 2; floor++)
        for (int k = 0; k < SPEEDS; k += 2) {
          law l = {.k_n = 1e4, .damping_pulls = pulls};
          hit h = head_on(&l, speeds[k], SD_VERLET, floor, BRIEF(100000, 20000));
          l.gamma_n = 2 * b * sqrt(l.k_n * hit_mass(&h));
          double residual, e = restitution(&l, &h, speeds[k], &residual);
          SYSTEM_NEAR(e, expected, BRIEF(1e-4, 5e-4), "gamma_n, b = %g, speed %g, cutoff %d", b,
                      speeds[k], !pulls);
        }
    }
}

static void coefficient(void **unused) {
  static const double asked[] = {0.1, 0.5, 0.9};
  for (int hertz = 0; hertz < 2; hertz++)
    for (int pulls = 0; pulls < 2; pulls++)
      for (size_t k = 0; k < sizeof asked / sizeof *asked; k++) {
        law l = {.k_n = 1e4, .normal = hertz, .damping_pulls = pulls, .restitution = asked[k]};
        char what[64];
        snprintf(what, sizeof what, "%s, restitution, cutoff %d", hertz ? "hertz" : "linear",
                 !pulls);
        look(&l, asked[k], what);
      }
  law elastic = {.k_n = 1e4, .restitution = 1};
  look(&elastic, 1, "linear, restitution of 1");
}

/* Both dampings add up. */
static void coefficient_and_viscosity(void **unused) {
  for (int pulls = 0; pulls < 2; pulls++) {
    law l = {.k_n = 1e4, .damping_pulls = pulls, .restitution = 0.8};
    hit h = head_on(&l, 0.3, SD_VERLET, false, BRIEF(100000, 20000));
    double b = 0.1 + law_damping_ratio(0.8, pulls), residual;
    l.gamma_n = 2 * 0.1 * sqrt(l.k_n * hit_mass(&h));
    double expected = pulls ? without_cutoff(b) : sd_restitution(1, 2 * b, 1).restitution;
    SYSTEM_NEAR(restitution(&l, &h, 0.3, &residual), expected, BRIEF(1e-4, 5e-4),
                "cutoff %d: e of both", !pulls);
  }
}

/* Hertz with gamma_n: slow impacts are damped more. */
static void hertz_viscosity(void **unused) {
  for (int pulls = 0; pulls < 2; pulls++) {
    double least = 1, most = 0, worst = 0;
    for (int k = 0; k < SPEEDS; k++)
      for (int i = 0; i < 2; i++) {
        law l = {.k_n = 1e4, .normal = SD_NORMAL_HERTZ, .damping_pulls = pulls, .gamma_n = 1.5};
        hit h = head_on(&l, speeds[k], (sd_integrator)i, false, BRIEF(100000, 20000));
        double residual, e = restitution(&l, &h, speeds[k], &residual);
        reference q = reference_new(&l, &h);
        const int parts = 4000;
        double lasts = duration(&l, hit_mass(&h), speeds[k]);
        reference_advance(&q, lasts / parts, 30);
        for (int n = 0; q.reach > 0 && n < 40 * parts; n++) reference_advance(&q, lasts / parts, 1);
        assert_true(q.reach <= 0);
        double expected = ((q.s[RATE + 3] - q.s[RATE]) * cos(h.beta) +
                           (q.s[RATE + 4] - q.s[RATE + 1]) * sin(h.beta)) /
                          speeds[k];
        SYSTEM_NEAR(e, expected, BRIEF(1e-4, 5e-4), "hertz, gamma_n, speed %g, cutoff %d",
                    speeds[k], !pulls);
        assert_true(residual < 1e-6);
        least = fmin(least, e), most = fmax(most, e), worst = fmax(worst, fabs(e - expected));
      }
    print_message("hertz, gamma_n, cutoff %d: e from %.4f to %.4f, error %.1e\n", !pulls, least,
                  most, worst);
    assert_true(most - least > 0.3);
  }
}

/* Without the cutoff the force at the end is -gamma_n e v; with it, it is never below 0. */
static void pull(void **unused) {
  for (int pulls = 0; pulls < 2; pulls++) {
    law l = {.k_n = 1e4, .gamma_n = 20, .damping_pulls = pulls};
    hit h = head_on(&l, 1, SD_VERLET, false, 100000);
    sd_simulation *s = laws_impact(&l, &h);
    double least = 0, b = l.gamma_n / (2 * sqrt(l.k_n * hit_mass(&h)));
    for (int k = 0; k < 130000; k++) {
      system_advance(s, 1);
      system_body a = system_at(s, 0);
      least = fmin(least, -(a.force_x * cos(h.beta) + a.force_y * sin(h.beta)));
    }
    SYSTEM_NEAR(least, pulls ? -l.gamma_n * without_cutoff(b) : 0, 1e-3,
                "cutoff %d: force at the end", !pulls);
    system_end(s);
  }
}

RUN_TESTS(TEST(linear_viscosity), TEST(coefficient), TEST(coefficient_and_viscosity),
          TEST(hertz_viscosity), TEST(pull))
