/* test_lanes.c: the step of small systems in lanes gives the bits of the general step.
 *
 * One run takes the step that suits it, the other the general one; both cross the ends of motion batches, phases, openings, new reference directions and angles that return into range.
 */
#include "deck_runs.h"
#include "model/model.h"
#include "physics/small/lanes.h"
#include "run/simulation_private.h"
#include "model/state.h"
#include "slipdisk/deck.h"
#include "slipdisk/simulation.h"

static const simulation_step steps_to_take[] = {SIMULATION_SUITABLE, SIMULATION_GENERAL};

static sd_simulation *start(const char *deck, const char *const *overrides, size_t n,
                            simulation_step step, sd_model **model) {
  char path[512];
  snprintf(path, sizeof path, "%s/inputs/%s", SLIPDISK_SOURCE_DIR, deck);
  sd_messages *m = sd_messages_new();
  sd_simulation *sim = NULL;
  if (sd_deck_load(path, n, overrides, model, m) != SD_OK ||
      simulation_new(*model, 1, step, NULL, NULL, &sim, m) != SD_OK)
    sd_messages_print(m, stderr);
  sd_messages_free(m);
  assert_non_null(sim);
  return sim;
}

static void compare(const char *deck, const char *integrator, const char *const *more,
                    size_t n_more, int64_t steps) {
  const char *overrides[8] = {integrator};
  for (size_t k = 0; k < n_more; k++) overrides[k + 1] = more[k];
  sd_model *model[2];
  sd_simulation *sim[2];
  for (int k = 0; k < 2; k++) {
    sim[k] = start(deck, overrides, n_more + 1, steps_to_take[k], &model[k]);
    assert_int_equal(simulation_is_small(sim[k]), k == 0);
    assert_int_equal(sd_simulation_advance(sim[k], steps, NULL), SD_OK);
  }
  const sd_field *f = sd_state_difference(sd_simulation_state(sim[0]), sd_simulation_state(sim[1]));
  if (f) fail_msg("%s, %s: %s differs", deck, integrator, f->name);
  for (int k = 0; k < 2; k++) {
    sd_simulation_free(sim[k]);
    sd_model_free(model[k]);
  }
}

static const char *const integrators[] = {"integrator=gear5", "integrator=verlet"};

static void three_disks(void **state) {
  const char *decks[] = {"three_disk/random.cfg", "three_disk/sync.cfg",   "three_disk/async.cfg",
                         "three_disk/steady.cfg", "three_disk/frozen.cfg", "three_disk/weak.cfg"};
  for (size_t d = 0; d < sizeof decks / sizeof *decks; d++)
    for (size_t k = 0; k < 2; k++) compare(decks[d], integrators[k], NULL, 0, 700);
}

/* Large steps and strong drive: bounces, short phases, large angles. */
static void rough(void **state) {
  const char *more[] = {"dt=1e-5", "measure.configurations=true", "phases[0].steps=1234",
                        "motions[*].amplitude=2e-2"};
  for (size_t k = 0; k < 2; k++) compare("three_disk/random.cfg", integrators[k], more, 4, 4000);
  for (size_t k = 0; k < 2; k++) compare("three_disk/random.cfg", integrators[k], more, 3, 40000);
  const char *turn[] = {"dt=2e-5"};
  for (size_t k = 0; k < 2; k++) compare("three_disk/steady.cfg", integrators[k], turn, 1, 4000);
}

/* Where too large an overlap ends the run: the same step, message, losses and coordinates; the derivatives are
 * those of the next step's predictor. */
static void an_overlap_ends_both_alike(void **state) {
  const char *decks[] = {"collisions/two_disks.cfg", "three_disk/random.cfg",
                         "collisions/disk_wall.cfg"};
  const char *gone[] = {"x2", "y2", "theta2", "x3", "y3", "theta3",
                        "x4", "y4", "theta4", "x5", "y5", "theta5"};
  for (size_t c = 0; c < 6; c++) {
    const char *more[] = {integrators[c % 2], "max_overlap=2e-5", "dt=1e-5", "gravity.g=1e-6"};
    sd_model *model[2];
    sd_simulation *sim[2];
    char said[2][256];
    for (int k = 0; k < 2; k++) {
      sim[k] = start(decks[c / 2], more, c / 2 == 1 ? 4 : 3, steps_to_take[k], &model[k]);
      if (c / 2 == 1)
        model[k]->max_overlap = 1e-12; /* the supports shake it deeper than gravity does */
      sd_messages *m = sd_messages_new();
      assert_int_equal(sd_simulation_advance(sim[k], 100000, m), SD_ERROR_NUMERIC);
      assert_int_equal(sd_messages_count(m), 1);
      snprintf(said[k], sizeof said[k], "%s", sd_messages_text(m, 0));
      sd_messages_free(m);
    }
    const sd_state *one = sd_simulation_state(sim[0]), *two = sd_simulation_state(sim[1]);
    assert_string_equal(said[0], said[1]);
    assert_true(one->step > 1 && strstr(said[0], "overlap by"));
    for (size_t f = 0; f < sd_field_count; f++) {
      bool derivative = false;
      for (size_t g = 0; g < sizeof gone / sizeof *gone; g++)
        derivative |= strcmp(sd_fields[f].name, gone[g]) == 0;
      size_t bytes = sd_extent_size(one, sd_fields[f].extent) * sd_type_size(sd_fields[f].type);
      if (!derivative && bytes &&
          memcmp(sd_field_data(one, &sd_fields[f]), sd_field_data(two, &sd_fields[f]), bytes))
        fail_msg("%s, %s: %s differs", decks[c / 2], more[0], sd_fields[f].name);
    }
    for (int k = 0; k < 2; k++) {
      sd_simulation_free(sim[k]);
      sd_model_free(model[k]);
    }
  }
}

/* A pose that is lost in the last step of all has no rebuild after it that would notice. */
static void not_finite(void **state) {
  const char *deck = "dt = 10.0; steps = 1; materials = ({ name = \"m\"; k_n = 1.0; k_t = 1.0; "
                     "gamma_n = 0; mu = 0; });"
                     "disks = ({ name = \"lost\"; x = 0; y = 0; radius = 1; mass = 1; });";
  for (size_t k = 0; k < 12; k++) {
    sd_messages *m = sd_messages_new();
    sd_model *model = NULL;
    sd_simulation *sim = NULL;
    if (sd_deck_load_text(deck, "deck", 1, &integrators[k % 2], &model, m) != SD_OK)
      sd_messages_print(m, stderr);
    assert_non_null(model);
    const size_t c = k / 4;
    if (k % 4 < 2) { /* a deck with these is refused */
      model->disks[0].mass = model->disks[0].inertia = 1e-300;
      model->disks[0].force[c] = 1e300;
    } else {
      model->disks[0].velocity[c] = 1e308;
    }
    assert_int_equal(sd_simulation_new(model, 1, &sim, m), SD_OK);
    assert_int_equal(sd_simulation_advance(sim, 1, m), SD_ERROR_NUMERIC);
    assert_non_null(strstr(sd_messages_text(m, 0), "step 1: disk \"lost\""));
    sd_simulation_free(sim);
    sd_model_free(model);
    sd_messages_free(m);
  }
}

/* Walls that meet, by either of their ends, are left to the general step. */
static void walls_that_meet_do_not_suit(void **unused) {
  const char *const ends[][2] = {{"(0, 0), (1, 0)", "(0, 0), (0, 1)"},
                                 {"(0, 0), (1, 0)", "(0, 1), (0, 0)"},
                                 {"(1, 0), (0, 0)", "(0, 0), (0, 1)"},
                                 {"(1, 0), (0, 0)", "(0, 1), (0, 0)"},
                                 {"(1, 0), (2, 0)", "(0, 1), (0, 2)"}};
  for (size_t k = 0; k < 5; k++) {
    text deck = {0};
    text_add(&deck,
             "dt = 1e-3; steps = 1; materials = ({ name = \"m\"; k_n = 1e3; k_t = 1e3; });\n"
             "disks = ({ x = 3; y = 3; radius = 1; mass = 1; });\n"
             "walls = ({ type = \"segment\"; points = (%s); },\n"
             "         { type = \"segment\"; points = (%s); });",
             ends[k][0], ends[k][1]);
    sd_model *m = model_of_text(&deck);
    assert_int_equal(lanes_suit(m), k == 4);
    sd_model_free(m);
  }
}

RUN_TESTS(TEST(walls_that_meet_do_not_suit), TEST(three_disks), TEST(rough),
          TEST(an_overlap_ends_both_alike), TEST(not_finite))
