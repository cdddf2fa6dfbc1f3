/* test_stability.c: where time steps become unstable (model/stability.c), and what is said of it.
 *
 * A disk is held between two walls and pushed a little. Below the limit of sd_model_step_limit the motion dies out, above it
 * it grows by orders of magnitude: for both integrators, from weak to strong viscosity. Gear without any gains energy slowly from
 * 20 steps per period on, so the limit alone is asked of Verlet only there.
 */
#include "deck_runs.h"
#include "model/advice.h"
#include "model/laws.h"
#include "model/model.h"

/* k_n = 1, m = 1: w^2 = 2, c = 2 gamma_n = 2 zeta w. */
static sd_model *held(const char *integrator, const char *law, double gamma, double dt,
                      const char *limits) {
  char deck[1200];
  snprintf(deck, sizeof deck,
           "integrator = \"%s\"; dt = %.17g; steps = 100000; output = { series = 0; };"
           "materials = ( { name = \"m\"; %s gamma_n = %.17g; } );"
           "disks = ( { name = \"held\"; x = 0.0; y = 0.0; %s radius = 1.0; mass = 1.0; } );"
           "walls = ( { type = \"line\"; points = ((0.0, -0.995), (1.0, -0.995)); },"
           "          { type = \"line\"; points = ((0.0, 0.995), (1.0, 0.995)); } ); %s",
           integrator, dt, law, gamma, strstr(limits, "motions") ? "" : "vy = 1e-9;", limits);
  return model_of(deck);
}

/* How much faster the disk becomes than at the start. */
static double growth(const char *integrator, double zeta, double part, double *limit) {
  const char *any = "limits = { unstable_step = true; };", *linear = "k_n = 1.0;";
  double gamma = zeta * sqrt(2.0), largest = 0;
  sd_model *m = held(integrator, linear, gamma, 1e-3, any);
  sd_messages *messages = sd_messages_new();
  *limit = sd_model_step_limit(m).dt;
  sd_model_free(m);
  m = held(integrator, linear, gamma, part * *limit, any);
  sd_simulation *s;
  assert_int_equal(sd_simulation_new(m, 1, &s, messages), SD_OK);
  for (int k = 0; k < 200 && largest < 1e-5; k++) {
    assert_int_equal(sd_simulation_advance(s, 20, messages), SD_OK);
    largest = fmax(largest, fabs(sd_simulation_state(s)->vy[0]));
  }
  sd_simulation_free(s);
  sd_messages_free(messages);
  sd_model_free(m);
  return largest / 1e-9;
}

static void limits_are_where_motion_begins_to_grow(void **unused) {
  static const double zetas[] = {0, 0.01, 0.05, 0.2, 0.5, 1, 2};
  static const char *const integrators[] = {"verlet", "gear5"};
  for (int n = 0; n < 2; n++)
    for (size_t k = n; k < sizeof zetas / sizeof *zetas; k++) {
      char what[80];
      double limit, below = growth(integrators[n], zetas[k], 0.98, &limit),
                    above = growth(integrators[n], zetas[k], 1.02, &limit);
      snprintf(what, sizeof what, "%s, zeta = %g, limit %g", integrators[n], zetas[k], limit);
      between(below, 0, 12, what);
      between(above, 1e3, HUGE_VAL, what);
    }
}

/* In closed form: physics.md 5. */
static void limits_follow_from_spring_and_viscosity(void **unused) {
  const struct {
    const char *integrator, *law;
    double gamma, dt;
    sd_bound bound;
  } rows[] = {
      {"verlet", "k_n = 1.0;", 0, sqrt(2.0), SD_BOUND_NORMAL},
      {"gear5", "k_n = 1.0;", 0, sqrt(30.0 / 47 / 2), SD_BOUND_NORMAL},
      {"verlet", "k_n = 1e-6;", 1, 0.5, SD_BOUND_VISCOSITY},
      {"gear5", "k_n = 1e-6;", 1, 45.0 / 551, SD_BOUND_VISCOSITY},
      /* w^2 = 2 k_t (1/m + R^2/I) = 6 k_t, not damped */
      {"verlet", "k_n = 1.0; k_t = 6.0; mu = 1.0;", 0.1, 1.0 / 3, SD_BOUND_TANGENTIAL},
      {"verlet", "k_n = 1.0; k_t = 6.0;", 0, sqrt(2.0), SD_BOUND_NORMAL},
      /* Hertz at an overlap of 0.01 R: 1.5 k_n sqrt(0.01), and for e = 1 no viscosity */
      {"verlet", "law = \"hertz\"; k_n = 10.0;", 0, 2 / sqrt(3.0), SD_BOUND_NORMAL},
  };
  for (size_t k = 0; k < sizeof rows / sizeof *rows; k++) {
    sd_model *m = held(rows[k].integrator, rows[k].law, rows[k].gamma, 1e-3, "");
    sd_step_limit limit = sd_model_step_limit(m);
    between(limit.dt, rows[k].dt * (1 - 1e-5), rows[k].dt * (1 + 1e-5), rows[k].law);
    assert_int_equal(limit.bound, rows[k].bound);
    sd_model_free(m);
  }
  /* what a motion holds does not swing */
  const char *lift =
      "motions = ( { disk = \"held\"; coordinate = [ \"x\", \"y\" ]; type = \"velocity\"; "
      "velocity = 0.0; } );";
  sd_model *led = held("verlet", "k_n = 1.0; k_t = 6.0; mu = 1.0;", 1, 1e-3, lift);
  between(sd_model_step_limit(led).dt, 2 / sqrt(24.0) - 1e-9, 2 / sqrt(24.0) + 1e-9,
          "limit of what only turns");
  sd_model_free(led);
  sd_model *bouncy = held("verlet", "law = \"hertz\"; k_n = 10.0; restitution = 0.9;", 0, 1e-3, ""),
           *dead = held("verlet", "law = \"hertz\"; k_n = 10.0; restitution = 0.1;", 0, 1e-3, "");
  assert_true(sd_model_step_limit(dead).dt < 0.8 * sd_model_step_limit(bouncy).dt);
  sd_model_free(bouncy);
  sd_model_free(dead);
}

/* By hand, too; the line of the deck is told. */
static void a_step_beyond_the_limit_is_an_error_unless_asked_for(void **unused) {
  sd_model *m = held("verlet", "k_n = 1.0;", 0, 1.5, "limits = { unstable_step = true; };");
  sd_messages *messages = sd_messages_new();
  sd_model_advise(m, messages);
  assert_int_equal(sd_messages_count(messages), 1);
  assert_non_null(strstr(sd_messages_text(messages, 0), "beyond the limit of stability 1.41"));
  sd_messages_clear(messages);
  assert_int_equal(sd_model_finish(m, messages), SD_OK);
  m->limits.unstable_step = false;
  struct sd_deck *deck = m->deck;
  m->deck = NULL;
  assert_int_equal(sd_model_finish(m, messages), SD_ERROR_USER);
  assert_non_null(strstr(sd_messages_text(messages, 0), "dt = 1.5: beyond 1.41"));
  m->deck = deck;
  sd_messages_clear(messages);
  sd_model *none = NULL;
  const char *line = "dt=1.5";
  assert_int_equal(sd_deck_load_text("integrator = \"verlet\"; dt = 1.5; steps = 1;\n"
                                     "materials = ( { name = \"m\"; k_n = 1.0; } );\n"
                                     "disks = ( { x = 0.0; y = 0.0; radius = 1.0; mass = 1.0; },\n"
                                     "          { x = 9.0; y = 0.0; radius = 1.0; mass = 1.0; } );",
                                     "test.cfg", 0, &line, &none, messages),
                   SD_ERROR_USER);
  assert_non_null(strstr(sd_messages_text(messages, 0), "test.cfg:1: dt = 1.5: beyond 1.41"));
  assert_non_null(strstr(sd_messages_text(messages, 0), "unstable_step"));
  assert_int_equal(sd_messages_count(messages), 1);
  sd_messages_free(messages);
  sd_model_free(m);
}

/* A run that fails near the limit says so; one that fails far from it does not. */
static void a_failed_run_tells_how_near_dt_is(void **unused) {
  sd_model *near = held("gear5", "k_n = 1.0;", 10, 0.004, ""),
           *far = held("gear5", "k_n = 1.0;", 0, 1e-3, "");
  char hint[200];
  assert_non_null(strstr(advice_of_failure(near, "why?", hint, sizeof hint),
                         "of the limit of stability (gear5, viscosity"));
  assert_string_equal(advice_of_failure(far, "why?", hint, sizeof hint),
                      "why? dt is 0.0018 of the limit of stability");
  sd_model_free(near);
  sd_model_free(far);
}

/* Each number of a contact law changes the limit, or is listed here as one that does not. */
static void every_constant_is_known(void **unused) {
  static const char *const no_limit[] = {"mu",
                                         "mu_kinetic",
                                         "critical_load",
                                         "mu_r",
                                         "pull_off",
                                         "range",
                                         "rupture",
                                         "E_star",
                                         "poisson",
                                         "bond_poisson",
                                         "bond_gap",
                                         "bond_tension",
                                         "bond_cohesion",
                                         "bond_friction",
                                         "bond_max_tension",
                                         "bond_max_shear",
                                         "bond_max_bending",
                                         "bond_extension",
                                         "bond_weibull"};
  const sd_contact_law base = {.k_n = 1, .k_t = 1, .mu = 1, .restitution = 0.5},
                       beam = {.k_n = 1, .bond_E = 1, .bond_width = 1};
  const deck_key *key;
  for (size_t k = 0; (key = deck_key_at(&law_table, k)); k++) {
    const bool of_beam = strcmp(key->name, "bond_E") == 0 || strcmp(key->name, "bond_width") == 0;
    const sd_contact_law *from = of_beam ? &beam : &base;
    sd_contact_law changed = *from;
    bool listed = false;
    for (size_t n = 0; n < sizeof no_limit / sizeof *no_limit; n++)
      listed |= strcmp(key->name, no_limit[n]) == 0;
    if (key->target != DECK_SETS_NUMBER || listed) continue;
    *(double *)(void *)((char *)&changed + key->offset) += 0.25;
    if (law_is_as_stiff(from, &changed))
      fail_msg("%s: model/stability.c does not know it; if it sets no limit, list it here",
               key->name);
  }
}

RUN_TESTS(TEST(every_constant_is_known), TEST(limits_are_where_motion_begins_to_grow),
          TEST(limits_follow_from_spring_and_viscosity),
          TEST(a_step_beyond_the_limit_is_an_error_unless_asked_for),
          TEST(a_failed_run_tells_how_near_dt_is))
