/* test_rain.c: disks that fall in batches: where and when they set out, that all of them come to rest with the energy
 * budget closed, and the same bits with any number of threads and restarts. */
#include "deck_runs.h"
#include "model/model.h"
#include "pack/rain.h"

enum { DISKS = 104, BATCH = 25, INTERVAL = 5000, RUSH = 1000 };

#define WIDTH 0.5

/* The last DISKS disks of a box rain; two lie there, one of them fixed. */
static sd_model *rain_model(const char *lid, const char *phase) {
  text t = {0};
  uint64_t seed = 5;
  text_add(&t,
           "dt = 2e-5; gravity = { g = 9.81; };\n"
           "materials = ( { name = \"a\"; k_n = 1e4; k_t = 5e3; gamma_n = 2; mu = 0.4; } );\n"
           "walls = ( { name = \"floor\"; type = \"line\"; points = ((0, 0), (1, 0)); },\n"
           "  { type = \"line\"; points = ((0, 1), (0, 0)); },\n"
           "  { type = \"line\"; points = ((%g, 0), (%g, 1)); } %s);\n"
           "disks = ( { x = 0.2; y = 0.016; radius = 0.016; density = 3.57; },\n"
           "  { x = 0.4; y = 0.03; radius = 0.02; density = 3.57; fixed = true; } );\n"
           "disk_rows = ( { columns = (\"x\", \"y\", \"radius\"); density = 3.57; rows = (",
           WIDTH, WIDTH, lid);
  for (int k = 0; k < DISKS; k++)
    text_add(&t, "%s(%g, %g, %.6f)", k ? ", " : "", 0.1, 10 + 0.1 * k,
             0.012 + 0.012 * next_uniform(&seed));
  text_add(&t, "); } );\nphases = ( { %s } ); measure = { rotation = (); };", phase);
  sd_model *m = model_of_text(&t);
  m->rains = calloc(1, sizeof *m->rains);
  assert_non_null(m->rains);
  m->n_rains = 1;
  m->rains[0] = (sd_rain){.first = 2,
                          .count = DISKS,
                          .batch = BATCH,
                          .interval = INTERVAL,
                          .lower = 0,
                          .upper = WIDTH,
                          .floor = 0,
                          .gap = 0.02,
                          .speed = 0.5};
  for (size_t k = 0; k < DISKS; k++) m->disks[2 + k].waiting = true;
  assert_int_equal(sd_model_finish(m, NULL), SD_OK);
  return m;
}

static const char until_rest[] =
    "steps = 500000; settle = { kinetic = 1e-9; unbalanced = 1e-2; every = 500; };";

static int64_t count_of(const sd_state *s, int32_t activity) {
  int64_t n = 0;
  for (size_t i = 0; i < s->n_free; i++) n += s->activity[i] == activity;
  return n;
}

static double largest_overlap(const sd_state *s) {
  double largest = 0;
  for (size_t k = 0; k < s->n_contacts; k++) largest = fmax(largest, s->contact_overlap[k]);
  return largest;
}

/* Disk numbers from ... to - 1 lie in the strip, above what was there, apart from one another, and set out. */
static void check_batch(const sd_model *m, sd_simulation *sim, uint32_t from, uint32_t to) {
  const sd_state *s = sd_simulation_state(sim);
  double top = 0;
  for (uint32_t d = 0; d < from; d++) {
    uint32_t i = sd_simulation_slot(sim, d);
    top = fmax(top, s->y[i] + s->radius[i]);
  }
  for (uint32_t d = from; d < to; d++) {
    uint32_t i = sd_simulation_slot(sim, d);
    assert_int_equal(s->activity[i], SD_IN_PLAY);
    assert_true(s->x[i] - s->radius[i] >= 0 && s->x[i] + s->radius[i] <= WIDTH);
    between(s->y[i] - s->radius[i], top + m->rains[0].gap - 1e-12, top + 0.4,
            "bottom of a disk of the batch");
    assert_true(s->vx[i] == 0 && s->vy[i] == -0.5 && s->omega[i] == 0);
    for (uint32_t other = 0; other < d; other++) {
      uint32_t j = sd_simulation_slot(sim, other);
      if (hypot(s->x[i] - s->x[j], s->y[i] - s->y[j]) < (s->radius[i] + s->radius[j]) * (1 - 1e-12))
        fail_msg("disks %u and %u overlap at release", d, other);
    }
  }
}

/* No two batches of disks alike stand in columns. */
static void check_columns(const sd_model *m, sd_simulation *sim) {
  const sd_state *s = sd_simulation_state(sim);
  int alike = 0;
  for (uint32_t d = 2; d + 1 < m->n_disks; d++)
    for (uint32_t e = d + 1; e < m->n_disks; e++)
      alike += fabs(s->x[sd_simulation_slot(sim, d)] - s->x[sd_simulation_slot(sim, e)]) < 1e-9;
  assert_int_equal(alike, 0);
}

static void falls_until_it_is_at_rest(void **unused) {
  sd_model *m = rain_model("", until_rest);
  sd_simulation *sim = begin_run(m, 1);
  int64_t released = 0;
  for (int64_t batch = 0; batch * BATCH < DISKS; batch++) {
    int64_t next = released + BATCH < DISKS ? released + BATCH : DISKS;
    const sd_state *s = sd_simulation_state(sim);
    assert_int_equal(s->released, next);
    assert_int_equal(count_of(s, SD_WAITING), DISKS - next);
    assert_int_equal(rain_waits(engine_of(sim)), next < DISKS);
    check_batch(m, sim, 2 + (uint32_t)released, 2 + (uint32_t)next);
    /* free fall, as exact as the integrator is for it */
    uint32_t i = sd_simulation_slot(sim, 2 + (uint32_t)released);
    double y = s->y[i], t = 20 * m->dt;
    advance(sim, 20);
    between(sd_simulation_state(sim)->y[i], y - 0.5 * t - 4.905 * t * t - 1e-15,
            y - 0.5 * t - 4.905 * t * t + 1e-15, "height after 20 steps");
    released = next;
    if (released == DISKS) break;
    /* the step that ends with a release leaves the residual where it was */
    advance(sim, INTERVAL - 21);
    sd_energy before = sd_simulation_energy(sim);
    advance(sim, 1);
    sd_energy after = sd_simulation_energy(sim);
    double brought = after.start - before.start;
    assert_true(brought > 0.01);
    between(after.residual - before.residual, -1e-4 * brought, 1e-4 * brought,
            "residual of a release");
  }
  check_columns(m, sim);
  advance(sim, 500000);
  const sd_state *s = sd_simulation_state(sim);
  sd_energy energy = sd_simulation_energy(sim);
  assert_true(sd_simulation_finished(sim));
  assert_int_equal(s->phase_reached[0], 1);
  assert_int_equal(count_of(s, SD_IN_PLAY), DISKS + 1);
  double top = 0;
  for (size_t i = 0; i < s->n_free; i++) {
    assert_true(s->x[i] > 0 && s->x[i] < WIDTH && s->y[i] > 0);
    top = fmax(top, s->y[i]);
  }
  /* the weight above a contact is a few times that of a column */
  double column = top * 3.57 * 9.81 * 0.048;
  between(largest_overlap(s), 0, 4 * column / 1e4, "largest overlap");
  between(energy.residual, -1e-3 * energy.scale, 1e-3 * energy.scale, "residual");
  print_message("  at rest after %lld steps, top %.3f, overlap %.2g, residual %.2g of %.3g\n",
                (long long)s->step, top, largest_overlap(s), energy.residual / energy.scale,
                energy.scale);
  end_run(sim, m);
}

/* What waits has no weight and no place. */
static void waiting_disks_are_not_there(void **unused) {
  sd_model *m = rain_model("", "steps = 1000;");
  m->rains[0].batch = 1;
  sd_simulation *sim = begin_run(m, 1);
  advance(sim, 1000);
  const sd_state *s = sd_simulation_state(sim);
  for (uint32_t d = 3; d < m->n_disks; d++) {
    uint32_t i = sd_simulation_slot(sim, d);
    assert_true(s->activity[i] == SD_WAITING && s->x[i] == 0.1 && s->y[i] > 10 && s->vy[i] == 0);
  }
  sd_energy energy = sd_simulation_energy(sim);
  double weight = 9.81 * (m->disks[0].mass + m->disks[2].mass);
  between(energy.external, 0, weight, "potential energy of two disks below y = 1");
  end_run(sim, m);
}

static void another_seed_is_another_packing(void **unused) {
  sd_model *m = rain_model("", "steps = 12000;");
  double x[2];
  for (int k = 0; k < 2; k++, m->seed++) {
    sd_simulation *sim = begin_run(m, 1);
    x[k] = sd_simulation_state(sim)->x[sd_simulation_slot(sim, 2)];
    sd_simulation_free(sim);
  }
  assert_true(x[0] != x[1]);
  sd_model_free(m);
}

static void a_lid_is_in_the_way(void **unused) {
  static const double heights[] = {0.1, 0.35};
  for (size_t k = 0; k < 2; k++) {
    char lid[120];
    snprintf(lid, sizeof lid,
             ", { name = \"lid\"; type = \"segment\"; points = ((0, %g), (1, %g)); } ", heights[k],
             heights[k]);
    sd_model *m = rain_model(lid, "steps = 50000;");
    sd_messages *messages = sd_messages_new();
    sd_simulation *sim = NULL;
    sd_status status = sd_simulation_new(m, 1, &sim, messages);
    if (status == SD_OK) status = sd_simulation_advance(sim, 50000, messages);
    assert_int_equal(status, SD_ERROR_NUMERIC);
    const char *told = sd_messages_text(messages, sd_messages_count(messages) - 1);
    if (!strstr(told, "has no room") || !strstr(told, "wall \"lid\" is in the way"))
      fail_msg("%s", told);
    sd_messages_free(messages);
    end_run(sim, m);
  }
}

/* A strip that is periodic in x: disks on one side do not overlap with those on the other. */
static void periodic_strip(void **unused) {
  sd_model *m = rain_model("", "steps = 20000;");
  m->periodic[SD_X] = true;
  m->lower[SD_X] = 0;
  m->upper[SD_X] = WIDTH;
  m->n_walls = 1; /* the floor */
  for (size_t w = 1; w < 3; w++) {
    free((char *)m->walls[w].name);
    free(m->walls[w].points);
  }
  assert_int_equal(sd_model_finish(m, NULL), SD_OK);
  sd_simulation *sim = begin_run(m, 1);
  for (int k = 0; k < 4; k++) {
    assert_true(largest_overlap(sd_simulation_state(sim)) < 1e-3);
    advance(sim, INTERVAL);
  }
  assert_int_equal(sd_simulation_state(sim)->released, 4 * BATCH + 4 * (DISKS > 4 * BATCH));
  sd_energy energy = sd_simulation_energy(sim);
  between(energy.residual, -1e-3 * energy.scale, 1e-3 * energy.scale, "residual");
  end_run(sim, m);
}

static void refused(sd_model *m, const char *why) {
  sd_messages *messages = sd_messages_new();
  assert_int_equal(sd_model_finish(m, messages), SD_ERROR_USER);
  if (!strstr(sd_messages_text(messages, 0), why)) fail_msg("%s", sd_messages_text(messages, 0));
  sd_messages_free(messages);
  sd_model_free(m);
}

static void mistakes(void **unused) {
  sd_model *m = rain_model("", "steps = 10;");
  m->rains[0].upper = 0.03;
  refused(m, "does not fit into rain");
  m = rain_model("", "steps = 10;");
  m->rains[0].count--;
  refused(m, "disks wait");
  m = rain_model("", "steps = 10;");
  m->disks[5].waiting = false;
  refused(m, "a free disk that waits");
  m = rain_model("", "steps = 10;");
  m->rains[0].batch = 0;
  refused(m, "batch");
}

RUN_TESTS(TEST(falls_until_it_is_at_rest), TEST(waiting_disks_are_not_there),
          TEST(another_seed_is_another_packing), TEST(a_lid_is_in_the_way), TEST(periodic_strip),
          TEST(mistakes))
