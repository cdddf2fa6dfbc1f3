/* test_until.c: a last phase that goes on until an error bar is small enough: when it is looked at, that the end
 * depends on model and state alone, what the deck may say, and what it does to the mean. */
#include "model/model.h"
#include "model/state.h"
#include "slipdisk/deck.h"
#include "deck_runs.h"
#include "sequential.h"

static void looks_are_few(void **unused) {
  const int64_t cases[][2] = {{1, 1},     {1, 50},         {7, 7},
                              {100, 101}, {1000, 1000000}, {3, INT64_MAX / 4}};
  for (size_t c = 0; c < sizeof cases / sizeof *cases; c++) {
    int64_t least = cases[c][0], most = cases[c][1], count = 0;
    sd_phase phases[2] = {{.steps = 12345}, {.steps = most}};
    sd_model model = {.n_phases = 2, .phases = phases, .until = {.asked = true, .least = least}};
    assert_int_equal(sd_goal_look(&model, 0), least);
    assert_int_equal(sd_goal_look(&model, least - 1), least);
    for (int64_t look = least; look < most; count++) {
      int64_t next = sd_goal_look(&model, look);
      assert_true(next > look && next <= most);
      assert_true(next == most || next - look == look / 20 + 1);
      /* from anywhere in between it is the same one */
      assert_int_equal(sd_goal_look(&model, next - 1), next);
      assert_int_equal(sd_goal_look(&model, look + (next - look) / 2), next);
      look = next;
    }
    assert_int_equal(sd_goal_look(&model, most), most);
    between((double)count, 0, 20 + log((double)most / (double)least) / log(1.05), "looks");
  }
}

static void goal_of_a_state(void **unused) {
  sd_disk disks[2] = {{.radius = 2}, {.radius = 0.5}};
  uint32_t watched[2] = {1, 0};
  sd_phase phase = {.steps = 1000000, .measure = true};
  sd_model model = {.dt = 1e-3,
                    .gravity = {-3, -4},
                    .n_disks = 2,
                    .disks = disks,
                    .n_rotations = 2,
                    .rotations = watched,
                    .n_phases = 1,
                    .phases = &phase,
                    .until = {.asked = true, .least = 1, .rotation = 1, .error = 1}};
  double *bins = calloc(2 * SD_BINS, sizeof *bins), zero[2] = {0, 0};
  assert_non_null(bins);
  uint64_t seed = 3;
  for (size_t k = 0; k < 1000; k++) bins[SD_BINS + k] = -0.5 + 0.1 * next_uniform(&seed);
  sd_state state = {.measured = 10007,
                    .bin_steps = 10,
                    .bins = 1000,
                    .n_rotations = 2,
                    .rotation_bin = bins,
                    .rotation_start = zero,
                    .rotation_last = zero};
  sd_rotation r = sd_rotation_of(&model, &state, 1);
  assert_true(r.converged && r.error > 0 && r.omega < 0);

  /* just small enough, and just not */
  model.until.error = r.error;
  sd_goal g = sd_goal_of(&model, &state);
  assert_true(g.reached && g.converged && g.value == r.omega && g.error == r.error &&
              g.goal == r.error);
  assert_true(g.measured == r.measured);
  model.until.error = nextafter(r.error, 0);
  assert_false(sd_goal_of(&model, &state).reached);

  model.until.scaled = true;
  model.until.error = 2 * r.scaled_error;
  g = sd_goal_of(&model, &state);
  assert_true(g.reached && g.value == r.scaled && g.error == r.scaled_error);

  /* a fraction of the size of the mean, which is negative */
  model.until =
      (sd_until){.asked = true, .least = 1, .rotation = 1, .relative = 1.001 * r.error / -r.omega};
  g = sd_goal_of(&model, &state);
  assert_true(g.reached);
  between(g.goal, 1.0009 * r.error, 1.0011 * r.error, "goal");
  model.until.relative = 0.999 * r.error / -r.omega;
  assert_false(sd_goal_of(&model, &state).reached);

  /* an error bar that is small is not enough: the record must be long enough to tell */
  for (size_t k = 0; k < 1000; k++) bins[SD_BINS + k] = 1e-9 * (double)k;
  model.until = (sd_until){.asked = true, .least = 1, .rotation = 1, .error = 1};
  g = sd_goal_of(&model, &state);
  assert_true(g.error < g.goal && !g.converged && !g.reached);
  state.bins = 0;
  g = sd_goal_of(&model, &state);
  assert_true(isnan(g.error) && !g.reached);
  free(bins);
}

/* A disk on two supports that shake: the goal is reached after some thousand steps. */
#define SHAKEN(last, until)                                                                        \
  "dt = 2e-5; gravity = { g = 10; tilt = 0.1; }; materials = ( { name = \"a\"; k_n = 1e4; k_t = "  \
  "5e3; "                                                                                          \
  "gamma_n = 2; mu = 0.4; } );\n"                                                                  \
  "disks = ( { name = \"top\"; x = 0; y = 0; radius = 1; mass = 0.1; },\n"                         \
  "{ name = \"left\"; x = -1; y = -1.7320508; radius = 1; mass = 0.1; fixed = true; },\n"          \
  "{ name = \"right\"; x = 1; y = -1.7320508; radius = 1; mass = 0.1; fixed = true; } );\n"        \
  "motions = ( { disk = (\"left\", \"right\"); coordinate = (\"x\", \"y\"); type = \"random\"; "   \
  "amplitude = 2e-5; omega = 300; },\n"                                                            \
  "{ disk = (\"left\", \"right\"); coordinate = \"theta\"; type = \"random\"; amplitude = 3e-4; "  \
  "omega = "                                                                                       \
  "500; } );\n"                                                                                    \
  "phases = ( { steps = 700; }, { steps = " last                                                   \
  "; } );\nmeasure = { rotation = (\"top\", \"left\"); };\n" until

static const char shaken[] = SHAKEN("3001", "until = { error = 0.006; max_time = 20; };");

static int64_t step_of(sd_simulation *sim) { return sd_simulation_state(sim)->step; }

/* Runs to the end in one go. */
static sd_state *whole_run(const sd_model *model, int threads) {
  sd_simulation *sim = begin_run(model, threads);
  advance(sim, INT64_MAX);
  assert_true(sd_simulation_finished(sim));
  sd_state *end = copy_of(model, sd_simulation_state(sim));
  sd_simulation_free(sim);
  return end;
}

static void ends_at_the_first_good_look(void **unused) {
  sd_model *model = model_of(shaken);
  sd_state *end = whole_run(model, 1);
  assert_int_equal(end->phase, 2);
  assert_true(end->step > 700 + 3001 && end->step < sd_model_steps(model));
  assert_true(sd_goal_of(model, end).reached);
  print_message("  ends at step %lld of %lld\n", (long long)end->step,
                (long long)sd_model_steps(model));

  /* no look before was good, and the end is one */
  sd_simulation *sim = begin_run(model, 1);
  advance(sim, 700);
  int64_t looks = 0;
  for (int64_t look = 0; !sd_simulation_finished(sim); looks++) {
    if (looks) assert_false(sd_simulation_goal(sim).reached);
    int64_t next = sd_goal_look(model, look);
    advance(sim, next - look);
    assert_int_equal(step_of(sim), 700 + next);
    look = next;
  }
  assert_true(looks > 5);
  same_states(sd_simulation_state(sim), end, "look by look");
  advance(sim, 1000);
  assert_int_equal(step_of(sim), end->step);
  sd_simulation_free(sim);

  /* the same phase with that length and no goal */
  char length[32], deck[4000];
  snprintf(length, sizeof length, "%lld", (long long)end->step - 700);
  snprintf(deck, sizeof deck, SHAKEN("%s", ""), length);
  sd_model *fixed = model_of(deck);
  sd_state *same = whole_run(fixed, 1);
  same_states(same, end, "without a goal");
  sd_state_free(same);
  sd_model_free(fixed);
  sd_state_free(end);
  sd_model_free(model);
}

static void gives_up_at_max_time(void **unused) {
  sd_model *model = model_of(SHAKEN("3000", "until = { relative = 1e-6; max_time = 0.1; };"));
  assert_int_equal(sd_model_steps(model), 700 + 5000);
  sd_state *end = whole_run(model, 1);
  assert_true(end->phase == 2 && end->step == 5700 && !sd_goal_of(model, end).reached);
  sd_state_free(end);
  sd_model_free(model);

  /* its own length and no more */
  model = model_of(SHAKEN("3000", "until = { relative = 1e-6; max_time = 0.06; };"));
  end = whole_run(model, 1);
  assert_true(end->phase == 2 && end->step == 3700);
  sd_state_free(end);
  sd_model_free(model);
}

static void decks_say_it(void **unused) {
  sd_model *model = model_of(SHAKEN("3000", "until = { error = 1e-3; max_time = 0.2; };"));
  const sd_until *u = &model->until;
  assert_true(u->asked && u->least == 3000 && u->rotation == 0 && !u->scaled && u->error == 1e-3 &&
              u->relative == 0);
  assert_true(model->phases[1].steps == 10000 && model->phases[0].steps == 700);
  assert_int_equal(model->phases[1].series_every, 3); /* a thousandth of its own length */
  assert_non_null(strstr(sd_model_deck(model)->full,
                         "until = { observable = \"top.omega\"; error = 0.001; max_time = 0.2; }"));
  sd_model *again = model_of(sd_model_deck(model)->full);
  assert_true(again->until.least == 3000 && again->phases[1].steps == 10000 &&
              again->phases[1].series_every == 3 && again->until.error == 1e-3);
  sd_model_free(again);
  sd_model_free(model);

  model = model_of(
      SHAKEN("3000", "until = { observable = \"left.scaled\"; relative = 0.05; max_time = 1; };"));
  assert_true(model->until.asked && model->until.rotation == 1 && model->until.scaled &&
              model->until.relative == 0.05 && model->until.error == 0);
  sd_model_free(model);
  model = model_of(
      SHAKEN("3000", "until = { observable = \"1.omega\"; relative = 0.05; max_time = 1; };"));
  assert_int_equal(model->until.rotation, 1);
  sd_model_free(model);

  model = model_of(SHAKEN("3000", ""));
  assert_true(!model->until.asked && model->phases[1].steps == 3000 &&
              !strstr(sd_model_deck(model)->full, "until"));
  sd_model_free(model);
}

static void decks_are_refused(void **unused) {
  static const struct {
    const char *deck, *told;
  } cases[] = {
      {SHAKEN("9", "until = { error = 1; };"), "test.cfg:9: until.max_time: missing"},
      {SHAKEN("9", "until = { max_time = 1; };"), "test.cfg:9: until.error: missing"},
      {SHAKEN("9", "until = { error = 1; relative = 1; max_time = 1; };"),
       "given together with error"},
      {SHAKEN("9", "until = { error = 0; max_time = 1; };"),
       "until.error = 0: expected a number > 0"},
      {SHAKEN("9", "until = { relative = -1; max_time = 1; };"),
       "until.relative = -1: expected a number > 0"},
      {SHAKEN("9", "until = { error = 1; max_time = -1; };"),
       "until.max_time = -1: expected a number > 0"},
      {SHAKEN("9", "until = { error = 1; max_time = 1e-4; };"),
       "at least the length of the last phase, 0.00018"},
      {SHAKEN("9", "until = { error = 1; max_time = 1e90; };"), "more than 9e18 time steps"},
      {SHAKEN("9", "until = { error = 1; max_time = 1; observable = \"tip.omega\"; };"),
       "did you mean \"top\"?"},
      {SHAKEN("9", "until = { error = 1; max_time = 1; observable = \"right.omega\"; };"),
       "measure.rotation watches no disk that is called \"right\""},
      {SHAKEN("9", "until = { error = 1; max_time = 1; observable = \"top.omga\"; };"),
       "did you mean \"omega\"?"},
      {SHAKEN("9", "until = { error = 1; max_time = 1; observable = \"top\"; };"),
       "expected \"NAME.omega\""},
      {SHAKEN("9", "until = { error = 1; max_time = 1; observable = 3; };"),
       "expected a text in quotes"},
      {SHAKEN("9", "until = { error = 1; max_tim = 1; max_time = 1; };"),
       "did you mean \"max_time\"?"},
      {SHAKEN("9", "until = 4;"), "until = 4: expected a group"},
      {SHAKEN("9; measure = false", "until = { error = 1; max_time = 1; };"),
       "the last phase does not measure"},
      {"dt = 1; time = 9; materials = ( { name = \"a\"; k_n = 1; } ); disks = ( { x = 0; y = 0; "
       "radius = 1; mass = 1; } ); measure = { rotation = (); }; until = { error = 1; max_time = "
       "10; };",
       "no disk is watched"},
      {"dt = 1; time = 9; materials = ( { name = \"a\"; k_n = 1; } ); disks = ( { x = 0; y = 0; "
       "radius = 1; mass = 1; } ); until = { observable = \"0.scaled\"; error = 1; max_time = "
       "10; };",
       "does not exist without gravity"},
  };
  for (size_t k = 0; k < sizeof cases / sizeof *cases; k++) {
    sd_messages *messages = sd_messages_new();
    sd_model *model = NULL;
    assert_int_equal(sd_deck_load_text(cases[k].deck, "test.cfg", 0, NULL, &model, messages),
                     SD_ERROR_USER);
    assert_null(model);
    bool found = false;
    for (size_t j = 0; j < sd_messages_count(messages); j++)
      found |= strstr(sd_messages_text(messages, j), cases[k].told) != NULL;
    if (!found || sd_messages_count(messages) != 1) sd_messages_print(messages, stderr);
    assert_true(found);
    assert_int_equal(sd_messages_count(messages), 1);
    sd_messages_free(messages);
  }
}

/* A model that is made by hand is looked at too. */
static void models_are_refused(void **unused) {
  const sd_until wrong[] = {
      {.least = 0, .error = 1},
      {.least = 3001, .error = 1},
      {.least = 1, .error = 1, .rotation = 2},
      {.least = 1},
      {.least = 1, .error = 1, .relative = 1},
      {.least = 1, .error = NAN},
  };
  for (size_t k = 0; k < sizeof wrong / sizeof *wrong; k++) {
    sd_model *model = model_of(SHAKEN("3000", ""));
    model->until = wrong[k];
    assert_int_equal(sd_model_finish(model, NULL), SD_OK);
    model->until.asked = true;
    assert_int_equal(sd_model_finish(model, NULL), SD_ERROR_USER);
    model->until = (sd_until){.asked = true, .least = 3000, .error = 1};
    assert_int_equal(sd_model_finish(model, NULL), SD_OK);
    model->phases[1].measure = false;
    assert_int_equal(sd_model_finish(model, NULL), SD_ERROR_USER);
    sd_model_free(model);
  }
}

static void means_are_biased_little(void **unused) {
  enum { SEEDS = 60 };
  const double two = 0.6; /* rho for tau = 2 */
  static const char *const heads =
      "  tau, least, wanted, relative, length, early, error, within, chi2, bias, fixed";
  const struct {
    sequential c;
    double chi2, bias;
  } cases[] = {
      {{two, 2000, 200, 0}, 2.2, 0.35},
      /* the goal is 15 % of the mean: the mean comes out too large */
      {{two, 2000, 200, 0.3}, 2.5, 1},
  };
  print_message("%s\n", heads);
  for (size_t k = 0; k < sizeof cases / sizeof *cases; k++) {
    sequential_found f = sequential_trial(&cases[k].c, SEEDS);
    print_sequential(&cases[k].c, &f);
    between(f.reached, 1 - 1e-9, 1 + 1e-9, "reached");
    between(f.length, 0.7, 1.1, "length");
    between(f.error, 0.8, 1.05, "error");
    between(f.chi2, 0.7, cases[k].chi2, "chi2");
    between(fabs(f.bias), 0, cases[k].bias, "bias");
  }
}

RUN_TESTS(TEST(looks_are_few), TEST(goal_of_a_state), TEST(ends_at_the_first_good_look),
          TEST(gives_up_at_max_time), TEST(decks_say_it), TEST(decks_are_refused),
          TEST(models_are_refused), TEST(means_are_biased_little))
