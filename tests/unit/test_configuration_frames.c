/* Frames as configurations: contacts of real runs against the engine's own forces, contacts that are found again, disks
 * that are not there. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "deck_runs.h"
#include "measure/stress.h"
#include "system.h"

static void frame_of(frame_data *f, const sd_model *m, const sd_state *s, bool contacts) {
  assert_int_equal(frame_data_of_state(f, m, s, NULL), SD_OK);
  f->has_contacts = contacts;
}

/* Disks in a tilted trough of all kinds of walls, one of which turns. */
static sd_simulation *trough(const char *integrator, const char *variant, double gamma_n) {
  text t = {0};
  text_add(&t,
           "dt = 1e-4; integrator = \"%s\"; contact_variant = \"%s\"; gravity = { g = 10.0; tilt = "
           "0.1; };\n",
           integrator, variant);
  text_add(&t, "materials = ( { name = \"m\"; k_n = 1e6; k_t = 6e5; gamma_n = %g; mu = 0.4; } );\n",
           gamma_n);
  text_add(&t, "disk_rows = ( { columns = (\"x\", \"y\", \"radius\"); density = 10.0; rows = (");
  uint64_t seed = 3;
  for (int k = 0; k < 40; k++) {
    double x = next_uniform(&seed), y = next_uniform(&seed), r = next_uniform(&seed);
    int column = k % 8, row = k / 8;
    text_add(&t, "%s(%.6f, %.6f, %.6f)", k ? ", " : "", -3.4 + column + 0.03 * x,
             1.2 + row + 0.03 * y, 0.36 + 0.13 * r);
  }
  text_add(
      &t,
      "); } );\nwalls = ( { name = \"floor\"; type = \"polyline\"; points = ((-4.5, 3.0), (-4.0, "
      "0.2), (-1.0, "
      "-0.4), (1.5, 0.0), (4.5, 0.5), (4.6, 4.0)); },\n"
      " { name = \"peg\"; type = \"circle\"; center = (0.0, -0.1); side = \"outside\"; radius = "
      "0.6; },\n"
      " { name = \"bar\"; type = \"segment\"; points = ((-2.0, 0.3), (-1.0, 0.1)); },\n"
      " { name = \"line\"; type = \"line\"; points = ((-4.0, 0.3), (-1.0, -0.3)); } );\n"
      "motions = ( { name = \"turn\"; wall = \"bar\"; coordinate = \"theta\"; type = \"harmonic\"; "
      "amplitude = 0.2; "
      "frequency = 1.0; } );\nphases = ( { steps = 100000; } );\n");
  sd_simulation *sim = begin_run(model_of(t.s), 1);
  free(t.s);
  return sim;
}

/* Forces of the contacts of each disk add up to what the engine has in its state. Returns which kinds of bodies are
 * touched: a bit for each wall, and one for disks. */
static unsigned compare_forces(sd_simulation *sim, const char *what) {
  const sd_model *m = sd_simulation_model(sim);
  const sd_state *s = sd_simulation_state(sim);
  frame_data f;
  configuration c;
  frame_of(&f, m, s, true);
  assert_int_equal(configuration_new(&c, m, &f, NULL), SD_OK);
  region g = configuration_region(&c, NULL);
  stress q;
  assert_int_equal(stress_new(&q, &c, &g, NULL), SD_OK);
  double weight = m->disks[0].mass * 10.0;
  for (uint32_t i = 0; i < m->n_disks; i++) {
    uint32_t k = sd_simulation_slot(sim, i);
    double x = s->force_x[k] + m->disks[i].mass * m->gravity[0];
    double y = s->force_y[k] + m->disks[i].mass * m->gravity[1];
    SYSTEM_NEAR(q.resultant[i][0], x, 1e-9 * weight, "%s: x force on disk %u", what, i);
    SYSTEM_NEAR(q.resultant[i][1], y, 1e-9 * weight, "%s: y force on disk %u", what, i);
  }
  unsigned touched = 0;
  for (size_t k = 0; k < c.n_contacts; k++)
    if (c.contacts[k].force > 0.0)
      touched |= 1u << (c.contacts[k].b < 40 ? 4 : c.contacts[k].b - 40);
  stress_free(&q);
  configuration_free(&c);
  frame_data_free(&f);
  return touched;
}

static void test_forces_of_a_run(void **state) {
  (void)state;
  for (int v = 0; v < 2; v++) {
    sd_simulation *sim = trough("verlet", system_variants[v], 500.0);
    const sd_model *m = sd_simulation_model(sim);
    unsigned touched = 0;
    for (int k = 0; k < 15; k++) {
      advance(sim, 1000);
      touched |= compare_forces(sim, system_variants[v]);
    }
    assert_int_equal(touched, 31); /* disks and every kind of wall */
    sd_simulation_free(sim);
    sd_model_free((sd_model *)(uintptr_t)m);
  }
}

static int by_bodies(const void *x, const void *y) {
  const config_contact *p = x, *q = y;
  if (p->a != q->a) return p->a < q->a ? -1 : 1;
  if (p->b != q->b) return p->b < q->b ? -1 : 1;
  return p->part < q->part ? -1 : p->part > q->part;
}

/* Contacts that are found again are those that were stored. With velocity Verlet and no viscosity to rounding; with Gear but
 * for the correction of one step, which the damping multiplies. */
static void recompute(const char *integrator, double gamma_n, double bound, double bound_n,
                      double bound_f) {
  sd_simulation *sim = trough(integrator, "paper", gamma_n);
  const sd_model *m = sd_simulation_model(sim);
  advance(sim, 7000);
  frame_data f[2];
  configuration c[2];
  for (int k = 0; k < 2; k++) {
    frame_of(&f[k], m, sd_simulation_state(sim), k == 0);
    assert_int_equal(configuration_new(&c[k], m, &f[k], NULL), SD_OK);
    assert_int_equal(c[k].recomputed, k == 1);
    qsort(c[k].contacts, c[k].n_contacts, sizeof *c[k].contacts, by_bodies);
  }
  assert_int_equal(c[0].n_contacts, c[1].n_contacts);
  for (size_t k = 0; k < c[0].n_contacts; k++) {
    const config_contact *p = &c[0].contacts[k], *q = &c[1].contacts[k];
    assert_int_equal(by_bodies(p, q), 0);
    SYSTEM_NEAR(q->overlap, p->overlap, bound, "overlap %u %u", p->a, p->b);
    SYSTEM_NEAR(q->force, p->force, 1e-7 + bound_f * (1.0 + p->force), "force %u %u", p->a, p->b);
    SYSTEM_NEAR(q->nx, p->nx, bound_n, "direction %u %u", p->a, p->b);
    assert_true(isnan(q->tau) && isfinite(p->tau));
  }
  for (int k = 0; k < 2; k++) {
    configuration_free(&c[k]);
    frame_data_free(&f[k]);
  }
  sd_simulation_free(sim);
  sd_model_free((sd_model *)(uintptr_t)m);
}

static void test_recomputed_contacts(void **state) {
  (void)state;
  recompute("verlet", 0.0, 1e-13, 1e-12, 0.0);
  recompute("gear5", 500.0, 1e-8, 1e-10, 1e-3);
}

/* Disks that wait or were removed are not there; numbers are those of the deck. */
static void test_absent_disks(void **state) {
  (void)state;
  sd_model *m =
      system_new(SD_GEAR5, SD_PAPER, 1e-3,
                 (sd_contact_law){.k_n = 1000.0, .k_t = 500.0, .gamma_n = 1.0, .mu = 0.3});
  for (int k = 0; k < 6; k++) system_disk(m, 0.99 * k, 0.0, 0.5, 1.0);
  frame_data f;
  assert_int_equal(frame_data_new(&f, 6, 0, NULL), SD_OK);
  for (int k = 0; k < 6; k++) f.position[k][0] = 0.99 * k;
  f.activity[1] = SD_WAITING;
  f.activity[4] = SD_REMOVED;
  f.activity[5] = SD_OUTSIDE;
  configuration c;
  assert_int_equal(configuration_new(&c, m, &f, NULL), SD_OK);
  assert_int_equal(c.model->n_disks, 4);
  assert_int_equal(c.n_waiting, 1);
  assert_int_equal(c.n_removed, 1);
  const uint32_t number[] = {0, 2, 3, 5};
  for (int k = 0; k < 4; k++) assert_int_equal(c.number[k], number[k]);
  assert_int_equal(c.n_contacts, 1); /* of disks 2 and 3 */
  configuration_free(&c);
  /* a table that speaks of a disk that is not there */
  assert_int_equal(frame_data_contacts(&f, 1, NULL), SD_OK);
  f.a[0] = 0, f.b[0] = 1;
  sd_messages *messages = sd_messages_new();
  assert_int_equal(configuration_new(&c, m, &f, messages), SD_ERROR_USER);
  assert_non_null(strstr(sd_messages_text(messages, 0), "bodies 0 and 1"));
  configuration_free(&c);
  sd_messages_free(messages);
  frame_data_free(&f);
  sd_model_free(m);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_forces_of_a_run),
      cmocka_unit_test(test_recomputed_contacts),
      cmocka_unit_test(test_absent_disks),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
