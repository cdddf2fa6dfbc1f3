/* test_waves.c: square and triangle waves against their formulas in extended precision, their largest velocity and
 * acceleration, the energy of disks that they drive, alone and in lanes, and mistakes in decks. */
#include "brief.h"
#include "deck_runs.h"
#include "model/model.h"

#define DT 0x1p-12 /* a power of 2: step * DT is exact */

typedef struct value {
  long double u, v, a;
} value;

static const long double pi = 3.14159265358979323846264338327950288L;

/* Distance from the middle of a flank, in half periods: [-1/2, 1/2]; direction of the flank. */
static long double flank(long double phase, int *direction) {
  long double z = phase / pi, n = nearbyintl(z);
  *direction = fmodl(fabsl(n), 2) == 0 ? 1 : -1;
  return z - n;
}

static value triangle(long double phase, long double w) {
  int d;
  long double z = flank(phase, &d);
  return (value){d * 2 * z, d * 2 * w / pi, 0};
}

/* The change of sides as the integral of a pulse (1 - q^2)^2. */
static value square(long double phase, long double w, long double rise) {
  int d;
  long double z = flank(phase, &d), q = 2 * z / rise, dq = 2 * w / (pi * rise);
  if (fabsl(q) >= 1) return (value){q > 0 ? d : -d, 0, 0};
  long double pulse = (1 - q * q) * (1 - q * q);
  return (value){d * 15 * (q - 2 * q * q * q / 3 + q * q * q * q * q / 5) / 8,
                 d * 15 * pulse * dq / 8, -d * 15 * q * (1 - q * q) / 2 * dq * dq};
}

/* A driven disk. */
static sd_model *driven(const char *moves) {
  text t = {0};
  text_add(&t, "dt = %.17g; steps = 1000000; gravity = { g = 9.81; };\n", DT);
  text_add(&t,
           "materials = ( { name = \"m\"; k_n = 1e3; } );\n"
           "disks = ( { name = \"d\"; x = 0; y = 0; radius = 1; mass = 1; fixed = true; } );\n");
  text_add(&t, "motions = ( %s );\n", moves);
  return model_of_text(&t);
}

#define SQUARE(r) "type = \"square\"; amplitude = 0.125; omega = 62.8; phase = 0.7; rise = " #r ";"
#define TRIANGLE "type = \"triangle\"; amplitude = -0.125; omega = 62.8; phase = 0.7;"

/* rise 0: a triangle. Steep flanks carry the rounding of the phase, 3e-14, further. */
static void compare(const char *move, int coordinate, long double amplitude, long double rise) {
  text t = {0};
  text_add(&t, "{ disk = \"d\"; coordinate = \"%s\"; %s }", coordinate == SD_X ? "x" : "theta",
           move);
  sd_model *model = driven(t.s);
  sd_simulation *sim = begin_run(model, 1);
  double worst_u = 0, worst_v = 0, most = 0;
  const long double w = 62.8;
  for (int k = 1; k <= 10000; k++) {
    advance(sim, 1);
    const sd_state *s = sd_simulation_state(sim);
    long double phase = w * (long double)DT * k + (long double)0.7;
    value f = rise > 0 ? square(phase, w, rise) : triangle(phase, w);
    double u = coordinate == SD_X ? s->x[0] : s->turn[0] + s->theta[0],
           v = coordinate == SD_X ? s->vx[0] : s->omega[0];
    int d;
    worst_u = fmax(worst_u, (double)fabsl(u / amplitude - f.u));
    most = fmax(most, fabs(v));
    if (rise == 0 && fabsl(fabsl(flank(phase, &d)) - 0.5L) < 1e-13L) continue; /* either velocity */
    worst_v = fmax(worst_v, (double)fabsl(v / amplitude - f.v) / (double)w);
  }
  double steep = rise > 0 ? (double)(1 / rise) : 1,
         peak = (double)(rise > 0 ? 15 * w / (4 * pi * rise) : 2 * w / pi);
  print_message("  %-75s relative errors: u %.2g, u' %.2g\n", t.s, worst_u, worst_v);
  between(worst_u, 0, 3e-14 * steep, "displacement");
  between(worst_v, 0, 3e-14 * steep * steep, "velocity");
  between(most / fabs((double)amplitude) / peak, rise > 0 ? 0.97 : 1 - 1e-12, 1 + 1e-12,
          "largest velocity");
  end_run(sim, model);
  free(t.s);
}

static void waves_follow_their_formulas(void **unused) {
  compare(TRIANGLE, SD_X, -0.125L, 0);
  compare(TRIANGLE, SD_THETA, -0.125L, 0);
  compare(SQUARE(1), SD_X, 0.125L, 1);
  compare(SQUARE(0.25), SD_X, 0.125L, 0.25L);
  compare(SQUARE(0.25), SD_THETA, 0.125L, 0.25L);
  compare(SQUARE(0.0625), SD_X, 0.125L, 0.0625L);
}

/* Second differences find the acceleration that the deck asked for. */
static void a_square_has_its_acceleration(void **unused) {
  sd_model *model =
      driven("{ disk = \"d\"; coordinate = \"y\"; type = \"square\"; acceleration = 3; "
             "frequency = 2; rise = 0.5; }");
  sd_simulation *sim = begin_run(model, 1);
  double largest = 0, jump = 0, last = 0, before = 0;
  for (int k = 0; k < 4096; k++) {
    advance(sim, 1);
    double v = sd_simulation_state(sim)->vy[0], a = (v - before) / DT;
    before = v;
    if (k == 0) continue;
    if (k > 1) jump = fmax(jump, fabs(a - last));
    largest = fmax(largest, fabs(a));
    last = a;
  }
  between(largest / (3 * 9.81), 1 - 1e-4, 1 + 1e-4, "largest acceleration");
  between(jump / largest, 0, 0.03, "change of the acceleration in a step");
  end_run(sim, model);
}

/* A disk that lies on a floor, thrown and struck by it. */
static double floor_residual(const char *integrator, double dt, const char *wave) {
  text t = {0};
  text_add(&t, "dt = %.17g; steps = %.0f; integrator = \"%s\"; gravity = { g = 10; };\n", dt,
           0.4 / dt, integrator);
  text_add(&t,
           "materials = ( { name = \"m\"; k_n = 1e4; k_t = 1e4; gamma_n = 20; mu = 0.3; } );\n");
  text_add(&t, "disks = ( { x = 0; y = 0.0999; radius = 0.1; mass = 0.1; } );\n");
  text_add(&t, "walls = ( { name = \"floor\"; type = \"line\"; points = ((0, 0), (1, 0)); } );\n");
  text_add(&t,
           "motions = ( { wall = \"floor\"; coordinate = (\"x\", \"y\"); amplitude = 0.002; "
           "frequency = 5; ramp = 0.1; %s } );\n",
           wave);
  sd_model *model = model_of(t.s);
  sd_simulation *sim = begin_run(model, 1);
  advance(sim, model->phases[0].steps);
  sd_energy energy = sd_simulation_energy(sim);
  assert_true(energy.scale > 1e-3); /* it was moved: m g A is 2e-3 */
  double residual = fabs(energy.residual / energy.scale);
  end_run(sim, model);
  free(t.s);
  return residual;
}

static void energy_is_balanced(void **unused) {
  const char *const waves[] = {"type = \"square\"; rise = 0.5;", "type = \"triangle\";"};
  const char *const integrators[] = {"gear5", "verlet"};
  for (int w = 0; w < 2; w++)
    for (int i = 0; i < 2; i++) {
      if (BRIEF(0, i != w)) continue;
      double coarse = floor_residual(integrators[i], 1e-5, waves[w]),
             fine = floor_residual(integrators[i], 2.5e-6, waves[w]);
      print_message("  %-30s %-7s residual/scale %.2g, with a quarter of the step %.2g\n", waves[w],
                    integrators[i], coarse, fine);
      between(coarse, 0, 2e-6, "residual");
      between(fine / coarse, 0, 0.12, "residual with a finer step over that with a coarse one");
    }
}

static void refused(const char *move, const char *what) {
  text t = {0};
  sd_model *m = NULL;
  sd_messages *messages = sd_messages_new();
  text_add(&t,
           "dt = 1e-3; steps = 10; gravity = { g = 9.81; }; materials = ( { name = \"m\"; k_n = "
           "1e4; } );\n"
           "disks = ( { name = \"d\"; x = 0; y = 0; radius = 1; mass = 1; fixed = true; } );\n"
           "motions = ( { name = \"shake\"; disk = \"d\"; coordinate = \"y\"; %s } );\n",
           move);
  assert_int_equal(sd_deck_load_text(t.s, "test.cfg", 0, NULL, &m, messages), SD_ERROR_USER);
  if (sd_messages_count(messages) != 1 || !strstr(sd_messages_text(messages, 0), what)) {
    print_error("%s\nexpected: %s\n", move, what);
    sd_messages_print(messages, stderr);
    fail();
  }
  sd_messages_free(messages);
  free(t.s);
}

static void mistakes_are_told(void **unused) {
#define WAVE(type, more) "type = \"" type "\"; amplitude = 0.1; frequency = 1; " more
  refused(WAVE("square", ""), "missing: type \"square\" needs it (square: share of half a period");
  refused(WAVE("square", "rise = 0;"), "expected a number > 0");
  refused(WAVE("square", "rise = 1.5;"), "expected a number > 0 and <= 1");
  refused(
      WAVE("square", "rise = 0.01;"),
      "test.cfg:3: motions[0]: rise = 0.01: a change of sides takes 5 steps, expected 8 or more");
  refused(WAVE("triangle", "rise = 0.1;"), "does not belong to type \"triangle\"");
  refused(WAVE("harmonic", "rise = 0.1;"), "does not belong to type \"harmonic\"");
  refused(WAVE("triangle", "acceleration = 2;"), "does not belong to type \"triangle\"");
  refused("type = \"triangle\"; frequency = 1;", "amplitude");
}

RUN_TESTS(TEST(waves_follow_their_formulas), TEST(a_square_has_its_acceleration),
          TEST(energy_is_balanced), TEST(mistakes_are_told))
