/* test_displacement.c: the displacement limit is found at the same step by every form of the step, at the step of the closed form;
 * a summary tells what is not finite, and nothing where limits are off.
 */
#include "io/results/summary.h"
#include "run/ensemble.h"
#include "run/simulation_private.h"
#include "model/state.h"
#include "slipdisk/deck.h"
#include "system.h"

static const sd_contact_law law = {.k_n = 1e3, .k_t = 1e3, .gamma_n = 1, .mu = 0.1};

enum { FALLING = 40, SMALLEST = 17, FIRST = 61 };

static sd_model *falling(sd_integrator integrator) {
  sd_model *m = system_new(integrator, SD_PAPER, 1e-3, law);
  m->gravity[1] = -10;
  m->limits.displacement = 0.00201667; /* n > 60.5 */
  for (size_t i = 0; i < FALLING; i++)
    system_disk(m, 3.0 * (double)i, 0, i == SMALLEST ? 0.3 : 0.5 + 0.01 * (double)i, 1);
  return m;
}

static void assert_first(const sd_state *s, const char *words) {
  if (s->fast_step != FIRST || s->fast_disk != SMALLEST)
    fail_msg("%s: step %lld, disk %lld", words, (long long)s->fast_step, (long long)s->fast_disk);
  SYSTEM_NEAR(s->fast_displacement, 10 * FIRST * 1e-6 / 0.3, 1e-12, "%s", words);
}

static sd_simulation *start_threads(sd_model *m, int threads) {
  sd_simulation *first = system_start(m), *s = NULL;
  sd_simulation_free(first);
  assert_int_equal(simulation_new(m, threads,
                                  threads > 1 ? SIMULATION_GENERAL : SIMULATION_SUITABLE, NULL,
                                  NULL, &s, NULL),
                   SD_OK);
  return s;
}

static void closed_form(void **unused) {
  for (int k = 0; k < 2; k++)
    for (int threads = 1; threads <= 3; threads++) {
      sd_simulation *s = start_threads(falling(k ? SD_VERLET : SD_GEAR5), threads);
      system_advance(s, FIRST - 1);
      assert_int_equal(sd_simulation_state(s)->fast_step, -1);
      assert_int_equal(sd_simulation_rebuild(s, NULL), SD_OK);
      system_advance(s, 1);
      assert_first(sd_simulation_state(s), system_integrators[k]);
      /* the first one stays, also when all is built anew */
      assert_int_equal(sd_simulation_rebuild(s, NULL), SD_OK);
      system_advance(s, 40);
      assert_first(sd_simulation_state(s), system_integrators[k]);
      system_end(s);
    }
}

/* Speeds of the deck are looked at before the first step; 0 switches the limit off. */
static void at_the_start(void **unused) {
  for (int k = 0; k < 2; k++) {
    sd_model *m = falling(SD_GEAR5);
    system_velocity(m, 5, 0, 300, 0);
    if (k) m->limits.displacement = 0;
    sd_simulation *s = system_start(m);
    assert_int_equal(sd_simulation_state(s)->fast_step, k ? -1 : 0);
    assert_int_equal(sd_simulation_state(s)->fast_disk, k ? -1 : 5);
    system_advance(s, 100);
    assert_int_equal(sd_simulation_state(s)->fast_step, k ? -1 : 0);
    system_end(s);
  }
}

enum { MEMBERS = 5, STEPS = 2000 };

static sd_model *three_disks(const char *integrator, const char *limit) {
  const char *overrides[] = {integrator, limit, "motions[*].amplitude=1e-14",
                             "phases.settle.steps=1000"};
  sd_model *m = NULL;
  sd_messages *messages = sd_messages_new();
  if (sd_deck_load(SLIPDISK_SOURCE_DIR "/inputs/three_disk/random.cfg", 4, overrides, &m,
                   messages) != SD_OK)
    sd_messages_print(messages, stderr);
  sd_messages_free(messages);
  assert_non_null(m);
  return m;
}

/* Limits that are crossed sooner, later, and never; beside each other. */
static void forms_of_the_step(void **unused) {
  static const char *const limits[MEMBERS] = {
      "limits.displacement=1e-10", "limits.displacement=3e-9", "limits.displacement=0",
      "limits.displacement=6e-9", "limits.displacement=0.1"};
  static const char *const integrators[] = {"integrator=gear5", "integrator=verlet"};
  for (int k = 0; k < 2; k++) {
    sd_model *model[MEMBERS];
    sd_simulation *together[MEMBERS];
    sd_status status[MEMBERS] = {SD_OK};
    sd_messages *messages[MEMBERS] = {NULL};
    int64_t latest = -1;
    for (size_t i = 0; i < MEMBERS; i++) {
      model[i] = three_disks(integrators[k], limits[i]);
      assert_int_equal(sd_simulation_new(model[i], 1, &together[i], NULL), SD_OK);
    }
    ensemble *e;
    e = ensemble_new(MEMBERS, together);
    ensemble_advance(e, STEPS, status, messages);
    assert_true(ensemble_width() < 2 || ensemble_in_lanes(e) > 1);
    ensemble_free(e);
    for (size_t i = 0; i < MEMBERS; i++) {
      const sd_state *wide = sd_simulation_state(together[i]);
      for (int threads = 1; threads <= (i == 1 ? 2 : 1);
           threads++) { /* 1: in a lane, 2: the general step */
        sd_simulation *alone;
        assert_int_equal(simulation_new(model[i], 1,
                                        threads > 1 ? SIMULATION_GENERAL : SIMULATION_SUITABLE,
                                        NULL, NULL, &alone, NULL),
                         SD_OK);
        system_advance(alone, STEPS);
        const sd_field *f = sd_state_difference(sd_simulation_state(alone), wide);
        if (f) fail_msg("%s, %s, %d: %s differs", integrators[k], limits[i], threads, f->name);
        sd_simulation_free(alone);
      }
      bool crossed = model[i]->limits.displacement > 0 && model[i]->limits.displacement < 0.01;
      assert_int_equal(wide->fast_step > 0, crossed);
      if (wide->fast_step > latest) latest = wide->fast_step;
      sd_simulation_free(together[i]);
      sd_model_free(model[i]);
    }
    assert_true(latest > 10); /* not all of them at the first step */
  }
}

static size_t doubts_of(const sd_model *m, const sd_state *state, sd_energy energy,
                        summary *found) {
  summary_collect(found, m, state, NULL, &energy, 1);
  return summary_doubts(found);
}

static void not_finite(void **unused) {
  sd_simulation *s = system_start(falling(SD_GEAR5));
  const sd_model *m = sd_simulation_model(s);
  sd_state *state = (sd_state *)(uintptr_t)sd_simulation_state(s);
  sd_energy energy = sd_simulation_energy(s);
  summary found;
  assert_int_equal(doubts_of(m, state, energy, &found), 0);
  summary_free(&found);
  double *const table[] = {state->vx, state->omega, state->force_y, state->torque};
  for (size_t k = 0; k < 4; k++) {
    double before = table[k][3];
    table[k][3] = k % 2 ? NAN : HUGE_VAL;
    assert_int_equal(doubts_of(m, state, energy, &found), 1);
    assert_non_null(found.doubts[DOUBT_FINITE].text);
    summary_free(&found);
    table[k][3] = before;
  }
  energy.residual = NAN;
  assert_int_equal(doubts_of(m, state, energy, &found), 2);
  assert_non_null(found.doubts[DOUBT_RESIDUAL].text);
  assert_non_null(found.doubts[DOUBT_FINITE].text);
  char *text = summary_doubts_text(&found);
  assert_non_null(strstr(text, "does not close"));
  assert_non_null(strstr(text, "; a number is not finite (residual)"));
  free(text);
  summary_free(&found);
  system_end(s);
}

static void limits_of_the_residual(void **unused) {
  sd_model *m = falling(SD_GEAR5);
  sd_simulation *s = system_start(m);
  const sd_state *state = sd_simulation_state(s);
  sd_energy energy = sd_simulation_energy(s);
  energy.scale = 2;
  static const struct {
    double limit, residual;
    size_t doubts;
  } cases[] = {
      {0.01, 0.0199, 0}, {0.01, 0.0201, 1}, {0.01, -0.0201, 1}, {0, 1e9, 0}, {1e-4, 2.1e-4, 1}};
  for (size_t k = 0; k < sizeof cases / sizeof *cases; k++) {
    summary found;
    m->limits.residual = cases[k].limit;
    energy.residual = cases[k].residual;
    assert_int_equal(doubts_of(m, state, energy, &found), cases[k].doubts);
    if (cases[k].doubts)
      SYSTEM_NEAR(found.doubts[DOUBT_RESIDUAL].value, fabs(cases[k].residual) / 2, 1e-15,
                  "case %zu", k);
    summary_free(&found);
  }
  system_end(s);
}

RUN_TESTS(TEST(closed_form), TEST(at_the_start), TEST(forms_of_the_step), TEST(not_finite),
          TEST(limits_of_the_residual))
