/* test_laws_mixed.c: three materials whose six pairs have laws drawn at random: the same bits by every way of running, and an
 * energy budget that closes with the square of the time step.
 */
#include "brief.h"
#include "laws.h"

static const double mass = 4.5e-3, mean_radius = 0.02;

static bool heads(uint64_t *seed) { return next_bits(seed) >> 63; }
/* Between two values, evenly in the logarithm. */
static double drawn(uint64_t *seed, double low, double high) {
  return low * pow(high / low, next_uniform(seed));
}

static law drawn_law(uint64_t *seed) {
  law l = {.normal = heads(seed), .tangential = heads(seed), .damping_pulls = heads(seed)};
  l.k_n = drawn(seed, 5e3, 2e4) * (l.normal == SD_NORMAL_HERTZ ? 300 : 1);
  if (heads(seed)) l.gamma_n = drawn(seed, 0.2, 3);
  if (heads(seed)) l.restitution = 0.3 + 0.7 * next_uniform(seed);
  if (next_uniform(seed) < 0.8) {
    l.mu = drawn(seed, 0.1, 1);
    if (heads(seed)) l.mu_kinetic = l.mu * (0.4 + 0.6 * next_uniform(seed));
    l.k_t = drawn(seed, 2e3, 1e4) * (l.tangential == SD_TANGENTIAL_MINDLIN ? 100 : 1);
    if (heads(seed)) l.gamma_t = drawn(seed, 0.1, 2);
    if (heads(seed)) l.critical_load = mass * 9.81 * drawn(seed, 0.3, 30);
  }
  if (heads(seed)) {
    l.mu_r = drawn(seed, 0.01, 0.5);
    l.k_r = drawn(seed, 5e2, 5e3);
    if (heads(seed)) l.gamma_r = drawn(seed, 0.1, 1);
  }
  if (heads(seed)) l.drag_r = drawn(seed, 0.1, 1);
  const double what = next_uniform(seed);
  if (what < 0.67) {
    l.cohesion = what < 0.33 ? SD_COHESION_CONSTANT : SD_COHESION_BRIDGE;
    l.pull_off = mass * 9.81 * drawn(seed, 0.3, 10);
    l.range = drawn(seed, 1e-4, 1e-3);
    if (what >= 0.33) l.rupture = l.range * drawn(seed, 1, 4);
  }
  return l;
}

/* Hertz' law of about these stiffnesses, from a modulus and Poisson's ratio. */
static void take_modulus(law *l) {
  if (l->normal != SD_NORMAL_HERTZ) return;
  l->E_star = 0.75 * l->k_n / sqrt(0.5 * mean_radius);
  if (l->tangential == SD_TANGENTIAL_MINDLIN && l->k_t > 0)
    l->poisson = 0.5 * fmin(fmod(l->k_t, 1000) / 1000 + 1e-3, 1);
}

static void add_laws(text *t, uint64_t *seed) {
  static const char *const names[] = {"a", "b", "c"}, *const between_two[] = {"(\"a\", \"b\")",
                                                                              "(\"a\", \"c\")",
                                                                              "(\"b\", \"c\")"};
  char name[64];
  const bool moduli = *seed % 3 == 2;
  text_add(t, "materials = (");
  for (int k = 0; k < 6; k++) {
    if (k == 3) text_add(t, " );\nmaterial_pairs = (");
    snprintf(name, sizeof name, k < 3 ? "name = \"%s\"" : "materials = %s",
             k < 3 ? names[k] : between_two[k - 3]);
    law l = drawn_law(seed);
    if (moduli) take_modulus(&l);
    text_add(t, "%s", k % 3 ? ", " : "");
    law_add(t, name, &l);
  }
  text_add(t, " );\n");
}

static void add_head(text *t, double dt, uint64_t seed) {
  text_add(t,
           "dt = %.17g; integrator = \"%s\"; contact_variant = \"%s\"; steps = 1e15; gravity = { g "
           "= 60; };\n",
           dt, system_integrators[seed % 2], system_variants[seed / 2 % 2]);
}

/* A packing that falls on a shaken floor with segments and a round wall. */
static sd_model *packing(uint64_t seed, double dt, const char *integrator) {
  enum { WIDE = 9, HIGH = 7 };
  text t = {0};
  add_head(&t, dt, integrator ? strcmp(integrator, "verlet") == 0 : seed);
  add_laws(&t, &seed);
  text_add(&t, "box = { x = (0, %.17g); periodic = \"x\"; };\n", WIDE * 2.01 * mean_radius);
  text_add(&t,
           "walls = ( { name = \"f\"; type = \"line\"; points = ( (0, 0), (1, 0) ); material = "
           "\"a\"; },\n"
           "{ type = \"segment\"; points = ( (0.03, 0.09), (0.1, 0.12) ); material = \"b\"; },\n"
           "{ type = \"circle\"; center = (0.25, 0.1); radius = 0.04; side = \"outside\"; "
           "material = \"c\"; } );\n");
  text_add(&t,
           "motions = ( { wall = \"f\"; coordinate = \"y\"; type = \"harmonic\"; amplitude = 1e-3; "
           "frequency = 40; } );\n");
  text_add(&t, "disk_rows = ( ");
  for (int k = 0; k < 3; k++) {
    text_add(&t,
             "%s{ columns = (\"x\", \"y\", \"radius\", \"vx\", \"vy\", \"omega\"); density = "
             "3.57; material = \"%c\"; rows = (",
             k ? ", " : "", 'a' + k);
    bool first = true;
    for (int n = 0; n < WIDE * HIGH; n++) {
      double x = 2.01 * mean_radius * (n % WIDE + 0.5),
             y = mean_radius * (1.02 + 2.01 * (n / WIDE));
      double r = mean_radius * (0.9 + 0.1 * next_uniform(&seed)), v[3];
      for (int c = 0; c < 3; c++) v[c] = 0.4 * (next_uniform(&seed) - 0.5);
      bool clear = (hypot(x - 0.25, y - 0.1) > 0.062) &&
                   (x > 0.13 || fabs(y - 0.09 - (x - 0.03) * 3 / 7) > 0.024);
      if (n % 3 != k || !clear) continue;
      text_add(&t, "%s(%.6f, %.6f, %.6f, %.3f, %.3f, %.2f)", first ? "" : ", ", x, y, r, v[0], v[1],
               10 * v[2]);
      first = false;
    }
    text_add(&t, ") }");
  }
  text_add(&t, " );\n");
  return model_of_text(&t);
}

enum { SEEDS = BRIEF(12, 3), STEPS = 2500 };

static void budget_closes(void **unused) {
  enum { LEVELS = 3 };
  double logs[LEVELS] = {0}, worst[LEVELS] = {0};
  sd_energy total = {0};
  for (uint64_t seed = 1; seed <= SEEDS; seed++)
    for (int k = 0; k < LEVELS; k++) {
      sd_model *m = packing(seed, 5e-6 / (1 << k), "verlet");
      m->variant = SD_CONSERVATIVE;
      sd_simulation *s = begin_run(m, 1);
      advance(s, 5000 << k);
      double residual = laws_residual(s);
      logs[k] += log(residual) / SEEDS;
      worst[k] = fmax(worst[k], residual);
      sd_energy e = sd_simulation_energy(s);
      total.rolling += e.rolling, total.bridge += e.bridge, total.viscous += e.viscous,
          total.friction += e.friction;
      total.elastic_rolling += e.elastic_rolling, total.cohesion += e.cohesion;
      end_run(s, m);
    }
  for (int k = 0; k < LEVELS; k++)
    print_message("dt %.2e: residual/scale typically %.1e, at most %.1e\n", 5e-6 / (1 << k),
                  exp(logs[k]), worst[k]);
  /* every term took part */
  assert_true(total.rolling > 0 && total.bridge > 0 && total.viscous > 0 && total.friction > 0);
  assert_true(total.elastic_rolling > 0 && total.cohesion < 0);
  assert_true(exp(logs[LEVELS - 1]) < 2e-6 && worst[LEVELS - 1] < 1e-5);
  assert_true(exp(logs[0] - logs[LEVELS - 1]) > 8); /* 16 when it falls with dt^2 */
}

RUN_TESTS(TEST(budget_closes))
