/* test_bounds.c: disks that leave: told of, a reason to stop, or taken out with the energy budget closed; and where
 * limits are when nobody gives them. */
#include "deck_runs.h"
#include "model/model.h"
#include "physics/step/outside.h"

/* A box of segments whose floor has a hole; 20 disks in it. */
static char *leaking_box(const char *more) {
  text t = {0};
  text_add(&t, "dt = 2e-5; gravity = { g = 9.81; };\n"
               "materials = ( { name = \"a\"; k_n = 1e4; k_t = 5e3; gamma_n = 2; mu = 0.4; } );\n"
               "walls = ( { type = \"segment\"; points = ((0, 0), (0.07, 0)); },\n"
               "  { type = \"segment\"; points = ((0.19, 0), (0.25, 0)); },\n"
               "  { type = \"segment\"; points = ((0, 1), (0, 0)); },\n"
               "  { type = \"segment\"; points = ((0.25, 0), (0.25, 1)); } );\n"
               "disk_rows = ( { columns = (\"x\", \"y\", \"radius\"); density = 3.57; rows = (");
  add_lattice(&t, 20, 5, 0.03, 0.03, 0.045, 0.02, 3);
  text_add(&t, "); } );\n measure = { rotation = (); }; steps = 40000; %s", more);
  return t.s;
}

static sd_model *box_model(const char *more) {
  char *deck = leaking_box(more);
  sd_model *m = model_of(deck);
  free(deck);
  return m;
}

enum {
  STEPS = 40000,
  SOME = 6000
}; /* threads that wait for one another are slow on a busy machine */

static sd_status run(sd_simulation *sim, int64_t n, sd_messages *messages) {
  return sd_simulation_advance(sim, n, messages);
}

static int64_t below(const sd_state *s, double y) {
  int64_t n = 0;
  for (size_t i = 0; i < s->n_free; i++) n += s->y[i] < y;
  return n;
}

static const char *last_text(const sd_messages *messages) {
  return sd_messages_text(messages, sd_messages_count(messages) - 1);
}

static void told_of(void **unused) {
  sd_model *m = box_model("bounds = { x = (-1, 1); y = (-0.1, 2); };"), *free_fall = box_model("");
  sd_messages *messages = sd_messages_new();
  sd_simulation *sim = begin_run(m, 1), *other = begin_run(free_fall, 1);
  assert_int_equal(run(sim, STEPS, messages), SD_OK);
  const sd_state *s = sd_simulation_state(sim);
  int64_t lost = below(s, -0.1);
  assert_true(lost > OUTSIDE_TOLD && lost < 20);
  assert_int_equal(outside_count(s), lost);
  assert_int_equal(s->outside, lost);
  assert_int_equal(sd_messages_count(messages), OUTSIDE_TOLD + 1);
  assert_int_equal(sd_messages_errors(messages), 0);
  assert_non_null(strstr(sd_messages_text(messages, 0), "left the bounds, it is at ("));
  assert_non_null(strstr(last_text(messages), "only counted"));
  print_message("  %s\n  %lld lost\n", sd_messages_text(messages, 0), (long long)lost);
  /* looking changes nothing */
  advance(other, STEPS);
  const sd_state *o = sd_simulation_state(other);
  assert_memory_equal(s->x, o->x, s->n_free * sizeof(double));
  assert_memory_equal(s->theta, o->theta, s->n_free * sizeof(double));
  sd_messages_free(messages);
  sd_simulation_free(sim);
  end_run(other, m);
  sd_model_free(free_fall);
}

static void reason_to_stop(void **unused) {
  sd_model *m = box_model("bounds = { x = (-1, 1); y = (-0.1, 2); outside = \"stop\"; };");
  sd_messages *messages = sd_messages_new();
  sd_simulation *sim = begin_run(m, 1);
  assert_int_equal(run(sim, STEPS, messages), SD_ERROR_NUMERIC);
  const sd_state *s = sd_simulation_state(sim);
  assert_int_equal(s->step % OUTSIDE_EVERY, 0);
  assert_int_equal(s->outside, 1);
  char name[60] = "";
  for (size_t i = 0; i < s->n_free && !*name; i++) /* the first of those that are out */
    if (s->y[i] < -0.1)
      snprintf(name, sizeof name, "step %lld: disk %u left", (long long)s->step, s->id[i]);
  assert_non_null(strstr(last_text(messages), name));
  sd_messages_free(messages);
  end_run(sim, m);
}

static void taken_out(void **unused) {
  /* in the hole itself, where disks touch the ends of the floor and one another */
  sd_model *m = box_model("bounds = { x = (-1, 1); y = (0.005, 2); outside = \"remove\"; };");
  sd_messages *messages = sd_messages_new();
  sd_simulation *sim = begin_run(m, 1);
  assert_int_equal(run(sim, STEPS, messages), SD_OK);
  const sd_state *s = sd_simulation_state(sim);
  sd_energy energy = sd_simulation_energy(sim);
  int64_t removed = 0;
  for (size_t i = 0; i < s->n_free; i++) {
    if (s->activity[i] != SD_REMOVED) continue;
    removed++;
    /* where it was found: at most OUTSIDE_EVERY steps beyond the limit */
    between(s->y[i], 0.005 - OUTSIDE_EVERY * 2e-5 * 3, 0.005, "height of a removed disk");
    assert_true(s->vx[i] == 0 && s->vy[i] == 0 && s->omega[i] == 0);
  }
  assert_true(removed > OUTSIDE_TOLD);
  assert_int_equal(outside_count(s), removed);
  for (size_t k = 0; k < s->n_contacts; k++)
    assert_int_equal(s->activity[sd_simulation_slot(sim, s->contact_a[k])], SD_IN_PLAY);
  between(energy.residual, -1e-3 * energy.scale, 1e-3 * energy.scale, "residual");
  print_message("  %lld taken out, residual %.2g of %.3g\n", (long long)removed,
                energy.residual / energy.scale, energy.scale);
  sd_messages_free(messages);
  end_run(sim, m);
}

/* A ball that is thrown up leaves, comes back, and is in play as before. */
static void comes_back(void **unused) {
  sd_model *m =
      model_of("dt = 1e-4; gravity = { g = 10; }; steps = 25000; bounds = { y = (-1, 3); };\n"
               "materials = ( { name = \"a\"; k_n = 1e4; gamma_n = 20; } );\n"
               "walls = ( { type = \"line\"; points = ((-1, 0), (1, 0)); } );\n"
               "disks = ( { x = 0; y = 1; vy = 10; radius = 0.5; mass = 1; } );");
  sd_messages *messages = sd_messages_new();
  sd_simulation *sim = begin_run(m, 1);
  assert_int_equal(run(sim, 10000, messages), SD_OK);
  assert_int_equal(sd_simulation_state(sim)->activity[0], SD_OUTSIDE);
  assert_int_equal(run(sim, 15000, messages), SD_OK);
  assert_int_equal(sd_simulation_state(sim)->activity[0], SD_IN_PLAY);
  assert_int_equal(sd_simulation_state(sim)->outside, 1);
  assert_int_equal(outside_count(sd_simulation_state(sim)), 0);
  assert_int_equal(sd_messages_count(messages), 1);
  sd_messages_free(messages);
  end_run(sim, m);
}

static void without_limits_of_its_own(void **unused) {
  /* the extent of the box is 1 high */
  sd_model *m = box_model("");
  assert_true(m->bounds.given && m->bounds.outside == SD_OUTSIDE_REPORT);
  between(m->bounds.lower[SD_Y], -10, -10, "lower limit far out");
  between(m->bounds.upper[SD_X], 10.25, 10.25, "right limit far out");
  sd_model_free(m);
}

static const char plain[] = "dt = 1e-4; steps = 10; materials = ( { name = \"a\"; k_n = 1e4; } );\n"
                            "disks = ( { x = 0; y = 1; radius = 0.5; mass = 1; } );\n";

static sd_model *plain_model(const char *more) {
  text t = {0};
  text_add(&t, "%s%s", plain, more);
  return model_of_text(&t);
}

static void nothing_can_be_lost(void **unused) {
  static const char *const open[] = {
      "", "gravity = { g = 10; };",
      "walls = ( { type = \"segment\"; points = ((-1, 0), (1, 0)); } );",
      "gravity = { g = 10; }; walls = ( { type = \"line\"; points = ((-1, 0), (1, 0)); } );"};
  for (size_t k = 0; k < sizeof open / sizeof *open; k++) {
    sd_model *m = plain_model(open[k]);
    assert_false(m->bounds.given);
    sd_model_free(m);
  }
}

static void refused(const char *more, const char *why) {
  text t = {0};
  sd_messages *messages = sd_messages_new();
  sd_model *m = NULL;
  text_add(&t, "%s%s", plain, more);
  assert_int_equal(sd_deck_load_text(t.s, "test.cfg", 0, NULL, &m, messages), SD_ERROR_USER);
  assert_null(m);
  if (!strstr(sd_messages_text(messages, 0), why)) fail_msg("%s", sd_messages_text(messages, 0));
  free(t.s);
  sd_messages_free(messages);
}

static void mistakes(void **unused) {
  refused("bounds = { x = (1, 0); };", "lower < upper");
  refused("bounds = { y = (2, 3); };", "disk 0 at (0, 1) starts outside the bounds");
  refused("bounds = { outside = \"flee\"; };", "expected one of");
}

RUN_TESTS(TEST(told_of), TEST(reason_to_stop), TEST(taken_out), TEST(comes_back),
          TEST(without_limits_of_its_own), TEST(nothing_can_be_lost), TEST(mistakes))
