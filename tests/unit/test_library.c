/* test_library.c: the public headers alone: models that are built, columns, observers, force fields, disks that come and go,
 * saving, loading, clones. Nothing of src/ is included. */
#include <unistd.h>

#include "unit.h"
#include "slipdisk/slipdisk.h"

static const sd_contact_law law = {.k_n = 1e4, .k_t = 8e3, .gamma_n = 2.0, .mu = 0.5};

static void show(sd_messages *messages) {
  sd_messages_print(messages, stderr);
  sd_messages_free(messages);
}

static sd_simulation *begin(const sd_model *model, int threads) {
  sd_messages *messages = sd_messages_new();
  sd_simulation *sim;
  if (sd_simulation_new(model, threads, &sim, messages) != SD_OK) {
    show(messages);
    fail();
  }
  sd_messages_free(messages);
  return sim;
}

static void finish(sd_model *model) {
  sd_messages *messages = sd_messages_new();
  if (sd_model_finish(model, messages) != SD_OK) {
    show(messages);
    fail();
  }
  sd_messages_free(messages);
}

static void advance(sd_simulation *sim, int64_t n) {
  sd_messages *messages = sd_messages_new();
  if (sd_simulation_advance(sim, n, messages) != SD_OK) {
    show(messages);
    fail();
  }
  sd_messages_free(messages);
}

/* n disks in rows above a floor that shakes, between two side walls. */
static sd_model *heap(size_t n, const char *integrator) {
  sd_model *m = sd_model_new();
  sd_model_set_text(m, "integrator", integrator);
  sd_model_set(m, "dt", 1e-4);
  sd_model_set_gravity(m, 0.0, -10.0);
  const int steel = sd_model_add_material(m, "steel", &law);
  double points[2][2] = {{0, 0}, {1, 0}};
  uint32_t floor = sd_model_add_wall(m, &(sd_wall){.name = "floor",
                                                   .kind = SD_WALL_LINE,
                                                   .material = steel,
                                                   .n_points = 2,
                                                   .points = points});
  const size_t wide = n < 16 ? 4 : 40;
  for (int side = 0; side < 2; side++) {
    const double x = side * ((double)wide * 1.05 + 0.5);
    double ends[2][2] = {{x, 0}, {x, 1}};
    sd_model_add_wall(m, &(sd_wall){.kind = SD_WALL_LINE, .n_points = 2, .points = ends});
  }
  for (size_t k = 0; k < n; k++)
    sd_model_add_disk(
        m, &(sd_disk){.position = {0.8 + 1.05 * (double)(k % wide) + 0.01 * (double)(k / wide % 3),
                                   0.52 + 1.02 * (double)(k / wide)},
                      .radius = 0.5 - 0.02 * (double)(k % 3),
                      .mass = 1.0});
  sd_model_add_motion(m, &(sd_motion){.name = "shake",
                                      .kind = SD_MOTION_HARMONIC,
                                      .coordinate = SD_Y,
                                      .n_bodies = 1,
                                      .bodies = &floor,
                                      .amplitude = 0.02,
                                      .omega = 30.0});
  finish(m);
  return m;
}

static void end(sd_simulation *sim, sd_model *model) {
  sd_simulation_free(sim);
  sd_model_free(model);
}

static void a_built_model_is_that_of_the_deck(void **state) {
  static const char deck[] =
      "integrator = \"verlet\"; dt = 1e-3; seed = 7; time = 2.0; gravity = { g = 10.0; };"
      "materials = ( { name = \"m\"; k_n = 1e4; k_t = 8e3; gamma_n = 2.0; mu = 0.5; } );"
      "disks = ( { name = \"a\"; x = 0.0; y = 0.51; radius = 0.5; mass = 2.0; vx = 1.0; } );"
      "walls = ( { name = \"floor\"; type = \"line\"; points = ( (0.0, 0.0), (1.0, 0.0) ); } );"
      "motions = ( { name = \"shake\"; wall = \"floor\"; type = \"random\"; coordinate = \"y\";"
      " amplitude = 0.01; omega = 20.0; damping = 0.5; interval = 10; } );";
  sd_messages *messages = sd_messages_new();
  sd_model *read = NULL;
  if (sd_deck_load_text(deck, "test.cfg", 0, NULL, &read, messages) != SD_OK) {
    show(messages);
    fail();
  }
  sd_messages_free(messages);

  sd_model *m = sd_model_new();
  char name[] = "a";
  double points[2][2] = {{0, 0}, {1, 0}};
  sd_model_set_text(m, "integrator", "verlet");
  sd_model_set(m, "dt", 1e-3);
  sd_model_set(m, "seed", 7);
  sd_model_set_gravity(m, 0.0, -10.0);
  sd_model_add_material(m, "m", &law);
  uint32_t floor = sd_model_add_wall(
      m, &(sd_wall){.name = "floor", .pivot = {0.5, 0}, .n_points = 2, .points = points});
  assert_int_equal(sd_model_add_motion(m, &(sd_motion){.name = "shake",
                                                       .kind = SD_MOTION_RANDOM,
                                                       .coordinate = SD_Y,
                                                       .n_bodies = 1,
                                                       .bodies = &floor,
                                                       .amplitude = 0.01,
                                                       .omega = 20.0,
                                                       .damping = 0.5,
                                                       .interval = 10}),
                   0);
  sd_model_add_disk(
      m, &(sd_disk){
             .name = name, .position = {0.0, 0.51}, .velocity = {1.0}, .radius = 0.5, .mass = 2.0});
  sd_model_add_phase(m, &(sd_phase){.name = "run", .steps = 2000, .measure = true});
  sd_model_measure_rotation(m, 1, &(uint32_t){0});
  name[0] = 'x'; /* what was given is not needed any more */
  points[0][1] = 100.0;
  floor = 77;
  finish(m);
  assert_int_equal(sd_model_find(m, "a"), 0);
  assert_int_equal(sd_model_find(m, "floor"), 1);
  assert_int_equal(sd_model_find(m, "x"), UINT32_MAX);
  assert_int_equal(sd_model_bodies(m), 2);

  sd_simulation *one = begin(read, 1), *other = begin(m, 1);
  advance(one, 5000);
  advance(other, 5000);
  assert_true(sd_simulation_finished(one) && sd_simulation_finished(other));
  const sd_field *different =
      sd_state_difference(sd_simulation_state(one), sd_simulation_state(other));
  if (different) fail_msg("column %s differs", different->name);
  end(one, read);
  end(other, m);
}

static void all_mistakes_are_told_at_once(void **state) {
  static const char *const expected[] = {
      "dtt: no key that a model has (did you mean dt?)",
      "integrator = \"euler\": expected one of \"gear5\", \"verlet\"",
      "seed = 1.5: expected a whole number",
      "law of materials 0 and 3: expected two of the 1 that there are",
      "group \"g\": disk 9 does not exist",
      "dt = 0: expected a number > 0",
      "disk 0: radius = 0: expected a number > 0",
      "disk 0: mass = 0: expected a number > 0",
      "motion 0: body 5 does not exist",
  };
  sd_model *m = sd_model_new();
  sd_messages *messages = sd_messages_new();
  sd_model_set(m, "dtt", 1e-3);
  sd_model_set_text(m, "integrator", "euler");
  sd_model_set(m, "seed", 1.5);
  sd_model_add_material(m, "m", &law);
  sd_model_set_law(m, 0, 3, &law);
  sd_model_add_disk(m, &(sd_disk){0});
  sd_model_add_group(m, "g", 1, &(uint32_t){9});
  sd_model_add_motion(
      m, &(sd_motion){.kind = SD_MOTION_VELOCITY, .n_bodies = 1, .bodies = &(uint32_t){5}});
  assert_int_equal(sd_model_finish(m, messages), SD_ERROR_USER);
  for (size_t k = 0; k < sizeof expected / sizeof *expected; k++) {
    bool found = false;
    for (size_t i = 0; i < sd_messages_count(messages); i++)
      found = found || strstr(sd_messages_text(messages, i), expected[k]);
    if (!found) {
      sd_messages_print(messages, stderr);
      fail_msg("not told: %s", expected[k]);
    }
  }
  sd_messages_free(messages);
  sd_model_free(m);
}

static void columns_stand_in_place(void **state) {
  sd_model *m = heap(8, "gear5");
  sd_simulation *sim = begin(m, 1);
  sd_column x, y, force, none;
  assert_true(sd_simulation_column(sim, "x", &x) && sd_simulation_column(sim, "y", &y));
  assert_false(sd_simulation_column(sim, "z", &none));
  assert_int_equal(x.type, SD_F64);
  assert_int_equal(x.extent, SD_PER_BODY);
  assert_int_equal(x.n, sd_model_bodies(m));
  assert_string_equal(x.unit, "length");
  const double before = ((const double *)y.data)[0];
  advance(sim, 1000);
  assert_true(((const double *)y.data)[0] != before); /* the same place, stepped on */
  advance(sim, 20000);
  assert_true(sd_simulation_column(sim, "contact_force", &force));
  assert_true(force.n >= 1);
  size_t n = 0;
  for (sd_column c; sd_simulation_column_at(sim, n, &c); n++) assert_non_null(c.name);
  assert_int_equal(n, sd_field_count);
  end(sim, m);
}

typedef struct notes {
  size_t n;
  int64_t step[32];
  int64_t stop;
} notes;

static sd_status note(sd_simulation *sim, void *user) {
  notes *seen = user;
  const int64_t step = sd_simulation_step(sim);
  if (seen->n < 32) seen->step[seen->n++] = step;
  return step == seen->stop ? SD_INTERRUPTED : SD_OK;
}

static void observers_come_at_their_steps_and_change_nothing(void **state) {
  sd_model *m = heap(8, "verlet");
  sd_simulation *plain = begin(m, 1), *seen = begin(m, 1);
  notes often = {.stop = 2100}, seldom = {.stop = -1};
  assert_int_equal(sd_simulation_observe(seen, 700, note, &often), SD_OK);
  assert_int_equal(sd_simulation_observe(seen, 1000, note, &seldom), SD_OK);
  assert_int_equal(sd_simulation_advance(seen, 5000, NULL), SD_INTERRUPTED);
  assert_int_equal(sd_simulation_step(seen), 2100);
  advance(seen, 2900);
  advance(plain, 5000);
  assert_null(sd_state_difference(sd_simulation_state(plain), sd_simulation_state(seen)));
  assert_int_equal(often.n, 7);
  assert_int_equal(often.step[6], 4900);
  assert_int_equal(seldom.n, 5);
  assert_int_equal(seldom.step[0], 1000);
  sd_simulation_free(seen);
  end(plain, m);
}

/* Weight 10 and a linear drag: closed form for a disk that falls. */
static const double DRAG = 3.0;
static void weight_and_drag(const sd_force_columns *c, void *user) {
  *(int64_t *)user += 1;
  for (size_t i = 0; i < c->n_free; i++) {
    c->force_x[i] -= DRAG * c->vx[i];
    c->force_y[i] -= 10.0 * c->mass[i] + DRAG * c->vy[i];
    c->torque[i] -= DRAG * c->omega[i];
  }
}

/* Errors of vx, vy, y, omega after a time of 1. */
static void fall_errors(const char *integrator, double dt, double error[4]) {
  sd_model *m = sd_model_new();
  sd_model_set_text(m, "integrator", integrator);
  sd_model_set(m, "dt", dt);
  sd_model_add_material(m, "m", &law);
  sd_model_add_disk(m, &(sd_disk){.velocity = {2.0, 0.0, 4.0}, .radius = 1.0, .mass = 2.0});
  finish(m);
  sd_simulation *sim = begin(m, 1);
  int64_t calls = 0;
  const int64_t n = (int64_t)nearbyint(1.0 / dt);
  assert_int_equal(sd_simulation_add_force_field(sim, weight_and_drag, &calls, NULL), SD_OK);
  advance(sim, n);
  assert_int_equal(calls, n + 1); /* once for step 0 */
  const double rate = DRAG / 2.0, fall = 10.0 / rate, left = exp(-rate);
  const char *const names[4] = {"vx", "vy", "y", "omega"};
  const double exact[4] = {2.0 * left, -fall * (1.0 - left), -fall * (1.0 - (1.0 - left) / rate),
                           4.0 * exp(-DRAG)};
  for (int k = 0; k < 4; k++) {
    sd_column column;
    assert_true(sd_simulation_column(sim, names[k], &column));
    error[k] = *(const double *)column.data - exact[k];
  }
  const sd_energy energy = sd_simulation_energy(sim);
  assert_true(fabs(energy.work) > 1.0 && fabs(energy.residual) < dt * dt * 10.0 * energy.scale);
  end(sim, m);
}

/* Both integrators are of second order here: Verlet's forces see predicted velocities, Gear's higher derivatives are 0 at
 * the start. */
static void a_force_field_gives_the_closed_form(void **state) {
  const char *const integrators[2] = {"gear5", "verlet"};
  for (int i = 0; i < 2; i++) {
    double coarse[4], fine[4];
    fall_errors(integrators[i], 2e-4, coarse);
    fall_errors(integrators[i], 1e-4, fine);
    for (int k = 0; k < 4; k++) {
      assert_true(fabs(fine[k]) < 1e-7);
      assert_true(coarse[k] / fine[k] > 3.5 && coarse[k] / fine[k] < 4.5);
    }
  }
}

/* A spring towards the middle of the disks' floor, which moves them about among contacts. */
static void spring(const sd_force_columns *c, void *user) {
  (void)user;
  for (size_t i = 0; i < c->n_free; i++) {
    c->force_x[i] += 2.0 * (20.0 - c->x[i]);
    c->torque[i] += 0.1 * sin(c->theta[i] + c->turn[i] + c->time);
  }
}

static void forces_do_not_depend_on_threads_or_restarts(void **state) {
  for (int integrator = 0; integrator < 2; integrator++) {
    sd_model *m = heap(2400, integrator ? "verlet" : "gear5");
    sd_simulation *one = begin(m, 1), *two = begin(m, 2), *again;
    assert_int_equal(sd_simulation_add_force_field(one, spring, NULL, NULL), SD_OK);
    assert_int_equal(sd_simulation_add_force_field(two, spring, NULL, NULL), SD_OK);
    assert_int_equal(sd_simulation_threads(two), 2);
    advance(one, 400);
    advance(two, 150);
    void *data;
    size_t size;
    assert_int_equal(sd_simulation_save_memory(two, &data, &size, NULL), SD_OK);
    sd_simulation_free(two);
    assert_int_equal(sd_simulation_load_memory(data, size, 2, &again, NULL), SD_OK);
    sd_free(data);
    assert_int_equal(sd_simulation_add_force_field(again, spring, NULL, NULL), SD_OK);
    advance(again, 250);
    const sd_field *different =
        sd_state_difference(sd_simulation_state(one), sd_simulation_state(again));
    if (different) fail_msg("column %s differs", different->name);
    const sd_energy energy = sd_simulation_energy(one);
    assert_true(fabs(energy.residual) < 2e-3 * energy.scale);
    sd_simulation_free(again);
    end(one, m);
  }
}

/* The step of small systems knows no fields: the general one takes over, with the same bits. */
static void nothing(const sd_force_columns *c, void *user) { (void)c, (void)user; }

static void a_field_of_no_force_changes_no_bit(void **state) {
  sd_model *m = sd_model_new();
  sd_model_set(m, "dt", 1e-4);
  sd_model_set_gravity(m, 0.0, -10.0);
  sd_model_add_material(m, "m", &law);
  sd_model_add_disk(m, &(sd_disk){.radius = 1.0, .mass = 1.0, .driven = true});
  sd_model_add_disk(m, &(sd_disk){.position = {0.2, 1.9}, .radius = 1.0, .mass = 1.0});
  finish(m);
  sd_simulation *plain = begin(m, 1), *field = begin(m, 1);
  advance(plain, 500);
  advance(field, 200);
  assert_int_equal(sd_simulation_add_force_field(field, nothing, NULL, NULL), SD_OK);
  advance(field, 300);
  const sd_field *different =
      sd_state_difference(sd_simulation_state(plain), sd_simulation_state(field));
  if (different) fail_msg("column %s differs", different->name);
  sd_simulation_free(field);
  end(plain, m);
}

static double value_of(const sd_measurement *m, const char *name) {
  const sd_quantity *q = sd_measurement_find(m, name);
  assert_non_null(q);
  return q->values[0];
}

static void a_packing_is_measured(void **state) {
  for (size_t n = 8; n <= 1200; n += 1192) {
    sd_model *m = heap(n, "gear5");
    sd_simulation *sim = begin(m, 2);
    advance(sim, 700);
    const uint64_t before = sd_state_hash(sd_simulation_state(sim));
    sd_measurement *all, *part, *none = NULL;
    assert_int_equal(sd_simulation_measure(sim, NULL, 20, &all, NULL), SD_OK);
    assert_int_equal(sd_simulation_measure(sim, (double[]){0, 3, 0, 2}, 20, &part, NULL), SD_OK);
    sd_column force;
    assert_true(sd_simulation_column(sim, "contact_force", &force));
    assert_true(force.n > 0);
    assert_true(value_of(all, "closed") == (double)force.n);
    assert_true(value_of(all, "free") == (double)n && value_of(part, "free") < (double)n);
    assert_true(value_of(part, "area") == 6.0);
    const sd_quantity *g = sd_measurement_find(all, "g"),
                      *stress = sd_measurement_find(all, "stress");
    assert_true(g->rank == 1 && g->shape[0] == 20 && stress->rank == 2 && stress->shape[1] == 2);
    assert_true(stress->values[3] == value_of(all, "stress_yy") && stress->values[3] > 0.0);
    assert_null(sd_measurement_find(all, "zz"));
    assert_int_equal(sd_simulation_measure(sim, (double[]){3, 0, 0, 2}, 20, &none, NULL),
                     SD_ERROR_USER);
    assert_int_equal(sd_simulation_measure(sim, NULL, 0, &none, NULL), SD_ERROR_USER);
    assert_null(none);
    assert_true(sd_state_hash(sd_simulation_state(sim)) == before);
    sd_measurement_free(all);
    sd_measurement_free(part);
    end(sim, m);
  }
  sd_result *result;
  assert_int_equal(sd_result_open("/nowhere/r.h5", &result, NULL), SD_ERROR_USER);
  assert_null(result);
  sd_result_close(result);
}

static void disks_come_and_go(void **state) {
  for (int integrator = 0; integrator < 2; integrator++) {
    sd_model *m = heap(12, integrator ? "verlet" : "gear5");
    sd_simulation *sim = begin(m, 1), *clone;
    advance(sim, 20000);
    const double residual = sd_simulation_energy(sim).residual;
    uint32_t first;
    const sd_disk more[2] = {
        {.position = {1.5, 6.0}, .radius = 0.5, .mass = 1.0},
        {.position = {3.0, 6.0, 1.0}, .velocity = {0.0, -1.0}, .radius = 0.4, .mass = 0.5}};
    assert_int_equal(sd_simulation_add_disks(sim, 2, more, &first, NULL), SD_OK);
    assert_int_equal(first, 12);
    assert_int_equal(sd_model_find(sd_simulation_model(sim), "floor"), 14);
    assert_true(fabs(sd_simulation_energy(sim).residual - residual) <
                1e-12 * sd_simulation_energy(sim).scale);
    sd_column y;
    assert_true(sd_simulation_column(sim, "y", &y));
    assert_true(((const double *)y.data)[sd_simulation_slot(sim, 12)] == 6.0);
    advance(sim, 1000);
    assert_true(sd_simulation_column(sim, "y", &y));
    const double fallen = ((const double *)y.data)[sd_simulation_slot(sim, 12)];
    assert_true(fabs(fallen - (6.0 - 0.5 * 10.0 * 0.01)) < 1e-9); /* 0.1 of fall from rest */
    advance(sim, 19000);
    const sd_energy before = sd_simulation_energy(sim);
    const uint32_t gone[2] = {0, 13};
    assert_int_equal(sd_simulation_remove_disks(sim, 2, gone, NULL), SD_OK);
    const sd_energy after = sd_simulation_energy(sim);
    assert_true(fabs(after.residual - before.residual) < 1e-12 * before.scale);
    sd_column a, b;
    assert_true(sd_simulation_column(sim, "contact_a", &a) &&
                sd_simulation_column(sim, "contact_b", &b));
    for (size_t k = 0; k < a.n; k++)
      for (int g = 0; g < 2; g++)
        assert_true(((const uint32_t *)a.data)[k] != gone[g] &&
                    ((const uint32_t *)b.data)[k] != gone[g]);
    assert_int_equal(sd_simulation_clone(sim, &clone, NULL), SD_OK);
    advance(sim, 20000);
    advance(clone, 20000);
    assert_null(sd_state_difference(sd_simulation_state(sim), sd_simulation_state(clone)));
    assert_true(fabs(sd_simulation_energy(sim).residual) < 1e-2 * sd_simulation_energy(sim).scale);
    sd_simulation_free(clone);
    end(sim, m);
  }
}

static void wrong_disks_are_refused_and_change_nothing(void **state) {
  sd_model *m = heap(8, "gear5");
  sd_simulation *sim = begin(m, 1), *clone;
  advance(sim, 100);
  assert_int_equal(sd_simulation_clone(sim, &clone, NULL), SD_OK);
  sd_messages *messages = sd_messages_new();
  assert_int_equal(
      sd_simulation_add_disks(sim, 1, &(sd_disk){.radius = -1.0, .mass = 1.0}, NULL, messages),
      SD_ERROR_USER);
  assert_non_null(strstr(sd_messages_text(messages, 0), "disk 8: radius = -1"));
  sd_messages_clear(messages);
  assert_int_equal(sd_simulation_remove_disks(sim, 1, &(uint32_t){8}, messages), SD_ERROR_USER);
  assert_non_null(strstr(sd_messages_text(messages, 0), "expected a free disk"));
  sd_messages_free(messages);
  advance(sim, 100);
  advance(clone, 100);
  assert_null(sd_state_difference(sd_simulation_state(sim), sd_simulation_state(clone)));
  sd_simulation_free(clone);
  end(sim, m);
}

RUN_TESTS(TEST(a_built_model_is_that_of_the_deck), TEST(all_mistakes_are_told_at_once),
          TEST(columns_stand_in_place), TEST(observers_come_at_their_steps_and_change_nothing),
          TEST(a_force_field_gives_the_closed_form),
          TEST(forces_do_not_depend_on_threads_or_restarts),
          TEST(a_field_of_no_force_changes_no_bit), TEST(a_packing_is_measured),
          TEST(disks_come_and_go), TEST(wrong_disks_are_refused_and_change_nothing))
