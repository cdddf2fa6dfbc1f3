/* test_order.c: free disks in slots by place, at the start and where phases begin. */
#include "brief.h"
#include "deck_runs.h"
#include "physics/neighbours/neighbours.h"

enum { WIDE = 60, HIGH = 25, DISKS = WIDE * HIGH };

/* Disks of a lattice that falls on a wavy floor and is shaken, periodic along x or between walls; their numbers know
 * nothing of their places where stride > 1. */
static sd_model *heap(int stride, bool periodic, const char *integrator) {
  text t = {0};
  text_add(&t, "dt = 2e-5; seed = 5; integrator = \"%s\"; gravity = { g = 100; };\n", integrator);
  text_add(&t, "box = { x = (0, %.17g); %s };\n", 0.046 * WIDE,
           periodic ? "periodic = \"x\";" : "");
  text_add(&t, "materials = ( { name = \"a\"; k_n = 1e4; k_t = 5e3; gamma_n = 1; mu = 0.5; } );\n"
               "disk_rows = ( { columns = (\"x\", \"y\", \"radius\"); density = 3.57; rows = (");
  for (int n = 0; n < DISKS; n++) {
    int k = n * stride % DISKS, row = k / WIDE;
    text_add(&t, "%s(%.9f, %.9f, %.9f)", n ? ", " : "", 0.046 * (k % WIDE + 0.45 + 0.1 * (row % 2)),
             0.03 + 0.046 * row, 0.0205 + 0.002 * ((k * 37) % 11) / 11.0);
  }
  text_add(&t,
           "); } );\nwalls = ( { name = \"floor\"; type = \"line\"; points = ((0, 0), (1, 0)); }");
  if (!periodic)
    text_add(&t,
             ", { name = \"left\"; type = \"line\"; points = ((0, 1), (0, 0)); }, { name = "
             "\"right\"; type = \"line\"; points = ((%.17g, 0), (%.17g, 1)); }",
             0.046 * WIDE, 0.046 * WIDE);
  text_add(&t, " );\nmotions = ( { wall = \"floor\"; coordinate = \"x\"; type = \"harmonic\"; "
               "amplitude = 5e-3; "
               "frequency = 40; } );\n"
               "phases = ( { steps = 400; }, { steps = 300; measure = true; }, { steps = 300; "
               "measure = true; } );\n"
               "measure = { rotation = (7, 100); disks = true; };\n");
  return model_of_text(&t);
}

static void neighbours_stand_side_by_side(void **unused) {
  for (int periodic = 0; periodic < 2; periodic++) {
    sd_model *model = heap(677, periodic, "verlet");
    sd_simulation *sim = begin_run(model, 1);
    advance(sim, 1000);
    const sd_state *s = sd_simulation_state(sim);
    for (uint32_t k = 0; k < s->n_bodies; k++)
      assert_int_equal(sd_simulation_slot(sim, s->id[k]), k);
    const pairs *p = &engine_of(sim)->work.pairs;
    size_t n = 0;
    int32_t span = 0;
    for (size_t k = 0; k < p->n_round; k++, n++)
      span = p->b[k] - p->a[k] > span ? p->b[k] - p->a[k] : span;
    print_message("  %s: %zu pairs, %d slots apart at most\n", periodic ? "periodic" : "walls", n,
                  span);
    assert_true(n > 1000);
    /* strips of some HIGH disks; folded ones have a strip of the other end between them */
    assert_true(span <= (periodic ? 4 : 2) * (HIGH + 8));
    end_run(sim, model);
  }
}

/* Numbers are names: who has which changes nothing, down to the last bit, since slots go by place. */
static void numbers_are_names(void **unused) {
  for (int k = 0; k < 2; k++) {
    sd_model *plain = heap(1, k, k ? "gear5" : "verlet"),
             *mixed = heap(677, k, k ? "gear5" : "verlet");
    sd_simulation *one = begin_run(plain, 1), *two = begin_run(mixed, 1);
    advance(one, 900);
    advance(two, 900);
    const sd_state *a = sd_simulation_state(one), *b = sd_simulation_state(two);
    assert_int_equal(a->n_contacts, b->n_contacts);
    for (uint32_t n = 0; n < DISKS; n++) {
      uint32_t i = sd_simulation_slot(one, n * 677 % DISKS), j = sd_simulation_slot(two, n);
      assert_true(a->x[i] == b->x[j] && a->y[i] == b->y[j] && a->theta[i] == b->theta[j]);
      assert_true(a->vx[i] == b->vx[j] && a->omega[i] == b->omega[j] &&
                  a->radius[i] == b->radius[j]);
      assert_true(a->loss_friction[i] == b->loss_friction[j] && a->sum_xx[i] == b->sum_xx[j]);
      for (size_t bin = 0; bin < SD_MEAN_BINS; bin++)
        assert_true(a->mean_bin[i * SD_MEAN_BINS + bin] == b->mean_bin[j * SD_MEAN_BINS + bin]);
    }
    sd_simulation_free(one);
    end_run(two, plain);
    sd_model_free(mixed);
  }
}

/* Radii over a decade and a half, and one disk as large as forty, on a shaken floor of many segments. */
static sd_model *mixture(const char *integrator) {
  text t = {0};
  text_add(&t,
           "dt = 2e-3; seed = 3; integrator = \"%s\"; gravity = { g = 1; };\n"
           "materials = ( { name = \"a\"; k_n = 3e3; k_t = 1.5e3; gamma_n = 40; mu = 0.5; } );\n"
           "disks = ( { x = 0; y = 45; radius = 40; mass = 5000; } );\n"
           "packings = ( { type = \"front\"; count = 1300; density = 1; sizes = \"powerlaw\"; "
           "lower = 1; upper = 30;\n"
           "  exponent = 3; x = (-100, 100); y = (0, 400); } );\n"
           "walls = ( { type = \"line\"; points = ((-100, 1), (-100, 0)); }, { type = \"line\"; "
           "points = ((100, 0), (100, 1)); },\n"
           "{ name = \"floor\"; type = \"polyline\"; points = (",
           integrator);
  for (int k = 0; k <= 400; k++)
    text_add(&t, "%s(%.9g, %.9g)", k ? ", " : "", 0.5 * k - 100, -0.2 * (k % 3));
  text_add(&t, "); } );\nmotions = ( { wall = \"floor\"; coordinate = \"y\"; type = \"harmonic\"; "
               "amplitude = 0.1; "
               "frequency = 1; },\n{ wall = \"floor\"; coordinate = \"theta\"; type = "
               "\"harmonic\"; amplitude = 0.01; "
               "frequency = 0.7; } );\n"
               "phases = ( { steps = 400; }, { steps = 300; }, { steps = 300; } );\n");
  return model_of_text(&t);
}

/* Slots go by size, each size by place: those of the largest disks are the last. */
static void large_disks_stand_last(void **unused) {
  sd_model *model = mixture("verlet");
  sd_simulation *sim = begin_run(model, 1);
  const sd_state *s = sd_simulation_state(sim);
  double most = 0.0;
  for (size_t i = 0; i < s->n_free; i++) {
    assert_true(s->radius[i] > most / 4.0);
    most = s->radius[i] > most ? s->radius[i] : most;
  }
  assert_true(s->radius[s->n_free - 1] == 40.0 || s->radius[s->n_free - 1] > 10.0);
  assert_true(s->radius[0] < 40.0 / 16.0);
  end_run(sim, model);
}

RUN_TESTS(TEST(neighbours_stand_side_by_side), TEST(numbers_are_names),
          TEST(large_disks_stand_last))
