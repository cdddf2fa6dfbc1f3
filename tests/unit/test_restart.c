/* test_restart.c: a run that is stopped, copied, resumed, rebuilt, looked at or cut into pieces goes on to
 * the same bits; for both integrators, all motions, phases, periodic boxes and walls that turn. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

#include <cmocka.h>

#include "deck_runs.h"

enum { DECKS = 8, MOST = 2600 };

#define MATERIAL                                                                                   \
  "materials = ( { name = \"a\"; k_n = 1e4; k_t = 5e3; gamma_n = 2; mu = 0.4; }, { name = \"b\"; " \
  "k_n = "                                                                                         \
  "2e4; k_t = 2e4; gamma_n = 1; mu = 0.2; } );\n"                                                  \
  "material_pairs = ( { materials = (\"a\", \"b\"); k_n = 1.5e4; k_t = 1e4; gamma_n = 2; mu = "    \
  "0.3; } );\n"

/* Three disks: every motion kind on the supports, ramps, intervals, sums; several phases. */
static void supports(text *t) {
  text_add(t, "dt = 5e-6; gravity = { g = 10; tilt = 0.1; };\n" MATERIAL
              "disks = ( { name = \"top\"; x = 0; y = 0; omega = 30; radius = 1; mass = 0.1; "
              "material = \"a\"; },\n"
              "{ name = \"left\"; x = -1; y = -1.7320508; radius = 1; mass = 0.1; fixed = true; "
              "material = \"a\"; "
              "},\n"
              "{ name = \"right\"; x = 1; y = -1.7320508; radius = 1; mass = 0.1; fixed = true; "
              "material = \"b\"; } "
              ");\n"
              "motions = ( { name = \"r\"; disk = (\"left\", \"right\"); coordinate = (\"x\", "
              "\"y\"); type = "
              "\"random\"; amplitude = 2e-5; omega = 300; },\n"
              "{ name = \"h\"; disk = \"left\"; coordinate = \"theta\"; type = \"random\"; "
              "amplitude = 0.1; omega = "
              "500; interval = 37; ramp = 0.004; },\n"
              "{ name = \"s\"; disk = \"left\"; coordinate = \"theta\"; type = \"harmonic\"; "
              "amplitude = 0.2; omega "
              "= 700; ramp = 0.01; },\n"
              "{ name = \"v\"; disk = \"right\"; coordinate = \"theta\"; type = \"velocity\"; "
              "velocity = 2e3; },\n"
              "{ name = \"p\"; disk = \"right\"; coordinate = \"y\"; type = \"parabolic\"; "
              "amplitude = 1e-4; omega = "
              "900; },\n"
              "{ name = \"t\"; disk = \"left\"; coordinate = \"y\"; type = \"table\"; times = (0, "
              "0.001, 0.003, "
              "0.004); values = (0, 1e-4, -1e-4, 0); periodic = true; } );\n"
              "phases = ( { steps = 500; motions = [\"r\", \"h\"]; }, { steps = 777; measure = "
              "true; }, { steps = "
              "300; motions = [\"r\", \"v\"]; },\n"
              "{ steps = 1; motions = [\"h\"]; }, { steps = 900; }, { steps = 100000; motions = "
              "[\"r\", \"s\", "
              "\"p\"]; measure = true; } );\n"
              "measure = { rotation = [\"top\"]; sliding = ( { disk = \"top\"; partners = "
              "[\"left\", \"right\"]; } "
              "); configurations = true; };\n");
}

/* A box that repeats in both directions: disks fly, wrap and collide; one is driven around it. */
static void gas(text *t) {
  text_add(t, "dt = 5e-5; box = { x = (0, 1); y = (-0.5, 0.5); periodic = \"xy\"; };\n" MATERIAL
              "disk_rows = (");
  uint64_t seed = 12;
  text_add(
      t,
      "{ columns = (\"x\", \"y\", \"radius\", \"vx\", \"vy\", \"omega\"); density = 3; material = "
      "\"a\"; rows = (");
  for (int k = 0; k < 45; k++)
    text_add(t, "%s(%.4f, %.4f, %.4f, %.4f, %.4f, %.4f)", k ? ", " : "", 0.07 + 0.14 * (k % 7),
             -0.43 + 0.14 * (k / 7), 0.05 + 0.018 * next_uniform(&seed),
             4 * next_uniform(&seed) - 2, 4 * next_uniform(&seed) - 2,
             400 * next_uniform(&seed) - 200);
  text_add(t, "); }, { columns = (\"x\", \"y\", \"radius\"); mass = 1; material = \"b\"; fixed = "
              "true; rows = ((0.5, "
              "0.42, 0.06)); },\n"
              "{ columns = (\"x\", \"y\", \"radius\"); mass = 0.03; material = \"b\"; rows = "
              "((0.63, 0.42, 0.05), "
              "(0.77, 0.42, 0.05)); } );\n"
              "motions = ( { disk = 45; coordinate = \"x\"; type = \"velocity\"; velocity = 4; }, "
              "{ disk = 45; "
              "coordinate = \"theta\"; type = \"velocity\"; velocity = -900; },\n"
              "{ disk = 45; coordinate = \"y\"; type = \"random\"; amplitude = 0.005; omega = 200; "
              "interval = 5; },\n"
              "{ disk = [46, 47]; coordinate = \"theta\"; type = \"harmonic\"; amplitude = 5; "
              "omega = 300; } );\n"
              "phases = ( { steps = 1000; }, { steps = 100000; measure = true; } ); measure = { "
              "rotation = (0, 3, "
              "7); sliding = ( { disk = 7; partners = (0, 8); } ); };\n");
}

/* A shaken packing on a polyline that moves and turns, a drum around it, contacts that open and close. */
static void packing(text *t) {
  text_add(t, "dt = 2e-5; gravity = { g = 9.81; };\n" MATERIAL
              "disk_rows = ( { columns = (\"x\", \"y\", \"radius\"); density = 3.57; material = "
              "\"a\"; rows = (");
  add_lattice(t, 53, 9, -0.17, 0.03, 0.042, 0.02, 5);
  text_add(
      t, "); } );\nwalls = ( { name = \"cup\"; type = \"polyline\"; material = \"b\"; pivot = (0, "
         "0.1); "
         "points = ((-0.3, 0.3), (-0.2, 0), (0, -0.003), (0.2, 0), (0.3, 0.3)); },\n"
         "{ name = \"drum\"; type = \"circle\"; material = \"b\"; center = (0, 0.2); radius = 0.5; "
         "side = "
         "\"inside\"; } );\n"
         "motions = ( { wall = \"cup\"; coordinate = \"y\"; type = \"harmonic\"; amplitude = 4e-4; "
         "frequency = 90; },\n"
         "{ wall = \"cup\"; coordinate = \"theta\"; type = \"harmonic\"; amplitude = 0.4; "
         "frequency = 4; "
         "ramp = 0.02; },\n"
         "{ wall = \"cup\"; coordinate = \"x\"; type = \"random\"; amplitude = 2e-4; frequency = "
         "70; },\n"
         "{ wall = \"drum\"; coordinate = \"theta\"; type = \"velocity\"; velocity = 40; } );\n"
         "phases = ( { steps = 1400; }, { steps = 100000; measure = true; } );\n"
         "measure = { rotation = (0, 11, 30); sliding = ( { disk = 2; partners = [\"cup\", 3]; }, "
         "{ disk = "
         "4; partners = (\"cup\", 13); } ); };\n");
}

/* A disk rolls over the vertices of a polyline that is watched. */
static void hills(text *t) {
  text_add(t, "dt = 1e-5; gravity = { g = 9.81; };\n" MATERIAL
              "disks = ( { name = \"r\"; x = 0; y = 0.0999; vx = 3; radius = 0.1; mass = 1; "
              "material = \"a\"; },\n"
              "{ x = 2; y = 2; radius = 0.1; mass = 1; material = \"a\"; } );\n"
              "walls = ( { name = \"hills\"; type = \"polyline\"; material = \"b\"; points = ((-1, "
              "0), (0.01, 0), "
              "(0.02, 0.0005), (0.03, 0), (0.04, 0), (0.05, 0.001), (1, 0.05)); } );\n"
              "phases = ( { steps = 100000; measure = true; } );\n"
              "measure = { rotation = \"r\"; sliding = ( { disk = \"r\"; partners = (\"hills\", "
              "1); } ); };\n");
}

/* A floor through a box that repeats in x, shaken along itself across the box's edge. */
static void carpet(text *t) {
  text_add(t,
           "dt = 2e-5; gravity = { g = 9.81; }; box = { x = (0, 1); periodic = \"x\"; };\n" MATERIAL
           "disk_rows = ( { columns = (\"x\", \"y\", \"radius\"); density = 3.57; material = "
           "\"a\"; rows = (");
  add_lattice(t, 23, 12, 0.06, 0.0395, 0.08, 0.04, 9);
  text_add(
      t,
      "); } );\nwalls = ( { name = \"floor\"; type = \"line\"; material = \"b\"; pivot = (0.0, 0); "
      "points = ((0, 0), (1, 0)); } );\n"
      "motions = ( { wall = \"floor\"; coordinate = \"x\"; type = \"harmonic\"; amplitude = 3e-3; "
      "frequency = 90; },\n"
      "{ wall = \"floor\"; coordinate = \"x\"; type = \"velocity\"; velocity = 40; } );\n"
      "phases = ( { steps = 100000; measure = true; } );\n");
}

/* Surfaces that run, of walls of every shape, switched on and off; arcs that move and turn, with disks on their ends. */
static void belts(text *t) {
  text_add(t, "dt = 2e-5; gravity = { g = 9.81; };\n" MATERIAL
              "disk_rows = ( { columns = (\"x\", \"y\", \"radius\"); density = 3.57; material = "
              "\"a\"; rows = (");
  add_lattice(t, 53, 9, -0.17, 0.03, 0.042, 0.02, 5);
  text_add(
      t, "); } );\nwalls = ( { name = \"belt\"; type = \"segment\"; material = \"b\"; points = "
         "((-0.3, "
         "-0.01), (-0.05, -0.01)); },\n"
         "{ name = \"bowl\"; type = \"arc\"; material = \"b\"; center = (0.05, 0.19); radius = "
         "0.2; from = "
         "-1.9; to = -1.2; },\n"
         "{ name = \"floor\"; type = \"line\"; material = \"a\"; points = ((-1, -0.07), (1, "
         "-0.07)); },\n"
         "{ name = \"ring\"; type = \"arc\"; material = \"b\"; center = (0.19, -0.035); radius = "
         "0.03; from "
         "= 0; to = \"2 pi\"; },\n"
         "{ name = \"drum\"; type = \"circle\"; material = \"b\"; center = (0, 0.2); radius = 0.5; "
         "side = "
         "\"inside\"; } );\n"
         "motions = ( { name = \"run\"; wall = (\"belt\", \"ring\", \"drum\"); coordinate = "
         "\"surface\"; "
         "type = \"velocity\"; "
         "velocity = 40; ramp = 0.01; },\n"
         "{ name = \"to and fro\"; wall = (\"belt\", \"floor\"); coordinate = \"surface\"; type = "
         "\"harmonic\"; amplitude = "
         "3e-3; frequency = 80; },\n"
         "{ wall = (\"bowl\", \"belt\"); coordinate = \"surface\"; type = \"random\"; amplitude = "
         "2e-4; "
         "frequency = 70; },\n"
         "{ wall = \"bowl\"; coordinate = \"y\"; type = \"harmonic\"; amplitude = 4e-4; frequency "
         "= 90; },\n"
         "{ wall = (\"bowl\", \"ring\"); coordinate = \"theta\"; type = \"harmonic\"; amplitude = "
         "0.6; "
         "frequency = 4; } );\n"
         "phases = ( { steps = 700; motions = [\"run\"]; }, { steps = 500; }, { steps = 300; "
         "motions = [\"to "
         "and fro\"]; }, "
         "{ steps = 100000; measure = true; } );\n"
         "measure = { rotation = (0, 11, 30); };\n");
}

/* Clumps fly, turn, wrap and collide, across both edges; a plate of three disks is driven along x and free along y; then all
 * are braked. */
static void dimers(text *t) {
  uint64_t seed = 5;
  text_add(t, "dt = 5e-5; box = { x = (0, 1); y = (-0.5, 0.5); periodic = \"xy\"; };\n" MATERIAL
              "disk_rows = ( { columns = (\"x\", \"y\", \"radius\"); density = 3; material = "
              "\"a\"; rows = (");
  for (int k = 0; k < 20; k++) {
    const double x = 0.1 + 0.2 * (k % 5), y = -0.49 + 0.21 * (k / 5);
    text_add(t, "%s(%.4f, %.4f, 0.05), (%.4f, %.4f, %.4f)", k ? ", " : "", x, y, x + 0.04,
             y + 0.05 * (k % 3), 0.02 + 0.02 * next_uniform(&seed));
  }
  text_add(
      t,
      "); }, { columns = (\"x\", \"y\"); radius = 0.03; mass = 0.1; group = \"plate\"; material = "
      "\"b\"; rows = "
      "((0.94, 0.43), (0.99, 0.43), (0.04, 0.43)); } );\nclumps = ( ");
  for (int k = 0; k < 20; k++)
    text_add(t, "{ disk = (%d, %d); force = (%d, 0); velocity = (%.4f, %.4f); omega = %.4f; },\n",
             2 * k, 2 * k + 1, k < 2 ? 2 - 4 * k : 0, 2 * next_uniform(&seed) - 1,
             2 * next_uniform(&seed) - 1, k == 3 ? 0.0 : 200 * next_uniform(&seed) - 100);
  text_add(
      t,
      "{ name = \"plate\"; group = \"plate\"; mass = 2; locked = \"theta\"; force = (0, -5); } );\n"
      "motions = ( { clump = \"plate\"; coordinate = \"x\"; type = \"velocity\"; velocity = 4; },\n"
      "{ clump = 3; coordinate = \"theta\"; type = \"harmonic\"; amplitude = 5; omega = 300; } );\n"
      "phases = ( { steps = 1000; }, { steps = 1200; measure = true; }, { steps = 100000; relax = "
      "true; } ); "
      "measure = { rotation = (0, 3, 7); disks = true; };\n");
}

/* Walls across the edges of a box, which move, turn, and meet their own images: disks touch their images. */
static void images(text *t) {
  text_add(
      t,
      "dt = 2e-5; box = { x = (0, 1); y = (0, 1); periodic = \"xy\"; };\n" MATERIAL
      "walls = ( { name = \"bar\"; type = \"segment\"; material = \"b\"; points = ((0.9, 0.5), "
      "(1.3, "
      "0.55)); },\n"
      "{ name = \"post\"; type = \"line\"; material = \"b\"; points = ((0.01, 0), (0.01, 1)); },\n"
      "{ name = \"saw\"; type = \"polyline\"; material = \"b\"; points = ((0.2, 0), (0.7, 0.03), "
      "(1.2, 0)); },\n"
      "{ name = \"bowl\"; type = \"arc\"; material = \"b\"; center = (0.5, 1.02); radius = 0.1; "
      "from "
      "= 3.3; to = 6.1; } );\n"
      "disk_rows = ( { columns = (\"x\", \"y\", \"radius\", \"vx\", \"vy\"); density = 3.57; "
      "material = \"a\"; rows = (");
  uint64_t seed = 5;
  for (int k = 0; k < 35; k++)
    text_add(t, "%s(%.4f, %.4f, 0.035, %.3f, %.3f)", k ? ", " : "", 0.1 + 0.13 * (k % 7),
             0.12 + 0.16 * (k / 7), 4 * next_uniform(&seed) - 2, 4 * next_uniform(&seed) - 2);
  text_add(
      t,
      "); } );\nmotions = ( { wall = (\"bar\", \"bowl\"); coordinate = \"theta\"; type = "
      "\"harmonic\"; amplitude = 1; "
      "frequency = 8; },\n"
      "{ wall = (\"post\", \"bar\"); coordinate = \"x\"; type = \"velocity\"; velocity = -2; } );\n"
      "phases = ( { steps = 100000; measure = true; } ); max_overlap = 1;\n");
}

static void (*const decks[DECKS])(text *t) = {supports, gas,   packing, hills,
                                              carpet,   belts, dimers,  images};
static const char *const deck_names[DECKS] = {"supports", "gas",   "packing", "hills",
                                              "carpet",   "belts", "dimers",  "images"};

static sd_model *deck(int d, int integrator, const char *more) {
  text t = {0};
  text_add(&t, "integrator = \"%s\"; seed = 31; %s\n", integrator ? "verlet" : "gear5", more);
  decks[d](&t);
  sd_model *model = model_of(t.s);
  free(t.s);
  return model;
}

/* --- stopped and resumed ------------------------------------------------------------------------------ */

static void resumed_runs_are_the_same(void **unused) {
  (void)unused;
  /* batches of motions end at multiples of 64 of what was done at once, phases at 500, 1277, 1577, 1578 ... */
  const int64_t stops[] = {1,    2,    63,   64,   65,   127,  128,  499,  500,
                           501,  1000, 1276, 1277, 1278, 1399, 1400, 1401, 1576,
                           1577, 1578, 1579, 2000, 2477, 2478, 2479};
  enum { STOPS = sizeof stops / sizeof *stops };
  for (int c = 0; c < 2 * DECKS; c++) {
    sd_model *model = deck(c / 2, c % 2, "");
    sd_state *end = NULL;
    for (int n = -1; n < STOPS; n++) {
      sd_simulation *sim = begin_run(model, 1);
      if (n >= 0) {
        advance(sim, stops[n]);
        sim = go_on_from_copy(sim, 1);
      }
      advance(sim, MOST - engine_of(sim)->state->step);
      const sd_state *s = sd_simulation_state(sim);
      char what[96];
      snprintf(what, sizeof what, "%s, integrator %d, resumed at %lld", deck_names[c / 2], c % 2,
               n < 0 ? 0LL : (long long)stops[n]);
      if (n < 0)
        end = copy_of(model, s);
      else
        same_states(end, s, what);
      sd_simulation_free(sim);
    }
    sd_state_free(end);
    sd_model_free(model);
  }
}

/* After every single step. */
static void resuming_at_every_step_changes_nothing(void **unused) {
  (void)unused;
  for (int c = 0; c < 2 * DECKS; c++) {
    sd_model *model = deck(c / 2, c % 2, "");
    sd_simulation *a = begin_run(model, 1), *b = begin_run(model, 1);
    for (int k = 0; k < 1700; k++) {
      advance(a, 1);
      advance(b, 1);
      b = go_on_from_copy(b, 1);
      if (k % 50 == 0 || k > 1680)
        same_states(sd_simulation_state(a), sd_simulation_state(b), deck_names[c / 2]);
    }
    sd_simulation_free(a);
    sd_simulation_free(b);
    sd_model_free(model);
  }
}

/* --- disturbed ---------------------------------------------------------------------------------------- */

enum { REBUILD = 1, LOOK = 2, PIECES = 4 };

static void disturb(sd_simulation *sim, int how, uint64_t *seed) {
  if (how & REBUILD) assert_int_equal(sd_simulation_rebuild(sim, NULL), SD_OK);
  if (how & LOOK) {
    assert_non_null(sd_simulation_state(sim));
    assert_true(isfinite(sd_simulation_energy(sim).residual));
    assert_true(isfinite(sd_simulation_angle(sim, (uint32_t)(next_bits(seed) % 2))));
  }
}

static void disturbances_change_nothing(void **unused) {
  (void)unused;
  const char *skins[] = {"", "skin = 1e-3;", "skin = 2e-2;"};
  for (int c = 0; c < 2 * DECKS; c++) {
    sd_state *end = NULL;
    sd_model *model = deck(c / 2, c % 2, "");
    for (int how = 0; how < 10; how++) {
      uint64_t seed = (uint64_t)how;
      sd_model *own = how > 7 ? deck(c / 2, c % 2, skins[how - 7]) : NULL;
      sd_simulation *sim = begin_run(own ? own : model, 1);
      int64_t left = MOST;
      while (how > 0 && how < 8 && left > 0) {
        int64_t now = how & PIECES ? 1 + (int64_t)(next_bits(&seed) % 30) : 100;
        if (now > left) now = left;
        advance(sim, now);
        left -= now;
        disturb(sim, how, &seed);
      }
      if (left > 0) advance(sim, left);
      char what[96];
      snprintf(what, sizeof what, "%s, integrator %d, disturbance %d", deck_names[c / 2], c % 2,
               how);
      const sd_state *s = sd_simulation_state(sim);
      if (how == 0)
        end = copy_of(model, s);
      else
        same_states(end, s, what);
      sd_simulation_free(sim);
      sd_model_free(own);
    }
    sd_model_free(model);
    sd_state_free(end);
  }
}

/* --- the decks do what they are there for ---------------------------------------------------------------- */

static void the_decks_are_lively(void **unused) {
  (void)unused;
  for (int d = 0; d < DECKS; d++) {
    sd_model *model = deck(d, 0, "");
    sd_simulation *sim = begin_run(model, 1);
    advance(sim, MOST);
    const sd_state *s = sd_simulation_state(sim);
    sd_energy e = sd_simulation_energy(sim);
    int32_t images = 0;
    for (size_t i = 0; i < s->n_bodies; i++) images += abs(s->image_x[i]) + abs(s->image_y[i]);
    print_message("  %s: %zu contacts, %d images, friction %.2g, opening %.2g, residual/scale "
                  "%.1g, %lld builds\n",
                  deck_names[d], s->n_contacts, images, e.friction, e.opening, e.residual / e.scale,
                  (long long)engine_of(sim)->work.builds);
    assert_true(s->n_contacts > 0);
    assert_true(e.friction > 0);
    if (d == 1) assert_true(images > 5);
    if (d == 4) assert_true(images > 0);
    sd_simulation_free(sim);
    sd_model_free(model);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(the_decks_are_lively),
      cmocka_unit_test(resumed_runs_are_the_same),
      cmocka_unit_test(resuming_at_every_step_changes_nothing),
      cmocka_unit_test(disturbances_change_nothing),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
