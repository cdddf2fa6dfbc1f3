/* test_settle.c: phases that end when the disks are at rest: what is measured, where the end is, and that it is
 * at the same step with any number of threads and after any number of restarts. */
#include "deck_runs.h"
#include "model/model.h"
#include "pack/settle.h"

/* Disks fall into a box and lose what they bring; then a phase that only measures. */
static char *pile(int n, int64_t most, const char *settle, const char *more) {
  text t = {0};
  text_add(
      &t,
      "dt = 2e-5; gravity = { g = 9.81; };\n"
      "materials = ( { name = \"a\"; k_n = 1e4; k_t = 5e3; gamma_n = 2; mu = 0.4; } );\n"
      "walls = ( { type = \"line\"; points = ((-1, 0), (1, 0)); },\n"
      "  { type = \"line\"; points = ((0, 1), (0, 0)); }, { type = \"line\"; points = ((0.2, 0), "
      "(0.2, 1)); } );\n"
      "disk_rows = ( { columns = (\"x\", \"y\", \"radius\"); density = 3.57; rows = (");
  add_lattice(&t, n, 4, 0.03, 0.03, 0.045, 0.02, 3);
  text_add(
      &t,
      "); } );\n%s phases = ( { name = \"fall\"; steps = %lld; settle = { %s }; series = 0; },\n"
      "  { name = \"after\"; steps = 300; series = 0; } ); measure = { rotation = (0, 1); };",
      more, (long long)most, settle);
  return t.s;
}

static sd_model *pile_model(int n, int64_t most, const char *settle) {
  char *deck = pile(n, most, settle, "");
  sd_model *m = model_of(deck);
  free(deck);
  return m;
}

enum { PLENTY = 1000000 };

static void a_disk_in_flight_and_one_at_rest(void **unused) {
  sd_model *m = model_of("dt = 1e-4; gravity = { g = 10; }; steps = 100000;\n"
                         "materials = ( { name = \"a\"; k_n = 1e3; gamma_n = 20; } );\n"
                         "walls = ( { type = \"line\"; points = ((-1, 0), (1, 0)); } );\n"
                         "disks = ( { x = 0; y = 0.999; radius = 1; mass = 0.1; },\n"
                         "  { x = 5; y = 9; vx = 3; omega = 2; radius = 1; mass = 0.2; } );");
  sd_simulation *sim = begin_run(m, 1);
  /* one carries its weight m g = 1 with an overlap of 1e-3, the other falls: resultants 0 and 2, one contact of 1 */
  settle_measure now = settle_measure_now(engine_of(sim));
  between(now.kinetic, (0.9 + 0.2) / 2 - 1e-12, (0.9 + 0.2) / 2 + 1e-12, "kinetic energy per disk");
  between(now.unbalanced, 1 - 1e-12, 1 + 1e-12, "unbalanced force");
  /* what is out of play or lost does not count, nor does what is held */
  engine_of(sim)->state->activity[1] = SD_OUTSIDE;
  now = settle_measure_now(engine_of(sim));
  between(now.kinetic, 0, 0, "kinetic energy of the disk at rest");
  between(now.unbalanced, 0, 1e-12, "its unbalanced force");
  end_run(sim, m);
}

static void without_contacts_nothing_is_balanced(void **unused) {
  sd_model *m = model_of("dt = 1e-4; gravity = { g = 10; }; steps = 10;\n"
                         "materials = ( { name = \"a\"; k_n = 1e3; } );\n"
                         "disks = ( { x = 0; y = 0; radius = 1; mass = 1; }, { x = 9; y = 0; "
                         "radius = 1; mass = 1; } );");
  sd_simulation *sim = begin_run(m, 1);
  assert_true(isinf(settle_measure_now(engine_of(sim)).unbalanced));
  sd_simulation_free(sim);
  m->gravity[1] = 0; /* free and at rest: balanced */
  sim = begin_run(m, 1);
  assert_true(settle_measure_now(engine_of(sim)).unbalanced == 0);
  end_run(sim, m);
}

static const char *const criteria[] = {"kinetic = 1e-8; every = 250;",
                                       "unbalanced = 1e-3; every = 100;",
                                       "kinetic = 1e-8; unbalanced = 1e-3;"};

/* The end is at the first look at which the criteria hold; one step further is the next phase. */
static void ends_at_the_first_look(void **unused) {
  for (size_t k = 0; k < sizeof criteria / sizeof *criteria; k++) {
    sd_model *m = pile_model(10, PLENTY, criteria[k]);
    const sd_settle *asked = &m->phases[0].settle;
    sd_simulation *sim = begin_run(m, 1);
    int64_t looks = 0;
    settle_measure last = {0};
    while (sd_simulation_stage(sim).phase == 0) {
      if (looks++ > 0)
        assert_true((asked->kinetic > 0 && last.kinetic > asked->kinetic) ||
                    (asked->unbalanced > 0 && last.unbalanced > asked->unbalanced));
      advance(sim, asked->every);
      last = settle_measure_now(engine_of(sim));
    }
    const sd_state *s = sd_simulation_state(sim);
    assert_int_equal(s->phase_steps[0], looks * asked->every);
    assert_true(s->phase_steps[0] < PLENTY);
    assert_int_equal(s->step, s->phase_steps[0]);
    assert_int_equal(s->phase_step, 0);
    assert_int_equal(s->phase_reached[0], 1);
    assert_true(s->phase_kinetic[0] == last.kinetic && s->phase_unbalanced[0] == last.unbalanced);
    assert_int_equal(sd_simulation_stage(sim).before, s->phase_steps[0]);
    print_message("  %s: %lld steps\n", criteria[k], (long long)s->phase_steps[0]);
    advance(sim, PLENTY);
    assert_true(sd_simulation_finished(sim));
    assert_int_equal(sd_simulation_state(sim)->measured, 300);
    assert_int_equal(sd_simulation_state(sim)->step, looks * asked->every + 300);
    end_run(sim, m);
  }
}

static void one_that_does_not_settle(void **unused) {
  sd_model *m = pile_model(16, 700, "kinetic = 1e-8; every = 500;");
  sd_simulation *sim = begin_run(m, 1);
  advance(sim, 2000);
  const sd_state *s = sd_simulation_state(sim);
  assert_int_equal(s->phase_steps[0], 700);
  assert_int_equal(s->phase_reached[0], 0);
  assert_true(s->phase_kinetic[0] > 1e-8);
  assert_int_equal(s->step, 1000);
  end_run(sim, m);
}

RUN_TESTS(TEST(a_disk_in_flight_and_one_at_rest), TEST(without_contacts_nothing_is_balanced),
          TEST(ends_at_the_first_look), TEST(one_that_does_not_settle))
