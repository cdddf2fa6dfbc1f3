/* test_windows.c: steps taken in windows (physics/step/window.h) have the bits of single steps, on
 * one thread and on two; and windows are undone where only single steps do. Small chunks
 * (SLIPDISK_CHUNK) let small systems take windows; one system has the size that needs no such help. */
#include "deck_runs.h"

enum { SMALL = 500, LARGE = 20500, WIDE = 25, STEPS = 330 };

/* What differs between the systems: keys of the deck, of the material, motions, walls. */
typedef struct trial {
  const char *name, *keys, *material, *motions, *walls;
  bool undone; /* a window is undone, at least */
  bool large;
} trial;

#define LINEAR "k_n = 2e4; k_t = 1e4; gamma_n = 0.4; mu = 0.3;"
#define SHAKE                                                                                      \
  "motions = ( { name = \"shake\"; wall = \"floor\"; coordinate = \"y\"; type = \"harmonic\"; "    \
  "acceleration = 20; "                                                                            \
  "frequency = 400; } );"

static const trial trials[] = {
    {"verlet, shaken floor", "contact_variant = \"conservative\"; integrator = \"verlet\";", LINEAR,
     SHAKE, "", false, true},
    {"gear, shaken floor, means of disks",
     "integrator = \"gear5\"; measure = { disks = true; every = 29; rotation = (); };", LINEAR,
     SHAKE, "", false, false},
    {"random floor and a turning wheel", "integrator = \"gear5\";", LINEAR,
     "motions = ( { name = \"noise\"; wall = \"floor\"; coordinate = \"y\"; type = \"random\"; "
     "acceleration = 10; frequency = 400; damping = 0.5; }, { name = \"turn\"; wall = \"wheel\"; "
     "coordinate = \"theta\"; type = \"velocity\"; velocity = 300; } );",
     "{ name = \"wheel\"; type = \"circle\"; center = (0.5, -0.12); radius = 0.12; side = "
     "\"outside\"; }, ",
     false, false},
    {"general laws", "integrator = \"verlet\";",
     "law = \"hertz\"; k_n = 2e5; tangential = \"mindlin\"; k_t = 1e5; restitution = 0.7; mu = "
     "0.3; mu_kinetic = 0.2; critical_load = 0.05; k_r = 500; mu_r = 0.05; gamma_t = 0.1;",
     SHAKE, "", false, false},
    {"nothing moves the walls", "integrator = \"verlet\";", LINEAR, "", "", false, false},
    {"a disk beyond the displacement limit",
     "integrator = \"verlet\"; limits = { displacement = 0.00078; };", LINEAR, SHAKE, "", true,
     false},
};

/* A column of disks in slight disorder, falling onto the floor, at several speeds. */
static sd_model *column(const trial *t) {
  text deck = {0};
  text_add(&deck,
           "dt = 2e-5; seed = 3; %s\nmaterials = ( { name = \"m\"; %s } );\ngravity = { g = 9.81; "
           "};\nwalls = ( %s{ name = "
           "\"floor\"; type = \"line\"; points = ((0, 0), (2, 0)); }, { type = \"line\"; points = "
           "((0, 40), (0, 0)); }, { type "
           "= \"line\"; points = ((1.04, 0), (1.04, 40)); } );\n%s\nphases = ( { steps = 100; }, { "
           "steps = 1000; measure = true; "
           "} );\ndisk_rows = ( { columns = (\"x\", \"y\", \"radius\"); density = 3.57; vy = -0.5; "
           "omega = 40; rows = (",
           t->keys, t->material, t->walls, t->motions);
  add_lattice(&deck, t->large ? LARGE : SMALL, WIDE, 0.03, 0.021, 0.0408, 0.018, 11);
  text_add(&deck, "); } );\n");
  return model_of_text(&deck);
}

static void same_runs(sd_simulation *plain, sd_simulation *other, const char *name) {
  const sd_state *a = sd_simulation_state(plain), *b = sd_simulation_state(other);
  same_states(a, b, name);
  assert_true(a->fast_step == b->fast_step && a->fast_disk == b->fast_disk &&
              a->work_driven == b->work_driven);
}

static void took_windows(sd_simulation *sim, const trial *t) {
  const window *v = &engine_of(sim)->work.window;
  if (v->taken >= 5 && (!t->undone || v->undone > 0)) return;
  print_error("%s: %lld windows, %lld undone\n", t->name, (long long)v->taken,
              (long long)v->undone);
  fail();
}

static void compare(const trial *t) {
  setenv("SLIPDISK_CHUNK", t->large ? "" : "8", 1);
  sd_model *model = column(t);
  sd_simulation *one = begin_run(model, 1), *two = begin_run(model, 2),
                *plain = begin_run(model, 1);
  for (int64_t done = 0; done < STEPS; done += STEPS / 3) {
    advance(one, STEPS / 3);
    advance(two, STEPS / 3);
    setenv("SLIPDISK_WINDOWS", "never", 1);
    advance(plain, STEPS / 3);
    setenv("SLIPDISK_WINDOWS", "always", 1);
    same_runs(plain, one, t->name);
    same_runs(plain, two, t->name);
  }
  took_windows(one, t);
  took_windows(two, t);
  assert_int_equal(engine_of(plain)->work.window.taken, 0);
  sd_simulation_free(one);
  sd_simulation_free(two);
  end_run(plain, model);
}

static void windows_have_the_bits_of_single_steps(void **unused) {
  for (size_t k = 0; k < sizeof trials / sizeof *trials; k++) compare(&trials[k]);
}

/* Steps until the run fails; its message. */
static int64_t fails_at(const sd_model *model, int threads, char *told, size_t size) {
  sd_simulation *sim = begin_run(model, threads);
  sd_messages *messages = sd_messages_new();
  sd_status status = SD_OK;
  while (status == SD_OK) status = sd_simulation_advance(sim, 50, messages);
  assert_int_equal(status, SD_ERROR_NUMERIC);
  snprintf(told, size, "%s", sd_messages_text(messages, 0));
  const int64_t step = sd_simulation_state(sim)->step;
  sd_messages_free(messages);
  sd_simulation_free(sim);
  return step;
}

static void a_deep_overlap_is_told_of_the_step_in_which_it_is(void **unused) {
  sd_model *model = column(&(trial){"", "integrator = \"verlet\"; max_overlap = 0.002;", LINEAR,
                                    SHAKE, "", true, false});
  char a[400], b[400];
  setenv("SLIPDISK_CHUNK", "8", 1);
  assert_int_equal(fails_at(model, 1, a, sizeof a), fails_at(model, 2, b, sizeof b));
  assert_string_equal(a, b);
  sd_model_free(model);
}

int main(void) {
  setenv("SLIPDISK_WINDOWS", "always", 1);
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(windows_have_the_bits_of_single_steps),
      cmocka_unit_test(a_deep_overlap_is_told_of_the_step_in_which_it_is)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
