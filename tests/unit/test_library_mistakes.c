/* test_library_mistakes.c: mistakes of programs that use the library: each is told, none of them crashes. Public headers alone. */
#include "unit.h"
#include "slipdisk/slipdisk.h"

static const sd_contact_law law = {.k_n = 1e4, .k_t = 8e3, .gamma_n = 2.0, .mu = 0.5};

/* Three disks above a floor. */
static sd_model *base(void) {
  sd_model *m = sd_model_new();
  sd_model_set(m, "dt", 1e-4);
  sd_model_set_gravity(m, 0.0, -10.0);
  sd_model_add_material(m, "m", &law);
  double points[2][2] = {{0, 0}, {1, 0}};
  sd_model_add_wall(m, &(sd_wall){.name = "floor", .n_points = 2, .points = points});
  for (int k = 0; k < 3; k++)
    sd_model_add_disk(m, &(sd_disk){.position = {1.0 + 1.2 * k, 0.6}, .radius = 0.5, .mass = 1.0});
  return m;
}

static bool told(const sd_messages *messages, const char *text) {
  for (size_t k = 0; k < sd_messages_count(messages); k++)
    if (strstr(sd_messages_text(messages, k), text)) return true;
  return false;
}

static sd_simulation *begin(sd_model *m) {
  sd_simulation *sim;
  assert_int_equal(sd_model_finish(m, NULL), SD_OK);
  assert_int_equal(sd_simulation_new(m, 1, &sim, NULL), SD_OK);
  return sim;
}

static void end(sd_simulation *sim, sd_model *m) {
  sd_simulation_free(sim);
  sd_model_free(m);
}

static void no_array(sd_model *m) { sd_model_add_wall(m, &(sd_wall){.name = "w", .n_points = 2}); }
static void no_bodies(sd_model *m) {
  sd_model_add_motion(m, &(sd_motion){.name = "q", .n_bodies = 1});
}
static void no_table(sd_model *m) {
  sd_model_add_motion(m, &(sd_motion){.name = "q",
                                      .kind = SD_MOTION_TABLE,
                                      .n_table = 3,
                                      .n_bodies = 1,
                                      .bodies = &(uint32_t){0}});
}
static void no_law(sd_model *m) { sd_model_set_law(m, 0, 0, NULL); }
static void wall_nowhere(sd_model *m) {
  double points[2][2] = {{NAN, 0}, {1, 0}};
  sd_model_add_wall(m, &(sd_wall){.name = "w", .n_points = 2, .points = points});
}
static void wall_without_end(sd_model *m) {
  sd_model_add_wall(m, &(sd_wall){.name = "w", .kind = SD_WALL_CIRCLE, .radius = INFINITY});
}
static void wall_of_no_kind(sd_model *m) {
  double points[2][2] = {{0, 5}, {1, 5}};
  sd_model_add_wall(
      m, &(sd_wall){.name = "w", .kind = (sd_wall_kind)9, .n_points = 2, .points = points});
}
static void no_weight(sd_model *m) { sd_model_set_gravity(m, NAN, 0.0); }
static void no_inertia(sd_model *m) {
  sd_model_add_disk(m, &(sd_disk){.position = {9, 9}, .radius = 1, .mass = 1, .inertia = NAN});
}
static void locked_and_fast(sd_model *m) {
  sd_model_add_disk(
      m, &(sd_disk){.position = {9, 9}, .velocity = {1}, .radius = 1, .mass = 1, .locked = {true}});
}
static void endless_wave(sd_model *m) {
  sd_model_add_motion(m, &(sd_motion){.name = "q",
                                      .kind = SD_MOTION_HARMONIC,
                                      .amplitude = NAN,
                                      .omega = 1,
                                      .n_bodies = 1,
                                      .bodies = &(uint32_t){0}});
}
static void ramp_back(sd_model *m) {
  sd_model_add_motion(m, &(sd_motion){.name = "q",
                                      .kind = SD_MOTION_HARMONIC,
                                      .amplitude = 1,
                                      .omega = 1,
                                      .ramp = -1,
                                      .n_bodies = 1,
                                      .bodies = &(uint32_t){0}});
}
static void add_table(sd_model *m, double second_time, double second_value) {
  double time[3] = {0, second_time, 2}, value[3] = {0, second_value, 0};
  sd_model_add_motion(m, &(sd_motion){.name = "q",
                                      .kind = SD_MOTION_TABLE,
                                      .amplitude = 1,
                                      .n_table = 3,
                                      .table_time = time,
                                      .table_value = value,
                                      .n_bodies = 1,
                                      .bodies = &(uint32_t){0}});
}
static void endless_table(sd_model *m) { add_table(m, 1, INFINITY); }
static void table_of_one_time(sd_model *m) { add_table(m, 0, 1); }

static void what_cannot_be_is_told(void **state) {
  const struct {
    void (*make)(sd_model *);
    const char *message;
  } mistakes[] = {
      {no_array, "a wall: expected 2 elements, not NULL"},
      {no_bodies, "a motion: expected 1 elements, not NULL"},
      {no_table, "a motion: expected 3 elements, not NULL"},
      {no_law, "law of materials 0 and 0: expected a law, not NULL"},
      {wall_nowhere, "wall \"w\": points, pivot and radius must be finite"},
      {wall_without_end, "wall \"w\": points, pivot and radius must be finite"},
      {wall_of_no_kind, "wall \"w\": kind 9: expected SD_WALL_LINE"},
      {no_weight, "gravity (nan, 0): expected finite numbers"},
      {no_inertia, "disk 3: inertia = nan: expected a number >= 0"},
      {locked_and_fast, "disk 3: a locked coordinate cannot have a velocity"},
      {endless_wave, "motion \"q\": amplitude, omega, phase and velocity must be finite"},
      {endless_table, "motion \"q\": table: expected finite numbers (row 1)"},
      {ramp_back, "motion \"q\": ramp = -1: expected >= 0"},
      {table_of_one_time, "motion \"q\": table: time must increase (row 1)"}};
  for (size_t k = 0; k < sizeof mistakes / sizeof *mistakes; k++) {
    sd_model *m = base();
    sd_messages *messages = sd_messages_new();
    mistakes[k].make(m);
    assert_int_equal(sd_model_finish(m, messages), SD_ERROR_USER);
    if (!told(messages, mistakes[k].message)) {
      sd_messages_print(messages, stderr);
      fail_msg("not told: %s", mistakes[k].message);
    }
    sd_messages_free(messages);
    sd_model_free(m);
  }
}

static void a_copy_keeps_the_mistakes(void **state) {
  sd_model *m = base();
  sd_model_set(m, "nonsense", 1.0);
  sd_model *copy = sd_model_clone(m);
  sd_messages *messages = sd_messages_new();
  assert_int_equal(sd_model_finish(copy, messages), SD_ERROR_USER);
  assert_true(told(messages, "nonsense: no key that a model has"));
  sd_messages_free(messages);
  sd_model_free(copy);
  sd_model_free(m);
}

static void a_model_that_was_changed_is_finished_again(void **state) {
  sd_model *m = base();
  sd_simulation *sim;
  sd_messages *messages = sd_messages_new();
  assert_int_equal(sd_simulation_new(m, 1, &sim, messages), SD_ERROR_USER);
  assert_null(sim);
  assert_true(told(messages, "the model is not finished"));
  assert_int_equal(sd_model_finish(m, NULL), SD_OK);
  sd_model_add_disk(m, &(sd_disk){.position = {9, 9}, .radius = 0.5, .mass = 1.0});
  assert_int_equal(sd_simulation_new(m, 1, &sim, NULL), SD_ERROR_USER);
  sim = begin(m);
  assert_int_equal(sd_model_disks(sd_simulation_model(sim)), 4);
  sd_messages_free(messages);
  end(sim, m);
}

static sd_status look(sd_simulation *sim, void *user) {
  (void)sim, (void)user;
  return SD_OK;
}

static void numbers_of_nothing_are_answered(void **state) {
  sd_model *m = base();
  sd_simulation *sim = begin(m);
  char text[64];
  assert_int_equal(sd_simulation_slot(sim, 3), 3);
  assert_int_equal(sd_simulation_slot(sim, SD_WALL(0)), 3);
  assert_int_equal(sd_simulation_slot(sim, 4), UINT32_MAX);
  assert_int_equal(sd_simulation_slot(sim, SD_WALL(1)), UINT32_MAX);
  assert_true(isnan(sd_simulation_angle(sim, sd_model_find(m, "ceiling"))));
  assert_null(sd_model_law(m, 0, 1));
  assert_null(sd_model_law(m, 1, 0));
  assert_null(sd_model_law(m, -1, 0));
  assert_null(sd_model_law(m, 0, -1));
  assert_string_equal(sd_model_body_name(m, 7, text, sizeof text), "body 7, which does not exist");
  assert_int_equal(sd_model_side(m, 7, SD_Y), 0);
  assert_int_equal(sd_model_side(m, 3, SD_Y), 1);
  assert_true(isnan(sd_model_compress_time(m, 5)));
  assert_false(sd_model_clash(m, 5, (size_t[2]){0}));
  const sd_rotation rotation = sd_rotation_of(m, sd_simulation_state(sim), 0);
  assert_true(rotation.disk == UINT32_MAX && isnan(rotation.omega));
  const sd_slide slide = sd_slide_of(m, sd_simulation_state(sim), 0);
  assert_true(slide.disk == UINT32_MAX && isnan(slide.pp) && isnan(slide.contact_open[1]));
  assert_false(sd_simulation_goal(sim).reached);
  assert_int_equal(sd_simulation_observe(sim, 0, look, NULL), SD_ERROR_USER);
  assert_int_equal(sd_simulation_observe(sim, 10, NULL, NULL), SD_ERROR_USER);
  assert_int_equal(sd_simulation_add_force_field(sim, NULL, NULL, NULL), SD_ERROR_USER);
  assert_int_equal(sd_simulation_advance(sim, 20, NULL), SD_OK);
  assert_int_equal(sd_simulation_add_disks(
                       sim, 1, &(sd_disk){.position = {9, 9}, .radius = 1, .mass = 1}, NULL, NULL),
                   SD_OK);
  assert_int_equal(sd_simulation_slot(sim, SD_WALL(0)), 4);
  end(sim, m);
}

static sd_status rebuild(sd_simulation *sim, void *user) {
  return sd_simulation_rebuild(sim, user);
}

/* What is wrong is told to the caller of the step, whatever lists observers have. */
static void an_observer_has_a_list_of_its_own(void **state) {
  sd_model *m = base();
  sd_simulation *sim;
  sd_messages *own = sd_messages_new(), *messages = sd_messages_new();
  sd_model_add_disk(
      m, &(sd_disk){.position = {1.0, 2.6}, .velocity = {0, -100}, .radius = 0.5, .mass = 1.0});
  sim = begin(m);
  assert_int_equal(sd_simulation_observe(sim, 50, rebuild, own), SD_OK);
  assert_int_equal(sd_simulation_advance(sim, 1000, messages), SD_ERROR_NUMERIC);
  assert_true(sd_simulation_step(sim) > 50);
  assert_true(told(messages, "disk 0 and disk 3 overlap"));
  assert_int_equal(sd_messages_count(own), 0);
  sd_messages_free(own);
  sd_messages_free(messages);
  end(sim, m);
}

/* The box as it is now decides, not that of the model. */
static void disks_are_added_inside_the_compressed_box(void **state) {
  sd_model *m = sd_model_new();
  sd_model_set(m, "dt", 1e-4);
  sd_model_add_material(m, "m", &law);
  for (int c = 0; c < 2; c++) sd_model_set_periodic(m, c, 0.0, 10.0);
  for (int k = 0; k < 9; k++)
    sd_model_add_disk(
        m, &(sd_disk){.position = {1.0 + 3 * (k % 3), 1.0 + 3 * (k / 3)}, .radius = 1, .mass = 1});
  sd_model_add_phase(
      m, &(sd_phase){.steps = 100000, .compress = {true, .fraction = 0.5, .rate = 1.0}});
  sd_simulation *sim = begin(m);
  sd_messages *messages = sd_messages_new();
  assert_int_equal(sd_simulation_advance(sim, 2000, NULL), SD_OK);
  const sd_disk one = {.position = {9.9, 2.4}, .radius = 0.2, .mass = 0.04};
  assert_int_equal(sd_simulation_add_disks(sim, 1, &one, NULL, messages), SD_ERROR_USER);
  assert_true(told(messages, "disk 9: x = 9.9 lies outside the periodic box"));
  sd_disk inside = one;
  inside.position[0] = 2.4;
  assert_int_equal(sd_simulation_add_disks(sim, 1, &inside, NULL, NULL), SD_OK);
  sd_messages_free(messages);
  end(sim, m);
}

/* A lid that rests on the disks; disks far above it would make its load look wrong. */
static void warnings_of_a_model_are_not_repeated(void **state) {
  sd_model *m = base();
  double points[2][2] = {{0, 1.2}, {1, 1.2}};
  const uint32_t lid =
      sd_model_add_wall(m, &(sd_wall){.name = "lid", .n_points = 2, .points = points});
  sd_model_add_motion(m, &(sd_motion){.name = "press",
                                      .kind = SD_MOTION_LOAD,
                                      .coordinate = SD_Y,
                                      .mass = 5.0,
                                      .force = -10.0,
                                      .n_bodies = 1,
                                      .bodies = &(uint32_t){lid}});
  sd_simulation *sim = begin(m), *clone;
  sd_messages *messages = sd_messages_new();
  const sd_disk far = {.position = {0, 1000}, .radius = 0.5, .mass = 1.0};
  assert_int_equal(sd_simulation_add_disks(sim, 1, &far, NULL, messages), SD_OK);
  assert_int_equal(sd_simulation_clone(sim, &clone, messages), SD_OK);
  void *data;
  size_t size;
  assert_int_equal(sd_simulation_save_memory(sim, &data, &size, messages), SD_OK);
  sd_simulation_free(clone);
  assert_int_equal(sd_simulation_load_memory(data, size, 1, &clone, messages), SD_OK);
  sd_free(data);
  assert_int_equal(sd_messages_count(messages), 0);
  sd_messages_free(messages);
  sd_simulation_free(clone);
  end(sim, m);
}

static void advice_needs_no_names(void **state) {
  sd_model *m = sd_model_new();
  sd_messages *messages = sd_messages_new();
  sd_model_set(m, "dt", 1e-4);
  for (int k = 0; k < 2; k++) {
    sd_model_add_material(m, NULL, &(sd_contact_law){.k_n = 1e4, .gamma_n = 1.0, .mu = 0.5});
    sd_model_add_disk(m,
                      &(sd_disk){.position = {3.0 * k}, .radius = 1.0, .mass = 1.0, .material = k});
  }
  sd_model_set_law(m, 0, 1, &(sd_contact_law){.k_n = 1e4, .k_t = 1e3});
  assert_int_equal(sd_model_finish(m, messages), SD_OK);
  sd_model_advise(m, messages);
  assert_true(told(messages, "material_pairs (0, 1): k_t = 1000 without mu"));
  sd_messages_free(messages);
  sd_model_free(m);
}

/* A floor that shakes begins its next step without the force of disks that are gone: its work, and the budget, stay right. */
static void a_floor_feels_removed_disks_no_more(void **state) {
  for (int kind = 0; kind < 4; kind++) {
    const bool verlet = kind % 2, round = kind / 2;
    sd_model *m = sd_model_new();
    double points[2][2] = {{0.0, 0.0}, {1.0, 0.1}};
    sd_model_set(m, "dt", 1e-4);
    sd_model_set_text(m, "integrator", verlet ? "verlet" : "gear5");
    sd_model_set_gravity(m, 0.0, -10.0);
    sd_model_add_material(m, "m", &law);
    uint32_t floor = sd_model_add_wall(
        m, round ? &(sd_wall){.kind = SD_WALL_CIRCLE,
                              .pivot = {1.0, 20.0},
                              .radius = 20.0,
                              .inside = true}
                 : &(sd_wall){
                       .kind = SD_WALL_LINE, .n_points = 2, .points = points, .pivot = {3.0, 0.0}});
    for (int k = 0; k < 3; k++)
      sd_model_add_disk(
          m, &(sd_disk){.position = {2.0 * k, 0.8 - 0.1 * (k == 1)}, .radius = 0.5, .mass = 1.0});
    for (int c = 0; c < 3; c++)
      sd_model_add_motion(m, &(sd_motion){.kind = SD_MOTION_HARMONIC,
                                          .coordinate = c,
                                          .n_bodies = 1,
                                          .bodies = &floor,
                                          .amplitude = 0.002,
                                          .omega = 30.0 + c});
    sd_simulation *sim = begin(m);
    assert_int_equal(sd_simulation_advance(sim, 20000, NULL), SD_OK);
    sd_column force[3];
    const char *const names[3] = {"force_x", "force_y", "torque"};
    const uint32_t slot = sd_simulation_slot(sim, floor);
    double before[3] = {0};
    for (int tries = 0; tries < 1000 && !(before[SD_Y] > 10.0); tries++) { /* disks bounce */
      assert_int_equal(sd_simulation_advance(sim, 20, NULL), SD_OK);
      for (int c = 0; c < 3; c++) {
        assert_true(sd_simulation_column(sim, names[c], &force[c]));
        before[c] = fabs(((const double *)force[c].data)[slot]);
      }
    }
    assert_true(before[SD_Y] > 10.0 && before[SD_X] > 0.0 && before[SD_THETA] > 0.0);
    const sd_energy old = sd_simulation_energy(sim);
    assert_int_equal(sd_simulation_remove_disks(sim, 3, (const uint32_t[]){2, 0, 1}, NULL), SD_OK);
    for (int c = 0; c < 3; c++) {
      assert_true(sd_simulation_column(sim, names[c], &force[c]));
      assert_true(fabs(((const double *)force[c].data)[slot]) < 1e-5 * before[SD_Y]);
    }
    assert_int_equal(sd_simulation_advance(sim, 1000, NULL), SD_OK);
    assert_true(fabs(sd_simulation_energy(sim).residual - old.residual) < 1e-6 * old.scale);
    end(sim, m);
  }
}

/* Pairs in any order, and each once or twice; bodies that are not there, or a body with itself. */
static void bonds_of_a_program_are_checked(void **state) {
  const sd_contact_law bonds = {
      .k_n = 1e3, .bond_k_n = 1e3, .bond_gap = 0.1, .bond_extension = 0.1};
  const uint32_t many[4][2] = {{3, 2}, {1, 0}, {2, 3}, {SD_WALL(0), 1}}, beyond[1][2] = {{0, 9}},
                 self[1][2] = {{2, 2}}, bodies[3] = {SD_WALL(0), 2, 1}, none[1] = {77};
  double points[2][2] = {{0, -0.5}, {1, -0.5}};
  const struct {
    sd_bonding bond;
    size_t made; /* 0: refused */
  } tries[] = {{{.n_pairs = 4, .pairs = many}, 3},
               {{.n_between = 3, .between = bodies}, 3},
               {{.n_pairs = 1, .pairs = beyond}, 0},
               {{.n_pairs = 1, .pairs = self}, 0},
               {{.n_between = 1, .between = none}, 0}};
  for (size_t t = 0; t < sizeof tries / sizeof *tries; t++) {
    sd_model *m = sd_model_new();
    sd_messages *messages = sd_messages_new();
    sd_phase phase = {.steps = 10, .bond = tries[t].bond};
    phase.bond.asked = true;
    sd_model_set(m, "dt", 1e-4);
    sd_model_add_material(m, "m", &bonds);
    for (int k = 0; k < 4; k++)
      sd_model_add_disk(m, &(sd_disk){.position = {k, 0}, .radius = 0.5, .mass = 1});
    sd_model_add_wall(m, &(sd_wall){.n_points = 2, .points = points});
    sd_model_add_phase(m, &phase);
    if (tries[t].made == 0) {
      assert_int_equal(sd_model_finish(m, messages), SD_ERROR_USER);
      assert_true(told(messages, tries[t].bond.pairs == self ? "with itself" : "does not exist"));
      sd_model_free(m);
    } else {
      sd_simulation *sim = begin(m);
      size_t made = 0;
      const sd_state *s = sd_simulation_state(sim);
      sd_column bond;
      assert_true(sd_simulation_column(sim, "contact_bond", &bond));
      assert_non_null(s);
      for (size_t k = 0; k < bond.n; k++) made += ((const double *)bond.data)[k] > 0;
      assert_int_equal(made, tries[t].made);
      end(sim, m);
    }
    sd_messages_free(messages);
  }
}

RUN_TESTS(TEST(what_cannot_be_is_told), TEST(a_copy_keeps_the_mistakes),
          TEST(a_model_that_was_changed_is_finished_again), TEST(numbers_of_nothing_are_answered),
          TEST(an_observer_has_a_list_of_its_own), TEST(disks_are_added_inside_the_compressed_box),
          TEST(warnings_of_a_model_are_not_repeated), TEST(advice_needs_no_names),
          TEST(a_floor_feels_removed_disks_no_more), TEST(bonds_of_a_program_are_checked))
