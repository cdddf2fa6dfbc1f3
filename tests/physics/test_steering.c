/* test_steering.c: changes of a running simulation (sd_simulation_set) and phases that hold and
 * release disks: closed forms, the energy budget, the same bits with any threads and after saving,
 * refused values. */
#include "unit.h"

#include "model/laws.h"
#include "model/state.h"
#include "slipdisk/slipdisk.h"

static void check(sd_status status, sd_messages *m) {
  if (status != SD_OK) sd_messages_print(m, stderr);
  assert_int_equal(status, SD_OK);
}

static sd_simulation *begin(const char *deck, const char *integrator, int threads) {
  sd_messages *m = sd_messages_new();
  sd_model *model;
  sd_simulation *sim, *own;
  char set[64];
  snprintf(set, sizeof set, "integrator=%s", integrator);
  check(sd_deck_load_text(deck, "deck", 1, (const char *[]){set}, &model, m), m);
  check(sd_simulation_new(model, threads, &sim, m), m);
  check(sd_simulation_clone(sim, &own, m), m); /* owns its model */
  sd_simulation_free(sim);
  sd_model_free(model);
  sd_messages_free(m);
  return own;
}

static void advance(sd_simulation *sim, int64_t n) {
  sd_messages *m = sd_messages_new();
  check(sd_simulation_advance(sim, n, m), m);
  sd_messages_free(m);
}

static void set(sd_simulation *sim, const char *name, uint32_t index, double value) {
  sd_messages *m = sd_messages_new();
  check(sd_simulation_set(sim, name, 1, &index, &value, m), m);
  sd_messages_free(m);
}

static double get(sd_simulation *sim, const char *name, uint32_t index) {
  return sd_simulation_get(sim, name, index);
}

static void near(double is, double expected, double tolerance) {
  if (!(fabs(is - expected) <= tolerance)) {
    fprintf(stderr, "%.17g, expected %.17g +- %.3g\n", is, expected, tolerance);
    fail();
  }
}

static void closed(sd_simulation *sim, double tolerance) {
  const sd_energy e = sd_simulation_energy(sim);
  near(e.residual, 0, tolerance * e.scale);
}

static const char *const integrators[] = {"gear5", "verlet"};
#define FOR_INTEGRATORS for (const char *const *how = integrators; how < integrators + 2; how++)

#define GRAIN                                                                                      \
  "materials = ( { name = \"grain\"; k_n = 1e4; k_t = 8e3; mu = 0.5; gamma_n = 2.0; } );\n"
static const char thrown[] =
    "dt = 1e-3; gravity = { g = 10.0; };\n" GRAIN
    "disks = ( { name = \"a\"; x = 0.0; y = 0.0; radius = 1.0; mass = 2.0; },\n"
    "          { name = \"b\"; x = 9.0; y = 0.0; radius = 1.0; mass = 2.0; fixed = true; } );\n";

/* A disk falls from rest, is thrown, falls to the side, and gets another place. */
static void test_thrown(void **unused) {
  FOR_INTEGRATORS {
    sd_simulation *sim = begin(thrown, *how, 1);
    advance(sim, 100);
    near(get(sim, "vy", 0), -1, 1e-12);
    sd_messages *m = sd_messages_new();
    check(sd_simulation_set(sim, "velocity", 1, (uint32_t[]){0}, (double[]){3, 4}, m), m);
    sd_messages_free(m);
    const double y = get(sim, "y", 0), work = sd_simulation_energy(sim).work;
    near(work, 25 - 1, 1e-12);
    closed(sim, 1e-12);
    advance(sim, 200);
    near(get(sim, "x", 0), 0.6, 1e-12);
    near(get(sim, "y", 0), y + 4 * 0.2 - 5 * 0.04, 1e-12);
    near(get(sim, "vy", 0), 2, 1e-12);
    set(sim, "gravity", SD_Y, 0);
    set(sim, "gravity", SD_X, -5);
    closed(sim, 1e-12);
    advance(sim, 400);
    near(get(sim, "vy", 0), 2, 1e-12);
    near(get(sim, "vx", 0), 1, 1e-12);
    near(get(sim, "x", 0), 0.6 + 3 * 0.4 - 2.5 * 0.16, 1e-12);
    set(sim, "x", 0, -7);
    set(sim, "omega", 0, 0.5);
    set(sim, "angle", 0, 1000);
    set(sim, "mass", 0, 4);
    advance(sim, 100);
    near(get(sim, "x", 0), -7 + 0.1 - 0.025, 1e-12);
    near(get(sim, "angle", 0), 1000.05, 1e-11);
    near(get(sim, "vx", 0), 0.5, 1e-12);
    closed(sim, 1e-12);
    sd_simulation_free(sim);
  }
}

/* A disk rests on a fixed one; with twice the stiffness it oscillates about a higher place. */
static const char spring[] =
    "dt = 1e-4; contact_variant = \"conservative\";\n"
    "materials = ( { name = \"grain\"; k_n = 1e4; } );\n"
    "disks = ( { x = 0.0; y = 1.99; radius = 1.0; mass = 1.0; vy = 0.0; },\n"
    "          { x = 0.0; y = 0.0; radius = 1.0; mass = 1.0; fixed = true; } );\n"
    "forces = ( { disk = 0; force = (0.0, -100.0); } );\n";

static void test_spring(void **unused) {
  FOR_INTEGRATORS {
    sd_simulation *sim = begin(spring, *how, 1);
    advance(sim, 1000);
    near(get(sim, "y", 0), 1.99, 1e-9); /* in equilibrium: overlap 0.01 */
    const sd_energy before = sd_simulation_energy(sim);
    set(sim, "law.k_n", 0, 2e4);
    near(sd_simulation_energy(sim).work - before.work, 0.5 * 1e4 * 0.01 * 0.01, 1e-9);
    advance(sim, 2000); /* y = 1.995 - 0.005 cos(w t), w^2 = 2e4 */
    near(get(sim, "y", 0), 1.995 - 0.005 * cos(sqrt(2e4) * 0.2), **how == 'g' ? 1e-7 : 3e-6);
    closed(sim, 1e-4);
    sd_simulation_free(sim);
  }
}

/* A disk that is pressed on the floor and pushed sideways sticks, and slides with a smaller mu. */
static const char pushed[] =
    "dt = 1e-4; gravity = { g = 10.0; };\n" GRAIN
    "disks = ( { x = 0.0; y = 0.999; radius = 1.0; mass = 1.0; locked = \"theta\"; } );\n"
    "walls = ( { name = \"floor\"; type = \"line\"; points = ([0.0, 0.0], [1.0, 0.0]); } );\n"
    "forces = ( { disk = 0; force = (3.0, 0.0); } );\n";

static void test_friction(void **unused) {
  FOR_INTEGRATORS {
    sd_simulation *sim = begin(pushed, *how, 1);
    advance(sim, 100000);
    const double x = get(sim, "x", 0);
    near(x, 0, 1e-2);
    set(sim, "law.mu", 0, 0.1);
    advance(sim, 10000); /* a = 3 - 0.1 * 10 = 2 */
    near(get(sim, "vx", 0), 2, 0.05);
    closed(sim, 1e-3);
    sd_simulation_free(sim);
  }
}

/* A plate at constant speed, and one that vibrates, go on from where they are. */
static const char plates[] =
    "dt = 1e-3;\n" GRAIN "disks = ( { x = 0.0; y = 5.0; radius = 1.0; mass = 1.0; } );\n"
    "walls = ( { name = \"left\"; type = \"segment\"; points = ([-9.0, -4.0], [-8.0, -4.0]); },\n"
    "          { name = \"right\"; type = \"segment\"; points = ([8.0, -4.0], [9.0, -4.0]); } );\n"
    "motions = ( { name = \"lift\"; wall = \"left\"; coordinate = \"y\"; type = \"velocity\"; "
    "velocity = 0.5; },\n"
    "  { name = \"shake\"; wall = \"right\"; coordinate = \"y\"; type = \"harmonic\"; amplitude = "
    "0.1; omega = 3.0; } );\n";

static double column(sd_simulation *sim, const char *name, uint32_t body) {
  sd_column c;
  assert_true(sd_simulation_column(sim, name, &c));
  return ((const double *)c.data)[sd_simulation_slot(sim, body)];
}

static void test_motions(void **unused) {
  FOR_INTEGRATORS for (int small = 0; small < 2; small++) {
    sd_simulation *sim = begin(plates, *how, 1);
    if (!small) set(sim, "held", 0, 0); /* the general step */
    advance(sim, 1000);
    const double left = column(sim, "y", SD_WALL(0)), right = column(sim, "y", SD_WALL(1));
    assert_int_equal(sd_simulation_index(sim, "motion.velocity", "lift", NULL), 0);
    set(sim, "motion.velocity", 0, -1);
    set(sim, "motion.amplitude", sd_simulation_index(sim, "motion.amplitude", "shake", NULL), 0.2);
    near(column(sim, "vy", SD_WALL(0)), -1, 1e-14);
    near(column(sim, "vy", SD_WALL(1)), 0.6 * cos(3), 1e-12);
    advance(sim, 500);
    near(column(sim, "y", SD_WALL(0)), left - 0.5, 1e-12);
    near(column(sim, "y", SD_WALL(1)), right + 0.2 * (sin(4.5) - sin(3)), 1e-12);
    sd_simulation_free(sim);
  }
}

/* A fixed intruder that a motion pulls is released, held and released again, by the phases of a
 * deck and by calls. */
static const char intruder[] =
    "dt = 1e-3; gravity = { g = 10.0; };\n" GRAIN
    "disks = ( { name = \"grain\"; x = 20.0; y = 0.0; radius = 1.0; mass = 1.0; },\n"
    "          { name = \"ball\"; x = 0.0; y = 0.0; radius = 1.0; mass = 1.0; fixed = true; } );\n"
    "motions = ( { name = \"pull\"; disk = \"ball\"; coordinate = \"x\"; type = \"velocity\"; "
    "velocity = 2.0; } );\n";

/* vy: velocity afterwards; 0 if the disk is held again then */
static void falls(sd_simulation *sim, double x, double vx, double vy) {
  near(get(sim, "x", 1), x, 1e-12);
  near(get(sim, "y", 1), 0, 1e-12);
  advance(sim, 300);
  near(get(sim, "y", 1), -5 * 0.09, 1e-12);
  near(get(sim, "x", 1), x + 0.3 * vx, 1e-12);
  near(get(sim, "vy", 1), vy, 1e-12);
  near(sd_simulation_energy(sim).work, 0, 1e-12); /* neither holding nor releasing does work */
  closed(sim, 1e-12);
}

static void test_release(void **unused) {
  FOR_INTEGRATORS {
    char deck[1200];
    snprintf(deck, sizeof deck,
             "%sphases = ( { name = \"pull\"; steps = 100; },"
             "{ name = \"fall\"; steps = 300; release = (\"ball\"); },"
             "{ name = \"again\"; steps = 100; hold = \"ball\"; },"
             "{ name = \"free\"; steps = 100; release = 1; } );\n",
             intruder);
    sd_simulation *sim = begin(deck, *how, 1), *other = begin(intruder, *how, 1);
    advance(sim, 100);
    falls(sim, 0.2, 2, 0);
    near(get(sim, "held", 1), 1, 0);
    advance(sim, 100); /* held, and moved by the motion from where it was */
    near(get(sim, "x", 1), 0.8 + 0.2, 1e-12);
    near(get(sim, "y", 1), -0.45, 1e-12);
    closed(sim, 1e-12);
    advance(sim, 100);
    near(get(sim, "y", 1), -0.45 - 0.05, 1e-12);
    near(get(sim, "x", 1), 1.2, 1e-12);
    assert_true(sd_simulation_finished(sim));
    sd_simulation_free(sim);
    advance(other, 100);
    set(other, "held", 1, 0);
    falls(other, 0.2, 2, -3);
    set(other, "held", 1, 1);
    near(get(other, "vy", 1), 0, 0);
    advance(other, 100);
    near(get(other, "x", 1), 1, 1e-12);
    near(get(other, "y", 1), -0.45, 1e-12);
    set(other, "y", 1, 3);
    set(other, "x", 1, 5);
    advance(other, 100);
    near(get(other, "x", 1), 5.2, 1e-12);
    near(get(other, "y", 1), 3, 1e-12);
    closed(other, 1e-12);
    sd_simulation_free(other);
  }
}

/* A box of disks that swell: the pressure rises, and the budget stays closed. */
static const char box[] =
    "dt = 2e-5; seed = 3;\n"
    "materials = ( { name = \"grain\"; k_n = 1e4; k_t = 8e3; mu = 0.5; gamma_n = 2.0; } );\n"
    "container = { type = \"box\"; width = 1.0; height = 1.0; };\n"
    "packings = ( { type = \"square\"; count = 64; spacing = 0.12; jitter = 0.3; radius = 0.05; "
    "density = 1.0; } );\n";

/* To hold what is held is the same as to release a disk that was never held, also while a contact
 * swings. */
static void test_held_twice(void **unused) {
  FOR_INTEGRATORS for (int held = 0; held < 2; held++) {
    char deck[1200];
    snprintf(deck, sizeof deck,
             "%swalls = ( { type = \"line\"; points = ((0, -1), (1, -1)); } );\nsteps = 1000;\n",
             intruder);
    sd_simulation *sim[2];
    for (int k = 0; k < 2; k++) {
      sim[k] = begin(deck, *how, 1);
      set(sim[k], "held", 1, 0);
      advance(sim[k], 20);
      if (held) set(sim[k], "held", 1, 1);
      advance(sim[k], 20);
      set(sim[k], "held", k ? 1 : 0, k && held); /* the other disk was free */
      advance(sim[k], 20);
    }
    const sd_field *f =
        sd_state_difference(sd_simulation_state(sim[0]), sd_simulation_state(sim[1]));
    if (f) fail_msg("%s, held %d: %s", *how, held, f->name);
    for (int k = 0; k < 2; k++) sd_simulation_free(sim[k]);
  }
}

static void test_swelling(void **unused) {
  FOR_INTEGRATORS {
    sd_simulation *sim = begin(box, *how, 1);
    double elastic = 0;
    sd_messages *m = sd_messages_new();
    for (int k = 1; k <= 40; k++) {
      double radius[64];
      for (int i = 0; i < 64; i++) radius[i] = 0.05 * (1 + 0.008 * k);
      check(sd_simulation_set(sim, "radius", 64, NULL, radius, m), m);
      advance(sim, 500);
      closed(sim, 1e-3);
    }
    const sd_energy e = sd_simulation_energy(sim);
    elastic = e.elastic_normal;
    assert_true(elastic > 1e-3);
    assert_true(e.work > elastic);
    sd_messages_free(m);
    sd_simulation_free(sim);
  }
}

/* A fixed disk is released among so many that slots are sorted by position. */
static const char many[] =
    "dt = 2e-5; seed = 3; gravity = { g = 10.0; };\n"
    "materials = ( { name = \"grain\"; k_n = 1e4; k_t = 8e3; mu = 0.5; gamma_n = 2.0; } );\n"
    "container = { type = \"box\"; width = 6.0; height = 4.0; };\n"
    "disks = ( { name = \"ball\"; x = 0.0; y = 3.8; radius = 0.05; mass = 1.0; fixed = true; } );\n"
    "packings = ( { type = \"square\"; count = 1300; spacing = 0.11; jitter = 0.9;"
    "               radius = 0.05; density = 1.0; } );\n";

static void test_many(void **unused) {
  uint64_t hash[3];
  for (int k = 0; k < 3; k++) {
    sd_messages *m = sd_messages_new();
    sd_simulation *sim = begin(many, "verlet", 1 + k), *copy;
    advance(sim, 200);
    set(sim, "held", 0, 0);
    closed(sim, 1e-3);
    if (k == 2) {
      check(sd_simulation_clone(sim, &copy, m), m);
      sd_simulation_free(sim);
      sim = copy;
    }
    advance(sim, 1000);
    near(get(sim, "y", 0), 3.8 - 5 * 0.02 * 0.02, 1e-12);
    set(sim, "held", 0, 1);
    set(sim, "vx", 700, 1);
    advance(sim, 200);
    near(get(sim, "y", 0), 3.8 - 5 * 0.02 * 0.02, 1e-12);
    closed(sim, 1e-2);
    hash[k] = sd_state_hash(sd_simulation_state(sim));
    sd_simulation_free(sim);
    sd_messages_free(m);
  }
  assert_true(hash[0] == hash[1] && hash[0] == hash[2]);
}

static const char sheared[] =
    "dt = 1e-4;\n" GRAIN "box = { x = (0.0, 20.0); y = (0.0, 20.0); periodic = \"xy\"; };\n"
    "disks = ( { x = 5.0; y = 5.0; radius = 1.0; mass = 1.0; } );\n"
    "phases = ( { steps = 1000; cell = { rate_xy = 0.1; }; } );\n";

static void refused(sd_simulation *sim, const char *name, uint32_t index, double value,
                    const char *expected) {
  sd_messages *m = sd_messages_new();
  const uint64_t before = sd_state_hash(sd_simulation_state(sim));
  assert_int_equal(sd_simulation_set(sim, name, 1, &index, &value, m), SD_ERROR_USER);
  assert_true(before == sd_state_hash(sd_simulation_state(sim)));
  if (!strstr(sd_messages_text(m, 0), expected)) {
    fprintf(stderr, "\"%s\", expected \"%s\"\n", sd_messages_text(m, 0), expected);
    fail();
  }
  sd_messages_free(m);
}

static void test_refused(void **unused) {
  sd_simulation *sim = begin(pushed, "verlet", 1), *two = begin(intruder, "verlet", 1),
                *move = begin(plates, "verlet", 1);
  refused(sim, "omega", 0, 1, "locked, held or prescribed");
  refused(sim, "vx", 0, NAN, "expected a number of at most 1e100");
  refused(sim, "vx", 1, 1, "expected one of the 1 disks");
  refused(sim, "velocty", 0, 1, "did you mean \"velocity\"");
  refused(sim, "radius", 0, -1, "expected a number > 0");
  refused(sim, "y", 0, 0.3, "max_overlap");
  refused(sim, "gravity", 2, 1, "expected 0 (x) or 1 (y)");
  refused(sim, "law.k_n", 0, 1e14, "dt");
  refused(sim, "law.mu", 0, -1, "expected a number >= 0");
  refused(sim, "law.mu", 1, 1, "materials");
  char quantity[32]; /* each number among the keys of a law has a value */
  for (size_t k = 0; k < law_table.n; k++) {
    snprintf(quantity, sizeof quantity, "law.%s", law_table.key[k].name);
    assert_int_equal(isnan(sd_simulation_get(sim, quantity, 0)),
                     law_table.key[k].target != DECK_SETS_NUMBER);
  }
  refused(sim, "mu", 0, 1, "did you mean \"law.mu\"");
  refused(sim, "law.mu_kinetc", 0, 1, "did you mean \"law.mu_kinetic\"");
  refused(sim, "law.k_r", 0, 1e3, "columns");
  refused(sim, "held", 0, 2, "expected 1 (hold) or 0 (release)");
  refused(two, "vx", 1, 1, "fixed or driven");
  refused(two, "motion.amplitude", 0, 1, "expected a wave");
  refused(two, "motion.velocity", 1, 1, "expected one of the 1 motions");
  refused(move, "motion.amplitude", 0, 1, "expected a wave");
  sd_simulation *shear = begin(sheared, "verlet", 1);
  refused(shear, "gravity", 1, -1, "disks fall through the periodic box");
  refused(shear, "held", 0, 1, "it is held or released in the box of phases[0].cell");
  refused(shear, "x", 0, 99, "outside the periodic box");
  sd_simulation_free(sim);
  sd_simulation_free(two);
  sd_simulation_free(move);
  sd_simulation_free(shear);
}

/* Gravity whose direction turns: the exact path of a disk. */
static void test_turning(void **unused) {
  static const char deck[] =
      "dt = 1e-3;\n" GRAIN "disks = ( { x = 0.0; y = 0.0; radius = 1.0; mass = 2.0; } );\n"
      "fields = ( { type = \"gravity\"; g = 10.0; tilt = 0.3; omega = 2.0; } );\n";
  FOR_INTEGRATORS {
    sd_simulation *sim = begin(deck, *how, 1);
    advance(sim, 1000);
    /* v = (g/w) (cos phi - cos phi0, sin phi0 - sin phi), phi = 2.3, phi0 = 0.3 */
    near(get(sim, "vx", 0), 5 * (cos(2.3) - cos(0.3)), 5e-6);
    near(get(sim, "vy", 0), 5 * (sin(0.3) - sin(2.3)), 5e-6);
    closed(sim, 1e-5);
    sd_simulation_free(sim);
  }
}

RUN_TESTS(TEST(test_thrown), TEST(test_spring), TEST(test_friction), TEST(test_motions),
          TEST(test_release), TEST(test_held_twice), TEST(test_swelling), TEST(test_refused),
          TEST(test_turning), TEST(test_many))
