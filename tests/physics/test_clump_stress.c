/* Stress with clumps: closed forms of two dimers in a periodic box, and forces on the walls of smooth boxes in which dimers
 * and rods are pressed together. */
#include "brief.h"
#include "deck_runs.h"
#include "measure/measurement.h"
#include "measure/resultant.h"
#include "pack/compress.h"
#include "pack/settle.h"
#include "physics/step/access.h"
#include "system.h"

static const char *const component[] = {"xx", "xy", "yx", "yy"};

static resultants row_of(sd_simulation *s) {
  resultants r;
  const sd_model *m = sd_simulation_model(s);
  resultants_new(&r, m);
  assert_int_equal(
      resultants_compute(&r, m, sd_simulation_state(s), engine_slots(engine_of(s)), NULL, NULL),
      SD_OK);
  return r;
}

/* again: contacts are not known and found again. */
static measurement measurement_of(sd_simulation *s, bool again) {
  frame_data f;
  measurement m = {0};
  sd_messages *messages = sd_messages_new();
  const sd_model *model = sd_simulation_model(s);
  sd_status status = frame_data_of_state(&f, model, sd_simulation_state(s), messages);
  if (again) f.has_contacts = false;
  if (status == SD_OK) status = measurement_new(&m, model, &f, NULL, 20, messages);
  sd_messages_print(messages, stderr);
  assert_int_equal(status, SD_OK);
  sd_messages_free(messages);
  frame_data_free(&f);
  return m;
}

/* Series, compression and slipdisk measure agree with each other. */
static void all_say_the_same(sd_simulation *s, double small) {
  resultants r = row_of(s);
  measurement m = measurement_of(s, false);
  for (int k = 0; k < 4; k++) {
    SYSTEM_NEAR(m.s.contact[k], r.stress[k], small, "stress %s of measure", component[k]);
    SYSTEM_NEAR(m.s.kinetic[k], r.kinetic[k], small, "kinetic stress %s of measure", component[k]);
  }
  const double pressure = 0.5 * (r.stress[STRESS_XX] + r.stress[STRESS_YY]);
  SYSTEM_NEAR(compress_pressure(engine_of(s)), pressure, small, "pressure of a compression");
  if (sd_simulation_model(s)->phases[0].compress.asked)
    SYSTEM_NEAR(r.pressure, pressure, small, "pressure of the series");
  measurement_free(&m);
  resultants_free(&r);
}

enum { WIDTH = 11, HEIGHT = 7 };
static const double K = 1000, RADIUS = 1, D = 0.8, OVERLAP = 0.01, FORCE = 10,
                    AREA = WIDTH * HEIGHT;

static sd_model *box_of(double width, double height) {
  sd_model *m = system_new(SD_VERLET, SD_PAPER, 1e-3, (sd_contact_law){.k_n = K});
  const double size[2] = {width, height};
  for (int k = 0; k < 2; k++) {
    m->periodic[k] = true;
    m->upper[k] = m->region_upper[k] = size[k];
  }
  m->measure_stress = true;
  return m;
}

/* Of these directions; its disks stand in the box. */
static void add_dimer(sd_model *m, double x, double y, double dx, double dy,
                      const double velocity[3]) {
  uint32_t disks[2];
  for (int n = 0; n < 2; n++) {
    const double way = n ? D : -D, at[2] = {x + way * dx, y + way * dy};
    double in[2];
    for (int k = 0; k < 2; k++)
      in[k] = m->periodic[k] ? at[k] - m->upper[k] * floor(at[k] / m->upper[k]) : at[k];
    disks[n] = system_disk(m, in[0], in[1], RADIUS, 0.5);
  }
  const sd_clump c = {
      .n_disks = 2, .disks = disks, .velocity = {velocity[0], velocity[1], velocity[2]}};
  sd_model_add_clump(m, &c);
}

static const double REST[3] = {0, 0, 0};

static sd_simulation *start(sd_model *m) {
  sd_simulation *s = system_start(m);
  system_advance(s, 0);
  return s;
}

/* One contact, through which there is a force (F, 0): sigma = l f/A with l between the centres of the dimers. The first lies along
 * x, the second stands on end, with its lower disk before the end of the first. */
static void two_dimers_touch_anywhere(void **unused) {
  const double l[2] = {D + 2 * RADIUS - OVERLAP, D};
  for (int place = 0; place < 40; place++) {
    const double x = 0.3 + place * WIDTH / 20.0, y = 0.1 + place * HEIGHT / 9.0;
    sd_model *m = box_of(WIDTH, HEIGHT);
    add_dimer(m, x, y, 1, 0, REST);
    add_dimer(m, x + l[0], y + l[1], 0, 1, REST);
    sd_simulation *s = start(m);
    resultants r = row_of(s);
    const double expected[4] = {l[0] * FORCE / AREA, 0, l[1] * FORCE / AREA, 0};
    assert_int_equal(r.contacts, 1);
    for (int k = 0; k < 4; k++)
      SYSTEM_NEAR(r.stress[k], expected[k], 1e-11 * FORCE, "stress %s at place %d", component[k],
                  place);
    measurement found = measurement_of(s, false);
    SYSTEM_NEAR(found.s.unbalanced, 1, 1e-10, "one force on each dimer");
    assert_int_equal(found.s.clumps, 2);
    measurement_free(&found);
    resultants_free(&r);
    all_say_the_same(s, 1e-11 * FORCE);
    system_end(s);
  }
}

/* A ring of dimers, end to end through the edge: a cut across carries F, whatever the dimers are long. */
static void a_row_of_dimers_carries_its_force(void **unused) {
  const double pitch = 2 * D + 2 * RADIUS - OVERLAP;
  for (int place = 0; place < 12; place++) {
    sd_model *m = box_of(3 * pitch, HEIGHT);
    for (int n = 0; n < 3; n++) add_dimer(m, (n + place / 12.0) * pitch, 6.5, 1, 0, REST);
    sd_simulation *s = start(m);
    resultants r = row_of(s);
    assert_int_equal(r.contacts, 3);
    for (int k = 0; k < 4; k++)
      SYSTEM_NEAR(r.stress[k], k ? 0 : FORCE / HEIGHT, 1e-11 * FORCE, "stress %s", component[k]);
    resultants_free(&r);
    measurement found = measurement_of(s, false), again = measurement_of(s, true);
    SYSTEM_NEAR(found.s.unbalanced, 0, 1e-10, "at rest");
    assert_int_equal(found.s.rattlers, 6); /* without friction two contacts hold nothing */
    assert_int_equal(again.s.n_contacts, 3);
    SYSTEM_NEAR(again.s.contact[STRESS_XX], FORCE / HEIGHT, 1e-10 * FORCE, "contacts found again");
    for (size_t i = 0; i < 6; i++)
      SYSTEM_NEAR(measurement_pressure(&found, i) * 3 * pitch * HEIGHT, 0.5 * FORCE * 3 * pitch,
                  1e-9 * FORCE, "pressure of disk %zu", i);
    measurement_free(&found);
    measurement_free(&again);
    all_say_the_same(s, 1e-11 * FORCE);
    system_end(s);
  }
}

/* Dimers that turn are at rest; others have M (v - u)(v - u)/A and M v^2/2. */
static void kinetic_stress_is_that_of_the_centres(void **unused) {
  const double v[3] = {0.3, -0.7, 5};
  sd_model *m = box_of(WIDTH, HEIGHT);
  add_dimer(m, 0.5, 6.8, 1, 0, v);
  add_dimer(m, 6, 3, 0.6, 0.8, REST);
  sd_simulation *s = start(m);
  resultants r = row_of(s);
  for (int k = 0; k < 4; k++) {
    SYSTEM_NEAR(r.kinetic[k], 2 * 0.25 * v[k / 2] * v[k % 2] / AREA, 1e-13, "kinetic stress %s",
                component[k]);
    SYSTEM_NEAR(r.stress[k], 0, 0, "stress %s", component[k]);
  }
  resultants_free(&r);
  measurement found = measurement_of(s, false);
  const double inertia = 2 * 0.5 * (RADIUS * RADIUS / 2 + D * D);
  SYSTEM_NEAR(found.s.energy_translation, 0.25 * (v[0] * v[0] + v[1] * v[1]), 1e-13,
              "energy of translation");
  SYSTEM_NEAR(found.s.energy_rotation, 0.25 * inertia * v[2] * v[2], 1e-12, "energy of rotation");
  measurement_free(&found);
  all_say_the_same(s, 1e-13);
  system_end(s);
}

/* A mass and an inertia of its own: the centre stays where the masses of the disks put it. */
static void a_given_mass_counts(void **unused) {
  sd_model *m = system_new(SD_VERLET, SD_PAPER, 1e-3, (sd_contact_law){.k_n = K});
  const uint32_t disks[2] = {system_disk(m, 0, 0, 1, 1), system_disk(m, 1.5, 0, 0.5, 0.2)};
  const sd_clump c = {.n_disks = 2,
                      .disks = disks,
                      .mass = 6,
                      .inertia = 7,
                      .velocity = {1, 0, 2},
                      .force = {0, 3, 0}};
  sd_model_add_clump(m, &c);
  system_disk(m, 5, 0, 1, 1);
  sd_simulation *s = start(m);
  measurement found = measurement_of(s, false);
  SYSTEM_NEAR(found.s.energy_translation, 1.5, 1e-13, "energy of translation");
  SYSTEM_NEAR(found.s.energy_rotation, 7, 1e-13, "energy of rotation");
  SYSTEM_NEAR(found.c.clumps[0].position[0], 0.25, 1e-15, "centre");
  SYSTEM_NEAR(found.c.clumps[0].force[1], 3, 0, "force on the clump");
  measurement_free(&found);
  system_end(s);
}

static const char *const pressed =
    "integrator = \"verlet\"; contact_variant = \"conservative\"; dt = 1e-3;\n"
    "materials = ( { name = \"g\"; k_n = 1e4; k_t = 5e3; restitution = 0.3; mu = %g; }, { name = "
    "\"smooth\"; k_n = 1e4; } );\n"
    "material_pairs = ( { materials = (\"g\", \"smooth\"); k_n = 1e4; restitution = 0.3; } );\n"
    "container = { type = \"%s\"; width = %g; height = %g; %s };\n"
    "packings = ( { type = \"random\"; fraction = %g; radius = 0.5; density = 1; material = "
    "\"g\"; %s } );\n"
    "phases = ( { time = 100; compress = { pressure = 10; rate = 0.05; }; settle = { unbalanced "
    "= 0.01; }; },\n"
    "  { time = 60; relax = true; settle = { unbalanced = 1e-10; }; } );\n"
    "measure = { stress = true; box = true; %s rotation = (); };\n";
static const char *const dimers = "clump = { at = ([-0.8, 0], [0.8, 0]); };";
static const char *const rods =
    "clump = { at = ([-1.6, 0], [-0.8, 0], [0, 0], [0.8, 0], [1.6, 0]); };";

static sd_simulation *press(const char *grains, double mu, bool walls, double size,
                            double fraction) {
  text t = {0};
  text_add(&t, pressed, mu, walls ? "box" : "periodic", size, size,
           walls ? "open = false; material = \"smooth\";" : "", fraction, grains,
           walls ? "walls = true;" : "");
  sd_simulation *s = begin_run(model_of(t.s), 1);
  free(t.s);
  advance(s, 160000);
  return s;
}

static void end(sd_simulation *s) {
  sd_model *m = (sd_model *)(uintptr_t)sd_simulation_model(s);
  end_run(s, m);
}

/* Both walls across a direction feel the stress along it; without friction at the walls there is no force along them. */
static void walls_feel_the_stress(sd_simulation *s, double small) {
  resultants r = row_of(s);
  const sd_model *m = sd_simulation_model(s);
  double on[2][2] = {{0}}; /* lower and upper wall of each direction */
  for (size_t w = 0; w < m->n_walls; w++) {
    on[0][r.wall[w].force_x > 0] += r.wall[w].force_x;
    on[1][r.wall[w].force_y > 0] += r.wall[w].force_y;
  }
  for (int side = 0; side < 2; side++) {
    SYSTEM_NEAR(fabs(on[0][side]) / r.height, r.stress[STRESS_XX], small, "force on a wall, x");
    SYSTEM_NEAR(fabs(on[1][side]) / r.width, r.stress[STRESS_YY], small, "force on a wall, y");
  }
  SYSTEM_NEAR(r.stress[STRESS_XY], r.stress[STRESS_YX], small, "symmetric");
  resultants_free(&r);
}

static void check_pressed(const char *name, sd_simulation *s, double size) {
  const double p = compress_pressure(engine_of(s)), small = 1e-7 * p;
  measurement found = measurement_of(s, false);
  const double unbalanced = settle_measure_now(engine_of(s)).unbalanced;
  print_message(
      "  %s: pressure %.6g, stress %.6g %.6g %.6g %.6g, unbalanced %.2g, %zu rattlers of %zu\n",
      name, p, found.s.contact[0], found.s.contact[1], found.s.contact[2], found.s.contact[3],
      unbalanced, found.s.rattlers, found.s.free);
  assert_true(unbalanced < 1e-10);
  assert_true(found.width < size);
  SYSTEM_NEAR(p, 10, 0.5, "pressure, as far as the relaxation leaves it");
  SYSTEM_NEAR(found.s.unbalanced, unbalanced, 1e-12, "unbalanced force of measure and settle");
  if (sd_simulation_model(s)->n_walls > 0) walls_feel_the_stress(s, small);
  SYSTEM_NEAR(found.s.contact[STRESS_XY], found.s.contact[STRESS_YX], small, "symmetric");
  all_say_the_same(s, 1e-11 * p);
  /* cells are those of the disks, pressures those of the clumps: together they are the trace */
  double sum = 0;
  for (size_t i = 0; i < found.c.model->n_disks; i++) {
    const double here = measurement_pressure(&found, i);
    if (isfinite(here)) sum += here * found.cells.area[i];
  }
  if (found.cells.n_open == 0)
    SYSTEM_NEAR(sum / found.s.area, p, 1e-9 * p, "mean of the pressures on disks");
  measurement_free(&found);
}

static void walls_of_a_smooth_box_feel_the_stress(void **unused) {
  const struct {
    const char *name, *grains;
    double mu, size, fraction;
  } cases[] = {{"dimers", dimers, 0.2, 12, 0.4},
               {"disks", "", 0.2, 12, 0.5},
               {"dimers without friction", dimers, 0, 12, 0.4},
               {"rods", rods, 0.2, 20, 0.25}};
  for (size_t k = 0; k < BRIEF(4, 1); k++) {
    sd_simulation *s = press(cases[k].grains, cases[k].mu, true, cases[k].size, cases[k].fraction);
    check_pressed(cases[k].name, s, cases[k].size);
    end(s);
  }
}

static void a_periodic_box_has_a_symmetric_stress(void **unused) {
  for (size_t k = 0; k < BRIEF(2, 1); k++) {
    sd_simulation *s = press(dimers, k ? 0.2 : 0, false, 12, 0.4);
    check_pressed("periodic dimers", s, 12);
    if (k == 0) {
      measurement found = measurement_of(s, false), again = measurement_of(s, true);
      assert_int_equal(again.s.n_contacts, found.s.n_contacts);
      for (int c = 0; c < 4; c++)
        SYSTEM_NEAR(again.s.contact[c], found.s.contact[c], 1e-9,
                    "stress %s of contacts found again", component[c]);
      measurement_free(&found);
      measurement_free(&again);
    }
    end(s);
  }
}

RUN_TESTS(TEST(two_dimers_touch_anywhere), TEST(a_row_of_dimers_carries_its_force),
          TEST(kinetic_stress_is_that_of_the_centres), TEST(a_given_mass_counts),
          TEST(walls_of_a_smooth_box_feel_the_stress), TEST(a_periodic_box_has_a_symmetric_stress))
